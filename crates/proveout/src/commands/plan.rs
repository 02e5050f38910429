use std::path::Path;

use proveout_machine::Machine;
use proveout_nc::{Dialect, detect};
use proveout_sim::{
    Prepared, SimError, programs,
    scene::{MethodFile, RescheduleFile, Scene},
};
use proveout_tool::ToolLibrary;

use crate::{
    args::{PlanArgs, RescheduleArgs, StrategyArg},
    failure::Failure,
};

/// Writes a program for the blade of a scene.
pub(crate) fn plan(args: &PlanArgs) -> Result<(), Failure> {
    let work = || -> Result<String, SimError> {
        let scene = Scene::read(&args.scene)?;
        let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools))?;
        let commands = match args.strategy {
            StrategyArg::Helix => {
                let machine = Machine::read(&scene.resolve(&scene.file.machine))?;
                programs::helix(&scene, &machine, &tools)?
            }
        };
        let settings = Prepared::reader_settings(&scene, None)?;
        programs::text(&commands, language(&args.output), &settings)
    };
    let text = work().map_err(|e| Failure::from(&e))?;
    write(&args.output, &text)
}

/// Writes a program of a scene with new tool axes.
pub(crate) fn reschedule(args: &RescheduleArgs) -> Result<(), Failure> {
    let Some(&(_, method)) = MethodFile::NAMES.iter().find(|(name, _)| *name == args.method) else {
        let names: Vec<&str> = MethodFile::NAMES.iter().map(|(name, _)| *name).collect();
        return Err(Failure::new(format!("method {:?} is not known", args.method))
            .with_help(format!("methods: {}", names.join(", "))));
    };
    let scene = Scene::read(&args.scene).map_err(|e| Failure::from(&SimError::from(e)))?;
    let Some(entry) = scene.program(Some(&args.program)) else {
        let names: Vec<&str> = scene.file.program.iter().map(|p| p.name.as_str()).collect();
        return Err(Failure::new(format!("there is no program {:?}", args.program))
            .with_help(format!("programs of the scene: {}", names.join(", "))));
    };
    let Some(file) = &entry.file else {
        return Err(Failure::new(format!("program {:?} has no text of its own", args.program))
            .with_help("name a program with a file"));
    };
    let work = || -> Result<String, SimError> {
        let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools))?;
        let machine = Machine::read(&scene.resolve(entry.machine.as_ref().unwrap_or(&scene.file.machine)))?;
        let settings = Prepared::reader_settings(&scene, Some(entry))?;
        let reschedule = RescheduleFile::plain(method, &args.program);
        let part = Prepared::part_on_table(&scene, Some(entry))?;
        let made = programs::rescheduled(&reschedule, &scene.resolve(file), &settings, &machine, &tools, &part)?;
        programs::text(&made.commands, language(&args.output), &settings)
    };
    let text = work().map_err(|e| Failure::from(&e))?;
    write(&args.output, &text)
}

/// The language of an output file; an 840D text where the ending does not tell.
fn language(path: &Path) -> Dialect {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match (detect(&path.display().to_string(), ""), ending.as_deref()) {
        (Dialect::Auto, Some("nc" | "iso" | "tap" | "gcode")) => Dialect::Iso,
        (Dialect::Auto, _) => Dialect::Siemens840d,
        (dialect, _) => dialect,
    }
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let fail = |e: std::io::Error| {
        Failure::new(format!("{} cannot be written: {e}", path.display())).with_help("name another file")
    };
    let beside = path.with_extension("part");
    std::fs::write(&beside, text).map_err(fail)?;
    std::fs::rename(&beside, path).map_err(fail)
}
