//! The search for one end of the interval that a moving body takes up, for many rays at once: see
//! `lane_body`.

use pulp::Simd;

use crate::{
    kernels::lane_sample::{LaneMotion, LaneRays, LaneSample, clearance, sample},
    kernels::lanes::{L, L3, Mask, cross, dot},
    kernels::meridian::Meridian,
    kernels::motion::{SEARCH_ERROR, TURN_ERROR},
    kernels::ray::REACHED,
};

/// Samples of one search at first: most need three, and one ray holds up all that are searched with it.
pub(crate) const STEPS: usize = 6;
/// Samples of the second chance.
pub(crate) const MORE_STEPS: usize = 24;
/// An end counts as found when F is this near to zero (mm); a last step of Newton's method follows, so what
/// remains is of second order.
const FLAT: f64 = 1e-5;
/// The same on smooth skin, where the square of the last step counts.
const SMOOTH_FLAT: f64 = 0.01;
/// Least slope of F along the ray at an end: steeper grazing goes to the searches.
const GRAZING: f64 = 0.004;

/// Times at which F falls and grows bound the time looked for while the height moves by less than this, mm.
const SAME_HEIGHT: f64 = 0.01;
/// Curvature of F along the ray from which on the skin is round enough for a parabola, 1/mm.
const ROUND: f64 = 1e-3;
/// Slope of F along the way below which it does not rise.
const RISES: f64 = 1e-9;
/// Second derivative in time by which a step is divided at least, mm.
const LEAST_IN_TIME: f64 = 1e-9;
/// Curvature along the ray by which a step is divided at least, 1/mm.
const LEAST_ALONG_RAY: f64 = 1e-4;

/// What a search found, one condition each; none of them: no proof.
#[derive(Clone, Copy)]
pub(crate) struct LaneSearchResult<S: Simd> {
    /// The body covers the end of the material at some time.
    pub covered: Mask<S>,
    /// An end inside of the material.
    pub end: Mask<S>,
    /// The body does not meet the material.
    pub miss: Mask<S>,
    pub s: L<S>,
    pub tau: L<S>,
    /// Where the other end of the interval may be looked for, if the body covers this one.
    pub other: L<S>,
    pub other_tau: L<S>,
}

/// A sample outside of the body.
#[derive(Clone, Copy)]
struct OuterSample<S: Simd> {
    s: L<S>,
    f: L<S>,
    fs: L<S>,
    deficit: L<S>,
    slope: L<S>,
}

impl<S: Simd> OuterSample<S> {
    #[inline(always)]
    fn set(&mut self, at: Mask<S>, new: Self) {
        self.s = at.select(new.s, self.s);
        self.f = at.select(new.f, self.f);
        self.fs = at.select(new.fs, self.fs);
        self.deficit = at.select(new.deficit, self.deficit);
        self.slope = at.select(new.slope, self.slope);
    }
}

/// Result of the first sample of a ray.
#[derive(Clone, Copy)]
pub(crate) struct FirstSample<S: Simd> {
    pub covered: Mask<S>,
    pub miss: Mask<S>,
    /// The body covers the lower end of the material at the time of the sample.
    pub low: Mask<S>,
    /// Height and time where the search goes on: for the other end where this one is covered.
    pub s: L<S>,
    pub tau: L<S>,
    /// F and the point from the tip at the sample.
    pub f: L<S>,
    pub y: L3<S>,
}

