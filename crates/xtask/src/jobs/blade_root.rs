//! `blade-root`: the blade between two platforms of `scenes/blade-root`, finished round its sections except
//! for 0.2 mm. Its design is a body that nothing may touch: a mesh of some 100,000 triangles in addition to
//! the 12 bodies of the machine.
//!
//! The cutter runs 0.2 mm above the mesh all the time, and the near-miss distance is 0.1 mm: the worst case
//! for a check that follows distances by steps.

use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_machine::Machine;
use proveout_nc::Dialect;
use proveout_sim::{Prepared, blade_mesh_of, planning, programs, scene::Scene, scene::StrategyFile};
use proveout_tool::ToolLibrary;

use crate::TaskError;

/// Chord error that gives the mesh its 100,000 triangles, mm.
const CHORD_MM: f64 = 0.006;

/// Writes the job below a folder; returns its scene.
pub(super) fn write(root: &Path, out: &Path) -> Result<PathBuf, TaskError> {
    let folder = out.join("blade-root");
    let wrong = |e: &dyn std::fmt::Display| TaskError(format!("{}: {e}", folder.display()));
    fs::create_dir_all(&folder).map_err(|e| wrong(&e))?;
    let path = folder.join("scene.toml");
    let put = |with_program: bool| fs::write(&path, scene(root, with_program)).map_err(|e| wrong(&e));
    // What is planned and meshed comes from the scene itself.
    put(false)?;
    let read = Scene::read(&path).map_err(|e| wrong(&e))?;
    let made = blade_mesh_of(&read, 0.0, Some(CHORD_MM)).map_err(|e| wrong(&e))?;
    proveout_record::write_mesh(&folder.join("design.stl"), "design", "", &made.mesh).map_err(|e| wrong(&e))?;
    let tools = ToolLibrary::read(&read.resolve(&read.file.tools)).map_err(|e| wrong(&e))?;
    let machine = Machine::read(&read.resolve(&read.file.machine)).map_err(|e| wrong(&e))?;
    let Some(strategy) = StrategyFile::named("transverse") else {
        return Err(wrong(&"no strategy named transverse"));
    };
    let planned = planning::plan(&read, &machine, &tools, strategy).map_err(|e| wrong(&e))?;
    let settings = Prepared::reader_settings(&read, None).map_err(|e| wrong(&e))?;
    let text = programs::text(&planned.commands, Dialect::Siemens840d, &settings).map_err(|e| wrong(&e))?;
    fs::write(folder.join("finish.mpf"), text).map_err(|e| wrong(&e))?;
    put(true)?;
    let checked = machine.bodies.iter().filter(|b| b.check).count();
    eprintln!("blade-root: {} triangles, {checked} machine bodies", made.mesh.triangles.len());
    Ok(folder)
}

fn scene(root: &Path, with_program: bool) -> String {
    let at = |path: &str| root.join(path);
    let mut text = format!(
        r#"name = "blade-root-job"
description = "A blade between two platforms finished but for 0.2 mm, its design a body of some 100,000 triangles"
machine = {machine:?}
tools = {tools:?}
resolution_mm = 0.5

[part]
sections = {sections:?}

[part.blade]
kind = "sections"
chord_error_mm = 0.01
root = {{ x_mm = 0, platform = {{ fillet_radius_mm = 8, thickness_mm = 12, y_mm = [-33, 33], z_mm = [-33, 33] }} }}
tip = {{ x_mm = 54, platform = {{ fillet_radius_mm = 8, thickness_mm = 8, y_mm = [-33, 33], z_mm = [-33, 33] }} }}

[part.judged_box]
min_mm = [14, -40, -40]
max_mm = [40, 40, 40]

[stock]
blade_allowance_mm = 0.7
source = "chosen: what roughing leaves"

[mount]
translation_mm = [260, 0, 0]

[work_offsets.G54]
X_mm = 260

[[fixture]]
name = "blade adapter"
box = {{ min_mm = [-260, -30, -30], max_mm = [-14.5, 30, 30] }}

[tolerances]
gouge_mm = 0.01
excess_mm = 0.3
near_miss_mm = 0.1

[plan.transverse]
tool = "BALL_D12_LONG"
spindle_rpm = 8000
feed_mm_min = 2000
work_offset = "G54"
tolerance_mm = 0.001
axis = {{ rule = "fixed-head", table = [1, 0, 0], head_deg = 0, lead_deg = 10 }}
lift_mm = 3
clearance_mm = 15
chord_error_mm = 0.001
scallop_mm = 0.010
allowance_mm = 0.2
across = [0, 1]
along = [0.31, 0.69]
"#,
        machine = at("machines/starrag-lx-451"),
        tools = at("tools/blade-root.toml"),
        sections = at("scenes/blade-root/sections.csv"),
    );
    if with_program {
        text.push_str(
            "\n[[fixture]]\nname = \"design\"\nmesh = \"design.stl\"\nmesh_unit = \"mm\"\n\n[[program]]\nname = \"finish\"\nfile = \"finish.mpf\"\ndialect = \"siemens-840d\"\n",
        );
    }
    text
}
