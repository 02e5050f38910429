//! Newton-Euler against closed forms, against Lagrange's equations from numerical derivatives of the forward
//! kinematics, and against Rapier; the library machines among others.

#![allow(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::{Path, PathBuf};

use crate::common::Random;
use nalgebra::Matrix3;
use proveout_controller::dynamics::{RapierPlant, RigidTree, STANDARD_GRAVITY};
use proveout_geom::Vector;
use proveout_machine::{Attachment, JointValues, MAX_JOINTS, Machine};

/// The library machines that are trees: all but the one with a platform.
fn library() -> Vec<Machine> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let entries = std::fs::read_dir(folder).expect("the folder machines/");
    let mut all: Vec<PathBuf> = entries.map(|e| e.expect("entry").path()).filter(|p| p.is_dir()).collect();
    all.sort();
    let all = all.iter().map(|p| Machine::read(p).unwrap_or_else(|e| panic!("{e}")));
    let trees: Vec<Machine> = all.filter(|m| m.platforms.is_empty()).collect();
    for machine in &trees {
        let unknown = RigidTree::new(machine).report().unknown.clone();
        assert!(unknown.is_empty(), "{}: {unknown:?}", machine.name);
    }
    assert!(trees.len() >= 14, "{}", trees.len());
    trees
}

