//! `proveout nc` with cutter compensation in every language: a cusp of two arcs is gouge-free, a neck that is
//! too narrow is refused or reported.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use serde_json::Value;

/// A tool of 2 mm radius.
const TOOLS: &str = "description = \"one end mill\"\n\n[[tool]]\nnumber = 1\nname = \"END_D4\"\nkind = \"flat\"\n\
                     diameter_mm = 4.0\nflute_length_mm = 20.0\nshank_diameter_mm = 4.0\ngauge_length_mm = 80.0\nsource = \"none: a test\"\n";

/// Names, blocks of the head up to the move onto the contour, between them a place for its point.
struct Language {
    dialect: &'static str,
    head: &'static str,
    /// Onto the contour: `X` and `Y` are replaced.
    entry: &'static str,
    line: &'static str,
    /// Arc about `I`, `J` (absolute) or `i`, `j` (from its start), counter-clockwise and clockwise.
    arcs: [&'static str; 2],
    exit: &'static str,
}

const ISO_ARCS: [&str; 2] = ["G3 X<X> Y<Y> I<i> J<j>", "G2 X<X> Y<Y> I<i> J<j>"];

const LANGUAGES: [Language; 8] = [
    Language {
        dialect: "siemens-840d",
        head: "G710 G90 G17 G40 G94 F100\nT1 D1 M6\nG0 X<X> Y<Y> Z0",
        entry: "G41 G1 X<X> Y<Y>",
        line: "G1 X<X> Y<Y>",
        arcs: ISO_ARCS,
        exit: "G40 G1 X<X> Y<Y>\nM30",
    },
    Language {
        dialect: "fanuc",
        head: "G21 G90 G17 G40 G94 F100\nT1 M6\nG0 X<X> Y<Y> Z0",
        entry: "G41 D1 G1 X<X> Y<Y>",
        line: "G1 X<X> Y<Y>",
        arcs: ISO_ARCS,
        exit: "G40 G1 X<X> Y<Y>\nM30",
    },
    Language {
        dialect: "haas",
        head: "G21 G90 G17 G40 G94 F100\nT1 M6\nG0 X<X> Y<Y> Z0",
        entry: "G41 D1 G1 X<X> Y<Y>",
        line: "G1 X<X> Y<Y>",
        arcs: ISO_ARCS,
        exit: "G40 G1 X<X> Y<Y>\nM30",
    },
    Language {
        dialect: "iso",
        head: "G21 G90 G17 G40 G94 F100\nT1 M6\nG0 X<X> Y<Y> Z0",
        entry: "G41 D1 G1 X<X> Y<Y>",
        line: "G1 X<X> Y<Y>",
        arcs: ISO_ARCS,
        exit: "G40 G1 X<X> Y<Y>\nM30",
    },
    Language {
        dialect: "linuxcnc",
        head: "G21 G90 G17 G40 G94 F100\nG0 X<X> Y<Y> Z0",
        entry: "G41.1 D4 G1 X<X> Y<Y>",
        line: "G1 X<X> Y<Y>",
        arcs: ISO_ARCS,
        exit: "G40 G1 X<X> Y<Y>\nM2",
    },
    Language {
        dialect: "heidenhain",
        head: "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X<X> Y<Y> Z+0 R0 FMAX",
        entry: "L X<X> Y<Y> RL F100",
        line: "L X<X> Y<Y>",
        arcs: ["CC X<I> Y<J>\nC X<X> Y<Y> DR+", "CC X<I> Y<J>\nC X<X> Y<Y> DR-"],
        exit: "L X<X> Y<Y> R0\nEND PGM A MM",
    },
    Language {
        dialect: "heidenhain-iso",
        head: "%A G71 *\nN10 T1 G17 S1000 *\nN20 G00 G40 G90 X<X> Y<Y> Z+0 *",
        entry: "N30 G01 G41 X<X> Y<Y> F100 *",
        line: "N40 G01 X<X> Y<Y> *",
        arcs: ["N50 I<I> J<J> *\nN60 G03 X<X> Y<Y> *", "N50 I<I> J<J> *\nN60 G02 X<X> Y<Y> *"],
        exit: "N70 G01 G40 X<X> Y<Y> *\nN99999999 %A G71 *",
    },
    Language {
        dialect: "apt",
        head: "PARTNO A\nUNITS/MM\nLOADTL/1\nFEDRAT/100,MMPM\nGOTO/<X>,<Y>,0",
        entry: "CUTCOM/LEFT\nGOTO/<X>,<Y>,0",
        line: "GOTO/<X>,<Y>,0",
        arcs: ["CIRCLE/<I>,<J>,0,0,0,1,<r>\nGOTO/<X>,<Y>,0", "CIRCLE/<I>,<J>,0,0,0,-1,<r>\nGOTO/<X>,<Y>,0"],
        exit: "CUTCOM/OFF\nGOTO/<X>,<Y>,0\nFINI",
    },
];

#[derive(Clone, Copy)]
enum Block {
    Line([f64; 2]),
    Arc([f64; 2], [f64; 2], bool),
}

/// A contour in a language: from a point, onto the start, along the blocks, off to the last point.
fn text(language: &Language, from: [f64; 2], start: [f64; 2], blocks: &[Block], to: [f64; 2]) -> String {
    let signed = language.dialect.starts_with("heidenhain");
    let number = |v: f64| if signed { format!("{v:+.6}") } else { format!("{v:.6}") };
    let put = |form: &str, p: [f64; 2]| form.replace("<X>", &number(p[0])).replace("<Y>", &number(p[1]));
    let mut text = put(language.head, from) + "\n" + &put(language.entry, start) + "\n";
    let mut at = start;
    for block in blocks {
        match *block {
            Block::Line(end) => {
                text += &put(language.line, end);
                at = end;
            }
            Block::Arc(end, center, clockwise) => {
                let way = [center[0] - at[0], center[1] - at[1]];
                let form = language.arcs[usize::from(clockwise)];
                let form = form.replace("<I>", &number(center[0])).replace("<J>", &number(center[1]));
                let form = form.replace("<i>", &number(way[0])).replace("<j>", &number(way[1]));
                text += &put(&form.replace("<r>", &number(way[0].hypot(way[1]))), end);
                at = end;
            }
        }
        text += "\n";
    }
    text + &put(language.exit, to) + "\n"
}

fn nc(folder: &Path, dialect: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(["nc", "program.txt", "--dialect", dialect, "--tools", "tools.toml"])
        .output()
        .expect("the program starts")
}

fn lines(output: &Output) -> Vec<Value> {
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().map(|line| serde_json::from_str(line).expect("one object a line")).collect()
}

/// Cuts that do not belong to the moves onto the contour and off it.
fn overcuts_of(lines: &[Value]) -> Vec<&Value> {
    let inner = |v: &&Value| v.get("overcut").is_some_and(|kind| kind != "entry" && kind != "exit");
    lines.iter().filter(inner).collect()
}

#[test]
fn a_cusp_of_two_arcs_is_gouge_free_in_every_language() {
    let folder = tempfile::tempdir().expect("temporary folder");
    fs::write(folder.path().join("tools.toml"), TOOLS).expect("written");
    // Two half circles of 5 mm over the X axis, with the tool above them. The equidistants have 7 mm and meet
    // over the cusp in the origin at sqrt(7^2 - 5^2).
    let blocks = [
        Block::Arc([0.0, 0.0], [-5.0, 0.0], true),
        Block::Arc([10.0, 0.0], [5.0, 0.0], true),
        Block::Line([10.0, -20.0]),
    ];
    let peak = [0.0, 24f64.sqrt()];
    for language in &LANGUAGES {
        for from in [[-10.0, 20.0], [-20.0, -20.0]] {
            let program = text(language, from, [-10.0, 0.0], &blocks, [20.0, -30.0]);
            fs::write(folder.path().join("program.txt"), &program).expect("written");
            let output = nc(folder.path(), language.dialect);
            let (lines, error) = (lines(&output), String::from_utf8_lossy(&output.stderr).into_owned());
            if output.status.code() == Some(2) {
                // The entry of a LinuxCNC is a block of the contour: from above it meets the first arc in a
                // corner of 180 degrees.
                let linuxcnc = language.dialect == "linuxcnc" && from[1] > 0.0;
                assert!(linuxcnc && error.contains("nc-compensation"), "{}: {error}\n{program}", language.dialect);
                continue;
            }
            assert_eq!(output.status.code(), Some(0), "{}: {error}", language.dialect);
            let ends = |v: &Value| Some([v["end_base"]["X"].as_f64()?, v["end_base"]["Y"].as_f64()?]);
            let meets = lines.iter().filter_map(ends).any(|p| (p[0] - peak[0]).hypot(p[1] - peak[1]) < 1e-6);
            assert!(meets, "{}: {lines:#?}", language.dialect);
            assert!(overcuts_of(&lines).is_empty(), "{}: {lines:#?}", language.dialect);
        }
    }
}

#[test]
fn a_neck_narrower_than_the_tool_is_refused_or_reported_in_every_language() {
    let folder = tempfile::tempdir().expect("temporary folder");
    fs::write(folder.path().join("tools.toml"), TOOLS).expect("written");
    // A slot of 3 mm that opens into a circle of 5 mm, in as many arcs as asked for.
    let y = (25.0f64 - 2.25).sqrt();
    let (first, sweep) = (y.atan2(-1.5), std::f64::consts::TAU - 2.0 * 1.5f64.atan2(y));
    for language in &LANGUAGES {
        for arcs in [1, 6] {
            let mut blocks = vec![Block::Line([-1.5, y])];
            for k in 1..=arcs {
                let angle = first + sweep * f64::from(k) / f64::from(arcs);
                blocks.push(Block::Arc([5.0 * angle.cos(), 5.0 * angle.sin()], [0.0, 0.0], false));
            }
            blocks.push(Block::Line([1.5, 30.0]));
            let program = text(language, [0.5, 40.0], [-1.5, 30.0], &blocks, [-0.5, 40.0]);
            fs::write(folder.path().join("program.txt"), &program).expect("written");
            let output = nc(folder.path(), language.dialect);
            let error = String::from_utf8_lossy(&output.stderr).into_owned();
            if arcs == 1 {
                assert_eq!(output.status.code(), Some(2), "{}", language.dialect);
                for word in ["nc-compensation", "the tool of radius 2 mm does not fit", "program.txt:", "smaller tool"]
                {
                    assert!(error.contains(word), "{}: {word:?} is not in {error}", language.dialect);
                }
            } else {
                assert_eq!(output.status.code(), Some(0), "{}: {error}", language.dialect);
                let lines = lines(&output);
                let overcuts = overcuts_of(&lines);
                let narrow = overcuts.iter().find(|v| v["overcut"] == "narrow").expect("given");
                assert!(narrow["severity"] == "error" && narrow["op"] == "note", "{narrow}");
                assert!((narrow["depth_mm"].as_f64().expect("a number") - 1.0).abs() < 1e-5, "{narrow}");
                assert!(narrow["text"].as_str().expect("a text").contains("does not fit between"), "{narrow}");
            }
        }
    }
}
