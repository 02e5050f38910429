//! A convex body on a piece of motion, seen from a point at rest: how far the point is from it at each time,
//! and the least of that.
//!
//! Let F be the convex function of the body (`meridian`): zero on the skin, negative inside, its slope at
//! most 1, and inside the depth below the skin. A point x at rest sees `f(t) = F(x in the frame of the tool
//! at t)`. Where the tool runs straight without turning, f is convex in x and t together, so each value with
//! its slopes is a bound from below, for every place and every time:
//!
//! ```text
//!   F(y, s) >= f(t) + g . (y - x) + f'(t) (s - t)
//! ```
//!
//! One such plane that falls in time and one that rises are added so that the time drops out: what is left
//! bounds `least over s of F(y, s)` from below by a plane in y. It is exact at x when both touch the least
//! place.
//!
//! A turn by the angle a bends the way of x in the frame of the tool: its acceleration is at most `|q| a² + 2
//! |way| a`, with q from the tip to x. Half of that is what a plane may lie too high over the whole piece; it
//! is taken off. A piece that bends by more is searched in parts.

use proveout_geom::{Aabb, Point, ToolPose, Vector};

use crate::{SweepMotion, kernels::meridian::Meridian};

/// Steps of the search for the least place.
const STEPS: usize = 24;
/// Bend up to which a piece is searched as one, mm, and the most parts of it.
const BEND: f64 = 1e-3;
const PARTS: f64 = 64.0;
/// The least is known when it is known to this, mm.
const KNOWN: f64 = 1e-7;
/// Angle up to which the axis runs on the chord of its circle, radian.
const CHORD: f64 = 0.02;

/// A motion, made ready.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovingBody {
    motion: SweepMotion,
    way: Vector,
    /// Axis of the turn times its angle, radian.
    turn: Vector,
    angle: f64,
}

/// Value and slopes at a place and a time.
#[derive(Clone, Copy, Debug)]
struct MotionSlope {
    value: f64,
    slope: Vector,
    rate: f64,
}

/// What is known of the least distance from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeastDistance {
    /// A time at which the value asked for is reached.
    pub met: Option<f64>,
    /// Smallest value that was seen, and when.
    pub seen: f64,
    pub at: f64,
    /// No value is below this one, mm.
    pub bound: f64,
    /// Slope of the bound in the place; none where the piece was searched in parts.
    pub slope: Option<Vector>,
}

/// Which part of the function is asked.
#[derive(Clone, Copy, Debug)]
pub(super) enum FunctionPart {
    Whole,
    /// One line or arc of the outline.
    One(usize),
}

impl MovingBody {
    pub(super) fn new(motion: &SweepMotion) -> Self {
        let over = motion.from.axis.cross(&motion.to.axis);
        let sine = over.norm();
        let angle = if sine < 1e-12 { 0.0 } else { sine.atan2(motion.from.axis.dot(&motion.to.axis)) };
        let turn = if angle > 0.0 { over * (angle / sine) } else { Vector::zeros() };
        Self { motion: *motion, way: motion.to.tip - motion.from.tip, turn, angle }
    }

    /// Splits a motion so that one plane bounds each part; `reach` is the largest distance of the body from
    /// its tip, mm.
    pub(super) fn parts(motion: &SweepMotion, reach: f64) -> Vec<SweepMotion> {
        let whole = Self::new(motion);
        let parts = (whole.bend(reach) / BEND).sqrt().ceil().clamp(1.0, PARTS) as u32;
        let at = |k: u32| match k {
            0 => motion.from,
            k if k == parts => motion.to,
            k => motion.from.interpolated(&motion.to, f64::from(k) / f64::from(parts)),
        };
        (0..parts).map(|k| SweepMotion { from: at(k), to: at(k + 1) }).collect()
    }

    /// What a plane of the bound may lie too high over the whole piece, mm, for a point so far from the tip.
    pub(super) fn bend(&self, far: f64) -> f64 {
        0.5 * (far * self.angle * self.angle + 2.0 * self.way.norm() * self.angle)
    }

    /// Box round all that a body takes up.
    pub(super) fn bounds(&self, body: &Meridian) -> Aabb {
        let mut all = Aabb::empty();
        for pose in [&self.motion.from, &self.motion.to] {
            for z in body.z {
                let c = pose.tip + pose.axis * z;
                let half = pose.axis.map(|a| body.radius * (1.0 - a * a).max(0.0).sqrt());
                all.grow(&(c - half));
                all.grow(&(c + half));
            }
        }
        all.expanded(body.reach * self.angle * self.angle / 8.0)
    }

