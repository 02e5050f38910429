//! How deep a point lies in what a cutter has swept, and which half space holds all of it.
//!
//! Two questions about a moving convex body, both answered from its closed form:
//!
//! ```text
//!   distance(p):  least over time of the signed distance of p to the cutter        p inside of the swept piece: below 0
//!   least(n):     least of n . x over all x of the swept piece                     {x: n . x >= least(n)} holds it
//! ```
//!
//! **Distance.** The signed distance to a convex body is a convex function of the point. While the axis
//! keeps its direction, the point moves straight in the frame of the tool. The distance is then a convex
//! function of time, and its tangents close in on the least. A piece that turns is cut into parts that turn
//! so little that no point of the tool leaves its chord by more than [`BULGE`].
//!
//! **Half space.** A body of revolution with the unit axis a reaches `h(n) = max (r sqrt(1 - (n.a)^2) + z n.a)` along n over its generating
//! curve: at an end of a line or an arc, or where the arc's normal is n. Of a straight motion one of the ends reaches farthest. A point of
//! a part that turns by the angle w leaves its chord by `reach w^2 / 8` at most, which is taken off.
//!
//! Pieces lie in a tree of groups of eight that follow each other in time, so that whole passes can be
//! ruled out at once: the tips of a group lie in a box, and its axes within an angle u of their mean, which
//! moves no point by more than `reach u`.

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_tool::Profile;

use super::{PathPiece, outline::Outline};

/// Largest distance of a part of a turning piece from its chord, mm. Below a third of the grain of a gouge search, no
/// block stays undecided.
const BULGE: f64 = 5e-5;
/// Most parts of a piece.
const MOST_PARTS: f64 = 512.0;
/// Members of a group.
const GROUP: usize = 8;
/// Most steps of the search for the nearest time, and the error at which it ends, mm.
const STEPS: usize = 40;
const KNOWN: f64 = 1e-8;
/// What the distance of a piece that turns may lie below its tangents, mm.
const BEND: f64 = 5e-5;
/// Axes that differ by less are one.
const SAME_AXIS: f64 = 1e-12;
/// Reach of a cutter at least where a piece is cut into parts, mm.
const LEAST_REACH: f64 = 1e-6;
/// Axes whose sum is shorter have no mean.
const NO_MEAN: f64 = 1e-6;
/// Error of the distance from a piece that keeps its axis, mm: that of the search, tenfold.
const STRAIGHT_ERROR: f64 = 1e-7;
/// Nearer to the axis than this there is no direction away from it, mm.
const ON_AXIS: f64 = 1e-12;
/// Part of a piece below which a bracket in time is a time.
const NARROW: f64 = 1e-9;

/// A convex body of a cutter on one part of a piece of motion.
#[derive(Clone, Copy, Debug)]
struct Move {
    piece: u32,
    body: u32,
    from: ToolPose,
    to: ToolPose,
    /// No point leaves the chord between its ends by more, mm.
    bulge: f64,
    bounds: Aabb,
}

/// Moves that follow each other.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// The body, where all have the same.
    body: Option<u32>,
    axis: Vector,
    tips: Aabb,
    /// Largest distance of a point from its place with the group's axis held fixed, mm.
    spread: f64,
    bounds: Aabb,
}

/// A move or a group of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepItem {
    /// 0 for a move.
    level: u8,
    index: u32,
}

impl SweepItem {
    /// Whether it is a single convex body on a single piece.
    pub fn is_single(self) -> bool {
        self.level == 0
    }
}

/// How near a point comes to a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InSweep {
    /// Signed distance at the best time, mm; negative inside.
    pub distance: f64,
    /// Outward unit normal of the cutter there.
    pub normal: Vector,
}

/// The swept pieces of a run, ready for both questions.
#[derive(Debug)]
pub struct SweptBodies {
    bodies: Vec<(Outline, f64)>,
    moves: Vec<Move>,
    /// Groups of moves, groups of these, and so on up to one.
    levels: Vec<Vec<Group>>,
}

