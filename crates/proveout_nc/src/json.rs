//! Canonical commands as JSON lines.

use std::f64::consts::TAU;
use std::io;

use serde_json::{Map, Value, json};

use crate::{
    ArcMotion, AxisValues, Command, CompSide, Dwell, Feed, Motion, Offset, Op, OrientationInterpolation, PathMode,
    SpindleDirection, ToolAction, ToolName,
};

/// Rounds to 1e-9 and turns -0 into 0.
fn rounded(value: f64) -> f64 {
    let scaled = value * 1e9;
    // Beyond 2^52 the spacing of doubles is coarser than 1e-9 already.
    if scaled.abs() < 4.5e15 { scaled.round() / 1e9 + 0.0 } else { value }
}

fn point(p: [f64; 3]) -> Value {
    json!(p.map(rounded))
}

/// Writes commands as JSON lines and knows the feed that is in force.
///
/// One object a line: `file`, `line`, `column`, `depth`, `op` and what belongs to the op. Lengths in mm, angles in degrees,
/// whatever the unit of the program; numbers are rounded to 1e-9, which is far below what any control resolves.
///
/// | op | keys |
/// |---|---|
/// | `rapid` `linear` `arc` | `end`, `end_base`: `{"X": mm, .., "A": degrees, .., "axis": [i, j, k]}`; `machine_coordinates`, `exact_stop` where true; in feed `feed_mm_min`, `feed_mm_rev` or `inverse_time_min` (the F of G93, 1/min) |
/// | `arc` | also `plane` (`XY`, `ZX`, `YZ`, null for a circle in space), `center`, `normal`, `center_base`, `normal_base`, `turns` (sweep over a full turn), `radius` |
/// | `spline` | as motions; also `control`, `control_base`: the two inner points of a cubic Bezier curve |
/// | `probe` | as motions; also `away`, `must_switch` |
/// | `thread` | as motions; also `pitch_mm`, and `direction` where the cycle sets it |
/// | `retract` | `distance_mm`, null for the end of the traverse; `rapid` |
/// | `cutter_comp` | `side`: `off`, `left`, `right`; `offset`, `radius_mm`, null where not known |
/// | `override` | `enabled`, `feed_percent` |
/// | `dwell` | `seconds` or `revolutions` |
/// | `feed_mode` | `mode`: `mm_min`, `mm_rev`, `inverse_time`; written when the mode changes |
/// | `feed` | the feed as in motions |
/// | `spindle` | `direction`: `off`, `cw`, `ccw`; `speed_rpm` |
/// | `tool` | `action`: `select`, `change`; `number`, `name`, or neither for an empty spindle |
/// | `plane` | `plane` |
/// | `offset` | `edge`, or `word` of the work offset, or `delta_length_mm`, `delta_radius_mm`, `delta_corner_radius_mm` |
/// | `frame` | `word`, `rotation` (3 rows), `translation`, `rotary_deg` of A, B, C |
/// | `tcp` | `on`, `interpolation`: `axes`, `great_circle` |
/// | `path_mode` | `mode`: `exact_stop`, `continuous`; `tolerance_mm`, `orientation_tolerance_deg` |
/// | `coolant` | `flood`, `mist` |
/// | `message` `note` | `text` |
/// | `stop` | `optional` |
/// | `end` | |
#[derive(Clone, Debug, Default)]
pub struct JsonWriter {
    feed: Option<Feed>,
}

impl JsonWriter {
    /// A writer before the first command.
    pub fn new() -> Self {
        Self::default()
    }

    /// The lines of a command: mostly one; a feed in another mode than before is preceded by its `feed_mode`.
    pub fn values(&mut self, command: &Command) -> Vec<Value> {
        let mut lines = Vec::with_capacity(1);
        if let Op::Feed(feed) = &command.op {
            let changed = self.feed.is_none_or(|old| std::mem::discriminant(&old) != std::mem::discriminant(feed));
            if changed {
                let mode = match feed {
                    Feed::PerTime(_) => "mm_min",
                    Feed::PerRevolution(_) => "mm_rev",
                    Feed::InverseTime(_) => "inverse_time",
                };
                let mut object = place(command, "feed_mode");
                object.insert("mode".to_owned(), json!(mode));
                lines.push(Value::Object(object));
            }
            self.feed = Some(*feed);
        }
        let mut object = place(command, name(&command.op));
        fill(&mut object, &command.op);
        if let (Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_), Some(feed)) = (&command.op, self.feed) {
            put_feed(&mut object, feed);
        }
        lines.push(Value::Object(object));
        lines
    }

    /// Writes the lines of a command.
    ///
    /// # Errors
    /// What the sink reports.
    pub fn write(&mut self, command: &Command, sink: &mut impl io::Write) -> io::Result<()> {
        for value in self.values(command) {
            serde_json::to_writer(&mut *sink, &value)?;
            sink.write_all(b"\n")?;
        }
        Ok(())
    }
}

