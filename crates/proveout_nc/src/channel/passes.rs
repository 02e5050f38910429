//! Counts how often a program jumps back, so that no loop runs for ever.

use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::settings::Limits;

/// Jumps back so far. A pass is idle where no motion was emitted since the last jump.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passes {
    total: u64,
    idle: u64,
}

impl Passes {
    /// A motion was emitted.
    pub(crate) fn moved(&mut self) {
        self.idle = 0;
    }

    /// Counts a jump back and refuses one too many.
    pub(crate) fn count(&mut self, limits: &Limits, span: Span) -> Result<(), Fault> {
        self.total += 1;
        self.idle += 1;
        if self.total > limits.max_loop_passes {
            let message = format!("the program has jumped back {} times, which is the limit", limits.max_loop_passes);
            return Err(Fault::new(codes::LOOP_LIMIT, span, message).help(
                "check the conditions of the loops: can this one end? Otherwise split the program, or raise \
                 limits.passes in a control file",
            ));
        }
        if self.idle > limits.max_idle_passes {
            let message = format!("the loop has run {} times without a motion", limits.max_idle_passes);
            return Err(Fault::new(codes::LOOP_LIMIT, span, message)
                .help("check the condition of the loop: is its variable changed inside? a control file may raise limits.idle_passes"));
        }
        Ok(())
    }
}
