//! Which column of a trace is what: a file of the user, or names that say it themselves.

use std::path::Path;

use proveout_input::{Document, InputError, Step::Item, Step::Key, nearest};
use proveout_machine::{Joint, Machine};
use serde::Deserialize;

/// Columns of a trace, as written in a file of `--columns`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnsFile {
    /// Column of the time.
    pub time: String,
    /// Unit of the time.
    #[serde(default)]
    pub time_unit: TimeUnit,
    /// Column with the line of the program under way, from 1.
    pub block: Option<String>,
    /// Column with the override of the feed, in percent: motion at another override than 100 is left out.
    pub override_percent: Option<String>,
    /// Columns of one joint each.
    pub joint: Vec<JointColumns>,
}

/// Columns of a joint.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointColumns {
    /// Name of the joint in the machine file.
    pub name: String,
    /// Unit of both positions.
    pub unit: PositionUnit,
    /// Column of the commanded position (set point).
    pub command: Option<String>,
    /// Column of the measured position.
    pub actual: Option<String>,
    /// Column of force, torque, current or load of the motor.
    pub force: Option<String>,
    /// Unit of that column.
    pub force_unit: Option<ForceUnit>,
    /// Force or torque for one unit of current or load, at a linear joint.
    #[serde(rename = "force_per_unit_N")]
    pub force_per_unit_n: Option<f64>,
    /// The same at a rotary joint.
    #[serde(rename = "torque_per_unit_Nm")]
    pub torque_per_unit_nm: Option<f64>,
}

/// Unit of a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    #[serde(rename = "s")]
    Second,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Millisecond,
    /// Microseconds.
    #[serde(rename = "us")]
    Microsecond,
}

impl TimeUnit {
    /// Factor to seconds.
    pub(crate) fn seconds(self) -> f64 {
        match self {
            Self::Second => 1.0,
            Self::Millisecond => 1e-3,
            Self::Microsecond => 1e-6,
        }
    }
}

/// Unit of a position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum PositionUnit {
    /// Millimeters.
    #[default]
    #[serde(rename = "mm")]
    Millimeter,
    /// Micrometers.
    #[serde(rename = "um")]
    Micrometer,
    /// Inches.
    #[serde(rename = "inch")]
    Inch,
    /// Degrees.
    #[serde(rename = "deg")]
    Degree,
    /// Radians.
    #[serde(rename = "rad")]
    Radian,
}

impl PositionUnit {
    /// Name in files, and factor to mm or radian.
    pub(crate) fn scale(self) -> (&'static str, f64) {
        match self {
            Self::Millimeter => ("mm", 1.0),
            Self::Micrometer => ("um", 1e-3),
            Self::Inch => ("inch", 25.4),
            Self::Degree => ("deg", 1_f64.to_radians()),
            Self::Radian => ("rad", 1.0),
        }
    }

    pub(crate) fn is_angle(self) -> bool {
        matches!(self, Self::Degree | Self::Radian)
    }
}

/// Unit of what the motor gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum ForceUnit {
    /// Newton, at the joint.
    N,
    /// Newton meter, at the joint.
    Nm,
    /// Ampere.
    A,
    /// Percent of the rated load.
    #[serde(rename = "percent")]
    Percent,
}

impl ForceUnit {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::N => "N",
            Self::Nm => "Nm",
            Self::A => "A",
            Self::Percent => "percent",
        }
    }
}

/// Endings of columns that say what they are, after the name of the joint.
const OWN_NAMES: &str = "time_s (or time_ms), and for a joint X: X_command_mm, X_actual_mm (or _deg), X_force_N, \
                         X_torque_Nm, X_current_A, X_load_percent; block, override_percent";

impl ColumnsFile {
    /// Reads the file of `--columns`.
    ///
    /// # Errors
    /// [`InputError`] with the place: an unknown key, a joint without a column of positions.
    pub fn read(file: &Path, text: &str) -> Result<Self, InputError> {
        let source = Document::new(file, text);
        let columns: Self = source.read()?;
        for (i, joint) in columns.joint.iter().enumerate() {
            let fault = |key, message: String, remedy: &str| {
                Err(source.error("trace-columns", &[Key("joint"), Item(i), Key(key)], message, remedy))
            };
            if joint.command.is_none() && joint.actual.is_none() {
                return fault("name", format!("joint {} has no column", joint.name), "state command, actual or both");
            }
            if joint.force.is_some() != joint.force_unit.is_some() {
                let key = if joint.force.is_some() { "force" } else { "force_unit" };
                return fault(key, "column and unit of the force come together".into(), "state force and force_unit");
            }
            for (key, value) in
                [("force_per_unit_N", joint.force_per_unit_n), ("torque_per_unit_Nm", joint.torque_per_unit_nm)]
            {
                let Some(value) = value else { continue };
                if !(value > 0.0 && value.is_finite()) {
                    return fault(key, format!("{value} cannot be"), "write a finite number above zero");
                }
                if !matches!(joint.force_unit, Some(ForceUnit::A | ForceUnit::Percent)) {
                    let remedy = "leave it out: the column is a force already, or there is none";
                    return fault(key, "it is for a current or a load alone".into(), remedy);
                }
            }
        }
        Ok(columns)
    }

