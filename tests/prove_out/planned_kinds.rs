//! Planned programs on the kinds of blades, run by the twin: ridges on the convex and the concave side apart,
//! ball and bull-nose, a face without tool center point control, a ruled side by the flank.

use std::{fs, path::Path};

use proveout_machine::Machine;
use proveout_nc::Dialect;
use proveout_sim::planning::{Planned, plan};
use proveout_sim::scene::{Scene, StrategyFile};
use proveout_sim::verdict::Verdict;
use proveout_sim::{Prepared, programs};
use proveout_tests::root;
use proveout_tool::ToolLibrary;

use crate::prove_out::planned::{CHORD_MM, GOUGE_MM, TOLERANCE_MM, as_planned, gates_pass, proved};

/// What is cut, where it is, and with what.
struct Job {
    machine: &'static str,
    /// Tables of the part, the mount and the work offset.
    part: &'static str,
    strategy: &'static str,
    tool: &'static str,
    axis: &'static str,
    /// Keys of the strategy.
    keys: &'static str,
    /// The axis along which the lines' ends are not judged.
    ends: usize,
}

/// The ball of the scene of Li et al., and a bull-nose of the same shank.
fn tools() -> String {
    let ball = fs::read_to_string(root().join("tools/li-2022.toml")).expect("the library");
    let at = ball.find("[[tool]]").expect("a tool");
    let bull = ball[at..].replace("number = 1", "number = 2").replace("\"BALL_D16\"", "\"BULL_D16\"");
    let bull = bull.replace("kind = \"ball\"", "kind = \"bull_nose\"\ncorner_radius_mm = 4.0");
    ball + "\n" + &bull
}

/// With its judged box, or without one before the plan is there.
fn scene(job: &Job, judged: &str) -> String {
    let (part, mount) = job.part.split_at(job.part.find("[mount]").expect("a mount"));
    let Job { machine, strategy, tool, axis, keys, .. } = job;
    let program = if judged.is_empty() { "" } else { "[[program]]\nname = \"main\"\nfile = \"main.mpf\"\n" };
    format!(
        "name = \"kinds\"\nworkholding = \"none\"\nworkholding_reason = \"not part of this test\"\nmachine = \"{}/machines/{machine}\"\ntools = \"tools.toml\"\nresolution_mm = 0.5\n{part}\n{judged}\n\
         [stock]\nblade_allowance_mm = 0.3\n{mount}\n\
         [tolerances]\ngouge_mm = {GOUGE_MM}\nexcess_mm = 0.05\nnear_miss_mm = 0\nscallop_um = 20\n\
         [plan.{strategy}]\ntool = \"{tool}\"\nspindle_rpm = 8000\nfeed_mm_min = 1000\nwork_offset = \"G54\"\n\
         tolerance_mm = {TOLERANCE_MM}\naxis = {axis}\nlift_mm = 2\nclearance_mm = 10\nchord_error_mm = {CHORD_MM}\n{keys}\n{program}",
        root().display()
    )
}

/// Plans the job, judges it inside of its outermost lines, and runs it.
fn done(folder: &Path, job: &Job) -> (Planned, Verdict) {
    let path = folder.join("scene.toml");
    fs::write(folder.join("tools.toml"), tools()).expect("written");
    fs::write(&path, scene(job, "")).expect("written");
    let read = Scene::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let machine = Machine::read(&read.resolve(&read.file.machine)).expect("machine");
    let tools = ToolLibrary::read(&read.resolve(&read.file.tools)).unwrap_or_else(|e| panic!("{e}"));
    let strategy = StrategyFile::named(job.strategy).expect("a strategy");
    let made = plan(&read, &machine, &tools, strategy).unwrap_or_else(|e| panic!("{}: {e}", job.strategy));
    let settings = Prepared::reader_settings(&read, None).expect("settings");
    let program = programs::text(&made.commands, Dialect::Siemens840d, &settings).expect("posted");
    fs::write(folder.join("main.mpf"), program).expect("written");
    // The middle third of the lines: those next to it lie aside where the blade is twisted.
    let left = made.lines.len() / 3;
    let lines = &made.lines[left..made.lines.len() - left];
    let mut bounds = [[f64::MAX, f64::MIN]; 3];
    for contact in lines.iter().flat_map(|l| &l.contacts) {
        for (range, x) in bounds.iter_mut().zip(contact.place.point.coords.iter()) {
            *range = [range[0].min(*x), range[1].max(*x)];
        }
    }
    for (k, range) in bounds.iter_mut().enumerate() {
        // Ridges lie up to the allowance off the surface; a line's ends are those of its ridges.
        let by = if k == job.ends { -1.2 } else { 0.2 };
        *range = [range[0] - by, range[1] + by];
    }
    let corner = |side: usize| bounds.map(|r| r[side]);
    let judged = format!("[part.judged_box]\nmin_mm = {:?}\nmax_mm = {:?}\n", corner(0), corner(1));
    fs::write(&path, scene(job, &judged)).expect("written");
    (made, proved(folder))
}

