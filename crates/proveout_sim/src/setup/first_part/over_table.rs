//! How high a part has to be set on a table that is tilted under the spindle, so that spindle,
//! holder and tool clear the table.
//!
//! Seen from the table, a tool that is tilted leans over it, and what carries the tool leans with it:
//!
//! ```text
//!                 a          r   radius of the spindle (holder, tool) at the distance d from the tip
//!                /           a   axis of the tool, in the frame of the workpiece
//!        r  .---/---.
//!          /   / d   \       lowest point of round section at d: z(d) = tip.z + a.z d - r sqrt(1 - a.z^2)
//!             /
//!            tip             over the table only where the section reaches over its edge
//!   ====================     table
//! ```
//!
//! The mounting is lifted by what the lowest point lacks. It is a proposal, for places at the ends of
//! motions: the run checks every pair of bodies.

use proveout_geom::{Point, Vector};
use proveout_machine::Machine;

use super::Reasoned;
use crate::prepare::program_extent::Reading;

/// Clearance between the table and what leans over it, mm.
const CLEAR_MM: f64 = 5.0;
/// Highest lift that is proposed, mm: that of a usual riser. More is no mounting but another machine.
const MOST_LIFT_MM: f64 = 300.0;
/// Steps along the spindle in which its radius is taken, mm.
const STEP_MM: f64 = 10.0;
/// How far above the gauge line the bodies of the spindle are read, mm.
const BEHIND_MM: f64 = 600.0;
/// A vertex belongs to the face of the table within this height, mm.
const FACE_MM: f64 = 2.0;
/// Directions of the table that count as up.
const UP: f64 = 0.999;

/// Sections of what carries tools: distance from the gauge line, negative towards the tip, and radius, mm.
fn sections(machine: &Machine, holder: Option<(f64, f64)>) -> Vec<(f64, f64)> {
    let gauge = &machine.spindle.gauge_pose;
    let (origin, along) = (gauge.point(&Point::origin()), gauge.vector(&Vector::z()));
    let mut by_step: Vec<(f64, f64)> = Vec::new();
    let own = machine.bodies.iter().filter(|b| b.check && b.attached_to == machine.spindle.attached_to);
    for p in own.flat_map(|b| &b.mesh.positions) {
        let from = p - origin;
        let distance = from.dot(&along);
        if !(-STEP_MM..BEHIND_MM).contains(&distance) {
            continue;
        }
        let radius = (from - along * distance).norm();
        let step = (distance / STEP_MM).floor() * STEP_MM;
        match by_step.iter_mut().find(|(known, _)| *known == step) {
            Some((_, widest)) => *widest = widest.max(radius),
            None => by_step.push((step, radius)),
        }
    }
    if let Some((diameter, length)) = holder {
        by_step.push((-length, 0.5 * diameter));
    }
    by_step.sort_by(|a, b| a.0.total_cmp(&b.0));
    by_step
}

/// Radius of the table's face about its middle, mm.
fn face_radius(machine: &Machine) -> f64 {
    let table = &machine.table;
    let own = machine.bodies.iter().filter(|b| b.check && b.attached_to == table.attached_to);
    own.flat_map(|b| &b.mesh.positions)
        .map(|p| p - table.point)
        .filter(|from| from.dot(&table.normal).abs() < FACE_MM)
        .map(|from| (from - table.normal * from.dot(&table.normal)).norm())
        .fold(0.0, f64::max)
}

/// The mounting, lifted where tilted tools would lean into the table. `holder`: diameter and length of the
/// widest one.
pub(super) fn cleared(
    machine: &Machine,
    mount: Reasoned<Vector>,
    readings: &[Reading],
    holder: Option<(f64, f64)>,
) -> Reasoned<Vector> {
    let table = &machine.table;
    let tilted = || readings.iter().flat_map(|r| &r.tilted);
    if table.normal.z < UP || tilted().next().is_none() {
        return mount;
    }
    let (sections, radius) = (sections(machine, holder), face_radius(machine));
    let mut lacking = 0.0_f64;
    for place in tilted() {
        let (tip, axis) = (place.tip + mount.value, place.axis);
        let lean = (1.0 - axis.z * axis.z).max(0.0).sqrt();
        let low = |distance: f64, r: f64| {
            let middle = tip + axis * distance;
            let aside = Vector::new(middle.x - table.point.x, middle.y - table.point.y, 0.0).norm();
            (aside < radius + r).then(|| table.point.z + CLEAR_MM - (middle.z - r * lean))
        };
        let all = sections.iter().filter_map(|(from_gauge, r)| low(place.gauge + from_gauge, *r));
        lacking = all.fold(lacking, f64::max);
    }
    if lacking <= 0.0 {
        return mount;
    }
    let lift = (lacking / 10.0).ceil() * 10.0;
    if lift > MOST_LIFT_MM {
        return mount;
    }
    let reason = format!(
        "{}; {lift:.0} mm higher, on a riser, so that spindle and holder clear the table where it is tilted under them",
        mount.reason
    );
    Reasoned { value: mount.value + Vector::new(0.0, 0.0, lift), reason, ..mount }
}
