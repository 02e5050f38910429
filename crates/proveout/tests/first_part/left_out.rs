//! What the gates of the shape leave out and report: threads round core holes, and sheets of material that
//! are thinner than their faces are known.

use std::{f64::consts::TAU, fs};

use serde_json::Value;

use super::desk::{Desk, gate};

const MILL: &str = "--machine three-axis-mill --answers answers.toml";

/// Triangles as STL text.
fn stl(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = String::from("solid part\n");
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid part\n"
}

/// A block of 40 x 40 x 20 mm with its top at zero and drilled holes of this diameter at these places along
/// X: straight down to `straight`, then a point down to `deep`.
fn drilled(diameter: f64, at: f64, [straight, deep]: [f64; 2]) -> String {
    const N: usize = 96;
    let ring = |r: f64, z: f64, k: usize| {
        let a = TAU * (k % N) as f64 / N as f64;
        [at + r * a.cos(), r * a.sin(), z]
    };
    // The border of the top as seen from the hole, corners included.
    let border = |k: usize| {
        let a = TAU * (k % N) as f64 / N as f64;
        let (c, s) = (a.cos(), a.sin());
        let way = 20.0 / c.abs().max(s.abs());
        [way * c, way * s, 0.0]
    };
    let low = |p: [f64; 3]| [p[0], p[1], -20.0];
    let mut all = Vec::new();
    for k in 0..N {
        let (r, next) = (0.5 * diameter, k + 1);
        let (a, b) = (ring(r, 0.0, k), ring(r, 0.0, next));
        let (c, d) = (ring(r, straight, k), ring(r, straight, next));
        let (p, q) = (border(k), border(next));
        all.extend([[a, p, q], [a, q, b]]); // the top
        all.extend([[a, b, d], [a, d, c]]); // the wall of the hole
        all.push([c, d, [at, 0.0, deep]]); // its point
        all.extend([[p, low(p), low(q)], [p, low(q), q]]); // the sides
        all.push([low(p), [0.0, 0.0, -20.0], low(q)]); // the bottom
    }
    stl(&all)
}

/// Drills 6.8 mm to a depth of 16 mm and taps M8 at X`x`, to Z`z`.
fn tapped(comment: &str, x: &str, z: &str) -> String {
    format!(
        "O1\nG21 G90 G17 G40 G80\n(T1 6.8MM DRILL)\n(T2 {comment})\nT1 M6\nG54 G0 X0. Y0. S1200 M3\nG43 H1 Z20.\nG81 G98 Z-16. R3. F150.\nG80\nG0 Z20.\n\
         T2 M6\nG0 X{x} Y0. S500 M3\nG43 H2 Z20.\nG84 G98 Z{z} R5. F625.\nG80\nG0 Z20.\nM30\n"
    )
}

fn findings<'a>(verdict: &'a Value, code: &str) -> Vec<&'a Value> {
    verdict["findings"].as_array().expect("findings").iter().filter(|f| f["code"] == code).collect()
}

#[test]
#[ignore = "nightly, 53 s"]
fn a_thread_in_its_core_hole_is_reported_and_is_no_gouge() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-20,-20,-20,20,20,0\"\n");
    let point = 3.4 / 59_f64.to_radians().tan();
    desk.write("plate.stl", &drilled(6.8, 0.0, [-16.0 + point, -16.0]));
    let run = |name: &str, comment: &str, x: &str, z: &str| {
        desk.write(&format!("{name}.nc"), &tapped(comment, x, z));
        desk.done(&format!("new {name}.nc {MILL} --design plate.stl --output {name}"));
        desk.verdict(name)
    };
    let good = run("good", "M8 TAP", "0.", "-10.");
    let tools = fs::read_to_string(desk.path("good/tools.toml")).expect("written");
    assert!(
        tools.contains("kind = \"tap\"") && tools.contains("pitch_mm = 1.25") && tools.contains("ISO 261"),
        "{tools}"
    );
    let (state, reason) = gate(&good, "gouge");
    assert_eq!(state, "pass", "{reason}");
    assert!(reason.contains("not counted: a thread in a core hole of the design"), "{reason}");
    assert_eq!(
        gate(&good, "process").0,
        "pass",
        "a tap has no edges at its center, and needs none: {:?}",
        gate(&good, "process")
    );
    let matches = findings(&good, "geometry-thread");
    assert_eq!((matches.len(), matches[0]["severity"].as_str()), (1, Some("info")), "{matches:?}");
    assert!(matches[0]["line"].is_u64() && matches[0]["point_mm"].is_array(), "{matches:?}");
    // A ring of 3.4 to 4 mm, 10 mm deep.
    let ring = 0.5 * TAU * (4.0 * 4.0 - 3.4 * 3.4) * 10.0;
    let volume = good["deviation"]["thread_volume_mm3"].as_f64().expect("given");
    assert!((volume / ring - 1.0).abs() < 0.1, "{volume} {ring}");
    let deep = good["deviation"]["gouge_max_mm"].as_f64().expect("measured");
    assert!(deep < 0.06, "the thread is no depth of a gouge: {deep}");
    // Next to its hole, and deeper than it: what is not the ring is a gouge.
    for (name, x, z) in [("beside", "0.6", "-10."), ("deep", "0.", "-15.5")] {
        let verdict = run(name, "M8 TAP", x, z);
        assert_eq!(gate(&verdict, "gouge").0, "fail", "{name}: {:?}", gate(&verdict, "gouge"));
    }
    // Larger than the thread that the hole is for: the ring of M10 begins at 8.376 mm.
    assert_eq!(gate(&run("large", "M10 TAP", "0.", "-10."), "gouge").0, "fail");
    // Without a pitch it is a cylinder, as the finding says.
    let round = run("round", "TAP 8MM", "0.", "-10.");
    assert_eq!(gate(&round, "gouge").0, "fail");
    assert!(round["findings"].to_string().contains("is modeled here as a cylinder"), "{}", round["findings"]);
    // Where the design has the outer diameter there is nothing to report.
    desk.write("plate.stl", &drilled(8.0, 0.0, [-10.0, -16.0]));
    let outer = run("outer", "M8 TAP", "0.", "-10.");
    assert_eq!((outer["deviation"]["threads"].as_u64(), findings(&outer, "geometry-thread").len()), (Some(0), 0));
}

