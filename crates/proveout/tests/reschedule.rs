//! Re-scheduled programs on the command line: what a run keeps, what `reschedule` writes, and which options
//! they take.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::OnceLock,
};

use tempfile::TempDir;

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

pub(crate) fn proveout(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder())
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// The blade of the published experiment with one and a half turns of its program, coarse cells, other
/// options than the default ones, and a tolerance that every chord passes, so that there are findings.
pub(crate) fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().expect("temporary folder");
        let from = root().join("scenes/li-2022-s-theta");
        let path = |p: &str| format!("{:?}", root().join(p).display().to_string());
        let scene = fs::read_to_string(from.join("scene.toml")).expect("the scene");
        let scene = scene
            .replace("\"../../machines/starrag-lx-451\"", &path("machines/starrag-lx-451"))
            .replace("\"../../tools/li-2022.toml\"", &path("tools/li-2022.toml"))
            .replace("resolution_mm = 0.2", "resolution_mm = 2")
            .replace("gouge_mm = 0.03", "gouge_mm = 0.00001")
            .replace("excess_mm = 0.05", "excess_mm = 0.00001")
            .replace("keys = 15", "keys = 9")
            .replace(
                "method = \"s-theta\", from = \"original\"",
                "method = \"s-theta\", from = \"original\", clearance_deg = 45",
            );
        fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let program = fs::read_to_string(from.join("original.mpf")).expect("the program");
        let lines: Vec<&str> = program.lines().collect();
        let text = lines[..600].iter().chain(&["TRAFOOF", "M30"]).map(|l| format!("{l}\n")).collect::<String>();
        fs::write(folder.path().join("original.mpf"), text).expect("written");
        folder
    });
    folder.path()
}

