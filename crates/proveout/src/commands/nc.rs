use std::io::{self, BufWriter, Write};

use proveout_machine::Machine;
use proveout_nc::post::{Post, PostError, PostSettings, post_for};
use proveout_nc::{
    Command, Compensation, Dialect, JsonWriter, NotRun, Op, Program, ReferencePoints, Settings, ToolAction, ToolName,
    UnknownWords, Weight,
};
use proveout_sim::{SimError, tool_radii};
use proveout_tool::{ToolId, ToolLibrary};

use super::reader::{self, dialect_of};
use crate::{args::NcArgs, failure::Failure};

/// Text that leaves at once: some hundred lines, so that the time of a call to the system does not count.
const OUTPUT_BYTES: usize = 1 << 16;

/// Where the commands go.
enum Sink<'a, W> {
    Json(JsonWriter, W),
    Post(Box<dyn Post + 'a>),
}

impl<W: Write> Sink<'_, W> {
    fn write(&mut self, command: &Command) -> Result<(), Failure> {
        match self {
            Self::Json(writer, out) => writer.write(command, out).map_err(told),
            Self::Post(post) => post.write(command).map_err(unsaid),
        }
    }

    fn flush(&mut self) -> Result<(), Failure> {
        match self {
            Self::Json(_, out) => out.flush().map_err(told),
            Self::Post(post) => post.finish().map_err(unsaid),
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
            Failure::new(format!("the dialect of --post cannot say {what}"))
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
    if args.unknown {
        return unknown(args, &settings);
    }
    let tools = args.tools.as_ref().map(|t| ToolLibrary::read(t)).transpose();
    let tools = tools.map_err(|e| Failure::from(&SimError::from(e)))?;
    let target = args.post.as_deref().map(dialect_of).transpose()?;
    let compensation = tools.as_ref().map_or(Compensation::Programmed, |t| Compensation::ToolCenter(tool_radii(t)));
    let settings = Settings { compensation, ..settings };
    // A written program moves to the coordinates that stand in it: a reference point that nobody knows is refused.
    let settings = match settings.reference_points {
        None if target.is_some() => Settings { reference_points: Some(ReferencePoints::default()), ..settings },
        _ => settings,
    };
    let program = Program::open(&args.program, &settings).map_err(|e| Failure::from(&SimError::from(e)))?;
    let mut out = BufWriter::with_capacity(OUTPUT_BYTES, io::stdout().lock());
    let mut sink = match target {
        None => Sink::Json(JsonWriter::new(), out),
        Some(to) => Sink::Post(post_for(to, format(args, program.dialect(), to), &mut out).map_err(unsaid)?),
    };
    let mut program = program;
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
                    .with_help("add it to the library, or leave --tools out"));
            }
        }
        sink.write(&command)?;
    }
    sink.flush()?;
    not_run(&program.not_run())
}

/// Prints the words that the control has no meaning for.
fn unknown(args: &NcArgs, settings: &Settings) -> Result<(), Failure> {
    let found = UnknownWords::of_file(&args.program, settings).map_err(|e| Failure::from(&SimError::from(e)))?;
    let mut out = io::stdout().lock();
    write!(out, "{found}").map_err(told)
}

/// Tells the text that is not among the commands; what belongs to the program is an error.
fn not_run(parts: &[NotRun]) -> Result<(), Failure> {
    for part in parts.iter().filter(|part| part.weight() < Weight::Lost) {
        tell!("note: {part}");
    }
    match parts.iter().find(|part| part.weight() == Weight::Lost) {
        Some(part) => Err(Failure::new(part).at(&part.file, part.lines[0] as usize, 1, 0, "").with_help(part.remedy())),
        None => Ok(()),
    }
}
