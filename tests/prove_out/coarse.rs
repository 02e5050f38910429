//! Every published experiment, coarse: the page of the experiments describes these inputs and this motion,
//! and a comparison has the same bytes at one and at two threads.
//!
//! *Page.* All programs whole, as motion alone: neither cells nor the mesh of the design change it. *Bytes.*
//! The first blocks of the programs at coarse cells, with every step of a comparison but choices, which take
//! most of the time and are tried on the motion alone, and roughness maps.

use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_sim::{
    compare::{CompareChoice, Comparing, Comparison},
    digest,
    run::run_with_surface,
};
use proveout_tests::root;
use toml::{Table, Value};

/// Distance of the rays, mm: points on them are exact whatever it is, and a comparison wants a few hundred.
const CELLS_MM: f64 = 2.0;
/// Chord error of the mesh of a design, mm: looks of a scene at its mesh take most of the time of a coarse
/// run.
const CHORD_MM: f64 = 0.01;
/// Bound of the pieces of motion, mm.
const PIECES_MM: f64 = 0.001;

/// What is kept of a scene for the bytes.
#[derive(Clone, Copy)]
struct Coarse {
    /// First motions of each program; the whole where a method wants whole layers or rows.
    blocks: usize,
    /// Chord error of the design's mesh where a method looks at it, mm.
    chord: Option<f64>,
}

/// Files of the experiments, as `docs/figures.toml` names them.
fn experiments() -> Vec<String> {
    let text = fs::read_to_string(root().join("docs/figures.toml")).expect("the registry");
    let table: Table = text.parse().expect("TOML");
    let runs = table["run"].as_array().expect("runs");
    let wanted = runs.iter().filter(|r| r.get("experiment").and_then(Value::as_bool) == Some(true));
    let commands = wanted.map(|r| r["command"].as_str().expect("a command"));
    commands.map(|c| c.strip_prefix("compare ").expect("a comparison without options").to_owned()).collect()
}

/// What the page has under the heading of a scene.
fn section(page: &str, scene: &str) -> String {
    let from = page.split_once(&format!("## {scene}\n")).unwrap_or_else(|| panic!("docs/experiments has no {scene}")).1;
    from.split("\n## ").next().unwrap_or(from).to_owned()
}

