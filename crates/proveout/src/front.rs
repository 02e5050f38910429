//! What front ends other than the command line call: the glue between the parts of the twin, without words on
//! a terminal.
//!
//! The commands themselves use it, so that a run of another front end leaves the same files.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use proveout_machine::Machine;
use proveout_nc::{Command, Compensation, Dialect, Program};
use proveout_record::{
    RerunMode,
    compare::{Trace, TraceObserver, write_comparison},
    observers, write_run_json,
};
use proveout_sim::{
    Committed, Manifest, Observer, Prepared, RunFolder, SimError, SurfaceMap,
    compare::{CompareChoice, Compared, Comparing},
    digest::InputFile,
    planning::{self, PlanReport},
    programs::{self, Remade, Rescheduling},
    run::{RunResult, run, run_with_surface},
    scene::{HELIX, MethodFile, Scene, StrategyFile},
    tool_radii,
};
use proveout_tool::ToolLibrary;

use crate::{args::ReaderArgs, commands::reader, failure::Failure, host::run_info};

/// What an error is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaultKind {
    /// The call, or a file: scene, machine, tools, meshes.
    #[default]
    Input,
    /// The text of an NC program.
    Program,
    /// A program that the control cannot execute.
    Control,
    /// A folder or file that cannot be written.
    Folder,
}

/// An error for people; its text is what the command line prints.
#[derive(Debug)]
pub struct CommandError(pub(crate) Failure);

impl CommandError {
    /// A call that is wrong.
    pub fn new(message: impl std::fmt::Display, remedy: &str) -> Self {
        Self(Failure::new(message).with_help(remedy))
    }

    /// What it is about.
    pub fn kind(&self) -> FaultKind {
        self.0.kind()
    }

    /// What is wrong, in one sentence.
    pub fn message(&self) -> &str {
        self.0.message()
    }

    /// File, line and column from 1, where it lies in a file; zero where only the file, or only the line, is
    /// known.
    pub fn place(&self) -> Option<(&str, usize, usize)> {
        self.0.place()
    }

    /// What to do about it; empty where there is nothing to say.
    pub fn remedy(&self) -> &str {
        self.0.help()
    }
}

impl std::fmt::Display for CommandError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl From<SimError> for CommandError {
    fn from(error: SimError) -> Self {
        Self(Failure::from(&error))
    }
}

impl From<Failure> for CommandError {
    fn from(failure: Failure) -> Self {
        Self(failure)
    }
}

impl From<CommandError> for Failure {
    fn from(fault: CommandError) -> Self {
        fault.0
    }
}

/// Default folder of a run: `out/SCENE-PROGRAM`, followed by what makes it less than a complete check.
pub fn default_place(prepared: &Prepared, preview: bool, stopped: bool) -> PathBuf {
    let kind = match (preview, stopped) {
        (true, _) => "-preview",
        (false, true) => "-stopped",
        (false, false) => "",
    };
    PathBuf::from("out").join(format!("{}-{}{kind}", prepared.scene.file.name, prepared.program_name))
}

/// Runs a prepared program and moves its complete folder to `place`. `watchers` see the run, as do the
/// observers that write it.
///
/// # Errors
/// [`SimError`] of the run, or of a watcher that ends it: nothing is then left at `place` that was not there
/// before.
pub fn prove_out(
    prepared: Prepared,
    place: &Path,
    threads: usize,
    rerun: &RerunMode,
    mut watchers: Vec<Box<dyn Observer>>,
) -> Result<(RunResult, Committed), CommandError> {
    let folder = RunFolder::create(place).map_err(SimError::Folder)?;
    let (inputs, scene) = (prepared.inputs.clone(), prepared.scene.clone());
    watchers.extend(observers(rerun).map_err(Failure::new)?);
    let result = run(prepared, &mut watchers, folder.path())?;
    drop(watchers);
    write_run_json(folder.path(), &run_info(&result, &scene.path, threads, false)).map_err(run_json)?;
    let committed = complete(folder, &inputs, &scene.folder, &mut || ())?;
    Ok((result, committed))
}

