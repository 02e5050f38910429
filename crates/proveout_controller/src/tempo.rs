//! A stretch of a law that is run faster or slower than it was planned.
//!
//! A *first law* gives the path s = S(p) in its own time p. Run with a tempo dp/dt = sqrt(b), where b is a
//! cubic in p over a stretch, all derivatives of p by the time t of the run follow from b alone:
//!
//! ```text
//!   p. = sqrt(b)        p.. = b'/2        p... = sqrt(b) b''/2        t = integral of dp / sqrt(b)
//! ```
//!
//! The integral has no closed form; Gauss' rule with eight points gives it to rounding, since b changes by
//! less than its own size within a stretch (1/sqrt(b) is analytic up to the zero of b, and the error falls
//! with the sixteenth power of the distance to it). The way back, p(t), is found by Newton's method on the
//! same sum.

/// A stretch of one cubic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tempo {
    /// Begin in the time of the first law, s.
    pub(crate) begin: f64,
    /// Length in the time of the first law, s.
    pub(crate) length: f64,
    /// Square of the tempo as polynomial of the time since `begin`.
    pub(crate) square: [f64; 4],
    /// Begin in the time of the run, s.
    pub(crate) time: f64,
    /// Length in the time of the run, s.
    pub(crate) duration: f64,
}

/// Points and weights of Gauss' rule with eight points over -1..=1, the negative half by symmetry (Abramowitz
/// and Stegun 1964, table 25.4).
pub(crate) const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// How many times slower than its first law a stretch may run. A tempo is there to run faster; where limits
/// were passed by a few percent it falls a little below one, and never near this.
const SLOWEST: f64 = 4.0;

/// Last step of Newton's method as part of the length: its square is rounding.
const CONVERGED: f64 = 1e-8;

const EVEN: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

impl Tempo {
    /// The stretch from `begin` over `length`; its time of the run begins at `time`.
    pub(crate) fn new(begin: f64, length: f64, square: [f64; 4], time: f64) -> Self {
        let mut tempo = Self { begin, length, square, time, duration: 0.0 };
        tempo.duration = tempo.passed(length);
        tempo
    }

    /// The first law as it is.
    pub(crate) fn even(begin: f64, length: f64, time: f64) -> Self {
        Self { begin, length, square: EVEN, time, duration: length }
    }

    /// Whether the square of the tempo is above zero throughout, by its Bernstein coefficients, and the run
    /// takes no more than [`SLOWEST`] times as long as the first law.
    pub(crate) fn is_sound(&self) -> bool {
        let h = self.length;
        let [b0, b1, b2, b3] = [self.square[0], self.square[1] * h, self.square[2] * h * h, self.square[3] * h * h * h];
        let bernstein = [b0, b0 + b1 / 3.0, b0 + (2.0 * b1 + b2) / 3.0, b0 + b1 + b2 + b3];
        bernstein.iter().all(|b| *b > 0.0) && self.duration <= SLOWEST * self.length
    }

    fn square_at(&self, x: f64) -> f64 {
        let [b0, b1, b2, b3] = self.square;
        b0 + x * (b1 + x * (b2 + x * b3))
    }

    /// Time of the first law with three derivatives by the time of the run, `t` after the begin of the
    /// stretch.
    pub(crate) fn at(&self, t: f64) -> [f64; 4] {
        if self.square == EVEN {
            return [self.begin + t.min(self.length), 1.0, 0.0, 0.0];
        }
        let [b0, b1, b2, b3] = self.square;
        // The power series of p(t) about the begin up to the fourth order, where b keeps its size.
        let v = b0.max(0.0).sqrt();
        let begin = t * (v + t * (0.25 * b1 + t * (v * b2 / 6.0 + t * (0.5 * b1 * b2 + 3.0 * b0 * b3) / 24.0)));
        let mut x = begin.clamp(0.0, self.length);
        for _ in 0..8 {
            let step = (t - self.passed(x)) * self.square_at(x).max(0.0).sqrt();
            x = (x + step).clamp(0.0, self.length);
            // The next step is about the square of this one, b'/4b at most one over the length.
            if step.abs() <= CONVERGED * self.length {
                break;
            }
        }
        let v = self.square_at(x).max(0.0).sqrt();
        [self.begin + x, v, 0.5 * (b1 + x * (2.0 * b2 + 3.0 * x * b3)), v * (b2 + 3.0 * x * b3)]
    }

