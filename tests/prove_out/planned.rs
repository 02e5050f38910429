//! Programs that are planned, run by the twin: what they leave is what the plan said.

use std::{fmt::Write as _, fs, path::Path};

use proveout_blade::{Domain, Local, ParametricSurface};
use proveout_geom::{Point, Vector};
use proveout_machine::Machine;
use proveout_nc::Dialect;
use proveout_sim::planning::{Planned, plan, plan_over};
use proveout_sim::scene::{Scene, StrategyFile};
use proveout_sim::verdict::{State, Verdict};
use proveout_sim::{Choice, Prepared, programs};
use proveout_tests::{prove, root};
use proveout_tool::ToolLibrary;

/// mm; 1 micrometer of chord, 2 of rounding by the control, 1 of the sweep.
pub(crate) const CHORD_MM: f64 = 0.001;
pub(crate) const TOLERANCE_MM: f64 = 0.002;
pub(crate) const GOUGE_MM: f64 = CHORD_MM + 0.001 + TOLERANCE_MM;
/// Ridge that is asked for, um.
const RIDGE_UM: f64 = 10.0;

/// A blade on the Starrag type, as in the scene of Li et al., 25 mm high.
fn blade_scene(plan: &str, more: &str) -> String {
    let root = root();
    format!(
        r#"
name = "planned"
workholding = "none"
workholding_reason = "not part of this test"
machine = "{root}/machines/starrag-lx-451"
tools = "{root}/tools/li-2022.toml"
resolution_mm = 1.0
[part.blade]
chord_mm = 60
camber_angle_deg = 60
thickness_mm = 8
leading_radius_mm = 1.6
trailing_radius_mm = 1.2
length_mm = 25
twist_deg_per_mm = 0.1
platform = {{ fillet_radius_mm = 10, margin_mm = 14, thickness_mm = 12 }}
chord_error_mm = 0.01
[stock]
blade_allowance_mm = 0.3
[mount]
translation_mm = [260, 0, 0]
[work_offsets.G54]
X_mm = 260
[tolerances]
gouge_mm = {GOUGE_MM}
excess_mm = 0.05
near_miss_mm = 0
scallop_um = 20
{plan}
{more}
"#,
        root = root.display()
    )
}

fn table(strategy: &str, keys: &str) -> String {
    format!(
        "[plan.{strategy}]\ntool = \"BALL_D16\"\nspindle_rpm = 8000\nfeed_mm_min = 1000\nwork_offset = \"G54\"\n\
         tolerance_mm = {TOLERANCE_MM}\naxis = {{ rule = \"fixed-head\", table = [1, 0, 0], head_deg = 5, lead_deg = 15 }}\n\
         lift_mm = 2\nclearance_mm = 10\nchord_error_mm = {CHORD_MM}\n{keys}\n"
    )
}

fn strategy(name: &str) -> StrategyFile {
    StrategyFile::named(name).expect("a strategy")
}

/// Plans, writes the program next to the scene, and judges the part between the lines but for the outermost
/// ones.
fn planned_in(
    folder: &Path,
    text: impl Fn(&str) -> String,
    name: &str,
    surface: Option<&dyn ParametricSurface>,
) -> Planned {
    let path = folder.join("scene.toml");
    fs::write(&path, text("")).expect("written");
    let scene = Scene::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let machine = Machine::read(&scene.resolve(&scene.file.machine)).expect("machine");
    let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).expect("tools");
    let made = match surface {
        Some(surface) => plan_over(&scene, &machine, &tools, strategy(name), surface),
        None => plan(&scene, &machine, &tools, strategy(name)),
    };
    let made = made.unwrap_or_else(|e| panic!("{name}: {e}"));
    let settings = Prepared::reader_settings(&scene, None).expect("settings");
    let program = programs::text(&made.commands, Dialect::Siemens840d, &settings).expect("posted");
    fs::write(folder.join("main.mpf"), program).expect("written");
    // The box of the contacts, 1.2 mm inside of the ends of lines, with the outermost lines left out.
    let lines = &made.lines[..];
    let inner = if lines.len() > 2 { &lines[1..lines.len() - 1] } else { lines };
    let points: Vec<Point> = inner.iter().flat_map(|l| l.contacts.iter().map(|c| c.place.point)).collect();
    let bound = |k: usize, f: fn(f64, f64) -> f64, start| points.iter().map(|p| p[k]).fold(start, f);
    // Lines round the blade lie side by side along X.
    let ends = if ["transverse", "point-roughing"].contains(&name) { 0.0 } else { 1.2 };
    let aside = if lines.len() == 1 { 0.5 } else { 0.0 };
    let inside = [ends, -aside, 0.0];
    let low: Vec<f64> = (0..3).map(|k| bound(k, f64::min, f64::MAX) + inside[k]).collect();
    let high: Vec<f64> = (0..3).map(|k| bound(k, f64::max, f64::MIN) - inside[k]).collect();
    let mut more = String::new();
    let _ = write!(
        more,
        "[part.judged_box]\nmin_mm = [{}, {}, {}]\nmax_mm = [{}, {}, {}]\n[[program]]\nname = \"main\"\nfile = \"main.mpf\"\n",
        low[0],
        low[1],
        low[2] - 0.2,
        high[0],
        high[1],
        high[2] + 0.2
    );
    fs::write(&path, text(&more)).expect("written");
    made
}

