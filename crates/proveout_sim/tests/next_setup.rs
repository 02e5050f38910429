//! One setup after the other: what a run leaves is the stock of the next one, and each block names its
//! engagement.

use std::{
    fs,
    io::BufReader,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
};

use proveout_geom::TriMesh;
use proveout_sim::{
    Choice, Engagement, Observer, Prepared, STOCK_FILE, SimError,
    observer::{Batch, BlockRow, ObserverError, Outcome, Setup},
    run::run,
    verdict::Verdict,
};
use proveout_stock::TriDexel;
use tempfile::TempDir;

const FEED_MM_MIN: f64 = 400.0;
const SPEED_RPM: f64 = 3000.0;
const FLUTES: f64 = 3.0;

/// A slot along X, 3 mm deep with an end mill of 6 mm; a second one next to it that leaves a wall of 2 mm.
const SLOTS: &str = "G17 G54 G90 G94 G710 G60\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nG0 X-30 Y-4\nG0 Z5 D1\nG1 Z-3 F400\n\
                     G1 X30\nG0 Z5\nG0 X-30 Y4\nG1 Z-3\nG1 X30\nG0 Z5\nM5\nM30\n";

/// Stock and blocks of a run.
#[derive(Clone, Default)]
struct Seen {
    blocks: Arc<Mutex<Vec<BlockRow>>>,
}

impl Observer for Seen {
    fn name(&self) -> &'static str {
        "seen"
    }

    fn begin(&mut self, _: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        self.blocks.lock().expect("one thread").extend(batch.blocks.iter().cloned());
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let mut file = fs::File::create(outcome.folder.join(STOCK_FILE)).expect("created");
        outcome.stock.save(&mut file).expect("saved");
        Ok(())
    }
}

struct Shop {
    folder: TempDir,
}

impl Shop {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("temporary folder") }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A scene of its own folder; `top` comes before the tables.
    fn scene(&self, name: &str, top: &str, stock: &str, rest: &str, program: &str) -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned();
        let folder = self.path(name);
        fs::create_dir_all(&folder).expect("made");
        let text = format!(
            "name = {name:?}\nmachine = {:?}\ntools = {:?}\n{top}\n[stock]\n{stock}\n[mount]\n\
             translation_mm = [0, 0, 100]\n[work_offsets.G54]\nZ_mm = 100\n[[program]]\nname = \"main\"\n\
             file = \"main.mpf\"\n{rest}",
            root.join("machines/three-axis-mill"),
            root.join("tools/axis-cross.toml"),
        );
        fs::write(folder.join("scene.toml"), text).expect("written");
        fs::write(folder.join("main.mpf"), program).expect("written");
        folder
    }

    fn run(&self, scene: &Path) -> Result<(Verdict, Vec<BlockRow>, TriDexel), SimError> {
        let seen = Seen::default();
        let blocks = Arc::clone(&seen.blocks);
        let result = run(Prepared::read(scene, &Choice::default())?, &mut [Box::new(seen)], scene)?;
        let file = fs::File::open(scene.join(STOCK_FILE)).expect("the run wrote it");
        let stock = TriDexel::load(&mut BufReader::new(file), 1 << 30).expect("as it was written");
        let blocks = blocks.lock().expect("one thread").clone();
        Ok((result.verdict, blocks, stock))
    }
}

const BLOCK: &str = "box = { min_mm = [-20, -15, -10], max_mm = [20, 15, 0] }";
const EMPTY: &str = "G17 G54 G90 G94 G710\nG0 Z50\nM30\n";

