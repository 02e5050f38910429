//! Arithmetic on several rays at once.
//!
//! [`L`] holds as many numbers as the processor works on in one instruction, [`Mask`] as many conditions; `pulp` chooses the
//! instructions at run time. Only operations that IEEE 754 rounds exactly are offered (no fused multiplication and addition, no
//! reciprocal estimates, no sums across lanes), so each lane has the same bits on any processor, whatever its neighbors are.
//!
//! Everything that works on lanes must be a function with `#[inline(always)]`: a closure, or anything of the standard library
//! that takes one, is compiled without the instructions and then called for every single operation.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use pulp::{Simd, WithSimd};

/// One number a lane.
#[derive(Clone, Copy)]
pub(crate) struct L<S: Simd> {
    simd: S,
    pub v: S::f64s,
}

/// One condition a lane.
#[derive(Clone, Copy)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    m: S::m64s,
}

/// Three numbers a lane: (ray, u, v).
pub(crate) type L3<S> = [L<S>; 3];

impl<S: Simd> L<S> {
    #[inline(always)]
    pub(crate) fn of(simd: S, v: S::f64s) -> Self {
        Self { simd, v }
    }

    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        Self { simd, v: simd.splat_f64s(x) }
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
        Self { v: self.simd.sqrt_f64s(self.v), ..self }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { v: self.simd.abs_f64s(self.v), ..self }
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
        Mask { simd: self.simd, m: self.simd.less_than_f64s(self.v, other.v) }
    }

    #[inline(always)]
    pub(crate) fn le(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_or_equal_f64s(self.v, other.v) }
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
                Self { v: self.simd.$call(self.v, other.v), ..self }
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
        Self { v: self.simd.neg_f64s(self.v), ..self }
    }
}

impl<S: Simd> Mask<S> {
    /// `yes` where the condition holds, `no` elsewhere.
    #[inline(always)]
    pub(crate) fn select(self, yes: L<S>, no: L<S>) -> L<S> {
        L { simd: self.simd, v: self.simd.select_f64s(self.m, yes.v, no.v) }
    }

    #[inline(always)]
    pub(crate) fn select3(self, yes: L3<S>, no: L3<S>) -> L3<S> {
        [self.select(yes[0], no[0]), self.select(yes[1], no[1]), self.select(yes[2], no[2])]
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        let (no, yes) = (self.simd.splat_f64s(0.0), self.simd.splat_f64s(1.0));
        self.simd.reduce_max_f64s(self.simd.select_f64s(self.m, yes, no)) > 0.0
    }
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self { m: self.simd.and_m64s(self.m, other.m), ..self }
    }
}

impl<S: Simd> BitOr for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self { m: self.simd.or_m64s(self.m, other.m), ..self }
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self { m: self.simd.not_m64s(self.m), ..self }
    }
}

#[inline(always)]
pub(crate) fn dot<S: Simd>(a: L3<S>, b: L3<S>) -> L<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a + k d.
#[inline(always)]
pub(crate) fn along<S: Simd>(a: L3<S>, d: L3<S>, k: L<S>) -> L3<S> {
    [a[0] + k * d[0], a[1] + k * d[1], a[2] + k * d[2]]
}

#[inline(always)]
pub(crate) fn scale<S: Simd>(a: L3<S>, k: L<S>) -> L3<S> {
    [a[0] * k, a[1] * k, a[2] * k]
}

#[inline(always)]
pub(crate) fn cross<S: Simd>(a: L3<S>, b: L3<S>) -> L3<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Rays that one call works on at most.
pub(crate) const LANES: usize = 64;
/// Numbers that the widest processor takes at once.
const WIDEST: usize = 8;

/// What is known of a lane: nothing is taken, one interval is taken, or the kernel could not prove its answer and the ray must
/// be searched (see `ray_translate`, `ray_turn`).
pub(crate) const NOTHING: f64 = 0.0;
pub(crate) const TAKEN: f64 = 1.0;
pub(crate) const UNPROVEN: f64 = 2.0;

/// Intervals of material and what a moving body takes of them, one array a quantity.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes {
    n: usize,
    pub u: [f64; LANES],
    pub v: [f64; LANES],
    /// The material that is of interest, mm.
    pub lo: [f64; LANES],
    pub hi: [f64; LANES],
    pub state: [f64; LANES],
    /// The interval taken up, mm; cut off anywhere outside of `lo..=hi`.
    pub from: [f64; LANES],
    pub to: [f64; LANES],
    /// Outward normals of the body at both ends, (ray, u, v).
    pub from_normal: [[f64; LANES]; 3],
    pub to_normal: [[f64; LANES]; 3],
    /// Both packed coordinates of the stock's normal below the interval and above it; see [`Packing`].
    pub from_code: [[f64; LANES]; 2],
    pub to_code: [[f64; LANES]; 2],
    /// Tile ray of the lane.
    pub ray: [u8; LANES],
}

impl Default for Lanes {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            n: 0,
            u: zero,
            v: zero,
            lo: zero,
            hi: zero,
            state: zero,
            from: zero,
            to: zero,
            from_normal: [zero; 3],
            to_normal: [zero; 3],
            from_code: [zero; 2],
            to_code: [zero; 2],
            ray: [0; LANES],
        }
    }
}

impl Lanes {
    pub(crate) fn len(&self) -> usize {
        self.n
    }

    pub(crate) fn is_full(&self) -> bool {
        self.n == LANES
    }

    pub(crate) fn clear(&mut self) {
        self.n = 0;
    }