    fn pose(&self, t: f64) -> ToolPose {
        let m = &self.motion;
        if self.angle == 0.0 {
            return ToolPose { tip: m.from.tip + self.way * t, axis: m.from.axis };
        }
        if self.angle < CHORD {
            let axis = m.from.axis + (m.to.axis - m.from.axis) * t;
            return ToolPose { tip: m.from.tip + self.way * t, axis: axis / axis.norm() };
        }
        m.from.interpolated(&m.to, t)
    }

    fn value_and_slope(&self, body: &Meridian, part: FunctionPart, p: &Point, t: f64) -> MotionSlope {
        let ToolPose { tip, axis } = self.pose(t);
        let q = p - tip;
        let z = q.dot(&axis);
        let across = q - axis * z;
        let r = across.norm();
        let (value, nr, nz) = match part {
            FunctionPart::Whole => body.eval(r, z),
            FunctionPart::One(k) => body.pieces[k].eval(r, z),
        };
        let e = if r > 1e-12 { across / r } else { Vector::zeros() };
        let turning = if self.angle > 0.0 { self.turn.cross(&axis) } else { Vector::zeros() };
        let along = q.dot(&turning) - self.way.dot(&axis);
        let aside = -e.dot(&self.way) - z * e.dot(&turning);
        MotionSlope { value, slope: e * nr + axis * nz, rate: nr * aside + nz * along }
    }

    /// Value and slope in the place at one time.
    pub(super) fn at(&self, body: &Meridian, part: FunctionPart, p: &Point, t: f64) -> (f64, Vector) {
        let seen = self.value_and_slope(body, part, p, t);
        (seen.value, seen.slope)
    }

    /// The least value for a point; the search ends as soon as one of at most `wanted` is seen, or none can
    /// be. With a `wanted` of minus infinity the least itself is searched.
    pub(super) fn least(&self, body: &Meridian, part: FunctionPart, p: &Point, wanted: f64) -> LeastDistance {
        let bend = if self.angle == 0.0 {
            0.0
        } else {
            self.bend((p - self.motion.from.tip).norm().max((p - self.motion.to.tip).norm()))
        };
        // Points somewhat beyond the body still have one plane.
        if bend <= 1.5 * BEND {
            return self.least_of_part(body, part, p, wanted, [0.0, 1.0], bend);
        }
        let parts = (bend / BEND).sqrt().ceil().min(PARTS);
        let mut all = LeastDistance { met: None, seen: f64::INFINITY, at: 0.0, bound: f64::INFINITY, slope: None };
        for k in 0..parts as usize {
            let range = [k as f64 / parts, (k + 1) as f64 / parts];
            let one = self.least_of_part(body, part, p, wanted, range, bend / (parts * parts));
            if one.seen < all.seen {
                (all.seen, all.at) = (one.seen, one.at);
            }
            all.bound = all.bound.min(one.bound);
            if one.met.is_some() {
                all.met = one.met;
                break;
            }
        }
        all
    }