    /// Time of the run since the begin of the stretch at which the time of the first law has grown by `x`.
    pub(crate) fn passed(&self, x: f64) -> f64 {
        let x = x.clamp(0.0, self.length);
        if self.square == EVEN {
            return x;
        }
        let half = 0.5 * x;
        // Eight roots side by side.
        let mut slow = [0.0; 8];
        for (k, (at, _)) in GAUSS.iter().enumerate() {
            (slow[2 * k], slow[2 * k + 1]) = (half - half * at, half + half * at);
        }
        for place in &mut slow {
            *place = 1.0 / self.square_at(*place).max(f64::MIN_POSITIVE).sqrt();
        }
        half * GAUSS.iter().zip(slow.chunks(2)).map(|((_, weight), two)| weight * two.iter().sum::<f64>()).sum::<f64>()
    }

    /// The parts before and after `p`, a time of the first law within the stretch; times of the run
    /// stay.
    pub(crate) fn cut(&self, p: f64) -> [Self; 2] {
        let x = (p - self.begin).clamp(0.0, self.length);
        let t = self.passed(x);
        let [_, b1, b2, b3] = self.square;
        let square = if self.square == EVEN {
            EVEN
        } else {
            [self.square_at(x), b1 + x * (2.0 * b2 + 3.0 * x * b3), b2 + 3.0 * x * b3, b3]
        };
        [
            Self { length: x, duration: t, ..*self },
            Self {
                begin: self.begin + x,
                length: self.length - x,
                square,
                time: self.time + t,
                duration: self.duration - t,
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_places_are_inverse_and_solve_the_equation() {
        let squares =
            [EVEN, [1.0, 3.0, 0.0, 0.0], [1.2, -2.0, 40.0, 200.0], [0.9, 5.0, -30.0, 100.0], [1.0, 0.01, 1e-4, 0.0]];
        for square in squares {
            let tempo = Tempo::new(2.0, 0.1, square, 7.0);
            assert!(tempo.is_sound());
            // The sum of dx/sqrt(b) by the rule of midpoints.
            let n = 20_000;
            let sum: f64 = (0..n)
                .map(|k| 0.1 / f64::from(n) / tempo.square_at(0.1 * (f64::from(k) + 0.5) / f64::from(n)).sqrt())
                .sum();
            assert!((sum - tempo.duration).abs() < 1e-9, "{square:?}: {sum} {}", tempo.duration);
            for k in 0..=20 {
                let x = 0.005 * f64::from(k);
                let t = tempo.passed(x);
                let [p, v, a, j] = tempo.at(t);
                assert!((p - 2.0 - x).abs() < 1e-13, "{square:?}: {p} {x}");
                assert!((v * v - tempo.square_at(x)).abs() < 1e-12);
                if k == 0 || k == 20 {
                    continue;
                }
                // Central differences: error h^2/6 times the next derivative, some thousands.
                let h = 1e-5;
                let (before, after) = (tempo.at(t - h), tempo.at(t + h));
                for (order, value) in [v, a, j].into_iter().enumerate() {
                    let slope = (after[order] - before[order]) / (2.0 * h);
                    assert!((slope - value).abs() < 1e-5 * value.abs().max(1.0), "{square:?} {order}: {slope} {value}");
                }
            }
            let [left, right] = tempo.cut(2.03);
            assert!((left.duration + right.duration - tempo.duration).abs() < 1e-15);
            assert!((right.at(0.02)[0] - tempo.at(0.02 + left.duration)[0]).abs() < 1e-13);
            assert!((right.passed(right.length) - right.duration).abs() < 1e-13);
        }
    }

    #[test]
    fn a_tempo_that_comes_to_rest_is_not_sound() {
        // Zero at the end, below zero in the middle, and nearly at rest all the way.
        for square in
            [[1.0, -10.0, 0.0, 0.0], [1.0, -50.0, 500.0, 0.0], [0.01, 0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0, 0.0]]
        {
            assert!(!Tempo::new(0.0, 0.1, square, 0.0).is_sound(), "{square:?}");
        }
    }
}
