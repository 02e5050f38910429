//! Library files: the shipped ones are read, and each defect is refused at its line and key.

use std::path::{Path, PathBuf};

use proveout_tool::{RakeAbout, Role, RoundInsert, RunOut, ToolId, ToolLibrary, library_schema};

fn shipped(name: &str) -> ToolLibrary {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tools").join(name);
    ToolLibrary::read(&path).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn the_axis_cross_library_has_the_tools_of_its_program() {
    let library = shipped("axis-cross.toml");
    assert_eq!(library.tools.len(), 8);
    for (name, radius, flute) in [
        ("PLAN_D50_N_AP4", 25.0, 4.0),
        ("SCHAFT_D12_N_AP30", 6.0, 30.0),
        ("SCHAFT_D6_N_AP15", 3.0, 15.0),
        ("ENTFRAESER_D8_N_90GRAD", 4.0, 6.0),
        ("BOHRER_D3.3_VHM", 1.65, 28.0),
        ("SCHAFT_D8_N_AP20", 4.0, 20.0),
        ("SCHAFT_D4_N_AP20", 2.0, 20.0),
        ("ENTFRAESER_D8_90GRAD", 4.0, 6.0),
    ] {
        let tool = library.find(&ToolId::Name(name.into())).unwrap_or_else(|| panic!("{name}"));
        let cutting = tool.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max);
        assert!((cutting - radius).abs() < 1e-12, "{name}: {cutting}");
        assert_eq!(tool.flute_length, flute, "{name}");
        assert!(tool.has_holder && (90.0..=150.0).contains(&tool.gauge_length), "{name}");
        let mut z = 0.0;
        for b in &tool.bodies {
            assert!((b.profile.z_min() - z).abs() < 1e-9, "{name}: gap at {z}");
            z = b.profile.z_max();
        }
        assert!((z - tool.gauge_length).abs() < 1e-9, "{name}");
    }
    assert!(library.notes.iter().all(|n| !n.source.is_empty() && !n.chosen.is_empty()));
}

#[test]
fn the_cone_frustum_library_cuts_a_flank_of_45_mm() {
    let library = shipped("cone-frustum.toml");
    let tool = library.find(&ToolId::Name("END_D20".into())).expect("END_D20");
    assert!(tool.flute_length >= 45.0);
    assert_eq!(library.position(&ToolId::Number(1)), Some(0));
    assert_eq!(library.find(&ToolId::Number(99)), None);
    assert_eq!(library.nearest_name("END-D20"), Some("END_D20"));
    assert_eq!(tool.not_cutting().next().map(|b| b.role), Some(Role::Shank));
}

/// A library of one good tool, with one line replaced or added.
fn with(line: &str, key: &str) -> String {
    let good = [
        "[[tool]]",
        "number = 1",
        "name = \"END\"",
        "kind = \"flat\"",
        "diameter_mm = 10.0",
        "flute_length_mm = 30",
        "shank_diameter_mm = 10.0",
        "overall_length_mm = 80.0",
        "gauge_length_mm = 120.0",
        "[tool.holder]",
        "sections = [{ diameter_mm = 40.0, length_mm = 70.0 }]",
    ];
    let found = good.iter().any(|l| l.starts_with(&format!("{key} =")));
    let mut lines: Vec<&str> = Vec::new();
    for l in good {
        if found && l.starts_with(&format!("{key} =")) {
            lines.extend(Some(line).filter(|l| !l.is_empty()));
        } else {
            if l == "[tool.holder]" && !found && !line.is_empty() {
                lines.push(line);
            }
            lines.push(l);
        }
    }
    lines.join("\n")
}

#[track_caller]
fn refused(text: &str, line: usize, key: &str, words: &str) {
    let error = ToolLibrary::from_text(Path::new("lib.toml"), text).expect_err("must be refused");
    let shown = error.to_string();
    assert_eq!((error.line, error.key.rsplit('.').next()), (line, Some(key)), "{shown}");
    assert!(shown.contains(words), "{shown}");
    assert!(shown.starts_with(&format!("lib.toml:{line}:{}:", error.column)), "{shown}");
}

