use proveout_geom::{Pose, ToolPose, TriMesh, Vector};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    Attachment, BodyMass, GeometricErrors, Joint, JointValues, MAX_JOINTS, PairRule, Platform, SpindleData, TableData,
    TurnShift, actual::ActualChain, key_lines::KeyLines, kinematic_chain::Chain, solver::Solver,
};

/// A part of the machine for collision checks and pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineBody {
    /// Name, unique in the machine.
    pub name: String,
    /// What it is (`bed`, `column`, `table`, `spindle_nose`), for people and pictures.
    pub role: String,
    /// What moves it.
    pub attached_to: Attachment,
    /// Closed shells in M with all joints at zero, mm.
    pub mesh: TriMesh,
    /// Mass, center and inertia, where they are known.
    pub mass: Option<BodyMass>,
    /// Red, green, blue, alpha.
    pub color: [u8; 4],
    /// False for bodies that are only drawn.
    pub check: bool,
}

/// Way of moving in rapid blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RapidMode {
    /// All joints begin and end together, on a straight line.
    #[default]
    Straight,
    /// Each joint at its own speed, on a tilted plane too whose axes are those of the machine. Elsewhere
    /// under tool center point control the tip keeps its line.
    #[serde(rename = "independent")]
    IndependentJoints,
}

/// Kinematics that the control lets programs switch on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ControlKinematics {
    /// Tool center point control.
    pub tcp: bool,
    /// Tilted working planes.
    pub tilted_plane: bool,
}

/// What the machine's control does and takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Control file of its programs: the name of a built-in one, or a path from the folder of the machine's
    /// file.
    pub file: Option<String>,
    /// Interpolation cycle, s.
    pub cycle_time: f64,
    /// Shortest time for preparing one block, s.
    pub block_time: f64,
    /// Time of a tool change in its position, s.
    pub tool_change_time: f64,
    /// Time for starting or stopping the spindle, s.
    pub spindle_start_time: f64,
    /// Way of moving in rapid blocks.
    pub rapid_mode: RapidMode,
    /// Kinematics that programs may switch on; `None` where not stated.
    pub kinematics: Option<ControlKinematics>,
    /// Path tolerance where the program states none, mm.
    pub default_tolerance: f64,
    /// Tolerance of the tool orientation where the program states none, radian.
    pub default_orientation_tolerance: Option<f64>,
    /// Cone about a pole of the rotary axes, radian: a great circle of the tool axis that passes the pole
    /// nearer than this is led through it, and left by no more than this.
    pub pole_cone: f64,
    /// Position of each joint for a tool change; `None` where the joint stays.
    pub tool_change_position: [Option<f64>; MAX_JOINTS],
}

/// Where a number of a machine file comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trust {
    /// Path of the key, `joint.Z.max_jerk_mm_s3`; ends in `*` where the note covers all other keys of its
    /// table.
    pub key: String,
    /// Its name in the table, `max_jerk_mm_s3`, or `*`.
    pub name: String,
    /// True for a number that somebody chose because none is published.
    pub chosen: bool,
    /// Source, or the reason of the choice.
    pub note: String,
}

