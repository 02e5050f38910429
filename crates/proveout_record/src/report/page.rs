//! Fills the page's template.

use minijinja::value::Serde;
use proveout_sim::{
    finding::NEAR_MISS,
    verdict::{Gate, Partial, State, Verdict},
};
use serde::Serialize;
use serde_json::{Value, json};

use crate::page_template::{fill, policy, strip_control_chars};
use crate::{
    chart::{Bar, SignalStrip, histogram, svg},
    color::{DeviationMap, STEEL},
    contact::{ContactPicture, FIRST, SECOND},
    envelope::Envelope,
    error::RecordError,
    free_axes::ShownAxes,
    page_encoding::{Shades, base64, deflated, pack_mesh},
    page_scripts::{PLAYER, VIEWER},
    part::GLB_TRIANGLES,
    report::{
        data::{JointSignals, Page, PartView, ProcessSignals},
        findings::{FindingData, groups, marks},
        format::{compact, count, duration, file_name, fixed, length, length_or_dash, volume},
        gouge_excess_scale::Scales,
        player::PlayerView,
        roughness::{color_stops, color_table, map_data, map_figures, profile_figures, texture_rows, texture_words},
        rows::{axes, deviation, drives, inspection, operations, symbol, time, tools},
        scallop::scallop,
    },
};

const TEMPLATE: &str = include_str!("../../templates/report.html");
const CSS: &str = include_str!("../../templates/report.css");
const TEXTURE: &str = include_str!("../../templates/texture.js");
const BENCH: &str = include_str!("../../templates/bench.js");
const TABLES: &str = include_str!("../../templates/tables.js");

/// Scale of the chart of feeds over the highest programmed one.
const FEED_ROOM: f64 = 1.2;

/// A name and what it is.
#[derive(Serialize)]
pub(crate) struct NamedValue {
    name: String,
    value: String,
    note: String,
}

pub(crate) fn entry(name: &str, value: impl Into<String>, note: impl Into<String>) -> NamedValue {
    NamedValue { name: name.into(), value: value.into(), note: note.into() }
}

/// What a reader must know before the verdict: what was not the whole check, and what was not as the files
/// say.
fn notices(v: &Verdict) -> Vec<String> {
    let mut all: Vec<String> = v.partial.iter().flat_map(Partial::words).collect();
    if !v.set.is_empty() {
        let set: Vec<String> = v.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        all.push(format!("Not as the files say, set by the call: {}", set.join(", ")));
    }
    all
}

