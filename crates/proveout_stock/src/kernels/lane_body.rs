//! Sweep of any convex body for many rays at once: Newton's method on the envelope, with a proof for each
//! ray.
//!
//! An end of the interval that a moving body takes up on a ray is a point (tau, s) with `F = 0` and `F_tau =
//! 0`, or `F = 0` at the beginning or end of the motion. Newton's method on this pair finds it in a few
//! steps; curvatures of the body are known in closed form, `kr = F_r / r` round the axis and `km` along the
//! meridian. What the search found is accepted only with a proof by a supporting half space, as in
//! `ray_turn`:
//!
//! ```text
//!                 .---- F >= f + F_tau dtau + F_s ds - ...   at all other times: the body is nowhere deeper
//!      s ^       /      than the deficit beyond the end found
//!        |  ...-*-...
//!        | /    |    \       straight motion: F is convex in both, the linear terms are all
//!        |/     |     \      turning: (1) of `ray_turn`, or the half space held fixed in space: a point of
//!        +-----tau*----->    the body leaves the chord of its way by no more than angle^2 reach / 8, so both
//!                            ends of the motion bound all of it
//! ```
//!
//! A ray that the body misses is proven by the same inequality: F > 0 at a point, and growing towards all of
//! the material; by two points on both sides of the minimum along the ray; or, most often, by the support of
//! the body on its way in the direction of the normal across the ray (`lane_sample::clearance`), which says
//! the same about all of the ray. The search begins inside of the body, where its axis is nearest to the ray,
//! and leaves it on the parabola with the height, slope and curvature of the skin. The first sample
//! (`lane_search::first_sample`) settles most rays and gives the starts of the searches for both ends.
//!
//! An end is accepted before F is zero where the skin is smooth: the last step d along the ray leaves at most
//! curvature d^2 / 2, and the parabola takes most of that away. Its half space is turned to be perpendicular
//! to the velocity, as the normal of the swept surface is: what it leaves open is then of second order in the
//! error of the time.
//!
//! Lanes without proof after a few samples are gathered and get a second chance with more, and in quarters of
//! a turning motion; what is left, such as rays that meet the rim of a flat end mill, is searched by
//! `ray_translate` and `ray_turn`, which always end. The bounds are the same:
//! [`SEARCH_ERROR`](crate::kernels::motion::SEARCH_ERROR) for a straight motion and [`TURN_ERROR`] more for
//! one that turns.

use pulp::{Simd, WithSimd};

use crate::{
    field::span::SLIVER,
    kernels::lane_sample::{LaneMotion, LaneRays, sample},
    kernels::lane_search::{LaneSearchResult, first_sample, search},
    kernels::lane_set::{LANES, Lanes, Maker, UNPROVEN, join},
    kernels::lanes::{L, dot, load, put, width},
    kernels::meridian::Meridian,
    kernels::motion::{MotionPiece, TURN_ERROR},
    kernels::vec3,
};

/// Square of the way across the axis below which no time is nearest, mm^2.
const NO_WAY: f64 = 1e-12;

/// A body on one piece of motion, for all lanes that are asked for. True when some may be left without proof.
pub(crate) struct BodyOnLanes<'a> {
    pub piece: &'a MotionPiece,
    /// Range of the moving body along the rays, mm.
    pub range: [f64; 2],
    pub body: &'a Meridian,
    pub maker: Maker,
    /// Samples that a search may take.
    pub steps: usize,
    pub lanes: &'a mut Lanes,
}

impl WithSimd for BodyOnLanes<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        if self.piece.turns() { sweep::<S, true>(simd, self) } else { sweep::<S, false>(simd, self) }
    }
}

