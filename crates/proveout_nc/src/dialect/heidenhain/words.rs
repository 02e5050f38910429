//! A block as written: the words of both forms of the language, before any of them is executed.

use crate::diagnostic::Span;

use super::expr::Expr;

/// Kind of a Q parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// `Q`
    Global,
    /// `QL`
    Local,
    /// `QR`
    Retained,
    /// `QS`
    Text,
}

/// `Q5`, `QL3`, `QR1`, `QS7`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Param {
    pub(crate) kind: Kind,
    pub(crate) index: u32,
}

impl Param {
    pub(crate) fn name(self) -> String {
        let letters = match self.kind {
            Kind::Global => "Q",
            Kind::Local => "QL",
            Kind::Retained => "QR",
            Kind::Text => "QS",
        };
        format!("{letters}{}", self.index)
    }
}

/// The value after an address.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Param { negative: bool, param: Param },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reference {
    Absolute,
    Incremental,
    /// DIN/ISO: as G90 and G91 say.
    Modal,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coordinate {
    pub(crate) value: Value,
    pub(crate) reference: Reference,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FeedWord {
    Value(Value),
    Max,
    Auto,
    /// FU: mm or inch a spindle revolution.
    PerRevolution(Value),
}

/// An M function with what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MWord {
    pub(crate) code: u32,
    /// `MB 50`, `F1000` of M128, `LA5`.
    pub(crate) value: Option<Value>,
    /// `MB MAX`
    pub(crate) max: bool,
    pub(crate) feed: Option<FeedWord>,
    /// Axes named after M94, M138: bit mask.
    pub(crate) axes: u16,
    pub(crate) span: Span,
}

/// R0, RL, RR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RadiusSide {
    Off,
    Left,
    Right,
}

/// Words of a path block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Words {
    /// In the order of [`crate::AXIS_LETTERS`].
    pub(crate) axes: [Option<Coordinate>; 9],
    pub(crate) programmed: u16,
    pub(crate) polar_radius: Option<Coordinate>,
    pub(crate) polar_angle: Option<Coordinate>,
    pub(crate) radius: Option<Value>,
    /// DR-
    pub(crate) clockwise: Option<bool>,
    pub(crate) side: Option<RadiusSide>,
    pub(crate) feed: Option<FeedWord>,
    pub(crate) normal: [Option<Value>; 3],
    pub(crate) vector: [Option<Value>; 3],
    /// LEN of APPR and DEP, side of CHF.
    pub(crate) length: Option<Value>,
    /// CCA
    pub(crate) arc_angle: Option<Value>,
    /// AN of a free contour.
    pub(crate) line_angle: Option<Value>,
    /// CCX, CCY of a free contour.
    pub(crate) circle: [Option<Value>; 2],
    /// CLSD+ (true) and CLSD- of a free contour.
    pub(crate) closed: Option<bool>,
    pub(crate) functions: Vec<MWord>,
}

impl Words {
    pub(crate) fn clear(&mut self) {
        if self.programmed != 0 {
            self.axes = [None; 9];
            self.programmed = 0;
        }
        self.polar_radius = None;
        self.polar_angle = None;
        self.radius = None;
        self.clockwise = None;
        self.side = None;
        self.feed = None;
        self.normal = [None; 3];
        self.vector = [None; 3];
        self.length = None;
        self.arc_angle = None;
        self.line_angle = None;
        self.circle = [None; 2];
        self.closed = None;
        self.functions.clear();
    }

    pub(crate) fn has(&self, code: u32) -> bool {
        self.functions.iter().any(|m| m.code == code)
    }
}

/// Kind of a path block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PathFunction {
    /// Only M functions, feed or compensation.
    Nothing,
    Line,
    /// LN
    Normal,
    /// CC
    Pole,
    /// C
    Arc,
    /// CR
    Radius,
    /// CT
    Tangent,
    /// LP
    PolarLine,
    /// CP
    PolarArc,
    /// CTP
    PolarTangent,
    Round,
    Chamfer,
    Approach(Lead),
    Depart(Lead),
    /// FL, FLT, FC, FCT
    Free(FreeKind),
    /// FPOL
    FreePole,
}

/// Elements of a free contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FreeKind {
    Line,
    LineTangent,
    Arc,
    ArcTangent,
}

/// Shape of approach and departure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lead {
    /// Tangential line.
    LineTangent,
    /// Line normal to the contour.
    LineNormal,
    /// Tangential arc.
    Circle,
    /// Line with tangential arc.
    LineCircle,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ToolRef {
    Number(Value),
    Name(String),
    Text(Param),
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ToolCall {
    pub(crate) tool: Option<ToolRef>,
    pub(crate) axis: Option<char>,
    pub(crate) speed: Option<Value>,
    pub(crate) feed: Option<FeedWord>,
    pub(crate) length: Option<Value>,
    pub(crate) radius: Option<Value>,
    pub(crate) corner: Option<Value>,
}

/// A value of a cycle parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CycleValue {
    Value(Value),
    Max,
    Auto,
    PerRevolution(Value),
}

