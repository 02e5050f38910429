//! From line to line: lift, retract, way round the blade or over the face, approach.
//!
//! ```text
//!   closed blade, seen along it             open face, seen from the side
//!
//!        .-- clearance cylinder --.           ---- clearance plane ----
//!       /      .---.               \             |             |
//!      |  <===(     )               |            |             |
//!       \      '---'  tool: radial /         ____v__      _____v___
//!        '------------------------'                 \____/
//! ```
//!
//! The cutter is lifted along the normal, goes out along its axis (over a face: along the face's mean normal)
//! until its tip is outside of the cylinder (the plane), and is led there, its axis keeping its parts along,
//! round and out of the cylinder. What is led like this is a proposal: the collision gate of a run is what
//! proves it free.

use proveout_blade::ParametricSurface;
use proveout_geom::{Point, ToolPose, Vector};

use super::{LineContacts, PathContact, PathCutter, PathError};

/// A motion to a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Where to, frame of the surface.
    pub pose: ToolPose,
    /// Seconds that a feed motion takes; none for a rapid.
    pub seconds: Option<f64>,
}

/// Distances of the motions between lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkRule {
    /// Way along the normal at feed, before and after a line, mm. Lines that begin nearer than this to the
    /// end of the one before are reached at this height.
    pub lift: f64,
    /// Distance of cylinder or plane from the outermost point of the surface with its allowance, mm.
    pub clearance: f64,
    /// Feed at the contact, mm/s.
    pub feed: f64,
    /// Longest step between two poses of a rapid, mm of the tip, and largest turn of the axis, radian.
    pub step: [f64; 2],
    /// The feed holds for the chord between two contacts, not for the way along the line.
    pub chords: bool,
}

/// Where rapids are led.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outside {
    Cylinder { on_axis: Point, along: Vector, radius: f64 },
    Plane { point: Point, normal: Vector },
}

/// Number of sample places in each direction that give the size of the surface.
const LOOKS: usize = 48;
/// A mean of directions that is shorter than this has none.
const NO_MEAN: f64 = 1e-6;
/// Shorter ways have no direction, mm.
const SHORTEST_MM: f64 = 1e-9;
/// Sine of the angle between tool axis and blade below which the axis leads out of nothing.
const ALONG_BLADE: f64 = 1e-9;
/// Least lift and clearance, mm.
const LEAST_MM: f64 = 1e-3;
/// Largest lift, mm.
const MOST_LIFT_MM: f64 = 1e3;
/// Largest clearance, mm.
const MOST_CLEARANCE_MM: f64 = 1e4;
/// Lowest and highest feed, mm/s.
const FEEDS: [f64; 2] = [1e-6, 1e6];
/// A joined line that begins nearer than this to the end of the last needs no link, mm.
const SAME_POINT_MM: f64 = 1e-6;
/// Way that a move takes time for at least, mm.
const LEAST_WAY_MM: f64 = 1e-9;

impl Outside {
    fn of(surface: &dyn ParametricSurface, most_allowance: f64, clearance: f64) -> Self {
        let domain = surface.domain();
        let at = |[low, high]: [f64; 2], k: usize| low + (high - low) * k as f64 / LOOKS as f64;
        let mut places = Vec::with_capacity((LOOKS + 1) * (LOOKS + 1));
        for i in 0..=LOOKS {
            for j in 0..=LOOKS {
                let local = surface.local(at(domain.u, i), at(domain.v, j));
                places.push((local.point, local.normal));
            }
        }
        let count = places.len() as f64;
        let mean = |of: &dyn Fn(&(Point, Vector)) -> Vector| places.iter().map(of).sum::<Vector>() / count;
        if !domain.u_closed {
            let normal = mean(&|p| p.1).try_normalize(NO_MEAN).unwrap_or_else(|| places[0].1);
            let highest = places.iter().map(|p| p.0.coords.dot(&normal)).fold(f64::NEG_INFINITY, f64::max);
            return Self::Plane { point: Point::from(normal * (highest + most_allowance + clearance)), normal };
        }
        let row =
            |v: f64| (0..LOOKS).map(|i| surface.local(at(domain.u, i), v).point.coords).sum::<Vector>() / LOOKS as f64;
        let (root, tip) = (row(domain.v[0]), row(domain.v[1]));
        let along = (tip - root).try_normalize(SHORTEST_MM).unwrap_or_else(Vector::z);
        let on_axis = Point::from(0.5 * (root + tip));
        let off = |p: &Point| {
            let d = p - on_axis;
            (d - along * d.dot(&along)).norm()
        };
        let widest = places.iter().map(|p| off(&p.0)).fold(0.0, f64::max);
        Self::Cylinder { on_axis, along, radius: widest + most_allowance + clearance }
    }

