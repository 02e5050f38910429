//! Every mistake in a machine file gets one error with its line, key, value and remedy.

use std::path::Path;

use proveout_input::InputError;
use proveout_machine::Machine;

const GOOD: &str = r#"name = "test"

[[joint]]
name = "X"
kind = "linear"
carries = "tool"
parent = "base"
direction = [1, 0, 0]
travel_mm = [-100, 100]

[[joint]]
name = "Y"
kind = "linear"
carries = "tool"
parent = "X"
direction = [0, 1, 0]

[[joint]]
name = "Z"
kind = "linear"
carries = "tool"
parent = "Y"
direction = [0, 0, 1]

[[joint]]
name = "B"
kind = "rotary"
carries = "workpiece"
parent = "base"
direction = [0, 1, 0]
point_mm = [0, 0, 50]
sense = -1
travel_deg = [-10, 105]
max_velocity_deg_s = 100

[[joint]]
name = "C"
kind = "rotary"
carries = "workpiece"
parent = "B"
direction = [0, 0, 1]
point_mm = [0, 0, 0]
sense = -1
endless = true

[spindle]
on = "Z"
origin_mm = [0, 0, 0]
direction = [0, 0, 1]
start_time_s = 1

[table]
on = "C"
point_mm = [0, 0, 0]
normal = [0, 0, 1]

[control]
cycle_time_ms = 2
block_time_ms = 1
tool_change_time_s = 5
rapid_mode = "straight"
default_tolerance_mm = 0.01

[[body]]
name = "plate"
role = "table"
attached_to = "C"
check = true
[[body.box]]
min_mm = [-1, -1, -1]
max_mm = [1, 1, 0]
"#;

fn refusal(text: &str) -> InputError {
    match Machine::from_text(Path::new("folder/machine.toml"), text) {
        Err(e) => e,
        Ok(_) => panic!(
            "accepted:
{text}"
        ),
    }
}

/// Replaces one piece of the good file and checks code, the text at the line named, and a part of the
/// message.
#[track_caller]
fn expect(old: &str, new: &str, code: &str, at_line: &str, part: &str) {
    assert!(GOOD.contains(old), "{old}");
    let text = GOOD.replacen(old, new, 1);
    let e = refusal(&text);
    let shown = e.to_string();
    assert_eq!(e.code, code, "{shown}");
    let line = text.lines().nth(e.line - 1).unwrap_or_default();
    assert!(line.contains(at_line), "{shown}\npoints at {line:?}");
    assert!(e.column >= 1 && e.column <= line.chars().count() + 1, "{shown}");
    assert!(shown.contains(part), "{shown}");
    assert!(shown.starts_with("folder/machine.toml:"), "{shown}");
    assert!(!e.remedy.is_empty());
}

#[test]
fn the_good_file_is_good() {
    let machine = Machine::from_text(Path::new("machine.toml"), GOOD).expect("good");
    assert_eq!(machine.tool_chain, [0, 1, 2]);
    assert_eq!(machine.work_chain, [3, 4]);
    let missing: Vec<String> = machine
        .missing_limits()
        .iter()
        .map(|m| format!("{} {}", m.joint.map_or("spindle", |j| &machine.joints[j].name), m.key))
        .collect();
    assert_eq!(missing[0], "X max_velocity_mm_min");
    assert!(
        missing.contains(&"Y travel_mm".to_owned()) && !missing.contains(&"C travel_deg".to_owned()),
        "{missing:?}"
    );
    assert_eq!(missing.last().map(String::as_str), Some("spindle max_speed_rpm"));
    let codes: Vec<&str> = machine.diagnose().iter().map(|d| d.code).collect();
    assert!(codes.contains(&"machine-missing-limit") && codes.contains(&"machine-no-source"));
}

#[test]
fn unknown_words_are_named_with_the_nearest() {
    expect("travel_mm =", "travell_mm =", "input-unknown-key", "travell_mm", "did you mean `travel_mm`?");
    expect("travel_mm =", "travel =", "input-unit-missing", "travel =", "write `travel_mm` or `travel_deg`");
    expect("[control]", "[controll]", "input-unknown-key", "[controll]", "did you mean `control`?");
    expect("kind = \"rotary\"", "kind = \"rotatory\"", "input-unknown-word", "rotatory", "rotary");
    expect("rapid_mode = \"straight\"\n", "", "input-missing-key", "[control]", "rapid_mode");
    expect("name = \"test\"\n", "name = \"test\n", "input-syntax", "name = \"test", "correct the text");
    expect(
        "cycle_time_ms = 2",
        "cycle_time_ms = \"2\"",
        "input-wrong-type",
        "cycle_time_ms",
        "= \"2\": must be a number",
    );
}

