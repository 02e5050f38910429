//! Rows of the page's tables, as text.

use proveout_sim::{
    compare::{Comparison, ProgramFigures, TimeGain, VariationKind},
    verdict::State,
};
use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    chart::Style,
    report::{
        format::{compact, fixed, length_or_dash},
        rows::symbol,
    },
    units::{MM_PER_UM, UM_PER_MM},
};

/// Class and word of a judgement.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct GateWord {
    class: &'static str,
    word: &'static str,
}

pub(crate) fn judged(state: State) -> GateWord {
    let (class, word) = match state {
        State::Pass => ("pass", "Pass"),
        State::Fail => ("fail", "Fail"),
        State::Unchecked => ("unchecked", "Unchecked"),
        State::NotAsked => ("not_asked", "Not asked"),
    };
    GateWord { class, word }
}

/// Programs with their place in the order of the scene, which gives their color.
pub(crate) fn programs(c: &Comparison) -> Vec<(usize, &str, &ProgramFigures)> {
    let known = |(i, name): (usize, &'_ String)| Some((i, c.programs.get_key_value(name)?));
    c.order.iter().enumerate().filter_map(known).map(|(i, (name, p))| (i, name.as_str(), p)).collect()
}

fn dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".into(), |v| fixed(v, digits))
}

/// A gain with its error.
#[derive(Serialize)]
pub(crate) struct GainWords {
    percent: String,
    error: String,
    parts: String,
    rate: String,
    sign: &'static str,
    class: &'static str,
}

pub(crate) fn gain(g: &TimeGain) -> GainWords {
    let (sign, class) = if g.sign_holds { ("sign holds", "pass") } else { ("sign changes", "fail") };
    let parts = match (g.numerical_percent, g.model_percent) {
        (Some(n), Some(m)) => format!("numerical {}, model {}", fixed(n, 3), fixed(m, 2)),
        _ => "no variation was made".into(),
    };
    GainWords {
        percent: dash(g.percent, 2),
        error: dash(g.error_percent, 2),
        parts,
        rate: dash(g.rate_percent, 1),
        sign,
        class,
    }
}

pub(crate) fn program_rows(c: &Comparison) -> Vec<Value> {
    let row = |(i, name, p): (usize, &str, &ProgramFigures)| {
        json!({
            "class": Style::Program(i).class(),
            "name": name,
            "made": p.made.as_ref().map_or_else(
                || if name == c.baseline { "baseline".into() } else { String::new() },
                |m| format!("{} from {} ({})", m.method, m.from, m.source),
            ),
            "verdict": judged(p.verdict),
            "errors": p.errors,
            "total": dash(Some(p.time.total_s), 3),
            "cutting": dash(Some(p.time.cutting_s), 3),
            "stretch": dash(p.stretch.as_ref().map(|s| s.time_s), 3),
            "programmed": dash(p.stretch.as_ref().map(|s| s.programmed_s), 3),
            "bound": dash(p.time.lower_bound_s, 3),
            "gains": c.gains.get(name).map(|g| [&g.cycle_time, &g.cutting_time, &g.stretch_time].map(gain)),
            "report": format!("{}/report.html", p.folder),
        })
    };
    programs(c).into_iter().map(row).collect()
}

/// Limits that the scene sets, with those of the machine for comparison.
pub(crate) fn limits(c: &Comparison) -> Vec<Value> {
    let row = |l: &proveout_sim::compare::ChangedLimit| {
        json!({
            "machine": l.machine,
            "joint": l.joint,
            "quantity": l.quantity,
            "own": l.of_machine.map_or_else(|| "none".into(), compact),
            "set": compact(l.of_scene),
            "unit": l.unit,
            "source": l.source,
        })
    };
    c.joint_limits.iter().map(row).collect()
}

/// Decimals that show how a value differs from the published one.
fn digits(published: f64) -> usize {
    if published.abs() < 2.0 { 3 } else { 1 }
}

pub(crate) fn choices(c: &Comparison) -> Vec<Value> {
    let row = |choice: &proveout_sim::compare::TriedChoice| {
        let change = |(name, [low, high]): (&String, &[f64; 2])| {
            let row = c.published.iter().find(|p| p.name == *name);
            let digits = row.map_or(1, |p| digits(p.published));
            let unit = row.map_or("", |p| p.unit.as_str());
            format!("{name}: {} to {} {unit}", fixed(*low, digits), fixed(*high, digits))
        };
        let mut acts: Vec<String> = choice.acts_on.iter().map(change).collect();
        if acts.is_empty() {
            acts.push("nothing".to_owned());
        }
        if !choice.refused.is_empty() {
            acts.push(format!("a value was refused: {}", choice.refused));
        }
        json!({
            "name": choice.name,
            "key": choice.key,
            "tried": choice.tried.join(", "),
            "source": choice.source,
            "reason": choice.reason,
            "acts": acts,
        })
    };
    c.choices.iter().flat_map(|open| &open.choices).map(row).collect()
}

