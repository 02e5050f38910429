//! Values of the call that override those in the files: `run --set KEY=VALUE`, the jobs of a sweep.
//!
//! A key is named by its tables with points between them; an entry of a list by its `name`, or by
//! its number from 0: `control.joint_limits.A.max_velocity_deg_s`,
//! `program.quaternion.reschedule.keys`. Keys under `machine.` and `tools.` are those of
//! `machine.toml` and of the tool library; a joint and a tool may be given there by name alone:
//! `machine.A.max_velocity_deg_s`, `tools.BALL_D16.gauge_length_mm`. `machine` and `tools`
//! themselves are the files that the scene names. A key of `plan` makes the program again that the
//! scene says the plan writes (`planned`).
//!
//! The files stay as they are; the verdict names every value that was set. A value that could change nothing
//! in the run is refused.

use std::{collections::BTreeMap, fmt, path::Path};

use proveout_input::{InputError, InputFault, nearest, read_input};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Settings};
use proveout_tool::ToolLibrary;
use toml::{Table, Value};

use crate::{
    prepare::{choice::Choice, error::SimError, planning, programs, set_value::SetValue},
    scene::{ChoiceValueFile, HELIX, ProgramFile, Scene, StrategyFile, choice::put},
};

/// Most values of one call.
const MOST: usize = 256;

impl fmt::Display for SetValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}", self.key, self.value.exact())
    }
}

/// The file that a key belongs to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Home {
    Scene,
    Machine,
    Tools,
}

fn home(key: &str) -> (Home, &str) {
    match key.split_once('.') {
        Some(("machine", rest)) => (Home::Machine, rest),
        Some(("tools", rest)) => (Home::Tools, rest),
        _ => (Home::Scene, key),
    }
}

