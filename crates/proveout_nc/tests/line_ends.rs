//! The line ends of a file, and what is around it on tape and disk, change nothing: the same commands at
//! the same places.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use proveout_nc::{Dialect, JsonWriter, Program, Settings, WorkOffset};

const DIALECTS: [(&str, Dialect); 8] = [
    ("siemens", Dialect::Siemens840d),
    ("iso", Dialect::Iso),
    ("fanuc", Dialect::Fanuc),
    ("haas", Dialect::Haas),
    ("linuxcnc", Dialect::LinuxCnc),
    ("heidenhain", Dialect::Heidenhain),
    ("heidenhain-iso", Dialect::HeidenhainIso),
    ("apt", Dialect::Apt),
];

fn settings(dialect: Dialect) -> Settings {
    let mut settings = Settings { dialect, ..Settings::default() };
    for name in ["G54", "PRESET1", "DATUM5"] {
        let offset = WorkOffset { translation: [100.0, 200.0, 300.0], rotary: [0.0; 3] };
        settings.work_offsets.insert(name.to_owned(), offset);
    }
    for (name, value) in [("R1", 1.0), ("M92_Z", 400.0), ("Q108", 6.0), ("$P_TOOLR", 6.0)] {
        settings.variables.insert(name.to_owned(), value);
    }
    settings
}

fn folder(dialect: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(dialect)
}

/// Programs of a folder, without subprograms.
fn cases(dialect: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder(dialect))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e != "jsonl"))
        .filter(|path| !path.file_name().unwrap().to_string_lossy().starts_with("sub_"))
        .collect();
    files.sort();
    files
}

/// The JSON lines of a file with these bytes, without the file names.
fn lines(file: &Path, bytes: &[u8], settings: &Settings) -> String {
    fs::write(file, bytes).unwrap();
    let mut writer = JsonWriter::new();
    let mut out = String::new();
    for command in Program::open(file, settings).unwrap_or_else(|e| panic!("{e}")) {
        for mut value in writer.values(&command.unwrap_or_else(|e| panic!("{e}"))) {
            value.as_object_mut().unwrap().shift_remove("file");
            out.push_str(&value.to_string());
            out.push('\n');
        }
    }
    out
}

#[test]
fn all_line_ends_and_encodings_give_the_same_commands() {
    let work = std::env::temp_dir().join(format!("proveout-line-ends-{}", std::process::id()));
    fs::create_dir_all(&work).unwrap();
    for (name, dialect) in DIALECTS {
        let mut settings = settings(dialect);
        settings.subprogram_folders.push(folder(name));
        for path in cases(name) {
            let text = fs::read_to_string(&path).unwrap();
            assert!(!text.contains('\r') && text.ends_with('\n'), "{}", path.display());
            let file = work.join(path.file_name().unwrap());
            let want = lines(&file, text.as_bytes(), &settings);
            assert!(!want.is_empty());
            let mixed: String =
                text.lines().zip(["\n", "\r\n", "\r"].into_iter().cycle()).map(|(l, e)| l.to_owned() + e).collect();
            let units: Vec<u16> = text.encode_utf16().collect();
            let utf16 = |mark: [u8; 2], bytes: fn(u16) -> [u8; 2]| {
                mark.into_iter().chain(units.iter().flat_map(|unit| bytes(*unit))).collect::<Vec<u8>>()
            };
            let variants: [(&str, Vec<u8>); 11] = [
                ("CR LF", text.replace('\n', "\r\n").into_bytes()),
                ("CR", text.replace('\n', "\r").into_bytes()),
                ("CR CR LF", text.replace('\n', "\r\r\n").into_bytes()),
                ("LF CR CR", text.replace('\n', "\n\r\r").into_bytes()),
                ("mixed", mixed.into_bytes()),
                ("no last end", text.trim_end_matches('\n').as_bytes().to_vec()),
                ("Ctrl-Z", (text.clone() + "\u{1a}").into_bytes()),
                ("NUL around", [&[0; 40], text.as_bytes(), &[0; 40]].concat()),
                ("mark of UTF-8", (String::from("\u{feff}") + &text).into_bytes()),
                ("UTF-16, low byte first", utf16([0xff, 0xfe], u16::to_le_bytes)),
                ("UTF-16, high byte first", utf16([0xfe, 0xff], u16::to_be_bytes)),
            ];
            for (kind, bytes) in variants {
                if kind == "mixed" && text.contains("\n\n") {
                    // CR of one line and LF of an empty one after it are one end.
                    continue;
                }
                let got = lines(&file, &bytes, &settings);
                for (got, want) in got.lines().zip(want.lines()) {
                    assert_eq!(got, want, "{} with {kind}", path.display());
                }
                assert_eq!(got.lines().count(), want.lines().count(), "{} with {kind}", path.display());
            }
        }
    }
    fs::remove_dir_all(&work).unwrap();
}

#[test]
fn utf_16_without_its_mark_is_refused_by_name() {
    let work = std::env::temp_dir().join(format!("proveout-utf-16-{}", std::process::id()));
    fs::create_dir_all(&work).unwrap();
    let file = work.join("p.nc");
    let unmarked: Vec<u8> = "G21\nG0 X1.\nM30\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [unmarked, vec![0xff, 0xfe, 0x47]] {
        fs::write(&file, bytes).unwrap();
        let fault = Program::open(&file, &Settings::default()).unwrap_err().0.remove(0);
        assert_eq!(fault.code, "nc-file");
        assert!(fault.message.contains("UTF-16") && fault.help.is_some(), "{fault}");
    }
    fs::remove_dir_all(&work).unwrap();
}
