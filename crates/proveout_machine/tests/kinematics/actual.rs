//! Geometric errors against closed forms worked out by hand.

use std::path::Path;

use crate::kinematics::{
    branches::bc,
    common::{Random, random_joints, random_machine},
};
use proveout_geom::{Point, Vector, rad};
use proveout_machine::{ConstantErrors, ErrorOf, ErrorTable, JointValues, Machine};

/// Levers of a meter in doubles leave 1e-13 mm; the closed forms below are exact.
const EXACT_MM: f64 = 1e-11;

fn with_constant(machine: &Machine, of: ErrorOf, components: [f64; 6]) -> Machine {
    let mut machine = machine.clone();
    machine.errors.constant.push(ConstantErrors { of, components });
    machine.recompiled()
}

fn with_table(machine: &Machine, joint: usize, reference: [f64; 3], at: &[f64], components: &[[f64; 6]]) -> Machine {
    let mut machine = machine.clone();
    let (at, components) = (at.to_vec(), components.to_vec());
    machine.errors.tables.push(ErrorTable { joint, reference: Point::from(reference), at, components });
    machine.recompiled()
}

#[test]
fn without_errors_the_bits_are_the_same() {
    let mut random = Random(31);
    for k in 0..200 {
        let mut machine = random_machine(&mut random);
        if k % 2 == 1 {
            // Stated, and all zero.
            machine = with_constant(&machine, ErrorOf::Joint(1), [0.0; 6]);
            machine = with_table(&machine, 2, [1.0, 2.0, 3.0], &[-500.0, 500.0], &[[0.0; 6]; 2]);
        }
        let q = random_joints(&machine, &mut random);
        assert!(!machine.has_errors());
        assert_eq!(machine.actual_forward(&q, 80.0), machine.forward(&q, 80.0));
        assert_eq!(machine.actual_table_from_spindle(&q), machine.table_from_spindle(&q));
        assert_eq!(machine.actual_joint_poses(&q), machine.joint_poses(&q));
        let solution = machine.actual_inverse_nearest(&machine.forward(&q, 80.0), 80.0, &q).expect("reached");
        assert_eq!(solution, machine.inverse_nearest(&machine.forward(&q, 80.0), 80.0, &q).expect("reached"));
    }
}

/// A table that turns about a line shifted by d sees the tip shifted by (1 - R) d, twice d across after half
/// a turn.
#[test]
fn a_shifted_line_runs_out_by_twice_the_shift() {
    let nominal = bc("", "");
    let actual = with_constant(&nominal, ErrorOf::Joint(4), [0.02, -0.01, 0.0, 0.0, 0.0, 0.0]);
    for degrees in [0.0, 30.0, 90.0, 180.0, 270.0] {
        let mut q = JointValues::ZERO;
        (q[0], q[1], q[2], q[4]) = (10.0, 20.0, 30.0, rad(degrees));
        let off = actual.actual_forward(&q, 0.0).tip - actual.forward(&q, 0.0).tip;
        // Seen from the table the tool turns by +C about the line: p = d + Rz(C) (q - d).
        let (s, c) = rad(degrees).sin_cos();
        let d = Vector::new(0.02, -0.01, 0.0);
        let turned = Vector::new(c * d.x - s * d.y, s * d.x + c * d.y, 0.0);
        assert!((off - (d - turned)).norm() < EXACT_MM, "{degrees}: {off:?}");
    }
}

/// A C line tilted by e about x: its direction is (0, -sin e, cos e); an upright tool then circles on a cone.
#[test]
fn a_tilted_line_swings_the_axis_on_a_cone() {
    let e = 1e-3;
    let nominal = bc("", "");
    let actual = with_constant(&nominal, ErrorOf::Joint(4), [0.0, 0.0, 0.0, e, 0.0, 0.0]);
    let line = Vector::new(0.0, -e.sin(), e.cos());
    for degrees in [0.0, 45.0, 90.0, 180.0] {
        let mut q = JointValues::ZERO;
        q[4] = rad(degrees);
        let axis = actual.actual_forward(&q, 0.0).axis;
        // Rodrigues' formula for the tool axis z turned about the line by +C.
        let (s, c) = rad(degrees).sin_cos();
        let z = Vector::z();
        let wanted = z * c + line.cross(&z) * s + line * (line.z * (1.0 - c));
        assert!((axis - wanted).norm() < 1e-14, "{degrees}");
    }
    // After half a turn the axis is off by twice the tilt.
    let mut q = JointValues::ZERO;
    q[4] = rad(180.0);
    assert!((actual.actual_forward(&q, 0.0).angle_to(&actual.forward(&q, 0.0)) - 2.0 * e).abs() < 1e-12);
}

