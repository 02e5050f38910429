//! Blocks so short that the tool passes them.
//!
//! Programs of CAM systems have blocks of a few micrometers that turn because their coordinates are
//! rounded. At an inside corner of such a crumb the equidistants meet beyond its end,
//! `o tan(w / 2)` from the corner for a turn of `w`, however little the crumb projects from the contour:
//!
//! ```text
//!              p              the tool center at the end of the first block
//!              :
//!              : o            the crumb ends at Q, L after P:  |p - Q|^2 = o^2 - 2 o L sin w + L^2
//!              :              so that the tool at p is less than L sin w into it
//!   -----------P.. Q------    which is how far Q projects from the first block
//! ```
//!
//! Where that is below [`CRUMB_MM`], the tool goes on past the crumb, and the path takes up the
//! contour after it. A block longer than [`SHORT_MM`] is never passed: the part of the contour that
//! is not followed must be a crumb as well.

use super::contour::{
    Element, ElementShape, LEAST_RADIUS_MM, Point, ROUNDING_MM, SAME_POINT_MM, along, cross, dot, norm, sub, unit,
};
use super::corner::{BlockStart, CornerPiece, Join};
use super::distance;

/// How far a crumb may project from the neighboring contour, mm: below the last digit of programs,
/// and below the least cut.
const CRUMB_MM: f64 = 9e-4;
/// Longest crumb, mm.
const SHORT_MM: f64 = 0.05;
/// Largest turn into a crumb and along it, radian.
const BENT: f64 = 0.5;

/// Goes on where the tool does not fit into the corner, past the second block or past what is left of the
/// first; none where one of both is more than a crumb.
pub(super) fn swallowed(begun: &BlockStart, second: &Element, offset: f64) -> Option<Join> {
    let first = &begun.element;
    if turn_between(first.last_tangent(), second.first_tangent()) > BENT {
        return None;
    }
    if is_crumb(first)
        && let Some(join) = take_up(begun, second, offset)
    {
        return Some(join);
    }
    let end = first.offset_end(offset);
    let clear = distance::nearest(second, end).0 >= offset.abs() - CRUMB_MM;
    let used = second.after_start(end, offset);
    (is_crumb(second) && clear && used >= second.extent()).then(|| Join {
        end,
        taken: 0.0,
        pieces: Vec::new(),
        start: end,
        used,
    })
}

/// The next block where the tool is past the end of the one before.
pub(super) fn past_end(begun: &BlockStart, second: &Element, offset: f64, straight_only: bool) -> Option<Join> {
    take_up(begun, second, offset).or_else(|| {
        // Not yet at the next block: around its start, from the present tool center.
        let (corner, start) = (second.start, second.offset_start(offset));
        let from = sub(begun.from, corner);
        if norm(from) < offset.abs() - CRUMB_MM {
            return None;
        }
        let beside = along(corner, unit(from), offset.abs());
        let to = sub(start, corner);
        let turn = -offset.signum() * cross(from, to).atan2(dot(from, to));
        let mut pieces = Vec::new();
        let mut step = |from: Point, to: Point| {
            if norm(sub(to, from)) > SAME_POINT_MM {
                pieces.push(CornerPiece::LineTo(to));
            }
        };
        if norm(sub(start, begun.from)) <= 2.0 * SHORT_MM {
            step(begun.from, start);
        } else if turn > 0.0 && norm(sub(beside, begun.from)) <= CRUMB_MM && !straight_only {
            step(begun.from, beside);
            pieces.push(CornerPiece::ArcTo { end: start, counter_clockwise: offset < 0.0, sweep: turn });
        } else {
            return None;
        }
        Some(Join { end: begun.from, taken: begun.rest, pieces, start, used: 0.0 })
    })
}

/// The second block from the present tool center, when that is on its equidistant.
fn take_up(begun: &BlockStart, second: &Element, offset: f64) -> Option<Join> {
    let from = begun.from;
    let used = second.after_start(from, offset);
    let foot = second.behind_start(used, offset);
    let rounding = second.offset_radius(offset).map_or(ROUNDING_MM, |r| ROUNDING_MM / r.abs().max(LEAST_RADIUS_MM));
    if used < -rounding || used > second.extent() || norm(sub(from, foot)) > CRUMB_MM {
        return None;
    }
    // An arc begins on its circle; a line leads from the present tool center to its end.
    let (start, pieces): (Point, _) = match second.shape {
        ElementShape::Line => (from, Vec::new()),
        ElementShape::Arc { .. } => (foot, vec![CornerPiece::LineTo(foot)]),
    };
    Some(Join { end: from, taken: begun.rest, pieces, start, used })
}

fn is_crumb(element: &Element) -> bool {
    element.length() <= SHORT_MM && (element.curvature() * element.length()).abs() <= BENT
}

fn turn_between(s: Point, t: Point) -> f64 {
    cross(s, t).atan2(dot(s, t)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(start: Point, end: Point) -> Element {
        Element { start, end, shape: ElementShape::Line }
    }

    #[test]
    fn a_step_of_a_micrometer_is_passed() {
        // 10 mm, a crumb that rises by 0.5 um within 1 um, 10 mm on: the tool of 5 mm on the left cannot
        // follow the crumb.
        let (a, crumb, b) =
            (line([-10.0, 0.0], [0.0, 0.0]), line([0.0, 0.0], [1e-3, 5e-4]), line([1e-3, 5e-4], [10.0, 5e-4]));
        let begun = |element: Element, from, rest| BlockStart { element, from, rest };
        let onto = swallowed(&begun(a, [-10.0, 5.0], 10.0), &crumb, 5.0).unwrap();
        assert_eq!((onto.end, onto.start), ([0.0, 5.0], [0.0, 5.0]));
        assert!(onto.used > crumb.extent(), "the tool is past the crumb");
        let off = past_end(&begun(crumb, onto.start, crumb.extent() - onto.used), &b, 5.0, false).unwrap();
        // Not yet at the next line: a step forward, of half a micrometer up.
        assert_eq!(off.end, [0.0, 5.0]);
        assert!(norm(sub(off.start, [1e-3, 5.0 + 5e-4])) < 1e-12 && off.pieces.len() == 1);
        // Two micrometers are no crumb any more.
        let step = line([0.0, 0.0], [1e-3, 2e-3]);
        assert_eq!(swallowed(&begun(a, [-10.0, 5.0], 10.0), &step, 5.0), None);
    }
}
