//! Joint positions and their derivatives along a path with tool center point control.
//!
//! *Task coordinates*: one number a joint, as in [`JointValues`], in which the three linear joints that follow the tip
//! are replaced by the coordinates of the tip in the table frame K. The control runs straight lines, arcs and corner
//! blends in task coordinates; without tool center point control they are the joints themselves.
//!
//! The way back closes the loop of the machine: with the tip p in K, rotary joints given, and the tool end at (0, 0, -L)
//! in the spindle frame S,
//!
//! ```text
//!    M_from_K(q) p = M_from_S(q) (0, 0, -L)
//! ```
//!
//! Both chains are products of turns about fixed lines and of shifts along fixed directions (machine at zero), so that
//! the equation is linear in the linear joints: `sum of D_i q_i = r`, where `D_i` is the direction of joint i turned by
//! the rotary joints between it and the base. With jets for everything, the coefficients of q follow order by order:
//! `D(0) q(k) = r(k) - sum over m of D(m) q(k - m)`.

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{Carries, JointKind, JointValues, Machine};

use crate::jet::{JointJet, VectorJet};

struct Link {
    joint: usize,
    rotary: bool,
    /// Unit direction times sense.
    direction: Vector,
    point: Vector,
}

/// The two chains of a machine, prepared for task coordinates.
pub(crate) struct Rig {
    tool: Vec<Link>,
    work: Vec<Link>,
    gauge_pose: Pose,
    /// The linear joints that follow the tip; entry k of task coordinates stands for x, y, z of K in this order.
    pub(crate) slots: [usize; 3],
}

impl Rig {
    /// None when the machine has not exactly three free, independent linear joints.
    pub(crate) fn new(machine: &Machine) -> Option<Self> {
        let free: Vec<usize> = machine
            .joints
            .iter()
            .enumerate()
            .filter(|(i, j)| {
                j.kind == JointKind::Linear
                    && !j.held
                    && (machine.tool_chain.contains(i) || machine.work_chain.contains(i))
            })
            .map(|(i, _)| i)
            .collect();
        let slots: [usize; 3] = free.try_into().ok()?;
        let link = |&joint: &usize| {
            let j = &machine.joints[joint];
            let direction = j.direction * j.sense;
            Link { joint, rotary: j.is_rotary(), direction, point: j.point.coords }
        };
        let rig = Self {
            tool: machine.tool_chain.iter().map(link).collect(),
            work: machine.work_chain.iter().map(link).collect(),
            gauge_pose: machine.spindle.gauge_pose,
            slots,
        };
        let directions = slots.map(|i| machine.joints[i].direction);
        let volume = directions[0].cross(&directions[1]).dot(&directions[2]);
        debug_assert!(machine.joints.iter().all(|j| j.carries == Carries::Tool || j.carries == Carries::Workpiece));
        (volume.abs() > 1e-9).then_some(rig)
    }

    /// Joint positions and derivatives from task coordinates and their derivatives, for a tool of length `length`.
    /// None where the linear directions become dependent (a machine with linear joints above rotary ones).
    pub(crate) fn joints(&self, task: &JointJet, length: f64) -> Option<JointJet> {
        let tip = VectorJet(std::array::from_fn(|k| {
            let t = &task.0[k];
            Vector::new(t[self.slots[0]], t[self.slots[1]], t[self.slots[2]])
        }));
        let end = self.gauge_pose.point(&Point::new(0.0, 0.0, -length)).coords;
        let (p_work, d_work) = self.run(&self.work, tip, task);
        let (p_tool, d_tool) = self.run(&self.tool, VectorJet::constant(end), task);
        let rest = p_work.minus(&p_tool);
        let mut columns = [VectorJet::constant(Vector::zeros()); 3];
        for k in 0..3 {
            columns[k] = d_tool[k].minus(&d_work[k]);
        }
        let matrix = |m: usize| Matrix3::from_columns(&[columns[0].0[m], columns[1].0[m], columns[2].0[m]]);
        let inverse = matrix(0).try_inverse()?;
        let mut x = [inverse * rest.0[0], Vector::zeros(), Vector::zeros(), Vector::zeros()];
        let fixed = columns.iter().all(VectorJet::is_constant);
        for k in 1..4 {
            let mut r = rest.0[k];
            if !fixed {
                for m in 1..=k {
                    r -= matrix(m) * x[k - m];
                }
            }
            x[k] = inverse * r;
        }
        let mut out = *task;
        for k in 0..4 {
            for (slot, &joint) in self.slots.iter().enumerate() {
                out.0[k][joint] = x[k][slot];
            }
        }
        Some(out)
    }

    /// Carries a point through a chain, from its end to the base, with all followed linear joints at zero, and the
    /// directions of those joints likewise.
    fn run(&self, chain: &[Link], mut p: VectorJet, task: &JointJet) -> (VectorJet, [VectorJet; 3]) {
        let mut d = [VectorJet::constant(Vector::zeros()); 3];
        let mut met = [false; 3];
        for link in chain.iter().rev() {
            let q = task.joint(link.joint);
            if link.rotary {
                let (s, c) = q.sin_cos();
                p.0[0] -= link.point;
                p = p.turned(&link.direction, &s, &c);
                p.0[0] += link.point;
                for k in 0..3 {
                    if met[k] {
                        d[k] = d[k].turned(&link.direction, &s, &c);
                    }
                }
            } else if let Some(k) = self.slots.iter().position(|&j| j == link.joint) {
                d[k] = VectorJet::constant(link.direction);
                met[k] = true;
            } else {
                p = p.plus(&VectorJet::constant(link.direction).times(&q));
            }
        }
        (p, d)
    }

    /// Task coordinates of a position of the joints.
    pub(crate) fn task(&self, machine: &Machine, q: &JointValues, length: f64) -> JointValues {
        let tip = machine.forward(q, length).tip;
        let mut task = *q;
        for (k, &joint) in self.slots.iter().enumerate() {
            task[joint] = tip[k];
        }
        task
    }
}
