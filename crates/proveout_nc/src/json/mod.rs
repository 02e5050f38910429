//! Canonical commands as JSON lines.

mod ops;
mod text;

use std::io;
use std::mem::discriminant;
use std::sync::Arc;

use serde_json::Value;

use crate::{Command, Feed, Op};

use text::JsonText;

/// Writes commands as JSON lines and knows the feed that is in force.
///
/// One object a line: `file`, `line`, `column`, `depth`, `op` and what belongs to the op. Lengths in mm,
/// angles in degrees, whatever the unit of the program; numbers are rounded to 1e-9, which is far below what
/// any control resolves.
///
/// Each op with its keys:
///
/// - `rapid` `linear` `arc`: `end`, `end_base`: `{"X": mm, .., "A": degrees, .., "axis": [i, j, k]}`;
///   `machine_coordinates`, `exact_stop` where true; in feed `feed_mm_min`, `feed_mm_rev` or
///   `inverse_time_min` (the F of G93, 1/min)
/// - `arc`: also `plane` (`XY`, `ZX`, `YZ`, null for a circle in space), `center`, `normal`, `center_base`,
///   `normal_base`, `turns` (sweep over a full turn), `radius`
/// - `spline`: as motions; also `control`, `control_base`: the two inner points of a cubic Bezier curve
/// - `probe`: as motions; also `away`, `must_switch`; with known answers `contact` (`touched`, `missed`)
/// - `thread`: as motions; also `pitch_mm`, and `direction` where the cycle sets it
/// - `retract`: `distance_mm`, null for the end of the traverse; `rapid`
/// - `cutter_comp`: `side`: `off`, `left`, `right`; `offset`, `radius_mm`, null where not known
/// - `override`: `enabled`, `feed_percent`
/// - `dwell`: `seconds` or `revolutions`
/// - `feed_mode`: `mode`: `mm_min`, `mm_rev`, `inverse_time`; written when the mode changes
/// - `feed`: the feed as in motions
/// - `spindle`: `direction`: `off`, `cw`, `ccw`; `speed_rpm`
/// - `tool`: `action`: `select`, `change`; `number`, `name`, or neither for an empty spindle
/// - `plane`: `plane`
/// - `offset`: `edge`, or `word` of the work offset, or `delta_length_mm`, `delta_radius_mm`,
///   `delta_corner_radius_mm`
/// - `frame`: `word`, `rotation` (3 rows), `translation`, `rotary_deg` of A, B, C
/// - `tcp`: `on`, `interpolation`: `axes`, `great_circle`
/// - `path_mode`: `mode`: `exact_stop`, `continuous`; `tolerance_mm`, `orientation_tolerance_deg`
/// - `coolant`: `flood`, `mist`
/// - `message` `note`: `text`
/// - `stop`: `optional`
/// - `end`: no key
#[derive(Clone, Debug, Default)]
pub struct JsonWriter {
    /// The lines of the command that is written.
    text: JsonText,
    /// A line up to the number of its line, and the file that it names.
    head: JsonText,
    file: Option<Arc<str>>,
    /// The feed in force, and its text.
    feed: Option<Feed>,
    feed_text: JsonText,
}

impl JsonWriter {
    /// A writer before the first command.
    pub fn new() -> Self {
        Self::default()
    }

    /// Writes the lines of a command: mostly one; a feed in another mode than before is preceded by its
    /// `feed_mode`.
    ///
    /// # Errors
    /// What the sink reports.
    pub fn write(&mut self, command: &Command, sink: &mut impl io::Write) -> io::Result<()> {
        self.lines(command);
        sink.write_all(self.text.bytes())
    }

    /// The lines of a command as a reader of JSON takes them.
    pub fn values(&mut self, command: &Command) -> Vec<Value> {
        self.lines(command);
        let lines = serde_json::Deserializer::from_slice(self.text.bytes()).into_iter();
        lines.map(|value| value.unwrap_or(Value::Null)).collect()
    }

    /// The lines of a command into the buffer.
    fn lines(&mut self, command: &Command) {
        self.text.clear();
        if let Op::Feed(feed) = &command.op {
            if self.feed.is_none_or(|old| discriminant(&old) != discriminant(feed)) {
                self.place(command);
                ops::put_feed_mode(&mut self.text, *feed);
                self.text.raw("}\n");
            }
            self.feed = Some(*feed);
            self.feed_text.clear();
            ops::put_feed(&mut self.feed_text, *feed);
        }
        self.place(command);
        ops::fill(&mut self.text, &command.op);
        if let Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_) | Op::Feed(_) = &command.op {
            self.text.append(&self.feed_text);
        }
        self.text.raw("}\n");
    }

    /// What every line begins with.
    fn place(&mut self, command: &Command) {
        let location = &command.location;
        if self.file.as_ref().is_none_or(|file| !Arc::ptr_eq(file, &location.file)) {
            self.head.clear();
            self.head.raw("{\"file\":");
            self.head.string(&location.file);
            self.head.raw(",\"line\":");
            self.file = Some(Arc::clone(&location.file));
        }
        self.text.append(&self.head);
        self.text.whole(location.line);
        self.text.raw(",\"column\":");
        self.text.whole(location.column);
        self.text.raw(",\"depth\":");
        self.text.whole(location.depth);
    }
}

/// One command as JSON, without the feed in force (see [`JsonWriter`]).
///
/// ```
/// use proveout_nc::{Op, Program, Settings, to_json};
///
/// let program = Program::from_text("a.nc", "G20\nG0 X1. Y0. Z2.\nM30\n", &Settings::default())?;
/// let commands = program.collect::<Result<Vec<_>, _>>()?;
/// let rapid = commands.iter().find(|c| matches!(c.op, Op::Rapid(_))).expect("G0 moves");
/// let json = to_json(rapid);
/// assert_eq!((json["op"].as_str(), json["line"].as_u64()), (Some("rapid"), Some(2)));
/// assert_eq!(json["end"]["X"].as_f64(), Some(25.4)); // one inch, in mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn to_json(command: &Command) -> Value {
    JsonWriter::new().values(command).pop().unwrap_or(Value::Null)
}
