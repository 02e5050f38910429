//! What stays in force from block to block.

use crate::compensation::{Beyond, CompStyle, ContourEntry, FeedAt, OutsideCorner};
use crate::control::{Control, OrientationAngles, StartFeed, StartMotion};
use crate::frame::Frame;
use crate::{CompSide, OrientationInterpolation, PathMode};

/// G group 1 and its relatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Rapid,
    Linear,
    Clockwise,
    CounterClockwise,
    /// CIP: circle through an intermediate point.
    Intermediate,
    /// CT: circle with tangential transition.
    Tangential,
    /// G33: straight, coupled to the spindle.
    Thread,
    /// G331: tapping.
    TapIn,
    /// G332: out of the tapped hole.
    TapOut,
    /// BSPLINE, CSPLINE, ASPLINE.
    Spline(SplineKind),
    /// POLY.
    Polynomial,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SplineKind {
    /// BSPLINE
    Basis,
    /// CSPLINE
    Cubic,
    /// ASPLINE
    Akima,
}

/// How a spline begins or ends: BAUTO, BNAT, BTAN and EAUTO, ENAT, ETAN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SplineEnd {
    Auto,
    Natural,
    Tangent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FeedMode {
    PerTime,
    PerRevolution,
    InverseTime,
}

/// G group 13 on a control whose basic system is metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Units {
    /// G71, G710.
    Metric,
    /// G70: lengths in inch, feed in mm.
    InchLengths,
    /// G700: lengths and feed in inch.
    Inch,
}

impl Units {
    pub(crate) fn length(self) -> f64 {
        if self == Self::Metric { 1.0 } else { 25.4 }
    }

    pub(crate) fn feed(self) -> f64 {
        if self == Self::Inch { 25.4 } else { 1.0 }
    }
}

/// Modal state that SAVE of a subprogram keeps and restores.
#[derive(Clone, Debug)]
pub(crate) struct Modal {
    pub(crate) interpolation: Interpolation,
    /// Index of the axis normal to the working plane: 2 for G17, 1 for G18, 0 for G19.
    pub(crate) normal: usize,
    pub(crate) incremental: bool,
    pub(crate) units: Units,
    pub(crate) feed_mode: FeedMode,
    pub(crate) exact_stop: bool,
    /// Corner treatment of the G words.
    pub(crate) path_mode: PathMode,
    /// Mode to return to when CYCLE832 ends.
    pub(crate) mode_before_cycle832: Option<PathMode>,
    pub(crate) orientation: OrientationInterpolation,
    /// How A2= B2= C2= are read; none if no word and no control file has stated it.
    pub(crate) angles: Option<OrientationAngles>,
    /// ORIMKS: vectors are meant in the machine frame.
    pub(crate) machine_vectors: bool,
    pub(crate) frames: Frames,
    pub(crate) compensation: Compensation,
    /// RNDM=, mm.
    pub(crate) modal_rounding: Option<f64>,
    /// FRCM=, as written.
    pub(crate) corner_feed: Option<f64>,
    /// Pole of polar coordinates, in the axes of the working plane, work coordinates, mm.
    pub(crate) pole: [f64; 2],
    /// RP, mm.
    pub(crate) polar_radius: Option<f64>,
    /// AP, degrees.
    pub(crate) polar_angle: Option<f64>,
    pub(crate) spline_begin: SplineEnd,
    pub(crate) spline_end: SplineEnd,
    /// SD=
    pub(crate) spline_degree: usize,
}

/// Cutter radius compensation as programmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compensation {
    pub(crate) side: CompSide,
    pub(crate) style: CompStyle,
    /// KONTC or KONTT, while it is in force.
    pub(crate) smooth_approach: Option<&'static str>,
    /// CUT2DF: the plane turns with the frame.
    pub(crate) plane_in_frame: bool,
    /// DISC=, percent.
    pub(crate) disc: f64,
}

impl Compensation {
    /// G451: circles instead of intersections beyond this change of direction, degrees (standard of MD20210).
    const CORNER_LIMIT_DEG: f64 = 100.0;

    /// CDON: blocks within which the control looks for places where the tool does not fit (standard of
    /// MD20240).
    pub(crate) const BOTTLENECK_BLOCKS: usize = 3;

    /// After reset: G40, NORM, G450, CFC, CUT2D, CDOF.
    pub(crate) const RESET: Self = Self {
        side: CompSide::Off,
        style: CompStyle {
            corner: OutsideCorner::Arc,
            entry: ContourEntry::Perpendicular,
            feed: FeedAt::Contour,
            follow_contour: false,
            look_ahead: 1,
        },
        smooth_approach: None,
        plane_in_frame: false,
        disc: 0.0,
    };

    /// G450, G451.
    pub(crate) fn corner(code: u32) -> OutsideCorner {
        if code == 450 {
            OutsideCorner::Arc
        } else {
            OutsideCorner::Intersection { limit: Self::CORNER_LIMIT_DEG.to_radians(), beyond: Beyond::Arc }
        }
    }
}

/// Frames of the control from the base to the work coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// `$P_BFRAME`.
    pub(crate) base: Frame,
    /// G54 and the like.
    pub(crate) settable: Frame,
    /// CYCLE800.
    pub(crate) swivel: Frame,
    /// TRANS ROT SCALE MIRROR.
    pub(crate) programmable: Frame,
    /// Part of its translation that ATRANS and G59 made; none where it is not along the axes of the frame.
    pub(crate) additive: Option<[f64; 3]>,
}

impl Frames {
    /// The frames without that of a swiveled tool.
    pub(crate) fn without_swivel(&self) -> Frame {
        self.base.then(&self.settable).then(&self.programmable)
    }

    pub(crate) fn total(&self) -> Frame {
        self.base.then(&self.settable).then(&self.swivel).then(&self.programmable)
    }
}

impl Modal {
    /// State after reset: G1, G17, G71, G90, G94, G60, G500. Settings of the control file take
    /// precedence.
    pub(crate) fn new(orientation: OrientationInterpolation, control: &Control) -> Self {
        let start = &control.start;
        Self {
            interpolation: match start.motion {
                Some(StartMotion::Rapid) => Interpolation::Rapid,
                _ => Interpolation::Linear,
            },
            normal: start.normal.unwrap_or(2),
            incremental: start.incremental.unwrap_or(false),
            units: if start.inch == Some(true) { Units::Inch } else { Units::Metric },
            feed_mode: match start.feed {
                Some(StartFeed::PerRevolution) => FeedMode::PerRevolution,
                Some(StartFeed::InverseTime) => FeedMode::InverseTime,
                Some(StartFeed::PerMinute) | None => FeedMode::PerTime,
            },
            exact_stop: true,
            path_mode: PathMode::ExactStop,
            mode_before_cycle832: None,
            orientation,
            angles: control.parameters.orientation_angles,
            machine_vectors: false,
            frames: Frames {
                base: Frame::IDENTITY,
                settable: Frame::IDENTITY,
                swivel: Frame::IDENTITY,
                programmable: Frame::IDENTITY,
                additive: Some([0.0; 3]),
            },
            compensation: Compensation::RESET,
            modal_rounding: None,
            corner_feed: None,
            pole: [0.0; 2],
            polar_radius: None,
            polar_angle: None,
            spline_begin: SplineEnd::Auto,
            spline_end: SplineEnd::Auto,
            spline_degree: 3,
        }
    }

    /// First and second axis of the plane and its normal, right-handed.
    pub(crate) fn plane_axes(&self) -> [usize; 3] {
        [(self.normal + 1) % 3, (self.normal + 2) % 3, self.normal]
    }
}
