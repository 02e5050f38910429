//! Whole runs with gouges and uncut hollows that no ray of the stock meets, clean twins of them, and what the
//! gates say of the limit.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, write_stl};
use proveout_sim::{
    Choice, Prepared,
    finding::{EXCESS, GOUGE},
    run::run,
    verdict::{State, Verdict},
};
use tempfile::TempDir;

const HEAD: &str = "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS8000 M3\n";
const FOOT: &str = "G0 Z60.\nM5\nM30\n";

struct Shop(TempDir);

impl Shop {
    fn new(part: &TriMesh, stock: &TriMesh, diameter: f64) -> Self {
        let shop = Self(tempfile::tempdir().unwrap());
        write_stl(&shop.0.path().join("part.stl"), part).unwrap();
        write_stl(&shop.0.path().join("stock.stl"), stock).unwrap();
        let tools = format!(
            "[[tool]]\nnumber = 1\nname = \"F\"\nkind = \"flat\"\ndiameter_mm = {diameter:.3}\nflute_length_mm = 25.0\n\
             shank_diameter_mm = {diameter:.3}\noverall_length_mm = 140.0\ngauge_length_mm = 140.0\nflutes = 2\n\
             center_cutting = true\n"
        );
        fs::write(shop.0.path().join("tools.toml"), tools).unwrap();
        shop
    }

    fn run(&self, stock: &str, cell: f64, chord_error: f64, moves: &str) -> Verdict {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
        let text = format!(
            "name = \"part\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = {cell}\n[stock]\n{stock}\n[part]\n\
             mesh = \"part.stl\"\nchord_error_mm = {chord_error}\n[mount]\ntranslation_mm = [0, 0, 100]\n[work_offsets.G54]\nZ_mm = 100\n\
             [tolerances]\ngouge_mm = 0.01\nexcess_mm = 0.01\n[control]\ndynamics = \"planned\"\n[[program]]\nname = \"main\"\n\
             file = \"main.nc\"\ndialect = \"fanuc\"\n",
            root.join("machines/three-axis-mill"),
        );
        fs::write(self.0.path().join("scene.toml"), text).unwrap();
        fs::write(self.0.path().join("main.nc"), format!("{HEAD}{moves}{FOOT}")).unwrap();
        let scene: PathBuf = self.0.path().to_owned();
        run(Prepared::read(&scene, &Choice::default()).unwrap(), &mut [], &scene).unwrap().verdict
    }
}

fn gate<'a>(v: &'a Verdict, name: &str) -> (State, &'a str) {
    let gate = v.gates.iter().find(|g| g.gate.name() == name).unwrap();
    (gate.state, &gate.reason)
}

fn worst(v: &Verdict, code: &str) -> Option<f64> {
    v.findings.iter().filter(|f| f.code == code).filter_map(|f| f.value).reduce(f64::max)
}

fn block() -> Aabb {
    Aabb { min: Point::new(-12.0, -12.0, -10.0), max: Point::new(12.0, 12.0, 0.0) }
}

const BLOCK: &str = "box = { min_mm = [-12, -12, -10], max_mm = [12, 12, 0] }";

/// A flat end mill of 6 mm takes a rebate off the edge at Y12 of a block that is turned about Z.
fn along_edge(degrees: f64, across: f64, down: f64, [from, to]: [f64; 2]) -> (TriMesh, String) {
    let turn = Pose::from_axis_angle(&Vector::z(), degrees.to_radians());
    let mut text = String::new();
    let place = |x: f64, y: f64| turn.point(&Point::new(x, y, 0.0));
    let (a, b) = (place(from, 15.0 - across), place(to, 15.0 - across));
    let (ahead, behind) = (place(from, 20.0), place(to, 20.0));
    write!(text, "G0 X{:.6} Y{:.6}\nZ{:.6}\n", ahead.x, ahead.y, -down).unwrap();
    write!(text, "G1 X{:.6} Y{:.6} F800.\nX{:.6} Y{:.6}\nX{:.6} Y{:.6}\n", a.x, a.y, b.x, b.y, behind.x, behind.y)
        .unwrap();
    (box_mesh(&block()).transformed(&turn), text)
}

