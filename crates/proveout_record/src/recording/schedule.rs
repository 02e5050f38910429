//! A re-scheduled program next to the original: tool axes on a sphere and on the part, channels, joints,
//! remaining gain.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use proveout_geom::{Point, Pose, Vector};
use proveout_sim::{
    compare::Role,
    observer::Setup,
    schedule::{Demand, MethodCurve, Schedule, ScheduledRun},
};

use crate::{
    color::Rgba,
    error::RecordError,
    recording::sink::{Arrows, LineStyle, PathPosition, Sink, path},
    units::JointUnit,
};

/// Arrows on the part for each program.
const ARROWS: usize = 160;
/// Length of an arrow, part of the diagonal of the workpiece.
const ARROW_PART: f64 = 0.13;
/// Circles of the sphere, degrees apart.
const CIRCLES_DEG: usize = 15;
/// Points of a circle.
const CIRCLE_POINTS: usize = 96;
/// Radius of the solid sphere that hides the far side.
const SOLID: f32 = 0.985;
/// Points that show the axes at the time of the viewer.
const PLACES: usize = 3000;
/// Axes that are farther than this from their middle go round the sphere, radian.
const WIDE: f64 = 1.3;
/// A limit is drawn where a program comes as near to it as this part.
const NEAR: f64 = 0.6;
/// A joint whose positions span less is not shown, mm or radian: it is held.
const MOVES: f64 = 1e-4;
/// Axes whose sum is shorter have no middle.
const SHORTEST: f64 = 1e-6;

const ORIGINAL: Rgba = [236, 150, 60, 255];
const NEW: Rgba = [80, 160, 245, 255];
const CHANNEL: Rgba = [120, 190, 120, 255];
const LIMIT: Rgba = [190, 70, 74, 255];
const GRID: Rgba = [92, 98, 108, 255];
const SPHERE: Rgba = [44, 48, 55, 255];
const OTHER: Rgba = [170, 170, 180, 255];

/// What the layout must know of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ScheduleViews {
    /// Joints with their units, and whether they have a channel; those that have one first.
    pub(crate) joints: Vec<(JointUnit, bool)>,
    /// Quantities of the method: name in paths, and title.
    pub(crate) quantities: Vec<[String; 2]>,
    /// From where the sphere is looked at, and at what.
    pub(crate) eye: [f64; 3],
    pub(crate) target: [f64; 3],
}

/// Rows of a signal: where, and what.
type Rows = Vec<(PathPosition, f64)>;

/// Logs it all; what there is to be laid out.
pub(crate) fn send(sink: &Sink, setup: &Setup<'_>, schedule: &Schedule) -> Result<ScheduleViews, RecordError> {
    let units = JointUnit::all(setup.machine);
    sink.document(path(["schedule", "text"]), text(setup, schedule, &units))?;
    let places = places(&schedule.runs);
    let work_from_table = setup.table_from_work.inverse();
    let [eye, target] = sphere(sink, schedule, &places, &work_from_table)?;
    let size = setup.stock.bounds().size().norm();
    arrows(sink, schedule, &work_from_table, ARROW_PART * size)?;
    let mut shown = Vec::new();
    for (j, unit) in units.iter().enumerate() {
        let of = |run: &ScheduledRun| run.joints.iter().position(|joint| joint.joint == j);
        if !schedule.runs.iter().any(|run| of(run).is_some_and(|k| moves(run, k))) {
            continue;
        }
        let limits =
            setup.machine.joints.get(j).map_or([None; 2], |joint| [joint.max_velocity, joint.max_acceleration]);
        joint(sink, schedule, &places, (j, unit), limits)?;
        let channel = schedule.runs.iter().any(|run| of(run).is_some_and(|k| run.joints[k].channel.is_some()));
        shown.push((!channel, unit.unit != "deg", unit.clone()));
    }
    shown.sort_by_key(|(no_channel, linear, _)| (*no_channel, *linear));
    let quantities = method(sink, schedule, &places)?;
    let joints = shown.into_iter().map(|(no_channel, _, unit)| (unit, !no_channel)).collect();
    Ok(ScheduleViews { joints, quantities, eye, target })
}

/// Positions of the blocks of all runs: time of the new program, and path length over all runs.
fn places(runs: &[ScheduledRun]) -> Vec<Vec<PathPosition>> {
    let mut begin = 0.0;
    let of = |run: &ScheduledRun| {
        let all = run.blocks.iter().map(|b| PathPosition { time: b.time, way: begin + b.way }).collect();
        begin += run.blocks.last().map_or(0.0, |b| b.way);
        all
    };
    runs.iter().map(of).collect()
}

