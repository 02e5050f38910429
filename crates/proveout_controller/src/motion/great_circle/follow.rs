//! The rotary joints along a way of the tool axis: continuation on one branch, knot by knot.
//!
//! *Positions.* The branch is kept, not looked for (`proveout_machine`, `poles.rs`): the joints at a knot are
//! those of this branch.
//!
//! *Derivatives.* With the tool axis F(q) of the rotary joints and the wanted U(t), both as Taylor series,
//! the coefficients of q follow order by order from F(q(t)) = U(t):
//!
//! ```text
//!   j1 q1_k + j2 q2_k = U_k - F_k(q_0 .. q_k-1)        j1, j2: rates of the axis with the two rotary joints
//! ```
//!
//! In a pole j1 is zero, and `q1_k` has no equation of its own order: it comes with the next one, through the
//! change of j1 along the tilt,
//!
//! ```text
//!   m q1_k-1 + j2 q2_k = U_k - F_k(.., q1_k-1 = 0)         m: what q1_k-1 = 1 adds to F_k
//! ```
//!
//! which is linear in q1_k-1, since the axis does not depend on q1 while the tilt is zero. The joints that
//! lead out of a pole are smooth as one-sided limits, and no difference is taken across it.
//!
//! *Knots.* Quintics take value, slope and curvature at both ends. A step is halved until the axis of the
//! quintic, by the forward chain, is on U at its quarters, the tip on its way, and no rotary joint turns far:
//! near a pole at the angle d the steps shrink with d, so that half a turn takes some sixty of them whatever
//! d is.
//!
//! *End of reach.* Where both branches meet apart from a pole (a 45 degree head held level) the joints go
//! with the square root of the way that is left: a slope without bound, which no polynomial has. The last
//! [`LAST_BIT`] of the way is one quintic with a finite slope; the axis leaves U by no more than that.

use proveout_geom::{Point, ToolPose, Vector, wrap_near};
use proveout_machine::{JointKind, JointValues, KinematicsError, Machine};

use super::curve::AxisCurve;
use crate::{jet::JointJet, rtcp::Rig, shape::Quintic};

/// Distance of a quintic from the wanted axis, radian: 1 nanometer at 100 mm from the tip.
const AXIS_ERROR: f64 = 1e-8;
/// Distance of a quintic from the way of the tip, mm.
const TIP_ERROR: f64 = 1e-6;
/// Longest step of the tool axis and of a rotary joint between two knots, radian: 3 degrees change the
/// direction in which a linear joint moves by 5 percent, so that limits along the path hardly vary between
/// them.
const LONGEST: f64 = 0.05;
/// Shortest step of the tool axis, radian: a hundredth of what a pole at the least distance asks for.
const SHORTEST: f64 = 1e-11;
/// Way before the end of reach over which the joints no longer follow it, radian.
const LAST_BIT: f64 = 1e-9;
/// Sine of the angle between the rates of the tool axis below which the axis is at the end of its
/// reach.
const END_OF_REACH: f64 = 1e-6;
/// Difference of joints at a begin in a pole that the first step takes away, radian: rounding of the program.
pub(super) const ABSORBED: f64 = 2e-6;
/// A rest of a stretch that is shorter than this part of it is taken with the step before.
const SLIVER: f64 = 1e-9;

/// A place of the way with task coordinates and derivatives by t.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointKnot {
    pub(super) t: f64,
    pub(super) jet: JointJet,
}

/// A stretch of the way between two poles, or ends of the block.
#[derive(Clone, Copy, Debug)]
pub(super) struct BranchStretch {
    pub(super) t: [f64; 2],
    /// The poles in which it begins and ends.
    pub(super) poles: [Option<Vector>; 2],
    /// Joints at its begin.
    pub(super) begin: JointValues,
    /// Branch; none where there are not two rotary joints.
    pub(super) branch: Option<usize>,
}

/// Follows ways of the tool axis on a machine.
pub(super) struct Follower<'a> {
    pub(super) machine: &'a Machine,
    pub(super) rig: &'a Rig,
    /// Linear task coordinates by t.
    pub(super) tip: &'a dyn Fn(f64) -> JointJet,
}