#[test]
fn wrong_units_are_named() {
    expect("travel_deg =", "travel_mm =", "machine-wrong-unit", "travel_mm = [-10", "write travel_deg");
    expect("travel_mm =", "travel_deg =", "machine-wrong-unit", "travel_deg = [-100", "write travel_mm");
    let both = "max_velocity_deg_s = 100\nmax_velocity_rev_min = 20";
    expect("max_velocity_deg_s = 100", both, "machine-duplicate-limit", "max_velocity_rev_min", "twice");
}

#[test]
fn trees_that_are_none_are_refused() {
    expect("name = \"Y\"", "name = \"X\"", "machine-duplicate-joint", "name = \"X\"", "joint.X.name");
    expect("parent = \"X\"", "parent = \"Q\"", "machine-unknown-joint", "parent = \"Q\"", "X, Y, Z, B, C");
    expect("parent = \"base\"", "parent = \"Z\"", "machine-loop", "parent", "loop");
    expect("parent = \"X\"", "parent = \"base\"", "machine-loose-joint", "parent = \"base\"", "joint X is in no chain");
    expect("on = \"Z\"", "on = \"Y\"", "machine-loose-joint", "parent = \"Y\"", "joint Z");
    let second = "parent = \"X\"\nparent = \"base\"";
    expect("parent = \"X\"", second, "input-syntax", "parent = \"base\"", "duplicate key");
    expect(
        "carries = \"tool\"\nparent = \"Y\"",
        "carries = \"workpiece\"\nparent = \"Y\"",
        "machine-wrong-side",
        "carries",
        "Z",
    );
    expect("on = \"C\"", "on = \"Z\"", "machine-wrong-side", "carries", "joint Z");
    expect("attached_to = \"C\"", "attached_to = \"Q\"", "machine-unknown-joint", "attached_to", "no joint \"Q\"");
}

#[test]
fn loops_beside_the_chains_are_refused() {
    let extra = "[[joint]]\nname = \"U\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"V\"\ndirection = [1, 0, 0]\n\
                 [[joint]]\nname = \"V\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"U\"\ndirection = [1, 0, 0]\n\n[spindle]";
    expect("[spindle]", extra, "machine-loop", "parent", "loop");
}

#[test]
fn directions_must_be_unit_vectors() {
    expect("[1, 0, 0]", "[0, 0, 0]", "machine-not-unit", "direction = [0, 0, 0]", "length 0");
    expect("[1, 0, 0]", "[1, 1, 0]", "machine-not-unit", "direction = [1, 1, 0]", "[0.707106781, 0.707106781, 0");
    expect("[1, 0, 0]", "[nan, 0, 0]", "input-out-of-range", "nan", "range");
    let close = GOOD.replacen("[1, 0, 0]", "[0.7071068, 0.7071068, 0]", 1);
    let machine = Machine::from_text(Path::new("m.toml"), &close).expect("seven digits are enough");
    assert!((machine.joints[0].direction.norm() - 1.0).abs() < 1e-15);
}

#[test]
fn rotary_axes_must_be_complete_and_apart() {
    expect("sense = -1\n", "", "machine-sense", "[[joint]]", "joint.B.sense");
    expect("sense = -1\n", "sense = 2\n", "machine-sense", "sense = 2", "write 1 or -1");
    expect("point_mm = [0, 0, 50]\n", "", "input-missing-key", "[[joint]]", "joint.B.point_mm");
    expect(
        "direction = [0, 1, 0]\npoint_mm",
        "direction = [0, 0, 1]\npoint_mm",
        "machine-parallel-rotary-axes",
        "direction = [0, 0, 1]",
        "parallel",
    );
}

#[test]
fn a_second_axis_along_the_tool_is_refused() {
    // The table turns about y, and a head about the tool itself: that cannot tilt the tool.
    let head = "[[joint]]\nname = \"W\"\nkind = \"rotary\"\ncarries = \"tool\"\nparent = \"Z\"\ndirection = [0, 0, 1]\n\
                point_mm = [0, 0, 0]\nsense = 1\n\n[spindle]";
    let text = GOOD.replacen("[spindle]", head, 1).replacen("on = \"Z\"", "on = \"W\"", 1);
    let text = text.replacen("name = \"C\"\n", "name = \"C\"\nheld = true\n", 1);
    let e = refusal(&text);
    assert_eq!(e.code, "machine-tool-on-axis", "{e}");
    let six = GOOD.replacen("[spindle]", head, 1).replacen("on = \"Z\"", "on = \"W\"", 1);
    let six = Machine::from_text(Path::new("m.toml"), &six).expect("three rotary joints are solved numerically");
    assert!(!six.has_closed_form());
    let remarks = six.diagnose();
    assert!(remarks.iter().any(|d| d.code == "machine-numerical-inverse" && d.key == "joint.W"), "{remarks:?}");
    // Three axes of which all are parallel to the tool or to each other swing it in one plane.
    let flat = text.replacen("name = \"C\"\nheld = true\n", "name = \"C\"\n", 1).replacen(
        "direction = [0, 1, 0]\npoint_mm",
        "direction = [0, 0, 1]\npoint_mm",
        1,
    );
    let e = refusal(&flat);
    assert_eq!((e.code, e.key.as_str()), ("machine-parallel-rotary-axes", "joint.W.direction"), "{e}");
}

