//! Runs that are stopped at moments drawn at random, and go on: by Ctrl-C, by TERM and by a kill that no
//! program can answer. What they leave in the end has the same bytes as an undisturbed run.
//!
//! `PROVEOUT_KILLS` sets how many (200 for a whole check), `PROVEOUT_KILL_SEED` the seed.
//!
//! ```text
//! PROVEOUT_KILLS=200 cargo test -p proveout --test cli hostile:: -- killed --nocapture
//! ```

#![expect(clippy::print_stderr, reason = "a long check tells what it did")]

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::hostile::{
    mutation::{Random, number},
    workshop::{HUNG, Told, Workshop},
};

/// Half of the kills are those that no program can answer.
const SIGNALS: [&str; 4] = ["KILL", "INT", "KILL", "TERM"];
/// Name of the journal of the run folder `result`.
const JOURNAL: &str = ".result.journal";

/// Everything that a run keeps in mind: a history, a finer patch, a design that the swept surface is held
/// against, rapids and a tool at rest in material (depths of runs), pieces that come off and fall,
/// loops, dwells, findings.
fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.scene("[[stock.patch]]\nname = \"corner\"\nmin_mm = [5, 5, -8]\nmax_mm = [20, 20, 0]\ncell_mm = 0.3\n");
    shop.replace("scene.toml", "resolution_mm = 1.0", "resolution_mm = 0.5");
    shop.replace("scene.toml", "[stock]\n", "[stock]\nhistory = true\n");
    let design = "[part]\nmesh = \"part.obj\"\n\n[tolerances]\ngouge_mm = 0.05\nexcess_mm = 0.1\n\n[[program]]";
    shop.replace("scene.toml", "[[program]]", design);
    shop.write("part.obj", step());
    shop.write(
        "program.mpf",
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X-35 Y-30 Z50 S3000 M3 D1\n\
         FOR R1=1 TO 6\nG0 X-35 Y=-34+R1*4 Z50\nG0 Z=-R1\nG1 X35 F2000\nG1 X=-35+R1 Y=-32+R1*5\nENDFOR\n\
         ; rapids in material, one after the other: a run of depths\n\
         G0 Z-3\nFOR R1=1 TO 8\nG0 X=R1*2-8 Y=R1\nENDFOR\nG1 Z-6 F300\n\
         ; a slot through all of it: two parts\n\
         G0 Z50\nG0 X0 Y-40\nG0 Z-21\nG1 Y40 F600\nG0 Z50\nG4 F2\n\
         T=\"BULL_D25_R2\"\nM6\nS2000 M3\nG0 X-10 Y-40 Z50 D1\n\
         FOR R1=1 TO 5\nG0 X=-10-R1 Y-40\nG0 Z=-5-R1\nG1 Y40 F1500\nG0 Z30\nENDFOR\n\
         M5\nG0 X30 Z-12\nG1 Y-20 F3000\nG0 Z50\nM30\n",
    );
    shop
}

