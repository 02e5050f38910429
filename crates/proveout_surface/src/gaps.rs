//! A ray of the stock against the design on the same ray: where material is missing, and where it is left.
//!
//! The distance of the points of the cut part from the design (`deviation`) sees nothing of a wall that was
//! milled away: no point of the cut part is left where it stood. So the intervals of design and material are
//! compared on every ray:
//!
//! ```text
//!     design      c0 =========== c1      c0 == c1      c0 ============= c1
//!     material             m0 ===                          ===      =======
//!     gap         c0 ----- m0            c0 -- c1      c0 -            m  m
//!                 partial                full          partial      inner
//! ```
//!
//! **Depth.** A point without material lies as deep inside of the design as its distance from the design's
//! surface. This is exact on the ray and needs nothing but the design: no rounding of a search, no assumption
//! on what lies between rays. So a part within its tolerance never gives a gap deeper than that, at edges and
//! crowns neither: a ray that clips an edge or grazes a crown runs through a long gap whose points are all
//! near the surface. The depth of a gap is that of its deepest point.
//!
//! **Walls.** In a wall of thickness t no point lies deeper than t / 2, even where all of it is gone. There a
//! gap counts with its length square to the face that it starts at, as a caliper reads what is missing: t
//! when it goes through, L |n| from the face n when it ends in the wall. The design is a wall on a ray when
//!
//! * the faces at both ends of its interval look away from each other (the angle between their normals is
//!   above 120 degrees), and
//! * its deepest point lies at least 0.45 t deep, t being the length of the interval square to the face that
//!   meets it more aslant: no other face is near, so that nothing but the wall was taken.
//!
//! The second condition keeps a thin layer that was milled off a block out: its points lie under the top
//! face, far nearer than half the width of the block.
//!
//! **Foils.** A wall no thicker than the tolerance that is gone as a whole lies within the tolerance on
//! each single ray, and so does the tip of a wedge. The caller distinguishes them by their extent
//! ([`Gap::foil`]).
//!
//! Known limits: material between two rays of a set is not seen where the others do not see it either: see
//! `coverage`.

use proveout_geom::Vector;
use proveout_stock::{RayPlace, RaySpan};

use crate::DesignSurface;

/// Cosine of the angle between the normals of two faces that look away from each other.
const AWAY: f64 = -0.5;
/// Part of its thickness that the deepest point of a wall lies deep at least.
const WALL: f64 = 0.45;
/// A gap whose length square to the face is at most so much longer than its end is deep is no wall's.
const PLAIN: f64 = 1.1;
/// Lengths that are none, mm: as the stock rounds.
const SLIVER: f64 = 2e-7;
/// Points of a gap at which its depth is asked for, before the best is refined; odd, so that the middle is
/// one.
const LOOKS: usize = 9;
/// Halvings by the golden section.
const REFINE: usize = 12;

/// What counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapSettings {
    /// Missing material deeper than this counts, mm.
    pub missing: f64,
    /// Material left higher than this counts, mm.
    pub left: f64,
    /// Below this no deviation can be resolved, mm: error of design and stock.
    pub floor: f64,
}

/// Which side of the design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Inside of the design without material.
    Missing,
    /// Material outside of the design.
    Left,
}

/// One end of a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GapEnd {
    /// On the surface of the design, with its outward normal.
    Design(Vector),
    /// On the surface of the cut part: number of the end of material on the ray, counted from below.
    Cut(usize),
}

/// A stretch of a ray that is deeper (or higher) than allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Which side.
    pub side: Side,
    /// Heights of its ends on the ray, mm.
    pub at: [f64; 2],
    /// What they are.
    pub ends: [GapEnd; 2],
    /// Depth or height, mm.
    pub depth: f64,
    /// Height of its worst point on the ray, mm.
    pub worst: f64,
    /// Thickness of the wall that is gone on this ray, mm.
    pub wall: Option<f64>,
    /// Not deeper than allowed, but all of a wall.
    pub foil: bool,
}

/// A ray as it is compared.
#[derive(Clone, Copy, Debug)]
pub struct OnRay<'a> {
    /// The ray.
    pub place: &'a RayPlace,
    /// Material of the cut part, rising.
    pub material: &'a [RaySpan],
    /// The design, rising.
    pub design: &'a [RaySpan],
    /// Signed deviation at each end of the material, two an interval, mm; NaN where it does not count.
    pub deviations: &'a [f64],
}

