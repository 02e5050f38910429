use std::fs;

use proveout_machine::{Machine, import_linuxcnc_ini};
use proveout_sim::SimError;

use crate::args::MachineArgs;
use crate::failure::Failure;

/// Writes the folder of a machine from the configuration of a control, as a start.
pub(crate) fn machine(args: &MachineArgs) -> Result<(), Failure> {
    let told = |e| Failure::from(&SimError::from(e));
    let output = &args.output;
    let taken = || {
        Failure::new(format!("{} is there already", output.display())).with_help("name another folder with --output")
    };
    if output.symlink_metadata().is_ok() {
        return Err(taken());
    }
    if args.file.extension().is_none_or(|e| !e.eq_ignore_ascii_case("ini")) {
        return Err(Failure::new(format!("{} is no INI file of LinuxCNC", args.file.display()))
            .with_help("other descriptions of machines are not read: write machine.toml after machines/README.md"));
    }
    let made = import_linuxcnc_ini(&args.file, args.table_axes.as_deref().unwrap_or("")).map_err(told)?;
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let beside = output.with_file_name(format!(".{name}.part-{}", std::process::id()));
    let failed = |e: std::io::Error| {
        Failure::new(format!("{} cannot be written: {e}", output.display())).with_help("name another folder")
    };
    let put = || -> Result<Machine, Failure> {
        fs::create_dir_all(&beside).map_err(failed)?;
        fs::write(beside.join("machine.toml"), &made.text).map_err(failed)?;
        let machine = Machine::read(&beside).map_err(told)?;
        fs::rename(&beside, output).map_err(failed)?;
        Ok(machine)
    };
    let done = put();
    if done.is_err() {
        fs::remove_dir_all(&beside).ok();
    }
    let machine = done?;
    say!("{}: {}", machine.name, machine.in_one_line());
    for note in &made.notes {
        say!("note: {note}");
    }
    say!("written: {}; next: proveout check {0}", output.display());
    Ok(())
}
