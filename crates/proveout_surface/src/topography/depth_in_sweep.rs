//! How deep a point lies in what a cutter has swept, and which half space holds all of it.
//!
//! Two questions about a moving convex body, both answered from its closed form:
//!
//! ```text
//!   distance(p):  least over time of the signed distance of p to the cutter
//!                 p inside of the swept piece: below 0
//!   least(n):     least of n . x over all x of the swept piece
//!                 {x: n . x >= least(n)} holds it
//! ```
//!
//! **Distance.** The signed distance to a convex body is a convex function of the point. While the axis
//! keeps its direction, the point moves straight in the frame of the tool. The distance is then a convex
//! function of time, and its tangents close in on the least. A piece that turns is cut into parts that turn
//! so little that no point of the tool leaves its chord by more than [`BULGE`].
//!
//! **Half space.** A body of revolution with the unit axis a reaches `h(n) = max (r sqrt(1 - (n.a)^2) + z
//! n.a)` along n over its generating curve: at an end of a line or an arc, or where the arc's normal is n. Of
//! a straight motion one of the ends reaches farthest. A point of a part that turns by the angle w leaves its
//! chord by `reach w^2 / 8` at most, which is taken off.
//!
//! Pieces lie in a tree of groups of eight that follow each other in time, so that whole passes can be ruled
//! out at once. A point of the axis is chosen in each body (its pivot: the center of a ball's sphere). In a
//! group the pivots lie in a box and the axes within an angle u of their mean. About its pivot a body has the
//! support function s(w), w being the angle between n and its axis, so that the group reaches no farther
//! along n than the largest s in `[w - u, w + u]`. Support functions are convex: between the ends v and w of
//! an angle of at most a right one, `s <= max (s(v), s(w)) / cos ((w - v) / 2)` where this is positive. For a
//! ball that is its radius, however its axis turns.

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_tool::{Profile, Segment};

use super::{PathPiece, outline::CutterOutline};

/// Largest distance of a part of a turning piece from its chord, mm. Below a third of the grain of a gouge
/// search, no block stays undecided.
const BULGE: f64 = 5e-5;
/// Levels of groups round a piece that are searched before all others.
const NEIGHBORS: u32 = 2;
/// Most parts of a piece.
const MOST_PARTS: f64 = 512.0;
/// Members of a group.
const GROUP: usize = 8;
/// Most steps of the search for the nearest time, and the error at which it ends, mm.
const STEPS: usize = 40;
const KNOWN: f64 = 1e-8;
/// What the distance of a piece that turns may lie below its tangents, mm.
const BEND: f64 = 5e-5;
/// Groups whose axes lean more are bounded by their boxes alone, radian.
const WIDEST_LEAN: f64 = 0.7;
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

/// A convex body of a cutter.
#[derive(Clone, Debug)]
struct ConvexBody {
    outline: CutterOutline,
    /// Largest distance from the tip, mm.
    reach: f64,
    /// Height of the pivot above the tip, mm.
    pivot: f64,
}

impl ConvexBody {
    fn new(profile: &Profile) -> Self {
        let arc = profile.segments().iter().find_map(|s| match s {
            Segment::Arc { center, .. } => Some(center[1]),
            Segment::Line { .. } => None,
        });
        let reach = profile.max_radius().hypot(profile.z_max().abs().max(profile.z_min().abs()));
        Self { outline: CutterOutline::new(profile), reach, pivot: arc.unwrap_or(0.0) }
    }

    /// How far the body reaches from its pivot along a direction; `across` and `along` are sine and cosine of
    /// its angle to the axis.
    fn about_pivot(&self, [across, along]: [f64; 2]) -> f64 {
        self.outline.support(across, along) - self.pivot * along
    }

    /// The largest of these within an angle of at most the lean of a group; infinite for wide ones. The ends
    /// of the range come from the sums of angles, so that no angle is taken.
    fn about_pivot_within(&self, along: f64, lean: &Lean) -> f64 {
        let across = (1.0 - along * along).max(0.0).sqrt();
        if lean.angle <= 0.0 {
            return self.about_pivot([across, along]);
        }
        if lean.angle > WIDEST_LEAN {
            return f64::INFINITY;
        }
        let [sine, cosine] = lean.sine_and_cosine;
        // Where the range passes the axis it ends there.
        let end = |sine: f64| {
            let turned = [across * cosine + along * sine, along * cosine - across * sine];
            if turned[0] > 0.0 { turned } else { [0.0, along.signum()] }
        };
        let most = self.about_pivot(end(-sine)).max(self.about_pivot(end(sine)));
        if most > 0.0 { most / cosine } else { most }
    }
}

/// An angle between axes, radian, with what is asked of it many times.
#[derive(Clone, Copy, Debug)]
struct Lean {
    angle: f64,
    sine_and_cosine: [f64; 2],
}