/// Head swivels and turns on a slide, table swivels on a slide: bodies with full tensors, axes on a slant.
fn skew() -> Machine {
    let joint = |name: &str, kind: &str, carries: &str, parent: &str, direction: &str, rest: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"{kind}\"\ncarries = \"{carries}\"\nparent = \"{parent}\"\n\
             direction = {direction}\n{rest}\n\n"
        )
    };
    let body = |on: &str, mass: f64, center: &str, inertia: &str| {
        format!(
            "[[body]]\nname = \"body {on}\"\nrole = \"part\"\nattached_to = \"{on}\"\ncheck = false\n\
             mass = {{ mass_kg = {mass}, center_mm = {center}, inertia_kg_m2 = {inertia} }}\n\
             [[body.box]]\nmin_mm = [0, 0, 0]\nmax_mm = [1, 1, 1]\n\n"
        )
    };
    let text = [
        "name = \"skew\"\nup = [0, 0, 1]\n\n".to_owned(),
        joint("C", "rotary", "tool", "Z", "[0, 0, 1]", "point_mm = [30, -20, 0]\nsense = 1\nendless = true"),
        joint("Z", "linear", "tool", "base", "[0, 0, 1]", "sense = -1"),
        joint("A", "rotary", "tool", "C", "[0.6, 0, 0.8]", "point_mm = [30, 10, 150]\nsense = -1\nendless = true"),
        joint("X", "linear", "workpiece", "base", "[0.8, 0.6, 0]", ""),
        joint("Y", "linear", "workpiece", "X", "[0, 1, 0]", ""),
        "[spindle]\non = \"A\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n\n\
         [table]\non = \"Y\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n\
         [control]\ncycle_time_ms = 2\nblock_time_ms = 0\ntool_change_time_s = 4\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\n\n"
            .to_owned(),
        body("Z", 300.0, "[10, 200, 400]", "[30, 25, 12, 1, -2, 0.5]"),
        body("C", 120.0, "[80, -60, 220]", "[4, 5, 6, 0.5, 0.2, -0.3]"),
        body("A", 60.0, "[90, 40, 60]", "[1.2, 1.5, 0.9, 0.1, -0.2, 0.05]"),
        body("X", 500.0, "[0, 0, -300]", "[40, 60, 80, 0, 0, 3]"),
        body("Y", 250.0, "[20, 10, -100]", "[20, 30, 35, 1, 1, 1]"),
    ]
    .concat();
    Machine::from_text(Path::new("skew/machine.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

/// Random positions within half the travel, velocities and accelerations of real size.
fn state(machine: &Machine, random: &mut Random) -> [JointValues; 3] {
    let mut out = [JointValues::ZERO; 3];
    for (j, joint) in machine.joints.iter().enumerate() {
        let [low, high] = joint.travel.unwrap_or(if joint.is_rotary() { [-3.0, 3.0] } else { [-200.0, 200.0] });
        let scale = if joint.is_rotary() { [3.0, 15.0] } else { [500.0, 5000.0] };
        out[0][j] = random.range(low, high);
        out[1][j] = random.range(-scale[0], scale[0]);
        out[2][j] = random.range(-scale[1], scale[1]);
    }
    out
}

/// Kinetic and potential energy (kg mm²/s²) from positions and the numerical derivative of every body's pose.
struct Lagrange<'a> {
    machine: &'a Machine,
}

impl Lagrange<'_> {
    /// Inertia of the joints: sum over bodies of the products of their rates, from central differences of the
    /// poses.
    fn inertia(&self, q: &JointValues) -> [[f64; MAX_JOINTS]; MAX_JOINTS] {
        let n = self.machine.joints.len();
        let mut m = [[0.0; MAX_JOINTS]; MAX_JOINTS];
        for body in &self.machine.bodies {
            let Some(mass) = body.mass else { continue };
            let pose = |q: &JointValues| self.machine.attachment_pose(body.attached_to, q);
            let here = pose(q);
            let mut rates = Vec::new();
            for j in 0..n {
                let h = if self.machine.joints[j].is_rotary() { 1e-5 } else { 1e-2 };
                let (mut up, mut down) = (*q, *q);
                up[j] += h;
                down[j] -= h;
                let (a, b) = (pose(&up), pose(&down));
                let v = (a.point(&mass.center) - b.point(&mass.center)) / (2.0 * h);
                let turn: Matrix3<f64> = (a.rotation - b.rotation) / (2.0 * h) * here.rotation.transpose();
                let w =
                    Vector::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)])
                        * 0.5;
                rates.push((v, w));
            }
            let inertia = here.rotation * mass.inertia * here.rotation.transpose();
            for i in 0..n {
                for k in 0..n {
                    m[i][k] += mass.mass * rates[i].0.dot(&rates[k].0) + rates[i].1.dot(&(inertia * rates[k].1));
                }
            }
        }
        m
    }

    fn height(&self, q: &JointValues) -> f64 {
        let bodies = self.machine.bodies.iter().filter(|b| b.attached_to != Attachment::Base);
        let up = self.machine.up.expect("up");
        bodies
            .filter_map(|b| b.mass.map(|m| (b, m)))
            .map(|(b, m)| {
                m.mass
                    * STANDARD_GRAVITY
                    * up.dot(&self.machine.attachment_pose(b.attached_to, q).point(&m.center).coords)
            })
            .sum()
    }

    /// Forces in N and N mm: d/dt of dT/dq. minus d(T - V)/dq, with M by differences again.
    fn forces(&self, [q, v, a]: &[JointValues; 3]) -> JointValues {
        let n = self.machine.joints.len();
        let m = self.inertia(q);
        let mut slope = Vec::new();
        let mut weight = [0.0; MAX_JOINTS];
        for k in 0..n {
            let h = if self.machine.joints[k].is_rotary() { 1e-3 } else { 1.0 };
            let (mut up, mut down) = (*q, *q);
            up[k] += h;
            down[k] -= h;
            let (mu, md) = (self.inertia(&up), self.inertia(&down));
            slope.push(std::array::from_fn::<_, MAX_JOINTS, _>(|i| {
                std::array::from_fn::<_, MAX_JOINTS, _>(|j| (mu[i][j] - md[i][j]) / (2.0 * h))
            }));
            weight[k] = (self.height(&up) - self.height(&down)) / (2.0 * h);
        }
        let mut tau = JointValues::ZERO;
        for i in 0..n {
            let mut sum = weight[i];
            for j in 0..n {
                sum += m[i][j] * a[j];
                for k in 0..n {
                    sum += (slope[k][i][j] - 0.5 * slope[i][j][k]) * v[j] * v[k];
                }
            }
            tau[i] = sum * 1e-3;
        }
        tau
    }
}

