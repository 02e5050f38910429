//! Branches and turns for a whole path, by look-ahead.
//!
//! Each pose has up to two branches, and each branch several turns of the joints that have end stops. Among all
//! sequences the one is taken that, in this order, leaves travel least often, jumps least often, and turns the rotary joints
//! least: dynamic programming over the poses (Bellman 1957), exact for this order, in time linear in the poses.
//!
//! ```text
//!   pose      0        1        2        3
//!   branch 0  o------->o------->o        o      a step costs |d r1| + |d r2|; it is a jump when the
//!             o        o        o \    / o      tool axis, with the joints running straight, leaves the
//!   branch 1  o        o        o  \->o  o      great circle between the poses by more than the tolerance
//!             o        o        o        o      rows: turns within travel
//! ```
//!
//! A joint without end stops needs no rows: it takes the turn nearest to where it comes from. A joint that a pose leaves
//! free (tool on the singular axis) is carried along; afterwards its motion is spread over the run of such poses, so
//! that the table turns while the tool stands upright instead of jumping when it leaves.
//!
//! Limits: of a joint with more than nine turns of travel only the nine about the start are searched. Machines whose
//! inverse kinematics is numerical follow pose by pose without look-ahead. Motion between the poses is judged on straight
//! joint ways, as a control without smoothing runs them. All choices of all poses are kept until the way back is known:
//! some 130 bytes a choice, two choices a pose on machines with one turn of travel, 18 with nine.

use std::f64::consts::TAU;

use proveout_geom::{ToolPose, wrap_near};
use thiserror::Error;

use crate::{
    Branch, JointValues, KinematicsError, LimitKind, Machine, MotionState, PlanEvent,
    arc::Arc,
    plan_events::{deviation, events},
};

/// Turns of a joint with end stops that are searched at most.
const MAX_TURNS: f64 = 9.0;

/// Weight of the distance from home at the first pose where no start is given: it only breaks ties between turns.
const TIE_WEIGHT: f64 = 1e-9;

/// What a plan starts from and when it reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanOptions {
    /// Gauge length of the tool, mm.
    pub tool_length: f64,
    /// Where the joints stand before the first pose; without it the first pose is reached from anywhere.
    pub start: Option<JointValues>,
    /// A step is a jump when the tool axis leaves the way between its poses by more than this, radian.
    pub axis_tolerance: f64,
    /// Amplification (rad/rad) above which a singular cone is reported.
    pub amplification_limit: f64,
}

impl Default for PlanOptions {
    /// Jumps above one degree, cones above tenfold amplification (within 5.7 degrees of the singular axis of a machine
    /// whose table turns about the upright tool).
    fn default() -> Self {
        Self { tool_length: 0.0, start: None, axis_tolerance: 1_f64.to_radians(), amplification_limit: 10.0 }
    }
}

/// Joint values for a path and what there is to tell about them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BranchPlan {
    /// One set a pose, unwrapped.
    pub joints: Vec<JointValues>,
    /// Branch of each pose.
    pub branches: Vec<usize>,
    /// Singular cones, branch changes, jumps and over-travel, in this order of kinds.
    pub events: Vec<PlanEvent>,
}

/// A pose that no branch reaches.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("pose {pose} of the path: {source}")]
pub struct PlanError {
    /// Index of the pose.
    pub pose: usize,
    /// Why.
    pub source: KinematicsError,
}

/// What a sequence costs, compared in order.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Cost {
    over_travel: u32,
    jumps: u32,
    way: f64,
}

/// One choice at one pose, with the best way to it.
#[derive(Clone, Copy, Debug)]
struct Node {
    q: JointValues,
    branch: usize,
    free: Option<usize>,
    cost: Cost,
    parent: usize,
}

/// Plans branches and turns for a path of tool poses in the table frame K.
///
/// # Errors
/// [`PlanError`] with the first pose that the machine does not reach, limits apart, or that is no number (a start that is
/// none counts as the first pose). Over-travel is no error: it is an
/// event of the plan, since a user wants to see all of it.
pub fn plan_branches(machine: &Machine, poses: &[ToolPose], options: &PlanOptions) -> Result<BranchPlan, PlanError> {
    if let Some(start) = &options.start
        && !start.is_finite()
        && !poses.is_empty()
    {
        let source = KinematicsError::NotFinite { tip: [f64::NAN; 3], axis: [f64::NAN; 3] };
        return Err(PlanError { pose: 0, source });
    }
    let mut plan =
        if machine.has_closed_form() { search(machine, poses, options)? } else { follow(machine, poses, options)? };
    plan.events = events(machine, poses, &plan, options);
    Ok(plan)
}

