//! From an entry of a library file to a tool: which dimensions each kind of cutter has, and the schema that
//! says so.

use serde_json::{Value, json};

use crate::cutter::{Apt, Cutter, LARGEST_MM, ShapeError, refuse};
use crate::edges::edges_of;
use crate::library_file::{CutterKind, Hand, LibraryFile, ToolEntry};
use crate::profile::ON_CIRCLE_MM;
use crate::residual::residual_of;
use crate::{HolderSection, ToolBuilder};
use crate::{ProfileError, Role, Segment, Thread, Tool};

/// Fastest spindle that is believed, 1/min.
const FASTEST_RPM: f64 = 1e6;

/// JSON Schema of a library file, as text: keys, types, and the dimensions that each kind of cutter needs.
pub fn library_schema() -> String {
    format!("{:#}\n", schema())
}

fn schema() -> Value {
    let mut all = schemars::schema_for!(LibraryFile).to_value();
    if let Some(tool) = all.pointer_mut("/$defs/ToolEntry").and_then(Value::as_object_mut) {
        let rules: Vec<Value> = KINDS
            .iter()
            .map(|(_, word, needed)| {
                let foreign: Vec<_> = SHAPE_KEYS.iter().filter(|k| !needed.contains(k)).collect();
                let absent: serde_json::Map<_, _> =
                    foreign.into_iter().map(|k| ((*k).to_owned(), Value::Bool(false))).collect();
                json!({
                    "if": { "properties": { "kind": { "const": word } }, "required": ["kind"] },
                    "then": { "required": required(needed), "properties": absent },
                })
            })
            .collect();
        tool.insert("allOf".into(), Value::Array(rules));
    }
    all
}

/// Keys that describe the shape of a cutter; each kind has its own.
pub(crate) const SHAPE_KEYS: [&str; 16] = [
    "diameter_mm",
    "corner_radius_mm",
    "corner_center_radius_mm",
    "corner_center_height_mm",
    "lower_angle_deg",
    "upper_angle_deg",
    "cutter_height_mm",
    "point_angle_deg",
    "tip_diameter_mm",
    "tip_radius_mm",
    "side_radius_mm",
    "lens_radius_mm",
    "half_angle_deg",
    "entering_angle_deg",
    "pitch_mm",
    "segments",
];

/// The key that may be missing: of a tap without a pitch, the cylinder round its teeth is known all the
/// same.
const OPTIONAL: &str = "pitch_mm";

/// The keys that a kind cannot do without.
fn required<'a>(keys: &[&'a str]) -> Vec<&'a str> {
    keys.iter().copied().filter(|key| *key != OPTIONAL).collect()
}

/// The shape keys that each kind needs, but for an optional one; it may have no others.
const KINDS: [(CutterKind, &str, &[&str]); 15] = [
    (CutterKind::Ball, "ball", &["diameter_mm"]),
    (CutterKind::Flat, "flat", &["diameter_mm"]),
    (CutterKind::BullNose, "bull_nose", &["diameter_mm", "corner_radius_mm"]),
    (CutterKind::TaperBall, "taper_ball", &["tip_diameter_mm", "half_angle_deg", "diameter_mm"]),
    (CutterKind::Barrel, "barrel", &["diameter_mm", "tip_radius_mm", "side_radius_mm"]),
    (CutterKind::Oval, "oval", &["diameter_mm", "tip_radius_mm", "side_radius_mm"]),
    (CutterKind::DrumWheel, "drum_wheel", &["diameter_mm", "side_radius_mm", "corner_radius_mm"]),
    (CutterKind::Lens, "lens", &["diameter_mm", "lens_radius_mm", "corner_radius_mm"]),
    (CutterKind::Drill, "drill", &["diameter_mm", "point_angle_deg"]),
    (CutterKind::Chamfer, "chamfer", &["diameter_mm", "point_angle_deg", "tip_diameter_mm"]),
    (CutterKind::FaceMill, "face_mill", &["diameter_mm", "corner_radius_mm", "entering_angle_deg"]),
    (CutterKind::Tap, "tap", &["diameter_mm", "pitch_mm"]),
    (CutterKind::Probe, "probe", &["diameter_mm"]),
    (
        CutterKind::Apt,
        "apt",
        &[
            "diameter_mm",
            "corner_radius_mm",
            "corner_center_radius_mm",
            "corner_center_height_mm",
            "lower_angle_deg",
            "upper_angle_deg",
            "cutter_height_mm",
        ],
    ),
    (CutterKind::Profile, "profile", &["segments"]),
];

/// Words of the kinds.
pub(crate) const KIND_WORDS: [&str; KINDS.len()] = {
    let mut words = [""; KINDS.len()];
    let mut i = 0;
    while i < words.len() {
        words[i] = KINDS[i].1;
        i += 1;
    }
    words
};

