use std::io::{self, BufWriter, Write};

use proveout_machine::Machine;
use proveout_nc::post::{Difference, Post, PostError, PostSettings, post_for, verify};
use proveout_nc::{
    Command, Compensation, Dialect, JsonWriter, Op, Program, ReferencePoints, Settings, Survey, Tally, ToolAction,
    ToolName,
};
use proveout_sim::{SimError, tool_radii};
use proveout_tool::{ToolId, ToolLibrary};

use super::{
    advise, output_file,
    reader::{self, dialect_of},
};
use crate::{args::NcArgs, failure::Failure};

/// Text that leaves at once: some hundred lines, so that the time of a call to the system does not count.
const OUTPUT_BYTES: usize = 1 << 16;
/// Largest number of remarks of a kind that are printed.
pub(super) const MAX_REMARKS: usize = 20;

/// Where the commands go.
enum Sink<'a, W> {
    Json(JsonWriter, W),
    /// Program text, which is read again before anything of it is shown.
    Post(Box<dyn Post + 'a>),
}

impl<W: Write> Sink<'_, W> {
    fn write(&mut self, command: &Command) -> Result<(), Failure> {
        match self {
            Self::Json(writer, out) => writer.write(command, out).map_err(told),
            Self::Post(post) => post.write(command).map_err(unsaid),
        }
    }

    /// What there is before a fault; a program is written whole or not at all.
    fn flush(&mut self) -> Result<(), Failure> {
        match self {
            Self::Json(_, out) => out.flush().map_err(told),
            Self::Post(_) => Ok(()),
        }
    }

    fn finish(self) -> Result<(), Failure> {
        match self {
            Self::Json(_, mut out) => out.flush().map_err(told),
            Self::Post(mut post) => post.finish().map_err(unsaid),
        }
    }
}

fn told(e: io::Error) -> Failure {
    Failure::new(format!("standard output: {e}"))
}

/// What a language cannot say, with the place of the program that asks for it.
fn unsaid(error: PostError) -> Failure {
    match error {
        PostError::Io(e) => told(e),
        PostError::Unsupported { what, help, location: l } => {
            Failure::new(format!("the dialect of --post cannot express {what}"))
                .at(&l.file, l.line as usize, l.column as usize, l.length as usize, "")
                .with_help(help)
        }
        other => Failure::new(other.to_string()),
    }
}

/// The format that the call asks for.
fn format(args: &NcArgs, from: Dialect, to: Dialect) -> PostSettings {
    let mut settings = PostSettings::between(from, to);
    if args.inch {
        settings = settings.in_inches();
    }
    if let Some(decimals) = args.decimals {
        let more = settings.center_decimals.saturating_sub(settings.length_decimals);
        settings.length_decimals = usize::from(decimals);
        settings.angle_decimals = usize::from(decimals);
        settings.center_decimals = usize::from(decimals) + more;
    }
    settings.block_number_step = args.block_numbers.or(settings.block_number_step);
    settings.arc_radius |= args.arc_radius;
    settings.modal &= !args.all_words;
    settings.trailing_zeros |= args.trailing_zeros;
    match &args.program_name {
        Some(name) => settings.program_name.clone_from(name),
        None => {
            if let Some(stem) = args.program.file_stem() {
                settings.program_name = stem.to_string_lossy().into_owned();
            }
        }
    }
    settings
}

