//! The scallop on the page: figures, histogram, the worst patches, and the passes.

use proveout_sim::verdict::{Scallop, ScallopHeights};
use serde_json::{Value, json};

use crate::{
    chart::{Bar, histogram},
    report::format::{count, fixed},
};

/// Lines of a table at most; the verdict has more.
const LINES: usize = 20;

fn micrometer(value: f64) -> String {
    format!("{} µm", fixed(value, 3))
}

fn row(name: String, heights: Option<&ScallopHeights>, more: String) -> Value {
    let of = |f: fn(&ScallopHeights) -> f64| heights.map_or_else(|| "–".into(), |h| micrometer(f(h)));
    json!({
        "name": name,
        "p95": of(|h| h.p95_um),
        "mean": of(|h| h.mean_um),
        "max": of(|h| h.max_um),
        "length": heights.map_or_else(|| "none found".into(), |h| format!("{} mm", fixed(h.length_mm, 1))),
        "more": more,
    })
}

fn more_than(count_of: u64, shown: usize, what: &str) -> String {
    if count_of > shown as u64 { format!("The worst {shown} of {} {what}.", count(count_of)) } else { String::new() }
}

/// The scallop in words and bars.
pub(crate) fn scallop(s: &Scallop) -> Value {
    let mut figures = vec![
        ["95th percentile of the height".to_owned(), micrometer(s.all.p95_um)],
        ["Mean".into(), micrometer(s.all.mean_um)],
        ["Largest".into(), micrometer(s.all.max_um)],
        ["Percentile known to".into(), micrometer(s.p95_bound_um)],
        ["Mean known to".into(), micrometer(s.mean_bound_um)],
        ["Each height known to".into(), micrometer(s.bound_um)],
        ["Length of the ridges".into(), format!("{} mm", fixed(s.all.length_mm, 1))],
        ["Places".into(), count(s.all.places)],
    ];
    let mut put = |name: &str, value: Option<String>| figures.extend(value.map(|v| [name.to_owned(), v]));
    put("Mean by the geometry of the contacts", s.geometric_mean_um.map(micrometer));
    put("Measured less geometric, mean", s.difference_mean_um.map(micrometer));
    put("The same, 95th percentile of its size", s.difference_p95_um.map(micrometer));
    let mm = |v: f64| format!("{} mm", fixed(v, 3));
    put("Distance of the passes, mean", s.spacing_mean_mm.map(mm));
    put("Largest distance of the passes", s.spacing_max_mm.map(mm));
    put("Narrowest strip up to the tolerance, standing cutter", s.strip_width_min_mm.map(mm));
    put("The same, moving cutter", s.swept_width_min_mm.map(mm));
    let length: f64 = s.histogram.iter().map(|b| b.length_mm).sum();
    let share = |l: f64| if length > 0.0 { l / length } else { 0.0 };
    let bars: Vec<Bar> =
        s.histogram.iter().map(|b| Bar { share: share(b.length_mm), color: "var(--accent, #3f7cc4)".into() }).collect();
    let ends = s.histogram.first().zip(s.histogram.last()).map_or([0.0; 2], |(a, b)| [a.from_um, b.to_um]);
    let marks = [ends[0], 0.5 * (ends[0] + ends[1]), ends[1]].map(micrometer);
    let [low, middle, high] = [&*marks[0], &*marks[1], &*marks[2]];
    let place = |p: [f64; 3]| format!("X{} Y{} Z{}", fixed(p[0], 3), fixed(p[1], 3), fixed(p[2], 3));
    let regions = s.regions.iter().map(|r| {
        let name = r.name.clone().unwrap_or_else(|| "elsewhere".into());
        row(name, r.heights.as_ref(), format!("allowed {} µm", r.limit_um))
    });
    let patches = s.patches.iter().take(LINES).map(|p| row(place(p.highest_mm), Some(&p.heights), p.blocks.join(", ")));
    let passes = s.passes.iter().take(LINES).map(|p| row(p.begins.clone(), Some(&p.heights), String::new()));
    json!({
        "figures": figures,
        "histogram": histogram(&bars, [low, middle, high], "Length of the ridges by height"),
        "regions": regions.collect::<Vec<_>>(),
        "patches": patches.collect::<Vec<_>>(),
        "passes": passes.collect::<Vec<_>>(),
        "patch_note": more_than(s.patch_count, s.patches.len().min(LINES), "patches"),
        "pass_note": if s.pass_count > s.passes.len().min(LINES) as u64 {
            format!("{} of {} passes.", s.passes.len().min(LINES), count(s.pass_count))
        } else {
            String::new()
        },
    })
}
