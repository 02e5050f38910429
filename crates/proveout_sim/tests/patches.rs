//! Patches of a scene: what they show, what stays as it was without them, and what is refused.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_geom::{Aabb, Point, box_mesh, write_stl};
use proveout_sim::{
    Choice, MapPoint, Observer, Prepared, STOCK_FILE, SimError, SurfaceMap,
    finding::{EXCESS, GOUGE},
    observer::{Batch, ObserverError, Outcome, Setup},
    patch_file,
    run::run_with_surface,
    verdict::{State, Verdict},
};
use tempfile::TempDir;

/// A slot along Y of 6 mm, 3 mm deep, and a V of 0.2 mm at x = 4, between the coarse rays: 0.4 mm wide, 0.14
/// mm deep across its walls.
const PROGRAM: &str = "G17 G54 G90 G94 G710 G60\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nG0 X-8 Y-30\nG0 Z5 D1\nG1 Z-3 F400\n\
                       G1 Y30\nG0 Z50\nM5\nT=\"ENTFRAESER_D8_N_90GRAD\"\nM6\nS8000 M3\nG0 X4 Y-5\nG0 Z5 D1\nG1 Z-0.2 F200\nG1 Y5\nG0 Z50\n\
                       M5\nM30\n";
const EMPTY: &str = "G17 G54 G90 G94 G710\nG0 Z50\nM30\n";
const BLOCK: &str = "box = { min_mm = [-20, -16, -8], max_mm = [20, 16, 0] }";
/// Over the V and half of the slot's edge; its faces run through material and through the V.
const PATCH: &str =
    "[[stock.patch]]\nname = \"engraving\"\nmin_mm = [-6.7, -4.2, -4]\nmax_mm = [6.3, 8.1, 1]\ncell_mm = 0.0625\n";
/// V of the engraver measured square to its walls, mm: 0.2 mm deep at 45 degrees.
const V_DEPTH: f64 = 0.2 * std::f64::consts::FRAC_1_SQRT_2;

/// Writes the files that the next setup needs.
struct Keeper;

impl Observer for Keeper {
    fn name(&self) -> &'static str {
        "keeper"
    }

    fn begin(&mut self, _: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        assert_eq!(batch.patches.len(), batch.changed_in_patches.len());
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let save = |name: &str, stock: &proveout_stock::TriDexel| {
            stock.save(&mut fs::File::create(outcome.folder.join(name)).unwrap()).unwrap();
        };
        save(STOCK_FILE, outcome.stock);
        outcome.patches.iter().for_each(|p| save(&patch_file(p.name()), p.stock()));
        Ok(())
    }
}

struct Shop(TempDir);

impl Shop {
    fn new() -> Self {
        let shop = Self(tempfile::tempdir().unwrap());
        let part = box_mesh(&Aabb { min: Point::new(-20.0, -16.0, -8.0), max: Point::new(20.0, 16.0, 0.0) });
        write_stl(&shop.0.path().join("part.stl"), &part).unwrap();
        shop
    }

    /// A scene; `judged` is the box in which the part is judged.
    fn scene(&self, name: &str, cell: &str, stock: &str, judged: &str, program: &str) -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_owned();
        let folder = self.0.path().join(name);
        fs::create_dir_all(&folder).unwrap();
        let text = format!(
            "name = {name:?}\nmachine = {:?}\ntools = {:?}\nresolution_mm = {cell}\n[stock]\n{stock}\n[part]\n\
             mesh = \"../part.stl\"\n{judged}\n[mount]\ntranslation_mm = [0, 0, 100]\n[work_offsets.G54]\nZ_mm = 100\n\
             [[program]]\nname = \"main\"\nfile = \"main.mpf\"\n[[inspect]]\nname = \"floor of the V\"\n\
             from_mm = [4, 0, 5]\ndirection = \"-z\"\nnominal_mm = -0.2\ntolerance_mm = 0.05\n",
            root.join("machines/three-axis-mill"),
            root.join("tools/axis-cross.toml"),
        );
        fs::write(folder.join("scene.toml"), text).unwrap();
        fs::write(folder.join("main.mpf"), program).unwrap();
        folder
    }

    fn run(&self, scene: &Path, threads: usize) -> Result<Ran, SimError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (result, surface) = pool
            .install(|| run_with_surface(Prepared::read(scene, &Choice::default())?, vec![Box::new(Keeper)], scene))?;
        Ok(Ran { verdict: result.verdict, surface })
    }
}

