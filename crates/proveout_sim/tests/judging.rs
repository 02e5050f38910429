//! What a run says of the cut part: gouges one by one, walls that are gone, what the rays cannot show,
//! memory.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use std::{
    f64::consts::PI,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use proveout_geom::{Aabb, Point, TriMesh, box_mesh, write_stl};
use proveout_sim::{
    Choice, Memory, Prepared, SimError,
    finding::{EXCESS, Finding, GOUGE},
    run::run,
    verdict::{State, Verdict},
};
use tempfile::TempDir;

const TOOLS: &str = "[[tool]]\nnumber = 1\nname = \"F10\"\nkind = \"flat\"\ndiameter_mm = 10.0\nflute_length_mm = 25.0\n\
                     shank_diameter_mm = 10.0\noverall_length_mm = 140.0\ngauge_length_mm = 140.0\nflutes = 4\n\
                     center_cutting = true\n[[tool]]\nnumber = 2\nname = \"F4\"\nkind = \"flat\"\ndiameter_mm = 4.0\n\
                     flute_length_mm = 25.0\nshank_diameter_mm = 4.0\noverall_length_mm = 140.0\ngauge_length_mm = 140.0\n\
                     flutes = 2\ncenter_cutting = true\n[[tool]]\nnumber = 3\nname = \"F1\"\nkind = \"flat\"\n\
                     diameter_mm = 1.0\nflute_length_mm = 12.0\nshank_diameter_mm = 1.0\noverall_length_mm = 140.0\n\
                     gauge_length_mm = 140.0\nflutes = 2\ncenter_cutting = true\n";
const HEAD: &str = "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS8000 M3\nG0 X-10. Y-10.\n";
const FOOT: &str = "G0 Z60.\nM5\nM30\n";

/// A folder with a part, tools and scenes. The workpiece zero is the corner of the part.
struct Shop(TempDir);

/// What differs between the scenes.
struct Job<'a> {
    stock: &'a str,
    cell: &'a str,
    tolerance: f64,
    more: &'a str,
    program: &'a str,
}

impl Shop {
    fn new(part: &TriMesh) -> Self {
        let shop = Self(tempfile::tempdir().unwrap());
        write_stl(&shop.0.path().join("part.stl"), part).unwrap();
        fs::write(shop.0.path().join("tools.toml"), TOOLS).unwrap();
        shop
    }

    fn scene(&self, job: &Job<'_>) -> PathBuf {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
        let Job { stock, cell, tolerance, more, program } = job;
        let text = format!(
            "name = \"part\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = {cell}\n[stock]\n{stock}\n[part]\n\
             mesh = \"part.stl\"\n[mount]\ntranslation_mm = [-20, -20, 100]\n[work_offsets.G54]\nX_mm = -20\nY_mm = -20\n\
             Z_mm = 100\n[tolerances]\ngouge_mm = {tolerance}\nexcess_mm = 0.05\n[[program]]\nname = \"main\"\n\
             file = \"main.nc\"\ndialect = \"fanuc\"\n{more}\n",
            root.join("machines/three-axis-mill"),
        );
        fs::write(self.0.path().join("scene.toml"), text).unwrap();
        fs::write(self.0.path().join("main.nc"), program).unwrap();
        self.0.path().to_owned()
    }

    fn run(&self, job: &Job<'_>, threads: usize) -> Result<Verdict, SimError> {
        let scene = self.scene(job);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Ok(run(Prepared::read(&scene, &Choice::default())?, &mut [], &scene)?.verdict))
    }
}

fn gate<'a>(v: &'a Verdict, name: &str) -> (State, &'a str) {
    let gate = v.gates.iter().find(|g| g.gate.name() == name).unwrap();
    (gate.state, &gate.reason)
}

fn of<'a>(v: &'a Verdict, code: &str) -> Vec<&'a Finding> {
    v.findings.iter().filter(|f| f.code == code).collect()
}

/// An outline in X and Z, counter-clockwise seen from -Y, with its triangles, along Y.
fn extruded(outline: &[[f64; 2]], triangles: &[[u32; 3]], length: f64) -> TriMesh {
    let n = outline.len() as u32;
    let at = |y: f64| outline.iter().map(move |p| Point::new(p[0], y, p[1]));
    let mut mesh = TriMesh { positions: at(0.0).chain(at(length)).collect(), triangles: Vec::new() };
    for t in triangles {
        mesh.triangles.extend([*t, [t[0] + n, t[2] + n, t[1] + n]]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.extend([[i, i + n, j + n], [i, j + n, j]]);
    }
    mesh.check_solid().unwrap();
    mesh
}

/// A plate 40 x 40 x 10 mm with a wall of 8 mm from X 20 on.
fn with_wall(t: f64) -> TriMesh {
    let w = 20.0 + t;
    let outline =
        [[0.0, 0.0], [40.0, 0.0], [40.0, 10.0], [w, 10.0], [w, 18.0], [20.0, 18.0], [20.0, 10.0], [0.0, 10.0]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 6], [0, 6, 7], [3, 4, 5], [3, 5, 6]], 40.0)
}

