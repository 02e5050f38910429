//! System parameters: positions, work offsets, modal state.

use super::eval::unknown_system;
use super::flavor::Flavor;
use super::length::OffsetColumn;
use super::modal::{FeedMode, Length};
use super::run_state::Interpreter;
use crate::channel::probing::Reading;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::Frame;
use crate::g_code::{G17, G18, G19, G40, G41, G42, G80};
use crate::{AXIS_LETTERS, CompSide, PathMode, SpindleDirection, ToolName, WorkOffset};

/// Work offsets by the first of their parameters; each takes twenty numbers.
fn offset_word(flavor: Flavor, number: u32) -> Option<(String, usize)> {
    let (word, first) = match (flavor, number) {
        (_, 5221..=5340) => (format!("G{}", 54 + (number - 5221) / 20), 5221),
        (Flavor::LinuxCnc, 5341..=5390) => (format!("G59.{}", 1 + (number - 5341) / 20), 5341),
        (Flavor::Fanuc, 7001..=7960) => (format!("G54.1P{}", 1 + (number - 7001) / 20), 7001),
        (Flavor::Haas, 14001..=15980) => (format!("G154P{}", 1 + (number - 14001) / 20), 14001),
        (Flavor::Haas, 7001..=7400) => (format!("G154P{}", 1 + (number - 7001) / 20), 7001),
        _ => return None,
    };
    Some((word, ((number - first) % 20) as usize))
}

/// Tool offsets of a Fanuc with memory C (*Operator's manual*, "System variables"): wear and geometry of
/// lengths, then of radii.
fn tool_offset(flavor: Flavor, number: u32) -> Option<(OffsetColumn, u32)> {
    let column = match number {
        10_001..=10_999 => OffsetColumn { radius: false, wear: true },
        11_001..=11_999 => OffsetColumn { radius: false, wear: false },
        12_001..=12_999 => OffsetColumn { radius: true, wear: true },
        13_001..=13_999 => OffsetColumn { radius: true, wear: false },
        _ => return None,
    };
    (flavor == Flavor::Fanuc).then_some((column, number % 1000))
}

impl Interpreter {
    /// A coordinate in the unit of the program: mm or inch, degrees.
    fn shown(&self, axis: usize, value: f64) -> f64 {
        if (3..6).contains(&axis) { value.to_degrees() } else { value / self.modal.unit() }
    }

