//! The path of the tool center for commands that stay as programmed, where the program itself gives
//! the radius.
//!
//! Without a tool table ([`crate::settings::Compensation::Programmed`]) motions are emitted as they
//! are written. A radius in the program (`G41.1 D`, a tool offset that it writes) is known all the
//! same, and what the control refuses about such a contour is refused.

use super::{CompensatedReader, Fault};
use crate::dialect::Reader;
use crate::settings::{Compensation, Dialect, Settings, ToolRadii};
use crate::{Command, CompSide, Op};

/// Nothing to read: the commands come from outside.
#[derive(Debug)]
struct NoReader;

impl Reader for NoReader {
    fn next_command(&mut self) -> Option<Result<Command, Fault>> {
        None
    }
}

/// Follows the commands of a program and looks at its contours.
#[derive(Debug)]
pub(super) struct Shadow(CompensatedReader);

impl Shadow {
    pub(super) fn new(dialect: Dialect, settings: &Settings) -> Self {
        let settings = Settings { compensation: Compensation::ToolCenter(ToolRadii::default()), ..settings.clone() };
        Self(CompensatedReader::new(Box::new(NoReader), dialect, false, &settings))
    }

    /// A command of the program, in its order.
    pub(super) fn follow(&mut self, command: &Command) -> Result<(), Fault> {
        let unknown =
            matches!(&command.op, Op::CutterComp(comp) if comp.side != CompSide::Off && comp.radius.is_none());
        if unknown {
            // The radius comes from the tool table, and there is none here.
            return Ok(());
        }
        let entering = self.0.pending.as_ref().is_some_and(|pending| pending.entry);
        let found = self.0.take(command.clone());
        self.0.out.clear();
        // The stage cannot compute a contour that ends after its entry, but the control runs it.
        if entering && matches!(&command.op, Op::CutterComp(comp) if comp.side == CompSide::Off) {
            if found.is_err() {
                self.0.recover();
            }
            return Ok(());
        }
        found
    }

    /// The program is at its end.
    pub(super) fn end(&mut self) -> Result<(), Fault> {
        let found = self.0.settle(None).map(|_| ());
        self.0.out.clear();
        found
    }
}

/// The text switches on a compensation whose radius the program can give: G41 or G42 of an ISO
/// control.
pub(crate) fn may_compensate(text: &str) -> bool {
    text.as_bytes().windows(3).any(|w| matches!(w[0], b'G' | b'g') && w[1] == b'4' && matches!(w[2], b'1' | b'2'))
}