fn run_json(error: impl std::fmt::Display) -> Failure {
    Failure::new(format!("run.json: {error}"))
}

/// Writes the manifest and moves a folder into its place; `before_move` hears when the run is complete.
///
/// # Errors
/// [`SimError::Folder`] when the system refuses.
pub fn complete(
    folder: RunFolder,
    inputs: &[InputFile],
    scene_folder: &Path,
    before_move: &mut dyn FnMut(),
) -> Result<Committed, SimError> {
    Manifest::of(folder.path(), inputs, scene_folder).and_then(|m| m.write(folder.path())).map_err(SimError::Folder)?;
    before_move();
    folder.commit().map_err(SimError::Folder)
}

/// What a comparison is made with.
#[derive(Clone, Debug)]
pub struct CompareOrder<'a> {
    /// Folder of the scene, or its file.
    pub scene: &'a Path,
    /// What the call chooses.
    pub choice: &'a CompareChoice,
    /// Folder of the comparison; `out/SCENE-compare` where the call names none.
    pub place: Option<&'a Path>,
    /// Worker threads, for `run.json`.
    pub threads: usize,
    /// Recordings of the runs.
    pub rerun: &'a RerunMode,
}

/// Runs and compares the programs of a scene in the current thread pool. `told` receives the number of
/// motions done and their total; `watchers` returns the observers of a run.
///
/// # Errors
/// [`CommandError`] of the scene, of a run, or of a watcher that ends it: no folder is then left that was not
/// there before.
pub fn compare(
    order: &CompareOrder<'_>,
    told: &(dyn Fn(usize, usize) + Sync),
    watchers: &mut dyn FnMut(&Prepared) -> Vec<Box<dyn Observer>>,
) -> Result<(Compared, Committed), CommandError> {
    let mut comparing = Comparing::read(order.scene, order.choice)?;
    let place =
        order.place.map_or_else(|| PathBuf::from("out").join(format!("{}-compare", comparing.scene())), Path::to_owned);
    let folder = RunFolder::create(&place).map_err(SimError::Folder)?;
    comparing.vary(told)?;
    let (mut inputs, mut scene_folder) = (Vec::new(), PathBuf::new());
    let mut traces: Vec<(String, Arc<Mutex<Trace>>)> = Vec::new();
    let order_of_runs = comparing.order();
    // Two programs at once: much of a run waits for itself.
    for names in order_of_runs.chunks(2) {
        let mut waiting = Vec::new();
        for name in names {
            let Some(prepared) = comparing.take(name) else { continue };
            inputs.extend(prepared.inputs.iter().cloned());
            scene_folder.clone_from(&prepared.scene.folder);
            if comparing.motion_only() {
                continue;
            }
            let place = folder.path().join(comparing.folder(name));
            fs::create_dir_all(&place).map_err(SimError::Folder)?;
            let mut all = watchers(&prepared);
            all.extend(observers(order.rerun).map_err(Failure::new)?);
            if let Some(windows) = comparing.windows(name) {
                let (observer, trace) = TraceObserver::new(windows);
                all.push(Box::new(observer));
                traces.push((name.clone(), trace));
            }
            waiting.push(PendingRun { name: name.clone(), prepared, observers: all, place });
        }
        let run = |one: PendingRun| one.run(order.threads);
        let mut waiting = waiting.into_iter();
        let done = match [waiting.next(), waiting.next()] {
            [Some(first), Some(second)] if fit_together(&first.prepared, &second.prepared) => {
                let (first, second) = rayon::join(|| run(first), || run(second));
                vec![first?, second?]
            }
            others => others.into_iter().flatten().map(run).collect::<Result<_, _>>()?,
        };
        for (name, result, surface) in done {
            comparing.add(&name, result, &surface);
        }
    }
    let Some(compared) = comparing.finish() else {
        return Err(Failure::new("internal error: a program of the comparison was not run").into());
    };
    let trace = |name: &String| {
        let found = traces.iter().find(|(n, _)| n == name);
        found.map_or_else(Trace::default, |(_, t)| t.lock().unwrap_or_else(PoisonError::into_inner).clone())
    };
    let traces: Vec<Trace> = compared.comparison.order.iter().map(trace).collect();
    write_comparison(folder.path(), &compared, &traces).map_err(Failure::new)?;
    let committed = complete(folder, &inputs, &scene_folder, &mut || ())?;
    Ok((compared, committed))
}

