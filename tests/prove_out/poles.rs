//! Great circles of the tool axis at poles, as programs meet them: the first rapid with vectors, a block past
//! the upright tool, the cone inside of which the control may leave the circle, and ends that no circle leads
//! to.

use std::fs;

use proveout_sim::{
    Choice,
    finding::{Finding, Severity},
    run::RunResult,
    scene::Dynamics,
    verdict::State,
};
use proveout_tests::{prove, root};

const TOOLS: &str = "description = \"a ball for five axes\"\n[[tool]]\nnumber = 1\nname = \"BALL_D8\"\nkind = \"ball\"\n\
    diameter_mm = 8.0\nflute_length_mm = 40.0\nshank_diameter_mm = 8.0\noverall_length_mm = 160.0\n\
    gauge_length_mm = 160.0\nflutes = 2\ncenter_cutting = true\n";

const HEAD: &str = "G40 G17 G710 G94 G90\nT=\"BALL_D8\"\nM6\nD1 S3000 M3\nTRAORI\nG54\nORIWKS ORIVECT\n";

/// The program on a small block, on a machine of the library.
fn run(machine: &str, program: &str, control: &str, dynamics: Dynamics) -> RunResult {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = format!(
        "name = \"pole\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 1.0\n\
         [stock]\nbox = {{ min_mm = [0, 0, -15], max_mm = [30, 30, 0] }}\n[mount]\ntranslation_mm = [-15, -15, 120]\n\
         [work_offsets.G54]\nX_mm = -15\nY_mm = -15\nZ_mm = 120\n[control]\n{control}\n\
         [[program]]\nname = \"p\"\nfile = \"p.mpf\"\ndialect = \"siemens-840d\"\n",
        root().join("machines").join(machine),
    );
    fs::write(folder.path().join("tools.toml"), TOOLS).expect("written");
    fs::write(folder.path().join("p.mpf"), format!("{HEAD}{program}M5\nM30\n")).expect("written");
    fs::write(folder.path().join("scene.toml"), scene).expect("written");
    let choice = Choice { dynamics: Some(dynamics), ..Choice::default() };
    prove(folder.path(), &choice, 1).unwrap_or_else(|e| panic!("{machine}: {e}"))
}

/// Vector words of a tool axis at a tilt and an azimuth, degrees.
fn words(tilt: f64, azimuth: f64) -> String {
    let (t, a) = (tilt.to_radians(), azimuth.to_radians());
    format!("A3={:.9} B3={:.9} C3={:.9}", t.sin() * a.cos(), t.sin() * a.sin(), t.cos())
}

/// Findings on the motion; what the block meets in the stock is not the matter here.
fn limit_findings(run: &RunResult) -> Vec<&Finding> {
    run.verdict.findings.iter().filter(|f| f.code.starts_with("limits-")).collect()
}

fn codes(run: &RunResult) -> Vec<&str> {
    limit_findings(run).iter().map(|f| f.code.as_str()).collect()
}

fn limits(run: &RunResult) -> State {
    run.verdict.gates.iter().find(|g| g.gate.name() == "limits").expect("the gate").state
}

/// C is at 0, and the tool upright: where B3 or A3 alone tilts the table, either way round, C turns by a
/// quarter at most.
#[test]
fn the_first_rapid_with_a_vector_turns_the_table_to_where_the_circle_leaves_the_pole() {
    for machine in ["bc-trunnion", "ac-trunnion-620"] {
        for azimuth in [5.0, 15.0, 35.0, 100.0, 175.0, 181.0, 285.0] {
            let program = format!("G0 X5 Y5 Z30 {}\n", words(20.0, azimuth));
            let run = run(machine, &program, "", Dynamics::Planned);
            let c = &run.verdict.axes["C"];
            assert!(c.max - c.min <= 90.001, "{machine} {azimuth}: C from {} to {}", c.min, c.max);
            assert_eq!(codes(&run), Vec::<&str>::new(), "{machine} {azimuth}: {:?}", run.verdict.findings);
            let time = &run.verdict.time;
            let bound = time.path_bound_s.expect("a bound");
            assert!(time.total_s < 1.06 * bound && time.total_s < 10.0, "{machine} {azimuth}: {time:?}");
            assert!(run.verdict.path.max_axis_error_deg.expect("measured") < 2e-6, "{:?}", run.verdict.path);
        }
    }
}

/// Both ends lean by 20 degrees, on circles whose closest point to the upright tool is 0.7 to 10 degrees
/// away.
#[test]
fn a_block_past_the_pole_stays_on_its_circle() {
    for machine in ["bc-trunnion", "ac-trunnion-620"] {
        for closest in [0.7_f64, 2.0, 5.0, 10.0] {
            // Napier: the cosine of the azimuth from the closest point is tan(closest) / tan(20).
            let half = (closest.to_radians().tan() / 20_f64.to_radians().tan()).acos().to_degrees();
            let [from, to] = [words(20.0, 90.0 - half), words(20.0, 90.0 + half)];
            let program = format!("G0 X-6 Y3 Z30 {from}\nG1 X36 Y3 Z30 {to} F3000\n");
            for dynamics in [Dynamics::Ideal, Dynamics::Planned, Dynamics::Servo] {
                let run = run(machine, &program, "", dynamics);
                let path = &run.verdict.path;
                let allowed = match dynamics {
                    // The nine digits of the vectors, and the polynomials of the joints.
                    Dynamics::Ideal => 1e-5,
                    // Corners may be rounded by 0.01 mm over 40 mm; the one between rapid and feed is a stop.
                    Dynamics::Planned => 0.0145,
                    // Lag of two joints that are not matched while one of them turns fast.
                    Dynamics::Servo => 1.0,
                };
                let error = path.max_axis_error_deg.expect("measured");
                println!("{machine} {closest} {dynamics:?}: {error:.6} degrees, {:?}", codes(&run));
                assert!(error < allowed, "{machine} {closest} {dynamics:?}: {error} degrees");
                assert!(dynamics != Dynamics::Servo || error > 1e-5, "{closest}: drives without any lag");
                // From one end to the other C goes round the pole on one side of it: by twice the angle, and
                // no less.
                let c = &run.verdict.axes["C"];
                assert!(c.max - c.min > 2.0 * half - 1.0, "{machine} {closest}: C from {} to {}", c.min, c.max);
                assert!(codes(&run).iter().all(|c| *c == "limits-drive-saturated"), "{:?}", run.verdict.findings);
            }
        }
    }
}

