//! Every key of a control file changes what a program gives: a key without an effect does not exist.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::collections::BTreeSet;
use std::path::Path;

use proveout_nc::{Compensation, Control, JsonWriter, Kinematics, Program, Settings, ToolRadii, control_schema};

/// Commands as JSON lines, the fault that ends them, and what is not run.
fn outcome(control: &str, program: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let control = match Control::from_text("shop.toml", control, Some(&folder)) {
        Ok(control) => control,
        Err(e) => panic!("{e}\n{control}"),
    };
    let mut settings = Settings::of_control(control);
    settings.kinematics = Some(Kinematics { machine: "M".to_owned(), tcp: true, tilted_plane: true });
    if program.contains("G41") {
        settings.compensation = Compensation::ToolCenter(ToolRadii { offset_is_tool: true, ..ToolRadii::default() });
    }
    let mut out = String::new();
    let mut program = match Program::from_text("program", program, &settings) {
        Ok(program) => program,
        Err(faults) => return format!("{faults}"),
    };
    let mut writer = JsonWriter::new();
    for command in program.by_ref() {
        match command {
            Ok(command) => {
                for line in writer.values(&command) {
                    out.push_str(&format!("{line}\n"));
                }
            }
            Err(fault) => {
                out.push_str(&format!("{fault}; {}\n", fault.help.as_deref().unwrap_or_default()));
            }
        }
    }
    for part in program.not_run() {
        out.push_str(&format!("{part} {:?}\n", part.weight()));
    }
    out
}

