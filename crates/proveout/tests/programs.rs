//! No text of a program is dropped without a word, and all faults are reported early, as a user meets it:
//! `check`, `nc`, `run`.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// A temporary folder with a scene: a block on a machine, milled by the program of this name.
struct Shop {
    folder: TempDir,
}

impl Shop {
    fn new(program: &str, text: &[u8]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let shop = Self { folder };
        let path = |p: &str| root().join(p).display().to_string();
        let scene = format!(
            "name = \"small\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 4\n[stock]\n\
             box = {{ min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }}\n[mount]\ntranslation_mm = [0, 0, 140]\n\
             [work_offsets.G54]\nZ_mm = 140\n[[program]]\nname = \"main\"\nfile = {program:?}\n",
            path("machines/spinner-u5-620"),
            path("tools/cone-frustum.toml"),
        );
        shop.write("scene.toml", scene.as_bytes());
        shop.write(program, text);
        shop
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.folder.path().join(name), bytes).expect("written");
    }

    fn call(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.folder.path())
            .args(arguments)
            .output()
            .expect("the program starts")
    }

    fn run(&self) -> Output {
        self.call(&["run", ".", "--output", "result", "--rerun", "off"])
    }

    fn verdict(&self) -> Value {
        let output = self.run();
        assert!(matches!(output.status.code(), Some(1 | 3)), "{}", printed(&output));
        let text = fs::read_to_string(self.folder.path().join("result/verdict.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }

    /// The run is refused with all of `words` in so many errors, and leaves nothing.
    fn refused(&self, errors: usize, words: &[&str]) {
        let output = self.run();
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        for word in words {
            assert!(text.contains(word), "{word:?} is not in:\n{text}");
        }
        assert_eq!(text.matches("error: ").count(), errors, "{text}");
        assert!(!self.folder.path().join("result").exists(), "nothing is written");
        let left = fs::read_dir(self.folder.path()).expect("readable").count();
        assert_eq!(left, 2, "scene and program alone");
    }
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

/// State and reason of a gate.
fn gate(verdict: &Value, name: &str) -> (String, String) {
    let gates = verdict["gates"].as_array().expect("gates");
    let gate = gates.iter().find(|g| g["name"] == name).expect("the gate");
    let text = |key: &str| gate[key].as_str().expect("a text").to_owned();
    (text("state"), text("reason"))
}

fn findings<'a>(verdict: &'a Value, code: &str) -> Vec<&'a Value> {
    verdict["findings"].as_array().expect("findings").iter().filter(|f| f["code"] == code).collect()
}

const ISO: &str = "%\nO1\nG21 G17 G90 G94 G40 G80 G49\nT1 M6\nG54 S1000 M3\nG0 B0 C0\nG0 X0. Y0.\nG43 H1 Z50.\nG1 Z10. F500\n@M30\n%\n";

fn iso(more: &str) -> String {
    ISO.replace('@', more)
}

/// `proveout check` of one program: exit code and output.
fn check(name: &str, text: &str) -> (Option<i32>, String) {
    let shop = Shop::new(name, text.as_bytes());
    let output = shop.call(&["check", name]);
    (output.status.code(), printed(&output))
}

/// A wrong form is named as what it looks like, at its place, with what to do.
#[test]
fn a_wrong_form_is_named_as_what_it_looks_like() {
    for (dialect, text, place, says) in [
        ("fanuc", "G21 G90 G0 X10,5 Y0.\nM30\n", ":1:15", "decimal comma?"),
        ("linuxcnc", "G21 G90 G0 X10,5 Y0\nM2\n", ":1:15", "decimal comma?"),
        (
            "fanuc",
            "G21 G90 G0 X10. Y10. Z0.\nG2 X20. Y20. I20. J10. F100.\nM30\n",
            ":2:1",
            "fit exactly as absolute centers",
        ),
        ("fanuc", "G21 G90 G0 X10. Y10. Z0.\nG3 X0. Y20. I10. F100.\nM30\n", ":2:1", "fit with other signs"),
        ("fanuc", "$PART.MIN%\nG0 X0. Y0.\nM30\n", ":1:1", "this looks like Okuma OSP"),
        ("fanuc", "O1\nNOEX VC1=5\nM30\n", ":2:6", "this looks like Okuma OSP"),
        ("fanuc", "O1\nCALL O200\nM30\n", ":2:1", "this looks like Okuma OSP"),
        ("fanuc", "O1\n12 TOOL CALL 5 Z S100\nM30\n", ":2:1", "this looks like Heidenhain Klartext"),
        ("haas", "O1\nN5 TRAORI\nM30\n", ":2:", "this looks like Siemens 840D"),
        ("linuxcnc", "G21\nGOTO/1,2,3\nM2\n", ":2:", "this looks like APT CL data"),
        ("haas", "G21 G90 G0 X0. Y0. Z0.\nG1 X5. ,R1. F10.\nG0 Y5.\nM30\n", ":2:1", "makes no corner"),
    ] {
        let shop = Shop::new("part.nc", text.as_bytes());
        for command in ["check", "nc"] {
            let output = shop.call(&[command, "part.nc", "--dialect", dialect]);
            let message = printed(&output);
            assert!(!output.status.success(), "{command} takes it: {text}{message}");
            let words = message.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(
                message.contains(&format!("part.nc{place}")) && words.contains(says),
                "{command} {says}: {message}"
            );
        }
    }
}

#[test]
fn text_that_is_not_run_fails_the_check_and_names_its_lines() {
    let wrong = [
        // A head after code is another program on a Fanuc and a Haas.
        ("late.nc", "G21 G90\n(comment)\n#1=1\nO100\nG0 X1 Y2\nG1 X5 F100\nM30\n", "nc-no-end", "lines 4 to 7"),
        ("colon.nc", "%\nO1\nG21 G0 X0 Y0\n:20 T2 M6\nG0 Z-60.\nM30\n%\n", "nc-no-end", "lines 4 to 6"),
        // After the end.
        ("end.nc", "G21 G0 X1. Y1.\nM30\nG0 X2.\nG1 X3. F10\n", "nc-not-run", "lines 3 to 4"),
        ("end.ngc", "g21 g0 x1\nm2\ng0 x2\n", "nc-not-run", "line 3"),
        ("end.mpf", "G0 X1 Y1 Z1\nM30\nX2\n", "nc-not-run", "line 3"),
        ("end.h", "BEGIN PGM A MM\nL X+1 Y+1 Z+1 FMAX\nM30\nL X+2 FMAX\nEND PGM A MM\n", "nc-not-run", "line 4"),
        ("end.apt", "LOADTL/1\nRAPID\nGOTO/1,2,3\nFINI\nRAPID\nGOTO/4,5,6\nFINI\n", "nc-not-run", "lines 5 to 6"),
        ("sub.nc", "O1\nG21 G0 X1.\nM98 P2\nG0 X9.\nM30\nO2\nG0 X2.\nM30\n", "nc-not-run", "line 4"),
        // Another main program.
        ("two.nc", "%\nO1\nG21 G0 X1.\nM30\nO2\nG0 X2.\nM30\n%\n", "nc-not-run", "line 6"),
        (
            "two.h",
            "BEGIN PGM A MM\nL X+1 Y+1 Z+1 FMAX\nEND PGM A MM\nBEGIN PGM B MM\nL X+2 FMAX\nEND PGM B MM\n",
            "nc-not-run",
            "line 5",
        ),
        ("two.mpf", "%_N_A_MPF\nG0 X1 Y1 Z1\nM30\n%_N_B_MPF\nG0 X2\nM30\n", "nc-not-run", "line 5"),
        // No motion, no end, nothing at all.
        ("subs.ngc", "g21\no1 sub\ng0 x1\no1 endsub\nm2\n", "nc-no-motion", "linuxcnc"),
        ("still.mpf", "G17 G54\nM30\n", "nc-no-motion", "siemens-840d"),
        ("cut.nc", "G21\nG0 X1. Y1.\nG1 X2. F100\n", "nc-no-end", "cut off"),
        ("cut.mpf", "G0 X1 Y1 Z1\n", "nc-no-end", "M30"),
        ("empty.mpf", "", "nc-no-motion", "moves no axis"),
    ];
    for (name, text, code, words) in wrong {
        let (status, shown) = check(name, text);
        assert_eq!(status, Some(2), "{name}: {shown}");
        assert!(shown.contains(code) && shown.contains(words) && shown.contains("help: "), "{name}: {shown}");
    }
}

#[test]
fn harmless_text_that_is_not_run_is_a_note_with_its_lines() {
    let right = [
        (
            "library.nc",
            "%\nO1\nG21 G0 X1.\nM30\nO2\nG0 X2.\nM99\n%\n",
            "line 6 of library.nc is not run: nothing calls O2",
        ),
        (
            "labels.h",
            "BEGIN PGM A MM\nL X+1 Y+1 Z+1 FMAX\nM30\nLBL 7\nL X+2\nLBL 0\nEND PGM A MM\n",
            "nothing calls LBL 7",
        ),
        ("proc.mpf", "G0 X1 Y1 Z1\nM30\nPROC SIDE\nX2\nRET\n", "line 4 of proc.mpf is not run: nothing calls SIDE"),
        ("subs.ngc", "o<a> sub\ng0 x2\no<a> endsub\ng21 g0 x1\nm2\n", "nothing calls o<a>"),
        ("jump.nc", "G21 G0 X1.\nGOTO 9\nG0 X2.\nN9 M30\n", "line 3 of jump.nc is not run: conditions and jumps"),
        ("leader.nc", "tool list made by a CAM system\n%\nO1\nG21 G0 X1.\nM30\n%\n", "line 1 of leader.nc is not read"),
        ("alarm.nc", "G21 G0 X1.\n#1=1\nIF [#1 EQ 2] GOTO 9\nM30\nN9 #3000=1 (ALARM)\n", "line 5 of alarm.nc"),
    ];
    for (name, text, words) in right {
        let (status, shown) = check(name, text);
        assert_eq!(status, Some(0), "{name}: {shown}");
        assert!(shown.contains(words) && shown.contains("note: "), "{name}: {shown}");
    }
    // Nothing of the text is reported where all of it is run, or is no text of the program; which control is
    // read for, is.
    let fanuc = "no word identifies the control: read as Fanuc";
    for (name, text, note) in [
        ("heads.ngc", "g21 g90\nO100\ng0 x1\nm2\n", None),
        ("all.nc", "%\nO1 (PART)\nG21 G0 X1.\nM98 P2\nM30\nO2\nG0 X2.\nM99\n%\n", Some(fanuc)),
        ("side.spf", "PROC SIDE\nR1=1\nM17\n", None),
        ("old_mac.nc", "%\rO1\rG21 G90\rG0 X1. Y2. Z3.\rM30\r%\r", Some(fanuc)),
        ("dos.nc", "%\r\nO1\r\nG21 G90\r\nG0 X1. Y2. Z3.\r\nM30\r\n%\r\n\u{1a}", Some(fanuc)),
    ] {
        let (status, shown) = check(name, text);
        assert_eq!(status, Some(0), "{name}: {shown}");
        assert_eq!(shown.matches("note: ").count(), usize::from(note.is_some()), "{name}: {shown}");
        assert!(note.is_none_or(|note| shown.contains(note)), "{name}: {shown}");
    }
}

#[test]
fn check_tells_the_faults_of_all_lines() {
    let text = "%\nO1\nG21 G90 G54\nG0 X0 Y0 Z10. F100\nG99.9\nG2 X20.\nQ5\nX1..5\nX=5\nM98 P77\nGOTO 88\nM30\n%\n";
    let (status, shown) = check("part.nc", text);
    assert_eq!(status, Some(2), "{shown}");
    for line in 5..=11 {
        assert!(shown.contains(&format!("part.nc:{line}:")), "line {line}: {shown}");
    }
    assert_eq!(shown.matches("error: ").count(), 7, "{shown}");
    // The same with the line ends of an old Mac.
    let (_, mac) = check("part.nc", &text.replace('\n', "\r"));
    assert_eq!(mac, shown);
    for (name, text, lines) in [
        ("part.mpf", "G0 X1.2.3\nX=_NO_SUCH\nTRAANG(45)\nG1 X==5\nGOTOF NOWHERE\nG291\nM30\n", &[1, 2, 3, 4, 5, 6][..]),
        (
            "part.h",
            "BEGIN PGM A MM\nL X+\nFROB 5\nL X+1 Y+1 Z+1 FMAX\nCALL LBL 9\nL X+2 X+3\nM30\nEND PGM A MM\n",
            &[2, 3, 5, 6],
        ),
        ("part.apt", "LOADTL/1\nGOTO/1,,2\nBLAH/3\nRAPID\nGOTO/1,2,3\nFEDRAT/-5\nGOTO/4,5\nFINI\n", &[2, 3, 6, 7]),
        (
            "part.i",
            "%A G71 *\nN1 G00 X+ *\nN2 G999 *\nN3 G00 X+1 Y+1 Z+1 *\nN4 L9,0 *\nN5 M30 *\nN9 %A G71 *\n",
            &[2, 3, 5],
        ),
        ("part.ngc", "g21\ng0 x\ng17.1\ng0 x1 y1 z1\no<no> call\nm66 p1\nm2\n", &[2, 3, 5, 6]),
    ] {
        let (status, shown) = check(name, text);
        assert_eq!(status, Some(2), "{shown}");
        for line in lines {
            assert!(shown.contains(&format!("{name}:{line}:")), "{name} line {line}: {shown}");
        }
        assert_eq!(shown.matches("error: ").count(), lines.len(), "{shown}");
    }
}

#[test]
fn what_follows_from_a_fault_is_not_reported() {
    for (name, text) in [
        // The feed, the position and the variable of the lost block.
        ("part.nc", "G21 G90 G17\nG0 X0 Y0 Z0 !\nG2 X10. Y0. I5. J0. F100\nM30\n"),
        ("feed.nc", "G21 G90 G17\nG0 X0 Y0 Z0\nG1 X1. F ! 100\nG1 X2.\nM30\n"),
        ("part.mpf", "DEF REAL _A=\nX=_A\nG0 Y=_A+1\nM30\n"),
        ("part.h", "BEGIN PGM A MM\nL X+1 Y+1 Z+1 FMAX @\nCC X+5 Y+1\nC X+9 Y+1 DR+ F100\nEND PGM A MM\n"),
    ] {
        let (status, shown) = check(name, text);
        assert_eq!(status, Some(2), "{shown}");
        assert_eq!(shown.matches("error: ").count(), 1, "{name}: {shown}");
    }
}

#[test]
fn very_many_faults_are_counted() {
    let text = format!("G21 G90\n{}M30\n", "G999\n".repeat(300));
    let (status, shown) = check("part.nc", &text);
    assert_eq!(status, Some(2));
    // One error of many lines is reported once.
    assert_eq!(shown.matches("error: ").count(), 1, "{shown}");
    assert!(shown.contains("the same in lines 3, 4, 5,") && shown.contains("and 250 more errors"), "{shown}");
    let words: String = (0..100).map(|k| format!("G9{k:02}\n")).collect();
    let (status, shown) = check("part.nc", &format!("G21 G90\n{words}M30\n"));
    assert_eq!(status, Some(2));
    assert_eq!(shown.matches("error: ").count(), 50, "{shown}");
    assert!(shown.contains("and 50 more errors"), "{shown}");
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let (status, shown) = check("part.nc", "G21 G90\nG0 X1 \u{1b}[31mQ5\nM30\n");
    assert_eq!(status, Some(2));
    assert!(!shown.contains('\u{1b}') && shown.contains("part.nc:2:"), "{shown}");
}

#[test]
fn nc_prints_no_program_with_lost_text_as_whole() {
    let shop = Shop::new("part.nc", b"G21 G0 X1. Y1.\nM30\nG0 X2.\n");
    let output = shop.call(&["nc", "part.nc"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(printed(&output).contains("line 3 of part.nc is never run"), "{}", printed(&output));
    let shop = Shop::new("part.nc", b"O1\nG21 G0 X1.\nM30\nO2\nG0 X2.\nM99\n");
    let output = shop.call(&["nc", "part.nc"]);
    assert_eq!(output.status.code(), Some(0));
    let notes = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(notes.contains("note: line 5 of part.nc is not run: nothing calls O2"), "{notes}");
    let late = Shop::new("part.nc", b"G21\nO100\nG0 X1.\nM30\n");
    assert_eq!(late.call(&["nc", "part.nc"]).status.code(), Some(2));
}

#[test]
fn a_run_refuses_a_program_that_would_be_dropped() {
    let late = "G21 G90\nT1 M6\nO100\nS1000 M3\nG0 X0 Y0 Z-500\nG1 X500 F1000\nM30\n";
    Shop::new("part.nc", late.as_bytes()).refused(1, &["part.nc:3:1", "nc-no-end", "lines 3 to 7"]);
}

#[test]
fn all_that_a_program_names_is_looked_up_before_it_moves() {
    // Named after a long way in feed.
    let way = "G1 X1. F1\nX0.\n".repeat(200);
    let text = iso(&format!("{way}G58\nG0 X0. Y0. Z50.\nT7 M6\nG54.1 P3\n#1=#501\nM98 P4000\nT9 M6\nG58\n"));
    let shop = Shop::new("part.nc", text.as_bytes());
    shop.refused(6, &["offset G58", "[work_offsets.G58]", "tool T7", "tool T9", "O4000", "#501", "part.nc:410:"]);
    let names = [
        ("part.mpf", "G17 G54 T=\"END_D20\" M6 D1\nG0 X0 Y0 Z50 S1000 M3\nG57\nT=\"NONE\"\nM6\nL77\nM30\n", 3),
        (
            "part.h",
            "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 FMAX\nTOOL CALL \"NONE\" Z\nCALL PGM OTHER\nEND PGM A MM\n",
            2,
        ),
        ("part.apt", "LOADTL/1\nRAPID\nGOTO/0,0,50\nLOADTL/99\nPREFUN/57\nFINI\n", 2),
    ];
    for (name, text, errors) in names {
        Shop::new(name, text.as_bytes()).refused(errors, &[name, "help: "]);
    }
}

#[test]
fn offsets_of_another_tool_are_refused() {
    // H2 is the length of tool 2; D2 its radius; D3 belongs to no tool.
    let text = iso("").replace("G43 H1", "G43 H2");
    Shop::new("part.nc", text.as_bytes()).refused(1, &["part.nc:8:", "offset 2 is that of tool T2", "T1", "write H1"]);
    let text = iso("").replace("G43 H1", "G43 H21");
    Shop::new("part.nc", text.as_bytes()).refused(1, &["offset 21 is not known"]);
    let text = iso("G41 D2 X10. Y10.\nX20.\nG40 X30.\n");
    Shop::new("part.nc", text.as_bytes()).refused(1, &["nc-compensation", "D2", "tool 1"]);
    let text = "G17 G54 T=\"END_D20\" M6 D1\nG0 X0 Y0 Z50 S1000 M3\nD2 Z40\nM30\n";
    Shop::new("part.mpf", text.as_bytes()).refused(1, &["part.mpf:3:", "D2", "one edge"]);
}

#[test]
fn lost_text_fails_the_program_and_leaves_the_other_gates_unchecked() {
    let verdict = Shop::new("part.nc", iso("").replace("M30\n", "M30\nG0 Z-60.\nG1 X50. F500\n").as_bytes()).verdict();
    let (state, reason) = gate(&verdict, "program");
    assert_eq!((state.as_str(), verdict["verdict"].as_str()), ("fail", Some("fail")), "{reason}");
    let lost = findings(&verdict, "program-text-lost");
    assert_eq!(lost.len(), 1);
    assert_eq!(lost[0]["line"], 11);
    assert!(lost[0]["message"].as_str().expect("a text").contains("lines 11 to 12"));
    for name in ["limits", "process", "collision", "near_miss", "gouge", "excess"] {
        let (state, reason) = gate(&verdict, name);
        assert!(state == "unchecked" && reason.contains("lines 11 to 12"), "{name}: {state} {reason}");
    }
}

#[test]
fn another_main_program_leaves_the_gates_unchecked() {
    let text = iso("").replace("M30\n%\n", "M30\nO2\nG21 G0 X0. Z-60.\nM30\n%\n");
    let verdict = Shop::new("part.nc", text.as_bytes()).verdict();
    for name in ["program", "limits", "collision"] {
        let (state, reason) = gate(&verdict, name);
        assert!(state == "unchecked" && reason.contains("12"), "{name}: {state} {reason}");
    }
    assert_eq!(findings(&verdict, "program-text-unproven").len(), 1);
}

#[test]
fn a_library_and_a_branch_close_no_gate() {
    let text = iso("GOTO 9\nX5.\nN9 X0.\n").replace("M30\n%\n", "M30\nO2\nX9.\nM99\n%\n");
    let verdict = Shop::new("part.nc", text.as_bytes()).verdict();
    assert_eq!(gate(&verdict, "program").0, "pass");
    assert!(!gate(&verdict, "limits").1.contains("were not run"));
    assert_eq!(findings(&verdict, "program-text-skipped").len(), 1);
    assert_eq!(findings(&verdict, "program-text-not-called").len(), 1);
}

#[test]
fn a_file_with_other_line_ends_gives_the_same_verdict() {
    let text = iso("X5.\nX0.\n");
    let mut verdicts = [text.clone(), text.replace('\n', "\r"), text.replace('\n', "\r\n") + "\u{1a}"].map(|text| {
        let mut verdict = Shop::new("part.nc", text.as_bytes()).verdict();
        // Digests of files differ.
        verdict["digests"] = Value::Null;
        verdict
    });
    let first = std::mem::take(&mut verdicts[0]);
    assert!(first["path"]["blocks"].as_u64().is_some_and(|blocks| blocks > 4));
    assert!(verdicts[1..].iter().all(|verdict| *verdict == first));
}
