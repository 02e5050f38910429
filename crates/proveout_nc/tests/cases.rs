//! Case folders: programs with the commands they must give, and programs with the error they must raise.
//!
//! `PROVEOUT_BLESS=1 cargo test -p proveout_nc --test nc cases::` writes the expected lines again; read the
//! difference.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use proveout_nc::{
    CODES, Compensation, Control, Dialect, JsonWriter, Program, Settings, ToolName, ToolRadii, WorkOffset, check,
};

/// Folders of `tests/cases` and `tests/bad` with the dialect of their programs; [`CONTROLS`] names those that
/// a control reads.
const DIALECTS: [(&str, Dialect); 11] = [
    ("siemens", Dialect::Siemens840d),
    ("iso", Dialect::Iso),
    ("fanuc", Dialect::Fanuc),
    ("haas", Dialect::Haas),
    ("linuxcnc", Dialect::LinuxCnc),
    ("heidenhain", Dialect::Heidenhain),
    ("heidenhain-iso", Dialect::HeidenhainIso),
    ("apt", Dialect::Apt),
    ("okuma", Dialect::Fanuc),
    ("fagor", Dialect::Fanuc),
    ("grbl", Dialect::LinuxCnc),
];

/// Programs of a folder; expected lines, and files that are subprograms of a program next to them (`sub_*`),
/// are left out.
fn programs(kind: &str) -> Vec<(PathBuf, Dialect)> {
    let mut files = Vec::new();
    for (name, dialect) in DIALECTS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(kind).join(name);
        let Ok(entries) = fs::read_dir(folder) else { continue };
        let mut found: Vec<PathBuf> = entries
            .map(|entry| entry.unwrap().path())
            .filter(|p| p.is_file() && p.extension().is_some_and(|e| e != "jsonl"))
            .filter(|p| !p.file_name().unwrap().to_string_lossy().starts_with("sub_"))
            .collect();
        found.sort();
        files.extend(found.into_iter().map(|path| (path, dialect)));
    }
    files
}

/// Folders whose programs a control reads.
const CONTROLS: [(&str, &str); 3] = [("okuma", "okuma-osp"), ("fagor", "fagor-8055"), ("grbl", "grbl-1.1")];

/// Settings of a folder: those of its dialect, or of its control.
fn of_folder(path: &Path, dialect: Dialect) -> Settings {
    let folder = path.parent().and_then(Path::file_name).unwrap().to_string_lossy();
    match CONTROLS.iter().find(|(name, _)| *name == folder) {
        Some((_, control)) => Settings::of_control(Control::find(control, None).unwrap()),
        None => Settings { dialect, ..Settings::default() },
    }
}

fn settings(path: &Path, dialect: Dialect) -> Settings {
    let mut settings = of_folder(path, dialect);
    settings.work_offsets.insert("G54".to_owned(), WorkOffset { translation: [100.0, 200.0, 300.0], rotary: [0.0; 3] });
    settings.variables.insert("R1".to_owned(), 1.0);
    // Of a Heidenhain control: a row of the preset table, one of the datum table, the machine builder's
    // datum.
    settings
        .work_offsets
        .insert("PRESET1".to_owned(), WorkOffset { translation: [100.0, 200.0, 300.0], rotary: [0.0; 3] });
    settings.work_offsets.insert("DATUM5".to_owned(), WorkOffset { translation: [1.0, 2.0, 3.0], rotary: [0.0; 3] });
    settings.variables.insert("M92_Z".to_owned(), 400.0);
    settings.variables.insert("Q108".to_owned(), 6.0);
    if dialect == Dialect::Siemens840d {
        settings.variables.insert("$P_TOOLR".to_owned(), 6.0);
    }
    settings
}

/// The JSON lines of a program without the file name; an error ends them.
fn lines(path: &Path, dialect: Dialect) -> String {
    let mut writer = JsonWriter::new();
    let mut text = String::new();
    for command in Program::open(path, &settings(path, dialect)).unwrap_or_else(|e| panic!("{e}")) {
        match command {
            Ok(command) => {
                for mut value in writer.values(&command) {
                    value.as_object_mut().unwrap().shift_remove("file");
                    text.push_str(&value.to_string());
                    text.push('\n');
                }
            }
            Err(error) => panic!("{error}"),
        }
    }
    text
}

#[test]
fn programs_give_the_expected_commands() {
    let bless = std::env::var_os("PROVEOUT_BLESS").is_some();
    for (path, dialect) in programs("cases") {
        let got = lines(&path, dialect);
        let expected = path.with_extension("jsonl");
        if bless {
            fs::write(&expected, &got).unwrap();
        }
        let want = fs::read_to_string(&expected).unwrap();
        for (at, (got, want)) in got.lines().zip(want.lines()).enumerate() {
            assert_eq!(got, want, "{} line {}", expected.display(), at + 1);
        }
        assert_eq!(got.lines().count(), want.lines().count(), "{}", expected.display());
    }
}