    /// The pose out there, from a lifted one: along its axis, or over a face along its normal.
    fn reached(&self, pose: &ToolPose) -> ToolPose {
        let way = match self {
            Self::Plane { point, normal } => normal * (point - pose.tip).dot(normal).max(0.0),
            Self::Cylinder { on_axis, along, radius } => {
                let flat = |v: Vector| v - along * v.dot(along);
                let (d, a) = (flat(pose.tip - on_axis), flat(pose.axis));
                // |d + s a| = radius. An axis along the blade leads out of nothing: there the way is straight
                // from the blade.
                let (direction, a) = if a.norm() > 0.2 {
                    (pose.axis, a)
                } else {
                    let out = d
                        .try_normalize(SHORTEST_MM)
                        .unwrap_or_else(|| a.try_normalize(ALONG_BLADE).unwrap_or_else(Vector::x));
                    (out, out)
                };
                let (p, q) = (d.dot(&a) / a.norm_squared(), (d.norm_squared() - radius * radius) / a.norm_squared());
                let s = if q < 0.0 { -p + (p * p - q).sqrt() } else { 0.0 };
                direction * s.max(0.0)
            }
        };
        ToolPose { tip: pose.tip + way, axis: pose.axis }
    }

    /// Poses from one outside to another, the last one included.
    fn round(&self, from: &ToolPose, to: &ToolPose, step: [f64; 2]) -> Vec<ToolPose> {
        let count = |way: f64, turn: f64| ((way / step[0]).max(turn / step[1]).ceil().max(1.0)) as usize;
        match self {
            Self::Plane { .. } => {
                let n = count((to.tip - from.tip).norm(), from.angle_to(to));
                (1..=n).map(|k| from.interpolated(to, k as f64 / n as f64)).collect()
            }
            Self::Cylinder { on_axis, along, .. } => {
                let flat = |v: Vector| v - along * v.dot(along);
                let across = along
                    .cross(&Vector::x())
                    .try_normalize(0.3)
                    .unwrap_or_else(|| along.cross(&Vector::y()).normalize());
                let third = along.cross(&across);
                let polar = |pose: &ToolPose| {
                    let d = pose.tip - on_axis;
                    let f = flat(d);
                    let angle = f.dot(&third).atan2(f.dot(&across));
                    let out = f.try_normalize(SHORTEST_MM).unwrap_or(across);
                    let round = along.cross(&out);
                    let axis = [pose.axis.dot(&out), pose.axis.dot(&round), pose.axis.dot(along)];
                    (angle, f.norm(), d.dot(along), axis)
                };
                let (a, b) = (polar(from), polar(to));
                let turn = proveout_geom::wrap_near(b.0, a.0) - a.0;
                let n = count((b.2 - a.2).hypot(turn * a.1.max(b.1)), turn.abs() + from.angle_to(to));
                let mix = |x: f64, y: f64, t: f64| x + (y - x) * t;
                let pose = |k: usize| {
                    if k == n {
                        return *to;
                    }
                    let t = k as f64 / n as f64;
                    let (s, c) = (a.0 + turn * t).sin_cos();
                    let out = across * c + third * s;
                    let round = along.cross(&out);
                    let [x, y, z] = std::array::from_fn(|i| mix(a.3[i], b.3[i], t));
                    let axis = (out * x + round * y + along * z).try_normalize(NO_MEAN).unwrap_or(out);
                    ToolPose { tip: on_axis + out * mix(a.1, b.1, t) + along * mix(a.2, b.2, t), axis }
                };
                (1..=n).map(pose).collect()
            }
        }
    }
}

