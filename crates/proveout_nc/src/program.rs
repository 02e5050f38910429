//! A program as an iterator of commands.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::codes;
use crate::compensation::{CompensatedReader, may_compensate};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::dialect::{self, detect};
use crate::not_run::NotRun;
use crate::optional_stop::StopWatch;
use crate::settings::{Dialect, Settings};
use crate::source::Source;
use crate::survey::Survey;
use crate::{Command, Location, Note, Op};

/// Something that gives canonical commands one by one.
pub trait CommandSource: Iterator<Item = Result<Command, Diagnostic>> {}

impl<T: Iterator<Item = Result<Command, Diagnostic>>> CommandSource for T {}

/// A program being executed: gives its commands one by one and keeps none of them.
///
/// After an error the program is at its end.
///
/// ```
/// use proveout_nc::{Op, Program, Settings};
///
/// let text = "G21 G90 G54\nG0 X0. Y0. Z5.\nG1 Z-2. F200.\nX40. F600.\nM30\n";
/// let mut ends = Vec::new();
/// for command in Program::from_text("slot.nc", text, &Settings::default())? {
///     if let Op::Linear(motion) = command?.op {
///         ends.push(motion.end.xyz());
///     }
/// }
/// assert_eq!(ends, [Some([0.0, 0.0, -2.0]), Some([40.0, 0.0, -2.0])]); // mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Program {
    commands: CompensatedReader,
    dialect: Dialect,
    /// Notes that wait to be handed out: on lines around the program that the control file names,
    /// before its commands, and on single commands.
    notes: VecDeque<Command>,
    stops: StopWatch,
    settings: Settings,
    /// The run has stopped at a fault.
    failed: bool,
    /// Where the text ends the program: place of its last command. None where a word must end it, and once it
    /// has ended.
    end_of_text: Option<Location>,
}

impl Program {
    /// Opens a program file; subprograms are looked for in its folder and in those of the settings.
    ///
    /// # Errors
    /// The file cannot be read, its dialect is not known, or its control structures do not match.
    pub fn open(path: impl AsRef<Path>, settings: &Settings) -> Result<Self, Diagnostics> {
        let path = path.as_ref();
        let source = Source::read(path).map_err(|diagnostic| Diagnostics::from(*diagnostic))?;
        Self::new(source, folder_of(path), settings)
    }

    /// Reads a program from memory. `name` takes the place of the file name in locations of
    /// commands and errors.
    ///
    /// # Errors
    /// As [`Program::open`].
    pub fn from_text(name: &str, text: impl Into<String>, settings: &Settings) -> Result<Self, Diagnostics> {
        Self::new(Source::new(name, text.into()), None, settings)
    }

