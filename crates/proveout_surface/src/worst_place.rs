//! The worst place of an area between the rays.
//!
//! Rays meet the cut surface every cell, so that the deepest of their points lies above the deepest place by
//! up to `(c/2)^2 / 2 (1/R_1 + 1/R_2)` in a groove of a cutter with these radii against the design: 10
//! micrometers for a ball of 3 mm and cells of 0.35 mm. The stock remembers which piece of motion made each
//! point, and the swept surface of a piece is known exactly; so the worst place is searched on it.
//!
//! **Height.** Over a foot on the design the height of the cut surface along the design's normal is found by
//! inverse contact ([`SweptPath`]): for a gouge that of the path about the piece that made the point,
//! followed while it falls; for an excess the lowest of all pieces that come near, since there the surface is
//! highest where several meet.
//!
//! **Search.** From each of the worst points of the area: a lattice of 7 x 7 feet over the cells round it,
//! then smaller ones of 5 x 5 about the best, each with half the step of the one before, until the step is a
//! thousandth of a cell. A lattice bounds a smooth extreme to step^2 / 2R, and a ridge, where heights fall
//! off with a slope, to slope times step: it ends below 0.1 micrometers for cells up to 0.4 mm. Halving keeps
//! twice the step about the best place, so that a ridge that runs askew is not lost.
//!
//! **What keeps it on the part.** The place lies within the cells round a point of the cut surface, inside
//! of the stock's box and the judged region, and its height is its distance from the design. Past the
//! middle between two faces the other face is nearer and gives the distance, as along the normal of an end
//! face into a layer that is milled off next to it. Other pieces that cut deeper at the worst place of a
//! gouge replace the first one, and are searched in turn.
//!
//! Limits: an area that is partly skin of the raw stock keeps its points as excess (what the skin bounds is
//! not searched); so do gaps of walls that are gone, and points made by an earlier run. An area with more
//! than [`crate::MOST_STARTS`] cells of nearly the same depth is searched about the worst of them.

use proveout_geom::{Aabb, Point, Vector};

use crate::{
    DesignSurface, Side, Starts,
    topography::{PathContact, SweptPath},
};

/// The first lattice reaches so many cells to each side.
const REACH: f64 = 1.5;
/// Places to each side of the middle in the first lattice, and in those that follow.
const FIRST: i32 = 3;
const LATER: i32 = 2;
/// Each lattice has so much of the step of the one before.
const SHRINK: f64 = 0.5;
/// The search ends at this part of a cell.
const END: f64 = 1e-3;
/// Starts of an excess: each takes all pieces near.
const STARTS_OF_EXCESS: usize = 4;
/// Times that another piece may turn out to be deeper.
const AGAIN: usize = 4;
/// What a height followed may be off the point that the stock has, mm: bound of the sweeps along the normal,
/// and rounding.
const SAME: f64 = 5e-3;
/// A height may differ from the distance of its point by this fraction and mm: the corners of a mesh of a
/// smooth face.
const OWN: [f64; 2] = [0.02, 1e-4];
/// Heights that differ by less are one, mm.
const EQUAL: f64 = 1e-9;
/// Pieces are near a place when their bounds hold it or are not farther from it than this, mm.
const NEAR: f64 = 1e-6;

/// What is searched on.
pub struct Refine<'a> {
    /// The motion, by the numbers that the stock remembers.
    pub path: &'a SweptPath,
    /// What heights count from.
    pub design: &'a dyn DesignSurface,
    /// Only in this box: the stock's own.
    pub bounds: Aabb,
    /// Only in this one.
    pub region: Option<Aabb>,
    /// Longest edge of the cells, mm.
    pub cell: f64,
}

/// The worst place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Depth or height, mm, positive.
    pub depth: f64,
    /// Where.
    pub point: Point,
    /// The piece of motion that made it.
    pub made_by: u32,
}

/// The deepest place of a gouge ([`Side::Missing`]), or the highest of an excess; none where nothing is worse
/// than the points themselves, or where the motion of the points is not known.
pub fn refined(on: &Refine<'_>, side: Side, starts: &Starts) -> Option<Worst> {
    let known = starts.points.first()?.0;
    let found = match side {
        Side::Missing => starts.points.iter().filter_map(|s| on.deepest(s)).reduce(worse),
        Side::Left if starts.raw => None,
        Side::Left => starts.points.iter().take(STARTS_OF_EXCESS).filter_map(|s| on.highest(s)).reduce(worse),
    };
    found.filter(|w| w.depth >= known)
}

