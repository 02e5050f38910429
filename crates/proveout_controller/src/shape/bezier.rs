//! Cubic Bezier curve by its own length.
//!
//! The curve is given over t in 0..=1, the control runs over its length s. With w = |r'(t)|^2
//!
//! ```text
//!   dt/ds = w^(-1/2)     d2t/ds2 = -w'/(2 w^2)     d3t/ds3 = w^(-1/2) (w'^2/w^3 - w''/(2 w^2))
//! ```
//!
//! and the chain rule gives the derivatives by s exactly. Only t(s) itself is numerical: the length up to t
//! is summed by Gauss' rule with five points over 64 parts, and the part's length is inverted by Newton steps
//! with bisection as net.

use proveout_geom::Vector;
use proveout_machine::JointValues;

use crate::jet::JointJet;

/// Parts of the table of lengths. Gauss' rule of degree nine over 1/64 of a cubic without cusp is exact to
/// rounding.
const PARTS: usize = 64;
/// Lowest speed |r'| over the mean one: below it the curve has a cusp, where no control keeps its feed.
const CUSP: f64 = 1e-4;
/// Places this near to an end of a part are that end, part of the curve.
const AT_BORDER: f64 = 1e-9;
/// Step of the parameter at which the search for a length ends.
const FOUND: f64 = 1e-16;
/// Points and weights of Gauss' rule over -1..=1, the negative half by symmetry (Abramowitz and Stegun 1964,
/// table 25.4).
const GAUSS: [(f64, f64); 3] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// The three coordinates `slots` on a cubic Bezier curve, the others in proportion to its length.
#[derive(Clone, Debug)]
pub(crate) struct Bezier {
    slots: [usize; 3],
    control: [Vector; 4],
    /// Length up to t = k/64.
    lengths: Vec<f64>,
    from: JointValues,
    slope: JointValues,
}

