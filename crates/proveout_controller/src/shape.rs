//! Exact path of one block and the quintic pieces that round corners, in task coordinates (see `rtcp.rs`).

mod bezier;

use proveout_geom::Vector;
use proveout_machine::{JointValues, MAX_JOINTS};

use crate::{
    jet::{Jet, JointJet, VectorJet},
    profile::{Cursor, Law},
};

pub(crate) use self::bezier::Bezier;

/// Path of a block over its parameter u in 0..=length.
#[derive(Clone, Debug)]
pub(crate) enum BlockShape {
    /// All task coordinates in proportion to u.
    Line { from: JointValues, slope: JointValues },
    /// The three coordinates `slots` on a circle or helix, the others in proportion to u.
    Arc(Box<Arc>),
    /// Pieces that join with equal value, first and second derivative; begins of the pieces grow.
    Spline(Vec<Quintic>),
    /// The three coordinates of a cubic Bezier curve by its length, the others in proportion to u.
    Bezier(Box<Bezier>),
    /// Every joint by its own law; the parameter is the time in seconds.
    Timed(Box<DogLeg>),
}

/// Joints that move at once and independently (dog-leg rapid motion).
#[derive(Clone, Debug)]
pub(crate) struct DogLeg {
    pub(crate) from: JointValues,
    /// Joint, direction and law of its distance for each joint that moves.
    pub(crate) joints: Vec<(usize, f64, Law)>,
    /// Joints whose motion counts as way, with their factor: the linear ones, or degrees of the rotary ones
    /// where no other moves.
    pub(crate) counted: Vec<(usize, f64)>,
}

/// Circle, helix, or spiral where the radii at start and end differ by rounding of the program.
#[derive(Clone, Debug)]
pub(crate) struct Arc {
    pub(crate) slots: [usize; 3],
    pub(crate) center: Vector,
    /// Unit vector from the center to the start.
    pub(crate) u: Vector,
    /// Unit vector in the sense of travel at the start.
    pub(crate) v: Vector,
    /// Advance along the normal per parameter.
    pub(crate) rise: Vector,
    pub(crate) radius: f64,
    pub(crate) radius_slope: f64,
    /// Angle per parameter.
    pub(crate) omega: f64,
    pub(crate) from: JointValues,
    pub(crate) slope: JointValues,
}

/// Polynomial of fifth degree in Bezier form over u0..=u1.
#[derive(Clone, Debug)]
pub(crate) struct Quintic {
    pub(crate) u0: f64,
    pub(crate) u1: f64,
    control: [JointValues; 6],
}

/// Bounds of the absolute derivatives of each coordinate over a range of the parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DerivativeBounds {
    /// Upper bound of |x'|.
    pub(crate) first: JointValues,
    /// Lower bound of |x'|.
    pub(crate) first_low: JointValues,
    /// Upper bound of |x''|.
    pub(crate) second: JointValues,
    /// Upper bound of |x'''|.
    pub(crate) third: JointValues,
}

impl BlockShape {
    /// Taylor coefficients at u.
    pub(crate) fn jet(&self, u: f64) -> JointJet {
        match self {
            Self::Line { from, slope } => JointJet([*from + *slope * u, *slope, JointValues::ZERO, JointValues::ZERO]),
            Self::Arc(arc) => arc.jet(u),
            Self::Spline(pieces) => {
                let i = pieces.partition_point(|p| p.u1 <= u).min(pieces.len() - 1);
                pieces[i].jet(u)
            }
            Self::Bezier(curve) => curve.jet(u),
            Self::Timed(timed) => timed.jet(u),
        }
    }

    /// Way between two parameters: the parameter itself, or that of independent joints, whose parameter is
    /// the time.
    pub(crate) fn way(&self, [from, to]: [f64; 2]) -> f64 {
        match self {
            Self::Timed(timed) => timed.way([from, to]),
            _ => to - from,
        }
    }

    /// The line between the ends of a spline of this length, and how far the spline leaves it at equal
    /// parameter, at most.
    pub(crate) fn chord(&self, length: f64) -> Option<(Self, JointValues)> {
        let Self::Spline(pieces) = self else { return None };
        let (first, last) = (pieces.first()?, pieces.last()?);
        let from = first.control[0];
        let slope = (last.control[5] - from) * (1.0 / length);
        // The line has control points on itself, at equal parts of each piece; the spline lies in the hull of
        // its own.
        let mut off = JointValues::ZERO;
        for p in pieces {
            for (k, control) in p.control.iter().enumerate() {
                let u = p.u0 + (p.u1 - p.u0) * k as f64 / 5.0;
                off = off.zip_map(*control - (from + slope * u), |m, d| m.max(d.abs()));
            }
        }
        Some((Self::Line { from, slope }, off))
    }