/// Writes the page as one string.
///
/// Every value of the run goes through the template's HTML escaping or through [`crate::chart`]; only
/// markup made here, the style sheet and the script are put in as they are.
///
/// # Errors
/// [`RecordError::Page`] when the template does not fit its data, which is a fault of this crate.
pub(crate) fn render(page: &Page<'_>) -> Result<String, RecordError> {
    let v = page.verdict;
    let end = v.time.total_s;
    let changes: Vec<f64> = page.process.tool_changes.iter().map(|c| c.0).collect();
    let order: Vec<&str> = page.joints.iter().map(|j| j.name.as_str()).collect();
    let has_mesh = !page.part.picture.triangles.is_empty();
    let mesh = if has_mesh { packed(page) } else { String::new() };
    let program = page.program;
    let told = FindingData {
        findings: &v.findings,
        explained: &program.explained,
        joints: &order,
        listings: &program.listings,
        contacts: page.contacts,
    };
    let mut data = json!({
        "program": v.program,
        "scene": v.scene,
        "machine": page.machine,
        "description": page.description.trim().trim_end_matches('.'),
        "verdict": verdict_words(v),
        "figures": figures(v),
        "gates": gates(v),
        "groups": groups(&told),
        "contacts": contacts(page),
        "unchecked": program.unchecked,
        "listing": listing(page),
        "path": if program.path.is_empty() { String::new() } else { deflated(&program.path.pack(&program.blocks, &program.numbers)) },
        "player": page.player.map(player),
        "program_notes": program_notes(page),
        "operations": operations(program),
        "contact_colors": contact_colors(),
        "mesh": mesh,
        "view_data": view_data(page),
        "mesh_notes": mesh_notes(page.part),
        "map": page.part.scales.map(|s| map_words(s, page.part)),
        "deviation": deviation(v),
        "scallop": v.surface.scallop.as_ref().map(scallop),
        "free_axes": page.axes.map(|a| free_axes(a, end)),
        "inspection": inspection(v),
        "time": time(v),
        "tools": tools(v, program),
        "process": process_plot(page.process, end, &changes),
        "tool_names": tool_changes(&page.process.tool_changes),
        "stretch": duration(page.process.feed.width().max(page.joints.first().map_or(0.0, |j| j.signals[0].width()))),
        "axes": axes(v, page.joints),
        "drives": drives(v, page.joints),
        "saturated": page.joints.iter().any(|j| !j.saturated.is_empty()),
        "plots": page.joints.iter().map(|j| joint_plot(j, end)).collect::<Vec<_>>(),
        "method": page.method.iter().map(|(n, value)| entry(n, value.clone(), "")).collect::<Vec<_>>(),
        "digests": v.digests.iter().map(|(n, d)| entry(n, d.clone(), "")).collect::<Vec<_>>(),
    });
    let rest = json!({
        "textures": texture_rows(&v.surface.textures),
        "texture_words": v.surface.textures.first().map(texture_words),
        "texture_maps": map_figures(page.textures),
        "texture_profiles": profile_figures(page.textures),
        "texture_stops": color_stops(),
        "texture_script": TEXTURE,
        "texture_data": texture_data(page),
        "notices": notices(v),
        "css": CSS,
        "viewer": VIEWER,
        "player_script": PLAYER,
        "bench_script": BENCH,
        "tables_script": TABLES,
        "policy": policy(&[VIEWER, PLAYER, BENCH, TABLES, TEXTURE]),
        "generator": format!("Written by proveout {}", env!("CARGO_PKG_VERSION")),
    });
    if let (Some(data), Value::Object(rest)) = (data.as_object_mut(), rest) {
        data.extend(rest);
    }
    fill("report.html", TEMPLATE, Serde(&data))
}

/// Free tool axes: room over time, and pictures at some places.
fn free_axes(axes: &ShownAxes, end: f64) -> Value {
    let strip = SignalStrip::new("Room of the tool axis, °", &axes.room, 110.0);
    let plot = if axes.room.is_empty() {
        String::new()
    } else {
        svg(&[strip], 960.0, end, &[], "Room of the tool axis over time")
    };
    json!({ "words": axes.words, "plot": plot, "figures": axes.figures, "unchecked": axes.unchecked })
}

/// What the script of the maps reads; nothing in it comes from a text of the user.
fn texture_data(page: &Page<'_>) -> String {
    json!({ "maps": map_data(page.textures), "colors": color_table() }).to_string()
}

fn contact_colors() -> [String; 2] {
    [FIRST, SECOND].map(|[r, g, b]| css([r, g, b, 255]))
}

/// Pictures of contacts in the order in which the causes number them.
fn contacts(page: &Page<'_>) -> Vec<Value> {
    let row = |p: &ContactPicture| {
        json!({
            "png": base64(&p.png),
            "bodies": p.bodies,
            "what": if p.code == NEAR_MISS.code { "First below the required clearance" } else { "First contact" },
            "words": p.time_s.map_or_else(String::new, |t| format!(" at {}", duration(t))),
        })
    };
    page.contacts.iter().map(row).collect()
}

/// The mesh for the viewer, with the blocks that made its vertices.
fn packed(page: &Page<'_>) -> String {
    let (picture, program) = (&page.part.picture, page.program);
    let blocks = program.blocks.tags(&picture.pieces);
    let shades = if page.part.scales.is_some() { Shades::Values } else { Shades::Plain };
    deflated(&pack_mesh(picture, shades, &blocks))
}

