//! From canonical motions to exact paths in task coordinates.

mod great_circle;
mod programmed;
mod retract;
mod spline;

use nalgebra::Matrix3;
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{AXIS_TOLERANCE, JointKind, JointValues, KinematicsError, Machine};
use proveout_nc::{AXIS_LETTERS, ArcMotion, Location, Motion, Note, OrientationInterpolation, RotarySolution};

use self::great_circle::{AxisTask, BlockTurning};
pub(crate) use self::programmed::ProgrammedMotion;
use self::programmed::{AxisWay, TipWay};
use crate::{
    error::ControlError,
    jet::JointJet,
    mapping::Mapping,
    rtcp::Rig,
    shape::{Arc, BlockShape},
};

/// Displacements of the tip below this (mm) are none: a thousandth of the finest increment of a control.
const NO_TIP_MM: f64 = 1e-7;
/// Turns below this (degrees) are none.
const NO_TURN_DEG: f64 = 1e-9;
/// Two programmed base coordinates nearer than this (mm or radian) are the same: the axis was not moved.
const SAME_BASE: f64 = 1e-9;
/// Largest difference of the radii at start and end of an arc, mm and relative: above it the program is
/// wrong; below, the arc runs as a spiral.
const RADIUS_MISMATCH_MM: f64 = 0.05;
const RADIUS_MISMATCH: f64 = 0.01;
/// Sine of the angle above which positions do not point the tool along the programmed axis.
const OFF_AXIS: f64 = 1e-5;
/// An arc of a smaller radius is none, mm.
const NO_RADIUS_MM: f64 = 1e-9;

/// Position of machine and program before a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Position {
    /// Joints.
    pub(crate) q: JointValues,
    /// Base coordinates last programmed, by axis letter; none where their meaning has changed since
    /// (tool length, tool center point control). The program must then set them again; an axis
    /// without a new value stays.
    pub(crate) base: [Option<f64>; AXIS_LETTERS.len()],
    /// Tip and tool axis in K as programmed with tool center point control, whatever the joints
    /// made of them.
    pub(crate) told: Option<ToolPose>,
}

/// A part of a block that runs without a stop.
pub(crate) struct BlockPart {
    pub(crate) shape: BlockShape,
    pub(crate) length: f64,
    /// The rotary joints turn in a pole, while tip and tool axis are at rest.
    pub(crate) turn: bool,
    /// False when the length is in degrees since the tip does not move.
    pub(crate) tip_moves: bool,
    /// Share of the block's way that it runs.
    pub(crate) t: [f64; 2],
}

/// The tool axis leaves the great circle of the program.
pub(crate) struct Leaves {
    /// By how much, radian.
    pub(crate) angle: f64,
    /// Inside of the cone about a pole where the control may.
    pub(crate) in_cone: bool,
    /// Why.
    pub(crate) reason: String,
}

/// Path of one block.
pub(crate) struct BlockPath {
    /// One at least.
    pub(crate) parts: Vec<BlockPart>,
    /// Length of the parts but the turns.
    pub(crate) length: f64,
    /// False when the parameter is in degrees since the tip does not move.
    pub(crate) tip_moves: bool,
    /// Position of the joints at the end.
    pub(crate) end: JointValues,
    /// A tool axis that no joint positions reach, with the reason.
    pub(crate) unreachable: Option<(ToolPose, String)>,
    /// The great circle that it leaves.
    pub(crate) leaves: Option<Leaves>,
    /// Tip and tool axis run their ways one after the other, not in step.
    pub(crate) apart: bool,
    /// What the program says of the way.
    pub(crate) programmed: Option<Box<ProgrammedMotion>>,
    /// The position of the rotary axes that the program chose is out of travel, and the other one is taken:
    /// what is said of it.
    pub(crate) other_position: Option<Note>,
}

impl BlockPath {
    /// A block in one part.
    pub(crate) fn whole(shape: BlockShape, length: f64, tip_moves: bool, end: JointValues) -> Self {
        let parts = vec![BlockPart { shape, length, turn: false, tip_moves, t: [0.0, 1.0] }];
        Self {
            parts,
            length,
            tip_moves,
            end,
            unreachable: None,
            leaves: None,
            apart: false,
            programmed: None,
            other_position: None,
        }
    }

