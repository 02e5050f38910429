//! How far the tip leaves the planned path, whatever the lag along it.
//!
//! The planned tips are kept for a while as a polyline. A place on it goes forward with the actual tip as long as that
//! brings it nearer; the distance to that place is never below the distance to the path.

use std::collections::VecDeque;

use proveout_geom::Point;

/// Planned tips that are kept: half a second at 2 ms, far more than any lag.
const KEPT: usize = 256;

/// Follows one tool's tip along its planned path.
#[derive(Debug, Default)]
pub(crate) struct Contour {
    path: VecDeque<Point>,
    /// The place lies on the segment from this point.
    at: usize,
    /// Largest distance, mm.
    pub(crate) worst: f64,
}

fn distance(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    let length2 = d.norm_squared();
    let t = if length2 > 0.0 { ((p - a).dot(&d) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + d * t)).norm()
}

impl Contour {
    /// Takes a planned tip and the actual one of the same time.
    pub(crate) fn push(&mut self, planned: Point, actual: &Point) {
        if self.path.back() != Some(&planned) {
            self.path.push_back(planned);
        }
        if self.path.len() > KEPT {
            self.path.pop_front();
            self.at = self.at.saturating_sub(1);
        }
        let reach = |k: usize| match (self.path.get(k), self.path.get(k + 1)) {
            (Some(a), Some(b)) => distance(actual, a, b),
            (Some(a), None) => (actual - a).norm(),
            _ => f64::INFINITY,
        };
        let mut near = reach(self.at);
        while self.at + 2 < self.path.len() {
            let next = reach(self.at + 1);
            if next > near {
                break;
            }
            near = next;
            self.at += 1;
        }
        self.worst = self.worst.max(near);
    }

    /// Forgets the path: another tool is in the spindle.
    pub(crate) fn restart(&mut self) {
        self.path.clear();
        self.at = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lag_along_the_path_is_no_contour_error() {
        let mut contour = Contour::default();
        for k in 0..1000 {
            let at = |s: f64| Point::new(s, (0.1 * s).sin(), 0.0);
            let s = 0.05 * f64::from(k);
            contour.push(at(s), &at((s - 1.0).max(0.0)));
        }
        // Chords of 0.05 mm on a curve of 1/100 mm curvature leave it by 0.05²/8/100 mm.
        assert!(contour.worst < 1e-5, "{}", contour.worst);
        let off = contour.path[contour.at] + proveout_geom::Vector::new(0.0, 0.0, 0.3);
        contour.push(Point::new(50.0, 0.0, 0.0), &off);
        assert!((contour.worst - 0.3).abs() < 1e-3);
    }
}
