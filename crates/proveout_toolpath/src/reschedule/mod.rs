//! Re-scheduling of tool orientations: contact points stay, tool axes and tips change.
//!
//! One file a method, with its paper and equation numbers in the header. A method implements [`Method`]: it gets a run of
//! cutting blocks ([`CuttingRun`]) and what is known about the surroundings ([`Surroundings`]), and gives a new pose for each
//! block and what a person may want to see of it ([`Study`]). It keeps the number and order of blocks, so that feeds, tools
//! and the structure of the program stay.

mod certificate;
mod channel;
mod corner;
mod error;
mod min_angular_acceleration;
mod quaternion;
mod s_theta;
mod section;
mod singularity;
mod study;
mod taut;

use std::ops::Range;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_tool::Profile;

pub use certificate::{Certificate, JointGates, Proof, Schedules, SchedulesError, SwingLimits};
pub use channel::{Channel, exact_limits};
pub use corner::{Corner, CornerRule, Smoothed, ThetaUnit};
pub use error::RescheduleError;
pub use min_angular_acceleration::{MinAngularAcceleration, between_keys, capped, inflections};
pub use quaternion::{Quaternion, slerp};
pub use s_theta::{Plan, STHETA_DEFAULTS, STheta};
pub use section::{Layer, SectionPath};
pub use singularity::{Junction, PoleAngles, PoleStretch, Singularity, between, fitted, pole_angles};
pub use study::{Curve, CurveKind, Figure, Quantity, Study};
pub use taut::{Gate, taut_string};

/// A block of a cutting run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingBlock {
    /// Tip and axis at the end of the block, in the frame of the run (the table's frame for a program under tool center point
    /// control).
    pub pose: ToolPose,
    /// Line of the block in its program, for messages.
    pub line: u32,
    /// Time that the programmed feed gives to the block, s; none for the first block of a run and where the program has told
    /// no feed. Methods that weigh joint speeds need it.
    pub time: Option<f64>,
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
    /// Contact point, frame of the run, mm.
    pub point: Point,
    /// Outward unit normal of the surface.
    pub normal: Vector,
    /// Principal curvatures, 1/mm, positive where the surface is convex, with their unit directions; the larger one first.
    pub curvatures: [(f64, Vector); 2],
}

/// A surface that answers where a tool touches it.
pub trait ContactSurface {
    /// The contact nearest to a point; none where the surface does not reach.
    fn contact(&self, near: &Point) -> Option<Contact>;
}

/// Which poses of the tool are free of interference: the feasible region of tool axes at a contact point is where the
/// clearance is positive.
pub trait FeasibleRegion {
    /// Smallest distance of shank, neck and holder from what they must not touch, mm; zero or less where they do. The cutting
    /// end, which touches the surface that it cuts, does not count.
    fn clearance(&self, pose: &ToolPose) -> f64;
}

/// What a method may ask about. Everything is in the frame of the run.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// Cutting end of the tool.
    pub cutter: &'a Profile,
    /// Direction of the rotary table's axis, unit length: sections are cut across it.
    pub table_axis: Vector,
    /// The machine that will run the poses, for methods that look at rotary axes, their ranges and singularities.
    pub machine: Option<&'a Machine>,
    /// The surface that is cut, for methods that need normals and curvatures.
    pub surface: Option<&'a dyn ContactSurface>,
    /// What the tool must not touch, for methods that need feasible regions.
    pub region: Option<&'a dyn FeasibleRegion>,
}

impl<'a> Surroundings<'a> {
    /// A cutter and a table axis; nothing else is known.
    pub fn new(cutter: &'a Profile, table_axis: Vector) -> Self {
        Self { cutter, table_axis, machine: None, surface: None, region: None }
    }
}

/// The angles about an axis of the frame that a tool axis may take while its inclination to that axis stays.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnChannel {
    /// The axis; angles grow right-handed about it.
    pub axis: Vector,
    /// Smallest and largest angle at each block of the stretch, radian.
    pub limits: Vec<[f64; 2]>,
    /// The angles that the method has chosen.
    pub angles: Vec<f64>,
}

/// New poses, one for each block of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Rescheduled {
    /// The poses.
    pub poses: Vec<ToolPose>,
    /// The blocks that were planned anew: without lead-in and lead-out, which only follow their ends.
    pub stretch: Range<usize>,
    /// Positions of the rotary joints at each block, where the poses do not tell them (at a pole); programs that give tool vectors
    /// cannot say them.
    pub rotary: Option<Vec<JointValues>>,
    /// What other schedules were possible; none where the method knows no channel of one angle.
    pub channel: Option<TurnChannel>,
    /// What to show.
    pub study: Study,
}

/// A published method that re-plans tool orientations.
pub trait Method {
    /// Name on the command line and in scenes.
    fn name(&self) -> &'static str;
    /// The paper.
    fn source(&self) -> &'static str;
    /// Whether the method asks for [`Surroundings::region`], which costs meshes and search trees to make.
    fn needs_region(&self) -> bool {
        false
    }
    /// New poses for a run.
    ///
    /// # Errors
    /// The method does not apply to this run, or has no solution: with the first block concerned and what would have to
    /// change.
    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError>;
}
