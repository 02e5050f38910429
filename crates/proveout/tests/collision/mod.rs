//! Bodies against bodies as a person types it: what the machine file leaves out or treats on its own, and
//! meshes that bound no solid, are named by the gates; what is checked of them has closed forms.
//!
//! ```text
//!      head  [-50, 50] x [-50, 50], 10 over the gauge line      cover, its face at x = 150
//!     .-------.                                  |
//!     '-------'      gap = 150 - (X + 50)        |
//!         H   holder: radius 10, 50 to 80 mm over the tip
//!         |
//!      [post]  on the table, top at z = 60, x and y within 15 mm
//! ```

mod in_the_spindle;
mod meshes;

use std::{fs, path::Path, process::Command};

use serde_json::Value;
use tempfile::TempDir;

/// X, Y and Z carry the tool, B the table; the gauge line is at the machine zero with all joints at zero.
const MACHINE: &str = r#"
name = "small"
spindle = { on = "Z", origin_mm = [0, 0, 0], direction = [0, 0, 1], start_time_s = 1, max_speed_rpm = 9000 }
table = { on = "B", point_mm = [0, 0, 0], normal = [0, 0, 1] }
control = { cycle_time_ms = 2, block_time_ms = 1, rapid_mode = "straight", tool_change_time_s = 5, default_tolerance_mm = 0.01 }

[[joint]]
name = "B"
kind = "rotary"
carries = "workpiece"
parent = "base"
direction = [0, 1, 0]
point_mm = [0, 0, 0]
sense = -1
travel_deg = [-100, 100]
max_velocity_deg_s = 90
max_acceleration_deg_s2 = 900
max_jerk_deg_s3 = 20_000

[[body]]
name = "table"
role = "table"
attached_to = "B"
check = true
box = [{ min_mm = [-60, -60, -40], max_mm = [60, 60, 0] }]

[[body]]
name = "head"
role = "head"
attached_to = "Z"
check = true
box = [{ min_mm = [-50, -50, 10], max_mm = [50, 50, 100] }]

[[body]]
name = "cover"
role = "cover"
attached_to = "base"
check = true
box = [{ min_mm = [150, -100, 0], max_mm = [160, 100, 600] }]
"#;

const TOOLS: &str = "[[tool]]\nnumber = 1\nname = \"T1\"\nkind = \"flat\"\ndiameter_mm = 6\nflute_length_mm = 20\nshank_diameter_mm = 6\n\
                     gauge_length_mm = 80\nflutes = 2\ncenter_cutting = true\nholder = { sections = [{ diameter_mm = 20, length_mm = 30 }] }\n";

/// The head goes to X 95, 5 mm from the cover, in line 8.
const TO_THE_COVER: &str =
    "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\nG0 X0. Y0. Z200.\nX95.\nX0.\nM5\nM30\n%\n";

fn machine(more: &str) -> String {
    let slide = |name: &str, parent: &str, direction: &str, home: f64| {
        format!(
            "\n[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\ndirection = {direction}\n\
             travel_mm = [-500, 500]\nhome_mm = {home}\nmax_velocity_mm_min = 20_000\nrapid_velocity_mm_min = 18_000\n\
             max_acceleration_mm_s2 = 3000\nmax_jerk_mm_s3 = 60_000\n"
        )
    };
    let joints =
        [slide("X", "base", "[1, 0, 0]", 0.0), slide("Y", "X", "[0, 1, 0]", 0.0), slide("Z", "Y", "[0, 0, 1]", 300.0)];
    MACHINE.replacen("\n[[joint]]", &(joints.concat() + "\n[[joint]]"), 1) + more
}

/// A shop with a post on the table, whose mesh is `post.stl`.
struct Shop {
    folder: TempDir,
}