impl Follower<'_> {
    /// Knots along a stretch. Fails with the t from which the joints do not go on.
    pub(super) fn knots(&self, curve: &AxisCurve, stretch: &BranchStretch) -> Result<Vec<JointKnot>, f64> {
        let [t0, t1] = stretch.t;
        let mut begin = self.knot(curve, stretch, t0, &stretch.begin).ok_or(t0)?;
        // What the joints at the begin differ by from the branch's own is rounding, or taken away by the
        // first step.
        let mut allowance = 0.0_f64;
        for &joint in self.machine.rotary_joints() {
            allowance = allowance.max((begin.jet.0[0][joint] - stretch.begin[joint]).abs());
            begin.jet.0[0][joint] = stretch.begin[joint];
        }
        let last_bit = LAST_BIT / curve.angle;
        let folds = [t0, t1].map(|t| self.at_end_of_reach(curve, stretch, t));
        let longest = (LONGEST / curve.angle).min(0.5 * (t1 - t0));
        let mut knots = vec![begin];
        let (mut t, mut step) = (t0, longest);
        if folds[0] && t1 - t0 > 4.0 * last_bit {
            let next = self.knot(curve, stretch, t0 + last_bit, &stretch.begin).ok_or(t0)?;
            knots[0].jet = self.beside_end_of_reach(&begin, &next);
            knots.push(next);
            t = next.t;
            step = last_bit;
        }
        let target = if folds[1] && t1 - t > 4.0 * last_bit { t1 - last_bit } else { t1 };
        while t < target {
            let rest = target - t;
            // The rest is never a sliver.
            let to = if step >= rest * (1.0 - SLIVER) {
                target
            } else if 2.0 * step > rest {
                t + 0.5 * rest
            } else {
                t + step
            };
            let last = &knots[knots.len() - 1];
            let first = knots.len() == 1;
            let next = self.knot(curve, stretch, to, &last.jet.0[0]);
            if let Some(next) = next.filter(|n| self.fits(curve, last, n, if first { allowance } else { 0.0 })) {
                knots.push(next);
                t = to;
                step = (2.0 * step).min(longest);
            } else {
                step = 0.5 * (to - t);
                if step * curve.angle < SHORTEST {
                    return Err(t);
                }
            }
        }
        if target < t1 {
            let last = knots[knots.len() - 1];
            let mut end = self.knot(curve, stretch, t1, &last.jet.0[0]).ok_or(t)?;
            end.jet = self.beside_end_of_reach(&end, &last);
            knots.push(end);
        }
        Ok(knots)
    }

    /// Quintics over the path parameter, `length` long for the whole block, from 0 on.
    pub(super) fn pieces(knots: &[JointKnot], length: f64) -> Vec<Quintic> {
        let t0 = knots.first().map_or(0.0, |k| k.t);
        let scaled = |jet: &JointJet| JointJet(std::array::from_fn(|k| jet.0[k] * length.powi(-(k as i32))));
        let pairs = knots.windows(2);
        let pieces = pairs.map(|w| {
            let at = |k: &JointKnot| (k.t - t0) * length;
            Quintic::hermite(at(&w[0]), at(&w[1]), &scaled(&w[0].jet), &scaled(&w[1].jet))
        });
        pieces.collect()
    }

    fn knot(&self, curve: &AxisCurve, stretch: &BranchStretch, t: f64, near: &JointValues) -> Option<JointKnot> {
        let wanted = curve.jet(t);
        let pole = [0, 1].into_iter().find_map(|k| stretch.poles[k].filter(|_| t == stretch.t[k]));
        let q = match (stretch.branch, pole) {
            (Some(branch), Some(pole)) => {
                // Out of the pole forward, or into it: out of it backward.
                let way = wanted.0[1].try_normalize(0.0)?;
                let out = if t == stretch.t[0] { way } else { -way };
                let mut q = self.machine.leaving_pole(&pole, &out, near)?[branch];
                for &joint in self.machine.rotary_joints() {
                    q[joint] = wrap_near(q[joint], near[joint]);
                }
                q
            }
            (Some(branch), None) => self.machine.on_branch(&wanted.0[0], branch, near)?,
            (None, _) => {
                let pose = ToolPose { tip: Point::origin(), axis: wanted.0[0] };
                match self.machine.inverse_nearest(&pose, 0.0, near) {
                    Ok(solution) => solution.q,
                    Err(KinematicsError::OverTravel { solution, .. }) => solution.q,
                    Err(_) => return None,
                }
            }
        };
        let mut jet = (self.tip)(t);
        for (i, joint) in self.machine.joints.iter().enumerate() {
            if joint.kind == JointKind::Rotary {
                jet.0[0][i] = q[i];
            }
        }
        match self.machine.rotary_joints() {
            &[first, second] if pole.is_some() => self.rates_in_pole(&mut jet, &wanted.0, [first, second])?,
            _ => self.rates(&mut jet, &wanted.0),
        }
        Some(JointKnot { t, jet })
    }

    /// Rate of the tool axis with a rotary joint.
    fn rate(&self, at: &JointJet, joint: usize) -> Vector {
        let mut jet = JointJet::constant(at.0[0]);
        jet.0[1][joint] = 1.0;
        self.rig.axis(&jet).0[1]
    }

    /// First and second coefficients of the rotary joints away from a pole. Left at zero at the end of reach.
    fn rates(&self, jet: &mut JointJet, wanted: &[Vector; 4]) {
        let rotary = self.machine.rotary_joints();
        let rates: Vec<Vector> = rotary.iter().map(|&j| self.rate(jet, j)).collect();
        let axis = wanted[0];
        let flat = |a: &Vector, b: &Vector| axis.dot(&a.cross(b));
        for k in 1..=2 {
            let rest = wanted[k] - self.rig.axis(jet).0[k];
            match (rotary, &rates[..]) {
                (&[first, second], [a, b]) => {
                    let area = flat(a, b);
                    if area.abs() > END_OF_REACH * a.norm() * b.norm() {
                        jet.0[k][first] = flat(&rest, b) / area;
                        jet.0[k][second] = flat(a, &rest) / area;
                    }
                }
                _ => {
                    // The smallest step: with two unit vectors across the axis, A' (A A')^-1 rest.
                    let across = axis.cross(&Vector::ith(axis.iamin(), 1.0)).normalize();
                    let basis = [across, axis.cross(&across)];
                    let gram = nalgebra::Matrix2::from_fn(|m, n| {
                        rates.iter().map(|r| r.dot(&basis[m]) * r.dot(&basis[n])).sum::<f64>()
                    });
                    let Some(inverse) = gram.try_inverse() else { continue };
                    let pull = inverse * nalgebra::Vector2::new(rest.dot(&basis[0]), rest.dot(&basis[1]));
                    for (&joint, rate) in rotary.iter().zip(&rates) {
                        jet.0[k][joint] = rate.dot(&basis[0]) * pull[0] + rate.dot(&basis[1]) * pull[1];
                    }
                }
            }
        }
    }

    /// First and second coefficients of the rotary joints in a pole, where the joint `first` does not turn
    /// the tool.
    fn rates_in_pole(&self, jet: &mut JointJet, wanted: &[Vector; 4], [first, second]: [usize; 2]) -> Option<()> {
        let tilting = self.rate(jet, second);
        jet.0[1][second] = wanted[1].dot(&tilting) / tilting.norm_squared();
        for k in 2..=3 {
            let without = self.rig.axis(jet).0[k];
            jet.0[k - 1][first] = 1.0;
            let turning = self.rig.axis(jet).0[k] - without;
            let rest = wanted[k] - without;
            let flat = |a: &Vector, b: &Vector| wanted[0].dot(&a.cross(b));
            let area = flat(&turning, &tilting);
            if area.abs() <= END_OF_REACH * turning.norm() * tilting.norm() {
                return None;
            }
            jet.0[k - 1][first] = flat(&rest, &tilting) / area;
            jet.0[k][second] = flat(&turning, &rest) / area;
        }
        // The third order was a means; quintics take two.
        jet.0[3][second] = 0.0;
        Some(())
    }

    fn at_end_of_reach(&self, curve: &AxisCurve, stretch: &BranchStretch, t: f64) -> bool {
        let pole = [0, 1].into_iter().any(|k| stretch.poles[k].is_some() && t == stretch.t[k]);
        let (Some(branch), &[first, second], false) = (stretch.branch, self.machine.rotary_joints(), pole) else {
            return false;
        };
        let axis = curve.at(t);
        let Some(q) = self.machine.on_branch(&axis, branch, &stretch.begin) else { return false };
        let at = JointJet::constant(q);
        let (a, b) = (self.rate(&at, first), self.rate(&at, second));
        axis.dot(&a.cross(&b)).abs() <= END_OF_REACH * a.norm() * b.norm()
    }

    /// The knot at the end of reach with slopes that join the square root: half of the mean slope where it is
    /// left off, one and a half at the end, and the change between them.
    fn beside_end_of_reach(&self, end: &JointKnot, beside: &JointKnot) -> JointJet {
        let mut jet = end.jet;
        let way = end.t - beside.t;
        for &joint in self.machine.rotary_joints() {
            let mean = (end.jet.0[0][joint] - beside.jet.0[0][joint]) / way;
            jet.0[1][joint] = 1.5 * mean;
            jet.0[2][joint] = 0.5 * mean / way;
        }
        jet
    }

    /// Whether the quintic between two knots is on the way.
    fn fits(&self, curve: &AxisCurve, a: &JointKnot, b: &JointKnot, allowance: f64) -> bool {
        let turned = |&j: &usize| (b.jet.0[0][j] - a.jet.0[0][j]).abs();
        if self.machine.rotary_joints().iter().map(turned).fold(0.0, f64::max) > LONGEST {
            return false;
        }
        let piece = Quintic::hermite(a.t, b.t, &a.jet, &b.jet);
        [0.25, 0.5, 0.75].into_iter().all(|part| {
            let t = a.t + (b.t - a.t) * part;
            let task = piece.jet(t).0[0];
            let off = (self.machine.forward(&task, 0.0).axis - curve.at(t)).norm();
            let tip = (self.tip)(t).0[0];
            let slots = self.rig.slots;
            let missed = Vector::from_fn(|k, _| task[slots[k]] - tip[slots[k]]).norm();
            off <= AXIS_ERROR + allowance && missed <= TIP_ERROR
        })
    }
}
