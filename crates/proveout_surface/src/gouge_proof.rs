//! Gouges between the rays, decided on the swept pieces themselves.
//!
//! Rays meet a convex edge of the design nowhere, and a groove narrower than the cells may run between them.
//! Whether a piece of motion went deeper into the design than allowed is decided without rays. The depth of a
//! place is its distance from the surface of the design, as on the rays (`gaps`): a place p of a swept piece
//! S that lies deeper than t in the design D is a gouge.
//!
//! **Moved out.** In a box B, let a shift d of length |d| <= t move S so that no face of the design crosses
//! it:
//!
//! ```text
//!        S     .-------.             p in S and B. If p + d lies outside of D, the straight way from p to
//!              |   S   |             p + d leaves D, so that p is no deeper than |d| <= t.
//!     --.......|.......|......  -t
//!       |  D   '-------'             S is convex, and so is the box: S and B, moved, lies as a whole
//!       |                            inside or outside of D when no face crosses it. One point tells which.
//! ```
//!
//! S lies in the half space `n . x >= least(n)` for any n. Moved by `d = t n` it keeps clear of every face in
//! the box (widened by t) that lies below `least(n) + t`: one direction n does for flat and bent faces and
//! for convex edges, since a gouge there must pass all of the faces that meet. In a concave edge or corner
//! the faces fall into groups with normals `n_k`, and the shortest d with `n_k . d >= top_k - least(n_k)` for
//! all k is asked.
//!
//! **Boxes.** A box in which some piece cannot be moved out is halved, down to a small part of t. Boxes whose
//! points are all less deep than t, pieces that do not reach into a box, and boxes outside of the design drop
//! out. If the middle of a box, or the point of a piece next to it, lies deeper than t, the gouge is found.
//! The search then raises t to 1.3 times the known depth and continues for a few boxes. In the deepest blocks
//! it climbs in shrinking steps to the deepest point. A face mill on a flat face is decided in one box, a
//! ball in a fillet in boxes of `sqrt(8 R t)`.
//!
//! **Result.** Gouges deeper than the allowed depth by more than [`Overcut::grain`] are found; nothing less
//! deep than the allowed depth is reported. Boxes that stay undecided (the search took too long) are
//! reported with place and size.

use std::cell::{Cell, OnceCell};

use proveout_geom::{Aabb, Point, TriMesh, Vector};
use rayon::prelude::*;

use crate::{
    DesignMesh, DesignSurface, NearestOnDesign,
    topography::{SweepItem, SweptBodies},
    worst_place::Worst,
};

/// Largest number of faces of a box for which pieces are checked against it; with more it is halved first.
const MOST_FACES: usize = 256;
/// So many pieces are tried in a box larger than a block before it counts how many of them are cleared.
const TRIED_IN_LARGE: u32 = 16;
/// Directions that are tried.
const ASPECTS: usize = 6;
/// Cosine of the angle within which the normals of faces count as one direction.
const ALIKE: f64 = 0.9;
/// The deepest place of each block is known to this part of its depth, and mm.
const DEEP: [f64; 2] = [0.3, 1e-4];
/// In so many of the deepest blocks the way to the deepest place is climbed.
const CLIMBED: usize = 16;
/// Pieces that are looked at in a climb, its last step, mm, and the most places it asks.
const NEAREST: usize = 6;
const LAST_STEP: f64 = 1e-4;
const MOST_PLACES: usize = 1_200;
/// Blocks that are decided at once, and boxes in a block.
const AT_ONCE: usize = 256;
const MOST_BOXES: usize = 20_000;
/// The same once a gouge is found.
const MOST_BOXES_DEEPER: usize = 40;
/// Halvings in parallel: 2^12 boxes.
const PARALLEL: u32 = 12;
/// A point that is looked at lies this deep in a piece, mm, so that rounding does not put it outside.
const BELOW_FACE: f64 = 1e-7;
/// The same in a box whose middle lies outside of the piece, mm.
const BELOW_MIDDLE: f64 = 1e-6;
/// Shorter parts of directions, both of length 1, are made of rounding.
const SHORTEST: f64 = 1e-9;
/// Area that a face has at least where normals are weighed by area, mm^2: one without area has a normal too.
const LEAST_AREA: f64 = 1e-12;
/// Weighed normals whose sum is shorter have no mean, mm^2.
const NO_MEAN: f64 = 1e-12;
/// A shift may fall short of a length that is asked by this, mm: rounding of the normal equations.
const SHORT: f64 = 1e-9;
/// Square of the sine of the angle between two normals below which they bind as one.
const ONE_NORMAL: f64 = 1e-6;
/// Volume between three unit normals below which they meet in no point that is known.
const NO_CORNER: f64 = 1e-3;
/// A plane passes a box by where it is farther from it than this, mm: rounding.
const PASSES: f64 = 1e-9;