impl Shop {
    fn new(machine: &str, fixture: &str, program: &str) -> Self {
        let shop = Self { folder: tempfile::tempdir().expect("temporary folder") };
        let workholding = if fixture.contains("[[fixture]]") {
            ""
        } else {
            "workholding = \"none\"\nworkholding_reason = \"not part of this test\"\n"
        };
        let scene = format!(
            "name = \"shop\"\n{workholding}machine = \"machine.toml\"\ntools = \"tools.toml\"\nresolution_mm = 1\n[stock]\n\
             box = {{ min_mm = [-50, -50, 0], max_mm = [-40, -40, 10] }}\n[work_offsets.G54]\nZ_mm = 0\n{fixture}\n\
             [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n"
        );
        for (name, text) in
            [("machine.toml", machine), ("tools.toml", TOOLS), ("scene.toml", &scene), ("main.nc", program)]
        {
            shop.write(name, text);
        }
        shop
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path().join(name), text).expect("written");
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn run(&self) -> (i32, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.path())
            .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"])
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("panicked"), "{said}");
        (output.status.code().unwrap_or(-1), said)
    }

    fn json(&self, name: &str) -> Value {
        let text = fs::read_to_string(self.path().join("result").join(name)).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }

    fn verdict(&self) -> Value {
        let (_, said) = self.run();
        assert!(self.path().join("result/verdict.json").is_file(), "{said}");
        self.json("verdict.json")
    }
}

/// State and reason of a gate.
fn gate<'v>(verdict: &'v Value, name: &str) -> (&'v str, &'v str) {
    let gate = verdict["gates"].as_array().expect("gates").iter().find(|g| g["name"] == name).expect("the gate");
    (gate["state"].as_str().expect("a state"), gate["reason"].as_str().expect("a reason"))
}

fn found<'v>(verdict: &'v Value, code: &str) -> Vec<&'v Value> {
    verdict["findings"].as_array().expect("findings").iter().filter(|f| f["code"] == code).collect()
}

const POST: &str = "[[fixture]]\nname = \"post\"\nmesh = \"post.stl\"\nframe = \"table\"\n";

/// A block of 30 x 30 x 60 mm as text of an STL file, without some of its triangles and with more.
fn post(without: std::ops::Range<usize>, more: &[[[f64; 3]; 3]]) -> String {
    let corner = |k: usize| [[-15.0, 15.0][k & 1], [-15.0, 15.0][k >> 1 & 1], [0.0, 60.0][k >> 2 & 1]];
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let of = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]].map(|t| t.map(corner));
    let sides = faces.into_iter().flat_map(of).enumerate().filter(|(k, _)| !without.contains(k)).map(|(_, t)| t);
    let all = sides.chain(more.iter().copied());
    let facet = |t: [[f64; 3]; 3]| {
        let corners = t.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid post\n{}endsolid post\n", all.map(facet).collect::<String>())
}

/// The tool comes down next to the post, 2 mm from its side, until the holder is over its top by a height, in
/// line 8; its lower face is 50 mm over the tip.
fn over_the_post(height: f64) -> String {
    format!(
        "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\nG0 X-20. Y0.\nG0 Z{}\nX-22.\nZ200.\nM5\nM30\n%\n",
        60.0 + height - 50.0
    )
}

#[test]
fn a_body_that_is_not_checked_is_named_by_both_gates() {
    let into = TO_THE_COVER.replace("X95.", "X103.");
    let checked = Shop::new(&machine(""), "", &into).verdict();
    assert_eq!(gate(&checked, "collision").0, "fail", "{checked}");
    assert_eq!(found(&checked, "collision-bodies")[0]["line"], 8, "{checked}");
    let only_drawn =
        machine("").replace("attached_to = \"base\"\ncheck = true", "attached_to = \"base\"\ncheck = false");
    let verdict = Shop::new(&only_drawn, "", &into).verdict();
    for name in ["collision", "near_miss"] {
        let (state, reason) = gate(&verdict, name);
        assert_eq!(state, "unchecked", "{reason}");
        assert!(reason.contains("not checked: bodies that the machine file excludes: cover"), "{reason}");
    }
    assert!(found(&verdict, "collision-bodies").is_empty());
}

