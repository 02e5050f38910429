use std::sync::Arc;

use proveout_geom::ToolPose;
use proveout_machine::{JointValues, MAX_JOINTS};
use proveout_nc::{Contact, Coolant, Location, Note, Overcut, SpindleDirection};

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MoveKind {
    /// Positioning at rapid rate.
    Rapid,
    /// Motion in programmed feed.
    Feed,
    /// Motion that the control makes by itself: to and from the tool change position.
    Handling,
}

/// A part of the tool's motion for removal and interference checks.
///
/// The tip runs straight and the axis on the great circle, both uniformly, from `pose[0]` to `pose[1]`; no
/// point of the tool between tip and gauge line is further than `deviation` from its true place. Times are
/// those of the plan, in which the motion within a piece is generally not uniform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Begin and end, s.
    pub time: [f64; 2],
    /// Index of the [`BlockRecord`].
    pub block: u32,
    /// Purpose.
    pub kind: MoveKind,
    /// Joint positions at both ends, mm and radian.
    pub joints: [JointValues; 2],
    /// Tip and axis in the table frame K at both ends.
    pub pose: [ToolPose; 2],
    /// Bound of the deviation of any point of the tool, mm.
    pub deviation: f64,
    /// The same of any point of the cutting edges, mm: no more than [`Self::deviation`].
    pub edge_deviation: f64,
    /// Bound of the deviation of each joint from the straight motion between the positions at both ends, mm
    /// and radian: at every moment the joints are so near to one and the same place of it. A joint that turns
    /// back within the piece is held by it, too.
    pub joint_deviation: JointValues,
    /// Places of the joints within the piece; none where they go straight, or turn a corner in it.
    pub finer: Option<FinerMotion>,
}

/// Where the joints are at the quarters of a piece, and how far they leave the straight ways between these: a
/// sixteenth of what they leave the piece by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinerMotion {
    /// At one, two and three quarters of the straight way of the piece: offset of the joints from
    /// it, mm and radian.
    pub beside: [[f32; MAX_JOINTS]; 3],
    /// As [`Piece::joint_deviation`], of the ways between.
    pub joint_deviation: [f32; MAX_JOINTS],
}

impl FinerMotion {
    /// Joint positions at the quarters of a piece with these ends, and the bound of the deviation from the
    /// ways between.
    pub fn places(&self, [from, to]: &[JointValues; 2]) -> ([JointValues; 3], JointValues) {
        let of = |k: usize| {
            let mut q = from.interpolated(*to, 0.25 * (k + 1) as f64);
            (0..MAX_JOINTS).for_each(|j| q[j] += f64::from(self.beside[k][j]));
            q
        };
        let mut off = JointValues::ZERO;
        (0..MAX_JOINTS).for_each(|j| off[j] = f64::from(self.joint_deviation[j]));
        ([of(0), of(1), of(2)], off)
    }
}

/// The state at one cycle of the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the start of the program, s.
    pub time: f64,
    /// Index of the [`BlockRecord`].
    pub block: u32,
    /// Length of the path that was run so far, mm (blocks of rotary motion alone: degrees).
    pub path_length: f64,
    /// Set point of each joint, mm and radian.
    pub commanded: JointValues,
    /// First derivative of the set point by time.
    pub velocity: JointValues,
    /// Second derivative.
    pub acceleration: JointValues,
    /// Third derivative.
    pub jerk: JointValues,
    /// Where the joint is after the axis dynamics in force.
    pub actual: JointValues,
    /// Tip and axis in the table frame K that belong to `actual`.
    pub pose: ToolPose,
    /// Programmed feed, mm/s; zero in rapid motion and at standstill.
    pub feed_programmed: f64,
    /// Feed along the planned path in fact, with its corners rounded, mm/s (blocks of rotary motion alone:
    /// degrees a second).
    pub feed: f64,
    /// Purpose.
    pub kind: MoveKind,
    /// What the drives do; none where they are not simulated.
    pub drive: Option<DriveSample>,
}

/// The drives at one cycle of the control. Of the joints of a platform, whose drives move legs: what the legs
/// together do to the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveSample {
    /// Actual velocity of the load, mm/s and radian/s.
    pub velocity: JointValues,
    /// Force or torque of the motor, N and N mm.
    pub force: JointValues,
    /// Mechanical power of the motor, W; below zero while it brakes.
    pub power: JointValues,
    /// Work that the motor has drawn since the start, J; what braking gives back is not taken off.
    pub energy: JointValues,
}

/// What passed its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LimitKind {
    /// Position outside of the joint's travel.
    Travel,
    /// The spindle turns faster than spindle or tool allow; the value is in 1/min.
    SpindleSpeed,
    /// The control asks the drive for more force (N) or torque (N mm) than it has; it gives its most, and the
    /// joint leaves its set point.
    DriveForce,
    /// The set points ask a joint for more velocity than it has, by more than 0.1 percent.
    Velocity,
    /// The same of its acceleration.
    Acceleration,
    /// The same of its jerk.
    Jerk,
}

