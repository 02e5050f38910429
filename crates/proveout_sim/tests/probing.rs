//! Programs that probe, on the simulated stock: what they read is what is there, and what they do about it
//! shows.

use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_sim::{
    Choice, Prepared, SimError,
    run::run,
    verdict::{State, Verdict},
};
use tempfile::TempDir;

const TOOLS: &str = "
[[tool]]
number = 1
name = \"MILL_D20\"
kind = \"flat\"
diameter_mm = 20
flute_length_mm = 30
shank_diameter_mm = 20
gauge_length_mm = 100
center_cutting = true
[[tool]]
number = 2
name = \"PROBE_D6\"
kind = \"probe\"
diameter_mm = 6
neck_diameter_mm = 4
neck_length_mm = 40
shank_diameter_mm = 20
gauge_length_mm = 150
";

/// A block of 60 x 60 x 20 mm; `mount` is where it lies on the table, the work offset where it should lie.
fn scene(folder: &TempDir, mount: &str, rest: &str, program: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned();
    let text = format!(
        "name = \"probing\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 0.5\n[stock]\n\
         box = {{ min_mm = [-30, -30, -20], max_mm = [30, 30, 0] }}\n[mount]\n{mount}\n[work_offsets.G54]\nZ_mm = 100\n\
         [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n{rest}",
        root.join("machines/three-axis-mill"),
    );
    let path = folder.path().to_owned();
    fs::write(path.join("scene.toml"), text).expect("written");
    fs::write(path.join("tools.toml"), TOOLS).expect("written");
    fs::write(path.join("main.nc"), program).expect("written");
    path
}

fn verdict(mount: &str, rest: &str, program: &str) -> Result<Verdict, SimError> {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = scene(&folder, mount, rest, program);
    Ok(run(Prepared::read(&path, &Choice::default())?, &mut [], &path)?.verdict)
}

const STRAIGHT: &str = "translation_mm = [0, 0, 100]";

fn codes(verdict: &Verdict) -> Vec<&str> {
    verdict.findings.iter().map(|f| f.code.as_str()).collect()
}

#[test]
fn a_flat_face_is_met_where_it_is() {
    // The ball of 6 mm comes from X50 to the face at X30; its lowest point is at Z-8, its center at Z-5.
    let program = "G21 G17 G90 G54 G94\nT2 M6\nG0 X50. Y3.\nG43 H2 Z20.\nG1 Z-8. F2000\nG31 X0. F300\n\
                   IF [ABS[#5061-33.] GT 0.00001] GOTO 99\nIF [ABS[#5062-3.] GT 0.00001] GOTO 99\n\
                   G1 X50. F2000\nG31 Z-12. F300\nIF [ABS[#5063+12.] GT 0.00001] GOTO 99\nG1 Z20. F2000\nX0.\n\
                   G31 Z-5. F300\nIF [ABS[#5063] GT 0.00001] GOTO 99\nG0 Z50.\nM30\nN99 #3000=1(WRONG)\n";
    let verdict = verdict(STRAIGHT, "", program).expect("it measures what is there");
    let met: Vec<_> = verdict.probing.iter().map(|p| (p.line, p.met.as_deref())).collect();
    assert_eq!(met, [(6, Some("stock")), (10, None), (14, Some("stock"))]);
    let first = &verdict.probing[0];
    let (center, point) = (first.center_mm.expect("known"), first.point_mm.expect("touched"));
    assert!((center[0] - 33.0).abs() < 1e-6 && (center[2] + 5.0).abs() < 1e-6, "{center:?}");
    assert!((point[0] - 30.0).abs() < 1e-6 && (point[1] - 3.0).abs() < 1e-3, "{point:?}");
    assert!((first.normal.expect("touched")[0] - 1.0).abs() < 1e-6);
    // What docs/probing.md promises on a face; ends of rays are kept to a fraction of a micrometer.
    assert!(first.bound_mm.expect("touched") < 1e-3, "{first:?}");
    assert!(!codes(&verdict).contains(&"process-probed"), "the result is known: {:?}", codes(&verdict));
    assert!(!codes(&verdict).contains(&"process-neck-rubs"), "a touch is no rubbing: {:?}", codes(&verdict));
}

