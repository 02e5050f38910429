//! Limits of a state of motion: each kind alone, with value and limit, and none when all are kept.

use crate::kinematics::{branches::bc, hybrid::machine_2};
use proveout_geom::rad;
use proveout_machine::{JointValues, LimitKind, Limited, MotionState};

const KEYS: &str =
    "travel_deg = [-10, 105]\nmax_velocity_deg_s = 100\nmax_acceleration_deg_s2 = 500\nmax_jerk_deg_s3 = 10_000";

#[test]
fn each_limit_is_named_with_value_and_limit() {
    let machine = bc(KEYS, "");
    let b = machine.joint("B").expect("B");
    let set = |value: f64| {
        let mut v = JointValues::ZERO;
        v[b] = rad(value);
        v
    };
    let within = MotionState { q: set(105.0), velocity: set(-100.0), acceleration: set(500.0), jerk: set(-10_000.0) };
    assert_eq!(machine.limit_violations(&within, 0.0), []);
    let cases = [
        (MotionState { q: set(-11.0), ..within }, LimitKind::Travel, -11.0, -10.0),
        (MotionState { velocity: set(-100.2), ..within }, LimitKind::Velocity, -100.2, 100.0),
        (MotionState { acceleration: set(501.0), ..within }, LimitKind::Acceleration, 501.0, 500.0),
        (MotionState { jerk: set(10_020.0), ..within }, LimitKind::Jerk, 10_020.0, 10_000.0),
    ];
    for (state, kind, value, limit) in cases {
        let all = machine.limit_violations(&state, 0.001);
        assert_eq!(all.len(), 1, "{all:?}");
        let v = &all[0];
        assert_eq!((v.limited, v.kind, v.name.as_str(), v.rotary), (Limited::Joint(b), kind, "B", true));
        assert!((v.value - rad(value)).abs() < 1e-12 && (v.limit - rad(limit)).abs() < 1e-12, "{v:?}");
        assert!(v.to_string().contains("B: ") && v.to_string().contains("deg"), "{v}");
    }
    // The part that may be passed, and values that are no numbers.
    let slightly = MotionState { velocity: set(100.05), ..within };
    assert_eq!(machine.limit_violations(&slightly, 0.001), []);
    assert_eq!(machine.limit_violations(&slightly, 0.0).len(), 1);
    let nan = MotionState { q: set(f64::NAN), velocity: set(f64::NAN), ..MotionState::default() };
    let kinds: Vec<LimitKind> = machine.limit_violations(&nan, 0.1).iter().map(|v| v.kind).collect();
    assert_eq!(kinds, [LimitKind::Travel, LimitKind::Velocity]);
}

#[test]
fn amplification_is_reported_above_its_limit() {
    let machine = bc("", "");
    let mut q = JointValues::ZERO;
    q[3] = rad(3.0);
    let found = machine.amplification_violation(&q, 10.0).expect("1 / sin 3 degrees is 19");
    assert!((found.value - 1.0 / rad(3.0).sin()).abs() < 1e-9 && found.limited == Limited::RotaryJoints);
    assert!(found.to_string().contains("B and C") || found.to_string().contains("C and B"), "{found}");
    assert_eq!(machine.amplification_violation(&q, 20.0), None);
    q[3] = 0.0;
    assert_eq!(machine.amplification_violation(&q, 1e9).expect("singular").value, f64::INFINITY);
    assert!(
        (machine.cone_angle(&proveout_geom::Vector::new(0.6, 0.0, 0.8)).expect("two") - 0.6_f64.asin()).abs() < 1e-15
    );
}

#[test]
fn legs_have_limits_of_their_own() {
    let machine = machine_2();
    let mut q = JointValues::ZERO;
    // Lowered by 100 mm the legs are sqrt(70² + 300²) = 308 mm long, and 350 is the shortest.
    q[2] = -100.0;
    let all = machine.limit_violations(&MotionState { q, ..MotionState::default() }, 0.0);
    assert_eq!(all.len(), 3, "{all:?}");
    assert_eq!(all[0].limited, Limited::Leg { platform: 0, leg: 0 });
    assert!((all[0].value - 70.0_f64.hypot(300.0)).abs() < 1e-12 && all[0].limit == 350.0);
    // Straight up at 150 mm/s the legs follow with the sine of their slope: 148 mm/s, and 100 are allowed.
    let mut velocity = JointValues::ZERO;
    velocity[2] = 150.0;
    let all = machine.limit_violations(&MotionState { velocity, ..MotionState::default() }, 0.0);
    assert_eq!(all.len(), 3, "{all:?}");
    let rate = all.iter().find(|v| v.kind == LimitKind::Velocity).expect("rate");
    assert!((rate.value - 150.0 * 400.0 / 70.0_f64.hypot(400.0)).abs() < 1e-9 && rate.limit == 100.0, "{rate}");
}