/// Pose by pose, for machines without a closed form.
fn follow(machine: &Machine, poses: &[ToolPose], options: &PlanOptions) -> Result<BranchPlan, PlanError> {
    let mut previous = options.start.unwrap_or_else(|| machine.home());
    let mut plan = BranchPlan::default();
    for (pose, wanted) in poses.iter().enumerate() {
        let solution = match machine.inverse_nearest(wanted, options.tool_length, &previous) {
            Ok(solution) => solution,
            Err(KinematicsError::OverTravel { solution, .. }) => *solution,
            Err(source) => return Err(PlanError { pose, source }),
        };
        previous = solution.q;
        plan.joints.push(solution.q);
        plan.branches.push(solution.branch);
    }
    Ok(plan)
}

fn search(machine: &Machine, poses: &[ToolPose], options: &PlanOptions) -> Result<BranchPlan, PlanError> {
    let mut layers: Vec<Vec<Node>> = Vec::with_capacity(poses.len());
    let home = options.start.unwrap_or_else(|| machine.home());
    let zero = Cost { over_travel: 0, jumps: 0, way: 0.0 };
    let start = Node { q: home, branch: 0, free: None, cost: zero, parent: 0 };
    for (pose, wanted) in poses.iter().enumerate() {
        let branches = machine.inverse(wanted, options.tool_length);
        if branches.is_empty() {
            let refused = machine.inverse_nearest(wanted, options.tool_length, &home).err();
            let source = refused.unwrap_or(KinematicsError::AxisUnreachable { angle: branches.axis_error });
            return Err(PlanError { pose, source });
        }
        let first = [start];
        let before: &[Node] = layers.last().map_or(&first, |l| l);
        let way = pose.checked_sub(1).map(|k| Arc::new(&poses[k].axis, &wanted.axis));
        let mut layer = Vec::new();
        for branch in branches.iter() {
            if branch.tip_error > crate::TIP_TOLERANCE {
                let source = KinematicsError::TipUnreachable { distance: branch.tip_error };
                return Err(PlanError { pose, source });
            }
            let step = Step { machine, options, wanted, way: way.as_ref(), branch };
            for choice in turns(machine, branch, &home) {
                if branch.free_joint.is_some() {
                    // Each way carries its own value of the free joint on.
                    layer.extend(before.iter().enumerate().map(|(k, from)| step.node(&choice, k, from)));
                } else {
                    let nodes = before.iter().enumerate().map(|(k, from)| step.node(&choice, k, from));
                    layer.extend(nodes.min_by(|a, b| order(&a.cost, &b.cost)));
                }
            }
        }
        layers.push(layer);
    }
    let mut plan = BranchPlan::default();
    let mut free = Vec::with_capacity(poses.len());
    let mut next =
        layers.last().and_then(|l| l.iter().enumerate().min_by(|a, b| order(&a.1.cost, &b.1.cost)).map(|(k, _)| k));
    for layer in layers.iter().rev() {
        let Some(node) = next.and_then(|k| layer.get(k)) else { break };
        plan.joints.push(node.q);
        plan.branches.push(node.branch);
        free.push(node.free);
        next = Some(node.parent);
    }
    plan.joints.reverse();
    plan.branches.reverse();
    free.reverse();
    spread_free(machine, poses, options, &free, &mut plan);
    Ok(plan)
}

fn order(a: &Cost, b: &Cost) -> std::cmp::Ordering {
    (a.over_travel, a.jumps).cmp(&(b.over_travel, b.jumps)).then(a.way.total_cmp(&b.way))
}

