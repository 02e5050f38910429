//! Re-scheduling of tool orientations: contact points stay, tool axes and tips change.
//!
//! Data in: cutting blocks of a program ([`CuttingRun`]) and what is around them ([`Surroundings`]). Data
//! out: a pose for each block ([`Rescheduled`]), curves for people ([`Study`]), and a lower bound of the time
//! of every schedule ([`Schedules`]). Lengths are in mm, times in s, angles in radian. Poses are in the frame
//! of the run, which is that of the table for a program under tool center point control.
//!
//! One file a method, with its paper and equation numbers in the header. A method implements [`Method`]. It
//! keeps the number and order of blocks, so that feeds, tools and the structure of the program stay.
//!
//! ```
//! use proveout_geom::{Point, ToolPose, Vector};
//! use proveout_reschedule::{CuttingBlock, CuttingRun, slerp};
//!
//! // A tool that leans from z to x while it moves 1 mm a block.
//! let block = |k: u32| {
//!     let axis = slerp(&Vector::z(), &Vector::x(), f64::from(k) / 4.0);
//!     let pose = ToolPose { tip: Point::new(f64::from(k), 0.0, 0.0), axis };
//!     CuttingBlock { pose, line: k + 1, time: None }
//! };
//! let run = CuttingRun { blocks: (0..=4).map(block).collect() };
//! let half = std::f64::consts::FRAC_1_SQRT_2;
//! assert!((run.blocks[2].pose.axis - Vector::new(half, 0.0, half)).norm() < 1e-12);
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `s_theta.rs`, `section.rs`, `channel.rs`, `corner.rs`, `inset.rs` | the S-theta plane and its corners |
//! | `singularity/` | axes near the pole of the rotary table |
//! | `min_angular_acceleration/` | least angular acceleration along rows of a ball end mill |
//! | `multi_scale/` | strip, gouge and roughness of a bull-nose cutter |
//! | `smooth/` | the smoothest schedule of a channel; `smooth/rows/`: both rotary joints free |
//! | `quaternion.rs` | interpolation of key orientations, the baseline |
//! | `certificate/`, `taut.rs` | a bound of the time of every schedule; shortest path through gates |
//! | `tool_channel.rs`, `meeting.rs`, `touching.rs` | where the tool is free, where it touches |
//! | `blade_surface.rs` | [`BladeSurface`]: contacts on a blade |
//! | `band.rs` | symmetric positive definite matrices of few diagonals |
//! | `study.rs` | what a method shows |
//! | `error.rs` | [`RescheduleError`] |

pub use proveout_geom::AxisTurn;

mod band;
mod blade_surface;
mod certificate;
mod channel;
mod corner;
mod error;
mod inset;
mod meeting;
mod min_angular_acceleration;
mod multi_scale;
mod quaternion;
mod s_theta;
mod section;
mod singularity;
mod smooth;
mod study;
mod taut;
mod tool_channel;
mod touching;

use std::ops::Range;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_tool::Profile;

pub use blade_surface::BladeSurface;
pub use certificate::{
    AxisPair, Caps, CellBound, Certificate, FeedFloor, JointGates, LeastPeak, Proof, Schedules, SchedulesError,
    SwingLimits, peak_of,
};
pub use channel::{Channel, exact_limits};
pub use corner::{BezierCorner, CornerRule, SmoothedPolyline, ThetaUnit};
pub use error::RescheduleError;
pub use inset::SearchedInset;
pub use min_angular_acceleration::{
    Criterion, MinAngularAcceleration, between_keys, capped, inflections, true_minimum,
};
pub use multi_scale::{
    AxisEffect, BullNose, ContactFrame, CrossSection, Measurement, MultiScale, basis, critical,
    fitted as fitted_curves, leaned, mean_deviation, mean_line, value as curve_value,
};
pub use quaternion::{Quaternion, slerp};
pub use s_theta::{STHETA_DEFAULTS, STheta, ThetaPlan};
pub use section::{BlockLayer, SectionPath};
pub use singularity::{Junction, PoleAngles, PoleStretch, Singularity, between, fitted, pole_angles};
pub use smooth::{ChannelKind, RowEnds, Smooth, SmoothPlan, SmoothRows, TurnLimits};
pub use study::{ChannelWidth, Curve, CurveKind, Figure, KeptSchedule, Quantity, Study};
pub use taut::{TautGate, free_taut_string, taut_string};
pub use tool_channel::ToolChannel;

