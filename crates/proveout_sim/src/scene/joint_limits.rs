//! Limits of joints that a scene sets below those of its machine, as a control does with its axis data for
//! one job.

use proveout_input::{InputError, Step, Step::Key};
use proveout_machine::{Joint, Machine};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::Scene;

/// Part by which a limit may be above the machine's: rounding of its unit.
const ROUNDING: f64 = 1e-9;

/// Limits of one joint, in force for all programs of the scene; what is left out stays as the machine has it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointLimitFile {
    /// Linear joint: velocity, mm/min.
    pub max_velocity_mm_min: Option<f64>,
    /// Linear joint: acceleration, mm/s².
    pub max_acceleration_mm_s2: Option<f64>,
    /// Linear joint: jerk, mm/s³.
    pub max_jerk_mm_s3: Option<f64>,
    /// Rotary joint: velocity, degrees/s.
    pub max_velocity_deg_s: Option<f64>,
    /// Rotary joint: acceleration, degrees/s².
    pub max_acceleration_deg_s2: Option<f64>,
    /// Rotary joint: jerk, degrees/s³.
    pub max_jerk_deg_s3: Option<f64>,
    /// Where the numbers come from.
    pub source: String,
}

/// A limit of a joint that a scene sets; mm or degrees, seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChangedLimit {
    /// Name of the machine.
    pub machine: String,
    /// Name of the joint.
    pub joint: String,
    /// `velocity`, `acceleration` or `jerk`.
    pub quantity: String,
    /// Unit of both numbers.
    pub unit: String,
    /// Limit of the machine; null where none is stated.
    pub of_machine: Option<f64>,
    /// Limit of the scene, in force for all programs.
    pub of_scene: f64,
    /// Where the scene's number comes from.
    pub source: String,
}

/// Lowers the limits of a machine to those of the scene, and returns what was changed.
///
/// # Errors
/// A joint that the machine does not have, a number in the unit of the other kind of joint, not above zero,
/// or above the limit of the machine.
pub(crate) fn limit_joints(scene: &Scene, machine: &mut Machine) -> Result<Vec<ChangedLimit>, InputError> {
    let mut changed = Vec::new();
    for (name, limits) in &scene.file.control.joint_limits {
        let fault = |key: Option<&'static str>, message: String, help: String| {
            let path = [Key("control"), Key("joint_limits"), Key(name)];
            let path: Vec<Step<'_>> = path.into_iter().chain(key.map(Key)).collect();
            scene.error_at(&path, format!("[control.joint_limits.{name}]: {message}"), help)
        };
        let Some(joint) = machine.joint(name) else {
            let names: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
            return Err(fault(
                None,
                format!("{} has no joint {name:?}", machine.name),
                format!("its joints are {}", names.join(", ")),
            ));
        };
        let before = machine.joints[joint].clone();
        let lowered = limit(&mut machine.joints[joint], limits);
        lowered.map_err(|LimitFault { key, message, help }| fault(Some(key), message, help))?;
        changed.extend(changes(&before, &machine.joints[joint], limits, &machine.name));
    }
    Ok(changed)
}

/// The limits that a scene gives a joint, compared with those before.
fn changes(before: &Joint, after: &Joint, limits: &JointLimitFile, machine: &str) -> Vec<ChangedLimit> {
    let of = |j: &Joint| [j.max_velocity, j.max_acceleration, j.max_jerk];
    let given = if after.is_rotary() {
        [limits.max_velocity_deg_s, limits.max_acceleration_deg_s2, limits.max_jerk_deg_s3]
    } else {
        [limits.max_velocity_mm_min, limits.max_acceleration_mm_s2, limits.max_jerk_mm_s3]
    };
    let factor = after.kind.unit_factor();
    let rows = [("velocity", "s"), ("acceleration", "s²"), ("jerk", "s³")].into_iter().zip(given).zip(of(before));
    rows.zip(of(after))
        .filter_map(|((((quantity, per), given), own), now)| {
            given?;
            Some(ChangedLimit {
                machine: machine.to_owned(),
                joint: after.name.clone(),
                quantity: quantity.to_owned(),
                unit: format!("{}/{per}", after.kind.unit()),
                of_machine: own.map(|v| rounded(v * factor)),
                of_scene: rounded(now? * factor),
                source: limits.source.clone(),
            })
        })
        .collect()
}

/// Without the noise of the way into radian and back: twelve digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// What is wrong with a limit of the scene.
#[derive(Debug)]
struct LimitFault {
    key: &'static str,
    message: String,
    help: String,
}

