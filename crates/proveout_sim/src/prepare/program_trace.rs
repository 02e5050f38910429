//! Where a program takes its tool, without a plan of the motion: ends of motions and points of arcs, in the
//! workpiece frame.
//!
//! The reader gives base coordinates. With tool center point control they are those of the tip on the table;
//! without, positions of the axes less the active tool length, so that
//!
//! ```text
//!   tcp on    tip_in_table = z + base                        z = Machine::program_zero()
//!   tcp off   q(X, Y, Z) = base + length,  q(A, B, C) = base,  tip_in_table = forward(q, gauge length)
//! ```
//!
//! An axis that the program has not programmed yet stays where it is. What lies between the ends of
//! a straight motion of several rotary axes is not followed, and corners are not rounded: this is
//! for extents and first contacts, never for a verdict.

use std::{collections::BTreeMap, f64::consts::PI};

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, ToolPose, Vector};
use proveout_machine::{JointValues, KinematicsError, Machine};
use proveout_nc::{
    AXIS_LETTERS, ArcMotion, Command, Dialect, Motion, Offset, Op, RotarySolution, ToolAction, ToolName,
};

use crate::prepare::control_settings::{length_active_after_change, length_in_machine_coordinates};

/// Angle between two points of an arc, radian: the sagitta is then below 0.1 percent of the radius.
const ARC_STEP: f64 = PI / 36.0;

/// X, Y or Z is programmed in the block, but its end position does not follow from the program.
fn left_open(motion: &Motion) -> bool {
    motion.programmed & 0b111 != 0 && (0..3).all(|axis| motion.end_base.get(axis).is_none())
}

/// How a motion cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WayKind {
    Rapid,
    Feed,
}

/// One motion.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    pub(crate) kind: WayKind,
    /// Points of the tip in the workpiece frame; the first is its start, where that is known.
    pub(crate) points: Vec<Point>,
    /// Tool axis at its end in the workpiece frame.
    pub(crate) axis: Vector,
    /// The joints at its end, where the program moves axes.
    pub(crate) joints: Option<JointValues>,
    /// In machine coordinates (G53, SUPA, M91, reference points).
    pub(crate) machine: bool,
    /// The first point is the start of the motion, known from the program.
    pub(crate) from_known: bool,
}

/// Follows the commands of a program.
pub(crate) struct Tracer<'a> {
    machine: &'a Machine,
    zero: Option<Point>,
    work_from_table: Pose,
    lengths: BTreeMap<ToolName, f64>,
    length_with_change: bool,
    length_in_machine: bool,
    /// The tool in the spindle.
    pub(crate) tool: ToolName,
    /// A tool length is active.
    pub(crate) length_on: bool,
    /// Tool center point control is on.
    pub(crate) tcp: bool,
    base: [Option<f64>; AXIS_LETTERS.len()],
    /// Work to base coordinates.
    frame: (Matrix3<f64>, Vector),
    /// Rotary axes turn about the point so much ahead of the tip, mm.
    turn_center: f64,
    q: JointValues,
    /// Tip and axis on the table, where the program has given them since the start.
    tip: Option<ToolPose>,
    /// The joints are those of `tip`.
    joints_known: bool,
}

/// What a tracer needs besides the machine.
pub(crate) struct TraceSetup {
    /// Workpiece frame to table frame.
    pub(crate) table_from_work: Pose,
    /// Gauge lengths by tool, mm.
    pub(crate) lengths: BTreeMap<ToolName, f64>,
    /// The length of a new tool counts without a word of the program.
    pub(crate) length_with_change: bool,
    /// The length counts in machine coordinates.
    pub(crate) length_in_machine: bool,
    /// Tool in the spindle at the start.
    pub(crate) tool: ToolName,
}

