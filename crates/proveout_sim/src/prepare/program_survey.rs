//! Checks that everything a program names exists, and finds which of its text is run: by reading it,
//! before anything moves.
//!
//! The reader runs the whole program once (branches, loops and calls as the control would), reports
//! all of its faults, and hands every command over. What a command names and the scene does not
//! have is a fault like any other: work offsets, tools, tool offsets, axes. All are reported
//! together, each name once.

use std::collections::BTreeSet;

use proveout_machine::Machine;
use proveout_nc::{
    AXIS_LETTERS, Command, Diagnostic, Diagnostics, Dialect, Location, Look, Motion, Offset, Op, Settings, Survey,
    ToolAction, ToolName,
};
use proveout_tool::ToolLibrary;

use crate::prepare::{error::SimError, memory::Motions};

/// What the commands of a program name.
struct Names<'a> {
    settings: &'a Settings,
    tools: &'a ToolLibrary,
    machine: &'a Machine,
    scene: &'a str,
    told: BTreeSet<String>,
    in_spindle: ToolName,
    /// The tool that was made ready last, and where.
    selected: Option<(ToolName, Location)>,
    /// Where the tool length was switched off last: machine coordinates switch it off and on again in one
    /// block.
    length_off_at: Option<Location>,
}

/// Reads a program to its end and looks up what it names; gives the text that its run does not reach, and its
/// motions.
///
/// # Errors
/// All faults of the text and all names that the scene does not know.
pub(crate) fn survey(
    read: impl FnOnce(&mut Look<'_>) -> Survey,
    settings: &Settings,
    tools: &ToolLibrary,
    machine: &Machine,
    scene: &str,
    start_tool: Option<u32>,
) -> Result<(Survey, Motions), SimError> {
    let mut motions = Motions::default();
    let mut names = Names {
        settings,
        tools,
        machine,
        scene,
        told: BTreeSet::new(),
        in_spindle: start_tool.map_or(ToolName::Empty, ToolName::Number),
        selected: None,
        length_off_at: None,
    };
    let survey = read(&mut |command, dialect| {
        motions.count(command);
        names.look(command, dialect)
    });
    if survey.faults.is_empty() { Ok((survey, motions)) } else { Err(SimError::Program(Diagnostics(survey.faults))) }
}

impl Names<'_> {
    /// The fault of a command that names what is not there; each name once.
    fn look(&mut self, command: &Command, dialect: Dialect) -> Option<Diagnostic> {
        let at = &command.location;
        match &command.op {
            Op::Offset(Offset::Work { word }) => {
                let fault = unknown_offset(at, word, self.settings, self.scene)?;
                self.once(format!("offset {word}")).then_some(fault)
            }
            Op::Tool(ToolAction::Select(name)) => {
                self.selected = Some((name.clone(), at.clone()));
                None
            }
            Op::Tool(ToolAction::Change(name)) => {
                self.in_spindle = name.clone();
                // Reported where its name is.
                let selected = self.selected.take().filter(|(selected, _)| selected == name);
                self.tool(name, selected.as_ref().map_or(at, |(_, at)| at))
            }
            Op::Offset(Offset::ToolEdge { edge }) => self.tool_offset(*edge, dialect, at),
            Op::Rapid(motion) | Op::Linear(motion) => self.axes(motion, at),
            Op::Arc(arc) => self.axes(&arc.motion, at),
            Op::Spline(spline) => self.axes(&spline.motion, at),
            Op::Probe(probe) => self.axes(&probe.motion, at),
            Op::Thread(thread) => self.axes(&thread.motion, at),
            _ => None,
        }
    }

    /// True the first time.
    fn once(&mut self, name: String) -> bool {
        self.told.insert(name)
    }

    fn tool(&mut self, name: &ToolName, at: &Location) -> Option<Diagnostic> {
        let known = match name {
            ToolName::Empty => return None,
            ToolName::Number(number) => self.tools.tools.iter().any(|t| t.number == *number),
            ToolName::Name(name) => self.tools.tools.iter().any(|t| t.name == *name),
        };
        let shown = shown(name);
        if known || !self.once(format!("tool {shown}")) {
            return None;
        }
        let count = self.tools.tools.len();
        Some(fault(
            at,
            "control-tool",
            format!("tool {shown} is not in the tool library ({count} tools)"),
            "add the tool to the library or correct its name in the program".to_owned(),
        ))
    }

    /// The library gives each tool one length and one radius: the offset of an ISO control has the number of
    /// its tool, a tool of an 840D one cutting edge.
    fn tool_offset(&mut self, number: u32, dialect: Dialect, at: &Location) -> Option<Diagnostic> {
        if number == 0 {
            self.length_off_at = Some(at.clone());
            return None;
        }
        if self.length_off_at.take().as_ref() == Some(at) {
            // No word names it here: the block before it has.
            return None;
        }
        let tool = shown(&self.in_spindle);
        let (message, help) = match (dialect, &self.in_spindle) {
            (Dialect::Siemens840d, _) if number > 1 => (
                format!("cutting edge D{number} of tool {tool} is not known: the library gives a tool one edge, D1"),
                "write D1, or give the other edge as a tool of its own".to_owned(),
            ),
            (Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc, ToolName::Number(own))
                if *own != number =>
            {
                let other = self.tools.tools.iter().any(|t| t.number == number);
                let whose = if other { format!("that of tool T{number}") } else { "not known".to_owned() };
                (
                    format!("tool offset {number} is {whose}, and tool {tool} is in the spindle"),
                    format!("write H{own}: the library gives tool {tool} the offset {own}"),
                )
            }
            _ => return None,
        };
        self.once(format!("edge {number} of {tool}")).then(|| fault(at, "scene-tool-offset", message, help))
    }

    fn axes(&mut self, motion: &Motion, at: &Location) -> Option<Diagnostic> {
        let missing = (3..AXIS_LETTERS.len()).find(|&index| {
            motion.programmed >> index & 1 == 1
                && motion.end_base.get(index).is_some()
                && self.machine.joint_for_letter(AXIS_LETTERS[index]).is_none()
        })?;
        let letter = AXIS_LETTERS[missing];
        let names: Vec<&str> = self.machine.joints.iter().map(|j| j.name.as_str()).collect();
        let message =
            format!("axis {letter} is programmed, but machine {} has no joint of this name", self.machine.name);
        let help = format!("the machine's joints are {}", names.join(", "));
        self.once(format!("axis {letter}")).then(|| fault(at, "control-axis", message, help))
    }
}