#[test]
fn a_pair_with_a_distance_of_its_own_is_held_to_it() {
    let shop = Shop::new(&machine(""), "", TO_THE_COVER);
    let verdict = shop.verdict();
    assert_eq!(gate(&verdict, "near_miss").0, "pass", "{verdict}");
    let pair = |v: &Value| {
        let pairs = v["clearance"]["pairs"].as_array().expect("pairs").clone();
        let of = |p: &Value| p["bodies"].to_string().contains("head") && p["bodies"].to_string().contains("cover");
        pairs.into_iter().find(of).expect("the pair")
    };
    assert!((pair(&verdict)["min_mm"].as_f64().expect("measured") - 5.0).abs() < 0.02, "{}", pair(&verdict));
    assert!(pair(&verdict)["near_miss_mm"].is_null());

    for (wanted, state) in [(8.0, "fail"), (4.9, "pass"), (0.0, "pass")] {
        let rule =
            format!("\n[[pairs]]\nbodies = [\"cover\", \"head\"]\nnear_miss_mm = {wanted}\nreason = \"thin sheet\"\n");
        let verdict = Shop::new(&machine(&rule), "", TO_THE_COVER).verdict();
        let (is, reason) = gate(&verdict, "near_miss");
        assert_eq!(is, state, "{wanted}: {reason}");
        assert_eq!(pair(&verdict)["near_miss_mm"], wanted);
        let near = found(&verdict, "collision-near-miss");
        if state == "pass" {
            assert!(reason.contains("as the machine file requires, ") && reason.contains("(thin sheet)"), "{reason}");
            assert!(near.is_empty());
        } else {
            assert_eq!((near.len(), &near[0]["line"], &near[0]["limit"]), (1, &8.into(), &wanted.into()), "{near:?}");
            assert!(near[0]["message"].as_str().expect("words").contains("than the required 8.000 mm"), "{near:?}");
        }
    }
}

#[test]
fn a_pair_that_the_machine_file_excludes_is_named_with_its_reason() {
    let rule = "\n[[pairs]]\nbodies = [\"head\", \"cover\"]\ncheck = false\nreason = \"it moves away with the door\"\n";
    let verdict = Shop::new(&machine(rule), "", &TO_THE_COVER.replace("X95.", "X103.")).verdict();
    for name in ["collision", "near_miss"] {
        let (state, reason) = gate(&verdict, name);
        assert_eq!(state, "unchecked", "{reason}");
        assert!(
            reason.contains("pairs that the machine file excludes: ") && reason.contains("with the door"),
            "{reason}"
        );
    }
    let unchecked = verdict["clearance"]["unchecked"].to_string();
    assert!(unchecked.contains("cover") && unchecked.contains("with the door"), "{unchecked}");
    // The holder is another body than the head: it is checked.
    let holder = verdict["clearance"]["pairs"].to_string();
    assert!(holder.contains("holder of T1"), "{holder}");

    let (code, said) = Shop::new(&machine(&rule.replace("cover", "lid")), "", TO_THE_COVER).run();
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("machine.toml:") && said.contains("there is no body \"lid\""), "{said}");
}

/// A bar of 10 mm turns on its table into the cheeks of the cradle, which rise by 8 mm over the face and 110
/// mm from the axis: the layer of 17 mm that counts for nothing against the flush face does not hide them.
#[test]
fn a_flat_bar_that_swings_into_the_cheeks_of_its_cradle_is_found() {
    let slides =
        machine("").split("\n[[joint]]\nname = \"B\"").next().expect("the slides").replace("on = \"B\"", "on = \"C\"");
    let cradle = |rise: f64| {
        format!(
            "{slides}\n[[joint]]\nname = \"C\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"base\"\ndirection = [0, 0, 1]\n\
             point_mm = [0, 0, 0]\nsense = -1\ntravel_deg = [-360, 360]\nmax_velocity_deg_s = 90\nmax_acceleration_deg_s2 = 900\n\
             max_jerk_deg_s3 = 20_000\n[[body]]\nname = \"table\"\nrole = \"table\"\nattached_to = \"C\"\ncheck = true\n\
             cylinder = [{{ from_mm = [0, 0, -40], to_mm = [0, 0, 0], radius_mm = 60 }}]\n[[body]]\nname = \"cradle\"\nrole = \"cradle\"\n\
             attached_to = \"base\"\ncheck = true\nbox = [{{ min_mm = [-200, -100, -60], max_mm = [200, 100, -0.05] }}, \
             {{ min_mm = [-200, 110, -60], max_mm = [200, 150, {rise}] }}]\n"
        )
    };
    let program = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nG54\nG0 X0. Y0. Z300.\nC90.\nC0.\nM30\n%\n";
    for (rise, hits) in [(8.0, true), (-2.0, false)] {
        let shop = Shop::new(&cradle(rise), "", program);
        let scene = fs::read_to_string(shop.path().join("scene.toml")).expect("written");
        let scene = scene.replace("resolution_mm = 1", "resolution_mm = 4");
        let bar = scene.replace(
            "min_mm = [-50, -50, 0], max_mm = [-40, -40, 10]",
            "min_mm = [-140, -20, 0], max_mm = [140, 20, 10]",
        );
        shop.write("scene.toml", &(bar + "[tolerances]\nnear_miss_mm = 10\n"));
        let verdict = shop.verdict();
        let found = found(&verdict, "collision-stock-body");
        assert_eq!(found.len(), usize::from(hits), "{rise}: {:?}", verdict["findings"]);
        assert!(!hits || found[0]["line"] == 6, "{found:?}");
        assert!(
            gate(&verdict, "collision").1.contains(if hits {
                "1 x collision-stock-body"
            } else {
                "cradle lies flush with"
            }),
            "{verdict}"
        );
    }
}

