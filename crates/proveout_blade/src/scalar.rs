//! Numbers in which a closed form is written once: plain ones, intervals that hold every value over a cell,
//! and jets that carry the first and second derivatives along (forward differentiation, Griewank & Walther
//! 2008, chapter 13). A jet of intervals bounds the derivatives over a cell.

use std::ops::{Add, Mul, Neg, Sub};

use std::f64::consts::{FRAC_PI_2, TAU};

/// What a closed form may do with its numbers.
pub trait Scalar: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self> {
    /// A constant.
    fn of(value: f64) -> Self;
    /// Sine and cosine of an angle in radian.
    fn sin_cos(self) -> (Self, Self);
    /// A multiple.
    fn times(self, factor: f64) -> Self {
        self * Self::of(factor)
    }
    /// A sum with a constant.
    fn plus(self, value: f64) -> Self {
        self + Self::of(value)
    }
}

impl Scalar for f64 {
    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }
}

/// All numbers from `low` to `high`. Ends are not rounded outward: who uses them adds a margin far above
/// rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lowest.
    pub low: f64,
    /// Highest.
    pub high: f64,
}

impl Interval {
    /// From two ends in either order.
    pub fn new(a: f64, b: f64) -> Self {
        Self { low: a.min(b), high: a.max(b) }
    }

    /// The least interval that holds both.
    pub fn with(self, o: Self) -> Self {
        Self { low: self.low.min(o.low), high: self.high.max(o.high) }
    }

    /// The largest magnitude in it.
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

impl Add for Interval {
    type Output = Self;

    #[inline]
    fn add(self, o: Self) -> Self {
        Self { low: self.low + o.low, high: self.high + o.high }
    }
}

impl Sub for Interval {
    type Output = Self;

    #[inline]
    fn sub(self, o: Self) -> Self {
        Self { low: self.low - o.high, high: self.high - o.low }
    }
}

impl Neg for Interval {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }
}

impl Mul for Interval {
    type Output = Self;

    #[inline]
    fn mul(self, o: Self) -> Self {
        let [a, b, c, d] = [self.low * o.low, self.low * o.high, self.high * o.low, self.high * o.high];
        Self { low: lower(lower(a, b), lower(c, d)), high: higher(higher(a, b), higher(c, d)) }
    }
}

/// One comparison each, where those of the library also look for what is no number.
#[inline]
fn lower(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
fn higher(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Range of the sine over an interval.
fn sine(x: Interval) -> Interval {
    let (a, b) = (x.low.sin(), x.high.sin());
    // Whether a place `first + k turns` lies in it.
    let holds = |first: f64| ((x.low - first) / TAU).ceil() * TAU + first <= x.high;
    Interval {
        low: if holds(-FRAC_PI_2) { -1.0 } else { a.min(b) },
        high: if holds(FRAC_PI_2) { 1.0 } else { a.max(b) },
    }
}

impl Scalar for Interval {
    #[inline]
    fn of(value: f64) -> Self {
        Self { low: value, high: value }
    }

    fn sin_cos(self) -> (Self, Self) {
        (sine(self), sine(self + Self::of(FRAC_PI_2)))
    }

    #[inline]
    fn times(self, factor: f64) -> Self {
        let (a, b) = (self.low * factor, self.high * factor);
        if factor < 0.0 { Self { low: b, high: a } } else { Self { low: a, high: b } }
    }
}

/// A value with its derivatives for u and v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<T> {
    /// The value.
    pub value: T,
    /// d/du, d/dv.
    pub first: [T; 2],
    /// d²/du², d²/dudv, d²/dv².
    pub second: [T; 3],
}

/// Which two first derivatives make each second one.
const PAIRS: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 1)];

impl<T: Scalar> Jet<T> {
    /// The parameter u itself.
    pub fn u(value: T) -> Self {
        Self { first: [T::of(1.0), T::of(0.0)], ..Self::constant(value) }
    }

    /// The parameter v itself.
    pub fn v(value: T) -> Self {
        Self { first: [T::of(0.0), T::of(1.0)], ..Self::constant(value) }
    }