fn shown(name: &ToolName) -> String {
    match name {
        ToolName::Empty => "T0".to_owned(),
        ToolName::Number(number) => format!("T{number}"),
        ToolName::Name(name) => format!("{name:?}"),
    }
}

fn fault(at: &Location, code: &'static str, message: String, help: String) -> Diagnostic {
    Diagnostic::at(at, code, message, help)
}

/// The fault of a work offset that the scene does not give: it would silently count as zero.
fn unknown_offset(at: &Location, word: &str, settings: &Settings, scene: &str) -> Option<Diagnostic> {
    if settings.work_offsets.contains_key(word) || word == "G500" {
        return None;
    }
    let message = format!("the scene gives no values for work offset {word}");
    let help = format!("add [work_offsets.{word}] with X_mm, Y_mm, Z_mm to {scene}");
    Some(fault(at, "scene-work-offset", message, help))
}

/// Refuses a work offset that the scene does not give, in the middle of a run: what was surveyed is what
/// runs, but a made program may differ from the one that it was made from.
pub(crate) fn known_offset(command: Command, settings: &Settings, scene: &str) -> Result<Command, Diagnostic> {
    match &command.op {
        Op::Offset(Offset::Work { word }) => match unknown_offset(&command.location, word, settings, scene) {
            Some(fault) => Err(fault),
            None => Ok(command),
        },
        _ => Ok(command),
    }
}
