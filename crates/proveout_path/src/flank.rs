//! Ruled sides cut with the flank of a cylinder or cone (side milling): the axis from two points of the
//! ruling, and what that leaves.
//!
//! ```text
//!         P2 ---- rho2 ----- C2        C_i  = P_i + rho_i n_i
//!         |                  |         rho  = r / cos(alpha)
//!  ruling |                  | axis    T    = (C2 - C1) / |C2 - C1|
//!         P1 ---- rho1 ----- C1        tip  = C1 - (z1 + r1 tan(alpha)) T
//!         :                            r(z) = r0 + (z - z0) tan(alpha)
//!         end + `below` of the side
//! ```
//!
//! rho is the distance along the normal from the skin to the axis. z is the height of a contact above the
//! tip, along T from that of the ruling's end.
//!
//! Both points are offset along their own normals (double point offset: Liu 1995, "Five-axis NC
//! cylindrical milling of sculptured surfaces", Computer-Aided Design 27(12); for cones each by its
//! own rho). Where the normals along the ruling agree (a developable side) the cutter touches along
//! the whole ruling. Where they turn by psi, the normal at a place between them is up to psi out of
//! the plane through axis and ruling, and the cutter cuts or leaves some `rho psi^2 / 8`. It also
//! meets the side away from the ruling, so the error is not read at the ruling: for places along it
//! the least signed distance of cutter and side across the cutter's width is searched. A negative
//! value is a gouge of this pose, exactly. A positive value is what the pass leaves, exactly where
//! the motion along the path is a screw, otherwise to second order of the step in which the side
//! changes its form.

use proveout_blade::ParametricSurface;
use proveout_geom::{Point, ToolPose, Vector};
use proveout_tool::Segment;

use super::{
    AxisRule, CutterTouch, Line, ParameterCurve, PathCutter, PathError, PathPoint, Strategy, Task,
    families::{LEAST_WAY, within},
    place::named,
};

/// Which lines of the parameter plane are straight in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rulings {
    /// v changes along them: from the root to the tip of a blade; the path goes round.
    Along,
    /// u changes along them: across a face; the path goes along it.
    Across,
}

/// One pass with the flank of the cutter.
#[derive(Clone, Debug, PartialEq)]
pub struct Flank {
    /// Which lines are straight.
    pub rulings: Rulings,
    /// From where to where round the section, part of the domain: the way, or the ruling from the side of the
    /// tip.
    pub round: [f64; 2],
    /// From where to where along the blade, part of the domain.
    pub along: [f64; 2],
    /// How far the straight side reaches beyond the ruling's end towards the tip, mm.
    pub below: f64,
    /// Largest error of the flank, gouge or rest, mm.
    pub limit: f64,
}

/// The ruling at a place of a line, and what is asked of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ruling {
    /// Which parameter runs along it.
    pub rulings: Rulings,
    /// That parameter at its ends; the cutter's tip lies beyond the first.
    pub range: [f64; 2],
    /// As [`Flank::below`].
    pub below: f64,
    /// As [`Flank::limit`].
    pub limit: f64,
}

/// What a pose of the flank does along its ruling.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlankError {
    /// Depth of the cutter in the side, mm.
    pub gouge: f64,
    /// Largest distance of the cutter from the side, mm.
    pub left: f64,
    /// Angle between the normals at both ends of the ruling, radian.
    pub twist: f64,
}

/// Places along a ruling at which its error is searched.
const LOOKS: usize = 17;
/// Places across the cutter's width before the search by the golden section.
const ACROSS: usize = 16;
/// Steps of the golden section: the width falls to 1e-7 of its place.
const SECTIONS: usize = 32;
/// Steps until heights and axis of a cone agree.
const ROUNDS: usize = 40;
/// A line of the profile that rises by no more than this is no straight side, mm.
const LEVEL_MM: f64 = 1e-6;
/// Shorter rulings have no direction, mm.
const SHORTEST_MM: f64 = 1e-9;
/// A line that is to be straight, with its ends nearer to each other than this, has no direction, mm.
const NO_CHORD_MM: f64 = 1e-12;
/// Turn of the axis in a step at which heights and axis agree, radian.
const STEADY: f64 = 1e-15;
/// Rounding of the height of the straight side, mm.
const ROUNDING_MM: f64 = 1e-9;
/// A contact nearer to the tool's axis than this has no direction from it, mm.
const ON_AXIS_MM: f64 = 1e-12;
/// Least way on the surface for each unit of a parameter, mm: the width of the search stays finite.
const SLOWEST: f64 = 1e-12;
/// Largest reach below a ruling, mm.
const DEEPEST_MM: f64 = 1e3;
/// Smallest error of the flank that can be asked for, mm.
const LEAST_LIMIT_MM: f64 = 1e-6;

/// The straight side of a cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
struct StraightSide {
    low: [f64; 2],
    high: [f64; 2],
}

