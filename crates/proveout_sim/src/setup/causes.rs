//! Causes of findings that the text of a program shows by itself.

use std::collections::BTreeMap;

use proveout_machine::Machine;
use proveout_nc::{Location, ToolName};
use serde::Serialize;

use crate::{prepare::program_extent::Reading, setup::first_part::shown};

/// Most lines that a cause names.
const MAX_LINES: usize = 6;

/// Something that will lead to findings, or keep a gate from being trusted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// What is so, with lines and values.
    pub what: String,
    /// What to write, and where.
    pub add: String,
    /// For information alone: no finding follows from it.
    pub note: bool,
}

impl Cause {
    pub(crate) fn new(what: String, add: impl Into<String>) -> Self {
        Self { what, add: add.into(), note: false }
    }
}

/// `lines 3, 8 and 4 more`.
pub(crate) fn lines<'a>(places: impl IntoIterator<Item = &'a Location>) -> String {
    let mut all: Vec<u32> = places.into_iter().map(|l| l.line).collect();
    all.sort_unstable();
    all.dedup();
    let more = all.len().saturating_sub(MAX_LINES);
    let named: Vec<String> = all.iter().take(MAX_LINES).map(u32::to_string).collect();
    let word = if all.len() == 1 { "line" } else { "lines" };
    if more > 0 {
        format!("{word} {} and {more} more", named.join(", "))
    } else {
        format!("{word} {}", named.join(", "))
    }
}

/// Positions of the machine that a program names and the travel does not hold.
pub(crate) fn outside_travel(machine: &Machine, readings: &[Reading]) -> Vec<Cause> {
    let mut by_letter: BTreeMap<char, Vec<(f64, &Location)>> = BTreeMap::new();
    for m in readings.iter().flat_map(|r| &r.machine_moves) {
        let joint = machine.joint_for_letter(m.letter).map(|j| &machine.joints[j]);
        if joint.is_some_and(|j| j.travel_violation(m.value).is_some()) {
            by_letter.entry(m.letter).or_default().push((m.value, &m.at));
        }
    }
    let cause = |(letter, places): (char, Vec<(f64, &Location)>)| {
        let joint = &machine.joints[machine.joint_for_letter(letter)?];
        let [low, high] = joint.travel?.map(|v| joint.kind.in_unit(v));
        let unit = joint.kind.unit();
        let value = joint.kind.in_unit(places.first()?.0);
        let from_home = places.iter().all(|(v, _)| joint.travel_violation(joint.home + v).is_none());
        let what = format!(
            "{letter} is sent to {value:.3} {unit} of the machine (G53, SUPA, M91 or a reference point, {}), its travel is {low:.3} to {high:.3} \
             {unit}{}",
            lines(places.iter().map(|(_, at)| *at)),
            machine.doubt_of_travel(joint)
        );
        let add = if from_home {
            format!(
                "the program counts from home and {} from its table: write zero = \"home\" as the first line of its machine.toml and take the \
                 work offsets from there (`proveout new` does both in a copy), or write {:.3} for {value:.3}",
                machine.name,
                joint.kind.in_unit(joint.home) + value
            )
        } else {
            format!("correct the position, or travel_{unit} of joint {letter} in the machine file")
        };
        Some(Cause::new(what, add))
    };
    by_letter.into_iter().filter_map(cause).collect()
}

/// Tools that are named one after the other in a text that changes none in: everything is cut with the one in
/// the spindle.
pub(crate) fn never_changed(reading: &Reading, in_spindle: &ToolName) -> Option<Cause> {
    let named: Vec<&(ToolName, Location)> =
        reading.selected.iter().filter(|(name, _)| *name != ToolName::Empty).collect();
    if reading.changes || named.len() < 2 {
        return None;
    }
    let names: Vec<String> = named.iter().map(|(name, _)| shown(name)).collect();
    Some(Cause::new(
        format!(
            "{} are called but never loaded ({}, no M6): everything is cut with {}, the tool in the spindle",
            names.join(", "),
            lines(named.iter().map(|(_, at)| at)),
            shown(in_spindle)
        ),
        "write M6 after each T where the operator changes the tool, or write one program per tool",
    ))
}
