//! Exact sweep of any convex body along a straight line.
//!
//! For a translation F(t, s), the body's convex function (see `meridian`) at height s of the ray and time t,
//! is convex in both together, since the point in the frame of the body is affine in (t, s). So the set of
//! (t, s) with F <= 0 is convex, and the interval wanted is its shadow on the s axis. Every sample with F > 0
//! gives a half plane that holds the whole set:
//!
//! ```text
//!    s ^  +-------*---------+      Start from the rectangle 0 <= t <= 1, material range of the ray.
//!      |  |     .' '.       |      Sample the highest corner; outside: cut the polygon with the tangent
//!      |  |   .' .-. '.     |      there and go on; inside: the upper end is found.
//!      |  | .'  (   )  '.   |      The lower end follows in the same polygon.
//!      |  +'-----`-'-----`--+      Polygon empty: the body never meets the ray, and that is a proof.
//!      +--------------------> t
//! ```
//!
//! Each cut at a smooth maximum halves the angle between the two tangents, so the distance falls by four a
//! step. Within [`SEARCH_ERROR`] the step ends by Newton's method along the ray at fixed t, which lands on
//! the skin of a true position of the body: the end is then exact or short by no more than that bound.
//! Grazing rays need no special case. (Cutting planes: Kelley 1960, "The Cutting-Plane Method for Solving
//! Convex Programs".)

use crate::{
    field::span::SLIVER,
    kernels::meridian::Meridian,
    kernels::motion::{BodySample, MotionPiece, SEARCH_ERROR},
    kernels::ray::{REACHED, RayLine, TakenEnd, TakenInterval},
};

/// Corners that the polygon may have; each cut adds at most one.
const CORNERS: usize = 64;
/// Cuts for one end after which the polygon's corner is taken as it is. Smooth bodies need ten.
const CUTS: usize = 56;
/// Corners of the polygon whose heights differ by less are equally high, mm.
const SAME_HEIGHT: f64 = 1e-10;

/// Convex polygon in the plane (t, s).
struct Polygon {
    corners: [(f64, f64); CORNERS],
    n: usize,
}

impl Polygon {
    fn new(lo: f64, hi: f64) -> Self {
        let mut corners = [(0.0, 0.0); CORNERS];
        corners[..4].copy_from_slice(&[(0.0, lo), (1.0, lo), (1.0, hi), (0.0, hi)]);
        Self { corners, n: 4 }
    }

    /// Keeps the part where f + ft (t - t0) + fs (s - s0) <= 0.
    #[inline]
    fn cut(&mut self, t0: f64, s0: f64, sample: &BodySample) {
        let g = |(t, s): (f64, f64)| sample.f + sample.ft * (t - t0) + sample.fs * (s - s0);
        let old = self.corners;
        let n = self.n;
        if n == 0 {
            return;
        }
        let mut kept = 0;
        let mut before = old[n - 1];
        let mut g_before = g(before);
        for &corner in &old[..n] {
            let g_here = g(corner);
            if (g_before <= 0.0) != (g_here <= 0.0) && kept < CORNERS {
                let k = g_before / (g_before - g_here);
                self.corners[kept] = (before.0 + k * (corner.0 - before.0), before.1 + k * (corner.1 - before.1));
                kept += 1;
            }
            if g_here <= 0.0 && kept < CORNERS {
                self.corners[kept] = corner;
                kept += 1;
            }
            (before, g_before) = (corner, g_here);
        }
        self.n = kept;
    }

    /// Middle of the highest (`sign` 1) or lowest (`sign` -1) corner or edge.
    #[inline]
    fn extreme(&self, sign: f64) -> (f64, f64) {
        let mut best = f64::NEG_INFINITY;
        for c in &self.corners[..self.n] {
            best = best.max(sign * c.1);
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for c in &self.corners[..self.n] {
            if sign * c.1 >= best - SAME_HEIGHT {
                low = low.min(c.0);
                high = high.max(c.0);
            }
        }
        (0.5 * (low + high), sign * best)
    }
}

/// Interval that a body takes up on a ray while it translates; its ends outside of the ray's range may be cut
/// off there.
pub(crate) fn sweep_translation(piece: &MotionPiece, body: &Meridian, ray: &RayLine) -> Option<TakenInterval> {
    let mut polygon = Polygon::new(ray.lo, ray.hi);
    // One sample in the middle proves most misses: facing the axis of the body, or as near as the material
    // comes.
    let s = piece.facing(body, ray.at(0.5 * (ray.lo + ray.hi))).clamp(ray.lo, ray.hi);
    let first = piece.sample(body, ray.at(s), 0.5);
    if first.f > REACHED {
        polygon.cut(0.5, s, &first);
    }
    let (hi, hi_time, _) = find_end(piece, body, ray, &mut polygon, 1.0)?;
    let (lo, lo_time, _) = find_end(piece, body, ray, &mut polygon, -1.0)?;
    if hi - lo <= SLIVER {
        return None;
    }
    Some(TakenInterval { lo: TakenEnd { s: lo, tau: lo_time }, hi: TakenEnd { s: hi, tau: hi_time } })
}

/// Height, time and sample of an end.
type SampledEnd = (f64, f64, BodySample);

fn find_end(
    piece: &MotionPiece,
    body: &Meridian,
    ray: &RayLine,
    polygon: &mut Polygon,
    sign: f64,
) -> Option<SampledEnd> {
    let mut last = None;
    for _ in 0..CUTS {
        if polygon.n == 0 {
            return None;
        }
        let (t, s) = polygon.extreme(sign);
        let sample = piece.sample(body, ray.at(s), t);
        if sample.f <= REACHED {
            return Some((s, t, sample));
        }
        // At the end of the material the swept body may go on, and the depth there be anything.
        if sample.f <= SEARCH_ERROR
            && (if sign > 0.0 { s < ray.hi } else { s > ray.lo })
            && let Some(end) = polish(piece, body, ray, t, s, sign, sample)
        {
            return Some(end);
        }
        last = Some((s, t, sample));
        polygon.cut(t, s, &sample);
    }
    last
}

/// Newton's method along the ray at fixed time; none when it moves the end by more than [`SEARCH_ERROR`]. The
/// depth in the swept body changes along the ray by no more than the way, so no deeper point is lost.
fn polish(
    piece: &MotionPiece,
    body: &Meridian,
    ray: &RayLine,
    t: f64,
    s: f64,
    sign: f64,
    first: BodySample,
) -> Option<SampledEnd> {
    let start = s;
    let (mut s, mut sample) = (s, first);
    for _ in 0..8 {
        if sample.fs * sign <= 0.0 {
            return None;
        }
        s -= sample.f / sample.fs;
        if (s - start).abs() > SEARCH_ERROR || !(ray.lo <= s && s <= ray.hi) {
            return None;
        }
        sample = piece.sample(body, ray.at(s), t);
        if sample.f <= REACHED {
            return Some((s, t, sample));
        }
    }
    None
}
