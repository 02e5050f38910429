//! The prove-out loop: program to motion, motion to removal and interference, findings, verdict.
//!
//! Stretch by stretch of simulated time the controller yields motion pieces; the stock is swept and the
//! bodies are checked against each other at the same time on two workers, since neither needs the other
//! (bodies against the stock are followed between the sweeps, see `stock_bodies`); reports are judged in
//! order of time. The length of a stretch bounds memory and sets how often observers are called, and how
//! often the twin looks whether a part has come off the stock; it does not change any other result.

use std::{path::Path, sync::PoisonError, time::Instant};

use proveout_controller::Summary as PathSummary;
use proveout_stock::{Patch, TriDexel};
use rayon::prelude::*;

use crate::{
    cut::{
        cut_source::Cuts,
        engine::Engine,
        journal::Journal,
        shard_cuts::{ShardCuts, ShardFacts},
    },
    judge::{
        final_verdict::{self, Shown},
        free_axes,
    },
    observe::{
        observer::{Batch, Observer, Outcome, Setup},
        observer_error::ObserverError,
        schedule_rows::Schedule,
        surface_keeper::SurfaceKeeper,
        surface_map::SurfaceMap,
    },
    prepare::{
        error::{SimError, from_run_error},
        prepared::Prepared,
    },
    run::{
        motion_plan::{STRETCH_S, controller, opened, stretches},
        partial::Watch,
        readings,
        show_mesh::show_mesh,
    },
    verdict::{
        partial_run::{Partial, Stopped},
        verdict_file::Verdict,
    },
};

pub use crate::cut::stages::{Checks, Stages};

/// What a run leaves.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// The judgement.
    pub verdict: Verdict,
    /// Wall time of the stages.
    pub stages: Stages,
    /// Wall time of the whole run, s.
    pub wall: f64,
    /// Swept motion pieces.
    pub pieces: u64,
    /// Memory that was announced before the stock was made, bytes.
    pub announced_memory: u64,
    /// Memory of the stock, and of each patch by its name, at the end, bytes.
    pub stock_memory: Vec<(String, u64)>,
    /// How the checks were settled.
    pub checks: Checks,
    /// Why the journal was given up, where there was one that could not be kept to the end.
    pub journal_given_up: Option<String>,
    /// What was taken from the shards of the run, where it has some.
    pub shards: Option<ShardFacts>,
    /// What was found of the free tool axes, and what was not looked at; empty where they are not
    /// asked for.
    pub free_axes: Vec<String>,
}

/// Runs a prepared program and calls the observers, which may write into `folder`.
///
/// # Errors
/// [`SimError`] when program, control or an observer refuse; there is then no verdict.
pub fn run(prepared: Prepared, observers: &mut [Box<dyn Observer>], folder: &Path) -> Result<RunResult, SimError> {
    run_journaled(prepared, None, observers, folder)
}

/// The same with a journal of its cuts, from which a run that is stopped goes on; it stays locked until the
/// run ends.
///
/// # Errors
/// As [`run`]; [`SimError::Journal`] when the journal does not fit.
pub fn run_journaled(
    prepared: Prepared,
    journal: Option<Journal>,
    observers: &mut [Box<dyn Observer>],
    folder: &Path,
) -> Result<RunResult, SimError> {
    run_with(prepared, journal.map(Cuts::Journal), observers, folder)
}

/// The same with cuts that shards have made: the folder has the bytes of a run that makes them itself.
///
/// # Errors
/// As [`run`]; [`SimError::Shard`] when they are those of another run.
pub fn run_merged(
    prepared: Prepared,
    shards: ShardCuts,
    observers: &mut [Box<dyn Observer>],
    folder: &Path,
) -> Result<RunResult, SimError> {
    run_with(prepared, Some(Cuts::Shards(shards)), observers, folder)
}

