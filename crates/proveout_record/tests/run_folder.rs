//! A whole run folder, read back by other readers than the writers.

use crate::support;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, File},
    path::Path,
    sync::{Mutex, OnceLock},
};

use crate::support::Shown;
use arrow_array::{Array, RecordBatch, cast::AsArray, types::Float64Type, types::UInt32Type};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use proveout_record::{RerunMode, observers};

/// A message that is markup wherever it goes through unescaped.
const EVIL: &str = "</script><script>alert(1)</script><img src='https://evil.example/x'>";
/// Cell of the stock, mm: coarse, since only files are tested.
const CELL: f64 = 1.0;

struct Run {
    folder: tempfile::TempDir,
    shown: Shown,
}

/// The run that all tests look at.
fn with_run<T>(look: impl FnOnce(&Path, &Shown) -> T) -> T {
    static RUN: OnceLock<Mutex<Run>> = OnceLock::new();
    let run = RUN.get_or_init(|| {
        let mode = if cfg!(feature = "rerun") { RerunMode::File } else { RerunMode::Off };
        Mutex::new(make(&mode))
    });
    let run = run.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    look(run.folder.path(), &run.shown)
}

fn make(mode: &RerunMode) -> Run {
    let folder = tempfile::tempdir().expect("folder");
    let mut all = observers(mode).expect("observers");
    let shown = support::run(&mut all, folder.path(), CELL, EVIL);
    Run { folder, shown }
}

/// All rows of a table as one batch, with the units of its columns.
fn read(path: &Path) -> (RecordBatch, BTreeMap<String, String>) {
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(path).expect("file")).expect("parquet");
    let schema = builder.schema().clone();
    let units = schema.fields().iter().map(|f| (f.name().clone(), f.metadata()["unit"].clone())).collect();
    let batches: Vec<RecordBatch> =
        builder.with_batch_size(1 << 20).build().expect("reader").map(|b| b.expect("batch")).collect();
    assert_eq!(batches.len(), 1, "the run is one row group");
    (batches[0].clone(), units)
}

fn reals(batch: &RecordBatch, name: &str) -> Vec<Option<f64>> {
    let column = batch.column_by_name(name).unwrap_or_else(|| panic!("{name} is missing"));
    column.as_primitive::<Float64Type>().iter().collect()
}

#[test]
fn signals_are_the_samples_in_the_units_of_their_columns() {
    with_run(|folder, shown| {
        let (batch, units) = read(&folder.join("signals.parquet"));
        assert_eq!(batch.num_rows(), shown.samples.len());
        for (name, unit) in [
            ("time_s", "s"),
            ("X_mm", "mm"),
            ("B_deg", "deg"),
            ("velocity_B_deg_s", "deg/s"),
            ("jerk_X_mm_s3", "mm/s3"),
            ("feed_mm_min", "mm/min"),
            ("removal_mm3_s", "mm3/s"),
            ("tip_z_mm", "mm"),
            ("axis_k", "1"),
        ] {
            assert_eq!(units.get(name).map(String::as_str), Some(unit), "{name}");
        }
        let joint = |name: &str| shown.joints.iter().position(|j| j == name).expect("joint");
        let (x, b) = (joint("X"), joint("B"));
        let columns = [
            "time_s",
            "X_mm",
            "B_deg",
            "acceleration_B_deg_s2",
            "feed_mm_min",
            "feed_programmed_mm_min",
            "tip_z_mm",
            "removal_mm3_s",
            "clearance_mm",
        ]
        .map(|n| reals(&batch, n));
        for (i, (s, beside)) in shown.samples.iter().zip(&shown.signals).enumerate() {
            let feed = (s.feed_programmed > 0.0).then_some(s.feed_programmed * 60.0);
            let expected = [
                Some(s.time),
                Some(s.commanded[x]),
                Some(s.commanded[b].to_degrees()),
                Some(s.acceleration[b].to_degrees()),
                Some(s.feed * 60.0),
                feed,
                Some(s.pose.tip.z - 140.0),
                Some(beside.removal_rate),
                beside.clearance,
            ];
            for (column, value) in columns.iter().zip(expected) {
                assert_eq!(column[i], value, "row {i}");
            }
        }
    });
}