#[test]
fn forces_are_those_of_lagrange() {
    for machine in library().into_iter().chain([skew()]) {
        let tree = RigidTree::new(&machine);
        assert!(tree.report().unknown.is_empty(), "{}: {:?}", machine.name, tree.report());
        let oracle = Lagrange { machine: &machine };
        let mut random = Random::new(3);
        for _ in 0..20 {
            let s = state(&machine, &mut random);
            let (tau, expected) = (tree.inverse_dynamics(&s[0], &s[1], &s[2]), oracle.forces(&s));
            for j in 0..machine.joints.len() {
                let size = if machine.joints[j].is_rotary() { 1e6 } else { 1e3 }; // of the forces at hand, N and N mm
                // Second differences over 1e-3 rad: (1e-3)²/6 of the term, and rounding.
                assert!((tau[j] - expected[j]).abs() < 1e-5 * size, "{} {j}: {} {}", machine.name, tau[j], expected[j]);
            }
        }
    }
}

#[test]
fn inertia_and_accelerations_belong_to_the_forces() {
    for machine in library().into_iter().chain([skew()]) {
        let tree = RigidTree::new(&machine);
        let mut random = Random::new(4);
        for _ in 0..50 {
            let [q, v, a] = state(&machine, &mut random);
            let m = tree.mass_matrix(&q);
            let rest = tree.inverse_dynamics(&q, &v, &JointValues::ZERO);
            let tau = tree.inverse_dynamics(&q, &v, &a);
            for i in 0..machine.joints.len() {
                let by_inertia: f64 = (0..MAX_JOINTS).map(|k| m[(i, k)] * a[k]).sum();
                // Both ways sum the same few dozen terms of up to 1e10: rounding.
                assert!((tau[i] - rest[i] - by_inertia * 1e-3).abs() < 1e-9 * (1e3 + tau[i].abs()));
            }
            let back = tree.forward_dynamics(&q, &v, &tau, &JointValues::ZERO).expect("masses");
            assert!((back - a).max_abs() < 1e-8, "{}: {back:?} {a:?}", machine.name);
        }
    }
}

#[test]
fn a_slide_lifts_its_weight_and_a_pendulum_has_its_closed_form() {
    let machine = skew();
    let tree = RigidTree::new(&machine);
    let z = machine.joint("Z").expect("Z");
    let mut a = JointValues::ZERO;
    a[z] = 700.0;
    let tau = tree.inverse_dynamics(&JointValues::ZERO, &JointValues::ZERO, &a);
    // Z grows downward (sense -1) and carries 480 kg: the weight pulls in its direction.
    assert!((tau[z] - 480.0 * (700.0 - STANDARD_GRAVITY) * 1e-3).abs() < 1e-9);
    // The swivel of the library machine: weight times lever of everything on it.
    let u5 = library().into_iter().find(|m| m.name.starts_with("Spinner")).expect("the machine");
    let tree = RigidTree::new(&u5);
    let b = u5.joint("B").expect("B");
    let carried: f64 = u5
        .bodies
        .iter()
        .filter(|m| matches!(m.attached_to, Attachment::Joint(j) if j == b || u5.joints[j].name == "C"))
        .filter_map(|m| m.mass)
        .map(|m| m.mass * (m.center.z - 120.0))
        .sum();
    for degrees in [0.0_f64, 30.0, 90.0] {
        let mut q = u5.home();
        q[b] = degrees.to_radians();
        let tau = tree.inverse_dynamics(&q, &JointValues::ZERO, &JointValues::ZERO);
        // A table axis turns by -B about +y: a center at (0, 0, -l) goes to x = l sin B, z = -l cos B.
        let lever = -carried * degrees.to_radians().sin() * STANDARD_GRAVITY * 1e-3;
        assert!((tau[b] - lever).abs() < 1e-6, "{degrees}: {} {lever}", tau[b]);
    }
}

