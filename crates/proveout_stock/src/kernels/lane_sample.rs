//! The function of a body and its derivatives for many rays at once.

use pulp::Simd;

use crate::{
    kernels::lanes::{L, L3, along, cross, dot, scale},
    kernels::meridian::{AT_CENTER, Meridian, MeridianPiece, Quarter},
    kernels::motion::{MotionPiece, ON_AXIS},
    kernels::vec3,
};

/// Square of the way over a piece below which a place hardly moves, mm^2.
const STANDS: f64 = 1e-12;

/// The piece of motion in all lanes.
#[derive(Clone, Copy)]
pub(crate) struct LaneMotion<S: Simd> {
    pub tip: L3<S>,
    pub travel: L3<S>,
    pub axis: L3<S>,
    pub turn: L3<S>,
    pub omega: L3<S>,
    pub angle2: L<S>,
    /// D of (1).
    pub third: L<S>,
}

impl<S: Simd> LaneMotion<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, piece: &MotionPiece, body: &Meridian) -> Self {
        let angle = piece.angle2.sqrt();
        let third = piece.angle2 * (angle * body.reach + 3.0 * vec3::norm(piece.travel)) / 6.0;
        Self {
            tip: L::splat3(simd, piece.tip),
            travel: L::splat3(simd, piece.travel),
            axis: L::splat3(simd, piece.axis),
            turn: L::splat3(simd, piece.turn),
            omega: L::splat3(simd, vec3::cross(piece.axis, piece.turn)),
            angle2: L::splat(simd, piece.angle2),
            third: L::splat(simd, third),
        }
    }
}

/// F and its derivatives.
#[derive(Clone, Copy)]
pub(crate) struct LaneSample<S: Simd> {
    pub f: L<S>,
    pub fs: L<S>,
    pub ft: L<S>,
    pub normal: L3<S>,
    /// From the tip to the point, and the part of it across the axis.
    pub y: L3<S>,
    p: L3<S>,
    per_r: L<S>,
    axis: L3<S>,
    /// Height of the point above the tip.
    pub z: L<S>,
    fr: L<S>,
    fz: L<S>,
    km: L<S>,
    /// Curvature round the axis.
    pub kr: L<S>,
}

/// Lower bound of the distance of a point outside the body at any time, by half spaces with the
/// unit normal `n`, which is fixed in space; `y`: from the tip at the time `tau` to the point.
///
/// A point of the body at the distance X from the tip that turns by the angle w leaves the chord of its way
/// by at most w^2 X / 8. The body lies in the hull of its tubes (see `meridian`), so its support on its way
/// is at most the largest, over the tubes, of those at both ends of the motion and that.
#[inline(always)]
pub(crate) fn clearance<S: Simd, const TURNS: bool>(
    motion: &LaneMotion<S>,
    body: &Meridian,
    n: L3<S>,
    y: L3<S>,
    tau: L<S>,
) -> L<S> {
    let (zero, one) = (tau.same(0.0), tau.same(1.0));
    let c0 = dot(n, motion.axis);
    let sine0 = c0.fma_from(c0, one).max(zero).sqrt();
    let (c1, sine1) = if TURNS {
        let c1 = dot(n, along(motion.axis, motion.turn, one));
        (c1, c1.fma_from(c1, one).max(zero).sqrt())
    } else {
        (c0, sine0)
    };
    let here = dot(n, y);
    let way = dot(n, motion.travel);
    let (start, end) = (tau.fma(way, here), (one - tau).fma_from(way, here));
    let bend = motion.angle2 * zero.same(0.125);
    let mut least = zero.same(f64::INFINITY);
    for [r, z, radius, reach] in &body.tubes {
        let (r, z) = (zero.same(*r), zero.same(*z));
        let nearest = if TURNS {
            let (start, end) = (sine0.fma_from(r, c0.fma_from(z, start)), sine1.fma_from(r, c1.fma_from(z, end)));
            bend.fma_from(zero.same(*reach), start.min(end))
        } else {
            sine0.fma_from(r, c0.fma_from(z, start.min(end)))
        };
        least = least.min(nearest - zero.same(*radius));
    }
    least
}

