//! A production program of a Spinner U5-620 (doi:10.1038/s41597-025-05294-0, CC-BY-4.0) on the machine of the
//! library. The program is not part of the project; without it these tests say so and pass.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use crate::common;
use std::path::{Path, PathBuf};

use crate::common::{limit_use, tool};
use proveout_controller::{BlockKind, Chunk, Controller, Event, Settings, Summary};
use proveout_machine::Machine;
use proveout_nc::{Op, Program, Settings as NcSettings, ToolAction, ToolName};

const PROGRAM: &str = "shared/cases/spinner-u5-840d/NC_code/Coordinate_system_representation_Achskreuz/\
                       Coordinate_system_representation_Achskreuz.mpf";

fn program() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    [root.join("..").join(PROGRAM), root.join("../..").join(PROGRAM)].into_iter().find(|p| p.is_file())
}

/// Printed past the capture of the test harness: `cargo xtask ci` has these lines in its summary.
fn left_out(what: &str) {
    use std::io::Write as _;
    writeln!(std::io::stdout(), "\nLEFT OUT: {what}").ok();
}

#[test]
fn axis_cross_runs_whole_and_keeps_limits() {
    let Some(path) = program() else {
        left_out("limits along the axis cross: the data set doi:10.1038/s41597-025-05294-0 is not beside the checkout");
        return;
    };
    let machines = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
    let machine = Machine::read(&machines).expect("the machine of the library");
    // Tools by the names of the program, with gauge lengths of usual assemblies.
    let open = || Program::open(&path, &NcSettings::default()).expect("a readable program");
    let mut names: Vec<String> = Vec::new();
    for command in open() {
        if let Op::Tool(ToolAction::Change(ToolName::Name(name))) = command.expect("no fault").op
            && !names.contains(&name)
        {
            names.push(name);
        }
    }
    assert_eq!(names.len(), 4);
    let tools: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(k, name)| proveout_tool::Tool { name: name.clone(), ..tool(k as u32 + 1, 120.0 + 10.0 * k as f64) })
        .collect();
    let mut controller = Controller::new(open(), &machine, &tools, Settings::default()).expect("good settings");
    let mut all = Chunk::default();
    let started = std::time::Instant::now();
    while let Some(chunk) = controller.next_chunk().expect("no refusal") {
        all.pieces.extend(chunk.pieces);
        all.samples.extend(chunk.samples);
        all.events.extend(chunk.events);
        all.blocks.extend(chunk.blocks);
    }
    let summary = controller.summary();
    println!("planned in {:.3} s of this computer (test profile)", started.elapsed().as_secs_f64());
    println!("{} pieces, {} samples, {} blocks", all.pieces.len(), all.samples.len(), all.blocks.len());
    report(&summary);
    let run = common::Run { all, chunks: 0, summary };
    let worst = limit_use(&run, &machine, machine.control.cycle_time);
    println!("{worst:?}");
    for value in [worst.velocity, worst.acceleration, worst.jerk].into_iter().chain(worst.differences) {
        assert!(value <= 1.001, "{worst:?}");
    }
    let s = &run.summary;
    assert!(s.lower_bound_s.is_some_and(|b| b <= s.total_s));
    assert!(s.max_contour_error_mm <= 0.02 + 1e-12); // CYCLE832(0.02,1)
    let changes = run.all.blocks.iter().filter(|b| b.kind == BlockKind::ToolChange).count();
    assert_eq!(changes, 5); // one of the four tools comes twice
    assert!(matches!(run.all.events.last(), Some(Event::End { .. })));
}

fn report(s: &Summary) {
    println!(
        "total {:.3} s = feed {:.3} + rapid {:.3} + dwell {:.3} + tool change {:.3}; bound {:?}",
        s.total_s, s.cutting_s, s.rapid_s, s.dwell_s, s.tool_change_s, s.lower_bound_s
    );
    println!(
        "chord {:.6} mm, contour {:.6} mm, least feed {:?}",
        s.max_chord_error_mm, s.max_contour_error_mm, s.min_feed_ratio
    );
}