fn run_with(
    mut prepared: Prepared,
    cuts: Option<Cuts>,
    observers: &mut [Box<dyn Observer>],
    folder: &Path,
) -> Result<RunResult, SimError> {
    let begin = Instant::now();
    let others = readings::run_others(&prepared, folder)?;
    let mut stages = Stages { read: prepared.read_time, ..Stages::default() };
    let (stock, patches) = prepared.stock.take()?;
    let known = prepared.schedule.take();
    let prepared = prepared;
    let mut engine = Engine::new(&prepared, stock, patches, cuts)?;
    engine.prove_clearance();
    let told = Instant::now();
    for observer in observers.iter_mut() {
        observer.begin(&setup(&prepared, engine.stock(), engine.patches()), folder)?;
    }
    if observers.iter().any(|o| o.shows_schedule())
        && let Some(schedule) = known.or_else(|| Schedule::of_prepared(&prepared))
    {
        for observer in observers.iter_mut() {
            observer.schedule(&setup(&prepared, engine.stock(), engine.patches()), &schedule)?;
        }
    }
    stages.record += told.elapsed().as_secs_f64();

    let (summary, stopped) = drive(&prepared, &mut engine, &mut stages, observers)?;
    let partial = Partial { preview: prepared.wanted.preview.clone(), stopped };
    let partial = (partial != Partial::default()).then_some(partial);

    let judging = Instant::now();
    let recorded = stages.record;
    let pieces = engine.pieces();
    let journal_given_up = engine.cuts().and_then(Cuts::journal_given_up);
    let shards = engine.cuts().and_then(Cuts::shards).map(ShardCuts::facts);
    let (stock, patches, facts) = engine.finish();
    let setup = setup(&prepared, &stock, &patches);
    let (mut verdict, surveyed) =
        final_verdict::judge(&prepared, (&stock, &patches), &facts, &summary, partial, &mut |shown| {
            tell(observers, &mut stages, |o| match shown {
                Shown::Points(band) => o.surface_points(&setup, band),
                Shown::Texture(texture) => o.surface_texture(&setup, texture),
            })
        })?;
    readings::fold(&mut verdict, prepared.other_readings.len(), others);
    let mut told_of_axes = Vec::new();
    if prepared.free_axes > 0 {
        let axes = free_axes::look(&prepared, &facts, prepared.free_axes);
        tell(observers, &mut stages, |o| o.free_axes(&setup, &axes))?;
        told_of_axes.push(axes.words());
        told_of_axes.extend(axes.unchecked.iter().map(|u| format!("not checked: {u}")));
    }
    show_mesh(&stock, &patches, &surveyed, &mut |part| {
        tell_at_once(observers, &mut stages, &|o| o.surface_mesh(&setup, &surveyed.shape, part))
    })?;
    stages.surface += judging.elapsed().as_secs_f64() - (stages.record - recorded);

    let shape = surveyed.shape;
    drop(surveyed.deviations);
    let outcome =
        Outcome { verdict: &verdict, stock: &stock, patches: &patches, surface: &shape, proof: &facts.proof, folder };
    tell(observers, &mut stages, |o| o.end(&setup, &outcome))?;
    let wall = prepared.read_time + begin.elapsed().as_secs_f64();
    let memory = |name: &str, s: &TriDexel| (name.to_owned(), s.memory_bytes());
    let stock_memory =
        std::iter::once(memory("stock", &stock)).chain(patches.iter().map(|p| memory(p.name(), p.stock()))).collect();
    Ok(RunResult {
        verdict,
        stages,
        wall,
        pieces,
        announced_memory: prepared.memory.total(),
        stock_memory,
        checks: facts.effort,
        journal_given_up,
        shards,
        free_axes: told_of_axes,
    })
}

/// Takes the motion through stock and bodies without a judgement of the surface; the observers are
/// called for the stretches alone.
pub(crate) fn rehearse(mut prepared: Prepared, observers: &mut [Box<dyn Observer>]) -> Result<(), SimError> {
    let (stock, patches) = prepared.stock.take()?;
    let prepared = prepared;
    let mut engine = Engine::new(&prepared, stock, patches, None)?;
    drive(&prepared, &mut engine, &mut Stages::default(), observers).map(|_| ())
}

