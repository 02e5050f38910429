//! What the drives of a machine move: its joints, and instead of heave and tilt of a platform its legs.
//!
//! ```text
//!   set points of joints ──► lengths of legs ──► a drive each ──► actual lengths ──► actual heave and tilt
//!          q, q.               L(q), J q.                            L, L.             J^-1 L.
//! ```
//!
//! The actual heave and tilt are those of the assembly nearest to the last one.
//!
//! A *drive place* is the index of a joint. Those of a platform's joints hold leg 1 (place of the
//! heave joint) and legs 2 and 3 (place of the tilt joint), which move alike and have the same
//! drive: one model serves both.
//!
//! Between two control samples an actual length is the cubic with its lengths and rates at both, up to the
//! bound of `trail.rs`. The joints are taken as cubics too; how far these are from the joints of the cubic
//! lengths is measured in the middle, where the error of a cubic through values and slopes is largest (it
//! goes like t^2 (h - t)^2), and doubled for what is not of fourth order.
//!
//! Limits: the legs are rigid and carry their own mass alone. Weight and coupling of what a platform carries
//! are not known (`dynamics/tree.rs` says so for every joint concerned), and legs 2 and 3 take no moment
//! about `e1`.

use proveout_machine::{JointValues, Machine, Platform, PlatformError};

use super::step::SetPointRates;
use crate::output::Sample;

/// The legs of a machine; without a platform every drive moves its joint.
#[derive(Clone, Debug, Default)]
pub(crate) struct Legs {
    platforms: Vec<Platform>,
}

/// Positions and velocities of the drives or of the joints, mm or radian and s.
pub(crate) type Motion = [JointValues; 2];

impl Legs {
    pub(crate) fn new(machine: &Machine) -> Self {
        Self { platforms: machine.platforms.clone() }
    }

    /// The platform of a drive place, and which of its legs the drive moves: 0 for leg 1, 1 for legs 2 and 3.
    pub(crate) fn leg(&self, place: usize) -> Option<(&Platform, usize)> {
        let of = |p: &&Platform| p.heave == place || p.tilt == place;
        self.platforms.iter().find(of).map(|p| (p, usize::from(p.tilt == place)))
    }

    /// The legs that a drive moves, in words; none where it moves its joint.
    pub(crate) fn names(&self, place: usize) -> Option<String> {
        let (platform, leg) = self.leg(place)?;
        let [first, second, third] = &platform.legs;
        Some(if leg == 0 { format!("leg {}", first.name) } else { format!("legs {} and {}", second.name, third.name) })
    }

    /// Drives for joints.
    pub(crate) fn of_joints(&self, q: &JointValues, velocity: &JointValues) -> Motion {
        let mut drives = [*q, *velocity];
        for p in &self.platforms {
            let [first, second, _] = p.leg_lengths(q);
            let rates = p.leg_rates(q).map(|[heave, tilt]| heave * velocity[p.heave] + tilt * velocity[p.tilt]);
            (drives[0][p.heave], drives[0][p.tilt]) = (first, second);
            (drives[1][p.heave], drives[1][p.tilt]) = (rates[0], rates[1]);
        }
        drives
    }

    /// Joints for drives; of the assemblies of a platform the one nearest to `near`.
    ///
    /// # Errors
    /// Legs that do not close.
    pub(crate) fn to_joints(&self, drives: &Motion, near: &JointValues) -> Result<Motion, PlatformError> {
        let mut joints = *drives;
        for p in &self.platforms {
            let [first, second] = [drives[0][p.heave], drives[0][p.tilt]];
            let [heave, tilt] = p.from_legs([first, second, second], near)?;
            (joints[0][p.heave], joints[0][p.tilt]) = (heave, tilt);
            let rates = p.joint_rates(&joints[0], [drives[1][p.heave], drives[1][p.tilt]]);
            (joints[1][p.heave], joints[1][p.tilt]) = (rates[0], rates[1]);
        }
        Ok(joints)
    }

    /// The drives' set points between two samples of the plan, a time `gap` apart.
    pub(crate) fn references(&self, last: &Sample, next: &Sample, gap: f64) -> impl Fn(usize) -> SetPointRates {
        let [from, to] = [last, next].map(|s| self.of_joints(&s.commanded, &s.velocity));
        move |j| cubic(gap, to[0][j] - from[0][j], from[1][j], to[1][j])
    }

    /// Bounds of the joints' deviation from their cubics over a cycle, from those of the drives.
    ///
    /// # Errors
    /// Legs that do not close.
    pub(crate) fn joint_bounds(
        &self,
        bounds: &JointValues,
        cycle: f64,
        [drives_before, drives]: [&Motion; 2],
        [before, joints]: [&Motion; 2],
    ) -> Result<JointValues, PlatformError> {
        let mut out = *bounds;
        if self.platforms.is_empty() {
            return Ok(out);
        }
        let middle = |a: &Motion, b: &Motion| {
            let sum = a[0] + b[0];
            (sum + (a[1] - b[1]) * (0.25 * cycle)) * 0.5
        };
        let lengths = middle(drives_before, drives);
        let true_middle = self.to_joints(&[lengths, JointValues::ZERO], &joints[0])?[0];
        let off = true_middle - middle(before, joints);
        for p in &self.platforms {
            // Shares of the legs in heave and tilt at both ends; over a cycle they change by a part of a
            // thousand.
            let [a, b] = [&before[0], &joints[0]].map(|q| [[1.0, 0.0], [0.0, 1.0]].map(|unit| p.joint_rates(q, unit)));
            for (k, joint) in [p.heave, p.tilt].into_iter().enumerate() {
                let share = |leg: usize| 1.01 * a[leg][k].abs().max(b[leg][k].abs());
                let moved = share(0) * bounds[p.heave] + share(1) * bounds[p.tilt];
                out[joint] = moved + 2.0 * off[joint].abs();
            }
        }
        Ok(out)
    }

    /// Forces of the drives (N) as forces (N) and torques (N mm) on the joints: virtual work, `J^T f`, legs 2
    /// and 3 counted both.
    pub(crate) fn joint_forces(&self, forces: &JointValues, q: &JointValues) -> JointValues {
        let mut out = *forces;
        for p in &self.platforms {
            let [first, second] = p.leg_rates(q);
            let [one, both] = [forces[p.heave], 2.0 * forces[p.tilt]];
            (out[p.heave], out[p.tilt]) = (first[0] * one + second[0] * both, first[1] * one + second[1] * both);
        }
        out
    }
}

/// The legs that the drive at the place of a joint moves, in words; none where it moves its joint.
pub fn leg_names(machine: &Machine, joint: usize) -> Option<String> {
    Legs::new(machine).names(joint)
}

/// The cubic over a time `h` with a way and the velocities at both ends.
pub(crate) fn cubic(h: f64, way: f64, v0: f64, v1: f64) -> SetPointRates {
    let slope = way / h;
    SetPointRates {
        velocity: v0,
        acceleration: (6.0 * slope - 4.0 * v0 - 2.0 * v1) / h,
        jerk: 6.0 * (v0 + v1 - 2.0 * slope) / (h * h),
    }
}
