//! Every tool of a library through the whole chain: called by name, plunged, and the hole is that of its
//! profile.

use std::fs;

use proveout_sim::{Choice, verdict::State};
use proveout_tests::{prove, root};
use proveout_tool::{Tool, ToolLibrary};

/// Distance of the rays of the narrow tools, mm; divides the depth, so that whole layers are cut: fine enough
/// that the narrowest tool, a drill of 3.3 mm, is met by 30 rays across.
const CELL_MM: f64 = 0.1;
/// A circle of 33 cells is counted with an area that is right to one part in fifty; wider ones are better.
const VOLUME_TOLERANCE: f64 = 0.02;

/// Volume of the cutting part below a height over the tip, mm³, by the midpoint rule on the radius.
fn volume_below(tool: &Tool, height: f64) -> f64 {
    let steps = 4000;
    let dz = height / f64::from(steps);
    let radius = |z: f64| tool.cutting().filter_map(|b| b.profile.radius_at(z)).fold(0.0, f64::max);
    (0..steps).map(|k| std::f64::consts::PI * radius((f64::from(k) + 0.5) * dz).powi(2) * dz).sum()
}

#[test]
fn each_tool_drills_the_hole_of_its_profile() {
    let library = root().join("tools/axis-cross.toml");
    let tools = ToolLibrary::read(&library).expect("the library is in order").tools;
    assert_eq!(tools.len(), 8, "face mill, five end mills and deburring cutters, drill");
    for tool in &tools {
        let depth = 3.0;
        let half = tool.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max).min(26.0) + 1.0;
        let folder = tempfile::tempdir().expect("temporary folder");
        let program = format!(
            "G17 G54 G90 G94 G710 G60\nT=\"{}\"\nM6\nG0 X0 Y0 Z5 S3000 M3 D1\nG1 Z-{depth} F200\nG0 Z5\nM5\nM30\n",
            tool.name
        );
        let scene = format!(
            "name = \"plunge\"\nmachine = {:?}\ntools = {library:?}\nresolution_mm = {}\n\
             [stock.box]\nmin_mm = [-{half}, -{half}, -5]\nmax_mm = [{half}, {half}, 0]\n\
             [mount]\ntranslation_mm = [0, 0, 150]\n[work_offsets.G54]\nZ_mm = 150\n\
             [[program]]\nname = \"plunge\"\nfile = \"plunge.mpf\"\n",
            root().join("machines/spinner-u5-620"),
            if half > 10.0 { 0.25 } else { CELL_MM },
        );
        fs::write(folder.path().join("plunge.mpf"), program).expect("written");
        fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let run = prove(folder.path(), &Choice::default(), 2).expect("runs");
        let used = &run.verdict.tools;
        assert_eq!(used.len(), 1);
        assert_eq!(used[0].name, tool.name);
        let expected = volume_below(tool, depth);
        let removed = used[0].volume_mm3;
        assert!(
            (removed / expected - 1.0).abs() < VOLUME_TOLERANCE,
            "{}: {removed} mm3 instead of {expected} mm3",
            tool.name
        );
        let process = run.verdict.gates.iter().find(|g| g.gate.name() == "process").expect("a gate");
        // A head with a bore must not plunge, and of a chamfer mill it is not stated whether it cuts at its
        // center.
        let expected = match tool.cuts_at_center() {
            Some(true) => State::Pass,
            Some(false) => State::Fail,
            None => State::Unchecked,
        };
        assert_eq!(process.state, expected, "{}: {process:?}", tool.name);
    }
}
