//! Laws of cutter radius compensation, checked with distances that share no code with the stage.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use proveout_nc::{Compensation, Diagnostic, Dialect, Feed, Op, Program, Settings, ToolName, ToolRadii};

type Point = [f64; 2];

fn settings(radius: f64) -> Settings {
    let mut radii = ToolRadii::default();
    radii.by_tool.insert(ToolName::Number(1), radius);
    radii.by_offset.insert(7, 0.5 * radius);
    Settings { dialect: Dialect::Siemens840d, compensation: Compensation::ToolCenter(radii), ..Settings::default() }
}

/// A straight or circular piece of a path in a plane, as a function from 0..1 to points.
#[derive(Clone, Debug)]
enum Piece {
    Line(Point, Point),
    /// Center, radius, start angle, signed sweep.
    Arc(Point, f64, f64, f64),
}

impl Piece {
    fn at(&self, s: f64) -> Point {
        match self {
            Self::Line(a, b) => [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])],
            Self::Arc(c, r, from, sweep) => [c[0] + r * (from + s * sweep).cos(), c[1] + r * (from + s * sweep).sin()],
        }
    }

    fn length(&self) -> f64 {
        match self {
            Self::Line(a, b) => (b[0] - a[0]).hypot(b[1] - a[1]),
            Self::Arc(_, r, _, sweep) => r * sweep.abs(),
        }
    }

    /// Distance of a point: closed forms of segment and arc.
    fn distance(&self, p: Point) -> f64 {
        match self {
            Self::Line(a, b) => {
                let (d, e) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
                let s = ((d[0] * e[0] + d[1] * e[1]) / (d[0] * d[0] + d[1] * d[1]).max(1e-300)).clamp(0.0, 1.0);
                (e[0] - s * d[0]).hypot(e[1] - s * d[1])
            }
            Self::Arc(c, r, from, sweep) => {
                let angle = (p[1] - c[1]).atan2(p[0] - c[0]);
                let along = if *sweep > 0.0 { angle - from } else { from - angle };
                if along.rem_euclid(TAU) <= sweep.abs() {
                    ((p[0] - c[0]).hypot(p[1] - c[1]) - r).abs()
                } else {
                    let far = |q: Point| (p[0] - q[0]).hypot(p[1] - q[1]);
                    far(self.at(0.0)).min(far(self.at(1.0)))
                }
            }
        }
    }
}

fn commands(text: &str, settings: &Settings) -> Result<Vec<Op>, Diagnostic> {
    Program::from_text("p.mpf", text, settings).unwrap().map(|c| c.map(|c| c.op)).collect()
}

/// Motions of a program in base X, Y as pieces, with the height (base Z) at the end of each. Vertical ones
/// are left out.
fn path(text: &str, settings: &Settings) -> Result<Vec<Piece>, Diagnostic> {
    let mut at: Option<Point> = None;
    let mut pieces = Vec::new();
    for op in commands(text, settings)? {
        let (motion, arc) = match &op {
            Op::Rapid(m) | Op::Linear(m) => (m, None),
            Op::Arc(a) => (&a.motion, Some(a)),
            _ => continue,
        };
        let (Some(x), Some(y)) = (motion.end_base.get(0), motion.end_base.get(1)) else { continue };
        if let Some(from) = at {
            match arc {
                Some(a) => {
                    let c = [a.center_base[0], a.center_base[1]];
                    let start = (from[1] - c[1]).atan2(from[0] - c[0]);
                    let sweep = a.sweep * a.normal_base[2];
                    let radius = (from[0] - c[0]).hypot(from[1] - c[1]);
                    assert!((radius - a.radius).abs() < 1e-9, "start {radius} is not on the circle {}", a.radius);
                    let piece = Piece::Arc(c, a.radius, start, sweep);
                    let end = piece.at(1.0);
                    // Programs carry three to six decimals, so programmed ends are that far from their
                    // circles.
                    assert!((end[0] - x).hypot(end[1] - y) < 2e-3, "{end:?} {x} {y}");
                    pieces.push(piece);
                }
                None if (x - from[0]).hypot(y - from[1]) > 1e-12 => pieces.push(Piece::Line(from, [x, y])),
                None => {}
            }
        }
        at = Some([x, y]);
    }
    Ok(pieces)
}

