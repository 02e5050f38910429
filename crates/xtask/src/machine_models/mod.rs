//! `cargo xtask machine-models`: writes `model.glb` and the `[[body]]` tables of the machines in `machines/`.
//!
//! The kinematic numbers come from `machine.toml`, so that table face, pivots and gauge line of a model are
//! those of its machine; proportions of castings, slides and heads are here. All coordinates are those of the
//! machine with all joints at zero.

mod c_frame;
mod gantry;
mod glb;
mod home_zero;
mod hybrid;
mod kinds;
mod library;
mod numbers;
mod part;
mod singles;
mod solid;
mod spindle_heads;
#[cfg(test)]
mod tests;
mod work;

use std::path::Path;

use crate::{TaskError, files};

/// The line of `machine.toml` from which on the bodies are written by this program.
const MARK: &str = "# Bodies: written by `cargo xtask machine-models`, which also makes their shapes in model.glb. Edit nothing below.";

const COMMAND: &str = "cargo xtask machine-models";

/// Writes all models and says how large they are; with `check`, only compares.
pub(crate) fn run(root: &Path, check: bool) -> Result<(), TaskError> {
    let mut total = 0;
    for (folder, build) in library::LIBRARY {
        let path = root.join("machines").join(folder).join("machine.toml");
        let text = files::get(&path)?;
        let (head, _) = text
            .split_once(MARK)
            .ok_or_else(|| TaskError(format!("{}: the line before the bodies is missing:\n{MARK}", path.display())))?;
        let numbers = numbers::KinematicNumbers::read(&path, head)?;
        let parts = build(&numbers)?;
        let model = glb::bytes(&numbers, &parts)
            .map_err(|e| TaskError(format!("{}: {e}", path.with_file_name("model.glb").display())))?;
        let triangles: usize = parts.iter().map(|p| p.solid.triangles.len()).sum();
        println!("{folder}: {} parts, {triangles} triangles, {} kB", parts.len(), model.len() / 1000);
        total += model.len();
        files::put_bytes(&path.with_file_name("model.glb"), &model, check, COMMAND)?;
        files::put(&path, &format!("{head}{MARK}\n{}", part::body_tables(&parts)), check, COMMAND)?;
    }
    println!("{} machines, {} kB", library::LIBRARY.len(), total / 1000);
    Ok(())
}
