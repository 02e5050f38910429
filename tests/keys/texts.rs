//! Texts that the setups are made of.

use std::fs;

use proveout_tests::root;

pub(crate) const MILL: &str = r#"
name = "mill"
up = [0, 0, 1]

[[joint]]
name = "X"
kind = "linear"
carries = "workpiece"
parent = "base"
direction = [1, 0, 0]
sense = -1
travel_mm = [-200, 200]
home_mm = 20
tool_change_mm = 25
max_velocity_mm_min = 20_000
rapid_velocity_mm_min = 18_000
max_acceleration_mm_s2 = 3000
max_jerk_mm_s3 = 60_000

[joint.drive]
position_gain_1_s = 60
velocity_gain_N_s_m = 30_000
integral_time_ms = 9
velocity_feed_forward = 0.9
acceleration_feed_forward = 0.9
max_force_N = 4000
viscous_friction_N_s_m = 150
coulomb_friction_N = 30
static_friction_N = 45
stribeck_velocity_mm_min = 150
backlash_mm = 0.002
encoder = "load"
elastic_frequency_hz = 100
elastic_damping = 0.08
motor_mass_kg = 60

[[joint]]
name = "Y"
kind = "linear"
carries = "workpiece"
parent = "X"
direction = [0, 1, 0]
sense = -1
travel_mm = [-200, 200]
home_mm = 30
max_velocity_mm_min = 20_000
max_acceleration_mm_s2 = 3000
max_jerk_mm_s3 = 60_000
moving_mass_kg = 90
drive = { position_gain_1_s = 60, velocity_bandwidth_hz = 50, max_force_N = 4000 }

[[joint]]
name = "Z"
kind = "linear"
carries = "tool"
parent = "base"
direction = [0, 0, 1]
travel_mm = [20, 300]
home_mm = 160
max_velocity_mm_min = 20_000
max_acceleration_mm_s2 = 3000
max_jerk_mm_s3 = 60_000
drive = { position_gain_1_s = 60, velocity_bandwidth_hz = 50, integral_time_ms = 10, max_force_N = 9000, counterbalance_N = 500 }

[spindle]
on = "Z"
origin_mm = [0, 0, 0]
direction = [0, 0, 1]
max_speed_rpm = 6000
start_time_s = 0.02

[table]
on = "Y"
point_mm = [0, 0, 0]
normal = [0, 0, 1]

[control]
cycle_time_ms = 4
block_time_ms = 0.5
tool_change_time_s = 0.1
rapid_mode = "straight"
default_tolerance_mm = 0.05
default_orientation_tolerance_deg = 0.1

[body_density]
default_kg_m3 = 2500
roles_kg_m3 = { table = 4500 }

[[body]]
name = "bed"
role = "bed"
attached_to = "base"
check = true
box = [{ min_mm = [-300, -300, -200], max_mm = [300, 300, -100] }]

[[body]]
name = "table"
role = "table"
attached_to = "Y"
color = [10, 20, 30]
check = true
box = [{ min_mm = [-60, -60, -40], max_mm = [60, 60, 0] }]

[[body]]
name = "head"
role = "head"
attached_to = "Z"
check = true
mass = { density_kg_m3 = 1500 }
prism = [{ along = "z", range_mm = [60, 200], outline_mm = [[-60, -60], [60, -60], [60, 60], [-60, 60]] }]

[[body]]
name = "nose"
role = "nose"
attached_to = "Z"
check = true
mass = { mass_kg = 12, center_mm = [0, 0, 30], inertia_kg_m2 = [0.02, 0.02, 0.01, 0, 0, 0] }
cylinder = [{ from_mm = [0, 0, 0], to_mm = [0, 0, 60], radius_mm = 30 }]

[[body]]
name = "saddle"
role = "saddle"
attached_to = "X"
check = true
box = [{ min_mm = [-60, -60, -98], max_mm = [60, 60, -85] }]

[[body]]
name = "slide"
role = "slide"
attached_to = "Y"
check = true
box = [{ min_mm = [-60, -60, -80], max_mm = [60, 60, -66] }]

