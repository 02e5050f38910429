//! What the player of the page gets, read by a decoder of its own and compared with the run.

use std::{fs, io::Read};

use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::read::ZlibDecoder;
use proveout_geom::{Point, Vector};
use proveout_machine::Machine;
use proveout_record::ReportObserver;
use serde_json::Value;

use crate::support::{self, Shown};

/// Cell of the stock, mm.
const CELL: f64 = 0.8;

struct Page {
    data: Value,
    motion: Vec<u8>,
    meshes: Vec<u8>,
    stock: Vec<u8>,
    bytes: usize,
}

fn element<'a>(page: &'a str, id: &str) -> &'a str {
    let begin = page.find(&format!("id=\"{id}\">")).unwrap_or_else(|| panic!("{id} is missing"));
    let rest = &page[begin..];
    let text = &rest[rest.find('>').expect("a tag") + 1..];
    &text[..text.find("</script>").expect("an end")]
}

fn unpacked(page: &str, id: &str) -> Vec<u8> {
    let packed = STANDARD.decode(element(page, id)).expect("Base64");
    let mut out = Vec::new();
    ZlibDecoder::new(packed.as_slice()).read_to_end(&mut out).expect("zlib");
    out
}

fn page() -> (Page, Shown) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let shown = support::run(&mut [Box::<ReportObserver>::default()], folder.path(), CELL, "plain");
    let text = fs::read_to_string(folder.path().join("report.html")).expect("a page");
    let page = Page {
        data: serde_json::from_str(element(&text, "player-data")).expect("JSON"),
        motion: unpacked(&text, "player-motion"),
        meshes: unpacked(&text, "player-meshes"),
        stock: unpacked(&text, "player-stock"),
        bytes: text.len(),
    };
    (page, shown)
}

/// Reads bytes in order.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn word(&mut self) -> usize {
        self.at += 4;
        u32::from_le_bytes(self.bytes[self.at - 4..self.at].try_into().expect("four bytes")) as usize
    }

    fn float(&mut self) -> f64 {
        f64::from(f32::from_bits(self.word() as u32))
    }

    fn numbers(&mut self, count: usize) -> Vec<i64> {
        let mut last = 0;
        let mut next = || {
            let (mut code, mut shift) = (0_u64, 0);
            loop {
                let byte = self.bytes[self.at];
                self.at += 1;
                code |= u64::from(byte & 127) << shift;
                shift += 7;
                if byte < 128 {
                    break;
                }
            }
            last += (code >> 1) as i64 ^ -((code & 1) as i64);
            last
        };
        (0..count).map(|_| next()).collect()
    }

    fn scaled(&mut self, count: usize, scale: f64) -> Vec<f64> {
        self.numbers(count).into_iter().map(|n| n as f64 * scale).collect()
    }

    /// Times, and values of each signal.
    fn series(&mut self, signals: usize, step: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
        let knots = self.word();
        let times = self.scaled(knots, 1e-4);
        (times, (0..signals).map(|_| self.scaled(knots, step)).collect())
    }

    /// A mesh: positions, normals, block plus one of each vertex, triangles.
    fn mesh(&mut self, blocks: bool) -> Mesh {
        let (vertices, triangles) = (self.word(), self.word());
        let low = [self.float(), self.float(), self.float()];
        let size = [self.float(), self.float(), self.float()];
        let places: Vec<Vec<f64>> = (0..3).map(|k| self.scaled(vertices, size[k] / 65535.0)).collect();
        let mut normals = vec![Vector::zeros(); vertices];
        for k in 0..3 {
            let mut last = 0_u8;
            for normal in &mut normals {
                last = last.wrapping_add(self.bytes[self.at]);
                self.at += 1;
                normal[k] = f64::from(last as i8) / 127.0;
            }
        }
        let made = if blocks { self.numbers(vertices) } else { Vec::new() };
        let indices = self.numbers(3 * triangles);
        Mesh {
            positions: (0..vertices)
                .map(|i| Point::new(low[0] + places[0][i], low[1] + places[1][i], low[2] + places[2][i]))
                .collect(),
            normals,
            made,
            triangles: indices.chunks(3).map(|t| [t[0] as usize, t[1] as usize, t[2] as usize]).collect(),
        }
    }
}

#[derive(Clone, Default)]
struct Mesh {
    positions: Vec<Point>,
    normals: Vec<Vector>,
    made: Vec<i64>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// By the divergence theorem; of a part of a closed surface its share.
    fn volume(&self) -> f64 {
        let of = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| self.positions[i].coords);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.triangles.iter().map(of).sum()
    }
}

fn at(times: &[f64], values: &[f64], time: f64) -> f64 {
    let n = times.partition_point(|t| *t <= time);
    match n {
        0 => values[0],
        n if n == times.len() => values[n - 1],
        n => values[n - 1] + (values[n] - values[n - 1]) * (time - times[n - 1]) / (times[n] - times[n - 1]),
    }
}