/// The first sample of a search for the upper end, which settles most rays: the body does not meet the
/// material, or covers its end.
#[inline(always)]
pub(crate) fn first_sample<S: Simd, const TURNS: bool>(
    motion: &LaneMotion<S>,
    body: &Meridian,
    ray: &LaneRays<S>,
    (s, tau): (L<S>, L<S>),
    wanted: Mask<S>,
) -> FirstSample<S> {
    let (zero, one) = (s.same(0.0), s.same(1.0));
    let allowed = if TURNS { s.same(SEARCH_ERROR + TURN_ERROR) } else { s.same(SEARCH_ERROR) };
    let q = sample::<S, TURNS>(motion, body, ray, s, tau);
    let inside = q.f.le(s.same(REACHED));
    let outside = wanted & !inside;
    let mut miss = outside & !wanted;
    if outside.any() {
        let up = q.fs.gt(zero);
        let (above, below) = (ray.hi - s, s - ray.lo);
        let [deficit, slope] = bound::<S, TURNS>(motion, &q, tau);
        let away = up.select(below, above);
        let steep = q.fs.abs();
        let mut least = (steep + slope).fma_from(away, q.f - deficit);
        if TURNS {
            least = least - (slope - steep).max(zero) * up.select(above, below);
        }
        miss = outside & least.ge(-allowed);
        if (outside & !miss).any() {
            // At the very end of the material a half space needs to say nothing about the rest of the ray.
            let across = away.le(zero).select3(q.normal, q.normal_across());
            let clear = clearance::<S, TURNS>(motion, body, across, q.y, tau);
            miss = miss | (outside & across[0].abs().fma_from(away, clear).ge(-allowed));
        }
    }
    let covered = wanted & inside & s.ge(ray.hi);
    let low = wanted & inside & s.le(ray.lo);
    let mut look = FirstSample { covered, miss, low, s, tau, f: q.f, y: q.y };
    let open = wanted & !miss;
    if open.any() {
        let [ftt, fts, fss] = q.curvature::<TURNS>(motion);
        let round = fss.gt(s.same(ROUND));
        let per_fss = one / round.select(fss, one);
        let root = (q.f * s.same(2.0)).fma_from(fss, q.fs * q.fs).max(zero).sqrt();
        let turned = q.fs.le(s.same(RISES));
        let drop = q.f / turned.select(one, q.fs);
        // Up out of the body: on the parabola with the height, slope and curvature of the skin, or straight.
        // From outside to where F is least.
        let out = round.select((root - q.fs) * per_fss, turned.select(ray.hi - s, -drop));
        let lowest = round.select(-q.fs * per_fss, turned.select(ray.hi - s, -drop));
        // Down out of it from the covered end.
        let other = -round.select((root + q.fs) * per_fss, q.f / q.fs.min(s.same(-0.05)));
        let step = covered.select(other, inside.select(out, (turned & outside).select(lowest, -drop)));
        let next = (s + step).max(ray.lo).min(ray.hi);
        let time = (tau - fts.fma(next - s, q.ft) / ftt.max(s.same(LEAST_IN_TIME))).max(zero).min(one);
        look.s = next;
        look.tau = time;
    }
    look
}

/// How much deeper than at the sample the body may be at another time, and how fast that grows along the ray:
/// (1).
#[inline(always)]
fn bound<S: Simd, const TURNS: bool>(motion: &LaneMotion<S>, q: &LaneSample<S>, tau: L<S>) -> [L<S>; 2] {
    let (zero, one) = (tau.same(0.0), tau.same(1.0));
    let (left, right) = (tau, one - tau);
    if !TURNS {
        return [(left * q.ft).max(right * -q.ft).max(zero), zero];
    }
    let carried = cross(motion.omega, q.normal);
    let second = dot(motion.omega, q.normal) * dot(motion.omega, q.y)
        - motion.angle2 * dot(q.normal, q.y)
        - tau.same(2.0) * dot(carried, motion.travel);
    let bend = tau.same(0.5) * (-second).max(zero);
    let before = left * left.fma(motion.third.fma(left, bend), q.ft);
    let after = right * right.fma(motion.third.fma(right, bend), -q.ft);
    let far = left.max(right);
    let slope = carried[0].abs() * far + tau.same(0.5) * motion.angle2 * far * far;
    [before.max(after).max(zero), slope]
}

