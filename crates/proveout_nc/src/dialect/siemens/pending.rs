//! The words of one block, sorted: what the block asks for, before anything is executed.

use crate::diagnostic::Span;
use crate::{CompSide, ToolName};

/// How a coordinate is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reference {
    /// As G90 and G91 say.
    Modal,
    /// `AC()`.
    Absolute,
    /// `IC()`.
    Incremental,
    /// `DC()`: rotary axis, absolute, the short way.
    Shortest,
    /// `ACP()`: rotary axis, absolute, in positive direction.
    Positive,
    /// `ACN()`: rotary axis, absolute, in negative direction.
    Negative,
}

/// A coordinate as written: mm, inch or degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coordinate {
    pub(crate) value: f64,
    pub(crate) reference: Reference,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameWord {
    Trans,
    ATrans,
    Rot,
    ARot,
    Scale,
    AScale,
    Mirror,
    AMirror,
    /// Absolute translation, axis by axis.
    G58,
    /// Additive translation, axis by axis.
    G59,
}

impl FrameWord {
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "TRANS" => Self::Trans,
            "ATRANS" => Self::ATrans,
            "ROT" => Self::Rot,
            "AROT" => Self::ARot,
            "SCALE" => Self::Scale,
            "ASCALE" => Self::AScale,
            "MIRROR" => Self::Mirror,
            "AMIRROR" => Self::AMirror,
            _ => return None,
        })
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Trans => "TRANS",
            Self::ATrans => "ATRANS",
            Self::Rot => "ROT",
            Self::ARot => "AROT",
            Self::Scale => "SCALE",
            Self::AScale => "ASCALE",
            Self::Mirror => "MIRROR",
            Self::AMirror => "AMIRROR",
            Self::G58 => "G58",
            Self::G59 => "G59",
        }
    }

    pub(crate) fn is_additive(self) -> bool {
        matches!(self, Self::ATrans | Self::ARot | Self::AScale | Self::AMirror)
    }
}

/// What the words request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ToolFrame {
    /// TOROT
    Turned,
    /// TOFRAME
    AtTip,
    /// TOROTOF, TOFRAMEOF
    Off,
}

impl ToolFrame {
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        match name {
            "TOROT" | "TOROTZ" => Some(Self::Turned),
            "TOFRAME" | "TOFRAMEZ" => Some(Self::AtTip),
            "TOROTOF" | "TOFRAMEOF" => Some(Self::Off),
            _ => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Turned => "TOROT",
            Self::AtTip => "TOFRAME",
            Self::Off => "TOROTOF",
        }
    }
}

