//! `check` reports the faults of all lines at once, each at its line, and none that follows from another.
//!
//! Faults are put into the programs of the case folders, which are in order: as lines of their own, and at
//! the end of lines that are there, which then set less than they did. Corners: the first and the last line,
//! neighboring lines, lines in loops and subprograms, between the parts of a cycle. Multi-line blocks are not
//! cut in two. `PROVEOUT_CASES` raises the count.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use proveout_nc::{Dialect, Limits, Settings, Survey, WorkOffset};

/// A language with what makes a line wrong.
struct Language {
    folder: &'static str,
    dialect: Dialect,
    /// Wrong wherever they are.
    lines: &'static [&'static str],
    /// Wrong where they are run.
    run: &'static [&'static str],
    /// After a line.
    tail: &'static str,
}

const LANGUAGES: [Language; 7] = [
    Language {
        folder: "siemens",
        dialect: Dialect::Siemens840d,
        lines: &["G999 X5", "X1 Y", "R1=(1+", "X1..2", "TRACYL(5)", "MSG(\"open"],
        run: &["GOTOF NO_LABEL_HERE", "NO_SUCH_SUB", "L9999", "$"],
        tail: " )",
    },
    Language {
        folder: "fanuc",
        dialect: Dialect::Fanuc,
        lines: &["G999", "X", "X1..5", "#1=[1+", "Y=5", "G29 X1", "T", "(open"],
        run: &["GOTO 98765", "M98 P8765", "IF [1 EQ 1] GOTO 98765"],
        tail: " Y",
    },
    Language {
        folder: "haas",
        dialect: Dialect::Haas,
        lines: &["G999", "X", "X1..5", "G47 P1"],
        run: &["M98 P8765", "M97 P98765"],
        tail: " @",
    },
    Language {
        folder: "linuxcnc",
        dialect: Dialect::LinuxCnc,
        lines: &["G999", "X", "G72 P1", "#1=[1+", "X1.5.5", "M66 P1"],
        run: &["o<nosuch> call", "M98 P8765"],
        tail: " X",
    },
    Language {
        folder: "heidenhain",
        dialect: Dialect::Heidenhain,
        lines: &["L X+", "FROB 5", "L X+1 X+2", "TCH PROBE 1", "L X+1 @", "Q1 = 1 +"],
        run: &["CALL LBL 987", "FN 9: IF +1 EQU +1 GOTO LBL 988", "CALL PGM NO_SUCH_PROGRAM"],
        tail: " @",
    },
    Language {
        folder: "heidenhain-iso",
        dialect: Dialect::HeidenhainIso,
        lines: &["G01 X+", "G999 X+1", "G00 X+1 X+2"],
        run: &["L987,0", "%NO_SUCH_PROGRAM"],
        tail: " @",
    },
    Language {
        folder: "apt",
        dialect: Dialect::Apt,
        lines: &["GOTO/1,,2", "BLAH/3", "SPLINE/1,2"],
        run: &["GOTO/1,2", "FEDRAT/-5", "UNITS/FOOT"],
        tail: ",,1",
    },
];

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

fn settings(dialect: Dialect) -> Settings {
    let limits = Limits { max_loop_passes: 20_000, max_idle_passes: 2_000, ..Limits::default() };
    let mut settings = Settings { dialect, limits, ..Settings::default() };
    let offset = |translation| WorkOffset { translation, rotary: [0.0; 3] };
    for (name, translation) in
        [("G54", [100.0, 200.0, 300.0]), ("PRESET1", [100.0, 200.0, 300.0]), ("DATUM5", [1.0, 2.0, 3.0])]
    {
        settings.work_offsets.insert(name.to_owned(), offset(translation));
    }
    for (name, value) in [("R1", 1.0), ("M92_Z", 400.0), ("Q108", 6.0), ("$P_TOOLR", 6.0)] {
        settings.variables.insert(name.to_owned(), value);
    }
    settings
}

fn cases(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(folder);
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e != "jsonl"))
        .filter(|path| !path.file_name().unwrap().to_string_lossy().starts_with("sub_"))
        .collect();
    files.sort();
    files
}

