//! Motions of a block: straight, circular, in machine coordinates.

use super::modal::Interpolation;
use super::pending::{Coordinate, Pending, Reference};
use super::run_state::Interpreter;
use crate::channel::parameters::turn_up;
use crate::channel::{finite, unknown_axes};
use crate::codes;
use crate::control::{OrientationAngles, OutsideModulo};
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};
use crate::{AXIS_LETTERS, AxisValues, Motion};

/// Bits of A, B and C.
const ROTARY: u16 = 0b111000;

impl Interpreter {
    /// Executes the motion of a block.
    pub(crate) fn motion(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        if p.machine {
            return self.machine_motion(p, span);
        }
        let interpolation = if p.tapping_feed { Interpolation::Linear } else { self.modal.interpolation };
        let is_thread = matches!(interpolation, Interpolation::Thread | Interpolation::TapIn | Interpolation::TapOut);
        match interpolation {
            Interpolation::Spline(kind) => return self.spline_point(kind, p, span),
            Interpolation::Polynomial => return self.polynomial(p, span),
            _ if p.weight.is_some() || p.interval.is_some() || p.polynomial.iter().any(Option::is_some) => {
                return Err(Fault::new(codes::CONFLICT, span, "PW, PL or PO in a block without a spline or POLY")
                    .help("write BSPLINE or POLY before it"));
            }
            _ => {}
        }
        let is_arc = !is_thread && !matches!(interpolation, Interpolation::Rapid | Interpolation::Linear);
        if is_thread && (p.has_orientation() || p.radius.is_some() || p.opening.is_some()) {
            return Err(Fault::new(codes::CONFLICT, span, "words of an arc or a tool vector in a thread block")
                .help("remove them"));
        }
        if !is_arc && !is_thread && (p.has_center() || p.radius.is_some() || p.opening.is_some()) {
            return Err(Fault::new(codes::CONFLICT, span, "words of an arc in a block without G2 or G3")
                .help("write G2 or G3, or remove I J K, CR=, AR="));
        }
        if interpolation != Interpolation::Rapid && !is_thread {
            self.need_feed(span)?;
        }
        let end = self.targets(p, span)?;
        if is_arc {
            return self.arc(p, end, span);
        }
        if !p.has_axis() && !p.has_orientation() {
            return Ok(());
        }
        let start = self.position.work.xyz();
        let (mut end, mut programmed) = (end, p.programmed);
        if !p.has_orientation() && !is_thread {
            self.with_kept(&mut end, &mut programmed);
            if interpolation == Interpolation::Rapid
                && self.rapid_left_open(end, programmed, p.programmed, p.exact_stop)
            {
                return Ok(());
            }
        }
        let motion = self.complete(p, end, programmed, span)?;
        if is_thread {
            return self.thread_block(p, motion, span);
        }
        if p.measure.is_some() || p.measure_on.is_some() {
            return self.measuring_motion(p, motion, span);
        }
        self.own.tangent = match (start, end.xyz()) {
            (Some(start), Some(end)) => frame::unit(frame::sub(end, start)).or(self.own.tangent),
            _ => None,
        };
        self.go(motion, interpolation == Interpolation::Rapid);
        Ok(())
    }

    pub(crate) fn need_feed(&mut self, span: Span) -> Result<(), Fault> {
        if self.technology.feed.is_some() {
            return Ok(());
        }
        if self.modal.feed_mode == super::modal::FeedMode::PerTime && self.default_feed().is_some() {
            self.tell_feed();
            return Ok(());
        }
        let (message, help) = match self.modal.feed_mode {
            super::modal::FeedMode::InverseTime => {
                ("G93 needs F in every block with a feed motion", "write F in this block")
            }
            _ => ("the motion has no feed", "write F before or in this block"),
        };
        Err(Fault::new(codes::NO_FEED, span, message).help(help))
    }

