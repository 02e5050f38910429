//! Sweep of any convex body for many rays at once: Newton's method on the envelope, with a proof for each ray.
//!
//! An end of the interval that a moving body takes up on a ray is a point (tau, s) with `F = 0` and `F_tau = 0`, or `F = 0` at the
//! beginning or end of the motion. Newton's method on this pair finds it in a few steps; curvatures of the body are known in
//! closed form, `kr = F_r / r` round the axis and `km` along the meridian. What the search found is accepted only with a proof by
//! a supporting half space, as in `ray_turn`:
//!
//! ```text
//!                 .---- F >= f + F_tau dtau + F_s ds - ...   at all other times: the body is nowhere deeper than
//!      s ^       /      the deficit beyond the end found
//!        |  ...-*-...
//!        | /    |    \       straight motion: F is convex in both, the linear terms are all
//!        |/     |     \      turning: (1) of `ray_turn`, or the half space held fixed in space: a point of the body
//!        +-----tau*----->    leaves the chord of its way by no more than angle^2 reach / 8, so both ends of the motion
//!                            bound all of it
//! ```
//!
//! A ray that the body misses is proven by the same inequality: F > 0 at a point, and growing towards all of the material; or
//! by two points on both sides of the minimum along the ray. Lanes without proof after [`STEPS`] samples get a second chance in
//! quarters of a turning motion; what is left, such as rays that meet the rim of a flat end mill, is searched by
//! `ray_translate` and `ray_turn`, which always end. The bounds are the same: [`SEARCH_ERROR`] for a straight motion and
//! [`TURN_ERROR`] more for one that turns.

use pulp::{Simd, WithSimd};

use crate::{
    lanes::{L, L3, Lanes, Mask, UNPROVEN, along, cross, dot, join, load, put, scale},
    meridian::{Meridian, Piece as Part},
    motion::{Piece, SEARCH_ERROR, TURN_ERROR},
    ray::REACHED,
    span::SLIVER,
    vec3,
};

/// Samples of one search.
const STEPS: usize = 9;
/// An end counts as found when F is this near to zero (mm); a last step of Newton's method follows, so what remains is of
/// second order.
const FLAT: f64 = 1e-5;
/// Least slope of F along the ray at an end: steeper grazing goes to the searches.
const GRAZING: f64 = 0.004;

/// A body on one piece of motion, for all lanes.
pub(crate) struct BodyOnLanes<'a> {
    pub piece: &'a Piece,
    pub body: &'a Meridian,
    pub lanes: &'a mut Lanes,
}

impl WithSimd for BodyOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.piece.turns() {
            sweep::<S, true>(simd, self.piece, self.body, self.lanes);
        } else {
            sweep::<S, false>(simd, self.piece, self.body, self.lanes);
        }
    }
}

/// The piece of motion in all lanes.
#[derive(Clone, Copy)]
struct Motion<S: Simd> {
    tip: L3<S>,
    travel: L3<S>,
    axis: L3<S>,
    turn: L3<S>,
    omega: L3<S>,
    angle2: L<S>,
    /// D of (1).
    third: L<S>,
}

/// F and its derivatives.
#[derive(Clone, Copy)]
struct Sample<S: Simd> {
    f: L<S>,
    fs: L<S>,
    ft: L<S>,
    normal: L3<S>,
    /// Curvature of F with time, and with time and height, by the shape of the body alone.
    ftt: L<S>,
    fts: L<S>,
    /// From the tip to the point.
    y: L3<S>,
}

/// What a search found, one condition each; none of them: no proof.
#[derive(Clone, Copy)]
struct Found<S: Simd> {
    /// The body covers the end of the material at some time.
    covered: Mask<S>,
    /// An end inside of the material.
    end: Mask<S>,
    /// The body does not meet the material.
    miss: Mask<S>,
    s: L<S>,
    tau: L<S>,
    f: L<S>,
    fs: L<S>,
    normal: L3<S>,
}