/// What is decided.
pub struct Overcut<'a> {
    /// The design, and its tree.
    pub mesh: &'a TriMesh,
    /// The same with its tree.
    pub tree: &'a DesignMesh,
    /// What was swept.
    pub sweeps: &'a SweptBodies,
    /// Only in this box.
    pub bounds: Aabb,
    /// Depth that is allowed, mm.
    pub allowed: f64,
    /// A gouge that is deeper than allowed by so much is found, mm.
    pub grain: f64,
    /// Edge of the blocks of which each has one worst place, mm.
    pub block: f64,
    /// Whether the rays have found a gouge at a place: nothing is searched there.
    pub known: &'a (dyn Fn(&Point) -> bool + Sync),
    /// Boxes that are looked at in all before the search is given up.
    pub most_boxes: usize,
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overcuts {
    /// The worst place of each block with a gouge, in the order of the blocks.
    pub found: Vec<Worst>,
    /// Blocks that stayed undecided.
    pub undecided: usize,
    /// One of them: its middle.
    pub at: Option<Point>,
    /// Boxes that were looked at.
    pub boxes: usize,
}

/// A triangle made ready.
struct ReadyTriangle {
    corners: [Point; 3],
    normal: Vector,
}

/// A box with what is near.
struct ProofBox {
    bounds: Aabb,
    faces: Vec<u32>,
    items: Vec<SweepItem>,
}

impl ProofBox {
    fn copy(&self) -> Self {
        Self { bounds: self.bounds, faces: self.faces.clone(), items: self.items.clone() }
    }
}

/// A direction in which pieces may be moved out of a box.
struct Aspect {
    normal: Vector,
    /// Highest point of all faces in the widened box along it, and of those that look this way.
    top: f64,
    own: f64,
}

/// The corners of a widened box: whether each lies outside of the design, looked up once and only when it is
/// asked for.
struct BoxCorners<'a> {
    tree: &'a DesignMesh,
    bounds: Aabb,
    outside: [Cell<Option<bool>>; 8],
}

impl<'a> BoxCorners<'a> {
    fn of(tree: &'a DesignMesh, bounds: Aabb) -> Self {
        Self { tree, bounds, outside: Default::default() }
    }

    /// Whether the corner that lies highest along a direction is outside.
    fn is_highest_outside(&self, n: &Vector) -> bool {
        let number = (0..3).map(|k| usize::from(n[k] > 0.0) << k).sum::<usize>();
        let outside = &self.outside[number];
        let known = outside.get().unwrap_or_else(|| {
            self.tree.signed_distance(&corner(&self.bounds, n)).is_some_and(|distance| distance >= 0.0)
        });
        outside.set(Some(known));
        known
    }
}

/// The middle of a box: where the surface of the design is from there, looked up once and only when it is
/// asked for.
struct Middle<'a> {
    tree: &'a DesignMesh,
    point: Point,
    nearest: OnceCell<Option<NearestOnDesign>>,
}

impl<'a> Middle<'a> {
    fn of(tree: &'a DesignMesh, bounds: &Aabb) -> Self {
        Self { tree, point: bounds.center(), nearest: OnceCell::new() }
    }

    fn nearest(&self) -> Option<&NearestOnDesign> {
        self.nearest.get_or_init(|| self.tree.nearest(&self.point, f64::INFINITY)).as_ref()
    }

    /// Depth in the design, mm.
    fn depth(&self) -> Option<f64> {
        self.nearest().map(|n| -n.distance)
    }
}