#[test]
fn joints_that_are_no_numbers_are_refused_with_their_place() {
    for number in ["nan", "inf"] {
        let text = machine("").replacen("home_mm = 300", &format!("home_mm = {number}"), 1);
        let (code, said) = Shop::new(&text, "", TO_THE_COVER).run();
        assert_eq!(code, 2, "{said}");
        assert!(said.contains("machine.toml:") && said.contains("home_mm"), "{said}");
    }
}

#[test]
fn what_the_checks_cost_is_reported() {
    let shop = Shop::new(&machine(""), POST, &over_the_post(3.0));
    shop.write("post.stl", &post(0..0, &[]));
    let (_, said) = shop.run();
    let checks = shop.json("run.json")["checks"].clone();
    let number = |key: &str| checks[key].as_f64().unwrap_or_else(|| panic!("{key}: {checks}"));
    let pieces = shop.json("verdict.json")["clearance"]["checks"].as_f64().expect("a count");
    assert_eq!(number("pieces"), pieces);
    let share = number("share_by_one_comparison");
    assert!(share > 0.5 && share < 1.0, "most pieces of rapids in the air need no distance: {checks}");
    assert!(
        number("queries_farther") + number("queries_distance") > 0.0 && number("clearance_looks") > 0.0,
        "{checks}"
    );
    assert!(number("stock_motions") > 0.0, "{checks}");
    let line = format!("{:.2} % of {pieces} pieces settled by one comparison", 100.0 * share);
    assert!(said.contains(&line), "{line}\n{said}");
}

/// A blade along +X between a platform at its root (X = 1) and a shroud at its tip (X = 98), with fillets of
/// 3 mm, as `proveout blade` writes it, stood upright on the table: X of the blade is Z of the table, raised
/// by 9 mm.
fn upright_blade(shop: &Shop) {
    let plate = "{ fillet_radius_mm = 3, thickness_mm = 8, y_mm = [-30, 30], z_mm = [-30, 30] }";
    let scene = format!(
        "name = \"blade\"\nmachine = \"machine.toml\"\ntools = \"tools.toml\"\nresolution_mm = 2\n[part.blade]\nkind = \"lu\"\n\
         chord_error_mm = 0.05\nroot = {{ x_mm = 1, platform = {plate} }}\ntip = {{ x_mm = 98, platform = {plate} }}\n[stock]\n\
         box = {{ min_mm = [-40, -40, -40], max_mm = [140, 60, 60] }}\n"
    );
    shop.write("blade.toml", &scene);
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(shop.path())
        .args(["blade", "blade.toml", "--output", "lying.stl"])
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // Binary: a head of 84 bytes, then a normal and three corners in 32 bits for each triangle of 50 bytes.
    let mut bytes = fs::read(shop.path().join("lying.stl")).expect("the mesh");
    for facet in bytes[84..].chunks_exact_mut(50) {
        for corner in 1..4 {
            let at = |k: usize| 12 * corner + 4 * k;
            let [x, y, z] =
                [0, 1, 2].map(|k| f32::from_le_bytes(facet[at(k)..at(k) + 4].try_into().expect("four bytes")));
            for (k, value) in [-z, y, x + 9.0].into_iter().enumerate() {
                facet[at(k)..at(k) + 4].copy_from_slice(&value.to_le_bytes());
            }
        }
    }
    fs::write(shop.path().join("post.stl"), bytes).expect("written");
}