/// Something that happens at a time.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A tool is in the spindle.
    ToolChange {
        /// When the change ends, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Index of the tool in the library; none for an empty spindle.
        tool: Option<usize>,
    },
    /// The spindle gets a new state.
    Spindle {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Direction.
        direction: SpindleDirection,
        /// Speed, 1/min; zero when off.
        speed_rpm: f64,
    },
    /// Coolant gets a new state.
    Coolant {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// State.
        coolant: Coolant,
    },
    /// Text of the program for the operator.
    Message {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Text.
        text: String,
    },
    /// A word without effect on the twin, or an assumption, as the reader names it.
    Note {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Text.
        text: Note,
    },
    /// The compensated path enters its own contour, named by the reader.
    Overcut {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`] after the compensated stretch.
        block: u32,
        /// Block that the tool follows there.
        location: Location,
        /// What is cut, and how deep.
        overcut: Box<Overcut>,
    },
    /// Wait.
    Dwell {
        /// Begin, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Length, s.
        duration: f64,
    },
    /// Program stop; the twin goes on at once.
    Stop {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// True for an optional stop.
        optional: bool,
    },
    /// End of the program.
    End {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
    },
    /// The control ends the program by itself, since nothing that follows would be true: nothing of it is
    /// executed.
    Ended {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// The block that is not executed any more.
        location: Location,
        /// Why, with value and limit.
        reason: String,
    },
    /// A limit is passed; the motion is executed as programmed (where a drive lacks force, as far as it can
    /// follow). One event a block and joint, with the worst value.
    Limit {
        /// Time of the worst value, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Joint; none for the spindle.
        joint: Option<usize>,
        /// Worst value, mm, radian, 1/min, N or N mm.
        value: f64,
        /// The limit that it passes.
        limit: f64,
        /// What passed.
        kind: LimitKind,
    },
    /// No joint positions reach a programmed tool axis; the rotary joints stay where they are.
    UnreachablePose {
        /// Time, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// The pose, in the table frame K.
        pose: ToolPose,
        /// Words of the kinematics.
        reason: String,
    },
    /// The tool axis leaves the great circle that the program asks for.
    LeavesCircle {
        /// Start of the motion, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Largest angle between the tool axis and the circle, radian.
        angle: f64,
        /// The way of the end of the cutting edges for this angle, mm.
        at_flank: f64,
        /// Inside of the cone about a pole where the control may; otherwise the rotary axes run in proportion
        /// instead.
        in_cone: bool,
        /// Why.
        reason: String,
    },
    /// A probing motion; where nothing is known of its contact, it runs to its programmed end.
    Probe {
        /// Start of the motion, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// What is known of its end.
        contact: Contact,
        /// The spindle turns.
        spindle_turns: bool,
    },
    /// Joint limits keep the feed of a whole block below a part of the programmed one.
    FeedReduced {
        /// Start of the block, s.
        time: f64,
        /// Index of the [`BlockRecord`].
        block: u32,
        /// Highest feed that the joints allow in the block's middle over the programmed feed.
        ratio: f64,
        /// The joint that limits.
        joint: Option<usize>,
    },
}

impl Event {
    /// When it happens, s.
    pub fn time(&self) -> f64 {
        match self {
            Self::ToolChange { time, .. }
            | Self::Spindle { time, .. }
            | Self::Coolant { time, .. }
            | Self::Message { time, .. }
            | Self::Note { time, .. }
            | Self::Overcut { time, .. }
            | Self::Dwell { time, .. }
            | Self::Stop { time, .. }
            | Self::End { time, .. }
            | Self::Ended { time, .. }
            | Self::Limit { time, .. }
            | Self::UnreachablePose { time, .. }
            | Self::LeavesCircle { time, .. }
            | Self::Probe { time, .. }
            | Self::FeedReduced { time, .. } => *time,
        }
    }

    /// Index of the [`BlockRecord`] that it belongs to.
    pub fn block(&self) -> u32 {
        match self {
            Self::ToolChange { block, .. }
            | Self::Spindle { block, .. }
            | Self::Coolant { block, .. }
            | Self::Message { block, .. }
            | Self::Note { block, .. }
            | Self::Overcut { block, .. }
            | Self::Dwell { block, .. }
            | Self::Stop { block, .. }
            | Self::End { block, .. }
            | Self::Ended { block, .. }
            | Self::Limit { block, .. }
            | Self::UnreachablePose { block, .. }
            | Self::LeavesCircle { block, .. }
            | Self::Probe { block, .. }
            | Self::FeedReduced { block, .. } => *block,
        }
    }
}

/// What a block does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BlockKind {
    /// Motion.
    Move(MoveKind),
    /// Waiting.
    Dwell,
    /// Tool change.
    ToolChange,
    /// Spindle, messages, stops: no motion.
    Action,
}

/// One command of the program that takes time or causes an event.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRecord {
    /// Running number in the order of execution, from 0.
    pub index: u32,
    /// File.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Begin, s.
    pub start_time: f64,
    /// End, s.
    pub end_time: f64,
    /// Length of the path that is run, mm (rotary motion alone: degrees): shorter than the programmed one
    /// where corners are rounded.
    pub length: f64,
    /// Length of the programmed path, in the same unit.
    pub programmed_length: f64,
    /// Programmed feed, mm/s; zero for rapid motion and without motion.
    pub feed: f64,
    /// The path runs in proportion to the angle of the spindle (rigid tapping, thread cutting).
    pub coupled: bool,
    /// Where the programmed path ends, without rounding of corners: joints, and the tool in the table frame;
    /// none without motion.
    pub programmed_end: Option<(JointValues, ToolPose)>,
    /// What it does.
    pub kind: BlockKind,
}

/// A stretch of the run, everything in the order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chunk {
    /// Motion.
    pub pieces: Vec<Piece>,
    /// Control samples on the grid of the control cycle; a standstill has only its first and last.
    pub samples: Vec<Sample>,
    /// Events.
    pub events: Vec<Event>,
    /// Blocks that ended.
    pub blocks: Vec<BlockRecord>,
}