/// Decides it.
pub fn overcuts(on: &Overcut<'_>) -> Overcuts {
    let mut out = Overcuts::default();
    let Some(root) = on.sweeps.root() else { return out };
    if on.bounds.is_empty() {
        return out;
    }
    let count = on.mesh.triangles.len();
    let faces: Vec<ReadyTriangle> = (0..count)
        .map(|t| ReadyTriangle {
            corners: on.mesh.corners(t),
            normal: on.mesh.area_normal(t).try_normalize(0.0).unwrap_or_default(),
        })
        .collect();
    let search = GougeSearch { on, faces: &faces, limit: on.allowed + on.grain };
    let whole = ProofBox { bounds: on.bounds, faces: (0..count as u32).collect(), items: vec![root] };
    let blocks = search.blocks(whole, PARALLEL);
    out.boxes = blocks.len();
    let mut found: Vec<(Worst, &ProofBox)> = Vec::new();
    for some in blocks.chunks(AT_ONCE) {
        if out.boxes > on.most_boxes {
            out.undecided += some.len();
            out.at = out.at.or(some.first().map(|b| b.bounds.center()));
            continue;
        }
        let of_blocks: Vec<BlockResult> = some.par_iter().map(|b| search.block(b)).collect();
        for (block, place) in of_blocks.into_iter().zip(some) {
            out.boxes += block.boxes;
            if let Some(best) = block.best {
                found.push((best, place));
            }
            out.undecided += usize::from(block.open.is_some() && block.best.is_none());
            out.at = out.at.or(block.open.filter(|_| block.best.is_none()));
        }
    }
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|&i, &j| found[j].0.depth.total_cmp(&found[i].0.depth).then(i.cmp(&j)));
    order.truncate(CLIMBED);
    let deeper: Vec<Worst> = order.par_iter().map(|&i| search.climb_to_deepest(found[i].1, found[i].0)).collect();
    for (i, worst) in order.into_iter().zip(deeper) {
        found[i].0 = worst;
    }
    out.found = found.into_iter().map(|f| f.0).collect();
    out
}

/// What one block gives.
#[derive(Default)]
struct BlockResult {
    best: Option<Worst>,
    open: Option<Point>,
    boxes: usize,
}

struct GougeSearch<'a> {
    on: &'a Overcut<'a>,
    faces: &'a [ReadyTriangle],
    /// What is deeper counts, mm.
    limit: f64,
}

fn longest(bounds: &Aabb) -> usize {
    let size = bounds.size();
    (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best })
}

fn halves(bounds: &Aabb) -> [Aabb; 2] {
    let k = longest(bounds);
    let (mut low, mut high) = (*bounds, *bounds);
    let middle = 0.5 * (bounds.min[k] + bounds.max[k]);
    (low.max[k], high.min[k]) = (middle, middle);
    [low, high]
}

/// Highest corner of a box along a direction.
fn corner(bounds: &Aabb, n: &Vector) -> Point {
    let at = |k: usize| if n[k] > 0.0 { bounds.max[k] } else { bounds.min[k] };
    Point::new(at(0), at(1), at(2))
}