    /// The columns of a header whose names say what they are.
    pub(crate) fn of_header(header: &[String], machine: &Machine) -> Result<Self, String> {
        let has = |name: &str| header.iter().any(|h| h == name).then(|| name.to_owned());
        let (time, time_unit) = match (has("time_s"), has("time_ms")) {
            (Some(name), _) => (name, TimeUnit::Second),
            (None, Some(name)) => (name, TimeUnit::Millisecond),
            (None, None) => return Err(format!("there is no column of the time; columns are {}", header.join(", "))),
        };
        let mut joint = Vec::new();
        for j in &machine.joints {
            let of = |what: &str| has(&format!("{}_{what}", j.name));
            let unit = if j.is_rotary() { PositionUnit::Degree } else { PositionUnit::Millimeter };
            let word = unit.scale().0;
            let (command, actual) = (of(&format!("command_{word}")), of(&format!("actual_{word}")));
            let forces = [
                ("force_N", ForceUnit::N),
                ("torque_Nm", ForceUnit::Nm),
                ("current_A", ForceUnit::A),
                ("load_percent", ForceUnit::Percent),
            ];
            let force = forces.into_iter().find_map(|(what, unit)| Some((of(what)?, unit)));
            if command.is_some() || actual.is_some() {
                let (force, force_unit) = force.unzip();
                joint.push(JointColumns {
                    name: j.name.clone(),
                    unit,
                    command,
                    actual,
                    force,
                    force_unit,
                    ..JointColumns::default()
                });
            }
        }
        if joint.is_empty() {
            let names: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
            return Err(format!(
                "no column is a position of a joint of {} ({}); columns are {}",
                machine.name,
                names.join(", "),
                header.join(", ")
            ));
        }
        Ok(Self { time, time_unit, block: has("block"), override_percent: has("override_percent"), joint })
    }

    /// What to do where the header does not say it.
    pub(crate) fn remedy() -> String {
        format!("name the columns in a file of --columns, or in the header: {OWN_NAMES}")
    }
}

impl JointColumns {
    /// The joint of the machine, where name and units fit it.
    pub(crate) fn joint_of<'m>(&self, machine: &'m Machine) -> Result<(usize, &'m Joint), String> {
        let Some((index, joint)) = machine.joints.iter().enumerate().find(|(_, j)| j.name == self.name) else {
            let names = machine.joints.iter().map(|j| j.name.as_str());
            let near = nearest(&self.name, names.clone()).map_or_else(String::new, |n| format!("; did you mean {n}?"));
            let all: Vec<&str> = names.collect();
            return Err(format!(
                "{} has no joint {:?}{near}; its joints are {}",
                machine.name,
                self.name,
                all.join(", ")
            ));
        };
        if self.unit.is_angle() != joint.is_rotary() {
            let kind = if joint.is_rotary() { "rotary" } else { "linear" };
            return Err(format!(
                "joint {} is {kind}, and its positions are stated in {}",
                joint.name,
                self.unit.scale().0
            ));
        }
        let of_force = match self.force_unit {
            Some(ForceUnit::N) => Some(false),
            Some(ForceUnit::Nm) => Some(true),
            _ if self.force_per_unit_n.is_some() => Some(false),
            _ if self.torque_per_unit_nm.is_some() => Some(true),
            _ => None,
        };
        if of_force.is_some_and(|rotary| rotary != joint.is_rotary()) {
            let (kind, unit) = if joint.is_rotary() { ("rotary", "Nm") } else { ("linear", "N") };
            return Err(format!("joint {} is {kind}: its motor is measured in {unit}", joint.name));
        }
        Ok((index, joint))
    }

    /// Factor of the force column to N or N mm; none where the unit is no force.
    pub(crate) fn force_factor(&self) -> Option<f64> {
        const N_MM_PER_N_M: f64 = 1e3;
        match self.force_unit? {
            ForceUnit::N => Some(1.0),
            ForceUnit::Nm => Some(N_MM_PER_N_M),
            ForceUnit::A | ForceUnit::Percent => {
                self.force_per_unit_n.or(self.torque_per_unit_nm.map(|t| t * N_MM_PER_N_M))
            }
        }
    }
}
