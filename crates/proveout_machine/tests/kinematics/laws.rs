//! Laws that hold on every machine: inverse undoes forward, forward undoes inverse, derivatives are
//! differences. One thousand random machines with skew axes on both sides, 115 poses each, of which 100,000
//! are away from singular ones.

use crate::kinematics::common::{Random, count, random_joints, random_machine};
use proveout_geom::{Pose, wrap_near};
use proveout_machine::{JointValues, Machine};

const MACHINES: usize = 1000;
const POSES: usize = 115;
/// The promise: 1e-9 mm and 1e-10 rad away from singular poses. Levers are up to 2 m, where doubles have
/// 4e-13 mm.
const TIP_MM: f64 = 1e-9;
const AXIS_RAD: f64 = 1e-10;
/// A pose counts as away from singular when the rotary joints turn at most a hundred times faster than the
/// tool axis; rounding of 1e-15 in the axis then stays below 1e-12 in the joints.
const REGULAR_RATE: f64 = 1e-2;
/// Slides after a rotary joint can come to lie in a plane; below this determinant the tip says little about
/// them.
const REGULAR_VOLUME: f64 = 5e-2;

/// Volume spanned by the slides where they are, from the Jacobian's linear columns.
fn slide_volume(machine: &Machine, q: &JointValues) -> f64 {
    let jacobian = machine.jacobian(q, 0.0);
    let column = |k: usize| jacobian.fixed_view::<3, 1>(0, machine.linear_joints()[k]).into_owned();
    column(0).cross(&column(1)).dot(&column(2)).abs()
}

fn joint_distance(machine: &Machine, a: &JointValues, b: &JointValues) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for (j, joint) in machine.joints.iter().enumerate() {
        if joint.is_rotary() {
            worst.1 = worst.1.max((wrap_near(a[j], b[j]) - b[j]).abs());
        } else {
            worst.0 = worst.0.max((a[j] - b[j]).abs());
        }
    }
    worst
}

#[test]
fn inverse_undoes_forward_and_forward_undoes_inverse() {
    let mut random = Random(1);
    let (mut regular, mut worst) = (0, [0.0_f64; 4]);
    let machines = count(MACHINES);
    for _ in 0..machines {
        let machine = random_machine(&mut random);
        for _ in 0..POSES {
            let q = random_joints(&machine, &mut random);
            let length = random.range(0.0, 300.0);
            let pose = machine.forward(&q, length);
            if machine.smallest_axis_rate(&q).expect("two rotary joints") < REGULAR_RATE
                || slide_volume(&machine, &q) < REGULAR_VOLUME
            {
                continue;
            }
            regular += 1;
            let branches = machine.inverse(&pose, length);
            assert_eq!(branches.len(), 2, "axis error {}", branches.axis_error);
            let mut nearest = (f64::INFINITY, f64::INFINITY);
            for branch in branches.iter() {
                if slide_volume(&machine, &branch.q) >= REGULAR_VOLUME {
                    let again = machine.forward(&branch.q, length);
                    worst[0] = worst[0].max((again.tip - pose.tip).norm());
                    worst[1] = worst[1].max(again.angle_to(&pose));
                }
                let distance = joint_distance(&machine, &branch.q, &q);
                if distance.1 < nearest.1 {
                    nearest = distance;
                }
            }
            worst[2] = worst[2].max(nearest.0);
            worst[3] = worst[3].max(nearest.1);
            let solution = machine.inverse_nearest(&pose, length, &q).expect("no limits");
            let distance = joint_distance(&machine, &solution.q, &q);
            assert!(distance.0 < TIP_MM && distance.1 < AXIS_RAD, "nearest is {distance:?} away");
        }
    }
    println!("{regular} of {} poses regular, worst {}", machines * POSES, worst.map(|v| format!("{v:.1e}")).join(", "));
    assert!(regular > 9 * machines * POSES / 10, "{regular} regular poses");
    // Nine of ten poses are away from singular ones: 115 a machine make 100,000.
    assert!(regular >= 100_000 * (machines / MACHINES), "{regular} regular poses");
    assert!(worst[0] < TIP_MM && worst[1] < AXIS_RAD && worst[2] < TIP_MM && worst[3] < AXIS_RAD, "{worst:?}");
}