/// A design that the program misses: a block with a face at z = -6, as a mesh with faces outward.
fn step() -> String {
    let mut text = String::new();
    for k in 0..8 {
        let of = |bit: u32, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        writeln!(text, "v {} {} {}", of(0, -20.0, 20.0), of(1, -20.0, 20.0), of(2, -20.0, -6.0)).expect("text");
    }
    text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// The files of a run folder that the inputs decide.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())).flatten();
    let mut out = BTreeMap::new();
    for entry in entries {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            out.extend(files(&entry.path()).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else if name != "run.json" {
            out.insert(name, fs::read(entry.path()).expect("readable"));
        }
    }
    out
}

fn same(what: &str, a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{what}");
    let other: Vec<&String> = a.iter().filter(|(name, bytes)| b.get(*name) != Some(bytes)).map(|(n, _)| n).collect();
    assert!(other.is_empty(), "{what}: {other:?} have other bytes");
}

/// Starts a run and stops it after a while: how it ended, what it said on standard error, and how long the
/// signal took; none of these where it had ended by itself before.
fn stopped(shop: &Workshop, more: &[&str], signal: &str, after: Duration) -> Option<(Option<i32>, String, Duration)> {
    let said = shop.path().join("said.txt");
    let mut call = Command::new(env!("CARGO_BIN_EXE_proveout"));
    call.args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"]).args(more);
    call.current_dir(shop.path()).stdin(Stdio::null()).stdout(Stdio::null());
    call.stderr(fs::File::create(&said).expect("made"));
    let mut child = call.spawn().expect("it starts");
    let begin = Instant::now();
    while begin.elapsed() < after {
        if child.try_wait().expect("a child").is_some() {
            return None;
        }
        thread::sleep(Duration::from_millis(1));
    }
    let id = child.id().to_string();
    let sent = Instant::now();
    assert!(Command::new("kill").args(["-s", signal, &id]).status().expect("kill").success() || signal != "KILL");
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        assert!(sent.elapsed() < HUNG, "SIG{signal} is not answered");
        thread::sleep(Duration::from_millis(1));
    };
    Some((status.code(), fs::read_to_string(said).expect("text"), sent.elapsed()))
}

fn going_on(shop: &Workshop) -> Told {
    shop.call(&["run", ".", "--output", "result", "--rerun", "off", "--threads", "1", "--resume"])
}

#[cfg(unix)]
#[test]
#[ignore = "nightly, 129 s"]
fn killed_runs_go_on_to_the_same_bytes() {
    let kills = number("PROVEOUT_KILLS", 4) as usize;
    let mut random = Random(number("PROVEOUT_KILL_SEED", 21));
    let shop = shop();
    let undisturbed = shop.run();
    let code = undisturbed.code();
    assert!(matches!(code, Some(1 | 3)), "{}", undisturbed.text);
    let whole = files(&shop.path().join("result"));
    for word in ["process-loose-part", "process-rapid-in-material", "process-spindle-off"] {
        assert!(String::from_utf8_lossy(&whole["verdict.json"]).contains(word), "the program does {word}");
    }
    let (mut done, mut went_on, mut twice, mut slowest) = (0, 0, 0, Duration::ZERO);
    let mut taken = 0.0_f64;
    // What a run takes at this moment: others use the processors too.
    let mut usual = undisturbed.wall;
    // Kills by the tenth of the undisturbed run in which they came; later ones are in the last.
    let mut tenths = [0_u32; 11];
    while done < kills {
        fs::remove_dir_all(shop.path().join("result")).ok();
        let moment = |random: &mut Random| usual.mul_f64(0.02 + 1.1 * random.below(1000) as f64 / 1000.0);
        let mut more: &[&str] = &[];
        // One of four is stopped a second time while it goes on.
        let times = 1 + usize::from(random.below(4) == 0);
        let mut was_stopped = false;
        for time in 0..times {
            let signal = SIGNALS[done % SIGNALS.len()];
            let after = moment(&mut random);
            let begin = Instant::now();
            let Some((code, said, wall)) = stopped(&shop, more, signal, after) else {
                if time == 0 {
                    usual = begin.elapsed();
                }
                break;
            };
            if code.is_some_and(|c| c != 130) {
                break; // it was done before the signal came
            }
            (was_stopped, twice) = (true, twice + time);
            let tenth = 10.0 * after.as_secs_f64() / usual.as_secs_f64();
            tenths[(tenth as usize).min(10)] += 1;
            assert!(code.is_none() == (signal == "KILL"), "SIG{signal}: {code:?} {said}");
            let journal = shop.path().join(JOURNAL).is_file();
            if signal != "KILL" {
                slowest = slowest.max(wall);
                let how = if journal { "--threads 2 --resume" } else { "there is nothing to resume" };
                assert!(said.contains(how) || said.contains("stopped before the first cut"), "{said}");
                let left: Vec<_> = fs::read_dir(shop.path()).expect("there").flatten().map(|e| e.file_name()).collect();
                assert!(!left.iter().any(|n| n.to_string_lossy().contains(".partial-")), "{left:?}");
            }
            assert!(!shop.path().join("result").exists(), "nothing is half there");
            if !journal {
                break;
            }
            more = &["--resume"];
        }
        if !was_stopped {
            continue;
        }
        done += 1;
        let output = if shop.path().join(JOURNAL).is_file() { going_on(&shop) } else { shop.run() };
        if let Some(mib) = output.text.split("resuming: ").nth(1).and_then(|t| t.split(' ').next()?.parse::<f64>().ok())
        {
            went_on += 1;
            taken = taken.max(mib);
        }
        assert_eq!(output.code(), code, "{}", output.text);
        same(&format!("kill {done}"), &whole, &files(&shop.path().join("result")));
        assert!(!shop.path().join(JOURNAL).exists(), "a run that is complete leaves no journal");
    }
    eprintln!(
        "{done} runs stopped, {twice} of them twice; {went_on} went on with up to {taken:.1} MiB of cuts, the others had cut nothing; \
         slowest answer to a signal {slowest:.1?}; an undisturbed run takes {:.1?}; stops by its tenths: {tenths:?}",
        undisturbed.wall
    );
    assert!(went_on > 0 && taken > 0.0);
}