impl GougeSearch<'_> {
    /// The blocks in which some piece is not moved out, in order.
    fn blocks(&self, mut place: ProofBox, parallel: u32) -> Vec<ProofBox> {
        let middle = Middle::of(self.on.tree, &place.bounds);
        self.keep_near(&mut place, self.limit);
        // Without a face a box lies inside or outside as a whole; outside no point is deeper than the limit.
        // With one it is as good as never shallow enough, and the surface need not be looked up.
        let half = 0.5 * place.bounds.size().norm();
        if place.faces.is_empty() && middle.depth().unwrap_or(f64::NEG_INFINITY) + half < self.limit {
            return Vec::new();
        }
        let box_corners = BoxCorners::of(self.on.tree, place.bounds.expanded(self.limit));
        self.drop_cleared(&mut place, (&middle, &box_corners), self.limit);
        if place.items.is_empty() {
            return Vec::new();
        }
        if place.bounds.size().max() <= self.on.block {
            return vec![place];
        }
        let of_half = |bounds: Aabb| ProofBox { bounds, ..place.copy() };
        let [low, high] = halves(&place.bounds).map(of_half);
        drop(place);
        let (mut blocks, more) = if parallel > 0 {
            rayon::join(|| self.blocks(low, parallel - 1), || self.blocks(high, parallel - 1))
        } else {
            (self.blocks(low, 0), self.blocks(high, 0))
        };
        blocks.extend(more);
        blocks
    }

    /// The worst place of a block.
    fn block(&self, place: &ProofBox) -> BlockResult {
        let mut out = BlockResult::default();
        if !(self.on.known)(&place.bounds.center()) {
            self.search(place.copy(), &mut out);
        }
        out
    }

    /// Climbs from a gouge to the deepest point in its block or a neighboring one. Every step ends inside a
    /// swept piece, so the depth was really cut.
    fn climb_to_deepest(&self, place: &ProofBox, known: Worst) -> Worst {
        let (sweeps, bounds) = (self.on.sweeps, place.bounds.expanded(self.on.block));
        let mut groups = place.items.clone();
        let mut near: Vec<(f64, SweepItem)> = Vec::new();
        while let Some(item) = groups.pop() {
            if !sweeps.bounds(item).intersects(&bounds) {
                continue;
            }
            match sweeps.distance(item, &known.point) {
                Some(there) => near.push((there.distance, item)),
                None => groups.extend(sweeps.members(item)),
            }
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(NEAREST);
        let nearest = |p: &Point| {
            let of = |item: SweepItem| sweeps.distance(item, p).map(|d| (d, item));
            let all = near.iter().filter_map(|(_, item)| of(*item));
            all.min_by(|a, b| a.0.distance.total_cmp(&b.0.distance))
        };
        let at = |p: &Point| {
            let (there, item) = nearest(p)?;
            let error = sweeps.distance_error(item);
            let out = (there.distance + 1.5 * error + BELOW_FACE).max(0.0);
            let inside = p - there.normal * out;
            self.gouge_at(item, &inside).filter(|_| bounds.contains(&inside))
        };
        let mut best = known;
        let mut step = 0.25 * bounds.size().max();
        let mut asked = 0;
        while step > LAST_STEP && asked < MOST_PLACES {
            let mut ways: Vec<Vector> = (0..27)
                .filter(|k| *k != 13)
                .map(|k: i32| Vector::new(f64::from(k % 3 - 1), f64::from(k / 3 % 3 - 1), f64::from(k / 9 - 1)))
                .collect();
            // Away from the nearest face along the skin of the piece, and along both.
            if let (Some(face), Some((piece, _))) =
                (self.on.tree.nearest(&best.point, f64::INFINITY), nearest(&best.point))
            {
                let (down, out) = (-face.normal, piece.normal);
                ways.extend([down, down - out * out.dot(&down), down.cross(&out), out.cross(&down)]);
            }
            asked += ways.len();
            let steps = ways.into_iter().filter_map(|way| way.try_normalize(SHORTEST));
            let tried = steps.filter_map(|way| at(&(best.point + way * step)));
            match tried.max_by(|a, b| a.depth.total_cmp(&b.depth)).filter(|w| w.depth > best.depth) {
                Some(deeper) => best = deeper,
                None => step *= 0.5,
            }
        }
        best
    }

    fn search(&self, mut place: ProofBox, out: &mut BlockResult) {
        out.boxes += 1;
        let limit = out.best.map_or(self.limit, |b| (b.depth * (1.0 + DEEP[0]) + DEEP[1]).max(self.limit));
        let middle = Middle::of(self.on.tree, &place.bounds);
        let (center, half) = (middle.point, 0.5 * place.bounds.size().norm());
        let box_corners = BoxCorners::of(self.on.tree, place.bounds.expanded(limit));
        // The first box of a block comes from `blocks`, which has done this.
        if out.boxes > 1 {
            self.keep_near(&mut place, limit);
            self.drop_cleared(&mut place, (&middle, &box_corners), limit);
        }
        // The surface is looked up only for boxes that some piece reaches and is not moved out of: the lookup
        // costs more than all else in a box.
        let is_shallow = || middle.depth().is_none_or(|depth| depth + half < limit);
        let known = self.on.allowed.max(out.best.map_or(0.0, |b| b.depth));
        let mut is_middle_open = true;
        let (sweeps, widened) = (self.on.sweeps, box_corners.bounds);
        let smallest = half < 0.2 * self.on.grain;
        let corners = OnceCell::new();
        let faces = &place.faces;
        let kept = place.items.iter().copied().filter(|item| {
            let error = sweeps.distance_error(*item);
            let Some(near) = sweeps.distance_within(*item, &center, half + error) else { return true };
            if near.distance > half + error {
                return false;
            }
            if is_middle_open && near.distance < -error {
                if is_shallow() {
                    return false;
                }
                if let Some(depth) = middle.depth().filter(|depth| *depth > known) {
                    let made_by = sweeps.piece(*item).unwrap_or(u32::MAX);
                    out.best = Some(Worst { depth, point: center, made_by });
                    is_middle_open = false;
                }
            }
            // Along the normal of the cutter where it is nearest.
            let n = -near.normal;
            let corners: &Vec<Point> = corners.get_or_init(|| self.corners(faces, &widened));
            let top = corners.iter().map(|p| p.coords.dot(&n)).fold(f64::NEG_INFINITY, f64::max);
            let level = sweeps.least(*item, &n) + limit;
            let highest = corner(&widened, &n);
            let is_clear = highest.coords.dot(&n) <= level || box_corners.is_highest_outside(&n);
            let is_kept = !(top <= level && is_clear);
            if is_kept && is_shallow() {
                return false;
            }
            if is_kept && out.best.is_none() {
                // The middle of the box may lie just outside of the piece: try the nearest points inside it.
                let into = |way: f64| center + n * (near.distance + way + 1.1 * error).max(0.0);
                out.best =
                    self.gouge_at(*item, &into(BELOW_MIDDLE)).or_else(|| self.gouge_at(*item, &into(0.5 * half)));
            }
            is_kept
        });
        place.items = kept.collect();
        if place.items.is_empty() || is_shallow() {
            return;
        }
        // A depth that is known is climbed from.
        let most = if out.best.is_some() { MOST_BOXES_DEEPER } else { MOST_BOXES };
        if smallest || out.boxes > most {
            out.open = out.open.or(Some(center));
            return;
        }
        let [low, high] = halves(&place.bounds);
        self.search(ProofBox { bounds: low, ..place.copy() }, out);
        self.search(ProofBox { bounds: high, ..place }, out);
    }

    /// A place in a piece that is deeper than allowed.
    fn gouge_at(&self, item: SweepItem, p: &Point) -> Option<Worst> {
        let (sweeps, on) = (self.on.sweeps, self.on);
        let is_inside = sweeps.distance(item, p).is_some_and(|near| near.distance < -sweeps.distance_error(item));
        let depth = on.tree.signed_distance(p).map(|d| -d).filter(|depth| *depth > on.allowed)?;
        (is_inside && on.bounds.contains(p)).then(|| Worst {
            depth,
            point: *p,
            made_by: sweeps.piece(item).unwrap_or(u32::MAX),
        })
    }

    /// Leaves in a box the pieces and faces that are near it.
    fn keep_near(&self, place: &mut ProofBox, limit: f64) {
        place.items.retain(|i| self.on.sweeps.bounds(*i).intersects(&place.bounds));
        if !place.items.is_empty() {
            let widened = place.bounds.expanded(limit);
            place.faces.retain(|f| touches(&self.faces[*f as usize], &widened));
        }
    }

    /// Leaves in a box that holds what is near the pieces that are not moved out by `limit`.
    fn drop_cleared(&self, place: &mut ProofBox, (middle, box_corners): (&Middle<'_>, &BoxCorners<'_>), limit: f64) {
        let (sweeps, bounds) = (self.on.sweeps, place.bounds);
        if place.items.is_empty() {
            return;
        }
        let few = place.faces.len() <= MOST_FACES;
        let mut aspects = if few { self.aspects(&place.faces, &box_corners.bounds) } else { Vec::new() };
        let size = bounds.size().max();
        if aspects.is_empty() && (few || size <= self.on.block) {
            aspects.extend(toward_surface(middle));
        }
        let highest: Vec<f64> = aspects.iter().map(|a| corner(&bounds, &a.normal).coords.dot(&a.normal)).collect();
        // The direction that was enough for the last piece mostly is for the next.
        let mut likely = 0;
        let mut left = Vec::new();
        let mut asked: Vec<SweepItem> = std::mem::take(&mut place.items);
        asked.reverse();
        let (mut tried, mut cleared) = (0_u32, 0_u32);
        while let Some(item) = asked.pop() {
            // Where hardly any piece is cleared from a large box, its halves decide.
            let in_vain = size > self.on.block && tried >= TRIED_IN_LARGE && 4 * cleared < tried;
            if !in_vain {
                tried += 1;
                if self.moves_out(item, box_corners, (&aspects, &highest), &mut likely, limit)
                    || self.is_separated(item, &bounds)
                {
                    cleared += 1;
                    continue;
                }
            }
            // A group stays one as long as its bodies are less apart than the box is long. Within a block
            // only single pieces can show a gouge, and bodies at rest are not apart at all.
            if item.is_single() || size > self.on.block && sweeps.extent(item) < size {
                left.push(item);
            } else {
                asked.extend(sweeps.members(item).rev().filter(|i| sweeps.bounds(*i).intersects(&bounds)));
            }
        }
        place.items = left;
    }

    /// Corners of the faces as far as they lie in a box.
    fn corners(&self, faces: &[u32], bounds: &Aabb) -> Vec<Point> {
        let mut out = Vec::new();
        faces.iter().for_each(|f| out.extend(clipped(&self.faces[*f as usize].corners, bounds)));
        out
    }

    /// The directions of the faces in a box.
    fn aspects(&self, faces: &[u32], widened: &Aabb) -> Vec<Aspect> {
        let mut sums: Vec<(Vector, Vector)> = Vec::new();
        let mut parts: Vec<(usize, Vec<Point>)> = Vec::with_capacity(faces.len());
        for f in faces {
            let face = &self.faces[*f as usize];
            let polygon = clipped(&face.corners, widened);
            if polygon.is_empty() || face.normal == Vector::zeros() {
                continue;
            }
            let alike = sums.iter().position(|(n, _)| n.dot(&face.normal) > ALIKE);
            let index = alike.unwrap_or(sums.len());
            if index == sums.len() {
                sums.push((face.normal, Vector::zeros()));
            }
            let from = polygon[0];
            let area: f64 = polygon.windows(2).map(|w| (w[0] - from).cross(&(w[1] - from)).norm()).sum();
            sums[index].1 += face.normal * (area + LEAST_AREA);
            parts.push((index, polygon));
        }
        let mean: Vector = sums.iter().map(|s| s.1).sum();
        let mut normals: Vec<Vector> =
            sums.iter().map(|(first, sum)| sum.try_normalize(0.0).unwrap_or(*first)).collect();
        if normals.len() > 1 && normals.len() < ASPECTS {
            normals.extend(mean.try_normalize(NO_MEAN));
        }
        let top = |n: &Vector, only: Option<usize>| {
            let of = parts.iter().filter(|(k, _)| only.is_none_or(|o| o == *k)).flat_map(|(_, p)| p);
            of.map(|p| p.coords.dot(n)).fold(f64::NEG_INFINITY, f64::max)
        };
        let groups = sums.len();
        let aspect = |(k, normal): (usize, Vector)| Aspect {
            normal,
            top: top(&normal, None),
            own: if k < groups { top(&normal, Some(k)) } else { f64::NEG_INFINITY },
        };
        normals.into_iter().take(4 * ASPECTS).enumerate().map(aspect).collect()
    }

    /// Whether a plane between a box and a cutter proves that the piece does not reach into the box. The
    /// boxes of long cutters that lean are much larger than the cutters.
    fn is_separated(&self, item: SweepItem, bounds: &Aabb) -> bool {
        let toward = self.on.sweeps.toward(item, &bounds.center());
        toward.is_some_and(|n| corner(bounds, &n).coords.dot(&n) < self.on.sweeps.least(item, &n))
    }

    /// Whether a shift of `limit` or less proves that a piece is nowhere deeper in the box; `highest` has the
    /// highest point of the box along each direction, and `likely` is the number of the direction that is
    /// tried first.
    fn moves_out(
        &self,
        item: SweepItem,
        box_corners: &BoxCorners<'_>,
        (aspects, highest): (&[Aspect], &[f64]),
        likely: &mut usize,
        limit: f64,
    ) -> bool {
        let mut least = [0.0; 4 * ASPECTS];
        let first = (*likely).min(aspects.len());
        for k in (first..aspects.len()).chain(0..first) {
            let aspect = &aspects[k];
            least[k] = self.on.sweeps.least(item, &aspect.normal);
            // It does not reach into the box at all, or all faces lie below it.
            if highest[k] < least[k] || aspect.top <= least[k] + limit && box_corners.is_highest_outside(&aspect.normal)
            {
                *likely = k;
                return true;
            }
        }
        // Every group of faces has a direction of its own, and lies below the piece along that one.
        let groups = aspects.iter().take_while(|a| a.own > f64::NEG_INFINITY).count();
        if !(2..=4).contains(&groups) {
            return false;
        }
        let asked: Vec<(Vector, f64)> = (0..groups).map(|k| (aspects[k].normal, aspects[k].own - least[k])).collect();
        let Some(shift) = least_shift(&asked).filter(|d| d.norm() <= limit) else { return false };
        let toward: Vector = asked.iter().map(|a| a.0).sum();
        let top = corner(&box_corners.bounds, &toward);
        asked.iter().zip(least).all(|((n, _), least)| n.dot(&top.coords) > least + n.dot(&shift))
            && box_corners.is_highest_outside(&toward)
    }
}

