//! Checks the certificates of a run (`clearance.parquet`) with code of its own.
//!
//! Machine, tools and fixtures are read again from the scene; the motion from `signals.parquet`; the claims
//! from `verdict.json` and `clearance.parquet`. Nothing of `proveout_collision` is used. A distance holds
//! by planes with that much room at their sides, computed here on the triangles and boxes of triangles of
//! both bodies (`distance.rs`); bounds of motion hold by the corners of the bodies (`motion.rs`). What is
//! checked:
//!
//! 1. The inputs are those of the run, by their digests.
//! 2. Every pair that moves against each other is listed: as checked, or as unchecked with a reason.
//! 3. The spans of a pair follow each other without a gap and with ranges that touch, and every sample of the
//!    motion while both bodies are in place has its joints in the range of a span of its time. Parts of one
//!    piece of the motion have the time of the piece in common.
//! 4. The distance of each span is no larger than the one found here, and its motion is no smaller than what
//!    the joints do in it. Where the range of a joint has no ends, it turns one of the two about a fixed line
//!    and not the other, and the distance is checked against that body at all turns.
//! 5. What the verdict claims for a pair is what its spans prove; a pair of which nothing is proved has a
//!    finding. With a pair that is not checked the gate does not pass.
//!
//! A certificate is refused if it claims what is not true, has a gap, or differs from the verdict. One that
//! claims less than is true is accepted. That no byte of it was changed is checked by `proveout verify`.
//!
//! Not checked: distances of machine bodies of neighboring joints, for which the product's own text leaves
//! out the volume in which they bear on each other (the verdict must report them), and the stock, which
//! changes at every moment.

mod distance;
mod form;
mod motion;
mod placed;
mod table;
#[cfg(test)]
mod tests;
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use proveout_geom::Vector;
use proveout_machine::{Attachment, JointValues, Machine};
use proveout_sim::{Choice, Prepared};
use proveout_tool::{Role, Tool};
use serde_json::Value;

use crate::TaskError;
use distance::SeparationSearch;
use form::{BodyPieces, RevolvedBody};
use motion::JointCorners;
use placed::RelativePoses;
use table::{ClearanceClaim, JointSample};

/// Allowed excess of a claim over what is found here, mm: rounding, and arcs of tools that are polygons
/// here.
const SLACK_MM: f64 = 1e-3;
/// Allowed difference of the verdict from what the spans prove, mm: rounding of the sum.
const VERDICT_SLACK_MM: f64 = 1e-9;
/// By how much a joint of a sample may be outside of the range of its span: rounding of degrees.
const JOINT_SLACK: f64 = 1e-6;
/// Corners of a round body that are on one circle, mm (models are stored in 32 bits), and the largest angle
/// of a facet, radian (10.1 degrees).
const RING_MM: f64 = 0.01;
const FACET_RAD: f64 = 0.1763;
/// By how much the time of a sample may be outside of a span: rounding.
const TIME_SLACK_S: f64 = 1e-9;

/// A body in the frame of its carrier.
struct CarriedBody {
    attached: Attachment,
    is_machine: bool,
    /// Its role is to bear on its neighbor.
    bears: bool,
    /// Number of the tool that it is a part of.
    tool: Option<u32>,
    form: BodyPieces,
    /// The same at all turns of the joint that carries it about a fixed line.
    turned: Option<(usize, RevolvedBody)>,
}

impl CarriedBody {
    fn new(machine: &Machine, attached: Attachment, is_machine: bool, tool: Option<u32>, form: BodyPieces) -> Self {
        let carrier = match attached {
            Attachment::Joint(j) if machine.joints[j].is_rotary() && machine.joints[j].turn_shift.is_none() => Some(j),
            _ => None,
        };
        let turned = carrier.map(|j| (j, form.turned(&machine.joints[j].point, &machine.joints[j].direction)));
        Self { attached, is_machine, bears: false, tool, form, turned }
    }
}

