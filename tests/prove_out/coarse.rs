//! Every published experiment at coarse cells: the same bytes at one and at two threads, and the page of the experiments tells of these inputs.
//!
//! Cells change what is seen of the cut part, and nothing of the motion. Choices are left out, which take most of the time and are tried on the motion alone.

use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_sim::{
    compare::{CompareChoice, Comparing, Comparison},
    run::run_with_surface,
};
use proveout_tests::root;

/// Distance of the rays, mm, by scene: points on them are exact whatever it is, and a comparison wants a few hundred.
fn cells(scene: &str) -> f64 {
    match scene {
        "scenes/dong-2023-multi-scale" => 2.0,
        "scenes/cui-2022-singularity" | "scenes/ma-2020-sine" => 1.0,
        _ => 1.5,
    }
}

/// Files of the experiments, as `docs/figures.toml` names them.
fn experiments() -> Vec<String> {
    let text = fs::read_to_string(root().join("docs/figures.toml")).expect("the registry");
    let table: toml::Table = text.parse().expect("TOML");
    let runs = table["run"].as_array().expect("runs");
    let wanted = runs.iter().filter(|r| r.get("experiment").and_then(toml::Value::as_bool) == Some(true));
    let commands = wanted.map(|r| r["command"].as_str().expect("a command"));
    commands.map(|c| c.strip_prefix("compare ").expect("a comparison without options").to_owned()).collect()
}

fn compared(path: &Path, cells: f64, threads: usize) -> Comparison {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let choice = CompareChoice { resolution_mm: Some(cells), without_choices: true, ..CompareChoice::default() };
    pool.install(|| {
        let mut comparing = Comparing::read(path, &choice).unwrap_or_else(|e| panic!("{e}"));
        comparing.vary(&|_, _| {}).unwrap_or_else(|e| panic!("{e}"));
        for name in comparing.order().iter().filter(|_| !comparing.motion_only()).cloned().collect::<Vec<_>>() {
            let prepared = comparing.take(&name).expect("taken once");
            let (result, surface) =
                run_with_surface(prepared, Vec::new(), Path::new(".")).unwrap_or_else(|e| panic!("{name}: {e}"));
            comparing.add(&name, result, &surface);
        }
        comparing.finish().expect("every program was run").comparison
    })
}

/// What the page has under the heading of a scene.
fn section(page: &str, scene: &str) -> String {
    let from =
        page.split_once(&format!("## {scene}\n")).unwrap_or_else(|| panic!("docs/experiments.md has no {scene}")).1;
    from.split("\n## ").next().unwrap_or(from).to_owned()
}

/// The page tells of these inputs, and of this motion.
fn is_fresh(page: &str, c: &Comparison) {
    let section = section(page, &c.scene);
    let remedy = "make it again: cargo xtask figures --run NAME";
    for (name, program) in &c.programs {
        for (role, digest) in &program.digests {
            let short: String = digest.chars().take(12).collect();
            assert!(section.contains(&format!("`{short}`")), "{}: {role} of {name} has changed; {remedy}", c.scene);
        }
        let Some(stretch) = &program.stretch else { continue };
        let time = format!("{:.3} |", stretch.time_s);
        assert!(
            section.lines().any(|l| l.starts_with(&format!("| {name} |")) && l.contains(&time)),
            "{}: {name} takes {time} s; {remedy}",
            c.scene
        );
        for (joint, axis) in &stretch.axes {
            let row = format!("| {joint}, {} | {name} |", axis.unit);
            assert!(
                section.lines().any(|l| l.starts_with(&row) && l.ends_with(&format!(" {} |", axis.reversals))),
                "{}: {row}; {remedy}",
                c.scene
            );
        }
    }
}

/// The same bytes, and what the page tells if the registry puts the scene on it.
fn at_any_thread_count(scene: &str) {
    let path: PathBuf = root().join(scene);
    let path = if path.is_dir() { path.join("scene.toml") } else { path };
    let bytes = |c: &Comparison| serde_json::to_string_pretty(c).expect("JSON");
    let two = compared(&path, cells(scene), 2);
    let one = compared(&path, cells(scene), 1);
    assert_eq!(bytes(&one), bytes(&two), "{scene}");
    if experiments().iter().any(|e| e == scene) {
        let page = fs::read_to_string(root().join("docs/experiments.md")).expect("the page");
        is_fresh(&page, &two);
    }
}

#[test]
fn every_experiment_has_its_test() {
    for experiment in experiments() {
        assert!(
            TESTED.contains(&experiment.as_str()),
            "{experiment} is on the page, and nothing holds the page against it"
        );
    }
}

macro_rules! experiments {
    ($($name:ident $scene:literal),* $(,)?) => {
        const TESTED: &[&str] = &[$($scene),*];
        $(
            #[test]
            fn $name() {
                at_any_thread_count($scene);
            }
        )*
    };
}

experiments! {
    li "scenes/li-2022-s-theta",
    cui "scenes/cui-2022-singularity",
    ma "scenes/ma-2020-sine",
    ma_steep "scenes/ma-2020-sine/ma-1.toml",
    lu "scenes/lu-2022-quasi-circle",
    lu_serial "scenes/lu-2022-quasi-circle/serial.toml",
    lu_whole_lines "scenes/lu-2022-quasi-circle/whole-lines.toml",
    lu_whole_lines_serial "scenes/lu-2022-quasi-circle/whole-lines-serial.toml",
    lu_untwisted "scenes/lu-2022-quasi-circle/untwisted.toml",
    lu_edge "scenes/lu-2022-quasi-circle/edge.toml",
    dong "scenes/dong-2023-multi-scale",
}
