//! A whole program read before anything is done with it: every fault, and what of its text is not run.
//!
//! Readers read millions of blocks a second, so that a separate pass costs little compared with
//! planning motion. It runs the program as the control would, branches and loops included, and goes
//! on after each fault. What a block with a fault would have set is in doubt (see the readers); a
//! fault that may follow from it is not reported.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::Command;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::dialect;
use crate::not_run::{NotRun, Weight};
use crate::program::Program;
use crate::settings::{Compensation, Dialect, Settings};
use crate::tally::{Remark, Tally};

/// Most faults that are kept; further ones are counted.
const MAX_FAULTS: usize = 1000;
/// Limit of recoveries after faults: a loop of many passes can run into one again and again.
const MAX_RECOVERIES: u32 = 200_000;

/// Sees every command of a survey with the dialect that is read, and may find fault with it.
pub type Look<'a> = dyn FnMut(&Command, Dialect) -> Option<Diagnostic> + 'a;

/// What a reading pass over a whole program has found.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The dialect that was read; [`Dialect::Auto`] where it was not recognized.
    pub dialect: Dialect,
    /// Commands of the run.
    pub commands: u64,
    /// Motions among them.
    pub motions: u64,
    /// The run reached a programmed end.
    pub ended: bool,
    /// The text is that of a subprogram: it need not move, nor end as a main program does.
    pub subprogram: bool,
    /// What is wrong, each fault once, in the order of the files and lines.
    pub faults: Vec<Diagnostic>,
    /// Further faults that were counted only.
    pub more_faults: usize,
    /// Text that the run has not reached; empty where faults kept the run from reaching its end.
    pub not_run: Vec<NotRun>,
    /// What the reader assumed, each text once, in the order of the run.
    pub assumptions: Vec<Remark>,
    /// Words without effect and other notes, each text once, in the order of the run.
    pub notes: Vec<Remark>,
    /// The run has ended at a probing motion that waits for its answer ([`Settings::touches`]).
    pub waits_for_probe: bool,
    /// Texts that were read, by the names under which they were opened: the main program first, then called
    /// ones.
    pub files: Vec<Arc<str>>,
    /// Place of the last command, or of the start of the text.
    last: Option<(Arc<str>, u32, String)>,
}

impl Survey {
    /// Surveys a program file. `look` sees every command of the run and may find fault with it.
    pub fn of_file(path: impl AsRef<Path>, settings: &Settings, look: &mut Look<'_>) -> Self {
        match Program::open_leniently(path.as_ref(), settings) {
            Ok(program) => Self::of(program, look),
            Err(fault) => Self::refused(fault),
        }
    }

    /// Surveys a text; `name` takes the place of the file name.
    pub fn of_text(name: &str, text: impl Into<String>, settings: &Settings, look: &mut Look<'_>) -> Self {
        match Program::text_leniently(name, text.into(), settings) {
            Ok(program) => Self::of(program, look),
            Err(fault) => Self::refused(fault),
        }
    }

    fn refused(fault: Diagnostic) -> Self {
        Self { faults: vec![fault], ..Self::default() }
    }

    fn of(mut program: Program, look: &mut Look<'_>) -> Self {
        let dialect = program.dialect();
        let mut list = Faults::default();
        for fault in program.take_structure_faults() {
            list.put(fault);
        }
        let mut recoveries = 0;
        let mut tally = Tally::default();
        loop {
            match program.next() {
                None => break,
                Some(Ok(command)) => {
                    tally.take(&command);
                    if let Some(fault) = look(&command, dialect) {
                        list.put(fault);
                    }
                }
                Some(Err(fault)) => {
                    if !program.follows(&fault) {
                        list.put(fault);
                    }
                    recoveries += 1;
                    if recoveries > MAX_RECOVERIES || !program.recover() {
                        break;
                    }
                }
            }
        }
        Self::close(&program, tally, list)
    }

    /// The survey of a program that has run to its end without a fault, with the commands that it gave.
    pub fn of_run(program: &Program, tally: Tally) -> Self {
        Self::close(program, tally, Faults::default())
    }

    fn close(program: &Program, tally: Tally, mut list: Faults) -> Self {
        let mut survey = Self { dialect: program.dialect(), ..Self::default() };
        (survey.commands, survey.motions, survey.ended) = (tally.commands, tally.motions, tally.ended);
        // Faults of lines, whether they were run or not.
        for source in program.sources() {
            for fault in dialect::line_faults(program.dialect(), source, program.settings()) {
                list.put(fault);
            }
        }
        let order: Vec<Arc<str>> = program.sources().iter().map(|source| Arc::clone(&source.name)).collect();
        survey.last = tally.last.clone().or_else(|| Some((order.first()?.clone(), 1))).map(|(file, line)| {
            let text =
                program.sources().iter().find(|s| s.name == file).and_then(|s| s.text_of(line)).unwrap_or_default();
            (file, line, text.to_owned())
        });
        survey.subprogram = program.is_subprogram();
        survey.waits_for_probe = program.waits_for_probe();
        if list.all.is_empty() && !survey.waits_for_probe {
            survey.not_run = program.not_run();
        }
        let compensated = matches!(program.settings().compensation, Compensation::ToolCenter(_));
        (survey.assumptions, survey.notes) = tally.remarks(compensated);
        let place = |fault: &Diagnostic| order.iter().position(|name| *name == fault.file).unwrap_or(order.len());
        list.all.sort_by_key(|fault| (place(fault), fault.line, fault.column));
        survey.files = order;
        survey.faults = list.all;
        survey.more_faults = list.more;
        survey
    }

