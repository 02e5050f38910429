//! Friction of a drive: dry, static and viscous.

use proveout_geom::rad;

use crate::{
    drive_file::{DriveFile, DriveKeys},
    reading::Checked,
};

/// Friction that does not grow with the velocity.
pub(crate) struct DryFriction {
    pub(crate) coulomb: f64,
    /// Not below the dry friction.
    pub(crate) breakaway: f64,
    /// mm/s or rad/s; zero where both are equal.
    pub(crate) stribeck_velocity: f64,
}

pub(crate) fn read_dry_friction(keys: &DriveKeys<'_>, f: &DriveFile) -> Checked<DryFriction> {
    let speed = if keys.rotary { rad(1.0) } else { 1.0 / 60.0 };
    let (key, value) =
        keys.pick(("coulomb_friction_N", f.coulomb_friction_n), ("coulomb_friction_Nm", f.coulomb_friction_nm));
    let coulomb_friction = keys.not_negative(key, value)? * keys.force();
    let (key, value) =
        keys.pick(("static_friction_N", f.static_friction_n), ("static_friction_Nm", f.static_friction_nm));
    let static_friction = keys.above_zero(key, value)?.map_or(coulomb_friction, |s| s * keys.force());
    if static_friction < coulomb_friction {
        let message = format!("the static friction {static_friction} is below the dry friction {coulomb_friction}");
        return Err(keys.fault(key, message, "give at least the dry friction, or leave it out"));
    }
    let (key, value) = keys.pick(
        ("stribeck_velocity_mm_min", f.stribeck_velocity_mm_min),
        ("stribeck_velocity_deg_s", f.stribeck_velocity_deg_s),
    );
    let stribeck_velocity = keys.above_zero(key, value)?.map_or(0.0, |v| v * speed);
    if static_friction > coulomb_friction && stribeck_velocity == 0.0 {
        let message = "static and dry friction differ, but the velocity between them is not stated";
        return Err(keys.fault(key, message, format!("add {key}")));
    }
    Ok(DryFriction { coulomb: coulomb_friction, breakaway: static_friction, stribeck_velocity })
}

/// Friction in proportion to the velocity, N s/mm or N mm s/rad.
pub(crate) fn read_viscous_friction(keys: &DriveKeys<'_>, f: &DriveFile) -> Checked<f64> {
    let (key, value) = keys.pick(
        ("viscous_friction_N_s_m", f.viscous_friction_n_s_m),
        ("viscous_friction_Nm_s_rad", f.viscous_friction_nm_s_rad),
    );
    Ok(keys.not_negative(key, value)? * keys.damping())
}
