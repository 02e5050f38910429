//! `proveout sweep plan|run|merge`: no engine of its own; anything that can start a program runs its jobs.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use proveout_record::{JsonObserver, RerunMode, merge_sweep, observers, write_run_json};
use proveout_sim::{
    Observer, RunFolder, SimError, digest,
    run::{run as prove, run_merged},
    shards::{ShardCuts, cut_shard},
    sweep::{
        JobResult, JobState, KeepFile, Plan, Planned, RESULT, Recheck, ResultFault, Sweep, check_shard, check_verdict,
        job_folder, plan as write_plan, prepare_job, read_result, result_of, result_of_shard, write_result,
    },
    verdict::State,
};

use crate::{
    args::{SweepCommand, SweepMergeArgs, SweepPlanArgs, SweepRunArgs},
    commands::run::{complete, pool, print_summary},
    failure::Failure,
    host::{cpu_time, peak_mib, run_info},
    progress::Progress,
};

/// Largest number of job faults printed at the end.
const TOLD: usize = 10;
/// Folder of a whole run, in that of its job; of a run in shards, in that of the sweep.
const RUN: &str = "run";
/// What a shard has cut, in the folder of its job.
const CUTS: &str = "cuts.bin";
/// Wall time between two lines of a shard, s.
const TELL_EVERY_S: f64 = 10.0;

/// The verdict is that of a run that was brought together from its shards; all else passes.
pub(crate) fn sweep(command: &SweepCommand) -> Result<State, Failure> {
    match command {
        SweepCommand::Plan(args) => plan(args).map(|()| State::Pass),
        SweepCommand::Run(args) => run(args).map(|()| State::Pass),
        SweepCommand::Merge(args) => merge(args),
    }
}

fn of(e: SimError) -> Failure {
    Failure::from(&e)
}

fn plan(args: &SweepPlanArgs) -> Result<(), Failure> {
    let begin = Instant::now();
    let sweep = Sweep::read(&args.sweep).map_err(|e| of(e.into()))?;
    let out = args.output.clone().unwrap_or_else(|| PathBuf::from("out").join(format!("{}-sweep", sweep.file.name)));
    let report = write_plan(&sweep, &out).map_err(of)?;
    say!("{} jobs planned in {:.2} s", report.jobs, begin.elapsed().as_secs_f64());
    if let Some(motion) = &report.motion {
        say!("  one run split into shards: {} pieces of motion, {} tiles of stock", motion.pieces, motion.tiles);
        let [most, least] = motion.loads;
        say!("  sweeps per shard: {least} to {most}");
    }
    if report.as_before > 0 {
        say!("  {} unchanged since the last plan: their results are kept", report.as_before);
    }
    if report.left_over > 0 {
        say!("  {} job folders of an earlier plan are kept, but are not part of this one", report.left_over);
    }
    say!("  run:   proveout sweep run {}", out.display());
    say!("  merge: proveout sweep merge {}", out.display());
    Ok(())
}

/// The jobs that a call asks for, in order.
fn chosen(args: &SweepRunArgs, plan: &Plan) -> Result<Vec<usize>, Failure> {
    let jobs = plan.jobs.len();
    if let Some(range) = args.job.iter().find(|range| range.last >= jobs) {
        let message = format!("--job {}: the plan has the jobs 0 to {}", range.last, jobs.saturating_sub(1));
        return Err(Failure::new(message).with_help("name jobs of this plan"));
    }
    let all: BTreeSet<usize> = if args.job.is_empty() {
        (0..jobs).collect()
    } else {
        args.job.iter().flat_map(|range| range.first..=range.last).collect()
    };
    Ok(match args.part {
        None => all.into_iter().collect(),
        Some(part) => all.into_iter().filter(|job| job % part.of == part.number - 1).collect(),
    })
}

