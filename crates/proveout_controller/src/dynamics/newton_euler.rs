//! Inverse dynamics of the tree of joints by recursive Newton-Euler in spatial vectors.
//!
//! All spatial vectors are written in the one frame M, at its origin: motion `(w, v)` with the velocity v of
//! the body point that passes the origin, force `(n, f)` with the moment n about the origin. A joint's axis
//! is then a screw
//!
//! ```text
//!   rotary  S = (a, p x a)        linear  S = (0, a)        a, p: axis and a point on it in the present pose
//!
//!   out:   V_i = V_p + S_i q.                                 p: the carrying link, base: V = 0
//!          A_i = A_p + S_i q.. + V_i x S_i q.                 base: A = (0, g up), which is gravity for all
//!          F_i = I_i A_i + V_i x* I_i V_i
//!   back:  F_p += F_i,   tau_i = S_i . F_i
//! ```
//!
//! (Luh, Walker and Paul 1980; Featherstone 2008, section 5.3, here in base coordinates so that no frames
//! between the joints are needed, as in the forward kinematics.) Cost is linear in the number of joints;
//! nothing is allocated.
//!
//! Limits: the links are rigid, and the tree has no loops.

use nalgebra::{Matrix3, SMatrix};
use proveout_geom::{Pose, Vector};
use proveout_machine::{JointValues, MAX_JOINTS};

use super::tree::{RigidLink, RigidTree};

/// Standard acceleration of free fall, mm/s² (3rd CGPM, 1901).
pub const STANDARD_GRAVITY: f64 = 9806.65;

/// Inertia of the joints in kg, kg mm and kg mm²; rows and columns of unused joints are zero.
pub type MassMatrix = SMatrix<f64, MAX_JOINTS, MAX_JOINTS>;

/// Forces in kg mm/s² make N, torques in kg mm²/s² make N mm.
pub(crate) const TO_NEWTON: f64 = 1e-3;

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

/// Pose and motion of a link. Initially all zeros, so that an array of links is made by one fill.
#[derive(Clone, Copy)]
struct LinkMotion {
    rotation: Matrix3<f64>,
    translation: Vector,
    screw: Spatial,
    center: Vector,
    motion: Spatial,
    acceleration: Spatial,
    force: Spatial,
}

impl LinkMotion {
    const NOTHING: Self = Self {
        rotation: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        translation: Vector::new(0.0, 0.0, 0.0),
        screw: Spatial::ZERO,
        center: Vector::new(0.0, 0.0, 0.0),
        motion: Spatial::ZERO,
        acceleration: Spatial::ZERO,
        force: Spatial::ZERO,
    };

    /// The inertia is turned into the body and back with the vector, which takes a third of turning the
    /// tensor.
    fn momentum(&self, link: &RigidLink, v: Spatial) -> Spatial {
        let linear = (v.1 + v.0.cross(&self.center)) * link.mass;
        let spin = self.rotation * (link.inertia * self.rotation.tr_mul(&v.0));
        Spatial(spin + self.center.cross(&linear), linear)
    }
}

impl RigidTree {
    fn placed(&self, q: &JointValues, all: &mut [LinkMotion; MAX_JOINTS]) {
        for (i, link) in self.links.iter().enumerate() {
            let (rotation, translation) = link
                .parent
                .map_or_else(|| (Matrix3::identity(), Vector::zeros()), |p| (all[p].rotation, all[p].translation));
            let axis = rotation * link.axis;
            let b = &mut all[i];
            if link.rotary {
                let p = rotation * link.point.coords + translation;
                let own = Pose::about_line(&link.point, &link.axis, q[link.joint]);
                b.screw = Spatial(axis, p.cross(&axis));
                b.rotation = rotation * own.rotation;
                b.translation = rotation * own.translation + translation;
            } else {
                b.screw = Spatial(Vector::zeros(), axis);
                b.rotation = rotation;
                b.translation = translation + axis * q[link.joint];
            }
            b.center = b.rotation * link.center.coords + b.translation;
        }
    }

    /// Forces (N) and torques (N mm) that the joints need for the given positions, velocities and
    /// accelerations, weight included where the direction of gravity is known. Friction and the motors' own
    /// inertia are not in it.
    pub fn inverse_dynamics(&self, q: &JointValues, v: &JointValues, a: &JointValues) -> JointValues {
        let mut all = [LinkMotion::NOTHING; MAX_JOINTS];
        self.placed(q, &mut all);
        let lift = self.up.map_or_else(Vector::zeros, |up| up * STANDARD_GRAVITY);
        let base = Spatial(Vector::zeros(), lift);
        let mut tau = JointValues::ZERO;
        for (i, link) in self.links.iter().enumerate() {
            let (before, rising) = link.parent.map_or((Spatial::ZERO, base), |p| (all[p].motion, all[p].acceleration));
            let b = &mut all[i];
            let rate = Spatial::ZERO.plus(b.screw, v[link.joint]);
            b.motion = before.plus(rate, 1.0);
            b.acceleration = rising.plus(b.screw, a[link.joint]).plus(b.motion.cross(rate), 1.0);
            b.force = b.momentum(link, b.acceleration).plus(b.motion.cross_force(b.momentum(link, b.motion)), 1.0);
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

    /// Inertia matrix of the joints, from the bodies alone: the composite of all that a joint carries, moved
    /// by it and by the joints before it (Featherstone 2008, section 6.2).
    pub fn mass_matrix(&self, q: &JointValues) -> MassMatrix {
        let mut all = [LinkMotion::NOTHING; MAX_JOINTS];
        self.placed(q, &mut all);
        let mut matrix = MassMatrix::zeros();
        for (i, link) in self.links.iter().enumerate() {
            let mut force = Spatial::ZERO;
            for (k, (body, own)) in all.iter().zip(&self.links).enumerate() {
                if self.hangs_on(k, i) {
                    force = force.plus(body.momentum(own, all[i].screw), 1.0);
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

    /// Accelerations for given forces (N, N mm): the inverse of [`RigidTree::inverse_dynamics`]. `armature`
    /// is added to the diagonal of the inertia (kg, kg mm²): motors. None where a joint would move no mass.
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
