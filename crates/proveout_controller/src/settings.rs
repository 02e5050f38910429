/// Which motion the tool makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dynamics {
    /// Exactly the programmed path, at the time law of the plan: corners are not rounded in the geometry.
    Ideal,
    /// The set points of the plan: corners rounded within the tolerance.
    #[default]
    Planned,
}

/// How the control is set up, where neither program nor machine say it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Motion of the tool.
    pub dynamics: Dynamics,
    /// Rounding of corners where program and machine state none, mm.
    pub default_tolerance: f64,
    /// Rounding of the orientation where program and machine state none, radian.
    pub default_orientation_tolerance: f64,
    /// Allowed deviation of a [`crate::Piece`], mm.
    pub piece_tolerance: f64,
    /// Longest [`crate::Piece`], mm.
    pub piece_length: f64,
    /// Largest turn of the tool axis or of a rotary joint within a [`crate::Piece`], radian.
    pub piece_angle: f64,
    /// Control cycle, s; none: that of the machine, else [`Self::FALLBACK_CYCLE`].
    pub sample_time: Option<f64>,
    /// Axis motion waits for the spindle to reach its speed (time from the machine).
    pub spindle_waits: bool,
    /// Joint limits that keep a block below this part of its programmed feed are told by an event.
    pub feed_reduced_below: f64,
    /// Number of blocks that the control looks ahead before it must plan a part of a run without stops.
    pub look_ahead_blocks: usize,
}

impl Settings {
    /// Control cycle where neither settings nor machine state one, s: usual for mid-size controls.
    pub const FALLBACK_CYCLE: f64 = 0.004;
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dynamics: Dynamics::Planned,
            default_tolerance: 0.01,
            default_orientation_tolerance: 0.05_f64.to_radians(),
            piece_tolerance: 0.0005,
            piece_length: 50.0,
            piece_angle: 1.0_f64.to_radians(),
            sample_time: None,
            spindle_waits: true,
            feed_reduced_below: 0.5,
            look_ahead_blocks: 2000,
        }
    }
}
