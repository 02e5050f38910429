//! The `[errors]` table: names after ISO 230-7, units, and the checks on both.

use std::collections::BTreeMap;

use proveout_geom::{Point, rad};
use proveout_input::{Document, Step, Step::Item, Step::Key};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    ConstantErrors, ErrorOf, ErrorTable, GeometricErrors, Joint,
    errors::COMPONENTS,
    reading::{Checked, Notes, finite_vector},
    units::{MM_PER_UM, RAD_PER_URAD},
};

/// Part of an error that must vanish where it has no meaning, relative to the whole.
const MEANINGLESS: f64 = 1e-9;
/// Positions of an endless axis span a turn within this, radian: rounding of degrees.
const FULL_TURN: f64 = 1e-9;

/// Largest error (mm, radian) that is still one: beyond it a number has the wrong unit, or the description is
/// wrong.
const IMPLAUSIBLE: [f64; 2] = [5.0, 0.02];

/// Geometric errors of the actual machine.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ErrorsFile {
    /// Position-independent errors: `EX0C_um`, E, component X Y Z A B C, 0, joint (S for the spindle), unit.
    #[serde(default)]
    pub(crate) constant: BTreeMap<String, f64>,
    /// Errors against the position of a joint.
    #[serde(default)]
    pub(crate) table: Vec<ErrorTableFile>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// Error motions of one joint, linear between the positions.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ErrorTableFile {
    /// The joint.
    pub(crate) joint: String,
    /// Positions of a linear joint, growing.
    pub(crate) at_mm: Option<Vec<f64>>,
    /// Positions of a rotary joint, growing.
    pub(crate) at_deg: Option<Vec<f64>>,
    /// Point that the shifts are given at, machine coordinates with all joints at zero; it moves with a
    /// slide. The machine origin for a linear joint, the joint's point for a rotary one, when left out.
    pub(crate) reference_mm: Option<[f64; 3]>,
    /// One list a component, as long as the positions: `EXX_um`, E, component X Y Z A B C, joint, unit.
    #[serde(default)]
    pub(crate) values: BTreeMap<String, Vec<f64>>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// Component, middle of the name and factor to mm or radian.
fn parse(name: &str) -> Result<(usize, &str, f64), String> {
    let (stem, unit) = name.rsplit_once('_').ok_or("a name ends in its unit: _um, _mm, _urad, _arcsec or _deg")?;
    let (k, middle) = COMPONENTS
        .iter()
        .enumerate()
        .find_map(|(k, letter)| Some((k, stem.strip_prefix('E')?.strip_prefix(*letter)?)))
        .ok_or("a name begins with E and the component X, Y, Z, A, B or C")?;
    let factor = match (unit, k < 3) {
        ("um", true) => MM_PER_UM,
        ("mm", true) => 1.0,
        ("urad", false) => RAD_PER_URAD,
        ("arcsec", false) => rad(1.0) / 3600.0,
        ("deg", false) => rad(1.0),
        (_, true) => return Err("the components X, Y, Z are shifts, in _um or _mm".into()),
        (_, false) => return Err("the components A, B, C are turns, in _urad, _arcsec or _deg".into()),
    };
    Ok((k, middle, factor))
}

fn checked_value(source: &Document<'_>, path: &[Step<'_>], component: usize, value: f64) -> Checked<f64> {
    let limit = IMPLAUSIBLE[component / 3];
    if value.is_finite() && value.abs() <= limit {
        return Ok(value);
    }
    let unit = if component < 3 { "mm" } else { "rad" };
    let message = format!("an error of {value} {unit} is too large; the limit is {limit} {unit}");
    Err(source.error("machine-error-value", path, message, "check the unit, or correct the joint itself"))
}

/// Reads the table.
pub(crate) fn read_errors(source: &Document<'_>, file: &ErrorsFile, joints: &[Joint]) -> Checked<GeometricErrors> {
    let mut errors = GeometricErrors::default();
    for (name, &value) in &file.constant {
        let path = [Key("errors"), Key("constant"), Key(name)];
        let wrong = |why: &str| {
            let remedy = format!("{why}; after the component come 0 and the joint (S for the spindle): EA0C_urad");
            source.error("machine-error-name", &path, format!("{name} names no error"), remedy)
        };
        let (component, middle, factor) = parse(name).map_err(|why| wrong(&why))?;
        let joint_name = middle
            .strip_prefix('0')
            .ok_or_else(|| wrong("write errors that depend on the position into [[errors.table]]"))?;
        let of = match joints.iter().position(|j| j.name == joint_name) {
            Some(j) => ErrorOf::Joint(j),
            None if joint_name == "S" => ErrorOf::Spindle,
            None => return Err(wrong(&format!("there is no joint {joint_name:?}"))),
        };
        let value = checked_value(source, &path, component, value * factor)?;
        let place = match errors.constant.iter().position(|c| c.of == of) {
            Some(k) => k,
            None => {
                errors.constant.push(ConstantErrors { of, components: [0.0; 6] });
                errors.constant.len() - 1
            }
        };
        let entry = &mut errors.constant[place].components[component];
        if *entry != 0.0 {
            return Err(wrong("the same error is given in another unit as well"));
        }
        *entry = value;
    }
    for constant in &errors.constant {
        check_meaning(source, constant, joints)?;
    }
    for (i, table) in file.table.iter().enumerate() {
        errors.tables.push(read_table(source, i, table, joints)?);
    }
    for (i, table) in errors.tables.iter().enumerate() {
        if errors.tables[..i].iter().any(|t| t.joint == table.joint) {
            let message = format!("joint {} has a table already", joints[table.joint].name);
            let path = [Key("errors"), Key("table"), Item(i), Key("joint")];
            return Err(source.error("machine-error-table", &path, message, "put all components in one table"));
        }
    }
    Ok(errors)
}