pub(crate) fn published(c: &Comparison) -> Vec<Value> {
    let row = |p: &proveout_sim::compare::Published| {
        let over = [p.over_choices, p.over_draws, p.over_twin].map(|range| {
            let digits = digits(p.published);
            range.map_or_else(
                || "cannot act".to_owned(),
                |[low, high]| format!("{} to {}", fixed(low, digits), fixed(high, digits)),
            )
        });
        json!({
            "name": p.name,
            "measured": p.measured,
            "published": format!("{}{} {}", p.kind.label(), compact(p.published), p.unit),
            "value": p.value.map_or_else(|| "–".into(), |v| format!("{} {}", fixed(v, 1), p.unit)),
            "band": p.band.map_or_else(|| "none".into(), |[low, high]| format!("{} to {}", compact(low), compact(high))),
            "judged": judged(p.state),
            "word": p.agreement.words(),
            "why": p.not_comparable,
            "decided": p.decided_by.as_ref().map(|(name, [low, high])| {
                let digits = digits(p.published);
                format!("{name}: {} to {}", fixed(*low, digits), fixed(*high, digits))
            }),
            "null": p.null_value.map_or_else(String::new, |v| format!("{} {}", fixed(v, digits(p.published)), p.unit)),
            "over": over,
            "source": p.source,
            "remark": p.remark,
        })
    };
    c.published.iter().map(row).collect()
}

pub(crate) fn expectations(c: &Comparison) -> Vec<Value> {
    let row = |e: &proveout_sim::compare::Expectation| {
        let unit = symbol(&e.unit);
        let bound = match (e.at_least, e.at_most) {
            (Some(low), Some(high)) => format!("{} to {} {unit}", compact(low), compact(high)),
            (Some(low), None) => format!("at least {} {unit}", compact(low)),
            (None, Some(high)) => format!("at most {} {unit}", compact(high)),
            (None, None) => "pass".into(),
        };
        json!({
            "name": e.name,
            "measured": e.measured,
            "value": e.value.map_or_else(|| "–".into(), |v| format!("{} {}", compact(v), symbol(&e.unit))),
            "bound": bound,
            "judged": judged(e.state),
            "reason": if e.state == State::Pass { String::new() } else { e.reason.clone() },
        })
    };
    c.expectations.iter().map(row).collect()
}

pub(crate) fn variations(c: &Comparison) -> Vec<Value> {
    let row = |v: &proveout_sim::compare::Variation| {
        json!({
            "name": v.name,
            "kind": match v.kind {
                VariationKind::Numerical => "numerical",
                VariationKind::Model => "model",
            },
            "unchecked": v.unchecked.clone().unwrap_or_default(),
            "gains": c
                .order
                .iter()
                .filter_map(|name| v.gains.get(name))
                .map(|g| {
                    [
                        dash(g.stretch_time_percent, 3),
                        g.stretch_time_change_percent.map_or("–".into(), |p| format!("{p:+.4}")),
                    ]
                })
                .collect::<Vec<_>>(),
        })
    };
    c.variations.iter().map(row).collect()
}

/// Joints in machine order, each with a row a program.
pub(crate) fn joints(c: &Comparison, order: &[String]) -> Vec<Value> {
    let all = programs(c);
    let one = |joint: &String| {
        let unit = all.iter().find_map(|(_, _, p)| p.axes.get(joint)).map(|a| symbol(a.unit.name()).to_owned())?;
        let row = |(i, name, p): &(usize, &str, &ProgramFigures)| {
            let axis = p.stretch.as_ref().and_then(|s| s.axes.get(joint));
            let whole = p.axes.get(joint);
            let known = |v: Option<f64>| v.map_or_else(|| "–".into(), compact);
            let values = [
                axis.and_then(|a| a.demand_velocity),
                axis.and_then(|a| a.demand_acceleration),
                axis.map(|a| a.max_velocity),
                axis.map(|a| a.max_acceleration),
                axis.map(|a| a.max_jerk),
                whole.map(|a| a.max_velocity),
                whole.map(|a| a.max_acceleration),
                whole.map(|a| a.max_jerk),
            ];
            let count = |n: Option<u64>| n.map_or_else(|| "–".into(), |n| n.to_string());
            json!({
                "class": Style::Program(*i).class(),
                "program": name,
                "values": values.map(known),
                "reversals": [count(axis.map(|a| a.reversals)), count(whole.map(|a| a.reversals))],
            })
        };
        Some(json!({ "name": joint, "unit": unit, "rows": all.iter().map(row).collect::<Vec<_>>() }))
    };
    order.iter().filter_map(one).collect()
}

pub(crate) fn parts(c: &Comparison) -> Vec<Value> {
    let row = |(i, name, p): (usize, &str, &ProgramFigures)| {
        let d = p.difference.as_ref();
        let range = d.and_then(|d| d.min_mm.zip(d.max_mm));
        let change = c.gains.get(name).and_then(|g| g.scallop_max_change_percent);
        json!({
            "class": Style::Program(i).class(),
            "program": name,
            "gouge": length_or_dash(p.deviation.gouge_max_mm),
            "excess": length_or_dash(p.deviation.excess_max_mm),
            "mean": length_or_dash(p.deviation.mean_mm),
            "rms": length_or_dash(p.deviation.rms_mm),
            "scallop_max": length_or_dash(p.surface.scallop_max_um.map(|v| MM_PER_UM * v)),
            "scallop_mean": length_or_dash(p.surface.scallop_mean_um.map(|v| MM_PER_UM * v)),
            "scallop_change": change.map_or_else(|| "–".into(), |v| format!("{v:+.2} %")),
            "difference_rms": length_or_dash(d.and_then(|d| d.rms_mm)),
            "difference_range": range.map_or_else(
                || "–".into(),
                |(low, high)| format!("{} to {} µm", fixed(UM_PER_MM * low, 2), fixed(UM_PER_MM * high, 2)),
            ),
            "clearance": length_or_dash(p.clearance.min_mm),
        })
    };
    programs(c).into_iter().map(row).collect()
}
