//! The elements of a URDF file as written, lengths in mm.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Matrix3;
use proveout_geom::{Pose, Vector};
use proveout_input::InputError;
use roxmltree::Node;

use super::{
    source::{METER_MM, Place, UrdfSource, place, shown},
    xml,
};

/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-12;
/// Least size of a shape, mm. A nanometer: below it, rounding would leave nothing.
const LEAST_MM: f64 = 1e-6;

/// A description of a robot.
pub(super) struct Robot {
    pub(super) name: String,
    pub(super) links: Vec<UrdfLink>,
    pub(super) joints: Vec<UrdfJoint>,
    /// Angles that were taken for right ones.
    squared: usize,
    /// Elements that are not read, how often.
    left_out: BTreeMap<String, usize>,
}

pub(super) struct UrdfLink {
    pub(super) name: String,
    pub(super) place: Place,
    pub(super) shapes: Vec<UrdfShape>,
    pub(super) inertia: Option<Inertia>,
}

/// A shape of a link.
pub(super) struct UrdfShape {
    pub(super) link_from_shape: Pose,
    pub(super) form: UrdfGeometry,
    pub(super) place: Place,
}

pub(super) enum UrdfGeometry {
    /// Edges along x, y, z; the middle is the origin.
    Box(Vector),
    /// About z, the middle is the origin.
    Cylinder { radius: f64, length: f64 },
    /// Radius.
    Sphere(f64),
    /// File as named, and the factor that makes its coordinates millimeters.
    Mesh { file: String, scale: Vector },
    /// An element of another kind.
    Other(String),
}

/// Mass of a link.
pub(super) struct Inertia {
    pub(super) mass_kg: f64,
    /// Pose of the center in the link.
    pub(super) link_from_center: Pose,
    /// About the center, kg m², where it is stated.
    pub(super) tensor: Option<Matrix3<f64>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum UrdfJointKind {
    Fixed,
    Prismatic,
    Revolute,
    Continuous,
}

pub(super) struct UrdfJoint {
    pub(super) name: String,
    pub(super) place: Place,
    pub(super) kind: UrdfJointKind,
    pub(super) parent: String,
    pub(super) child: String,
    /// Pose of the child in the parent with the joint at zero.
    pub(super) parent_from_child: Pose,
    /// Unit vector in the frame of the child.
    pub(super) axis: Vector,
    /// Lowest and highest value, mm or radian; none where the file does not say.
    pub(super) travel: Option<[f64; 2]>,
    /// mm/s or radian/s; none where the file does not say.
    pub(super) velocity: Option<f64>,
    /// Of `<limit>`, else of the joint.
    pub(super) limit_place: Place,
}

/// Reads the text.
pub(super) fn robot(source: &UrdfSource<'_>) -> Result<Robot, InputError> {
    let document = xml::document(source)?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let message =
            format!("the first element is <{}>, and a URDF file begins with <robot>", short(root.tag_name().name()));
        return Err(source.at(&place(root), message, "name a URDF file"));
    }
    let name = root.attribute("name").map(str::trim).filter(|n| !n.is_empty()).map_or_else(
        || source.file.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        |n| n.chars().filter(|c| !c.is_control()).take(200).collect(),
    );
    let mut robot = Robot { name, links: Vec::new(), joints: Vec::new(), squared: 0, left_out: BTreeMap::new() };
    for node in elements(source, root)? {
        match node.tag_name().name() {
            "link" => {
                let link = robot.link(source, node)?;
                robot.links.push(link);
            }
            "joint" => {
                let joint = robot.joint(source, node)?;
                robot.joints.push(joint);
            }
            other => robot.leave_out(other),
        }
    }
    unique(source, "link", robot.links.iter().map(|l| (l.name.as_str(), &l.place)))?;
    unique(source, "joint", robot.joints.iter().map(|j| (j.name.as_str(), &j.place)))?;
    if robot.links.is_empty() {
        return Err(source.at(&place(root), "the robot has no link", "name a URDF file with links and joints"));
    }
    Ok(robot)
}

fn short(name: &str) -> String {
    name.chars().take(60).collect()
}

