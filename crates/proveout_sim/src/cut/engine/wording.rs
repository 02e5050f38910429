//! What a finding of the engine says: codes, words and figures. Place and time are added by the engine.

use std::sync::Arc;

use proveout_collision::{Severity, StockBreach};
use proveout_controller::{Event, LimitKind, servo::leg_names};
use proveout_geom::Point;
use proveout_machine::{Joint, JointKind, Machine};
use proveout_nc::{Location, Overcut, OvercutWeight, SpindleDirection};
use proveout_stock::SweepReport;
use proveout_tool::{Role, Tool, ToolLibrary};

use super::UnknownPlunge;
use crate::{
    cut::{
        bodies::{Hit, HitKind},
        stock_bodies::{AtRest, is_near_miss},
        tool_sweeps::{self, CuttingState, Swept},
    },
    units::N_M_PER_N_MM,
    verdict::{
        finding::{self, Code, Finding, LimitSource, ToolPart},
        log::FindingLog,
    },
};

/// Why the spindle is stopped.
fn standing(state: &CuttingState) -> &'static str {
    match state.spindle {
        SpindleDirection::Off => {
            " while the spindle is stopped (no M3 or M4 is in force: M5 and a tool change stop it)"
        }
        _ => " while the spindle is stopped (it is on but has no speed: the S word is missing, or is S0)",
    }
}

/// A part of the tool in material; `wanted` is the clearance asked for, mm.
pub(super) fn material(
    code: &Code,
    what: Swept,
    state: &CuttingState,
    tool: &Tool,
    report: &SweepReport,
    wanted: f64,
) -> Finding {
    let part = tool_sweeps::part_of_tool(what);
    let how = match code.code {
        _ if what == Swept::Entry => " right after the tool change, before it moves",
        c if c == finding::RAPID_IN_MATERIAL.code => " at rapid rate",
        c if c == finding::SPINDLE_OFF.code => standing(state),
        c if c == finding::SPINDLE_WRONG_WAY.code => " while the spindle turns against its hand",
        _ => "",
    };
    let near = code.code == finding::NEAR_MISS.code;
    let message = if near {
        format!("{part} of {} comes closer to the stock than the required {wanted:.3} mm", tool.name)
    } else {
        // A body that clamps or carries the cutter is more often at the side of the material than
        // below it.
        let cuts = matches!(what, Swept::Body(Role::Cutting) | Swept::Entry | Swept::Core);
        let deep = if cuts { "mm deep" } else { "mm below the nearest free surface" };
        // Between the rays a depth is known, and no volume.
        let volume = match report.volume_mm3 {
            volume if volume >= LEAST_VOLUME_MM3 => format!(", {volume:.3} mm3 in this piece"),
            _ => String::new(),
        };
        format!("{part} of {} meets material{how}: {:.3} {deep}{volume}", tool.name, tool_sweeps::depth(report))
    };
    let mut f = FindingLog::of(code, message);
    f.bodies = vec![format!("{}/{part}", tool.name), "stock".into()];
    let role = tool_sweeps::role_of(what);
    f.tool = state.tool.map(|tool| ToolPart { tool, role, body: 0, swept: true });
    if near {
        (f.limit, f.unit) = (Some(wanted), Some("mm".into()));
    } else {
        f.penetration_mm = Some(tool_sweeps::depth(report));
    }
    f.point_mm = report.first_point.map(|p| [p.x, p.y, p.z]);
    f
}

/// Volumes that are printed as zero are left out, mm³.
const LEAST_VOLUME_MM3: f64 = 0.0005;

/// Assumed dimensions on which a finding about a part of the tool depends, in words; empty where
/// all are given.
pub(super) fn chosen_of_tool(tools: &ToolLibrary, index: usize, part: Option<Role>) -> String {
    let (Some(tool), Some(notes)) = (tools.tools.get(index), tools.notes.get(index)) else { return String::new() };
    let keys: &[&str] = match part {
        Some(Role::Holder) => &["gauge_length_mm", "holder"],
        Some(Role::Neck | Role::Shank) => {
            &["flute_length_mm", "neck_length_mm", "neck_diameter_mm", "shank_diameter_mm"]
        }
        Some(Role::Cutting) | None => return String::new(),
    };
    let chosen: Vec<&str> =
        keys.iter().copied().filter(|key| notes.chosen.iter().any(|(own, _)| own.iter().any(|k| k == key))).collect();
    if chosen.is_empty() {
        return String::new();
    }
    format!(
        "; {} of {} chosen, not measured: put your own values into the tool library",
        chosen.join(" and "),
        tool.name
    )
}

