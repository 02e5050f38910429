//! What an 840D keeps while its program runs, in addition to the modal state.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::expr::Expr;
use super::index::Index;
use super::modal::{Interpolation, Modal, SplineKind};
use super::parser::Call;
use super::pending::Pending;
use crate::channel::corners::Corners;
use crate::channel::{self, Channel};
use crate::diagnostic::{Fault, Span};
use crate::frame::Frame;
use crate::source::Mark;
use crate::{AxisValues, Feed, Location, Motion};

/// A program file with its structure.
pub(crate) type Loaded = channel::LoadedProgram<Index>;

/// A Siemens program being executed.
pub(crate) type Interpreter = Channel<Siemens>;

/// Part of a program that a REPEAT with labels repeats.
#[derive(Debug)]
pub(crate) struct Repetition {
    pub(super) first: Mark,
    /// A pass is complete when the next line begins here.
    pub(super) end: usize,
    pub(super) remaining: u32,
    pub(super) resume: Mark,
}

/// What a call level keeps.
#[derive(Debug, Default)]
pub(crate) struct CallLevel {
    pub(super) repetitions: Vec<Repetition>,
    /// Parameters by reference: name inside and name outside.
    pub(super) references: Vec<(String, Expr)>,
    pub(super) saved: Option<Box<Modal>>,
}

/// A modal call with the values of its arguments.
#[derive(Clone, Debug)]
pub(crate) struct ModalCall {
    pub(crate) call: Call,
    /// Call level at which it is in force.
    pub(crate) level: usize,
    /// File and line of its MCALL.
    pub(crate) place: (Arc<str>, u32),
}

impl ModalCall {
    /// Adds the line of the MCALL, which may contain the cause, to a fault of its cycle. The fault
    /// itself is located at the block with the position.
    pub(crate) fn at_call(&self, mut fault: Fault, file: &str) -> Fault {
        let (own, line) = &self.place;
        let other = if **own == *file { String::new() } else { format!(" of {own}") };
        fault.message =
            format!("{}; the cycle is that of `MCALL {}` in line {line}{other}", fault.message, self.call.name);
        fault
    }
}

/// What an 840D keeps in addition to the modal state; SAVE does not affect it.
#[derive(Debug, Default)]
pub(crate) struct Siemens {
    /// Chamfers and roundings between the motions.
    pub(crate) corners: Corners,
    /// Probe input of the last measuring motion.
    pub(super) probe_input: f64,
    /// The FOR line is reached from its ENDFOR.
    pub(super) next_pass_of_for: bool,
    pub(super) block_numbers: BTreeMap<(Arc<str>, usize, u32, bool), Mark>,
    /// Settable frames by the G word that calls them.
    pub(crate) offsets: BTreeMap<String, Frame>,
    /// Variables of type FRAME; one scope for the whole run.
    pub(crate) frame_variables: BTreeMap<String, Frame>,
    /// The first of two lines by their angles waits for the second one.
    pub(crate) first_line: Option<Box<FirstLine>>,
    /// A fault took the place of the first of two lines.
    pub(crate) two_lines_torn: bool,
    /// Direction of motion at the end of the last motion, work coordinates: for CT.
    pub(crate) tangent: Option<[f64; 3]>,
    pub(crate) modal_call: Option<ModalCall>,
    /// CTOL, mm.
    pub(crate) contour_tolerance: Option<f64>,
    /// OTOL, radian.
    pub(crate) orientation_tolerance: Option<f64>,
    /// ADIS in the unit of the program.
    pub(crate) rounding: f64,
    /// Spline whose end is not known yet.
    pub(crate) curve: Option<Box<SplineCurve>>,
    /// A block of the curve has failed.
    pub(crate) curve_torn: bool,
    /// Pitch of the last thread block, mm, with its sign.
    pub(crate) pitch: Option<f64>,
    pub(crate) edge: Option<u32>,
    /// Coordinates that rapid motions on a turned plane have set while one is still unknown.
    pub(crate) held: AxisValues,
    /// Contours that CYCLE62 has called since the last milling of one.
    pub(crate) contours: Vec<Named>,
    /// A contour has failed at a line whose fault is reported separately.
    pub(crate) contour_torn: bool,
    /// A contour is run for its path.
    pub(crate) in_contour: bool,
    /// TRAORI.
    pub(crate) transformed: bool,
    /// CYCLE800 has swiveled the plane.
    pub(crate) swiveled: bool,
    /// The assumption about the reference axis of CYCLE800 has been reported.
    pub(crate) reference_told: bool,
    /// Axes of FGROUP, by bits.
    pub(crate) feed_group: Option<u16>,
    /// FGREF of A, B, C, mm.
    pub(crate) feed_reference: [Option<f64>; 3],
    /// Where the tool points by its last vector, base coordinates.
    pub(crate) tool_axis: Option<[f64; 3]>,
    /// TOROT or TOFRAME is in force, in place of the swivel plane.
    pub(crate) tool_framed: bool,
}

impl Siemens {
    pub(crate) fn tcp(&self) -> bool {
        self.transformed || self.swiveled
    }
}

/// The first of two lines, which waits for the second one.
#[derive(Debug)]
pub(crate) struct FirstLine {
    pub(super) words: Pending,
    pub(super) angle: f64,
    pub(super) location: Location,
    pub(super) plane: [usize; 3],
    pub(super) interpolation: Interpolation,
    pub(super) modal_rounding: Option<f64>,
    pub(super) corner_feed: Option<f64>,
}

/// A point of a curve with the motion that its block would be.
#[derive(Debug)]
pub(crate) struct SplinePoint {
    pub(super) at: [f64; 3],
    pub(super) weight: f64,
    /// PL, where it is written.
    pub(super) interval: Option<f64>,
    /// Its end along axes that the program does not know is not set.
    pub(super) motion: Motion,
    pub(super) feed: Option<Feed>,
    pub(super) location: Location,
    pub(super) span: Span,
}

/// A curve whose last point is not known yet.
#[derive(Debug)]
pub(crate) struct SplineCurve {
    pub(super) kind: SplineKind,
    /// SD when it began.
    pub(super) degree: usize,
    pub(super) start: [f64; 3],
    /// Direction of the motion before.
    pub(super) before: Option<[f64; 3]>,
    pub(super) points: Vec<SplinePoint>,
}

/// A contour, by the cycle that calls it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Named {
    Program(String),
    Labels(String, String),
}
