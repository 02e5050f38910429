//! Motions of the programmed contour: entry, blocks, exit, and those that do not move in the plane.

use super::contour::{Element, ElementShape, Point, SAME_POINT_MM, norm, sub};
use super::corner::ContourEntry;
use super::plane::CompPlane;
use super::stretch::{CenterPiece, ContourBlock, PathRole, WINDOW};
use super::{CompState, CompensatedReader, Fault, PendingBlock, emit, motion_mut, motion_of};
use crate::codes;
use crate::frame;
use crate::{AxisValues, Command, Feed, Location, Note, Op};

/// Sine of the angle between tool axis and normal above which the axis is not square to the plane.
const OFF_SQUARE: f64 = 1e-6;

impl CompensatedReader {
    pub(super) fn motion(&mut self, mut command: Command) -> Result<(), Fault> {
        let location = command.location.clone();
        let Some(motion) = motion_of(&command.op) else { return self.pass(command) };
        let (end_base, programmed, machine) = (motion.end_base, motion.programmed, motion.machine_coordinates);
        let start = self.position;
        // After a motion the program knows the coordinates that the motion gives.
        self.position = if machine { AxisValues::NONE } else { end_base };
        let straight = matches!(command.op, Op::Rapid(_) | Op::Linear(_));
        let Some(plane) = self.plane.filter(|_| self.is_active() || self.residual != [0.0; 2]) else {
            return self.pass(command);
        };
        self.heights = plane.height(&start).zip(plane.height(&end_base)).map(|(a, b)| [a.min(b), a.max(b)]);
        if machine {
            if self.is_active() {
                return Err(self.unfit(&location, "a motion in machine coordinates while cutter compensation is on"));
            }
            return self.pass(command);
        }
        if !self.is_active() {
            // After G40: the next straight block in the plane leads back to the programmed point.
            if programmed & plane.axes == 0 && straight {
                if let Some(motion) = motion_mut(&mut command.op) {
                    plane.shift(&mut motion.end_base, self.residual);
                }
            } else if straight {
                if let Some((corner, tangent, offset)) = self.exit.take() {
                    let end = plane.project(&end_base).map_err(|missing| self.unknown(&location, &missing))?;
                    if emit::is_behind(end, corner, tangent, offset) {
                        return Err(self.far_side(&location, "exit"));
                    }
                }
                self.residual = [0.0; 2];
                if matches!(command.op, Op::Linear(_)) {
                    self.exit_move(&end_base, &plane, location);
                }
                self.leaving = None;
            } else {
                return Err(self.unfit(&location, "the first motion after G40 is not straight"));
            }
            return self.pass(command);
        }
        if let Some(axis) = motion.tool_axis_base
            && frame::norm(frame::cross(axis, plane.normal)) > OFF_SQUARE
        {
            return Err(self.unfit(&location, "the tool axis is not square to the plane of cutter compensation"));
        }
        let end = plane.project(&end_base).map_err(|missing| self.unknown(&location, &missing))?;
        let entering = self.state == CompState::Entering;
        let from = match &self.pending {
            Some(pending) if !entering => Some(pending.element.end),
            _ => plane.project(&start).ok(),
        };
        let is_arc = matches!(command.op, Op::Arc(_));
        let moves = is_arc
            || from.map_or(programmed & plane.axes != 0, |from| norm(sub(end, from)) > SAME_POINT_MM)
            || entering && programmed & plane.axes != 0;
        if !moves {
            if entering
                && self.residual != [0.0; 2]
                && let Some(motion) = motion_mut(&mut command.op)
            {
                plane.shift(&mut motion.end_base, self.residual);
            }
            return self.pass(command);
        }
        if !straight && !is_arc {
            let message = "a spline, thread or probing motion in the plane of cutter compensation";
            return Err(self.unfit(&location, message));
        }
        if matches!(self.feed, Some(Feed::InverseTime(_))) {
            return Err(self.unfit(&location, "inverse time feed (G93) with cutter compensation"));
        }
        if entering {
            return self.enter(command, from, end, plane);
        }
        let Some(from) = from else { return Err(self.unknown(&location, "the plane")) };
        let shape = self.shape(&command.op, &plane, &location)?;
        self.follow(command, Element { start: from, end, shape })
    }

    /// The straight block in feed that leads off the contour.
    fn exit_move(&mut self, end_base: &AxisValues, plane: &CompPlane, location: Location) {
        let Some((stretch, from)) = &self.leaving else { return };
        let (Ok(end), Some(wall)) = (plane.project(end_base), stretch.walls.len().checked_sub(1)) else {
            let text = "the exit from cutter compensation is not checked against the contour: its end is not known";
            self.out.push_back(Ok(Command { location, op: Op::Note(Note::new(text)) }));
            return;
        };
        let element = Element { start: *from, end, shape: ElementShape::Line };
        let way = CenterPiece {
            element,
            role: PathRole::Exit,
            wall,
            radius: self.offset.abs(),
            heights: self.heights,
            location,
        };
        self.check_exit(&way);
    }

