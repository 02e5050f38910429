//! The prove-out loop: program to motion, motion to removal and interference, findings, verdict.
//!
//! Stretch by stretch of simulated time the controller yields motion pieces; the stock is swept and the bodies are
//! checked at the same time on two workers, since neither needs the other; reports are judged in order of time. The
//! length of a stretch bounds memory and sets how often observers are called; it does not change any result.

use std::{path::Path, time::Instant};

use proveout_controller::{Chunk, Controller, RunError};
use proveout_nc::Diagnostic;
use proveout_stock::TriDexel;

use crate::{
    engine::Engine,
    error::SimError,
    judge,
    observer::{Batch, Observer, Outcome, Setup},
    prepare::Prepared,
    surface_map::SurfaceMap,
    survey::known_offset,
    verdict::Verdict,
};

/// Simulated time of one stretch, s.
const STRETCH_S: f64 = 2.0;

/// Wall time of the stages of a run, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stages {
    /// Reading scene, machine, tools, meshes; making the stock.
    pub read: f64,
    /// Reading the program and planning its motion.
    pub plan: f64,
    /// Axis dynamics.
    pub servo: f64,
    /// Sweeping the stock.
    pub removal: f64,
    /// Interference of bodies; runs beside the removal.
    pub collision: f64,
    /// Surface extraction, deviation, inspection.
    pub surface: f64,
    /// Observers.
    pub record: f64,
}

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
    /// Surface of the cut part with what was measured on it.
    pub surface: SurfaceMap,
    /// Memory of the stock, and of each patch by its name, at the end, bytes.
    pub stock_memory: Vec<(String, u64)>,
}

/// Runs a prepared program and tells the observers, which may write into `folder`.
///
/// # Errors
/// [`SimError`] when program, control or an observer refuse; there is then no verdict.
pub fn run(prepared: Prepared, observers: &mut [Box<dyn Observer>], folder: &Path) -> Result<RunResult, SimError> {
    let begin = Instant::now();
    let mut stages = Stages { read: prepared.read_time, ..Stages::default() };
    let stock = &prepared.stock;
    let mut engine = Engine::new(&prepared, stock.clone(), prepared.patches.clone())?;
    let setup = Setup {
        scene: &prepared.scene,
        program: &prepared.program_name,
        program_lines: prepared.program_lines,
        machine: &prepared.machine,
        tools: &prepared.tools,
        stock,
        patches: &prepared.patches,
        part: prepared.part_mesh.as_ref(),
        fixtures: &prepared.fixtures,
        table_from_work: prepared.table_from_work,
        dynamics: prepared.dynamics,
        plant: prepared.plant,
    };
    let told = Instant::now();
    for observer in observers.iter_mut() {
        observer.begin(&setup, folder)?;
    }
    stages.record += told.elapsed().as_secs_f64();

    let scene_path = prepared.scene.path.display().to_string();
    let program = prepared.program()?;
    let settings = prepared.control_settings(program.dialect());
    let commands = program.map(|command| command.and_then(|c| known_offset(c, &prepared.nc_settings, &scene_path)));
    let mut controller = Controller::new(commands, &prepared.machine, &prepared.tools.tools, settings)?;
    loop {
        let planning = Instant::now();
        let chunk = controller.next_chunk().map_err(from_run_error)?;
        let servo = controller.servo_wall_s() - stages.servo;
        stages.plan += planning.elapsed().as_secs_f64() - servo;
        stages.servo += servo;
        let Some(chunk) = chunk else { break };
        for stretch in stretches(&chunk) {
            let batch = engine.step(&stretch, &mut stages);
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
            };
            for observer in observers.iter_mut() {
                observer.batch(&setup, &batch)?;
            }
            stages.record += telling.elapsed().as_secs_f64();
        }
    }

    let judging = Instant::now();
    let summary = controller.summary();
    let pieces = engine.pieces();
    let (stock, patches, facts) = engine.finish();
    let (verdict, surface) = judge::judge(&prepared, &stock, &patches, &facts, &summary);
    stages.surface += judging.elapsed().as_secs_f64();

    let telling = Instant::now();
    let outcome = Outcome { verdict: &verdict, stock: &stock, patches: &patches, surface: &surface, folder };
    for observer in observers.iter_mut() {
        observer.end(&setup, &outcome)?;
    }
    stages.record += telling.elapsed().as_secs_f64();
    let wall = prepared.read_time + begin.elapsed().as_secs_f64();
    let memory = |name: &str, s: &TriDexel| (name.to_owned(), s.memory_bytes());
    let stock_memory =
        std::iter::once(memory("stock", &stock)).chain(patches.iter().map(|p| memory(p.name(), p.stock()))).collect();
    Ok(RunResult { verdict, stages, wall, pieces, surface, stock_memory })
}

pub(crate) fn from_run_error(e: RunError<Diagnostic>) -> SimError {
    match e {
        RunError::Program(d) => SimError::from(d),
        RunError::Control(c) => SimError::Control(c),
    }
}

/// Cuts a chunk into stretches of at most [`STRETCH_S`] simulated seconds, at borders of pieces.
fn stretches(chunk: &Chunk) -> Vec<Chunk> {
    let start = [
        chunk.pieces.first().map(|p| p.time[0]),
        chunk.samples.first().map(|s| s.time),
        chunk.events.first().map(|e| e.time()),
        chunk.blocks.first().map(|b| b.end_time),
    ];
    let Some(start) = start.into_iter().flatten().reduce(f64::min) else { return Vec::new() };
    let (mut p, mut s, mut e, mut b) = (0, 0, 0, 0);
    let mut out = Vec::new();
    let mut until = start;
    while p < chunk.pieces.len() || s < chunk.samples.len() || e < chunk.events.len() || b < chunk.blocks.len() {
        until += STRETCH_S;
        let next =
            |from: usize, done: &dyn Fn(usize) -> bool, len: usize| (from..len).find(|&i| !done(i)).unwrap_or(len);
        let p_end = next(p, &|i| chunk.pieces[i].time[0] < until, chunk.pieces.len());
        let s_end = next(s, &|i| chunk.samples[i].time < until, chunk.samples.len());
        let e_end = next(e, &|i| chunk.events[i].time() < until, chunk.events.len());
        let b_end = next(b, &|i| chunk.blocks[i].end_time < until, chunk.blocks.len());
        if (p, s, e, b) != (p_end, s_end, e_end, b_end) {
            out.push(Chunk {
                pieces: chunk.pieces[p..p_end].to_vec(),
                samples: chunk.samples[s..s_end].to_vec(),
                events: chunk.events[e..e_end].to_vec(),
                blocks: chunk.blocks[b..b_end].to_vec(),
            });
        }
        (p, s, e, b) = (p_end, s_end, e_end, b_end);
    }
    out
}
