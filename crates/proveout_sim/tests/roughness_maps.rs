//! Roughness maps from scene, program and tool files alone.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use std::{
    f64::consts::{PI, TAU},
    fs,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
};

use proveout_sim::{
    Choice, Observer, Prepared, SimError, SurfaceTexture,
    observer::{Batch, ObserverError, Outcome, Setup},
    run::run,
    verdict::{State, Verdict},
};
use tempfile::TempDir;

/// Keeps the textures of a run.
struct Keeper(Arc<Mutex<Vec<SurfaceTexture>>>);

impl Observer for Keeper {
    fn name(&self) -> &'static str {
        "keeper"
    }

    fn begin(&mut self, _: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _: &Setup<'_>, _: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn surface_texture(&mut self, _: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        self.0.lock().unwrap().push(texture.clone());
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, _: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// A block of 10 x 5 mm under the tools of a job on the three-axis mill.
struct Job<'a> {
    dynamics: &'a str,
    tools: &'a str,
    program: &'a str,
    /// Tolerances, `[surface]`.
    more: &'a str,
}

impl Job<'_> {
    fn write(&self) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
        let scene = format!(
            "name = \"map\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 0.5\n[stock]\n\
             box = {{ min_mm = [0, 0, -5], max_mm = [10, 5, 0.5] }}\n[mount]\ntranslation_mm = [0, 0, 100]\n\
             [work_offsets.G54]\nZ_mm = 100\n[control]\ndynamics = {:?}\n[[program]]\nname = \"main\"\nfile = \"main.nc\"\n\
             dialect = \"fanuc\"\n{}\n",
            root.join("machines/three-axis-mill"),
            self.dynamics,
            self.more,
        );
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        fs::write(folder.path().join("tools.toml"), self.tools).unwrap();
        fs::write(folder.path().join("main.nc"), self.program).unwrap();
        let path = folder.path().to_owned();
        (folder, path)
    }

    fn run(&self) -> Result<(Verdict, Vec<SurfaceTexture>), SimError> {
        let (_folder, path) = self.write();
        let kept: Arc<Mutex<Vec<SurfaceTexture>>> = Arc::default();
        let keeper = Keeper(Arc::clone(&kept));
        let verdict = run(Prepared::read(&path, &Choice::default())?, &mut [Box::new(keeper)], &path)?.verdict;
        let textures = kept.lock().unwrap().clone();
        Ok((verdict, textures))
    }

    fn refused(&self) -> String {
        match self.run() {
            Ok(_) => "it ran".into(),
            Err(e) => e.to_string(),
        }
    }
}

/// Two round inserts, D = 10 mm, on a path along +Y at X5: Duong, Nguyen 2026, case A1, turning
/// counter-clockwise.
const FACE_MILL: &str = "[[tool]]\nnumber = 1\nname = \"FACE\"\nkind = \"bull_nose\"\ndiameter_mm = 20\ncorner_radius_mm = 5\n\
    flute_length_mm = 8\ngauge_length_mm = 150\nflutes = 2\nhand = \"left\"\ncenter_cutting = false\n[tool.edges]\n\
    radial_run_out_mm = [0, 0.011]\naxial_run_out_mm = [0, 0.003]\nradial_rake_deg = 0.6\n\
    round_insert = { nose_circle_diameter_mm = 10, insert_radius_mm = 5 }\n";
const CUTTING_SPEED: f64 = 170_000.0;
const FEED_TOOTH: f64 = 0.6;

fn face_program(spindle: &str) -> String {
    let turns = CUTTING_SPEED / (PI * 10.0);
    let feed = FEED_TOOTH * 2.0 * turns;
    format!(
        "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS{turns:.9} {spindle}\nG0 X5. Y-30.\nZ0.\nG1 Y40. F{feed:.9}\n\
         G0 Z60.\nM5\nM30\n"
    )
}

fn face_surface(n: usize, phase: &str) -> String {
    format!(
        "[surface]\nmodel = \"teeth\"\nprofiles = false\nrandom_phases = 3\nmax_height_mm = 0.5\n[[surface.patch]]\nname = \"face\"\n\
         at_mm = [5, 2.5, 0]\nnormal = [0, 0, 1]\nalong = [1, 0, 0]\nsize_mm = [10, 5]\nstep_um = {}\n{phase}",
        5000.0 / n as f64
    )
}

