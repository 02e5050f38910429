//! `cargo xtask cone-frustum`: writes the programs of `scenes/cone-frustum`.

mod geometry;
mod plan;
mod program;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::TaskError;

/// Writes `bc.mpf` and `ac.mpf` and says what was written; with `check`, only compares.
pub(crate) fn run(root: &Path, check: bool) -> Result<(), TaskError> {
    let folder = root.join("scenes/cone-frustum");
    let cone = plan::cone();
    let [x, y, z] = cone.apex;
    println!("cone: apex X{x:.6} Y{y:.6} Z{z:.6}, axis {:?}", cone.axis);
    println!("depth along the tool at most {:.3} mm", plan::greatest_depth());
    for target in program::TARGETS {
        let written = program::write(&target);
        let path = folder.join(format!("{}.mpf", target.name));
        crate::files::put(&path, &written.text, check, "cargo xtask cone-frustum")?;
        println!("{}: {} blocks", path.display(), written.text.lines().count());
        for pass in &written.passes {
            println!(
                "  {}: {} blocks a turn, {:.3} um between blocks, starts {} mm further off",
                pass.name,
                pass.blocks_per_turn,
                1000.0 * pass.entry,
                pass.clear_offset
            );
        }
    }
    Ok(())
}
