//! Programs that cannot be re-scheduled: the error names the first block concerned and what would have to change.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use proveout_controller::ControlError;
use proveout_machine::Machine;
use proveout_sim::scene::{MethodFile, RescheduleFile, Scene};
use proveout_sim::{Prepared, SimError, programs};
use proveout_tool::ToolLibrary;

/// The scene of Li et al. 2022, of which each test spoils one thing.
struct Spoilt {
    scene: Scene,
    machine: Machine,
    tools: ToolLibrary,
    program: PathBuf,
    reschedule: RescheduleFile,
}

impl Spoilt {
    fn new() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/li-2022-s-theta");
        let scene = Scene::read(&folder).unwrap();
        Self {
            machine: Machine::read(&scene.resolve(&scene.file.machine)).unwrap(),
            tools: ToolLibrary::read(&scene.resolve(&scene.file.tools)).unwrap(),
            program: scene.folder.join("original.mpf"),
            reschedule: RescheduleFile::plain(MethodFile::STheta, "original"),
            scene,
        }
    }

    fn text(&self) -> String {
        fs::read_to_string(&self.program).unwrap()
    }

    /// The program with another text.
    fn with(mut self, name: &str, text: &str) -> Self {
        self.program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::write(&self.program, text).unwrap();
        self
    }

    fn refused(&self) -> ControlError {
        let settings = Prepared::reader_settings(&self.scene, None).unwrap();
        match programs::rescheduled(&self.reschedule, &self.program, &settings, &self.machine, &self.tools) {
            Err(SimError::Control(error)) => *error,
            Err(other) => panic!("{other}"),
            Ok(made) => panic!("{} runs were re-scheduled", made.runs.len()),
        }
    }
}

/// Line of the first motion in feed.
fn first_block(text: &str) -> u32 {
    text.lines().position(|l| l.starts_with("G1 ")).unwrap() as u32 + 1
}

/// All words are told, and the place is a line of the program from the first motion in feed on.
fn told(error: &ControlError, code: &str, spoilt: &Spoilt, words: &[&str]) -> u32 {
    let text = error.to_string();
    assert_eq!(error.code, code, "{text}");
    for word in words {
        assert!(text.contains(word), "{word:?} is not in: {text}");
    }
    assert!(text.contains("(help: "), "{text}");
    let place = error.location.as_ref().unwrap();
    assert!(Path::new(&*place.file).ends_with(spoilt.program.file_name().unwrap()), "{text}");
    assert!(place.line >= first_block(&spoilt.text()) && (place.line as usize) <= spoilt.text().lines().count());
    place.line
}

#[test]
fn concave_turning_and_a_clearance_too_large_leave_no_channel() {
    let mut spoilt = Spoilt::new();
    spoilt.reschedule.clearance_deg = Some(62.0);
    let error = spoilt.refused();
    told(&error, "reschedule-channel", &spoilt, &["no channel", "62.0 degrees", "set the clearance to at most"]);
    // What the help says helps.
    let help = error.help.unwrap();
    let most: f64 = help.split_whitespace().find_map(|w| w.parse().ok()).unwrap();
    spoilt.reschedule.clearance_deg = Some(most - 0.1);
    let settings = Prepared::reader_settings(&spoilt.scene, None).unwrap();
    let made =
        programs::rescheduled(&spoilt.reschedule, &spoilt.program, &settings, &spoilt.machine, &spoilt.tools).unwrap();
    assert_eq!(made.runs.len(), 1);
}

#[test]
fn a_path_of_less_than_a_turn_has_no_layers() {
    let spoilt = Spoilt::new();
    let text = spoilt.text();
    let first = first_block(&text) as usize;
    let end: Vec<&str> = text.lines().collect();
    // Approach and 200 blocks of half a millimeter round a section of 185 mm.
    let short: Vec<&str> = end[..first + 200].iter().chain(&["TRAFOOF", "M30"]).copied().collect();
    let spoilt = spoilt.with("less_than_a_turn.mpf", &(short.join("\n") + "\n"));
    let error = spoilt.refused();
    let line = told(&error, "reschedule-layers", &spoilt, &["has no whole layer", "one turn or more"]);
    assert!(line as usize <= first + 1, "the first block of the path: {line}");
    let spoilt = spoilt.with("no_run.mpf", "G17\nG0 X0 Y0 Z500\nM30\n");
    assert_eq!(spoilt.refused().code, "reschedule-layers");
}

#[test]
fn a_tool_that_is_no_ball_is_refused_at_the_first_block() {
    let mut spoilt = Spoilt::new();
    let text = "description = \"flat\"\n[[tool]]\nnumber = 1\nname = \"BALL_D16\"\nkind = \"flat\"\ndiameter_mm = 16\n\
                flute_length_mm = 32\nshank_diameter_mm = 16\noverall_length_mm = 170\ngauge_length_mm = 190\nflutes = 4\n\
                center_cutting = true\nsource = \"test\"\n";
    spoilt.tools = ToolLibrary::from_text(Path::new("flat.toml"), text).unwrap();
    for method in [MethodFile::STheta, MethodFile::Quaternion] {
        spoilt.reschedule.method = method;
        let line = told(&spoilt.refused(), "reschedule-tool", &spoilt, &["not a ball end mill", "use a ball end mill"]);
        assert_eq!(line, first_block(&spoilt.text()));
    }
}

#[test]
fn an_orientation_outside_of_the_joint_ranges_is_named_at_its_block() {
    let mut spoilt = Spoilt::new();
    let file = spoilt.scene.resolve(&spoilt.scene.file.machine).join("machine.toml");
    let text = fs::read_to_string(&file).unwrap();
    // An A axis with end stops: the monotone plan turns once a layer.
    let a = text.find("name = \"A\"").unwrap();
    let (head, tail) = text.split_at(a);
    let stops = tail.replacen("endless = true", "travel_deg = [-400, 400]", 1).replacen(
        "endless = \"Li",
        "travel_deg = \"Li",
        1,
    );
    spoilt.machine = Machine::from_text(&file, &format!("{head}{stops}")).unwrap();
    let line = told(&spoilt.refused(), "reschedule-range", &spoilt, &["out of reach", "A", "400", "wider range"]);
    assert!(line > first_block(&spoilt.text()) + 100, "the first turns are in reach: {line}");
    // A head that cannot take the tilt of the program: the first block already.
    let text = text.replacen("travel_deg = [-87, 87]", "travel_deg = [-87, 3]", 1);
    spoilt.machine = Machine::from_text(&file, &text).unwrap();
    told(&spoilt.refused(), "reschedule-range", &spoilt, &["out of reach", "B", "3.0"]);
}
