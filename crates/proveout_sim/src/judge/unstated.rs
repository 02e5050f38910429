//! What the gates leave open because it is not stated: workholding, the length of a tool, the path
//! under ideal dynamics.

use proveout_controller::Dynamics;

use crate::{cut::engine::Facts, prepare::prepared::Prepared, verdict::gates::Coverage};

/// A length longer than a tenth of a millimeter by less is not rounded up to the next, tenths of a
/// millimeter.
const ROUNDING: f64 = 1e-6;

/// What the gates that depend on the path say under ideal dynamics.
pub(crate) fn ideal(prepared: &Prepared) -> Option<String> {
    (prepared.dynamics == Dynamics::Ideal).then(|| "dynamics are ideal: the cut ignores corner rounding".to_owned())
}

/// Workholding and lengths of tools, for `collision` and `near_miss`.
pub(crate) fn leave_out(prepared: &Prepared, facts: &Facts, gate: &mut Coverage) {
    let scene = &prepared.scene.file;
    if scene.fixture.is_empty() {
        match (scene.workholding_in_words(), &mut gate.checked) {
            (None, _) => gate.left_out.push(
                "no workholding in the scene: what holds the part was not checked for collision; add [[fixture]], or workholding = \"none\" with \
                 workholding_reason"
                    .to_owned(),
            ),
            (Some(words), Some(checked)) => *checked += &format!("; workholding: {words}"),
            (Some(_), None) => {}
        }
    }
    gate.left_out.extend(assumed_lengths(prepared, facts));
    if let Some(checked) = &mut gate.checked {
        let clamped = used(prepared, facts).filter(|index| prepared.tools.is_length_prescribed(*index));
        let clamped: Vec<String> = clamped
            .filter_map(|index| {
                let tool = prepared.tools.tools.get(index)?;
                Some(format!("{} {:.1} mm", tool.name, tool.overhang()?))
            })
            .collect();
        if !clamped.is_empty() {
            *checked += &format!("; clamped out of the holder as the tool file prescribes: {}", clamped.join(", "));
        }
    }
}

/// Tools of the run that have a holder, as indices in the library, in order of first use.
fn used<'a>(prepared: &'a Prepared, facts: &'a Facts) -> impl Iterator<Item = usize> + 'a {
    let index = move |used: &crate::verdict::verdict_file::ToolUse| {
        prepared.tools.tools.iter().position(|t| t.number == used.number && t.name == used.name)
    };
    facts.tools.iter().filter_map(index).filter(move |i| prepared.tools.tools[*i].has_holder)
}

/// Tools whose length was neither measured nor prescribed: where their holder goes is assumed.
fn assumed_lengths(prepared: &Prepared, facts: &Facts) -> Vec<String> {
    let assumed = used(prepared, facts).filter(|index| prepared.tools.is_length_assumed(*index));
    assumed
        .filter_map(|index| {
            let tool = prepared.tools.tools.get(index)?;
            let out = tool.overhang().map_or_else(
                || format!("its gauge length of {:.1} mm", tool.gauge_length),
                |out| format!("{out:.1} mm out of its holder"),
            );
            let shortest = match prepared.least_overhang_mm.get(&tool.name) {
                // Rounded up: a length that is printed clears.
                Some(least) => format!("the shortest that clears is {:.1} mm", (least * 10.0 - ROUNDING).ceil() / 10.0),
                None => "`proveout run --find-stickout` finds the shortest that clears".to_owned(),
            };
            Some(format!(
                "assumed: the holder of {}, with {out}, a length that was chosen and not measured; {shortest}; state \
                 gauge_length_source = \"measured\" or \"prescribed\" in the tool file",
                tool.name
            ))
        })
        .collect()
}
