//! Laws that hold for every program: the same meaning however it is written, round trips, no panic and no
//! endless run.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proptest::prelude::*;
use proveout_nc::post::{Post, PostSettings, SiemensPost};
use proveout_nc::{AxisValues, Command, Dialect, Motion, Op, Program, Settings};

fn settings() -> Settings {
    let mut settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    // Small limits, so that endless loops of random texts end at once.
    settings.limits.max_loop_passes = 500;
    settings.limits.max_idle_passes = 100;
    settings.limits.max_array_elements = 1000;
    settings
}

fn ops(text: &str) -> Result<Vec<Op>, String> {
    Program::from_text("p.mpf", text, &settings())
        .map_err(|e| e.to_string())?
        .map(|c| c.map(|c| c.op).map_err(|e| format!("{} {}", e.code, e.message)))
        .collect()
}

/// A word of a motion block with a value in thousandths.
fn word(letter: char, thousandths: i32) -> String {
    let sign = if thousandths < 0 { "-" } else { "" };
    let value = thousandths.unsigned_abs();
    format!("{letter}{sign}{}.{:03}", value / 1000, value % 1000)
}

prop_compose! {
    /// Plain blocks: X and Y always, other words at will.
    fn block()(g in 0..2u8, x in -99999..99999i32, y in -99999..99999i32, z in prop::option::of(-9999..9999i32),
               b in prop::option::of(-90000..90000i32), f in prop::option::of(1..9999i32)) -> Vec<String> {
        let mut words = vec![format!("G{g}"), word('X', x), word('Y', y)];
        words.extend(z.map(|z| word('Z', z)));
        words.extend(b.map(|b| word('B', b)));
        words.extend(f.map(|f| word('F', f)));
        words
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn blanks_case_numbers_and_order_do_not_matter(blocks in prop::collection::vec(block(), 1..20), seed in any::<u64>()) {
        let plain: String = blocks.iter().map(|words| words.join(" ") + "\n").collect();
        let plain = format!("G0 X0 Y0 Z0 F100\n{plain}");
        let mut state = seed | 1;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let mut other = String::from("; head\n\nn1 g0x0y0z0f100\r\n");
        for (i, words) in blocks.iter().enumerate() {
            let mut words = words.clone();
            let at = random(words.len() as u64) as usize;
            words.rotate_left(at);
            if random(2) == 0 {
                other.push_str(&format!("N{} ", i * 10));
            }
            let text = words.join(["", " ", "\t "][random(3) as usize]);
            other.push_str(&if random(2) == 0 { text.to_lowercase() } else { text });
            other.push_str([" ; end\n", "\n", "  \r\n"][random(3) as usize]);
        }
        prop_assert_eq!(ops(&plain), ops(&other));
    }

    #[test]
    fn arcs_lie_on_their_circle(
        x in -50.0..50.0f64, y in -50.0..50.0f64, radius in 0.5..80.0f64, from in 0.0..360.0f64, turn in 1.0..359.0f64,
        clockwise in any::<bool>(), rot in prop::array::uniform3(-180.0..180.0f64), plane in 0..3usize,
    ) {
        // A circle of known center, written with the three decimals of shop programs, in a turned and shifted
        // frame.
        let point = |degrees: f64| [x + radius * degrees.to_radians().cos(), y + radius * degrees.to_radians().sin()];
        let round = |v: f64| (v * 1000.0).round() / 1000.0;
        let start = point(from).map(round);
        let end = point(if clockwise { from - turn } else { from + turn }).map(round);
        let letters = [["X", "Y", "I", "J"], ["Z", "X", "K", "I"], ["Y", "Z", "J", "K"]][plane];
        let text = format!(
            "G{} TRANS X10 Y20 Z30\nAROT X{} Y{} Z{}\nG0 X0 Y0 Z0\nG0 {}={} {}={}\nG{} {}={} {}={} {}={} {}={} F100\n",
            17 + plane, rot[0], rot[1], rot[2], letters[0], start[0], letters[1], start[1], if clockwise { 2 } else { 3 },
            letters[0], end[0], letters[1], end[1], letters[2], round(x - start[0]), letters[3], round(y - start[1]),
        );
        let ops = ops(&text).unwrap();
        let start_base = ops.iter().rev().find_map(|op| if let Op::Rapid(m) = op { m.end_base.xyz() } else { None }).unwrap();
        let Some(Op::Arc(arc)) = ops.last() else { panic!("no arc in {ops:?}") };
        let out = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] - arc.center_base[i]) };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let (a, b) = (out(start_base), out(arc.motion.end_base.xyz().unwrap()));
        prop_assert!((dot(a, a).sqrt() - arc.radius).abs() < 1e-9);
        // Rounding of four words to 0.0005 mm moves the radius by at most 0.0005 (1 + sqrt 2) at each end.
        prop_assert!((dot(b, b).sqrt() - arc.radius).abs() < 2.5e-3);
        prop_assert!(dot(a, arc.normal_base).abs() < 1e-9 && dot(b, arc.normal_base).abs() < 1e-9);
        // Turning the start about the normal by the sweep reaches the end.
        let (s, c) = arc.sweep.sin_cos();
        let across = cross(arc.normal_base, a);
        for i in 0..3 {
            prop_assert!((c * a[i] + s * across[i] - b[i]).abs() < 4e-3);
        }
        // The sweep is the programmed angle but for rounding: 0.002 mm on the radius, plus the shift of the
        // center of short arcs, which turns both ends alike.
        let error = (arc.sweep.to_degrees() - turn).abs();
        prop_assert!(error < (0.005 / radius).to_degrees() + 1e-6 || turn < 3.0, "{} {}", arc.sweep.to_degrees(), turn);
    }

    #[test]
    fn what_the_post_writes_is_read_back(blocks in prop::collection::vec(block(), 1..20), rot in prop::array::uniform3(-180.0..180.0f64),
                                         vector in prop::array::uniform3(-1.0..1.0f64), shift in -500.0..500.0f64) {
        prop_assume!(vector.iter().map(|v| v * v).sum::<f64>() > 0.01);
        let mut text = String::from("G54\nG0 X0 Y0 Z0 B0 F100 S1000 M3\nT=\"MILL\" M6\nM8\nCYCLE832(0.02,1,1)\n");
        for (i, words) in blocks.iter().enumerate() {
            text.push_str(&(words.join(" ") + "\n"));
            match i % 5 {
                1 => text.push_str(&format!("TRANS X{shift:.3}\nAROT X{:.6} Y{:.6} Z{:.6}\nG0 X1 Y2 Z3\n", rot[0], rot[1], rot[2])),
                2 => text.push_str("G3 X=IC(10) Y=IC(0) Z=IC(1) I5 J0 TURN=1\nG2 I4 J3\nCIP X=IC(1) Y=IC(2) Z=IC(3) I1=IC(2) J1=IC(0) K1=IC(1)\n"),
                3 => text.push_str(&format!(
                    "TRAORI\nORIVECT\nG1 X0 Y0 Z50 A3={:.4} B3={:.4} C3={:.4}\nTRAFOOF\nG0 X1 Y1 Z1 B5\n", vector[0], vector[1], vector[2]
                )),
                4 => text.push_str("G93\nG1 X1 F12\nX2 F24\nG94 F50\nSUPA G0 Z500 D0\nG0 X0 Y0 Z10 D1\nG4 F1.5\n"),
                _ => {}
            }
        }
        text.push_str("M9 M5\nM30\n");
        let read = |text: &str| -> Vec<Command> {
            Program::from_text("p.mpf", text, &settings()).unwrap().map(|c| c.unwrap_or_else(|e| panic!("{e}\n{text}"))).collect()
        };
        let first = read(&text);
        let mut post = SiemensPost::new(Vec::new(), PostSettings { block_number_step: Some(10), ..PostSettings::default() });
        for command in &first {
            post.write(command).unwrap();
        }
        let written = String::from_utf8(post.into_inner()).unwrap();
        let second = read(&written);
        let motions = |commands: &[Command]| commands.iter().filter(|c| matches!(c.op, Op::Rapid(_) | Op::Linear(_) | Op::Arc(_))).cloned().collect::<Vec<_>>();
        let (first, second) = (motions(&first), motions(&second));
        prop_assert_eq!(first.len(), second.len(), "{}\n{}", text, written);
        for (a, b) in first.iter().zip(&second) {
            // Three decimals of lengths: half of the last one; axes 0.0005 degrees.
            match (&a.op, &b.op) {
                (Op::Rapid(a), Op::Rapid(b)) | (Op::Linear(a), Op::Linear(b)) => same(a, b, &written),
                (Op::Arc(a), Op::Arc(b)) => {
                    same(&a.motion, &b.motion, &written);
                    for i in 0..3 {
                        prop_assert!((a.normal_base[i] - b.normal_base[i]).abs() < 1e-3, "{written}");
                    }
                    prop_assert!((a.radius - b.radius).abs() < 3e-3 && (a.sweep - b.sweep).abs() < 3e-3, "{a:?} {b:?}");
                }
                _ => prop_assert!(false, "{:?} {:?}", a.op, b.op),
            }
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let _ = ops(&text);
        let _ = proveout_nc::check_text("p.mpf", &text, &settings());
    }

    #[test]
    fn token_soup_never_panics_and_always_ends(picks in prop::collection::vec(0..SOUP.len(), 0..120)) {
        let text: String = picks.iter().map(|&i| SOUP[i]).collect();
        let mut count = 0usize;
        if let Ok(program) = Program::from_text("p.mpf", text.as_str(), &settings()) {
            for command in program {
                count += 1;
                // 500 passes of at most 120 tokens; a cycle gives at most some 10 000 motions.
                prop_assert!(count < 10_000_000, "{text}");
                if command.is_err() {
                    break;
                }
            }
        }
        for diagnostic in proveout_nc::check_text("p.mpf", &text, &settings()) {
            prop_assert!(proveout_nc::explain(diagnostic.code).is_some());
            let _ = format!("{:?}", miette::Report::new(diagnostic));
        }
    }
}