fn limit(joint: &mut Joint, limits: &JointLimitFile) -> Result<(), LimitFault> {
    let degrees = std::f64::consts::PI / 180.0;
    let linear = [
        ("max_velocity_mm_min", limits.max_velocity_mm_min, 1.0 / 60.0),
        ("max_acceleration_mm_s2", limits.max_acceleration_mm_s2, 1.0),
        ("max_jerk_mm_s3", limits.max_jerk_mm_s3, 1.0),
    ];
    let rotary = [
        ("max_velocity_deg_s", limits.max_velocity_deg_s, degrees),
        ("max_acceleration_deg_s2", limits.max_acceleration_deg_s2, degrees),
        ("max_jerk_deg_s3", limits.max_jerk_deg_s3, degrees),
    ];
    let (own, other) = if joint.is_rotary() { (rotary, linear) } else { (linear, rotary) };
    if let Some((key, ..)) = other.iter().find(|(_, value, _)| value.is_some()) {
        let kind = if joint.is_rotary() { "rotary" } else { "linear" };
        let keys: Vec<&str> = own.iter().map(|(key, ..)| *key).collect();
        let message = format!("{key} does not apply: the joint is {kind}");
        return Err(LimitFault { key, message, help: format!("write {}", keys.join(", ")) });
    }
    let targets = [&mut joint.max_velocity, &mut joint.max_acceleration, &mut joint.max_jerk];
    for ((key, value, unit), target) in own.into_iter().zip(targets) {
        let Some(value) = value else { continue };
        let inside = value * unit;
        if !(value > 0.0 && value.is_finite()) {
            let message = format!("{key} = {value} is not a limit");
            return Err(LimitFault { key, message, help: "write a number above 0".into() });
        }
        if let Some(most) = target.filter(|most| inside > *most * (1.0 + ROUNDING)) {
            let message = format!("{key} = {value} is above the machine's limit of {}", most / unit);
            let help = "a scene can lower what a machine can do, not raise it; change machine.toml for another machine";
            return Err(LimitFault { key, message, help: help.into() });
        }
        *target = Some(inside);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn machine() -> Machine {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/starrag-lx-451");
        Machine::read(&folder).expect("library machine")
    }

    fn limits(text: &str) -> JointLimitFile {
        toml::from_str(&format!("source = \"test\"\n{text}")).expect("limits")
    }

    #[test]
    fn limits_are_lowered_in_the_unit_of_the_joint() {
        let machine = machine();
        let mut a = machine.joints[machine.joint("A").expect("A")].clone();
        limit(&mut a, &limits("max_velocity_deg_s = 90\nmax_jerk_deg_s3 = 9000")).expect("lower");
        assert!((a.max_velocity.expect("a limit") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((a.max_jerk.expect("a limit") - 50.0 * std::f64::consts::PI).abs() < 1e-9);
        let untouched = &machine.joints[machine.joint("A").expect("A")];
        assert_eq!(a.max_acceleration, untouched.max_acceleration, "left out: as the machine has it");
        let mut x = machine.joints[machine.joint("X").expect("X")].clone();
        limit(&mut x, &limits("max_velocity_mm_min = 600")).expect("lower");
        assert_eq!(x.max_velocity, Some(10.0));
    }

    #[test]
    fn what_a_scene_changes_stands_beside_the_limit_of_the_machine() {
        let machine = machine();
        let before = &machine.joints[machine.joint("A").expect("A")];
        let mut after = before.clone();
        let file = limits("max_velocity_deg_s = 62.4\nmax_jerk_deg_s3 = 28_400");
        limit(&mut after, &file).expect("lower");
        let changed = changes(before, &after, &file, "M");
        let rows: Vec<_> =
            changed.iter().map(|c| (c.quantity.as_str(), c.unit.as_str(), c.of_machine, c.of_scene)).collect();
        assert_eq!(rows, [("velocity", "deg/s", Some(360.0), 62.4), ("jerk", "deg/s³", Some(90_000.0), 28_400.0)]);
        let x = &machine.joints[machine.joint("X").expect("X")];
        let (mut free, file) = (Joint { max_velocity: None, ..x.clone() }, limits("max_velocity_mm_min = 600"));
        let own = free.clone();
        limit(&mut free, &file).expect("lower");
        let changed = changes(&own, &free, &file, "M");
        assert_eq!((changed[0].unit.as_str(), changed[0].of_machine, changed[0].of_scene), ("mm/s", None, 10.0));
    }

    #[test]
    fn what_is_no_lower_limit_is_refused() {
        let machine = machine();
        let a = &machine.joints[machine.joint("A").expect("A")];
        for (text, word) in [
            ("max_velocity_mm_min = 600", "rotary"),
            ("max_velocity_deg_s = 0", "not a limit"),
            ("max_acceleration_deg_s2 = nan", "not a limit"),
            ("max_velocity_deg_s = 1e5", "above the machine's limit of 360"),
        ] {
            let LimitFault { message, help, .. } = limit(&mut a.clone(), &limits(text)).expect_err(text);
            assert!(message.contains(word) && !help.is_empty(), "{text}: {message}");
        }
    }
}