    pub(super) fn shape(&self, op: &Op, plane: &CompPlane, location: &Location) -> Result<ElementShape, Fault> {
        let Op::Arc(arc) = op else { return Ok(ElementShape::Line) };
        let sense = frame::dot(arc.normal_base, plane.normal);
        if sense.abs() < frame::SAME_DIRECTION {
            return Err(self.unfit(location, "a circle outside of the plane of cutter compensation"));
        }
        let center = plane.project_point(arc.center_base);
        let shape = ElementShape::Arc { center, radius: arc.radius, counter_clockwise: sense > 0.0, sweep: arc.sweep };
        let probe = Element { start: [0.0; 2], end: [0.0; 2], shape };
        if let Some(pending) = &self.pending
            && pending.offset != self.offset
        {
            return Err(self.unfit(location, "the radius of cutter compensation changes in an arc"));
        }
        if probe.offset_radius(self.offset).is_some_and(|r| r <= SAME_POINT_MM) {
            let message = format!(
                "the tool of radius {} mm does not fit into the arc of radius {:.4} mm",
                self.offset.abs(),
                arc.radius
            );
            let help = format!(
                "use a tool with a radius below {:.4} mm; where the program gives the path of the tool center and the offset holds the wear alone \
                 (compensation type wear), state it in a control file: parameters.compensation = \"wear\"",
                arc.radius
            );
            return Err(self.fault(codes::COMPENSATION, location, message, help));
        }
        Ok(shape)
    }

    /// The straight block that leads onto the contour.
    pub(super) fn enter(
        &mut self,
        command: Command,
        from: Option<Point>,
        end: Point,
        plane: CompPlane,
    ) -> Result<(), Fault> {
        let location = command.location.clone();
        if matches!(command.op, Op::Arc(_)) {
            return Err(self.unfit(&location, "cutter compensation begins with an arc"));
        }
        let style = self.reader.comp_style().unwrap_or(self.default_style);
        let from = from.map(|p| [p[0] + self.residual[0], p[1] + self.residual[1]]);
        if from.is_none() {
            let text = "the entry to cutter compensation is not checked against the contour: its start is not known";
            self.out.push_back(Ok(Command { location: location.clone(), op: Op::Note(Note::new(text)) }));
        }
        let from = match (style.entry, from) {
            (ContourEntry::Perpendicular, from) => from.unwrap_or(end),
            (ContourEntry::Parallel, Some(from)) if norm(sub(end, from)) > self.offset.abs() => from,
            (ContourEntry::Parallel, Some(from)) => {
                let message = format!(
                    "the entry move is {:.4} mm long, not longer than the tool radius {} mm",
                    norm(sub(end, from)),
                    self.offset.abs()
                );
                return Err(self.fault(codes::COMPENSATION, &location, message, "begin farther from the contour"));
            }
            (ContourEntry::Parallel, None) => {
                let missing = plane.project(&AxisValues::NONE).err().unwrap_or_default();
                return Err(self.unknown(&location, &missing));
            }
        };
        let element = Element { start: from, end, shape: ElementShape::Line };
        self.state = CompState::On;
        self.pending = Some(PendingBlock {
            command,
            element,
            offset: self.offset,
            least_offset: self.offset,
            from,
            rest: element.extent(),
            entry: true,
            feed: self.feed,
            style,
            heights: self.heights,
        });
        Ok(())
    }

    /// A block of the contour: the end of the one before is known now.
    pub(super) fn follow(&mut self, command: Command, element: Element) -> Result<(), Fault> {
        let start = self.settle(Some((&element, &command)))?;
        let (from, offset, used) =
            start.map_or((element.offset_start(self.offset), self.offset, 0.0), |b| (b.point, b.offset, b.used));
        let style = self.reader.comp_style().unwrap_or(self.default_style);
        let least_offset = if offset.abs() < self.offset.abs() { offset } else { self.offset };
        if self.stretch.is_full() {
            self.check()?;
            self.stretch.forget();
            let text = format!(
                "the contour has more than {} blocks: each block is checked against the {WINDOW} blocks before and \
                 after it only",
                2 * WINDOW
            );
            self.out.push_back(Ok(Command { location: command.location.clone(), op: Op::Note(Note::new(text)) }));
        }
        self.stretch.walls.push(ContourBlock {
            element,
            offset: least_offset,
            location: command.location.clone(),
            in_feed: !matches!(command.op, Op::Rapid(_)),
            heights: self.heights,
            look_ahead: style.look_ahead,
        });
        self.pending = Some(PendingBlock {
            command,
            element,
            offset: self.offset,
            least_offset,
            from,
            rest: element.extent() - used,
            entry: false,
            feed: self.feed,
            style,
            heights: self.heights,
        });
        Ok(())
    }
}
