//! Frame variables: `DEF FRAME`, `CTRANS CROT CSCALE CMIRROR CRPL`, `:`, and the frames of the control by
//! name.
//!
//! After Siemens, *Programming Guide Advanced*, "Frames", and *Function Manual K2*: `$P_UIFR[n]` are the
//! settable frames, which act when their G word is programmed; `$P_IFRAME`, `$P_PFRAME` and `$P_BFRAME` are
//! the settable, programmable and base frame in force and act at once; `$P_ACTFRAME` is their chain.
//! Components: `TR` translation, `RT` rotation (RPY).

use super::expr::Expr;
use super::run_state::Interpreter;
use crate::AxisValues;
use crate::channel::expression::Operator;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::{Frame, UNIT_SCALE};

/// Word of a settable frame by its index in `$P_UIFR`.
fn settable_word(index: f64) -> Option<String> {
    if index.fract() != 0.0 {
        return None;
    }
    match index as i64 {
        0 => Some("G500".to_owned()),
        1..=4 => Some(format!("G{}", 53 + index as i64)),
        5..=99 => Some(format!("G{}", 500 + index as i64)),
        _ => None,
    }
}

fn unsupported(span: Span, message: impl Into<String>) -> Fault {
    Fault::new(codes::UNSUPPORTED_WORD, span, message)
        .help("use CTRANS, CROT, CSCALE, CMIRROR and frames joined by `:`")
}

/// Angles about X, Y, Z in degrees of a rotation `Rz Ry Rx`; none where scale or mirror is in it.
fn rpy_angles(frame: &Frame) -> Option<[f64; 3]> {
    let m = &frame.linear;
    let scale = frame.uniform_scale()?;
    if (scale - 1.0).abs() > UNIT_SCALE || frame.determinant() < 0.0 {
        return None;
    }
    let y = (-m[2][0]).clamp(-1.0, 1.0).asin();
    Some([m[2][1].atan2(m[2][2]), y, m[1][0].atan2(m[0][0])].map(f64::to_degrees))
}

impl Interpreter {
    /// True when the name with its indices means a frame or a component of one.
    pub(crate) fn is_frame(&self, name: &str) -> bool {
        matches!(name, "$P_UIFR" | "$P_IFRAME" | "$P_PFRAME" | "$P_BFRAME" | "$P_CHBFRAME" | "$P_CHBFR" | "$P_ACTFRAME")
            || self.own.frame_variables.contains_key(name)
    }