/// What a run gave.
struct Ran {
    verdict: Verdict,
    surface: SurfaceMap,
}

/// Next to the slot, which the design does not know.
const JUDGED: &str = "judged_box = { min_mm = [-4, -16, -8], max_mm = [20, 16, 1] }";

fn inside(p: &MapPoint) -> bool {
    // The box of PATCH; its upper face lies above the stock.
    let [x, y, z] = p.position;
    (-6.7..=6.3).contains(&x) && (-4.2..=8.1).contains(&y) && (-4.0..=1.0).contains(&z)
}

#[test]
fn a_gouge_between_the_coarse_rays_is_found_and_the_patch_has_its_rays() {
    let shop = Shop::new();
    let plain = shop.scene("plain", "1.0", BLOCK, JUDGED, PROGRAM);
    let patched = shop.scene("patched", "1.0", &format!("{BLOCK}\n{PATCH}"), JUDGED, PROGRAM);
    let (plain, patched) = (shop.run(&plain, 2).unwrap(), shop.run(&patched, 2).unwrap());
    let gate = |r: &Ran, name: &str| r.verdict.gates.iter().find(|g| g.gate.name() == name).unwrap().state;
    // Without the patch no ray meets the V: the swept pieces of motion show its depth.
    assert_eq!((gate(&plain, "gouge"), gate(&patched, "gouge")), (State::Fail, State::Fail));
    let gouge = plain.verdict.findings.iter().find(|f| f.code == GOUGE.code).unwrap();
    let depth = gouge.value.unwrap();
    assert!(depth <= 0.2 + 1e-3 && depth > 0.19, "{depth}");
    assert_eq!(gouge.line, Some(17), "the block that engraves");
    let gouge = patched.verdict.findings.iter().find(|f| f.code == GOUGE.code).unwrap();
    // The deepest ray lies at most half a cell off the bottom of the V.
    let depth = gouge.value.unwrap();
    assert!(depth <= 0.2 + 1e-3 && depth > V_DEPTH, "{depth}");
    assert_eq!(gouge.line, Some(17), "the block that engraves");
    assert!((gouge.point_mm.unwrap()[0] - 4.0).abs() < 0.0625);
    // Inspection reads the ray of the patch.
    let floor = |r: &Ran| r.verdict.inspection[0].measured_mm.unwrap();
    assert_eq!(floor(&plain), 0.0);
    assert!((floor(&patched) + 0.2).abs() <= 0.5 * 0.0625 + 1e-3, "{}", floor(&patched));
    let used = &patched.verdict.removal.patches[0];
    assert_eq!((used.name.as_str(), used.cells_mm, used.max_mm), ("engraving", [0.0625; 3], [6.3, 8.1, 1.0]));
    assert!(used.sweep_bound_mm > 0.0 && used.sweep_bound_mm <= patched.verdict.removal.sweep_bound_mm);
    assert_eq!(used.points, patched.surface.patches[0].points.len() as u64);
}

