//! Machine bodies of neighboring joints: shipped machines through their travels, and crashes at places of
//! closed form.

use std::path::{Path, PathBuf};

use proveout_collision::{Interference, Severity, Unchecked};
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, cylinder_mesh};
use proveout_machine::{Attachment, JointValues, Machine, MachineBody};

fn machines() -> Vec<(String, Machine)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(root).expect("machines").map(|e| e.expect("entry").path()).collect();
    folders.retain(|p| p.is_dir());
    folders.sort();
    let name = |p: &Path| p.file_name().expect("name").to_string_lossy().into_owned();
    folders.iter().map(|p| (name(p), Machine::read(p).unwrap_or_else(|e| panic!("{e}")))).collect()
}

/// From home each joint through its travel alone: nothing is invented where bodies bear on each other, and no
/// body is left out as a whole but those that do nothing else, as carriages round their rails.
#[test]
fn neighbors_of_shipped_machines_keep_clear_of_each_other() {
    let (mut checked, mut guides) = (0, 0);
    // The machines with another zero look like their namesakes.
    for (name, machine) in machines().into_iter().filter(|(name, _)| !name.ends_with("home-zero")) {
        let mut check = Interference::new(&machine, &[], 0.5).unwrap_or_else(|e| panic!("{name}: {e}"));
        checked += check.pairs().iter().filter(|p| p.bearing > 0.0).count();
        // By role or shape: nothing that is swallowed is passed over.
        guides += check.pairs().iter().filter(|p| p.unchecked == Some(Unchecked::Guide)).count();
        let swallowed: Vec<_> = check.pairs().iter().filter(|p| p.unchecked == Some(Unchecked::Neighbors)).collect();
        assert!(swallowed.is_empty(), "{name}: {swallowed:?}");
        let home = machine.home();
        let mut time = 0.0;
        let mut go = |from: &JointValues, to: &JointValues| {
            check.check_piece(from, to, [time, time + 1.0], 0.0);
            time += 1.0;
        };
        go(&home, &home);
        for (j, joint) in machine.joints.iter().enumerate() {
            let full = std::f64::consts::TAU;
            let [low, high] = joint.travel.unwrap_or([0.0, full]);
            let ends = if joint.is_rotary() { [low.max(-full), high.min(full)] } else { [low, high] };
            for end in ends {
                let mut to = home;
                to[j] = end;
                go(&home, &to);
                go(&to, &home);
            }
        }
        let breaches: Vec<String> = check.breaches().iter().map(|b| format!("{b:?}")).collect();
        assert!(breaches.is_empty(), "{name}: {} breaches, first {}", breaches.len(), breaches[0]);
    }
    assert!(checked >= 40, "{checked} pairs of neighbors that bear on each other");
    assert!(guides >= 20, "{guides} pairs of which nothing is left");
}

/// Z in the tool; Y and A about x in the table.
fn machine(bodies: impl Fn(&Machine) -> Vec<MachineBody>) -> Machine {
    let text = "name = \"test\"\n\
        [[joint]]\nname = \"Z\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"base\"\ndirection = [0, 0, 1]\ntravel_mm = [0, 900]\n\
        [[joint]]\nname = \"Y\"\nkind = \"linear\"\ncarries = \"workpiece\"\nparent = \"base\"\ndirection = [0, 1, 0]\ntravel_mm = [-600, 600]\n\
        [[joint]]\nname = \"A\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"Y\"\ndirection = [1, 0, 0]\npoint_mm = [0, 0, 0]\nsense = 1\n\
        [spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n\
        [table]\non = \"A\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
        [control]\ncycle_time_ms = 2\nblock_time_ms = 1\nrapid_mode = \"straight\"\ntool_change_time_s = 5\ndefault_tolerance_mm = 0.01\n";
    let mut m = Machine::from_text(Path::new("test.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    m.bodies = bodies(&m);
    m
}

fn body(machine: &Machine, name: &str, on: Option<&str>, mesh: TriMesh) -> MachineBody {
    let attached_to = on.map_or(Attachment::Base, |j| Attachment::Joint(machine.joint(j).expect("joint")));
    MachineBody { name: name.into(), role: name.into(), attached_to, mesh, mass: None, color: [0; 4], check: true }
}

fn block(min: [f64; 3], max: [f64; 3]) -> TriMesh {
    box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) })
}

fn together(parts: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    parts.iter().for_each(|p| all.append(p));
    all
}