/// The direction from a box without faces to the surface: pieces on the other side do not reach into the box.
fn toward_surface(middle: &Middle<'_>) -> Option<Aspect> {
    let near = middle.nearest()?;
    Some(Aspect { normal: near.normal, top: f64::INFINITY, own: f64::NEG_INFINITY })
}

/// The shortest shift d with `n . d >= g` for all pairs of a unit direction n and a length g: the one that is
/// bound by the fewest of them, by the normal equations of these.
fn least_shift(asked: &[(Vector, f64)]) -> Option<Vector> {
    let does = |d: &Vector| asked.iter().all(|(n, g)| n.dot(d) >= g - SHORT);
    if does(&Vector::zeros()) {
        return Some(Vector::zeros());
    }
    let mut best: Option<Vector> = None;
    let mut take = |d: Vector| {
        if does(&d) && best.is_none_or(|b| d.norm_squared() < b.norm_squared()) {
            best = Some(d);
        }
    };
    for (i, (n, g)) in asked.iter().enumerate() {
        take(n * *g);
        for (j, (m, h)) in asked.iter().enumerate().skip(i + 1) {
            let (c, cross) = (n.dot(m), n.cross(m));
            let sine = 1.0 - c * c;
            if sine > ONE_NORMAL {
                take(n * ((g - c * h) / sine) + m * ((h - c * g) / sine));
            }
            for (o, k) in asked.iter().skip(j + 1) {
                let volume = cross.dot(o);
                if volume.abs() > NO_CORNER {
                    take((m.cross(o) * *g + o.cross(n) * *h + cross * *k) / volume);
                }
            }
        }
    }
    best
}