const PHASE: &str = "[[surface.phase]]\nat_mm = [5, -5, 0]\ntooth_deg = 180\n";

/// Height of a point by the published equations, roots of the contact by bisection: shares nothing with the
/// product.
fn height(x: f64, y: f64) -> f64 {
    let turns = CUTTING_SPEED / 60.0 / (PI * 10.0);
    let (w, v, rake) = (TAU * turns, FEED_TOOTH * 2.0 * turns, 0.6_f64.to_radians());
    let (radius, depth) = (5.0_f64, 0.5);
    let mut lowest: f64 = depth;
    for k in 0..2 {
        let (rho, up) = (5.0 + f64::from(k) * 0.011, f64::from(k) * 0.003);
        let angle = |t: f64| PI / 2.0 + f64::from(k) * PI - w * t - rake;
        let center = |t: f64| -5.0 + v * t;
        let f = |t: f64| angle(t).cos() * (y - center(t)) + angle(t).sin() * (x - 5.0);
        let along = |t: f64| angle(t).cos() * (x - 5.0) - angle(t).sin() * (y - center(t));
        // Sixty parts of a revolution over the whole passage.
        let step = TAU / w / 60.0;
        let mut t = -2.0 * TAU / w;
        while t < 25.0 / v {
            let (mut a, mut b) = (t, t + step);
            t = b;
            if f(a) * f(b) > 0.0 || along(0.5 * (a + b)) < 0.0 {
                continue;
            }
            for _ in 0..60 {
                let m = 0.5 * (a + b);
                if f(a) * f(m) <= 0.0 { b = m } else { a = m }
            }
            let off = along(0.5 * (a + b)) - rho;
            if off.abs() < radius {
                lowest = lowest.min(up + radius - (radius * radius - off * off).sqrt());
            }
        }
    }
    lowest
}

#[test]
fn a_face_mill_leaves_the_published_surface_from_its_files_alone() {
    let n = 100;
    let more = face_surface(n, PHASE);
    let program = face_program("M4");
    let job = Job { dynamics: "ideal", tools: FACE_MILL, program: &program, more: &more };
    let (verdict, textures) = job.run().unwrap();
    let map = textures[0].map.as_ref().unwrap();
    assert_eq!((map.columns, map.rows), (2 * n + 1, n + 1));
    let used = &verdict.surface.textures[0];
    assert!(used.unchecked.is_empty(), "{:?}", used.unchecked);
    assert!(used.phases.is_none(), "the phase is known");
    let mut worst = 0.0_f64;
    for (p, h) in map.points.iter().zip(&map.heights) {
        worst = worst.max((h - height(p.x, p.y)).abs());
    }
    assert!(worst < 1e-6, "heights within 1e-3 um: {worst} mm");
    assert_eq!(used.blocks[0].line, Some(8));
    assert!(used.blocks[0].percent > 99.9);
}

/// The published path begins in the work: with a spindle that starts there the files give the published Sa,
/// and say what the standing tool did on its way.
#[test]
fn a_path_that_begins_in_the_work_has_the_published_sa() {
    let turns = CUTTING_SPEED / (PI * 10.0);
    let feed = FEED_TOOTH * 2.0 * turns;
    let program = format!(
        "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nG0 X5. Y-5.\nZ0.\nS{turns:.9} M4\nG1 Y15. F{feed:.9}\nM5\nG0 Z60.\nM30\n"
    );
    for (n, published) in [(25, 1.48499349337313), (50, 1.5998235023622), (100, 1.58088191701734)] {
        let more = face_surface(n, PHASE);
        let (verdict, _) = Job { dynamics: "ideal", tools: FACE_MILL, program: &program, more: &more }.run().unwrap();
        let used = &verdict.surface.textures[0];
        // data/raw/ladder_dt_regimes.csv of the published repository.
        assert!((used.sa_um.unwrap() - published).abs() < 1e-6, "n {n}: {:?} against {published}", used.sa_um);
        assert!(used.unchecked.iter().any(|u| u.contains("without spindle speed")), "{:?}", used.unchecked);
    }
}

