//! Work offsets, programmable frames, swivel planes, and the tolerance of the path.
//!
//! ```text
//! base = base frame * settable (G54) * swivel (CYCLE800) * programmable (TRANS ROT SCALE MIRROR) * work
//! ```
//!
//! An absolute instruction replaces the whole programmable frame, so `TRANS X0 Y0 Z0` takes an AROT away too;
//! an additive one is multiplied from the right and so acts in the axes of the frame that is active. Several
//! angles in one block turn about Z, the new Y, the newest X (Siemens, *NC programming*, "Programmable
//! rotation", RPY, the standard setting of MD10600).

use super::eval::Val;
use super::parser::Call;
use super::pending::{FrameWord, Pending};
use super::run_state::{Interpreter, Siemens};
use crate::channel::Language;
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::{Fault, Span};
use crate::frame::Frame;
use crate::machine_data::KinematicsKind;
use crate::{Motion, Offset, Op, PathMode, RotarySolution};

/// Cosine of the angle between the new Z and the old one below which a plane is swiveled.
const UPRIGHT: f64 = 1.0 - 1e-12;

impl Interpreter {
    /// Puts the frames of the modal state into effect and emits the resulting frame.
    pub(crate) fn take_frames(&mut self, word: &str) {
        let total = self.modal.frames.total();
        self.position.set_frame(total);
        self.own.tangent = None;
        self.forget_kept();
        self.tell_frame(word);
    }

    pub(crate) fn work_offset(&mut self, code: u32) {
        let word = format!("G{code}");
        self.modal.frames.settable = self.own.offsets.get(&word).copied().unwrap_or(Frame::IDENTITY);
        self.emit(Op::Offset(Offset::Work { word: word.clone() }));
        if self.modal.frames.total() != *self.position.frame() {
            self.take_frames(&word);
        }
    }