/// The joint values of a branch with every turn of the rotary joints that have end stops.
fn turns(machine: &Machine, branch: &Branch, about: &JointValues) -> Vec<JointValues> {
    let mut all = vec![branch.q];
    for &j in machine.rotary_joints() {
        let Some([low, high]) = machine.joints[j].travel else { continue };
        if branch.free_joint == Some(j) {
            continue;
        }
        let angle = branch.q[j];
        let slack = crate::joint::TRAVEL_TOLERANCE;
        let least = ((low - slack - angle) / TAU).ceil();
        let most = ((high + slack - angle) / TAU).floor();
        let middle = ((about[j] - angle) / TAU).round().clamp(least.min(most), most.max(least));
        let (least, most) = if most - least >= MAX_TURNS {
            ((middle - 4.0).max(least), (middle + 4.0).min(most))
        } else {
            (least, most)
        };
        // Without a turn inside the nearest one outside is kept, and counts as over-travel.
        let count = (most - least).max(0.0) as usize;
        let first = if least <= most { least } else { middle };
        all = all
            .iter()
            .flat_map(|q| {
                (0..=count).map(move |k| {
                    let mut q = *q;
                    q[j] = angle + TAU * (first + k as f64);
                    q
                })
            })
            .collect();
    }
    all
}

/// One branch of one pose, and the way to it.
struct Step<'a> {
    machine: &'a Machine,
    options: &'a PlanOptions,
    wanted: &'a ToolPose,
    /// Great circle from the pose before; `None` at the first pose.
    way: Option<&'a Arc>,
    branch: &'a Branch,
}

impl Step<'_> {
    fn node(&self, choice: &JointValues, parent: usize, from: &Node) -> Node {
        let machine = self.machine;
        let mut q = *choice;
        for &j in machine.rotary_joints() {
            if self.branch.free_joint == Some(j) {
                q[j] = from.q[j];
            } else if machine.joints[j].travel.is_none() {
                q[j] = wrap_near(q[j], from.q[j]);
            }
        }
        if self.branch.free_joint.is_some() {
            q = machine.inverse_with_rotary(&self.wanted.tip, &q, self.options.tool_length);
        }
        let mut cost = from.cost;
        cost.over_travel += over_travel(machine, &q);
        let way: f64 = machine.rotary_joints().iter().map(|&j| (q[j] - from.q[j]).abs()).sum();
        match self.way {
            None if self.options.start.is_none() => cost.way += TIE_WEIGHT * way,
            None => cost.way += way,
            Some(arc) => {
                cost.way += way;
                let mut a = from.q;
                if let Some(free) = from.free {
                    // It turns before the tool leaves the singular axis.
                    a[free] = q[free];
                }
                // The axis leaves its way by no more than the joints turn.
                let jump =
                    way > self.options.axis_tolerance && deviation(machine, &a, &q, arc) > self.options.axis_tolerance;
                cost.jumps += u32::from(jump);
            }
        }
        Node { q, branch: self.branch.index, free: self.branch.free_joint, cost, parent }
    }
}

/// Number of joints and legs outside their travel.
fn over_travel(machine: &Machine, q: &JointValues) -> u32 {
    let state = MotionState { q: *q, ..MotionState::default() };
    machine.limit_violations(&state, 0.0).iter().filter(|v| v.kind == LimitKind::Travel).count() as u32
}

/// Spreads the motion of free joints over the poses that leave them free.
fn spread_free(
    machine: &Machine,
    poses: &[ToolPose],
    options: &PlanOptions,
    free: &[Option<usize>],
    plan: &mut BranchPlan,
) {
    let mut first = 0;
    while first < free.len() {
        let Some(joint) = free[first] else {
            first += 1;
            continue;
        };
        let last = (first..free.len()).take_while(|&k| free[k] == Some(joint)).last().unwrap_or(first);
        let value = |k: usize| plan.joints.get(k).map(|q| q[joint]);
        let after = value(last + 1);
        let before = match first.checked_sub(1) {
            Some(k) => value(k),
            None => options.start.map(|q| q[joint]),
        };
        let stays = plan.joints[first][joint];
        let (from, to) = match (before, after) {
            (Some(a), Some(b)) => (a, b),
            (None, Some(b)) => (b, b),
            (a, None) => (a.unwrap_or(stays), a.unwrap_or(stays)),
        };
        let run = plan.joints.iter_mut().zip(poses).enumerate().take(last + 1).skip(first);
        for (k, (q, pose)) in run {
            // The tool stands on the singular axis from the first to the last pose of the run: all turning is done
            // between them. A run of one pose leaves it to the step away.
            let part = if last > first { (k - first) as f64 / (last - first) as f64 } else { 0.0 };
            q[joint] = from * (1.0 - part) + to * part;
            *q = machine.inverse_with_rotary(&pose.tip, q, options.tool_length);
        }
        first = last + 1;
    }
}
