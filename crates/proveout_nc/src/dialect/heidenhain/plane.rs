//! Tilted working plane (PLANE, cycle 19) and tool center point control (M128, FUNCTION TCPM).
//!
//! A plane is emitted as a frame. Its base coordinates are those of the table, so tool center point
//! control is emitted as on with it. Where the control turns the rotary axes itself (TURN), the way
//! is a motion that carries only the tool axis, before tool center point control goes on: the
//! linear axes do not move. With MOVE they follow. With STAY the rotary words of the program turn
//! them, as numbers or as Q120, Q121, Q122, which the control has computed.
//!
//! Angles after HEIDENHAIN, *TNC 640 Klartext programming*, "The PLANE function": SPA, SPB, SPC turn about
//! the fixed axes X, then Y, then Z of the workpiece system, which is Rz Ry Rx; EULPR, EULNU, EULROT about Z,
//! the turned X, the turned Z; a VECTOR plane has NX NY NZ as its Z and the part of BX BY BZ square to it as
//! its X; POINTS run P1 to P2 along X, P3 lies on the side of +Y; PROPR and PROMIN are the angles of the
//! lines in which the plane cuts Z X and Y Z; AXIAL gives positions of the rotary axes. The origin stays at
//! the active datum.

use super::interpreter::Interpreter;
use super::motion::{Goal, LINEAR, ROTARY};
use super::words::{FeedWord, Kind, Param, Plane, PlaneKind, Positioning, Tcpm, TiltChoice};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};
use crate::machine_data::KinematicsKind;
use crate::{Motion, Offset, Op, OrientationInterpolation, RotarySolution, Tcp};

const PLANE_PARAMS: [u32; 3] = [120, 121, 122];

/// A tilted plane as defined in the program.
pub(crate) struct Tilt {
    pub(crate) frame: Frame,
    /// On top of the plane in force.
    pub(crate) relative: bool,
    /// Positions of A, B, C that PLANE AXIAL gives, degrees.
    pub(crate) axes: [Option<f64>; 3],
}

/// How the rotary axes come onto a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) positioning: Positioning,
    /// DIST of MOVE: how far the center of the turn is ahead of the tip, away from the holder, mm.
    pub(crate) ahead: f64,
    pub(crate) feed: Option<FeedWord>,
    /// Which of two positions of the rotary axes is taken.
    pub(crate) solution: RotarySolution,
}

/// Where the rotary axes turn when they move alone.
enum Target {
    ToolAxis([f64; 3]),
    /// A, B, C, degrees.
    Axes([Option<f64>; 3]),
    /// All of them to zero.
    Zero,
}

impl Interpreter {
    /// Emits tool center point control when it has changed; the meaning of base coordinates changes
    /// with it.
    pub(crate) fn tell_tcp(&mut self) {
        self.tell_tcp_as(self.modal.tcpm || self.modal.frames.tilted());
    }

    pub(crate) fn tell_tcp_as(&mut self, on: bool) {
        let interpolation = if self.modal.tcpm { self.modal.interpolation } else { OrientationInterpolation::Axes };
        let told = Tcp { on, interpolation };
        if self.modal.told_tcp == Some(told) || !on && self.modal.told_tcp.is_none_or(|t| !t.on) {
            return;
        }
        if self.modal.told_tcp.is_some_and(|t| t.on) != on {
            self.position.forget(LINEAR);
            self.modal.tangent = None;
        }
        self.modal.told_tcp = Some(told);
        self.emit(Op::Tcp(told));
    }

    /// M128, M129.
    pub(crate) fn set_tcpm(&mut self, on: bool) {
        self.modal.tcpm = on;
        if !on {
            self.modal.spatial = false;
            self.modal.interpolation = OrientationInterpolation::Axes;
        }
        self.tell_tcp();
    }

    pub(crate) fn function_tcpm(&mut self, tcpm: &Tcpm) {
        if !tcpm.options.is_empty() {
            self.note(format!("FUNCTION TCPM {}", tcpm.options.join(" ")));
        }
        self.modal.spatial = tcpm.spatial;
        self.modal.interpolation =
            if tcpm.vector { OrientationInterpolation::GreatCircle } else { OrientationInterpolation::Axes };
        self.set_tcpm(true);
    }

