//! A certificate holds; each forgery is refused.

use serde_json::json;

use super::*;

/// Blocks of 0.1 s; a joint that must go up by 10, down by 10 and up by 10 degrees, limited to 20 deg/s and 100 deg/s2. Half a swing of
/// 10 degrees takes `10/20 + 20/200`, a whole one `10/20 + 20/100`.
fn certificate() -> Value {
    let gates = json!([[-1, 0], [10, 11], [-1, 0], [10, 11], [-30, 30]]);
    let places = json!([0, 10, 0, 10, 10]);
    json!({
        "format": "proveout schedule certificate, version 1",
        "runs": [{
            "feed_part": 1.0, "limit_passed": 0.0, "rounding_deg": 0.0,
            "least_s": [0.1, 0.1, 0.1, 0.1], "feed_bound_s": 0.4,
            "new_s": [0.7, 0.8, 0.7, 0.1], "original_s": [1.0, 1.0, 1.0, 0.2],
            "time_s": 2.3, "original_time_s": 3.2, "new_inside": true, "original_inside": true,
            "joints": [{
                "name": "A", "velocity_deg_s": 20.0, "acceleration_deg_s2": 100.0, "jerk_deg_s3": null,
                "gates_deg": gates, "new_deg": places, "original_deg": places
            }],
            "windows": [
                { "proof": "swings", "joint": "A", "gates": [0, 1, 2, 3], "up": true, "time_s": 0.6 + 0.7 + 0.6 },
                { "proof": "feed", "joint": null, "gates": [3, 4], "up": null, "time_s": 0.1 }
            ],
            "bound_s": 2.0, "gap_percent": 15.0
        }]
    })
}

fn fault(change: impl Fn(&mut Value)) -> String {
    let mut value = certificate();
    change(&mut value["runs"][0]);
    match check(&value) {
        Ok(seen) => panic!("taken: {seen}"),
        Err(Failure(text)) => text,
    }
}

#[test]
fn a_certificate_that_holds_is_taken() {
    let seen = check(&certificate()).unwrap_or_else(|Failure(e)| panic!("{e}"));
    assert!(seen.contains("2.000 s proved by 2 windows"), "{seen}");
}

#[test]
fn each_forgery_is_refused() {
    type Change = fn(&mut Value);
    let forgeries: [(Change, &str); 15] = [
        (|r| r["bound_s"] = json!(2.1), "bound_s is told as"),
        (|r| r["windows"][0]["time_s"] = json!(2.0), "claims 2 s, and proves"),
        (|r| r["windows"][0]["gates"] = json!([0, 1, 3]), "without moving"),
        (|r| r["windows"][0]["gates"] = json!([0, 2, 1, 3]), "do not rise"),
        (|r| r["windows"][0]["up"] = json!(false), "without moving"),
        (|r| r["windows"][0]["joint"] = json!("C"), "not in the certificate"),
        (|r| r["windows"][1]["gates"] = json!([2, 4]), "do not rise from gate 3"),
        (|r| r["windows"] = json!([r["windows"][0]]), "end at gate 3 of 4"),
        (|r| r["joints"][0]["velocity_deg_s"] = json!(30.0), "claims 1.9"),
        (|r| r["joints"][0]["gates_deg"][1] = json!([11, 10]), "is empty"),
        (|r| r["joints"][0]["new_deg"][1] = json!(9), "new_inside is told as true"),
        (|r| r["new_s"][3] = json!(0.05), "takes less than its least time"),
        (|r| r["time_s"] = json!(2.2), "time_s is told as"),
        (|r| r["gap_percent"] = json!(10.0), "gap_percent is told as"),
        (|r| r["least_s"][0] = json!(0.0), "no least time"),
    ];
    for (forgery, told) in forgeries {
        let text = fault(forgery);
        assert!(text.contains(told), "{text:?} does not say {told:?}");
    }
    let mut other = certificate();
    other["format"] = json!("something else");
    assert!(check(&other).is_err());
}

#[test]
fn a_program_that_is_faster_than_the_bound_is_no_schedule_of_it() {
    let text = fault(|r| {
        r["new_s"] = json!([0.5, 0.5, 0.5, 0.1]);
        r["time_s"] = json!(1.6);
        r["gap_percent"] = json!(-20.0);
    });
    assert!(text.contains("faster than the bound"), "{text}");
}

#[test]
fn times_between_turns_meet_closed_forms() {
    let l = Limits { velocity: f64::MAX, acceleration: f64::INFINITY, jerk: 6.0 };
    // D = 2/3 J (T/2)^3.
    assert!((l.turn_to_turn(4.0) - 2.0).abs() < 1e-12);
    let l = Limits { velocity: 3.0, acceleration: 2.0, jerk: f64::INFINITY };
    assert!((l.turn_to_turn(2.0) - 2.0).abs() < 1e-12 && (l.turn_to_turn(9.0) - 4.5).abs() < 1e-12);
    assert!((l.after_turn(1.0) - 1.0).abs() < 1e-12 && (l.after_turn(6.0) - 2.75).abs() < 1e-12);
    let free = Limits { velocity: 4.0, acceleration: f64::INFINITY, jerk: f64::INFINITY };
    assert!((free.turn_to_turn(2.0) - 0.5).abs() < 1e-12 && (free.after_turn(2.0) - 0.5).abs() < 1e-12);
}
