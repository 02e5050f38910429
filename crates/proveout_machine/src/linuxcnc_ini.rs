//! A first machine file from LinuxCNC: taken from its INI file where that has the value, otherwise assumed
//! and marked.
//!
//! The INI file gives axes, travel, velocity, acceleration, home, spindle speed, cycle and the tool change
//! position. It does not say which axes carry the table, where a rotary axis lies, where the table is, or
//! what the machine looks like. Those are assumed, with the reason. Without bodies no gate can check
//! collisions with the machine.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use proveout_input::{InputError, read_input};

use crate::units::MS_PER_NS;

/// Millimeters of an inch.
const INCH_MM: f64 = 25.4;

/// An imported machine file with the notes for its reader.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedMachine {
    /// Text of `machine.toml`.
    pub text: String,
    /// What the source file has and the machine lacks, and what must be checked first.
    pub notes: Vec<String>,
    /// Bytes of the model file that the text names as `model.glb`.
    pub model: Option<Vec<u8>>,
}

/// Keys of a section, each with its value and line.
type Section = BTreeMap<String, (String, usize)>;

/// Sections with their keys; a repeated key keeps its first value, as in LinuxCNC.
fn sections(file: &Path, text: &str) -> Result<BTreeMap<String, Section>, InputError> {
    let mut all: BTreeMap<String, Section> = BTreeMap::new();
    let mut section = String::new();
    for (at, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with(['#', ';']) {
            continue;
        }
        if let Some(name) = line.strip_prefix('[') {
            let name = name.split(']').next().unwrap_or_default().trim();
            name.clone_into(&mut section);
            all.entry(section.clone()).or_default();
            continue;
        }
        let Some((key, value)) = line.split_once('=') else {
            let message = format!("the line is neither a section nor KEY = VALUE: {line:.60}");
            return Err(
                InputError::file(file, message, "name the INI file of a LinuxCNC configuration").with_line(at + 1)
            );
        };
        let value = value.split(" #").next().unwrap_or_default().trim();
        all.entry(section.clone()).or_default().entry(key.trim().to_owned()).or_insert((value.to_owned(), at + 1));
    }
    Ok(all)
}