const BLOCK: &str = "box = { min_mm = [0, 0, 0], max_mm = [40, 40, 18] }";

/// Two levels of passes along X or along Y; `lanes` are the other coordinate.
fn passes(lanes: &[f64], along_y: bool) -> String {
    let mut text = HEAD.to_owned();
    for level in [14.0, 10.0] {
        for (k, lane) in lanes.iter().enumerate() {
            let [from, to] = if k % 2 == 0 { [-8.0, 48.0] } else { [48.0, -8.0] };
            let place = |s: f64| if along_y { format!("X{lane:.3} Y{s:.3}") } else { format!("X{s:.3} Y{lane:.3}") };
            if k == 0 {
                write!(text, "G0 Z40.\nG0 {}\nG0 Z{level}\n", place(from)).unwrap();
            }
            write!(text, "G1 {} F2000.\nG1 {}\n", place(from), place(to)).unwrap();
        }
    }
    text + FOOT
}

#[test]
#[ignore = "nightly, 56 s"]
fn a_wall_that_is_milled_away_fails_with_its_thickness_place_and_block() {
    let lanes: Vec<f64> = (0..12).map(|k| -2.0 + 4.0 * f64::from(k)).collect();
    let program = passes(&lanes, false);
    for thickness in [1.0, 0.4, 0.2, 0.07, 0.015] {
        let shop = Shop::new(&with_wall(thickness));
        let job = Job { stock: BLOCK, cell: "0.5", tolerance: 0.02, more: "", program: &program };
        let v = shop.run(&job, 2).unwrap();
        assert_eq!(gate(&v, "gouge").0, State::Fail, "{thickness}: {}", gate(&v, "gouge").1);
        assert_eq!(gate(&v, "excess").0, State::Pass, "{thickness}");
        let found = of(&v, GOUGE.code);
        assert_eq!(found.len(), 1, "{thickness}: {found:?}");
        let f = found[0];
        assert!((f.value.unwrap() - thickness).abs() < 1e-4, "{f:?}");
        assert!(f.message.contains("wall of") && f.message.contains("is cut away"), "{}", f.message);
        // Both sides of 40 x 8 mm; the top and the ends only as far as rays meet them.
        let (area, volume) = (f.area_mm2.unwrap(), f.volume_mm3.unwrap());
        assert!((630.0..700.0 + 60.0 * thickness).contains(&area), "{thickness}: {area}");
        assert!((volume / (320.0 * thickness) - 1.0).abs() < 0.03, "{thickness}: {volume}");
        let [x, y, z] = f.point_mm.unwrap();
        assert!((19.99..20.01 + thickness).contains(&x) && (0.0..=40.0).contains(&y) && (10.0..=18.0).contains(&z));
        // A pass along X, by its line; the first level takes what is above Z14.
        let line = program.lines().nth(f.line.unwrap() as usize - 1).unwrap();
        assert!(line.starts_with("G1 X"), "{line:?}");
        let second = program.lines().position(|l| l == "G0 Z10").unwrap();
        assert_eq!(f.line.unwrap() as usize - 1 > second, z < 14.0, "{f:?}");
        let d = &v.deviation;
        assert_eq!((d.gouges, d.excesses), (Some(1), Some(0)));
        if thickness > 0.02 {
            assert_eq!(d.gouge_max_mm, f.value, "the points of the cut part tell half of it at most");
        }
    }
}

#[test]
fn a_wall_that_stands_passes_at_any_thickness() {
    for (thickness, cell) in [(1.0, "0.5"), (0.2, "0.5"), (0.2, "[0.37, 0.5, 0.5]"), (0.05, "0.5")] {
        let shop = Shop::new(&with_wall(thickness));
        let left = [-3.0, 1.0, 5.0, 9.0, 13.0, 15.0];
        let right = [25.0 + thickness, 29.0, 33.0, 37.0, 41.0, 43.0];
        let both = format!("{}{}", HEAD, around(&left, &right));
        let job = Job { stock: BLOCK, cell, tolerance: 0.02, more: "", program: &both };
        let v = shop.run(&job, 2).unwrap();
        for name in ["gouge", "excess"] {
            assert_eq!(gate(&v, name).0, State::Pass, "{thickness} {cell}: {}\n{:#?}", gate(&v, name).1, v.findings);
        }
        assert!(v.deviation.gouge_max_mm.unwrap() < 1e-3);
    }
}