/// Data of the player, packed; its texts are escaped so that none can end the script element.
fn player(view: &PlayerView) -> Value {
    json!({
        "data": view.data.to_string().replace('<', "\\u003c").replace('/', "\\/"),
        "motion": deflated(&view.motion),
        "meshes": deflated(&view.meshes),
        "stock": deflated(&view.stock),
        "notes": view.notes,
    })
}

/// Files with their lines as JSON, compressed: name, number before the first line, count, numbers and texts
/// of the lines that are here.
fn listing(page: &Page<'_>) -> String {
    let program = page.program;
    let file = |(name, base): &(String, u32)| {
        let listing = program.listings.iter().find(|l| l.file == *name);
        let shown = listing.map_or(&[][..], |l| l.shown.as_slice());
        let text: Vec<String> = shown.iter().map(|l| strip_control_chars(l.1.clone())).collect();
        // Numbers only where lines are missing.
        let whole = shown.iter().enumerate().all(|(k, l)| l.0 == k as u32 + 1);
        let numbers: Vec<u32> = if whole { Vec::new() } else { shown.iter().map(|l| l.0).collect() };
        json!({ "name": file_name(name), "base": base, "numbers": numbers, "text": text })
    };
    let all: Vec<Value> = program.numbers.files.iter().map(file).collect();
    deflated(json!(all).to_string().as_bytes())
}

fn program_notes(page: &Page<'_>) -> Vec<String> {
    let program = page.program;
    let mut notes = Vec::new();
    if !program.left_out.is_empty() {
        notes.push(program.left_out.clone());
    }
    if program.path.left_out > 0 {
        notes.push(format!(
            "The path is shown to {}; {} blocks between the others have none.",
            length(program.path.step()),
            count(program.path.left_out)
        ));
    }
    notes
}

fn verdict_words(v: &Verdict) -> Value {
    let not_asked = v.not_asked().join(", ");
    let (class, word, meaning) = match v.verdict {
        State::Pass if not_asked.is_empty() => ("pass", "Pass", "Every gate was checked and passed.".to_owned()),
        State::Pass => ("pass", "Pass", format!("Every gate that was asked passed. Not asked: {not_asked}.")),
        State::Fail => ("fail", "Fail", "Not for the machine: see the findings.".to_owned()),
        State::Unchecked | State::NotAsked => {
            ("unchecked", "Unchecked", "No fault found, but not all was checked.".to_owned())
        }
    };
    json!({ "class": class, "word": word, "meaning": meaning })
}

fn figures(v: &Verdict) -> Vec<NamedValue> {
    let mut out = vec![entry("Cycle time", duration(v.time.total_s), "")];
    let errors = v.findings.iter().filter(|f| f.severity == proveout_sim::finding::Severity::Error).count() as u64;
    let rest = v.findings.len() as u64 - errors;
    let further =
        if rest == 1 { "and 1 warning or note".into() } else { format!("and {} warnings and notes", count(rest)) };
    out.push(entry("Errors", count(errors), if rest == 0 { String::new() } else { further }));
    let fallen = v.removal.fallen_mm3;
    let fallen = if fallen > 0.0 { format!(", {} fallen off", volume(fallen)) } else { String::new() };
    let left = format!("{} left{fallen}", volume(v.removal.stock_left_mm3));
    out.push(entry("Removed", volume(v.removal.volume_mm3), left));
    let d = &v.deviation;
    if d.gouge_max_mm.is_some() || d.excess_max_mm.is_some() {
        out.push(entry("Deepest gouge", length_or_dash(d.gouge_max_mm), ""));
        out.push(entry("Most material left", length_or_dash(d.excess_max_mm), ""));
    }
    let pair = v.clearance.pair.as_ref().map_or_else(String::new, |[a, b]| format!("{a} to {b}"));
    // Bodies that meet have none, and nothing is known of it to a part of a micrometer.
    if v.clearance.min_mm.is_some_and(|min| min <= 0.0) {
        out.push(entry("Least clearance", "none".to_owned(), format!("{pair}: they meet")));
    } else {
        let error = v.clearance.error_mm.map_or_else(String::new, |e| format!(", less by no more than {}", length(e)));
        out.push(entry("Least clearance", length_or_dash(v.clearance.min_mm), pair + &error));
    }
    if let Some(ratio) = v.path.min_feed_ratio {
        out.push(entry("Lowest feed", format!("{} %", fixed(100.0 * ratio, 0)), "of the programmed feed"));
    }
    out
}

