use std::path::{Path, PathBuf};

use proveout_machine::Machine;
use proveout_nc::{Program, Settings};
use proveout_sim::{Choice, Prepared, SimError, scene::Scene};
use proveout_tool::ToolLibrary;

use crate::failure::Failure;

/// What a path is.
enum Kind {
    Scene,
    Machine,
    Tools,
    Program,
}

/// Checks files without running them; true when none has an error.
pub(crate) fn check(paths: &[PathBuf]) -> Result<bool, Failure> {
    let mut clean = true;
    for path in paths {
        let result = match kind(path)? {
            Kind::Scene => check_scene(path),
            Kind::Machine => check_machine(path),
            Kind::Tools => {
                ToolLibrary::read(path).map(|l| vec![format!("{} tools", l.tools.len())]).map_err(SimError::from)
            }
            Kind::Program => check_program(path),
        };
        match result {
            Ok(notes) => {
                say!("{}: in order", path.display());
                for note in notes {
                    say!("  {note}");
                }
            }
            Err(e) => {
                clean = false;
                tell!("{}", Failure::from(&e).to_string().trim_end());
            }
        }
    }
    Ok(clean)
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    if path.is_dir() {
        return match (path.join("scene.toml").is_file(), path.join("machine.toml").is_file()) {
            (true, _) => Ok(Kind::Scene),
            (false, true) => Ok(Kind::Machine),
            (false, false) => Err(Failure::new(format!("{} has neither scene.toml nor machine.toml", path.display()))
                .with_help("name the folder of a scene or a machine, or a file")),
        };
    }
    if !path.is_file() {
        return Err(Failure::new(format!("{} is not there", path.display())).with_help("check the path"));
    }
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(match (name.as_str(), path.extension().and_then(|e| e.to_str())) {
        ("scene.toml", _) => Kind::Scene,
        ("machine.toml", _) => Kind::Machine,
        (_, Some("toml")) => Kind::Tools,
        _ => Kind::Program,
    })
}

fn check_scene(path: &Path) -> Result<Vec<String>, SimError> {
    let scene = Scene::read(path)?;
    let mut notes = Vec::new();
    for program in &scene.file.program {
        if program.file.is_none() && program.reschedule.is_none() {
            notes.push(format!("program {}: its text is not part of the scene, give it with --nc", program.name));
            Machine::read(&scene.resolve(program.machine.as_ref().unwrap_or(&scene.file.machine)))?;
            ToolLibrary::read(&scene.resolve(&scene.file.tools))?;
            continue;
        }
        let choice = Choice { program: Some(program.name.clone()), ..Choice::default() };
        let prepared = Prepared::read(path, &choice)?;
        let commands = execute(prepared.program()?)?;
        notes.push(format!("program {}: {commands} commands", program.name));
    }
    Ok(notes)
}

fn check_machine(path: &Path) -> Result<Vec<String>, SimError> {
    let machine = Machine::read(path)?;
    let all = machine.diagnose();
    Ok(all.iter().map(|d| format!("{}:{d}", machine.file().display())).collect())
}

fn check_program(path: &Path) -> Result<Vec<String>, SimError> {
    let commands = execute(Program::open(path, &Settings::default())?)?;
    Ok(vec![format!("{commands} commands")])
}

/// Executes a program without a machine; gives the number of its commands.
fn execute(program: Program) -> Result<u64, SimError> {
    let mut commands = 0;
    for command in program {
        command?;
        commands += 1;
    }
    Ok(commands)
}