/// Checks a run folder against its scene; gives what was seen.
///
/// # Errors
/// The first claim that does not hold, or a file that cannot be read.
pub(crate) fn run(folder: &Path, scene: &Path) -> Result<String, TaskError> {
    let verdict: Value = serde_json::from_str(&crate::files::get(&folder.join("verdict.json"))?)
        .map_err(|e| TaskError(format!("verdict.json: {e}")))?;
    let choice = Choice { program: verdict["program"].as_str().map(Into::into), ..Choice::default() };
    let setup = Prepared::read(scene, &choice).map_err(|e| TaskError(format!("{}: {e}", scene.display())))?;
    for (role, digest) in &setup.digests {
        if verdict["digests"][role].as_str() != Some(digest) {
            return Err(TaskError(format!("{role} has changed since the run: its digest differs")));
        }
    }
    let spans = table::spans(&folder.join("clearance.parquet"), &setup.machine)?;
    let samples = table::samples(&folder.join("signals.parquet"), &setup.machine)?;
    check(&verdict, &setup, &spans, &samples)
}

fn bodies(setup: &Prepared) -> BTreeMap<String, CarriedBody> {
    let machine = &setup.machine;
    let table = machine.work_chain.last().map_or(Attachment::Base, |&j| Attachment::Joint(j));
    let of_machine = machine.bodies.iter().filter(|b| b.check).map(|b| {
        let bears = matches!(b.role.as_str(), "guide" | "bearing");
        (
            b.name.clone(),
            CarriedBody { bears, ..CarriedBody::new(machine, b.attached_to, true, None, BodyPieces::mesh(&b.mesh)) },
        )
    });
    let fixtures = setup
        .fixtures
        .iter()
        .map(|(name, mesh)| (name.clone(), CarriedBody::new(machine, table, false, None, BodyPieces::mesh(mesh))));
    let mut all: BTreeMap<String, CarriedBody> = of_machine.chain(fixtures).collect();
    for tool in &setup.tools.tools {
        all.extend(tool_bodies(machine, tool));
    }
    all
}

fn tool_bodies<'a>(machine: &'a Machine, tool: &'a Tool) -> impl Iterator<Item = (String, CarriedBody)> + 'a {
    let roles = [(Role::Cutting, "cutter"), (Role::Neck, "neck"), (Role::Shank, "shank"), (Role::Holder, "holder")];
    roles.into_iter().filter_map(|(role, word)| {
        let profiles: Vec<_> = tool.bodies.iter().filter(|b| b.role == role).map(|b| &b.profile).collect();
        let form = BodyPieces::revolved(&profiles, &machine.spindle.gauge_pose, tool.gauge_length);
        let body = CarriedBody::new(machine, machine.spindle.attached_to, false, Some(tool.number), form);
        (!profiles.is_empty()).then(|| (format!("{word} of {}", tool.name), body))
    })
}

/// Joints that carry an attachment, from the base.
fn carriers(machine: &Machine, attached: Attachment) -> Vec<usize> {
    let Attachment::Joint(joint) = attached else { return Vec::new() };
    let of = |chain: &[usize]| chain.iter().position(|&j| j == joint).map(|end| chain[..=end].to_vec());
    of(&machine.tool_chain).or_else(|| of(&machine.work_chain)).unwrap_or_default()
}

/// Machine bodies with one joint between them.
fn are_neighbors(machine: &Machine, a: &CarriedBody, b: &CarriedBody) -> bool {
    let (x, y) = (carriers(machine, a.attached), carriers(machine, b.attached));
    let (short, long) = if x.len() < y.len() { (x, y) } else { (y, x) };
    a.is_machine && b.is_machine && long.len() == short.len() + 1 && long.starts_with(&short)
}

