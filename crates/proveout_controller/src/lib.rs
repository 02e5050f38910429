//! The twin's numerical control: canonical commands in, motion of the machine out.
//!
//! It applies tool lengths, tool center point control (RTCP) and machine coordinates, rounds corners within
//! tolerances, plans the feed with look-ahead under the velocity, acceleration and jerk limits of every
//! joint, and samples the motion at the cycle of the control. Executed motion leaves as a stream of
//! [`Chunk`]s, so that memory does not grow with the program.
//!
//! # Data
//!
//! In: [`proveout_nc::Command`]s, a [`proveout_machine::Machine`], tools, [`Settings`]. Out, in mm, radian
//! and second:
//! * [`Piece`] – tool motion in the table frame K for removal and interference checks, with a bound of its
//!   error;
//! * [`Sample`] – set points of the joints with three derivatives at each control cycle, and what the drives
//!   do;
//! * [`Event`] – tool changes, spindle, limits passed; [`BlockRecord`] – begin and end of every block;
//! * [`Summary`] – times, lower bound of the time, extremes of the joints.
//!
//! # Coordinates
//!
//! Without tool center point control, base coordinates are machine coordinates of the tip: an axis letter is
//! the joint of that name; the active tool length is added along the spindle direction (joints at zero) to
//! the axes that a block moves. Changing the length alone moves nothing. With tool center point control they
//! are coordinates of the tip in the table frame K, which turns with the table. A block in machine
//! coordinates (SUPA, G53) moves only the axes it names. No motion happens when the control is switched.
//!
//! # Feed
//!
//! The feed holds for the tip (with tool center point control) or the linear joints (without), on the path
//! that is run: where corners are rounded, that is shorter than the programmed one, and so are lengths and
//! the time at the feed (`path/way.rs`). Where neither moves, a feed of F mm/min is read as F degrees/min of
//! the rotary joints together (Euclidean).
//!
//! # Exact stops
//!
//! A corner that turns the tip back by 170 degrees or more is an exact stop, as are corners between feed and
//! rapid and those without room: depths of holes are reached (`path/reversal.rs`).
//!
//! # Bounds of the time
//!
//! [`Summary::lower_bound_s`] holds for every motion within the tolerances (`tube.rs`),
//! [`Summary::path_bound_s`] for the path that is run (`limits.rs`).
//!
//! # Algorithm
//!
//! Corners between feed and rapid are exact: the control stops in them. [`Controller`] collects blocks
//! between two stops into a path in task coordinates, with fitted runs of lines (`path/fit.rs`) and quintic
//! corner blends (`path.rs`), derives limits along the path from those of the joints (`limits.rs`,
//! derivatives through the kinematics by Taylor arithmetic, `rtcp.rs`), plans a first time law
//! (`look_ahead.rs`, closed forms in `jerk_ramp.rs`), runs it as fast as the joints allow (`retime.rs`),
//! measures the law at the control samples and slows down where one passes a limit (`stretch.rs`), and cuts
//! the motion into pieces (`pieces.rs`). Rounded and exact path share one parameter, so that
//! [`Dynamics::Ideal`] and [`Dynamics::Planned`] have the same time law.
//!
//! # Axis dynamics
//!
//! With [`Dynamics::Servo`] the planned stream goes through the drives of the machine file (`servo`): cascade
//! control, friction, backlash, one elastic mode and force limit a joint, in exact discrete form, loaded by
//! the machine's bodies (`dynamics`: recursive Newton-Euler, or Rapier as plant). Times, blocks and set
//! points stay those of the plan; `Sample::actual` and the pieces are those of the loads. The control does
//! not wait for the drives at exact stops.
//!
//! # Geometric errors
//!
//! The control plans with the described machine. [`Sample::pose`] and [`Piece::pose`] are those of the actual
//! one, with the geometric errors of the machine file, under all dynamics; joints, times and limits are the
//! same as without them.
//!
//! # Limits
//!
//! Curved blocks that are not short (arcs, splines, long great circles) are rounded corner by corner, not
//! fitted together. Against an independent optimum with jerk limits (`tests/optimum.rs`) plans lose below 0.1
//! percent at feed and 1 to 2 percent at corners and in curves; 20 single curves from rest to rest that
//! joints alone bind take no longer than what another program finds (`tests/against_copp.rs`). Not executed
//! and refused by name: a contour whose cutter compensation was not applied by the reader. A machine without
//! acceleration (jerk) limits gets steps of velocity (acceleration); [`Summary::unlimited_joints`] names it.
//! A standstill has only its first and last sample. M0 and M1 take no time. Loads of the drives are those of
//! the machine alone: no workpiece, fixture, tool or cutting force.
//!
//! # Files
//!
//! | file or folder | holds |
//! |---|---|
//! | `controller.rs`, `controller/` | executes commands: state, runs between stops, dwell, spindle, probing |
//! | `motion.rs`, `motion/` | exact path of a motion: lines, great circles, splines, retraction |
//! | `shape.rs`, `shape/` | exact path of one block; quintic pieces that round corners |
//! | `path.rs`, `path/` | path between two stops: fit, rounded corners, reversals, cells with limits |
//! | `rtcp.rs`, `mapping.rs`, `jet.rs` | task coordinates to joints, with derivatives |
//! | `limits.rs`, `look_ahead.rs`, `jerk_ramp.rs`, `profile.rs` | limits along the path; the first time law |
//! | `retime.rs`, `retime/`, `tempo.rs` | the law run as fast as the joints allow |
//! | `stretch.rs`, `stretch/`, `watch.rs` | the law checked and slowed at the control samples |
//! | `emit.rs`, `output.rs`, `pieces.rs`, `straightness.rs` | samples, events, blocks, motion pieces |
//! | `meter.rs`, `summary.rs`, `tube.rs` | figures of a run; its lower bound of the time |
//! | `servo/` | drives: the actual motion of the joints |
//! | `dynamics/` | loads of the drives: Newton-Euler, or Rapier as plant |
//! | `program_runs.rs`, `idle_tools.rs` | runs of a program; tools that are changed in and not moved |
//! | `reprogram.rs`, `reprogram/` | whole programs re-scheduled |
//! | `alternatives/` | all tool axes that are possible in a run, as gates of joints |
//! | `settings.rs`, `error.rs` | settings of the control; why it stops |

#![expect(clippy::needless_range_loop, reason = "a joint's number indexes several arrays at once")]

mod alternatives;
mod controller;
pub mod dynamics;
mod emit;
mod error;
mod idle_tools;
mod jerk_ramp;
mod jet;
mod limits;
mod look_ahead;
mod mapping;
mod meter;
mod motion;
mod output;
mod path;
mod pieces;
mod profile;
mod program_runs;
mod reprogram;
mod retime;
mod rtcp;
pub mod servo;
mod settings;
mod shape;
mod straightness;
mod stretch;
mod summary;
mod tempo;
mod tube;
mod watch;

pub use alternatives::{Alternatives, TwoAngles};
pub use controller::{Controller, ProbeWay};
pub use error::{ControlError, RunError};
pub use output::{BlockKind, BlockRecord, Chunk, DriveSample, Event, FinerMotion, LimitKind, MoveKind, Piece, Sample};
pub use program_runs::{ProgramBlock, ProgramRun, program_runs};
pub use reprogram::{BlockTimes, Reprogrammed, ReprogrammedRun, Reprogramming};
pub use settings::{Dynamics, Settings};
pub use summary::{DriveUse, JointSummary, LoadTrust, Summary, UnlimitedJoint};
