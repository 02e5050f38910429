//! What can be known of a run before anything moves: causes of the findings that would follow, the most
//! likely one first, each with the line that would mend it.
//!
//! One reading pass follows the tool (`program_trace`); nothing is planned and nothing is cut. A cause is a
//! hint: the run decides. What is missing altogether (work offsets, tools, subprograms) is refused before, by
//! the survey of the program, all of it at once.

use std::path::Path;

use proveout_geom::{Aabb, Point};
use proveout_machine::Machine;
use proveout_nc::{AXIS_LETTERS, Location, ProgramText, ToolName};

use crate::{
    prepare::{
        control_settings::length_active_after_change,
        prepared::Prepared,
        program_extent::{MachineMove, NO_TURN, Reading, ToolUse, at_start, reading},
    },
    setup::{
        causes::{lines, never_changed, outside_travel},
        first_part::{
            place::{Fit, PAST_TRAVEL, fit},
            shown,
        },
    },
};

pub use crate::setup::causes::Cause;

/// A rapid descent deeper than this into the box of the stock is reported, mm.
const CONTACT_MM: f64 = 0.01;
/// A drill goes through the stock by so much, mm.
const BELOW_MM: f64 = 5.0;
/// Positions of a joint that differ by less are the same, mm or radian: rounding.
const SAME_POSITION: f64 = 1e-9;

/// What has lengths come with the tool on a control whose programs have no word for them.
const WITH_TOOL: &str = "; where lengths come with the tool on your control, name a file under [control] file that says so: inherits = \"fanuc-0i\", \
                         [tool_length] without_h = \"tool\", [words] M6 = { does = \"M6 G43\" }";

/// Everything that can be known before a run.
pub fn preflight(prepared: &Prepared) -> Vec<Cause> {
    if prepared.made.is_some() {
        return Vec::new();
    }
    let dialect = prepared.survey.dialect;
    let in_spindle = at_start(prepared);
    let reading = reading(prepared);
    let tools = || prepared.tools.tools.iter();
    let cutting: Vec<&ToolUse> = reading.tools.iter().filter(|t| t.feeds > 0).collect();
    let stock = prepared.stock.bounds();
    let mut all = Vec::new();

    // Design and stock in other units explain everything that follows.
    let room = reading.feed();
    if let Some(mesh) = &prepared.part_mesh {
        all.extend(design(&mesh.aabb(), &stock.union(&room)));
    }
    if let Some(tool) = cutting.iter().find(|t| t.name == ToolName::Empty) {
        let numbers: Vec<u32> = tools().map(|t| t.number).collect();
        let number = numbers.first().copied().unwrap_or(1);
        let at = tool.first_feed.as_ref().unwrap_or(&tool.at);
        all.push(Cause::new(
            format!("the program cuts with no tool in the spindle ({})", lines([at])),
            format!("add to the scene: [start] tool = {number}; tools of the library: {numbers:?}"),
        ));
    }
    all.extend(never_changed(&reading, &in_spindle));
    all.extend(no_length(prepared, &cutting, &stock, length_active_after_change(dialect)));
    all.extend(outside_travel(&prepared.machine, std::slice::from_ref(&reading)));
    all.extend(axes(&prepared.machine, &reading, &prepared.program_path));
    all.extend(first_cuts(prepared, &cutting, &stock));
    let chosen: Vec<&str> = prepared
        .machine
        .joints
        .iter()
        .filter(|j| prepared.machine.travel_is_chosen(j) == Some(true))
        .map(|j| j.name.as_str())
        .collect();
    if !chosen.is_empty() {
        let what = format!("the travel of {} of {} is chosen, not published", chosen.join(", "), prepared.machine.name);
        let add = "put the travel of your own machine into a copy of its machine.toml before you trust a verdict about limits";
        all.push(Cause { note: true, ..Cause::new(what, add) });
    }
    all
}