/// A sample outside of the body.
#[derive(Clone, Copy)]
struct Side<S: Simd> {
    s: L<S>,
    f: L<S>,
    fs: L<S>,
    deficit: L<S>,
}

impl<S: Simd> Side<S> {
    #[inline(always)]
    fn set(&mut self, at: Mask<S>, new: Self) {
        self.s = at.select(new.s, self.s);
        self.f = at.select(new.f, self.f);
        self.fs = at.select(new.fs, self.fs);
        self.deficit = at.select(new.deficit, self.deficit);
    }
}

#[derive(Clone, Copy)]
struct Ray<S: Simd> {
    u: L<S>,
    v: L<S>,
    lo: L<S>,
    hi: L<S>,
}

#[inline(always)]
fn sweep<S: Simd, const TURNS: bool>(simd: S, piece: &Piece, body: &Meridian, lanes: &mut Lanes) {
    let angle = piece.angle2.sqrt();
    let third = piece.angle2 * (angle * body.reach + 3.0 * vec3::norm(piece.travel)) / 6.0;
    let motion = Motion {
        tip: L::splat3(simd, piece.tip),
        travel: L::splat3(simd, piece.travel),
        axis: L::splat3(simd, piece.axis),
        turn: L::splat3(simd, piece.turn),
        omega: L::splat3(simd, vec3::cross(piece.axis, piece.turn)),
        angle2: L::splat(simd, piece.angle2),
        third: L::splat(simd, third),
    };
    let zero = L::splat(simd, 0.0);
    for g in 0..lanes.len().div_ceil(S::F64_LANES) {
        let ray = Ray {
            u: load(simd, &lanes.u, g),
            v: load(simd, &lanes.v, g),
            lo: load(simd, &lanes.lo, g),
            hi: load(simd, &lanes.hi, g),
        };
        let state = load(simd, &lanes.state, g);
        let wanted = state.lt(state.same(UNPROVEN));
        if !wanted.any() {
            continue;
        }
        let above = search::<S, TURNS>(&motion, body, &ray, 1.0, (ray.hi, zero.same(0.5)), wanted);
        let met = above.covered | above.end;
        let mut hit = met;
        let mut below = above;
        if met.any() {
            // From a point inside of the body Newton's method steps out of it, below its lower end.
            let jump = above.covered & above.fs.lt(zero.same(-0.05));
            let step = jump.select(above.f / above.fs, zero);
            let start = jump.select((ray.hi - step).max(ray.lo).min(ray.hi), ray.lo);
            below = search::<S, TURNS>(&motion, body, &ray, -1.0, (start, above.tau), met);
            hit = met & (below.covered | below.end);
        }
        let (to, from) = (above.covered.select(ray.hi, above.s), below.covered.select(ray.lo, below.s));
        if TURNS && hit.any() {
            // The union is one interval if the body makes both ends with a point in common.
            let apart = hit & (below.tau.lt(above.tau) | below.tau.gt(above.tau));
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
            join(simd, lanes, g, hit, [from, to], [below.normal, above.normal], SLIVER);
        }
        if unproven.any() {
            put(simd, g, &mut lanes.state, unproven, zero.same(UNPROVEN));
        }
    }
}