/// A line may be put in front of this one, or something after it, without cutting a block in two.
fn is_whole(lines: &[String], at: usize) -> bool {
    let continued = |line: &str| line.trim_end().ends_with(['~', '$']);
    let parameter = |line: &str| line.trim_start().starts_with('Q') && (line.contains('=') || line.contains(" F"));
    let here = lines.get(at).map_or("", String::as_str);
    !continued(here)
        && at.checked_sub(1).is_none_or(|before| !continued(&lines[before]))
        && !parameter(here)
        && !here.trim_start().starts_with("CYCL DEF 2")
        && at.checked_sub(1).is_none_or(|before| !lines[before].contains("CYCL DEF 2"))
}

/// `O1000 (TEXT)`
fn is_head(line: &str) -> bool {
    line.strip_prefix('O').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
}

fn defines_cycle(line: &str) -> bool {
    line.contains("CYCL DEF") || line.contains("CYCLE DEF")
}

/// A block of its own, without a comment that would swallow what is put after it.
fn is_plain(line: &str) -> bool {
    let code = line.trim();
    // The first block of an old cycle ends with its title.
    let title = defines_cycle(code) && code.contains(".0 ");
    !code.is_empty()
        && !title
        && !code.contains(['(', ';', '%', '$', '*', '~', '"', '{'])
        && ![
            "PARTNO",
            // Its values may be left out.
            "TOOLNO",
            "PPRINT",
            "PPWORD",
            "INSERT",
            "TPRINT",
            "BEGIN",
            "PGM",
            "CYCL DEF 2",
            "CYCLE DEF 2",
            "F-PRINT",
            "TOOL DEF",
            "REMARK",
            "LETTER",
            "LEADER",
            "DISPLY",
            "TITLES",
            "BLK",
            "FUNCTION",
            "STOP",
        ]
        .iter()
        .any(|word| code.to_ascii_uppercase().contains(word))
}

/// What a survey reports, and what it should.
fn expect_reports(
    test: &str,
    path: &Path,
    text: &str,
    language: &Language,
    wrong: &BTreeSet<u32>,
) -> Result<BTreeSet<u32>, String> {
    // Next to the case, so that its subprograms are found.
    let name = path.file_stem().unwrap().to_string_lossy().into_owned();
    let ending = path.extension().unwrap().to_string_lossy().into_owned();
    let folder = tempdir(test, path);
    let file = folder.join(format!("{name}.{ending}"));
    fs::write(&file, text).unwrap();
    let mut ran = BTreeSet::new();
    let survey = Survey::of_file(&file, &settings(language.dialect), &mut |command, _| {
        if command.location.file.contains(name.as_str()) {
            ran.insert(command.location.line);
        }
        None
    });
    let lines: Vec<u32> =
        survey.faults.iter().filter(|fault| fault.file.contains(name.as_str())).map(|fault| fault.line).collect();
    let unique: BTreeSet<u32> = lines.iter().copied().collect();
    if unique == *wrong && lines.len() == wrong.len() && survey.more_faults == 0 {
        return Ok(ran);
    }
    let faults: String = survey.faults.iter().map(|f| format!("  {f} [{}]\n", f.code)).collect();
    Err(format!("{}\nwrong lines {wrong:?}, told\n{faults}{}", path.display(), numbered(text)))
}

fn numbered(text: &str) -> String {
    text.lines().zip(1..).map(|(line, number)| format!("{number:4} {line}\n")).collect()
}

/// A folder of this process with the subprograms of the case.
fn tempdir(test: &str, path: &Path) -> PathBuf {
    let from = path.parent().unwrap();
    let kind = from.file_name().unwrap().to_string_lossy().into_owned();
    let folder = std::env::temp_dir().join(format!("proveout-recovery-{}-{test}-{kind}", std::process::id()));
    if !folder.is_dir() {
        fs::create_dir_all(&folder).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let file = entry.unwrap().path();
            if file.file_name().unwrap().to_string_lossy().starts_with("sub_") {
                fs::copy(&file, folder.join(file.file_name().unwrap())).unwrap();
            }
        }
    }
    folder
}

