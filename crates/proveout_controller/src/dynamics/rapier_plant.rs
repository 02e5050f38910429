//! The machine's bodies in Rapier: one multibody that is moved by forces alone.
//!
//! Only this file uses Rapier. Its motors, dampers, limits and contacts are off; the drives act as
//! forces on both sides of a joint, so that the load is known because it was applied:
//!
//! ```text
//!   slide   +f at a point p of the carried body, -f at the same point of the carrying one: no free moment
//!   turn    +t on the carried body, -t on the carrying one
//! ```
//!
//! Properties of the library (0.36.1), each checked by a test:
//!
//! - A multibody on a fixed root reports six degrees of freedom too many until its first forward
//!   kinematics.
//! - Rotary joints start with a damping of 0.1.
//! - Its integration is of first order, so steps are 0.1 ms or less, each of four substeps.
//! - The principal axes that it finds for an inertia tensor may be off by degrees where two
//!   principal values are nearly equal (a long body then turns about its long axis with several
//!   times its inertia), so they are computed here.
//!
//! Lengths are in m inside.

use nalgebra::Matrix3;
use proveout_machine::{JointValues, MAX_JOINTS};
use rapier3d_f64::{
    dynamics::{MassProperties, MultibodyJointHandle, PrismaticJointBuilder, RevoluteJointBuilder, RigidBodyBuilder},
    math::{Matrix, Rotation, Vector},
    prelude::{PhysicsWorld, RigidBodyHandle},
};

use super::{STANDARD_GRAVITY, tree::RigidTree};

const METER: f64 = 1e-3;
/// Substeps of the library within one step.
const SUBSTEPS: usize = 4;
/// By how much a step may be longer than the longest by rounding, part of it.
const ROUNDING: f64 = 1e-9;

fn to_meter(v: &proveout_geom::Vector) -> Vector {
    Vector::new(v.x * METER, v.y * METER, v.z * METER)
}

/// Principal inertias and the rotation from their axes to those of the tensor.
fn principal_axes(tensor: &Matrix3<f64>) -> (Vector, Rotation) {
    let eigen = tensor.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let columns: [f64; 9] = std::array::from_fn(|k| axes[(k % 3, k / 3)]);
    let value = |k: usize| eigen.eigenvalues[k].max(0.0);
    let frame = Rotation::from_mat3(&Matrix::from_cols_array(&columns)).normalize();
    (Vector::new(value(0), value(1), value(2)), frame)
}

fn direction(v: &proveout_geom::Vector) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// A machine as a multibody in Rapier.
pub struct RapierPlant {
    world: PhysicsWorld,
    base: RigidBodyHandle,
    tree: RigidTree,
    /// In the order of the tree's links.
    bodies: Vec<RigidBodyHandle>,
    joints: Vec<MultibodyJointHandle>,
}

impl std::fmt::Debug for RapierPlant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RapierPlant").field("links", &self.bodies.len()).finish_non_exhaustive()
    }
}

impl RapierPlant {
    /// Longest step, s: the error of the library grows with it.
    pub const LONGEST_STEP: f64 = 1e-4;

    /// A plant at rest with all joints at zero; `step` in s, `armature` (kg, kg mm²) is what the motors add.
    ///
    /// # Errors
    /// A sentence on what the plant cannot be made from: masses that are missing, a step that is too long.
    pub fn new(tree: &RigidTree, step: f64, armature: &JointValues) -> Result<Self, String> {
        if let Some((_, reason)) = tree.report().unknown.first() {
            return Err(reason.clone());
        }
        if !(step > 0.0 && step <= Self::LONGEST_STEP * (1.0 + ROUNDING)) {
            return Err(format!("a step of {step} s; the plant needs at most {} s", Self::LONGEST_STEP));
        }
        let mut world = PhysicsWorld::new();
        let up = tree.up.unwrap_or_else(proveout_geom::Vector::zeros);
        world.gravity = direction(&(up * (-STANDARD_GRAVITY * METER)));
        world.integration_parameters.dt = step;
        world.integration_parameters.num_solver_iterations = SUBSTEPS;
        let base = world.insert_body(RigidBodyBuilder::fixed());
        let (mut bodies, mut joints): (Vec<RigidBodyHandle>, Vec<MultibodyJointHandle>) = (Vec::new(), Vec::new());
        for link in &tree.links {
            let (principal, frame) = principal_axes(&(link.inertia * (METER * METER)));
            let mass = MassProperties::with_principal_inertia_frame(
                to_meter(&link.center.coords),
                link.mass,
                principal,
                frame,
            );
            let body = world.insert_body(
                RigidBodyBuilder::dynamic()
                    .additional_mass_properties(mass)
                    .can_sleep(false)
                    .linear_damping(0.0)
                    .angular_damping(0.0),
            );
            let carrier = link.parent.map_or(base, |p| bodies[p]);
            let axis = direction(&link.axis);
            let joint = if link.rotary {
                let anchor = to_meter(&link.point.coords);
                let data = RevoluteJointBuilder::new(axis).local_anchor1(anchor).local_anchor2(anchor);
                world.insert_multibody_joint(carrier, body, data)
            } else {
                world.insert_multibody_joint(carrier, body, PrismaticJointBuilder::new(axis))
            };
            let joint = joint.ok_or_else(|| "the joints do not form a tree".to_owned())?;
            bodies.push(body);
            joints.push(joint);
        }
        let mut plant = Self { world, base, tree: tree.clone(), bodies, joints };
        plant.settle(armature)?;
        Ok(plant)
    }