struct Case {
    key: &'static str,
    /// Two controls that differ in the key alone.
    controls: [&'static str; 2],
    program: &'static str,
    /// What only the second one gives.
    gives: &'static str,
}

const fn case(
    key: &'static str,
    without: &'static str,
    with: &'static str,
    program: &'static str,
    gives: &'static str,
) -> Case {
    Case { key, controls: [without, with], program, gives }
}

const FANUC: &str = "dialect = \"fanuc\"\n";

const CASES: &[Case] = &[
    case(
        "name",
        "dialect = \"fanuc\"\nwords.M25.refuse = \"x\"",
        "name = \"Mill 7\"\ndialect = \"fanuc\"\nwords.M25.refuse = \"x\"",
        "M25\n",
        "the control \"Mill 7\"",
    ),
    case(
        "inherits",
        "dialect = \"fanuc\"",
        "inherits = \"fanuc-30i\"",
        "G21 G0 X10 Y0 Z0\nM30\n",
        "state it as numbers.without_point",
    ),
    case("dialect", "dialect = \"fanuc\"", "dialect = \"linuxcnc\"", "G0 X0 Y0 Z0\nG4 P2\nM2\n", "\"seconds\":2.0"),
    case(
        "start.plane",
        FANUC,
        "dialect = \"fanuc\"\nstart.plane = \"ZX\"",
        "G21 G0 X0. Y0. Z0.\nG2 X10. K5. I5. Z0. F100\nM30\n",
        "\"op\":\"arc\"",
    ),
    case("start.unit", FANUC, "dialect = \"fanuc\"\nstart.unit = \"inch\"", "G0 X1.\nM30\n", "25.4"),
    case(
        "start.distance",
        FANUC,
        "dialect = \"fanuc\"\nstart.distance = \"incremental\"\nstart.position_mm = { X = 5 }",
        "G21 G0 X1.\nM30\n",
        "\"X\":6.0",
    ),
    case(
        "start.feed",
        FANUC,
        "dialect = \"fanuc\"\nstart.feed = \"per-revolution\"",
        "G21 S1000 M3\nG1 X1. F0.1\nM30\n",
        "mm_rev",
    ),
    case(
        "start.motion",
        FANUC,
        "dialect = \"fanuc\"\nstart.motion = \"linear\"",
        "G21 X1. Y1. F100.\nM30\n",
        "\"op\":\"linear\"",
    ),
    case(
        "start.position_mm",
        FANUC,
        "dialect = \"fanuc\"\nstart.position_mm = { X = 5, Z = 100 }",
        "G21 G91 G0 X1. Z-1.\nM30\n",
        "\"X\":6.0",
    ),
    case(
        "start.position_deg",
        FANUC,
        "dialect = \"fanuc\"\nstart.position_deg = { B = 30 }",
        "G21 G91 G0 B15.\nM30\n",
        "\"B\":45",
    ),
    case(
        "parameters.mixed_feed",
        FANUC,
        "dialect = \"fanuc\"\nparameters.mixed_feed = \"linear\"",
        "G21 G0 X0. C0.\nG91 G1 X20. C40. F300.\nM30\n",
        "\"radius_mm\":[0.0,0.0,0.0]",
    ),
    case(
        "parameters.reference_radius_mm",
        "dialect = \"fanuc\"\nparameters.mixed_feed = \"vector\"",
        "dialect = \"fanuc\"\nparameters = { mixed_feed = \"vector\", reference_radius_mm = { C = 50 } }",
        "G21 G0 X0. C0.\nG91 G1 X20. C40. F300.\nM30\n",
        ",50.0]",
    ),
    case(
        "parameters.rollover",
        "dialect = \"siemens-840d\"",
        "dialect = \"siemens-840d\"\nparameters.rollover = \"shortest\"",
        "G0 C350\nG0 C10\nM30\n",
        "\"C\":370.0",
    ),
    case(
        "parameters.rollover_axes",
        "dialect = \"fanuc\"\nparameters.rollover = \"sign\"",
        "dialect = \"fanuc\"\nparameters = { rollover = \"sign\", rollover_axes = [\"B\"] }",
        "G21 G0 C350.\nC10.\nM30\n",
        "{\"C\":10.0}",
    ),
    case(
        "parameters.outside_modulo",
        "dialect = \"siemens-840d\"",
        "dialect = \"siemens-840d\"\nparameters.outside_modulo = \"convert\"",
        "G0 C10\nC=ACN(-90)\nM30\n",
        "\"C\":-90.0",
    ),
    case(
        "parameters.length_word",
        "dialect = \"fanuc\"\nparameters.length_word = \"shifts\"",
        "dialect = \"fanuc\"\nparameters.length_word = \"moves\"",
        "G21 G0 X0. Y0. Z100.\nG43 H1\nM30\n",
        "\"op\":\"rapid\",\"end\":{\"X\":0.0,\"Y\":0.0,\"Z\":100.0},\"end_base\":{\"X\":0.0,\"Y\":0.0,\"Z\":100.0}}\n{\"file\":\"program\",\"line\":3",
    ),
    case(
        "parameters.return_level",
        FANUC,
        "dialect = \"fanuc\"\nparameters.return_level = \"r-plane\"",
        "G21 G0 X0. Y0. Z50.\nG81 X10. Y0. Z-10. R2. F50\nX20.\nG80\nM30\n",
        "\"op\":\"rapid\",\"end\":{\"X\":20.0,\"Y\":0.0,\"Z\":2.0},\"end_base\":{\"X\":20.0,\"Y\":0.0,\"Z\":2.0}}\n{\"file\":\"program\",\"line\":5",
    ),
    case(
        "parameters.orientation_angles",
        "dialect = \"siemens-840d\"",
        "dialect = \"siemens-840d\"\nparameters.orientation_angles = \"rpy\"",
        "TRAORI\nG0 X0 Y0 Z0 A2=30 B2=45 C2=90\nM30\n",
        "[0.5,0.612372436",
    ),
    case(
        "parameters.tilt_reference",
        "dialect = \"siemens-840d\"",
        "dialect = \"siemens-840d\"\nparameters.tilt_reference = \"C\"",
        "CYCLE800(0,\"\",0,57,0,0,0,20,0,0,0,0,0,-1)\nM30\n",
        "\"reference_axis\":\"C\"",
    ),
    case(
        "parameters.tilt_solution",
        FANUC,
        "dialect = \"fanuc\"\nparameters.tilt_solution = \"lower\"",
        "G21 G68.2 X0. Y0. Z0. I0. J20. K0.\nG53.1\nM30\n",
        "\"solution\":\"lower\"",
    ),
    case(
        "parameters.g64_tolerance_mm",
        "dialect = \"linuxcnc\"",
        "dialect = \"linuxcnc\"\nparameters.g64_tolerance_mm = 0.02",
        "G21 G64\nG0 X1\nM2\n",
        "\"tolerance_mm\":0.02",
    ),
    case(
        "parameters.radius_offset_mm",
        FANUC,
        "dialect = \"fanuc\"\nparameters.radius_offset_mm = { 2 = 6.0 }",
        "G21 G0 X0. Y-20. Z0.\nG41 D2 G1 X0. Y0. F100.\nG1 X50.\nG40 G1 X60. Y-20.\nM30\n",
        "\"Y\":6.0",
    ),
    case(
        "numbers.without_point",
        FANUC,
        "dialect = \"fanuc\"\nnumbers.without_point = \"increments\"",
        "G21 G0 X1000\nM30\n",
        "\"X\":1.0",
    ),
    case(
        "numbers.increment_mm",
        "dialect = \"fanuc\"\nnumbers.without_point = \"increments\"",
        "dialect = \"fanuc\"\nnumbers = { without_point = \"increments\", increment_mm = 0.01 }",
        "G21 G0 X1000\nM30\n",
        "\"X\":10.0",
    ),
    case(
        "numbers.increment_inch",
        "dialect = \"fanuc\"\nnumbers.without_point = \"increments\"",
        "dialect = \"fanuc\"\nnumbers = { without_point = \"increments\", increment_inch = 0.001 }",
        "G20 G0 X1000\nM30\n",
        "\"X\":25.4",
    ),
    case(
        "numbers.increment_deg",
        "dialect = \"fanuc\"\nnumbers.without_point = \"increments\"",
        "dialect = \"fanuc\"\nnumbers = { without_point = \"increments\", increment_deg = 0.01 }",
        "G21 G0 B1000\nM30\n",
        "\"B\":10.0",
    ),
    case(
        "arcs.tolerance_mm",
        FANUC,
        "dialect = \"fanuc\"\narcs.tolerance_mm = 0.1",
        "G21 G0 X10. Y0. Z0.\nG3 X0. Y10.05 I-10. F100\nM30\n",
        "\"op\":\"arc\"",
    ),
    case(
        "arcs.tolerance_ratio",
        FANUC,
        "dialect = \"fanuc\"\narcs = { tolerance_ratio = 0.001, largest_difference_mm = 0.5 }",
        "G21 G0 X100. Y0. Z0.\nG3 X0. Y100.09 I-100. F100\nM30\n",
        "\"op\":\"arc\"",
    ),
    case(
        "arcs.largest_difference_mm",
        "dialect = \"fanuc\"\narcs = { tolerance_ratio = 0.001, largest_difference_mm = 0.05 }",
        "dialect = \"fanuc\"\narcs = { tolerance_ratio = 0.001, largest_difference_mm = 0.5 }",
        "G21 G0 X100. Y0. Z0.\nG3 X0. Y100.09 I-100. F100\nM30\n",
        "\"op\":\"arc\"",
    ),
    case(
        "program.modal_variables",
        "dialect = \"fanuc\"",
        "dialect = \"fanuc\"\nprogram.modal_variables = \"mitsubishi\"",
        "G21 G90 G55\nG0 X0. Y0. Z0.\nX#4012\nM30\n",
        "\"X\":55.0",
    ),
    case(
        "arcs.clsf_sense",
        "dialect = \"apt\"",
        "dialect = \"apt\"\narcs.clsf_sense = \"clockwise\"",
        "UNITS/MM\nFEDRAT/100,MMPM\nGOTO/0,0,0\nCIRCLE/10,0,0,0,0,1,10\nGOTO/20,0,0\nFINI\n",
        "\"normal\":[0.0,0.0,-1.0]",
    ),
    case(
        "arcs.centers",
        FANUC,
        "dialect = \"fanuc\"\narcs.centers = \"absolute\"",
        "G21 G0 X20. Y10. Z0.\nG3 X10. Y20. I10. J10. F100\nM30\n",
        "\"center\":[10.0,10.0",
    ),
    case(
        "cycles.g76",
        FANUC,
        "dialect = \"fanuc\"\ncycles.g76 = \"shift-may-be-left-out\"",
        "G21 G0 X0. Y0. Z50. S500 M3\nG98 G76 X10. Y0. Z-10. R2. F50\nG80\nM30\n",
        "\"Z\":-10",
    ),
    case(
        "cycles.returns",
        FANUC,
        "dialect = \"fanuc\"\ncycles.returns = \"m53\"",
        "G21 G0 X0. Y0. Z50.\nG71 Z20.\nG81 X10. Y0. Z-10. R2. F50 M53\nG80\nM30\n",
        "\"Z\":20.0",
    ),
    case(
        "cycles.depth",
        FANUC,
        "dialect = \"fanuc\"\ncycles.depth = \"I\"",
        "G21 G0 X0. Y0. Z50.\nG98 G81 X10. Y0. Z2. I-10. F50\nG80\nM30\n",
        "\"Z\":-10.0",
    ),
    case(
        "program.words",
        FANUC,
        "dialect = \"fanuc\"\nprogram.words = \"osp\"",
        "G21 G0 X0. Y0. Z0.\nVC1=7\nX=VC1\nM30\n",
        "\"X\":7.0",
    ),
    case(
        "program.words",
        "dialect = \"linuxcnc\"\n",
        "dialect = \"linuxcnc\"\nprogram.words = \"grbl\"",
        "$H\nG21 G90 G0 X0 Y0\nM2\n",
        "machine_coordinates",
    ),
    case(
        "tool_length.without_h",
        FANUC,
        "dialect = \"fanuc\"\ntool_length.without_h = \"tool\"",
        "G21 T7 M6\nG0 G43 Z5.\nM30\n",
        "\"edge\":7",
    ),
    case(
        "limits.call_depth",
        FANUC,
        "dialect = \"fanuc\"\nlimits.call_depth = 1",
        "O1\nM98 P2\nM30\nO2\nM98 P3\nM99\nO3\nM99\n",
        "the limit is 1",
    ),
    case(
        "limits.passes",
        FANUC,
        "dialect = \"fanuc\"\nlimits.passes = 3",
        "G21 G0 X0. Y0. Z0.\n#1=0\nWHILE [#1 LT 5] DO1\n#1=#1+1\nX#1\nEND1\nM30\n",
        "has jumped back 3 times",
    ),
    case(
        "limits.idle_passes",
        FANUC,
        "dialect = \"fanuc\"\nlimits.idle_passes = 4",
        "#1=0\nWHILE [#1 LT 9] DO1\n#1=#1+1\nEND1\nG21 G0 X1. Y0. Z0.\nM30\n",
        "has run 4 times without a motion",
    ),
    case(
        "tool_change.position_mm",
        FANUC,
        "dialect = \"fanuc\"\ntool_change.position_mm = { Z = 420 }",
        "G21 T1 M6\nG0 X1.\nM30\n",
        "\"Z\":420.0",
    ),
    case(
        "words.G15.offset",
        FANUC,
        "dialect = \"fanuc\"\nwords.G15.offset = \"H\"",
        "G21 G0 X1.\nG15 H7\nM30\n",
        "G54.1 P1",
    ),
    case(
        "words.G16.offset_once",
        FANUC,
        "dialect = \"fanuc\"\nwords.G16.offset_once = \"H\"",
        "G21 G0 G16 H0 Z7.\nM30\n",
        "\"machine_coordinates\":true",
    ),
    case("dwell.P", FANUC, "dialect = \"fanuc\"\ndwell.P = \"s\"", "G4 P2\nM30\n", "\"seconds\":2.0"),
    case(
        "feed.missing",
        FANUC,
        "dialect = \"fanuc\"\nfeed = { missing = \"value\", missing_mm_min = 300 }",
        "G21 G1 X1.\nM30\n",
        "\"feed_mm_min\":300.0",
    ),
    case(
        "feed.missing_mm_min",
        "dialect = \"fanuc\"\nfeed = { missing = \"value\", missing_mm_min = 300 }",
        "dialect = \"fanuc\"\nfeed = { missing = \"value\", missing_mm_min = 500 }",
        "G21 G1 X1.\nM30\n",
        "\"feed_mm_min\":500.0",
    ),
    case(
        "feed.rapid_from_mm_min",
        "dialect = \"heidenhain\"",
        "dialect = \"heidenhain\"\nfeed.rapid_from_mm_min = 9999",
        "0 BEGIN PGM A MM\n1 L X+1 R0 F9999\n2 L X+2\n3 L X+3 F500\n4 END PGM A MM\n",
        "\"op\":\"rapid\",\"end\":{\"X\":2.0}",
    ),
    case(
        "orientation.interpolation",
        "dialect = \"siemens-840d\"",
        "dialect = \"siemens-840d\"\norientation.interpolation = \"axes\"",
        "TRAORI\nM30\n",
        "axes",
    ),
    case(
        "blocks.skipped_levels",
        FANUC,
        "dialect = \"fanuc\"\nblocks.skipped_levels = [1]",
        "G21 G0 X1.\n/G0 X2.\nM30\n",
        "",
    ),
    case(
        "variables.#500",
        FANUC,
        "dialect = \"fanuc\"\nvariables = { \"#500\" = 7.5 }",
        "G21 G0 X#500\nM30\n",
        "\"X\":7.5",
    ),
    case(
        "subprograms.folders",
        FANUC,
        "dialect = \"fanuc\"\nsubprograms.folders = [\"subprograms\"]",
        "M98 P4711\nM30\n",
        "\"X\":47.11",
    ),
    case(
        "subprograms.missing",
        FANUC,
        "dialect = \"fanuc\"\nsubprograms = { missing = \"note\", missing_reason = \"warm-up\" }",
        "M98 P9999\nG21 G0 X1.\nM30\n",
        "Unproven",
    ),
    case(
        "subprograms.missing_reason",
        "dialect = \"fanuc\"\nsubprograms = { missing = \"note\", missing_reason = \"a\" }",
        "dialect = \"fanuc\"\nsubprograms = { missing = \"note\", missing_reason = \"warm-up of the spindle\" }",
        "M98 P9999\nG21 G0 X1.\nM30\n",
        "warm-up of the spindle",
    ),
    case(
        "assumed.arcs",
        "dialect = \"fanuc\"\narcs.centers = \"absolute\"",
        "dialect = \"fanuc\"\narcs.centers = \"absolute\"\nassumed.arcs = \"they close\"",
        "G21 G0 X1.\nM30\n",
        "is not confirmed: they close",
    ),
    case("program.end", FANUC, "dialect = \"fanuc\"\nprogram.end = \"text\"", "G21 G0 X1. Y1. Z1.\n", "\"op\":\"end\""),
    case(
        "parameters.compensation",
        "dialect = \"fanuc\"\nparameters.radius_offset_mm = { 1 = 0.1 }",
        "dialect = \"fanuc\"\nparameters = { compensation = \"wear\", radius_offset_mm = { 1 = 0.1 } }",
        "G21 G17\nT1 M6\nG0 X-20. Y20. Z0.\nG41 D1 G1 X-10. Y5. F300.\nX50.\nG40 Y30.\nM30\n",
        "the program gives the path of the tool center",
    ),
    case(
        "program.header",
        FANUC,
        "dialect = \"fanuc\"\nprogram.header = [\"$*.MIN%\"]",
        "$PART.MIN%\nG21 G0 X1.\nM30\n",
        "\"X\":1.0",
    ),
    case(
        "program.trailer",
        FANUC,
        "dialect = \"fanuc\"\nprogram.trailer = [\"E*\"]",
        "G21 G0 X1.\nM30\nEND OF FILE\n",
        "END OF FILE is not a block",
    ),
    case("unlisted.m", FANUC, "dialect = \"fanuc\"\nunlisted.m = \"refuse\"", "M777\nM30\n", "does not list it"),
    case(
        "words.M25.does",
        FANUC,
        "dialect = \"fanuc\"\nwords.M25.does = \"M3 M8\"",
        "S100 M25\nM30\n",
        "\"flood\":true",
    ),
    case(
        "words.M25.kinematics",
        FANUC,
        "dialect = \"fanuc\"\nwords.M25.kinematics = \"tcp-on\"",
        "G43 H1\nM25\nM30\n",
        "\"op\":\"tcp\"",
    ),
    case(
        "words.M25.call",
        FANUC,
        "dialect = \"fanuc\"\nwords.M25.call = \"O20\"",
        "G21 M25\nM30\nO20\nG0 X3.\nM99\n",
        "\"X\":3.0",
    ),
    case(
        "words.M25.macro",
        FANUC,
        "dialect = \"fanuc\"\nwords.M25.macro = \"O20\"",
        "G21\nM25 A3.\nM30\nO20\nG0 X#1\nM99\n",
        "\"X\":3.0",
    ),
    case(
        "words.M25.message",
        FANUC,
        "dialect = \"fanuc\"\nwords.M25.message = \"turn the part\"",
        "M25\nM30\n",
        "\"op\":\"message\"",
    ),
    case("words.M25.note", FANUC, "dialect = \"fanuc\"\nwords.M25.note = \"clamps\"", "M25\nM30\n", "M25: clamps"),
    case(
        "words.M25.ignore",
        FANUC,
        "dialect = \"fanuc\"\nwords.M25.ignore = \"chip conveyor\"",
        "M25\nM25\nM30\n",
        "chip conveyor",
    ),
    case("words.M25.refuse", FANUC, "dialect = \"fanuc\"\nwords.M25.refuse = \"use M26\"", "M25\nM30\n", "use M26"),
    case(
        "words.M25.values",
        "dialect = \"fanuc\"\nwords.M25.note = \"clamps\"",
        "dialect = \"fanuc\"\nwords.M25 = { note = \"clamps\", values = \"Q\" }",
        "M25 Q7\nM30\n",
        "M25 Q7: clamps",
    ),
];

/// What a key should have given, and what a program gave without and with it.
fn differs(key: &str, gives: &str, without: &str, with: &str) -> String {
    format!("{key}: {gives}\n--- without\n{without}--- with\n{with}")
}

#[test]
fn every_key_changes_what_a_program_gives() {
    let mut wrong = Vec::new();
    for Case { key, controls, program, gives } in CASES {
        let [without, with] = controls.map(|control| outcome(control, program));
        if without == with || !with.contains(gives) || !gives.is_empty() && without.contains(gives) {
            wrong.push(differs(key, gives, &without, &with));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_key_of_the_schema_is_tried() {
    let schema = control_schema().to_value();
    let definition = |value: &serde_json::Value| {
        let name = value["$ref"].as_str().and_then(|r| r.rsplit('/').next())?;
        Some(schema["$defs"][name].clone())
    };
    let mut keys = BTreeSet::new();
    for (name, property) in schema["properties"].as_object().unwrap() {
        let inner = definition(property).or_else(|| definition(&property["allOf"][0]));
        let entry = definition(&property["additionalProperties"]).filter(|d| d["properties"].is_object());
        if let Some(inner) = inner.filter(|d| d["properties"].is_object()) {
            keys.extend(inner["properties"].as_object().unwrap().keys().map(|key| format!("{name}.{key}")));
        } else if let Some(entry) = entry {
            keys.extend(entry["properties"].as_object().unwrap().keys().map(|key| format!("{name}.*.{key}")));
        } else if property["additionalProperties"].is_object() {
            keys.insert(format!("{name}.*"));
        } else {
            keys.insert(name.clone());
        }
    }
    // Sources are for readers of the file; that they name keys of it is checked where it is read.
    for documentation in ["source.*", "words.*.source"] {
        assert!(keys.remove(documentation), "{documentation}");
    }
    for key in &keys {
        let fits = |case: &Case| {
            let (key, own): (Vec<&str>, Vec<&str>) = (key.split('.').collect(), case.key.split('.').collect());
            key.len() == own.len() && key.iter().zip(&own).all(|(k, o)| *k == "*" || k == o)
        };
        assert!(CASES.iter().any(fits), "no program shows what {key} does");
    }
    assert!(keys.len() >= 35, "{keys:?}");
}

/// Keys that other languages use, too.
#[test]
fn the_languages_use_what_their_control_says() {
    let mut wrong = Vec::new();
    for (control, program, gives) in [
        ("dialect = \"siemens-840d\"\nstart.unit = \"inch\"", "G0 X1\nM30\n", "25.4"),
        (
            "dialect = \"siemens-840d\"\nstart.distance = \"incremental\"\nstart.position_mm = { X = 5 }",
            "G0 X1\nM30\n",
            "\"X\":6.0",
        ),
        ("dialect = \"siemens-840d\"\nstart.motion = \"rapid\"", "X1\nM30\n", "rapid"),
        ("dialect = \"siemens-840d\"\nstart.feed = \"per-revolution\"", "S100 M3\nG1 X1 F0.1\nM30\n", "mm_rev"),
        (
            "dialect = \"siemens-840d\"\nstart.plane = \"ZX\"",
            "G0 X0 Y0 Z0\nG2 X10 Z0 I5 K0 F100\nM30\n",
            "\"op\":\"arc\"",
        ),
        ("dialect = \"siemens-840d\"\nfeed = { missing = \"value\", missing_mm_min = 300 }", "G1 X1\nM30\n", "300.0"),
        ("dialect = \"siemens-840d\"\nwords.M13.does = \"M3 M8\"", "S100 M13\nM30\n", "flood"),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"bore\", values = \"PQ\" }",
            "G21 G0 X0 Y0 Z0\no<bore> sub\nG0 X#<p> Y#1\no<bore> endsub\nM400 P7\nM2\n",
            "\"X\":7.0",
        ),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"20\", values = \"P\" }",
            "G21 G0 X0 Y0 Z0\no20 sub\nG0 X9\no20 endsub\nM400\nM2\n",
            "\"X\":9.0",
        ),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"bore\", values = \"P\" }",
            "G21 G0 X0 Y0 Z0\no<bore> sub\nG0 X#<p>\no<bore> endsub\nG1 M400 P7\nM2\n",
            "write it in a block of its own",
        ),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"bore\" }",
            "G21 G0 X0 Y0 Z0\no<bore> sub\no<bore> endsub\nM400 P7\nM2\n",
            "`P7` has no meaning in this block",
        ),
        ("dialect = \"siemens-840d\"\nwords.G187.note = \"quality\"", "G187\nM30\n", "G187: quality"),
        ("dialect = \"siemens-840d\"\nwords.CYCLE999.ignore = \"log\"", "CYCLE999(1,2)\nM30\n", "log"),
        ("dialect = \"siemens-840d\"\nwords.CYCLE999.refuse = \"take it out\"", "CYCLE999(1,2)\nM30\n", "take it out"),
        ("dialect = \"siemens-840d\"\nwords.M50.kinematics = \"tcp-on\"", "M50\nM30\n", "\"op\":\"tcp\""),
        ("dialect = \"siemens-840d\"\nwords.M6.call = \"CHANGE\"", "M6\nM30\n", "CHANGE"),
        (
            "dialect = \"siemens-840d\"\nsubprograms = { missing = \"note\", missing_reason = \"log\" }",
            "L20\nG0 X1\nM30\n",
            "Unproven",
        ),
        ("dialect = \"siemens-840d\"\nunlisted.m = \"refuse\"", "M777\nM30\n", "does not list it"),
        ("dialect = \"siemens-840d\"\nprogram.header = [\"HEAD*\"]", "HEAD OF TAPE\nG0 X1\nM30\n", "is not a block"),
        (
            "dialect = \"heidenhain\"\nwords.M25.does = \"M3 M8\"",
            "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100\n2 M25\n3 END PGM A MM\n",
            "flood",
        ),
        (
            "dialect = \"heidenhain\"\nwords.M25.ignore = \"vise\"",
            "0 BEGIN PGM A MM\n2 L X+1 R0 FMAX M25\n3 END PGM A MM\n",
            "vise",
        ),
        (
            "dialect = \"heidenhain\"\nwords.M114.note = \"old\"",
            "0 BEGIN PGM A MM\n2 L X+1 R0 FMAX M114\n3 END PGM A MM\n",
            "M114: old",
        ),
        (
            "dialect = \"heidenhain\"\nwords.M50.kinematics = \"tcp-on\"",
            "0 BEGIN PGM A MM\n2 M50\n3 END PGM A MM\n",
            "\"op\":\"tcp\"",
        ),
        (
            "dialect = \"heidenhain\"\nunlisted.m = \"refuse\"",
            "0 BEGIN PGM A MM\n2 M777\n3 END PGM A MM\n",
            "does not list it",
        ),
        (
            "dialect = \"heidenhain\"\nfeed = { missing = \"value\", missing_mm_min = 300 }",
            "0 BEGIN PGM A MM\n2 L X+1 R0\n3 END PGM A MM\n",
            "300.0",
        ),
        (
            "dialect = \"heidenhain\"\nstart.position_mm = { X = 5 }",
            "0 BEGIN PGM A MM\n2 L IX+1 R0 FMAX\n3 END PGM A MM\n",
            "\"X\":6.0",
        ),
        (
            "dialect = \"heidenhain\"\nvariables = { \"ID270 NR1 IDX1\" = 4.5 }",
            "0 BEGIN PGM A MM\n1 FN 18: SYSREAD Q1 = ID270 NR1 IDX1\n2 L X+Q1 R0 FMAX\n3 END PGM A MM\n",
            "\"X\":4.5",
        ),
        (
            "dialect = \"heidenhain\"\nsubprograms = { missing = \"note\", missing_reason = \"log\" }",
            "0 BEGIN PGM A MM\n1 CALL PGM OTHER\n3 END PGM A MM\n",
            "Unproven",
        ),
        (
            "dialect = \"heidenhain\"\nblocks.skipped_levels = [0]",
            "0 BEGIN PGM A MM\n/1 L X+77 R0 FMAX\n2 L X+1 R0 FMAX\n3 END PGM A MM\n",
            "\"X\":1.0",
        ),
        ("dialect = \"apt\"\nwords.FOOBAR.ignore = \"of the post\"", "FOOBAR/1\nGOTO/0,0,0\nFINI\n", "of the post"),
        ("dialect = \"apt\"\nstart.unit = \"inch\"", "RAPID\nGOTO/1,0,0\nFINI\n", "25.4"),
        ("dialect = \"apt\"\nstart.position_mm = { X = 5, Y = 0, Z = 0 }", "RAPID\nGODLTA/1,0,0\nFINI\n", "\"X\":6.0"),
        (
            "dialect = \"linuxcnc\"\narcs.centers = \"absolute\"",
            "G21 G0 X20 Y10 Z0\nG3 X10 Y20 I10 J10 F100\nM2\n",
            "\"op\":\"arc\"",
        ),
        ("dialect = \"linuxcnc\"\nwords.M428.kinematics = \"tcp-on\"", "G21 M428\nM2\n", "\"op\":\"tcp\""),
    ] {
        let dialect = control.lines().next().unwrap();
        let (without, with) = (outcome(dialect, program), outcome(control, program));
        if without == with || !with.contains(gives) {
            wrong.push(differs(control, gives, &without, &with));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unsigned_centers_find_the_quadrant() {
    let control = "dialect = \"fanuc\"\narcs.centers = \"unsigned\"";
    for (program, center) in [
        ("G3 X10. Y20. I10. J0. F100", "10.0,10.0"),
        ("G2 X30. Y20. I10. J0. F100", "30.0,10.0"),
        ("G2 X10. Y0. I10. J0. F100", "10.0,10.0"),
    ] {
        let out = outcome(control, &format!("G21 G0 X20. Y10. Z0.\n{program}\nM30\n"));
        assert!(out.contains(&format!("\"center\":[{center}")), "{program}: {out}");
    }
    let out = outcome(control, "G21 G0 X20. Y10. Z0.\nG3 X10. Y25. I10. J0. F100\nM30\n");
    assert!(out.contains("0 centers fit"), "{out}");
}

#[test]
fn a_kinematics_word_is_refused_where_the_machine_does_not_list_it() {
    for (dialect, program) in [
        ("fanuc", "G43 H1\nM50\nM30\n"),
        ("siemens-840d", "M50\nM30\n"),
        ("heidenhain", "0 BEGIN PGM A MM\n1 M50\n2 END PGM A MM\n"),
    ] {
        let text = format!("dialect = \"{dialect}\"\nwords.M50.kinematics = \"tcp-on\"");
        let control = Control::from_text("shop.toml", &text, None).unwrap();
        let mut settings = Settings::of_control(control);
        settings.kinematics = Some(Kinematics { machine: "three axes".to_owned(), tcp: false, tilted_plane: false });
        let faults = proveout_nc::check_text("p", program, &settings);
        assert!(faults.iter().any(|f| f.message.contains("M50") && f.message.contains("three axes")), "{faults:?}");
    }
}

#[test]
fn a_control_reads_programs_of_its_language_only() {
    let mut settings = Settings::of_control(Control::find("fanuc-30i", None).unwrap());
    settings.dialect = proveout_nc::Dialect::Siemens840d;
    let fault = Program::from_text("p.mpf", "G0 X1\nM30\n", &settings).unwrap_err();
    assert!(fault.to_string().contains("is fanuc"), "{fault}");
}

#[test]
fn a_tnc_reads_both_forms_of_its_language() {
    let settings = Settings::of_control(Control::find("heidenhain-tnc-640", None).unwrap());
    for (name, text) in [
        ("p.h", "0 BEGIN PGM A MM\n1 L X+1 R0 FMAX\n2 END PGM A MM\n"),
        ("p.i", "%A G71 *\nN10 G00 G40 G90 X+1 *\nN99999999 %A G71 *\n"),
    ] {
        assert_eq!(proveout_nc::check_text(name, text, &settings), [], "{name}");
    }
    let settings = Settings::of_control(Control::find("haas-ngc", None).unwrap());
    let iso = Settings { dialect: proveout_nc::Dialect::Iso, ..settings };
    let program = Program::from_text("p.nc", "G0 G154 P3 X0\nM30\n", &iso).unwrap();
    assert_eq!(program.dialect(), proveout_nc::Dialect::Haas);
}