/// What is to be known of a finding where the place of the workpiece on the table is assumed.
pub(super) const ASSUMED_MOUNT: &str = "; the place of the part on the table is assumed: write your own `translation_mm` under [mount] of the scene, with the work offsets";

/// What is to be known of material that no ray has met.
pub(super) const BETWEEN: &str =
    "; no ray of the stock passes through it: found from the shape of the raw stock and the cuts";

/// Where a tool meets what is fixed to the workpiece, in words: a place of the program, which no mounting
/// changes. `lowest`: lower face of the raw stock, workpiece frame, mm.
pub(super) fn place_of_hit(point_in_work: &Point, lowest: f64) -> String {
    let [x, y, z] = [point_in_work.x, point_in_work.y, point_in_work.z].map(|v| v + 0.0);
    let below = lowest - z;
    let below = if below > 0.0 { format!(", {below:.3} mm below the raw stock") } else { String::new() };
    format!(" at X{x:.3} Y{y:.3} Z{z:.3} of the workpiece{below}")
}

/// Two bodies too near.
pub(super) fn hit(hit: &Hit) -> Finding {
    let ([a, b], near) = (&hit.bodies, hit.wanted);
    let inside = if hit.inside { ", one inside of the other" } else { "" };
    let (code, message) = match hit.kind {
        HitKind::Collision => (&finding::COLLISION, format!("{a} hits {b}{inside}")),
        HitKind::NearMiss(_) => {
            (&finding::NEAR_MISS, format!("{a} comes closer to {b} than the required {near:.3} mm"))
        }
    };
    let mut f = FindingLog::of(code, message);
    f.bodies = hit.bodies.to_vec();
    f.penetration_mm = hit.penetration;
    f.tool = hit.tool_part();
    if let HitKind::NearMiss(left) = hit.kind {
        (f.clearance_mm, f.limit, f.unit) = (Some(left), Some(near), Some("mm".into()));
    }
    f
}

/// A distance of a ray's material that is called a meeting, mm.
const TOUCH_MM: f64 = 0.01;

/// A body too near to the stock; `near` is the clearance asked for, `unseen` what the rays cannot
/// resolve, mm.
pub(super) fn stock_breach(breach: &StockBreach, near: f64, unseen: f64) -> Finding {
    let body = &breach.body;
    let near_miss = is_near_miss(breach);
    let (rays, least) = (breach.ray_distance, breach.distance);
    let how = if breach.severity == Severity::QueryFailed {
        format!("{body} is not proven clear of the stock: joint positions are not finite numbers")
    } else if near_miss {
        format!("{body} comes closer to the stock than the required {near:.3} mm")
    } else if breach.inside {
        format!("{body} contains a part of the stock")
    } else if rays <= TOUCH_MM {
        format!(
            "{body} hits the stock: it meets material, known to within {:.3} mm, half the diagonal of a cell",
            0.5 * unseen
        )
    } else {
        format!(
            "{body} hits the stock or misses it by less than {rays:.3} mm: between rays material is known to within {:.3} mm, half the diagonal of a \
             cell",
            0.5 * unseen
        )
    };
    let mut f = FindingLog::of(if near_miss { &finding::NEAR_MISS } else { &finding::STOCK_HIT }, how);
    f.bodies = vec![body.to_string(), "stock".into()];
    f.penetration_mm = breach.penetration_estimate;
    if near_miss {
        (f.clearance_mm, f.limit, f.unit) = (Some(least), Some(near), Some("mm".into()));
    }
    f.point_mm = Some(breach.point_in_work.coords.into());
    f
}

/// A breach that rests on what lies between the rays: no ray was as near as that.
pub(super) fn may_be_of_the_cells(breach: &StockBreach, near: f64) -> bool {
    let limit = if is_near_miss(breach) { near } else { TOUCH_MM };
    !breach.inside && breach.severity != Severity::QueryFailed && breach.ray_distance > limit
}

