//! Cost of one piece of motion: a finishing pass of 0.02 mm pieces, all five joints moving, over a vise on
//! the table of a shipped machine, with a tool of a shipped library; and a table that turns sixty times under
//! it. Proved pose checks a second are pieces of which all pairs are proved to keep their clearance, by
//! processor time of one thread.
#![allow(missing_docs, clippy::print_stdout, reason = "the macros make items without documentation; a bench prints")]

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use proveout_collision::{Fixture, Interference};
use proveout_geom::{Aabb, Point, box_mesh, cylinder_mesh};
use proveout_machine::{JointValues, Machine};
use proveout_tool::{ToolId, ToolLibrary};

const PIECES: usize = 20_000;

/// Processor time of this thread so far, s.
fn processor_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|t| t.parse::<f64>().ok()).map_or(f64::NAN, |ns| ns * 1e-9)
}

/// The table turns, the tip stays 12 mm above a post on it.
fn turning() -> (Interference, Vec<JointValues>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let machine = Machine::read(&root.join("machines/bc-trunnion")).unwrap_or_else(|e| panic!("{e}"));
    let tools = ToolLibrary::read(&root.join("tools/axis-cross.toml")).unwrap_or_else(|e| panic!("{e}"));
    let tool = tools.find(&ToolId::Name("SCHAFT_D12_N_AP30".into())).expect("tool");
    let post = Fixture { name: "post".into(), mesh: cylinder_mesh(15.0, 0.0, 100.0, 48), on_table: true };
    let mut check = Interference::new(&machine, &[post], 0.5).expect("solids");
    check.set_tool(Some(tool));
    let (b, c) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    let at = |k: usize| {
        let turn = std::f64::consts::TAU * k as f64 / 333.0;
        let mut rotary = JointValues::ZERO;
        (rotary[b], rotary[c]) = (0.2 + 0.1 * (turn / 7.0).sin(), turn);
        machine.inverse_with_rotary(&Point::new(5.0 * turn.cos(), 5.0 * turn.sin(), 112.0), &rotary, tool.gauge_length)
    };
    (check, (0..=PIECES).map(at).collect())
}

fn setup() -> (Interference, Vec<JointValues>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let machine = Machine::read(&root.join("machines/spinner-u5-620")).unwrap_or_else(|e| panic!("{e}"));
    let tools = ToolLibrary::read(&root.join("tools/axis-cross.toml")).unwrap_or_else(|e| panic!("{e}"));
    let tool = tools.find(&ToolId::Name("SCHAFT_D12_N_AP30".into())).expect("tool");
    let b = |min: [f64; 3], max: [f64; 3]| box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) });
    let fixture = |name: &str, mesh| Fixture { name: name.into(), mesh, on_table: true };
    let fixtures = [
        fixture("vise", b([-60.0, -60.0, 0.0], [60.0, 60.0, 80.0])),
        fixture("jaw", b([-60.0, 30.0, 80.0], [60.0, 60.0, 100.0])),
        fixture("stop", cylinder_mesh(8.0, 0.0, 110.0, 64)),
    ];
    let mut check = Interference::new(&machine, &fixtures, 0.5).expect("solids");
    check.set_tool(Some(tool));
    let (b_joint, c_joint) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    let way = (0..=PIECES)
        .map(|k| {
            let s = 0.02 * k as f64;
            let tip = Point::new(25.0 * (s / 25.0).cos(), 25.0 * (s / 25.0).sin() - 20.0, 130.0);
            let mut rotary = JointValues::ZERO;
            (rotary[b_joint], rotary[c_joint]) = (0.3 + 0.1 * (s / 40.0).sin(), s / 100.0);
            machine.inverse_with_rotary(&tip, &rotary, tool.gauge_length)
        })
        .collect();
    (check, way)
}

fn pieces(c: &mut Criterion) {
    let (start, way) = setup();
    let mut group = c.benchmark_group("interference");
    group.sample_size(10);
    group.throughput(criterion::Throughput::Elements(PIECES as u64));
    group.bench_function("finishing pass", |bench| {
        bench.iter(|| {
            let mut check = start.clone();
            for (k, w) in way.windows(2).enumerate() {
                check.check_piece(&w[0], &w[1], [k as f64, k as f64 + 1.0], 5e-4);
            }
            black_box((check.queries(), check.breaches().len(), check.clearance()))
        });
    });
    group.finish();
    for (name, (mut check, way)) in [("finishing pass", setup()), ("turning table", turning())] {
        let begin = processor_s();
        for (k, w) in way.windows(2).enumerate() {
            check.check_piece(&w[0], &w[1], [k as f64, k as f64 + 1.0], 5e-4);
        }
        let rate = check.pieces() as f64 / (processor_s() - begin);
        println!("{name}: {rate:.0} proved pose checks a second of the processor");
        println!("  {} pieces, {} queries, {} pairs", check.pieces(), check.queries(), check.pairs().len());
        let effort = check.effort();
        println!("  {effort:?}");
        println!("  {:.2} percent of the pieces by one comparison", 100.0 * effort.share_by_allowance());
        println!("  {:?}", check.clearance());
        assert!(check.breaches().is_empty(), "{:?}", check.breaches());
        assert!(check.queries() < PIECES as u64 / 4, "{} queries", check.queries());
    }
}

criterion_group!(benches, pieces);
criterion_main!(benches);