    /// Knots of a spline between two places and the middles between them: what is narrow in it shows there.
    /// None of other shapes, which are the program's own.
    pub(crate) fn knots(&self, u0: f64, u1: f64) -> impl Iterator<Item = f64> {
        let pieces: &[Quintic] = if let Self::Spline(pieces) = self { pieces } else { &[] };
        let places = pieces.iter().flat_map(|p| [p.u0, 0.5 * (p.u0 + p.u1)]);
        places.filter(move |u| *u > u0 && *u < u1)
    }

    /// True when all derivatives of the coordinates above the first vanish.
    pub(crate) fn is_line(&self) -> bool {
        matches!(self, Self::Line { .. })
    }
}

impl DogLeg {
    /// Way between two times: chords of a thousandth of the motion, which are short of it by 1e-7 of the way
    /// where all joints speed up.
    fn way(&self, [from, to]: [f64; 2]) -> f64 {
        const CHORDS: f64 = 1000.0;
        let longest = self.joints.iter().map(|(_, _, law)| law.duration).fold(0.0, f64::max);
        let n = (CHORDS * (to - from) / longest.max(f64::MIN_POSITIVE)).ceil().clamp(1.0, CHORDS);
        let at = |k: f64| self.jet(from + (to - from) * k / n).0[0];
        let mut before = at(0.0);
        let mut sum = 0.0;
        for k in 1..=n as usize {
            let now = at(k as f64);
            sum += self.counted.iter().map(|(i, per)| ((now[*i] - before[*i]) * per).powi(2)).sum::<f64>().sqrt();
            before = now;
        }
        sum
    }

    fn jet(&self, time: f64) -> JointJet {
        let mut out = JointJet::constant(self.from);
        for (joint, sign, law) in &self.joints {
            let p = if time >= law.duration { law.end() } else { law.at(time, &mut Cursor::default()) };
            let s = if p.v == 0.0 && time >= law.duration { law.end().s } else { p.s };
            let jet = Jet([self.from[*joint] + sign * s, sign * p.v, sign * p.a / 2.0, sign * p.j / 6.0]);
            out.set(*joint, &jet);
        }
        out
    }
}

impl Arc {
    fn jet(&self, u: f64) -> JointJet {
        let mut out = JointJet([self.from + self.slope * u, self.slope, JointValues::ZERO, JointValues::ZERO]);
        let (s, c) = Jet([self.omega * u, self.omega, 0.0, 0.0]).sin_cos();
        let r = Jet([self.radius + self.radius_slope * u, self.radius_slope, 0.0, 0.0]);
        let mut p =
            VectorJet::constant(self.u).times(&c.times(&r)).plus(&VectorJet::constant(self.v).times(&s.times(&r)));
        p.0[0] += self.center + self.rise * u;
        p.0[1] += self.rise;
        for (k, &slot) in self.slots.iter().enumerate() {
            out.set(slot, &Jet(std::array::from_fn(|m| p.0[m][k])));
        }
        out
    }

    /// Bounds over u0..=u1 of the coordinates themselves (no tool center point control).
    pub(crate) fn bounds(&self, u0: f64, u1: f64) -> DerivativeBounds {
        let abs = self.slope.map(f64::abs);
        let mut b =
            DerivativeBounds { first: abs, first_low: abs, second: JointValues::ZERO, third: JointValues::ZERO };
        let r = (self.radius + self.radius_slope * u0).max(self.radius + self.radius_slope * u1);
        let dr = self.radius_slope.abs();
        let w = self.omega.abs();
        for (k, &slot) in self.slots.iter().enumerate() {
            let amplitude = self.u[k].hypot(self.v[k]);
            // x = amplitude r cos(omega u - phase)
            let phase = self.v[k].atan2(self.u[k]);
            let range = [self.omega * u0 - phase, self.omega * u1 - phase];
            let (cos_high, _) = abs_cos_range(range);
            let (sin_high, sin_low) = abs_cos_range(range.map(|a| a - std::f64::consts::FRAC_PI_2));
            let rise = self.rise[k];
            b.first[slot] = amplitude * (r * w * sin_high + dr) + rise.abs();
            b.first_low[slot] = (amplitude * (r * w * sin_low - dr * (1.0 + w * (u1 - u0))) - rise.abs()).max(0.0);
            b.second[slot] = amplitude * w * (r * w * cos_high + 2.0 * dr);
            b.third[slot] = amplitude * w * w * (r * w * sin_high + 3.0 * dr);
        }
        b
    }
}