/// A program as `reschedule` writes it.
pub(crate) fn written(words: &[&str], file: &str) -> String {
    let output = proveout(&[&["reschedule", "."], words, &["--output", file, "--force"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read_to_string(folder().join(file)).expect("written")
}

#[test]
#[ignore = "nightly, 21 s"]
fn a_run_keeps_the_text_that_its_findings_cite_and_reschedule_writes_the_same() {
    for (name, method) in [("quaternion", "quaternion"), ("s-theta", "s-theta")] {
        let out = format!("run-{name}");
        let output = proveout(&["run", ".", "--program", name, "--rerun", "off", "--output", &out]);
        assert!(matches!(output.status.code(), Some(1 | 3)), "{}", String::from_utf8_lossy(&output.stderr));
        let run = folder().join(&out);
        let kept = fs::read_to_string(run.join(format!("{name}.mpf"))).expect("the text is kept");
        let verdict = fs::read_to_string(run.join("verdict.json")).expect("written");
        let verdict: serde_json::Value = serde_json::from_str(&verdict).expect("JSON");
        let cited: Vec<_> =
            verdict["findings"].as_array().expect("a list").iter().filter(|f| f["line"].is_u64()).collect();
        assert!(!cited.is_empty(), "a tolerance of nothing is passed somewhere");
        for finding in cited {
            let file = run.join(finding["file"].as_str().expect("a file"));
            let lines =
                fs::read_to_string(&file).expect("the file that a finding cites is in the folder").lines().count();
            assert!(finding["line"].as_u64().expect("a line") <= lines as u64, "{finding}");
        }
        // The options of the scene are those of the command too, whichever way the program is named.
        let by_source = written(&["--program", "original", "--method", method], &format!("{name}-a.mpf"));
        let by_name = written(&["--program", name, "--method", method], &format!("{name}-b.mpf"));
        assert!(by_source == kept && by_name == kept, "{name}: not the program that runs");
    }
}

#[test]
fn set_takes_the_place_of_the_scene() {
    let scene = written(&["--program", "original", "--method", "quaternion"], "k.mpf");
    let nine = written(&["--program", "original", "--method", "quaternion", "--set", "keys=9"], "k9.mpf");
    let other = written(&["--program", "original", "--method", "quaternion", "--set", "keys=15"], "k15.mpf");
    assert!(scene == nine && scene != other);
    let scene = written(&["--program", "original", "--method", "s-theta"], "s.mpf");
    for option in
        ["clearance_deg=50", "inset_deg=4", "theta_unit=radian", "start_flat_mm=4", "end_flat_percent=8", "merge_mm=60"]
    {
        let other = written(&["--program", "original", "--method", "s-theta", "--set", option], "s2.mpf");
        assert!(scene != other, "{option} changes nothing");
    }
}

/// The inset that is looked for has no higher a peak of acceleration than those that are given; what is
/// neither degrees nor that word is refused.
#[test]
fn the_inset_is_searched_over_the_peak_of_acceleration() {
    let peak = |inset: &str, name: &str| {
        let (all, _) = certificate("s-theta", &[&format!("inset_deg={inset}")], name);
        let peaks = all["runs"][0]["constant_feed"].as_array().expect("a list").clone();
        peaks[0]["program_deg"].as_f64().expect("a number")
    };
    let found = peak("search", "inset-search");
    for given in ["1", "2", "3", "5"] {
        let given = peak(given, "inset-given");
        assert!(found <= given * 1.02, "{found} deg/s2, and {given} of an inset that is given");
    }
    let words = ["reschedule", ".", "--program", "original", "--method", "s-theta", "--output", "never-inset.mpf"];
    let output = proveout(&[&words[..], &["--set", "inset_deg=best"]].concat());
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && printed.contains("degrees with a point, or search"), "{printed}");
    // Out of its range it is named, and not the channel that it leaves.
    for given in ["0", "-1", "46", "400"] {
        let output = proveout(&[&words[..], &["--set", &format!("inset_deg={given}")]].concat());
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && printed.contains("inset above 0 to 45 degrees"), "{printed}");
    }
}

#[test]
fn two_programs_with_other_options_must_be_distinguished() {
    let own = tempfile::tempdir().expect("temporary folder");
    let scene = fs::read_to_string(folder().join("scene.toml")).expect("readable");
    let more =
        "\n[[program]]\nname = \"coarse\"\nreschedule = { method = \"quaternion\", from = \"original\", keys = 5 }\n";
    fs::write(own.path().join("scene.toml"), scene + more).expect("written");
    fs::copy(folder().join("original.mpf"), own.path().join("original.mpf")).expect("copied");
    let call = |program: &str| {
        let scene = own.path().display().to_string();
        proveout(&["reschedule", &scene, "--program", program, "--method", "quaternion", "--output", "two.mpf"])
    };
    let refused = call("original");
    let output = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{output}");
    assert!(output.contains("several programs") && output.contains("quaternion, coarse"), "{output}");
    assert_eq!(call("coarse").status.code(), Some(0));
}

/// The certificate of a call with these options, and what it says.
pub(crate) fn certificate(method: &str, options: &[&str], name: &str) -> (serde_json::Value, String) {
    let (program, file) = (format!("{name}.mpf"), format!("{name}.json"));
    let set = options.iter().flat_map(|o| ["--set", o]);
    let words = ["reschedule", ".", "--program", "original", "--method", method, "--output", &program, "--force"];
    let words: Vec<&str> = words.into_iter().chain(["--certificate", &file]).chain(set).collect();
    let output = proveout(&words);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(folder().join(&file)).expect("written");
    (serde_json::from_str(&text).expect("JSON"), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn no_schedule_of_the_channel_is_faster_than_its_bound_and_the_gap_is_reported() {
    let (all, message) = certificate("s-theta", &[], "certified");
    let run = &all["runs"][0];
    let number = |key: &str| run[key].as_f64().expect("a number");
    let (time, bound) = (number("time_s"), number("bound_s"));
    assert!(bound > 0.9 * time && bound <= time, "{bound} {time}");
    assert!((number("gap_percent") - 100.0 * (time / bound - 1.0)).abs() < 1e-9);
    assert!(
        run["new_inside"] == true && run["original_inside"] == false,
        "the pass leaves the channel on the pressure side"
    );
    // A gain is shown with the limits that it depends on.
    assert!(message.contains("percent remain to be gained") && message.contains("at most 62.4 deg/s"), "{message}");
    assert!(message.contains("lowered by the scene; the machine has velocity 360.0"), "{message}");
    let a = run["joints"].as_array().expect("a list").iter().find(|j| j["name"] == "A").expect("the table");
    let gates = a["gates_deg"].as_array().expect("a list");
    assert_eq!(gates.len(), run["least_s"].as_array().expect("a list").len() + 1);
    // Nearly all of the programmed time is proved of the feed, from the ways of the tip, and what stays a
    // condition is reported.
    let (programmed, proved) = (number("programmed_s"), number("feed_bound_s"));
    assert!(proved < programmed && proved > 0.99 * programmed, "{proved} {programmed}");
    assert!(
        message.contains("not proved for all schedules: at block ends the tip path turns at most as sharply"),
        "{message}"
    );
    assert_eq!(run["seams_s"].as_array().expect("a list").len(), gates.len());
    // Linear joints have the range that the channel gives them, and both programs could be run.
    let linear = run["linear"].as_array().expect("a list");
    assert_eq!(linear.len(), 3, "{message}");
    assert!(message.contains("linear joints do not bind; every schedule moves"), "{message}");
    // At constant feed the weights of the dual meet the primal, and the program needs no less.
    let peaks = run["constant_feed"].as_array().expect("a list");
    assert_eq!(peaks.len(), 4, "acceleration and jerk, with and without turning back");
    for peak in peaks {
        let of = |key: &str| peak[key].as_f64().expect("a number");
        assert!(
            of("proved_deg") <= of("reached_deg") * 1.0001 && of("reached_deg") <= 1.05 * of("proved_deg"),
            "{message}"
        );
        assert!(of("program_deg") > of("proved_deg"), "{message}");
    }
    // A wider channel: the gates are wider by the clearance that is left out, on both sides.
    let (wide, _) = certificate("s-theta", &["clearance_deg=40"], "certified-wide");
    let wide_a =
        wide["runs"][0]["joints"].as_array().expect("a list").iter().find(|j| j["name"] == "A").expect("the table");
    for (narrow, wide) in gates.iter().zip(wide_a["gates_deg"].as_array().expect("a list")) {
        let side = |g: &serde_json::Value, k: usize| g[k].as_f64().expect("a number");
        assert!(
            (side(narrow, 0) - side(wide, 0) - 5.0).abs() < 1e-6
                && (side(wide, 1) - side(narrow, 1) - 5.0).abs() < 1e-6
        );
    }
    // Quaternions do not look at the channel: the bound is not about them.
    let (other, message) = certificate("quaternion", &["clearance_deg=50"], "certified-quaternion");
    assert!(other["runs"][0]["ramps_apart"].is_null() && !message.contains("without the first and last"), "{message}");
    assert!(other["runs"][0]["new_inside"] == false && other["runs"][0]["gap_percent"].is_null());
    assert!(message.contains("the bound does not apply to them"), "{message}");
}

#[test]
fn a_method_of_two_angles_has_its_bound_over_cells() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = root().join("scenes/cui-2022-singularity").display().to_string();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let words = ["reschedule", &scene, "--program", "cone-5", "--method", "singularity"];
    let output = proveout(&[&words[..], &["--output", &file("c.mpf"), "--certificate", &file("c.json")]].concat());
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{printed}");
    let all: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(file("c.json")).expect("written")).expect("JSON");
    let run = &all["runs"][0];
    let cells = &run["cells"];
    let number = |value: &serde_json::Value, key: &str| value[key].as_f64().expect("a number");
    // The method turns axes by about what they miss the pole by.
    let stray = number(cells, "stray_deg");
    assert!(stray > 0.9 && stray < 1.3, "{stray}");
    // With the pole in reach no joint has to hurry; each station costs what a window of feed loses at its
    // ends.
    let (own, feed) = (number(cells, "bound_s"), number(run, "feed_bound_s"));
    assert!(own > 0.999 * feed && own <= number(run, "bound_s") && feed <= number(run, "time_s"), "{own} {feed}");
    assert!(cells["potentials_s"].as_array().expect("a list").len() >= 2);
    assert!(number(run, "gap_percent") >= 0.0 && run["new_inside"] == true);
    assert!(printed.contains("with axes within") && printed.contains("by cells of B and C at"), "{printed}");
    assert!(printed.contains("percent remain to be gained"), "{printed}");
}

/// The folder of the small scene with another text in its scene or machine.
pub(crate) fn spoiled(change: impl Fn(String) -> String, machine: impl Fn(String) -> String) -> TempDir {
    let own = tempfile::tempdir().expect("temporary folder");
    let from = root().join("machines/starrag-lx-451");
    fs::create_dir(own.path().join("machine")).expect("made");
    fs::copy(from.join("model.glb"), own.path().join("machine/model.glb")).expect("copied");
    let text = fs::read_to_string(from.join("machine.toml")).expect("the machine");
    fs::write(own.path().join("machine/machine.toml"), machine(text)).expect("written");
    fs::copy(folder().join("original.mpf"), own.path().join("original.mpf")).expect("copied");
    let scene = fs::read_to_string(folder().join("scene.toml")).expect("the scene");
    let scene = scene.replace(&format!("{:?}", from.display().to_string()), "\"machine\"");
    fs::write(own.path().join("scene.toml"), change(scene)).expect("written");
    own
}

#[test]
fn a_program_that_sends_a_joint_past_its_travel_is_not_written() {
    // Two keys lean the tool far enough that Y goes to -33 mm, where the program before stays above -30.
    let own =
        spoiled(|scene| scene, |machine| machine.replacen("travel_mm = [-330, 330]", "travel_mm = [-30, 330]", 1));
    fs::copy(root().join("scenes/li-2022-s-theta/original.mpf"), own.path().join("original.mpf")).expect("copied");
    let scene = own.path().display().to_string();
    let words = ["reschedule", &scene, "--program", "original", "--method", "quaternion", "--set", "keys=2"];
    let output = proveout(&[&words[..], &["--output", "never.mpf", "--certificate", "never.json"]].concat());
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{printed}");
    assert!(printed.contains("original.mpf:") && printed.contains("the new axes send Y to -3"), "{printed}");
    assert!(
        printed.contains("over the whole program Y lacks ") && printed.contains("a larger clearance_deg"),
        "{printed}"
    );
    assert!(!folder().join("never.mpf").exists() && !folder().join("never.json").exists(), "nothing is written");
}

#[test]
fn a_large_lean_starts_where_its_first_axis_stands() {
    // ORIVECT after TRAORI is no reason to forget the rapid that turns the table before: the tool would
    // swing past the travel of Y.
    let text = written(&["--program", "original", "--method", "smooth", "--set", "channel=tool"], "lean.mpf");
    let turned =
        text.lines().find_map(|l| l.strip_prefix("G0 A")?.split(' ').next()?.parse::<f64>().ok()).expect("a turn");
    let first = vectors(&text)[0];
    let angle = (-first[1]).atan2(first[2]).to_degrees();
    assert!((angle - turned).abs() < 2e-3, "{angle} {turned}");
    assert!((turned + 170.476).abs() > 10.0, "it is not that of the program before: {turned}");
}

/// Tool vectors of the blocks of a program.
fn vectors(text: &str) -> Vec<[f64; 3]> {
    let word = |line: &str, name: &str| line.split_whitespace().find_map(|w| w.strip_prefix(name)?.parse::<f64>().ok());
    let vector = |l: &str| Some([word(l, "A3=")?, word(l, "B3=")?, word(l, "C3=")?]);
    text.lines().filter_map(vector).collect()
}

#[test]
fn the_gain_is_reported_over_the_velocity_limit_with_the_machines_own() {
    let (all, message) = certificate("s-theta", &[], "gains");
    let a = all["runs"][0]["joints"].as_array().expect("a list").iter().find(|j| j["name"] == "A").expect("the table");
    let rows = a["over_velocity"].as_array().expect("a list");
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().expect("a number");
    let of = |is: &str| rows.iter().find(|r| r["is"] == is).expect("a row");
    assert!((number(of("of-machine"), "velocity_deg_s") - 360.0).abs() < 1e-6);
    assert!((number(of("in-force"), "velocity_deg_s") - 62.4).abs() < 1e-6);
    // At the machine's own limit, and wherever the program before is not slowed down, nothing is gained.
    for is in ["of-machine", "of-original"] {
        assert!(number(of(is), "saved_percent").abs() < 1e-9 && number(of(is), "saved_at_most_percent").abs() < 1e-9);
    }
    assert!(number(of("in-force"), "saved_percent") > 5.0);
    for pair in rows.windows(2) {
        assert!(number(&pair[0], "velocity_deg_s") >= number(&pair[1], "velocity_deg_s"));
        assert!(number(&pair[0], "original_s") <= number(&pair[1], "original_s") + 1e-9);
        assert!(number(&pair[1], "least_s") <= number(&pair[1], "new_s") + 1e-9);
    }
    assert!(
        message.contains("by feed and velocity of A alone") && message.contains("(the machine's own)"),
        "{message}"
    );
}

/// A row along a blade on the axis of the table, near whose pole the tool axis passes: as the substitute of
/// the specification, with a ball.
fn near_the_pole(folder: &Path, vectors: bool) {
    let root = root();
    let path = |p: &str| format!("{:?}", root.join(p).display().to_string());
    let tools = "[[tool]]\nnumber = 1\nname = \"T1\"\nkind = \"ball\"\ndiameter_mm = 6\nflute_length_mm = 10\n\
                 shank_diameter_mm = 6\ngauge_length_mm = 60\ncenter_cutting = true\n\
                 holder = { sections = [{ diameter_mm = 40, length_mm = 40 }] }\n";
    let scene = format!(
        "name = \"pole\"\nmachine = {}\ntools = \"tools.toml\"\nresolution_mm = 4\n[stock.box]\nmin_mm = [-6, -6, -70]\n\
         max_mm = [6, 6, 70]\n[mount]\ntranslation_mm = [0, 0, 200]\n[work_offsets.G54]\nZ_mm = 200\n\
         [[program]]\nname = \"main\"\nfile = \"main.mpf\"\ndialect = \"siemens-840d\"\n",
        path("machines/bc-trunnion")
    );
    let axis = |lean: f64, azimuth: f64| {
        let ((sl, cl), (sa, ca)) = (lean.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        [ca * sl, sa * sl, cl]
    };
    let (from, to) = (axis(12.0, 5.0), axis(12.0, 175.0));
    let angle = from.iter().zip(to).map(|(a, b)| a * b).sum::<f64>().acos();
    let mut text = String::from("G17\nT=\"T1\"\nM6\nD1\nG54\nS8000 M3\nCTOL=0.01 OTOL=0.05 G645\n");
    let mut lines = Vec::new();
    for i in 0..=120 {
        let l = f64::from(i) / 120.0;
        let (p, q) = (((1.0 - l) * angle).sin() / angle.sin(), (l * angle).sin() / angle.sin());
        let t: Vec<f64> = from.iter().zip(to).map(|(a, b)| a * p + b * q).collect();
        let z = 60.0 - f64::from(i);
        let (s, c) = (90.0 + 25.0 * z / 120.0_f64).to_radians().sin_cos();
        // The ball of 3 mm next to a cylinder of 8 mm.
        let center = [11.0 * c, 11.0 * s, z];
        let tip: Vec<f64> = center.iter().zip(&t).map(|(c, t)| c - 3.0 * t).collect();
        let place = format!("X{:.5} Y{:.5} Z{:.5}", tip[0], tip[1], tip[2]);
        let (b, turn) = (t[0].hypot(t[1]).atan2(t[2]).to_degrees(), t[1].atan2(t[0]).to_degrees());
        lines.push((
            place,
            if vectors {
                format!("A3={:.8} B3={:.8} C3={:.8}", t[0], t[1], t[2])
            } else {
                format!("B{b:.5} C{turn:.5}")
            },
        ));
    }
    text += "G0 B12 C5\nTRAORI\n";
    text += if vectors { "ORIVECT\n" } else { "ORIAXES\n" };
    text += &format!("{} {}\nG93\n", lines[0].0.replace("Z60", "Z90"), lines[0].1);
    for (place, turn) in &lines {
        text += &format!("G1 {place} {turn} F1200\n");
    }
    text += "TRAFOOF\nM30\n";
    for (name, text) in [("tools.toml", tools), ("scene.toml", &scene), ("main.mpf", &text)] {
        fs::write(folder.join(name), text).expect("written");
    }
}

/// Largest step and sum of steps of an axis over the feed blocks of a program.
fn steps(text: &str, axis: char) -> (f64, f64) {
    let word = |line: &str| {
        line.split_whitespace().find_map(|w| w.strip_prefix(axis)?.trim_start_matches('=').parse::<f64>().ok())
    };
    let lines = text.lines().skip_while(|l| !l.contains("G93"));
    let values: Vec<f64> = lines.filter_map(word).collect();
    let steps: Vec<f64> = values.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
    (steps.iter().copied().fold(0.0, f64::max), steps.iter().sum())
}

#[test]
fn a_table_goes_through_its_pole_without_swinging_round() {
    let own = tempfile::tempdir().expect("temporary folder");
    near_the_pole(own.path(), false);
    let scene = own.path().display().to_string();
    let made = |options: &[&str]| {
        let out = own.path().join("made.mpf").display().to_string();
        let set = options.iter().flat_map(|o| ["--set", o]);
        let words = ["reschedule", &scene, "--program", "main", "--method", "singularity", "--output", &out, "--force"];
        let output = proveout(&words.into_iter().chain(set).collect::<Vec<_>>());
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{printed}");
        (fs::read_to_string(&out).expect("written"), printed)
    };
    let before = fs::read_to_string(own.path().join("main.mpf")).expect("readable");
    let (largest, sum) = steps(&before, 'C');
    assert!(largest > 10.0 && sum > 169.0, "{largest} {sum}");
    let (text, printed) = made(&["junction=off"]);
    let (largest, sum) = steps(&text, 'C');
    // As the independent count of the substitute, whose contact path is 8 mm from the axis; here the ball's
    // center is 11 mm from it.
    assert!(largest < 0.6 && (sum - 38.0).abs() < 1.0, "{largest} {sum}");
    // No channel of one angle is known: the feed, or the reason why there is no bound, but no gap to the best
    // schedule in one.
    assert!(!printed.contains("in the channel") && printed.contains("no "), "{printed}");
    let (wide, _) = made(&["junction=off", "cone_deg=10"]);
    assert!(steps(&wide, 'C').1 < 16.0, "{:?}", steps(&wide, 'C'));
    let (smooth, _) = made(&["junction=pinned"]);
    let (free, _) = made(&[]);
    assert!(smooth != text && free != text && smooth != free);
    // Nothing turns that fast: nothing is changed but decimals.
    let (slow, _) = made(&["rate_deg_mm=20"]);
    assert!((steps(&slow, 'C').1 - 170.0).abs() < 0.1, "{:?}", steps(&slow, 'C'));

    near_the_pole(own.path(), true);
    let out = own.path().join("never.mpf");
    let word = out.display().to_string();
    let output = proveout(&["reschedule", &scene, "--program", "main", "--method", "singularity", "--output", &word]);
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && !out.exists(), "{printed}");
    assert!(
        printed.contains("main.mpf:13:") && printed.contains("does not define the angle of the table"),
        "{printed}"
    );
}

#[test]
fn axes_between_keys_lean_no_more_than_the_cap() {
    let own = tempfile::tempdir().expect("temporary folder");
    near_the_pole(own.path(), true);
    let scene = own.path().display().to_string();
    let made = |cap: &str, window: &str| {
        let out = own.path().join("made.mpf").display().to_string();
        let method = "min-angular-acceleration";
        let words = ["reschedule", &scene, "--program", "main", "--method", method, "--output", &out, "--force"];
        let output = proveout(&[&words[..], &["--set", cap, "--set", window]].concat());
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{printed}");
        assert!(!printed.contains("in the channel"), "{printed}");
        fs::read_to_string(&out).expect("written")
    };
    let least_upright = |text: &str| {
        let words = text.lines().filter(|l| l.contains("C3=")).flat_map(str::split_whitespace);
        words.filter_map(|w| w.strip_prefix("C3=")?.parse::<f64>().ok()).fold(1.0, f64::min)
    };
    let capped = least_upright(&made("max_key_lean_deg=5", "window_mm=6"));
    assert!((capped - 5.0_f64.to_radians().cos()).abs() < 1e-6, "{capped}");
    // The row has no inflection, and its ends lean by 12 degrees.
    let free = least_upright(&made("max_key_lean_deg=47", "window_mm=0"));
    assert!((free - 12.0_f64.to_radians().cos()).abs() < 1e-6, "{free}");
}

/// Seconds that a method saves on a scene of the library, with the texts that it writes and prints.
fn saved(scene: &str, program: &str, method: &str, options: &[&str], out: &Path) -> (f64, String, String) {
    let scene = root().join("scenes").join(scene).display().to_string();
    let file = out.join(format!("{program}-{method}.mpf")).display().to_string();
    let set: Vec<&str> = options.iter().flat_map(|o| ["--set", o]).collect();
    let words = ["reschedule", &scene, "--program", program, "--method", method, "--output", &file, "--force"];
    let output = proveout(&[&words[..], &set].concat());
    let printed = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned()).concat();
    assert_eq!(output.status.code(), Some(0), "{printed}");
    let line = printed.lines().find(|l| l.starts_with("lines ")).expect("times of the run");
    let seconds: Vec<f64> = line
        .split(' ')
        .zip(line.split(' ').skip(1))
        .filter(|(_, b)| b.starts_with("s,") || *b == "s")
        .filter_map(|(a, _)| a.parse().ok())
        .collect();
    assert_eq!(seconds.len(), 2, "{line}");
    (seconds[1] - seconds[0], fs::read_to_string(&file).expect("written"), printed)
}