/// The same holes tapped with another way in a revolution than the pitch of M8, 1.25 mm: coupled to the
/// spindle as `G84` is, in a feed by time, and in one by the revolution.
#[test]
#[ignore = "nightly, 36 s"]
fn a_tap_that_is_led_by_another_pitch_than_its_own_is_an_error() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-20,-20,-20,20,20,0\"\n");
    let cycle = "G84 G98 Z-10. R5. F625.\nG80\n";
    let cases = [
        (cycle.to_owned(), None),
        // Rounded to whole millimeters a minute.
        (cycle.replace("F625.", "F630."), None),
        (cycle.replace("F625.", "F750."), Some((1.5, 1))),
        (cycle.replace("F625.", "F500."), Some((1.0, 1))),
        (cycle.replace("G84", "S600 G84"), Some((625.0 / 600.0, 1))),
        ("G0 Z5.\nG1 Z-10. F590.\nM4\nG1 Z5.\n".to_owned(), None),
        ("G0 Z5.\nG1 Z-10. F450.\nM4\nG1 Z5.\n".to_owned(), Some((0.9, 10))),
        ("G0 Z5.\nG95 G1 Z-10. F1.25\nG94 M4\nG1 Z5. F625.\n".to_owned(), None),
        ("G0 Z5.\nG95 G1 Z-10. F1.\nG94 M4\nG1 Z5. F625.\n".to_owned(), Some((1.0, 10))),
    ];
    for (k, (words, wrong)) in cases.into_iter().enumerate() {
        let (name, program) = (format!("case{k}"), tapped("M8 TAP", "0.", "-10.").replace(cycle, &words));
        assert!(program.contains(&words));
        desk.write(&format!("{name}.nc"), &program);
        desk.done(&format!("new {name}.nc {MILL} --output {name}"));
        let verdict = desk.verdict(&name);
        let matches = findings(&verdict, "process-tap-pitch");
        let Some((way, percent)) = wrong else {
            assert!(matches.is_empty(), "{words}: {matches:?}");
            assert_eq!(gate(&verdict, "process").0, "pass", "{words}: {:?}", gate(&verdict, "process"));
            continue;
        };
        assert_eq!(matches.len(), 1, "{words}: {:?}", verdict["findings"]);
        assert_eq!(gate(&verdict, "process").0, "fail", "{words}");
        let value = matches[0]["value"].as_f64().expect("the way");
        assert!((value - way).abs() < 1e-9 && matches[0]["limit"] == 1.25, "{words}: {matches:?}");
        let message = matches[0]["message"].as_str().expect("words");
        assert!(message.contains(&format!("percent off, {percent} percent allowed")), "{message}");
        let line = program.lines().position(|l| l.contains("Z-10.")).expect("the stroke") as u64 + 1;
        assert_eq!(matches[0]["line"], line, "{words}: {matches:?}");
    }
}

