//! The written machine file: values, sources, everything else byte for byte.

use std::path::Path;

use proveout_calibrate::{Parameter, WordTimes, calibrate, calibrated_machine};
use proveout_machine::Machine;
use proveout_nc::Program;

use crate::plant::{Axis, Random, Recorder, air_text, machine, machine_text, record, table, trace};

#[test]
fn what_is_found_is_in_the_file_with_its_error_and_the_rest_stays() {
    let mut r = Random::new(11);
    let axes = [(); 3].map(|()| Axis::random(&mut r));
    let guess_text = machine_text(&[0, 1, 2].map(|k: usize| axes[k].guessed(&mut r)));
    let (truth, guess) = (machine(&machine_text(&axes)), machine(&guess_text));
    let program = air_text(&truth);
    let recorder = Recorder { every: 2, noise: 1e-3, rounding: 0.0, force_noise: 0.01 };
    let csv = table(&record(&truth, &program), recorder, 5);
    let mut words = WordTimes::new(program.lines().count() as u32);
    for command in
        Program::from_text("air.mpf", program.as_str(), &proveout_nc::Settings::default()).expect("a program")
    {
        words.add(&command.expect("a command"));
    }
    let found = calibrate(&guess, &[trace(&csv, &guess)], Some(&words)).unwrap_or_else(|e| panic!("{e}"));
    let text =
        calibrated_machine(Path::new("plant/machine.toml"), &guess_text, &found).unwrap_or_else(|e| panic!("{e}"));
    let after = Machine::from_text(Path::new("plant/machine.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
    for (k, axis) in axes.iter().enumerate() {
        let joint = &after.joints[k];
        let near = |found: Option<f64>, truth: f64, part: f64| {
            assert!(found.is_some_and(|v| (v / truth - 1.0).abs() < part), "{} {found:?} {truth}", joint.name);
        };
        near(joint.rapid_velocity, axis.velocity / 60.0, 0.005);
        near(joint.max_velocity, axis.velocity / 60.0, 0.005);
        near(joint.max_acceleration, axis.acceleration, 0.005);
        near(joint.max_jerk, axis.jerk, 0.03);
        let own = |p: &&Parameter| p.joint.as_ref() == Some(&joint.name) && p.key == "position_gain_1_s";
        let gain = found.parameters.iter().find(own).expect("a gain");
        let stays = guess.joints[k].drive.as_ref().map_or(0.0, |d| d.position_gain);
        let (aim, error) = if gain.written { (axis.gain, gain.standard_error) } else { (stays, None) };
        near(joint.drive.as_ref().map(|d| d.position_gain), aim, 0.01_f64.max(4.0 * error.unwrap_or(0.0) / aim));
        near(joint.drive.as_ref().map(|d| d.coulomb_friction), axis.coulomb, 0.03);
        let key = format!("joint.{}.max_jerk_mm_s3", joint.name);
        let trust: Vec<_> = after.trust.iter().filter(|t| t.key == key).collect();
        assert!(trust.len() == 1 && !trust[0].chosen, "{trust:?}");
        assert!(
            trust[0].note.contains("fitted to air.csv (sha256 ") && trust[0].note.contains("standard error"),
            "{trust:?}"
        );
    }
    // Comments stay, and no line but those of the values and notes changes.
    assert!(text.contains("# a guess") && text.contains("name = \"plant\"\n"));
    let kept = guess_text.lines().filter(|l| text.lines().any(|t| t == *l)).count();
    assert!(kept * 2 > guess_text.lines().count(), "{kept}");
    // Dwells take what is programmed: the twin adds nothing to them.
    let dwell = found.word_times.iter().find(|t| t.word == "dwell").expect("dwells");
    assert!(dwell.count > 50 && dwell.mean_s.abs() < 4.0 * recorder.every as f64 * 1e-3, "{dwell:?}");

    // A trace of a longer program than the one that is named.
    let short = WordTimes::new(3);
    let error = calibrate(&guess, &[trace(&csv, &guess)], Some(&short)).expect_err("another program");
    assert!(error.message.contains("and the program has 3 lines"), "{error}");
    let error = calibrated_machine(Path::new("m.toml"), "name = \"other\"\n", &found).expect_err("another file");
    assert!(error.message.contains("there is no table for"), "{error}");
}
