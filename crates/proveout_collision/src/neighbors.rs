//! Machine bodies of neighboring joints: they slide or turn on each other, so that they touch where they are
//! borne.
//!
//! Of such a pair the *volume of the bearing* is left out, and the rest is checked as everything else is.
//! What bears is what is near or inside of the other at rest (the joint at zero, or at the end of its travel
//! that is nearest to zero):
//!
//! ```text
//!    rotary joint: r, z of the axis            slide: the plane across it
//!
//!      r ^      base of a trunnion               v ^    ____
//!        |    ######                               |   |____|  slide
//!        |    ######                               |  xxxxxxxx                x  left out: cells in which
//!        |  xxxxxxxxxx                             |  x######x  guide            the two are near at rest,
//!        |  xxxxxxxxxx-------. trunnion            |  x######x                   and two cells around
//!        |  xxxxxxxxxx       |                     |   ######
//!        +-------------------'---> z               +-----------> u
//! ```
//!
//! The motion of the joint changes neither r and z of a point about its axis, nor its place across a slide.
//! So what is outside of the zone stays outside, on both bodies, and never meets what was left out: an
//! overlap outside of the zone is one of the two rests, and begins where their skins meet. Nothing else is
//! assumed of the bodies; drawn ones may overlap at rest as they like.
//!
//! The width of the volume left out is reported ([`ZONE_MM`]). Parts that lie in the zone and bear
//! nothing are checked as wholes (`neighbor_shells.rs`).
//!
//! A pair of neighbors has one freedom. Where it was found clear it stays clear whatever the other joints do:
//! the range of the joint that is proved is kept, and most pieces need no more than a look at it.

use std::{f64::consts::TAU, sync::Arc};

use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{Joint, JointValues, Machine};

use crate::box_tree::{BoxTree, Effort, NearestLeaves, nearest_leaf};
use crate::neighbor_shells;
use crate::shape::MeshShape;
use crate::triangle;
use crate::triangle_tree::TriangleTree;

/// Edge of a cell of the zone, mm: the zone reaches two to three of them beyond what bears.
const CELL_MM: f64 = 4.0;
/// Cells that the zone is grown by to all sides. A piece at its border is smaller than one cell: with two of
/// them it is either dropped, or reaches in where nothing bears.
const GROWN: usize = 2;
/// What is nearer than the clearance and this, mm, bears.
const BEARING_MM: f64 = 2.0;
/// Most by which the zone reaches beyond what bears, mm: the cells that it is grown by, and the one that they
/// begin in.
pub const ZONE_MM: f64 = (GROWN + 1) as f64 * CELL_MM;
/// Most triangles that a body may be parted into at the border of its zone; beyond it pieces are kept whole,
/// which only checks more.
const MOST_PIECES: usize = 400_000;
/// Rounding of corners, mm.
const ROUND_MM: f64 = 1e-6;

/// Most by which a range is proved for more slack than was asked for, mm: less than the tolerance of any
/// answer.
const SPARE_MM: f64 = 1e-4;

/// A range that nothing lies in.
pub(crate) const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Two neighbors without what bears, and the range of their joint that is proved.
#[derive(Clone, Debug)]
pub(crate) struct Neighbors {
    /// The joint between them.
    pub(crate) joint: usize,
    /// The rests of both, in their own frames.
    pub(crate) rests: Arc<SkinRests>,
    /// Range of the joint in which they keep the clearance, with `slack`; empty at first.
    pub(crate) proved: [f64; 2],
    /// For which the range was proved, mm.
    pub(crate) slack: f64,
    /// Most that a point of one moves against the other for a unit of the joint: 1, or mm for a radian.
    pub(crate) weight: f64,
    /// The joint turns: a whole turn is all of it.
    turns: bool,
}

/// What is left of two bodies.
#[derive(Debug)]
pub(crate) struct SkinRests {
    pub(crate) skins: [Arc<TriangleTree>; 2],
    /// Part of the skin of each that was left out, 0 to 1.
    pub(crate) left_out: [f64; 2],
    /// Parts of one that lie in the zone and bear nothing, each with all of the other.
    pub(crate) idle: Vec<neighbor_shells::SkinPair>,
}

impl Neighbors {
    pub(crate) fn new(machine: &Machine, joint: usize, rests: Arc<SkinRests>) -> Self {
        let j = &machine.joints[joint];
        // Where two points are nearest, one of them moves against the other's body by its distance from the
        // axis; either may be taken.
        let radius = |skin: &TriangleTree| farthest(skin, &j.point, &j.direction);
        let of_pair = |[a, b]: &neighbor_shells::SkinPair| radius(a).min(radius(b));
        let widest = std::iter::once(&rests.skins).chain(&rests.idle).map(of_pair).fold(0.0, f64::max);
        let weight = if j.is_rotary() { widest } else { 1.0 };
        Self { joint, rests, proved: EMPTY, slack: 0.0, weight, turns: j.is_rotary() }
    }