/// A run that was stopped in the middle, with its journal.
#[cfg(unix)]
fn left_over() -> Workshop {
    let shop = shop();
    for part in 2..40 {
        // Some of these are too early and some too late, however fast the machine is.
        let after = Duration::from_millis(100 * part);
        let ended = stopped(&shop, &[], "KILL", after).is_none();
        let journal = fs::metadata(shop.path().join(JOURNAL)).map_or(0, |about| about.len());
        if !ended && journal > 200_000 {
            return shop;
        }
        fs::remove_dir_all(shop.path().join("result")).ok();
    }
    panic!("no run was stopped in the middle");
}

#[cfg(unix)]
#[test]
#[ignore = "nightly, 41 s"]
fn only_the_run_that_was_stopped_goes_on() {
    let shop = left_over();
    let journal = fs::read(shop.path().join(JOURNAL)).expect("there");
    let program = shop.read("program.mpf");
    let refused = |arguments: &[&str], words: &[&str]| {
        let mut call = vec!["run", ".", "--output", "result", "--rerun", "off", "--threads", "1", "--resume"];
        call.extend(arguments);
        let output = shop.call(&call);
        assert_eq!(output.code(), Some(2), "{}", output.text);
        for word in words.iter().chain(&["--resume"]) {
            assert!(output.text.contains(word), "{word:?} is not in:\n{}", output.text);
        }
        assert!(!shop.path().join("result").exists());
    };
    // Another call, another program, another tool, another version.
    refused(&["--resolution-mm", "1"], &["--resolution-mm was not given, and is now 1"]);
    refused(&["--dynamics", "servo"], &["--dynamics was not given"]);
    shop.write("program.mpf", program.replace("F1500", "F1501"));
    refused(&[], &["the file of program was program.mpf with SHA-256"]);
    shop.write("program.mpf", &program);
    shop.replace("tools.toml", "diameter_mm = 20.0", "diameter_mm = 20.01");
    refused(&[], &["the file of tools was"]);
    shop.replace("tools.toml", "diameter_mm = 20.01", "diameter_mm = 20.0");
    let version = env!("CARGO_PKG_VERSION");
    let from = format!("proveout {version}").into_bytes();
    let at = journal.windows(from.len()).position(|w| w == from).expect("the version");
    let mut other = journal.clone();
    other[at + 9] = b'9';
    shop.write(JOURNAL, &other);
    refused(&[], &["the version was proveout 9"]);
    shop.write(JOURNAL, "PROVEOUT-JOURNAL 3\n");
    refused(&[], &["not a journal that this version can read"]);
    fs::remove_file(shop.path().join(JOURNAL)).expect("removed");
    refused(&[], &["there is no stopped run to resume"]);
    // The journal itself, cut off anywhere and spoiled in the middle: what is whole of it is taken.
    shop.write(JOURNAL, &journal[..journal.len() * 2 / 3]);
    let output = going_on(&shop);
    assert!(matches!(output.code(), Some(1 | 3)), "{}", output.text);
    let whole = files(&shop.path().join("result"));
    let mut spoiled = journal.clone();
    let middle = journal.len() / 2;
    spoiled[middle] ^= 4;
    shop.write(JOURNAL, &spoiled);
    let output = going_on(&shop);
    assert!(matches!(output.code(), Some(1 | 3)), "{}", output.text);
    same("a spoiled journal", &whole, &files(&shop.path().join("result")));
    assert_eq!(shop.run().code(), output.code());
    same("an undisturbed run", &whole, &files(&shop.path().join("result")));
}

