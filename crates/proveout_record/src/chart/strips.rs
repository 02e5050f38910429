//! Signals over time, one above the other.

use super::{begin, centered, escape, level, put, scale_ticks, ticks, widened};
use crate::{envelope::Envelope, report::format::compact};

const LEFT: f64 = 62.0;
const RIGHT: f64 = 6.0;
const TOP: f64 = 18.0;
const GAP: f64 = 24.0;
const BOTTOM: f64 = 20.0;

/// One signal, or two on the same scale, above the common time axis.
pub(crate) struct SignalStrip<'a> {
    /// Name with unit; plain text.
    pub(crate) name: String,
    /// Filled band.
    pub(crate) signal: &'a Envelope,
    /// Line over it: the largest value of each stretch.
    pub(crate) second: Option<&'a Envelope>,
    /// Lower and upper limit, each drawn when the signal comes near it.
    pub(crate) limits: [Option<f64>; 2],
    /// Begin and end (s) of times that are marked at the upper edge.
    pub(crate) marks: Vec<[f64; 2]>,
    /// Highest value of the scale; what is above it is drawn at the upper edge.
    pub(crate) ceiling: Option<f64>,
    /// Height of the strip in the picture.
    pub(crate) height: f64,
}

impl<'a> SignalStrip<'a> {
    /// One signal without limits and marks.
    pub(crate) fn new(name: impl Into<String>, signal: &'a Envelope, height: f64) -> Self {
        Self { name: name.into(), signal, second: None, limits: [None; 2], marks: Vec::new(), ceiling: None, height }
    }
}

