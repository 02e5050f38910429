//! Branches over whole paths: singular cones of every machine, look-ahead against a full search, named rewinds.

use std::path::Path;

use crate::{
    branches::{bc, types},
    common::{Random, random_joints, random_machine},
    hybrid::machine_2,
};
use proveout_geom::{ToolPose, Vector, rad};
use proveout_machine::{BranchPlan, JointValues, Machine, PlanEvent, PlanOptions, plan_branches};

/// Half of the path and its step, radian: fine enough that no step is a jump, wide enough to leave the cone.
const HALF_STEPS: i32 = 40;
const STEP: f64 = 0.2;

fn options(start: Option<JointValues>) -> PlanOptions {
    PlanOptions { tool_length: 100.0, start, ..PlanOptions::default() }
}

fn library() -> Vec<(String, Machine)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let entries = std::fs::read_dir(folder).expect("the folder machines/");
    let mut folders: Vec<_> =
        entries.map(|e| e.expect("entry").path()).filter(|p| p.join("machine.toml").is_file()).collect();
    folders.sort();
    let name = |p: &Path| p.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    folders.iter().map(|p| (name(p), Machine::read(p).unwrap_or_else(|e| panic!("{e}")))).collect()
}

/// Joint values in a singular pose: slides in the middle of their travel, the tilting joint where the rates of both
/// rotary joints come to lie along each other; `None` where that is outside its travel.
fn singular_pose(machine: &Machine) -> Option<JointValues> {
    let &[first, second] = machine.rotary_joints() else { return None };
    let mut q = machine.home();
    for &j in machine.linear_joints() {
        q[j] = machine.joints[j].travel.map_or(0.0, |[a, b]| 0.5 * (a + b));
    }
    if machine.joints[first].travel.is_none_or(|[a, b]| a < 0.0 && b > 0.0) {
        q[first] = 0.0;
    }
    let side = |value: f64| {
        let mut q = q;
        q[second] = value;
        let jacobian = machine.jacobian(&q, 0.0);
        let rate = |j: usize| jacobian.fixed_view::<3, 1>(3, j).into_owned();
        rate(first).cross(&rate(second)).dot(&machine.forward(&q, 0.0).axis)
    };
    let [low, high] = machine.joints[second].travel.unwrap_or([-3.0, 3.0]);
    let count = 720;
    let at = |k: usize| low + (high - low) * k as f64 / f64::from(count);
    let mut found: Vec<f64> = Vec::new();
    for k in 0..count as usize {
        let (mut a, mut b) = (at(k), at(k + 1));
        if side(a) == 0.0 {
            found.push(a);
        } else if side(a) * side(b) < 0.0 {
            let sign = side(a);
            for _ in 0..100 {
                let middle = 0.5 * (a + b);
                if side(middle) * sign > 0.0 { a = middle } else { b = middle }
            }
            found.push(0.5 * (a + b));
        }
    }
    let value = found.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    // Zero exactly where it is meant.
    q[second] = if value.abs() < 1e-9 { 0.0 } else { value };
    Some(q)
}

/// Poses on a great circle through the singular axis, the way that the tilting joint swings the tool, offset sidewise.
fn through_the_cone(machine: &Machine, q: &JointValues, offset: f64) -> Vec<ToolPose> {
    let second = machine.rotary_joints()[1];
    let pose = machine.forward(q, 100.0);
    let way = machine.jacobian(q, 100.0).fixed_view::<3, 1>(3, second).normalize();
    let aside = pose.axis.cross(&way);
    (-HALF_STEPS..=HALF_STEPS)
        .map(|k| {
            let angle = rad(STEP * f64::from(k));
            let axis = (pose.axis * angle.cos() + way * angle.sin()) * offset.cos() + aside * offset.sin();
            ToolPose { tip: pose.tip, axis }
        })
        .collect()
}

fn reaches(machine: &Machine, poses: &[ToolPose], plan: &BranchPlan) {
    assert_eq!(plan.joints.len(), poses.len());
    for (pose, q) in poses.iter().zip(&plan.joints) {
        let again = machine.forward(q, 100.0);
        // The singular cone keeps poses to 1e-6; where it is left, to 1e-9.
        assert!((again.tip - pose.tip).norm() < 1e-6 && again.angle_to(pose) < 1e-6, "{:?}", again.tip - pose.tip);
    }
}