/// The gate of the issue: joint forces and accelerations within 1 percent; in fact far nearer.
#[test]
fn rapier_agrees_on_accelerations_and_forces() {
    let step = 1e-5;
    for machine in library().into_iter().chain([skew()]) {
        let tree = RigidTree::new(&machine);
        let armature = JointValues::ZERO;
        let mut plant = RapierPlant::new(&tree, step, &armature).unwrap_or_else(|e| panic!("{e}"));
        let mut random = Random::new(5);
        let mut worst = 0.0_f64;
        for _ in 0..40 {
            let [q, v, a] = state(&machine, &mut random);
            let tau = tree.inverse_dynamics(&q, &v, &a);
            plant.place(&q, &v);
            assert!((plant.position() - q).max_abs() < 1e-9, "{:?} {q:?}", plant.position());
            assert!((plant.velocity() - v).max_abs() < 1e-9);
            plant.step(&tau);
            let got = (plant.velocity() - v) * (1.0 / step);
            // What the difference of accelerations costs in force, against the force itself.
            let missing = tree.mass_matrix(&q) * nalgebra::SVector::from((got - a).0) * 1e-3;
            for j in 0..machine.joints.len() {
                let (force, acceleration) = if machine.joints[j].is_rotary() { (1e4, 1.0) } else { (100.0, 100.0) };
                worst = worst.max(missing[j].abs() / tau[j].abs().max(force));
                worst = worst.max((got[j] - a[j]).abs() / a[j].abs().max(acceleration));
            }
        }
        println!("{}: Rapier and Newton-Euler differ by {worst:.2e}", machine.name);
        assert!(worst < 0.01, "{}: {worst}", machine.name);
    }
}

/// A long body has two nearly equal principal inertias: its axes must be found well enough that it turns
/// about the long one with the small third.
#[test]
fn a_long_body_turns_about_its_long_axis_with_its_own_inertia() {
    let mut machine = skew();
    let body = machine.bodies.iter_mut().find(|b| b.name == "body A").expect("body");
    let mass = body.mass.as_mut().expect("a mass");
    mass.inertia = Matrix3::new(0.26, 0.003, -0.002, 0.003, 20.0, 0.001, -0.002, 0.001, 20.02) * 1e6;
    let tree = RigidTree::new(&machine);
    let step = 1e-5;
    let mut plant = RapierPlant::new(&tree, step, &JointValues::ZERO).expect("masses");
    let mut random = Random::new(6);
    for _ in 0..20 {
        let [q, v, a] = state(&machine, &mut random);
        plant.place(&q, &v);
        plant.step(&tree.inverse_dynamics(&q, &v, &a));
        let got = (plant.velocity() - v) * (1.0 / step);
        for j in 0..machine.joints.len() {
            let size = if machine.joints[j].is_rotary() { 1.0 } else { 100.0 };
            assert!((got[j] - a[j]).abs() < 0.01 * a[j].abs().max(size), "{j}: {} {}", got[j], a[j]);
        }
    }
}

/// Along a smooth random motion, against the largest force of each joint in it: three sines a joint that
/// together keep within half the travel, velocity and acceleration of the joint.
#[test]
fn rapier_agrees_along_a_smooth_motion() {
    let step = 1e-5;
    for machine in library() {
        let tree = RigidTree::new(&machine);
        let mut plant = RapierPlant::new(&tree, step, &JointValues::ZERO).unwrap_or_else(|e| panic!("{e}"));
        let mut random = Random::new(8);
        let n = machine.joints.len();
        // Amplitude, angular frequency and phase of each sine.
        let mut sines = vec![[[0.0; 3]; 3]; n];
        let mut middle = JointValues::ZERO;
        for (j, joint) in machine.joints.iter().enumerate() {
            let [low, high] = joint.travel.unwrap_or([-3.0, 3.0]);
            middle[j] = 0.5 * (low + high);
            for sine in &mut sines[j] {
                let w = random.range(1.0, 12.0);
                let size = (0.25 * (high - low))
                    .min(0.5 * joint.max_velocity.expect("a limit") / w)
                    .min(0.5 * joint.max_acceleration.expect("a limit") / (w * w));
                *sine = [size / 3.0 * random.range(0.5, 1.0), w, random.range(0.0, 6.3)];
            }
        }
        let motion = |t: f64| {
            let mut out = [middle, JointValues::ZERO, JointValues::ZERO];
            for j in 0..n {
                for [size, w, phase] in sines[j] {
                    let (s, c) = (w * t + phase).sin_cos();
                    out[0][j] += size * s;
                    out[1][j] += size * w * c;
                    out[2][j] -= size * w * w * s;
                }
            }
            out
        };
        let (mut largest, mut apart) = ([0.0_f64; MAX_JOINTS], [0.0_f64; MAX_JOINTS]);
        for k in 0..100 {
            let [q, v, a] = motion(f64::from(k) * 0.05);
            let tau = tree.inverse_dynamics(&q, &v, &a);
            plant.place(&q, &v);
            plant.step(&tau);
            let got = (plant.velocity() - v) * (1.0 / step);
            // Force that Rapier would have taken for the wanted acceleration, less that of Newton-Euler.
            let missing = tree.mass_matrix(&q) * nalgebra::SVector::from((got - a).0) * 1e-3;
            for j in 0..n {
                largest[j] = largest[j].max(tau[j].abs());
                apart[j] = apart[j].max(missing[j].abs());
            }
        }
        let worst = (0..n).map(|j| apart[j] / largest[j]).fold(0.0, f64::max);
        println!("{}: forces differ by {worst:.2e} of the largest along the motion", machine.name);
        assert!(worst < 0.01, "{}: {worst}: {apart:?} of {largest:?}", machine.name);
    }
}

