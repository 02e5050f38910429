//! The programs of the experiment of Li et al. 2022: what is committed, what re-scheduling keeps, what it gains on the joints.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use proveout_controller::{JointDemand, JointTrack, ProgramRun, Reprogrammed, TrackSettings, program_runs};
use proveout_machine::{JointValues, MAX_JOINTS, Machine};
use proveout_nc::{Command, Dialect, Op, Program, Settings};
use proveout_sim::scene::Scene;
use proveout_sim::{PartOnTable, Prepared, programs};
use proveout_tool::ToolLibrary;
use proveout_toolpath::reschedule::CurveKind;

/// Radius of the ball, mm.
const BALL: f64 = 8.0;
/// Ball center feed of the scene, mm/s.
const FEED: f64 = 1000.0 / 60.0;
/// Control sample of the specification, mm.
const STEP: f64 = 0.5;

/// The scene with what its programs are made from.
struct Experiment {
    scene: Scene,
    machine: Machine,
    tools: ToolLibrary,
    settings: Settings,
}

impl Experiment {
    fn read() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/li-2022-s-theta");
        let scene = Scene::read(&folder).unwrap();
        let machine = Machine::read(&scene.resolve(&scene.file.machine)).unwrap();
        let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools)).unwrap();
        let settings = Prepared::reader_settings(&scene, None).unwrap();
        Self { scene, machine, tools, settings }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.scene.folder.join(name)
    }

    fn made(&self, name: &str) -> Reprogrammed {
        let reschedule = self.scene.program(Some(name)).unwrap().reschedule.clone().unwrap();
        let (program, part) = (self.file("original.mpf"), PartOnTable::default());
        programs::rescheduled(&reschedule, &program, &self.settings, &self.machine, &self.tools, &part).unwrap()
    }

    fn commands(&self, name: &str, text: &str) -> Vec<Command> {
        Program::from_text(name, text, &self.settings).unwrap().collect::<Result<_, _>>().unwrap()
    }

    /// The one run of a text in a language.
    fn run(&self, commands: &[Command]) -> ProgramRun {
        let mut runs = program_runs(&self.machine, commands, 8).unwrap();
        assert_eq!(runs.len(), 1);
        runs.remove(0)
    }

    /// Joints of the cutting stretch of a program, from its posted text, every `step` mm.
    fn track(&self, text: &str, stretch: &std::ops::Range<usize>, step: f64) -> JointTrack {
        let run = self.run(&self.commands("program.mpf", text));
        let poses: Vec<_> = run.blocks[stretch.clone()].iter().map(|b| b.pose).collect();
        let settings =
            TrackSettings { gauge_length: self.tools.tools[0].gauge_length, center: BALL, step, speed: FEED };
        JointTrack::new(&self.machine, &poses, settings).unwrap()
    }
}

#[test]
fn the_committed_originals_are_what_plan_writes() {
    let e = Experiment::read();
    let commands = programs::helix(&e.scene, &e.machine, &e.tools).unwrap();
    for (file, dialect) in [("original.mpf", Dialect::Siemens840d), ("original.apt", Dialect::Apt)] {
        let made = programs::text(&commands, dialect, &e.settings).unwrap();
        let committed = fs::read_to_string(e.file(file)).unwrap();
        let line = made.lines().zip(committed.lines()).position(|(a, b)| a != b).map(|i| i + 1);
        assert!(
            made == committed,
            "{file} differs from line {line:?} on; write it again with \
             `proveout plan scenes/li-2022-s-theta --strategy helix --output scenes/li-2022-s-theta/{file}`"
        );
    }
}

#[test]
fn both_languages_of_the_original_are_the_same_path() {
    let e = Experiment::read();
    let [mpf, apt] =
        ["original.mpf", "original.apt"].map(|f| e.run(&e.commands(f, &fs::read_to_string(e.file(f)).unwrap())));
    assert_eq!(mpf.blocks.len(), apt.blocks.len());
    for (a, b) in mpf.blocks.iter().zip(&apt.blocks) {
        // Both have four decimals of ends and eight of vectors.
        assert!(
            (a.pose.tip - b.pose.tip).norm() < 1e-6 && (a.pose.axis - b.pose.axis).norm() < 1e-9,
            "line {}",
            b.line
        );
    }
}

