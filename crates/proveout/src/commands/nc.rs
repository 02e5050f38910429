use std::io::{self, BufWriter, Write};

use proveout_nc::{Dialect, JsonWriter, Op, Program, Settings, ToolAction, ToolName};
use proveout_sim::SimError;
use proveout_tool::{ToolId, ToolLibrary};

use crate::{args::NcArgs, failure::Failure};

/// Prints the canonical commands of a program as JSON lines.
pub(crate) fn nc(args: &NcArgs) -> Result<(), Failure> {
    let dialect = match args.dialect.as_deref() {
        None => Dialect::Auto,
        Some(name) => Dialect::from_name(name).ok_or_else(|| {
            let names: Vec<&str> = Dialect::NAMES.iter().map(|(name, _)| *name).collect();
            Failure::new(format!("dialect {name:?} is not known"))
                .with_help(format!("write one of {}, or leave it out", names.join(", ")))
        })?,
    };
    let tools = args.tools.as_ref().map(|t| ToolLibrary::read(t)).transpose();
    let tools = tools.map_err(|e| Failure::from(&SimError::from(e)))?;
    let settings = Settings { dialect, ..Settings::default() };
    let program = Program::open(&args.program, &settings).map_err(|e| Failure::from(&SimError::from(e)))?;
    let mut out = BufWriter::new(io::stdout().lock());
    let mut writer = JsonWriter::new();
    let told = |e: io::Error| Failure::new(format!("standard output: {e}"));
    for command in program {
        let command = match command {
            Ok(command) => command,
            Err(e) => {
                out.flush().map_err(told)?;
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
                out.flush().map_err(told)?;
                let l = &command.location;
                return Err(Failure::new(format!("the tool library has no tool {id:?}"))
                    .at(&l.file, l.line as usize, l.column as usize, l.length as usize, "")
                    .with_help("add it to the library, or leave --tools out"));
            }
        }
        writer.write(&command, &mut out).map_err(told)?;
    }
    out.flush().map_err(told)
}