impl Bezier {
    /// The curve through these control points with the other coordinates from `from` to `to`. The parameter t
    /// of the cusp where the curve has one.
    pub(crate) fn new(
        slots: [usize; 3],
        control: [Vector; 4],
        from: JointValues,
        to: JointValues,
    ) -> Result<Self, f64> {
        let mut curve = Self { slots, control, lengths: Vec::with_capacity(PARTS + 1), from, slope: JointValues::ZERO };
        let mut sum = 0.0;
        curve.lengths.push(sum);
        for k in 0..PARTS {
            sum += curve.length_between(part(k), part(k + 1));
            curve.lengths.push(sum);
        }
        // The lowest speed: w is of fourth degree in t, so that a fine grid and a search around its lowest
        // point find it.
        const GRID: usize = 16 * PARTS;
        let at = |i: usize| i as f64 / GRID as f64;
        let speed = |t: f64| curve.derivatives(t)[1].norm();
        let lowest = (0..=GRID).min_by(|a, b| speed(at(*a)).total_cmp(&speed(at(*b)))).unwrap_or(0);
        let (mut low, mut high) = (at(lowest.saturating_sub(1)), at((lowest + 1).min(GRID)));
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if speed(a) < speed(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let slowest = 0.5 * (low + high);
        if sum.is_nan() || speed(slowest) < CUSP * sum {
            return Err(slowest);
        }
        curve.slope = (to - from) * (1.0 / sum);
        for slot in slots {
            curve.slope[slot] = 0.0;
            curve.from[slot] = 0.0;
        }
        Ok(curve)
    }

    pub(crate) fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Places over the length between u0 and u1 (both included), denser where the curve turns.
    pub(crate) fn places(&self, u0: f64, u1: f64) -> Vec<f64> {
        let mut places = vec![u0];
        let gap = AT_BORDER * self.length();
        places.extend(self.lengths.iter().copied().filter(|u| *u > u0 + gap && *u < u1 - gap));
        places.push(u1);
        places
    }

    /// Slope of the coordinates that run in proportion to the length.
    pub(crate) fn slope(&self) -> &JointValues {
        &self.slope
    }

    pub(crate) fn jet(&self, u: f64) -> JointJet {
        let t = self.parameter_at(u);
        let [p, d1, d2, d3] = self.derivatives(t);
        let (w, w1, w2) = (d1.norm_squared(), 2.0 * d1.dot(&d2), 2.0 * (d2.norm_squared() + d1.dot(&d3)));
        let t1 = 1.0 / w.sqrt();
        let t2 = -0.5 * w1 / (w * w);
        let t3 = t1 * (w1 * w1 / (w * w * w) - 0.5 * w2 / (w * w));
        let first = d1 * t1;
        let second = d2 * (t1 * t1) + d1 * t2;
        let third = d3 * (t1 * t1 * t1) + d2 * (3.0 * t1 * t2) + d1 * t3;
        let mut out = JointJet([self.from + self.slope * u, self.slope, JointValues::ZERO, JointValues::ZERO]);
        for (k, &slot) in self.slots.iter().enumerate() {
            out.0[0][slot] = p[k];
            out.0[1][slot] = first[k];
            out.0[2][slot] = second[k] / 2.0;
            out.0[3][slot] = third[k] / 6.0;
        }
        out
    }

    /// Point and derivatives by t.
    fn derivatives(&self, t: f64) -> [Vector; 4] {
        let [a, b, c, d] = self.control;
        let r = 1.0 - t;
        let (ab, bc, cd) = (b - a, c - b, d - c);
        [
            a * (r * r * r) + b * (3.0 * r * r * t) + c * (3.0 * r * t * t) + d * (t * t * t),
            (ab * (r * r) + bc * (2.0 * r * t) + cd * (t * t)) * 3.0,
            ((bc - ab) * r + (cd - bc) * t) * 6.0,
            (cd - bc * 2.0 + ab) * 6.0,
        ]
    }

    fn length_between(&self, t0: f64, t1: f64) -> f64 {
        let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
        let speed = |t: f64| self.derivatives(t)[1].norm();
        let pair = |x: f64| if x == 0.0 { speed(middle) } else { speed(middle - half * x) + speed(middle + half * x) };
        GAUSS.iter().map(|(x, w)| w * pair(*x)).sum::<f64>() * half
    }

    fn parameter_at(&self, u: f64) -> f64 {
        let k = self.lengths.partition_point(|l| *l <= u).clamp(1, PARTS) - 1;
        let (t0, mut low, mut high) = (part(k), part(k), part(k + 1));
        let goal = (u - self.lengths[k]).max(0.0);
        let whole = self.lengths[k + 1] - self.lengths[k];
        if goal >= whole {
            return high;
        }
        let mut t = low + (high - low) * goal / whole;
        for _ in 0..50 {
            let off = self.length_between(t0, t) - goal;
            if off > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let mut next = t - off / self.derivatives(t)[1].norm();
            if !(next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            if (next - t).abs() <= FOUND {
                return next;
            }
            t = next;
        }
        t
    }
}

fn part(k: usize) -> f64 {
    k as f64 / PARTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Bezier {
        let control = [[0.0, 0.0, 0.0], [10.0, 2.0, 1.0], [4.0, 15.0, -3.0], [20.0, 18.0, 5.0]].map(Vector::from);
        let mut to = JointValues::ZERO;
        to[3] = 0.7;
        Bezier::new([0, 1, 2], control, JointValues::ZERO, to).expect("no cusp")
    }

    #[test]
    fn the_parameter_is_the_length_and_derivatives_match_differences() {
        let c = curve();
        let length = c.length();
        // Chords of an independent fine subdivision: error of the sum about (1/n)^2.
        let n = 40_000;
        let point = |i: i32| c.derivatives(f64::from(i) / f64::from(n))[0];
        let sum: f64 = (0..n).map(|i| (point(i + 1) - point(i)).norm()).sum();
        assert!((sum - length).abs() < 1e-7, "{sum} {length}");
        assert!((c.jet(length).0[0][3] - 0.7).abs() < 1e-14);
        let h = 1e-3;
        for i in 1..60 {
            let u = length * f64::from(i) / 60.0;
            let jet = c.jet(u);
            let speed = (0..3).map(|k| jet.first()[k].powi(2)).sum::<f64>().sqrt();
            assert!((speed - 1.0).abs() < 1e-13);
            let [before, after] = [c.jet(u - h), c.jet(u + h)];
            // Central differences of the order below: h^2/6 times a derivative of at most about 1.
            for (low, high) in [
                (after.0[0] - before.0[0], jet.first()),
                (after.first() - before.first(), jet.second()),
                (after.second() - before.second(), jet.third()),
            ] {
                assert!((low * (0.5 / h) - high).max_abs() < 1e-5, "{u}");
            }
        }
    }

    #[test]
    fn a_straight_curve_is_a_line_and_a_cusp_is_reported() {
        let straight = [0.0, 1.0, 5.0, 9.0].map(|x| Vector::new(x, 0.0, 0.0));
        let c = Bezier::new([0, 1, 2], straight, JointValues::ZERO, JointValues::ZERO).expect("no cusp");
        assert!((c.length() - 9.0).abs() < 1e-12);
        assert!((c.jet(4.0).0[0][0] - 4.0).abs() < 1e-12);
        assert!(c.jet(4.0).second().max_abs() < 1e-12);
        let cusp = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0]].map(|[x, y]| Vector::new(x, y, 0.0));
        let t = Bezier::new([0, 1, 2], cusp, JointValues::ZERO, JointValues::ZERO).err();
        assert!(t.is_some_and(|t| (t - 0.5).abs() < 1e-3), "{t:?}");
    }
}
