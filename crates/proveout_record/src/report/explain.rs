//! Details of a finding: its tool, the source of its limit, and the lines of the program round it.

use std::collections::{BTreeMap, BTreeSet};

use proveout_machine::Machine;
use proveout_sim::{
    finding::{self, Finding, LimitSource},
    listing::{self, Listing, Wanted},
    observer::Setup,
    verdict::{State, Verdict},
};

use crate::report::{
    blocks::{Blocks, LineNumbers},
    findings::FindingContext,
    format::{compact, length, tool_name},
};

/// Program text up to which the page holds all of it, bytes; it is compressed to about a sixth.
const WHOLE_BYTES: u64 = 1 << 20;
/// Lines before and after a line of interest that the page holds of a longer text.
const AROUND: u32 = 12;
/// Lines of interest of a longer text.
const MOST_LINES: usize = 800;

/// Lines of the program files for the page, and why some are missing.
pub(crate) fn listings(setup: &Setup<'_>, blocks: &Blocks, findings: &[Finding]) -> (Vec<Listing>, String) {
    let files = listing::files(setup);
    let used = |name: &str| {
        blocks.files().iter().any(|f| **f == *name) || findings.iter().any(|f| f.file.as_deref() == Some(name))
    };
    let used: Vec<&(String, u64)> = files.iter().filter(|(name, _)| used(name)).collect();
    if used.iter().map(|(_, bytes)| bytes).sum::<u64>() <= WHOLE_BYTES {
        return (
            used.iter().filter_map(|(name, _)| listing::lines(setup, name, &Wanted::All)).collect(),
            String::new(),
        );
    }
    let mut near: BTreeMap<&str, BTreeSet<u32>> =
        used.iter().map(|(n, _)| (n.as_str(), (1..=AROUND).collect())).collect();
    for f in findings.iter().take(MOST_LINES) {
        if let Some((line, lines)) = f.line.zip(f.file.as_deref().and_then(|name| near.get_mut(name))) {
            lines.extend(line.saturating_sub(AROUND)..=line.saturating_add(AROUND));
        }
    }
    let read = |(name, lines): (&str, BTreeSet<u32>)| listing::lines(setup, name, &Wanted::Lines(lines));
    let words = format!(
        "The program is above {} KiB: its beginning and the lines round findings are shown.",
        WHOLE_BYTES >> 10
    );
    (near.into_iter().filter_map(read).collect(), words)
}

/// For each finding: its tool, its limit's source, its line.
pub(crate) fn explained(
    setup: &Setup<'_>,
    blocks: &Blocks,
    numbers: &LineNumbers,
    findings: &[Finding],
) -> Vec<FindingContext> {
    let tools = &setup.tools.tools;
    let tool = |f: &Finding| {
        let of_block = || tools.get(usize::from(blocks.of_block(f.block?)?.tool?));
        let named = || tools.get(f.tool?.tool);
        named().or_else(of_block).map_or_else(String::new, |t| tool_name(t.number, &t.name))
    };
    let of = |f: &Finding| FindingContext {
        tool: tool(f),
        basis: basis(setup, f),
        line: numbers.named(f.file.as_deref(), f.line),
    };
    findings.iter().map(of).collect()
}

/// Where the limit of a finding comes from.
fn basis(setup: &Setup<'_>, f: &Finding) -> String {
    let t = &setup.scene.file.tolerances;
    let scene = |key: &str| format!("set by {key} in the scene");
    match f.limit_source {
        Some(LimitSource::Travel(joint)) => setup.machine.joints.get(joint).map_or_else(String::new, |j| {
            let note = trust_note(setup.machine, &j.name, &["travel_mm", "travel_deg", "endless"]);
            match setup.machine.travel_is_chosen(j) {
                Some(true) => format!("chosen in the machine file{note}"),
                Some(false) => format!("the machine file has it from a source{note}"),
                None => "the machine file names no source".into(),
            }
        }),
        Some(LimitSource::NearMissTolerance) => scene("tolerances.near_miss_mm"),
        Some(LimitSource::GougeTolerance) => scene("tolerances.gouge_mm"),
        Some(LimitSource::ExcessTolerance) => scene("tolerances.excess_mm"),
        Some(LimitSource::InspectedFeature) => "the tolerance of the feature in the scene".into(),
        Some(LimitSource::SpindleOrTool) => "of the spindle in the machine file or of the tool in its library".into(),
        Some(LimitSource::Tool) => "of the tool in its library".into(),
        Some(LimitSource::ContourCheck) => "the tool may enter its own contour by 0.001 mm".into(),
        None if f.limit.is_none() && f.penetration_mm.is_some() => {
            format!(
                "bodies that meet by up to {} only touch (tolerances.contact_mm in the scene)",
                length(t.contact_mm)
            )
        }
        None => String::new(),
    }
}

/// What the machine file says of a value: its source or the reason of the choice.
fn trust_note(machine: &Machine, joint: &str, keys: &[&str]) -> String {
    let named = keys.iter().map(|key| format!("joint.{joint}.{key}"));
    let wanted: Vec<String> = named.chain([format!("joint.{joint}.*")]).collect();
    let note = wanted.iter().find_map(|key| machine.trust.iter().find(|t| t.key == *key));
    note.filter(|t| !t.note.is_empty()).map_or_else(String::new, |t| format!(": {}", t.note))
}

/// What was not checked, and why: gates, places, and what the twin does not know.
pub(crate) fn unchecked(setup: &Setup<'_>, v: &Verdict) -> Vec<[String; 2]> {
    let mut all: Vec<[String; 2]> = Vec::new();
    for gate in v.gates.iter().filter(|g| g.state == State::Unchecked) {
        all.push([format!("Gate {}", gate.gate), gate.reason.clone()]);
    }
    if setup.scene.file.workholding.is_some() {
        let words = setup.scene.file.workholding_in_words().unwrap_or_default();
        all.push(["Workholding".into(), words]);
    }
    for gate in v.gates.iter().filter(|g| g.state == State::NotAsked) {
        all.push([format!("Gate {}: not asked", gate.gate), gate.reason.clone()]);
    }
    for texture in &v.surface.textures {
        all.extend(texture.unchecked.iter().map(|why| [format!("Texture of {}", texture.name), why.clone()]));
    }
    let used = |number: u32| v.tools.iter().any(|t| t.number == number);
    for tool in setup.tools.tools.iter().filter(|t| used(t.number) && !t.has_holder) {
        let why = "its library gives no holder, so no holder was checked";
        all.push([format!("Holder of {}", tool_name(tool.number, &tool.name)), why.into()]);
    }
    if v.axes.values().all(|a| a.max_following_error.is_none()) {
        all.push(["Drives".into(), "not simulated: no following errors and no drive loads are known".into()]);
    }
    if let Some(floor) = v.deviation.tolerance_floor_mm.filter(|f| *f > 0.0) {
        let why = format!("values below {} are within the resolution of stock and design", length(floor));
        all.push(["Deviations near zero".into(), why]);
    }
    let chosen = setup.machine.trust.iter().filter(|t| t.chosen).count();
    if chosen > 0 {
        let why = format!(
            "{} values of the machine file are chosen, not published: times and limits hold as far as they do",
            compact(chosen as f64)
        );
        all.push(["The machine in the shop".into(), why]);
    }
    let assumed = v.findings.iter().filter(|f| f.code == finding::ASSUMED.code);
    all.extend(assumed.map(|f| {
        let place = f.line.map_or_else(String::new, |l| format!(", line {l}"));
        [format!("A word of the program{place}"), f.message.clone()]
    }));
    all
}
