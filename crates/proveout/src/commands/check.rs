use std::{collections::BTreeSet, path::Path};

use proveout_machine::Machine;
use proveout_nc::{Control, ProgramText, Survey};
use proveout_record::machine_png;
use proveout_sim::first_part::looks_binary;
use proveout_sim::preflight::{Cause, preflight};
use proveout_sim::{Choice, Prepared, SimError, control_of, read_regular_text, scene::Scene};
use proveout_tool::ToolLibrary;
use serde::Serialize;
use serde_json::json;

use super::{nc::MAX_REMARKS, output_file, reader, reports};
use crate::args::CheckArgs;
use crate::failure::Failure;

/// Largest TOML file.
const MAX_TOML_BYTES: u64 = 16 << 20;

/// What a path is.
enum InputKind {
    Scene,
    Machine,
    Tools,
    Control,
    Program,
}

/// What was found of a path.
#[derive(Default)]
struct CheckReport {
    notes: Vec<String>,
    programs: Vec<ProgramReport>,
}

/// What was found of a program.
#[derive(Default, Serialize)]
struct ProgramReport {
    /// Its name in the scene; none of a program by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// Commands of its run; none where the scene does not hold its text.
    commands: Option<u64>,
    notes: Vec<String>,
    /// Most likely cause first.
    causes: Vec<Cause>,
}

impl CheckReport {
    fn note(note: String) -> Self {
        Self { notes: vec![note], programs: Vec::new() }
    }

    /// Causes of findings to come: program and words.
    fn warnings(&self) -> Vec<[String; 2]> {
        let of = |program: &ProgramReport| {
            let name = program.name.clone().unwrap_or_default();
            let causes = program.causes.iter().filter(|c| !c.note);
            causes.map(|c| [name.clone(), format!("{}; {}", c.what, c.add)]).collect::<Vec<_>>()
        };
        self.programs.iter().flat_map(of).collect()
    }

    /// Line by line, for people.
    fn lines(&self) -> Vec<String> {
        let mut all = self.notes.clone();
        for program in &self.programs {
            let before = program.name.as_ref().map_or_else(String::new, |name| format!("program {name}: "));
            all.extend(program.commands.map(|n| format!("{before}{n} commands")));
            all.extend(program.notes.iter().map(|note| format!("{before}{note}")));
            all.extend(causes(&program.causes).into_iter().map(|line| format!("{before}{line}")));
        }
        all
    }
}

impl InputKind {
    fn word(&self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Machine => "machine",
            Self::Tools => "tools",
            Self::Control => "control",
            Self::Program => "program",
        }
    }
}

/// Checks files without running them; true when none has an error.
pub(crate) fn check(args: &CheckArgs) -> Result<bool, Failure> {
    reports::check(&args.reports)?;
    let result = check_paths(args);
    if let (Err(failure), Some(path)) = (&result, args.paths.first()) {
        reports::of_failure(&args.reports, path, CHECK, failure)?;
    }
    result
}

/// Group of what keeps the check from its work.
const CHECK: &str = "check";

fn check_paths(args: &CheckArgs) -> Result<bool, Failure> {
    let mut clean = true;
    let kinds = args.paths.iter().map(|path| Ok((path, kind(path)?))).collect::<Result<Vec<_>, Failure>>()?;
    if args.reader.stated() && !kinds.iter().any(|(_, kind)| matches!(kind, InputKind::Program)) {
        return Err(Failure::new("options for reading NC programs are given, but no path is an NC program")
            .with_help("omit --control and the other reading options: scenes and machines state their own"));
    }
    if let Some(file) = &args.picture {
        check_picture(file, args.force, &kinds)?;
    }
    let (mut all, mut suites) = (Vec::new(), Vec::new());
    for (path, kind) in kinds {
        let word = kind.word();
        let result = match kind {
            InputKind::Scene => check_scene(path),
            InputKind::Machine => check_machine(path).map_err(as_failure),
            InputKind::Tools => ToolLibrary::read(path)
                .map(|l| CheckReport::note(format!("{} tools", l.tools.len())))
                .map_err(|e| as_failure(SimError::from(e))),
            InputKind::Control => check_control(path),
            InputKind::Program if ProgramText::open(path).is_ok_and(|text| looks_binary(&text)) => {
                Err(Failure::new(format!("{} is not plain text: it looks like a binary file", path.display()))
                    .with_help("name the text file of an NC program"))
            }
            InputKind::Program => reader::settings(&args.reader, None, path)
                .and_then(|settings| check_program(&Survey::of_file(path, &settings, &mut |_, _| None)))
                .map(|program| CheckReport { programs: vec![program], ..CheckReport::default() }),
        };
        clean &= result.is_ok();
        suites.push(match &result {
            Ok(found) => reports::of_check(path, word, &found.warnings()),
            Err(failure) => reports::of_faults(path, word, failure),
        });
        if args.json {
            all.push(match &result {
                Ok(found) => json!({
                    "path": path, "kind": word, "in_order": true, "notes": found.notes, "programs": found.programs, "errors": [],
                }),
                Err(failure) => json!({
                    "path": path, "kind": word, "in_order": false, "notes": [], "programs": [], "errors": failure.for_programs(),
                }),
            });
            continue;
        }
        match result {
            Ok(found) => {
                say!("{}: in order", path.display());
                for note in found.lines() {
                    say!("  {note}");
                }
            }
            Err(failure) => tell!("{}", failure.to_string().trim_end()),
        }
    }
    reports::write(&args.reports, &suites)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&all).map_err(Failure::new)?);
    }
    if let (Some(file), Some(path), true) = (&args.picture, args.paths.first(), clean) {
        let machine = Machine::read(path).map_err(|e| as_failure(e.into()))?;
        let png = machine_png(&machine).map_err(Failure::new)?;
        output_file::put_bytes(file, args.force, png)?;
        if !args.json {
            say!("  picture: {}", file.display());
        }
    }
    Ok(clean)
}

