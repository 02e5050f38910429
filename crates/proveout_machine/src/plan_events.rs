//! What a plan of branches has to tell: singular cones, jumps, over-travel.

use proveout_geom::{Point, ToolPose};

use crate::{BranchPlan, JointValues, LimitKind, LimitViolation, Machine, MotionState, PlanOptions, arc::Arc};

/// Something about a planned path that must not stay hidden.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanEvent {
    /// The path passes so near to a singular tool axis that the rotary joints turn much faster than the tool.
    SingularCone {
        /// First and last pose of the stretch.
        first: usize,
        /// Last pose.
        last: usize,
        /// Where the axis is nearest to the singular one: pose number plus part of the way to the next.
        place: f64,
        /// Angle there between tool axis and singular axis, radian; zero when it is passed exactly.
        cone_angle: f64,
        /// Turn of the rotary joints for a turn of the tool axis there, rad/rad; infinite on the singular axis.
        amplification: f64,
        /// The joint that turns most on the stretch, the step to it and from it included.
        joint: usize,
        /// How far it turns, radian.
        turn: f64,
    },
    /// The other branch is taken where both meet, without a jump.
    BranchChange {
        /// First pose on the new branch.
        pose: usize,
        /// Branch before.
        from: usize,
        /// Branch after.
        to: usize,
    },
    /// Between two poses the joints cannot follow the tool axis: a flip to the other branch or a rewind, which no choice
    /// of branches and turns avoids. The tool must be lifted off there.
    Jump {
        /// Pose after the jump.
        pose: usize,
        /// The joint that moves farthest.
        joint: usize,
        /// Its motion, radian.
        turn: f64,
        /// Farthest that the tool axis leaves the way between the poses, radian.
        deviation: f64,
        /// Branches before and after.
        branches: [usize; 2],
    },
    /// A joint or leg stands outside its travel on every way.
    OverTravel {
        /// The pose.
        pose: usize,
        /// What passes its travel, with value and limit.
        violation: LimitViolation,
    },
}

/// Farthest that the tool axis leaves the great circle between two poses while the joints run straight.
pub(crate) fn deviation(machine: &Machine, a: &JointValues, b: &JointValues, way: &Arc) -> f64 {
    // Quarters: a turn to and fro of one or two full turns cannot hide between them.
    [0.25, 0.5, 0.75]
        .into_iter()
        .map(|t| way.distance(&machine.forward(&a.interpolated(*b, t), 0.0).axis))
        .fold(0.0, f64::max)
}

/// Cone angle and amplification at the place of a step nearest to a singular axis, and that place as a part of the step.
fn nearest_cone(machine: &Machine, from: &ToolPose, to: &ToolPose, q: &JointValues) -> Option<(f64, f64, f64)> {
    let (part, cone_angle) = machine.solver.cone_on_arc(&machine.chain, &Arc::new(&from.axis, &to.axis))?;
    let axis = Arc::new(&from.axis, &to.axis).at(part);
    let tip = Point::from(from.tip.coords * (1.0 - part) + to.tip.coords * part);
    let branches = machine.inverse_closest(&ToolPose { tip, axis }, 0.0);
    let rotary = machine.rotary_joints();
    let distance =
        |b: &JointValues| rotary.iter().map(|&j| (proveout_geom::wrap_near(b[j], q[j]) - q[j]).abs()).sum::<f64>();
    let nearest = branches.iter().map(|b| b.q).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    Some((cone_angle, machine.rotary_amplification(&nearest)?, part))
}

/// All events of a plan whose joints are final.
pub(crate) fn events(
    machine: &Machine,
    poses: &[ToolPose],
    plan: &BranchPlan,
    options: &PlanOptions,
) -> Vec<PlanEvent> {
    let mut all = cones(machine, poses, plan, options);
    for (k, pair) in plan.joints.windows(2).enumerate() {
        let (a, b) = (&pair[0], &pair[1]);
        let way = Arc::new(&poses[k].axis, &poses[k + 1].axis);
        let branches = [plan.branches[k], plan.branches[k + 1]];
        let off = deviation(machine, a, b, &way);
        let farthest =
            machine.rotary_joints().iter().max_by(|&&i, &&j| (b[i] - a[i]).abs().total_cmp(&(b[j] - a[j]).abs()));
        if off > options.axis_tolerance
            && let Some(&joint) = farthest
        {
            all.push(PlanEvent::Jump { pose: k + 1, joint, turn: b[joint] - a[joint], deviation: off, branches });
        } else if branches[0] != branches[1] {
            all.push(PlanEvent::BranchChange { pose: k + 1, from: branches[0], to: branches[1] });
        }
    }
    for (pose, q) in plan.joints.iter().enumerate() {
        let state = MotionState { q: *q, ..MotionState::default() };
        let travel = machine.limit_violations(&state, 0.0).into_iter().filter(|v| v.kind == LimitKind::Travel);
        all.extend(travel.map(|violation| PlanEvent::OverTravel { pose, violation }));
    }
    all
}

fn cones(machine: &Machine, poses: &[ToolPose], plan: &BranchPlan, options: &PlanOptions) -> Vec<PlanEvent> {
    let mut all = Vec::new();
    let steps = plan.joints.len().saturating_sub(1).max(usize::from(plan.joints.len() == 1));
    let mut open: Option<(usize, usize, f64, f64, f64)> = None;
    for k in 0..=steps {
        let to = (k + 1).min(poses.len().saturating_sub(1));
        let found = if k < steps { nearest_cone(machine, &poses[k], &poses[to], &plan.joints[k]) } else { None };
        let near = found.filter(|(_, amplification, _)| *amplification > options.amplification_limit);
        match (near, &mut open) {
            (Some((cone, amplification, part)), None) => open = Some((k, to, k as f64 + part, cone, amplification)),
            (Some((cone, amplification, part)), Some(run)) => {
                run.1 = to;
                if cone < run.3 {
                    (run.2, run.3, run.4) = (k as f64 + part, cone, amplification);
                }
            }
            (None, run) => {
                if let Some((first, last, place, cone_angle, amplification)) = run.take() {
                    let turn_of = |&j: &usize| {
                        let turn: f64 = plan.joints[first..=last].windows(2).map(|w| (w[1][j] - w[0][j]).abs()).sum();
                        (j, turn)
                    };
                    let turns = machine.rotary_joints().iter().map(turn_of);
                    let (joint, turn) = turns.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
                    all.push(PlanEvent::SingularCone { first, last, place, cone_angle, amplification, joint, turn });
                }
            }
        }
    }
    all
}
