//! Curves of several programs in one frame.

use super::{begin, bounds, centered, escape, level, put, scale_ticks, ticks, widened};
use crate::report::format::compact;

const LEFT: f64 = 66.0;
const RIGHT: f64 = 10.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = 34.0;

/// How a series is drawn. The style sheet gives program 0, 1, 2, ... a color and a dash each, so that they
/// differ even without color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    /// Line of a program.
    Program(usize),
    /// Bound of a region.
    Limit,
    /// Thin line: what lies between.
    Guide,
    /// Circles.
    Circles,
    /// Triangles.
    Triangles,
}

impl Style {
    /// Class in the style sheet.
    pub(crate) fn class(self) -> String {
        match self {
            Self::Program(i) => format!("p{}", i % 6),
            Self::Limit => "bound".into(),
            Self::Guide => "guide".into(),
            Self::Circles => "circles".into(),
            Self::Triangles => "triangles".into(),
        }
    }
}

/// A curve or set of points; a point that is not finite breaks the curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Series {
    pub(crate) style: Style,
    pub(crate) points: Vec<[f64; 2]>,
}

/// A frame with curves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chart {
    /// What is drawn, for those who do not see it; plain text.
    pub(crate) label: String,
    /// Name and unit of both axes; plain text.
    pub(crate) axes: [String; 2],
    /// Range of the abscissa; that of the points when none.
    pub(crate) range: Option<[f64; 2]>,
    /// Size in units of which 11 are the height of a letter.
    pub(crate) size: [f64; 2],
    pub(crate) series: Vec<Series>,
    /// Values of the ordinate that get a dashed line, when they lie near the curves.
    pub(crate) limits: Vec<f64>,
    /// Strips that share one abscissa show its name and numbers only below the last.
    pub(crate) abscissa: bool,
}