/// Finds the gaps of a ray that count. `solid` gives signed distances to the design whose intervals these
/// are; `counts` returns whether a height on the ray is judged.
pub fn gaps(
    ray: &OnRay<'_>,
    solid: &(impl DesignSurface + ?Sized),
    settings: &GapSettings,
    counts: &dyn Fn(f64) -> bool,
    out: &mut Vec<Gap>,
) {
    for d in ray.design {
        missing_gaps(ray, d, solid, settings, counts, out);
    }
    left_gaps(ray, settings, out);
}

/// Gaps within one interval of the design.
fn missing_gaps(
    ray: &OnRay<'_>,
    d: &RaySpan,
    solid: &(impl DesignSurface + ?Sized),
    settings: &GapSettings,
    counts: &dyn Fn(f64) -> bool,
    out: &mut Vec<Gap>,
) {
    let judge = Judge { ray, d, solid, settings, counts };
    let mut from = (d.lo.at, GapEnd::Design(d.lo.normal));
    for (k, m) in ray.material.iter().enumerate() {
        if m.hi.at <= from.0 {
            continue;
        }
        if m.lo.at >= d.hi.at {
            break;
        }
        if m.lo.at - from.0 > SLIVER {
            out.extend(judge.gap(from, (m.lo.at, GapEnd::Cut(2 * k))));
        }
        from = (m.hi.at, GapEnd::Cut(2 * k + 1));
    }
    if d.hi.at - from.0 > SLIVER {
        out.extend(judge.gap(from, (d.hi.at, GapEnd::Design(d.hi.normal))));
    }
}

struct Judge<'a, D: ?Sized> {
    ray: &'a OnRay<'a>,
    d: &'a RaySpan,
    solid: &'a D,
    settings: &'a GapSettings,
    counts: &'a dyn Fn(f64) -> bool,
}

