use std::ops::Mul;

use nalgebra::Matrix3;

use crate::{Point, Vector, sin_cos};

/// Rigid transform `a_from_b`: coordinates in frame b to coordinates in frame a.
///
/// The rotation is kept as a matrix, so that right angles stay exact, and is built from joint values each
/// time, so that no rounding accumulates. Products read left to right: `a_from_b * b_from_c` is `a_from_c`.
///
/// ```
/// use proveout_geom::{Point, Pose, Vector, rad};
///
/// // The workpiece stands 100 mm along X of the table, turned by 90 degrees about Z.
/// let turn = Pose::from_axis_angle(&Vector::z(), rad(90.0));
/// let table_from_work = Pose::from_translation(Vector::new(100.0, 0.0, 0.0)) * turn;
/// let in_table = table_from_work.point(&Point::new(20.0, 0.0, 5.0));
/// assert_eq!(in_table, Point::new(100.0, 20.0, 5.0)); // mm, exact
/// let work_from_table = table_from_work.inverse();
/// assert_eq!(work_from_table.point(&in_table), Point::new(20.0, 0.0, 5.0));
/// assert!((work_from_table.translation.norm() - 100.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation, orthonormal with determinant one (3 x 3; columns are the axes of b in a).
    pub rotation: Matrix3<f64>,
    /// Origin of b in a, mm.
    pub translation: Vector,
}

impl Default for Pose {
    fn default() -> Self {
        Self::identity()
    }
}

impl Pose {
    /// The transform that changes nothing.
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector::zeros() }
    }

    /// Pure translation, mm.
    pub fn from_translation(translation: Vector) -> Self {
        Self { rotation: Matrix3::identity(), translation }
    }

    /// Right-handed rotation by `angle` (radian) about the unit vector `axis` through the origin (Rodrigues
    /// 1840).
    pub fn from_axis_angle(axis: &Vector, angle: f64) -> Self {
        let (s, c) = sin_cos(angle);
        let k = axis.cross_matrix();
        let rotation = Matrix3::identity() * c + k * s + axis * axis.transpose() * (1.0 - c);
        Self { rotation, translation: Vector::zeros() }
    }

    /// Right-handed rotation by `angle` (radian) about the line through `point` along the unit vector `axis`.
    pub fn about_line(point: &Point, axis: &Vector, angle: f64) -> Self {
        let turn = Self::from_axis_angle(axis, angle);
        let translation = point.coords - turn.rotation * point.coords;
        Self { rotation: turn.rotation, translation }
    }

    /// Rotation Rz(z) Ry(y) Rx(x) after fixed axes, radian (roll, pitch, yaw), then the translation, mm.
    pub fn from_rpy(translation: Vector, x: f64, y: f64, z: f64) -> Self {
        let turn = Self::from_axis_angle(&Vector::z(), z)
            * Self::from_axis_angle(&Vector::y(), y)
            * Self::from_axis_angle(&Vector::x(), x);
        Self { rotation: turn.rotation, translation }
    }

    /// `b_from_a` of this `a_from_b`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// `p_in_a` of `p_in_b`.
    #[inline]
    pub fn point(&self, p_in_b: &Point) -> Point {
        Point::from(self.rotation * p_in_b.coords + self.translation)
    }

    /// A free vector or direction, turned from b to a.
    pub fn vector(&self, v_in_b: &Vector) -> Vector {
        self.rotation * v_in_b
    }

    /// True when every number is finite.
    pub fn is_finite(&self) -> bool {
        self.rotation.iter().chain(self.translation.iter()).all(|v| v.is_finite())
    }

    /// The same transform as a nalgebra isometry, for libraries that want quaternions.
    pub fn to_isometry(&self) -> nalgebra::Isometry3<f64> {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(self.rotation);
        nalgebra::Isometry3::from_parts(
            self.translation.into(),
            nalgebra::UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }
}

impl Mul for Pose {
    type Output = Self;

    fn mul(self, b_from_c: Self) -> Self {
        Self {
            rotation: self.rotation * b_from_c.rotation,
            translation: self.rotation * b_from_c.translation + self.translation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rad;

    #[test]
    fn quarter_turns_are_exact_matrices() {
        let turn = Pose::from_axis_angle(&Vector::y(), rad(90.0));
        assert_eq!(turn.vector(&Vector::z()), Vector::x());
        assert_eq!(turn.vector(&Vector::x()), -Vector::z());
    }

    #[test]
    fn inverse_undoes_and_lines_stay_fixed() {
        let point = Point::new(3.0, -7.0, 11.0);
        let axis = Vector::new(1.0, 2.0, -2.0) / 3.0;
        let pose = Pose::about_line(&point, &axis, 0.7);
        assert!((pose.point(&(point + axis * 5.0)) - (point + axis * 5.0)).norm() < 1e-14);
        let p = Point::new(-1.0, 4.0, 2.0);
        let back = pose.inverse().point(&pose.point(&p));
        assert!((back - p).norm() < 1e-14);
        let both = pose * pose.inverse();
        assert!((both.rotation - Matrix3::identity()).norm() < 1e-15);
    }

    #[test]
    fn isometry_agrees() {
        let pose = Pose::from_rpy(Vector::new(1.0, 2.0, 3.0), 0.3, -0.8, 2.9);
        let p = Point::new(-1.0, 4.0, 2.0);
        assert!((pose.to_isometry() * p - pose.point(&p)).norm() < 1e-14);
    }
}
