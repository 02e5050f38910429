//! Fills the page's template.

use std::collections::BTreeMap;

use minijinja::value::Serde;
use proveout_sim::compare::{Compared, Comparison, Pictures, Role, Study, StudyCurve, VariationKind};
use serde::Serialize;
use serde_json::{Value, json};

use super::{
    Trace, part,
    rows::{self, judged},
};
use crate::page_template::{fill, policy};
use crate::{
    chart::{Chart, DotRow, Series, Style, dots},
    error::RecordError,
    page_scripts::VIEWER,
    report::{format::fixed, rows::symbol},
};

const TEMPLATE: &str = include_str!("../../templates/compare.html");
const CSS: &str = include_str!("../../templates/report.css");
const MORE_CSS: &str = include_str!("../../templates/compare.css");
const MAPS: &str = include_str!("../../templates/maps.js");
const WIDTH: f64 = 1080.0;
/// Size of a chart in which a degree is as long across as up: its frame, with the margins of names and
/// numbers.
const SQUARE: [f64; 2] = [536.0, 569.2];
/// A held joint trembles by the rounding of corners and by the decimals of the text: less is no motion that
/// was asked for, mm/s or degrees/s.
const ASKED_FOR: f64 = 1e-3;

#[derive(Serialize)]
struct LegendKey {
    class: String,
    name: String,
}

/// A plot with its heading.
#[derive(Serialize)]
struct Plot {
    title: String,
    note: String,
    keys: Vec<LegendKey>,
    charts: Vec<String>,
    figures: Vec<[String; 2]>,
}

/// Writes the page as one string; every value goes through the template's escaping or that of the charts.
///
/// # Errors
/// [`RecordError::Page`] when the template does not fit its data, which is a fault of this crate.
pub(crate) fn render(compared: &Compared, traces: &[Trace]) -> Result<String, RecordError> {
    let (c, pictures) = (&compared.comparison, &compared.pictures);
    let order: Vec<String> = pictures.joints.iter().map(|j| j.name.clone()).collect();
    let view = pictures.part.as_ref().and_then(|p| part::view(p, &c.order, &c.baseline));
    let (rotary, linear): (Vec<usize>, Vec<usize>) =
        moving(c, pictures).into_iter().partition(|&j| pictures.joints[j].unit == "deg");
    let plots = |joints: &[usize]| -> Vec<Plot> {
        joints
            .iter()
            .flat_map(|&j| [demand_plot(c, pictures, j), trace_plot(c, pictures, traces, j)])
            .flatten()
            .collect()
    };
    let data = json!({
        "css": CSS,
        "more_css": MORE_CSS,
        "viewer": VIEWER,
        "policy": policy(&[VIEWER, MAPS]),
        "generator": format!("Written by proveout {}", env!("CARGO_PKG_VERSION")),
        "scene": c.scene,
        "experiment": c.experiment.trim().trim_end_matches('.'),
        "description": c.description.trim().trim_end_matches('.'),
        "machine": c.machine,
        "baseline": c.baseline,
        "limits_words": c.limits_in_words(),
        "same_texts": c.same_texts_in_words(),
        "limits": rows::limits(c),
        "verdict": judged(c.verdict),
        "keys": keys(c),
        "others": c.order.iter().filter(|n| **n != c.baseline).collect::<Vec<_>>(),
        "headlines": headlines(c),
        "programs": rows::program_rows(c),
        "published": rows::published(c),
        "published_chart": published_chart(c),
        "null_program": c.null_program,
        "choices": rows::choices(c),
        "draws": c.choices.as_ref().map(|o| (o.draws, o.refused, o.reasons.join("; "))),
        "expectations": rows::expectations(c),
        "variations": rows::variations(c),
        "variation_chart": variation_chart(c),
        "studies": studies(c, pictures),
        "rotary": plots(&rotary),
        "linear": plots(&linear),
        "joints": rows::joints(c, &order),
        "parts": rows::parts(c),
        "rules": &c.rules,
        "mesh": view.as_ref().map(|v| v.mesh.as_str()),
        "view_data": view.as_ref().map(|v| v.data.as_str()),
        "layers": view.as_ref().map(|v| v.layers.clone()),
        "first_layer": view.as_ref().map(|v| v.first),
        "flat": view.as_ref().map(|v| &v.flat),
        "maps_script": MAPS,
        "legend_colors": view.as_ref().map(|v| v.stops.as_str()),
        "legend_low": view.as_ref().map(|v| v.low.as_str()),
        "legend_high": view.as_ref().map(|v| v.high.as_str()),
    });
    fill("compare.html", TEMPLATE, Serde(&data))
}

