//! One `[[joint]]` table: units by kind, required keys, limits that agree.

use proveout_geom::{Point, rad};
use proveout_input::{Document, Step::Item, Step::Key};

use crate::{
    Attachment, Joint, JointKind,
    attachment::attachment,
    description::JointFile,
    drive_reader::read_drive,
    reading::{Checked, finite_vector, positive, unit},
    units::MM2_PER_M2,
};

/// Part by which a rapid may be above the highest velocity: rounding of its unit.
const ROUNDING: f64 = 1e-12;

pub(crate) fn read_joint(source: &Document<'_>, index: usize, file: &JointFile, all: &[JointFile]) -> Checked<Joint> {
    let at = |key| [Key("joint"), Item(index), Key(key)];
    if file.name == "base" || file.name.is_empty() {
        let message = format!("a joint cannot have the name {:?}", file.name);
        return Err(source.error("machine-joint-name", &at("name"), message, "name it by its letter, as programs do"));
    }
    let rotary = file.kind == JointKind::Rotary;
    check_units(source, index, file, rotary)?;
    let sense = match file.sense {
        Some(sense) if sense.abs() == 1.0 => sense,
        Some(sense) => {
            let message = format!("{sense} is not a valid sense");
            return Err(source.error("machine-sense", &at("sense"), message, "write 1 or -1"));
        }
        None if !rotary => 1.0,
        None => {
            let remedy = "write 1 when a growing value turns the carried body right-handed about the direction, else -1 \
                          (table axes after ISO 841)";
            return Err(source.error("machine-sense", &at("sense"), "a rotary joint must state its sense", remedy));
        }
    };
    let point = match file.point_mm {
        Some(p) => Point::from(finite_vector(source, &at("point_mm"), p)?),
        None if !rotary => Point::origin(),
        None => {
            let remedy = "add point_mm, any point on the axis in machine coordinates with all joints at zero";
            return Err(source.error("input-missing-key", &at("point_mm"), "the rotary axis has no place", remedy));
        }
    };
    let parent = match attachment(source, all, &at("parent"), &file.parent)? {
        Attachment::Base => None,
        Attachment::Joint(j) => Some(j),
    };
    let angle = |v: Option<f64>| v.map(rad);
    let travel = if rotary { file.travel_deg.map(|t| t.map(rad)) } else { file.travel_mm };
    let unit_word = if rotary { "degrees" } else { "mm" };
    let travel_key = if rotary { "travel_deg" } else { "travel_mm" };
    if let Some([low, high]) = travel
        && !(low < high && low.is_finite() && high.is_finite())
    {
        let [from, to] = if rotary { file.travel_deg } else { file.travel_mm }.unwrap_or([low, high]);
        let message = format!("travel {from} to {to} {unit_word}: the lower end must be below the upper end");
        return Err(source.error("machine-limits-upside-down", &at(travel_key), message, "write the lower end first"));
    }
    if file.endless && (!rotary || travel.is_some()) {
        let message = "`endless` together with end stops, or on a linear joint";
        let remedy = "an endless rotary joint has no travel; leave out one of the two";
        return Err(source.error("machine-endless", &at("endless"), message, remedy));
    }
    let home_key = if rotary { "home_deg" } else { "home_mm" };
    let stated_home = if rotary { angle(file.home_deg) } else { file.home_mm };
    let home = stated_home.unwrap_or(0.0);
    let tool_change_key = if rotary { "tool_change_deg" } else { "tool_change_mm" };
    let tool_change = if rotary { angle(file.tool_change_deg) } else { file.tool_change_mm };
    let joint = Joint {
        name: file.name.clone(),
        kind: file.kind,
        carries: file.carries,
        parent,
        direction: unit(source, &at("direction"), file.direction)?,
        point,
        turn_shift: None,
        sense,
        travel,
        endless: file.endless,
        held: file.held,
        max_velocity: velocity(
            source,
            index,
            [
                ("max_velocity_mm_min", file.max_velocity_mm_min),
                ("max_velocity_deg_s", file.max_velocity_deg_s),
                ("max_velocity_rev_min", file.max_velocity_rev_min),
            ],
        )?,
        max_acceleration: if rotary {
            angle(positive(source, &at("max_acceleration_deg_s2"), file.max_acceleration_deg_s2)?)
        } else {
            positive(source, &at("max_acceleration_mm_s2"), file.max_acceleration_mm_s2)?
        },
        max_jerk: if rotary {
            angle(positive(source, &at("max_jerk_deg_s3"), file.max_jerk_deg_s3)?)
        } else {
            positive(source, &at("max_jerk_mm_s3"), file.max_jerk_mm_s3)?
        },
        rapid_velocity: velocity(
            source,
            index,
            [
                ("rapid_velocity_mm_min", file.rapid_velocity_mm_min),
                ("rapid_velocity_deg_s", file.rapid_velocity_deg_s),
                ("rapid_velocity_rev_min", file.rapid_velocity_rev_min),
            ],
        )?,
        home,
        home_stated: stated_home.is_some(),
        tool_change,
        moving_inertia: if rotary {
            positive(source, &at("moving_inertia_kg_m2"), file.moving_inertia_kg_m2)?.map(|j| j * MM2_PER_M2)
        } else {
            positive(source, &at("moving_mass_kg"), file.moving_mass_kg)?
        },
        drive: read_drive(source, &[Key("joint"), Item(index)], file.drive.as_ref(), rotary)?,
    };
    let written = if rotary { [file.home_deg, file.tool_change_deg] } else { [file.home_mm, file.tool_change_mm] };
    let positions = [(home_key, Some(home)), (tool_change_key, tool_change)];
    for ((key, value), written) in positions.into_iter().zip(written) {
        let Some(value) = value else { continue };
        if !value.is_finite() || joint.travel_violation(value).is_some() {
            let shown = written.unwrap_or(0.0);
            let message = format!("the position {shown} {unit_word} lies outside the travel");
            return Err(source.error("machine-home-outside", &at(key), message, "give a position within the travel"));
        }
    }
    if let (Some(rapid), Some(most)) = (joint.rapid_velocity, joint.max_velocity)
        && rapid > most * (1.0 + ROUNDING)
    {
        let of = |name: &'static str| -> (&'static str, f64) {
            // Of several units the one that is written.
            let all: [(&'static str, Option<f64>); 6] = [
                ("rapid_velocity_mm_min", file.rapid_velocity_mm_min),
                ("rapid_velocity_deg_s", file.rapid_velocity_deg_s),
                ("rapid_velocity_rev_min", file.rapid_velocity_rev_min),
                ("max_velocity_mm_min", file.max_velocity_mm_min),
                ("max_velocity_deg_s", file.max_velocity_deg_s),
                ("max_velocity_rev_min", file.max_velocity_rev_min),
            ];
            let found = all.into_iter().find_map(|(key, value)| Some((key, value?)).filter(|_| key.starts_with(name)));
            found.unwrap_or((name, 0.0))
        };
        let (key, rapid) = of("rapid_velocity");
        let (most_key, most) = of("max_velocity");
        let message = format!("{key} = {rapid} is above {most_key} = {most}");
        let remedy = "lower the rapid velocity or raise the highest one";
        return Err(source.error("machine-limits-upside-down", &at(key), message, remedy));
    }
    Ok(joint)
}

