//! One row along the blade, as a grinder with a wheel cuts it (Cui et al. 2022): usually with the tool axis
//! between the leans at both edge plates ([`super::AxisRule::Interpolated`]).

use super::{
    Label, Line, PathError, SECTIONS, Sections, Strategy, Task,
    families::{check_along, within},
};

/// One row along the blade.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What is constant along the row.
    pub label: Label,
    /// Its value; theta in parts of a turn.
    pub at: f64,
    /// u near the trailing edge, part of the domain, for the polar angle.
    pub trailing: f64,
    /// Along the blade, parts of the domain; the other way round where the first is larger.
    pub along: [f64; 2],
}

impl Strategy for Row {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.along)?;
        PathError::within("the place of the row", self.at, 0.0, 1.0)?;
        let domain = task.surface.domain();
        let [low, high] = [self.along[0].min(self.along[1]), self.along[0].max(self.along[1])];
        let v = [within(domain.v, low), within(domain.v, high)];
        let sections = Sections::new(task.surface, self.label, v, SECTIONS, within(domain.u, self.trailing))?;
        let curve = sections.line(self.at)?;
        let curve = if self.along[1] < self.along[0] { curve.reversed() } else { curve };
        Ok(vec![Line::new(format!("row {:.5}", self.at), curve)])
    }
}
