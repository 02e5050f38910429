//! Rotations, mirrors, scales, tilted working planes, dynamic work offsets.
//!
//! **G68.2** (Fanuc, *Tilted working plane indexing*): a plane in the coordinates before it, in the
//! forms of [`super::planes`]. G53.1 turns the rotary axes until the tool is along the new Z: a
//! rapid motion that has only the tool axis, with the linear axes at rest. From there on base
//! coordinates are those of the table. Without G53.1 the rotary axes stay where the program puts
//! them, and the table coordinates begin with the first motion of a linear axis.
//!
//! **G254** (Haas, *Dynamic work offset*): after the rotary motion the program goes on in axes
//! parallel to those of the machine, with the origin that turns with the table. Seen from the table
//! this is the frame turned by the rotary axes,
//!
//! ```text
//! table_from_work = T(G54) * Rz(C) * Rx(A)      or      T(G54) * Rz(C) * Ry(B)
//! ```
//!
//! for a C table that is carried by an A or B trunnion, counted as ISO 841 does (motion of the tool against
//! the part).

use super::flavor::Flavor;
use super::interpreter::Interpreter;
use super::modal::{Length, Plane};
use super::pending::{AXES, Pending};
use super::planes::FEATURE;
use super::technology::LINEAR;
use super::words::Group;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};
use crate::g_code::{G51, G51_1, G53_6, G68, G68_2, G101, G254, G268, G269, GCode};
use crate::machine_data::KinematicsKind;
use crate::{Motion, Offset, Op, OrientationInterpolation, RotarySolution, Tcp};

/// Scales of G51 on a Haas.
const SCALES: std::ops::RangeInclusive<f64> = 0.001..=999.999;

impl Interpreter {
    /// Hands the state of the tool center point control out: the rotary axes run in proportion to the path.
    pub(crate) fn tell_tcp(&mut self) {
        self.emit(Op::Tcp(Tcp { on: self.modal.in_table(), interpolation: OrientationInterpolation::Axes }));
    }

    /// G68 G68.2 G69, G51.1 G50.1 G101 G100, G254 G255.
    pub(crate) fn rotation_words(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        if p.g(Group::Rotation).is_some() || p.g(Group::DynamicOffset).is_some() {
            self.forget_kept();
        }
        match p.g(Group::Rotation) {
            Some(G68) => self.plane_rotation(p, span)?,
            Some(G68_2) => self.tilted_plane(p, span)?,
            Some(G268) => self.feature_plane(p, span)?,
            Some(G269) => self.end_of_planes("G269"),
            Some(_) => self.end_of_planes("G69"),
            None => {}
        }
        if let Some(code) = p.g(Group::Scaling) {
            self.scaling(code, p, span)?;
        }
        if let Some(code) = p.g(Group::Mirror) {
            self.mirror(code, p, span)?;
        }
        match p.g(Group::DynamicOffset) {
            Some(G254) => self.dynamic_offset(span)?,
            Some(_) if self.modal.plane == Plane::Dynamic => self.end_of_planes("G255"),
            _ => {}
        }
        Ok(())
    }

