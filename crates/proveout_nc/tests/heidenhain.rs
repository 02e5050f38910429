//! Laws of the Heidenhain reader: closed forms, both forms of the language against each other, random text.
//!
//! `PROVEOUT_FUZZ_CASES` raises the number of random cases.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proptest::prelude::*;
use proveout_nc::{ArcMotion, Command, Dialect, Motion, Op, Program, Settings, check_text};

fn settings(dialect: Dialect) -> Settings {
    let mut settings = Settings { dialect, ..Settings::default() };
    // Small limits, so that endless loops of random texts end at once.
    settings.limits.max_loop_passes = 500;
    settings.limits.max_idle_passes = 100;
    settings.limits.max_array_elements = 1000;
    settings
}

fn read(dialect: Dialect, text: &str) -> Result<Vec<Op>, String> {
    Program::from_text("p.h", text, &settings(dialect))
        .map_err(|e| e.to_string())?
        .map(|c| c.map(|c| c.op).map_err(|e| format!("{} {}", e.code, e.message)))
        .collect()
}

fn ops(text: &str) -> Vec<Op> {
    read(Dialect::Heidenhain, text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn code(dialect: Dialect, text: &str) -> String {
    read(dialect, text).err().unwrap_or_default().split(' ').next().unwrap_or_default().to_owned()
}

fn motions(ops: &[Op]) -> Vec<&Motion> {
    ops.iter()
        .filter_map(|op| match op {
            Op::Rapid(m) | Op::Linear(m) => Some(m),
            Op::Arc(a) => Some(&a.motion),
            Op::Thread(t) => Some(&t.motion),
            _ => None,
        })
        .collect()
}

fn end(op: &Op) -> [f64; 3] {
    motions(std::slice::from_ref(op))[0].end.xyz().unwrap()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn word(letter: char, thousandths: i32) -> String {
    let sign = if thousandths < 0 { '-' } else { '+' };
    let value = thousandths.unsigned_abs();
    format!("{letter}{sign}{}.{:03}", value / 1000, value % 1000)
}

fn cases() -> ProptestConfig {
    let cases = std::env::var("PROVEOUT_FUZZ_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(150);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// X and Y always, Z, C and F at will, in thousandths; true for rapid.
type Words = (i32, i32, Option<i32>, Option<i32>, Option<i32>, bool);

fn blocks() -> impl Strategy<Value = Vec<Words>> {
    let opt = |r: std::ops::Range<i32>| prop::option::of(r);
    prop::collection::vec(
        (-99999..99999i32, -99999..99999i32, opt(-9999..9999), opt(-90000..90000), opt(1..9999), any::<bool>()),
        1..20,
    )
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn blanks_case_and_numbers_do_not_matter_and_din_says_the_same(blocks in blocks(), seed in any::<u64>()) {
        let mut state = seed | 1;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        let mut plain = String::from("BEGIN PGM A MM\nTOOL CALL 1 Z S100 F100\nL X+0 Y+0 Z+0 R0 FMAX\n");
        let mut other = String::from("0 begin pgm a mm\n; head\n\n1 tool call 1 z s100f100\r\n2 lx+0y+0z+0r0fmax\n");
        let mut din = String::from("%A G71 *\nN1 T1 G17 S100 F100 *\nN2 G00 G40 G90 X+0 Y+0 Z+0 *\n");
        for (i, (x, y, z, c, f, rapid)) in blocks.iter().enumerate() {
            let mut words = vec![word('X', *x), word('Y', *y)];
            words.extend(z.map(|z| word('Z', z)));
            words.extend(c.map(|c| word('C', c)));
            let feed = if *rapid { Some("FMAX".to_owned()) } else { f.map(|f| word('F', f * 10).replace('+', "")) };
            plain.push_str(&format!("L {} {}\n", words.join(" "), feed.clone().unwrap_or_default()));
            let at = random(words.len() as u64) as usize;
            let mut mixed = words.clone();
            mixed.extend(feed.clone());
            mixed.rotate_left(at);
            if random(2) == 0 {
                other.push_str(&format!("{} ", i * 3));
            }
            let text = format!("L{}{}", ["", " ", "\t"][random(3) as usize], mixed.join(["", " ", "  "][random(3) as usize]));
            other.push_str(&if random(2) == 0 { text.to_lowercase() } else { text });
            other.push_str([" ; end\n", "\n", "  \r\n"][random(3) as usize]);
            let feed = if *rapid { String::new() } else { feed.unwrap_or_default() };
            din.push_str(&format!("N{}0 {} {} {feed} *\n", i + 1, if *rapid { "G00" } else { "G01" }, words.join(" ")));
        }
        din.push_str("N99999999 %A G71 *\n");
        plain.push_str("END PGM A MM\n");
        other.push_str("end pgm a mm\n");
        let want = read(Dialect::Heidenhain, &plain);
        prop_assert!(want.is_ok(), "{want:?}\n{plain}");
        prop_assert_eq!(&want, &read(Dialect::Heidenhain, &other), "{}", other);
        prop_assert_eq!(&want, &read(Dialect::HeidenhainIso, &din), "{}", din);
    }

    #[test]
    fn arcs_lie_on_their_circle(
        x in -50.0..50.0f64, y in -50.0..50.0f64, radius in 0.5..80.0f64, from in 0.0..360.0f64, turn in 3.0..357.0f64,
        clockwise in any::<bool>(), kind in 0..3usize, rot in -180.0..180.0f64,
    ) {
        let point = |degrees: f64| [x + radius * degrees.to_radians().cos(), y + radius * degrees.to_radians().sin()];
        let (a, b) = (point(from), point(if clockwise { from - turn } else { from + turn }));
        let dr = if clockwise { '-' } else { '+' };
        let arc = match kind {
            0 => format!("C X{:+.4} Y{:+.4} DR{dr}", b[0], b[1]),
            1 => format!("CR X{:+.4} Y{:+.4} R{:+.4} DR{dr}", b[0], b[1], if turn > 180.0 { -radius } else { radius }),
            _ => format!("CP IPA{:+.6} DR{dr} IZ+3", if clockwise { -turn } else { turn }),
        };
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100 F100\nCYCL DEF 7.0\nCYCL DEF 7.1 X+10 Y-20 Z+30\nCYCL DEF 10.0\nCYCL DEF 10.1 ROT{rot:+.3}\nL X{:+.4} Y{:+.4} Z+1 FMAX\nCC X{x:+.4} Y{y:+.4}\n{arc}\n",
            a[0], a[1],
        );
        // A radius of four decimals next to half the chord moves the center along the bisector: stay off half
        // a turn.
        prop_assume!(kind != 1 || (turn - 180.0).abs() > 5.0);
        let ops = ops(&text);
        let Some(Op::Arc(arc)) = ops.iter().rev().find(|op| matches!(op, Op::Arc(_))) else { panic!("no arc\n{text}") };
        let start = ops.iter().rev().find_map(|op| if let Op::Rapid(m) = op { m.end_base.xyz() } else { None }).unwrap();
        let out = |p: [f64; 3]| [p[0] - arc.center_base[0], p[1] - arc.center_base[1]];
        let (s, e) = (out(start), out(arc.motion.end_base.xyz().unwrap()));
        // Four decimals in the text; the center of CR moves more than its words where the chord is short.
        let slack = if kind == 1 { 2e-2 } else { 1e-3 };
        prop_assert!((s[0].hypot(s[1]) - arc.radius).abs() < 1e-3 && (e[0].hypot(e[1]) - arc.radius).abs() < 1e-3, "{text}");
        prop_assert!((arc.radius - radius).abs() < slack, "{} {radius}\n{text}", arc.radius);
        let (sin, cos) = (arc.sweep * arc.normal_base[2]).sin_cos();
        let turned = [cos * s[0] - sin * s[1], sin * s[0] + cos * s[1]];
        prop_assert!((turned[0] - e[0]).hypot(turned[1] - e[1]) < 2e-3, "{text}");
        prop_assert!((arc.sweep.to_degrees() - turn).abs() < (0.02 / radius).to_degrees().max(0.01), "{} {turn}\n{text}", arc.sweep.to_degrees());
    }

    #[test]
    fn roundings_touch_both_lines(a in 0.0..360.0f64, turn in 10.0..170.0f64, left in any::<bool>(), radius in 0.5..8.0f64) {
        // Two lines of 200 mm meet in the origin.
        let (first, second) = (a.to_radians(), (a + if left { turn } else { -turn }).to_radians());
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100 F100\nL X{:.6} Y{:.6} Z+0 FMAX\nL X+0 Y+0\nRND R{radius:.4}\nL X{:.6} Y{:.6}\n",
            -200.0 * first.cos(), -200.0 * first.sin(), 200.0 * second.cos(), 200.0 * second.sin(),
        );
        let ops = ops(&text);
        let path: Vec<&Op> = ops.iter().filter(|op| matches!(op, Op::Linear(_) | Op::Arc(_))).collect();
        let [Op::Linear(_), Op::Arc(arc), Op::Linear(_)] = path[..] else { panic!("{path:?}") };
        // The feet lie r tan(turn / 2) from the corner, the center r / cos(turn / 2).
        let half = (turn / 2.0).to_radians();
        let (t1, t2) = (end(path[0]), end(path[1]));
        let foot = radius * half.tan();
        // 1e-3: four decimals of the radius, times the tangent of up to 85 degrees (11.4).
        prop_assert!(distance(t1, [-foot * first.cos(), -foot * first.sin(), 0.0]) < 1e-3, "{text}");
        prop_assert!(distance(t2, [foot * second.cos(), foot * second.sin(), 0.0]) < 1e-3, "{text}");
        prop_assert!((distance(arc.center, [0.0; 3]) - radius / half.cos()).abs() < 1e-3);
        prop_assert!((arc.sweep.to_degrees() - turn).abs() < 1e-3, "{} {turn}", arc.sweep.to_degrees());
        prop_assert_eq!(arc.normal[2] > 0.0, left);
    }

    #[test]
    fn approaches_arrive_along_the_contour(
        direction in 0.0..360.0f64, right in any::<bool>(), radius in 1.0..20.0f64, form in 0..2usize, far in 60.0..200.0f64, around in 0.0..360.0f64,
    ) {
        let d = [direction.to_radians().cos(), direction.to_radians().sin()];
        let lead = ["CT X+0 Y+0 CCA75", "LCT X+0 Y+0"][form];
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100 F100\nL X{:.6} Y{:.6} Z+0 F100\nAPPR {lead} R{radius:.4} R{} F50\nL X{:.6} Y{:.6}\n",
            far * around.to_radians().cos(), far * around.to_radians().sin(), if right { 'R' } else { 'L' }, 50.0 * d[0], 50.0 * d[1],
        );
        let ops = ops(&text);
        let path: Vec<&Op> = ops.iter().filter(|op| matches!(op, Op::Linear(_) | Op::Arc(_))).collect();
        let [Op::Linear(_), Op::Linear(to), Op::Arc(arc), Op::Linear(_)] = path[..] else { panic!("{path:?}") };
        let tangent = |arc: &ArcMotion, p: [f64; 3]| {
            let r = [p[0] - arc.center[0], p[1] - arc.center[1]];
            let sense = arc.normal[2];
            [-sense * r[1] / arc.radius, sense * r[0] / arc.radius]
        };
        let arrives = tangent(arc, [0.0; 3]);
        prop_assert!((arrives[0] - d[0]).hypot(arrives[1] - d[1]) < 1e-5, "{text}");
        prop_assert!((distance(arc.center, [0.0; 3]) - radius).abs() < 1e-4);
        // RL: the center lies left of the contour.
        prop_assert_eq!(d[0] * arc.center[1] - d[1] * arc.center[0] < 0.0, right);
        let helper = to.end.xyz().unwrap();
        prop_assert!((distance(helper, arc.center) - radius).abs() < 1e-4);
        if form == 0 {
            prop_assert!((arc.sweep.to_degrees() - 75.0).abs() < 1e-6);
        } else {
            // The line from the start runs on into the arc.
            let from = end(path[0]);
            let line = [helper[0] - from[0], helper[1] - from[1]];
            let t = tangent(arc, helper);
            let l = line[0].hypot(line[1]);
            prop_assert!((line[0] / l - t[0]).hypot(line[1] / l - t[1]) < 1e-5, "{text}");
        }
    }

    #[test]
    fn transforms_act_in_the_order_of_the_program(
        order in Just([0usize, 1, 2, 3]).prop_shuffle(), x in -100.0..100.0f64, y in -100.0..100.0f64, z in -50.0..50.0f64,
        shift in prop::array::uniform3(-200.0..200.0f64), angle in -180.0..180.0f64, scale in 0.2..3.0f64,
    ) {
        let mut text = String::from("BEGIN PGM A MM\nTOOL CALL 1 Z S100 F100\n");
        let r = |v: f64| (v * 1000.0).round() / 1000.0;
        let (x, y, z, angle, scale, shift) = (r(x), r(y), r(z), r(angle), r(scale), shift.map(r));
        for step in order {
            text.push_str(&match step {
                0 => format!("CYCL DEF 7.0\nCYCL DEF 7.1 X{:+.3}\nCYCL DEF 7.2 Y{:+.3}\nCYCL DEF 7.3 Z{:+.3}\n", shift[0], shift[1], shift[2]),
                1 => "CYCL DEF 8.0\nCYCL DEF 8.1 Y\n".to_owned(),
                2 => format!("CYCL DEF 10.0\nCYCL DEF 10.1 ROT{angle:+.3}\n"),
                _ => format!("CYCL DEF 11.0\nCYCL DEF 11.1 SCL{scale:.3}\n"),
            });
        }
        text.push_str(&format!("L X{x:+.3} Y{y:+.3} Z{z:+.3} FMAX\n"));
        // Oracle: the point goes through the steps from the last to the first.
        let mut p = [x, y, z];
        for step in order.iter().rev() {
            p = match step {
                0 => std::array::from_fn(|i| p[i] + shift[i]),
                1 => [p[0], -p[1], p[2]],
                2 => {
                    let (s, c) = angle.to_radians().sin_cos();
                    [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]
                }
                _ => p.map(|v| v * scale),
            };
        }
        let ops = ops(&text);
        let got = motions(&ops)[0].end_base.xyz().unwrap();
        prop_assert!(distance(got, p) < 1e-9, "{got:?} {p:?}\n{text}");
    }

    #[test]
    fn holes_reach_their_depth_and_end_above(
        number in prop::sample::select(vec![200u32, 201, 203, 205, 207, 209, 240, 206]), depth in 1.0..60.0f64, infeed in 0.5..20.0f64,
        surface in -20.0..20.0f64, clearance in 0.5..5.0f64, second in 0.0..80.0f64, decrement in 0.0..2.0f64, breaks in 0..4u32,
    ) {
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100 F100\nL X+0 Y+0 Z+200 FMAX M3\nCYCL DEF {number} X Q200={clearance:.3} Q201={:.3} Q206=100 Q202={infeed:.3} Q210=0 Q203={surface:+.3} Q204={second:.3} Q211=0 Q208=0 Q212={decrement:.3} Q213={breaks} Q205=0.5 Q256=0.2 Q257={infeed:.3} Q258=0.2 Q259=0.2 Q239=1 Q343=0\nL X+5 FMAX M99\n",
            -depth,
        );
        let ops = ops(&text);
        let heights: Vec<f64> = motions(&ops).iter().filter_map(|m| m.end.get(2)).collect();
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        // Three decimals in the text.
        prop_assert!((lowest - (surface - depth)).abs() < 2e-3, "{lowest}\n{text}");
        prop_assert!((heights.last().unwrap() - (surface + clearance.max(second))).abs() < 2e-3, "{heights:?}\n{text}");
        // Rapid never goes below what feed or thread has reached before.
        let mut reached = surface;
        for op in &ops {
            match op {
                Op::Rapid(m) => prop_assert!(m.end.get(2).is_none_or(|z| z > reached - 2e-3), "{text}"),
                Op::Linear(m) => reached = reached.min(m.end.get(2).unwrap()),
                Op::Thread(t) => reached = reached.min(t.motion.end.get(2).unwrap()),
                _ => {}
            }
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        for dialect in [Dialect::Heidenhain, Dialect::HeidenhainIso] {
            let _ = read(dialect, &text);
            let _ = check_text("p.h", &text, &settings(dialect));
        }
    }

    #[test]
    fn token_soup_never_panics_and_always_ends(picks in prop::collection::vec(0..SOUP.len(), 0..100), iso in any::<bool>()) {
        let dialect = if iso { Dialect::HeidenhainIso } else { Dialect::Heidenhain };
        let text: String = picks.iter().map(|&i| SOUP[i]).collect();
        let mut count = 0usize;
        if let Ok(program) = Program::from_text("p.h", text.as_str(), &settings(dialect)) {
            for command in program {
                count += 1;
                // 500 passes of at most 100 tokens; a cycle gives at most some 10 000 motions.
                prop_assert!(count < 10_000_000, "{text}");
                if command.is_err() {
                    break;
                }
            }
        }
        for diagnostic in check_text("p.h", &text, &settings(dialect)) {
            prop_assert!(proveout_nc::explain(diagnostic.code).is_some());
            prop_assert!(diagnostic.help.is_some(), "{diagnostic}");
        }
    }
}

/// Pieces of the language, so that random texts reach deep into the reader.
const SOUP: &[&str] = &[
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "\n",
    "L X+1 Y+2 Z+3 FMAX\n",
    "L X+10 F100\n",
    "L Y+20 F100\n",
    "L IX+5\n",
    "TOOL CALL 1 Z S100 F500\n",
    "CC X+0 Y+0\n",
    "C X+5 Y+5 DR+\n",
    "CR X+9 Y+9 R+20 DR-\n",
    "CT X+3 Y+8\n",
    "CP IPA+720 IZ-3 DR+\n",
    "LP PR+10 PA+45\n",
    "CTP PA+20 PR+4\n",
    "RND R2\n",
    "CHF 1\n",
    "APPR CT X+0 Y+0 CCA90 R+5 RL F100\n",
    "APPR LCT X+1 Y+2 R3 RR F100\n",
    "APPR LT X+0 Y+0 LEN3\n",
    "DEP LN LEN5\n",
    "DEP LCT X+50 Y+50 R4\n",
    "RL ",
    "R0 ",
    "M3 ",
    "M30 ",
    "M91 ",
    "M99 ",
    "M89 ",
    "M128 F100 ",
    "M129 ",
    "M126 ",
    "M136 ",
    "M140 MB 5 ",
    "M140 MB MAX\n",
    "X+1 ",
    "IZ-2.5 ",
    "A+Q120 ",
    "C+Q122 ",
    "B+10 ",
    "F100 ",
    "FMAX ",
    "LN X+1 Y+1 Z+1 NX+0 NY+0 NZ+1 TX+0 TY+0 TZ+1\n",
    "PLANE SPATIAL SPA+10 SPB+20 SPC+30 TURN FMAX\n",
    "PLANE RELATIVE SPB+10 STAY\n",
    "PLANE RESET TURN\n",
    "PLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY+0 NZ+1 MOVE\n",
    "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL VECTOR\n",
    "FUNCTION RESET TCPM\n",
    "CYCL DEF 7.0 D\n",
    "CYCL DEF 7.1 X+10\n",
    "CYCL DEF 8.0\nCYCL DEF 8.1 X\n",
    "CYCL DEF 10.0\nCYCL DEF 10.1 IROT+30\n",
    "CYCL DEF 11.0\nCYCL DEF 11.1 SCL2\n",
    "CYCL DEF 19.0\nCYCL DEF 19.1 A+10 B+0 C+5\n",
    "CYCL DEF 26.0\nCYCL DEF 26.1 X2 CCX+1\n",
    "CYCL DEF 32.0\nCYCL DEF 32.1 T0.1\n",
    "CYCL DEF 247 D ~\n Q339=+1\n",
    "CYCL DEF 200 D\n Q200=2 ;A\n Q201=-20\n Q206=100\n Q202=1\n Q203=+0\n",
    "CYCL DEF 203 D Q200=2 Q201=-20 Q206=100 Q202=3 Q212=0.1 Q213=2 Q205=1 Q208=0 Q256=0.3\n",
    "CYCL DEF 209 D Q200=2 Q201=-9 Q239=1 Q257=2\n",
    "CYCL DEF 202 D Q200=2 Q201=-9 Q206=9 Q214=2\n",
    "CYCL CALL\n",
    "CYCL CALL POS X+1 Y+1 Z+1 FMAX\n",
    "CYCL DEF 220 P Q216=0 Q217=0 Q244=9 Q245=0 Q241=3\n",
    "CYCL DEF 1.0\nCYCL DEF 1.1 SET UP 2\n",
    "LBL 1\n",
    "LBL 0\n",
    "CALL LBL 1\n",
    "CALL LBL 1 REP 3\n",
    "LBL \"A\"\n",
    "CALL LBL \"A\"\n",
    "Q1 = Q1 + 1\n",
    "FN 0: Q1 = +5\n",
    "FN 9: IF +Q1 EQU +5 GOTO LBL 1\n",
    "FN 4: Q2 = +1 DIV +0\n",
    "Q2 = SQRT ( Q1 ^ 2 - 3 )\n",
    "QS1 = \"A\" || \"B\"\n",
    "TRANS DATUM AXIS X+1\n",
    "TRANS ROTATION IROT+10\n",
    "STOP\n",
    "BEGIN PGM A INCH\n",
    "END PGM A MM\n",
    "~\n",
    ";",
    "\"",
    "(",
    ")",
    "+",
    "Q",
    "ü",
    "1 ",
    "/",
    "* - s\n",
    "%A G71 *\n",
    "N10 ",
    "G00 ",
    "G01 ",
    "G02 ",
    "G05 ",
    "G11 ",
    "G13 ",
    "G91 ",
    "G90 ",
    "I+1 J+2 ",
    "R+5 ",
    "H+30 ",
    "G98 L1 *\n",
    "L1,3 *\n",
    "L1 *\n",
    "D01 Q1 P01 +Q1 P02 +1 *\n",
    "D09 P01 +Q1 P02 +3 P03 1 *\n",
    "G25 R2 *\n",
    "G54 X+1 *\n",
    "G73 H+30 *\n",
    "G80 A+10 *\n",
    "G79 *\n",
    "*\n",
    "G200 Q200=2 Q201=-5 Q206=100 *\n",
    "T1 G17 S5 *\n",
    "F50 ",
];

#[test]
fn a_long_loop_gives_commands_without_keeping_them() {
    let text = "BEGIN PGM A MM\nTOOL CALL 1 Z S1\nL X+0 Y+0 Z+0 FMAX\nLBL 1\nL IX+1 F100\nCALL LBL 1 REP 60000\nM30\nEND PGM A MM\n";
    let settings = Settings { dialect: Dialect::Heidenhain, ..Settings::default() };
    let mut program = Program::from_text("p.h", text, &settings).unwrap();
    assert!(matches!(program.next(), Some(Ok(Command { op: Op::Tool(_), .. }))));
    let last = program.map(Result::unwrap).filter(|c| matches!(c.op, Op::Linear(_))).last().unwrap();
    assert_eq!(end(&last.op)[0], 60_001.0);
}

#[test]
fn a_helix_keeps_its_turns_and_its_bits() {
    let ops = ops("BEGIN PGM A MM\nTOOL CALL 1 Z S1 F100\nL X+10 Y+0 Z+0 FMAX\nCC X+0 Y+0\nCP IPA-3600 IZ-20 DR-\n");
    let Some(Op::Arc(arc)) = ops.last().filter(|op| !matches!(op, Op::End)).or(ops.iter().rev().nth(1)) else {
        panic!("{ops:?}")
    };
    assert_eq!(arc.motion.end.xyz(), Some([10.0, 0.0, -20.0]));
    assert!((arc.sweep - 20.0 * std::f64::consts::PI).abs() < 1e-12);
    assert_eq!(arc.normal, [0.0, 0.0, -1.0]);
}

#[test]
fn planes_of_all_definitions_agree() {
    // B by 30 in every way of saying it.
    let head = "BEGIN PGM A MM\nTOOL CALL 1 Z S1 F100\n";
    let (s, c) = 30f64.to_radians().sin_cos();
    let ways = [
        "PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY".to_owned(),
        "PLANE RELATIVE SPB+30 STAY".to_owned(),
        "PLANE EULER EULPR+90 EULNU+30 EULROT-90 STAY".to_owned(),
        format!("PLANE VECTOR BX+{c:.10} BY+0 BZ-{s:.10} NX+{s:.10} NY+0 NZ+{c:.10} STAY"),
        format!("PLANE POINTS P1X+0 P1Y+0 P1Z+0 P2X+{c:.10} P2Y+0 P2Z-{s:.10} P3X+0 P3Y+5 P3Z+0 STAY"),
        "CYCL DEF 19.0 P\nCYCL DEF 19.1 A+0 B+30 C+0".to_owned(),
    ];
    for way in ways {
        let ops = ops(&format!("{head}{way}\nL X+1 Y+2 Z+3 FMAX\n"));
        let got = motions(&ops)[0].end_base.xyz().unwrap();
        assert!(distance(got, [c + 3.0 * s, 2.0, -s + 3.0 * c]) < 1e-9, "{way} {got:?}");
    }
}

#[test]
fn projected_and_axial_planes_are_rotations() {
    // PROPR alone turns about Y, PROMIN alone about X; ROT then about the new Z.
    let (s, c) = 30f64.to_radians().sin_cos();
    let head = "BEGIN PGM A MM\nTOOL CALL 1 Z S1 F100\n";
    for (way, x, z) in [
        ("PLANE PROJECTED PROPR+30 PROMIN+0 ROT+0 STAY", [c, 0.0, -s], [s, 0.0, c]),
        ("PLANE PROJECTED PROPR+0 PROMIN+30 ROT+0 STAY", [1.0, 0.0, 0.0], [0.0, -s, c]),
        ("PLANE PROJECTED PROPR+0 PROMIN+30 ROT+90 STAY", [0.0, c, s], [0.0, -s, c]),
        ("PLANE AXIAL B+30 STAY", [c, 0.0, -s], [s, 0.0, c]),
        ("PLANE AXIAL B+30 C+90 STAY", [0.0, c, -s], [0.0, s, c]),
        ("PLANE AXIAL A-30 TURN FMAX", [1.0, 0.0, 0.0], [0.0, s, c]),
    ] {
        let ops = ops(&format!("{head}{way}\nL X+1 Y+0 Z+0 FMAX\nL X+0 Z+1 FMAX\n"));
        let all = motions(&ops);
        let last: Vec<_> = all.iter().rev().take(2).map(|m| m.end_base.xyz().unwrap()).collect();
        assert!(distance(last[1], x) < 1e-12 && distance(last[0], z) < 1e-12, "{way} {last:?}");
        assert!(ops.iter().any(|op| matches!(op, Op::Note(text) if text.starts_with(proveout_nc::ASSUMED))), "{way}");
        if way.contains("TURN") {
            assert_eq!(all[0].end.get(3), Some(-30f64.to_radians()));
        }
    }
    // The line in which a plane cuts Z X has the angle PROPR, that in Y Z the angle PROMIN, whatever both
    // are.
    for (p, m) in [(20.0f64, 50.0f64), (-35.0, 10.0), (60.0, -70.0)] {
        let ops = ops(&format!("{head}PLANE PROJECTED PROPR{p:+} PROMIN{m:+} ROT+0 STAY\nL X+0 Y+0 Z+1 FMAX\n"));
        let n = motions(&ops)[0].end_base.xyz().unwrap();
        assert!(
            (n[0] / n[2] - p.to_radians().tan()).abs() < 1e-9 && (-n[1] / n[2] - m.to_radians().tan()).abs() < 1e-9,
            "{n:?}"
        );
    }
    for bad in
        ["PLANE PROJECTED PROPR+90 PROMIN+0 ROT+0 STAY", "PLANE PROJECTED PROPR+9 ROT+0 STAY", "PLANE AXIAL STAY"]
    {
        let code = code(Dialect::Heidenhain, &format!("{head}{bad}\n"));
        assert!(matches!(&*code, "nc-bad-value" | "nc-missing-value"), "{bad}: {code}");
    }
}

#[test]
fn system_data_that_the_program_has_set_are_read() {
    let text = "BEGIN PGM A MM\nTOOL CALL 7 Z S1500 F100\nL X+10 Y+20 Z+30 FMAX M4 M8\nFN 18: SYSREAD Q1 = ID20 NR1\nFN 18: SYSREAD Q2 = ID20 NR4\n\
                FN 18: SYSREAD Q3 = ID270 NR1 IDX2\nFN 18: SYSREAD Q4 = ID20 NR5\nFN 18: SYSREAD Q5 = ID20 NR8\nL X+Q1 Y+Q2 Z+Q3 FMAX\nL X+Q4 Y+Q5 FMAX\n";
    let ops = ops(text);
    let ends: Vec<_> = motions(&ops).iter().map(|m| m.end.xyz().unwrap()).collect();
    assert_eq!(ends[1..], [[7.0, 1500.0, 20.0], [1.0, 1.0, 20.0]]);
    let unknown = "BEGIN PGM A MM\nTOOL CALL \"X\" Z S1\nFN 18: SYSREAD Q1 = ID20 NR1\n";
    assert_eq!(code(Dialect::Heidenhain, unknown), "nc-unknown-variable");
}

/// Words that the README says are refused, each with a block that holds it.
const REFUSED: &[(&str, &str)] = &[
    ("FZ", "L X+1 FZ0.1"),
    ("FT", "L X+1 FT2"),
    ("R+", "X+1 R+ F100"),
    ("M103", "L X+1 F100 M103 F0.5"),
    ("M114", "L M114"),
    ("M130", "L X+1 FMAX M130"),
    ("M144", "L M144"),
    ("FK", "FL X+1"),
    ("SPL", "SPL X+1"),
    ("TCH PROBE", "TCH PROBE 400"),
    ("SEL TABLE", "SEL TABLE \"A.D\""),
    ("SEL CONTOUR", "SEL CONTOUR \"A\""),
    ("GLOBAL DEF", "GLOBAL DEF 100"),
    ("FN 17", "FN 17: SYSWRITE ID10"),
    ("FN 24", "FN 24: Q1 = CDATA Q2"),
    ("FN 26", "FN 26: TABOPEN X"),
    ("FUNCTION PARAXCOMP", "FUNCTION PARAXCOMP DISPLAY X"),
    ("FUNCTION MODE TURN", "FUNCTION MODE TURN"),
    ("FUNCTION MODE SET", "FUNCTION MODE SET \"ROTARY_TABLE\""),
    ("MILL KINEMATICS", "FUNCTION MODE MILL KINEMATICS \"HEAD_2\""),
    ("M138", "L M138 C"),
    (
        "Q347",
        "CYCL DEF 233 X Q215=1 Q389=0 Q350=1 Q218=5 Q219=5 Q227=1 Q386=0 Q369=0 Q202=1 Q370=1 Q207=5 Q385=5 Q253=5 Q357=2 Q200=2 Q204=9 Q347=1",
    ),
    ("266", "CYCL DEF 266 X"),
    ("267", "CYCL DEF 267 X"),
    ("270", "CYCL DEF 270 X"),
    ("VC", "TOOL CALL 1 Z S( VC = 100 )"),
    ("PREDEF", "CYCL DEF 200 X Q200=PREDEF"),
    ("FSELECT", "FSELECT 1"),
    ("SL and OCM", "CYCL DEF 22 ROUGH Q10=-5"),
    ("FUNCTION FEED", "FUNCTION FEED DWELL D-TIME0.5"),
    ("DECIMALS", "QS1 = TOCHAR ( DAT+Q1 DECIMALS3 )"),
    ("Q395", "CYCL DEF 200 X Q200=1 Q201=-1 Q395=1"),
    ("REFPNT", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT CENTER-CENTER"),
];

#[test]
fn the_table_of_the_readme_is_true() {
    let readme = include_str!("../README.md");
    let section = readme.split("## Coverage: Heidenhain").nth(1).unwrap().split("\n## ").next().unwrap();
    let refused = section.split("**refused by name**").nth(1).unwrap();
    for (name, block) in REFUSED {
        assert!(refused.contains(name), "{name} is not in the table");
        assert_eq!(
            code(Dialect::Heidenhain, &format!("BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\n{block}\n")),
            "nc-unsupported-word",
            "{block}"
        );
    }
    for g in ["G26", "G27", "G43", "G83", "G84", "G85", "G271", "G55", "G74"] {
        assert!(refused.contains(g), "{g} is not in the table");
        assert_eq!(code(Dialect::HeidenhainIso, &format!("%A G71 *\nN10 {g} X+1 *\n")), "nc-unsupported-word", "{g}");
    }
}

#[test]
fn limits_are_named() {
    let deep = format!("Q1 = {}1{}\n", "(".repeat(200), ")".repeat(200));
    assert_eq!(code(Dialect::Heidenhain, &deep), "nc-nesting-limit");
    let relative = format!("BEGIN PGM A MM\n{}", "PLANE RELATIVE SPB+1 STAY\n".repeat(200));
    assert_eq!(code(Dialect::Heidenhain, &relative), "nc-nesting-limit");
    let many: String = (0..1500).map(|i| format!("Q{i} = 1\n")).collect();
    assert_eq!(code(Dialect::Heidenhain, &many), "nc-bad-value");
    // A sheer endless doubling of calls.
    let calls: String = (1..30).map(|i| format!("LBL {i}\nCALL LBL {}\nCALL LBL {}\nLBL 0\n", i + 1, i + 1)).collect();
    let text = format!("CALL LBL 1\nM30\n{calls}LBL 30\nLBL 0\n");
    assert_eq!(code(Dialect::Heidenhain, &text), "nc-loop-limit");
}

#[test]
fn faults_stand_in_their_line_of_a_long_block() {
    let text = "BEGIN PGM A MM\nCYCL DEF 200 DRILLING ~\n  Q200=2 ;CLEARANCE ~\n  Q201=-5 X9 ;DEPTH\nM30\n";
    let faults = check_text("p.h", text, &settings(Dialect::Heidenhain));
    let found: Vec<_> = faults.iter().map(|f| (f.line, f.column, f.length, f.code)).collect();
    assert_eq!(found, [(4, 11, 2, "nc-unknown-word")], "{faults:?}");
    assert_eq!(&*faults[0].source_line, "  Q201=-5 X9 ;DEPTH");
}