/// A picture shows one machine, and is a PNG file that is not there yet.
fn check_picture(file: &Path, force: bool, kinds: &[(&std::path::PathBuf, InputKind)]) -> Result<(), Failure> {
    if !matches!(kinds, [(_, InputKind::Machine)]) {
        return Err(Failure::new("--picture draws one machine, but the paths are not a single machine")
            .with_help("name a single folder with machine.toml"));
    }
    if file.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
        return Err(Failure::new(format!("{}: the file extension is not .png", file.display()))
            .with_help("use the extension .png"));
    }
    output_file::check(file, force)
}

fn as_failure(e: SimError) -> Failure {
    Failure::from(&e)
}

fn kind(path: &Path) -> Result<InputKind, Failure> {
    if path.is_dir() {
        return match (path.join("scene.toml").is_file(), path.join("machine.toml").is_file()) {
            (true, _) => Ok(InputKind::Scene),
            (false, true) => Ok(InputKind::Machine),
            (false, false) => Err(Failure::new(format!("{} has neither scene.toml nor machine.toml", path.display()))
                .with_help("name the folder of a scene or a machine, or a file")),
        };
    }
    if !path.exists() {
        return Err(Failure::new(format!("{} does not exist", path.display())).with_help("check the path"));
    }
    if !path.is_file() {
        return Err(Failure::new(format!("{} is neither a file nor a folder", path.display()))
            .with_help("name a scene, a machine, a tool library, a control or a program"));
    }
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    match (name.as_str(), path.extension().and_then(|e| e.to_str())) {
        ("scene.toml", _) => Ok(InputKind::Scene),
        ("machine.toml", _) => Ok(InputKind::Machine),
        (_, Some("toml")) => kind_by_keys(path),
        _ => Ok(InputKind::Program),
    }
}

/// What a TOML file is, by the keys that only such a file has; the name of the file says nothing.
fn kind_by_keys(path: &Path) -> Result<InputKind, Failure> {
    let text = read_regular_text(path, MAX_TOML_BYTES).unwrap_or_default();
    let keys = top_keys(&text);
    let has = |words: &[&str]| words.iter().any(|word| keys.contains(*word));
    let other = |what: &str, help: &str| {
        Err(Failure::new(format!("{} is {what}; `proveout check` does not read it", path.display()))
            .with_help(help.to_owned()))
    };
    if has(&["stock", "resolution_mm", "mount", "fixture", "work_offsets"]) || has(&["machine"]) && has(&["tools"]) {
        Ok(InputKind::Scene)
    } else if has(&["dialect", "inherits", "words"]) {
        Ok(InputKind::Control)
    } else if has(&["joint", "spindle"]) {
        Ok(InputKind::Machine)
    } else if has(&["vary", "shards"]) {
        other("a sweep", "check it with `proveout sweep plan`")
    } else if has(&["setup"]) {
        other("a job of several setups", "check the scenes of its setups, or run `proveout job`")
    } else {
        Ok(InputKind::Tools)
    }
}

/// Keys and tables at the top of a TOML text, also of one that is not whole.
fn top_keys(text: &str) -> BTreeSet<&str> {
    let mut keys = BTreeSet::new();
    let mut in_table = false;
    for line in text.lines().map(str::trim_start) {
        let word = |text: &'_ str| text.find(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '_' | '-')));
        if let Some(table) = line.strip_prefix("[[").or_else(|| line.strip_prefix('[')) {
            // A line of a list that goes over several lines has no name.
            let table = table.trim_start();
            let end = word(table).unwrap_or(table.len());
            if end > 0 && table.starts_with(|c: char| c.is_ascii_alphabetic()) {
                in_table = true;
                keys.insert(&table[..end]);
            }
        } else if !in_table
            && let Some(end) = word(line).filter(|end| *end > 0)
            && line[end..].trim_start().starts_with(['=', '.'])
        {
            keys.insert(&line[..end]);
        }
    }
    keys
}