/// Passes along Y on both sides of a wall, with a retract between, at two levels.
fn around(left: &[f64], right: &[f64]) -> String {
    let mut text = String::new();
    for level in [14.0, 10.0] {
        for lane in left.iter().chain(right) {
            write!(text, "G0 Z40.\nG0 X{lane:.3} Y-12.\nG0 Z{level}\nG1 Y52. F2000.\n").unwrap();
        }
    }
    text + FOOT
}

#[test]
fn gouges_are_reported_one_by_one_the_deepest_first_and_the_rest_is_counted() {
    let part = box_mesh(&Aabb { min: Point::origin(), max: Point::new(100.0, 100.0, 12.0) });
    let shop = Shop::new(&part);
    // Plunges 14 mm apart: every third with 4 mm, the others with 10 mm.
    let mut program = HEAD.to_owned();
    let mut wanted = Vec::new();
    for tool in [1, 2] {
        write!(program, "G0 Z60.\nT{tool} M6\nG0 G43 H{tool} Z60.\nS8000 M3\n").unwrap();
        for k in (0..27).filter(|k| (k % 3 == 0) == (tool == 2)) {
            let (x, y) = (8.13 + 14.0 * f64::from(k % 7), 8.31 + 14.0 * f64::from(k / 7));
            let depth = 0.3 + 0.13 * f64::from(k * 11 % 27);
            write!(program, "G0 X{x} Y{y}\nG0 Z14.\nG1 Z{:.4} F500.\nG4 P200\nG0 Z14.\n", 12.0 - depth).unwrap();
            let line = program.lines().count() as u32 - 2;
            wanted.push((depth, if tool == 2 { 4.0 } else { 10.0 }, line, [x, y]));
        }
    }
    program += FOOT;
    wanted.sort_by(|a: &(f64, f64, u32, [f64; 2]), b| b.0.total_cmp(&a.0));
    let stock = "box = { min_mm = [0, 0, 0], max_mm = [100, 100, 12] }";
    let job = Job { stock, cell: "0.25", tolerance: 0.05, more: "", program: &program };
    let v = shop.run(&job, 2).unwrap();
    let found = of(&v, GOUGE.code);
    assert_eq!(found.len(), 21, "twenty and the rest");
    let (state, reason) = gate(&v, "gouge");
    assert!(state == State::Fail && reason.contains("27 x geometry-gouge"), "{reason}");
    assert_eq!(v.deviation.gouges, Some(27));
    let mut volume = 0.0;
    for (f, (depth, diameter, line, [x, y])) in found[..20].iter().zip(&wanted) {
        assert!((f.value.unwrap() - depth).abs() < 2e-3, "{f:?} {depth}");
        assert_eq!((f.line, f.areas), (Some(*line), Some(1)), "{f:?}");
        let [px, py, _] = f.point_mm.unwrap();
        assert!((px - x).hypot(py - y) <= 0.5 * diameter);
        // Points of a lattice in a disk are off by less than half a cell along its rim.
        let (size, rim) = (0.25 * PI * diameter * diameter, 0.125 * PI * diameter);
        assert!((f.area_mm2.unwrap() - size).abs() <= rim, "{f:?} {size}");
        assert!((f.volume_mm3.unwrap() - size * depth).abs() <= rim * depth + 2e-3 * size, "{f:?}");
        volume += f.volume_mm3.unwrap();
    }
    let rest = found[20];
    let small = &wanted[20..];
    let area = small.iter().map(|w| 0.25 * PI * w.1 * w.1).sum::<f64>();
    assert_eq!((rest.areas, rest.line), (Some(7), None));
    assert!(rest.message.contains("7 more gouges"), "{}", rest.message);
    assert!((rest.area_mm2.unwrap() / area - 1.0).abs() < 0.05, "{rest:?} {area}");
    assert!((rest.value.unwrap() - wanted[20].0).abs() < 2e-3);
    volume += rest.volume_mm3.unwrap();
    assert!((v.deviation.gouge_volume_mm3.unwrap() - volume).abs() < 1e-6);
    // The part is the stock: what is missing was removed.
    assert!((volume / v.removal.volume_mm3 - 1.0).abs() < 0.02, "{volume} {:?}", v.removal);
}

