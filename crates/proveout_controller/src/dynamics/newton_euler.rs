//! Inverse dynamics of the tree of joints by recursive Newton-Euler in spatial vectors.
//!
//! All spatial vectors are written in the one frame M, at its origin: motion `(w, v)` with the velocity v of the body
//! point that passes the origin, force `(n, f)` with the moment n about the origin. A joint's axis is then a screw
//!
//! ```text
//!   rotary  S = (a, p x a)        linear  S = (0, a)        a, p: axis and a point on it as they stand now
//!
//!   out:   V_i = V_p + S_i q.                                 p: the carrying link, base: V = 0
//!          A_i = A_p + S_i q.. + V_i x S_i q.                 base: A = (0, g up), which is gravity for all
//!          F_i = I_i A_i + V_i x* I_i V_i
//!   back:  F_p += F_i,   tau_i = S_i . F_i
//! ```
//!
//! (Luh, Walker and Paul 1980; Featherstone 2008, section 5.3, here in base coordinates so that no frames between the
//! joints are needed, as in the forward kinematics.) Cost is linear in the number of joints; nothing is allocated.
//!
//! Limits: the links are rigid, and the tree has no loops.

use nalgebra::{Matrix3, SMatrix};
use proveout_geom::{Pose, Vector};
use proveout_machine::{JointValues, MAX_JOINTS};

use super::tree::RigidTree;

/// Standard acceleration of free fall, mm/s² (3rd CGPM, 1901).
pub const STANDARD_GRAVITY: f64 = 9806.65;

/// Inertia of the joints in kg, kg mm and kg mm²; rows and columns of unused joints are zero.
pub type MassMatrix = SMatrix<f64, MAX_JOINTS, MAX_JOINTS>;

/// Forces in kg mm/s² make N, torques in kg mm²/s² make N mm.
const TO_NEWTON: f64 = 1e-3;

/// A spatial vector: angular part, linear part.
#[derive(Clone, Copy)]
struct Spatial(Vector, Vector);

impl Spatial {
    const ZERO: Self = Self(Vector::new(0.0, 0.0, 0.0), Vector::new(0.0, 0.0, 0.0));

    fn plus(self, other: Self, factor: f64) -> Self {
        Self(self.0 + other.0 * factor, self.1 + other.1 * factor)
    }

    /// Motion cross motion.
    fn cross(self, m: Self) -> Self {
        Self(self.0.cross(&m.0), self.0.cross(&m.1) + self.1.cross(&m.0))
    }

    /// Motion cross force.
    fn cross_force(self, f: Self) -> Self {
        Self(self.0.cross(&f.0) + self.1.cross(&f.1), self.0.cross(&f.1))
    }

    fn dot(self, other: Self) -> f64 {
        self.0.dot(&other.0) + self.1.dot(&other.1)
    }
}

/// A link where it stands.
#[derive(Clone, Copy)]
struct Placed {
    pose: Pose,
    screw: Spatial,
    mass: f64,
    center: Vector,
    inertia: Matrix3<f64>,
    motion: Spatial,
    acceleration: Spatial,
    force: Spatial,
}

impl Placed {
    fn momentum(&self, v: Spatial) -> Spatial {
        let linear = (v.1 + v.0.cross(&self.center)) * self.mass;
        Spatial(self.inertia * v.0 + self.center.cross(&linear), linear)
    }
}

impl RigidTree {
    fn placed(&self, q: &JointValues) -> [Placed; MAX_JOINTS] {
        let nothing = Placed {
            pose: Pose::identity(),
            screw: Spatial::ZERO,
            mass: 0.0,
            center: Vector::zeros(),
            inertia: Matrix3::zeros(),
            motion: Spatial::ZERO,
            acceleration: Spatial::ZERO,
            force: Spatial::ZERO,
        };
        let mut all = [nothing; MAX_JOINTS];
        for (i, link) in self.links.iter().enumerate() {
            let before = link.parent.map_or_else(Pose::identity, |p| all[p].pose);
            let axis = before.vector(&link.axis);
            let (screw, motion) = if link.rotary {
                let p = before.point(&link.point);
                (Spatial(axis, p.coords.cross(&axis)), Pose::about_line(&link.point, &link.axis, q[link.joint]))
            } else {
                (Spatial(Vector::zeros(), axis), Pose::from_translation(link.axis * q[link.joint]))
            };
            let pose = before * motion;
            let r = pose.rotation;
            all[i] = Placed {
                pose,
                screw,
                mass: link.mass,
                center: pose.point(&link.center).coords,
                inertia: r * link.inertia * r.transpose(),
                ..nothing
            };
        }
        all
    }