    /// G68 X Y R: about a point of the working plane.
    fn plane_rotation(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let [u, v, w] = self.modal.plane_axes();
        if p.any_free(&[AXES[w], b'I', b'J', b'K']) {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                "`G68` in space (three coordinates, I J K) is not supported",
            )
            .help("use G68.2 with Euler angles"));
        }
        if self.modal.incremental {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                "`G68` with G91 depends on the set-up of the control",
            )
            .help("write G90 G68"));
        }
        let Some(angle) = p.take(b'R') else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "G68 has no angle").help("write G68 X0 Y0 R30"));
        };
        let turned = self.modal.frames.rotation != Frame::IDENTITY || self.modal.frames.mirror != Frame::IDENTITY;
        let mut center = [0.0; 3];
        for axis in [u, v] {
            center[axis] = match self.length_of(p, AXES[axis]) {
                Some(value) => value,
                // The present position is the center.
                None => self.position.work.get(axis).filter(|_| !turned).ok_or_else(|| {
                    let message = format!("G68 has no `{}`, and the position is not known", char::from(AXES[axis]));
                    Fault::new(codes::POSITION_UNKNOWN, span, message).help("write the center: G68 X0 Y0 R30")
                })?,
            };
        }
        let back = Frame::translation(center.map(|c| -c));
        self.begin();
        self.modal.frames.rotation = Frame::translation(center).then(&Frame::rotation(w, angle)).then(&back);
        self.frames_changed("G68");
        Ok(())
    }

    /// G68.2
    fn tilted_plane(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        self.settings.check_kinematics(KinematicsKind::TiltedPlane, "G68.2", span)?;
        if self.modal.plane == Plane::Dynamic || self.modal.tcp {
            return Err(Fault::new(codes::CONFLICT, span, "G68.2 under G43.4 or G254").help("write G49 before it"));
        }
        let Some(plane) = self.plane_of_block(p, span)? else { return Ok(()) };
        self.plane_in_force(plane, "G68.2");
        Ok(())
    }

    /// G268 X Y Z I J K Q of a Haas (*Mill operator's manual*, "Feature coordinate system"): the angles I, J,
    /// K about X, Y, Z in the order of the digits of Q.
    fn feature_plane(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        self.settings.check_kinematics(KinematicsKind::TiltedPlane, "G268", span)?;
        if self.modal.plane == Plane::Dynamic || self.modal.tcp {
            return Err(
                Fault::new(codes::CONFLICT, span, "G268 under G234 or G254").help("write G49 or G255 before it")
            );
        }
        let plane = self.plane_of_turns(p, &FEATURE, span)?;
        self.plane_in_force(plane, "G268");
        Ok(())
    }

    fn plane_in_force(&mut self, plane: Frame, word: &str) {
        self.begin();
        if self.modal.plane == Plane::Engaged {
            self.modal.plane = Plane::Off;
            self.tell_tcp();
        }
        let frames = &mut self.modal.frames;
        frames.plane = plane;
        (frames.rotation, frames.mirror) = (Frame::IDENTITY, Frame::IDENTITY);
        self.modal.plane = Plane::Defined;
        // Coordinates before and after do not belong to the same axes.
        self.position.forget(LINEAR);
        let total = self.modal.frames.total(self.own.flavor);
        self.position.set_frame(total);
        self.tell_frame(word);
    }

    /// G53.1: turns the tool upright on the plane with the linear axes at rest. G53.6 H: they follow, so that
    /// the tip stays on the workpiece, or with R the point so much ahead of it (Fanuc, "Tool center point
    /// retention type tool axis direction control", from memory).
    pub(crate) fn turn_to_plane(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let word = code.to_string();
        if !matches!(self.modal.plane, Plane::Defined | Plane::Engaged) || self.modal.tcp {
            return Err(Fault::new(codes::CONFLICT, span, format!("{word} needs a plane of G68.2, without G43.4"))
                .help("write G68.2 before it"));
        }
        self.forget_kept();
        let solution = self.plane_solution(p.take(b'P').unwrap_or(0.0), &word);
        let follows = code == G53_6;
        let ahead = self.length_of(p, b'R').filter(|ahead| follows && *ahead != 0.0);
        if follows {
            self.length_of_turn(p, span)?;
        }
        if ahead.is_some() {
            self.assume(
                "R of G53.6 is the distance from the tip to the point about which the tool turns, away from the holder",
            );
        }
        if !follows && self.modal.plane == Plane::Engaged {
            self.modal.plane = Plane::Off;
            self.tell_tcp();
        } else if follows {
            self.modal.plane = Plane::Engaged;
            self.tell_tcp();
        }
        self.position.forget(LINEAR | 0b111000);
        let axis = [0.0, 0.0, 1.0];
        let motion = Motion {
            end: self.position.work,
            end_base: self.position.base,
            tool_axis: Some(axis),
            tool_axis_base: frame::unit(self.position.frame().apply_vector(axis)),
            programmed: 0,
            machine_coordinates: false,
            exact_stop: true,
            solution,
        };
        self.begin_motion();
        if let Some(ahead) = ahead {
            self.emit(Op::Offset(Offset::TurnCenter { ahead }));
        }
        self.emit(Op::Rapid(motion));
        if ahead.is_some() {
            self.emit(Op::Offset(Offset::TurnCenter { ahead: 0.0 }));
        }
        if !follows {
            self.modal.plane = Plane::Engaged;
            self.tell_tcp();
        }
        Ok(())
    }

    /// P of G53.1 and G53.6: 1 takes the positive, 2 the negative angle of the reference axis (Fanuc, from
    /// memory).
    fn plane_solution(&mut self, choice: f64, word: &str) -> RotarySolution {
        if choice == 0.0 {
            return self.usual_solution();
        }
        self.assume(format!(
            "{word} P{choice} takes the {} angle of the rotary axis nearest to the tool; parameters of the control name the axis: state \
             it as parameters.tilt_reference of its control file",
            if choice == 1.0 { "higher" } else { "lower" }
        ));
        self.chosen_solution(choice == 1.0, false)
    }

    /// G69, G255.
    fn end_of_planes(&mut self, word: &str) {
        let was = self.modal.plane;
        let before = self.modal.in_table();
        if word == "G69" && was == Plane::Dynamic {
            self.modal.frames.rotation = Frame::IDENTITY;
            self.frames_changed(word);
            return;
        }
        self.modal.frames.plane = Frame::IDENTITY;
        self.modal.frames.rotation = Frame::IDENTITY;
        self.modal.plane = Plane::Off;
        if was != Plane::Off {
            self.position.forget(LINEAR);
        }
        self.frames_changed(word);
        if before != self.modal.in_table() {
            self.tell_tcp();
        }
    }

    /// G51.1 and G101 mirror about the given coordinates; G50.1 and G100 end it for the given axes, or for
    /// all.
    fn mirror(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let on = matches!(code, G51_1 | G101);
        let axes = p.axes();
        if axes & !LINEAR != 0 || on && axes == 0 {
            return Err(Fault::new(codes::BAD_VALUE, span, "a mirror takes X, Y and Z").help("write G51.1 X0"));
        }
        let mut mirror = self.modal.frames.mirror;
        for (axis, letter) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
            let given = self.length_of(p, letter);
            if on && let Some(at) = given {
                mirror.linear[axis][axis] = -1.0;
                // Haas mirrors about the work origin whatever the number is.
                mirror.translation[axis] = if code == G101 { 0.0 } else { 2.0 * at };
            } else if !on && (given.is_some() || axes == 0) {
                mirror.linear[axis][axis] = 1.0;
                mirror.translation[axis] = 0.0;
            }
        }
        self.begin();
        self.modal.frames.mirror = mirror;
        self.frames_changed(&code.to_string());
        Ok(())
    }

    /// A scaling is in force.
    pub(crate) fn is_scaled(&self) -> bool {
        self.modal.frames.scale != Frame::IDENTITY
    }

    /// G51 X Y Z P and G50 (Haas, *Mill operator's manual*, G51): all end points and arcs are
    /// scaled by P about a center. Along axes without a word the center is the present position.
    /// Scaling is switched on before a rotation, and off after it.
    ///
    /// A Fanuc (*Operator's manual*, "Scaling (G50, G51)") scales each axis by I, J and K as well, mirrors it
    /// where they are below zero, and counts thousandths where they have no decimal point.
    pub(crate) fn scaling(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let frames = &self.modal.frames;
        let inside = frames.rotation != Frame::IDENTITY || frames.mirror != Frame::IDENTITY;
        if inside || self.modal.plane != Plane::Off || self.modal.tcp {
            return Err(Fault::new(codes::CONFLICT, span, "scaling changes under a rotation, a mirror or a plane")
                .help("write G69, G100 or G50.1, or G255 before it"));
        }
        let mut scale = Frame::IDENTITY;
        if code == G51 {
            let factors = self.scale_factors(p, span)?;
            let scaled = self.is_scaled();
            if p.axes() & !LINEAR != 0 {
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "G51 of a rotary axis is not supported")
                    .help("scale X, Y and Z"));
            }
            for (axis, letter) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
                let center = match self.length_of(p, letter) {
                    Some(value) => value,
                    // What is not scaled has no center.
                    None if factors[axis] == 1.0 => 0.0,
                    None => self.position.work.get(axis).filter(|_| !scaled).ok_or_else(|| {
                        let message = format!("G51 has no {}, and the position is not known", char::from(letter));
                        Fault::new(codes::POSITION_UNKNOWN, span, message).help("write the center: G51 X0 Y0 Z0 P2.")
                    })?,
                };
                scale.linear[axis][axis] = factors[axis];
                scale.translation[axis] = center * (1.0 - factors[axis]);
            }
        }
        self.begin();
        self.modal.frames.scale = scale;
        self.frames_changed(&code.to_string());
        Ok(())
    }

    /// P for all axes, or on a Fanuc I J K for each.
    fn scale_factors(&mut self, p: &mut Pending, span: Span) -> Result<[f64; 3], Fault> {
        let fanuc = self.own.flavor == Flavor::Fanuc;
        let points = [b'P', b'I', b'J', b'K'].map(|letter| p.has_point(letter));
        let all = p.take(b'P');
        let each = [b'I', b'J', b'K'].map(|letter| p.take(letter).filter(|_| fanuc));
        let wrong =
            |code: &'static str, message: String, help: &'static str| Err(Fault::new(code, span, message).help(help));
        let one = |value: f64, point: bool| if fanuc && !point { value / 1000.0 } else { value };
        let factors = match (all, each) {
            (Some(_), [None, None, None]) | (None, [Some(_), Some(_), Some(_)]) => match all {
                Some(all) => [one(all, points[0]); 3],
                None => std::array::from_fn(|axis| one(each[axis].unwrap_or(1.0), points[axis + 1])),
            },
            (None, [None, None, None]) => {
                return wrong(
                    codes::MISSING_VALUE,
                    "G51 has no P, and would scale by settings of the control".to_owned(),
                    "write the factor: G51 X0 Y0 Z0 P2.",
                );
            }
            (None, _) => {
                return wrong(
                    codes::MISSING_VALUE,
                    "G51 has not all of I, J and K, and would scale an axis by a parameter of the control".to_owned(),
                    "write all three: G51 X0 Y0 Z0 I2000 J2000 K1000",
                );
            }
            (Some(_), _) => {
                return wrong(
                    codes::CONFLICT,
                    "G51 has P for all axes, and I, J or K for one".to_owned(),
                    "write P, or I, J and K",
                );
            }
        };
        for factor in factors {
            if !SCALES.contains(&if all.is_none() { factor.abs() } else { factor }) {
                let message = format!("the scale takes 0.001 to 999.999 and has {factor}");
                return wrong(
                    codes::BAD_VALUE,
                    message,
                    "write a factor above zero, without a decimal point in thousandths",
                );
            }
        }
        if fanuc {
            self.assume(
                "G51: P, I, J and K without a decimal point count thousandths (bit 7 of parameter 5400), and no axis is kept from \
                 scaling (bit 0 of parameter 5401)",
            );
        }
        Ok(factors)
    }

    /// G254
    fn dynamic_offset(&mut self, span: Span) -> Result<(), Fault> {
        self.settings.check_kinematics(KinematicsKind::TiltedPlane, "G254", span)?;
        if self.modal.plane != Plane::Off || self.modal.tcp {
            return Err(Fault::new(codes::CONFLICT, span, "G254 while a plane or G234 is in force")
                .help("write G255 or G49 before it"));
        }
        let [a, b, c] = [3, 4, 5].map(|axis| self.position.base.get(axis));
        if a.is_none() && b.is_none() && c.is_none() {
            return Err(Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                "G254 needs the position of the rotary axes, which the program has not set",
            )
            .help("program A or B, and C, before G254"));
        }
        if a.is_some_and(|a| a != 0.0) && b.is_some_and(|b| b != 0.0) {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "`G254` with A and B is not supported")
                .help("use a C table on an A or B trunnion"));
        }
        let degrees = |angle: Option<f64>| angle.unwrap_or(0.0).to_degrees();
        self.begin();
        self.modal.frames.plane = Frame::rpy([a, b, c].map(degrees));
        self.modal.plane = Plane::Dynamic;
        self.position.forget(LINEAR);
        let total = self.modal.frames.total(self.own.flavor);
        self.position.set_frame(total);
        self.tell_frame("G254");
        self.tell_tcp();
        Ok(())
    }

    /// The tool length in force is one that the program itself gives.
    pub(crate) fn has_programmed_length(&self) -> bool {
        matches!(self.modal.length, Length::Programmed(_))
    }
}
