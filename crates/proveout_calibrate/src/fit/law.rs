//! Position over time of a move from rest to rest, by five kinds of interpolator.
//!
//! Every law is a sum of truncated powers, in which a moving average is exact:
//!
//! ```text
//!   p(t) = sum c (t - s)_+^n / n!
//!
//!   steps of velocity      n = 1      a pulse of the speed V over the time L/V
//!   steps of acceleration  n = 2      trapezoid of the velocity, under V and A
//!   steps of jerk          n = 3      seven phases, under V, A and J (Biagiotti and Melchiorri 2008, 3.4)
//!
//!   average over T:  c (t-s)^n/n!  ->  c/T [ (t-s)^(n+1)/(n+1)! - (t-s-T)^(n+1)/(n+1)! ]
//! ```
//!
//! Moving averages are the interpolators of many controls (finite impulse response; Ward, Sencer, Jones,
//! Ozturk 2021). On moves that reach V, one average over T after a trapezoid makes the jerk A/T, and two
//! averages over T1 and T2 after a pulse make A = V/T1 and J = V/(T1 T2): these laws differ on short moves
//! alone.

/// Averages shorter than this (s) change nothing that a trace shows.
const SHORTEST_AVERAGE: f64 = 1e-7;

/// A kind of interpolator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LawKind {
    /// Velocity, acceleration and jerk are bounded.
    JerkLimited,
    /// Velocity and acceleration are bounded.
    Trapezoid,
    /// A trapezoid of the velocity through one moving average.
    SmoothedTrapezoid,
    /// A pulse of the velocity through one moving average.
    OneAverage,
    /// A pulse of the velocity through two moving averages.
    TwoAverages,
}

impl LawKind {
    /// All kinds; of those that fit alike, the first with the fewest parameters is taken.
    pub const ALL: [Self; 5] =
        [Self::JerkLimited, Self::Trapezoid, Self::SmoothedTrapezoid, Self::OneAverage, Self::TwoAverages];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::JerkLimited => "velocity, acceleration and jerk limited",
            Self::Trapezoid => "velocity and acceleration limited",
            Self::SmoothedTrapezoid => "velocity and acceleration limited, then one moving average",
            Self::OneAverage => "one moving average",
            Self::TwoAverages => "two moving averages",
        }
    }

    /// Number of parameters after the velocity.
    pub(crate) fn shape_parameters(self) -> usize {
        match self {
            Self::Trapezoid | Self::OneAverage => 1,
            _ => 2,
        }
    }
}

/// Velocity and shape of a law: after the velocity A and J (mm/s², mm/s³), A and T (s), T1, or T1 and T2,
/// whichever the kind has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawShape {
    /// Kind.
    pub kind: LawKind,
    /// Velocity, mm/s or rad/s.
    pub velocity: f64,
    /// The others; the second is not used by kinds with one.
    pub shape: [f64; 2],
}

impl LawShape {
    /// Acceleration that the law reaches on a long move.
    pub fn acceleration(&self) -> f64 {
        match self.kind {
            LawKind::JerkLimited | LawKind::Trapezoid | LawKind::SmoothedTrapezoid => self.shape[0],
            LawKind::OneAverage | LawKind::TwoAverages => self.velocity / self.shape[0].max(self.shape[1]),
        }
    }

    /// Jerk that the law reaches on a long move; none for steps of acceleration.
    pub fn jerk(&self) -> Option<f64> {
        match self.kind {
            LawKind::JerkLimited => Some(self.shape[1]),
            LawKind::SmoothedTrapezoid => Some(self.shape[0] / self.shape[1]),
            LawKind::TwoAverages => Some(self.velocity / (self.shape[0] * self.shape[1])),
            LawKind::Trapezoid | LawKind::OneAverage => None,
        }
    }

