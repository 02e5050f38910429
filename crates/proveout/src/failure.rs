use std::{collections::BTreeMap, fmt::Display, path::Path};

use proveout_nc::{Diagnostic, ProgramText};
use proveout_sim::SimError;

use crate::{front::FaultKind, terminal};

/// Characters of a line that are shown.
const SHOWN: usize = 160;
/// Most errors of one file that are shown; the others are counted.
const MAX_SHOWN: usize = 50;

/// An error for people: place, message, line of text, remedy. Ends the program with exit code 2.
#[derive(Debug, Default)]
pub(crate) struct Failure(Box<FailureParts>);

#[derive(Debug, Default)]
struct FailureParts {
    kind: FaultKind,
    /// Stable code, where the fault has one.
    code: Option<&'static str>,
    message: String,
    place: Option<FilePlace>,
    source_line: Option<String>,
    /// Column of the fault in `source_line`, from 1, and its length.
    mark: Option<(usize, usize)>,
    help: Option<String>,
    /// Further errors of the same file.
    more: Vec<Failure>,
    /// Number of further errors that are not kept.
    uncounted: usize,
}

/// A place in a file: line and column from 1; zero where only the file, or only the line, is known.
#[derive(Debug)]
struct FilePlace {
    file: String,
    line: usize,
    column: usize,
}

impl Display for FilePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.line, self.column) {
            (0, _) => write!(f, "{}", self.file),
            (line, 0) => write!(f, "{}:{line}", self.file),
            (line, column) => write!(f, "{}:{line}:{column}", self.file),
        }
    }
}

impl Failure {
    pub(crate) fn new(message: impl Display) -> Self {
        Self(Box::new(FailureParts { message: message.to_string(), ..FailureParts::default() }))
    }

    pub(crate) fn with_help(mut self, help: impl Display) -> Self {
        self.0.help = Some(help.to_string()).filter(|h| !h.is_empty());
        self
    }

    /// Appends to the existing help.
    pub(crate) fn with_more_help(mut self, help: impl Display) -> Self {
        let before = self.0.help.take().map_or_else(String::new, |h| h + "; ");
        self.0.help = Some(format!("{before}{help}"));
        self
    }

    pub(crate) fn at(mut self, file: impl Display, line: usize, column: usize, length: usize, text: &str) -> Self {
        self.0.place = Some(FilePlace { file: file.to_string(), line, column });
        if !text.is_empty() && column > 0 {
            self.0.source_line = Some(text.replace('\t', " "));
            self.0.mark = Some((column, length.max(1)));
        }
        self
    }

    fn coded(mut self, code: &'static str) -> Self {
        self.0.code = Some(code);
        self
    }

    pub(crate) fn code(&self) -> Option<&'static str> {
        self.0.code
    }

    /// This error, then the further ones of the same file.
    pub(crate) fn all(&self) -> Vec<&Self> {
        std::iter::once(self).chain(self.0.more.iter().flat_map(Self::all)).collect()
    }

    /// Text of its line; empty where it is not known.
    pub(crate) fn source_line(&self) -> &str {
        self.0.source_line.as_deref().unwrap_or_default()
    }

    fn of_kind(mut self, kind: FaultKind) -> Self {
        self.0.kind = kind;
        self
    }

    pub(crate) fn kind(&self) -> FaultKind {
        self.0.kind
    }

    pub(crate) fn message(&self) -> &str {
        &self.0.message
    }

    /// File, line and column; zero where only the file, or only the line, is known.
    pub(crate) fn place(&self) -> Option<(&str, usize, usize)> {
        self.0.place.as_ref().map(|p| (p.file.as_str(), p.line, p.column))
    }

    pub(crate) fn help(&self) -> &str {
        self.0.help.as_deref().unwrap_or_default()
    }

    /// Takes out of a list the errors that say the same of another line of the file.
    fn take_same<'a>(&self, rest: &mut Vec<&'a Self>) -> Vec<&'a Self> {
        let file = |e: &Self| e.place().filter(|(_, line, _)| *line > 0).map(|(file, ..)| file.to_owned());
        let own = file(self);
        let says_it = |e: &&Self| {
            own.is_some()
                && file(e) == own
                && e.message() == self.message()
                && e.help() == self.help()
                && e.0.more.is_empty()
        };
        let (same, other) = rest.drain(..).partition(says_it);
        *rest = other;
        same
    }

    /// This error and the further ones of the same file, for programs that read: message, file, line,
    /// column, help.
    pub(crate) fn for_programs(&self) -> Vec<serde_json::Value> {
        let mut all = vec![serde_json::json!({ "message": self.message(), "help": self.help() })];
        if let (Some((file, line, column)), Some(own)) = (self.place(), all[0].as_object_mut()) {
            own.insert("file".into(), file.into());
            let known = [("line", line), ("column", column)].into_iter().filter(|(_, n)| *n > 0);
            own.extend(known.map(|(key, n)| (key.to_owned(), n.into())));
        }
        all.extend(self.0.more.iter().flat_map(Self::for_programs));
        if self.0.uncounted > 0 {
            all.push(serde_json::json!({ "message": format!("and {} more errors", self.0.uncounted), "help": "" }));
        }
        all
    }
}

