//! Parts that a program cuts off, as a person meets them: a slug over a hole, a half on its support, under a
//! clamp, on a tilted table.

use std::{
    fs,
    path::{Path, PathBuf},
};

use proveout_sim::{
    Choice, Observer, Prepared, SimError,
    finding::Finding,
    observer::{Batch, LooseMotion, ObserverError, Outcome, Setup},
    run::run,
    verdict::{GateVerdict, State, Verdict},
};
use tempfile::TempDir;

/// Gravity of the closed forms, mm/s².
const G: f64 = 9806.65;

/// A machine of three slides that carry the tool; or of which X carries the table.
fn machine(up: &str, table_moves: bool, table: &str) -> String {
    let (x, y, on) = if table_moves { ("workpiece", "base", "X") } else { ("tool", "Y", "base") };
    let z_parent = if table_moves { "Y" } else { "X" };
    let sense = if table_moves { "sense = -1\n" } else { "" };
    let joint = |name: &str, carries: &str, parent: &str, sense: &str, direction: &str, travel: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"{carries}\"\nparent = \"{parent}\"\n\
             direction = {direction}\n{sense}{travel}\nmax_velocity_mm_min = 20_000\nmax_acceleration_mm_s2 = 3000\n\
             max_jerk_mm_s3 = 60_000\n"
        )
    };
    let wide = "travel_mm = [-200, 200]\nhome_mm = 0";
    format!(
        "name = \"mill\"\nup = {up}\n{}{}{}[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\n\
         max_speed_rpm = 6000\nstart_time_s = 0.02\n[table]\non = \"{on}\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [control]\ncycle_time_ms = 4\nblock_time_ms = 0.5\ntool_change_time_s = 0.1\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.05\ndefault_orientation_tolerance_deg = 0.1\n\
         [[body]]\nname = \"table\"\nrole = \"table\"\nattached_to = \"{on}\"\ncheck = true\nbox = [{table}]\n\
         [[body]]\nname = \"nose\"\nrole = \"nose\"\nattached_to = \"Z\"\ncheck = true\n\
         cylinder = [{{ from_mm = [0, 0, 0], to_mm = [0, 0, 60], radius_mm = 30 }}]\n",
        joint("Y", "tool", "base", "", "[0, 1, 0]", wide),
        joint("X", x, y, sense, "[1, 0, 0]", wide),
        joint("Z", "tool", z_parent, "", "[0, 0, 1]", "travel_mm = [20, 500]\nhome_mm = 400"),
    )
}

const TOOLS: &str = "[[tool]]\nnumber = 1\nname = \"END_D6\"\nkind = \"flat\"\ndiameter_mm = 6\nflute_length_mm = 20\n\
                     shank_diameter_mm = 6\noverall_length_mm = 80\ngauge_length_mm = 100\nflutes = 3\ncenter_cutting = true\n\
                     source = \"usual\"\n[tool.holder]\nname = \"chuck\"\nsections = [{ diameter_mm = 20, length_mm = 20 }]\n";

const WHOLE_TABLE: &str = "{ min_mm = [-60, -60, -40], max_mm = [60, 60, 0] }";
/// With a slot of 30 mm along y.
const SLOTTED_TABLE: &str =
    "{ min_mm = [-60, -60, -40], max_mm = [-15, 60, 0] }, { min_mm = [15, -60, -40], max_mm = [60, 60, 0] }";
const LEVEL: &str = "[0, 0, 1]";

/// A plate of 40 x 30 x 6 mm whose lower face is 50 mm above the table.
const PLATE: &str = "box = { min_mm = [-20, -15, -6], max_mm = [20, 15, 0] }";

/// A slot along Y at X 5 through the plate: 12 mm are left next to it.
fn slot(after: &str) -> String {
    format!(
        "G17 G54 G90 G94 G710 G60\nT=\"END_D6\"\nM6\nS3000 M3\nG0 X5 Y-20\nG0 Z5 D1\nG0 Z-6.5\nG1 Y22 F600\nG0 Z20\n{after}M5\nM30\n"
    )
}