/// Runs jobs that have no result yet; an error names those that could not be run, the others have their
/// results.
fn run(args: &SweepRunArgs) -> Result<(), Failure> {
    let begin = Instant::now();
    let (threads, pool) = pool(None, args.threads)?;
    let plan = Plan::read(&args.sweep).map_err(|e| of(e.into()))?;
    let jobs = chosen(args, &plan)?;
    let (mut done, mut started, mut stale, mut faults) = (0, 0, 0, Vec::new());
    let mut recheck = Recheck::new(&args.sweep, &plan);
    let sound =
        |job| read_result(&args.sweep, &plan, job).and_then(|result| check_verdict(&args.sweep, &plan, &result));
    for (at, job) in jobs.iter().enumerate() {
        match sound(*job) {
            Ok(()) => {
                // A result is that of the inputs it was made of.
                match recheck.job(*job) {
                    Ok(()) => done += 1,
                    Err(changed) => {
                        stale += 1;
                        faults.push((*job, of(changed.into())));
                    }
                }
                continue;
            }
            Err(ResultFault::Damaged { message, path, .. }) => {
                tell!("note: job {job} is run again because its result is damaged: {message} ({})", path.display());
            }
            Err(ResultFault::Missing(_) | ResultFault::Other(_)) => {}
        }
        started += 1;
        match pool.install(|| run_job(&args.sweep, &plan, *job, threads)) {
            Ok(result) => tell!("job {job} ({} of {}): {}", at + 1, jobs.len(), told(&result)),
            Err(fault) => {
                tell!("job {job} ({} of {}): NOT RUN", at + 1, jobs.len());
                faults.push((*job, fault));
            }
        }
    }
    say!("{} jobs: {done} had their result, {started} started, {:.1} s", jobs.len(), begin.elapsed().as_secs_f64());
    if faults.is_empty() {
        return Ok(());
    }
    for (job, fault) in faults.iter().take(TOLD) {
        tell!("job {job}: {}", fault.to_string().trim_end());
    }
    let message = match stale {
        0 => format!("{} of {} jobs have no result", faults.len(), jobs.len()),
        _ => format!(
            "{} of {} jobs have no valid result; the inputs of {stale} of them have changed since their run",
            faults.len(),
            jobs.len()
        ),
    };
    let help = match stale {
        0 => "fix the cause, then repeat the same command: jobs that have a result are not run again",
        _ => "restore the changed inputs, or plan the sweep again: proveout sweep plan",
    };
    Err(Failure::new(message).with_help(help))
}

fn told(result: &JobResult) -> String {
    let time = result.figures.get("time_s").copied().flatten().map_or_else(String::new, |t| format!(", {t:.1} s"));
    if result.refused.is_empty() {
        format!("{}{time}", result.state.word())
    } else {
        format!("refused: {}", result.refused)
    }
}

/// Runs one job and writes its result, last of all.
fn run_job(sweep: &Path, plan: &Plan, job: usize, threads: usize) -> Result<JobResult, Failure> {
    let folder_fault = |e: std::io::Error| of(SimError::Folder(e));
    let planned = Planned::read(sweep, plan, job).map_err(|e| of(e.into()))?;
    if planned.shard.is_some() {
        check_shard(sweep, &planned).map_err(|e| of(e.into()))?;
        return cut(sweep, &planned);
    }
    let prepared = match prepare_job(sweep, &planned).map_err(|e| of(e.into()))? {
        Ok(prepared) => prepared,
        // What the values make of the scene is a result like any other.
        Err(refused) => {
            let result = result_of(&planned, Err(refused.to_string()));
            write_result(sweep, &result).map_err(folder_fault)?;
            return Ok(result);
        }
    };
    let (inputs, scene) = (prepared.inputs.clone(), prepared.scene.clone());
    let at = job_folder(sweep, job);
    let folder = RunFolder::create(&at.join(RUN)).map_err(folder_fault)?;
    let mut watchers: Vec<Box<dyn Observer>> = vec![Box::new(Progress::new(&prepared.running_file()))];
    match plan.keep {
        KeepFile::Verdict => watchers.push(Box::new(JsonObserver)),
        KeepFile::Folder => watchers.extend(observers(&RerunMode::Off).map_err(Failure::new)?),
    }
    let run = match prove(prepared, &mut watchers, folder.path()) {
        Ok(run) => run,
        Err(fault @ (SimError::Observer(_) | SimError::Folder(_))) => return Err(of(fault)),
        Err(refused) => {
            let result = result_of(&planned, Err(refused.to_string()));
            write_result(sweep, &result).map_err(folder_fault)?;
            return Ok(result);
        }
    };
    drop(watchers);
    let bytes = fs::read(folder.path().join("verdict.json")).map_err(folder_fault)?;
    if plan.keep == KeepFile::Folder {
        write_run_json(folder.path(), &run_info(&run, &scene.path, threads, false))
            .map_err(|e| Failure::new(format!("run.json: {e}")))?;
        complete(folder, &inputs, &scene.folder, &mut || ())?;
    } else {
        let to = at.join("verdict.json");
        fs::copy(folder.path().join("verdict.json"), &to).map_err(folder_fault)?;
        drop(folder);
    }
    let result = result_of(&planned, Ok((&run.verdict, &bytes)));
    write_result(sweep, &result).map_err(folder_fault)?;
    Ok(result)
}

