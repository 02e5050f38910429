//! What a cut into the contour means: a tool that does not fit, or a contour that runs over itself.
//!
//! The tool with its center at `c` follows the contour of its block at the contact `k`, and enters the
//! contour of another block at `v`. Two cases look alike there and are not:
//!
//! ```text
//!     does not fit                                  runs over itself
//!
//!   ------------- v ---------->  another block      - - - - - - - v - - - - ->  lead-in, or a pass before
//!              .     .                                         .     .
//!             .   c   .                                       .   c   .
//!              .     .                                         .     .
//!   <------------ k -----------  the block          ------------- k --------->  the block
//! ```
//!
//! Left, `k` lies in front of the other block, on its side of the tool: a smaller tool would fit
//! between both. Right, `k` lies on its far side: the contour itself runs through what the other
//! block would leave, with any tool. Programs do that where they lead in and out on an arc that the
//! full circle crosses, or open a pocket in a spiral. So it is reported as information.
//!
//! Where the tool does not fit and the two blocks lie within the look-ahead of the control, the
//! program is refused. Farther apart the control cuts the contour without an alarm, and so does the
//! twin, which reports it as an error of the contour.

use super::contour::{Element, Point, cross, dot, norm, sub};
use super::distance::{self, ElementPart};
use super::stretch::{CenterPiece, ContourBlock, ContourCut, ContourStretch, PathRole};
use super::{CompensatedReader, Fault};
use crate::codes;
use crate::{AXIS_LETTERS, AxisValues, Command, Location, Op, Overcut, OvercutKind};

/// Contours that come together or cross nearer than this to an end, mm, or at a smaller angle, radian, are
/// taken as touching.
const TOUCH: f64 = 1e-3;
/// Heights that differ by less are one, mm.
const SAME_HEIGHT_MM: f64 = 1e-6;
/// Blocks at each end of a contour that may be a way on or off it.
const LEAD: usize = 3;
/// Places of one kind that a stretch reports one by one; the rest is counted with the last.
const MOST_TOLD: usize = 50;

/// What a cut is; none where it is none, because the path is above the contour.
fn kind(stretch: &ContourStretch, way: &CenterPiece, cut: &ContourCut) -> Option<OvercutKind> {
    let walls = &stretch.walls;
    let wall = walls.get(cut.wall)?;
    let above = match (way.heights, wall.heights) {
        (Some([low, _]), Some([_, high])) => low > high + SAME_HEIGHT_MM,
        _ => false,
    };
    match way.role {
        PathRole::Entry => return (!above).then_some(OvercutKind::Entry),
        PathRole::Exit => return (!above).then_some(OvercutKind::Exit),
        PathRole::Block | PathRole::Corner => {}
    }
    let own = walls.get(way.wall)?;
    let contact = match way.role {
        PathRole::Corner => own.element.start,
        _ => distance::nearest(&own.element, cut.center).1,
    };
    if lies_behind(stretch, cut.wall, contact) && !cross_each_other(&own.element, &wall.element) {
        return Some(OvercutKind::Overlap);
    }
    // Past an end that has no neighbor; within the extent of the block the tool cuts it as well.
    let [start, end] = distance::ends(&wall.element);
    let beyond = |end: Point, out: Point| dot(sub(cut.center, end), out) > TOUCH;
    let free = match distance::nearest(&wall.element, cut.center).2 {
        ElementPart::Inside => false,
        ElementPart::Start => cut.wall == 0 && beyond(start, wall.element.first_tangent().map(|v| -v)),
        ElementPart::End => cut.wall + 1 == walls.len() && beyond(end, wall.element.last_tangent()),
    };
    Some(if free {
        OvercutKind::ContourEnd
    } else if above {
        OvercutKind::Above
    } else {
        OvercutKind::Narrow
    })
}

