//! Limits of joints that a scene sets below those of its machine, as a control does with its axis data for one job.

use proveout_machine::{Joint, Machine};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{config::ConfigError, scene::Scene};

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

/// Lowers the limits of a machine to those of the scene.
///
/// # Errors
/// A joint that the machine does not have, a number in the unit of the other kind of joint, not above zero, or above the
/// limit of the machine.
pub(crate) fn limit_joints(scene: &Scene, machine: &mut Machine) -> Result<(), ConfigError> {
    for (name, limits) in &scene.file.control.joint_limits {
        let fault = |message: String, help: String| {
            ConfigError::file(&scene.path, format!("[control.joint_limits.{name}]: {message}"), help)
        };
        let Some(joint) = machine.joint(name) else {
            let names: Vec<&str> = machine.joints.iter().map(|j| j.name.as_str()).collect();
            return Err(fault(
                format!("{} has no joint {name:?}", machine.name),
                format!("its joints are {}", names.join(", ")),
            ));
        };
        limit(&mut machine.joints[joint], limits).map_err(|(message, help)| fault(message, help))?;
    }
    Ok(())
}

fn limit(joint: &mut Joint, limits: &JointLimitFile) -> Result<(), (String, String)> {
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
        return Err((format!("the joint is {kind} and {key} is not for it"), format!("write {}", keys.join(", "))));
    }
    let targets = [&mut joint.max_velocity, &mut joint.max_acceleration, &mut joint.max_jerk];
    for ((key, value, unit), target) in own.into_iter().zip(targets) {
        let Some(value) = value else { continue };
        let inside = value * unit;
        if !(value > 0.0 && value.is_finite()) {
            return Err((format!("{key} = {value} is no limit"), "write a number above 0".into()));
        }
        if let Some(most) = target.filter(|most| inside > *most * (1.0 + 1e-9)) {
            return Err((
                format!("{key} = {value} is above the machine's limit of {}", most / unit),
                "a scene can lower what a machine can do, not raise it; change machine.toml for another machine".into(),
            ));
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
    fn what_is_no_lower_limit_is_refused() {
        let machine = machine();
        let a = &machine.joints[machine.joint("A").expect("A")];
        for (text, word) in [
            ("max_velocity_mm_min = 600", "rotary"),
            ("max_velocity_deg_s = 0", "no limit"),
            ("max_acceleration_deg_s2 = nan", "no limit"),
            ("max_velocity_deg_s = 1e5", "above the machine's limit of 360"),
        ] {
            let (message, help) = limit(&mut a.clone(), &limits(text)).expect_err(text);
            assert!(message.contains(word) && !help.is_empty(), "{text}: {message}");
        }
    }
}