fn moves(run: &ScheduledRun, k: usize) -> bool {
    let joint = &run.joints[k];
    let range = |demand: &Demand| {
        let ends = demand.position.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], q| [l.min(*q), h.max(*q)]);
        ends[1] - ends[0]
    };
    joint.channel.is_some() || range(&joint.original).max(range(&joint.new)) > MOVES
}

/// Rows of all runs, one after the other; a NaN interrupts the line.
fn rows(runs: &[ScheduledRun], places: &[Vec<PathPosition>], of: impl Fn(&ScheduledRun, usize) -> Option<f64>) -> Rows {
    let mut all = Rows::new();
    for (run, places) in runs.iter().zip(places) {
        if let (Some(last), Some(next)) = (all.last().copied(), places.first()) {
            let middle = |a: f64, b: f64| 0.5 * (a + b);
            let between = PathPosition { time: middle(last.0.time, next.time), way: middle(last.0.way, next.way) };
            all.push((between, f64::NAN));
        }
        all.extend(places.iter().enumerate().filter_map(|(i, place)| Some((*place, of(run, i)?))));
    }
    all
}

/// Position within its channel, velocity and acceleration of a joint in both programs.
fn joint(
    sink: &Sink,
    schedule: &Schedule,
    places: &[Vec<PathPosition>],
    (j, unit): (usize, &JointUnit),
    limits: [Option<f64>; 2],
) -> Result<(), RecordError> {
    let of = |run: &ScheduledRun| run.joints.iter().position(|joint| joint.joint == j);
    for (end, name) in ["lowest", "highest"].into_iter().enumerate() {
        let gate = |run: &ScheduledRun, i: usize| {
            let channel = run.joints.get(of(run)?)?.channel.as_ref()?;
            Some(channel.get(i.checked_sub(run.stretch.start)?)?[end] * unit.factor)
        };
        let rows = rows(&schedule.runs, places, gate);
        if rows.iter().any(|r| r.1.is_finite()) {
            let entity = path(["schedule", "joints", &unit.name, "position", name]);
            let style = LineStyle { name: format!("{name} in the channel"), color: CHANNEL, width: 2.0 };
            sink.line_style(entity.clone(), &style)?;
            sink.values(entity, &rows)?;
        }
    }
    in_channel(sink, schedule, places, (j, unit))?;
    let of_demand: [fn(&Demand) -> &Vec<f64>; 3] = [|d| &d.position, |d| &d.velocity, |d| &d.acceleration];
    for (what, (quantity, get)) in ["position", "velocity", "acceleration"].into_iter().zip(of_demand).enumerate() {
        let mut most = 0.0_f64;
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for (name, color, after) in [("original", ORIGINAL, false), ("new", NEW, true)] {
            let value = |run: &ScheduledRun, i: usize| {
                let joint = run.joints.get(of(run)?)?;
                let value = *get(if after { &joint.new } else { &joint.original }).get(i)?;
                value.is_finite().then_some(value * unit.factor)
            };
            let rows = rows(&schedule.runs, places, value);
            for (place, value) in rows.iter().filter(|r| r.1.is_finite()) {
                most = most.max(value.abs());
                ends = [ends[0].min(place.time), ends[1].max(place.time)];
            }
            let entity = path(["schedule", "joints", &unit.name, quantity, name]);
            let style = LineStyle { name: name.to_owned(), color, width: if after { 2.0 } else { 1.5 } };
            sink.line_style(entity.clone(), &style)?;
            sink.values(entity, &rows)?;
        }
        let limit = what.checked_sub(1).and_then(|k| limits[k]).map(|limit| limit * unit.factor);
        if let Some(limit) = limit.filter(|limit| most > NEAR * limit && ends[0] < ends[1]) {
            for (name, limit) in [("lower_limit", -limit), ("upper_limit", limit)] {
                let entity = path(["schedule", "joints", &unit.name, quantity, name]);
                sink.line_style(entity.clone(), &LineStyle { name: "limit".to_owned(), color: LIMIT, width: 1.0 })?;
                sink.signal(entity, &ends.map(|time| (time, limit)))?;
            }
        }
    }
    Ok(())
}