fn shape_value(e: &ToolEntry, key: &str) -> Option<f64> {
    match key {
        "diameter_mm" => e.diameter_mm,
        "corner_radius_mm" => e.corner_radius_mm,
        "corner_center_radius_mm" => e.corner_center_radius_mm,
        "corner_center_height_mm" => e.corner_center_height_mm,
        "lower_angle_deg" => e.lower_angle_deg,
        "upper_angle_deg" => e.upper_angle_deg,
        "cutter_height_mm" => e.cutter_height_mm,
        "point_angle_deg" => e.point_angle_deg,
        "tip_diameter_mm" => e.tip_diameter_mm,
        "tip_radius_mm" => e.tip_radius_mm,
        "side_radius_mm" => e.side_radius_mm,
        "lens_radius_mm" => e.lens_radius_mm,
        "half_angle_deg" => e.half_angle_deg,
        "entering_angle_deg" => e.entering_angle_deg,
        "pitch_mm" => e.pitch_mm,
        // Any value: it only means that the key is present.
        "segments" => e.segments.as_ref().map(|s| s.len() as f64),
        _ => None,
    }
}

pub(crate) fn tool_of(e: &ToolEntry) -> Result<Tool, ShapeError> {
    let Some((_, word, needed)) = KINDS.iter().find(|k| k.0 == e.kind) else {
        return refuse("kind", 0.0, "is not a kind of cutter");
    };
    for key in SHAPE_KEYS {
        match (shape_value(e, key), needed.contains(&key)) {
            (None, true) if key != OPTIONAL => {
                return refuse(
                    key,
                    f64::NAN,
                    format!("is missing: kind \"{word}\" needs {}", required(needed).join(", ")),
                );
            }
            (Some(value), false) => {
                let limit = format!("is not a dimension of kind \"{word}\", which has {}", needed.join(", "));
                return refuse(key, value, limit);
            }
            _ => {}
        }
    }
    let get = |key: &str| shape_value(e, key).unwrap_or(f64::NAN);
    let diameter = get("diameter_mm");
    let fixed_height = matches!(e.kind, CutterKind::Apt | CutterKind::Profile | CutterKind::Probe);
    let is_probe = e.kind == CutterKind::Probe;
    if is_probe && let Some(flute) = e.flute_length_mm {
        return refuse("flute_length_mm", flute, "is not for kind \"probe\", which has no flutes");
    }
    if is_probe && e.neck_diameter_mm.is_none() {
        return refuse("neck_diameter_mm", f64::NAN, "is missing: it is the stem of the stylus of kind \"probe\"");
    }
    if e.flute_length_mm.is_none() && !fixed_height {
        return refuse("flute_length_mm", f64::NAN, format!("is missing: kind \"{word}\" needs it"));
    }
    let flute = e.flute_length_mm.unwrap_or(f64::NAN);
    let cutter = match e.kind {
        CutterKind::Ball => Cutter::ball(diameter),
        CutterKind::Flat | CutterKind::Tap => Cutter::flat(diameter),
        CutterKind::BullNose => Cutter::bull_nose(diameter, get("corner_radius_mm")),
        CutterKind::TaperBall => Cutter::taper_ball(get("tip_diameter_mm"), get("half_angle_deg"), diameter),
        CutterKind::Barrel => Cutter::barrel(diameter, get("tip_radius_mm"), get("side_radius_mm"), flute),
        CutterKind::Oval => Cutter::oval(diameter, get("tip_radius_mm"), get("side_radius_mm")),
        CutterKind::DrumWheel => Cutter::drum_wheel(diameter, get("side_radius_mm"), get("corner_radius_mm"), flute),
        CutterKind::Lens => Cutter::lens(diameter, get("lens_radius_mm"), get("corner_radius_mm")),
        CutterKind::Drill => Cutter::drill(diameter, get("point_angle_deg")),
        CutterKind::Chamfer => Cutter::chamfer(diameter, get("point_angle_deg"), get("tip_diameter_mm")),
        CutterKind::FaceMill => Cutter::face_mill(diameter, get("corner_radius_mm"), get("entering_angle_deg"), flute),
        CutterKind::Apt => Cutter::apt(&Apt {
            diameter,
            corner_radius: get("corner_radius_mm"),
            center_radius: get("corner_center_radius_mm"),
            center_height: get("corner_center_height_mm"),
            lower_angle_deg: get("lower_angle_deg"),
            upper_angle_deg: get("upper_angle_deg"),
            height: get("cutter_height_mm"),
        }),
        CutterKind::Probe => Cutter::stylus(diameter, e.neck_diameter_mm.unwrap_or(f64::NAN)),
        CutterKind::Profile => Cutter::profile(&segments_of(e)?),
    }?;
    let flute = e.flute_length_mm.unwrap_or_else(|| cutter.height());
    let mut builder = ToolBuilder::new(e.number, e.name.clone(), cutter, flute, e.gauge_length_mm)
        .description(e.description.clone())
        .left_handed(e.hand == Some(Hand::Left));
    match (e.neck_diameter_mm, e.neck_length_mm) {
        (Some(diameter), Some(length)) => builder = builder.neck(diameter, length),
        (Some(_), None) => return refuse("neck_length_mm", f64::NAN, "is missing: a neck has a diameter and a length"),
        (None, Some(_)) => {
            return refuse("neck_diameter_mm", f64::NAN, "is missing: a neck has a diameter and a length");
        }
        (None, None) => {}
    }
    if let Some(length) = e.transition_length_mm {
        builder = builder.transition(length);
    }
    if let Some(diameter) = e.shank_diameter_mm {
        builder = builder.shank(diameter);
    }
    if let Some(length) = e.overall_length_mm {
        builder = builder.overall_length(length);
    }
    if let Some(flutes) = e.flutes {
        if flutes == 0 {
            return refuse("flutes", 0.0, "must be 1 or more");
        }
        builder = builder.flutes(flutes);
    }
    let is_tap = e.kind == CutterKind::Tap;
    let thread = e.pitch_mm.filter(|_| is_tap).map(|pitch| Thread::new(diameter, pitch)).transpose()?;
    if let Some(yes) = e.center_cutting.or(is_tap.then_some(false)) {
        builder = builder.center_cutting(yes);
    }
    if let Some(wide) = e.dead_center_diameter_mm {
        if e.center_cutting != Some(false) {
            return refuse(
                "dead_center_diameter_mm",
                wide,
                "is for a tool without edges at its center: center_cutting = false",
            );
        }
        if !(wide > 0.0 && wide < diameter) {
            return refuse(
                "dead_center_diameter_mm",
                wide,
                format!("must be above 0 and below the diameter {diameter}"),
            );
        }
        builder = builder.dead_center(0.5 * wide);
    }
    if let Some(angle) = e.max_ramp_angle_deg {
        if e.center_cutting != Some(false) {
            return refuse(
                "max_ramp_angle_deg",
                angle,
                "is for a tool without edges at its center: center_cutting = false",
            );
        }
        if !(angle > 0.0 && angle < 90.0) {
            return refuse("max_ramp_angle_deg", angle, "must be above 0 and below 90");
        }
        builder = builder.max_ramp_angle(proveout_geom::rad(angle));
    }
    if let Some(speed) = e.max_speed_rpm {
        if !(speed > 0.0 && speed <= FASTEST_RPM) {
            return refuse("max_speed_rpm", speed, format!("must be above 0 and at most {FASTEST_RPM}"));
        }
        builder = builder.max_speed_rpm(speed);
    }
    if let Some(holder) = &e.holder {
        if holder.sections.is_empty() {
            return refuse("sections", 0.0, "is empty: a holder has at least one section");
        }
        for section in &holder.sections {
            for value in [Some(section.diameter_mm), section.top_diameter_mm, Some(section.length_mm)] {
                // Their place is the list of sections.
                if let Some(v) = value.filter(|v| !(*v > 0.0 && *v <= LARGEST_MM)) {
                    return refuse("sections", v, format!("has the dimension {v}; it must be above 0 mm"));
                }
            }
        }
        builder = builder.holder(holder.sections.iter().map(|s| HolderSection {
            diameter: s.diameter_mm,
            top_diameter: s.top_diameter_mm.unwrap_or(s.diameter_mm),
            length: s.length_mm,
        }));
    }
    let mut tool = builder.build()?;
    if e.thread_mill && e.kind != CutterKind::Flat {
        return refuse("thread_mill", f64::NAN, "is for kind \"flat\": the cylinder around the teeth of a thread mill");
    }
    (tool.is_tap, tool.is_thread_mill, tool.thread) = (is_tap, e.thread_mill, thread);
    if is_probe {
        tool.bodies.iter_mut().filter(|b| b.role == Role::Cutting).for_each(|b| b.role = Role::Neck);
        tool.stylus = Some(0.5 * diameter);
    }
    tool.residual = e.residual.as_ref().map(residual_of).transpose()?;
    tool.edges = e.edges.as_ref().map(|edges| edges_of(edges, &tool)).transpose()?;
    Ok(tool)
}

fn segments_of(e: &ToolEntry) -> Result<Vec<Segment>, ShapeError> {
    let mut from = [0.0, 0.0];
    let mut segments = Vec::new();
    for s in e.segments.iter().flatten() {
        let to = s.to_mm;
        segments.push(match s.center_mm {
            None => Segment::Line { from, to },
            Some(center) => {
                let radius = crate::profile::distance(center, to);
                let off = (crate::profile::distance(center, from) - radius).abs();
                if off > ON_CIRCLE_MM {
                    let reason = "the ends of the arc are not equally far from its center";
                    return Err(ProfileError::Degenerate { segment: segments.len(), reason }.into());
                }
                Segment::Arc { center, radius, from, to }
            }
        });
        from = to;
    }
    Ok(segments)
}
