//! Paths over blades and other sides of parts: where the cutter touches, its pose there, and what the machine
//! needs for it.
//!
//! Data in: a surface, a cutter, a strategy and a rule of the tool axis. Data out: contacts with tool poses,
//! side steps and scallops. Everything is in the frame of the surface, in mm and radian. No control and no NC
//! program is known here.
//!
//! ```text
//!   ParametricSurface ─► Strategy ─► lines in the parameter plane ─► Sampler ─► contacts ─► Setting::judge
//!   (proveout_blade)     where       (cubic splines u(t), v(t))      chord      tip, axis   joints, feed,
//!                        to go                                       error, axis            pole distance
//! ```
//!
//! * [`Task`] – surface, cutter, axis rule and step; [`Task::plan`] makes the contacts of a [`Strategy`].
//! * [`QuasiCircle`], [`IsoParametric`], [`Transverse`], [`IsoPlanar`], [`ConstantScallop`], [`Row`],
//!   [`Pocket`], [`PointRoughing`], [`Flank`] – strategies.
//! * [`PathCutter`] – from contact to cutter location for any convex cutter; [`AxisRule`] – the tool axis at
//!   a contact.
//! * [`side_step`], [`scallop_height`] – exact formulas of ridges between two cuts; [`envelope_across`] – the
//!   curvature that a moving cutter leaves across its feed.
//! * [`Setting::judge`] – what a path asks of a machine, before it runs.
//! * [`HelicalPass`] – a ball end mill round a blade, as a CAM system posts it.
//!
//! ```
//! use proveout_blade::{ClosedSurface, Sine};
//! use proveout_path::{AxisRule, PathCutter, Spacing, StepRule, Task, Transverse};
//! use proveout_tool::Cutter;
//!
//! let face = ClosedSurface::new(Sine::gentle()); // 30 mm wide, two waves of 40 mm
//! let ball = PathCutter::new(Cutter::ball(6.0)?.bodies(20.0)?.remove(0)); // diameter and length, mm
//! let (rule, step) = (AxisRule::Normal, StepRule::Length(1.0));
//! let task = Task { surface: &face, cutter: &ball, rule: &rule, step, allowance: 0.0 };
//! let spacing = Spacing::At(vec![0.25]); // along the first crest
//! let plan = task.plan(&Transverse { round: [0.1, 0.9], range: [0.0, 1.0], spacing, one_way: true })?;
//! let last = plan[0].contacts.last().expect("a line has contacts");
//! assert!((last.length - 24.0).abs() < 1e-9); // 0.8 of the width, mm
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//!
//! Chord errors are measured at the middle and the quarters of every step, under a bound by curvature.
//! Scallops are computed by the osculating circles across the feed. Both are figures of the plan; a run of
//! the program proves them. The run also shows whether shank and holder are free, and whether the cutter
//! touches elsewhere.
//!
//! | file | holds |
//! |---|---|
//! | `strategy.rs` | [`Task`], [`Strategy`], spacing of lines by their scallop |
//! | `families.rs`, `sections.rs`, `polar_angle.rs` | lines along and round a blade |
//! | `iso_planar.rs`, `constant_scallop.rs`, `row.rs` | lines in planes, of one scallop height, one row |
//! | `pocket.rs`, `point_roughing.rs`, `flank.rs` | rings, layers from solid, side milling |
//! | `curve.rs` | lines as splines in the parameter plane |
//! | `place.rs`, `sample.rs` | a point of a line with its curvatures; contacts along a line |
//! | `cutter.rs`, `axis_rule.rs` | cutter location and tool axis of a contact |
//! | `scallop.rs` | side step and scallop height |
//! | `link.rs` | motions from line to line |
//! | `judge.rs` | joints, rates and feed that a path needs |
//! | `helix.rs` | [`HelicalPass`] |
//! | `error.rs` | [`PathError`] |

mod axis_rule;
mod constant_scallop;
mod curve;
mod cutter;
mod error;
mod families;
mod flank;
mod helix;
mod iso_planar;
mod judge;
mod link;
mod place;
mod pocket;
mod point_roughing;
mod polar_angle;
mod row;
mod sample;
mod scallop;
mod sections;
mod strategy;

pub use axis_rule::AxisRule;
pub use constant_scallop::ConstantScallop;
pub use curve::{CurvePoint, Line, ParameterCurve, Spline};
pub use cutter::{CutterTouch, PathCutter, envelope_across};
pub use error::{BladeLocation, MOST_POINTS, PathError};
pub use families::{IsoParametric, QuasiCircle, Transverse};
pub use flank::{Flank, FlankError, Ruling, Rulings};
pub use helix::{HelicalPass, PassError, PassPoint};
pub use iso_planar::IsoPlanar;
pub use judge::{Extreme, JointDemand, PathJudgement, Setting};
pub use link::{LinkRule, Move, linked};
pub use place::{Form, PathPoint};
pub use pocket::Pocket;
pub use point_roughing::PointRoughing;
pub use polar_angle::{ContourSide, PolarPoint, polar_point};
pub use row::Row;
pub use sample::{LineContacts, PathContact, Sampler, StepRule};
pub use scallop::{scallop_height, side_step};
pub use sections::{BladeLoop, Label, SECTIONS, Sections};
pub use strategy::{OneWay, Spacing, Strategy, Task};
