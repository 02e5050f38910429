//! `proveout measure` on files of texture: profiles and height maps, what is named with the values, and
//! what it refuses.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

fn proveout(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", printed(output)))
}

/// Ridges of parabolas, 1 um high every `pitch` mm, as a softgauge.
fn gauge(pitch: f64, step: f64, points: usize) -> Vec<u8> {
    let mut text = format!(
        "ISO 5436 - 2000\0gauge\r\nPRF\x000\0ridges\r\nCX\0I\0{points}\0mm\x001\0D\0{step}\r\nCZ\0A\0{points}\0um\x001\0D\r\n\x03\r\n\x03\r\n"
    );
    for i in 0..points {
        let u = i as f64 * step / pitch;
        text += &format!("{}\r\n", 4.0 * (u - u.round()).powi(2));
    }
    text += "\x03\r\n";
    let sum: u64 = text.bytes().map(u64::from).sum();
    (text + &format!("{}\r\n\x03\x1a", sum % 65_535)).into_bytes()
}

/// The same ridges along y as a height map of 401 x 401 points every 5 um.
fn patch(pitch: f64) -> Vec<u8> {
    let mut text = String::from(
        "aISO-1.0\nNumPoints = 401\nNumProfiles = 401\nXscale = 5e-6\nYscale = 5e-6\nZscale = 1e-6\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n",
    );
    for _ in 0..401 {
        for i in 0..401 {
            let u = f64::from(i) * 0.005 / pitch;
            text += &format!("{} ", 4.0 * (u - u.round()).powi(2));
        }
        text += "\n";
    }
    (text + "*\n*\n").into_bytes()
}

fn shop() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("written");
    write("fine.smd", &gauge(0.1, 0.0005, 11_201));
    write("wide.smd", &gauge(1.0, 0.0005, 11_201));
    write("coarse.smd", &gauge(0.1, 0.005, 1_121));
    write("long.smd", &gauge(1.0, 0.0015, 11_668));
    write("patch.sdf", &patch(0.2));
    folder
}

#[test]
fn a_profile_is_evaluated_and_everything_is_named() {
    let shop = shop();
    let output = proveout(shop.path(), &["measure", "--profile", "fine.smd", "--to-lay-deg", "90"]);
    let text = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    for words in [
        "fine.smd: SMD (ISO 5436-2)",
        "ISO 21920-2:2021; class Sc3 of ISO 21920-3:2021, table 1",
        "lambda_s 2.5 µm, lambda_c 0.8 mm, evaluation length 4 mm in 5 sections; ISO 16610-21:2011",
        "form: least-squares line removed; ends: one cut-off of data beyond each end",
        "points every 0.5000 µm over 5.6000 mm; direction to the lay: across the lay (90.0 degrees); pitch 0.1000 mm",
        "filtered   unfiltered",
    ] {
        assert!(text.contains(words), "{words}:\n{text}");
    }
    let output = proveout(shop.path(), &["measure", "--profile", "fine.smd", "--standard", "iso4287", "--json"]);
    let answer = json(&output);
    let p = &answer["profiles"][0];
    assert_eq!((&p["standard"], &p["direction_to_lay"]), (&"ISO 4287:1997+A1:2009".into(), &"not known".into()));
    // Ridges of 1 um: 4 / (9 sqrt 3) um unfiltered; the cut-off of eight pitches takes next to nothing.
    for key in ["filtered", "unfiltered"] {
        let ra = p[key]["ra_um"].as_f64().expect("Ra");
        assert!((ra - 0.2566).abs() < 2e-3, "{key}: {ra}");
    }
}

