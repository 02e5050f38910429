use proveout_sim::SimError;
use proveout_sim::first_part::holder;
use proveout_tool::{ImportCall, PlainHolder, ToolLibrary, import_tools, library_text};

use super::new::unit;
use super::output_file;
use crate::args::ToolsArgs;
use crate::failure::Failure;

/// Writes the tool library of another program as one of this.
pub(crate) fn tools(args: &ToolsArgs) -> Result<(), Failure> {
    output_file::check(&args.output, args.force)?;
    let holder = args.holder.as_deref().map(plain_holder).transpose()?.flatten();
    let wanted = (!args.number.is_empty()).then(|| args.number.iter().copied().collect());
    let call = ImportCall { unit: args.unit.map(unit), wanted };
    let mut imported = import_tools(&args.file, &call).map_err(|e| Failure::from(&SimError::from(e)))?;
    if let Some(missing) = args.number.iter().find(|n| !imported.tools.iter().any(|t| t.number == **n)) {
        return Err(Failure::new(format!("{} has no tool {missing}", args.file.display()))
            .with_help("correct --number, or omit it"));
    }
    for tool in &mut imported.tools {
        tool.complete(holder)
            .map_err(|e| Failure::new(e).with_help("complete the file, or select the other tools with --number"))?;
    }
    let heading = format!(
        "Tools of {}, a {}. Values missing there are marked in `chosen`, with the reason.",
        args.file.display(),
        imported.format
    );
    let text = library_text(&heading, &format!("Tools of {}", args.file.display()), &imported.tools);
    // What is written can be read.
    ToolLibrary::from_text(&args.output, &text).map_err(|e| Failure::from(&SimError::from(e)))?;
    output_file::put_bytes(&args.output, args.force, &text)?;
    for note in &imported.notes {
        tell!("note: {note}");
    }
    for tool in &imported.tools {
        let chosen: Vec<&str> = tool.chosen.iter().flat_map(|(keys, _)| keys.iter().copied()).collect();
        let chosen = if chosen.is_empty() { String::new() } else { format!("; assumed: {}", chosen.join(", ")) };
        say!(
            "T{:<4} {:<24} {:<10} D{:<9.4} to the gauge line {:.3} mm{chosen}",
            tool.number,
            tool.name,
            tool.kind.unwrap_or("flat"),
            tool.diameter().unwrap_or(0.0),
            tool.gauge.unwrap_or(0.0)
        );
    }
    say!("{} tools from a {}: {}", imported.tools.len(), imported.format, args.output.display());
    Ok(())
}

fn plain_holder(text: &str) -> Result<Option<PlainHolder>, Failure> {
    holder(text).ok_or_else(|| {
        Failure::new(format!("--holder {text:?} is not a holder"))
            .with_help("write none, or diameter and length to the gauge line: 40x60, or 1.6x2.5 inch")
    })
}