fn keys(c: &Comparison) -> Vec<LegendKey> {
    let key = |(i, name): (usize, &String)| LegendKey { class: Style::Program(i).class(), name: name.clone() };
    c.order.iter().enumerate().map(key).collect()
}

fn headlines(c: &Comparison) -> Vec<Value> {
    let others = c.order.iter().enumerate().filter_map(|(i, name)| Some((i, name, c.gains.get(name)?)));
    let headline = |(i, name, g): (usize, &String, &proveout_sim::compare::Gain)| {
        json!({
            "name": name,
            "class": Style::Program(i).class(),
            "stretch": rows::gain(&g.stretch_time),
            "cycle": rows::gain(&g.cycle_time),
            "own_limits": c.at_own_limits(name).map(|v| fixed(v, 2)),
        })
    };
    others.map(headline).collect()
}

fn published_chart(c: &Comparison) -> Option<String> {
    let percent: Vec<_> = c.published.iter().filter(|p| p.unit == "%").collect();
    if percent.is_empty() {
        return None;
    }
    // One color for ours: the program changes from row to row and is named in the table.
    let row = |p: &&proveout_sim::compare::Published| DotRow {
        name: p.name.clone(),
        band: p.band,
        reference: Some(p.published),
        dots: p.value.map(|v| (2, v)).into_iter().collect(),
    };
    Some(dots(&percent.iter().map(row).collect::<Vec<_>>(), "percent", "Published values and ours", WIDTH))
}

fn variation_chart(c: &Comparison) -> Option<String> {
    let rows: Vec<DotRow> = c
        .variations
        .iter()
        .filter(|v| v.unchecked.is_none())
        .map(|v| DotRow {
            name: format!("{}{}", v.name, if v.kind == VariationKind::Numerical { " (numerical)" } else { "" }),
            band: None,
            reference: None,
            dots: c
                .order
                .iter()
                .enumerate()
                .filter_map(|(i, name)| Some((i, v.gains.get(name)?.stretch_time_percent?)))
                .collect(),
        })
        .collect();
    let nominal = DotRow {
        name: "nominal twin".into(),
        band: None,
        reference: None,
        dots: c
            .order
            .iter()
            .enumerate()
            .filter_map(|(i, name)| Some((i, c.gains.get(name)?.stretch_time.percent?)))
            .collect(),
    };
    let all: Vec<DotRow> = std::iter::once(nominal).chain(rows).collect();
    let scale = format!("time of the cutting stretch saved against {}, percent", c.baseline);
    (!c.variations.is_empty()).then(|| dots(&all, &scale, "Gain under every variation of the twin", WIDTH))
}

/// Joints that a program asks to move in its cutting stretch.
fn moving(c: &Comparison, pictures: &Pictures) -> Vec<usize> {
    let moves = |name: &str| {
        let axes = c.programs.values().filter_map(|p| p.stretch.as_ref()?.axes.get(name));
        axes.into_iter().any(|a| a.demand_velocity.unwrap_or(a.max_velocity) > ASKED_FOR)
    };
    pictures.joints.iter().enumerate().filter(|(_, j)| moves(&j.name)).map(|(i, _)| i).collect()
}