    /// Forces (N) and torques (N mm) that the joints need for the given positions, velocities and accelerations, weight
    /// included where the direction of gravity is known. Friction and the motors' own inertia are not in it.
    pub fn inverse_dynamics(&self, q: &JointValues, v: &JointValues, a: &JointValues) -> JointValues {
        let mut all = self.placed(q);
        let lift = self.up.map_or_else(Vector::zeros, |up| up * STANDARD_GRAVITY);
        let base = Spatial(Vector::zeros(), lift);
        let mut tau = JointValues::ZERO;
        for (i, link) in self.links.iter().enumerate() {
            let (before, rising) = link.parent.map_or((Spatial::ZERO, base), |p| (all[p].motion, all[p].acceleration));
            let b = &mut all[i];
            let rate = Spatial::ZERO.plus(b.screw, v[link.joint]);
            b.motion = before.plus(rate, 1.0);
            b.acceleration = rising.plus(b.screw, a[link.joint]).plus(b.motion.cross(rate), 1.0);
            b.force = b.momentum(b.acceleration).plus(b.motion.cross_force(b.momentum(b.motion)), 1.0);
        }
        for (i, link) in self.links.iter().enumerate().rev() {
            tau[link.joint] = all[i].screw.dot(all[i].force) * TO_NEWTON;
            if let Some(p) = link.parent {
                let force = all[i].force;
                all[p].force = all[p].force.plus(force, 1.0);
            }
        }
        tau
    }

    /// Inertia matrix of the joints, from the bodies alone: the composite of all that a joint carries, moved by it and by
    /// the joints before it (Featherstone 2008, section 6.2).
    pub fn mass_matrix(&self, q: &JointValues) -> MassMatrix {
        let all = self.placed(q);
        let mut matrix = MassMatrix::zeros();
        for (i, link) in self.links.iter().enumerate() {
            let mut force = Spatial::ZERO;
            for (k, body) in all.iter().enumerate().take(self.links.len()) {
                if self.hangs_on(k, i) {
                    force = force.plus(body.momentum(all[i].screw), 1.0);
                }
            }
            let mut at = Some(i);
            while let Some(k) = at {
                let m = all[k].screw.dot(force);
                matrix[(link.joint, self.links[k].joint)] = m;
                matrix[(self.links[k].joint, link.joint)] = m;
                at = self.links[k].parent;
            }
        }
        matrix
    }

    /// Accelerations for given forces (N, N mm): the inverse of [`RigidTree::inverse_dynamics`]. `armature` is added to
    /// the diagonal of the inertia (kg, kg mm²): motors. None where a joint would move no mass.
    pub fn forward_dynamics(
        &self,
        q: &JointValues,
        v: &JointValues,
        tau: &JointValues,
        armature: &JointValues,
    ) -> Option<JointValues> {
        let bias = self.inverse_dynamics(q, v, &JointValues::ZERO);
        let mut matrix = self.mass_matrix(q);
        let used: Vec<usize> = self.links.iter().map(|l| l.joint).collect();
        for j in 0..MAX_JOINTS {
            matrix[(j, j)] += if used.contains(&j) { armature[j] } else { 1.0 };
        }
        let rest = (*tau - bias) * (1.0 / TO_NEWTON);
        let solution = matrix.cholesky()?.solve(&nalgebra::SVector::from(rest.0));
        Some(JointValues(solution.into()))
    }

    fn hangs_on(&self, mut link: usize, on: usize) -> bool {
        loop {
            if link == on {
                return true;
            }
            match self.links[link].parent {
                Some(p) => link = p,
                None => return false,
            }
        }
    }
}
