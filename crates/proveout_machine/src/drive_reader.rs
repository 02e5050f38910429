//! Reads `[joint.drive]`, and converts it to internal units.

use proveout_input::{Document, Step};

use crate::{
    backlash::{Transmission, read_transmission},
    drive::{Drive, VelocityGain},
    drive_file::{DriveFile, DriveKeys, check_units},
    friction::{read_dry_friction, read_viscous_friction},
    reading::Checked,
    units::S_PER_MS,
};

/// Gains of the position, 1/s. One kilohertz is beyond every drive: a slip of the unit would pass for a very
/// stiff axis.
const LEAST_GAIN: f64 = 1e-3;
const MOST_GAIN: f64 = 1e3;

/// Checks the drive of the joint or leg whose table is at `owner` and converts it to internal units.
pub(crate) fn read_drive(
    source: &Document<'_>,
    owner: &[Step<'_>],
    file: Option<&DriveFile>,
    rotary: bool,
) -> Checked<Option<Drive>> {
    let Some(f) = file else { return Ok(None) };
    check_units(source, owner, f, rotary)?;
    let keys = DriveKeys { source, owner, rotary };
    let (key, value) =
        keys.pick(("velocity_gain_N_s_m", f.velocity_gain_n_s_m), ("velocity_gain_Nm_s_rad", f.velocity_gain_nm_s_rad));
    let gain = keys.above_zero(key, value)?;
    let bandwidth = keys.above_zero("velocity_bandwidth_hz", f.velocity_bandwidth_hz)?;
    let velocity_gain = match (gain, bandwidth) {
        (Some(g), None) => VelocityGain::Gain(g * keys.damping()),
        (None, Some(b)) => VelocityGain::Bandwidth(b * std::f64::consts::TAU),
        _ => {
            let message = "the gain of the velocity loop must be given exactly once";
            let remedy = format!("give {key} or velocity_bandwidth_hz, and not both");
            return Err(keys.fault(key, message, remedy));
        }
    };
    let friction = read_dry_friction(&keys, f)?;
    let Transmission { backlash, encoder, elastic, motor_inertia } = read_transmission(&keys, f)?;
    let (key, value) = keys.pick(("max_force_N", f.max_force_n), ("max_torque_Nm", f.max_torque_nm));
    let max_force = keys.above_zero(key, value)?.map(|m| m * keys.force());
    let viscous_friction = read_viscous_friction(&keys, f)?;
    let position_gain = keys.bounded("position_gain_1_s", f.position_gain_1_s, LEAST_GAIN, MOST_GAIN)?;
    Ok(Some(Drive {
        position_gain,
        velocity_gain,
        integral_time: keys.above_zero("integral_time_ms", f.integral_time_ms)?.map(|t| t * S_PER_MS),
        velocity_feed_forward: keys.bounded("velocity_feed_forward", f.velocity_feed_forward, 0.0, 1.0)?,
        acceleration_feed_forward: keys.bounded("acceleration_feed_forward", f.acceleration_feed_forward, 0.0, 1.0)?,
        max_force,
        viscous_friction,
        coulomb_friction: friction.coulomb,
        static_friction: friction.breakaway,
        stribeck_velocity: friction.stribeck_velocity,
        backlash,
        encoder,
        elastic,
        motor_inertia,
        counterbalance: keys.bounded("counterbalance_N", f.counterbalance_n, -f64::MAX, f64::MAX)?,
    }))
}
