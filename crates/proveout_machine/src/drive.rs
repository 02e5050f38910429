//! What is known of a joint's drive: loop gains, friction, backlash, elasticity, force limit; `[joint.drive]`.
//!
//! ```text
//!              Kv              Kp, Tn           F max
//!   set ──►( )──►( )──────►( )───────►( )─────►[ / ]──► motor mass ──┤backlash├──spring, damper── load mass
//!    │      ▲     ▲ feed    ▲          ▲ feed                 │                                      │ friction
//!    │      │     │ forward └──────────┼──── motor encoder ◄──┤                                      │
//!    └──────┼─────┴────────────────────┘                      │ encoder = "motor"                    │
//!           └─────────────────────────────────────────────────┴───────────── encoder = "load" ◄──────┘
//! ```
//!
//! Linear joints are described in N, kg and mm, rotary joints in Nm, kg m² and degrees; all seen at the joint, with gears
//! and screws taken out. Inside, forces are in N and torques in N mm.

use proveout_geom::{Document, Step, Step::Key, rad};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    assemble::Checked,
    units::{MM2_PER_M2, N_MM_PER_N_M, N_S_MM_PER_N_S_M, S_PER_MS},
};

/// Gains of the position, 1/s. One kilohertz is beyond every drive: a slip of the unit would pass for a very stiff axis.
const LEAST_GAIN: f64 = 1e-3;
const MOST_GAIN: f64 = 1e3;

/// The drive of one joint, as the file states it. What is left out is not there: no integral part, no feed-forward, no
/// friction, no backlash, no elasticity, no limit of the force.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DriveFile {
    /// Gain of the position loop Kv, 1/s: commanded velocity over position error (1 m/min per mm is 16.67 1/s).
    pub(crate) position_gain_1_s: f64,
    /// Gain of the velocity loop of a linear joint.
    #[serde(rename = "velocity_gain_N_s_m")]
    pub(crate) velocity_gain_n_s_m: Option<f64>,
    /// Gain of the velocity loop of a rotary joint.
    #[serde(rename = "velocity_gain_Nm_s_rad")]
    pub(crate) velocity_gain_nm_s_rad: Option<f64>,
    /// Instead of the gain: its quotient with the moved mass over 2 pi.
    pub(crate) velocity_bandwidth_hz: Option<f64>,
    /// Integral time Tn of the velocity loop; without it the loop is proportional.
    pub(crate) integral_time_ms: Option<f64>,
    /// Part of the commanded velocity that is added after the position loop, 0 to 1.
    #[serde(default)]
    pub(crate) velocity_feed_forward: f64,
    /// Part of the force for the commanded acceleration that is added after the velocity loop, 0 to 1.
    #[serde(default)]
    pub(crate) acceleration_feed_forward: f64,
    /// Highest force of a linear drive.
    #[serde(rename = "max_force_N")]
    pub(crate) max_force_n: Option<f64>,
    /// Highest torque of a rotary drive.
    #[serde(rename = "max_torque_Nm")]
    pub(crate) max_torque_nm: Option<f64>,
    /// Friction of a linear joint in proportion to its velocity.
    #[serde(rename = "viscous_friction_N_s_m")]
    pub(crate) viscous_friction_n_s_m: Option<f64>,
    /// Friction of a rotary joint in proportion to its velocity.
    #[serde(rename = "viscous_friction_Nm_s_rad")]
    pub(crate) viscous_friction_nm_s_rad: Option<f64>,
    /// Dry friction of a moving linear joint.
    #[serde(rename = "coulomb_friction_N")]
    pub(crate) coulomb_friction_n: Option<f64>,
    /// Dry friction of a moving rotary joint.
    #[serde(rename = "coulomb_friction_Nm")]
    pub(crate) coulomb_friction_nm: Option<f64>,
    /// Friction at which a linear joint breaks away; as the dry friction when left out.
    #[serde(rename = "static_friction_N")]
    pub(crate) static_friction_n: Option<f64>,
    /// Friction at which a rotary joint breaks away; as the dry friction when left out.
    #[serde(rename = "static_friction_Nm")]
    pub(crate) static_friction_nm: Option<f64>,
    /// Velocity at which the friction has come down from the static to the dry one by the part 1 - 1/e.
    pub(crate) stribeck_velocity_mm_min: Option<f64>,
    /// The same for a rotary joint.
    pub(crate) stribeck_velocity_deg_s: Option<f64>,
    /// Lost motion between motor and load of a linear joint.
    pub(crate) backlash_mm: Option<f64>,
    /// Lost motion between motor and load of a rotary joint.
    pub(crate) backlash_deg: Option<f64>,
    /// Where the position is measured: motor (before backlash and elasticity) or load (a scale on the load side).
    /// Required with backlash or elasticity.
    pub(crate) encoder: Option<EncoderFile>,
    /// Natural frequency of the load on the held motor.
    pub(crate) elastic_frequency_hz: Option<f64>,
    /// Damping ratio of that oscillation, 0 to 1; required together with the frequency.
    pub(crate) elastic_damping: Option<f64>,
    /// Motor, screw and gear of a linear joint, as a mass at the joint; required together with the elastic frequency.
    /// Moves in addition to the mass of the joint.
    pub(crate) motor_mass_kg: Option<f64>,
    /// Motor and gear of a rotary joint, as an inertia at the joint.
    pub(crate) motor_inertia_kg_m2: Option<f64>,
    /// Constant force of a weight compensation, positive in the direction of growing values.
    #[serde(default)]
    #[serde(rename = "counterbalance_N")]
    pub(crate) counterbalance_n: f64,
}

