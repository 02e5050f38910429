//! Probing motions: handed out with the question, gone on with the answer.
//!
//! A step of the reader ends with a probing motion at most. The next one begins when the list of answers has
//! what it found ([`crate::TouchList`]); without such a list the motion runs to its end, and what it finds
//! stays unknown.

use super::{Channel, Language};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::probing::{Contact, Met, Touch};
use crate::state::Position;
use crate::{AXIS_LETTERS, AxisValues, Motion, Op, ProbeMotion};

/// What a probing motion is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ProbeKind {
    /// It ends where the probe leaves the surface.
    pub(crate) away: bool,
    /// A motion without a touch is an alarm.
    pub(crate) must_switch: bool,
    /// After the touch it goes on to its programmed end.
    pub(crate) runs_on: bool,
}

/// A probing motion that was handed out and is not answered.
#[derive(Clone, Debug)]
pub(crate) struct AskedProbe {
    motion: ProbeMotion,
    runs_on: bool,
    /// Word, for messages.
    word: String,
    span: Span,
    /// Line, for messages.
    line: String,
}

/// What the last probing motion has left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// The program has not probed.
    NotYet,
    /// It has, and what it found is not known.
    Unknown,
    /// Position where the probe switched, or the end of a motion without a touch.
    At {
        /// Work coordinates, mm and radian.
        work: AxisValues,
        /// Base coordinates, mm and radian.
        base: AxisValues,
        /// The probe has switched.
        touched: bool,
        /// Radius of the ball of the stylus, mm.
        ball_radius: f64,
    },
}

/// Probing in the run of a program.
#[derive(Debug)]
pub(crate) struct Probing {
    /// Probing motions so far.
    count: usize,
    asked: Option<Box<AskedProbe>>,
    pub(crate) reading: Reading,
    /// The run has ended at a motion without an answer.
    pub(crate) waits: bool,
}

impl Probing {
    pub(crate) fn new() -> Self {
        Self { count: 0, asked: None, reading: Reading::NotYet, waits: false }
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.asked.is_some()
    }
}

/// Each axis after a part of the way between two positions.
fn after(share: f64, from: &AxisValues, to: &AxisValues) -> AxisValues {
    let mut at = *to;
    for axis in 0..AXIS_LETTERS.len() {
        if let (Some(a), Some(b)) = (from.get(axis), to.get(axis)) {
            at.put(axis, if share >= 1.0 { b } else { a + share * (b - a) });
        }
    }
    at
}

impl<L: Language> Channel<L> {
    /// Hands a probing motion out. `word`: as messages call it.
    pub(crate) fn go_probe(&mut self, motion: Motion, kind: ProbeKind, word: &str, span: Span) -> Result<(), Fault> {
        let number = self.probing.count;
        self.probing.count += 1;
        L::moving(self);
        let ProbeKind { away, must_switch, runs_on } = kind;
        let probe = ProbeMotion { motion, away, must_switch, contact: Contact::Unknown };
        let Some(touches) = &self.settings.touches else {
            self.position.move_to(probe.motion.end, probe.motion.end_base);
            self.probing.reading = Reading::Unknown;
            self.emit(Op::Probe(probe));
            return Ok(());
        };
        let known = |axis: usize| probe.motion.programmed >> axis & 1 == 0 || self.position.work.get(axis).is_some();
        if let Some(axis) = (0..AXIS_LETTERS.len()).find(|&axis| !known(axis)) {
            let message = format!("{word} begins at a position of {} that the program has not set", AXIS_LETTERS[axis]);
            return Err(Fault::new(codes::POSITION_UNKNOWN, span, message)
                .help("program the axis before it probes, so that the way is known"));
        }
        match touches.get(number) {
            Some(touch) => self.probed(probe, runs_on, touch, word, span),
            None => {
                let asked = ProbeMotion { contact: Contact::Asked, ..probe.clone() };
                self.emit(Op::Probe(asked));
                let line = self.line_of(&self.location.file.clone(), self.location.line).unwrap_or_default();
                let word = word.to_owned();
                self.probing.asked = Some(Box::new(AskedProbe { motion: probe, runs_on, word, span, line }));
                Ok(())
            }
        }
    }

