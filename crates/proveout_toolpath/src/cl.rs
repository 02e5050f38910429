use std::sync::Arc;

use proveout_geom::{Point, ToolPose, Vector};

/// Direction of the spindle, seen from the spindle towards the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpindleState {
    /// `SPINDL/OFF`.
    Off,
    /// `CLW`.
    Clockwise,
    /// `CCLW`.
    CounterClockwise,
}

/// Coolant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoolantState {
    /// `COOLNT/OFF`.
    Off,
    /// `COOLNT/ON` or `COOLNT/FLOOD`.
    Flood,
    /// `COOLNT/MIST`.
    Mist,
}

/// One statement of a CL file.
#[derive(Clone, Debug, PartialEq)]
pub enum ClStatement {
    /// The tool is here before the first motion (`FROM`).
    From(ToolPose),
    /// Straight motion of the tip (`GOTO`, `GODLTA`).
    Goto {
        /// Tip and axis at the end, mm.
        pose: ToolPose,
        /// At rapid rate: `RAPID` stood before.
        rapid: bool,
    },
    /// Feed in force from here, mm/s (`FEDRAT`).
    Feed(f64),
    /// Feed per revolution from here, mm (`FEDRAT/f,MMPR`).
    FeedPerRevolution(f64),
    /// Tool change (`LOADTL`).
    LoadTool {
        /// Number of the tool.
        number: u32,
    },
    /// Spindle (`SPINDL`).
    Spindle {
        /// Direction.
        state: SpindleState,
        /// Speed, 1/min, where given.
        speed_rpm: Option<f64>,
    },
    /// Coolant (`COOLNT`).
    Coolant(CoolantState),
    /// Wait, s (`DELAY`).
    Delay(f64),
    /// Program stop; true: optional (`STOP`, `OPSTOP`).
    Stop {
        /// True for `OPSTOP`.
        optional: bool,
    },
    /// Text for people (`PARTNO`, `PPRINT`, `TOOL PATH`, `$$`).
    Text(String),
    /// A statement that has no effect on the motion and is kept word by word (`CUTTER`, `MACHIN`, `INTOL`, ...).
    Kept(String),
    /// End of the path (`END`, `FINI`).
    End,
}

/// A statement with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct ClRecord {
    /// Line of its first character, from 1.
    pub line: u32,
    /// What it says.
    pub statement: ClStatement,
}

/// A tool path.
#[derive(Clone, Debug, PartialEq)]
pub struct ClFile {
    /// File as given by the caller.
    pub file: Arc<str>,
    /// Statements in the order of the file.
    pub records: Vec<ClRecord>,
}

impl ClFile {
    /// The motions: line, pose, rapid.
    pub fn motions(&self) -> impl Iterator<Item = (u32, &ToolPose, bool)> {
        self.records.iter().filter_map(|r| match &r.statement {
            ClStatement::Goto { pose, rapid } => Some((r.line, pose, *rapid)),
            _ => None,
        })
    }

    /// Length of the tip's path from the first pose (`FROM` or motion) on, mm.
    pub fn length_mm(&self) -> f64 {
        let mut at: Option<Point> = None;
        let mut length = 0.0;
        for r in &self.records {
            if let ClStatement::From(pose) | ClStatement::Goto { pose, .. } = &r.statement {
                if let (Some(p), ClStatement::Goto { .. }) = (at, &r.statement) {
                    length += (pose.tip - p).norm();
                }
                at = Some(pose.tip);
            }
        }
        length
    }

    /// APT CL text of the path, in mm and mm/min; read again, it gives the same statements to the last digit of the
    /// feed's conversion.
    pub fn to_apt(&self) -> String {
        let mut out = String::from("UNITS/MM\nMULTAX/ON\n");
        for r in &self.records {
            let line = match &r.statement {
                ClStatement::From(pose) => format!("FROM/{}", shown(pose)),
                ClStatement::Goto { pose, rapid: true } => format!("RAPID\nGOTO/{}", shown(pose)),
                ClStatement::Goto { pose, rapid: false } => format!("GOTO/{}", shown(pose)),
                ClStatement::Feed(f) => format!("FEDRAT/{},MMPM", f * 60.0),
                ClStatement::FeedPerRevolution(f) => format!("FEDRAT/{f},MMPR"),
                ClStatement::LoadTool { number } => format!("LOADTL/{number}"),
                ClStatement::Spindle { state: SpindleState::Off, .. } => "SPINDL/OFF".to_owned(),
                ClStatement::Spindle { state, speed_rpm } => {
                    let speed = speed_rpm.map(|s| format!("{s},RPM,")).unwrap_or_default();
                    format!("SPINDL/{speed}{}", if *state == SpindleState::Clockwise { "CLW" } else { "CCLW" })
                }
                ClStatement::Coolant(CoolantState::Off) => "COOLNT/OFF".to_owned(),
                ClStatement::Coolant(CoolantState::Flood) => "COOLNT/FLOOD".to_owned(),
                ClStatement::Coolant(CoolantState::Mist) => "COOLNT/MIST".to_owned(),
                ClStatement::Delay(s) => format!("DELAY/{s}"),
                ClStatement::Stop { optional } => if *optional { "OPSTOP" } else { "STOP" }.to_owned(),
                ClStatement::Text(text) => format!("PPRINT/{text}"),
                ClStatement::Kept(text) => text.clone(),
                ClStatement::End => "FINI".to_owned(),
            };
            out.push_str(&line);
            out.push('\n');
        }
        out
    }
}

fn shown(pose: &ToolPose) -> String {
    let (p, a) = (&pose.tip, &pose.axis);
    if *a == Vector::z() {
        // Written in full: with MULTAX/ON a reader may expect six numbers.
        return format!("{},{},{},0,0,1", p.x, p.y, p.z);
    }
    format!("{},{},{},{},{},{}", p.x, p.y, p.z, a.x, a.y, a.z)
}
