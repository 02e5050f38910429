use crate::{Point, Pose, Vector};

/// Sine between axes below which the axis does not turn: opposite ones have no great circle.
const NO_TURN: f64 = 1e-12;

/// A turn of the tool axis about a direction, with the center of the tool's ball held:
/// `V(a) = sqrt(1 - axial^2) (basis[0] cos a + basis[1] sin a) + axial basis[2]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisTurn {
    /// Center of the ball, mm.
    pub center: Point,
    /// The result holds for all centers no farther away than this, mm.
    pub drift: f64,
    /// Unit vectors at right angles to each other.
    pub basis: [Vector; 3],
    /// Sine of the inclination of the axis.
    pub axial: f64,
    /// The result holds for all axes no farther from those of the turn than this, radian.
    pub spread: f64,
}

/// Tip and axis of a tool in one frame: a cutter location. The turn about the axis is left open, since every
/// body of a tool assembly is a body of revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    /// Programmed tip, mm.
    pub tip: Point,
    /// Unit vector from the tip to the holder.
    pub axis: Vector,
}

impl ToolPose {
    /// The same pose seen from frame a.
    pub fn transformed(&self, a_from_b: &Pose) -> Self {
        Self { tip: a_from_b.point(&self.tip), axis: a_from_b.vector(&self.axis) }
    }

    /// Pose at `t` in 0..=1 on the way to `to`: the tip straight, the axis on the great circle, both uniform
    /// (Shoemake 1985, spherical linear interpolation). For opposite axes the great circle is not defined;
    /// the axis then stays.
    ///
    /// ```
    /// use proveout_geom::{Point, ToolPose, Vector, deg};
    ///
    /// let upright = ToolPose { tip: Point::origin(), axis: Vector::z() };
    /// let lying = ToolPose { tip: Point::new(20.0, 0.0, 0.0), axis: Vector::x() };
    /// let half = upright.interpolated(&lying, 0.5);
    /// assert_eq!(half.tip, Point::new(10.0, 0.0, 0.0)); // mm
    /// assert!((deg(half.angle_to(&upright)) - 45.0).abs() < 1e-9);
    /// ```
    pub fn interpolated(&self, to: &Self, t: f64) -> Self {
        let tip = self.tip + (to.tip - self.tip) * t;
        let sine = self.axis.cross(&to.axis).norm();
        let angle = sine.atan2(self.axis.dot(&to.axis));
        if sine < NO_TURN {
            let axis = if t < 1.0 { self.axis } else { to.axis };
            return Self { tip, axis };
        }
        let axis = self.axis * (((1.0 - t) * angle).sin() / angle.sin()) + to.axis * ((t * angle).sin() / angle.sin());
        Self { tip, axis: axis.normalize() }
    }

    /// Angle between the axes of two poses, radian.
    pub fn angle_to(&self, other: &Self) -> f64 {
        self.axis.cross(&other.axis).norm().atan2(self.axis.dot(&other.axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_way_is_half_the_angle() {
        let a = ToolPose { tip: Point::origin(), axis: Vector::z() };
        let b = ToolPose { tip: Point::new(2.0, 0.0, 0.0), axis: Vector::x() };
        let h = a.interpolated(&b, 0.5);
        assert!((h.tip - Point::new(1.0, 0.0, 0.0)).norm() < 1e-15);
        assert!((h.angle_to(&a) - std::f64::consts::FRAC_PI_4).abs() < 1e-14);
        assert!((h.angle_to(&b) - std::f64::consts::FRAC_PI_4).abs() < 1e-14);
    }
}