/// Close to the singular cone the pose must still come out to 1e-6, though the joints are ill determined.
#[test]
fn poses_near_the_singular_cone_are_kept() {
    let mut random = Random(2);
    let mut worst = [0.0_f64; 2];
    let mut found = 0;
    for _ in 0..MACHINES {
        let machine = random_machine(&mut random);
        // The rate as a function of the second rotary joint has a zero between signs of a x b: bisect it.
        let &[_, second] = machine.rotary_joints() else { panic!("two rotary joints") };
        let mut q = random_joints(&machine, &mut random);
        let side = |machine: &Machine, q: &JointValues| {
            let jacobian = machine.jacobian(q, 0.0);
            let rate = |j: usize| jacobian.fixed_view::<3, 1>(3, j).into_owned();
            let &[a, b] = machine.rotary_joints() else { panic!("two rotary joints") };
            rate(a).cross(&rate(b)).dot(&machine.forward(q, 0.0).axis)
        };
        let mut at = |value: f64| {
            q[second] = value;
            side(&machine, &q)
        };
        let starts = (0..30).map(|k| -3.0 + 0.2 * f64::from(k));
        let Some(mut low) = starts.into_iter().find(|&v| at(v) * at(v + 0.2) <= 0.0) else { continue };
        let mut high = low + 0.2;
        let sign = at(low);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            q[second] = middle;
            if side(&machine, &q) * sign > 0.0 { low = middle } else { high = middle }
        }
        let singular = 0.5 * (low + high);
        for step in 0..12 {
            q[second] = singular + 10.0_f64.powi(-step - 3);
            let pose = machine.forward(&q, 100.0);
            let branches = machine.inverse(&pose, 100.0);
            assert!(!branches.is_empty(), "axis error {}", branches.axis_error);
            for branch in branches.iter().filter(|b| slide_volume(&machine, &b.q) >= REGULAR_VOLUME) {
                let again = machine.forward(&branch.q, 100.0);
                worst[0] = worst[0].max((again.tip - pose.tip).norm());
                worst[1] = worst[1].max(again.angle_to(&pose));
            }
            found += 1;
        }
    }
    assert!(found > 10 * MACHINES, "{found}");
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6, "{worst:?}");
}

/// The chain walk of `forward` against the two rigid poses of the tree, which share only the sine and cosine
/// with it.
#[test]
fn forward_is_the_spindle_seen_from_the_table() {
    let mut random = Random(3);
    for _ in 0..200 {
        let machine = random_machine(&mut random);
        let q = random_joints(&machine, &mut random);
        let tree = machine.machine_from_table(&q).inverse() * machine.machine_from_spindle(&q);
        let tip = tree * Pose::from_translation([0.0, 0.0, -120.0].into());
        let pose = machine.forward(&q, 120.0);
        assert!((pose.tip.coords - tip.translation).norm() < TIP_MM);
        assert!((pose.axis - tree.rotation.column(2)).norm() < AXIS_RAD);
        let direct = machine.table_from_spindle(&q);
        assert!((direct.translation - tree.translation).norm() < TIP_MM);
        assert!((direct.rotation - tree.rotation).norm() < AXIS_RAD);
    }
}

/// Central differences with a step of 1e-5 have an error of 1e-10/6 times the third derivative (a lever of 2
/// m) and rounding of 1e-12 / 1e-5: 1e-6 holds both.
#[test]
fn the_jacobian_is_the_limit_of_differences() {
    let mut random = Random(4);
    let step = 1e-5;
    for _ in 0..300 {
        let machine = random_machine(&mut random);
        let q = random_joints(&machine, &mut random);
        let jacobian = machine.jacobian(&q, 80.0);
        for j in 0..machine.joints.len() {
            let mut by = JointValues::ZERO;
            by[j] = step;
            let (a, b) = (machine.forward(&(q - by), 80.0), machine.forward(&(q + by), 80.0));
            let tip = (b.tip - a.tip) / (2.0 * step);
            let axis = (b.axis - a.axis) / (2.0 * step);
            let column = jacobian.column(j);
            assert!((tip - column.fixed_rows::<3>(0)).norm() < 1e-6, "tip by joint {j}");
            assert!((axis - column.fixed_rows::<3>(3)).norm() < 1e-6, "axis by joint {j}");
        }
        let rate = machine.smallest_axis_rate(&q).expect("two rotary joints");
        let &[a, b] = machine.rotary_joints() else { panic!("two rotary joints") };
        // The least stretch over all directions in the plane of the two joints, by search.
        let least = (0..3600)
            .map(|k| {
                let (s, c) = (f64::from(k) * std::f64::consts::PI / 3600.0).sin_cos();
                (jacobian.fixed_view::<3, 1>(3, a) * c + jacobian.fixed_view::<3, 1>(3, b) * s).norm()
            })
            .fold(f64::INFINITY, f64::min);
        assert!(rate <= least + 1e-12 && least - rate < 1e-3, "{rate} against {least}");
    }
}

/// Programmed rotary axes: the slides alone bring the tip home.
#[test]
fn slides_place_the_tip_for_given_rotary_joints() {
    let mut random = Random(5);
    for _ in 0..500 {
        let machine = random_machine(&mut random);
        let q = random_joints(&machine, &mut random);
        if slide_volume(&machine, &q) < REGULAR_VOLUME {
            continue;
        }
        let pose = machine.forward(&q, 90.0);
        let mut start = random_joints(&machine, &mut random);
        for &j in machine.rotary_joints() {
            start[j] = q[j];
        }
        let solved = machine.inverse_with_rotary(&pose.tip, &start, 90.0);
        let distance = joint_distance(&machine, &solved, &q);
        assert!(distance.0 < TIP_MM && distance.1 == 0.0, "{distance:?}");
    }
}
