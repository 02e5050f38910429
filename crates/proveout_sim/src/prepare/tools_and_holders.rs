//! The tools of a run: as the call clamps them, the one in the spindle at the start, and the room round their
//! holders.

use std::path::Path;

use proveout_input::{InputError, Step::Key};
use proveout_tool::{Profile, Role, Tool, ToolLibrary};

use crate::{prepare::choice::Choice, scene::Scene};

/// The tool that the scene puts into the spindle is one of its library.
pub(crate) fn check_start_tool(scene: &Scene, tools: &ToolLibrary) -> Result<(), InputError> {
    let Some(number) = scene.file.start.tool else { return Ok(()) };
    if tools.tools.iter().any(|t| t.number == number) {
        return Ok(());
    }
    let message =
        format!("start.tool = {number}: the tool library has no tool of this number ({} tools)", tools.tools.len());
    Err(scene.error_at(&[Key("start"), Key("tool")], message, "add the tool to the library, or correct the number"))
}

/// Clamps tools as the call chooses.
pub(crate) fn clamp_out(tools: &mut ToolLibrary, choice: &Choice, path: &Path) -> Result<(), InputError> {
    for (name, by) in &choice.clamped_out_mm {
        let refused = |message: String| {
            InputError::file(
                path,
                message,
                "choose a tool with a holder, and an overhang at which it is still \
                                             gripped",
            )
        };
        let tool = tools.tools.iter_mut().find(|t| t.name == *name);
        let tool = tool.ok_or_else(|| refused(format!("there is no tool {name:?} whose overhang could change")))?;
        let moved = tool.clamped_out_by(*by);
        *tool = moved.ok_or_else(|| refused(format!("{name} cannot be clamped {by} mm further out")))?;
    }
    Ok(())
}

/// For each tool the parts of its holder, widened by a clearance, mm.
pub(crate) fn holder_zones(tools: &ToolLibrary, clearance: f64) -> Vec<Vec<Profile>> {
    let zones = |t: &Tool| {
        let holder = t.bodies.iter().filter(|b| b.role == Role::Holder);
        holder.filter_map(|b| b.profile.widened(clearance).ok()).collect()
    };
    tools.tools.iter().map(zones).collect()
}