#[test]
fn the_other_way_round_is_another_surface_and_a_random_phase_is_reported() {
    let program = face_program("M3");
    let tools = FACE_MILL.replace("hand = \"left\"\n", "");
    let run = |program: &str, tools: &str, phase: &str| {
        let more = face_surface(50, phase);
        Job { dynamics: "ideal", tools, program, more: &more }.run().unwrap()
    };
    let (_, there) = run(&face_program("M4"), FACE_MILL, PHASE);
    let (_, back) = run(&program, &tools, PHASE);
    let heights = |t: &[SurfaceTexture]| t[0].map.clone().unwrap().heights;
    let apart = heights(&there).iter().zip(&heights(&back)).fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
    // Mirrored along X, and the rake with it.
    assert!(apart > 1e-4, "{apart}");
    let mirrored =
        heights(&back).chunks(101).flat_map(|row| row.iter().rev().copied().collect::<Vec<_>>()).collect::<Vec<f64>>();
    let apart = heights(&there).iter().zip(&mirrored).fold(0.0_f64, |a, (x, y)| a.max((x - y).abs()));
    assert!(apart < 1e-6, "{apart}");
    let (verdict, _) = run(&program, &tools, "");
    let spread = verdict.surface.textures[0].phases.clone().unwrap();
    assert_eq!(spread.repeats, 3);
    let [low, high] = spread.sz_um;
    assert!(low < high && spread.sa_um[0] <= spread.sa_um[1], "{spread:?}");
}

const BALL: &str = "[[tool]]\nnumber = 1\nname = \"BALL\"\nkind = \"ball\"\ndiameter_mm = 6\nflute_length_mm = 20\n\
    gauge_length_mm = 150\nflutes = 2\n[tool.edges]\nradial_run_out_mm = [0, 0.004]\n";

/// Passes along X, 0.2 mm apart, over the whole block.
fn rows() -> String {
    let mut text = String::from("G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS6000 M3\n");
    for k in -5..=31 {
        let y = 0.2 * f64::from(k);
        text += &format!("G0 X-6. Y{y:.3}\nG0 Z0.\nG1 X16. F1200\nG0 Z2.\n");
    }
    text + "G0 Z60.\nM5\nM30\n"
}

const ROWS: &str = "[surface]\nsize_mm = [2, 2]\nstep_um = 20\n[[surface.patch]]\nname = \"top\"\nat_mm = [5, 2.5, 0]\nnormal = [0, 0, 1]\n";

fn surface_gate(v: &Verdict) -> (State, String) {
    let gate = v.gates.iter().find(|g| g.gate.name() == "surface").unwrap();
    (gate.state, gate.reason.clone())
}

