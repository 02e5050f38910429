use std::path::Path;

use proveout_machine::Machine;
use proveout_nc::{Dialect, detect};
use proveout_sim::{
    Prepared, SimError,
    programs::{self, Rescheduling},
    scene::{MethodFile, Scene},
};
use proveout_tool::ToolLibrary;

use crate::{
    args::{PlanArgs, RescheduleArgs, StrategyArg},
    commands::output_file::{check, put_bytes},
    failure::Failure,
};

/// Writes a program for the blade of a scene.
pub(crate) fn plan(args: &PlanArgs) -> Result<(), Failure> {
    check(&args.output, args.force)?;
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
    put_bytes(&args.output, args.force, &text)
}

/// Writes a program of a scene with new tool axes.
pub(crate) fn reschedule(args: &RescheduleArgs) -> Result<(), Failure> {
    check(&args.output, args.force)?;
    let Some(&(_, method)) = MethodFile::NAMES.iter().find(|(name, _)| *name == args.method) else {
        let names: Vec<&str> = MethodFile::NAMES.iter().map(|(name, _)| *name).collect();
        return Err(Failure::new(format!("method {:?} is not known", args.method))
            .with_help(format!("methods: {}", names.join(", "))));
    };
    let failure = |e: SimError| Failure::from(&e);
    let scene = Scene::read(&args.scene).map_err(|e| failure(e.into()))?;
    let mut work = Rescheduling::of_scene(&scene, &args.program, method).map_err(|e| failure(e.into()))?;
    for option in &args.set {
        let wrong = |(message, help): (String, String)| Failure::new(format!("--set {message}")).with_help(help);
        let Some((key, value)) = option.split_once('=') else {
            return Err(wrong((format!("{option} is not KEY=VALUE"), "write for example --set keys=15".into())));
        };
        work.file.set(key.trim(), value.trim()).map_err(wrong)?;
    }
    let text = work.text(&scene, language(&args.output)).map_err(failure)?;
    put_bytes(&args.output, args.force, &text)?;
    tell!("{}: {} from {}, {}", args.output.display(), args.method, work.source.name, options(&work));
    Ok(())
}

/// The options that were taken, and where they come from.
fn options(work: &Rescheduling<'_>) -> String {
    let given: Vec<String> = work.file.given().into_iter().map(|(key, value)| format!("{key}={value}")).collect();
    let given = if given.is_empty() { "published and default options".to_owned() } else { given.join(", ") };
    match &work.entry.reschedule {
        Some(_) => format!("{given} (program {} of the scene)", work.entry.name),
        None => given,
    }
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