    /// The probing motion with its answer: its true end, and what the control then knows.
    fn probed(
        &mut self,
        mut probe: ProbeMotion,
        runs_on: bool,
        touch: Touch,
        word: &str,
        span: Span,
    ) -> Result<(), Fault> {
        let Position { work: from, base: from_base, .. } = self.position.clone();
        let share = match touch.met {
            Met::Unknown => {
                self.position.move_to(probe.motion.end, probe.motion.end_base);
                self.probing.reading = Reading::Unknown;
                self.emit(Op::Probe(probe));
                return Ok(());
            }
            Met::After(share) => Some(share.clamp(0.0, 1.0)),
            Met::Nothing => None,
        };
        let fault = |message: String, help: &str| Err(Fault::new(codes::PROBE, span, message).help(help));
        if probe.must_switch && touch.at_start {
            let (state, help) = match probe.away {
                false => ("touches already", "begin the motion clear of the part"),
                true => ("does not touch", "begin the motion where the stylus touches"),
            };
            return fault(format!("{word} begins where the stylus {state}: the control raises an alarm"), help);
        }
        let whole = (runs_on && share.is_some()).then(|| probe.motion.clone());
        let end = share.unwrap_or(1.0);
        probe.motion.end = after(end, &from, &probe.motion.end);
        probe.motion.end_base = after(end, &from_base, &probe.motion.end_base);
        probe.contact = if share.is_some() { Contact::Touched } else { Contact::Missed };
        self.position.move_to(probe.motion.end, probe.motion.end_base);
        self.probing.reading = Reading::At {
            work: probe.motion.end,
            base: probe.motion.end_base,
            touched: share.is_some(),
            ball_radius: touch.ball_radius,
        };
        let misses = probe.must_switch && share.is_none();
        let away = probe.away;
        self.emit(Op::Probe(probe));
        if let Some(whole) = whole {
            self.go(whole, false);
        }
        if misses {
            let met = if away { "does not come off the surface" } else { "touches nothing" };
            return fault(
                format!("{word} runs to its end and {met}: the control raises an alarm"),
                "check the place of the part and the work offset, or let the motion end farther on",
            );
        }
        Ok(())
    }

    /// Before the next step: takes the answer to the motion that was asked for. False where there is none:
    /// the run is at its end.
    pub(crate) fn answered(&mut self) -> bool {
        let Some(touch) = self.settings.touches.as_ref().and_then(|t| t.get(self.probing.count - 1)) else {
            self.probing.waits = true;
            return false;
        };
        self.probing.waits = false;
        let Some(asked) = self.probing.asked.take() else { return true };
        let AskedProbe { motion, runs_on, word, span, line } = *asked;
        if let Err(fault) = self.probed(motion, runs_on, touch, &word, span) {
            self.done = true;
            self.failure = Some(Box::new(fault.at(&self.location.file, self.location.line, &line)));
        }
        true
    }

    /// The fault of a program that reads what no probing motion has found.
    pub(crate) fn not_measured(&self, name: &str, word: &str, span: Span) -> Fault {
        match self.probing.reading {
            Reading::NotYet if self.settings.touches.is_some() => {
                let message = format!("{name} is read before a probing motion has measured it");
                Fault::new(codes::PROBE, span, message).help(format!("probe first ({word}), then read {name}"))
            }
            _ => {
                let message = format!("{name} is what a probing motion finds, and that is not known here");
                Fault::new(codes::PROBE, span, message).help(
                    "run the program on a scene with a tool of kind \"probe\" in the spindle, which measures on the stock",
                )
            }
        }
    }
}