fn all_told(failures: &[String]) {
    assert!(
        failures.is_empty(),
        "{} programs, the first ones:\n{}",
        failures.len(),
        failures[..failures.len().min(6)].join("\n")
    );
}

fn count() -> usize {
    std::env::var("PROVEOUT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(8)
}

#[test]
fn the_cases_themselves_are_in_order() {
    for language in &LANGUAGES {
        for path in cases(language.folder) {
            expect_reports("clean", &path, &fs::read_to_string(&path).unwrap(), language, &BTreeSet::new()).unwrap();
        }
    }
}

#[test]
fn each_wrong_line_is_reported_and_no_other() {
    let mut random = Random(1);
    let mut failures = Vec::new();
    for language in &LANGUAGES {
        for path in cases(language.folder) {
            let text = fs::read_to_string(&path).unwrap();
            let ran = expect_reports("wrong", &path, &text, language, &BTreeSet::new()).unwrap();
            for _ in 0..count() {
                let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                // After the tape nothing is read.
                let end = lines.iter().rposition(|line| line.trim() == "%").unwrap_or(lines.len());
                // The head of an archive or a tape is the first line.
                let first = lines
                    .iter()
                    .take(3)
                    .rposition(|line| line.starts_with('%') || is_head(line))
                    .map_or(0, |at| at + 1);
                let places: Vec<usize> = (first..=end).filter(|at| is_whole(&lines, *at)).collect();
                let mut at: Vec<usize> = (0..1 + random.below(8)).map(|_| places[random.below(places.len())]).collect();
                if random.below(4) == 0 {
                    at.extend([places[0], places[places.len() - 1]]);
                }
                at.sort_unstable();
                let mut wrong = BTreeSet::new();
                let lines_before = lines.clone();
                for (put, at) in at.iter().enumerate() {
                    // After a block that is run; an approach or a corner wants its contour after it.
                    let before =
                        lines_before[..*at].iter().rfind(|line| !line.starts_with(';')).map_or("", String::as_str);
                    let waits =
                        ["APPR", "RND", "CHF", "ANG=", "G24", "G25", "CYCL"].iter().any(|word| before.contains(word));
                    let ends = ["M30", "m30", "M2", "m2", "M17", "M99", "FINI", "END", "AUXFUN", "RET", "FUNCTION"]
                        .iter()
                        .any(|word| before.contains(word));
                    let runs = !waits && !ends && ran.contains(&(*at as u32)) && random.below(2) == 0;
                    let choice = if runs { language.run } else { language.lines };
                    lines.insert(at + put, choice[random.below(choice.len())].to_owned());
                    wrong.insert((at + put + 1) as u32);
                }
                if let Err(text) = expect_reports("wrong", &path, &(lines.join("\n") + "\n"), language, &wrong) {
                    failures.push(text);
                }
            }
        }
    }
    all_told(&failures);
}

#[test]
fn a_line_that_is_spoiled_is_reported_and_nothing_that_follows_from_it() {
    let mut random = Random(2);
    let mut failures = Vec::new();
    for language in &LANGUAGES {
        for path in cases(language.folder) {
            let text = fs::read_to_string(&path).unwrap();
            for _ in 0..count() {
                let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
                let places: Vec<usize> =
                    (0..lines.len()).filter(|at| is_whole(&lines, *at) && is_plain(&lines[*at])).collect();
                let picks = if places.is_empty() { 0 } else { 1 + random.below(5) };
                let picked: BTreeSet<usize> = (0..picks).map(|_| places[random.below(places.len())]).collect();
                for at in &picked {
                    lines[*at].push_str(language.tail);
                }
                let wrong = picked.iter().map(|at| *at as u32 + 1).collect();
                if let Err(text) = expect_reports("spoiled", &path, &(lines.join("\n") + "\n"), language, &wrong) {
                    failures.push(text);
                }
            }
        }
    }
    all_told(&failures);
}
