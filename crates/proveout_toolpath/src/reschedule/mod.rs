//! Re-scheduling of tool orientations: contact points stay, tool axes and tips change.
//!
//! One file a method, with its paper and equation numbers in the header. A method implements [`Method`]: it gets a run of
//! cutting blocks ([`CuttingRun`]) and what is known about the surroundings ([`Surroundings`]), and gives a new pose for each
//! block and what a person may want to see of it ([`Picture`]). It keeps the number and order of blocks, so that feeds, tools
//! and the structure of the program stay.

mod channel;
mod corner;
mod error;
mod quaternion;
mod s_theta;
mod section;
mod taut;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_tool::Profile;

pub use channel::{Channel, exact_limits};
pub use corner::{Corner, CornerRule, Smoothed, ThetaUnit};
pub use error::RescheduleError;
pub use quaternion::{Quaternion, slerp};
pub use s_theta::{Plan, STHETA_DEFAULTS, STheta};
pub use section::{Layer, SectionPath};
pub use taut::{Gate, taut_string};

/// A block of a cutting run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingBlock {
    /// Tip and axis at the end of the block, frame of the workpiece.
    pub pose: ToolPose,
    /// Line of the block in its program, for messages.
    pub line: u32,
}

/// Blocks in feed without a rapid between them, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CuttingRun {
    /// The blocks.
    pub blocks: Vec<CuttingBlock>,
}

/// Where a tool touches a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Contact point, frame of the workpiece, mm.
    pub point: Point,
    /// Outward unit normal of the surface.
    pub normal: Vector,
    /// Principal curvatures, 1/mm, positive where the surface is convex, with their unit directions.
    pub curvatures: [(f64, Vector); 2],
}

/// A surface that answers where a tool touches it.
pub trait ContactSurface {
    /// The contact nearest to a point; none where the surface does not reach.
    fn contact(&self, near: &Point) -> Option<Contact>;
}

/// What a method may ask about.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// Cutting end of the tool.
    pub cutter: &'a Profile,
    /// Direction of the rotary table's axis in the frame of the workpiece, unit length: sections are cut across it.
    pub table_axis: Vector,
    /// The surface that is cut, for methods that need normals and curvatures.
    pub surface: Option<&'a dyn ContactSurface>,
}

/// A curve or a set of points to show.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What it is: `forward limit`, `key points`, ...
    pub name: &'static str,
    /// Arc length, mm, and angle, radian.
    pub points: Vec<[f64; 2]>,
}

/// What a method shows of its work in the plane of path length and angle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// The curves.
    pub curves: Vec<Curve>,
    /// Numbers by name, with their unit in the name.
    pub figures: Vec<(&'static str, f64)>,
}

/// New poses, one for each block of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Rescheduled {
    /// The poses.
    pub poses: Vec<ToolPose>,
    /// What to show.
    pub picture: Picture,
}

/// A published method that re-plans tool orientations.
pub trait Method {
    /// Name on the command line and in scenes.
    fn name(&self) -> &'static str;
    /// The paper.
    fn source(&self) -> &'static str;
    /// New poses for a run.
    ///
    /// # Errors
    /// The method does not apply to this run, or has no solution: with the first block concerned and what would have to
    /// change.
    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError>;
}