[[body]]
name = "motor"
role = "motor"
attached_to = "Z"
check = true
cylinder = [{ from_mm = [0, 0, 210], to_mm = [0, 0, 260], radius_mm = 40 }]
"#;

pub(crate) const TOOLS: &str = r#"
[[tool]]
number = 1
name = "END_D6"
kind = "flat"
diameter_mm = 6
flute_length_mm = 12
neck_diameter_mm = 5
neck_length_mm = 8
transition_length_mm = 2
shank_diameter_mm = 6
overall_length_mm = 60
gauge_length_mm = 80
flutes = 3
center_cutting = true
max_speed_rpm = 9000
source = "catalogue"
chosen = [{ keys = ["flutes"], reason = "usual" }]

[tool.holder]
name = "chuck"
sections = [{ diameter_mm = 20, top_diameter_mm = 30, length_mm = 30 }, { diameter_mm = 40, length_mm = 15 }]
"#;

pub(crate) const SCENE: &str = r#"
name = "keys"
machine = "machine"
tools = "tools.toml"
resolution_mm = 0.5
engagement = true

[stock]
box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }

[mount]
translation_mm = [0, 0, 40]
rotation_deg = [0, 0, 0]

[work_offsets.G54]
Z_mm = 40

[[fixture]]
name = "clamp"
box = { min_mm = [17, -10, -40], max_mm = [25, 10, 3] }

[tolerances]
near_miss_mm = 0.5

[[program]]
name = "main"
file = "main.nc"

[[inspect]]
name = "floor"
from_mm = [-5.25, 0.25, 5]
direction = "-z"
nominal_mm = -2
tolerance_mm = 0.01
"#;

/// A slot with a corner and an arc, a short block, a rapid that touches the block by 0.3 mm, and another
/// offset.
pub(crate) const PROGRAM: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS4000 M3\nG0 X-22. Y0.25\nZ4.\nG1 Z-2. F1500\n\
                       X0.\nX0.1\nY4.\nG2 X4. Y8. I4. J0.\nG0 Z4.\nX-10. Y-6.\nZ-0.3\nZ4.\nG1 Z2. F1500\nG0 Z12.\nM5\nM30\n%\n";

pub(crate) const FIVE_PROGRAM: &str = "N10 G17 G710 G90 G94\nN20 T=\"END_D6\"\nN30 M6\nN40 G54 D1\nN50 S4000 M3\nN60 TRAORI\nN70 ORIAXES\n\
                            N80 G0 X-22 Y0.25 Z8 B0 C0\nN90 G1 Z-1 F1500\nN100 G64\nN110 G1 X-10 B6 C10\nN120 G1 X0 Y3 B10 C-14\n\
                            N130 G1 X8 Y4 B2 C5\nN140 G0 Z20\nN142 ORIVECT\n\
                            N144 G0 A3=0.173648178 B3=0.000012031 C3=0.984807753\n\
                            N146 G0 A3=-0.173648178 B3=0.000012031 C3=0.984807753\nN150 TRAFOOF\nN160 G0 B-5 C30\nN170 M5\nN180 M30\n";

pub(crate) const HYBRID_PROGRAM: &str = "N10 G17 G710 G90 G94\nN20 T=\"END_D6\"\nN30 M6\nN40 G54 D1\nN50 S4000 M3\nN60 G0 A0 B0\nN70 G1 Z-60 A6 F2000\n\
                              N80 G1 Z-80 A-4\nN90 M5\nN100 M30\n";

fn rotary_joint(name: &str, parent: &str, direction: &str, limits: &str) -> String {
    format!(
        "\n[[joint]]\nname = \"{name}\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"{parent}\"\ndirection = {direction}\n\
         point_mm = [0, 0, 20]\nsense = -1\n{limits}\nmax_acceleration_deg_s2 = 900\n\
         max_jerk_deg_s3 = 20_000\n\n[joint.drive]\nposition_gain_1_s = 40\nvelocity_gain_Nm_s_rad = 900\nmax_torque_Nm = 600\n\
         viscous_friction_Nm_s_rad = 4\ncoulomb_friction_Nm = 3\nstatic_friction_Nm = 5\nstribeck_velocity_deg_s = 3\n\
         backlash_deg = 0.001\nencoder = \"load\"\nelastic_frequency_hz = 80\nelastic_damping = 0.1\nmotor_inertia_kg_m2 = 0.4\n"
    )
}