fn length(pieces: &[Piece]) -> f64 {
    pieces.iter().map(Piece::length).sum()
}

fn programmed(text: &str) -> Vec<Piece> {
    path(text, &Settings { dialect: Dialect::Siemens840d, ..Settings::default() }).unwrap()
}

const HEAD: &str = "G17 G90 T1 M6 D1\nF1000\nG0 X-40 Y-40 Z0\n";

#[test]
fn a_square_outside_is_its_perimeter_and_a_circle() {
    // Counter-clockwise square of 30 mm with the tool on the right, outside; entry below the first corner.
    let text = format!("{HEAD}G1 G42 X0 Y0\nX30\nY30\nX0\nY0\nG40 X-40 Y-40\nM30\n");
    let path = path(&text, &settings(4.0)).unwrap();
    // The first and the last piece are entry and exit; three corners are arcs, the fourth is not closed by
    // one: the entry is perpendicular to the first side and the exit to the last.
    let inner = &path[1..path.len() - 1];
    assert!((length(inner) - (4.0 * 30.0 + 3.0 * 4.0 * PI / 2.0)).abs() < 1e-9, "{}", length(inner));
    assert_eq!(path[0].at(1.0), [0.0, -4.0]);
    assert_eq!(path[path.len() - 1].at(0.0), [-4.0, 0.0]);
    assert_eq!(path[path.len() - 1].at(1.0), [-40.0, -40.0]);
}

#[test]
fn a_square_with_intersections_is_a_larger_square() {
    let text = format!("{HEAD}G451 G1 G42 X0 Y0\nX30\nY30\nX0\nY0\nG40 X-40 Y-40\nM30\n");
    let path = path(&text, &settings(4.0)).unwrap();
    let corners: Vec<Point> = path[1..path.len() - 1].iter().map(|p| p.at(1.0)).collect();
    assert_eq!(corners, [[34.0, -4.0], [34.0, 34.0], [-4.0, 34.0], [-4.0, 0.0]]);
}

#[test]
fn a_square_inside_is_a_smaller_square() {
    let text = format!("{HEAD}G0 X15 Y15\nG1 G41 X15 Y0\nX30\nY30\nX0\nY0\nX15\nG40 Y15\nM30\n");
    let path = path(&text, &settings(4.0)).unwrap();
    let corners: Vec<Point> = path.iter().map(|p| p.at(1.0)).collect();
    assert_eq!(
        corners,
        [[15.0, 15.0], [15.0, 4.0], [26.0, 4.0], [26.0, 26.0], [4.0, 26.0], [4.0, 4.0], [15.0, 4.0], [15.0, 15.0]]
    );
}

#[test]
fn circles_become_larger_and_smaller() {
    for (side, word, radius) in [("G41", "G3", 16.0), ("G42", "G3", 24.0), ("G41", "G2", 24.0), ("G42", "G2", 16.0)] {
        let tangent = if word == "G3" { "X20 Y-10" } else { "X20 Y10" };
        let text = format!("{HEAD}G0 {tangent}\nG1 {side} X20 Y0\n{word} X20 Y0 I-20 J0\nG40 G1 X40\nM30\n");
        let ops = commands(&text, &settings(4.0)).unwrap();
        let arcs: Vec<_> = ops.iter().filter_map(|op| if let Op::Arc(a) = op { Some(a) } else { None }).collect();
        assert_eq!(arcs.len(), 1, "{side} {word}");
        assert!((arcs[0].radius - radius).abs() < 1e-12 && (arcs[0].sweep - TAU).abs() < 1e-12, "{:?}", arcs[0]);
        assert_eq!(arcs[0].center_base, [0.0, 0.0, 0.0]);
        assert_eq!(arcs[0].motion.end.xyz(), Some([20.0, 0.0, 0.0]), "the end stays as programmed");
        assert!((arcs[0].motion.end_base.get(0).unwrap() - radius).abs() < 1e-12);
    }
}

