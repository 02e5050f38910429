//! Injected events with closed forms: thin grazes, swings past an edge, cut corners, bodies inside of others.
//!
//! `PROVEOUT_EVENTS=10000 cargo test -p proveout_collision --test collision events::` runs ten thousand of
//! them; without the variable it is a hundredth.
//!
//! Corners that the generator visits: overlaps and misses from 1 to 100 micrometers, in equal shares of the
//! decades; walls of 0.2 mm; grazes along a wall and over its top; swings of 90 to 350 degrees in both
//! senses; corners passed at any angle within their normal cone, and motions of 400 mm in one piece; motions
//! split into 1 to 6 unequal pieces; any direction in the plane; the clearance zero and above; bodies inside
//! that are at rest or move along.
//!
//! Of every event it is known whether the parts meet, and when first. Those that meet are found, never late,
//! and no further apart than what is stated: 0.2 micrometers, and 1e-5 mm for rounding. Those that miss are
//! not named.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

use proveout_collision::{Fixture, Interference, Severity};
use proveout_geom::{Aabb, Point, Pose, Vector, box_mesh};
use proveout_machine::{JointValues, Machine};
use proveout_tool::{Cutter, HolderSection, Tool, ToolBuilder};

use crate::common::Random;

/// Nearness that counts as a touch, mm: the tolerance of the advancement (2e-4), the slack for rounding
/// (1e-5), and what a proved distance of a tool may be below the true one (1e-7).
const STATED_MM: f64 = 2.102e-4;
const GAUGE: f64 = 120.0;
/// Radius of the cutter, mm.
const R: f64 = 6.0;

/// X Y Z in the tool, C in the table; the gauge line at the machine zero with all joints at zero.
fn machine() -> Machine {
    let linear = |name: &str, parent: &str, direction: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
             direction = {direction}\ntravel_mm = [-1000, 1000]\n"
        )
    };
    let text = [
        "name = \"test\"\n".to_owned(),
        linear("X", "base", "[1, 0, 0]"),
        linear("Y", "X", "[0, 1, 0]"),
        linear("Z", "Y", "[0, 0, 1]"),
        "[[joint]]\nname = \"C\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"base\"\ndirection = [0, 0, 1]\n\
         point_mm = [0, 0, 0]\nsense = -1\n".into(),
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n\
         [table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [control]\ncycle_time_ms = 2\nblock_time_ms = 1\nrapid_mode = \"straight\"\ntool_change_time_s = 5\n\
         default_tolerance_mm = 0.01\n".into(),
    ]
    .concat();
    Machine::from_text(Path::new("test.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

/// Ball of radius 6 with 20 mm of flutes, a shank of radius 5, a holder of radius 30 from 50 mm over the tip
/// on.
fn tool() -> Tool {
    let section = |diameter, length| HolderSection { diameter, top_diameter: diameter, length };
    ToolBuilder::new(1, "BALL", Cutter::ball(2.0 * R).expect("ball"), 20.0, GAUGE)
        .shank(10.0)
        .holder([section(60.0, 70.0)])
        .build()
        .expect("tool")
}

/// An event: a body on the table, the motion, and what is true of it.
struct Event {
    what: String,
    body: Fixture,
    from: JointValues,
    to: JointValues,
    /// When the parts meet first, 0 to 1; none for a miss.
    first: Option<f64>,
    /// Their distance at a time, mm.
    distance: Box<dyn Fn(f64) -> f64>,
}

fn at(tip: Point, c: f64) -> JointValues {
    let mut q = JointValues::ZERO;
    (q[0], q[1], q[2], q[3]) = (tip.x, tip.y, tip.z + GAUGE, c);
    q
}

fn fixture(min: [f64; 3], max: [f64; 3], turn: f64) -> Fixture {
    let mesh = box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) });
    Fixture { name: "body".into(), mesh: mesh.transformed(&Pose::from_axis_angle(&Vector::z(), turn)), on_table: true }
}

fn turned(p: Point, turn: f64) -> Point {
    Pose::from_axis_angle(&Vector::z(), turn).point(&p)
}

/// A circle of radius R moves along a straight way past a point: `depth` is how far it reaches over it at the
/// nearest place, `foot` the way to there and `length` the whole way. Gives the first touch and the distance
/// over time.
fn past_a_point(depth: f64, foot: f64, length: f64) -> (Option<f64>, Box<dyn Fn(f64) -> f64>) {
    let miss = R - depth;
    let first = (depth > 0.0).then(|| (foot - (R * R - miss * miss).sqrt()) / length);
    (first, Box::new(move |t| miss.hypot(foot - t * length) - R))
}