/// A square path on slides that miss the right angle by e becomes a rhombus: sides kept, diagonals a sqrt(2
/// (1 -+ sin e)).
#[test]
fn missing_squareness_makes_a_rhombus() {
    let (a, e) = (200.0, 40e-6);
    let actual = with_constant(&bc("", ""), ErrorOf::Joint(1), [0.0, 0.0, 0.0, 0.0, 0.0, e]);
    let corner = |x: f64, y: f64| {
        let mut q = JointValues::ZERO;
        (q[0], q[1]) = (x, y);
        actual.actual_forward(&q, 0.0).tip
    };
    let corners = [corner(0.0, 0.0), corner(a, 0.0), corner(a, a), corner(0.0, a)];
    for k in 0..4 {
        assert!(((corners[(k + 1) % 4] - corners[k]).norm() - a).abs() < EXACT_MM, "side {k}");
    }
    // Positive about z turns Y towards -x: the diagonal from the origin is the shorter one.
    let (long, short) = ((corners[3] - corners[1]).norm(), (corners[2] - corners[0]).norm());
    assert!((short - a * (2.0 * (1.0 - e.sin())).sqrt()).abs() < EXACT_MM, "{short}");
    assert!((long - a * (2.0 * (1.0 + e.sin())).sqrt()).abs() < EXACT_MM, "{long}");
    assert!((corners[3] - Point::new(-a * e.sin(), a * e.cos(), 0.0)).norm() < EXACT_MM);
}

/// Scale error, straightness and Abbe's lever from a table, linear between the positions and kept beyond
/// them.
#[test]
fn tables_are_linear_and_have_levers() {
    let rows = [[0.0; 6], [0.010, -0.004, 0.0, 0.0, 0.0, 20e-6], [0.030, 0.0, 0.002, 0.0, 0.0, 0.0]];
    let actual = with_table(&bc("", ""), 0, [0.0, 50.0, 0.0], &[0.0, 100.0, 300.0], &rows);
    for (x, part) in
        [(-50.0, [1.0, 0.0, 0.0]), (50.0, [0.5, 0.5, 0.0]), (150.0, [0.0, 0.75, 0.25]), (999.0, [0.0, 0.0, 1.0])]
    {
        let mut q = JointValues::ZERO;
        (q[0], q[1], q[2]) = (x, 120.0, 7.0);
        let mean = |k: usize| rows.iter().zip(part).map(|(r, w)| r[k] * w).sum::<f64>();
        // The reference point (0, 50, 0) travels with X; the tool end is at (0, 120, 7) on it, 70 mm
        // beyond in y.
        let (s, c) = mean(5).sin_cos();
        let wanted = Point::new(x + mean(0) - s * 70.0, 50.0 + mean(1) + c * 70.0, 7.0 + mean(2));
        let tip = actual.actual_forward(&q, 0.0).tip;
        assert!((tip - wanted).norm() < EXACT_MM, "{x}: {tip} against {wanted}");
    }
}

