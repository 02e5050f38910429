//! Paths over blades and other sides of parts: where the cutter touches, its pose there, and what
//! the machine needs for it.
//!
//! ```text
//!   ParametricSurface ──► Strategy ──► lines in the parameter plane ──► Sampler ──► contacts ──► Setting::judge
//!   (proveout_geom)       where        (cubic splines u(t), v(t))       chord       tip, axis     joints, feed,
//!                         to go                                         error, axis               distance to poles
//! ```
//!
//! * [`Task`] – surface, cutter, axis rule and step; [`Task::plan`] makes the contacts of a [`Strategy`].
//! * [`QuasiCircle`], [`IsoParametric`], [`Transverse`], [`IsoPlanar`], [`ConstantScallop`], [`Row`], [`Pocket`], [`PointRoughing`],
//!   [`Flank`] – strategies.
//! * [`PathCutter`] – from contact to cutter location for any convex cutter; [`AxisRule`] – the
//!   tool axis at a contact.
//! * [`side_step`], [`scallop_height`] – exact formulas of ridges between two cuts; [`envelope_across`] – the curvature that a moving
//!   cutter leaves across its feed.
//! * [`Setting::judge`] – what a path asks of a machine, before it runs.
//!
//! Everything is in the frame of the surface, mm and radian. Chord errors are measured at the
//! middle and the quarters of every step under a bound by curvature, scallops are computed by the
//! osculating circles across the feed. Both are figures of the plan; a run of the program proves
//! them. That shank and holder are free, and that the cutter touches nowhere else, is for the run
//! to show as well.

mod axis_rule;
mod constant_scallop;
mod curve;
mod cutter;
mod error;
mod families;
mod flank;
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
