//! `[[platform]]` tables: their content and the checks on it.

use proveout_geom::Vector;
use proveout_input::{Document, Step, Step::Item, Step::Key};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    Joint, Leg, Platform,
    drive_file::DriveFile,
    drive_reader::read_drive,
    reading::{Checked, Notes, positive, unit},
};

/// Sine of the angle by which the directions of a platform may miss a right angle: six digits in a file.
const RIGHT_ANGLE_TOLERANCE: f64 = 1e-6;

/// Kinds of parallel sub-chains.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub(crate) enum PlatformKindFile {
    /// Three legs, each with hinge, slide and ball joint; heave and one tilt.
    #[serde(rename = "3-RPS")]
    ThreeRps,
}

/// A platform on three legs that moves a heave and a tilt joint together.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlatformFile {
    /// Name.
    pub(crate) name: String,
    /// 3-RPS.
    #[expect(dead_code, reason = "there is one kind, which reading the word has checked")]
    pub(crate) kind: PlatformKindFile,
    /// Linear joint for the height of the moving plate; its direction points from the fixed to the moving
    /// plate.
    pub(crate) heave: String,
    /// Rotary joint on the heave joint for the tilt; its point is the middle of the moving joints' circle.
    pub(crate) tilt: String,
    /// Radius of the circle of the fixed joints.
    pub(crate) fixed_radius_mm: f64,
    /// Radius of the circle of the moving joints.
    pub(crate) moving_radius_mm: f64,
    /// Height of the moving circle over the fixed one with all joints at zero.
    pub(crate) height_mm: f64,
    /// Unit vector from the middle to leg 1, at right angles to heave and tilt. Legs 2 and 3 are at 120
    /// degrees.
    pub(crate) leg_1_direction: [f64; 3],
    /// The three legs; legs 2 and 3 move alike.
    #[serde(default)]
    pub(crate) leg: Vec<LegFile>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// One leg of a platform.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LegFile {
    /// Name, for tables and reports: L1.
    pub(crate) name: String,
    /// Shortest and longest distance of the leg's two joints.
    pub(crate) travel_mm: Option<[f64; 2]>,
    /// Highest velocity.
    pub(crate) max_velocity_mm_min: Option<f64>,
    /// Highest acceleration.
    pub(crate) max_acceleration_mm_s2: Option<f64>,
    /// Highest jerk.
    pub(crate) max_jerk_mm_s3: Option<f64>,
    /// Mass that the drive of the leg moves, along the leg; needed with a drive.
    pub(crate) moving_mass_kg: Option<f64>,
    /// The drive: needed where the axis dynamics are simulated. Keys of a linear joint.
    pub(crate) drive: Option<DriveFile>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// Reads all platforms.
pub(crate) fn read_platforms(
    source: &Document<'_>,
    files: &[PlatformFile],
    joints: &[Joint],
) -> Checked<Vec<Platform>> {
    let mut all: Vec<Platform> = Vec::new();
    for (i, file) in files.iter().enumerate() {
        let platform = read_platform(source, i, file, joints)?;
        let at = |key| [Key("platform"), Item(i), Key(key)];
        for (key, joint) in [("heave", platform.heave), ("tilt", platform.tilt)] {
            if all.iter().any(|p| p.heave == joint || p.tilt == joint) {
                let message = format!("joint {} belongs to another platform", joints[joint].name);
                let remedy = "give each platform its own two joints";
                return Err(source.error("machine-platform", &at(key), message, remedy));
            }
        }
        let taken = |name: &str| {
            joints.iter().any(|j| j.name == name) || all.iter().flat_map(|p| &p.legs).any(|l| l.name == name)
        };
        for (k, leg) in platform.legs.iter().enumerate() {
            if leg.name.is_empty() || taken(&leg.name) || platform.legs[..k].iter().any(|l| l.name == leg.name) {
                let path = [Key("platform"), Item(i), Key("leg"), Item(k), Key("name")];
                let message = format!("the leg's name {:?} is empty or taken", leg.name);
                return Err(source.error("machine-platform", &path, message, "give each leg its own name, L1"));
            }
        }
        all.push(platform);
    }
    Ok(all)
}

