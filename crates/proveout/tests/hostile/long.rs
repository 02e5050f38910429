//! Memory does not grow with the length of a program: a seeded walk of short blocks at G64, long enough to
//! show it.
//!
//! ```text
//! PROVEOUT_MINUTES=600 cargo test -p proveout --test cli hostile:: -- long_program --nocapture
//! ```

#![expect(clippy::print_stderr, reason = "a long measurement tells what it found")]

use std::{
    fmt::Write as _,
    fs,
    process::{Command, Stdio},
    thread,
    time::Duration,
};

use crate::hostile::{
    mutation::{Random, number},
    workshop::Workshop,
};

/// Most that a run may take, bytes.
const MOST: u64 = 1_000_000_000;
/// Feed of the walk, mm/min.
const FEED: f64 = 1000.0;

/// Blocks of one to three millimeters in a disc of 80 mm, slowly down by 10 mm.
fn walk(minutes: f64, random: &mut Random) -> (String, u32) {
    let mut drawn = |low: f64, high: f64| low + (high - low) * random.below(1 << 20) as f64 / f64::from(1 << 20);
    let mut text = String::from("G17 G54 G90 G94 G710 G64\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S3000 M3 D1\nG1 Z0 F1000\n");
    let (mut x, mut y, mut way, mut turned, mut blocks) = (0.0_f64, 0.0_f64, 0.0, 0.0_f64, 0);
    while way < minutes * FEED {
        turned += drawn(-0.25, 0.25) + if x.hypot(y) > 60.0 { 0.1 } else { 0.0 };
        let step = drawn(1.0, 3.0);
        (x, y) = (x + step * turned.cos(), y + step * turned.sin());
        if x.hypot(y) > 80.0 {
            (x, y, turned) = (x * 0.98, y * 0.98, turned + 0.5);
        }
        way += step;
        blocks += 1;
        writeln!(text, "G1 X{x:.3} Y{y:.3} Z{:.4}", -10.0 * way / (minutes * FEED)).expect("text");
    }
    (text + "G0 Z50\nM30\n", blocks)
}

/// The most memory that a process has held, bytes; none where it is gone or the system does not show.
fn peak(id: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib << 10)
}

#[test]
fn a_long_program_takes_no_more_memory_than_a_short_one() {
    let shop = Workshop::new();
    shop.replace("scene.toml", "resolution_mm = 1.0", "resolution_mm = 2.0");
    let (small, large) = ("[-20, -20, -20], max_mm = [20, 20, 0]", "[-90, -90, -20], max_mm = [90, 90, 0]");
    shop.replace("scene.toml", small, large);
    let minutes = number("PROVEOUT_MINUTES", 5);
    let (text, blocks) = walk(minutes as f64, &mut Random(5));
    shop.write("program.mpf", text);
    let mut call = Command::new(env!("CARGO_BIN_EXE_proveout"));
    call.args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "1"]).current_dir(shop.path());
    let mut child = call.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
    let (mut most, mut journal) = (0, 0);
    let code = loop {
        most = most.max(peak(child.id()).unwrap_or(0));
        journal = journal.max(fs::metadata(shop.path().join(".result.journal")).map_or(0, |about| about.len()));
        if let Some(status) = child.try_wait().expect("a child") {
            break status.code();
        }
        thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(code, Some(3), "no design part");
    let verdict: serde_json::Value = serde_json::from_str(&shop.read("result/verdict.json")).expect("JSON");
    eprintln!(
        "{minutes} minutes, {blocks} blocks, {} s of machine time: at most {:.0} MB held, journal {:.1} MB",
        verdict["time"]["total_s"],
        most as f64 / 1e6,
        journal as f64 / 1e6
    );
    assert!(most > 0 && most < MOST, "{most} bytes");
}