/// Names the tool changes when they are few, and counts them otherwise; empty when there are none.
fn tool_changes(changes: &[(f64, String)]) -> String {
    match changes.len() {
        0 => String::new(),
        1..=8 => {
            let names: Vec<String> = changes.iter().map(|(t, n)| format!("{n} at {}", duration(*t))).collect();
            format!("tool change ({})", names.join(", "))
        }
        n => format!("{n} tool changes"),
    }
}

fn gates(v: &Verdict) -> Vec<Value> {
    let question = |gate: Gate| match gate {
        Gate::Program => "Program runs to its end",
        Gate::Limits => "Travel and drive limits kept",
        Gate::Process => "No rapid, shank or neck in material",
        Gate::Collision => "No collision",
        Gate::NearMiss => "Clearance kept",
        Gate::Gouge => "No gouge",
        Gate::Excess => "No material left",
        Gate::Surface => "Surface texture",
    };
    let row = |g: &proveout_sim::verdict::GateVerdict| {
        let (class, word) = match g.state {
            State::Pass => ("pass", "Pass"),
            State::Fail => ("fail", "Fail"),
            State::Unchecked => ("unchecked", "Unchecked"),
            State::NotAsked => ("not_asked", "Not asked"),
        };
        json!({ "question": question(g.gate), "class": class, "word": word, "reason": g.reason })
    };
    v.gates.iter().map(row).collect()
}

/// JSON for the script; `<` is written as an escape so that no value can end the script element.
fn view_data(page: &Page<'_>) -> String {
    let map: Vec<u8> = (0..256).flat_map(|i| DeviationMap::at(f64::from(i) / 255.0).into_iter().take(3)).collect();
    json!({
        "values": page.part.scales.is_some(),
        "blocks": !page.part.picture.pieces.is_empty(),
        "scales": page.part.scales.map(|s| [s.gouge, s.excess].map(|s| [s.shown, s.most_points, s.largest, s.tolerance])),
        "map": base64(&map),
        "plain": STEEL[..3],
        "marks": marks(&page.verdict.findings),
        "error": mesh_error(page),
    })
    .to_string()
    .replace('<', "\\u003c")
}

/// How far a place on the mesh of the page may lie from the surface of the stock, mm: the diagonal of a cell
/// that its vertices were gathered in, and the rounding of their places.
fn mesh_error(page: &Page<'_>) -> f64 {
    let cell = page.part.cell.unwrap_or(page.verdict.removal.cell_mm);
    let size = page.part.picture.aabb().size();
    3.0_f64.sqrt() * cell + if size.norm().is_finite() { 0.5 * size.norm() / f64::from(u16::MAX) } else { 0.0 }
}

fn mesh_notes(part: &PartView) -> Vec<String> {
    let mut notes = Vec::new();
    if part.picture.triangles.is_empty() {
        notes.push("There is no surface to show.".into());
    } else if let Some(cell) = part.cell {
        notes.push(format!(
            "Shown with {} of {} triangles, gathered in cells of {}; {} is in part.glb.",
            count(part.picture.triangles.len() as u64),
            count(part.triangles as u64),
            length(cell),
            if part.triangles <= GLB_TRIANGLES { "the whole surface" } else { "a finer one" }
        ));
    }
    if part.scales.is_none() {
        notes.push("The scene has no design part, so the surface carries no deviations.".into());
    }
    notes
}