/// The motions of a whole path: the first one is a rapid to a pose outside, the last one ends outside.
///
/// # Errors
/// Distances out of their ranges.
pub fn linked(
    surface: &dyn ParametricSurface,
    cutter: &PathCutter,
    lines: &[LineContacts],
    rule: &LinkRule,
) -> Result<Vec<Move>, PathError> {
    PathError::within("the lift in mm", rule.lift, LEAST_MM, MOST_LIFT_MM)?;
    PathError::within("the clearance in mm", rule.clearance, LEAST_MM, MOST_CLEARANCE_MM)?;
    PathError::within("the feed in mm/s", rule.feed, FEEDS[0], FEEDS[1])?;
    let most = lines.iter().map(|l| l.allowance).fold(0.0, f64::max);
    let reach = cutter.profile().max_radius();
    // The tip is led outside; the cutter around it has a radius.
    let outside = Outside::of(surface, most, rule.clearance + reach);
    let lifted = |contact: &PathContact| ToolPose {
        tip: contact.touch.pose.tip + contact.place.normal * rule.lift,
        axis: contact.touch.pose.axis,
    };
    let mut moves: Vec<Move> = Vec::with_capacity(lines.iter().map(|l| l.contacts.len() + 8).sum());
    let rapid = |pose: ToolPose| Move { pose, seconds: None };
    let mut at: Option<&PathContact> = None;
    for line in lines {
        let Some(first) = line.contacts.first() else { continue };
        let apart = at.map(|last| (first.touch.pose.tip - last.touch.pose.tip).norm());
        match at {
            Some(_) if line.joined && apart.is_some_and(|d| d < SAME_POINT_MM) => {}
            Some(last)
                if apart.is_some_and(|d| d <= rule.lift) && last.touch.pose.angle_to(&first.touch.pose) < 0.5 =>
            {
                let seconds = Some(rule.lift / rule.feed);
                moves.push(Move { pose: lifted(last), seconds });
                moves.push(rapid(lifted(first)));
                moves.push(Move { pose: first.touch.pose, seconds });
            }
            _ => {
                let high = outside.reached(&lifted(first));
                match at {
                    Some(last) => {
                        moves.push(Move { pose: lifted(last), seconds: Some(rule.lift / rule.feed) });
                        let from = outside.reached(&lifted(last));
                        moves.push(rapid(from));
                        moves.extend(outside.round(&from, &high, rule.step).into_iter().map(rapid));
                    }
                    None => moves.push(rapid(high)),
                }
                moves.push(rapid(lifted(first)));
                moves.push(Move { pose: first.touch.pose, seconds: Some(rule.lift / rule.feed) });
            }
        }
        for pair in line.contacts.windows(2) {
            // A step of the contact takes its length; where only the axis turns, as long as its tip needs.
            let chord = (pair[1].place.point - pair[0].place.point).norm();
            let way = if rule.chords { chord } else { pair[1].length - pair[0].length }.max(LEAST_WAY_MM);
            moves.push(Move { pose: pair[1].touch.pose, seconds: Some(way / rule.feed) });
        }
        at = line.contacts.last();
    }
    if let Some(last) = at {
        moves.push(Move { pose: lifted(last), seconds: Some(rule.lift / rule.feed) });
        moves.push(rapid(outside.reached(&lifted(last))));
    }
    Ok(moves)
}
