//! How far tip and tool axis leave the planned path, whatever the lag along it.
//!
//! The planned poses are kept for a while as a polyline. A place on it moves forward with the
//! actual tip as long as that brings it nearer; the distance to that place is never below the
//! distance to the path. Where it would be the largest so far, the place is searched on everything
//! that is kept: after a reversal or a rest the forward-moving place may lie on another block. A
//! second place moves forward with the whole tool, with tip and gauge line weighted alike, so that
//! it also advances while the tip is at rest; the axes are compared there.

use std::collections::VecDeque;

use nalgebra::SVector;
use proveout_geom::{Point, ToolPose};

/// Planned poses that are kept: half a second at 2 ms, far more than any lag.
const KEPT: usize = 256;

/// Follows one tool along its planned path.
#[derive(Debug, Default)]
pub(crate) struct Contour {
    path: VecDeque<ToolPose>,
    /// Whether the way to each of the poses counts.
    counts: VecDeque<bool>,
    /// The places of tip and tool lie on the segments from these points.
    at: [usize; 2],
    /// Largest distance of the tip, mm.
    pub(crate) worst: f64,
    /// Largest angle of the tool axis, radian.
    pub(crate) worst_axis: f64,
}

/// Part of the way from a to b that is nearest to p.
fn foot<const N: usize>(p: &SVector<f64, N>, a: &SVector<f64, N>, b: &SVector<f64, N>) -> f64 {
    let d = b - a;
    let length2 = d.norm_squared();
    if length2 > 0.0 { ((p - a).dot(&d) / length2).clamp(0.0, 1.0) } else { 0.0 }
}

/// Tip and gauge line.
fn both(pose: &ToolPose, length: f64) -> SVector<f64, 6> {
    let gauge = pose.tip + pose.axis * length;
    SVector::from_fn(|k, _| if k < 3 { pose.tip[k] } else { gauge[k - 3] })
}

impl Contour {
    /// Takes a planned pose and the actual one of the same time, of a tool of this length, mm; only what
    /// `counts` is kept as worst.
    pub(crate) fn push(&mut self, planned: ToolPose, actual: &ToolPose, length: f64, counts: bool) {
        if self.path.back() != Some(&planned) {
            self.path.push_back(planned);
            self.counts.push_back(counts);
        }
        if self.path.len() > KEPT {
            self.path.pop_front();
            self.counts.pop_front();
            self.at = self.at.map(|at| at.saturating_sub(1));
        }
        let tip = |p: &Point| p.coords;
        let off_tip = |k: usize| {
            let Some(a) = self.path.get(k) else { return f64::INFINITY };
            let b = self.path.get(k + 1).unwrap_or(a);
            let t = foot(&tip(&actual.tip), &tip(&a.tip), &tip(&b.tip));
            (actual.tip - (a.tip + (b.tip - a.tip) * t)).norm()
        };
        let off_tool = |k: usize| {
            let Some(a) = self.path.get(k) else { return (f64::INFINITY, 0.0) };
            let b = self.path.get(k + 1).unwrap_or(a);
            let (p, from, to) = (both(actual, length), both(a, length), both(b, length));
            let t = foot(&p, &from, &to);
            ((p - (from + (to - from) * t)).norm(), a.interpolated(b, t).angle_to(actual))
        };
        let (mut at, mut near) = (self.at[0], off_tip(self.at[0]));
        while at + 2 < self.path.len() {
            let next = off_tip(at + 1);
            if next > near {
                break;
            }
            (at, near) = (at + 1, next);
        }
        let (mut along, mut of_tool) = (self.at[1], off_tool(self.at[1]));
        while along + 2 < self.path.len() {
            let next = off_tool(along + 1);
            if next.0 > of_tool.0 {
                break;
            }
            (along, of_tool) = (along + 1, next);
        }
        let on_path = |k: usize| self.counts.get(k + 1).or(self.counts.get(k)).copied().unwrap_or(false);
        if counts && near > self.worst {
            for k in 0..self.path.len() {
                let found = off_tip(k);
                if found < near {
                    (at, near) = (k, found);
                }
            }
            // After a rapid the machine may still be on its way, which does not count.
            if on_path(at) {
                self.worst = self.worst.max(near);
            }
        }
        if counts && of_tool.1 > self.worst_axis {
            for k in 0..self.path.len() {
                let found = off_tool(k);
                if found.0 < of_tool.0 {
                    (along, of_tool) = (k, found);
                }
            }
            if on_path(along) {
                self.worst_axis = self.worst_axis.max(of_tool.1);
            }
        }
        self.at = [at, along];
    }

    /// Forgets the path: another tool is in the spindle.
    pub(crate) fn restart(&mut self) {
        self.path.clear();
        self.counts.clear();
        self.at = [0, 0];
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::Vector;

    use super::*;

    fn upright(tip: Point) -> ToolPose {
        ToolPose { tip, axis: Vector::z() }
    }

    #[test]
    fn lag_along_the_path_is_no_contour_error() {
        let mut contour = Contour::default();
        for k in 0..1000 {
            let at = |s: f64| upright(Point::new(s, (0.1 * s).sin(), 0.0));
            let s = 0.05 * f64::from(k);
            contour.push(at(s), &at((s - 1.0).max(0.0)), 80.0, true);
        }
        // Chords of 0.05 mm on a curve of 1/100 mm curvature leave it by 0.05²/8/100 mm.
        assert!(contour.worst < 1e-5 && contour.worst_axis == 0.0, "{}", contour.worst);
        let off = contour.path[contour.at[0]].tip + Vector::new(0.0, 0.0, 0.3);
        contour.push(upright(Point::new(50.0, 0.0, 0.0)), &upright(off), 80.0, true);
        assert!((contour.worst - 0.3).abs() < 1e-3);
    }

    #[test]
    fn lag_of_a_turning_tool_is_no_error_of_its_axis() {
        for moves in [0.0, 1.0] {
            let mut contour = Contour::default();
            let at = |s: f64, aside: f64| {
                let (x, y) = (0.01 * s, aside);
                ToolPose {
                    tip: Point::new(moves * s, 0.0, 0.0),
                    axis: Vector::new(x.sin(), y.sin(), x.cos()).normalize(),
                }
            };
            for k in 0..600 {
                let s = 0.05 * f64::from(k);
                contour.push(at(s, 0.0), &at((s - 0.7).max(0.0), 0.0), 80.0, true);
            }
            assert!(contour.worst_axis < 1e-6, "{moves}: {}", contour.worst_axis);
            contour.push(at(30.0, 0.0), &at(29.3, 0.002), 80.0, true);
            assert!((contour.worst_axis - 0.002).abs() < 1e-5, "{moves}: {}", contour.worst_axis);
        }
    }
}
