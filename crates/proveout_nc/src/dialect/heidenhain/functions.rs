//! M functions: those that act at the start of a block, and those that act at its end.
//!
//! Assignment after HEIDENHAIN, *TNC 640 Klartext programming*, "Miscellaneous functions" and its
//! overview of M functions.

use super::lexer::{Lexer, refused};
use super::listed::LISTED;
use super::run_state::{Heidenhain, Interpreter};
use super::words::{FeedWord, MWord, PathFunction, Words};
use crate::channel::{Language, direction_of};
use crate::codes;
use crate::control::{Control, Meaning};
use crate::diagnostic::{Fault, Span};
use crate::dialect::listed::{WordState, refused_by, unlisted};
use crate::frame::add_scaled;
use crate::machine_data::KinematicsKind;
use crate::{AxisValues, Op, Retract, SpindleDirection};

/// Code of an `M` without a number.
pub(crate) const NOTHING: u32 = u32::MAX;
/// A feed is told with six decimals.
const DECIMALS: f64 = 1e6;

/// Most blocks that M120 LA allows.
const MOST_AHEAD: f64 = 99.0;

/// Reads the number after an `M` that began at `start`, and the words that belong to the function.
pub(crate) fn word(x: &mut Lexer<'_>, start: usize) -> Result<MWord, Fault> {
    x.blanks();
    if x.s.at_end() || x.peek().is_ascii_alphabetic() {
        // `M` alone, as older controls write a block without functions.
        return Ok(MWord { code: NOTHING, value: None, max: false, feed: None, axes: 0, span: x.span_from(start) });
    }
    let Some(code) = x.s.integer() else {
        return Err(Fault::new(codes::MISSING_VALUE, x.span_from(start), "`M` has no number").help("write M3"));
    };
    let mut m = MWord { code, value: None, max: false, feed: None, axes: 0, span: x.span_from(start) };
    match code {
        94 | 138 => loop {
            x.blanks();
            let index = AxisValues::index(char::from(x.peek()))
                .filter(|_| !matches!(x.peek_at(1), b'0'..=b'9' | b'+' | b'-' | b'.'));
            let Some(index) = index else { break };
            x.s.bump();
            m.axes |= 1 << index;
        },
        // The words after these belong to them: limits of handwheel superimposition, filters,
        // look-ahead.
        118 => {
            while {
                x.blanks();
                AxisValues::index(char::from(x.peek())).is_some() || x.at("MB") || x.at("VT")
            } {
                let at = x.pos();
                let letters = x.letters();
                if letters == "MB" && x.word("MAX") {
                    continue;
                }
                x.need(at)?;
            }
        }
        120 if x.prefix("LA") => m.value = Some(x.need(start)?),
        112 | 124 => {
            while {
                x.blanks();
                matches!(x.peek(), b'T' | b'A') && !x.peek_at(1).is_ascii_alphabetic()
            } {
                let at = x.pos();
                x.s.bump();
                x.need(at)?;
            }
        }
        103 | 128 => {
            let at = x.pos();
            if x.prefix("F") {
                m.feed = Some(x.feed(at)?);
            }
        }
        140 => {
            if x.prefix("MB") {
                if x.word("MAX") {
                    m.max = true;
                } else {
                    m.value = Some(x.need(start)?);
                }
            } else {
                return Err(Fault::new(codes::MISSING_VALUE, x.span_from(start), "M140 has no retraction distance")
                    .help("write M140 MB 50 or M140 MB MAX"));
            }
            x.blanks();
            let at = x.pos();
            if x.prefix("F") {
                m.feed = Some(x.feed(at)?);
            }
        }
        _ => {}
    }
    m.span = x.span_from(start);
    Ok(m)
}