/// A slide has a direction and no place; a line is not moved by a shift along itself.
fn check_meaning(source: &Document<'_>, constant: &ConstantErrors, joints: &[Joint]) -> Checked<()> {
    let ErrorOf::Joint(j) = constant.of else { return Ok(()) };
    let joint = &joints[j];
    let (shift, _) = constant.parts();
    let along = joint.direction * joint.direction.dot(&shift);
    let (lost, message, remedy) = if joint.is_rotary() {
        let message = format!("a shift along the axis of {} has no effect", joint.name);
        (along, message, "give the shift across the axis")
    } else {
        let message = format!("slide {} has a direction, but no place across it", joint.name);
        (shift - along, message, "give the shift along the slide (its zero), or as a table")
    };
    if lost.norm() <= MEANINGLESS * shift.norm() {
        return Ok(());
    }
    let letter = COMPONENTS[lost.iamax()];
    let name = format!("E{letter}0{}", joint.name);
    let key = [format!("{name}_um"), format!("{name}_mm")];
    let key = if source.has(&[Key("errors"), Key("constant"), Key(&key[1])]) { &key[1] } else { &key[0] };
    Err(source.error("machine-error-name", &[Key("errors"), Key("constant"), Key(key)], message, remedy))
}

fn read_table(source: &Document<'_>, index: usize, file: &ErrorTableFile, joints: &[Joint]) -> Checked<ErrorTable> {
    let at = |key| [Key("errors"), Key("table"), Item(index), Key(key)];
    let wrong =
        |key, message: String, remedy: &str| Err(source.error("machine-error-table", &at(key), message, remedy));
    let Some(joint) = joints.iter().position(|j| j.name == file.joint) else {
        return wrong("joint", format!("there is no joint {:?}", file.joint), "name a joint of this file");
    };
    let rotary = joints[joint].is_rotary();
    let (key, other, positions) = if rotary {
        ("at_deg", ("at_mm", file.at_mm.is_some()), file.at_deg.as_ref().map(|v| v.iter().map(|d| rad(*d)).collect()))
    } else {
        ("at_mm", ("at_deg", file.at_deg.is_some()), file.at_mm.clone())
    };
    if other.1 {
        return wrong(other.0, format!("joint {} has no {}", file.joint, other.0), &format!("write {key}"));
    }
    let Some(positions): Option<Vec<f64>> = positions else {
        return wrong("joint", format!("the table has no {key}"), &format!("add {key}, the positions of the values"));
    };
    let growing = positions.windows(2).all(|w| w[0] < w[1]) && positions.iter().all(|p| p.is_finite());
    if positions.len() < 2 || !growing {
        return wrong(key, "positions must be two or more growing numbers".into(), "sort them, without repetitions");
    }
    let mut components = vec![[0.0; 6]; positions.len()];
    for (name, values) in &file.values {
        let path = [Key("errors"), Key("table"), Item(index), Key("values"), Key(name)];
        let refuse = |why: String| {
            source.error(
                "machine-error-name",
                &path,
                format!("{name}: {why}"),
                "write EXX_um: E, component, joint, unit",
            )
        };
        let (component, middle, factor) = parse(name).map_err(refuse)?;
        if middle != file.joint {
            return Err(refuse(format!("the table is that of joint {}", file.joint)));
        }
        if values.len() != positions.len() {
            let message = format!("{} values for {} positions", values.len(), positions.len());
            return Err(source.error("machine-error-table", &path, message, "write one value a position"));
        }
        for (row, value) in components.iter_mut().zip(values) {
            if row[component] != 0.0 {
                return Err(refuse("the same error is given in another unit as well".into()));
            }
            row[component] = checked_value(source, &path, component, value * factor)?;
        }
    }
    if joints[joint].endless {
        let (first, last) = (positions.first().copied().unwrap_or(0.0), positions.last().copied().unwrap_or(0.0));
        let turn = (last - first - std::f64::consts::TAU).abs() < FULL_TURN;
        if !turn || components.first() != components.last() {
            let remedy = "give a full turn whose last values are the first ones";
            return wrong(key, format!("the table of the endless joint {} does not close", file.joint), remedy);
        }
    }
    let reference = match file.reference_mm {
        Some(p) => Point::from(finite_vector(source, &at("reference_mm"), p)?),
        None => joints[joint].point,
    };
    Ok(ErrorTable { joint, reference, at: positions, components })
}
