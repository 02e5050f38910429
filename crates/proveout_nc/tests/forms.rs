//! Forms of real programs against their closed forms: corners of ISO controls, lines by their angle, curves
//! in the plane, bolt holes, the reference point of CL data.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use crate::common::cases;
use proptest::prelude::*;
use proveout_nc::{AxisValues, Control, Dialect, Op, Program, ReferencePoints, Settings};

type P = [f64; 2];

fn read_with(text: &str, settings: &Settings) -> Result<Vec<Op>, String> {
    let program = Program::from_text("program", text, settings).map_err(|faults| faults.to_string())?;
    let commands: Result<Vec<_>, _> = program.collect();
    commands.map(|commands| commands.into_iter().map(|c| c.op).collect()).map_err(|fault| {
        format!("{}:{} {fault}; {}", fault.line, fault.code, fault.help.as_deref().unwrap_or_default())
    })
}

fn read(dialect: Dialect, text: &str) -> Result<Vec<Op>, String> {
    read_with(text, &Settings { dialect, ..Settings::default() })
}

fn ops(dialect: Dialect, text: &str) -> Vec<Op> {
    read(dialect, text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn moves(ops: &[Op]) -> Vec<&Op> {
    ops.iter().filter(|op| matches!(op, Op::Linear(_) | Op::Arc(_))).collect()
}

fn end(op: &Op) -> AxisValues {
    match op {
        Op::Rapid(m) | Op::Linear(m) => m.end,
        Op::Arc(a) => a.motion.end,
        Op::Spline(s) => s.motion.end,
        other => panic!("{other:?}"),
    }
}

fn in_plane(op: &Op, [u, v, _]: [usize; 3]) -> P {
    let end = end(op);
    [end.get(u).unwrap(), end.get(v).unwrap()]
}

fn near(a: P, b: P, text: &str) {
    assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6, "{a:?} {b:?}\n{text}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(300)))]

    /// A corner between two lines, in all planes, in mm and inch, absolute and incremental, with the third
    /// axis known or not: the piece begins and ends by leg, or by r tan(turn / 2), from the corner. Turns
    /// from 2 to 170 degrees on both sides.
    #[test]
    fn a_corner_of_two_lines(
        direction in 0.0..std::f64::consts::TAU,
        turn in 2.0f64..170.0,
        left in any::<bool>(),
        lengths in [20.0f64..60.0, 20.0..60.0],
        rounding in any::<bool>(),
        part in 0.01f64..0.99,
        plane in 0usize..3,
        inch in any::<bool>(),
        incremental in any::<bool>(),
        known in any::<bool>(),
        haas in any::<bool>(),
    ) {
        let turn = turn.to_radians() * if left { 1.0 } else { -1.0 };
        let (s, t) = (P::from(direction.sin_cos()), P::from((direction + turn).sin_cos()));
        let (s, t) = ([s[1], s[0]], [t[1], t[0]]);
        let corner = [lengths[0] * s[0], lengths[0] * s[1]];
        let last = [corner[0] + lengths[1] * t[0], corner[1] + lengths[1] * t[1]];
        // Back from the corner along both lines.
        let back = part * lengths[0].min(lengths[1]);
        let size = if rounding { back / (0.5 * turn.abs()).tan() } else { back };
        let unit = if inch { 25.4 } else { 1.0 };
        let (word, axes, letters) = [("G17", [0, 1, 2], ["X", "Y", "Z"]), ("G18", [2, 0, 1], ["Z", "X", "Y"]), ("G19", [1, 2, 0], ["Y", "Z", "X"])][plane];
        let at = |p: P, q: P| {
            let by = if incremental { [p[0] - q[0], p[1] - q[1]] } else { p };
            format!("{}{:.9} {}{:.9}", letters[0], by[0] / unit, letters[1], by[1] / unit)
        };
        let third = if known { format!("{}1.", letters[2]) } else { String::new() };
        let text = format!(
            "{} {word} G90 G0 {}0. {}0. {third}\n{} G1 {} ,{}{:.9} F100.\nG4 P100\n{}\nM30\n",
            if inch { "G20" } else { "G21" }, letters[0], letters[1], if incremental { "G91" } else { "G90" },
            at(corner, [0.0; 2]), if rounding { "R" } else { "C" }, size / unit, at(last, corner),
        );
        let ops = ops(if haas { Dialect::Haas } else { Dialect::Fanuc }, &text);
        let found = moves(&ops);
        assert_eq!(found.len(), 3, "{text}");
        near(in_plane(found[0], axes), [corner[0] - back * s[0], corner[1] - back * s[1]], &text);
        near(in_plane(found[1], axes), [corner[0] + back * t[0], corner[1] + back * t[1]], &text);
        near(in_plane(found[2], axes), last, &text);
        // The dwell comes after the piece, which belongs to the first block.
        let dwell = ops.iter().position(|op| matches!(op, Op::Dwell(_))).unwrap();
        assert_eq!(moves(&ops[..dwell]).len(), 2, "{text}");
        if let Op::Arc(arc) = found[1] {
            assert!(rounding && (arc.radius - size).abs() < 1e-6 && (arc.sweep - turn.abs()).abs() < 1e-6, "{arc:?}\n{text}");
            // X to Y, Y to Z and Z to X turn about the third axis.
            prop_assert_eq!(arc.normal[axes[2]] > 0.0, left);
        } else {
            assert!(!rounding, "{text}");
        }
    }

    /// A line by its angle ends where the line by both coordinates does.
    #[test]
    fn a_line_by_its_angle(
        angle in 0.0f64..360.0,
        length in 0.1f64..200.0,
        from in [-50.0f64..50.0, -50.0..50.0],
        plane in 0usize..3,
        second in any::<bool>(),
        incremental in any::<bool>(),
        turns in -1i32..2,
    ) {
        let (word, axes, letters) = [("G17", [0, 1, 2], ["X", "Y"]), ("G18", [2, 0, 1], ["Z", "X"]), ("G19", [1, 2, 0], ["Y", "Z"])][plane];
        let (s, c) = angle.to_radians().sin_cos();
        let given = usize::from(second);
        prop_assume!([c, s][given].abs() > 1e-3);
        let to = [from[0] + length * c, from[1] + length * s];
        let value = if incremental { to[given] - from[given] } else { to[given] };
        let text = format!(
            "{word} G90 G0 X0 Y0 Z0\nG1 {}={:.12} {}={:.12} F100\n{} {}={value:.12} ANG={:.12}\nM30\n",
            letters[0], from[0], letters[1], from[1], if incremental { "G91" } else { "G90" }, letters[given],
            angle + 360.0 * f64::from(turns),
        );
        let ops = ops(Dialect::Siemens840d, &text);
        near(in_plane(moves(&ops)[1], axes), to, &text);
    }

    /// Two lines by their angles meet where the lines were drawn, in all planes, with a rounding at the
    /// corner or none, through a turned frame or none, after angles counted on by whole turns. Corners of
    /// less than 3 degrees are left out.
    #[test]
    fn two_lines_by_their_angles(
        angle in 0.0f64..360.0,
        turn in prop_oneof![3.0f64..177.0, -177.0f64..-3.0],
        lengths in [1.0f64..200.0, 1.0..200.0],
        from in [-50.0f64..50.0, -50.0..50.0],
        plane in 0usize..3,
        turned in any::<bool>(),
        radius in prop::option::of(10u32..20),
        turns in -1i32..2,
    ) {
        let (word, axes, letters) = [("G17", [0, 1, 2], ["X", "Y"]), ("G18", [2, 0, 1], ["Z", "X"]), ("G19", [1, 2, 0], ["Y", "Z"])][plane];
        let ((s, c), (s2, c2)) = (angle.to_radians().sin_cos(), (angle + turn).to_radians().sin_cos());
        let corner = [from[0] + lengths[0] * c, from[1] + lengths[0] * s];
        let to = [corner[0] + lengths[1] * c2, corner[1] + lengths[1] * s2];
        let frame = if turned { "ROT RPL=30" } else { "" };
        let radius = radius.map(|r| f64::from(r) / 1000.0);
        let rounding = radius.map_or(String::new(), |r| format!(" RND={r}"));
        let text = format!(
            "{word} G90 G0 X0 Y0 Z0\n{frame}\nG1 {}={:.12} {}={:.12} F100\nANG={:.12}{rounding}\n; between\n{}={:.12} {}={:.12} ANG={:.12} F200\nM30\n",
            letters[0], from[0], letters[1], from[1], angle, letters[0], to[0], letters[1], to[1],
            angle + turn + 360.0 * f64::from(turns),
        );
        let ops = ops(Dialect::Siemens840d, &text);
        let found = moves(&ops);
        prop_assert_eq!(found.len(), if radius.is_some() { 4 } else { 3 }, "{}", text);
        // The rounding of r takes r tan(turn / 2) off the first line.
        let off = radius.map_or(0.0, |r| r * (turn.to_radians() / 2.0).tan().abs());
        prop_assume!(off < 0.9);
        near(in_plane(found[1], axes), [corner[0] - off * c, corner[1] - off * s], &text);
        near(in_plane(found.last().unwrap(), axes), to, &text);
        let feed = |op: &Op| matches!(op, Op::Feed(_));
        let first = ops.iter().position(|op| std::ptr::eq(op, found[1])).unwrap();
        prop_assert!(ops[first..].iter().any(feed), "the feed of the second block comes behind the first line");
    }

    /// G83 of a Fagor: every infeed goes J times by I below the plane, comes out to the plane, and goes back
    /// to 1 mm above the last depth, never above the plane; G98 and G99. Corners: one infeed, infeeds shorter
    /// than 1 mm, the plane below zero.
    #[test]
    fn infeeds_of_a_fagor(plane in -50i32..50, infeed in 1u32..400, count in 1u32..12, to_plane in any::<bool>()) {
        let (plane, infeed) = (f64::from(plane), f64::from(infeed) / 20.0);
        let text = format!(
            "G71 G90 G0 X0 Y0 Z80\n{} G83 X5 Y6 Z{plane} I-{infeed} J{count} F100\nG80\nM30\n",
            if to_plane { "G99" } else { "G98" },
        );
        let mut want = vec![(true, plane)];
        for i in 1..=count {
            want.push((false, plane - infeed * f64::from(i)));
            if i < count {
                want.push((true, plane));
                want.push((true, (plane - infeed * f64::from(i) + 1.0).min(plane)));
            }
        }
        want.push((true, if to_plane { plane } else { 80.0 }));
        // A stroke to where the tool is already is none.
        want.dedup_by(|now, before| now.0 && (now.1 - before.1).abs() < 1e-12);
        let program = Program::from_text("a", &text, &Settings::of_control(Control::find("fagor-8055", None).unwrap())).unwrap();
        let strokes: Vec<(bool, f64)> = program.filter_map(|command| match command.unwrap().op {
            Op::Rapid(m) => Some((true, m.end.get(2).unwrap())),
            Op::Linear(m) => Some((false, m.end.get(2).unwrap())),
            _ => None,
        }).skip(2).collect();
        prop_assert_eq!(strokes.len(), want.len(), "{}\n{:?}\n{:?}", text, strokes, want);
        for (got, want) in strokes.iter().zip(&want) {
            prop_assert!(got.0 == want.0 && (got.1 - want.1).abs() < 1e-9, "{text}\n{strokes:?}\n{want:?}");
        }
    }

    /// Common variables, jumps and calls of an Okuma give what the same program with macro B gives. Corners:
    /// loops of one pass, no pass of a subprogram, sums of one term.
    #[test]
    fn an_okuma_counts_as_macro_b_does(
        start in -20i32..20,
        step in 1i32..9,
        last in -20i32..40,
        passes in 0u32..4,
        terms in prop::collection::vec((prop::sample::select(vec!["+", "-", "*"]), 1i32..9), 0..4),
    ) {
        let sum: String = terms.iter().map(|(operator, value)| format!("{operator}{value}")).collect();
        let okuma = format!(
            "$A.MIN%\nO1\nG21 G90 G0 X0. Y0. Z0.\nVC1={start}\nVC2=0\nN10 X=VC1{sum} Y=[VC1+1]*2\nVC1=VC1+{step}\n\
             IF [VC1 LT {last}] N10\nCALL O2 Q{passes}\nM2\nO2\nVC2=VC2+1\nZ=-VC2\nRTS\n"
        );
        let fanuc = format!(
            "O1\nG21 G90 G0 X0. Y0. Z0.\n#101={start}\n#102=0\nN10 X[#101{sum}] Y[[#101+1]*2]\n#101=#101+{step}\n\
             IF [#101 LT {last}] GOTO 10\n{}M2\nO2\n#102=#102+1\nZ-#102\nM99\n",
            if passes == 0 { String::new() } else { format!("M98 P2 L{passes}\n") },
        );
        let ends = |control: &str, text: &str| -> Vec<Option<[f64; 3]>> {
            let settings = Settings::of_control(Control::find(control, None).unwrap());
            let program = Program::from_text("a", text, &settings).unwrap();
            program.filter_map(|c| match c.unwrap_or_else(|e| panic!("{e}\n{text}")).op {
                Op::Rapid(m) => Some(m.end.xyz()),
                _ => None,
            }).collect()
        };
        prop_assert_eq!(ends("okuma-osp", &okuma), ends("fanuc-30i", &fanuc), "{}", okuma);
    }

    /// Where Z is not known, a curve of X and Y is the same as with it, as chords; every chord end lies on
    /// the curve with Z.
    #[test]
    fn curves_without_z(points in prop::collection::vec([-40i32..40, -40..40], 3..8), kind in 0usize..3) {
        let word = ["BSPLINE", "CSPLINE", "ASPLINE"][kind];
        let mut body = format!("{word}\n");
        for [x, y] in &points {
            body.push_str(&format!("X{x} Y{y}\n"));
        }
        let with = ops(Dialect::Siemens840d, &format!("G0 X50 Y50 Z3\nG1 F100\n{body}G1 X0 Y0\nM30\n"));
        let without = ops(Dialect::Siemens840d, &format!("G0 X50 Y50\nG1 F100\n{body}G1 X0 Y0\nM30\n"));
        let mut at = [50.0, 50.0];
        let mut curve: Vec<P> = vec![at];
        for op in &with {
            let to = match op {
                Op::Spline(s) => {
                    let [a, b] = s.control.map(|p| [p[0], p[1]]);
                    let to = in_plane(op, [0, 1, 2]);
                    for i in 1..=400 {
                        let t = f64::from(i) / 400.0;
                        let b3 = [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
                        curve.push([0, 1].map(|k| b3[0] * at[k] + b3[1] * a[k] + b3[2] * b[k] + b3[3] * to[k]));
                    }
                    to
                }
                Op::Linear(_) => {
                    let to = in_plane(op, [0, 1, 2]);
                    curve.push(to);
                    to
                }
                _ => continue,
            };
            at = to;
        }
        // Distance of a point to the curve sampled so finely that a chord is off by less than 0.02 mm.
        let off = |p: P| {
            curve.windows(2).map(|w| {
                let d = [w[1][0] - w[0][0], w[1][1] - w[0][1]];
                let l = d[0] * d[0] + d[1] * d[1];
                let t = if l > 0.0 { (((p[0] - w[0][0]) * d[0] + (p[1] - w[0][1]) * d[1]) / l).clamp(0.0, 1.0) } else { 0.0 };
                (w[0][0] + t * d[0] - p[0]).hypot(w[0][1] + t * d[1] - p[1])
            }).fold(f64::MAX, f64::min)
        };
        let flat = moves(&without);
        prop_assert!(flat.len() >= points.len());
        for op in &flat {
            prop_assert!(matches!(op, Op::Linear(m) if m.end.get(2).is_none() && m.end_base.get(2).is_none()));
            prop_assert!(off(in_plane(op, [0, 1, 2])) < 0.02);
        }
        near(in_plane(flat.last().unwrap(), [0, 1, 2]), [0.0, 0.0], "the end");
    }
}

/// A curve that would take more chords than anyone writes is refused, whether Z is known or a weight asks for
/// chords.
#[test]
fn a_curve_of_endless_chords_is_refused() {
    for start in ["G0 X0 Y0", "G0 X0 Y0 Z0"] {
        let text = format!("{start}\nG1 F100\nBSPLINE\nX1e12 Y0 PW=2\nX0 Y1e12\nX5 Y5\nX7 Y1\nG1 X0 Y0\nM30\n")
            .replace("1e12", "1EX12");
        let fault = read(Dialect::Siemens840d, &text).expect_err(&text);
        assert!(fault.contains("more than 20000 chords"), "{fault}");
    }
}

#[test]
fn a_corner_that_cannot_be_is_refused_at_its_block() {
    for (dialect, text, line, says) in [
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,C2. F100.\nG0 Y5.\nM30\n", 2, "makes no corner"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,C2. F100.\nG1 Z5.\nM30\n", 2, "makes no corner"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,R2. F100.\nM30\n", 2, "makes no corner"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,R2. F100.\nG18\nG1 Z5.\nM30\n", 2, "makes no corner"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,R12. F100.\nY8.\nM30\n", 2, "does not fit"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,C9. F100.\nY8.\nM30\n", 2, "does not fit"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,C-1. F100.\nY8.\nM30\n", 2, "must not be negative"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,C1. ,R1. F100.\nY8.\nM30\n", 2, "both `,C` and `,R`"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,C1. ,C1. F100.\nY8.\nM30\n", 2, "twice"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0. ,C1.\nM30\n", 1, "need a motion of G1, G2 or G3"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 F100. ,C1.\nX5.\nM30\n", 2, "need a motion"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z9.\nG81 X5. Z-1. R1. F100. ,C1.\nG80\nM30\n", 2, "need a motion"),
        (Dialect::Fanuc, "G65 P2 ,C1.\nM30\nO2\nM99\n", 1, "has no motion in this block"),
        (Dialect::Fanuc, "G21 G0 X0. Y0. Z0.\nG1 X10. ,A45. F100.\nY8.\nM30\n", 2, "`,` has no meaning"),
        (Dialect::Haas, "G21 G0 X0. Y0. Z0.\nG1 X10. ,R2. F100.\nG3 X0. Y10. I-10. J0.\nM30\n", 2, "makes no corner"),
        (
            Dialect::Haas,
            "G21 G0 X0. Y0. Z0.\nG1 F100.\nG3 X10. Y10. I0. J10. ,R2.\nG1 X0.\nM30\n",
            3,
            "need a motion of G1",
        ),
        (Dialect::LinuxCnc, "G21 G0 X0 Y0 Z0\nG1 X10 ,C2 F100\nY5\nM2\n", 2, "`,` has no meaning"),
    ] {
        let fault = read(dialect, text).expect_err(text);
        assert!(fault.starts_with(&format!("{line}:")) && fault.contains(says), "{says}: {fault}\n{text}");
        assert!(fault.rsplit("; ").next().is_some_and(|remedy| !remedy.is_empty()), "{fault}");
    }
}

#[test]
fn an_angle_that_gives_no_end_is_refused() {
    for (block, says) in [
        ("G1 X10 ANG=90", "does not move X"),
        ("G1 Y10 ANG=180", "does not move Y"),
        ("G1 X10 ANG=180", "leads away"),
        ("G1 X10 Y10 ANG=45", "second of two lines"),
        ("G1 ANG=45 Z2", "takes only G0 or G1"),
        ("G1 ANG=45 CR=2", "takes only G0 or G1"),
        ("G1 ANG=45 FB=2", "takes only G0 or G1"),
        ("G1 ANG=45 M9", "acts after the motion"),
        ("G1 ANG=45 L100", "acts after the motion"),
        ("G2 X10 ANG=45 CR=5", "angle of a straight line"),
        ("SUPA G1 X10 ANG=45", "angle of a straight line"),
    ] {
        let text = format!("G0 X0 Y0 Z0\nF100\n{block}\nM30\n");
        let fault = read(Dialect::Siemens840d, &text).expect_err(&text);
        assert!(fault.starts_with("3:") && fault.contains(says), "{says}: {fault}");
    }
}

#[test]
fn two_lines_without_a_corner_are_refused() {
    for (blocks, line, says) in [
        ("G1 ANG=45\nX10 Y5", 4, "line 3 has ANG= alone"),
        ("G1 ANG=45\nX10 ANG=0", 4, "line 3 has ANG= alone"),
        ("G1 ANG=45\nR1=5\nX10 Y5 ANG=0", 4, "line 3 has ANG= alone"),
        ("G1 ANG=45\nIF 1==1\nENDIF\nX10 Y5 ANG=0", 4, "line 3 has ANG= alone"),
        ("G1 ANG=45\nM8\nX10 Y5 ANG=0", 4, "line 3 has ANG= alone"),
        ("G1 ANG=45\nG2 X10 Y5 ANG=0 CR=9", 4, "line 3 has ANG= alone"),
        ("G1 ANG=45\nX10 Y10 ANG=225", 4, "parallel"),
        ("G1 ANG=45\nX10 Y5 ANG=45", 4, "parallel"),
        ("G1 ANG=45\nX10 Y5 ANG=90", 4, "second line would run against"),
        ("G1 ANG=225\nX10 Y5 ANG=0", 4, "first line would run against"),
        ("G1 ANG=45\nG91 X10 Y5 ANG=0", 4, "is an increment"),
        ("G1 ANG=45\nX=IC(10) Y5 ANG=0", 4, "is an increment"),
        ("G1 ANG=45\nG55 X10 Y5 ANG=0", 4, "changes the plane"),
        ("G1 ANG=45\nG18 X10 Y5 Z3 ANG=10", 4, "changes the plane"),
        ("G1 ANG=45\nG41 D1 X10 Y5 ANG=0", 4, "changes the plane"),
        ("G1 ANG=45\nSUPA X10 Y5 ANG=0", 4, "changes the plane"),
        ("MCALL CYCLE81(5,0,1,-5)\nG1 ANG=45\nX10 Y5 ANG=0\nMCALL", 4, "MCALL is in force"),
        ("G1 ANG=45", 4, "line 3 has ANG= alone"),
    ] {
        let text = format!("G0 X0 Y0 Z0\nF100\n{blocks}\nM30\n");
        let fault = read(Dialect::Siemens840d, &text).expect_err(&text);
        assert!(fault.starts_with(&format!("{line}:")) && fault.contains(says), "{says}: {fault}\n{text}");
    }
    // The end of the text, without M30.
    let fault = read(Dialect::Siemens840d, "G0 X0 Y0\nG1 F5 ANG=45\n").unwrap_err();
    assert!(fault.contains("line 2 has ANG= alone"), "{fault}");
}

/// G70 and G71 of a Haas: the manual's example of twelve holes, and an arc; every hole is drilled once, and
/// no other.
#[test]
fn bolt_holes_lie_on_their_circle() {
    let text = "G20 G90 G54 G0 X1. Y2. S1000 M3\nG43 H1 Z.1\nG81 G98 Z-1. R.1 F15. L0\nG70 I5. J15. L12\nG80\nM30\n";
    let ops = ops(Dialect::Haas, text);
    let holes: Vec<P> = ops.iter().filter(|op| matches!(op, Op::Linear(_))).map(|op| in_plane(op, [0, 1, 2])).collect();
    assert_eq!(holes.len(), 12);
    for (i, hole) in holes.iter().enumerate() {
        let (s, c) = (15.0 + 30.0 * i as f64).to_radians().sin_cos();
        near(*hole, [25.4 * (1.0 + 5.0 * c), 25.4 * (2.0 + 5.0 * s)], text);
    }
    for (block, says) in [
        ("G70 I5. L3", "no drilling cycle"),
        ("G81 G98 Z-1. R.1 F15. G70 I5. L3", "words of a cycle"),
        ("G81 G98 Z-1. R.1 F15. L0\nG70 J5. L3", "has no I"),
        ("G81 G98 Z-1. R.1 F15. L0\nG71 I5. L3", "has no K"),
        ("G81 G98 Z-1. R.1 F15. L0\nG70 I5. L2.5", "whole number"),
        ("G81 G98 Z-1. R.1 F15. L0\nG72 I5. L2", "first hole"),
        ("G73 G98 Z-1. R.1 Q.1 J.1 F15.", "belong to a first infeed"),
        ("G83 G98 Z-1. R.1 Q.1 K.1 F15.", "belong to a first infeed"),
    ] {
        let text = format!("G20 G90 G54 G0 X1. Y2. S1000 M3\nG43 H1 Z.1\n{block}\nG80\nM30\n");
        let fault = read(Dialect::Haas, &text).expect_err(&text);
        assert!(fault.contains(says), "{says}: {fault}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(200)))]

    /// G51 and G68 of a Haas: a point is turned about the center of G68, then scaled about that of G51; radii
    /// are scaled.
    #[test]
    fn scaled_and_turned(
        factor in 0.01f64..20.0, about in [-50.0f64..50.0, -50.0..50.0], center in [-50.0f64..50.0, -50.0..50.0],
        angle in -180.0f64..180.0, to in [-80.0f64..80.0, -80.0..80.0], radius in 1.0f64..30.0, incremental in any::<bool>(),
    ) {
        let r = |v: f64| (v * 1e4).round() / 1e4;
        let (factor, angle, radius) = (r(factor), r(angle), r(radius));
        let (about, center, to) = (about.map(r), center.map(r), to.map(r));
        let text = format!(
            "G21 G17 G90 G54 G0 X0. Y0. Z5. S100 M3\nG51 X{} Y{} Z0. P{factor:.4}\nG68 X{} Y{} R{angle:.4}\nG1 X{} Y{} F100.\n{}\nG69\nG50\nG0 X1. Y1.\nM30\n",
            about[0], about[1], center[0], center[1], to[0], to[1],
            if incremental { format!("G91 G2 X{r:.4} Y{r:.4} I{r:.4} J0.\nG90", r = radius) } else { format!("G2 X{:.4} Y{:.4} I{radius:.4} J0.", to[0] + radius, to[1] + radius) },
        );
        let base = |p: P| {
            let (s, c) = angle.to_radians().sin_cos();
            let d = [p[0] - center[0], p[1] - center[1]];
            let turned = [center[0] + c * d[0] - s * d[1], center[1] + s * d[0] + c * d[1]];
            [about[0] + factor * (turned[0] - about[0]), about[1] + factor * (turned[1] - about[1])]
        };
        let at = |op: &Op| match op {
            Op::Rapid(m) | Op::Linear(m) => [m.end_base.get(0).unwrap(), m.end_base.get(1).unwrap()],
            Op::Arc(a) => [a.motion.end_base.get(0).unwrap(), a.motion.end_base.get(1).unwrap()],
            other => panic!("{other:?}"),
        };
        let ops = ops(Dialect::Haas, &text);
        let found = moves(&ops);
        near(at(found[0]), base(to), &text);
        near(at(found[1]), base([to[0] + radius, to[1] + radius]), &text);
        let Op::Arc(arc) = found[1] else { panic!("{text}") };
        prop_assert!((arc.radius - factor * radius).abs() < 1e-6 * factor.max(1.0) * radius, "{arc:?} {text}");
        let last = ops.iter().rev().find(|op| matches!(op, Op::Rapid(_))).unwrap();
        near(at(last), [1.0, 1.0], &text);
    }

    /// Klartext with decimal commas is the same program as with points.
    #[test]
    fn decimal_commas(values in prop::collection::vec(-9999.999f64..9999.999, 4), feed in 1.0f64..9000.0, turn in -180.0f64..180.0) {
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100 F{feed:.1}\nQ1 = {:.3} + 0.5\nCYCL DEF 7.0\nCYCL DEF 7.1 X-Q1\nCYCL DEF 7.2 Y{:+.3}\nCYCL DEF 10.0\nCYCL DEF 10.1 ROT{turn:+.2}\nL X{:+.3} Y{:+.3} Z+0.25 R0 FMAX\nEND PGM A MM\n",
            values[0], values[1], values[2], values[3],
        );
        let with = format!("{:?}", ops(Dialect::Heidenhain, &text));
        let without = format!("{:?}", ops(Dialect::Heidenhain, &text.replace('.', ",").replace("DEF 7,", "DEF 7.").replace("DEF 10,", "DEF 10.")));
        prop_assert_eq!(with, without);
    }
}

#[test]
fn scaling_that_the_twin_does_not_follow_is_refused() {
    for (block, says) in [
        ("G51 X0. Y0.", "settings of the control"),
        ("G51 X0. P0.", "0.001 to 999.999"),
        ("G51 A5. P2.", "rotary axis"),
        ("G68 X0. Y0. R30.\nG51 P2.", "under a rotation"),
        ("G51 X0. Y0. Z0. P2.\nG1 A5. F10.", "rotary axes, and cycles"),
        ("G51 X0. Y0. Z0. P2.\nG83 Z-5. R1. Q1. F10.", "rotary axes, and cycles"),
        ("G51 X0. Y0. Z0. P2.\nG51 P3.", "the position is not known"),
        ("G1 X5. L0 F10.", "at least once"),
        ("G1 X5. ,R1. L2 F10.", "not with a chamfer"),
        ("G1 X5. L2.5 F10.", "whole number"),
    ] {
        let text = format!("G21 G90 G54 G0 X0. Y0. Z5. S100 M3\n{block}\nM30\n");
        let fault = read(Dialect::Haas, &text).expect_err(&text);
        assert!(fault.contains(says), "{says}: {fault}");
    }
    // On a Fanuc L has no meaning in a motion.
    let fault = read(Dialect::Fanuc, "G21 G90 G0 X0. Y0. Z5.\nG1 X5. L2 F10.\nM30\n").unwrap_err();
    assert!(fault.contains("`L2` has no meaning"), "{fault}");
}

#[test]
fn a_motion_is_repeated_l_times_on_a_haas() {
    let text = "G21 G17 G90 G54 G0 X5. Y0. Z0. S100 M3\nG91 G3 I-5. J0. Z-1.5 L4 F100.\nG90 G0 Z9.\nM30\n";
    let ops = ops(Dialect::Haas, text);
    let ends: Vec<_> = moves(&ops).iter().map(|op| end(op).get(2).unwrap()).collect();
    assert_eq!(ends, [-1.5, -3.0, -4.5, -6.0]);
    let turns = ops.iter().filter(|op| matches!(op, Op::Arc(a) if (a.sweep - std::f64::consts::TAU).abs() < 1e-9));
    assert_eq!(turns.count(), 4);
}

#[test]
fn cycles_of_the_machine_builder_mean_what_the_control_file_says() {
    let text = "BEGIN PGM A MM\nCYCL DEF 392 ATC ~\nQ240=0 ;MODE ~\nQ241=1 ;WEIGHT\nTOOL CALL 1 Z S100\nL X+Q241 Y+0 Z+0 FMAX\nEND PGM A MM\n";
    let fault = read(Dialect::Heidenhain, text).unwrap_err();
    assert!(fault.starts_with("2:") && fault.contains("machine builder") && fault.contains("words.CYCL392"), "{fault}");
    let with = |words: &str| {
        let control = format!("inherits = \"heidenhain-tnc-640\"\n[words.CYCL392]\n{words}\n");
        let control = Control::from_text("shop.toml", &control, None).unwrap_or_else(|e| panic!("{e}"));
        read_with(text, &Settings::of_control(control))
    };
    let ops = with("ignore = \"tunes the drives\"").unwrap();
    assert!(ops.iter().any(|op| matches!(op, Op::Note(text) if text.contains("tunes the drives"))));
    assert!(
        ops.iter().any(|op| matches!(op, Op::Rapid(m) if m.end.get(0) == Some(1.0))),
        "its parameters have their values"
    );
    let fault = with("refuse = \"take it out\"").unwrap_err();
    assert!(fault.contains("take it out"), "{fault}");
    for wrong in ["[words.CYCL392]\ncall = \"X\"", "[words.CYCL292]\nnote = \"x\"", "[words.ATC]\nnote = \"x\""] {
        let control = format!("inherits = \"heidenhain-tnc-640\"\n{wrong}\n");
        assert!(Control::from_text("shop.toml", &control, None).is_err(), "{wrong}");
    }
}

/// G73 with Q and K: out to the R plane each time the infeeds add up to K.
#[test]
fn chips_are_cleared_by_k_on_a_haas() {
    let text = "G21 G90 G54 G0 X0. Y0. Z9. S1000 M3\nG73 G99 Z-7. R1. Q2. K4. F100.\nG80\nM30\n";
    let ops = ops(Dialect::Haas, text);
    let z: Vec<f64> =
        ops.iter().filter(|op| matches!(op, Op::Rapid(_) | Op::Linear(_))).map(|op| end(op).get(2).unwrap()).collect();
    let ahead = 1.27;
    let want = [9.0, 1.0, -1.0, -1.0 + ahead, -3.0, 1.0, -3.0 + ahead, -5.0, -5.0 + ahead, -7.0, 1.0];
    assert_eq!(z.len(), want.len(), "{z:?}");
    assert!(z.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-9), "{z:?}");
}

#[test]
fn gohome_goes_to_the_reference_point_of_the_machine() {
    let text = "UNITS/MM\nRAPID\nGOTO/10,20,30\nGOHOME\nGODLTA/1,0,0\nFINI\n";
    let fault = read(Dialect::Apt, text).unwrap_err();
    assert!(fault.starts_with("5:"), "no point is known behind it: {fault}");
    let text = "UNITS/MM\nRAPID\nGOTO/10,20,30\nGOHOME\nFINI\n";
    let mut first = AxisValues::NONE;
    for (axis, value) in [-400.0, 250.0, 610.0].into_iter().enumerate() {
        first.put(axis, value);
    }
    let points = |first| ReferencePoints { machine: "M".to_owned(), axes: 0b111, first, ..ReferencePoints::default() };
    let settings = |points| Settings { dialect: Dialect::Apt, reference_points: Some(points), ..Settings::default() };
    let ops = read_with(text, &settings(points(first))).unwrap();
    let machine: Vec<_> = ops
        .iter()
        .filter_map(|op| match op {
            Op::Rapid(m) if m.machine_coordinates => Some((m.end.get(0), m.end.get(1), m.end.get(2))),
            _ => None,
        })
        .collect();
    assert_eq!(machine, [(None, None, Some(610.0)), (Some(-400.0), Some(250.0), None)]);
    let mut without_z = first;
    without_z.clear(2);
    let fault = read_with(text, &settings(points(without_z))).unwrap_err();
    assert!(fault.starts_with("4:") && fault.contains("states none") && fault.contains("home_mm"), "{fault}");
}
