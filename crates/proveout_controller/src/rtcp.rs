//! Joint positions and their derivatives along a path with tool center point control.
//!
//! *Task coordinates*: one number a joint, as in [`JointValues`], in which the three linear joints that
//! follow the tip are replaced by the coordinates of the tip in the table frame K. The control runs straight
//! lines, arcs and corner blends in task coordinates; without tool center point control they are the joints
//! themselves.
//!
//! The way back closes the loop of the machine: with the tip p in K, rotary joints given, and the tool end at
//! (0, 0, -L) in the spindle frame S,
//!
//! ```text
//!    M_from_K(q) p = M_from_S(q) (0, 0, -L)
//! ```
//!
//! Both chains are products of turns about fixed lines and of shifts along fixed directions (machine at
//! zero), so that the equation is linear in the linear joints: `sum of D_i q_i = r`, where `D_i` is the
//! direction of joint i turned by the rotary joints between it and the base. With jets for everything, the
//! coefficients of q follow order by order: `D(0) q(k) = r(k) - sum over m of D(m) q(k - m)`.

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{Carries, JointKind, JointValues, Machine};

use crate::{
    jet::{Jet, JointJet, VectorJet},
    program_runs::base_zero,
};

/// Volume of three unit directions below which they are in a plane.
const IN_A_PLANE: f64 = 1e-9;

struct RigLink {
    joint: usize,
    rotary: bool,
    /// Unit direction times sense.
    direction: Vector,
    point: Vector,
    /// Vector of the shift that comes with the turn, `(cos q - 1)` times it, where the joint has one.
    shift: Option<Vector>,
}

