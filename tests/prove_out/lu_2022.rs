//! The experiment of Lu et al. 2022 on both of its machines: what lines near an edge ask of the joints, and
//! how deep they cut with drives in the loop, the platform's among them.

use std::{fs, path::Path};

use proveout_sim::{
    Choice,
    compare::{CompareChoice, Comparing, Depth, Stretch},
};
use proveout_tests::{prove, root, scene};

const NAME: &str = "lu-2022-quasi-circle";

fn moved(path: &Path) -> Comparing {
    let mut comparing = Comparing::read(path, &CompareChoice::default()).unwrap_or_else(|e| panic!("{e}"));
    comparing.execute(&|| ()).unwrap_or_else(|e| panic!("{e}"));
    comparing
}

fn close(name: &str, got: f64, wanted: f64, by: f64) {
    println!("{name}: {got:.4}, wanted {wanted} within {by}");
    assert!((got - wanted).abs() <= by, "{name}: {got} is not {wanted}");
}

fn stretch(all: &Comparing, program: &str) -> Stretch {
    all.stretch_of(program).unwrap_or_else(|| panic!("{program}: no stretch"))
}

/// Counts of another implementation (`tests/reference/lu_2022.py`): velocity at 500 mm/min and range of the
/// joint about the span, motion from turning.
#[test]
fn whole_lines_turn_the_joints_as_the_second_count_says() {
    let rate = |deg_mm: f64| deg_mm * 500.0 / 60.0;
    let all = moved(&scene(NAME).join("whole-lines.toml"));
    for (name, [velocity, range, turning]) in
        [("iso-parametric", [rate(4.124), 142.62, 1.456]), ("quasi-circle", [rate(0.510), 48.82, 0.157])]
    {
        let s = stretch(&all, name);
        // Blocks of 0.4 mm where the rate is highest: its peak is cut by less than a percent.
        close(name, s.axes["B"].demand_velocity.expect("known"), velocity, 0.01 * velocity);
        close(name, s.axes["B"].range, range, 0.05);
        close(name, s.from_turning.expect("three slides"), turning, 0.01 * turning);
        assert!(s.depth.is_none(), "nobody asks for it");
    }
    // With the span on C the other machine turns alike: its joints test the mapping, and its slides move
    // otherwise.
    let all = moved(&scene(NAME).join("whole-lines-serial.toml"));
    for (name, [velocity, turning]) in
        [("iso-parametric", [rate(4.124), 1.389]), ("quasi-circle", [rate(0.510), 0.156])]
    {
        let s = stretch(&all, name);
        close(name, s.axes["C"].demand_velocity.expect("known"), velocity, 0.01 * velocity);
        close(name, s.from_turning.expect("three slides"), turning, 0.01 * turning);
    }
    let all = moved(&scene(NAME).join("untwisted.toml"));
    for (name, deg_mm) in [("iso-parametric", 3.839), ("quasi-circle", 0.298)] {
        let velocity = stretch(&all, name).axes["B"].demand_velocity.expect("known");
        close(name, velocity, rate(deg_mm), 0.01 * rate(deg_mm));
    }
}

/// Paths from the one that keeps its depth best to the worst.
const ORDER: [&str; 4] = ["quasi-circle", "iso-planar", "iso-parametric", "transverse"];

fn depths(all: &Comparing) -> [Depth; 4] {
    ORDER.map(|name| {
        let depth = stretch(all, name).depth.unwrap_or_else(|| panic!("{name}: a ball, and asked for"));
        println!("{name}: {depth:.2?}");
        depth
    })
}

#[test]
#[ignore = "nightly, 29 s"]
fn unequal_drives_leave_depths_in_the_published_order_on_both_machines() {
    // Deviations of `tests/reference/lu_2022.py`: lags of first order after the posted blocks, without
    // limits of acceleration. Machine II, machine I.
    for (file, wanted) in [("scene.toml", [0.78, 4.13, 26.90, 71.23]), ("serial.toml", [1.25, 5.71, 35.68, 75.46])] {
        let all = moved(&scene(NAME).join(file));
        let found = depths(&all);
        assert!(found[0].deviation_um < 1.5, "{file}: {found:?}");
        for (pair, names) in found.windows(2).zip(ORDER.windows(2)) {
            assert!(pair[0].deviation_um < 0.8 * pair[1].deviation_um, "{file}: {names:?}");
        }
        for (depth, wanted) in found.iter().zip(wanted) {
            // The control slows down at corners and begins each line from rest, which the second count does
            // not: a tenth, and the micrometer's tenth of blocks.
            close(file, depth.deviation_um, wanted, 0.1 * wanted + 0.1);
            assert!(depth.places > 100 && depth.least_um < depth.mean_um && depth.mean_um < depth.most_um, "{depth:?}");
        }
    }
    let all = moved(&scene(NAME).join("equal.toml"));
    for (depth, name) in depths(&all).iter().zip(ORDER) {
        assert!(depth.deviation_um < 0.4, "{name}: equal lags shift the way in time alone: {depth:?}");
    }
}

#[test]
fn equal_gains_leave_nothing_on_machine_i_either() {
    let folder = tempfile::tempdir().expect("a folder");
    let from = scene(NAME);
    let beside = |text: String| text.replace("../../", &format!("{}/", root().display()));
    let mut machine = beside(fs::read_to_string(from.join("machine-i.toml")).expect("the machine"));
    for gain in [61, 64, 74, 38] {
        machine = machine.replace(&format!("position_gain_1_s = {gain}\n"), "position_gain_1_s = 60\n");
    }
    fs::write(folder.path().join("machine-i.toml"), machine).expect("written");
    let text = beside(fs::read_to_string(from.join("serial.toml")).expect("the scene"));
    fs::write(folder.path().join("scene.toml"), text).expect("written");
    for name in ORDER.into_iter().chain(["null"]) {
        let file = format!("serial-{name}.mpf");
        fs::copy(from.join(&file), folder.path().join(&file)).expect("copied");
    }
    for (depth, name) in depths(&moved(folder.path())).iter().zip(ORDER) {
        assert!(depth.deviation_um < 0.4 && (depth.mean_um - 200.0).abs() < 0.5, "{name}: {depth:?}");
    }
}

/// A plane that cuts the edge is worse than what the order of the paper has: the order holds next to the edge
/// alone.
#[test]
fn a_plane_through_the_edge_is_no_line_beside_it() {
    let all = moved(&scene(NAME).join("edge.toml"));
    let depth = stretch(&all, "iso-planar-edge").depth.expect("measured");
    println!("{depth:.2?}");
    // 28.8 by the second count without limits of acceleration; the control slows down before it turns round
    // the edge.
    close("through the edge", depth.deviation_um, 28.8, 6.0);
}

/// The deepest cut of the part is the deepest place of the path: rays of the part see the bottom of a groove
/// where they meet it.
#[test]
fn the_cut_part_is_as_deep_as_the_path_says() {
    let all = moved(&scene(NAME));
    let most = stretch(&all, "iso-parametric").depth.expect("measured").most_um - 200.0;
    let choice = Choice { program: Some("iso-parametric".into()), resolution_mm: Some(0.5), ..Choice::default() };
    let run = prove(&scene(NAME), &choice, 2).unwrap_or_else(|e| panic!("{e}"));
    let gouge = 1e3 * run.verdict.deviation.gouge_max_mm.expect("measured");
    println!("deepest place of the path {most:.2} um, of the cut part {gouge:.2} um");
    // A ray a tenth of a millimeter off the bottom misses less than a quarter of it.
    assert!(gouge < most + 1.0 && gouge > 0.7 * most, "{gouge} {most}");
}