fn design(own: &Aabb, room: &Aabb) -> Option<Cause> {
    let (size, other) = (own.size(), room.size());
    let sizes = format!(
        "{:.3} x {:.3} x {:.3} against {:.3} x {:.3} x {:.3} mm",
        size.x, size.y, size.z, other.x, other.y, other.z
    );
    match fit(own, room) {
        Fit::Fits => None,
        Fit::InInch => Some(Cause::new(
            format!(
                "the design is about 25.4 times smaller than stock and cuts ({sizes}): its numbers look like inches"
            ),
            "export it in millimeters, or let `proveout new --design` write it so; nothing is converted automatically",
        )),
        Fit::Off => {
            let shift = room.center() - own.center();
            Some(Cause::new(
                format!("the design does not overlap stock and cuts ({sizes})"),
                format!(
                    "export it in the coordinates of the workpiece; a shift of {:.1}, {:.1}, {:.1} mm would align their centers",
                    shift.x, shift.y, shift.z
                ),
            ))
        }
    }
}

/// Tools that cut without an active length.
fn no_length(prepared: &Prepared, cutting: &[&ToolUse], stock: &Aabb, with_change: bool) -> Option<Cause> {
    if with_change {
        return None;
    }
    let bare: Vec<&&ToolUse> = cutting.iter().filter(|t| t.bare.is_some() && t.name != ToolName::Empty).collect();
    let first = bare.first()?;
    let names: Vec<String> = bare.iter().map(|t| shown(&t.name)).collect();
    let places = lines(bare.iter().filter_map(|t| t.bare.as_ref()));
    let gauge = prepared
        .tools
        .tools
        .iter()
        .find(|t| first.name == ToolName::Number(t.number) || first.name == ToolName::Name(t.name.clone()))
        .map_or(0.0, |t| t.gauge_length);
    let word = prepared.nc_settings.work_offsets.iter().next();
    let offset = word.map_or_else(String::new, |(word, o)| {
        format!(
            "; if the zero of {word} was taken at the tip of {}: [work_offsets.{word}] Z_mm = {}",
            names[0],
            proveout_tool::plain_number(o.translation[2] + gauge)
        )
    });
    // One tool alone, whose cuts are where the stock is: its zero was taken at its tip.
    let at_tip = cutting.iter().all(|t| t.name == first.name && !t.lengthened)
        && first.feed.intersects(stock)
        && first.feed.min.z > stock.min.z - BELOW_MM
        // With its length on top it would cut nothing: there is one reading alone.
        && !raised(&first.feed, gauge).intersects(stock);
    if let (true, Some((word, _))) = (at_tip, word) {
        return Some(Cause {
            what: format!(
                "tool length compensation is never active: {word} counts to the tip of {}, the only tool that cuts",
                names[0]
            ),
            add: format!("nothing, as long as the zero of {word} is taken at its tip; with another tool its Z changes"),
            note: true,
        });
    }
    let number = if let ToolName::Number(n) = first.name { n.to_string() } else { "1".into() };
    let what = format!(
        "tool length compensation is not active while {} cut{} ({places}): the gauge line goes where the tip is programmed, {gauge:.3} mm too deep with {}",
        names.join(", "),
        if names.len() == 1 { "s" } else { "" },
        names[0]
    );
    // Several tools and no word for a length at all: the text may be of a control that needs none.
    let with_tool = if cutting.len() > 1 && !cutting.iter().any(|t| t.lengthened) { WITH_TOOL } else { "" };
    Some(Cause::new(what, format!("write G43 H{number} after the tool change{offset}{with_tool}")))
}

/// A box higher up.
fn raised(b: &Aabb, by: f64) -> Aabb {
    let up = proveout_geom::Vector::z() * by;
    Aabb { min: b.min + up, max: b.max + up }
}