/// The mill with B and C between Y and the table; the drives of its slides are those of the mill.
pub(crate) fn five() -> String {
    let b = rotary_joint(
        "B",
        "Y",
        "[0, 1, 0]",
        "travel_deg = [-30, 100]\nhome_deg = 3\ntool_change_deg = 4\nmax_velocity_deg_s = 180\nrapid_velocity_deg_s = 150",
    );
    let c =
        rotary_joint("C", "B", "[0, 0, 1]", "endless = true\nmax_velocity_rev_min = 30\nrapid_velocity_rev_min = 25");
    let joints = b + &c + "\n[spindle]";
    let cradle = "\n[[body]]\nname = \"cradle\"\nrole = \"cradle\"\nattached_to = \"B\"\ncheck = true\n\
                  box = [{ min_mm = [-15, -15, -56], max_mm = [15, 15, -42] }]\n";
    let text = (MILL.to_owned() + cradle).replacen("\n[spindle]", &joints, 1).replace("on = \"Y\"", "on = \"C\"");
    let mass = "mass = { mass_kg = 30, center_mm = [5, 0, -20], inertia_kg_m2 = [0.2, 0.2, 0.3, 0, 0, 0] }";
    text.replace("role = \"table\"\nattached_to = \"Y\"", &format!("role = \"table\"\nattached_to = \"C\"\n{mass}"))
}

/// The joints, platform and table of a machine of the library on legs, without its bodies.
pub(crate) fn hybrid() -> String {
    hybrid_of("machines/lu-hybrid-ii/machine.toml")
}

/// The same with drives at its legs and at its other joints.
pub(crate) fn hybrid_servo() -> String {
    hybrid_of("scenes/lu-2022-quasi-circle/machine-ii.toml")
}

fn hybrid_of(path: &str) -> String {
    let text = fs::read_to_string(root().join(path)).unwrap_or_default();
    let text = text.split("# Bodies: ").next().unwrap_or_default().to_owned();
    let kept = text.lines().filter(|l| !l.starts_with("model =") && !l.starts_with("roles_kg_m3"));
    kept.collect::<Vec<_>>().join("\n")
        + "\n[[body]]\nname = \"bed\"\nrole = \"bed\"\nattached_to = \"base\"\ncheck = true\n\
         box = [{ min_mm = [-900, -900, -300], max_mm = [900, 900, -200] }]\n"
}

