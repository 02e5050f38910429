//! Words with `=`: values of words, variables, frames.

use super::block::{refused, word_text};
use super::expr::Expr;
use super::interpreter::Interpreter;
use super::pending::Pending;
use super::words::{self, Class};
use crate::AxisValues;
use crate::channel::expression::Indexed;
use crate::codes;
use crate::diagnostic::{Fault, Span};

impl Interpreter {
    pub(super) fn assignment(
        &mut self,
        p: &mut Pending,
        name: &str,
        indices: &[Expr],
        value: &Expr,
        span: Span,
        line: &str,
    ) -> Result<(), Fault> {
        if indices.is_empty() && !self.variables.is_defined(name) {
            let slot = match name {
                "CR" => Some(&mut p.radius),
                "AR" => Some(&mut p.opening),
                "TURN" => Some(&mut p.turns),
                "RPL" => Some(&mut p.plane_angle),
                "ADIS" => Some(&mut p.rounding),
                "FB" => Some(&mut p.block_feed),
                "CHF" => Some(&mut p.chamfer),
                "CHR" => Some(&mut p.chamfer_leg),
                "RND" => Some(&mut p.corner_radius),
                "FRC" => Some(&mut p.corner_feed),
                "OVR" => Some(&mut p.feed_override),
                _ => None,
            };
            if let Some(slot) = slot {
                *slot = Some(self.variables.number(value, span)?);
                return Ok(());
            }
            if matches!(name, "AP" | "RP") {
                let coordinate = Some(self.coordinate_of(value, span)?);
                *(if name == "AP" { &mut p.polar_angle } else { &mut p.polar_radius }) = coordinate;
                return Ok(());
            }
            if matches!(name, "RNDM" | "FRCM") {
                let value = self.variables.number(value, span)?;
                if name == "RNDM" {
                    let radius = value * self.modal.units.length();
                    self.modal.modal_rounding = (radius > 0.0).then_some(radius);
                } else {
                    self.modal.corner_feed = (value > 0.0).then_some(value);
                }
                return Ok(());
            }
            if name == "DISC" {
                self.modal.compensation.disc = self.variables.number(value, span)?;
                return Ok(());
            }
            if matches!(name, "CTOL" | "OTOL" | "ATOL") {
                let value = self.variables.number(value, span)?;
                return self.tolerance_word(name, value, span);
            }
        }
        if self.is_frame(name) {
            return self.assign_frame(name, indices, value, span);
        }
        if let ("POS", [Expr::Name(axis)]) = (name, indices) {
            let index = match axis.as_bytes() {
                [letter] => AxisValues::index(char::from(*letter)),
                _ => None,
            };
            let Some(axis) = index else {
                return Err(Fault::new(
                    codes::UNKNOWN_WORD,
                    span,
                    format!("`POS[{axis}]` names no axis of the reader"),
                )
                .help("use X Y Z A B C U V W"));
            };
            p.axes[axis] = Some(self.coordinate_of(value, span)?);
            p.programmed |= 1 << axis;
            p.positioning = true;
            return Ok(());
        }
        match words::classify_assignment(name) {
            Class::Note => {
                self.note(word_text(span, line));
                return Ok(());
            }
            Class::Refused(remedy) => return Err(refused(name, span, remedy)),
            Class::Unknown => {}
        }
        if matches!(value, Expr::Call(function, _) if function == "SET" || function == "REP") {
            return Err(refused("SET", span, "assign the elements one by one, or in DEF"));
        }
        let target = match (name, indices) {
            ("R", [index]) => Indexed::expr(index.clone()),
            (_, []) => Expr::Name(name.to_owned()),
            _ => Expr::Element(name.to_owned(), indices.to_vec()),
        };
        let value = self.variables.eval(value, span)?;
        self.assign_expr(&target, value, span)
    }
}
