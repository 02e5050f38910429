//! Files of a comparison: `compare.json`, the page `compare.html`, drawings for other pages.

mod drawings;
mod page;
mod part;
mod rows;
#[cfg(test)]
mod tests;

use std::{
    fs,
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

use proveout_sim::{
    Observer,
    compare::Compared,
    observer::{Batch, ObserverError, Outcome, Setup},
};

use crate::{envelope::Envelope, error::RecordError, json::write_json, units::JointUnit};

/// Set points of every joint over the cutting stretch of a program, as [`TraceObserver`] has gathered them.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Whole stretch, and the part of it that is shown closely.
    windows: [Vec<JointTrace>; 2],
}

/// Position, velocity, acceleration and jerk of a joint over the time since the begin of the window; mm or
/// degrees.
#[derive(Clone, Debug, Default)]
struct JointTrace {
    signals: [Envelope; 4],
}

/// Gathers the set points of a program for the page of a comparison. Memory does not grow with the length of
/// the run.
pub struct TraceObserver {
    windows: [[f64; 2]; 2],
    units: Vec<JointUnit>,
    trace: Arc<Mutex<Trace>>,
}

impl TraceObserver {
    /// An observer of these windows (begin and end, s of the program), and where its trace lies after the
    /// run.
    pub fn new(windows: [[f64; 2]; 2]) -> (Self, Arc<Mutex<Trace>>) {
        let trace = Arc::new(Mutex::new(Trace::default()));
        (Self { windows, units: Vec::new(), trace: Arc::clone(&trace) }, trace)
    }
}

impl Observer for TraceObserver {
    fn name(&self) -> &'static str {
        "trace"
    }

    fn begin(&mut self, setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        self.units = JointUnit::all(setup.machine);
        let empty = || vec![JointTrace::default(); self.units.len()];
        self.trace.lock().unwrap_or_else(PoisonError::into_inner).windows = [empty(), empty()];
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        let mut trace = self.trace.lock().unwrap_or_else(PoisonError::into_inner);
        for (joints, [from, to]) in trace.windows.iter_mut().zip(self.windows) {
            for s in batch.samples.iter().filter(|s| s.time >= from && s.time <= to) {
                for (k, (joint, unit)) in joints.iter_mut().zip(&self.units).enumerate() {
                    let values = [s.commanded[k], s.velocity[k], s.acceleration[k], s.jerk[k]];
                    for (signal, value) in joint.signals.iter_mut().zip(values) {
                        signal.push(s.time - from, value * unit.factor);
                    }
                }
            }
        }
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// Writes `compare.json`, `compare.html` and the drawings that there is something for; `traces` are those of
/// the programs in the order of the scene.
///
/// # Errors
/// [`RecordError::Io`] with the path, or [`RecordError::Page`].
pub fn write_comparison(folder: &Path, compared: &Compared, traces: &[Trace]) -> Result<(), RecordError> {
    write_json(&folder.join("compare.json"), &compared.comparison)?;
    drawings::write_drawings(folder, &compared.comparison)?;
    let path = folder.join("compare.html");
    fs::write(&path, page::render(compared, traces)?).map_err(RecordError::io(&path))
}