impl Chart {
    /// The SVG; every text is escaped.
    pub(crate) fn svg(&self) -> String {
        let [width, height] = self.size;
        let bottom = if self.abscissa { BOTTOM } else { 8.0 };
        let mut out = begin("plot chart", width, height, &self.label);
        put!(out, r#"<text class="name" x="{LEFT}" y="{:.1}">{}</text>"#, TOP - 7.0, escape(&self.axes[1]));
        let base = height - bottom;
        put!(
            out,
            r#"<rect class="frame" x="{LEFT}" y="{TOP}" width="{:.1}" height="{:.1}"/>"#,
            width - LEFT - RIGHT,
            base - TOP
        );
        let finite = |p: &&[f64; 2]| p[0].is_finite() && p[1].is_finite();
        let all = || self.series.iter().flat_map(|s| s.points.iter()).filter(finite);
        let [x_low, x_high] = self.range.unwrap_or_else(|| bounds(all().map(|p| p[0])));
        let inside = |p: &&[f64; 2]| p[0] >= x_low && p[0] <= x_high;
        let [mut low, mut high] = bounds(all().filter(inside).map(|p| p[1]));
        if !(low <= high && x_low < x_high) {
            centered(&mut out, [0.5 * (LEFT + width), 0.5 * (TOP + base)], "nothing to show");
            return out + "</svg>";
        }
        // A limit is shown when it is reached for by half; a far one would press the curves flat.
        let near = |l: &&f64| l.is_finite() && **l != 0.0 && **l * if **l > 0.0 { high } else { low } > 0.5 * **l * **l;
        let limits: Vec<f64> = self.limits.iter().filter(near).copied().collect();
        for l in &limits {
            (low, high) = (low.min(*l), high.max(*l));
        }
        [low, high] = widened([low, high], 0.06);
        let x = |v: f64| LEFT + (width - LEFT - RIGHT) * (v - x_low) / (x_high - x_low);
        let y = |v: f64| base - (base - TOP) * ((v - low) / (high - low)).clamp(0.0, 1.0);
        for v in scale_ticks(low, high, ((base - TOP) / 36.0).max(2.0) as u32) {
            level(&mut out, v, y(v), [LEFT, width - RIGHT]);
        }
        for v in ticks(x_low, x_high, 8) {
            put!(out, r#"<path class="zero" d="M{:.1} {TOP}V{base:.1}"/>"#, x(v));
            if self.abscissa {
                centered(&mut out, [x(v), base + 14.0], &compact(v));
            }
        }
        if self.abscissa {
            centered(&mut out, [0.5 * (LEFT + width - RIGHT), base + 29.0], &self.axes[0]);
        }
        for l in &limits {
            put!(out, r#"<path class="limit" d="M{LEFT} {:.1}H{}"/>"#, y(*l), width - RIGHT);
        }
        for series in &self.series {
            match series.style {
                Style::Circles | Style::Triangles => {
                    marks(&mut out, series, &x, &y, [x_low, x_high]);
                }
                Style::Program(_) | Style::Limit | Style::Guide => {
                    let columns = (width - LEFT - RIGHT) as usize;
                    line(&mut out, &series.style.class(), &thinned(&series.points, [x_low, x_high], columns), &x, &y);
                }
            }
        }
        out.push_str("</svg>");
        out
    }
}

fn marks(out: &mut String, series: &Series, x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64, range: [f64; 2]) {
    for p in series.points.iter().filter(|p| p[0] >= range[0] && p[0] <= range[1] && p[1].is_finite()) {
        let (px, py) = (x(p[0]), y(p[1]));
        if series.style == Style::Circles {
            put!(out, r#"<circle class="circles" cx="{px:.1}" cy="{py:.1}" r="4"/>"#);
        } else {
            put!(out, r#"<path class="triangles" d="M{px:.1} {:.1}l4.5 8h-9z"/>"#, py - 5.0);
        }
    }
}

fn line(out: &mut String, class: &str, points: &[[f64; 2]], x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64) {
    put!(out, r#"<path class="curve {class}" d=""#);
    let mut down = false;
    for p in points {
        if p[0].is_finite() && p[1].is_finite() {
            put!(out, "{}{:.1} {:.1}", if down { 'L' } else { 'M' }, x(p[0]), y(p[1]));
            down = true;
        } else {
            down = false;
        }
    }
    out.push_str(r#""/>"#);
}

/// Points in the range; where there are more than three a column, the first, smallest, largest and last of
/// each column, so that no peak is lost.
fn thinned(points: &[[f64; 2]], [low, high]: [f64; 2], columns: usize) -> Vec<[f64; 2]> {
    let inside: Vec<[f64; 2]> =
        points.iter().filter(|p| !p[0].is_finite() || p[0] >= low && p[0] <= high).copied().collect();
    if inside.len() <= 3 * columns.max(1) {
        return inside;
    }
    let column = |p: &[f64; 2]| ((p[0] - low) / (high - low) * columns as f64) as i64;
    let mut out = Vec::with_capacity(4 * columns);
    for group in inside.chunk_by(|a, b| column(a) == column(b) && a[1].is_finite() == b[1].is_finite()) {
        let mut picks: Vec<usize> = vec![0, group.len() - 1];
        let by = |a: &usize, b: &usize| group[*a][1].total_cmp(&group[*b][1]);
        picks.extend((0..group.len()).min_by(by));
        picks.extend((0..group.len()).max_by(by));
        picks.sort_unstable();
        picks.dedup();
        out.extend(picks.into_iter().map(|i| group[i]));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<[f64; 2]>) -> Chart {
        Chart {
            label: "a \"label\"".into(),
            axes: ["S, <mm>".into(), "θ, °".into()],
            range: None,
            size: [400.0, 200.0],
            series: vec![
                Series { style: Style::Program(0), points: points.clone() },
                Series { style: Style::Circles, points },
            ],
            limits: vec![1.1, -40.0],
            abscissa: true,
        }
    }

    #[test]
    fn no_peak_is_lost_when_points_are_thinned() {
        let mut points: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i), (f64::from(i) * 0.1).sin()]).collect();
        points[54_321][1] = 7.5;
        points[12_345][1] = -3.5;
        let thin = thinned(&points, [0.0, 99_999.0], 500);
        assert!(thin.len() <= 4 * 502, "{}", thin.len());
        assert!(thin.contains(&[54_321.0, 7.5]) && thin.contains(&[12_345.0, -3.5]));
        assert!(thin.windows(2).all(|w| w[0][0] < w[1][0]), "order stays");
    }

    #[test]
    fn charts_escape_and_stay_finite() {
        let text = chart(vec![[0.0, 0.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 0.5], [f64::INFINITY, 2.0]]).svg();
        assert!(text.contains("S, &lt;mm&gt;") && text.contains("a &quot;label&quot;"));
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        assert_eq!(text.matches(r#"class="limit""#).count(), 1, "the far limit is not drawn");
        let curve = text.split(r#"class="curve p0" d=""#).nth(1).and_then(|t| t.split('"').next()).expect("a curve");
        assert_eq!(curve.matches('M').count(), 2, "a missing point breaks the curve: {curve}");
        for empty in [vec![], vec![[1.0, f64::NAN]], vec![[1.0, 1.0]]] {
            let text = chart(empty).svg();
            assert!(text.contains("nothing to show") && text.ends_with("</svg>"), "{text}");
        }
    }
}