/// Whether a point lies on the side of a block where the tool does not run.
fn lies_behind(stretch: &ContourStretch, index: usize, point: Point) -> bool {
    let walls = &stretch.walls;
    let Some(wall) = walls.get(index) else { return false };
    let (distance, foot, part) = distance::nearest(&wall.element, point);
    if distance < TOUCH {
        return false;
    }
    let neighbor = match part {
        ElementPart::Inside => None,
        ElementPart::Start => index.checked_sub(1).and_then(|i| walls.get(i)).map(|w| (w.element.last_tangent(), true)),
        ElementPart::End => walls.get(index + 1).map(|w| (w.element.first_tangent(), false)),
    };
    let from = sub(point, foot);
    let in_front = |tangent: Point| wall.offset * cross(tangent, from) > 0.0;
    let tangent = match part {
        ElementPart::Start => wall.element.first_tangent(),
        ElementPart::Inside => wall.element.tangent_at(foot),
        ElementPart::End => wall.element.last_tangent(),
    };
    let front = match neighbor {
        None => in_front(tangent),
        Some((other, before)) => {
            // Inside of a corner the front is before both blocks, outside of it before one of them.
            let turn = if before { cross(other, tangent) } else { cross(tangent, other) };
            let inside = wall.offset * turn > 0.0;
            if inside { in_front(tangent) && in_front(other) } else { in_front(tangent) || in_front(other) }
        }
    };
    !front
}

/// Whether two blocks cross away from their ends.
fn cross_each_other(a: &Element, b: &Element) -> bool {
    real_crossings(a, b).next().is_some()
}

/// Where two blocks cross away from their ends.
fn real_crossings(a: &Element, b: &Element) -> impl Iterator<Item = Point> {
    let (a, b) = (*a, *b);
    distance::crossings(&a, &b).into_iter().flatten().filter(move |x| {
        let away = |e: &Element| distance::ends(e).iter().all(|end| norm(sub(*x, *end)) > TOUCH);
        let angle = cross(a.tangent_at(*x), b.tangent_at(*x)).abs();
        away(&a) && away(&b) && angle > TOUCH
    })
}

/// Where the start or the end of a block lies on another one, away from its ends and at an angle.
fn meets(wall: &Element, block: &Element, start: bool) -> Option<Point> {
    let [first, last] = distance::ends(block);
    let (x, own) = if start { (first, block.first_tangent()) } else { (last, block.last_tangent()) };
    let (distance, foot, part) = distance::nearest(wall, x);
    let away = distance::ends(wall).iter().all(|end| norm(sub(x, *end)) > TOUCH);
    let on = distance < TOUCH && matches!(part, ElementPart::Inside) && away;
    (on && cross(wall.tangent_at(foot), own).abs() > TOUCH).then_some(x)
}

/// A place of the contour: block, and way along it as [`Element::on_from_start`] counts it.
type Place1d = (usize, f64);

/// Ways on and off a contour that crosses itself there, as programs do that begin and end on the extensions
/// of its sides:
///
/// ```text
///              |     ^            Up to the crossing the first blocks, and from it on the last ones, are
///              |     |            no wall that must remain.
///    end - - - X <---+---
///              ^
///              : start
/// ```
///
/// The same where the contour closes at the crossing, or begins there: most contours written by
/// hand end in the corner near which they began.
struct Tails {
    /// The first blocks are a way on up to here.
    start: Option<Place1d>,
    /// The last ones are a way off from here on.
    end: Option<Place1d>,
}