/// One command as JSON, without the feed in force (see [`JsonWriter`]).
pub fn to_json(command: &Command) -> Value {
    let mut object = place(command, name(&command.op));
    fill(&mut object, &command.op);
    Value::Object(object)
}

fn name(op: &Op) -> &'static str {
    match op {
        Op::Rapid(_) => "rapid",
        Op::Linear(_) => "linear",
        Op::Arc(_) => "arc",
        Op::Spline(_) => "spline",
        Op::Probe(_) => "probe",
        Op::Thread(_) => "thread",
        Op::Retract(_) => "retract",
        Op::CutterComp(_) => "cutter_comp",
        Op::Override(_) => "override",
        Op::Dwell(_) => "dwell",
        Op::Feed(_) => "feed",
        Op::Spindle(_) => "spindle",
        Op::Tool(_) => "tool",
        Op::Plane(_) => "plane",
        Op::Offset(_) => "offset",
        Op::Frame(_) => "frame",
        Op::Tcp(_) => "tcp",
        Op::PathMode(_) => "path_mode",
        Op::Coolant(_) => "coolant",
        Op::Message(_) => "message",
        Op::Note(_) | Op::Overcut(_) => "note",
        Op::Stop { .. } => "stop",
        Op::End => "end",
    }
}

fn place(command: &Command, op: &str) -> Map<String, Value> {
    let mut object = Map::new();
    object.insert("file".to_owned(), json!(&*command.location.file));
    object.insert("line".to_owned(), json!(command.location.line));
    object.insert("column".to_owned(), json!(command.location.column));
    object.insert("depth".to_owned(), json!(command.location.depth));
    object.insert("op".to_owned(), json!(op));
    object
}

fn put_feed(object: &mut Map<String, Value>, feed: Feed) {
    let (key, value) = match feed {
        Feed::PerTime(v) => ("feed_mm_min", v * 60.0),
        Feed::PerRevolution(v) => ("feed_mm_rev", v),
        Feed::InverseTime(v) => ("inverse_time_min", 60.0 / v),
    };
    object.insert(key.to_owned(), json!(rounded(value)));
}

fn axes(values: &AxisValues, axis: Option<[f64; 3]>) -> Value {
    let mut object = Map::new();
    for (letter, value) in values.iter() {
        let value = if matches!(letter, 'A' | 'B' | 'C') { value.to_degrees() } else { value };
        object.insert(letter.to_string(), json!(rounded(value)));
    }
    if let Some(axis) = axis {
        object.insert("axis".to_owned(), point(axis));
    }
    Value::Object(object)
}

fn put_motion(object: &mut Map<String, Value>, motion: &Motion) {
    object.insert("end".to_owned(), axes(&motion.end, motion.tool_axis));
    object.insert("end_base".to_owned(), axes(&motion.end_base, motion.tool_axis_base));
    if motion.machine_coordinates {
        object.insert("machine_coordinates".to_owned(), json!(true));
    }
    if motion.exact_stop {
        object.insert("exact_stop".to_owned(), json!(true));
    }
}

fn plane_of(normal: [f64; 3]) -> Value {
    let names = ["YZ", "ZX", "XY"];
    normal.iter().position(|v| v.abs() > 1.0 - 1e-12).map_or(Value::Null, |axis| json!(names[axis]))
}

fn put_arc(object: &mut Map<String, Value>, arc: &ArcMotion) {
    put_motion(object, &arc.motion);
    object.insert("plane".to_owned(), plane_of(arc.normal));
    object.insert("center".to_owned(), point(arc.center));
    object.insert("normal".to_owned(), point(arc.normal));
    object.insert("center_base".to_owned(), point(arc.center_base));
    object.insert("normal_base".to_owned(), point(arc.normal_base));
    object.insert("turns".to_owned(), json!(rounded(arc.sweep / TAU)));
    object.insert("radius".to_owned(), json!(rounded(arc.radius)));
}

fn direction(direction: SpindleDirection) -> &'static str {
    match direction {
        SpindleDirection::Off => "off",
        SpindleDirection::Clockwise => "cw",
        SpindleDirection::CounterClockwise => "ccw",
    }
}

fn put_special(object: &mut Map<String, Value>, op: &Op) {
    match op {
        Op::Spline(spline) => {
            put_motion(object, &spline.motion);
            object.insert("control".to_owned(), json!(spline.control.map(point)));
            object.insert("control_base".to_owned(), json!(spline.control_base.map(point)));
        }
        Op::Probe(probe) => {
            put_motion(object, &probe.motion);
            object.insert("away".to_owned(), json!(probe.away));
            object.insert("must_switch".to_owned(), json!(probe.must_switch));
        }
        Op::Thread(thread) => {
            put_motion(object, &thread.motion);
            object.insert("pitch_mm".to_owned(), json!(rounded(thread.pitch)));
            if let Some(turn) = thread.direction {
                object.insert("direction".to_owned(), json!(direction(turn)));
            }
        }
        _ => {}
    }
}

