//! What a block removes, and how its cutter is engaged: sums over its pieces of motion.

use std::collections::BTreeMap;

use proveout_controller::{Chunk, MoveKind};
use proveout_stock::SweepReport;
use proveout_tool::{Role, Tool};

use crate::{
    checks::engagement::Engagement,
    cut::tool_sweeps::{CuttingState, SweepPart, Swept},
};

/// Sums over the pieces of a block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlockSum {
    /// Removed, mm³.
    pub(crate) volume: f64,
    /// Longest way of a ray through material, mm.
    pub(crate) overlap: f64,
    pub(crate) engagement: Option<Engagement>,
    /// Place in the library of the tool of its last piece.
    pub(crate) tool: Option<usize>,
    /// Speed of the spindle at its last cut in feed, 1/min.
    pub(crate) cut_rpm: f64,
}

/// The blocks that have begun and not ended.
#[derive(Debug, Default)]
pub(crate) struct BlockSums(BTreeMap<u32, BlockSum>);

impl BlockSums {
    /// Adds what the cutter did in a stretch; gives the removed volume of every piece, mm³. `share` is the
    /// factor from what the sweeps report to what they took, `contact` the depth that only touches, mm.
    pub(crate) fn add(
        &mut self,
        (chunk, states): (&Chunk, &[CuttingState]),
        tools: &[Tool],
        (parts, reports): (&[SweepPart], &[SweepReport]),
        [share, contact]: [f64; 2],
    ) -> Vec<f64> {
        let mut volumes = vec![0.0; chunk.pieces.len()];
        for (part, report) in parts.iter().zip(reports) {
            if part.what != Swept::Body(Role::Cutting) {
                continue;
            }
            let (piece, state) = (&chunk.pieces[part.piece], &states[part.piece]);
            let Some(tool) = state.tool.and_then(|t| tools.get(t)) else { continue };
            let volume = share * report.volume_mm3;
            volumes[part.piece] += volume;
            let sum = self.0.entry(piece.block).or_default();
            sum.volume += volume;
            sum.overlap = sum.overlap.max(report.overlap_mm);
            if report.overlap_mm <= contact {
                continue;
            }
            if piece.kind == MoveKind::Feed {
                sum.cut_rpm = state.speed_rpm;
            }
            if let Some(contact) = report.contact {
                let engaged = Engagement::of_piece(&contact, piece, state, tool);
                sum.engagement = Some(sum.engagement.map_or(engaged, |e| e.union(&engaged)));
            }
        }
        for (piece, state) in chunk.pieces.iter().zip(states) {
            self.0.entry(piece.block).or_default().tool = state.tool;
        }
        volumes
    }

    /// The sums of a block that has ended.
    pub(crate) fn take(&mut self, block: u32) -> BlockSum {
        self.0.remove(&block).unwrap_or_default()
    }
}
