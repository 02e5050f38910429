//! Milling cycles of a TNC and an 840D against the shape that they leave: the tool never crosses the wall,
//! nothing stays inside of it, depths and infeeds are those of the program. The wall is written here by
//! distances, not by paths.
//!
//! The generator visits pockets of any proportion with sharp, rounded and full corners, slots as wide as the
//! tool, circular slots up to 300 degrees, all positions (Q367), turns, both directions, M4, every plunge,
//! roughing alone and with finishing of the sides; surfaces of any proportion to all four sides of their
//! corner, along both axes, in one direction and to and fro.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proptest::prelude::*;
use proveout_nc::{Compensation, Dialect, Op, Program, Settings, ToolName, ToolRadii};

type P = [f64; 2];

fn settings(radius: Option<f64>) -> Settings {
    let mut settings = Settings { dialect: Dialect::Heidenhain, ..Settings::default() };
    if let Some(radius) = radius {
        settings.variables.insert("Q108".to_owned(), radius);
    }
    settings
}

fn read(text: &str, settings: &Settings) -> Result<Vec<Op>, String> {
    Program::from_text("p.h", text, settings)
        .map_err(|e| e.to_string())?
        .map(|c| c.map(|c| c.op).map_err(|e| format!("{}: {}", e.code, e.message)))
        .collect()
}

fn ops(text: &str, settings: &Settings) -> Vec<Op> {
    read(text, settings).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Points along all motions in feed, about 0.1 mm apart.
fn samples(ops: &[Op]) -> Vec<[f64; 3]> {
    let mut at: Option<[f64; 3]> = None;
    let mut all = Vec::new();
    for op in ops {
        match op {
            Op::Rapid(m) => at = m.end.xyz(),
            Op::Linear(m) => {
                let (a, b) = (at.unwrap(), m.end.xyz().unwrap());
                let length = (0..3).map(|i| (b[i] - a[i]).powi(2)).sum::<f64>().sqrt();
                let steps = (length / 0.1).ceil().max(1.0) as u32;
                for i in 0..=steps {
                    let t = f64::from(i) / f64::from(steps);
                    all.push(std::array::from_fn(|k| a[k] + t * (b[k] - a[k])));
                }
                at = Some(b);
            }
            Op::Arc(arc) => {
                let (a, b) = (at.unwrap(), arc.motion.end.xyz().unwrap());
                let d = [a[0] - arc.center[0], a[1] - arc.center[1]];
                let sense = arc.normal[2];
                let steps = (arc.sweep * arc.radius / 0.1).ceil().max(4.0) as u32;
                for i in 0..=steps {
                    let t = f64::from(i) / f64::from(steps);
                    let (s, c) = (sense * arc.sweep * t).sin_cos();
                    let p = [arc.center[0] + c * d[0] - s * d[1], arc.center[1] + s * d[0] + c * d[1]];
                    all.push([p[0], p[1], a[2] + t * (b[2] - a[2])]);
                }
                let last = all.last().unwrap();
                assert!((last[0] - b[0]).hypot(last[1] - b[1]) < 1e-6, "the arc ends beside its end: {last:?} {b:?}");
                at = Some(b);
            }
            _ => {}
        }
    }
    all
}

fn turned(p: P, degrees: f64) -> P {
    let (s, c) = degrees.to_radians().sin_cos();
    [c * p[0] - s * p[1], s * p[0] + c * p[1]]
}

/// Signed distance to a rectangle with rounded corners, below zero inside.
fn rectangle(p: P, a: f64, b: f64, corner: f64) -> f64 {
    let q = [p[0].abs() - a + corner, p[1].abs() - b + corner];
    q[0].max(0.0).hypot(q[1].max(0.0)) + q[0].max(q[1]).min(0.0) - corner
}

struct Cell {
    wall: Box<dyn Fn(P) -> f64>,
    /// Half of a square around the shape, and its middle.
    extent: f64,
    middle: P,
}

/// Every point that the tool can reach inside of the wall is cut at the depth, and the tool crosses the wall
/// nowhere.
fn judge(points: &[[f64; 3]], cell: &Cell, radius: f64, allowance: f64, depth: f64, text: &str) {
    let low: Vec<P> = points.iter().filter(|p| (p[2] - depth).abs() < 1e-9).map(|p| [p[0], p[1]]).collect();
    for p in points {
        let d = (cell.wall)([p[0], p[1]]);
        assert!(d <= -(radius + allowance) + 1e-6, "the tool at {p:?} is {d} from the wall\n{text}");
    }
    let n = 60;
    for i in 0..=n {
        for j in 0..=n {
            let p = [
                cell.middle[0] + cell.extent * (2.0 * f64::from(i) / f64::from(n) - 1.0),
                cell.middle[1] + cell.extent * (2.0 * f64::from(j) / f64::from(n) - 1.0),
            ];
            if (cell.wall)(p) > -allowance {
                continue;
            }
            // Reachable: a place of the tool within its radius is far enough from the wall.
            let reachable = (0..48).any(|k| {
                let (s, c) = (f64::from(k) / 48.0 * std::f64::consts::TAU).sin_cos();
                [0.0, 0.5, 0.95]
                    .iter()
                    .any(|r| (cell.wall)([p[0] + r * radius * c, p[1] + r * radius * s]) < -(radius + allowance) - 0.06)
            });
            if !reachable {
                continue;
            }
            let near = low.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1])).fold(f64::INFINITY, f64::min);
            assert!(near <= radius + 0.06, "{p:?} stays: the tool comes within {near} of {radius}\n{text}");
        }
    }
}

