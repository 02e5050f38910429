//! `MEAS=` and `MEAW=`: a straight motion in feed that takes the position at which the probe switches.
//!
//! MEAS ends the motion there (delete distance-to-go), MEAW runs on to its programmed end. `1` and `2` are
//! the rising edges of the two probe inputs, `-1` and `-2` the falling ones, where the stylus comes off the
//! surface. Then `$AC_MEA[n]` is 1 where the probe has switched, and `$AA_MW[axis]` is the position in work
//! coordinates; `$AA_MM[axis]` is that of the machine axis, which the reader knows of rotary axes only. After
//! Siemens,
//! *SINUMERIK 840D sl, Programming Manual Job Planning*, "Measuring with touch-trigger probe (MEAS, MEAW)".

use super::expr::Expr;
use super::modal::Interpolation;
use super::parser::SiemensBlock;
use super::pending::Pending;
use super::run_state::Interpreter;
use super::system::visit_block;
use crate::channel::probing::{ProbeKind, Reading};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{AXIS_LETTERS, CompSide, Motion};

impl Interpreter {
    /// The motion of a block with MEAS or MEAW.
    pub(super) fn measuring_motion(&mut self, p: &Pending, motion: Motion, span: Span) -> Result<(), Fault> {
        let (word, value) = match (p.measure, p.measure_on) {
            (Some(value), None) => ("MEAS", value),
            (None, Some(value)) => ("MEAW", value),
            _ => {
                return Err(Fault::new(codes::CONFLICT, span, "MEAS and MEAW in one block")
                    .help("write one of them: MEAS ends the motion where the probe switches"));
            }
        };
        let text = format!("{word}={value}");
        if ![1.0, 2.0].contains(&value.abs()) {
            let message = format!("{text} is no probe input");
            return Err(Fault::new(codes::BAD_VALUE, span, message)
                .help("write 1 or 2 for the rising edge of a probe, -1 or -2 for the falling one"));
        }
        if self.modal.interpolation != Interpolation::Linear {
            return Err(Fault::new(codes::CONFLICT, span, format!("{text} measures on a straight motion in feed"))
                .help("write G1 and a feed"));
        }
        if self.modal.compensation.side != CompSide::Off {
            let message =
                format!("{text} while cutter compensation is on: the programmed point is not the center of the ball");
            return Err(Fault::new(codes::PROBE, span, message).help("write G40 before it"));
        }
        self.own.probe_input = value.abs();
        let kind = ProbeKind { away: value < 0.0, must_switch: false, runs_on: word == "MEAW" };
        self.go_probe(motion, kind, &text, span)
    }

    /// Values of the system variables that a measuring motion has set.
    pub(super) fn measured_values(&self, put: &mut dyn FnMut(String, f64)) {
        let Reading::At { work, base, touched, .. } = &self.probing.reading else { return };
        let input = self.own.probe_input;
        for number in [1.0, 2.0] {
            put(format!("$AC_MEA[{number}]"), f64::from(u8::from(*touched && number == input)));
        }
        if !touched {
            return;
        }
        let length = self.modal.units.length();
        for (axis, letter) in AXIS_LETTERS.iter().enumerate() {
            let rotary = (3..6).contains(&axis);
            let unit = |v: f64| if rotary { v.to_degrees() } else { v / length };
            for form in ["", "1"] {
                if let Some(value) = work.get(axis) {
                    put(format!("$AA_MW{form}[{letter}]"), unit(value));
                }
                if let Some(value) = base.get(axis).filter(|_| rotary) {
                    put(format!("$AA_MM{form}[{letter}]"), unit(value));
                }
            }
        }
    }

    /// The fault of a block that reads what no measuring motion has found.
    pub(super) fn reads_unmeasured(&self, block: &SiemensBlock) -> Option<Fault> {
        let mut fault = None;
        visit_block(block, &mut |expr| {
            let Expr::Element(name, _) = expr else { return };
            let (position, state) = (name.starts_with("$AA_MW") || name.starts_with("$AA_MM"), name == "$AC_MEA");
            if !position && !state || self.settings.variables.keys().any(|given| given.starts_with(name.as_str())) {
                return;
            }
            let found = match &self.probing.reading {
                Reading::At { touched: true, .. } if name.starts_with("$AA_MM") => None,
                Reading::At { touched, .. } if state || *touched => None,
                Reading::At { .. } => Some(
                    Fault::new(codes::PROBE, block.span, format!("{name} is read, and the probe has not switched"))
                        .help("ask $AC_MEA[1] first, or let the motion end farther on"),
                ),
                _ => Some(self.not_measured(name, "MEAS=1", block.span)),
            };
            fault = fault.take().or(found);
        });
        fault
    }
}