    /// The move over `length` (of either sign).
    pub fn law(&self, length: f64) -> Law {
        let way = length.abs();
        let mut law = Law { terms: Vec::with_capacity(32), duration: 0.0, length };
        if !(way > 0.0 && self.velocity > 0.0) {
            return law;
        }
        let [first, second] = self.shape;
        match self.kind {
            LawKind::JerkLimited => law.ramps(way, self.velocity, first, second),
            LawKind::Trapezoid | LawKind::SmoothedTrapezoid => law.ramps(way, self.velocity, first, f64::INFINITY),
            LawKind::OneAverage | LawKind::TwoAverages => {
                let time = way / self.velocity;
                law.push(0.0, self.velocity, 1);
                law.push(time, -self.velocity, 1);
                law.duration = time;
            }
        }
        match self.kind {
            LawKind::SmoothedTrapezoid => law.average(second),
            LawKind::OneAverage => law.average(first),
            LawKind::TwoAverages => {
                law.average(first);
                law.average(second);
            }
            LawKind::JerkLimited | LawKind::Trapezoid => {}
        }
        if length < 0.0 {
            for term in &mut law.terms {
                term.factor = -term.factor;
            }
        }
        law
    }
}

#[derive(Clone, Copy, Debug)]
struct Term {
    time: f64,
    factor: f64,
    order: u8,
}

/// One move that begins at the time zero and the place zero.
#[derive(Clone, Debug)]
pub struct Law {
    terms: Vec<Term>,
    /// Time that it takes, s.
    pub duration: f64,
    length: f64,
}

impl Law {
    fn push(&mut self, time: f64, factor: f64, order: u8) {
        self.terms.push(Term { time, factor, order });
    }

    /// Ramp, cruise and ramp under the limits; an infinite jerk makes steps of acceleration.
    fn ramps(&mut self, way: f64, velocity: f64, acceleration: f64, jerk: f64) {
        let full = acceleration / jerk;
        // Speed of a move that only just reaches it: v T(v) = way, T the time of a ramp.
        let with_hold = 0.5 * acceleration * ((full * full + 4.0 * way / acceleration).sqrt() - full);
        let reached =
            if with_hold >= acceleration * full { with_hold } else { (0.5 * way).powf(2.0 / 3.0) * jerk.cbrt() };
        let v = velocity.min(reached);
        let (rise, ramp) = if v >= acceleration * full {
            (full, v / acceleration + full)
        } else {
            let rise = (v / jerk).sqrt();
            (rise, 2.0 * rise)
        };
        let cruise = (way / v - ramp).max(0.0);
        let end = 2.0 * ramp + cruise;
        self.duration = end;
        if rise > 0.0 {
            let j = v / ((ramp - rise) * rise);
            for (time, sign) in [
                (0.0, 1.0),
                (rise, -1.0),
                (ramp - rise, -1.0),
                (ramp, 1.0),
                (ramp + cruise, -1.0),
                (ramp + cruise + rise, 1.0),
                (end - rise, 1.0),
                (end, -1.0),
            ] {
                self.push(time, sign * j, 3);
            }
        } else {
            let a = v / ramp;
            for (time, sign) in [(0.0, 1.0), (ramp, -1.0), (ramp + cruise, -1.0), (end, 1.0)] {
                self.push(time, sign * a, 2);
            }
        }
    }

    fn average(&mut self, time: f64) {
        if time < SHORTEST_AVERAGE {
            return;
        }
        let before = std::mem::take(&mut self.terms);
        for t in before {
            self.push(t.time, t.factor / time, t.order + 1);
            self.push(t.time + time, -t.factor / time, t.order + 1);
        }
        self.duration += time;
    }

    /// The derivative of this order at a time: position (0), velocity (1) and so on.
    pub fn derivative(&self, order: u8, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        if time >= self.duration {
            return if order == 0 { self.length } else { 0.0 };
        }
        let mut sum = 0.0;
        for term in &self.terms {
            let dt = time - term.time;
            if dt <= 0.0 || term.order < order {
                continue;
            }
            let n = term.order - order;
            let mut power = 1.0;
            for k in 1..=n {
                power *= dt / f64::from(k);
            }
            sum += term.factor * power;
        }
        sum
    }

