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

/// An ISO 13399 file with values in two units, one code given twice in the same size.
const P21: &str = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA (('CUTTING_TOOL_SCHEMA_ARM'));\nENDSEC;\nDATA;\n\
    #1 = UNIT ('mm');\n#2 = UNIT ('inch');\n#3 = STRING_WITH_LANGUAGE ('BULL NOSE END MILL; 12''S', #9);\n\
    /* #8 = NUMERICAL_VALUE ('DC', $, #1, '99'); */ #4 = NUMERICAL_VALUE ('DC', $, #1, '12.7');\n\
    #5 = NUMERICAL_VALUE ('DC', $, #2, '0.5');\n#6 = NUMERICAL_VALUE ('RE', $, #1, '1.5');\n\
    #7 = NUMERICAL_VALUE ('APMX', $, #2, '1.25');\n#10 = NUMERICAL_VALUE ('OAL', $, #1, '83');\n\
    #11 = NUMERICAL_VALUE ('DMM', $, #1, '12');\n#12 = NUMERICAL_VALUE ('NOF', $, $, '4');\n\
    #13 = STRING_VALUE ('HAND', $, 'L');\nENDSEC;\nEND-ISO-10303-21;\n";

#[test]
fn iso_13399_values_have_their_own_units_and_are_those_of_the_file() {
    let shelf = Shelf::new();
    let all = import_tools(&shelf.file("mill.p21", P21), &call(None)).expect("read");
    let mill = &all.tools[0];
    assert_eq!((all.format, mill.number, mill.name.as_str()), ("ISO 13399 file", 1, "BULL NOSE END MILL; 12'S"));
    assert_eq!((mill.kind, mill.diameter(), mill.get("corner_radius_mm")), (Some("bull_nose"), Some(12.7), Some(1.5)));
    assert_eq!((mill.flute_length, mill.overall, mill.shank), (Some(31.75), Some(83.0), Some(12.0)));
    assert!(mill.flutes == Some(4) && mill.left_handed);
    assert!(all.notes.iter().any(|n| n.contains("numbered from 1")), "{:?}", all.notes);
    assert_eq!(library(all.tools).tools[0].max_radius(), 6.35);
    for (from, to, words) in [
        ("'0.5'", "'0.6'", "`DC` has two values: 12.7 and 0.6"),
        ("'1.5'", "'7'", "corner radius of 7 mm is above half of its diameter of 12.7 mm"),
        ("'NOF', $, $, '4'", "'NOF', $, $, '4.5'", "`NOF`, `ZEFF`, `ZEFP` = 4.5 is no number of teeth"),
        ("'83'", "'eighty'", "`OAL` = \"eighty\" is not a number"),
        ("$, #1, '83'", "$, $, '83'", "`OAL` = 83 has no unit of length"),
        ("CUTTING_TOOL_SCHEMA_ARM", "AUTOMOTIVE_DESIGN", "no ISO 13399 file"),
        ("END-ISO-10303-21;\n", "", "the file is not whole"),
    ] {
        let text = P21.replacen(from, to, 1);
        assert_ne!(text, P21, "{from}");
        let refused = import_tools(&shelf.file("bad.p21", &text), &call(None)).expect_err(words).to_string();
        assert!(refused.contains(words), "{refused}");
    }
    let none = P21.replace("'DC'", "'DX'");
    let refused = import_tools(&shelf.file("none.p21", &none), &call(None)).expect_err("no diameter").to_string();
    assert!(refused.contains("`DC` is not given"), "{refused}");
}

#[test]
fn din_4000_has_decimal_commas_and_only_the_class_whose_letters_are_known() {
    let property = |name: &str, value: &str| {
        format!(
            "<Property-Data><PropertyName source=\"din_mk\">{name}</PropertyName><Value>{value}</Value></Property-Data>"
        )
    };
    let values =
        [("J23", "VHM"), ("A1", "8,5"), ("B2", "20"), ("B5", "63,25"), ("C3", "10"), ("F21", "3"), ("J22", "X1")];
    let body: String = values.iter().map(|(k, v)| property(k, v)).collect();
    let file = |class: &str, more: &str| {
        format!(
            "<?xml version=\"1.0\"?><!DOCTYPE Tool-Data SYSTEM \"x.dtd\"><Tool-Data><Tool><Category><Category-Data>\
             <PropertyName>NSM</PropertyName><Value>{class}</Value></Category-Data></Category><Properties>{body}{more}</Properties></Tool></Tool-Data>"
        )
    };
    let shelf = Shelf::new();
    let all = import_tools(&shelf.file("din.xml", &file("DIN4000-82", "")), &call(None)).expect("read");
    let mill = &all.tools[0];
    assert_eq!((mill.name.as_str(), mill.kind, mill.diameter()), ("X1", Some("flat"), Some(8.5)));
    assert_eq!((mill.flute_length, mill.overall, mill.shank), (Some(20.0), Some(63.25), Some(10.0)));
    assert_eq!(mill.flutes, Some(3));
    let refused = |text: &str| import_tools(&shelf.file("bad.xml", text), &call(None)).expect_err("bad").to_string();
    let two = refused(&file("DIN4000-82", &property("A1", "9")));
    assert!(two.contains("`A1` has two values: 8,5 and 9"), "{two}");
    let other = refused(&file("DIN4000-81", ""));
    assert!(other.contains("class DIN4000-81; DIN4000-82"), "{other}");
    let other = refused("<Shelf/>");
    assert!(other.contains("begins with <Shelf>"), "{other}");
    let cut = file("DIN4000-82", "");
    assert!(refused(&cut[..cut.len() - 20]).contains("not XML"));
    // Entities that would grow to gigabytes are refused, not expanded.
    let bomb = "<!DOCTYPE a [<!ENTITY a \"aaaaaaaaaaaaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;\">\
                <!ENTITY d \"&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;\"><!ENTITY e \"&d;&d;&d;&d;&d;&d;&d;&d;&d;&d;\">]><Tool-Data>&e;&e;&e;</Tool-Data>";
    assert!(!refused(bomb).is_empty());
}

