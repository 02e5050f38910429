//! Parts, the pairs of them that are checked, and how far a part can move for a given motion of the joints.

use std::sync::Arc;

use proveout_geom::{Point, Pose, TriMesh, Vector};
use proveout_machine::{Attachment, JointValues, MAX_JOINTS, Machine, PairCare, PairRule};
use proveout_tool::{Role, Tool};

use crate::report::{CollisionError, PartKind, Unchecked};
use crate::shape::{MeshShape, PartShape, Revolved, ShapeFault};

/// Travel assumed for a linear joint at first where none is stated, mm to either side; it is widened when
/// left.
const TRAVEL_GUESS_MM: f64 = 500.0;

/// Roles of machine bodies that are there to bear on their neighbor.
pub const BEARING_ROLES: [&str; 2] = ["guide", "bearing"];

/// A fixture, clamp or platform.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixture {
    /// Name, for findings.
    pub name: String,
    /// Mesh in the table frame K (equal to M with all joints at zero), mm; of one that is not closed only the
    /// surface counts.
    pub mesh: TriMesh,
    /// True when it is mounted on the table and moves with it; false when it is on the base.
    pub on_table: bool,
}

/// One part that can hit another.
#[derive(Clone, Debug)]
pub(crate) struct CollisionPart {
    pub(crate) name: Arc<str>,
    pub(crate) kind: PartKind,
    pub(crate) attached: Attachment,
    /// Pose in M with all joints at zero.
    pub(crate) zero_from_local: Pose,
    pub(crate) shape: Arc<PartShape>,
    pub(crate) excluded: bool,
    /// It bears by its role.
    pub(crate) bears: bool,
}

impl CollisionPart {
    pub(crate) fn pose(&self, machine: &Machine, q: &JointValues) -> Pose {
        machine.attachment_pose(self.attached, q) * self.zero_from_local
    }

    /// The name by which a rule of the machine file means it; none for what the machine file does not know.
    fn rule_name(&self) -> Option<&str> {
        match self.kind {
            PartKind::Machine => Some(&self.name),
            PartKind::Cutter => Some("cutter"),
            PartKind::Neck => Some("neck"),
            PartKind::Shank => Some("shank"),
            PartKind::Holder => Some("holder"),
            PartKind::Fixture | PartKind::Stock => None,
        }
    }

    fn is_tool(&self) -> bool {
        !matches!(self.kind, PartKind::Machine | PartKind::Fixture | PartKind::Stock)
    }
}

pub(crate) fn machine_parts(machine: &Machine) -> Result<Vec<CollisionPart>, CollisionError> {
    let part = |b: &proveout_machine::MachineBody| {
        let wanted = if b.check { MeshDemand::Surface } else { MeshDemand::Nothing };
        let shape = PartShape::Mesh(Box::new(mesh_shape("machine body", &b.name, &b.mesh, wanted)?));
        Ok(CollisionPart {
            name: b.name.as_str().into(),
            kind: PartKind::Machine,
            attached: b.attached_to,
            zero_from_local: Pose::identity(),
            shape: Arc::new(shape),
            excluded: !b.check,
            bears: BEARING_ROLES.contains(&b.role.as_str()),
        })
    };
    machine.bodies.iter().map(part).collect()
}

/// What carries the table frame.
pub(crate) fn table_of(machine: &Machine) -> Attachment {
    machine.work_chain.last().map_or(Attachment::Base, |&j| Attachment::Joint(j))
}

pub(crate) fn fixture_part(machine: &Machine, fixture: &Fixture) -> Result<CollisionPart, CollisionError> {
    Ok(CollisionPart {
        name: fixture.name.as_str().into(),
        kind: PartKind::Fixture,
        attached: if fixture.on_table { table_of(machine) } else { Attachment::Base },
        zero_from_local: Pose::identity(),
        shape: Arc::new(PartShape::Mesh(Box::new(mesh_shape(
            "fixture",
            &fixture.name,
            &fixture.mesh,
            MeshDemand::Surface,
        )?))),
        excluded: false,
        bears: false,
    })
}