fn words(set: &[SetValue]) -> String {
    set.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The values as the verdict names them.
pub(crate) fn told(set: &[SetValue]) -> BTreeMap<String, String> {
    set.iter().map(|s| (s.key.clone(), s.value.exact())).collect()
}

/// The text of a file with the values that belong to it; none where there are none.
fn changed(file: &Path, set: &[SetValue], of: Home, list: Option<&str>) -> Result<Option<String>, InputError> {
    let own: Vec<&SetValue> = set.iter().filter(|s| home(&s.key).0 == of).collect();
    if own.is_empty() {
        return Ok(None);
    }
    let refused =
        |message: String| InputError::file(file, message, "correct the key: tables, names and key with dots between");
    let table: Table = read_input(file)?
        .parse()
        .map_err(|e: toml::de::Error| InputError::file(file, e.message(), "correct the file"))?;
    let mut whole = Value::Table(table);
    for set in own {
        let key = home(&set.key).1;
        // A joint or a tool by name alone.
        let (first, _) = key.split_once('.').unwrap_or((key, ""));
        let named = |list: &&str| {
            let entries = whole.get(list).and_then(Value::as_array);
            whole.get(first).is_none()
                && entries.is_some_and(|e| e.iter().any(|v| v.get("name").and_then(Value::as_str) == Some(first)))
        };
        let key = list.filter(named).map_or_else(|| key.to_owned(), |list| format!("{list}.{key}"));
        put(&mut whole, &key, &set.value).ok_or_else(|| refused(format!("{set}: this file has no such key")))?;
    }
    toml::to_string(&whole).map(Some).map_err(|e| refused(e.to_string()))
}

/// Names the values in a fault of the text that they made: its lines are not those of the file.
fn with_words(fault: &InputError, set: &[SetValue], of: Home) -> InputError {
    let own: Vec<SetValue> = set.iter().filter(|s| home(&s.key).0 == of).cloned().collect();
    let message = format!("with {} set by the call: {}", words(&own), **fault);
    InputFault { file: fault.file.clone(), message, remedy: fault.remedy.clone(), ..InputFault::default() }.into()
}

/// A scene with the values of the call.
pub(crate) fn scene(path: &Path, set: &[SetValue]) -> Result<Scene, InputError> {
    check(path, set)?;
    let file = if path.is_dir() { path.join("scene.toml") } else { path.to_owned() };
    match changed(&file, set, Home::Scene, None)? {
        None => Scene::read(path),
        Some(text) => {
            let scene = Scene::of_text(file, &text).map_err(|fault| with_words(&fault, set, Home::Scene))?;
            Ok(Scene { values_set: true, ..scene })
        }
    }
}

/// A machine with the values of the call.
pub(crate) fn machine(path: &Path, set: &[SetValue]) -> Result<Machine, InputError> {
    let file = if path.is_dir() { path.join("machine.toml") } else { path.to_owned() };
    match changed(&file, set, Home::Machine, Some("joint"))? {
        None => Machine::read(path),
        Some(text) => Machine::from_text(&file, &text).map_err(|fault| with_words(&fault, set, Home::Machine)),
    }
}

/// A tool library with the values of the call.
pub(crate) fn tools(path: &Path, set: &[SetValue]) -> Result<ToolLibrary, InputError> {
    match changed(path, set, Home::Tools, Some("tool"))? {
        None => ToolLibrary::read(path),
        Some(text) => ToolLibrary::from_text(path, &text).map_err(|fault| with_words(&fault, set, Home::Tools)),
    }
}

/// No key twice, and not more than anyone writes.
fn check(path: &Path, set: &[SetValue]) -> Result<(), InputError> {
    let fault = |message: String, remedy: &str| Err(InputError::file(path, message, remedy));
    if set.len() > MOST {
        return fault(format!("the call sets {} values; the limit is {MOST}", set.len()), "write a scene of its own");
    }
    for (i, one) in set.iter().enumerate() {
        if set[..i].iter().any(|s| s.key == one.key) {
            return fault(format!("the call sets {} twice", one.key), "set it once");
        }
        if matches!(one.value, ChoiceValueFile::Number(v) if !v.is_finite()) {
            return fault(format!("the call sets {one}, which is not a number"), "write a number");
        }
    }
    Ok(())
}

/// Keys of a scene that say nothing about a run.
const OF_NO_RUN: [(&str, &str); 2] = [
    ("compare", "only comparisons: change it in the scene"),
    ("name", "only the names of folders: choose the folder by --output"),
];

/// Refuses a value that could change nothing in the run of this program.
pub(crate) fn check_used(scene: &Scene, entry: Option<&ProgramFile>, choice: &Choice) -> Result<(), InputError> {
    let fault = |message: String, remedy: &str| Err(InputError::file(&scene.path, message, remedy));
    for one in &choice.set {
        let steps: Vec<&str> = one.key.split('.').collect();
        if let Some((_, what)) = OF_NO_RUN.iter().find(|(table, _)| *table == steps[0]) {
            return fault(format!("{one} affects {what}"), "leave it out");
        }
        let whole_key = one.key.as_str();
        let by_option = match whole_key {
            "resolution_mm" => choice.resolution_mm.map(|_| "--resolution-mm"),
            "control.dynamics" => choice.dynamics.map(|_| "--dynamics"),
            "control.plant" => choice.plant.map(|_| "--plant"),
            _ => None,
        };
        if let Some(option) = by_option {
            return fault(format!("{one} and {option} say the same thing"), "give one of them");
        }
        let Some(entry) = entry else {
            if matches!(steps[0], "program" | "plan") {
                return fault(
                    format!("{one}: the call names the program file"),
                    "leave it out, or run a program of the scene",
                );
            }
            continue;
        };
        let own = match whole_key {
            "machine" => entry.machine.is_some(),
            "control.dynamics" => entry.dynamics.is_some(),
            _ => steps[0] == "mount" && entry.mount.is_some(),
        };
        if own {
            let message = format!("{one}: the program {:?} has its own", entry.name);
            return fault(message, &format!("set program.{}.{}", entry.name, one.key));
        }
        if steps[0] == "program" {
            let from = entry.reschedule.as_ref().map(|r| r.from.as_str());
            let of = scene
                .file
                .program
                .iter()
                .enumerate()
                .find(|(i, p)| steps[1..].first().is_some_and(|s| *s == p.name || *s == i.to_string()));
            if let Some((_, other)) = of.filter(|(_, p)| p.name != entry.name && Some(p.name.as_str()) != from) {
                return fault(
                    format!("{one} affects the program {:?}, but the run is of {:?}", other.name, entry.name),
                    "leave it out, or run that program",
                );
            }
        }
        let nc_given = choice.nc.is_some();
        if steps[0] == "plan"
            && (nc_given || plan_of(scene, entry).is_none_or(|(plan, _)| steps[1..].first() != Some(&plan)))
        {
            let message = format!("{one}: the scene does not state that this plan writes the program {:?}", entry.name);
            let plans = scene.file.program.iter().filter_map(|p| p.planned.as_deref());
            let near = nearest(steps.get(1).copied().unwrap_or_default(), plans)
                .map_or_else(String::new, |n| format!("; did you mean plan.{n}?"));
            return fault(message + &near, "give `planned` in its [[program]]: the name of the table under [plan]");
        }
    }
    Ok(())
}

/// The plan that writes a program, or the one that it is re-scheduled from, with that program.
fn plan_of<'a>(scene: &'a Scene, entry: &'a ProgramFile) -> Option<(&'a str, &'a ProgramFile)> {
    let source = match &entry.reschedule {
        Some(reschedule) => scene.program(Some(&reschedule.from))?,
        None => entry,
    };
    Some((source.planned.as_deref()?, source))
}