#[test]
fn a_helix_keeps_its_height_and_turns() {
    let text = format!("{HEAD}G0 X20 Y-10\nG1 G41 X20 Y0\nG3 X-20 Y0 Z-5 I-20 J0 TURN=2\nG40 G1 X-40\nM30\n");
    let ops = commands(&text, &settings(4.0)).unwrap();
    let Some(Op::Arc(arc)) = ops.iter().find(|op| matches!(op, Op::Arc(_))) else { panic!() };
    assert!((arc.sweep - 5.0 * PI).abs() < 1e-12);
    assert_eq!(arc.motion.end_base.get(2), Some(-5.0));
}

#[test]
fn feed_holds_at_the_contour_unless_the_program_says_otherwise() {
    let feeds = |words: &str| -> Vec<f64> {
        let text =
            format!("{HEAD}{words} G0 X20 Y-10\nG1 G41 X20 Y0\nG3 X-20 Y0 I-20 J0\nG2 X-60 I-20 J0\nG40 G1 Y40\nM30\n");
        let feed = |op: &Op| if let Op::Feed(Feed::PerTime(v)) = op { Some((v * 60.0).round()) } else { None };
        commands(&text, &settings(5.0)).unwrap().iter().filter_map(feed).collect()
    };
    assert_eq!(feeds(""), [1000.0, 750.0, 1000.0, 1250.0, 1000.0]);
    assert_eq!(feeds("CFIN"), [1000.0, 750.0, 1000.0]);
    assert_eq!(feeds("CFTCP"), [1000.0]);
}

#[test]
fn blocks_without_motion_in_the_plane_stay_at_the_end_of_their_block() {
    let text = format!("{HEAD}G1 G42 X0 Y0\nX30\nZ-5\nG4 F1\nY30\nG40 X60\nM30\n");
    let ops = commands(&text, &settings(4.0)).unwrap();
    let at = ops.iter().position(|op| matches!(op, Op::Dwell(_))).unwrap();
    let (Op::Linear(side), Op::Linear(down), Op::Arc(corner)) = (&ops[at - 2], &ops[at - 1], &ops[at + 1]) else {
        panic!("{ops:?}")
    };
    assert_eq!(side.end_base.xyz(), Some([30.0, -4.0, 0.0]));
    assert_eq!(down.end_base.xyz(), Some([30.0, -4.0, -5.0]));
    assert_eq!(corner.motion.end_base.xyz(), Some([34.0, 0.0, -5.0]));
    assert_eq!(corner.center_base, [30.0, 0.0, -5.0]);
}

#[test]
fn after_g40_other_axes_do_not_move_the_tool_back() {
    let text = format!("{HEAD}G1 G42 X0 Y0\nX30\nG40\nZ50\nX40 Y-20\nM30\n");
    let ops = commands(&text, &settings(4.0)).unwrap();
    let ends: Vec<_> =
        ops.iter().filter_map(|op| if let Op::Linear(m) = op { m.end_base.xyz() } else { None }).collect();
    assert_eq!(ends[1..], [[30.0, -4.0, 0.0], [30.0, -4.0, 50.0], [40.0, -20.0, 50.0]]);
}

#[test]
fn another_radius_takes_effect_at_the_end_of_its_block() {
    // D0 takes the radius away: the block leads from the equidistant to the contour.
    let text = format!("{HEAD}G1 G42 X0 Y0\nX30\nX60 D0\nX90\nG40 Y-40\nM30\n");
    let ops = commands(&text, &settings(4.0)).unwrap();
    let ends: Vec<_> = ops
        .iter()
        .filter_map(|op| if let Op::Linear(m) = op { Some([m.end_base.get(0)?, m.end_base.get(1)?]) } else { None })
        .collect();
    assert_eq!(ends, [[0.0, -4.0], [30.0, -4.0], [60.0, 0.0], [90.0, 0.0], [90.0, -40.0]]);
}