    /// Position at a time.
    pub fn position(&self, time: f64) -> f64 {
        self.derivative(0, time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> Vec<LawShape> {
        let of = |kind, velocity, shape| LawShape { kind, velocity, shape };
        vec![
            of(LawKind::JerkLimited, 400.0, [3000.0, 60_000.0]),
            of(LawKind::Trapezoid, 400.0, [3000.0, 0.0]),
            of(LawKind::SmoothedTrapezoid, 400.0, [3000.0, 0.04]),
            of(LawKind::OneAverage, 400.0, [0.13, 0.0]),
            of(LawKind::TwoAverages, 400.0, [0.07, 0.01]),
        ]
    }

    /// The averages of this file against sums over a fine grid, which share no formula with them.
    #[test]
    fn an_average_is_the_mean_of_what_it_averages() {
        for (smooth, base, times) in [
            (shapes()[2], shapes()[1], vec![0.04]),
            (shapes()[4], LawShape { kind: LawKind::OneAverage, ..shapes()[4] }, vec![0.01]),
        ] {
            for length in [0.5, 7.0, -60.0, 200.0] {
                let (law, plain) = (smooth.law(length), base.law(length));
                for k in 0..60 {
                    let t = law.duration * f64::from(k) / 50.0;
                    let n = 4000;
                    let mean =
                        (0..n).map(|i| plain.position(t - times[0] * (f64::from(i) + 0.5) / f64::from(n))).sum::<f64>()
                            / f64::from(n);
                    // The sum has steps of a 4000th of the average, at up to 400 mm/s: its error is of the
                    // second order, below 1e-6 mm.
                    assert!((law.position(t) - mean).abs() < 1e-6, "{smooth:?} {length} {t}");
                }
            }
        }
    }

    #[test]
    fn every_law_ends_at_its_length_and_keeps_its_limits() {
        for shape in shapes() {
            for length in [1e-3, 0.2, 3.0, -25.0, 90.0, 600.0] {
                let law = shape.law(length);
                assert_eq!(law.position(law.duration), length);
                assert_eq!(law.position(0.0), 0.0);
                let near = law.duration * (1.0 - 1e-9);
                assert!((law.position(near) - length).abs() < 1e-6 * length.abs().max(1.0), "{shape:?} {length}");
                for k in 0..=400 {
                    let t = law.duration * f64::from(k) / 400.0;
                    let v = law.derivative(1, t) * length.signum();
                    assert!(v > -1e-6 && v < shape.velocity * (1.0 + 1e-9), "{shape:?} {length} {t}: {v}");
                    assert!(law.derivative(2, t).abs() < shape.acceleration() * (1.0 + 1e-6), "{shape:?} {length} {t}");
                    if let Some(j) = shape.jerk() {
                        // An average that holds both ends of a short pulse changes by both at once.
                        let j = if shape.kind == LawKind::JerkLimited { j } else { 2.0 * j };
                        assert!(law.derivative(3, t).abs() < j * (1.0 + 1e-6), "{shape:?} {length} {t}");
                    }
                }
            }
        }
    }

    /// Long moves take L/V + V/A + A/J; without reaching A, two ramps of 2 sqrt(v/J).
    #[test]
    fn times_are_those_of_the_closed_forms() {
        let s = shapes()[0];
        assert!((s.law(300.0).duration - (300.0 / 400.0 + 400.0 / 3000.0 + 3000.0 / 60_000.0)).abs() < 1e-12);
        // v = (L/2)^(2/3) J^(1/3) = 3.915 mm/s for L = 0.02: four phases of sqrt(v/J).
        let v = 0.01_f64.powf(2.0 / 3.0) * 60_000_f64.cbrt();
        assert!((s.law(0.02).duration - 4.0 * (v / 60_000.0).sqrt()).abs() < 1e-12);
        let averages = shapes()[4];
        assert!((averages.law(100.0).duration - (0.25 + 0.08)).abs() < 1e-12);
        assert!((averages.acceleration() - 400.0 / 0.07).abs() < 1e-9);
        assert_eq!(averages.jerk().map(|j| (j * 7e-4).round()), Some(400.0));
    }

    #[test]
    fn a_move_of_no_length_stays() {
        let law = shapes()[0].law(0.0);
        assert_eq!((law.duration, law.position(1.0)), (0.0, 0.0));
    }
}
