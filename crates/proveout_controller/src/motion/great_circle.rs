//! Blocks whose tool axis runs on a great circle.

use proveout_geom::{Point, ToolPose};
use proveout_machine::{JointKind, JointValues, KinematicsError};

use super::{BlockPath, Context};
use crate::{
    jet::JointJet,
    rig::Rig,
    shape::{Quintic, Shape},
};

/// Two tool axes nearer than this (radian) are one: 0.2 micrometers at 100 mm from the tip.
const SAME_AXIS: f64 = 2e-6;
/// Turn of the tool axis between two knots of a great circle, radian.
const KNOT_TURN: f64 = 0.02;

impl Context<'_> {
    pub(super) fn great_circle(
        &self,
        rig: &Rig,
        length: f64,
        from: &JointValues,
        to: &JointValues,
        tip: &dyn Fn(f64) -> JointJet,
    ) -> Option<BlockPath> {
        let (path_length, tip_moves) = self.parameter_length(&(*to - *from));
        if path_length <= 0.0 {
            return None;
        }
        let mut path = self.great_circle_along(rig, length, from, to, tip, path_length)?;
        path.tip_moves = tip_moves;
        Some(path)
    }

    /// The tool axis on the great circle, the tip as given over t in 0..=1. The rotary joints are interpolated by
    /// quintics through knots whose derivatives are central differences of the inverse kinematics; knots every 0.02 rad
    /// keep the axis within about 1e-9 rad of the great circle away from singular positions. None where the great
    /// circle is not defined, not reached, or ends in another branch than programmed: the axes then run in proportion.
    pub(super) fn great_circle_along(
        &self,
        rig: &Rig,
        length: f64,
        from: &JointValues,
        to: &JointValues,
        tip: &dyn Fn(f64) -> JointJet,
        path_length: f64,
    ) -> Option<BlockPath> {
        let axis_of = |task: &JointValues| self.machine.forward(&self.joints(rig, task, length), length).axis;
        let ends = [
            ToolPose { tip: Point::origin(), axis: axis_of(from) },
            ToolPose { tip: Point::origin(), axis: axis_of(to) },
        ];
        let angle = ends[0].angle_to(&ends[1]);
        if !(1e-9..=std::f64::consts::PI - 1e-3).contains(&angle) {
            return None;
        }
        let middle = axis_of(&((*from + *to) * 0.5));
        let off = ends[0].interpolated(&ends[1], 0.5).axis - middle;
        if off.norm() < SAME_AXIS {
            return None; // short blocks: the axes in proportion are on the great circle
        }
        let knots = (angle / KNOT_TURN).ceil().max(2.0) as usize;
        let solve = |t: f64, near: &JointValues| -> Option<JointValues> {
            // Beyond the ends the same circle goes on.
            let pose = if (0.0..=1.0).contains(&t) {
                ends[0].interpolated(&ends[1], t)
            } else {
                let turn = ends[0].axis.cross(&ends[1].axis).normalize();
                let r = proveout_geom::Pose::from_axis_angle(&turn, angle * t);
                ToolPose { tip: Point::origin(), axis: r.vector(&ends[0].axis) }
            };
            match self.machine.inverse_nearest(&pose, length, near) {
                Ok(s) => Some(s.q),
                Err(KinematicsError::OverTravel { solution, .. }) => Some(solution.q),
                Err(_) => None,
            }
        };
        let h = 1e-3_f64.min(0.25 / knots as f64);
        let mut near = *from;
        let mut jets = Vec::with_capacity(knots + 1);
        for k in 0..=knots {
            let t = k as f64 / knots as f64;
            let mid = if k == 0 { *from } else { solve(t, &near)? };
            let (before, after) = (solve(t - h, &mid)?, solve(t + h, &mid)?);
            let mut jet = tip(t);
            for (i, joint) in self.machine.joints.iter().enumerate() {
                if joint.kind == JointKind::Rotary {
                    if (after[i] - mid[i]).abs().max((mid[i] - before[i]).abs()) > 0.5 {
                        return None; // a jump: a singular position lies on the circle
                    }
                    jet.0[0][i] = mid[i];
                    jet.0[1][i] = (after[i] - before[i]) / (2.0 * h);
                    jet.0[2][i] = 0.5 * (after[i] - 2.0 * mid[i] + before[i]) / (h * h);
                }
            }
            near = mid;
            jets.push(jet);
        }
        let rotary_end = self.machine.joints.iter().enumerate().filter(|(_, j)| j.kind == JointKind::Rotary);
        for (i, _) in rotary_end {
            if (near[i] - to[i]).abs() > 1e-6 {
                return None;
            }
        }
        // From t in 0..=1 to the path parameter.
        let scaled = |jet: &JointJet| JointJet(std::array::from_fn(|k| jet.0[k] * path_length.powi(-(k as i32))));
        let at = |k: usize| if k == knots { path_length } else { path_length * k as f64 / knots as f64 };
        let pieces: Vec<Quintic> =
            (0..knots).map(|k| Quintic::hermite(at(k), at(k + 1), &scaled(&jets[k]), &scaled(&jets[k + 1]))).collect();
        let end = self.joints(rig, &pieces.last()?.jet(path_length).0[0], length);
        Some(BlockPath { shape: Shape::Spline(pieces), length: path_length, tip_moves: true, end, unreachable: None })
    }
}
