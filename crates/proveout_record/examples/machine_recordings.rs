//! Writes one recording for each machine of `machines/`, at home at 0 s and in a working pose at 1 s, with a
//! block of stock on its table: `machine_recordings FOLDER [MACHINE...]`. The pictures of
//! `docs/pictures/machines.png` are made from them.
//!
//! Working poses come from `machines/poses.csv`; slides that it does not name are in the middle of their
//! travel, rotary joints at zero.
#![allow(clippy::print_stdout, reason = "a command line prints")]

#[allow(dead_code, reason = "only the verdict of the synthetic run is used")]
#[path = "../tests/support/mod.rs"]
mod support;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use proveout_controller::{MoveKind, Sample};
use proveout_geom::{Aabb, Point, Pose, Vector, rad};
use proveout_machine::{JointValues, Machine};
use proveout_record::{RerunMode, observers};
use proveout_sim::{
    SurfaceShape,
    observer::{Batch, ClearanceProof, Outcome, SampleSignals, Setup},
    scene::Scene,
};
use proveout_stock::TriDexel;
use proveout_tool::ToolLibrary;

type Fault = Box<dyn std::error::Error>;

fn main() -> Result<(), Fault> {
    let mut args = std::env::args().skip(1);
    let out = PathBuf::from(args.next().ok_or("give a folder for the recordings")?);
    let wanted: Vec<String> = args.collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (name, pose) in poses(&root)? {
        if wanted.is_empty() || wanted.contains(&name) {
            let folder = out.join(&name);
            std::fs::create_dir_all(&folder)?;
            record(&root, &name, &pose, &folder)?;
            println!("{}", folder.join("recording.rrd").display());
        }
    }
    Ok(())
}

/// Joints and positions (mm or degrees) of each machine.
fn poses(root: &Path) -> Result<BTreeMap<String, Vec<(String, f64)>>, Fault> {
    let mut all: BTreeMap<String, Vec<(String, f64)>> = BTreeMap::new();
    for line in std::fs::read_to_string(root.join("machines/poses.csv"))?.lines().skip(1) {
        let [machine, joint, position, _unit] = line.split(',').collect::<Vec<_>>()[..] else {
            return Err(format!("machines/poses.csv: four columns are expected: {line}").into());
        };
        all.entry(machine.to_owned()).or_default().push((joint.to_owned(), position.parse()?));
    }
    Ok(all)
}

/// The middle of all travels, with the positions given.
fn position(machine: &Machine, pose: &[(String, f64)]) -> Result<JointValues, Fault> {
    let mut q = machine.home();
    for (j, joint) in machine.joints.iter().enumerate().filter(|(_, j)| !j.held) {
        q[j] = match joint.travel {
            Some([low, high]) if !joint.is_rotary() => 0.5 * (low + high),
            _ => 0.0,
        };
    }
    for (name, value) in pose {
        let j = machine.joint(name).ok_or_else(|| format!("{} has no joint {name}", machine.name))?;
        q[j] = if machine.joints[j].is_rotary() { rad(*value) } else { *value };
    }
    if let Some(violation) = machine.first_over_travel(&q) {
        return Err(format!("{}: the pose is outside the travel: {violation:?}", machine.name).into());
    }
    Ok(q)
}

fn record(root: &Path, name: &str, pose: &[(String, f64)], folder: &Path) -> Result<(), Fault> {
    let machine = Machine::read(&root.join("machines").join(name))?;
    let scene = Scene::read(&root.join("scenes/cone-frustum"))?;
    let tools = ToolLibrary::read(&root.join("tools/cone-frustum.toml"))?;
    // A block on the clamping face and looks at home there.
    let reach = machine.bodies.iter().find(|b| b.role == "table").map_or(100.0, |b| 0.5 * b.mesh.aabb().size().norm());
    let half = 0.18 * reach;
    let bounds = Aabb { min: Point::new(-half, -half, 0.0), max: Point::new(half, half, 1.2 * half) };
    let stock = TriDexel::from_box(&bounds, 0.2 * half, 1 << 30)?;
    let normal = machine.table.normal;
    let across = Vector::z().cross(&normal);
    let turn = match across.try_normalize(1e-9) {
        Some(axis) => Pose::from_axis_angle(&axis, across.norm().atan2(normal.z)),
        None => Pose::identity(),
    };
    let table_from_work = Pose::from_translation(machine.table.point.coords) * turn;
    let setup = Setup {
        scene: &scene,
        program: name,
        program_lines: 1,
        made: None,
        sources: &BTreeMap::new(),
        machine: &machine,
        tools: &tools,
        stock: &stock,
        patches: &[],
        part: None,
        fixtures: &[],
        table_from_work,
        dynamics: proveout_controller::Dynamics::Planned,
        plant: proveout_controller::servo::Plant::NewtonEuler,
    };
    let places = [machine.home(), position(&machine, pose)?];
    let sample = |k: usize| {
        let q = places[k];
        Sample {
            time: k as f64,
            block: 0,
            path_length: 0.0,
            commanded: q,
            velocity: JointValues::ZERO,
            acceleration: JointValues::ZERO,
            jerk: JointValues::ZERO,
            actual: q,
            pose: machine.forward(&q, 0.0),
            feed_programmed: 0.0,
            feed: 0.0,
            kind: MoveKind::Rapid,
            drive: None,
        }
    };
    let samples = [sample(0), sample(1)];
    let batch = Batch {
        samples: &samples,
        signals: &[SampleSignals::default(); 2],
        pieces: &[],
        blocks: &[],
        events: &[],
        findings: &[],
        time: 1.0,
        stock: &stock,
        changed_tiles: &[],
        patches: &[],
        changed_in_patches: &[],
        loose: &[],
    };
    let verdict = support::verdict(1.0, 0.0, "a picture of a machine is no prove-out");
    let surface = SurfaceShape::default();
    let outcome = Outcome {
        verdict: &verdict,
        stock: &stock,
        patches: &[],
        surface: &surface,
        proof: &ClearanceProof::default(),
        folder,
    };
    for observer in observers(&RerunMode::File)?.iter_mut().filter(|o| o.name() == "rerun") {
        observer.begin(&setup, folder)?;
        observer.batch(&setup, &batch)?;
        observer.end(&setup, &outcome)?;
    }
    Ok(())
}