impl Tails {
    fn of(walls: &[ContourBlock]) -> Self {
        let mut tails = Self { start: None, end: None };
        let (count, place) = (walls.len(), |index: usize, e: &Element, x: Point| (index, e.on_from_start(x, 0.0)));
        for (index, own) in walls.iter().enumerate().filter(|(i, _)| *i < LEAD || i + LEAD >= count) {
            for (other, wall) in walls.iter().enumerate().filter(|(k, _)| k.abs_diff(index) > 1) {
                for x in real_crossings(&own.element, &wall.element) {
                    let at: Place1d = place(index, &own.element, x);
                    if index < LEAD && other > index && tails.start.is_none_or(|start| at > start) {
                        tails.start = Some(at);
                    }
                    if index + LEAD >= count && other < index && tails.end.is_none_or(|end| at < end) {
                        tails.end = Some(at);
                    }
                }
            }
        }
        let Some(last) = count.checked_sub(1) else { return tails };
        for near in 0..LEAD {
            // The contour ends on one of its first blocks, or begins on one of its last ones.
            if near + 1 < last
                && let Some(x) = meets(&walls[near].element, &walls[last].element, false)
            {
                let at = place(near, &walls[near].element, x);
                tails.start = Some(tails.start.map_or(at, |start| if start > at { start } else { at }));
            }
            if near + 1 < last
                && let Some(x) = meets(&walls[last - near].element, &walls[0].element, true)
            {
                let at = place(last - near, &walls[last - near].element, x);
                tails.end = Some(tails.end.map_or(at, |end| if end < at { end } else { at }));
            }
        }
        tails
    }

    /// Whether a cut lies on the way on or off.
    fn hold(&self, walls: &[ContourBlock], cut: &ContourCut) -> bool {
        let Some(wall) = walls.get(cut.wall) else { return false };
        let at: Place1d = (cut.wall, wall.element.on_from_start(cut.point, 0.0));
        self.start.is_some_and(|start| at < start) || self.end.is_some_and(|end| at > end)
    }
}

/// Blocks between the one that the tool follows and the one that it cuts, counted as a control reads them.
fn apart(way: &CenterPiece, cut: &ContourCut) -> usize {
    let apart = way.wall.abs_diff(cut.wall);
    // A corner belongs to the block before as well.
    if way.role == PathRole::Corner { apart.min(way.wall.saturating_sub(1).abs_diff(cut.wall)) } else { apart }
}

/// Places of one kind that follow each other along the path.
#[derive(Debug)]
struct OvercutGroup {
    kind: OvercutKind,
    worst: ContourCut,
    blocks: u32,
    last_wall: usize,
}

impl CompensatedReader {
    /// Checks the path of the stretch against its contour: refuses the program, or reports what the
    /// control would cut.
    pub(super) fn check(&mut self) -> Result<(), Fault> {
        let stretch = std::mem::take(&mut self.stretch);
        let told = self.judge(&stretch);
        self.stretch = stretch;
        self.out.extend(told?.into_iter().map(Ok));
        Ok(())
    }

    fn judge(&self, stretch: &ContourStretch) -> Result<Vec<Command>, Fault> {
        let mut places: Vec<OvercutGroup> = Vec::new();
        let mut refused: Option<ContourCut> = None;
        let mut tails: Option<Tails> = None;
        for cut in stretch.cuts() {
            let Some(way) = stretch.ways.get(cut.way) else { continue };
            let Some(mut kind) = kind(stretch, way, &cut) else { continue };
            if kind == OvercutKind::Narrow
                && tails.get_or_insert_with(|| Tails::of(&stretch.walls)).hold(&stretch.walls, &cut)
            {
                kind = OvercutKind::Overlap;
            }
            if kind == OvercutKind::Narrow {
                let later = stretch.walls.get(way.wall.max(cut.wall));
                if later.is_some_and(|wall| apart(way, &cut) <= wall.look_ahead) {
                    refused = refused.filter(|worst| worst.depth >= cut.depth).or(Some(cut));
                }
            }
            let told = places.iter().filter(|place| place.kind == kind).count();
            let goes_on = |place: &&mut OvercutGroup| {
                let near = way.wall <= place.last_wall + 1 || kind == OvercutKind::Overlap || told >= MOST_TOLD;
                place.kind == kind && near
            };
            match places.iter_mut().rev().find(goes_on) {
                Some(place) => {
                    place.blocks += u32::from(way.wall != place.last_wall);
                    place.last_wall = way.wall;
                    if cut.depth > place.worst.depth {
                        place.worst = cut;
                    }
                }
                None => places.push(OvercutGroup { kind, worst: cut, blocks: 1, last_wall: way.wall }),
            }
        }
        if let Some(cut) = refused
            && let Some(way) = stretch.ways.get(cut.way)
        {
            return Err(self.does_not_fit(stretch, way, &cut));
        }
        let tell = |place: &OvercutGroup| {
            let way = stretch.ways.get(place.worst.way)?;
            self.told(stretch, way, &place.worst, place.kind, place.blocks)
        };
        Ok(places.iter().filter_map(tell).collect())
    }