pub(crate) fn proved(folder: &Path) -> Verdict {
    prove(folder, &Choice::default(), 2).unwrap_or_else(|e| panic!("{e}")).verdict
}

pub(crate) fn gates_pass(name: &str, verdict: &Verdict, gates: &[&str]) {
    for gate in gates {
        let gate = verdict.gates.iter().find(|g| g.gate.name() == *gate).expect("every gate is there");
        assert_eq!(gate.state, State::Pass, "{name}: {gate:?}\n{:#?}", verdict.findings);
    }
}

/// The gouge is what chord error, sweep and rounding allow; the ridges are those asked for.
pub(crate) fn as_planned(name: &str, made: &Planned, verdict: &Verdict, everywhere: bool) {
    gates_pass(name, verdict, &["program", "limits", "process", "collision", "gouge"]);
    let gouge = verdict.deviation.gouge_max_mm.expect("measured");
    let ridges = &verdict
        .surface
        .scallop
        .as_ref()
        .unwrap_or_else(|| panic!("{name}: {:?} {:?} {:?}", verdict.surface, verdict.deviation, made.report.joints))
        .all;
    println!(
        "{name}: {} contacts, gouge {:.2} um, ridges mean {:.2} p95 {:.2} max {:.2} um, planned {:.2} um",
        made.report.contacts,
        1e3 * gouge,
        ridges.mean_um,
        ridges.p95_um,
        ridges.max_um,
        made.report.scallop_um.as_ref().map_or(0.0, |s| s.value)
    );
    assert!(gouge <= GOUGE_MM, "{name}: {gouge}");
    assert!((ridges.max_um / RIDGE_UM - 1.0).abs() < 0.1, "{name}: {ridges:?}");
    if everywhere {
        assert!((ridges.p95_um / RIDGE_UM - 1.0).abs() < 0.1, "{name}: {ridges:?}");
        assert!((ridges.mean_um / RIDGE_UM - 1.0).abs() < 0.1, "{name}: {ridges:?}");
    }
}

fn ridge_test(name: &str, label: &str, keys: &str, everywhere: bool) {
    let folder = tempfile::tempdir().expect("a folder");
    let made = planned_in(folder.path(), |more| blade_scene(&table(name, keys), more), name, None);
    as_planned(label, &made, &proved(folder.path()), everywhere);
}

const SCALLOP: &str = "scallop_mm = 0.01";

#[test]
fn quasi_circle_lines_leave_the_ridges_asked_for_on_the_convex_and_the_concave_side() {
    ridge_test("quasi-circle", "convex", &format!("{SCALLOP}\nacross_deg = [85, 96]\nalong = [0.2, 0.6]"), true);
    ridge_test("quasi-circle", "concave", &format!("{SCALLOP}\nacross_deg = [264, 275]\nalong = [0.2, 0.6]"), true);
}

#[test]
fn lines_of_constant_scallop_leave_it_everywhere_on_both_sides() {
    // Parts of the round from the leading end of the pressure side.
    ridge_test("constant-scallop", "concave", &format!("{SCALLOP}\nacross = [0.2, 0.24]\nalong = [0.2, 0.6]"), true);
    ridge_test("constant-scallop", "convex", &format!("{SCALLOP}\nacross = [0.72, 0.76]\nalong = [0.2, 0.6]"), true);
}

