//! Entities over time: poses of what moves, values of signals.

use proveout_geom::{Pose, Vector};
use proveout_machine::{Attachment, JointValues, Machine};

use crate::{
    error::RecordError,
    recording::{
        signal_thinning::SignalThinner,
        sink::{Sink, path},
    },
};

/// What moves: an entity and its poses that are not sent yet.
pub(crate) struct MovedEntity {
    parts: Vec<String>,
    what: MotionSource,
    shown: Option<Pose>,
    pub(crate) rows: Vec<(f64, Pose)>,
}

#[derive(Clone, Copy)]
pub(crate) enum MotionSource {
    Joint(usize),
    Table,
    Tool,
}

impl MovedEntity {
    pub(crate) fn new(parts: &[&str], what: MotionSource) -> Self {
        Self { parts: parts.iter().map(|p| (*p).to_owned()).collect(), what, shown: None, rows: Vec::new() }
    }

    /// Adds the pose at joint positions `q`, if it differs from the one before.
    pub(crate) fn push(&mut self, machine: &Machine, gauge_length: f64, time: f64, q: &JointValues) {
        let pose = match self.what {
            MotionSource::Joint(j) => machine.attachment_pose(Attachment::Joint(j), q),
            MotionSource::Table => machine.machine_from_table(q),
            MotionSource::Tool => {
                machine.machine_from_spindle(q) * Pose::from_translation(Vector::new(0.0, 0.0, -gauge_length))
            }
        };
        if self.shown != Some(pose) && pose.is_finite() {
            self.shown = Some(pose);
            self.rows.push((time, pose));
        }
    }

    /// Sends and forgets the rows.
    pub(crate) fn send(&mut self, sink: &Sink) -> Result<(), RecordError> {
        sink.poses(path(self.parts.iter().map(String::as_str)), &self.rows)?;
        self.rows.clear();
        Ok(())
    }
}

/// A plotted signal and its rows that are not sent yet.
pub(crate) struct Signal {
    parts: [String; 3],
    thinner: SignalThinner,
    pub(crate) rows: Vec<(f64, f64)>,
    /// Smallest and largest value so far.
    range: [f64; 2],
}

impl Signal {
    pub(crate) fn new(parts: [&str; 3]) -> Self {
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Self { parts: parts.map(str::to_owned), thinner: SignalThinner::default(), rows: Vec::new(), range }
    }

    /// True when the bound is no farther from the signal than half the signal's span: a far one would press
    /// the plot flat.
    pub(crate) fn comes_near(&self, bound: f64) -> bool {
        let [low, high] = self.range;
        low - bound <= 0.5 * (high - low) && bound - high <= 0.5 * (high - low)
    }

    pub(crate) fn path(&self) -> rerun::EntityPath {
        path(self.parts.iter().map(String::as_str).filter(|p| !p.is_empty()))
    }

    pub(crate) fn push(&mut self, time: f64, value: f64) {
        self.range = [self.range[0].min(value), self.range[1].max(value)];
        self.thinner.push(time, value, &mut self.rows);
    }

    /// Ends the signal with its last sample.
    pub(crate) fn finish(&mut self) {
        self.thinner.finish(&mut self.rows);
    }

    /// Sends and forgets the rows that are complete.
    pub(crate) fn send(&mut self, sink: &Sink) -> Result<(), RecordError> {
        sink.signal(self.path(), &self.rows)?;
        self.rows.clear();
        Ok(())
    }
}