    /// Holds a straight way off the contour against it.
    pub(super) fn check_exit(&mut self, way: &CenterPiece) {
        let Some(stretch) = self.leaving.take().map(|(stretch, _)| stretch) else { return };
        let told = stretch.cut_by(way).and_then(|cut| {
            let mut kind = kind(&stretch, way, &cut)?;
            if Tails::of(&stretch.walls).hold(&stretch.walls, &cut) {
                kind = OvercutKind::Overlap;
            }
            self.told(&stretch, way, &cut, kind, 1)
        });
        self.out.extend(told.map(Ok));
    }

    fn told(
        &self,
        stretch: &ContourStretch,
        way: &CenterPiece,
        cut: &ContourCut,
        kind: OvercutKind,
        blocks: u32,
    ) -> Option<Command> {
        let wall = stretch.walls.get(cut.wall)?;
        let height = wall.heights.map(|[_, high]| high);
        let point = self.plane?.point(cut.point, height);
        let overcut = Overcut {
            kind,
            programmed_point: self.programmed(point),
            depth: cut.depth,
            radius: way.radius,
            contour_file: wall.location.file.clone(),
            contour_line: wall.location.line,
            point,
            blocks,
        };
        Some(Command { location: way.location.clone(), op: Op::Overcut(overcut) })
    }

    /// A point of base coordinates in those of the program, as far as it is known.
    fn programmed(&self, point: AxisValues) -> AxisValues {
        let frame = &self.frame;
        let mut programmed = AxisValues::NONE;
        if !frame.is_rotated() {
            for axis in 0..3 {
                if let Some(value) = point.get(axis) {
                    programmed.put(axis, value - frame.translation[axis] + 0.0);
                }
            }
            return programmed;
        }
        let Some((p, inverse)) = point.xyz().zip(frame.inverse_linear()) else { return point };
        for (axis, row) in inverse.iter().enumerate() {
            let value = (0..3).map(|column| row[column] * (p[column] - frame.translation[column])).sum::<f64>();
            programmed.put(axis, value + 0.0);
        }
        programmed
    }