    /// The same block with what is made of its great circle.
    fn turned(self, turning: BlockTurning) -> Self {
        match turning {
            BlockTurning::InProportion(leaves) => Self { leaves, ..self },
            BlockTurning::Parts { parts, length, end, leaves, apart } => {
                Self { parts, length, end, leaves, apart, ..self }
            }
        }
    }
}

/// What came of turning the rotary joints to a tool axis.
#[derive(Default)]
struct TurnResult {
    /// A tool axis that no joint positions reach, with the reason.
    unreachable: Option<(ToolPose, String)>,
    /// See [`BlockPath::other_position`].
    other_position: Option<Note>,
}

/// What a motion needs to know.
pub(crate) struct Context<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) rig: Option<&'a Rig>,
    pub(crate) mapping: Mapping,
    /// Tool length that the control applies, mm.
    pub(crate) active_length: f64,
    pub(crate) orientation: OrientationInterpolation,
    /// Cone about a pole inside of which the tool axis may leave its great circle, radian.
    pub(crate) pole_cone: f64,
    /// The motion is a rapid one.
    pub(crate) rapid: bool,
    pub(crate) location: &'a Location,
}

impl Context<'_> {
    fn fail(&self, code: &'static str, message: String, help: &str) -> Box<ControlError> {
        Box::new(ControlError::at(self.location, code, message, help))
    }

    /// Tool length in the axes X, Y, Z without tool center point control: along the spindle with all joints
    /// at zero.
    fn length_offset(&self) -> Vector {
        self.machine.spindle.gauge_pose.vector(&Vector::z()) * self.active_length
    }

    /// The motion with base coordinates, where a turned frame let the program give only some work
    /// coordinates: the others are those of the machine, seen in the frame. None where the motion has what it
    /// needs.
    pub(crate) fn completed(
        &self,
        motion: &Motion,
        (rotation, translation): ([[f64; 3]; 3], [f64; 3]),
        position: &Position,
    ) -> Option<Motion> {
        let given = motion.programmed & 0b111;
        let none = (0..3).all(|axis| motion.end_base.get(axis).is_none());
        if given == 0 || motion.machine_coordinates || !none {
            return None;
        }
        let now: [f64; 3] = match self.mapping.tcp_length.zip(self.rig) {
            Some((length, rig)) => {
                let task = rig.task(self.machine, &position.q, length);
                std::array::from_fn(|axis| task[rig.slots[axis]] - rig.zero[axis])
            }
            None => {
                let offset = self.length_offset();
                let mut now = [0.0; 3];
                for (axis, value) in now.iter_mut().enumerate() {
                    *value = position.q[self.machine.joint_for_letter(AXIS_LETTERS[axis])?] - offset[axis];
                }
                now
            }
        };
        let linear = Matrix3::from_fn(|row, column| rotation[row][column]);
        let shift = Vector::from(translation);
        let mut work = linear.try_inverse()? * (Vector::from(now) - shift);
        for axis in 0..3 {
            if given >> axis & 1 == 1 {
                work[axis] = motion.end.get(axis)?;
            }
        }
        let base = linear * work + shift;
        let mut motion = motion.clone();
        for axis in 0..3 {
            motion.end_base.put(axis, base[axis]);
        }
        Some(motion)
    }

    /// Joint of each axis letter that moves in this motion, with its target in base coordinates.
    fn targets(&self, motion: &Motion, position: &Position) -> Result<Vec<(usize, usize, f64)>, Box<ControlError>> {
        let mut targets = Vec::with_capacity(6);
        let linear = |values: &proveout_nc::AxisValues| (0..3).any(|axis| values.get(axis).is_some());
        if motion.programmed & 0b111 != 0 && linear(&motion.end) && !linear(&motion.end_base) {
            let message = "in the turned frame this motion needs a coordinate that the program has not set".to_owned();
            let help = "program X, Y and Z in the first block of the tilted plane";
            return Err(self.fail("control-unsupported", message, help));
        }
        for (letter_index, &letter) in AXIS_LETTERS.iter().enumerate() {
            let Some(value) = motion.end_base.get(letter_index) else { continue };
            if !value.is_finite() {
                return Err(self.fail(
                    "control-not-a-number",
                    format!("the end of the motion in {letter} is {value}"),
                    "check the expressions of this block",
                ));
            }
            let programmed = motion.programmed >> letter_index & 1 == 1;
            let moved = position.base[letter_index].is_none_or(|last| (value - last).abs() > SAME_BASE);
            if !programmed && (motion.machine_coordinates || !moved) {
                continue;
            }
            match self.machine.joint_for_letter(letter) {
                Some(joint) => targets.push((letter_index, joint, value)),
                None if programmed => {
                    let names: Vec<&str> = self.machine.joints.iter().map(|j| j.name.as_str()).collect();
                    return Err(self.fail(
                        "control-axis",
                        format!(
                            "axis {letter} is programmed, but machine {} has no joint of this name",
                            self.machine.name
                        ),
                        &format!("the machine's joints are {}", names.join(", ")),
                    ));
                }
                None => {}
            }
        }
        Ok(targets)
    }

    /// A target of a joint, where the setup does not hold it elsewhere.
    fn unless_held(&self, joint: usize, value: f64) -> Result<f64, Box<ControlError>> {
        let Some(held) = self.machine.joints.get(joint).filter(|j| j.held && (value - j.home).abs() > SAME_BASE) else {
            return Ok(value);
        };
        let (unit, scale) = (held.kind.unit(), held.kind.unit_factor());
        let message = format!(
            "{} is sent to {:.3} {unit}, but the setup holds it at {:.3} {unit}",
            held.name,
            value * scale,
            held.home * scale
        );
        Err(self.fail("control-axis", message, "take `held` off the joint in the machine file, or leave the axis out"))
    }

    /// End of a motion in joints (no tool center point control, or machine coordinates). A tool axis turns
    /// the rotary joints while the linear joints stay or go where the block says (swiveling).
    fn end_in_joints(
        &self,
        motion: &Motion,
        position: &Position,
    ) -> Result<(JointValues, TurnResult), Box<ControlError>> {
        let offset = self.length_offset();
        let mut q = position.q;
        for (letter, joint, value) in self.targets(motion, position)? {
            q[joint] = self.unless_held(joint, value + if letter < 3 { offset[letter] } else { 0.0 })?;
        }
        let mut turned = TurnResult::default();
        if let Some(axis) = motion.tool_axis_base {
            let tip = self.machine.forward(&q, self.active_length).tip;
            turned = self.turn_to((axis, motion.solution), tip, self.active_length, position, &mut q)?;
        }
        Ok((q, turned))
    }

    /// Turns the rotary joints of `q` to a tool axis, to the solution nearest to their present
    /// position or the one the program chooses. An axis that cannot be reached is returned and
    /// leaves the joints unchanged.
    fn turn_to(
        &self,
        (axis, solution): ([f64; 3], RotarySolution),
        tip: Point,
        length: f64,
        position: &Position,
        q: &mut JointValues,
    ) -> Result<TurnResult, Box<ControlError>> {
        let axis = Vector::from(axis);
        // Within rounding of a pole its azimuth says nothing.
        let axis = axis.try_normalize(0.0).and_then(|u| self.pole_at(&u, &position.q)).unwrap_or(axis);
        let pose = ToolPose { tip, axis };
        let choice = self.choice(solution);
        let found = match choice {
            None => self.machine.inverse_nearest(&pose, length, &position.q),
            Some((joint, higher, _)) => self.machine.inverse_chosen(&pose, length, &position.q, (joint, higher)),
        };
        let turned = match found {
            Ok(solution) => solution,
            Err(KinematicsError::OverTravel { solution, .. }) => *solution,
            Err(e @ KinematicsError::NotFinite { .. }) => {
                return Err(self.fail("control-not-a-number", e.to_string(), "check the tool axis of this block"));
            }
            Err(e) => return Ok(TurnResult { unreachable: Some((pose, e.to_string())), other_position: None }),
        };
        self.take_rotary(q, &turned.q);
        let other = choice.filter(|_| turned.other);
        let other_position = other.map(|(joint, higher, or_other)| self.told_other(joint, higher, or_other));
        Ok(TurnResult { unreachable: None, other_position })
    }

    /// The joint whose angle chooses between two positions of the rotary axes, whether the higher one is
    /// wanted, and whether the control takes the other one instead.
    fn choice(&self, solution: RotarySolution) -> Option<(usize, bool, bool)> {
        let RotarySolution::Angle { higher, reference, or_other } = solution else { return None };
        let named = reference.and_then(|letter| self.machine.joint_for_letter(letter));
        let joint = named.or_else(|| self.machine.rotary_joints().last().copied())?;
        Some((joint, higher, or_other))
    }

    fn told_other(&self, joint: usize, higher: bool, or_other: bool) -> Note {
        let name = self.machine.joints.get(joint).map_or("", |j| j.name.as_str());
        let wanted = if higher { "higher" } else { "lower" };
        let out = format!("the position of the rotary axes with the {wanted} angle of {name} is out of travel");
        if or_other {
            Note::new(format!("{out}: the axes take the other one"))
        } else {
            Note::assuming(format!("{out}: the axes take the other one here, and the control may refuse the block"))
        }
    }

    /// The pole that a tool axis lies in, within rounding.
    fn pole_at(&self, axis: &Vector, q: &JointValues) -> Option<Vector> {
        self.machine.poles(q).find(|p| axis.cross(p).norm() <= AXIS_TOLERANCE && axis.dot(p) > 0.0)
    }

    /// Path of a rapid or straight motion.
    pub(crate) fn straight(&self, motion: &Motion, position: &Position) -> Result<BlockPath, Box<ControlError>> {
        let Some((length, rig)) = self.mapping.tcp_length.zip(self.rig) else {
            let (end, turned) = self.end_in_joints(motion, position)?;
            let mut path = self.line(position.q, end, end);
            (path.unreachable, path.other_position) = (turned.unreachable, turned.other_position);
            path.programmed = Some(Box::new(ProgrammedMotion::joints(position.q, end, None)));
            return Ok(path);
        };
        let (from, to, turned) = self.end_with_tcp(motion, position, rig, length)?;
        let mut path = self.line(from, to, self.joints(rig, &to, length));
        (path.unreachable, path.other_position) = (turned.unreachable, turned.other_position);
        if path.length > 0.0 {
            let tip = |t: f64| lerp_tip(rig, &from, &to, t);
            let tip_length = path.tip_moves.then_some(path.length);
            path = self.oriented(path, motion, rig, (length, [&from, &to]), &tip, tip_length);
        }
        let start = position.told.map_or_else(|| rig.point(&from), |pose| pose.tip.coords);
        let tip = TipWay::line(start, rig.point(&to));
        path.programmed = self.told(motion, position, length, &to, (tip, path.apart));
        Ok(path)
    }

    /// A path with tool center point control with its tool axis on the great circle, where the program wants
    /// it there.
    fn oriented(
        &self,
        path: BlockPath,
        motion: &Motion,
        rig: &Rig,
        (length, [from, to]): (f64, [&JointValues; 2]),
        tip: &dyn Fn(f64) -> JointJet,
        tip_length: Option<f64>,
    ) -> BlockPath {
        if self.orientation != OrientationInterpolation::GreatCircle || path.unreachable.is_some() {
            return path;
        }
        let any_joints = motion.tool_axis_base.is_some();
        let turning = self.great_circle(&AxisTask { rig, length, from, to, any_joints, tip, tip_length });
        path.turned(turning)
    }

    /// What the program says of tip and tool axis with tool center point control; `apart`: they are not run
    /// in step.
    fn told(
        &self,
        motion: &Motion,
        position: &Position,
        length: f64,
        to: &JointValues,
        (tip, apart): (TipWay, bool),
    ) -> Option<Box<ProgrammedMotion>> {
        let axis_of = |q: &JointValues| self.machine.forward(q, length).axis;
        let from = position.told.map_or_else(|| axis_of(&position.q), |pose| pose.axis);
        let axis = match (motion.tool_axis_base, self.orientation) {
            (Some(axis), OrientationInterpolation::GreatCircle) => {
                AxisWay::circle(from, Vector::from(axis).normalize())
            }
            (None, OrientationInterpolation::GreatCircle) => AxisWay::circle(from, axis_of(to)),
            // Positions that do not point the tool along the programmed axis cannot replace it.
            (Some(axis), OrientationInterpolation::Axes)
                if Vector::from(axis).cross(&axis_of(to)).norm() > OFF_AXIS =>
            {
                AxisWay::circle(from, Vector::from(axis).normalize())
            }
            (_, OrientationInterpolation::Axes) => AxisWay::joints(position.q, *to),
        };
        Some(Box::new(ProgrammedMotion::tool(length, tip, axis, !apart)))
    }

    /// Start and end in task coordinates with tool center point control.
    fn end_with_tcp(
        &self,
        motion: &Motion,
        position: &Position,
        rig: &Rig,
        length: f64,
    ) -> Result<(JointValues, JointValues, TurnResult), Box<ControlError>> {
        let from = rig.task(self.machine, &position.q, length);
        let mut to = from;
        let mut tip = Vector::new(from[rig.slots[0]], from[rig.slots[1]], from[rig.slots[2]]);
        for (letter, joint, value) in self.targets(motion, position)? {
            if letter < 3 {
                tip[letter] = value + rig.zero[letter];
            } else {
                to[joint] = self.unless_held(joint, value)?;
            }
        }
        let mut turned = TurnResult::default();
        if let Some(axis) = motion.tool_axis_base {
            turned = self.turn_to((axis, motion.solution), Point::from(tip), length, position, &mut to)?;
        }
        for (k, &slot) in rig.slots.iter().enumerate() {
            to[slot] = tip[k];
        }
        Ok((from, to, turned))
    }

    /// The joints X, Y and Z.
    fn letter_slots(&self, what: &str) -> Result<[usize; 3], Box<ControlError>> {
        let mut slots = [0; 3];
        for (k, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            slots[k] = self.machine.joint_for_letter(letter).ok_or_else(|| {
                let message = format!("machine {} has no joint {letter}, which {what} needs", self.machine.name);
                self.fail("control-axis", message, "name the linear joints of the machine X, Y and Z")
            })?;
        }
        Ok(slots)
    }

    fn take_rotary(&self, to: &mut JointValues, q: &JointValues) {
        for (i, joint) in self.machine.joints.iter().enumerate() {
            if joint.kind == JointKind::Rotary {
                to[i] = q[i];
            }
        }
    }

    fn joints(&self, rig: &Rig, task: &JointValues, length: f64) -> JointValues {
        rig.joints(&JointJet::constant(*task), length).map_or(*task, |j| j.0[0])
    }

    /// Straight way between two positions of the joints.
    pub(crate) fn between(&self, from: JointValues, to: JointValues) -> BlockPath {
        let programmed = Some(Box::new(ProgrammedMotion::joints(from, to, None)));
        BlockPath { programmed, ..self.line(from, to, to) }
    }

    fn line(&self, from: JointValues, to: JointValues, end: JointValues) -> BlockPath {
        let (length, tip_moves) = self.parameter_length(&(to - from));
        let slope = if length > 0.0 { (to - from) * (1.0 / length) } else { JointValues::ZERO };
        BlockPath::whole(BlockShape::Line { from, slope }, length, tip_moves, end)
    }

    /// Length of a straight motion: of the linear coordinates, mm; of the rotary ones, degrees, if
    /// the linear ones do not move.
    fn parameter_length(&self, way: &JointValues) -> (f64, bool) {
        let norm = |kind: JointKind| {
            let joints = self.machine.joints.iter().enumerate().filter(|(_, j)| j.kind == kind);
            joints.map(|(i, _)| way[i] * way[i]).sum::<f64>().sqrt()
        };
        let linear = norm(JointKind::Linear);
        if linear > NO_TIP_MM {
            return (linear, true);
        }
        let turn = norm(JointKind::Rotary).to_degrees();
        (if turn > NO_TURN_DEG { turn } else { 0.0 }, false)
    }

    /// Path of an arc.
    pub(crate) fn arc(&self, arc: &ArcMotion, position: &Position) -> Result<BlockPath, Box<ControlError>> {
        let motion = &arc.motion;
        let center = Vector::from(arc.center_base);
        let normal = Vector::from(arc.normal_base);
        let finite = center.iter().chain(normal.iter()).chain([&arc.sweep]).all(|v| v.is_finite());
        if !finite || arc.sweep <= 0.0 || normal.norm() == 0.0 {
            let message = format!("center {center:?}, normal {normal:?} and sweep {} do not make an arc", arc.sweep);
            return Err(self.fail("control-not-a-number", message, "check the expressions of this block"));
        }
        let normal = normal / normal.norm();
        let tcp = self.mapping.tcp_length.zip(self.rig);
        let (from, to, slots, shift, end, turned) = match tcp {
            Some((length, rig)) => {
                let (from, to, turned) = self.end_with_tcp(motion, position, rig, length)?;
                let end = self.joints(rig, &to, length);
                (from, to, rig.slots, rig.zero, end, turned)
            }
            None => {
                let (end, turned) = self.end_in_joints(motion, position)?;
                let slots = self.letter_slots("an arc")?;
                (position.q, end, slots, self.length_offset(), end, turned)
            }
        };
        let at = |q: &JointValues| Vector::new(q[slots[0]], q[slots[1]], q[slots[2]]);
        let center = center + shift;
        let (a, b) = (at(&from) - center, at(&to) - center);
        let flat = |v: Vector| v - normal * v.dot(&normal);
        let (ra, rb) = (flat(a), flat(b));
        let (r0, r1) = (ra.norm(), rb.norm());
        let mismatch = (r1 - r0).abs();
        if r0 < NO_RADIUS_MM || mismatch > RADIUS_MISMATCH_MM.max(RADIUS_MISMATCH * r0) {
            let message = format!(
                "the arc's radius is {r0:.4} mm at the start and {r1:.4} mm at the end, \
                 more than {RADIUS_MISMATCH_MM} mm and 1 percent apart"
            );
            let help = "check center and end; all axes of the arc's plane must be where the program assumes them (a tool length that was switched on before must have been traversed)";
            return Err(self.fail("control-arc", message, help));
        }
        let u = ra / r0;
        let v = normal.cross(&u);
        // The end decides about the exact angle; the program's angle only about full turns.
        let sweep = proveout_geom::wrap_near(rb.dot(&v).atan2(rb.dot(&u)), arc.sweep);
        if (sweep - arc.sweep).abs() > 0.1 || sweep <= 0.0 {
            let message = format!(
                "the arc's end lies at {:.4} degrees from its start, the program says {:.4}",
                sweep.to_degrees(),
                arc.sweep.to_degrees()
            );
            return Err(self.fail("control-arc", message, "check center, end and plane of the arc"));
        }
        let rise = (b - a).dot(&normal);
        let length = (0.5 * (r0 + r1) * sweep).hypot(rise);
        let center_line = center + normal * a.dot(&normal);
        let mut slope = (to - from) * (1.0 / length);
        let mut start = from;
        for slot in slots {
            slope[slot] = 0.0;
            start[slot] = 0.0;
        }
        let shape = BlockShape::Arc(Box::new(Arc {
            slots,
            center: center_line,
            u,
            v,
            rise: normal * (rise / length),
            radius: r0,
            radius_slope: (r1 - r0) / length,
            omega: sweep / length,
            from: start,
            slope,
        }));
        let start = position.told.filter(|_| tcp.is_some()).map_or_else(|| at(&from), |pose| pose.tip.coords);
        let way = TipWay::arc(start, at(&to), center, normal, arc.sweep);
        let mut path = BlockPath::whole(shape.clone(), length, true, end);
        (path.unreachable, path.other_position) = (turned.unreachable, turned.other_position);
        let Some((tool, rig)) = tcp else {
            path.programmed = Some(Box::new(ProgrammedMotion::joints(from, to, Some((slots, way)))));
            return Ok(path);
        };
        let tip = |t: f64| linear_part(rig, &shape.jet(t * length), length);
        path = self.oriented(path, motion, rig, (tool, [&from, &to]), &tip, Some(length));
        path.programmed = self.told(motion, position, tool, &to, (way, path.apart));
        Ok(path)
    }
}

/// The linear coordinates over t in 0..=1 of a way by its length.
fn linear_part(rig: &Rig, jet: &JointJet, length: f64) -> JointJet {
    JointJet(std::array::from_fn(|k| {
        let mut out = JointValues::ZERO;
        for slot in rig.slots {
            out[slot] = jet.0[k][slot] * length.powi(k as i32);
        }
        out
    }))
}

/// Taylor coefficients over t in 0..=1 of the linear coordinates on a straight way.
fn lerp_tip(rig: &Rig, from: &JointValues, to: &JointValues, t: f64) -> JointJet {
    let mut out = JointJet::constant(JointValues::ZERO);
    for slot in rig.slots {
        out.0[0][slot] = from[slot] * (1.0 - t) + to[slot] * t;
        out.0[1][slot] = to[slot] - from[slot];
    }
    out
}