#[test]
fn the_next_setup_starts_with_what_the_first_has_left() {
    let shop = Shop::new();
    let first = shop.scene("first", "resolution_mm = 0.25", &format!("{BLOCK}\nhistory = true"), "", SLOTS);
    let (verdict, blocks, left) = shop.run(&first).expect("runs");
    assert!(verdict.removal.volume_mm3 > 1000.0 && left.has_history());
    assert_eq!((verdict.removal.regrid_bound_mm, verdict.removal.cells_mm), (None, [0.25; 3]));

    // The same pose and cells: nothing is lost. A wall of 2 mm is between the slots.
    let wall = "[[inspect]]\nname = \"wall\"\nkind = \"thickness\"\nfrom_mm = [0, -3, -1]\ndirection = \"+y\"\nnominal_mm = 2\n\
                tolerance_mm = 0.001\n[[inspect]]\nname = \"floor\"\nfrom_mm = [0, 4, 5]\ndirection = \"-z\"\nnominal_mm = -3\n\
                tolerance_mm = 0.001\n";
    let second = shop.scene("second", "resolution_mm = 0.25", "from_run = \"../first\"", wall, EMPTY);
    let (verdict, _, same) = shop.run(&second).expect("runs");
    let ends = |s: &TriDexel| s.surface_points().map(|p| (p.point, p.normal)).collect::<Vec<_>>();
    assert_eq!(ends(&same), ends(&left));
    assert_eq!((verdict.removal.regrid_bound_mm, verdict.removal.volume_mm3), (None, 0.0));
    assert_eq!(verdict.removal.sweep_bound_mm, left.sweep_bound_mm());
    assert!(verdict.digests.contains_key("stock"));
    for m in &verdict.inspection {
        let off = m.measured_mm.expect("met") - m.nominal_mm;
        assert!(off.abs() < 0.001, "{m:?}");
    }

    // Turned over: the slots look down, and nothing is lost either. Other cells: a bound is reported.
    let over =
        "from_run = \"../first/stock.dexel\"\nplace = { rotation_deg = [180, 0, 0], translation_mm = [0, 0, -10] }";
    let third = shop.scene("third", "resolution_mm = 0.25", over, "", EMPTY);
    let (verdict, _, turned) = shop.run(&third).expect("runs");
    assert_eq!(verdict.removal.regrid_bound_mm, None);
    let touched = turned.intervals_on(2, 0.0, 4.0).1;
    assert!((touched[0].lo + 7.0).abs() < 1e-3 && touched[0].hi.abs() < 1e-9, "{touched:?}");
    let askew = "from_run = \"../first\"\nplace = { rotation_deg = [0, 0, 30] }";
    let fourth = shop.scene("fourth", "resolution_mm = [0.4, 0.3, 0.2]", askew, "", EMPTY);
    let (verdict, _, regridded) = shop.run(&fourth).expect("runs");
    let bound = verdict.removal.regrid_bound_mm.expect("given");
    assert!(bound < 1e-3, "its faces are flat: {bound}");
    assert!(verdict.removal.regrid_edge_bound_mm.expect("given") <= 0.3);
    assert_eq!(regridded.cells_mm(), [0.4, 0.3, 0.2]);
    assert!((regridded.volume() / left.volume() - 1.0).abs() < 0.02);

    // As it stood between the slots: one slot, the other side whole.
    let between = blocks.iter().filter(|b| b.volume_mm3 > 0.0).map(|b| b.end_time).next().expect("a slot") + 0.1;
    let fifth = shop.scene(
        "fifth",
        "resolution_mm = 0.25",
        &format!("from_run = \"../first\"\nat_time_s = {between}"),
        "",
        EMPTY,
    );
    let (_, _, one_slot) = shop.run(&fifth).expect("runs");
    assert!((one_slot.intervals_on(2, 0.0, -4.0).1[0].hi + 3.0).abs() < 1e-6);
    assert_eq!(one_slot.intervals_on(2, 0.0, 4.0).1[0].hi, 0.0);
}

#[test]
fn every_block_tells_how_the_cutter_was_engaged() {
    let shop = Shop::new();
    let top = "resolution_mm = 0.2\nengagement = true";
    let scene = shop.scene("engaged", top, BLOCK, "", SLOTS);
    let (_, blocks, _) = shop.run(&scene).expect("runs");
    let cut: Vec<Engagement> = blocks.iter().filter_map(|b| b.engagement).collect();
    assert_eq!(cut.len(), 2, "two slots, and nothing else has cut");
    for e in cut {
        let near = |have: f64, want: f64, play: f64| assert!((have - want).abs() <= play, "{have}, not {want}: {e:?}");
        near(e.axial_depth_mm, 3.0, 0.2);
        near(e.radial_width_mm.expect("across"), 6.0, 0.2);
        near(e.entry.expect("an angle"), 0.0, 0.07);
        near(e.exit.expect("an angle"), std::f64::consts::PI, 0.07);
        // Feed a tooth; the piece in which the axis still gains or loses speed is slower.
        near(e.chip_thickness_mm.expect("flutes are known"), FEED_MM_MIN / SPEED_RPM / FLUTES, 1e-3);
    }
    // Without the wish nothing is computed, and the volume is the same.
    let plain = shop.scene("plain", "resolution_mm = 0.2", BLOCK, "", SLOTS);
    let (_, without, _) = shop.run(&plain).expect("runs");
    assert!(without.iter().all(|b| b.engagement.is_none()));
    let volumes = |b: &[BlockRow]| b.iter().map(|b| b.volume_mm3.to_bits()).collect::<Vec<_>>();
    assert_eq!(volumes(&without), volumes(&blocks));
}