fn unique<'n>(
    source: &UrdfSource<'_>,
    what: &str,
    names: impl Iterator<Item = (&'n str, &'n Place)>,
) -> Result<(), InputError> {
    let mut seen = BTreeSet::new();
    for (name, place) in names {
        if !seen.insert(name) {
            let message = format!("two {what}s have the name {}", shown(name));
            return Err(source.at(place, message, format!("give each {what} its own name")));
        }
    }
    Ok(())
}

/// Elements below one; macros are refused.
fn elements<'a, 'i>(source: &UrdfSource<'_>, node: Node<'a, 'i>) -> Result<Vec<Node<'a, 'i>>, InputError> {
    let all: Vec<Node<'a, 'i>> = node.children().filter(Node::is_element).collect();
    let is_macro = |n: &&Node<'a, 'i>| n.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"));
    match all.iter().find(is_macro) {
        None => Ok(all),
        Some(n) => {
            let message = format!("<xacro:{}> is a macro of xacro", short(n.tag_name().name()));
            Err(source.at(&place(*n), message, "expand the file with xacro first, and name the result"))
        }
    }
}

/// The one element of a name below another.
fn only<'a, 'i>(source: &UrdfSource<'_>, all: &[Node<'a, 'i>], name: &str) -> Result<Option<Node<'a, 'i>>, InputError> {
    let mut found = all.iter().filter(|n| n.tag_name().name() == name);
    let first = found.next().copied();
    match found.next() {
        None => Ok(first),
        Some(second) => Err(source.at(&place(*second), format!("<{name}> appears twice"), "keep one of the two")),
    }
}

/// Name of a link or joint.
fn name_of(source: &UrdfSource<'_>, node: Node<'_, '_>) -> Result<String, InputError> {
    named(source, node, "name")
}

fn named(source: &UrdfSource<'_>, node: Node<'_, '_>, key: &str) -> Result<String, InputError> {
    let tag = node.tag_name().name();
    match node.attribute(key).map(str::trim) {
        Some(name) if !name.is_empty() && !name.chars().any(char::is_control) => Ok(name.to_owned()),
        Some(name) => Err(source.at(
            &place(node),
            format!("{key} = {} of <{tag}> is not a valid name", shown(name)),
            "write a name",
        )),
        None => Err(source.at(&place(node), format!("<{tag}> has no {key}"), format!("add {key} = \"...\""))),
    }
}

impl Robot {
    fn leave_out(&mut self, name: &str) {
        *self.left_out.entry(short(name)).or_default() += 1;
    }

    /// Reports what is in the file and not in the machine.
    pub(super) fn note_left_out(&self, notes: &mut Vec<String>) {
        if self.squared > 0 {
            notes.push(format!(
                "angles whose digits are those of a right angle (1.5708, 3.14) are taken as right angles: {}",
                self.squared
            ));
        }
        if !self.left_out.is_empty() {
            let names: Vec<String> = self.left_out.iter().map(|(name, n)| format!("{name} ({n})")).collect();
            let more = if names.len() > 12 { format!(" and {} more", names.len() - 12) } else { String::new() };
            notes.push(format!("not taken: {}{more}", names.get(..12).unwrap_or(&names).join(", ")));
        }
    }

    /// Pose of `<origin>`; none is the identity.
    fn origin(&mut self, source: &UrdfSource<'_>, all: &[Node<'_, '_>]) -> Result<Pose, InputError> {
        let Some(node) = only(source, all, "origin")? else { return Ok(Pose::identity()) };
        let place = source.lengths::<3>(node, "xyz")?.unwrap_or_default();
        let [roll, pitch, yaw] = source.angles(node, &mut self.squared)?.unwrap_or_default();
        Ok(Pose::from_rpy(Vector::from(place), roll, pitch, yaw))
    }