/// Two passes of 10 mm that meet edge to edge at y = 10, the second one moved aside by `gap` mm.
fn side_by_side(gap: f64) -> String {
    format!(
        "O1\nG21 G90 G17 G40\n(T1 10MM FLAT ENDMILL CENTER CUTTING)\nT1 M6\nG54 G0 X-10. Y5. S3000 M3\nG43 H1 Z20.\nZ2.\nG1 Z-1. F500.\nX50.\nG0 Z2.\n\
         X-10. Y{:.6}\nG1 Z-1.\nX50.\nG0 Z20.\nM30\n",
        15.0 + gap
    )
}

#[test]
fn a_sheet_thinner_than_its_faces_are_known_is_reported_and_fails_nothing() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-10,40,20,0\"\n");
    desk.write("lower.stl", &super::block([0.0, 0.0, -10.0], [40.0, 20.0, -1.0]));
    let run = |name: &str, gap: f64| {
        desk.write(&format!("{name}.nc"), &side_by_side(gap));
        desk.done(&format!("new {name}.nc {MILL} --design lower.stl --output {name}"));
        desk.verdict(name)
    };
    let film = run("film", 2e-5);
    let (state, reason) = gate(&film, "excess");
    assert_eq!(state, "pass", "{reason}");
    assert!(reason.contains("not counted: a sheet of material at most 0.001"), "{reason}");
    let d = &film["deviation"];
    assert_eq!(d["films"].as_u64(), Some(1), "{d}");
    assert!((d["film_max_mm"].as_f64().expect("given") - 1.0).abs() < 0.5, "{d}");
    let volume = d["film_volume_mm3"].as_f64().expect("given");
    assert!((volume / (2e-5 * 40.0) - 1.0).abs() < 0.4, "{volume}");
    assert!(d["excess_max_mm"].as_f64().is_some_and(|e| e < 0.06), "{d}");
    let matches = findings(&film, "geometry-film");
    assert_eq!((matches.len(), matches[0]["severity"].as_str()), (1, Some("info")));
    assert!(matches[0]["line"].is_u64(), "{matches:?}");
    // A fin that is there.
    let fin = run("fin", 0.01);
    assert_eq!(gate(&fin, "excess").0, "fail", "{:?}", gate(&fin, "excess"));
    assert!(findings(&fin, "geometry-film").is_empty());
    assert!(fin["deviation"]["excess_max_mm"].as_f64().is_some_and(|e| e > 0.5), "{}", fin["deviation"]);
    // Both walls in one plane, in which rays run: those say the sheet is there, and the ones that cross them
    // see nothing.
    let exact = run("exact", 0.0);
    assert_eq!(
        (gate(&exact, "excess").0.as_str(), exact["deviation"]["films"].as_u64()),
        ("pass", Some(1)),
        "{}",
        exact["deviation"]
    );
}

/// `DL` of a tool call: the control takes the tool for longer than it is, and what is left is on the
/// part; for shorter, it gouges.
#[test]
fn a_delta_value_of_the_length_is_left_on_the_part_or_taken_from_it() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-10,40,20,0\"\ntool.T1 = \"flat D24 L25\"\n");
    desk.write("lower.stl", &super::block([0.0, 0.0, -10.0], [40.0, 20.0, -1.0]));
    let cases = [
        ("", 0.0, 0.0),
        ("DL+0.1", 0.1, 0.0),
        ("DL-0.2 DR+0.5", 0.0, 0.2),
        // Without a tool the word is for the one that is in.
        ("DL-0.3\nTOOL CALL S3000 DL+0.1", 0.1, 0.0),
        ("DL+0.1\nTOOL CALL S3000", 0.1, 0.0),
        ("DL+0.1\nTOOL CALL 1 Z S3000", 0.0, 0.0),
    ];
    for (k, (words, excess, gouge)) in cases.into_iter().enumerate() {
        let name = format!("delta{k}");
        let program = format!(
            "0 BEGIN PGM 1 MM\n1 TOOL CALL 1 Z S4000 F800 {words}\n2 L X-20 Y+10 R0 FMAX M3\n3 L Z-1 R0 FMAX\n4 L X+60 R0 F800\n\
             5 L Z+50 R0 FMAX M30\n6 END PGM 1 MM\n"
        );
        desk.write(&format!("{name}.h"), &program);
        desk.done(&format!("new {name}.h {MILL} --design lower.stl --output {name}"));
        let verdict = desk.verdict(&name);
        let assumed = words.contains("S3000 DL");
        let program = if assumed { "unchecked" } else { "pass" };
        assert_eq!(gate(&verdict, "program").0, program, "{words}: {:?}", gate(&verdict, "program"));
        assert_eq!(findings(&verdict, "program-assumed").len(), usize::from(assumed), "{words}");
        let d = &verdict["deviation"];
        for (key, expected) in [("excess_max_mm", excess), ("gouge_max_mm", gouge)] {
            let value = d[key].as_f64().expect("measured");
            assert!((value - expected).abs() < 1e-3, "{words}: {key} {value}, {expected}: {d}");
        }
    }
}