/// Place of the position encoder.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum EncoderFile {
    /// On the motor, before backlash and elasticity.
    Motor,
    /// On the load side: scale or ring encoder.
    Load,
}

/// Where the position loop measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoder {
    /// On the motor, before backlash and elasticity.
    Motor,
    /// On the load, after backlash and elasticity.
    Load,
}

/// Proportional gain of a velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocityGain {
    /// N s/mm or N mm s/rad.
    Gain(f64),
    /// The gain over the moved mass (inertia), 1/s.
    Bandwidth(f64),
}

/// One oscillation between motor and load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticMode {
    /// Natural frequency of the load on the held motor, rad/s.
    pub frequency: f64,
    /// Damping ratio.
    pub damping: f64,
}

/// Data of a joint's drive, seen at the joint. Forces in N, torques in N mm, masses in kg, inertias in kg mm²; mm,
/// radian, second.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Kv, 1/s.
    pub position_gain: f64,
    /// Gain of the velocity loop.
    pub velocity_gain: VelocityGain,
    /// Tn, s; none: a proportional loop.
    pub integral_time: Option<f64>,
    /// Part of the commanded velocity that is fed forward.
    pub velocity_feed_forward: f64,
    /// Part of mass times commanded acceleration that is fed forward.
    pub acceleration_feed_forward: f64,
    /// Highest force or torque of the motor; none: not stated.
    pub max_force: Option<f64>,
    /// N s/mm or N mm s/rad.
    pub viscous_friction: f64,
    /// N or N mm.
    pub coulomb_friction: f64,
    /// N or N mm, not below the dry friction.
    pub static_friction: f64,
    /// mm/s or rad/s; zero where static and dry friction are equal.
    pub stribeck_velocity: f64,
    /// Whole lost motion, mm or radian.
    pub backlash: f64,
    /// Place of the position encoder.
    pub encoder: Encoder,
    /// Elasticity between motor and load; none: stiff.
    pub elastic: Option<ElasticMode>,
    /// Mass or inertia of the motor, which moves in addition to the load.
    pub motor_inertia: Option<f64>,
    /// Constant force of a weight compensation, N.
    pub counterbalance: f64,
}