/// Joints that the program sends past their travel in its own coordinates.
fn axes(machine: &Machine, reading: &Reading, program: &Path) -> Vec<Cause> {
    let mut all = Vec::new();
    for (&j, [low, high]) in &reading.joints {
        let joint = &machine.joints[j];
        let Some([least, most]) = joint.travel else { continue };
        let (below, above) = (least - low.0, high.0 - most);
        if below <= PAST_TRAVEL && above <= PAST_TRAVEL {
            continue;
        }
        let unit = |v: f64| joint.kind.in_unit(v);
        let word = joint.kind.unit();
        let (value, limit, at, over) =
            if below > above { (low.0, least, &low.1, below) } else { (high.0, most, &high.1, -above) };
        let what = format!(
            "{} is sent to {:.3} {word} ({}), {:.3} {word} past its travel of {:.3} {word}{}",
            joint.name,
            unit(value),
            lines([at]),
            unit(over).abs(),
            unit(limit),
            machine.doubt_of_travel(joint)
        );
        // Where the program has sent it by a position of the machine it is still there: that is
        // reported already.
        let letter_of = |m: &MachineMove| machine.joint_for_letter(m.letter) == Some(j);
        if reading.machine_moves.iter().any(|m| letter_of(m) && (m.value - value).abs() < SAME_POSITION) {
            continue;
        }
        let fits = high.0 - low.0 <= most - least;
        let linear = AXIS_LETTERS[..3].iter().any(|l| machine.joint_for_letter(*l) == Some(j));
        if let Some(add) = not_cancelled(reading, program, j, at, [least, most]).filter(|_| linear) {
            all.push(Cause::new(what, add(&joint.name)));
            continue;
        }
        let add = match (fits, linear) {
            (true, true) => format!(
                "a mounting and a work offset that are {:.3} mm further along {} would fit: [mount] translation_mm and [work_offsets] together",
                over + over.signum(),
                joint.name
            ),
            (false, true) => {
                let offsets: Vec<&str> = reading.offsets.iter().map(|(word, _)| word.as_str()).collect();
                let needs = format!(
                    "the program needs {:.3} mm of {} (line {} to line {}) and has {:.3} mm",
                    high.0 - low.0,
                    joint.name,
                    low.1.line,
                    high.1.line,
                    most - least
                );
                let turned = |j: &usize| reading.joints.get(j).is_some_and(|[low, high]| high.0 - low.0 > NO_TURN);
                let table_turns = machine.work_chain.iter().filter(|j| machine.joints[**j].is_rotary()).any(turned);
                match &offsets[..] {
                    // How far apart they lie is a statement of the scene.
                    [_, _, ..] => format!(
                        "{needs}, with {} placed as in this scene: enter their places on your machine",
                        offsets.join(", ")
                    ),
                    // How far a part goes round with its table is one of its place on it.
                    _ if table_turns => {
                        format!(
                            "{needs}, with the part as mounted now: nearer to the axis of the table it needs less \
                             travel"
                        )
                    }
                    _ => format!("{needs}, wherever the part is mounted: correct the two lines, or divide the program"),
                }
            }
            _ => format!("correct the position, or clamp the part so that {} stays in its travel", joint.name),
        };
        all.push(Cause::new(what, add));
    }
    all
}

/// Words that switch tool center point control on, and what ends it, by the beginning of the word.
const TCP_WORDS: [(&str, &str); 7] = [
    ("G43.4", "G49"),
    ("G43.5", "G49"),
    ("G234", "G49"),
    ("G169", "G170"),
    ("TRAORI", "TRAFOOF"),
    ("M128", "M129"),
    ("FUNCTION TCPM", "FUNCTION RESET TCPM"),
];

/// What makes a linear axis leave its travel where rotary axes turn alone under tool center point
/// control that was never cancelled: the tip keeps its place on the part and the axis follows it.
/// Reported only where the axis is past its travel in such a motion, and in no other.
fn not_cancelled(
    reading: &Reading,
    program: &Path,
    j: usize,
    at: &Location,
    [least, most]: [f64; 2],
) -> Option<impl Fn(&str) -> String> {
    let turn = reading.turns.iter().find(|turn| turn.at == *at)?.clone();
    let [low, high] = *reading.joints_besides.get(&j)?;
    if low < least - PAST_TRAVEL || high > most + PAST_TRAVEL {
        return None;
    }
    let text = ProgramText::open(program).ok();
    let own = |at: &Location| Path::new(&*at.file).file_name() == program.file_name();
    let line = |n: u32| text.as_ref()?.line(n as usize).map(str::to_uppercase);
    let said = line(turn.on.line).filter(|_| own(&turn.on)).unwrap_or_default();
    let known = TCP_WORDS.iter().find(|(word, _)| said.contains(word));
    let (word, end) = known.map_or(("tool center point control", "what ends it"), |(word, end)| (*word, *end));
    // The dynamic work offset of a Haas ends with another word.
    let between = (turn.on.line..turn.at.line).find(|n| line(*n).is_some_and(|text| text.contains("G255")));
    let between = between.filter(|_| word == "G234" && own(&turn.at));
    let another = between.map_or_else(String::new, |n| format!(" (G255 in line {n} ends G254)"));
    Some(move |name: &str| {
        format!(
            "rotary axes move alone in line {} under {word} of line {}, which is still active{another}: the tip keeps its place on the part and \
             {name} follows it; without that motion {name} stays in its travel: write {end} before line {}",
            turn.at.line, turn.on.line, turn.at.line
        )
    })
}