impl StraightSide {
    /// The longest line of the profile that goes up.
    fn of(cutter: &PathCutter) -> Option<Self> {
        let lines = cutter.profile().segments().iter().filter_map(|s| match *s {
            Segment::Line { from, to } if to[1] - from[1] > LEVEL_MM => Some(Self { low: from, high: to }),
            _ => None,
        });
        lines.max_by(|a, b| a.height().total_cmp(&b.height()))
    }

    fn height(&self) -> f64 {
        self.high[1] - self.low[1]
    }

    fn slope(&self) -> f64 {
        (self.high[0] - self.low[0]) / self.height()
    }

    fn radius(&self, z: f64) -> f64 {
        self.low[0] + (z - self.low[1]) * self.slope()
    }
}

impl Ruling {
    fn uv(&self, uv: [f64; 2], part: f64) -> [f64; 2] {
        let at = within(self.range, part);
        match self.rulings {
            Rulings::Along => [uv[0], at],
            Rulings::Across => [at, uv[1]],
        }
    }

    fn point(&self, surface: &dyn ParametricSurface, uv: [f64; 2], part: f64, allowance: f64) -> (Point, Vector) {
        let [u, v] = self.uv(uv, part);
        let at = surface.local(u, v);
        (at.point + at.normal * allowance, at.normal)
    }

    /// The cutter at the ruling through a place.
    ///
    /// # Errors
    /// The cutter has no straight side, it is too short, or both points are one.
    pub(crate) fn touch(
        &self,
        surface: &dyn ParametricSurface,
        cutter: &PathCutter,
        points: [f64; 2],
        place: &PathPoint,
        allowance: f64,
    ) -> Result<CutterTouch, PathError> {
        let at = || place.named(&surface.domain());
        let no = |what: String| PathError::NoLine { what: format!("{what} at {}", at()), section: at().section };
        let side = StraightSide::of(cutter).ok_or_else(|| no("the cutter has no straight side to cut with".into()))?;
        let tangent = side.slope();
        let cosine = 1.0 / tangent.hypot(1.0);
        let of = |part: f64| self.point(surface, place.uv, part, allowance);
        let (end, top) = (of(0.0).0, of(1.0).0);
        let ends = points.map(of);
        let straight = || no("the ruling has no length".into());
        let mut axis = (ends[1].0 - ends[0].0).try_normalize(SHORTEST_MM).ok_or_else(straight)?;
        let start = side.low[1] + self.below;
        let height = |p: &Point, axis: &Vector| start + (p - end).dot(axis);
        for _ in 0..ROUNDS {
            let [from, to] = ends.map(|(p, n)| p + n * (side.radius(height(&p, &axis)) / cosine));
            let next = (to - from).try_normalize(SHORTEST_MM).ok_or_else(straight)?;
            let turned = (next - axis).norm();
            axis = next;
            if turned < STEADY {
                break;
            }
        }
        let (p, n) = ends[0];
        let z = height(&p, &axis);
        let tip = p + n * (side.radius(z) / cosine) - axis * (z + side.radius(z) * tangent);
        let reach = height(&top, &axis);
        if reach > side.high[1] + ROUNDING_MM || start > side.high[1] {
            return Err(no(format!(
                "the straight side of the cutter ends {:.3} mm above its tip, the ruling {reach:.3} mm",
                side.high[1]
            )));
        }
        let contact = place.point + place.normal * allowance;
        let middle = height(&contact, &axis);
        let off = contact - tip;
        let radial = off - axis * off.dot(&axis);
        let radial = radial.try_normalize(ON_AXIS_MM).ok_or_else(|| no("the axis lies in the side".into()))?;
        let about = axis.cross(&radial);
        let round = cosine / side.radius(middle);
        let (f, k) = (place.feed.dot(&about), place.across.dot(&about));
        Ok(CutterTouch {
            pose: ToolPose { tip, axis },
            radial,
            on_profile: [side.radius(middle), middle],
            form: [round * f * f, round * f * k, round * k * k],
        })
    }

    /// Signed distance of the cutter from a point of the side, mm.
    fn distance(cutter: &PathCutter, pose: &ToolPose, p: &Point) -> f64 {
        let off = p - pose.tip;
        let z = off.dot(&pose.axis);
        cutter.profile().signed_distance([(off - pose.axis * z).norm(), z])
    }

    /// The errors of a pose along the ruling through `uv`.
    pub(crate) fn error(
        &self,
        surface: &dyn ParametricSurface,
        cutter: &PathCutter,
        pose: &ToolPose,
        uv: [f64; 2],
        allowance: f64,
    ) -> FlankError {
        let domain = surface.domain();
        let [low, high] = match self.rulings {
            Rulings::Along if domain.u_closed => [f64::NEG_INFINITY, f64::INFINITY],
            Rulings::Along => domain.u,
            Rulings::Across => domain.v,
        };
        let mut worst = FlankError::default();
        for j in 0..LOOKS {
            let here = self.uv(uv, j as f64 / (LOOKS - 1) as f64);
            let local = surface.local(here[0], here[1]);
            let k = usize::from(self.rulings == Rulings::Across);
            let speed = local.first[k].norm().max(SLOWEST);
            let width = cutter.profile().max_radius() / speed;
            let [from, to] = [(here[k] - width).max(low), (here[k] + width).min(high)];
            let distance = |w: f64| {
                let mut there = here;
                there[k] = w;
                let at = surface.local(there[0], there[1]);
                Self::distance(cutter, pose, &(at.point + at.normal * allowance))
            };
            let least = least(distance, from, to).min(distance(here[k]));
            worst.gouge = worst.gouge.max(-least);
            worst.left = worst.left.max(least);
        }
        let [a, b] = [0.0, 1.0].map(|part| self.point(surface, uv, part, 0.0).1);
        worst.twist = a.cross(&b).norm().atan2(a.dot(&b));
        worst
    }