    /// Adds an interval of material; nothing happens when all lanes are in use.
    #[inline]
    pub(crate) fn push(&mut self, ray: usize, u: f64, v: f64, lo: f64, hi: f64) {
        if self.n < LANES {
            let k = self.n;
            (self.u[k], self.v[k], self.lo[k], self.hi[k]) = (u, v, lo, hi);
            self.state[k] = NOTHING;
            self.ray[k] = ray as u8;
            self.n += 1;
        }
    }

    /// Adds lanes of another set as they were before any body came.
    pub(crate) fn copy(&mut self, from: &Self, lanes: std::ops::Range<usize>) {
        for k in lanes {
            self.push(usize::from(from.ray[k]), from.u[k], from.v[k], from.lo[k], from.hi[k]);
        }
    }

    /// Fills the last vector with copies of the last lane, so that no lane has numbers left over from before.
    pub(crate) fn pad(&mut self) {
        let Some(last) = self.n.checked_sub(1) else { return };
        for k in self.n..self.n.next_multiple_of(WIDEST).min(LANES) {
            (self.u[k], self.v[k], self.lo[k], self.hi[k]) = (self.u[last], self.v[last], self.lo[last], self.hi[last]);
            self.state[k] = NOTHING;
        }
    }
}

/// Vector `g` of an array.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, x: &[f64; LANES], g: usize) -> L<S> {
    L::of(simd, S::as_simd_f64s(x).0[g])
}

/// Writes where the condition holds.
#[inline(always)]
pub(crate) fn put<S: Simd>(simd: S, g: usize, x: &mut [f64; LANES], m: Mask<S>, value: L<S>) {
    let place = &mut S::as_mut_simd_f64s(x).0[g];
    *place = m.select(value, L::of(simd, *place)).v;
}

#[inline(always)]
fn put3<S: Simd>(simd: S, g: usize, x: &mut [[f64; LANES]; 3], m: Mask<S>, value: L3<S>) {
    let [a, b, c] = x;
    put(simd, g, a, m, value[0]);
    put(simd, g, b, m, value[1]);
    put(simd, g, c, m, value[2]);
}

/// Adds the interval `from..to` where `hit` holds to what a lane has, or gives the lane up when the two do not meet.
#[inline(always)]
pub(crate) fn join<S: Simd>(
    simd: S,
    lanes: &mut Lanes,
    g: usize,
    hit: Mask<S>,
    ends: [L<S>; 2],
    normals: [L3<S>; 2],
    sliver: f64,
) {
    let state = load(simd, &lanes.state, g);
    let (nothing, taken) = (state.same(NOTHING), state.same(TAKEN));
    let fresh = hit & state.le(nothing);
    let more = hit & state.ge(taken) & state.le(taken);
    let (from, to) = (load(simd, &lanes.from, g), load(simd, &lanes.to, g));
    let gap = state.same(sliver);
    let meets = ends[0].le(to + gap) & ends[1].ge(from - gap);
    let lower = fresh | (more & meets & ends[0].lt(from));
    let upper = fresh | (more & meets & ends[1].gt(to));
    let apart = more & !meets;
    put(simd, g, &mut lanes.state, hit, apart.select(state.same(UNPROVEN), fresh.select(taken, state)));
    put(simd, g, &mut lanes.from, lower, ends[0]);
    put(simd, g, &mut lanes.to, upper, ends[1]);
    put3(simd, g, &mut lanes.from_normal, lower, normals[0]);
    put3(simd, g, &mut lanes.to_normal, upper, normals[1]);
}

/// Packs the normals of all lanes for `Mark::packed`: turned round, since the material lies on the other side of the surface,
/// and in the order x, y, z for rays of the set `axis`.
pub(crate) struct Packing<'a> {
    pub lanes: &'a mut Lanes,
    pub axis: usize,
}

impl WithSimd for Packing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, axis } = self;
        for g in 0..lanes.len().div_ceil(S::F64_LANES) {
            let taken = load(simd, &lanes.state, g);
            if !taken.ge(taken.same(TAKEN)).any() {
                continue;
            }
            pack(simd, g, axis, &lanes.from_normal, &mut lanes.from_code);
            pack(simd, g, axis, &lanes.to_normal, &mut lanes.to_code);
        }
    }
}

/// Largest value of one octahedral coordinate, as in `span`.
const FULL: f64 = 32767.0;
/// 1.5 * 2^52: added to a small number it leaves the nearest integer in the last bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

#[inline(always)]
fn pack<S: Simd>(simd: S, g: usize, axis: usize, normal: &[[f64; LANES]; 3], code: &mut [[f64; LANES]; 2]) {
    let x = -load(simd, &normal[(3 - axis) % 3], g);
    let y = -load(simd, &normal[(4 - axis) % 3], g);
    let z = -load(simd, &normal[(5 - axis) % 3], g);
    let (zero, one) = (x.same(0.0), x.same(1.0));
    let sum = x.abs() + y.abs() + z.abs();
    let per_sum = one / sum.gt(zero).select(sum, one);
    let (a, b) = (x * per_sum, y * per_sum);
    let down = z.lt(zero);
    let (a_sign, b_sign) = (a.lt(zero).select(-one, one), b.lt(zero).select(-one, one));
    let c = down.select((one - b.abs()) * a_sign, a);
    let d = down.select((one - a.abs()) * b_sign, b);
    let [first, second] = code;
    S::as_mut_simd_f64s(first).0[g] = (c * x.same(FULL) + x.same(ROUND)).v;
    S::as_mut_simd_f64s(second).0[g] = (d * x.same(FULL) + x.same(ROUND)).v;
}