fn css(c: [u8; 4]) -> String {
    format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2])
}

fn map_words(scales: Scales, part: &PartView) -> Value {
    let stops: Vec<String> = (0..=16).map(|i| css(DeviationMap::at(f64::from(i) / 16.0))).collect();
    let [low, high] = [-scales.gouge.shown, scales.excess.shown].map(length);
    let n = part.shares.len().max(1) as f64;
    let bars: Vec<Bar> = part
        .shares
        .iter()
        .enumerate()
        .map(|(i, &share)| Bar { share, color: css(DeviationMap::at((i as f64 + 0.5) / n)) })
        .collect();
    let outside = if part.outside.iter().any(|s| *s > 0.0) {
        let [below, above] = part.outside.map(|s| compact(s * 100.0));
        format!(" {below} % lie below and {above} % above the scales.")
    } else {
        String::new()
    };
    json!({
        "stops": stops.join(", "),
        "histogram": histogram(&bars, [&low, "0", &high], "Distribution of the deviation"),
        "low": low,
        "high": high,
        "gouge": scales.gouge.shown,
        "excess": scales.excess.shown,
        "note": format!("Share of the measured surface points in each class; each side has a scale of its own.{outside}"),
    })
}

#[derive(Serialize)]
struct Plot {
    name: String,
    svg: String,
}

fn joint_plot(joint: &JointSignals, end: f64) -> Plot {
    let unit = symbol(joint.unit);
    let names = ["Position", "Velocity", "Acceleration", "Jerk"];
    let per = ["", "/s", "/s²", "/s³"];
    let both = |limit: Option<f64>| [limit.map(|l| -l), limit];
    let mut strips: Vec<SignalStrip<'_>> = (0..4_usize)
        .map(|k| SignalStrip {
            limits: match k.checked_sub(1) {
                None => joint.travel.map_or([None; 2], |t| t.map(Some)),
                Some(k) => both(joint.limits[k]),
            },
            ..SignalStrip::new(
                format!("{}, {unit}{}", names[k], per[k]),
                &joint.signals[k],
                if k == 0 { 84.0 } else { 62.0 },
            )
        })
        .collect();
    let mut what = "position, velocity, acceleration and jerk".to_owned();
    if joint.following.range().is_some() {
        let force = SignalStrip::new(format!("Drive {}, {}", joint.effort, joint.force_unit), &joint.force, 62.0);
        strips.extend([
            SignalStrip::new(format!("Following error, {unit}"), &joint.following, 62.0),
            SignalStrip { limits: both(joint.force_limit), marks: joint.saturated.marked(), ..force },
            SignalStrip::new("Drive power, W", &joint.power, 62.0),
        ]);
        what = format!("position, velocity, acceleration, jerk, following error, drive {} and power", joint.effort);
    }
    let name = format!("Axis {}", joint.name);
    Plot { svg: svg(&strips, 560.0, end, &[], &format!("{name}: {what} over time")), name }
}

fn process_plot(process: &ProcessSignals, end: f64, changes: &[f64]) -> String {
    // Rapids would press the feeds flat.
    let highest = process.feed_programmed.range().map(|r| FEED_ROOM * r[1]).filter(|h| *h > 0.0);
    let over = process.feed.range().zip(highest).is_some_and(|(r, h)| r[1] > h);
    let name = "Feed reached (blue) and programmed (orange), mm/min";
    let name = if over { format!("{name}; rapids go to the upper edge") } else { name.to_owned() };
    let feed = SignalStrip::new(name, &process.feed, 96.0);
    let mut strips = vec![
        SignalStrip { second: Some(&process.feed_programmed), ceiling: highest, ..feed },
        SignalStrip::new("Removal rate, mm³/s", &process.removal, 70.0),
    ];
    if !Envelope::is_empty(&process.clearance) {
        strips.push(SignalStrip::new("Proved clearance, mm", &process.clearance, 60.0));
    }
    svg(&strips, 1080.0, end, changes, "Feed and removal rate over time")
}