/// The page describes these inputs, and this motion; `scene` is the digest of the scene's own text.
fn is_fresh(page: &str, c: &Comparison, scene: &str) {
    let section = section(page, &c.scene);
    let remedy = "make it again: cargo xtask figures --run NAME";
    for (name, program) in &c.programs {
        for (role, digest) in &program.digests {
            // The scene that ran is a copy.
            let digest = if role == "scene" { scene } else { digest };
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

/// A scene in a folder of its own.
struct Copied {
    folder: tempfile::TempDir,
    digest: String,
}

impl Copied {
    /// The scene with a coarse mesh of its design; `change` edits it, `text` each program.
    fn new(path: &Path, coarse: Coarse, change: impl Fn(&mut Table), text: impl Fn(&str) -> String) -> Self {
        let source = fs::read_to_string(path).expect("a scene");
        let beside = path.parent().expect("a folder");
        let mut scene: Table = source.parse().expect("TOML");
        if let Some(blade) = table(&mut scene, &["part", "blade"]) {
            let chord = coarse.chord.unwrap_or(CHORD_MM);
            blade.insert("chord_error_mm".into(), chord.into());
        }
        scene.remove("surface");
        change(&mut scene);
        let folder = tempfile::tempdir().expect("a folder");
        for (key, value) in &mut scene {
            absolute(beside, key, value);
        }
        for program in scene.get_mut("program").and_then(Value::as_array_mut).expect("programs") {
            let Some(Value::String(file)) = program.get_mut("file") else { continue };
            let from = PathBuf::from(&*file);
            let to = folder.path().join(from.file_name().expect("a name"));
            fs::write(&to, text(&fs::read_to_string(&from).expect("a program"))).expect("written");
            *file = to.display().to_string();
        }
        fs::write(folder.path().join("scene.toml"), toml::to_string(&scene).expect("a table")).expect("written");
        Self { folder, digest: digest::of_bytes(source.as_bytes()) }
    }

    /// The comparison of it; of the motion alone without its variations.
    fn compared(&self, threads: usize, varied: bool) -> Comparison {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let choice = CompareChoice { resolution_mm: Some(CELLS_MM), without_choices: true, ..CompareChoice::default() };
        pool.install(|| {
            let mut comparing = Comparing::read(self.folder.path(), &choice).unwrap_or_else(|e| panic!("{e}"));
            if varied {
                comparing.vary(&|_, _| {}).unwrap_or_else(|e| panic!("{e}"));
            } else {
                comparing.execute(&|| ()).unwrap_or_else(|e| panic!("{e}"));
            }
            for name in comparing.order().iter().filter(|_| !comparing.motion_only()).cloned().collect::<Vec<_>>() {
                let prepared = comparing.take(&name).expect("taken once");
                let (result, surface) =
                    run_with_surface(prepared, Vec::new(), Path::new(".")).unwrap_or_else(|e| panic!("{name}: {e}"));
                comparing.add(&name, result, &surface);
            }
            comparing.finish().expect("every program was run").comparison
        })
    }
}

/// A table below others; none where one of them is not there.
fn table<'a>(scene: &'a mut Table, path: &[&str]) -> Option<&'a mut Table> {
    path.iter().try_fold(scene, |table, key| table.get_mut(*key)?.as_table_mut())
}

/// Files of a scene, from wherever it lies.
fn absolute(beside: &Path, key: &str, value: &mut Value) {
    match value {
        Value::String(text) if matches!(key, "machine" | "tools" | "file" | "sections") => {
            *text = beside.join(&*text).display().to_string();
        }
        Value::Table(table) => table.iter_mut().for_each(|(key, value)| absolute(beside, key, value)),
        Value::Array(all) => all.iter_mut().for_each(|value| absolute(beside, key, value)),
        _ => {}
    }
}

/// The first motions of a program and its end, from the last way out on.
fn first_motions(text: &str, motions: usize) -> String {
    let all: Vec<&str> = text.lines().collect();
    let tail = all.iter().rposition(|l| l.starts_with("G0 ")).expect("a way out");
    let moves = |l: &str| l.starts_with('X') || l.starts_with("G1 X") || l.starts_with("G0 X");
    let last = all.iter().enumerate().filter(|(_, l)| moves(l)).map(|(i, _)| i).nth(motions).unwrap_or(tail);
    all[..last.min(tail)].iter().chain(&all[tail..]).map(|l| format!("{l}\n")).collect()
}

/// All pages of the experiments.
fn pages() -> String {
    let folder = fs::read_dir(root().join("docs/experiments")).expect("a folder");
    let paths = folder.map(|entry| entry.expect("an entry").path());
    paths.map(|path| fs::read_to_string(path).expect("a page")).collect()
}

/// What the page says if the registry puts the scene on it, and the same bytes at any number of threads.
fn held(scene: &str, coarse: Coarse) {
    let path: PathBuf = root().join(scene);
    let path = if path.is_dir() { path.join("scene.toml") } else { path };
    if experiments().iter().any(|e| e == scene) {
        let page = pages();
        let moved = |scene: &mut Table| {
            let compare = table(scene, &["compare"]).expect("a comparison");
            compare.insert("motion_only".into(), true.into());
        };
        let whole = Copied::new(&path, coarse, moved, str::to_owned);
        is_fresh(&page, &whole.compared(2, false), &whole.digest);
    }
    let shorter = |scene: &mut Table| {
        if let Some(control) = table(scene, &["control"]) {
            control.insert("piece_tolerance_mm".into(), PIECES_MM.into());
        }
    };
    let part = Copied::new(&path, coarse, shorter, |text| first_motions(text, coarse.blocks));
    let [one, two] = [1, 2].map(|threads| serde_json::to_string_pretty(&part.compared(threads, true)).expect("JSON"));
    assert_eq!(one, two, "{scene}");
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
    ($($(#[$mark:meta])* $name:ident $scene:literal $blocks:expr, $chord:expr;)*) => {
        const TESTED: &[&str] = &[$($scene),*];
        $(
            #[test]
            $(#[$mark])*
            fn $name() {
                held($scene, Coarse { blocks: $blocks, chord: $chord });
            }
        )*
    };
}

/// Methods that want whole layers or rows.
const WHOLE: usize = usize::MAX;

// Methods of Ma et al. look at the mesh of the design, the others at its closed form or at nothing that a
// coarse one changes.
experiments! {
    #[ignore = "nightly, 161 s"]
    li "scenes/li-2022-s-theta" 570, None;
    #[ignore = "nightly, 55 s"]
    cui "scenes/cui-2022-singularity" WHOLE, None;
    #[ignore = "nightly, 63 s"]
    ma "scenes/ma-2020-sine" WHOLE, Some(0.001);
    #[ignore = "nightly, 31 s"]
    ma_steep "scenes/ma-2020-sine/ma-1.toml" WHOLE, None;
    lu "scenes/lu-2022-quasi-circle" 60, None;
    #[ignore = "nightly, 59 s"]
    lu_serial "scenes/lu-2022-quasi-circle/serial.toml" 60, None;
    #[ignore = "nightly, 22 s"]
    lu_whole_lines "scenes/lu-2022-quasi-circle/whole-lines.toml" WHOLE, None;
    #[ignore = "nightly, 22 s"]
    lu_whole_lines_serial "scenes/lu-2022-quasi-circle/whole-lines-serial.toml" WHOLE, None;
    #[ignore = "nightly, 20 s"]
    lu_untwisted "scenes/lu-2022-quasi-circle/untwisted.toml" WHOLE, None;
    lu_edge "scenes/lu-2022-quasi-circle/edge.toml" 60, None;
    #[ignore = "nightly, 27 s"]
    lu_equal "scenes/lu-2022-quasi-circle/equal.toml" 60, None;
    #[ignore = "nightly, 62 s"]
    dong "scenes/dong-2023-multi-scale" 210, None;
    #[ignore = "nightly, 52 s"]
    blade_root "scenes/blade-root/methods.toml" 300, None;
}
