//! Blocks of a lattice: which pieces can matter, and the search point by point.
//!
//! The lattice is cut into bands, each band into blocks by halving. For a block every piece gets a floor: a
//! height below which the piece never comes over the block. A piece that touches the normal of the block's
//! middle point has a tangent half space there, which contains the convex cutter. On the other normals of
//! the block the half space begins at a height that is linear in the point up to the curvature of the
//! design; the block's corners and middle represent the block. Over the time of the piece the floor sinks
//! by rate times half duration (the height is convex in time for a straight piece) and by what a turn tilts
//! and bends. A piece that misses the middle's normal is bounded by its distance.
//!
//! Pieces whose floor lies above an estimate of what the block can reach are left out, and the lowest of
//! their floors is remembered. A point that ends above that floor is searched again among all pieces: the
//! estimate costs time when it is wrong, never a height.

use proveout_geom::Vector;
use proveout_tool::Profile;
use rayon::prelude::*;

use super::{
    CutterPiece, Edge, Lattice, NOT_ZERO,
    edge_contact::{Hull, LowestContact, PieceRun},
    envelope::{NormalLine, descend, lowest, touch},
    motion::SweptPiece,
    outline::{CutterBody, CutterOutline},
};

/// Rows of a band and largest side of a block that is not halved again.
const BLOCK: usize = 16;
/// A block side of the first division.
const BAND: usize = 64;
/// Parts of vectors across a normal that are shorter have no direction.
const SHORTEST: f64 = 1e-9;
/// Cosine between a tangent plane's normal and the lines of a block from which on it bounds their heights
/// from below.
const STEEPEST: f64 = 1e-3;
/// A piece begins where and when the one before ends within this, s, mm and radian.
const JOINED_S: f64 = 1e-9;
const JOINED_MM: f64 = 1e-6;
const JOINED_RAD: f64 = 1e-6;
/// Growth of the last one with the angle that the spindle has turned, 1/radian: rounding.
const JOINED_PER_RAD: f64 = 1e-6;

/// What decides which points count as cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Heights above this (mm) count as not cut by these motions.
    pub max_height: f64,
}

/// The contact that made a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Height above the design along its normal, mm; negative inside of it.
    pub height: f64,
    /// When, s.
    pub time: f64,
    /// [`CutterPiece::motion`].
    pub motion: u32,
    /// Index of the edge; none for the envelope.
    pub edge: Option<usize>,
}

/// Heights over a lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// One entry a point; none where nothing cuts below the largest height.
    pub cuts: Vec<Option<Cut>>,
    /// Points that were searched a second time among all pieces.
    pub again: usize,
}

impl Topography {
    /// Heights, mm; NaN where not cut.
    pub fn heights(&self) -> Vec<f64> {
        self.cuts.iter().map(|c| c.map_or(f64::NAN, |c| c.height)).collect()
    }

    /// Points that are not cut.
    pub fn uncut(&self) -> usize {
        self.cuts.iter().filter(|c| c.is_none()).count()
    }
}

/// Heights that the nominal cutter leaves, its run-out and its teeth apart.
pub fn heights_by_envelope(
    lattice: &Lattice,
    cutter: &Profile,
    pieces: &[CutterPiece],
    settings: &Settings,
) -> Topography {
    HeightSearch::new(lattice, pieces, CutterBody::Outline(CutterOutline::new(cutter)), None, settings).heights()
}

/// Heights that the edges of the teeth leave. Edges that are not finite, or whose arc has no radius, leave
/// none.
pub fn heights_by_edges(lattice: &Lattice, edges: &[Edge], pieces: &[CutterPiece], settings: &Settings) -> Topography {
    // Arcs of one kind are searched together, those of ball and side of a barrel apart: one body would hold
    // both only loosely.
    let kind = |e: &Edge| [e.radius.to_bits(), e.corner[0].to_bits(), e.corner[1].to_bits()];
    let mut kinds: Vec<([u64; 3], Vec<usize>)> = Vec::new();
    for (i, edge) in edges.iter().enumerate().filter(|(_, e)| e.is_finite() && e.radius > 0.0) {
        match kinds.iter_mut().find(|k| k.0 == kind(edge)) {
            Some(k) => k.1.push(i),
            None => kinds.push((kind(edge), vec![i])),
        }
    }
    let mut lowest = Topography { cuts: vec![None; lattice.points().len()], again: 0 };
    for (_, members) in kinds {
        let part: Vec<Edge> = members.iter().map(|i| edges[*i]).collect();
        let Some(body) = CutterBody::of_edges(&part) else { continue };
        let found = HeightSearch::new(lattice, pieces, body, Some(&part), settings).heights();
        lowest.again += found.again;
        for (low, cut) in lowest.cuts.iter_mut().zip(found.cuts) {
            let Some(cut) = cut else { continue };
            if low.is_none_or(|l| cut.height < l.height) {
                *low = Some(Cut { edge: cut.edge.map(|k| members[k]), ..cut });
            }
        }
    }
    lowest
}

