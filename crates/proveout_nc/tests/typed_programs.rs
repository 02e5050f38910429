//! Programs by their form (`typed/`): each is read as it is, read with the control file that the program
//! writes for it, or refused for a reason that no control file mends.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]
#![allow(clippy::print_stdout, reason = "the counts are what a reader of the test wants to see")]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use proveout_nc::{Advice, AdviceCall, Control, Settings, Survey, check, check_text};

/// Programs of the set.
const LEAST: usize = 150;
/// A control file of a shop, for programs that name the control `mill`.
const MILL: &str = include_str!("typed/mill.toml");

/// The file, with its forms.
const FILES: [(&str, &str); 7] = [
    ("fanuc", include_str!("typed/fanuc.txt")),
    ("haas", include_str!("typed/haas.txt")),
    ("linuxcnc", include_str!("typed/linuxcnc.txt")),
    ("siemens", include_str!("typed/siemens.txt")),
    ("heidenhain", include_str!("typed/heidenhain.txt")),
    ("apt", include_str!("typed/apt.txt")),
    ("others", include_str!("typed/others.txt")),
];

struct Typed<'a> {
    form: &'a str,
    file: &'a str,
    control: &'a str,
    expected: &'a str,
    text: String,
}

fn programs(text: &str) -> Vec<Typed<'_>> {
    let mut list: Vec<Typed<'_>> = Vec::new();
    for line in text.lines() {
        if let Some(head) = line.strip_prefix("=== ") {
            let parts: Vec<&str> = head.split(" | ").collect();
            let [form, file, control, expected] = parts[..] else { panic!("four parts: {head}") };
            list.push(Typed { form, file, control, expected, text: String::new() });
        } else if let Some(program) = list.last_mut() {
            program.text.push_str(line);
            program.text.push('\n');
        }
    }
    list
}

fn settings(control: &str) -> Settings {
    match control {
        "-" => Settings::default(),
        "mill" => Settings::of_control(Control::from_text("mill.toml", MILL, None).unwrap()),
        name => Settings::of_control(Control::find(name, None).unwrap_or_else(|e| panic!("{e}"))),
    }
}

