//! Blocks of rays that a moving body cannot meet, by a half space for each.

use pulp::{Simd, WithSimd};

use crate::{
    kernels::lane_bits::ROW,
    kernels::lane_sample::{LaneMotion, LaneRays, clearance, sample},
    kernels::lane_set::{BLOCKS, Lanes},
    kernels::lanes::{L, along, cross, dot, load, store, width},
    kernels::meridian::Meridian,
    kernels::sweep_step::SweepStep,
};

/// Where the blocks of a tile lie: centers, and half of what lies between the rays of a block along u and v,
/// mm.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockCenters {
    pub u: [f64; BLOCKS],
    pub v: [f64; BLOCKS],
    pub half: [f64; 2],
}

impl BlockCenters {
    /// Of the columns and rows of a tile.
    pub(crate) fn new(u: &[f64; ROW], v: &[f64]) -> Self {
        let middle = |x: &[f64], k: usize| 0.5 * (x[2 * k] + x[2 * k + 1]);
        Self {
            u: std::array::from_fn(|b| middle(u, b % (ROW / 2))),
            v: std::array::from_fn(|b| middle(v, b / (ROW / 2))),
            half: [0.5 * (u[1] - u[0]).abs(), 0.5 * (v[1] - v[0]).abs()],
        }
    }
}

/// Rays of the blocks whose bits are set, one bit each.
#[inline]
pub(crate) fn rays_of(blocks: u16) -> u64 {
    let mut rays = 0;
    for pair in 0..ROW / 2 {
        // Four bits to eight, each twice.
        let x = u64::from(blocks >> (4 * pair)) & 0xF;
        let x = (x | x << 2) & 0x33;
        let x = (x | x << 1) & 0x55;
        let row = x | x << 1;
        rays |= (row | row << ROW) << (2 * ROW * pair);
    }
    rays
}

/// Blocks of a tile that a body may meet on one step: a bit each.
///
/// The half space is tangent to the body at mid-time, next to the point of the block's material
/// that is nearest to the body, judged by its axis. F is convex with a unit gradient, so the half
/// space holds the body at mid-time. At other times the body leaves it by at most half of its way
/// along the normal, the bend of the way, and what the turn of the normal makes at the far end of
/// the block.
pub(crate) struct BodyOnBlocks<'a> {
    pub step: &'a SweepStep,
    pub body: &'a Meridian,
    pub places: &'a BlockCenters,
    /// Material of each block, mm; lo > hi: none.
    pub lo: &'a [f64; BLOCKS],
    pub hi: &'a [f64; BLOCKS],
}

impl WithSimd for BodyOnBlocks<'_> {
    type Output = u16;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u16 {
        if self.step.piece.turns() { blocks::<S, true>(simd, self) } else { blocks::<S, false>(simd, self) }
    }
}

#[inline(always)]
fn blocks<S: Simd, const TURNS: bool>(simd: S, call: BodyOnBlocks<'_>) -> u16 {
    let BodyOnBlocks { step, body, places, lo, hi } = call;
    let piece = &step.piece;
    let motion = LaneMotion::new(simd, piece, body);
    let zero = L::splat(simd, 0.0);
    let half = zero.same(0.5);
    let (tip, axis) = (L::splat3(simd, piece.tip_at(0.5)), L::splat3(simd, piece.axis_at(0.5)));
    let (half_u, half_v) = (zero.same(places.half[0]), zero.same(places.half[1]));
    let bend = if TURNS { piece.bend(body.reach) / 8.0 } else { 0.0 };
    let eighth_angle2 = zero.same(piece.angle2 / 8.0);
    let mut met = [0.0; BLOCKS];
    for g in 0..BLOCKS / width::<S>() {
        let (lo, hi) = (load(simd, lo, g).max(zero.same(step.low[0])), load(simd, hi, g).min(zero.same(step.high[0])));
        let held = lo.lt(hi);
        if !held.any() {
            continue;
        }
        let ray = LaneRays { u: load(simd, &places.u, g), v: load(simd, &places.v, g), lo, hi };
        let x = [half * (lo + hi) - tip[0], ray.u - tip[1], ray.v - tip[2]];
        let z = dot(x, axis).max(zero.same(body.rest_z)).min(zero.same(body.z[1]));
        let s = along(tip, axis, z)[0].max(lo).min(hi);
        let q = sample::<S, TURNS>(&motion, body, &ray, s, half);
        let toward = q.fs.gt(zero).select(lo - s, hi - s);
        let across = q.normal[1].abs().fma(half_u, q.normal[2].abs() * half_v);
        let mut value = q.fs.fma(toward, q.f) - half * q.ft.abs() - across;
        if TURNS {
            // The normal turns with the body: its change along the ray, along u and along v.
            let far = (s - lo).max(hi - s);
            let carried = cross(motion.omega, q.normal);
            let turned = carried[0].abs() * far + carried[1].abs() * half_u + carried[2].abs() * half_v;
            value = value - half * turned - eighth_angle2 * (far + half_u + half_v) - zero.same(bend);
        }
        let mut open = held & !value.gt(zero);
        if open.any() {
            // Or held fixed in space, along the ray.
            let across = q.normal_across();
            let fixed = clearance::<S, TURNS>(&motion, body, across, q.y, half)
                - across[0].abs() * (s - lo).max(hi - s)
                - across[1].abs() * half_u
                - across[2].abs() * half_v;
            open = open & !fixed.gt(zero);
        }
        store(&mut met, g, open.select(zero.same(1.0), zero));
    }
    let mut all = 0;
    for (k, &x) in met.iter().enumerate() {
        all |= u16::from(x > 0.0) << k;
    }
    all
}

/// Range of the blocks of one pair of rows.
#[inline(always)]
pub(crate) fn measure_pair(lanes: &Lanes, pair: usize, lo: &mut [f64; BLOCKS], hi: &mut [f64; BLOCKS]) {
    let first = 2 * ROW * pair;
    let rows = [first..first + ROW, first + ROW..first + 2 * ROW];
    let [low, low_next] = rows.clone().map(|row| &lanes.lo[row]);
    let [high, high_next] = rows.map(|row| &lanes.hi[row]);
    for i in 0..ROW / 2 {
        let k = 2 * i;
        lo[pair * (ROW / 2) + i] = less(less(low[k], low[k + 1]), less(low_next[k], low_next[k + 1]));
        hi[pair * (ROW / 2) + i] = more(more(high[k], high[k + 1]), more(high_next[k], high_next[k + 1]));
    }
}

#[inline(always)]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn more(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
