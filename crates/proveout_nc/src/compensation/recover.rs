//! Going on behind a fault, for [`crate::check`].

use super::{Compensated, State};
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::dialect::Reader;

impl Compensated {
    pub(crate) fn reader(&self) -> &dyn Reader {
        self.reader.as_ref()
    }

    pub(crate) fn reader_mut(&mut self) -> &mut dyn Reader {
        self.reader.as_mut()
    }

    /// Goes on behind the fault that was handed out last, of the reader or of the contour. A contour that is broken off is
    /// followed without compensation until it is switched on again.
    pub(crate) fn recover(&mut self) -> bool {
        self.finished = false;
        self.state = State::Off;
        // What waited for the end of its block goes out as it is.
        let pending = self.pending.take().map(|pending| pending.command);
        self.out.extend(pending.into_iter().chain(self.held.drain(..)).map(Ok));
        self.exit = None;
        self.residual = [0.0; 2];
        self.position = AxisValues::NONE;
        self.broken = true;
        self.reader.recover()
    }

    /// The fault may follow from one before: behind a broken contour the position is known again when a motion has told it.
    pub(crate) fn follows(&self, fault: &Diagnostic) -> bool {
        let contour = matches!(fault.code, codes::COMPENSATION | codes::POSITION_UNKNOWN);
        self.reader.follows(fault) || contour && self.broken && self.position.xyz().is_none()
    }
}