#[test]
#[ignore = "nightly, 28 s"]
fn outside_of_a_patch_nothing_changes_and_inside_it_is_a_run_with_fine_cells() {
    let shop = Shop::new();
    let plain = shop.scene("plain", "1.0", BLOCK, "", PROGRAM);
    let patched = shop.scene("patched", "1.0", &format!("{BLOCK}\n{PATCH}"), "", PROGRAM);
    let fine = shop.scene("fine", "0.0625", BLOCK, "", PROGRAM);
    let [plain, patched, fine] = [plain, patched, fine].map(|s| shop.run(&s, 2).unwrap());
    let of = |r: &Ran, within: bool| -> Vec<MapPoint> {
        r.surface.points.iter().filter(|p| inside(p) == within).copied().collect()
    };
    assert_eq!(of(&patched, false), of(&plain, false), "bit for bit");
    let own = patched.surface.patches[0].points.clone();
    assert!(own.start == of(&plain, false).len() && own.end == patched.surface.points.len());
    let (mine, other) = (of(&patched, true), of(&fine, true));
    assert!(mine.len() > 50_000 && mine.len() == other.len(), "{} {}", mine.len(), other.len());
    // Straight motion of a flat and of a pointed tool: off by the bound of both runs, seen along rays at 45
    // degrees or steeper.
    let bound = 2.0 * fine.verdict.removal.sweep_bound_mm * std::f64::consts::SQRT_2;
    for (a, b) in mine.iter().zip(&other) {
        let off = (0..3).map(|k| (a.position[k] - b.position[k]).abs()).fold(0.0, f64::max);
        assert!(off <= bound && a.made_by == b.made_by, "{a:?} {b:?}");
        assert!((a.deviation.unwrap() - b.deviation.unwrap()).abs() <= bound);
    }
    // Everything that is judged on the stock alone.
    let stock = |r: &Ran| {
        let mut removal = r.verdict.removal.clone();
        removal.patches.clear();
        let excess = r.verdict.findings.iter().filter(|f| f.code != GOUGE.code && f.code != EXCESS.code);
        let excess: Vec<_> = excess.filter(|f| f.line.is_some()).cloned().collect();
        (removal, excess, r.verdict.tools.clone(), r.verdict.clearance.clone(), r.verdict.time.clone())
    };
    assert_eq!(stock(&patched), stock(&plain));
    // Figures over the area do not count a patch more than its area.
    let rms = |r: &Ran| r.verdict.deviation.rms_mm.unwrap();
    assert!((rms(&patched) / rms(&plain) - 1.0).abs() < 0.02, "{} {}", rms(&patched), rms(&plain));
    let (weights, points) =
        (patched.surface.weighted_points().map(|(_, w)| w).sum::<f64>(), plain.surface.points.len() as f64);
    assert!((weights / points - 1.0).abs() < 0.01, "{weights} for {points}");
}

#[test]
fn the_verdict_with_patches_has_the_same_bytes_at_any_thread_count() {
    let shop = Shop::new();
    let second =
        "[[stock.patch]]\nname = \"corner\"\nmin_mm = [12, 10, -8]\nmax_mm = [25, 25, 5]\ncell_mm = [0.3, 0.2, 0.1]\n";
    let scene = shop.scene("scene", "0.5", &format!("{BLOCK}\n{PATCH}{second}"), "", PROGRAM);
    let bytes = |threads| {
        let result = shop.run(&scene, threads).unwrap();
        let names: Vec<String> = result.surface.patches.iter().map(|p| p.name.clone()).collect();
        assert_eq!(names, ["engraving", "corner"]);
        let files = ["engraving", "corner"].map(|n| fs::read(scene.join(patch_file(n))).unwrap());
        (serde_json::to_string_pretty(&result.verdict).unwrap(), files, result.surface.points)
    };
    assert!(bytes(1) == bytes(2));
}

#[test]
fn the_next_setup_takes_a_patch_over_exactly() {
    let shop = Shop::new();
    let first = shop.scene("first", "1.0", &format!("{BLOCK}\nhistory = true\n{PATCH}"), JUDGED, PROGRAM);
    let left = shop.run(&first, 2).unwrap();
    let second = shop.scene("second", "1.0", &format!("from_run = \"../first\"\n{PATCH}"), JUDGED, EMPTY);
    let next = shop.run(&second, 2).unwrap();
    let used = &next.verdict.removal.patches[0];
    assert_eq!((used.regrid_bound_mm, next.verdict.removal.regrid_bound_mm), (None, None));
    let places = |r: &Ran| r.surface.points.iter().map(|p| (p.position, p.deviation)).collect::<Vec<_>>();
    assert_eq!(places(&next), places(&left));
    assert!(next.verdict.digests.contains_key("stock patch engraving"));
    // As it stood before the engraver came.
    let before = format!("from_run = \"../first\"\nat_time_s = {}\n{PATCH}", left.verdict.tools[0].time_s + 1.0);
    let before = shop.run(&shop.scene("before", "1.0", &before, JUDGED, EMPTY), 2).unwrap();
    assert!(before.verdict.deviation.gouge_max_mm.unwrap() < 1e-6, "no V yet");
    // A patch that the earlier run did not have is made from its coarse rays, and says so.
    let other = PATCH.replace("engraving", "other");
    let other = shop.scene("other", "1.0", &format!("from_run = \"../first\"\n{other}"), JUDGED, EMPTY);
    let other = shop.run(&other, 2).unwrap().verdict;
    assert!(other.removal.patches[0].regrid_edge_bound_mm.is_some() && other.removal.regrid_bound_mm.is_none());
}

