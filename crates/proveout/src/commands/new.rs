use std::io::{self, BufRead, IsTerminal as _, Write};
use std::path::{Path, PathBuf};

use proveout_machine::Machine;
use proveout_sim::SimError;
use proveout_sim::first_part::{FirstPart, FirstPartError, Question, propose, read_answers};
use proveout_tool::LengthUnit;
use serde_json::json;

use super::advise;
use crate::args::{NewArgs, ReaderArgs, UnitArg};
use crate::failure::Failure;

/// Folder of the machine library, next to those of scenes and tools.
const LIBRARY: &str = "machines";

/// Makes a scene from programs, or lists the machines.
pub(crate) fn new(args: &NewArgs) -> Result<(), Failure> {
    if args.list_machines {
        return list(args.json);
    }
    let mut answers = match &args.answers {
        Some(file) => read_answers(file).map_err(|e| Failure::from(&SimError::from(e)))?,
        None => Default::default(),
    };
    if let Some(stock) = &args.stock {
        answers.insert("stock".into(), stock.clone());
    }
    let Some(machine) = &args.machine else {
        return Err(Failure::new("no machine given")
            .with_help("name one with --machine; `proveout new --list-machines` lists them"));
    };
    let output = args
        .output
        .clone()
        .unwrap_or_else(|| PathBuf::from(args.programs.first().and_then(|p| p.file_stem()).unwrap_or_default()));
    let folder = machine_folder(machine)?;
    let written = args.write_control.as_deref().map(|file| written_control(args, &folder, file)).transpose()?.flatten();
    let call = FirstPart {
        programs: args.programs.clone(),
        machine: folder,
        control: written.or_else(|| args.control.clone()),
        design: args.design.clone(),
        tools: args.tools.clone(),
        unit: args.unit.map(unit),
        answers,
        output: output.clone(),
        step_files: Default::default(),
    };
    let terminal = !args.json && io::stdin().is_terminal() && io::stderr().is_terminal();
    let mut dialogue = Dialogue::new(io::stdin().lock(), io::stderr());
    let proposal = propose(&call, &mut |question| terminal.then(|| dialogue.ask(question)).flatten()).map_err(|e| {
        if let (true, FirstPartError::Unanswered(open)) = (args.json, &e)
            && let Ok(text) = serde_json::to_string_pretty(&json!({ "open": open }))
        {
            say!("{text}");
        }
        let failure = match &e {
            FirstPartError::Sim(sim) if matches!(**sim, SimError::Program(_)) => {
                with_advice(told(e), args, &call.machine)
            }
            _ => told(e),
        };
        dialogue.with_answers(failure)
    })?;
    if args.json {
        proposal.write().map_err(told)?;
        let result = json!({ "output": output, "answers": proposal.answered, "scene": proposal.summary });
        say!("{}", serde_json::to_string_pretty(&result).map_err(Failure::new)?);
        return Ok(());
    }
    for line in &proposal.told {
        say!("{line}");
    }
    proposal.write().map_err(told)?;
    let answers = if proposal.answered == 1 { "answer" } else { "answers" };
    say!("\n{} {answers}; written: {}", proposal.answered, output.display());
    say!("next: proveout check {0}; proveout run {0}", output.display());
    Ok(())
}

/// How the programs of the call are read.
fn reading(args: &NewArgs) -> ReaderArgs {
    ReaderArgs { control: args.control.clone(), ..ReaderArgs::default() }
}

/// The written control file, where the programs need one.
fn written_control(args: &NewArgs, machine: &Path, file: &Path) -> Result<Option<String>, Failure> {
    if file.symlink_metadata().is_ok() {
        let message = format!("{} already exists", file.display());
        return Err(Failure::new(message).with_help("name another file with --write-control: this one is kept"));
    }
    let machine = Machine::read(machine).map_err(|e| Failure::from(&SimError::from(e)))?;
    let advice = advise::advice(&args.programs, &reading(args), Some(&machine))?;
    // Standard output is that of programs that read.
    let show = |line: String| if args.json { tell!("{line}") } else { say!("{line}") };
    let written = advise::write_control(&advice, file, false, &show)?;
    Ok(written.then(|| file.display().to_string()))
}

