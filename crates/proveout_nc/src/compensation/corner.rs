//! From one block of the contour to the next: where the path of the tool center leaves the first and enters the second.

use std::f64::consts::{FRAC_PI_2, PI};

use super::contour::{self, Element, Point, SAME_POINT_MM, Shape, along, cross, dot, inside_corner, norm, sub};

/// How the dialect guides the tool around and onto the contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompStyle {
    pub(crate) corner: Corner,
    pub(crate) entry: Entry,
    pub(crate) feed: FeedAt,
    /// KONT: entry and exit go around the contour where they lie behind it. Where they lie in front, as NORM.
    pub(crate) follow_contour: bool,
}

/// Outside corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Corner {
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
pub(crate) enum Entry {
    /// It ends beside the start of the contour, at a right angle to its first tangent.
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
    pub(crate) const PLAIN: Self =
        Self { corner: Corner::Arc, entry: Entry::Perpendicular, feed: FeedAt::Center, follow_contour: false };

    /// Fanuc: intersection up to a right angle, a chamfer beyond; start-up and cancel of type A.
    pub(crate) const FANUC: Self =
        Self { corner: Corner::Intersection { limit: FRAC_PI_2, beyond: Beyond::Chamfer }, ..Self::PLAIN };

    /// `LinuxCNC`: circles; the entry block is a part of the contour.
    pub(crate) const LINUX_CNC: Self = Self { entry: Entry::Parallel, ..Self::PLAIN };
}

/// A piece between the equidistants of two blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Piece {
    LineTo(Point),
    /// About the programmed corner.
    ArcTo {
        end: Point,
        counter_clockwise: bool,
        sweep: f64,
    },
}

/// The way around a corner.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Join {
    /// Where the first block ends.
    pub(super) end: Point,
    pub(super) pieces: Vec<Piece>,
    /// Where the second block begins.
    pub(super) start: Point,
}

impl Join {
    fn at(point: Point) -> Self {
        Self { end: point, pieces: Vec::new(), start: point }
    }
}

/// Way from one block to the next with the tool `offset` to the left of the motion; none when the tool does not fit into the
/// corner. `rest`: what is left of the first block. `straight_only`: circles are not possible (rapid motion).
pub(super) fn join(
    first: &Element,
    second: &Element,
    offset: f64,
    rest: f64,
    corner: Corner,
    straight_only: bool,
) -> Option<Join> {
    let (s, t) = (first.last_tangent(), second.first_tangent());
    let (p, q) = (first.offset_end(offset), second.offset_start(offset));
    let (sine, cosine) = (cross(s, t), dot(s, t));
    let reversal = cosine < 0.0 && sine.abs() < 1e-9;
    if norm(sub(p, q)) < SAME_POINT_MM {
        return Some(Join { end: p, pieces: Vec::new(), start: q });
    }
    if offset * sine > 0.0 && !reversal {
        return inside_corner(first, second, offset, rest).map(Join::at);
    }
    let turn = sine.abs().atan2(cosine);
    let corner = match corner {
        Corner::Arc if straight_only => Corner::Intersection { limit: FRAC_PI_2, beyond: Beyond::Chamfer },
        Corner::Intersection { limit, beyond: Beyond::Arc } if straight_only => {
            Corner::Intersection { limit: limit.min(FRAC_PI_2), beyond: Beyond::Chamfer }
        }
        other => other,
    };
    let (to, from) = match corner {
        Corner::Intersection { limit, .. } if turn <= limit + 1e-9 && turn < PI - 1e-6 => {
            let reach = offset.abs() * (0.5 * turn).tan();
            let point = along(p, s, reach);
            (point, point)
        }
        Corner::Intersection { beyond: Beyond::Chamfer, .. } => (along(p, s, offset.abs()), along(q, t, -offset.abs())),
        Corner::Arc | Corner::Intersection { beyond: Beyond::Arc, .. } => {
            let piece = Piece::ArcTo { end: q, counter_clockwise: offset < 0.0, sweep: turn };
            return Some(Join { end: p, pieces: vec![piece], start: q });
        }
    };
    // A line runs on to the intersection by itself; an arc ends beside the corner, and its tangent goes on.
    let mut pieces = Vec::new();
    let end = if first.shape == Shape::Line {
        to
    } else {
        pieces.push(Piece::LineTo(to));
        p
    };
    if norm(sub(to, from)) > SAME_POINT_MM {
        pieces.push(Piece::LineTo(from));
    }
    let start = if second.shape == Shape::Line {
        from
    } else {
        pieces.push(Piece::LineTo(q));
        q
    };
    Some(Join { end, pieces, start })
}

/// End of the entry block: beside the start of the contour.
pub(super) fn perpendicular_entry(second: &Element, offset: f64) -> Join {
    Join::at(second.offset_start(offset))
}

/// What to say about a tool that does not fit: the largest radius that would.
pub(super) fn fitting_radius(first: &Element, second: &Element, offset: f64) -> f64 {
    contour::largest_inside(first, second, offset)
}