    #[inline]
    fn constant(value: T) -> Self {
        Self { value, first: [T::of(0.0); 2], second: [T::of(0.0); 3] }
    }

    /// f(self) from f, f' and f'' at its value.
    #[inline]
    fn chain(self, f: T, slope: T, bend: T) -> Self {
        let second = |k: usize| slope * self.second[k] + bend * self.first[PAIRS[k].0] * self.first[PAIRS[k].1];
        Self { value: f, first: self.first.map(|d| slope * d), second: [second(0), second(1), second(2)] }
    }
}

impl<T: Scalar> Add for Jet<T> {
    type Output = Self;

    #[inline]
    fn add(self, o: Self) -> Self {
        Self {
            value: self.value + o.value,
            first: [self.first[0] + o.first[0], self.first[1] + o.first[1]],
            second: [self.second[0] + o.second[0], self.second[1] + o.second[1], self.second[2] + o.second[2]],
        }
    }
}

impl<T: Scalar> Neg for Jet<T> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, first: self.first.map(|d| -d), second: self.second.map(|d| -d) }
    }
}

impl<T: Scalar> Sub for Jet<T> {
    type Output = Self;

    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

#[expect(clippy::suspicious_arithmetic_impl, reason = "the rule of Leibniz adds products")]
impl<T: Scalar> Mul for Jet<T> {
    type Output = Self;

    #[inline]
    fn mul(self, o: Self) -> Self {
        let second = |k: usize| {
            let (i, j) = PAIRS[k];
            let mixed = self.first[i] * o.first[j] + self.first[j] * o.first[i];
            self.second[k] * o.value + mixed + self.value * o.second[k]
        };
        let first = |k: usize| self.first[k] * o.value + self.value * o.first[k];
        Self { value: self.value * o.value, first: [first(0), first(1)], second: [second(0), second(1), second(2)] }
    }
}

impl<T: Scalar> Scalar for Jet<T> {
    #[inline]
    fn of(value: f64) -> Self {
        Self::constant(T::of(value))
    }

    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c, -s), self.chain(c, -s, -c))
    }

    #[inline]
    fn times(self, factor: f64) -> Self {
        Self {
            value: self.value.times(factor),
            first: self.first.map(|d| d.times(factor)),
            second: self.second.map(|d| d.times(factor)),
        }
    }

    #[inline]
    fn plus(self, value: f64) -> Self {
        Self { value: self.value.plus(value), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_of_a_sine_holds_every_value_and_little_more() {
        for k in 0..4000 {
            let low = f64::from(k) * 0.01 - 20.0;
            let width = f64::from(k % 71) * 0.1;
            let (range, _) = Interval::new(low, low + width).sin_cos();
            let values: Vec<f64> = (0..=400).map(|i| (low + width * f64::from(i) / 400.0).sin()).collect();
            let least = values.iter().copied().fold(f64::MAX, f64::min);
            let most = values.iter().copied().fold(f64::MIN, f64::max);
            // Between samples 7/400 apart a sine goes on by at most (7/800)^2 / 2.
            assert!(range.low <= least && range.high >= most, "{low} {width}");
            assert!(range.low > least - 4e-5 && range.high < most + 4e-5, "{low} {width}");
        }
    }

    #[test]
    fn a_product_of_sines_has_the_derivatives_of_calculus() {
        let (u, v) = (0.7, -1.3);
        let (a, b) = (Jet::u(u), Jet::v(v));
        let f = (a * b).sin_cos().0 * a;
        let (s, c) = (u * v).sin_cos();
        let expected =
            [u * s, s + u * v * c, u * u * c, 2.0 * v * c - u * v * v * s, 2.0 * u * c - u * u * v * s, -u * u * u * s];
        let found = [f.value, f.first[0], f.first[1], f.second[0], f.second[1], f.second[2]];
        for (e, g) in expected.iter().zip(found) {
            assert!((e - g).abs() < 1e-14, "{e} {g}");
        }
    }
}
