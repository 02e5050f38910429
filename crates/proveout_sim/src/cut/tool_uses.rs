//! Which tool is in the spindle, and what each tool of the program did.

use std::collections::BTreeMap;

use proveout_controller::{BlockRecord, Chunk, Event, MoveKind};

use crate::{
    cut::tool_sweeps::{CuttingState, states_of_pieces},
    prepare::prepared::Prepared,
    verdict::verdict_file::ToolUse,
};

/// Follows the events of a run.
#[derive(Debug)]
pub(crate) struct ToolUses {
    /// Tool and spindle after the last stretch.
    state: CuttingState,
    /// By place in the library: the order of first use, and the sums.
    uses: BTreeMap<usize, (usize, ToolUse)>,
    in_spindle_since: f64,
    ended: bool,
}

impl ToolUses {
    pub(crate) fn new() -> Self {
        Self { state: CuttingState::IDLE, uses: BTreeMap::new(), in_spindle_since: 0.0, ended: false }
    }

    /// Tool and spindle at each piece of a stretch.
    pub(crate) fn states_of_pieces(&mut self, prepared: &Prepared, chunk: &Chunk) -> Vec<CuttingState> {
        let mut state = self.state;
        let states = states_of_pieces(chunk, &mut state, |event| self.apply(prepared, event));
        debug_assert_eq!(state, self.state);
        states
    }

    fn apply(&mut self, prepared: &Prepared, event: &Event) {
        match *event {
            Event::ToolChange { time, tool, .. } => {
                self.tool_out(time);
                if let Some(t) = tool.and_then(|i| prepared.tools.tools.get(i)) {
                    let order = self.uses.len();
                    let least = prepared.least_overhang_mm.get(&t.name).copied();
                    let fresh = || {
                        let name = t.name.clone();
                        (order, ToolUse { number: t.number, name, min_overhang_mm: least, ..ToolUse::default() })
                    };
                    self.uses.entry(tool.unwrap_or_default()).or_insert_with(fresh);
                }
            }
            // A program that the control ends has its finding.
            Event::End { .. } | Event::Ended { .. } => self.ended = true,
            _ => {}
        }
        self.state.apply(event);
    }

    /// Books the time of the tool in the spindle until now.
    fn tool_out(&mut self, now: f64) {
        if let Some((_, used)) = self.state.tool.and_then(|t| self.uses.get_mut(&t)) {
            used.time_s += now - self.in_spindle_since;
        }
        self.in_spindle_since = now;
    }

    /// Books a block that has ended on its tool; `volume` is what it removed, mm³.
    pub(crate) fn book_block(&mut self, tool: Option<usize>, block: &BlockRecord, kind: MoveKind, volume: f64) {
        if let Some((_, used)) = tool.and_then(|t| self.uses.get_mut(&t)) {
            used.volume_mm3 += volume;
            if kind == MoveKind::Feed {
                used.cut_time_s += block.end_time - block.start_time;
                used.length_mm += block.length;
            }
        }
    }

    /// The program has reached its end (M2, M30), or the control has ended it.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }

    /// The tools in order of first use; the run ends `now`.
    pub(crate) fn finish(&mut self, now: f64) -> Vec<ToolUse> {
        self.tool_out(now);
        let mut uses: Vec<(usize, ToolUse)> = std::mem::take(&mut self.uses).into_values().collect();
        uses.sort_by_key(|(order, _)| *order);
        uses.into_iter().map(|(_, u)| u).collect()
    }
}
