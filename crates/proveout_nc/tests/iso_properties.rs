//! Laws that hold for every ISO program: the same meaning however it is written, no panic and no endless run.
//!
//! `PROVEOUT_CASES` raises the number of random programs.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proptest::prelude::*;
use proveout_nc::{Command, Dialect, Op, Program, Settings, check_text};

const DIALECTS: [Dialect; 4] = [Dialect::Iso, Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc];

fn cases() -> u32 {
    std::env::var("PROVEOUT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(200)
}

fn settings(dialect: Dialect) -> Settings {
    let mut settings = Settings { dialect, ..Settings::default() };
    // Small limits, so that endless loops of random texts end at once.
    settings.limits.max_loop_passes = 500;
    settings.limits.max_idle_passes = 100;
    settings
}

fn ops(dialect: Dialect, text: &str) -> Result<Vec<Op>, String> {
    Program::from_text("p.nc", text, &settings(dialect))
        .map_err(|e| e.to_string())?
        .map(|c| c.map(|c| c.op).map_err(|e| format!("{} {}", e.code, e.message)))
        .collect()
}

/// A word with a value in thousandths.
fn word(letter: char, thousandths: i32) -> String {
    let sign = if thousandths < 0 { "-" } else { "" };
    let value = thousandths.unsigned_abs();
    format!("{letter}{sign}{}.{:03}", value / 1000, value % 1000)
}

prop_compose! {
    fn block()(g in 0..2u8, x in -99999..99999i32, y in -99999..99999i32, z in prop::option::of(-9999..9999i32),
               a in prop::option::of(-90000..90000i32), f in prop::option::of(1..9999i32)) -> Vec<String> {
        let mut words = vec![format!("G{g}"), word('X', x), word('Y', y)];
        words.extend(z.map(|z| word('Z', z)));
        words.extend(a.map(|a| word('A', a)));
        words.extend(f.map(|f| word('F', f)));
        words
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn blanks_case_numbers_and_order_do_not_matter(
        blocks in prop::collection::vec(block(), 1..20), seed in any::<u64>(), dialect in 0..4usize,
    ) {
        let dialect = DIALECTS[dialect];
        let plain: String = blocks.iter().map(|words| words.join(" ") + "\n").collect();
        let plain = format!("G21 G0 X0. Y0. Z0. F100.\n{plain}");
        let mut state = seed | 1;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let mut other = String::from("%\n(head)\n\nn1 g21g0x0.y0.z0.f100.\r\n");
        for (i, words) in blocks.iter().enumerate() {
            let mut words = words.clone();
            let at = random(words.len() as u64) as usize;
            words.rotate_left(at);
            if random(2) == 0 {
                other.push_str(&format!("N{} ", i * 10));
            }
            let text = words.join(["", " ", "\t ", "(in between)"][random(4) as usize]);
            other.push_str(&if random(2) == 0 { text.to_lowercase() } else { text });
            other.push_str([" ; end\n", "\n", "  \r\n", "(end)\n"][random(4) as usize]);
        }
        prop_assert_eq!(ops(dialect, &plain), ops(dialect, &other));
    }

    #[test]
    fn arcs_lie_on_their_circle(
        x in -50.0..50.0f64, y in -50.0..50.0f64, radius in 0.5..80.0f64, from in 0.0..360.0f64, turn in 1.0..359.0f64,
        clockwise in any::<bool>(), spin in -180.0..180.0f64, plane in 0..3usize, by_radius in any::<bool>(), pitch in -5.0..5.0f64,
    ) {
        // A circle of known center, with the three decimals of shop programs, under a rotation of the plane.
        let point = |degrees: f64| [x + radius * degrees.to_radians().cos(), y + radius * degrees.to_radians().sin()];
        let round = |v: f64| (v * 1000.0).round() / 1000.0;
        let start = point(from).map(round);
        let end = point(if clockwise { from - turn } else { from + turn }).map(round);
        let letters = [["X", "Y", "I", "J", "Z"], ["Z", "X", "K", "I", "Y"], ["Y", "Z", "J", "K", "X"]][plane];
        // R defines the arc badly near half a turn and near none: left to the center form there.
        let by_radius = by_radius && (30.0..150.0).contains(&(turn % 180.0));
        let circle = if by_radius {
            format!("R{:.3}", if turn > 180.0 { -radius } else { radius })
        } else {
            format!("{}{:.3} {}{:.3}", letters[2], x - start[0], letters[3], y - start[1])
        };
        let text = format!(
            "G21 G{} G0 X0. Y0. Z0.\nG68 {}1. {}2. R{spin:.3}\nG0 {}{:.3} {}{:.3} {}0.\nG{} {}{:.3} {}{:.3} {}{pitch:.3} {circle} F100.\n",
            17 + plane, letters[0], letters[1], letters[0], start[0], letters[1], start[1], letters[4],
            if clockwise { 2 } else { 3 }, letters[0], end[0], letters[1], end[1], letters[4],
        );
        let ops = ops(Dialect::Fanuc, &text).unwrap();
        let start_base = ops.iter().rev().find_map(|op| if let Op::Rapid(m) = op { m.end_base.xyz() } else { None }).unwrap();
        let Some(Op::Arc(arc)) = ops.last() else { panic!("no arc in {ops:?}") };
        let out = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] - arc.center_base[i]) };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let n = arc.normal_base;
        let flat = |v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| v[i] - dot(v, n) * n[i]) };
        let (a, b) = (flat(out(start_base)), flat(out(arc.motion.end_base.xyz().unwrap())));
        prop_assert!((dot(a, a).sqrt() - arc.radius).abs() < 1e-9);
        // Rounding of four words to 0.0005 mm moves the radius by at most 0.0005 (1 + sqrt 2) at each end.
        prop_assert!((dot(b, b).sqrt() - arc.radius).abs() < 2.5e-3);
        // Turning the start about the normal by the sweep reaches the direction of the end.
        let (s, c) = arc.sweep.sin_cos();
        let side = cross(n, a);
        for i in 0..3 {
            prop_assert!((a[i] * c + side[i] * s - b[i]).abs() < 2e-2, "{text}");
        }
        let degrees = arc.sweep.to_degrees();
        // The end points are rounded to 0.0007 mm across: for the smallest radius that is 0.16 degrees; R
        // adds its own.
        prop_assert!((degrees - turn).abs() < 0.5 || by_radius && (degrees - turn).abs() < 2.0, "{degrees} {turn}\n{text}");
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), dialect in 0..4usize) {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let _ = ops(DIALECTS[dialect], &text);
        let _ = check_text("p.nc", &text, &settings(DIALECTS[dialect]));
    }

    #[test]
    fn token_soup_never_panics_and_always_ends(picks in prop::collection::vec(0..SOUP.len(), 0..120), dialect in 0..4usize) {
        let text: String = picks.iter().map(|&i| SOUP[i]).collect();
        let settings = settings(DIALECTS[dialect]);
        let mut count = 0usize;
        if let Ok(program) = Program::from_text("p.nc", text.as_str(), &settings) {
            for command in program {
                count += 1;
                // 500 passes of some 100 words, each block at most 10 repetitions of 10 000 infeeds in this
                // soup.
                prop_assert!(count < 20_000_000, "{text}");
                if let Ok(Command { op: Op::Linear(m) | Op::Rapid(m), .. }) = &command {
                    prop_assert!(m.end_base.iter().all(|(_, v)| v.is_finite()), "{text}");
                }
                if command.is_err() {
                    break;
                }
            }
        }
        for diagnostic in check_text("p.nc", &text, &settings) {
            prop_assert!(proveout_nc::explain(diagnostic.code).is_some());
            prop_assert!(diagnostic.help.is_some());
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
    "G5 ",
    "G5.1 ",
    "G10 L2 ",
    "G10 L20 ",
    "G10 L10 ",
    "G15 ",
    "G16 ",
    "G17 ",
    "G18 ",
    "G19 ",
    "G20 ",
    "G21 ",
    "G28 ",
    "G30 ",
    "G31 ",
    "G33 ",
    "G38.2 ",
    "G40 ",
    "G41 ",
    "G42.1 ",
    "G43 ",
    "G43.1 ",
    "G43.4 ",
    "G43.5 ",
    "G49 ",
    "G51.1 ",
    "G50.1 ",
    "G52 ",
    "G53 ",
    "G53.1 ",
    "G54 ",
    "G59.3 ",
    "G54.1 ",
    "G61 ",
    "G64 ",
    "G65 ",
    "G66 ",
    "G67 ",
    "G68 ",
    "G68.2 ",
    "G69 ",
    "G73 ",
    "G76 ",
    "G81 ",
    "G83 ",
    "G84 ",
    "G85 ",
    "G86 ",
    "G87 ",
    "G89 ",
    "G80 ",
    "G90 ",
    "G91 ",
    "G90.1 ",
    "G92 ",
    "G92.1 ",
    "G92.3 ",
    "G93 ",
    "G94 ",
    "G95 ",
    "G96 ",
    "G97 ",
    "G98 ",
    "G99 ",
    "G154 ",
    "G234 ",
    "G254 ",
    "G255 ",
    "G187 ",
    "X1. ",
    "Y-2.5 ",
    "Z#1 ",
    "Z5 ",
    "A10. ",
    "B30 ",
    "C[90] ",
    "I5. ",
    "J1 ",
    "K2 ",
    "R3. ",
    "Q1. ",
    "P1 ",
    "P100 ",
    "P2 ",
    "L2 ",
    "F100. ",
    "S1000 ",
    "H1 ",
    "D1 ",
    "T1 ",
    "E0.1 ",
    "U1 ",
    "M3 ",
    "M5 ",
    "M6 ",
    "M8 ",
    "M29 ",
    "M30 ",
    "M70 ",
    "M72 ",
    "M97 P1 ",
    "M98 P2 ",
    "M99 ",
    "M99 P1 ",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "(text) ",
    "(MSG, a) ",
    "; x\n",
    "/",
    "N1 ",
    "N100 ",
    "O1\n",
    "O2\n",
    "%\n",
    "#1=#1+1 ",
    "#2=1/0 ",
    "#[#1]=2 ",
    "#<a>=3 ",
    "#<_b>=[#1 GT 2] ",
    "#100=[",
    "]",
    "[",
    "IF [#1 GT 2] GOTO 1\n",
    "IF [#1 LT 3] THEN #2=5\n",
    "GOTO 100\n",
    "WHILE [#1 LT 3] DO 1\n",
    "END 1\n",
    "DO 2\n",
    "END 2\n",
    "o1 sub\n",
    "o1 endsub\n",
    "o1 call [1]\n",
    "o1 return [2]\n",
    "o2 while [#1 lt 3]\n",
    "o2 endwhile\n",
    "o3 if [#1]\n",
    "o3 else\n",
    "o3 elseif [#2]\n",
    "o3 endif\n",
    "o4 repeat [3]\n",
    "o4 endrepeat\n",
    "o5 do\n",
    "o5 while [0]\n",
    "o2 break\n",
    "o4 continue\n",
    "o5 continue\n",
    "SIN[30] ",
    "ATAN[1]/[2] ",
    "MOD ",
    "**2 ",
    "-",
    "+",
    "*",
    "/",
    ".",
    "#",
    "ü",
    "99999999999 ",
    "1e5 ",
    "@",
    "#5041 ",
    "#5221=3 ",
    "#3006=1 ",
];

#[test]
fn a_long_loop_gives_commands_without_keeping_them() {
    let text = "g21 g0 x0\n#1 = 0\no1 while [#1 lt 200000]\n#1 = [#1 + 1]\nx#1\no1 endwhile\nm2\n";
    let settings = Settings { dialect: Dialect::LinuxCnc, ..Settings::default() };
    let mut program = Program::from_text("p.ngc", text, &settings).unwrap();
    // The first commands come before the loop has run: offset and frame of the start, then the motion.
    assert!(program.by_ref().take(3).all(|c| c.is_ok()));
    assert_eq!(program.map(Result::unwrap).filter(|c| matches!(c.op, Op::Rapid(_))).count(), 200_000);
}
