//! From the content of `machine.toml` to a [`Machine`], with every check that a single value or a pair of
//! them allows.

use std::path::{Path, PathBuf};

use proveout_geom::{Point, Pose, Vector, rad};
use proveout_input::{Document, InputError, Step, Step::Item, Step::Key, read_input};

use crate::{
    Carries, Control, ControlKinematics, GeometricErrors, Joint, MAX_JOINTS, Machine, SpindleData, TableData, Trust,
    attachment::attachment,
    bodies::read_bodies,
    description::{KinematicsFile, MachineFile, ZeroFile},
    errors_reader::read_errors,
    joint_reader::read_joint,
    key_lines::KeyLines,
    kinematic_chain::Chain,
    pairs_reader::read_pairs,
    platform_reader::read_platforms,
    reading::{Checked, Notes, finite_vector, positive, unit},
    solver::Solver,
    structure::{chain_to, check_kinematics},
    units::S_PER_MS,
};

/// Sine of the angle to Z below which a direction is along it.
const PARALLEL: f64 = 1e-12;

impl Machine {
    /// Reads a machine from its folder or from its `machine.toml`.
    ///
    /// # Errors
    /// [`InputError`] with file, line, column, key, value and remedy of the first mistake.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let file: PathBuf = if path.is_dir() { path.join("machine.toml") } else { path.into() };
        Self::from_text(&file, &read_input(&file)?)
    }

    /// Reads a machine from the text of a `machine.toml`. Errors name `file`, and a model file is looked
    /// for in its folder.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn from_text(file: &Path, text: &str) -> Result<Self, InputError> {
        let source = Document::new(file, text);
        assemble(&source, &source.read()?)
    }
}

fn assemble(source: &Document<'_>, content: &MachineFile) -> Result<Machine, InputError> {
    if content.joint.len() > MAX_JOINTS {
        let message = format!("{} joints, and at most {MAX_JOINTS} are handled", content.joint.len());
        let path = [Key("joint"), Item(MAX_JOINTS)];
        Err(source.error("machine-too-many-joints", &path, message, "leave out joints that the programs do not move"))?;
    }
    let mut joints = Vec::with_capacity(content.joint.len());
    for (i, joint) in content.joint.iter().enumerate() {
        if let Some(first) = content.joint[..i].iter().position(|j| j.name == joint.name) {
            let message = format!("joint {first} has the name {:?} already", joint.name);
            let path = [Key("joint"), Item(i), Key("name")];
            Err(source.error("machine-duplicate-joint", &path, message, "give each joint its own name"))?;
        }
        joints.push(read_joint(source, i, joint, &content.joint)?);
    }
    let spindle_on = attachment(source, &content.joint, &[Key("spindle"), Key("on")], &content.spindle.on)?;
    let platforms = read_platforms(source, &content.platform, &joints)?;
    let errors =
        content.errors.as_ref().map_or_else(|| Ok(GeometricErrors::default()), |e| read_errors(source, e, &joints))?;
    let table_on = attachment(source, &content.joint, &[Key("table"), Key("on")], &content.table.on)?;
    let tool_chain = chain_to(source, &joints, spindle_on, Carries::Tool)?;
    let work_chain = chain_to(source, &joints, table_on, Carries::Workpiece)?;

    let spindle = &content.spindle;
    let in_spindle = |key| [Key("spindle"), Key(key)];
    let up = unit(source, &in_spindle("direction"), spindle.direction)?;
    let origin = finite_vector(source, &in_spindle("origin_mm"), spindle.origin_mm)?;
    let spindle_data = SpindleData {
        attached_to: spindle_on,
        gauge_pose: Pose { translation: origin, ..upright(&up) },
        max_speed_rpm: positive(source, &in_spindle("max_speed_rpm"), spindle.max_speed_rpm)?,
    };
    let in_table = |key| [Key("table"), Key(key)];
    let table = TableData {
        attached_to: table_on,
        point: Point::from(finite_vector(source, &in_table("point_mm"), content.table.point_mm)?),
        normal: unit(source, &in_table("normal"), content.table.normal)?,
    };
    let chain = Chain::new(&joints, &tool_chain, &work_chain, spindle_data.gauge_pose);
    let solver = Solver::new(&chain, &joints);
    check_kinematics(source, &joints, &chain, &solver)?;
    let control = read_control(source, content, &joints)?;
    let trust = read_trust(source, content)?;
    let (bodies, unused_nodes) =
        read_bodies(source, content, |path, name| attachment(source, &content.joint, path, name))?;
    let pairs = read_pairs(source, &content.pairs, &bodies, &spindle_data)?;
    let machine = Machine {
        name: content.name.clone(),
        description: content.description.clone(),
        up: content.up.map(|v| unit(source, &[Key("up")], v)).transpose()?,
        joints,
        tool_chain,
        work_chain,
        platforms,
        errors,
        bodies,
        pairs,
        control,
        spindle: spindle_data,
        table,
        trust,
        unused_nodes,
        chain,
        solver,
        actual: None,
        places: KeyLines::new(source),
    };
    let machine = machine.recompiled();
    match content.zero {
        ZeroFile::File => Ok(machine),
        ZeroFile::Home => machine.zero_at_home().map_err(|why| {
            let message = format!("X, Y and Z cannot be zero at home: {why}");
            source.error("machine-zero", &[Key("zero")], message, "leave the key out, or state what is missing")
        }),
    }
}