impl SweptBodies {
    /// The pieces that reach into a box; `cutters` holds the convex bodies of each cutter. Pieces that `without` names are left out.
    pub fn new(
        pieces: &[PathPiece],
        cutters: &[Vec<Profile>],
        within: &Aabb,
        without: &(dyn Fn(u32) -> bool + Sync),
    ) -> Self {
        let reach = |p: &Profile| p.max_radius().hypot(p.z_max().abs().max(p.z_min().abs()));
        let mut bodies = Vec::new();
        let mut of_cutter = Vec::new();
        for profiles in cutters {
            of_cutter.push(bodies.len() as u32..(bodies.len() + profiles.len()) as u32);
            bodies.extend(profiles.iter().map(|p| (Outline::new(p), reach(p))));
        }
        let mut out = Self { bodies, moves: Vec::new(), levels: Vec::new() };
        for (number, piece) in pieces.iter().enumerate() {
            let number = number as u32;
            let Some(own) = piece.cutter.and_then(|c| of_cutter.get(c as usize)).filter(|_| !without(number)) else {
                continue;
            };
            let finite = |p: &ToolPose| p.tip.iter().chain(p.axis.iter()).all(|v| v.is_finite());
            if finite(&piece.from) && finite(&piece.to) {
                own.clone().for_each(|body| out.add(number, body, piece, within));
            }
        }
        out.group();
        out
    }

    fn add(&mut self, number: u32, body: u32, piece: &PathPiece, within: &Aabb) {
        let reach = self.bodies[body as usize].1;
        let angle = piece.from.angle_to(&piece.to);
        let parts = (angle / (8.0 * BULGE / reach.max(LEAST_REACH)).sqrt()).ceil().clamp(1.0, MOST_PARTS);
        let mut from = piece.from;
        for k in 1..=parts as usize {
            let last = k == parts as usize;
            let to = if last { piece.to } else { piece.from.interpolated(&piece.to, k as f64 / parts) };
            let turn = angle / parts;
            let mut part =
                Move { piece: number, body, from, to, bulge: reach * turn * turn / 8.0, bounds: Aabb::empty() };
            part.bounds = self.box_of(&part);
            if part.bounds.intersects(within) {
                self.moves.push(part);
            }
            from = to;
        }
    }

    fn box_of(&self, part: &Move) -> Aabb {
        let mut bounds = Aabb::empty();
        for k in 0..3 {
            let mut n = Vector::zeros();
            n[k] = 1.0;
            (bounds.min[k], bounds.max[k]) = (self.least_of(part, &n), -self.least_of(part, &-n));
        }
        bounds
    }

    fn group(&mut self) {
        let mut level: Vec<Group> = self
            .moves
            .chunks(GROUP)
            .map(|of| {
                let sum: Vector = of.iter().map(|m| m.from.axis + m.to.axis).sum();
                let axis = sum.try_normalize(NO_MEAN).unwrap_or(of[0].from.axis);
                let apart =
                    of.iter().flat_map(|m| [m.from.axis, m.to.axis]).map(|a| (a - axis).norm()).fold(0.0, f64::max);
                let reach = of.iter().map(|m| self.bodies[m.body as usize].1).fold(0.0, f64::max);
                // The chord of an angle, at most a right one, is nine tenths of it or more.
                let spread = if apart > SAME_AXIS { 1.2 * apart * reach } else { 0.0 };
                Group {
                    body: of.iter().all(|m| m.body == of[0].body).then_some(of[0].body),
                    axis,
                    tips: Aabb::of_points(of.iter().flat_map(|m| [&m.from.tip, &m.to.tip])),
                    spread: spread + of.iter().map(|m| m.bulge).fold(0.0, f64::max),
                    bounds: of.iter().fold(Aabb::empty(), |all, m| all.union(&m.bounds)),
                }
            })
            .collect();
        while !level.is_empty() {
            let done = level.len() == 1;
            let above = level
                .chunks(GROUP)
                .map(|of| {
                    let first = of[0];
                    let body = first.body.filter(|_| of.iter().all(|g| g.body == first.body));
                    let reach = body.map_or(0.0, |b| self.bodies[b as usize].1);
                    let lean = of.iter().map(|g| (g.axis - first.axis).norm()).fold(0.0, f64::max);
                    let lean = if lean > SAME_AXIS { 1.2 * lean * reach } else { 0.0 };
                    Group {
                        body,
                        axis: first.axis,
                        tips: of.iter().fold(Aabb::empty(), |all, g| all.union(&g.tips)),
                        spread: lean + of.iter().map(|g| g.spread).fold(0.0, f64::max),
                        bounds: of.iter().fold(Aabb::empty(), |all, g| all.union(&g.bounds)),
                    }
                })
                .collect();
            self.levels.push(std::mem::replace(&mut level, above));
            if done {
                break;
            }
        }
    }

