//! Chamfers and roundings of an 840D: CHF=, CHR=, RND=, RNDM=, FRC=, FRCM=. The pieces are made in
//! [`crate::channel::corners`].

use super::pending::Pending;
use super::run_state::Interpreter;
use crate::channel::corners::{CornerKind, CornerMark};
use crate::codes;
use crate::diagnostic::{Fault, Span};

impl Interpreter {
    /// The corner that a block asks for at its end.
    pub(crate) fn corner_of(&self, p: &Pending, span: Span) -> Result<Option<CornerKind>, Fault> {
        let length = self.modal.units.length();
        let kinds = [
            p.chamfer.map(|v| CornerKind::Chamfer(v * length)),
            p.chamfer_leg.map(|v| CornerKind::Leg(v * length)),
            p.corner_radius.map(|v| CornerKind::Rounding(v * length)),
        ];
        let mut given = kinds.into_iter().flatten();
        let first = given.next();
        if given.next().is_some() {
            return Err(
                Fault::new(codes::CONFLICT, span, "the block has more than one of CHF=, CHR=, RND=").help("keep one")
            );
        }
        let kind = first.or(self.modal.modal_rounding.map(CornerKind::Rounding));
        match kind {
            Some(CornerKind::Chamfer(v) | CornerKind::Leg(v) | CornerKind::Rounding(v)) if v < 0.0 => {
                Err(Fault::new(codes::BAD_VALUE, span, "a chamfer or rounding must not be negative")
                    .help("write RND=2"))
            }
            Some(CornerKind::Chamfer(0.0) | CornerKind::Leg(0.0) | CornerKind::Rounding(0.0)) => Ok(None),
            kind => Ok(kind),
        }
    }

    /// The motion of a block, with what its end needs for a corner there or before it.
    pub(crate) fn motion_with_corner(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let kind = self.corner_of(p, span)?;
        if kind.is_none() && !self.own.corners.waits {
            return self.motion(p, span);
        }
        let start = self.position.work;
        let before = self.queue.len();
        self.motion(p, span)?;
        let feed = match p.corner_feed.or(self.modal.corner_feed) {
            Some(value) => Some((self.feed_of(value, span)?, self.technology.feed)),
            None => None,
        };
        let (axes, frame) = (self.modal.plane_axes(), *self.position.frame());
        self.mark_corner(CornerMark { kind, start, axes, frame, feed, strict: false }, before);
        Ok(())
    }
}
