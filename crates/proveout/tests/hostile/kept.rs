//! Nothing of anybody is lost: files next to those of a run, older runs, files of other names.

use std::fs;

use crate::hostile::workshop::Workshop;

#[test]
fn files_of_the_user_stay_in_a_run_folder() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3), "no design part: unchecked");
    fs::create_dir(shop.path().join("result/photos")).expect("made");
    shop.write("result/photos/part.jpg", "mine");
    shop.write("result/notes.txt", "mine");
    let output = shop.run();
    assert_eq!(output.code(), Some(3), "{}", output.text);
    assert_eq!((shop.read("result/photos/part.jpg"), shop.read("result/notes.txt")), ("mine".into(), "mine".into()));
    assert!(output.text.contains("notes.txt does not belong to a run and is kept"), "{}", output.text);
}

#[test]
fn a_folder_that_no_run_has_written_is_left_alone() {
    let shop = Workshop::new();
    fs::create_dir(shop.path().join("result")).expect("made");
    shop.write("result/verdict.json", "of something else");
    shop.write("result/thesis.tex", "work of years");
    shop.refused(&["not a run folder with manifest.json"]);
    assert_eq!(shop.read("result/verdict.json"), "of something else");
}

#[test]
fn a_run_that_was_killed_is_taken_back() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    // What a kill between the two moves leaves, and what one before them leaves.
    fs::rename(shop.path().join("result"), shop.path().join(".result.old")).expect("moved");
    fs::create_dir(shop.path().join(".result.partial-4294967294")).expect("made");
    assert_eq!(shop.run().code(), Some(3));
    assert!(shop.path().join("result/verdict.json").is_file());
    for left in [".result.old", ".result.partial-4294967294"] {
        assert!(!shop.path().join(left).exists(), "{left}");
    }
}

#[test]
fn names_choose_no_paths() {
    for (from, to) in [
        ("name = \"small\"", "name = \"../small\""),
        ("name = \"small\"", "name = \"/tmp/small\""),
        ("name = \"main\"", "name = \"../../main\""),
        ("name = \"main\"", "name = \"..\""),
        ("name = \"main\"", "name = \"a\\u001b[2Jb\""),
    ] {
        let shop = Workshop::new();
        shop.replace("scene.toml", from, to);
        let before = fs::read_dir(shop.path()).expect("there").count();
        shop.refused(&["scene.toml", "the name"]);
        assert_eq!(fs::read_dir(shop.path()).expect("there").count(), before, "{to}");
    }
}

#[test]
fn nothing_is_written_over_without_force() {
    let shop = Workshop::new();
    shop.write("poses.csv", "mine");
    shop.write("joints.csv", "X_mm,Y_mm,Z_mm,B_deg,C_deg\n0,0,0,0,0\n");
    let call = |more: &[&str]| {
        let mut all = vec!["kinematics", "machine", "--forward", "--input", "joints.csv", "--output", "poses.csv"];
        all.extend(more);
        shop.call(&all)
    };
    let output = call(&[]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
    assert!(output.text.contains("poses.csv already exists") && output.text.contains("--force"), "{}", output.text);
    assert_eq!(shop.read("poses.csv"), "mine");
    let output = call(&["--force"]);
    assert_eq!(output.code(), Some(0), "{}", output.text);
    assert!(shop.read("poses.csv").contains("x_mm"));
    let left: Vec<_> = fs::read_dir(shop.path()).expect("there").flatten().map(|e| e.file_name()).collect();
    assert!(!left.iter().any(|n| n.to_string_lossy().contains("part-")), "{left:?}");
}

#[test]
fn a_measured_section_goes_over_nothing() {
    let shop = Workshop::new();
    assert_eq!(shop.run().code(), Some(3));
    shop.write("section.json", "mine");
    let output = shop.call(&["measure", "result", "--section", "z=-1", "--output", "section.json"]);
    assert_eq!(output.code(), Some(2), "{}", output.text);
    assert_eq!(shop.read("section.json"), "mine");
    let output = shop.call(&["measure", "result", "--section", "z=-1", "--output", "section.json", "--force"]);
    assert_eq!(output.code(), Some(0), "{}", output.text);
    assert!(shop.read("section.json").starts_with('{'));
}
