//! Branches that are kept past poles, and the ways out of them.

use crate::kinematics::{
    branches::{Y, Z, machine, types},
    common::{Random, random_joints, random_machine},
};
use proveout_geom::{ToolPose, Vector};
use proveout_machine::Machine;

/// Machines with both poles, one pole, and none; a held joint below the table and one between the rotary
/// joints.
fn machines() -> Vec<(String, Machine)> {
    let mut all: Vec<(String, Machine)> = types().into_iter().map(|(n, m)| (n.to_owned(), m)).collect();
    let held = |degrees: f64| format!("held = true\nhome_deg = {degrees:?}");
    let x = [1.0, 0.0, 0.0];
    let below = held(25.0);
    let tables =
        [("B", "workpiece", "base", Y, ""), ("C", "workpiece", "B", Z, ""), ("E", "workpiece", "C", x, &below)];
    all.push(("held joint on the table".to_owned(), machine(&tables, "Z", "E")));
    let between = held(90.0);
    let tables =
        [("B", "workpiece", "base", Y, ""), ("E", "workpiece", "B", Z, &between), ("C", "workpiece", "E", Z, "")];
    all.push(("held joint between".to_owned(), machine(&tables, "Z", "C")));
    all
}

#[test]
fn the_branch_of_joint_values_is_the_number_that_the_inverse_gives() {
    let mut random = Random(71);
    let mut seen = [0; 2];
    let mut all: Vec<Machine> = machines().into_iter().map(|(_, m)| m).collect();
    all.extend((0..40).map(|_| random_machine(&mut random)));
    for machine in &all {
        for _ in 0..50 {
            let q = random_joints(machine, &mut random);
            let pose = machine.forward(&q, 90.0);
            for branch in machine.inverse(&pose, 90.0).iter() {
                if branch.singular {
                    continue;
                }
                assert_eq!(machine.branch_of(&branch.q), Some(branch.index));
                let again = machine.on_branch(&pose.axis, branch.index, &branch.q).expect("in reach");
                assert!((again - branch.q).max_abs() < 1e-12);
                seen[branch.index] += 1;
            }
        }
    }
    assert!(seen[0] > 1500 && seen[1] > 1500, "{seen:?}");
}

#[test]
fn in_a_pole_the_first_rotary_joint_does_not_turn_the_tool() {
    let mut count = 0;
    for (name, machine) in machines() {
        for pole in machine.poles(&machine.home()) {
            let pose = ToolPose { tip: [1.0, 2.0, 3.0].into(), axis: pole };
            let found = machine.inverse(&pose, 50.0);
            assert_eq!(found.len(), 1, "{name}");
            let first = machine.rotary_joints()[0];
            assert_eq!(found[0].free_joint, Some(first), "{name}");
            let rates = machine.jacobian(&found[0].q, 50.0);
            assert!(rates.fixed_view::<3, 1>(3, first).norm() < 1e-9, "{name}");
            count += 1;
        }
    }
    // Orthogonal joints have two poles, 45 degree ones one.
    assert_eq!(count, 4 * 2 + 2 + 2 * 2);
}

#[test]
fn a_pole_is_left_where_the_branches_come_from() {
    let mut random = Random(72);
    for (name, machine) in machines() {
        let home = machine.home();
        let poles: Vec<Vector> = machine.poles(&home).collect();
        for pole in poles {
            for _ in 0..200 {
                let direction = loop {
                    let v = random.unit();
                    let across = v - pole * v.dot(&pole);
                    if across.norm() > 0.1 {
                        break across.normalize();
                    }
                };
                let both = machine.leaving_pole(&pole, &direction, &home).expect("two rotary joints");
                for (index, q) in both.iter().enumerate() {
                    // Straight out of the pole the branch goes on from the limit, at the rate of the angle.
                    let mut before = *q;
                    for step in 1..=20 {
                        let angle: f64 = 1e-4 * f64::from(step);
                        let axis = pole * angle.cos() + direction * angle.sin();
                        let now = machine.on_branch(&axis, index, &before).expect("in reach");
                        assert!((now - before).max_abs() < 3e-4, "{name} {step}: {:?}", now - before);
                        assert!((machine.forward(&now, 0.0).axis - axis).norm() < 1e-12, "{name}");
                        assert_eq!(machine.branch_of(&now), Some(index), "{name}");
                        before = now;
                    }
                }
                // The same way backward is the other branch's way on: a pole is passed straight without a
                // turn.
                let back = machine.leaving_pole(&pole, &-direction, &both[0]).expect("two rotary joints");
                assert!((back[1] - both[0]).max_abs() < 1e-12, "{name}");
            }
        }
    }
}

#[test]
fn a_branch_is_one_curve_past_a_pole_at_any_distance() {
    for (name, machine) in machines() {
        let home = machine.home();
        let poles: Vec<Vector> = machine.poles(&home).collect();
        for pole in poles {
            let way = pole.cross(&Vector::new(0.3, -0.5, 0.8)).normalize();
            let aside = pole.cross(&way);
            for distance in [1e-6_f64, 1e-4, 0.01, 0.1, 0.3] {
                let closest = pole * distance.cos() + aside * distance.sin();
                for index in [0, 1] {
                    // Even steps of the azimuth, as the pole sees it: up to 80 degrees to either side.
                    let mut before = None;
                    let mut turned = 0.0;
                    for k in -160..=160 {
                        let x = (distance.sin() * (0.5 * f64::from(k)).to_radians().tan()).clamp(-0.4, 0.4);
                        let axis = (closest * (1.0 - x * x).sqrt() + way * x).normalize();
                        let near = before.unwrap_or(home);
                        let q = machine.on_branch(&axis, index, &near).expect("in reach");
                        assert!((machine.forward(&q, 0.0).axis - axis).norm() < 1e-9, "{name}");
                        if let Some(before) = before {
                            let step = q - before;
                            // A skew pair adds what the tilt makes of its way.
                            assert!(step.max_abs() < 0.04, "{name} {distance} {k}: {}", step.max_abs());
                            turned += step[machine.rotary_joints()[0]];
                        }
                        before = Some(q);
                    }
                    if distance < 0.01 {
                        assert!((turned.abs().to_degrees() - 160.0).abs() < 2.0, "{name} {distance}: {turned}");
                    }
                }
            }
        }
    }
}
