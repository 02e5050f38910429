use nalgebra::SMatrix;
use proveout_geom::{Pose, Vector};

use crate::{JointValues, MAX_JOINTS, Machine};

/// Rates of the tip (rows 0 to 2, mm) and of the tool axis (rows 3 to 5) in K with each joint (mm or radian).
pub type Jacobian = SMatrix<f64, 6, MAX_JOINTS>;

impl Machine {
    /// Analytic derivative of [`Machine::forward`] by the joint values. Columns of unused joints are zero.
    ///
    /// A joint turns everything nearer to the tool about its current line (the spatial screw): the tip
    /// moves with w x (tip - p) and the axis with w x axis (Lynch and Park 2017, section 5.1.1).
    pub fn jacobian(&self, q: &JointValues, tool_length: f64) -> Jacobian {
        let pose = self.forward(q, tool_length);
        let mut jacobian = Jacobian::zeros();
        let mut before = Pose::identity();
        for link in &self.chain.links {
            let direction = before.vector(&link.direction);
            let mut column = jacobian.column_mut(link.joint);
            if link.rotary {
                let arm = pose.tip - before.point(&link.point);
                column
                    .fixed_rows_mut::<3>(0)
                    .copy_from(&(direction.cross(&arm) + before.vector(&link.shift_rate(q[link.joint]))));
                column.fixed_rows_mut::<3>(3).copy_from(&direction.cross(&pose.axis));
            } else {
                column.fixed_rows_mut::<3>(0).copy_from(&direction);
            }
            before = before * link.pose(q[link.joint]);
        }
        jacobian
    }

    /// Rate at which the rotary joints turn, at worst, for one radian of tool axis change: the reciprocal of
    /// the smallest singular value of d(axis)/d(rotary joints). At least one half on any machine, about 1 /
    /// sin(tilt) on a machine whose table turns about the upright tool, infinite at a singular pose. `None`
    /// on machines with fewer than two rotary joints.
    ///
    /// ```
    /// use proveout_geom::rad;
    /// use proveout_machine::Machine;
    ///
    /// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// let mut q = machine.home(); // upright: C turns about the tool
    /// assert_eq!(machine.rotary_amplification(&q), Some(f64::INFINITY));
    /// q[machine.joint("B").expect("it swivels")] = rad(30.0);
    /// let factor = machine.rotary_amplification(&q).expect("two rotary joints");
    /// assert!((factor - 2.0).abs() < 1e-9); // 1 / sin 30 degrees
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn rotary_amplification(&self, q: &JointValues) -> Option<f64> {
        Some(1.0 / self.smallest_axis_rate(q)?)
    }

    /// Smallest singular value of d(axis)/d(rotary joints), 0 at a singular pose: the least turn of the tool
    /// axis, in radian, for a joint step of length one radian. With more than two rotary joints: of the steps
    /// that turn it at all (the second singular value).
    pub fn smallest_axis_rate(&self, q: &JointValues) -> Option<f64> {
        let rotary = self.rotary_joints();
        if rotary.len() < 2 {
            return None;
        }
        let jacobian = self.jacobian(q, 0.0);
        let rate = |j: usize| -> Vector { jacobian.fixed_view::<3, 1>(3, j).into() };
        // All rates lie across the tool axis, so there are two singular values at most. Their product squared
        // is the sum of |a x b|² over the pairs of rates (Cauchy and Binet), their square sum that of |a|²;
        // their sum and difference are better conditioned than the eigenvalues of the normal matrix.
        let (mut squares, mut products) = (0.0, 0.0);
        for (k, &first) in rotary.iter().enumerate() {
            let a = rate(first);
            squares += a.norm_squared();
            products += rotary[k + 1..].iter().map(|&second| a.cross(&rate(second)).norm_squared()).sum::<f64>();
        }
        let product = products.sqrt();
        let sum = (squares + 2.0 * product).sqrt();
        let difference = (squares - 2.0 * product).max(0.0).sqrt();
        let largest = 0.5 * (sum + difference);
        Some(if largest > 0.0 { product / largest } else { 0.0 })
    }
}
