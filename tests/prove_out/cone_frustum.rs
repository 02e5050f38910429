//! The tilted cone frustum on two machines: the flank against its closed form.

use proveout_sim::{Choice, scene::Dynamics, verdict::State};
use proveout_tests::{prove, scene};

/// Distance of the rays, mm. Points of the cut surface are exact whatever it is.
const CELL_MM: f64 = 1.0;
/// Bound on the flank cut by the programmed path itself: 1 micrometer between blocks (the generator's own
/// bound on the finishing passes) and 1 micrometer of the swept volume.
const IDEAL_MM: f64 = 0.002;
/// The finishing passes allow corners to be rounded by this much (`CYCLE832` in the program).
const PATH_TOLERANCE_MM: f64 = 0.005;

fn choice(program: &str, dynamics: Dynamics) -> Choice {
    Choice {
        program: Some(program.into()),
        resolution_mm: Some(CELL_MM),
        dynamics: Some(dynamics),
        ..Choice::default()
    }
}

#[test]
fn the_programmed_path_cuts_the_cone_of_the_drawing() {
    for program in ["bc", "ac"] {
        let run = prove(&scene("cone-frustum"), &choice(program, Dynamics::Ideal), 2).expect("runs");
        let d = &run.verdict.deviation;
        let (gouge, excess) = (d.gouge_max_mm.expect("measured"), d.excess_max_mm.expect("measured"));
        assert!(d.samples.expect("measured") > 2000, "{program}: {d:?}");
        assert!(gouge <= IDEAL_MM && excess <= IDEAL_MM, "{program}: gouge {gouge} mm, excess {excess} mm");
    }
}

#[test]
fn rounded_corners_stay_within_the_path_tolerance() {
    let run = prove(&scene("cone-frustum"), &choice("bc", Dynamics::Planned), 2).expect("runs");
    let d = &run.verdict.deviation;
    let bound = IDEAL_MM + PATH_TOLERANCE_MM;
    assert!(d.gouge_max_mm.expect("measured") <= bound, "{d:?}");
    assert!(d.excess_max_mm.expect("measured") <= bound, "{d:?}");
    let failed: Vec<_> = run.verdict.gates.iter().filter(|g| g.state == State::Fail).collect();
    assert!(failed.is_empty(), "{failed:?}\n{:#?}", run.verdict.findings);
    assert!(run.verdict.time.lower_bound_s.expect("bounded") <= run.verdict.time.total_s);
}

/// The drives of the library machine follow with full feed-forward: what they leave is friction at the
/// reversals, elasticity and the load of the swivel, some micrometers on the part.
#[test]
fn the_drives_leave_their_marks_and_the_time_as_it_is() {
    let planned = prove(&scene("cone-frustum"), &choice("bc", Dynamics::Planned), 2).expect("runs").verdict;
    let servo = prove(&scene("cone-frustum"), &choice("bc", Dynamics::Servo), 2).expect("runs").verdict;
    assert_eq!(servo.time, planned.time);
    assert!(planned.axes.values().all(|a| a.max_following_error.is_none() && a.drive_energy_j.is_none()));
    for (name, axis) in &servo.axes {
        let following = axis.max_following_error.expect("drives");
        assert!(following > 1e-6 && following < 0.05, "{name}: {following}");
        assert!(axis.drive_utilisation.is_some_and(|u| u > 0.0 && u < 1.0), "{name}: {axis:?}");
        assert!(axis.drive_energy_j.is_some_and(|e| e > 0.0));
    }
    let contour = |v: &proveout_sim::verdict::Verdict| v.path.max_contour_error_mm.expect("a path");
    assert!(contour(&servo) > contour(&planned));
    let error = |v: &proveout_sim::verdict::Verdict| v.deviation.rms_mm.expect("measured");
    assert!(error(&servo) > error(&planned), "{} {}", error(&servo), error(&planned));
    // Never more than what the joints are off: the contour error bounds the part.
    let worst = servo.deviation.gouge_max_mm.expect("measured").max(servo.deviation.excess_max_mm.expect("measured"));
    assert!(worst < IDEAL_MM + contour(&servo) + 0.02, "{worst} {}", contour(&servo));
    let limits = servo.gates.iter().find(|g| g.gate.name() == "limits").expect("the gate");
    assert!(limits.state == State::Pass && limits.reason.contains("force of every drive"), "{}", limits.reason);
}

#[test]
fn the_verdict_has_the_same_bytes_at_any_thread_count() {
    let bytes = |threads| {
        let run = prove(&scene("cone-frustum"), &choice("bc", Dynamics::Planned), threads).expect("runs");
        serde_json::to_string_pretty(&run.verdict).expect("a verdict is JSON")
    };
    assert_eq!(bytes(1), bytes(2));
}