    /// Forgets what was proved for a smaller slack. A little more than what is asked for is taken, so that
    /// slacks that grow from piece to piece do not throw the range away each time.
    pub(crate) fn allow(&mut self, slack: f64) {
        if slack > self.slack {
            (self.slack, self.proved) = (slack + (0.25 * slack).min(SPARE_MM), EMPTY);
        }
    }

    pub(crate) fn covers(&self, a: f64, b: f64, slack: f64) -> bool {
        slack <= self.slack && self.proved[0] <= a.min(b) && a.max(b) <= self.proved[1]
    }

    /// Adds a range round a position; one that does not meet what is proved takes its place.
    pub(crate) fn add(&mut self, at: f64, reach: f64) {
        let [low, high] = [at - reach, at + reach];
        if low <= self.proved[1] && self.proved[0] <= high {
            self.proved = [self.proved[0].min(low), self.proved[1].max(high)];
        } else {
            self.proved = [low, high];
        }
        if self.turns && self.proved[1] - self.proved[0] >= TAU {
            self.proved = [f64::NEG_INFINITY, f64::INFINITY];
        }
    }
}

/// Coordinates of a point that a joint does not change, mm: r and z about its axis, or two across its way.
struct Invariant {
    turns: bool,
    origin: Point,
    along: Vector,
    across: [Vector; 2],
}

/// A rectangle of invariant coordinates, low and high of each.
type Patch = [[f64; 2]; 2];

impl Invariant {
    fn of(machine: &Machine, joint: usize) -> Self {
        let j = &machine.joints[joint];
        let along = j.direction;
        let helper = if along.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let u = along.cross(&helper).normalize();
        Self { turns: j.is_rotary(), origin: j.point, along, across: [u, along.cross(&u)] }
    }

    fn patch(&self, t: &[Point; 3]) -> Patch {
        let range = |f: &dyn Fn(&Point) -> f64| {
            t.iter().map(f).fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)])
        };
        let [u, v] = self.across;
        if !self.turns {
            return [range(&|p| p.coords.dot(&u)), range(&|p| p.coords.dot(&v))];
        }
        let flat = t.map(|p| Point::new((p - self.origin).dot(&u), (p - self.origin).dot(&v), 0.0));
        let near = triangle::point_triangle(Point::origin(), &flat).square.sqrt();
        let far = flat.iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
        [[near, far], range(&|p| (p - self.origin).dot(&self.along))]
    }
}

fn is_small(p: &Patch) -> bool {
    p.iter().all(|[low, high]| high - low <= CELL_MM)
}

/// Cells of invariant coordinates, marked where the bodies bear on each other.
struct Zone {
    low: [f64; 2],
    size: [usize; 2],
    marked: Vec<bool>,
    any: bool,
}

/// Most cells of a zone; a machine of 10 m has 6 million. Beyond it the zone ends there, and what lies
/// outside is checked.
const MOST_CELLS: usize = 4000;

impl Zone {
    fn round(bodies: [&MeshShape; 2], invariant: &Invariant) -> Self {
        let all = bodies.iter().flat_map(|b| b.boxes.triangles()).map(|t| invariant.patch(t));
        let low = all.clone().fold([f64::INFINITY; 2], |l, p| [l[0].min(p[0][0]), l[1].min(p[1][0])]);
        let high = all.fold([f64::NEG_INFINITY; 2], |h, p| [h[0].max(p[0][1]), h[1].max(p[1][1])]);
        let low = low.map(|x| x - GROWN as f64 * CELL_MM);
        let size = [0, 1].map(|k| (((high[k] - low[k]) / CELL_MM).ceil() as usize + GROWN + 1).min(MOST_CELLS));
        Self { low, size, marked: vec![false; size[0] * size[1]], any: false }
    }

    /// Rows of cells of a patch.
    fn rows(&self, p: &Patch, grown: usize) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let at = |k: usize, x: f64| (((x - self.low[k]) / CELL_MM).max(0.0) as usize).min(self.size[k] - 1);
        let range = |k: usize| at(k, p[k][0]).saturating_sub(grown)..(at(k, p[k][1]) + grown + 1).min(self.size[k]);
        let (of, within, width) = (range(0), range(1), self.size[1]);
        of.map(move |i| i * width + within.start..i * width + within.end)
    }

    /// Whether a patch and what is grown about it are marked.
    fn holds(&self, p: &Patch, grown: usize) -> bool {
        let reaches = |k: usize| p[k][1] < self.low[k] + self.size[k] as f64 * CELL_MM;
        reaches(0) && reaches(1) && self.rows(p, grown).all(|row| self.marked[row].iter().all(|m| *m))
    }

    fn meets(&self, p: &Patch) -> bool {
        self.rows(p, 0).any(|row| self.marked[row].iter().any(|m| *m))
    }

    fn mark(&mut self, p: &Patch) {
        self.any = true;
        for row in self.rows(p, GROWN) {
            self.marked[row].fill(true);
        }
    }
}

