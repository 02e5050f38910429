use std::path::Path;

use proveout_machine::Machine;
use proveout_nc::{Dialect, detect};
use proveout_sim::{
    Prepared, SimError, planning,
    programs::{self, Rescheduling},
    scene::{MethodFile, Scene, StrategyFile},
};
use proveout_tool::ToolLibrary;

use crate::{
    args::{PlanArgs, RescheduleArgs, StrategyArg},
    commands::output_file::{check, put_bytes},
    failure::Failure,
};

/// Writes a program for the blade of a scene, or compares its plans.
pub(crate) fn plan(args: &PlanArgs) -> Result<(), Failure> {
    for file in args.output.iter().chain(&args.report) {
        check(file, args.force)?;
    }
    let failure = |e: SimError| Failure::from(&e);
    let scene = Scene::read(&args.scene).map_err(|e| failure(e.into()))?;
    let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).map_err(|e| failure(e.into()))?;
    let machine = Machine::read(&scene.resolve(&scene.file.machine)).map_err(|e| failure(e.into()))?;
    let (Some(strategy), Some(output)) = (args.strategy, &args.output) else {
        return study(&scene, &machine, &tools);
    };
    let commands = match strategy_file(strategy) {
        None => {
            if args.report.is_some() {
                return Err(Failure::new("--report does not go with --strategy helix")
                    .with_help("compare `proveout run`, which tells what the program asks of the joints"));
            }
            programs::helix(&scene, &machine, &tools).map_err(failure)?
        }
        Some(strategy) => {
            let planned = planning::plan(&scene, &machine, &tools, strategy).map_err(failure)?;
            tell!("{}", planned.report.text().trim_end());
            if let Some(path) = &args.report {
                let json = serde_json::to_string_pretty(&planned.report);
                let json = json.map_err(|e| Failure::new(format!("the report cannot be written: {e}")))?;
                put_bytes(path, args.force, json)?;
            }
            planned.commands
        }
    };
    let settings = Prepared::reader_settings(&scene, None).map_err(|e| failure(e.into()))?;
    let text = programs::text(&commands, language(output), &settings).map_err(failure)?;
    put_bytes(output, args.force, &text)
}

fn strategy_file(strategy: StrategyArg) -> Option<StrategyFile> {
    match strategy {
        StrategyArg::Helix => None,
        StrategyArg::Transverse => Some(StrategyFile::Transverse),
        StrategyArg::IsoParametric => Some(StrategyFile::IsoParametric),
        StrategyArg::IsoPlanar => Some(StrategyFile::IsoPlanar),
        StrategyArg::Pocket => Some(StrategyFile::Pocket),
        StrategyArg::ConstantScallop => Some(StrategyFile::ConstantScallop),
        StrategyArg::QuasiCircle => Some(StrategyFile::QuasiCircle),
        StrategyArg::Row => Some(StrategyFile::Row),
        StrategyArg::PointRoughing => Some(StrategyFile::PointRoughing),
    }
}

/// All plans of a scene side by side.
fn study(scene: &Scene, machine: &Machine, tools: &ToolLibrary) -> Result<(), Failure> {
    let plans = scene.file.plan.as_ref();
    let given = StrategyFile::NAMES.into_iter().filter(|(_, s)| plans.is_some_and(|p| s.of(p).is_some()));
    let mut reports = Vec::new();
    for (_, strategy) in given {
        let planned = planning::plan(scene, machine, tools, strategy).map_err(|e| Failure::from(&e))?;
        reports.push(planned.report);
    }
    if reports.is_empty() {
        return Err(Failure::new(format!("{}: the scene has no plan by contacts to compare", scene.path.display()))
            .with_help("add tables such as [plan.quasi-circle] and [plan.iso-parametric]"));
    }
    tell!("{}", planning::PlanReport::table(&reports).trim_end());
    Ok(())
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