impl<'a> Tracer<'a> {
    pub(crate) fn new(machine: &'a Machine, setup: TraceSetup) -> Self {
        let length_on = setup.length_with_change && setup.tool != ToolName::Empty;
        Self {
            machine,
            zero: machine.program_zero(),
            work_from_table: setup.table_from_work.inverse(),
            lengths: setup.lengths,
            length_with_change: setup.length_with_change,
            length_in_machine: setup.length_in_machine,
            tool: setup.tool,
            length_on,
            tcp: false,
            base: [None; AXIS_LETTERS.len()],
            frame: (Matrix3::identity(), Vector::zeros()),
            turn_center: 0.0,
            q: machine.home(),
            tip: None,
            joints_known: true,
        }
    }

    /// Gauge length of the tool in the spindle, mm; zero where it is unknown.
    pub(crate) fn gauge(&self) -> f64 {
        self.lengths.get(&self.tool).copied().unwrap_or(0.0)
    }

    fn forget_linear(&mut self) {
        self.base[..3].fill(None);
    }

    /// The motion of a command, if it is one.
    pub(crate) fn step(&mut self, command: &Command) -> Option<Way> {
        match &command.op {
            Op::Rapid(motion) => self.straight(motion, WayKind::Rapid),
            Op::Linear(motion) => self.straight(motion, WayKind::Feed),
            Op::Probe(probe) => self.straight(&probe.motion, WayKind::Feed),
            Op::Thread(thread) => self.straight(&thread.motion, WayKind::Feed),
            Op::Spline(spline) => {
                let way = self.straight(&spline.motion, WayKind::Feed);
                way.map(|mut way| {
                    // The curve lies in the hull of its control points.
                    let inner: Vec<Point> = spline.control_base.iter().filter_map(|c| self.at_base(*c)).collect();
                    let end = way.points.pop();
                    way.points.extend(inner);
                    way.points.extend(end);
                    way
                })
            }
            Op::Arc(arc) => self.arc(arc),
            Op::Tool(ToolAction::Change(name)) => {
                self.tool = name.clone();
                self.length_on |= self.length_with_change;
                self.forget_linear();
                None
            }
            Op::Offset(Offset::ToolEdge { edge }) => {
                let on = *edge != 0;
                if on != self.length_on {
                    self.length_on = on;
                    self.forget_linear();
                }
                None
            }
            Op::Offset(Offset::TurnCenter { ahead }) => {
                self.turn_center = *ahead;
                self.forget_linear();
                None
            }
            Op::Frame(frame) => {
                let linear = Matrix3::from_fn(|row, column| frame.rotation[row][column]);
                self.frame = (linear, Vector::from(frame.translation));
                None
            }
            Op::Tcp(tcp) => {
                if tcp.on != self.tcp {
                    self.tcp = tcp.on;
                    self.forget_linear();
                }
                None
            }
            _ => None,
        }
    }

    fn straight(&mut self, motion: &Motion, kind: WayKind) -> Option<Way> {
        let start = self.tip;
        let from_known = start.is_some();
        let joints = self.go(motion)?;
        let end = self.tip?;
        let points: Vec<Point> = start.iter().chain([&end]).map(|p| self.work_from_table.point(&p.tip)).collect();
        let axis = self.work_from_table.vector(&end.axis);
        Some(Way { kind, points, axis, joints, machine: motion.machine_coordinates, from_known })
    }