#[test]
fn the_three_planes_are_alike() {
    let shape = |plane: &str, [u, v, w]: [&str; 3], [i, j]: [&str; 2], axes: [usize; 3]| {
        let text = format!(
            "{plane} T1 M6 D1 F1000\nG0 {u}=0 {v}=-20 {w}=5\nG1 G41 {u}=0 {v}=0\n{u}=30 {v}=10\nG3 {u}=10 {v}=30 {i}=-20 {j}=0\nG1 {u}=0\n{u}=-10 {v}=20\nG40 {v}=-20\nM30\n"
        );
        let mut ends = Vec::new();
        for op in commands(&text, &settings(3.0)).unwrap() {
            match op {
                Op::Rapid(m) | Op::Linear(m) => ends.push(axes.map(|a| m.end_base.get(a).unwrap())),
                Op::Arc(a) => {
                    ends.push(axes.map(|x| a.motion.end_base.get(x).unwrap()));
                    ends.push(axes.map(|x| a.center_base[x]));
                    ends.push(axes.map(|x| a.normal_base[x]));
                    ends.push([a.radius, a.sweep, 0.0]);
                }
                _ => {}
            }
        }
        ends
    };
    let xy = shape("G17", ["X", "Y", "Z"], ["I", "J"], [0, 1, 2]);
    assert!(xy.len() > 8);
    assert_eq!(shape("G18", ["Z", "X", "Y"], ["K", "I"], [2, 0, 1]), xy);
    assert_eq!(shape("G19", ["Y", "Z", "X"], ["J", "K"], [1, 2, 0]), xy);
}

#[test]
fn a_mirrored_program_gives_the_mirrored_path_and_a_scaled_one_keeps_the_radius() {
    let body = "G1 G41 X0 Y0\nX30 Y10\nG3 X10 Y30 I-20 J0\nG1 X0\nX-10 Y20\nG40 Y-20\nM30\n";
    let plain = path(&format!("{HEAD}{body}"), &settings(3.0)).unwrap();
    let mirrored = path(&format!("{HEAD}MIRROR X0\nG0 X-40 Y-40\n{body}"), &settings(3.0)).unwrap();
    for (a, b) in plain.iter().zip(&mirrored[1..]) {
        for s in [0.0, 0.3, 1.0] {
            let (p, q) = (a.at(s), b.at(s));
            assert!((p[0] + q[0]).abs() < 1e-12 && (p[1] - q[1]).abs() < 1e-12, "{p:?} {q:?}");
        }
    }
    // Everything twice as large but the tool: the same as twice the path with half the radius.
    let scaled = path(&format!("{HEAD}SCALE X2 Y2 Z2\nG0 X-40 Y-40\n{body}"), &settings(3.0)).unwrap();
    let half = path(&format!("{HEAD}{body}"), &settings(1.5)).unwrap();
    for (a, b) in half.iter().zip(&scaled[1..]) {
        let (p, q) = (a.at(1.0), b.at(1.0));
        assert!((2.0 * p[0] - q[0]).abs() < 1e-9 && (2.0 * p[1] - q[1]).abs() < 1e-9, "{p:?} {q:?}");
    }
}