/// The side of the cutter along a wall of 0.2 mm, or its ball over the top of it.
fn graze(random: &mut Random, depth: f64) -> Event {
    let turn = random.next(0.0, TAU);
    if random.pick(2) == 0 {
        let wall = random.next(-40.0, 60.0);
        let body = fixture([wall, -20.0, 0.0], [wall + 0.2, 20.0, 65.0], turn);
        let ends = [-100.0, 100.0].map(|y| at(turned(Point::new(wall - R + depth, y, 50.0), turn), 0.0));
        // The edge at y = -20 is met first; after it the face keeps the depth.
        let (first, near) = past_a_point(depth, 80.0, 200.0);
        let distance = Box::new(move |t: f64| if 200.0 * t < 80.0 { near(t) } else { -depth });
        return Event { what: "along a wall".into(), body, from: ends[0], to: ends[1], first, distance };
    }
    let top = random.next(10.0, 30.0);
    let body = fixture([-0.1, -30.0, 0.0], [0.1, 30.0, top], turn);
    let (reach, y) = (random.next(10.0, 200.0), random.next(-20.0, 20.0));
    let ends = [-reach, reach].map(|x| at(turned(Point::new(x, y, top - depth), turn), 0.0));
    // The top edge at x = -0.1; over the face the lowest point of the ball counts.
    let (first, near) = past_a_point(depth, reach - 0.1, 2.0 * reach);
    let distance = Box::new(move |t: f64| if 2.0 * reach * t < reach - 0.1 { near(t) } else { -depth });
    Event { what: "over a wall".into(), body, from: ends[0], to: ends[1], first, distance }
}

/// The table swings a radial wall of 0.2 mm past the cutter: the corner of the wall is the nearest.
fn swing(random: &mut Random, depth: f64) -> Event {
    let half = 0.1;
    let end = random.next(20.0, 150.0);
    let corner = end.hypot(half);
    let center = corner + R - depth;
    let swing = random.next(90.0, 350.0_f64).to_radians();
    // How long before the middle of the cutter the middle of the wall is at the begin: the cutter is
    // clear of it at both ends.
    let clear = 1.2 * (R / center).asin() + 0.1;
    let begin = random.next(clear, swing - clear);
    let sense = if random.pick(2) == 0 { 1.0 } else { -1.0 };
    let azimuth = random.next(0.0, TAU);
    // Seen in the machine, a growing C turns the table by less: sense = -1.
    let body = fixture([end - 12.0, -half, 0.0], [end, half, 65.0], azimuth + sense * begin);
    let tip = turned(Point::new(center, 0.0, 50.0), azimuth);
    let lead = (half / end).atan();
    let apart = move |angle: f64| (corner * corner + center * center - 2.0 * corner * center * angle.cos()).sqrt();
    let touch = ((corner * corner + center * center - R * R) / (2.0 * corner * center)).min(1.0).acos();
    let first = (depth > 0.0).then(|| (begin - lead - touch) / swing);
    let distance = Box::new(move |t: f64| apart((begin - lead - t * swing).max(0.0)) - R);
    let what = format!("swing of {} degrees", swing.to_degrees());
    Event { what, body, from: at(tip, 0.0), to: at(tip, sense * swing), first, distance }
}

/// A rapid that cuts the corner round a block: the cutter passes the edge at any angle between its two faces.
fn corner(random: &mut Random, depth: f64) -> Event {
    let turn = random.next(0.0, TAU);
    let body = fixture([0.0, 0.0, 0.0], [50.0, 40.0, 65.0], turn);
    // The normal of the way points out of the corner at the origin, so far between the two faces (0.18
    // radian) that the edge is met first.
    let normal = random.next(std::f64::consts::PI + 0.2, std::f64::consts::PI + FRAC_PI_2 - 0.2);
    let (s, c) = normal.sin_cos();
    let (out, along) = (Vector::new(c, s, 0.0), Vector::new(-s, c, 0.0));
    let foot = Point::new(0.0, 0.0, 50.0) + out * (R - depth);
    let (before, after) = (random.next(60.0, 200.0), random.next(60.0, 200.0));
    let ends = [foot - along * before, foot + along * after].map(|p| at(turned(p, turn), 0.0));
    let (first, distance) = past_a_point(depth, before, before + after);
    Event { what: "corner".into(), body, from: ends[0], to: ends[1], first, distance }
}

