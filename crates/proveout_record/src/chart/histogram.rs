//! Shares as bars.

use super::{begin, escape, put};
use crate::report::format::compact;

/// A bar of the histogram.
pub(crate) struct Bar {
    pub(crate) share: f64,
    /// CSS color.
    pub(crate) color: String,
}

/// Bars side by side with their largest share as scale; `marks` are values at the left end, in the middle and
/// at the right end.
pub(crate) fn histogram(bars: &[Bar], marks: [&str; 3], label: &str) -> String {
    const HEIGHT: f64 = 120.0;
    // Keeps the heights of empty bars numbers.
    const LEAST_TOP: f64 = 1e-12;
    let top = bars.iter().map(|b| b.share).fold(0.0, f64::max).max(LEAST_TOP);
    let mut out = begin("plot", 480.0, HEIGHT + 30.0, label);
    let width = 480.0 / bars.len().max(1) as f64;
    for (i, bar) in bars.iter().enumerate() {
        let h = HEIGHT * bar.share / top;
        put!(
            out,
            r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{h:.1}" fill="{}" stroke="currentColor" stroke-opacity=".25" stroke-width=".5"/>"#,
            i as f64 * width,
            10.0 + HEIGHT - h,
            (width - 1.0).max(0.5),
            escape(&bar.color)
        );
    }
    put!(
        out,
        r#"<path class="zero" d="M0 {0}H480"/><text x="0" y="{1}">{2}</text><text x="240" y="{1}" text-anchor="middle">{3}</text><text x="480" y="{1}" text-anchor="end">{4}</text><text x="480" y="18" text-anchor="end">highest bar {5} %</text></svg>"#,
        10.0 + HEIGHT,
        26.0 + HEIGHT,
        escape(marks[0]),
        escape(marks[1]),
        escape(marks[2]),
        compact(top * 100.0)
    );
    out
}