/// Pieces of the language, so that random texts reach deep into the reader.
const SOUP: &[&str] = &[
    "G0 ",
    "G1 ",
    "G2 ",
    "G3 ",
    "G4 ",
    "G9 ",
    "G17 ",
    "G18 ",
    "G54 ",
    "G641 ",
    "G91 ",
    "G93 ",
    "X1 ",
    "Y-2.5 ",
    "Z=R1 ",
    "A10 ",
    "C=DC(90) ",
    "I5 ",
    "J=AC(1) ",
    "K1=2 ",
    "CR=10 ",
    "AR=90 ",
    "TURN=2 ",
    "F100 ",
    "S1000 ",
    "M3 ",
    "M6 ",
    "M30 ",
    "M17 ",
    "T1 ",
    "T=\"A\" ",
    "D1 ",
    "TRANS ",
    "AROT ",
    "ASCALE ",
    "MIRROR ",
    "RPL=30 ",
    "SUPA ",
    "TRAORI ",
    "TRAFOOF ",
    "A3=1 ",
    "C3=0.5 ",
    "B2=30 ",
    "CIP ",
    "CT ",
    "ORIAXES ",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "; text\n",
    "/",
    "N10 ",
    "L1: ",
    "AB: ",
    "IF ",
    "R1>2 ",
    "GOTOB AB ",
    "GOTOF AB ",
    "ELSE ",
    "ENDIF ",
    "FOR R1=1 TO 3 ",
    "ENDFOR ",
    "WHILE ",
    "ENDWHILE ",
    "REPEAT ",
    "UNTIL R1>3 ",
    "LOOP ",
    "ENDLOOP ",
    "REPEAT AB P=3 ",
    "R1=R1+1 ",
    "R2=1/0 ",
    "DEF REAL ",
    "_V",
    "[2]",
    "=",
    "(",
    ")",
    ",",
    "\"",
    "+",
    "*",
    "<<",
    "==",
    "NOT ",
    "1EX5 ",
    "9999999999 ",
    "SIN(30) ",
    "PROC SUB",
    "SUB ",
    "MCALL ",
    "CYCLE81(10,0,1,-5) ",
    "CYCLE83(10,0,1,-500,,1,,0.001) ",
    "CYCLE800(0,\"T\",0,57,0,0,0,10,20,30,0,0,0,1) ",
    "CYCLE832(0.1,1) ",
    "HOLES2(0,0,5,0,0,4) ",
    "CALL \"SUB\" ",
    "RET ",
    "CASE (R1) OF 1 GOTOF AB ",
    "ü",
    "%_N_A_SPF\n",
    "'H1F' ",
];