#[test]
fn libraries_of_cam_systems_state_unit_and_type() {
    let shelf = Shelf::new();
    let hyper = "<omtdx version=\"25\"><tools><tools folder=\"a\"><tool name=\"Kugel 10\" type=\"ballMill\">\
                 <param name=\"lengthOfUnit\" value=\"mm\"/><param name=\"toolDiameter\" value=\"10\"/><param name=\"toolTotalLength\" value=\"80\"/>\
                 <param name=\"cuttingLength\" value=\"22\"/><param name=\"cuttingEdges\" value=\"2\"/><param name=\"toolShaftDiameter\" value=\"10\"/>\
                 <tecsets><tecset><param name=\"cuttingLength\" value=\"0\"/></tecset></tecsets></tool></tools></tools></omtdx>";
    let all = import_tools(&shelf.file("hyper.xml", hyper), &call(None)).expect("read");
    let ball = &all.tools[0];
    assert_eq!((all.format, ball.kind, ball.name.as_str()), ("hyperMILL library", Some("ball"), "Kugel 10"));
    assert_eq!((ball.diameter(), ball.flute_length, ball.overall), (Some(10.0), Some(22.0), Some(80.0)));
    assert_eq!((ball.shank, ball.flutes), (Some(10.0), Some(2)));
    let solid = "<?xml version=\"1.0\" encoding=\"iso-8859-1\"?><Results><Tools><Tool SubType=\"EndMill\" UserType=\"3/8 EM\">\
                 <param name=\"diameter\" value=\"0.375\"/><param name=\"arbor diameter\" value=\"0.375\"/><param name=\"total length\" value=\"2.5\"/>\
                 <param name=\"outside holder length\" value=\"1.2\"/><param name=\"cutting edge length\" value=\"0.75\"/>\
                 <param name=\"number of teeth\" value=\"4\"/><param name=\"unit\" value=\"inch\"/></Tool></Tools></Results>";
    let all = import_tools(&shelf.file("solid.xml", solid), &call(None)).expect("read");
    let mill = &all.tools[0];
    assert_eq!((all.format, mill.kind, mill.diameter()), ("SolidCAM library", Some("flat"), Some(0.375 * INCH_MM)));
    assert_eq!(
        (mill.shank, mill.overall, mill.flute_length),
        (Some(0.375 * INCH_MM), Some(2.5 * INCH_MM), Some(0.75 * INCH_MM))
    );
    assert_eq!((mill.stick_out, mill.flutes), (Some(1.2 * INCH_MM), Some(4)));
    let refused = |text: &str| import_tools(&shelf.file("bad.xml", text), &call(None)).expect_err("bad").to_string();
    let two = refused(&hyper.replace("\"toolTotalLength\" value=\"80\"", "\"toolDiameter\" value=\"12\""));
    assert!(two.contains("tool 1 of the file (\"Kugel 10\"): `toolDiameter` has two values: 10 and 12"), "{two}");
    assert!(refused(&hyper.replace("lengthOfUnit", "length")).contains("states no unit (lengthOfUnit)"));
    let units = solid.replace("</Tool>", "<param name=\"units\" value=\"metric\"/></Tool>");
    assert!(refused(&units).contains("has two units: inch and metric"));
    assert!(refused(&solid.replace("\"inch\"", "\"cubit\"")).contains("unit \"cubit\" is not known"));
    assert!(refused("<Results/>").contains("has no tool"));
    let zip = import_tools(&shelf.file("tool.zip", "PK"), &call(None)).expect_err("a package").to_string();
    assert!(zip.contains("a GTC package is not read"), "{zip}");
}
