//! The programs of the experiment of Li et al. 2022: what is committed, what re-scheduling keeps, what it gains on the joints.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use proveout_controller::{JointTrack, ProgramRun, Reprogrammed, TrackSettings, program_runs};
use proveout_machine::Machine;
use proveout_nc::{Command, Dialect, Op, Program, Settings};
use proveout_sim::scene::{MethodFile, RescheduleFile, Scene};
use proveout_sim::{Choice, Prepared, programs};
use proveout_tool::ToolLibrary;

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
        programs::rescheduled(&reschedule, &self.file("original.mpf"), &self.settings, &self.machine, &self.tools)
            .unwrap()
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

    /// Joints of the cutting stretch of a program, from its posted text.
    fn track(&self, text: &str, stretch: &std::ops::Range<usize>) -> JointTrack {
        let run = self.run(&self.commands("program.mpf", text));
        let poses: Vec<_> = run.blocks[stretch.clone()].iter().map(|b| b.pose).collect();
        let settings =
            TrackSettings { gauge_length: self.tools.tools[0].gauge_length, center: BALL, step: STEP, speed: FEED };
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
    let original = e.track(&fs::read_to_string(e.file("original.mpf")).unwrap(), &stretch);
    let quaternion = e.track(&posted(&e.made("quaternion")), &stretch);
    let proposed = e.track(&posted(&proposed), &stretch);
    let of = |track: &JointTrack, name: &str| track.demand(joint(name));
    let a = [&original, &quaternion, &proposed].map(|t| of(t, "A"));
    let shown = format!("A {:?}", a.map(|d| (d.velocity.to_degrees(), d.acceleration.to_degrees(), d.reversals)));
    println!("{shown}");
    for name in ["X", "Y", "Z", "B"] {
        let [o, q, p] = [&original, &quaternion, &proposed].map(|t| of(t, name));
        println!("{name} o {o:?}\n  q {q:?}\n  p {p:?}");
        println!("{name}: {:.1} {:.1}", reduction(q.velocity, p.velocity), reduction(q.acceleration, p.acceleration));
    }
    println!(
        "A: {:.1} {:.1}",
        reduction(a[1].velocity, a[2].velocity),
        reduction(a[1].acceleration, a[2].acceleration)
    );
}
