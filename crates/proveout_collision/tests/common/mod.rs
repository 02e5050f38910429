//! What tests of this crate share.
#![allow(dead_code, reason = "each test uses what it needs")]

/// Small deterministic generator (xorshift, Marsaglia 2003).
pub(crate) struct Random(u64);

impl Random {
    /// From a seed that is not zero.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// From one number up to another.
    pub(crate) fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Zero up to one.
    pub(crate) fn part(&mut self) -> f64 {
        self.next(0.0, 1.0)
    }

    /// One of so many.
    pub(crate) fn pick(&mut self, n: usize) -> usize {
        (self.next(0.0, n as f64) as usize).min(n - 1)
    }

    /// Heads or tails.
    pub(crate) fn yes(&mut self) -> bool {
        self.part() < 0.5
    }
}