/// What the plan of a program writes now, where the call changes what it is made from.
pub(crate) fn planned_again(
    scene: &Scene,
    entry: Option<&ProgramFile>,
    set: &[SetValue],
    (machine, tools): (&Machine, &ToolLibrary),
    settings: &Settings,
) -> Result<Option<String>, SimError> {
    let changes = set.iter().any(|s| s.key.starts_with("plan.") || s.key.starts_with("part."));
    let Some((plan, source)) = entry.filter(|_| changes).and_then(|e| plan_of(scene, e)) else { return Ok(None) };
    let scene = &*scene.planned_for(source);
    let commands = match StrategyFile::named(plan) {
        Some(strategy) => planning::plan(scene, machine, tools, strategy)?.commands,
        None => {
            debug_assert_eq!(plan, HELIX.0);
            programs::helix(scene, machine, tools)?
        }
    };
    programs::text(&commands, Dialect::Siemens840d, settings).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_numbers_switches_and_words() {
        let of = |text: &str| text.parse::<SetValue>();
        assert_eq!(of("a.b=3").expect("one").value, ChoiceValueFile::Whole(3));
        assert_eq!(of(" a.b = 3.5 ").expect("one").value, ChoiceValueFile::Number(3.5));
        assert_eq!(of("a=true").expect("one").value, ChoiceValueFile::Switch(true));
        assert_eq!(of("machine=../x=y").expect("one").value, ChoiceValueFile::Word("../x=y".into()));
        assert_eq!(of("a=0.1").expect("one").to_string(), "a = 0.1");
        for wrong in ["a", "=3", "a..b=3", ".a=3", "a=", "a=nan", "a=inf", "a=-inf", "a=1e999"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }

    fn library(name: &str) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
    }

    fn set(text: &str) -> Vec<SetValue> {
        text.split_whitespace().map(|t| t.parse().expect("a value")).collect()
    }

    #[test]
    fn joints_and_tools_are_found_by_name_alone_and_what_is_no_key_is_refused() {
        let folder = library("machines/starrag-lx-451");
        let short = machine(&folder, &set("machine.A.max_acceleration_deg_s2=90")).expect("a limit");
        let long = machine(&folder, &set("machine.joint.A.max_acceleration_deg_s2=90")).expect("a limit");
        let a = short.joint("A").expect("a joint");
        assert_eq!(short.joints[a].max_acceleration, long.joints[a].max_acceleration);
        assert!((short.joints[a].max_acceleration.expect("a limit") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let tool = tools(&library("tools/li-2022.toml"), &set("tools.BALL_D16.gauge_length_mm=200")).expect("a tool");
        assert!((tool.tools[0].gauge_length - 200.0).abs() < 1e-12);
        for wrong in
            ["machine.A.max_velocty_deg_s=90", "machine.Q.max_velocity_deg_s=9", "machine.A.max_velocity_deg_s=-1"]
        {
            let error = machine(&folder, &set(wrong)).expect_err(wrong);
            assert!(error.to_string().contains("set by the call"), "{error}");
        }
        let error = scene(&library("scenes/li-2022-s-theta"), &set("control.dynamic=ideal")).expect_err("no key");
        assert!(error.to_string().contains("control.dynamic = ideal set by the call"), "{error}");
        assert!(error.to_string().contains("dynamics"), "the nearest key: {error}");
        assert!(
            scene(&library("scenes/li-2022-s-theta"), &set("resolution_mm=0.3 resolution_mm=0.4")).is_err(),
            "twice"
        );
    }
}