/// What a control file would have to say for programs that are not read.
fn with_advice(failure: Failure, args: &NewArgs, machine: &Path) -> Failure {
    let Ok(machine) = Machine::read(machine) else { return failure };
    let Ok(advice) = advise::advice(&args.programs, &reading(args), Some(&machine)) else { return failure };
    if advice.statements.is_empty() {
        return failure;
    }
    let statements: Vec<String> = advice.statements.iter().map(|s| format!("{} = {}", s.key, s.value)).collect();
    let reads = if advice.reads() { "the programs are read" } else { "fewer faults are left" };
    failure.with_more_help(format!(
        "with a control file that states {} {reads}: --write-control FILE writes it, each statement marked as assumed",
        statements.join(", ")
    ))
}

pub(super) fn unit(argument: UnitArg) -> LengthUnit {
    match argument {
        UnitArg::Mm => LengthUnit::Millimeter,
        UnitArg::Inch => LengthUnit::Inch,
    }
}

/// Questions and answers of whoever sits at the terminal.
struct Dialogue<R, W> {
    input: R,
    output: W,
    /// Answers that were typed, by key.
    answers: Vec<(String, String)>,
}

impl<R: BufRead, W: Write> Dialogue<R, W> {
    fn new(input: R, output: W) -> Self {
        Self { input, output, answers: Vec::new() }
    }

    /// Asks; an empty line takes what is proposed, where something is. None at the end of the input.
    fn ask(&mut self, question: &Question) -> Option<String> {
        let line = |text: &str| crate::terminal::plain(text).to_string();
        let mut asked = line(&format!("{}: {}\n", question.key, question.text));
        if let Some(proposed) = &question.proposed {
            asked += &line(&format!("  press Enter to accept: {proposed}\n"));
        }
        write!(self.output, "{asked}> ").and_then(|()| self.output.flush()).ok();
        let mut typed = String::new();
        self.input.read_line(&mut typed).ok().filter(|read| *read > 0)?;
        let answer = match (typed.trim(), &question.proposed) {
            ("", Some(_)) => "proposed".to_owned(),
            ("", None) => return None,
            (answer, _) => answer.to_owned(),
        };
        self.answers.push((question.key.clone(), answer.clone()));
        Some(answer)
    }

    /// A failure after answers: they are not to be typed again.
    fn with_answers(&self, failure: Failure) -> Failure {
        if self.answers.is_empty() {
            return failure;
        }
        let lines: Vec<String> = self
            .answers
            .iter()
            .map(|(key, answer)| format!("{key} = \"{}\"", answer.replace('\\', "\\\\").replace('"', "\\\"")))
            .collect();
        failure.with_more_help(format!("answers so far, for a file given with --answers: {}", lines.join(", ")))
    }
}

pub(super) fn told(e: FirstPartError) -> Failure {
    match e {
        FirstPartError::Sim(e) => Failure::from(&*e),
        FirstPartError::Refused { message, help } => Failure::new(message).with_help(help),
        FirstPartError::Unanswered(open) => {
            let keys: Vec<&str> = open.iter().map(|q| q.key.as_str()).collect();
            let lines: Vec<String> = open
                .iter()
                .map(|q| {
                    let proposed = q.proposed.as_ref().map_or_else(String::new, |p| format!("; proposed: {p}"));
                    format!("  {}: {}{proposed}", q.key, q.text)
                })
                .collect();
            let example: Vec<String> = open
                .iter()
                .map(|q| format!("{} = \"{}\"", q.key, if q.proposed.is_some() { "proposed" } else { "..." }))
                .collect();
            Failure::new(format!("no answer for: {}\n{}", keys.join(", "), lines.join("\n")))
                .with_help(format!("write the answers to a file and name it with --answers: {}", example.join(", ")))
        }
    }
}

/// Folders that may hold the machine library: the current one and those above it, then those above the
/// program.
fn libraries() -> Vec<PathBuf> {
    let mut all = Vec::new();
    let from = [std::env::current_dir().ok(), std::env::current_exe().ok()];
    for start in from.into_iter().flatten() {
        for folder in start.ancestors() {
            let library = folder.join(LIBRARY);
            if library.is_dir() && !all.contains(&library) {
                all.push(library);
            }
        }
    }
    all
}

