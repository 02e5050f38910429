//! Sixteen cells of axes at once against a spot (`obstacle_spots.rs`): the same operation for each, in the
//! vector instructions that the processor has (`pulp` chooses at run time). Nothing is rounded across cells
//! or fused: the same bits everywhere.
//!
//! Angles are compared by their cosines, in single precision. A unit vector has three numbers off by half a
//! unit of the last place each, which is 6e-8, and so have cosines and sines; with the roundings of the
//! products a comparison is off by 9e-7 at most. [`SLACK`] is what it must hold by.

use proveout_geom::Vector;
use pulp::Simd;

use super::obstacle_spots::{Anchor, ObstacleSpot, Turn};

/// Cells of a packet.
pub(super) const LANES: usize = 16;
/// By so much the cosines must differ for a proof.
const SLACK: f32 = 2e-6;
/// Where the sum of two angles comes this near to half a turn (its sine), its cosine is too
/// imprecise: it counts as half a turn.
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
pub(super) struct SpotAnswer {
    /// It forbids none.
    pub(super) apart: Cells,
    /// It forbids all.
    pub(super) blocked: Cells,
    /// A point of the skin is not known to be apart, so that no smaller part of it will show the cell to be
    /// free.
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

    /// Cells of which a spot may forbid an axis, by what it forbids at most.
    #[inline(always)]
    pub(super) fn reached<S: Simd>(&self, simd: S, spot: &ObstacleSpot) -> Cells {
        let mut apart = 0;
        for part in 0..LANES / S::F32_LANES {
            let rows = Rows::of(simd, self, part);
            apart |= rows.bits(rows.below(rows.near(&spot.way), rows.wider(spot.high)));
        }
        self.cells & !apart
    }

    /// What the anchor of a spot says.
    #[inline(always)]
    pub(super) fn anchor_answer<S: Simd>(&self, simd: S, spot: &ObstacleSpot, anchor: &Anchor) -> SpotAnswer {
        let mut said = SpotAnswer { apart: 0, blocked: 0, met: 0 };
        for part in 0..LANES / S::F32_LANES {
            let rows = Rows::of(simd, self, part);
            if let Some(low) = anchor.low {
                said.apart |= rows.bits(rows.below(rows.narrower(low), rows.near(&spot.way)));
            }
            let at = rows.near(&anchor.way);
            if let Some([low, high]) = anchor.inner {
                let mut blocked = rows.below(rows.narrower(high), at);
                if low[0] < 1.0 {
                    blocked = simd.and_m32s(blocked, rows.below(at, rows.wider(low)));
                }
                said.blocked |= rows.bits(blocked);
            }
            if let Some([low, high]) = anchor.reach {
                let mut met = rows.below(rows.wider(high), at);
                if low[0] < 1.0 {
                    met = simd.and_m32s(met, rows.below(at, rows.narrower(low)));
                }
                said.met |= rows.bits(met);
            }
        }
        said
    }
}

/// The bits of the cells.
const BITS: Row = {
    let mut bits = [1.0; LANES];
    let mut lane = 1;
    while lane < LANES {
        bits[lane] = 2.0 * bits[lane - 1];
        lane += 1;
    }
    bits
};

/// As many cells of a packet as one vector of the processor has numbers.
#[derive(Clone, Copy)]
struct Rows<S: Simd> {
    simd: S,
    axis: [S::f32s; 3],
    turn: [S::f32s; 2],
    bits: S::f32s,
}

impl<S: Simd> Rows<S> {
    #[inline(always)]
    fn of(simd: S, packet: &Packet, part: usize) -> Self {
        let [x, y, z] = &packet.axis;
        let [c, s] = &packet.turn;
        let axis = [S::as_simd_f32s(x).0[part], S::as_simd_f32s(y).0[part], S::as_simd_f32s(z).0[part]];
        let turn = [S::as_simd_f32s(c).0[part], S::as_simd_f32s(s).0[part]];
        Self { simd, axis, turn, bits: S::as_simd_f32s(&BITS).0[part] }
    }

    /// Cosines of the angles between a direction and the centers.
    #[inline(always)]
    fn near(&self, way: &[f32; 3]) -> S::f32s {
        let s = self.simd;
        let x = s.mul_f32s(s.splat_f32s(way[0]), self.axis[0]);
        let y = s.mul_f32s(s.splat_f32s(way[1]), self.axis[1]);
        let z = s.mul_f32s(s.splat_f32s(way[2]), self.axis[2]);
        s.add_f32s(s.add_f32s(x, y), z)
    }

    /// Cosines of the sums of an angle and those of the cells; below every cosine where it is half a turn or
    /// more.
    #[inline(always)]
    fn wider(&self, [c, s]: [f32; 2]) -> S::f32s {
        let (simd, [co, so]) = (self.simd, self.turn);
        let (c, s) = (simd.splat_f32s(c), simd.splat_f32s(s));
        let cosine = simd.sub_f32s(simd.mul_f32s(c, co), simd.mul_f32s(s, so));
        let sine = simd.add_f32s(simd.mul_f32s(s, co), simd.mul_f32s(c, so));
        let zero = simd.splat_f32s(0.0);
        let is_obtuse = simd.less_than_f32s(cosine, zero);
        let least = simd.select_f32s(is_obtuse, simd.splat_f32s(NEAR_HALF_TURN), zero);
        simd.select_f32s(simd.less_than_f32s(least, sine), cosine, simd.splat_f32s(-3.0))
    }

    /// Cosines of an angle less those of the cells; above every cosine where it is the smaller one.
    #[inline(always)]
    fn narrower(&self, [c, s]: [f32; 2]) -> S::f32s {
        let (simd, [co, so]) = (self.simd, self.turn);
        let (c, s) = (simd.splat_f32s(c), simd.splat_f32s(s));
        let sine = simd.sub_f32s(simd.mul_f32s(s, co), simd.mul_f32s(c, so));
        let cosine = simd.add_f32s(simd.mul_f32s(c, co), simd.mul_f32s(s, so));
        simd.select_f32s(simd.less_than_f32s(simd.splat_f32s(0.0), sine), cosine, simd.splat_f32s(3.0))
    }

    /// Where one number is below another by more than the slack.
    #[inline(always)]
    fn below(&self, a: S::f32s, b: S::f32s) -> S::m32s {
        self.simd.less_than_f32s(a, self.simd.sub_f32s(b, self.simd.splat_f32s(SLACK)))
    }

    /// A bit for each cell where a condition holds: a sum of different powers of two below 2^24 is exact in
    /// any order.
    #[inline(always)]
    fn bits(&self, m: S::m32s) -> Cells {
        let s = self.simd;
        s.reduce_sum_f32s(s.select_f32s(m, self.bits, s.splat_f32s(0.0))) as Cells
    }
}