#[cfg(unix)]
#[test]
#[ignore = "nightly, 24 s"]
fn two_runs_do_not_write_to_one_place() {
    let shop = shop();
    let first = shop.path().to_owned();
    let under_way = thread::spawn(move || {
        let mut call = Command::new(env!("CARGO_BIN_EXE_proveout"));
        call.args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "1"]).current_dir(first);
        call.stdin(Stdio::null()).output().expect("it runs").status.code()
    });
    let begin = Instant::now();
    while !shop.path().join(JOURNAL).is_file() && begin.elapsed() < HUNG {
        thread::sleep(Duration::from_millis(1));
    }
    let printed = shop.run();
    assert_eq!(printed.code(), Some(2), "{}", printed.text);
    assert!(printed.text.contains("another run is writing to this run folder"), "{}", printed.text);
    assert!(matches!(under_way.join().expect("it ended"), Some(1 | 3)));
    assert!(shop.path().join("result/verdict.json").is_file());
}

/// With and without a journal: what lies beside the run folder while the stock is cut, and what a stop says.
#[cfg(unix)]
#[test]
fn without_a_journal_nothing_is_recorded_and_a_stopped_run_says_so() {
    let size = |shop: &Workshop| fs::metadata(shop.path().join(JOURNAL)).map_or(0, |about| about.len());
    let (mut sizes, mut after) = ([0, 0], Duration::from_millis(300));
    for (k, more) in [&[][..], &["--no-journal"]].into_iter().enumerate() {
        let shop = shop();
        // Later and later, until the signal finds the run cutting; without a journal not earlier than with
        // one.
        loop {
            after += Duration::from_millis(100);
            let found = stopped(&shop, more, "INT", after).expect("it cuts for seconds");
            assert_eq!(found.0, Some(130), "{}", found.1);
            sizes[k] = size(&shop);
            if found.1.contains("before the first cut") || k == 0 && sizes[0] < 1 << 16 {
                continue;
            }
            let said = ["to resume: proveout run", "without a journal there is nothing to resume"][k];
            assert!(found.1.contains(said), "{}", found.1);
            break;
        }
    }
    // Its head names the inputs.
    assert!(sizes[1] < 1 << 13 && sizes[0] >= 1 << 16, "{sizes:?}");
}

/// A limit of the size of files represents a disk that is full: the system refuses to write on.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_older_run_and_says_so() {
    let shop = shop();
    assert!(matches!(shop.run().code(), Some(1 | 3)));
    let before = files(&shop.path().join("result"));
    for blocks in [0, 8, 60, 400] {
        let shell = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec {:?} run . --output result --rerun off --threads 1",
            env!("CARGO_BIN_EXE_proveout")
        );
        let mut call = Command::new("sh");
        let out = call.args(["-c", &shell]).current_dir(shop.path()).stdin(Stdio::null()).output().expect("it runs");
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{blocks} blocks: {text}");
        assert!(text.contains("File too large"), "{blocks} blocks: {text}");
        assert!(!text.contains("panicked"), "{blocks} blocks: {text}");
        same("the older run", &before, &files(&shop.path().join("result")));
        let left: Vec<_> = fs::read_dir(shop.path()).expect("there").flatten().map(|e| e.file_name()).collect();
        assert!(!left.iter().any(|n| n.to_string_lossy().contains(".partial-")), "{left:?}");
    }
}
