//! The valleys next to a ridge: where each pass comes nearest to the design, and the ridge height that its
//! geometry gives.

use proveout_geom::{Point, Vector};
use proveout_tool::Profile;

use super::{
    contact::{CutterContact, scallop_between},
    ridges::{Line, Ridge},
};
use crate::{
    DesignSurface,
    topography::{ContactDirections, PathContact, SweptPath},
};

/// Steps by which the valley is looked for, each twice as long as the one before.
const DOUBLINGS: usize = 12;
/// First step, mm.
const FIRST_STEP: f64 = 0.01;
/// Base of the first section of the design, in cells to either side.
const CELLS: f64 = 4.0;
/// Slope of the pass against the design at which it is level.
const LEVEL: f64 = 1e-9;
/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-9;
/// Half an angle of an arc below which it is as long as its chord.
const STRAIGHT: f64 = 1e-9;
/// Feet nearer to each other than this are one, mm, and show no curvature.
const ONE_FOOT: f64 = 1e-9;
/// A bracket that is narrower is a place, mm.
const NARROW: f64 = 1e-9;
/// A way of a pass that is shorter has no direction, mm.
const NO_WAY: f64 = 1e-12;

/// A valley next to a ridge, where its pass touches the design or comes nearest to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valley {
    /// Height above the design, mm; negative in a gouge.
    pub height: f64,
    /// The place on the design.
    pub foot: Point,
    /// Outward unit normal of the design there.
    pub normal: Vector,
    /// Axis of the cutter.
    pub axis: Vector,
    /// Direction of its motion.
    pub feed: Vector,
    /// Which cutter.
    pub cutter: u32,
}

/// Looks for both valleys of a ridge across its direction, and fills in spacing, curvature and geometric
/// height; `cell` is the distance of the rays, mm.
///
/// The design across the ridge is approximated by a circle through three points of it, `base` apart. The
/// normals of a mesh jump from facet to facet, and a valley that followed them would lie anywhere within a
/// facet. The first `base` is some cells, the second the step found with it.
pub(super) fn sides(
    path: &SweptPath,
    cutters: &[Vec<Profile>],
    design: &(impl DesignSurface + ?Sized),
    ridge: &mut Ridge,
    contacts: [PathContact; 2],
    (reach, cell): (f64, f64),
) {
    let Some(across) = ridge.normal.cross(&ridge.along).try_normalize(SHORTEST) else { return };
    let line = Line { origin: ridge.point, across, normal: ridge.normal };
    let look = |base: f64| {
        let circle = SectionCircle::through(design, &line, base, reach)?;
        let first = valley(path, design, &line, &circle, contacts[0], reach)?;
        let second = valley(path, design, &line, &circle, contacts[1], reach)?;
        Some((circle.curvature, first, second))
    };
    let Some(mut found) = look(CELLS * cell) else { return };
    let chord = (found.2.foot - found.1.foot).norm();
    if 2.0 * chord > CELLS * cell {
        // Where the design ends within that base the first one stays.
        found = look(2.0 * chord).unwrap_or(found);
    }
    let (curvature, first, second) = found;
    let chord = (second.foot - first.foot).norm();
    let half = 0.5 * chord * curvature;
    let arc = if half.abs() > STRAIGHT { 2.0 * half.clamp(-1.0, 1.0).asin() / curvature } else { chord };
    if [&first, &second].into_iter().any(|side| on_flat(cutters, side)) {
        ridge.on_flat = true;
        return;
    }
    ridge.sides = Some([first, second]);
    (ridge.spacing, ridge.curvature) = (Some(arc), Some(curvature));
    ridge.geometric = geometric(cutters, [&first, &second], chord, curvature);
}

/// The section of the design across a ridge.
struct SectionCircle {
    middle: Point,
    /// Outward at the middle.
    normal: Vector,
    /// Positive where the design is convex, 1/mm.
    curvature: f64,
    /// The plane of the section: across, up.
    plane: [Vector; 2],
}

impl SectionCircle {
    /// Through the feet of three places of a line, `base` mm apart.
    fn through(design: &(impl DesignSurface + ?Sized), line: &Line, base: f64, reach: f64) -> Option<Self> {
        let foot = |s: f64| {
            let place = line.at(s);
            let nearest = design.nearest(&place, reach)?;
            Some(place - nearest.normal * nearest.distance)
        };
        let middle = foot(0.0)?;
        let in_plane = |p: Point| [(p - middle).dot(&line.across), (p - middle).dot(&line.normal)];
        let (a, b) = (in_plane(foot(-base)?), in_plane(foot(base)?));
        let length = |d: [f64; 2]| d[0].hypot(d[1]);
        let lengths = [length(a), length(b), length([b[0] - a[0], b[1] - a[1]])];
        if lengths.iter().any(|l| *l < ONE_FOOT) {
            return None;
        }
        // Four times the area of the triangle over the product of its sides.
        let curvature = 2.0 * (a[0] * b[1] - a[1] * b[0]) / (lengths[0] * lengths[1] * lengths[2]);
        // The chord to the first point leads the tangent at the middle by half its arc.
        let angle = (-a[1]).atan2(-a[0]) - (0.5 * curvature * lengths[0]).clamp(-1.0, 1.0).asin();
        let (sine, cosine) = angle.sin_cos();
        let normal = line.normal * cosine - line.across * sine;
        Some(Self { middle, normal, curvature, plane: [line.across, line.normal] })
    }

