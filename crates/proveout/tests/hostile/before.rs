//! Inputs on which the program once hung, aborted, panicked or took all memory, as they were found, or as a
//! generator where they are larger than a few lines. Each ends now with a code of the program, within 20 s of
//! a processor and 8 GiB, and says why.

use std::{fmt::Write as _, fs};

use crate::hostile::{
    meshes::glb,
    workshop::{HUNG, Workshop, proveout_within, root},
};

/// Time of a processor that a call may take, s.
const MOST_S: u64 = 20;

/// Calls the program in the workshop and asserts code and words.
#[track_caller]
fn ends(what: &str, shop: &Workshop, call: &[&str], codes: &[i32], words: &str) {
    let output = proveout_within(shop.path(), call, HUNG, MOST_S).unwrap_or_else(|| panic!("{what}: hangs"));
    let verdict = fs::read_to_string(shop.path().join("result/verdict.json")).unwrap_or_default();
    assert!(!output.text.contains("panicked"), "{what}: {}", output.text);
    assert!(output.code().is_some_and(|code| codes.contains(&code)), "{what}: {:?} {}", output.status, output.text);
    assert!(output.text.contains(words) || verdict.contains(words), "{what}: {words:?} is not in {}", output.text);
}

const RUN: [&str; 7] = ["run", ".", "--output", "result", "--rerun", "off", "--threads=1"];

/// Programs for the small block: text, and what is reported. They took up to 9.7 GB, or did not end.
const PROGRAMS: [(&str, &str); 10] = [
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\" CYCLE800()\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nM128\nG2 X5 Y-5 I-5 J-5\n\
         G0 Z4294967296\nM30\n",
        "",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X360000 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nM30\n",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z2147483648 F500\nX15 Y5\nG2 X5 Y-5 I-5 J-5\nG0 Z50\nM30\n\
         \u{20}M98 P1\n",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nG2 X5 Y-5 I-5 J-5\n\
         G0 Z99999999999999999999\nM30\n",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nG2 X5 Y-5 I-5 J-5\nG0 Z2147483648\nM30",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X9223372036854775808 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nG0 Z50\nM30\n",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X4294967296 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nG0 Z50\nM30\n",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X99999999999999999999 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y5\nG2 X5 Y-5 I-5 J-5\n\
         G0 Z50\nO360000 ENDWHILE\nM30\n",
        "",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z-5 F0.1\nX15 Y5\nG0 Z50\nM30\n",
        "program-stopped",
    ),
    (
        "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z-5 F500\nX15 Y0\nG2 X15 Y0 I-5 J0 TURN=999\nG0 Z50\nM30\n",
        "",
    ),
];

#[test]
fn programs_that_went_too_far() {
    for (text, words) in PROGRAMS {
        let shop = Workshop::new();
        shop.write("program.mpf", text);
        ends(text, &shop, &RUN, &[1, 2], words);
    }
}

/// A program of `LinuxCNC` whose first loop has no end: its condition depends on a name that the body does
/// not change.
fn endless(step: &str, behind: &str) -> String {
    format!(
        "; sub, loops, names\no100 sub\n  #<depth>=[#1/2]\n  o101 while [#<depth> gt 0]\n    g1 z[-#<depth>] f200\n  o101 endwhile\n\
         o100 endsub [5]\ng21 g90 g64 p0.01\nt1 m6 g43\ng0 x0 y0 z5\no100 call [6]\no102 if [#5220 eq 1]\n  g55\no102 else\n  g54\n\
         o102 endif\no103 repeat [3]\n  g91 x{step}\no103 endrepeat\ng90\n{behind}\nm2\n"
    )
}

#[test]
fn loops_without_end() {
    let shop = Workshop::new();
    shop.write("p.ngc", endless("1", "g5 i0 j3 p0 q-3 x1 y1\ng10 l2 p1 x1\ng38.2 z-10 f50\n(msg, done)"));
    let post = ["nc", "p.ngc", "--dialect", "linuxcnc", "--post", "haas"];
    ends("posted", &shop, &post, &[2], "p.ngc:6");
    shop.write("p.ngc", endless("1e308", "g5 i-0 j0.0000000001 p0 q-3 x1 y1\ng38.2 z-10 f50\ndone) (msg,"));
    let mut run = RUN.to_vec();
    run.extend(["--nc", "p.ngc", "--dialect", "linuxcnc"]);
    ends("run", &shop, &run, &[1, 2], "");
}

/// A five-axis program with its middle torn out: the tool goes from one end of it to the other in one block
/// at a feed of the flank.
#[test]
fn a_program_without_its_middle() {
    let shop = Workshop::new();
    let whole = fs::read_to_string(root().join("scenes/cone-frustum/bc.mpf")).expect("a program of the tree");
    let lines: Vec<&str> = whole.lines().collect();
    let behind = lines.iter().position(|l| l.starts_with("N24000 ")).expect("a block of the last turn");
    let torn: Vec<&str> = lines[..60].iter().chain(&lines[behind..behind + 150]).copied().collect();
    shop.write("program.mpf", torn.join("\n"));
    ends("torn", &shop, &RUN, &[3], "the text ends without M30 or M2");
}

