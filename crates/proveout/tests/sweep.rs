//! Sweeps as a person calls them: plan, run in parts, merge; what is killed, changed, lost or damaged costs
//! its jobs and is named.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    time::{Duration, Instant},
};

use tempfile::TempDir;

const FILES: [&str; 4] = ["sweep.parquet", "sweep.csv", "sweep.json", "sweep.html"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

fn command(words: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_proveout"));
    command.args(words).current_dir(folder).stdin(Stdio::null());
    command
}

fn call(words: &[&str], folder: &Path) -> Output {
    command(words, folder).output().expect("started")
}

/// Standard output and standard error of a call with this exit code.
fn run_expecting(words: &[&str], folder: &Path, code: i32) -> (String, String) {
    let output = call(words, folder);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{words:?}\n{out}\n{err}");
    (out, err)
}

/// A folder with a copy of the small scene, a second program, and a sweep.
fn small(vary: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    let of = |name: &str| fs::read_to_string(root().join("tests/job").join(name)).expect("there");
    let machine = root().join("machines/three-axis-mill");
    let scene = of("op10/scene.toml").replace("../../../machines/three-axis-mill", &machine.display().to_string());
    let scene = scene.replace("../tools.toml", "tools.toml") + "\n[[program]]\nname = \"other\"\nfile = \"other.nc\"\n";
    fs::create_dir(folder.path().join("scene")).expect("made");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("scene/scene.toml", &scene);
    write("scene/tools.toml", &of("tools.toml"));
    write("scene/main.nc", &of("op10/main.nc"));
    write("scene/other.nc", &of("op10/main.nc"));
    write("sweep.toml", &format!("name = \"small\"\nscene = \"scene\"\n{vary}"));
    folder
}

const PROGRAMS: &str = "[[vary]]\nkey = \"program\"\nvalues = [\"main\", \"other\"]\n\
                        [[vary]]\nkey = \"machine.X.max_acceleration_mm_s2\"\nvalues = [500, 2000]\n";

fn merged(folder: &Path) -> BTreeMap<&'static str, Vec<u8>> {
    FILES.into_iter().map(|name| (name, fs::read(folder.join(name)).expect("merged"))).collect()
}

#[test]
fn parts_that_run_beside_each_other_merge_to_the_bytes_of_one() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (sweep, at) = (root().join("tests/sweep"), folder.path());
    let sweep = sweep.to_str().expect("a path");
    for out in ["one", "four"] {
        let (words, _) = run_expecting(&["sweep", "plan", sweep, "--output", out], at, 0);
        assert!(words.contains("6 jobs planned"), "{words}");
    }
    run_expecting(&["sweep", "run", "one", "--threads", "1"], at, 0);
    let parts = ["1/4", "2/4", "3/4", "4/4"];
    let mut running: Vec<_> = parts
        .iter()
        .map(|part| {
            let mut command = command(&["sweep", "run", "four", "--part", part, "--threads", "2"], at);
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started")
        })
        .collect();
    for child in &mut running {
        assert!(child.wait().expect("ended").success());
    }
    let (words, _) = run_expecting(&["sweep", "merge", "one"], at, 0);
    assert!(words.contains("6 jobs: 6 "), "{words}");
    run_expecting(&["sweep", "merge", "four"], at, 0);
    let (one, four) = (merged(&at.join("one")), merged(&at.join("four")));
    for name in FILES {
        assert!(one[name] == four[name], "{name}");
    }
    // A second run starts nothing, and a second plan leaves everything as it is.
    let (words, _) = run_expecting(&["sweep", "run", "four"], at, 0);
    assert!(words.contains("6 had their result, 0 started"), "{words}");
    let (words, _) = run_expecting(&["sweep", "plan", sweep, "--output", "four"], at, 0);
    assert!(words.contains("6 unchanged since the last plan"), "{words}");
    run_expecting(&["sweep", "merge", "four"], at, 0);
    assert!(one == merged(&at.join("four")));

    // The values act: less acceleration is more time, and the table says which.
    let csv = String::from_utf8(one["sweep.csv"].clone()).expect("text");
    let mut lines = csv.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a head");
    let column = |name: &str| head.iter().position(|h| *h == name).unwrap_or_else(|| panic!("no {name} in {head:?}"));
    let (key, time) = (column("machine.X.max_acceleration_mm_s2"), column("time_s"));
    let rows: Vec<(f64, f64)> =
        lines.map(|row| (row[key].parse().expect("a number"), row[time].parse().expect("a number"))).collect();
    assert_eq!(rows.len(), 6);
    let slowest = rows.iter().filter(|r| r.0 == 500.0).map(|r| r.1).fold(f64::INFINITY, f64::min);
    let fastest = rows.iter().filter(|r| r.0 == 2000.0).map(|r| r.1).fold(0.0, f64::max);
    assert!(slowest > fastest, "{rows:?}");
}