/// The same with a table that tilts to one side alone: the circle through the pole turns C by half a turn
/// there.
#[test]
fn a_block_through_the_pole_runs_on_every_machine() {
    let program = format!("G0 X-6 Y3 Z30 {}\nG1 X36 Y3 Z30 {} F3000\n", words(20.0, 40.0), words(25.0, 220.0));
    for (machine, turn) in [("bc-trunnion", 0.0), ("ac-trunnion-620", 0.0), ("ma-ac-trunnion", 180.0)] {
        let run = run(machine, &program, "", Dynamics::Ideal);
        assert_eq!(codes(&run), Vec::<&str>::new(), "{machine}: {:?}", run.verdict.findings);
        assert!(run.verdict.path.max_axis_error_deg.expect("measured") < 1e-4, "{machine}: {:?}", run.verdict.path);
        let c = &run.verdict.axes["C"];
        let least = if turn == 0.0 { 50.0 } else { 220.0 };
        assert!((c.max - c.min) <= least + 90.01, "{machine}: C from {} to {}", c.min, c.max);
        assert!((c.max - c.min) >= turn, "{machine}: C from {} to {}", c.min, c.max);
    }
}

/// The cone of machine or scene: inside, the circle is left and that is reported with its angle; without one
/// it is followed.
#[test]
fn inside_of_the_cone_the_circle_is_left_and_that_is_reported() {
    let half = (0.0007_f64.to_radians().tan() / 20_f64.to_radians().tan()).acos().to_degrees();
    let program =
        format!("G0 X-6 Y3 Z30 {}\nG1 X36 Y3 Z30 {} F3000\n", words(20.0, 90.0 - half), words(20.0, 90.0 + half));
    let inside = run("bc-trunnion", &program, "", Dynamics::Ideal);
    assert_eq!(codes(&inside), ["limits-pole-crossed"], "{:?}", inside.verdict.findings);
    let finding = limit_findings(&inside)[0];
    assert_eq!((finding.severity, finding.line), (Severity::Warning, Some(9)));
    assert!((finding.value.expect("an angle") - 0.0007).abs() < 1e-6, "{finding:?}");
    // 0.0007 degrees over 40 mm of edge.
    assert!(finding.message.contains("0.000489 mm at the flank"), "{}", finding.message);
    let error = inside.verdict.path.max_axis_error_deg.expect("measured");
    assert!((error - 0.0007).abs() < 1e-5, "{error}");
    let c = |r: &RunResult| r.verdict.axes["C"].max - r.verdict.axes["C"].min;
    assert!(c(&inside) < 130.0, "{}", c(&inside));
    assert_ne!(limits(&inside), State::Fail);

    let followed = run("bc-trunnion", &program, "pole_cone_deg = 0", Dynamics::Ideal);
    assert_eq!(codes(&followed), Vec::<&str>::new(), "{:?}", followed.verdict.findings);
    assert!(followed.verdict.path.max_axis_error_deg.expect("measured") < 1e-5);
    assert!(c(&followed) > 179.0, "{}", c(&followed));

    let half = (0.7_f64.to_radians().tan() / 20_f64.to_radians().tan()).acos().to_degrees();
    let program =
        format!("G0 X-6 Y3 Z30 {}\nG1 X36 Y3 Z30 {} F3000\n", words(20.0, 90.0 - half), words(20.0, 90.0 + half));
    let wide = run("bc-trunnion", &program, "pole_cone_deg = 1", Dynamics::Ideal);
    assert_eq!(codes(&wide), ["limits-pole-crossed"]);
    assert!((limit_findings(&wide)[0].value.expect("an angle") - 0.7).abs() < 1e-4);
}

/// Positions of the rotary axes are reached as programmed, and a circle that does not lead there is reported.
#[test]
fn positions_that_no_circle_leads_to_are_reported() {
    let program = "G0 X0 Y0 Z30 B20 C0\nG1 X30 Z30 B-20 C6 F3000\n";
    let run = run("bc-trunnion", program, "", Dynamics::Ideal);
    assert_eq!(codes(&run), ["limits-off-circle"], "{:?}", run.verdict.findings);
    let finding = limit_findings(&run)[0];
    assert_eq!((finding.severity, finding.line), (Severity::Error, Some(9)));
    assert_eq!(limits(&run), State::Fail);
    let (stated, measured) = (finding.value.expect("an angle"), run.verdict.path.max_axis_error_deg.expect("measured"));
    assert!(stated > 0.5 && (stated - measured).abs() < 0.01 * stated, "told {stated}, measured {measured}");
}
