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
