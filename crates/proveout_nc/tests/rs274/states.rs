//! Both sides as the same list: what happens in each block, and the state in which it happens.

use proveout_nc::{
    Control, Dwell, Feed, Motion, Offset, Op, Program, Settings, SpindleDirection, ToolAction, ToolName,
};

use super::recording::Recorded;

const INCH_MM: f64 = 25.4;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    Rapid,
    Feed,
    /// In machine coordinates, mm, where known; turns as begun, counter-clockwise above zero.
    Arc {
        center: [Option<f64>; 3],
        turns: i32,
    },
    Probe,
    Thread,
    Spline,
    Dwell(f64),
    Stop(bool),
    Change(u32),
    Select(u32),
    Plane(char),
    End,
}

impl Kind {
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Arc { turns, .. } => format!("Arc of {turns}"),
            Self::Change(_) => "Change".to_owned(),
            Self::Select(_) => "Select".to_owned(),
            Self::Dwell(_) => "Dwell".to_owned(),
            other => format!("{other:?}"),
        }
    }

    fn is_motion(&self) -> bool {
        !matches!(self, Self::Dwell(_) | Self::Stop(_) | Self::Change(_) | Self::Select(_) | Self::Plane(_) | Self::End)
    }

    fn is_in_feed(&self) -> bool {
        matches!(self, Self::Feed | Self::Arc { .. } | Self::Probe)
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Event {
    pub(crate) kind: Kind,
    /// Machine coordinates, tool length included, mm and degrees; none where not known.
    pub(crate) end: [Option<f64>; 6],
    /// mm or degrees a minute or a turn, as far as both sides say it in one way.
    pub(crate) feed: Option<f64>,
    /// -1, 0, 1, and the speed where it turns.
    pub(crate) spindle: (i32, i64),
    pub(crate) coolant: (bool, bool),
}

/// Length of tool n in the table of the recordings: n inch.
fn tool_length_mm(edge: u32) -> f64 {
    if edge <= 20 { f64::from(edge) * INCH_MM } else { 0.0 }
}

/// Events of the reader for each block, up to the block that it refuses, and the message.
pub(crate) fn ours(blocks: &[&str]) -> (Vec<Vec<Event>>, Option<(usize, String)>) {
    let mut events = vec![Vec::new(); blocks.len()];
    let mut text = blocks.join("\n") + "\n";
    // `rs274` begins with G99.
    let first = blocks.first().map_or("", |block| block);
    if !first.contains("G98") && !first.contains("G99") {
        text = text.replacen(first, &format!("{first} G99"), 1);
    }
    let settings = Settings::of_control(Control::find("linuxcnc-2.9", None).unwrap());
    let program = match Program::from_text("a.ngc", text, &settings) {
        Ok(program) => program,
        Err(faults) => {
            let fault = &faults.0[0];
            let at = (fault.line as usize).saturating_sub(1).min(blocks.len() - 1);
            return (events, Some((at, fault.message.clone())));
        }
    };
    let (mut last, mut length, mut feed) = ([None; 6], 0.0, None);
    let (mut spindle, mut coolant) = ((0, 0), (false, false));
    for command in program {
        let command = match command {
            Ok(command) => command,
            Err(fault) => {
                let at = (fault.line as usize).saturating_sub(1).min(blocks.len() - 1);
                return (events, Some((at, fault.message.clone())));
            }
        };
        let at = (command.location.line as usize).saturating_sub(1).min(blocks.len() - 1);
        let mut put = |kind: Kind, motion: Option<&Motion>, last: &mut [Option<f64>; 6]| {
            let before = *last;
            if let Some(motion) = motion {
                for (axis, kept) in last.iter_mut().enumerate() {
                    let value = motion.end_base.get(axis).map(|v| match axis {
                        2 => v + length,
                        0 | 1 => v,
                        _ => v.to_degrees(),
                    });
                    *kept = value.or(*kept);
                }
            }
            let near = |axis: usize| match (before[axis], last[axis]) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-6,
                (a, b) => a == b,
            };
            let stands = motion.is_some() && (0..6).all(near) && !matches!(kind, Kind::Arc { .. } | Kind::Probe);
            if stands {
                return;
            }
            let feed = if kind.is_in_feed() { said(feed) } else { None };
            events[at].push(Event { kind, end: *last, feed, spindle, coolant });
        };
        match &command.op {
            Op::Rapid(motion) => put(Kind::Rapid, Some(motion), &mut last),
            Op::Linear(motion) => put(Kind::Feed, Some(motion), &mut last),
            Op::Probe(probe) => put(Kind::Probe, Some(&probe.motion), &mut last),
            Op::Thread(thread) => put(Kind::Thread, Some(&thread.motion), &mut last),
            Op::Spline(spline) => put(Kind::Spline, Some(&spline.motion), &mut last),
            Op::Arc(arc) => {
                let along = (0..3).find(|&axis| arc.normal_base[axis].abs() > 0.99).unwrap_or(2);
                let mut center = arc.center_base.map(Some);
                center[2] = center[2].map(|z| z + length);
                center[along] = None;
                let sense = if arc.normal[0] + arc.normal[1] + arc.normal[2] < 0.0 { -1 } else { 1 };
                let turns = sense * (arc.sweep / std::f64::consts::TAU - 1e-6).ceil() as i32;
                put(Kind::Arc { center, turns }, Some(&arc.motion), &mut last);
            }
            Op::Dwell(Dwell::Seconds(seconds)) if *seconds > 0.0 => put(Kind::Dwell(*seconds), None, &mut last),
            Op::Stop { optional } => put(Kind::Stop(*optional), None, &mut last),
            Op::End => put(Kind::End, None, &mut last),
            Op::Tool(ToolAction::Change(tool)) => put(Kind::Change(number(tool)), None, &mut last),
            Op::Tool(ToolAction::Select(tool)) => put(Kind::Select(number(tool)), None, &mut last),
            Op::Plane(letter) => put(Kind::Plane(*letter), None, &mut last),
            Op::Feed(f) => feed = Some(*f),
            Op::Spindle(s) => {
                let direction = match s.direction {
                    SpindleDirection::Off => 0,
                    SpindleDirection::Clockwise => 1,
                    SpindleDirection::CounterClockwise => -1,
                };
                let speed = if direction == 0 { 0.0 } else { s.speed_rpm.unwrap_or(0.0) };
                spindle = (direction, speed.round() as i64);
            }
            Op::Coolant(c) => coolant = (c.flood, c.mist),
            Op::Offset(Offset::ToolEdge { edge }) => length = tool_length_mm(*edge),
            _ => {}
        }
    }
    (events, None)
}