#[test]
fn imports_tell_taps_and_edges_at_the_center() {
    let desk = Desk::new(&[]);
    let entry = |number: u32, kind: &str, words: &str, more: &str| {
        format!(
            "{{\"type\":\"{kind}\",\"unit\":\"millimeters\",\"description\":\"{words}\",\"geometry\":{{\"DC\":8,\"LCF\":20,\"LB\":50,\"OAL\":80,\"SFDM\":8{more}}},\
             \"post-process\":{{\"number\":{number}}}}}"
        )
    };
    let all = [
        entry(1, "tap right hand", "Tap M8", ",\"TP\":1"),
        entry(2, "tap right hand", "M8x1.25 tap", ""),
        entry(3, "tap left hand", "some tap", ""),
        entry(4, "flat end mill", "Slot drill", ""),
        entry(5, "flat end mill", "rougher, non-center cutting", ""),
        entry(6, "flat end mill", "end mill", ""),
    ];
    desk.write("shop.json", &format!("{{\"data\":[{}],\"version\":1}}", all.join(",")));
    desk.done("tools shop.json --holder 40x60 --output tools.toml");
    let text = fs::read_to_string(desk.path("tools.toml")).expect("written");
    let tools: Vec<&str> = text.split("[[tool]]").skip(1).collect();
    let has = |k: usize, words: &[&str]| words.iter().for_each(|w| assert!(tools[k].contains(w), "{w}: {}", tools[k]));
    has(0, &["kind = \"tap\"", "pitch_mm = 1\n"]);
    has(1, &["kind = \"tap\"", "pitch_mm = 1.25\n"]);
    has(2, &["kind = \"tap\"", "no pitch is given", "hand = \"left\""]);
    assert!(!tools[2].contains("pitch_mm ="), "{}", tools[2]);
    has(3, &["center_cutting = true"]);
    has(4, &["center_cutting = false"]);
    assert!(!tools[5].contains("center_cutting"), "{}", tools[5]);
    desk.write(
        "shop.csv",
        "number,kind,diameter_mm,pitch_mm,center_cutting,description\n1,tap,8,1.25,,\n2,tap,6,,,M6 tap\n3,flat,10,,yes,\n4,flat,10,,,centre cutting\n",
    );
    desk.done("tools shop.csv --holder 40x60 --output table.toml");
    let text = fs::read_to_string(desk.path("table.toml")).expect("written");
    let tools: Vec<&str> = text.split("[[tool]]").skip(1).collect();
    for (tool, word) in
        tools.iter().zip(["pitch_mm = 1.25", "pitch_mm = 1\n", "center_cutting = true", "center_cutting = true"])
    {
        assert!(tool.contains(word), "{word}: {tool}");
    }
    desk.write("odd.csv", "number,kind,diameter_mm,center_cutting\n1,flat,8,perhaps\n");
    desk.refused("tools odd.csv --output odd.toml", &["`center_cutting` = \"perhaps\" is not yes or no"]);
    desk.write("odd.csv", "number,kind,diameter_mm,pitch_mm\n1,flat,8,1\n");
    let output = desk.refused("tools odd.csv --output odd.toml", &["pitch_mm"]);
    assert!(output.contains("is not a dimension of kind \"flat\""), "{output}");
}

/// The control fetches the tool of the next operation while this one cuts; that one need not be known. Where
/// it comes into the spindle, it must be.
#[test]
fn a_tool_that_is_made_ready_and_never_changed_in_need_not_be_known() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-10,40,20,0\"\n");
    let program = "O1\nG21 G90 G17 G40\n(T1 10MM FLAT ENDMILL CENTER CUTTING)\nT1 M6\nT7\nG54 G0 X-10. Y5. S3000 M3\nG43 H1 Z20.\nZ-1.\nG1 X50. F500.\nG0 Z20.\nM30\n";
    desk.write("ready.nc", program);
    desk.done(&format!("new ready.nc {MILL} --output ready"));
    let verdict = desk.verdict("ready");
    assert_eq!(gate(&verdict, "program").0, "pass", "{verdict}");
    let notes = findings(&verdict, "program-note");
    assert!(
        notes.iter().any(|n| n["message"].as_str().is_some_and(|m| m.contains("T7 is not in the tool library"))),
        "{notes:?}"
    );
    desk.write("ready.nc", &program.replace("G0 Z20.\nM30", "G0 Z20.\nM6\nM30"));
    desk.refused("run ready --rerun off", &["tool T7 is not in the tool library", "ready.nc:5:"]);
}