#[test]
fn limits_must_stand_upright() {
    expect("[-100, 100]", "[100, -100]", "machine-limits-upside-down", "travel_mm = [100", "lower end first");
    expect("[-10, 105]", "[105, 105]", "machine-limits-upside-down", "travel_deg", "must be below");
    expect("= 100\n", "= -100\n", "machine-not-positive", "max_velocity_deg_s", "above zero");
    expect("= 100\n", "= 100\nrapid_velocity_deg_s = 200\n", "machine-limits-upside-down", "rapid", "rapid velocity");
    expect("[-10, 105]", "[-10, 105]\nhome_deg = 200", "machine-home-outside", "home_deg", "outside the travel");
    expect(
        "travel_deg = [-10, 105]",
        "travel_deg = [-10, 105]\nendless = true",
        "machine-endless",
        "endless",
        "end stops",
    );
    expect("cycle_time_ms = 2", "cycle_time_ms = 0", "machine-not-positive", "cycle_time_ms", "0");
    expect("start_time_s = 1", "start_time_s = inf", "input-out-of-range", "start_time_s", "inf");
}

/// Every message with a value gives it in the unit of its key, as it is written.
#[test]
fn values_are_reported_in_the_unit_of_their_key() {
    for (old, new, code, at_line, expected) in [
        ("[-10, 105]", "[120, -120]", "machine-limits-upside-down", "travel_deg", "120 to -120 degrees"),
        ("[-100, 100]", "[250, -250]", "machine-limits-upside-down", "travel_mm", "250 to -250 mm"),
        ("[-10, 105]", "[-10, 105]\nhome_deg = 200", "machine-home-outside", "home_deg", "position 200 degrees"),
        (
            "[-10, 105]",
            "[-10, 105]\ntool_change_deg = -45.5",
            "machine-home-outside",
            "tool_change_deg",
            "position -45.5 degrees",
        ),
        ("[-100, 100]", "[-100, 100]\nhome_mm = 150", "machine-home-outside", "home_mm", "position 150 mm"),
        (
            "= 100\n",
            "= 100\nrapid_velocity_deg_s = 200\n",
            "machine-limits-upside-down",
            "rapid",
            "rapid_velocity_deg_s = 200 is above max_velocity_deg_s = 100",
        ),
    ] {
        expect(old, new, code, at_line, expected);
    }
}

#[test]
fn bodies_must_have_a_shape() {
    expect("max_mm = [1, 1, 0]", "max_mm = [1, 1, -2]", "machine-empty-body", "[[body.box]]", "empty");
    expect("check = true\n", "check = true\nnode = \"Table\"\n", "machine-model", "node", "no model file");
    expect("check = true\n", "check = true\ncolor = [1, 2]\n", "machine-color", "color", "red, green, blue");
    let missing = "name = \"test\"\nmodel = \"none.glb\"\n";
    expect("name = \"test\"\n", missing, "machine-model", "none.glb", "cannot open folder/none.glb");
    let prism = "[[body.prism]]\nalong = \"z\"\nrange_mm = [0, 1]\noutline_mm = [[0, 0], [0, 1], [1, 0]]\n";
    let text = format!("{GOOD}{prism}");
    assert!(refusal(&text).to_string().contains("counter-clockwise"));
    let second = "[[body]]\nname = \"plate\"\nrole = \"x\"\nattached_to = \"base\"\ncheck = true\n";
    assert_eq!(refusal(&format!("{GOOD}{second}")).code, "machine-duplicate-body");
}

#[test]
fn notes_must_be_about_numbers_of_their_table() {
    let note = "start_time_s = 1\n\n[spindle.chosen]\nmax_sped_rpm = \"why\"";
    expect("start_time_s = 1", note, "input-unknown-key", "max_sped_rpm", "does not have");
}

