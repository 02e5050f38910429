use std::fs;

use proveout_machine::{ImportedMachine, Machine, UrdfOptions, import_linuxcnc_ini, import_urdf};
use proveout_sim::SimError;

use crate::args::MachineArgs;
use crate::failure::Failure;

/// Reads the file by its ending; an option of the other kind of file is refused.
fn import(args: &MachineArgs) -> Result<ImportedMachine, Failure> {
    let told = |e| Failure::from(&SimError::from(e));
    let of_urdf = [
        ("--tool-link", &args.tool_link),
        ("--table-link", &args.table_link),
        ("--axis-names", &args.axis_names),
        ("--reverse", &args.reverse),
        ("--tool-direction", &args.tool_direction),
        ("--table-normal", &args.table_normal),
    ];
    let idle = |option: &str, of: &str| {
        Failure::new(format!("{option} does not apply to {}", args.file.display()))
            .with_help(format!("omit it; it is for {of} only"))
    };
    let ending = args.file.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("ini") => match of_urdf.iter().find(|(_, value)| value.is_some()) {
            Some((option, _)) => Err(idle(option, "URDF files")),
            None => import_linuxcnc_ini(&args.file, args.table_axes.as_deref().unwrap_or("")).map_err(told),
        },
        Some("urdf" | "xml") if args.table_axes.is_some() => Err(idle("--table-axes", "LinuxCNC INI files")
            .with_more_help("for URDF, name the link of the table with --table-link")),
        Some("urdf" | "xml") => {
            let options = UrdfOptions {
                tool_link: args.tool_link.clone(),
                table_link: args.table_link.clone(),
                axis_names: args.axis_names.clone(),
                reverse: args.reverse.clone(),
                tool_direction: args.tool_direction.clone(),
                table_normal: args.table_normal.clone(),
            };
            import_urdf(&args.file, &options).map_err(told)
        }
        Some("xacro") => Err(Failure::new(format!("{} is a xacro file", args.file.display()))
            .with_help("expand it with `xacro` to a .urdf file and name that file")),
        _ => Err(Failure::new(format!("{} is neither a LinuxCNC INI file nor a URDF file", args.file.display()))
            .with_help("other formats are not supported: write machine.toml as described in machines/README.md")),
    }
}

/// Writes the folder of a machine from the configuration of a control or a description of its links, as a
/// start.
pub(crate) fn machine(args: &MachineArgs) -> Result<(), Failure> {
    let told = |e| Failure::from(&SimError::from(e));
    let output = &args.output;
    let taken =
        || Failure::new(format!("{} already exists", output.display())).with_help("name another folder with --output");
    if output.symlink_metadata().is_ok() {
        return Err(taken());
    }
    let made = import(args)?;
    let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let beside = output.with_file_name(format!(".{name}.part-{}", std::process::id()));
    let failed = |e: std::io::Error| {
        Failure::new(format!("{} cannot be written: {e}", output.display())).with_help("name another folder")
    };
    let put = || -> Result<Machine, Failure> {
        fs::create_dir_all(&beside).map_err(failed)?;
        fs::write(beside.join("machine.toml"), &made.text).map_err(failed)?;
        if let Some(model) = &made.model {
            fs::write(beside.join("model.glb"), model).map_err(failed)?;
        }
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
