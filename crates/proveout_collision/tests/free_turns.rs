//! Free angles of a turn against the exact distance of the tool in its poses.

use std::f64::consts::{PI, TAU};

use proveout_collision::{Obstacle, OrientationSettings, OrientationSpace, ToolClearance};
use proveout_geom::{Aabb, AxisTurn, Point, ToolPose, Vector, box_mesh, revolved_mesh};
use proveout_tool::{Cutter, HolderSection, Tool, ToolBuilder};

fn tool() -> Tool {
    let section = |diameter, top_diameter, length| HolderSection { diameter, top_diameter, length };
    let cutter = Cutter::ball(8.0).expect("ball");
    let builder = ToolBuilder::new(1, "BALL", cutter, 8.0, 90.0).shank(8.0);
    builder.holder([section(20.0, 32.0, 30.0), section(63.0, 63.0, 15.0)]).build().expect("tool")
}

fn pose(turn: &AxisTurn, center: Point, angle: f64, radius: f64) -> ToolPose {
    let across = (1.0 - turn.axial * turn.axial).sqrt();
    let [u, v, w] = turn.basis;
    let axis = u * (across * angle.cos()) + v * (across * angle.sin()) + w * turn.axial;
    ToolPose { tip: center - axis * radius, axis }
}

/// A post next to a wall: what is reported free is free for every center of the drift, and what is not is
/// met a little farther on.
#[test]
fn free_angles_are_free_and_end_where_the_tool_meets_the_solids() {
    let tool = tool();
    let block = |min: [f64; 3], max: [f64; 3]| box_mesh(&Aabb { min: min.into(), max: max.into() });
    let wall = block([10.0, -40.0, -5.0], [20.0, 40.0, 60.0]);
    let post = revolved_mesh(&[[0.0, 0.0], [6.0, 0.0], [6.0, 50.0], [0.0, 50.0]], 24);
    let clearance = 0.5;
    let settings = OrientationSettings { clearance, ..OrientationSettings::default() };
    let solids =
        [Obstacle { name: "wall", mesh: &wall, cut: false }, Obstacle { name: "post", mesh: &post, cut: false }];
    let space = OrientationSpace::new(&tool, &solids, &settings).expect("space");
    let named = [("wall".to_owned(), wall.clone()), ("post".to_owned(), post.clone())];
    let exact = ToolClearance::new(&tool, &named).expect("clearance");
    let mut met = 0;
    for k in 0..24 {
        let at = f64::from(k);
        let turn = AxisTurn {
            center: Point::new(-14.0 - 0.5 * at, 3.0 * (at - 12.0) * 0.4, 20.0 + at),
            drift: 0.02 * at,
            basis: [Vector::x(), Vector::z(), -Vector::y()],
            axial: 0.04 * (at - 12.0),
            spread: 1e-4,
        };
        let free = space.free_turns(&turn).expect("a ball");
        // Intervals are in order and apart.
        assert!(free.windows(2).all(|w| w[0][1] < w[1][0]) && free.iter().all(|i| i[0] < i[1]));
        for [from, to] in &free {
            for step in 0..=60 {
                let angle = from + (to - from) * f64::from(step) / 60.0;
                for off in [Vector::zeros(), Vector::x(), -Vector::x(), Vector::y(), Vector::z(), -Vector::z()] {
                    let pose = pose(&turn, turn.center + off * turn.drift, angle, 4.0);
                    let distance = exact.distance(&pose, 50.0);
                    assert!(distance > clearance - 1e-6, "{k} {angle} {distance}");
                }
            }
        }
        // Just outside of an interval some center of the drift is too near, by the angle of the smallest
        // pieces and the drift over the distance.
        for [from, to] in free.iter().filter(|i| i[1] - i[0] < TAU - 1e-6) {
            for angle in [from - 0.05, to + 0.05] {
                let places = [-1.0, 0.0, 1.0].iter().flat_map(|x| [-1.0, 0.0, 1.0].map(|z| Vector::new(*x, 0.0, z)));
                let least = places
                    .map(|off| {
                        let off = off.try_normalize(1e-9).unwrap_or_default();
                        exact.distance(&pose(&turn, turn.center + off * turn.drift, angle, 4.0), 50.0)
                    })
                    .fold(f64::MAX, f64::min);
                assert!(least < clearance + 1.6, "{k} {angle} {least}");
                met += 1;
            }
        }
    }
    assert!(met > 20, "{met}");
}

#[test]
fn nothing_near_leaves_the_whole_turn_and_a_flat_end_has_none() {
    let far = box_mesh(&Aabb { min: [500.0, 0.0, 0.0].into(), max: [510.0, 10.0, 10.0].into() });
    let solids = [Obstacle { name: "far", mesh: &far, cut: true }];
    let turn = AxisTurn {
        center: Point::origin(),
        drift: 0.1,
        basis: [Vector::x(), Vector::y(), Vector::z()],
        axial: 0.0,
        spread: 0.0,
    };
    let settings = OrientationSettings::default();
    let space = OrientationSpace::new(&tool(), &solids, &settings).expect("space");
    assert_eq!(space.free_turns(&turn), Some(vec![[-PI, PI]]));
    assert_eq!(space.free_turns(&AxisTurn { drift: f64::NAN, ..turn }), None);
    let flat = ToolBuilder::new(1, "FLAT", Cutter::flat(8.0).expect("flat"), 20.0, 90.0).build().expect("tool");
    let space = OrientationSpace::new(&flat, &solids, &settings).expect("space");
    assert_eq!(space.free_turns(&turn), None);
}