#[test]
fn missing_files_are_named() {
    let e = Machine::read(Path::new("/nowhere/machine.toml")).expect_err("missing");
    assert!(e.to_string().contains("/nowhere/machine.toml"), "{e}");
}

/// No input may bring the reader down: every single line left out or doubled, and the file cut at every byte.
#[test]
fn damaged_files_never_panic() {
    let lines: Vec<&str> = GOOD.lines().collect();
    for k in 0..lines.len() {
        for copies in [0, 2] {
            let text: String = lines
                .iter()
                .enumerate()
                .flat_map(|(i, l)| std::iter::repeat_n(format!("{l}\n"), if i == k { copies } else { 1 }))
                .collect();
            let _ = Machine::from_text(Path::new("m.toml"), &text);
        }
    }
    for whole in [GOOD.to_owned(), on_legs(), format!("{GOOD}\n[errors.constant]\nEX0C_um = 5\n")] {
        for cut in (0..whole.len()).filter(|&c| whole.is_char_boundary(c)) {
            if let Ok(machine) = Machine::from_text(Path::new("m.toml"), &whole[..cut]) {
                let _ = machine.diagnose();
            }
        }
    }
}

/// The good file with its B and Z tied together on three legs: Z heaves, B tilts.
fn on_legs() -> String {
    let platform = "\n[[platform]]\nname = \"P\"\nkind = \"3-RPS\"\nheave = \"U\"\ntilt = \"B\"\nfixed_radius_mm = 220\n\
         moving_radius_mm = 150\nheight_mm = 400\nleg_1_direction = [1, 0, 0]\n\
         [[platform.leg]]\nname = \"L1\"\ntravel_mm = [300, 600]\n[[platform.leg]]\nname = \"L2\"\n[[platform.leg]]\nname = \"L3\"\n";
    let heave = "[[joint]]\nname = \"U\"\nkind = \"linear\"\ncarries = \"workpiece\"\nparent = \"base\"\ndirection = [0, 0, 1]\n\n\
         [[joint]]\nname = \"B\"";
    let text = GOOD.replacen("[[joint]]\nname = \"B\"", heave, 1);
    let text = text.replacen(
        "carries = \"workpiece\"\nparent = \"base\"\ndirection = [0, 1, 0]",
        "carries = \"workpiece\"\nparent = \"U\"\ndirection = [0, 1, 0]",
        1,
    );
    text + platform
}

#[track_caller]
fn expect_in(text: &str, old: &str, new: &str, code: &str, at_line: &str, part: &str) {
    assert!(text.contains(old), "{old}");
    let text = text.replacen(old, new, 1);
    let e = refusal(&text);
    let shown = e.to_string();
    assert_eq!(e.code, code, "{shown}");
    let line = text.lines().nth(e.line - 1).unwrap_or_default();
    assert!(line.contains(at_line), "{shown}\npoints at {line:?}");
    assert!(shown.contains(part) && !e.remedy.is_empty(), "{shown}");
}

#[test]
fn platforms_must_be_complete_and_square() {
    let good = on_legs();
    let machine = Machine::from_text(Path::new("m.toml"), &good).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(machine.platforms[0].legs[2].name, "L3");
    let c = "machine-platform";
    expect_in(&good, "heave = \"U\"", "heave = \"Q\"", c, "heave", "no joint \"Q\"");
    expect_in(&good, "heave = \"U\"", "heave = \"B\"", c, "heave", "not linear");
    expect_in(&good, "heave = \"U\"", "heave = \"X\"", c, "tilt", "is not the heave joint");
    expect_in(
        &good,
        "leg_1_direction = [1, 0, 0]",
        "leg_1_direction = [0, 1, 0]",
        c,
        "leg_1_direction",
        "0.000000 degrees",
    );
    expect_in(
        &good,
        "leg_1_direction = [1, 0, 0]",
        "leg_1_direction = [1, 1, 0]",
        "machine-not-unit",
        "leg_1",
        "1.414213562",
    );
    expect_in(&good, "height_mm = 400", "height_mm = -400", "machine-not-positive", "height_mm", "-400");
    expect_in(&good, "height_mm = 400", "height = 400", "input-unit-missing", "height = 400", "write `height_mm`");
    expect_in(&good, "[[platform.leg]]\nname = \"L3\"\n", "", c, "", "2 legs");
    expect_in(&good, "name = \"L3\"", "name = \"L1\"", c, "L1", "taken");
    expect_in(&good, "name = \"L3\"", "name = \"X\"", c, "X", "taken");
    expect_in(&good, "[300, 600]", "[600, 300]", "machine-limits-upside-down", "travel_mm", "shortest length");
    expect_in(&good, "kind = \"3-RPS\"", "kind = \"6-UPS\"", "input-unknown-word", "6-UPS", "3-RPS");
}

