//! A written program is read again and moves as the original, or the post says where it does not: every case
//! program in every dialect, texts with one wrong number, and arcs of all radii.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::post;
use proveout_nc::post::{Difference, PostError, PostSettings, verify};
use proveout_nc::{Dialect, Program, ReferencePoints, Settings};

const SOURCES: [(&str, Dialect); 8] = [
    ("siemens", Dialect::Siemens840d),
    ("iso", Dialect::Iso),
    ("fanuc", Dialect::Fanuc),
    ("haas", Dialect::Haas),
    ("linuxcnc", Dialect::LinuxCnc),
    ("heidenhain", Dialect::Heidenhain),
    ("heidenhain-iso", Dialect::HeidenhainIso),
    ("apt", Dialect::Apt),
];
const TARGETS: [Dialect; 6] =
    [Dialect::Siemens840d, Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc, Dialect::Heidenhain, Dialect::Apt];

/// Texts that do not move as their originals and so are not written: the feed of M140, a circle of no radius,
/// and an entry as long as the tool radius, which a LinuxCNC refuses.
const REFUSED: [(&str, Dialect); 3] = [
    ("tcpm.h", Dialect::Heidenhain),
    ("circle_pocket.nc", Dialect::Siemens840d),
    ("contour_milling.mpf", Dialect::LinuxCnc),
];

fn settings(dialect: Dialect) -> Settings {
    let mut settings = Settings { dialect, reference_points: Some(ReferencePoints::default()), ..Settings::default() };
    for (name, value) in [("R1", 1.0), ("M92_Z", 400.0), ("Q108", 6.0), ("$P_TOOLR", 6.0)] {
        settings.variables.insert(name.to_owned(), value);
    }
    settings
}

fn programs(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name);
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_file() && p.extension().is_some_and(|e| e != "jsonl"))
        .filter(|p| !p.file_name().unwrap().to_string_lossy().starts_with("sub_"))
        .collect();
    files.sort();
    files
}

fn read_again(path: &Path, from: Dialect, to: Dialect, form: &PostSettings, text: &str) -> Result<(), Difference> {
    let original = Program::open(path, &settings(from)).unwrap();
    let written = Program::from_text("written", text, &settings(to)).unwrap();
    verify(original, written, form)
}

/// Case programs that can be read and written, with what is written.
fn written(to: Dialect) -> Vec<(PathBuf, Dialect, PostSettings, String)> {
    let mut all = Vec::new();
    for (name, from) in SOURCES {
        for path in programs(name) {
            let Ok(program) = Program::open(&path, &settings(from)) else { continue };
            let Ok(commands) = program.collect::<Result<Vec<_>, _>>() else { continue };
            let form = PostSettings::between(from, to);
            match post(&commands, to, form.clone()) {
                Ok(text) => all.push((path, from, form, text)),
                Err(PostError::Unsupported { what, help, .. }) => assert!(!what.is_empty() && !help.is_empty()),
                Err(error) => panic!("{}: {error}", path.display()),
            }
        }
    }
    all
}