#[test]
fn bad_programs_raise_the_error_they_name() {
    let mut seen = std::collections::BTreeSet::new();
    for (path, dialect) in programs("bad") {
        let text = fs::read_to_string(&path).unwrap();
        // The first line is a comment of the dialect: `; code`, `(code)`, `$$ code`.
        let code = text.lines().next().unwrap();
        let code =
            code.trim_matches(|c: char| matches!(c, ';' | '(' | ')' | '$' | '%') || c.is_whitespace()).to_owned();
        let mut settings = of_folder(&path, dialect);
        // What only the path of the tool center can raise.
        if path.file_name().unwrap().to_string_lossy().starts_with("compensation") {
            let mut radii = ToolRadii::default();
            radii.by_tool.insert(ToolName::Number(1), 5.0);
            radii.by_offset.insert(1, 5.0);
            settings.compensation = Compensation::ToolCenter(radii);
        }
        let faults = check(&path, &settings);
        let fault = faults.first().unwrap_or_else(|| panic!("{} raises nothing", path.display()));
        assert_eq!(fault.code, code, "{}: {fault}", path.display());
        assert!(fault.help.as_ref().is_some_and(|h| !h.is_empty()), "{} has no remedy", path.display());
        assert!(fault.line > 1 && fault.column >= 1 && !fault.source_line.is_empty(), "{}: {fault:?}", path.display());
        seen.insert(code);
    }
    // Every code of the registry is raised by some program; a missing file and an unknown dialect are tested
    // below.
    for info in CODES {
        assert!(
            seen.contains(info.code) || matches!(info.code, "nc-file" | "nc-dialect"),
            "{} has no bad program",
            info.code
        );
    }
}

#[test]
fn a_missing_file_and_an_unknown_dialect_are_named() {
    let faults = check("no/such/file.mpf", &Settings::default());
    assert_eq!(faults[0].code, "nc-file");
    assert!(faults[0].message.contains("no/such/file.mpf"));
    let error = Program::from_text("x.txt", "hello", &Settings::default()).unwrap_err();
    assert_eq!(error.0[0].code, "nc-dialect");
}

#[test]
fn all_faults_of_lines_are_found_at_once() {
    let text = "G0 X\nG999\nX1 Y\nG0 X0 Y0 Z0\nG1 X5\n";
    let faults = proveout_nc::check_text("t.mpf", text, &Settings::default());
    let found: Vec<_> = faults.iter().map(|f| (f.line, f.column, f.length, f.code)).collect();
    assert_eq!(
        found,
        [
            (1, 4, 1, "nc-missing-value"),
            (2, 1, 4, "nc-unknown-word"),
            (3, 4, 1, "nc-missing-value"),
            (5, 1, 5, "nc-no-feed")
        ],
        "{faults:?}"
    );
}

#[test]
fn diagnostics_show_their_line() {
    let error = Program::from_text("part.mpf", "G0 X0\nG0 X1 Q5 ; here\n", &Settings::default())
        .unwrap()
        .find_map(Result::err)
        .unwrap();
    assert_eq!((error.line, error.column, error.length), (2, 7, 2));
    assert_eq!(&*error.source_line, "G0 X1 Q5 ; here");
    assert_eq!(error.to_string(), "part.mpf:2:7: unknown word `Q5`");
    let diagnostic: &dyn miette::Diagnostic = &error;
    let label = diagnostic.labels().unwrap().next().unwrap();
    let span = diagnostic.source_code().unwrap().read_span(label.inner(), 0, 0).unwrap();
    assert_eq!((span.line(), span.column()), (1, 6), "counted from zero");
    assert_eq!(span.data(), b"Q5");
}

#[test]
fn subprograms_are_found_beside_the_program() {
    let folder = std::env::temp_dir().join(format!("proveout-nc-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("main.mpf"), "G0 X0\nSide(2)\nM30\n").unwrap();
    fs::write(folder.join("SIDE.spf"), "PROC SIDE(REAL A)\nX=A\nM17\n").unwrap();
    let commands: Vec<_> =
        Program::open(folder.join("main.mpf"), &Settings::default()).unwrap().collect::<Result<_, _>>().unwrap();
    fs::remove_dir_all(&folder).unwrap();
    assert_eq!(commands.len(), 3);
    assert!(commands[1].location.file.ends_with("SIDE.spf"));
    assert_eq!((commands[1].location.line, commands[1].location.depth), (2, 1));
}