#[test]
fn rows_of_a_ball_have_the_roughness_of_their_arcs() {
    let program = rows();
    let tools = format!("{BALL}[tool.residual]\nra_um = [0, 0.05]\nrz_um = [0, 0.2]\nsource = \"own trials\"\n");
    // An envelope has no marks of the teeth along the path: 0.407 um of Ra and 1.584 um of Rz at most, in
    // addition to the residual of the tool.
    for (limit, state) in [
        ("ra_um = 0.9\nrz_um = 3.5", State::Pass),
        ("ra_um = 0.85", State::Unchecked),
        ("ra_um = 0.1", State::Fail),
        ("ra_um = 0.5\nrz_um = 0.5", State::Fail),
    ] {
        let more = format!("[tolerances]\n{limit}\n{ROWS}");
        let (verdict, textures) =
            Job { dynamics: "planned", tools: &tools, program: &program, more: &more }.run().unwrap();
        let (is, reason) = surface_gate(&verdict);
        assert_eq!(is, state, "{limit}: {reason}");
        assert_eq!(verdict.findings.iter().any(|f| f.code == "surface-roughness"), state == State::Fail);
        assert!(reason.contains("top at X5.000 Y2.500 Z0.000"), "{reason}");
        let used = &verdict.surface.textures[0];
        // Arcs of 3 mm at 0.2 mm: p^2 / 8 R up to fourth order; nothing is taken away at a pitch of a quarter
        // of lambda_c but 0.5 percent.
        let (ra, rq) = proveout_surface::texture::cusp::arc_ra_rq(3.0, 0.2).unwrap();
        let across = &used.profiles[0];
        assert_eq!(across.direction, "across the lay");
        let [low, high] = across.ra_um.unwrap();
        assert_eq!(low, high);
        assert!((low - 1e3 * ra).abs() < 0.02 * 1e3 * ra, "{low} against {}", 1e3 * ra);
        assert!(rq > ra);
        // Next to it the model of rows of a torus, of which a ball is one; both unfiltered.
        let model = across.analytic.as_ref().unwrap_or_else(|| panic!("{:?}", used.remarks));
        assert!((model.pitch_mm - 0.2).abs() < 1e-3, "{model:?}");
        assert!((model.radius_mm - 3.0).abs() < 1e-6 && model.curvature_per_mm.abs() < 1e-9, "{model:?}");
        assert!((model.ra_um - 1e3 * ra).abs() < 0.003 * 1e3 * ra, "{model:?} against {}", 1e3 * ra);
        assert!(model.difference_um.abs() < 0.005 * 1e3 * ra && model.feed_per_tooth_mm.is_none(), "{model:?}");
        assert!((used.sz_um.unwrap() - 1e3 * 0.04 / 24.0).abs() < 0.01, "{:?}", used.sz_um);
        assert_eq!(across.report["class"], "Sc3");
        assert_eq!(across.report["lambda_c_mm"], 0.8);
        // The marks run along the columns.
        let lay = textures[0].map.as_ref().unwrap().lay_deg.unwrap();
        assert!(lay.min(180.0 - lay) < 1.0, "{lay}");
        let along =
            used.profiles[1].ra_um.unwrap_or_else(|| panic!("{:?} {:?}", used.profiles[1].report, used.remarks));
        assert!(along[1] < 0.01, "flat along the marks");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let program = face_program("M3");
    let tools = FACE_MILL.replace("hand = \"left\"\n", "");
    let more = face_surface(50, "");
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Job { dynamics: "planned", tools: &tools, program: &program, more: &more }.run().unwrap())
    };
    let ((mut one, single), (mut many, several)) = (run(1), run(3));
    // The folders of the two runs have their own names.
    for block in [&mut one, &mut many].into_iter().flat_map(|v| &mut v.surface.textures).flat_map(|t| &mut t.blocks) {
        block.file = None;
    }
    assert_eq!(one.surface, many.surface);
    let bits =
        |t: &[SurfaceTexture]| -> Vec<u64> { t[0].map.iter().flat_map(|m| &m.heights).map(|h| h.to_bits()).collect() };
    assert_eq!(bits(&single), bits(&several));
}

#[test]
fn what_a_tool_states_of_its_residual_counts_on_top() {
    let program = rows();
    let judged = |residual: &str, limit: f64| {
        let tools = format!("{BALL}{residual}");
        let more = format!("[tolerances]\nra_um = {limit}\n{ROWS}");
        let (verdict, _) = Job { dynamics: "planned", tools: &tools, program: &program, more: &more }.run().unwrap();
        (surface_gate(&verdict).0, verdict.surface.textures[0].residual.clone())
    };
    let (state, none) = judged("", 0.6);
    assert_eq!((state, none.ra_um), (State::Unchecked, [0.0, 0.0]));
    assert_eq!(none.source, "BALL states none: unknown, not zero");
    let residual = "[tool.residual]\nra_um = [0.1, 0.3]\nrz_um = [0.4, 1]\nsource = \"own trials\"\n";
    // About 0.43 um of the motion alone, and up to 0.41 um of the marks of the teeth, which an envelope does
    // not have.
    assert_eq!(judged(residual, 0.6).0, State::Unchecked, "0.53 to 1.13 um");
    assert_eq!(judged(residual, 0.8).0, State::Unchecked, "0.53 to 1.13 um");
    assert_eq!(judged(residual, 1.2).0, State::Pass);
    assert_eq!(judged(residual, 0.5).0, State::Fail);
    let turned = residual.replace("[0.1, 0.3]", "[0.3, 0.1]");
    let tools = format!("{BALL}{turned}");
    let output = Job { dynamics: "planned", tools: &tools, program: &program, more: ROWS }.refused();
    assert!(output.contains("ra_um"), "{output}");
}