/// Charts above each other with one abscissa.
fn stack(
    title: &str,
    abscissa: &str,
    range: Option<[f64; 2]>,
    strips: Vec<(String, Vec<Series>, Vec<f64>)>,
) -> Vec<String> {
    let last = strips.len().saturating_sub(1);
    let strip = |(i, (name, series, limits)): (usize, (String, Vec<Series>, Vec<f64>))| {
        Chart {
            label: format!("{title}: {name}"),
            axes: [abscissa.to_owned(), name],
            range,
            size: [WIDTH, if i == last { 186.0 } else { 160.0 }],
            series,
            limits,
            abscissa: i == last,
        }
        .svg()
    };
    strips.into_iter().enumerate().map(strip).collect()
}

fn demand_plot(c: &Comparison, pictures: &Pictures, joint: usize) -> Option<Plot> {
    let j = &pictures.joints[joint];
    let unit = symbol(j.unit);
    let series = |of: fn(&proveout_sim::compare::DemandRow) -> f64| -> Vec<Series> {
        let programs = pictures.programs.iter().enumerate();
        let one = |(i, p): (usize, &proveout_sim::compare::ProgramPicture)| {
            let rows = p.demand.get(joint).map(Vec::as_slice).unwrap_or_default();
            Series { style: Style::Program(i), points: rows.iter().map(|r| [r.time_s, of(r)]).collect() }
        };
        programs.map(one).collect()
    };
    if pictures.programs.iter().all(|p| p.demand.get(joint).is_none_or(Vec::is_empty)) {
        return None;
    }
    let limit = |k: usize| j.limits[k].map_or_else(Vec::new, |l| vec![l, -l]);
    let title = format!("Axis {}: demand of the programs at their programmed feed", j.name);
    let strips = vec![
        (format!("Position, {unit}"), series(|r| r.position), Vec::new()),
        (format!("Velocity, {unit}/s"), series(|r| r.velocity), limit(0)),
        (format!("Acceleration, {unit}/s²"), series(|r| r.acceleration), limit(1)),
    ];
    let charts =
        stack(&title, "programmed time since the begin of the cutting stretch, s", pictures.plot_window_s, strips);
    let note = "Differences over the blocks of the program; equal abscissas are equal places on the part. Dashed: limit of the machine.";
    Some(Plot { title, note: note.into(), keys: keys(c), charts, figures: Vec::new() })
}

fn trace_plot(c: &Comparison, pictures: &Pictures, traces: &[Trace], joint: usize) -> Option<Plot> {
    let j = &pictures.joints[joint];
    let unit = symbol(j.unit);
    let series = |signal: usize| -> Vec<Series> {
        let one = |(i, trace): (usize, &Trace)| {
            let envelope = trace.windows[1].get(joint).map(|t| t.signals[signal].stretches()).unwrap_or_default();
            // The envelope as one line: both ends of each stretch of time.
            let points = envelope.into_iter().flat_map(|(t, low, high)| [[t, low], [t, high]]).collect();
            Series { style: Style::Program(i), points }
        };
        traces.iter().enumerate().map(one).collect()
    };
    if traces.iter().all(|t| t.windows[1].get(joint).is_none_or(|s| s.signals[0].is_empty())) {
        return None;
    }
    let limit = |k: usize| j.limits[k].map_or_else(Vec::new, |l| vec![l, -l]);
    let title = format!("Axis {}: set points of the control", j.name);
    let strips = vec![
        (format!("Position, {unit}"), series(0), Vec::new()),
        (format!("Velocity, {unit}/s"), series(1), limit(0)),
        (format!("Acceleration, {unit}/s²"), series(2), limit(1)),
        (format!("Jerk, {unit}/s³"), series(3), limit(2)),
    ];
    let charts = stack(&title, "time since the begin of the same stretch of the path, s", None, strips);
    let note = "Set points under the limits of the machine (dashed); a program that ends earlier is faster.";
    Some(Plot { title, note: note.into(), keys: keys(c), charts, figures: Vec::new() })
}