fn cases() -> ProptestConfig {
    let cases = std::env::var("PROVEOUT_NC_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(40);
    ProptestConfig { cases, ..ProptestConfig::default() }
}

/// Program around a cycle: the tool is at (40, 30).
fn program(cycle: &str, spindle: &str) -> String {
    format!(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F500\nL X+40 Y+30 R0 FMAX {spindle}\nL Z+50 FMAX\n{cycle}\nCYCL CALL\nL Z+80 FMAX\nM30\nEND PGM A MM\n"
    )
}

fn tail(operation: u32, side: f64, floor: f64, infeed: f64, climb: bool) -> String {
    format!(
        "Q368={side} ~\nQ207=400 ~\nQ351={} ~\nQ201=-12 ~\nQ202={infeed} ~\nQ369={floor} ~\nQ206=100 ~\nQ338=0 ~\nQ200=2 ~\n\
         Q203=+5 ~\nQ204=20 ~\nQ215={operation}",
        if climb { "+1" } else { "-1" }
    )
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_rectangular_pocket_is_cleared(
        a in 6.0..30.0f64, b in 6.0..30.0f64, corner in 0.0..1.5f64, radius in 2.0..5.9f64, side in 0.0..0.1f64,
        turn in -180.0..180.0f64, position in 0..5usize, overlap in 0.3..1.99f64, plunge in 0..3u32, climb in any::<bool>(),
        m4 in any::<bool>(), operation in 0..2u32,
    ) {
        let text = program(
            &format!(
                "CYCL DEF 251 RECTANGULAR POCKET ~\nQ218={} ~\nQ219={} ~\nQ220={} ~\nQ224={turn} ~\nQ367={position} ~\nQ370={overlap} ~\nQ366={plunge} ~\n{}",
                2.0 * a, 2.0 * b, corner * a.min(b), tail(operation, side, 0.0, 5.0, climb)
            ),
            if m4 { "M4" } else { "M3" },
        );
        let from = [[0.0, 0.0], [-a, -b], [a, -b], [a, b], [-a, b]][position];
        let t = turned(from, turn);
        let middle = [40.0 - t[0], 30.0 - t[1]];
        let round = (corner * a.min(b)).min(a.min(b)).max(radius);
        let cell = Cell {
            wall: Box::new(move |p| rectangle(turned([p[0] - middle[0], p[1] - middle[1]], -turn), a, b, round)),
            extent: a.hypot(b),
            middle,
        };
        let points = samples(&ops(&text, &settings(Some(radius))));
        judge(&points, &cell, radius, if operation == 1 { side } else { 0.0 }, -7.0, &text);
    }

    #[test]
    fn circular_pockets_and_slots_are_cleared(
        kind in 0..3usize, size in 6.5..25.0f64, length in 0.0..30.0f64, radius in 2.0..6.4f64, full in any::<bool>(),
        from in -180.0..180.0f64, through in 10.0..300.0f64, position in 0..4usize, plunge in 0..2u32, climb in any::<bool>(),
    ) {
        // A slot as wide as the tool has a spine and no rings.
        let half = if full && kind > 0 { radius } else { size };
        let end = tail(1, 0.0, 0.0, 5.0, climb);
        let pitch = half + 5.0 + length;
        let (cycle, cell) = match kind {
            0 => (
                format!("CYCL DEF 252 X ~\nQ223={} ~\nQ370=1.2 ~\nQ366={plunge} ~\n{end}", 2.0 * half),
                Cell { wall: Box::new(move |p| (p[0] - 40.0).hypot(p[1] - 30.0) - half), extent: half, middle: [40.0, 30.0] },
            ),
            1 => {
                let a = half + length;
                let along = [0.0, -a, -(a - half), a - half][position];
                let t = turned([along, 0.0], from);
                let middle = [40.0 - t[0], 30.0 - t[1]];
                (
                    format!("CYCL DEF 253 X ~\nQ218={} ~\nQ219={} ~\nQ374={from} ~\nQ367={position} ~\nQ366={plunge} ~\n{end}", 2.0 * a, 2.0 * half),
                    Cell {
                        wall: Box::new(move |p| rectangle(turned([p[0] - middle[0], p[1] - middle[1]], -from), a, half, half)),
                        extent: a,
                        middle,
                    },
                )
            }
            _ => {
                let at = |degrees: f64| turned([pitch, 0.0], degrees);
                let middle = match position {
                    0 => [11.0, -3.0],
                    k => {
                        let p = at(from + [0.0, 0.5, 1.0][k - 1] * through);
                        [40.0 - p[0], 30.0 - p[1]]
                    }
                };
                let caps = [at(from), at(from + through)];
                let wall = move |p: P| {
                    let q = [p[0] - middle[0], p[1] - middle[1]];
                    let angle = (q[1].atan2(q[0]).to_degrees() - from).rem_euclid(360.0);
                    let ends = caps.map(|c| (q[0] - c[0]).hypot(q[1] - c[1]));
                    let ends = ends[0].min(ends[1]);
                    (if angle <= through { (q[0].hypot(q[1]) - pitch).abs().min(ends) } else { ends }) - half
                };
                (
                    format!(
                        "CYCL DEF 254 X ~\nQ219={} ~\nQ375={} ~\nQ367={position} ~\nQ216=11 ~\nQ217=-3 ~\nQ376={from} ~\nQ248={through} ~\nQ378=0 ~\nQ377=1 ~\nQ366={plunge} ~\n{end}",
                        2.0 * half, 2.0 * pitch
                    ),
                    Cell { wall: Box::new(wall), extent: pitch + half, middle },
                )
            }
        };
        // Where the ends of a circular slot overlap its wall is no longer this one.
        prop_assume!(kind != 2 || (360.0 - through).to_radians() * pitch > 2.5 * half);
        let text = program(&cycle, "M3");
        judge(&samples(&ops(&text, &settings(Some(radius)))), &cell, radius, 0.0, -7.0, &text);
    }

    #[test]
    fn pockets_of_an_840d_are_cleared(
        round in any::<bool>(), a in 6.0..30.0f64, b in 6.0..30.0f64, corner in 0.0..1.5f64, radius in 2.0..5.9f64,
        side in 0.0..0.1f64, floor in 0.0..0.5f64, turn in 0.0..180.0f64, width in 0.0..14.0f64, insertion in 0..4u32,
        direction in 0..4u32, m4 in any::<bool>(), finish in any::<bool>(),
    ) {
        let b = if round { a } else { b };
        let room = a.min(b) - radius - side;
        let insertion = if round && insertion == 3 || room < 0.01 && insertion == 2 { 1 } else { insertion };
        let end = |units: u32, helix: f64| format!("12,{insertion}{units},{width},,,,{helix},0.7)").replacen("12,", "", 1);
        let helix = if insertion == 3 { 5.0 } else { (0.9 * room).max(0.001) };
        let call = |units: u32| if round {
            format!("POCKET4(10,0,2,-12,{a},40,30,5,{side},{floor},400,100,{direction},{}", end(units, helix).replacen(",,,,", ",,,", 1))
        } else {
            format!("POCKET3(10,0,2,-12,{},{},{},40,30,{turn},5,{side},{floor},400,100,{direction},{}", 2.0 * a, 2.0 * b, corner * a.min(b), end(units, helix))
        };
        let last = if finish { call(2) } else { String::new() };
        let text = format!("T1 D1 M6\nS900 {} F300\nG0 X0 Y0 Z50\n{}\n{last}\nG0 Z60\nM30\n", if m4 { "M4" } else { "M3" }, call(1));
        let mut settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
        settings.variables.insert("$P_TOOLR".to_owned(), radius);
        let commands: Vec<Op> = Program::from_text("p.mpf", &text, &settings)
            .unwrap()
            .map(|c| c.map(|c| c.op).unwrap_or_else(|e| panic!("{e}\n{text}")))
            .collect();
        let round_corner = if round { a } else { (corner * a.min(b)).min(a.min(b)).max(radius) };
        let middle = [40.0, 30.0];
        let cell = Cell {
            wall: Box::new(move |p| {
                rectangle(turned([p[0] - middle[0], p[1] - middle[1]], if round { 0.0 } else { -turn }), a, b, round_corner)
            }),
            extent: a.hypot(b),
            middle,
        };
        let points = samples(&commands);
        // With both allowances the base is milled up to the wall.
        let left = if finish && (side > 0.0 || floor > 0.0) { 0.0 } else { side };
        let depth = if finish && floor > 0.0 { -12.0 } else { -12.0 + floor };
        judge(&points, &cell, radius, left, depth, &text);
    }

    #[test]
    fn surfaces_of_an_840d_are_faced(
        a in 5.0..60.0f64, b in 5.0..60.0f64, left in any::<bool>(), down in any::<bool>(), turn in 0.0..180.0f64,
        radius in 3.0..20.0f64, part in 0.2..2.0f64, beyond in 0.0..5.0f64, over in 0.0..3.0f64, variant in 1..5u32, floor in 0.0..1.0f64,
    ) {
        let (sa, sb) = (if left { -a } else { a }, if down { -b } else { b });
        let text = format!(
            "T1 D1 M6\nS900 M3 F300\nG0 X0 Y0 Z50\nCYCLE71(10,0,2,-7,40,30,{sa},{sb},{turn},3,{},{beyond},{floor},400,{variant}1,{over})\nG0 Z60\nM30\n",
            part * radius
        );
        let mut settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
        settings.variables.insert("$P_TOOLR".to_owned(), radius);
        let commands: Vec<Op> = Program::from_text("p.mpf", &text, &settings)
            .unwrap()
            .map(|c| c.map(|c| c.op).unwrap_or_else(|e| panic!("{e}\n{text}")))
            .collect();
        let points = samples(&commands);
        let low: Vec<P> = points.iter().filter(|p| (p[2] + 7.0 - floor).abs() < 1e-9).map(|p| [p[0], p[1]]).collect();
        // Infeeds are equal and none is above 3 mm.
        let mut heights: Vec<f64> = points.iter().map(|p| p[2]).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|x, y| (*x - *y).abs() < 1e-9);
        let step = (7.0 - floor) / ((7.0 - floor) / 3.0).ceil();
        for pair in heights.windows(2).filter(|pair| pair[1] < 1e-9) {
            prop_assert!((pair[1] - pair[0] - step).abs() < 1e-9, "{:?}\n{}", heights, text);
        }
        for i in 0..=30 {
            for j in 0..=30 {
                let q = turned([sa * f64::from(i) / 30.0, sb * f64::from(j) / 30.0], turn);
                let p = [q[0] + 40.0, q[1] + 30.0];
                let near = low.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1])).fold(f64::INFINITY, f64::min);
                prop_assert!(near <= radius + 1e-3 * radius + 0.001, "{:?} stays: {} of {}\n{}", p, near, radius, text);
            }
        }
        // Next to the surface the tool comes down, free of it.
        let far = |p: P| {
            let q = turned([p[0] - 40.0, p[1] - 30.0], -turn);
            let x = (q[0] - 0.5 * sa).abs() - 0.5 * a;
            let y = (q[1] - 0.5 * sb).abs() - 0.5 * b;
            if variant % 2 == 1 { x } else { y }
        };
        prop_assert!(low.iter().all(|p| far(*p) <= radius + beyond + 1e-9), "{}", text);
        prop_assert!((far(low[0]) - radius - beyond).abs() < 1e-9, "{}", text);
    }

    #[test]
    fn studs_stand_and_what_is_around_them_is_gone(
        a in 5.0..20.0f64, b in 5.0..20.0f64, more in 0.5..15.0f64, round in any::<bool>(), corner in 0.0..5.0f64,
        radius in 2.0..8.0f64, overlap in 0.4..1.6f64, climb in any::<bool>(), turn in -90.0..90.0f64,
    ) {
        let b = if round { a } else { b };
        let corner = if round { a } else { corner };
        let end = tail(0, 0.0, 0.0, 5.0, climb);
        let cycle = if round {
            format!("CYCL DEF 257 X ~\nQ223={} ~\nQ222={} ~\nQ370={overlap} ~\nQ376={turn} ~\n{end}", 2.0 * a, 2.0 * (a + more))
        } else {
            format!(
                "CYCL DEF 256 X ~\nQ218={} ~\nQ424={} ~\nQ219={} ~\nQ425={} ~\nQ220={corner} ~\nQ224={turn} ~\nQ367=0 ~\nQ370={overlap} ~\nQ437=0 ~\n{end}",
                2.0 * a, 2.0 * (a + more), 2.0 * b, 2.0 * (b + more)
            )
        };
        let text = program(&cycle, "M3");
        let points = samples(&ops(&text, &settings(Some(radius))));
        let stud = |p: P| {
            let q = turned([p[0] - 40.0, p[1] - 30.0], if round { 0.0 } else { -turn });
            rectangle(q, a, b, corner.min(a).min(b))
        };
        let low: Vec<P> = points.iter().filter(|p| (p[2] + 7.0).abs() < 1e-9).map(|p| [p[0], p[1]]).collect();
        for p in &points {
            let d = stud([p[0], p[1]]);
            prop_assert!(d >= radius - 1e-6, "the tool at {:?} is {} from the stud\n{}", p, d, text);
        }
        for i in 0..=50 {
            for j in 0..=50 {
                let at = |k: i32, half: f64| half * (f64::from(k) / 25.0 - 1.0);
                let (x, y) = (at(i, a + more), at(j, b + more));
                // The blank of a round stud is round.
                if round && x.hypot(y) > a + more {
                    continue;
                }
                let t = turned([x, y], if round { 0.0 } else { turn });
                let p = [40.0 + t[0], 30.0 + t[1]];
                let d = stud(p);
                // Corners of a rectangular blank may lie farther out than the last ring reaches.
                if d < 1e-9 || d > more {
                    continue;
                }
                let near = low.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1])).fold(f64::INFINITY, f64::min);
                prop_assert!(near <= radius + 0.06, "{:?} stays, {} from the stud: {}\n{}", p, d, near, text);
            }
        }
    }

    #[test]
    fn bores_are_round_and_threads_have_their_pitch(
        bore in 0.1..3.9f64, radius in 2.0..6.0f64, pitch in 0.3..4.0f64, climb in any::<bool>(), left in any::<bool>(),
        overlap in 0.3..1.9f64, steps in 0..4u32,
    ) {
        let diameter = 2.0 * radius + 2.0 * bore;
        let sign = if climb { "+1" } else { "-1" };
        let text = program(
            &format!("CYCL DEF 208 X ~\nQ200=2 ~\nQ201=-12 ~\nQ206=300 ~\nQ334={pitch} ~\nQ203=5 ~\nQ204=20 ~\nQ335={diameter} ~\nQ342=0 ~\nQ351={sign} ~\nQ370={overlap}"),
            "M3",
        );
        let points = samples(&ops(&text, &settings(Some(radius))));
        let cell = Cell {
            wall: Box::new(move |p| (p[0] - 40.0).hypot(p[1] - 30.0) - 0.5 * diameter),
            extent: 0.5 * diameter,
            middle: [40.0, 30.0],
        };
        judge(&points, &cell, radius, 0.0, -7.0, &text);

        let hand = if left { -1.0 } else { 1.0 };
        let text = program(
            &format!("CYCL DEF 262 X ~\nQ335={diameter} ~\nQ239={} ~\nQ201=-12 ~\nQ355={steps} ~\nQ253=700 ~\nQ351={sign} ~\nQ200=2 ~\nQ203=5 ~\nQ204=20 ~\nQ207=300", hand * pitch),
            "M3",
        );
        let ops = ops(&text, &settings(Some(radius)));
        let mut at = [0.0; 3];
        let mut turns = 0.0;
        for op in &ops {
            match op {
                Op::Arc(arc) => {
                    let end = arc.motion.end.xyz().unwrap();
                    if (arc.radius - bore).abs() < 1e-9 {
                        // A right-hand helix rises counter-clockwise.
                        let rise = (end[2] - at[2]) / (arc.sweep / std::f64::consts::TAU) * arc.normal[2];
                        prop_assert!((rise - hand * pitch).abs() < 1e-9, "{} {}\n{}", rise, pitch, text);
                        prop_assert_eq!(arc.normal[2] > 0.0, climb);
                        turns += arc.sweep / std::f64::consts::TAU;
                    } else {
                        prop_assert!((arc.radius - 0.5 * bore).abs() < 1e-9, "{}", arc.radius);
                    }
                    at = end;
                }
                Op::Linear(m) | Op::Rapid(m) => at = m.end.xyz().unwrap_or(at),
                _ => {}
            }
        }
        let want = match steps {
            0 => 1.0,
            1 => 12.0 / pitch,
            n => (12.0 / (f64::from(n) * pitch) - 1e-9).ceil(),
        };
        prop_assert!((turns - want).abs() < 1e-6, "{} turns, {} wanted\n{}", turns, want, text);
    }

    /// Threads of 263, 264 and 265 have their pitch, hand, depth and number of turns; 264 drills to its depth
    /// in infeeds that are no deeper than asked, 265 goes down; the countersink runs at its depth and offset.
    /// Corners: both hands, climb and up-cut, no countersink, one infeed.
    #[test]
    fn threads_are_drilled_and_countersunk(
        bore in 0.2..3.9f64, radius in 2.0..6.0f64, pitch in 0.3..3.0f64, climb in any::<bool>(), left in any::<bool>(),
        number in 263u32..266, front in prop::option::of(0.2..4.0f64), offset in 0.0..2.0f64, behind in any::<bool>(), infeed in 1.0..15.0f64,
    ) {
        let diameter = 2.0 * radius + 2.0 * bore;
        let hand = if left { -1.0 } else { 1.0 };
        let hole = -(12.1 + 0.5 * pitch);
        let front_depth = if number == 264 { 0.0 } else { front.unwrap_or(0.0) };
        let more = match number {
            263 => "Q356=0 ~\nQ357=0.2 ~\nQ254=110".to_owned(),
            264 => format!("Q356={hole} ~\nQ202={infeed} ~\nQ258=0.5 ~\nQ257=0 ~\nQ256=0.2 ~\nQ206=120"),
            _ => format!("Q360={} ~\nQ254=110", u8::from(behind)),
        };
        let text = program(
            &format!(
                "CYCL DEF {number} X ~\nQ335={diameter} ~\nQ239={} ~\nQ201=-12 ~\nQ253=700 ~\nQ351={} ~\nQ358={} ~\nQ359={offset} ~\nQ200=2 ~\nQ203=5 ~\nQ204=20 ~\nQ207=300 ~\n{more}",
                hand * pitch, if climb { "+1" } else { "-1" }, -front_depth,
            ),
            "M3",
        );
        let mut at = [0.0; 3];
        let (mut turns, mut sunk, mut drilled, mut lowest) = (0.0, 0.0, Vec::new(), f64::MAX);
        for op in &ops(&text, &settings(Some(radius))) {
            match op {
                Op::Arc(arc) => {
                    let end = arc.motion.end.xyz().unwrap();
                    let rise = end[2] - at[2];
                    let around = (arc.center[0] - 40.0).hypot(arc.center[1] - 30.0) < 1e-9;
                    if around && rise.abs() > 1e-9 {
                        prop_assert!((arc.radius - bore).abs() < 1e-9);
                        let per_turn = rise / (arc.sweep / std::f64::consts::TAU) * arc.normal[2];
                        prop_assert!((per_turn - hand * pitch).abs() < 1e-9, "{} {}\n{}", per_turn, pitch, text);
                        prop_assert!(number == 265 && rise < 0.0 || number != 265 && (arc.normal[2] > 0.0) == climb, "{}", text);
                        turns += arc.sweep / std::f64::consts::TAU;
                        lowest = lowest.min(end[2]).min(at[2]);
                    } else if around {
                        prop_assert!((end[2] - (5.0 - front_depth)).abs() < 1e-9 && (arc.radius - offset).abs() < 1e-9);
                        sunk += arc.sweep / std::f64::consts::TAU;
                    }
                    at = end;
                }
                Op::Linear(m) => {
                    let end = m.end.xyz().unwrap_or(at);
                    // Drilled: straight down in feed.
                    if number == 264 && turns == 0.0 && end[2] < at[2] && end[2] < 5.0 {
                        drilled.push((at[2], end[2]));
                    }
                    at = end;
                }
                Op::Rapid(m) => at = m.end.xyz().unwrap_or(at),
                _ => {}
            }
        }
        let want = if number == 265 { 12.0 / pitch } else { 1.0 };
        prop_assert!((turns - want).abs() < 1e-6 && (lowest + 7.0).abs() < 1e-9, "{} turns to {}\n{}", turns, lowest, text);
        prop_assert_eq!(sunk > 0.5, front_depth > 0.0 && offset > 1e-6, "{}", text);
        if number == 264 {
            prop_assert!((drilled.iter().map(|d| d.1).fold(f64::MAX, f64::min) - 5.0 - hole).abs() < 1e-9, "{:?}", drilled);
            prop_assert!(drilled.windows(2).all(|w| w[1].1 >= w[0].1 - infeed - 1e-9), "{:?}\n{}", drilled, text);
            prop_assert_eq!(drilled.len(), (-hole / infeed - 1e-9).ceil() as usize, "{:?}", drilled);
        }
    }

    #[test]
    fn a_face_is_covered(
        length in 20.0..90.0f64, width in 5.0..60.0f64, sign in 0..4usize, radius in 3.0..20.0f64, overlap in 0.4..1.9f64,
        strategy in 0..3u32, depth in 0.5..9.0f64, infeed in 1.0..5.0f64, allowance in 0.0..0.4f64,
    ) {
        let (l, w) = ([length, -length][sign % 2], [width, -width][sign / 2]);
        let text = program(
            &format!("CYCL DEF 232 X ~\nQ389={strategy} ~\nQ225=7 ~\nQ226=-4 ~\nQ227=5 ~\nQ386={} ~\nQ218={l} ~\nQ219={w} ~\nQ202={infeed} ~\nQ369={allowance} ~\nQ370={overlap} ~\nQ207=500 ~\nQ385=300 ~\nQ253=900 ~\nQ200=2 ~\nQ357=3 ~\nQ204=10", 5.0 - depth),
            "M3",
        );
        let points = samples(&ops(&text, &settings(Some(radius))));
        let low: Vec<P> = points.iter().filter(|p| (p[2] - 5.0 + depth).abs() < 1e-9).map(|p| [p[0], p[1]]).collect();
        for i in 0..=40 {
            for j in 0..=40 {
                let p = [7.0 + l * f64::from(i) / 40.0, -4.0 + w * f64::from(j) / 40.0];
                let near = low.iter().map(|q| (p[0] - q[0]).hypot(p[1] - q[1])).fold(f64::INFINITY, f64::min);
                // Strategy 1 ends with its edge on that of the surface, so that corners of it may stay there.
                let corner = strategy == 1 && (i < 40 && f64::from(i) * length / 40.0 < radius || f64::from(40 - i) * length / 40.0 < radius);
                prop_assert!(corner || near <= radius + 0.06, "{:?} stays: {}\n{}", p, near, text);
            }
        }
        // No infeed is deeper than allowed, and no pass is farther from the next than the overlap says.
        let mut depths: Vec<f64> = points.iter().map(|p| p[2]).filter(|z| *z < 5.0 - 1e-9).collect();
        depths.sort_by(f64::total_cmp);
        prop_assert!((depths[0] - (5.0 - depth)).abs() < 1e-9);
    }
}

