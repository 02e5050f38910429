use std::path::{Path, PathBuf};

use proveout_record::{RerunMode, observers, write_run_json};
use proveout_sim::{
    Choice, Committed, Memory, Observer, Prepared, Recorded, RunFolder, SimError,
    digest::InputFile,
    journal::{Begun, Journal},
    overhang::{Overhang, STEP_MM, by_tool, least_of_assumed, least_overhangs},
    preflight::preflight,
    resolution_fault,
    run::{RunResult, run_journaled as prove},
    scene::{Dynamics, Plant},
    verdict::{Gate, Partial, State, Verdict},
};

use super::reports;
use crate::{
    args::{DynamicsArg, PlantArg, RerunArg, RunArgs},
    failure::Failure,
    front::{self, default_place},
    host::{LEAST_WALL_S, run_info},
    progress::Progress,
    stop::Stop,
};

/// Most worker threads: above the number of processors they only take memory.
const MAX_THREADS: usize = 512;
/// Where a viewer listens (its own default), and how long it may take to answer.
const VIEWER_PORT: u16 = 9876;
const VIEWER_ANSWERS: std::time::Duration = std::time::Duration::from_millis(500);
/// Hundredths of a whole.
const PERCENT: f64 = 1e2;

/// Runs a scene; the verdict, with what the call accepts. What keeps it from running is reported, too.
pub(crate) fn run(args: &RunArgs) -> Result<State, Failure> {
    reports::check(&args.reports)?;
    let result = run_scene(args);
    if let Err(failure) = &result {
        reports::of_failure(&args.reports, &args.scene, "scene", failure)?;
    }
    result
}

fn run_scene(args: &RunArgs) -> Result<State, Failure> {
    let (threads, pool) = pool(args.resolution_mm, args.threads)?;
    check_viewer(args.rerun)?;
    let stop = Stop::watch()?;
    let mut choice = Choice {
        program: args.program.clone(),
        nc: args.nc.clone(),
        resolution_mm: args.resolution_mm,
        dynamics: args.dynamics.map(dynamics),
        plant: args.plant.map(|p| match p {
            PlantArg::NewtonEuler => Plant::NewtonEuler,
            PlantArg::Rapier => Plant::Rapier,
        }),
        recorded: match args.rerun {
            RerunArg::Off => Recorded::Folder,
            _ => Recorded::Recording,
        },
        free_axes: args.orientation_maps.map_or(0, usize::from),
        preview: args.preview,
        stop_at: args.stop_at.clone(),
        set: args.set.clone(),
        ..Choice::default()
    };
    let overhangs = if args.find_stickout {
        let search = || least_overhangs(&args.scene, &choice, &mut |run| tell!("overhang: {run}"));
        pool.install(search).map_err(|e| Failure::from(&e))?
    } else {
        Vec::new()
    };
    choice.least_overhang_mm = by_tool(&overhangs);
    let read = || Prepared::read_announced(&args.scene, &choice, &mut announce);
    let mut prepared = pool.install(read).map_err(|e| Failure::from(&e))?;
    if !args.find_stickout {
        let search = || least_of_assumed(&args.scene, &choice, &prepared);
        choice.least_overhang_mm = by_tool(&pool.install(search).map_err(|e| Failure::from(&e))?);
        prepared.least_overhang_mm.clone_from(&choice.least_overhang_mm);
    }
    if let Some(note) = &prepared.control_note {
        tell!("note: {note}");
    }
    for line in
        super::check::causes(&pool.install(|| preflight(&prepared)).into_iter().filter(|c| !c.note).collect::<Vec<_>>())
    {
        tell!("{line}");
    }
    let place = args.output.clone().unwrap_or_else(|| default_place(&prepared, args.preview, args.stop_at.is_some()));
    if args.preview {
        tell!("preview with coarse cells: not a full check");
    }
    let folder = RunFolder::create(&place).map_err(|e| Failure::from(&SimError::Folder(e)))?;
    let (inputs, scene) = (prepared.inputs.clone(), prepared.scene.clone());
    let texts = reports::ProgramTexts::new(&prepared.shown);
    let journal = journal(args.resume, &folder, &Begun::of(&prepared, &choice))?;
    stop.running(folder.path());
    let mut watchers: Vec<Box<dyn Observer>> = vec![Box::new(Progress::new(&prepared.running_file()))];
    watchers.extend(observers(&recorder(args.rerun)).map_err(Failure::new)?);
    let result = pool.install(|| prove(prepared, Some(journal), &mut watchers, folder.path()));
    drop(watchers);
    let result = result.map_err(|e| {
        // A folder that goes away under a run that is stopped is no fault.
        stop.ending();
        failed(&e, &folder)
    })?;
    if let Some(why) = &result.journal_given_up {
        tell!("note: the journal was abandoned, so this run cannot be resumed if interrupted: {why}");
    }
    write_run_json(folder.path(), &run_info(&result, &scene.path, threads, true))
        .map_err(|e| Failure::new(format!("run.json: {e}")))?;
    let place = complete(folder, &inputs, &scene.folder, &mut || stop.ending())?;
    print_summary(&result, &place);
    reports::of_verdict(&args.reports, &result.verdict, texts)?;
    if let Some(stop_at) = args.stop_at.as_ref().filter(|_| !stopped(&result.verdict)) {
        say!("\n  --stop-at {stop_at}: not reached; the run went to the end of the program");
    }
    for line in &result.free_axes {
        say!("  free axes: {line}");
    }
    if args.find_stickout {
        print_overhangs(&overhangs);
    }
    Ok(accepted(&result.verdict, &args.accept_unchecked))
}