/// A block of a cutting run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CuttingBlock {
    /// Tip and axis at the end of the block, in the frame of the run (the table's frame for a program under
    /// tool center point control).
    pub pose: ToolPose,
    /// Line of the block in its program, for messages.
    pub line: u32,
    /// Time that the programmed feed gives to the block, s; none for the first block of a run and
    /// where no feed is programmed. Methods that weigh joint speeds need it.
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
pub struct ContactPoint {
    /// Contact point, frame of the run, mm.
    pub point: Point,
    /// Outward unit normal of the surface.
    pub normal: Vector,
    /// Principal curvatures, 1/mm, positive where the surface is convex, with their unit directions; the
    /// larger one first.
    pub curvatures: [(f64, Vector); 2],
}

/// A surface that answers where a tool touches it.
pub trait ContactSurface {
    /// The contact nearest to a point; none where the surface does not reach.
    fn contact(&self, near: &Point) -> Option<ContactPoint>;

    /// The same, with the nearest point of the rim for a point beyond it.
    fn nearest(&self, near: &Point) -> Option<ContactPoint> {
        self.contact(near)
    }
}

/// Which poses of the tool are free of interference: the feasible region of tool axes at a contact point is
/// where the clearance is positive.
pub trait FeasibleRegion {
    /// Smallest distance of shank, neck and holder from what they must not touch, mm; zero or less where they
    /// do. The cutting end, which touches the surface that it cuts, does not count.
    fn clearance(&self, pose: &ToolPose) -> f64;

    /// The same where it is below `most` (mm, above zero), else `most`: what is farther away need not be
    /// looked for.
    fn clearance_up_to(&self, pose: &ToolPose, most: f64) -> f64 {
        self.clearance(pose).min(most)
    }

    /// Angles of a turn at which the tool is free, proved: intervals `[from, to]` in radian,
    /// ascending and disjoint, `from` in -pi .. pi and `to` at most a turn above; `[-pi, pi]` if
    /// all are free. None if they are not known for this tool.
    fn free_turns(&self, turn: &AxisTurn) -> Option<Vec<[f64; 2]>> {
        let _ = turn;
        None
    }

    /// How far from the tip anything is that [`Self::clearance`] looks at, mm; none where that is not known.
    fn reach(&self) -> Option<f64> {
        None
    }
}

/// How long a control takes: the time law that a method may ask about.
pub trait TimeLaw {
    /// Time of every block of the run with these poses, s; of the first one, which comes from somewhere else,
    /// too. None where the control refuses the motion.
    fn block_times(&self, poses: &[ToolPose]) -> Option<Vec<f64>>;

    /// The same with positions of the rotary joints at the blocks, which poses at a pole do not
    /// determine.
    fn joint_times(&self, poses: &[ToolPose], rotary: Option<&[JointValues]>) -> Option<Vec<f64>> {
        let _ = rotary;
        self.block_times(poses)
    }
}

/// What a method may ask about. Everything is in the frame of the run.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// Cutting end of the tool.
    pub cutter: &'a Profile,
    /// Direction of the rotary table's axis, unit length: sections are cut across it.
    pub table_axis: Vector,
    /// The machine that will run the poses, for methods that look at rotary axes, their ranges and
    /// singularities.
    pub machine: Option<&'a Machine>,
    /// The surface that is cut, for methods that need normals and curvatures.
    pub surface: Option<&'a dyn ContactSurface>,
    /// What the tool must not touch, for methods that need feasible regions.
    pub region: Option<&'a dyn FeasibleRegion>,
    /// How long the control takes for new poses, for methods that are led by it.
    pub time_law: Option<&'a dyn TimeLaw>,
    /// The program gives tool vectors: what [`Rescheduled::rotary`] says cannot be written.
    pub vectors: bool,
    /// All runs of the original program, for methods that use the neighboring rows.
    pub rows: &'a [CuttingRun],
    /// Which of them this run is.
    pub row: usize,
}

impl<'a> Surroundings<'a> {
    /// A cutter and a table axis; nothing else is known.
    pub fn new(cutter: &'a Profile, table_axis: Vector) -> Self {
        Self {
            cutter,
            table_axis,
            machine: None,
            surface: None,
            region: None,
            time_law: None,
            vectors: false,
            rows: &[],
            row: 0,
        }
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
    /// The blocks that were planned again: without lead-in and lead-out, which only follow their
    /// ends.
    pub stretch: Range<usize>,
    /// Positions of the rotary joints at each block, where the poses do not determine them (at a
    /// pole); programs that give tool vectors cannot express them.
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
    /// The method does not apply to this run, or has no solution: with the first block concerned and what
    /// would have to change.
    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError>;
}