/// Prints the canonical commands of a program as JSON lines, or the program in another dialect.
pub(crate) fn nc(args: &NcArgs) -> Result<(), Failure> {
    let machine = args.machine.as_deref().map(Machine::read).transpose();
    let machine = machine.map_err(|e| Failure::from(&SimError::from(e)))?;
    let settings = reader::settings(&args.reader, machine.as_ref(), &args.program)?;
    if let Some(file) = &args.write_control {
        output_file::check(file, args.force)?;
    }
    if args.unknown {
        advise::print_unknown(&args.program, &args.reader, machine.as_ref(), &settings)?;
    }
    if let Some(file) = &args.write_control {
        let advice = advise::advice(std::slice::from_ref(&args.program), &args.reader, machine.as_ref())?;
        if advise::write_control(&advice, file, args.force, &|line| say!("{line}"))? {
            say!("next: proveout check {} --control {}", args.program.display(), file.display());
        }
    }
    if args.unknown || args.write_control.is_some() {
        return Ok(());
    }
    let tools = args.tools.as_ref().map(|t| ToolLibrary::read(t)).transpose();
    let tools = tools.map_err(|e| Failure::from(&SimError::from(e)))?;
    let target = args.post.as_deref().map(dialect_of).transpose()?;
    let compensation = tools.as_ref().map_or(Compensation::Programmed, |t| Compensation::ToolCenter(tool_radii(t)));
    let settings = Settings { compensation, ..settings };
    // A written program moves to explicit coordinates, so a move to an unknown reference point is refused.
    let settings = match settings.reference_points {
        None if target.is_some() => Settings { reference_points: Some(ReferencePoints::default()), ..settings },
        _ => settings,
    };
    let program = Program::open(&args.program, &settings).map_err(|e| Failure::from(&SimError::from(e)))?;
    let mut text = Vec::new();
    let form = target.map(|to| format(args, program.dialect(), to));
    let mut sink = match (target, &form) {
        (Some(to), Some(form)) => Sink::Post(post_for(to, form.clone(), &mut text).map_err(unsaid)?),
        _ => Sink::Json(JsonWriter::new(), BufWriter::with_capacity(OUTPUT_BYTES, io::stdout().lock())),
    };
    let mut program = program;
    let mut tally = Tally::default();
    for command in program.by_ref() {
        let command = match command {
            Ok(command) => command,
            Err(e) => {
                sink.flush()?;
                return Err(Failure::from(&SimError::from(e)));
            }
        };
        if let (Some(tools), Op::Tool(ToolAction::Select(name) | ToolAction::Change(name))) = (&tools, &command.op) {
            let id = match name {
                ToolName::Empty => None,
                ToolName::Number(n) => Some(ToolId::Number(*n)),
                ToolName::Name(n) => Some(ToolId::Name(n.clone())),
            };
            if let Some(id) = id
                && tools.find(&id).is_none()
            {
                sink.flush()?;
                let l = &command.location;
                return Err(Failure::new(format!("the tool library has no tool {id:?}"))
                    .at(&l.file, l.line as usize, l.column as usize, l.length as usize, "")
                    .with_help("add it to the library, or omit --tools"));
            }
        }
        tally.take(&command);
        sink.write(&command)?;
    }
    sink.finish()?;
    let survey = Survey::of_run(&program, tally);
    let judged = judge(&survey, target.is_some());
    let (Some(to), Some(form)) = (target, form) else { return judged };
    judged?;
    let text = String::from_utf8(text).map_err(Failure::new)?;
    read_again(args, &settings, to, &form, &text)?;
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(told)
}

/// Reads a written program with the reader of its dialect and compares its motion with that of the
/// original.
fn read_again(args: &NcArgs, settings: &Settings, to: Dialect, form: &PostSettings, text: &str) -> Result<(), Failure> {
    let name = format!("{} as {}", args.program.display(), to.name());
    let reading = Settings {
        dialect: to,
        reference_points: settings.reference_points.clone(),
        limits: settings.limits,
        ..Settings::default()
    };
    let original = Program::open(&args.program, settings).map_err(|e| Failure::from(&SimError::from(e)))?;
    let written = Program::from_text(&name, text, &reading).map_err(|e| Failure::from(&SimError::from(e)))?;
    verify(original, written, form).map_err(|Difference { what, original, written_line }| {
        let shown = text.lines().nth((written_line as usize).saturating_sub(1)).unwrap_or_default();
        let failure = Failure::new(format!(
            "nothing is written: when read back, the {} program does not move like the original: {what}",
            to.name()
        ));
        let failure = match &original {
            Some(l) => failure.at(&l.file, l.line as usize, l.column as usize, l.length as usize, ""),
            None => failure,
        };
        failure.with_help(format!(
            "see line {written_line} of the written text, `{}`; use more decimals (--decimals), or change the original there",
            shown.trim()
        ))
    })
}

/// Prints the part of the `check` result that is not among the commands. A fault of the program as a whole
/// is an error.
fn judge(survey: &Survey, posted: bool) -> Result<(), Failure> {
    let judged = survey.judged();
    if !judged.is_empty() {
        return Err(Failure::of_program(&judged, survey.more_faults));
    }
    // The commands themselves hold notes and assumptions, a program in another dialect does not.
    for remark in survey.remarks_beside_commands(posted, MAX_REMARKS) {
        tell!("{remark}");
    }
    Ok(())
}