fn fill(object: &mut Map<String, Value>, op: &Op) {
    if matches!(op, Op::Spline(_) | Op::Probe(_) | Op::Thread(_)) {
        return put_special(object, op);
    }
    let mut put = |key: &str, value: Value| {
        object.insert(key.to_owned(), value);
    };
    match op {
        Op::Rapid(motion) | Op::Linear(motion) => put_motion(object, motion),
        Op::Arc(arc) => put_arc(object, arc),
        Op::Dwell(Dwell::Seconds(seconds)) => put("seconds", json!(rounded(*seconds))),
        Op::Dwell(Dwell::Revolutions(revolutions)) => put("revolutions", json!(rounded(*revolutions))),
        Op::Feed(feed) => put_feed(object, *feed),
        Op::Spindle(spindle) => {
            put("direction", json!(direction(spindle.direction)));
            put("speed_rpm", json!(spindle.speed_rpm));
        }
        Op::Tool(action) => {
            let (action, tool) = match action {
                ToolAction::Select(tool) => ("select", tool),
                ToolAction::Change(tool) => ("change", tool),
            };
            put("action", json!(action));
            match tool {
                ToolName::Empty => {}
                ToolName::Number(number) => put("number", json!(number)),
                ToolName::Name(name) => put("name", json!(name)),
            }
        }
        Op::Plane(normal) => {
            let normal = AxisValues::index(*normal).unwrap_or(2);
            put("plane", json!(["YZ", "ZX", "XY"].get(normal)));
        }
        Op::Offset(Offset::ToolEdge { edge }) => put("edge", json!(edge)),
        Op::Offset(Offset::ToolDelta { length, radius, corner_radius }) => {
            put("delta_length_mm", json!(rounded(*length)));
            put("delta_radius_mm", json!(rounded(*radius)));
            put("delta_corner_radius_mm", json!(rounded(*corner_radius)));
        }
        Op::Retract(retract) => {
            put("distance_mm", json!(retract.distance.map(rounded)));
            put("rapid", json!(retract.rapid));
        }
        Op::Offset(Offset::Work { word }) => put("word", json!(word)),
        Op::Frame(frame) => {
            put("word", json!(frame.word));
            put("rotation", json!(frame.rotation.map(|row| row.map(rounded))));
            put("translation", point(frame.translation));
            put("rotary_deg", point(frame.rotary.map(f64::to_degrees)));
        }
        Op::Tcp(tcp) => {
            let interpolation = match tcp.interpolation {
                OrientationInterpolation::Axes => "axes",
                OrientationInterpolation::GreatCircle => "great_circle",
            };
            put("on", json!(tcp.on));
            put("interpolation", json!(interpolation));
        }
        Op::PathMode(PathMode::ExactStop) => put("mode", json!("exact_stop")),
        Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance }) => {
            put("mode", json!("continuous"));
            put("tolerance_mm", json!(tolerance.map(rounded)));
            put("orientation_tolerance_deg", json!(orientation_tolerance.map(|t| rounded(t.to_degrees()))));
        }
        Op::CutterComp(comp) => {
            let side = match comp.side {
                CompSide::Off => "off",
                CompSide::Left => "left",
                CompSide::Right => "right",
            };
            put("side", json!(side));
            put("offset", json!(comp.offset));
            put("radius_mm", json!(comp.radius.map(rounded)));
        }
        Op::Override(change) => {
            put("enabled", json!(change.enabled));
            put("feed_percent", json!(rounded(change.feed * 100.0)));
        }
        Op::Spline(_) | Op::Probe(_) | Op::Thread(_) => {}
        Op::Coolant(coolant) => {
            put("flood", json!(coolant.flood));
            put("mist", json!(coolant.mist));
        }
        Op::Message(text) | Op::Note(text) => put("text", json!(text)),
        Op::Overcut(overcut) => {
            put("text", json!(overcut.to_string()));
            put("severity", json!(overcut.kind.weight().name()));
            put("overcut", json!(overcut.kind.name()));
            put("depth_mm", json!(rounded(overcut.depth)));
            put("radius_mm", json!(rounded(overcut.radius)));
            put("contour_file", json!(&*overcut.contour_file));
            put("contour_line", json!(overcut.contour_line));
            put("blocks", json!(overcut.blocks));
        }
        Op::Stop { optional } => put("optional", json!(optional)),
        Op::End => {}
    }
}
