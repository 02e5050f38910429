use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use proveout_record::{observers, write_job, write_run_json};
use proveout_sim::{
    Choice, Manifest, Observer, Prepared, Recorded, RunFolder, SimError, StockChoice,
    digest::{InputFile, of_input},
    job::{Job, JobVerdict, Setup},
    preflight::preflight,
    run::run as prove,
    verdict::State,
};

use crate::{
    args::{JobArgs, RerunArg},
    commands::{
        check::causes,
        run::{check_viewer, complete, pool, recorder, word},
    },
    failure::Failure,
    host::run_info,
    progress::Progress,
};

/// Runs the setups of a job in order; the verdict over all of them.
pub(crate) fn job(args: &JobArgs) -> Result<State, Failure> {
    let begin = Instant::now();
    let (threads, pool) = pool(None, args.threads)?;
    check_viewer(args.rerun)?;
    let failure = |e: SimError| Failure::from(&e);
    let job = Job::read(&args.job).map_err(|e| failure(e.into()))?;
    let call = Choice::default();
    pool.install(|| job.check(&call.step_files)).map_err(failure)?;
    let place = args.output.clone().unwrap_or_else(|| PathBuf::from("out").join(format!("{}-job", job.name)));
    let folder = RunFolder::create(&place).map_err(|e| failure(SimError::Folder(e)))?;
    let whole = folder.path().canonicalize().map_err(|e| failure(SimError::Folder(e)))?;

    let mut inputs = vec![of_input("job", &job.path).map_err(|e| failure(e.into()))?];
    let mut verdict = JobVerdict::new(&job);
    for setup in &job.setups {
        if let Some(before) = verdict.blocked(&job, setup) {
            tell!("setup {}: not run: setup {before} before it failed or was not run", setup.name);
            verdict.leave_out(&job, setup, &before);
            continue;
        }
        tell!("setup {}", setup.name);
        let stock = setup.after.map_or(StockChoice::OfScene, |i| StockChoice::OfRun(whole.join(&job.setups[i].name)));
        let choice = Choice {
            program: setup.program.clone(),
            recorded: if matches!(args.rerun, RerunArg::Off) { Recorded::Folder } else { Recorded::Recording },
            stock,
            ..call.clone()
        };
        let prepared = pool.install(|| Prepared::read(&setup.scene, &choice)).map_err(failure)?;
        for line in causes(&preflight(&prepared).into_iter().filter(|c| !c.note).collect::<Vec<_>>()) {
            tell!("{line}");
        }
        let mut own = prepared.inputs.clone();
        let scene = prepared.scene.clone();
        let at = whole.join(&setup.name);
        fs::create_dir_all(&at).map_err(|e| failure(SimError::Folder(e)))?;
        let mut watchers: Vec<Box<dyn Observer>> = vec![Box::new(Progress::new(&prepared.running_file()))];
        watchers.extend(observers(&recorder(args.rerun)).map_err(Failure::new)?);
        let result = pool.install(|| prove(prepared, &mut watchers, &at)).map_err(failure)?;
        drop(watchers);
        write_run_json(&at, &run_info(&result, &scene.path, threads, false))
            .map_err(|e| Failure::new(format!("run.json: {e}")))?;
        close(&at, &own, &scene.folder, (&whole, &place)).map_err(|e| failure(SimError::Folder(e)))?;
        verdict.add(&job, setup, &result.verdict);
        own.retain(|input| !input.path.starts_with(&whole));
        inputs.extend(own);
        told(setup, &verdict);
    }
    write_job(&whole, &verdict).map_err(Failure::new)?;
    let job_folder = job.path.parent().map_or_else(PathBuf::new, Path::to_owned);
    let place = complete(folder, &inputs, &job_folder, &mut || ())?;
    summary(&verdict, &place, begin.elapsed().as_secs_f64());
    Ok(verdict.verdict)
}

/// Writes the manifest of a setup, in which the folder of the job has the name that it will have.
fn close(at: &Path, inputs: &[InputFile], scene_folder: &Path, (now, later): (&Path, &Path)) -> std::io::Result<()> {
    let mut manifest = Manifest::of(at, inputs, scene_folder)?;
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (from, to) = (format!("{}/", name(now)), format!("{}/", name(later)));
    for input in &mut manifest.inputs {
        input.path = input.path.replace(&from, &to);
    }
    manifest.write(at)
}

fn told(setup: &Setup, verdict: &JobVerdict) {
    let state = verdict.setups.last().and_then(|s| s.verdict).map_or("not run", word);
    tell!("setup {}: {state}", setup.name);
}

fn summary(verdict: &JobVerdict, place: &Path, wall: f64) {
    say!("\n{}: {}\n", word(verdict.verdict).to_uppercase(), verdict.job);
    for s in &verdict.setups {
        let stock = s.after.as_ref().map_or_else(|| "own stock".to_owned(), |a| format!("stock of {a}"));
        match (&s.verdict, &s.not_run) {
            (Some(state), _) => {
                say!(
                    "  {:<9} {:<16} {stock}, {:.1} s, {:.1} mm3 removed, {} findings fail a gate",
                    word(*state),
                    s.name,
                    s.time_s.unwrap_or(0.0),
                    s.removed_mm3.unwrap_or(0.0),
                    s.errors
                );
                for gate in s.gates.iter().filter(|g| g.state != State::Pass) {
                    say!("            {:<9} {:<10} {}", word(gate.state), gate.gate, gate.reason);
                }
                for line in &s.first_errors {
                    say!("            {line}");
                }
            }
            (None, why) => say!("  {:<9} {:<16} {}", "unchecked", s.name, why.as_deref().unwrap_or_default()),
        }
    }
    say!("\n  computed in {wall:.1} s");
    say!("  results: {}", place.display());
    say!("           {} in a browser", place.join("job.html").display());
}