#[test]
fn rescheduled_programs_keep_contact_points_and_structure_in_both_languages() {
    let e = Experiment::read();
    let original = e.commands("original.mpf", &fs::read_to_string(e.file("original.mpf")).unwrap());
    let before = e.run(&original);
    for name in ["quaternion", "s-theta"] {
        let made = e.made(name);
        assert!(programs::largest_center_shift(&made, BALL) < 1e-9, "{name}");
        for (file, dialect) in [("made.mpf", Dialect::Siemens840d), ("made.apt", Dialect::Apt)] {
            let text = programs::text(&made.commands, dialect, &e.settings).unwrap();
            let commands = e.commands(file, &text);
            let after = e.run(&commands);
            assert_eq!(before.blocks.len(), after.blocks.len(), "{name} {file}");
            // The ball touches where its center less the radius along the surface's normal is, and the normal belongs to the
            // place: contact points stay where centers stay. Ends have four decimals, vectors eight.
            let mut worst: f64 = 0.0;
            let mut turned: f64 = 0.0;
            for (a, b) in before.blocks.iter().zip(&after.blocks) {
                let [p, q] = [a, b].map(|block| block.pose.tip + block.pose.axis * BALL);
                worst = worst.max((p - q).norm());
                turned = turned.max((a.pose.axis - b.pose.axis).norm());
                assert!((a.pose.axis.x - b.pose.axis.x).abs() < 1e-7, "{name} {file}: the head stays");
            }
            assert!(worst < 1e-3, "{name} {file}: {worst} mm");
            assert!(turned > 0.1, "{name} {file}: the axes are new");
            // The same commands in the same order; of the motions only the ends are others.
            if dialect == Dialect::Siemens840d {
                assert_eq!(original.len(), commands.len());
                for (a, b) in original.iter().zip(&commands) {
                    assert_eq!(std::mem::discriminant(&a.op), std::mem::discriminant(&b.op));
                    if let (Op::Feed(f), Op::Feed(g)) = (&a.op, &b.op) {
                        assert_eq!(f, g, "line {}", a.location.line);
                    }
                }
            }
        }
    }
}

/// Reduction of an extreme, percent.
fn reduction(from: f64, to: f64) -> f64 {
    100.0 * (1.0 - to / from)
}

#[test]
fn the_joints_gain_what_the_specification_expects() {
    let e = Experiment::read();
    let joint = |name: &str| e.machine.joint(name).unwrap();
    let proposed = e.made("s-theta");
    let stretch = proposed.runs[0].stretch.clone();
    let posted = |made: &Reprogrammed| programs::text(&made.commands, Dialect::Siemens840d, &e.settings).unwrap();
    let original = e.track(&fs::read_to_string(e.file("original.mpf")).unwrap(), &stretch, STEP);
    let quaternion = e.track(&posted(&e.made("quaternion")), &stretch, STEP);
    let proposed = e.track(&posted(&proposed), &stretch, STEP);
    let tracks = [&original, &quaternion, &proposed];
    let demands = |name: &str| tracks.map(|t| t.demand(joint(name)));

    // Hard criteria of section 8.
    let a = demands("A");
    assert_eq!(a.map(|d| d.reversals), [12, 12, 0], "two a layer, and none");
    // The bands: A 25 to 55 and 45 to 90 percent, the others within a factor of two of the paper's Table 2.
    let bands = [
        ("A", [25.0, 45.0], [55.0, 90.0]),
        ("X", [6.3 / 2.0, 10.6 / 2.0], [6.3 * 2.0, 10.6 * 2.0]),
        ("Y", [46.2 / 2.0, 71.4 / 2.0], [92.4, 142.8]),
        ("Z", [69.2 / 2.0, 83.7 / 2.0], [138.4, 167.4]),
    ];
    let mut table =
        String::from("| joint | original | quaternion | s-theta | reduction | paper |\n|---|---|---|---|---|---|\n");
    for ((name, low, high), paper) in bands.into_iter().zip(["38.1 / 72.9", "6.3 / 10.6", "46.2 / 71.4", "69.2 / 83.7"])
    {
        let [o, q, p] = demands(name);
        let unit = if name == "A" { "deg" } else { "mm" };
        let scale = |v: f64| if name == "A" { v.to_degrees() } else { v };
        let gain = [reduction(q.velocity, p.velocity), reduction(q.acceleration, p.acceleration)];
        let cell = |d: &JointDemand| format!("{:.1} / {:.0}", scale(d.velocity), scale(d.acceleration));
        table += &format!(
            "| {name}, {unit}/s and {unit}/s2 | {} | {} | {} | {:.1} / {:.1} % | {paper} % |\n",
            cell(&o),
            cell(&q),
            cell(&p),
            gain[0],
            gain[1]
        );
        for k in 0..2 {
            assert!(gain[k] > 0.0 && (low[k]..high[k]).contains(&gain[k]), "{name}: {gain:?}\n{table}");
        }
    }
    // Time at the velocity that the proposed path needs of A, both readings of "efficiency": 15 to 35 percent.
    let mut limits = JointValues([f64::INFINITY; MAX_JOINTS]);
    limits[joint("A")] = a[2].velocity;
    let times = tracks.map(|t| t.time_within(&limits));
    assert!((times[2] - proposed.length() / FEED).abs() < 1e-9, "its own demand slows nothing down");
    let gains = [100.0 * (times[0] / times[2] - 1.0), reduction(times[0], times[2])];
    table += &format!(
        "\nTime of the cutting stretch at the A velocity of `s-theta`: {:.1} s, {:.1} s and {:.1} s; against the original {:.1} percent \
         more\nrate, {:.1} percent less time.\n",
        times[0], times[1], times[2], gains[0], gains[1]
    );
    assert!(gains.iter().all(|g| (15.0..35.0).contains(g)), "{table}");

    // The limits that the scene gives the A axis are this demand, to three digits.
    let limit = &e.scene.file.control.joint_limits["A"];
    assert!((limit.max_velocity_deg_s.unwrap() / a[2].velocity.to_degrees() - 1.0).abs() < 2e-3, "{table}");
    assert!((limit.max_acceleration_deg_s2.unwrap() / a[2].acceleration.to_degrees() - 1.0).abs() < 2e-3, "{table}");
    let readme = fs::read_to_string(e.file("README.md")).unwrap();
    assert!(readme.contains(&table), "README.md of the scene should say\n{table}");
}

