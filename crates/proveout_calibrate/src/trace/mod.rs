//! Measured traces: positions of the joints over time, with what the motors give.

mod columns;
mod quality;
mod read;

pub use columns::{ColumnsFile, ForceUnit, JointColumns, PositionUnit, TimeUnit};
pub use read::trace_from_text;

/// A trace in mm, radian, second, N and N mm.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Name of its file, for reports.
    pub name: String,
    /// SHA-256 of its text.
    pub sha256: String,
    /// Time of every row, s, growing.
    pub time: Vec<f64>,
    /// Median of the steps of time, s.
    pub step: f64,
    /// Steps of time are equal: the time follows from the row's number.
    pub even: bool,
    /// One entry for each joint of the machine; none where the trace does not have it.
    pub joints: Vec<Option<JointTrace>>,
    /// Line of the program under way.
    pub block: Option<Vec<u32>>,
    /// Override of the feed, percent.
    pub override_percent: Option<Vec<f64>>,
}

/// What a trace has of one joint.
#[derive(Clone, Debug)]
pub struct JointTrace {
    /// Set point.
    pub command: Option<Signal>,
    /// Measured position.
    pub actual: Option<Signal>,
    /// Force or torque of the motor: N or N mm where `force_known`, else in the unit of its column.
    pub force: Option<Vec<f64>>,
    /// Unit of that column, and whether it is a force.
    pub force_unit: Option<ForceUnit>,
    /// The force is in N or N mm.
    pub force_known: bool,
}

impl JointTrace {
    /// The set point, else the measured position.
    pub fn position(&self) -> Option<&Signal> {
        self.command.as_ref().or(self.actual.as_ref())
    }
}

/// One column of positions.
#[derive(Clone, Debug)]
pub struct Signal {
    /// Values, mm or radian.
    pub values: Vec<f64>,
    /// All values are multiples of this; zero where they are not rounded.
    pub quantum: f64,
    /// Standard deviation of a value at rest.
    pub noise: f64,
}

impl Signal {
    /// Variance of a value that was read while the joint moved at `speed`, with rows `step` apart.
    ///
    /// Rounding to steps of q has the variance q²/12 (Widrow 1956). Rows that read the same step share one
    /// rounding error: of q / (|v| dt) rows one is new, so each counts for so much less. Noise of half a step
    /// makes rounding errors independent.
    pub fn variance(&self, speed: f64, step: f64) -> f64 {
        let rounding = self.quantum * self.quantum / 12.0;
        let way = speed.abs() * step;
        let shared = if self.noise >= 0.5 * self.quantum {
            1.0
        } else {
            // A joint at rest repeats one value: nothing but the border of a move comes with this speed.
            (self.quantum / way.max(1e-3 * self.quantum)).max(1.0)
        };
        self.noise * self.noise + rounding * shared
    }
}