/// Checks the drive of the joint or leg whose table is at `owner` and converts it to internal units.
pub(crate) fn read_drive(
    source: &Document<'_>,
    owner: &[Step<'_>],
    file: Option<&DriveFile>,
    rotary: bool,
) -> Checked<Option<Drive>> {
    let Some(f) = file else { return Ok(None) };
    let at = |key: &'static str| place(owner, key);
    check_units(source, owner, f, rotary)?;
    let bounded = |key: &'static str, value: f64, low: f64, high: f64| -> Checked<f64> {
        if value >= low && value <= high {
            return Ok(value);
        }
        let message = format!("{value} is not between {low} and {high}");
        Err(source.error("machine-drive", &at(key), message, "correct the number, or leave the key out"))
    };
    let above_zero = |key: &'static str, value: Option<f64>| -> Checked<Option<f64>> {
        match value {
            Some(v) if !(v > 0.0 && v.is_finite()) => {
                let remedy = "write a finite number above zero, or leave the key out where the value is not known";
                Err(source.error("machine-not-positive", &at(key), format!("{v} cannot be"), remedy))
            }
            v => Ok(v),
        }
    };
    let not_negative =
        |key: &'static str, value: Option<f64>| -> Checked<f64> { bounded(key, value.unwrap_or(0.0), 0.0, f64::MAX) };
    // Per kind: keys, and the factors to N or N mm, mm or radian. N s/m and Nm s/rad turn into N s/mm and N mm s/rad.
    let pick = |linear: (&'static str, Option<f64>), turning: (&'static str, Option<f64>)| {
        if rotary { turning } else { linear }
    };
    let force = if rotary { N_MM_PER_N_M } else { 1.0 };
    let damping = if rotary { N_MM_PER_N_M } else { N_S_MM_PER_N_S_M };
    let speed = if rotary { rad(1.0) } else { 1.0 / 60.0 };

    let (key, value) =
        pick(("velocity_gain_N_s_m", f.velocity_gain_n_s_m), ("velocity_gain_Nm_s_rad", f.velocity_gain_nm_s_rad));
    let gain = above_zero(key, value)?;
    let bandwidth = above_zero("velocity_bandwidth_hz", f.velocity_bandwidth_hz)?;
    let velocity_gain = match (gain, bandwidth) {
        (Some(g), None) => VelocityGain::Gain(g * damping),
        (None, Some(b)) => VelocityGain::Bandwidth(b * std::f64::consts::TAU),
        _ => {
            let message = "the gain of the velocity loop must be given exactly once";
            let remedy = format!("give {key} or velocity_bandwidth_hz, and not both");
            return Err(source.error("machine-drive", &at(key), message, remedy));
        }
    };
    let (key, value) =
        pick(("coulomb_friction_N", f.coulomb_friction_n), ("coulomb_friction_Nm", f.coulomb_friction_nm));
    let coulomb_friction = not_negative(key, value)? * force;
    let (key, value) = pick(("static_friction_N", f.static_friction_n), ("static_friction_Nm", f.static_friction_nm));
    let static_friction = above_zero(key, value)?.map_or(coulomb_friction, |s| s * force);
    if static_friction < coulomb_friction {
        let message = format!("the static friction {static_friction} is below the dry friction {coulomb_friction}");
        return Err(source.error(
            "machine-drive",
            &at(key),
            message,
            "give at least the dry friction, or leave it out",
        ));
    }
    let (key, value) = pick(
        ("stribeck_velocity_mm_min", f.stribeck_velocity_mm_min),
        ("stribeck_velocity_deg_s", f.stribeck_velocity_deg_s),
    );
    let stribeck_velocity = above_zero(key, value)?.map_or(0.0, |v| v * speed);
    if static_friction > coulomb_friction && stribeck_velocity == 0.0 {
        let message = "static and dry friction differ, but the velocity between them is not stated";
        return Err(source.error("machine-drive", &at(key), message, format!("add {key}")));
    }
    let (key, value) = pick(("backlash_mm", f.backlash_mm), ("backlash_deg", f.backlash_deg));
    let backlash = not_negative(key, value)? * if rotary { rad(1.0) } else { 1.0 };
    let (motor_key, value) = pick(("motor_mass_kg", f.motor_mass_kg), ("motor_inertia_kg_m2", f.motor_inertia_kg_m2));
    let motor_inertia = above_zero(motor_key, value)?.map(|m| if rotary { m * MM2_PER_M2 } else { m });
    let frequency = above_zero("elastic_frequency_hz", f.elastic_frequency_hz)?;
    let elastic = match (frequency, f.elastic_damping) {
        (None, None) => None,
        (Some(frequency), Some(damping)) => Some(ElasticMode {
            frequency: frequency * std::f64::consts::TAU,
            damping: bounded("elastic_damping", damping, 0.0, 1.0)?,
        }),
        _ => {
            let message = "an elastic mode has a frequency and a damping";
            let remedy = "give elastic_frequency_hz and elastic_damping, or neither";
            return Err(source.error("machine-drive", &at("elastic_frequency_hz"), message, remedy));
        }
    };
    if elastic.is_some() && motor_inertia.is_none() {
        let message = "an elastic mode needs the mass of the motor";
        return Err(source.error("machine-drive", &at(motor_key), message, format!("add {motor_key}")));
    }
    let encoder = match f.encoder {
        Some(EncoderFile::Motor) => Encoder::Motor,
        Some(EncoderFile::Load) => Encoder::Load,
        None if backlash == 0.0 && elastic.is_none() => Encoder::Motor,
        None => {
            let message = "with backlash or an elastic mode, state where the position is measured";
            let remedy = "add encoder = \"motor\" or encoder = \"load\"";
            return Err(source.error("machine-drive", &at("encoder"), message, remedy));
        }
    };
    let (key, value) = pick(("max_force_N", f.max_force_n), ("max_torque_Nm", f.max_torque_nm));
    let max_force = above_zero(key, value)?.map(|m| m * force);
    let (key, value) = pick(
        ("viscous_friction_N_s_m", f.viscous_friction_n_s_m),
        ("viscous_friction_Nm_s_rad", f.viscous_friction_nm_s_rad),
    );
    let viscous_friction = not_negative(key, value)? * damping;
    let position_gain = bounded("position_gain_1_s", f.position_gain_1_s, LEAST_GAIN, MOST_GAIN)?;
    Ok(Some(Drive {
        position_gain,
        velocity_gain,
        integral_time: above_zero("integral_time_ms", f.integral_time_ms)?.map(|t| t * S_PER_MS),
        velocity_feed_forward: bounded("velocity_feed_forward", f.velocity_feed_forward, 0.0, 1.0)?,
        acceleration_feed_forward: bounded("acceleration_feed_forward", f.acceleration_feed_forward, 0.0, 1.0)?,
        max_force,
        viscous_friction,
        coulomb_friction,
        static_friction,
        stribeck_velocity,
        backlash,
        encoder,
        elastic,
        motor_inertia,
        counterbalance: bounded("counterbalance_N", f.counterbalance_n, -f64::MAX, f64::MAX)?,
    }))
}

