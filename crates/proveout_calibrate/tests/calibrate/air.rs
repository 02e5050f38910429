//! Air programs of the library: within travel, under ten minutes, each joint alone, in four languages.

use std::path::Path;

use proveout_calibrate::AirProgram;
use proveout_controller::{BlockKind, Controller, Event, Settings};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Program};

use crate::plant::{Axis, Random, machine, machine_text};

/// Ranges of joints by name.
type Ranges = Vec<(String, [f64; 2])>;

/// Machines of the library, each with the range of its joint along the spindle: all of its travel.
fn library() -> Vec<(String, Machine, Ranges)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).expect("machines/") {
        let path = entry.expect("an entry").path();
        if !path.is_dir() {
            continue;
        }
        let machine = Machine::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let spindle = machine.spindle.gauge_pose.vector(&nalgebra::Vector3::z());
        let ranges = machine
            .joints
            .iter()
            .filter(|j| !j.is_rotary() && j.direction.dot(&spindle).abs() > 0.99)
            .filter_map(|j| Some((j.name.clone(), j.travel?)))
            .collect();
        all.push((path.file_name().expect("a name").to_string_lossy().into_owned(), machine, ranges));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

#[test]
fn every_machine_of_the_library_has_one_in_every_language() {
    let languages = [
        (Dialect::Siemens840d, "air.mpf"),
        (Dialect::Heidenhain, "air.h"),
        (Dialect::Fanuc, "air.nc"),
        (Dialect::Haas, "air.nc"),
        (Dialect::LinuxCnc, "air.ngc"),
    ];
    let mut seen = 0;
    for (name, machine, ranges) in library() {
        let plan = AirProgram::new(&machine, &ranges).unwrap_or_else(|e| panic!("{name}: {e:?}"));
        for (dialect, file) in languages {
            let (text, _) = plan.text(&machine, dialect).unwrap_or_else(|e| panic!("{name}: {e:?}"));
            let settings = proveout_nc::Settings { dialect, ..proveout_nc::Settings::default() };
            let program = Program::from_text(file, text.as_str(), &settings).unwrap_or_else(|e| panic!("{name}: {e}"));
            let settings = Settings { sample_time: Some(0.01), ..Settings::default() };
            let mut control =
                Controller::new(program, &machine, &[], settings).unwrap_or_else(|e| panic!("{name}: {e}"));
            let mut moves = 0;
            while let Some(chunk) = control.next_chunk().unwrap_or_else(|e| panic!("{name} {dialect:?}: {e}")) {
                for event in &chunk.events {
                    let fine = !matches!(event, Event::Limit { .. } | Event::UnreachablePose { .. });
                    assert!(fine, "{name} {dialect:?}: {event:?}");
                }
                moves += chunk.blocks.iter().filter(|b| matches!(b.kind, BlockKind::Move(_))).count();
            }
            let total = control.summary().total_s;
            assert!(total < 600.0, "{name} {dialect:?}: {total} s");
            // Six lengths and eight feeds, there and back, of each joint that moves.
            let joints = plan.order.len();
            let least = if dialect == Dialect::Haas { 12 } else { 28 } * joints;
            assert!(moves >= least, "{name} {dialect:?}: {moves} moves of {joints} joints");
            seen += 1;
        }
    }
    assert!(seen >= 100, "{seen}");
}

#[test]
fn ranges_are_asked_for_and_checked() {
    let mut r = Random::new(2);
    let plant = machine(&machine_text(&[(); 3].map(|()| Axis::random(&mut r))));
    let with = |ranges: &[(&str, [f64; 2])]| {
        let ranges: Vec<(String, [f64; 2])> = ranges.iter().map(|(n, r)| ((*n).to_owned(), *r)).collect();
        AirProgram::new(&plant, &ranges)
    };
    for (ranges, message) in [
        (vec![], "nothing says how far Z may go"),
        (vec![("W", [0.0, 1.0])], "plant has no joint \"W\""),
        (vec![("Z", [0.0, 100.0]), ("Z", [0.0, 50.0])], "joint Z has two ranges"),
        (vec![("Z", [100.0, 0.0])], "the range of Z, 100 to 0, is upside down"),
        (vec![("Z", [0.0, 500.0])], "leaves its travel, 0 to 400 mm"),
        (vec![("Z", [100.0, 200.0])], "home of Z, 0 mm, is outside of its range"),
        (vec![("Z", [0.0, 0.5])], "too short for six lengths"),
    ] {
        let error = with(&ranges).expect_err(message);
        assert!(error.message.contains(message) && !error.help.is_empty(), "{error:?}");
    }
    let plan = with(&[("Z", [0.0, 120.0])]).expect("a plan");
    let z = plant.joint("Z").expect("Z");
    assert!(plan.steps.iter().filter(|s| s.joint == z).all(|s| (0.0..=120.0).contains(&s.to)));
    assert!(plan.text(&plant, Dialect::Apt).is_err());
}