    /// Forward kinematics once, which takes the surplus freedoms of the fixed root away; then damping and
    /// armature.
    fn settle(&mut self, armature: &JointValues) -> Result<(), String> {
        let Some(&first) = self.joints.first() else { return Err("the machine has no joints".to_owned()) };
        let count = self.joints.len();
        let Some((multibody, _)) = self.world.multibody_joints.get_mut(first) else {
            return Err("the joints do not form one tree".to_owned());
        };
        multibody.forward_kinematics(&self.world.bodies, true);
        if multibody.ndofs() != count {
            return Err(format!("{} degrees of freedom for {count} joints", multibody.ndofs()));
        }
        multibody.damping_mut().fill(0.0);
        for (k, link) in self.tree.links.iter().enumerate() {
            let unit = if link.rotary { METER * METER } else { 1.0 };
            multibody.armature_mut()[k] = armature[link.joint] * unit;
        }
        Ok(())
    }

    /// Puts the joints to positions and velocities.
    pub fn place(&mut self, q: &JointValues, v: &JointValues) {
        let now = self.position();
        let Some(&first) = self.joints.first() else { return };
        let unit = |rotary: bool| if rotary { 1.0 } else { METER };
        let links = &self.tree.links;
        let way: Vec<f64> = links.iter().map(|l| (q[l.joint] - now[l.joint]) * unit(l.rotary)).collect();
        if let Some((multibody, _)) = self.world.multibody_joints.get_mut(first) {
            multibody.apply_displacements(&way);
            multibody.forward_kinematics(&self.world.bodies, false);
            let mut velocity = multibody.generalized_velocity_mut();
            for (k, link) in links.iter().enumerate() {
                velocity[k] = v[link.joint] * unit(link.rotary);
            }
            multibody.update_rigid_bodies(&mut self.world.bodies, true);
        }
    }

    /// One step with the drives' forces (N) and torques (N mm).
    pub fn step(&mut self, tau: &JointValues) {
        for &body in &self.bodies {
            if let Some(b) = self.world.bodies.get_mut(body) {
                b.reset_forces(true);
                b.reset_torques(true);
            }
        }
        for (k, link) in self.tree.links.iter().enumerate() {
            let Some(pose) = self.world.bodies.get(self.bodies[k]).map(|b| *b.position()) else { continue };
            let axis = pose.rotation * direction(&link.axis);
            let carrier = link.parent.map_or(self.base, |p| self.bodies[p]);
            for (body, sign) in [(self.bodies[k], 1.0), (carrier, -1.0)] {
                let Some(b) = self.world.bodies.get_mut(body) else { continue };
                if link.rotary {
                    b.add_torque(axis * (sign * tau[link.joint] * METER), true);
                } else {
                    b.add_force_at_point(axis * (sign * tau[link.joint]), pose.translation, true);
                }
            }
        }
        self.world.step();
    }

    /// Positions, mm and radian.
    pub fn position(&self) -> JointValues {
        let mut q = JointValues::ZERO;
        for (link, &handle) in self.tree.links.iter().zip(&self.joints) {
            let Some(found) = self.world.multibody_joints.get(handle) else { continue };
            let Some(body) = found.0.link(found.1) else { continue };
            let coords = body.joint().coords();
            q[link.joint] = if link.rotary { coords[3] } else { coords[0] / METER };
        }
        q
    }

    /// Velocities, mm/s and radian/s.
    pub fn velocity(&self) -> JointValues {
        let mut v = JointValues::ZERO;
        let Some((multibody, _)) = self.joints.first().and_then(|h| self.world.multibody_joints.get(*h)) else {
            return v;
        };
        let all = multibody.generalized_velocity();
        for (k, link) in self.tree.links.iter().enumerate().take(MAX_JOINTS) {
            v[link.joint] = if link.rotary { all[k] } else { all[k] / METER };
        }
        v
    }
}