/// Whether a body is one of revolution about the joint between it and its neighbor, except for facets: its
/// corners of each height and radius lie all round the axis.
fn is_round(machine: &Machine, body: &CarriedBody, other: &CarriedBody) -> bool {
    let (own, theirs) = (carriers(machine, body.attached), carriers(machine, other.attached));
    let Some(&joint) = (if own.len() > theirs.len() { own } else { theirs }).last() else { return false };
    let axis = &machine.joints[joint];
    if !axis.is_rotary() || axis.turn_shift.is_some() {
        return false;
    }
    let across =
        axis.direction.cross(&if axis.direction.x.abs() < 0.9 { Vector::x() } else { Vector::y() }).normalize();
    let third = axis.direction.cross(&across);
    let corners = body.form.pieces.iter().flatten().map(|p| {
        let way = p - axis.point;
        let (x, y) = (way.dot(&across), way.dot(&third));
        [way.dot(&axis.direction), x.hypot(y), y.atan2(x)]
    });
    let off_axis: Vec<[f64; 3]> = corners.filter(|c| c[1] > RING_MM).collect();
    let closed = |circle: &[[f64; 3]]| {
        let mut angles: Vec<f64> = circle.iter().map(|c| c[2]).collect();
        angles.sort_by(f64::total_cmp);
        let around = angles.first().copied().unwrap_or_default() + std::f64::consts::TAU;
        let next = angles.iter().skip(1).copied().chain([around]);
        angles.iter().zip(next).all(|(a, b)| b - a < FACET_RAD)
    };
    let circles = clusters(off_axis, 0).into_iter().flat_map(|height| clusters(height, 1));
    let mut circles = circles.peekable();
    circles.peek().is_some() && circles.all(|circle| closed(&circle))
}

/// Corners whose coordinate `k` goes on without a gap.
fn clusters(mut corners: Vec<[f64; 3]>, k: usize) -> Vec<Vec<[f64; 3]>> {
    corners.sort_by(|a, b| a[k].total_cmp(&b[k]));
    corners.chunk_by(|a, b| b[k] - a[k] < RING_MM).map(<[_]>::to_vec).collect()
}

type Pair = (String, String);

fn ordered(a: &str, b: &str) -> Pair {
    if a <= b { (a.into(), b.into()) } else { (b.into(), a.into()) }
}

