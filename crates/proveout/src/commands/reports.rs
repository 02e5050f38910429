//! Findings for other programs: `--sarif`, `--junit`.

use std::{
    collections::BTreeMap,
    fs::File,
    io::Read,
    path::{Path, PathBuf},
    sync::Arc,
};

use proveout_nc::{CODES, ProgramText};
use proveout_record::exchange::{CaseAnswer, ReportedCase, ReportedItem, ReportedSuite, junit, reported, sarif};
use proveout_sim::{finding::Severity, verdict::Verdict};
use serde_json::Map;

use super::output_file;
use crate::{args::ReportArgs, failure::Failure};

/// Bytes at the begin of a file that show what it is.
const LOOKED_AT: u64 = 4096;
/// Code of a fault of an input that has none of its own, and of a likely cause of findings.
const INPUT: (&str, &str) = ("input-error", "An input file or the call is not in order.");
const LIKELY: (&str, &str) = ("before-run", "A likely cause of findings, seen before the run.");
/// The one case of a checked file.
const CHECK: &str = "check";

/// Refuses places that cannot be written, before the work is done: only an older report is replaced.
pub(super) fn check(args: &ReportArgs) -> Result<(), Failure> {
    let kinds = [
        (&args.sarif, "--sarif", &["sarif", "json"][..], "sarif-2.1.0", "a SARIF log"),
        (&args.junit, "--junit", &["xml"][..], "<testsuites", "a JUnit file"),
    ];
    for (place, option, endings, sign, what) in kinds {
        let Some(place) = place else { continue };
        let ending = place.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !endings.contains(&ending.as_str()) {
            let wanted: Vec<String> = endings.iter().map(|e| format!(".{e}")).collect();
            return Err(Failure::new(format!("{}: {option} writes {what}, {}", place.display(), wanted.join(" or ")))
                .with_help(format!("use the extension {}", wanted.first().map_or("", String::as_str))));
        }
        output_file::check(place, true)?;
        if place.exists() && !holds(place, sign) {
            return Err(Failure::new(format!("{} exists and is not {what}: it is not replaced", place.display()))
                .with_help("name another file"));
        }
    }
    Ok(())
}

/// Whether a sign is at the begin of a file.
fn holds(path: &Path, sign: &str) -> bool {
    let mut begin = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LOOKED_AT).read_to_end(&mut begin));
    read.is_ok() && String::from_utf8_lossy(&begin).contains(sign)
}

/// Writes what is asked for.
pub(super) fn write(args: &ReportArgs, suites: &[ReportedSuite]) -> Result<(), Failure> {
    if let Some(place) = &args.sarif {
        output_file::put_bytes(place, true, sarif(suites).map_err(Failure::new)?)?;
    }
    if let Some(place) = &args.junit {
        output_file::put_bytes(place, true, junit(suites))?;
    }
    Ok(())
}

/// Texts of the programs of a run, by their names in findings; each is read once.
pub(super) struct ProgramTexts {
    opened: BTreeMap<String, PathBuf>,
    texts: BTreeMap<String, Option<ProgramText>>,
}

impl ProgramTexts {
    /// `shown`: names in findings by the paths that were opened.
    pub(super) fn new(shown: &BTreeMap<String, Arc<str>>) -> Self {
        let opened = shown.iter().map(|(path, name)| (name.to_string(), PathBuf::from(path))).collect();
        Self { opened, texts: BTreeMap::new() }
    }

    /// Path from the folder of the call, where it is below it, and text of a line.
    fn line(&mut self, name: &str, line: Option<u32>) -> (String, String) {
        let Some(path) = self.opened.get(name) else { return (name.to_owned(), String::new()) };
        let text =
            self.texts.entry(name.to_owned()).or_insert_with(|| ProgramText::open(path.display().to_string()).ok());
        let line = line.and_then(|line| text.as_ref()?.line(line as usize)).unwrap_or_default();
        (from_here(path), line.to_owned())
    }
}

/// A path from the folder of the call, where it is below it.
fn from_here(path: &Path) -> String {
    let inside = || {
        let here = std::env::current_dir().ok()?.canonicalize().ok()?;
        Some(path.canonicalize().ok()?.strip_prefix(here).ok()?.display().to_string())
    };
    inside().unwrap_or_else(|| path.display().to_string())
}

/// Writes the findings of a run.
pub(super) fn of_verdict(args: &ReportArgs, verdict: &Verdict, mut texts: ProgramTexts) -> Result<(), Failure> {
    if args.sarif.is_none() && args.junit.is_none() {
        return Ok(());
    }
    write(args, &[reported(verdict, &mut |name, line| texts.line(name, line))])
}

/// Writes what kept a run from its verdict.
pub(super) fn of_failure(args: &ReportArgs, path: &Path, kind: &str, failure: &Failure) -> Result<(), Failure> {
    write(args, &[of_faults(path, kind, failure)])
}

/// Faults of an input, each with its place.
pub(super) fn of_faults(path: &Path, kind: &str, failure: &Failure) -> ReportedSuite {
    let item = |fault: &Failure| {
        let code = fault.code().unwrap_or(INPUT.0);
        let summary = CODES.iter().find(|c| c.code == code).map_or(INPUT.1, |c| c.summary);
        let (file, line, column) = fault.place().unwrap_or_default();
        let known = |n: usize| u32::try_from(n).ok().filter(|n| *n > 0);
        let mut more = Map::new();
        if !fault.help().is_empty() {
            more.insert("help".to_owned(), fault.help().into());
        }
        ReportedItem {
            code: code.to_owned(),
            summary: summary.to_owned(),
            severity: Severity::Error,
            // The code has a place of its own.
            message: fault.message().trim_end_matches(&format!(" [{code}]")).to_owned(),
            case: Some(CHECK.to_owned()),
            file: (!file.is_empty()).then(|| from_here(Path::new(file))),
            line: known(line),
            column: known(column),
            line_text: fault.source_line().to_owned(),
            more,
        }
    };
    ReportedSuite {
        name: path.display().to_string(),
        group: kind.to_owned(),
        time_s: None,
        cases: vec![ReportedCase {
            name: CHECK.to_owned(),
            answer: CaseAnswer::Fail,
            reason: failure.message().to_owned(),
        }],
        items: failure.all().into_iter().map(item).collect(),
        executed: false,
    }
}

/// A file that is in order, with the likely causes of findings: program and words.
pub(super) fn of_check(path: &Path, kind: &str, warnings: &[[String; 2]]) -> ReportedSuite {
    let item = |[program, words]: &[String; 2]| ReportedItem {
        code: LIKELY.0.to_owned(),
        summary: LIKELY.1.to_owned(),
        severity: Severity::Warning,
        message: if program.is_empty() { words.clone() } else { format!("program {program}: {words}") },
        case: None,
        file: path.is_file().then(|| from_here(path)),
        line: None,
        column: None,
        line_text: String::new(),
        more: Map::new(),
    };
    ReportedSuite {
        name: path.display().to_string(),
        group: kind.to_owned(),
        time_s: None,
        cases: vec![ReportedCase { name: CHECK.to_owned(), answer: CaseAnswer::Pass, reason: String::new() }],
        items: warnings.iter().map(item).collect(),
        executed: true,
    }
}