    fn joint(&mut self, source: &UrdfSource<'_>, node: Node<'_, '_>) -> Result<UrdfJoint, InputError> {
        let name = name_of(source, node)?;
        let all = elements(source, node)?;
        let fault = |message: String, remedy: &str| Err(source.at(&place(node), message, remedy));
        let kind = match node.attribute("type").unwrap_or_default() {
            "fixed" => UrdfJointKind::Fixed,
            "prismatic" => UrdfJointKind::Prismatic,
            "revolute" => UrdfJointKind::Revolute,
            "continuous" => UrdfJointKind::Continuous,
            other => {
                let message = format!("joint {} is of type {}", shown(&name), shown(other));
                return fault(message, "a machine has fixed, prismatic, revolute and continuous joints");
            }
        };
        if only(source, &all, "mimic")?.is_some() {
            let message = format!("joint {} moves with another one (<mimic>)", shown(&name));
            return fault(message, "write it as a fixed joint, or leave it out with the links that it carries");
        }
        let of = |tag: &str| match only(source, &all, tag)? {
            Some(n) => named(source, n, "link"),
            None => Err(source.at(
                &place(node),
                format!("joint {} has no <{tag}>", shown(&name)),
                format!("add <{tag} link=\"...\"/>"),
            )),
        };
        let (parent, child) = (of("parent")?, of("child")?);
        let parent_from_child = self.origin(source, &all)?;
        let mut axis = Vector::x();
        if let Some(n) = only(source, &all, "axis")?
            && let Some(given) = source.numbers::<3>(n, "xyz")?
        {
            // The largest of them first, so that neither a tiny nor a huge one leaves the range of the
            // numbers.
            let given = Vector::from(given);
            match (given / given.amax()).try_normalize(SHORTEST).filter(|v| v.iter().all(|x| x.is_finite())) {
                Some(v) => axis = v,
                None if kind == UrdfJointKind::Fixed => {}
                None => {
                    let message = format!("the axis of joint {} has no direction", shown(&name));
                    return Err(source.at(&place(n), message, "write a vector that is not zero"));
                }
            }
        }
        let limit = only(source, &all, "limit")?;
        let (mut travel, mut velocity) = (None, None);
        if let Some(n) = limit {
            travel = Self::travel(source, n, kind)?;
            velocity = source.numbers::<1>(n, "velocity")?.map(|[v]| v);
            if velocity.is_some_and(|v| v < 0.0) {
                return Err(source.at(&place(n), "the velocity is below zero", "write the highest one, above zero"));
            }
            source.numbers::<1>(n, "effort")?;
        }
        for n in &all {
            if !["origin", "parent", "child", "axis", "limit"].contains(&n.tag_name().name()) {
                self.leave_out(n.tag_name().name());
            }
        }
        if limit.is_some_and(|n| n.has_attribute("effort")) && kind != UrdfJointKind::Fixed {
            self.leave_out("effort");
        }
        let scale = if kind == UrdfJointKind::Prismatic { METER_MM } else { 1.0 };
        Ok(UrdfJoint {
            place: place(node),
            limit_place: limit.map_or_else(|| place(node), place),
            // Many files give zero for a velocity that is not known.
            velocity: velocity.filter(|v| *v > 0.0).map(|v| v * scale),
            name,
            kind,
            parent,
            child,
            parent_from_child,
            axis,
            travel,
        })
    }

    /// Ends of travel, mm or radian. If only one end is given, the other is zero, as the format defines.
    fn travel(source: &UrdfSource<'_>, n: Node<'_, '_>, kind: UrdfJointKind) -> Result<Option<[f64; 2]>, InputError> {
        let [lower, upper] = if kind == UrdfJointKind::Prismatic {
            [source.lengths::<1>(n, "lower")?, source.lengths::<1>(n, "upper")?]
        } else {
            [source.numbers::<1>(n, "lower")?, source.numbers::<1>(n, "upper")?]
        };
        if (lower.is_none() && upper.is_none()) || matches!(kind, UrdfJointKind::Fixed | UrdfJointKind::Continuous) {
            return Ok(None);
        }
        let [[low], [high]] = [lower, upper].map(Option::unwrap_or_default);
        if low >= high {
            let given = |key| n.attribute(key).unwrap_or("0");
            let message = format!("lower = {} is not below upper = {}", shown(given("lower")), shown(given("upper")));
            return Err(source.at(
                &place(n),
                message,
                "write the lower end as lower; a joint that does not move is fixed",
            ));
        }
        Ok(Some([low, high]))
    }