#[test]
fn the_good_library_is_accepted() {
    let library = ToolLibrary::from_text(Path::new("lib.toml"), &with("", "-")).expect("good");
    assert_eq!(library.tools[0].bodies.len(), 3);
}

#[test]
fn each_defect_is_refused_at_its_line_and_key() {
    refused(&with("diamter_mm = 10.0", "diameter_mm"), 5, "diamter_mm", "did you mean `diameter_mm`");
    refused(&with("", "diameter_mm"), 1, "diameter_mm", "kind \"flat\" needs diameter_mm");
    refused(&with("diameter_mm = -10.0", "diameter_mm"), 5, "diameter_mm", "= -10.0: must be above 0");
    refused(&with("diameter_mm = nan", "diameter_mm"), 5, "diameter_mm", "= nan: is out of range");
    refused(&with("diameter_mm = 2e5", "diameter_mm"), 5, "diameter_mm", "out of range: -100000 to 100000");
    refused(&with("diameter_mm = 2e4", "diameter_mm"), 5, "diameter_mm", "at most 10000 mm");
    refused(&with("diameter_mm = \"10\"", "diameter_mm"), 5, "diameter_mm", "must be a number");
    refused(&with("kind = \"bal\"", "kind"), 4, "kind", "did you mean \"ball\"");
    refused(&with("kind = \"ball_bearing_factory\"", "kind"), 4, "kind", "must be one of ball, flat");
    refused(&with("", "kind"), 1, "kind", "is missing");
    refused(&with("", "name"), 1, "name", "is missing");
    refused(&with("name = \" END\"", "name"), 3, "name", "blanks");
    refused(&with("number = -1", "number"), 2, "number", "= -1: must be a whole number, 0 or more");
    refused(&with("number = 1.5", "number"), 2, "number", "whole number");
    refused(&with("flute_length_mm = 0.0", "flute_length_mm"), 6, "flute_length_mm", "above 0");
    refused(&with("", "flute_length_mm"), 1, "flute_length_mm", "is missing");
    refused(
        &with("corner_radius_mm = 1.0", "corner_radius_mm"),
        10,
        "corner_radius_mm",
        "is not a dimension of kind \"flat\"",
    );
    refused(
        &with("gauge_length_mm = 60.0", "gauge_length_mm"),
        9,
        "gauge_length_mm",
        "above 70 mm, the length of the holder",
    );
    refused(&with("gauge_length_mm = 90.0", "gauge_length_mm"), 9, "gauge_length_mm", "holder nose");
    refused(&with("", "gauge_length_mm"), 1, "gauge_length_mm", "is missing");
    refused(&with("overall_length_mm = 40.0", "overall_length_mm"), 8, "overall_length_mm", "reach the holder");
    refused(&with("neck_diameter_mm = 8.0", "neck_diameter_mm"), 1, "neck_length_mm", "is missing");
    refused(&with("transition_length_mm = 50.0", "transition_length_mm"), 10, "transition_length_mm", "at most 20 mm");
    refused(&with("flutes = 0", "flutes"), 10, "flutes", "1 or more");
    refused(&with("max_speed_rpm = 0.0", "max_speed_rpm"), 10, "max_speed_rpm", "above 0");
    refused(&with("center_cutting = 1", "center_cutting"), 10, "center_cutting", "true or false");
    refused(&with("hand = \"lift\"", "hand"), 10, "hand", "did you mean \"left\"");
    refused(
        &with("chosen = [{ keys = [\"neck_length_mm\"], reason = \"r\" }]", "chosen"),
        10,
        "chosen",
        "names `neck_length_mm`",
    );
    refused(&with("sections = []", "sections"), 11, "sections", "at least one section");
    refused(&with("sections = [{ diameter_mm = -4.0, length_mm = 9.0 }]", "sections"), 11, "sections", "dimension -4");
    refused(&with("sections = [{ diameter_mm = 4.0, lenght_mm = 9.0 }]", "sections"), 11, "lenght_mm", "`length_mm`");
    refused(&with("sections = [{ diameter_mm = 4.0 }]", "sections"), 11, "length_mm", "is missing");
    refused("[[tool]]\nnumber = = 2\n", 2, "", "not TOML");
    refused("[[tools]]\nnumber = 2\n", 1, "tools", "did you mean `tool`");
}