/// Two triangles instead of one: the edge that is longest across the way of a slide, or in space, is halved.
fn halves(t: &[Point; 3], invariant: &Invariant) -> [[Point; 3]; 2] {
    let length = |k: usize| {
        let edge = t[(k + 1) % 3] - t[k];
        if invariant.turns { edge.norm_squared() } else { edge.cross(&invariant.along).norm_squared() }
    };
    let k = (0..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
    let m = nalgebra::center(&a, &b);
    [[a, m, c], [m, b, c]]
}

/// Parts two bodies of neighboring joints into what bears, which is dropped, and the rest.
pub(crate) fn rests(
    machine: &Machine,
    joint: usize,
    bodies: [&MeshShape; 2],
    b_from_a: &Pose,
    clearance: f64,
) -> SkinRests {
    let invariant = Invariant::of(machine, joint);
    let near = clearance + BEARING_MM;
    let mut zone = Zone::round(bodies, &invariant);
    bearing(bodies[0], bodies[1], b_from_a, near, &invariant, &mut zone);
    bearing(bodies[1], bodies[0], &b_from_a.inverse(), near, &invariant, &mut zone);
    if !zone.any {
        // They are apart and whole, like most pairs of a machine: the trees of the bodies are used
        // as they are.
        return SkinRests { skins: bodies.map(|body| body.boxes.clone()), left_out: [0.0; 2], idle: Vec::new() };
    }
    let rest = bodies.map(|body| outside(body.boxes.triangles(), &invariant, &zone));
    let area = |t: &[[Point; 3]]| -> f64 { t.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).norm()).sum() };
    let left_out = [0, 1].map(|k| 1.0 - area(&rest[k]) / area(bodies[k].boxes.triangles()).max(f64::MIN_POSITIVE));
    let at_rest = BearingBodies { bodies, b_from_a, near, invariant: &invariant, zone: &zone };
    let idle = neighbor_shells::pairs(&at_rest, bodies.map(|body| &body.boxes));
    SkinRests { skins: rest.map(|triangles| Arc::new(TriangleTree::of_triangles(triangles))), left_out, idle }
}

/// Two bodies at rest, with the zone in which they bear on each other.
struct BearingBodies<'a> {
    bodies: [&'a MeshShape; 2],
    b_from_a: &'a Pose,
    near: f64,
    invariant: &'a Invariant,
    zone: &'a Zone,
}

impl neighbor_shells::Bodies for BearingBodies<'_> {
    fn in_zone(&self, triangles: &[[Point; 3]]) -> bool {
        triangles.iter().all(|t| self.zone.meets(&self.invariant.patch(t)))
            && outside(triangles, self.invariant, self.zone).is_empty()
    }

    fn bears(&self, body: usize, triangles: &[[Point; 3]]) -> bool {
        let other = self.bodies[1 - body];
        let other_from_body = if body == 0 { *self.b_from_a } else { self.b_from_a.inverse() };
        let moved = |t: &[Point; 3]| t.map(|p| other_from_body.point(&p));
        triangles.iter().any(|t| skin_within(&other.boxes, &moved(t), self.near))
            || triangles.first().is_some_and(|t| is_inside(other, &moved(t)[0]))
    }

    fn outline(&self, triangle: &[Point; 3]) -> Patch {
        self.invariant.patch(triangle)
    }
}

/// Rest position of the joint: at zero, or as near to it as its travel allows.
pub(crate) fn at_rest(machine: &Machine, joint: usize) -> JointValues {
    let mut q = JointValues::ZERO;
    if let Some([low, high]) = machine.joints[joint].travel {
        q[joint] = 0.0_f64.max(low).min(high);
    }
    q
}

