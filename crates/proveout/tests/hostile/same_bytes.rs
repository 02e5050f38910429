//! The same bytes from any working directory, however the scene is named, and with any number of threads:
//! every file of a run folder and of a comparison but `run.json` and a recording.

use std::{collections::BTreeMap, fs, path::Path};

use crate::hostile::workshop::{PROGRAM, Workshop, proveout, root};

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

fn same(what: &str, first: &BTreeMap<String, Vec<u8>>, found: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(first.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>(), "{what}");
    let other: Vec<&String> =
        found.iter().filter(|(name, bytes)| first[*name] != **bytes).map(|(name, _)| name).collect();
    assert!(other.is_empty(), "{what}: {other:?} have other bytes");
}

/// All files below a folder but those that may differ.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("there").flatten() {
        let (name, path) = (entry.file_name().to_string_lossy().into_owned(), entry.path());
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else if name != "run.json" {
            all.insert(name, fs::read(path).expect("read"));
        }
    }
    all
}

#[test]
fn the_same_bytes_come_from_everywhere_and_with_any_number_of_threads() {
    let shop = Workshop::new();
    // Findings with places, and a subprogram.
    shop.write("program.mpf", PROGRAM.replace("X10\n", "SUB1\nG0 X-15\n"));
    shop.write("SUB1.SPF", "G1 X10\nM17\n");
    let elsewhere = shop.path().join("machine");
    let scene = shop.path().display().to_string();
    let out = |name: &str| shop.path().join(name).display().to_string();
    let calls: [(&Path, &str, &str, &str); 4] = [
        (shop.path(), ".", "a", "1"),
        (&elsewhere, "..", "b", "2"),
        (&elsewhere, &scene, "c", "7"),
        (shop.path(), "scene.toml", "d", "1"),
    ];
    let mut first = None;
    for (folder, scene, name, threads) in calls {
        let output = proveout(folder, &["run", scene, "--output", &out(name), "--rerun", "off", "--threads", threads]);
        assert_eq!(output.code(), Some(1), "a rapid in material: {}", output.text);
        let found = files(&shop.path().join(name));
        let first = first.get_or_insert_with(|| found.clone());
        same(&format!("{scene} from {} with {threads} threads", folder.display()), first, &found);
    }
}

/// Every kind of file that a run writes, but the text of a re-scheduled program.
const ALL: [&str; 19] = [
    "blocks.parquet",
    "clearance.parquet",
    "deviation.glb",
    "manifest.json",
    "maps/middle.png",
    "maps/middle.sdf",
    "maps/middle.x3p",
    "maps/side.png",
    "maps/side.sdf",
    "maps/side.x3p",
    "part.glb",
    "report.html",
    "roughness.glb",
    "setup.html",
    "signals.parquet",
    "stock-patch-corner.dexel",
    "stock.dexel",
    "surface.parquet",
    "verdict.json",
];

#[test]
fn every_file_of_a_run_folder_has_the_same_bytes_with_any_number_of_threads() {
    let shop = Workshop::new();
    let from = root().join("scenes/face-mill-marks");
    for name in ["face.nc", "part.stl"] {
        fs::copy(from.join(name), shop.path().join(name)).expect("copied");
    }
    fs::copy(root().join("tools/face-mill-marks.toml"), shop.path().join("tools.toml")).expect("copied");
    let scene = fs::read_to_string(from.join("scene.toml")).expect("a scene of the tree");
    let machine = root().join("machines/three-axis-mill").display().to_string();
    let scene = scene
        .replace("../../machines/three-axis-mill", &machine)
        .replace("../../tools/face-mill-marks.toml", "tools.toml")
        .replace("resolution_mm = 0.25", "resolution_mm = 0.5")
        .replace("step_um = 10", "step_um = 100\nrandom_phases = 2")
        .replace("[stock]\n", "[stock]\nhistory = true\n")
        .replace(
            "[part]\n",
            "[[stock.patch]]\nname = \"corner\"\nmin_mm = [0, 1, -1]\nmax_mm = [10, 5, 0.5]\ncell_mm = 0.2\n\n[part]\n",
        );
    shop.write("scene.toml", scene);
    let elsewhere = shop.path().join("machine");
    let out = |name: &str| shop.path().join(name).display().to_string();
    let mut first: Option<BTreeMap<String, Vec<u8>>> = None;
    for (folder, scene, name, threads) in
        [(shop.path(), ".", "a", "1"), (&*elsewhere, "..", "b", "2"), (&*elsewhere, "../scene.toml", "c", "7")]
    {
        let output = proveout(folder, &["run", scene, "--output", &out(name), "--rerun", "off", "--threads", threads]);
        assert!(matches!(output.code(), Some(0 | 1 | 3)), "{}", output.text);
        let found = files(&shop.path().join(name));
        assert_eq!(found.keys().map(String::as_str).collect::<Vec<_>>(), ALL, "a new file has its place in this list");
        let first = first.get_or_insert_with(|| found.clone());
        same(&format!("{scene} from {} with {threads} threads", folder.display()), first, &found);
    }
}

#[test]
fn a_comparison_has_the_same_bytes_from_everywhere_and_with_any_number_of_threads() {
    let shop = Workshop::new();
    shop.write("other.mpf", PROGRAM.replace("F500", "F800"));
    shop.scene("[[program]]\nname = \"other\"\nfile = \"other.mpf\"\n\n[compare]\nbaseline = \"main\"\n");
    let elsewhere = shop.path().join("machine");
    let scene = shop.path().display().to_string();
    let out = |name: &str| shop.path().join(name).display().to_string();
    let mut first: Option<BTreeMap<String, Vec<u8>>> = None;
    for (folder, scene, name, threads) in
        [(shop.path(), ".", "a", "1"), (&*elsewhere, "..", "b", "2"), (&*elsewhere, &scene, "c", "7")]
    {
        let call = ["compare", scene, "--output", &out(name), "--rerun", "off", "--threads", threads];
        let output = proveout(folder, &call);
        assert_eq!(output.code(), Some(3), "no design part: {}", output.text);
        let found = files(&shop.path().join(name));
        for wanted in ["compare.json", "compare.html", "manifest.json", "main/verdict.json", "other/stock.dexel"] {
            assert!(found.contains_key(wanted), "{wanted}: {:?}", found.keys());
        }
        let first = first.get_or_insert_with(|| found.clone());
        let what = format!("compare from {} with {threads} threads", folder.display());
        same(&what, first, &found);
    }
    // What a script tolerates is named gate by gate.
    let call = |more: &[&str]| {
        let mut all = vec!["compare", ".", "--output", "d", "--rerun", "off", "--threads", "1"];
        all.extend(more);
        shop.call(&all)
    };
    let verdict = json(&shop.read("a/compare.json"));
    let gates = verdict["programs"]["main"]["gates"].as_array().expect("gates");
    let open = gates.iter().filter(|g| g["state"] == "unchecked").map(|g| g["name"].as_str().expect("name"));
    let accepted: Vec<&str> = open.flat_map(|name| ["--accept-unchecked", name]).collect();
    assert!(accepted.len() >= 4, "two gates at least: {accepted:?}");
    assert_eq!(call(&accepted[2..]).code(), Some(3), "one of them is not accepted");
    let output = call(&accepted);
    assert_eq!(output.code(), Some(0), "{}", output.text);
    assert!(output.text.contains("unchecked, accepted by --accept-unchecked"), "{}", output.text);
    assert_eq!(json(&shop.read("d/compare.json"))["verdict"], "unchecked", "the verdict stays");
}