#[test]
fn errors_must_have_a_name_a_unit_and_a_meaning() {
    let with = |text: &str| format!("{GOOD}\n{text}");
    let constant = |line: &str| with(&format!("[errors.constant]\n{line}\n"));
    let good = constant("EX0C_um = 5\nEA0B_urad = 3\nEC0Y_arcsec = 1\nEB0S_urad = 2\nEZ0Z_mm = 0.01");
    let machine = Machine::from_text(Path::new("m.toml"), &good).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(machine.errors.constant.len(), 5);
    let n = "machine-error-name";
    for (line, code, part) in [
        ("EX0Q_um = 5", n, "no joint \"Q\""),
        ("EX0C = 5", n, "ends in its unit"),
        ("EX0C_urad = 5", n, "shifts"),
        ("EA0C_um = 5", n, "turns"),
        ("EXC_um = 5", n, "[[errors.table]]"),
        ("FX0C_um = 5", n, "begins with E"),
        ("EZ0C_um = 5", n, "along the axis of C"),
        ("EY0X_um = 5", n, "no place across"),
        ("EX0C_mm = 50", "machine-error-value", "the limit is 5 mm"),
        ("EX0C_um = nan", "input-out-of-range", "nan"),
    ] {
        expect_in(&constant(line), line, line, code, line.split(' ').next().unwrap_or(""), part);
    }
    let table = |lines: &str| with(&format!("[[errors.table]]\n{lines}\n"));
    let t = "machine-error-table";
    let values = "[errors.table.values]\nEXX_um = [0, 1]";
    for (lines, code, at, part) in [
        (format!("joint = \"Q\"\nat_mm = [0, 1]\n{values}"), t, "Q", "no joint"),
        (format!("joint = \"X\"\nat_deg = [0, 1]\n{values}"), t, "at_deg", "write at_mm"),
        (format!("joint = \"X\"\n{values}"), t, "X", "no at_mm"),
        (format!("joint = \"X\"\nat_mm = [1, 0]\n{values}"), t, "at_mm", "growing"),
        (format!("joint = \"X\"\nat_mm = [0, 1, 2]\n{values}"), t, "EXX_um", "2 values for 3 positions"),
        (format!("joint = \"Y\"\nat_mm = [0, 1]\n{values}"), n, "EXX_um", "that of joint Y"),
        ("joint = \"C\"\nat_deg = [0, 90]".to_owned(), t, "at_deg", "does not close"),
    ] {
        expect_in(&table(&lines), &lines, &lines, code, at, part);
    }
}

/// Values that are numbers and look like another unit are reported with their line.
#[test]
fn remarks_name_line_and_remedy() {
    let text = GOOD.replacen("travel_deg = [-10, 105]", "travel_deg = [-0.17, 1.83]", 1).replacen(
        "travel_mm = [-100, 100]",
        "travel_mm = [-100, 100]\nmax_velocity_mm_min = 900_000",
        1,
    );
    let machine = Machine::from_text(Path::new("m.toml"), &text).expect("readable");
    let all = machine.diagnose();
    let line = |d: &proveout_machine::Diagnosis| text.lines().nth(d.line.max(1) - 1).unwrap_or_default();
    let find = |code: &str, key: &str| {
        let found = all.iter().find(|d| d.code == code && d.key == key);
        found.unwrap_or_else(|| panic!("{code} {key}: {all:?}"))
    };
    assert!(line(find("machine-implausible-value", "joint.B.travel_deg")).contains("-0.17"));
    assert!(line(find("machine-implausible-value", "joint.X.max_velocity_mm_min")).contains("900_000"));
    let missing = find("machine-missing-limit", "joint.Y.travel_mm");
    assert!(text.lines().skip(missing.line - 1).take(2).any(|l| l.contains("\"Y\"")), "{missing:?}");
    assert!(all.iter().all(|d| d.line > 0 && !d.remedy.is_empty() && !d.message.is_empty()), "{all:?}");
    // Y and Z carry no body; the plate is carried by C, which B moves as well.
    for (joint, expected) in [("Y", true), ("Z", true), ("B", false), ("C", false)] {
        let key = format!("joint.{joint}");
        assert_eq!(all.iter().any(|d| d.code == "machine-joint-without-body" && d.key == key), expected, "{joint}");
    }
    let legs = Machine::from_text(Path::new("m.toml"), &on_legs()).expect("readable").diagnose();
    assert!(legs.iter().any(|d| d.key == "platform.P.leg.L2.travel_mm"), "{legs:?}");
}
