//! Rows of the page's tables, as text.

use proveout_sim::verdict::{Axis, AxisUnit, Verdict};
use serde::Serialize;
use serde_json::{Value, json};

use crate::report::{
    AT_LIMIT,
    data::{JointSignals, ProgramView},
    format::{compact, count, duration, fixed, length, length_or_dash, path, tool_name, volume},
    operations::Operation,
    page::{NamedValue, entry},
};

/// Kilojoules of a joule.
const KJ_PER_J: f64 = 1e-3;

pub(crate) fn deviation(v: &Verdict) -> Vec<NamedValue> {
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
    if let Some(against) = &d.against {
        rows.push(entry("Compared with", against.clone(), ""));
    }
    if let Some(error) = d.mesh_error_mm {
        rows.push(entry("Error of the design's mesh", length(error), ""));
    }
    if let Some(asked) = d.mesh_asked_mm {
        rows.push(entry("Asked of that mesh", length(asked), ""));
    }
    if let Some(p) = d.worst_point {
        rows.push(entry("Worst point", format!("X {} Y {} Z {}", fixed(p[0], 3), fixed(p[1], 3), fixed(p[2], 3)), ""));
    }
    rows
}

pub(crate) fn inspection(v: &Verdict) -> Vec<Value> {
    let row = |f: &proveout_sim::verdict::Inspected| {
        let off = f.measured_mm.map(|m| m - f.nominal_mm);
        let (class, word) = match off {
            None => ("unchecked", "No surface met"),
            Some(d) if d.abs() <= f.tolerance_mm => ("pass", "In tolerance"),
            Some(_) => ("fail", "Out of tolerance"),
        };
        json!({
            "name": f.name,
            "nominal": format!("{} mm", fixed(f.nominal_mm, 3)),
            "measured": f.measured_mm.map_or_else(|| "–".into(), |m| format!("{} mm", fixed(m, 4))),
            "deviation": length_or_dash(off),
            "tolerance": format!("± {}", length(f.tolerance_mm)),
            "class": class,
            "word": word,
        })
    };
    v.inspection.iter().map(row).collect()
}

#[derive(Serialize)]
pub(crate) struct TimeShare {
    class: &'static str,
    name: &'static str,
    value: String,
    percent: String,
}

pub(crate) fn time(v: &Verdict) -> Value {
    let t = &v.time;
    let parts = [
        ("cut", "Feed", t.cutting_s),
        ("rapid", "Rapid", t.rapid_s),
        ("dwell", "Dwell and spindle", t.dwell_s),
        ("change", "Tool change", t.tool_change_s),
    ];
    let whole = t.total_s.max(parts.iter().map(|p| p.2).sum());
    let share = |(class, name, s): (&'static str, &'static str, f64)| TimeShare {
        class,
        name,
        value: duration(s),
        percent: fixed(if whole > 0.0 { 100.0 * s / whole } else { 0.0 }, 1),
    };
    let above = |bound: f64| {
        if bound > 0.0 {
            format!("{} ({} % above it)", duration(bound), fixed(100.0 * (t.total_s / bound - 1.0), 1))
        } else {
            duration(bound)
        }
    };
    let any = t.lower_bound_s.map(|bound| {
        format!("No control with the same limits and tolerances can take less than {}, on any path.", above(bound))
    });
    let own = t.path_bound_s.map(|bound| format!("None can run this path in less than {}.", above(bound)));
    let note = any.into_iter().chain(own).collect::<Vec<_>>().join(" ");
    json!({ "total": duration(t.total_s), "shares": parts.into_iter().map(share).collect::<Vec<_>>(), "note": note })
}

#[derive(Serialize)]
pub(crate) struct ToolRow {
    number: u32,
    name: String,
    time: String,
    cut: String,
    length: String,
    volume: String,
    feed: String,
    share: String,
    overhang: String,
}

/// Feed reached, and its share of the programmed one.
fn feed_words(o: &Operation) -> [String; 2] {
    let dash = || "–".to_owned();
    let words =
        o.feed().map(|(feed, share)| [format!("{} mm/min", compact(feed)), format!("{} %", fixed(100.0 * share, 1))]);
    words.unwrap_or_else(|| [dash(), dash()])
}

