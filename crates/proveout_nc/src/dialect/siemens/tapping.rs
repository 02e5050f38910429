//! Threads: G33, G331, G332, G63, CYCLE84 and CYCLE840.
//!
//! Parameters after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), CYCLE84 and CYCLE840; G331
//! and G332 after *Programming Manual Fundamentals*, "Tapping without compensating chuck". A positive pitch
//! is a right-hand thread.

use proveout_tool::coarse_pitch;

use super::drilling::wait;
use super::interpreter::Interpreter;
use super::modal::Interpolation;
use super::pending::{Pending, Reference};
use crate::channel::milling::{Heights, WHOLE};
use crate::channel::{Stroke, direction_of, direction_of_thread, opposite};
use crate::codes;
use crate::cycle::Values;
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
    fn cycle_pitch(v: &Values) -> Result<Option<f64>, Fault> {
        if let Some(pitch) = v.get("PIT")?.filter(|pitch| *pitch != 0.0) {
            return Ok(Some(pitch));
        }
        let Some(size) = v.get("MPIT")?.filter(|size| *size != 0.0) else { return Ok(None) };
        let Some(pitch) = coarse_pitch(size.abs()) else {
            let message = format!("`{}` has no coarse pitch for M{}", v.name(), size.abs());
            return Err(v.fault(codes::ARGUMENTS, message, "give the pitch itself (PIT)"));
        };
        Ok(Some(pitch.copysign(size)))
    }

    /// CYCLE84: rapid to the start plane, into the hole with the pitch at SST, dwell, out to the start plane
    /// at SST1 with the spindle reversed, rapid to the retraction plane; the spindle then turns as SDAC says.
    pub(crate) fn rigid_tapping(&mut self, h: Heights, v: &Values) -> Result<(), Fault> {
        if v.get("AXN")?.is_some_and(|axis| axis != 0.0 && axis != 3.0) {
            let message = "`CYCLE84` with another drilling axis (AXN) is not supported";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, "choose the plane with G17, G18 or G19"));
        }
        let unit = match v.value("PITA")? {
            0.0 | 1.0 => 1.0,
            // Threads per inch and inch per revolution.
            2.0 => f64::NAN,
            3.0 => 25.4,
            _ => {
                let message = "`CYCLE84` with modular pitch (PITA)";
                return Err(v.fault(codes::UNSUPPORTED_WORD, message, "give the pitch in mm"));
            }
        };
        let pitch = Self::cycle_pitch(v)?
            .ok_or_else(|| v.fault(codes::ARGUMENTS, "`CYCLE84` has no pitch (MPIT or PIT)", "write the pitch, mm"))?;
        let pitch = if unit.is_nan() { 25.4 / pitch } else { pitch * unit };
        // Thousands of AMODE: 1 right-hand, 2 left-hand; without it the sign of the pitch says it.
        let pitch = match v.digit("AMODE", 1000.0)? {
            1.0 => pitch.abs(),
            2.0 => -pitch.abs(),
            _ => pitch,
        };
        let speed = v.get("SST")?.filter(|v| *v > 0.0).or(self.technology.speed).ok_or_else(|| {
            v.fault(codes::ARGUMENTS, "`CYCLE84` has no spindle speed (SST)", "write the speed, 1/min")
        })?;
        let back = v.get("SST1")?.filter(|v| *v > 0.0).unwrap_or(speed);
        let turn = direction_of_thread(pitch);
        self.course(&[h.approach()], v.span)?;
        if let Some(angle) = v.get("POSS")? {
            self.note(format!("CYCLE84 orients the spindle at {angle} degrees"));
        }
        for (depth, up) in Self::tapping_steps(h, v)? {
            self.tap(depth, pitch.abs(), turn, speed, v.span)?;
            self.course(&[wait(v.get("DTB")?)], v.span)?;
            self.tap(up, pitch.abs(), opposite(turn), back, v.span)?;
        }
        self.spindle(direction_of(v.value("SDAC")?));
        self.course(&[h.out()], v.span)
    }

    /// Depths of CYCLE84, each with the coordinate to come back to: one (VARI 0), or infeeds of DAM with a
    /// retraction by VRT (VARI 1) or to the start plane (VARI 2).
    fn tapping_steps(h: Heights, v: &Values) -> Result<Vec<(f64, f64)>, Fault> {
        let (variant, infeed) = (v.value("VARI")?, v.value("DAM")?);
        if variant == 0.0 || infeed == 0.0 {
            return Ok(vec![(h.depth, h.clear)]);
        }
        if variant != 1.0 && variant != 2.0 {
            let message = format!("`CYCLE84` has no machining type (VARI) {variant}");
            let help = "write 0 for one pass, 1 for chip breaking, 2 for full retraction";
            return Err(v.fault(codes::ARGUMENTS, message, help));
        }
        let count = ((h.surface - h.depth).abs() / infeed - WHOLE).ceil();
        if count > MAX_TAPPING_STEPS {
            let message = format!("`CYCLE84` would need {count} infeeds");
            return Err(Fault::new(codes::ARGUMENTS, v.span, message)
                .help(format!("choose DAM so that there are at most {MAX_TAPPING_STEPS}")));
        }
        let back = v.get("VRT")?.filter(|back| *back > 0.0).unwrap_or(1.0);
        let mut steps = Vec::new();
        for i in 1..count as u32 {
            let depth = h.surface + h.down * infeed * f64::from(i);
            let up = depth - h.down * back.min((depth - h.clear).abs());
            steps.push((depth, if variant == 1.0 { up } else { h.clear }));
        }
        steps.push((h.depth, h.clear));
        Ok(steps)
    }

    /// Motion along the drilling axis coupled to the spindle.
    fn tap(&mut self, to: f64, pitch: f64, turn: SpindleDirection, speed: f64, span: Span) -> Result<(), Fault> {
        self.emit(Op::Spindle(Spindle { direction: turn, speed_rpm: Some(speed) }));
        self.course(&[Stroke::Thread { to, pitch, turn }], span)
    }

    /// CYCLE840: tapping in a compensating chuck. The spindle runs as it was started; it reverses at the
    /// depth. Without a pitch the feed and speed in force give it.
    pub(crate) fn floating_tapping(&mut self, h: Heights, v: &Values) -> Result<(), Fault> {
        let speed = self.technology.speed.filter(|s| *s > 0.0).ok_or_else(|| {
            v.fault(codes::MISSING_VALUE, "`CYCLE840` has no spindle speed", "write S before the cycle")
        })?;
        let pitch = match (Self::cycle_pitch(v)?, self.technology.feed) {
            (Some(pitch), _) => pitch.abs(),
            (None, Some(Feed::PerTime(feed))) => feed * 60.0 / speed,
            (None, Some(Feed::PerRevolution(feed))) => feed,
            _ => {
                let message = "`CYCLE840` has neither a pitch nor a feed";
                return Err(v.fault(codes::ARGUMENTS, message, "write MPIT or PIT, or F before the cycle"));
            }
        };
        let turn = match (v.get("SDAC")?, self.technology.direction) {
            (Some(m @ (3.0 | 4.0)), _) => direction_of(m),
            (_, SpindleDirection::Off) => SpindleDirection::Clockwise,
            (_, running) => running,
        };
        let back = match v.get("SDR")? {
            Some(m @ (3.0 | 4.0)) => direction_of(m),
            _ => opposite(turn),
        };
        self.course(&[h.approach()], v.span)?;
        self.tap(h.depth, pitch, turn, speed, v.span)?;
        self.course(&[wait(v.get("DTB")?)], v.span)?;
        self.tap(h.clear, pitch, back, speed, v.span)?;
        self.technology.direction = turn;
        self.emit(Op::Spindle(Spindle { direction: turn, speed_rpm: Some(speed) }));
        self.course(&[h.out()], v.span)
    }
}