/// Cuts a shard, and writes its result, last of all.
fn cut(sweep: &Path, planned: &Planned) -> Result<JobResult, Failure> {
    let folder_fault = |e: std::io::Error| of(SimError::Folder(e));
    let at = job_folder(sweep, planned.job);
    let (to, beside) = (at.join(CUTS), at.join(format!(".{CUTS}.{}", std::process::id())));
    let (begin, mut told) = (Instant::now(), Instant::now());
    let processor = cpu_time();
    let done = cut_shard(sweep, &at, &beside, &mut |pieces| {
        if told.elapsed().as_secs_f64() > TELL_EVERY_S {
            told = Instant::now();
            tell!("  {pieces} pieces of motion cut");
        }
    });
    let done = done.and_then(|cost| {
        let result = result_of_shard(planned, &cost, &beside).map_err(SimError::Folder)?;
        fs::rename(&beside, &to).map_err(SimError::Folder)?;
        Ok((cost, result))
    });
    if done.is_err() {
        fs::remove_file(&beside).ok();
    }
    let (cost, result) = done.map_err(of)?;
    let spent = cpu_time().zip(processor).map(|(now, then)| now - then);
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    tell!(
        "  {} pieces of motion: cut in {:.2} s of {:.2} s{}; stock {:.1} MiB{}, cuts {:.1} MiB",
        cost.pieces,
        cost.removal_s,
        begin.elapsed().as_secs_f64(),
        spent.map_or_else(String::new, |s| format!(", {s:.2} s of processor time")),
        mib(cost.stock_bytes),
        peak_mib().map_or_else(String::new, |p| format!(", process {p:.0} MiB at most")),
        mib(cost.bytes)
    );
    write_result(sweep, &result).map_err(folder_fault)?;
    Ok(result)
}

/// Brings the shards of a run together: its run folder is that of a run that was never split.
fn merge_shards(args: &SweepMergeArgs, plan: &Plan) -> Result<State, Failure> {
    let missing = |message: String| {
        Failure::new(message).with_help(format!("run what is missing: proveout sweep run {}", args.sweep.display()))
    };
    let mut cuts = Vec::with_capacity(plan.jobs.len());
    for job in 0..plan.jobs.len() {
        Planned::read(&args.sweep, plan, job).map_err(|e| of(e.into()))?;
        let result = read_result(&args.sweep, plan, job).map_err(|e| missing(e.to_string()))?;
        if result.state != JobState::Cut {
            return Err(missing(format!("shard {job} was refused: {}", result.refused)));
        }
        let path = job_folder(&args.sweep, job).join(CUTS);
        let digest = digest::measure(&path).map_err(|e| missing(format!("{}: {e}", path.display())))?.1;
        if digest != result.verdict_sha256 {
            fs::remove_file(job_folder(&args.sweep, job).join(RESULT)).map_err(|e| of(SimError::Folder(e)))?;
            return Err(missing(format!("the cuts of shard {job} are damaged: {}", path.display())));
        }
        cuts.push(path);
    }
    let (threads, pool) = pool(None, None)?;
    let planned = Planned::read(&args.sweep, plan, 0).map_err(|e| of(e.into()))?;
    let prepared = pool.install(|| prepare_job(&args.sweep, &planned)).map_err(|e| of(e.into()))?.map_err(of)?;
    let shards = ShardCuts::open(&cuts).map_err(|e| of(e.into()))?;
    let (inputs, scene) = (prepared.inputs.clone(), prepared.scene.clone());
    let folder = RunFolder::create(&args.sweep.join(RUN)).map_err(|e| of(SimError::Folder(e)))?;
    let mut watchers: Vec<Box<dyn Observer>> = vec![Box::new(Progress::new(&prepared.running_file()))];
    watchers.extend(observers(&RerunMode::Off).map_err(Failure::new)?);
    let run = pool.install(|| run_merged(prepared, shards, &mut watchers, folder.path())).map_err(of)?;
    drop(watchers);
    write_run_json(folder.path(), &run_info(&run, &scene.path, threads, true))
        .map_err(|e| Failure::new(format!("run.json: {e}")))?;
    let place = complete(folder, &inputs, &scene.folder, &mut || ())?;
    print_summary(&run, &place);
    if let Some(facts) = &run.shards {
        say!("\n  {} shards: {} sweeps taken from them", facts.shards, facts.taken);
        if facts.near_bodies > 0 {
            say!("  {} sweeps computed here: a body came near the stock in their section", facts.near_bodies);
        }
        if facts.behind_loose_part > 0 {
            say!("  {} sweeps computed here, after a part came off the stock", facts.behind_loose_part);
        }
    }
    Ok(run.verdict.verdict)
}

fn merge(args: &SweepMergeArgs) -> Result<State, Failure> {
    let plan = Plan::read(&args.sweep).map_err(|e| of(e.into()))?;
    if plan.shards.is_some() {
        return merge_shards(args, &plan);
    }
    let merged = merge_sweep(&args.sweep, &plan).map_err(|e| {
        let run = format!("proveout sweep run {}", args.sweep.display());
        Failure::new(e).with_help(format!("run what is missing: {run}; if an input has changed, plan the sweep again"))
    })?;
    let states: Vec<String> = merged.states.iter().map(|(state, n)| format!("{n} {state}")).collect();
    say!("{} jobs: {}", merged.jobs, states.join(", "));
    if let Some(best) = &merged.fastest_pass {
        let values: Vec<String> = best.values.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        say!("  fastest that passes: job {}, {:.3} s, {}", best.job, best.time_s, values.join(", "));
    }
    say!("  results: {}", args.sweep.join("sweep.parquet").display());
    say!("           {} in a browser", args.sweep.join("sweep.html").display());
    Ok(State::Pass)
}
