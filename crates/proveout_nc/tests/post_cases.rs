//! Every case program through every post: it is refused by name, or it comes back as the same motions.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{post, same_commands};
use proveout_nc::post::{PostError, PostSettings};
use proveout_nc::{Command, Dialect, Program, Settings, WorkOffset};

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

/// The first work offset is the same on every control; the others are zero.
fn settings(dialect: Dialect, translation: [f64; 3]) -> Settings {
    let mut settings = Settings { dialect, ..Settings::default() };
    let offset = WorkOffset { translation, rotary: [0.0; 3] };
    for word in ["G54", "PRESET1"] {
        settings.work_offsets.insert(word.to_owned(), offset);
    }
    settings.work_offsets.insert("DATUM5".to_owned(), WorkOffset { translation: [1.0, 2.0, 3.0], rotary: [0.0; 3] });
    for (name, value) in [("R1", 1.0), ("M92_Z", 400.0), ("Q108", 6.0), ("$P_TOOLR", 6.0)] {
        settings.variables.insert(name.to_owned(), value);
    }
    settings
}

fn programs(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name);
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_file() && p.extension().is_some_and(|e| e != "jsonl"))
        .filter(|p| !p.file_name().unwrap().to_string_lossy().starts_with("sub_"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_case_is_refused_by_name_or_comes_back() {
    let mut counts = Vec::new();
    let mut broken = std::collections::BTreeSet::new();
    for (name, from, shift) in SOURCES.into_iter().flat_map(|(n, d)| [(n, d, [0.0; 3]), (n, d, [100.0, 200.0, 300.0])])
    {
        for path in programs(name) {
            let program = Program::open(&path, &settings(from, shift)).unwrap();
            let first: Vec<Command> = program.map(|c| c.unwrap_or_else(|e| panic!("{e}"))).collect();
            for to in TARGETS {
                let format =
                    PostSettings { work_offsets: settings(to, shift).work_offsets, ..PostSettings::between(from, to) };
                let length = 1.2 * 10f64.powi(-(format.length_decimals as i32));
                let what = format!("{} to {}", path.display(), to.name());
                let written = match post(&first, to, format) {
                    Ok(written) => written,
                    Err(PostError::Unsupported { what: said, help, location }) => {
                        assert!(!said.is_empty() && !help.is_empty() && location.line > 0, "{what}: {said}");
                        if shift == [0.0; 3] {
                            counts.push((to, false, said));
                        }
                        continue;
                    }
                    Err(error) => panic!("{what}: {error}"),
                };
                // Its entry is as long as the tool radius, which a LinuxCNC refuses: `nc --post` finds it
                // when it reads the text again.
                if path.ends_with("contour_milling.mpf") && to == Dialect::LinuxCnc {
                    let mut read = Program::from_text("written", written.as_str(), &settings(to, shift)).unwrap();
                    let fault = read.find_map(Result::err).unwrap();
                    assert!(fault.message.contains("not longer than the tool radius"), "{what}: {fault}");
                    continue;
                }
                // All that does not come back is listed at once.
                let back = std::panic::catch_unwind(|| {
                    let read = Program::from_text("written", written.as_str(), &settings(to, shift)).unwrap();
                    let second: Vec<Command> =
                        read.map(|c| c.unwrap_or_else(|e| panic!("{what}: {e}\n{written}"))).collect();
                    same_commands(&first, &second, length, &format!("{what}\n{written}"));
                });
                if back.is_err() {
                    broken.insert(what);
                }
                if shift == [0.0; 3] {
                    counts.push((to, true, String::new()));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    // A post that refuses everything would pass the test above.
    for to in TARGETS {
        let (said, all) = counts.iter().filter(|c| c.0 == to).fold((0, 0), |(s, a), c| (s + usize::from(c.1), a + 1));
        assert!(
            said * 8 > all,
            "{} writes {said} of {all} programs: {:?}",
            to.name(),
            counts.iter().filter(|c| c.0 == to && !c.1).map(|c| &c.2).collect::<Vec<_>>()
        );
    }
}