/// Highest and lowest |cos| over an interval.
fn abs_cos_range([a, b]: [f64; 2]) -> (f64, f64) {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (a, b) = if a <= b { (a, b) } else { (b, a) };
    let (ca, cb) = (a.cos().abs(), b.cos().abs());
    let has = |offset: f64| ((a - offset) / PI).ceil() * PI + offset <= b;
    (if has(0.0) { 1.0 } else { ca.max(cb) }, if has(FRAC_PI_2) { 0.0 } else { ca.min(cb) })
}

impl Quintic {
    /// The piece with given Taylor coefficients (up to the second) at both ends.
    pub(crate) fn hermite(u0: f64, u1: f64, a: &JointJet, b: &JointJet) -> Self {
        let h = u1 - u0;
        let p1 = a.0[0] + a.0[1] * (h / 5.0);
        let p2 = p1 * 2.0 - a.0[0] + a.0[2] * (h * h / 10.0);
        let p4 = b.0[0] - b.0[1] * (h / 5.0);
        let p3 = p4 * 2.0 - b.0[0] + b.0[2] * (h * h / 10.0);
        Self { u0, u1, control: [a.0[0], p1, p2, p3, p4, b.0[0]] }
    }

    pub(crate) fn jet(&self, u: f64) -> JointJet {
        let h = self.u1 - self.u0;
        let t = (u - self.u0) / h;
        let r = 1.0 - t;
        // The triangle of de Casteljau; its last columns give value and derivatives (Farin 2002, section
        // 5.3).
        let mut out = JointJet::constant(JointValues::ZERO);
        let scale = [1.0, 5.0 / h, 10.0 / (h * h), 10.0 / (h * h * h)];
        let mut p = self.control;
        // All coordinates side by side.
        let mut step = |n: usize| {
            for k in 0..n {
                let next = p[k + 1];
                for (own, next) in p[k].0.iter_mut().zip(next.0) {
                    *own = *own * r + next * t;
                }
            }
            p
        };
        step(5);
        let cubic = step(4); // four points left: third differences
        let quadratic = step(3); // three points left: second differences
        let linear = step(2);
        let [point, ..] = step(1);
        for i in 0..MAX_JOINTS {
            out.0[0][i] = point[i];
            out.0[1][i] = (linear[1][i] - linear[0][i]) * scale[1];
            out.0[2][i] = (quadratic[2][i] - 2.0 * quadratic[1][i] + quadratic[0][i]) * scale[2];
            out.0[3][i] = (cubic[3][i] - 3.0 * cubic[2][i] + 3.0 * cubic[1][i] - cubic[0][i]) * scale[3];
        }
        out
    }

    /// Bounds of the derivatives over the whole piece, by the convex hull of their control points.
    pub(crate) fn bounds(&self) -> DerivativeBounds {
        let h = self.u1 - self.u0;
        let mut level = self.control;
        let mut high = [JointValues::ZERO; 4];
        let mut low = JointValues::ZERO;
        let mut factor = 1.0;
        for (k, bound) in high.iter_mut().enumerate() {
            let n = 5 - k;
            if k == 1 {
                low = JointValues(std::array::from_fn(|i| {
                    let same = level[..=n].iter().all(|p| p[i] > 0.0) || level[..=n].iter().all(|p| p[i] < 0.0);
                    if same { level[..=n].iter().fold(f64::INFINITY, |m, p| m.min(p[i].abs())) * factor } else { 0.0 }
                }));
            }
            for p in &level[..=n] {
                *bound = bound.zip_map(*p, |m, v| m.max(v.abs() * factor));
            }
            for i in 0..n {
                level[i] = level[i + 1] - level[i];
            }
            factor *= n as f64 / h;
        }
        DerivativeBounds { first: high[1], first_low: low, second: high[2], third: high[3] }
    }

    /// Control points of the first derivative: it lies in their hull.
    pub(crate) fn slopes(&self) -> [JointValues; 5] {
        let per = 5.0 / (self.u1 - self.u0);
        std::array::from_fn(|k| (self.control[k + 1] - self.control[k]) * per)
    }

