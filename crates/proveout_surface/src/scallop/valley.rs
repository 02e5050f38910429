//! The valleys beside a ridge: where each pass comes nearest to the design, and what its geometry says of the ridge.

use proveout_geom::{Point, Vector};
use proveout_tool::Profile;

use super::{
    contact::{CutterContact, scallop_between},
    ridges::{Line, Ridge},
};
use crate::{
    DesignSurface,
    topography::{PathContact, SweptPath, Touching},
};

/// Steps by which the valley is looked for, each twice as long as the one before.
const DOUBLINGS: usize = 12;
/// First step, mm.
const FIRST_STEP: f64 = 0.01;
/// Slope of the pass against the design at which it is level.
const LEVEL: f64 = 1e-9;

/// A valley beside a ridge, where its pass touches the design or comes nearest to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
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

/// Looks for both valleys of a ridge across its direction, and fills in spacing, curvature and geometric height.
pub(super) fn sides(
    path: &SweptPath,
    cutters: &[Vec<Profile>],
    design: &(impl DesignSurface + ?Sized),
    ridge: &mut Ridge,
    contacts: [PathContact; 2],
    reach: f64,
) {
    let Some(across) = ridge.normal.cross(&ridge.along).try_normalize(1e-9) else { return };
    let line = Line { origin: ridge.point, across, normal: ridge.normal };
    let find = |k: usize| valley(path, design, &line, contacts[k], reach);
    let (Some(first), Some(second)) = (find(0), find(1)) else { return };
    let chord = (second.foot - first.foot).norm();
    let bent = (second.normal - first.normal).dot(&(second.foot - first.foot));
    // The angle between the normals over the arc; they are unit vectors, so that its half has the sine of half their difference.
    let half = (0.5 * (second.normal - first.normal).norm()).min(1.0).asin();
    let arc = if half > 1e-9 { chord * half / half.sin() } else { chord };
    let curvature = if half > 1e-9 && arc > 1e-12 { bent.signum() * 2.0 * half / arc } else { 0.0 };
    ridge.sides = Some([first, second]);
    (ridge.spacing, ridge.curvature) = (Some(arc), Some(curvature));
    ridge.geometric = geometric(cutters, [&first, &second], chord, curvature);
}

/// Height of the ridge by the formulas of two contacts.
fn geometric(cutters: &[Vec<Profile>], sides: [&Side; 2], chord: f64, curvature: f64) -> Option<f64> {
    // Seen along the feed, or against it, so that the second contact lies to the left; what is swept is the same.
    let left = sides[0].normal.cross(&sides[0].feed);
    let sense = if left.dot(&(sides[1].foot - sides[0].foot)) >= 0.0 { 1.0 } else { -1.0 };
    let contacts = |side: &Side| -> Vec<CutterContact<'_>> {
        let bodies = cutters.get(side.cutter as usize).map_or(&[][..], Vec::as_slice);
        bodies.iter().filter_map(|b| CutterContact::new(b, side.axis, side.normal, side.feed * sense)).collect()
    };
    let (first, second) = (contacts(sides[0]), contacts(sides[1]));
    // Of a cutter of several bodies the one that reaches lowest leaves the surface.
    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
    pairs.filter_map(|(a, b)| scallop_between(a, b, chord, curvature)).reduce(f64::min)
}

/// The level place of a pass beside the ridge, searched across it on the side on which the pass lies.
fn valley(
    path: &SweptPath,
    design: &(impl DesignSurface + ?Sized),
    line: &Line,
    from: PathContact,
    reach: f64,
) -> Option<Side> {
    // Slope of the pass against the design at a place, as difference of their normals, with what is there.
    let look = |s: f64, near: &PathContact| {
        let place = line.at(s);
        let contact = path.follow(near, &place, &line.normal)?;
        let touching = path.touching(&contact, &place, &line.normal)?;
        let point = place + line.normal * contact.height;
        let nearest = design.nearest(&point, reach)?;
        let slope = (nearest.normal - touching.normal).dot(&line.across);
        Some((slope, contact, touching, nearest, point))
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
        if here.0.abs() < LEVEL || (near.0 - far.0).abs() < 1e-9 {
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
    let (_, contact, Touching { way, axis, .. }, nearest, point) = best;
    Some(Side {
        height: nearest.distance,
        foot: point - nearest.normal * nearest.distance,
        normal: nearest.normal,
        axis,
        feed: way.try_normalize(1e-12)?,
        cutter: path.pieces().get(contact.piece as usize)?.cutter?,
    })
}