/// A free swing over a tenth of a second at the step that a run takes, against own forward dynamics
/// (Runge-Kutta).
#[test]
fn rapier_swings_as_newton_euler() {
    for machine in library().into_iter().chain([skew()]) {
        let tree = RigidTree::new(&machine);
        let n = machine.joints.len();
        let mut armature = JointValues::ZERO;
        for j in 0..n {
            armature[j] = if machine.joints[j].is_rotary() { 2e6 } else { 50.0 };
        }
        let mut q = machine.home();
        let mut v = JointValues::ZERO;
        for j in 0..n {
            if machine.joints[j].is_rotary() {
                (q[j], v[j]) = (0.8, 2.0);
            } else {
                v[j] = 100.0;
            }
        }
        let tau = tree.inverse_dynamics(&machine.home(), &JointValues::ZERO, &JointValues::ZERO);
        let mut plant = RapierPlant::new(&tree, RapierPlant::LONGEST_STEP, &armature).expect("masses");
        plant.place(&q, &v);
        for _ in 0..1000 {
            plant.step(&tau);
        }
        let h = 1e-4;
        let rate = |q: &JointValues, v: &JointValues| tree.forward_dynamics(q, v, &tau, &armature).expect("masses");
        for _ in 0..1000 {
            let (k1v, k1a) = (v, rate(&q, &v));
            let (k2v, k2a) = (v + k1a * (0.5 * h), rate(&(q + k1v * (0.5 * h)), &(v + k1a * (0.5 * h))));
            let (k3v, k3a) = (v + k2a * (0.5 * h), rate(&(q + k2v * (0.5 * h)), &(v + k2a * (0.5 * h))));
            let (k4v, k4a) = (v + k3a * h, rate(&(q + k3v * h), &(v + k3a * h)));
            q = q + (k1v + k2v * 2.0 + k3v * 2.0 + k4v) * (h / 6.0);
            v = v + (k1a + k2a * 2.0 + k3a * 2.0 + k4a) * (h / 6.0);
        }
        let off = plant.position() - q;
        println!("{}: after 0.1 s {off:?} of {q:?}", machine.name);
        for j in 0..n {
            // Way of the swing: some 10 mm and 0.2 rad; the library is of first order in 25 us.
            let bound = if machine.joints[j].is_rotary() { 2e-4 } else { 2e-2 };
            assert!(off[j].abs() < bound, "{} {j}: {}", machine.name, off[j]);
        }
    }
}

#[test]
fn what_is_not_known_is_reported() {
    let mut machine = skew();
    let without = machine.bodies.iter().position(|b| b.name == "body A").expect("body");
    machine.bodies[without].mass = None;
    let tree = RigidTree::new(&machine);
    let unknown: Vec<&str> = tree.report().unknown.iter().map(|(j, _)| machine.joints[*j].name.as_str()).collect();
    assert_eq!(unknown, ["C", "Z", "A"], "all that carry the body");
    assert!(tree.report().unknown.iter().all(|(_, why)| why.contains("body A has no mass")));
    assert!(RapierPlant::new(&tree, 1e-4, &JointValues::ZERO).is_err());
    let mut machine = skew();
    machine.up = None;
    let tree = RigidTree::new(&machine);
    assert!(tree.report().unknown.iter().all(|(_, why)| why.contains("up")) && !tree.knows(0));
    let tree = RigidTree::new(&skew());
    assert!(RapierPlant::new(&tree, 1e-3, &JointValues::ZERO).is_err_and(|e| e.contains("0.0001")));
}
