//! The closed form of `ray_ball` for many rays at once. The same formulas, in the same order for each lane.

use pulp::{Simd, WithSimd};

use crate::{
    lanes::{L, Lanes, join, load},
    motion::Piece,
    span::SLIVER,
};

/// One ball on one piece of motion, for all lanes.
pub(crate) struct BallOnLanes<'a> {
    pub piece: &'a Piece,
    pub center_z: f64,
    pub radius: f64,
    pub lanes: &'a mut Lanes,
}

impl WithSimd for BallOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { piece, center_z, radius, lanes } = self;
        let (start, end) = (piece.on_axis(center_z, 0.0), piece.on_axis(center_z, 1.0));
        let (de, du, dv) = (end[0] - start[0], end[1] - start[1], end[2] - start[2]);
        let mut dp2 = du * du + dv * dv;
        // Along the ray the time of the nearest approach is any; all times are then within the limit.
        let (mut per_dp2, mut per_dp) = (0.0, 1e30);
        let mut lean = if de >= 0.0 { 1.0 } else { -1.0 };
        if dp2 > 1e-24 {
            per_dp2 = 1.0 / dp2;
            per_dp = 1.0 / dp2.sqrt();
            lean = de / (dp2 + de * de).sqrt();
        } else {
            dp2 = 0.0;
        }
        let zero = L::splat(simd, 0.0);
        let (one, r2, per_r) = (zero.same(1.0), zero.same(radius * radius), zero.same(1.0 / radius));
        let (s_start, u_start, v_start) = (zero.same(start[0]), zero.same(start[1]), zero.same(start[2]));
        let (de, du, dv, dp2) = (zero.same(de), zero.same(du), zero.same(dv), zero.same(dp2));
        let (per_dp2, per_dp, lean) = (zero.same(per_dp2), zero.same(per_dp), zero.same(lean));
        for g in 0..lanes.len().div_ceil(S::F64_LANES) {
            let (lo, hi) = (load(simd, &lanes.lo, g), load(simd, &lanes.hi, g));
            let (u, v) = (u_start - load(simd, &lanes.u, g), v_start - load(simd, &lanes.v, g));
            let nearest = -(u * du + v * dv) * per_dp2;
            let (pu, pv) = (u + nearest * du, v + nearest * dv);
            let k2 = r2 - (pu * pu + pv * pv);
            let near = k2.gt(zero);
            if !near.any() {
                continue;
            }
            let limit = k2.max(zero).sqrt() * per_dp;
            let first = (-nearest).max(-limit);
            let last = (one - nearest).min(limit);
            let best = limit * lean;
            let top = best.max(first).min(last);
            let bottom = (-best).max(first).min(last);
            let half_top = (k2 - dp2 * top * top).max(zero).sqrt();
            let half_bottom = (k2 - dp2 * bottom * bottom).max(zero).sqrt();
            let middle = s_start + nearest * de;
            let to = middle + de * top + half_top;
            let from = middle + de * bottom - half_bottom;
            let hit = near & first.lt(last) & (to - from).gt(zero.same(SLIVER)) & to.gt(lo) & from.lt(hi);
            if !hit.any() {
                continue;
            }
            let (t_top, t_bottom) = (top + nearest, bottom + nearest);
            let lower = [-half_bottom * per_r, -(u + t_bottom * du) * per_r, -(v + t_bottom * dv) * per_r];
            let upper = [half_top * per_r, -(u + t_top * du) * per_r, -(v + t_top * dv) * per_r];
            join(simd, lanes, g, hit, [from, to], [lower, upper], SLIVER);
        }
    }
}
