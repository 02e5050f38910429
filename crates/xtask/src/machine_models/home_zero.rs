//! Machines whose axes are zero at home: the shapes are those of a machine whose axes read the place of the
//! gauge line.
//!
//! The functions of `library` build a machine with its slides at zero on the table. Here the numbers are
//! first converted to that zero, and what the slides carry is then moved to its place with the slides at
//! home.

use crate::{
    TaskError,
    machine_models::{
        library::Build,
        numbers::KinematicNumbers,
        part::MachinePart,
        solid::{V3, add, scaled},
    },
};

/// The joint of this name; none for the base.
fn position(numbers: &KinematicNumbers, name: &str) -> Option<usize> {
    numbers.joints.iter().position(|j| j.name == name)
}

/// Way of everything on a joint, from the slides at zero on the table to the slides at home, as the table
/// sees it at home: slides of the workpiece move against their axes, and places of the file count from the
/// table, so that the base moves the other way.
fn way(numbers: &KinematicNumbers, on: &str) -> Result<V3, TaskError> {
    let mut way = [0.0; 3];
    for joint in numbers.joints.iter().filter(|j| j.workpiece && j.travel.is_some()) {
        way = add(way, scaled(joint.direction, along(joint.direction, numbers.gauge)?));
    }
    let mut next = position(numbers, on);
    for _ in 0..=numbers.joints.len() {
        let Some(j) = next else { return Ok(way) };
        let joint = &numbers.joints[j];
        if joint.travel.is_some() {
            let sense = if joint.workpiece { -1.0 } else { 1.0 };
            way = add(way, scaled(joint.direction, sense * along(joint.direction, numbers.gauge)?));
        }
        next = position(numbers, &joint.parent);
    }
    Err(TaskError(format!("{}: the joints below {on} form a loop", numbers.name)))
}

/// Part of a place along a slide, which must run along an axis of the machine.
fn along(direction: V3, place: V3) -> Result<f64, TaskError> {
    let axis = (0..3).find(|&k| direction[k] == 1.0);
    axis.map(|k| place[k])
        .ok_or_else(|| TaskError(format!("a slide along {direction:?} has no home position: use a machine axis")))
}

/// Parts of a machine with its zero at home, by the maker of one with its zero on the table.
pub(crate) fn parts(numbers: &KinematicNumbers, build: Build) -> Result<Vec<MachinePart>, TaskError> {
    let mut at_table = numbers.clone();
    at_table.gauge = [0.0; 3];
    for j in 0..numbers.joints.len() {
        let joint = &numbers.joints[j];
        let home = way(numbers, &joint.name)?;
        if let Some([low, high]) = joint.travel {
            let shift = along(joint.direction, numbers.gauge)?;
            at_table.joints[j].travel = Some([low + shift, high + shift]);
        }
        at_table.joints[j].point = joint.point.map(|p| add(p, scaled(home, -1.0)));
    }
    let mut parts = build(&at_table)?;
    for part in &mut parts {
        let home = way(numbers, &part.on)?;
        for point in &mut part.solid.points {
            *point = add(*point, home);
        }
    }
    Ok(parts)
}
