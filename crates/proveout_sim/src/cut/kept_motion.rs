//! The motion that cut the part, kept to its end for those who ask the swept surface itself.
//!
//! The stock remembers for each point the piece of motion that made it, by a number; here is the piece of a
//! number.

use crate::prepare::memory::MOST_PIECES;
use proveout_stock::SweepMotion;
use proveout_surface::topography::{PathPiece, SweptPath};
use proveout_tool::{Profile, ToolLibrary};

/// One piece of motion in the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeptPiece {
    /// Begin and end, s.
    pub(crate) time: [f64; 2],
    /// Tip and axis at both ends.
    pub(crate) motion: SweepMotion,
    /// Tool in the library; `u32::MAX` for none.
    pub(crate) tool: u32,
    /// In feed; else at rapid rate.
    pub(crate) feed: bool,
    /// Bound of the deviation of any point of the tool from the motion that it approximates, mm.
    pub(crate) deviation: f32,
}

/// All pieces of a run, by the number that the stock knows them under.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeptMotion {
    pieces: Vec<KeptPiece>,
    lost: bool,
}

impl KeptMotion {
    /// Takes the next piece.
    pub(crate) fn push(&mut self, piece: KeptPiece) {
        if self.pieces.len() < MOST_PIECES {
            self.pieces.push(piece);
        } else {
            self.lost = true;
        }
    }

    /// The pieces; none when there were too many to keep.
    pub(crate) fn pieces(&self) -> Option<&[KeptPiece]> {
        (!self.lost).then_some(&self.pieces)
    }
}

/// All motion as the surface that it swept.
pub(crate) struct Swept {
    pub(crate) path: SweptPath,
    /// The cutting bodies of each tool.
    pub(crate) cutters: Vec<Vec<Profile>>,
}

impl Swept {
    /// The motion of a run with its tools.
    pub(crate) fn new(pieces: &[KeptPiece], tools: &ToolLibrary) -> Self {
        let cutters: Vec<Vec<Profile>> =
            tools.tools.iter().map(|t| t.cutting().map(|b| b.profile.clone()).collect()).collect();
        let of = |p: &KeptPiece| PathPiece {
            from: p.motion.from,
            to: p.motion.to,
            cutter: Some(p.tool).filter(|t| (*t as usize) < cutters.len()),
        };
        Self { path: SweptPath::new(pieces.iter().map(of).collect(), &cutters), cutters }
    }
}
