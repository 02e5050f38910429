//! What a run takes: wall time of its stages, and how the checks of bodies were settled.

use std::time::Instant;

use proveout_collision::Effort;

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
    /// Interference of bodies; runs in parallel with the removal.
    pub collision: f64,
    /// Surface extraction, deviation, inspection.
    pub surface: f64,
    /// Observers.
    pub record: f64,
}

/// How the checks of bodies were settled: what they cost, on any host.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Checks {
    /// Bodies against bodies.
    pub bodies: Effort,
    /// Stretches of motion that were looked at for the least clearance of each pair.
    pub looks: u64,
    /// Motions that were followed against the stock.
    pub stock_motions: u64,
    /// Distances from its rays that were asked for.
    pub stock_queries: u64,
}

/// Does some work, and gives the wall time that it took, s.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
