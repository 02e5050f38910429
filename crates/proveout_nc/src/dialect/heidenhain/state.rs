//! What stays in force from block to block.

use super::corner::PendingCorner;
use super::cycle::{Cycle, OldCycle};
use super::frames::DatumFrames;
use super::words::Pattern;
use crate::{AxisValues, Feed, OrientationInterpolation, RotarySolution, Settings, Tcp};

/// Modal state of the control.
#[derive(Debug)]
pub(crate) struct HeidenhainState {
    pub(crate) inch: bool,
    /// Index of the tool axis: 2 for Z.
    pub(crate) normal: usize,
    /// A TOOL CALL has named the tool axis.
    pub(crate) plane_told: bool,
    /// Pole of C, CP, LP.
    pub(crate) pole: Option<super::circle::Pole>,
    /// Direction of motion at the end of the last contour element, in the working plane.
    pub(crate) tangent: Option<[f64; 2]>,
    /// Feed of TOOL CALL, for FAUTO.
    pub(crate) tool_feed: Option<Feed>,
    /// M136
    pub(crate) per_revolution: bool,
    pub(crate) side: Option<super::words::RadiusSide>,
    /// DL, DR, DR2 of the last TOOL CALL, mm.
    pub(crate) delta: [f64; 3],
    pub(crate) frames: DatumFrames,
    /// M128 or FUNCTION TCPM.
    pub(crate) tcpm: bool,
    /// AXIS SPAT
    pub(crate) spatial: bool,
    pub(crate) interpolation: OrientationInterpolation,
    pub(crate) told_tcp: Option<Tcp>,
    /// A rotary axis or the tool axis was programmed, so the tool may be inclined.
    pub(crate) inclined: bool,
    /// M126
    pub(crate) shortest: bool,
    /// The last F is a number that the control file takes for rapid traverse.
    pub(crate) rapid_number: bool,
    /// The note about an F that older controls read as rapid traverse has been issued.
    pub(crate) rapid_number_told: bool,
    /// Last positioning block had FMAX.
    pub(crate) rapid_before: bool,
    /// The command at the end of the queue is a contour element and waits for its corner.
    pub(crate) held: bool,
    /// Start of the last straight motion, work coordinates.
    pub(crate) line_start: AxisValues,
    /// Feed of the last contour element, and the feed before the block.
    pub(crate) element_feed: Option<Feed>,
    pub(crate) feed_before: Option<Feed>,
    /// Compensation in force before a departure.
    pub(crate) departing: Option<super::words::RadiusSide>,
    /// M120 LA: blocks that the control looks ahead for undercuts, while compensation is on.
    pub(crate) look_ahead: usize,
    /// R0 came since.
    pub(crate) look_ahead_ended: bool,
    pub(crate) approach: Option<super::approach::Approach>,
    pub(crate) corner: Option<PendingCorner>,
    pub(crate) pending_cycle: Option<OldCycle>,
    pub(crate) cycle: Option<Cycle>,
    /// M89
    pub(crate) modal_cycle: bool,
    pub(crate) pattern: Vec<Pattern>,
    /// DIN/ISO: G91.
    pub(crate) incremental: bool,
    /// DIN/ISO: last G function of the path group.
    pub(crate) din_path: u32,
    /// DIN/ISO: direction of the last arc, for G05 and G15.
    pub(crate) din_clockwise: Option<bool>,
    /// Q120 to Q122 hold the rotary positions of the tilted plane.
    pub(crate) plane_angles: bool,
    /// Which of two positions of the rotary axes the plane takes.
    pub(crate) plane_solution: RotarySolution,
}

impl HeidenhainState {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            inch: false,
            normal: 2,
            plane_told: false,
            pole: None,
            tangent: None,
            tool_feed: None,
            per_revolution: false,
            side: None,
            delta: [0.0; 3],
            frames: DatumFrames::new(settings),
            tcpm: false,
            spatial: false,
            interpolation: OrientationInterpolation::Axes,
            told_tcp: None,
            inclined: false,
            shortest: false,
            rapid_number: false,
            rapid_number_told: false,
            rapid_before: false,
            held: false,
            line_start: AxisValues::NONE,
            element_feed: None,
            feed_before: None,
            departing: None,
            look_ahead: 1,
            look_ahead_ended: false,
            approach: None,
            corner: None,
            pending_cycle: None,
            cycle: None,
            modal_cycle: false,
            pattern: Vec::new(),
            incremental: false,
            din_path: 1,
            din_clockwise: None,
            plane_angles: false,
            plane_solution: RotarySolution::Nearest,
        }
    }

    /// mm of one unit of length of the program.
    pub(crate) fn unit(&self) -> f64 {
        if self.inch { 25.4 } else { 1.0 }
    }

    /// First and second axis of the working plane and the tool axis, right-handed.
    pub(crate) fn plane_axes(&self) -> [usize; 3] {
        super::circle::plane_of(self.normal)
    }
}