    /// Largest difference between the distances of two poses from the ruling through `uv`, mm.
    pub(crate) fn moved(
        &self,
        surface: &dyn ParametricSurface,
        cutter: &PathCutter,
        poses: [&ToolPose; 2],
        uv: [f64; 2],
        allowance: f64,
    ) -> f64 {
        let off = |part: f64| {
            let (p, _) = self.point(surface, uv, part, allowance);
            let [a, b] = poses.map(|pose| Self::distance(cutter, pose, &p));
            (a - b).abs()
        };
        [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().map(off).fold(0.0, f64::max)
    }
}

/// The least value over a range: the lowest of equal steps, then the golden section round it.
fn least(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let at = |k: usize| from + (to - from) * k as f64 / ACROSS as f64;
    let best = (0..=ACROSS).map(|k| (f(at(k)), k)).min_by(|a, b| a.0.total_cmp(&b.0));
    let (value, k) = best.unwrap_or((f64::INFINITY, 0));
    let (mut a, mut b) = (at(k.saturating_sub(1)), at((k + 1).min(ACROSS)));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_c, mut at_d) = (f(c), f(d));
    for _ in 0..SECTIONS {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - golden * (b - a);
            at_c = f(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + golden * (b - a);
            at_d = f(d);
        }
    }
    value.min(at_c).min(at_d)
}

impl Strategy for Flank {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        PathError::within("the reach below the ruling in mm", self.below, 0.0, DEEPEST_MM)?;
        PathError::within("the error of the flank in mm", self.limit, LEAST_LIMIT_MM, 10.0)?;
        let AxisRule::Ruling { points } = task.rule else {
            let what = "the flank of a cutter takes its axis from the ruling".to_owned();
            return Err(PathError::NoLine { what, section: self.along[0] });
        };
        let domain = task.surface.domain();
        let most = if domain.u_closed { 2.0 } else { 1.0 };
        for (name, value, high) in [
            ("the start round the section", self.round[0], most),
            ("the end round the section", self.round[1], most),
            ("the start along the blade", self.along[0], 1.0),
            ("the end along the blade", self.along[1], 1.0),
        ] {
            PathError::within(name, value, 0.0, high)?;
        }
        for range in [self.round, self.along] {
            PathError::within("the way of the flank, part of the domain", (range[1] - range[0]).abs(), LEAST_WAY, 1.0)?;
        }
        let (u, v) = (self.round.map(|r| within(domain.u, r)), self.along.map(|r| within(domain.v, r)));
        let (range, way) = if self.rulings == Rulings::Along { (v, u) } else { (u, v) };
        let ruling = Ruling { rulings: self.rulings, range, below: self.below, limit: self.limit };
        self.check_rulings(task.surface, &ruling, way)?;
        let guide = within(range, 0.5 * (points[0] + points[1]));
        let [from, to] = match self.rulings {
            Rulings::Along => [[way[0], guide], [way[1], guide]],
            Rulings::Across => [[guide, way[0]], [guide, way[1]]],
        };
        let curve = ParameterCurve::straight(from, to);
        let what = "the flank has no way".to_owned();
        let curve = curve.ok_or(PathError::NoLine { what, section: self.along[0] })?;
        let mut line = Line::new("flank".to_owned(), curve);
        line.ruling = Some(ruling);
        Ok(vec![line])
    }
}

impl Flank {
    /// Lines that are to be straight are so within the error that is allowed.
    fn check_rulings(&self, surface: &dyn ParametricSurface, ruling: &Ruling, way: [f64; 2]) -> Result<(), PathError> {
        for i in 0..LOOKS {
            let at = within(way, i as f64 / (LOOKS - 1) as f64);
            let uv = [at, at];
            let of = |part: f64| ruling.point(surface, uv, part, 0.0).0;
            let (from, to) = (of(0.0), of(1.0));
            let along = (to - from).try_normalize(NO_CHORD_MM).unwrap_or_else(Vector::zeros);
            for j in 1..LOOKS {
                let p = of(j as f64 / LOOKS as f64);
                let off = (p - from).cross(&along).norm();
                if off > self.limit {
                    let place = named(&surface.domain(), ruling.uv(uv, j as f64 / LOOKS as f64), &p);
                    let what =
                        format!("the side is not ruled: its line leaves the straight one by {off:.4} mm at {place}");
                    return Err(PathError::NoLine { what, section: place.section });
                }
            }
        }
        Ok(())
    }
}
