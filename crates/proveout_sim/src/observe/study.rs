//! What a method of re-scheduling shows of its work: curves and numbers.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// What a method shows of its work, whatever the method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// Curves, in the order in which they are drawn.
    pub curves: Vec<StudyCurve>,
    /// Numbers.
    pub figures: Vec<StudyFigure>,
}

/// What a curve is, so that it can be drawn without knowing its method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// A bound that the result keeps to.
    Limit,
    /// The program before.
    Original,
    /// Key points joined by straight lines.
    Polyline,
    /// The program after.
    Result,
    /// Points that the method has chosen; not joined.
    KeyPoints,
    /// Places that divide the path; not joined.
    Marks,
}

/// A curve or set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyCurve {
    /// What it is, in words.
    pub name: String,
    /// How it is meant.
    pub role: Role,
    /// Names of abscissa and ordinate; curves with equal ones share a plot.
    pub axes: [String; 2],
    /// Units of both.
    pub units: [String; 2],
    /// A unit is as long across as up.
    pub equal_scales: bool,
    /// Abscissa and ordinate.
    pub points: Vec<[f64; 2]>,
}

/// A number that a method reports of its work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudyFigure {
    /// What it is.
    pub name: String,
    /// Its unit; empty for counts and ratios.
    pub unit: String,
    /// Its value.
    pub value: f64,
}