    pub(crate) fn frame_instruction(&mut self, word: FrameWord, p: &Pending, span: Span) -> Result<(), Fault> {
        let mut values = [None; 9];
        for (axis, coordinate) in p.axes.iter().enumerate() {
            values[axis] = coordinate.map(|c| c.value);
        }
        if matches!(word, FrameWord::G58 | FrameWord::G59) {
            return self.axial_offset(word, &values, span);
        }
        if !matches!(word, FrameWord::Trans | FrameWord::ATrans) && p.programmed >> 3 != 0 {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("`{}` takes X, Y and Z", word.name()))
                .help("remove the other axes"));
        }
        if p.programmed >> 6 != 0 {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "offsets of U, V and W are not supported")
                .help("use a work offset"));
        }
        let length = self.modal.units.length();
        let linear: [f64; 3] = std::array::from_fn(|i| values[i].unwrap_or(0.0));
        let change = match word {
            FrameWord::Trans | FrameWord::ATrans => Frame {
                rotary: std::array::from_fn(|i| values[i + 3].unwrap_or(0.0).to_radians()),
                ..Frame::translation(linear.map(|v| v * length))
            },
            FrameWord::Rot | FrameWord::ARot => match p.plane_angle {
                Some(_) if p.has_axis() => {
                    return Err(
                        Fault::new(codes::CONFLICT, span, "RPL= and angles about axes in one block").help("keep one")
                    );
                }
                Some(angle) => Frame::rotation(self.modal.normal, angle),
                None => Frame::rpy(linear),
            },
            FrameWord::Scale | FrameWord::AScale => {
                let factors: [f64; 3] = std::array::from_fn(|i| values[i].unwrap_or(1.0));
                if factors.iter().any(|&f| !(f > 0.0 && f.is_finite())) {
                    return Err(Fault::new(codes::BAD_VALUE, span, "a scale factor must be above zero")
                        .help("mirror with MIRROR"));
                }
                Frame::scale(factors)
            }
            FrameWord::G58 | FrameWord::G59 => Frame::IDENTITY,
            FrameWord::Mirror | FrameWord::AMirror => {
                Frame::scale(std::array::from_fn(|i| if values[i].is_some() { -1.0 } else { 1.0 }))
            }
        };
        let additive = match (word, self.modal.frames.additive) {
            (FrameWord::Trans, _) => Some([0.0; 3]),
            (FrameWord::ATrans, Some(sum)) if !self.modal.frames.programmable.is_rotated() => {
                Some(std::array::from_fn(|i| sum[i] + change.translation[i]))
            }
            (FrameWord::ATrans, _) => None,
            (_, sum) if word.is_additive() => sum,
            _ => Some([0.0; 3]),
        };
        let programmable = if word.is_additive() { self.modal.frames.programmable.then(&change) } else { change };
        if !programmable.translation.iter().chain(programmable.linear.iter().flatten()).all(|v| v.is_finite())
            || programmable.inverse_linear().is_none()
        {
            return Err(Fault::new(codes::BAD_VALUE, span, "the frame is degenerate").help("check its values"));
        }
        self.modal.frames.programmable = programmable;
        self.modal.frames.additive = additive;
        self.take_frames(word.name());
        Ok(())
    }

    /// G58 and G59: the absolute and the additive part of the programmable translation, axis by axis.
    fn axial_offset(&mut self, word: FrameWord, values: &[Option<f64>; 9], span: Span) -> Result<(), Fault> {
        if values[3..].iter().any(Option::is_some) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("`{}` takes X, Y and Z", word.name()))
                .help("use TRANS for rotary axes"));
        }
        let Some(mut additive) = self.modal.frames.additive else {
            let message = format!("`{}` after ATRANS in a rotated frame is not supported", word.name());
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("use TRANS and ATRANS"));
        };
        let length = self.modal.units.length();
        let translation = &mut self.modal.frames.programmable.translation;
        for axis in 0..3 {
            let Some(value) = values[axis].map(|v| v * length) else { continue };
            if word == FrameWord::G58 {
                translation[axis] = value + additive[axis];
            } else {
                translation[axis] += value - additive[axis];
                additive[axis] = value;
            }
        }
        self.modal.frames.additive = Some(additive);
        self.take_frames(word.name());
        Ok(())
    }

    /// ADIS=: rounding distance of G641, taken as the tolerance of the tip, which it bounds.
    pub(crate) fn rounding_word(&mut self, rounding: f64, span: Span) -> Result<(), Fault> {
        if !(rounding >= 0.0 && rounding.is_finite()) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("ADIS= must not be negative and is {rounding}"))
                .help("write ADIS=0.1"));
        }
        self.own.rounding = rounding;
        if let PathMode::Continuous { orientation_tolerance, .. } = self.modal.path_mode {
            let tolerance = Some(rounding * self.modal.units.length());
            self.path_mode(PathMode::Continuous { tolerance, orientation_tolerance });
        }
        Ok(())
    }

    /// CTOL=, OTOL=: tolerances of the contour (mm) and of the orientation (degrees).
    pub(crate) fn tolerance_word(&mut self, name: &str, value: f64, span: Span) -> Result<(), Fault> {
        // A negative value cancels the word.
        let given = (value >= 0.0).then_some(value);
        if !value.is_finite() {
            return Err(
                Fault::new(codes::BAD_VALUE, span, format!("{name}= has no finite value")).help("write a length")
            );
        }
        match name {
            "CTOL" => self.own.contour_tolerance = given.map(|v| v * self.modal.units.length()),
            "OTOL" => self.own.orientation_tolerance = given.map(f64::to_radians),
            _ => {
                self.note(format!("{name}={value}"));
                return Ok(());
            }
        }
        if let PathMode::Continuous { .. } = self.modal.path_mode {
            let mode = PathMode::Continuous {
                tolerance: self.own.contour_tolerance,
                orientation_tolerance: self.own.orientation_tolerance,
            };
            self.path_mode(mode);
        }
        Ok(())
    }

    /// `CYCLE832(tolerance, mode, orientation tolerance)`; without arguments it returns to the
    /// previous mode.
    pub(crate) fn cycle832(&mut self, v: &Values) -> Result<(), Fault> {
        let tolerance = v.get("TOL")?;
        // The last digit of the mode is the kind of machining, 0 switches it off; older programs
        // code more in higher digits.
        let mode = v.get("MODE")?.unwrap_or(if tolerance.is_some() { 1.0 } else { 0.0 });
        if mode.round().rem_euclid(10.0) == 0.0 {
            let before = self.modal.mode_before_cycle832.take().unwrap_or(self.modal.path_mode);
            self.path_mode(before);
            return Ok(());
        }
        let Some(tolerance) = tolerance.filter(|t| *t >= 0.0) else {
            let message = "CYCLE832 needs a tolerance that is not negative";
            return Err(v.fault(codes::ARGUMENTS, message, "write CYCLE832(0.02,1)"));
        };
        // 11 to 13: the third argument is the tolerance of the orientation, degrees.
        let kind = if mode < 1000.0 { mode.rem_euclid(100.0) } else { mode };
        let with_orientation = (11.0..=13.0).contains(&kind);
        let orientation = if with_orientation { v.get("OTOL")? } else { None };
        if self.modal.mode_before_cycle832.is_none() {
            self.modal.mode_before_cycle832 = Some(self.modal.path_mode);
        }
        self.path_mode(PathMode::Continuous {
            tolerance: Some(tolerance),
            orientation_tolerance: orientation.filter(|o| *o >= 0.0).map(f64::to_radians),
        });
        Ok(())
    }

    /// `CYCLE800(FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, DIR, ...)`: a swivel plane, axis by axis.
    ///
    /// MODE: bits 7-6 are 0 for axis by axis; bits 1-0, 3-2, 5-4 name the first, second and third
    /// axis of rotation with 1 X, 2 Y, 3 Z. The plane is `T(X0 Y0 Z0) R1 R2 R3 T(X1 Y1 Z1)`, each
    /// rotation about the turned axis. With DIR not zero the rotary axes turn the tool upright on
    /// the plane, with the lower (below zero) or the higher angle of the reference axis. This is
    /// emitted as a rapid motion that carries only the tool axis, before tool center point control
    /// goes on, so that the linear axes do not move.
    pub(crate) fn cycle800(&mut self, v: &Values) -> Result<(), Fault> {
        const NAME: &str = "CYCLE800";
        let span = v.span;
        // An empty name selects the only data set, "0" deselects.
        let deselected = v.text("TC").is_some_and(|name| name.trim() == "0");
        if self.own.tool_framed {
            let message = "`CYCLE800` while TOROT or TOFRAME is in force";
            return Err(v.fault(codes::CONFLICT, message, "write TOROTOF before it"));
        }
        self.forget_kept();
        let frames_before = self.modal.frames.total();
        if v.given.is_empty() || deselected {
            self.modal.frames.swivel = Frame::IDENTITY;
            self.modal.frames.programmable = Frame::IDENTITY;
            let tcp_before = self.own.tcp();
            self.own.swiveled = false;
            if frames_before != self.modal.frames.total() {
                self.take_frames(NAME);
            } else {
                self.note("CYCLE800()");
            }
            if tcp_before != self.own.tcp() {
                self.tell_tcp();
                self.position.forget(0b111);
            }
            return Ok(());
        }
        self.settings.check_kinematics(KinematicsKind::TiltedPlane, NAME, span)?;
        let mode = v.value("MODE")?;
        if !(0.0..256.0).contains(&mode) || mode.fract() != 0.0 {
            return Err(v.fault(codes::BAD_VALUE, format!("the mode of CYCLE800 is {mode}"), "use 0 to 255"));
        }
        let mode = mode as u32;
        let kind = ["axis by axis", "solid angle", "projection angle", "direct"][(mode >> 6 & 3) as usize];
        if mode >> 6 != 0 {
            let message = format!("`CYCLE800` in the mode {mode} ({kind}) is not supported");
            let help = "swivel axis by axis, for example with mode 57 (X, Y, Z)";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, help));
        }
        let retraction = v.value("FR")?;
        let options = v.value("ST")?.abs().round();
        let before = [v.value("X0")?, v.value("Y0")?, v.value("Z0")?];
        let angles = [v.value("A")?, v.value("B")?, v.value("C")?];
        let mut turns = Vec::new();
        for (at, angle) in angles.into_iter().enumerate() {
            match (mode >> (2 * at) & 3) as usize {
                0 if angle != 0.0 => {
                    let message = format!("mode {mode} of CYCLE800 names no axis for angle {}", at + 1);
                    return Err(v.fault(codes::BAD_VALUE, message, "use mode 57 for X, Y, Z"));
                }
                0 => {}
                axis => turns.push((axis - 1, angle)),
            }
        }
        let plane = Frame::translation(before).then(&Frame::turned(turns)).then(&Frame::translation([
            v.value("X1")?,
            v.value("Y1")?,
            v.value("Z1")?,
        ]));
        let direction = v.value("DIR")?;
        let additive = options.rem_euclid(10.0) == 1.0;
        if (options / 10.0).floor().rem_euclid(10.0) >= 1.0 && direction != 0.0 {
            let message = "`CYCLE800` with tracking of the tool tip is not supported";
            let help = "swivel without tracking (second digit of ST is 0)";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, help));
        }
        if retraction != 0.0 {
            self.note(format!("CYCLE800 retraction {retraction}: its position is set up on the machine"));
        }
        if additive {
            self.modal.frames.swivel = self.modal.frames.swivel.then(&plane);
        } else {
            self.modal.frames.swivel = plane;
            self.modal.frames.programmable = Frame::IDENTITY;
        }
        // Coordinates before and after a swivel refer to different axes.
        self.position.forget(0b111);
        self.take_frames(NAME);
        if direction != 0.0 {
            let solution = self.swivel_solution(direction > 0.0);
            self.swivel_motion(solution);
        }
        self.own.swiveled = true;
        self.tell_tcp();
        Ok(())
    }

    /// DIR of CYCLE800: the lower or the higher angle of the axis that the machine builder has
    /// chosen as reference. Where that position is out of travel, the control takes the other one
    /// (828D, *Operating manual Milling*, "Swivel plane", parameter "Direction").
    fn swivel_solution(&mut self, higher: bool) -> RotarySolution {
        let turned = self.modal.frames.swivel.apply_vector([0.0, 0.0, 1.0])[2] < UPRIGHT;
        if turned
            && self.settings.control.parameters.tilt_reference.is_none()
            && !std::mem::replace(&mut self.own.reference_told, true)
        {
            self.assume(
                "DIR of CYCLE800 refers to the rotary axis nearest to the tool; the swivel data set of the machine names the axis: state it \
                 as parameters.tilt_reference of the control file",
            );
        }
        self.chosen_solution(higher, true)
    }

    /// Turns the tool upright on the plane with the linear axes at rest.
    fn swivel_motion(&mut self, solution: RotarySolution) {
        if self.own.tcp() {
            let was = (self.own.transformed, self.own.swiveled);
            (self.own.transformed, self.own.swiveled) = (false, false);
            self.tell_tcp();
            (self.own.transformed, self.own.swiveled) = was;
        }
        self.position.forget(0b111000);
        let frame = *self.position.frame();
        let axis = [0.0, 0.0, 1.0];
        let motion = Motion {
            end: self.position.work,
            end_base: self.position.base,
            tool_axis: Some(axis),
            tool_axis_base: crate::frame::unit(frame.apply_vector(axis)),
            exact_stop: true,
            solution,
            ..Motion::default()
        };
        Siemens::moving(self);
        self.emit(Op::Rapid(motion));
    }

    /// Values of the arguments of a call; an omitted argument is none.
    pub(crate) fn arguments(&self, call: &Call, span: Span) -> Result<Vec<Option<Val>>, Fault> {
        let list = call.arguments.as_deref().unwrap_or_default();
        list.iter().map(|argument| argument.as_ref().map(|expr| self.variables.eval(expr, span)).transpose()).collect()
    }
}
