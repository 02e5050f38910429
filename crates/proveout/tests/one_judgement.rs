//! `nc` and `check` judge a program alike: the same exit status, the same faults, the same assumptions.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn call(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout")).args(args).output().expect("runs")
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Case programs of the readers, and the same texts without their last line.
fn programs(folder: &Path) -> Vec<PathBuf> {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../proveout_nc/tests/cases");
    let mut all = Vec::new();
    for dialect in fs::read_dir(cases).expect("there").map(|e| e.expect("there").path()) {
        let mut files: Vec<PathBuf> =
            fs::read_dir(&dialect).into_iter().flatten().map(|e| e.expect("there").path()).collect();
        files.sort();
        for (n, file) in files.into_iter().filter(|f| f.extension().is_some_and(|e| e != "jsonl")).enumerate() {
            if n % 3 == 0 {
                let text = fs::read_to_string(&file).expect("text");
                let lines: Vec<&str> = text.lines().collect();
                let name = format!("{}-{}", dialect.file_name().expect("a name").to_string_lossy(), n);
                let cut = folder.join(name).with_extension(file.extension().expect("an ending"));
                fs::write(&cut, lines[..lines.len().saturating_sub(1)].join("\n") + "\n").expect("written");
                all.push(cut);
            }
            all.push(file);
        }
    }
    all
}

#[test]
fn nc_and_check_judge_every_program_alike() {
    let folder = std::env::temp_dir().join(format!("one-judgement-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("made");
    let mut apart = Vec::new();
    let mut in_order = 0;
    for program in programs(&folder) {
        let path = program.to_str().expect("a name");
        let (nc, check) = (call(&["nc", path]), call(&["check", path]));
        in_order += usize::from(check.status.success());
        if nc.status.code() != check.status.code() {
            apart.push(format!(
                "{path}: nc {:?}, check {:?}\n{}",
                nc.status.code(),
                check.status.code(),
                printed(&check)
            ));
            continue;
        }
        if !nc.status.success() {
            continue;
        }
        // Each assumption among the commands is one of the check.
        let commands = String::from_utf8_lossy(&nc.stdout).into_owned();
        let assumptions: BTreeSet<String> = commands
            .lines()
            .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
            .filter_map(|line| line["text"].as_str().and_then(|text| text.strip_prefix("assumed: ")).map(str::to_owned))
            .collect();
        let checked = printed(&check);
        for text in assumptions.iter().filter(|text| !checked.contains(*text)) {
            apart.push(format!("{path}: check does not tell {text:?}\n{checked}"));
        }
    }
    fs::remove_dir_all(&folder).expect("removed");
    assert!(apart.is_empty(), "{} programs are judged in two ways:\n{}", apart.len(), apart.join("\n"));
    assert!(in_order > 50, "{in_order} programs are in order");
}