fn not_negative(source: &Document<'_>, path: &[Step<'_>], value: f64) -> Checked<f64> {
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(source.error("machine-not-positive", path, format!("{value} cannot be"), "write zero or a positive number"))
}

/// The rotation that brings +z into a direction on the shortest way; half a turn about x for -z.
fn upright(z: &Vector) -> Pose {
    let across = Vector::z().cross(z);
    match across.try_normalize(PARALLEL) {
        Some(axis) => Pose::from_axis_angle(&axis, across.norm().atan2(z.z)),
        None if z.z > 0.0 => Pose::identity(),
        None => Pose::from_axis_angle(&Vector::x(), rad(180.0)),
    }
}

fn read_control(source: &Document<'_>, content: &MachineFile, joints: &[Joint]) -> Checked<Control> {
    let file = &content.control;
    let at = |key| [Key("control"), Key(key)];
    let mut tool_change_position = [None; MAX_JOINTS];
    for (place, joint) in tool_change_position.iter_mut().zip(joints) {
        *place = joint.tool_change;
    }
    let required = |key: &'static str, value: f64| -> Checked<f64> {
        let v = positive(source, &at(key), Some(value))?;
        Ok(v.unwrap_or(value))
    };
    Ok(Control {
        file: file.file.clone(),
        cycle_time: required("cycle_time_ms", file.cycle_time_ms)? * S_PER_MS,
        block_time: not_negative(source, &at("block_time_ms"), file.block_time_ms)? * S_PER_MS,
        tool_change_time: not_negative(source, &at("tool_change_time_s"), file.tool_change_time_s)?,
        spindle_start_time: not_negative(source, &[Key("spindle"), Key("start_time_s")], content.spindle.start_time_s)?,
        rapid_mode: file.rapid_mode,
        kinematics: file.kinematics.as_ref().map(|list| ControlKinematics {
            tcp: list.contains(&KinematicsFile::Tcp),
            tilted_plane: list.contains(&KinematicsFile::TiltedPlane),
        }),
        default_tolerance: required("default_tolerance_mm", file.default_tolerance_mm)?,
        default_orientation_tolerance: positive(
            source,
            &at("default_orientation_tolerance_deg"),
            file.default_orientation_tolerance_deg,
        )?
        .map(rad),
        pole_cone: read_pole_cone(source, file.pole_cone_deg)?,
        tool_change_position,
    })
}

fn read_pole_cone(source: &Document<'_>, degrees: Option<f64>) -> Checked<f64> {
    let Some(degrees) = degrees else { return Ok(Machine::USUAL_POLE_CONE) };
    let path = [Key("control"), Key("pole_cone_deg")];
    let cone = rad(not_negative(source, &path, degrees)?);
    if cone > Machine::WIDEST_POLE_CONE {
        let message = format!("the cone about a pole is {degrees} degrees");
        return Err(source.error("machine-range", &path, message, "give at most 5 degrees"));
    }
    Ok(cone)
}

/// Collects the notes on numbers; each must belong to a key of its table.
fn read_trust(source: &Document<'_>, content: &MachineFile) -> Checked<Vec<Trust>> {
    let mut tables: Vec<(Vec<Step<'_>>, String, &Notes, &Notes)> = vec![
        (vec![Key("spindle")], "spindle".into(), &content.spindle.source, &content.spindle.chosen),
        (vec![Key("table")], "table".into(), &content.table.source, &content.table.chosen),
        (vec![Key("control")], "control".into(), &content.control.source, &content.control.chosen),
    ];
    if let Some(d) = &content.body_density {
        tables.push((vec![Key("body_density")], "body_density".into(), &d.source, &d.chosen));
    }
    for (i, j) in content.joint.iter().enumerate() {
        tables.push((vec![Key("joint"), Item(i)], format!("joint.{}", j.name), &j.source, &j.chosen));
    }
    for (i, p) in content.platform.iter().enumerate() {
        tables.push((vec![Key("platform"), Item(i)], format!("platform.{}", p.name), &p.source, &p.chosen));
        for (k, leg) in p.leg.iter().enumerate() {
            let path = vec![Key("platform"), Item(i), Key("leg"), Item(k)];
            tables.push((path, format!("platform.{}.leg.{}", p.name, leg.name), &leg.source, &leg.chosen));
        }
    }
    if let Some(errors) = &content.errors {
        tables.push((vec![Key("errors")], "errors".into(), &errors.source, &errors.chosen));
        for (i, t) in errors.table.iter().enumerate() {
            let path = vec![Key("errors"), Key("table"), Item(i)];
            tables.push((path, format!("errors.table.{}", t.joint), &t.source, &t.chosen));
        }
    }
    for (i, b) in content.body.iter().enumerate() {
        tables.push((vec![Key("body"), Item(i)], format!("body.{}", b.name), &b.source, &b.chosen));
    }
    let mut all = Vec::new();
    for (path, name, sources, chosen) in tables {
        let keys = source.keys(&path);
        for (notes, word, is_chosen) in [(sources, "source", false), (chosen, "chosen", true)] {
            for (key, note) in notes {
                if key != "*" && !keys.contains(key) {
                    let mut at = path.clone();
                    at.extend([Key(word), Key(key)]);
                    let message = format!("the note names {key}, which this table does not have");
                    return Err(source.error("input-unknown-key", &at, message, "name a key of the same table, or *"));
                }
                all.push(Trust {
                    key: format!("{name}.{key}"),
                    name: key.clone(),
                    chosen: is_chosen,
                    note: note.clone(),
                });
            }
        }
    }
    Ok(all)
}
