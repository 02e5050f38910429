//! Motions from their programmed end: base coordinates, straight lines, arcs, threads.

use std::f64::consts::TAU;

use super::{Channel, Language};
use crate::arc::{ArcFault, PlaneArc};
use crate::codes;
use crate::control::ArcTolerance;
use crate::diagnostic::{Fault, FaultSubject, Span};
use crate::machine_data::ReferencePoints;
use crate::state::MissingAxes;
use crate::{AXIS_LETTERS, ArcMotion, AxisValues, FrameChange, Motion, Op, SpindleDirection, ThreadMotion};

/// Difference of the radii of an arc that a tolerance of a control explains, part of the larger one.
const LITTLE: f64 = 1e-4;

impl<L: Language> Channel<L> {
    /// The motion to an end in work coordinates of which these axes (bit mask) are programmed; the missing
    /// axes where a turned frame needs more.
    #[inline]
    pub(crate) fn motion_to(&self, end: AxisValues, programmed: u16) -> Result<Motion, MissingAxes> {
        Ok(Motion { end, end_base: self.position.base_of(&end, programmed)?, programmed, ..Motion::default() })
    }

    /// Emits a motion that ends at positions of the machine axes. What the program knows after it
    /// is settled before.
    pub(crate) fn go_in_machine(&mut self, end: AxisValues, programmed: u16, rapid: bool, exact_stop: bool) {
        let motion =
            Motion { end, end_base: end, programmed, machine_coordinates: true, exact_stop, ..Motion::default() };
        L::moving(self);
        self.emit(if rapid { Op::Rapid(motion) } else { Op::Linear(motion) });
    }

    /// Emits the frame in force.
    pub(crate) fn tell_frame(&mut self, word: &str) {
        let frame = *self.position.frame();
        self.emit(Op::Frame(FrameChange {
            word: word.to_owned(),
            rotation: frame.linear,
            translation: frame.translation,
            rotary: frame.rotary,
        }));
    }

    /// The position of an axis, from which an increment starts.
    pub(crate) fn known(&self, axis: usize, span: Span) -> Result<f64, Fault> {
        self.position.work.get(axis).ok_or_else(|| unknown_axis(axis, span))
    }

    /// The position nearest to the present one among those of a rotary axis that mean this value;
    /// the value itself where the present one is unknown.
    pub(crate) fn short_way(&self, axis: usize, value: f64) -> f64 {
        self.position.work.get(axis).map_or(value, |now| {
            let turn = (value - now).rem_euclid(TAU);
            now + if turn > TAU / 2.0 { turn - TAU } else { turn }
        })
    }

    /// Hands a straight motion out and takes its end as the position.
    #[inline]
    pub(crate) fn go(&mut self, motion: Motion, rapid: bool) {
        if !rapid {
            self.before_feed(&motion);
        }
        self.position.move_to(motion.end, motion.end_base);
        L::moving(self);
        self.emit(if rapid { Op::Rapid(motion) } else { Op::Linear(motion) });
    }

    /// Hands a rapid motion out that leaves a coordinate of a turned frame open: the axes without a word stay
    /// where the machine has them, which whoever runs the motion fills in.
    pub(crate) fn go_left_open(&mut self, end: AxisValues, programmed: u16, exact_stop: bool) {
        let (end_base, known) = self.position.base_left_open(&end, programmed);
        self.position.move_to(end, known);
        L::moving(self);
        self.emit(Op::Rapid(Motion { end, end_base, programmed, exact_stop, ..Motion::default() }));
    }

    /// Hands a motion out that follows the spindle. `pitch`: mm, above zero. `direction`: none where the
    /// spindle turns as it is.
    pub(crate) fn go_thread(&mut self, motion: Motion, pitch: f64, direction: Option<SpindleDirection>) {
        self.position.move_to(motion.end, motion.end_base);
        L::moving(self);
        self.emit(Op::Thread(ThreadMotion { motion, pitch, direction }));
    }

