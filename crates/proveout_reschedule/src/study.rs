//! What a method shows of its work: curves and numbers, without a word of the method in their types.

/// What a curve is, so that it can be drawn without knowing its method; what is drawn first comes
/// first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CurveKind {
    /// A bound that the result keeps to; it is joined by lines.
    Limit,
    /// The program before; joined by lines.
    Original,
    /// The key points joined by straight lines, before they are smoothed.
    Polyline,
    /// The program after; joined by lines.
    Result,
    /// Points that the method has chosen and the result is led by; not joined.
    KeyPoints,
    /// Places that divide the path: base points, seams, ends of a treated stretch; not joined.
    Marks,
}

impl CurveKind {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Original => "original",
            Self::KeyPoints => "key-points",
            Self::Polyline => "polyline",
            Self::Result => "result",
            Self::Marks => "marks",
        }
    }
}

/// What is drawn along an axis of a plot. Curves with equal quantities belong into one plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// In words of the trade.
    pub name: &'static str,
    /// Unit of the numbers: `mm`, `deg`, ...
    pub unit: &'static str,
}

/// A named curve or set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What it is: `forward limit`, `key points`, ...
    pub name: &'static str,
    /// How it is meant.
    pub kind: CurveKind,
    /// Quantities of abscissa and ordinate.
    pub axes: [Quantity; 2],
    /// Abscissa and ordinate in the units of `axes`; abscissas do not fall.
    pub points: Vec<[f64; 2]>,
}

/// A number that describes the work as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// What it is.
    pub name: &'static str,
    /// Its unit; empty for counts and ratios.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
}

/// What a method shows of its work on one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// The curves, in the order in which they are drawn.
    pub curves: Vec<Curve>,
    /// Numbers.
    pub figures: Vec<Figure>,
    /// Channels that the method has looked at; `figures` has their numbers too.
    pub channels: Vec<ChannelWidth>,
    /// Whose schedule the method has kept, where none of its own was faster or smoother.
    pub kept: Option<KeptSchedule>,
}

/// A channel of tool axes by its figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelWidth {
    /// Which one: `clearance 50 deg`, `by the tool`.
    pub name: &'static str,
    /// Its width at its narrowest place, degrees.
    pub narrowest_deg: f64,
    /// Least peak velocity of the rotary axis in it at the programmed feed, degrees/s.
    pub least_velocity_deg_s: Option<f64>,
}

/// A schedule that is no result of the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptSchedule {
    /// The tool axes of the program.
    OwnAxes,
    /// That of s-theta.
    STheta,
}

impl KeptSchedule {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::OwnAxes => "the program's own axes",
            Self::STheta => "the schedule of s-theta",
        }
    }

    /// The figure that names it.
    pub(super) fn figure(self) -> Figure {
        let name = match self {
            Self::OwnAxes => "kept, the program's own axes",
            Self::STheta => "kept, the schedule of s-theta",
        };
        Figure { name, unit: "", value: 1.0 }
    }
}

impl Study {
    /// The first curve of a kind.
    pub fn curve(&self, kind: CurveKind) -> Option<&Curve> {
        self.curves.iter().find(|c| c.kind == kind)
    }

    /// A number by its name.
    pub fn figure(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|f| f.name == name).map(|f| f.value)
    }
}
