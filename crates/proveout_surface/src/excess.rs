//! Material left next to the design, decided on the swept pieces themselves.
//!
//! If a slot, a hole, a chamfer or a cavity of the design is narrower than the cells and was left full, the
//! cut part has no point near its faces. So each face of the design is tested: was the room in front of it
//! cleared?
//!
//! ```text
//!       p = q + (t + e) n          q: sample of the design's surface with its normal n
//!       |                          t: height that is allowed
//!       q                          p lies in the raw stock, p is higher than t above the design, and no
//!    ===+===== design              piece of motion ever came to p: material is left there. It is exact:
//!                                  nothing is searched between rays.
//! ```
//!
//! Samples lie a cell apart, at least one on every face. In a concave edge of the design most material is
//! left where a round cutter cannot go; there the place just higher than t above both faces is tested as
//! well, a cell apart along the edge.
//!
//! **Height.** From a place with material left the search goes along n while nothing was cleared, and then
//! to the sides while the distance from the design grows; the largest distance found is reported.
//!
//! **Missing from the start.** The same places on the other side, `q - (t + e) n` and deeper than t below
//! both faces of a convex edge, show whether the raw stock contained the design: a bar may lack the edges
//! of a block by less than a cell.
//!
//! **When the motion is not enough.** What an earlier run left, or material that fell away without being
//! cut, is known on rays alone. Then a point of a ray next to p, outside of the design and in plain sight
//! of p, decides whether material is there. With no such point in reach the place stays unknown, and its
//! area counts.

use std::{cell::Cell, collections::HashMap};

use proveout_geom::{Aabb, Point, TriMesh, Vector};
use proveout_stock::TriDexel;
use rayon::prelude::*;

use crate::{
    DesignMesh, DesignSurface, Watcher,
    coverage::{each_sample, watcher},
    topography::SweptBodies,
};

/// A place lies higher than allowed by so much, mm.
const BEYOND: f64 = 1e-6;
/// Steps along the normal, each longer than the one before by this factor.
const STEPS: usize = 24;
const LONGER: f64 = 1.3;
/// Rounds of steps to the sides, and places of some faces from which they are made.
const CLIMBS: usize = 14;
const MOST_CLIMBED: usize = 8;
/// An edge is bent when the sine between the normals of its faces is this or more.
const BENT: f64 = 0.1;
/// Faces that fold back on each other, so that their normals sum up to less, have nothing between them.
const FOLDED: f64 = 0.2;
/// Reach of a ray's sight, in cells.
const REACH: f64 = 2.0;
/// Triangles and edges that are worked on at once by a thread.
const AT_ONCE: usize = 64;
/// Places on an edge that are asked at most: the work for a long edge of a fine stock stays bounded.
const MOST_ON_EDGE: f64 = 1e5;
/// Distances from the raw stock are right to this, mm.
const ROUNDING: f64 = 1e-9;
/// An edge goes inward where a corner of the other face lies above this one by more, mm.
const ABOVE: f64 = 1e-9;

/// What is decided.
pub struct Uncut<'a> {
    /// The design, and its tree.
    pub mesh: &'a TriMesh,
    /// The same with its tree.
    pub tree: &'a DesignMesh,
    /// What was swept; none where the motion is not known.
    pub sweeps: Option<&'a SweptBodies>,
    /// How far a place lay outside of the raw stock, mm, negative inside, and never more than its distance
    /// from the skin; none where the raw stock is known on rays alone.
    pub raw: Option<&'a (dyn Fn(&Point) -> f64 + Sync)>,
    /// The rays.
    pub watchers: &'a [Watcher<'a>],
    /// Whether material may be gone that nothing has swept.
    pub fallen: bool,
    /// Only in this box.
    pub region: Option<Aabb>,
    /// Height that is allowed, mm.
    pub allowed: f64,
    /// Depth below the design at which the raw stock may end, mm.
    pub missing: f64,
    /// Material nearer to what was swept may be a sheet too thin for the twin to distinguish from none, mm.
    pub film: f64,
    /// Whether the rays have found material left at a place: nothing is asked there.
    pub known: &'a (dyn Fn(&Point) -> bool + Sync),
}