fn check_control(path: &Path) -> Result<CheckReport, Failure> {
    let control = Control::find(&path.display().to_string(), None).map_err(|e| as_failure(e.into()))?;
    Ok(CheckReport::note(format!("control \"{}\" for programs in {}", control.name(), control.dialect().name())))
}

fn check_scene(path: &Path) -> Result<CheckReport, Failure> {
    let scene = Scene::read(path).map_err(|e| as_failure(e.into()))?;
    let mut found = CheckReport::default();
    for program in &scene.file.program {
        if program.file.is_none() && program.reschedule.is_none() {
            found.programs.push(ProgramReport {
                name: Some(program.name.clone()),
                notes: vec!["its text is not part of the scene; name the file with --nc".into()],
                ..ProgramReport::default()
            });
            let machine = scene.resolve(program.machine.as_ref().unwrap_or(&scene.file.machine));
            Machine::read(&machine).map_err(|e| as_failure(e.into()))?;
            ToolLibrary::read(&scene.resolve(&scene.file.tools)).map_err(|e| as_failure(e.into()))?;
            continue;
        }
        let choice = Choice { program: Some(program.name.clone()), ..Choice::default() };
        let prepared = Prepared::read(path, &choice).map_err(as_failure)?;
        let mut own = check_program(&prepared.survey)?;
        own.notes.splice(0..0, prepared.control_note.iter().map(|note| format!("note: {note}")));
        found.programs.push(ProgramReport { name: Some(program.name.clone()), causes: preflight(&prepared), ..own });
    }
    Ok(found)
}

/// What will lead to findings, the most likely cause first.
pub(super) fn causes(all: &[Cause]) -> Vec<String> {
    let mut lines = Vec::new();
    for (n, cause) in (1..).zip(all.iter().filter(|c| !c.note)) {
        lines.push(format!("before the run, {n}: {}", cause.what));
        lines.push(format!("  {}", cause.add));
    }
    lines.extend(all.iter().filter(|c| c.note).map(|c| format!("note: {}: {}", c.what, c.add)));
    lines
}

fn check_machine(path: &Path) -> Result<CheckReport, SimError> {
    let machine = Machine::read(path)?;
    control_of(None, &machine)?;
    let all = machine.diagnose();
    let notes = all.iter().map(|d| format!("{}:{d}", machine.file().display())).collect();
    Ok(CheckReport { notes, ..CheckReport::default() })
}

/// What there is to say of a program without a fault: its commands, and what was taken for granted.
fn check_program(survey: &Survey) -> Result<ProgramReport, Failure> {
    // What a control leaves out for a reason is its choice: a note here, unchecked in a run.
    let judged = survey.judged();
    if !judged.is_empty() {
        return Err(Failure::of_program(&judged, survey.more_faults));
    }
    Ok(ProgramReport {
        commands: Some(survey.commands),
        notes: survey.remarks(MAX_REMARKS),
        ..ProgramReport::default()
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Every TOML file of the repository's scenes, machines, tools and controls, under a name that gives no
    /// hint.
    #[test]
    fn a_file_is_what_its_keys_say_whatever_its_name() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let folder = tempfile::tempdir().expect("temporary folder");
        let part = folder.path().join("part.toml");
        let mut seen = [0; 4];
        let mut open: Vec<_> = ["scenes", "machines", "tools", "controls"].map(|name| root.join(name)).into();
        while let Some(at) = open.pop() {
            for entry in fs::read_dir(&at).expect("a folder").flatten() {
                let path = entry.path();
                if path.is_dir() {
                    open.push(path);
                    continue;
                }
                if path.extension().is_none_or(|e| e != "toml") {
                    continue;
                }
                let text = fs::read_to_string(&path).expect("text");
                let inside = |name: &str| path.starts_with(root.join(name));
                let wanted = if inside("machines") && path.ends_with("machine.toml") {
                    1
                } else if inside("controls") {
                    2
                } else if inside("tools") || text.contains("\n[[tool]]") {
                    3
                } else if text.contains("resolution_mm") {
                    0
                } else {
                    continue;
                };
                // Half of a file, or one that ends in a fault, is of the same kind.
                for text in [text.clone(), format!("{text}\n[[")] {
                    fs::write(&part, text).expect("written");
                    let found = match kind(&part) {
                        Ok(InputKind::Scene) => 0,
                        Ok(InputKind::Machine) => 1,
                        Ok(InputKind::Control) => 2,
                        Ok(InputKind::Tools) => 3,
                        _ => 4,
                    };
                    assert_eq!(found, wanted, "{}", path.display());
                }
                seen[wanted] += 1;
            }
        }
        assert!(seen.iter().all(|n| *n > 2), "{seen:?}");
        for (text, what) in
            [("scene = \"a\"\n[[vary]]\nkey = \"x\"\n", "a sweep"), ("[[setup]]\nname = \"a\"\n", "a job")]
        {
            fs::write(&part, text).expect("written");
            assert!(kind(&part).err().is_some_and(|e| e.to_string().contains(what)), "{what}");
        }
    }
}