#[test]
fn blocks_joints_and_feeds_are_those_of_the_run() {
    let (page, shown) = page();
    let joints = shown.joints.len();
    let mut reader = Reader { bytes: &page.motion, at: 0 };
    let steps = reader.word();
    assert_eq!(steps, shown.blocks.len());
    let block = reader.numbers(steps);
    let line = reader.numbers(steps);
    let end = reader.scaled(steps, 1e-4);
    let tool = reader.numbers(steps);
    let feed = reader.numbers(steps);
    let length = reader.scaled(steps, 0.01);
    let volume = reader.scaled(steps, 0.1);
    for (k, row) in shown.blocks.iter().enumerate() {
        assert_eq!((block[k], line[k]), (i64::from(row.block), i64::from(row.line)));
        assert!((end[k] - row.end_time).abs() <= 0.51e-4 && (length[k] - row.length).abs() <= 0.0051);
        assert!((volume[k] - row.volume_mm3).abs() <= 0.051);
        assert_eq!(tool[k] >> 1, row.tool.map_or(0, |t| i64::from(t) + 1));
        assert_eq!(tool[k] & 1 == 1, row.kind == proveout_controller::MoveKind::Rapid);
        assert_eq!(feed[k], row.feed.map_or(0, |f| (60.0 * f).round() as i64));
    }
    let step = |name: &str| page.data["steps"][name].as_f64().expect("a step");
    let (times, values) = reader.series(joints, step("joint"));
    let (feed_times, feeds) = reader.series(1, step("feed"));
    let (load_times, _) = reader.series(joints, step("load"));
    assert_eq!((load_times.len(), reader.at), (0, page.motion.len()), "no drives in this run, and nothing is left");
    assert_eq!(page.data["loads"], false);
    let unit = |k: usize, v: f64| if k > 2 { v.to_degrees() } else { v };
    let mut fastest = vec![0.0_f64; joints];
    for s in &shown.samples {
        for (k, fast) in fastest.iter_mut().enumerate() {
            *fast = fast.max(unit(k, s.velocity[k]).abs());
        }
    }
    for s in &shown.samples {
        for k in 0..joints {
            // The tolerance, half a step of the value, and half a step of the time at the fastest.
            let bound = 0.02 + 0.5e-3 + 0.5e-4 * 2.0 * fastest[k];
            let off = (at(&times, &values[k], s.time) - unit(k, s.actual[k])).abs();
            assert!(off <= bound, "joint {k} at {}: {off} above {bound}", s.time);
        }
    }
    // The ends of blocks are knots.
    for row in &shown.blocks {
        assert!(times.iter().any(|t| (t - row.end_time).abs() < 1e-4), "no knot at the end of block {}", row.block);
    }
    assert!(times.len() < shown.samples.len() / 2, "{} knots of {} samples", times.len(), shown.samples.len());
    let mut largest = 0.0_f64;
    for s in &shown.samples {
        largest = largest.max((at(&feed_times, &feeds[0], s.time) - 60.0 * s.feed).abs());
    }
    // At the end of a block the feed of the run jumps between two samples.
    assert!(largest < 16.0 + 1.0 + 60.0 * 400.0 * 0.01, "{largest}");
}

#[test]
fn the_stock_of_a_moment_has_the_volume_of_the_run() {
    let (page, shown) = page();
    let mut reader = Reader { bytes: &page.stock, at: 0 };
    let [groups, moments, parts] = [reader.word(), reader.word(), reader.word()];
    let times = reader.scaled(moments, 1e-4);
    let (moment, group, length) = (reader.numbers(parts), reader.numbers(parts), reader.numbers(parts));
    assert!(moments >= 5 && times[0] == 0.0 && times.windows(2).all(|w| w[0] <= w[1]), "{times:?}");
    assert!(moment.windows(2).all(|w| w[0] <= w[1]) && moment.iter().all(|m| (*m as usize) < moments));
    let cell = page.data["cell"].as_f64().expect("a cell");
    assert!((CELL..10.0 * CELL).contains(&cell), "{cell}");
    let mut tiles = vec![Mesh::default(); groups];
    let mut next = 0;
    let initial = 100.0 * 80.0 * 50.0;
    for (k, time) in times.iter().enumerate() {
        while next < parts && moment[next] as usize == k {
            let begin = reader.at;
            let tile = &mut tiles[group[next] as usize];
            *tile = if length[next] > 0 { reader.mesh(true) } else { Mesh::default() };
            assert_eq!(reader.at - begin, length[next] as usize);
            for normal in &tile.normals {
                assert!((normal.norm() - 1.0).abs() < 0.02);
            }
            next += 1;
        }
        let removed: f64 = shown.blocks.iter().filter(|b| b.end_time <= time + 1e-4).map(|b| b.volume_mm3).sum();
        let volume: f64 = tiles.iter().map(Mesh::volume).sum();
        // Faces of the mesh lie within a part of a cell of the cut ones, which are some 8000 mm²; a moment
        // later or earlier is 5000 mm³ away.
        assert!(
            (initial - removed - volume).abs() < 0.25 * cell * 8000.0,
            "at {time}: {volume} of {}",
            initial - removed
        );
        // No block that has not run yet has made a surface.
        let made = tiles.iter().flat_map(|t| &t.made).max().copied().unwrap_or(0);
        let begun = shown.blocks.iter().filter(|b| b.start_time <= *time + 1e-4).map(|b| i64::from(b.block)).max();
        assert!(made <= begun.unwrap_or(-1) + 1, "block {made} at {time}");
        assert!(k == 0 || made > 0 || removed == 0.0, "a cut surface has its block at {time}");
    }
    assert_eq!((next, reader.at), (parts, page.stock.len()));
}