fn number(tool: &ToolName) -> u32 {
    if let ToolName::Number(number) = tool { *number } else { 0 }
}

fn said(feed: Option<Feed>) -> Option<f64> {
    match feed? {
        Feed::PerTime(v) => Some(v * 60.0),
        Feed::PerRevolution(v) => Some(v),
        // `rs274` gives the speed that it has computed from the way.
        Feed::InverseTime(_) => None,
    }
}

struct Machine {
    unit: f64,
    plane: [usize; 3],
    g5x: [f64; 6],
    g92: [f64; 6],
    turn: f64,
    tool: [f64; 3],
    /// As written, and in mm.
    feed: (f64, f64),
    inverse: bool,
    spindle: (i32, i64),
    speed: f64,
    coolant: (bool, bool),
    last: [f64; 6],
    synchronous: bool,
    surface: bool,
}

impl Machine {
    fn point(&self, values: &[f64]) -> [f64; 6] {
        let at = |axis: usize| values.get(axis).copied().unwrap_or(0.0);
        let mut p: [f64; 6] =
            std::array::from_fn(|axis| at(axis) * if axis < 3 { self.unit } else { 1.0 } + self.g92[axis]);
        let (s, c) = self.turn.to_radians().sin_cos();
        (p[0], p[1]) = (c * p[0] - s * p[1], s * p[0] + c * p[1]);
        for (axis, value) in p.iter_mut().enumerate() {
            *value += self.g5x[axis] + if axis < 3 { self.tool[axis] } else { 0.0 };
        }
        p
    }

    fn event(&mut self, kind: Kind, end: Option<[f64; 6]>) -> Option<Event> {
        let end = end.unwrap_or(self.last);
        let moves =
            |axes: std::ops::Range<usize>| axes.into_iter().any(|a| (end[a] - self.last[a]).abs() > 3e-4 * self.unit);
        if kind.is_motion() && !matches!(kind, Kind::Arc { .. } | Kind::Probe | Kind::Spline) && !moves(0..6) {
            self.last = end;
            return None;
        }
        let linear = moves(0..3) || matches!(kind, Kind::Arc { .. });
        let feed = (kind.is_in_feed() && !self.inverse).then_some(if linear { self.feed.1 } else { self.feed.0 });
        self.last = end;
        Some(Event { kind, end: end.map(Some), feed, spindle: self.spindle, coolant: self.coolant })
    }
}

/// Events of `rs274` for each block.
pub(crate) fn theirs(blocks: &[&Recorded]) -> Vec<Vec<Event>> {
    let mut m = Machine {
        unit: 1.0,
        plane: [0, 1, 2],
        g5x: [0.0; 6],
        g92: [0.0; 6],
        turn: 0.0,
        tool: [0.0; 3],
        feed: (0.0, 0.0),
        inverse: false,
        spindle: (0, 0),
        speed: 0.0,
        coolant: (false, false),
        last: [0.0; 6],
        synchronous: false,
        surface: false,
    };
    let mut events: Vec<Vec<Event>> =
        blocks.iter().map(|block| block.calls.iter().flat_map(|call| m.call(call)).collect()).collect();
    let mut oriented = false;
    for (block, events) in blocks.iter().zip(&mut events) {
        // The plane of the next program.
        if block.calls.iter().any(|call| call == "E2") {
            events.retain(|event| !matches!(event.kind, Kind::Plane(_)));
        }
        // The reader emits the stop of an oriented spindle, the calls do not.
        oriented |= block.text.to_ascii_uppercase().contains("M19");
        if oriented {
            events.iter_mut().for_each(|event| event.spindle.1 = -1);
        }
    }
    events
}