/// The table is tilted by 15 degrees, the tool goes in from the side between platform and shroud. The holder,
/// a cylinder of 10 mm radius round the vertical, comes near the lower edge of the shroud's rim, which is a
/// straight line along Y through x = 30, z = 107 of the table:
///
/// ```text
///            .------.     | |  holder         The edge lies at x cos b - z sin b of the machine, at the
///    shroud  |      |     | |                 height 30 sin b + 107 cos b. That is 6 mm over the lower
///            '------*<gap>| |                 face of the holder. So
///             blade       |_|
///              | |         |  shank             gap = X - (30 cos b - 107 sin b) - 10
/// ```
#[test]
fn a_tilted_holder_between_platform_and_shroud_is_measured_to_hundredths() {
    let tools = TOOLS
        .replace("gauge_length_mm = 80", "gauge_length_mm = 160")
        .replace("length_mm = 30 }]", "length_mm = 80 }]");
    let (s, c) = 15_f64.to_radians().sin_cos();
    let edge = 30.0 * c - 107.0 * s;
    let machine =
        machine("").replace("min_mm = [150, -100, 0], max_mm = [160,", "min_mm = [350, -100, 0], max_mm = [360,");
    for (gap, collision) in [(1.2, "pass"), (0.2, "pass"), (-0.02, "fail")] {
        let x = edge + 10.0 + gap;
        let program = format!(
            "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\nG0 X100. Y0. Z300.\nB15.\nZ25.\nG1 X{x:.6} F1000\nG0 X100.\n\
             Z300.\nM5\nM30\n%\n"
        );
        let shop = Shop::new(&machine, POST, &program);
        shop.write("tools.toml", &tools);
        upright_blade(&shop);
        let verdict = shop.verdict();
        let (is, reason) = gate(&verdict, "collision");
        assert_eq!(is, collision, "{gap}: {reason}");
        let hits = found(&verdict, if gap < 0.0 { "collision-bodies" } else { "collision-near-miss" });
        if gap > 1.0 {
            assert!(hits.is_empty() && gate(&verdict, "near_miss").0 == "pass", "{hits:?}");
        } else {
            // Whatever touches has come too near before.
            assert_eq!((hits.len(), &hits[0]["line"]), (1, &10.into()), "{hits:?}");
            assert_eq!(hits[0]["bodies"], serde_json::json!(["holder of T1", "post"]), "{hits:?}");
            assert_eq!(gate(&verdict, "near_miss").0, "fail");
        }
        let pairs = verdict["clearance"]["pairs"].as_array().expect("pairs");
        let of = |a: &str| {
            let named =
                |p: &&Value| p["bodies"].to_string().contains(a) && p["bodies"].to_string().contains("\"post\"");
            pairs.iter().find(named).unwrap_or_else(|| panic!("{a}: {pairs:?}"))
        };
        let number = |p: &Value, key: &str| p[key].as_f64().unwrap_or_else(|| panic!("{key}: {p}"));
        let holder = of("holder of T1");
        let (measured, proved) = (number(holder, "min_mm"), number(holder, "proved_mm"));
        let true_gap = gap.max(0.0);
        assert!((measured - true_gap).abs() < 0.01 && proved <= true_gap + 1e-6, "{gap}: {holder}");
        assert!(proved > true_gap - 0.02, "{gap}: {holder}");
        // Flutes and shank are free between platform and blade, so that it is the holder that decides.
        assert!(
            number(of("cutter of T1"), "proved_mm") > 1.0 && number(of("shank of T1"), "proved_mm") > 1.0,
            "{pairs:?}"
        );
    }
}

