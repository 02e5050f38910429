//! Small scenes in which the keys act: a block of 30 x 20 x 10 mm on machines of a few boxes, a few seconds
//! of motion.

use std::{collections::BTreeMap, fs};

use proveout_tests::root;

use crate::keys::texts::{
    BLADE_PART, COMPARE, CONE, FIVE_PROGRAM, FLANK, HELIX, HYBRID_PROGRAM, MILL, PART, PROGRAM, SCENE, SURFACE,
    SURFACE_BLADE, SURFACE_PROGRAM, TOOLS, five, hybrid, hybrid_servo, one_tool, paths, shortened, stl,
};

/// Text of a file, or its bytes, by its name.
pub(crate) type Files = BTreeMap<String, Vec<u8>>;

const ENDED_BLADE_PART: &str = r#"
[part.blade]
kind = "lu"
chord_error_mm = 0.5
root = { x_mm = 2, platform = { fillet_radius_mm = 3, thickness_mm = 6, y_mm = [-30, 30], z_mm = [-30, 30] } }
tip = { x_mm = 97 }
"#;

const SECTIONS_PART: &str = r#"
[part]
sections = "sections.csv"

[part.blade]
kind = "sections"
chord_error_mm = 0.2
root = { x_mm = 0 }
tip = { x_mm = 30 }
"#;

/// One of each kind, in addition to what the machine does.
const HELD: &str = r#"
[[fixture]]
name = "vise"
kind = "vise"
at_mm = [100, 0, 0]
rotation_deg = [0, 0, 30]
opening_mm = 20
jaw_width_mm = 40
jaw_height_mm = 15
jaw_thickness_mm = 8
bed_height_mm = 12

[[fixture]]
name = "plate"
kind = "plate"
at_mm = [100, 0, -30]
length_mm = 60
width_mm = 50
thickness_mm = 5

[[fixture]]
name = "chuck"
kind = "chuck"
at_mm = [100, 80, -20]
diameter_mm = 60
length_mm = 15
grip_diameter_mm = 20
jaws = 3
jaw_width_mm = 10
jaw_height_mm = 12

[[fixture]]
name = "tombstone"
kind = "tombstone"
at_mm = [100, -80, -40]
side_mm = 30
height_mm = 50
base_side_mm = 50
base_thickness_mm = 10

[[fixture]]
name = "toe"
kind = "toe-clamp"
at_mm = [60, 80, -20]
length_mm = 40
width_mm = 15
thickness_mm = 8
reach_mm = 5
height_mm = 10
stud_diameter_mm = 6
stud_height_mm = 7
"#;

const FACE_PART: &str = r#"
[part.blade]
kind = "dong"
chord_error_mm = 0.2
underside_mm = -5
"#;

