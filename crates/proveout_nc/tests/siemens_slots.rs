//! Slots and spigots of an 840D against their walls, written here by distances: the tool never crosses a
//! wall, touches it all around where the cycle finishes, and goes as deep as the program says, in no
//! larger steps.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Dialect, Op, Program, Settings};

type P = [f64; 2];

const RADIUS: f64 = 6.0;

/// Points along the motions in feed of a cycle, 0.2 mm apart at most, with the lines of its assumptions left
/// out.
fn path(cycle: &str) -> Vec<[f64; 3]> {
    let mut settings = Settings { dialect: Dialect::Siemens840d, ..Settings::default() };
    settings.variables.insert("$P_TOOLR".to_owned(), RADIUS);
    let text = format!("T1 D1 M6\nS900 M3 F300\nG0 X0 Y0 Z50\n{cycle}\nG0 Z60\nM30\n");
    let (mut at, mut all) = ([0.0; 3], Vec::new());
    for command in Program::from_text("p.mpf", text.as_str(), &settings).unwrap() {
        match command.unwrap_or_else(|e| panic!("{e}\n{text}")).op {
            Op::Rapid(m) => at = std::array::from_fn(|i| m.end.get(i).unwrap_or(at[i])),
            Op::Linear(m) => {
                let to: [f64; 3] = std::array::from_fn(|i| m.end.get(i).unwrap());
                for i in 0..=100 {
                    let t = f64::from(i) / 100.0;
                    all.push(std::array::from_fn(|k| at[k] + t * (to[k] - at[k])));
                }
                at = to;
            }
            Op::Arc(arc) => {
                let d = [at[0] - arc.center[0], at[1] - arc.center[1]];
                let to: [f64; 3] = std::array::from_fn(|i| arc.motion.end.get(i).unwrap());
                for i in 0..=200 {
                    let t = f64::from(i) / 200.0;
                    let (s, c) = (arc.normal[2] * arc.sweep * t).sin_cos();
                    all.push([
                        arc.center[0] + c * d[0] - s * d[1],
                        arc.center[1] + s * d[0] + c * d[1],
                        at[2] + t * (to[2] - at[2]),
                    ]);
                }
                let last = *all.last().unwrap();
                assert!((last[0] - to[0]).hypot(last[1] - to[1]) < 1e-6, "{arc:?}");
                at = to;
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

/// Distance to a rectangle with rounded corners about the origin, below zero inside.
fn rectangle(p: P, a: f64, b: f64, corner: f64) -> f64 {
    let q = [p[0].abs() - a + corner, p[1].abs() - b + corner];
    q[0].max(0.0).hypot(q[1].max(0.0)) + q[0].max(q[1]).min(0.0) - corner
}

/// Distance to a slot along a circle about the origin, from an angle on.
fn curved(p: P, pitch: f64, from: f64, through: f64, half: f64) -> f64 {
    let angle = (p[1].atan2(p[0]).to_degrees() - from).rem_euclid(360.0);
    let ends = [from, from + through].map(|d| {
        let c = turned([pitch, 0.0], d);
        (p[0] - c[0]).hypot(p[1] - c[1])
    });
    let end = ends[0].min(ends[1]);
    (if angle <= through { end.min((p[0].hypot(p[1]) - pitch).abs()) } else { end }) - half
}

fn depths(points: &[[f64; 3]]) -> Vec<f64> {
    let mut list: Vec<f64> = points.windows(2).filter(|w| w[0][2] == w[1][2]).map(|w| w[0][2]).collect();
    list.sort_by(|a, b| b.total_cmp(a));
    list.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    list
}

#[test]
fn slots_stay_in_their_walls_and_reach_them() {
    for (row, sta, inda, tens, cdir) in
        [(3, 20.0, 0.0, 1, 0), (2, -30.0, 75.0, 3, 1), (4, 0.0, 90.0, 0, 2), (1, 200.0, 0.0, 1, 3)]
    {
        let step = if inda == 0.0 { 360.0 / f64::from(row) } else { inda };
        // SLOT1: 34 x 16 from 25 on.
        let points = path(&format!(
            "SLOT1(10,0,2,-7,,{row},34,16,80,50,25,{sta},{inda},100,300,3,{cdir},0.3,{tens}0,0,200,1200,0,8)"
        ));
        let wall = |p: P| {
            (0..row)
                .map(|n| {
                    let q = turned([p[0] - 80.0, p[1] - 50.0], -(sta + f64::from(n) * step));
                    rectangle([q[0] - 42.0, q[1]], 17.0, 8.0, 8.0)
                })
                .fold(f64::INFINITY, f64::min)
        };
        check_inside(&points, wall, -7.0, 3.0);
        if tens != 3 {
            // SLOT2: 50 degrees along a radius of 40, 15 wide.
            let points = path(&format!(
                "SLOT2(10,0,2,,7,{row},50,15,80,50,40,{sta},{inda},100,300,3,{cdir},0.3,{tens}0,0,200,1200)"
            ));
            let wall = |p: P| {
                (0..row)
                    .map(|n| curved([p[0] - 80.0, p[1] - 50.0], 40.0, sta + f64::from(n) * step, 50.0, 7.5))
                    .fold(f64::INFINITY, f64::min)
            };
            check_inside(&points, wall, -7.0, 3.0);
        }
    }
}

/// No point is nearer to the wall than the radius, some at the bottom touch it, and no infeed is
/// larger than asked.
fn check_inside(points: &[[f64; 3]], wall: impl Fn(P) -> f64, bottom: f64, infeed: f64) {
    let nearest = points.iter().map(|p| -wall([p[0], p[1]])).fold(f64::INFINITY, f64::min);
    assert!((nearest - RADIUS).abs() < 1e-6, "the tool comes within {nearest}");
    let low = points.iter().filter(|p| (p[2] - bottom).abs() < 1e-9);
    let against = low.filter(|p| (-wall([p[0], p[1]]) - RADIUS).abs() < 1e-6).count();
    assert!(against > 100, "{against} points stand against the wall at the bottom");
    let depths = depths(points);
    assert!((depths.last().unwrap() - bottom).abs() < 1e-9, "{depths:?}");
    let mut before = 0.0;
    for depth in depths {
        assert!(before - depth < infeed + 1e-9, "from {before} to {depth}");
        before = depth;
    }
}

#[test]
fn elongated_holes_are_as_long_as_they_should_be() {
    for (row, sta, inda, mid) in [(4, 45.0, 90.0, 6.0), (3, 10.0, 0.0, 0.0), (1, -70.0, 0.0, 2.5)] {
        let step = if inda == 0.0 { 360.0 / f64::from(row) } else { inda };
        let points = path(&format!("LONGHOLE(10,0,1,,23,{row},30,40,45,20,{sta},{inda},100,320,{mid})"));
        let wall = |p: P| {
            (0..row)
                .map(|n| {
                    let q = turned([p[0] - 40.0, p[1] - 45.0], -(sta + f64::from(n) * step));
                    rectangle([q[0] - 35.0, q[1]], 15.0, RADIUS, RADIUS)
                })
                .fold(f64::INFINITY, f64::min)
        };
        check_inside(&points, wall, -23.0, if mid > 0.0 { mid } else { 23.0 });
        // Each hole is passed from end to end at the bottom.
        for n in 0..row {
            for end in [26.0, 44.0] {
                let at = turned([end, 0.0], sta + f64::from(n) * step);
                let there = |p: &&[f64; 3]| {
                    (p[0] - 40.0 - at[0]).hypot(p[1] - 45.0 - at[1]) < 1e-6 && (p[2] + 23.0).abs() < 1e-9
                };
                assert!(points.iter().any(|p| there(&p)), "hole {n}, {end}");
            }
        }
    }
}

#[test]
fn spigots_are_gone_around_and_left_whole() {
    for (cdir, sta) in [(0, 0.0), (1, 35.0), (2, -80.0), (3, 150.0)] {
        for (vari, allowance) in [(1, 0.4), (2, 0.0)] {
            let text = format!("CYCLE76(20,0,2,-9,,50,30,6,10,20,{sta},4,0.4,0,400,150,{cdir},{vari},60,44)");
            let wall = |p: P| rectangle(turned([p[0] - 10.0, p[1] - 20.0], -sta), 25.0, 15.0, 6.0);
            check_outside(&path(&text), wall, allowance, 30.0, -9.0);
            let text = format!("CYCLE77(20,0,2,-9,,40,10,20,4,0.4,0,400,150,{cdir},{vari},56)");
            check_outside(&path(&text), |p| (p[0] - 10.0).hypot(p[1] - 20.0) - 20.0, allowance, 28.0, -9.0);
        }
    }
}

/// No point is nearer to the spigot than radius and allowance, the ring around it is closed at the bottom,
/// and the tool goes down clear of the blank, which ends `blank` from the middle.
fn check_outside(points: &[[f64; 3]], wall: impl Fn(P) -> f64, allowance: f64, blank: f64, bottom: f64) {
    let nearest = points.iter().map(|p| wall([p[0], p[1]])).fold(f64::INFINITY, f64::min);
    assert!((nearest - RADIUS - allowance).abs() < 1e-6, "the tool comes within {nearest}");
    let near = |p: &&[f64; 3]| (p[2] - bottom).abs() < 1e-9 && (wall([p[0], p[1]]) - nearest).abs() < 1e-6;
    let mut sectors = [false; 12];
    for p in points.iter().filter(near) {
        let angle = (p[1] - 20.0).atan2(p[0] - 10.0).to_degrees().rem_euclid(360.0);
        sectors[(angle / 30.0) as usize % 12] = true;
    }
    assert!(sectors.iter().all(|s| *s), "{sectors:?}");
    for w in points.windows(2).filter(|w| w[0][2] != w[1][2] && w[0][0] == w[1][0] && w[0][1] == w[1][1]) {
        let from = (w[0][0] - 10.0).hypot(w[0][1] - 20.0);
        assert!(from > blank + RADIUS + 2.0 - 1e-6, "the tool goes down {from} from the middle");
    }
}
