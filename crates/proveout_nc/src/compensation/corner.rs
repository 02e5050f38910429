//! From one block of the contour to the next: where the path of the tool center leaves the first and enters
//! the second.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::contour::{
    self, Element, ElementShape, Meeting, Point, ROUNDING_MM, SAME_POINT_MM, along, cross, dot, inside_corner, left,
    norm, sub,
};
use super::crumb;

/// Sine of the angle between two tangents that are opposite but for rounding.
const REVERSAL: f64 = 1e-9;
/// Width of a sliver between two branches of a cusp that is rounding of the text and no contour, mm.
const SLIVER_MM: f64 = 1e-4;
/// How far the tool may swerve at an outside corner that is taken without a piece of its own, mm.
const FLAT_MM: f64 = 1e-5;
/// Largest change of direction of such a corner, radian, for the smallest tools.
const FLAT_TURN: f64 = 0.1;
/// Rounding of the largest turn that runs to an intersection, radian.
const AT_LIMIT: f64 = 1e-9;
/// Nearer to half a turn than this the lines beside a corner have no intersection, radian.
const TURNED_BACK: f64 = 1e-6;

/// How the dialect guides the tool around and onto the contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompStyle {
    pub(crate) corner: OutsideCorner,
    pub(crate) entry: ContourEntry,
    pub(crate) feed: FeedAt,
    /// KONT: entry and exit go around the contour where they start or end on its far side. On the
    /// side of the tool, as NORM.
    pub(crate) follow_contour: bool,
    /// So many blocks with a motion in the plane the control looks ahead for places where the tool does not
    /// fit.
    pub(crate) look_ahead: usize,
}

/// Outside corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum OutsideCorner {
    /// A circle of the tool radius about the corner.
    Arc,
    /// The intersection of the tangents at the ends of the equidistants, up to a limit.
    Intersection {
        /// Largest change of direction that is made so, radian.
        limit: f64,
        beyond: Beyond,
    },
}

/// Outside corners sharper than the limit of the intersection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beyond {
    /// A circle about the corner.
    Arc,
    /// Both tangents go on for one tool radius, and a line joins them.
    Chamfer,
}

/// The block that leads onto the contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ContourEntry {
    /// It ends on the equidistant at the start of the contour, at a right angle to the first
    /// tangent.
    Perpendicular,
    /// It counts as a block of the contour itself and begins at the uncompensated point.
    Parallel,
}

/// Where the programmed feed holds on arcs of the contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FeedAt {
    /// At the tool center.
    Center,
    /// At the contour.
    Contour,
    /// At the contour on its inside, at the tool center outside.
    ContourInside,
}

impl CompStyle {
    /// Circles at outside corners, perpendicular entry, feed of the tool center.
    pub(crate) const PLAIN: Self = Self {
        corner: OutsideCorner::Arc,
        entry: ContourEntry::Perpendicular,
        feed: FeedAt::Center,
        follow_contour: false,
        look_ahead: 1,
    };

    /// Fanuc: intersection up to a right angle, a chamfer beyond; start-up and cancel of type A.
    /// Three blocks are read ahead (the least that parameter 19625 allows): each block is checked
    /// against the two after it.
    pub(crate) const FANUC: Self = Self {
        corner: OutsideCorner::Intersection { limit: FRAC_PI_2, beyond: Beyond::Chamfer },
        look_ahead: 2,
        ..Self::PLAIN
    };

    /// `LinuxCNC`: circles; the entry block is a part of the contour.
    pub(crate) const LINUX_CNC: Self = Self { entry: ContourEntry::Parallel, ..Self::PLAIN };
}

/// A piece between the equidistants of two blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CornerPiece {
    LineTo(Point),
    /// About the programmed corner.
    ArcTo {
        end: Point,
        counter_clockwise: bool,
        sweep: f64,
    },
}

impl CornerPiece {
    /// Its line or arc from a point, about the programmed corner.
    pub(super) fn element(&self, start: Point, corner: Point, offset: f64) -> Element {
        match *self {
            Self::LineTo(end) => Element { start, end, shape: ElementShape::Line },
            Self::ArcTo { end, counter_clockwise, sweep } => {
                let shape = ElementShape::Arc { center: corner, radius: offset.abs(), counter_clockwise, sweep };
                Element { start, end, shape }
            }
        }
    }
}

/// The way around a corner.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Join {
    /// Where the first block ends.
    pub(super) end: Point,
    /// What the corner cuts off the end of the first block, in the unit of [`Element::extent`];
    /// negative where the block goes on beyond its end.
    pub(super) taken: f64,
    pub(super) pieces: Vec<CornerPiece>,
    /// Where the second block begins.
    pub(super) start: Point,
    /// What that takes from the second block; below zero where it begins before its start.
    pub(super) used: f64,
}

