//! Values, loops and calls without bound: refused by name, or the program ends with its line.

use std::time::Duration;

use crate::hostile::workshop::{PROGRAM, Workshop};

/// Values of scene, machine and tools that no workshop has: file, the text there, what replaces it, what
/// is reported.
const MAGNITUDES: [(&str, &str, &str, [&str; 2]); 12] = [
    ("scene.toml", "max_mm = [20, 20, 0]", "max_mm = [20, 1e18, 0]", ["1e18", "-100000 to 100000"]),
    ("scene.toml", "max_mm = [20, 20, 0]", "max_mm = [20, 1e6, 0]", ["`stock.box.max_mm[1]`", "-100000 to 100000"]),
    ("scene.toml", "Z_mm = 140", "Z_mm = 1e9", ["1e9", "-100000 to 100000"]),
    ("scene.toml", "Z_mm = 140", "Z_mm = nan", ["nan", "-100000 to 100000"]),
    ("scene.toml", "resolution_mm = 1.0", "resolution_mm = 1e-9", ["1e-9", "0.00001 to 1000"]),
    ("scene.toml", "[stock]", "[run_limits]\nblocks = 0\n[stock]", ["`run_limits.blocks` = 0", "1 to 4294967295"]),
    ("machine/machine.toml", "cycle_time_ms = 2", "cycle_time_ms = 1e-4", ["1e-4", "0.01 to 100"]),
    ("machine/machine.toml", "tool_change_time_s = 6", "tool_change_time_s = 1e300", ["1e300", "0 to 3600"]),
    ("machine/machine.toml", "radius_mm = ", "radius_mm = 1e18 # ", ["1e18", "-100000 to 100000"]),
    ("machine/machine.toml", "cycle_time_ms = 2", "cycle_time_ms = inf", ["inf", "0.01 to 100"]),
    ("tools.toml", "gauge_length_mm = ", "gauge_length_mm = 1e18 # ", ["1e18", "-100000 to 100000"]),
    ("tools.toml", "diameter_mm = ", "diameter_mm = 1e9 # ", ["1e9", "-100000 to 100000"]),
];

#[test]
fn quantities_out_of_range_are_refused_with_the_range() {
    for (file, from, to, words) in MAGNITUDES {
        let shop = Workshop::new();
        shop.replace(file, from, to);
        let output = shop.refused(&words);
        assert!(output.text.contains(file), "the place: {}", output.text);
        assert!(output.wall < Duration::from_secs(20), "{to}: {:?}", output.wall);
    }
}

/// Programs that would not end, or would fill the memory: what replaces a line of the program, the line
/// that is reported, and words.
const ENDLESS: [(&str, u32, &str); 6] = [
    ("G0 X1000000", 5, "more than 10 travels past its travel"),
    ("G0 X10000000", 5, "more than 10 travels past its travel"),
    ("G1 X100 F0.01", 5, "the limit for one motion is"),
    ("G4 F999999", 5, "simulated time"),
    ("G1 Z45 F500\nG2 X10 Y0 I5 J0 TURN=999 F500\nG1", 6, "the limit for one motion is"),
    ("G1 Z45 F100\nR1=0\nWHILE R1<100000\nG4 F3600\nR1=R1+1\nENDWHILE", 8, "simulated time"),
];

#[test]
fn motion_without_measure_ends_the_program_by_name() {
    for (text, line, words) in ENDLESS {
        let shop = Workshop::new();
        shop.write("program.mpf", PROGRAM.replace("G1 Z-2 F500\n", &format!("{text}\n")));
        let output = shop.run();
        assert_eq!(output.code(), Some(1), "{text}: {}", output.text);
        let verdict: serde_json::Value = serde_json::from_str(&shop.read("result/verdict.json")).expect("JSON");
        let all = verdict["findings"].as_array().expect("findings");
        let found: Vec<_> = all.iter().filter(|f| f["code"] == "program-stopped").collect();
        assert_eq!(found.len(), 1, "{text}: {all:?}");
        assert_eq!(found[0]["line"], line, "{text}: {found:?}");
        assert!(found[0]["message"].as_str().expect("text").contains(words), "{text}: {found:?}");
        assert!(!all.iter().any(|f| f["code"] == "process-rapid-in-material"), "nothing behind it runs: {all:?}");
    }
}

/// A machine within all ranges whose motion has twelve million control cycles: each joint is there in no time
/// by its speed, and takes two minutes by its acceleration.
#[test]
fn joints_too_slow_for_their_cycle_end_the_program() {
    for (mode, motion) in
        [("straight", "G0 X100"), ("independent", "G0 X100"), ("straight", "G64\nG1 X50 F5000\nX100 Y20")]
    {
        let shop = Workshop::new();
        shop.replace("machine/machine.toml", "cycle_time_ms = 2", "cycle_time_ms = 0.01");
        shop.replace("machine/machine.toml", "max_acceleration_mm_s2 = ", "max_acceleration_mm_s2 = 0.1 # ");
        let text = shop.read("machine/machine.toml");
        let modes = ["straight", "independent"].map(|mode| format!("rapid_mode = \"{mode}\""));
        let from = modes.iter().find(|m| text.contains(*m)).expect("a mode of rapid motion");
        shop.replace("machine/machine.toml", from, &format!("rapid_mode = \"{mode}\""));
        shop.write(
            "program.mpf",
            format!("G17 G54 G90 G94 G710\nG0 X-364.99\n{motion}\nG4 F1\nM3 S1000\nG0 X-300\nM30\n"),
        );
        let output = shop.run();
        assert_eq!(output.code(), Some(1), "{motion}: {}", output.text);
        let verdict: serde_json::Value = serde_json::from_str(&shop.read("result/verdict.json")).expect("JSON");
        let all = verdict["findings"].as_array().expect("findings");
        let found: Vec<_> = all.iter().filter(|f| f["code"] == "program-stopped").collect();
        assert_eq!(found.len(), 1, "{mode} {motion}: {all:?}");
        assert!(found[0]["message"].as_str().expect("text").contains("two million control cycles"), "{found:?}");
        let line = if motion.starts_with("G64") { 4 } else { 3 };
        assert_eq!(found[0]["line"], line, "{found:?}");
        let total = verdict["time"]["total_s"].as_f64().expect("time");
        assert!(total < 60.0, "nothing behind it runs: {total} s");
        let bound = verdict["time"]["lower_bound_s"].as_f64().unwrap_or_default();
        assert!(bound <= total, "{bound} s of {total} s");
    }
}

