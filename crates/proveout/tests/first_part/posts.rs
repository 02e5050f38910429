//! Programs in the manner of the posts of eight CAM systems, each from its text to a verdict by what is
//! proposed: no finding that the machine, the stock or the place of the zero would cause.

use std::fs;

use super::desk::{Desk, believable, gate, open_by_setup_alone, root};

/// Program, call after its name, words of the output, box of the stock (mm; 1 mm more or less).
struct Case {
    file: &'static str,
    call: &'static str,
    expected: &'static [&'static str],
    stock: Option<[f64; 6]>,
}

fn case(case: &Case) {
    let desk = Desk::new(&[]);
    let name = case.file;
    fs::copy(root().join("tests/first-part/posts").join(name), desk.path(name)).expect("copied");
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"proposed\"\n");
    let states_stock = case.stock.is_none();
    if states_stock {
        desk.write("answers.toml", "holder = \"40x60\"\n");
    }
    let output = desk.done(&format!("new {name} {} --answers answers.toml --output part", case.call));
    for word in case.expected {
        assert!(output.contains(word), "{name}: {word:?} is not in:\n{output}");
    }
    if let Some(expected) = case.stock {
        let line = output.lines().find(|l| l.starts_with("stock: X ")).expect("the stock");
        let numbers: Vec<f64> =
            line.split(" mm (").next().unwrap_or_default().split([' ', ',']).filter_map(|w| w.parse().ok()).collect();
        let expected = [expected[0], expected[3], expected[1], expected[4], expected[2], expected[5]];
        assert_eq!(numbers.len(), 6, "{line}");
        for (found, wanted) in numbers.iter().zip(expected) {
            assert!((found - wanted).abs() <= 1.0, "{name}: {line}, {wanted} is expected");
        }
    }
    let output = desk.done("check part");
    assert!(!output.contains("before the run"), "{name}:\n{output}");
    let verdict = desk.verdict("part");
    believable(&verdict);
    assert_eq!(gate(&verdict, "limits").0, "pass", "{}: {:?}", case.file, gate(&verdict, "limits"));
    for name in ["collision", "near_miss"] {
        open_by_setup_alone(&verdict, name);
    }
}

#[test]
#[ignore = "nightly, 61 s"]
fn fusion_for_a_haas_in_inch_with_the_zero_at_home() {
    case(&Case {
        file: "fusion-haas.nc",
        call: "--machine three-axis-mill",
        expected: &[
            "unit: inch",
            "tool T4: chamfer D9.525",
            "tool T6: tap D6.35",
            "assumed: Z is sent to 0 of the machine (G53, SUPA or M91, lines 13,",
            "zero = \"home\"",
        ],
        // The contour runs round a plate of 4 x 3 inches, faced at its zero; the widest path is that of the
        // contour's ends.
        stock: Some([-27.0, -24.5, -18.0, 113.5, 88.0, 1.0]),
    });
}

#[test]
#[ignore = "nightly, 29 s"]
fn mastercam_for_a_fanuc_in_millimeters() {
    case(&Case {
        file: "mastercam-fanuc.nc",
        call: "--machine three-axis-mill",
        expected: &["tool T4: ball D6", "tool T9: drill D8.5", "tool T1: flat D12"],
        stock: Some([-64.0, -56.0, -18.5, 61.0, 41.0, 0.0]),
    });
}

#[test]
fn hsmworks_for_a_universal_haas_with_dwo_and_tcpc() {
    case(&Case {
        file: "hsmworks-umc.nc",
        call: "--machine haas-umc-750",
        expected: &["rotary axis B: -11.999 to 30.000", "tool center point control", "tool T2: ball D6"],
        stock: Some([-56.0, -49.0, -18.5, 56.0, 49.0, 0.0]),
    });
}

#[test]
fn nx_for_an_840d_with_vectors() {
    case(&Case {
        file: "nx-840d.mpf",
        call: "--machine spinner-u5-620",
        expected: &["unit: mm (G710", "\"BALL_D8\": ball D8", "tool center point control"],
        stock: Some([-49.0, -29.0, -5.0, 49.0, 29.0, 0.0]),
    });
}

#[test]
#[ignore = "nightly, 24 s"]
fn hypermill_for_a_tnc_with_plane_and_m128() {
    case(&Case {
        file: "hypermill-tnc.h",
        call: "--machine bc-trunnion",
        expected: &[
            "BLK FORM",
            "work offset PRESET1",
            "tool T13: drill D6.8",
            "assumed: Z is sent to -10 of the machine",
        ],
        stock: None,
    });
}

#[test]
fn powermill_for_a_fanuc_with_its_tools_in_lines_of_their_own() {
    case(&Case {
        file: "powermill-fanuc.tap",
        call: "--machine ac-trunnion-620",
        expected: &["tool T1: bull_nose D12", "tool T2: ball D8", "comments up to line"],
        stock: Some([-71.0, -41.0, -5.0, 71.0, 41.0, 0.0]),
    });
}