/// Material that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftMaterial {
    /// Where it is highest above the design, as far as was looked.
    pub point: Point,
    /// Height there, mm.
    pub depth: f64,
    /// Area of the design that it lies on, mm²; none for an edge.
    pub area: f64,
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UncutFound {
    /// In the order of the design's faces.
    pub left: Vec<LeftMaterial>,
    /// Where the raw stock left the design out, with the depth that is missing at least.
    pub missing: Vec<LeftMaterial>,
    /// Area of the design in front of which it is not known whether material is left, mm².
    pub unknown: f64,
    /// A place of it.
    pub at: Option<Point>,
}

/// The state of a place.
enum Occupancy {
    Free,
    Full,
    Unknown,
}

/// The raw stock, asked at places near each other: within the distance of the last place from the skin the
/// side stays the same.
struct RawSide<'a> {
    outside: &'a (dyn Fn(&Point) -> f64 + Sync),
    last: Cell<(Point, f64)>,
}

impl<'a> RawSide<'a> {
    fn new(on: &Uncut<'a>) -> Option<Self> {
        let outside = on.raw?;
        Some(Self { outside, last: Cell::new((Point::origin(), 0.0)) })
    }

    fn contains(&self, p: &Point) -> bool {
        let (near, distance) = self.last.get();
        if (p - near).norm() < distance.abs() - ROUNDING {
            return distance < 0.0;
        }
        let distance = (self.outside)(p);
        self.last.set((*p, distance));
        distance < 0.0
    }
}

/// Decides it.
pub fn uncut(on: &Uncut<'_>) -> UncutFound {
    let count = on.mesh.triangles.len();
    let of_faces: Vec<UncutFound> = (0..count.div_ceil(AT_ONCE))
        .into_par_iter()
        .map(|k| {
            let (mut found, raw) = (UncutFound::default(), RawSide::new(on));
            for t in k * AT_ONCE..count.min((k + 1) * AT_ONCE) {
                each_sample(on.mesh, t, on.watchers, &mut |q, n, area, _| {
                    on.test_front(q, n, [1.0, area], raw.as_ref(), &mut found);
                    on.ask_raw(q, n, [1.0, area], raw.as_ref(), &mut found);
                });
            }
            found
        })
        .collect();
    let edges = edges(on.mesh);
    let of_edges: Vec<UncutFound> = edges
        .par_chunks(AT_ONCE)
        .map(|some| {
            let (mut found, raw) = (UncutFound::default(), RawSide::new(on));
            for edge in some {
                let [a, b] = edge.ends;
                let steps = ((b - a).norm() / on.finest()).ceil().clamp(1.0, MOST_ON_EDGE) as usize;
                for i in 0..steps {
                    let q = a + (b - a) * ((i as f64 + 0.5) / steps as f64);
                    if edge.inward {
                        on.test_front(&q, &edge.outward, [edge.stretch, 0.0], raw.as_ref(), &mut found);
                    } else {
                        on.ask_raw(&q, &edge.outward, [edge.stretch, 0.0], raw.as_ref(), &mut found);
                    }
                }
            }
            found
        })
        .collect();
    let mut out = UncutFound::default();
    for part in of_faces.into_iter().chain(of_edges) {
        out.left.extend(part.left);
        out.missing.extend(part.missing);
        out.unknown += part.unknown;
        out.at = out.at.or(part.at);
    }
    out
}