#[test]
fn numbers_and_names_are_unique() {
    let twice = format!("{}\n{}", with("", "-"), with("", "-"));
    refused(&twice, 13, "number", "number of tool \"END\" as well");
    let same_name = format!("{}\n{}", with("", "-"), with("number = 2", "number"));
    refused(&same_name, 14, "name", "used twice");
}

#[test]
fn profiles_are_read_and_refused() {
    let text = |segments: &str| {
        format!(
            "[[tool]]\nnumber = 1\nname = \"P\"\nkind = \"profile\"\ngauge_length_mm = 60.0\nsegments = [{segments}]\n"
        )
    };
    let good = text("{ to_mm = [5.0, 5.0], center_mm = [0.0, 5.0] }, { to_mm = [5.0, 20.0] }");
    let library = ToolLibrary::from_text(Path::new("lib.toml"), &good).expect("a ball end");
    assert_eq!(library.tools[0].flute_length, 20.0);
    assert!(!library.tools[0].has_holder);
    refused(&text("{ to_mm = [5.0, 5.0], center_mm = [0.0, 4.0] }"), 6, "segments", "equally far");
    refused(&text("{ to_mm = [5.0, 5.0, 1.0] }"), 6, "to_mm", "must be a list of 2 values");
    refused(&text("{ to_mm = [5.0, 5.0] }, { to_mm = [6.0, 1.0] }"), 6, "segments", "z falls");
}

#[test]
fn a_missing_file_is_named() {
    let error = ToolLibrary::read(&PathBuf::from("no/such/library.toml")).expect_err("missing");
    assert!(error.to_string().contains("no/such/library.toml"));
}

#[test]
fn the_schema_knows_every_kind_and_its_dimensions() {
    let schema = library_schema();
    for word in ["\"ball\"", "\"taper_ball\"", "\"apt\"", "corner_center_height_mm", "entering_angle_deg", "chosen"] {
        assert!(schema.contains(word), "{word}");
    }
}

#[test]
fn a_steepest_ramp_belongs_to_a_tool_without_edges_at_its_center() {
    let read = |kind: &str, more: &str| {
        let text = format!(
            "[[tool]]\nnumber = 1\nname = \"HEAD\"\nkind = \"{kind}\"\ndiameter_mm = 20\nflute_length_mm = 12\n\
             gauge_length_mm = 60\n{more}\n"
        );
        ToolLibrary::from_text(Path::new("tools.toml"), &text)
    };
    let tool = |kind: &str, more: &str| read(kind, more).unwrap_or_else(|e| panic!("{e}")).tools.remove(0);
    let head = tool("flat", "center_cutting = false\nmax_ramp_angle_deg = 3");
    assert!((head.max_ramp_angle.expect("stated") - 3.0_f64.to_radians()).abs() < 1e-12);
    assert_eq!(head.cuts_at_center(), Some(false));
    for wrong in ["", "center_cutting = true", "center_cutting = false"] {
        let angle = if wrong == "center_cutting = false" { "90" } else { "3" };
        let error = read("flat", &format!("{wrong}\nmax_ramp_angle_deg = {angle}")).expect_err(wrong).to_string();
        assert!(error.contains("max_ramp_angle_deg"), "{error}");
    }
    // Of a flat end it is not known unless stated; the edges of a ball meet at its tip.
    assert_eq!(tool("flat", "").cuts_at_center(), None);
    assert_eq!(tool("ball", "").cuts_at_center(), Some(true));
    assert_eq!(tool("ball", "center_cutting = false").cuts_at_center(), Some(false));
}