    fn position_value(&self, axis: usize, machine: bool, name: &str, span: Span) -> Result<f64, Fault> {
        let unknown = || {
            Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                format!("`{name}` is not known: the program has not set the position"),
            )
            .help("program the axis before its position is read")
        };
        let values = if machine { &self.position.base } else { &self.position.work };
        // The machine coordinate of Z contains the tool length, which the reader does not know.
        let readable = !machine || !self.modal.in_table() && axis != self.modal.normal || (3..6).contains(&axis);
        values.get(axis).filter(|_| readable).map(|v| self.shown(axis, v)).ok_or_else(unknown)
    }

    /// Where the last probing motion has ended, in work coordinates of that motion.
    fn skip_value(&self, axis: usize, name: &str, word: &str, span: Span) -> Result<f64, Fault> {
        match &self.probing.reading {
            Reading::At { work, .. } => work.get(axis).map(|v| self.shown(axis, v)).ok_or_else(|| {
                let message = format!("{name} is not known: the program has not set the axis before it probed");
                Fault::new(codes::POSITION_UNKNOWN, span, message).help("program the axis before the probing motion")
            }),
            _ => Err(self.not_measured(name, word, span)),
        }
    }

    /// Number of the word of the work offset: 55 of G55, 54.1 of G54.1 P1.
    fn offset_in_force(&self) -> f64 {
        let word = self.modal.offset.split('P').next().unwrap_or_default();
        word.trim().trim_start_matches('G').parse().unwrap_or(54.0)
    }

    /// Value of a system parameter; none where the number is none.
    pub(crate) fn system_number(&self, number: u32, span: Span) -> Result<Option<f64>, Fault> {
        let name = format!("#{number}");
        if let Some((word, axis)) = offset_word(self.own.flavor, number) {
            if axis < 6 {
                let offset = self.own.offsets.get(&word).copied().unwrap_or_default();
                let value = if axis < 3 { offset.translation[axis] } else { offset.rotary[axis - 3] };
                return Ok(Some(self.shown(axis, value)));
            }
            if self.own.flavor.is_linuxcnc() && axis == 9 {
                return Ok(Some(self.own.turns.get(&word).copied().unwrap_or(0.0)));
            }
            return Err(unknown_system(&name, span));
        }
        if self.own.flavor.is_linuxcnc() {
            return self.linuxcnc_number(number, &name, span);
        }
        if let Some((kept, offset)) = tool_offset(self.own.flavor, number) {
            let stored = self.stored_tool_offset(kept, offset).ok_or_else(|| unknown_system(&name, span))?;
            return Ok(Some(stored / self.modal.unit()));
        }
        let modal = &self.modal;
        let tool = |tool: &Option<ToolName>| match tool {
            Some(ToolName::Number(number)) => f64::from(*number),
            _ => 0.0,
        };
        let shift = &modal.frames.external;
        // #4201 and up describe the block that runs; the reader knows no other.
        let number = if matches!(number, 4201..=4330) { number - 200 } else { number };
        let flag = |on: bool, code: f64, other: f64| if on { code } else { other };
        let value = match number {
            4004 => 23.0,
            4008 => match modal.length {
                Length::Off => 49.0,
                Length::Edge(_) | Length::Programmed(_) => 43.0,
            },
            4009 => modal.cycle.unwrap_or(G80).number(),
            4011 => flag(modal.frames.scale != Frame::IDENTITY, 51.0, 50.0),
            4012..=4017 if self.settings.control.mitsubishi_variables => match number {
                4012 => self.offset_in_force(),
                4013 => flag(modal.path_mode == Some(PathMode::ExactStop), 61.0, 64.0),
                4014 => flag(self.own.modal_macro.is_some(), 66.0, 67.0),
                4017 => flag(modal.surface.is_some(), 96.0, 97.0),
                _ => return Err(unknown_system(&name, span)),
            },
            4012 => flag(self.own.modal_macro.is_some(), 66.0, 67.0),
            4013 => flag(modal.surface.is_some(), 96.0, 97.0),
            4014 => self.offset_in_force(),
            4015 => flag(modal.path_mode == Some(PathMode::ExactStop), 61.0, 64.0),
            4016 => {
                let turned = modal.frames.rotation != Frame::IDENTITY || modal.frames.plane != Frame::IDENTITY;
                flag(turned, 68.0, 69.0)
            }
            4113 => f64::from(self.own.last_m),
            4130 => match modal.offset.split_once('P') {
                Some((_, page)) => page.trim().parse().unwrap_or(0.0),
                None => 0.0,
            },
            5001..=5003 | 5041..=5043 => self.position_value((number as usize - 1) % 20 % 10, false, &name, span)?,
            5021..=5023 => self.position_value(number as usize - 5021, true, &name, span)?,
            5061..=5069 => self.skip_value(number as usize - 5061, &name, "G31", span)?,
            5201..=5203 => self.shown(0, shift[number as usize - 5201]),
            4001 => modal.motion_code.number(),
            4002 => 19.0 - modal.normal as f64,
            4003 => {
                if modal.incremental {
                    91.0
                } else {
                    90.0
                }
            }
            4005 => match modal.feed_mode {
                FeedMode::PerTime => 94.0,
                FeedMode::PerRevolution => 95.0,
                FeedMode::InverseTime => 93.0,
            },
            4006 => {
                if modal.inch == Some(true) {
                    20.0
                } else {
                    21.0
                }
            }
            4007 => match modal.comp {
                CompSide::Off => 40.0,
                CompSide::Left => 41.0,
                CompSide::Right => 42.0,
            },
            4010 => {
                if modal.return_to_r.unwrap_or(false) {
                    99.0
                } else {
                    98.0
                }
            }
            4107 => f64::from(self.own.d.unwrap_or(0)),
            4109 => self.own.feed.unwrap_or(0.0),
            4111 => f64::from(self.own.h.unwrap_or(0)),
            4114 => f64::from(self.own.sequence),
            4119 => self.technology.speed.unwrap_or(0.0),
            4120 => tool(&self.technology.selected),
            3026 => tool(&self.technology.in_spindle),
            1000..=9999 | 10_000.. => return Err(unknown_system(&name, span)),
            _ => return Ok(None),
        };
        Ok(Some(value))
    }

    fn linuxcnc_number(&self, number: u32, name: &str, span: Span) -> Result<Option<f64>, Fault> {
        let shift = &self.modal.frames.shift;
        let value = match number {
            // Reference points: zero where nothing has set them.
            5161..=5169 | 5181..=5189 => 0.0,
            5210 => f64::from(u8::from(self.modal.frames.kept_shift.is_none())),
            5211..=5216 => self.shown(number as usize - 5211, shift[number as usize - 5211]),
            5220 => match self.modal.offset.as_str() {
                "G59.1" => 7.0,
                "G59.2" => 8.0,
                "G59.3" => 9.0,
                word => word.trim_start_matches('G').parse::<f64>().unwrap_or(54.0) - 53.0,
            },
            5400 => match self.technology.in_spindle {
                Some(ToolName::Number(number)) => f64::from(number),
                _ => 0.0,
            },
            5420..=5428 => self.position_value(number as usize - 5420, false, name, span)?,
            5061..=5069 => self.skip_value(number as usize - 5061, name, "G38.2", span)?,
            5070 => match self.probing.reading {
                Reading::At { touched, .. } => f64::from(u8::from(touched)),
                _ => return Err(self.not_measured(name, "G38.2", span)),
            },
            5399 | 5401..=5419 => return Err(unknown_system(name, span)),
            _ => return Ok(None),
        };
        Ok(Some(value))
    }

    /// Value of a predefined named parameter of `LinuxCNC`; none where the name is none.
    pub(crate) fn system_named(&self, name: &str, span: Span) -> Result<Option<f64>, Fault> {
        let Some(short) = name.strip_prefix('_') else { return Ok(None) };
        let truth = |holds: bool| f64::from(u8::from(holds));
        let modal = &self.modal;
        let direction = self.technology.direction;
        let tool = |tool: &Option<ToolName>| match tool {
            Some(ToolName::Number(number)) => f64::from(*number),
            _ => 0.0,
        };
        let value = match short {
            "x" | "y" | "z" | "a" | "b" | "c" | "u" | "v" | "w" => {
                let letter = short.chars().next().unwrap_or('x').to_ascii_uppercase();
                let axis = AXIS_LETTERS.iter().position(|&l| l == letter).unwrap_or(0);
                self.position_value(axis, false, &format!("#<{name}>"), span)?
            }
            "metric" => truth(modal.inch != Some(true)),
            "imperial" => truth(modal.inch == Some(true)),
            "absolute" => truth(!modal.incremental),
            "incremental" => truth(modal.incremental),
            "plane" => f64::from([G19, G18, G17][modal.normal.min(2)].tenths()),
            "motion_mode" => f64::from(modal.motion_code.tenths()),
            "ccomp" => {
                let code = match modal.comp {
                    CompSide::Off => G40,
                    CompSide::Left => G41,
                    CompSide::Right => G42,
                };
                f64::from(code.tenths())
            }
            "coord_system" => {
                let digits: String = modal.offset.chars().filter(char::is_ascii_digit).collect();
                let number: f64 = digits.parse().unwrap_or(54.0);
                if number < 100.0 { number * 10.0 } else { number }
            }
            "feed" => self.own.feed.unwrap_or(0.0),
            "rpm" => self.technology.speed.unwrap_or(0.0),
            "spindle_on" => truth(direction != SpindleDirection::Off),
            "spindle_cw" => truth(direction == SpindleDirection::Clockwise),
            "mist" => truth(self.technology.mist),
            "flood" => truth(self.technology.flood),
            "units_per_minute" => truth(modal.feed_mode == FeedMode::PerTime),
            "units_per_rev" => truth(modal.feed_mode == FeedMode::PerRevolution),
            "inverse_time" => truth(modal.feed_mode == FeedMode::InverseTime),
            "current_tool" => tool(&self.technology.in_spindle),
            "selected_tool" => tool(&self.technology.selected),
            "call_level" => self.depth() as f64,
            "task" => 1.0,
            // Zero until a subprogram returns a value.
            "value" | "value_returned" => 0.0,
            "line" => f64::from(self.own.sequence),
            "vmajor" | "vminor" | "current_pocket" | "selected_pocket" | "tool_offset" | "remap_level"
            | "speed_override" | "feed_override" | "adaptive_feed" | "feed_hold" | "value_undefined" => {
                return Err(unknown_system(&format!("#<{name}>"), span));
            }
            other if other.starts_with("ini[") || other.starts_with("hal[") => {
                return Err(unknown_system(&format!("#<{name}>"), span));
            }
            _ => return Ok(None),
        };
        Ok(Some(value))
    }

    /// Writes a system parameter; false where the number is none.
    pub(crate) fn write_system(&mut self, number: u32, value: Option<f64>, span: Span) -> Result<bool, Fault> {
        let refuse = |help: &str| {
            Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                format!("the system parameter #{number} cannot be written here"),
            )
            .help(help.to_owned()))
        };
        let value = value.unwrap_or(0.0);
        if let Some((word, axis)) = offset_word(self.own.flavor, number) {
            if axis >= 6 || self.own.flavor.is_linuxcnc() {
                return refuse("write work offsets with G10 L2");
            }
            let stored = if axis < 3 { value * self.modal.unit() } else { value.to_radians() };
            let offset: &mut WorkOffset = self.own.offsets.entry(word.clone()).or_default();
            if axis < 3 {
                offset.translation[axis] = stored;
            } else {
                offset.rotary[axis - 3] = stored;
            }
            self.offset_changed(&word);
            return Ok(true);
        }
        if self.own.flavor.is_linuxcnc() {
            return match number {
                // 5599 switches the output of (DEBUG,) on and off.
                5161..=5169 | 5181..=5189 | 1..=5000 | 5599 => Ok(false),
                _ => refuse("write offsets with G10, G92 and G28.1"),
            };
        }
        if let Some((kept, offset)) = tool_offset(self.own.flavor, number) {
            let mm = value * self.modal.unit();
            self.store_tool_offset(kept, offset, mm, false, &format!("#{number}"), span)?;
            return Ok(true);
        }
        match number {
            3003 | 3004 | 3007 | 3008 | 3901 | 3902 | 3001 | 3002 | 3011 | 3012 | 3101..=3199 => {
                self.note(format!("#{number}={value}"));
                Ok(true)
            }
            1..=999 | 10_000..=10_999 => Ok(false),
            5201..=5203 => {
                self.modal.frames.external[number as usize - 5201] = value * self.modal.unit();
                self.frames_changed("#5201");
                Ok(true)
            }
            2001..=2999 | 1000..=1999 => {
                refuse("write tool offsets with G10 L10 to L13; signals of the machine are not known to the twin")
            }
            _ => refuse("use #100 to #199 or #500 to #999"),
        }
    }
}