/// Plans the motion of the program and takes it through the engine, stretch by stretch.
fn drive(
    prepared: &Prepared,
    engine: &mut Engine<'_>,
    stages: &mut Stages,
    observers: &mut [Box<dyn Observer>],
) -> Result<(PathSummary, Option<Stopped>), SimError> {
    let mut controller = controller(prepared)?;
    let mut watch = Watch::new(prepared);
    while !watch.has_stopped() {
        let planning = Instant::now();
        let chunk = controller.next_chunk().map_err(|e| from_run_error(opened(prepared, e)))?;
        let servo = controller.servo_wall_s() - stages.servo;
        stages.plan += planning.elapsed().as_secs_f64() - servo;
        stages.servo += servo;
        let Some(chunk) = chunk else { break };
        let chunk = watch.cut(chunk);
        for stretch in stretches(chunk, watch.stretch_s(STRETCH_S)) {
            let batch = engine.step(&stretch, stages);
            engine.check_cuts()?;
            engine.check_memory()?;
            let telling = Instant::now();
            let batch = Batch {
                samples: &stretch.samples,
                signals: &batch.signals,
                pieces: &stretch.pieces,
                blocks: &batch.blocks,
                events: &stretch.events,
                findings: &batch.findings,
                time: batch.time,
                stock: engine.stock(),
                changed_tiles: &batch.changed_tiles,
                patches: engine.patches(),
                changed_in_patches: &batch.changed_in_patches,
                loose: &batch.loose,
            };
            for observer in observers.iter_mut() {
                observer.batch(&setup(prepared, batch.stock, batch.patches), &batch)?;
            }
            stages.record += telling.elapsed().as_secs_f64();
            watch.ran(&stretch, batch.findings);
            if watch.ends_here() {
                break;
            }
        }
    }
    let mut summary = controller.summary();
    let stopped = watch.finish(prepared, &mut summary, engine.time());
    Ok((summary, stopped))
}

/// The same, with the whole surface of the cut part in memory.
///
/// # Errors
/// As [`run`].
pub fn run_with_surface(
    prepared: Prepared,
    mut observers: Vec<Box<dyn Observer>>,
    folder: &Path,
) -> Result<(RunResult, SurfaceMap), SimError> {
    let (keeper, surface) = SurfaceKeeper::new();
    observers.push(Box::new(keeper));
    let result = run(prepared, &mut observers, folder)?;
    let surface = std::mem::take(&mut *surface.lock().unwrap_or_else(PoisonError::into_inner));
    Ok((result, surface))
}

/// Calls all observers in parallel, where that takes them long, and books the time; returns the
/// fault of the first in their order.
fn tell_at_once(
    observers: &mut [Box<dyn Observer>],
    stages: &mut Stages,
    what: &(dyn Fn(&mut dyn Observer) -> Result<(), ObserverError> + Sync),
) -> Result<(), SimError> {
    let told = Instant::now();
    let all: Vec<Result<(), ObserverError>> = observers.par_iter_mut().map(|o| what(o.as_mut())).collect();
    all.into_iter().collect::<Result<(), ObserverError>>()?;
    stages.record += told.elapsed().as_secs_f64();
    Ok(())
}

/// Calls all observers in turn, and books the time.
fn tell(
    observers: &mut [Box<dyn Observer>],
    stages: &mut Stages,
    mut what: impl FnMut(&mut dyn Observer) -> Result<(), ObserverError>,
) -> Result<(), SimError> {
    let told = Instant::now();
    for observer in observers.iter_mut() {
        what(observer.as_mut())?;
    }
    stages.record += told.elapsed().as_secs_f64();
    Ok(())
}

/// What does not change during the run, and the present stock.
fn setup<'a>(prepared: &'a Prepared, stock: &'a TriDexel, patches: &'a [Patch]) -> Setup<'a> {
    Setup {
        scene: &prepared.scene,
        program: &prepared.program_name,
        program_lines: prepared.program_lines,
        made: prepared.made.as_ref(),
        sources: &prepared.shown,
        machine: &prepared.machine,
        tools: &prepared.tools,
        stock,
        patches,
        part: prepared.part_mesh.as_ref(),
        fixtures: &prepared.fixtures,
        table_from_work: prepared.table_from_work,
        dynamics: prepared.dynamics,
        plant: prepared.plant,
    }
}