    /// Splits indices into those of the frame itself and an axis with its component.
    fn component<'a>(name: &str, indices: &'a [Expr]) -> (&'a [Expr], Option<(&'a Expr, &'a Expr)>) {
        let own = usize::from(matches!(name, "$P_UIFR" | "$P_CHBFRAME" | "$P_CHBFR"));
        match indices.split_at_checked(own) {
            Some((own, [axis, part])) => (own, Some((axis, part))),
            Some((own, [])) => (own, None),
            _ => (indices, None),
        }
    }

    fn frame_by_name(&self, name: &str, own: &[Expr], span: Span) -> Result<Frame, Fault> {
        let frames = &self.modal.frames;
        match (name, own) {
            ("$P_PFRAME", []) => Ok(frames.programmable),
            ("$P_IFRAME", []) => Ok(frames.settable),
            ("$P_BFRAME", []) => Ok(frames.base),
            ("$P_ACTFRAME", []) => Ok(frames.total()),
            ("$P_CHBFRAME" | "$P_CHBFR", [index]) if self.variables.number(index, span)? == 0.0 => Ok(frames.base),
            ("$P_UIFR", [index]) => {
                let word = settable_word(self.variables.number(index, span)?)
                    .ok_or_else(|| unsupported(span, "`$P_UIFR` has the indices 0 to 99"))?;
                Ok(self.own.offsets.get(&word).copied().unwrap_or(Frame::IDENTITY))
            }
            _ => self
                .own
                .frame_variables
                .get(name)
                .copied()
                .filter(|_| own.is_empty())
                .ok_or_else(|| unsupported(span, format!("`{name}` is not a frame that can be read here"))),
        }
    }

    /// Value of a frame expression.
    pub(crate) fn frame_value(&self, expr: &Expr, span: Span) -> Result<Frame, Fault> {
        match expr {
            Expr::Chain(first, rest) if rest.iter().all(|(operator, _)| *operator == Operator::Chain) => {
                let mut frame = self.frame_value(first, span)?;
                for (_, right) in rest {
                    frame = frame.then(&self.frame_value(right, span)?);
                }
                Ok(frame)
            }
            Expr::Call(name, arguments) => self.frame_function(name, arguments, span),
            Expr::Name(name) => self.frame_by_name(name, &[], span),
            Expr::Element(name, indices) => self.frame_by_name(name, indices, span),
            _ => Err(Fault::new(codes::TYPE, span, "a frame is needed here").help("write for example CTRANS(X,10)")),
        }
    }

    fn axis_of(argument: Option<&Expr>) -> Option<usize> {
        let Some(Expr::Name(name)) = argument else { return None };
        let mut letters = name.chars();
        AxisValues::index(letters.next()?).filter(|&axis| axis < 6 && letters.next().is_none())
    }

    fn frame_function(&self, name: &str, arguments: &[Option<Expr>], span: Span) -> Result<Frame, Fault> {
        let wrong = || {
            Fault::new(codes::ARGUMENTS, span, format!("the arguments of `{name}` are not axes with their values"))
                .help("write for example CTRANS(X,10,Y,20) or CMIRROR(X)")
        };
        let argument = |at: usize| arguments.get(at).and_then(Option::as_ref);
        if name == "CMIRROR" {
            let mut factors = [1.0; 3];
            for at in 0..arguments.len() {
                let axis = Self::axis_of(argument(at)).filter(|&a| a < 3).ok_or_else(wrong)?;
                factors[axis] = -1.0;
            }
            return Ok(Frame::scale(factors));
        }
        if name == "CRPL" {
            let (Some(plane), Some(angle), 2) = (argument(0), argument(1), arguments.len()) else {
                return Err(wrong());
            };
            let axis = match self.variables.number(plane, span)? {
                0.0 => self.modal.normal,
                1.0 => 2,
                2.0 => 1,
                3.0 => 0,
                _ => return Err(wrong()),
            };
            return Ok(Frame::rotation(axis, self.variables.number(angle, span)?));
        }
        let neutral = if name == "CSCALE" { 1.0 } else { 0.0 };
        let mut values = [neutral, neutral, neutral, 0.0, 0.0, 0.0];
        for pair in (0..arguments.len()).step_by(2) {
            let axis = Self::axis_of(argument(pair)).ok_or_else(wrong)?;
            values[axis] = self.variables.number(argument(pair + 1).ok_or_else(wrong)?, span)?;
            if axis >= 3 && !matches!(name, "CTRANS" | "CFINE") {
                return Err(wrong());
            }
        }
        let linear = [values[0], values[1], values[2]];
        match name {
            "CTRANS" | "CFINE" => Ok(Frame {
                rotary: [values[3], values[4], values[5]].map(f64::to_radians),
                ..Frame::translation(linear.map(|v| v * self.modal.units.length()))
            }),
            "CROT" => Ok(Frame::rpy(linear)),
            "CSCALE" if linear.iter().all(|f| *f > 0.0) => Ok(Frame::scale(linear)),
            "CSCALE" => {
                Err(Fault::new(codes::BAD_VALUE, span, "a scale factor must be above zero").help("mirror with CMIRROR"))
            }
            _ => Err(unsupported(span, format!("the frame function `{name}` is not supported"))),
        }
    }

    /// `F1=CTRANS(X,10)`, `$P_UIFR[1]=...`, `$P_PFRAME[X,TR]=5`.
    pub(crate) fn assign_frame(&mut self, name: &str, indices: &[Expr], value: &Expr, span: Span) -> Result<(), Fault> {
        let (own, component) = Self::component(name, indices);
        let frame = match component {
            None => self.frame_value(value, span)?,
            Some((axis, part)) => {
                let mut frame = self.frame_by_name(name, own, span)?;
                let axis =
                    Self::axis_of(Some(axis)).ok_or_else(|| unsupported(span, format!("`{name}` has no such axis")))?;
                let number = self.variables.number(value, span)?;
                match (part, axis) {
                    (Expr::Name(part), 0..=2) if part == "TR" => {
                        frame.translation[axis] = number * self.modal.units.length();
                    }
                    (Expr::Name(part), 3..=5) if part == "TR" => frame.rotary[axis - 3] = number.to_radians(),
                    (Expr::Name(part), 0..=2) if part == "RT" => {
                        let mut angles = rpy_angles(&frame)
                            .ok_or_else(|| unsupported(span, format!("`{name}` scales or mirrors")))?;
                        angles[axis] = number;
                        frame.linear = Frame::rpy(angles).linear;
                    }
                    _ => return Err(unsupported(span, "of the components of a frame TR and RT can be written")),
                }
                frame
            }
        };
        if frame.inverse_linear().is_none() || !frame.translation.iter().all(|v| v.is_finite()) {
            return Err(Fault::new(codes::BAD_VALUE, span, "the frame is degenerate").help("check its values"));
        }
        match (name, own) {
            ("$P_PFRAME", []) => {
                self.modal.frames.programmable = frame;
                self.modal.frames.additive = None;
            }
            ("$P_IFRAME", []) => self.modal.frames.settable = frame,
            ("$P_BFRAME", []) => self.modal.frames.base = frame,
            ("$P_CHBFRAME" | "$P_CHBFR", [index]) if self.variables.number(index, span)? == 0.0 => {
                self.modal.frames.base = frame;
            }
            ("$P_UIFR", [index]) => {
                let word = settable_word(self.variables.number(index, span)?)
                    .ok_or_else(|| unsupported(span, "`$P_UIFR` has the indices 0 to 99"))?;
                self.own.offsets.insert(word, frame);
                return Ok(());
            }
            (_, []) if self.own.frame_variables.contains_key(name) => {
                self.own.frame_variables.insert(name.to_owned(), frame);
                return Ok(());
            }
            _ => return Err(unsupported(span, format!("`{name}` cannot be written here"))),
        }
        self.take_frames(name);
        Ok(())
    }

    /// A component of a frame as a number: `$P_UIFR[1,X,TR]`; none for any other expression.
    pub(crate) fn frame_component(&self, name: &str, indices: &[Expr], span: Span) -> Option<f64> {
        let (own, Some((axis, Expr::Name(part)))) = Self::component(name, indices) else { return None };
        let frame = self.frame_by_name(name, own, span).ok()?;
        let axis = Self::axis_of(Some(axis))?;
        match (part.as_str(), axis) {
            ("TR", 0..=2) => Some(frame.translation[axis] / self.modal.units.length()),
            ("TR", _) => Some(frame.rotary[axis - 3].to_degrees()),
            ("RT", 0..=2) => rpy_angles(&frame).map(|angles| angles[axis]),
            _ => None,
        }
    }
}
