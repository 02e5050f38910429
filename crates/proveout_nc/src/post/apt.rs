//! APT cutter location data. Points are those of the work offset, whatever frames the commands have; there is
//! no word for rotary axes, machine coordinates, and how corners are treated (a comment says what the
//! commands wanted).

use std::io::Write;

use super::format::{PostFrames, PostLines, full_turns, offset_number, one_line, speed};
use super::{Post, PostError, PostSettings, Unpostable};
use crate::frame;
use crate::settings::Dialect;
use crate::{
    ArcMotion, Command, CompSide, Coolant, CutterComp, Dwell, Feed, Motion, Offset, Op, Spindle, SpindleDirection,
    ToolAction, ToolName,
};

/// Writes canonical commands as CL data.
#[derive(Debug)]
pub struct AptPost<W> {
    out: PostLines<W>,
    begun: bool,
    tcp: bool,
    multax: bool,
    /// Tool axis of the last motion, base coordinates.
    axis: Option<[f64; 3]>,
    frames: PostFrames,
    selected: Option<ToolName>,
    /// A tool whose change waits for the number of its length.
    changed: Option<ToolName>,
    length_on: bool,
    at: Option<[f64; 3]>,
    coolant: Coolant,
    offset_told: bool,
}

impl<W: Write> AptPost<W> {
    /// A post that writes to a sink.
    pub fn new(sink: W, settings: PostSettings) -> Self {
        Self {
            // CL data has no line numbers.
            out: PostLines::new(sink, PostSettings { block_number_step: None, ..settings }),
            begun: false,
            tcp: false,
            multax: false,
            axis: None,
            frames: PostFrames::new(),
            selected: None,
            changed: None,
            length_on: false,
            at: None,
            coolant: Coolant { flood: false, mist: false },
            offset_told: false,
        }
    }

    /// Returns the sink.
    pub fn into_inner(self) -> W {
        self.out.sink
    }

    fn begin(&mut self) -> Result<(), Unpostable> {
        self.begun = true;
        if let Some(header) = self.out.settings.header.take() {
            return header.iter().try_for_each(|line| self.out.plain(line));
        }
        let name = one_line(&self.out.settings.program_name.clone(), &[]);
        self.out.plain(&format!("PARTNO/{name}"))?;
        self.out.plain(if self.out.settings.inches { "UNITS/INCHES" } else { "UNITS/MM" })
    }

    fn tool_name(tool: &ToolName) -> String {
        match tool {
            ToolName::Empty => "0".to_owned(),
            ToolName::Number(number) => number.to_string(),
            ToolName::Name(name) => format!("'{}'", one_line(name, &['\'', '"'])),
        }
    }

    /// What waits for the next command.
    fn waiting(&mut self, op: &Op) -> Result<(), Unpostable> {
        if let Some(tool) = self.selected.take() {
            if let Op::Tool(ToolAction::Change(next)) = op
                && *next == tool
            {
                return Ok(());
            }
            self.out.plain(&format!("SELCTL/{}", Self::tool_name(&tool)))?;
        }
        if let Some(tool) = self.changed.take() {
            let edge = match op {
                Op::Offset(Offset::ToolEdge { edge }) if *edge != 0 => self.out.edge(*edge, Some(&tool)),
                _ => 1,
            };
            let adjust = if edge == 1 { String::new() } else { format!(",ADJUST,{edge}") };
            self.out.plain(&format!("LOADTL/{}{adjust}", Self::tool_name(&tool)))?;
        }
        Ok(())
    }

