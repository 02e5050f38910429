//! The least clearance of every pair, and the spans that prove it.
#![allow(clippy::print_stdout, reason = "the figures of a run by hand")]

use std::path::Path;

use proveout_collision::{Fixture, Interference, PairClearance, ProvedSpan, SolidPair};
use proveout_geom::{Aabb, Point, TriMesh, box_mesh, cylinder_mesh};
use proveout_machine::{Attachment, JointValues, Machine};
use proveout_tool::{ToolId, ToolLibrary};

use crate::common::Random;

fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn machine(name: &str) -> Machine {
    Machine::read(&root().join("machines").join(name)).unwrap_or_else(|e| panic!("{e}"))
}

fn block(min: [f64; 3], max: [f64; 3]) -> TriMesh {
    box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) })
}

fn fixtures() -> Vec<Fixture> {
    let fixture = |name: &str, mesh| Fixture { name: name.into(), mesh, on_table: true };
    vec![
        fixture("vise", block([-60.0, -60.0, 0.0], [60.0, 60.0, 40.0])),
        fixture("stop", cylinder_mesh(8.0, 0.0, 70.0, 48)),
    ]
}

/// A way of five joints that wanders over the setup, through corners and back.
fn way(machine: &Machine, random: &mut Random, pieces: usize) -> Vec<JointValues> {
    let mut q = machine.home();
    let mut all = vec![q];
    let mut goal = q;
    for k in 0..pieces {
        if k % 40 == 0 {
            for (j, joint) in machine.joints.iter().enumerate() {
                let [low, high] = joint.travel.unwrap_or([-3.0, 3.0]);
                let middle = joint.home.clamp(low, high);
                let reach = if joint.is_rotary() { 0.6 } else { 150.0 };
                goal[j] = random.next((middle - reach).max(low), (middle + reach).min(high));
            }
        }
        q = q.interpolated(goal, 0.08);
        all.push(q);
    }
    all
}

fn spans_of<'a>(check: &'a Interference, of: &PairClearance) -> Vec<&'a ProvedSpan> {
    check.proved_spans().iter().filter(|s| s.pair == of.pair).collect()
}

/// Whether the joints are in the range of a span.
fn in_range(span: &ProvedSpan, q: &JointValues) -> bool {
    (0..q.0.len()).all(|j| span.low[j] - 1e-12 <= q[j] && q[j] <= span.high[j] + 1e-12)
}

