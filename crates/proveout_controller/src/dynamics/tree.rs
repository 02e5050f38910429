//! The bodies of a machine lumped to one rigid body a joint.

use nalgebra::Matrix3;
use proveout_geom::{Point, Vector};
use proveout_machine::{Attachment, MAX_JOINTS, Machine, Platform};

/// The rigid bodies that one joint carries, in M with all joints at zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidLink {
    /// Index of the joint in the machine.
    pub(crate) joint: usize,
    /// Index of the carrying link; none for the base.
    pub(crate) parent: Option<usize>,
    pub(crate) rotary: bool,
    /// Unit vector of the physical motion for a growing value.
    pub(crate) axis: Vector,
    /// A point on the axis of a rotary joint.
    pub(crate) point: Point,
    /// kg; zero where no mass is given.
    pub(crate) mass: f64,
    pub(crate) center: Point,
    /// About the center, kg mm².
    pub(crate) inertia: Matrix3<f64>,
}

/// How far the loads of the drives can be trusted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MassReport {
    /// Names of the bodies whose mass, center or inertia was found from their shape.
    pub estimated: Vec<String>,
    /// Why loads of a joint are not known: index of the joint and the reason.
    pub unknown: Vec<(usize, String)>,
}

/// The machine as a tree of rigid bodies, one per joint; parents come before their children.
/// Platforms are not trees: the loads of their joints, of the joints that carry them and of the
/// joints on them are not known.
#[derive(Clone, Debug)]
pub struct RigidTree {
    pub(crate) links: Vec<RigidLink>,
    /// Direction against gravity; none: weights are left out.
    pub(crate) up: Option<Vector>,
    /// True for joints whose loads are known.
    known: [bool; MAX_JOINTS],
    report: MassReport,
}

/// Sum of two bodies, the second given by mass, center and inertia about it (parallel axes: Huygens,
/// Steiner).
fn joined(
    (m1, c1, i1): (f64, Point, Matrix3<f64>),
    (m2, c2, i2): (f64, Point, Matrix3<f64>),
) -> (f64, Point, Matrix3<f64>) {
    let mass = m1 + m2;
    if mass <= 0.0 {
        return (0.0, c1, i1 + i2);
    }
    let center = Point::from((c1.coords * m1 + c2.coords * m2) / mass);
    let moved = |m: f64, c: Point| {
        let d = c - center;
        (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * m
    };
    (mass, center, i1 + i2 + moved(m1, c1) + moved(m2, c2))
}

impl RigidTree {
    /// Lumps the bodies of a machine.
    pub fn new(machine: &Machine) -> Self {
        let count = machine.joints.len().min(MAX_JOINTS);
        // A joint may precede its parent in the file: take joints whose parents are placed until
        // none is left.
        let mut order: Vec<usize> = Vec::with_capacity(count);
        while order.len() < count {
            let ready = |j: &usize| {
                !order.contains(j) && machine.joints[*j].parent.is_none_or(|p| order.contains(&p) || p >= count)
            };
            let Some(next) = (0..count).find(ready) else { break };
            order.push(next);
        }
        let mut report = MassReport::default();
        let mut missing: [Option<String>; MAX_JOINTS] = std::array::from_fn(|_| None);
        let mut links = Vec::with_capacity(order.len());
        for &j in &order {
            let joint = &machine.joints[j];
            let mut sum = (0.0, Point::origin(), Matrix3::zeros());
            let mut bodies = 0;
            for body in machine.bodies.iter().filter(|b| b.attached_to == Attachment::Joint(j)) {
                bodies += 1;
                match body.mass {
                    Some(m) => {
                        sum = joined(sum, (m.mass, m.center, m.inertia));
                        if m.estimated {
                            report.estimated.push(body.name.clone());
                        }
                    }
                    None => missing[j] = Some(format!("body {} has no mass", body.name)),
                }
            }
            let moved_by_legs = |p: &&Platform| p.heave == j || p.tilt == j;
            if let Some(platform) = machine.platforms.iter().find(moved_by_legs) {
                // Its legs close loops, and the tilt brings a sideways motion with it: no tree of screws.
                missing[j] = Some(format!("joint {} is moved by the legs of platform {}", joint.name, platform.name));
            } else if bodies == 0 {
                missing[j] = Some(format!("joint {} carries no body", joint.name));
            }
            let parent = joint.parent.and_then(|p| order.iter().position(|o| *o == p));
            let (mass, center, inertia) = sum;
            let (axis, point) = (joint.direction * joint.sense, joint.point);
            links.push(RigidLink { joint: j, parent, rotary: joint.is_rotary(), axis, point, mass, center, inertia });
        }
        let mut known = [false; MAX_JOINTS];
        for (i, link) in links.iter().enumerate() {
            let carried = (i..links.len()).filter(|&k| ancestor(&links, i, k));
            let reason = carried.filter_map(|k| missing[links[k].joint].clone()).next();
            // What a platform carries moves in a way that the tree does not know.
            let below = (0..i).filter(|&k| ancestor(&links, k, i)).map(|k| links[k].joint);
            let on_platform = |j: usize| machine.platforms.iter().any(|p| p.tilt == j);
            let reason = reason.or_else(|| below.filter(|&j| on_platform(j)).find_map(|j| missing[j].clone()));
            let reason = reason.or_else(|| machine.up.is_none().then(|| "the machine does not state `up`".to_owned()));
            known[link.joint] = reason.is_none();
            if let Some(reason) = reason {
                report.unknown.push((link.joint, reason));
            }
        }
        report.unknown.sort();
        Self { links, up: machine.up, known, report }
    }

    /// What is estimated and what is missing.
    pub fn report(&self) -> &MassReport {
        &self.report
    }

    /// True when every body that the joint carries has a mass and the direction of gravity is known.
    pub fn knows(&self, joint: usize) -> bool {
        self.known.get(joint).copied().unwrap_or(false)
    }
}

/// True if link `k` is `i` or is carried by it.
fn ancestor(links: &[RigidLink], i: usize, mut k: usize) -> bool {
    loop {
        if k == i {
            return true;
        }
        match links[k].parent {
            Some(p) => k = p,
            None => return false,
        }
    }
}