struct HeightSearch<'a> {
    lattice: &'a Lattice,
    pieces: Vec<SweptPiece>,
    /// Whether a piece follows the one before it without gap.
    joined: Vec<bool>,
    body: CutterBody,
    edges: Option<&'a [Edge]>,
    hulls: Vec<Hull>,
    /// Shortest revolution, s.
    turn: f64,
    max_height: f64,
}

/// Candidates of a block.
#[derive(Clone, Debug)]
struct Candidates {
    /// Pieces in their order, with their floors.
    kept: Vec<(u32, f64)>,
    /// Lowest floor of those that were left out.
    left_out: f64,
}

/// Where the points of a block lie.
struct Patch {
    middle: NormalLine,
    /// Center and half edges of a box round the points.
    center: Vector,
    half: [Vector; 3],
    /// Largest difference of a normal from the middle's.
    spread: f64,
    /// Largest distance of a point from the middle.
    radius: f64,
}

#[derive(Clone, Copy, Debug)]
struct LatticeRange {
    row: [usize; 2],
    column: [usize; 2],
}

impl<'a> HeightSearch<'a> {
    fn new(
        lattice: &'a Lattice,
        pieces: &[CutterPiece],
        body: CutterBody,
        edges: Option<&'a [Edge]>,
        settings: &Settings,
    ) -> Self {
        let (mut ready, mut joined): (Vec<SweptPiece>, Vec<bool>) = (Vec::new(), Vec::new());
        let mut before: Option<&CutterPiece> = None;
        for piece in pieces.iter().filter(|p| p.is_finite()) {
            let follows = before.is_some_and(|b| joins(b, piece));
            for (k, part) in SweptPiece::new(piece).parts().enumerate() {
                ready.push(part);
                joined.push(k > 0 || follows);
            }
            before = Some(piece);
        }
        let fastest = pieces.iter().map(|p| p.azimuth_rate.abs()).filter(|r| r.is_finite()).fold(0.0, f64::max);
        Self {
            lattice,
            turn: std::f64::consts::TAU / fastest,
            pieces: ready,
            joined,
            body,
            edges,
            hulls: edges.unwrap_or_default().iter().map(Hull::new).collect(),
            max_height: settings.max_height,
        }
    }

    fn ray(&self, row: usize, column: usize) -> NormalLine {
        let i = row * self.lattice.columns() + column;
        NormalLine { point: self.lattice.points()[i].coords, normal: self.lattice.normals()[i] }
    }

    fn heights(&self) -> Topography {
        let (columns, rows) = (self.lattice.columns(), self.lattice.rows());
        let whole = LatticeRange { row: [0, rows], column: [0, columns] };
        let all = Candidates {
            kept: (0..self.pieces.len() as u32).map(|i| (i, f64::NEG_INFINITY)).collect(),
            left_out: f64::INFINITY,
        };
        // Only what comes near the lattice at all.
        let near = self.candidates_in(&whole, &all, true);
        let mut found = vec![LowestContact::NONE; columns * rows];
        let again: usize = found
            .par_chunks_mut(columns * BAND)
            .enumerate()
            .map(|(k, out)| {
                let mut again = 0;
                let row = [k * BAND, (k * BAND + BAND).min(rows)];
                for column in (0..columns).step_by(BAND) {
                    let area = LatticeRange { row, column: [column, (column + BAND).min(columns)] };
                    again += self.block(&area, &near, &near, out, row[0]);
                }
                again
            })
            .sum();
        let cuts = found
            .into_iter()
            .map(|best| {
                (best.height.is_finite() && best.height <= self.max_height).then_some(Cut {
                    height: best.height,
                    time: best.time,
                    motion: best.motion,
                    edge: self.edges.map(|_| best.edge),
                })
            })
            .collect();
        Topography { cuts, again }
    }

