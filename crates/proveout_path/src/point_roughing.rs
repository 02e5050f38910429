//! A blade from solid in layers: lines round the sections at a falling allowance, from the outside in. In
//! each layer the cutter touches a surface that lies its allowance outside of the blade, with a point (point
//! milling), so that the same cutter and axes as for finishing do.

use super::{
    Line, PathError, Spacing, Strategy, Task,
    families::{Round, check_along, within},
    sample::WHOLE,
};

/// Smallest depth of a layer, mm.
const LEAST_DEPTH_MM: f64 = 1e-3;

/// Layers of lines round the sections.
#[derive(Clone, Debug, PartialEq)]
pub struct PointRoughing {
    /// Allowance of the outermost layer, mm.
    pub from_allowance: f64,
    /// Allowance that stays, mm.
    pub to_allowance: f64,
    /// Largest difference of the allowances of two layers, mm.
    pub depth: f64,
    /// First and last v, parts of the domain: from the tip to the root the layers have a free end to come
    /// from.
    pub range: [f64; 2],
    /// u at which a line begins and ends, part of the domain.
    pub start: f64,
    /// Where the lines lie.
    pub spacing: Spacing,
}

impl PointRoughing {
    /// Allowances of the layers, mm.
    pub fn layers(&self) -> Vec<f64> {
        let way = self.from_allowance - self.to_allowance;
        let count = (way / self.depth - WHOLE).ceil().max(0.0) as usize;
        (0..=count).map(|k| self.from_allowance - way * k as f64 / count.max(1) as f64).collect()
    }
}

impl Strategy for PointRoughing {
    fn has_layers(&self) -> bool {
        true
    }

    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.range)?;
        let domain = task.surface.domain();
        if !domain.u_closed {
            let what = "an open surface has no lines all round it".to_owned();
            return Err(PathError::NoLine { what, section: self.range[0] });
        }
        PathError::within("the depth of a layer in mm", self.depth, LEAST_DEPTH_MM, 100.0)?;
        PathError::within("the allowance that stays in mm", self.to_allowance, 0.0, 100.0)?;
        PathError::within("the allowance of the first layer in mm", self.from_allowance, self.to_allowance, 1000.0)?;
        PathError::within("the start round the section", self.start, 0.0, 1.0)?;
        let u = [self.start, self.start + 1.0].map(|part| within(domain.u, part));
        let family = Round { u, v: domain.v };
        // Lines lie as the finished surface asks: outside of it ridges between them are higher by the factor
        // of the offset.
        let lines = task.family(&family, self.range, &self.spacing)?;
        let mut all = Vec::new();
        for (k, allowance) in self.layers().into_iter().enumerate() {
            for line in &lines {
                all.push(Line { name: format!("layer {}, {}", k + 1, line.name), allowance, ..line.clone() });
            }
        }
        Ok(all)
    }
}