/// Six components of a rotary joint in resting axes; an endless joint repeats them with each turn.
#[test]
fn rotary_tables_rest_in_the_machine_and_repeat() {
    let machine = bc("", "endless = true");
    let quarter = rad(90.0);
    let at: Vec<f64> = (0..=4).map(|k| f64::from(k) * quarter).collect();
    // EZC: axial, EBC: a wobble about y.
    let mut rows = vec![[0.0; 6]; 5];
    rows[1] = [0.0, 0.0, 0.005, 0.0, 30e-6, 0.0];
    let actual = with_table(&machine, 4, [0.0, 0.0, 0.0], &at, &rows);
    for turns in [-3.0, 0.0, 2.0] {
        let mut q = JointValues::ZERO;
        (q[0], q[4]) = (100.0, quarter + rad(360.0) * turns);
        // In M the table is raised by 5 um and wobbles about y: the tool at (100, 0, 0) is seen from the
        // table frame through the inverse of Ry(30 urad) and then the turned table.
        let (s, c) = 30e-6_f64.sin_cos();
        let (x, z) = (c * 100.0 + s * 0.005, s * 100.0 - c * 0.005);
        let tip = actual.actual_forward(&q, 0.0).tip;
        // Table turned by -90 physically: what lies along x in M lies along y of the table.
        assert!((tip - Point::new(0.0, x, z)).norm() < 1e-10, "{turns}: {tip}");
    }
}

#[test]
fn zeros_and_the_spindle_have_errors_too() {
    let nominal = bc("", "");
    // Zero of C, physically +5 urad on a table that turns by -C: as C -5 urad.
    let actual = with_constant(&nominal, ErrorOf::Joint(4), [0.0, 0.0, 0.0, 0.0, 0.0, 5e-6]);
    let (mut q, mut seen) = (JointValues::ZERO, JointValues::ZERO);
    (q[0], q[3], q[4]) = (80.0, 0.4, 1.0);
    seen.0 = q.0;
    seen[4] -= 5e-6;
    assert!((actual.actual_forward(&q, 10.0).tip - nominal.forward(&seen, 10.0).tip).norm() < EXACT_MM);
    // Zero of X.
    let actual = with_constant(&nominal, ErrorOf::Joint(0), [0.03, 0.0, 0.0, 0.0, 0.0, 0.0]);
    seen.0 = q.0;
    seen[0] += 0.03;
    assert!((actual.actual_forward(&q, 10.0).tip - nominal.forward(&seen, 10.0).tip).norm() < EXACT_MM);
    // A spindle tilted about y by e at the gauge line moves the tip of a tool of length L by -L sin e in x.
    let e = 1e-4;
    let actual = with_constant(&nominal, ErrorOf::Spindle, [0.0, 0.002, 0.0, 0.0, e, 0.0]);
    let pose = actual.actual_forward(&JointValues::ZERO, 150.0);
    assert!((pose.axis - Vector::new(e.sin(), 0.0, e.cos())).norm() < 1e-15);
    assert!((pose.tip - Point::new(-150.0 * e.sin(), 0.002, -150.0 * e.cos())).norm() < EXACT_MM);
}