#[test]
fn what_cannot_be_evaluated_is_named_and_unchecked() {
    let program = rows();
    let reason = |dynamics: &str, tools: &str, program: &str, more: &str| {
        let more = format!("[tolerances]\nra_um = 0.5\n{more}");
        let (verdict, _) = Job { dynamics, tools, program, more: &more }.run().unwrap();
        let (state, reason) = surface_gate(&verdict);
        assert_eq!(state, State::Unchecked, "{reason}");
        reason
    };
    // Nothing cuts there.
    let beside = ROWS.replace("[5, 2.5, 0]", "[5, 30, 0]");
    assert!(reason("planned", BALL, &program, &beside).contains("nodes are not cut"), "beside");
    // The teeth are not described.
    let teeth = ROWS.replace("[surface]", "[surface]\nmodel = \"teeth\"\nrandom_phases = 1");
    let bare = BALL.split("[tool.edges]").next().unwrap();
    let message = reason("planned", bare, &program, &teeth);
    assert!(message.contains("tool \"BALL\" has no [tool.edges]"), "{message}");
    // The spindle is at rest while it goes through.
    let standing = program.replace("S6000 M3", "M5");
    let message = reason("planned", BALL, &standing, &teeth);
    assert!(message.contains("without spindle speed") && message.contains("main.nc:"), "{message}");
    // Run-out of 4 um against a chip of 1 um.
    let slow = program.replace("F1200", "F12");
    let slow: String = slow.lines().take(9).map(|l| format!("{l}\n")).collect::<String>() + "G0 Z60.\nM5\nM30\n";
    let thin = teeth.replace("[5, 2.5, 0]", "[-3.5, -1, 0]").replace("[2, 2]", "[0.2, 0.2]");
    let message = reason("planned", BALL, &slow, &thin);
    assert!(message.contains("run-out"), "{message}");
    // The phase is asked for at a place that the tip never passes.
    let phase = format!("{teeth}[[surface.phase]]\nat_mm = [5, 2.5, 3]\ntooth_deg = 0\n");
    let message = reason("planned", BALL, &program, &phase);
    assert!(message.contains("spindle phase"), "{message}");
    // No place at all.
    let message = reason("planned", BALL, &program, "");
    assert!(message.contains("no patch or profile"), "{message}");
}

#[test]
fn places_off_the_surface_are_refused_by_name() {
    let program = rows();
    let refused = |more: &str| Job { dynamics: "planned", tools: BALL, program: &program, more }.refused();
    let patch = |keys: &str| format!("[surface]\n[[surface.patch]]\nname = \"p\"\n{keys}\n");
    for (more, words) in [
        (patch("at_mm = [0, 0, 0]"), "no design part"),
        (patch("normal = [0, 0, 1]"), "its place must be given exactly once"),
        (patch("at_mm = [0, 0, 0]\nnormal = [0, 0, 0]"), "not a direction"),
        (patch("at_mm = [0, 0, 0]\nnormal = [0, 0, 1]\nalong = [0, 0, 1]"), "is perpendicular"),
        (patch("at_mm = [0, 0, 0]\nnormal = [0, 0, 1]\nsize_mm = [4, 0.001]"), "shorter than two steps"),
        (patch("at_mm = [0, 0, 0]\nnormal = [0, 0, 1]\nsize_mm = [400, 400]"), "nodes are more"),
        ("[surface]\nrandom_phases = 0\n".into(), "random_phases = 0"),
        ("[surface]\nmax_height_mm = -1\n".into(), "max_height_mm"),
        (
            "[surface]\n[[surface.profile]]\nname = \"q\"\nat_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n".into(),
            "its direction must be given exactly once",
        ),
        ("[surface]\n[[surface.phase]]\nat_mm = [0, 0, 0]\ntooth_deg = 0\n".into(), "no phase"),
        ("[surface]\n[[surface.grid]]\nname = \"g\"\ncount = [2, 2]\n".into(), "its region must be given exactly once"),
        ("[tolerances]\nra_um = 0\n".into(), "ra_um = 0"),
        ("[surface]\nstep = 3\n".into(), "`surface.step` is not a known key"),
    ] {
        let text = refused(&more);
        assert!(text.contains(words), "{more}: {text}");
    }
    let part = "[part]\nmesh = \"part.stl\"\n";
    let with_part = |more: &str| {
        let more = format!("{part}{more}");
        let job = Job { dynamics: "planned", tools: BALL, program: &program, more: &more };
        let (_folder, path) = job.write();
        let solid = proveout_geom::box_mesh(&proveout_geom::Aabb {
            min: proveout_geom::Point::new(0.0, 0.0, -5.0),
            max: proveout_geom::Point::new(10.0, 5.0, 0.0),
        });
        proveout_geom::write_stl(&path.join("part.stl"), &solid).unwrap();
        match Prepared::read(&path, &Choice::default()) {
            Ok(_) => "it was read".to_owned(),
            Err(e) => e.to_string(),
        }
    };
    let text = with_part(&patch("at_mm = [5, 2.5, 7]"));
    assert!(text.contains("patch \"p\": X5.000 Y2.500 Z7.000 lies 7.000 mm away from the design"), "{text}");
    let text = with_part(&patch("at_mm = [9, 2.5, 0]"));
    assert!(text.contains("patch \"p\": it leaves the surface of the design, or runs over an edge"), "{text}");
    assert_eq!(with_part(&patch("at_mm = [5, 2.5, 0.2]")), "it was read");
    let text = with_part(&patch("arc_mm = 3\nx_mm = 2"));
    assert!(text.contains("belong to a blade"), "{text}");
}