#[test]
fn blocks_and_surface_are_complete() {
    with_run(|folder, shown| {
        let (batch, _) = read(&folder.join("blocks.parquet"));
        assert_eq!(batch.num_rows(), shown.blocks.len());
        let line = batch.column_by_name("line").expect("line").as_primitive::<UInt32Type>();
        let tool = batch.column_by_name("tool_name").expect("tool").as_string::<i32>();
        let volume = reals(&batch, "volume_mm3");
        for (i, b) in shown.blocks.iter().enumerate() {
            assert_eq!((line.value(i), volume[i]), (b.line, Some(b.volume_mm3)));
        }
        assert_eq!((tool.value(0), tool.value(tool.len() - 1)), ("BULL_D25_R2", "END_D20"));

        let (batch, _) = read(&folder.join("surface.parquet"));
        assert_eq!(batch.num_rows(), shown.surface.points.len());
        let (z, deviation) = (reals(&batch, "z_mm"), reals(&batch, "deviation_mm"));
        for (i, p) in shown.surface.points.iter().enumerate() {
            assert_eq!((z[i], deviation[i]), (Some(p.position[2]), p.deviation));
        }
    });
}

#[test]
fn points_of_a_patch_and_its_mesh_are_distinguished_and_shown() {
    use proveout_geom::{Aabb, Point, Vector, box_mesh};
    use proveout_sim::{MapPoint, PatchMap, SurfaceMap};
    let at = |x: f64| MapPoint {
        position: [x, 0.0, 0.0],
        normal: [0.0, 0.0, 1.0],
        deviation: Some(0.01 * x),
        scallop: None,
        scallop_geometric: None,
        made_by: Some(1),
    };
    let cube = |low: f64| box_mesh(&Aabb { min: Point::new(low, 0.0, 0.0), max: Point::new(low + 1.0, 1.0, 1.0) });
    let normals = vec![Vector::z(); cube(0.0).positions.len()];
    let deviations = vec![0.01; normals.len()];
    let surface = SurfaceMap {
        mesh: cube(0.0),
        normals: normals.clone(),
        vertex_deviation: deviations.clone(),
        points: vec![at(0.0), at(5.0), at(6.0)],
        cells_mm: [1.0; 3],
        patches: vec![PatchMap {
            name: "edge".into(),
            window: Aabb { min: Point::new(4.0, -1.0, -1.0), max: Point::new(9.0, 1.0, 1.0) },
            cells_mm: [0.5; 3],
            mesh: cube(5.0),
            normals,
            vertex_deviation: deviations,
            points: 1..3,
        }],
    };
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("surface.parquet");
    proveout_record::write_surface_table(&path, &surface).expect("written");
    let (batch, _) = read(&path);
    let patch = batch.column_by_name("patch").expect("patch").as_string::<i32>();
    let names: Vec<Option<&str>> = (0..3).map(|k| (!patch.is_null(k)).then(|| patch.value(k))).collect();
    assert_eq!(names, [None, Some("edge"), Some("edge")]);
    // Four points of the patch lie where the stock has one.
    let weights: Vec<f64> = surface.weighted_points().map(|(_, w)| w).collect();
    assert_eq!(weights, [1.0, 0.25, 0.25]);
    proveout_record::write_part_files(folder.path(), &surface, 0.001).expect("written");
    let file = gltf::Gltf::open(folder.path().join("part.glb")).expect("valid glTF");
    let bounds = file.meshes().next().expect("mesh").primitives().next().expect("primitive").bounding_box();
    assert_eq!((bounds.min, bounds.max), ([0.0; 3], [6.0, 1.0, 1.0]), "stock and patch");
}

#[test]
fn gltf_files_hold_the_surface_with_finite_numbers() {
    with_run(|folder, shown| {
        for (name, colored) in [("part.glb", false), ("deviation.glb", true)] {
            let file = gltf::Gltf::open(folder.join(name)).expect("valid glTF");
            let blob = file.blob.clone().expect("binary chunk");
            let mesh = file.meshes().next().expect("mesh");
            let primitive = mesh.primitives().next().expect("primitive");
            let reader = primitive.reader(|_| Some(blob.as_slice()));
            let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
            assert_eq!(positions.len(), shown.surface.mesh.positions.len());
            assert!(positions.iter().flatten().all(|v| v.is_finite()));
            let indices = reader.read_indices().expect("indices").into_u32();
            assert_eq!(indices.count(), 3 * shown.surface.mesh.triangles.len());
            assert_eq!(reader.read_colors(0).is_some(), colored);
        }
    });
}

