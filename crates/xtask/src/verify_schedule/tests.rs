//! A certificate holds; each forgery is refused.

use serde_json::json;

use super::*;

/// Blocks of 0.1 s; a joint that must go up by 10, down by 10 and up by 10 degrees, limited to 20 deg/s and
/// 100 deg/s2. Half a swing of 10 degrees takes `10/20 + 20/200`, a whole one `10/20 + 20/100`.
fn certificate() -> Value {
    let gates = json!([[-1, 0], [10, 11], [-1, 0], [10, 11], [-30, 30]]);
    let places = json!([0, 10, 0, 10, 10]);
    json!({
        "format": "proveout schedule certificate, version 2",
        "runs": [{
            "feed_passed": 0.0, "off_mm": 0.0, "limit_passed": 0.0, "rounding_deg": 0.0,
            "ways": [{
                "program": "new", "times_s": [0.1, 0.1, 0.1, 0.1],
                "points_mm": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0], [3, 1, 1]]
            }],
            "nominal_s": [0.1, 0.1, 0.1, 0.1], "linear": [], "cells": null, "constant_feed": [],
            "least_s": [0.1, 0.1, 0.1, 0.1], "seams_s": [0, 0, 0, 0, 0], "feed_bound_s": 0.4,
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
            "bound_s": 2.0, "gap_percent": 15.0,
            "ramps_apart": {
                "ramp_s": 0.1, "gates": [1, 3], "time_s": 1.5, "bound_s": 1.2, "gap_percent": 25.0,
                "windows": [{ "proof": "swings", "joint": "A", "gates": [1, 2, 3], "up": false, "time_s": 0.6 + 0.6 }]
            }
        }]
    })
}

fn fault(change: impl Fn(&mut Value)) -> String {
    let mut value = certificate();
    change(&mut value["runs"][0]);
    match check(&value) {
        Ok(seen) => panic!("taken: {seen}"),
        Err(TaskError(text)) => text,
    }
}

#[test]
fn a_certificate_that_holds_is_taken() {
    let seen = check(&certificate()).unwrap_or_else(|TaskError(e)| panic!("{e}"));
    assert!(seen.contains("2.000 s proved by 2 windows"), "{seen}");
}