/// A box as text of an STL file; `hole` leaves its last triangle out.
pub(crate) fn stl(min: [f64; 3], max: [f64; 3], turned: bool) -> Vec<u8> {
    let corner = |k: usize| -> [f64; 3] { std::array::from_fn(|i| if k >> i & 1 == 1 { max[i] } else { min[i] }) };
    // Corners of the faces, counter-clockwise seen from outside.
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid box\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            let triangle = if turned { [triangle[0], triangle[2], triangle[1]] } else { triangle };
            text += "facet normal 0 0 0\nouter loop\n";
            for k in triangle {
                let [x, y, z] = corner(k);
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    (text + "endsolid box\n").into_bytes()
}

pub(crate) const PART: &str = r#"
[part]
mesh = "part.stl"
chord_error_mm = 0.001
judged_box = { min_mm = [-14, -9, -9], max_mm = [14, 9, 5] }
"#;

pub(crate) const CONE: &str = r#"
[part.cone_frustum]
apex_mm = [0, 0, 30]
axis = [0, 0, -1]
half_angle_deg = 20
from_mm = 24
to_mm = 38
reach_mm = 6
"#;

pub(crate) const BLADE_PART: &str = r#"
[part.blade]
chord_mm = 60
camber_angle_deg = 60
thickness_mm = 8
leading_radius_mm = 1.6
trailing_radius_mm = 1.2
length_mm = 25
twist_deg_per_mm = 0.1
platform = { fillet_radius_mm = 10, margin_mm = 14, thickness_mm = 12 }
chord_error_mm = 0.2
"#;

/// Rows of 0.2 mm on a plane, and what is asked of it.
pub(crate) const SURFACE: &str = r#"
[part]
mesh = "part.stl"
chord_error_mm = 0.0001

[surface]
model = "envelope"
size_mm = [0.6, 0.4]
step_um = 50
max_height_mm = 0.5
standard = "iso21920"
class = "Sc2"
profiles = true
random_phases = 2
seed = 1
save_nodes = true

[[surface.patch]]
name = "own"
at_mm = [-5, 0, -1]
along = [1, 0.2, 0]
size_mm = [0.5, 0.5]
step_um = 40

[[surface.patch]]
name = "plane"
at_mm = [3, 0, -1]
normal = [0, 0, 1]

[[surface.grid]]
name = "grid"
count = [2, 1]
corner_mm = [-8, 0, -1]
u_mm = [2, 0, 0]
v_mm = [0, 0.1, 0]

[[surface.grid]]
name = "spaced"
spacing_mm = [1, 1]
corner_mm = [6, 0, -1]
u_mm = [1.5, 0, 0]
v_mm = [0, 0.1, 0]

[[surface.profile]]
name = "lay"
at_mm = [-2, 0, -1]
direction = "along"

[[surface.profile]]
name = "line"
at_mm = [-2, 0.1, -1]
normal = [0, 0, 1]
along = [1, 0, 0]
"#;

pub(crate) const SURFACE_PROGRAM: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS4000 M3\nG0 X-20. Y-0.4\nZ-1.\nG1 X20. F1500\nY-0.2\n\
                       X-20.\nY0.\nX20.\nY0.2\nX-20.\nY0.4\nX20.\nG0 Z12.\nM5\nM30\n%\n";

/// Places on a blade.
pub(crate) const SURFACE_BLADE: &str = r#"
[surface]
size_mm = [0.6, 0.4]
step_um = 50

[[surface.patch]]
name = "own"
arc_mm = 20
x_mm = 17

[[surface.grid]]
name = "grid"
count = [2, 2]
arc_mm = [15, 25]
x_mm = [14, 18]

[[surface.profile]]
name = "line"
arc_mm = 22
x_mm = 17
along = [1, 0, 0]
"#;

pub(crate) const HELIX: &str = r#"
[plan.helix]
tool = "BALL_D16"
spindle_rpm = 8000
feed_mm_min = 1000
work_offset = "G54"
allowance_mm = 0.0
head_tilt_deg = 5
lead_deg = 15
from_x_mm = 12
to_x_mm = 13.5
pitch_mm = 1
step_mm = 4
start = 0.3
clearance_mm = 10
tolerance_mm = 0.01
"#;

/// Every strategy of contacts, a few lines each.
pub(crate) fn paths() -> String {
    let tables = [
        ("transverse", "lines = [0.2, 0.3]\nacross = [0.2, 0.3]\none_way = true"),
        ("iso-parametric", "lines = [0.3, 0.31]\nalong = [0.2, 0.6]\nparameter = \"surface\""),
        (
            "iso-planar",
            "scallop_mm = 0.1\nnormal = [0, 1, 0]\nacross_mm = [0, 2]\nacross = [0.6, 0.8]\nalong = [0.2, 0.6]",
        ),
        ("pocket", "lines = [0.1, 0.3]\nacross = [0.2, 0.3]\nalong = [0.2, 0.6]\noutwards = true"),
        ("constant-scallop", "scallop_mm = 0.1\nacross = [0.2, 0.22]\nalong = [0.2, 0.6]"),
        (
            "quasi-circle",
            "scallop_mm = 0.1\nacross_deg = [85, 90]\nalong = [0.2, 0.6]\nfocus_inside = 0.01\ntrailing = 0.0",
        ),
        ("row", "at = 0.3\nalong = [0.2, 0.6]"),
        ("point-roughing", "lines = [0.3]\nfrom_allowance_mm = 0.4\ndepth_mm = 0.2\nallowance_mm = 0.1\nstart = 0.3"),
    ];
    let mut text = String::new();
    for (name, keys) in tables {
        let axis = match name {
            "row" => {
                "{ rule = \"interpolated\", axes = [{ part = 0, direction = [0.1, -0.9, -0.4] }, { part = 1, direction = [0.2, -0.9, -0.3] }] }"
            }
            _ => "{ rule = \"fixed-head\", table = [1, 0, 0], head_deg = 5, lead_deg = 15 }",
        };
        let step = if name == "pocket" { "step_mm = 2" } else { "chord_error_mm = 0.01\nlongest_step_mm = 4" };
        text += &format!(
            "\n[plan.{name}]\ntool = \"BALL_D16\"\nspindle_rpm = 8000\nfeed_mm_min = 1000\nwork_offset = \"G54\"\ntolerance_mm = 0.01\n\
             axis = {axis}\nlift_mm = 2\nclearance_mm = 10\n{step}\n{keys}\n"
        );
    }
    text
}

/// A side that is ruled along the blade, by the flank.
pub(crate) const FLANK: &str = r#"
[plan.flank]
tool = "BALL_D16"
spindle_rpm = 8000
feed_mm_min = 1000
work_offset = "G54"
tolerance_mm = 0.01
axis = { rule = "ruling", points = [0.2, 0.8] }
lift_mm = 2
clearance_mm = 10
chord_error_mm = 0.01
across = [0.7, 0.8]
along = [0.55, 0.95]
rulings = "along"
beyond_end_mm = 1
flank_error_mm = 0.01
"#;

pub(crate) const COMPARE: &str = r#"
[compare]
baseline = "main"
experiment = "words"
trimmed_ends_s = 0.1
plot_window_s = [0.1, 0.3]
draws = 2

[[compare.choice]]
name = "velocity limit"
key = "machine.X.max_velocity_mm_min"
range = [500, 900]
source = "chosen"
reason = "words"

[[compare.choice]]
name = "tolerance"
key = "control.path_tolerance_mm"
values = [0.01, 0.1]
source = "chosen"
reason = "words"

[[compare.published]]
name = "velocity"
program = "other"
against = "main"
quantity = "demand-velocity"
axis = "X"
value = 10
band = [5, 15]
source = "a paper"
remark = "words"

[[compare.published]]
name = "time"
program = "other"
against = "main"
quantity = "stretch-time"
form = "rate"
value = 10
source = "a paper"

[[compare.expect]]
name = "reversals"
program = "other"
quantity = "reversals"
axis = "X"
at_least = 0
at_most = 9
source = "a paper"

[[compare.expect]]
name = "gate"
program = "other"
gate = "limits"

[[compare.expect]]
name = "faster"
program = "other"
against = "main"
quantity = "stretch-time"
form = "rate"
at_least = -500
"#;

/// A tool library with one tool of a kind; its shape keys are given.
pub(crate) fn one_tool(kind: &str, shape: &str) -> String {
    format!(
        "[[tool]]\nnumber = 1\nname = \"END_D6\"\nkind = \"{kind}\"\n{shape}\ngauge_length_mm = 80\n\
         holder = {{ sections = [{{ diameter_mm = 20, length_mm = 30 }}] }}\n"
    )
}

/// The first turn and a half of a pass round a blade.
pub(crate) fn shortened(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let motion = |l: &&str| l.starts_with('X') || l.starts_with("G1 X");
    let (Some(first), Some(last)) = (lines.iter().position(motion), lines.iter().rposition(motion)) else {
        return String::new();
    };
    let kept = lines.iter().take(first + 560).chain(lines.iter().skip(last + 1)).copied();
    kept.collect::<Vec<_>>().join("\n") + "\n"
}