#[test]
fn the_verdict_reads_back_and_the_page_is_closed() {
    with_run(|folder, shown| {
        let text = fs::read_to_string(folder.join("verdict.json")).expect("verdict");
        let back: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(back["gates"].as_array().map(Vec::len), Some(shown.verdict.gates.len()));
        assert_eq!(back["findings"][0]["message"], EVIL);
        // The written digits are read by the standard library, which rounds correctly.
        let digits = |key: &str| {
            let at = text.find(&format!("\"{key}\": ")).expect("key") + key.len() + 4;
            text[at..].split([',', '\n']).next().expect("value").parse::<f64>().expect("number")
        };
        assert_eq!(digits("total_s"), shown.verdict.time.total_s);
        assert_eq!(digits("stock_left_mm3"), shown.verdict.removal.stock_left_mm3);
        let page = fs::read_to_string(folder.join("report.html")).expect("page");
        // Pictures are those that the page makes itself.
        let images = page.matches("<img").count();
        assert_eq!(images, page.matches("<img src=\"data:image/png;base64,").count(), "a value went through unescaped");
        assert!(!page.contains("<script>alert"), "a value went through unescaped");
        let loads = page.replace("https://evil.example", ""); // shown as text
        assert!(!loads.contains("http://") && !loads.contains("https://"), "the page names an address");
        assert_eq!(page.matches("</script>").count(), 12);
    });
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let again = make(&RerunMode::Off);
    with_run(|folder, _| {
        for name in [
            "verdict.json",
            "signals.parquet",
            "blocks.parquet",
            "surface.parquet",
            "stock.dexel",
            "part.glb",
            "deviation.glb",
            "report.html",
            "setup.html",
        ] {
            let [a, b] = [folder, again.folder.path()].map(|f| fs::read(f.join(name)).expect("there"));
            assert!(a == b, "{name} differs");
        }
        assert!(!again.folder.path().join("recording.rrd").exists());
    });
}

#[cfg(feature = "rerun")]
#[test]
fn the_recording_reads_back_with_its_entities_and_blueprint() {
    use rerun::external::{re_log_encoding::DecoderApp, re_log_types::LogMsg};
    with_run(|folder, _| {
        let file = std::io::BufReader::new(File::open(folder.join("recording.rrd")).expect("recording"));
        let mut entities = BTreeSet::new();
        let mut stores = BTreeSet::new();
        let mut activated = false;
        for message in DecoderApp::decode_eager(file).expect("header") {
            match message.expect("message") {
                LogMsg::SetStoreInfo(info) => {
                    stores.insert(info.info.store_id.kind().to_string());
                }
                LogMsg::ArrowMsg(_, arrow) => {
                    let chunk = rerun::log::Chunk::from_arrow_msg(&arrow).expect("chunk");
                    entities.insert(chunk.entity_path().to_string());
                }
                LogMsg::BlueprintActivationCommand(_) => activated = true,
            }
        }
        assert!(activated && stores.len() == 2, "recording and blueprint: {stores:?}");
        for entity in [
            "/machine/tool",
            "/machine/tool/holder",
            "/machine/table",
            "/machine/table/work",
            "/machine/table/work/part",
            "/machine/table/work/surface",
            "/machine/table/work/findings",
            "/axes/X/position",
            "/axes/C/jerk",
            "/process/feed",
            "/process/removal",
            "/log/findings",
            "/log/program",
            "/about",
        ] {
            assert!(entities.contains(entity), "{entity} is missing in {entities:?}");
        }
        assert!(entities.iter().any(|e| e.starts_with("/machine/table/work/stock/")));
        assert!(entities.iter().any(|e| e.ends_with("/EyeControls3D")), "the views have cameras");
    });
}