#[test]
fn each_forgery_is_refused() {
    type Change = fn(&mut Value);
    let forgeries: [(Change, &str); 26] = [
        (|r| r["bound_s"] = json!(2.1), "bound_s: stated"),
        (|r| r["windows"][0]["time_s"] = json!(2.0), "claims 2 s, but proves"),
        (|r| r["windows"][0]["gates"] = json!([0, 1, 3]), "without moving"),
        (|r| r["windows"][0]["gates"] = json!([0, 2, 1, 3]), "do not increase"),
        (|r| r["windows"][0]["up"] = json!(false), "without moving"),
        (|r| r["windows"][0]["joint"] = json!("C"), "not in the certificate"),
        (|r| r["windows"][1]["gates"] = json!([2, 4]), "do not increase from gate 3"),
        (|r| r["windows"] = json!([r["windows"][0]]), "end at gate 3 of 4"),
        (|r| r["joints"][0]["velocity_deg_s"] = json!(30.0), "claims 1.9"),
        (|r| r["joints"][0]["gates_deg"][1] = json!([11, 10]), "is empty"),
        (|r| r["joints"][0]["new_deg"][1] = json!(9), "new_inside is stated as true"),
        (|r| r["new_s"][3] = json!(0.05), "blocks 3 to 3 take less time in the new program"),
        (|r| r["off_mm"] = json!(0.01), "claims more feed time than the new path proves"),
        (|r| r["ways"][0]["times_s"][1] = json!(0.09), "claims more feed time than the new path proves"),
        (|r| r["ways"] = json!([]), "no path given to prove the feed from"),
        (|r| r["seams_s"][2] = json!(-0.1), "seams_s needs"),
        (|r| r["time_s"] = json!(2.2), "time_s: stated"),
        (|r| r["gap_percent"] = json!(10.0), "gap_percent: stated"),
        (|r| r["least_s"][0] = json!(0.0), "no least time"),
        (|r| r["ramps_apart"]["bound_s"] = json!(1.3), "ramps_apart: bound_s: stated"),
        (|r| r["ramps_apart"]["time_s"] = json!(1.4), "ramps_apart: time_s: stated"),
        (|r| r["ramps_apart"]["gap_percent"] = json!(24.0), "ramps_apart: gap_percent: stated"),
        (|r| r["ramps_apart"]["ramp_s"] = json!(0.2), "the last ramp is shorter"),
        (|r| r["ramps_apart"]["gates"] = json!([1, 9]), "are not two gates of the stretch"),
        (|r| r["ramps_apart"]["windows"][0]["time_s"] = json!(1.3), "claims 1.3 s, but proves"),
        (|r| r["ramps_apart"]["windows"][0]["gates"] = json!([2, 3]), "do not increase from gate 1"),
    ];
    for (forgery, expected) in forgeries {
        let text = fault(forgery);
        assert!(text.contains(expected), "{text:?} does not say {expected:?}");
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
    let l = PeakLimits { velocity: f64::MAX, acceleration: f64::INFINITY, jerk: 6.0 };
    // D = 2/3 J (T/2)^3.
    assert!((l.turn_to_turn(4.0) - 2.0).abs() < 1e-12);
    let l = PeakLimits { velocity: 3.0, acceleration: 2.0, jerk: f64::INFINITY };
    assert!((l.turn_to_turn(2.0) - 2.0).abs() < 1e-12 && (l.turn_to_turn(9.0) - 4.5).abs() < 1e-12);
    assert!((l.after_turn(1.0) - 1.0).abs() < 1e-12 && (l.after_turn(6.0) - 2.75).abs() < 1e-12);
    let free = PeakLimits { velocity: 4.0, acceleration: f64::INFINITY, jerk: f64::INFINITY };
    assert!((free.turn_to_turn(2.0) - 0.5).abs() < 1e-12 && (free.after_turn(2.0) - 0.5).abs() < 1e-12);
}

/// Corners of 1 mm blocks at 10 mm/s whose ends are 0.01 mm off: a right angle costs `0.01 sqrt(2) / 10` s,
/// an end 0.001 s.
#[test]
fn corners_and_ends_cost_what_they_may_be_cut_short() {
    let corner = 0.001 * 2.0_f64.sqrt();
    let least = |cost: f64| {
        // Three corners: the two outer blocks have half of one, the inner ones half of two.
        let mut value = certificate();
        let run = &mut value["runs"][0];
        run["off_mm"] = json!(0.01);
        run["ways"][0]["points_mm"][4] = json!([2, 2, 0]);
        run["least_s"] = json!([0.1 - 0.5 * cost, 0.1 - cost, 0.1 - cost, 0.1 - 0.5 * cost]);
        run["seams_s"] = json!([0.001, 0.001 - 0.5 * cost, 0.001 - 0.5 * cost, 0.001 - 0.5 * cost, 0.001]);
        run["feed_bound_s"] = json!(0.4 - 3.0 * cost - 0.002);
        run["windows"][1]["time_s"] = json!(0.1 - 0.5 * cost - 0.002 + 0.5 * cost);
        let bound = 1.9 + 0.1 - 0.002;
        run["bound_s"] = json!(bound);
        run["gap_percent"] = json!(100.0 * (2.3 / bound - 1.0));
        check(&value)
    };
    assert!(least(corner).is_ok(), "{}", least(corner).err().map_or(String::new(), |TaskError(e)| e));
    let Err(TaskError(text)) = least(0.99 * corner) else { panic!("taken") };
    assert!(text.contains("claims more feed time than the new path proves"), "{text}");
}

/// Two stations whose axes point to X and to -X, with cells of 10 degrees about Y (inner) and Z (outer).
fn cells() -> Value {
    let (rows, columns, size) = (6_usize, 36_usize, 10.0_f64);
    let radius = 3.0_f64;
    let middle = |j: usize, k: usize| [60.0 + size * (j as f64 + 0.5), size * (k as f64 + 0.5)];
    let reaches = |j: usize, k: usize, side: f64| {
        let [p, q] = middle(j, k).map(f64::to_radians);
        (side * p.sin() * q.cos()).acos().to_degrees() <= radius + 0.5 * size * (1.0 + p.sin())
    };
    let of = |side: f64| -> Vec<usize> {
        (0..rows * columns).filter(|id| reaches(id / columns, id % columns, side)).collect()
    };
    let [first, second] = [1.0, -1.0].map(of);
    // The joint about Z has 36 degrees a second, and a cell for nothing.
    let way = |a: usize, b: usize| {
        let [j, k] = [(a / columns).abs_diff(b / columns), (a % columns).abs_diff(b % columns)];
        let turn = k.min(columns - k);
        (j.saturating_sub(1) as f64 * size / 90.0).max(turn.saturating_sub(1) as f64 * size / 36.0).max(0.398)
    };
    let potentials: Vec<f64> =
        second.iter().map(|b| first.iter().map(|a| way(*a, *b)).fold(f64::INFINITY, f64::min)).collect();
    let bound = potentials.iter().copied().fold(f64::INFINITY, f64::min);
    let joint = |name: &str, direction: [f64; 3], velocity: f64, count: usize, from: f64, places: [f64; 2]| {
        json!({
            "name": name, "direction": direction, "velocity_deg_s": velocity, "cells": count, "size_deg": size,
            "from_deg": from, "new_deg": places, "original_deg": places
        })
    };
    json!({
        "inner": joint("B", [0.0, 1.0, 0.0], 90.0, rows, 60.0, [90.0, 90.0]),
        "outer": joint("C", [0.0, 0.0, 1.0], 36.0, columns, 0.0, [1.0, 181.0]),
        "zero": [0, 0, 1], "stray_deg": 3.0, "radius_deg": radius, "stations": [0, 4],
        "axes": [[1, 0, 0], [-1, 0, 0]], "cells": [first, second],
        "potentials_s": [vec![0.0; first.len()], potentials], "bound_s": bound, "reached_s": null
    })
}

#[test]
fn potentials_of_cells_are_checked_edge_by_edge() {
    let proved = |change: &dyn Fn(&mut Value)| {
        let mut value = cells();
        change(&mut value);
        cells::check(&value, 0.0, |_, _| 0.398, 4).map_err(|TaskError(e)| e)
    };
    let bound = proved(&|_| {}).unwrap_or_else(|e| panic!("{e}"));
    // Half a turn less what caps and cells leave: 180 degrees less two cells' reach on either side, and one
    // for nothing.
    assert!((bound - 140.0 / 36.0).abs() < 1.0, "{bound}");
    type Change = fn(&mut Value);
    let forgeries: [(Change, &str); 8] = [
        (|c| c["potentials_s"][1][0] = json!(9.0), "exceeds that of an earlier cell"),
        (|c| c["potentials_s"][0][2] = json!(0.5), "first station is above zero"),
        (|c| c["bound_s"] = json!(9.0), "above the least potential"),
        (|c| c["radius_deg"] = json!(30.0), "is missing"),
        (|c| c["axes"][1] = json!([0, -1, 0]), "is missing"),
        (|c| c["stations"] = json!([0, 3]), "do not increase from the first gate to the last"),
        (|c| c["outer"]["new_deg"][1] = json!(90.0), "the new program is in no cell of station 1"),
        (|c| c["outer"]["velocity_deg_s"] = json!(72.0), "exceeds that of an earlier cell"),
    ];
    for (forgery, expected) in forgeries {
        let text = proved(&forgery).expect_err("taken");
        assert!(text.contains(expected), "{text:?} does not say {expected:?}");
    }
}

/// A joint that goes up by one degree and down again in two steps of 0.1 s: the second difference of the
/// three places is -2 / 0.01 at least.
#[test]
fn weights_of_a_least_peak_are_counted_again() {
    let run = || {
        json!({
            "rounding_deg": 0.5, "nominal_s": [0.1, 0.1, 0.1], "limit_passed": 0.0,
            "joints": [{ "name": "A", "velocity_deg_s": 50.0, "gates_deg": [[-2.5, 0.5], [0.5, 2.5], [-2.5, 0.5], [-9.5, 9.5]] }]
        })
    };
    let peak = || {
        json!({
            "joint": "A", "order": 2, "velocity_deg_s": [-50, 50], "proved_deg": 200.0, "weights": [-1.0, 0.0], "pushes": [0, 0, 0]
        })
    };
    let fault_after = |change: &dyn Fn(&mut Value)| {
        let mut own = peak();
        change(&mut own);
        peak::check(&run(), &own).map_err(|TaskError(e)| e)
    };
    fault_after(&|_| {}).unwrap_or_else(|e| panic!("{e}"));
    type Change = fn(&mut Value);
    let forgeries: [(Change, &str); 7] = [
        (|p| p["proved_deg"] = json!(201.0), "claims 201"),
        (|p| p["weights"] = json!([-2.0, 0.0]), "prove nothing"),
        // A push at a velocity limit that is not reached costs.
        (|p| p["pushes"] = json!([0.1, 0.0, 0.0]), "claims 200"),
        (|p| p["velocity_deg_s"] = json!([-5, 50]), "zero or reach the joint's limit"),
        (|p| p["velocity_deg_s"] = json!([5, 50]), "must include zero"),
        (|p| p["order"] = json!(1), "an unknown order"),
        (|p| p["joint"] = json!("C"), "not in the certificate"),
    ];
    for (forgery, expected) in forgeries {
        let text = fault_after(&forgery).expect_err("taken");
        assert!(text.contains(expected), "{text:?} does not say {expected:?}");
    }
}