    /// An arc from its center and the axis about which it turns counter-clockwise, work coordinates, and the
    /// motion to its end.
    pub(crate) fn arc_about(
        &self,
        center: [f64; 3],
        normal: [f64; 3],
        arc: &PlaneArc,
        span: Span,
        motion: impl FnOnce(&Self) -> Result<Motion, Fault>,
    ) -> Result<ArcMotion, Fault> {
        let active = *self.position.frame();
        let Some(scale) = active.uniform_scale() else {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "an arc under unequal scales is an ellipse")
                .help("use equal scale factors for X, Y and Z, or write the path with straight lines"));
        };
        // A mirror reverses the sense of rotation about the image of the normal.
        let sense = if active.determinant() < 0.0 { -1.0 } else { 1.0 };
        let normal_base = active.apply_vector(normal).map(|v| sense * v / scale + 0.0);
        Ok(ArcMotion {
            center,
            center_base: self.position.point_in_base(center),
            normal,
            normal_base,
            radius: arc.radius * scale,
            sweep: arc.sweep,
            motion: motion(self)?,
        })
    }

    /// Hands an arc out: its center and the axis about which it turns counter-clockwise, work coordinates.
    pub(crate) fn go_arc(
        &mut self,
        motion: Motion,
        center: [f64; 3],
        normal: [f64; 3],
        arc: &PlaneArc,
        span: Span,
    ) -> Result<(), Fault> {
        let op = self.arc_about(center, normal, arc, span, |_| Ok(motion))?;
        self.before_feed(&op.motion);
        self.position.move_to(op.motion.end, op.motion.end_base);
        L::moving(self);
        self.emit(Op::Arc(op));
        Ok(())
    }

    /// Where the machine's reference point `points` (home, or the second one) has an axis that `word` sends
    /// there.
    pub(crate) fn stated_reference(
        points: &ReferencePoints,
        second: bool,
        axis: usize,
        word: &str,
        span: Span,
    ) -> Result<f64, Fault> {
        let (letter, machine) = (AXIS_LETTERS[axis], &points.machine);
        if machine.is_empty() {
            let message =
                format!("{word} sends {letter} to its reference point, and no machine is named that states it");
            return Err(Fault::new(codes::POSITION_UNKNOWN, span, message)
                .help("name the machine (--machine), or program the position in machine coordinates"));
        }
        if points.axes >> axis & 1 == 0 {
            let message = format!("{word} names {letter}, and machine \"{machine}\" has no axis of this letter");
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("remove the axis"));
        }
        let stated = if second { &points.second } else { &points.first };
        stated.get(axis).ok_or_else(|| {
            let message =
                format!("{word} sends {letter} to its reference point, and machine \"{machine}\" states none for it");
            let key = if (3..6).contains(&axis) { "home_deg" } else { "home_mm" };
            Fault::new(codes::POSITION_UNKNOWN, span, message).help(format!(
                "add {key} to joint {letter} of the machine file, or program the position in machine coordinates"
            ))
        })
    }

    /// Start of an arc in the plane of the first two axes ([`crate::state::Position::arc_start`]).
    pub(crate) fn arc_start(&self, what: &str, axes: [usize; 3], span: Span) -> Result<[f64; 3], Fault> {
        match self.position.arc_start(axes) {
            Some(start) => Ok(start),
            None => self.start_point(what, span),
        }
    }

    /// The point of the tool, which `what` begins at.
    pub(crate) fn start_point(&self, what: &str, span: Span) -> Result<[f64; 3], Fault> {
        self.position.work.xyz().ok_or_else(|| {
            Fault::new(codes::POSITION_UNKNOWN, span, format!("the start of {what} is not known to the program"))
                .help(format!("program X, Y and Z before {what}"))
        })
    }
}

/// The fault of an increment or a cycle that needs an axis which the program has not set.
pub(crate) fn unknown_axis(axis: usize, span: Span) -> Fault {
    let letter = AXIS_LETTERS[axis];
    let message = format!("the position of `{letter}` is not known to the program here");
    Fault::new(codes::POSITION_UNKNOWN, span, message)
        .help(format!("program `{letter}` with an absolute coordinate first"))
}

/// The coordinate that an axis is sent to.
pub(crate) fn finite(axis: usize, target: f64, span: Span) -> Result<f64, Fault> {
    if target.is_finite() {
        return Ok(target);
    }
    let message = format!("the coordinate of `{}` is not finite", AXIS_LETTERS[axis]);
    Err(Fault::new(codes::BAD_VALUE, span, message).help("check the value"))
}

/// A motion in a turned frame without the coordinates that it depends on.
pub(crate) fn unknown_axes(missing: &MissingAxes, span: Span) -> Fault {
    let letters = &missing.0;
    let message =
        format!("in the turned frame this motion needs the position of {letters}, which the program has not set");
    Fault::new(codes::POSITION_UNKNOWN, span, message)
        .help("program X, Y and Z in the first block after machine coordinates, a tool change or a change of the frame")
}

/// Why the words of an arc make no circle. `full_circle`: how the language writes one.
/// The radii at start and end of an arc differ by no more than rounding or another tolerance explains.
pub(crate) fn differ_by_little(fault: &ArcFault) -> bool {
    matches!(fault, ArcFault::Radii(start, end) if (start - end).abs() <= 0.1_f64.max(LITTLE * start.max(*end)))
}

pub(crate) fn arc_fault(fault: ArcFault, tolerance: ArcTolerance, full_circle: &str, span: Span) -> Fault {
    let subject = match fault {
        ArcFault::Radii(start, end) => {
            Some(FaultSubject::ArcRadii { start_nm: nanometers(start), end_nm: nanometers(end) })
        }
        _ => None,
    };
    let (code, message, help) = match fault {
        ArcFault::NoRadius => (
            codes::ARC_GEOMETRY,
            "the center of the arc lies on its start or end, or the radius is zero".to_owned(),
            "correct the center or the radius",
        ),
        ArcFault::Radii(start, end) => (
            codes::ARC_RADIUS,
            format!(
                "the arc has radius {start:.4} mm at its start and {end:.4} mm at its end; the limit of the difference is {tolerance} mm"
            ),
            if differ_by_little(&fault) {
                "give more decimals, or state what the control takes: --arc-tolerance, or arcs.tolerance_mm in a file for --control"
            } else {
                "correct the center or the end point"
            },
        ),
        ArcFault::TooSmall(radius, half) => (
            codes::ARC_RADIUS,
            format!("the radius {radius:.4} mm is smaller than half the distance {half:.4} mm from start to end"),
            "correct the radius or the end point",
        ),
        ArcFault::SamePoint => {
            (codes::ARC_GEOMETRY, "start and end of the arc are the same point".to_owned(), full_circle)
        }
    };
    Fault::new(code, span, message).help(help).about(subject)
}

/// A length of at most some kilometers; what is no length is the largest one.
fn nanometers(mm: f64) -> u64 {
    (mm * 1e6).round() as u64
}
