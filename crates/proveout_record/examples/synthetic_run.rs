//! Writes the run folder of a small run without a controller, to look at: `synthetic_run FOLDER [CELL_MM]`.

#[path = "../tests/support/mod.rs"]
mod support;

use std::path::PathBuf;

use proveout_record::{RerunMode, RunInfo, observers, write_run_json};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let folder = PathBuf::from(args.next().ok_or("give a folder")?);
    let cell: f64 = args.next().map_or(Ok(0.5), |c| c.parse())?;
    std::fs::create_dir_all(&folder)?;
    let mode = if cfg!(feature = "rerun") { RerunMode::File } else { RerunMode::Off };
    let mut all = observers(&mode)?;
    support::run(&mut all, &folder, cell, "roughness is not evaluated");
    write_run_json(&folder, &RunInfo { threads: 1, ..RunInfo::default() })?;
    Ok(())
}