#[test]
fn the_center_of_a_milled_bore_is_known_to_a_micrometer() {
    // A bore of 25 mm at X0.10 Y-0.05, milled by the program itself, and probed from X0 Y0 in four
    // directions.
    let program = "G21 G17 G90 G54 G94\nT1 M6\nG0 X0.1 Y-.05\nG43 H1 Z20.\nS2000 M3\nG1 Z-10. F600\nX2.6\nG3 I-2.5 J0.\n\
                   G1 X.1\nG0 Z20.\nM5\nT2 M6\nG0 X0. Y0.\nG43 H2 Z20.\nG1 Z-7. F2000\nG31 X20. F300\n#101=#5061\nG1 X0. F2000\n\
                   G31 X-20. F300\n#102=#5061\nG1 X[[#101+#102]/2.] F2000\nG31 Y20. F300\n#103=#5062\nG1 Y0. F2000\n\
                   G31 Y-20. F300\n#104=#5062\nG1 Y0. F2000\nG0 Z50.\n\
                   IF [ABS[[#101+#102]/2.-.1] GT 0.001] GOTO 99\nIF [ABS[[#103+#104]/2.+.05] GT 0.001] GOTO 99\n\
                   IF [ABS[#103-#104+6.-25.] GT 0.001] GOTO 99\nM30\nN99 #3000=1(WRONG)\n";
    let verdict = verdict(STRAIGHT, "", program).expect("center and diameter are those of the bore");
    assert_eq!(verdict.probing.len(), 4);
    for touch in &verdict.probing {
        let (p, n) = (touch.point_mm.expect("touched"), touch.normal.expect("touched"));
        let radius = (p[0] - 0.1).hypot(p[1] + 0.05);
        assert!((radius - 12.5).abs() < 1e-3, "{touch:?}");
        assert!(touch.bound_mm.expect("touched") < 1e-3, "{touch:?}");
        // The normal points out of the stock: to the axis of the bore.
        assert!((n[0] * (p[0] - 0.1) + n[1] * (p[1] + 0.05)) / radius < -0.9999, "{touch:?}");
    }
}

/// Probes the right face and the front face in two places, and mills a groove of 20 mm along Y whose walls
/// are 20 mm from them; `correct` shifts and turns the work system by what was measured.
fn groove(correct: &str) -> String {
    format!(
        "G21 G17 G90 G54 G94\nT2 M6\nG0 X50. Y0.\nG43 H2 Z20.\nG1 Z-8. F2000\nG31 X20. F300\n#101=#5061-33.\nG1 X50. F2000\n\
         Y-50.\nX20.\nG31 Y-20. F300\n#102=#5062\nG1 Y-50. F2000\nX-20.\nG31 Y-20. F300\n#103=#5062\nG1 Y-50. F2000\nG0 Z50.\n\
         #104=ATAN[#102-#103]/[40.]\n{correct}T1 M6\nG0 X0. Y-45.\nG43 H1 Z20.\nS2000 M3\nG1 Z-5. F600\nY45.\nG0 Z50.\nG69\nM5\nM30\n"
    )
}

#[test]
fn a_drifted_mounting_passes_only_where_the_program_corrects_for_it() {
    // The groove in the workpiece: its walls at x = -10 and 10.
    let walls = "[[inspect]]\nname = \"wall at the front\"\nfrom_mm = [0, -25, -2]\ndirection = \"+x\"\nnominal_mm = 10\ntolerance_mm = 0.01\n\
                 [[inspect]]\nname = \"wall at the back\"\nfrom_mm = [0, 25, -2]\ndirection = \"+x\"\nnominal_mm = 10\ntolerance_mm = 0.01\n";
    let drifted = "translation_mm = [0.3, 0, 100]\nrotation_deg = [0, 0, 0.2]";
    let correct = "G52 X[#101]\nG68 X0. Y0. R[#104]\n";
    let off = |correct: &str| {
        let verdict = verdict(drifted, walls, &groove(correct)).expect("it runs");
        let off: Vec<f64> = verdict.inspection.iter().map(|i| i.measured_mm.expect("a wall") - i.nominal_mm).collect();
        let fails = codes(&verdict).contains(&"geometry-inspection");
        (fails, off)
    };
    let (fails, walls) = off("");
    assert!(fails && walls.iter().any(|w| w.abs() > 0.1), "{walls:?}");
    let (fails, walls) = off(correct);
    assert!(!fails, "{walls:?}");
}

#[test]
fn bad_probing_is_named_with_its_place() {
    let start = "G21 G17 G90 G54 G94\nT2 M6\nG0 X50. Y3.\nG43 H2 Z20.\n";
    // The spindle turns.
    let text = format!("{start}S500 M3\nG1 Z-8. F2000\nG31 X0. F300\nG1 X50. F2000\nG0 Z50.\nM5\nM30\n");
    let turning = verdict(STRAIGHT, "", &text).expect("it runs");
    let finding = turning.findings.iter().find(|f| f.code == "process-probe-spindle").expect("found");
    assert_eq!(finding.line, Some(7));
    assert!(turning.gates.iter().any(|g| g.gate.name() == "process" && g.state == State::Fail));
    // A result before it is measured: the fault of the text, before anything moves.
    let text = format!("{start}G1 X[#5061] F300\nM30\n");
    let fault = verdict(STRAIGHT, "", &text).expect_err("refused").to_string();
    assert!(fault.contains("main.nc") && fault.contains("#5061"), "{fault}");
    // The stem beside the ball, and the ball on a way that does not measure.
    let text = format!("{start}G1 Z-8. F2000\nX28.\nX50.\nG0 Z50.\nM30\n");
    assert!(codes(&verdict(STRAIGHT, "", &text).expect("it runs")).contains(&"process-neck-rubs"));
    // A mill in the spindle measures nothing: as before.
    let text = "G21 G17 G90 G54 G94\nT1 M6\nG0 X50. Y3.\nG43 H1 Z20.\nG31 X45. F300\nM30\n";
    let unknown = verdict(STRAIGHT, "", text).expect("it runs");
    assert!(codes(&unknown).contains(&"process-probed"));
    assert!(unknown.gates.iter().any(|g| g.gate.name() == "process" && g.state == State::Unchecked));
}