/// Strips above each other with a common time axis from 0 to `end` (s), and vertical lines at `changes` (s);
/// `width` in units of which 11 are the height of a letter.
///
/// Every text goes through [`escape`]; the result is SVG markup without scripts or references.
pub(crate) fn svg(strips: &[SignalStrip<'_>], width: f64, end: f64, changes: &[f64], label: &str) -> String {
    let end = if end.is_finite() && end > 0.0 { end } else { 1.0 };
    let height = TOP + strips.iter().map(|s| s.height + GAP).sum::<f64>() - GAP + BOTTOM;
    let x = |t: f64| LEFT + (width - LEFT - RIGHT) * (t / end).clamp(0.0, 1.0);
    let mut out = begin("plot", width, height, label);
    let mut top = TOP;
    for strip in strips {
        draw_strip(&mut out, strip, top, width, &x, changes);
        top += strip.height + GAP;
    }
    let base = top - GAP;
    for t in ticks(0.0, end, 6) {
        centered(&mut out, [x(t), base + 15.0], &compact(t));
    }
    out.push_str("</svg>");
    out
}

fn draw_strip(
    out: &mut String,
    strip: &SignalStrip<'_>,
    top: f64,
    width: f64,
    x: &impl Fn(f64) -> f64,
    changes: &[f64],
) {
    let bottom = top + strip.height;
    let ranges = [strip.signal.range(), strip.second.and_then(Envelope::range)];
    let (mut low, mut high) =
        ranges.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r[0]), h.max(r[1])));
    put!(out, r#"<text class="name" x="{LEFT}" y="{:.1}">{}</text>"#, top - 5.0, escape(&strip.name));
    put!(
        out,
        r#"<rect class="frame" x="{LEFT}" y="{top:.1}" width="{:.1}" height="{:.1}"/>"#,
        width - LEFT - RIGHT,
        strip.height
    );
    if let Some(ceiling) = strip.ceiling.filter(|c| *c > low) {
        high = high.min(ceiling);
    }
    if low > high {
        centered(out, [(LEFT + width) / 2.0, (top + bottom) / 2.0 + 4.0], "not recorded");
        return;
    }
    // A limit is shown when it is no farther from the signal than half the signal's span; a far one would
    // press the signal flat. A signal to both sides of zero thus shows limits that it uses by half.
    let near = 0.5 * (high - low);
    let is_near = |l: &f64, k: usize| l.is_finite() && if k == 0 { low - l <= near } else { l - high <= near };
    let limits: Vec<f64> = (0..2).filter_map(|k| strip.limits[k].filter(|l| is_near(l, k))).collect();
    for l in &limits {
        (low, high) = (low.min(*l), high.max(*l));
    }
    let [low, high] = widened([low, high], 0.05);
    let y = |v: f64| bottom - (bottom - top) * ((v - low) / (high - low)).clamp(0.0, 1.0);
    for v in scale_ticks(low, high, 3) {
        level(out, v, y(v), [LEFT, width - RIGHT]);
    }
    for t in changes {
        put!(out, r#"<path class="change-line" d="M{:.1} {top:.1}V{bottom:.1}"/>"#, x(*t));
    }
    for l in &limits {
        put!(out, r#"<path class="limit" d="M{LEFT} {:.1}H{}"/>"#, y(*l), width - RIGHT);
    }
    for [begin, end] in &strip.marks {
        // At least two units wide, so that a short one is seen.
        let width = (x(*end) - x(*begin)).max(2.0);
        put!(out, r#"<rect class="saturated" x="{:.1}" y="{top:.1}" width="{width:.1}" height="4"/>"#, x(*begin));
    }
    let stretches = strip.signal.stretches();
    let upper = stretches.iter().map(|&(t, _, h)| (t, h));
    let lower = stretches.iter().rev().map(|&(t, l, _)| (t, l));
    path(out, "signal", upper.chain(lower).map(|(t, v)| (x(t), y(v))), true);
    if let Some(second) = strip.second {
        path(out, "second", second.stretches().into_iter().map(|(t, _, h)| (x(t), y(h))), false);
    }
}

fn path(out: &mut String, class: &str, points: impl Iterator<Item = (f64, f64)>, closed: bool) {
    put!(out, r#"<path class="{class}" d=""#);
    for (i, (x, y)) in points.enumerate() {
        put!(out, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
    }
    out.push_str(if closed { r#"Z"/>"# } else { r#""/>"# });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_limits_are_left_out() {
        let mut signal = Envelope::default();
        for i in 0..500 {
            signal.push(f64::from(i) * 0.01, 100.0 + 20.0 * (f64::from(i) * 0.1).sin());
        }
        let lines = |limits| {
            let strip = SignalStrip {
                name: "Z".into(),
                signal: &signal,
                second: None,
                limits,
                marks: vec![],
                ceiling: None,
                height: 70.0,
            };
            svg(&[strip], 640.0, 5.0, &[], "Z").matches("class=\"limit\"").count()
        };
        // The signal runs from 80 to 120: limits down to 60 and up to 140 are near.
        assert_eq!(lines([Some(61.0), Some(139.0)]), 2);
        assert_eq!(lines([Some(59.0), Some(139.0)]), 1);
        assert_eq!(lines([Some(110.0), None]), 1, "one that was passed is near");
        assert_eq!(lines([Some(f64::NEG_INFINITY), Some(f64::NAN)]), 0);
    }

    #[test]
    fn a_ceiling_ends_the_scale() {
        let mut signal = Envelope::default();
        for i in 0..500 {
            signal.push(f64::from(i) * 0.01, if i < 100 { 20_000.0 } else { 300.0 });
        }
        let text =
            |ceiling| svg(&[SignalStrip { ceiling, ..SignalStrip::new("F", &signal, 70.0) }], 640.0, 5.0, &[], "F");
        assert!(text(None).contains("000</text>"), "{}", text(None));
        let low = text(Some(400.0));
        assert!(!low.contains("000</text>") && low.contains("300"), "{low}");
        assert_eq!(text(Some(-5.0)), text(None), "a ceiling below the signal is none");
    }

    #[test]
    fn plots_stay_inside_their_frame_and_escape_names() {
        let mut signal = Envelope::default();
        for i in 0..5000 {
            signal.push(f64::from(i) * 0.01, (f64::from(i) * 0.02).sin() * 1e3);
        }
        let empty = Envelope::default();
        let strip = |name: &str, signal| SignalStrip {
            name: name.into(),
            signal,
            second: None,
            limits: [Some(-1100.0), Some(1100.0)],
            marks: vec![[10.0, 10.001]],
            ceiling: None,
            height: 70.0,
        };
        let text = svg(&[strip("<b>X", &signal), strip("Y", &empty)], 640.0, 50.0, &[7.0], "a \"b\"");
        assert_eq!(text.matches("class=\"saturated\"").count(), 1, "only where there is a signal");
        assert!(text.contains("&lt;b&gt;X") && text.contains("a &quot;b&quot;") && text.contains("not recorded"));
        assert_eq!(text.matches("class=\"limit\"").count(), 2);
        assert!(!text.contains("NaN") && !text.contains("inf"));
        assert!(text.starts_with("<svg") && text.ends_with("</svg>"));
    }
}