/// The two chains of a machine, prepared for task coordinates.
pub(crate) struct Rig {
    tool: Vec<RigLink>,
    work: Vec<RigLink>,
    gauge_pose: Pose,
    /// From a point to the followed linear joints, where no rotary joint turns their directions.
    inverse: Option<Matrix3<f64>>,
    /// The linear joints that follow the tip: the task coordinates at these indices are x, y, z of
    /// K, in this order.
    pub(crate) slots: [usize; 3],
    /// The point of K from which base coordinates of the program count with tool center point control.
    pub(crate) zero: Vector,
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
            RigLink { joint, rotary: j.is_rotary(), direction, point: j.point.coords, shift: j.turn_shift.map(|s| s.0) }
        };
        let rig = Self {
            tool: machine.tool_chain.iter().map(link).collect(),
            work: machine.work_chain.iter().map(link).collect(),
            gauge_pose: machine.spindle.gauge_pose,
            inverse: None,
            slots,
            zero: base_zero(machine),
        };
        let inverse = rig.fixed_directions().and_then(|m| m.try_inverse());
        let rig = Self { inverse, ..rig };
        let directions = slots.map(|i| machine.joints[i].direction);
        let volume = directions[0].cross(&directions[1]).dot(&directions[2]);
        debug_assert!(machine.joints.iter().all(|j| j.carries == Carries::Tool || j.carries == Carries::Workpiece));
        (volume.abs() > IN_A_PLANE).then_some(rig)
    }

    /// Directions of the followed linear joints, the tool's less the workpiece's, if no rotary joint carries
    /// any of them.
    fn fixed_directions(&self) -> Option<Matrix3<f64>> {
        let mut columns = [Vector::zeros(); 3];
        for (chain, sign) in [(&self.tool, 1.0), (&self.work, -1.0)] {
            // From the base outward: what follows a rotary joint is turned by it.
            let first_rotary = chain.iter().position(|l| l.rotary).unwrap_or(chain.len());
            for (at, link) in chain.iter().enumerate() {
                if let Some(k) = self.slots.iter().position(|&j| j == link.joint) {
                    if at > first_rotary {
                        return None;
                    }
                    columns[k] = link.direction * sign;
                }
            }
        }
        Some(Matrix3::from_columns(&columns))
    }

    /// Joint positions and derivatives from task coordinates and their derivatives, for a tool of length
    /// `length`. None where the linear directions become dependent (a machine with linear joints above rotary
    /// ones).
    pub(crate) fn joints(&self, task: &JointJet, length: f64) -> Option<JointJet> {
        let x = self.linear::<4>(task, length)?;
        let mut out = *task;
        for (values, x) in out.0.iter_mut().zip(&x) {
            for (slot, &joint) in self.slots.iter().enumerate() {
                values[joint] = x[slot];
            }
        }
        Some(out)
    }

    /// Joint positions alone, the same to the last bit.
    pub(crate) fn position(&self, task: &JointValues, length: f64) -> Option<JointValues> {
        let [x] = self.linear::<1>(&JointJet::constant(*task), length)?;
        let mut out = *task;
        for (slot, &joint) in self.slots.iter().enumerate() {
            out[joint] = x[slot];
        }
        Some(out)
    }

    /// The followed linear joints, up to order N - 1.
    fn linear<const N: usize>(&self, task: &JointJet, length: f64) -> Option<[Vector; N]> {
        let tip = VectorJet::<N>(std::array::from_fn(|k| {
            let t = &task.0[k];
            Vector::new(t[self.slots[0]], t[self.slots[1]], t[self.slots[2]])
        }));
        let end = self.gauge_pose.point(&Point::new(0.0, 0.0, -length)).coords;
        let (p_work, d_work) = self.run(&self.work, tip, task);
        let (p_tool, d_tool) = self.run(&self.tool, VectorJet::constant(end), task);
        let rest = p_work.minus(&p_tool);
        if let Some(inverse) = &self.inverse {
            let mut x = rest.0;
            x.iter_mut().for_each(|r| *r = inverse * *r);
            return Some(x);
        }
        let columns: [VectorJet<N>; 3] = std::array::from_fn(|k| d_tool[k].minus(&d_work[k]));
        let matrix = |m: usize| Matrix3::from_columns(&[columns[0].0[m], columns[1].0[m], columns[2].0[m]]);
        let inverse = matrix(0).try_inverse()?;
        let mut x = [Vector::zeros(); N];
        for k in 0..N {
            let mut r = rest.0[k];
            for m in 1..=k {
                r -= matrix(m) * x[k - m];
            }
            x[k] = inverse * r;
        }
        Some(x)
    }

    /// Carries a point through a chain, from its end to the base, with all followed linear joints at zero,
    /// and the directions of those joints likewise where rotary joints turn them.
    #[inline]
    fn run<const N: usize>(
        &self,
        chain: &[RigLink],
        mut p: VectorJet<N>,
        task: &JointJet,
    ) -> (VectorJet<N>, [VectorJet<N>; 3]) {
        let mut d = [VectorJet::constant(Vector::zeros()); 3];
        let mut met = [false; 3];
        let turns = self.inverse.is_none();
        for link in chain.iter().rev() {
            if link.rotary {
                let (s, c) = task.joint::<N>(link.joint).sin_cos();
                p.0[0] -= link.point;
                p = p.turned(&link.direction, &s, &c);
                p.0[0] += link.point;
                if let Some(shift) = link.shift {
                    let mut drop = c;
                    drop.0[0] -= 1.0;
                    p = p.plus(&VectorJet::constant(shift).times(&drop));
                }
                for k in 0..3 {
                    if turns && met[k] {
                        d[k] = d[k].turned(&link.direction, &s, &c);
                    }
                }
            } else if let Some(k) = self.slots.iter().position(|&j| j == link.joint) {
                if turns {
                    d[k] = VectorJet::constant(link.direction);
                    met[k] = true;
                }
            } else {
                p = p.plus(&VectorJet::constant(link.direction).times(&task.joint(link.joint)));
            }
        }
        (p, d)
    }

    /// How far the followed linear joints may be off where the tip is off by `tip` and each rotary joint by
    /// `angle`; none where rotary joints turn the directions of linear ones.
    ///
    /// Both chains carry a point link by link. Two points that lie apart by x before a rotary link,
    /// with angles that differ by `angle`, lie apart by no more than `x + angle (r + x)` after it,
    /// r being the distance of the first from the axis: the turn of one keeps their distance, and
    /// the chord of the rest is no longer than its arc.
    pub(crate) fn slack(&self, task: &JointValues, length: f64, tip: f64, angle: f64) -> Option<[f64; 3]> {
        let inverse = self.inverse.as_ref()?;
        let carried = |chain: &[RigLink], start: Vector, off: f64| {
            let (mut p, mut off) = (start, off);
            for link in chain.iter().rev() {
                if link.rotary {
                    let arm = p - link.point;
                    let distance = (arm - link.direction * arm.dot(&link.direction)).norm();
                    off += angle * (distance + off + link.shift.map_or(0.0, |shift| shift.norm()));
                    let (s, c) = proveout_geom::sin_cos(task[link.joint]);
                    let turned = VectorJet::<1>([arm]).turned(&link.direction, &Jet([s]), &Jet([c]));
                    p = turned.0[0] + link.point + link.shift.map_or(Vector::zeros(), |shift| shift * (c - 1.0));
                } else if !self.slots.contains(&link.joint) {
                    p += link.direction * task[link.joint];
                }
            }
            off
        };
        let end = self.gauge_pose.point(&Point::new(0.0, 0.0, -length)).coords;
        let [x, y, z] = self.slots.map(|slot| task[slot]);
        let off = carried(&self.work, Vector::new(x, y, z), tip) + carried(&self.tool, end, 0.0);
        Some(std::array::from_fn(|k| inverse.row(k).norm() * off))
    }

    /// The tip that the task coordinates give.
    pub(crate) fn point(&self, task: &JointValues) -> Vector {
        Vector::from_fn(|k, _| task[self.slots[k]])
    }

    /// Tool axis in K with its derivatives, from the rotary joints of task coordinates.
    pub(crate) fn axis(&self, task: &JointJet) -> VectorJet {
        let mut axis = VectorJet::constant(self.gauge_pose.vector(&Vector::z()));
        for link in self.tool.iter().rev().filter(|l| l.rotary) {
            let (s, c) = task.joint(link.joint).sin_cos();
            axis = axis.turned(&link.direction, &s, &c);
        }
        // From the base out to the table each turn is undone.
        for link in self.work.iter().filter(|l| l.rotary) {
            let (s, c) = task.joint(link.joint).sin_cos();
            axis = axis.turned(&-link.direction, &s, &c);
        }
        axis
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_platform_shifts_sideways_with_its_tilt() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/lu-hybrid-ii");
        let machine = Machine::read(&folder).expect("library machine");
        assert!(machine.joints.iter().any(|j| j.turn_shift.is_some()));
        let rig = Rig::new(&machine).expect("three slides");
        for step in 0..20 {
            let mut q = machine.home();
            for j in 0..machine.joints.len() {
                q[j] +=
                    if machine.joints[j].is_rotary() { 0.03 } else { 7.0 } * f64::from(step) * (0.3 + j as f64 * 0.1);
            }
            let task = JointJet::constant(rig.task(&machine, &q, 80.0));
            let value = rig.joints(&task, 80.0).expect("independent slides").0[0];
            let alone = rig.position(&task.0[0], 80.0).expect("independent slides");
            assert!((alone - value).max_abs() < 1e-11);
            for j in 0..machine.joints.len() {
                // Slides of a few hundred mm: rounding of some 1e-13 mm.
                assert!((value[j] - q[j]).abs() < 1e-10, "step {step} joint {j}: {} {}", value[j], q[j]);
            }
        }
    }

    /// A machine of three linear joints and two rotary ones in the given places.
    fn machine(rotary: [(&str, &str, &str); 2], linear_parent: &str, spindle_on: &str, table_on: &str) -> Machine {
        let mut text = String::from("name = \"rig\"\ndescription = \"test\"\n");
        let lines = [("X", "[1, 0, 0]", linear_parent), ("Y", "[0, 1, 0]", "X"), ("Z", "[0, 0, 1]", "Y")];
        for (name, direction, parent) in lines {
            text += &format!(
                "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
                 direction = {direction}\n"
            );
        }
        for (name, carries, parent) in rotary {
            let direction = if name == "C" { "[0, 0, 1]" } else { "[0, 1, 0]" };
            text += &format!(
                "[[joint]]\nname = \"{name}\"\nkind = \"rotary\"\ncarries = \"{carries}\"\nparent = \"{parent}\"\n\
                 direction = {direction}\npoint_mm = [3, -4, 25]\nsense = -1\nendless = true\n"
            );
        }
        text += &format!(
            "[spindle]\non = \"{spindle_on}\"\norigin_mm = [0, 0, 40]\ndirection = [0, 0, 1]\nstart_time_s = 0\n\
             [table]\non = \"{table_on}\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
             [control]\ncycle_time_ms = 2\nblock_time_ms = 0\ntool_change_time_s = 0\nrapid_mode = \"straight\"\n\
             default_tolerance_mm = 0.01\n"
        );
        match Machine::from_text(Path::new("rig.toml"), &text) {
            Ok(m) => m,
            Err(e) => panic!("{e}"),
        }
    }

    #[test]
    fn derivatives_match_differences_of_the_inverse_kinematics() {
        let machines = [
            machine([("B", "workpiece", "base"), ("C", "workpiece", "B")], "base", "Z", "C"),
            machine([("C", "tool", "Z"), ("B", "tool", "C")], "base", "B", "base"),
            machine([("C", "workpiece", "base"), ("B", "tool", "Z")], "base", "B", "C"),
        ];
        let length = 130.0;
        for m in &machines {
            let rig = Rig::new(m).expect("three linear joints");
            let (b, c) = (m.joint("B").expect("B"), m.joint("C").expect("C"));
            // A cubic in every task coordinate.
            let coefficients = |k: usize| -> [f64; 4] {
                let k = k as f64;
                [10.0 - 7.0 * k, 3.0 + k, 1.5 - 0.4 * k, 0.2 * k - 0.5]
            };
            let task = |s: f64| {
                let mut t = JointJet::constant(JointValues::ZERO);
                let mut put = |joint: usize, c: [f64; 4]| {
                    // Taylor coefficients of the cubic about s.
                    t.0[0][joint] = c[0] + s * (c[1] + s * (c[2] + s * c[3]));
                    t.0[1][joint] = c[1] + s * (2.0 * c[2] + s * 3.0 * c[3]);
                    t.0[2][joint] = c[2] + 3.0 * s * c[3];
                    t.0[3][joint] = c[3];
                };
                for (k, slot) in rig.slots.into_iter().enumerate() {
                    put(slot, coefficients(k));
                }
                put(b, [0.4, 0.3, -0.2, 0.1]);
                put(c, [-0.7, 0.5, 0.1, -0.3]);
                t
            };
            let position = |s: f64| {
                let t = task(s).0[0];
                let tip = Point::new(t[rig.slots[0]], t[rig.slots[1]], t[rig.slots[2]]);
                m.inverse_with_rotary(&tip, &t, length)
            };
            let q = rig.joints(&task(0.3), length).expect("regular");
            assert_eq!(rig.position(&task(0.3).0[0], length), Some(q.0[0]));
            assert!((q.0[0] - position(0.3)).max_abs() < 1e-11);
            let alone = rig.position(&task(0.3).0[0], length).expect("regular");
            assert!((alone - q.0[0]).max_abs() < 1e-12);
            let back = rig.task(m, &q.0[0], length);
            assert!((back - task(0.3).0[0]).max_abs() < 1e-11);
            // Differences of fourth order accuracy for the first, of second order for the others: errors of
            // h^4 and h^2 times higher derivatives of about 1000, and rounding 1e-13 over the power of h.
            let h = 2e-3;
            let at = |k: i32| position(0.3 + f64::from(k) * h);
            let first = ((at(1) - at(-1)) * 8.0 - (at(2) - at(-2))) * (1.0 / (12.0 * h));
            let second = (at(1) + at(-1) - at(0) * 2.0) * (1.0 / (h * h));
            let third = (at(2) - at(-2) - (at(1) - at(-1)) * 2.0) * (1.0 / (2.0 * h * h * h));
            assert!((q.first() - first).max_abs() < 1e-7, "{:?} {first:?}", q.first());
            assert!((q.second() - second).max_abs() < 1e-2, "{:?} {second:?}", q.second());
            assert!((q.third() - third).max_abs() < 1e-1, "{:?} {third:?}", q.third());
        }
    }
}
