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
    /// What the drive did; none where drives are not simulated.
    pub drive: Option<DriveUse>,
}

/// What a drive did over the run. Of the joints of a platform: what its legs together did to the joint; the
/// part of the limit is that of the most loaded leg, for both joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveUse {
    /// Largest distance of the load from the set point at a control sample, mm or radian.
    pub max_following_error: f64,
    /// Largest force (N) or torque (N mm) at a control sample.
    pub max_force: f64,
    /// The same over the limit of the drive; none where no limit is stated.
    pub force_utilisation: Option<f64>,
    /// Largest mechanical power to either side, W.
    pub max_power: f64,
    /// Work drawn, J, without what braking gives back.
    pub energy: f64,
}

/// How far the forces of the drives can be trusted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadTrust {
    /// Bodies whose mass, center or inertia was found from their shape.
    pub estimated: Vec<String>,
    /// Joints without known weight and coupling, and why.
    pub unknown: Vec<(String, String)>,
    /// Joints whose drive states no limit of force: saturation is not seen there.
    pub no_force_limit: Vec<String>,
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
///
/// ```
/// use proveout_controller::{Controller, Settings};
/// use proveout_machine::Machine;
/// use proveout_nc::Program;
///
/// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
/// let text = "G21\nG4 P750\nM30\n"; // 750 ms
/// let program = Program::from_text("part.nc", text, &proveout_nc::Settings::default())?;
/// let mut controller = Controller::new(program, &machine, &[], Settings::default())?;
/// while controller.next_chunk()?.is_some() {}
/// let summary = controller.summary();
/// assert!((summary.dwell_s - 0.75).abs() < 1e-9 && (summary.total_s - 0.75).abs() < 1e-9);
/// assert_eq!(summary.end_position, machine.home());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    /// No motion within the tolerances of the path takes less, s, whatever path it takes and
    /// whatever control makes it: at the same feeds, velocities and accelerations of the joints,
    /// stopping where the program stops; standstill included.
    pub lower_bound_s: Option<f64>,
    /// No motion along the path that is run (with these roundings of its corners) takes less, s: under the
    /// same feeds, velocities and accelerations; standstill included. Another rounding within the tolerance
    /// may be faster.
    pub path_bound_s: Option<f64>,
    /// Joints in machine order.
    pub joints: Vec<JointSummary>,
    /// Joints that lack limits.
    pub unlimited_joints: Vec<UnlimitedJoint>,
    /// Number of blocks.
    pub blocks: u64,
    /// Length of the tip's path that is run, with its corners rounded, mm.
    pub length_mm: f64,
    /// Largest deviation of a piece from the motion that it represents, mm.
    pub max_chord_error_mm: f64,
    /// Largest distance of the tip (without tool center point control, of the linear joints together) from
    /// the programmed way, mm: measured against the words of the program, at the ends and middles of all
    /// pieces, and no less than the bound of the rounding; with drives, plus their part in feed.
    pub max_contour_error_mm: f64,
    /// Largest angle between the tool axis and the programmed one at the same share of the block's way,
    /// radian: measured in the same places; with drives, plus their part in feed.
    pub max_axis_error: f64,
    /// Largest distance of the actual tip from the planned path, at the control samples in feed, mm; none
    /// without drives. Part of `max_contour_error_mm`, which bounds the distance from the programmed path by
    /// the sum.
    pub max_servo_contour_error_mm: Option<f64>,
    /// Trust in the drives' forces; none where drives are not simulated.
    pub loads: Option<LoadTrust>,
    /// Largest rounding of a corner in the plan, whatever the dynamics, mm.
    pub planned_contour_error_mm: f64,
    /// Lowest part of the programmed feed on the path that is run: that to which it falls between the ramps
    /// from and to standstills and rapid motions, at the control samples; the highest one of a motion in feed
    /// between them that does not reach its feed; and the most that the velocities of the joints allow in a
    /// feed block.
    pub min_feed_ratio: Option<f64>,
    /// Final position of the joints.
    pub end_position: JointValues,
}
