//! Charts of the pages as SVG. Every text goes through [`escape`]; the result is markup without scripts or
//! references.

mod curves;
mod dots;
mod histogram;
mod strips;

pub(crate) use self::{
    curves::{Chart, Series, Style},
    dots::{DotRow, dots},
    histogram::{Bar, histogram},
    strips::{SignalStrip, svg},
};
use crate::report::format::compact;

/// Least range of values that is drawn as it is: by itself, and as a part of the largest.
const LEAST_RANGE: f64 = 1e-9;
const LEAST_PART: f64 = 1e-6;

/// Puts a formatted text at the end of a string.
macro_rules! put {
    ($out:expr, $($text:tt)+) => {{
        use std::fmt::Write as _;
        $out.write_fmt(format_args!($($text)+)).unwrap_or_default(); // a string takes everything
    }};
}
pub(crate) use put;

/// Begins a picture; `label` is its text for screen readers.
fn begin(class: &str, width: f64, height: f64, label: &str) -> String {
    format!(r#"<svg class="{class}" viewBox="0 0 {width} {height}" role="img" aria-label="{}">"#, escape(label))
}

/// A text with its middle at a place.
fn centered(out: &mut String, [x, y]: [f64; 2], words: &str) {
    put!(out, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="middle">{}</text>"#, escape(words));
}

/// A level line from `left` to `right` at height `y`, with its value before it.
fn level(out: &mut String, value: f64, y: f64, [left, right]: [f64; 2]) {
    put!(
        out,
        r#"<path class="zero" d="M{left} {y:.1}H{right}"/><text x="{}" y="{:.1}" text-anchor="end">{}</text>"#,
        left - 6.0,
        y + 4.0,
        compact(value)
    );
}

/// A range that is no point, with a share of it as margin at both ends.
fn widened([mut low, mut high]: [f64; 2], margin: f64) -> [f64; 2] {
    let least = LEAST_RANGE.max(LEAST_PART * low.abs().max(high.abs()));
    if high - low < least {
        (low, high) = (low - 0.5 * least.max(1.0), high + 0.5 * least.max(1.0));
    }
    let margin = margin * (high - low);
    [low - margin, high + margin]
}

fn bounds(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
}

/// Round values (1, 2 or 5 times a power of ten apart) between two bounds, about `wanted` of them.
pub(crate) fn ticks(low: f64, high: f64, wanted: u32) -> Vec<f64> {
    let raw = (high - low) / f64::from(wanted.max(1));
    if !(raw.is_finite() && raw > 0.0) {
        return Vec::new();
    }
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw).unwrap_or(10.0 * power);
    let first = (low / step).ceil() as i64;
    (first..first + 2 * i64::from(wanted) + 2).map(|k| k as f64 * step).take_while(|v| *v <= high).collect()
}

/// The same, at least two of them where the bounds differ, so that a scale can be read.
pub(crate) fn scale_ticks(low: f64, high: f64, wanted: u32) -> Vec<f64> {
    [wanted, 3, 5, 8].map(|wanted| ticks(low, high, wanted)).into_iter().find(|t| t.len() > 1).unwrap_or_default()
}

/// Text for markup: the five characters that have a meaning there.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 100.0, 5), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(ticks(-0.3, 0.3, 3), [-0.2, 0.0, 0.2]);
        // One round number alone says nothing of a scale.
        assert_eq!(ticks(3.0, 7.5, 2), [5.0]);
        for (low, high) in [(3.0, 7.5), (0.9, 1.4), (-1e-3, 4e-4), (1.0e6, 1.00003e6)] {
            let all = scale_ticks(low, high, 2);
            assert!(all.len() > 1 && all.iter().all(|v| (low..=high).contains(v)), "{all:?}");
        }
        assert!(scale_ticks(1.0, 1.0, 3).is_empty());
        assert!(ticks(1.0, 1.0, 3).is_empty() && ticks(f64::NAN, 1.0, 3).is_empty());
    }
}
