//! A re-scheduled program compared with its source, as observers get it.

use std::ops::Range;

use proveout_geom::ToolPose;

use crate::observe::study::{Role, StudyFigure};

/// A re-scheduled program compared with the one before.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    /// The method.
    pub method: String,
    /// The paper that it is from.
    pub source: String,
    /// Name of the program before.
    pub from: String,
    /// The runs that were re-scheduled; those whose blocks are not in both motions are left out.
    pub runs: Vec<ScheduledRun>,
    /// Why nothing is known of the motion, where it is not.
    pub unknown: Option<String>,
}

/// One run of it.
#[derive(Clone, Debug)]
pub struct ScheduledRun {
    /// The blocks.
    pub blocks: Vec<ScheduledBlock>,
    /// The blocks, by their place, that were re-planned: without lead-in and lead-out.
    pub stretch: Range<usize>,
    /// What is asked of the joints, in the order of the machine.
    pub joints: Vec<ScheduledJoint>,
    /// Curves of the method.
    pub curves: Vec<MethodCurve>,
    /// Numbers of the method.
    pub figures: Vec<StudyFigure>,
    /// Time and bound, or why there is none.
    pub bound: Result<ScheduleBound, String>,
}

/// A block at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScheduledBlock {
    /// When the new program ends it, s.
    pub time: f64,
    /// Way of the ball center, or of the tip, since the begin of the run, mm.
    pub way: f64,
    /// Pose before and after, table frame K; with a ball its center in the place of the tip, which is the
    /// same in both.
    pub poses: [ToolPose; 2],
}

/// A joint over the blocks of a run; mm or radian, s. Not a number where nothing is known.
#[derive(Clone, Debug, PartialEq)]
pub struct ScheduledJoint {
    /// Place in the machine.
    pub joint: usize,
    /// Lowest and highest position over the blocks of the stretch; none where the joint has no choice or the
    /// method knows no channel.
    pub channel: Option<Vec<[f64; 2]>>,
    /// Program before.
    pub original: Demand,
    /// New program.
    pub new: Demand,
}

/// What a program asks of a joint at the ends of its blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demand {
    /// Positions.
    pub position: Vec<f64>,
    /// At the programmed feed.
    pub velocity: Vec<f64>,
    /// At the programmed feed.
    pub acceleration: Vec<f64>,
}

/// A curve of the method that lies along the path.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodCurve {
    /// What it is.
    pub name: String,
    /// How it is meant.
    pub role: Role,
    /// What is drawn, with its unit.
    pub quantity: [String; 2],
    /// Place among the blocks of the run, between two of them as a fraction, and value.
    pub points: Vec<[f64; 2]>,
}

/// How far the stretch is from the best schedule, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScheduleBound {
    /// Time of the new program.
    pub time: f64,
    /// Time of the program before.
    pub original_time: f64,
    /// No schedule of the channel is below.
    pub bound: f64,
    /// How much longer the new program takes, percent of the bound; none where it leaves the channel.
    pub gap_percent: Option<f64>,
}
