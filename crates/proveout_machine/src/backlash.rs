//! Backlash and elasticity between motor and load, and on which side the position is measured.

use proveout_geom::rad;

use crate::{
    drive::{ElasticMode, Encoder},
    drive_file::{DriveFile, DriveKeys},
    reading::Checked,
    units::MM2_PER_M2,
};

/// What lies between the motor and the load.
pub(crate) struct Transmission {
    /// Whole lost motion, mm or radian.
    pub(crate) backlash: f64,
    pub(crate) encoder: Encoder,
    pub(crate) elastic: Option<ElasticMode>,
    pub(crate) motor_inertia: Option<f64>,
}

pub(crate) fn read_transmission(keys: &DriveKeys<'_>, f: &DriveFile) -> Checked<Transmission> {
    let (key, value) = keys.pick(("backlash_mm", f.backlash_mm), ("backlash_deg", f.backlash_deg));
    let backlash = keys.not_negative(key, value)? * if keys.rotary { rad(1.0) } else { 1.0 };
    let (motor_key, value) =
        keys.pick(("motor_mass_kg", f.motor_mass_kg), ("motor_inertia_kg_m2", f.motor_inertia_kg_m2));
    let motor_inertia = keys.above_zero(motor_key, value)?.map(|m| if keys.rotary { m * MM2_PER_M2 } else { m });
    let frequency = keys.above_zero("elastic_frequency_hz", f.elastic_frequency_hz)?;
    let elastic = match (frequency, f.elastic_damping) {
        (None, None) => None,
        (Some(frequency), Some(damping)) => Some(ElasticMode {
            frequency: frequency * std::f64::consts::TAU,
            damping: keys.bounded("elastic_damping", damping, 0.0, 1.0)?,
        }),
        _ => {
            let message = "an elastic mode has a frequency and a damping";
            let remedy = "give elastic_frequency_hz and elastic_damping, or neither";
            return Err(keys.fault("elastic_frequency_hz", message, remedy));
        }
    };
    if elastic.is_some() && motor_inertia.is_none() {
        let message = "an elastic mode needs the mass of the motor";
        return Err(keys.fault(motor_key, message, format!("add {motor_key}")));
    }
    let encoder = match f.encoder {
        Some(encoder) => encoder,
        None if backlash == 0.0 && elastic.is_none() => Encoder::Motor,
        None => {
            let message = "with backlash or an elastic mode, state where the position is measured";
            let remedy = "add encoder = \"motor\" or encoder = \"load\"";
            return Err(keys.fault("encoder", message, remedy));
        }
    };
    Ok(Transmission { backlash, encoder, elastic, motor_inertia })
}
