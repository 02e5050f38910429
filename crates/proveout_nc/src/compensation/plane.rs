//! The working plane in base coordinates.

use super::contour::Point;
use crate::frame::{self, Frame};
use crate::{AXIS_LETTERS, AxisValues};

/// Directions of the working plane in base coordinates: unit vectors, also under a frame that scales all axes
/// alike.
///
/// Under a mirror `u`, `v` are a left-handed pair: what is left in the program stays left in `u` and `v`, so
/// the whole path is the mirror image, as on the controls, which swap G41 and G42 then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CompPlane {
    u: [f64; 3],
    v: [f64; 3],
    /// `u` x `v`: circles that run counter-clockwise in the plane do so about it.
    pub(super) normal: [f64; 3],
    /// The same direction in work coordinates.
    pub(super) work_normal: [f64; 3],
    /// Away from the work, as the program counts the third axis: `normal`, or against it under a mirror.
    up: [f64; 3],
    /// Bits of the two axes of the plane in a block.
    pub(super) axes: u16,
    /// mm in base coordinates for each mm of the program.
    pub(super) scale: f64,
}

impl CompPlane {
    /// Plane with this normal axis (0 X, 1 Y, 2 Z) under a frame; none when the frame scales the axes
    /// differently.
    pub(super) fn new(normal: usize, frame: &Frame) -> Option<Self> {
        let scale = frame.uniform_scale()?;
        let axis = |i: usize| {
            let mut work = [0.0; 3];
            if let Some(component) = work.get_mut(i % 3) {
                *component = 1.0;
            }
            work
        };
        let base = |i: usize| frame.apply_vector(axis(i)).map(|c| c / scale + 0.0);
        let (u, v) = (base(normal + 1), base(normal + 2));
        Some(Self {
            u,
            v,
            normal: frame::cross(u, v).map(|c| c + 0.0),
            work_normal: axis(normal),
            up: base(normal),
            axes: 1 << ((normal + 1) % 3) | 1 << ((normal + 2) % 3),
            scale,
        })
    }

    /// Coordinates in the plane; the letters of the axes that are missing otherwise.
    pub(super) fn project(&self, base: &AxisValues) -> Result<Point, String> {
        let mut point = [0.0; 2];
        let mut missing = String::new();
        for ((coordinate, direction), _) in point.iter_mut().zip([self.u, self.v]).zip(0..) {
            for (axis, factor) in direction.into_iter().enumerate().filter(|(_, factor)| *factor != 0.0) {
                match (base.get(axis), AXIS_LETTERS.get(axis)) {
                    (Some(value), _) => *coordinate += factor * value,
                    (None, Some(&letter)) if !missing.contains(letter) => missing.push(letter),
                    _ => {}
                }
            }
        }
        if missing.is_empty() { Ok(point) } else { Err(missing) }
    }

    /// Coordinates in the plane of a point in space.
    pub(super) fn project_point(&self, base: [f64; 3]) -> Point {
        [frame::dot(self.u, base), frame::dot(self.v, base)]
    }

    /// Base coordinates of a point of the plane at a height over it; those that depend on an
    /// unknown height are left out.
    pub(super) fn point(&self, at: Point, height: Option<f64>) -> AxisValues {
        let mut values = AxisValues::NONE;
        for (axis, (u, (v, n))) in self.u.into_iter().zip(self.v.into_iter().zip(self.up)).enumerate() {
            if let Some(height) = height.or((n == 0.0).then_some(0.0)) {
                values.put(axis, u * at[0] + v * at[1] + n * height + 0.0);
            }
        }
        values
    }

    /// Height over the plane through the origin, where it is known.
    pub(super) fn height(&self, base: &AxisValues) -> Option<f64> {
        let mut height = 0.0;
        for (axis, factor) in self.up.into_iter().enumerate().filter(|(_, factor)| *factor != 0.0) {
            height += factor * base.get(axis)?;
        }
        Some(height)
    }

    /// Moves a point by a vector of the plane; axes without a value stay without.
    pub(super) fn shift(&self, base: &mut AxisValues, by: Point) {
        let vector = frame::add_scaled(self.u.map(|c| c * by[0]), self.v, by[1]);
        for (axis, change) in vector.into_iter().enumerate() {
            if let Some(value) = base.get(axis)
                && change != 0.0
            {
                base.put(axis, value + change + 0.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifting_moves_the_projection() {
        let frame = Frame::rpy([20.0, -35.0, 110.0]).then(&Frame::scale([-2.0, 2.0, 2.0]));
        let plane = CompPlane::new(1, &frame).unwrap();
        assert!((plane.scale - 2.0).abs() < 1e-12);
        let mut point = AxisValues::NONE;
        for (axis, value) in [1.0, -2.0, 3.0].into_iter().enumerate() {
            point.put(axis, value);
        }
        let before = plane.project(&point).unwrap();
        plane.shift(&mut point, [0.3, -0.7]);
        let after = plane.project(&point).unwrap();
        assert!((after[0] - before[0] - 0.3).abs() < 1e-14 && (after[1] - before[1] + 0.7).abs() < 1e-14);
        assert_eq!(CompPlane::new(2, &Frame::scale([1.0, 2.0, 1.0])), None);
        assert_eq!(CompPlane::new(2, &Frame::IDENTITY).unwrap().project(&AxisValues::NONE), Err("XY".to_owned()));
    }
}