#[test]
fn over_travel_alone_goes_on() {
    let shop = Workshop::new();
    shop.write("program.mpf", PROGRAM.replace("X10\n", "G0 X900\nG0 Z-15\nX0\n"));
    let output = shop.run();
    let verdict = shop.read("result/verdict.json");
    assert_eq!(output.code(), Some(1), "{}", output.text);
    assert!(verdict.contains("limits-overtravel") && verdict.contains("process-rapid-in-material"), "{verdict}");
    assert!(!verdict.contains("program-stopped"), "{verdict}");
}

#[test]
fn limits_of_the_scene_end_a_program() {
    let shop = Workshop::new();
    shop.scene("[run_limits]\nsimulated_time_s = 5");
    let output = shop.run();
    assert_eq!(output.code(), Some(1), "{}", output.text);
    assert!(shop.read("result/verdict.json").contains("past the limit of 5 s"), "{}", output.text);
    shop.scene("[run_limits]\nblocks = 4");
    let output = shop.refused(&["the program has run 4 blocks", "program.mpf:4"]);
    assert!(output.text.contains("[run_limits]"), "the remedy: {}", output.text);
}

#[test]
#[ignore = "nightly, 59 s"]
fn loops_with_motion_and_no_end_stop_with_their_line() {
    let loops = [
        ("a.mpf", "siemens-840d", "G0 X0\nF100 S100 M3\nLOOP\nG1 X1\nX0\nENDLOOP\nM30\n", "a.mpf:6"),
        ("a.mpf", "siemens-840d", "AGAIN:\nG0 X1\nX0\nGOTOB AGAIN\nM30\n", "a.mpf:4"),
        ("a.nc", "fanuc", "O1\nWHILE[1EQ1]DO1\nG0X1.\nX0\nEND1\nM30\n", "a.nc:5"),
        ("a.nc", "fanuc", "O1\nN10G0X1.\nX0\nGOTO10\nM30\n", "a.nc:4"),
        ("a.ngc", "linuxcnc", "o1 while [1]\ng0 x1\nx0\no1 endwhile\nm2\n", "a.ngc:4"),
        (
            "a.h",
            "heidenhain",
            "BEGIN PGM A MM\nLBL 1\nL X+1 FMAX\nL X+0 FMAX\nFN 9: IF +1 EQU +1 GOTO LBL 1\nEND PGM A MM\n",
            "a.h:5",
        ),
    ];
    let shop = Workshop::new();
    for (name, dialect, text, place) in loops {
        shop.write(name, text);
        let output = shop.call(&["check", name, "--dialect", dialect]);
        assert_eq!(output.code(), Some(2), "{dialect}: {}", output.text);
        assert!(
            output.text.contains(place) && output.text.contains("which is the limit"),
            "{dialect}: {}",
            output.text
        );
    }
}

#[test]
fn wrong_calls_are_answered_at_once() {
    let shop = Workshop::new();
    let output = shop.call(&["run", ".", "--threads", "10000", "--rerun", "off"]);
    assert_eq!(output.code(), Some(2));
    assert!(output.text.contains("the maximum is 512"), "{}", output.text);
    let output = shop.call(&["run", ".", "--rerun", "connect"]);
    // Where a viewer happens to run, the run goes on.
    assert!(output.code() != Some(2) || output.text.contains("no viewer answers"), "{}", output.text);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("nowhere/at/all", shop.path().join("gone")).expect("linked");
        let output = shop.call(&["run", ".", "--output", "gone", "--rerun", "off"]);
        assert_eq!(output.code(), Some(2));
        assert!(output.text.contains("is a link to nowhere/at/all"), "{}", output.text);
    }
}

#[test]
fn a_spindle_without_speed_does_not_cut() {
    for spindle in ["M3", "S0 M3", "M4 S0"] {
        let shop = Workshop::new();
        shop.write("program.mpf", PROGRAM.replace("S1000 M3", spindle));
        let output = shop.run();
        assert_eq!(output.code(), Some(1), "{spindle}: {}", output.text);
        let verdict: serde_json::Value = serde_json::from_str(&shop.read("result/verdict.json")).expect("JSON");
        let process =
            verdict["gates"].as_array().expect("gates").iter().find(|g| g["name"] == "process").expect("gate");
        assert_eq!(process["state"], "fail", "{spindle}: {process}");
        assert!(process["reason"].as_str().expect("text").contains("process-spindle-off"), "{spindle}: {process}");
    }
}
