//! Blocks of a lattice: which pieces can matter, and the search point by point.
//!
//! The lattice is cut into bands, each band into blocks by halving. For a block every piece gets a floor: a height below which it comes
//! nowhere over the block. A piece that touches the normal of the block's middle point has a tangent half space there; the convex cutter
//! lies within it, and on the other normals of the block the half space begins at a height that is linear in the point up to the
//! curvature of the design, for which the block's corners and middle stand. Over the time of the piece the floor sinks by rate times half
//! duration (the height is convex in time for a straight piece) and by what a turn tilts and bends. A piece that misses the middle's normal is
//! bounded by its distance.
//!
//! Pieces whose floor lies above an estimate of what the block can reach are left out, and the lowest of their floors is
//! remembered. A point that ends above that floor is searched again among all pieces: the estimate costs time when it is wrong,
//! never a height.

use proveout_tool::Profile;
use rayon::prelude::*;

use super::{
    CutterPiece, Edge, Lattice,
    contact::{Lowest, Run},
    envelope::{Ray, lowest, touch},
    motion::Piece,
    outline::{Body, Outline},
};

/// Rows of a band and largest side of a block that is not halved again.
const BLOCK: usize = 16;
/// A block side of the first division.
const BAND: usize = 64;

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
    Search::new(lattice, pieces, Body::Outline(Outline::new(cutter)), None, settings).heights()
}

/// Heights that the edges of the teeth leave.
pub fn heights_by_edges(lattice: &Lattice, edges: &[Edge], pieces: &[CutterPiece], settings: &Settings) -> Topography {
    match Body::of_edges(edges) {
        Some(body) => Search::new(lattice, pieces, body, Some(edges), settings).heights(),
        None => Topography { cuts: vec![None; lattice.points().len()], again: 0 },
    }
}

struct Search<'a> {
    lattice: &'a Lattice,
    pieces: Vec<Piece>,
    /// Whether a piece follows the one before it without gap.
    joined: Vec<bool>,
    body: Body,
    edges: Option<&'a [Edge]>,
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

#[derive(Clone, Copy, Debug)]
struct Area {
    row: [usize; 2],
    column: [usize; 2],
}

impl<'a> Search<'a> {
    fn new(
        lattice: &'a Lattice,
        pieces: &[CutterPiece],
        body: Body,
        edges: Option<&'a [Edge]>,
        settings: &Settings,
    ) -> Self {
        let joined = std::iter::once(false).chain(pieces.windows(2).map(|w| joins(&w[0], &w[1]))).take(pieces.len());
        Self {
            lattice,
            joined: joined.collect(),
            pieces: pieces.iter().map(Piece::new).collect(),
            body,
            edges,
            max_height: settings.max_height,
        }
    }

    fn ray(&self, row: usize, column: usize) -> Ray {
        let i = row * self.lattice.columns() + column;
        Ray { point: self.lattice.points()[i].coords, normal: self.lattice.normals()[i] }
    }