/// Ends of the channel and positions of both programs about its middle: on the scale of a whole turn of the
/// joint, a channel of some degrees would be invisible.
fn in_channel(
    sink: &Sink,
    schedule: &Schedule,
    places: &[Vec<PathPosition>],
    (j, unit): (usize, &JointUnit),
) -> Result<(), RecordError> {
    let styles = [("lowest", CHANNEL, 2.0), ("highest", CHANNEL, 2.0), ("original", ORIGINAL, 1.5), ("new", NEW, 2.0)];
    for (which, (name, color, width)) in styles.into_iter().enumerate() {
        let value = |run: &ScheduledRun, i: usize| {
            let joint = run.joints.iter().find(|joint| joint.joint == j)?;
            let [low, high] = *joint.channel.as_ref()?.get(i.checked_sub(run.stretch.start)?)?;
            let at = [low, high, *joint.original.position.get(i)?, *joint.new.position.get(i)?][which];
            Some((at - 0.5 * (low + high)) * unit.factor)
        };
        let rows = rows(&schedule.runs, places, value);
        if rows.iter().any(|r| r.1.is_finite()) {
            let entity = path(["schedule", "joints", &unit.name, "in_channel", name]);
            let words = if which < 2 { format!("{name} in the channel") } else { name.to_owned() };
            sink.line_style(entity.clone(), &LineStyle { name: words, color, width })?;
            sink.values(entity, &rows)?;
        }
    }
    Ok(())
}

/// What the method shows along the path; its quantities.
fn method(sink: &Sink, schedule: &Schedule, places: &[Vec<PathPosition>]) -> Result<Vec<[String; 2]>, RecordError> {
    let mut quantities: Vec<[String; 2]> = Vec::new();
    let mut names: Vec<(&MethodCurve, String)> = Vec::new();
    for curve in schedule.runs.iter().flat_map(|run| &run.curves) {
        let [quantity, unit] = &curve.quantity;
        let title = if unit.is_empty() { quantity.clone() } else { format!("{quantity}, {unit}") };
        if !quantities.iter().any(|q| q[1] == title) {
            quantities.push([plain(quantity), title]);
        }
        if !names.iter().any(|(c, q)| c.name == curve.name && *q == curve.quantity[0]) {
            names.push((curve, curve.quantity[0].clone()));
        }
    }
    for (k, (first, _)) in names.iter().enumerate() {
        let mut all = Rows::new();
        for (run, places) in schedule.runs.iter().zip(places) {
            let same = |c: &&MethodCurve| c.name == first.name && c.quantity == first.quantity;
            let Some(curve) = run.curves.iter().find(same) else { continue };
            if let (Some(last), Some(next), false) = (all.last().copied(), places.first(), curve.points.is_empty()) {
                let middle = |a: f64, b: f64| 0.5 * (a + b);
                let place = PathPosition { time: middle(last.0.time, next.time), way: middle(last.0.way, next.way) };
                all.push((place, f64::NAN));
            }
            all.extend(curve.points.iter().filter_map(|p| Some((between(places, p[0])?, p[1]))));
        }
        let entity = path(["schedule", "method", &plain(&first.quantity[0]), &plain(&first.name)]);
        let (color, dots) = match first.role {
            Role::Limit => (if k % 2 == 0 { CHANNEL } else { [90, 170, 160, 255] }, false),
            Role::Original => (ORIGINAL, false),
            Role::Result => (NEW, false),
            Role::Polyline => (OTHER, false),
            Role::KeyPoints => ([230, 220, 90, 255], true),
            Role::Marks => (OTHER, true),
        };
        if dots {
            sink.dots_style(entity.clone(), &first.name, color)?;
        } else {
            sink.line_style(entity.clone(), &LineStyle { name: first.name.clone(), color, width: 1.5 })?;
        }
        sink.values(entity, &all)?;
    }
    Ok(quantities)
}

/// A place between two blocks, by its part of the way.
fn between(places: &[PathPosition], at: f64) -> Option<PathPosition> {
    let k = (at.max(0.0) as usize).min(places.len().checked_sub(1)?);
    let (from, to) = (places[k], places.get(k + 1).unwrap_or(&places[k]));
    let part = (at - k as f64).clamp(0.0, 1.0);
    Some(PathPosition { time: from.time + part * (to.time - from.time), way: from.way + part * (to.way - from.way) })
}

/// A name as a part of a path.
fn plain(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|p| !p.is_empty());
    parts.collect::<Vec<_>>().join("_")
}

