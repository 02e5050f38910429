//! Roughness maps on the page: a picture a patch with its color bar, the profile at a clicked place, and the
//! parameters.

use proveout_sim::verdict::TextureUsed;
use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    chart::{SignalStrip, svg},
    color::height_color,
    page_encoding::base64,
    report::{
        format::{count, fixed},
        rows::symbol,
    },
    roughness_map::{ShownProfile, ShownTexture},
    units::UM_PER_MM,
};

/// Largest number of maps with a picture, and nodes along their sides: 2.5 MB of page. The others are in
/// the table.
pub(crate) const PAGE_MAPS: usize = 24;
pub(crate) const PAGE_SIDE: usize = 201;
/// Stops of the color bar.
const STOPS: usize = 12;
/// Heights that differ by less are shown as one, micrometers: half of the last of three decimals.
const ONE_FIGURE_UM: f64 = 5e-4;

/// A map as the script draws it: heights as 16 bit, 0 to 65534 over its range, 65535 where nothing cuts.
#[derive(Serialize)]
pub(crate) struct MapData {
    columns: usize,
    rows: usize,
    step: [f64; 2],
    range: [f64; 2],
    heights: String,
}

pub(crate) fn map_data(all: &[ShownTexture]) -> Vec<MapData> {
    let bytes = |t: &ShownTexture| {
        let [low, high] = t.range;
        let level = |h: &f32| {
            if h.is_nan() {
                return u16::MAX;
            }
            let part = if high > low { (f64::from(*h) - low) / (high - low) } else { 0.5 };
            (part.clamp(0.0, 1.0) * 65534.0).round() as u16
        };
        base64(&t.heights.iter().flat_map(|h| level(h).to_le_bytes()).collect::<Vec<u8>>())
    };
    let data = |t: &ShownTexture| MapData {
        columns: t.columns,
        rows: t.rows,
        step: t.step,
        range: if t.range[0] <= t.range[1] { t.range } else { [0.0, 0.0] },
        heights: bytes(t),
    };
    all.iter().filter(|t| t.is_map()).take(PAGE_MAPS).map(data).collect()
}

/// The color map in 256 steps of red, green, blue.
pub(crate) fn color_table() -> String {
    base64(&(0..256).flat_map(|i| height_color(f64::from(i) / 255.0)).collect::<Vec<u8>>())
}

/// Stops of the color bar for a style sheet.
pub(crate) fn color_stops() -> String {
    let stop = |k: usize| {
        let [r, g, b] = height_color(k as f64 / (STOPS - 1) as f64);
        format!("rgb({r} {g} {b})")
    };
    (0..STOPS).map(stop).collect::<Vec<_>>().join(", ")
}

fn micrometer(value: f64) -> String {
    format!("{} µm", fixed(value, if value.abs() < 10.0 { 3 } else { 2 }))
}

pub(crate) fn map_figures(all: &[ShownTexture]) -> Vec<Value> {
    let figure = |t: &ShownTexture| {
        let size = [(t.columns - 1) as f64 * t.step[0], (t.rows - 1) as f64 * t.step[1]];
        let lay = t.lay.map_or("no lay".to_owned(), |l| format!("lay at {}° from the rows", fixed(l, 1)));
        let shown = if t.every > 1 { format!("; one node of {} is drawn", t.every) } else { String::new() };
        json!({
            "name": t.name,
            "words": format!("{} × {} mm, {lay}{shown}", fixed(size[0], 2), fixed(size[1], 2)),
            "low": micrometer(t.range[0]),
            "high": micrometer(t.range[1]),
        })
    };
    all.iter().filter(|t| t.is_map()).take(PAGE_MAPS).map(figure).collect()
}

/// The profiles of the places: unfiltered, and the roughness profile over its evaluation length.
pub(crate) fn profile_figures(all: &[ShownTexture]) -> Vec<Value> {
    let figure = |t: &ShownTexture, p: &ShownProfile| {
        let name = format!("{}, {}", t.name, p.direction);
        let mut strips = vec![SignalStrip::new("height above the design, unfiltered, µm", &p.heights, 70.0)];
        strips.extend(p.roughness.as_ref().map(|r| SignalStrip::new("roughness profile, µm", r, 70.0)));
        let values =
            p.ra_rz_um.map_or_else(String::new, |[ra, rz]| format!(" Ra {}, Rz {}.", micrometer(ra), micrometer(rz)));
        let class = if p.class.is_empty() { String::new() } else { format!(" Class {}.", p.class) };
        json!({
            "svg": svg(&strips, 480.0, p.length, &[], &name),
            "name": name,
            "words": format!(
                "Along {} mm, a point every {} µm.{class}{values}",
                fixed(p.length, 2),
                fixed(UM_PER_MM * p.step, 2)
            ),
        })
    };
    all.iter().flat_map(|t| t.profiles.iter().map(move |p| figure(t, p))).collect()
}