/// Every machine of the library that has the folder here, the kinds that it is to hold, and the hybrid machine.
#[test]
fn every_machine_passes_its_singular_cone() {
    let mut machines: Vec<(String, Machine)> = library();
    machines.extend(types().into_iter().map(|(n, m)| (n.to_owned(), m)));
    machines.push(("3-RPS hybrid".to_owned(), machine_2()));
    let (mut passed, mut one_sided) = (0, 0);
    for (name, machine) in &machines {
        let &[_, second] = machine.rotary_joints() else { continue };
        // Where the end stops keep the machine out of its cone, the same machine without them runs the path, and the real one
        // must say that it cannot.
        let (q, mechanism, kept_out) = match singular_pose(machine) {
            Some(q) => (q, machine.clone(), false),
            None => {
                let mut open = machine.clone();
                open.joints[second].travel = None;
                (
                    singular_pose(&open).unwrap_or_else(|| panic!("{name}: every machine has a singular axis")),
                    open,
                    true,
                )
            }
        };
        if kept_out {
            let plan = plan_branches(machine, &through_the_cone(&mechanism, &q, 0.0), &options(None)).expect("planned");
            let tilt = &machine.joints[second].name;
            let tilt_stops =
                |e: &PlanEvent| matches!(e, PlanEvent::OverTravel { violation, .. } if violation.name == *tilt);
            // With the stop on the singular axis itself the table turns by half a turn there instead.
            let turned = |e: &PlanEvent| matches!(e, PlanEvent::SingularCone { turn, .. } if *turn > rad(170.0));
            let named = plan.events.iter().any(|e| matches!(e, PlanEvent::SingularCone { .. }));
            assert!(named && plan.events.iter().any(|e| tilt_stops(e) || turned(e)), "{name}: {:?}", plan.events);
        }
        let machine = &mechanism;
        let half = rad(STEP * f64::from(HALF_STEPS));
        let room =
            machine.joints[second].travel.is_none_or(|[a, b]| q[second] - a > 2.0 * half && b - q[second] > 2.0 * half);
        for offset in [0.0, rad(0.05)] {
            let poses = through_the_cone(machine, &q, offset);
            let plan = plan_branches(machine, &poses, &options(None)).unwrap_or_else(|e| panic!("{name}: {e}"));
            reaches(machine, &poses, &plan);
            let cones: Vec<&PlanEvent> =
                plan.events.iter().filter(|e| matches!(e, PlanEvent::SingularCone { .. })).collect();
            let [PlanEvent::SingularCone { first, last, place, cone_angle, amplification, turn, .. }] = cones[..]
            else {
                panic!("{name} {offset}: {:?}", plan.events)
            };
            // Skew tables bend the cone: the nearest place may lie a step aside.
            assert!((place - f64::from(HALF_STEPS)).abs() < 1.5, "{name} {offset}: at {place}");
            assert!(*first < HALF_STEPS as usize && *last > HALF_STEPS as usize, "{name}: {first} to {last}");
            assert!(
                (cone_angle - offset).abs() < 1e-3 && *amplification > 100.0,
                "{name} {offset}: {cone_angle} {amplification}"
            );
            println!(
                "{name}, {:.2} degrees aside: place {place:.2}, cone {:.4} degrees, amplification {amplification:.0}, turn {:.1} degrees, other events {}",
                offset.to_degrees(),
                cone_angle.to_degrees(),
                turn.to_degrees(),
                plan.events.len() - 1
            );
            let jumps = plan.events.iter().filter(|e| matches!(e, PlanEvent::Jump { .. })).count();
            assert_eq!(jumps, 0, "{name} {offset}: {:?}", plan.events);
            // With room on both sides the tilt passes straight through the axis and nothing turns over; elsewhere the
            // table must turn inside the cone, and outside it no faster than the limit of the report.
            let through = room && offset == 0.0;
            for (k, w) in plan.joints.windows(2).enumerate() {
                let bound = match (through, k >= *first && k < *last) {
                    (true, _) => rad(4.0 * STEP),
                    (false, false) => rad(11.0 * STEP),
                    (false, true) => rad(180.0),
                };
                for &j in machine.rotary_joints() {
                    let step = (w[1][j] - w[0][j]).abs();
                    assert!(step < bound + 1e-9, "{name} {offset}: step {k} of {}", step.to_degrees());
                }
            }
            one_sided += usize::from(!room);
            passed += 1;
        }
    }
    assert!(passed >= 2 * 9, "{passed}");
    println!("{passed} paths, {one_sided} with the tilt at its end");
}