    fn command(&mut self, op: &Op) -> Result<(), Unpostable> {
        if !self.begun {
            self.begin()?;
        }
        self.frames.before_motion(op, &self.out.settings, "G54")?;
        self.waiting(op)?;
        match op {
            Op::Rapid(motion) => self.straight(motion, true),
            Op::Linear(motion) => self.straight(motion, false),
            Op::Arc(arc) => self.arc(arc),
            Op::Dwell(Dwell::Seconds(seconds)) => self.out.plain(&format!("DELAY/{}", super::decimal(*seconds, 3))),
            Op::Dwell(Dwell::Revolutions(n)) => self.out.plain(&format!("DELAY/{},REV", super::decimal(*n, 3))),
            Op::Feed(feed) => self.feed(*feed),
            Op::FeedCounts(counts) => super::feed_counts(*counts, Dialect::Apt),
            Op::Spindle(spindle) => self.spindle(*spindle),
            Op::Tool(ToolAction::Select(tool)) => {
                self.selected = Some(tool.clone());
                Ok(())
            }
            Op::Tool(ToolAction::Change(tool)) => {
                self.changed = Some(tool.clone());
                self.length_on = true;
                self.at = None;
                Ok(())
            }
            // Circles carry their plane.
            Op::Plane(_) => Ok(()),
            Op::Offset(Offset::ToolEdge { edge: 0 }) if self.length_on => Err(Unpostable::new(
                "switching the tool length off",
                "remove D0 or G49: CL data gives points of the tip",
            )),
            Op::Offset(Offset::ToolEdge { .. }) => Ok(()),
            Op::Offset(Offset::ToolDelta { length, radius, corner_radius }) => {
                if [length, radius, corner_radius].iter().all(|v| **v == 0.0) {
                    return Ok(());
                }
                Err(Unpostable::new("delta values of the tool", "write them into the tool table"))
            }
            Op::Retract(_) => Err(Unpostable::new("a retraction along the tool axis", "write the retracted position")),
            Op::Offset(Offset::TurnCenter { .. }) => Err(super::turns_ahead()),
            Op::Offset(Offset::Work { word }) => self.work_offset(word),
            Op::Frame(change) => {
                self.frames.change(change);
                Ok(())
            }
            Op::Tcp(tcp) => {
                self.tcp = tcp.on;
                Ok(())
            }
            Op::CutterComp(comp) => self.compensation(comp),
            Op::Override(change) if change.enabled && change.feed == 1.0 => Ok(()),
            Op::Override(_) => Err(Unpostable::new("a fixed or programmed override", "write the feed itself")),
            Op::PathMode(mode) => self.out.plain(&format!("$$ path mode: {mode:?}")),
            Op::Spline(_) => Err(Unpostable::new("a Bezier curve", "write it as short straight blocks")),
            Op::Probe(_) => Err(Unpostable::new("a probing motion", "remove the measuring cycle")),
            Op::Thread(_) => Err(Unpostable::new("a motion coupled to the spindle", "write CYCLE/TAP by hand")),
            Op::Coolant(coolant) => self.coolant(*coolant),
            Op::Message(text) => self.out.plain(&format!("PPRINT/{}", one_line(text, &[]))),
            Op::Overcut(overcut) => self.out.plain(&format!("$$ {}", one_line(&overcut.to_string(), &[]))),
            Op::Note(text) => self.out.plain(&format!("$$ {}", one_line(text, &[]))),
            Op::Stop { optional } => self.out.plain(if *optional { "OPSTOP" } else { "STOP" }),
            Op::End => self.out.plain("FINI"),
        }
    }

    /// Point in the coordinates of the work offset, and the tool axis where vectors are in effect.
    fn pose(&mut self, motion: &Motion) -> Result<([f64; 3], Option<[f64; 3]>), Unpostable> {
        if motion.machine_coordinates {
            return Err(Unpostable::new(
                "a motion in machine coordinates",
                "take SUPA, G53 or M91 out, and what goes with it",
            ));
        }
        if motion.programmed >> 3 != 0 {
            return Err(Unpostable::new(
                "positions of rotary axes: what they mean depends on the machine",
                "program the tool axis as a vector",
            ));
        }
        if motion.programmed == 0 && motion.tool_axis.is_some() {
            return Err(Unpostable::new(
                "a motion that turns the tool with the linear axes at rest",
                "program the tool axis as a vector",
            ));
        }
        let Some(base) = motion.end_base.xyz() else {
            return Err(Unpostable::new("a point of which not all coordinates are known", "program X, Y and Z"));
        };
        let point = frame::sub(base, self.frames.settable.translation);
        if !self.tcp {
            let still = self.multax && self.axis != Some([0.0, 0.0, 1.0]);
            if self.frames.is_tilted() || still {
                return Err(Unpostable::new(
                    "a tilted plane without tool center point control",
                    "switch it on and program the tool axis as a vector",
                ));
            }
            return Ok((point, self.axis.filter(|_| self.multax)));
        }
        match motion.tool_axis_base.or(self.axis) {
            Some(axis) => {
                self.axis = Some(axis);
                Ok((point, Some(axis)))
            }
            None => Err(Unpostable::new(
                "tool center point control with a tool axis that is not known",
                "program the tool axis as a vector",
            )),
        }
    }

    fn goto(&mut self, point: [f64; 3], axis: Option<[f64; 3]>) -> Result<(), Unpostable> {
        let mut words = point.map(|v| self.out.length(v)).join(",");
        if let Some(axis) = axis {
            for component in axis {
                words.push(',');
                words.push_str(&self.out.vector(component));
            }
        }
        self.at = Some(point);
        self.out.plain(&format!("GOTO/{words}"))
    }

    fn multax(&mut self, axis: Option<[f64; 3]>) -> Result<(), Unpostable> {
        if axis.is_some() && !self.multax {
            self.multax = true;
            return self.out.plain("MULTAX/ON");
        }
        Ok(())
    }