/// Upper (`sign` 1) or lower (-1) end of the interval, from a start (height, time).
#[inline(always)]
fn search<S: Simd, const TURNS: bool>(
    motion: &Motion<S>,
    body: &Meridian,
    ray: &Ray<S>,
    sign: f64,
    start: (L<S>, L<S>),
    wanted: Mask<S>,
) -> Found<S> {
    let (mut s, mut tau) = start;
    let (zero, one) = (s.same(0.0), s.same(1.0));
    let outward = s.same(sign);
    let limit = if sign > 0.0 { ray.hi } else { ray.lo };
    let allowed = if TURNS { s.same(SEARCH_ERROR + TURN_ERROR) } else { s.same(SEARCH_ERROR) };
    let none = !wanted & wanted;
    let mut found = Found { covered: none, end: none, miss: none, s, tau, f: zero, fs: zero, normal: [zero; 3] };
    let mut active = wanted;
    // Samples outside of the body between which F has its minimum along the ray.
    let mut rising = Side { s: zero, f: zero, fs: zero, deficit: zero };
    let mut sinking = rising;
    // Times at which F falls and grows, with F_tau there; 0: none yet.
    let (mut falls, mut falls_at) = (zero, zero);
    let (mut grows, mut grows_at) = (zero, one);
    for _ in 0..STEPS {
        let q = sample::<S, TURNS>(motion, body, ray, s, tau);
        let (left, right) = (tau, one - tau);
        let (mut before, mut after) = ((left * q.ft).max(zero), (right * -q.ft).max(zero));
        let mut slope = zero;
        if TURNS {
            let carried = cross(motion.omega, q.normal);
            let second = dot(motion.omega, q.normal) * dot(motion.omega, q.y)
                - motion.angle2 * dot(q.normal, q.y)
                - s.same(2.0) * dot(carried, motion.travel);
            let bend = s.same(0.5) * (-second).max(zero);
            before = (left * (left * (bend + motion.third * left) + q.ft)).max(zero);
            after = (right * (right * (bend + motion.third * right) - q.ft)).max(zero);
            let far = left.max(right);
            slope = carried[0].abs() * far + s.same(0.5) * motion.angle2 * far * far;
        }
        let mut deficit = before.max(after);
        let near = q.f.abs().le(s.same(FLAT));
        if TURNS {
            let open = active & (near | q.f.gt(zero)) & deficit.gt(allowed);
            if open.any() {
                let fixed = fixed_half_space(motion, body, &q, tau);
                let better = open & fixed.lt(deficit);
                deficit = better.select(fixed, deficit);
                slope = better.select(zero, slope);
            }
        }
        let inside = q.f.le(s.same(REACHED));
        let covered = active & inside & s.ge(limit) & s.le(limit);
        let steep = q.fs.abs();
        let up = q.fs.gt(zero);
        let (above, below) = (ray.hi - s, s - ray.lo);
        let (toward, away) = (up.select(above, below), up.select(below, above));
        let least = q.f - deficit - (steep + slope) * away - (slope - steep).max(zero) * toward;
        let mut miss = active & !inside & least.ge(-allowed);
        let here = Side { s, f: q.f, fs: q.fs, deficit: deficit + slope * (ray.hi - ray.lo) };
        rising.set(active & !inside & up, here);
        sinking.set(active & !inside & !up, here);
        let valley = rising.fs.gt(zero) & sinking.fs.lt(zero) & rising.s.gt(sinking.s) & !inside;
        let mut lowest = s;
        if (active & valley & !miss).any() {
            // Both tangents bound F from below; where they cross the bound is least.
            let per_slope = one / valley.select(rising.fs - sinking.fs, one);
            lowest = (sinking.fs * sinking.s - rising.fs * rising.s + rising.f - sinking.f) * -per_slope;
            let bound = rising.f + rising.fs * (lowest - rising.s);
            miss = miss | (active & valley & (bound - rising.deficit.max(sinking.deficit)).ge(-allowed));
        }
        let rise = q.fs * outward;
        let end = active
            & near
            & !covered
            & !miss
            & (deficit + s.same(FLAT)).le(allowed)
            & rise.ge(s.same(GRAZING).max(slope));
        let done = covered | miss | end;
        if done.any() {
            let at = end.select(s - q.f / end.select(q.fs, one), s);
            found.covered = found.covered | covered;
            found.miss = found.miss | miss;
            found.end = found.end | end;
            found.s = done.select(at, found.s);
            found.tau = done.select(tau, found.tau);
            found.f = done.select(q.f, found.f);
            found.fs = done.select(q.fs, found.fs);
            found.normal = done.select3(q.normal, found.normal);
            active = active & !done;
            if !active.any() {
                break;
            }
        }
        // Next height: out of the body, or down to it; where F does not fall that way only the time can help.
        let turned = rise.le(s.same(1e-9));
        let deep = inside & turned;
        let stay = !inside & turned;
        let newton = s - q.f / turned.select(one, q.fs);
        let still = valley.select(lowest, s);
        let next = deep.select(limit, stay.select(still, newton)).max(ray.lo).min(ray.hi);
        let slant = q.ft + q.fts * (next - s);
        let falling = q.ft.lt(zero);
        (falls, falls_at) = (falling.select(q.ft, falls), falling.select(tau, falls_at));
        (grows, grows_at) = (falling.select(grows, q.ft), falling.select(grows_at, tau));
        let crossed = falls_at.gt(grows_at);
        grows = (crossed & falling).select(zero, grows);
        falls = (crossed & !falling).select(zero, falls);
        let step = tau - slant / q.ftt.max(s.same(1e-9));
        let both = falls.lt(zero) & grows.gt(zero);
        let between = step.gt(falls_at) & step.lt(grows_at);
        let secant = falls_at + (grows_at - falls_at) * falls / both.select(falls - grows, one);
        let time = (both & !between).select(secant, step).max(zero).min(one);
        s = active.select(next, s);
        tau = active.select(time, tau);
    }
    found
}

