//! What the commands of a run say of the whole program: how many they are, whether it moves and ends, what
//! was taken for granted.
//!
//! Every command that shows a program counts with this: a survey, the commands of a program as text, a post.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::{Command, CompSide, CutterComp, Op};

/// Most remarks of a kind that are kept; further ones are counted.
const MAX_REMARKS: usize = 1000;
/// A dwell from this time on is nearly always one of milliseconds meant for seconds, s.
const LONG_DWELL_S: f64 = 60.0;

/// A remark on a program, with the place where it occurs first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// File as given by the caller.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// The remark.
    pub text: String,
    /// How often it occurs in the run.
    pub count: u64,
    /// A note among the commands carries it.
    pub among_commands: bool,
}

/// Remarks, each text once.
#[derive(Clone, Debug, Default)]
struct Remarks {
    all: Vec<Remark>,
    at: BTreeMap<String, usize>,
    more: u64,
}

impl Remarks {
    fn put(&mut self, text: &str, command: &Command, among_commands: bool) {
        if let Some(remark) = self.at.get(text).and_then(|at| self.all.get_mut(*at)) {
            remark.count += 1;
        } else if self.all.len() < MAX_REMARKS {
            self.at.insert(text.to_owned(), self.all.len());
            let (file, line) = (Arc::clone(&command.location.file), command.location.line);
            self.all.push(Remark { file, line, text: text.to_owned(), count: 1, among_commands });
        } else {
            self.more += 1;
        }
    }
}

/// Counts the commands of a run.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub(crate) commands: u64,
    pub(crate) motions: u64,
    pub(crate) ended: bool,
    /// Place of the last command.
    pub(crate) last: Option<(Arc<str>, u32)>,
    assumptions: Remarks,
    notes: Remarks,
    /// Where cutter compensation is switched on first without a radius.
    uncompensated: Option<(Arc<str>, u32)>,
}

impl Tally {
    /// Counts a command.
    pub fn take(&mut self, command: &Command) {
        self.commands += 1;
        match &command.op {
            Op::Rapid(_)
            | Op::Linear(_)
            | Op::Arc(_)
            | Op::Spline(_)
            | Op::Probe(_)
            | Op::Thread(_)
            | Op::Retract(_) => self.motions += 1,
            Op::End => self.ended = true,
            Op::Note(note) => match note.assumption() {
                Some(text) => self.assumptions.put(text, command, true),
                None => self.notes.put(note, command, true),
            },
            Op::CutterComp(CutterComp { side: CompSide::Left | CompSide::Right, radius: None, .. }) => {
                let place = || (Arc::clone(&command.location.file), command.location.line);
                self.uncompensated.get_or_insert_with(place);
            }
            Op::Dwell(crate::Dwell::Seconds(seconds)) if *seconds >= LONG_DWELL_S => {
                self.notes.put(&long_dwell(*seconds), command, false);
            }
            _ => {}
        }
        let same = self.last.as_ref().is_some_and(|(file, _)| Arc::ptr_eq(file, &command.location.file));
        match &mut self.last {
            Some((_, line)) if same => *line = command.location.line,
            last => *last = Some((Arc::clone(&command.location.file), command.location.line)),
        }
    }

    /// What the readers take for granted, and the notes, in the order of the run. `compensated`: the path is
    /// that of the tool center.
    pub(crate) fn remarks(self, compensated: bool) -> (Vec<Remark>, Vec<Remark>) {
        let mut assumptions = self.assumptions.all;
        if let Some((file, line)) = self.uncompensated.filter(|_| !compensated) {
            let text = "no radius of the tool is known: cutter compensation is left out, and its faults are not looked for; give the \
                        tools with --tools, or check the scene";
            assumptions.push(Remark { file, line, text: text.to_owned(), count: 1, among_commands: false });
        }
        (assumptions, self.notes.all)
    }
}

/// The remark on a long dwell.
pub fn long_dwell(seconds: f64) -> String {
    format!(
        "the program waits {seconds} s: so long a dwell is mostly one of milliseconds on a control that counts seconds"
    )
}
