//! The text of `machine.toml`.

use std::fmt::Write as _;

use proveout_geom::{Point, Vector, deg};
use proveout_input::{InputError, range_of};

use super::{
    axes::{Axes, UrdfAxis},
    link_tree::LinkTree,
    named_links::NamedLinks,
    read::{Robot, UrdfJointKind},
    source::{UrdfSource, listed, shown},
};
use crate::Carries;

/// Acceleration (mm/s², degrees/s²) and jerk (mm/s³, degrees/s³) of slides and of rotary axes: machines of
/// the library have 300 to 10,000 mm/s² and 100 to 1,500 degrees/s²; the jerk takes 50 ms to full
/// acceleration.
const SLIDE: [f64; 2] = [2_000.0, 40_000.0];
const TURN: [f64; 2] = [500.0, 10_000.0];
/// Scales of the decimals that numbers and unit vectors are written with.
const NINE_DECIMALS: f64 = 1e9;
const FIFTEEN_DECIMALS: f64 = 1e15;

/// A slide that runs this far along the normal of the table (cosine) takes the tool off it at home.
const OFF_THE_TABLE: f64 = 0.7;

/// What follows the axes in the file.
#[derive(Default)]
pub(super) struct Sections<'b> {
    pub(super) bodies: &'b str,
    pub(super) has_model: bool,
}

/// A string of TOML.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars().filter(|c| !c.is_control()) {
        if matches!(c, '"' | '\\') {
            out.push('\\');
        }
        out.push(c);
    }
    out.push('"');
    out
}

/// A number with nine decimals: a millionth of a nanometer.
pub(super) fn number(v: f64) -> String {
    format!("{}", (v * NINE_DECIMALS).round() / NINE_DECIMALS + 0.0)
}

pub(super) fn place(p: &Point) -> String {
    format!("[{}, {}, {}]", number(p.x), number(p.y), number(p.z))
}

/// A unit vector with fifteen decimals.
fn unit(v: &Vector) -> String {
    let [x, y, z] = [v.x, v.y, v.z].map(|x| (x * FIFTEEN_DECIMALS).round() / FIFTEEN_DECIMALS + 0.0);
    format!("[{x}, {y}, {z}]")
}

fn on(letter: Option<char>) -> String {
    letter.map_or_else(|| "base".to_owned(), |l| l.to_string())
}

/// The whole file.
pub(super) fn machine(source: &UrdfSource<'_>, robot: &Robot, kinematics: &str, sections: &Sections<'_>) -> String {
    let file = source.file.file_name().unwrap_or_default().to_string_lossy();
    let file: String = file.chars().filter(|c| !c.is_control()).collect();
    let model = if sections.has_model { "model = \"model.glb\"\n" } else { "" };
    format!(
        "# Made from the URDF file {file}, as a start. What the file does not give is marked `chosen`.\n# Machine \
         coordinates: the frame of the root link, all joints at zero. Up is its z, as ROS has it (REP 103).\n\nname = \
         {}\ndescription = \"from URDF; letters, sides, home and times are chosen\"\nup = [0, 0, \
         1]\n{model}{kinematics}{}",
        quoted(&robot.name),
        sections.bodies
    )
}

/// Joints, spindle, table and control.
pub(super) fn kinematics(
    source: &UrdfSource<'_>,
    robot: &Robot,
    tree: &LinkTree,
    ends: &NamedLinks,
    axes: &Axes,
    notes: &mut Vec<String>,
) -> Result<String, InputError> {
    let mut w = String::new();
    let normal = tree.poses[ends.table].vector(&ends.normal);
    let (mut no_travel, mut no_velocity) = (Vec::new(), Vec::new());
    for axis in &axes.all {
        let joint = &robot.joints[axis.joint];
        write_joint(&mut w, source, robot, axis, &normal)?;
        if joint.travel.is_none() && joint.kind != UrdfJointKind::Continuous {
            no_travel.push(joint.name.as_str());
        }
        if joint.velocity.is_none() {
            no_velocity.push(joint.name.as_str());
        }
    }
    for (what, names) in [("travel", no_travel), ("velocity", no_velocity)] {
        if !names.is_empty() {
            notes.push(format!("no {what} in the file, the gate `limits` stays unchecked for it: {}", listed(names)));
        }
    }
    notes.push("assumed: acceleration, jerk and home of the axes, times of the control; the highest speed of the spindle is not known".into());
    let gauge = Point::from(tree.poses[ends.tool].translation);
    let into_spindle = tree.poses[ends.tool].vector(&ends.into_spindle);
    let table = Point::from(tree.poses[ends.table].translation);
    let [tool_name, table_name] = [ends.tool, ends.table].map(|l| robot.links[l].name.as_str());
    let link = |what: &str, name: &str, frame: &str, stated: bool| {
        let frame = if stated { String::new() } else { format!(", and the z of its frame {frame}") };
        format!("{what} is the origin of link {}{frame}", shown(name))
    };
    notes.push(link(
        "the middle of the gauge line",
        tool_name,
        "points into the spindle (chosen; else --tool-direction)",
        ends.stated[0],
    ));
    notes.push(link(
        "the middle of the clamping surface",
        table_name,
        "points out of it (chosen; else --table-normal)",
        ends.stated[1],
    ));
    let chosen = |stated: bool, key: &str| {
        if stated { String::new() } else { format!("{key} = \"z of the frame of the link; not in the file\"\n") }
    };
    let [tool_on, table_on] = axes.last.map(on);
    let _ = write!(
        w,
        "\n[spindle]\non = {}\norigin_mm = {}\ndirection = {}\nstart_time_s = 2\n\n[spindle.source]\norigin_mm = \
         {}\n\n[spindle.chosen]\n{}start_time_s = \"not in the file\"\n",
        quoted(&tool_on),
        place(&gauge),
        unit(&into_spindle),
        quoted(&format!("URDF file: origin of link {tool_name}, named by the caller")),
        chosen(ends.stated[0], "direction"),
    );
    let _ = write!(
        w,
        "\n[table]\non = {}\npoint_mm = {}\nnormal = {}\n\n[table.source]\npoint_mm = {}\n\n[table.chosen]\n{}",
        quoted(&table_on),
        place(&table),
        unit(&normal),
        quoted(&format!("URDF file: origin of link {table_name}, named by the caller")),
        chosen(ends.stated[1], "normal"),
    );
    w.push_str(
        "\n[control]\ncycle_time_ms = 2\nblock_time_ms = 1\ntool_change_time_s = 10\nrapid_mode = \
         \"straight\"\ndefault_tolerance_mm = 0.01\n\n[control.chosen]\n\"*\" = \"not in the file\"\n",
    );
    Ok(w)
}