#[test]
fn marks_beyond_the_cutoff_take_the_next_class_or_stay_unchecked() {
    let shop = shop();
    let output = proveout(shop.path(), &["measure", "--profile", "wide.smd"]);
    let text = printed(&output);
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(text.contains("unchecked [pitch-beyond-cutoff]: a pitch of "), "{text}");
    assert!(text.contains("unchecked [spacing-too-coarse]") || text.contains("unchecked [too-short]"), "{text}");
    assert!(text.contains("  Ra      unchecked"), "{text}");
    // 17.5 mm every 1.5 um carry Sc4, but not Sc3.
    let output = proveout(shop.path(), &["measure", "--profile", "long.smd", "--class", "Sc4", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert_eq!(json(&output)["profiles"][0]["lambda_c_mm"], 2.5);
    let output = proveout(shop.path(), &["measure", "--profile", "coarse.smd", "--json"]);
    assert_eq!(output.status.code(), Some(3), "{}", printed(&output));
    let p = &json(&output)["profiles"][0];
    assert_eq!((&p["unchecked"][0]["rule"], &p["filtered"]), (&"spacing-too-coarse".into(), &Value::Null));
    assert!(p["unfiltered"]["ra_um"].as_f64().expect("Ra") > 0.2);
}

#[test]
fn a_map_is_evaluated_drawn_and_written_for_other_programs() {
    let shop = shop();
    let output = proveout(shop.path(), &["measure", "patch.sdf", "--json", "--output", "patch.x3p"]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let area = &json(&output)["area"];
    assert_eq!((&area["standard"], &area["l_filter_mm"]), (&"ISO 25178-2:2021".into(), &0.8.into()));
    assert!((area["lay_deg"].as_f64().expect("a lay") - 90.0).abs() < 1.1, "{area}");
    let again = proveout(shop.path(), &["measure", "patch.x3p", "--json", "--output", "again.sdf"]);
    let close = |a: &Value, b: &Value| (a.as_f64().expect("Sa") / b.as_f64().expect("Sa") - 1.0).abs() < 1e-12;
    assert!(close(&json(&again)["area"]["filtered"]["sa_um"], &area["filtered"]["sa_um"]), "{}", printed(&again));
    assert!(fs::read(shop.path().join("again.sdf")).expect("written").starts_with(b"bISO-1.0"));
    let drawn = proveout(shop.path(), &["measure", "patch.sdf", "--output", "patch.png"]);
    assert!(printed(&drawn).contains("written: patch.png"), "{}", printed(&drawn));
    assert!(fs::read(shop.path().join("patch.png")).expect("written").starts_with(b"\x89PNG"));
}

#[test]
fn nonsense_is_refused_with_place_value_and_remedy() {
    let shop = shop();
    let good = gauge(0.1, 0.0005, 2001);
    let changed = |from: &str, to: &str| {
        let text: String = good.iter().map(|b| char::from(*b)).collect();
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1).into_bytes()
    };
    let cases: [(&str, Vec<u8>, &str); 8] = [
        ("empty.smd", Vec::new(), "no file of texture: 0 bytes"),
        ("noise.smd", (0..200_u8).collect(), "ends of record (ETX); 3 are expected"),
        ("word.smd", changed("\r\n0.0004\r\n", "\r\nhigh\r\n"), "is \"high\": no number"),
        ("unit.smd", changed("\0um\0", "\0furlong\0"), "unit \"furlong\" of axis CZ"),
        ("huge.smd", changed("CX\0I\x002001", "CX\0I\x00999999999"), "999999999 places and 2001 heights"),
        ("step.smd", changed("D\x000.0005", "D\x00-1"), "a step of -1 mm is not a spacing"),
        ("cut.x3p", b"PK\x03\x04\x14\0".to_vec(), "the archive has no readable directory"),
        ("cut.sdf", b"bISO-1.0xx".to_vec(), "shorter than the header"),
    ];
    for (name, bytes, words) in cases {
        fs::write(shop.path().join(name), bytes).expect("written");
        let output = proveout(shop.path(), &["measure", "--profile", name]);
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{name}: {text}");
        for word in [words, name, "help: "] {
            assert!(text.contains(word), "{name}, {word}: {text}");
        }
    }
    for (arguments, words) in [
        (vec!["measure", "--profile", "patch.sdf"], "a map of 401 x 401 points, not a profile"),
        (vec!["measure", "patch.sdf", "--wall", "0,0,0,1,0,0"], "--wall applies to a stock"),
        (vec!["measure", "patch.sdf", "--standard", "iso4287"], "--standard selects"),
        (vec!["measure", "fine.smd", "--output", "never.png"], "only a map can be drawn"),
        (vec!["measure", "fine.smd", "--output", "never.txt"], "unknown file extension for a texture"),
        (vec!["measure", "fine.smd", "--pitch-mm=-0.1"], "must be above zero"),
        (vec!["measure", "fine.smd", "--to-lay-deg", "inf"], "is not a finite angle"),
        (vec!["measure", "fine.smd", "--profile", "fine.smd"], "cannot be used with"),
        (vec!["measure"], "required"),
    ] {
        let output = proveout(shop.path(), &arguments);
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.contains(words), "{arguments:?}: {text}");
        assert!(
            fs::read_dir(shop.path()).expect("a folder").all(|e| !e
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .contains("never"))
        );
    }
}
