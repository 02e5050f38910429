//! The motion that cut the part, kept to its end for those who ask the swept surface itself.
//!
//! The stock remembers for each point the piece of motion that made it, by a number; here is the piece of a number.

use proveout_stock::SweepMotion;

/// Pieces that are kept at most: some 500 MB.
pub(crate) const MOST_PIECES: usize = 4_000_000;

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
    /// Bound of the deviation of any point of the tool from the motion that it stands for, mm.
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
