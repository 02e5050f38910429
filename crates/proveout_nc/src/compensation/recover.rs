//! Going on after a fault, for [`crate::check`].

use super::stretch::ContourStretch;
use super::{CompState, CompensatedReader};
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::dialect::Reader;

impl CompensatedReader {
    pub(crate) fn reader(&self) -> &dyn Reader {
        self.reader.as_ref()
    }

    pub(crate) fn reader_mut(&mut self) -> &mut dyn Reader {
        self.reader.as_mut()
    }

    /// Goes on after the last fault, of the reader or of the contour. A contour that is broken off
    /// is followed without compensation until it is switched on again.
    pub(crate) fn recover(&mut self) -> bool {
        self.finished = false;
        self.state = CompState::Off;
        // What waited for the end of its block goes out as it is.
        let pending = self.pending.take().map(|pending| pending.command);
        self.out.extend(pending.into_iter().chain(self.held.drain(..)).map(Ok));
        self.exit = None;
        // An incomplete contour is not checked.
        self.stretch = ContourStretch::default();
        self.leaving = None;
        self.heights = None;
        self.residual = [0.0; 2];
        self.position = AxisValues::NONE;
        self.broken = true;
        self.reader.recover()
    }

    /// The fault may follow from one before: after a broken contour the position is unknown until a
    /// motion gives it.
    pub(crate) fn follows(&self, fault: &Diagnostic) -> bool {
        let contour = matches!(fault.code, codes::COMPENSATION | codes::POSITION_UNKNOWN);
        self.reader.follows(fault) || contour && self.broken && self.position.xyz().is_none()
    }
}