fn pair_of(value: &Value) -> Option<Pair> {
    Some(ordered(value["bodies"][0].as_str()?, value["bodies"][1].as_str()?))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn check(
    verdict: &Value,
    setup: &Prepared,
    spans: &[ClearanceClaim],
    samples: &[JointSample],
) -> Result<String, TaskError> {
    let machine = &setup.machine;
    let bodies = bodies(setup);
    let clearance = &verdict["clearance"];
    let unchecked: BTreeSet<Pair> = list(&clearance["unchecked"]).iter().filter_map(pair_of).collect();
    let claimed: BTreeMap<Pair, f64> =
        list(&clearance["pairs"]).iter().filter_map(|p| Some((pair_of(p)?, p["proved_mm"].as_f64()?))).collect();
    let passes = |g: &Value| g["name"] == "collision" && g["state"] == "pass";
    let borne =
        |a: &CarriedBody, b: &CarriedBody| a.bears || b.bears || is_round(machine, a, b) || is_round(machine, b, a);
    let bears = |(a, b): &&Pair| matches!((bodies.get(a), bodies.get(b)), (Some(a), Some(b)) if are_neighbors(machine, a, b) && borne(a, b));
    let mut left = unchecked.iter().filter(|p| !bears(p));
    if let Some((a, b)) = left.next().filter(|_| list(&verdict["gates"]).iter().any(passes)) {
        return Err(TaskError(format!("{a} and {b}: not checked, yet the collision gate passes")));
    }
    let found: BTreeSet<Pair> = list(&verdict["findings"]).iter().filter_map(pair_of).collect();
    let mut of_pair: BTreeMap<Pair, Vec<&ClearanceClaim>> = BTreeMap::new();
    for span in spans {
        of_pair.entry(ordered(&span.bodies[0], &span.bodies[1])).or_default().push(span);
    }
    let used: BTreeSet<u32> = samples.iter().filter_map(|s| s.tool).collect();
    let [mut pairs, mut seen, mut neighbors, mut looks, mut by_one_plane, mut boxes, mut asked] = [0_usize; 7];
    let names: Vec<&String> = bodies.keys().collect();
    for (k, one) in names.iter().enumerate() {
        for other in &names[k + 1..] {
            let (a, b) = (&bodies[*one], &bodies[*other]);
            let tool = a.tool.or(b.tool);
            let of_run = tool.is_none_or(|t| used.contains(&t));
            if (a.tool.is_some() && b.tool.is_some()) || a.attached == b.attached || !of_run {
                continue;
            }
            let pair = ordered(one, other);
            if unchecked.contains(&pair) {
                continue;
            }
            let about = |text: String| TaskError(format!("{one} and {other}: {text}"));
            if are_neighbors(machine, a, b) {
                if !claimed.contains_key(&pair) {
                    return Err(about("the pair is missing in the verdict".into()));
                }
                neighbors += 1;
                continue;
            }
            let Some(spans) = of_pair.get(&pair) else {
                return Err(about("the pair has no time span and is not listed as unchecked".into()));
            };
            cover(machine, spans, samples, tool).map_err(about)?;
            pairs += 1;
            let mut known = PairCache::default();
            for span in spans {
                seen += 1;
                holds(machine, &bodies, span, samples, &mut known).map_err(about)?;
            }
            for search in [known.search, known.turned] {
                looks += search.looks;
                by_one_plane += search.by_one_plane;
                (boxes, asked) = (boxes + search.nodes, asked + search.asked);
            }
            let proved = spans.iter().map(|s| (s.distance - s.motion).max(0.0)).fold(f64::INFINITY, f64::min);
            let Some(said) = claimed.get(&pair) else { return Err(about("the pair is missing in the verdict".into())) };
            if (*said - proved).abs() > VERDICT_SLACK_MM {
                return Err(about(format!("the verdict states {said} mm, its spans prove {proved} mm")));
            }
            if proved <= 0.0 && !found.contains(&pair) {
                return Err(about("no clearance is proved, and no finding names the pair".into()));
            }
        }
    }
    Ok(format!(
        "{pairs} pairs, {} spans: no gap over {} samples; {seen} distances and motions hold, {looks} of them by planes, \
         {by_one_plane} by a single one ({boxes} pairs of boxes, {asked} of pieces); {neighbors} pairs of neighbors by the check of the run alone; {} \
         listed as unchecked",
        spans.len(),
        samples.len(),
        unchecked.len()
    ))
}

/// The spans are one after the other and hold all samples.
fn cover(
    machine: &Machine,
    spans: &[&ClearanceClaim],
    samples: &[JointSample],
    tool: Option<u32>,
) -> Result<(), String> {
    let in_place = |s: &JointSample| tool.is_none() || s.tool == tool;
    for two in spans.windows(2) {
        follow(machine, two[0], two[1], samples, &in_place)?;
    }
    let mut first = 0;
    for sample in samples.iter().filter(|s| in_place(s)) {
        while first + 1 < spans.len() && spans[first].time[1] < sample.time {
            first += 1;
        }
        let begun = spans[first..].iter().take_while(|s| s.time[0] <= sample.time + TIME_SLACK_S);
        let near: Vec<&&ClearanceClaim> = begun.filter(|s| sample.time <= s.time[1] + TIME_SLACK_S).collect();
        // Before the first span and beyond the last one nothing moves.
        let outside = sample.time < spans[0].time[0] || spans[spans.len() - 1].time[1] < sample.time;
        let near = if near.is_empty() && outside && tool.is_none() { vec![&spans[first]] } else { near };
        if near.is_empty() {
            return Err(format!("at {} s: a gap", sample.time));
        }
        if !near.iter().any(|s| holds_joints(machine, s, &sample.joints)) {
            let beyond = near.iter().map(|s| beyond(machine, s, &sample.joints));
            let (most, joint) = beyond.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
            let name = machine.joints.get(joint).map_or("a joint", |j| &j.name);
            return Err(format!(
                "at {} s: the joints leave the range of the span: {name} by {most} (mm or radian)",
                sample.time
            ));
        }
    }
    Ok(())
}

/// The second span goes on where the first one ends, or is another part of the same piece of the motion;
/// their ranges touch. Only where the tool is not in the spindle there may be time between them.
fn follow(
    machine: &Machine,
    one: &ClearanceClaim,
    next: &ClearanceClaim,
    samples: &[JointSample],
    in_place: &impl Fn(&JointSample) -> bool,
) -> Result<(), String> {
    let from = samples.partition_point(|s| s.time < one.time[1]);
    let to = samples.partition_point(|s| s.time <= next.time[0]);
    let changed = one.time[1] < next.time[0] && samples.get(from..to).is_some_and(|s| s.iter().any(|s| !in_place(s)));
    if changed {
        return Ok(());
    }
    if one.time[1] != next.time[0] && one.time != next.time {
        return Err(format!("a gap from {} to {} s", one.time[1], next.time[0]));
    }
    let apart = |j: usize| one.low[j].max(next.low[j]) > one.high[j].min(next.high[j]) + JOINT_SLACK;
    match (0..machine.joints.len()).find(|&j| apart(j)) {
        Some(j) => {
            Err(format!("at {} s: {} does not continue from the previous span", next.time[0], machine.joints[j].name))
        }
        None => Ok(()),
    }
}

/// Joint that is farthest outside of the range of a span, and by how much.
fn beyond(machine: &Machine, span: &ClearanceClaim, q: &JointValues) -> (f64, usize) {
    let off = |j: usize| (span.low[j] - q[j]).max(q[j] - span.high[j]);
    (0..machine.joints.len()).map(|j| (off(j), j)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
}

/// Whether the joints are in the range of a span.
fn holds_joints(machine: &Machine, span: &ClearanceClaim, q: &JointValues) -> bool {
    (0..machine.joints.len()).all(|j| in_range(span, q, j))
}

fn in_range(span: &ClearanceClaim, q: &JointValues, j: usize) -> bool {
    span.low[j] - JOINT_SLACK <= q[j] && q[j] <= span.high[j] + JOINT_SLACK
}

/// The body that a span takes at all turns of its joint, with both in the order in which the first is that
/// one; none where all ranges have ends.
fn at_all_turns<'a>(
    machine: &Machine,
    [a, b]: [&'a CarriedBody; 2],
    span: &ClearanceClaim,
) -> Result<Option<(&'a RevolvedBody, [&'a CarriedBody; 2])>, String> {
    let mut joints = span.without_ends();
    let Some(joint) = joints.next() else { return Ok(None) };
    let about = |why: &str| {
        let name = machine.joints.get(joint).map_or("a joint", |j| &j.name);
        Err(format!("from {} s: the range of {name} is unbounded, {why}", span.time[0]))
    };
    if joints.next().is_some() {
        return about("and so is that of another joint");
    }
    if span.straight.is_some() {
        return about("but the joints are stated to move linearly");
    }
    let of = |one: &'a CarriedBody, other: &'a CarriedBody| {
        let (carrier, turned) = one.turned.as_ref()?;
        let alone = *carrier == joint && !carriers(machine, other.attached).contains(&joint);
        alone.then_some((turned, [one, other]))
    };
    match of(a, b).or_else(|| of(b, a)) {
        None => about("and the joint does not turn just one of the two bodies about a fixed axis"),
        found => Ok(found),
    }
}

/// Results of a pair's spans so far that speed up the next one.
#[derive(Default)]
struct PairCache {
    search: SeparationSearch,
    turned: SeparationSearch,
    corners: [JointCorners; 2],
}

/// Distance and motion of one span.
fn holds(
    machine: &Machine,
    bodies: &BTreeMap<String, CarriedBody>,
    span: &ClearanceClaim,
    samples: &[JointSample],
    known: &mut PairCache,
) -> Result<(), String> {
    if !span.is_told() {
        return Err(format!("from {} s: a number is missing, or exceeds all joints and bodies", span.time[0]));
    }
    if span.distance <= span.motion {
        return Ok(());
    }
    let [a, b] = span.bodies.each_ref().map(|name| &bodies[name]);
    let turned = at_all_turns(machine, [a, b], span)?;
    let motion = motion::least(machine, [a, b], span, samples, &mut known.corners);
    if motion > span.motion + SLACK_MM {
        return Err(format!(
            "from {} s: {} mm of motion claimed, the joints make at least {motion} mm",
            span.time[0], span.motion
        ));
    }
    let limit = span.distance - SLACK_MM;
    let nearer = match turned {
        None => known.search.nearer_than(&a.form, &b.form, &RelativePoses::of(machine, [a, b], span), limit),
        Some((turned, [one, other])) => {
            known.turned.turned_nearer_than(turned, &other.form, &RelativePoses::of(machine, [one, other], span), limit)
        }
    };
    if let Some(nearer) = nearer {
        return Err(format!("from {} s: {} mm claimed, {nearer} mm found", span.time[0], span.distance));
    }
    Ok(())
}
