//! Threads: G33, G331, G332, G63, CYCLE84 and CYCLE840.
//!
//! Parameters after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), CYCLE84 and CYCLE840; G331 and G332 after
//! *Programming Manual Fundamentals*, "Tapping without compensating chuck". A positive pitch is a right-hand thread.

use proveout_tool::coarse_pitch;

use super::drilling::{Planes, wait};
use super::eval::Val;
use super::frames::number;
use super::interpreter::Interpreter;
use super::modal::Interpolation;
use super::pending::{Pending, Reference};
use crate::channel::milling::WHOLE;
use crate::channel::{Stroke, direction_of, direction_of_thread, opposite};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{Feed, Motion, Op, Spindle, SpindleDirection};

/// Most infeeds of one thread.
const MAX_TAPPING_STEPS: f64 = 1000.0;

impl Interpreter {
    /// A block of G33, G331 or G332: one linear axis, its pitch in I, J or K.
    pub(crate) fn thread_block(&mut self, p: &Pending, motion: Motion, span: Span) -> Result<(), Fault> {
        let interpolation = self.modal.interpolation;
        let word = match interpolation {
            Interpolation::TapIn => "G331",
            Interpolation::TapOut => "G332",
            _ => "G33",
        };
        let moved: Vec<usize> = (0..9).filter(|axis| p.programmed >> axis & 1 == 1).collect();
        let [axis @ 0..=2] = moved[..] else {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                format!("`{word}` with other axes than one of X, Y, Z is not supported"),
            )
            .help("program the axis of the thread alone"));
        };
        Self::second_pitch(p, axis, span)?;
        if let Some(coordinate) = p.center[axis] {
            if coordinate.reference != Reference::Modal || coordinate.value == 0.0 {
                return Err(Fault::new(codes::BAD_VALUE, span, "the pitch is a number other than zero")
                    .help("write for example K1.5"));
            }
            self.own.pitch = Some(coordinate.value * self.modal.units.length());
        }
        let Some(pitch) = self.own.pitch else {
            let letter = ['I', 'J', 'K'][axis];
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("`{word}` has no pitch"))
                .help(format!("write the pitch with {letter}")));
        };
        let turn = direction_of_thread(pitch);
        let direction = match interpolation {
            Interpolation::TapIn => Some(turn),
            Interpolation::TapOut => Some(opposite(turn)),
            _ => None,
        };
        if self.technology.speed.is_none() {
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("`{word}` has no spindle speed"))
                .help("write S before or in the block"));
        }
        self.own.tangent = None;
        self.go_thread(motion, pitch.abs(), direction);
        Ok(())
    }

    /// Pitch from MPIT (nominal diameter) or PIT (mm), with its sign.
    fn cycle_pitch(&self, values: &[Option<Val>], at: usize, name: &str, span: Span) -> Result<Option<f64>, Fault> {
        if let Some(pitch) = number(values, at + 1, name, span)?.filter(|v| *v != 0.0) {
            return Ok(Some(pitch * self.modal.units.length()));
        }
        let Some(size) = number(values, at, name, span)?.filter(|v| *v != 0.0) else { return Ok(None) };
        let Some(pitch) = coarse_pitch(size.abs()) else {
            return Err(Fault::new(
                codes::ARGUMENTS,
                span,
                format!("`{name}` has no coarse pitch for M{}", size.abs()),
            )
            .help("give the pitch itself (PIT)"));
        };
        Ok(Some(pitch.copysign(size)))
    }

    /// CYCLE84(RTP, RFP, SDIS, DP, DPR, DTB, SDAC, MPIT, PIT, POSS, SST, SST1, AXN, PITA, TECHNO, VARI, DAM, VRT).
    ///
    /// Rapid to the start plane, into the hole with the pitch at SST, dwell, out to the start plane at SST1 with the spindle
    /// reversed, rapid to the retraction plane; the spindle then turns as SDAC says.
    pub(crate) fn rigid_tapping(&mut self, planes: Planes, values: &[Option<Val>], span: Span) -> Result<(), Fault> {
        const NAME: &str = "CYCLE84";
        let value = |at: usize| number(values, at, NAME, span);
        if value(12)?.is_some_and(|axis| axis != 0.0 && axis != 3.0) {
            let message = format!("`{NAME}` with another drilling axis (AXN) is not supported");
            return Err(
                Fault::new(codes::UNSUPPORTED_WORD, span, message).help("choose the plane with G17, G18 or G19")
            );
        }
        let unit = match value(13)?.unwrap_or(0.0) {
            0.0 | 1.0 => 1.0,
            // Threads per inch and inch per revolution.
            2.0 => f64::NAN,
            3.0 => 25.4,
            _ => {
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{NAME}` with modular pitch (PITA)"))
                    .help("give the pitch in mm"));
            }
        };
        let pitch = self.cycle_pitch(values, 7, NAME, span)?.ok_or_else(|| {
            Fault::new(codes::ARGUMENTS, span, "`CYCLE84` has no pitch (MPIT or PIT)").help("write the pitch, mm")
        })?;
        let pitch = if unit.is_nan() { 25.4 / pitch } else { pitch * unit };
        // Thousands of AMODE: 1 right-hand, 2 left-hand; without it the sign of the pitch says it.
        let pitch = match value(23)?.map(|mode| (mode / 1000.0).floor().rem_euclid(10.0)) {
            Some(1.0) => pitch.abs(),
            Some(2.0) => -pitch.abs(),
            _ => pitch,
        };
        let speed = value(10)?.filter(|v| *v > 0.0).or(self.technology.speed).ok_or_else(|| {
            Fault::new(codes::ARGUMENTS, span, "`CYCLE84` has no spindle speed (SST)").help("write the speed, 1/min")
        })?;
        let back = value(11)?.filter(|v| *v > 0.0).unwrap_or(speed);
        let turn = direction_of_thread(pitch);
        self.course(&[planes.approach()], span)?;
        if let Some(angle) = value(9)? {
            self.note(format!("CYCLE84 orients the spindle at {angle} degrees"));
        }
        for (depth, up) in self.tapping_steps(planes, values, span)? {
            self.tap(depth, pitch.abs(), turn, speed, span)?;
            self.course(&[wait(value(5)?)], span)?;
            self.tap(up, pitch.abs(), opposite(turn), back, span)?;
        }
        self.spindle(direction_of(value(6)?.unwrap_or(5.0)));
        self.course(&[planes.out()], span)
    }

    /// Depths of CYCLE84, each with the coordinate to come back to: one (VARI 0), or infeeds of DAM with a retraction by VRT
    /// (VARI 1) or to the start plane (VARI 2).
    fn tapping_steps(&self, planes: Planes, values: &[Option<Val>], span: Span) -> Result<Vec<(f64, f64)>, Fault> {
        const NAME: &str = "CYCLE84";
        let value = |at: usize| number(values, at, NAME, span);
        let length = self.modal.units.length();
        let variant = value(15)?.unwrap_or(0.0);
        let infeed = value(16)?.unwrap_or(0.0).abs() * length;
        if variant == 0.0 || infeed == 0.0 {
            return Ok(vec![(planes.depth, planes.start)]);
        }
        if variant != 1.0 && variant != 2.0 {
            return Err(Fault::new(codes::ARGUMENTS, span, format!("`{NAME}` has no machining type (VARI) {variant}"))
                .help("write 0 for one pass, 1 for chip breaking, 2 for full retraction"));
        }
        let total = (planes.reference - planes.depth).abs();
        let down = if planes.depth < planes.reference { -1.0 } else { 1.0 };
        let count = (total / infeed - WHOLE).ceil();
        if count > MAX_TAPPING_STEPS {
            return Err(Fault::new(codes::ARGUMENTS, span, format!("`{NAME}` would need {count} infeeds"))
                .help(format!("choose DAM so that there are at most {MAX_TAPPING_STEPS}")));
        }
        let back = value(17)?.filter(|v| *v > 0.0).map_or(1.0, |v| v * length);
        let mut steps = Vec::new();
        for i in 1..count as u32 {
            let depth = planes.reference + down * infeed * f64::from(i);
            let up = depth - down * back.min((depth - planes.start).abs());
            steps.push((depth, if variant == 1.0 { up } else { planes.start }));
        }
        steps.push((planes.depth, planes.start));
        Ok(steps)
    }

    /// Motion along the drilling axis coupled to the spindle.
    fn tap(&mut self, to: f64, pitch: f64, turn: SpindleDirection, speed: f64, span: Span) -> Result<(), Fault> {
        self.emit(Op::Spindle(Spindle { direction: turn, speed_rpm: Some(speed) }));
        self.course(&[Stroke::Thread { to, pitch, turn }], span)
    }

    /// CYCLE840(RTP, RFP, SDIS, DP, DPR, DTB, SDR, SDAC, ENC, MPIT, PIT): tapping in a compensating chuck.
    ///
    /// The spindle runs as it was started; it reverses at the depth. Without a pitch the feed and speed in force give it.
    pub(crate) fn floating_tapping(&mut self, planes: Planes, values: &[Option<Val>], span: Span) -> Result<(), Fault> {
        const NAME: &str = "CYCLE840";
        let value = |at: usize| number(values, at, NAME, span);
        let speed = self.technology.speed.filter(|s| *s > 0.0).ok_or_else(|| {
            Fault::new(codes::MISSING_VALUE, span, "`CYCLE840` has no spindle speed").help("write S before the cycle")
        })?;
        let pitch = match (self.cycle_pitch(values, 9, NAME, span)?, self.technology.feed) {
            (Some(pitch), _) => pitch.abs(),
            (None, Some(Feed::PerTime(feed))) => feed * 60.0 / speed,
            (None, Some(Feed::PerRevolution(feed))) => feed,
            _ => {
                return Err(Fault::new(codes::ARGUMENTS, span, "`CYCLE840` has neither a pitch nor a feed")
                    .help("write MPIT or PIT, or F before the cycle"));
            }
        };
        let turn = match (value(7)?, self.technology.direction) {
            (Some(m @ (3.0 | 4.0)), _) => direction_of(m),
            (_, SpindleDirection::Off) => SpindleDirection::Clockwise,
            (_, running) => running,
        };
        let back = match value(6)? {
            Some(m @ (3.0 | 4.0)) => direction_of(m),
            _ => opposite(turn),
        };
        self.course(&[planes.approach()], span)?;
        self.tap(planes.depth, pitch, turn, speed, span)?;
        self.course(&[wait(value(5)?)], span)?;
        self.tap(planes.start, pitch, back, speed, span)?;
        self.technology.direction = turn;
        self.emit(Op::Spindle(Spindle { direction: turn, speed_rpm: Some(speed) }));
        self.course(&[planes.out()], span)
    }
}
