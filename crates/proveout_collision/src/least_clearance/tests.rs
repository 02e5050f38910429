//! Bounds of pairs whose search ends early, against distances at many places of the motion.

use std::path::Path;

use proveout_geom::{Aabb, Point, box_mesh, cylinder_mesh};
use proveout_machine::JointValues;
use proveout_tool::{ToolId, ToolLibrary};

use super::*;
use crate::Fixture;
use crate::distance::gap;

/// A tool that runs close over a block while the table turns and tilts below it.
fn way(machine: &Machine, gauge_length: f64, pieces: usize) -> Vec<JointValues> {
    let (b, c) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    let at = |k: usize| {
        let s = k as f64 / 20.0;
        let tip = Point::new(25.0 * s.cos(), 25.0 * (1.3 * s).sin(), 44.2 + 0.9 * (3.1 * s).sin());
        let mut rotary = JointValues::ZERO;
        (rotary[b], rotary[c]) = (0.3 + 0.2 * (s / 2.0).sin(), s);
        machine.inverse_with_rotary(&tip, &rotary, gauge_length)
    };
    (0..=pieces).map(at).collect()
}

/// Every span of every pair holds at four places of each piece of a way that takes a second each, and no more
/// is proved of the pair than is there. Gives how many spans of parabolas were held.
fn holds(check: &Interference, least: &[PairClearance], way: &[JointValues], about: &str) -> usize {
    let (spans, pieces) = (check.proved_spans(), way.len() - 1);
    let mut curved = 0;
    for pair in check.pairs.iter().filter(|p| p.neighbors.is_none()) {
        let entry = least.iter().find(|l| l.pair == pair.info).expect("given");
        let of_pair: Vec<&ProvedSpan> = spans.iter().filter(|s| s.pair == pair.info).collect();
        assert_eq!((of_pair[0].time[0], of_pair[of_pair.len() - 1].time[1]), (0.0, pieces as f64));
        let follows = |w: &[&ProvedSpan]| w[0].time[1] == w[1].time[0] || w[0].time == w[1].time;
        assert!(of_pair.windows(2).all(follows), "{about}");
        let [a, b] = [&check.parts[pair.a], &check.parts[pair.b]];
        for k in (0..4 * pieces).step_by(if entry.proved < 50.0 { 1 } else { 15 }) {
            let (piece, t) = (k / 4, f64::from(k as u32 % 4) / 4.0);
            let q = way[piece].interpolated(way[piece + 1], t);
            let time = piece as f64 + t;
            let pose = b_from_a(&check.machine, a, b, &q);
            let distance = match gap(&a.shape, &b.shape, &pose, [f64::INFINITY; 2], &mut None) {
                Separation::At(d, ..) => d,
                Separation::Meeting(_) => 0.0,
                other => panic!("{other:?}"),
            };
            assert!(entry.proved <= distance + 1e-6, "{about}: {entry:?}, {distance} at {time}");
            let inside = |s: &&&ProvedSpan| {
                s.time[0] <= time
                    && time <= s.time[1]
                    && (0..MAX_JOINTS).all(|j| s.low[j] - 1e-12 <= q[j] && q[j] <= s.high[j] + 1e-12)
            };
            let holding: Vec<_> = of_pair.iter().filter(inside).collect();
            assert!(!holding.is_empty(), "{about}: {entry:?} at {time}");
            for span in holding {
                curved += usize::from(span.curved);
                assert!(span.least() <= distance + 1e-6, "{about}: {span:?}, {distance} at {time}");
            }
        }
    }
    curved
}

