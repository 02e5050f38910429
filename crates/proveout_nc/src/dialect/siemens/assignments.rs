//! Words with `=`: values of words, variables, frames.

use super::block::{put_once, refused, word_text};
use super::eval::{self, Val};
use super::expr::Expr;
use super::pending::Pending;
use super::run_state::Interpreter;
use super::words::{self, Class};
use crate::AxisValues;
use crate::channel::expression::IndexedParameter;
use crate::codes;
use crate::diagnostic::{Fault, Span};

impl Interpreter {
    /// `PO[X]=(end, a2, a3, a4, a5)`.
    fn polynomial_word(
        &mut self,
        p: &mut Pending,
        axis: &Expr,
        list: &[Option<Expr>],
        span: Span,
    ) -> Result<(), Fault> {
        let axis = self.named_axis("PO", axis, span)?;
        let [Some(end), coefficients @ ..] = list else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "PO has no end").help("write PO[X]=(10, 2, -1)"));
        };
        if axis > 2 || coefficients.len() > 4 {
            return Err(refused(
                "PO of another axis than X Y Z, or above the fifth power",
                span,
                "program the path with G1",
            ));
        }
        let mut powers = [0.0; 4];
        for (slot, value) in powers.iter_mut().zip(coefficients) {
            *slot = value.as_ref().map_or(Ok(0.0), |value| self.variables.number(value, span))?;
        }
        put_once(&mut p.axes[axis], self.coordinate_of(end, span)?, &crate::AXIS_LETTERS[axis].to_string(), span)?;
        p.programmed |= 1 << axis;
        p.polynomial[axis] = Some(powers);
        Ok(())
    }

    /// The axis that `POS[X]`, `AX[_AXIS]` or `PO[X]` names, by its letter or by a variable of type AXIS.
    pub(super) fn named_axis(&self, word: &str, axis: &Expr, span: Span) -> Result<usize, Fault> {
        let name = match axis {
            // `X`, `B1`: an axis, not a variable.
            Expr::Name(name)
                if name.bytes().skip(1).all(|b| b.is_ascii_digit()) && !self.variables.is_defined(name) =>
            {
                name.clone()
            }
            other => match self.variables.eval(other, span)? {
                Val::Text(name) => name,
                Val::Number(number) => number.to_string(),
            },
        };
        let letter = name.chars().next().filter(|_| eval::is_axis(&name));
        letter.and_then(AxisValues::index).ok_or_else(|| {
            Fault::new(codes::UNKNOWN_WORD, span, format!("`{word}[{name}]` names no axis of the reader"))
                .help("use X Y Z A B C U V W, or a variable of type AXIS that holds one of them")
        })
    }

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
                "ANG" => Some(&mut p.angle),
                "CHF" => Some(&mut p.chamfer),
                "CHR" => Some(&mut p.chamfer_leg),
                "RND" => Some(&mut p.corner_radius),
                "FRC" => Some(&mut p.corner_feed),
                "OVR" => Some(&mut p.feed_override),
                "PW" => Some(&mut p.weight),
                "PL" => Some(&mut p.interval),
                "MEAS" => Some(&mut p.measure),
                "MEAW" => Some(&mut p.measure_on),
                "FP" => Some(&mut p.fixed_point_number),
                _ => None,
            };
            if let Some(slot) = slot {
                let number = self.variables.number(value, span)?;
                // G641 in front of it has put the value in force there.
                if name == "ADIS" {
                    *slot = Some(number);
                    return Ok(());
                }
                return put_once(slot, number, &format!("{name}="), span);
            }
            if matches!(name, "AP" | "RP") {
                let coordinate = self.coordinate_of(value, span)?;
                let slot = if name == "AP" { &mut p.polar_angle } else { &mut p.polar_radius };
                return put_once(slot, coordinate, &format!("{name}="), span);
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
            if name == "SD" {
                let degree = self.variables.number(value, span)?;
                if degree != 2.0 && degree != 3.0 {
                    return Err(Fault::new(
                        codes::BAD_VALUE,
                        span,
                        format!("the degree SD is 2 or 3 and not {degree}"),
                    )
                    .help("write SD=2 or SD=3"));
                }
                self.modal.spline_degree = degree as usize;
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
        if let ("POS" | "AX", [axis]) = (name, indices) {
            let axis = self.named_axis(name, axis, span)?;
            let letter = crate::AXIS_LETTERS[axis];
            put_once(&mut p.axes[axis], self.coordinate_of(value, span)?, &letter.to_string(), span)?;
            p.programmed |= 1 << axis;
            p.positioning |= name == "POS";
            return Ok(());
        }
        if let ("FGREF", [axis]) = (name, indices) {
            let axis = self.named_axis(name, axis, span)?;
            let radius = self.variables.number(value, span)? * self.modal.units.length();
            return self.feed_reference(axis, radius, span);
        }
        if let ("PO", [axis], Expr::Call(_, list)) = (name, indices, value) {
            return self.polynomial_word(p, axis, list, span);
        }
        match words::classify_assignment(name) {
            Class::Note => {
                self.note(word_text(span, line));
                return Ok(());
            }
            Class::Assumed(text) => {
                self.assume(text);
                return Ok(());
            }
            Class::Refused(remedy) => return Err(refused(name, span, remedy)),
            Class::Unknown => {}
        }
        if matches!(value, Expr::Call(function, _) if function == "SET" || function == "REP") {
            return Err(refused("SET", span, "assign the elements one by one, or in DEF"));
        }
        let target = match (name, indices) {
            ("R", [index]) => IndexedParameter::expr(index.clone()),
            (_, []) => Expr::Name(name.to_owned()),
            _ => Expr::Element(name.to_owned(), indices.to_vec()),
        };
        let value = self.variables.eval(value, span)?;
        self.assign_expr(&target, value, span)
    }
}
