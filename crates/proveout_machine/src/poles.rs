//! Singular poses along a path: keeping a branch, leaving and reaching a pole.
//!
//! Along a path of tool axes that meets no singular pose each branch of [`Machine::inverse`] is a separate
//! curve: the height over the plane of both rotary axes, whose sign gives the branch, has no zero there. A
//! control that follows a path therefore never looks for the nearest solution; it keeps its branch. In a
//! pole (the first rotary joint does not turn the tool there) the height is zero: the path continues in
//! either branch, with the first joint at the angle that the direction of departure requires.

use proveout_geom::{Vector, wrap_near};

use crate::{AXIS_TOLERANCE, JointValues, Machine, inverse::unwrapped};

impl Machine {
    /// Cone about a pole where none is stated, radian (0.001 degrees). It moves the flank of a tool by 0.9
    /// micrometers at 50 mm from the tip, less than any control resolves on a surface, and is wide enough
    /// for axes written with five digits.
    pub const USUAL_POLE_CONE: f64 = 0.001 * std::f64::consts::PI / 180.0;
    /// The widest cone about a pole that is taken, radian (5 degrees).
    pub const WIDEST_POLE_CONE: f64 = 5.0 * std::f64::consts::PI / 180.0;

    /// Tool axes (unit vectors of K) at which the first of two rotary joints, the one on the table's side,
    /// does not turn the tool: the poles. None, one, or two opposite ones. Travel is not checked. Held
    /// joints keep their values in `at`.
    pub fn poles(&self, at: &JointValues) -> impl Iterator<Item = Vector> + use<> {
        let pair = self.solver.pair(&self.chain, at);
        let poles = pair.map_or([None; 2], |pair| pair.poles());
        poles.map(|pole| pole.map(|p| self.solver.seen_from_outside(&self.chain, at, &p))).into_iter().flatten()
    }

    /// Branch ([`crate::Branch::index`]) of the two rotary joints; none in a singular pose, and on machines
    /// with fewer or more rotary joints.
    pub fn branch_of(&self, q: &JointValues) -> Option<usize> {
        let pair = self.solver.pair(&self.chain, q)?;
        let second = *self.solver.rotary().get(1)?;
        pair.branch_of(q[second])
    }

    /// The rotary joints that point the tool along a unit vector of K on this branch, each at the turn
    /// nearest to `near`; the other joints are those of `near`. Travel is not looked at. None where the tool
    /// axis cannot be reached, and on machines that have not two rotary joints.
    pub fn on_branch(&self, axis_in_table: &Vector, branch: usize, near: &JointValues) -> Option<JointValues> {
        let pair = self.solver.pair(&self.chain, near)?;
        let found = pair.solve(&self.solver.seen_by_pair(&self.chain, near, axis_in_table));
        if found.error.is_nan() || found.error > AXIS_TOLERANCE {
            return None;
        }
        let angles = found.angles[branch.min(found.count.saturating_sub(1))];
        let mut q = *near;
        for (k, (&joint, angle)) in self.solver.rotary().iter().zip(angles).enumerate() {
            if !(found.free_first && k == 0) {
                q[joint] = wrap_near(angle, near[joint]);
            }
        }
        q.is_finite().then_some(q)
    }

    /// The rotary joints of both branches for a tool that leaves (or reaches) a pole in a direction, in the
    /// limit of a path of zero length. `pole` and `direction` are unit vectors of K; `direction` is
    /// perpendicular to the pole. Each joint is at the turn nearest to `near` that its travel admits; the
    /// other joints are those of `near`. `None` on machines that do not have two rotary joints.
    pub fn leaving_pole(&self, pole: &Vector, direction: &Vector, near: &JointValues) -> Option<[JointValues; 2]> {
        let pair = self.solver.pair(&self.chain, near)?;
        let seen = |v: &Vector| self.solver.seen_by_pair(&self.chain, near, v);
        let both = pair.leave(&seen(pole), &seen(direction));
        Some(both.map(|angles| {
            let mut q = *near;
            for (&joint, angle) in self.solver.rotary().iter().zip(angles) {
                q[joint] = unwrapped(&self.joints[joint], angle, near[joint]);
            }
            q
        }))
    }
}