/// Reads the INI file of a LinuxCNC configuration. `on_table`: letters of the linear axes that carry the
/// table; all others carry the tool.
///
/// # Errors
/// [`InputError`] with the line: no INI file, no axes, a value that is no number, a unit that is not known.
pub fn import_linuxcnc_ini(file: &Path, on_table: &str) -> Result<ImportedMachine, InputError> {
    let text = read_input(file)?;
    let ini = sections(file, &text)?;
    let get = |section: &str, key: &str| ini.get(section).and_then(|s| s.get(key));
    let number = |section: &str, key: &str| match get(section, key) {
        None => Ok(None),
        Some((value, line)) => {
            match value.split_whitespace().next().and_then(|v| v.parse::<f64>().ok()).filter(|v| v.is_finite()) {
                Some(v) => Ok(Some(v)),
                None => Err(InputError::file(
                    file,
                    format!("[{section}] {key} = {value:?} is not a number"),
                    "correct the value",
                )
                .with_line(*line)),
            }
        }
    };
    let (unit, line) = get("TRAJ", "LINEAR_UNITS").map_or(("", 0), |(u, l)| (u.as_str(), *l));
    let mm = match unit.to_ascii_lowercase().as_str() {
        "mm" | "metric" => 1.0,
        "in" | "inch" | "imperial" => INCH_MM,
        _ => {
            let message = format!("[TRAJ] LINEAR_UNITS = {unit:?} is not a known unit");
            return Err(InputError::file(file, message, "write mm or inch").with_line(line));
        }
    };
    let kinematics = get("KINS", "KINEMATICS").map_or("", |(k, _)| k.as_str());
    let coordinates = get("TRAJ", "COORDINATES")
        .map_or_else(|| kinematics.split("coordinates=").nth(1).unwrap_or("XYZ"), |(c, _)| c.as_str());
    let mut letters: Vec<char> = Vec::new();
    for c in coordinates.to_ascii_uppercase().chars().filter(char::is_ascii_alphabetic) {
        if !letters.contains(&c) {
            letters.push(c);
        }
    }
    let known: Vec<char> = letters.iter().copied().filter(|c| ini.contains_key(&format!("AXIS_{c}"))).collect();
    if known.is_empty() {
        let message = "the file has no section [AXIS_X] or its like for the axes of [TRAJ] COORDINATES";
        return Err(InputError::file(file, message, "name the INI file of a LinuxCNC configuration, 2.8 or newer"));
    }
    for c in on_table.to_ascii_uppercase().chars() {
        if !known.contains(&c) || !"XYZ".contains(c) {
            return Err(InputError::file(
                file,
                format!("{c} is not a linear axis of the file"),
                "name letters of its linear axes: XY",
            ));
        }
    }
    let mut notes = Vec::new();
    if !kinematics.starts_with("trivkins") && !kinematics.is_empty() {
        notes.push(format!("kinematics {kinematics:?}: places and directions of the rotary axes are not in the file, write them into joints"));
    }
    for c in letters.iter().filter(|c| !known.contains(c)) {
        notes.push(format!("axis {c} has no section and is left out"));
    }
    let mut range = BTreeMap::new();
    let mut joints = String::new();
    let (mut last_table, mut last_tool) = ("base".to_owned(), "base".to_owned());
    // Slides from the base outward, then what turns on the table.
    let order = known.iter().filter(|c| "XYZUVW".contains(**c)).chain(known.iter().filter(|c| "ABC".contains(**c)));
    for &c in order {
        let (axis, joint) = (format!("AXIS_{c}"), joint_of(&letters, &ini, c));
        let either =
            |key: &str| -> Result<Option<f64>, InputError> { Ok(number(&axis, key)?.or(number(&joint, key)?)) };
        if "UVW".contains(c) {
            notes.push(format!("axis {c} is left out: only X, Y, Z are supported"));
            continue;
        }
        let rotary = "ABC".contains(c);
        let scale = if rotary { 1.0 } else { mm };
        let [low, high] = [either("MIN_LIMIT")?, either("MAX_LIMIT")?].map(|v| v.map(|v| v * scale));
        let table = rotary || on_table.to_ascii_uppercase().contains(c);
        let parent = if table { &mut last_table } else { &mut last_tool };
        let w = &mut joints;
        let direction = match c {
            'X' | 'A' => "[1, 0, 0]",
            'Y' | 'B' => "[0, 1, 0]",
            _ => "[0, 0, 1]",
        };
        let _ = writeln!(w, "\n[[joint]]\nname = \"{c}\"\nkind = \"{}\"", if rotary { "rotary" } else { "linear" });
        let _ = writeln!(
            w,
            "carries = \"{}\"\nparent = \"{parent}\"\ndirection = {direction}",
            if table { "workpiece" } else { "tool" }
        );
        let (length, speed, time) = if rotary { ("deg", "deg_s", 1.0) } else { ("mm", "mm_min", 60.0) };
        let mut told: Vec<String> = Vec::new();
        let mut put = |w: &mut String, key: String, value: Option<f64>| {
            if let Some(v) = value {
                let _ = writeln!(w, "{key} = {v}");
                told.push(key);
            }
        };
        let _ = writeln!(w, "sense = {}", if table { -1 } else { 1 });
        if rotary {
            let _ = writeln!(w, "point_mm = [0, 0, 0]");
        }
        match (low, high) {
            (Some(low), Some(high)) if low < high => {
                if rotary && high - low > 9000.0 {
                    let _ = writeln!(w, "endless = true");
                } else {
                    let _ = writeln!(w, "travel_{length} = [{low}, {high}]");
                }
                range.insert(c, [low, high]);
            }
            _ => notes.push(format!("axis {c} has no travel: the gate `limits` stays unchecked for it")),
        }
        put(w, format!("home_{length}"), number(&joint, "HOME")?.map(|v| v * scale));
        let velocity = either("MAX_VELOCITY")?.map(|v| v * scale * time);
        put(w, format!("max_velocity_{speed}"), velocity);
        put(w, format!("rapid_velocity_{speed}"), velocity);
        put(w, format!("max_acceleration_{length}_s2"), either("MAX_ACCELERATION")?.map(|v| v * scale));
        put(w, format!("max_jerk_{length}_s3"), either("MAX_JERK")?.map(|v| v * scale));
        let _ = writeln!(w, "\n[joint.source]\n\"*\" = \"LinuxCNC INI file\"\n\n[joint.chosen]");
        let _ = writeln!(
            w,
            "carries = \"the file does not say what the axis carries\"\nsense = \"ISO 841: a table moves against its \
             axis\""
        );
        if rotary {
            let _ = writeln!(w, "point_mm = \"the file does not give the position of the axis\"");
        }
        *parent = c.to_string();
    }
    let middle = |c: char| range.get(&c).map_or(0.0, |[low, high]| 0.5 * (low + high));
    let floor = range.get(&'Z').map_or(0.0, |[low, _]| *low);
    let name = get("EMC", "MACHINE")
        .map_or_else(|| file.file_stem().unwrap_or_default().to_string_lossy().into_owned(), |(n, _)| n.clone());
    let quoted = name.replace(['"', '\\'], "'");
    let cycle = number("EMCMOT", "SERVO_PERIOD")?.map_or(1.0, |ns| ns * MS_PER_NS);
    let speed = match number("SPINDLE_0", "MAX_FORWARD_VELOCITY")? {
        Some(rpm) if rpm > 0.0 => format!("max_speed_rpm = {rpm}\n"),
        _ => String::new(),
    };
    if get("EMCIO", "TOOL_CHANGE_POSITION").is_some() {
        notes.push(
            "TOOL_CHANGE_POSITION: write it as tool_change_mm of the joints, where a change drives the axes there"
                .into(),
        );
    }
    notes.push(
        "the machine has no bodies: nothing is checked against it until they are drawn (machines/README.md)".into(),
    );
    let text = format!(
        "# Made from the INI file of a LinuxCNC configuration, as a start. What the file does not give is marked \
         `chosen`.\n\nname = \"{quoted}\"\ndescription = \"LinuxCNC configuration; places, sides and the table are \
         chosen\"\nup = [0, 0, 1]\n{joints}\n[spindle]\non = \"{last_tool}\"\norigin_mm = [0, 0, 0]\ndirection = [0, \
         0, 1]\n{speed}start_time_s = 2\n\n[spindle.chosen]\n\"*\" = \"not in the file\"\n\n[table]\non = \
         \"{last_table}\"\npoint_mm = [{}, {}, {floor}]\nnormal = [0, 0, 1]\n\n[table.chosen]\n\"*\" = \"the file \
         does not give the position of the table: the middle of X and Y, at the lowest position of \
         Z\"\n\n[control]\nfile = \"linuxcnc-2.9\"\ncycle_time_ms = {cycle}\nblock_time_ms = 0\ntool_change_time_s = \
         10\nrapid_mode = \"straight\"\ndefault_tolerance_mm = 0.01\n\n[control.source]\ncycle_time_ms = \
         \"SERVO_PERIOD of the file, 1 ms where it has none\"\n\n[control.chosen]\n\"*\" = \"not in the file\"\n",
        middle('X'),
        middle('Y'),
    );
    Ok(ImportedMachine { text, notes, model: None })
}

