//! Every letter in every kind of block of a grbl, and every G and M word: what grbl 1.1 refuses is refused.
//!
//! The tables are written down from the comments and error codes of `gcode.c` of grbl 1.1, apart from the
//! reader.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Control, Program, Settings};

/// G words of grbl 1.1, as they are written.
const G_WORDS: &str = "0 1 2 3 4 10 17 18 19 20 21 28 28.1 30 30.1 38.2 38.3 38.4 38.5 40 43.1 49 53 54 55 56 57 58 59 61 80 90 91 \
                       91.1 92 92.1 93 94";
const M_WORDS: &str = "0 1 2 3 4 5 7 8 9 30";

/// A block that is valid, and the letters that may be added to it. F, S and T may be in any block.
const BLOCKS: [(&str, &str); 20] = [
    ("G0 X1", "YZ"),
    ("G1 X1", "YZ"),
    ("X1", "YZ"),
    ("G2 X10 Y0 R5", "Z"),
    ("G3 X10 Y0 I5", "ZJ"),
    ("G4 P1", "XYZ"),
    ("G10 L2 P1 X1", "YZ"),
    ("G10 L20 P1 X1", "YZ"),
    ("G28", "XYZ"),
    ("G28.1", "XYZ"),
    ("G92 X1", "YZ"),
    ("G92.1", "XYZ"),
    ("G43.1 Z1", ""),
    ("G49", ""),
    ("G53 G0 X1", "YZ"),
    ("G21", "XYZ"),
    ("G38.2 Z-1", "XY"),
    ("G80", ""),
    ("M3", "XYZ"),
    ("G55", "XYZ"),
];

fn refusal(block: &str) -> Option<String> {
    let settings = Settings::of_control(Control::find("grbl-1.1", None).unwrap());
    let text = format!("G21 G90 G94 G17\nG0 X0 Y0 Z0\nF100\n{block}\nM2\n");
    match Program::from_text("a.nc", text, &settings) {
        Err(faults) => Some(faults.0[0].message.clone()),
        Ok(program) => program.filter_map(Result::err).map(|fault| fault.message).next(),
    }
}

#[test]
fn each_letter_is_used_or_refused_in_each_kind_of_block() {
    let mut wrong = Vec::new();
    for (block, more) in BLOCKS {
        if let Some(message) = refusal(block) {
            wrong.push(format!("{block}: refused: {message}"));
        }
        for letter in 'A'..='Z' {
            // Further G and M words are another test, and N comes first.
            if "GMN".contains(letter) {
                continue;
            }
            let stands = block.contains(letter);
            let allowed = !stands && ("FST".contains(letter) || more.contains(letter));
            // A J that fits the arc.
            let value = if block.starts_with("G3") && letter == 'J' { 0 } else { 2 };
            let text = format!("{block} {letter}{value}");
            match (refusal(&text), allowed) {
                (None, false) => wrong.push(format!("{text}: taken")),
                (Some(message), true) => wrong.push(format!("{text}: refused: {message}")),
                _ => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn words_that_a_grbl_does_not_know_are_refused() {
    let known = |list: &str, word: &str| list.split_whitespace().any(|w| w == word);
    let mut wrong = Vec::new();
    for tenths in 0..1200 {
        let word =
            if tenths % 10 == 0 { format!("{}", tenths / 10) } else { format!("{}.{}", tenths / 10, tenths % 10) };
        if !known(G_WORDS, &word) && refusal(&format!("G{word} X1 Y1 Z1 P1")).is_none() {
            wrong.push(format!("G{word}"));
        }
        if !known(G_WORDS, &word) && refusal(&format!("G{word}")).is_none() {
            wrong.push(format!("G{word} alone"));
        }
    }
    for m in 0..200 {
        let taken = refusal(&format!("M{m}")).is_none();
        // M56 is a word of a grbl with parking, and the control file notes it.
        if taken != known(M_WORDS, &m.to_string()) && m != 56 {
            wrong.push(format!("M{m}: taken {taken}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn a_grbl_calculates_nothing_and_checks_words_together() {
    for block in [
        "#1=5",
        "G1 X[1+2]",
        "G1 X#1",
        "o100 sub",
        "O1000",
        "G92.2",
        "G10 L1 P1 Z5",
        "G10 L2 P1 R30",
        "G10 L2 P7 X0",
        "G10 L2 X0",
        "G10 L2 P1",
        "G52 X1",
        "M60",
        "M61 Q1",
        "G0 A10",
        "G2 X0 Y10 Z-10 I0 J-10 P10",
        "G2 I5",
        "G2 Z1 I5",
        "G2 X10 Y0 K5",
        "G0 G92 X1",
        "G43.1 X1",
        "G43.1 Z1 G0",
        "G80 X1",
        "G53 G2 X1 R5",
        "G4",
        "G4 P-1",
        "S-1",
        "T256",
        "M3 M4",
        "M8 M9",
        "G0 G1 X1",
        "G38.2",
        "G43 H1",
        "G41 D1",
        "G81 X1 Z-1 R1",
    ] {
        assert!(refusal(block).is_some(), "{block}");
    }
}