impl<S: Simd> LaneSample<S> {
    /// The normal turned to be perpendicular to the ray: the half space then says the same about all of the
    /// ray. Where the normal runs along the ray, it stays.
    #[inline(always)]
    pub(crate) fn normal_across(&self) -> L3<S> {
        let n = self.normal;
        let across = n[1].fma(n[1], n[2] * n[2]).sqrt();
        let enough = across.gt(across.same(0.1));
        let per_across = across.same(1.0) / enough.select(across, across.same(1.0));
        [enough.select(across.same(0.0), n[0]), n[1] * per_across, n[2] * per_across]
    }
}

/// The body's function at a height of the ray and a time; see `MotionPiece::sample` for the first
/// derivatives.
#[inline(always)]
pub(crate) fn sample<S: Simd, const TURNS: bool>(
    motion: &LaneMotion<S>,
    body: &Meridian,
    ray: &LaneRays<S>,
    s: L<S>,
    tau: L<S>,
) -> LaneSample<S> {
    let (zero, one) = (s.same(0.0), s.same(1.0));
    let axis = if TURNS {
        let x = tau * (one - tau) * motion.angle2;
        scale(along(motion.axis, motion.turn, tau), x.fma(x.fma(s.same(0.375), s.same(0.5)), one))
    } else {
        motion.axis
    };
    let tip = along(motion.tip, motion.travel, tau);
    let y = [s - tip[0], ray.u - tip[1], ray.v - tip[2]];
    let z = dot(y, axis);
    let p = [z.fma_from(axis[0], y[0]), z.fma_from(axis[1], y[1]), z.fma_from(axis[2], y[2])];
    let r = dot(p, p).sqrt();
    let per_r = r.gt(s.same(ON_AXIS)).select(one / r, zero);
    let MeridianValue { f, fr, fz, km } = function(body, r, z);
    let kr = fr * per_r;
    let normal = along(scale(p, kr), axis, fz);
    let mut ft = -dot(normal, motion.travel);
    if TURNS {
        ft = dot(p, motion.turn).fma(kr.fma_from(z, fz), ft);
    }
    LaneSample { f, fs: normal[0], ft, normal, y, p, per_r, axis, z, fr, fz, km, kr }
}

impl<S: Simd> LaneSample<S> {
    /// The velocity of the body at the point, by the chord of its turn.
    #[inline(always)]
    pub(crate) fn velocity<const TURNS: bool>(&self, motion: &LaneMotion<S>) -> L3<S> {
        let v = motion.travel;
        if !TURNS {
            return v;
        }
        let turning = cross(motion.omega, self.y);
        [v[0] + turning[0], v[1] + turning[1], v[2] + turning[2]]
    }

    /// The normal turned to be perpendicular to the velocity, as that of the swept surface is; it stays where
    /// the body hardly moves.
    #[inline(always)]
    pub(crate) fn normal_across_way<const TURNS: bool>(&self, motion: &LaneMotion<S>) -> L3<S> {
        let v = self.velocity::<TURNS>(motion);
        let square = dot(v, v);
        let moves = square.gt(square.same(STANDS));
        let k = -dot(self.normal, v) / moves.select(square, square.same(1.0));
        let n = along(self.normal, v, k);
        // The rest of a unit normal that runs along the way is nothing.
        let length2 = dot(n, n);
        let enough = moves & length2.gt(length2.same(0.01));
        let n = scale(n, length2.same(1.0) / enough.select(length2, length2.same(1.0)).sqrt());
        enough.select3(n, self.normal)
    }

    /// Curvature of F along the ray, by the shape of the body: see [`Self::curvature`].
    #[inline(always)]
    pub(crate) fn bend_along(&self) -> L<S> {
        let (p, w) = (self.p, self.axis);
        let ts = self.fz.fma_from(p[0] * self.per_r, self.fr * w[0]);
        let a_s = w[2].fma_from(p[1], w[1] * p[2]) * self.per_r;
        (self.km * ts).fma(ts, self.kr * a_s * a_s)
    }