/// A file says the same as the data, units included.
#[test]
fn files_tell_errors_in_their_units() {
    let text = include_str!("../../../../machines/spinner-u5-620/machine.toml").to_owned()
        + "\n[errors.constant]\nEX0C_um = 8\nEA0C_arcsec = 3\n[errors.chosen]\n\"*\" = \"test\"\n\
           [[errors.table]]\njoint = \"X\"\nat_mm = [-370, 250]\n[errors.table.values]\nEXX_um = [0, 6]\nEBX_urad = [-5, 5]\n";
    let machine = Machine::from_text(Path::new("m.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
    let c = machine.joint("C").expect("C");
    assert_eq!(
        machine.errors.constant,
        [ConstantErrors { of: ErrorOf::Joint(c), components: [0.008, 0.0, 0.0, rad(3.0 / 3600.0), 0.0, 0.0] }]
    );
    let table = &machine.errors.tables[0];
    assert_eq!(table.at, [-370.0, 250.0]);
    for (value, wanted) in table.components[1].iter().zip([0.006, 0.0, 0.0, 0.0, 5e-6, 0.0]) {
        assert!((value - wanted).abs() < 1e-18);
    }
    assert!(machine.has_errors() && machine.trust.iter().any(|t| t.key == "errors.*" && t.chosen));
}

/// What a complete compensation commands brings the actual machine to the pose that was wanted.
#[test]
fn compensation_undoes_the_errors() {
    let mut random = Random(32);
    let (mut solved, mut worst) = (0, [0.0_f64; 2]);
    for _ in 0..300 {
        let mut machine = random_machine(&mut random);
        for j in 0..5 {
            // Components without a meaning for a joint have no effect.
            let components =
                std::array::from_fn(|k| if k < 3 { random.range(-0.02, 0.02) } else { random.range(-5e-5, 5e-5) });
            machine.errors.constant.push(ConstantErrors { of: ErrorOf::Joint(j), components });
            let mut row =
                || std::array::from_fn(|k| if k < 3 { random.range(-0.02, 0.02) } else { random.range(-5e-5, 5e-5) });
            let (at, components) = (vec![-600.0, 0.0, 600.0], vec![row(), row(), row()]);
            machine.errors.tables.push(ErrorTable { joint: j, reference: Point::origin(), at, components });
        }
        let machine = machine.recompiled();
        for _ in 0..10 {
            let q = random_joints(&machine, &mut random);
            let jacobian = machine.jacobian(&q, 0.0);
            let column = |k: usize| jacobian.fixed_view::<3, 1>(0, machine.linear_joints()[k]).into_owned();
            if machine.smallest_axis_rate(&q).expect("two") < 0.05
                || column(0).cross(&column(1)).dot(&column(2)).abs() < 0.2
            {
                continue;
            }
            let wanted = machine.forward(&q, 100.0);
            let before = machine.actual_forward(&q, 100.0);
            assert!((before.tip - wanted.tip).norm() > 1e-4, "errors of hundredths move the tip");
            let solution = machine.actual_inverse_nearest(&wanted, 100.0, &q).unwrap_or_else(|e| panic!("{e}"));
            let after = machine.actual_forward(&solution.q, 100.0);
            worst[0] = worst[0].max((after.tip - wanted.tip).norm());
            worst[1] = worst[1].max(after.angle_to(&wanted));
            assert_eq!(solution.tip_error, (after.tip - wanted.tip).norm(), "the residual is told");
            solved += 1;
        }
    }
    assert!(solved > 1000, "{solved}");
    assert!(worst[0] < 1e-9 && worst[1] < 1e-10, "{worst:?}");
}

/// What a caller keeps as room for the errors is never less than what they do.
#[test]
fn the_bound_of_the_errors_holds_and_tables_tell_their_bends() {
    let mut random = Random(33);
    for _ in 0..300 {
        let mut machine = random_machine(&mut random);
        for j in 0..5 {
            let mut row =
                || std::array::from_fn(|k| if k < 3 { random.range(-0.05, 0.05) } else { random.range(-1e-3, 1e-3) });
            machine.errors.constant.push(ConstantErrors { of: ErrorOf::Joint(j), components: row() });
            let (at, components) = (vec![-600.0, 0.0, 600.0], vec![row(), row(), row()]);
            machine.errors.tables.push(ErrorTable { joint: j, reference: Point::origin(), at, components });
        }
        let machine = machine.recompiled();
        let bound = machine.errors.bound(5000.0);
        for _ in 0..10 {
            let q = random_joints(&machine, &mut random);
            let off = machine.actual_forward(&q, 100.0).tip - machine.forward(&q, 100.0).tip;
            assert!(off.norm() <= bound, "{} {bound}", off.norm());
        }
    }
    let rows = [[0.0; 6], [0.01, 0.0, 0.0, 0.0, 0.0, 0.0], [0.03, 0.0, 0.0, 0.0, 0.0, 0.0]];
    let machine = with_table(&bc("", ""), 0, [0.0; 3], &[0.0, 100.0, 300.0], &rows);
    let at = |x: f64| {
        let mut q = JointValues::ZERO;
        q[0] = x;
        q
    };
    for (from, to, bends) in [(-50.0, -1.0, 0), (-1.0, 1.0, 1), (350.0, -10.0, 3), (100.0, 200.0, 0), (7.0, 7.0, 0)] {
        assert_eq!(machine.error_bends(&at(from), &at(to)), bends, "{from} to {to}");
    }
    assert_eq!(bc("", "").error_bends(&at(-1e3), &at(1e3)), 0);
}
