//! Values that nobody has measured, in the message of a finding that depends on them.

use proveout_tool::{Role, ToolLibrary};

use crate::{
    prepare::prepared::Prepared,
    scene::{FixtureFile, FixtureFrame},
};

/// Where the place of the workpiece on the table is assumed.
pub(crate) const ASSUMED_MOUNT: &str = "; the place of the part on the table is assumed: write your own `translation_mm` under [mount] of the scene, with the work offsets";

/// Assumed dimensions on which a finding about a part of the tool depends, in words; empty where
/// all are given.
pub(crate) fn chosen_of_tool(tools: &ToolLibrary, index: usize, part: Option<Role>) -> String {
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

/// Whether a body is a fixture whose place is given in coordinates of the workpiece.
pub(crate) fn is_fixed_to_work(prepared: &Prepared, body: &str) -> bool {
    let own = |f: &FixtureFile| f.name == body && f.frame == FixtureFrame::Workpiece;
    prepared.scene.file.fixture.iter().any(own)
}