/// A body inside the stock that moves as one with it.
pub(super) fn at_rest(standing: &AtRest) -> Finding {
    let (body, overlap) = (&standing.body, &standing.overlap);
    let message = format!(
        "{body} overlaps the stock before any motion: {:.3} mm deep, {:.3} mm3",
        overlap.depth_mm, overlap.volume_mm3
    );
    let mut f = FindingLog::of(&finding::STOCK_AT_REST, message);
    f.bodies = vec![body.clone(), "stock".into()];
    f.time_s = Some(0.0);
    f.penetration_mm = Some(overlap.depth_mm);
    f.point_mm = Some(overlap.point.coords.into());
    f
}

/// What an event of the control says; none where it is no finding. A place where the compensated
/// path enters its own contour has its own words ([`overcut`]), since it is reported only at the
/// end of the compensated stretch.
pub(super) fn event(event: &Event, machine: &Machine) -> Option<Finding> {
    Some(match event {
        Event::Limit { joint, value, limit, kind, .. } => {
            if let (LimitKind::DriveForce, Some(legs)) = (kind, joint.and_then(|j| leg_names(machine, j))) {
                return Some(past_leg_force(&legs, [*value, *limit]));
            }
            let known = joint.and_then(|j| Some((j, machine.joints.get(j)?)));
            let mut f = past_limit(known.map(|(_, joint)| joint), [*value, *limit], *kind)?;
            if let (LimitKind::Travel, Some((index, joint))) = (kind, known) {
                f = f.limited_by(LimitSource::Travel(index));
                f.message.push_str(machine.doubt_of_travel(joint));
            }
            f
        }
        Event::UnreachablePose { reason, .. } => {
            FindingLog::of(&finding::UNREACHABLE, format!("the programmed tool pose cannot be reached: {reason}"))
        }
        Event::LeavesCircle { angle, at_flank, in_cone, reason, .. } => {
            let code = if *in_cone { &finding::POLE_CROSSED } else { &finding::OFF_CIRCLE };
            let angle = angle.to_degrees();
            let message = format!(
                "{reason}: the tool axis leaves the programmed great circle by {angle:.6} degrees, {at_flank:.6} mm at the flank"
            );
            let mut f = FindingLog::of(code, message);
            (f.value, f.unit) = (Some(angle), Some("deg".into()));
            f
        }
        Event::Ended { location, reason, .. } => {
            let mut f = FindingLog::of(&finding::STOPPED, reason.clone());
            (f.file, f.line) = (Some(location.file.to_string()), Some(location.line));
            f
        }
        Event::Probe { .. } => FindingLog::of(
            &finding::PROBED,
            "the probing motion is run to its end: the probe result is not known".into(),
        ),
        Event::Note { text, .. } => match text.assumption() {
            Some(assumed) => FindingLog::of(&finding::ASSUMED, assumed.to_owned()),
            None => FindingLog::of(&finding::NOTE, text.as_str().to_owned()),
        },
        _ => return None,
    })
}

/// A leg's drive at its limit, N.
fn past_leg_force(legs: &str, [value, limit]: [f64; 2]) -> Finding {
    let message = format!(
        "the control demands a force of {value:.1} N from the drive of {legs}; its limit is {limit:.1} N, so the platform leaves its set points"
    );
    let mut f = FindingLog::of(&finding::DRIVE_SATURATED, message);
    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some("N".into()));
    f
}

