//! A machine's limits, gains and friction from measured traces, each with its standard error.
//!
//! **Data in.** Tables of time, commanded and measured joint positions, motor force (CSV;
//! [`trace_from_text`]), and the machine file as a first guess. **Data out.** [`Calibration`]: one
//! [`Parameter`] for each value, with estimate, standard error, and whether it replaces that of the machine
//! file; [`calibrated_machine`] writes the file. Inside: mm, radian, second, N, N mm; joint positions in
//! machine coordinates.
//!
//! **Algorithm.** The trace is split into moves of one joint from rest to rest. Their set points are fitted
//! by five laws of motion; the drive model of the twin is fitted to the following error; friction follows
//! from the balance of momentum. All by weighted least squares with a rank test; rounding, noise and the
//! correlation of residuals widen the errors. What the data do not determine keeps its value, with the
//! reason.
//!
//! **Limits.** Moves of several joints, corners and circles are not used. Each joint's limits are taken as
//! constant over its travel. The drive model needs a machine file that states a drive. Positions of
//! platforms' joints are taken as they are, their legs are not fitted.
//!
//! | file or folder | holds |
//! |---|---|
//! | `trace/` | columns of a table, rounding and noise, bad input |
//! | `fit/` | laws of motion, least squares, one file an estimator |
//! | `times.rs` | tool changes, dwells and words of the program |
//! | `calibration.rs`, `parameters.rs` | all estimators over all joints; their values in the units of keys |
//! | `machine_file.rs` | the machine file with the new values |
//! | `air_program.rs`, `air_text.rs` | the program to record: its moves, and their text in four languages |

mod air_program;
mod air_text;
mod calibration;
mod fit;
mod machine_file;
mod parameters;
mod times;
mod trace;

pub use air_program::{AirProgram, AirStep, PlanError};
pub use calibration::{Calibration, Correlation, JointReport, Parameter, Table, calibrate};
pub use fit::law::{Law, LawKind, LawShape};
pub use machine_file::{calibrated_machine, needs_folder, with_error};
pub use times::{WordTime, WordTimes};
pub use trace::{
    ColumnsFile, ForceUnit, JointColumns, JointTrace, PositionUnit, Signal, TimeUnit, Trace, trace_from_text,
};