/// Least clearance, proved and measured; the spans of every pair are without a gap and true.
fn least_of_all(check: &mut Interference, event: &Event) -> [f64; 2] {
    let least = check.least_clearances().to_vec();
    for pair in &least {
        let spans: Vec<_> = check.proved_spans().iter().filter(|s| s.pair == pair.pair).collect();
        // Parts of one piece have its time in common, and go on where the one before them ends.
        let proved = spans.iter().map(|s| s.least()).fold(f64::INFINITY, f64::min);
        assert_eq!((spans[0].time[0], spans[spans.len() - 1].time[1]), (0.0, 1.0));
        assert_eq!(proved, pair.proved);
        assert!(spans.windows(2).all(|w| w[0].time[1] == w[1].time[0] || w[0].time == w[1].time));
        for w in spans.windows(2) {
            let touches = (0..w[0].low.0.len()).all(|j| w[0].low[j].max(w[1].low[j]) <= w[0].high[j].min(w[1].high[j]));
            assert!(touches, "a gap: {w:?}");
        }
    }
    // The event names the nearest of the parts of the tool.
    for k in 0..=200 {
        let t = f64::from(k) / 200.0;
        let q = event.from.interpolated(event.to, t);
        let holds = |s: &&proveout_collision::ProvedSpan| {
            (0..q.0.len()).all(|j| s.low[j] - 1e-12 <= q[j] && q[j] <= s.high[j] + 1e-12)
        };
        for pair in &least {
            assert!(check.proved_spans().iter().filter(holds).any(|s| s.pair == pair.pair), "{}: at {t}", event.what);
        }
        let at = check.proved_spans().iter().filter(holds).map(proveout_collision::ProvedSpan::least);
        // Up to the nearest place.
        if (event.distance)(t) > (event.distance)(1.0) {
            assert!(at.fold(f64::INFINITY, f64::min) <= (event.distance)(t) + 1e-6, "{}: at {t}", event.what);
        }
    }
    let proved = least.iter().map(|p| p.proved).fold(f64::INFINITY, f64::min);
    [proved, least.iter().filter_map(|p| p.measured).fold(f64::INFINITY, f64::min)]
}

/// A small block wholly inside of the holder, or next to it; it is at rest or is passed along the axis.
fn inside(random: &mut Random, depth: f64) -> Event {
    let turn = random.next(0.0, TAU);
    let (half, height) = (random.next(0.5, 5.0), random.next(1.0, 4.0));
    // Its outer corners lie below the skin by the depth, or its inner face outside of it.
    let (low, high) = if depth > 0.0 {
        let high = ((30.0 - depth) * (30.0 - depth) - half * half).sqrt();
        (high - 3.0, high)
    } else {
        (30.0 - depth, 33.0 - depth)
    };
    let body = fixture([low, -half, 110.0], [high, half, 110.0 + height], turn);
    // The holder reaches from 50 to 120 mm over the tip.
    let rise = if random.pick(2) == 0 { 0.0 } else { random.next(-2.0, 2.0) };
    let (from, to) = (at(Point::new(0.0, 0.0, 20.0), 0.0), at(Point::new(0.0, 0.0, 20.0 + rise), 0.0));
    let first = (depth > 0.0).then_some(0.0);
    Event { what: "inside".into(), body, from, to, first, distance: Box::new(move |_| -depth) }
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures of a run by hand")]
fn injected_events_are_found_and_misses_are_not_named() {
    let count: usize = std::env::var("PROVEOUT_EVENTS").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    let (machine, tool) = (machine(), tool());
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    let families: [fn(&mut Random, f64) -> Event; 4] = [graze, swing, corner, inside];
    let (mut hits, mut misses, mut earliest) = (0, 0, 0.0_f64);
    for k in 0..count {
        let size = 10_f64.powf(random.next(-3.0, -1.0));
        let meets = (k / families.len()).is_multiple_of(2);
        let event = families[k % families.len()](&mut random, if meets { size } else { -size });
        let mut check =
            Interference::new(&machine, std::slice::from_ref(&event.body), 0.0).expect("solids").with_proof();
        check.set_tool(Some(&tool));
        let pieces = 1 + random.pick(6);
        let mut borders: Vec<f64> = (1..pieces).map(|_| random.next(0.0, 1.0)).chain([0.0, 1.0]).collect();
        borders.sort_by(f64::total_cmp);
        for pair in borders.windows(2) {
            let ends = [pair[0], pair[1]].map(|t| event.from.interpolated(event.to, t));
            check.check_piece(&ends[0], &ends[1], [pair[0], pair[1]], 0.0);
        }
        let found = check.breaches().iter().filter(|b| b.severity == Severity::Collision).map(|b| b.time);
        let found = found.fold(f64::INFINITY, f64::min);
        let about = || format!("event {k}, {} by {} mm: {found}, {:?}", event.what, size, event.first);
        match event.first {
            Some(first) => {
                hits += 1;
                assert!(found <= first + 1e-12, "missed or late: {}", about());
                let apart = (event.distance)(found);
                earliest = earliest.max(apart);
                assert!(apart <= STATED_MM + 1e-9, "early, {apart} mm apart: {}", about());
            }
            None => {
                misses += 1;
                assert!(check.breaches().is_empty(), "invented: {}", about());
                let proved = check.clearance().lower_bound;
                assert!(proved > 0.0 && proved <= size + 1e-9, "proved {proved}: {}", about());
                let least = least_of_all(&mut check, &event);
                assert!((-1e-6..=1.001e-3).contains(&(least[1] - least[0])), "{least:?}: {}", about());
                assert!(least[0] <= size + 1e-9 && least[1] >= size - 1e-6, "{least:?}: {}", about());
            }
        }
    }
    assert!(hits * 5 >= count * 2 && misses * 5 >= count * 2, "{hits} hits, {misses} misses");
    println!("{hits} hits found, at most {earliest:.1e} mm early; {misses} misses kept clear");
}