    fn least_of_part(
        &self,
        body: &Meridian,
        part: FunctionPart,
        p: &Point,
        wanted: f64,
        [begin, end]: [f64; 2],
        bend: f64,
    ) -> LeastDistance {
        let (mut a, mut b) = (begin, end);
        let mut falls: Option<(f64, MotionSlope)> = None;
        let mut rises: Option<(f64, MotionSlope)> = None;
        let square = self.way.norm_squared();
        let guess = if square > 0.0 { (p - self.motion.from.tip).dot(&self.way) / square } else { begin };
        let mut t = guess.clamp(begin, end);
        let mut out = LeastDistance { met: None, seen: f64::INFINITY, at: t, bound: f64::NEG_INFINITY, slope: None };
        for _ in 0..STEPS {
            let here = self.value_and_slope(body, part, p, t);
            if here.value < out.seen {
                (out.seen, out.at) = (here.value, t);
            }
            let flat = here.rate.abs() * (end - begin) <= 0.1 * KNOWN;
            if here.rate < 0.0 {
                (falls, a) = (Some((t, here)), t);
            } else {
                (rises, b) = (Some((t, here)), t);
            }
            let (bound, slope, next) = match (&falls, &rises) {
                _ if flat => (here.value - here.rate.abs() * (end - begin), here.slope, t),
                (Some((s, f)), Some((u, r))) => {
                    // The time at which both planes are as high.
                    let meet = (r.value - f.value + f.rate * s - r.rate * u) / (f.rate - r.rate);
                    let share = r.rate / (r.rate - f.rate);
                    let bound = f.value + f.rate * (meet - s);
                    (bound, f.slope * share + r.slope * (1.0 - share), meet)
                }
                (Some((s, f)), None) => (f.value + f.rate * (end - s), f.slope, end),
                (None, Some((u, r))) => (r.value - r.rate * (u - begin), r.slope, begin),
                (None, None) => (f64::NEG_INFINITY, here.slope, t),
            };
            // Each of the planes is a bound: the highest counts.
            if bound > out.bound {
                (out.bound, out.slope) = (bound, Some(slope));
            }
            if out.seen <= wanted {
                out.met = Some(out.at);
                break;
            }
            let none_can_be = wanted > f64::NEG_INFINITY && out.bound - bend > wanted;
            if none_can_be || flat || out.seen - out.bound <= KNOWN || b - a < 1e-9 {
                break;
            }
            // Not too near to an end that was seen.
            let room = 0.05 * (b - a);
            t = match (&falls, &rises) {
                (Some(_), Some(_)) => next.clamp(a + room, b - room),
                _ => next,
            };
        }
        out.bound -= bend;
        out
    }
}

#[cfg(test)]
mod tests {
    use proveout_tool::{Profile, Segment};

    use super::*;

    /// Seeded numbers in 0..1.
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    fn bull() -> Meridian {
        let profile = Profile::new(vec![
            Segment::Line { from: [0.0, 0.0], to: [2.0, 0.0] },
            Segment::Arc { center: [2.0, 3.0], radius: 3.0, from: [2.0, 0.0], to: [5.0, 3.0] },
            Segment::Line { from: [5.0, 3.0], to: [5.0, 30.0] },
            Segment::Line { from: [5.0, 30.0], to: [0.0, 30.0] },
        ]);
        Meridian::whole(&profile.expect("convex"))
    }

    #[test]
    fn the_bound_is_below_every_value_near_by_and_reaches_the_least() {
        let body = bull();
        let mut next = numbers(7);
        let mut slopes = 0;
        for case in 0..2000 {
            let mut vector = |size: f64| Vector::new(next() - 0.5, next() - 0.5, next() - 0.5) * size;
            let axis = vector(2.0).normalize();
            let turned =
                if case % 3 == 0 { (axis + vector(if case % 2 == 0 { 0.02 } else { 0.6 })).normalize() } else { axis };
            let from = ToolPose { tip: Point::from(vector(20.0)), axis };
            let to = ToolPose { tip: from.tip + vector(30.0), axis: turned };
            let moving = MovingBody::new(&SweepMotion { from, to });
            let p = from.tip + axis * 8.0 + vector(30.0);
            let least = moving.least(&body, FunctionPart::Whole, &p, f64::NEG_INFINITY);
            let value = |q: &Point, t: f64| {
                let pose = from.interpolated(&to, t);
                let w = q - pose.tip;
                let z = w.dot(&pose.axis);
                body.eval((w - pose.axis * z).norm(), z).0
            };
            let true_least = (0..=2000).map(|k| value(&p, f64::from(k) / 2000.0)).fold(f64::INFINITY, f64::min);
            assert!(least.bound <= true_least + 1e-6, "{case}: {least:?} {true_least}");
            assert!(least.seen <= true_least + 2e-3, "{case}: {least:?} {true_least}");
            assert!(least.bound >= true_least - 0.03, "{case}: {least:?} {true_least}");
            if let Some(slope) = least.slope {
                slopes += 1;
                for _ in 0..10 {
                    let q = p + vector(4.0);
                    let there = (0..=200).map(|k| value(&q, f64::from(k) / 200.0)).fold(f64::INFINITY, f64::min);
                    assert!(least.bound + slope.dot(&(q - p)) <= there + 1e-3, "{case}");
                }
            }
            let inside = moving.bounds(&body).expanded(1e-6).contains(&p);
            assert!(true_least > 0.0 || inside, "{case}");
        }
        assert!(slopes > 1000);
    }
}
