//! Jobs that represent what a user waits for: whole runs with all gates on, to be timed and profiled.
//!
//! `raster`: 81 lines of 161 points over 40 x 40 mm (13,041 moves of 0.25 mm) with a ball of radius 3 mm, 0.2
//! mm cells. The tool axis runs on a cone of 15 degrees about a mean that leans 15 degrees, once round every
//! 20 mm: once each turn it passes through the pole of a machine whose table turns about Z, and on a machine
//! whose table turns about X it is a common nutating motion.
//!
//! `blade-root`: see there.

mod blade_root;

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use crate::TaskError;

const LINES: u32 = 81;
const POINTS: u32 = 161;
const SIDE_MM: f64 = 40.0;
/// Half angle of the cone of axes and lean of its middle.
const CONE_DEG: f64 = 15.0;
/// Way of one turn.
const TURN_MM: f64 = 20.0;

const TOOLS: &str = r#"description = "The ball end mill of the raster; all dimensions chosen"

[[tool]]
number = 1
name = "BALL_D6"
kind = "ball"
diameter_mm = 6.0
flute_length_mm = 15.0
shank_diameter_mm = 6.0
overall_length_mm = 80.0
gauge_length_mm = 120.0
flutes = 2
center_cutting = true
source = "none: a usual long ball end mill"

[tool.holder]
name = "shrink-fit chuck"
sections = [
    { diameter_mm = 21.0, top_diameter_mm = 27.0, length_mm = 50.0 },
    { diameter_mm = 63.0, length_mm = 19.1 },
]
"#;

/// A machine and the place of the block on it.
struct BlockMount {
    machine: &'static str,
    mount_mm: [f64; 3],
    home: &'static str,
}

const PLACES: [BlockMount; 2] = [
    BlockMount { machine: "starrag-lx-451", mount_mm: [260.0, 0.0, 40.0], home: "G0 SUPA Z500\nG0 SUPA A0 B0\n" },
    BlockMount { machine: "bc-trunnion", mount_mm: [0.0, 0.0, 120.0], home: "G0 SUPA Z450\nG0 SUPA B0 C0\n" },
];

/// Writes the jobs below a folder; returns their scenes.
pub(crate) fn write(root: &Path, out: &Path) -> Result<Vec<PathBuf>, TaskError> {
    let wrong = |path: &Path| {
        let path = path.display().to_string();
        move |e: std::io::Error| TaskError(format!("{path}: {e}"))
    };
    let root = root.canonicalize().map_err(wrong(root))?;
    let mut scenes = Vec::new();
    for place in &PLACES {
        let folder = out.join(format!("raster-{}", place.machine));
        fs::create_dir_all(&folder).map_err(wrong(&folder))?;
        for (name, text) in
            [("tools.toml", TOOLS.to_owned()), ("raster.mpf", raster(place)), ("scene.toml", scene(&root, place))]
        {
            let path = folder.join(name);
            fs::write(&path, text).map_err(wrong(&path))?;
        }
        scenes.push(folder);
    }
    scenes.push(blade_root::write(&root, out)?);
    Ok(scenes)
}

fn scene(root: &Path, place: &BlockMount) -> String {
    let [x, y, z] = place.mount_mm;
    let machine = root.join("machines").join(place.machine);
    format!(
        r#"name = "raster-{name}"
description = "A raster of 13,041 moves with an axis that nutates"
machine = {machine:?}
tools = "tools.toml"
resolution_mm = 0.2

[stock]
box = {{ min_mm = [-2, -2, -20], max_mm = [42, 42, 0] }}

[mount]
translation_mm = [{x}, {y}, {z}]

[work_offsets.G54]
X_mm = {x}
Y_mm = {y}
Z_mm = {z}

[control]
dynamics = "planned"

[[fixture]]
name = "post"
box = {{ min_mm = [11, 11, -40], max_mm = [29, 29, -20.5] }}

[[program]]
name = "raster"
file = "raster.mpf"
dialect = "siemens-840d"
"#,
        name = place.machine,
    )
}