/// Whether a triangle may reach into a box: their boxes meet, and its plane cuts the box.
fn touches(face: &ReadyTriangle, bounds: &Aabb) -> bool {
    let [a, b, c] = &face.corners;
    let outside = |k: usize| {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        low > bounds.max[k] || high < bounds.min[k]
    };
    if (0..3).any(outside) {
        return false;
    }
    let (middle, half) = (bounds.center(), bounds.size() * 0.5);
    let reach: f64 = (0..3).map(|k| face.normal[k].abs() * half[k]).sum();
    (middle - a).dot(&face.normal).abs() <= reach + PASSES
}

/// The part of a triangle in a box, cut by its six planes one by one (Sutherland and Hodgman 1974).
fn clipped(corners: &[Point; 3], bounds: &Aabb) -> Vec<Point> {
    let mut polygon: Vec<Point> = corners.to_vec();
    for k in 0..3 {
        for (at, sign) in [(bounds.min[k], 1.0), (bounds.max[k], -1.0)] {
            let above = |p: &Point| sign * (p[k] - at);
            if polygon.iter().all(|p| above(p) >= 0.0) {
                continue;
            }
            let mut next = Vec::with_capacity(polygon.len() + 1);
            for (i, p) in polygon.iter().enumerate() {
                let q = &polygon[(i + 1) % polygon.len()];
                let (hp, hq) = (above(p), above(q));
                if hp >= 0.0 {
                    next.push(*p);
                }
                if (hp < 0.0) != (hq < 0.0) {
                    next.push(p + (q - p) * (hp / (hp - hq)));
                }
            }
            polygon = next;
            if polygon.is_empty() {
                return polygon;
            }
        }
    }
    polygon
}