/// However little a search may cost, every span holds at many places of its motion, the spans cover all of
/// it, and what is proved of a pair is never above what is there. With all the effort the least distance is
/// known to a micrometer.
#[test]
#[ignore = "nightly, 34 s"]
fn what_little_effort_proves_is_true() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let machine = Machine::read(&root.join("machines/spinner-u5-620")).unwrap_or_else(|e| panic!("{e}"));
    let tools = ToolLibrary::read(&root.join("tools/axis-cross.toml")).unwrap_or_else(|e| panic!("{e}"));
    let tool = tools.find(&ToolId::Name("SCHAFT_D12_N_AP30".into())).expect("tool");
    let block = box_mesh(&Aabb { min: Point::new(-60.0, -60.0, 0.0), max: Point::new(60.0, 60.0, 40.0) });
    let fixture = |name: &str, mesh| Fixture { name: name.into(), mesh, on_table: true };
    let fixtures = [fixture("block", block), fixture("stop", cylinder_mesh(8.0, 0.0, 41.0, 48))];
    let way = way(&machine, tool.gauge_length, 150);
    let mut reached = Vec::new();
    let efforts = [(0, 0, 0), (1 << 9, 1 << 10, 64), (1 << 12, 1 << 15, 1 << 9), (1 << 15, 1 << 26, 1 << 14)];
    for (coarse, fine, look) in efforts {
        let mut check = Interference::new(&machine, &fixtures, 0.1).expect("solids").with_proof();
        check.proof.as_mut().expect("kept").efforts = Efforts { coarse, fine, look };
        check.set_tool(Some(tool));
        for (k, w) in way.windows(2).enumerate() {
            check.check_piece(&w[0], &w[1], [k as f64, k as f64 + 1.0], 1e-4);
        }
        let least = check.least_clearances();
        assert_eq!(
            least.iter().filter(|l| !l.neighbors).count(),
            check.pairs.iter().filter(|p| p.neighbors.is_none()).count()
        );
        let curved = holds(&check, &least, &way, &coarse.to_string());
        let near = least.iter().filter(|l| l.measured.is_some_and(|m| m < 5.0));
        let open = near.clone().filter_map(|l| Some(l.measured? - l.proved)).fold(0.0, f64::max);
        reached.push((near.count(), open, curved, check.proof_effort()));
    }
    let full = reached[3];
    assert!(full.0 > 1 && full.1 <= 1.3e-3 && full.2 > 0, "{reached:?}");
    assert!(reached.windows(2).all(|w| w[0].3 < w[1].3) && reached[2].1 > 0.01, "{reached:?}");
}

/// A ball that runs 0.2 mm over a face while the table turns: what the check has found of the pieces is not
/// asked again, its spans hold, and the least is as well known as without it, as are those of all pairs.
#[test]
fn what_the_check_has_found_is_not_asked_again() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let machine = Machine::read(&root.join("machines/spinner-u5-620")).unwrap_or_else(|e| panic!("{e}"));
    let tools = ToolLibrary::read(&root.join("tools/blade-root.toml")).unwrap_or_else(|e| panic!("{e}"));
    let tool = tools.find(&ToolId::Name("BALL_D12_LONG".into())).expect("tool");
    let block = box_mesh(&Aabb { min: Point::new(-60.0, -60.0, 0.0), max: Point::new(60.0, 60.0, 40.0) });
    let fixtures = [Fixture { name: "block".into(), mesh: block, on_table: true }];
    let (b, c) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    let at = |k: usize| {
        let s = k as f64 / 60.0;
        let mut rotary = JointValues::ZERO;
        (rotary[b], rotary[c]) = (0.3 + 0.1 * (s / 2.0).sin(), s);
        // The center of the ball runs 6.2 mm over the face, and a little more in some places.
        let axis = machine.forward(&rotary, tool.gauge_length).axis;
        let center = Point::new(25.0 * s.cos(), 25.0 * (1.3 * s).sin(), 46.2 + 1e-3 * (1.0 + (9.0 * s).sin()));
        machine.inverse_with_rotary(&(center - axis * 6.0), &rotary, tool.gauge_length)
    };
    let way: Vec<JointValues> = (0..=300).map(at).collect();
    let run = |noted: bool| {
        let mut check = Interference::new(&machine, &fixtures, 0.1).expect("solids").with_proof();
        check.set_tool(Some(tool));
        for (k, w) in way.windows(2).enumerate() {
            check.check_piece(&w[0], &w[1], [k as f64, k as f64 + 1.0], 1e-4);
        }
        assert!(check.breaches().is_empty(), "{:?}", check.breaches());
        let proof = check.proof.as_mut().expect("kept");
        assert!(proof.noted.len() > 200, "{}", proof.noted.len());
        if !noted {
            proof.noted.clear();
        }
        let least = check.least_clearances();
        holds(&check, &least, &way, "slide");
        (least, check.looks())
    };
    let (with, without) = (run(true), run(false));
    assert!(2 * with.1 < without.1, "{} and {} looks", with.1, without.1);
    for (x, y) in with.0.iter().zip(&without.0) {
        let error = |l: &PairClearance| l.measured.map_or(0.0, |m| m - l.proved);
        assert!(error(x) <= error(y).max(1.3e-3) + 1e-6, "{x:?} {y:?}");
        let [m, n] = [x, y].map(|l| l.measured.unwrap_or(ENOUGH_MM));
        assert!((m - n).abs() <= 1.1e-3 || m.min(n) > NEAR_MM, "{x:?} {y:?}");
    }
    assert!(with.0.iter().any(|l| l.measured.is_some_and(|m| (m - 0.2).abs() < 2e-3)));
}
