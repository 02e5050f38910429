//! Splines and polynomials of an 840D against their definitions: de Boor's recursion, the polynomial itself,
//! continuity.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proptest::prelude::*;
use proveout_nc::{Dialect, Op, Program, Settings};

type P = [f64; 3];

fn ops(text: &str) -> Vec<Op> {
    let settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    Program::from_text("p.mpf", text, &settings)
        .unwrap()
        .map(|c| c.map(|c| c.op).unwrap_or_else(|e| panic!("{e}\n{text}")))
        .collect()
}

/// Bezier pieces with their starts.
fn pieces(ops: &[Op]) -> Vec<[P; 4]> {
    let mut at = [0.0; 3];
    let mut all = Vec::new();
    for op in ops {
        match op {
            Op::Rapid(m) | Op::Linear(m) => at = m.end.xyz().unwrap(),
            Op::Spline(s) => {
                let end = s.motion.end.xyz().unwrap();
                all.push([at, s.control[0], s.control[1], end]);
                at = end;
            }
            _ => {}
        }
    }
    all
}

fn bezier(piece: &[P; 4], t: f64) -> P {
    let b = [(1.0 - t).powi(3), 3.0 * t * (1.0 - t).powi(2), 3.0 * t * t * (1.0 - t), t.powi(3)];
    std::array::from_fn(|i| (0..4).map(|k| b[k] * piece[k][i]).sum())
}

fn distance(a: P, b: P) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// The basis function of de Boor and Cox.
fn basis(i: usize, degree: usize, knots: &[f64], u: f64) -> f64 {
    if degree == 0 {
        return f64::from(u8::from(knots[i] <= u && u < knots[i + 1]));
    }
    let part = |from: f64, to: f64, numerator: f64| if to > from { numerator / (to - from) } else { 0.0 };
    part(knots[i], knots[i + degree], u - knots[i]) * basis(i, degree - 1, knots, u)
        + part(knots[i + 1], knots[i + degree + 1], knots[i + degree + 1] - u) * basis(i + 1, degree - 1, knots, u)
}

fn points(text: &mut String, points: &[(i32, i32, i32)]) -> Vec<P> {
    let mut all = vec![[0.0; 3]];
    for (x, y, z) in points {
        let p = [f64::from(*x) / 1000.0, f64::from(*y) / 1000.0, f64::from(*z) / 1000.0];
        text.push_str(&format!("X={} Y={} Z={}\n", p[0], p[1], p[2]));
        all.push(p);
    }
    all
}

