//! Tool libraries of Fusion 360: JSON with a list `data`.
//!
//! Pitfalls of the format: the holder has a unit of its own; its segments run from the tip side to the
//! spindle, and may go on above the gauge line; `TA` is the half angle of chamfer mills and countersinks
//! and the full one of center drills; `SIG` is the full point angle; `LB` is the length below the holder;
//! `TP` is the pitch of a tap; tool numbers may repeat.
//!
//! Tools that do not rotate (turning, laser, waterjet), form mills and corner-rounding mills have no kind
//! in a library: they are left out and reported.

use std::path::Path;

use proveout_input::InputError;
use serde::Deserialize;

use super::words::{SubstituteBody, center_cutting_of};
use super::{ImportCall, Imported, LengthUnit};
use crate::HolderSection;
use crate::draft::{SAME_MM, ToolDraft};

/// Shorter parts of an outline are none, mm: rounding of inches.
const SHORTEST_MM: f64 = 1e-9;

/// A tool as written in the file; unused members are skipped.
#[derive(Debug, Deserialize)]
pub(super) struct FusionTool {
    #[serde(rename = "type")]
    kind: Option<String>,
    unit: Option<String>,
    description: Option<String>,
    #[serde(rename = "product-id")]
    product: Option<String>,
    vendor: Option<String>,
    #[serde(default)]
    geometry: Geometry,
    holder: Option<Holder>,
    #[serde(rename = "post-process", default)]
    post: Post,
}

