//! Three components in registers: the inner loop of the sweep, fast in every build profile.

pub(crate) type V = [f64; 3];

#[inline]
pub(crate) fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(crate) fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(crate) fn scale(a: V, k: f64) -> V {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// a + k d.
#[inline]
pub(crate) fn along(a: V, d: V, k: f64) -> V {
    [a[0] + k * d[0], a[1] + k * d[1], a[2] + k * d[2]]
}

#[inline]
pub(crate) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(crate) fn norm(a: V) -> f64 {
    dot(a, a).sqrt()
}