impl Join {
    /// The first block ends at the end of its equidistant, the second begins at the start of its
    /// own.
    pub(super) fn beside(end: Point, pieces: Vec<CornerPiece>, start: Point) -> Self {
        Self { end, taken: 0.0, pieces, start, used: 0.0 }
    }

    fn at(meeting: Meeting) -> Self {
        let Meeting { point, taken, used } = meeting;
        Self { end: point, taken, pieces: Vec::new(), start: point, used }
    }

    /// The end of a contour, and the end of a perpendicular entry.
    pub(super) fn end_at(point: Point) -> Self {
        Self::beside(point, Vec::new(), point)
    }
}

/// A block of which the end is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockStart {
    pub(super) element: Element,
    /// Where the tool center begins it.
    pub(super) from: Point,
    /// What is left of it from there, in the unit of [`Element::extent`]; below zero where the tool is past
    /// its end.
    pub(super) rest: f64,
}

/// Way from one block to the next with the tool `offset` to the left of the motion; none when the tool does
/// not fit into the corner. `straight_only`: circles are not possible (rapid motion).
pub(super) fn join(
    begun: &BlockStart,
    second: &Element,
    offset: f64,
    corner: OutsideCorner,
    straight_only: bool,
) -> Option<Join> {
    let BlockStart { element: first, from: _, rest } = begun;
    let rest = *rest;
    if rest < -ROUNDING_MM {
        return crumb::past_end(begun, second, offset, straight_only);
    }
    let (s, t) = (first.last_tangent(), second.first_tangent());
    let (p, q) = (first.offset_end(offset), second.offset_start(offset));
    let (sine, cosine) = (cross(s, t), dot(s, t));
    let turn = sine.abs().atan2(cosine);
    if norm(sub(p, q)) < SAME_POINT_MM {
        return Some(Join::beside(p, Vec::new(), q));
    }
    if is_inside(first, second, offset) {
        return inside_corner(first, second, offset, rest)
            .map(Join::at)
            .or_else(|| flat_corner(first, second, offset, rest, turn, true))
            .or_else(|| gap(first, offset, p, q, turn))
            .or_else(|| crumb::swallowed(begun, second, offset));
    }
    if let Some(join) = flat_corner(first, second, offset, rest, turn, false) {
        return Some(join);
    }
    let corner = match corner {
        OutsideCorner::Arc if straight_only => {
            OutsideCorner::Intersection { limit: FRAC_PI_2, beyond: Beyond::Chamfer }
        }
        OutsideCorner::Intersection { limit, beyond: Beyond::Arc } if straight_only => {
            OutsideCorner::Intersection { limit: limit.min(FRAC_PI_2), beyond: Beyond::Chamfer }
        }
        other => other,
    };
    // Tool center at the end of the first block: where an arc does not end on its circle, `p` is a
    // little off.
    let beside = along(first.end, left(s), offset);
    let mut pieces = Vec::new();
    let (to, from) = match corner {
        OutsideCorner::Intersection { limit, .. } if turn <= limit + AT_LIMIT && turn < PI - TURNED_BACK => {
            let point = along(beside, s, offset.abs() * (0.5 * turn).tan());
            (point, point)
        }
        OutsideCorner::Intersection { beyond: Beyond::Chamfer, .. } => {
            (along(beside, s, offset.abs()), along(q, t, -offset.abs()))
        }
        OutsideCorner::Arc | OutsideCorner::Intersection { beyond: Beyond::Arc, .. } => {
            if norm(sub(p, beside)) > SAME_POINT_MM {
                pieces.push(CornerPiece::LineTo(beside));
            }
            // At a cusp whose tangents have crossed by rounding, the way around is a little more than half a
            // turn.
            let crossed = cosine < 0.0 && offset * sine > 0.0;
            let sweep = if crossed { TAU - turn } else { turn };
            pieces.push(CornerPiece::ArcTo { end: q, counter_clockwise: offset < 0.0, sweep });
            return Some(Join::beside(p, pieces, q));
        }
    };
    // A line runs on to the intersection by itself; an arc ends at the corner, and its tangent goes
    // on.
    let (end, taken) = if first.shape == ElementShape::Line {
        (to, -norm(sub(to, p)))
    } else {
        pieces.push(CornerPiece::LineTo(to));
        (p, 0.0)
    };
    if norm(sub(to, from)) > SAME_POINT_MM {
        pieces.push(CornerPiece::LineTo(from));
    }
    let (start, used) = if second.shape == ElementShape::Line {
        (from, -norm(sub(q, from)))
    } else {
        pieces.push(CornerPiece::LineTo(q));
        (q, 0.0)
    };
    Some(Join { end, taken, pieces, start, used })
}