/// One row an operation.
pub(crate) fn operations(program: &ProgramView) -> Vec<Value> {
    let row = |(k, o): (usize, &Operation)| {
        let tool = o.tool.and_then(|t| program.tools.get(t as usize));
        let tool = tool.map_or_else(String::new, |(number, name)| tool_name(*number, name));
        let [feed, share] = feed_words(o);
        json!({
            "name": if o.text.is_empty() { format!("Operation {}", k + 1) } else { o.text.clone() },
            "lines": o.lines.map_or_else(String::new, |[a, b]| format!("{a} to {b}")),
            "tool": tool,
            "time": duration(o.time_s),
            "feed_time": duration(o.feed_s),
            "rapid": duration(o.rapid_s),
            "feed": feed,
            "share": share,
            "volume": volume(o.volume_mm3),
        })
    };
    program.operations.iter().enumerate().map(row).collect()
}

pub(crate) fn tools(v: &Verdict, program: &ProgramView) -> Vec<ToolRow> {
    let of_tool = |name: &str| {
        let mut sum = Operation::default();
        let known = |o: &&Operation| o.tool.and_then(|t| program.tools.get(t as usize)).is_some_and(|t| t.1 == name);
        program.operations.iter().filter(known).for_each(|o| sum.add(o));
        feed_words(&sum)
    };
    let row = |t: &proveout_sim::verdict::ToolUse| {
        let [feed, share] = of_tool(&t.name);
        ToolRow {
            number: t.number,
            name: t.name.clone(),
            time: duration(t.time_s),
            cut: duration(t.cut_time_s),
            length: path(t.length_mm),
            volume: volume(t.volume_mm3),
            feed,
            share,
            overhang: t.min_overhang_mm.map_or_else(|| "–".into(), |o| format!("{} mm", fixed(o, 1))),
        }
    };
    v.tools.iter().map(row).collect()
}

#[derive(Serialize)]
pub(crate) struct LimitUse {
    value: String,
    percent: Option<String>,
    width: String,
    over: bool,
}

/// Joints in machine order, then those that the machine does not name.
fn in_order<'v>(v: &'v Verdict, joints: &[JointSignals]) -> Vec<(&'v String, &'v Axis)> {
    let named = joints.iter().filter_map(|j| v.axes.get_key_value(&j.name));
    let others = v.axes.iter().filter(|(name, _)| joints.iter().all(|j| j.name != **name));
    named.chain(others).collect()
}

/// A bar with the share of a limit.
fn usage(value: String, part: Option<f64>, most: f64) -> LimitUse {
    LimitUse {
        value,
        percent: part.map(|p| fixed(100.0 * p, 1)),
        width: fixed(part.map_or(0.0, |p| (100.0 * p).clamp(0.0, 100.0)), 0),
        over: part.is_some_and(|p| p > most),
    }
}

/// One row a joint.
pub(crate) fn axes(v: &Verdict, joints: &[JointSignals]) -> Vec<Value> {
    let row = |(name, a): (&String, &Axis)| {
        let sign = symbol(a.unit.name());
        // The promise of the planner: 0.1 percent.
        let rate = |value: f64, per: &str, part| usage(format!("{} {sign}/{per}", compact(value)), part, 1.001);
        json!({
            "name": name,
            "min": format!("{} {sign}", fixed(a.min, 3)),
            "max": format!("{} {sign}", fixed(a.max, 3)),
            "uses": vec![
                rate(a.max_velocity, "s", a.velocity_utilisation),
                rate(a.max_acceleration, "s²", a.acceleration_utilisation),
                rate(a.max_jerk, "s³", a.jerk_utilisation),
            ],
            "reversals": count(a.reversals),
        })
    };
    in_order(v, joints).into_iter().map(row).collect()
}

/// One row a joint whose drive was simulated; none where drives were not.
pub(crate) fn drives(v: &Verdict, joints: &[JointSignals]) -> Vec<Value> {
    let row = |(name, a): (&String, &Axis)| {
        let error = a.max_following_error?;
        let force = a.max_drive_force.map_or_else(|| "–".into(), compact);
        Some(json!({
            "name": name,
            "following": if a.unit == AxisUnit::Deg { format!("{}°", compact(error)) } else { length(error) },
            // A drive at its limit is a finding.
            "force": usage(
                format!("{force} {}", a.drive_force_unit.as_deref().unwrap_or("")),
                a.drive_utilisation,
                AT_LIMIT,
            ),
            "power": a.max_drive_power_w.map_or_else(|| "–".into(), |w| format!("{} W", compact(w))),
            "energy": a.drive_energy_j.map_or_else(|| "–".into(), |j| format!("{} kJ", compact(j * KJ_PER_J))),
        }))
    };
    in_order(v, joints).into_iter().filter_map(row).collect()
}

pub(crate) fn symbol(unit: &str) -> &str {
    if unit == "deg" { "°" } else { unit }
}
