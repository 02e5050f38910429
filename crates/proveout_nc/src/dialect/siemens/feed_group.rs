//! FGROUP and FGREF: which axes the feed counts, and at which radius a rotary axis counts.

use super::expr::Expr;
use super::run_state::Interpreter;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{AXIS_LETTERS, FeedCounts};

impl Interpreter {
    /// `FGROUP(X, Y, C)`; `FGROUP()` returns to the machine data.
    pub(super) fn feed_group(&mut self, arguments: &[Option<Expr>], span: Span) -> Result<(), Fault> {
        let mut axes = 0_u16;
        for argument in arguments.iter().flatten() {
            axes |= 1 << self.named_axis("FGROUP", argument, span)?;
        }
        self.own.feed_group = (axes != 0).then_some(axes);
        self.feed_counts();
        Ok(())
    }

    /// `FGREF[C]=100`: the radius at which the feed of a rotary axis counts.
    pub(super) fn feed_reference(&mut self, axis: usize, radius: f64, span: Span) -> Result<(), Fault> {
        if !(3..6).contains(&axis) {
            let message = format!("FGREF[{}] names no rotary axis", AXIS_LETTERS[axis]);
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write A, B or C"));
        }
        if !(radius > 0.0 && radius.is_finite()) {
            let message = format!("the radius FGREF[{}] must be above zero and is {radius} mm", AXIS_LETTERS[axis]);
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write the radius of the part at this axis"));
        }
        self.own.feed_reference[axis - 3] = Some(radius);
        self.feed_counts();
        Ok(())
    }

    fn feed_counts(&mut self) {
        let radius = self.own.feed_reference.map(|radius| radius.unwrap_or(FeedCounts::DEGREE_IS_MM));
        self.told.program_counts = self.own.feed_group.map(|axes| FeedCounts {
            linear: std::array::from_fn(|axis| f64::from(axes >> axis & 1)),
            radius: std::array::from_fn(|axis| f64::from(axes >> (axis + 3) & 1) * radius[axis]),
        });
    }
}