fn near(a: &AxisValues, b: &AxisValues, text: &str) {
    assert_eq!(a.iter().map(|(l, _)| l).collect::<String>(), b.iter().map(|(l, _)| l).collect::<String>(), "{text}");
    for ((letter, a), (_, b)) in a.iter().zip(b.iter()) {
        let limit = if matches!(letter, 'A' | 'B' | 'C') { 0.0006f64.to_radians() } else { 2e-3 };
        assert!((a - b).abs() < limit, "{letter} {a} {b}\n{text}");
    }
}

fn same(a: &Motion, b: &Motion, text: &str) {
    assert_eq!((a.machine_coordinates, a.exact_stop), (b.machine_coordinates, b.exact_stop));
    near(&a.end_base, &b.end_base, text);
    assert_eq!(a.tool_axis.is_some(), b.tool_axis.is_some());
    for (a, b) in a.tool_axis_base.iter().flatten().zip(b.tool_axis_base.iter().flatten()) {
        assert!((a - b).abs() < 2e-5, "{a} {b}\n{text}");
    }
}

#[test]
fn a_long_loop_gives_commands_without_keeping_them() {
    let text = "G0 X0\nFOR R1=1 TO 200000\nX=R1\nENDFOR\nM30\n";
    let mut program = Program::from_text("p.mpf", text, &Settings::default()).unwrap();
    // The first commands come before the loop has run.
    assert!(matches!(program.next(), Some(Ok(Command { op: Op::Rapid(_), .. }))));
    assert_eq!(program.map(Result::unwrap).count(), 200_001);
}