/// How much deeper the body may be at other times than its sample says, by the half space of the sample held fixed in space.
///
/// A point X of the body that turns by the angle w leaves the chord of its way by at most w^2 |X| / 8, so the support of the
/// moving body is at most the larger of those at both ends of the motion and that.
#[inline(always)]
fn fixed_half_space<S: Simd>(motion: &Motion<S>, body: &Meridian, q: &Sample<S>, tau: L<S>) -> L<S> {
    let zero = q.f.same(0.0);
    let first = motion.axis;
    let last = along(motion.axis, motion.turn, zero.same(1.0));
    let (c0, c1) = (dot(q.normal, first), dot(q.normal, last));
    let here = dot(q.normal, q.y);
    let way = dot(q.normal, motion.travel);
    let start = here + tau * way - support(body, c0);
    let end = here - (zero.same(1.0) - tau) * way - support(body, c1);
    let low = c0.max(c1).lt(zero.same(-0.05));
    let reach = low.select(zero.same(body.low_reach), zero.same(body.reach));
    q.f - start.min(end) + motion.angle2 * reach * zero.same(0.125)
}

/// Support function of the body for a unit vector with the cosine `c` to the axis.
#[inline(always)]
fn support<S: Simd>(body: &Meridian, c: L<S>) -> L<S> {
    let sine = (c.same(1.0) - c * c).max(c.same(0.0)).sqrt();
    let mut most = c.same(f64::NEG_INFINITY);
    for [r, z, radius] in &body.tubes {
        most = most.max(sine * c.same(*r) + c * c.same(*z) + c.same(*radius));
    }
    most
}