    /// Searches a block; `out` begins at row `first`. Returns the number of points that were searched twice.
    fn block(
        &self,
        area: &LatticeRange,
        above: &Candidates,
        all: &Candidates,
        out: &mut [LowestContact],
        first: usize,
    ) -> usize {
        let candidates = self.candidates_in(area, above, false);
        let (rows, columns) = (area.row[1] - area.row[0], area.column[1] - area.column[0]);
        if rows.max(columns) > BLOCK {
            let halves = if rows >= columns {
                let m = area.row[0] + rows / 2;
                [LatticeRange { row: [area.row[0], m], ..*area }, LatticeRange { row: [m, area.row[1]], ..*area }]
            } else {
                let m = area.column[0] + columns / 2;
                [
                    LatticeRange { column: [area.column[0], m], ..*area },
                    LatticeRange { column: [m, area.column[1]], ..*area },
                ]
            };
            return halves.iter().map(|half| self.block(half, &candidates, all, out, first)).sum();
        }
        let mut again = 0;
        let leaf = Leaf::new(self, &candidates);
        let mut everything = None;
        let width = self.lattice.columns();
        for row in area.row[0]..area.row[1] {
            for column in area.column[0]..area.column[1] {
                let ray = self.ray(row, column);
                let at = (row - first) * width + column;
                let left = (column > area.column[0]).then(|| out[at - 1]);
                let below = (row > area.row[0]).then(|| out[at - width]);
                let corner = left.and(below).map(|_| out[at - width - 1]);
                let hint = self.expected(left, below, corner);
                let mut best = leaf.point(&ray, &hint);
                if best.height > candidates.left_out && candidates.left_out < self.max_height {
                    again += 1;
                    best = everything.get_or_insert_with(|| Leaf::new(self, all)).point(&ray, &hint);
                }
                out[at] = best;
            }
        }
        again
    }

    /// What the neighbors of a node let expect: the plane through three that the same edge cut in the same
    /// turn, else one of them. A start for Newton's method, on which no height hangs.
    fn expected(
        &self,
        left: Option<LowestContact>,
        below: Option<LowestContact>,
        corner: Option<LowestContact>,
    ) -> LowestContact {
        let cut = |l: &LowestContact| l.height.is_finite();
        let (left, below) = (left.filter(cut), below.filter(cut));
        let (Some(a), Some(b), Some(c)) = (left, below, corner.filter(cut)) else {
            return left.or(below).unwrap_or(LowestContact::NONE);
        };
        let same = if self.edges.is_some() {
            let near = |l: &LowestContact| l.edge == c.edge && (l.time - c.time).abs() < 0.3 * self.turn;
            near(&a) && near(&b)
        } else {
            a.motion == c.motion && b.motion == c.motion
        };
        if same {
            LowestContact { height: a.height + b.height - c.height, time: a.time + b.time - c.time, ..a }
        } else {
            a
        }
    }

    /// The candidates of a block among those of a larger one.
    fn candidates_in(&self, area: &LatticeRange, above: &Candidates, keep_all_low: bool) -> Candidates {
        let patch = self.patch(area);
        let mut floors = Vec::with_capacity(above.kept.len());
        let mut estimate = self.max_height;
        for &(i, before) in &above.kept {
            let piece = &self.pieces[i as usize];
            let (floor, reached) = self.floor(piece, &patch);
            estimate = estimate.min(reached);
            floors.push((i, floor.max(before)));
        }
        let limit = if keep_all_low { self.max_height } else { estimate };
        let mut candidates = Candidates { kept: Vec::new(), left_out: above.left_out };
        for (i, floor) in floors {
            if floor <= limit {
                candidates.kept.push((i, floor));
            } else {
                candidates.left_out = candidates.left_out.min(floor);
            }
        }
        candidates
    }

