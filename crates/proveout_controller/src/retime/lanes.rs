//! Eight numbers at once: the same operation on each, so that the compiler makes vector instructions of it
//! where the processor has them (`pulp` chooses at run time). No sum runs across the lanes but in a fixed
//! order, and nothing is fused: the same bits everywhere.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// How many.
pub(super) const LANES: usize = 8;

#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn all(x: f64) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    pub(super) fn with(self, o: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = f(self.0[i], o.0[i]);
        }
        out
    }

    #[inline(always)]
    pub(super) fn each(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for x in &mut out.0 {
            *x = f(*x);
        }
        out
    }

    /// Whether it is so in any lane.
    #[inline(always)]
    pub(super) fn any(self, o: Self, is: impl Fn(f64, f64) -> bool) -> bool {
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
    pub(super) fn highest(self) -> f64 {
        self.0.iter().fold(f64::NEG_INFINITY, |m, x| if *x > m { *x } else { m })
    }

    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.with(o, |a, b| a + b)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.with(o, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.with(o, |a, b| a * b)
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        self.each(|a| a * o)
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}