/// The folder of a machine: a path, or a name of the library.
pub(super) fn machine_folder(name: &str) -> Result<PathBuf, Failure> {
    let path = Path::new(name);
    if path.join("machine.toml").is_file() || path.is_file() {
        return Ok(path.to_owned());
    }
    let libraries = libraries();
    if let Some(found) = libraries.iter().map(|l| l.join(name)).find(|f| f.join("machine.toml").is_file()) {
        return Ok(found);
    }
    let names: Vec<String> = libraries.iter().flat_map(|l| names_in(l)).collect();
    if names.is_empty() {
        return Err(Failure::new(format!(
            "machine {name:?} not found: no folder `machines` here, in a parent folder, or in one above the executable"
        ))
        .with_help("run the command in the project folder, or give the path of a machine folder"));
    }
    let near = proveout_sim::nearest_word(name, names.iter().map(String::as_str));
    let help = match near {
        Some(near) => format!("did you mean {near}? `proveout new --list-machines` lists them"),
        None => {
            "`proveout new --list-machines` lists them; a machine of your own is a folder with machine.toml".to_owned()
        }
    };
    Err(Failure::new(format!("machine {name:?} not found")).with_help(help))
}

fn names_in(library: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(library).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter(|e| e.path().join("machine.toml").is_file())
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// A line for each machine of the library: structure, travel, where its travel comes from.
fn list(as_json: bool) -> Result<(), Failure> {
    let Some(library) = libraries().into_iter().find(|l| !names_in(l).is_empty()) else {
        return Err(Failure::new("no folder `machines` here or in a parent folder")
            .with_help("run the command in the project folder"));
    };
    let mut all = Vec::new();
    for name in names_in(&library) {
        let read = Machine::read(&library.join(&name));
        if as_json {
            all.push(match &read {
                Ok(machine) => {
                    json!({ "name": name, "summary": machine.in_one_line(), "joints": joints(machine) })
                }
                Err(e) => json!({ "name": name, "error": e.to_string() }),
            });
            continue;
        }
        match read {
            Ok(machine) => say!("{name:<26} {}", machine.in_one_line()),
            Err(e) => say!("{name:<26} cannot be read: {e}"),
        }
    }
    if as_json {
        say!("{}", serde_json::to_string_pretty(&all).map_err(Failure::new)?);
    }
    Ok(())
}

/// Joints with their travel in mm and degrees, and whether the travel is assumed rather than published.
fn joints(machine: &Machine) -> Vec<serde_json::Value> {
    let joint = |j: &proveout_machine::Joint| {
        json!({
            "name": j.name,
            "unit": j.kind.unit(),
            "travel": j.travel.map(|t| t.map(|v| j.kind.in_unit(v))),
            "travel_chosen": machine.travel_is_chosen(j),
        })
    };
    machine.joints.iter().map(joint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn question(key: &str, proposed: Option<&str>) -> Question {
        Question { key: key.into(), text: format!("What {key}?"), proposed: proposed.map(str::to_owned) }
    }

    #[test]
    fn an_empty_line_takes_what_is_proposed_and_nothing_else() {
        let mut dialogue = Dialogue::new(&b"\n\n 40x60 \r\nlast"[..], Vec::new());
        assert_eq!(dialogue.ask(&question("holder", Some("none"))).as_deref(), Some("proposed"));
        assert_eq!(dialogue.ask(&question("design_unit", None)), None, "nothing is proposed, so that it stays open");
        assert_eq!(dialogue.ask(&question("stock", Some("0"))).as_deref(), Some("40x60"));
        assert_eq!(dialogue.ask(&question("mount", None)).as_deref(), Some("last"), "the end needs no line end");
        assert_eq!(dialogue.ask(&question("more", Some("1"))), None, "the end of the input is no empty line");
        let shown = String::from_utf8(dialogue.output.clone()).expect("text");
        assert!(shown.starts_with("holder: What holder?\n  press Enter to accept: none\n> design_unit: "), "{shown}");
        let failure = dialogue.with_answers(Failure::new("the stock holds nothing")).to_string();
        assert!(failure.contains("holder = \"proposed\", stock = \"40x60\", mount = \"last\""), "{failure}");
    }

    #[test]
    fn what_a_question_quotes_cannot_steer_the_terminal() {
        let mut dialogue = Dialogue::new(&b""[..], Vec::new());
        dialogue.ask(&question("tool.\u{1b}[2J", None));
        assert!(!dialogue.output.contains(&0x1b));
    }
}
