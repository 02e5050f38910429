//! The closed form of `ray_ball` for many rays at once. The same formulas, in the same order for each lane.

use pulp::{Simd, WithSimd};

use crate::{
    field::span::SLIVER,
    kernels::lane_bits::ROW,
    kernels::lane_set::{LANES, Lanes, Maker, UNPROVEN, WIDE, join},
    kernels::lanes::{L, load, width},
    kernels::motion::MotionPiece,
    kernels::vec3::{V, dot, sub},
};

/// Square of the way of a ball across a ray below which it runs along it, mm^2.
pub(crate) const ALONG_RAY: f64 = 1e-24;
/// One over the way across the ray where there is none: all times are within the limit.
const ANY_TIME: f64 = 1e30;

/// The path of the center of a ball, ready for any number of rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallPath {
    pub start: V,
    /// From the first center to the last, mm.
    pub way: V,
    pub radius: f64,
    /// Square of the part of the way across the ray; 0 when there is none.
    across2: f64,
    per_across2: f64,
    per_across: f64,
    /// Share of the way that runs along the ray.
    lean: f64,
}

impl BallPath {
    /// The ball with its center at height `center_z` on the tool axis.
    pub(crate) fn new(piece: &MotionPiece, center_z: f64, radius: f64) -> Self {
        let (start, end) = (piece.on_axis(center_z, 0.0), piece.on_axis(center_z, 1.0));
        let way = sub(end, start);
        let mut across2 = way[1] * way[1] + way[2] * way[2];
        // Along the ray the time of the nearest approach is any; all times are then within the limit.
        let (mut per_across2, mut per_across) = (0.0, ANY_TIME);
        let mut lean = if way[0] >= 0.0 { 1.0 } else { -1.0 };
        if across2 > ALONG_RAY {
            per_across2 = 1.0 / across2;
            per_across = 1.0 / across2.sqrt();
            lean = way[0] / dot(way, way).sqrt();
        } else {
            across2 = 0.0;
        }
        Self { start, way, radius, across2, per_across2, per_across, lean }
    }

    /// Whether the ball stays away from a box, its path taken for a box.
    #[inline]
    pub(crate) fn passes(&self, s: [f64; 2], u: [f64; 2], v: [f64; 2]) -> bool {
        let mut square = 0.0;
        for (i, [low, high]) in [s, u, v].into_iter().enumerate() {
            let (from, to) = (self.start[i], self.start[i] + self.way[i]);
            let (from, to) = if from < to { (from, to) } else { (to, from) };
            let away = (from - high).max(low - to).max(0.0);
            square += away * away;
        }
        square > self.radius * self.radius
    }

    /// Box of the center on its way: lowest and highest coordinates.
    pub(crate) fn center_box(&self) -> [V; 2] {
        let end = [0, 1, 2].map(|i| self.start[i] + self.way[i]);
        [[0, 1, 2].map(|i| self.start[i].min(end[i])), [0, 1, 2].map(|i| self.start[i].max(end[i]))]
    }
}

/// One ball on one piece of motion, for all lanes that are asked for.
pub(crate) struct BallOnLanes<'a> {
    pub path: &'a BallPath,
    pub maker: Maker,
    pub lanes: &'a mut Lanes,
}

impl WithSimd for BallOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { path, maker, lanes } = self;
        let zero = L::splat(simd, 0.0);
        let (one, r2) = (zero.same(1.0), zero.same(path.radius * path.radius));
        let (s_start, u_start, v_start) =
            (zero.same(path.start[0]), zero.same(path.start[1]), zero.same(path.start[2]));
        let (de, du, dv) = (zero.same(path.way[0]), zero.same(path.way[1]), zero.same(path.way[2]));
        let (across2, per_across2) = (zero.same(path.across2), zero.same(path.per_across2));
        let (per_across, lean) = (zero.same(path.per_across), zero.same(path.lean));
        for g in 0..LANES / width::<S>() {
            if !lanes.requests_any::<S>(g) {
                continue;
            }
            let (u, v) = (u_start - load(simd, &lanes.u, g), v_start - load(simd, &lanes.v, g));
            let nearest = -u.fma(du, v * dv) * per_across2;
            let (pu, pv) = (nearest.fma(du, u), nearest.fma(dv, v));
            let k2 = pu.fma_from(pu, pv.fma_from(pv, r2));
            let near = k2.gt(zero);
            let limit = k2.max(zero).sqrt() * per_across;
            let first = (-nearest).max(-limit);
            let last = (one - nearest).min(limit);
            let best = limit * lean;
            let top = best.max(first).min(last);
            let bottom = (-best).max(first).min(last);
            let half_top = (across2 * top).fma_from(top, k2).max(zero).sqrt();
            let half_bottom = (across2 * bottom).fma_from(bottom, k2).max(zero).sqrt();
            let middle = nearest.fma(de, s_start);
            let to = de.fma(top, middle) + half_top;
            let from = de.fma(bottom, middle) - half_bottom;
            let (lo, hi) = (load(simd, &lanes.lo, g), load(simd, &lanes.hi, g));
            let asked = load(simd, &lanes.state, g).lt(one.same(UNPROVEN));
            let overlap = to.min(hi) - from.max(lo);
            let hit = near & asked & first.lt(last) & overlap.gt(zero.same(SLIVER));
            if !hit.any() {
                continue;
            }
            join(simd, lanes, g, hit, [from, to], [bottom + nearest, top + nearest], maker);
        }
    }
}

/// Rows of a tile that a ball may meet: a bit each.
///
/// The path is taken for its box, the row for its range along u; what lies between both is
/// `R^2 = h^2 + du^2 + dv^2`.
pub(crate) struct BallOnRows<'a> {
    pub path: &'a BallPath,
    pub u: [f64; 2],
    pub v: &'a [f64; WIDE],
    pub lo: &'a [f64; WIDE],
    pub hi: &'a [f64; WIDE],
}

impl WithSimd for BallOnRows<'_> {
    type Output = u8;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u8 {
        let Self { path, u, v, lo, hi } = self;
        let [low, high] = path.center_box();
        let du = (low[1] - u[1]).max(u[0] - high[1]).max(0.0);
        let zero = L::splat(simd, 0.0);
        let room = zero.same(path.radius * path.radius - du * du);
        let mut met = [0.0; WIDE];
        for g in 0..ROW.div_ceil(width::<S>()) {
            let v = load(simd, v, g);
            let dv = (zero.same(low[2]) - v).max(v - zero.same(high[2])).max(zero);
            let k2 = room - dv * dv;
            let half = k2.max(zero).sqrt();
            let reached =
                load(simd, hi, g).gt(zero.same(low[0]) - half) & load(simd, lo, g).lt(half + zero.same(high[0]));
            crate::kernels::lanes::store(&mut met, g, (k2.gt(zero) & reached).select(zero.same(1.0), zero));
        }
        bits(&met)
    }
}

/// A bit for every number that is not zero.
#[inline(always)]
pub(crate) fn bits(x: &[f64; WIDE]) -> u8 {
    let mut all = 0;
    for (k, &x) in x[..ROW].iter().enumerate() {
        all |= u8::from(x > 0.0) << k;
    }
    all
}
