//! The table of unknown words: pasted into a control file and filled in, it lets the program be read.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::sync::Arc;

use proveout_nc::{Control, Settings, UnknownWords, check_text};

fn settings(control: &str) -> Settings {
    Settings::of_control(control_of(control))
}

fn control_of(control: &str) -> Arc<Control> {
    Control::from_text("shop.toml", control, None).unwrap_or_else(|e| panic!("{e}\n{control}"))
}

/// Pastes the table after the control, looks that it refuses, fills it in, and reads the program.
fn first_five_minutes(control: &str, name: &str, program: &str, words: &[(&str, u64)]) {
    let found = UnknownWords::of_text(name, program, &settings(control)).unwrap();
    let listed: Vec<(&str, u64)> = found.words.iter().map(|w| (w.word.as_str(), w.count)).collect();
    assert_eq!(listed, words, "{found}");
    let table = found.to_string();
    let pasted = format!("{control}\n{table}");
    let refused = check_text(name, program, &settings(&pasted));
    assert!(refused.iter().any(|f| f.message.contains("is refused by the control")), "{refused:?}\n{pasted}");
    let again = UnknownWords::of_text(name, program, &settings(&pasted)).unwrap();
    assert!(again.words.is_empty(), "{again}");
    let filled = pasted.replace("refuse = \"not looked up yet\"", "note = \"without effect\"");
    assert_eq!(check_text(name, program, &settings(&filled)), [], "{filled}");
}

#[test]
fn a_table_is_pasted_and_filled_in() {
    first_five_minutes(
        "dialect = \"fanuc\"\nunlisted.m = \"refuse\"\n[words]\nM60.note = \"pallet\"",
        "part.nc",
        "%\nO1\nG21 G17 G90\nM777\nG0 X1. M25\nM60\nG1 X2. F100 M25\nG321\nG5.7\nM30\n%\n",
        &[("G5.7", 1), ("G321", 1), ("M25", 2), ("M777", 1)],
    );
    first_five_minutes(
        "dialect = \"siemens-840d\"\n",
        "part.mpf",
        "G0 X1 M25\nCYCLE999(1,2)\nFOO\nG187\nM25\nM30\n",
        &[("G187", 1), ("M25", 2), ("CYCLE999", 1), ("FOO", 1)],
    );
    first_five_minutes(
        "dialect = \"heidenhain\"\n",
        "part.h",
        "0 BEGIN PGM A MM\n1 L X+1 R0 FMAX M25\n2 M114\n3 END PGM A MM\n",
        &[("M25", 1), ("M114", 1)],
    );
    first_five_minutes(
        "dialect = \"apt\"\n",
        "part.apt",
        "PARTNO A\nFOOBAR/1,2\nRAPID\nGOTO/1,2,3\nFOOBAR/OFF\nFINI\n",
        &[("FOOBAR", 2)],
    );
}

#[test]
fn a_word_tells_its_first_place_and_what_is_done_with_it() {
    let found = UnknownWords::of_text("part.nc", "G21\nG0 X1. M25\nM25\n", &Settings::default()).unwrap();
    let word = &found.words[0];
    assert_eq!((word.first.1, word.first.2, word.count), (2, 8, 2));
    assert_eq!((word.line.as_str(), word.now), ("G0 X1. M25", "a note, without effect"));
    let text = found.to_string();
    assert!(
        text.contains("# 2 times, first in part.nc:2:8 (a note, without effect): G0 X1. M25\n[words.M25]"),
        "{text}"
    );
}

#[test]
fn lines_that_cannot_be_read_are_reported() {
    let found = UnknownWords::of_text("part.nc", "G21\nG0 X1. M25 (no end\nM30\n", &Settings::default()).unwrap();
    assert_eq!(found.unreadable.len(), 1);
    assert!(found.to_string().contains("# 1 lines cannot be read"), "{found}");
    let read = UnknownWords::of_text("part.nc", "G21 G0 X1.\nM30\n", &Settings::default()).unwrap();
    assert!(read.to_string().contains("has a meaning for every word"), "{read}");
}