const POCKET: &str = "CYCL DEF 252 CIRCULAR POCKET ~\nQ215=0 ~\nQ223=36 ~\nQ368=0.2 ~\nQ207=200 ~\nQ351=+1 ~\nQ201=-17 ~\nQ202=18 ~\nQ369=0.1 ~\nQ206=150 ~\nQ338=0 ~\nQ200=1 ~\nQ203=0 ~\nQ204=40 ~\nQ370=1 ~\nQ366=0 ~\nQ385=90";

#[test]
fn what_the_manual_leaves_open_is_reported_as_an_assumption() {
    let all = ops(&program(POCKET, "M3"), &settings(Some(5.0)));
    let notes = all.iter().filter(|op| matches!(op, Op::Note(text) if text.contains("cycle 252"))).count();
    assert_eq!(notes, 1, "{all:?}");
    assert!(all.iter().any(|op| matches!(op, Op::Note(text) if text.starts_with(proveout_nc::ASSUMED))));
}

#[test]
fn the_radius_comes_from_the_tool_in_the_spindle() {
    let mut radii = ToolRadii::default();
    radii.by_tool.insert(ToolName::Number(1), 4.0);
    let with = Settings { compensation: Compensation::ToolCenter(radii), ..settings(None) };
    let all = ops(&program(POCKET, "M3"), &with);
    let largest =
        all.iter().filter_map(|op| if let Op::Arc(a) = op { Some(a.radius) } else { None }).fold(0.0, f64::max);
    assert!((largest - 14.0).abs() < 1e-9, "{largest}");
    // Another tool has no radius: the path of the tool center is asked for and not known.
    let other = program(POCKET, "M3").replace("TOOL CALL 1", "TOOL CALL 2");
    assert!(read(&other, &with).unwrap_err().starts_with("nc-compensation"));
}

