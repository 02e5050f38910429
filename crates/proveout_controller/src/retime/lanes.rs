//! Eight numbers at once: the same operation on each, so that the compiler makes vector instructions of it where the processor has
//! them (`pulp` chooses at run time). No sum runs across the lanes but in a fixed order, and nothing is fused: the same bits everywhere.
//!
//! Rows, slacks and multipliers are in single precision: half of the memory and twice as many at once. Unknowns and the system for
//! their steps are in double precision ([`Wide`]).

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// How many.
pub(super) const LANES: usize = 8;

/// Eight numbers of a kind; of single precision they are a vector of most processors, and lie as those like to.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Eight<T>(pub(super) [T; LANES]);

/// In single precision.
pub(super) type Lanes = Eight<f32>;

/// In double precision.
pub(super) type Wide = Eight<f64>;

impl<T: Copy> Eight<T> {
    #[inline(always)]
    pub(super) fn all(x: T) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    pub(super) fn with(self, o: Self, f: impl Fn(T, T) -> T) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = f(self.0[i], o.0[i]);
        }
        out
    }

    #[inline(always)]
    pub(super) fn each(self, f: impl Fn(T) -> T) -> Self {
        let mut out = self;
        for x in &mut out.0 {
            *x = f(*x);
        }
        out
    }
}

impl Wide {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn narrow(self) -> Lanes {
        let mut out = Lanes::ZERO;
        for i in 0..LANES {
            out.0[i] = self.0[i] as f32;
        }
        out
    }

    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl Lanes {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn wide(self) -> Wide {
        let mut out = Wide::ZERO;
        for i in 0..LANES {
            out.0[i] = f64::from(self.0[i]);
        }
        out
    }

    /// Whether it is so in any lane.
    #[inline(always)]
    pub(super) fn any(self, o: Self, is: impl Fn(f32, f32) -> bool) -> bool {
        let mut any = false;
        for i in 0..LANES {
            any |= is(self.0[i], o.0[i]);
        }
        any
    }

    /// The higher of two numbers; the first where the second is none.
    #[inline(always)]
    pub(super) fn higher(self, o: Self) -> Self {
        self.with(o, |a, b| if b > a { b } else { a })
    }

    #[inline(always)]
    pub(super) fn inverse(self) -> Self {
        self.each(|x| 1.0 / x)
    }

    /// The highest of all; numbers that are none do not count.
    #[inline(always)]
    pub(super) fn highest(self) -> f32 {
        self.0.iter().fold(f32::NEG_INFINITY, |m, x| if *x > m { *x } else { m })
    }
}

impl<T: Copy + Add<Output = T>> Add for Eight<T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.with(o, |a, b| a + b)
    }
}

impl<T: Copy + Add<Output = T>> AddAssign for Eight<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<T: Copy + Sub<Output = T>> Sub for Eight<T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.with(o, |a, b| a - b)
    }
}

impl<T: Copy + Mul<Output = T>> Mul for Eight<T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.with(o, |a, b| a * b)
    }
}

impl<T: Copy + Mul<Output = T>> Mul<T> for Eight<T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: T) -> Self {
        self.each(|a| a * o)
    }
}

impl<T: Copy + Neg<Output = T>> Neg for Eight<T> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}
