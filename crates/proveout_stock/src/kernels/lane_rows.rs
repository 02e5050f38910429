//! Rows of rays that a moving body cannot meet, by a half space for each.

use pulp::{Simd, WithSimd};

use crate::{
    field::step::Step,
    kernels::lane_ball::bits,
    kernels::lane_sample::{Motion, Ray, clearance, sample},
    kernels::lane_set::{ROW, WIDE},
    kernels::lanes::{L, along, cross, dot, load, store, width},
    kernels::meridian::Meridian,
};

/// Rows of a tile that a body may meet on one step: a bit each.
///
/// The half space is tangent to the body at mid-time, next to the point of the row's material that is nearest to the body as far
/// as its axis tells. F is convex with a unit gradient: it holds the body at mid-time; at other times the body leaves it by at
/// most half of its way along the normal, the bend of the way, and what the turn of the normal makes at the far end of the row.
pub(crate) struct BodyOnRows<'a> {
    pub step: &'a Step,
    pub body: &'a Meridian,
    pub u: [f64; 2],
    pub v: &'a [f64; WIDE],
    pub lo: &'a [f64; WIDE],
    pub hi: &'a [f64; WIDE],
}

impl WithSimd for BodyOnRows<'_> {
    type Output = u8;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u8 {
        if self.step.piece.turns() { rows::<S, true>(simd, self) } else { rows::<S, false>(simd, self) }
    }
}

#[inline(always)]
fn rows<S: Simd, const TURNS: bool>(simd: S, call: BodyOnRows<'_>) -> u8 {
    let BodyOnRows { step, body, u, v, lo, hi } = call;
    let piece = &step.piece;
    let motion = Motion::new(simd, piece, body);
    let zero = L::splat(simd, 0.0);
    let half = zero.same(0.5);
    let (tip, axis) = (L::splat3(simd, piece.tip_at(0.5)), L::splat3(simd, piece.axis_at(0.5)));
    let half_u = 0.5 * (u[1] - u[0]);
    let bend = if TURNS { piece.bend(body.reach) / 8.0 } else { 0.0 };
    let eighth_angle2 = zero.same(piece.angle2 / 8.0);
    let mut met = [0.0; WIDE];
    for g in 0..ROW.div_ceil(width::<S>()) {
        let (lo, hi) = (load(simd, lo, g).max(zero.same(step.low[0])), load(simd, hi, g).min(zero.same(step.high[0])));
        let ray = Ray { u: zero.same(0.5 * (u[0] + u[1])), v: load(simd, v, g), lo, hi };
        let x = [half * (lo + hi) - tip[0], ray.u - tip[1], ray.v - tip[2]];
        let z = dot(x, axis).max(zero.same(body.rest_z)).min(zero.same(body.z[1]));
        let s = along(tip, axis, z)[0].max(lo).min(hi);
        let q = sample::<S, TURNS>(&motion, body, &ray, s, half);
        let toward = q.fs.gt(zero).select(lo - s, hi - s);
        let mut value = q.f + q.fs * toward - half * q.ft.abs() - q.normal[1].abs() * zero.same(half_u);
        if TURNS {
            // The normal turns with the body: its change along the ray and along u.
            let far = (s - lo).max(hi - s);
            let carried = cross(motion.omega, q.normal);
            let turned = carried[0].abs() * far + carried[1].abs() * zero.same(half_u);
            value = value - half * turned - eighth_angle2 * (far + zero.same(half_u)) - zero.same(bend);
        }
        // Or held fixed in space, along the ray.
        let across = q.normal_across();
        let fixed = clearance::<S, TURNS>(&motion, body, across, q.y, half)
            - across[0].abs() * (s - lo).max(hi - s)
            - across[1].abs() * zero.same(half_u);
        value = value.max(fixed);
        let open = lo.lt(hi) & !value.gt(zero);
        store(&mut met, g, open.select(zero.same(1.0), zero));
    }
    bits(&met)
}