#[test]
fn a_job_gives_what_run_set_gives() {
    let folder = small(PROGRAMS);
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    run_expecting(&["sweep", "run", "out", "--job", "3"], at, 0);
    let job = fs::read(at.join("out/jobs/00003/verdict.json")).expect("a verdict");
    let set = "machine.X.max_acceleration_mm_s2=2000";
    let output = call(&["run", "scene", "--program", "other", "--set", set, "--rerun", "off", "--output", "run"], at);
    assert!(matches!(output.status.code(), Some(0 | 1 | 3)), "{output:?}");
    assert!(job == fs::read(at.join("run/verdict.json")).expect("a verdict"));
    let text = String::from_utf8(job).expect("text");
    assert!(text.contains("\"machine.X.max_acceleration_mm_s2\": \"2000\""), "the verdict names what was set");
    let page = fs::read_to_string(at.join("run/report.html")).expect("a report");
    assert!(page.contains("Not as the files say, set by the call: machine.X.max_acceleration_mm_s2 = 2000"));
    // Job 0 was not asked for.
    let (_, words) = run_expecting(&["sweep", "merge", "out"], at, 2);
    assert!(words.contains("3 of 4 results cannot be merged: job 0 has no result; job 1"), "{words}");
    assert!(FILES.iter().all(|name| !at.join("out").join(name).exists()), "nothing is merged by halves");
}

#[test]
fn a_changed_input_costs_the_jobs_that_read_it() {
    let folder = small(PROGRAMS);
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    run_expecting(&["sweep", "run", "out"], at, 0);
    let text = fs::read_to_string(at.join("scene/other.nc")).expect("text");
    fs::write(at.join("scene/other.nc"), format!("(changed)\n{text}").replace("(changed)\n%", "%\n(changed)"))
        .expect("written");
    // Before it is planned again, a job that is not done refuses the input that has changed.
    fs::remove_file(at.join("out/jobs/00002/result.json")).expect("removed");
    let (_, words) = run_expecting(&["sweep", "run", "out"], at, 2);
    assert!(words.contains("the program of job 2: it has changed since the sweep was planned"), "{words}");
    assert!(words.contains("other.nc"), "{words}");
    let (words, _) = run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    assert!(words.contains("2 unchanged since the last plan"), "{words}");
    let (_, words) = run_expecting(&["sweep", "merge", "out"], at, 2);
    assert!(words.contains("the result of job 3 is of an earlier plan"), "{words}");
    let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("2 had their result, 2 started"), "{words}");
    run_expecting(&["sweep", "merge", "out"], at, 0);
}

/// A kind of tampering: what it is, what is changed, what a merge says, and whether `run` mends it by running
/// the job again.
type Tampering = (&'static str, fn(&Path), &'static str, bool);