#[test]
fn freecad_for_a_linuxcnc() {
    case(&Case {
        file: "freecad-linuxcnc.ngc",
        call: "--machine three-axis-mill",
        expected: &["linuxcnc", "tool T1: flat D6", "tool T2: drill D5"],
        stock: Some([3.0, 3.0, -12.5, 77.0, 57.0, 0.0]),
    });
}

#[test]
fn fusion_for_a_mazak_with_two_t_words_and_g68_2() {
    case(&Case {
        file: "fusion-mazak.eia",
        call: "--machine variaxis-i600-type --control mazak-eia",
        expected: &["control \"Mazak", "tool T8: drill D10", "zero = \"home\""],
        // The face, and the depth of the tilted holes.
        stock: Some([-90.0, -45.0, -32.0, 90.0, 55.0, 0.0]),
    });
}

/// The machine file names no control, and the text names one.
#[test]
fn words_of_another_control_are_a_hint_and_never_a_choice() {
    let desk = Desk::new(&[]);
    for name in ["fusion-mazak.eia", "fusion-okuma.min"] {
        fs::copy(root().join("tests/first-part/posts").join(name), desk.path(name)).expect("copied");
    }
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"proposed\"\n");
    let call = |name: &str| format!("new {name} --machine bc-trunnion --answers answers.toml --output of-{name}");
    let output = super::desk::printed(&desk.call(&call("fusion-mazak.eia")));
    assert!(
        output.contains("G61.1 in line") && output.contains("--control mazak-eia or --control mitsubishi-m800"),
        "{output}"
    );
    desk.refused(&call("fusion-okuma.min"), &["G15H in line", "--control okuma-osp reads the program that way"]);
}

#[test]
fn fusion_for_an_okuma() {
    case(&Case {
        file: "fusion-okuma.min",
        call: "--machine three-axis-mill --control okuma-osp",
        expected: &["control \"Okuma OSP\"", "tool T2: drill D6.8"],
        stock: Some([-25.0, -25.0, -20.5, 100.0, 70.0, 0.0]),
    });
}

#[test]
fn fusion_for_a_tnc_on_three_axes() {
    case(&Case {
        file: "fusion-tnc.h",
        call: "--machine three-axis-mill",
        expected: &["tool T5: drill D8", "tool T10: flat D10", "tool T23: face_mill D50", "BLK FORM"],
        stock: None,
    });
}

#[test]
fn fusion_for_an_828d_with_cycles() {
    case(&Case {
        file: "fusion-828d.mpf",
        call: "--machine three-axis-mill",
        expected: &["siemens-840d", "T2", "assumed: Z is sent to 0 of the machine"],
        stock: Some([-15.0, 0.0, -16.0, 95.0, 59.0, 1.5]),
    });
}

/// The cycles of a probe stay on the control.
#[test]
fn a_probe_is_left_out_by_a_control_file_with_its_reason() {
    let desk = Desk::new(&[]);
    desk.write(
        "probe.nc",
        "%\nO112 (PROBE AND FACE)\n(T1 D=3. CR=0. - ZMIN=0. - FACE MILL)\n(T20 D=0.2362 - PROBE)\nG90 G94 G17\nG20\nG53 G0 Z0.\nT20 M6\nG54\n\
         G0 X2. Y1.5\nG43 Z1. H20\nG65 P9832\nG65 P9810 Z0.25 F100.\nG65 P9811 Z0. S1.\nG65 P9810 Z1.\nG53 G0 Z0.\nT1 M6\nS1500 M3\nG54\n\
         G0 X-1.7 Y1.5\nG43 Z1. H1\nG0 Z0.2\nG1 Z-0.02 F30.\nX5.7 F50.\nG0 Z1.\nG53 G0 Z0.\nM30\n%\n",
    );
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-0.6,4,3,0 inch\"\n");
    let call = "new probe.nc --machine three-axis-mill --answers answers.toml --output part";
    let output = desk.call(call);
    let text = super::desk::printed(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("`O9810` not found") && text.contains("missing_reason = \"probing\""), "{text}");
    // What the help says, as it is typed.
    desk.write(
        "shop.toml",
        "inherits = \"haas-ngc\"\nsubprograms = { missing = \"note\", missing_reason = \"probing\" }\n",
    );
    desk.done(&format!("{call} --control shop.toml"));
    // Left out is what the control file asks for: a note before the run, and no error.
    let text = desk.done("check part");
    assert!(text.contains("in order") && text.contains("note: line 12"), "{text}");
    let verdict = desk.verdict("part");
    let findings = verdict["findings"].as_array().expect("findings");
    assert!(findings.iter().all(|f| f["severity"] != "error"), "{findings:?}");
    // The face is cut, and what was left out keeps every gate from passing.
    assert!(verdict["removal"]["volume_mm3"].as_f64().expect("a volume") > 1000.0, "{}", verdict["removal"]);
    for name in ["program", "limits"] {
        let (state, reason) = gate(&verdict, name);
        assert!(state == "unchecked", "{name}: {state}: {reason}");
    }
}