    /// Takes the end of a motion; the joints where axes were moved. None where the end does not
    /// follow from the program.
    fn go(&mut self, motion: &Motion) -> Option<Option<JointValues>> {
        let tcp = self.tcp && !motion.machine_coordinates;
        if motion.machine_coordinates {
            self.solve_joints();
            let length = if self.length_in_machine && self.length_on { self.gauge() } else { 0.0 };
            self.put_joints(motion, length);
            for letter in 0..AXIS_LETTERS.len() {
                if motion.end_base.get(letter).is_some() && letter < 3 {
                    self.base[letter] = None;
                }
            }
            self.tip = Some(self.machine.forward(&self.q, self.gauge()));
            return Some(Some(self.q));
        }
        for letter in 0..AXIS_LETTERS.len() {
            if let Some(value) = motion.end_base.get(letter) {
                self.base[letter] = Some(value);
            }
        }
        if tcp {
            let zero = self.zero?;
            if left_open(motion) {
                let completed = self.completed(motion, zero)?;
                self.base[..3].copy_from_slice(&completed);
            }
            let known = |axis: usize| self.base[axis].or_else(|| Some(self.tip?.tip[axis] - zero[axis]));
            let mut tip = zero + Vector::new(known(0)?, known(1)?, known(2)?);
            for letter in 3..6 {
                self.put_joint(letter, motion.end_base.get(letter));
            }
            let axis = match motion.tool_axis_base {
                Some([i, j, k]) => Vector::new(i, j, k),
                None => self.machine.forward(&self.q, 0.0).axis,
            };
            if self.turn_center != 0.0 {
                let before = self.tip?.axis;
                tip += (axis - before) * self.turn_center;
            }
            self.tip = Some(ToolPose { tip, axis });
            self.joints_known = false;
            return Some(None);
        }
        self.solve_joints();
        let length = if self.length_on { self.gauge() } else { 0.0 };
        self.put_joints(motion, length);
        if let Some(axis) = motion.tool_axis_base {
            self.turn_to(&Vector::from(axis), motion.solution);
        }
        // An axis without a programmed position is at home, which is no place of the program.
        let told = (0..3).all(|axis| self.base[axis].is_some()) || self.tip.is_some();
        self.tip = Some(self.machine.forward(&self.q, self.gauge()));
        told.then_some(Some(self.q))
    }

    /// Base coordinates of the end of a motion that leaves a coordinate of a turned frame open: the tip stays
    /// along its axis there.
    fn completed(&self, motion: &Motion, zero: Point) -> Option<[Option<f64>; 3]> {
        let (linear, translation) = &self.frame;
        let mut work = linear.try_inverse()? * (self.tip?.tip - zero - translation);
        for axis in (0..3).filter(|axis| motion.programmed >> axis & 1 == 1) {
            work[axis] = motion.end.get(axis)?;
        }
        let base = linear * work + translation;
        Some([0, 1, 2].map(|axis| Some(base[axis])))
    }

    /// The joints under the tip, those nearest to where the axes stood, past their travel where that is
    /// short; none where no position of the axes leads there.
    pub(crate) fn joints_under_tip(&mut self) -> Option<JointValues> {
        self.q = self.joints_at(self.tip.as_ref()?)?;
        self.joints_known = true;
        Some(self.q)
    }

    /// The joints under the tip, after motion that gave the tip alone.
    fn solve_joints(&mut self) {
        if self.joints_known {
            return;
        }
        self.joints_known = true;
        if let Some(q) = self.tip.as_ref().and_then(|pose| self.joints_at(pose)) {
            self.q = q;
        }
    }

    fn joints_at(&self, pose: &ToolPose) -> Option<JointValues> {
        match self.machine.inverse_nearest(pose, self.gauge(), &self.q) {
            Ok(solution) => Some(solution.q),
            Err(KinematicsError::OverTravel { solution, .. }) => Some(solution.q),
            Err(_) => None,
        }
    }

    /// Turns the rotary axes until the tool points along an axis of the table frame (G53.1,
    /// CYCLE800, PLANE), the linear ones at rest.
    fn turn_to(&mut self, axis: &Vector, solution: RotarySolution) {
        let tip = self.machine.forward(&self.q, self.gauge()).tip;
        let pose = ToolPose { tip, axis: *axis };
        let chosen = match solution {
            RotarySolution::Nearest => None,
            RotarySolution::Angle { higher, reference, .. } => {
                let named = reference.and_then(|letter| self.machine.joint_for_letter(letter));
                let joint = named.or_else(|| self.machine.rotary_joints().last().copied());
                let found = joint.map(|j| self.machine.inverse_chosen(&pose, self.gauge(), &self.q, (j, higher)));
                match found {
                    Some(Ok(solution)) => Some(solution.q),
                    Some(Err(KinematicsError::OverTravel { solution, .. })) => Some(solution.q),
                    Some(Err(_)) | None => None,
                }
            }
        };
        let Some(turned) = chosen.or_else(|| self.joints_at(&pose)) else { return };
        for &j in self.machine.rotary_joints() {
            self.q[j] = turned[j];
        }
    }