/// First motions against the stock before the first cut.
fn first_cuts(prepared: &Prepared, cutting: &[&ToolUse], stock: &Aabb) -> Vec<Cause> {
    let radius = |t: &ToolUse| {
        let known = prepared
            .tools
            .tools
            .iter()
            .find(|own| t.name == ToolName::Number(own.number) || t.name == ToolName::Name(own.name.clone()));
        known.map_or(0.0, |own| own.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max))
    };
    let reach = |t: &ToolUse| {
        let r = radius(t);
        let mut b = t.feed;
        for i in 0..2 {
            b.min[i] -= r;
            b.max[i] += r;
        }
        b
    };
    let upright: Vec<&&ToolUse> =
        cutting.iter().filter(|t| !t.tilted && t.name != ToolName::Empty && !t.feed.is_empty()).collect();
    let mut all = Vec::new();
    let missing: Vec<&&&ToolUse> = upright.iter().filter(|t| !reach(t).intersects(stock)).collect();
    let word = prepared.nc_settings.work_offsets.keys().next().cloned().unwrap_or_else(|| "the work offset".into());
    if !missing.is_empty() && missing.len() == upright.len() {
        let room = upright.iter().fold(Aabb::empty(), |all, t| all.union(&reach(t)));
        let mut shift = stock.center() - room.center();
        // What overlaps already needs no shift.
        for i in 0..3 {
            if room.min[i] <= stock.max[i] && room.max[i] >= stock.min[i] {
                shift[i] = 0.0;
            }
        }
        if shift.z != 0.0 {
            shift.z = stock.max.z - room.max.z;
        }
        let at = missing.iter().filter_map(|t| t.first_feed.as_ref());
        all.push(Cause::new(
            format!("no motion in feed meets the stock (first of each tool in {})", lines(at)),
            format!(
                "{word} shifted by about {:.1}, {:.1}, {:.1} mm would bring the cuts to the stock",
                shift.x, shift.y, shift.z
            ),
        ));
        return all;
    }
    if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(|t| shown(&t.name)).collect();
        all.push(Cause::new(
            format!(
                "{} never meets the stock ({})",
                names.join(", "),
                lines(missing.iter().filter_map(|t| t.first_feed.as_ref()))
            ),
            "check its length and the depth of its cuts",
        ));
    }
    if let Some(first) = upright.first()
        && let Some((at, p)) = &first.first_descent
        && let Some(depth) = depth_in(p, stock, radius(first))
    {
        all.push(Cause::new(
            format!("{} goes down in rapid into the stock before its first cut: {depth:.3} mm below its top ({})", shown(&first.name), lines([at])),
            format!("if the zero lies too low: {word} with Z_mm {:.3} mm higher would clear it; else the stock is too large there", depth + 1.0),
        ));
    }
    all
}

/// How deep a point is below the top of a box; none outside or above it.
fn depth_in(p: &Point, stock: &Aabb, radius: f64) -> Option<f64> {
    let beside =
        (0..2).any(|i| p[i] + radius <= stock.min[i] + CONTACT_MM || p[i] - radius >= stock.max[i] - CONTACT_MM);
    let depth = stock.max.z - p.z;
    (!beside && depth > CONTACT_MM && p.z > stock.min.z).then_some(depth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_depth_counts_only_over_the_stock() {
        let stock = Aabb { min: Point::new(0.0, 0.0, -10.0), max: Point::new(50.0, 30.0, 0.0) };
        assert_eq!(depth_in(&Point::new(10.0, 10.0, -3.0), &stock, 5.0), Some(3.0));
        assert_eq!(depth_in(&Point::new(-5.0, 10.0, -3.0), &stock, 5.0), None, "tangent");
        assert_eq!(depth_in(&Point::new(10.0, 10.0, 2.0), &stock, 5.0), None);
    }
}