/// Five axes: the tip runs straight while table and head turn evenly, so that the housing of the spindle
/// turns in the workpiece.
mod five_axes {
    use super::*;
    use proveout_geom::{Point, Pose, Vector, rad};

    const FEED: f64 = 1800.0;
    const SPEED: f64 = 3000.0;
    const FROM: [f64; 3] = [-6.0, 1.0, 0.0];
    const TO: [f64; 3] = [6.0, 2.0, 0.1];
    const B: [f64; 2] = [20.0, 26.0];
    const C: [f64; 2] = [10.0, 55.0];
    const RUN_OUT: [f64; 2] = [0.0, 0.006];
    const TOOTH: f64 = 40.0;

    fn orientation(u: f64) -> Pose {
        let angle = |[a, b]: [f64; 2]| rad(a + (b - a) * u);
        Pose::from_axis_angle(&Vector::z(), angle(C)) * Pose::from_axis_angle(&Vector::y(), angle(B))
    }

    /// The least height over a node by scanning time: at each time the plane of an edge meets the vertical
    /// line in one height, and the arc in it is passed where the distance from its center changes sign.
    fn height(x: f64, y: f64, parts: f64) -> f64 {
        let (from, to) = (Point::from(FROM), Point::from(TO));
        let way = to - from;
        let duration = way.norm() / (FEED / 60.0);
        let rate = -SPEED / 60.0 * TAU;
        // The first tooth is at 40 degrees from the feed direction when the motion begins.
        let start = orientation(0.0);
        let feed = start.inverse().vector(&way);
        let zero = feed.y.atan2(feed.x) + rad(TOOTH);
        let mut lowest = f64::INFINITY;
        for (k, off) in RUN_OUT.iter().enumerate() {
            let at = |t: f64| {
                let u = t / duration;
                let housing = orientation(u);
                let azimuth = zero + PI * k as f64 + rate * t;
                let tooth = housing.vector(&Vector::new(azimuth.cos(), azimuth.sin(), 0.0));
                let axis = housing.vector(&Vector::z());
                let across = axis.cross(&tooth);
                let base = Point::new(x, y, 0.0) - (from + way * u);
                let h = -across.dot(&base) / across.z;
                let q = base + Vector::z() * h;
                let (side, up) = (q.dot(&tooth) - off, q.dot(&axis) - 3.0);
                (h, side.hypot(up) - 3.0, side, up)
            };
            let step = 60.0 / SPEED / parts;
            let mut t = 0.0;
            while t < duration {
                let (mut a, mut b) = (t, t + step);
                t = b;
                let (fa, fb) = (at(a), at(b));
                if fa.1 * fb.1 > 0.0 || fa.0.abs() > 0.5 || fb.0.abs() > 0.5 || fa.2 < -0.01 || fa.3 > 0.0 {
                    continue;
                }
                for _ in 0..50 {
                    let m = 0.5 * (a + b);
                    if at(m).1 * fa.1 <= 0.0 { b = m } else { a = m }
                }
                let found = at(0.5 * (a + b));
                if found.2 >= 0.0 {
                    lowest = lowest.min(found.0);
                }
            }
        }
        lowest
    }