/// The body's function at a height of the ray and a time; see `Piece::sample` for the first derivatives.
///
/// With v the velocity of the point against the body, t the tangent of the meridian and a the unit vector round the axis,
/// `F_tautau = km (t . v)^2 + kr (a . v)^2` and `F_taus = km (t . v) t_s + kr (a . v) a_s`, but for the turning of the frame.
#[inline(always)]
fn sample<S: Simd, const TURNS: bool>(
    motion: &Motion<S>,
    body: &Meridian,
    ray: &Ray<S>,
    s: L<S>,
    tau: L<S>,
) -> Sample<S> {
    let (zero, one) = (s.same(0.0), s.same(1.0));
    let w = if TURNS {
        let x = tau * (one - tau) * motion.angle2;
        scale(along(motion.axis, motion.turn, tau), one + x * (s.same(0.5) + s.same(0.375) * x))
    } else {
        motion.axis
    };
    let tip = along(motion.tip, motion.travel, tau);
    let y = [s - tip[0], ray.u - tip[1], ray.v - tip[2]];
    let z = dot(y, w);
    let p = along(y, w, -z);
    let r = dot(p, p).sqrt();
    let on_axis = r.le(s.same(1e-12));
    let per_r = on_axis.select(zero, one / on_axis.select(one, r));
    let Value { f, fr, fz, km } = function(body, r, z);
    let kr = fr * per_r;
    let normal = along(scale(p, kr), w, fz);
    let mut velocity = [-motion.travel[0], -motion.travel[1], -motion.travel[2]];
    let mut ft = dot(normal, velocity);
    if TURNS {
        ft = ft + dot(p, motion.turn) * (fz - kr * z);
        let turning = cross(motion.omega, y);
        velocity = [velocity[0] - turning[0], velocity[1] - turning[1], velocity[2] - turning[2]];
    }
    let (pv, wv) = (dot(p, velocity) * per_r, dot(w, velocity));
    let tv = fr * wv - fz * pv;
    let ts = fr * w[0] - fz * p[0] * per_r;
    let round = cross(w, p);
    let av = dot(round, velocity) * per_r;
    let a_s = round[0] * per_r;
    let ftt = km * tv * tv + kr * av * av;
    let fts = km * tv * ts + kr * av * a_s;
    Sample { f, fs: normal[0], ft, normal, ftt, fts, y }
}

/// Value, gradient (d/dr, d/dz) and curvature along the meridian of the body's function; see `meridian`.
#[inline(always)]
fn function<S: Simd>(body: &Meridian, r: L<S>, z: L<S>) -> Value<S> {
    let zero = r.same(0.0);
    let mut best = Value { f: r.same(f64::NEG_INFINITY), fr: zero, fz: r.same(1.0), km: zero };
    for part in &body.pieces {
        match *part {
            Part::Line { nr, nz, c } => {
                let (fr, fz) = (r.same(nr), r.same(nz));
                best = best.or(Value { f: fr * r + fz * z - r.same(c), fr, fz, km: zero });
            }
            Part::Arc { center, radius, first, last } => {
                let (x, y) = (r - r.same(center[0]), z - r.same(center[1]));
                let (f0, f1) = (r.same(first[0]), r.same(first[1]));
                let (l0, l1) = (r.same(last[0]), r.same(last[1]));
                let square = x * x + y * y;
                let sector = (f0 * y - f1 * x).ge(zero) & (x * l1 - y * l0).ge(zero) & square.gt(r.same(1e-24));
                let length = square.sqrt();
                let per_length = r.same(1.0) / sector.select(length, r.same(1.0));
                let (a, b) = (f0 * x + f1 * y, l0 * x + l1 * y);
                let low = a.gt(b);
                best = best.or(Value {
                    f: sector.select(length, low.select(a, b)) - r.same(radius),
                    fr: sector.select(x * per_length, low.select(f0, l0)),
                    fz: sector.select(y * per_length, low.select(f1, l1)),
                    km: sector.select(per_length, zero),
                });
            }
        }
    }
    best
}

/// Value, gradient (d/dr, d/dz) and curvature along the meridian.
#[derive(Clone, Copy)]
struct Value<S: Simd> {
    f: L<S>,
    fr: L<S>,
    fz: L<S>,
    km: L<S>,
}

impl<S: Simd> Value<S> {
    /// The larger one; this one when they are equal.
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        let more = other.f.gt(self.f);
        Self {
            f: more.select(other.f, self.f),
            fr: more.select(other.fr, self.fr),
            fz: more.select(other.fz, self.fz),
            km: more.select(other.km, self.km),
        }
    }
}