impl Uncut<'_> {
    fn finest(&self) -> f64 {
        self.watchers.iter().flat_map(|w| w.stock.cells_mm()).fold(f64::INFINITY, f64::min)
    }

    /// Asks in front of a place of the design; `stretch` is the way along n for each millimeter of height.
    fn test_front(
        &self,
        q: &Point,
        n: &Vector,
        [stretch, area]: [f64; 2],
        raw: Option<&RawSide<'_>>,
        found: &mut UncutFound,
    ) {
        let p = q + n * ((self.allowed + BEYOND) * stretch);
        if self.region.is_some_and(|r| !r.contains(&p)) || (self.known)(&p) {
            return;
        }
        match self.occupancy(&p, n, raw) {
            Occupancy::Free => {}
            // In a gap of the design that is no wider than twice the height, or next to another face,
            // nothing is too high.
            _ if self.height(&p) < self.allowed => {}
            Occupancy::Unknown => {
                found.unknown += area;
                found.at = found.at.or(Some(p).filter(|_| area > 0.0));
            }
            Occupancy::Full => {
                let mut best = LeftMaterial { point: p, depth: self.height(&p), area };
                let mut step = self.allowed.max(0.02);
                let mut at = p;
                for _ in 0..STEPS {
                    at += n * step;
                    step *= LONGER;
                    let within = self.region.is_none_or(|r| r.contains(&at));
                    if !within || !matches!(self.occupancy(&at, n, raw), Occupancy::Full) {
                        break;
                    }
                    let height = self.height(&at);
                    if height <= best.depth {
                        break;
                    }
                    best = LeftMaterial { point: at, depth: height, area };
                }
                found.left.push(if found.left.len() < MOST_CLIMBED { self.highest(best, n, raw) } else { best });
            }
        }
    }

    /// Climbs from a place with material left to a higher one next to it.
    fn highest(&self, mut best: LeftMaterial, n: &Vector, raw: Option<&RawSide<'_>>) -> LeftMaterial {
        let mut step = 0.5 * best.depth;
        for _ in 0..CLIMBS {
            let mut higher = false;
            for k in 0..6 {
                let mut at = best.point;
                at[k / 2] += if k % 2 == 0 { step } else { -step };
                let height = self.height(&at);
                let within = self.region.is_none_or(|r| r.contains(&at));
                if height > best.depth && within && matches!(self.occupancy(&at, n, raw), Occupancy::Full) {
                    best = LeftMaterial { point: at, depth: height, ..best };
                    higher = true;
                }
            }
            if !higher {
                step *= 0.5;
            }
        }
        best
    }

    /// Asks below a place of the design whether the raw stock held it.
    fn ask_raw(
        &self,
        q: &Point,
        n: &Vector,
        [stretch, area]: [f64; 2],
        raw: Option<&RawSide<'_>>,
        found: &mut UncutFound,
    ) {
        let Some(raw) = raw else { return };
        let p = q - n * ((self.missing + BEYOND) * stretch);
        let looked_at =
            self.region.is_none_or(|r| r.contains(&p)) && self.watchers.iter().any(|w| w.stock.bounds().contains(&p));
        if looked_at && !raw.contains(&p) && -self.height(&p) > self.missing {
            found.missing.push(LeftMaterial { point: p, depth: -self.height(&p), area });
        }
    }

    fn height(&self, p: &Point) -> f64 {
        self.tree.signed_distance(p).unwrap_or(f64::NEG_INFINITY)
    }

    /// What is known of a place over a face with the normal n.
    fn occupancy(&self, p: &Point, n: &Vector, raw: Option<&RawSide<'_>>) -> Occupancy {
        if raw.is_some_and(|raw| !raw.contains(p)) || !self.watchers.iter().any(|w| w.stock.bounds().contains(p)) {
            return Occupancy::Free;
        }
        let cleared = |s: &SweptBodies| {
            let likely = self.made_near(p, n).is_some_and(|piece| s.reaches(piece, p, self.film));
            likely || s.last_to_reach(p, self.film).is_some()
        };
        if self.sweeps.is_some_and(cleared) {
            return Occupancy::Free;
        }
        if self.sweeps.is_some() && self.raw.is_some() && !self.fallen { Occupancy::Full } else { self.by_rays(p) }
    }

    /// The piece of motion that made the surface next to a place, on the ray that meets it most squarely:
    /// most likely it cleared the place.
    fn made_near(&self, p: &Point, n: &Vector) -> Option<u32> {
        let stock = watcher(self.watchers, p)?.stock;
        let axis = n.iamax();
        let ray = stock.ray_near(axis, p, [0, 0])?;
        let ends = stock.material(&ray).flat_map(|m| [m.lo, m.hi]);
        let near = ends.map(|e| ((e.at - p[axis]).abs(), e.made_by)).filter(|e| e.0 <= stock.cell_mm());
        near.min_by(|a, b| a.0.total_cmp(&b.0))?.1
    }

    /// The nearest point of a ray that lies outside of the design in sight of a place.
    fn by_rays(&self, p: &Point) -> Occupancy {
        let Some(watcher) = watcher(self.watchers, p) else { return Occupancy::Unknown };
        let stock = watcher.stock;
        let mut nearest: Option<(f64, bool)> = None;
        for axis in 0..3 {
            for (di, dj) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
                let Some(ray) = stock.ray_near(axis, p, [di, dj]) else { continue };
                let at = ray.point(p[axis]);
                let apart = (at - p).norm();
                let nearer = apart <= REACH * stock.cell_mm() && nearest.is_none_or(|(d, _)| apart < d);
                if nearer && self.height(&at) > self.allowed && self.tree.is_free(p, &at) {
                    nearest = Some((apart, has_material(stock, axis, &at)));
                }
            }
        }
        match nearest {
            None => Occupancy::Unknown,
            Some((_, true)) => Occupancy::Full,
            Some((_, false)) => Occupancy::Free,
        }
    }
}

