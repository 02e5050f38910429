use proveout_machine::JointValues;

/// Extremes of one joint over the run; mm or radian, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSummary {
    /// Lowest position.
    pub min: f64,
    /// Highest position.
    pub max: f64,
    /// Highest speed at a control sample.
    pub max_velocity: f64,
    /// Highest acceleration at a control sample.
    pub max_acceleration: f64,
    /// Highest jerk at a control sample.
    pub max_jerk: f64,
    /// Highest speed over its limit; none without a limit.
    pub velocity_utilisation: Option<f64>,
    /// Highest acceleration over its limit.
    pub acceleration_utilisation: Option<f64>,
    /// Highest jerk over its limit.
    pub jerk_utilisation: Option<f64>,
    /// Changes of the direction of motion.
    pub reversals: u32,
}

/// A joint with a missing limit, and which.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnlimitedJoint {
    /// Name of the joint.
    pub joint: String,
    /// No limit of velocity.
    pub velocity: bool,
    /// No limit of acceleration: the plan may step the velocity.
    pub acceleration: bool,
    /// No limit of jerk: the plan may step the acceleration.
    pub jerk: bool,
}

/// What the run took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Duration of the program, s.
    pub total_s: f64,
    /// Motion in feed, s.
    pub cutting_s: f64,
    /// Motion in rapid and handling, s.
    pub rapid_s: f64,
    /// Dwell and waiting for the spindle, s.
    pub dwell_s: f64,
    /// Tool changes without the motion to their position, s.
    pub tool_change_s: f64,
    /// No plan of the same paths under the same velocity and acceleration limits is shorter, s; standstill included.
    pub lower_bound_s: Option<f64>,
    /// Joints in machine order.
    pub joints: Vec<JointSummary>,
    /// Joints that lack limits.
    pub unlimited_joints: Vec<UnlimitedJoint>,
    /// Number of blocks.
    pub blocks: u64,
    /// Length of the tip's path, mm.
    pub length_mm: f64,
    /// Largest deviation of a piece from the motion that it stands for, mm.
    pub max_chord_error_mm: f64,
    /// Largest rounding of a corner, measured at the tip, mm; zero for [`crate::Dynamics::Ideal`].
    pub max_contour_error_mm: f64,
    /// Largest rounding of a corner in the plan, whatever the dynamics, mm.
    pub planned_contour_error_mm: f64,
    /// Lowest part of the programmed feed that joint limits allowed in the middle of a feed block.
    pub min_feed_ratio: Option<f64>,
    /// Final position of the joints.
    pub end_position: JointValues,
}