/// Four ellipses of this half length.
fn sections(half: f64) -> String {
    let mut text = "section,x_mm,y_mm,z_mm\n".to_owned();
    for j in 0..4 {
        for k in 0..40 {
            let (s, c) = (f64::from(k) * std::f64::consts::TAU / 40.0).sin_cos();
            text += &format!("s{j},{},{},{}\n", 10 * j, half * c, 5.0 * s);
        }
    }
    text
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Setup {
    /// Three linear joints, set points of the control.
    Mill,
    /// The same with its drives.
    MillServo,
    /// The same with coupled rigid bodies.
    MillRapier,
    /// The same with geometric errors.
    MillErrors,
    /// A body from a model file, and one of a prism that comes nearest of all.
    Model,
    /// A design mesh as part, fixtures, patches.
    Part,
    /// A part that comes off the block and falls.
    Loose,
    /// A cone as part.
    Cone,
    /// A blade as part and stock.
    Blade,
    /// A blade between two ends.
    EndedBlade,
    /// A blade through sections of a file.
    Sections,
    /// A face over a block.
    Face,
    /// A mesh that is inside out as stock.
    Mesh,
    /// The stock that an earlier setup has left.
    Next,
    /// Two rotary joints under the table, with tool center point control.
    Five,
    /// The same with its drives.
    FiveServo,
    /// The same with errors of a rotary joint.
    FiveErrors,
    /// A platform on three legs.
    Hybrid,
    /// The same with its drives.
    HybridServo,
    /// Two programs side by side.
    Compare,
    /// A pass round a blade.
    Plan,
    /// Paths over a blade by contacts, every strategy but the flank.
    Paths,
    /// The same with planes at equal distances.
    Planes,
    /// A ruled side by the flank.
    Flank,
    /// A program that is made from another, by either method.
    Remade,
    RemadeQuaternion,
    /// A program that turns the table near its pole, re-planned there.
    RemadePole,
    /// The same program, its axes laid between keys.
    RemadeKeys,
    /// The first program as smooth as its channel lets it.
    RemadeSmooth,
    /// Two rows of a bull-nose cutter side by side, by strip and roughness.
    RemadeStrip,
    /// One tool each, that cuts a groove.
    Ball,
    BullNose,
    TaperBall,
    Barrel,
    Oval,
    DrumWheel,
    Lens,
    Drill,
    Chamfer,
    FaceMill,
    /// A tap goes into a design without a hole: a ring of what it cuts is thread.
    Tap,
    Apt,
    Profile,
    /// Short flutes, so that neck and shank rub, under a long holder.
    Short,
    /// A ramp with a tool that has no edges at its center, with and without its steepest ramp.
    Hollow,
    HollowUnstated,
    /// Patches, a grid and profiles on a plane that a ball cuts in rows: by its envelope; by its teeth with
    /// random phases, and with a given one; by round inserts.
    Surface,
    SurfaceTeeth,
    SurfacePhase,
    SurfaceInsert,
    /// The same kinds of places on a blade that nothing cuts.
    SurfaceBlade,
    /// A fixture of each kind, a block that may be skipped, and an optional stop before a cut.
    Held,
    /// Neither fixture nor design, as the scene states.
    Bare,
}

impl Setup {
    pub(crate) fn files(self) -> Files {
        let (mut machine, mut tools, mut scene) = (MILL.to_owned(), TOOLS.to_owned(), SCENE.to_owned());
        let (mut name, mut program) = ("main.nc", PROGRAM.to_owned());
        let mut more: Vec<(&str, Vec<u8>)> = Vec::new();
        let servo = "\n[control]\ndynamics = \"servo\"\n";
        let in_siemens = |scene: &str| scene.replace("main.nc", "main.mpf");
        match self {
            Self::Mill => {
                scene += "\n[control]\npath_tolerance_mm = 0.05\n[control.joint_limits.X]\nmax_velocity_mm_min = 15_000\nsource = \"test\"\n";
            }
            Self::MillServo => scene += servo,
            Self::MillRapier => {
                scene += "\n[control]\ndynamics = \"servo\"\nplant = \"rapier\"\n";
            }
            Self::MillErrors => {
                machine += "\n[errors.constant]\nEZ0S_um = 20\n[[errors.table]]\njoint = \"X\"\nat_mm = [-30, 0, 40]\nreference_mm = [0, 10, 0]\n\
                            [errors.table.values]\nEZX_um = [0, 5, 20]\nEAX_urad = [0, 20, 50]\n";
            }
            Self::Held => {
                scene += HELD;
                program = PROGRAM.replace("G0 Z12.", "/G0 Z12.").replace("G1 Z2. F1500", "M1\nG1 Z2. F1500");
            }
            Self::Bare => {
                let (head, rest) = scene.split_once("[[fixture]]").unwrap_or((&scene, ""));
                let rest = rest.split_once("[tolerances]").map_or("", |(_, rest)| rest);
                let stated = "workholding = \"none\"\nworkholding_reason = \"glued\"\ndesign = \"none\"\nresolution_mm";
                scene = format!("{head}[gates]\nnot_asked = [\"surface\"]\n\n[tolerances]{rest}").replacen(
                    "resolution_mm",
                    stated,
                    1,
                );
            }
            Self::Model => {
                let column = "\n[[body]]\nname = \"column\"\nrole = \"column\"\nattached_to = \"base\"\ncheck = true\nnode = \"column\"\n\
                              [[body]]\nname = \"lamp\"\nrole = \"lamp\"\nattached_to = \"Z\"\ncheck = true\n\
                              prism = [{ along = \"z\", range_mm = [-70, 60], outline_mm = [[12, -5], [16, -5], [16, 5], [12, 5]] }]\n";
                machine = MILL.replacen("up = ", "model = \"model.glb\"\nup = ", 1) + column;
                let model = fs::read(root().join("machines/three-axis-mill/model.glb")).unwrap_or_default();
                more.push(("machine/model.glb", model));
            }
            Self::Part => {
                scene += PART;
                scene += "\n[[stock.patch]]\nname = \"fine\"\nmin_mm = [-6, -3, -4]\nmax_mm = [2, 3, 1]\ncell_mm = 0.25\n\
                          \n[[fixture]]\nname = \"post\"\ncylinder = { base_mm = [-22, -8, -40], radius_mm = 2, height_mm = 44 }\n\
                          \n[[fixture]]\nname = \"jaw\"\nmesh = \"jaw.stl\"\n";
                more.push(("part.stl", stl([-14.0, -9.0, -9.5], [14.0, 9.0, -0.2], false)));
                more.push(("other.stl", stl([-14.0, -9.0, -9.5], [14.0, 9.0, -1.2], false)));
                more.push(("jaw.stl", stl([-15.0, 14.0, -40.0], [15.0, 20.0, 1.0], false)));
                more.push(("jaw2.stl", stl([-15.0, 10.5, -40.0], [15.0, 20.0, 1.0], false)));
            }
            Self::Mesh => {
                scene = scene.replace(
                    "box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }",
                    "mesh = \"turned.stl\"\nrepair = true",
                );
                more.push(("turned.stl", stl([-14.0, -9.0, -9.5], [14.0, 9.0, -0.2], true)));
                more.push(("other.stl", stl([-14.0, -9.0, -9.5], [14.0, 9.0, -1.2], false)));
            }
            Self::Loose => {
                scene += "\n[control]\npath_tolerance_mm = 0.05\n";
                program = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS4000 M3\nG0 X6. Y-15.\nZ4.\nG1 Z-10.5 F1500\nY15.\nG0 Z12.\n\
                           M5\nM30\n%\n"
                    .to_owned();
            }
            Self::Cone => {
                scene = scene.replace(
                    "box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }",
                    "cylinder = { base_mm = [0, 0, -10], radius_mm = 12, height_mm = 10 }",
                );
                scene += CONE;
            }
            Self::Blade | Self::EndedBlade | Self::Sections | Self::Face => {
                scene = scene
                    .replace("box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }", "blade_allowance_mm = 0.5")
                    .replace("resolution_mm = 0.5", "resolution_mm = 4")
                    .replace("translation_mm = [0, 0, 40]", "translation_mm = [0, 0, 100]");
                scene += match self {
                    Self::EndedBlade => ENDED_BLADE_PART,
                    Self::Sections => SECTIONS_PART,
                    Self::Face => FACE_PART,
                    _ => BLADE_PART,
                };
                if self == Self::Sections {
                    more.push(("sections.csv", sections(20.0).into_bytes()));
                    more.push(("other.csv", sections(18.0).into_bytes()));
                }
                program = "%\nO1\nG17 G21 G90 G94\nG54\nM30\n%\n".into();
            }
            Self::Next => {
                let first = scene
                    .replace("[stock]\n", "[stock]\nhistory = true\n")
                    .replace("machine = \"machine\"", "machine = \"../machine\"")
                    .replace("tools = \"tools.toml\"", "tools = \"../tools.toml\"")
                    .replace("main.nc", "../main.nc");
                more.push(("first/scene.toml", first.into_bytes()));
                scene = scene.replace(
                    "box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }",
                    "from_run = \"first\"\nplace = { translation_mm = [0, 0, 0] }\nat_time_s = 100",
                );
                let other = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS4000 M3\nG0 X-22. Y-6.\nZ4.\nG1 Z-1. F3000\nX22.\nG0 Z12.\nM30\n%\n";
                more.push(("next.nc", other.into()));
                scene = scene.replace("file = \"main.nc\"", "file = \"next.nc\"");
            }
            Self::Five => {
                (machine, scene, name, program) = (five(), in_siemens(&scene), "main.mpf", FIVE_PROGRAM.into());
                scene += "\n[control.joint_limits.C]\nmax_velocity_deg_s = 120\nsource = \"test\"\n";
            }
            Self::FiveServo | Self::FiveErrors => {
                (machine, scene, name, program) = (five(), in_siemens(&scene), "main.mpf", FIVE_PROGRAM.into());
                if self == Self::FiveServo {
                    scene += servo;
                } else {
                    machine += "\n[[errors.table]]\njoint = \"B\"\nat_deg = [0, 20]\n[errors.table.values]\nEZB_um = [0, 30]\n";
                }
            }
            Self::Hybrid | Self::HybridServo => {
                let with_drives = self == Self::HybridServo;
                machine = if with_drives { hybrid_servo() } else { hybrid() };
                (scene, name, program) = (in_siemens(&scene), "main.mpf", HYBRID_PROGRAM.into());
                scene = scene.replace("translation_mm = [0, 0, 40]", "translation_mm = [0, 0, 600]");
                if with_drives {
                    scene += servo;
                }
            }
            Self::Compare => {
                scene = scene.replace("resolution_mm = 0.5", "resolution_mm = 2");
                scene += "\n[[program]]\nname = \"other\"\nfile = \"other.nc\"\n";
                scene += COMPARE;
                let short = "%\nO1\nG17 G21 G90 G94\nT1 M6\nG54 G43 H1\nS4000 M3\nG0 X-20. Y0.\nZ-1.\nG1 X-15. F1500\nX-10.\nX-5.\nX0.\nY3.\nG0 Z4.\nM30\n%\n";
                program = short.into();
                machine = machine.replace("cycle_time_ms = 4", "cycle_time_ms = 8");
                more.push(("other.nc", short.replace("F1500", "F1100").into()));
            }
            Self::Flank => {
                let lib = |path: &str| fs::read_to_string(root().join(path)).unwrap_or_default();
                machine = lib("machines/bc-trunnion/machine.toml");
                tools = lib("tools/li-2022.toml");
                name = "main.mpf";
                program = "G17 G54 G90 G94 G710\nT=\"BALL_D16\"\nM6\nM30\n".into();
                scene = in_siemens(&scene)
                    .replace("box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }", "blade_allowance_mm = 0.5")
                    .replace("resolution_mm = 0.5", "resolution_mm = 8")
                    .replace("rotation_deg = [0, 0, 0]", "rotation_deg = [0, -90, 0]");
                scene += &BLADE_PART.replace("twist_deg_per_mm = 0.1", "twist_deg_per_mm = 0.0");
                scene += FLANK;
                let model = fs::read(root().join("machines/bc-trunnion/model.glb")).unwrap_or_default();
                more.push(("machine/model.glb", model));
            }
            Self::Plan
            | Self::Paths
            | Self::Planes
            | Self::Remade
            | Self::RemadeQuaternion
            | Self::RemadePole
            | Self::RemadeKeys
            | Self::RemadeSmooth => {
                let lib = |path: &str| fs::read_to_string(root().join(path)).unwrap_or_default();
                machine = lib("machines/starrag-lx-451/machine.toml");
                tools = lib("tools/li-2022.toml");
                name = "main.mpf";
                program = if self == Self::RemadePole {
                    near_pole()
                } else {
                    shortened(&lib("scenes/li-2022-s-theta/original.mpf"))
                };
                scene = in_siemens(&scene)
                    .replace("box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }", "blade_allowance_mm = 0.5")
                    .replace("resolution_mm = 0.5", "resolution_mm = 8")
                    .replace("translation_mm = [0, 0, 40]", "translation_mm = [260, 0, 0]")
                    .replace("Z_mm = 40", "X_mm = 260");
                scene += BLADE_PART;
                if self == Self::Paths {
                    scene += &paths();
                } else if self == Self::Planes {
                    scene += &paths().replace("scallop_mm = 0.1\nnormal", "lines_apart_mm = 1\nnormal");
                } else {
                    scene += HELIX;
                }
                if !matches!(self, Self::Plan | Self::Paths | Self::Planes) {
                    scene += "\n[[program]]\nname = \"second\"\nfile = \"second.mpf\"\n";
                    let method = match self {
                        Self::Remade => "\"s-theta\"",
                        Self::RemadePole => "\"singularity\", cone_deg = 20",
                        Self::RemadeKeys => "\"min-angular-acceleration\"",
                        Self::RemadeSmooth => "\"smooth\"",
                        _ => "\"quaternion\"",
                    };
                    scene += &format!(
                        "\n[[program]]\nname = \"made\"\nreschedule = {{ method = {method}, from = \"main\" }}\n"
                    );
                    more.push(("second.mpf", program.replace("S8000", "S7000").into()));
                }
                let model = fs::read(root().join("machines/starrag-lx-451/model.glb")).unwrap_or_default();
                more.push(("machine/model.glb", model));
            }
            Self::RemadeStrip => {
                let lib = |path: &str| fs::read_to_string(root().join(path)).unwrap_or_default();
                let paper = lib("scenes/dong-2023-multi-scale/scene.toml");
                machine = lib("machines/jdgr200t/machine.toml");
                tools = lib("tools/dong-2023.toml");
                name = "main.mpf";
                program = two_rows(&lib("scenes/dong-2023-multi-scale/original.mpf"));
                scene = paper[..paper.find("# Eleven of the 51 rows").unwrap_or_default()]
                    .replace("../../machines/jdgr200t", "machine")
                    .replace("../../tools/dong-2023.toml", "tools.toml")
                    .replace("chord_error_mm = 0.0001", "chord_error_mm = 0.002")
                    .replace("resolution_mm = 0.2", "resolution_mm = 4");
                scene += "\n[[program]]\nname = \"main\"\nfile = \"main.mpf\"\n\n[[program]]\nname = \"second\"\nfile = \"main.mpf\"\n\
                          \n[[program]]\nname = \"made\"\nreschedule = { method = \"multi-scale\", from = \"main\", measured_ratio = 0.66, measured_spread = 0.12 }\n";
                let model = fs::read(root().join("machines/jdgr200t/model.glb")).unwrap_or_default();
                more.push(("machine/model.glb", model));
            }
            Self::Ball => tools = one_tool("ball", "diameter_mm = 6\nflute_length_mm = 12"),
            Self::BullNose => {
                tools = one_tool("bull_nose", "diameter_mm = 6\ncorner_radius_mm = 1\nflute_length_mm = 12")
            }
            Self::TaperBall => {
                tools = one_tool(
                    "taper_ball",
                    "tip_diameter_mm = 3\nhalf_angle_deg = 10\ndiameter_mm = 6\nflute_length_mm = 12",
                );
            }
            Self::Barrel => {
                tools =
                    one_tool("barrel", "diameter_mm = 6\ntip_radius_mm = 1\nside_radius_mm = 30\nflute_length_mm = 12");
            }
            Self::Oval => {
                tools =
                    one_tool("oval", "diameter_mm = 6\ntip_radius_mm = 1\nside_radius_mm = 30\nflute_length_mm = 20");
            }
            Self::DrumWheel => {
                tools = one_tool(
                    "drum_wheel",
                    "diameter_mm = 8\nside_radius_mm = 6\ncorner_radius_mm = 0.5\nflute_length_mm = 3",
                );
            }
            Self::Lens => {
                tools = one_tool(
                    "lens",
                    "diameter_mm = 6\nlens_radius_mm = 20\ncorner_radius_mm = 0.5\nflute_length_mm = 12",
                );
            }
            Self::Drill => tools = one_tool("drill", "diameter_mm = 6\npoint_angle_deg = 118\nflute_length_mm = 12"),
            Self::Chamfer => {
                tools = one_tool(
                    "chamfer",
                    "diameter_mm = 6\npoint_angle_deg = 90\ntip_diameter_mm = 1\nflute_length_mm = 12",
                );
            }
            Self::FaceMill => {
                tools = one_tool(
                    "face_mill",
                    "diameter_mm = 6\ncorner_radius_mm = 0.5\nentering_angle_deg = 75\nflute_length_mm = 5",
                );
            }
            Self::Tap => {
                tools = one_tool("tap", "diameter_mm = 6\npitch_mm = 1\nflute_length_mm = 12");
                scene += PART;
                program = PROGRAM
                    .replace("G0 X-22. Y0.25\nZ4.\nG1 Z-2. F1500\nX0.", "G0 X0. Y0.\nZ4.\nG1 Z-5. F1500\nG0 Z4.");
                more.push(("part.stl", stl([-14.0, -9.0, -9.5], [14.0, 9.0, -1.0], false)));
            }
            Self::Apt => {
                tools = one_tool(
                    "apt",
                    "diameter_mm = 6\ncorner_radius_mm = 1.3\ncorner_center_radius_mm = 2\ncorner_center_height_mm = 1.2\n\
                     lower_angle_deg = 5\nupper_angle_deg = 5\ncutter_height_mm = 12",
                );
            }
            Self::Profile => {
                tools = one_tool(
                    "profile",
                    "segments = [{ to_mm = [2, 0] }, { to_mm = [3, 1], center_mm = [2, 1] }, { to_mm = [3, 12] }]",
                );
            }
            Self::Short => {
                tools = TOOLS
                    .replace("flute_length_mm = 12", "flute_length_mm = 1")
                    .replace("neck_diameter_mm = 5", "neck_diameter_mm = 5.5")
                    .replace("neck_length_mm = 8", "neck_length_mm = 0.6")
                    .replace("transition_length_mm = 2", "transition_length_mm = 0.3")
                    .replace("shank_diameter_mm = 6", "shank_diameter_mm = 6.5")
                    .replace(
                        "{ diameter_mm = 20, top_diameter_mm = 30, length_mm = 30 }, { diameter_mm = 40, length_mm = 15 }",
                        "{ diameter_mm = 10, top_diameter_mm = 24, length_mm = 2 }, { diameter_mm = 20, length_mm = 69 }",
                    );
            }
            Self::Surface | Self::SurfaceTeeth | Self::SurfacePhase | Self::SurfaceInsert => {
                scene += SURFACE;
                if self != Self::Surface {
                    scene = scene.replace("model = \"envelope\"", "model = \"teeth\"");
                }
                if self == Self::SurfacePhase || self == Self::SurfaceInsert {
                    scene += "\n[[surface.phase]]\nat_mm = [-15, 0, -1]\ntooth_deg = 30\ntool = \"END_D6\"\n";
                }
                let edges = "\n[tool.edges]\nhelix_deg = 30\nradial_run_out_mm = [0, 0.01]\naxial_run_out_mm = [0, 0.002]\nradial_rake_deg = 5\n\
                             rake_about = \"axis\"\n";
                let insert = "round_insert = { nose_circle_diameter_mm = 4, insert_radius_mm = 1 }\n";
                let residual = "[tool.residual]\nra_um = [0.1, 0.2]\nrz_um = [0.3, 0.5]\nsource = \"trials\"\n";
                tools = match self {
                    Self::SurfaceInsert => {
                        let shape = "diameter_mm = 6\ncorner_radius_mm = 1\nflute_length_mm = 12\nflutes = 2";
                        one_tool("bull_nose", shape) + edges + insert + residual
                    }
                    _ => one_tool("ball", "diameter_mm = 6\nflute_length_mm = 12\nflutes = 2") + edges + residual,
                };
                program = SURFACE_PROGRAM.into();
                more.push(("part.stl", stl([-14.0, -9.0, -9.5], [14.0, 9.0, -1.0], false)));
            }
            Self::SurfaceBlade => {
                scene = scene
                    .replace("box = { min_mm = [-15, -10, -10], max_mm = [15, 10, 0] }", "blade_allowance_mm = 0.5")
                    .replace("resolution_mm = 0.5", "resolution_mm = 4")
                    .replace("translation_mm = [0, 0, 40]", "translation_mm = [0, 0, 100]");
                scene += BLADE_PART;
                scene += SURFACE_BLADE;
                program = "%\nO1\nG17 G21 G90 G94\nG54\nM30\n%\n".into();
            }
            Self::Hollow | Self::HollowUnstated => {
                let ramp = if self == Self::Hollow { "max_ramp_angle_deg = 30" } else { "" };
                let shape = format!("diameter_mm = 6\nflute_length_mm = 12\ncenter_cutting = false\n{ramp}");
                tools = one_tool("flat", &shape);
                // A ramp of 22 degrees into the block.
                program = PROGRAM.replace("G1 Z-2. F1500\nX0.", "G1 Z0.5 F1500\nX-12.\nX-5. Z-2.");
                if self == Self::Hollow {
                    // After it a narrow helix of two turns, whose middle the center of the tool may cover.
                    let helix = "X-5. Z-2.\nG3 X-5. Y0.25 Z-2.5 I-1. J0.\nG3 X-5. Y0.25 Z-3. I-1. J0.\nG1 X-5. Z-2.";
                    program = program.replace("X-5. Z-2.", helix);
                }
            }
        }
        let mut files = Files::new();
        files.insert("machine/machine.toml".into(), machine.into_bytes());
        files.insert("tools.toml".into(), tools.into_bytes());
        files.insert("scene.toml".into(), scene.into_bytes());
        files.insert(name.into(), program.into_bytes());
        let second = MILL.replace("home_mm = 30", "home_mm = 31");
        files.insert("second/machine.toml".into(), second.into_bytes());
        files.insert("other-tools.toml".into(), TOOLS.replace("diameter_mm = 6\n", "diameter_mm = 5\n").into_bytes());
        files.extend(more.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)));
        files
    }
}

/// The first two rows of a program in which rows end with a rapid.
fn two_rows(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let rapids: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].starts_with("G0 ")).collect();
    let end = rapids.get(2).copied().unwrap_or(lines.len());
    lines[..=end.min(lines.len() - 1)].join("\n") + "\nTRAFOOF\nM30\n"
}

/// A row above the part whose axis comes within 6 degrees of the table's while the table turns by 3 degrees a
/// block.
fn near_pole() -> String {
    let mut text = String::from(
        "G17\nT=\"BALL_D16\"\nM6\nD1\nG54\nS8000 M3\nCTOL=0.01 OTOL=0.05 G645\nG0 A0 B60\nTRAORI\nORIAXES\n",
    );
    text += "G0 X30 Y0 Z90 A0 B60\nG93\n";
    for i in 0..=40_i32 {
        let tilt = 84.0 - 1.2 * f64::from((i - 20).abs());
        // Along the table's axis the row goes up and down.
        let up = 30.0 + f64::from(i) + 3.0 * (f64::from(i) / 5.0).sin();
        text += &format!("G1 X{up:.4} Y{} Z80 A{} B{tilt:.1} F600\n", i, 3 * i);
    }
    text + "TRAFOOF\nM30\n"
}
