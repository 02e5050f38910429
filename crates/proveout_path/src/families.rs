//! Lines of constant parameter: along the blade with the length or the polar angle constant, and round its
//! sections.

use super::{
    Label, Line, ParameterCurve, PathError, SECTIONS, Sections, Spacing, Strategy, Task,
    strategy::{LineFamily, to_and_fro},
};

/// Least way along or across the lines, part of the domain.
pub(super) const LEAST_WAY: f64 = 1e-6;

/// Lines along the blade on which the part of the section's length is constant (or the surface's own u): the
/// usual lines of a CAM system.
#[derive(Clone, Debug, PartialEq)]
pub struct IsoParametric {
    /// [`Label::Length`] or [`Label::Surface`].
    pub label: Label,
    /// First and last label, 0 to 1.
    pub range: [f64; 2],
    /// Along the blade, parts of the domain.
    pub along: [f64; 2],
    /// Where the lines lie.
    pub spacing: Spacing,
}

/// Lines along the blade on which the polar angle is constant (Lu, Yang and Zhao 2022): both edges have the
/// same angle in every section, so that no line crosses an edge.
#[derive(Clone, Debug, PartialEq)]
pub struct QuasiCircle {
    /// How far the branch points lie inside of the edges, parts of the chord.
    pub focus_inside: f64,
    /// u near the trailing edge at the first section, part of the domain: it decides which edge is theta = 0.
    pub trailing: f64,
    /// First and last angle, radian.
    pub range: [f64; 2],
    /// Along the blade, parts of the domain.
    pub along: [f64; 2],
    /// Where the lines lie; values in radian.
    pub spacing: Spacing,
}

/// Lines round the sections, v constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Transverse {
    /// Round the section, parts of the domain; a closed section goes from one part on to the other over the
    /// seam.
    pub round: [f64; 2],
    /// First and last v, parts of the domain.
    pub range: [f64; 2],
    /// Where the lines lie.
    pub spacing: Spacing,
    /// All lines in the same direction, instead of to and fro.
    pub one_way: bool,
}

/// The value at a part of a range.
pub(crate) fn within([low, high]: [f64; 2], part: f64) -> f64 {
    low + (high - low) * part
}

pub(crate) fn check_along(along: [f64; 2]) -> Result<(), PathError> {
    PathError::within("the start along the blade", along[0], 0.0, 1.0)?;
    PathError::within("the end along the blade", along[1], 0.0, 1.0)?;
    PathError::within("the length along the blade, part of the domain", (along[1] - along[0]).abs(), LEAST_WAY, 1.0)?;
    Ok(())
}

struct Along<'a> {
    sections: Sections<'a>,
    /// From the value of the spacing to the label.
    factor: f64,
    what: &'static str,
    shown: f64,
    unit: &'static str,
}

impl LineFamily for Along<'_> {
    fn line(&self, value: f64) -> Result<Line, PathError> {
        let name = format!("{} {:.4}{}", self.what, value * self.shown, self.unit);
        Ok(Line::new(name, self.sections.line(value * self.factor)?))
    }
}

/// Whether lines lie in the direction of growing v.
fn directed(mut lines: Vec<Line>, along: [f64; 2]) -> Vec<Line> {
    if along[1] < along[0] {
        for line in &mut lines {
            line.curve = line.curve.reversed();
        }
    }
    to_and_fro(&mut lines);
    lines
}

impl Strategy for IsoParametric {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.along)?;
        let domain = task.surface.domain();
        let [low, high] = [self.along[0].min(self.along[1]), self.along[0].max(self.along[1])];
        let v = [within(domain.v, low), within(domain.v, high)];
        let sections = Sections::new(task.surface, self.label, v, SECTIONS, domain.u[0])?;
        let family = Along { sections, factor: 1.0, what: "u", shown: 1.0, unit: "" };
        Ok(directed(task.family(&family, self.range, &self.spacing)?, self.along))
    }
}

impl Strategy for QuasiCircle {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.along)?;
        let domain = task.surface.domain();
        let [low, high] = [self.along[0].min(self.along[1]), self.along[0].max(self.along[1])];
        let v = [within(domain.v, low), within(domain.v, high)];
        let label = Label::PolarAngle { focus_inside: self.focus_inside };
        let sections = Sections::new(task.surface, label, v, SECTIONS, within(domain.u, self.trailing))?;
        let shown = 1_f64.to_degrees();
        let family = Along { sections, factor: 1.0 / std::f64::consts::TAU, what: "theta", shown, unit: " deg" };
        Ok(directed(task.family(&family, self.range, &self.spacing)?, self.along))
    }
}

pub(crate) struct Round {
    pub(crate) u: [f64; 2],
    pub(crate) v: [f64; 2],
}

impl LineFamily for Round {
    fn line(&self, part: f64) -> Result<Line, PathError> {
        let v = within(self.v, part);
        let curve = ParameterCurve::straight([self.u[0], v], [self.u[1], v]);
        let what = format!("the line round the section has no length from u {} to {}", self.u[0], self.u[1]);
        let curve = curve.ok_or(PathError::NoLine { what, section: part })?;
        Ok(Line::new(format!("v {part:.5}"), curve))
    }
}

impl Strategy for Transverse {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.range)?;
        let domain = task.surface.domain();
        let most = if domain.u_closed { 2.0 } else { 1.0 };
        PathError::within("the start round the section", self.round[0], 0.0, most)?;
        PathError::within("the end round the section", self.round[1], 0.0, most)?;
        let way = (self.round[1] - self.round[0]).abs();
        PathError::within("the way round the section, part of the domain", way, LEAST_WAY, 1.0)?;
        let family = Round { u: self.round.map(|r| within(domain.u, r)), v: domain.v };
        let mut lines = task.family(&family, self.range, &self.spacing)?;
        if !self.one_way {
            to_and_fro(&mut lines);
        }
        Ok(lines)
    }
}