/// Marks the cells in which the skin of `body` is near or inside of `other`.
fn bearing(
    body: &MeshShape,
    other: &MeshShape,
    other_from_body: &Pose,
    near: f64,
    invariant: &Invariant,
    zone: &mut Zone,
) {
    let Some((middle, half)) = other.boxes.root().map(|root| other.boxes.bounds(root)) else { return };
    let mut open: Vec<[Point; 3]> = body.boxes.triangles().to_vec();
    while let Some(t) = open.pop() {
        let moved = t.map(|p| other_from_body.point(&p));
        // Outside the box round all of the other body it is neither near to it nor inside.
        let beside = |k: usize| {
            let [a, b, c] = moved.map(|p| p[k] - middle[k]);
            a.min(b).min(c) > half[k] + near || a.max(b).max(c) < -half[k] - near
        };
        if (0..3).any(beside) {
            continue;
        }
        let patch = invariant.patch(&t);
        if zone.holds(&patch, GROWN) {
            continue;
        }
        if skin_within(&other.boxes, &moved, near) {
            if is_small(&patch) {
                zone.mark(&patch);
            } else {
                open.extend(halves(&t, invariant));
            }
        } else if is_inside(other, &moved[0]) {
            // Wholly inside: every part of it bears.
            mark(&t, invariant, zone);
        }
    }
}

/// Whether a point is inside of a body: by two half lines in directions of no plane that anyone draws, and by
/// solid angles where they disagree.
fn is_inside(body: &MeshShape, p: &Point) -> bool {
    if body.faults.open.is_some() {
        return false;
    }
    let one = body.boxes.winding_crossings(p, &Vector::new(0.571_23, 0.703_41, 0.422_87));
    let other = body.boxes.winding_crossings(p, &Vector::new(-0.318_59, 0.214_73, -0.923_17));
    if one == other { one > 0 } else { body.contains(p) }
}

fn mark(t: &[Point; 3], invariant: &Invariant, zone: &mut Zone) {
    let mut open = vec![*t];
    while let Some(t) = open.pop() {
        let patch = invariant.patch(&t);
        if zone.holds(&patch, GROWN) {
            continue;
        }
        if is_small(&patch) {
            zone.mark(&patch);
        } else {
            open.extend(halves(&t, invariant));
        }
    }
}

fn skin_within(skin: &TriangleTree, t: &[Point; 3], near: f64) -> bool {
    let b = proveout_geom::Aabb::of_points(t);
    let (middle, half) = (b.center(), b.size() * 0.5);
    let apart = |node: u32, _| {
        let (m, h) = skin.bounds(node);
        ((m - middle).abs() - half - h).map(|x| x.max(0.0)).norm()
    };
    let mut found = false;
    let distance = |item: u32, bound: f64| {
        let d = triangle::nearest_within(t, skin.corners(item), bound).square.sqrt();
        found |= d < near;
        // The first that is near ends the search.
        (if d < near { 0.0 } else { d }, ())
    };
    matches!(nearest_leaf(skin, apart, (near, &mut Effort::unlimited()), None, distance), NearestLeaves::At(..))
        || found
}

/// The part of a skin outside of the zone, with pieces at its border that reach in by less than two cells,
/// where nothing bears.
fn outside(triangles: &[[Point; 3]], invariant: &Invariant, zone: &Zone) -> Vec<[Point; 3]> {
    let mut kept = Vec::with_capacity(triangles.len());
    let mut open = triangles.to_vec();
    while let Some(t) = open.pop() {
        let patch = invariant.patch(&t);
        match (zone.meets(&patch), zone.holds(&patch, 0)) {
            (_, true) => {}
            (true, false) if !is_small(&patch) && kept.len() + open.len() < MOST_PIECES => {
                open.extend(halves(&t, invariant))
            }
            _ => kept.push(t),
        }
    }
    kept
}

/// Farthest distance of what is left from a line, mm.
fn farthest(rest: &TriangleTree, point: &Point, direction: &Vector) -> f64 {
    rest.triangles().iter().flatten().map(|p| (p - point).cross(direction).norm()).fold(0.0, f64::max)
}

/// Facets round the axis that a body needs at least to count as round.
const ROUND_FACETS: f64 = 36.0;
/// Turns for which it is tried, radian: no parts of a turn that a drawing divides by.
const ROUND_TURNS: [f64; 4] = [0.037, 0.731, 1.913, 2.817];

/// Whether a body turned about the axis of a joint is where it was, but for its facets: every corner lies on
/// the skin after a turn.
pub(crate) fn is_round(body: &MeshShape, joint: &Joint) -> bool {
    ROUND_TURNS.iter().all(|&angle| {
        let turn = Pose::about_line(&joint.point, &joint.direction, angle);
        body.vertices().all(|p| {
            let radius = (p - joint.point).cross(&joint.direction).norm();
            let facet = radius * (1.0 - (std::f64::consts::PI / ROUND_FACETS).cos());
            skin_within(&body.boxes, &[turn.point(&p); 3], facet + ROUND_MM)
        })
    })
}

/// Whether anything is left to check.
pub(crate) fn is_left(rests: &SkinRests) -> bool {
    rests.skins.iter().all(|s| s.root().is_some()) || !rests.idle.is_empty()
}