fn post(name: &str, [min, max]: [[f64; 3]; 2]) -> String {
    format!("[[fixture]]\nname = \"{name}\"\nbox = {{ min_mm = {min:?}, max_mm = {max:?} }}\n")
}

struct Shop {
    folder: TempDir,
}

/// What the run showed of loose parts.
#[derive(Default)]
struct Seen(std::sync::Arc<std::sync::Mutex<Vec<LooseMotion>>>);

impl Observer for Seen {
    fn name(&self) -> &'static str {
        "seen"
    }

    fn begin(&mut self, _: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        self.0.lock().expect("one thread").extend(batch.loose.iter().cloned());
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, _: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

impl Shop {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("temporary folder") }
    }

    fn scene(&self, machine: &str, stock: &str, rest: &str, program: &str) -> PathBuf {
        let folder = self.folder.path().to_owned();
        fs::create_dir_all(folder.join("machine")).expect("made");
        fs::write(folder.join("machine/machine.toml"), machine).expect("written");
        fs::write(folder.join("tools.toml"), TOOLS).expect("written");
        fs::write(folder.join("main.mpf"), program).expect("written");
        let text = format!(
            "name = \"loose\"\nmachine = \"machine\"\ntools = \"tools.toml\"\nresolution_mm = 0.5\n[stock]\n{stock}\n\
             [mount]\ntranslation_mm = [0, 0, 56]\n[work_offsets.G54]\nZ_mm = 56\n[[program]]\nname = \"main\"\n\
             file = \"main.mpf\"\n{rest}"
        );
        fs::write(folder.join("scene.toml"), text).expect("written");
        folder
    }

    fn run(&self, scene: &Path) -> Result<(Verdict, Vec<LooseMotion>), SimError> {
        let seen = Seen::default();
        let motions = seen.0.clone();
        let result = run(Prepared::read(scene, &Choice::default())?, &mut [Box::new(seen)], scene)?;
        let motions = std::mem::take(&mut *motions.lock().expect("one thread"));
        Ok((result.verdict, motions))
    }
}

fn prove(machine: &str, rest: &str, program: &str) -> (Verdict, Vec<LooseMotion>) {
    let shop = Shop::new();
    let scene = shop.scene(machine, PLATE, rest, program);
    shop.run(&scene).expect("runs")
}

fn of<'a>(verdict: &'a Verdict, code: &str) -> Vec<&'a Finding> {
    verdict.findings.iter().filter(|f| f.code == code).collect()
}

fn gate<'a>(verdict: &'a Verdict, name: &str) -> &'a GateVerdict {
    verdict.gates.iter().find(|g| g.gate.name() == name).expect("there")
}

/// The one part that came off, reported in one finding.
fn part(verdict: &Verdict) -> &Finding {
    let matches = of(verdict, "process-loose-part");
    assert_eq!(matches.len(), 1, "{:#?}", verdict.findings);
    matches[0]
}

