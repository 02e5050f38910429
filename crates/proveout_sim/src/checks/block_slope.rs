//! The slope of a block as it is programmed: corners of the path that the control rounds are no part of it.

use proveout_controller::{BlockKind, BlockRecord, Chunk};
use proveout_geom::ToolPose;

use crate::checks::descent::way_down;

/// Tool axes at both ends of a block nearer than this (sine of their angle) are the same.
const UPRIGHT: f64 = 1e-9;
/// Way by which a block may be shorter than the straight line between its ends, mm: rounding.
const ROUNDING: f64 = 1e-6;

/// Where the blocks that have ended lead to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlockEnds {
    /// Of the last block with a motion in the stretches before: its number, and the tool in the table frame.
    last: Option<ToolPose>,
}

impl BlockEnds {
    /// Takes note of the blocks of a stretch that was judged.
    pub(crate) fn keep(&mut self, chunk: &Chunk) {
        let ends = chunk.blocks.iter().rev().find_map(|b| b.programmed_end);
        self.last = ends.map(|(_, pose)| pose).or(self.last);
    }

    /// Whether a block ends in the stretch, so that its slope is known.
    pub(crate) fn has_ended(chunk: &Chunk, block: u32) -> bool {
        chunk.blocks.binary_search_by_key(&block, |b| b.index).is_ok()
    }

    /// Angle of a block of the stretch against the plane across the tool axis, radian; none where the block
    /// has not ended, turns the tool, or is no motion in feed.
    pub(crate) fn slope(&self, chunk: &Chunk, block: u32) -> Option<f64> {
        let at = chunk.blocks.partition_point(|b| b.index < block);
        let (before, rest) = chunk.blocks.split_at(at);
        let record: &BlockRecord = rest.first().filter(|b| b.index == block)?;
        if !matches!(record.kind, BlockKind::Move(_)) {
            return None;
        }
        let end = record.programmed_end?.1;
        let start = before.iter().rev().find_map(|b| b.programmed_end).map(|(_, pose)| pose).or(self.last)?;
        if start.axis.cross(&end.axis).norm() > UPRIGHT {
            return None;
        }
        let (down, aside) = way_down(&[start, end]);
        let length = record.programmed_length;
        // A table that turns under the tool makes another way than the axes.
        if length + ROUNDING < down.hypot(aside) {
            return None;
        }
        Some(down.atan2((length * length - down * down).max(0.0).sqrt()))
    }
}