/// Position of a joint when the program begins.
fn home(axis: &UrdfAxis, normal: &Vector) -> f64 {
    let Some([low, high]) = axis.travel else { return 0.0 };
    let off = axis.direction.dot(normal);
    if axis.rotary() || axis.held() || off.abs() < OFF_THE_TABLE {
        return 0.0_f64.clamp(low, high);
    }
    if off > 0.0 { high } else { low }
}

fn write_joint(
    w: &mut String,
    source: &UrdfSource<'_>,
    robot: &Robot,
    axis: &UrdfAxis,
    normal: &Vector,
) -> Result<(), InputError> {
    let joint = &robot.joints[axis.joint];
    let rotary = axis.rotary();
    let (unit_of, kind) = if rotary { ("deg", "rotary") } else { ("mm", "linear") };
    let (carries, sense) = match axis.carries {
        Carries::Tool => ("tool", 1),
        Carries::Workpiece => ("workpiece", -1),
    };
    let in_unit = |v: f64| if rotary { deg(v) } else { v };
    let _ = write!(
        w,
        "\n[[joint]]\nname = \"{}\"\nkind = \"{kind}\"\ncarries = \"{carries}\"\nparent = {}\ndirection = {}\n",
        axis.letter,
        quoted(&on(axis.parent)),
        unit(&axis.direction)
    );
    if rotary {
        let _ = writeln!(w, "point_mm = {}", place(&axis.point));
    }
    let _ = writeln!(w, "sense = {sense}");
    let in_range = |key: &str, value: f64| {
        let fits = range_of(key).is_none_or(|(least, most, _)| value.abs() <= most && value.abs() >= least);
        if fits {
            return Ok(number(value));
        }
        let (least, most, _) = range_of(key).unwrap_or_default();
        let message =
            format!("the limit of joint {} gives {key} = {value:e}: {least} to {most} is taken", shown(&joint.name));
        Err(source.at(&joint.limit_place, message, "correct it, or leave it out where it is not known"))
    };
    if joint.kind == UrdfJointKind::Continuous {
        w.push_str("endless = true\n");
    } else if let Some([low, high]) = axis.travel {
        let key = format!("travel_{unit_of}");
        let [low, high] = [in_range(&key, in_unit(low))?, in_range(&key, in_unit(high))?];
        if low == high {
            let message = format!("joint {} has no travel: {low} to {high} {unit_of}", shown(&joint.name));
            return Err(source.at(
                &joint.limit_place,
                message,
                "write meters and radians; a joint that does not move is fixed",
            ));
        }
        let _ = writeln!(w, "{key} = [{low}, {high}]");
    }
    if axis.held() {
        w.push_str("held = true\n");
    }
    let _ = writeln!(w, "home_{unit_of} = {}", number(in_unit(home(axis, normal))));
    let speed = if rotary { "deg_s" } else { "mm_min" };
    if let Some(v) = joint.velocity {
        let key = format!("max_velocity_{speed}");
        let v = in_range(&key, if rotary { deg(v) } else { v * 60.0 })?;
        let _ = writeln!(w, "{key} = {v}\nrapid_velocity_{speed} = {v}");
    }
    let [acceleration, jerk] = if rotary { TURN } else { SLIDE };
    let _ = writeln!(w, "max_acceleration_{unit_of}_s2 = {acceleration}\nmax_jerk_{unit_of}_s3 = {jerk}");
    let way = if axis.reversed { "; the control counts against it (--reverse)" } else { "" };
    let _ = write!(
        w,
        "\n[joint.source]\n\"*\" = {}\n\n[joint.chosen]\n",
        quoted(&format!("URDF file, joint {}{way}", joint.name))
    );
    if axis.carries == Carries::Workpiece {
        w.push_str("sense = \"ISO 841: the direction is that of the tool past the workpiece, so that the table moves against it\"\n");
    }
    let end = if rotary || home(axis, normal) == 0.0 {
        "zero of the joint, or the end nearest to it"
    } else {
        "an end of the travel"
    };
    let _ = writeln!(w, "home_{unit_of} = \"the file names no home: {end}\"");
    if axis.held() {
        w.push_str("held = \"programs do not move U, V and W\"\n");
    }
    if joint.velocity.is_some() {
        let _ = writeln!(w, "rapid_velocity_{speed} = \"as the highest velocity\"");
    }
    let _ = write!(
        w,
        "max_acceleration_{unit_of}_s2 = \"URDF knows none: a usual value, to be measured\"\nmax_jerk_{unit_of}_s3 = \"full acceleration in 50 ms\"\n"
    );
    Ok(())
}