    fn put_joints(&mut self, motion: &Motion, length: f64) {
        let along = self.machine.spindle.gauge_pose.vector(&Vector::z()) * length;
        for letter in 0..AXIS_LETTERS.len() {
            let shift = if letter < 3 { along[letter] } else { 0.0 };
            self.put_joint(letter, motion.end_base.get(letter).map(|v| v + shift));
        }
    }

    fn put_joint(&mut self, letter: usize, value: Option<f64>) {
        if let (Some(value), Some(joint)) = (value, self.machine.joint_for_letter(AXIS_LETTERS[letter])) {
            self.q[joint] = value;
        }
    }

    /// A point of base coordinates in the workpiece frame, at the present positions of the rotary
    /// axes.
    fn at_base(&self, base: [f64; 3]) -> Option<Point> {
        let tip = if self.tcp {
            self.zero? + Vector::from(base)
        } else {
            let length = if self.length_on { self.gauge() } else { 0.0 };
            let along = self.machine.spindle.gauge_pose.vector(&Vector::z()) * length;
            let mut q = self.q;
            for (axis, value) in base.into_iter().enumerate() {
                q[self.machine.joint_for_letter(AXIS_LETTERS[axis])?] = value + along[axis];
            }
            self.machine.forward(&q, self.gauge()).tip
        };
        Some(self.work_from_table.point(&tip))
    }

    fn arc(&mut self, arc: &ArcMotion) -> Option<Way> {
        let start = [self.base[0], self.base[1], self.base[2]];
        let mut way = self.straight(&arc.motion, WayKind::Feed)?;
        let end = [self.base[0], self.base[1], self.base[2]];
        if let ([Some(x), Some(y), Some(z)], [Some(ex), Some(ey), Some(ez)]) = (start, end) {
            let (from, to) = (Vector::new(x, y, z), Vector::new(ex, ey, ez));
            let (center, normal) = (Vector::from(arc.center_base), Vector::from(arc.normal_base));
            let rise = normal.dot(&(to - from));
            let spoke = from - center;
            let spoke = spoke - normal * normal.dot(&spoke);
            let side = normal.cross(&spoke);
            let count = (arc.sweep / ARC_STEP).ceil().clamp(1.0, 720.0);
            let inner: Vec<Point> = (1..count as usize)
                .filter_map(|i| {
                    let t = i as f64 / count;
                    let (sin, cos) = (arc.sweep * t).sin_cos();
                    let from_center = spoke * cos + side * sin;
                    let height = normal * (normal.dot(&(from - center)) + rise * t);
                    self.at_base((center + from_center + height).into())
                })
                .collect();
            let last = way.points.pop();
            way.points.extend(inner);
            way.points.extend(last);
        }
        Some(way)
    }
}

/// Lengths and heights that differ by less are the same, and a shorter way is none, mm: programs and tool
/// lists are written in steps of 0.0001.
pub(crate) const SAME_MM: f64 = 1e-6;

/// Directions whose cosine is closer to 1 are the same: rounding.
pub(crate) const SAME_DIRECTION: f64 = 1e-9;

pub(crate) fn setup(
    table_from_work: &Pose,
    lengths: BTreeMap<ToolName, f64>,
    dialect: Dialect,
    tool: ToolName,
) -> TraceSetup {
    TraceSetup {
        table_from_work: *table_from_work,
        lengths,
        length_with_change: length_active_after_change(dialect),
        length_in_machine: length_in_machine_coordinates(dialect),
        tool,
    }
}
