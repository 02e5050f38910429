//! `[joint.drive]` as written, and the checks of its keys.

use proveout_input::{Document, InputError, Step, Step::Key};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    Encoder,
    reading::{Checked, positive},
    units::{N_MM_PER_N_M, N_S_MM_PER_N_S_M},
};

/// The drive of one joint, as the file states it. What is left out is not there: no integral part, no
/// feed-forward, no friction, no backlash, no elasticity, no limit of the force.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DriveFile {
    /// Gain of the position loop Kv, 1/s: commanded velocity over position error (1 m/min per mm is 16.67
    /// 1/s).
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
    /// Where the position is measured: motor (before backlash and elasticity) or load (a scale on the load
    /// side). Required with backlash or elasticity.
    pub(crate) encoder: Option<Encoder>,
    /// Natural frequency of the load on the held motor.
    pub(crate) elastic_frequency_hz: Option<f64>,
    /// Damping ratio of that oscillation, 0 to 1; required together with the frequency.
    pub(crate) elastic_damping: Option<f64>,
    /// Motor, screw and gear of a linear joint, as a mass at the joint; required together with the elastic
    /// frequency. Moves in addition to the mass of the joint.
    pub(crate) motor_mass_kg: Option<f64>,
    /// Motor and gear of a rotary joint, as an inertia at the joint.
    pub(crate) motor_inertia_kg_m2: Option<f64>,
    /// Constant force of a weight compensation, positive in the direction of growing values.
    #[serde(default)]
    #[serde(rename = "counterbalance_N")]
    pub(crate) counterbalance_n: f64,
}

/// Key of a linear joint with its value, and that of a rotary one.
type OfKind = (&'static str, Option<f64>);

/// The keys of one drive with the checks of their values.
pub(crate) struct DriveKeys<'a> {
    pub(crate) source: &'a Document<'a>,
    pub(crate) owner: &'a [Step<'a>],
    pub(crate) rotary: bool,
}

impl DriveKeys<'_> {
    /// A fault of a key.
    pub(crate) fn fault(&self, key: &'static str, message: impl Into<String>, remedy: impl Into<String>) -> InputError {
        self.source.error("machine-drive", &place(self.owner, key), message, remedy)
    }

    /// The key and value of this kind of joint.
    pub(crate) fn pick(&self, linear: OfKind, turning: OfKind) -> OfKind {
        if self.rotary { turning } else { linear }
    }

    pub(crate) fn bounded(&self, key: &'static str, value: f64, low: f64, high: f64) -> Checked<f64> {
        if value >= low && value <= high {
            return Ok(value);
        }
        let message = format!("{value} is not between {low} and {high}");
        Err(self.fault(key, message, "correct the number, or leave the key out"))
    }

    pub(crate) fn above_zero(&self, key: &'static str, value: Option<f64>) -> Checked<Option<f64>> {
        positive(self.source, &place(self.owner, key), value)
    }

    pub(crate) fn not_negative(&self, key: &'static str, value: Option<f64>) -> Checked<f64> {
        self.bounded(key, value.unwrap_or(0.0), 0.0, f64::MAX)
    }

    /// Factor to N or N mm.
    pub(crate) fn force(&self) -> f64 {
        if self.rotary { N_MM_PER_N_M } else { 1.0 }
    }

    /// Factor from N s/m and Nm s/rad to N s/mm and N mm s/rad.
    pub(crate) fn damping(&self) -> f64 {
        if self.rotary { N_MM_PER_N_M } else { N_S_MM_PER_N_S_M }
    }
}

/// Path of a key of a drive.
fn place<'a>(owner: &[Step<'a>], key: &'a str) -> Vec<Step<'a>> {
    owner.iter().copied().chain([Key("drive"), Key(key)]).collect()
}

/// Refuses keys with the unit of the other kind of joint.
pub(crate) fn check_units(source: &Document<'_>, owner: &[Step<'_>], f: &DriveFile, rotary: bool) -> Checked<()> {
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
