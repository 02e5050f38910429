//! Closed form: the ray against a ball whose center moves straight.
//!
//! The center is c(t) = c0 + t D, 0 <= t <= 1; split D = De e + Dp with Dp perpendicular to the ray direction
//! e, and let tau measure the time from the nearest approach to the ray, at distance h0. With k^2 = R^2 -
//! h0^2 the upper end at time tau is
//!
//! ```text
//!     b(tau) = b0 + De tau + sqrt(k^2 - |Dp|^2 tau^2)         half an ellipse on a slope: concave
//!
//!       b ^      __
//!         |   .-'  `*.         greatest at tau* = k De / (|Dp| |D|), where normal . velocity is zero
//!         |  /        \        (the envelope condition), moved into the time range of the motion
//!         +--[----------]---> tau
//! ```
//!
//! and the lower end is least at -tau*. The function is concave, so the greatest value in a range is at the
//! point of the range nearest to tau*. No search, no case is missed: the ray is touched exactly when k^2 > 0
//! and the ranges meet.

use crate::{
    field::span::SLIVER,
    kernels::lane_ball::{ALONG_RAY, BallPath},
    kernels::ray::{RayLine, TakenEnd, TakenInterval},
    kernels::vec3::dot,
};

/// Interval that a ball takes up on its way.
///
/// A turning axis moves the center on an arc; the splitting of the motion bounds its distance from the chord.
pub(crate) fn sweep_ball(path: &BallPath, ray: &RayLine) -> Option<TakenInterval> {
    let (start, [de, du, dv], radius) = (path.start, path.way, path.radius);
    let (u, v) = (start[1] - ray.u, start[2] - ray.v);
    let dp2 = du * du + dv * dv;
    let (first, last, s0, k2, tau_best, nearest);
    if dp2 > ALONG_RAY {
        nearest = -(u * du + v * dv) / dp2;
        let (pu, pv) = (u + nearest * du, v + nearest * dv);
        k2 = radius * radius - (pu * pu + pv * pv);
        if k2 <= 0.0 {
            return None;
        }
        let k = k2.sqrt();
        let dp = dp2.sqrt();
        let limit = k / dp;
        (first, last) = ((-nearest).max(-limit), (1.0 - nearest).min(limit));
        if first >= last {
            return None;
        }
        s0 = start[0] + nearest * de;
        tau_best = limit * de / dot(path.way, path.way).sqrt();
    } else {
        k2 = radius * radius - (u * u + v * v);
        if k2 <= 0.0 {
            return None;
        }
        nearest = 0.0;
        (first, last, s0, tau_best) = (0.0, 1.0, start[0], if de >= 0.0 { 1.0 } else { 0.0 });
    }
    let half = |tau: f64| if dp2 > ALONG_RAY { (k2 - dp2 * tau * tau).max(0.0).sqrt() } else { k2.sqrt() };
    let top = tau_best.clamp(first, last);
    let bottom = if dp2 > ALONG_RAY { (-tau_best).clamp(first, last) } else { 1.0 - top };
    let hi = s0 + de * top + half(top);
    let lo = s0 + de * bottom - half(bottom);
    if hi.min(ray.hi) - lo.max(ray.lo) <= SLIVER {
        return None;
    }
    Some(TakenInterval { lo: TakenEnd { s: lo, tau: bottom + nearest }, hi: TakenEnd { s: hi, tau: top + nearest } })
}
