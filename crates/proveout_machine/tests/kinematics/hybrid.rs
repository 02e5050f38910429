//! The hybrid machine on a 3-RPS platform: golden data, the platform against its joints in space, tables.

use std::path::Path;

use crate::kinematics::common::{Random, rest};
use proveout_geom::{Point, ToolPose, Vector, deg, rad, wrap_near};
use proveout_machine::{Direction, JointValues, Machine, Platform, PlatformError, kinematics_csv};

const RADIUS_FIXED: f64 = 220.0;
const RADIUS_MOVING: f64 = 150.0;
const HEIGHT: f64 = 400.0;

/// Machine II of the golden file: base, Y, heave Z, tilt A, fixture B, workpiece; X carries the tool. The
/// workpiece's zero lies 60 mm above the moving plate, at (0, 0, 460) with all joints at zero.
pub(crate) fn machine_2() -> Machine {
    let joint = |name: &str, kind: &str, carries: &str, parent: &str, d: [i32; 3], extra: &str| {
        format!(
            "[[joint]]\nname = {name:?}\nkind = {kind:?}\ncarries = {carries:?}\nparent = {parent:?}\ndirection = {d:?}\n\
             sense = 1\n{extra}\n"
        )
    };
    let mut text = "name = \"hybrid\"\n".to_owned();
    text += &joint("X", "linear", "tool", "base", [1, 0, 0], "");
    text += &joint("Y", "linear", "workpiece", "base", [0, 1, 0], "");
    text += &joint("Z", "linear", "workpiece", "Y", [0, 0, 1], "");
    text += &joint("A", "rotary", "workpiece", "Z", [1, 0, 0], "point_mm = [0, 0, 400]\ntravel_deg = [-60, 60]");
    text += &joint("B", "rotary", "workpiece", "A", [0, 1, 0], "point_mm = [0, 0, 460]");
    text += &rest("X", "B", Vector::z()).replace("origin_mm = [0, 0, 0]", "origin_mm = [0, 0, 520]");
    text += "[[platform]]\nname = \"P\"\nkind = \"3-RPS\"\nheave = \"Z\"\ntilt = \"A\"\nfixed_radius_mm = 220\n\
             moving_radius_mm = 150\nheight_mm = 400\nleg_1_direction = [0, 1, 0]\n";
    for leg in ["L1", "L2", "L3"] {
        text += &format!(
            "[[platform.leg]]\nname = {leg:?}\ntravel_mm = [350, 560]\nmax_velocity_mm_min = 6_000\nmax_acceleration_mm_s2 = 100\n"
        );
    }
    Machine::from_text(Path::new("hybrid.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

const WORK_IN_TABLE: Vector = Vector::new(0.0, 0.0, 460.0);

/// Nine decimals: half a unit in the last place, of mm and of degrees.
const HALF: f64 = 0.5e-9;

/// What half a unit of each joint column moves the tip (mm) and turns the axis (rad), plus half a unit of
/// each component that it is compared with: the file's own rounding, row by row, from the Jacobian.
fn rounding(machine: &Machine, q: &JointValues) -> (f64, f64) {
    let jacobian = machine.jacobian(q, 0.0);
    let (mut tip, mut axis) = (HALF * 3_f64.sqrt(), HALF * 3_f64.sqrt());
    for (j, joint) in machine.joints.iter().enumerate() {
        let half = if joint.is_rotary() { rad(HALF) } else { HALF };
        tip += half * jacobian.fixed_view::<3, 1>(0, j).norm();
        axis += half * jacobian.fixed_view::<3, 1>(3, j).norm();
    }
    (tip, axis)
}

#[test]
fn the_golden_rows_are_reproduced() {
    let machine = machine_2();
    let text = include_str!("../reference/hybrid_3rps_golden.csv");
    let mut worst = [0.0_f64; 7];
    let mut rows = 0;
    for line in text.lines().skip(1) {
        let n: Vec<f64> = line.split(',').map(|t| t.parse().expect("number")).collect();
        let (p, axis) = (Point::new(n[0], n[1], n[2]) + WORK_IN_TABLE, Vector::new(n[3], n[4], n[5]));
        let mut q = JointValues::ZERO;
        q.0[..5].copy_from_slice(&[n[6], n[7], n[8], rad(n[9]), rad(n[10])]);
        let reached = machine.forward(&q, 0.0);
        let (tip_bound, axis_bound) = rounding(&machine, &q);
        assert!((reached.tip - p).norm() < tip_bound && (reached.axis - axis).norm() < axis_bound, "row {rows}");
        worst[0] = worst[0].max((reached.tip - p).norm());
        worst[1] = worst[1].max((reached.axis - axis).norm());

        // The file's axis has nine digits, its angles eleven: the slides are compared at the axis of the
        // angles, where the lever of 75 mm at most makes 7e-10 of half a unit of an angle; the angles at the
        // rounded axis.
        let exact = ToolPose { tip: p, axis: reached.axis };
        let branch = machine.inverse_nearest(&exact, 0.0, &q).expect("reached").q;
        for k in 0..3 {
            worst[2] = worst[2].max((branch[k] - q[k]).abs());
        }
        let rounded = ToolPose { tip: p, axis: axis.normalize() };
        let branches = machine.inverse(&rounded, 0.0);
        let nearest =
            branches.iter().map(|b| (3..5).map(|k| (wrap_near(b.q[k], q[k]) - q[k]).abs()).fold(0.0, f64::max));
        // Half units of three components turn the axis by 0.87e-9 rad; B turns 1 / cos A times as much.
        let least = nearest.fold(f64::INFINITY, f64::min);
        assert!(least < 0.9e-9 / q[3].cos(), "angles of row {rows}: {least}");
        worst[3] = worst[3].max(least);
        let back = machine.forward(&machine.inverse_nearest(&rounded, 0.0, &q).expect("reached").q, 0.0);
        worst[4] = worst[4].max((back.tip - p).norm()).max((back.axis - rounded.axis).norm());

        let platform = &machine.platforms[0];
        let [first, second, third] = platform.leg_lengths(&q);
        worst[5] = worst[5].max((first - n[11]).abs()).max((second - n[12]).abs()).max((third - n[12]).abs());
        worst[5] = worst[5].max((platform.parasitic_shift(&q) - n[13]).abs());
        let mut far = q;
        (far[2], far[3]) = (0.0, 0.0);
        let [heave, tilt] = platform.from_legs([first, second, third], &far).expect("closes");
        worst[6] = worst[6].max((heave - q[2]).abs()).max((tilt - q[3]).abs());
        // From the printed lengths: half units of the legs over their rates.
        let [heave, tilt] = platform.from_legs([n[11], n[12], n[12]], &far).expect("closes");
        assert!((heave - n[8]).abs() < 3e-9 && (tilt - rad(n[9])).abs() < 3e-11, "legs of row {rows}");
        rows += 1;
    }
    assert_eq!(rows, 12);
    println!(
        "tip, axis, slides, angles, round trip, legs, from legs: {}",
        worst.map(|v| format!("{v:.2e}")).join(", ")
    );
    // Slides: half a unit of nine decimals, and of an angle on the lever. Legs: half a unit of heave and leg,
    // and of the tilt on a radius of 150 mm (1.3e-9). The round trips do not pass through printed numbers.
    assert!(worst[2] < 1e-9 && worst[4] < 1e-9 && worst[5] < 2.3e-9 && worst[6] < 1e-9, "{worst:?}");
}

/// The platform in space: three hinges and three ball joints, nothing of the crate's formulas.
fn joints_in_space(heave: f64, tilt: f64, shift: f64) -> [(Vector, Vector, Vector); 3] {
    [90.0_f64, 210.0, 330.0].map(|angle| {
        let (s, c) = angle.to_radians().sin_cos();
        let out = Vector::new(c, s, 0.0);
        let ball = out * RADIUS_MOVING;
        let (sa, ca) = tilt.sin_cos();
        let turned = Vector::new(ball.x, ca * ball.y - sa * ball.z, sa * ball.y + ca * ball.z);
        let ball = turned + Vector::new(0.0, shift, HEIGHT + heave);
        (out * RADIUS_FIXED, ball, Vector::new(-s, c, 0.0))
    })
}

#[test]
fn legs_stay_in_the_planes_of_their_hinges() {
    let machine = machine_2();
    let platform = &machine.platforms[0];
    let mut random = Random(21);
    for _ in 0..2000 {
        let mut q = JointValues::ZERO;
        (q[2], q[3]) = (random.range(-100.0, 150.0), random.range(-0.7, 0.7));
        let shift = platform.parasitic_shift(&q);
        let lengths = platform.leg_lengths(&q);
        for (k, (hinge, ball, across)) in joints_in_space(q[2], q[3], shift).into_iter().enumerate() {
            // Sizes of 400 mm in doubles: 1e-13.
            assert!(ball.dot(&across).abs() < 1e-12, "leg {k} leaves its plane by {}", ball.dot(&across));
            assert!(((ball - hinge).norm() - lengths[k]).abs() < 1e-12, "leg {k}");
        }
        // The same motion in the machine: the middle of the plate in M.
        let middle = machine.joint_poses(&q)[3].point(&Point::new(0.0, 0.0, HEIGHT));
        assert!((middle - Point::new(0.0, shift, HEIGHT + q[2])).norm() < 1e-12);
    }
}

/// Newton's method on lengths measured in space, with differences for derivatives, against the closed form.
fn newton(lengths: [f64; 3], start: (f64, f64)) -> (f64, f64) {
    let measure = |(h, a): (f64, f64)| {
        let legs = joints_in_space(h, a, -0.5 * RADIUS_MOVING * (1.0 - a.cos()));
        [(legs[0].1 - legs[0].0).norm(), (legs[1].1 - legs[1].0).norm()]
    };
    let (mut h, mut a) = start;
    for _ in 0..60 {
        let now = measure((h, a));
        let (by_h, by_a) = (measure((h + 1e-4, a)), measure((h, a + 1e-6)));
        let (j11, j21) = ((by_h[0] - now[0]) / 1e-4, (by_h[1] - now[1]) / 1e-4);
        let (j12, j22) = ((by_a[0] - now[0]) / 1e-6, (by_a[1] - now[1]) / 1e-6);
        let (r1, r2) = (lengths[0] - now[0], lengths[1] - now[1]);
        let det = j11 * j22 - j12 * j21;
        h += (r1 * j22 - r2 * j12) / det;
        a += (j11 * r2 - j21 * r1) / det;
    }
    (h, a)
}

#[test]
fn legs_give_heave_and_tilt_back() {
    let machine = machine_2();
    let platform = &machine.platforms[0];
    let mut random = Random(22);
    for _ in 0..2000 {
        let mut q = JointValues::ZERO;
        (q[2], q[3]) = (random.range(-100.0, 150.0), random.range(-0.7, 0.7));
        let lengths = platform.leg_lengths(&q);
        let mut near = q;
        // The other assembly is 0.3 rad away at least.
        near[3] += random.range(-0.1, 0.1);
        let [heave, tilt] = platform.from_legs(lengths, &near).expect("closes");
        let by_newton = newton(lengths, (near[2], near[3]));
        // The legs hold the plate with a transmission above 0.3 here: a length of 500 mm in doubles, 6e-14,
        // becomes 1e-12.
        assert!(platform.transmission(&q) > 0.3);
        assert!((heave - q[2]).abs() < 1e-9 && (tilt - q[3]).abs() < 1e-11, "{heave} {tilt} against {q:?}");
        assert!((heave - by_newton.0).abs() < 1e-9 && (tilt - by_newton.1).abs() < 1e-11, "{by_newton:?}");
    }
    let q = JointValues::ZERO;
    assert!(matches!(platform.from_legs([1e3, 60.0, 60.0], &q), Err(PlatformError::Open { leg: 2, short: true, .. })));
    assert!(matches!(
        platform.from_legs([1e3, 400.0, 400.0], &q),
        Err(PlatformError::Open { leg: 1, short: false, .. })
    ));
    assert!(matches!(platform.from_legs([400.0, 400.0, 401.0], &q), Err(PlatformError::SecondTilt { .. })));
    assert!(matches!(platform.from_legs([f64::NAN, 400.0, 400.0], &q), Err(PlatformError::Length { .. })));
}

/// Rates and accelerations of the legs against central differences: step 1e-4 s, third derivatives below 1e4
/// mm/s³ leave 1e-5 / 6; rounding 1e-13 / 1e-8 for the second.
#[test]
fn leg_rates_are_limits_of_differences() {
    let machine = machine_2();
    let platform: &Platform = &machine.platforms[0];
    let mut random = Random(23);
    for _ in 0..300 {
        let mut sets = [JointValues::ZERO; 4];
        for (set, (linear, rotary)) in sets.iter_mut().zip([(80.0, 0.6), (50.0, 0.5), (100.0, 1.0), (500.0, 3.0)]) {
            (set[2], set[3]) = (random.range(-linear, linear), random.range(-rotary, rotary));
        }
        let [q, v, a, j] = sets;
        let at = |t: f64| platform.leg_lengths(&(q + v * t + a * (0.5 * t * t) + j * (t * t * t / 6.0)));
        let [rates, accelerations] = platform.leg_motion(&q, &v, &a);
        let h = 1e-4;
        let (before, now, after) = (at(-h), at(0.0), at(h));
        for k in 0..3 {
            assert!(((after[k] - before[k]) / (2.0 * h) - rates[k]).abs() < 1e-4);
            assert!(((after[k] - 2.0 * now[k] + before[k]) / (h * h) - accelerations[k]).abs() < 1e-2);
        }
        // Third difference over 2 ms: rounding 4e-13 / 2e-9, and a quarter of the fifth derivative (some 1e4)
        // times 1e-6.
        let jerks = platform.leg_jerk(&q, [&v, &a, &j]);
        let h = 1e-3;
        let (outer, inner) = ([at(-2.0 * h), at(2.0 * h)], [at(-h), at(h)]);
        for k in 0..3 {
            let third = (outer[1][k] - outer[0][k] - 2.0 * (inner[1][k] - inner[0][k])) / (2.0 * h * h * h);
            assert!((third - jerks[k]).abs() < 2e-2 + 1e-4 * third.abs(), "{third} {}", jerks[k]);
        }
    }
}

/// Inverse undoes forward and derivatives are differences on platforms too, on either side of the machine.
#[test]
fn platforms_keep_the_laws() {
    let work = machine_2();
    let text = "name = \"parallel head\"\n\
        [[joint]]\nname = \"X\"\nkind = \"linear\"\ncarries = \"workpiece\"\nparent = \"base\"\ndirection = [1, 0, 0]\nsense = -1\n\
        [[joint]]\nname = \"Y\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"base\"\ndirection = [0, 1, 0]\n\
        [[joint]]\nname = \"Z\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"Y\"\ndirection = [0, 0, -1]\nsense = -1\n\
        [[joint]]\nname = \"A\"\nkind = \"rotary\"\ncarries = \"tool\"\nparent = \"Z\"\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 200]\nsense = -1\n\
        [[joint]]\nname = \"C\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"X\"\ndirection = [0, 0, 1]\npoint_mm = [5, 7, 0]\nsense = -1\n\
        [[platform]]\nname = \"P\"\nkind = \"3-RPS\"\nheave = \"Z\"\ntilt = \"A\"\nfixed_radius_mm = 250\nmoving_radius_mm = 180\nheight_mm = 500\nleg_1_direction = [0, -1, 0]\n\
        [[platform.leg]]\nname = \"L1\"\n[[platform.leg]]\nname = \"L2\"\n[[platform.leg]]\nname = \"L3\"\n"
        .to_owned()
        + &rest("A", "C", Vector::z());
    let head = Machine::from_text(Path::new("head.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
    let mut random = Random(24);
    for machine in [&work, &head] {
        for _ in 0..3000 {
            let mut q = JointValues::ZERO;
            for (j, joint) in machine.joints.iter().enumerate() {
                q[j] = if joint.is_rotary() { random.range(-0.9, 0.9) } else { random.range(-200.0, 200.0) };
            }
            if machine.smallest_axis_rate(&q).expect("two") < 1e-2 {
                continue;
            }
            let pose = machine.forward(&q, 70.0);
            let solution = machine.inverse_nearest(&pose, 70.0, &q).expect("reached");
            assert!((solution.q - q).max_abs() < 1e-9, "{:?}", solution.q - q);
            for branch in machine.inverse(&pose, 70.0).iter() {
                let again = machine.forward(&branch.q, 70.0);
                assert!((again.tip - pose.tip).norm() < 1e-9 && again.angle_to(&pose) < 1e-10);
            }
            let tree = machine.machine_from_table(&q).inverse() * machine.machine_from_spindle(&q);
            assert!((tree.point(&Point::new(0.0, 0.0, -70.0)) - pose.tip).norm() < 1e-9);
            let direct = machine.table_from_spindle(&q);
            assert!((direct.translation - tree.translation).norm() < 1e-9);
            let jacobian = machine.jacobian(&q, 70.0);
            for j in 0..5 {
                let mut by = JointValues::ZERO;
                by[j] = 1e-5;
                let (a, b) = (machine.forward(&(q - by), 70.0), machine.forward(&(q + by), 70.0));
                // As in laws.rs: third derivatives times 1e-10 / 6 and rounding.
                assert!(
                    ((b.tip - a.tip) / 2e-5 - jacobian.fixed_view::<3, 1>(0, j)).norm() < 1e-6,
                    "joint {j} of {}",
                    machine.name
                );
            }
        }
    }
}

#[test]
fn tables_of_the_hybrid_machine_go_both_ways() {
    let machine = machine_2();
    let run = |text: &str, direction| {
        let mut out = Vec::new();
        kinematics_csv(&machine, text.as_bytes(), &mut out, direction, 0.0)
            .map(|_| String::from_utf8(out).expect("text"))
    };
    let poses = "x_mm,y_mm,z_mm,i,j,k\n10,-20,465,0,0.3,0.953939201416946\n5,0,450,0.6,0,0.8\n";
    let inverse = run(poses, Direction::Inverse { nearest: true }).expect("inverse");
    let rows: Vec<Vec<&str>> = inverse.lines().map(|l| l.split(',').collect()).collect();
    let names = ["X_mm", "Y_mm", "Z_mm", "A_deg", "B_deg", "L1_mm", "L2_mm", "L3_mm", "branch", "residual_mm", "note"];
    assert_eq!(rows[0][6..], names);
    let field = |row: usize, k: usize| rows[row][k].parse::<f64>().expect("number");
    assert!((field(1, 9) - deg(0.3_f64.asin())).abs() < 1e-9, "A is the tilt: {}", rows[1][9]);
    assert!(field(1, 15) < 1e-9 && field(2, 15) < 1e-9, "residuals");
    // Forward from the legs instead of heave and tilt.
    let mut legs = "B_deg,X_mm,Y_mm,L1_mm,L2_mm,L3_mm\n".to_owned();
    for row in &rows[1..=2] {
        let f = |k: usize| row[k];
        legs += &format!("{},{},{},{},{},{}\n", f(10), f(6), f(7), f(11), f(12), f(13));
    }
    let forward = run(&legs, Direction::Forward).expect("forward");
    for (row, wanted) in forward.lines().skip(1).zip(poses.lines().skip(1)) {
        let tail: Vec<f64> = row.split(',').skip(6).map(|t| t.parse().expect("number")).collect();
        for (a, b) in tail.iter().zip(wanted.split(',')) {
            assert!((a - b.parse::<f64>().expect("number")).abs() < 1e-9, "{row} against {wanted}");
        }
    }
    // A leg past its travel is reported; legs that do not close are an error with line and column.
    let far = run("x_mm,y_mm,z_mm,i,j,k\n0,0,300,0,0,1\n", Direction::Inverse { nearest: false }).expect("row");
    assert!(far.contains("travel of L1"), "{far}");
    let open = run("B_deg,X_mm,Y_mm,L1_mm,L2_mm,L3_mm\n0,0,0,900,400,400\n", Direction::Forward).expect_err("open");
    assert!(open.to_string().contains("line 2: column L1_mm") && open.to_string().contains("too long"), "{open}");
    let missing = run("B_deg,X_mm,Y_mm,L1_mm,L2_mm\n0,0,0,900,400\n", Direction::Forward).expect_err("no L3");
    assert!(missing.to_string().contains("Z_mm"), "{missing}");
}

/// The machine with a drive and a moved mass at each leg; `change` edits its text.
fn driven(change: impl Fn(String) -> String) -> Result<Machine, proveout_input::InputError> {
    let mut text = "name = \"hybrid\"\n".to_owned();
    let joint = |name: &str, kind: &str, carries: &str, parent: &str, d: [i32; 3], extra: &str| {
        format!(
            "[[joint]]\nname = {name:?}\nkind = {kind:?}\ncarries = {carries:?}\nparent = {parent:?}\ndirection = {d:?}\n\
             sense = 1\n{extra}\n"
        )
    };
    text += &joint("X", "linear", "tool", "base", [1, 0, 0], "");
    text += &joint("Z", "linear", "workpiece", "base", [0, 0, 1], "# heave");
    text +=
        &joint("A", "rotary", "workpiece", "Z", [1, 0, 0], "point_mm = [0, 0, 400]\ntravel_deg = [-60, 60]\n# tilt");
    text += &rest("X", "A", Vector::z());
    text += "[[platform]]\nname = \"P\"\nkind = \"3-RPS\"\nheave = \"Z\"\ntilt = \"A\"\nfixed_radius_mm = 220\n\
             moving_radius_mm = 150\nheight_mm = 400\nleg_1_direction = [0, 1, 0]\n";
    for (leg, gain) in [("L1", 50), ("L2", 74), ("L3", 74)] {
        text += &format!(
            "[[platform.leg]]\nname = {leg:?}\nmoving_mass_kg = 80\n[platform.leg.drive]\nposition_gain_1_s = {gain}\n\
             velocity_bandwidth_hz = 100\nmax_force_N = 900 # {leg}\n"
        );
    }
    Machine::from_text(Path::new("hybrid.toml"), &change(text))
}

#[test]
fn legs_have_drives_of_their_own_and_mistakes_are_named() {
    let machine = driven(|text| text).unwrap_or_else(|e| panic!("{e}"));
    let gains = machine.platforms[0].legs.each_ref().map(|l| {
        let drive = l.drive.as_ref().expect("a drive");
        (drive.position_gain, drive.max_force, l.moving_mass)
    });
    assert_eq!(gains, [50.0, 74.0, 74.0].map(|gain| (gain, Some(900.0), Some(80.0))));
    let wrong = |from: &str, to: &str| {
        let text =
            driven(|text| text.replacen(from, to, 1)).err().unwrap_or_else(|| panic!("{to}: accepted")).to_string();
        println!("{text}");
        text
    };
    let text = wrong("max_force_N = 900 # L3", "max_force_N = 901");
    assert!(text.contains("legs L2 and L3 differ") && text.contains("second axis"), "{text}");
    let text = wrong("name = \"L1\"\nmoving_mass_kg = 80", "name = \"L1\"");
    assert!(text.contains("leg L1") && text.contains("moving_mass_kg"), "{text}");
    for joint in ["# heave", "# tilt"] {
        let text = wrong(joint, "[joint.drive]\nposition_gain_1_s = 50\nvelocity_bandwidth_hz = 100\n");
        assert!(text.contains("moved by the legs") && text.contains("platform.leg.drive"), "{text}");
    }
    let text = wrong("max_force_N = 900 # L1", "max_torque_Nm = 900");
    assert!(text.contains("a linear joint has no max_torque_Nm"), "{text}");
    let text = wrong("position_gain_1_s = 50", "position_gain_1_s = 5000");
    assert!(text.contains("5000 is not between"), "{text}");
}

/// Rates of the legs against differences of their lengths, and back; at tilts to both sides, heave and tilt
/// of either sense.
#[test]
fn rates_of_the_legs_are_the_derivatives_of_their_lengths() {
    let machine = machine_2();
    let mut random = Random(41);
    let mut signed = || random.range(-1.0, 1.0);
    for turned in [1.0, -1.0] {
        let mut platform = machine.platforms[0].clone();
        (platform.heave_sign, platform.tilt_sign) = (turned, -turned);
        for _ in 0..500 {
            let mut q = JointValues::ZERO;
            (q[2], q[3]) = (60.0 * signed(), rad(50.0) * signed());
            let h = 1e-5;
            let by = |j: usize| {
                let [mut ahead, mut behind] = [q, q];
                ahead[j] += h;
                behind[j] -= h;
                let [a, b] = [ahead, behind].map(|q| platform.leg_lengths(&q));
                [0, 1].map(|k| (a[k] - b[k]) / (2.0 * h))
            };
            let rates = platform.leg_rates(&q);
            let differences = [by(2), by(3)];
            for (leg, row) in rates.iter().enumerate() {
                for (rate, column) in row.iter().zip(&differences) {
                    // Third derivatives of lengths of 400 mm by radian: 1e3 h^2 / 6 and rounding of 1e-13 /
                    // h.
                    assert!((rate - column[leg]).abs() < 1e-5, "{q:?}: {rates:?} {differences:?}");
                }
            }
            let velocity = [30.0 * signed(), signed()];
            let legs = rates.map(|r| r[0] * velocity[0] + r[1] * velocity[1]);
            let back = platform.joint_rates(&q, legs);
            // Transmission is above 0.3 here: ten digits are left.
            assert!(
                (back[0] - velocity[0]).abs() < 1e-9 && (back[1] - velocity[1]).abs() < 1e-11,
                "{back:?} {velocity:?}"
            );
        }
    }
}
