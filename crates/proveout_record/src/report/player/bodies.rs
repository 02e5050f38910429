//! What moves beside the stock: bodies of the machine, fixtures, tools, parts that came off, the design.

use proveout_geom::Pose;
use proveout_machine::{Attachment, Machine};
use proveout_sim::observer::{LooseMotion, Setup};
use serde_json::{Value, json};

use crate::{
    color::{Rgba, STEEL},
    in_process::{CREASE, tool_pictures::tool_pictures},
    page_encoding::{Shades, pack_mesh},
    picture::Picture,
    report::format::tool_name,
    units::JointUnit,
};

/// Most triangles of all bodies of the machine, of all fixtures, of the design and of a part that came off.
const MACHINE_TRIANGLES: usize = 60_000;
const FIXTURE_TRIANGLES: usize = 30_000;
const DESIGN_TRIANGLES: usize = 60_000;
const LOOSE_TRIANGLES: usize = 5_000;
/// A body keeps as many, however small its share is.
const LEAST_TRIANGLES: usize = 200;
/// Most parts that came off, and places of the way of one.
const MOST_LOOSE: usize = 40;
const MOST_PLACES: usize = 200;

const FIXTURE_COLOR: Rgba = [120, 128, 140, 255];
const LOOSE_COLOR: Rgba = [200, 120, 70, 255];

/// Meshes packed one after the other; each is named by its number.
#[derive(Clone, Debug, Default)]
pub(crate) struct PackedMeshes {
    pub(crate) bytes: Vec<u8>,
    pub(crate) count: usize,
}

impl PackedMeshes {
    /// Number of the mesh; none without triangles.
    fn add(&mut self, picture: &Picture) -> Option<usize> {
        if picture.triangles.is_empty() {
            return None;
        }
        self.bytes.extend(pack_mesh(picture, Shades::Plain, &[]));
        self.count += 1;
        Some(self.count - 1)
    }
}

/// Pictures with at most so many triangles in all, each with its share.
fn fitted(pictures: Vec<Picture>, limit: usize) -> Vec<Picture> {
    let all: usize = pictures.iter().map(|p| p.triangles.len()).sum();
    if all <= limit {
        return pictures;
    }
    let share = |p: &Picture| ((p.triangles.len() as f64 * limit as f64 / all as f64) as usize).max(LEAST_TRIANGLES);
    pictures
        .into_iter()
        .map(|p| {
            let most = share(&p);
            p.reduced(most).0
        })
        .collect()
}

/// Rows of the rotation with the translation at the end of each.
fn rows(pose: &Pose) -> Vec<f64> {
    (0..3).flat_map(|i| (0..3).map(move |j| pose.rotation[(i, j)]).chain([pose.translation[i]])).collect()
}

/// Chains of joints, and what is carried: data of the page's forward kinematics, which is that of
/// [`Machine::attachment_pose`].
pub(crate) fn kinematics(setup: &Setup<'_>, units: &[JointUnit]) -> Value {
    let machine = setup.machine;
    let joint = |(joint, unit): (&proveout_machine::Joint, &JointUnit)| {
        json!({
            "name": unit.name,
            "unit": if unit.rotary { "°" } else { "mm" },
            "rotary": unit.rotary,
            "axis": (joint.direction * joint.sense).as_slice(),
            "point": joint.point.coords.as_slice(),
            "shift": joint.turn_shift.as_ref().map(|s| s.0.as_slice().to_vec()),
        })
    };
    json!({
        "joints": machine.joints.iter().zip(units).map(joint).collect::<Vec<_>>(),
        "tool_chain": machine.tool_chain,
        "work_chain": machine.work_chain,
        "gauge": rows(&machine.spindle.gauge_pose),
        "work": rows(&setup.table_from_work),
    })
}

/// Bodies of the machine with the chain and the place in it at which they hang.
pub(crate) fn machine_bodies(machine: &Machine, meshes: &mut PackedMeshes) -> Vec<Value> {
    let pictures = machine.bodies.iter().map(|b| Picture::creased(&b.mesh, CREASE)).collect();
    let row = |(body, picture): (&proveout_machine::MachineBody, Picture)| {
        let joint = match body.attached_to {
            Attachment::Base => None,
            Attachment::Joint(joint) => Some(joint),
        };
        let mesh = meshes.add(&picture)?;
        Some(json!({ "name": body.name, "joint": joint, "color": body.color[..3], "mesh": mesh }))
    };
    machine.bodies.iter().zip(fitted(pictures, MACHINE_TRIANGLES)).filter_map(row).collect()
}

