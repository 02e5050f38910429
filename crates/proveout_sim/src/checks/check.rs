//! What a check is, and what it sees of a run.

use std::{collections::BTreeMap, sync::Arc};

use proveout_controller::{BlockRecord, Chunk, Piece};
use proveout_geom::Pose;
use proveout_machine::{JointValues, Machine};
use proveout_stock::SweepReport;

use crate::{
    cut::{
        block_sums::BlockSum,
        bodies::{BodyCheck, Checked},
        stock_bodies::StockBodies,
        tool_between_rays::BetweenFacts,
        tool_sweeps::{Cutters, CuttingState, SweepPart},
    },
    prepare::prepared::Prepared,
    verdict::{finding::Finding, log::FindingLog, verdict_file::ToolUse},
};

/// Looks at a run as it goes on, and reports what is wrong to the log. The module above says when each method
/// is called, and in which order the checks run.
pub(crate) trait Check {
    /// A stretch has been cut, and all bodies were followed through it.
    fn stretch(&mut self, _view: &StretchView<'_>, _log: &mut FindingLog) {}

    /// A motion block has ended.
    fn block(&mut self, _end: &BlockEnd<'_>, _log: &mut FindingLog) {}

    /// The run has ended: what is known only now, and what was not decided ([`FindingLog::leave_out`]).
    fn finish(&mut self, _end: &RunEnd<'_>, _log: &mut FindingLog) {}
}

/// One stretch of motion, and what became of it. Lists by piece are as long as `chunk.pieces`.
pub(crate) struct StretchView<'a> {
    /// What holds for the whole run: scene, machine, tools.
    pub(crate) prepared: &'a Prepared,
    pub(crate) work_from_table: &'a Pose,
    /// Motion pieces (poses in the table frame), events, samples of the control, blocks that end.
    pub(crate) chunk: &'a Chunk,
    /// Tool and spindle at each piece.
    pub(crate) states: &'a [CuttingState],
    /// Number in the run of the first piece.
    pub(crate) first_id: u32,
    /// The bodies of all tools that are swept.
    pub(crate) cutters: &'a Cutters,
    /// What was swept, in the order of the pieces.
    pub(crate) parts: &'a [SweepPart],
    /// What each of `parts` met in the stock.
    pub(crate) reports: &'a [SweepReport],
    /// Numbers of the reports that no ray of the stock has met, ascending.
    pub(crate) between_rays: &'a [usize],
    /// By piece: bodies that came too near each other.
    pub(crate) hits: &'a [Checked],
    /// Bodies that came too near the stock: the piece, and the index of the breach in `stock_bodies`.
    pub(crate) stock_breaches: &'a [(usize, usize)],
    pub(crate) stock_bodies: &'a StockBodies,
}

impl StretchView<'_> {
    /// Depth in material that only touches, mm.
    pub(crate) fn contact_mm(&self) -> f64 {
        self.prepared.scene.file.tolerances.contact_mm
    }

    /// Clearance that the scene asks for, mm.
    pub(crate) fn near_miss_mm(&self) -> f64 {
        self.prepared.scene.file.tolerances.near_miss_mm
    }

    /// Joint positions by name, mm or degrees.
    pub(crate) fn axes(&self, q: &JointValues) -> BTreeMap<String, f64> {
        axes(&self.prepared.machine, q)
    }

    /// A finding with the block of a piece, and the joint positions at a time within it.
    pub(crate) fn at_piece(&self, mut f: Finding, piece: &Piece, time: f64) -> Finding {
        (f.block, f.time_s) = (Some(piece.block), Some(time));
        let t =
            if piece.time[1] > piece.time[0] { (time - piece.time[0]) / (piece.time[1] - piece.time[0]) } else { 0.0 };
        f.axes = self.axes(&piece.joints[0].interpolated(piece.joints[1], t));
        f
    }
}

/// A motion block that has ended.
pub(crate) struct BlockEnd<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) block: &'a BlockRecord,
    /// What it removed, with which tool.
    pub(crate) sum: &'a BlockSum,
}

/// The end of the run.
pub(crate) struct RunEnd<'a> {
    pub(crate) prepared: &'a Prepared,
    /// Tools that were used.
    pub(crate) tools: &'a [ToolUse],
    /// File and line of every block.
    pub(crate) places: &'a [Option<(Arc<str>, u32)>],
    pub(crate) bodies: &'a BodyCheck<'a>,
    pub(crate) stock_bodies: &'a StockBodies,
    /// What lies between the rays of the stock.
    pub(crate) between: &'a BetweenFacts,
}

/// Joint positions by name, mm or degrees.
pub(crate) fn axes(machine: &Machine, q: &JointValues) -> BTreeMap<String, f64> {
    let joints = machine.joints.iter().enumerate();
    joints.map(|(i, j)| (j.name.clone(), j.kind.in_unit(q[i]))).collect()
}