    fn new(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Result<Self, Diagnostics> {
        let mut program = Self::lenient(source, folder, settings)?;
        match program.take_structure_faults() {
            faults if faults.is_empty() => Ok(program),
            faults => Err(Diagnostics(faults)),
        }
    }

    /// The program, even where its structure is wrong.
    fn lenient(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Result<Self, Diagnostics> {
        let with_offsets = settings.with_radius_offsets();
        let settings = with_offsets.as_ref().unwrap_or(settings);
        let dialect = match settings.dialect {
            Dialect::Auto => detect(&source.name, &source.text),
            dialect => dialect,
        };
        let dialect = spoken(dialect, &source, settings)?;
        let mut source = source;
        let mut notes = unconfirmed(&source, settings);
        for (line, text) in source.take_out(&settings.control.header, &settings.control.trailer) {
            let location = Location {
                file: Arc::clone(&source.name),
                line,
                column: 1,
                length: text.chars().count() as u32,
                depth: 0,
            };
            notes.push_back(Command {
                location,
                op: Op::Note(Note::new(format!("{} is not a block on this control", text.trim()))),
            });
        }
        source.speak_as(&settings.control);
        let end_of_text = settings.control.ends_with_text.then(|| start_of(&source));
        let compensates = may_compensate(&source.text);
        let reader = dialect::open(dialect, source, folder, settings)?;
        let stops = StopWatch::new(settings.optional_stop);
        Ok(Self {
            commands: CompensatedReader::new(reader, dialect, compensates, settings),
            dialect,
            notes,
            stops,
            settings: settings.clone(),
            failed: false,
            end_of_text,
        })
    }

    pub(crate) fn open_leniently(path: &Path, settings: &Settings) -> Result<Self, Diagnostic> {
        let source = Source::read(path).map_err(|diagnostic| *diagnostic)?;
        Self::lenient(source, folder_of(path), settings).map_err(first)
    }

    pub(crate) fn text_leniently(name: &str, text: String, settings: &Settings) -> Result<Self, Diagnostic> {
        Self::lenient(Source::new(name, text), None, settings).map_err(first)
    }

    pub(crate) fn take_structure_faults(&mut self) -> Vec<Diagnostic> {
        self.commands.reader_mut().take_structure_faults()
    }

    /// Goes on after the block of the last fault; false where nothing can follow.
    pub(crate) fn recover(&mut self) -> bool {
        self.failed = !self.commands.recover();
        !self.failed
    }

    /// The fault may follow from one before.
    pub(crate) fn follows(&self, fault: &Diagnostic) -> bool {
        self.commands.follows(fault)
    }

    /// Files read so far, the main program first.
    pub(crate) fn sources(&self) -> Vec<&Source> {
        self.commands.reader().sources()
    }

    pub(crate) fn is_subprogram(&self) -> bool {
        self.commands.reader().is_subprogram()
    }

    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Text of the files of the program that its run has not reached. Call it when the run is over.
    pub fn not_run(&self) -> Vec<NotRun> {
        self.commands.reader().not_run()
    }

    /// The run has ended at a probing motion whose answer is not in the list ([`Settings::touches`]).
    pub fn waits_for_probe(&self) -> bool {
        self.commands.reader().waits_for_probe()
    }

    /// The dialect that is read.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }
}

impl Iterator for Program {
    type Item = Result<Command, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(note) = self.notes.pop_front() {
            return Some(Ok(note));
        }
        let command = match self.commands.next() {
            Some(Ok(command)) => command,
            Some(Err(diagnostic)) => {
                self.failed = true;
                return Some(Err(*diagnostic));
            }
            None if self.failed => return None,
            None => return self.end_of_text.take().map(|location| Ok(Command { location, op: Op::End })),
        };
        if let Some(last) = &mut self.end_of_text {
            last.clone_from(&command.location);
            if command.op == Op::End {
                self.end_of_text = None;
            }
        }
        let [before, behind] = self.stops.look(&command);
        let beside = |op: Op| Command { location: command.location.clone(), op };
        let behind = behind.map(beside);
        let Some(before) = before.map(beside) else {
            self.notes.extend(behind);
            return Some(Ok(command));
        };
        self.notes.push_back(command);
        self.notes.extend(behind);
        Some(Ok(before))
    }
}

/// The first line of a text.
fn start_of(source: &Source) -> Location {
    Location { file: Arc::clone(&source.name), line: 1, column: 1, length: 0, depth: 0 }
}

/// What the control's file assumes and nobody has confirmed, as notes before the first command.
fn unconfirmed(source: &Source, settings: &Settings) -> VecDeque<Command> {
    let control = &settings.control;
    let note = |(key, why): (&String, &String)| {
        let text = format!(
            "`{key}` of the control \"{}\" is not confirmed: {why}; confirm it and take it out of [assumed]",
            control.name()
        );
        Command { location: start_of(source), op: Op::Note(Note::assuming(text)) }
    };
    control.assumed().iter().map(note).collect()
}

/// The dialect in which a control reads the text: its own, and on a TNC that of the text. It reads programs
/// of its own language only.
fn spoken(dialect: Dialect, source: &Source, settings: &Settings) -> Result<Dialect, Diagnostics> {
    let control = &settings.control;
    match (control.dialect(), dialect) {
        (Dialect::Auto, dialect) => return Ok(dialect),
        (Dialect::Heidenhain | Dialect::HeidenhainIso, Dialect::Heidenhain | Dialect::HeidenhainIso) => {
            let told = detect(&source.name, &source.text);
            return Ok(if told.family() == Dialect::Heidenhain { told } else { dialect });
        }
        (own, Dialect::Iso) if own.family() == Dialect::Iso => return Ok(own),
        (own, dialect) if own == dialect => return Ok(own),
        _ => {}
    }
    Err(Diagnostics::from(Diagnostic {
        code: codes::DIALECT,
        message: format!(
            "{} is to be read as {}, but the dialect of the control \"{}\" is {}",
            source.name,
            dialect.name(),
            control.name(),
            control.dialect().name()
        ),
        file: Arc::clone(&source.name),
        line: 1,
        column: 1,
        length: 0,
        help: Some("name another control, or leave the dialect out".to_owned()),
        about: None,
        source_line: source.text.lines().next().unwrap_or_default().into(),
    }))
}

/// The folder of a program file.
fn folder_of(path: &Path) -> Option<PathBuf> {
    path.parent().map(|p| if p.as_os_str().is_empty() { PathBuf::from(".") } else { p.to_path_buf() })
}

/// The first of several faults: only one can keep a program from being opened at all.
fn first(faults: Diagnostics) -> Diagnostic {
    faults.0.into_iter().next().unwrap_or_else(|| unreachable!("a program is refused with a fault"))
}

/// Everything that can be found wrong with a program: all faults of its lines, its structure and its run, and
/// what is wrong with it as a whole. Empty when the program runs to its end, with motion, and nothing of its
/// own text is left out.
pub fn check(path: impl AsRef<Path>, settings: &Settings) -> Vec<Diagnostic> {
    all(Survey::of_file(path, settings, &mut |_, _| None))
}

/// As [`check`], for a text in memory.
///
/// ```
/// use proveout_nc::{Settings, check_text};
///
/// let check = |text: &str| check_text("slot.nc", text, &Settings::default());
/// let faults = check("G21 G0 X0. Y0. Z5.\nG1 X40.\nM30\n");
/// assert_eq!((faults[0].code, faults[0].line), ("nc-no-feed", 2));
/// assert_eq!(check("G21 G0 X0. Y0. Z5.\nG1 X40. F600.\nM30\n"), []);
/// ```
pub fn check_text(name: &str, text: &str, settings: &Settings) -> Vec<Diagnostic> {
    all(Survey::of_text(name, text, settings, &mut |_, _| None))
}

fn all(survey: Survey) -> Vec<Diagnostic> {
    let defects = survey.defects();
    let mut list = survey.faults;
    list.extend(defects);
    list
}