proptest! {
    #[test]
    fn b_splines_are_those_of_de_boor(
        list in prop::collection::vec((-50_000..50_000i32, -50_000..50_000i32, -9_000..9_000i32), 3..9), degree in 2..4usize,
        intervals in prop::collection::vec(1..40u32, 9), with_intervals in any::<bool>(),
    ) {
        let mut text = format!("G0 X0 Y0 Z0\nG1 F100\nBSPLINE SD={degree}\n");
        let control = points(&mut text, &list);
        if with_intervals {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            for (line, interval) in lines[3..].iter_mut().zip(&intervals) {
                line.push_str(&format!(" PL={}", f64::from(*interval) / 10.0));
            }
            text = lines.join("\n") + "\n";
        }
        text.push_str("M30\n");
        let n = control.len() - 1;
        let mut knots = vec![0.0; degree + 1];
        for interval in &intervals[..=n - degree] {
            knots.push(knots.last().unwrap() + if with_intervals { f64::from(*interval) / 10.0 } else { 1.0 });
        }
        let last = *knots.last().unwrap();
        knots.extend(vec![last; degree]);
        let pieces = pieces(&ops(&text));
        prop_assert_eq!(pieces.len(), n - degree + 1);
        for (k, piece) in pieces.iter().enumerate() {
            let (from, to) = (knots[degree + k], knots[degree + k + 1]);
            for step in 0..8 {
                let t = f64::from(step) / 8.0;
                let u = from + t * (to - from);
                let want: P = std::array::from_fn(|i| (0..=n).map(|j| basis(j, degree, &knots, u) * control[j][i]).sum());
                prop_assert!(distance(bezier(piece, t), want) < 1e-9, "{} {} {:?}\n{}", k, t, want, text);
            }
        }
    }

    #[test]
    fn splines_go_through_their_points_and_are_smooth(
        list in prop::collection::vec((-50_000..50_000i32, -50_000..50_000i32, -9_000..9_000i32), 1..9), akima in any::<bool>(),
        begin in 0..3usize, end in 0..3usize,
    ) {
        let mut text = format!(
            "G0 X-10 Y-5 Z0\nG1 X0 Y0 Z0 F100\n{} {} {}\n", if akima { "ASPLINE" } else { "CSPLINE" },
            ["BAUTO", "BNAT", "BTAN"][begin], ["EAUTO", "ENAT", "ETAN"][end]
        );
        let through = points(&mut text, &list);
        prop_assume!(through.windows(2).all(|w| distance(w[0], w[1]) > 0.5));
        let last = through[through.len() - 1];
        text.push_str(&format!("G1 X={} Y={}\nM30\n", last[0] + 3.0, last[1] + 4.0));
        let pieces = pieces(&ops(&text));
        prop_assert_eq!(pieces.len(), through.len() - 1);
        for (piece, ends) in pieces.iter().zip(through.windows(2)) {
            prop_assert!(piece.iter().flatten().all(|v| v.is_finite()), "{:?}\n{}", piece, text);
            prop_assert!(distance(piece[0], ends[0]) < 1e-12 && distance(piece[3], ends[1]) < 1e-12);
        }
        let h: Vec<f64> = through.windows(2).map(|w| distance(w[0], w[1])).collect();
        let slope = |a: P, b: P, h: f64| -> P { std::array::from_fn(|i| 3.0 * (b[i] - a[i]) / h) };
        let bend = |a: P, b: P, c: P, h: f64| -> P { std::array::from_fn(|i| 6.0 * (a[i] - 2.0 * b[i] + c[i]) / (h * h)) };
        for (i, pair) in pieces.windows(2).enumerate() {
            let (a, b) = (pair[0], pair[1]);
            prop_assert!(distance(slope(a[2], a[3], h[i]), slope(b[0], b[1], h[i + 1])) < 1e-9);
            if !akima {
                let (x, y) = (bend(a[1], a[2], a[3], h[i]), bend(b[0], b[1], b[2], h[i + 1]));
                prop_assert!(distance(x, y) < 1e-7 * (1.0 + distance(x, [0.0; 3])), "{:?} {:?}\n{}", x, y, text);
            }
        }
        let (first, last) = (pieces[0], pieces[pieces.len() - 1]);
        if begin == 2 {
            let s = slope(first[0], first[1], h[0]);
            prop_assert!((s[0] * 5.0 - s[1] * 10.0).abs() < 1e-9 && s[0] > 0.0, "{:?}", s);
        }
        if end == 2 {
            let s = slope(last[2], last[3], h[h.len() - 1]);
            prop_assert!((s[0] * 4.0 - s[1] * 3.0).abs() < 1e-9 && s[0] > 0.0, "{:?}", s);
        }
        if begin == 1 && !akima {
            prop_assert!(distance(bend(first[0], first[1], first[2], h[0]), [0.0; 3]) < 1e-7);
        }
    }

    #[test]
    fn polynomials_are_what_is_written(
        end in -50.0..50.0f64, a2 in -3.0..3.0f64, a3 in -1.0..1.0f64, a4 in -0.1..0.1f64, length in 0.5..9.0f64, high in any::<bool>(),
    ) {
        let a4 = if high { a4 } else { 0.0 };
        let text = format!("G0 X1 Y2 Z3\nG1 F100\nPOLY PO[X]=({end}, {a2}, {a3}, {a4}) Y=IC(7) PL={length}\nM30\n");
        let ops = ops(&text);
        let a1 = (end - 1.0 - a2 * length.powi(2) - a3 * length.powi(3) - a4 * length.powi(4)) / length;
        let at = |p: f64| [1.0 + a1 * p + a2 * p.powi(2) + a3 * p.powi(3) + a4 * p.powi(4), 2.0 + 7.0 * p / length, 3.0];
        if high {
            // Every end of a chord lies on the curve; y runs evenly.
            for op in &ops {
                if let Op::Linear(m) = op {
                    let q = m.end.xyz().unwrap();
                    prop_assert!(distance(q, at((q[1] - 2.0) / 7.0 * length)) < 1e-6, "{:?}\n{}", q, text);
                }
            }
        } else {
            let piece = pieces(&ops)[0];
            for step in 0..=8 {
                let t = f64::from(step) / 8.0;
                prop_assert!(distance(bezier(&piece, t), at(t * length)) < 1e-9, "{}\n{}", t, text);
            }
        }
    }
}

#[test]
fn a_curve_ends_where_a_block_is_more_than_a_point() {
    let all = ops("G0 X0 Y0 Z0\nG1 F100\nCSPLINE X10 Y5\nX20 Y0\nM8\nX30 Y5\nX40 Y0\nM30\n");
    let coolant = all.iter().position(|op| matches!(op, Op::Coolant(_))).unwrap();
    let splines: Vec<usize> = (0..all.len()).filter(|&i| matches!(all[i], Op::Spline(_))).collect();
    assert!(splines[1] < coolant && coolant < splines[2], "{splines:?} {coolant}");
}