/// A limit that was passed; `value` and `limit` in the units of the event.
fn past_limit(joint: Option<&Joint>, [value, limit]: [f64; 2], kind: LimitKind) -> Option<Finding> {
    let kind_of_joint = joint.map_or(JointKind::Linear, |j| j.kind);
    let (unit, scale) = (kind_of_joint.unit(), kind_of_joint.unit_factor());
    let name = joint.map_or("a joint", |j| j.name.as_str());
    let (code, message, value, limit, unit) = match kind {
        LimitKind::Travel => {
            let (value, limit) = (value * scale, limit * scale);
            let past = (value - limit).abs();
            let message =
                format!("{name} is sent to {value:.3} {unit}, {past:.3} {unit} past its travel of {limit:.3} {unit}");
            (&finding::OVERTRAVEL, message, value, limit, unit.to_owned())
        }
        LimitKind::DriveForce => {
            let linear = kind_of_joint == JointKind::Linear;
            let (word, unit, scale) = if linear { ("force", "N", 1.0) } else { ("torque", "Nm", N_M_PER_N_MM) };
            let (value, limit) = (value * scale, limit * scale);
            let message = format!(
                "the control demands a {word} of {value:.1} {unit} from the drive of {name}; its limit is {limit:.1} {unit}, so the joint leaves its set points"
            );
            (&finding::DRIVE_SATURATED, message, value, limit, unit.to_owned())
        }
        LimitKind::Velocity | LimitKind::Acceleration | LimitKind::Jerk => {
            let (word, per) = match kind {
                LimitKind::Velocity => ("velocity", "s"),
                LimitKind::Acceleration => ("acceleration", "s²"),
                _ => ("jerk", "s³"),
            };
            let (value, limit, unit) = (value * scale, limit * scale, format!("{unit}/{per}"));
            let message = format!(
                "the set points demand a {word} of {value:.3} {unit} from {name}; its limit is {limit:.3} {unit}"
            );
            (&finding::PLANNED_MOTION, message, value, limit, unit)
        }
        LimitKind::SpindleSpeed => {
            let message = format!("spindle speed {value:.0} 1/min is above the limit of {limit:.0} 1/min");
            let mut f = FindingLog::of(&finding::SPINDLE_SPEED, message);
            (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some("1/min".into()));
            return Some(f);
        }
    };
    let mut f = FindingLog::of(code, message);
    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some(unit));
    f.bodies = vec![name.into()];
    Some(f)
}

/// A place where the compensated path enters its own contour. The reader reports it at the end of
/// the compensated stretch, so its line is that of the reader and not that of the block under way.
pub(super) fn overcut(time: f64, location: &Location, overcut: &Overcut) -> Finding {
    let code = match overcut.kind.weight() {
        OvercutWeight::Error => &finding::OVERCUT,
        OvercutWeight::Warning => &finding::CONTOUR_TOUCHED,
        OvercutWeight::Info => &finding::NOTE,
    };
    let mut f = FindingLog::of(code, overcut.to_string());
    (f.file, f.line) = (Some(location.file.to_string()), Some(location.line));
    f.time_s = Some(time);
    f.penetration_mm = Some(overcut.depth);
    f
}

/// What is known of a way down that is not allowed: its angle or its stub, each with its limit.
pub(super) fn plunge(tool: &Tool, angle: f64, limit: f64, [stub, most]: [f64; 2]) -> Finding {
    let name = &tool.name;
    let (angle_deg, limit_deg) = (angle.to_degrees(), limit.to_degrees());
    let ramp = match tool.max_ramp_angle {
        Some(_) => format!("its maximum ramp angle is {limit_deg:.3} degrees"),
        None => "its maximum ramp angle is not stated".to_owned(),
    };
    let steep = angle > limit;
    let aside = if tool.dead_center.is_some() { "the region without edges" } else { "its radius" };
    let message = if steep {
        format!("{name} is not center-cutting and plunges into material at {angle_deg:.3} degrees; {ramp}")
    } else {
        format!(
            "{name} is not center-cutting and leaves a stub of {stub:.3} mm under it: it plunges without moving sideways by \
             {aside}; {ramp}, which leaves {most:.3} mm"
        )
    };
    let mut f = FindingLog::of(&finding::PLUNGE, message);
    f.bodies = vec![name.clone()];
    if steep {
        f.value = Some(angle_deg);
        (f.limit, f.unit) = (tool.max_ramp_angle.map(|_| limit_deg), Some("deg".into()));
    } else {
        (f.value, f.limit, f.unit) = (Some(stub), Some(most), Some("mm".into()));
    }
    f
}

pub(super) fn unknown_plunge(tool: &Tool, plunge: &UnknownPlunge, places: &[Option<(Arc<str>, u32)>]) -> String {
    let at = places.get(plunge.block as usize).and_then(Option::as_ref);
    let at = at.map_or_else(String::new, |(file, line)| format!(" ({file}:{line})"));
    let missing = match (tool.center_cutting, tool.max_ramp_angle) {
        (None, _) => "center_cutting",
        (_, None) => "max_ramp_angle_deg",
        _ => "dead_center_diameter_mm",
    };
    let (name, angle) = (&tool.name, plunge.angle.to_degrees());
    format!(
        "whether {name} may plunge into material at {angle:.1} degrees{at}: the tool library gives no `{missing}` for it"
    )
}