#[test]
fn every_case_that_is_written_moves_as_its_original() {
    let mut wrong = Vec::new();
    for to in TARGETS {
        for (path, from, form, text) in written(to) {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if let Err(difference) = read_again(&path, from, to, &form, &text)
                && !REFUSED.contains(&(name.as_str(), to))
            {
                wrong.push(format!("{} to {}: {difference:?}", path.display(), to.name()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A text with one coordinate changed by a hundredth of a millimeter or more.
fn with_a_wrong_number(text: &str, seed: usize) -> Option<String> {
    let lines: Vec<&str> = text.lines().collect();
    let moves = |line: &str| {
        let line = line.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
        ["G0 ", "G1 ", "L ", "GOTO/", "X", "Y", "Z"].iter().any(|word| line.starts_with(word))
            && line.contains(['X', 'Y', 'G'])
    };
    let candidates: Vec<usize> = (0..lines.len()).filter(|&at| moves(lines[at])).collect();
    let at = *candidates.get(seed % candidates.len().max(1))?;
    let line = lines[at];
    let start = line.find(['X', 'Y', 'Z']).or_else(|| line.find("GOTO/").map(|at| at + 4))? + 1;
    let digits = line[start..].find(|c: char| !matches!(c, '0'..='9' | '+' | '-' | '.')).unwrap_or(line.len() - start);
    let value: f64 = line[start..start + digits].parse().ok()?;
    let sign = if line[start..].starts_with('+') { "+" } else { "" };
    let changed = format!("{}{sign}{:.3}{}", &line[..start], value.abs() + 0.25, &line[start + digits..]);
    let mut all: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
    all[at] = changed;
    Some(all.join("\n") + "\n")
}

#[test]
fn a_wrong_number_in_a_written_text_is_found() {
    let (mut tried, mut missed) = (0, Vec::new());
    for to in TARGETS {
        for (seed, (path, from, form, text)) in written(to).into_iter().enumerate() {
            let Some(wrong) = with_a_wrong_number(&text, seed) else { continue };
            let Ok(program) = Program::from_text("written", wrong.as_str(), &settings(to)) else { continue };
            tried += 1;
            let original = Program::open(&path, &settings(from)).unwrap();
            if verify(original, program, &form).is_ok() {
                missed.push(format!("{} to {}\n{wrong}", path.display(), to.name()));
            }
        }
    }
    assert!(tried > 100, "{tried} texts were tried");
    assert!(missed.is_empty(), "{} of {tried}: {}", missed.len(), missed.join("\n---\n"));
}

/// A number from 0 to 1 of a seed (`SplitMix64`).
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn arcs_of_all_radii_come_back_from_every_dialect() {
    let mut seed = 7;
    let mut wrong = Vec::new();
    for case in 0..150 {
        let radius = 10f64.powf(random(&mut seed) * 6.0);
        let chord = (radius * 0.5).min(0.5 + 20.0 * random(&mut seed));
        let (x, y) = (50.0 * random(&mut seed), 250.0 * random(&mut seed));
        // Rounded as a CAM system writes it: start and end lie a little off the circle.
        let half = (chord / (2.0 * radius)).asin();
        let (i, j) = (radius * half.sin(), -radius * half.cos());
        let clockwise = random(&mut seed) < 0.5;
        let (word, j) = if clockwise { ("G2", j) } else { ("G3", -j) };
        let text = format!(
            "G21 G17 G90 G94\nG0 X{x:.4} Y{y:.4} Z0\nF3500\n{word} X{:.4} Y{:.4} I{i:.4} J{j:.4}\nG1 X0 Y0\nM2\n",
            x + chord,
            y
        );
        let read = || Program::from_text("arc.ngc", text.as_str(), &settings(Dialect::LinuxCnc)).unwrap();
        let commands: Vec<_> = read().map(|c| c.unwrap()).collect();
        for to in TARGETS {
            let form = PostSettings::between(Dialect::LinuxCnc, to);
            let out = post(&commands, to, form.clone()).unwrap();
            let back = Program::from_text("written", out.as_str(), &settings(to)).unwrap();
            if let Err(difference) = verify(read(), back, &form) {
                wrong.push(format!("{case} {}: {difference:?}\n{text}---\n{out}", to.name()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} arcs do not come back:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn the_length_of_a_tool_is_called_behind_its_change() {
    let text = "G17 G54 G90 G710\nT1 D1\nM6\nS1000 M3\nG0 X0 Y0\nG0 Z50\nG1 Z-2 F200\nT2 D1\nX20\nM6\nG0 Z50\nM30\n";
    let commands: Vec<_> =
        Program::from_text("t.mpf", text, &settings(Dialect::Siemens840d)).unwrap().map(|c| c.unwrap()).collect();
    for to in [Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc] {
        let out = post(&commands, to, PostSettings::between(Dialect::Siemens840d, to)).unwrap();
        let lines: Vec<&str> = out.lines().collect();
        let change = lines.iter().position(|l| l.contains("M6")).unwrap();
        let length = lines.iter().position(|l| l.contains("G43 H1")).unwrap();
        assert!(length > change, "{}:\n{out}", to.name());
    }
}

#[test]
fn a_haas_gets_no_g33() {
    let text = "G21 G90 G94\nG0 X0 Y0 Z5\nS100 M3\nG33 Z-10 K1\nG0 X10\nM2\n";
    let commands: Vec<_> =
        Program::from_text("t.ngc", text, &settings(Dialect::LinuxCnc)).unwrap().map(|c| c.unwrap()).collect();
    let error = post(&commands, Dialect::Haas, PostSettings::between(Dialect::LinuxCnc, Dialect::Haas)).unwrap_err();
    assert!(error.to_string().contains("G33"), "{error}");
}