pub(crate) fn fixtures(setup: &Setup<'_>, meshes: &mut PackedMeshes) -> Vec<Value> {
    let pictures = setup.fixtures.iter().map(|(_, mesh)| Picture::creased(mesh, CREASE)).collect();
    let row = |((name, _), picture): (&(String, proveout_geom::TriMesh), Picture)| {
        Some(json!({ "name": name, "color": FIXTURE_COLOR[..3], "mesh": meshes.add(&picture)? }))
    };
    setup.fixtures.iter().zip(fitted(pictures, FIXTURE_TRIANGLES)).filter_map(row).collect()
}

/// Number of the mesh of the design, where the scene has one.
pub(crate) fn design(setup: &Setup<'_>, meshes: &mut PackedMeshes) -> Option<usize> {
    let part = setup.part?;
    meshes.add(&Picture::creased(part, CREASE).reduced(DESIGN_TRIANGLES).0)
}

/// The tools of the library by their index there; those that were never in the spindle are null.
pub(crate) fn tools(setup: &Setup<'_>, used: &[bool], meshes: &mut PackedMeshes) -> Vec<Value> {
    let row = |(k, tool): (usize, &proveout_tool::Tool)| {
        if !used.get(k).copied().unwrap_or(false) {
            return Value::Null;
        }
        let part = |(name, color, picture): (&'static str, Rgba, Picture)| {
            Some(json!({ "role": name, "color": color[..3], "mesh": meshes.add(&picture)? }))
        };
        let parts: Vec<Value> = tool_pictures(Some(tool)).into_iter().filter_map(part).collect();
        json!({ "name": tool_name(tool.number, &tool.name), "gauge": tool.gauge_length, "parts": parts })
    };
    setup.tools.tools.iter().enumerate().map(row).collect()
}

/// A part that came off the stock, with its way in the table frame.
#[derive(Clone, Debug)]
pub(crate) struct DetachedPart {
    name: String,
    picture: Picture,
    track: Vec<(f64, Pose)>,
    gone: bool,
}

/// Parts that came off, as many as are shown.
#[derive(Clone, Debug, Default)]
pub(crate) struct DetachedParts {
    all: Vec<DetachedPart>,
    pub(crate) left_out: usize,
}

impl DetachedParts {
    pub(crate) fn take(&mut self, loose: &[LooseMotion]) {
        for part in loose {
            if self.all.len() >= MOST_LOOSE {
                self.left_out += 1;
                continue;
            }
            let every = part.track.len().div_ceil(MOST_PLACES).max(1);
            let last = part.track.len().saturating_sub(1);
            let kept = part
                .track
                .iter()
                .enumerate()
                .filter(|(k, (time, pose))| (k % every == 0 || *k == last) && time.is_finite() && pose.is_finite());
            self.all.push(DetachedPart {
                name: part.name.clone(),
                picture: Picture::creased(&part.mesh, CREASE).reduced(LOOSE_TRIANGLES).0,
                track: kept.map(|(_, row)| *row).collect(),
                gone: part.gone,
            });
        }
    }

    pub(crate) fn values(&self, meshes: &mut PackedMeshes) -> Vec<Value> {
        let row = |part: &DetachedPart| {
            let mesh = meshes.add(&part.picture)?;
            let places: Vec<Value> = part
                .track
                .iter()
                .map(|(time, pose)| json!([round(*time), rows(pose).into_iter().map(round).collect::<Vec<_>>()]))
                .collect();
            Some(
                json!({ "name": part.name, "color": LOOSE_COLOR[..3], "mesh": mesh, "track": places, "gone": part.gone }),
            )
        };
        self.all.iter().filter_map(row).collect()
    }
}

/// To a millionth: enough for a picture.
fn round(v: f64) -> f64 {
    (v * 1e6).round() / 1e6
}

/// Half the diagonal of the machine at home, mm: how far the camera must see.
pub(crate) fn reach(machine: &Machine) -> f64 {
    let home = machine.home();
    let mut all = proveout_geom::Aabb::empty();
    for (k, body) in machine.bodies.iter().enumerate() {
        let pose = machine.body_pose(k, &home);
        body.mesh.positions.iter().for_each(|p| all.grow(&pose.point(p)));
    }
    if all.is_empty() { 0.0 } else { 0.5 * all.size().norm() }
}

/// Color of the stock.
pub(crate) fn steel() -> Vec<u8> {
    STEEL[..3].to_vec()
}
