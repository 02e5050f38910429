use std::path::PathBuf;

use super::*;
use crate::draft::library_text;
use crate::{Role, ToolLibrary};

struct Shelf(tempfile::TempDir);

impl Shelf {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("written");
        path
    }
}

fn call(unit: Option<LengthUnit>) -> ImportCall {
    ImportCall { unit, wanted: None }
}

/// The library that the drafts make.
fn library(mut tools: Vec<ToolDraft>) -> ToolLibrary {
    for tool in &mut tools {
        tool.complete(None).expect("a diameter is given");
    }
    let text = library_text("made", "made", &tools);
    ToolLibrary::from_text(Path::new("tools.toml"), &text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// An end mill of half an inch in a holder drawn in millimeters, whose last segment goes on above the gauge
/// line.
const MIXED: &str = r#"{"data": [
  {"type": "flat end mill", "unit": "inches", "description": "1/2 rougher", "guid": "x", "BMC": "carbide",
   "geometry": {"DC": 0.5, "LCF": 1.25, "LB": 2.0, "OAL": 3.0, "SFDM": 0.5, "NOF": 4, "HAND": true, "shoulder-length": 1.5, "shoulder-diameter": 0.48},
   "holder": {"unit": "millimeters", "description": "ER32", "gaugeLength": 70,
     "segments": [{"height": 20, "lower-diameter": 40, "upper-diameter": 50}, {"height": 30, "lower-diameter": 50, "upper-diameter": 50},
                  {"height": 40, "lower-diameter": 50, "upper-diameter": 63}]},
   "post-process": {"number": 3, "length-offset": 3}, "expressions": {"tool_diameter": "12.7 mm"}},
  {"type": "chamfer mill", "unit": "millimeters", "description": "C10", "geometry": {"DC": 10, "LCF": 5, "LB": 40, "OAL": 60, "TA": 45, "NOF": 2, "tip-diameter": 0},
   "post-process": {"number": 4}},
  {"type": "center drill", "unit": "millimeters", "description": "A4", "geometry": {"DC": 10, "LCF": 10, "LB": 40, "TA": 60, "tip-diameter": 4}, "post-process": {"number": 5}},
  {"type": "turning general", "unit": "millimeters", "description": "CNMG", "geometry": {"RE": 0.8}, "post-process": {"number": 6}}
]}"#;

#[test]
fn the_holder_has_its_own_unit_and_ends_at_the_gauge_line() {
    let shelf = Shelf::new();
    let all = import_tools(&shelf.file("lib.json", MIXED), &call(None)).expect("read");
    assert_eq!(all.format, "Fusion 360 library");
    let mill = &all.tools[0];
    assert_eq!(
        (mill.number, mill.diameter(), mill.flute_length, mill.stick_out),
        (3, Some(12.7), Some(31.75), Some(50.8))
    );
    let lengths: Vec<f64> = mill.holder.iter().map(|s| s.length).collect();
    assert_eq!(lengths, [20.0, 30.0, 20.0], "millimeters although the tool is in inch, and cut at 70 mm");
    // The cone is cut half way up: 50 to 56.5 mm.
    assert!((mill.holder[2].top_diameter - 56.5).abs() < 1e-9);
    let read = library(all.tools.clone());
    let tool = &read.tools[0];
    assert!((tool.gauge_length - 120.8).abs() < 1e-6);
    let nose = tool.bodies.iter().find(|b| b.role == Role::Holder).expect("holder");
    // Listed tip first: the thin end of 40 mm is at the nose.
    assert!((nose.profile.z_min() - 50.8).abs() < 1e-6);
    assert!((nose.profile.segments()[0].to()[0] - 20.0).abs() < 1e-6);
    assert!(all.notes.iter().any(|n| n.contains("CNMG") && n.contains("left out")), "{:?}", all.notes);
}

#[test]
fn half_angles_of_chamfer_mills_are_doubled_and_those_of_center_drills_are_not() {
    let shelf = Shelf::new();
    let all = import_tools(&shelf.file("lib.json", MIXED), &call(None)).expect("read");
    assert_eq!(all.tools[1].get("point_angle_deg"), Some(90.0));
    assert_eq!(all.tools[2].get("point_angle_deg"), Some(60.0));
}