/// What is asked of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeshDemand {
    /// It is only drawn.
    Nothing,
    /// Its surface; what is inside only where it has an inside.
    Surface,
    /// A solid.
    Solid,
}

pub(crate) fn mesh_shape(
    kind: &'static str,
    name: &str,
    mesh: &TriMesh,
    wanted: MeshDemand,
) -> Result<MeshShape, CollisionError> {
    let made = match wanted {
        MeshDemand::Nothing => {
            // A body that is only drawn may be anything; its place is taken by a block that nothing is
            // checked against.
            let b = proveout_geom::Aabb { min: Point::origin(), max: Point::new(1.0, 1.0, 1.0) };
            MeshShape::new(&proveout_geom::box_mesh(&b))
        }
        MeshDemand::Surface => MeshShape::surface(mesh),
        MeshDemand::Solid => MeshShape::new(mesh),
    };
    made.map_err(|fault| match fault {
        ShapeFault::Solid(fault) => CollisionError::NotSolid { kind, name: name.into(), fault },
        ShapeFault::Tree(fault) => CollisionError::Tree { kind, name: name.into(), fault },
    })
}

/// One part for each role of the tool.
pub(crate) fn tool_parts(machine: &Machine, tool: &Tool) -> Vec<CollisionPart> {
    let roles = [
        (Role::Cutting, PartKind::Cutter, "cutter"),
        (Role::Neck, PartKind::Neck, "neck"),
        (Role::Shank, PartKind::Shank, "shank"),
        (Role::Holder, PartKind::Holder, "holder"),
    ];
    let spindle_from_tip = Pose::from_translation(Vector::new(0.0, 0.0, -tool.gauge_length));
    roles
        .into_iter()
        .filter_map(|(role, kind, word)| {
            let bodies: Vec<_> =
                tool.bodies.iter().filter(|b| b.role == role).map(|b| Revolved::new(&b.profile)).collect();
            (!bodies.is_empty()).then(|| CollisionPart {
                name: format!("{word} of {}", tool.name).into(),
                kind,
                attached: machine.spindle.attached_to,
                zero_from_local: machine.spindle.gauge_pose * spindle_from_tip,
                shape: Arc::new(PartShape::Convex(bodies)),
                excluded: false,
                bears: false,
            })
        })
        .collect()
}

/// Joints from the base to an attachment.
pub(crate) fn chain_to(machine: &Machine, attached: Attachment) -> &[usize] {
    let Attachment::Joint(joint) = attached else { return &[] };
    for chain in [&machine.tool_chain, &machine.work_chain] {
        if let Some(end) = chain.iter().position(|&j| j == joint) {
            return &chain[..=end];
        }
    }
    &[]
}

/// What the machine file wants of two parts on their own.
pub(crate) fn rule_of<'m>(machine: &'m Machine, a: &CollisionPart, b: &CollisionPart) -> Option<&'m PairRule> {
    let (one, other) = (a.rule_name()?, b.rule_name()?);
    machine.pairs.iter().find(|r| r.is_of(one, other))
}

/// Whether a pair is checked, and if not, why. None for two parts of one tool, which are no pair at all.
pub(crate) fn relation(
    machine: &Machine,
    a: &CollisionPart,
    b: &CollisionPart,
    allowed: &[(String, String)],
) -> Option<Option<Unchecked>> {
    if a.is_tool() && b.is_tool() {
        return None;
    }
    let named = |x: &str, y: &str| *a.name == *x && *b.name == *y || *a.name == *y && *b.name == *x;
    if a.excluded || b.excluded {
        return Some(Some(Unchecked::Excluded));
    }
    let (x, y) = (chain_to(machine, a.attached), chain_to(machine, b.attached));
    if x == y {
        return Some(Some(Unchecked::Rigid));
    }
    if allowed.iter().any(|(m, n)| named(m, n)) {
        return Some(Some(Unchecked::Allowed));
    }
    if rule_of(machine, a, b).is_some_and(|r| r.care == PairCare::Unchecked) {
        return Some(Some(Unchecked::PairExcluded));
    }
    let (short, long) = if x.len() < y.len() { (x, y) } else { (y, x) };
    let neighbors = long.len() == short.len() + 1 && long.starts_with(short);
    if neighbors && a.kind == PartKind::Machine && b.kind == PartKind::Machine {
        let platform = long.last().is_some_and(|&j| machine.joints[j].turn_shift.is_some());
        return Some(Some(if platform { Unchecked::Platform } else { Unchecked::Neighbors }));
    }
    Some(None)
}

