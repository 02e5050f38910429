//! Motion in feed with an empty spindle ([`NO_TOOL`], gate `process`).
//!
//! A block that does not move the tip is no motion.

use proveout_controller::MoveKind;

use crate::{
    checks::check::{Check, StretchView},
    verdict::{finding::NO_TOOL, log::FindingLog},
};

/// See the module.
#[derive(Debug)]
pub(crate) struct NoTool;

impl Check for NoTool {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        for (piece, state) in view.chunk.pieces.iter().zip(view.states) {
            let moved = (piece.pose[1].tip - piece.pose[0].tip).norm() > 0.0;
            if state.tool.is_none() && piece.kind == MoveKind::Feed && moved {
                let finding = FindingLog::of(&NO_TOOL, "feed motion with an empty spindle".into());
                log.push(view.at_piece(finding, piece, piece.time[0]));
            }
        }
    }
}
