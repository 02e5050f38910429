//! Text of JSON lines: keys, strings and numbers, appended to a buffer.

use std::fmt::Debug;

/// Three decimal digits of each number below 1000, and how many of them are leading zeros.
const DIGITS: [[u8; 4]; 1000] = digits();

const fn digits() -> [[u8; 4]; 1000] {
    let mut table = [[0; 4]; 1000];
    let mut n = 0;
    while n < 1000 {
        let zeros = (n < 10) as u8 + (n < 100) as u8;
        table[n] = [b'0' + (n / 100) as u8, b'0' + (n / 10 % 10) as u8, b'0' + (n % 10) as u8, zeros];
        n += 1;
    }
    table
}

/// Number of 1e-9 from which on numbers are written without an exponent, as `serde_json` does.
const SMALLEST_PLAIN: u64 = 10_000;
/// How many times 1e-9 makes one.
const NANO: f64 = 1e9;
/// Numbers of 1e-9 below this are rounded: beyond 2^52 the spacing of doubles is coarser already.
const ROUNDED: f64 = 4.5e15;

/// Bytes on their way into the buffer: sign, ten digits of a whole number, point, nine decimals.
#[derive(Clone, Copy)]
struct NumberText {
    bytes: [u8; 24],
    length: usize,
}

impl NumberText {
    const EMPTY: Self = Self { bytes: [0; 24], length: 0 };

    #[inline]
    fn push(&mut self, byte: u8) {
        self.bytes[self.length] = byte;
        self.length += 1;
    }

    #[inline]
    fn group(&mut self, n: u32) {
        let [a, b, c, _] = DIGITS[n as usize % 1000];
        self.bytes[self.length..self.length + 3].copy_from_slice(&[a, b, c]);
        self.length += 3;
    }

    #[inline]
    fn whole(&mut self, n: u32) {
        if n >= 1000 {
            self.whole(n / 1000);
            return self.group(n % 1000);
        }
        let [a, b, c, zeros] = DIGITS[n as usize];
        self.bytes[self.length..self.length + 3].copy_from_slice(&match zeros {
            0 => [a, b, c],
            1 => [b, c, 0],
            _ => [c, 0, 0],
        });
        self.length += 3 - usize::from(zeros);
    }

    /// Decimals of so many 1e-9, without zeros at the end, one at the least.
    #[inline]
    fn decimals(&mut self, n: u32) {
        if n == 0 {
            return self.push(b'0');
        }
        self.group(n / 1_000_000);
        let rest = n % 1_000_000;
        if rest > 0 {
            self.group(rest / 1000);
            if !rest.is_multiple_of(1000) {
                self.group(rest % 1000);
            }
        }
        while self.bytes[self.length - 1] == b'0' {
            self.length -= 1;
        }
    }

    #[inline]
    fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

/// A buffer of JSON text. Each key is written with the comma before it, which is why a line begins
/// with [`JsonText::raw`].
#[derive(Clone, Default)]
pub(super) struct JsonText(Vec<u8>);

impl Debug for JsonText {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&String::from_utf8_lossy(&self.0))
    }
}

impl JsonText {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Text that is JSON already.
    #[inline]
    pub(super) fn raw(&mut self, text: &str) {
        self.0.extend_from_slice(text.as_bytes());
    }

    /// What was written from here on, once more.
    #[inline]
    pub(super) fn again(&mut self, from: std::ops::Range<usize>) {
        self.0.extend_from_within(from);
    }

    pub(super) fn append(&mut self, other: &Self) {
        self.0.extend_from_slice(&other.0);
    }

    #[inline]
    pub(super) fn key(&mut self, key: &str) {
        self.raw(",\"");
        self.raw(key);
        self.raw("\":");
    }

    /// A string with its escapes.
    pub(super) fn string(&mut self, text: &str) {
        // A vector takes whatever is written.
        let _ = serde_json::to_writer(&mut self.0, text);
    }

    #[inline]
    pub(super) fn whole(&mut self, n: u32) {
        let mut short = NumberText::EMPTY;
        short.whole(n);
        self.0.extend_from_slice(short.bytes());
    }

    /// A number rounded to 1e-9; without a sign where that is zero. What is not finite is `null`.
    ///
    /// The decimals of the rounded number are its shortest text: below 4.5e6 two neighbors of nine decimals
    /// are farther from each other than a double from its neighbors, so that no other text of nine decimals
    /// or less reads as the same double.
    #[inline]
    pub(super) fn number(&mut self, value: f64) {
        let scaled = value * NANO;
        if scaled.abs() < ROUNDED {
            // Half away from zero, as `f64::round`: the fraction of a double below 2^52 is exact.
            let below = scaled as i64;
            let fraction = scaled - below as f64;
            let nano = below + i64::from(fraction >= 0.5) - i64::from(fraction <= -0.5);
            return self.nano(nano);
        }
        self.exact(value);
    }

