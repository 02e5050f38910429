//! The control file that lets programs be read, written from the programs: `nc --unknown`, `nc
//! --write-control`, `new --write-control`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use proveout_machine::Machine;
use proveout_nc::{Advice, AdviceCall, Settings, UnknownWords};
use proveout_sim::SimError;

use super::{output_file, reader};
use crate::args::ReaderArgs;
use crate::failure::Failure;

/// What lets these programs be read with one control file.
pub(super) fn advice(programs: &[PathBuf], args: &ReaderArgs, machine: Option<&Machine>) -> Result<Advice, Failure> {
    let Some(first) = programs.first() else { return Err(Failure::new("no program is given")) };
    let settings = reader::settings(args, machine, first)?;
    advice_with(programs, args, machine, &settings)
}

fn advice_with(
    programs: &[PathBuf],
    args: &ReaderArgs,
    machine: Option<&Machine>,
    settings: &Settings,
) -> Result<Advice, Failure> {
    let complete = |of_control: Settings| {
        // What the call states was read once without a fault.
        let kept = of_control.clone();
        reader::stated(args, machine, of_control).unwrap_or(kept)
    };
    let call = AdviceCall { settings: settings.clone(), inherits: reader::parent(args, machine), complete: &complete };
    Advice::of_files(programs, &call).map_err(|e| Failure::from(&SimError::from(e)))
}

/// Prints the words that the control has no meaning for, and what else keeps the program from being read.
pub(super) fn print_unknown(
    program: &Path,
    args: &ReaderArgs,
    machine: Option<&Machine>,
    settings: &Settings,
) -> Result<(), Failure> {
    let found = UnknownWords::of_file(program, settings).map_err(|e| Failure::from(&SimError::from(e)))?;
    let advice = advice_with(&[program.to_owned()], args, machine, settings)?;
    let rest = if advice.needs_nothing() { String::new() } else { format!("\n{advice}") };
    let written = write!(io::stdout().lock(), "{found}{rest}");
    written.map_err(|e| Failure::new(format!("standard output: {e}")))
}

/// Writes the control file with which the programs are read, and lists what it assumes; false where they
/// need none.
pub(super) fn write_control(advice: &Advice, file: &Path, force: bool, tell: &dyn Fn(String)) -> Result<bool, Failure> {
    const OWN_FAULT: &str = "no statement of a control file mends this";
    if advice.needs_nothing() {
        tell(format!("the program is read without a control file of its own: {} is not written", file.display()));
        return Ok(false);
    }
    if advice.statements.is_empty() {
        let failure = Failure::of_program(&advice.left, 0);
        return Err(failure.with_more_help(format!("{OWN_FAULT}: {} is not written", file.display())));
    }
    output_file::put_bytes(file, force, advice.control_file())?;
    for statement in &advice.statements {
        tell(format!(
            "assumed: {} = {} ({}), since {}",
            statement.key,
            statement.value,
            statement.place(),
            statement.why
        ));
    }
    let statements = if advice.statements.len() == 1 { "statement" } else { "statements" };
    tell(format!(
        "written: {}, {} {statements}; the gate `program` is unchecked until its table [assumed] is empty",
        file.display(),
        advice.statements.len()
    ));
    if advice.reads() { Ok(true) } else { Err(Failure::of_program(&advice.left, 0).with_more_help(OWN_FAULT)) }
}