/// Blocks at inverse time after a second `M6`, for a post that cannot name the tool.
#[test]
fn a_helix_for_a_control_without_tool_names() {
    let mut text = String::from(
        "G17\nT=\"BALL_D16\"\nM6\nD1\nG54\nS8000 M3\nM8\nCTOL=0.01 OTOL=-1 G645\nG0 A-170.476 B5\nTRAORI\nORIVECT\nX12 Y28 Z-17 A3=0.087 B3=0.165 \
         C3=-0.982\nG93\nG1 X11.7 Y29 Z-10 A3=0.087 B3=0.165 C3=-0.982 F100\n",
    );
    for k in 0..200 {
        let (sine, cosine) = (f64::from(k) * 0.03).sin_cos();
        let (y, z) = (30.0 * cosine, -30.0 * sine);
        writeln!(
            text,
            "X{:.4} Y{y:.4} Z{z:.4} A3=0.08715574 B3={cosine:.8} C3={:.8} F2003.4",
            11.7 - 0.001 * f64::from(k),
            -sine
        )
        .expect("text");
        if k == 100 {
            text.push_str("M6\n");
        }
    }
    let shop = Workshop::new();
    shop.write("p.mpf", text);
    ends("helix", &shop, &["nc", "p.mpf", "--post", "iso"], &[2], "BALL_D16");
}

/// Values of scene and machine: file, the text there, what replaces it, what is reported. They hung,
/// overflowed the stack, panicked, took 4 to 10 GB, or put numbers of 300 digits into the verdict.
const VALUES: [(&str, &str, &str, &str); 10] = [
    (
        "scene.toml",
        "[[program]]",
        "[[fixture]]\nname = \"pot\"\ncylinder = { base_mm = [0, 0, -140], radius_mm = 25, height_mm = 1.7e308 }\n[[program]]",
        "`fixture.pot.cylinder.height_mm` = 1.7e308: is out of range: -100000 to 100000",
    ),
    // As long as a stock may be. It was found at cells of 1 mm, where it takes 26 s of a processor now.
    (
        "scene.toml",
        "resolution_mm = 1.0\n\n[stock]\nbox = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }",
        "resolution_mm = 4.0\n\n[stock]\nbox = { min_mm = [-20, -20, -20], max_mm = [20, 1e5, 0] }",
        "contains a part of the stock",
    ),
    ("scene.toml", "file = \"program.mpf\"", "file = \"/dev/zero\"", "/dev/zero is not a file"),
    ("scene.toml", "Z_mm = 140", "Z_mm = 9223372036854775807", "is out of range: -100000 to 100000"),
    ("scene.toml", "Z_mm = 140", "Z_mm = -9223372036854775808", "is out of range: -100000 to 100000"),
    ("scene.toml", "Z_mm = 140", "Z_mm = 1e9", "is out of range: -100000 to 100000"),
    ("scene.toml", "resolution_mm = 1.0", "resolution_mm = 1e7", "is out of range: 0.00001 to 1000"),
    ("machine/machine.toml", "origin_mm = [0, 0, 0]", "origin_mm = [1e18, 0, 0]", "is out of range: -100000 to 100000"),
    ("machine/machine.toml", "radius_mm = ", "radius_mm = 1e18 # ", "is out of range: -100000 to 100000"),
    ("machine/machine.toml", "from_mm = [", "from_mm = [-1e6, 0, 0] # [", "is out of range: -100000 to 100000"),
];

#[test]
fn values_that_no_workshop_has() {
    for (file, from, to, words) in VALUES {
        let shop = Workshop::new();
        shop.replace(file, from, to);
        ends(to, &shop, &RUN, &[1, 2], words);
    }
}

/// Two changed bytes of a mesh: an attribute of a primitive names an accessor that is not there.
#[test]
fn a_mesh_whose_accessor_is_not_there() {
    for accessor in ["3", "4294967295"] {
        let json = format!(
            r#"{{"scene":0,"scenes":[{{"nodes":[0]}}],"asset":{{"version":"2.0"}},"accessors":[{{"componentType":5125,"type":"SCALAR",
            "bufferView":0,"count":36,"max":[7],"min":[0]}},{{"componentType":5126,"type":"VEC3","byteOffset":0,"bufferView":1,"count":8,
            "max":[18.0,18.0,-5.0],"min":[-18.0,-18.0,-20.0]}}],"meshes":[{{"name":"geometry_0","primitives":[{{"attributes":
            {{"POSITION":{accessor}}},"indices":0,"mode":4}}]}}],"nodes":[{{"name":"geometry_0","mesh":0}}],"buffers":[{{"byteLength":240}}],
            "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":144}},{{"buffer":0,"byteOffset":144,"byteLength":96}}]}}"#
        );
        let shop = Workshop::new();
        shop.scene("[part]\nmesh = \"part.glb\"\n");
        shop.write("part.glb", glb(&json, &[0; 240]));
        ends(accessor, &shop, &RUN, &[2], &format!("accessor {accessor} is not there"));
    }
    // The same as the model of a machine.
    let shop = Workshop::new();
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"bed","mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":4294967295}]}]}"#;
    shop.write("machine/model.glb", glb(json, &[]));
    shop.replace("machine/machine.toml", "up = [0, 0, 1]", "up = [0, 0, 1]\nmodel = \"model.glb\"");
    ends("model", &shop, &RUN, &[2], "model.glb");
}