#[test]
fn run_and_merge_hold_plan_jobs_inputs_and_verdicts_against_their_digests_again() {
    fn edit(path: &Path, from: &str, to: &str) {
        let text = fs::read_to_string(path).expect("text");
        assert!(text.contains(from), "{from} is in {}", path.display());
        fs::write(path, text.replace(from, to)).expect("written");
    }
    let tamperings: [Tampering; 9] = [
        ("program", |at| edit(&at.join("scene/main.nc"), "Z-", "Z-1"), "the program of job 0: it has changed", false),
        ("scene", |at| edit(&at.join("scene/scene.toml"), "name", "# mine\nname"), "the scene of job 0: it has", false),
        (
            "tools",
            |at| edit(&at.join("scene/tools.toml"), "[[tool]]", "\n[[tool]]"),
            "the tools of job 0: it has",
            false,
        ),
        ("an input is gone", |at| fs::remove_file(at.join("scene/main.nc")).expect("gone"), "cannot be read", false),
        (
            "verdict",
            |at| edit(&at.join("out/jobs/00001/verdict.json"), "\"verdict\": \"", "\"verdict\": \"x"),
            "damaged",
            true,
        ),
        ("verdict gone", |at| fs::remove_file(at.join("out/jobs/00001/verdict.json")).expect("gone"), "damaged", true),
        (
            "verdict of another job",
            |at| {
                let [from, to] =
                    ["out/jobs/00000/verdict.json", "out/jobs/00001/verdict.json"].map(|name| at.join(name));
                fs::copy(from, to).expect("copied");
            },
            "damaged",
            true,
        ),
        (
            "job",
            |at| edit(&at.join("out/jobs/00001/job.json"), "2000", "2001"),
            "has changed since it was planned",
            false,
        ),
        (
            "a shorter plan",
            |at| {
                let path = at.join("out/plan.json");
                let mut plan: serde_json::Value =
                    serde_json::from_str(&fs::read_to_string(&path).expect("text")).expect("JSON");
                plan["jobs"].as_array_mut().expect("jobs").truncate(2);
                fs::write(path, plan.to_string()).expect("written");
            },
            "has changed since it was planned",
            false,
        ),
    ];
    let folder = small(PROGRAMS);
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    run_expecting(&["sweep", "run", "out"], at, 0);
    run_expecting(&["sweep", "merge", "out"], at, 0);
    let sound = merged(&at.join("out"));
    // What may be changed, as it was.
    let mut kept = BTreeMap::new();
    for name in ["scene/main.nc", "scene/scene.toml", "scene/tools.toml", "out/plan.json"] {
        kept.insert(name.to_owned(), fs::read(at.join(name)).expect("read"));
    }
    for name in ["job.json", "verdict.json", "result.json"] {
        let name = format!("out/jobs/00001/{name}");
        kept.insert(name.clone(), fs::read(at.join(&name)).expect("read"));
    }
    for (what, tamper, wanted, mended) in tamperings {
        tamper(at);
        let (_, words) = run_expecting(&["sweep", "merge", "out"], at, 2);
        assert!(words.contains(wanted), "{what}: {words}");
        if mended {
            let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
            assert!(words.contains("3 had their result, 1 started"), "{what}: {words}");
        } else {
            let (_, words) = run_expecting(&["sweep", "run", "out"], at, 2);
            assert!(words.contains(wanted), "{what}: {words}");
        }
        for (name, bytes) in &kept {
            fs::write(at.join(name), bytes).expect("written");
        }
        run_expecting(&["sweep", "merge", "out"], at, 0);
        assert!(merged(&at.join("out")) == sound, "{what}: as it was before");
    }
}

#[test]
fn a_worker_that_is_killed_costs_its_job() {
    let folder = small(
        "method = \"latin-hypercube\"\ndraws = 12\n[[vary]]\nkey = \"machine.X.max_acceleration_mm_s2\"\nrange = [200, 4000]\n",
    );
    let at = folder.path();
    for out in ["killed", "whole"] {
        run_expecting(&["sweep", "plan", ".", "--output", out], at, 0);
    }
    let mut worker =
        command(&["sweep", "run", "killed"], at).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started");
    let begin = Instant::now();
    while !at.join("killed/jobs/00003/result.json").exists() {
        assert!(begin.elapsed() < Duration::from_secs(300), "the first jobs take too long");
        std::thread::sleep(Duration::from_millis(2));
    }
    worker.kill().expect("killed");
    worker.wait().expect("ended");
    let (words, _) = run_expecting(&["sweep", "run", "killed"], at, 0);
    let done: usize = words
        .split(" had their result")
        .next()
        .and_then(|w| w.rsplit(' ').next())
        .and_then(|w| w.parse().ok())
        .expect(&words);
    assert!((4..12).contains(&done), "{words}");
    run_expecting(&["sweep", "run", "whole"], at, 0);
    for out in ["killed", "whole"] {
        run_expecting(&["sweep", "merge", out], at, 0);
    }
    assert!(merged(&at.join("killed")) == merged(&at.join("whole")));
}