    /// The part from a to b (de Casteljau: first the part after a, then the part before b).
    pub(crate) fn between(&self, a: f64, b: f64) -> Self {
        let behind = self.cut(a)[1].clone();
        let [before, _] = behind.cut(b);
        before
    }

    fn cut(&self, u: f64) -> [Self; 2] {
        let t = ((u - self.u0) / (self.u1 - self.u0)).clamp(0.0, 1.0);
        self.split(u, |a, b| a * (1.0 - t) + b * t)
    }

    /// The parts before and after u; `between` gives a place between two control points.
    fn split(&self, u: f64, between: impl Fn(JointValues, JointValues) -> JointValues) -> [Self; 2] {
        let mut level = self.control;
        let mut left = level;
        let mut right = level;
        for k in 0..6 {
            left[k] = level[0];
            right[5 - k] = level[5 - k];
            for i in 0..5 - k {
                level[i] = between(level[i], level[i + 1]);
            }
        }
        [Self { u0: self.u0, u1: u, control: left }, Self { u0: u, u1: self.u1, control: right }]
    }

    /// The same piece further on.
    pub(crate) fn moved(self, by: f64) -> Self {
        Self { u0: self.u0 + by, u1: self.u1 + by, ..self }
    }

    /// The two parts before and after t = 1/2 (de Casteljau).
    pub(crate) fn halves(&self) -> [Self; 2] {
        self.split(0.5 * (self.u0 + self.u1), |a, b| (a + b) * 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(a: f64, b: f64) -> JointValues {
        JointValues([a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    #[test]
    fn hermite_pieces_meet_their_ends_and_bounds_hold() {
        let a = JointJet([values(1.0, 0.0), values(1.0, 0.2), values(0.3, -0.1), JointValues::ZERO]);
        let b = JointJet([values(2.0, 1.5), values(-0.4, 1.0), values(0.0, 0.7), JointValues::ZERO]);
        let q = Quintic::hermite(2.0, 4.5, &a, &b);
        for (u, end) in [(2.0, &a), (4.5, &b)] {
            let jet = q.jet(u);
            for k in 0..3 {
                assert!((jet.0[k] - end.0[k]).max_abs() < 1e-13);
            }
        }
        let bounds = q.bounds();
        let h = 1e-4;
        for i in 1..250 {
            let u = 2.0 + 0.01 * f64::from(i);
            let jet = q.jet(u);
            // Central difference, error h^2/6 times the fourth derivative.
            let slope = (q.jet(u + h).0[0] - q.jet(u - h).0[0]) * (0.5 / h);
            assert!((slope - jet.first()).max_abs() < 1e-6);
            for j in 0..2 {
                assert!(jet.first()[j].abs() <= bounds.first[j] + 1e-12);
                assert!(jet.first()[j].abs() >= bounds.first_low[j] - 1e-12);
                assert!(jet.second()[j].abs() <= bounds.second[j] + 1e-12);
                assert!(jet.third()[j].abs() <= bounds.third[j] + 1e-12);
            }
        }
        let [left, right] = q.halves();
        assert!((left.jet(2.7).0[0] - q.jet(2.7).0[0]).max_abs() < 1e-13);
        assert!((right.jet(4.0).0[3] - q.jet(4.0).0[3]).max_abs() < 1e-11);
    }

    #[test]
    fn arc_bounds_hold() {
        let arc = Arc {
            slots: [0, 1, 2],
            center: Vector::new(1.0, 2.0, 3.0),
            u: Vector::x(),
            v: Vector::new(0.0, 0.8, 0.6),
            rise: Vector::new(0.0, -0.06, 0.08),
            radius: 5.0,
            radius_slope: 1e-5,
            omega: 0.2,
            from: JointValues::ZERO,
            slope: JointValues::ZERO,
        };
        for k in 0..40 {
            let (u0, u1) = (f64::from(k), f64::from(k) + 1.3);
            let b = arc.bounds(u0, u1);
            for i in 0..=20 {
                let jet = arc.jet(u0 + (u1 - u0) * f64::from(i) / 20.0);
                for j in 0..3 {
                    assert!(jet.first()[j].abs() <= b.first[j] + 1e-12);
                    assert!(jet.first()[j].abs() >= b.first_low[j] - 1e-12, "{j}");
                    assert!(jet.second()[j].abs() <= b.second[j] + 1e-12);
                    assert!(jet.third()[j].abs() <= b.third[j] + 1e-12);
                }
            }
        }
    }
}
