//! Where a run has its cuts from, when it does not simply make them.

use proveout_stock::{Measure, SweepItem, SweepReport};

use crate::{
    cut::{cutting::Cutting, journal::Journal, shard_cuts::ShardCuts},
    prepare::error::SimError,
};

/// Written down, or taken from what was written.
#[derive(Debug)]
pub(crate) enum Cuts {
    /// Written as they are made, and taken from there by a run that goes on.
    Journal(Journal),
    /// Made before by shards.
    Shards(ShardCuts),
}

impl Cuts {
    /// Cuts, or takes what is known of it.
    pub(crate) fn sweep(
        &mut self,
        cutting: &mut Cutting<'_>,
        items: &[SweepItem<'_>],
        measures: &[Measure],
    ) -> Vec<SweepReport> {
        match self {
            Self::Journal(journal) => journal.sweep(cutting, items, measures),
            Self::Shards(shards) => shards.sweep(cutting, items, measures),
        }
    }

    /// What was found wrong; the result of the run is then none.
    pub(crate) fn take_fault(&mut self) -> Option<SimError> {
        match self {
            Self::Journal(journal) => journal.take_fault().map(SimError::from),
            Self::Shards(shards) => shards.take_fault().map(SimError::from),
        }
    }

    /// The stock was changed by something else than sweeps: shards do not know of it.
    pub(crate) fn stock_was_changed(&mut self) {
        if let Self::Shards(shards) = self {
            shards.leave();
        }
    }

    /// Why the journal was given up, where it was.
    pub(crate) fn journal_given_up(&self) -> Option<String> {
        match self {
            Self::Journal(journal) => journal.given_up(),
            Self::Shards(_) => None,
        }
    }

    /// The shards, where these are theirs.
    pub(crate) fn shards(&self) -> Option<&ShardCuts> {
        match self {
            Self::Journal(_) => None,
            Self::Shards(shards) => Some(shards),
        }
    }
}