    fn angle(&self, plane: &Plane, name: &str, span: Span) -> Result<Option<f64>, Fault> {
        let found = plane.angles.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| self.variables.value(*value, span)).transpose()
    }

    /// Rotation from the plane to the system it is defined in.
    fn plane_rotation(&self, plane: &Plane, span: Span) -> Result<Frame, Fault> {
        let value = |name: &str| -> Result<f64, Fault> { Ok(self.angle(plane, name, span)?.unwrap_or(0.0)) };
        let need = |name: &str| -> Result<f64, Fault> {
            self.angle(plane, name, span)?.ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, span, format!("`{name}` is missing in the PLANE block"))
                    .help(format!("write {name}+0"))
            })
        };
        let vector =
            |names: [&str; 3]| -> Result<[f64; 3], Fault> { Ok([need(names[0])?, need(names[1])?, need(names[2])?]) };
        match plane.kind {
            PlaneKind::Spatial => Ok(Frame::rpy([need("SPA")?, need("SPB")?, need("SPC")?])),
            PlaneKind::Relative => {
                if plane.angles.len() != 1 {
                    return Err(Fault::new(codes::BAD_VALUE, span, "PLANE RELATIVE takes one angle")
                        .help("write SPA, SPB or SPC"));
                }
                Ok(Frame::rpy([value("SPA")?, value("SPB")?, value("SPC")?]))
            }
            PlaneKind::Euler => Ok(Frame::turned([(2, value("EULPR")?), (0, value("EULNU")?), (2, value("EULROT")?)])),
            PlaneKind::Vector => basis(vector(["BX", "BY", "BZ"])?, vector(["NX", "NY", "NZ"])?, span),
            PlaneKind::Points => {
                let (a, b, c) =
                    (vector(["P1X", "P1Y", "P1Z"])?, vector(["P2X", "P2Y", "P2Z"])?, vector(["P3X", "P3Y", "P3Z"])?);
                let x = frame::sub(b, a);
                basis(x, frame::cross(x, frame::sub(c, a)), span)
            }
            PlaneKind::Projected => {
                let steep = |name: &str| -> Result<f64, Fault> {
                    let angle = need(name)?;
                    if angle.abs() < 90.0 {
                        return Ok(angle);
                    }
                    Err(Fault::new(
                        codes::BAD_VALUE,
                        span,
                        format!("`{name}` takes angles below 90 degrees and has {angle}"),
                    )
                    .help("write the plane with PLANE SPATIAL"))
                };
                // The lines in which the plane cuts Z X and Y Z.
                let ((sp, cp), (sm, cm)) =
                    (frame::sin_cos_degrees(steep("PROPR")?), frame::sin_cos_degrees(steep("PROMIN")?));
                let (x, y) = ([cp, 0.0, -sp], [0.0, cm, sm]);
                let turn = self.angle(plane, "ROT", span)?.or(self.angle(plane, "PROROT", span)?).unwrap_or(0.0);
                Ok(basis(x, frame::cross(x, y), span)?.then(&Frame::rotation(2, turn)))
            }
            PlaneKind::Axial => {
                if plane.angles.is_empty() || plane.angles.iter().any(|(name, _)| name.len() != 1) {
                    return Err(Fault::new(codes::MISSING_VALUE, span, "PLANE AXIAL takes positions of rotary axes")
                        .help("write PLANE AXIAL B+45"));
                }
                Ok(Frame::rpy([value("A")?, value("B")?, value("C")?]))
            }
            PlaneKind::Reset => Ok(Frame::IDENTITY),
        }
    }

    pub(crate) fn plane(&mut self, plane: &Plane, span: Span) -> Result<(), Fault> {
        let tilt = self.plane_rotation(plane, span)?;
        let Some(positioning) = plane.positioning.or((plane.kind == PlaneKind::Reset).then_some(Positioning::Stay))
        else {
            return Err(Fault::new(
                codes::MISSING_VALUE,
                span,
                "the PLANE block does not say how the rotary axes move",
            )
            .help("write MOVE, TURN or STAY"));
        };
        if !plane.options.is_empty() {
            self.note(format!("PLANE {}", plane.options.join(" ")));
        }
        if let Some((value, max)) = plane.retract {
            let distance = match value {
                Some(value) if !max => Some(self.variables.value(value, span)? * self.modal.unit()),
                _ => None,
            };
            if positioning == Positioning::Stay {
                return Err(Fault::new(codes::CONFLICT, span, "`MB` with STAY, which moves no axis")
                    .help("write MOVE or TURN, or remove MB"));
            }
            self.retract(distance, None, span)?;
        }
        let ahead = match plane.distance {
            Some(distance) => self.variables.value(distance, span)? * self.modal.unit(),
            None => 0.0,
        };
        if ahead != 0.0 && positioning != Positioning::Move {
            return Err(Fault::new(codes::CONFLICT, span, "DIST without MOVE, to which it belongs")
                .help("write MOVE, or remove DIST"));
        }
        let solution = match plane.choice {
            // Of two positions one has the higher angle of the primary axis; both lie about its basic
            // position.
            Some(TiltChoice::Positive | TiltChoice::Upper) => self.chosen_solution(true, false),
            Some(TiltChoice::Negative | TiltChoice::Lower) => self.chosen_solution(false, false),
            None => self.usual_solution(),
        };
        if positioning == Positioning::Stay && plane.feed.is_some() {
            self.note("F or FMAX of PLANE has no effect: STAY moves no axis");
        }
        if positioning == Positioning::Stay && plane.choice.is_some() {
            self.note("SEQ or SYM of PLANE has no effect: STAY moves no axis");
        }
        let way = Way { positioning, ahead, feed: plane.feed, solution };
        if plane.kind == PlaneKind::Reset {
            return self.plane_reset(way, "PLANE RESET", span);
        }
        let name = match plane.kind {
            PlaneKind::Relative => "PLANE RELATIVE",
            PlaneKind::Euler => "PLANE EULER",
            PlaneKind::Vector => "PLANE VECTOR",
            PlaneKind::Points => "PLANE POINTS",
            PlaneKind::Projected => {
                self.assume(
                    "PLANE PROJECTED: both angles count with the right hand about Y and X, and X of the plane lies above that of \
                     the workpiece",
                );
                "PLANE PROJECTED"
            }
            PlaneKind::Axial => {
                self.assume(
                    "PLANE AXIAL: the axes A, B, C turn about X, Y, Z, and the plane lies as Rz(C) Ry(B) Rx(A) turns it; other \
                     kinematics tilt it in another way",
                );
                "PLANE AXIAL"
            }
            _ => "PLANE SPATIAL",
        };
        let mut axes = [None; 3];
        if plane.kind == PlaneKind::Axial {
            for (slot, name) in axes.iter_mut().zip(["A", "B", "C"]) {
                *slot = self.angle(plane, name, span)?;
            }
        }
        self.tilt(Tilt { frame: tilt, relative: plane.kind == PlaneKind::Relative, axes }, way, name, span)
    }

    /// Takes a plane into force and turns the tool onto it as asked.
    pub(crate) fn tilt(&mut self, tilt: Tilt, way: Way, word: &str, span: Span) -> Result<(), Fault> {
        self.settings.check_kinematics(KinematicsKind::TiltedPlane, word, span)?;
        if !self.modal.frames.tilt(tilt.frame, tilt.relative) {
            return Err(Fault::new(
                codes::NESTING_LIMIT,
                span,
                "more than 100 PLANE RELATIVE blocks act on each other",
            )
            .help("write PLANE RESET between them"));
        }
        self.modal.plane_angles = true;
        self.modal.plane_solution = way.solution;
        for (index, position) in PLANE_PARAMS.into_iter().zip(tilt.axes) {
            let param = Param { kind: Kind::Global, index };
            match position {
                Some(position) => self.variables.set(param, position, span)?,
                None => self.variables.forget(param),
            }
        }
        let target = if tilt.axes == [None; 3] { Target::ToolAxis(self.tool_axis()) } else { Target::Axes(tilt.axes) };
        self.take_frames(word, span)?;
        match way.positioning {
            Positioning::Stay => self.tell_tcp(),
            Positioning::Turn => {
                self.tell_tcp_as(false);
                self.turn(target, way, span)?;
                self.tell_tcp();
            }
            Positioning::Move => {
                self.tell_tcp();
                self.turn_ahead(target, way, span)?;
            }
        }
        Ok(())
    }

    /// The tool axis in the working plane system.
    fn tool_axis(&self) -> [f64; 3] {
        let mut axis = [0.0; 3];
        axis[self.modal.normal] = 1.0;
        axis
    }

    /// Ends the tilted plane.
    pub(crate) fn plane_reset(&mut self, way: Way, word: &str, span: Span) -> Result<(), Fault> {
        let was = self.modal.frames.tilted();
        self.modal.frames.untilt();
        self.modal.plane_angles = false;
        for index in PLANE_PARAMS {
            self.variables.set(Param { kind: Kind::Global, index }, 0.0, span)?;
        }
        if was {
            self.take_frames(word, span)?;
        } else {
            self.note(word);
        }
        match way.positioning {
            Positioning::Stay => self.tell_tcp(),
            Positioning::Turn => {
                self.tell_tcp_as(self.modal.tcpm);
                self.turn(Target::Zero, way, span)?;
                if !self.modal.tcpm {
                    self.position.forget(LINEAR);
                }
            }
            Positioning::Move => {
                // The linear axes follow, whether a plane was in force or not.
                self.tell_tcp_as(true);
                self.turn_ahead(Target::Zero, way, span)?;
                self.tell_tcp();
            }
        }
        Ok(())
    }

    /// MOVE: turns the rotary axes while the linear ones follow, so that the point ahead of the tip
    /// stays on the workpiece.
    fn turn_ahead(&mut self, target: Target, way: Way, span: Span) -> Result<(), Fault> {
        if way.ahead == 0.0 {
            return self.turn(target, way, span);
        }
        // The tip moves, and its end position depends on the positions of the rotary axes.
        self.position.forget(LINEAR);
        self.emit(Op::Offset(Offset::TurnCenter { ahead: way.ahead }));
        self.turn(target, way, span)?;
        self.emit(Op::Offset(Offset::TurnCenter { ahead: 0.0 }));
        Ok(())
    }

    /// Turns the rotary axes alone: onto a tool axis, or all of them to zero.
    fn turn(&mut self, target: Target, way: Way, span: Span) -> Result<(), Fault> {
        let feed = way.feed;
        let rapid = matches!(feed, None | Some(FeedWord::Max));
        let before = self.technology.feed;
        if let (false, Some(word)) = (rapid, feed) {
            self.technology.feed = self.feed_of(word, span)?;
            self.tell_feed();
        }
        self.position.forget(ROTARY);
        let motion = match target {
            Target::ToolAxis(axis) => {
                let goal = Goal { end: self.position.work, programmed: 0, tool_axis: Some(axis) };
                Motion { solution: way.solution, ..self.complete(goal, span)? }
            }
            Target::Axes(positions) => {
                let mut goal = Goal { end: self.position.work, programmed: 0, tool_axis: None };
                for (axis, position) in (3..6).zip(positions) {
                    let Some(position) = position else { continue };
                    goal.end.put(axis, position.to_radians());
                    goal.programmed |= 1 << axis;
                }
                self.complete(goal, span)?
            }
            Target::Zero => {
                // Axes that the machine does not have are not programmed, so they are left alone.
                let (mut end, mut base) = (self.position.work, self.position.base);
                for axis in 3..6 {
                    let offset = self.position.frame().rotary[axis - 3];
                    base.put(axis, 0.0);
                    end.put(axis, -offset + 0.0);
                }
                Motion { end, end_base: base, ..Motion::default() }
            }
        };
        self.modal.tangent = None;
        self.drive(motion, rapid);
        self.technology.feed = before;
        Ok(())
    }
}

/// Rotation with z along `normal` and x along the part of `x` square to it.
fn basis(x: [f64; 3], normal: [f64; 3], span: Span) -> Result<Frame, Fault> {
    let degenerate = || {
        Fault::new(codes::ORIENTATION, span, "the vectors or points do not define a plane")
            .help("check that they are not parallel")
    };
    let z = frame::unit(normal).ok_or_else(degenerate)?;
    let y = frame::unit(frame::cross(z, frame::unit(x).ok_or_else(degenerate)?)).ok_or_else(degenerate)?;
    Ok(Frame::of_axes([0.0; 3], [frame::cross(y, z), y, z]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_of_vectors_is_a_rotation() {
        let span = Span::default();
        let frame = basis([1.0, 0.2, 0.3], [0.0, 1.0, 1.0], span).unwrap();
        assert!((frame.determinant() - 1.0).abs() < 1e-15);
        let z = frame.apply_vector([0.0, 0.0, 1.0]);
        assert!((z[1] - 0.5f64.sqrt()).abs() < 1e-15 && z[0] == 0.0);
        assert!(basis([0.0, 0.0, 2.0], [0.0, 0.0, 1.0], span).is_err());
    }
}