/// The journal of a new run, or of the one that was stopped.
fn journal(resume: bool, folder: &RunFolder, begun: &Begun) -> Result<Journal, Failure> {
    let path = folder.journal();
    let open = if resume { Journal::go_on } else { Journal::begin };
    let journal = open(&path, begun).map_err(|e| {
        let failure = Failure::from(&SimError::from(e));
        if resume { failure.with_help("omit --resume to start the run from the beginning") } else { failure }
    })?;
    if resume {
        tell!("resuming: {:.1} MiB of cuts are read from the journal", journal.left() as f64 / f64::from(1 << 20));
    }
    Ok(journal)
}

/// A failure, and what becomes of the journal: it stays where the system refused something, since nothing is
/// wrong with the run itself.
fn failed(error: &SimError, folder: &RunFolder) -> Failure {
    let failure = Failure::from(error);
    match error {
        SimError::Observer(_) | SimError::Folder(_) if folder.journal().is_file() => {
            failure.with_help("free disk space, then repeat the same command with --resume")
        }
        // The program that wrote it may go on with it.
        SimError::Journal(_) => failure,
        // A run that ends here would end here again.
        _ => {
            std::fs::remove_file(folder.journal()).ok();
            failure
        }
    }
}

/// Writes the manifest and moves a folder into its place; prints which older files stay there.
pub(super) fn complete(
    folder: RunFolder,
    inputs: &[InputFile],
    scene_folder: &Path,
    before_move: &mut dyn FnMut(),
) -> Result<PathBuf, Failure> {
    front::complete(folder, inputs, scene_folder, before_move).map(told_kept).map_err(|e| Failure::from(&e))
}

/// The place of a folder; prints which older files stay there.
pub(super) fn told_kept(Committed { place, kept }: Committed) -> PathBuf {
    for name in &kept {
        tell!("note: {} does not belong to a run and is kept", place.join(name).display());
    }
    place
}

fn stopped(verdict: &Verdict) -> bool {
    verdict.partial.as_ref().is_some_and(|p| p.stopped.is_some())
}

/// The verdict of a run. Unchecked gates that the call accepts count as passed, and are reported.
fn accepted(verdict: &Verdict, gates: &[Gate]) -> State {
    let unchecked: Vec<Gate> = verdict.gates.iter().filter(|g| g.state == State::Unchecked).map(|g| g.gate).collect();
    if verdict.verdict != State::Unchecked || unchecked.is_empty() {
        return verdict.verdict;
    }
    if unchecked.iter().all(|gate| gates.contains(gate)) {
        let unchecked: Vec<&str> = unchecked.into_iter().map(Gate::name).collect();
        say!("\n  unchecked, accepted by --accept-unchecked: {}", unchecked.join(", "));
        return State::Pass;
    }
    State::Unchecked
}