#[test]
fn without_a_radius_the_wall_is_given_with_compensation() {
    for (cycle, side) in [(POCKET.to_owned(), "Left"), (POCKET.replace("Q351=+1", "Q351=-1"), "Right")] {
        let all = ops(&program(&cycle, "M3"), &settings(None));
        let comp: Vec<_> =
            all.iter().filter_map(|op| if let Op::CutterComp(c) = op { Some(c.side) } else { None }).collect();
        assert_eq!(format!("{comp:?}"), format!("[{side}, Off]"));
        let radius = all.iter().find_map(|op| if let Op::Arc(a) = op { Some(a.radius) } else { None }).unwrap();
        assert!((radius - 18.0).abs() < 1e-9);
    }
}

#[test]
fn wrong_words_of_milling_cycles_are_named() {
    for (from, to, code, word) in [
        ("Q223=36", "Q223=9", "nc-compensation", "does not fit"),
        ("Q370=1 ", "Q370=2 ", "nc-bad-value", "Q370"),
        ("Q351=+1", "Q351=+2", "nc-bad-value", "Q351"),
        ("Q215=0", "Q215=3", "nc-bad-value", "Q215"),
        ("Q366=0", "Q366=7", "nc-bad-value", "Q366"),
        ("Q201=-17", "Q201=0", "nc-arguments", "Q201"),
        ("Q368=0.2 ~\n", "", "nc-arguments", "Q368"),
    ] {
        let text = program(&POCKET.replace(from, to), "M3");
        let error = read(&text, &settings(Some(5.0))).unwrap_err();
        assert!(error.starts_with(code) && error.contains(word), "{from} -> {to}: {error}");
    }
}