    fn does_not_fit(&self, stretch: &ContourStretch, way: &CenterPiece, cut: &ContourCut) -> Fault {
        let (Some(own), Some(wall)) = (stretch.walls.get(way.wall), stretch.walls.get(cut.wall)) else {
            return self.unfit(&way.location, "a contour that the tool cuts");
        };
        let later: &Location = if cut.wall > way.wall { &wall.location } else { &own.location };
        let mut place = String::new();
        let point = self.plane.map(|plane| self.programmed(plane.point(cut.point, None))).unwrap_or_default();
        for (axis, letter) in AXIS_LETTERS.iter().enumerate().take(3) {
            if let Some(value) = point.get(axis) {
                place.push_str(&format!(" {letter}{value:.3}"));
            }
        }
        let at = if place.is_empty() { String::new() } else { format!(" at{place}") };
        let message = format!(
            "the tool of radius {} mm does not fit: along line {} it cuts {:.4} mm into the contour of line {}{at}",
            way.radius, own.location.line, cut.depth, wall.location.line
        );
        let help = format!(
            "use a smaller tool, or make the contour wider between lines {} and {}",
            own.location.line.min(wall.location.line),
            own.location.line.max(wall.location.line)
        );
        self.fault(codes::COMPENSATION, later, message, help)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::contour::ElementShape;
    use std::sync::Arc;

    fn stretch(points: &[Point], offset: f64) -> ContourStretch {
        let location = Location { file: Arc::from("x"), line: 1, column: 1, length: 1, depth: 0 };
        let walls = points.windows(2).map(|pair| ContourBlock {
            element: Element { start: pair[0], end: pair[1], shape: ElementShape::Line },
            offset,
            location: location.clone(),
            in_feed: true,
            heights: None,
            look_ahead: 1,
        });
        let mut stretch = ContourStretch::default();
        stretch.walls.extend(walls);
        stretch
    }

    #[test]
    fn front_and_behind_of_corners() {
        // Along X, then up: the tool on the left is inside, on the right outside.
        let points = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]];
        let inside = stretch(&points, 2.0);
        assert!(!lies_behind(&inside, 0, [9.0, 1.0]) && !lies_behind(&inside, 1, [9.0, 1.0]));
        assert!(lies_behind(&inside, 0, [12.0, -1.0]) && lies_behind(&inside, 0, [12.0, 1.0]));
        let outside = stretch(&points, -2.0);
        assert!(lies_behind(&outside, 0, [9.0, 1.0]));
        assert!(!lies_behind(&outside, 0, [12.0, -1.0]) && !lies_behind(&outside, 1, [12.0, -1.0]));
        // A point on the contour is not on its far side.
        assert!(!lies_behind(&inside, 0, [5.0, -1e-4]) && lies_behind(&inside, 0, [5.0, -0.01]));
    }

    #[test]
    fn extensions_of_sides_are_ways_on_and_off() {
        // A boss from the extension of its first side to that of its last: they cross in (-15, -15).
        let points = [[-15.0, -25.0], [-15.0, 15.0], [15.0, 15.0], [15.0, -15.0], [-25.0, -15.0]];
        let boss = stretch(&points, 5.0);
        let tails = Tails::of(&boss.walls);
        assert_eq!((tails.start, tails.end), (Some((0, 10.0)), Some((3, 30.0))));
        let cut = |wall, point| ContourCut { way: 0, wall, depth: 1.0, center: point, point };
        assert!(tails.hold(&boss.walls, &cut(0, [-15.0, -20.0])) && tails.hold(&boss.walls, &cut(3, [-20.0, -15.0])));
        assert!(!tails.hold(&boss.walls, &cut(0, [-15.0, 0.0])) && !tails.hold(&boss.walls, &cut(1, [0.0, 15.0])));
        // It closes in the corner where the extension of its first side begins, and the other way round.
        let closing = stretch(&points[..4].iter().copied().chain([[-15.0, -15.0]]).collect::<Vec<_>>(), 5.0);
        let tails = Tails::of(&closing.walls);
        assert_eq!((tails.start, tails.end), (Some((0, 10.0)), None));
        let opening = stretch(&[&[[-15.0, -15.0]], &points[1..]].concat(), 5.0);
        let tails = Tails::of(&opening.walls);
        assert_eq!((tails.start, tails.end), (None, Some((3, 30.0))));
        // Closed in a corner, nothing is a way on.
        let closed = stretch(&[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [0.0, 0.0]], 2.0);
        let tails = Tails::of(&closed.walls);
        assert_eq!((tails.start, tails.end), (None, None));
    }

    #[test]
    fn only_real_crossings_count() {
        let line = |start: Point, end: Point| Element { start, end, shape: ElementShape::Line };
        let a = line([0.0, 0.0], [10.0, 0.0]);
        assert!(cross_each_other(&a, &line([5.0, -5.0], [5.0, 5.0])));
        assert!(!cross_each_other(&a, &line([5.0, 0.0], [5.0, 5.0])));
        assert!(!cross_each_other(&a, &line([0.0, -1e-4], [10.0, 1e-4])));
    }
}