#[test]
fn a_stock_that_cannot_be_had_is_one_error_with_its_place() {
    let shop = Shop::new();
    let refused = |stock: &str, words: &[&str]| {
        let scene = shop.scene("bad", "resolution_mm = 0.5", stock, "", EMPTY);
        let text = match shop.run(&scene) {
            Err(e) => e.to_string(),
            Ok(_) => panic!("{stock} is no stock"),
        };
        for w in words {
            assert!(text.contains(w), "{w:?} is missing in: {text}");
        }
    };
    refused("from_run = \"../nowhere\"", &["nowhere", "cannot be read"]);
    fs::write(shop.path("text.dexel"), "solid part").expect("written");
    refused("from_run = \"../text.dexel\"", &["text.dexel", "not a stock file"]);
    let first = shop.scene("first", "resolution_mm = 1.0", BLOCK, "", EMPTY);
    shop.run(&first).expect("runs");
    refused("from_run = \"../first\"\nat_time_s = 1.0", &["stock.dexel", "keeps no history"]);
    let whole = fs::read(shop.path("first/stock.dexel")).expect("there");
    fs::write(shop.path("half.dexel"), &whole[..whole.len() / 2]).expect("written");
    refused("from_run = \"../half.dexel\"", &["half.dexel", "cut off"]);
    refused("from_run = \"../first\"\nplace = { rotation_deg = [0, 0, 1] }\nmesh = \"a.stl\"", &["2 forms"]);
    refused(&format!("{BLOCK}\nat_time_s = 3.0"), &["belong to `from_run`"]);
    refused(&format!("{BLOCK}\nrepair = true"), &["belongs to `mesh`"]);
}

/// A box with its faces turned inward, and one that crosses it.
fn write_stl(path: &Path, turned: bool) {
    use proveout_geom::{Aabb, Point, box_mesh, write_stl};
    let cube = |a: [f64; 3], b: [f64; 3]| box_mesh(&Aabb { min: Point::from(a), max: Point::from(b) });
    let mut mesh: TriMesh = cube([-10.0, -10.0, -10.0], [10.0, 10.0, 0.0]);
    mesh.append(&cube([0.0, -5.0, -8.0], [15.0, 5.0, -2.0]));
    if turned {
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
    write_stl(path, &mesh).expect("written");
}

#[test]
fn a_faulty_mesh_is_refused_and_mended_only_when_asked() {
    let shop = Shop::new();
    for turned in [false, true] {
        let name = if turned { "turned" } else { "crossing" };
        let folder = shop.scene(name, "resolution_mm = 0.5", "mesh = \"stock.stl\"", "", EMPTY);
        write_stl(&folder.join("stock.stl"), turned);
        let Err(error) = shop.run(&folder) else { panic!("{name} is refused") };
        let word = if turned { "inside out" } else { "crosses itself" };
        assert!(error.to_string().contains(word), "{error}");
        let folder = shop.scene(name, "resolution_mm = 0.5", "mesh = \"stock.stl\"\nrepair = true", "", EMPTY);
        let (_, _, stock) = shop.run(&folder).expect("mended");
        // The union of both boxes.
        let want = 20.0 * 20.0 * 10.0 + 5.0 * 10.0 * 6.0;
        assert!((stock.volume() / want - 1.0).abs() < 0.01, "{}", stock.volume());
    }
}

#[test]
fn a_part_that_is_cut_off_is_reported_and_the_collision_gate_does_not_pass() {
    let shop = Shop::new();
    // A plate of 6 mm: a slot along Y through all of it at X 8 leaves 9 mm next to it.
    let plate = "box = { min_mm = [-20, -10, -6], max_mm = [20, 10, 0] }";
    let slot = |depth: f64| {
        format!(
            "G17 G54 G90 G94 G710 G60\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nG0 X8 Y-16\nG0 Z5 D1\nG0 Z2\nG1 Z{depth} F400\n\
             G1 Y16\nG0 Z5\nM5\nM30\n"
        )
    };
    let cut = shop.scene("off", "resolution_mm = 0.25", plate, "", &slot(-6.5));
    let (verdict, ..) = shop.run(&cut).expect("runs");
    let matches: Vec<_> = verdict.findings.iter().filter(|f| f.code == "process-loose-part").collect();
    assert_eq!(matches.len(), 1, "{:?}", verdict.findings);
    let f = matches[0];
    assert_eq!((f.line, f.unit.as_deref()), (Some(9), Some("mm3")), "{f:?}");
    assert!((f.value.expect("a volume") - 9.0 * 20.0 * 6.0).abs() < 1.0, "{f:?}");
    let middle = f.point_mm.expect("a place");
    assert!((middle[0] - 15.5).abs() < 0.01 && middle[1].abs() < 0.01 && (middle[2] + 3.0).abs() < 0.01, "{middle:?}");
    let gate = verdict.gates.iter().find(|g| g.gate.name() == "collision").expect("there");
    assert!(gate.state != proveout_sim::verdict::State::Pass && gate.reason.contains("process-loose-part"), "{gate:?}");
    // A floor of 0.1 mm holds it.
    let held = shop.scene("held", "resolution_mm = 0.25", plate, "", &slot(-5.9));
    let (verdict, ..) = shop.run(&held).expect("runs");
    assert!(verdict.findings.iter().all(|f| f.code != "process-loose-part"));
    assert!(verdict.gates.iter().all(|g| !g.reason.contains("came off")));
}