fn raster(place: &BlockMount) -> String {
    let mut text = format!(
        "G17 G90 G94\nT=\"BALL_D6\"\nM6\nD1\nG54\nS12000 M3\n{}CTOL=0.01 OTOL=-1 G645\nTRAORI\nORIVECT\n",
        place.home
    );
    let (lean_sine, lean_cosine) = CONE_DEG.to_radians().sin_cos();
    let (cone_sine, cone_cosine) = CONE_DEG.to_radians().sin_cos();
    let mut way = 0.0;
    for line in 0..LINES {
        for k in 0..POINTS {
            let along = SIDE_MM * f64::from(k) / f64::from(POINTS - 1);
            let x = if line % 2 == 0 { along } else { SIDE_MM - along };
            let y = SIDE_MM * f64::from(line) / f64::from(LINES - 1);
            let (s, c) = (std::f64::consts::TAU * way / TURN_MM).sin_cos();
            // On the cone about z, then leaned towards x.
            let (u, v, w) = (cone_sine * c, cone_sine * s, cone_cosine);
            let axis = [lean_cosine * u + lean_sine * w, v, lean_cosine * w - lean_sine * u];
            // The ball's center runs 2.5 mm over the face: the tip lies a radius below it along the axis.
            let center = [x, y, 2.5];
            let tip = [0, 1, 2].map(|i| center[i] - 3.0 * axis[i]);
            let words = format!(
                "X{:.4} Y{:.4} Z{:.4} A3={:.8} B3={:.8} C3={:.8}",
                tip[0], tip[1], tip[2], axis[0], axis[1], axis[2]
            );
            if line == 0 && k == 0 {
                let up = [0, 1, 2].map(|i| tip[i] + 20.0 * axis[i]);
                let _ = writeln!(
                    text,
                    "G0 X{:.4} Y{:.4} Z{:.4} A3={:.8} B3={:.8} C3={:.8}\nG1 {words} F2000",
                    up[0], up[1], up[2], axis[0], axis[1], axis[2]
                );
            } else {
                text.push_str(&words);
                text.push('\n');
            }
            way += SIDE_MM / f64::from(POINTS - 1);
        }
    }
    text.push_str("G0 Z60\nTRAFOOF\n");
    text.push_str(place.home.lines().next().unwrap_or_default());
    text.push_str("\nM30\n");
    text
}

#[cfg(test)]
mod tests {
    use proveout_sim::{Choice, Prepared};

    use super::*;

    /// All jobs are written, and read as a run reads them: 13,041 moves each of the rasters, a design of some
    /// 100,000 triangles as a body of the blade. They stay in the folder that `PROVEOUT_JOBS` names: `cargo
    /// xtask jobs` without a build of its own.
    #[test]
    fn every_job_is_one_that_a_run_takes() {
        let temporary = tempfile::tempdir().expect("folder");
        let out = std::env::var_os("PROVEOUT_JOBS").map_or_else(|| temporary.path().to_owned(), PathBuf::from);
        let scenes = write(&crate::workspace_root(), &out).unwrap_or_else(|TaskError(e)| panic!("{e}"));
        assert_eq!(scenes.len(), 3);
        for scene in &scenes {
            let read = Prepared::read(scene, &Choice::default()).unwrap_or_else(|e| panic!("{e}"));
            if scene.ends_with("blade-root") {
                let design = &read.fixtures.iter().find(|(name, _)| name == "design").expect("the design").1;
                assert!((90_000..110_000).contains(&design.triangles.len()), "{}", design.triangles.len());
                assert!(read.machine.bodies.iter().filter(|b| b.check).count() >= 12);
            } else {
                let text = fs::read_to_string(scene.join("raster.mpf")).expect("the program");
                assert_eq!(text.lines().filter(|l| l.contains("A3=") && !l.starts_with('G')).count(), 13_040);
            }
        }
    }
}
