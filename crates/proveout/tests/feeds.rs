//! `feeds` as a person types it: which F words change, what the new program does on the twin, and what is
//! refused.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

/// A load so much over its limit is one over it.
const OVER: f64 = 1.02;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// The scene of the page with another program, tools and limits; empty texts are those of the page.
fn scene(folder: &Path, (name, dialect, program): (&str, &str, &str), tools: &str, limits: &str) {
    let from = root().join("tests/feeds");
    let read = |name: &str| fs::read_to_string(from.join(name)).expect("the example is there");
    let or = |text: &str, file: &str| if text.is_empty() { read(file) } else { text.to_owned() };
    let text = read("scene.toml")
        .replace("../../machines", &root().join("machines").display().to_string())
        .replace("step.nc", name)
        .replace("dialect = \"fanuc\"", &format!("dialect = \"{dialect}\""));
    let limits = or(limits, "limits.toml").replace("../../materials", &root().join("materials").display().to_string());
    for (name, text) in [
        ("scene.toml", text),
        ("tools.toml", or(tools, "tools.toml")),
        (name, or(program, "step.nc")),
        ("limits.toml", limits),
    ] {
        fs::write(folder.join(name), text).expect("written");
    }
}

fn feeds(folder: &Path, options: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(["feeds", ".", "--threads", "2"])
        .args(options)
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap_or(-1), said)
}

fn report(folder: &Path, name: &str) -> Vec<Value> {
    let text = fs::read_to_string(folder.join(name)).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    report["blocks"].as_array().expect("blocks").clone()
}

/// The blocks of a line.
fn of_line(blocks: &[Value], line: u64) -> Vec<&Value> {
    blocks.iter().filter(|b| b["line"] == line).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// A text without its F words, and the feeds of its lines.
fn without_feeds(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let code = line.split('(').next().unwrap_or_default();
        let rest = &line[code.len()..];
        let words: Vec<&str> = code.split_whitespace().filter(|w| !w.starts_with('F')).collect();
        out += &words.join(" ");
        out += rest.trim();
        out.push('\n');
    }
    out
}

/// Canonical commands without their feeds, as `proveout nc` prints them.
fn commands(folder: &Path, file: &str, dialect: &str) -> Vec<String> {
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(["nc", file, "--dialect", dialect, "--tools", "tools.toml"])
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON lines"))
        .filter(|c| c["op"] != "feed")
        .map(|mut c| {
            if let Some(c) = c.as_object_mut() {
                c.retain(|key, _| !key.contains("feed") && !matches!(key.as_str(), "file" | "column" | "length"));
            }
            c.to_string()
        })
        .collect()
}

#[test]
fn feeds_rise_to_the_limits_and_no_load_passes_one() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    scene(at, ("step.nc", "fanuc", ""), "", "");
    let options = ["--limits", "limits.toml", "--output", "new.nc", "--report", "r.json", "--engagement", "e.parquet"];
    let (code, said) = feeds(at, &options);
    assert_eq!(code, 0, "{said}");
    let (old, new) = (fs::read_to_string(at.join("step.nc")), fs::read_to_string(at.join("new.nc")));
    let (old, new) = (old.expect("old"), new.expect("new"));
    assert_ne!(old, new);
    assert_eq!(without_feeds(&old), without_feeds(&new), "{new}");
    assert_eq!(commands(at, "step.nc", "fanuc"), commands(at, "new.nc", "fanuc"));
    assert!(fs::metadata(at.join("e.parquet")).expect("a table").len() > 1000);

    let blocks = report(at, "r.json");
    for block in blocks.iter().filter(|b| !b["set_by"].as_str().is_some_and(|w| w.starts_with("kept"))) {
        assert!(block["load_over_limit"].as_f64().is_none_or(|over| over <= OVER), "{block}");
    }
    // Narrow shoulder: faster; its wide end: slower than that, since the feed is that of the whole block.
    let feed = |line: u64| number(&of_line(&blocks, line)[0]["feed_after_mm_min"]);
    assert!(feed(15) > 900.0 && feed(16) < feed(15), "{} {}", feed(15), feed(16));
    // In air as fast as the tool may, but the drilling cycle stays as it is.
    assert_eq!(feed(13), 3000.0, "{said}");
    for line in [27, 28] {
        for block in of_line(&blocks, line) {
            assert_eq!(block["feed_before_mm_min"], block["feed_after_mm_min"], "{block}");
            assert!(block["set_by"].as_str().is_some_and(|w| w.contains("cycle")), "{block}");
        }
    }
    assert!(new.contains("F250."), "{new}");

    // The same cut with cells half as large, and the new program as it is.
    let options = [
        "--nc",
        "new.nc",
        "--mode",
        "analyse",
        "--limits",
        "limits.toml",
        "--report",
        "fine.json",
        "--resolution-mm",
        "0.25",
    ];
    let (code, said) = feeds(at, &options);
    assert_eq!(code, 0, "{said}");
    let fine = report(at, "fine.json");
    assert!(fine.iter().any(|b| b["load_over_limit"].as_f64().is_some_and(|over| over > 0.8)), "{said}");
    for block in
        fine.iter().filter(|b| b["tool"] == "F10" && !b["set_by"].as_str().is_some_and(|w| w.contains("plunge")))
    {
        assert!(block["load_over_limit"].as_f64().is_none_or(|over| over <= OVER), "{block}");
    }
    // Another number of threads, the same bytes.
    let again = ["--limits", "limits.toml", "--output", "again.nc", "--report", "again.json", "--threads", "1"];
    let output = Command::new(env!("CARGO_BIN_EXE_proveout")).current_dir(at).args(["feeds", "."]).args(again).output();
    assert!(output.expect("the program starts").status.success());
    for (a, b) in [("new.nc", "again.nc"), ("r.json", "again.json")] {
        assert!(fs::read(at.join(a)).expect("a") == fs::read(at.join(b)).expect("b"), "{a} {b}");
    }
}

