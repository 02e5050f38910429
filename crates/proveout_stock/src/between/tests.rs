use proveout_geom::{ToolPose, TriMesh, Vector, box_mesh};
use proveout_tool::Segment;

use super::*;
use crate::Cells;

const TOUCH: f64 = 0.01;

fn numbers(mut state: u64) -> impl FnMut(f64, f64) -> f64 {
    move |low, high| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn flat(radius: f64, length: f64) -> Profile {
    let corners = [[0.0, 0.0], [radius, 0.0], [radius, length], [0.0, length]];
    Profile::new(corners.windows(2).map(|w| Segment::Line { from: w[0], to: w[1] }).collect()).expect("a cylinder")
}

fn ball(radius: f64, length: f64) -> Profile {
    Profile::new(vec![
        Segment::Arc { center: [0.0, radius], radius, from: [0.0, 0.0], to: [radius, radius] },
        Segment::Line { from: [radius, radius], to: [radius, length] },
        Segment::Line { from: [radius, length], to: [0.0, length] },
    ])
    .expect("a ball end")
}

fn block() -> Aabb {
    Aabb { min: Point::new(-30.0, -20.0, -20.0), max: Point::new(30.0, 20.0, 0.0) }
}

fn of(raw: &RawBody) -> BetweenRays {
    let stock = raw.stock(Cells([5.0; 3]), u64::MAX).expect("stock");
    BetweenRays::new(raw, &stock)
}

fn straight(from: [f64; 3], to: [f64; 3]) -> SweepMotion {
    let at = |tip: [f64; 3]| ToolPose { tip: Point::from(tip), axis: Vector::z() };
    SweepMotion { from: at(from), to: at(to) }
}

fn depth(found: BetweenFound) -> Option<f64> {
    match found {
        BetweenFound::Clear => None,
        BetweenFound::Material { depth_mm, .. } => Some(depth_mm),
        BetweenFound::Open { .. } => panic!("not decided: {found:?}"),
    }
}

#[test]
fn a_strip_off_an_edge_is_found_to_a_hundredth_and_its_twin_is_clear() {
    let mut next = numbers(11);
    for _ in 0..60 {
        let mut stock = of(&RawBody::block(&block()));
        let (radius, dip) = (next(0.5, 8.0), next(0.02, 1.5));
        let body = if next(0.0, 1.0) < 0.5 { flat(radius, 30.0) } else { flat(radius, 12.0) };
        let y = 20.0 + radius;
        let motion = |off: f64| straight([-50.0, y + off, -dip], [50.0, y + off, -dip]);
        let found = depth(stock.look(&body, &motion(-dip), TOUCH)).expect("it cuts the edge");
        assert!(found > 0.6 * dip.min(radius) && found < dip + 1e-3, "{found} of {dip}");
        assert_eq!(stock.look(&body, &motion(0.0), TOUCH), BetweenFound::Clear, "it slides along the face");
        assert_eq!(stock.look(&body, &motion(0.02), TOUCH), BetweenFound::Clear);
        // What was cut in feed before is no fault.
        stock.cut([&body].into_iter(), &motion(-dip));
        assert_eq!(stock.look(&body, &motion(-dip), TOUCH), BetweenFound::Clear, "it goes back");
        assert!(depth(stock.look(&body, &motion(-dip - 0.03), TOUCH)).is_some_and(|d| d < 0.031));
    }
}

#[test]
fn edges_along_no_axis_and_round_bars_are_as_exact() {
    let mut next = numbers(5);
    for case in 0..40 {
        let axis = Vector::new(next(-1.0, 1.0), next(-1.0, 1.0), next(-1.0, 1.0)).normalize();
        let (bar, length) = (next(2.0, 15.0), 40.0);
        let mut stock = of(&RawBody::cylinder(&Point::new(1.0, 2.0, 3.0), &axis, bar, length).expect("bar"));
        // A tool parallel to the bar goes past it at a distance, across or along.
        let side = axis.cross(&Vector::new(0.3, 0.2, 0.9)).normalize();
        let along = axis.cross(&side);
        let tool = next(0.3, 6.0);
        let body = flat(tool, 25.0);
        let at = |off: f64, way: f64| ToolPose {
            tip: Point::new(1.0, 2.0, 3.0) + axis * 5.0 + side * (bar + tool + off) + along * way,
            axis,
        };
        for off in [-0.2, -0.02, 0.02, 0.3] {
            let motion = SweepMotion { from: at(off, -40.0), to: at(off, 40.0) };
            let found = depth(stock.look(&body, &motion, TOUCH));
            assert_eq!(found.is_some(), off < 0.0, "{case}: {off}");
            if let Some(found) = found {
                assert!(found < -off + 1e-3 && found > -0.7 * off, "{case}: {found} {off}");
            }
        }
    }
}

#[test]
fn a_pin_of_a_mesh_is_found_and_room_beside_it_is_clear() {
    let mut next = numbers(9);
    for _ in 0..20 {
        let (x, y, width) = (next(-20.0, 20.0), next(-10.0, 10.0), next(0.03, 0.4));
        let mut mesh: TriMesh = box_mesh(&block());
        let pin = Aabb { min: Point::new(x, y, 0.0), max: Point::new(x + width, y + width, 10.0) };
        mesh.append(&box_mesh(&Aabb { min: pin.min + Vector::z() * 1e-6, ..pin }));
        let mut stock = of(&RawBody::mesh(mesh).expect("two shells"));
        let body = flat(3.0, 20.0);
        let through = straight([-50.0, y, 5.0], [50.0, y, 5.0]);
        assert!(depth(stock.look(&body, &through, TOUCH)).is_some());
        let past = straight([-50.0, y - 3.02, 5.0], [50.0, y - 3.02, 5.0]);
        assert_eq!(stock.look(&body, &past, TOUCH), BetweenFound::Clear);
        let over = straight([-50.0, y, 10.0], [50.0, y, 10.0]);
        assert_eq!(stock.look(&body, &over, TOUCH), BetweenFound::Clear, "it touches the top");
    }
}

#[test]
fn a_pocket_is_clear_up_to_its_walls_and_a_pillar_between_holes_is_found() {
    let mut stock = of(&RawBody::block(&block()));
    let cutter = flat(3.0, 6.0);
    for layer in 1..=3 {
        let z = -4.0 * f64::from(layer);
        for row in -2..=2 {
            let y = 2.5 * f64::from(row);
            stock.cut([&cutter].into_iter(), &straight([-15.0, y, z], [15.0, y, z]));
        }
        for x in [-15.0, 15.0] {
            stock.cut([&cutter].into_iter(), &straight([x, -5.0, z], [x, 5.0, z]));
        }
    }
    let wide = |dy: f64| straight([-10.0, dy, -11.99], [10.0, dy, -11.99]);
    let holder = flat(7.0, 60.0);
    assert_eq!(stock.look(&holder, &wide(0.98), TOUCH), BetweenFound::Clear, "a hundredth from the wall");
    assert!(depth(stock.look(&holder, &wide(1.03), TOUCH)).is_some());
    let down = straight([0.0, 0.0, -11.99], [0.0, 0.0, -12.05]);
    assert!(depth(stock.look(&holder, &down, TOUCH)).is_some_and(|d| d < 0.051));
    // Up along the walls that it has cut, and away from them.
    assert_eq!(stock.look(&cutter, &straight([15.0, 5.0, -12.0], [15.0, 5.0, 20.0]), TOUCH), BetweenFound::Clear);
    assert_eq!(stock.look(&cutter, &straight([15.0, 5.0, -12.0], [0.0, 0.0, 5.0]), TOUCH), BetweenFound::Clear);
    let shank = flat(3.0, 40.0);
    assert_eq!(stock.look(&shank, &straight([-15.0, 5.0, -12.0], [15.0, 5.0, -12.0]), TOUCH), BetweenFound::Clear);
    // Four holes leave a pillar with hollow sides.
    let mut stock = of(&RawBody::block(&block()));
    for (x, y) in [(2.5, 2.5), (-2.5, 2.5), (2.5, -2.5), (-2.5, -2.5)] {
        stock.cut([&cutter].into_iter(), &straight([x, y, 5.0], [x, y, -5.0]));
    }
    let thin = flat(0.4, 20.0);
    assert!(depth(stock.look(&thin, &straight([0.0, 0.0, -2.0], [0.0, 0.0, 20.0]), TOUCH)).is_some());
    assert_eq!(stock.is_material(&Point::new(0.0, 0.0, -2.0)), Some(true));
    assert_eq!(stock.is_material(&Point::new(1.0, 1.0, -2.0)), Some(false));
}

#[test]
#[ignore = "nightly, 29 s"]
fn tilted_tools_that_turn_go_back_on_their_way() {
    let mut next = numbers(3);
    for case in 0..30 {
        let mut stock = of(&RawBody::block(&block()));
        let body = ball(next(1.0, 6.0), 30.0);
        let tilt = |a: f64, b: f64| Vector::new(a, b, 1.0).normalize();
        let mut way = Vec::new();
        for k in 0..20 {
            let t = f64::from(k) / 19.0;
            let tip = Point::new(-20.0 + 40.0 * t, 3.0 * (6.0 * t).sin(), -3.0 - t);
            way.push(ToolPose { tip, axis: tilt(0.3 * t, 0.2 * (4.0 * t).cos()) });
        }
        let pieces: Vec<SweepMotion> = way.windows(2).map(|w| SweepMotion { from: w[0], to: w[1] }).collect();
        pieces.iter().for_each(|m| stock.cut([&body].into_iter(), m));
        for m in &pieces {
            let back = SweepMotion { from: m.to, to: m.from };
            assert_eq!(stock.look(&body, &back, TOUCH), BetweenFound::Clear, "{case}");
        }
        let last = way[19];
        let up = ToolPose { tip: last.tip + last.axis * 40.0, ..last };
        assert_eq!(stock.look(&body, &SweepMotion { from: last, to: up }, TOUCH), BetweenFound::Clear, "{case}");
        let below = ToolPose { tip: last.tip - Vector::z() * 0.04, ..last };
        assert!(depth(stock.look(&body, &SweepMotion { from: below, to: below }, TOUCH)).is_some(), "{case}");
    }
}

#[test]
fn many_are_cleared_at_once_and_the_bad_one_stays_in_doubt() {
    let mut stock = of(&RawBody::block(&block()));
    let body = flat(5.0, 40.0);
    let many: Vec<SweepMotion> = (0..50)
        .map(|k| {
            let z = if k == 31 { -0.3 } else { 0.5 };
            straight([f64::from(k) - 25.0, 0.0, z], [f64::from(k) - 24.0, 0.0, z])
        })
        .collect();
    let asked: Vec<(&Profile, SweepMotion)> = many.iter().map(|m| (&body, *m)).collect();
    let doubtful = stock.in_doubt(&asked, TOUCH);
    assert_eq!(doubtful.iter().filter(|d| **d).count(), 1);
    assert!(doubtful[31]);
}

#[test]
fn what_an_earlier_run_left_is_open_only_near_its_rays() {
    let bounds = block();
    let earlier = TriDexel::from_box(&bounds, 1.0, 1 << 30).expect("stock");
    let mut raw = RawBody::earlier(earlier, Vec::new(), &proveout_geom::Pose::identity()).expect("something is left");
    raw.prepare(1.0, false).expect("cells");
    let mut stock = of(&raw);
    let body = flat(5.0, 40.0);
    let at = |y: f64, z: f64| straight([-50.0, y, z], [50.0, y, z]);
    assert!(matches!(stock.look(&body, &at(24.9, -0.1), TOUCH), BetweenFound::Open { .. }));
    assert_eq!(stock.look(&body, &at(0.0, 3.0), TOUCH), BetweenFound::Clear);
    assert_eq!(stock.look(&body, &at(30.0, -5.0), TOUCH), BetweenFound::Clear);
}

#[test]
fn a_part_that_was_taken_away_leaves_its_place_open() {
    let mut stock = of(&RawBody::block(&block()));
    stock.part_is_gone(&Aabb { min: Point::new(0.0, -20.0, -20.0), max: block().max });
    let body = flat(5.0, 40.0);
    assert!(matches!(
        stock.look(&body, &straight([10.0, 0.0, 5.0], [10.0, 0.0, -1.0]), TOUCH),
        BetweenFound::Open { .. }
    ));
    assert!(depth(stock.look(&body, &straight([-10.0, 0.0, 5.0], [-10.0, 0.0, -1.0]), TOUCH)).is_some());
}