#[test]
fn what_is_missing_damaged_or_of_another_version_is_named_and_nothing_is_merged() {
    let folder = small(PROGRAMS);
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    run_expecting(&["sweep", "run", "out"], at, 0);
    let result = at.join("out/jobs/00001/result.json");
    let sound = fs::read_to_string(&result).expect("a result");
    let time = sound.lines().find(|l| l.contains("\"time_s\"")).expect("a time");
    for damage in [sound.replace(time, &time.replace(": ", ": 1")), sound[..sound.len() / 2].to_owned(), String::new()]
    {
        fs::write(&result, damage).expect("written");
        let (_, words) = run_expecting(&["sweep", "merge", "out"], at, 2);
        assert!(words.contains("1 of 4 results cannot be merged: the result of job 1 is damaged"), "{words}");
        assert!(!at.join("out/sweep.parquet").exists());
    }
    // Damaged is not done.
    let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("3 had their result, 1 started"), "{words}");
    assert_eq!(fs::read_to_string(&result).expect("a result"), sound, "same job, same bytes");

    let plan = at.join("out/plan.json");
    let own = fs::read_to_string(&plan).expect("a plan");
    let version = format!("proveout {}", env!("CARGO_PKG_VERSION"));
    fs::write(&plan, own.replace(&version, "proveout 0.0.1")).expect("written");
    for verb in ["run", "merge"] {
        let (_, words) = run_expecting(&["sweep", verb, "out"], at, 2);
        assert!(words.contains("was planned by proveout 0.0.1"), "{words}");
    }
    fs::write(&plan, &own).expect("written");
    let job = at.join("out/jobs/00002/job.json");
    let text = fs::read_to_string(&job).expect("a job");
    fs::write(&job, text.replace("500", "501")).expect("written");
    fs::remove_file(at.join("out/jobs/00002/result.json")).expect("removed");
    let (_, words) = run_expecting(&["sweep", "run", "out"], at, 2);
    assert!(words.contains("has changed since it was planned"), "{words}");
}

#[test]
fn a_job_whose_folder_cannot_be_written_is_named_and_the_others_have_their_results() {
    let folder = small(PROGRAMS);
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    // Where the run would be written there is a file.
    fs::write(at.join("out/jobs/00001/run"), "in the way").expect("written");
    let (_, words) = run_expecting(&["sweep", "run", "out"], at, 2);
    assert!(words.contains("job 1 (2 of 4): NOT RUN") && words.contains("1 of 4 jobs have no result"), "{words}");
    fs::remove_file(at.join("out/jobs/00001/run")).expect("removed");
    let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("3 had their result, 1 started"), "{words}");
}

#[test]
fn values_that_a_scene_refuses_together_are_a_result() {
    // Each value is possible; both ends of the travel together are none.
    let folder = small("[[vary]]\nkey = \"resolution_mm\"\nvalues = [1, 0.002]\n");
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    let (_, words) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("job 1 (2 of 2): refused: "), "{words}");
    let (words, _) = run_expecting(&["sweep", "merge", "out"], at, 0);
    assert!(words.contains("1 refused"), "{words}");
}