/// Random motion of shipped machines that speeds up and brakes within each piece: every span holds at times
/// within it, by the distances of the solids; spans follow each other without a gap; at every moment the
/// joints are in the range of one of its time; and the least distance is known to a micrometer where it is
/// small.
#[test]
fn spans_hold_at_every_time_and_the_least_is_true_to_a_micrometer() {
    let mut random = Random::new(0x2545_f491_4f6c_dd1d);
    let mut cut = 0;
    for name in ["spinner-u5-620", "bc-trunnion", "three-axis-mill"] {
        let machine = machine(name);
        let mut check = Interference::new(&machine, &fixtures(), 0.5).expect("solids").with_proof();
        let way = way(&machine, &mut random, 400);
        for (k, w) in way.windows(2).enumerate() {
            check.check_piece(&w[0], &w[1], [k as f64, k as f64 + 1.0], 2e-4);
        }
        let least = check.least_clearances().to_vec();
        assert!(least.len() >= 4, "{name}: {}", least.len());
        assert_eq!(least.len(), check.pairs().iter().filter(|p| p.unchecked.is_none()).count());
        let meshes = |name: &str| -> (TriMesh, Attachment) {
            let of_machine = machine.bodies.iter().find(|b| b.name == name).map(|b| (b.mesh.clone(), b.attached_to));
            let table = machine.work_chain.last().map_or(Attachment::Base, |j| Attachment::Joint(*j));
            let of_setup = || fixtures().into_iter().find(|f| f.name == name).map(|f| (f.mesh, table));
            of_machine.or_else(of_setup).expect("body")
        };
        let (mut exact, mut short_spans) = (0, 0);
        for pair in &least {
            let spans = spans_of(&check, pair);
            if pair.neighbors {
                // The check of the motion alone reports them.
                let near = check.breaches().iter().any(|b| b.pair == pair.pair);
                assert!(spans.is_empty() && pair.measured.is_some() == near, "{name} {pair:?}");
                assert_eq!(pair.proved, if near { 0.0 } else { 0.5 });
                continue;
            }
            assert_eq!((spans[0].time[0], spans[spans.len() - 1].time[1]), (0.0, 400.0));
            let follows = |w: &[&ProvedSpan]| w[0].time[1] == w[1].time[0] || w[0].time == w[1].time;
            assert!(spans.windows(2).all(follows));
            // From standstill to standstill: a quarter of the time is 5/32 of the way.
            let at = |time: f64| {
                let piece = (time.floor() as usize).min(way.len() - 2);
                let t = time - piece as f64;
                way[piece].interpolated(way[piece + 1], t * t * (3.0 - 2.0 * t))
            };
            for short in spans.iter().filter(|s| s.time[1] - s.time[0] < 1.5) {
                for part in [0.1, 0.25, 0.6, 0.85] {
                    let time = short.time[0] + (short.time[1] - short.time[0]) * part;
                    let mut of_time = spans.iter().filter(|s| s.time[0] <= time && time <= s.time[1]);
                    let held = of_time.any(|s| in_range(s, &at(time)));
                    assert!(held, "{name} {time} {short:?}");
                    short_spans += 1;
                }
            }
            let [a, b] = [0, 1].map(|k| meshes(&check.pairs()[pair.pair].bodies[k]));
            let mut solids = SolidPair::new(&a.0, &b.0).expect("solids");
            let mut nearest = f64::INFINITY;
            for k in 0..=50 {
                let time = 7.99 * f64::from(k);
                let q = at(time);
                let pose = machine.attachment_pose(b.1, &q).inverse() * machine.attachment_pose(a.1, &q);
                let distance = solids.distance(&pose);
                nearest = nearest.min(distance);
                let of_time = spans.iter().filter(|s| s.time[0] <= time && time <= s.time[1] && in_range(s, &q));
                let holding: Vec<_> = of_time.collect();
                assert!(!holding.is_empty(), "{name} {pair:?} at {time}");
                for span in holding {
                    assert!(span.least() <= distance + 1e-6, "{name} {pair:?} {span:?}: {distance}");
                }
            }
            let measured = pair.measured.expect("asked");
            // Far pairs are searched to half of their distance.
            assert!(pair.proved <= nearest + 1e-6 && measured <= 2.1 * nearest + 0.5, "{name} {pair:?}: {nearest}");
            if measured < 20.0 {
                exact += 1;
                assert!(measured - pair.proved <= 1.3e-3, "{name} {pair:?}");
            }
        }
        let spans = check.proved_spans().len();
        let measured = |p: &PairClearance| p.measured.unwrap_or(f64::INFINITY);
        let best = least.iter().filter(|p| !p.neighbors).min_by(|a, b| measured(a).total_cmp(&measured(b)));
        let best = best.expect("a pair");
        println!(
            "{name}: {} pairs, {exact} below 20 mm, {spans} spans, {short_spans} looks into short ones, {} looks; {best:?}",
            least.len(),
            check.looks()
        );
        assert!(measured(best) - best.proved <= 1.3e-3, "{name} {best:?}");
        cut += short_spans;
    }
    println!("{cut} looks into short spans");
}

/// A fin on a table that turns towards a pillar on the base and back: at all turns it would hit it, so that
/// turns must be followed, and pieces cut to find the least distance to a micrometer. Distances of the solids
/// at many moments hold every span.
#[test]
fn turns_are_followed_where_the_hull_of_all_of_them_is_too_near() {
    let machine = machine("bc-trunnion");
    let fixture = |name: &str, mesh, on_table| Fixture { name: name.into(), mesh, on_table };
    let fin = block([200.0, -5.0, 5.0], [230.0, 5.0, 60.0]);
    let pillar = block([-10.0, 190.0, 5.0], [10.0, 240.0, 60.0]);
    let fixtures = [fixture("fin", fin.clone(), true), fixture("pillar", pillar.clone(), false)];
    let mut check = Interference::new(&machine, &fixtures, 0.5).expect("solids").with_proof();
    let c = machine.joint("C").expect("C");
    let sense = machine.joints[c].sense;
    let at = |k: f64| {
        let mut q = machine.home();
        q[c] = sense * 1.44 * (1.0 - (k / 5.0 - 1.0).abs());
        q
    };
    for k in 0..10 {
        let k = f64::from(k);
        check.check_piece(&at(k), &at(k + 1.0), [k, k + 1.0], 2e-4);
    }
    assert!(check.breaches().is_empty(), "{:?}", check.breaches());
    let least = check.least_clearances();
    let of_pair = |a: &str, b: &str| {
        let named = |p: &&PairClearance| check.pairs()[p.pair].bodies.iter().all(|n| **n == *a || **n == *b);
        least.iter().find(named).unwrap_or_else(|| panic!("{a} {b}"))
    };
    let pair = of_pair("fin", "pillar");
    let spans = spans_of(&check, pair);
    let mut solids = SolidPair::new(&fin, &pillar).expect("solids");
    let (mut nearest, mut parts) = (f64::INFINITY, 0);
    for k in 0..=2000 {
        let time = f64::from(k) / 200.0;
        // Each piece from standstill to standstill.
        let (piece, t) = (time.floor().min(9.0), time - time.floor().min(9.0));
        let q = at(piece).interpolated(at(piece + 1.0), t * t * (3.0 - 2.0 * t));
        let pose = machine.attachment_pose(Attachment::Joint(c), &q);
        let distance = solids.distance(&pose);
        nearest = nearest.min(distance);
        let holding: Vec<_> =
            spans.iter().filter(|s| s.time[0] <= time && time <= s.time[1] && in_range(s, &q)).collect();
        assert!(!holding.is_empty(), "{time}");
        for span in holding {
            assert!(span.least() <= distance + 1e-6, "{time} {span:?}: {distance}");
            parts += usize::from(span.high[c] - span.low[c] < 0.2);
        }
    }
    let measured = pair.measured.expect("asked");
    assert!(measured < 20.0 && measured <= nearest + 1e-6 && nearest <= measured + 0.01, "{measured} {nearest}");
    assert!(measured - pair.proved <= 1.3e-3 && parts > 0, "{pair:?}, {parts} looks into parts of a piece");
    // The table below the pillar is as far from it at every turn.
    let turned = |s: &&ProvedSpan| s.low[c] == f64::NEG_INFINITY && s.high[c] == f64::INFINITY;
    assert!(check.proved_spans().iter().filter(turned).count() > 0);
}

