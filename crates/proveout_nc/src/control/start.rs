//! What is in force at the start of a program, and where its axes are.

use std::collections::BTreeMap;

use super::error::Checked;
use super::file::{DistanceFile, PlaneFile, StartFile, UnitFile};
use super::model::{Control, StartMotion};
use super::place::ControlText;
use crate::AxisValues;
use crate::settings::Dialect;

pub(super) fn start(control: &mut Control, file: &StartFile, text: &ControlText<'_>) -> Checked<()> {
    let start = &mut control.start;
    if let Some(plane) = file.plane {
        start.normal = Some(match plane {
            PlaneFile::XY => 2,
            PlaneFile::ZX => 1,
            PlaneFile::YZ => 0,
        });
    }
    if let Some(unit) = file.unit {
        start.inch = Some(matches!(unit, UnitFile::Inch));
    }
    if let Some(distance) = file.distance {
        start.incremental = Some(matches!(distance, DistanceFile::Incremental));
    }
    start.feed = file.feed.or(start.feed);
    start.motion = file.motion.or(start.motion);
    if control.dialect == Dialect::Siemens840d && file.motion == Some(StartMotion::None) {
        let message = "a Sinumerik has a motion in force at every time";
        return Err(text.error("control-value", &["start", "motion"], message, "write rapid or linear"));
    }
    for (table, values, rotary) in
        [("position_mm", &file.position_mm, false), ("position_deg", &file.position_deg, true)]
    {
        positions(&mut control.position, values, rotary, &["start", table], text)?;
    }
    Ok(())
}

/// Positions of axes by their letter.
pub(super) fn positions(
    into: &mut AxisValues,
    values: &BTreeMap<String, f64>,
    rotary: bool,
    path: &[&str],
    text: &ControlText<'_>,
) -> Checked<()> {
    for (letter, &value) in values {
        let axis = match letter.as_bytes() {
            [byte] => AxisValues::index(char::from(*byte)),
            _ => None,
        };
        let Some(axis) = axis.filter(|axis| (3..6).contains(axis) == rotary) else {
            let axes = if rotary { "A, B, C" } else { "X, Y, Z, U, V, W" };
            let message = format!("{letter} is not one of the axes {axes}");
            return Err(text.error("control-value", path, message, "write the letter of an axis"));
        };
        if !value.is_finite() {
            return Err(text.error(
                "control-value",
                path,
                format!("{value} is not a valid position"),
                "write a finite number",
            ));
        }
        into.put(axis, if rotary { value.to_radians() } else { value });
    }
    Ok(())
}
