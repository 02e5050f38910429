//! Values of several programs in rows above one scale.

use super::{begin, bounds, centered, curves::Style, escape, put, ticks};
use crate::report::format::compact;

/// Distance of the scale from the right edge.
const RIGHT: f64 = 10.0;
/// Values that span less are one; the scale then reaches one to both sides.
const LEAST_RANGE: f64 = 1e-9;

/// A row of a dot chart: values of several programs on one scale.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DotRow {
    /// Name; plain text.
    pub(crate) name: String,
    /// Range drawn as a band below the dots.
    pub(crate) band: Option<[f64; 2]>,
    /// Hollow dot: a value from elsewhere.
    pub(crate) reference: Option<f64>,
    /// Program and value.
    pub(crate) dots: Vec<(usize, f64)>,
}

/// Rows of dots above one scale with its name.
pub(crate) fn dots(rows: &[DotRow], scale: &str, label: &str, width: f64) -> String {
    const ROW: f64 = 22.0;
    const NAMES: f64 = 330.0;
    let height = 12.0 + ROW * rows.len() as f64 + 40.0;
    let mut out = begin("plot chart", width, height, label);
    let values =
        rows.iter().flat_map(|r| r.dots.iter().map(|d| d.1).chain(r.reference).chain(r.band.into_iter().flatten()));
    let [mut low, mut high] = bounds(values.filter(|v| v.is_finite()).chain([0.0]));
    if high - low < LEAST_RANGE {
        (low, high) = (low - 1.0, high + 1.0);
    }
    let margin = 0.04 * (high - low);
    (low, high) = (low - margin, high + margin);
    let x = |v: f64| NAMES + (width - NAMES - RIGHT) * ((v - low) / (high - low)).clamp(0.0, 1.0);
    let base = 8.0 + ROW * rows.len() as f64;
    for v in ticks(low, high, 8) {
        let class = if v == 0.0 { "origin" } else { "zero" };
        put!(out, r#"<path class="{class}" d="M{:.1} 6V{base:.1}"/>"#, x(v));
        centered(&mut out, [x(v), base + 14.0], &compact(v));
    }
    centered(&mut out, [0.5 * (NAMES + width - RIGHT), base + 30.0], scale);
    for (i, row) in rows.iter().enumerate() {
        let middle = 6.0 + ROW * (i as f64 + 0.5);
        put!(
            out,
            r#"<text class="name" x="{}" y="{:.1}" text-anchor="end">{}</text>"#,
            NAMES - 12.0,
            middle + 4.0,
            escape(&row.name)
        );
        if let Some([from, to]) = row.band {
            put!(
                out,
                r#"<rect class="band" x="{:.1}" y="{:.1}" width="{:.1}" height="14" rx="3"/>"#,
                x(from),
                middle - 7.0,
                (x(to) - x(from)).max(1.0)
            );
        }
        for &(program, value) in row.dots.iter().filter(|d| d.1.is_finite()) {
            let class = Style::Program(program).class();
            if program % 2 == 0 {
                put!(out, r#"<circle class="dot {class}" cx="{:.1}" cy="{middle:.1}" r="4.5"/>"#, x(value));
            } else {
                put!(
                    out,
                    r#"<rect class="dot {class}" x="{:.1}" y="{:.1}" width="8" height="8"/>"#,
                    x(value) - 4.0,
                    middle - 4.0
                );
            }
        }
        if let Some(value) = row.reference.filter(|v| v.is_finite()) {
            put!(out, r#"<path class="reference" d="M{0:.1} {1:.1}l5.5 6l-5.5 6l-5.5 -6z"/>"#, x(value), middle - 6.0);
        }
    }
    out.push_str("</svg>");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_show_every_value() {
        let row = DotRow {
            name: "jerk <10 %".into(),
            band: Some([1.0, 5.0]),
            reference: Some(3.0),
            dots: vec![(0, 2.0), (1, 4.0)],
        };
        let text = dots(&[row], "gain, %", "gains", 600.0);
        assert!(
            text.contains("jerk &lt;10 %") && text.contains(r#"class="band""#) && text.contains(r#"class="reference""#)
        );
        assert!(text.contains(r#"<circle class="dot p0""#) && text.contains(r#"<rect class="dot p1""#));
    }
}