/// Refuses a call that wants a recording from a build that writes none, or a running viewer where none
/// answers, before the run takes its time.
pub(super) fn check_viewer(rerun: RerunArg) -> Result<(), Failure> {
    if cfg!(not(feature = "rerun")) && !matches!(rerun, RerunArg::Off) {
        return Err(Failure::new("--rerun: this build writes no recordings (feature `rerun` is off)")
            .with_help("build with the default features, or omit `--rerun`"));
    }
    let RerunArg::Connect = rerun else { return Ok(()) };
    let address = std::net::SocketAddr::from(([127, 0, 0, 1], VIEWER_PORT));
    std::net::TcpStream::connect_timeout(&address, VIEWER_ANSWERS).map(|_| ()).map_err(|e| {
        Failure::new(format!("--rerun connect: no viewer answers at {address}: {e}"))
            .with_help("start a viewer with `rerun` first, or use `--rerun spawn`")
    })
}

/// Prints how much memory the run will hold, before the stock is made.
fn announce(memory: &Memory) {
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let stocks: Vec<String> =
        memory.stocks.iter().map(|(name, bytes)| format!("{name} {:.1} MiB", mib(*bytes))).collect();
    let history = match memory.history {
        0 => String::new(),
        most => format!(", history up to {:.0} MiB", mib(most)),
    };
    tell!(
        "memory: {}, other data {:.1} MiB{history}; total {:.0} of {:.0} MiB allowed",
        stocks.join(", "),
        mib(memory.rest),
        mib(memory.total()),
        mib(memory.limit + memory.history)
    );
}

/// Checks the cell and starts the workers.
pub(super) fn pool(cell: Option<f64>, threads: Option<usize>) -> Result<(usize, rayon::ThreadPool), Failure> {
    if let Some(fault) = cell.and_then(resolution_fault) {
        return Err(Failure::new(format!("--resolution-mm: {fault}")).with_help("check the value and its unit, mm"));
    }
    let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    if threads == 0 {
        return Err(Failure::new("--threads 0: at least 1 is required"));
    }
    if threads > MAX_THREADS {
        return Err(Failure::new(format!("--threads {threads}: the maximum is {MAX_THREADS}"))
            .with_help("omit it: one thread per processor is fastest"));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Failure::new(format!("{threads} threads cannot be started: {e}")))?;
    Ok((threads, pool))
}

pub(super) fn dynamics(argument: DynamicsArg) -> Dynamics {
    match argument {
        DynamicsArg::Ideal => Dynamics::Ideal,
        DynamicsArg::Planned => Dynamics::Planned,
        DynamicsArg::Servo => Dynamics::Servo,
    }
}

pub(super) fn recorder(argument: RerunArg) -> RerunMode {
    match argument {
        RerunArg::Off => RerunMode::Off,
        RerunArg::File => RerunMode::File,
        RerunArg::Spawn => RerunMode::Spawn,
        RerunArg::Connect => RerunMode::Connect,
    }
}