#[test]
fn material_that_is_left_is_reported_area_by_area() {
    // Two pads of the stock are on the design: 12 x 40 mm and what is beyond X 30, 2 and 2 mm high.
    let part = box_mesh(&Aabb { min: Point::origin(), max: Point::new(40.0, 40.0, 10.0) });
    let shop = Shop::new(&part);
    let mut program = HEAD.to_owned();
    for lane in [-4.0, 23.0, 25.0] {
        write!(program, "G0 Z40.\nG0 X{lane:.3} Y-12.\nG0 Z10.\nG1 Y52. F2000.\n").unwrap();
    }
    program += FOOT;
    let stock = "box = { min_mm = [0, 0, 0], max_mm = [40, 40, 12] }";
    let v = shop.run(&Job { stock, cell: "0.5", tolerance: 0.05, more: "", program: &program }, 2).unwrap();
    let found = of(&v, EXCESS.code);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(gate(&v, "excess").1.contains("2 x geometry-excess"));
    // From X 1 to 18, and from 30 to 40.
    let mut areas: Vec<f64> = found.iter().map(|f| f.area_mm2.unwrap()).collect();
    areas.sort_by(f64::total_cmp);
    assert!((areas[0] / 400.0 - 1.0).abs() < 0.05 && (areas[1] / 680.0 - 1.0).abs() < 0.05, "{areas:?}");
    for f in &found {
        assert!(
            (f.value.unwrap() - 2.0).abs() < 1e-3
                && (f.volume_mm3.unwrap() / (2.0 * f.area_mm2.unwrap()) - 1.0).abs() < 0.05
        );
    }
    assert_eq!(gate(&v, "gouge").0, State::Pass, "{}", gate(&v, "gouge").1);
}

/// A pin of 0.2 mm on a plate: at 0.5 mm cells its place decides whether a ray meets it.
fn with_pin(x: f64, y: f64) -> TriMesh {
    let mut mesh = box_mesh(&Aabb { min: Point::origin(), max: Point::new(40.0, 40.0, 10.0) });
    let (low, high) = (Point::new(x - 0.1, y - 0.1, 10.0), Point::new(x + 0.1, y + 0.1, 15.0));
    mesh.append(&box_mesh(&Aabb { min: low, max: high }));
    mesh
}

#[test]
fn what_stands_between_all_rays_and_is_cut_away_is_found_and_says_what_to_do() {
    let lanes: Vec<f64> = (0..12).map(|k| -2.0 + 4.0 * f64::from(k)).collect();
    let program = passes(&lanes, false);
    let between = Shop::new(&with_pin(20.0, 20.0));
    let job = |more| Job { stock: BLOCK, cell: "0.5", tolerance: 0.02, more, program: &program };
    let v = between.run(&job(""), 2).unwrap();
    let (state, reason) = gate(&v, "gouge");
    // No ray meets it: the swept pieces of motion show that it is gone. Its middle lies half its thickness
    // deep.
    assert_eq!(state, State::Fail, "{reason}");
    let found = of(&v, GOUGE.code);
    assert!((found[0].value.unwrap() / 0.1 - 1.0).abs() < 0.03, "{found:?}");
    for word in ["lie between the rays", "X20.", "0.200 mm thick", "[[stock.patch]]", "0.140 mm"] {
        assert!(reason.contains(word), "{word:?} is missing in: {reason}");
    }
    assert_eq!(gate(&v, "excess").0, State::Pass, "{} {:?}", gate(&v, "excess").1, of(&v, EXCESS.code));
    assert_ne!(v.verdict, State::Pass);
    // Where a ray meets it, it is missed.
    let v = Shop::new(&with_pin(20.25, 20.25)).run(&job(""), 2).unwrap();
    assert_eq!(gate(&v, "gouge").0, State::Fail, "{}", gate(&v, "gouge").1);
    // With the cells that the reason names.
    let patch = "[[stock.patch]]\nname = \"pin\"\nmin_mm = [18, 18, 9]\nmax_mm = [22, 22, 16]\ncell_mm = 0.14";
    let v = between.run(&job(patch), 2).unwrap();
    let found = of(&v, GOUGE.code);
    assert_eq!((gate(&v, "gouge").0, found.len()), (State::Fail, 1), "{found:?}");
    // A ray through the middle reads the thickness, one next to it the distance of its deepest point from the
    // nearest face.
    let depth = found[0].value.unwrap();
    assert!((0.04..0.2001).contains(&depth), "{found:?}");
}