/// Upper (`sign` 1) or lower (-1) end of the interval, from a start (height, time).
#[inline(always)]
pub(crate) fn search<S: Simd, const TURNS: bool>(
    motion: &LaneMotion<S>,
    body: &Meridian,
    ray: &LaneRays<S>,
    sign: f64,
    start: (L<S>, L<S>),
    wanted: Mask<S>,
    steps: usize,
) -> LaneSearchResult<S> {
    let (mut s, mut tau) = start;
    let (zero, one) = (s.same(0.0), s.same(1.0));
    let outward = s.same(sign);
    let limit = if sign > 0.0 { ray.hi } else { ray.lo };
    let allowed = if TURNS { s.same(SEARCH_ERROR + TURN_ERROR) } else { s.same(SEARCH_ERROR) };
    let none = !wanted & wanted;
    let mut found = LaneSearchResult { covered: none, end: none, miss: none, s, tau, other: s, other_tau: tau };
    let mut active = wanted;
    // Samples outside of the body between which F has its minimum along the ray.
    let mut rising = OuterSample { s: zero, f: zero, fs: zero, deficit: zero, slope: zero };
    let mut sinking = rising;
    // Times at which F falls and grows at this height, with F_tau there; 0: none yet.
    let (mut falls, mut falls_at) = (zero, zero);
    let (mut grows, mut grows_at) = (zero, one);
    for _ in 0..steps {
        let q = sample::<S, TURNS>(motion, body, ray, s, tau);
        let (up, steep) = (q.fs.gt(zero), q.fs.abs());
        let rise = q.fs * outward;
        let inside = q.f.le(s.same(REACHED));
        let turned = rise.le(s.same(RISES));
        let drop = q.f / turned.select(one, q.fs);
        // Where the skin is smooth the last step may be longer: F leaves the tangent by curvature / 2 times
        // its square.
        let left_over = drop * drop * q.kr.max(s.same(body.bend));
        let smooth = q.z.gt(s.same(body.smooth[0])) & q.z.lt(s.same(body.smooth[1]));
        let near = q.f.abs().le(s.same(FLAT))
            | (smooth & !turned & left_over.le(s.same(2.0 * FLAT)) & q.f.abs().le(s.same(SMOOTH_FLAT)));
        let covered = active & inside & s.ge(limit) & s.le(limit);
        let mut done = covered;
        found.covered = found.covered | covered;
        // The lower end is looked for where the upper has been found: the body is met.
        let outside = if sign > 0.0 { active & !inside } else { none };
        let mut valley = none;
        let mut lowest = s;
        if (outside | (active & near & !covered)).any() {
            let [mut deficit, mut slope] = bound::<S, TURNS>(motion, &q, tau);
            let (above, below) = (ray.hi - s, s - ray.lo);
            let (toward, away) = (up.select(above, below), up.select(below, above));
            let mut miss = none;
            if sign > 0.0 {
                let least = q.f - deficit - (steep + slope) * away - (slope - steep).max(zero) * toward;
                miss = outside & least.ge(-allowed);
            }
            let apart = outside & !miss;
            let open = apart | (active & near & deficit.gt(allowed));
            if open.any() {
                // Ends want the half space of the sample, misses one along the ray: it says the same about
                // all of the ray.
                let mut across = q.normal;
                if (open & near).any() {
                    across = q.normal_across_way::<TURNS>(motion);
                }
                if sign > 0.0 && (apart & !near).any() {
                    across = (apart & !near).select3(q.normal_across(), across);
                }
                let clear = clearance::<S, TURNS>(motion, body, across, q.y, tau);
                let away = across[0].gt(zero).select(below, above);
                miss = miss | (apart & (clear - across[0].abs() * away).ge(-allowed));
                // Between the end where the last step leads and where the half space cuts the ray.
                let between = drop.fma(across[0], -clear);
                let better = open & near & (across[0] * outward).ge(s.same(GRAZING)) & between.lt(deficit);
                deficit = better.select(between.max(zero), deficit);
                slope = better.select(zero, slope);
            }
            if sign > 0.0 && (outside & !miss).any() {
                let here = OuterSample { s, f: q.f, fs: q.fs, deficit, slope };
                // At a time far from the best one a sample proves nothing, and leads astray.
                let telling = outside & q.f.gt(deficit);
                rising.set(telling & up, here);
                sinking.set(telling & !up, here);
                valley = outside & rising.fs.gt(zero) & sinking.fs.lt(zero) & rising.s.gt(sinking.s);
                if (valley & !miss).any() {
                    // Both tangents bound F from below; where they cross the bound is least.
                    let per_slope = one / valley.select(rising.fs - sinking.fs, one);
                    lowest = (sinking.fs * sinking.s - rising.fs * rising.s + rising.f - sinking.f) * -per_slope;
                    let bound = rising.f + rising.fs * (lowest - rising.s);
                    let right = rising.deficit + rising.slope * (rising.s - lowest);
                    let left = sinking.deficit + sinking.slope * (lowest - sinking.s);
                    // Further out both must grow although they turn.
                    let grow = rising.fs.ge(rising.slope) & (-sinking.fs).ge(sinking.slope);
                    miss = miss | (valley & grow & (bound - right.max(left)).ge(-allowed));
                    // Tangents at different times may cross anywhere.
                    let room = (rising.s - sinking.s) * s.same(0.05);
                    let between = lowest.gt(sinking.s + room) & lowest.lt(rising.s - room);
                    lowest = between.select(lowest, (sinking.s + rising.s) * s.same(0.5));
                }
            }
            let end = active
                & near
                & !covered
                & !miss
                & (deficit + s.same(FLAT)).le(allowed)
                & rise.ge(s.same(GRAZING).max(slope));
            done = done | miss | end;
            found.miss = found.miss | miss;
            found.end = found.end | end;
            if end.any() {
                // Along the parabola with the height, slope and curvature of the skin.
                let sag = s.same(0.5) * q.bend_along() * drop / end.select(q.fs, one);
                found.s = end.select(s - sag.fma(drop, drop), found.s);
            }
        }
        if done.any() {
            found.s = (done & !found.end).select(s, found.s);
            found.tau = done.select(tau, found.tau);
            if sign > 0.0 && covered.any() {
                // Where the other end is likely to be: on the parabola with the same height, slope and
                // curvature.
                let [_, _, fss] = q.curvature::<TURNS>(motion);
                let root = (q.f * s.same(2.0)).fma_from(fss, rise * rise).max(zero).sqrt();
                let round = fss.gt(s.same(ROUND));
                let out = (rise + root) / round.select(fss, one);
                let straight = q.f / q.fs.min(s.same(-0.05));
                found.other = covered.select(s - round.select(out, straight), found.other);
            }
            active = active & !done;
            if !active.any() {
                break;
            }
        }
        // Next height: out of the body, or down to it; where F does not fall that way only the time can help.
        let deep = inside & turned;
        let stay = !inside & turned;
        let newton = s - drop;
        // Newton's method from one side of the minimum may land on the other side.
        let past = valley & (newton.le(sinking.s) | newton.ge(rising.s));
        let astray = active & (stay | past);
        // At the beginning and at the end of the motion most searches only want the height.
        let settled = (tau.le(zero) & q.ft.ge(zero)) | (tau.ge(one) & q.ft.le(zero));
        let mut next = deep.select(limit, newton);
        let deep_in = active & inside;
        if (astray | deep_in | (active & !settled)).any() {
            let [ftt, fts, fss] = q.curvature::<TURNS>(motion);
            // Out of the body where its skin is round: the parabola with the same height, slope and
            // curvature.
            let root = (q.f * s.same(2.0)).fma_from(fss, rise * rise).max(zero).sqrt();
            let round = deep_in & fss.gt(s.same(ROUND));
            let out = (root - rise) / round.select(fss, one);
            next = round.select(s + outward * out, next);
            if astray.any() {
                // To the minimum of F along the ray, the time going along with the height.
                let per_ftt = one / ftt.max(s.same(LEAST_IN_TIME));
                let share = settled.select(zero, fts * per_ftt);
                let (slope, bend) = (q.fs - share * q.ft, fss - share * fts);
                let bottom = s - slope / bend.max(s.same(LEAST_ALONG_RAY));
                let between = bottom.gt(sinking.s) & bottom.lt(rising.s);
                let known = bend.gt(s.same(ROUND)) & (!valley | between);
                next = astray.select(known.select(bottom, valley.select(lowest, limit)), next);
            }
            next = next.max(ray.lo).min(ray.hi);
            let far = (next - s).abs().gt(s.same(SAME_HEIGHT));
            let slant = fts.fma(next - s, q.ft);
            let falling = q.ft.lt(zero);
            (falls, falls_at) = (falling.select(q.ft, falls), falling.select(tau, falls_at));
            (grows, grows_at) = (falling.select(grows, q.ft), falling.select(grows_at, tau));
            let crossed = falls_at.gt(grows_at);
            grows = (crossed & falling).select(zero, grows);
            falls = (crossed & !falling).select(zero, falls);
            let step = tau - slant / ftt.max(s.same(LEAST_IN_TIME));
            let both = falls.lt(zero) & grows.gt(zero) & !far;
            let between = step.gt(falls_at) & step.lt(grows_at);
            let secant = falls_at + (grows_at - falls_at) * falls / both.select(falls - grows, one);
            let time = (both & !between).select(secant, step).max(zero).min(one);
            // What this height says about the time is worth nothing far from it.
            (falls, grows) = (far.select(zero, falls), far.select(zero, grows));
            (falls_at, grows_at) = (far.select(zero, falls_at), far.select(one, grows_at));
            tau = (active & !settled).select(time, tau);
        }
        s = active.select(next.max(ray.lo).min(ray.hi), s);
    }
    found
}