    /// Curvature of F with time, with time and height, and with height, by the shape of the body alone.
    ///
    /// With v the velocity of the point against the body, t the tangent of the meridian and a the unit vector
    /// round the axis, `F_tautau = km (t . v)^2 + kr (a . v)^2` and `F_taus = km (t . v) t_s + kr (a . v)
    /// a_s`, but for the turning of the frame.
    #[inline(always)]
    pub(crate) fn curvature<const TURNS: bool>(&self, motion: &LaneMotion<S>) -> [L<S>; 3] {
        let (p, w) = (self.p, self.axis);
        let velocity = self.velocity::<TURNS>(motion);
        // The sign of the velocity: the body moves, the point is fixed.
        let (pv, wv) = (-dot(p, velocity) * self.per_r, -dot(w, velocity));
        let tv = self.fz.fma_from(pv, self.fr * wv);
        let ts = self.fz.fma_from(p[0] * self.per_r, self.fr * w[0]);
        let round = cross(w, p);
        let av = -dot(round, velocity) * self.per_r;
        let a_s = round[0] * self.per_r;
        let (along_meridian, around) = (self.km * tv, self.kr * av);
        let bend = (self.km * ts).fma(ts, self.kr * a_s * a_s);
        [along_meridian.fma(tv, around * av), along_meridian.fma(ts, around * a_s), bend]
    }
}

/// Value, gradient (d/dr, d/dz) and curvature along the meridian of the body's function; see `meridian`.
#[inline(always)]
fn function<S: Simd>(body: &Meridian, r: L<S>, z: L<S>) -> MeridianValue<S> {
    let zero = r.same(0.0);
    let mut best = MeridianValue { f: r.same(f64::NEG_INFINITY), fr: zero, fz: r.same(1.0), km: zero };
    if let Some(quarter) = &body.quarter {
        best = quarter_of(quarter, r, z);
        if !z.gt(r.same(quarter.alone_below)).any() {
            return best;
        }
    }
    for part in &body.others {
        match *part {
            MeridianPiece::Line { nr, nz, c } => {
                let (fr, fz) = (r.same(nr), r.same(nz));
                best = best.or(MeridianValue { f: fr.fma(r, fz.fma(z, r.same(-c))), fr, fz, km: zero });
            }
            MeridianPiece::Arc { center, radius, first, last } => {
                let (x, y) = (r - r.same(center[0]), z - r.same(center[1]));
                let (f0, f1) = (r.same(first[0]), r.same(first[1]));
                let (l0, l1) = (r.same(last[0]), r.same(last[1]));
                let square = x.fma(x, y * y);
                let sector = (f0 * y).ge(f1 * x) & (x * l1).ge(y * l0) & square.gt(r.same(AT_CENTER));
                let length = square.sqrt();
                let per_length = r.same(1.0) / length;
                let (a, b) = (f0.fma(x, f1 * y), l0.fma(x, l1 * y));
                let low = a.gt(b);
                best = best.or(MeridianValue {
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

/// The same of a quarter of a circle, from straight down to straight out.
#[inline(always)]
fn quarter_of<S: Simd>(quarter: &Quarter, r: L<S>, z: L<S>) -> MeridianValue<S> {
    let (zero, one) = (r.same(0.0), r.same(1.0));
    let (x, y) = (r - r.same(quarter.center[0]), z - r.same(quarter.center[1]));
    let square = x.fma(x, y * y);
    let sector = x.ge(zero) & y.le(zero) & square.gt(r.same(AT_CENTER));
    let length = square.sqrt();
    let per_length = one / length;
    let low = (-y).gt(x);
    MeridianValue {
        f: sector.select(length, low.select(-y, x)) - r.same(quarter.radius),
        fr: sector.select(x * per_length, low.select(zero, one)),
        fz: sector.select(y * per_length, low.select(-one, zero)),
        km: sector.select(per_length, zero),
    }
}

/// Value, gradient (d/dr, d/dz) and curvature along the meridian.
#[derive(Clone, Copy)]
struct MeridianValue<S: Simd> {
    f: L<S>,
    fr: L<S>,
    fz: L<S>,
    km: L<S>,
}

impl<S: Simd> MeridianValue<S> {
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

/// Rays with the material that is of interest.
#[derive(Clone, Copy)]
pub(crate) struct LaneRays<S: Simd> {
    pub u: L<S>,
    pub v: L<S>,
    pub lo: L<S>,
    pub hi: L<S>,
}