    fn heights(&self) -> Topography {
        let (columns, rows) = (self.lattice.columns(), self.lattice.rows());
        let whole = Area { row: [0, rows], column: [0, columns] };
        let all = Candidates {
            kept: (0..self.pieces.len() as u32).map(|i| (i, f64::NEG_INFINITY)).collect(),
            left_out: f64::INFINITY,
        };
        // Only what comes near the lattice at all.
        let near = self.narrowed(&whole, &all, true);
        let mut found = vec![Lowest::NONE; columns * rows];
        let again: usize = found
            .par_chunks_mut(columns * BAND)
            .enumerate()
            .map(|(k, out)| {
                let mut again = 0;
                let row = [k * BAND, (k * BAND + BAND).min(rows)];
                for column in (0..columns).step_by(BAND) {
                    let area = Area { row, column: [column, (column + BAND).min(columns)] };
                    again += self.block(&area, &near, &near, out, row[0]);
                }
                again
            })
            .sum();
        let cuts = found
            .into_iter()
            .map(|best| {
                (best.height <= self.max_height).then_some(Cut {
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
    fn block(&self, area: &Area, above: &Candidates, all: &Candidates, out: &mut [Lowest], first: usize) -> usize {
        let candidates = self.narrowed(area, above, false);
        let (rows, columns) = (area.row[1] - area.row[0], area.column[1] - area.column[0]);
        if rows.max(columns) > BLOCK {
            let halves = if rows >= columns {
                let m = area.row[0] + rows / 2;
                [Area { row: [area.row[0], m], ..*area }, Area { row: [m, area.row[1]], ..*area }]
            } else {
                let m = area.column[0] + columns / 2;
                [Area { column: [area.column[0], m], ..*area }, Area { column: [m, area.column[1]], ..*area }]
            };
            return halves.iter().map(|half| self.block(half, &candidates, all, out, first)).sum();
        }
        let mut again = 0;
        let leaf = Leaf::new(self, &candidates);
        let mut hint = Lowest::NONE;
        let mut everything = None;
        for row in area.row[0]..area.row[1] {
            for column in area.column[0]..area.column[1] {
                let ray = self.ray(row, column);
                let mut best = leaf.point(&ray, &hint);
                if best.height > candidates.left_out && candidates.left_out < self.max_height {
                    again += 1;
                    best = everything.get_or_insert_with(|| Leaf::new(self, all)).point(&ray, &hint);
                }
                if best.height.is_finite() {
                    hint = best;
                }
                out[(row - first) * self.lattice.columns() + column] = best;
            }
        }
        again
    }

    /// The candidates of a block among those of a larger one.
    fn narrowed(&self, area: &Area, above: &Candidates, keep_all_low: bool) -> Candidates {
        let middle = self.ray((area.row[0] + area.row[1]) / 2, (area.column[0] + area.column[1]) / 2);
        let corners = [
            self.ray(area.row[0], area.column[0]),
            self.ray(area.row[0], area.column[1] - 1),
            self.ray(area.row[1] - 1, area.column[0]),
            self.ray(area.row[1] - 1, area.column[1] - 1),
        ];
        let radius = corners.iter().fold(0.0_f64, |a, c| a.max((c.point - middle.point).norm()));
        // What the design's curvature takes the points out of a plane through the corners.
        let bulge = {
            let mean = corners.iter().fold(proveout_geom::Vector::zeros(), |a, c| a + c.point) / 4.0;
            2.0 * (mean - middle.point).dot(&middle.normal).abs()
        };
        let mut floors = Vec::with_capacity(above.kept.len());
        let mut estimate = self.max_height;
        for &(i, before) in &above.kept {
            let piece = &self.pieces[i as usize];
            let (floor, reached) = self.floor(piece, &middle, &corners, radius, bulge);
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

    /// A height below which a piece comes nowhere over the block, and an estimate of one that it reaches everywhere.
    fn floor(&self, piece: &Piece, middle: &Ray, corners: &[Ray; 4], radius: f64, bulge: f64) -> (f64, f64) {
        let time = 0.5 * (piece.time[0] + piece.time[1]);
        let smallest = self.body.smallest_radius();
        if let Some(touch) = touch(middle, piece, &self.body, time, 0.0) {
            let on_corners = corners.iter().map(|c| touch.floor_on(middle, c)).fold(touch.height, f64::min);
            let angle = piece.angle();
            // A straight piece carries the half space along; a turning one turns it about its touch as well, by half its angle at
            // either end, which lowers it on normals that lie the block's radius away.
            let tilt = 0.6 * angle * (radius + touch.height.abs());
            let sink = 0.5 * touch.rate.abs() * piece.duration() + 0.25 * touch.reach * angle * angle + tilt + bulge;
            let mut rise = 2.0 * touch.slope(middle) * radius + 2.0 * radius * radius / smallest + bulge;
            if let Some(edges) = self.edges {
                // The next tooth comes within a revolution.
                let turn = std::f64::consts::TAU / piece.azimuth_rate.abs();
                let feed = piece.travel() / piece.duration() * turn;
                let spread = edges.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |a, e| {
                    (a.0.min(e.center_height), a.1.max(e.center_height))
                });
                rise += touch.rate.abs() * turn + feed * feed / smallest + (spread.1 - spread.0);
            }
            // Along a ray that grazes, the estimate says nothing.
            let reached = if touch.slope(middle) < 1.0 { touch.height + rise } else { f64::INFINITY };
            (on_corners - sink, reached)
        } else {
            let state = piece.state(time);
            let q = state.point(&middle.point);
            let (distance, _) = self.body.distance(q.x.hypot(q.y), q.z);
            let way = 0.5 * (piece.travel() + piece.angle() * q.norm());
            (if distance > 0.0 { distance - radius - way } else { f64::NEG_INFINITY }, f64::INFINITY)
        }
    }
}

/// Whether one piece goes on where the other ends, with a spindle that turns on.
fn joins(a: &CutterPiece, b: &CutterPiece) -> bool {
    let turned = a.azimuth + a.azimuth_rate * (a.time[1] - a.time[0]);
    let close = |x: f64, y: f64, tolerance: f64| (x - y).abs() <= tolerance;
    close(a.time[1], b.time[0], 1e-9)
        && (a.tip[1] - b.tip[0]).norm() <= 1e-6
        && a.azimuth_rate * b.azimuth_rate > 0.0
        && close(turned, b.azimuth, 1e-6 * (1.0 + turned.abs() * 1e-6))
}

/// The pieces of a block, in the form in which they are searched.
struct Leaf<'a> {
    search: &'a Search<'a>,
    /// For the envelope: the lowest floors first.
    sorted: Vec<(u32, f64)>,
    /// For the edges: pieces that follow one another.
    runs: Vec<Run>,
}

impl<'a> Leaf<'a> {
    fn new(search: &'a Search<'a>, candidates: &Candidates) -> Self {
        let mut leaf = Self { search, sorted: Vec::new(), runs: Vec::new() };
        if search.edges.is_none() {
            leaf.sorted.clone_from(&candidates.kept);
            leaf.sorted.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
            return leaf;
        }
        let follows = |a: &(u32, f64), b: &(u32, f64)| b.0 == a.0 + 1 && search.joined[b.0 as usize];
        for part in candidates.kept.chunk_by(follows) {
            leaf.runs.push(Run::new(
                part.iter().map(|(i, _)| search.pieces[*i as usize]).collect(),
                part.iter().map(|(_, floor)| *floor).collect(),
            ));
        }
        leaf.runs.sort_by(|a, b| a.lowest.total_cmp(&b.lowest));
        leaf
    }

    /// The lowest contact of a point; `hint` is that of a neighbor.
    fn point(&self, ray: &Ray, hint: &Lowest) -> Lowest {
        let mut best = Lowest::NONE;
        match self.search.edges {
            None => {
                for &(i, floor) in &self.sorted {
                    if floor >= best.height {
                        break;
                    }
                    let piece = &self.search.pieces[i as usize];
                    let guess = if hint.height.is_finite() { hint.height } else { 0.0 };
                    if let Some((height, time)) = lowest(ray, piece, &self.search.body, (hint.time, guess))
                        && height < best.height
                    {
                        best = Lowest { height, time, motion: piece.motion, edge: usize::MAX };
                    }
                }
            }
            Some(edges) => {
                for run in &self.runs {
                    if run.lowest >= best.height {
                        break;
                    }
                    let middle = if (run.begin()..=run.end()).contains(&hint.time) {
                        // The neighbor's contact leads to one that is as low, and leaves little to look for.
                        run.follow(ray, &edges[hint.edge], hint, &mut best);
                        hint.time
                    } else {
                        run.middle_of_lowest()
                    };
                    for (index, edge) in edges.iter().enumerate() {
                        run.search(ray, edge, index, middle, &mut best);
                    }
                }
            }
        }
        best
    }
}