#[test]
fn other_strategies_leave_what_they_plan() {
    ridge_test("iso-parametric", "iso", &format!("{SCALLOP}\nacross = [0.72, 0.76]\nalong = [0.2, 0.6]"), true);
    ridge_test("transverse", "transverse", &format!("{SCALLOP}\nacross = [0.62, 0.78]\nalong = [0.15, 0.8]"), false);
}

/// A plane, z = 0.
#[derive(Debug)]
struct Plane;

impl ParametricSurface for Plane {
    fn domain(&self) -> Domain {
        Domain { u: [-15.0, 15.0], v: [-10.0, 10.0], u_closed: false }
    }
    fn local(&self, u: f64, v: f64) -> Local {
        let zero = Vector::zeros();
        Local {
            point: Point::new(v, u, 0.0),
            normal: Vector::z(),
            first: [Vector::y(), Vector::x()],
            second: [zero; 3],
        }
    }
    fn nearest(&self, p: &Point) -> [f64; 2] {
        [p.y.clamp(-15.0, 15.0), p.x.clamp(-10.0, 10.0)]
    }
}

/// Scene of a plane on a machine: a face of a block with 0.3 mm on it.
fn plane_scene(machine: &str, mount_z: f64, table: &str, more: &str) -> String {
    // The part's tables are together.
    let (judged, program) = more.split_at(more.find("[[program]]").unwrap_or(0));
    format!(
        "name = \"plane\"\nworkholding = \"none\"\nworkholding_reason = \"not part of this test\"\nmachine = \"{0}/machines/{machine}\"\ntools = \"{0}/tools/li-2022.toml\"\nresolution_mm = 0.5\n\
         [part]\nmesh = \"part.stl\"\nchord_error_mm = 0.0001\n{judged}\n\
         [stock]\nbox = {{ min_mm = [-15, -15, -10], max_mm = [15, 15, 0.3] }}\n\
         [mount]\ntranslation_mm = [0, 0, {mount_z}]\n[work_offsets.G54]\nZ_mm = {mount_z}\n\
         [tolerances]\ngouge_mm = {GOUGE_MM}\nexcess_mm = 0.05\nnear_miss_mm = 0\nscallop_um = 20\n{table}\n{program}",
        root().display()
    )
}

fn on_plane(machine: &str, mount_z: f64, name: &str, axis: &str, keys: &str) -> (Planned, Verdict) {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("part.stl"), block([-15.0, -15.0, -10.0], [15.0, 15.0, 0.0])).expect("written");
    let table = table(name, keys);
    let from = table.find("axis = ").expect("the axis");
    let to = from + table[from..].find('\n').expect("the end of its line");
    let table = format!("{}axis = {axis}{}", &table[..from], &table[to..]);
    let made = planned_in(folder.path(), |more| plane_scene(machine, mount_z, &table, more), name, Some(&Plane));
    let verdict = proved(folder.path());
    (made, verdict)
}

const LEAD: &str = "{ rule = \"lead-tilt\", lead_deg = 10 }";

fn block(low: [f64; 3], high: [f64; 3]) -> Vec<u8> {
    let corner = |k: usize| -> [f64; 3] { std::array::from_fn(|i| if k >> i & 1 == 1 { high[i] } else { low[i] }) };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid block\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for k in triangle {
                let [x, y, z] = corner(k);
                let _ = writeln!(text, "vertex {x} {y} {z}");
            }
            text += "endloop\nendfacet\n";
        }
    }
    (text + "endsolid block\n").into_bytes()
}

#[test]
fn a_plane_has_the_ridges_asked_for() {
    let keys = "scallop_mm = 0.01\nparameter = \"surface\"\nacross = [0.2, 0.5]\nalong = [0.1, 0.9]";
    let (made, verdict) = on_plane("bc-trunnion", 60.0, "iso-parametric", LEAD, keys);
    as_planned("plane", &made, &verdict, true);
    let keys = "scallop_mm = 0.01\nnormal = [0, 1, 0]\nacross_mm = [-5, 3]\nalong = [0.1, 0.9]";
    let (made, verdict) = on_plane("bc-trunnion", 60.0, "iso-planar", LEAD, keys);
    as_planned("planes", &made, &verdict, true);
}