    /// Outward unit normal at the place of the circle nearest to a point.
    fn normal_at(&self, p: &Point) -> Option<Vector> {
        let d = p - self.middle;
        let d = self.plane[0] * d.dot(&self.plane[0]) + self.plane[1] * d.dot(&self.plane[1]);
        (self.normal + d * self.curvature).try_normalize(SHORTEST)
    }

    /// A direction in the plane of the section.
    fn flat(&self, v: &Vector) -> Option<Vector> {
        (self.plane[0] * v.dot(&self.plane[0]) + self.plane[1] * v.dot(&self.plane[1])).try_normalize(SHORTEST)
    }
}

/// Whether a pass lies on the design with a flat of its cutter: then neither its contact nor its distance
/// from the next pass is one place.
fn on_flat(cutters: &[Vec<Profile>], side: &Valley) -> bool {
    let bodies = cutters.get(side.cutter as usize).map_or(&[][..], Vec::as_slice);
    let mut contacts = bodies.iter().filter_map(|b| CutterContact::new(b, side.axis, side.normal, side.feed));
    contacts.any(|contact| contact.rests_on_flat())
}

/// Height of the ridge by the formulas of two contacts.
fn geometric(cutters: &[Vec<Profile>], sides: [&Valley; 2], chord: f64, curvature: f64) -> Option<f64> {
    // Seen along the feed, or against it, so that the second contact lies to the left; what is swept is the
    // same.
    let left = sides[0].normal.cross(&sides[0].feed);
    let sense = if left.dot(&(sides[1].foot - sides[0].foot)) >= 0.0 { 1.0 } else { -1.0 };
    let contacts = |side: &Valley| -> Vec<CutterContact<'_>> {
        let bodies = cutters.get(side.cutter as usize).map_or(&[][..], Vec::as_slice);
        bodies.iter().filter_map(|b| CutterContact::new(b, side.axis, side.normal, side.feed * sense)).collect()
    };
    let (first, second) = (contacts(sides[0]), contacts(sides[1]));
    // Of a cutter of several bodies the one that reaches lowest leaves the surface.
    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
    pairs.filter_map(|(a, b)| scallop_between(a, b, chord, curvature)).reduce(f64::min)
}

/// The level place of a pass next to the ridge, searched across it on the side on which the pass lies.
fn valley(
    path: &SweptPath,
    design: &(impl DesignSurface + ?Sized),
    line: &Line,
    circle: &SectionCircle,
    from: PathContact,
    reach: f64,
) -> Option<Valley> {
    // Slope of the pass against the design at a place, as difference of their normals, with what is there.
    let look = |s: f64, near: &PathContact| {
        let place = line.at(s);
        let contact = path.follow(near, &place, &line.normal)?;
        let touching = path.touching(&contact, &place, &line.normal)?;
        let point = place + line.normal * contact.height;
        let normal = circle.normal_at(&point)?;
        let slope = (normal - circle.flat(&touching.normal)?).dot(&line.across);
        Some((slope, contact, touching, normal, point))
    };
    let start = look(0.0, &PathContact { height: 0.0, ..from })?;
    let down = -start.0.signum();
    let (mut near, mut far) = ((0.0, start.0), None);
    let mut best = start;
    let mut step = FIRST_STEP;
    for _ in 0..DOUBLINGS {
        let s = near.0 + down * step;
        let here = look(s, &best.1)?;
        if here.0 * start.0 <= 0.0 {
            far = Some((s, here.0));
            break;
        }
        (near, best) = ((s, here.0), here);
        step *= 2.0;
    }
    let mut far = far?;
    let mut side = 0;
    for _ in 0..60 {
        let mut s = (near.0 * far.1 - far.0 * near.1) / (far.1 - near.1);
        if !s.is_finite() || (s - near.0) * (s - far.0) > 0.0 {
            s = 0.5 * (near.0 + far.0);
        }
        let here = look(s, &best.1)?;
        best = here;
        if here.0.abs() < LEVEL || (near.0 - far.0).abs() < NARROW {
            break;
        }
        if here.0 * start.0 > 0.0 {
            near = (s, here.0);
            if side == 1 {
                far.1 *= 0.5;
            }
            side = 1;
        } else {
            far = (s, here.0);
            if side == -1 {
                near.1 *= 0.5;
            }
            side = -1;
        }
    }
    let (_, contact, ContactDirections { way, axis, .. }, normal, point) = best;
    let nearest = design.nearest(&point, reach)?;
    Some(Valley {
        height: nearest.distance,
        foot: point - normal * nearest.distance,
        normal,
        axis,
        feed: way.try_normalize(NO_WAY)?,
        cutter: path.pieces().get(contact.piece as usize)?.cutter?,
    })
}