impl Machine {
    fn call(&mut self, call: &str) -> Vec<Event> {
        let (name, rest) = match call.as_bytes()[0] {
            b'S' | b'E' | b'C' | b'c' => call.split_at(2),
            _ => call.split_at(1),
        };
        let mut v: Vec<f64> = rest.split(',').filter_map(|n| n.parse().ok()).collect();
        // Zeros at the end are left out of the recording.
        v.resize(v.len().max(9), 0.0);
        let lengths = |v: &[f64], unit: f64| -> [f64; 6] {
            std::array::from_fn(|a| v.get(a).copied().unwrap_or(0.0) * if a < 3 { unit } else { 1.0 })
        };
        let turned = |m: &mut Self, direction: i32| {
            // The reader gives surface speed as the speed that follows from it.
            let speed = if m.surface { -1 } else { m.speed.round() as i64 };
            m.spindle = (direction, if direction == 0 { 0 } else { speed });
        };
        let event = match name {
            "U" => {
                self.unit = if rest.contains("INCH") { INCH_MM } else { 1.0 };
                None
            }
            "P" => {
                let (plane, letter) = match rest {
                    "PLANE_XZ" => ([2, 0, 1], 'Y'),
                    "PLANE_YZ" => ([1, 2, 0], 'X'),
                    _ => ([0, 1, 2], 'Z'),
                };
                self.plane = plane;
                self.event(Kind::Plane(letter), None)
            }
            "G" => {
                self.g5x = lengths(&v[1..], self.unit);
                None
            }
            "g" => {
                self.g92 = lengths(&v, self.unit);
                None
            }
            "r" => {
                self.turn = v[0];
                None
            }
            "H" => {
                let l = lengths(&v, self.unit);
                self.tool = [l[0], l[1], l[2]];
                None
            }
            "F" => {
                self.feed = (v[0], v[0] * self.unit);
                None
            }
            "y" | "Y" => {
                self.synchronous = name == "y";
                None
            }
            "w" => {
                self.surface = v[1] != 0.0;
                if self.spindle.0 != 0 {
                    turned(self, self.spindle.0);
                }
                None
            }
            "s" => {
                self.speed = v[1];
                if self.spindle.0 != 0 {
                    turned(self, self.spindle.0);
                }
                None
            }
            "S+" | "S-" | "S0" => {
                turned(
                    self,
                    if name == "S+" {
                        1
                    } else if name == "S-" {
                        -1
                    } else {
                        0
                    },
                );
                None
            }
            "C+" | "C-" => {
                self.coolant.0 = name == "C+";
                None
            }
            "c+" | "c-" => {
                self.coolant.1 = name == "c+";
                None
            }
            "T" => {
                let p = self.point(&v);
                self.event(Kind::Rapid, Some(p))
            }
            "L" => {
                let p = self.point(&v);
                let kind = if self.synchronous { Kind::Thread } else { Kind::Feed };
                self.event(kind, Some(p))
            }
            "B" => {
                let p = self.point(&v);
                self.event(Kind::Probe, Some(p))
            }
            "R" => {
                // Down and back.
                let before = self.last;
                let mut p = self.point(&v);
                p[3..6].copy_from_slice(&before[3..6]);
                let down = self.event(Kind::Thread, Some(p));
                let up = self.event(Kind::Thread, Some(before));
                return down.into_iter().chain(up).collect();
            }
            "N" => {
                let mut e = self.event(Kind::Spline, None);
                if let Some(e) = &mut e {
                    e.end = [None; 6];
                }
                e
            }
            "A" => {
                let [u, w, n] = self.plane;
                let mut end = [0.0; 6];
                let mut center = [0.0; 6];
                (end[u], end[w], end[n]) = (v[0], v[1], v[5]);
                (center[u], center[w], center[n]) = (v[2], v[3], v[5]);
                end[3..6].copy_from_slice(&v[6..9]);
                let center = self.point(&center);
                let mut known = [Some(center[0]), Some(center[1]), Some(center[2])];
                known[n] = None;
                if n != 2 && self.turn != 0.0 {
                    known = [None; 3];
                }
                let p = self.point(&end);
                self.event(Kind::Arc { center: known, turns: v[4] as i32 }, Some(p))
            }
            "D" if v[0] > 0.0 => self.event(Kind::Dwell(v[0]), None),
            "t" => self.event(Kind::Select(v[0] as u32), None),
            "X" | "x" => self.event(Kind::Change(v[0] as u32), None),
            "E0" => self.event(Kind::Stop(false), None),
            "E1" => self.event(Kind::Stop(true), None),
            "E2" => self.event(Kind::End, None),
            _ => None,
        };
        event.into_iter().collect()
    }
}