    /// The box of a block's points and the cone of their normals.
    fn patch(&self, area: &LatticeRange) -> Patch {
        let middle = self.ray((area.row[0] + area.row[1]) / 2, (area.column[0] + area.column[1]) / 2);
        let n = middle.normal;
        // Along the rows of the block, where that is a direction.
        let along = self.ray((area.row[0] + area.row[1]) / 2, area.column[0]).point - middle.point;
        let across = if n.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
        let flat = |v: Vector| (v - n * v.dot(&n)).try_normalize(SHORTEST);
        let x = flat(along).or_else(|| flat(across)).unwrap_or_else(Vector::x);
        let axes = [x, n.cross(&x), n];
        let (mut low, mut high, mut spread, mut radius) = ([0.0_f64; 3], [0.0_f64; 3], 0.0_f64, 0.0_f64);
        for row in area.row[0]..area.row[1] {
            for column in area.column[0]..area.column[1] {
                let ray = self.ray(row, column);
                let v = ray.point - middle.point;
                for (k, axis) in axes.iter().enumerate() {
                    let s = v.dot(axis);
                    low[k] = low[k].min(s);
                    high[k] = high[k].max(s);
                }
                spread = spread.max((ray.normal - n).norm_squared());
                radius = radius.max(v.norm_squared());
            }
        }
        let center = (0..3).fold(middle.point, |c, k| c + axes[k] * (0.5 * (low[k] + high[k])));
        let half = [0, 1, 2].map(|k| axes[k] * (0.5 * (high[k] - low[k])));
        Patch { middle, center, half, spread: spread.sqrt(), radius: radius.sqrt() }
    }

    /// A height below which a piece never comes over the block, and an estimate of one that it reaches
    /// everywhere.
    ///
    /// The piece has its lowest touch on the normal of the block's middle at a time t0, at T with the
    /// cutter's outward normal m. The convex cutter lies on the inner side of its tangent plane, so at t0
    /// it meets the normal n of a point P no lower than h >= m (P - T) / a with a = - m n. At another time
    /// the plane is carried by the velocity V of the cutter at T, turned by delta at most, and T is bent
    /// off its straight path by reach delta^2 / 2:
    ///
    /// ```text
    ///   h a' >= m (P - T) - (t - t0) m V - reach delta^2 / 2 - delta |P - T'|
    ///   |a' - a| <= |n - n_middle| + delta
    /// ```
    ///
    /// m (P - T) is linear in P and least at a corner of the box of the points. Where the lowest touch lies
    /// within a straight piece m V is zero, and at its ends the plane only rises: then the floor is exact on
    /// the middle's normal.
    fn floor(&self, piece: &SweptPiece, patch: &Patch) -> (f64, f64) {
        let middle = &patch.middle;
        let smallest = self.body.smallest_radius();
        let found = descend(middle, piece, &self.body, (f64::NAN, 0.0))
            .0
            .and_then(|(height, time)| Some((touch(middle, piece, &self.body, time, height)?, time)));
        let Some((touch, time)) = found else {
            // Nothing is nearer than the distance at the middle of the piece less what the piece moves and
            // the block is wide.
            let time = 0.5 * (piece.time[0] + piece.time[1]);
            let q = piece.state(time).point(&middle.point);
            let (distance, _) = self.body.distance(q.x.hypot(q.y), q.z);
            let way = 0.5 * (piece.travel() + piece.angle() * q.norm());
            let free = distance - patch.radius - way;
            return (if free > 0.0 { free } else { f64::NEG_INFINITY }, f64::INFINITY);
        };
        let at = middle.point + middle.normal * touch.height;
        let m = touch.normal;
        let along = -m.dot(&middle.normal);
        let (before, after) = (time - piece.time[0], piece.time[1] - time);
        let delta = piece.angle() * before.max(after) / piece.duration().max(NOT_ZERO);
        // m V: the height on the middle's normal falls at `rate`, which is m V over m n.
        let carried = -touch.rate * along;
        let sunk = (carried * after).max(-carried * before).max(0.0);
        let far = patch.radius + touch.height.abs() + piece.travel() + delta * touch.reach;
        let sink = sunk + 0.5 * touch.reach * delta * delta + delta * far;
        let least = m.dot(&(patch.center - at)) - patch.half.iter().map(|h| m.dot(h).abs()).sum::<f64>() - sink;
        let lean = patch.spread + delta;
        let (low, high) = (along - lean, along + lean);
        let floor = match (least >= 0.0, low > STEEPEST) {
            (true, _) => least / high.min(1.0),
            (false, true) => least / low,
            (false, false) => f64::NEG_INFINITY,
        };
        let slope = touch.slope(middle);
        let mut rise = 2.0 * slope * patch.radius + 2.0 * patch.radius * patch.radius / smallest;
        if let Some(edges) = self.edges {
            // The next tooth comes within a revolution.
            let turn = std::f64::consts::TAU / piece.azimuth_rate.abs();
            let feed = piece.travel() / piece.duration() * turn;
            let spread = edges
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |a, e| (a.0.min(e.center_height), a.1.max(e.center_height)));
            rise += touch.rate.abs() * turn + feed * feed / smallest + (spread.1 - spread.0);
        }
        // Along a normal that grazes, the estimate says nothing.
        (floor, if slope < 1.0 { touch.height + rise } else { f64::INFINITY })
    }
}