/// A slot along X with a given head.
fn slot(feed: &str) -> String {
    format!(
        "%\nO1\nG21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS4000 M3\nX-10. Y20.\nZ-3.\nG1 X35. {feed}\nX70.\nG0 Z60.\nM30\n%\n"
    )
}

#[test]
fn constant_engagement_at_its_limit_keeps_its_feed() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    // 0.1 mm a tooth is 1200 mm/min for three teeth at 4000/min: the slot has it from its first to its last
    // mm.
    scene(at, ("slot.nc", "fanuc", &slot("F1180.")), "", "[tool.F10]\nmax_chip_mm = 0.1\nmax_feed_mm_min = 4000\n");
    let (code, said) =
        feeds(at, &["--mode", "chip", "--limits", "limits.toml", "--output", "new.nc", "--report", "r.json"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("no feed changes") && !at.join("new.nc").exists(), "{said}");
    assert!(report(at, "r.json").iter().filter(|b| b["engaged"] == true).all(|b| b["set_by"] == "dead band"), "{said}");
    // Twice the feed passes the limit: it falls to it, though the dead band is wide.
    scene(at, ("slot.nc", "fanuc", &slot("F1250.")), "", "[tool.F10]\nmax_chip_mm = 0.1\nmax_feed_mm_min = 4000\n");
    let options = ["--mode", "chip", "--limits", "limits.toml", "--output", "new.nc", "--dead-band", "50"];
    let (code, said) = feeds(at, &options);
    assert_eq!(code, 0, "{said}");
    let new = fs::read_to_string(at.join("new.nc")).expect("written");
    assert!(new.contains("X35. F1200.") || new.contains("X35. F1199."), "{new}");
}

#[test]
fn blocks_that_the_machine_paces_keep_their_feed() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    // A zigzag of 0.4 mm in air: corners let no feed above some hundred mm/min through.
    let mut program =
        "%\nO1\nG21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS4000 M3\nX10. Y20.\nG1 Z59. F2500.\n"
            .to_owned();
    for k in 0..60 {
        program += &format!("X{:.1} Y{:.1}\n", 10.0 + 0.4 * f64::from(k), if k % 2 == 0 { 20.4 } else { 20.0 });
    }
    program += "G0 Z70.\nM30\n%\n";
    scene(at, ("zigzag.nc", "fanuc", &program), "", "[tool.F10]\nmax_feed_mm_min = 6000\n");
    let options = ["--mode", "air", "--limits", "limits.toml", "--output", "new.nc", "--report", "r.json"];
    let (code, said) = feeds(at, &options);
    assert_eq!(code, 0, "{said}");
    let blocks = report(at, "r.json");
    let inner: Vec<&Value> =
        blocks.iter().filter(|b| b["line"].as_u64().is_some_and(|l| (15..60).contains(&l))).collect();
    assert!(inner.len() > 40, "{said}");
    for block in inner {
        let word = block["set_by"].as_str().unwrap_or_default();
        assert!(word.starts_with("joint") || word == "corner" || word == "block cycle", "{block}");
        assert_eq!(block["feed_before_mm_min"], block["feed_after_mm_min"], "{block}");
    }
}

