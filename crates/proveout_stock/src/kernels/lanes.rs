//! Arithmetic on several rays at once.
//!
//! [`L`] holds twice as many numbers as the processor works on in one instruction, [`Mask`] as many
//! conditions; `pulp` chooses the instructions at run time. Two vectors side by side, since every step of a
//! search waits for the one before: the second vector runs in the gaps. Only operations that IEEE 754 rounds
//! exactly are offered (no reciprocal estimates, no sums across lanes), so each lane has the same bits on any
//! processor, whatever its neighbors are. Fused multiplication and addition is one of them; a processor
//! without it (x86 before 2013) calculates it in software, slowly.
//!
//! Everything that works on lanes must be a function with `#[inline(always)]`: a closure, or anything of the
//! standard library that takes one, is compiled without the instructions and then called for every single
//! operation.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use pulp::Simd;

/// One number a lane.
#[derive(Clone, Copy)]
pub(crate) struct L<S: Simd> {
    simd: S,
    v: [S::f64s; 2],
}

/// One condition a lane.
#[derive(Clone, Copy)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    m: [S::m64s; 2],
}

/// Lanes of one [`L`].
#[inline(always)]
pub(crate) const fn width<S: Simd>() -> usize {
    2 * S::F64_LANES
}

/// Three numbers a lane: (ray, u, v).
pub(crate) type L3<S> = [L<S>; 3];

impl<S: Simd> L<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        Self { simd, v: [simd.splat_f64s(x); 2] }
    }

    #[inline(always)]
    pub(crate) fn splat3(simd: S, x: [f64; 3]) -> L3<S> {
        [Self::splat(simd, x[0]), Self::splat(simd, x[1]), Self::splat(simd, x[2])]
    }

    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn same(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self { v: [self.simd.sqrt_f64s(self.v[0]), self.simd.sqrt_f64s(self.v[1])], ..self }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { v: [self.simd.abs_f64s(self.v[0]), self.simd.abs_f64s(self.v[1])], ..self }
    }

    /// self * b + c, rounded once.
    #[inline(always)]
    pub(crate) fn fma(self, b: Self, c: Self) -> Self {
        let (s, a) = (self.simd, self.v);
        Self { v: [s.mul_add_f64s(a[0], b.v[0], c.v[0]), s.mul_add_f64s(a[1], b.v[1], c.v[1])], ..self }
    }

    /// c - self * b, rounded once.
    #[inline(always)]
    pub(crate) fn fma_from(self, b: Self, c: Self) -> Self {
        let (s, a) = (self.simd, self.v);
        Self { v: [s.negate_mul_add_f64s(a[0], b.v[0], c.v[0]), s.negate_mul_add_f64s(a[1], b.v[1], c.v[1])], ..self }
    }

    /// The larger one; `other` when they are equal.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }

    /// The smaller one; `other` when they are equal.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Mask<S> {
        let (a, b) = (self.v, other.v);
        Mask { simd: self.simd, m: [self.simd.less_than_f64s(a[0], b[0]), self.simd.less_than_f64s(a[1], b[1])] }
    }

    #[inline(always)]
    pub(crate) fn le(self, other: Self) -> Mask<S> {
        let (a, b) = (self.v, other.v);
        let le = [self.simd.less_than_or_equal_f64s(a[0], b[0]), self.simd.less_than_or_equal_f64s(a[1], b[1])];
        Mask { simd: self.simd, m: le }
    }

    #[inline(always)]
    pub(crate) fn gt(self, other: Self) -> Mask<S> {
        other.lt(self)
    }

    #[inline(always)]
    pub(crate) fn ge(self, other: Self) -> Mask<S> {
        other.le(self)
    }
}

macro_rules! operator {
    ($name:ident, $method:ident, $call:ident) => {
        impl<S: Simd> $name for L<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { v: [self.simd.$call(self.v[0], other.v[0]), self.simd.$call(self.v[1], other.v[1])], ..self }
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for L<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { v: [self.simd.neg_f64s(self.v[0]), self.simd.neg_f64s(self.v[1])], ..self }
    }
}

impl<S: Simd> Mask<S> {
    /// `yes` where the condition holds, `no` elsewhere.
    #[inline(always)]
    pub(crate) fn select(self, yes: L<S>, no: L<S>) -> L<S> {
        let first = self.simd.select_f64s(self.m[0], yes.v[0], no.v[0]);
        L { simd: self.simd, v: [first, self.simd.select_f64s(self.m[1], yes.v[1], no.v[1])] }
    }

