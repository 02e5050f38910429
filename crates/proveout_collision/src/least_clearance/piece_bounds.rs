//! What the check of the motion has found of single pieces, for the search that asks the same of stretches.
//!
//! A tool that slides along a wall is asked about in nearly every piece by the check, by the hull of its way
//! through the piece. The search would halve its stretches down to the same pieces and ask the same once
//! more. So the answers are kept, and a stretch whose pieces all have one that is good enough is done without
//! a look.

use super::piece_tree::PieceTree;
use super::search::StretchBound;

/// Distance of a pair that the check has found on the whole of a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PieceRecord {
    /// Index among the pairs that are checked.
    pub(crate) pair: usize,
    /// Index among the pieces that are kept.
    pub(crate) piece: usize,
    /// Proved of the hull of both ends, or of the parabolas, mm.
    pub(crate) distance: f64,
    pub(crate) curved: bool,
}

/// Bounds of single pieces, and how many there are and the least of them below each node of the way.
#[derive(Debug, Default)]
pub(crate) struct PieceBounds {
    /// By leaf; empty where nothing was noted.
    bounds: Vec<Option<StretchBound>>,
    nodes: Vec<(u32, f64)>,
    first_leaf: usize,
}

impl PieceBounds {
    pub(crate) fn new(way: &PieceTree, noted: impl Iterator<Item = (usize, StretchBound)>) -> Self {
        let mut noted = noted.peekable();
        if noted.peek().is_none() {
            return Self::default();
        }
        let first_leaf = way.leaf(0);
        let mut bounds: Vec<Option<StretchBound>> = vec![None; way.nodes() - first_leaf];
        let mut nodes = vec![(0, f64::INFINITY); way.nodes()];
        for (piece, bound) in noted {
            bounds[piece] = Some(bound.or(bounds[piece].unwrap_or(bound)));
        }
        for (piece, bound) in bounds.iter().enumerate() {
            if let Some(bound) = bound {
                nodes[first_leaf + piece] = (1, bound.reached());
            }
        }
        for n in (1..first_leaf).rev() {
            let (x, y) = (nodes[2 * n], nodes[2 * n + 1]);
            nodes[n] = (x.0 + y.0, x.1.min(y.1));
        }
        Self { bounds, nodes, first_leaf }
    }

    /// The piece of which least was proved, by its node.
    pub(crate) fn worst(&self) -> Option<usize> {
        let mut at = self.nodes.get(1).filter(|n| n.0 > 0).map(|_| 1)?;
        while at < self.first_leaf {
            let (x, y) = (self.nodes[2 * at], self.nodes[2 * at + 1]);
            at = 2 * at + usize::from(y.1 < x.1);
        }
        Some(at)
    }

    /// Number of pieces of a node of which something is noted, and the least bound of them, as
    /// [`StretchBound::reached`].
    pub(crate) fn below(&self, node: usize) -> (usize, f64) {
        self.nodes.get(node).map_or((0, f64::INFINITY), |n| (n.0 as usize, n.1))
    }

    /// Bound of a piece, by its node.
    pub(crate) fn bound(&self, node: usize) -> Option<StretchBound> {
        node.checked_sub(self.first_leaf).and_then(|piece| self.bounds.get(piece).copied().flatten())
    }
}
