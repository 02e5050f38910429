use schemars::JsonSchema;
use serde::Deserialize;

use crate::servo::Plant;

/// Which motion cuts the stock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Dynamics {
    /// The programmed path without corner rounding, at the planned times.
    Ideal,
    /// The set points of the control: corners rounded within the tolerance.
    #[default]
    Planned,
    /// What the drives make of the set points; the machine must describe its drives.
    Servo,
}

/// How the control is set up, where neither program nor machine say it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Motion of the tool.
    pub dynamics: Dynamics,
    /// What moves under the forces of the drives, for [`Dynamics::Servo`].
    pub plant: Plant,
    /// Rounding of corners where the program states none, mm; none: as the machine's control.
    pub default_tolerance: Option<f64>,
    /// Rounding of the orientation where the program states none, radian; none: as the machine's control,
    /// else [`Self::orientation_tolerance`].
    pub default_orientation_tolerance: Option<f64>,
    /// Cone about a pole of the rotary axes inside of which the tool axis may leave its great circle, radian;
    /// none: as the machine's control.
    pub pole_cone: Option<f64>,
    /// Allowed deviation of a [`crate::Piece`] at the cutting edges, mm.
    pub piece_tolerance: f64,
    /// The same for the rest of the tool up to the gauge line, mm: what it is checked against are distances,
    /// to which the deviation of each piece is added; and what turns by an angle moves there by many times of
    /// what the edges do.
    pub piece_body_tolerance: f64,
    /// Longest [`crate::Piece`], mm.
    pub piece_length: f64,
    /// Largest turn of the tool axis or of a rotary joint within a [`crate::Piece`], radian.
    pub piece_angle: f64,
    /// Control cycle, s; none: that of the machine.
    pub sample_time: Option<f64>,
    /// Motion in feed waits until the spindle has reached its speed, and a tool change until it has
    /// stopped (time from the machine); rapid motion goes on meanwhile.
    pub spindle_waits: bool,
    /// The length of a new tool counts without a word of the program (840D: `$MC_CUTTING_EDGE_DEFAULT`; not
    /// on controls that want G43).
    pub length_active_after_change: bool,
    /// The active tool length counts in machine coordinates too (840D: programs write D0 with
    /// SUPA); false where the control leaves it out of them (TNC: M91, M92). ISO controls leave it
    /// out as well, and their reader says so block by block.
    pub length_in_machine_coordinates: bool,
    /// Number of the tool in the spindle before the first block, as the operator has left it there; none: the
    /// spindle is empty.
    pub start_tool: Option<u32>,
    /// An event reports a block that joint limits keep below this part of its programmed feed.
    pub feed_reduced_below: f64,
    /// Simulated time at which a program is ended, s.
    pub max_time: f64,
    /// Number of blocks that the control looks ahead before it must plan a part of a run without stops.
    pub look_ahead_blocks: usize,
}

impl Settings {
    /// Default limit of the simulated time of a program, s: a hundred hours.
    pub const MAX_TIME: f64 = 360_000.0;

    /// Largest default rounding of the orientation, radian (0.05 degrees): the usual one of
    /// finishing.
    pub const FALLBACK_ORIENTATION_TOLERANCE: f64 = 0.05 * std::f64::consts::PI / 180.0;

    /// Default rounding of the orientation, radian, from that of the tip and the distance from the
    /// tip to the end of the cutting edges, mm. The angle times this distance is how far the flank
    /// moves; it must be no more than the tip may move. A fixed angle would not do: 0.05 degrees
    /// move a flank of 39 mm by 34 um, three times the tolerance of a usual finishing cut. Short
    /// edges get [`Self::FALLBACK_ORIENTATION_TOLERANCE`]: above it nothing is gained but time.
    ///
    /// ```
    /// use proveout_controller::Settings;
    ///
    /// // 0.01 mm where the cutting edges end, 40 mm from the tip.
    /// assert!((Settings::orientation_tolerance(0.01, 40.0) - 0.000_25).abs() < 1e-12); // radian
    /// // Edges of 2 mm would allow 0.29 degrees: the usual angle is less.
    /// let usual = 0.05_f64.to_radians();
    /// assert!((Settings::orientation_tolerance(0.01, 2.0) - usual).abs() < 1e-12);
    /// ```
    pub fn orientation_tolerance(tip: f64, reach: f64) -> f64 {
        if reach > 0.0 {
            (tip / reach).min(Self::FALLBACK_ORIENTATION_TOLERANCE)
        } else {
            Self::FALLBACK_ORIENTATION_TOLERANCE
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dynamics: Dynamics::Planned,
            plant: Plant::NewtonEuler,
            default_tolerance: None,
            default_orientation_tolerance: None,
            pole_cone: None,
            piece_tolerance: 0.0005,
            piece_body_tolerance: 0.004,
            piece_length: 50.0,
            piece_angle: 1.0_f64.to_radians(),
            sample_time: None,
            spindle_waits: true,
            length_active_after_change: true,
            length_in_machine_coordinates: true,
            start_tool: None,
            feed_reduced_below: 0.5,
            max_time: Self::MAX_TIME,
            look_ahead_blocks: 2000,
        }
    }
}
