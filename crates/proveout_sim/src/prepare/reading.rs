//! A reading of a program: how the operator's switches for `/` blocks and M1 are set.

use proveout_nc::{OptionalStop, Settings};

use crate::scene::{ProgramFile, SwitchFile};

/// All levels of `/`.
const ALL_LEVELS: u16 = 0x3ff;

/// How the switches are set; none where not stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Blocks with `/` are left out.
    pub skip: Option<bool>,
    /// M1 stops.
    pub stop: Option<bool>,
}

impl Reading {
    /// Sets the switches of a reader.
    pub(crate) fn apply(self, settings: &mut Settings) {
        if let Some(skip) = self.skip {
            (settings.skip_stated, settings.skipped_levels) = (true, if skip { ALL_LEVELS } else { 0 });
        }
        if let Some(stop) = self.stop {
            settings.optional_stop = if stop { OptionalStop::On } else { OptionalStop::Off };
        }
    }

    pub(crate) fn words(self) -> String {
        let skip = self.skip.map(|s| if s { "without the `/` blocks" } else { "with the `/` blocks" });
        let stop = self.stop.map(|s| if s { "with M1 as a stop" } else { "without a stop at M1" });
        skip.into_iter().chain(stop).collect::<Vec<_>>().join(" and ")
    }
}

/// The readings that a scene wants of a program, the one of the run first.
pub(crate) fn of(entry: Option<&ProgramFile>) -> Vec<Reading> {
    let set = |switch: Option<SwitchFile>| match switch {
        None => vec![None],
        Some(SwitchFile::On) => vec![Some(true)],
        Some(SwitchFile::Off) => vec![Some(false)],
        Some(SwitchFile::Both) => vec![Some(false), Some(true)],
    };
    let (skips, stops) = (set(entry.and_then(|e| e.block_skip)), set(entry.and_then(|e| e.optional_stop)));
    skips.iter().flat_map(|skip| stops.iter().map(|stop| Reading { skip: *skip, stop: *stop })).collect()
}