/// A trunnion whose journals run in solid bearings of its carriage, with an arm of 200 x 20 mm from the axis,
/// over a cover of the carriage.
fn trunnion(cover: f64) -> Machine {
    machine(|m| {
        let along_x = Pose::from_axis_angle(&Vector::y(), std::f64::consts::FRAC_PI_2);
        let bearing = |x: f64| block([x - 20.0, -60.0, -60.0], [x + 20.0, 60.0, 60.0]);
        let carriage = [bearing(-150.0), bearing(150.0), block([-170.0, -300.0, cover - 40.0], [170.0, 300.0, cover])];
        let journals = cylinder_mesh(30.0, -170.0, 170.0, 48).transformed(&along_x);
        let arm = block([-90.0, 0.0, -20.0], [90.0, 200.0, 20.0]);
        vec![
            body(m, "carriage", Some("Y"), together(&carriage)),
            body(m, "trunnion", Some("A"), together(&[journals, arm])),
        ]
    })
}

fn turn(machine: &Machine, end: f64, pieces: u32) -> Interference {
    let mut check = Interference::new(machine, &[], 0.0).expect("solids");
    assert!(check.pairs().iter().all(|p| p.unchecked.is_none()), "{:?}", check.pairs());
    let (a, y) = (machine.joint("A").expect("A"), machine.joint("Y").expect("Y"));
    let at = |k: u32| {
        let mut q = JointValues::ZERO;
        // The other joint moves along, which changes nothing between the two.
        (q[a], q[y]) = (end * f64::from(k) / f64::from(pieces), 0.4 * f64::from(k));
        q
    };
    for k in 0..pieces {
        check.check_piece(&at(k), &at(k + 1), [f64::from(k), f64::from(k + 1)], 0.0);
    }
    check
}

#[test]
fn a_trunnion_that_turns_into_its_own_cover_is_found_at_its_angle() {
    let (radius, corner) = (200.0_f64.hypot(20.0), (20.0_f64 / 200.0).atan());
    for cover in [-60.0, -120.0, -190.0, -200.0] {
        let angle = (-cover / radius).asin() - corner;
        for pieces in [1, 700] {
            // The arm goes down for a negative angle.
            let check = turn(&trunnion(cover), -3.0, pieces);
            let hit = check.breaches().first().unwrap_or_else(|| panic!("{cover} is hit"));
            let exact = angle / 3.0 * f64::from(pieces);
            let early = (exact - hit.time) * 3.0 / f64::from(pieces);
            assert_eq!((&*hit.bodies[0], hit.severity), ("carriage", Severity::Collision));
            // 0.2 micrometers, at the angle at which the corner comes down.
            let tolerance = 2.2e-4 / (radius * (angle + corner).cos());
            assert!((-1e-12..=tolerance).contains(&early), "{cover} {pieces}: early by {early}");
        }
    }
    // Past the lowest place of the corner by a micrometer.
    assert!(turn(&trunnion(-radius - 1e-3), -3.0, 100).breaches().is_empty());
    assert!(!turn(&trunnion(-radius + 1e-3), -3.0, 100).breaches().is_empty());
}

#[test]
fn what_is_proved_of_neighbors_is_not_asked_for_again() {
    let mut check = turn(&trunnion(-400.0), -0.5, 50);
    let first = check.queries();
    let (from, to) = (JointValues([0.0, 20.0, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0]), JointValues::ZERO);
    for k in 0..1000_u32 {
        let (a, b) = if k % 2 == 0 { (&from, &to) } else { (&to, &from) };
        check.check_piece(a, b, [50.0 + f64::from(k), 51.0 + f64::from(k)], 0.0);
    }
    assert!(check.breaches().is_empty());
    assert!(check.queries() <= first + 2, "{} after {first}", check.queries());
    assert!(check.effort().share_by_allowance() > 0.9, "{:?}", check.effort());
}

