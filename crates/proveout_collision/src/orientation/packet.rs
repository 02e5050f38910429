//! Sixteen cells of axes at once against a spot (`spots.rs`): the same operation for each, so that the compiler makes vector instructions of
//! it where the processor has them (`pulp` chooses at run time). Nothing is summed across cells or fused: the same bits everywhere.
//!
//! Angles are compared by their cosines, in single precision. A unit vector has three numbers off by half a unit of the last place each, which is
//! 6e-8, and so have cosines and sines; with the roundings of the products a comparison is off by 9e-7 at most. [`SLACK`] is what it
//! must hold by.

use proveout_geom::Vector;

use super::spots::{Anchor, Spot, Turn};

/// Cells of a packet.
pub(super) const LANES: usize = 16;
/// By so much the cosines must differ for a proof.
const SLACK: f32 = 2e-6;
/// Where the sum of two angles comes this near to half a turn (its sine), its cosine tells too little: it counts as half a turn.
const NEAR_HALF_TURN: f32 = 1e-3;

type Row = [f32; LANES];
/// A bit for each cell.
pub(super) type Cells = u32;

/// The axes of up to sixteen cells: the center of each and how far others are from it.
#[derive(Clone, Copy)]
pub(super) struct Packet {
    axis: [Row; 3],
    turn: [Row; 2],
    /// One bit for each cell that there is.
    pub(super) cells: Cells,
    /// A direction amid all, of any length.
    pub(super) middle: Vector,
}

/// What a spot says of the cells of a packet that it may forbid an axis of.
pub(super) struct Said {
    /// It forbids none.
    pub(super) apart: Cells,
    /// It forbids all.
    pub(super) blocked: Cells,
    /// A point of the skin is not known to be apart, so that no smaller part of it will show the cell to be free.
    pub(super) met: Cells,
}

impl Packet {
    /// Centers and angles of up to sixteen cells.
    pub(super) fn new(around: impl Iterator<Item = (Vector, Turn)>) -> Self {
        let mut packet =
            Self { axis: [[0.0; LANES]; 3], turn: [[1.0; LANES], [0.0; LANES]], cells: 0, middle: Vector::zeros() };
        for (lane, (axis, turn)) in around.take(LANES).enumerate() {
            for i in 0..3 {
                packet.axis[i][lane] = axis[i] as f32;
            }
            for (row, part) in packet.turn.iter_mut().zip(turn) {
                row[lane] = part as f32;
            }
            packet.cells |= 1 << lane;
            packet.middle += axis;
        }
        packet
    }

    /// Cosines of the angles between a direction and the centers.
    #[inline(always)]
    fn near(&self, way: &[f32; 3]) -> Row {
        let mut near = [0.0; LANES];
        for l in 0..LANES {
            near[l] = way[0] * self.axis[0][l] + way[1] * self.axis[1][l] + way[2] * self.axis[2][l];
        }
        near
    }

    /// Cosines of the sums of an angle and those of the cells; below every cosine where it is half a turn or more.
    #[inline(always)]
    fn wider(&self, [c, s]: [f32; 2]) -> Row {
        let mut wider = [0.0; LANES];
        for l in 0..LANES {
            let (co, so) = (self.turn[0][l], self.turn[1][l]);
            let (cosine, sine) = (c * co - s * so, s * co + c * so);
            let least = if cosine < 0.0 { NEAR_HALF_TURN } else { 0.0 };
            wider[l] = if sine > least { cosine } else { -3.0 };
        }
        wider
    }

    /// Cosines of an angle less those of the cells; above every cosine where it is the smaller one.
    #[inline(always)]
    fn narrower(&self, [c, s]: [f32; 2]) -> Row {
        let mut narrower = [0.0; LANES];
        for l in 0..LANES {
            let (co, so) = (self.turn[0][l], self.turn[1][l]);
            narrower[l] = if s * co - c * so > 0.0 { c * co + s * so } else { 3.0 };
        }
        narrower
    }

    /// Cells of which a spot may forbid an axis, by what it forbids at most.
    #[inline(always)]
    pub(super) fn reached(&self, spot: &Spot) -> Cells {
        let (near, wider) = (self.near(&spot.way), self.wider(spot.high));
        self.cells & !below(&near, &wider)
    }

    /// What the anchor of a spot says.
    #[inline(always)]
    pub(super) fn ask(&self, spot: &Spot, anchor: &Anchor) -> Said {
        let mut said = Said { apart: 0, blocked: 0, met: 0 };
        if let Some(low) = anchor.low {
            said.apart = below(&self.narrower(low), &self.near(&spot.way));
        }
        let at = self.near(&anchor.way);
        if let Some([low, high]) = anchor.inner {
            let from_below = if low[0] >= 1.0 { Cells::MAX } else { below(&at, &self.wider(low)) };
            said.blocked = from_below & below(&self.narrower(high), &at);
        }
        if let Some([low, high]) = anchor.reach {
            let from_below = if low[0] >= 1.0 { Cells::MAX } else { below(&at, &self.narrower(low)) };
            said.met = from_below & below(&self.wider(high), &at);
        }
        said
    }
}

/// Where one number is below another by more than the slack.
#[inline(always)]
fn below(a: &Row, b: &Row) -> Cells {
    let mut cells = 0;
    for l in 0..LANES {
        cells |= Cells::from(a[l] < b[l] - SLACK) << l;
    }
    cells
}