#[inline(always)]
fn sweep<S: Simd, const TURNS: bool>(simd: S, call: BodyOnLanes<'_>) -> bool {
    let BodyOnLanes { piece, range: [low, high], body, maker, steps, lanes } = call;
    let motion = LaneMotion::new(simd, piece, body);
    let mut all_proven = true;
    // Where in time a point is nearest: its place along the part of the way that is across the axis.
    let sideways = vec3::along(piece.travel, piece.axis, -vec3::dot(piece.travel, piece.axis));
    let square = vec3::dot(sideways, sideways);
    let across = L::splat3(simd, vec3::scale(sideways, if square > NO_WAY { 1.0 / square } else { 0.0 }));
    let zero = L::splat(simd, 0.0);
    let (middle, axis) = (L::splat3(simd, piece.tip_at(0.5)), piece.axis_at(0.5));
    // Weight of "as high as the material comes" against "near the ray": only an axis along the ray leaves the
    // choice.
    let weight = 0.02;
    let per_height = 1.0 / (axis[1] * axis[1] + axis[2] * axis[2] + weight);
    let along_ray = if axis[0].abs() > 0.1 { weight / axis[0] } else { 0.0 };
    let (lowest, highest) = (body.rest_z, body.z[1]);
    let axis = L::splat3(simd, axis);
    // A little more than the angle of the turn, whose pace is not even by less.
    let (way, angle) = (zero.same(vec3::norm(piece.travel)), zero.same(1.01 * piece.angle2.sqrt()));
    for g in 0..LANES / width::<S>() {
        if !lanes.requests_any::<S>(g) {
            continue;
        }
        let ray = LaneRays {
            u: load(simd, &lanes.u, g),
            v: load(simd, &lanes.v, g),
            // Bounds of a turning half space grow with the length of the ray.
            lo: load(simd, &lanes.lo, g).max(zero.same(low)),
            hi: load(simd, &lanes.hi, g).min(zero.same(high)),
        };
        let state = load(simd, &lanes.state, g);
        let wanted = state.lt(state.same(UNPROVEN)) & ray.lo.lt(ray.hi);
        if !wanted.any() {
            continue;
        }
        // Begin inside of the body if the ray meets it: at the point of the axis that is nearest to the ray,
        // as high as the material comes when the axis runs along the ray.
        let (du, dv) = (ray.u - middle[1], ray.v - middle[2]);
        let top = (ray.hi - middle[0]) * zero.same(along_ray);
        let height = (du.fma(axis[1], dv.fma(axis[2], top)) * zero.same(per_height))
            .max(zero.same(lowest))
            .min(zero.same(highest));
        let s = height.fma(axis[0], middle[0]).max(ray.lo).min(ray.hi);
        let time = dot([s - motion.tip[0], ray.u - motion.tip[1], ray.v - motion.tip[2]], across);
        let time = time.max(zero).min(zero.same(1.0));
        let look = first_sample::<S, TURNS>(&motion, body, &ray, (s, time), wanted);
        let none = !wanted & wanted;
        let mut above = LaneSearchResult {
            covered: look.covered,
            end: none,
            miss: look.miss,
            s: ray.hi,
            tau: time,
            other: look.s,
            other_tau: look.tau,
        };
        let open = wanted & !look.covered & !look.miss;
        if open.any() {
            let searched = search::<S, TURNS>(&motion, body, &ray, 1.0, (look.s, look.tau), open, steps);
            above.covered = above.covered | searched.covered;
            above.end = searched.end;
            above.miss = above.miss | searched.miss;
            above.s = open.select(searched.s, above.s);
            above.tau = open.select(searched.tau, above.tau);
            above.other = open.select(searched.other, above.other);
            above.other_tau = open.select(searched.tau, above.other_tau);
        }
        let met = above.covered | above.end;
        let mut hit = met;
        let mut below = above;
        if met.any() {
            let start = above.covered.select(above.other, ray.lo).max(ray.lo).min(ray.hi);
            let low = met & look.low;
            let open = met & !low;
            if open.any() {
                below = search::<S, TURNS>(&motion, body, &ray, -1.0, (start, above.other_tau), open, steps);
            }
            below.covered = low | (open & below.covered);
            below.tau = low.select(time, below.tau);
            hit = below.covered | (open & below.end);
        }
        let (to, from) = (above.covered.select(ray.hi, above.s), below.covered.select(ray.lo, below.s));
        if TURNS && hit.any() {
            // The union is one interval if the body makes both ends with a point in common.
            let mut apart = hit & (below.tau.lt(above.tau) | below.tau.gt(above.tau));
            // A point so deep in the body at first that it is in it at both times.
            let longest = (below.tau - time).abs().max((above.tau - time).abs());
            let speed = (dot(look.y, look.y).sqrt() + way) * angle + way;
            apart = apart & !(look.f + speed * longest).le(zero);
            if apart.any() {
                let mut joined = sample::<S, TURNS>(&motion, body, &ray, to, below.tau).f.le(zero.same(TURN_ERROR));
                if (apart & !joined).any() {
                    joined =
                        joined | sample::<S, TURNS>(&motion, body, &ray, from, above.tau).f.le(zero.same(TURN_ERROR));
                }
                if (apart & !joined).any() {
                    let middle = (from + to) * zero.same(0.5);
                    let upper = sample::<S, TURNS>(&motion, body, &ray, middle, above.tau).f.le(zero.same(TURN_ERROR));
                    let lower = sample::<S, TURNS>(&motion, body, &ray, middle, below.tau).f.le(zero.same(TURN_ERROR));
                    joined = joined | (upper & lower);
                }
                hit = hit & (joined | !apart);
            }
        }
        let unproven = wanted & !(hit | above.miss);
        let hit = hit & (to - from).gt(zero.same(SLIVER));
        if hit.any() {
            join(simd, lanes, g, hit, [from, to], [below.tau, above.tau], maker);
        }
        if unproven.any() {
            put(g, &mut lanes.state, unproven, zero.same(UNPROVEN));
            all_proven = false;
        }
    }
    !all_proven
}