/// Both rotary joints free: on the experiments of Cui et al. and Ma et al. no published program saves more
/// time, contacts and blocks stay, and the bound is shown with the time.
#[test]
#[ignore = "nightly, 66 s"]
fn rows_by_smooth_are_never_slower_than_what_was_published_for_them() {
    let folder = tempfile::tempdir().expect("temporary folder");
    for (scene, method, published, options) in [
        ("ma-2020-sine", "min-angular-acceleration", &["slerp", "joints"][..], &["channel=rows"][..]),
        ("cui-2022-singularity", "singularity", &["cone-5", "cone-5-smoothed", "cone-3", "cone-10"], &["channel=rows"]),
        ("dong-2023-multi-scale", "multi-scale", &["free-ends"], &["channel=rows", "ends=free"]),
    ] {
        let (most, text, message) = saved(scene, "original", "smooth", options, folder.path());
        assert!(
            message.contains("smooth from original") && message.contains("channel=rows") && message.contains("below"),
            "{message}"
        );
        for program in published {
            let (other, ..) = saved(scene, program, method, &[], folder.path());
            assert!(most >= other - 2e-3, "{scene}, {program}: {most} s and {other} s");
        }
        if scene == "ma-2020-sine" {
            // An even turn of A from end to end is free there: 0.421 s less than before. Coarse cells alone
            // found 0.360.
            assert!(most > 0.41, "{most}");
        }
        let before = fs::read_to_string(root().join("scenes").join(scene).join("original.mpf")).expect("the program");
        let blocks = |text: &str| text.lines().filter(|l| l.starts_with('X') || l.starts_with("G1 X")).count();
        assert_eq!(blocks(&text), blocks(&before), "{scene}");
        // The times of the blocks are those of the program before.
        let feeds = |text: &str| -> Vec<String> {
            text.lines()
                .filter(|l| !l.starts_with(';'))
                .filter_map(|l| {
                    l.split(' ')
                        .find(|w| w.starts_with('F') && w.as_bytes().get(1).is_some_and(u8::is_ascii_digit))
                        .map(str::to_owned)
                })
                .collect()
        };
        assert_eq!(feeds(&text), feeds(&before), "{scene}");
    }
}

#[test]
fn options_of_rows_are_read_and_refused_by_name() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = root().join("scenes/ma-2020-sine").display().to_string();
    let file = folder.path().join("never.mpf");
    let word = file.display().to_string();
    for (options, wanted) in [
        (&["channel=rows", "clearance_deg=50"][..], "does not use clearance_deg"),
        (&["channel=rows", "monotone=true"], "does not use monotone"),
        (&["channel=tool", "ends=free"], "does not use ends"),
        (&["channel=rows", "ends=loose"], "write one of kept, free"),
        (&["channel=rows", "turn_max_deg=0"], "turn_max_deg"),
        (&["channel=rows", "lean_max_deg=4"], "goes on from here"),
    ] {
        let set: Vec<&str> = options.iter().flat_map(|o| ["--set", o]).collect();
        let words = ["reschedule", &scene, "--program", "original", "--method", "smooth", "--output", &word];
        let output = proveout(&[&words[..], &set].concat());
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && printed.contains(wanted), "{options:?}: {printed}");
        assert!(!file.exists(), "nothing is written");
    }
}