    /// All of them; none where no piece reaches into the box.
    pub fn root(&self) -> Option<SweepItem> {
        (!self.levels.is_empty()).then_some(SweepItem { level: self.levels.len() as u8, index: 0 })
    }

    /// The members of a group, in the order of time.
    pub fn members(&self, item: SweepItem) -> impl DoubleEndedIterator<Item = SweepItem> + use<> {
        let below = match item.level {
            0 => 0,
            1 => self.moves.len(),
            level => self.levels[usize::from(level) - 2].len(),
        };
        let first = item.index as usize * GROUP;
        let level = item.level.saturating_sub(1);
        (first..below.min(first + GROUP)).map(move |k| SweepItem { level, index: k as u32 })
    }

    /// A box that holds it.
    pub fn bounds(&self, item: SweepItem) -> &Aabb {
        match item.level {
            0 => &self.moves[item.index as usize].bounds,
            level => &self.levels[usize::from(level) - 1][item.index as usize].bounds,
        }
    }

    /// Number of the piece of a move; of a group that of its first.
    pub fn piece(&self, item: SweepItem) -> Option<u32> {
        let first = item.index as usize * GROUP.pow(u32::from(item.level));
        self.moves.get(first).map(|m| m.piece)
    }

    /// A lower bound of `n . x` over all that it sweeps, sharp for a move with a fixed axis direction; n is
    /// a unit vector.
    pub fn least(&self, item: SweepItem, n: &Vector) -> f64 {
        if item.level == 0 {
            return self.least_of(&self.moves[item.index as usize], n);
        }
        let group = &self.levels[usize::from(item.level) - 1][item.index as usize];
        let lowest = |b: &Aabb| (0..3).map(|k| n[k] * if n[k] > 0.0 { b.min[k] } else { b.max[k] }).sum::<f64>();
        match group.body {
            Some(body) => lowest(&group.tips) - self.reach(body, &group.axis, n) - group.spread,
            None => lowest(&group.bounds),
        }
    }

    fn least_of(&self, part: &Move, n: &Vector) -> f64 {
        let at = |pose: &ToolPose| pose.tip.coords.dot(n) - self.reach(part.body, &pose.axis, n);
        at(&part.from).min(at(&part.to)) - part.bulge
    }

    /// How far a body reaches from its tip against n.
    fn reach(&self, body: u32, axis: &Vector, n: &Vector) -> f64 {
        let along = -n.dot(axis);
        self.bodies[body as usize].0.support((1.0 - along * along).max(0.0).sqrt(), along)
    }

    /// The signed distance of a point to a move; none for a group.
    pub fn distance(&self, item: SweepItem, p: &Point) -> Option<InSweep> {
        let part = self.moves.get(item.index as usize).filter(|_| item.level == 0)?;
        Some(self.nearest(part, p, [f64::NEG_INFINITY, f64::INFINITY]))
    }

    /// The largest error of [`Self::distance`], mm.
    pub fn distance_error(&self, item: SweepItem) -> f64 {
        STRAIGHT_ERROR
            + self.moves.get(item.index as usize).map_or(0.0, |m| if m.bulge > 0.0 { 2.0 * BEND } else { 0.0 })
    }

    /// The same, but stops early once the point is known to be farther than `far`; the result is then some value above it.
    pub fn distance_within(&self, item: SweepItem, p: &Point, far: f64) -> Option<InSweep> {
        let part = self.moves.get(item.index as usize).filter(|_| item.level == 0)?;
        Some(self.nearest(part, p, [f64::NEG_INFINITY, far]))
    }