/// A machine: two chains of joints, the bodies on them, limits, spindle and control.
///
/// Frames: M machine, fixed to the base; K table, equal to M with all joints at zero and carried by the last
/// work joint; S spindle at the gauge line. The geometry of the joints is compiled when the machine is made:
/// limits may be changed in place, while a change of directions, points or chains needs
/// [`Machine::recompiled`].
///
/// ```
/// use proveout_machine::Machine;
///
/// // The folder as seen from this crate.
/// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
/// let [z, b] = ["Z", "B"].map(|name| machine.joint(name).expect("a joint of this machine"));
/// assert_eq!(machine.home()[z], 610.0); // mm
/// assert_eq!(machine.joint_for_letter('b'), Some(b));
/// assert!(machine.joints[b].is_rotary() && !machine.joints[z].is_rotary());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Machine {
    /// Name.
    pub name: String,
    /// Words for people.
    pub description: String,
    /// All joints, in the order of the file; the index is the place in [`JointValues`].
    pub joints: Vec<Joint>,
    /// Direction against gravity in M, a unit vector; `None` where not stated.
    pub up: Option<Vector>,
    /// Joints from the base to the spindle.
    pub tool_chain: Vec<usize>,
    /// Joints from the base to the table.
    pub work_chain: Vec<usize>,
    /// Parallel sub-chains.
    pub platforms: Vec<Platform>,
    /// Errors by which the actual machine differs from this one; see [`Machine::actual_forward`].
    pub errors: GeometricErrors,
    /// Parts.
    pub bodies: Vec<MachineBody>,
    /// Pairs of bodies with a rule of their own.
    pub pairs: Vec<PairRule>,
    /// Control.
    pub control: Control,
    /// Spindle.
    pub spindle: SpindleData,
    /// Table.
    pub table: TableData,
    /// Source of the numbers.
    pub trust: Vec<Trust>,
    /// Nodes with meshes of the model file that no body uses.
    pub unused_nodes: Vec<String>,
    pub(crate) chain: Chain,
    pub(crate) solver: Solver,
    /// Compiled errors; `None` when there are none or all are zero.
    pub(crate) actual: Option<ActualChain>,
    pub(crate) places: KeyLines,
}

impl Machine {
    /// Index of a joint by its name.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// Index of the joint whose name is one letter, as an NC program addresses it; upper or lower case.
    pub fn joint_for_letter(&self, letter: char) -> Option<usize> {
        self.joints.iter().position(|j| {
            let mut chars = j.name.chars();
            chars.next().is_some_and(|c| c.eq_ignore_ascii_case(&letter)) && chars.next().is_none()
        })
    }

    /// Home position of every joint.
    pub fn home(&self) -> JointValues {
        let mut q = JointValues::ZERO;
        for (i, joint) in self.joints.iter().enumerate() {
            q[i] = joint.home;
        }
        q
    }