#[test]
fn a_sweep_that_cannot_be_planned_is_reported_with_its_place_and_nothing_is_written() {
    for (vary, wanted) in [
        ("", "varies nothing"),
        ("[[vary]]\nkey = \"control.path_tolerance\"\nvalues = [1]\n", "path_tolerance_mm"),
        ("[[vary]]\nkey = \"machine.Q.max_velocity_mm_min\"\nvalues = [1]\n", "machine.Q.max_velocity_mm_min = 1"),
        ("[[vary]]\nkey = \"program\"\nvalues = [\"man\"]\n", "did you mean \"main\"?"),
        ("[[vary]]\nkey = \"nc\"\nvalues = [\"gone.nc\"]\n", "is not there"),
        ("[[vary]]\nkey = \"resolution_mm\"\nvalues = [-1]\n", "resolution_mm = -1"),
        ("[[vary]]\nkey = \"resolution_mm\"\n", "needs either values or range"),
        ("[[vary]]\nkey = \"resolution_mm\"\nvalues = []\n", "values are missing"),
        ("[[vary]]\nkey = \"resolution_mm\"\nvalues = [1, 1]\n", "repeated"),
        ("[[vary]]\nkey = \"resolution_mm\"\nrange = [2, 1]\nsteps = 3\n", "is empty"),
        ("[[vary]]\nkey = \"resolution_mm\"\nrange = [1, 2]\n", "needs a number of values"),
        ("draws = 3\n[[vary]]\nkey = \"resolution_mm\"\nvalues = [1]\n", "belong to a Latin hypercube"),
        ("method = \"latin-hypercube\"\n[[vary]]\nkey = \"resolution_mm\"\nvalues = [1]\n", "needs a number of draws"),
        (
            "[[vary]]\nkey = \"resolution_mm\"\nrange = [1, 2]\nsteps = 900000\n[[vary]]\nkey = \"tolerances.near_miss_mm\"\nrange = [1, 2]\nsteps = 900000\n",
            "the limit is 1000000",
        ),
        (
            "[[vary]]\nkey = \"resolution_mm\"\nvalues = [1]\n[[vary]]\nkey = \"resolution_mm\"\nvalues = [2]\n",
            "two [[vary]]",
        ),
        ("speed = 3\n[[vary]]\nkey = \"resolution_mm\"\nvalues = [1]\n", "speed"),
    ] {
        let folder = small(vary);
        let (_, words) = run_expecting(&["sweep", "plan", ".", "--output", "out"], folder.path(), 2);
        assert!(words.contains(wanted) && words.contains("sweep.toml"), "{vary}\n{words}");
        assert!(!folder.path().join("out").exists(), "{vary}");
    }
    let folder = small(PROGRAMS);
    let (_, words) = run_expecting(&["sweep", "plan", ".", "--output", "scene"], folder.path(), 2);
    assert!(words.contains("not the folder of a sweep"), "{words}");
    let (_, words) = run_expecting(&["sweep", "run", "scene"], folder.path(), 2);
    assert!(words.contains("plan.json"), "{words}");
}

/// All files of a folder and what is in them, but for the one with time and memory.
fn folder_of(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(path).expect("a run folder").map(|e| e.expect("an entry").path());
    let name = |p: &Path| p.file_name().expect("a name").to_string_lossy().into_owned();
    entries.filter(|p| name(p) != "run.json").map(|p| (name(&p), fs::read(&p).expect("read"))).collect()
}

fn write_program(folder: &Path, name: &str, lines: &str) {
    let text = format!("G21 G17 G90 G54\nT1 M6\nS3000 M3\nG43 H1\n{lines}M5\nM30\n");
    fs::write(folder.join("scene").join(name), text).expect("written");
}

#[test]
#[ignore = "nightly, 38 s"]
fn a_run_in_shards_leaves_the_bytes_of_a_run_that_was_never_split() {
    // Two cuts, then the spindle comes down to the block within a stretch, and the nose is in it; a part
    // that is cut off, and cuts after that; a patch of finer cells, the history and the engagement as well.
    let (slots, down) = ("G0 X5 Y-30\nG0 Z5\nG0 Z-9\nG1 Y30 F600\nG0 Z10\n", "G0 X-10 Y0\nG0 Z-100\nG0 Z50\n");
    let off = slots.replace("Z-9", "Z-21") + "G0 X-10 Y-30\nG0 Z-5\nG1 Y30 F600\nG0 Z10\n";
    let near = format!("{slots}{down}{slots}");
    let fine = "engagement = true\n[stock]\nhistory = true\nbox = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }\n\
                [[stock.patch]]\nname = \"edge\"\nmin_mm = [0, -20, -12]\nmax_mm = [10, 0, 0]\ncell_mm = 0.4\n";
    let plain = "[stock]\nbox = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }\n";
    for (lines, made_here) in [(slots, None), (&*near, Some("a body came near")), (&off, Some("after a part"))] {
        for stock in [plain, fine] {
            let folder = small("shards = 3\n");
            let at = folder.path();
            write_program(at, "main.nc", lines);
            let scene = at.join("scene/scene.toml");
            let text = fs::read_to_string(&scene).expect("read");
            assert!(text.contains(plain));
            fs::write(&scene, text.replace(plain, stock)).expect("written");
            let code = call(&["run", "scene", "--program", "main", "--rerun", "off", "--output", "whole/run"], at);
            let code = code.status.code().expect("an exit code");
            let whole = folder_of(&at.join("whole/run"));
            for shards in [1, 3, 8] {
                let out = format!("out{shards}");
                let sweep = format!(
                    "name = \"small\"\nscene = \"scene\"\nshards = {shards}\n\
                                     [[vary]]\nkey = \"program\"\nvalues = [\"main\"]\n"
                );
                fs::write(at.join("sweep.toml"), sweep).expect("written");
                let (words, _) = run_expecting(&["sweep", "plan", ".", "--output", &out], at, 0);
                assert!(words.contains(&format!("{shards} jobs planned")), "{words}");
                run_expecting(&["sweep", "run", &out, "--threads", "2"], at, 0);
                let (words, _) = run_expecting(&["sweep", "merge", &out], at, code);
                assert!(words.contains(&format!("{shards} shards: ")), "{words}");
                for why in ["a body came near", "after a part"] {
                    assert_eq!(words.contains(why), made_here == Some(why), "{words}");
                }
                let merged = folder_of(&at.join(&out).join("run"));
                assert!(whole.keys().eq(merged.keys()));
                for (name, bytes) in &whole {
                    assert!(*bytes == merged[name], "{name} of {shards} shards");
                }
            }
        }
    }
}