    /// Least distance over time; the search ends once it is `enough` or less, or is known to be more than `far`.
    ///
    /// Without a turn, the distance is convex in time and lies above its tangents. The least value is at an end from which
    /// it rises, or above the point where a falling and a rising tangent meet. A turn by the angle a over the way s bends
    /// the path of the point in the tool frame by at most `(|q| a + 2 s) a / 2`, with q from the tip to the point. Time is
    /// then searched in parts that bend by at most [`BEND`].
    fn nearest(&self, part: &Move, p: &Point, [enough, far]: [f64; 2]) -> InSweep {
        let outline = &self.bodies[part.body as usize].0;
        let turn = part.to.axis - part.from.axis;
        let turns = turn.norm() > SAME_AXIS;
        let way = part.to.tip - part.from.tip;
        // Distance, and its rate.
        let at = |time: f64| {
            let (axis, turning) = if turns {
                let chord = part.from.axis + turn * time;
                let length = chord.norm();
                let axis = chord / length;
                (axis, (turn - axis * turn.dot(&axis)) / length)
            } else {
                (part.from.axis, Vector::zeros())
            };
            let q = p - (part.from.tip + way * time);
            let z = q.dot(&axis);
            let out = q - axis * z;
            let r = out.norm();
            let (distance, gradient) = outline.distance(r, z);
            let radial = if r > ON_AXIS { out / r } else { Vector::zeros() };
            let along = q.dot(&turning) - way.dot(&axis);
            let aside = -radial.dot(&way) - z * radial.dot(&turning);
            let seen = InSweep { distance, normal: radial * gradient[0] + axis * gradient[1] };
            (seen, gradient[0] * aside + gradient[1] * along)
        };
        let mut from = at(0.0);
        let mut best = from.0;
        let (way, angle) = (way.norm(), turn.norm() * 1.01);
        let reach = (p - part.from.tip).norm() + way;
        // No point moves faster in the frame of the tool.
        let most = way + reach * angle;
        // What is known to be farther than this is not searched.
        let far = |best: &InSweep| far.min(best.distance);
        let parts = (0.5 * (reach * angle + 2.0 * way) * angle / BEND).sqrt().ceil().clamp(1.0, MOST_PARTS);
        for k in 0..parts as usize {
            if best.distance <= enough || k == 0 && from.0.distance - most > far(&best) {
                break;
            }
            let (begin, end) = (k as f64 / parts, (k + 1) as f64 / parts);
            if from.0.distance - most / parts > far(&best) {
                from = at(end);
                if from.0.distance < best.distance {
                    best = from.0;
                }
                continue;
            }
            let to = at(end);
            if to.0.distance < best.distance {
                best = to.0;
            }
            let (mut lo, mut hi) = ((begin, from.0.distance, from.1), (end, to.0.distance, to.1));
            from = to;
            if lo.2 >= 0.0 || hi.2 <= 0.0 {
                continue;
            }
            for _ in 0..STEPS {
                let meet = (hi.1 - lo.1 + lo.2 * lo.0 - hi.2 * hi.0) / (lo.2 - hi.2);
                let bound = lo.1 + lo.2 * (meet - lo.0) - if turns { BEND } else { 0.0 };
                if best.distance <= enough || bound > far(&best) - KNOWN || hi.0 - lo.0 < NARROW {
                    break;
                }
                let room = 0.05 * (hi.0 - lo.0);
                let time = meet.clamp(lo.0 + room, hi.0 - room);
                let (here, rate) = at(time);
                if here.distance < best.distance {
                    best = here;
                }
                if rate > 0.0 {
                    hi = (time, here.distance, rate);
                } else {
                    lo = (time, here.distance, rate);
                }
            }
        }
        best
    }

    /// The last piece that came within `margin` (mm) of a point; a negative margin asks for points inside.
    pub fn last_to_reach(&self, p: &Point, margin: f64) -> Option<u32> {
        self.last_of(self.root()?, p, margin)
    }

    /// Whether a piece, or one next to it, came within `margin` (mm) of a point.
    pub fn reaches(&self, piece: u32, p: &Point, margin: f64) -> bool {
        let from = self.moves.partition_point(|m| m.piece < piece.saturating_sub(1));
        let near = self.moves[from..].iter().take_while(|m| m.piece <= piece.saturating_add(1));
        let reach = |m: &Move| m.bounds.expanded(margin.max(0.0)).contains(p);
        near.filter(|m| reach(m)).any(|m| self.nearest(m, p, [margin; 2]).distance <= margin)
    }

    fn last_of(&self, item: SweepItem, p: &Point, margin: f64) -> Option<u32> {
        if !self.bounds(item).expanded(margin.max(0.0)).contains(p) {
            return None;
        }
        if item.level == 0 {
            let part = &self.moves[item.index as usize];
            return (self.nearest(part, p, [margin; 2]).distance <= margin).then_some(part.piece);
        }
        self.members(item).rev().find_map(|member| self.last_of(member, p, margin))
    }
}