/// A face mill with two round inserts, as a library gives it, with lines replaced or added in its edges.
fn face_mill(more: &str) -> String {
    format!(
        "[[tool]]\nnumber = 1\nname = \"HEAD\"\nkind = \"face_mill\"\ndiameter_mm = 20\ncorner_radius_mm = 5\n\
         entering_angle_deg = 90\nflute_length_mm = 6\noverall_length_mm = 40\ngauge_length_mm = 40\nflutes = 2\n\
         [tool.edges]\n{more}\n"
    )
}

#[test]
fn edges_of_teeth_are_read() {
    let text = face_mill(
        "radial_run_out_mm = [0, 0.011]\naxial_run_out_mm = [0.0, 0.003]\nradial_rake_deg = 0.6\n\
         round_insert = { nose_circle_diameter_mm = 10, insert_radius_mm = 5 }",
    );
    let library = ToolLibrary::from_text(Path::new("lib.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
    let edges = library.tools[0].edges.as_ref().expect("described");
    assert_eq!(edges.run_out, [RunOut::default(), RunOut { radial: 0.011, axial: 0.003 }]);
    assert_eq!(edges.round_insert, Some(RoundInsert { nose_circle_diameter: 10.0, insert_radius: 5.0 }));
    assert!((edges.radial_rake - 0.6_f64.to_radians()).abs() < 1e-15);
    assert_eq!((edges.rake_about, edges.helix), (RakeAbout::Axis, 0.0));
    let nose = face_mill("helix_deg = -30\nradial_rake_deg = -5\nrake_about = \"nose\"");
    let library = ToolLibrary::from_text(Path::new("lib.toml"), &nose).unwrap_or_else(|e| panic!("{e}"));
    let edges = library.tools[0].edges.as_ref().expect("described");
    assert_eq!((edges.rake_about, edges.run_out.len()), (RakeAbout::Nose, 2));
    assert!((edges.helix + 30_f64.to_radians()).abs() < 1e-15);
    assert_eq!(ToolLibrary::from_text(Path::new("lib.toml"), &with("", "-")).expect("good").tools[0].edges, None);
}

#[test]
fn edges_that_no_tool_has_are_refused_by_name() {
    let of = |more: &str, key: &str, words: &str| refused(&face_mill(more), 13, key, words);
    of("radial_run_out_mm = [0, 0.011, 0]", "radial_run_out_mm", "3 values for 2 teeth (flutes)");
    of("axial_run_out_mm = []", "axial_run_out_mm", "0 values for 2 teeth");
    of("axial_run_out_mm = [0, 5.0]", "axial_run_out_mm", "has 5; run-out must be below the edge radius, 5 mm");
    of("radial_run_out_mm = [0, nan]", "radial_run_out_mm[1]", "= nan: is out of range");
    of("radial_rake_deg = 90", "radial_rake_deg", "above -90 and below 90");
    of("helix_deg = -90", "helix_deg", "above -90 and below 90");
    of("rake_about = \"nose\"", "rake_about", "with radial_rake_deg");
    of("rake_about = \"noes\"", "rake_about", "did you mean \"nose\"");
    let insert =
        |d: &str, r: &str| format!("round_insert = {{ nose_circle_diameter_mm = {d}, insert_radius_mm = {r} }}");
    of(&insert("10", "0"), "insert_radius_mm", "above 0");
    of(&insert("-10", "5"), "nose_circle_diameter_mm", "above 0");
    of(&insert("10", "4"), "round_insert", "cutter diameter 18 mm");
    of("axial_rake_deg = 3", "axial_rake_deg", "did you mean `radial_rake_deg`");
    refused(&with("edges = { helix_deg = 30 }", "edges"), 1, "flutes", "is missing: [tool.edges]");
}
