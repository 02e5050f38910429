//! Words of the control through whole runs: tool length, probing, drives that saturate, limits that no one
//! has stated.

use std::{fs, path::Path};

use proveout_sim::{
    Choice,
    run::RunResult,
    scene::Dynamics,
    verdict::{GateVerdict, State},
};
use proveout_tests::{prove, root};

/// A block of 40 x 40 x 8 mm on a machine; the folder is given to the caller's changes before the run.
fn run(machine: &Path, file: &str, program: &str, extra: &str, choice: &Choice) -> RunResult {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = format!(
        "name = \"block\"\nmachine = {machine:?}\ntools = {:?}\nresolution_mm = 0.25\n\
         [stock.box]\nmin_mm = [-20, -20, -8]\nmax_mm = [20, 20, 0]\n[mount]\ntranslation_mm = [0, 0, 100]\n\
         [work_offsets.G54]\nZ_mm = 100\n[[program]]\nname = \"block\"\nfile = {file:?}\n{extra}",
        root().join("tools/axis-cross.toml"),
    );
    fs::write(folder.path().join(file), program).expect("written");
    fs::write(folder.path().join("scene.toml"), scene).expect("written");
    prove(folder.path(), choice, 2).unwrap_or_else(|e| panic!("{file}: {e}"))
}

fn three_axis() -> std::path::PathBuf {
    root().join("machines/three-axis-mill")
}

fn gate<'r>(run: &'r RunResult, name: &str) -> &'r GateVerdict {
    run.verdict.gates.iter().find(|g| g.gate.name() == name).expect("a gate")
}

/// A slot across the block, 3 mm deep, with the length words of the caller.
fn slot(length: &str, approach: &str) -> String {
    format!(
        "%\nO1 (SLOT)\nG17 G21 G40 G49 G80 G90 G94\nT3 M6\nG54\nS3000 M3\nG0 X-30. Y0.\n{length} Z5.{approach}\n\
         G1 Z-3. F400.\nX30.\nG0 Z5.\nG49\nG53 G0 Z600.\nM5\nM30\n%\n"
    )
}

/// Of tool 3.
fn gauge_length() -> f64 {
    let tools = proveout_tool::ToolLibrary::read(&root().join("tools/axis-cross.toml")).expect("the library");
    tools.tools.iter().find(|t| t.number == 3).expect("tool 3").gauge_length
}

const FLOOR: &str =
    "[[inspect]]\nname = \"floor\"\nfrom_mm = [0, 0, 5]\ndirection = \"-z\"\nnominal_mm = -3\ntolerance_mm = 0.002\n";

#[test]
fn the_length_of_g43_puts_the_tip_where_the_program_says() {
    let good = run(&three_axis(), "slot.nc", &slot("G43 H3", ""), FLOOR, &Choice::default());
    assert_eq!(gate(&good, "limits").state, State::Pass, "{:?}", good.verdict.findings);
    assert_eq!(gate(&good, "process").state, State::Pass, "{:?}", good.verdict.findings);
    let floor = good.verdict.inspection[0].measured_mm.expect("a floor");
    // A plane face of an end mill: the sweep's bound of 1 micrometer.
    assert!((floor + 3.0).abs() < 0.001, "{floor}");
    // Home is the highest place; after G49 nothing of the tool is added any more to the slide's own Z600.
    let z = &good.verdict.axes["Z"];
    assert!((z.max - 610.0).abs() < 1e-9, "{z:?}");
    // Lowest: work zero 100 mm, depth -3 mm, and the gauge length of tool 3 above the tip.
    let length = gauge_length();
    assert!((z.min - (97.0 + length)).abs() < 1e-6, "{} {length}", z.min);
}