impl<D: DesignSurface + ?Sized> Judge<'_, D> {
    /// How deep a height of the ray lies inside of the design, mm.
    fn inside(&self, at: f64) -> f64 {
        self.solid.signed_distance(&self.ray.place.point(at)).map_or(0.0, |d| -d)
    }

    /// Depth of an end on the cut part.
    fn own_depth(&self, at: f64, end: usize) -> f64 {
        let known = self.ray.deviations.get(end).copied().filter(|d| d.is_finite());
        known.map_or_else(|| self.inside(at), |d| -d)
    }

    /// Deepest point between two heights: depth and place.
    fn deepest(&self, [lo, hi]: [f64; 2], counted: bool) -> (f64, f64) {
        let step = (hi - lo) / (LOOKS + 1) as f64;
        let depth = |at: f64| if counted && !(self.counts)(at) { f64::NEG_INFINITY } else { self.inside(at) };
        let mut best = (f64::NEG_INFINITY, 0.5 * (lo + hi));
        for k in 1..=LOOKS {
            let at = lo + k as f64 * step;
            let found = depth(at);
            if found > best.0 {
                best = (found, at);
            }
        }
        // Golden section round the best (Kiefer 1953).
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut a, mut b) = (best.1 - step, best.1 + step);
        for _ in 0..REFINE {
            let (x, y) = (b - ratio * (b - a), a + ratio * (b - a));
            let (fx, fy) = (depth(x), depth(y));
            for (found, at) in [(fx, x), (fy, y)] {
                if found > best.0 {
                    best = (found, at);
                }
            }
            if fx >= fy { b = y } else { a = x }
        }
        best
    }

    /// Thickness of the design on this ray where it is a wall.
    fn wall(&self) -> Option<f64> {
        let (n, m) = (&self.d.lo.normal, &self.d.hi.normal);
        if n.dot(m) > AWAY {
            return None;
        }
        let axis = self.ray.place.axis;
        let thickness = (self.d.hi.at - self.d.lo.at) * n[axis].abs().min(m[axis].abs());
        (self.deepest([self.d.lo.at, self.d.hi.at], false).0 >= WALL * thickness).then_some(thickness)
    }

    fn gap(&self, (lo, low): (f64, GapEnd), (hi, high): (f64, GapEnd)) -> Option<Gap> {
        let (limit, floor) = (self.settings.missing, self.settings.floor);
        let length = hi - lo;
        let found = |depth: f64, worst: f64, wall: Option<f64>| {
            (depth > limit).then_some(Gap {
                side: Side::Missing,
                at: [lo, hi],
                ends: [low, high],
                depth,
                worst,
                wall,
                foil: false,
            })
        };
        if !(self.counts)(lo) && !(self.counts)(hi) && !(self.counts)(0.5 * (lo + hi)) {
            return None;
        }
        match (low, high) {
            (GapEnd::Design(n), GapEnd::Design(m)) => {
                let axis = self.ray.place.axis;
                let square = length * n[axis].abs().min(m[axis].abs());
                if length <= limit && (square <= 2.0 * floor || n.dot(&m) > AWAY) {
                    return None;
                }
                let wall = if square > 2.0 * floor { self.wall() } else { None };
                if let Some(t) = wall {
                    if t > limit {
                        return found(t, lo, wall);
                    }
                    let foil = Gap {
                        side: Side::Missing,
                        at: [lo, hi],
                        ends: [low, high],
                        depth: t,
                        worst: lo,
                        wall,
                        foil: true,
                    };
                    return Some(foil);
                }
                let (depth, worst) = self.deepest([lo, hi], true);
                found(depth, worst, None)
            }
            (GapEnd::Design(n), GapEnd::Cut(k)) | (GapEnd::Cut(k), GapEnd::Design(n)) => {
                let (face, end) = if matches!(low, GapEnd::Design(_)) { (lo, hi) } else { (hi, lo) };
                let square = length * n[self.ray.place.axis].abs();
                let own = self.own_depth(end, k);
                if square <= limit && own <= limit {
                    return None;
                }
                if square <= PLAIN * own + floor {
                    return found(own, end, None);
                }
                if let Some(t) = self.wall() {
                    let depth = square.min(t);
                    return if depth > own { found(depth, face, None) } else { found(own, end, None) };
                }
                let (depth, worst) = self.deepest([lo, hi], true);
                if depth > own { found(depth, worst, None) } else { found(own, end, None) }
            }
            (GapEnd::Cut(j), GapEnd::Cut(k)) => {
                let (below, above) = (self.own_depth(lo, j), self.own_depth(hi, k));
                let own = if below >= above { (below, lo) } else { (above, hi) };
                // No point of the gap lies deeper than its ends by more than half its length.
                if own.0 + 0.5 * length <= limit {
                    return None;
                }
                let (depth, worst) = self.deepest([lo, hi], true);
                if depth > own.0 { found(depth, worst, None) } else { found(own.0, own.1, None) }
            }
        }
    }
}

/// Material outside of the design that ends higher than allowed.
fn left_gaps(ray: &OnRay<'_>, settings: &GapSettings, out: &mut Vec<Gap>) {
    for (k, m) in ray.material.iter().enumerate() {
        let deviation = |end: usize| ray.deviations.get(2 * k + end).copied().filter(|d| *d > settings.left);
        if deviation(0).is_none() && deviation(1).is_none() {
            continue;
        }
        let mut from = (m.lo.at, GapEnd::Cut(2 * k));
        let mut put = |(lo, low): (f64, GapEnd), (hi, high): (f64, GapEnd)| {
            let ends = [(low, lo, deviation(0)), (high, hi, deviation(1))];
            let over = ends.iter().filter(|e| matches!(e.0, GapEnd::Cut(_))).filter_map(|e| Some((e.2?, e.1)));
            if let Some((depth, worst)) = over.reduce(|a, b| if b.0 > a.0 { b } else { a }) {
                out.push(Gap {
                    side: Side::Left,
                    at: [lo, hi],
                    ends: [low, high],
                    depth,
                    worst,
                    wall: None,
                    foil: false,
                });
            }
        };
        for d in ray.design {
            if d.hi.at <= from.0 {
                continue;
            }
            if d.lo.at >= m.hi.at {
                break;
            }
            if d.lo.at - from.0 > SLIVER {
                put(from, (d.lo.at, GapEnd::Design(d.lo.normal)));
            }
            from = (d.hi.at, GapEnd::Design(d.hi.normal));
        }
        if m.hi.at - from.0 > SLIVER {
            put(from, (m.hi.at, GapEnd::Cut(2 * k + 1)));
        }
    }
}