/// Axes of both programs as ways on the unit sphere of the workpiece frame, with what belongs to the time of
/// the viewer; from where to look at it, and where.
fn sphere(
    sink: &Sink,
    schedule: &Schedule,
    places: &[Vec<PathPosition>],
    work_from_table: &Pose,
) -> Result<[[f64; 3]; 2], RecordError> {
    sink.z_up(path(["schedule", "sphere"]))?;
    sink.static_lines(path(["schedule", "sphere", "grid"]), &[(grid(), GRID, 0.7)])?;
    let ends = [("X", Vector::x()), ("Y", Vector::y()), ("Z", Vector::z())];
    let labels: Vec<([f64; 3], String)> = ends.iter().map(|(n, v)| ((v * 1.03).into(), (*n).to_owned())).collect();
    sink.labels(path(["schedule", "sphere", "frame"]), &labels, OTHER)?;
    let axis = |run: &ScheduledRun, i: usize, which: usize| work_from_table.vector(&run.blocks[i].poses[which].axis);
    let mut all = Vec::new();
    for (which, (name, color)) in [("original", ORIGINAL), ("new", NEW)].into_iter().enumerate() {
        // The new way lies over the one before.
        let radius = if which == 0 { 1.0 } else { 1.004 };
        let strip = |run: &ScheduledRun| -> Vec<[f32; 3]> {
            run.stretch.clone().map(|i| single(axis(run, i, which) * radius)).collect()
        };
        let strips: Vec<Vec<[f32; 3]>> = schedule.runs.iter().map(strip).collect();
        all.extend(schedule.runs.iter().flat_map(|run| run.stretch.clone().map(|i| axis(run, i, which))));
        sink.static_lines(path(["schedule", "sphere", name]), &[(strips, color, 2.0)])?;
        let count: usize = schedule.runs.iter().map(|run| run.blocks.len()).sum();
        let step = count.div_ceil(PLACES).max(1);
        let mut now: Vec<(PathPosition, [f32; 3])> = Vec::new();
        for (run, places) in schedule.runs.iter().zip(places) {
            let shown = (0..run.blocks.len()).step_by(step);
            now.extend(shown.map(|i| (places[i], single(axis(run, i, which) * radius))));
        }
        sink.moving_point(path(["schedule", "sphere", &format!("{name}_now")]), &now, color)?;
    }
    let from = |middle: &Vector| all.iter().map(|v| middle.cross(v).norm().atan2(middle.dot(v))).fold(0.0, f64::max);
    let sum: Vector = all.iter().sum();
    let middle = if sum.norm() > SHORTEST { sum.normalize() } else { Vector::z() };
    let reach = from(&middle);
    if reach < WIDE {
        // A ball hides its far side, where nothing is drawn here.
        sink.ball(path(["schedule", "sphere", "solid"]), SOLID, SPHERE)?;
        let away = 1.0 + (2.4 * reach).clamp(0.5, 2.0);
        let near = if reach < 0.6 { 0.95 } else { 0.3 };
        return Ok([(middle * away).into(), (middle * near).into()]);
    }
    // About an axis of the frame: looking from slightly off the one that is nearest to all.
    let frame = [Vector::x(), Vector::y(), Vector::z()].into_iter().flat_map(|v| [v, -v]);
    let best = frame.min_by(|a, b| from(a).total_cmp(&from(b))).unwrap_or_else(Vector::x);
    let beside =
        if best.z.abs() > 0.5 { Vector::new(0.35, -0.55, 0.0) } else { Vector::new(-0.3 * best.y, 0.3 * best.x, 0.55) };
    Ok([((best + beside).normalize() * 2.9).into(), [0.0; 3]])
}