#[test]
fn feeds_change_in_other_languages_and_units() {
    let inch = "%\nO1\nG20 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z2.4\nS4000 M3\nX-0.4 Y0.8\nZ-0.1\nG1 X1.2 F20.\nX2.8\nG0 Z2.4\nM30\n%\n";
    let siemens = "G17 G54 G90 G94 G710\nT=\"F10\"\nM6\nD1\nS4000 M3\nG0 X-10 Y20 Z60\nZ-3\nG1 X35 F=500 ; slot\nX70\nG0 Z60\nM30\n";
    let klartext = "0 BEGIN PGM P MM\n1 TOOL CALL 1 Z S4000\n2 CYCL DEF 247 Q339=+1\n3 L Z+60 R0 FMAX M3\n4 L X-10 Y+20 R0 FMAX\n\
                    5 L Z-3 R0 FMAX\n6 L X+35 R0 F500 M8\n7 L X+70\n8 L Z+60 R0 FMAX M30\n9 END PGM P MM\n";
    for (name, dialect, program, has) in [
        ("inch.nc", "fanuc", inch, "X1.2 F47.2"),
        ("slot.mpf", "siemens-840d", siemens, "G1 X35 F=1200 ; slot"),
        ("slot.h", "heidenhain", klartext, "6 L X+35 R0 F1200 M8"),
    ] {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = folder.path();
        scene(at, (name, dialect, program), "", "[tool.F10]\nmax_chip_mm = 0.1\nmax_feed_mm_min = 4000\n");
        if dialect == "heidenhain" {
            let text = fs::read_to_string(at.join("scene.toml")).expect("a scene");
            fs::write(at.join("scene.toml"), text.replace("work_offsets.G54", "work_offsets.PRESET1"))
                .expect("written");
        }
        let (code, said) = feeds(at, &["--mode", "chip", "--limits", "limits.toml", "--output", "new.nc"]);
        assert_eq!(code, 0, "{name}: {said}");
        let new = fs::read_to_string(at.join("new.nc")).expect("written");
        assert!(new.contains(has), "{name}: {new}\n{said}");
    }
}

#[test]
fn a_feed_that_the_next_block_takes_over_is_written_again() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let at = folder.path();
    // The slot is slow for its limit, the way down in material stays a plunge, and the cycle takes over F.
    let program = "%\nO1\nG21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS4000 M3\nX-10. Y20.\nZ-2.\nG1 X30. F600.\nZ-3.\nX70.\nG0 Z5.\n\
                   G98 G81 X30. Y32. Z-4. R2.\nG80\nG0 Z60.\nM30\n%\n";
    scene(at, ("p.nc", "fanuc", program), "", "[tool.F10]\nmax_chip_mm = 0.1\nmax_feed_mm_min = 4000\n");
    let (code, said) =
        feeds(at, &["--mode", "chip", "--limits", "limits.toml", "--output", "new.nc", "--report", "r.json"]);
    assert_eq!(code, 0, "{said}");
    let new = fs::read_to_string(at.join("new.nc")).expect("written");
    assert!(new.contains("G1 X30. F1200.\nZ-3. F600.\nX70.\n"), "{new}\n{said}");
    let blocks = report(at, "r.json");
    assert!(of_line(&blocks, 11)[0]["set_by"].as_str().is_some_and(|w| w.contains("plunge")), "{said}");
    assert!(of_line(&blocks, 12)[0]["set_by"].as_str().is_some_and(|w| w.contains("taken over")), "{said}");
}

#[test]
fn what_cannot_be_is_refused_by_name_and_nothing_is_written() {
    let plain = "[tool.F10]\nmax_chip_mm = 0.1\nmax_feed_mm_min = 4000\n";
    let forces = "[tool.F10]\nmax_force_n = 100\n";
    let stiff = "material = \"m.toml\"\n[tool.F10]\nmax_force_n = 100\n";
    let toothless =
        fs::read_to_string(root().join("tests/feeds/tools.toml")).expect("tools").replace("flutes = 3\n", "");
    let computed = slot("F#101").replace("S4000 M3\n", "S4000 M3\n#101=500\n");
    let fixed = slot("F500.").replace("S4000 M3\n", "S4000 M3\nM49\n");
    for (program, tools, limits, words) in [
        (computed.as_str(), "", plain, &["p.nc:11", "#101", "computed"][..]),
        (fixed.as_str(), "", plain, &["p.nc:8", "override"]),
        (&slot("F500."), toothless.as_str(), plain, &["limits.toml", "no teeth", "flutes"]),
        (&slot("F500."), "", forces, &["limits.toml", "no material", "material ="]),
        (&slot("F500."), "", stiff, &["p.nc:10", "no feed", "force"]),
        (&slot("F500."), "", "[tool.F11]\nmax_chip_mm = 0.1\n", &["limits.toml:1", "F11", "F10"]),
        (&slot("F500."), "", "[tool.F10]\nmax_chip = 0.1\n", &["limits.toml:2", "max_chip_mm"]),
    ] {
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = folder.path();
        scene(at, ("p.nc", "fanuc", program), tools, limits);
        let steel = "name = \"m\"\nsource = \"test\"\nconvention = \"chip-thickness\"\nkc11_n_mm2 = 1500\nexponent = 0.2\nedge_force_n_mm = 90\n\
                     radial_ratio = 0.3\naxial_ratio = 0\nuncertainty_percent = 10\n";
        fs::write(at.join("m.toml"), steel).expect("written");
        let (code, said) = feeds(at, &["--limits", "limits.toml", "--output", "new.nc", "--report", "r.json"]);
        assert_eq!(code, 2, "{said}");
        assert!(words.iter().all(|w| said.contains(w)), "{words:?}: {said}");
        assert!(!at.join("new.nc").exists() && !at.join("r.json").exists(), "{said}");
    }
}
