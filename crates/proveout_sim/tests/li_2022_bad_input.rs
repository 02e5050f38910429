//! Programs that cannot be re-scheduled: the error names the first block concerned and what would have to
//! change.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};

use proveout_controller::{ControlError, Reprogrammed};
use proveout_machine::Machine;
use proveout_sim::scene::{MethodFile, RescheduleFile, Scene};
use proveout_sim::{PartOnTable, Prepared, SimError, programs};
use proveout_tool::ToolLibrary;

/// The scene of Li et al. 2022, of which each test spoils one thing.
struct Spoiled {
    scene: Scene,
    machine: Machine,
    tools: ToolLibrary,
    program: PathBuf,
    reschedule: RescheduleFile,
}

impl Spoiled {
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

    fn made(&self) -> Result<Reprogrammed, SimError> {
        let (settings, part) = (Prepared::reader_settings(&self.scene, None).unwrap(), PartOnTable::default());
        programs::rescheduled(
            &self.scene,
            &self.reschedule,
            programs::Original::File(&self.program),
            &settings,
            &self.machine,
            &self.tools,
            &part,
        )
    }

    fn refused(&self) -> ControlError {
        match self.made() {
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

/// All words are reported, and the place is a motion of the program.
fn expect_refusal(error: &ControlError, code: &str, spoiled: &Spoiled, words: &[&str]) -> u32 {
    let text = error.to_string();
    assert_eq!(error.code, code, "{text}");
    for word in words {
        assert!(text.contains(word), "{word:?} is not in: {text}");
    }
    assert!(text.contains("(help: "), "{text}");
    let place = error.location.as_ref().unwrap();
    assert!(Path::new(&*place.file).ends_with(spoiled.program.file_name().unwrap()), "{text}");
    let program = spoiled.text();
    let line = program.lines().nth(place.line as usize - 1).unwrap();
    assert!(["G0 ", "G1 ", "X", "Y", "Z"].iter().any(|start| line.starts_with(start)), "{text}: {line}");
    place.line
}

#[test]
fn concave_turning_and_a_clearance_too_large_leave_no_channel() {
    let mut spoiled = Spoiled::new();
    spoiled.reschedule.clearance_deg = Some(62.0);
    let error = spoiled.refused();
    expect_refusal(
        &error,
        "reschedule-channel",
        &spoiled,
        &["no channel", "62.0 degrees", "set the clearance to at most"],
    );
    // What the help says helps.
    let help = error.help.unwrap();
    let most: f64 = help.split_whitespace().find_map(|w| w.parse().ok()).unwrap();
    spoiled.reschedule.clearance_deg = Some(most - 0.1);
    assert_eq!(spoiled.made().unwrap().runs.len(), 1);
}

#[test]
fn a_path_of_less_than_a_turn_has_no_layers() {
    let spoiled = Spoiled::new();
    let text = spoiled.text();
    let first = first_block(&text) as usize;
    let end: Vec<&str> = text.lines().collect();
    // Approach and 200 blocks of half a millimeter round a section of 185 mm.
    let short: Vec<&str> = end[..first + 200].iter().chain(&["TRAFOOF", "M30"]).copied().collect();
    let spoiled = spoiled.with("less_than_a_turn.mpf", &(short.join("\n") + "\n"));
    let error = spoiled.refused();
    let line = expect_refusal(&error, "reschedule-layers", &spoiled, &["has no whole layer", "one turn or more"]);
    assert!(line as usize <= first + 1, "the first block of the path: {line}");
    let spoiled = spoiled.with("no_run.mpf", "G17\nG0 X0 Y0 Z500\nM30\n");
    assert_eq!(spoiled.refused().code, "reschedule-layers");
}

#[test]
fn a_tool_that_is_no_ball_is_refused_at_the_first_block() {
    let mut spoiled = Spoiled::new();
    let text = "description = \"flat\"\n[[tool]]\nnumber = 1\nname = \"BALL_D16\"\nkind = \"flat\"\ndiameter_mm = 16\n\
                flute_length_mm = 32\nshank_diameter_mm = 16\noverall_length_mm = 170\ngauge_length_mm = 150\nflutes = 4\n\
                center_cutting = true\nsource = \"test\"\n";
    spoiled.tools = ToolLibrary::from_text(Path::new("flat.toml"), text).unwrap();
    for method in [MethodFile::STheta, MethodFile::Quaternion] {
        spoiled.reschedule.method = method;
        let line = expect_refusal(
            &spoiled.refused(),
            "reschedule-tool",
            &spoiled,
            &["not a ball end mill", "use a ball end mill"],
        );
        assert_eq!(line, first_block(&spoiled.text()));
    }
}

#[test]
fn an_orientation_outside_of_the_joint_ranges_is_named_at_its_block() {
    let mut spoiled = Spoiled::new();
    let file = spoiled.scene.resolve(&spoiled.scene.file.machine).join("machine.toml");
    let text = fs::read_to_string(&file).unwrap();
    // An A axis with end stops: the monotone plan turns once a layer.
    let a = text.find("name = \"A\"").unwrap();
    let (head, tail) = text.split_at(a);
    let stops = tail.replacen("endless = true", "travel_deg = [-400, 400]", 1).replacen(
        "endless = \"Li",
        "travel_deg = \"Li",
        1,
    );
    spoiled.machine = Machine::from_text(&file, &format!("{head}{stops}")).unwrap();
    let line = expect_refusal(
        &spoiled.refused(),
        "reschedule-range",
        &spoiled,
        &["out of reach", "A is at", "400.0 degrees", "wider range"],
    );
    assert!(line > first_block(&spoiled.text()) + 100, "the first turns are in reach: {line}");
    // A head that cannot take the tilt of the program: the first motion with the tool center held already.
    let text = text.replacen("travel_deg = [-87, 87]", "travel_deg = [-87, 3]", 1);
    spoiled.machine = Machine::from_text(&file, &text).unwrap();
    let line = expect_refusal(&spoiled.refused(), "reschedule-range", &spoiled, &["out of reach", "B", "3.0"]);
    assert!(line <= first_block(&spoiled.text()), "{line}");
}