/// Path of a key of a drive.
fn place<'a>(owner: &[Step<'a>], key: &'a str) -> Vec<Step<'a>> {
    owner.iter().copied().chain([Key("drive"), Key(key)]).collect()
}

/// Refuses keys with the unit of the other kind of joint.
fn check_units(source: &Document<'_>, owner: &[Step<'_>], f: &DriveFile, rotary: bool) -> Checked<()> {
    let pairs = [
        ("velocity_gain_N_s_m", f.velocity_gain_n_s_m, "velocity_gain_Nm_s_rad", f.velocity_gain_nm_s_rad),
        ("max_force_N", f.max_force_n, "max_torque_Nm", f.max_torque_nm),
        ("viscous_friction_N_s_m", f.viscous_friction_n_s_m, "viscous_friction_Nm_s_rad", f.viscous_friction_nm_s_rad),
        ("coulomb_friction_N", f.coulomb_friction_n, "coulomb_friction_Nm", f.coulomb_friction_nm),
        ("static_friction_N", f.static_friction_n, "static_friction_Nm", f.static_friction_nm),
        ("stribeck_velocity_mm_min", f.stribeck_velocity_mm_min, "stribeck_velocity_deg_s", f.stribeck_velocity_deg_s),
        ("backlash_mm", f.backlash_mm, "backlash_deg", f.backlash_deg),
        ("motor_mass_kg", f.motor_mass_kg, "motor_inertia_kg_m2", f.motor_inertia_kg_m2),
    ];
    let kind = if rotary { "rotary" } else { "linear" };
    for (linear, of_linear, turning, of_rotary) in pairs {
        let (wrong, given, instead) = if rotary { (linear, of_linear, turning) } else { (turning, of_rotary, linear) };
        if given.is_some() {
            let path = place(owner, wrong);
            let message = format!("a {kind} joint has no {wrong}");
            return Err(source.error("machine-wrong-unit", &path, message, format!("write {instead}")));
        }
    }
    if rotary && f.counterbalance_n != 0.0 {
        let path = place(owner, "counterbalance_N");
        let message = "a rotary joint has no counterbalance_N";
        return Err(source.error("machine-wrong-unit", &path, message, "leave it out"));
    }
    Ok(())
}