#[test]
fn a_tilted_plane_is_compensated_in_itself() {
    let body = "G1 G41 X0 Y0\nX30 Y10\nG3 X10 Y30 I-20 J0\nG1 X0\nX-10 Y20\nG40 Y-20\nM30\n";
    let ends = |text: &str| -> Vec<[f64; 3]> {
        commands(text, &settings(3.0))
            .unwrap()
            .iter()
            .filter_map(|op| match op {
                Op::Linear(m) => m.end_base.xyz(),
                Op::Arc(a) => a.motion.end_base.xyz(),
                _ => None,
            })
            .collect()
    };
    let (s, c) = 35f64.to_radians().sin_cos();
    let flat = ends(&format!("{HEAD}{body}"));
    // By words of frames, and with the tool swiveled upright on the plane.
    for tilt in ["TRANS X5 Y6 Z7\nAROT X35\nCUT2DF\n", "CYCLE800(0,\"T\",100000,57,5,6,7,35,0,0,0,0,0,1)\n"] {
        let tilted = ends(&format!("{HEAD}{tilt}G0 X-40 Y-40 Z0\n{body}"));
        assert_eq!(flat.len(), tilted.len());
        for (p, q) in flat.iter().zip(&tilted) {
            let want = [p[0] + 5.0, c * p[1] - s * p[2] + 6.0, s * p[1] + c * p[2] + 7.0];
            for i in 0..3 {
                assert!((want[i] - q[i]).abs() < 1e-12, "{want:?} {q:?}");
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_an_error_that_names_it() {
    let fault = |body: &str, radius: f64| commands(&format!("{HEAD}{body}"), &settings(radius)).unwrap_err();
    // A slot of 6 mm: the bottom is taken from both sides.
    let slot = "G1 G41 X0 Y20\nY0\nX6\nY20\nG40 X40\nM30\n";
    let error = fault(slot, 4.0);
    assert_eq!((error.code, error.line), ("nc-compensation", 7));
    assert!(error.message.contains("4 mm"), "{error}");
    assert_eq!(&*error.source_line, "Y20");
    assert!(commands(&format!("{HEAD}{slot}"), &settings(2.9)).is_ok());
    // An inside arc of 5 mm.
    let error = fault("G1 G41 X0 Y0\nX20\nG3 X25 Y5 I0 J5\nG1 Y20\nG40 X0\nM30\n", 5.0);
    assert!(error.code == "nc-compensation" && error.help.unwrap().contains("below 5.0000 mm"));
    // A step of 1 mm in an inside corner of 90 degrees: the radius that fits into the corner is the length of
    // the step.
    let error = fault("G1 G41 X0 Y0\nX20\nY1\nX40\nG40 Y30\nM30\n", 2.0);
    assert!(error.help.as_ref().unwrap().contains("1.0000 mm"), "{error:?}");
    for (body, what) in [
        ("G41\nG2 X0 Y0 CR=60\nX10\nM30\n", "begins with an arc"),
        ("G1 G41 X0 Y0\nX10\nG40 G2 X20 CR=60\nM30\n", "after G40 is not straight"),
        ("G1 G41 X0 Y0\nX10\nG42 X20\nM30\n", "changes its side"),
        ("G1 G41 X0 Y0\nX10\nT2 M6\nM30\n", "tool is changed"),
        ("G1 G41 X0 Y0\nX10\nG18 X20\nM30\n", "plane changes"),
        ("G1 G41 X0 Y0\nX10\nAROT Z10\nX20 Y0\nM30\n", "frame turns"),
        ("G1 G41 X0 Y0\nX10\nSUPA X20\nM30\n", "machine coordinates"),
        ("G1 G41 X0 Y0\nX10\nG93 X20 F2\nM30\n", "inverse time"),
        ("G1 G41 X0 Y0\nX10\nTRAORI\nX20 Y0\nM30\n", "tool center point control"),
        ("G1 G41 X0 Y0\nX10\nCIP X20 Z5 I1=15 J1=0 K1=1\nM30\n", "circle outside"),
        ("G1 G41 X0 Y0\nG40 X10\nM30\n", "no contour"),
        // Left of a contour along X is above it; the entry comes from below.
        ("KONT G1 G41 X0 Y0\nX10\nG40 Y20\nM30\n", "entry lies on the far side"),
        ("KONT G0 Y40\nG1 G41 X0 Y0\nX10\nG40 Y-20\nM30\n", "exit lies on the far side"),
        ("T2 M6\nG0 X0 Y0\nG1 G41 X0 Y0\nX10\nM30\n", "not known (tool 2)"),
    ] {
        let error = fault(body, 2.0);
        assert!(error.code == "nc-compensation" && error.message.contains(what), "{body} {error}");
        assert!(!error.help.unwrap().is_empty() && !error.source_line.is_empty());
    }
    let many = "G1 G41 X0 Y0\nX10\n".to_owned() + &"M123\n".repeat(1001) + "X20\nM30\n";
    assert!(fault(&many, 2.0).message.contains("1000 commands"));
}

#[test]
fn kont_in_front_of_the_contour_is_norm() {
    let text = |word: &str| format!("{HEAD}{word} G0 Y40\nG1 G41 X0 Y0\nX30\nY30\nX60\nG40 Y60\nM30\n");
    let (norm, kont) = (path(&text("NORM"), &settings(3.0)).unwrap(), path(&text("KONT"), &settings(3.0)).unwrap());
    assert_eq!(norm.len(), kont.len());
    for (a, b) in norm.iter().zip(&kont) {
        assert_eq!((a.at(0.0), a.at(1.0)), (b.at(0.0), b.at(1.0)));
    }
}

#[test]
fn without_radii_the_contour_stays_as_programmed() {
    let text = format!("{HEAD}G1 G41 X0 Y0\nX30\nG40 Y30\nM30\n");
    let settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    let ops = commands(&text, &settings).unwrap();
    assert_eq!(ops.iter().filter(|op| matches!(op, Op::CutterComp(_))).count(), 2);
    for op in &ops {
        if let Op::Linear(m) = op {
            assert_eq!(m.end, m.end_base);
        }
    }
    let ops = commands(&text, &self::settings(1.0)).unwrap();
    assert!(!ops.iter().any(|op| matches!(op, Op::CutterComp(_))));
    assert!(ops.iter().any(|op| matches!(op, Op::Note(n) if n.contains("left") && n.contains("radius 1 mm"))));
}

/// A star-shaped closed contour about the origin, counter-clockwise, with sides that are lines or arcs
/// bulging out or in.
fn star(radii: &[f64], bulges: &[f64]) -> String {
    let n = radii.len();
    let point = |i: usize| {
        let angle = TAU * i as f64 / n as f64;
        [radii[i % n] * angle.cos(), radii[i % n] * angle.sin()]
    };
    let mut text = String::new();
    for i in 1..=n {
        let (a, b) = (point(i - 1), point(i));
        let chord = (b[0] - a[0]).hypot(b[1] - a[1]);
        let bulge = bulges[(i - 1) % n];
        let word = if bulge.abs() < 0.15 {
            "G1".to_owned()
        } else {
            // Half the opening angle is the bulge, radian.
            format!("{} CR={:.6}", if bulge > 0.0 { "G3" } else { "G2" }, 0.5 * chord / bulge.abs().sin())
        };
        text.push_str(&format!("{word} X{:.6} Y{:.6}\n", b[0], b[1]));
    }
    text
}

#[test]
fn small_tools_nearly_always_fit() {
    // Errors must not be the easy way out: of 200 contours with sharp inside corners, a tool of 1 mm fits
    // into most.
    let mut state = 1u64;
    let mut random = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((state >> 33) as f64 / f64::from(1u32 << 31))
    };
    let mut fits = 0;
    for i in 0..200 {
        let radii: Vec<f64> = (0..8).map(|_| random(25.0, 40.0)).collect();
        let bulges: Vec<f64> = (0..8).map(|_| random(-0.6, 0.6)).collect();
        let (side, from) = if i % 2 == 0 { ("G42", radii[0] + 20.0) } else { ("G41", 0.0) };
        let text = format!(
            "G17 T1 M6 D1 F1000\nG0 X{from:.6} Y0 Z0\n{side} G1 X{:.6} Y0\n{}G40 G1 X{from:.6} Y0\nM30\n",
            radii[0],
            star(&radii, &bulges)
        );
        fits += usize::from(path(&text, &settings(1.0)).is_ok());
    }
    assert!(fits >= 180, "{fits} of 200");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(60),
        failure_persistence: None, ..ProptestConfig::default()
    })]

    /// The tool never comes nearer to the contour than its radius, touches it all along, and runs on the
    /// right side.
    #[test]
    fn random_contours_are_never_gouged(
        radii in prop::collection::vec(25.0..40.0f64, 5..12), bulges in prop::collection::vec(-0.6..0.6f64, 12),
        tool in 0.05..4.0f64, outside in any::<bool>(), intersection in any::<bool>(),
    ) {
        let n = radii.len();
        let (start, corner) = (radii[0], if intersection { "G451" } else { "G450" });
        // From inside or outside along the radius; the contour runs counter-clockwise.
        let (side, from) = if outside { ("G42", start + 20.0) } else { ("G41", 0.0) };
        let body = star(&radii, &bulges);
        let contour = format!("{side} G1 X{start:.6} Y0\n{body}");
        let text = format!("G17 T1 M6 D1 F1000\n{corner} G0 X{from:.6} Y0 Z0\n{contour}G40 G1 X{from:.6} Y0\nM30\n");
        let programmed = programmed(&text);
        let programmed = &programmed[1..=n];
        let path = match path(&text, &settings(tool)) {
            Ok(path) => path,
            Err(error) => {
                // Sharp inside corners do not take every tool; the smallest ones fit nearly always.
                prop_assert!(error.code == "nc-compensation", "{error}");
                return Ok(());
            }
        };
        let path = &path[1..path.len() - 1];
        for (i, piece) in path.iter().enumerate() {
            for k in 0..=16 {
                let p = piece.at(f64::from(k) / 16.0);
                let nearest = programmed.iter().map(|e| e.distance(p)).fold(f64::INFINITY, f64::min);
                // Arcs are given by end and radius with six decimals; their centers are exact to that. 1e-9
                // for rounding. At the seam the entry and the exit are square to one side each and do not
                // look at the other.
                let is_seam = i < 2 || i + 2 >= path.len();
                prop_assert!(nearest >= tool - 1e-9 || is_seam || overlaps(programmed, p, tool), "{nearest} {tool} {text}");
                // The tool touches the contour everywhere but on the way to the intersection of an outside
                // corner. A corner of a few milliradian takes no circle of its own; there it swerves by 1e-5
                // at most.
                prop_assert!(nearest <= tool + 1e-5 || intersection, "{nearest} {tool} {text}");
                // The tool runs on its side of the contour: the winding number of the contour about its
                // center.
                prop_assert!(winding(programmed, p) != outside || is_seam, "{text}");
            }
        }
        // Every point of the contour between its first and last corner is touched, where no inside corner
        // hides it.
        for element in &programmed[1..n - 1] {
            let middle = element.at(0.5);
            let nearest = path.iter().map(|e| e.distance(middle)).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest >= tool - 1e-9 || overlaps(programmed, middle, tool));
        }
    }

    #[test]
    fn convex_contours_grow_by_a_circle(radii in 20.0..60.0f64, n in 3..12usize, turn in 0.0..6.0f64, tool in 0.1..10.0f64) {
        // Points on a circle are a convex polygon, run counter-clockwise with the tool outside: perimeter
        // plus all corners but the one at the start, of which the entry and the exit are perpendicular to
        // their sides.
        let point = |i: usize| {
            let angle = turn + TAU * i as f64 / n as f64;
            [(1e6 * radii * angle.cos()).round() / 1e6, (1e6 * radii * angle.sin()).round() / 1e6]
        };
        let mut text = format!("T1 M6 D1 F100\nG0 X200 Y0 Z0\nG1 G42 X{} Y{}\n", point(0)[0], point(0)[1]);
        let mut perimeter = 0.0;
        for i in 1..=n {
            let (a, b) = (point(i - 1), point(i % n));
            perimeter += (b[0] - a[0]).hypot(b[1] - a[1]);
            text.push_str(&format!("X{} Y{}\n", b[0], b[1]));
        }
        text.push_str("G40 X200 Y0\nM30\n");
        let path = path(&text, &settings(tool)).unwrap();
        let got = length(&path[1..path.len() - 1]);
        let want = perimeter + TAU * tool * (n - 1) as f64 / n as f64;
        // Corners rounded to 1e-6 turn their sides by at most 1e-7 radian.
        prop_assert!((got - want).abs() < 1e-5, "{got} {want}");
    }

    #[test]
    fn a_divided_line_changes_nothing(cuts in prop::collection::vec(0.01..0.99f64, 0..6), tool in 0.1..5.0f64, y in -30.0..30.0f64) {
        let mut cuts = cuts;
        cuts.sort_by(f64::total_cmp);
        let line: String = cuts.iter().chain([&1.0]).map(|s| format!("X={} Y={}\n", 40.0 * s, y * s)).collect();
        let text = |line: &str| format!("{HEAD}G1 G41 X0 Y0\n{line}X=10 Y=60\nG40 X0\nM30\n");
        let (plain, divided) = (path(&text(&format!("X=40 Y={y}\n")), &settings(tool)), path(&text(&line), &settings(tool)));
        let (Ok(plain), Ok(divided)) = (plain, divided) else {
            // A last part that is shorter than what the corner takes is one more block that the tool does not
            // fit behind.
            return Ok(());
        };
        prop_assert!((length(&plain) - length(&divided)).abs() < 1e-9);
        for piece in &divided {
            let p = piece.at(1.0);
            let nearest = plain.iter().map(|e| e.distance(p)).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest < 1e-9, "{nearest}");
        }
    }
}