#[derive(Debug, Default, Deserialize)]
struct Post {
    number: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[allow(non_snake_case, reason = "names of ISO 13399 as the file has them")]
struct Geometry {
    DC: Option<f64>,
    RE: Option<f64>,
    LCF: Option<f64>,
    LB: Option<f64>,
    OAL: Option<f64>,
    SFDM: Option<f64>,
    NOF: Option<f64>,
    TA: Option<f64>,
    SIG: Option<f64>,
    HAND: Option<bool>,
    TP: Option<f64>,
    #[serde(rename = "shoulder-length")]
    shoulder_length: Option<f64>,
    #[serde(rename = "shoulder-diameter")]
    shoulder_diameter: Option<f64>,
    #[serde(rename = "tip-diameter")]
    tip_diameter: Option<f64>,
    #[serde(rename = "lower-radius")]
    lower_radius: Option<f64>,
    #[serde(rename = "profile-radius")]
    profile_radius: Option<f64>,
    #[serde(rename = "assemblyGaugeLength")]
    assembly_gauge: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Holder {
    unit: Option<String>,
    description: Option<String>,
    #[serde(rename = "gaugeLength")]
    gauge: Option<f64>,
    #[serde(default)]
    segments: Vec<Segment>,
}

#[derive(Debug, Deserialize)]
struct Segment {
    height: f64,
    #[serde(rename = "lower-diameter")]
    lower: f64,
    #[serde(rename = "upper-diameter")]
    upper: f64,
}

/// Kinds of tools that do not turn, or that a library has no form for.
const LEFT_OUT: [&str; 9] =
    ["turning", "laser", "waterjet", "plasma", "form mill", "radius mill", "corner rounding", "additive", "holder"];

pub(super) fn drafts(file: &Path, data: Vec<FusionTool>, call: &ImportCall) -> Result<Imported, InputError> {
    let mut imported = Imported { format: "Fusion 360 library", ..Imported::default() };
    for (at, entry) in data.into_iter().enumerate() {
        let words = entry.description.clone().unwrap_or_default();
        let kind = entry.kind.clone().unwrap_or_default().to_lowercase().replace(['-', '_'], " ");
        // A holder that is an entry of its own has no tool number.
        if kind == "holder" {
            continue;
        }
        let refused = |message: String, help: &str| {
            InputError::file(file, format!("tool {} of the list ({kind} \"{words}\"): {message}", at + 1), help)
        };
        let number = match entry.post.number {
            Some(n) if n >= 0.0 && n.fract() == 0.0 && n <= f64::from(u32::MAX) => n as u32,
            Some(n) => {
                return Err(refused(format!("its number {n} is not a tool number"), "number the tools in Fusion"));
            }
            None => {
                imported.notes.push(format!("\"{words}\" ({kind}) has no number and is left out"));
                continue;
            }
        };
        if !call.selects(number) {
            continue;
        }
        let left_out = LEFT_OUT.iter().any(|word| kind.contains(word)) || kind == "circle segment taper";
        if left_out {
            let message =
                format!("T{number} \"{words}\" is a {kind}, which a library does not support, and is left out");
            imported.notes.push(message);
            continue;
        }
        match draft(file, number, &kind, &entry, call) {
            Ok((draft, notes)) => {
                imported.notes.extend(notes.into_iter().map(|n| format!("T{number}: {n}")));
                imported.tools.push(draft);
            }
            Err(message) => return Err(refused(message, "give the tool its dimensions in Fusion and export it again")),
        }
    }
    Ok(imported)
}

fn unit_of(name: Option<&str>, call: &ImportCall) -> Result<f64, String> {
    match name {
        Some(word) => {
            LengthUnit::from_name(word).map(LengthUnit::mm).ok_or_else(|| format!("unit {word:?} is not known"))
        }
        None => call.unit.map(LengthUnit::mm).ok_or_else(|| "it has no unit".into()),
    }
}

fn draft(
    file: &Path,
    number: u32,
    kind: &str,
    entry: &FusionTool,
    call: &ImportCall,
) -> Result<(ToolDraft, Vec<String>), String> {
    let unit = unit_of(entry.unit.as_deref(), call)?;
    let g = &entry.geometry;
    let mm = |value: Option<f64>| value.filter(|v| v.is_finite() && *v > 0.0).map(|v| v * unit);
    let need = |name: &str, value: Option<f64>| mm(value).ok_or_else(|| format!("{name} is missing or not above zero"));
    let angle = |name: &str, value: Option<f64>| {
        value
            .filter(|a| *a > 0.0 && *a < 180.0)
            .ok_or_else(|| format!("{name} is missing, or no angle between 0 and 180 degrees"))
    };
    let mut notes = Vec::new();
    let maker: Vec<&str> = [entry.vendor.as_deref(), entry.product.as_deref()]
        .into_iter()
        .flatten()
        .filter(|w| !w.trim().is_empty())
        .collect();
    let source = format!(
        "Fusion 360 library {}{}",
        file.display(),
        if maker.is_empty() { String::new() } else { format!(": {}", maker.join(" ")) }
    );
    let mut draft = ToolDraft::new(number, source);
    if let Some(words) = entry.description.as_deref().map(str::trim).filter(|w| !w.is_empty()) {
        words.clone_into(&mut draft.description);
        words.clone_into(&mut draft.name);
    }
    let dc = need("DC", g.DC)?;
    let has = |word: &str| kind.contains(word);
    if has("lollipop") {
        // A ball that is cut above its middle until the neck.
        let neck =
            mm(g.shoulder_diameter).filter(|d| *d < dc).ok_or("a lollipop mill needs a shoulder below its diameter")?;
        let r = 0.5 * dc;
        let top = r + (r * r - 0.25 * neck * neck).sqrt();
        draft.kind = Some("profile");
        draft.segments = vec![([0.5 * neck, top], Some([0.0, r]))];
    } else if has("barrel") || has("oval") {
        draft.kind = Some(if has("oval") { "oval" } else { "barrel" });
        draft.shape = vec![
            ("diameter_mm", dc),
            ("tip_radius_mm", need("lower-radius", g.lower_radius)?),
            ("side_radius_mm", need("profile-radius", g.profile_radius)?),
        ];
    } else if has("lens") {
        draft.kind = Some("lens");
        draft.shape = vec![
            ("diameter_mm", dc),
            ("lens_radius_mm", need("profile-radius", g.profile_radius.or(g.lower_radius))?),
            ("corner_radius_mm", need("RE", g.RE)?),
        ];
    } else if has("tapered") {
        draft.kind = Some("profile");
        draft.segments = tapered(dc, mm(g.RE).unwrap_or(0.0), angle("TA", g.TA)?, need("LCF", g.LCF)?)?;
        notes.push("DC is read as the diameter at the tip".into());
    } else if has("dovetail") {
        let (half, length) = (angle("TA", g.TA)?.to_radians(), need("LCF", g.LCF)?);
        let top = 0.5 * dc - length * half.tan();
        if top <= 0.0 {
            return Err("its side meets the axis below the end of its flutes".into());
        }
        draft.kind = Some("profile");
        draft.segments = vec![([0.5 * dc, 0.0], None), ([top, length], None)];
    } else if has("ball") || has("probe") {
        draft.kind = Some("ball");
        draft.shape = vec![("diameter_mm", dc)];
        if has("probe") {
            draft.choose(&["kind"], "a probe: its ball; it must not cut");
        }
    } else if has("bull nose") {
        draft.kind = Some("bull_nose");
        draft.shape = vec![("diameter_mm", dc), ("corner_radius_mm", need("RE", g.RE)?)];
    } else if has("face mill") {
        draft.kind = Some("face_mill");
        // TA leans the inserts from the axis.
        let entering = 90.0 - g.TA.filter(|a| (0.0..90.0).contains(a)).unwrap_or(0.0);
        draft.shape =
            vec![("diameter_mm", dc), ("corner_radius_mm", mm(g.RE).unwrap_or(0.0)), ("entering_angle_deg", entering)];
    } else if has("chamfer") || has("counter sink") || has("countersink") || has("engrav") {
        draft.kind = Some("chamfer");
        let tip = mm(g.tip_diameter).unwrap_or(0.0);
        draft.shape =
            vec![("diameter_mm", dc), ("point_angle_deg", 2.0 * angle("TA", g.TA)?), ("tip_diameter_mm", tip)];
    } else if has("center drill") {
        draft.kind = Some("chamfer");
        let tip = mm(g.tip_diameter).unwrap_or(0.0);
        draft.shape = vec![("diameter_mm", dc), ("point_angle_deg", angle("TA", g.TA)?), ("tip_diameter_mm", tip)];
        notes.push("the pilot of the center drill is left out: its cone alone cuts".into());
    } else if has("spot drill") {
        draft.kind = Some("chamfer");
        let tip = mm(g.tip_diameter).unwrap_or(0.0);
        draft.shape = vec![("diameter_mm", dc), ("point_angle_deg", angle("SIG", g.SIG)?), ("tip_diameter_mm", tip)];
    } else if has("drill") {
        draft.kind = Some("drill");
        draft.shape = vec![("diameter_mm", dc), ("point_angle_deg", angle("SIG", g.SIG)?)];
    } else if has("tap") && !has("taper") {
        draft.shape = vec![("diameter_mm", dc)];
        let words = draft.description.clone();
        // Where the library has no pitch, its texts may name it.
        draft.become_tap(&words, mm(g.TP), SubstituteBody::Tap.reason());
    } else if ["flat", "slot", "thread mill", "reamer", "boring", "counter bore", "counterbore"].iter().any(|w| has(w))
    {
        draft.kind = Some("flat");
        draft.shape = vec![("diameter_mm", dc)];
        if !has("flat") {
            draft.thread_mill = has("thread mill");
            draft.choose(&["kind"], format!("a {kind}: taken as a cylinder of its diameter and flute length"));
        }
    } else {
        return Err(format!("type {kind:?} is not known"));
    }
    let lcf = need("LCF", g.LCF)?;
    if draft.kind != Some("profile") || has("tapered") || has("dovetail") {
        draft.flute_length = Some(lcf);
    }
    let cut = draft.segments.last().map_or(lcf, |([_, z], _)| *z);
    let (shoulder, own) = (mm(g.shoulder_length), mm(g.shoulder_diameter));
    let shank = mm(g.SFDM);
    if let (Some(top), Some(neck)) = (shoulder, own)
        && top > cut + SAME_MM
        && (neck - shank.unwrap_or(neck + 1.0)).abs() > SAME_MM
    {
        draft.neck = Some((neck, top - cut));
    }
    draft.shank = shank;
    draft.stick_out = mm(g.LB);
    draft.overall = mm(g.OAL).filter(|all| draft.stick_out.is_none_or(|out| *all >= out));
    draft.flutes = g.NOF.filter(|n| *n >= 1.0 && n.fract() == 0.0).map(|n| n as u32);
    let mut told = [entry.description.as_deref(), entry.product.as_deref()].into_iter().flatten();
    draft.center_cutting = told.find_map(center_cutting_of).filter(|_| kind_may_plunge(draft.kind));
    draft.left_handed = g.HAND == Some(false) || has("left hand");
    if let Some(holder) = &entry.holder
        && !holder.segments.is_empty()
    {
        // Its own unit, and only where it has none that of the tool.
        let unit =
            unit_of(holder.unit.as_deref().or(entry.unit.as_deref()), call).map_err(|e| format!("its holder: {e}"))?;
        draft.holder = sections(&holder.segments, unit, holder.gauge.map(|l| l * unit))?;
        draft.holder_name = holder.description.clone().unwrap_or_default();
    } else if let Some(gauge) = mm(g.assembly_gauge) {
        draft.gauge = Some(gauge);
    }
    Ok((draft, notes))
}

/// Whether the words about the center of an end say something of this kind: of a point or a ball they go
/// without saying.
fn kind_may_plunge(kind: Option<&str>) -> bool {
    matches!(kind, Some("flat" | "bull_nose" | "face_mill" | "profile"))
}

/// Sections up to the gauge line; those above it are in the spindle.
fn sections(segments: &[Segment], unit: f64, gauge: Option<f64>) -> Result<Vec<HolderSection>, String> {
    let mut all = Vec::new();
    let mut z = 0.0;
    for s in segments {
        let [height, lower, upper] = [s.height, s.lower, s.upper].map(|v| v * unit);
        if !(height >= 0.0 && lower > 0.0 && upper > 0.0 && (height + lower + upper).is_finite()) {
            return Err(format!("a segment of its holder has the dimensions {height}, {lower}, {upper} mm"));
        }
        let left = gauge.filter(|g| *g > 0.0).map_or(height, |g| (g - z).min(height));
        if left <= SHORTEST_MM {
            // A step without height, or above the gauge line.
            continue;
        }
        let top = lower + (upper - lower) * left / height;
        all.push(HolderSection { diameter: lower, top_diameter: top, length: left });
        z += height;
    }
    Ok(all)
}

/// A place of an outline, `[r, z]` in mm, and the center of the arc that leads to it, where it is one.
type OutlinePlace = ([f64; 2], Option<[f64; 2]>);

/// Outline of a tapered mill: flat to the corner, its arc to where it is tangent to the side, the side up to
/// the end of the flutes.
fn tapered(dc: f64, corner: f64, half_deg: f64, length: f64) -> Result<Vec<OutlinePlace>, String> {
    let (sin, cos) = half_deg.to_radians().sin_cos();
    let flat = 0.5 * dc - corner;
    if flat < -SAME_MM {
        return Err("RE is above half of DC".into());
    }
    let flat = flat.max(0.0);
    let mut outline = Vec::new();
    if flat > SHORTEST_MM {
        outline.push(([flat, 0.0], None));
    }
    let mut foot = [flat, 0.0];
    if corner > SHORTEST_MM {
        foot = [flat + corner * cos, corner * (1.0 - sin)];
        outline.push((foot, Some([flat, corner])));
    }
    if length <= foot[1] {
        return Err("LCF ends below its corner".into());
    }
    outline.push(([foot[0] + (length - foot[1]) * sin / cos, length], None));
    Ok(outline)
}