fn single(v: Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// Circles of equal inclination to Z, and great circles through it.
fn grid() -> Vec<Vec<[f32; 3]>> {
    let circle = |of: &dyn Fn(f64, f64) -> Vector| -> Vec<[f32; 3]> {
        (0..=CIRCLE_POINTS)
            .map(|i| {
                let (s, c) = (TAU * i as f64 / CIRCLE_POINTS as f64).sin_cos();
                single(of(s, c))
            })
            .collect()
    };
    let mut all = Vec::new();
    for k in (CIRCLES_DEG..180).step_by(CIRCLES_DEG) {
        let (r, z) = (k as f64).to_radians().sin_cos();
        all.push(circle(&|s, c| Vector::new(r * c, r * s, z)));
    }
    for k in (0..180).step_by(2 * CIRCLES_DEG) {
        let (y, x) = (k as f64).to_radians().sin_cos();
        all.push(circle(&|s, c| Vector::new(x * s, y * s, c)));
    }
    all
}

/// Arrows along the tool axes, from the ball's center or the tip.
fn arrows(sink: &Sink, schedule: &Schedule, work_from_table: &Pose, length: f64) -> Result<(), RecordError> {
    let count: usize = schedule.runs.iter().map(|run| run.stretch.len()).sum();
    let step = count.div_ceil(ARROWS).max(1);
    for (which, (name, color)) in [("original", ORIGINAL), ("new", NEW)].into_iter().enumerate() {
        let chosen = schedule.runs.iter().flat_map(|run| run.stretch.clone().step_by(step).map(|i| &run.blocks[i]));
        let (mut from, mut along) = (Vec::new(), Vec::new());
        for block in chosen {
            let pose = &block.poses[which];
            let place: Point = work_from_table.point(&pose.tip);
            from.push(single(place.coords));
            along.push(single(work_from_table.vector(&pose.axis) * length));
        }
        let all = Arrows { from, along, color };
        sink.arrows(path(["machine", "table", "work", "schedule", name]), &all)?;
    }
    Ok(())
}

/// The page of text: what is shown, times, bound, numbers of the method.
fn text(setup: &Setup<'_>, schedule: &Schedule, units: &[JointUnit]) -> String {
    let mut text = format!(
        "**{}**, made from **{}** by **{}** ({}).\n",
        setup.program, schedule.from, schedule.method, schedule.source
    );
    if let Some(why) = &schedule.unknown {
        let _ = write!(text, "\nThe motion is not known: {why}.\n");
    }
    for (k, run) in schedule.runs.iter().enumerate() {
        if schedule.runs.len() > 1 {
            let _ = write!(text, "\n## Run {} of {}\n", k + 1, schedule.runs.len());
        }
        text.push('\n');
        match &run.bound {
            Ok(b) => {
                let _ = writeln!(
                    text,
                    "| time of the {} replanned blocks | |\n|---|---|\n| program before | {:.3} s |\n| new program | {:.3} s ({:+.2} percent) |\n| no schedule of these is below | {:.3} s |\n| left to gain at most | {} |",
                    run.stretch.len(),
                    b.original_time,
                    b.time,
                    100.0 * (b.time / b.original_time - 1.0),
                    b.bound,
                    b.gap_percent.map_or("the new program leaves the channel".into(), |gap| format!(
                        "{gap:.2} percent of the bound"
                    )),
                );
            }
            Err(why) => {
                let _ = writeln!(text, "No bound of the time: {why}.");
            }
        }
        let _ = write!(text, "\n| largest at the programmed feed | before | new |\n|---|---|---|\n");
        for joint in &run.joints {
            let Some(unit) = units.get(joint.joint).filter(|u| u.rotary) else { continue };
            let most = |values: &[f64]| {
                let inside = values.get(run.stretch.clone()).unwrap_or_default();
                inside.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs())) * unit.factor
            };
            let [a, b] = [&joint.original, &joint.new];
            let _ = writeln!(
                text,
                "| {} velocity, deg/s | {:.2} | {:.2} |",
                unit.name,
                most(&a.velocity),
                most(&b.velocity)
            );
            let _ = writeln!(
                text,
                "| {} acceleration, deg/s² | {:.1} | {:.1} |",
                unit.name,
                most(&a.acceleration),
                most(&b.acceleration)
            );
        }
        if !run.figures.is_empty() {
            text += "\n| values of the method | |\n|---|---|\n";
            for f in &run.figures {
                let _ = writeln!(text, "| {} | {:.3} {} |", f.name, f.value, f.unit);
            }
        }
    }
    text += "\n## What is shown\n\n**Orange** is the program before, **blue** the new one, **green** the channel that it may use, **red** a limit of the machine as \
             the scene has it. The curves are drawn at the time at which the new program ends its blocks (timeline `sim_time`) and at the way of the tool over \
             all runs in micrometers (`path_um`). Velocity and acceleration are those at the programmed feed, by differences over blocks; what the control \
             makes of them is under *Run*. Circles of the sphere are 15 degrees apart; the dots are the tool axes at the time of the viewer.\n";
    text
}