#[test]
fn rings_and_a_single_row_cut_no_deeper_than_planned() {
    let keys = "scallop_mm = 0.01\nacross = [0.3, 0.6]\nalong = [0.2, 0.8]";
    let (made, verdict) = on_plane("bc-trunnion", 60.0, "pocket", LEAD, keys);
    gates_pass("pocket", &verdict, &["program", "limits", "process", "collision", "gouge"]);
    let ridges = &verdict.surface.scallop.as_ref().expect("ridges").all;
    println!("pocket: {} lines, {ridges:?}", made.report.lines);
    assert!(ridges.p95_um <= 1.1 * RIDGE_UM && made.report.lines > 20, "{ridges:?}");
    let axis = "{ rule = \"interpolated\", axes = [{ part = 0, direction = [0.2, 0, 1] }, { part = 1, direction = [-0.2, 0.1, 1] }] }";
    let (made, verdict) =
        on_plane("bc-trunnion", 60.0, "row", axis, "at = 0.5\nalong = [0.9, 0.1]\nlongest_step_mm = 2");
    gates_pass("row", &verdict, &["program", "limits", "process", "collision", "gouge"]);
    assert!(made.report.lines == 1 && verdict.deviation.samples.expect("judged") > 10);
}

/// A grinder whose control has no tool center point control gets joint positions.
#[test]
fn a_control_without_tool_center_point_control_gets_joints() {
    let keys =
        "scallop_mm = 0.01\nparameter = \"surface\"\nacross = [0.3, 0.5]\nalong = [0.1, 0.9]\nlongest_step_mm = 1";
    let axis = "{ rule = \"inclination-tilt\", inclination_deg = 12, tilt_deg = 30 }";
    let (made, verdict) = on_plane("bc-head-table-grinder", 60.0, "iso-parametric", axis, keys);
    assert_eq!(made.report.posted, "joints");
    // To and fro turns the axis by half a turn of C from line to line: out there, not in the part.
    as_planned("joints", &made, &verdict, true);
}

#[test]
fn a_blade_from_solid_in_layers_keeps_its_allowance() {
    let keys = "lines = [0.2, 0.24, 0.28, 0.32]\nallowance_mm = 0.1\nfrom_allowance_mm = 0.2\ndepth_mm = 0.1\nlongest_step_mm = 2";
    let folder = tempfile::tempdir().expect("a folder");
    let made =
        planned_in(folder.path(), |more| blade_scene(&table("point-roughing", keys), more), "point-roughing", None);
    let verdict = proved(folder.path());
    gates_pass("roughing", &verdict, &["program", "limits", "process", "collision", "gouge"]);
    assert_eq!(made.report.lines, 8);
    let left = verdict.deviation.excess_max_mm.expect("measured");
    println!("roughing: {} contacts, {:?}", made.report.contacts, verdict.deviation);
    // The ridge between lines 0.6 mm apart is 6 um.
    assert!((0.1..0.115).contains(&left), "{left}");
}

/// A cutter that the concave side does not take is refused with its place; a key that the strategy does not
/// read, by its name.
#[test]
fn what_cannot_be_planned_is_refused_by_name() {
    let refused = |keys: &str, name: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("scene.toml");
        fs::write(&path, blade_scene(&table(name, keys), "")).expect("written");
        let scene = Scene::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let machine = Machine::read(&scene.resolve(&scene.file.machine)).expect("machine");
        let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).expect("tools");
        plan(&scene, &machine, &tools, strategy(name)).map(|_| ()).expect_err("refused").to_string()
    };
    let message = refused("scallop_mm = 0.01\nlines = [0.5]", "iso-parametric");
    assert!(message.contains("the distance of the lines must be given exactly once"), "{message}");
    let message = refused("scallop_mm = 0.01\noutwards = true", "iso-parametric");
    assert!(message.contains("does not read `outwards`"), "{message}");
    // The head of 87 degrees cannot lie along the blade.
    let message = refused("lines = [0.3]\nalong = [0.2, 0.4]\nstep_mm = 1", "iso-parametric");
    assert!(message.contains("step along the lines must be given exactly once"), "{message}");
    let message = refused("lines_deg = [0, 10]\nallowance_mm = -1", "quasi-circle");
    assert!(message.contains("allowance_mm = -1"), "{message}");
}