/// A drum about the axis of B, of 240 flat sides whose edges are 60 mm from it, as text of an STL file.
fn drum() -> String {
    let at = |k: usize, y: f64| {
        let (s, c) = (std::f64::consts::TAU * (k % 240) as f64 / 240.0).sin_cos();
        [60.0 * s, y, 60.0 * c]
    };
    let side = |k: usize| {
        let [a, b, c, d] = [at(k, -30.0), at(k + 1, -30.0), at(k + 1, 30.0), at(k, 30.0)];
        [[a, b, c], [a, c, d], [[0.0, -30.0, 0.0], b, a], [[0.0, 30.0, 0.0], d, c]]
    };
    let facet = |t: [[f64; 3]; 3]| {
        let corners = t.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid drum\n{}endsolid drum\n", (0..240).flat_map(side).map(facet).collect::<String>())
}

/// The flutes run along a drum that turns below them, 0.2 mm over each of its edges that passes: the least
/// clearance is that, and is proved to a fiftieth of it, though there is nothing farther away at any moment.
#[test]
fn a_tool_that_runs_close_over_what_turns_is_measured_to_micrometers() {
    let program = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS3000 M3\nG0 X0. Y-20. Z200. B-30.\nG0 Z60.2\nG1 B30. Y20. F800\n\
                   G1 B-30. Y-10. F800\nG0 Z200.\nM5\nM30\n%\n";
    let shop = Shop::new(&machine(""), POST, program);
    shop.write("post.stl", &drum());
    let verdict = shop.verdict();
    let pairs = verdict["clearance"]["pairs"].as_array().expect("pairs");
    let named = |p: &&Value| p["bodies"] == serde_json::json!(["cutter of T1", "post"]);
    let cutter = pairs.iter().find(named).unwrap_or_else(|| panic!("{pairs:?}"));
    let number = |key: &str| cutter[key].as_f64().unwrap_or_else(|| panic!("{key}: {cutter}"));
    assert!((number("min_mm") - 0.2).abs() < 1e-3, "{cutter}");
    assert!(number("proved_mm") <= 0.2 + 1e-6 && number("error_mm") < 4e-3, "{cutter}");
    assert!(found(&verdict, "collision-bodies").is_empty(), "{verdict}");
}

/// A rail on the base and a carriage on X that lies round it all over: where nothing is left of two neighbors
/// to check, they pass as a guide by the role that the machine file gives the body that is swallowed, and are
/// not checked otherwise.
#[test]
fn neighbors_that_touch_all_over_pass_by_their_role_alone() {
    let bodies = |rail: &str, carriage: &str| {
        format!(
            "\n[[body]]\nname = \"rail\"\nrole = \"{rail}\"\nattached_to = \"base\"\ncheck = true\nbox = [{{ min_mm = [-600, -5, 700], max_mm = [600, 5, 710] }}]\n\
             [[body]]\nname = \"carriage\"\nrole = \"{carriage}\"\nattached_to = \"X\"\ncheck = true\nbox = [{{ min_mm = [-20, -8, 697], max_mm = [20, 8, 713] }}]\n"
        )
    };
    for (rail, carriage, state) in [
        ("guide", "guide", "pass"),
        ("bearing", "guide", "pass"),
        ("cover", "guide", "unchecked"),
        ("cover", "cover", "unchecked"),
    ] {
        let shop = Shop::new(&machine(&bodies(rail, carriage)), POST, &over_the_post(10.0));
        shop.write("post.stl", &post(0..0, &[]));
        let verdict = shop.verdict();
        for name in ["collision", "near_miss"] {
            let (is, reason) = gate(&verdict, name);
            assert_eq!(is, state, "{rail} {carriage}: {reason}");
        }
        let reason = gate(&verdict, "collision").1;
        let words = if state == "pass" {
            "not checked, wholly inside their bearing: rail against carriage"
        } else {
            "): rail against carriage"
        };
        assert!(reason.contains(words), "{rail} {carriage}: {reason}");
        let unchecked = verdict["clearance"]["unchecked"].to_string();
        assert!(unchecked.contains("\"rail\",\"carriage\""), "{unchecked}");
    }
}