    /// Work coordinates at the end of the block: programmed axes replaced, the others as they are.
    pub(super) fn targets(&mut self, p: &Pending, span: Span) -> Result<AxisValues, Fault> {
        let mut end = self.position.work;
        if p.programmed != 0 {
            for (axis, coordinate) in p.axes.iter().enumerate() {
                if let Some(coordinate) = coordinate {
                    end.put(axis, self.target(axis, *coordinate, span)?);
                }
            }
        }
        Ok(end)
    }

    fn target(&mut self, axis: usize, coordinate: Coordinate, span: Span) -> Result<f64, Fault> {
        let rotary = (3..6).contains(&axis);
        let value = if rotary { coordinate.value.to_radians() } else { coordinate.value * self.modal.units.length() };
        let reference = match coordinate.reference {
            Reference::Modal if self.modal.incremental => Reference::Incremental,
            Reference::Modal => Reference::Absolute,
            other => other,
        };
        let letter = AXIS_LETTERS[axis];
        if !rotary && matches!(reference, Reference::Shortest | Reference::Positive | Reference::Negative) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("DC, ACP and ACN belong to rotary axes, not to `{letter}`"),
            )
            .help("use AC() or IC()"));
        }
        if matches!(reference, Reference::Shortest | Reference::Positive | Reference::Negative) {
            self.within_modulo(axis, coordinate.value, span)?;
        }
        let target = match reference {
            Reference::Modal | Reference::Absolute if rotary => self.rolled(axis, value),
            Reference::Modal | Reference::Absolute => value,
            Reference::Incremental => self.known(axis, span)? + value,
            Reference::Shortest => self.short_way(axis, value),
            Reference::Positive => {
                let now = self.known(axis, span)?;
                now + turn_up(value - now)
            }
            Reference::Negative => {
                let now = self.known(axis, span)?;
                now - turn_up(now - value)
            }
        };
        finite(axis, target, span)
    }

    /// Positions of DC, ACP and ACN are within one turn (alarm 16830), unless the control converts
    /// them (bit 0 of MD30455).
    fn within_modulo(&self, axis: usize, degrees: f64, span: Span) -> Result<(), Fault> {
        let converts = self.settings.control.parameters.outside_modulo == Some(OutsideModulo::Convert);
        if converts || (0.0..360.0).contains(&degrees) {
            return Ok(());
        }
        let letter = AXIS_LETTERS[axis];
        let message = format!("DC, ACP and ACN take positions of 0 to 359.999 degrees, and {letter} has {degrees}");
        Err(Fault::new(codes::BAD_VALUE, span, message).help(format!(
            "write {letter}=DC({}), or state parameters.outside_modulo = \"convert\" of the control file where MD30455 converts it",
            degrees.rem_euclid(360.0)
        )))
    }

    /// Base coordinates and orientation of the end of a motion.
    pub(super) fn complete(&self, p: &Pending, end: AxisValues, programmed: u16, span: Span) -> Result<Motion, Fault> {
        let mut motion = self.motion_to(end, programmed).map_err(|missing| unknown_axes(&missing, span))?;
        motion.exact_stop = p.exact_stop;
        if !p.has_orientation() {
            return Ok(motion);
        }
        let axis = self.tool_axis(p, span)?;
        let frame = self.position.frame();
        if frame.uniform_scale().is_none() {
            let message = "a tool vector cannot be turned by a frame with unequal scales";
            return Err(Fault::new(codes::ORIENTATION, span, message).help("use equal scale factors for X, Y and Z"));
        }
        motion.tool_axis_base = frame::unit(frame.apply_vector(axis));
        motion.tool_axis = Some(axis);
        // The rotary axes follow the vector; the reader does not know their positions.
        for axis in 3..6 {
            motion.end.clear(axis);
            motion.end_base.clear(axis);
        }
        Ok(motion)
    }

    /// Unit tool axis from A3= B3= C3= or A2= B2= C2=.
    pub(super) fn tool_axis(&self, p: &Pending, span: Span) -> Result<[f64; 3], Fault> {
        let wrong = |message: &str, help: &str| Err(Fault::new(codes::ORIENTATION, span, message).help(help));
        if !self.own.transformed {
            return wrong("a tool vector is programmed and TRAORI is not active", "write TRAORI before it");
        }
        if p.programmed & ROTARY != 0 {
            return wrong("rotary axes and a tool vector in the same block", "program one of the two");
        }
        if self.modal.machine_vectors {
            return wrong("a tool vector in machine coordinates (ORIMKS) is not supported", "write ORIWKS before it");
        }
        let vector = p.vector.iter().any(Option::is_some);
        if vector && p.angles.iter().any(Option::is_some) {
            return wrong("a tool vector and orientation angles in the same block", "program one of the two");
        }
        if vector {
            // Components that are not written are zero.
            let components = p.vector.map(|v| v.unwrap_or(0.0));
            return frame::unit(components).map_or_else(
                || wrong("the tool vector has no length", "give the direction from the tip to the holder"),
                Ok,
            );
        }
        let [a, b, c] = p.angles.map(|v| v.unwrap_or(0.0));
        let frame = match self.modal.angles {
            // The vector along z, turned about Z by C2, the new Y by B2, the newest X by A2.
            Some(OrientationAngles::Rpy) => Frame::rpy([a, b, c]),
            // Turned about Z by A2, the new X by B2, the newest Z by C2.
            Some(OrientationAngles::Euler) | None => Frame::turned([(2, a), (0, b), (2, c)]),
        };
        Ok(frame.apply_vector([0.0, 0.0, 1.0]))
    }

    /// Angles A2= B2= C2= are used. By default the control begins with ORIEULER (*Fundamentals*, G
    /// group 50); MD20150 and MD21100 may select ORIRPY.
    pub(super) fn orientation_angles(&mut self) {
        if self.modal.angles.is_some() {
            return;
        }
        self.modal.angles = Some(OrientationAngles::Euler);
        self.assume(
            "A2= B2= C2= before ORIEULER or ORIRPY are Euler angles, the setting of a new control; MD20150 and \
             MD21100 may set roll, pitch, yaw: write ORIEULER or ORIRPY, or state parameters.orientation_angles of \
             the control file",
        );
    }

    /// SUPA, G53, G153: coordinates of the machine axes, only the programmed ones move.
    fn machine_motion(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let rapid = match self.modal.interpolation {
            Interpolation::Rapid => true,
            Interpolation::Linear => false,
            _ => {
                return Err(Fault::new(codes::CONFLICT, span, "an arc cannot be programmed in machine coordinates")
                    .help("write G0 or G1 with SUPA"));
            }
        };
        if p.has_orientation() || p.has_center() {
            return Err(Fault::new(
                codes::CONFLICT,
                span,
                "machine coordinates and a tool vector or a center exclude each other",
            )
            .help("program the rotary axes"));
        }
        if !rapid {
            self.need_feed(span)?;
        }
        let mut end = AxisValues::NONE;
        for (axis, coordinate) in p.axes.iter().enumerate() {
            let Some(coordinate) = coordinate else { continue };
            let incremental = match coordinate.reference {
                Reference::Modal => self.modal.incremental,
                Reference::Incremental => true,
                _ => false,
            };
            if incremental {
                return Err(Fault::new(
                    codes::POSITION_UNKNOWN,
                    span,
                    "an increment in machine coordinates has no known start",
                )
                .help("write the coordinate with G90 or AC()"));
            }
            let rotary = (3..6).contains(&axis);
            end.put(
                axis,
                if rotary { coordinate.value.to_radians() } else { coordinate.value * self.modal.units.length() },
            );
        }
        self.position.moved_in_machine(&end, p.programmed, self.own.tcp());
        if self.own.transformed {
            // Frames end at the basic coordinate system, which is on the program's side of the
            // transformation (Siemens, *Basic functions*, K2, "Frames"): the control counts SUPA in
            // the coordinates of the tip.
            self.assume(
                "SUPA, G53 or G153 under TRAORI gives positions of the machine axes; the control counts them in the basic \
                 coordinates of the transformation: write TRAFOOF before them",
            );
        }
        self.own.tangent = None;
        self.go_in_machine(end, p.programmed, rapid, p.exact_stop);
        Ok(())
    }
}