/// A finishing pass as the benchmark has it: what the proof costs in looks and spans.
#[test]
fn a_finishing_pass_takes_few_spans() {
    let machine = machine("spinner-u5-620");
    let tools = ToolLibrary::read(&root().join("tools/axis-cross.toml")).unwrap_or_else(|e| panic!("{e}"));
    let tool = tools.find(&ToolId::Name("SCHAFT_D12_N_AP30".into())).expect("tool");
    let mut check = Interference::new(&machine, &fixtures(), 0.5).expect("solids").with_proof();
    check.set_tool(Some(tool));
    let (b, c) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    let joints = |k: usize| {
        let s = 0.02 * k as f64;
        let tip = Point::new(25.0 * (s / 25.0).cos(), 25.0 * (s / 25.0).sin() - 20.0, 45.0);
        let mut rotary = JointValues::ZERO;
        (rotary[b], rotary[c]) = (0.3 + 0.1 * (s / 40.0).sin(), s / 100.0);
        machine.inverse_with_rotary(&tip, &rotary, tool.gauge_length)
    };
    for k in 0..20_000 {
        check.check_piece(&joints(k), &joints(k + 1), [k as f64, k as f64 + 1.0], 5e-4);
    }
    let least = check.least_clearances().to_vec();
    println!("{} looks, {} spans, {} pairs", check.looks(), check.proved_spans().len(), least.len());
    assert!(check.proved_spans().len() < 4000 && check.looks() < 40_000);
    let near = least.iter().filter(|p| !p.neighbors && p.measured.is_some_and(|m| m < 20.0));
    assert!(near.clone().count() > 2);
    assert!(near.clone().all(|p| p.measured.is_some_and(|m| m - p.proved <= 1.6e-3)));
}

/// A table that turns below bearings and walls of fine meshes, all far away, and a tool near a post: what is
/// far must not use up what the proof may cost. (When each look at two meshes was exact, however far apart
/// they were, 1,117 looks at bearing caps 234 mm from the table took 5.6 s.)
#[test]
fn meshes_that_turn_far_from_each_other_cost_little() {
    let machine = machine("bc-trunnion");
    let post = Fixture { name: "post".into(), mesh: cylinder_mesh(15.0, 0.0, 100.0, 48), on_table: true };
    let tools = ToolLibrary::read(&root().join("tools/axis-cross.toml")).unwrap_or_else(|e| panic!("{e}"));
    let tool = tools.find(&ToolId::Name("SCHAFT_D12_N_AP30".into())).expect("tool");
    let mut check = Interference::new(&machine, &[post], 0.5).expect("solids").with_proof();
    check.set_tool(Some(tool));
    let (b, c) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    // Forty turns of the table; the tip stays 12 mm above the post, and nods.
    let joints = |k: usize| {
        let turn = std::f64::consts::TAU * k as f64 / 100.0;
        let mut rotary = JointValues::ZERO;
        (rotary[b], rotary[c]) = (0.2 + 0.1 * (turn / 7.0).sin(), turn);
        machine.inverse_with_rotary(&Point::new(5.0 * turn.cos(), 5.0 * turn.sin(), 112.0), &rotary, tool.gauge_length)
    };
    for k in 0..4000 {
        check.check_piece(&joints(k), &joints(k + 1), [k as f64, k as f64 + 1.0], 1e-3);
    }
    let least = check.least_clearances();
    let measured = least.iter().filter_map(|p| p.measured).fold(f64::INFINITY, f64::min);
    let proved = least.iter().filter(|p| !p.neighbors).map(|p| p.proved).fold(f64::INFINITY, f64::min);
    println!("{measured} mm, proved {proved} mm: {} looks, {} pairs of boxes", check.looks(), check.proof_effort());
    assert!(measured > 5.0 && proved > 0.9 * measured, "{proved} of {measured} mm");
    assert!(check.proof_effort() < 60_000_000, "{} pairs of boxes", check.proof_effort());
}
