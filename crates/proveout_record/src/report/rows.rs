//! Rows of the page's tables, as text.

use proveout_sim::verdict::Verdict;
use serde::Serialize;

use crate::report::{
    data::JointSignals,
    format::{compact, count, duration, fixed, length, length_or_dash, path, volume},
    page::{Entry, entry},
};

pub(crate) fn deviation(v: &Verdict) -> Vec<Entry> {
    let d = &v.deviation;
    let mut rows = vec![
        entry("Deepest gouge", length_or_dash(d.gouge_max_mm), ""),
        entry("Most material left", length_or_dash(d.excess_max_mm), ""),
        entry("Mean", length_or_dash(d.mean_mm), ""),
        entry("Root mean square", length_or_dash(d.rms_mm), ""),
        entry("Gouged area", d.gouge_area_mm2.map_or_else(|| "–".into(), |a| format!("{} mm²", compact(a))), ""),
        entry("Points measured", d.samples.map_or_else(|| "–".into(), count), ""),
        entry("Below this not judged", length_or_dash(d.tolerance_floor_mm), ""),
    ];
    if let Some(p) = d.worst_point {
        rows.push(entry("Worst point", format!("X {} Y {} Z {}", fixed(p[0], 3), fixed(p[1], 3), fixed(p[2], 3)), ""));
    }
    rows
}

#[derive(Serialize)]
pub(crate) struct InspectionRow {
    name: String,
    nominal: String,
    measured: String,
    deviation: String,
    tolerance: String,
    class: &'static str,
    word: &'static str,
}

pub(crate) fn inspection(v: &Verdict) -> Vec<InspectionRow> {
    let row = |f: &proveout_sim::verdict::Inspected| {
        let off = f.measured_mm.map(|m| m - f.nominal_mm);
        let (class, word) = match off {
            None => ("unchecked", "No surface met"),
            Some(d) if d.abs() <= f.tolerance_mm => ("pass", "In tolerance"),
            Some(_) => ("fail", "Out of tolerance"),
        };
        InspectionRow {
            name: f.name.clone(),
            nominal: format!("{} mm", fixed(f.nominal_mm, 3)),
            measured: f.measured_mm.map_or_else(|| "–".into(), |m| format!("{} mm", fixed(m, 4))),
            deviation: length_or_dash(off),
            tolerance: format!("± {}", length(f.tolerance_mm)),
            class,
            word,
        }
    };
    v.inspection.iter().map(row).collect()
}

#[derive(Serialize)]
pub(crate) struct Share {
    class: &'static str,
    name: &'static str,
    value: String,
    percent: String,
}

#[derive(Serialize)]
pub(crate) struct TimeWords {
    total: String,
    shares: Vec<Share>,
    note: String,
}

pub(crate) fn time(v: &Verdict) -> TimeWords {
    let t = &v.time;
    let parts = [
        ("cut", "Feed", t.cutting_s),
        ("rapid", "Rapid", t.rapid_s),
        ("dwell", "Dwell and spindle", t.dwell_s),
        ("change", "Tool change", t.tool_change_s),
    ];
    let whole = t.total_s.max(parts.iter().map(|p| p.2).sum());
    let share = |(class, name, s): (&'static str, &'static str, f64)| Share {
        class,
        name,
        value: duration(s),
        percent: fixed(if whole > 0.0 { 100.0 * s / whole } else { 0.0 }, 1),
    };
    let note = t.lower_bound_s.map_or_else(String::new, |bound| {
        let above = if bound > 0.0 {
            format!(" ({} % above it)", fixed(100.0 * (t.total_s / bound - 1.0), 1))
        } else {
            String::new()
        };
        format!("No control with the same limits can run this path in less than {}{above}.", duration(bound))
    });
    TimeWords { total: duration(t.total_s), shares: parts.into_iter().map(share).collect(), note }
}

#[derive(Serialize)]
pub(crate) struct ToolRow {
    number: u32,
    name: String,
    time: String,
    cut: String,
    length: String,
    volume: String,
    overhang: String,
}

pub(crate) fn tools(v: &Verdict) -> Vec<ToolRow> {
    let row = |t: &proveout_sim::verdict::ToolUse| ToolRow {
        number: t.number,
        name: t.name.clone(),
        time: duration(t.time_s),
        cut: duration(t.cut_time_s),
        length: path(t.length_mm),
        volume: volume(t.volume_mm3),
        overhang: t.min_overhang_mm.map_or_else(|| "–".into(), |o| format!("{} mm", fixed(o, 1))),
    };
    v.tools.iter().map(row).collect()
}

#[derive(Serialize)]
pub(crate) struct Use {
    value: String,
    percent: Option<String>,
    width: String,
    over: bool,
}

#[derive(Serialize)]
pub(crate) struct AxisRow {
    name: String,
    min: String,
    max: String,
    uses: Vec<Use>,
    reversals: String,
    following: String,
}

/// One row a joint: in machine order, then joints that the machine does not name.
pub(crate) fn axes(v: &Verdict, joints: &[JointSignals]) -> Vec<AxisRow> {
    let row = |(name, a): (&String, &proveout_sim::verdict::Axis)| {
        let sign = symbol(&a.unit);
        let usage = |value: f64, per: &str, part: Option<f64>| Use {
            value: format!("{} {sign}/{per}", compact(value)),
            percent: part.map(|p| fixed(100.0 * p, 1)),
            width: fixed(part.map_or(0.0, |p| (100.0 * p).clamp(0.0, 100.0)), 0),
            over: part.is_some_and(|p| p > 1.001), // the promise of the planner: 0.1 percent
        };
        let error = |e: f64| if a.unit == "deg" { format!("{}°", compact(e)) } else { length(e) };
        AxisRow {
            name: name.clone(),
            min: format!("{} {sign}", fixed(a.min, 3)),
            max: format!("{} {sign}", fixed(a.max, 3)),
            uses: vec![
                usage(a.max_velocity, "s", a.velocity_utilisation),
                usage(a.max_acceleration, "s²", a.acceleration_utilisation),
                usage(a.max_jerk, "s³", a.jerk_utilisation),
            ],
            reversals: count(a.reversals),
            following: a.max_following_error.map_or_else(|| "not simulated".into(), error),
        }
    };
    let named = joints.iter().filter_map(|j| v.axes.get_key_value(&j.name));
    let others = v.axes.iter().filter(|(name, _)| joints.iter().all(|j| j.name != **name));
    named.chain(others).map(row).collect()
}

pub(crate) fn symbol(unit: &str) -> &str {
    if unit == "deg" { "°" } else { unit }
}