    /// What is wrong with the program: its faults, or where it has none, its defects as a whole.
    /// Every command that shows a program fails on it. Calls that the control leaves out for a
    /// reason are no defect.
    pub fn judged(&self) -> Vec<Diagnostic> {
        if self.faults.is_empty() { self.own_defects() } else { self.faults.clone() }
    }

    /// Remarks on a program that is in order: text that is not run, assumptions, notes; `most` of
    /// each kind.
    pub fn remarks(&self, most: usize) -> Vec<String> {
        self.remarks_of(|_| true, most)
    }

    /// As [`Survey::remarks`]. Where `told` is false, remarks that notes among the printed commands
    /// repeat are left out. A post prints no commands and passes true.
    pub fn remarks_beside_commands(&self, told: bool, most: usize) -> Vec<String> {
        self.remarks_of(|remark| told || !remark.among_commands, most)
    }

    fn remarks_of(&self, wanted: impl Fn(&Remark) -> bool, most: usize) -> Vec<String> {
        let main = self.files.first();
        let place = |remark: &Remark| {
            let Remark { file, line, .. } = remark;
            let file = if main == Some(file) { String::new() } else { format!(" of {file}") };
            let times = if remark.count > 1 { format!(" ({} times)", remark.count) } else { String::new() };
            format!("line {line}{file}: {}{times}", remark.text)
        };
        let mut all = Vec::new();
        let mut list = |kind: &str, texts: Vec<String>, what: &str| {
            let more = texts.len().saturating_sub(most);
            all.extend(texts.into_iter().take(most).map(|text| format!("{kind}: {text}")));
            if more > 0 {
                all.push(format!("{kind}: and {more} more {what}"));
            }
        };
        list("note", self.not_run.iter().map(ToString::to_string).collect(), "stretches of text that are not run");
        let told = |list: &[Remark]| list.iter().filter(|remark| wanted(remark)).map(place).collect();
        list("assumed", told(&self.assumptions), "assumptions");
        list("note", told(&self.notes), "notes");
        all
    }

    /// As [`Survey::defects`], without calls that the control leaves out for a reason: that is its
    /// choice, and a run reports it.
    pub fn own_defects(&self) -> Vec<Diagnostic> {
        self.defects_of(|part| !part.is_left_out())
    }

    /// What is wrong with the program as a whole where its blocks are in order: no motion, no end, text that
    /// is lost.
    pub fn defects(&self) -> Vec<Diagnostic> {
        self.defects_of(|_| true)
    }

    fn defects_of(&self, counts: impl Fn(&NotRun) -> bool) -> Vec<Diagnostic> {
        if !self.faults.is_empty() || self.waits_for_probe {
            return Vec::new();
        }
        let mut list = Vec::new();
        if let Some((file, line, text)) = &self.last {
            let at = |code: &'static str, message: String, help: &str| Diagnostic {
                code,
                message,
                file: Arc::clone(file),
                line: *line,
                column: 1,
                length: characters(text),
                help: Some(help.to_owned()),
                source_line: text.as_str().into(),
                about: None,
            };
            if self.motions == 0 && !self.subprogram {
                let message = format!("the program moves no axis; it was read as {}", self.dialect.name());
                list.push(at(
                    codes::NO_MOTION,
                    message,
                    "check that the file holds the whole program, and name its dialect",
                ));
            }
            if !self.ended {
                let word = match self.dialect {
                    Dialect::Siemens840d => "M30, or M17 in a subprogram",
                    Dialect::Heidenhain | Dialect::HeidenhainIso => "END PGM or M30",
                    Dialect::Apt => "FINI",
                    _ => "M30, or M99 in a subprogram",
                };
                list.push(at(
                    codes::NO_END,
                    "the text ends without an end of the program: it may be cut off".to_owned(),
                    &format!("write {word} at its end"),
                ));
            }
        }
        let heavy = |part: &&NotRun| part.weight() > Weight::Harmless && counts(part);
        list.extend(self.not_run.iter().filter(heavy).map(|part| Diagnostic {
            code: codes::NOT_RUN,
            message: part.to_string(),
            file: Arc::clone(&part.file),
            line: part.lines[0],
            column: 1,
            length: characters(&part.text),
            help: Some(part.remedy().to_owned()),
            source_line: part.text.as_str().into(),
            about: None,
        }));
        list
    }
}

/// Faults, each once.
#[derive(Default)]
struct Faults {
    all: Vec<Diagnostic>,
    more: usize,
    seen: BTreeSet<(Arc<str>, u32, u32, &'static str)>,
}

impl Faults {
    fn put(&mut self, fault: Diagnostic) {
        // One fault of a block is reported once, whether it is found when the line is read or again
        // when it is run.
        if !self.seen.insert((Arc::clone(&fault.file), fault.line, fault.column, fault.code)) {
            return;
        }
        if self.all.len() < MAX_FAULTS {
            self.all.push(fault);
        } else {
            self.more += 1;
        }
    }
}

fn characters(text: &str) -> u32 {
    u32::try_from(text.chars().count()).unwrap_or(u32::MAX)
}