/// True when the point lies inside of the closed contour, by the angles under which it sees the sides.
fn winding(contour: &[Piece], p: Point) -> bool {
    let mut total = 0.0;
    for piece in contour {
        let mut last = piece.at(0.0);
        for k in 1..=24 {
            let next = piece.at(f64::from(k) / 24.0);
            let (a, b) = ([last[0] - p[0], last[1] - p[1]], [next[0] - p[0], next[1] - p[1]]);
            total += (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
            last = next;
        }
    }
    total.abs() > PI
}

/// True where two sides that do not follow each other come nearer to the point than two radii: a narrow
/// place, which the controls do not see without bottleneck detection and which this stage leaves to the
/// collision check.
fn overlaps(contour: &[Piece], p: Point, tool: f64) -> bool {
    let near: Vec<usize> = (0..contour.len()).filter(|&i| contour[i].distance(p) < tool * (1.0 - 1e-9)).collect();
    near.iter().any(|&i| {
        let n = contour.len();
        let touched: Vec<usize> = (0..n).filter(|&j| (contour[j].distance(p) - tool).abs() < 1e-6).collect();
        touched.iter().all(|&j| j != i && (i + 1) % n != j && (j + 1) % n != i)
    })
}

/// A fault of the path is told with the text of its line, whatever language the line is written in.
#[test]
fn faults_of_the_path_show_their_line() {
    let text = "G17 G21 G90 T1 M6\nG0 X0 Y0 Z0\nG41 D1 G1 X10 F100\nG40 X0\nM30\n";
    for dialect in [Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc] {
        let mut radii = ToolRadii::default();
        radii.by_tool.insert(ToolName::Number(1), 5.0);
        radii.by_offset.insert(1, 5.0);
        let settings = Settings { dialect, compensation: Compensation::ToolCenter(radii), ..Settings::default() };
        let fault = Program::from_text("part", text, &settings).unwrap().find_map(Result::err);
        let fault = fault.unwrap_or_else(|| panic!("{dialect:?} raises nothing"));
        assert_eq!((fault.code, fault.line), ("nc-compensation", 3), "{dialect:?}: {fault}");
        assert_eq!(&*fault.source_line, "G41 D1 G1 X10 F100", "{dialect:?}");
    }
}
