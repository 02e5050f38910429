//! Blocks whose tool axis runs on a great circle.
//!
//! The circle is that of the program, from tool axis to tool axis, in proportion to the way of the
//! tip. The joints follow it by continuation (`follow.rs`): they stay on their branch, however far
//! the first rotary joint swings near a pole. Only in a pole is there a choice:
//!
//! - **Begin in a pole**: the first rotary joint turns, with tip and axis at rest, to where either branch
//!   leaves the pole.
//! - **Way through a pole**: the other branch goes on without a turn (the tilt changes its sign), or the same
//!   branch goes on after half a turn.
//! - **End in a pole**: there is no choice; the joint stays as it comes. Where the program names its
//!   position, it turns there.
//!
//! Of the choices that end in the programmed position of the joints, the first one is taken whose
//! rotary joints stay within travel, then whose linear joints do, then the one that turns least. If
//! none does, the least turn is run and its over-travel reported. A block with turns is run in
//! parts with a stop at each turn.
//!
//! *Far from the table* a turn takes the tip along, out of the travel of the linear joints, above
//! all in the first rapid from home. A rapid motion then brings the tip to its end first, and turns
//! and tilts there. Both ways are run as programmed but not in step, which no program requires of a
//! rapid. In feed the over-travel is reported.
//!
//! *In a pole* means nearer to it than rounding ([`AXIS_TOLERANCE`]), or passing it within the cone
//! of the control (`curve.rs`); the latter is reported with the angle.
//!
//! *No circle*: between opposite axes, beyond the reach of the rotary joints, and to named
//! positions of the rotary joints that the circle does not lead to. The rotary joints then run in
//! proportion, and the angle by which they leave the circle is reported.

mod curve;
mod follow;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{AXIS_TOLERANCE, JointValues};

use self::{
    curve::AxisCurve,
    follow::{ABSORBED, BranchStretch, Follower, JointKnot},
};
use super::{BlockPart, Context, Leaves};
use crate::{jet::JointJet, rtcp::Rig, shape::BlockShape};

/// Two tool axes nearer than this (radian) are one: 0.2 micrometers at 100 mm from the tip.
const SAME_AXIS: f64 = 2e-6;
/// A tool axis that turns by less than this (radian) counts as at rest.
const STANDS: f64 = 1e-9;
/// Named positions of the rotary joints count as reached within this, radian.
const SAME_JOINTS: f64 = 1e-6;
/// Points of a block at which the way off the circle is looked for.
const LOOKS: u32 = 256;

/// What is asked of the tool axis in a block.
pub(super) struct AxisTask<'a> {
    pub(super) rig: &'a Rig,
    /// Tool length of the tool center point control, mm.
    pub(super) length: f64,
    /// Task coordinates at both ends.
    pub(super) from: &'a JointValues,
    pub(super) to: &'a JointValues,
    /// The program gives the tool axis, not positions of the rotary joints: any branch and turn will do.
    pub(super) any_joints: bool,
    /// Linear task coordinates over t in 0..=1 with their derivatives.
    pub(super) tip: &'a dyn Fn(f64) -> JointJet,
    /// Length of the way of the tip, mm; none if it does not move.
    pub(super) tip_length: Option<f64>,
}

/// One way to run a block.
struct Candidate {
    stretches: Vec<(BranchStretch, Vec<JointKnot>)>,
    /// Joints before each stretch, and at the end of the block.
    stands: Vec<JointValues>,
}

/// How a block is to be run.
pub(super) enum BlockTurning {
    /// The rotary joints run in proportion to the way, and what that leaves.
    InProportion(Option<Leaves>),
    /// The parts of the block, their length together without turns, and the joints at the end.
    Parts { parts: Vec<BlockPart>, length: f64, end: JointValues, leaves: Option<Leaves>, apart: bool },
}

/// What the tool axis is to do.
enum AxisCourse {
    Stands(Vector),
    Circle(AxisCurve),
    Opposite(Vector),
}

impl AxisCourse {
    fn new(from: &Vector, to: &Vector) -> Self {
        if angle_between(from, to) <= STANDS {
            return Self::Stands(*from);
        }
        AxisCurve::circle(from, to).map_or(Self::Opposite(*from), Self::Circle)
    }

    fn at(&self, t: f64) -> Vector {
        match self {
            Self::Stands(axis) | Self::Opposite(axis) => *axis,
            Self::Circle(curve) => curve.at(t),
        }
    }
}