    fn straight(&mut self, motion: &Motion, rapid: bool) -> Result<(), Unpostable> {
        if motion.exact_stop {
            return Err(Unpostable::new("an exact stop of one block", "remove G9"));
        }
        let (point, axis) = self.pose(motion)?;
        self.multax(axis)?;
        if rapid {
            self.out.plain("RAPID")?;
        }
        self.goto(point, axis)
    }

    fn arc(&mut self, arc: &ArcMotion) -> Result<(), Unpostable> {
        let (end, axis) = self.pose(&arc.motion)?;
        self.multax(axis)?;
        let same = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| self.out.length(a[i]) == self.out.length(b[i]));
        let one_point = self.at.is_some_and(|at| same(at, end));
        let turns = full_turns(arc);
        if one_point && turns == 0 && arc.sweep < std::f64::consts::PI {
            return self.goto(end, axis);
        }
        let center = frame::sub(arc.center_base, self.frames.settable.translation);
        let center = center.map(|v| self.out.center(v));
        // A normal of six digits would lift the end of a large arc out of its plane.
        let decimals = self.out.settings.vector_decimals + 3;
        let normal = arc.normal_base.map(|v| self.out.number(v, decimals));
        let radius = self.out.center(arc.radius);
        let words = format!("{},{},{radius}", center.join(","), normal.join(","));
        if turns == 0 && !one_point {
            self.out.plain(&format!("CIRCLE/{words}"))?;
        } else {
            self.out.plain(&format!("MOVARC/{words},ANGLE,{}", self.out.number(arc.sweep.to_degrees(), 6)))?;
        }
        self.goto(end, axis)
    }

    fn feed(&mut self, feed: Feed) -> Result<(), Unpostable> {
        let inches = self.out.settings.inches;
        match feed {
            Feed::PerTime(v) => {
                let text = self.out.feed(v * 60.0);
                self.out.plain(&format!("FEDRAT/{text},{}", if inches { "IPM" } else { "MMPM" }))
            }
            Feed::PerRevolution(v) => {
                let text = self.out.above_zero(self.out.in_unit(v), self.out.settings.feed_decimals + 3);
                self.out.plain(&format!("FEDRAT/{text},{}", if inches { "IPR" } else { "MMPR" }))
            }
            Feed::InverseTime(_) => Err(Unpostable::new("inverse time feed", "write the feed in mm/min (G94)")),
        }
    }

    fn spindle(&mut self, spindle: Spindle) -> Result<(), Unpostable> {
        let direction = match spindle.direction {
            SpindleDirection::Off => return self.out.plain("SPINDL/OFF"),
            SpindleDirection::Clockwise => "CLW",
            SpindleDirection::CounterClockwise => "CCLW",
        };
        match spindle.speed_rpm {
            Some(value) => self.out.plain(&format!("SPINDL/{},RPM,{direction}", speed(value))),
            None => self.out.plain(&format!("SPINDL/{direction}")),
        }
    }

    fn work_offset(&mut self, word: &str) -> Result<(), Unpostable> {
        let code = match offset_number(word) {
            _ if word == "G500" => 500,
            Some(number @ 1..=6) => number + 53,
            Some(number @ 7..=99) => number + 500,
            _ => return Err(Unpostable::new(format!("the work offset {word}"), "use G54 to G59")),
        };
        let settings = std::mem::take(&mut self.out.settings);
        self.frames.offset(word, &settings);
        self.out.settings = settings;
        // CL data counts from G54 where it says nothing else.
        if code == 54 && !std::mem::replace(&mut self.offset_told, true) {
            return Ok(());
        }
        self.offset_told = true;
        self.out.plain(&format!("PREFUN/{code}"))
    }

    fn compensation(&mut self, comp: &CutterComp) -> Result<(), Unpostable> {
        let side = match comp.side {
            CompSide::Off => return self.out.plain("CUTCOM/OFF"),
            CompSide::Left => "LEFT",
            CompSide::Right => "RIGHT",
        };
        match comp.offset {
            Some(offset) => self.out.plain(&format!("CUTCOM/{side},{offset}")),
            None => self.out.plain(&format!("CUTCOM/{side}")),
        }
    }

    fn coolant(&mut self, coolant: Coolant) -> Result<(), Unpostable> {
        let before = std::mem::replace(&mut self.coolant, coolant);
        super::tell_coolant(before, coolant, ["COOLNT/OFF", "COOLNT/FLOOD", "COOLNT/MIST"], |words| {
            self.out.plain(words)
        })
    }
}

impl<W: Write> Post for AptPost<W> {
    fn write(&mut self, command: &Command) -> Result<(), PostError> {
        self.command(&command.op).map_err(|unsaid| unsaid.at(&command.location))
    }

    fn finish(&mut self) -> Result<(), PostError> {
        self.waiting(&Op::End).and_then(|()| self.out.footer()).map_err(|unsaid| unsaid.at(&super::nowhere()))
    }
}