/// Whether the tool runs inside of a corner, `offset` to the left of the motion.
///
/// Away from a cusp the tangents `s` and `t` decide: inside where `offset * (s x t) > 0`. At a
/// cusp, where the path turns back, both branches leave the corner in nearly the same direction,
/// and their bends decide what lies between them.
///
/// ```text
///        first  .              . second       y1 = (s x t) l - k1 l^2 / 2    the first branch, l from P
///                .   tool     .               y2 =             k2 l^2 / 2    the second, both left of t
///                 .  inside  .
///                  ..      ..                 opening y1 - y2 = (s x t) l - (k1 + k2) l^2 / 2
///                    .    .      ^ t
///                     .  .       | l
///                      ..        P
/// ```
///
/// With curvatures `k` that are above zero to the left, the tool on the left is inside where the opening is
/// above zero, the tool on the right where it is below. Where tangents and bends disagree, the branches cross
/// again at `l = 2 (s x t) / (k1 + k2)`, and between lies a sliver that is `(s x t)^2 / (2 |k1 + k2|)` wide
/// at most. A sliver below [`SLIVER_MM`] comes from rounding of the text, and the bends decide. Two branches
/// that lie on each other (a line and back, an arc and back) leave nothing between them: the tool goes around
/// their end.
fn is_inside(first: &Element, second: &Element, offset: f64) -> bool {
    let (s, t) = (first.last_tangent(), second.first_tangent());
    let sine = cross(s, t);
    if dot(s, t) < 0.0 {
        let bend = first.curvature() + second.curvature();
        let length = first.length().min(second.length());
        let parted = 0.5 * bend.abs() * length * length > SLIVER_MM;
        if parted && sine * sine < 2.0 * bend.abs() * SLIVER_MM && 2.0 * sine.abs() < bend.abs() * length {
            return offset * bend < 0.0;
        }
        if sine.abs() < REVERSAL {
            return false;
        }
    }
    offset * sine > 0.0
}

/// The sharpest corner that is taken without a piece of its own: the two equidistants meet, a little beyond
/// their ends at an outside corner.
///
/// At a change of direction `w` their tangents meet `|o| tan(w / 2)` beyond the end of the first,
/// and that point is `|o| (1 / cos(w / 2) - 1)`, about `|o| w^2 / 8`, farther from the corner than
/// the tool radius. Below [`FLAT_MM`] a piece on a circle around the corner would be a few
/// micrometers long, which makes no difference to any control. Where the equidistants bend away
/// from their tangents by no more than rounding, the points along them are taken as one; else they
/// are intersected.
fn flat_corner(first: &Element, second: &Element, offset: f64, rest: f64, turn: f64, inside: bool) -> Option<Join> {
    if turn > FLAT_TURN || offset.abs() * turn * turn > 8.0 * FLAT_MM {
        return None;
    }
    let reach = offset.abs() * (0.5 * turn).tan();
    let sign = if inside { 1.0 } else { -1.0 };
    let (on_first, on_second) =
        (reach / first.offset_radius(offset).unwrap_or(1.0), reach / second.offset_radius(offset).unwrap_or(1.0));
    let bends_little = |e: &Element, by: f64| e.shape == ElementShape::Line || by < FLAT_TURN;
    if !bends_little(first, on_first) || !bends_little(second, on_second) {
        return None;
    }
    let fits = |taken: f64, used: f64| !inside || taken <= rest && used <= second.extent();
    let (taken, used) = (sign * on_first, sign * on_second);
    let (end, start) = (first.behind_end(-taken, offset), second.behind_start(used, offset));
    if norm(sub(end, start)) <= ROUNDING_MM {
        return fits(taken, used).then(|| Join { end, taken, pieces: Vec::new(), start, used });
    }
    contour::intersections(first, second, offset).into_iter().flatten().find_map(|point| {
        let beyond = norm(sub(point, second.start)) - offset.abs();
        let near = norm(sub(point, end)) <= reach + SAME_POINT_MM && beyond > -FLAT_MM && beyond < 3.0 * FLAT_MM;
        let (taken, used) = (first.before_end(point, offset), second.after_start(point, offset));
        (near && fits(taken, used)).then(|| Join::at(Meeting { point, taken, used }))
    })
}

/// A line across the gap that an arc leaves which does not end on its circle (its radii differ within the
/// tolerance of the reader), where the path goes straight on and the equidistants do not meet.
fn gap(first: &Element, offset: f64, p: Point, q: Point, turn: f64) -> Option<Join> {
    let off = norm(sub(p, along(first.end, left(first.last_tangent()), offset)));
    let across = norm(sub(p, q));
    (off > SAME_POINT_MM && across <= 2.0 * off && turn < FLAT_TURN)
        .then(|| Join::beside(p, vec![CornerPiece::LineTo(q)], q))
}

/// What to say about a tool that does not fit: the largest radius that would.
pub(super) fn fitting_radius(first: &Element, second: &Element, offset: f64) -> f64 {
    contour::largest_inside(first, second, offset)
}