/// The words of a block by meaning.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pending {
    /// Axes in the order of [`crate::AXIS_LETTERS`].
    pub(crate) axes: [Option<Coordinate>; 9],
    /// Bit i: axis i is programmed in the block.
    pub(crate) programmed: u16,
    /// I, J, K.
    pub(crate) center: [Option<Coordinate>; 3],
    /// I1=, J1=, K1=.
    pub(crate) intermediate: [Option<Coordinate>; 3],
    pub(crate) radius: Option<f64>,
    pub(crate) opening: Option<f64>,
    pub(crate) turns: Option<f64>,
    /// A3=, B3=, C3=.
    pub(crate) vector: [Option<f64>; 3],
    /// A2=, B2=, C2=, degrees.
    pub(crate) angles: [Option<f64>; 3],
    pub(crate) feed: Option<f64>,
    pub(crate) speed: Option<f64>,
    pub(crate) tool: Option<ToolName>,
    pub(crate) edge: Option<u32>,
    pub(crate) dwell: bool,
    pub(crate) exact_stop: bool,
    pub(crate) machine: bool,
    pub(crate) frame: Option<(FrameWord, Span)>,
    pub(crate) tool_frame: Option<ToolFrame>,
    pub(crate) plane_angle: Option<f64>,
    pub(crate) rounding: Option<f64>,
    /// M words in the order of the block.
    pub(crate) functions: Vec<u32>,
    /// The word that switches the transformation, if it is not TRAORI.
    pub(crate) transformation_word: Option<String>,
    /// Subprogram that a word of the control file calls.
    pub(crate) listed_call: Option<String>,
    /// Cycle or subprogram of the block: index of its word.
    pub(crate) call: Option<usize>,
    /// Passes of a subprogram, P.
    pub(crate) passes: Option<u32>,
    /// Subprogram by number, L100.
    pub(crate) numbered_call: Option<u32>,
    /// TRAORI (true) or TRAFOOF.
    pub(crate) transformation: Option<bool>,
    /// Number of the G word of the work offset: 54, 505, 500.
    pub(crate) offset: Option<u32>,
    /// ANG=, degrees.
    pub(crate) angle: Option<f64>,
    /// CHF=, CHR=, RND=.
    pub(crate) chamfer: Option<f64>,
    pub(crate) chamfer_leg: Option<f64>,
    pub(crate) corner_radius: Option<f64>,
    /// FRC=.
    pub(crate) corner_feed: Option<f64>,
    /// G110, G111, G112.
    pub(crate) pole: Option<u32>,
    pub(crate) polar_angle: Option<Coordinate>,
    pub(crate) polar_radius: Option<Coordinate>,
    /// PW= and PL= of splines and polynomials.
    pub(crate) weight: Option<f64>,
    pub(crate) interval: Option<f64>,
    /// Coefficients of PO[X], PO[Y], PO[Z] from the second power on.
    pub(crate) polynomial: [Option<[f64; 4]>; 3],
    /// FB=.
    pub(crate) block_feed: Option<f64>,
    /// OVR=, percent.
    pub(crate) feed_override: Option<f64>,
    /// POS[]=: the axes are positioning axes.
    pub(crate) positioning: bool,
    /// G25, G26: the axes and S of the block are limits.
    pub(crate) limits: Option<u32>,
    /// G63: this block is straight and at feed, whatever interpolation is in force.
    pub(crate) tapping_feed: bool,
    /// G74, G75.
    pub(crate) fixed_point: Option<u32>,
    /// FP=.
    pub(crate) fixed_point_number: Option<f64>,
    /// Axes that are named by the machine (`X1=`), bit mask.
    pub(crate) machine_axes: u16,
    /// MEAS=, MEAW=.
    pub(crate) measure: Option<f64>,
    pub(crate) measure_on: Option<f64>,
    /// G40, G41, G42.
    pub(crate) compensation: Option<CompSide>,
    /// The G word that the block has of each group of [`super::words::g_group`].
    pub(crate) groups: [Option<u32>; 7],
}

impl Pending {
    /// The block has a word that only some kinds of blocks use.
    pub(crate) fn may_be_left(&self) -> bool {
        let numbers = [
            self.radius,
            self.opening,
            self.turns,
            self.plane_angle,
            self.chamfer,
            self.chamfer_leg,
            self.corner_radius,
            self.weight,
            self.interval,
            self.measure,
            self.measure_on,
            self.block_feed,
            self.angle,
        ];
        numbers.iter().any(Option::is_some)
            || self.dwell
            || self.limits.is_some()
            || self.pole.is_some()
            || self.frame.is_some()
            || self.fixed_point.is_some()
            || self.has_center()
            || self.intermediate.iter().any(Option::is_some)
            || self.polar_angle.is_some()
            || self.polar_radius.is_some()
            || self.has_orientation() && !self.has_axis()
    }

    pub(crate) fn has_axis(&self) -> bool {
        self.programmed != 0
    }

    pub(crate) fn has_orientation(&self) -> bool {
        self.vector.iter().chain(&self.angles).any(Option::is_some)
    }

    pub(crate) fn has_center(&self) -> bool {
        self.center.iter().any(Option::is_some)
    }
}