impl Lean {
    fn new(angle: f64) -> Self {
        let (sine, cosine) = angle.sin_cos();
        Self { angle, sine_and_cosine: [sine, cosine] }
    }
}

/// The angle between two unit vectors, radian.
fn angle_between(a: &Vector, b: &Vector) -> f64 {
    2.0 * (0.5 * (a - b).norm()).min(1.0).asin()
}

/// Moves that follow each other.
#[derive(Clone, Copy, Debug)]
struct MoveGroup {
    /// The body, where all have the same.
    body: Option<u32>,
    axis: Vector,
    /// Largest angle of an axis to this one.
    lean: Lean,
    pivots: Aabb,
    /// Largest bulge of its moves, mm.
    bulge: f64,
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
pub struct MoveDistance {
    /// Signed distance at the best time, mm; negative inside.
    pub distance: f64,
    /// Outward unit normal of the cutter there.
    pub normal: Vector,
}

/// The swept pieces of a run, ready for both questions.
#[derive(Debug)]
pub struct SweptBodies {
    bodies: Vec<ConvexBody>,
    moves: Vec<Move>,
    /// Groups of moves, groups of these, and so on up to one.
    levels: Vec<Vec<MoveGroup>>,
}

impl SweptBodies {
    /// The pieces that reach into a box; `cutters` holds the convex bodies of each cutter. Pieces that
    /// `without` names are left out.
    pub fn new(
        pieces: &[PathPiece],
        cutters: &[Vec<Profile>],
        within: &Aabb,
        without: &(dyn Fn(u32) -> bool + Sync),
    ) -> Self {
        let mut bodies = Vec::new();
        let mut of_cutter = Vec::new();
        for profiles in cutters {
            of_cutter.push(bodies.len() as u32..(bodies.len() + profiles.len()) as u32);
            bodies.extend(profiles.iter().map(ConvexBody::new));
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
        let reach = self.bodies[body as usize].reach;
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
        let mut level: Vec<MoveGroup> = self
            .moves
            .chunks(GROUP)
            .map(|of| {
                let sum: Vector = of.iter().map(|m| m.from.axis + m.to.axis).sum();
                let axis = sum.try_normalize(NO_MEAN).unwrap_or(of[0].from.axis);
                let axes = of.iter().flat_map(|m| [&m.from.axis, &m.to.axis]);
                let pivot = |m: &Move, pose: &ToolPose| pose.tip + pose.axis * self.bodies[m.body as usize].pivot;
                let pivots: Vec<Point> = of.iter().flat_map(|m| [pivot(m, &m.from), pivot(m, &m.to)]).collect();
                MoveGroup {
                    body: of.iter().all(|m| m.body == of[0].body).then_some(of[0].body),
                    axis,
                    lean: Lean::new(axes.map(|a| angle_between(a, &axis)).fold(0.0, f64::max)),
                    pivots: Aabb::of_points(&pivots),
                    bulge: of.iter().map(|m| m.bulge).fold(0.0, f64::max),
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
                    MoveGroup {
                        body,
                        axis: first.axis,
                        lean: Lean::new(
                            of.iter().map(|g| angle_between(&g.axis, &first.axis) + g.lean.angle).fold(0.0, f64::max),
                        ),
                        pivots: of.iter().fold(Aabb::empty(), |all, g| all.union(&g.pivots)),
                        bulge: of.iter().map(|g| g.bulge).fold(0.0, f64::max),
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

    /// How far the places of the body in a group are apart, mm; of several bodies the size of their box.
    pub fn extent(&self, item: SweepItem) -> f64 {
        if item.level == 0 {
            return 0.0;
        }
        let group = &self.levels[usize::from(item.level) - 1][item.index as usize];
        match group.body {
            Some(body) => group.pivots.size().max() + group.lean.angle * self.bodies[body as usize].reach,
            None => group.bounds.size().max(),
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
        let of_box = lowest(&group.bounds);
        group.body.map_or(of_box, |body| {
            let along = (-n.dot(&group.axis)).clamp(-1.0, 1.0);
            let reach = self.bodies[body as usize].about_pivot_within(along, &group.lean);
            of_box.max(lowest(&group.pivots) - reach - group.bulge)
        })
    }

    /// Direction from a point to the cutter in the middle of the motion: a good normal for a plane between
    /// them. None for groups of several bodies.
    pub fn toward(&self, item: SweepItem, p: &Point) -> Option<Vector> {
        let (body, tip, axis) = if item.level == 0 {
            let part = &self.moves[item.index as usize];
            let axis = part.from.axis + part.to.axis;
            (part.body, part.from.tip + (part.to.tip - part.from.tip) * 0.5, axis.try_normalize(NO_MEAN)?)
        } else {
            let group = &self.levels[usize::from(item.level) - 1][item.index as usize];
            let body = group.body?;
            (body, group.pivots.center() - group.axis * self.bodies[body as usize].pivot, group.axis)
        };
        let q = p - tip;
        let z = q.dot(&axis);
        let out = q - axis * z;
        let r = out.norm();
        let (_, [across, along]) = self.bodies[body as usize].outline.distance(r, z);
        let radial = if r > ON_AXIS { out / r } else { Vector::zeros() };
        Some(-(radial * across + axis * along))
    }

    fn least_of(&self, part: &Move, n: &Vector) -> f64 {
        let [from, to] = [&part.from, &part.to].map(|pose| pose.tip.coords.dot(n));
        let reach = self.reach(part.body, &part.from.axis, n);
        if part.from.axis == part.to.axis {
            return from.min(to) - reach - part.bulge;
        }
        (from - reach).min(to - self.reach(part.body, &part.to.axis, n)) - part.bulge
    }

    /// How far a body reaches from its tip against n.
    fn reach(&self, body: u32, axis: &Vector, n: &Vector) -> f64 {
        let along = -n.dot(axis);
        self.bodies[body as usize].outline.support((1.0 - along * along).max(0.0).sqrt(), along)
    }

    /// The signed distance of a point to a move; none for a group.
    pub fn distance(&self, item: SweepItem, p: &Point) -> Option<MoveDistance> {
        let part = self.moves.get(item.index as usize).filter(|_| item.level == 0)?;
        Some(self.nearest(part, p, [f64::NEG_INFINITY, f64::INFINITY]))
    }

    /// The largest error of [`Self::distance`], mm.
    pub fn distance_error(&self, item: SweepItem) -> f64 {
        STRAIGHT_ERROR
            + self.moves.get(item.index as usize).map_or(0.0, |m| if m.bulge > 0.0 { 2.0 * BEND } else { 0.0 })
    }

    /// The same, but stops early once the point is known to be farther than `far`; the result is then some
    /// value above it.
    pub fn distance_within(&self, item: SweepItem, p: &Point, far: f64) -> Option<MoveDistance> {
        let part = self.moves.get(item.index as usize).filter(|_| item.level == 0)?;
        Some(self.nearest(part, p, [f64::NEG_INFINITY, far]))
    }

    /// Least distance over time; the search ends once it is `enough` or less, or is known to be more than
    /// `far`.
    ///
    /// Without a turn, the distance is convex in time and lies above its tangents. The least value is at an
    /// end from which it rises, or above the point where a falling and a rising tangent meet. A turn by the
    /// angle a over the way s bends the path of the point in the tool frame by at most `(|q| a + 2 s) a / 2`,
    /// with q from the tip to the point. Time is then searched in parts that bend by at most [`BEND`].
    fn nearest(&self, part: &Move, p: &Point, [enough, far]: [f64; 2]) -> MoveDistance {
        let outline = &self.bodies[part.body as usize].outline;
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
            let seen = MoveDistance { distance, normal: radial * gradient[0] + axis * gradient[1] };
            (seen, gradient[0] * aside + gradient[1] * along)
        };
        let mut from = at(0.0);
        let mut best = from.0;
        let (way, angle) = (way.norm(), turn.norm() * 1.01);
        let reach = (p - part.from.tip).norm() + way;
        // No point moves faster in the frame of the tool.
        let most = way + reach * angle;
        // What is known to be farther than this is not searched.
        let far = |best: &MoveDistance| far.min(best.distance);
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

    /// Whether a piece, or one of those made shortly before or after it, came within `margin` (mm) of a
    /// point.
    pub fn reaches(&self, piece: u32, p: &Point, margin: f64) -> bool {
        let index = self.moves.partition_point(|m| m.piece < piece);
        let group = |level: u32| SweepItem { level: level as u8, index: (index / GROUP.pow(level)) as u32 };
        let is_there = |level: u32| group(level).index < self.levels.get(level as usize - 1).map_or(0, Vec::len) as u32;
        index < self.moves.len()
            && (1..=NEIGHBORS).any(|level| is_there(level) && self.last_of(group(level), p, margin).is_some())
    }

    fn last_of(&self, item: SweepItem, p: &Point, margin: f64) -> Option<u32> {
        if !self.bounds(item).expanded(margin.max(0.0)).contains(p) {
            return None;
        }
        if item.level == 0 {
            let part = &self.moves[item.index as usize];
            return (self.nearest(part, p, [margin; 2]).distance <= margin).then_some(part.piece);
        }
        let is_beyond = |n: Vector| n.dot(&p.coords) + margin.max(0.0) < self.least(item, &n);
        if self.toward(item, p).is_some_and(is_beyond) {
            return None;
        }
        self.members(item).rev().find_map(|member| self.last_of(member, p, margin))
    }
}
