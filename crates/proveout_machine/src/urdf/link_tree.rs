//! The links and joints of a URDF as one tree, and their poses with all joints at zero.

use std::collections::BTreeMap;

use proveout_geom::Pose;
use proveout_input::InputError;

use super::{
    read::{Robot, UrdfJointKind},
    source::{UrdfSource, listed, shown},
};

/// Links and joints by index.
pub(super) struct LinkTree {
    /// Joint that carries each link; none for the root.
    pub(super) carrier: Vec<Option<usize>>,
    /// Link that carries each joint.
    pub(super) parent: Vec<usize>,
    /// Link that each joint carries.
    pub(super) child: Vec<usize>,
    /// Links, each after the one that carries it.
    pub(super) order: Vec<usize>,
    /// `machine_from_link` with all joints at zero; M is the frame of the root.
    pub(super) poses: Vec<Pose>,
}

impl LinkTree {
    /// Binds the names, and refuses what is no tree.
    pub(super) fn new(source: &UrdfSource<'_>, robot: &Robot) -> Result<Self, InputError> {
        let index: BTreeMap<&str, usize> = robot.links.iter().enumerate().map(|(i, l)| (l.name.as_str(), i)).collect();
        let mut carrier: Vec<Option<usize>> = vec![None; robot.links.len()];
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
        let (mut parent, mut child) = (Vec::new(), Vec::new());
        for (j, joint) in robot.joints.iter().enumerate() {
            let find = |word: &str, name: &str| {
                index.get(name).copied().ok_or_else(|| {
                    let message = format!("the {word} {} of joint {} is not a link", shown(name), shown(&joint.name));
                    source.at(&joint.place, message, "name a link of the file, or add it")
                })
            };
            let (up, down) = (find("parent", &joint.parent)?, find("child", &joint.child)?);
            if let Some(first) = carrier[down] {
                let other = robot.joints.get(first).map_or("", |o| o.name.as_str());
                let message = format!(
                    "link {} is the child of two joints, {} and {}: links must form a tree",
                    shown(&joint.child),
                    shown(other),
                    shown(&joint.name)
                );
                return Err(source.at(&joint.place, message, "leave one of the two joints out"));
            }
            carrier[down] = Some(j);
            below[up].push(j);
            parent.push(up);
            child.push(down);
        }
        let roots: Vec<usize> = (0..carrier.len()).filter(|&l| carrier[l].is_none()).collect();
        let mut order = match roots[..] {
            [root] => vec![root],
            [] => return Err(Self::a_loop(source, robot, 0)),
            [_, second, ..] => {
                let names = listed(roots.iter().map(|&l| robot.links[l].name.as_str()));
                let message = format!("{} links have no parent joint: {names}", roots.len());
                return Err(source.at(&robot.links[second].place, message, "bind all but one by a joint"));
            }
        };
        let mut poses = vec![Pose::identity(); robot.links.len()];
        let mut next = 0;
        while let Some(&link) = order.get(next) {
            next += 1;
            for &j in &below[link] {
                poses[child[j]] = poses[link] * robot.joints[j].parent_from_child;
                order.push(child[j]);
            }
        }
        if order.len() < robot.links.len() {
            let mut reached = vec![false; robot.links.len()];
            order.iter().for_each(|&l| reached[l] = true);
            let lost = reached.iter().position(|r| !r).and_then(|l| carrier[l]);
            return Err(Self::a_loop(source, robot, lost.unwrap_or(0)));
        }
        Ok(Self { carrier, parent, child, order, poses })
    }

    fn a_loop(source: &UrdfSource<'_>, robot: &Robot, joint: usize) -> InputError {
        match robot.joints.get(joint) {
            Some(j) => {
                let message = format!("joint {} is its own ancestor: the joints form a loop", shown(&j.name));
                source.at(&j.place, message, "leave one link of the loop without a parent joint")
            }
            None => source.whole("the robot has no root", "name a URDF file with links and joints"),
        }
    }

    /// Joints from the root to a link.
    pub(super) fn way_to(&self, link: usize) -> Vec<usize> {
        let mut way = Vec::new();
        let mut at = link;
        while let Some(j) = self.carrier[at] {
            way.push(j);
            at = self.parent[j];
        }
        way.reverse();
        way
    }

    /// Names of the links on which no other hangs.
    pub(super) fn leaves<'r>(&self, robot: &'r Robot) -> Vec<&'r str> {
        let mut carries = vec![false; robot.links.len()];
        self.parent.iter().for_each(|&l| carries[l] = true);
        robot.links.iter().zip(carries).filter(|(_, c)| !c).map(|(l, _)| l.name.as_str()).collect()
    }

    /// The joints that move, of a way.
    pub(super) fn moving(robot: &Robot, way: &[usize]) -> Vec<usize> {
        way.iter().copied().filter(|&j| robot.joints[j].kind != UrdfJointKind::Fixed).collect()
    }
}
