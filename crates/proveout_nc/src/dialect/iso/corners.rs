//! Chamfers `,C` and roundings `,R` of a Fanuc and a Haas. The pieces are made in
//! [`crate::channel::corners`].
//!
//! Fanuc, *Operator's manual*, "Optional chamfering and corner rounding": `,C` is the distance from
//! the corner to both ends of the chamfer, `,R` the radius. They are written in a block of G1, G2
//! or G3. Such a block must follow in the same plane, with nothing but a dwell between. Haas, *Mill
//! operator's manual*, "Corner rounding and chamfering": the same between blocks of G1.

use super::flavor::Flavor;
use super::modal::MotionMode;
use super::parser::{CHAMFER, IsoBlock, ROUNDING};
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::channel::corners::{CornerKind, CornerMark};
use crate::codes;
use crate::diagnostic::{Fault, Span};

impl Interpreter {
    /// The motion of a block, with what its end needs for a corner there or before it.
    pub(super) fn motion_with_corner(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let asked = p.corner_left();
        if !asked && !self.own.corners.waits {
            return self.motion(p, span);
        }
        let kind = if asked { self.corner_kind(p, span)? } else { None };
        let start = self.position.work;
        if kind.is_some() {
            // Without them there is no corner; the axis along the normal may be unknown.
            let [u, v, _] = self.modal.plane_axes();
            self.known(u, span)?;
            self.known(v, span)?;
        }
        let before = self.queue.len();
        self.motion(p, span)?;
        let line = self.modal.motion == Some(MotionMode::Linear);
        if !asked && self.own.flavor == Flavor::Haas && !line && self.queue.len() > before {
            // Nothing marks this motion, so that the corner before it fails.
            self.own.corners.waits = false;
            return Ok(());
        }
        let (axes, frame) = (self.modal.plane_axes(), *self.position.frame());
        self.mark_corner(CornerMark { kind, start, axes, frame, feed: None, strict: true }, before);
        Ok(())
    }

    /// What the words ask for; zero asks for nothing.
    fn corner_kind(&self, p: &mut Pending, span: Span) -> Result<Option<CornerKind>, Fault> {
        let circles = self.own.flavor == Flavor::Fanuc;
        let fits = self.modal.cycle.is_none()
            && match self.modal.motion {
                Some(MotionMode::Linear) => true,
                Some(MotionMode::Clockwise | MotionMode::CounterClockwise) => circles,
                _ => false,
            };
        if !fits || p.axes() == 0 && !p.any_free(b"IJKR") {
            let words = if circles { "G1, G2 or G3" } else { "G1" };
            return Err(Fault::new(
                codes::CONFLICT,
                span,
                format!("`,C` and `,R` need a motion of {words} in their block"),
            )
            .help("write them in the block that ends at the corner"));
        }
        let unit = self.modal.unit();
        let kind = match p.take_corner() {
            [Some(_), Some(_)] => {
                return Err(Fault::new(codes::CONFLICT, span, "the block has both `,C` and `,R`").help("keep one"));
            }
            [Some(leg), None] => CornerKind::Leg(leg * unit),
            [None, Some(radius)] => CornerKind::Rounding(radius * unit),
            [None, None] => return Ok(None),
        };
        let (CornerKind::Leg(size) | CornerKind::Rounding(size) | CornerKind::Chamfer(size)) = kind;
        if !(size >= 0.0 && size.is_finite()) {
            return Err(Fault::new(codes::BAD_VALUE, span, "a chamfer or rounding must not be negative")
                .help("write its length without sign, such as ,R2."));
        }
        Ok((size > 0.0).then_some(kind))
    }
}

/// `,C` or `,R` in a block that has no use for it, such as the call of a macro.
pub(super) fn misplaced(block: &IsoBlock) -> Fault {
    let word = block.words.iter().find(|word| matches!(word.letter, CHAMFER | ROUNDING));
    let span = word.map_or(block.span, |word| word.span);
    Fault::new(codes::UNKNOWN_WORD, span, "the chamfer or rounding has no motion in this block")
        .help("write ,C and ,R in the G1, G2 or G3 that ends at the corner")
}