fn has_material(stock: &TriDexel, axis: usize, at: &Point) -> bool {
    let Some(ray) = stock.ray_near(axis, at, [0, 0]) else { return false };
    let height = at[axis];
    stock.material(&ray).any(|m| m.lo.at < height && height < m.hi.at)
}

/// An edge at which the design is bent.
struct BentEdge {
    ends: [Point; 2],
    /// Inward, as in the corner of a pocket; else outward.
    inward: bool,
    /// Unit vector between the normals of its faces.
    outward: Vector,
    /// Way along it for each millimeter of distance from both faces.
    stretch: f64,
}

fn edges(mesh: &TriMesh) -> Vec<BentEdge> {
    let mesh = mesh.merge_equal_vertices();
    let mut of_edge: HashMap<(u32, u32), usize> = HashMap::with_capacity(3 * mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            of_edge.insert((triangle[k], triangle[(k + 1) % 3]), t);
        }
    }
    let normal = |t: usize| mesh.area_normal(t).try_normalize(0.0);
    let mut out = Vec::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let Some(&other) = of_edge.get(&(b, a)).filter(|_| a < b) else { continue };
            let (Some(n), Some(m)) = (normal(t), normal(other)) else { continue };
            if n.cross(&m).norm() < BENT && n.dot(&m) > 0.0 {
                continue;
            }
            let Some(outward) = (n + m).try_normalize(FOLDED) else { continue };
            let above = mesh.corners(other).iter().map(|p| (p - corners[k]).dot(&n)).fold(0.0, f64::max);
            out.push(BentEdge {
                ends: [corners[k], corners[(k + 1) % 3]],
                inward: above > ABOVE,
                outward,
                stretch: 1.0 / outward.dot(&n),
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// A walk in small steps through a ball: every answer is that of the ball itself, and few of them ask for
    /// it.
    #[test]
    fn places_near_each_other_ask_the_raw_stock_once() {
        let asked = AtomicUsize::new(0);
        let outside = |p: &Point| {
            asked.fetch_add(1, Ordering::Relaxed);
            p.coords.norm() - 5.0
        };
        let side = RawSide { outside: &outside, last: Cell::new((Point::origin(), 0.0)) };
        let mut inside = 0;
        for k in 0..10_000 {
            let t = f64::from(k) * 1e-3;
            let p = Point::new(7.0 * (0.7 * t).sin(), 6.0 * (1.1 * t).cos(), 2.0 * (2.3 * t).sin());
            assert_eq!(side.contains(&p), p.coords.norm() < 5.0, "{p}");
            inside += usize::from(side.contains(&p));
        }
        assert!((2_000..8_000).contains(&inside), "{inside}");
        assert!(asked.load(Ordering::Relaxed) < 2_000, "{asked:?}");
    }

    /// A mesh that gives no distance for a place holds nothing there, and says nothing about the next place.
    #[test]
    fn an_unknown_distance_says_nothing_about_places_nearby() {
        let outside = |p: &Point| if p.x < 0.0 { f64::NAN } else { -1.0 };
        let side = RawSide { outside: &outside, last: Cell::new((Point::origin(), 0.0)) };
        assert!(!side.contains(&Point::new(-1e-3, 0.0, 0.0)));
        assert!(side.contains(&Point::new(1e-3, 0.0, 0.0)));
    }
}
