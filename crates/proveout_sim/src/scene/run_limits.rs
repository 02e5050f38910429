//! Where a run ends that would not end by itself.

use proveout_controller::Settings as ControlSettings;
use proveout_nc::Limits;
use schemars::JsonSchema;
use serde::Deserialize;

/// Limits of simulated time and of blocks, for all programs of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunLimitsFile {
    /// Simulated time at which a program is ended with the finding `program-stopped`, s; 360000 (a hundred
    /// hours) when left out.
    pub simulated_time_s: Option<f64>,
    /// Blocks, those of loops and subprograms counted each time, after which a program is refused; ten
    /// million when left out. Loops may jump back a fifth as often.
    #[schemars(range(min = 1))]
    pub blocks: Option<u32>,
}

impl RunLimitsFile {
    /// Simulated time at which a program is ended, s.
    pub(crate) fn max_time(self) -> f64 {
        self.simulated_time_s.unwrap_or(ControlSettings::MAX_TIME)
    }

    /// What the reader keeps to, where its control says `usual`.
    pub(crate) fn of_reader(self, usual: Limits) -> Limits {
        match self.blocks.map(u64::from) {
            None => usual,
            Some(blocks) => Limits {
                max_blocks: blocks,
                max_loop_passes: (blocks / 5).max(1),
                max_idle_passes: usual.max_idle_passes.min((blocks / 5).max(1)),
                ..usual
            },
        }
    }
}