    #[inline]
    fn nano(&mut self, nano: i64) {
        let magnitude = nano.unsigned_abs();
        let decimals = (magnitude % 1_000_000_000) as u32;
        if magnitude < SMALLEST_PLAIN && magnitude != 0 {
            return self.exact(nano as f64 / NANO);
        }
        let mut short = NumberText::EMPTY;
        if nano < 0 {
            short.push(b'-');
        }
        short.whole((magnitude / 1_000_000_000) as u32);
        short.push(b'.');
        short.decimals(decimals);
        self.0.extend_from_slice(short.bytes());
    }

    /// A number with all its digits.
    pub(super) fn exact(&mut self, value: f64) {
        let _ = serde_json::to_writer(&mut self.0, &value);
    }

    pub(super) fn point(&mut self, p: [f64; 3]) {
        self.raw("[");
        self.number(p[0]);
        self.raw(",");
        self.number(p[1]);
        self.raw(",");
        self.number(p[2]);
        self.raw("]");
    }

    /// Points or rows in brackets.
    pub(super) fn points(&mut self, points: &[[f64; 3]]) {
        for (at, p) in points.iter().enumerate() {
            self.raw(if at == 0 { "[" } else { "," });
            self.point(*p);
        }
        self.raw("]");
    }

    pub(super) fn put_number(&mut self, key: &str, value: f64) {
        self.key(key);
        self.number(value);
    }

    /// A number that may be missing.
    pub(super) fn put_number_or_null(&mut self, key: &str, value: Option<f64>) {
        self.key(key);
        match value {
            Some(value) => self.number(value),
            None => self.raw("null"),
        }
    }

    pub(super) fn put_whole(&mut self, key: &str, value: u32) {
        self.key(key);
        self.whole(value);
    }

    pub(super) fn put_flag(&mut self, key: &str, value: bool) {
        self.key(key);
        self.raw(if value { "true" } else { "false" });
    }

    pub(super) fn put_string(&mut self, key: &str, text: &str) {
        self.key(key);
        self.string(text);
    }

    pub(super) fn put_point(&mut self, key: &str, p: [f64; 3]) {
        self.key(key);
        self.point(p);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same number by way of a tree of values: rounded, then written by `serde_json`.
    fn slowly(value: f64) -> String {
        let scaled = value * 1e9;
        let rounded = if scaled.abs() < 4.5e15 { scaled.round() / 1e9 + 0.0 } else { value };
        serde_json::json!(rounded).to_string()
    }

    fn written(value: f64) -> String {
        let mut text = JsonText::default();
        text.number(value);
        String::from_utf8(text.0).unwrap()
    }

    /// Knuth's constants of MMIX.
    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state ^ *state >> 29
    }

    #[test]
    fn numbers_are_the_text_of_the_rounded_value() {
        for value in [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.1,
            1e-9,
            -1e-9,
            4.9e-10,
            5e-10,
            -5e-10,
            1e-5,
            9.999e-6,
            1e-4,
            0.999_999_999_5,
            1e15,
            1e16,
            4.5e6,
            4_499_999.999_999_999,
            4.5e6 + 1e-9,
            4_194_304.000_000_001,
            1e300,
            -1e300,
            f64::MIN_POSITIVE,
            5e-324,
            f64::MAX,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            2.5e-9,
            0.5e-9f64.next_down(),
            1.5e-9f64.next_down(),
        ] {
            assert_eq!(written(value), slowly(value), "{value:e}");
        }
    }

    /// All counts of 1e-9 up to a million, doubles of any bits, lengths with up to nine decimals, half counts
    /// and neighbors.
    #[test]
    fn random_numbers_of_all_magnitudes() {
        let state = &mut 1;
        for n in 0..1_000_000 {
            let value = f64::from(n) / 1e9;
            assert_eq!(written(value), slowly(value), "{value:e}");
        }
        for _ in 0..300_000 {
            let bits = f64::from_bits(random(state));
            let scale = 10f64.powi((random(state) % 30) as i32 - 15);
            let length = (random(state) % 20_000_000) as f64 / 1e7 * scale;
            let half = (random(state) % 9_000_000_000_000_000) as f64 / 2.0 / 1e9;
            let coordinate = (random(state) % 10_000_000) as f64 / 1e3;
            for value in [bits, length, half, half.next_up(), half.next_down(), coordinate, coordinate.next_up()] {
                assert_eq!(written(value), slowly(value), "{value:e}");
                assert_eq!(written(-value), slowly(-value), "-{value:e}");
            }
        }
    }

    #[test]
    fn whole_numbers_have_all_their_digits() {
        let state = &mut 1;
        let ends = [0, 9, 10, 99, 100, 999, 1000, 1001, 999_999, 1_000_000, u32::MAX];
        for n in ends.into_iter().chain((0..10_000).map(|_| random(state) as u32 >> (random(state) % 32))) {
            let mut text = JsonText::default();
            text.whole(n);
            assert_eq!(String::from_utf8(text.0).unwrap(), n.to_string());
        }
    }
}