/// A carriage drawn into its guide runs against a stop next to the guide.
#[test]
fn a_carriage_that_runs_against_its_stop_is_found_at_its_place() {
    let at = |stop: f64| {
        machine(|m| {
            let guide = block([-40.0, -500.0, -100.0], [40.0, 700.0, 0.0]);
            let post = block([65.0, stop, -100.0], [90.0, stop + 30.0, 40.0]);
            let carriage =
                [block([-60.0, -80.0, -30.0], [60.0, 80.0, 60.0]), block([55.0, -50.0, 10.0], [100.0, 50.0, 50.0])];
            vec![body(m, "bed", None, together(&[guide, post])), body(m, "carriage", Some("Y"), together(&carriage))]
        })
    };
    let y = 1;
    let mut far = JointValues::ZERO;
    far[y] = 600.0;
    let mut check = Interference::new(&at(350.0), &[], 0.0).expect("solids");
    check.check_piece(&JointValues::ZERO, &far, [0.0, 600.0], 0.0);
    let hit = check.breaches().first().expect("hit");
    assert!((0.0..=3e-4).contains(&(300.0 - hit.time)), "{}", hit.time);
    let mut check = Interference::new(&at(650.001), &[], 0.0).expect("solids");
    check.check_piece(&JointValues::ZERO, &far, [0.0, 600.0], 0.0);
    assert!(check.breaches().is_empty(), "{:?}", check.breaches());
}

/// A stop of any height on the rail of a slide, screwed on from above or from a side: it is met at its place,
/// however low it is. The zone that is left out round what bears would swallow it.
#[test]
fn a_stop_on_the_rail_is_found_at_its_place() {
    for (k, height) in [2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0, 25.0].into_iter().enumerate() {
        for (side, far) in [(false, 150.0), (true, 90.0), (false, 300.0)] {
            let machine = machine(|m| {
                let rail = block([-10.0, -400.0, -300.0], [10.0, 400.0, -200.0]);
                let stop = if side {
                    block([10.0, far, -206.0 - height], [10.0 + height, far + 20.0, -206.0])
                } else {
                    block([-10.0, far, -200.0], [10.0, far + 20.0, -200.0 + height])
                };
                // It runs on the rail and grips it from both sides.
                let carriage = [
                    block([-40.0, -50.0, -200.0], [40.0, 50.0, -120.0]),
                    block([10.0, -50.0, -260.0], [40.0, 50.0, -200.0]),
                    block([-40.0, -50.0, -260.0], [-10.0, 50.0, -200.0]),
                ];
                vec![body(m, "bed", None, together(&[rail, stop])), body(m, "carriage", Some("Y"), together(&carriage))]
            });
            let mut to = JointValues::ZERO;
            to[1] = far + 10.0;
            let mut check = Interference::new(&machine, &[], 0.0).expect("solids");
            check.check_piece(&JointValues::ZERO, &to, [0.0, to[1]], 0.0);
            let hit = check.breaches().first().unwrap_or_else(|| panic!("{k}: {height} {side} {far} is hit"));
            let exact = far - 50.0;
            assert!((0.0..=3e-4).contains(&(exact - hit.time)), "{height} {side} {far}: {} of {exact}", hit.time);
            // Up to a micrometer before it.
            to[1] = exact - 1e-3;
            let mut check = Interference::new(&machine, &[], 0.0).expect("solids");
            check.check_piece(&JointValues::ZERO, &to, [0.0, to[1]], 0.0);
            assert!(check.breaches().is_empty(), "{height} {side} {far}: {:?}", check.breaches());
        }
    }
}

/// A rail in pieces of its own, and screws that are sunk in it: the slide runs over all of them.
#[test]
fn a_rail_in_pieces_is_no_stop() {
    let machine = machine(|m| {
        let pieces = (-4..4).map(|k| {
            let y = 100.0 * f64::from(k);
            block([-10.0, y, -212.0], [10.0, y + 99.5, -200.0])
        });
        let screws = (-4..4).map(|k| {
            let y = 100.0 * f64::from(k) + 50.0;
            cylinder_mesh(4.0, -208.0, -201.0, 16).transformed(&Pose::from_translation(Vector::new(0.0, y, 0.0)))
        });
        let bed: Vec<TriMesh> =
            pieces.chain(screws).chain([block([-60.0, -450.0, -300.0], [60.0, 450.0, -212.0])]).collect();
        // Drawn into the rail by half a millimeter, as bodies of slides often are.
        let carriage = block([-40.0, -50.0, -200.5], [40.0, 50.0, -120.0]);
        vec![body(m, "bed", None, together(&bed)), body(m, "carriage", Some("Y"), carriage)]
    });
    let mut check = Interference::new(&machine, &[], 0.0).expect("solids");
    let at = |y: f64| {
        let mut q = JointValues::ZERO;
        q[1] = y;
        q
    };
    for (k, w) in [0.0, 340.0, -340.0, 0.0].windows(2).enumerate() {
        check.check_piece(&at(w[0]), &at(w[1]), [k as f64, k as f64 + 1.0], 0.0);
    }
    assert!(check.breaches().is_empty(), "{:?}", check.breaches());
}