/// Without G43 the gauge line goes where the tip should be: the tool plunges through the block at rapid, and
/// the run says so.
#[test]
fn without_g43_the_tool_crashes_and_the_run_says_so() {
    let wrong = run(&three_axis(), "slot.nc", &slot("", ""), FLOOR, &Choice::default());
    assert_eq!(wrong.verdict.verdict, State::Fail);
    let codes: Vec<&str> = wrong.verdict.findings.iter().map(|f| f.code.as_str()).collect();
    assert!(codes.contains(&"collision-bodies") || codes.contains(&"limits-overtravel"), "{codes:?}");
    // The same after G49 in the middle of a program.
    let cancelled = run(&three_axis(), "slot.nc", &slot("G43 H3", "\nG49\nG0 Z5."), FLOOR, &Choice::default());
    assert_eq!(cancelled.verdict.verdict, State::Fail);
}

/// A length of the program itself (G10 L10, G43.1) is taken instead of the library's.
#[test]
fn a_length_that_the_program_writes_counts_instead_of_the_library() {
    let length = gauge_length();
    // One millimeter too long in the table of the control: the tip stays one millimeter high.
    let text = slot("G43 H7", "").replace("T3 M6\n", &format!("T3 M6\nG10 L10 P7 R{:.3}\n", length + 1.0));
    let high = run(&three_axis(), "slot.nc", &text, FLOOR, &Choice::default());
    let floor = high.verdict.inspection[0].measured_mm.expect("a floor");
    assert!((floor + 2.0).abs() < 0.001, "{floor}: {:?}", high.verdict.findings);
}

#[test]
fn a_probing_motion_leaves_the_process_gate_unchecked_and_is_reported_with_its_block() {
    let program = |probe: &str| {
        format!(
            "%\nO2 (PROBE)\nG17 G21 G40 G49 G80 G90 G94\nT3 M6\nG54\nG0 X-30. Y0.\nG43 H3 Z20.\n{probe}\nG0 Z20.\nM30\n%\n"
        )
    };
    let plain = run(&three_axis(), "probe.nc", &program("G1 Z3. F100."), "", &Choice::default());
    assert_eq!(gate(&plain, "process").state, State::Pass, "{:?}", plain.verdict.findings);
    let probed = run(&three_axis(), "probe.nc", &program("G31 Z3. F100."), "", &Choice::default());
    let process = gate(&probed, "process");
    assert_eq!(process.state, State::Unchecked, "{}", process.reason);
    assert!(process.reason.contains("1 probing motion"), "{}", process.reason);
    let matches: Vec<_> = probed.verdict.findings.iter().filter(|f| f.code == "process-probed").collect();
    assert_eq!(matches.len(), 1, "{:?}", probed.verdict.findings);
    assert_eq!(matches[0].line, Some(8));
    // The probe runs to its end at the programmed feed and stops there; the plain motion turns back within
    // the path tolerance of the control, 0.01 mm, and takes as long but for the ramps.
    let lowest = |r: &RunResult| r.verdict.axes["Z"].min;
    let reach = 100.0 + 3.0 + gauge_length();
    assert!((lowest(&probed) - reach).abs() < 1e-9, "{} {reach}", lowest(&probed));
    assert!((lowest(&plain) - reach).abs() < 0.0101, "{} {reach}", lowest(&plain));
    let feed_time = |r: &RunResult| r.verdict.time.cutting_s;
    assert!((feed_time(&probed) - 17.0 * 60.0 / 100.0).abs() < 0.1, "{}", feed_time(&probed));
    assert!((feed_time(&plain) - feed_time(&probed)).abs() < 0.1);
    assert_ne!(probed.verdict.verdict, State::Pass, "a run with a probe is never a pass");
}

/// Machine file of the library with lines changed, in a folder of its own next to its model.
fn changed(name: &str, folder: &Path, change: impl Fn(String) -> String) -> std::path::PathBuf {
    let from = root().join("machines").join(name);
    let text = fs::read_to_string(from.join("machine.toml")).expect("readable");
    fs::write(folder.join("machine.toml"), change(text)).expect("written");
    if from.join("model.glb").is_file() {
        fs::copy(from.join("model.glb"), folder.join("model.glb")).expect("copied");
    }
    folder.to_path_buf()
}