/// The fault of a function that no state of the control makes valid.
pub(crate) fn refused_function(m: &MWord, control: &Control) -> Option<Fault> {
    let code = m.code;
    if let Some((_, listed)) = control.words.m(code) {
        let Meaning::Refuse(remedy) = &listed.meaning else { return None };
        return Some(refused_by(control, &listed.word, m.span, remedy));
    }
    // Two axes are those of the five-axis machine; only one of them would be another kinematics.
    let one_axis = code == 138 && m.axes.count_ones() == 1;
    if let Some(remedy) = if one_axis { Some(ONE_SWIVEL_AXIS) } else { remedy(code) } {
        return Some(refused(&format!("M{code}"), m.span, remedy));
    }
    (control.refuses_unlisted && !is_known(code)).then(|| unlisted(control, &format!("M{code}"), m.span))
}

/// What the reader does with a function defined neither by itself nor by the control file; none for
/// the others.
pub(crate) fn unlisted_function(m: &MWord, control: &Control) -> Option<WordState> {
    if control.words.m(m.code).is_some() {
        return None;
    }
    match (refused_function(m, control).is_some(), is_known(m.code)) {
        (true, true) => Some(WordState::NotSupported),
        (true, false) => Some(WordState::Unknown),
        (false, true) => None,
        (false, false) => Some(WordState::Noted),
    }
}

/// Functions of the language; all others are those of the machine builder.
fn is_known(code: u32) -> bool {
    matches!(code, 0..=9 | 13 | 14 | 30 | 89..=92 | 94 | 97..=99 | 101..=149 | NOTHING)
}

/// The reader executes this function itself, and no words of its own follow it.
pub(crate) fn does_function(code: u32) -> bool {
    matches!(code, 0 | 1 | 3..=5 | 7..=9 | 13 | 14 | 89 | 91 | 92 | 99 | 126..=129 | 136 | 137)
}

const ONE_SWIVEL_AXIS: &str = "it excludes rotary axes from M128, TCPM and tilted planes, but the twin uses the \
                               kinematics of the machine file: name both axes, or program their positions";

/// Remedy for an M function that is refused.
fn remedy(code: u32) -> Option<&'static str> {
    Some(match code {
        103 => "it lowers the feed of plunging: write the feed into the blocks",
        114 | 115 => "it was replaced by M128: use M128 or FUNCTION TCPM",
        130 => "switch the tilted plane off with PLANE RESET for the block",
        144 | 146 => "use M128 or FUNCTION TCPM",
        _ => return None,
    })
}

impl Interpreter {
    /// Functions that act at the start of the block.
    pub(crate) fn functions_before(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        for m in &w.functions {
            match m.code {
                0 | 1 | 2 | 5 | 9 | 30 | 89 | 91 | 92 | 99 | 127 | 129 | 137 => {}
                3 | 4 => self.spindle(direction_of(f64::from(m.code))),
                13 | 14 => self.spindle(direction_of(f64::from(m.code - 10))),
                _ => {}
            }
            match m.code {
                7 | 8 => self.coolant(m.code),
                13 | 14 => self.coolant(8),
                120 => {
                    let blocks = m.value.map(|value| self.variables.value(value, m.span)).transpose()?;
                    self.modal.look_ahead = blocks.map_or(1, |n| n.clamp(1.0, MOST_AHEAD) as usize);
                    self.modal.look_ahead_ended = false;
                    self.note("M120");
                }
                126 => self.modal.shortest = true,
                128 => {
                    self.settings.check_kinematics(KinematicsKind::Tcp, "M128", m.span)?;
                    if let Some(feed) = m.feed {
                        // Limits the compensating motions of the linear axes, which the limits of
                        // the machine bound too.
                        if let Some(crate::Feed::PerTime(feed)) = self.feed_of(feed, m.span)? {
                            self.note(format!("M128 F{}", (feed * 60.0 * DECIMALS).round() / DECIMALS));
                        }
                    }
                    self.modal.spatial = false;
                    self.modal.interpolation = crate::OrientationInterpolation::Axes;
                    self.set_tcpm(true);
                }
                136 => {
                    if self.modal.inch {
                        return Err(refused("M136 in inch", m.span, "write the feed in tenths of an inch a minute"));
                    }
                    self.modal.per_revolution = true;
                    self.technology.feed = None;
                }
                137 => {
                    if self.modal.per_revolution {
                        self.technology.feed = None;
                    }
                    self.modal.per_revolution = false;
                }
                140 => {
                    let distance = match m.value {
                        Some(value) => Some(self.variables.value(value, m.span)? * self.modal.unit()),
                        None => None,
                    };
                    self.retract(distance, m.feed, span)?;
                }
                94 => {
                    // Reduces the display of a rotary axis to less than one turn: its program value
                    // is then unknown.
                    let axes = if m.axes & super::motion::ROTARY != 0 { m.axes } else { super::motion::ROTARY };
                    self.position.forget(axes & super::motion::ROTARY);
                    self.note("M94");
                }
                0..=5 | 9 | 30 | 89 | 91 | 92 | 99 | 127 | 129 | NOTHING => {}
                code if code >= LISTED => self.act_listed(code, m.span)?,
                code => self.note(format!("M{code}")),
            }
        }
        Ok(())
    }