fn ridges(name: &str, job: &Job) {
    let folder = tempfile::tempdir().expect("a folder");
    let (made, verdict) = done(folder.path(), job);
    as_planned(name, &made, &verdict, true);
}

/// Twenty millimeters out of the middle of the span.
const LU: &str = "[part.blade]\nkind = \"lu\"\nchord_error_mm = 0.01\nroot = { x_mm = 38 }\ntip = { x_mm = 62 }\n\
                  [mount]\ntranslation_mm = [260, 0, 0]\n[work_offsets.G54]\nX_mm = 260";
const HEAD: &str = "{ rule = \"fixed-head\", table = [1, 0, 0], head_deg = 5, lead_deg = 15 }";

fn lu(tool: &'static str, keys: &'static str) -> Job {
    Job { machine: "starrag-lx-451", part: LU, strategy: "quasi-circle", tool, axis: HEAD, keys, ends: 0 }
}

#[test]
fn both_sides_of_the_blade_of_lu_have_the_ridges_asked_for() {
    let keys = "scallop_mm = 0.01\nacross_deg = [80, 100]\nalong = [0.45, 0.51]";
    ridges("lu, convex, ball", &lu("BALL_D16", keys));
    let keys = "scallop_mm = 0.01\nacross_deg = [260, 280]\nalong = [0.45, 0.51]";
    ridges("lu, concave, ball", &lu("BALL_D16", keys));
}

#[test]
fn a_bull_nose_leaves_the_ridges_asked_for_on_both_sides() {
    let keys = "scallop_mm = 0.01\nacross_deg = [65, 115]\nalong = [0.45, 0.51]";
    ridges("lu, convex, bull-nose", &lu("BULL_D16", keys));
    let keys = "scallop_mm = 0.01\nacross_deg = [260, 280]\nalong = [0.45, 0.51]";
    ridges("lu, concave, bull-nose", &lu("BULL_D16", keys));
}

/// The ruled face for the method of Cui et al., laid along the A axis.
#[test]
fn the_face_of_cui_has_the_ridges_asked_for() {
    let job = Job {
        machine: "starrag-lx-451",
        part: "[part.blade]\nkind = \"cui\"\nchord_error_mm = 0.0002\n[mount]\ntranslation_mm = [330, 0, 0]\nrotation_deg = [0, 90, 0]\n[work_offsets.G54]\nX_mm = 330",
        strategy: "iso-parametric",
        tool: "BALL_D16",
        axis: "{ rule = \"fixed-head\", table = [0, 0, 1], head_deg = 5, lead_deg = 15 }",
        keys: "scallop_mm = 0.01\nparameter = \"surface\"\nacross = [0.1, 0.9]\nalong = [0.5, 0.56]\nlongest_step_mm = 1",
        ends: 2,
    };
    ridges("cui, ball", &job);
}

/// A side of a blade without twist is ruled along X, which points up on the table here.
#[test]
fn a_ruled_side_is_cut_by_the_flank() {
    let job = Job {
        machine: "bc-trunnion",
        part: "[part.blade]\nchord_mm = 60\ncamber_angle_deg = 60\nthickness_mm = 8\nleading_radius_mm = 1.6\ntrailing_radius_mm = 1.2\n\
               length_mm = 25\nchord_error_mm = 0.0005\n\
               [mount]\ntranslation_mm = [0, 0, 60]\nrotation_deg = [0, -90, 0]\n[work_offsets.G54]\nZ_mm = 60",
        strategy: "flank",
        tool: "BALL_D16",
        axis: "{ rule = \"ruling\" }",
        keys: "rulings = \"along\"\nacross = [0.65, 0.85]\nalong = [0.2, 0.95]\nbeyond_end_mm = 1\nflank_error_mm = 0.001",
        ends: 1,
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (made, verdict) = done(folder.path(), &job);
    gates_pass("flank", &verdict, &["program", "limits", "process", "collision", "gouge"]);
    let [gouge, left] = [verdict.deviation.gouge_max_mm, verdict.deviation.excess_max_mm].map(|v| v.expect("measured"));
    println!("flank: {} contacts, gouge {:.2} um, left {:.2} um", made.report.contacts, 1e3 * gouge, 1e3 * left);
    assert!(gouge <= GOUGE_MM && left <= CHORD_MM + TOLERANCE_MM + 0.001, "{gouge} {left}");
    assert!(verdict.deviation.samples.is_some_and(|n| n > 40), "{:?}", verdict.deviation);
}