#[test]
fn the_gain_in_acceleration_does_not_hang_on_the_sample() {
    let e = Experiment::read();
    let made = ["quaternion", "s-theta"].map(|name| e.made(name));
    let texts = made.each_ref().map(|m| programs::text(&m.commands, Dialect::Siemens840d, &e.settings).unwrap());
    let a = e.machine.joint("A").unwrap();
    let mut gains = Vec::new();
    let mut peaks = Vec::new();
    for step in [0.1, 0.25, 0.5, 1.0, 2.0] {
        let [q, p] = texts.each_ref().map(|t| e.track(t, &made[0].runs[0].stretch, step).demand(a));
        gains.push(reduction(q.acceleration, p.acceleration));
        peaks.push(p.acceleration.to_degrees());
        assert!((reduction(q.velocity, p.velocity) - 39.9).abs() < 0.3, "velocities do not hang on it at all: {step}");
    }
    // Both paths are chords with kinks: below the length of a block their accelerations grow as one over the step.
    assert!(peaks[0] / peaks[2] > 4.0 && peaks[0] / peaks[2] < 6.0, "{peaks:?}");
    // Beyond it the kinks of the interpolation at its keys fall between samples and count for half of what they are.
    assert!(gains[..3].iter().all(|g| (45.0..90.0).contains(g)) && gains[3..].iter().all(|g| *g > 30.0), "{gains:?}");
    let sentence = format!(
        "With steps of 0.1, 0.25, 0.5, 1 and 2 mm it is {:.0}, {:.0}, {:.0}, {:.0} and {:.0} percent",
        gains[0], gains[1], gains[2], gains[3], gains[4]
    );
    let readme = fs::read_to_string(e.file("README.md")).unwrap();
    let readme = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(readme.contains(&sentence), "README.md of the scene should say: {sentence}");
}

#[test]
fn the_planned_angle_stays_in_its_channel_and_is_monotone_after_reading() {
    let e = Experiment::read();
    let made = e.made("s-theta");
    let study = &made.runs[0].study;
    assert!(study.figure("smallest margin").unwrap() > -1e-9);
    // The same from the text: angles in the section between the limits of the study, up to the digits of the text.
    let run =
        e.run(&e.commands("made.mpf", &programs::text(&made.commands, Dialect::Siemens840d, &e.settings).unwrap()));
    let limits: Vec<_> = study.curves.iter().filter(|c| c.kind == CurveKind::Limit).collect();
    assert_eq!(limits.iter().map(|c| c.name).collect::<Vec<_>>(), ["forward limit", "backward limit"]);
    let result = study.curve(CurveKind::Result).unwrap();
    let stretch = made.runs[0].stretch.clone();
    assert_eq!(result.points.len(), stretch.len());
    let mut last: Option<f64> = None;
    let (mut sense, mut zero) = (0.0, None);
    for (k, block) in run.blocks[stretch].iter().enumerate() {
        let t = &block.pose.axis;
        let angle = t.z.atan2(t.y).to_degrees();
        let turned = last.map_or(0.0, |l| (angle - l + 540.0).rem_euclid(360.0) - 180.0);
        last = Some(angle);
        if sense == 0.0 && turned.abs() > 0.01 {
            sense = turned.signum();
        }
        // Eight decimals of a unit vector: 1e-6 degrees.
        assert!(turned * sense >= -2e-6, "block {k} turns back by {turned} degrees");
        let [theta, upper, lower] = [result, limits[0], limits[1]].map(|c| c.points[k][1]);
        assert!(theta <= upper + 1e-9 && theta >= lower - 1e-9, "block {k}");
        let off = (theta * sense - angle + 540.0).rem_euclid(360.0) - 180.0;
        if k > 0 && sense != 0.0 {
            // Zero and sense of the plane are the method's: what it shows and what is written differ by a constant.
            let first = *zero.get_or_insert(off);
            assert!((off - first).abs() < 2e-6, "block {k}: {off} {first}");
        }
    }
}