#[test]
fn a_design_that_reaches_out_of_the_raw_stock_is_named_as_such() {
    let part = box_mesh(&Aabb { min: Point::origin(), max: Point::new(40.0, 40.0, 18.3) });
    let program = format!("{HEAD}{FOOT}");
    let job = Job { stock: BLOCK, cell: "0.5", tolerance: 0.02, more: "", program: &program };
    let v = Shop::new(&part).run(&job, 1).unwrap();
    let found = of(&v, GOUGE.code);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0].value.unwrap() - 0.3).abs() < 1e-6 && found[0].line.is_none(), "{found:?}");
    assert!(found[0].message.contains("the raw stock has this shape"), "{}", found[0].message);
}

#[test]
fn areas_and_verdict_are_the_same_at_any_thread_count() {
    let lanes: Vec<f64> = (0..12).map(|k| -2.0 + 4.0 * f64::from(k)).collect();
    let program = passes(&lanes, false);
    let shop = Shop::new(&with_wall(0.4));
    let more = "[[stock.patch]]\nname = \"edge\"\nmin_mm = [15, 10, 8]\nmax_mm = [25, 21.3, 20]\ncell_mm = 0.11";
    let job = Job { stock: BLOCK, cell: "0.5", tolerance: 0.02, more, program: &program };
    let bytes = |threads| serde_json::to_string_pretty(&shop.run(&job, threads).unwrap()).unwrap();
    let one = bytes(1);
    assert!(one == bytes(2) && one == bytes(5));
    let v: Verdict = serde_json::from_str(&one).unwrap();
    let found = of(&v, GOUGE.code);
    assert_eq!(found.len(), 1, "one area across the faces of the patch: {found:?}");
    assert!((found[0].volume_mm3.unwrap() / 128.0 - 1.0).abs() < 0.05, "{found:?}");
}

#[test]
#[ignore = "nightly, 88 s"]
fn a_stock_that_outgrows_its_announcement_is_refused_with_the_key_that_helps() {
    let part = box_mesh(&Aabb { min: Point::origin(), max: Point::new(40.0, 40.0, 4.0) });
    let shop = Shop::new(&part);
    // Slots of 1 mm every 1.3 mm along X: 31 of them, and rays across have as many intervals.
    let mut program = HEAD.replace("T1", "T3").replace("H1", "H3");
    for k in 0..31 {
        write!(program, "G0 Z12.\nG0 X-4. Y{:.3}\nG0 Z3.\nG1 X44. F2000.\n", 0.4 + 1.3 * f64::from(k)).unwrap();
    }
    program += FOOT;
    let scene = |more: &str| {
        let stock = format!("box = {{ min_mm = [0, 0, 0], max_mm = [40, 40, 4] }}\n{more}");
        shop.scene(&Job { stock: &stock, cell: "[0.02, 1.0, 0.02]", tolerance: 0.05, more: "", program: &program })
    };
    let read_with_memory = |scene: &Path| {
        let mut memory: Option<Memory> = None;
        let prepared = Prepared::read_announced(scene, &Choice::default(), &mut |m| memory = Some(m.clone())).unwrap();
        (prepared, memory.unwrap())
    };
    let path = scene("intervals_per_ray = 1");
    let (prepared, before) = read_with_memory(&path);
    assert_eq!(prepared.memory, before);
    let error = run(prepared, &mut [], &path).unwrap_err();
    let SimError::Memory { used_mib, announced_mib, intervals, remedy, .. } = &error else { panic!("{error}") };
    assert!(used_mib > announced_mib && *intervals > 1.5, "{error}");
    assert!(error.to_string().contains("planned for it"), "{error}");
    // The remedy is a line of the scene, and helps.
    let key = remedy.split('`').nth(1).unwrap();
    let path = scene(key);
    let (prepared, after) = read_with_memory(&path);
    assert!(after.stocks[0].1 > before.stocks[0].1 && after.total() > before.total());
    run(prepared, &mut [], &path).unwrap();
}

#[test]
fn a_key_for_intervals_that_is_none_is_refused_at_its_place() {
    let shop = Shop::new(&box_mesh(&Aabb { min: Point::origin(), max: Point::new(40.0, 40.0, 18.0) }));
    let stock = format!("{BLOCK}\nintervals_per_ray = 0.5");
    let job = Job { stock: &stock, cell: "1.0", tolerance: 0.02, more: "", program: FOOT };
    let Err(SimError::Input(e)) = shop.run(&job, 1) else { panic!("0.5 intervals are refused") };
    assert!(e.line == 7 && e.message.contains("0.5") && e.remedy.contains("from 1 to 1000"), "{e:?}");
}
