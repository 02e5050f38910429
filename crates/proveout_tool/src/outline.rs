//! Open generating curves of whole parts, and their division into convex bodies.

use crate::profile::{CONVEX_RAD, JOIN_MM, distance};
use crate::{Profile, ProfileError, Segment};

/// Generating curve of a part of a tool: from a point of the axis outward and upward, z never falling, left
/// open at the top. Need not be convex.
///
/// ```text
///  z ^        to
///    |     |
///    |     |          a joint that turns to the right (outward again) is
///    |    /           where [`ToolOutline::convex_bodies`] divides the part
///    |   |
///    |___|
///    +-------> r
///  start
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ToolOutline {
    segments: Vec<Segment>,
    end: [f64; 2],
}

impl ToolOutline {
    /// A curve that begins on the axis at height `z` (mm).
    pub(crate) fn start(z: f64) -> Self {
        Self { segments: Vec::new(), end: [0.0, z] }
    }

    /// Adds a straight line; one of no length adds nothing.
    pub(crate) fn line(mut self, to: [f64; 2]) -> Self {
        if distance(self.end, to) > JOIN_MM {
            self.segments.push(Segment::Line { from: self.end, to });
            self.end = to;
        }
        self
    }

    /// Adds a counter-clockwise arc; one of no length adds nothing.
    pub(crate) fn arc(mut self, center: [f64; 2], to: [f64; 2]) -> Self {
        if distance(self.end, to) > JOIN_MM {
            let radius = distance(center, to);
            self.segments.push(Segment::Arc { center, radius, from: self.end, to });
            self.end = to;
        }
        self
    }

    /// The open end `[r, z]`, mm.
    pub(crate) fn end(&self) -> [f64; 2] {
        self.end
    }

    /// The curve with a cylinder on its open end, up to `z` (mm).
    pub(crate) fn extended(self, z: f64) -> Self {
        let r = self.end[0];
        if z > self.end[1] { self.line([r, z]) } else { self }
    }

    /// Index of the first segment whose z falls, or that is not a piece of a curve (zero or negative radius).
    pub(crate) fn first_falling(&self) -> Option<usize> {
        self.segments.iter().position(|s| {
            let falls = s.to()[1] < s.from()[1] - JOIN_MM;
            let arc_falls = matches!(*s, Segment::Arc { center, radius, from, to }
                // A counter-clockwise arc rises only on the right half of its circle.
                if from[0] < center[0] - radius * CONVEX_RAD || to[0] < center[0] - radius * CONVEX_RAD);
            falls || arc_falls
        })
    }

    /// Cuts the curve by the plane at height `z` (mm). The upper part begins on the axis at `z`; parts may be
    /// empty.
    pub(crate) fn split_at(&self, z: f64) -> (Self, Self) {
        let first = self.segments.first().map_or(self.end, Segment::from);
        let mut below = Self::start(first[1]);
        let mut above = Self::start(z);
        for s in &self.segments {
            let (from, to) = (s.from(), s.to());
            if to[1] <= z + JOIN_MM {
                below = below.with(*s);
            } else if from[1] >= z - JOIN_MM {
                above = above.line([from[0], z]).with(*s);
            } else {
                let cut = match *s {
                    Segment::Line { .. } => {
                        let t = (z - from[1]) / (to[1] - from[1]);
                        [from[0] + t * (to[0] - from[0]), z]
                    }
                    Segment::Arc { center, radius, .. } => {
                        let h = z - center[1];
                        [center[0] + (radius * radius - h * h).max(0.0).sqrt(), z]
                    }
                };
                let (low, high) = match *s {
                    Segment::Line { .. } => (Segment::Line { from, to: cut }, Segment::Line { from: cut, to }),
                    Segment::Arc { center, radius, .. } => {
                        (Segment::Arc { center, radius, from, to: cut }, Segment::Arc { center, radius, from: cut, to })
                    }
                };
                below = below.with(low);
                above = above.line(cut).with(high);
            }
        }
        (below, above)
    }

    fn with(self, s: Segment) -> Self {
        match s {
            Segment::Line { to, .. } => self.line(to),
            Segment::Arc { center, to, .. } => self.arc(center, to),
        }
    }

    /// Divides the part by planes across the axis into convex bodies, from the lowest to the highest.
    pub(crate) fn convex_bodies(&self) -> Result<Vec<Profile>, ProfileError> {
        let mut bodies = Vec::new();
        let mut run: Vec<Segment> = Vec::new();
        let mut heading = [1.0, 0.0];
        for s in &self.segments {
            let start = s.tangent(s.from());
            let turn = heading[0] * start[1] - heading[1] * start[0];
            if turn < -CONVEX_RAD && !run.is_empty() {
                bodies.extend(closed(std::mem::take(&mut run))?);
                let from = s.from();
                if from[0] > JOIN_MM {
                    run.push(Segment::Line { from: [0.0, from[1]], to: from });
                }
            }
            run.push(*s);
            heading = s.tangent(s.to());
        }
        bodies.extend(closed(run)?);
        Ok(bodies)
    }
}

/// Closes a curve to the axis; none when it encloses nothing.
fn closed(mut run: Vec<Segment>) -> Result<Option<Profile>, ProfileError> {
    let (Some(first), Some(last)) = (run.first(), run.last()) else { return Ok(None) };
    let (low, top) = (first.from(), last.to());
    if top[1] - low[1] <= JOIN_MM {
        return Ok(None);
    }
    if top[0] > JOIN_MM {
        run.push(Segment::Line { from: top, to: [0.0, top[1]] });
    }
    Profile::new(run).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stepped_part_is_divided_at_its_steps() {
        // Neck of radius 2, cone to 3, collar of 5, then 3 again.
        let part = ToolOutline::start(0.0)
            .line([2.0, 0.0])
            .line([2.0, 5.0])
            .line([3.0, 6.0])
            .line([3.0, 8.0])
            .line([5.0, 8.0])
            .line([5.0, 9.0])
            .line([3.0, 9.0])
            .line([3.0, 12.0]);
        let bodies = part.convex_bodies().expect("bodies");
        let heights: Vec<_> = bodies.iter().map(|b| (b.z_min(), b.z_max())).collect();
        assert_eq!(heights, [(0.0, 5.0), (5.0, 8.0), (8.0, 9.0), (9.0, 12.0)]);
        let volume: f64 = bodies.iter().map(Profile::volume).sum();
        let frustum = (4.0 + 6.0 + 9.0) / 3.0;
        let exact = std::f64::consts::PI * (4.0 * 5.0 + frustum + 9.0 * 2.0 + 25.0 + 9.0 * 3.0);
        assert!((volume - exact).abs() < 1e-9);
    }

    #[test]
    fn cutting_keeps_the_volume() {
        let ball = ToolOutline::start(0.0).arc([0.0, 4.0], [4.0, 4.0]).extended(20.0);
        for z in [0.5, 3.9, 4.0, 7.0, 19.999] {
            let (below, above) = ball.split_at(z);
            let volume: f64 =
                [below, above].iter().flat_map(|o| o.convex_bodies().expect("convex")).map(|b| b.volume()).sum();
            let exact = std::f64::consts::PI * (2.0 / 3.0 * 64.0 + 16.0 * 16.0);
            assert!((volume - exact).abs() < 1e-9, "{z}: {volume}");
        }
    }
}