/// All sequences of branches and turns against the plan: the least way over short random paths. Jumps are allowed here
/// (tolerance half a turn), so that the way alone decides.
#[test]
fn look_ahead_finds_the_least_way_of_all() {
    let mut random = Random(51);
    let mut checked = 0;
    for case in 0..80 {
        let machine = if case % 2 == 0 {
            bc("travel_deg = [-120, 120]", "travel_deg = [-400, 380]")
        } else {
            let mut machine = random_machine(&mut random);
            let j = machine.rotary_joints()[0];
            machine.joints[j].travel = Some([-4.0, 5.0]);
            machine
        };
        let start = JointValues::ZERO;
        let poses: Vec<ToolPose> =
            (0..5).map(|_| machine.forward(&random_joints(&machine, &mut random), 100.0)).collect();
        let set = PlanOptions { axis_tolerance: 4.0, ..options(Some(start)) };
        let plan = plan_branches(&machine, &poses, &set).expect("reached");
        let way = |joints: &[JointValues]| {
            let all = std::iter::once(&start).chain(joints);
            let pairs = all.clone().zip(all.skip(1));
            pairs.map(|(a, b)| machine.rotary_joints().iter().map(|&j| (b[j] - a[j]).abs()).sum::<f64>()).sum::<f64>()
        };
        // Every branch with every turn within +-2 turns and travel, pose by pose.
        let choices: Vec<Vec<JointValues>> = poses
            .iter()
            .map(|pose| {
                let mut all = Vec::new();
                for branch in machine.inverse(pose, 100.0).iter() {
                    for turns in 0..25 {
                        let mut q = branch.q;
                        for (&j, k) in machine.rotary_joints().iter().zip([turns % 5 - 2, turns / 5 - 2]) {
                            q[j] += rad(360.0) * f64::from(k);
                        }
                        let within =
                            machine.rotary_joints().iter().all(|&j| machine.joints[j].travel_violation(q[j]).is_none());
                        if within {
                            all.push(q);
                        }
                    }
                }
                all
            })
            .collect();
        if choices.iter().any(Vec::is_empty) {
            continue;
        }
        // Full search, cut where the way is longer than the best already.
        let mut best = f64::INFINITY;
        let mut stack: Vec<Vec<JointValues>> = vec![Vec::new()];
        while let Some(done) = stack.pop() {
            let so_far = way(&done);
            if so_far >= best {
                continue;
            }
            match choices.get(done.len()) {
                None => best = so_far,
                Some(next) => {
                    let last = done.last().copied().unwrap_or(start);
                    let mut sorted: Vec<&JointValues> = next.iter().collect();
                    let distance =
                        |q: &JointValues| machine.rotary_joints().iter().map(|&j| (q[j] - last[j]).abs()).sum::<f64>();
                    sorted.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
                    stack.extend(sorted.into_iter().map(|q| [&done[..], &[*q]].concat()));
                }
            }
        }
        assert!((way(&plan.joints) - best).abs() < 1e-9, "case {case}: {} against {best}", way(&plan.joints));
        checked += 1;
    }
    assert!(checked > 35, "{checked}");
}

fn cone_walk(machine: &Machine, tilt: f64, from: i32, to: i32) -> Vec<ToolPose> {
    let (b, c) = (machine.joint("B").expect("B"), machine.joint("C").expect("C"));
    let degrees: Vec<i32> = (from..=to).step_by(2).collect();
    degrees
        .iter()
        .map(|&d| {
            let mut q = JointValues::ZERO;
            (q[b], q[c]) = (rad(tilt), rad(f64::from(d)));
            machine.forward(&q, 100.0)
        })
        .collect()
}

/// C must go from 150 to 330 with stops at +-200: pose by pose it runs into the stop, the plan begins on the other
/// branch, and where the tilt forbids that the rewind is named.
#[test]
fn an_avoidable_rewind_is_avoided_and_another_is_named() {
    let both = bc("travel_deg = [-60, 60]", "travel_deg = [-200, 200]");
    let poses = cone_walk(&both, 30.0, 150, 330);
    let mut previous = JointValues::ZERO;
    (previous[3], previous[4]) = (rad(30.0), rad(150.0));
    let mut greedy_jump = 0.0_f64;
    for pose in &poses {
        let q = both.inverse_nearest(pose, 100.0, &previous).expect("reached").q;
        greedy_jump = greedy_jump.max((q[4] - previous[4]).abs());
        previous = q;
    }
    assert!(greedy_jump > rad(170.0), "pose by pose C turns over");
    let plan = plan_branches(&both, &poses, &options(None)).expect("planned");
    reaches(&both, &poses, &plan);
    assert_eq!(plan.events, [], "nothing to tell");
    assert!(plan.branches.iter().all(|&b| b == 1), "the negative tilt");

    let one = bc("travel_deg = [-10, 60]", "travel_deg = [-200, 200]");
    let plan = plan_branches(&one, &poses, &options(None)).expect("planned");
    reaches(&one, &poses, &plan);
    let [PlanEvent::Jump { pose, joint, turn, deviation, branches }] = plan.events[..] else {
        panic!("one rewind: {:?}", plan.events)
    };
    assert_eq!((joint, branches), (4, [0, 0]));
    assert!((turn.abs() - rad(358.0)).abs() < 1e-9, "a turn back, less the step: {}", turn.to_degrees());
    // Half way C stands opposite: the tool leaves its way by the opening of the cone.
    assert!(deviation > rad(40.0) && deviation <= rad(60.1), "{}", deviation.to_degrees());
    assert!((1..poses.len()).contains(&pose));

    // Nothing helps where the pose itself lies past the stops.
    let narrow = bc("travel_deg = [-10, 60]", "travel_deg = [-100, 100]");
    let plan = plan_branches(&narrow, &poses, &options(None)).expect("planned, with its over-travel");
    assert!(plan.events.iter().any(|e| matches!(e, PlanEvent::OverTravel { violation, .. } if violation.name == "C")));
}