fn advice(program: &Typed<'_>) -> Advice {
    let inherits = match program.control {
        "-" => None,
        "mill" => Some(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/typed/mill.toml").to_owned()),
        name => Some(name.to_owned()),
    };
    let call = AdviceCall { settings: settings(program.control), inherits, complete: &|settings| settings };
    Advice::of_text(program.file, &program.text, &call).unwrap_or_else(|_| panic!("{}: no program", program.form))
}

/// What is wrong with what happens, if anything is.
fn verdict(program: &Typed<'_>) -> Result<&'static str, String> {
    let faults = check_text(program.file, &program.text, &settings(program.control));
    let codes = |list: &[proveout_nc::Diagnostic]| -> String {
        list.iter().map(|f| format!("{}:{} {}", f.code, f.line, f.message)).collect::<Vec<_>>().join("; ")
    };
    let (kind, rest) = program.expected.split_once(' ').unwrap_or((program.expected, ""));
    match kind {
        "read" if faults.is_empty() => Ok("read"),
        "read" => Err(format!("refused: {}", codes(&faults))),
        _ if faults.is_empty() => Err("read as it is".to_owned()),
        "refused" if faults[0].code == "nc-dialect" => Ok("refused"),
        "file" => {
            let advice = advice(program);
            if !advice.reads() {
                return Err(format!("not read with the file: {}\n{}", codes(&advice.left), advice.control_file()));
            }
            let mut keys: Vec<&str> = advice.statements.iter().map(|s| s.key.as_str()).collect();
            keys.sort_unstable();
            let stated = keys.join(", ");
            if stated != rest {
                return Err(format!("the file states {stated}\n{}", advice.control_file()));
            }
            // The file as it is written is a control file with which the program is read, and is not
            // confirmed.
            let control = Control::from_text("written.toml", advice.control_file(), None).map_err(|e| e.to_string())?;
            let assumed = control.assumed().len();
            let settings = Settings::of_control(control);
            let again = Survey::of_text(program.file, program.text.clone(), &settings, &mut |_, _| None).judged();
            if !again.is_empty() || assumed != keys.len() {
                return Err(format!("{} assumed; again: {}", assumed, codes(&again)));
            }
            Ok("read with the written file")
        }
        _ => {
            let code = rest.split(':').next().unwrap_or_default();
            let advice = advice(program);
            if advice.reads() {
                return Err(format!("read with a file:\n{}", advice.control_file()));
            }
            if advice.left.iter().all(|fault| fault.code != code) {
                return Err(format!("refused for {}", codes(&advice.left)));
            }
            Ok("refused")
        }
    }
}

#[test]
fn each_form_is_read_or_refused_as_its_head_says() {
    let mut wrong = String::new();
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (language, text) in FILES {
        for program in programs(text) {
            match verdict(&program) {
                Ok(kind) => *counts.entry((language, kind)).or_default() += 1,
                Err(what) => writeln!(wrong, "{language}: {}\n  {what}", program.form).unwrap(),
            }
        }
    }
    let all: usize = counts.values().sum();
    for ((language, kind), count) in &counts {
        println!("{language:<12} {kind:<28} {count}");
    }
    println!("{all} programs as expected");
    assert!(wrong.is_empty(), "{all} as expected; others:\n{wrong}");
    assert!(all >= LEAST, "{all} programs");
}

#[test]
fn a_written_file_has_six_statements_at_most_each_with_its_reason() {
    for (_, text) in FILES {
        for program in programs(text).iter().filter(|p| p.expected.starts_with("file ")) {
            let advice = advice(program);
            let keys = advice.statements.len();
            assert!(keys <= 6, "{}: {keys} statements", program.form);
            for statement in &advice.statements {
                let line = format!("{} = {}\n", statement.key.split_once('.').unwrap().1, statement.value);
                assert!(!statement.why.is_empty() && statement.count > 0, "{}: {line}", program.form);
            }
        }
    }
}

/// Counts over a folder of programs of the reader of this test, by the ending of the name.
#[test]
fn programs_of_a_folder() {
    let Some(folder) = std::env::var_os("PROVEOUT_PROGRAMS") else {
        println!("LEFT OUT: PROVEOUT_PROGRAMS names no folder");
        return;
    };
    let control = std::env::var("PROVEOUT_CONTROL").ok();
    let mut files = Vec::new();
    collect(Path::new(&folder), &mut files);
    files.sort();
    let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
    for file in &files {
        let settings = settings(control.as_deref().unwrap_or("-"));
        let call = AdviceCall { settings: settings.clone(), inherits: control.clone(), complete: &|settings| settings };
        let faults = check(file, &settings);
        let told = if faults.is_empty() {
            "read".to_owned()
        } else {
            match Advice::of_files(std::slice::from_ref(file), &call) {
                Ok(advice) if advice.reads() => {
                    let keys: Vec<&str> = advice.statements.iter().map(|s| s.key.as_str()).collect();
                    println!("written  {}: {}", file.display(), keys.join(", "));
                    "read with the written file".to_owned()
                }
                Ok(advice) => {
                    println!("refused  {}", advice.left[0]);
                    format!("refused {}", advice.left[0].code)
                }
                Err(faults) => {
                    println!("refused  {faults}");
                    format!("refused {}", faults.0[0].code)
                }
            }
        };
        let ending = file.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase());
        *counts.entry((ending, told)).or_default() += 1;
    }
    for ((ending, told), count) in &counts {
        println!("{ending:<8} {told:<32} {count}");
    }
    println!("{} programs", files.len());
}

/// Files of a folder and those below it whose names end as programs do.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    const ENDINGS: [&str; 20] = [
        "nc", "ngc", "tap", "cnc", "gcode", "eia", "min", "mpf", "spf", "arc", "h", "i", "apt", "cls", "cl", "pim",
        "txt", "din", "iso", "g",
    ];
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| ENDINGS.contains(&e.to_string_lossy().to_ascii_lowercase().as_str()))
        {
            files.push(path);
        }
    }
}