/// A program of a comparison that is ready to be run.
struct PendingRun {
    name: String,
    prepared: Prepared,
    observers: Vec<Box<dyn Observer>>,
    place: PathBuf,
}

impl PendingRun {
    fn run(self, threads: usize) -> Result<(String, RunResult, SurfaceMap), CommandError> {
        let scene = self.prepared.scene.path.clone();
        let (result, surface) = run_with_surface(self.prepared, self.observers, &self.place)?;
        write_run_json(&self.place, &run_info(&result, &scene, threads, false)).map_err(run_json)?;
        Ok((self.name, result, surface))
    }
}

/// Whether two runs are within the memory that is allowed for one.
fn fit_together(first: &Prepared, second: &Prepared) -> bool {
    let [first, second] = [&first.memory, &second.memory];
    first.total().saturating_add(second.total()) <= first.limit.min(second.limit)
}

/// The text of a program for the blade of a scene, and what it asks of the machine; a helix comes without
/// that report.
///
/// # Errors
/// [`CommandError`] of scene, machine and tools, an unknown strategy, or what keeps the path from being
/// planned.
pub fn plan(
    scene: &Path,
    strategy: &str,
    program: Option<&str>,
    dialect: Dialect,
) -> Result<(String, Option<PlanReport>), CommandError> {
    let scene = Scene::read(scene).map_err(SimError::from)?;
    let scene = match program {
        None => scene,
        Some(name) => match scene.program(Some(name)) {
            Some(program) if program.planned.as_deref() == Some(strategy) => scene.planned_for(program).into_owned(),
            _ => {
                return Err(Failure::new(format!("program {name:?} of the scene is not planned by {strategy}"))
                    .with_help(format!("name a [[program]] with `planned = {strategy:?}`, or omit --program"))
                    .into());
            }
        },
    };
    let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).map_err(SimError::from)?;
    let machine = Machine::read(&scene.resolve(&scene.file.machine)).map_err(SimError::from)?;
    let (commands, report) = if strategy == HELIX.0 {
        (programs::helix(&scene, &machine, &tools)?, None)
    } else {
        let Some(named) = StrategyFile::named(strategy) else {
            let names = StrategyFile::ALL.map(|(_, name, _)| name).join(", ");
            return Err(Failure::new(format!("unknown strategy {strategy:?}"))
                .with_help(format!("strategies: {}, {names}", HELIX.0))
                .into());
        };
        let planned = planning::plan(&scene, &machine, &tools, named)?;
        (planned.commands, Some(planned.report))
    };
    let settings = Prepared::reader_settings(&scene, None).map_err(SimError::from)?;
    Ok((programs::text(&commands, dialect, &settings)?, report))
}