/// The tool stands upright for a while between two tilts in different directions: the table turns in that time.
#[test]
fn a_free_table_turns_while_the_tool_stands_upright() {
    let machine = bc("travel_deg = [-5, 60]", "");
    let mut poses = cone_walk(&machine, 20.0, 0, 0);
    let upright = ToolPose { tip: poses[0].tip, axis: Vector::z() };
    poses.extend([upright; 6]);
    poses.extend(cone_walk(&machine, 20.0, 90, 90));
    let plan = plan_branches(&machine, &poses, &options(None)).expect("planned");
    reaches(&machine, &poses, &plan);
    let c: Vec<f64> = plan.joints.iter().map(|q| q[4].to_degrees()).collect();
    for (k, wanted) in [0.0, 0.0, 18.0, 36.0, 54.0, 72.0, 90.0, 90.0].into_iter().enumerate() {
        assert!((c[k] - wanted).abs() < 1e-9, "{c:?}");
    }
    assert!(!plan.events.iter().any(|e| matches!(e, PlanEvent::Jump { .. })), "{:?}", plan.events);
    // A path that begins upright lets the table wait where it will be needed; a stated start is turned away from.
    let plan = plan_branches(&machine, &poses[1..], &options(None)).expect("planned");
    assert!(plan.joints.iter().all(|q| (q[4] - rad(90.0)).abs() < 1e-12));
    let plan = plan_branches(&machine, &poses[1..], &options(Some(JointValues::ZERO))).expect("planned");
    assert!(plan.joints[0][4] == 0.0 && (plan.joints[5][4] - rad(90.0)).abs() < 1e-12);
}

/// Endless joints unwrap for ever; a step that passes the cone between two coarse poses is still named.
#[test]
fn turns_add_up_and_cones_between_poses_are_seen() {
    let machine = bc("travel_deg = [-5, 60]", "endless = true");
    let poses = cone_walk(&machine, 30.0, 0, 1440);
    let plan = plan_branches(&machine, &poses, &options(None)).expect("planned");
    assert!((plan.joints[poses.len() - 1][4] - plan.joints[0][4] - rad(1440.0)).abs() < 1e-9);
    assert_eq!(plan.events, []);

    let free = bc("", "");
    let coarse = [cone_walk(&free, 10.0, 0, 0), cone_walk(&free, -10.0, 0, 0)].concat();
    let plan = plan_branches(&free, &coarse, &options(None)).expect("planned");
    let [
        PlanEvent::SingularCone { first: 0, last: 1, place, cone_angle, amplification, .. },
        PlanEvent::BranchChange { pose: 1, .. },
    ] = plan.events[..]
    else {
        panic!("{:?}", plan.events)
    };
    assert!((place - 0.5).abs() < 1e-9 && cone_angle < 1e-9 && amplification > 1e6);
}

#[test]
fn poses_out_of_reach_are_named_by_number() {
    let machine = types().swap_remove(3).1;
    let up = ToolPose { tip: [0.0; 3].into(), axis: Vector::z() };
    let down = ToolPose { axis: -Vector::z(), ..up };
    let error = plan_branches(&machine, &[up, up, down], &options(None)).expect_err("upside down");
    assert_eq!(error.pose, 2);
    assert!(error.to_string().contains("pose 2"), "{error}");
    assert_eq!(plan_branches(&machine, &[], &options(None)).expect("nothing"), BranchPlan::default());
}