#[test]
fn threads_that_are_not_followed_are_refused() {
    let plain = "CYCL DEF 264 X ~\nQ335=20 ~\nQ239=2 ~\nQ201=-12 ~\nQ356=-13 ~\nQ253=700 ~\nQ351=+1 ~\nQ202=5 ~\nQ258=0.5 ~\nQ257=0 ~\nQ256=0.2 ~\nQ358=0 ~\nQ359=0 ~\nQ200=2 ~\nQ203=5 ~\nQ204=20 ~\nQ206=120 ~\nQ207=300";
    assert!(read(&program(plain, "M3"), &settings(Some(5.0))).is_ok());
    for (from, to, code, says) in [
        ("Q257=0", "Q257=1", "nc-unsupported-word", "Q257"),
        ("Q358=0", "Q358=-1", "nc-unsupported-word", "Q358"),
        ("Q356=-13", "Q356=13", "nc-arguments", "Q356"),
        ("Q356=-13", "Q356=-12.9", "nc-arguments", "13.000 mm deep"),
        ("Q239=2 ", "Q239=0 ", "nc-arguments", "pitch"),
        ("Q335=20", "Q335=9", "nc-compensation", "does not fit"),
        ("Q351=+1", "Q351=2", "nc-bad-value", "Q351"),
        ("Q206=120 ~\n", "", "nc-arguments", "Q206"),
        ("264", "266", "nc-unsupported-word", "266"),
        ("264", "267", "nc-unsupported-word", "267"),
    ] {
        let error = read(&program(&plain.replace(from, to), "M3"), &settings(Some(5.0))).unwrap_err();
        assert!(error.starts_with(code) && error.contains(says), "{from} -> {to}: {error}");
    }
    let sunk = "CYCL DEF 263 X ~\nQ335=20 ~\nQ239=2 ~\nQ201=-12 ~\nQ356=-13 ~\nQ253=700 ~\nQ351=+1 ~\nQ200=2 ~\nQ357=0 ~\nQ358=0 ~\nQ359=0 ~\nQ203=5 ~\nQ204=20 ~\nQ254=120 ~\nQ207=300";
    let error = read(&program(sunk, "M3"), &settings(Some(5.0))).unwrap_err();
    assert!(error.starts_with("nc-unsupported-word") && error.contains("Q356=-13"), "{error}");
    let flag = "CYCL DEF 265 X ~\nQ335=20 ~\nQ239=2 ~\nQ201=-12 ~\nQ253=700 ~\nQ358=-1 ~\nQ359=1 ~\nQ360=2 ~\nQ200=2 ~\nQ203=5 ~\nQ204=20 ~\nQ254=120 ~\nQ207=300";
    let error = read(&program(flag, "M3"), &settings(Some(5.0))).unwrap_err();
    assert!(error.starts_with("nc-bad-value") && error.contains("Q360"), "{error}");
}