pub(super) fn print_summary(result: &RunResult, place: &Path) {
    let v: &Verdict = &result.verdict;
    say!("\n{}: {}  (program {})\n", word(v.verdict).to_uppercase(), v.scene, v.program);
    if v.verdict == State::Pass && !v.not_asked().is_empty() {
        say!("  not asked: {}\n", v.not_asked().join(", "));
    }
    for line in v.partial.iter().flat_map(Partial::words) {
        say!("  {line}\n");
    }
    if !v.set.is_empty() {
        let set: Vec<String> = v.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        say!("  set on the command line: {}\n", set.join(", "));
    }
    for gate in &v.gates {
        say!("  {:<9} {:<10} {}", word(gate.state), gate.gate, gate.reason);
    }
    let errors: Vec<_> = v.findings.iter().filter(|f| f.severity == proveout_sim::finding::Severity::Error).collect();
    if !errors.is_empty() {
        say!("\n  first of {} findings:", errors.len());
        for f in errors.iter().take(8) {
            let line = f.line.map_or_else(String::new, |l| format!("line {l}: "));
            let more = if f.repeats > 0 { format!(" (and in {} more blocks)", f.repeats) } else { String::new() };
            say!("    {line}{}{more} [{}]", f.message, f.code);
        }
    }
    if !v.inspection.is_empty() {
        say!("\n  inspection");
        for i in &v.inspection {
            let measured = i.measured_mm.map_or_else(|| "no surface".into(), |m| format!("{m:.4}"));
            say!("    {:<44} nominal {:>9.4}  measured {measured:>9}  +-{} mm", i.name, i.nominal_mm, i.tolerance_mm);
        }
    }
    if let (Some(gouge), Some(excess), Some(rms)) =
        (v.deviation.gouge_max_mm, v.deviation.excess_max_mm, v.deviation.rms_mm)
    {
        say!("\n  deviation  gouge {gouge:.5} mm, excess {excess:.5} mm, rms {rms:.5} mm");
    }
    say!(
        "\n  machine time {:.1} s (feed {:.1}, rapid {:.1}, dwell {:.1}, tool change {:.1}); lower bound {} \
         within the tolerances, {} on the path as run",
        v.time.total_s,
        v.time.cutting_s,
        v.time.rapid_s,
        v.time.dwell_s,
        v.time.tool_change_s,
        bound(v.time.lower_bound_s),
        bound(v.time.path_bound_s)
    );
    for t in &v.tools {
        say!(
            "    T{:<3} {:<24} {:>8.1} s in the spindle, {:>8.1} s in feed, {:>9.1} mm3",
            t.number,
            t.name,
            t.time_s,
            t.cut_time_s,
            t.volume_mm3
        );
    }
    say!(
        "\n  computed in {:.1} s: {:.0} times faster than the machine, {} pieces of motion",
        result.wall,
        v.time.total_s / result.wall.max(LEAST_WALL_S),
        result.pieces
    );
    let bodies = &result.checks.bodies;
    say!(
        "  collision: {:.2} % of {} pieces settled by one comparison, {:.2} % of {} pairs in the others; {} distances computed, {} to the stock",
        PERCENT * bodies.share_by_allowance(),
        bodies.pieces,
        PERCENT * bodies.share_of_pairs_by_allowance(),
        bodies.pair_checks,
        bodies.misses + bodies.distances,
        result.checks.stock_queries
    );
    say!("  results: {}", place.display());
    let recording = if place.join(proveout_record::RECORDING_FILE).exists() {
        format!("; `proveout view {}` for the recording", place.display())
    } else {
        String::new()
    };
    say!("           {} in a browser{recording}", place.join("report.html").display());
}

fn print_overhangs(found: &[Overhang]) {
    say!("\n  overhang: shortest collision-free value, in steps of {STEP_MM} mm; each was simulated");
    for o in found {
        let now = o.now_mm;
        match (o.least_mm, &o.too_short) {
            (Some(least), Some((short, fault))) => {
                let change = least - now;
                let words = if change > 0.0 { "too short by" } else { "longer than needed by" };
                let change = change.abs();
                say!(
                    "    {:<24} {least:>8.1} mm; clamped {now:.1} mm, {words} {change:.1} mm; at {short:.1} mm: {fault}",
                    o.tool
                );
            }
            (Some(least), None) => {
                say!(
                    "    {:<24} {least:>8.1} mm; clamped {now:.1} mm; the shortest overhang that the holder can grip is collision-free",
                    o.tool
                );
            }
            (None, Some((short, fault))) => {
                say!("    {:<24} none up to {short:.1} mm is collision-free: {fault}", o.tool);
            }
            (None, None) => {}
        }
    }
    if found.is_empty() {
        say!("    no tool of the program has a holder that grips a cylindrical shank");
    }
}

fn bound(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "unchecked".into(), |b| format!("{b:.1} s"))
}

pub(super) fn word(state: State) -> &'static str {
    state.word()
}