fn bounds(range: Option<[f64; 2]>) -> String {
    match range {
        None => "not checked".into(),
        Some([a, b]) if b - a < ONE_FIGURE_UM => micrometer(b),
        Some([a, b]) => format!("{} to {}", fixed(a, 3), micrometer(b)),
    }
}

/// One line for each profile, or for the map alone.
pub(crate) fn texture_rows(all: &[TextureUsed]) -> Vec<Value> {
    all.iter().flat_map(rows_of).collect()
}

fn rows_of(t: &TextureUsed) -> Vec<Value> {
    let [x, y, z] = t.at_mm;
    let one = |value: Option<f64>| value.map_or("–".to_owned(), micrometer);
    let blocks: Vec<String> = t
        .blocks
        .iter()
        .map(|b| match (&b.file, b.line) {
            (Some(file), Some(line)) => format!("{file}:{line} ({} %)", fixed(b.percent, 0)),
            _ => format!("block {}", b.block),
        })
        .collect();
    let mut notes: Vec<String> = t.unchecked.iter().map(|u| format!("Not checked: {u}.")).collect();
    notes.extend(t.remarks.iter().map(|r| format!("{r}.")));
    if let Some(p) = &t.phases {
        notes.push(format!(
            "Spindle phase not known: over {} random ones Sa {}, Sz {}.",
            count(p.repeats.into()),
            bounds(Some(p.sa_um)),
            bounds(Some(p.sz_um))
        ));
    }
    notes.push(format!("Residual part: {}.", t.residual.source));
    let text = |v: &Value, key: &str| v.get(key).and_then(|v| v.as_str()).unwrap_or("–").to_owned();
    let number = |v: &Value, key: &str| v.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let row = |what: String, [ra, rz]: [String; 2], first: bool| {
        json!({
            "name": t.name,
            "place": format!("X{} Y{} Z{}", fixed(x, 3), fixed(y, 3), fixed(z, 3)),
            "what": what,
            "ra": ra,
            "rz": rz,
            "sa": if first { one(t.sa_um) } else { String::new() },
            "sz": if first { one(t.sz_um) } else { String::new() },
            "blocks": if first { blocks.join(", ") } else { String::new() },
            "notes": if first { notes.join(" ") } else { String::new() },
        })
    };
    let profiles: Vec<Value> = t
        .profiles
        .iter()
        .enumerate()
        .map(|(k, p)| {
            let r = &p.report;
            let model = p.analytic.as_ref().map_or_else(String::new, |a| {
                format!(
                    "; unfiltered Ra {}, by the model of Dong et al. 2023 (pitch {} mm, lean {}°) {}",
                    micrometer(a.simulated_ra_um),
                    fixed(a.pitch_mm, 3),
                    fixed(a.inclination_deg, 1),
                    micrometer(a.ra_um)
                )
            });
            let what = format!(
                "{}: {}, {}, λs {} µm, λc {} mm, length {} mm, every {} µm, {}{model}",
                p.direction,
                text(r, "standard"),
                text(r, "class"),
                number(r, "lambda_s_um"),
                number(r, "lambda_c_mm"),
                number(r, "evaluation_length_mm"),
                fixed(number(r, "spacing_um"), 2),
                text(r, "end_rule")
            );
            row(what, [bounds(p.ra_um), bounds(p.rz_um)], k == 0)
        })
        .collect();
    if profiles.is_empty() {
        return vec![row("map alone".into(), ["–".into(), "–".into()], true)];
    }
    profiles
}

/// What the table is about.
pub(crate) fn texture_words(t: &TextureUsed) -> String {
    let model =
        if t.model == "teeth" { "edges of the teeth" } else { "envelope of the cutter, without teeth and run-out" };
    let error = if t.design_error_um > 0.0 {
        format!("; the design's own error of {} {} counts on top", fixed(t.design_error_um, 2), symbol("um"))
    } else {
        String::new()
    };
    format!(
        "Kinematic surface by the {model}; form removed by distance to the design{error}. Sa and Sz are those of the unfiltered map."
    )
}