#[test]
fn a_slug_falls_through_the_table_and_hits_what_is_in_its_way() {
    // A slug of 12 mm: a circle of 9 mm with a tool of 6 mm.
    let program = "G17 G54 G90 G94 G710 G60\nT=\"END_D6\"\nM6\nS3000 M3\nG0 X9 Y0\nG0 Z5 D1\nG1 Z-6.5 F300\n\
                   G3 X9 Y0 I-9 J0 F800\nG0 Z20\nM5\nM30\n";
    let (verdict, motions) = prove(&machine(LEVEL, false, SLOTTED_TABLE), "", program);
    let f = part(&verdict);
    assert!(f.message.contains("fall off and are removed from the stock"), "{f:?}");
    assert_eq!(f.line, Some(8), "the circle cuts it off: {f:?}");
    let volume = std::f64::consts::PI * 36.0 * 6.0;
    assert!((f.value.expect("given") / volume - 1.0).abs() < 0.02, "{f:?}");
    assert!((verdict.removal.fallen_mm3 / volume - 1.0).abs() < 0.02, "{:?}", verdict.removal);
    let plate = 40.0 * 30.0 * 6.0;
    let sum = verdict.removal.fallen_mm3 + verdict.removal.volume_mm3 + verdict.removal.stock_left_mm3;
    assert!((sum / plate - 1.0).abs() < 1e-6, "nothing is counted twice: {sum}");
    assert!(of(&verdict, "process-loose-part-hits").is_empty(), "{:?}", verdict.findings);
    for name in ["collision", "near_miss"] {
        let g = gate(&verdict, name);
        assert!(!g.reason.contains("loose part"), "{g:?}");
    }
    assert!(gate(&verdict, "collision").reason.contains("without 1 part that fell off the stock"), "{verdict:?}");
    // Its way is shown: free fall, within the error of the simulation.
    let [motion] = &motions[..] else { panic!("{}", motions.len()) };
    assert!(motion.gone && (motion.mesh.volume() / volume - 1.0).abs() < 0.02);
    let start = motion.track[0].0;
    for (time, pose) in &motion.track {
        let fall = 0.5 * G * (time - start).powi(2);
        assert!((pose.translation.z + fall).abs() < 0.1 + 0.01 * fall, "{time} {pose:?} {fall}");
    }

    // A bar below: 40 mm of free way.
    let bar = post("bar", [[-14.0, -14.0, -56.0], [14.0, 14.0, -46.0]]);
    let (verdict, _) = prove(&machine(LEVEL, false, SLOTTED_TABLE), &bar, program);
    let hits = of(&verdict, "process-loose-part-hits");
    assert_eq!(hits.len(), 1, "{:?}", verdict.findings);
    let speed = hits[0].value.expect("given");
    assert!((speed / (2.0 * G * 40.0).sqrt() - 1.0).abs() < 0.03, "{speed}");
    assert!(hits[0].bodies.contains(&"bar".to_owned()) && hits[0].point_mm.expect("given")[2] == -46.0, "{hits:?}");
    // It lies on the bar, or the solver is not sure: both say so.
    let text = &part(&verdict).message;
    let lies = text.contains("come to rest about X 0 Y 0");
    assert!(lies || text.contains("its place is not known"), "{text}");
    assert_eq!(
        gate(&verdict, "collision").reason.contains("where loose part 1, cut off the stock, goes"),
        !lies,
        "{verdict:?}"
    );
    assert_eq!(gate(&verdict, "process").state, State::Pass, "{:?}", gate(&verdict, "process"));
}

/// A support under the smaller half of the plate from `x` on.
fn support(x: f64) -> String {
    post("support", [[x, -15.0, -56.0], [20.0, 15.0, -6.0]])
}

#[test]
fn a_half_on_its_support_stays_stock_and_may_not_be_cut() {
    let still = machine(LEVEL, false, WHOLE_TABLE);
    let (verdict, motions) = prove(&still, &support(10.0), &slot(""));
    let f = part(&verdict);
    assert!(f.message.contains("stay at rest") && f.message.contains("remain part of the stock"), "{f:?}");
    assert!((f.value.expect("given") - 12.0 * 30.0 * 6.0).abs() < 1.0 && f.line == Some(8), "{f:?}");
    assert_eq!(verdict.removal.fallen_mm3, 0.0);
    let g = gate(&verdict, "collision");
    assert!(g.reason.contains("1 part that came off the stock, at rest in its place"), "{g:?}");
    assert!(!g.reason.contains("where loose part"), "{g:?}");
    assert!(motions.iter().all(|m| !m.gone));

    // On a table that moves it slides with the first rapid.
    let moving = machine(LEVEL, true, WHOLE_TABLE);
    let (verdict, _) = prove(&moving, &support(10.0), &slot("G4 F3\nG0 X-40\n"));
    let g = gate(&verdict, "collision");
    assert!(g.state != State::Pass && g.reason.contains("the table tilts or accelerates it more"), "{g:?}");

    // The cutter comes back to it.
    let again = "G4 F3\nG0 X16 Y-20\nG0 Z-2\nG1 Y22 F600\nG0 Z20\nG4 F3\n";
    let (verdict, _) = prove(&still, &support(10.0), &slot(again));
    let cut = of(&verdict, "process-loose-part-cut");
    assert_eq!(cut.len(), 1, "{:?}", verdict.findings);
    assert_eq!(gate(&verdict, "process").state, State::Fail);
    let g = gate(&verdict, "collision");
    assert!(g.state != State::Pass && g.reason.contains("process-loose-part-cut"), "{g:?}");
}