    fn link(&mut self, source: &UrdfSource<'_>, node: Node<'_, '_>) -> Result<UrdfLink, InputError> {
        let name = name_of(source, node)?;
        let all = elements(source, node)?;
        // What is checked for collisions, and only where nothing is, what is drawn.
        let of = |tag: &str| all.iter().filter(|n| n.tag_name().name() == tag).copied().collect::<Vec<_>>();
        let drawn = Some(of("collision")).filter(|c| !c.is_empty()).unwrap_or_else(|| of("visual"));
        let mut shapes = Vec::new();
        for n in drawn {
            let below = elements(source, n)?;
            let link_from_shape = self.origin(source, &below)?;
            let Some(geometry) = only(source, &below, "geometry")? else { continue };
            for form in elements(source, geometry)? {
                shapes.push(UrdfShape { link_from_shape, form: Self::form(source, form)?, place: place(form) });
            }
        }
        let mut inertia = None;
        if let Some(n) = only(source, &all, "inertial")? {
            inertia = self.inertia(source, n)?;
        }
        for n in &all {
            if !["collision", "visual", "inertial"].contains(&n.tag_name().name()) {
                self.leave_out(n.tag_name().name());
            }
        }
        Ok(UrdfLink { name, place: place(node), shapes, inertia })
    }

    fn inertia(&mut self, source: &UrdfSource<'_>, node: Node<'_, '_>) -> Result<Option<Inertia>, InputError> {
        let all = elements(source, node)?;
        let link_from_center = self.origin(source, &all)?;
        let mass = match only(source, &all, "mass")? {
            Some(n) => source.numbers::<1>(n, "value")?,
            None => None,
        };
        let tensor = match only(source, &all, "inertia")? {
            None => None,
            Some(n) => {
                let of = |key: &str| source.numbers::<1>(n, key).map(|v| v.map_or(0.0, |[v]| v));
                let [xx, yy, zz, xy, yz, xz] = [of("ixx")?, of("iyy")?, of("izz")?, of("ixy")?, of("iyz")?, of("ixz")?];
                Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
            }
        };
        Ok(mass.map(|[mass_kg]| Inertia { mass_kg, link_from_center, tensor }))
    }

    fn form(source: &UrdfSource<'_>, node: Node<'_, '_>) -> Result<UrdfGeometry, InputError> {
        let tag = node.tag_name().name();
        let missing =
            |key: &str| source.at(&place(node), format!("<{tag}> has no {key}"), format!("add {key} = \"...\""));
        let length = |key: &str| source.lengths::<1>(node, key)?.map(|[v]| v).ok_or_else(|| missing(key));
        let form = match tag {
            "box" => {
                UrdfGeometry::Box(Vector::from(source.lengths::<3>(node, "size")?.ok_or_else(|| missing("size"))?))
            }
            "cylinder" => UrdfGeometry::Cylinder { radius: length("radius")?, length: length("length")? },
            "sphere" => UrdfGeometry::Sphere(length("radius")?),
            "mesh" => {
                let file = node.attribute("filename").map(str::trim).filter(|f| !f.is_empty());
                let scale = source.numbers::<3>(node, "scale")?.unwrap_or([1.0; 3]);
                if scale.contains(&0.0) {
                    return Err(source.at(&place(node), "the scale of a mesh is zero", "write 1 1 1, or leave it out"));
                }
                UrdfGeometry::Mesh {
                    file: file.ok_or_else(|| missing("filename"))?.to_owned(),
                    scale: Vector::from(scale) * METER_MM,
                }
            }
            other => UrdfGeometry::Other(short(other)),
        };
        let least = match &form {
            UrdfGeometry::Box(size) => size.min(),
            UrdfGeometry::Cylinder { radius, length } => radius.min(*length),
            UrdfGeometry::Sphere(radius) => *radius,
            UrdfGeometry::Mesh { .. } | UrdfGeometry::Other(_) => 1.0,
        };
        if least < LEAST_MM {
            let message = format!("<{tag}> measures {least} mm");
            return Err(source.at(&place(node), message, "write meters above zero, or leave the shape out"));
        }
        Ok(form)
    }
}