#[test]
fn shards_that_are_missing_damaged_or_of_another_plan_are_named_and_cut_again_alone() {
    let folder = small("shards = 4\n");
    let at = folder.path();
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    run_expecting(&["sweep", "run", "out", "--part", "1/2"], at, 0);
    let (_, fault) = run_expecting(&["sweep", "merge", "out"], at, 2);
    assert!(fault.contains("job 1 has no result") && !at.join("out/run").exists(), "{fault}");
    let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("2 had their result, 2 started"), "{words}");
    run_expecting(&["sweep", "merge", "out"], at, 3);
    let whole = folder_of(&at.join("out/run"));

    // A byte of the cuts: the shard is named, and cut again alone.
    let cuts = at.join("out/jobs/00002/cuts.bin");
    let mut bytes = fs::read(&cuts).expect("read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&cuts, bytes).expect("written");
    let (_, fault) = run_expecting(&["sweep", "merge", "out"], at, 2);
    assert!(fault.contains("the cuts of shard 2 are damaged"), "{fault}");
    let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("3 had their result, 1 started"), "{words}");
    run_expecting(&["sweep", "merge", "out"], at, 3);
    assert!(folder_of(&at.join("out/run")) == whole);

    // A second plan of the same files changes nothing; motion that was changed after the plan is found.
    let (words, _) = run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    assert!(words.contains("4 unchanged since the last plan"), "{words}");
    let motion = at.join("out/motion.bin");
    let mut bytes = fs::read(&motion).expect("read");
    bytes.push(0);
    fs::write(&motion, bytes).expect("written");
    fs::remove_file(at.join("out/jobs/00001/result.json")).expect("removed");
    let (_, fault) = run_expecting(&["sweep", "run", "out"], at, 2);
    assert!(fault.contains("the motion of job 1: it has changed since the sweep was planned"), "{fault}");

    // Another program is another motion: all shards.
    write_program(at, "main.nc", "G0 X0 Y-30\nG0 Z5\nG0 Z-3\nG1 Y30 F600\nG0 Z10\n");
    run_expecting(&["sweep", "plan", ".", "--output", "out"], at, 0);
    let (words, _) = run_expecting(&["sweep", "run", "out"], at, 0);
    assert!(words.contains("0 had their result, 4 started"), "{words}");
}

#[test]
fn shards_are_those_of_a_single_run() {
    for (head, words) in [
        (PROGRAMS.replacen("[[vary]]", "shards = 2\n[[vary]]", 1), "shards split a single run, but the sweep has 4"),
        ("shards = 0\n".into(), "shards = 0: a run is split into 1 to 1024"),
        ("shards = 2000\n".into(), "shards = 2000"),
        (String::new(), "the sweep varies nothing"),
        ("shards = 2\nkeep = \"folder\"\n".into(), "a run in shards keeps its whole folder"),
        (format!("seed = 3\n{PROGRAMS}"), "`seed` belongs to a Latin hypercube"),
    ] {
        let folder = small(&head);
        let (_, fault) = run_expecting(&["sweep", "plan", ".", "--output", "out"], folder.path(), 2);
        assert!(fault.contains(words) && fault.contains("help:"), "{fault}");
        assert!(!folder.path().join("out").exists());
    }
}