#[test]
fn a_drive_that_saturates_is_a_finding_that_fails_the_limits() {
    let servo = Choice { dynamics: Some(Dynamics::Servo), ..Choice::default() };
    let strong = run(&three_axis(), "slot.nc", &slot("G43 H3", ""), FLOOR, &servo);
    assert_eq!(
        gate(&strong, "limits").state,
        State::Pass,
        "{}: {:?}",
        gate(&strong, "limits").reason,
        strong.verdict.findings
    );
    assert!(gate(&strong, "limits").reason.contains("force of every drive"));
    // The drives leave a mark of micrometers on the floor, not more: weight is held by the integral part.
    let floor = strong.verdict.inspection[0].measured_mm.expect("a floor");
    assert!((floor + 3.0).abs() < 0.01, "{floor}");

    let folder = tempfile::tempdir().expect("temporary folder");
    // Half of the force that the acceleration of Y takes, which comes from home in rapid.
    let weak = changed("three-axis-mill", folder.path(), |text| {
        let (before, x) = text.split_once("name = \"Y\"").expect("joint Y");
        let (head, rest) = x.split_once("max_force_N = ").expect("its drive");
        let (number, tail) = rest.split_once('\n').expect("a line");
        let force: f64 = number.parse().expect("a number");
        format!("{before}name = \"Y\"{head}max_force_N = {}\n{tail}", 0.3 * force)
    });
    let saturated = run(&weak, "slot.nc", &slot("G43 H3", ""), FLOOR, &servo);
    let found: Vec<_> = saturated.verdict.findings.iter().filter(|f| f.code == "limits-drive-saturated").collect();
    assert!(!found.is_empty(), "{:?}", saturated.verdict.findings);
    for f in &found {
        assert!(f.bodies == ["Y"] && f.unit.as_deref() == Some("N") && f.line.is_some() && f.time_s.is_some(), "{f:?}");
        let (value, limit) = (f.value.expect("a demand"), f.limit.expect("a limit"));
        assert!(value.abs() > limit.abs() && value * limit > 0.0, "{f:?}");
    }
    let limits = gate(&saturated, "limits");
    assert!(limits.state == State::Fail && limits.reason.contains("limits-drive-saturated"), "{}", limits.reason);
    let used = saturated.verdict.axes["Y"].drive_utilisation.expect("a share");
    assert!((used - 1.0).abs() < 1e-9, "{used}");
    assert!(root().join("docs/findings/limits-drive-saturated.md").is_file());
    // The plan alone does not know of forces.
    let planned = run(&weak, "slot.nc", &slot("G43 H3", ""), FLOOR, &Choice::default());
    assert_eq!(gate(&planned, "limits").state, State::Pass);
}

#[test]
fn limits_that_nobody_has_stated_leave_the_gate_unchecked_and_are_named() {
    for (missing, word) in [("max_jerk_mm_s3", "jerk"), ("max_acceleration_mm_s2", "acceleration")] {
        let folder = tempfile::tempdir().expect("temporary folder");
        let machine = changed("three-axis-mill", folder.path(), |text| {
            let kept = text.lines().filter(|l| !l.starts_with(missing));
            kept.collect::<Vec<_>>().join("\n")
        });
        let run = run(&machine, "slot.nc", &slot("G43 H3", ""), FLOOR, &Choice::default());
        let limits = gate(&run, "limits");
        assert_eq!(limits.state, State::Unchecked, "{}", limits.reason);
        for joint in ["X", "Y", "Z"] {
            assert!(limits.reason.contains(&format!("{joint} has no limit of {word}")), "{}", limits.reason);
        }
        assert_ne!(run.verdict.verdict, State::Pass);
        let floor = run.verdict.inspection[0].measured_mm.expect("a floor");
        assert!((floor + 3.0).abs() < 0.001, "{floor}");
    }
}
