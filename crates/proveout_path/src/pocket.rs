//! Rings inside each other: the rim of a field of the parameter plane, moved inwards by the same part on all
//! sides ("pocketing" of Lu et al. 2022, section 4).
//!
//! ```text
//!   v ^  +-------------+      ring k: u and v from the rim by the part p_k of the field
//!     |  | +---------+ |      from ring to ring over the corner, on the surface
//!     |  | | +-----+ | |
//!     |  | | +-----+ | |
//!     |  | +---------+ |
//!     |  +-------------+
//!     +-----------------> u
//! ```

use super::{
    Line, ParameterCurve, PathError, PathPoint, Spacing, Strategy, Task,
    error::LEAST_SCALLOP_MM,
    families::{check_along, within},
    strategy::{LEAST_USED, beside},
};

/// Rings inside each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Pocket {
    /// Round the section, parts of the domain.
    pub round: [f64; 2],
    /// Along the blade, parts of the domain.
    pub along: [f64; 2],
    /// Where the rings lie; values are parts of the field, 0 at its rim and 0.5 in its middle.
    pub spacing: Spacing,
    /// From the middle outwards.
    pub outwards: bool,
}

/// Rings beyond which the numbers are a mistake.
const MOST_RINGS: usize = 100_000;
/// Inset of the innermost ring, part of the domain: at a half it has no size.
const INNERMOST: f64 = 0.5 - 1e-9;
/// Shortest step from ring to ring, part of the domain: with shorter ones they come to no end.
const LEAST_STEP: f64 = 1e-9;

impl Pocket {
    fn corners(&self, task: &Task<'_>, inset: f64) -> [[f64; 2]; 4] {
        let domain = task.surface.domain();
        let u = |part: f64| within(domain.u, within(self.round, part));
        let v = |part: f64| within(domain.v, within(self.along, part));
        let (low, high) = (inset, 1.0 - inset);
        [[u(low), v(low)], [u(high), v(low)], [u(high), v(high)], [u(low), v(high)]]
    }

    fn ring(&self, task: &Task<'_>, inset: f64) -> Result<Vec<Line>, PathError> {
        let corners = self.corners(task, inset);
        let mut lines = Vec::new();
        for k in 0..4 {
            let curve = ParameterCurve::straight(corners[k], corners[(k + 1) % 4]);
            let curve = curve.ok_or(PathError::NoLine { what: "a ring has no length".into(), section: inset })?;
            lines.push(Line { joined: true, ..Line::new(format!("ring {inset:.5}, side {}", k + 1), curve) });
        }
        Ok(lines)
    }

    fn insets(&self, task: &Task<'_>) -> Result<Vec<f64>, PathError> {
        let height = match &self.spacing {
            Spacing::At(insets) => {
                for &inset in insets {
                    PathError::within("the place of a ring", inset, 0.0, 0.5)?;
                }
                return Ok(insets.clone());
            }
            Spacing::Scallop(height) => PathError::within("the scallop in mm", *height, LEAST_SCALLOP_MM, 10.0)?,
        };
        let mut insets = vec![0.0];
        let mut inset = 0.0;
        while inset < 0.5 {
            let sides = self.ring(task, inset)?;
            let looks: Result<Vec<_>, _> = sides.iter().map(|side| task.looks(side, height)).collect();
            let looks = looks?;
            let used = |next: f64| -> Result<f64, PathError> {
                let others = self.ring(task, next)?;
                let mut most = 0.0_f64;
                for (places, other) in looks.iter().zip(&others) {
                    for (k, (place, allowed)) in places.iter().enumerate() {
                        let there = PathPoint::on(task.surface, &other.curve, k as f64 / (places.len() - 1) as f64);
                        most = most.max(beside(place, &there) / allowed);
                    }
                }
                Ok(most)
            };
            let mut step = 0.01_f64.min(0.5 - inset);
            for _ in 0..40 {
                let taken = used((inset + step).min(INNERMOST))?;
                if taken <= 1.0 && (taken > 0.95 || inset + step >= 0.5) {
                    break;
                }
                step = (step * (0.98 / taken.max(LEAST_USED)).clamp(0.1, 10.0)).min(0.5 - inset);
            }
            inset += step;
            if inset < INNERMOST {
                insets.push(inset);
            }
            if insets.len() > MOST_RINGS || step < LEAST_STEP {
                return Err(PathError::TooLong);
            }
        }
        Ok(insets)
    }
}

impl Strategy for Pocket {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        check_along(self.round)?;
        check_along(self.along)?;
        let mut insets = self.insets(task)?;
        if self.outwards {
            insets.reverse();
        }
        let mut lines: Vec<Line> = Vec::new();
        for (k, &inset) in insets.iter().enumerate() {
            if k > 0 {
                let [from, to] = [insets[k - 1], inset].map(|i| self.corners(task, i)[0]);
                let curve = ParameterCurve::straight(from, to);
                let what = format!("two rings lie on each other at {inset}");
                let curve = curve.ok_or(PathError::NoLine { what, section: inset })?;
                lines.push(Line { joined: true, ..Line::new(format!("to ring {inset:.5}"), curve) });
            }
            lines.extend(self.ring(task, inset)?);
        }
        if let Some(first) = lines.first_mut() {
            first.joined = false;
        }
        Ok(lines)
    }
}