    /// Functions that act at the end of the block, but for the end of the program.
    pub(crate) fn functions_after(&mut self, w: &Words, _span: Span) -> Result<(), Fault> {
        for m in &w.functions {
            match m.code {
                5 => self.spindle(SpindleDirection::Off),
                9 => self.coolant(9),
                127 => self.modal.shortest = false,
                129 => self.set_tcpm(false),
                _ => {}
            }
        }
        Ok(())
    }

    /// Stop and end of program, after everything else in the block.
    pub(crate) fn functions_last(&mut self, w: &Words) {
        for m in &w.functions {
            match m.code {
                0 | 1 => self.emit(Op::Stop { optional: m.code == 1 }),
                2 | 30 => return self.end_of_program(),
                _ => {}
            }
        }
    }

    /// M99 and M89: the cycle runs at the end of the block.
    pub(crate) fn cycle_after(&mut self, path: PathFunction, w: &Words, span: Span) -> Result<(), Fault> {
        if w.has(89) {
            self.modal.modal_cycle = true;
        }
        let once = w.has(99);
        if once {
            self.modal.modal_cycle = false;
        }
        let positioned = path != PathFunction::Nothing && w.programmed != 0;
        if once || self.modal.modal_cycle && positioned {
            self.run_cycle(span)?;
        }
        Ok(())
    }

    /// M140 MB: retraction along the tool axis. It is a motion where the reader knows direction and
    /// start, otherwise a command of its own.
    pub(crate) fn retract(&mut self, distance: Option<f64>, feed: Option<FeedWord>, span: Span) -> Result<(), Fault> {
        if distance.is_some_and(|d| !(d >= 0.0 && d.is_finite())) {
            return Err(Fault::new(codes::BAD_VALUE, span, "the retraction distance of M140 must not be negative")
                .help("write M140 MB 50"));
        }
        let rapid = !matches!(feed, Some(FeedWord::Value(_) | FeedWord::Auto | FeedWord::PerRevolution(_)));
        let before = self.technology.feed;
        if let (false, Some(word)) = (rapid, feed) {
            self.technology.feed = self.feed_of(word, span)?;
            self.tell_feed();
        }
        let known = self.position.base.xyz().zip(self.position.work.xyz());
        // The tool points along the tool axis of the plane; it is upright where nothing has
        // inclined it.
        let upright = !self.modal.inclined || (3..6).all(|axis| self.position.base.get(axis) == Some(0.0));
        let axis_known = !self.modal.tcpm && (self.modal.frames.tilted() || upright);
        match (distance, known) {
            (Some(distance), Some((_, point))) if axis_known => {
                let mut axis = [0.0; 3];
                axis[self.modal.normal] = 1.0;
                let mut goal = super::motion::Goal { end: self.position.work, programmed: 0, tool_axis: None };
                let to = add_scaled(point, axis, distance);
                goal.end.put(self.modal.normal, to[self.modal.normal]);
                goal.programmed = 1 << self.modal.normal;
                self.straight(goal, rapid, span)?;
            }
            _ => {
                self.emit(Op::Retract(Retract { distance, rapid }));
                self.position.forget(super::motion::LINEAR);
                self.modal.tangent = None;
                Heidenhain::moving(self);
            }
        }
        self.technology.feed = before;
        Ok(())
    }
}