/// Refuses keys with the unit of the other kind of joint.
fn check_units(source: &Document<'_>, index: usize, file: &JointFile, rotary: bool) -> Checked<()> {
    let of_linear = [
        ("travel_mm", file.travel_mm.is_some(), "travel_deg"),
        ("max_velocity_mm_min", file.max_velocity_mm_min.is_some(), "max_velocity_deg_s"),
        ("max_acceleration_mm_s2", file.max_acceleration_mm_s2.is_some(), "max_acceleration_deg_s2"),
        ("max_jerk_mm_s3", file.max_jerk_mm_s3.is_some(), "max_jerk_deg_s3"),
        ("rapid_velocity_mm_min", file.rapid_velocity_mm_min.is_some(), "rapid_velocity_deg_s"),
        ("home_mm", file.home_mm.is_some(), "home_deg"),
        ("tool_change_mm", file.tool_change_mm.is_some(), "tool_change_deg"),
        ("moving_mass_kg", file.moving_mass_kg.is_some(), "moving_inertia_kg_m2"),
    ];
    let of_rotary = [
        ("point_mm", file.point_mm.is_some(), "nothing: a slide has no place"),
        ("travel_deg", file.travel_deg.is_some(), "travel_mm"),
        ("max_velocity_deg_s", file.max_velocity_deg_s.is_some(), "max_velocity_mm_min"),
        ("max_velocity_rev_min", file.max_velocity_rev_min.is_some(), "max_velocity_mm_min"),
        ("max_acceleration_deg_s2", file.max_acceleration_deg_s2.is_some(), "max_acceleration_mm_s2"),
        ("max_jerk_deg_s3", file.max_jerk_deg_s3.is_some(), "max_jerk_mm_s3"),
        ("rapid_velocity_deg_s", file.rapid_velocity_deg_s.is_some(), "rapid_velocity_mm_min"),
        ("rapid_velocity_rev_min", file.rapid_velocity_rev_min.is_some(), "rapid_velocity_mm_min"),
        ("home_deg", file.home_deg.is_some(), "home_mm"),
        ("tool_change_deg", file.tool_change_deg.is_some(), "tool_change_mm"),
        ("moving_inertia_kg_m2", file.moving_inertia_kg_m2.is_some(), "moving_mass_kg"),
    ];
    let wrong = if rotary { &of_linear[..] } else { &of_rotary[..] };
    let Some((key, _, instead)) = wrong.iter().find(|(_, given, _)| *given) else { return Ok(()) };
    let kind = if rotary { "rotary" } else { "linear" };
    let path = [Key("joint"), Item(index), Key(key)];
    Err(source.error("machine-wrong-unit", &path, format!("a {kind} joint has no {key}"), format!("write {instead}")))
}

/// The one velocity of several keys (mm/min, deg/s, rev/min) in mm/s or rad/s.
fn velocity(source: &Document<'_>, index: usize, keys: [(&'static str, Option<f64>); 3]) -> Checked<Option<f64>> {
    let mut found: Option<f64> = None;
    for ((key, value), factor) in keys.into_iter().zip([1.0 / 60.0, rad(1.0), rad(6.0)]) {
        let path = [Key("joint"), Item(index), Key(key)];
        let Some(value) = positive(source, &path, value)? else { continue };
        if found.is_some() {
            let remedy = "keep one of the two keys";
            return Err(source.error("machine-duplicate-limit", &path, "the velocity is given twice", remedy));
        }
        found = Some(value * factor);
    }
    Ok(found)
}