/// A program with new tool axes.
#[derive(Clone, Debug)]
pub struct RescheduledProgram {
    /// Text, times and bounds.
    pub made: Remade,
    /// Name of the program that it was made from.
    pub source: String,
    /// Options that were given, by scene or call.
    pub options: Vec<(&'static str, String)>,
    /// Program of the scene whose options were taken, where there is one.
    pub entry: Option<String>,
}

/// A program of a scene with new tool axes. `word` is what the call names its options by, for error texts.
///
/// # Errors
/// [`CommandError`] of the call, of the scene, or of the method.
pub fn reschedule(
    scene: &Path,
    program: &str,
    method: &str,
    options: &[(&str, &str)],
    word: &str,
    dialect: Dialect,
) -> Result<RescheduledProgram, CommandError> {
    let Some(&(_, known)) = MethodFile::NAMES.iter().find(|(name, _)| *name == method) else {
        let names: Vec<&str> = MethodFile::NAMES.iter().map(|(name, _)| *name).collect();
        return Err(Failure::new(format!("unknown method {method:?}"))
            .with_help(format!("methods: {}", names.join(", ")))
            .into());
    };
    let scene = Scene::read(scene).map_err(SimError::from)?;
    let mut work = Rescheduling::of_scene(&scene, program, known).map_err(SimError::from)?;
    for (key, value) in options {
        work.file
            .set(key, value)
            .map_err(|(message, help)| Failure::new(format!("{word} {message}")).with_help(help))?;
    }
    if let Some(key) = work.file.unread() {
        let message = format!("{word}: method {method} does not use {key} with its other options");
        let help = format!("options it uses: {}", work.file.read().join(", "));
        return Err(Failure::new(message).with_help(help).into());
    }
    let made = work.remade(&scene, dialect)?;
    Ok(RescheduledProgram {
        made,
        source: work.source.name.clone(),
        options: work.file.given(),
        entry: work.entry.reschedule.as_ref().map(|_| work.entry.name.clone()),
    })
}

/// How a program is read; what is left out is as the control says.
#[derive(Clone, Debug, Default)]
pub struct ReaderOptions {
    /// Machine whose control, axes and reference points count.
    pub machine: Option<PathBuf>,
    /// Tool library whose radii cutter compensation takes: the commands then move the tool center.
    pub tools: Option<PathBuf>,
    /// Dialect by its name.
    pub dialect: Option<String>,
    /// Built-in control, or a control file.
    pub control: Option<String>,
    /// `NAME=VALUE`.
    pub variables: Vec<String>,
    /// `G54=X,Y,Z[,A,B,C]`, mm and degrees.
    pub offsets: Vec<String>,
    /// Feed before the first F, mm/min.
    pub feed_mm_min: Option<f64>,
    /// Folders of subprograms.
    pub subprograms: Vec<PathBuf>,
}

/// Hands every canonical command of a program to `each`, until the end or the first fault.
///
/// # Errors
/// [`CommandError`] of the call or of the program.
pub fn canonical(program: &Path, how: &ReaderOptions, each: &mut dyn FnMut(&Command)) -> Result<(), CommandError> {
    let machine = how.machine.as_deref().map(Machine::read).transpose().map_err(SimError::from)?;
    let tools = how.tools.as_deref().map(ToolLibrary::read).transpose().map_err(SimError::from)?;
    let args = ReaderArgs {
        dialect: how.dialect.clone(),
        control: how.control.clone(),
        variable: how.variables.clone(),
        offset: how.offsets.clone(),
        start: None,
        feed: how.feed_mm_min,
        subprograms: how.subprograms.clone(),
        without_subprograms: None,
        arc_tolerance: None,
    };
    let mut settings = reader::settings(&args, machine.as_ref(), program)?;
    settings.compensation =
        tools.as_ref().map_or(Compensation::Programmed, |t| Compensation::ToolCenter(tool_radii(t)));
    for command in Program::open(program, &settings).map_err(SimError::from)? {
        each(&command.map_err(SimError::from)?);
    }
    Ok(())
}

/// A dialect by its name; that of the Siemens 840D where none is given.
///
/// # Errors
/// [`CommandError`] with the names that there are.
pub fn dialect(name: Option<&str>) -> Result<Dialect, CommandError> {
    Ok(name.map_or(Ok(Dialect::Siemens840d), reader::dialect_of)?)
}