#[test]
fn bodies_and_kinematics_are_those_of_the_machine() {
    let (page, shown) = page();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let machine = Machine::read(&root.join("machines/spinner-u5-620")).expect("machine");
    let count = page.data["meshes"].as_u64().expect("meshes") as usize;
    let mut reader = Reader { bytes: &page.meshes, at: 0 };
    let meshes: Vec<Mesh> = (0..count).map(|_| reader.mesh(false)).collect();
    assert_eq!(reader.at, page.meshes.len());
    let bodies = page.data["bodies"].as_array().expect("bodies");
    assert_eq!(bodies.len(), machine.bodies.len());
    for (body, own) in bodies.iter().zip(&machine.bodies) {
        assert_eq!(body["name"], own.name.as_str());
        let mesh = &meshes[body["mesh"].as_u64().expect("a mesh") as usize];
        let volume = own.mesh.volume();
        // Corners round to a 65,535th of the body.
        assert!(
            (mesh.volume() - volume).abs() < 1e-3 * volume.abs() + 1.0,
            "{}: {} of {volume}",
            own.name,
            mesh.volume()
        );
    }
    // Two tools were in the spindle, each with a cutting part; the others are not in the page.
    let tools = page.data["tools"].as_array().expect("tools");
    let used: Vec<usize> = (0..tools.len()).filter(|t| !tools[*t].is_null()).collect();
    assert_eq!(used, [0, 1]);
    for t in used {
        let parts = tools[t]["parts"].as_array().expect("parts");
        assert!(parts.iter().any(|p| p["role"] == "cutting"));
        assert!(tools[t]["gauge"].as_f64().is_some_and(|g| g > 50.0));
    }
    assert_eq!(page.data["fixtures"][0]["name"], "clamping \"pot\"");
    // Motion of each joint by the data of the page: slides and turns (Rodrigues 1840), chains in order.
    let data = &page.data["kinematics"];
    let list = |v: &Value| -> Vec<f64> {
        v.as_array().expect("a list").iter().map(|n| n.as_f64().expect("a number")).collect()
    };
    let chain = |name: &str| -> Vec<usize> { list(&data[name]).into_iter().map(|j| j as usize).collect() };
    for s in shown.samples.iter().step_by(97) {
        let place = |p: &Point, chain: &[usize]| {
            chain.iter().rev().fold(*p, |p, &j| {
                let joint = &data["joints"][j];
                let axis = Vector::from_row_slice(&list(&joint["axis"]));
                if joint["rotary"] == false {
                    return p + axis * s.actual[j];
                }
                let through = Point::from(Vector::from_row_slice(&list(&joint["point"])));
                let (v, (sin, cos)) = (p - through, s.actual[j].sin_cos());
                through + v * cos + axis.cross(&v) * sin + axis * (axis.dot(&v) * (1.0 - cos))
            })
        };
        let gauge = list(&data["gauge"]);
        let spindle = place(&Point::new(gauge[3], gauge[7], gauge[11]), &chain("tool_chain"));
        let own = machine.machine_from_spindle(&s.actual);
        assert!((spindle.coords - own.translation).norm() < 1e-9);
        let corner = place(&Point::new(10.0, -20.0, 30.0), &chain("work_chain"));
        let table = machine.machine_from_table(&s.actual).point(&Point::new(10.0, -20.0, 30.0));
        assert!((corner - table).norm() < 1e-9);
    }
    assert!(page.bytes < 4_000_000, "{} bytes", page.bytes);
}

#[test]
fn jumps_name_tools_operations_and_findings() {
    let (page, shown) = page();
    let jumps = &page.data["jumps"];
    let texts = |name: &str| -> Vec<String> {
        let all = jumps[name].as_array().expect("jumps");
        all.iter().map(|j| j["text"].as_str().expect("a text").to_owned()).collect()
    };
    assert_eq!(texts("tools").len(), 2);
    assert!(!texts("operations").is_empty());
    let timed = shown.verdict.findings.iter().filter(|f| f.time_s.is_some()).count();
    assert_eq!(texts("findings").len(), timed);
    assert!(texts("findings")[0].starts_with("line 118: "));
}