#[test]
fn an_edge_that_is_cut_off_between_the_rays_fails_and_one_that_is_touched_passes() {
    for (degrees, across, down, way, cell) in [
        (0.0, 0.24, 0.24, [-14.0, 14.0], 0.5),
        (0.0, 0.05, 0.1, [2.0, 2.4], 0.5),
        (23.0, 0.2, 0.3, [-3.0, 1.0], 1.0),
        (45.0, 0.4, 0.4, [-1.0, 1.0], 0.5),
    ] {
        let (part, moves) = along_edge(degrees, across, down, way);
        let shop = Shop::new(&part, &part, 6.0);
        let v = shop.run("mesh = \"stock.stl\"", cell, 0.0001, &moves);
        let depth = across.min(down);
        assert_eq!(gate(&v, "gouge").0, State::Fail, "{degrees} {across}: {}", gate(&v, "gouge").1);
        let found = worst(&v, GOUGE.code).unwrap();
        // If rays meet the gouge, its depth is the deepest on any ray. On a turned edge the deepest place
        // lies between rays, at most half a cell along the edge from the next one that crosses the cut, which
        // falls off at 45 degrees at its ends.
        let least = if degrees == 0.0 { 0.97 * depth } else { depth - 0.25 * cell };
        assert!(found / depth < 1.03 && found > least, "{degrees}: {found} {depth}");
        let (_, moves) = along_edge(degrees, 0.0, 2.0, way);
        let v = shop.run("mesh = \"stock.stl\"", cell, 0.0001, &moves);
        assert_eq!(gate(&v, "gouge").0, State::Pass, "{degrees}: {}", gate(&v, "gouge").1);
    }
}

/// A block with a slot along X from Y y to y + w, 4 mm deep.
fn slotted(y: f64, w: f64) -> TriMesh {
    let outline =
        [[-12.0, -10.0], [12.0, -10.0], [12.0, 0.0], [y + w, 0.0], [y + w, -4.0], [y, -4.0], [y, 0.0], [-12.0, 0.0]];
    let triangles = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7]];
    let n = outline.len() as u32;
    let at = |x: f64| outline.iter().map(move |p: &[f64; 2]| Point::new(x, p[0], p[1]));
    let mut mesh = TriMesh { positions: at(-12.0).chain(at(12.0)).collect(), triangles: Vec::new() };
    for t in triangles {
        mesh.triangles.extend([[t[0], t[2], t[1]], [t[0] + n, t[1] + n, t[2] + n]]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    mesh
}

#[test]
fn a_slot_that_was_left_full_fails_and_the_same_milled_passes() {
    for (y, width, cell) in [(1.03, 0.9, 1.0), (-3.4, 0.3, 1.0), (2.1, 2.0, 0.5)] {
        let shop = Shop::new(&slotted(y, width), &box_mesh(&block()), width);
        let middle = y + 0.5 * width;
        let air = format!("G0 X-20. Y{middle:.4}\nZ5.\nG1 X20. F500.\n");
        let v = shop.run(BLOCK, cell, 0.0001, &air);
        assert_eq!(gate(&v, "excess").0, State::Fail, "{width}: {}", gate(&v, "excess").1);
        let found = worst(&v, EXCESS.code).unwrap();
        assert!(found > 0.3 * width && found <= 0.5 * width + 1e-6, "{width}: {found}");
        let milled = format!("G0 X-20. Y{middle:.4}\nZ-4.\nG1 X20. F500.\n");
        let v = shop.run(BLOCK, cell, 0.0001, &milled);
        assert_eq!(gate(&v, "excess").0, State::Pass, "{width}: {}", gate(&v, "excess").1);
        assert_eq!(gate(&v, "gouge").0, State::Pass, "{width}: {}", gate(&v, "gouge").1);
    }
}

#[test]
fn a_chord_error_beyond_the_tolerance_leaves_the_gates_unchecked_and_the_limit_is_printed() {
    let part = box_mesh(&block());
    let shop = Shop::new(&part, &part, 6.0);
    let cut = "G0 X-20. Y0.\nZ-0.5\nG1 X20. F800.\n";
    let v = shop.run(BLOCK, 0.5, 0.6, cut);
    for name in ["gouge", "excess"] {
        let (state, reason) = gate(&v, name);
        assert_eq!(state, State::Unchecked, "{name}: {reason}");
        assert!(reason.contains("accurate to 0.6 mm") && reason.contains("is 0.01 mm"), "{reason}");
        assert!(reason.contains("limit 0.610"), "the limit that was used: {reason}");
    }
    let v = shop.run(BLOCK, 0.5, 0.002, "G0 X-20. Y0.\nZ0.\nG1 X20. F800.\n");
    let (state, reason) = gate(&v, "gouge");
    assert_eq!(state, State::Pass, "{reason}");
    assert!(reason.contains("gouge limit 0.012") && reason.contains("0.01 mm allowed"), "{reason}");
    let v = shop.run(BLOCK, 0.5, 0.002, cut);
    assert_eq!(gate(&v, "gouge").0, State::Fail);
}