    /// Tip and axis in the table frame K, of a tool whose tip is `tool_length` (mm) in front of the gauge
    /// line.
    ///
    /// ```
    /// use proveout_geom::{Point, Vector};
    /// use proveout_machine::Machine;
    ///
    /// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// // At home the gauge line stands at X-365 Y224 Z610; a tool of 120 mm hangs below it.
    /// let pose = machine.forward(&machine.home(), 120.0);
    /// assert!((pose.tip - Point::new(-365.0, 224.0, 490.0)).norm() < 1e-9); // mm
    /// assert!((pose.axis - Vector::z()).norm() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forward(&self, q: &JointValues, tool_length: f64) -> ToolPose {
        self.chain.forward(q, tool_length)
    }

    /// Pose of the table frame K in M.
    pub fn machine_from_table(&self, q: &JointValues) -> Pose {
        self.chain_pose(&self.work_chain, q)
    }

    /// Pose of the gauge line S in M.
    pub fn machine_from_spindle(&self, q: &JointValues) -> Pose {
        self.chain_pose(&self.tool_chain, q) * self.spindle.gauge_pose
    }

    /// Pose of the gauge line S in the table frame K.
    pub fn table_from_spindle(&self, q: &JointValues) -> Pose {
        let links = self.chain.links.iter();
        links.fold(Pose::identity(), |p, l| p * l.pose(q[l.joint])) * self.spindle.gauge_pose
    }

    /// Motion of everything that each joint carries, `M at q` from `M at zero`, in the order of the joints.
    pub fn joint_poses(&self, q: &JointValues) -> [Pose; MAX_JOINTS] {
        let mut poses = [Pose::identity(); MAX_JOINTS];
        for chain in [&self.tool_chain, &self.work_chain] {
            let mut pose = Pose::identity();
            for &j in chain {
                pose = pose * self.joints[j].motion(q[j]);
                poses[j] = pose;
            }
        }
        poses
    }

    /// Pose of an attachment: applied to coordinates in M with all joints at zero.
    pub fn attachment_pose(&self, attachment: Attachment, q: &JointValues) -> Pose {
        let Attachment::Joint(joint) = attachment else { return Pose::identity() };
        for chain in [&self.tool_chain, &self.work_chain] {
            if let Some(end) = chain.iter().position(|&j| j == joint) {
                return self.chain_pose(&chain[..=end], q);
            }
        }
        Pose::identity()
    }

    /// Pose of a body, to be applied to its mesh. An index without a body gives the identity.
    pub fn body_pose(&self, body: usize, q: &JointValues) -> Pose {
        let attachment = self.bodies.get(body).map_or(Attachment::Base, |b| b.attached_to);
        self.attachment_pose(attachment, q)
    }

    fn chain_pose(&self, chain: &[usize], q: &JointValues) -> Pose {
        chain.iter().fold(Pose::identity(), |pose, &j| pose * self.joints[j].motion(q[j]))
    }

    /// The machine with its kinematics recompiled from joints, chains and spindle, after a change of these,
    /// of the platforms or of the errors.
    #[must_use]
    pub fn recompiled(mut self) -> Self {
        for platform in &self.platforms {
            let shift = TurnShift(platform.leg_1_direction * (0.5 * platform.moving_radius));
            if let Some(tilt) = self.joints.get_mut(platform.tilt) {
                tilt.turn_shift = Some(shift);
            }
        }
        self.chain = Chain::new(&self.joints, &self.tool_chain, &self.work_chain, self.spindle.gauge_pose);
        self.solver = Solver::new(&self.chain, &self.joints);
        self.actual = ActualChain::new(&self);
        self
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Point, rad};

    use super::*;
    use crate::testing::u5;

    #[test]
    fn joints_are_found_by_letter_and_name() {
        let machine = u5();
        assert_eq!(machine.joint("B"), machine.joint_for_letter('b'));
        assert_eq!((machine.joint("Q"), machine.joint_for_letter('Q')), (None, None));
        assert_eq!(machine.home()[machine.joint("Z").expect("Z")], 610.0);
    }

    #[test]
    fn bodies_move_with_their_joints() {
        let machine = u5();
        let mut q = machine.home();
        q[machine.joint("B").expect("B")] = rad(90.0);
        let poses = machine.joint_poses(&q);
        for (i, body) in machine.bodies.iter().enumerate() {
            let by_joint = match body.attached_to {
                Attachment::Base => Pose::identity(),
                Attachment::Joint(j) => poses[j],
            };
            assert_eq!(machine.body_pose(i, &q), by_joint, "{}", body.name);
        }
        // The table top turns about the line at z = 120 and is then upright at x = 120, facing -x.
        let table = machine.bodies.iter().position(|b| b.name == "table").expect("table");
        let top = machine.body_pose(table, &q).point(&machine.table.point);
        assert_eq!(top, Point::new(120.0, 0.0, 120.0));
        assert_eq!(machine.body_pose(table, &q).vector(&machine.table.normal), -Vector::x());
        assert_eq!(machine.body_pose(999, &q), Pose::identity());
    }

    #[test]
    fn changed_geometry_counts_after_recompiling() {
        let mut machine = u5();
        let c = machine.joint("C").expect("C");
        machine.joints[c].point = Point::new(7.0, 0.0, 0.0);
        let machine = machine.recompiled();
        let mut q = JointValues::ZERO;
        q[c] = rad(180.0);
        assert!((machine.forward(&q, 0.0).tip - Point::new(14.0, 0.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn every_chosen_number_says_why() {
        let machine = u5();
        let jerk = machine.trust.iter().find(|t| t.key == "joint.X.max_jerk_mm_s3").expect("note");
        assert!(jerk.chosen && !jerk.note.is_empty());
        assert!(machine.trust.iter().any(|t| !t.chosen && t.key == "joint.Z.home_mm"));
    }
}
