//! What a line says of each op.

use std::f64::consts::TAU;

use super::text::JsonText;
use crate::{
    AXIS_LETTERS, ArcMotion, AxisValues, CompSide, Contact, Dwell, Feed, FrameChange, Motion, Offset, Op,
    OrientationInterpolation, Overcut, PathMode, RotarySolution, SpindleDirection, ToolAction, ToolName,
};

/// The text in front of the value of each axis, in the order of [`AXIS_LETTERS`].
const AXIS_KEYS: [&str; AXIS_LETTERS.len()] =
    [r#""X":"#, r#""Y":"#, r#""Z":"#, r#""A":"#, r#""B":"#, r#""C":"#, r#""U":"#, r#""V":"#, r#""W":"#];

/// Index of the first rotary axis, and of the first axis after the rotary ones, in
/// [`AXIS_LETTERS`].
const ROTARY: std::ops::Range<usize> = 3..6;
/// Component of a normal above which it is that of a plane of the program.
const ALONG_AXIS: f64 = 1.0 - 1e-12;

/// Planes by the index of their normal.
const PLANES: [&str; 3] = ["YZ", "ZX", "XY"];

/// The name of the op and its keys. The writer adds the feed in force.
pub(super) fn fill(text: &mut JsonText, op: &Op) {
    match op {
        Op::Rapid(motion) => put_motion(text, "rapid", motion),
        Op::Linear(motion) => put_motion(text, "linear", motion),
        Op::Arc(arc) => put_arc(text, arc),
        Op::Spline(spline) => {
            put_motion(text, "spline", &spline.motion);
            text.key("control");
            text.points(&spline.control);
            text.key("control_base");
            text.points(&spline.control_base);
        }
        Op::Probe(probe) => {
            put_motion(text, "probe", &probe.motion);
            text.put_flag("away", probe.away);
            text.put_flag("must_switch", probe.must_switch);
            if let Some(contact) = contact_word(probe.contact) {
                text.put_string("contact", contact);
            }
        }
        Op::Thread(thread) => {
            put_motion(text, "thread", &thread.motion);
            text.put_number("pitch_mm", thread.pitch);
            if let Some(turn) = thread.direction {
                text.put_string("direction", direction(turn));
            }
        }
        Op::Retract(retract) => {
            text.put_string("op", "retract");
            text.put_number_or_null("distance_mm", retract.distance);
            text.put_flag("rapid", retract.rapid);
        }
        Op::Dwell(dwell) => {
            text.put_string("op", "dwell");
            match dwell {
                Dwell::Seconds(seconds) => text.put_number("seconds", *seconds),
                Dwell::Revolutions(revolutions) => text.put_number("revolutions", *revolutions),
            }
        }
        Op::Feed(_) => text.put_string("op", "feed"),
        Op::FeedCounts(counts) => {
            text.put_string("op", "feed_counts");
            text.put_point("linear", counts.linear);
            text.put_point("radius_mm", counts.radius);
        }
        Op::Spindle(spindle) => {
            text.put_string("op", "spindle");
            text.put_string("direction", direction(spindle.direction));
            text.key("speed_rpm");
            match spindle.speed_rpm {
                Some(speed) => text.exact(speed),
                None => text.raw("null"),
            }
        }
        Op::Tool(action) => put_tool(text, action),
        Op::Plane(normal) => {
            text.put_string("op", "plane");
            put_plane(text, AxisValues::index(*normal).unwrap_or(2));
        }
        Op::Offset(offset) => put_offset(text, offset),
        Op::Frame(frame) => put_frame(text, frame),
        Op::Tcp(tcp) => {
            text.put_string("op", "tcp");
            text.put_flag("on", tcp.on);
            let interpolation = match tcp.interpolation {
                OrientationInterpolation::Axes => "axes",
                OrientationInterpolation::GreatCircle => "great_circle",
            };
            text.put_string("interpolation", interpolation);
        }
        Op::PathMode(mode) => put_path_mode(text, *mode),
        Op::CutterComp(comp) => {
            text.put_string("op", "cutter_comp");
            let side = match comp.side {
                CompSide::Off => "off",
                CompSide::Left => "left",
                CompSide::Right => "right",
            };
            text.put_string("side", side);
            text.key("offset");
            match comp.offset {
                Some(offset) => text.whole(offset),
                None => text.raw("null"),
            }
            text.put_number_or_null("radius_mm", comp.radius);
        }
        Op::Override(change) => {
            text.put_string("op", "override");
            text.put_flag("enabled", change.enabled);
            text.put_number("feed_percent", change.feed * 100.0);
        }
        Op::Coolant(coolant) => {
            text.put_string("op", "coolant");
            text.put_flag("flood", coolant.flood);
            text.put_flag("mist", coolant.mist);
        }
        Op::Message(message) => {
            text.put_string("op", "message");
            text.put_string("text", message);
        }
        Op::Note(note) => {
            text.put_string("op", "note");
            text.put_string("text", note);
        }
        Op::Overcut(overcut) => put_overcut(text, overcut),
        Op::Stop { optional } => {
            text.put_string("op", "stop");
            text.put_flag("optional", *optional);
        }
        Op::End => text.put_string("op", "end"),
    }
}

/// The mode that a feed belongs to.
pub(super) fn put_feed_mode(text: &mut JsonText, feed: Feed) {
    text.put_string("op", "feed_mode");
    let mode = match feed {
        Feed::PerTime(_) => "mm_min",
        Feed::PerRevolution(_) => "mm_rev",
        Feed::InverseTime(_) => "inverse_time",
    };
    text.put_string("mode", mode);
}

pub(super) fn put_feed(text: &mut JsonText, feed: Feed) {
    let (key, value) = match feed {
        Feed::PerTime(v) => ("feed_mm_min", v * 60.0),
        Feed::PerRevolution(v) => ("feed_mm_rev", v),
        Feed::InverseTime(v) => ("inverse_time_min", 60.0 / v),
    };
    text.put_number(key, value);
}

fn put_axes(text: &mut JsonText, values: &AxisValues, axis: Option<[f64; 3]>) {
    let mut separator = "{";
    for (at, key) in AXIS_KEYS.iter().enumerate() {
        let Some(value) = values.get(at) else { continue };
        text.raw(separator);
        text.raw(key);
        text.number(if ROTARY.contains(&at) { value.to_degrees() } else { value });
        separator = ",";
    }
    if let Some(axis) = axis {
        text.raw(separator);
        text.raw(r#""axis":"#);
        text.point(axis);
        separator = ",";
    }
    text.raw(if separator == "{" { "{}" } else { "}" });
}

#[inline]
fn put_motion(text: &mut JsonText, op: &str, motion: &Motion) {
    text.raw(r#","op":""#);
    text.raw(op);
    text.raw(r#"","end":"#);
    let from = text.len();
    put_axes(text, &motion.end, motion.tool_axis);
    let end = from..text.len();
    text.raw(r#","end_base":"#);
    if motion.end_base == motion.end && motion.tool_axis_base == motion.tool_axis {
        text.again(end);
    } else {
        put_axes(text, &motion.end_base, motion.tool_axis_base);
    }
    if motion.machine_coordinates {
        text.put_flag("machine_coordinates", true);
    }
    if motion.exact_stop {
        text.put_flag("exact_stop", true);
    }
    if let RotarySolution::Angle { higher, reference, .. } = motion.solution {
        text.put_string("solution", if higher { "higher" } else { "lower" });
        if let Some(letter) = reference {
            text.put_string("reference_axis", letter.encode_utf8(&mut [0; 4]));
        }
    }
}

/// `plane` of a normal that lies along an axis.
fn put_plane(text: &mut JsonText, normal: usize) {
    match PLANES.get(normal) {
        Some(plane) => text.put_string("plane", plane),
        None => text.raw(r#","plane":null"#),
    }
}

fn put_arc(text: &mut JsonText, arc: &ArcMotion) {
    put_motion(text, "arc", &arc.motion);
    put_plane(text, arc.normal.iter().position(|v| v.abs() > ALONG_AXIS).unwrap_or(PLANES.len()));
    text.put_point("center", arc.center);
    text.put_point("normal", arc.normal);
    text.put_point("center_base", arc.center_base);
    text.put_point("normal_base", arc.normal_base);
    text.put_number("turns", arc.sweep / TAU);
    text.put_number("radius", arc.radius);
}

fn direction(direction: SpindleDirection) -> &'static str {
    match direction {
        SpindleDirection::Off => "off",
        SpindleDirection::Clockwise => "cw",
        SpindleDirection::CounterClockwise => "ccw",
    }
}

fn put_tool(text: &mut JsonText, action: &ToolAction) {
    text.put_string("op", "tool");
    let (action, tool) = match action {
        ToolAction::Select(tool) => ("select", tool),
        ToolAction::Change(tool) => ("change", tool),
    };
    text.put_string("action", action);
    match tool {
        ToolName::Empty => {}
        ToolName::Number(number) => text.put_whole("number", *number),
        ToolName::Name(name) => text.put_string("name", name),
    }
}

fn put_offset(text: &mut JsonText, offset: &Offset) {
    text.put_string("op", "offset");
    match offset {
        Offset::ToolEdge { edge } => text.put_whole("edge", *edge),
        Offset::ToolDelta { length, radius, corner_radius } => {
            text.put_number("delta_length_mm", *length);
            text.put_number("delta_radius_mm", *radius);
            text.put_number("delta_corner_radius_mm", *corner_radius);
        }
        Offset::TurnCenter { ahead } => text.put_number("turn_center_mm", *ahead),
        Offset::Work { word } => text.put_string("word", word),
    }
}

fn put_frame(text: &mut JsonText, frame: &FrameChange) {
    text.put_string("op", "frame");
    text.put_string("word", &frame.word);
    text.key("rotation");
    text.points(&frame.rotation);
    text.put_point("translation", frame.translation);
    text.put_point("rotary_deg", frame.rotary.map(f64::to_degrees));
}

fn put_path_mode(text: &mut JsonText, mode: PathMode) {
    text.put_string("op", "path_mode");
    match mode {
        PathMode::ExactStop => text.put_string("mode", "exact_stop"),
        PathMode::Continuous { tolerance, orientation_tolerance } => {
            text.put_string("mode", "continuous");
            text.put_number_or_null("tolerance_mm", tolerance);
            text.put_number_or_null("orientation_tolerance_deg", orientation_tolerance.map(f64::to_degrees));
        }
    }
}

fn put_overcut(text: &mut JsonText, overcut: &Overcut) {
    text.put_string("op", "note");
    text.put_string("text", &overcut.to_string());
    text.put_string("severity", overcut.kind.weight().name());
    text.put_string("overcut", overcut.kind.name());
    text.put_number("depth_mm", overcut.depth);
    text.put_number("radius_mm", overcut.radius);
    text.put_string("contour_file", &overcut.contour_file);
    text.put_whole("contour_line", overcut.contour_line);
    text.put_whole("blocks", overcut.blocks);
}

/// What is known of the end of a probing motion; none where nothing is.
fn contact_word(contact: Contact) -> Option<&'static str> {
    match contact {
        Contact::Unknown => None,
        Contact::Asked => Some("asked"),
        Contact::Touched => Some("touched"),
        Contact::Missed => Some("missed"),
    }
}