/// Section of the joint that an axis moves: by its place in the coordinates.
fn joint_of(letters: &[char], ini: &BTreeMap<String, BTreeMap<String, (String, usize)>>, letter: char) -> String {
    let at = letters.iter().position(|c| *c == letter).unwrap_or(0);
    let name = format!("JOINT_{at}");
    if ini.contains_key(&name) { name } else { format!("AXIS_{letter}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Machine;

    const MILL: &str = "[EMC]\nMACHINE = Bench \"mill\"\n[TRAJ]\nCOORDINATES = X Y Z A\nLINEAR_UNITS = inch\n[KINS]\nKINEMATICS = trivkins coordinates=xyza\n\
                        [EMCMOT]\nSERVO_PERIOD = 1000000\n[AXIS_X]\nMIN_LIMIT = -10 # left\nMAX_LIMIT = 10\nMAX_VELOCITY = 2\nMAX_ACCELERATION = 20\n[JOINT_0]\nHOME = 0\n\
                        [AXIS_Y]\nMIN_LIMIT = -4\nMAX_LIMIT = 4\nMAX_VELOCITY = 2\nMAX_ACCELERATION = 20\n[JOINT_1]\nHOME = 4\n[AXIS_Z]\nMIN_LIMIT = -6\nMAX_LIMIT = 0\n\
                        MAX_VELOCITY = 1\nMAX_ACCELERATION = 10\n[JOINT_2]\nHOME = 0\n[AXIS_A]\nMIN_LIMIT = -9999\nMAX_LIMIT = 9999\nMAX_VELOCITY = 60\nMAX_ACCELERATION = 500\n";

    #[test]
    fn a_configuration_becomes_a_machine_that_is_read() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = folder.path().join("mill.ini");
        std::fs::write(&file, MILL).expect("written");
        let made = import_linuxcnc_ini(&file, "XY").expect("read");
        std::fs::write(folder.path().join("machine.toml"), &made.text).expect("written");
        let machine = Machine::read(folder.path()).unwrap_or_else(|e| panic!("{e}\n{}", made.text));
        let x = &machine.joints[machine.joint("X").expect("X")];
        assert_eq!(x.travel, Some([-254.0, 254.0]));
        // 2 inch a second.
        assert!(
            (x.max_velocity.expect("given") - 50.8).abs() < 1e-9
                && (x.max_acceleration.expect("given") - 508.0).abs() < 1e-9
        );
        assert!(machine.joints[machine.joint("A").expect("A")].endless);
        assert_eq!(machine.joints[machine.joint("Y").expect("Y")].home, 101.6);
        assert_eq!(machine.tool_chain.len(), 1);
        assert!(machine.program_zero().is_some());
    }

    #[test]
    fn what_is_no_configuration_is_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = folder.path().join("mill.ini");
        for (text, word) in [
            ("hello\n", "neither"),
            ("[TRAJ]\nLINEAR_UNITS = furlong\n", "furlong"),
            ("[TRAJ]\nLINEAR_UNITS = mm\nCOORDINATES = XYZ\n", "AXIS_X"),
            ("[TRAJ]\nLINEAR_UNITS = mm\nCOORDINATES = X\n[AXIS_X]\nMIN_LIMIT = low\n", "MIN_LIMIT"),
        ] {
            std::fs::write(&file, text).expect("written");
            let error = import_linuxcnc_ini(&file, "").expect_err(word);
            assert!(error.message.contains(word), "{error}");
        }
    }
}