    #[inline(always)]
    pub(crate) fn select3(self, yes: L3<S>, no: L3<S>) -> L3<S> {
        [self.select(yes[0], no[0]), self.select(yes[1], no[1]), self.select(yes[2], no[2])]
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        any(self.simd, self.simd.or_m64s(self.m[0], self.m[1]))
    }

    /// The same for the first half of the lanes and for the second.
    #[inline(always)]
    pub(crate) fn any_of_halves(self) -> [bool; 2] {
        [any(self.simd, self.m[0]), any(self.simd, self.m[1])]
    }
}

#[inline(always)]
fn any<S: Simd>(simd: S, m: S::m64s) -> bool {
    if size_of::<S::m64s>() < S::F64_LANES * size_of::<f64>() {
        return simd.first_true_m64s(m) < S::F64_LANES;
    }
    // A sum of ones is exact, and cheaper than a maximum that minds numbers that are none.
    let (no, yes) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
    simd.reduce_sum_f64s(simd.select_f64s(m, yes, no)) > 0.0
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self { m: [self.simd.and_m64s(self.m[0], other.m[0]), self.simd.and_m64s(self.m[1], other.m[1])], ..self }
    }
}

impl<S: Simd> BitOr for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self { m: [self.simd.or_m64s(self.m[0], other.m[0]), self.simd.or_m64s(self.m[1], other.m[1])], ..self }
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self { m: [self.simd.not_m64s(self.m[0]), self.simd.not_m64s(self.m[1])], ..self }
    }
}

#[inline(always)]
pub(crate) fn dot<S: Simd>(a: L3<S>, b: L3<S>) -> L<S> {
    a[0].fma(b[0], a[1].fma(b[1], a[2] * b[2]))
}

/// a + k d.
#[inline(always)]
pub(crate) fn along<S: Simd>(a: L3<S>, d: L3<S>, k: L<S>) -> L3<S> {
    [k.fma(d[0], a[0]), k.fma(d[1], a[1]), k.fma(d[2], a[2])]
}

#[inline(always)]
pub(crate) fn scale<S: Simd>(a: L3<S>, k: L<S>) -> L3<S> {
    [a[0] * k, a[1] * k, a[2] * k]
}

#[inline(always)]
pub(crate) fn cross<S: Simd>(a: L3<S>, b: L3<S>) -> L3<S> {
    [a[2].fma_from(b[1], a[1] * b[2]), a[0].fma_from(b[2], a[2] * b[0]), a[1].fma_from(b[0], a[0] * b[1])]
}

/// The smallest of some numbers; rounding plays no part in it, so the order of the lanes does not either.
#[inline(always)]
pub(crate) fn lowest<S: Simd>(simd: S, x: &[f64]) -> f64 {
    let mut least = simd.splat_f64s(f64::INFINITY);
    for &v in S::as_simd_f64s(x).0 {
        least = simd.min_f64s(v, least);
    }
    simd.reduce_min_f64s(least)
}

/// The largest of some numbers.
#[inline(always)]
pub(crate) fn highest<S: Simd>(simd: S, x: &[f64]) -> f64 {
    let mut most = simd.splat_f64s(f64::NEG_INFINITY);
    for &v in S::as_simd_f64s(x).0 {
        most = simd.max_f64s(v, most);
    }
    simd.reduce_max_f64s(most)
}

/// Vector `g` of an array whose length is a multiple of [`width`].
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, x: &[f64], g: usize) -> L<S> {
    let x = S::as_simd_f64s(x).0;
    L { simd, v: [x[2 * g], x[2 * g + 1]] }
}

/// Writes vector `g`.
#[inline(always)]
pub(crate) fn store<S: Simd>(x: &mut [f64], g: usize, value: L<S>) {
    let x = S::as_mut_simd_f64s(x).0;
    x[2 * g] = value.v[0];
    x[2 * g + 1] = value.v[1];
}

/// Writes where the condition holds.
#[inline(always)]
pub(crate) fn put<S: Simd>(g: usize, x: &mut [f64], m: Mask<S>, value: L<S>) {
    let old = load(m.simd, x, g);
    store(x, g, m.select(value, old));
}