/// Whether one piece goes on where the other ends, with a spindle that turns on.
fn joins(a: &CutterPiece, b: &CutterPiece) -> bool {
    let turned = a.azimuth + a.azimuth_rate * (a.time[1] - a.time[0]);
    let close = |x: f64, y: f64, tolerance: f64| (x - y).abs() <= tolerance;
    close(a.time[1], b.time[0], JOINED_S)
        && (a.tip[1] - b.tip[0]).norm() <= JOINED_MM
        && a.azimuth_rate * b.azimuth_rate > 0.0
        && close(turned, b.azimuth, JOINED_RAD * (1.0 + turned.abs() * JOINED_PER_RAD))
}

/// The pieces of a block, in the form in which they are searched.
struct Leaf<'a> {
    search: &'a HeightSearch<'a>,
    /// For the envelope: the lowest floors first.
    sorted: Vec<(u32, f64)>,
    /// For the edges: pieces that follow one another.
    runs: Vec<PieceRun>,
}

impl<'a> Leaf<'a> {
    fn new(search: &'a HeightSearch<'a>, candidates: &Candidates) -> Self {
        let mut leaf = Self { search, sorted: Vec::new(), runs: Vec::new() };
        if search.edges.is_none() {
            leaf.sorted.clone_from(&candidates.kept);
            leaf.sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            return leaf;
        }
        let follows = |a: &(u32, f64), b: &(u32, f64)| b.0 == a.0 + 1 && search.joined[b.0 as usize];
        for part in candidates.kept.chunk_by(follows) {
            leaf.runs.push(PieceRun::new(
                part.iter().map(|(i, _)| search.pieces[*i as usize]).collect(),
                part.iter().map(|(_, floor)| *floor).collect(),
            ));
        }
        leaf.runs.sort_by(|a, b| a.lowest.total_cmp(&b.lowest));
        leaf
    }

    /// The lowest contact of a point; `hint` is that of a neighbor.
    fn point(&self, ray: &NormalLine, hint: &LowestContact) -> LowestContact {
        let mut best = LowestContact::NONE;
        if !ray.is_finite() {
            return best;
        }
        match self.search.edges {
            None => {
                // The piece that cut the neighbor cuts this one as well, mostly.
                let near = |i: u32| {
                    let [begin, end] = self.search.pieces[i as usize].time;
                    (begin..=end).contains(&hint.time)
                };
                let first = self.sorted.iter().position(|(i, _)| near(*i));
                let rest = self.sorted.iter().enumerate().filter(|(k, _)| Some(*k) != first).map(|(_, s)| s);
                for &(i, floor) in first.map(|k| &self.sorted[k]).into_iter().chain(rest) {
                    if floor >= best.height {
                        // All that follow are as high.
                        break;
                    }
                    let piece = &self.search.pieces[i as usize];
                    let guess = if hint.height.is_finite() { hint.height } else { 0.0 };
                    if let Some((height, time)) = lowest(
                        ray,
                        piece,
                        &self.search.body,
                        (hint.time, guess),
                        best.height.min(self.search.max_height),
                    ) && height < best.height
                    {
                        best = LowestContact { height, time, motion: piece.motion, edge: usize::MAX };
                    }
                }
            }
            Some(_) => {
                let (hulls, cap) = (&self.search.hulls, self.search.max_height);
                for run in &self.runs {
                    if run.lowest >= best.height {
                        break;
                    }
                    let middle = if (run.begin()..=run.end()).contains(&hint.time) {
                        // The neighbor's contact leads to one that is as low, and leaves little to look for.
                        run.follow(ray, &hulls[hint.edge], hint, cap, &mut best);
                        hint.time
                    } else {
                        run.middle_of_lowest()
                    };
                    for (index, hull) in hulls.iter().enumerate() {
                        run.search(ray, hull, index, middle, cap, &mut best);
                    }
                }
            }
        }
        best
    }
}
