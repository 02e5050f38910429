//! Machines: description, forward and inverse kinematics, travel and drive limits, bodies.
//!
//! **Data in.** `machine.toml`: joints with their lines, limits and parents, spindle gauge line, table
//! surface, control and bodies; keys carry their units (mm, deg, mm/min). **Data out.** Joint values
//! ([`JointValues`], mm and radian) and tool poses ([`proveout_geom::ToolPose`]: tip in mm and unit axis from
//! the tip to the holder).
//!
//! **Frames.** M machine, fixed to the base. K table: carried by the last work joint, equal to M with all
//! joints at zero. S spindle: origin on the gauge line, +z from the tool into the spindle. The tip of a tool
//! lies `tool_length` in front of the gauge line. Every joint is given by its line in M with all joints at
//! zero, and says whether it carries tool or workpiece and which way it moves: [`Joint::sense`].
//!
//! Main types:
//! * [`Machine`] – read with [`Machine::read`]; forward ([`Machine::forward`]), inverse
//!   ([`Machine::inverse`], [`Machine::inverse_nearest`], [`Machine::inverse_with_rotary`]), rates
//!   ([`Machine::jacobian`]).
//! * [`Joint`] – one axis and its limits; [`Machine::missing_limits`] lists those that are not stated.
//! * [`Platform`] – a heave and a tilt joint on three legs (3-RPS), with leg lengths and rates.
//! * [`GeometricErrors`] – what the actual machine does differently: [`Machine::actual_forward`],
//!   [`Machine::actual_inverse_nearest`].
//! * [`Machine::poles`], [`Machine::branch_of`], [`Machine::on_branch`], [`Machine::leaving_pole`] – what it
//!   takes to follow a tool axis through and past singular poses.
//! * [`Machine::limit_violations`] – travel and rate limits of a state of motion, legs included, as data;
//!   [`Machine::amplification_violation`].
//! * [`Machine::diagnose`] – what is missing or looks wrong in a description, with line and remedy.
//! * [`MachineBody`] – a part for collision checks and pictures, with its mass where it is known.
//! * [`PairRule`] – a near-miss distance or an exclusion of one pair of bodies.
//! * [`Drive`] – loop gains, friction, backlash, elasticity and force limit of a joint, where they are known.
//! * [`kinematics_csv`] – whole tables, both ways.
//!
//! **Algorithm.** Forward: product of exponentials along one chain from the table to the spindle (Brockett
//! 1984). Inverse: the tool axis gives the rotary joints as the intersection of two cones (Paden 1986). The
//! tip then gives the linear joints, in which it is linear wherever they are in the chain. Closed form for
//! any two rotary joints, platforms included; the derivations are at the top of `axis_pair.rs` and
//! `platform.rs`. With more rotary joints a damped Newton method takes the smallest motion.
//!
//! **Limits.** Eight joints. Platforms have heave and one tilt. Error tables give the error as a function
//! of the position of one joint; errors that depend on two joints, on load or on temperature are not
//! described. Near a singular pose, angles are only as exact as the pose: with the tool axis known to
//! 1e-16, the free joint is known to 1e-16 / sin(angle to the singular axis).
//!
//! # Files
//!
//! | file or folder | holds |
//! |---|---|
//! | `machine`, `joint`, `spindle`, `attachment` | the machine as data |
//! | `platform`, `turn_shift`, `drive` | legs, the shift of a turn, drives |
//! | `errors`, `mass`, `pairs` | errors, masses, rules for pairs |
//! | `description`, `drive_file` | the machine file as written; the JSON Schema comes from it |
//! | `machine_reader`, `reading`, `units`, `structure` | from the file to the data, with checks |
//! | `joint_reader`, `platform_reader`, `errors_reader`, `pairs_reader` | one table of the file each |
//! | `drive_reader`, `friction`, `backlash` | `[joint.drive]` |
//! | `bodies`, `model` | bodies from primitives and from model files |
//! | `kinematic_chain`, `solver`, `axis_pair`, `inverse`, `jacobian` | forward and inverse kinematics |
//! | `poles` | singular poses along a path |
//! | `actual` | kinematics with geometric errors |
//! | `limits` | travel and rates of a state of motion |
//! | `diagnose`, `key_lines` | remarks on a description, with their line |
//! | `summary` | a machine in one line |
//! | `program_zero`, `zero_at_home` | where programs and joints have their zero |
//! | `table` | tables of joint values and poses (CSV) |
//! | `linuxcnc_ini`, `urdf` | import from other programs |

mod actual;
mod attachment;
mod axis_pair;
mod backlash;
mod bodies;
mod description;
mod diagnose;
mod drive;
mod drive_file;
mod drive_reader;
mod errors;
mod errors_reader;
mod friction;
mod inverse;
mod jacobian;
mod joint;
mod joint_reader;
mod key_lines;
mod kinematic_chain;
mod limits;
mod linuxcnc_ini;
mod machine;
mod machine_reader;
mod mass;
mod model;
mod pairs;
mod pairs_reader;
mod platform;
mod platform_reader;
mod poles;
mod program_zero;
mod reading;
mod solver;
mod spindle;
mod structure;
mod summary;
mod table;
#[cfg(test)]
mod testing;
mod turn_shift;
mod units;
mod urdf;
mod zero_at_home;

pub use attachment::Attachment;
pub use description::machine_schema;
pub use diagnose::{Diagnosis, MissingLimit, RemarkSeverity};
pub use drive::{Drive, ElasticMode, Encoder, VelocityGain};
pub use errors::{ConstantErrors, ErrorOf, ErrorTable, GeometricErrors};
pub use inverse::{AXIS_TOLERANCE, Branch, Branches, KinematicsError, Solution, TIP_TOLERANCE};
pub use jacobian::Jacobian;
pub use joint::{Carries, Joint, JointKind, JointValues, MAX_JOINTS};
pub use limits::{LimitKind, LimitViolation, Limited, MotionState};
pub use linuxcnc_ini::{ImportedMachine, import_linuxcnc_ini};
pub use machine::{Control, ControlKinematics, Machine, MachineBody, RapidMode, Trust};
pub use mass::BodyMass;
pub use pairs::{PairCare, PairRule, TOOL_PARTS};
pub use platform::{Leg, Platform, PlatformError};
pub use spindle::{SpindleData, TableData};
pub use table::{Direction, TableError, kinematics_csv};
pub use turn_shift::TurnShift;
pub use urdf::{UrdfOptions, import_urdf};