#[test]
fn a_half_that_tips_off_its_support_is_held_by_a_clamp() {
    let still = machine(LEVEL, false, WHOLE_TABLE);
    // The middle of the half is at X 14: it hangs over.
    let (verdict, _) = prove(&still, &support(15.0), &slot(""));
    assert!(!part(&verdict).message.contains("stay at rest"), "{:?}", part(&verdict));
    let clamp = support(15.0) + &post("clamp", [[15.0, -15.0, 0.0], [20.0, 15.0, 8.0]]);
    let (verdict, _) = prove(&still, &clamp, &slot(""));
    assert!(part(&verdict).message.contains("stay at rest"), "{:?}", part(&verdict));
    assert_eq!(verdict.removal.fallen_mm3, 0.0);
}

#[test]
#[ignore = "nightly, 90 s"]
fn what_hangs_on_friction_is_not_decided() {
    // 20 degrees: between the angles of friction of 0.1 and 0.5. It slides into the kerf.
    let tilted = machine("[0.3420201433256687, 0, 0.9396926207859084]", false, WHOLE_TABLE);
    let (verdict, _) = prove(&tilted, &support(8.0), &slot(""));
    let f = part(&verdict);
    assert!(f.message.contains("where they fall is unknown") && f.message.contains("with a friction of 0.1"), "{f:?}");
    for name in ["collision", "near_miss"] {
        let g = gate(&verdict, name);
        assert!(g.state != State::Pass && g.reason.contains("where loose part 1, cut off the stock, goes"), "{g:?}");
    }
    assert_eq!(verdict.removal.fallen_mm3, 0.0);
    // Up is not stated.
    let unknown = machine(LEVEL, false, WHOLE_TABLE).replace("up = [0, 0, 1]\n", "");
    let (verdict, _) = prove(&unknown, &support(8.0), &slot(""));
    assert!(part(&verdict).message.contains("does not state `up`"), "{:?}", part(&verdict));
}

#[test]
fn the_same_fall_gives_the_same_bytes_on_any_number_of_threads() {
    let shop = Shop::new();
    let bar = post("bar", [[-20.0, -14.0, -56.0], [11.0, 14.0, -30.0]]);
    let scene = shop.scene(&machine(LEVEL, false, WHOLE_TABLE), PLATE, &bar, &slot(""));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("made");
        let (verdict, motions) = pool.install(|| shop.run(&scene)).expect("runs");
        (serde_json::to_string(&verdict).expect("written"), motions)
    };
    let (one, three) = (on(1), on(3));
    assert!(one.0.contains("process-loose-part"));
    assert_eq!(one.0, three.0);
    assert!(one.1 == three.1, "the ways differ");
}

#[test]
fn the_weight_is_that_of_the_material() {
    let shop = Shop::new();
    let message_of = |stock: &str| {
        let scene = shop.scene(&machine(LEVEL, false, WHOLE_TABLE), stock, &support(10.0), &slot(""));
        shop.run(&scene).map(|(v, _)| part(&v).message.clone())
    };
    assert!(message_of(PLATE).expect("runs").contains("(0.017 kg)"));
    assert!(message_of(&format!("{PLATE}\ndensity_kg_m3 = 2700")).expect("runs").contains("(0.006 kg)"));
    let refused = message_of(&format!("{PLATE}\ndensity_kg_m3 = 2.7")).expect_err("no density").to_string();
    assert!(refused.contains("density_kg_m3 = 2.7") && refused.contains("scene.toml:7:17"), "{refused}");
}