#[test]
fn a_patch_that_cannot_be_is_one_error_with_its_place() {
    let shop = Shop::new();
    let refused = |cell: &str, patches: &str, words: &[&str]| {
        let scene = shop.scene("bad", cell, &format!("{BLOCK}\n{patches}"), "", EMPTY);
        let Err(error) = shop.run(&scene, 1) else { panic!("{patches} is refused") };
        let SimError::Input(config) = &error else { panic!("{error} has no place") };
        let text = format!("{error} {}", config.remedy);
        for w in words {
            assert!(text.contains(w), "{w:?} is missing in: {text}");
        }
        config.line
    };
    let change = |from: &str, to: &str| PATCH.replace(from, to);
    let two = |other: &str| format!("{PATCH}{other}");
    // Line 7 is the first line after `box`.
    let line =
        refused("1.0", &change("6.3, 8.1", "-6.7, 8.1"), &["engraving", "is empty", "along x", "min_mm must be below"]);
    assert_eq!(line, 7);
    refused(
        "1.0",
        &change("max_mm = [6.3, 8.1, 1]", "max_mm = [6.3, nan, 1]"),
        &["stock.patch.engraving.max_mm[1]", "out of range"],
    );
    let line =
        refused("1.0", &two(&change("engraving", "second")), &["second", "overlaps", "engraving", "-6.7 to 6.3"]);
    assert_eq!(line, 12);
    let apart = change("-6.7, -4.2, -4", "6.3, -4.2, -4").replace("[6.3, 8.1, 1]", "[9, 8.1, 1]");
    refused("1.0", &two(&apart), &["two patches are named", "engraving"]);
    refused("1.0", &change("engraving", "../up"), &["../up", "begins with a point", "letters"]);
    refused("1.0", &change("engraving", ""), &["is empty"]);
    let out = change("-6.7, -4.2, -4", "30, -4.2, -4").replace("6.3, 8.1, 1", "40, 8.1, 1");
    assert_eq!(refused("1.0", &out, &["outside of the stock", "30", "40", "-20 to 20", "move the box"]), 7);
    refused("1.0", &change("0.0625", "2.0"), &["2 mm", "not finer", "1 mm"]);
    refused("0.0625", &change("0.0625", "0.0625"), &["not finer"]);
    refused("1.0", &change("0.0625", "0"), &["cell_mm = 0", "positive"]);
    refused("1.0", &change("0.0625", "\"fine\""), &["one length in mm, or three"]);
    refused("1.0", &change("-4]", "-0.1]"), &["too thin", "0.1 mm", "0.0625"]);
    // Nothing is allocated: the box would need some 100 GiB.
    let line = refused(
        "1.0",
        &change("0.0625", "0.0005"),
        &["together more than the 4096 MiB", "mm for \"engraving\", or smaller boxes"],
    );
    assert_eq!(line, 7);
    refused("1.0", &change("cell_mm", "cells_mm"), &["cells_mm", "did you mean"]);
}

#[test]
fn the_cells_that_a_refusal_names_do_fit() {
    let shop = Shop::new();
    let refused = |patch: &str| {
        let scene = shop.scene("large", "1.0", &format!("{BLOCK}\n{patch}"), "", EMPTY);
        match Prepared::read(&scene, &Choice::default()) {
            Err(SimError::Input(c)) => c.remedy.clone(),
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    let help = refused(&PATCH.replace("0.0625", "0.0002"));
    let fits: f64 = help.split_whitespace().find_map(|w| w.parse().ok()).unwrap();
    assert!(fits > 0.0002 && fits < 0.01, "{help}");
    // One step finer is refused with the same number, rounded up as it is.
    let again = refused(&PATCH.replace("0.0625", &format!("{}", fits - 2e-4)));
    assert!(again.contains(&format!("{fits:.4}")), "{again}");
}
