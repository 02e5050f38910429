#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::path::PathBuf;

use super::*;

fn fault(text: &str) -> ControlFileError {
    *Control::from_text("shop.toml", text, None).expect_err(text)
}

#[test]
fn a_mistake_is_one_error_with_place_and_remedy() {
    let mut wrong = Vec::new();
    for (text, code, place, says, remedy) in [
        ("dialect = \"fanuc\"\nwordz = 1\n", "control-unknown-key", (2, 1), "wordz", "did you mean words?"),
        ("dialect = \"fanuc\"\narcs.tolerance = 1\n", "control-unknown-key", (2, 6), "tolerance", "tolerance_mm"),
        ("dialect = \"fanoc\"\n", "control-unknown-value", (1, 11), "fanoc", "fanuc"),
        ("dialect = fanuc\n", "control-syntax", (1, 11), "", "correct the TOML"),
        ("start.plane = \"XY\"\n", "control-no-dialect", (1, 1), "language", "inherits"),
        ("inherits = \"fanuc-30\"\n", "control-parent-missing", (1, 12), "fanuc-30", "did you mean fanuc-30i?"),
        ("inherits = \"nowhere/x.toml\"\n", "control-parent-missing", (1, 12), "cannot be read", "check the path"),
        ("inherits = \"fanuc-30i\"\ndialect = \"haas\"\n", "control-contradiction", (2, 11), "haas", "remove it"),
        (
            "dialect = \"fanuc\"\n[words]\nM25 = { does = \"M333\" }\n",
            "control-unknown-function",
            (3, 16),
            "M333",
            "supported",
        ),
        (
            "dialect = \"fanuc\"\n[words]\nM25 = { does = \"FOO\" }\n",
            "control-unknown-function",
            (3, 16),
            "FOO",
            "supported",
        ),
        (
            "dialect = \"fanuc\"\n[words]\nM25 = { does = \"M30\" }\n",
            "control-unknown-function",
            (3, 16),
            "M30",
            "supported",
        ),
        (
            "dialect = \"fanuc\"\n[words]\nM25 = { does = \"M3 M3\" }\n",
            "control-contradiction",
            (3, 16),
            "twice",
            "keep one",
        ),
        (
            "dialect = \"fanuc\"\n[words]\nM25 = { note = \"a\", ignore = \"b\" }\n",
            "control-contradiction",
            (3, 1),
            "note, ignore",
            "one of",
        ),
        ("dialect = \"fanuc\"\n[words]\nM25 = {}\n", "control-contradiction", (3, 1), "no meaning", "one of"),
        ("dialect = \"fanuc\"\n[words]\nM25 = { ignore = \" \" }\n", "control-empty-text", (3, 18), "empty", "why"),
        (
            "dialect = \"fanuc\"\n[words]\nM3.note = \"a\"\nM03.note = \"b\"\n",
            "control-contradiction",
            (3, 1),
            "same word",
            "keep one",
        ),
        ("dialect = \"fanuc\"\n[words]\nM30.note = \"a\"\n", "control-word", (3, 1), "keeps its meaning", "remove it"),
        ("dialect = \"fanuc\"\n[words]\nX10.note = \"a\"\n", "control-word", (3, 1), "X10", "M25"),
        ("dialect = \"apt\"\n[words]\nFOO.does = \"M3\"\n", "control-no-effect", (3, 12), "apt", "another meaning"),
        ("dialect = \"heidenhain\"\nstart.plane = \"XY\"\n", "control-no-effect", (2, 15), "heidenhain", "remove it"),
        (
            "dialect = \"linuxcnc\"\nnumbers.without_point = \"units\"\n",
            "control-no-effect",
            (2, 25),
            "linuxcnc",
            "remove it",
        ),
        (
            "dialect = \"fanuc\"\nnumbers = { without_point = \"units\", increment_mm = 0.01 }\n",
            "control-contradiction",
            (2, 53),
            "increment",
            "increments",
        ),
        (
            "dialect = \"fanuc\"\nnumbers.increment_mm = 0.01\n",
            "control-contradiction",
            (2, 24),
            "increment",
            "increments",
        ),
        (
            "dialect = \"fanuc\"\narcs = { tolerance_mm = 1.0, tolerance_ratio = 0.1, largest_difference_mm = 0.5 }\n",
            "control-contradiction",
            (2, 77),
            "below",
            "larger",
        ),
        ("dialect = \"fanuc\"\narcs.tolerance_ratio = 0.5\n", "control-value", (2, 24), "0 to 0.1", "0.001"),
        ("dialect = \"fanuc\"\narcs.tolerance_mm = -1\n", "control-value", (2, 21), "-1", "above zero"),
        (
            "dialect = \"fanuc\"\nfeed = { missing = \"refuse\", missing_mm_min = 5 }\n",
            "control-contradiction",
            (2, 47),
            "refused",
            "value",
        ),
        (
            "dialect = \"fanuc\"\nfeed.missing = \"value\"\n",
            "control-contradiction",
            (2, 16),
            "not stated",
            "missing_mm_min",
        ),
        (
            "dialect = \"fanuc\"\nsubprograms.missing = \"note\"\n",
            "control-contradiction",
            (2, 23),
            "no reason",
            "missing_reason",
        ),
        (
            "dialect = \"fanuc\"\nsubprograms.folders = [\"nowhere\"]\n",
            "control-value",
            (2, 23),
            "nowhere",
            "check the path",
        ),
        ("dialect = \"fanuc\"\nstart.position_mm.A = 5\n", "control-value", (2, 7), "A is not one of", "letter"),
        ("dialect = \"fanuc\"\ndwell.Z = \"s\"\n", "control-value", (2, 11), "Z is not a dwell word", "P, X"),
        ("dialect = \"fanuc\"\nprogram.header = [\"*\"]\n", "control-pattern", (2, 18), "every line", "begin"),
        (
            "dialect = \"heidenhain\"\nblocks.skipped_levels = [1]\n",
            "control-value",
            (2, 25),
            "1 is not a block skip level",
            "one level",
        ),
        (
            "dialect = \"fanuc\"\nsource = { \"start.plan\" = \"x\" }\n",
            "control-unknown-key",
            (2, 27),
            "start.plan",
            "known here",
        ),
        (
            "dialect = \"siemens-840d\"\nstart.motion = \"none\"\n",
            "control-value",
            (2, 16),
            "at every time",
            "rapid or linear",
        ),
    ] {
        let e = fault(text);
        let whole = e.to_string();
        if (e.code, (e.line, e.column)) != (code, place) || !whole.contains(says) || !e.remedy.contains(remedy) {
            wrong.push(format!("{text}{whole}; wanted {code} {place:?} {says:?} {remedy:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_circle_of_inheritance_is_reported_where_it_closes() {
    let folder = std::env::temp_dir().join(format!("proveout-controls-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("a.toml", "inherits = \"b.toml\"\n");
    write("b.toml", "# second\ninherits = \"c.toml\"\n");
    write("c.toml", "inherits = \"./b.toml\"\n");
    write("self.toml", "inherits = \"self.toml\"\n");
    let circle = Control::find("a.toml", Some(&folder)).unwrap_err();
    let own = Control::find("self.toml", Some(&folder)).unwrap_err();
    std::fs::remove_dir_all(&folder).unwrap();
    for (e, file) in [(circle, "c.toml"), (own, "self.toml")] {
        assert_eq!((e.code, e.line, e.column), ("control-inheritance-circle", 1, 12), "{e}");
        assert!(PathBuf::from(&e.file).ends_with(file), "{e}");
        assert!(e.remedy.contains("inherits"), "{e}");
    }
}

#[test]
fn a_child_says_what_differs() {
    let folder = std::env::temp_dir().join(format!("proveout-inherit-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let parent = "dialect = \"fanuc\"\nfeed = { missing = \"value\", missing_mm_min = 100 }\n\
                  numbers = { without_point = \"increments\", increment_mm = 0.01 }\n[words]\nM25.note = \"parent\"\nM26.note = \"parent\"\n";
    std::fs::write(folder.join("parent.toml"), parent).unwrap();
    let child = "inherits = \"parent.toml\"\nfeed.missing = \"refuse\"\nnumbers.increment_inch = 0.001\n[words]\nM025.note = \"child\"\n";
    let control = Control::from_text("shop/mill.toml", child, Some(&folder));
    std::fs::remove_dir_all(&folder).unwrap();
    let control = control.unwrap();
    assert_eq!(control.name(), "mill");
    assert_eq!(control.missing_feed_mm_min, None);
    assert_eq!(control.whole_numbers, WholeNumbers::Increments { mm: 0.01, inch: 0.001, deg: 0.001 });
    let meaning = |code| control.words.m(code).map(|(_, listed)| listed.meaning.clone());
    assert_eq!(meaning(25), Some(Meaning::Note("child".to_owned())));
    assert_eq!(meaning(26), Some(Meaning::Note("parent".to_owned())));
}

#[test]
fn every_control_of_the_tree_is_built_in_and_tells_its_sources() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../controls");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .filter_map(|entry| {
            entry.unwrap().file_name().to_str().and_then(|n| n.strip_suffix(".toml")).map(str::to_owned)
        })
        .collect();
    files.sort();
    assert_eq!(files, builtin_controls().collect::<Vec<_>>());
    for name in builtin_controls() {
        let control = Control::find(name, None).unwrap_or_else(|e| panic!("{e}"));
        assert!(!control.name().is_empty() && control.dialect() != crate::Dialect::Auto, "{name}");
        let text = builtin::text_of(name).unwrap();
        let file: file::ControlFile = toml::from_str(text).unwrap();
        let sourced = |path: &str| {
            let table = path.split('.').next().unwrap_or_default();
            file.source.contains_key(path) || file.source.contains_key(table)
        };
        for path in place::ControlText::new(name, text).paths() {
            let message = match path.split_once('.') {
                Some(("source", _)) => true,
                Some(("words", word)) => file.words[word].source.is_some() || sourced(&path),
                None if matches!(path.as_str(), "name" | "dialect" | "inherits") => true,
                _ => sourced(&path),
            };
            assert!(message, "{name}: {path} has no source");
        }
    }
}
