//! Programs that count positions of the machine from home, on a machine whose file counts from its table.
//!
//! `G53 Z0`, `SUPA Z0` and `M91` send an axis home on most machines. A file that counts from the
//! table puts that place far outside of the travel, and every retract of the program into the
//! table. Where the positions fit from home and not as the file counts, the scene gets a copy of
//! the machine with `zero = "home"`. The choice is reported.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use proveout_input::read_input;
use proveout_machine::Machine;

use crate::{
    prepare::program_extent::{MachineMove, OwnZero, Reading},
    setup::causes::lines,
};

/// Folder of the copy in the new scene.
pub(super) const FOLDER: &str = "machine";

/// A machine that is copied into the scene, zero at home.
#[derive(Clone, Debug)]
pub(crate) struct HomeZero {
    /// Text of its file.
    pub(crate) text: String,
    /// Files that it names, to be copied along with it.
    pub(crate) beside: Vec<PathBuf>,
    /// Why.
    pub(crate) reason: String,
}

/// The machine with its zero at home, where the positions of programs fit so and not otherwise.
pub(super) fn chosen(path: &Path, machine: &Machine, readings: &[Reading]) -> Option<(Machine, HomeZero)> {
    let mut outside = Vec::new();
    // Joints whose home has to be at the other end of their travel.
    let mut turned: BTreeMap<usize, f64> = BTreeMap::new();
    // A zero that G10 writes is a position of the machine as well.
    let zeros: Vec<MachineMove> = readings.iter().filter_map(|r| r.own_zero.as_ref()).flat_map(of_zero).collect();
    let moves = || readings.iter().flat_map(|r| &r.machine_moves).chain(&zeros);
    for m in moves().filter(|m| "XYZ".contains(m.letter)) {
        let index = machine.joint_for_letter(m.letter)?;
        let joint = &machine.joints[index];
        // A reference point is where the machine has it, whatever is counted.
        if m.value == joint.home {
            continue;
        }
        if joint.travel_violation(joint.home + m.value).is_some() {
            let own = moves().filter(|o| o.letter == m.letter && o.value != joint.home).map(|o| o.value);
            match other_end(machine, index, own) {
                Some(home) => {
                    turned.insert(index, home);
                }
                // It fits neither way: that is reported, and supports neither reading.
                None if joint.travel_violation(m.value).is_some() => {}
                None => return None,
            }
            continue;
        }
        if joint.travel_violation(m.value).is_some() {
            outside.push(m);
        }
    }
    let first = outside.first()?;
    let file = if path.is_dir() { path.join("machine.toml") } else { path.to_owned() };
    let text = read_input(&file).ok()?;
    let table: toml::Table = toml::from_str(&text).ok()?;
    if table.contains_key("zero") {
        return None;
    }
    let text = turned.iter().try_fold(text, |text, (&j, home)| with_home(&text, &machine.joints[j].name, *home))?;
    let text = format!(
        "# A copy of {}, with X, Y and Z zero at home. Everything else is unchanged: put in the numbers of your own machine.\nzero = \"home\"\n\n{text}",
        machine.name
    );
    let at_home = Machine::from_text(&file, &text).ok()?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let control = table.get("control").and_then(|c| c.get("file"));
    let named = [table.get("model"), control].into_iter().flatten().filter_map(toml::Value::as_str);
    // A name alone: a path that leads elsewhere would not be found from the copy.
    let (plain, elsewhere): (Vec<&str>, Vec<&str>) = named.partition(|n| Path::new(n).components().count() == 1);
    if elsewhere.iter().any(|n| folder.join(n).is_file()) {
        return None;
    }
    let beside = plain.iter().map(|n| folder.join(n)).filter(|p| p.is_file()).collect();
    let reason = format!(
        "assumed: {} is sent to {} of the machine ({}, {}), which {} reaches only where its axes are zero at home; the folder \
         `{FOLDER}` holds a copy of it with zero = \"home\"{}",
        first.letter,
        proveout_tool::plain_number(first.value),
        if zeros.iter().any(|z| z.at == first.at) { "by a work offset of the program" } else { "G53, SUPA or M91" },
        lines(outside.iter().map(|m| &m.at)),
        machine.name,
        if turned.is_empty() {
            String::new()
        } else {
            let names: Vec<&str> = turned.keys().map(|j| machine.joints[*j].name.as_str()).collect();
            format!(", and the home of {} at the other end of its travel", names.join(", "))
        }
    );
    Some((at_home, HomeZero { text, beside, reason }))
}

/// Positions of the axes at a zero that the program writes; where G92 puts it follows from a position that is
/// known.
fn of_zero(zero: &OwnZero) -> Vec<MachineMove> {
    if zero.word == "G92" {
        return Vec::new();
    }
    let at = |(letter, value)| MachineMove { letter, value, at: zero.at.clone() };
    "XYZ".chars().zip(zero.base).map(at).collect()
}

/// The other end of a travel, from which positions `own` of the machine fit; none where the home is published
/// or lies at no end.
fn other_end(machine: &Machine, index: usize, own: impl Iterator<Item = f64>) -> Option<f64> {
    let joint = &machine.joints[index];
    let key = format!("joint.{}.home_mm", joint.name);
    if machine.trust.iter().any(|t| t.key == key && !t.chosen) {
        return None;
    }
    let [low, high] = joint.travel?;
    let home = match (joint.home - low < AT_END_MM, high - joint.home < AT_END_MM) {
        (true, false) => high,
        (false, true) => low,
        _ => return None,
    };
    own.into_iter().all(|value| joint.travel_violation(home + value).is_none()).then_some(home)
}

/// A home this near to the end of the travel lies at it, mm.
const AT_END_MM: f64 = 10.0;

/// The text of a machine file with another home of a joint.
fn with_home(text: &str, joint: &str, home: f64) -> Option<String> {
    let begin = text.find(&format!("name = \"{joint}\""))?;
    let end = text[begin..].find("\n[[").map_or(text.len(), |at| begin + at);
    let at = begin + text[begin..end].find("\nhome_mm = ")? + 1;
    let line_end = text[at..].find('\n').map_or(text.len(), |n| at + n);
    Some(format!("{}home_mm = {}{}", &text[..at], proveout_tool::plain_number(home), &text[line_end..]))
}