impl Failure {
    /// Faults of programs, and how many more there are.
    pub(crate) fn of_program(faults: &[Diagnostic], more: usize) -> Self {
        let mut lines = ProgramLines::default();
        let mut each = faults.iter().take(MAX_SHOWN).map(|d| {
            let text =
                if d.source_line.is_empty() { lines.get(&d.file, d.line as usize) } else { d.source_line.to_string() };
            Self::new(format!("{} [{}]", d.message, d.code))
                .coded(d.code)
                .at(&d.file, d.line as usize, d.column as usize, d.length as usize, &text)
                .with_help(d.help.as_deref().unwrap_or_default())
        });
        let mut first = each.next().unwrap_or_default();
        first.0.more = each.collect();
        first.0.uncounted = more + faults.len().saturating_sub(MAX_SHOWN);
        first
    }
}

/// Lines of program files for display, each file read once.
#[derive(Default)]
struct ProgramLines(BTreeMap<String, Option<ProgramText>>);

impl ProgramLines {
    /// Empty when the file cannot be read any more.
    fn get(&mut self, file: &str, line: usize) -> String {
        let text = self.0.entry(file.to_owned()).or_insert_with(|| ProgramText::open(file).ok());
        text.as_ref().and_then(|text| text.line(line)).unwrap_or_default().to_owned()
    }
}

/// Line numbers of an error that is printed once for several places.
fn also_at(f: &mut std::fmt::Formatter<'_>, same: &[&Failure]) -> std::fmt::Result {
    let lines: Vec<String> =
        same.iter().take(MAX_LINES).filter_map(|e| e.place()).map(|(_, line, _)| line.to_string()).collect();
    match (&lines[..], same.len().saturating_sub(MAX_LINES)) {
        ([], _) => Ok(()),
        ([line], _) => writeln!(f, "  the same in line {line}"),
        (lines, 0) => writeln!(f, "  the same in lines {}", lines.join(", ")),
        (lines, more) => writeln!(f, "  the same in lines {} and {more} more", lines.join(", ")),
    }
}

/// Largest number of lines listed for an error that is printed once for several places.
const MAX_LINES: usize = 12;

/// One line: a message or a name of a file may hold line feeds.
fn plain(text: &str) -> String {
    terminal::plain(text).replace('\n', "\u{240a}")
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let FailureParts { message, place, source_line, mark, help, more, uncounted, .. } = &*self.0;
        writeln!(f, "error: {}", terminal::plain(message))?;
        if let Some(place) = place {
            writeln!(f, "  at {}", plain(&place.to_string()))?;
        }
        if let (Some(line), Some((column, length))) = (source_line, *mark) {
            let shown: String = line.chars().take(SHOWN).collect();
            writeln!(f, "   | {}", plain(&shown))?;
            if column <= SHOWN {
                writeln!(f, "   | {}{}", " ".repeat(column - 1), "^".repeat(length.min(SHOWN + 1 - column)))?;
            }
        }
        if let Some(help) = help {
            writeln!(f, "  help: {help}")?;
        }
        let mut rest: Vec<&Self> = more.iter().collect();
        let same = self.take_same(&mut rest);
        also_at(f, &same)?;
        while !rest.is_empty() {
            let first = rest.remove(0);
            write!(f, "{first}")?;
            let same = first.take_same(&mut rest);
            also_at(f, &same)?;
        }
        if *uncounted > 0 { writeln!(f, "and {uncounted} more errors") } else { Ok(()) }
    }
}

impl From<&SimError> for Failure {
    fn from(e: &SimError) -> Self {
        let kind = match e {
            SimError::Program(_) | SimError::Post(_) => FaultKind::Program,
            SimError::Control(_) => FaultKind::Control,
            SimError::Folder(_) | SimError::Observer(_) | SimError::Journal(_) | SimError::Shard(_) => {
                FaultKind::Folder
            }
            _ => FaultKind::Input,
        };
        let failure = match e {
            SimError::Input(e) => {
                Self::new(&**e).at(e.file.display(), e.line, e.column, e.length, &e.source_line).with_help(&e.remedy)
            }
            SimError::Memory { remedy, .. } => Self::new(e).with_help(remedy),
            SimError::StopAt { help, .. } => Self::new(e).with_help(help),
            SimError::Program(all) => Self::of_program(&all.0, 0),
            SimError::ControlFile(c) => Self::new(format!("{}: {} [{}]", c.key, c.message, c.code))
                .at(
                    &c.file,
                    c.line,
                    c.column,
                    c.key.rsplit('.').next().map_or(1, str::len),
                    &line_of(Path::new(&c.file), c.line),
                )
                .with_help(&c.remedy),
            SimError::Control(c) => {
                let failure =
                    Self::new(format!("{} [{}]", c.message, c.code)).with_help(c.help.as_deref().unwrap_or_default());
                match &c.location {
                    Some(l) => {
                        let text = line_of(Path::new(&*l.file), l.line as usize);
                        failure.at(&l.file, l.line as usize, l.column as usize, l.length as usize, &text)
                    }
                    None => failure,
                }
            }
            SimError::Mesh { path, source } => Self::new(source).at(path.display(), 0, 0, 0, "").with_help(
                "repair the mesh in the program that made it: a solid must be closed, with face normals outward",
            ),
            SimError::Stock(s) => Self::new(s).with_help("see resolution_mm of the scene, or --resolution-mm"),
            SimError::Folder(f) => Self::new(f).with_help("name another folder with --output"),
            other => Self::new(other),
        };
        failure.of_kind(kind)
    }
}

/// A line of a file for display; empty when it cannot be read any more.
fn line_of(file: &Path, line: usize) -> String {
    ProgramLines::default().get(&file.display().to_string(), line)
}