    #[test]
    #[ignore = "nightly, 17 s"]
    fn the_spindle_turns_in_a_housing_that_turns_in_the_workpiece() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let scene = format!(
            "name = \"five\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 1\n[stock]\n\
             box = {{ min_mm = [-5, -5, -10], max_mm = [5, 5, 0.2] }}\n[mount]\ntranslation_mm = [0, 0, 140]\n\
             [work_offsets.G54]\nZ_mm = 140\n[control]\ndynamics = \"ideal\"\n[[program]]\nname = \"main\"\nfile = \"main.mpf\"\n\
             dialect = \"siemens-840d\"\n[surface]\nmodel = \"teeth\"\nprofiles = false\n[[surface.patch]]\nname = \"p\"\n\
             at_mm = [0, 1.5, 0]\nnormal = [0, 0, 1]\nalong = [1, 0, 0]\nsize_mm = [2, 1]\nstep_um = 200\n[[surface.phase]]\n\
             at_mm = {FROM:?}\ntooth_deg = {TOOTH}\n",
            root.join("machines/spinner-u5-620"),
        );
        let [[x0, y0, z0], [x1, y1, z1]] = [FROM, TO];
        let program = format!(
            "N10 G17 G710 G90 G94\nN20 T=\"BALL\"\nN30 M6\nN40 G54 D1\nN50 S{SPEED} M3\nN60 TRAORI\nN70 ORIAXES\n\
             N80 G0 X{x0} Y{y0} Z30 B{} C{}\nN90 G0 X{x0} Y{y0} Z{z0}\nN100 G1 X{x1} Y{y1} Z{z1} B{} C{} F{FEED}\nN110 G0 Z40\n\
             N120 TRAFOOF\nN130 M5\nN140 M30\n",
            B[0], C[0], B[1], C[1]
        );
        let tools = "[[tool]]\nnumber = 1\nname = \"BALL\"\nkind = \"ball\"\ndiameter_mm = 6\nflute_length_mm = 20\n\
                     gauge_length_mm = 150\nflutes = 2\n[tool.edges]\nradial_run_out_mm = [0, 0.006]\n";
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        fs::write(folder.path().join("tools.toml"), tools).unwrap();
        fs::write(folder.path().join("main.mpf"), program).unwrap();
        let kept: Arc<Mutex<Vec<SurfaceTexture>>> = Arc::default();
        let prepared = Prepared::read(folder.path(), &Choice::default()).unwrap();
        let verdict = run(prepared, &mut [Box::new(Keeper(Arc::clone(&kept)))], folder.path()).unwrap().verdict;
        let used = &verdict.surface.textures[0];
        assert!(used.unchecked.is_empty(), "{:?}", used.unchecked);
        let map = kept.lock().unwrap()[0].map.clone().unwrap();
        let mut worst = 0.0_f64;
        for (p, h) in map.points.iter().zip(&map.heights) {
            let mut wanted = height(p.x, p.y, 1000.0);
            // Near the axis of a ball an edge passes a node in and out within a thousandth of a turn.
            if *h < wanted - 1e-6 {
                wanted = height(p.x, p.y, 50_000.0);
            }
            worst = worst.max((h - wanted).abs());
        }
        // Pieces stay within 0.5 um of the motion anywhere between tip and gauge line, 150 mm away: near the
        // tip within a fraction of it.
        assert!(worst < 1e-5, "{worst} mm; Sz {:?}", used.sz_um);
        assert!(used.sz_um.unwrap() > 3.0, "{:?}", used.sz_um);
    }
}