#[test]
fn kinds_of_a_library_give_their_outlines() {
    let shelf = Shelf::new();
    let entry = |number: u32, kind: &str, geometry: &str| {
        format!(
            r#"{{"type": "{kind}", "unit": "millimeters", "description": "t{number}", "geometry": {{{geometry}}}, "post-process": {{"number": {number}}}}}"#
        )
    };
    let tools = [
        entry(1, "ball end mill", r#""DC": 8, "RE": 4, "LCF": 16, "LB": 40"#),
        entry(2, "bull nose end mill", r#""DC": 12, "RE": 1, "LCF": 26, "LB": 45"#),
        entry(3, "tapered mill", r#""DC": 2, "RE": 1, "TA": 5, "LCF": 20, "LB": 50, "SFDM": 8"#),
        entry(4, "dovetail mill", r#""DC": 20, "TA": 30, "LCF": 8, "LB": 50, "SFDM": 8"#),
        entry(
            5,
            "lollipop mill",
            r#""DC": 10, "LCF": 9, "LB": 50, "shoulder-diameter": 6, "shoulder-length": 30, "SFDM": 10"#,
        ),
        entry(6, "drill", r#""DC": 6.8, "SIG": 140, "LCF": 40, "LB": 60"#),
        entry(7, "tap right hand", r#""DC": 8, "LCF": 20, "LB": 60"#),
        entry(8, "face mill", r#""DC": 50, "RE": 0.8, "TA": 45, "LCF": 8, "LB": 40"#),
        entry(9, "circle segment barrel", r#""DC": 10, "lower-radius": 2, "profile-radius": 60, "LCF": 20, "LB": 50"#),
    ];
    let text = format!(r#"{{"data": [{}]}}"#, tools.join(","));
    let all = import_tools(&shelf.file("lib.json", &text), &call(None)).expect("read");
    let read = library(all.tools);
    let widest = |n: usize| 2.0 * read.tools[n].cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max);
    // Inserts of 45 degrees, 8 mm high, about a face of 50 mm: 66 mm. The cone of 5 degrees above a ball of
    // 1 mm radius: r = cos 5 + (20 - (1 - sin 5)) tan 5.
    let half = 5.0_f64.to_radians();
    let top = half.cos() + (20.0 - (1.0 - half.sin())) * half.tan();
    for (n, want) in [8.0, 12.0, 2.0 * top, 20.0, 10.0, 6.8, 8.0, 66.0, 10.0].into_iter().enumerate() {
        assert!((widest(n) - want).abs() < 0.02, "T{}: {} instead of {want}", n + 1, widest(n));
    }
}

#[test]
fn double_numbers_are_refused_by_both_names() {
    let shelf = Shelf::new();
    let twice = MIXED.replace("\"number\": 4", "\"number\": 3");
    let error = import_tools(&shelf.file("lib.json", &twice), &call(None)).expect_err("double");
    assert!(
        error.message.contains("number 3") && error.message.contains("1/2 rougher") && error.message.contains("C10"),
        "{error}"
    );
    // Not a fault of the tools that are wanted.
    let wanted = ImportCall { unit: None, wanted: Some([5].into()) };
    assert_eq!(import_tools(&shelf.file("lib.json", &twice), &wanted).expect("read").tools.len(), 1);
    let table = shelf.file("tool.tbl", "T1 P1 D6 Z50\nT1 P2 D8 Z50\n");
    assert!(import_tools(&table, &call(Some(LengthUnit::Millimeter))).is_err());
    let csv = shelf.file("t.csv", "number,kind,diameter_mm\n1,flat,6\n1,flat,8\n");
    assert!(import_tools(&csv, &call(None)).is_err());
}

#[test]
fn tables_without_a_unit_want_one() {
    let shelf = Shelf::new();
    let table =
        shelf.file("tool.tbl", "T1 P1 D.5 Z+4.25 ;1/2 4FL end mill\nT2 P2 D0.25 Z3 X0 I30 ;ball nose\n\n;nothing\n");
    let error = import_tools(&table, &call(None)).expect_err("no unit");
    assert!(error.remedy.contains("--unit"), "{error}");
    let all = import_tools(&table, &call(Some(LengthUnit::Inch))).expect("read");
    assert_eq!((all.tools[0].diameter(), all.tools[0].flutes), (Some(12.7), Some(4)));
    assert!((all.tools[0].gauge.expect("given") - 107.95).abs() < 1e-9);
    assert_eq!((all.tools[1].kind, all.notes.len()), (Some("ball"), 1));
    assert_eq!(library(all.tools).tools.len(), 2);
    let wrong = shelf.file("wrong.tbl", "T1 P1 D6\nT2 Dxyz\n");
    let error = import_tools(&wrong, &call(Some(LengthUnit::Inch))).expect_err("no number");
    assert_eq!(error.line, 2);
}

#[test]
fn offsets_of_a_control_are_added_with_their_wear() {
    let shelf = Shelf::new();
    let text = "%\nG20 G90\nG10 L10 P1 R4.5 (1/2 END MILL)\nG10 L11 P1 R-.002\nG10 L12 P1 R.5\nG10 L13 P1 R-0.001\n%\n";
    let all = import_tools(&shelf.file("offsets.nc", text), &call(None)).expect("read");
    let tool = &all.tools[0];
    assert!(
        (tool.gauge.expect("given") - 4.498 * 25.4).abs() < 1e-9
            && (tool.diameter().expect("given") - 0.499 * 25.4).abs() < 1e-9
    );
    let none = text.replace("G20 ", "");
    assert!(
        import_tools(&shelf.file("offsets.nc", &none), &call(None)).expect_err("no unit").remedy.contains("--unit")
    );
    let double = text.replace("L13", "L12");
    let error = import_tools(&shelf.file("offsets.nc", &double), &call(None)).expect_err("set twice");
    assert!(error.message.contains("lines 5 and 6"), "{error}");
}

#[test]
fn camotics_and_csv_give_tools() {
    let shelf = Shelf::new();
    let project = r#"{"units": "metric", "files": ["a.nc"], "tools": {
      "1": {"units": "metric", "shape": "cylindrical", "length": 20, "diameter": 6, "description": "rough"},
      "2": {"units": "imperial", "shape": "conical", "length": 0.5, "diameter": 0.5}}}"#;
    let all = import_tools(&shelf.file("part.camotics", project), &call(None)).expect("read");
    assert_eq!((all.tools[0].flute_length, all.tools[1].diameter()), (Some(20.0), Some(12.7)));
    // A cone as high as it is wide: half angle atan 1/2.
    assert!((all.tools[1].get("point_angle_deg").expect("given") - 53.130_102).abs() < 1e-4);
    library(all.tools);
    let csv = "number,name,kind,diameter_inch,flute_length_mm,stick_out_mm,holder_diameter_mm,holder_length_mm,flutes\n\
               7,END,flat,0.5,30,45,40,60,4\n8,B6,ball,0.25,,,,,\n";
    let all = import_tools(&shelf.file("t.csv", csv), &call(None)).expect("read");
    assert_eq!((all.tools[0].diameter(), all.tools[1].diameter()), (Some(12.7), Some(6.35)));
    assert!((library(all.tools).tools[0].gauge_length - 105.0).abs() < 1e-9);
    let unknown =
        import_tools(&shelf.file("u.csv", "number,diametre_mm\n1,6\n"), &call(None)).expect_err("unknown column");
    assert!(unknown.remedy.contains("diameter_mm"), "{unknown}");
    let letters =
        import_tools(&shelf.file("v.csv", "number,diameter_mm\n1,six\n"), &call(None)).expect_err("no number");
    assert_eq!(letters.line, 2);
}

#[test]
fn what_is_no_library_is_refused() {
    let shelf = Shelf::new();
    for (name, text) in [
        ("a.json", "{\"a\": 1}"),
        ("b.json", "[1"),
        ("c.txt", "hello"),
        ("d.tools", "PK"),
        ("e.csv", "a,b\n1,2\n"),
        ("f.tbl", ""),
        ("g.json", ""),
    ] {
        let error = import_tools(&shelf.file(name, text), &call(Some(LengthUnit::Inch))).expect_err(name);
        assert!(!error.message.is_empty() && !error.remedy.is_empty(), "{name}: {error}");
    }
    assert!(import_tools(Path::new("nowhere.json"), &call(None)).is_err());
}