/// Range of the linear joints for which the motion bounds hold.
#[derive(Clone, Debug)]
pub(crate) struct Envelope {
    low: [f64; MAX_JOINTS],
    high: [f64; MAX_JOINTS],
}

impl Envelope {
    pub(crate) fn new(machine: &Machine) -> Self {
        let mut all = Self { low: [0.0; MAX_JOINTS], high: [0.0; MAX_JOINTS] };
        for (i, joint) in machine.joints.iter().enumerate().filter(|(_, j)| !j.is_rotary()) {
            let [low, high] = joint.travel.unwrap_or([joint.home - TRAVEL_GUESS_MM, joint.home + TRAVEL_GUESS_MM]);
            (all.low[i], all.high[i]) = (low, high);
        }
        all
    }

    /// Widens the range to a position; true when it was outside.
    pub(crate) fn include(&mut self, machine: &Machine, q: &JointValues) -> bool {
        let mut grown = false;
        for (i, _) in machine.joints.iter().enumerate().filter(|(_, j)| !j.is_rotary()) {
            if q[i] < self.low[i] {
                self.low[i] = q[i] - TRAVEL_GUESS_MM;
                grown = true;
            }
            if q[i] > self.high[i] {
                self.high[i] = q[i] + TRAVEL_GUESS_MM;
                grown = true;
            }
        }
        grown
    }
}

/// How far a point of one part moves against the other for a unit of each joint: 1 for a linear joint between
/// them, the farthest distance from the axis (mm) for a rotary one, 0 for a joint that moves both or none.
///
/// Only the joints between them move one part against the other; each contributes at most its own
/// share, whichever the positions of the others (triangle inequality along a path on which one
/// joint moves at a time). For rotary joint j the share is the distance from its axis of the part
/// that it carries. With joints k between j and the part this distance changes, so a ball round the
/// part is carried from the part to j: a rotary k keeps the distance from its axis, so the ball
/// grows to one about the foot of its center on that axis; a linear k shifts the center anywhere in
/// its range.
pub(crate) fn motion_weights(
    machine: &Machine,
    a: &CollisionPart,
    b: &CollisionPart,
    range: &Envelope,
) -> [f64; MAX_JOINTS] {
    let (x, y) = (chain_to(machine, a.attached), chain_to(machine, b.attached));
    let shared = x.iter().zip(y).take_while(|(i, j)| i == j).count();
    let mut weights = [0.0; MAX_JOINTS];
    for (chain, part) in [(&x[shared..], a), (&y[shared..], b)] {
        let (local_center, mut radius) = part.shape.ball();
        let mut center = part.zero_from_local.point(&local_center);
        let local_from_zero = part.zero_from_local.inverse();
        for (depth, &k) in chain.iter().rev().enumerate() {
            let joint = &machine.joints[k];
            if joint.is_rotary() {
                let foot = joint.point + joint.direction * (center - joint.point).dot(&joint.direction);
                let off = (center - foot).norm();
                let mut reach = off + radius;
                if depth == 0 {
                    let (p, d) = (local_from_zero.point(&joint.point), local_from_zero.vector(&joint.direction));
                    reach = reach.min(part.shape.farthest_from_line(&p, &d));
                }
                // A platform shifts sideways with its tilt, by (1 - cos q) times a vector: at most that
                // vector's length for each radian, and twice its length in all.
                let shift = joint.turn_shift.map_or(0.0, |s| s.0.norm());
                weights[k] = reach + shift;
                (center, radius) = (foot, radius + off + 2.0 * shift);
            } else {
                weights[k] = 1.0;
                let (low, high) = (range.low[k], range.high[k]);
                center += joint.direction * (joint.sense * 0.5 * (low + high));
                radius += 0.5 * (high - low);
            }
        }
    }
    weights
}