fn read_platform(source: &Document<'_>, index: usize, file: &PlatformFile, joints: &[Joint]) -> Checked<Platform> {
    let at = |key| [Key("platform"), Item(index), Key(key)];
    let find = |key, name: &str, rotary: bool| {
        let kind = if rotary { "rotary" } else { "linear" };
        match joints.iter().position(|j| j.name == name) {
            Some(j) if joints[j].is_rotary() == rotary => Ok(j),
            found => {
                let message = match found {
                    Some(_) => format!("joint {name} is not {kind}"),
                    None => format!("there is no joint {name:?}"),
                };
                let remedy = format!("name a {kind} joint of this file");
                Err(source.error("machine-platform", &at(key), message, remedy))
            }
        }
    };
    let heave = find("heave", &file.heave, false)?;
    let tilt = find("tilt", &file.tilt, true)?;
    if joints[tilt].parent != Some(heave) {
        let message = format!("the parent of the tilt joint {} is not the heave joint {}", file.tilt, file.heave);
        let remedy = format!("write parent = {:?} at joint {}", file.heave, file.tilt);
        return Err(source.error("machine-platform", &at("tilt"), message, remedy));
    }
    let leg_1_direction = unit(source, &at("leg_1_direction"), file.leg_1_direction)?;
    let (up, axis) = (joints[heave].direction, joints[tilt].direction);
    let across = |key, a: &Vector, b: &Vector, words: &str| {
        if a.dot(b).abs() <= RIGHT_ANGLE_TOLERANCE {
            return Ok(());
        }
        let angle = a.dot(b).clamp(-1.0, 1.0).acos().to_degrees();
        let message = format!("{words} are at {angle:.6} degrees to each other");
        Err(source.error("machine-platform", &at(key), message, "they must be at right angles"))
    };
    across("tilt", &up, &axis, "heave direction and tilt axis")?;
    across("leg_1_direction", &leg_1_direction, &up, "leg 1 and the heave direction")?;
    across("leg_1_direction", &leg_1_direction, &axis, "leg 1 and the tilt axis")?;
    let size = |key, value| -> Checked<f64> { Ok(positive(source, &at(key), Some(value))?.unwrap_or(value)) };
    if file.leg.len() != 3 {
        let message = format!("{} legs, and a 3-RPS platform has three", file.leg.len());
        return Err(source.error("machine-platform", &at("leg"), message, "write three [[platform.leg]] tables"));
    }
    let mut legs: [Leg; 3] = Default::default();
    for (k, (leg, from)) in legs.iter_mut().zip(&file.leg).enumerate() {
        *leg = read_leg(source, [Key("platform"), Item(index), Key("leg"), Item(k)], from)?;
    }
    if legs[1].drive != legs[2].drive || legs[1].moving_mass != legs[2].moving_mass {
        let path = [Key("platform"), Item(index), Key("leg"), Item(2), Key("drive")];
        let message = format!("the drives of legs {} and {} differ", legs[1].name, legs[2].name);
        let remedy =
            "legs 2 and 3 move alike: unequal drives would tilt the plate about a second axis, which is not simulated";
        return Err(source.error("machine-platform", &path, message, remedy));
    }
    for (key, joint) in [("heave", heave), ("tilt", tilt)] {
        if joints[joint].drive.is_some() || joints[joint].moving_inertia.is_some() {
            let message =
                format!("joint {} is moved by the legs and states a drive or a moved mass", joints[joint].name);
            let remedy = "state them at the legs: [platform.leg.drive], moving_mass_kg";
            return Err(source.error("machine-platform", &at(key), message, remedy));
        }
    }
    Ok(Platform {
        name: file.name.clone(),
        heave,
        tilt,
        fixed_radius: size("fixed_radius_mm", file.fixed_radius_mm)?,
        moving_radius: size("moving_radius_mm", file.moving_radius_mm)?,
        height: size("height_mm", file.height_mm)?,
        leg_1_direction,
        heave_sign: joints[heave].sense,
        // A turn about the axis raises what lies along (heave x axis).
        tilt_sign: joints[tilt].sense * up.cross(&axis).dot(&leg_1_direction).signum(),
        legs,
    })
}

fn read_leg(source: &Document<'_>, path: [Step<'_>; 4], file: &LegFile) -> Checked<Leg> {
    let at = |key| {
        let [a, b, c, d] = path;
        [a, b, c, d, Key(key)]
    };
    if let Some([low, high]) = file.travel_mm
        && !(low < high && low > 0.0 && high.is_finite())
    {
        let message = format!("leg lengths from {low} to {high} mm are impossible");
        let remedy = "write the shortest length, above zero, first";
        return Err(source.error("machine-limits-upside-down", &at("travel_mm"), message, remedy));
    }
    let drive = read_drive(source, &path, file.drive.as_ref(), false)?;
    let moving_mass = positive(source, &at("moving_mass_kg"), file.moving_mass_kg)?;
    if drive.is_some() && moving_mass.is_none() {
        let message = format!("the drive of leg {} moves an unknown mass", file.name);
        let remedy = "add moving_mass_kg to the leg: the share of the plate that it moves, seen along it";
        return Err(source.error("machine-platform", &at("moving_mass_kg"), message, remedy));
    }
    Ok(Leg {
        name: file.name.clone(),
        moving_mass,
        drive,
        travel: file.travel_mm,
        max_velocity: positive(source, &at("max_velocity_mm_min"), file.max_velocity_mm_min)?.map(|v| v / 60.0),
        max_acceleration: positive(source, &at("max_acceleration_mm_s2"), file.max_acceleration_mm_s2)?,
        max_jerk: positive(source, &at("max_jerk_mm_s3"), file.max_jerk_mm_s3)?,
    })
}