fn studies(c: &Comparison, pictures: &Pictures) -> Vec<Plot> {
    // Methods on the same path are shown on the same part of it, which the first one with marks decides.
    let mut windows: Windows<'_> = BTreeMap::new();
    for curve in pictures.programs.iter().flat_map(|p| p.studies.iter().flat_map(|s| &s.curves)) {
        if let Some(range) = window(curve) {
            windows.entry((&curve.axes, &curve.units)).or_insert(range);
        }
    }
    let mut out = Vec::new();
    for (i, program) in pictures.programs.iter().enumerate() {
        for (k, study) in program.studies.iter().enumerate() {
            let method = c.programs.get(&program.name).and_then(|p| p.made.as_ref());
            let run = if program.studies.len() > 1 { format!(", run {}", k + 1) } else { String::new() };
            let title = match method {
                Some(m) => format!("{}{run}: {}, {}", program.name, m.method, m.source),
                None => format!("{}{run}", program.name),
            };
            out.extend(study_plots(&title, i, study, &windows));
        }
    }
    out
}

/// Part of a plot that is shown, by the quantities of its axes.
type Windows<'a> = BTreeMap<(&'a [String; 2], &'a [String; 2]), [f64; 2]>;

/// One plot for each pair of quantities; closely where marks divide the path.
fn study_plots(title: &str, program: usize, study: &Study, windows: &Windows<'_>) -> Vec<Plot> {
    let mut groups: BTreeMap<(&[String; 2], &[String; 2]), Vec<&StudyCurve>> = BTreeMap::new();
    for curve in &study.curves {
        groups.entry((&curve.axes, &curve.units)).or_default().push(curve);
    }
    let mut figures: Vec<[String; 2]> = study
        .figures
        .iter()
        .map(|f| [f.name.clone(), format!("{} {}", crate::report::format::compact(f.value), symbol(&f.unit))])
        .collect();
    let mut out = Vec::new();
    for ((axes, units), mut curves) in groups {
        curves.sort_by_key(|c| c.role);
        let style = |role: Role| match role {
            Role::Limit => Style::Limit,
            Role::Original => Style::Program(0),
            Role::Polyline => Style::Guide,
            Role::Result => Style::Program(program),
            Role::KeyPoints => Style::Circles,
            Role::Marks => Style::Triangles,
        };
        let series = curves.iter().map(|c| Series { style: style(c.role), points: c.points.clone() }).collect();
        let names = [0, 1].map(|k| {
            let unit = symbol(&units[k]);
            let name = capital(&axes[k]);
            if unit.is_empty() { name } else { format!("{name}, {unit}") }
        });
        let range = windows.get(&(axes, units)).copied();
        let chart = Chart {
            label: format!("{title}: {} over {}", axes[1], axes[0]),
            axes: names,
            range,
            size: if curves.iter().any(|c| c.equal_scales) { SQUARE } else { [WIDTH, 430.0] },
            series,
            limits: Vec::new(),
            abscissa: true,
        };
        let note = match range {
            Some([from, to]) => format!(
                "Between {} and {} {} of the path: from one layer to the next in its middle.",
                fixed(from, 1),
                fixed(to, 1),
                units[0]
            ),
            None => String::new(),
        };
        let keys = curves.iter().map(|c| LegendKey { class: style(c.role).class(), name: c.name.clone() }).collect();
        let figures = std::mem::take(&mut figures);
        out.push(Plot { title: title.to_owned(), note, keys, charts: vec![chart.svg()], figures });
    }
    out
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The stretch between two neighboring marks in the middle of the path, with a margin; none without two
/// marks.
fn window(curve: &StudyCurve) -> Option<[f64; 2]> {
    if curve.role != Role::Marks {
        return None;
    }
    let at = (curve.points.len() / 2).checked_sub(1)?;
    let (from, to) = (curve.points.get(at)?[0], curve.points.get(at + 1)?[0]);
    let margin = 0.04 * (to - from);
    (to > from).then_some([from - margin, to + margin])
}
