//! What the three kernels of the sweep have in common.

use crate::{
    kernels::meridian::Meridian,
    kernels::motion::{BodySample, MotionPiece},
    kernels::vec3::{V, add, norm, scale},
};

/// A body point with a function value up to this (mm) counts as reached: half of what the body was made
/// smaller by, so that touching never counts.
pub(crate) const REACHED: f64 = 0.5 * crate::kernels::meridian::TOUCH;

/// The line of a ray and the part of it that holds material; everything outside of `lo..=hi` is of no
/// interest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLine {
    pub u: f64,
    pub v: f64,
    pub lo: f64,
    pub hi: f64,
}

impl RayLine {
    #[inline]
    pub(crate) fn at(&self, s: f64) -> V {
        [s, self.u, self.v]
    }
}

/// One end of the interval that a moving body takes up on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TakenEnd {
    pub s: f64,
    /// When the body is there: time of the piece.
    pub tau: f64,
}

/// Interval that a moving body takes up on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TakenInterval {
    pub lo: TakenEnd,
    pub hi: TakenEnd,
}

/// A step in space that separates the two faces at an edge of a body, mm.
const EDGE_STEP: f64 = 1e-3;
/// Sums of normals that are shorter have no direction.
const SHORTEST: f64 = 1e-3;

/// Normal of the swept surface at an end at `s` that was sampled at time `tau`; `sign` 1: upper end.
///
/// On a smooth face the normal of the body is perpendicular to the velocity, and is that of the swept
/// surface. Where an edge of the body, such as the rim of a flat end mill, makes the surface, the sample is
/// that of one of the two faces; the swept surface has the normal between both that is perpendicular to the
/// velocity. `way`: bound of the motion of the body, mm.
pub(crate) fn swept_normal(
    piece: &MotionPiece,
    body: &Meridian,
    ray: &RayLine,
    (s, tau): (f64, f64),
    sign: f64,
    sample: &BodySample,
    way: f64,
) -> V {
    let mut n = sample.normal;
    if sample.ft.abs() > 0.02 * way {
        let step = (EDGE_STEP / way).min(0.5);
        let other = if sample.ft > 0.0 { tau - step } else { tau + step };
        if (0.0..=1.0).contains(&other) {
            let face = piece.sample(body, ray.at(s), other);
            if face.ft * sample.ft < 0.0 {
                let k = face.ft / (face.ft - sample.ft);
                let blend = add(scale(n, k), scale(face.normal, 1.0 - k));
                let length = norm(blend);
                if length > SHORTEST {
                    n = scale(blend, 1.0 / length);
                }
            }
        }
    }
    if n[0] * sign < 0.0 {
        let face = piece.sample(body, ray.at(s + sign * EDGE_STEP), tau);
        if face.fs * sign >= 0.0 {
            n = face.normal;
        }
    }
    n
}