impl Context<'_> {
    /// How to run a block whose tool axis is to be on the great circle.
    pub(super) fn great_circle(&self, wanted: &AxisTask<'_>) -> BlockTurning {
        let in_step = self.on_circle(wanted);
        let too_far = match &in_step {
            BlockTurning::Parts { parts, .. } => self.rapid && self.turns_out_of_travel(wanted, parts),
            BlockTurning::InProportion(_) => false,
        };
        if too_far { self.tip_first(wanted).unwrap_or(in_step) } else { in_step }
    }

    /// Whether a turn in a pole takes a linear joint out of its travel.
    fn turns_out_of_travel(&self, wanted: &AxisTask<'_>, parts: &[BlockPart]) -> bool {
        let out = |task: &JointValues| {
            let q = self.joints(wanted.rig, task, wanted.length);
            let joints = self.machine.joints.iter().enumerate();
            joints.filter(|(_, j)| !j.is_rotary()).any(|(i, j)| j.travel_violation(q[i]).is_some())
        };
        let places = |part: &BlockPart| (0..=16).any(|k| out(&part.shape.jet(part.length * f64::from(k) / 16.0).0[0]));
        parts.iter().filter(|p| p.turn).any(places)
    }

    /// The tip to its end on a straight way, and then the circle; none where that leaves the travel as well.
    fn tip_first(&self, wanted: &AxisTask<'_>) -> Option<BlockTurning> {
        let length = wanted.tip_length?;
        let there = (wanted.tip)(1.0).0[0];
        let mut from = *wanted.from;
        for slot in wanted.rig.slots {
            from[slot] = there[slot];
        }
        let tip = |_: f64| JointJet::constant(there);
        let standing = AxisTask {
            rig: wanted.rig,
            length: wanted.length,
            from: &from,
            to: wanted.to,
            any_joints: wanted.any_joints,
            tip: &tip,
            tip_length: None,
        };
        let BlockTurning::Parts { parts: turned, end, leaves, .. } = self.on_circle(&standing) else { return None };
        if self.turns_out_of_travel(&standing, &turned) {
            return None;
        }
        let slope = (from - *wanted.from) * (1.0 / length);
        let way = BlockShape::Line { from: *wanted.from, slope };
        let mut parts = vec![BlockPart { shape: way, length, turn: false, tip_moves: true, t: [0.0, 1.0] }];
        parts.extend(turned.into_iter().map(|part| BlockPart { t: [1.0, 1.0], ..part }));
        Some(BlockTurning::Parts { parts, length, end, leaves, apart: true })
    }

    /// The same with tip and tool axis in step.
    fn on_circle(&self, wanted: &AxisTask<'_>) -> BlockTurning {
        let [a, b] = [wanted.from, wanted.to].map(|task| self.machine.forward(task, wanted.length).axis);
        let course = AxisCourse::new(&a, &b);
        let turned = |&j: &usize| (wanted.to[j] - wanted.from[j]).abs();
        let most = self.machine.rotary_joints().iter().map(turned).fold(0.0, f64::max);
        let near = |t: f64| (self.axis_in_proportion(wanted, t) - course.at(t)).norm() < SAME_AXIS;
        let off = |course: &AxisCourse, reason: &str| {
            BlockTurning::InProportion(Some(self.off_the_circle(wanted, course, reason.to_owned())))
        };
        let circle = match &course {
            AxisCourse::Opposite(_) => {
                return off(
                    &course,
                    "the tool axes at its ends are opposite, and no great circle is defined between them",
                );
            }
            _ if most < STANDS || [0.25, 0.5, 0.75].into_iter().all(near) => return BlockTurning::InProportion(None),
            AxisCourse::Stands(_) => {
                return off(
                    &course,
                    "the tool axis is the same at both ends, and leaves it while the rotary axes move",
                );
            }
            AxisCourse::Circle(circle) => circle,
        };
        let poles: Vec<Vector> = self.machine.poles(wanted.from).collect();
        let pole_of = |axis: &Vector| poles.iter().copied().find(|p| angle_between(p, axis) <= AXIS_TOLERANCE);
        let at_ends = [pole_of(&a), pole_of(&b)];
        let circle = match at_ends {
            [None, None] => Some(circle.clone()),
            [from, to] => AxisCurve::circle(&from.unwrap_or(a), &to.unwrap_or(b)),
        };
        let Some(circle) = circle else {
            return off(&course, "the tool axis is at a pole, and leaves it while the rotary axes move");
        };
        let curve = circle.through_poles(&poles, self.pole_cone.max(AXIS_TOLERANCE));
        let candidates = match self.candidates(wanted, &curve, at_ends) {
            Ok(candidates) => candidates,
            Err(t) => {
                let reason = format!(
                    "from {:.1} percent of its way on the rotary axes do not reach the great circle",
                    100.0 * t
                );
                return off(&course, &reason);
            }
        };
        match self.best(wanted, candidates) {
            Some(best) => self.in_parts(wanted, &curve, &best),
            None => off(&course, "the great circle does not lead to the programmed positions of the rotary axes"),
        }
    }

    fn axis_in_proportion(&self, wanted: &AxisTask<'_>, t: f64) -> Vector {
        self.machine.forward(&wanted.from.interpolated(*wanted.to, t), wanted.length).axis
    }

    /// How far the rotary joints in proportion leave what the axis is to do.
    fn off_the_circle(&self, wanted: &AxisTask<'_>, course: &AxisCourse, reason: String) -> Leaves {
        let places = (1..LOOKS).map(|k| f64::from(k) / f64::from(LOOKS));
        let angles = places.map(|t| angle_between(&self.axis_in_proportion(wanted, t), &course.at(t)));
        Leaves { angle: angles.fold(0.0, f64::max), in_cone: false, reason }
    }

    /// All ways to run the block. Fails with the t from which the joints do not go on, where there is none.
    fn candidates(
        &self,
        wanted: &AxisTask<'_>,
        curve: &AxisCurve,
        at_ends: [Option<Vector>; 2],
    ) -> Result<Vec<Candidate>, f64> {
        let follower = Follower { machine: self.machine, rig: wanted.rig, tip: wanted.tip };
        let from = *wanted.from;
        let begins: Vec<(Option<usize>, JointValues)> = match at_ends[0] {
            Some(pole) => self.out_of(&pole, curve, 0.0, &from),
            None if self.machine.rotary_joints().len() != 2 => vec![(None, from)],
            None => match self.machine.branch_of(&from) {
                Some(branch) => vec![(Some(branch), from)],
                // At the end of reach the branches meet.
                None => vec![(Some(0), from), (Some(1), from)],
            },
        };
        let middle = curve.pass.as_ref().filter(|_| begins.iter().all(|b| b.0.is_some()));
        let mut all = Vec::new();
        let mut lost = None;
        for (branch, begin) in begins {
            let (end, pole) = middle.map_or((1.0, at_ends[1]), |pass| (pass.t, Some(pass.pole)));
            let first = BranchStretch { t: [0.0, end], poles: [at_ends[0], pole], begin, branch };
            let knots = match follower.knots(curve, &first) {
                Ok(knots) => knots,
                Err(t) => {
                    lost.get_or_insert(t);
                    continue;
                }
            };
            let arrived = knots.last().map_or(begin, |k| k.jet.0[0]);
            let Some((pass, branch)) = middle.zip(branch) else {
                all.push(Candidate { stretches: vec![(first, knots)], stands: vec![from, arrived] });
                continue;
            };
            for (next, q) in self.beyond(&pass.pole, curve, pass.t, &arrived, branch) {
                let second = BranchStretch {
                    t: [pass.t, 1.0],
                    poles: [Some(pass.pole), at_ends[1]],
                    begin: q,
                    branch: Some(next),
                };
                match follower.knots(curve, &second) {
                    Ok(more) => {
                        let stands = vec![from, arrived, more.last().map_or(q, |k| k.jet.0[0])];
                        all.push(Candidate { stretches: vec![(first, knots.clone()), (second, more)], stands });
                    }
                    Err(t) => {
                        lost.get_or_insert(t);
                    }
                }
            }
        }
        if all.is_empty() { Err(lost.unwrap_or(0.0)) } else { Ok(all) }
    }

    /// Joints of both branches where the way leaves a pole; they stay where they are if that is rounding.
    fn out_of(
        &self,
        pole: &Vector,
        curve: &AxisCurve,
        t: f64,
        from: &JointValues,
    ) -> Vec<(Option<usize>, JointValues)> {
        let Some(way) = curve.jet(t).0[1].try_normalize(0.0) else { return Vec::new() };
        let Some(both) = self.machine.leaving_pole(pole, &way, from) else { return Vec::new() };
        let stay = |q: JointValues| if (q - *from).max_abs() <= ABSORBED { *from } else { q };
        both.into_iter().enumerate().map(|(k, q)| (Some(k), stay(q))).collect()
    }

    /// Continuations after a pole: the other branch without a turn, or the same one after half a
    /// turn to either side.
    fn beyond(
        &self,
        pole: &Vector,
        curve: &AxisCurve,
        t: f64,
        arrived: &JointValues,
        branch: usize,
    ) -> Vec<(usize, JointValues)> {
        let out = self.out_of(pole, curve, t, arrived);
        let first = self.machine.rotary_joints()[0];
        let mut ways = vec![(1 - branch, *arrived)];
        for (_, q) in out.into_iter().filter(|(k, _)| *k == Some(branch)) {
            let mut other = q;
            other[first] -= std::f64::consts::TAU * (q[first] - arrived[first]).signum();
            ways.extend([(branch, q), (branch, other)]);
        }
        ways
    }

    /// The best of the ways that end where the program wants the joints.
    fn best(&self, wanted: &AxisTask<'_>, candidates: Vec<Candidate>) -> Option<Candidate> {
        let mut fitting: Vec<Candidate> = candidates
            .into_iter()
            .filter_map(|c| if wanted.any_joints { Some(c) } else { self.ending_at(wanted, c) })
            .collect();
        if fitting.len() < 2 {
            return fitting.pop();
        }
        let mut best: Option<((bool, bool, f64), Candidate)> = None;
        for candidate in fitting {
            let cost = self.cost(wanted, &candidate);
            let order = |c: &(bool, bool, f64)| (c.0, c.1);
            let better = best.as_ref().is_none_or(|(least, _)| {
                order(&cost).cmp(&order(least)).then(cost.2.total_cmp(&(least.2 - SAME_JOINTS))).is_lt()
            });
            if better {
                best = Some((cost, candidate));
            }
        }
        best.map(|b| b.1)
    }

    /// A way that ends at named positions of the rotary joints: whole turns go into its last turn in a pole.
    fn ending_at(&self, wanted: &AxisTask<'_>, mut candidate: Candidate) -> Option<Candidate> {
        let rotary = self.machine.rotary_joints();
        let end = *candidate.stands.last()?;
        let (&first, others) = rotary.split_first()?;
        let off = |j: usize| wanted.to[j] - end[j];
        if others.iter().any(|&j| off(j).abs() > SAME_JOINTS) {
            return None;
        }
        let last = candidate.stretches.last()?.0;
        if off(first).abs() > SAME_JOINTS && last.poles[1].is_none() {
            // The last stretch that begins in a pole may be reached with more turns.
            let from = candidate.stretches.iter().rposition(|(s, _)| s.poles[0].is_some())?;
            let turns = std::f64::consts::TAU * (off(first) / std::f64::consts::TAU).round();
            if (off(first) - turns).abs() > SAME_JOINTS {
                return None;
            }
            for (stretch, knots) in &mut candidate.stretches[from..] {
                stretch.begin[first] += turns;
                knots.iter_mut().for_each(|k| k.jet.0[0][first] += turns);
            }
            for stand in &mut candidate.stands[from + 1..] {
                stand[first] += turns;
            }
        }
        let knots = &mut candidate.stretches.last_mut()?.1;
        let arrived = knots.last_mut()?;
        for &j in rotary {
            if (wanted.to[j] - arrived.jet.0[0][j]).abs() <= SAME_JOINTS {
                arrived.jet.0[0][j] = wanted.to[j];
            }
        }
        Some(candidate)
    }

    /// Over-travel of rotary and of linear joints, and how far the rotary joints turn.
    fn cost(&self, wanted: &AxisTask<'_>, candidate: &Candidate) -> (bool, bool, f64) {
        let (mut rotary, mut linear, mut turn) = (false, false, 0.0);
        let mut look = |task: &JointValues| {
            let q = self.joints(wanted.rig, task, wanted.length);
            for (i, joint) in self.machine.joints.iter().enumerate() {
                let over = joint.travel_violation(q[i]).is_some();
                rotary |= over && joint.is_rotary();
                linear |= over && !joint.is_rotary();
            }
        };
        let way = |a: &JointValues, b: &JointValues| {
            self.machine.rotary_joints().iter().map(|&j| (b[j] - a[j]).abs()).sum::<f64>()
        };
        for (k, (stretch, knots)) in candidate.stretches.iter().enumerate() {
            let Some(begin) = knots.first().map(|k| k.jet.0[0]) else { continue };
            let mut before = begin;
            self.take_rotary(&mut before, &candidate.stands[k]);
            turn += way(&candidate.stands[k], &stretch.begin);
            for part in 0..=8 {
                look(&before.interpolated(begin, f64::from(part) / 8.0));
            }
            for pair in knots.windows(2) {
                turn += way(&pair[0].jet.0[0], &pair[1].jet.0[0]);
                look(&pair[1].jet.0[0]);
            }
        }
        (rotary, linear, turn)
    }

    /// The path of a way in parts: turns in poles, and what lies between them.
    fn in_parts(&self, wanted: &AxisTask<'_>, curve: &AxisCurve, candidate: &Candidate) -> BlockTurning {
        let mut end = candidate.stretches.last().and_then(|(_, k)| k.last()).map_or(*wanted.to, |k| k.jet.0[0]);
        let length = wanted.tip_length.unwrap_or_else(|| {
            let mut to = end;
            for slot in wanted.rig.slots {
                to[slot] = wanted.from[slot];
            }
            self.parameter_length(&(to - *wanted.from)).0.max(curve.angle.to_degrees())
        });
        let mut parts: Vec<BlockPart> = Vec::new();
        let mut stands = *wanted.from;
        for (stretch, knots) in &candidate.stretches {
            let Some(begin) = knots.first().map(|k| k.jet.0[0]) else { continue };
            parts.extend(self.turn(wanted, &stands, &begin, stretch.t[0]));
            stands = knots.last().map_or(begin, |k| k.jet.0[0]);
            // A way through a pole without a turn is one part: the joints are smooth there.
            let joined = parts.last_mut().filter(|p| !p.turn && stretch.t[0] > 0.0);
            let pieces = Follower::pieces(knots, length);
            let share = length * (stretch.t[1] - stretch.t[0]);
            match joined.map(|p| (&mut p.shape, &mut p.length, &mut p.t)) {
                Some((BlockShape::Spline(before), before_length, t)) => {
                    let offset = *before_length;
                    before.extend(pieces.into_iter().map(|p| p.moved(offset)));
                    (*before_length, t[1]) = (offset + share, stretch.t[1]);
                }
                _ => {
                    let (shape, tip_moves) = (BlockShape::Spline(pieces), wanted.tip_length.is_some());
                    parts.push(BlockPart { shape, length: share, turn: false, tip_moves, t: stretch.t });
                }
            }
        }
        if !wanted.any_joints {
            let to = *wanted.to;
            parts.extend(self.turn(wanted, &end, &to, 1.0));
            end = to;
        }
        let leaves = curve.pass.as_ref().filter(|p| p.off > AXIS_TOLERANCE).map(|p| Leaves {
            angle: p.off,
            in_cone: true,
            reason: format!(
                "the tool axis is led through the pole of the rotary axes, which the great circle passes at {:.6} degrees",
                p.off.to_degrees()
            ),
        });
        let end = self.joints(wanted.rig, &end, wanted.length);
        BlockTurning::Parts { parts, length, end, leaves, apart: false }
    }

    /// A turn of the rotary joints at t, with tip and axis at rest; none if the turn is only
    /// rounding.
    fn turn(&self, wanted: &AxisTask<'_>, before: &JointValues, after: &JointValues, t: f64) -> Option<BlockPart> {
        let mut from = (wanted.tip)(t).0[0];
        let mut to = from;
        self.take_rotary(&mut from, before);
        self.take_rotary(&mut to, after);
        if (to - from).max_abs() <= ABSORBED {
            return None;
        }
        let (length, _) = self.parameter_length(&(to - from));
        let slope = (to - from) * (1.0 / length);
        Some(BlockPart { shape: BlockShape::Line { from, slope }, length, turn: true, tip_moves: false, t: [t, t] })
    }
}

fn angle_between(a: &Vector, b: &Vector) -> f64 {
    ToolPose { tip: Point::origin(), axis: *a }.angle_to(&ToolPose { tip: Point::origin(), axis: *b })
}