fn worse(a: Worst, b: Worst) -> Worst {
    if b.depth > a.depth { b } else { a }
}

/// A place of the lattice: foot on the design, its normal, and the height over it.
#[derive(Clone, Copy)]
struct LatticePoint {
    foot: Point,
    normal: Vector,
    contact: PathContact,
}

impl LatticePoint {
    fn point(&self) -> Point {
        self.foot + self.normal * self.contact.height
    }
}

impl Refine<'_> {
    fn foot(&self, p: &Point) -> Option<(Point, Vector)> {
        let nearest = self.design.nearest(p, f64::INFINITY)?;
        Some((p - nearest.normal * nearest.distance, nearest.normal))
    }

    /// Whether a place lies on the part, and no other face is nearer to it.
    fn counts(&self, place: &LatticePoint) -> bool {
        let (p, height) = (place.point(), place.contact.height);
        let own = || {
            let distance = self.design.signed_distance(&p);
            distance.is_some_and(|d| (d - height).abs() <= OWN[0] * height.abs() + OWN[1])
        };
        self.bounds.contains(&p) && self.region.is_none_or(|r| r.contains(&p)) && own()
    }

    /// The best place about a foot; `sign` is 1 for the highest and -1 for the deepest.
    fn search(
        &self,
        start: &LatticePoint,
        sign: f64,
        height: &dyn Fn(&Point, &Vector, &PathContact) -> Option<PathContact>,
    ) -> LatticePoint {
        let middle = start.foot;
        let mut best = *start;
        let mut step = REACH / f64::from(FIRST) * self.cell;
        let mut half = FIRST;
        while step > END * self.cell {
            let (from, up) = (best.foot, best.normal);
            let least = if up.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
            let u = up.cross(&least).normalize();
            let v = up.cross(&u);
            for i in -half..=half {
                for j in -half..=half {
                    let beside = from + u * (f64::from(i) * step) + v * (f64::from(j) * step);
                    let Some((foot, normal)) = self.foot(&beside) else { continue };
                    if (foot - middle).norm() > 1.5 * REACH * self.cell {
                        continue;
                    }
                    let Some(contact) = height(&foot, &normal, &best.contact) else { continue };
                    let place = LatticePoint { foot, normal, contact };
                    let better = sign * (contact.height - best.contact.height) > EQUAL;
                    if better && self.counts(&place) {
                        best = place;
                    }
                }
            }
            (step, half) = (step * SHRINK, LATER);
        }
        best
    }

    fn worst(place: &LatticePoint) -> Worst {
        Worst { depth: place.contact.height.abs(), point: place.point(), made_by: place.contact.piece }
    }

    fn start(&self, (depth, point, maker): &(f64, Point, u32), sign: f64) -> Option<LatticePoint> {
        let (foot, normal) = self.foot(point)?;
        let from = PathContact { height: sign * depth, piece: *maker, at: f64::NAN };
        let contact = self.path.follow(&from, &foot, &normal)?;
        // Another height than that of the point: the piece is of an earlier run, or no cutter's.
        ((contact.height - sign * depth).abs() <= SAME).then_some(LatticePoint { foot, normal, contact })
    }

    fn deepest(&self, start: &(f64, Point, u32)) -> Option<Worst> {
        let mut start = self.start(start, -1.0)?;
        let followed = |foot: &Point, normal: &Vector, from: &PathContact| self.path.follow(from, foot, normal);
        for _ in 0..AGAIN {
            let best = self.search(&start, -1.0, &followed);
            let near = self.path.near(&best.point(), NEAR);
            let deeper = self.path.lowest_of(&near, &best.foot, &best.normal, best.contact.height);
            let deeper = deeper
                .filter(|c| c.height < best.contact.height - EQUAL)
                .map(|contact| LatticePoint { contact, ..best });
            match deeper.filter(|place| self.counts(place)) {
                Some(place) => start = place,
                None => return Some(Self::worst(&best)),
            }
        }
        Some(Self::worst(&start))
    }

    fn highest(&self, start: &(f64, Point, u32)) -> Option<Worst> {
        let start = self.start(start, 1.0)?;
        // What can come lowest anywhere over the lattice: within its reach of the surface.
        let near = self.path.near(&start.point(), 2.0 * REACH * self.cell);
        let lowest =
            |foot: &Point, normal: &Vector, from: &PathContact| self.path.lowest_of(&near, foot, normal, from.height);
        let own = lowest(&start.foot, &start.normal, &start.contact)?;
        let start = LatticePoint { contact: own, ..start };
        Some(Self::worst(&self.search(&start, 1.0, &lowest)))
    }
}