/// `X+10`, `ROT+35`, `DEPTH -20`, `X` of a cycle in the old form.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OldWord {
    pub(crate) name: String,
    pub(crate) value: Option<Value>,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Label {
    Number(Value),
    Name(String),
    Text(Param),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Equal,
    NotEqual,
    Greater,
    Less,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Condition {
    Compare(Value, Relation, Value),
    Defined(Param, bool),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaneKind {
    Spatial,
    Projected,
    Euler,
    Vector,
    Points,
    Relative,
    Axial,
    Reset,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Positioning {
    Move,
    Turn,
    Stay,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plane {
    pub(crate) kind: PlaneKind,
    /// `SPA+10`, `BX+1`, `P1X+0`.
    pub(crate) angles: Vec<(String, Value)>,
    pub(crate) positioning: Option<Positioning>,
    /// DIST of MOVE.
    pub(crate) distance: Option<Value>,
    /// MB: retraction before turning; the flag says MAX.
    pub(crate) retract: Option<(Option<Value>, bool)>,
    pub(crate) feed: Option<FeedWord>,
    /// SEQ and SYM.
    pub(crate) choice: Option<TiltChoice>,
    /// `TABLE ROT` and the like, reported in a note.
    pub(crate) options: Vec<String>,
}

/// Which of two positions of the rotary axes a plane takes, by the angle of the primary axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TiltChoice {
    /// SEQ+
    Positive,
    /// SEQ-
    Negative,
    /// SYM+
    Upper,
    /// SYM-
    Lower,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tcpm {
    /// AXIS SPAT: words of rotary axes are spatial angles.
    pub(crate) spatial: bool,
    /// PATHCTRL VECTOR
    pub(crate) vector: bool,
    /// Other words of the block, for a note.
    pub(crate) options: Vec<String>,
}

/// Forms of PATTERN DEF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PatternKind {
    /// POS
    Point,
    Row,
    /// PAT
    Grid,
    /// FRAME: the edge of a grid.
    Frame,
    /// CIRC
    Circle,
    /// PITCHCIRC
    Sector,
}

/// Points of PATTERN DEF.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pattern {
    pub(crate) kind: PatternKind,
    /// By their words: `X`, `NUMX`.
    pub(crate) values: Vec<(&'static str, Value)>,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Statement {
    /// A comment, a header or nothing at all.
    Empty,
    Begin {
        inch: bool,
    },
    End,
    Path(PathFunction),
    ToolCall(ToolCall),
    /// The tool, and the text after it, which is reported in a note.
    ToolDef(ToolRef, String),
    /// `CYCL DEF 7.1 X+10`.
    OldCycle {
        number: u32,
        part: u32,
        words: Vec<OldWord>,
    },
    /// `CYCL DEF 12.1 PGM NAME`.
    OldCycleProgram(String),
    /// `CYCL DEF 200 DRILLING Q200=2`.
    Cycle {
        number: u32,
        values: Vec<(Param, CycleValue, Span)>,
    },
    CycleCall,
    CycleCallPos,
    CycleCallPattern,
    Pattern(Vec<Pattern>),
    Label(Label),
    CallLabel {
        label: Label,
        repeat: Option<Value>,
    },
    CallProgram(String),
    CallProgramText(Param),
    SelectProgram(String),
    SelectProgramText(Param),
    CallSelected,
    Assign(Param, Expr),
    /// FN 18: SYSREAD of ID, NR and IDX.
    SystemRead(Param, [Option<Value>; 3]),
    /// FN 23: circle through three points.
    CircleData(Param, Param),
    Branch(Condition, Label),
    Goto(Label),
    Error(Value),
    Plane(Plane),
    Tcpm(Tcpm),
    ResetTcpm,
    /// TRANS DATUM AXIS; none: TRANS DATUM RESET.
    Datum(bool),
    DatumRow(Value),
    TransMirror(bool),
    TransRotation(Option<Coordinate>),
    TransScale(Option<Value>),
    Stop,
    Note(String),
    /// DIN/ISO block: G functions in the order of the block.
    Din(Box<DinBlock>),
}

/// A block of path functions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct DinBlock {
    /// Path function of this block, if it has one.
    pub(crate) path: Option<u32>,
    /// G90 (false) or G91 (true).
    pub(crate) incremental: Option<bool>,
    /// I, J, K.
    pub(crate) pole: [Option<Value>; 3],
    /// G29
    pub(crate) pole_here: bool,
    pub(crate) radius: Option<Value>,
    pub(crate) angle: Option<Value>,
    /// T, S and the plane, which act before the path.
    pub(crate) tool: Option<ToolCall>,
}

/// Everything of a block before its meaning is known.
#[derive(Default)]
pub(super) struct DinWords {
    pub(super) g: Vec<(u32, Span)>,
    pub(super) din: DinBlock,
    pub(super) label: Option<(Label, Option<Value>)>,
    pub(super) function: Option<(u32, Option<Param>)>,
    pub(super) values: Vec<Value>,
    pub(super) target: Option<Label>,
    pub(super) settings: Vec<(Param, CycleValue, Span)>,
    pub(super) tool: Option<ToolRef>,
    pub(super) speed: Option<Value>,
    pub(super) delta: [Option<Value>; 3],
    pub(super) program: Option<String>,
}

/// A block of either form. Reused from block to block.
#[derive(Debug)]
pub(crate) struct Block {
    pub(crate) skip: bool,
    pub(crate) words: Words,
    pub(crate) statement: Statement,
    /// G90 (false) or G91 together with a G word that is not a path function: it holds from here.
    pub(crate) incremental: Option<bool>,
    pub(crate) span: Span,
}

impl Default for Block {
    fn default() -> Self {
        Self {
            skip: false,
            words: Words::default(),
            statement: Statement::Empty,
            incremental: None,
            span: Span::default(),
        }
    }
}

impl Block {
    pub(crate) fn clear(&mut self) {
        self.skip = false;
        self.words.clear();
        self.statement = Statement::Empty;
        self.incremental = None;
        self.span = Span::default();
    }
}
