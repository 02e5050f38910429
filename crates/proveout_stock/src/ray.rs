//! What the three kernels of the sweep have in common.

use crate::vec3::V;

/// A body point with a function value up to this (mm) counts as reached: half of what the body was made smaller by, so
/// that touching never counts.
pub(crate) const REACHED: f64 = 0.5 * crate::meridian::TOUCH;

/// The line of a ray and the part of it that holds material; everything outside of `lo..=hi` is of no interest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub u: f64,
    pub v: f64,
    pub lo: f64,
    pub hi: f64,
}

impl Ray {
    #[inline]
    pub(crate) fn at(&self, s: f64) -> V {
        [s, self.u, self.v]
    }
}

/// One end of the interval that a moving body takes up on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    pub s: f64,
    /// Outward normal of the body there, (ray, u, v).
    pub normal: V,
}

/// Interval that a moving body takes up on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taken {
    pub lo: End,
    pub hi: End,
}
