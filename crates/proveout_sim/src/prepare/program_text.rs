//! Which program of a scene is run, and where its text is.

use std::path::{Path, PathBuf};

use proveout_input::InputError;
use proveout_nc::ProgramText;

use crate::{
    prepare::{choice::Choice, error::SimError},
    scene::{ProgramFile, Scene},
};

pub(crate) fn program_entry<'a>(scene: &'a Scene, choice: &Choice) -> Result<Option<&'a ProgramFile>, InputError> {
    let entry = scene.program(choice.program.as_deref());
    if let (Some(name), None) = (&choice.program, entry) {
        let names: Vec<&str> = scene.file.program.iter().map(|p| p.name.as_str()).collect();
        let message = format!("there is no program {name:?}");
        return Err(InputError::file(&scene.path, message, format!("programs of the scene: {}", names.join(", "))));
    }
    Ok(entry)
}

pub(crate) fn program_text(
    scene: &Scene,
    entry: Option<&ProgramFile>,
    choice: &Choice,
) -> Result<(String, PathBuf), InputError> {
    if let Some(path) = &choice.nc {
        let stem = path.file_stem().map_or_else(|| "program".to_owned(), |s| s.to_string_lossy().into_owned());
        return Ok((entry.map_or(stem, |e| e.name.clone()), path.clone()));
    }
    let Some(entry) = entry else {
        return Err(InputError::file(&scene.path, "the scene has no program", "name one with --nc FILE"));
    };
    let source = entry.reschedule.as_ref().and_then(|r| scene.program(Some(&r.from))).unwrap_or(entry);
    match &source.file {
        Some(file) => Ok((entry.name.clone(), scene.resolve(file))),
        None => {
            let message = format!("the text of program {:?} is not part of the scene", entry.name);
            let help = "give it with --nc FILE; the scene's README says where it is published";
            Err(scene.error_of_program(entry, "name", message, help))
        }
    }
}

/// A program that says nothing at all is a file that was not written, not a part that passes.
pub(crate) fn check_holds_text(program: &Path) -> Result<(), SimError> {
    let text = ProgramText::open(program)?;
    let blank = |line: &str| line.chars().all(|c| c.is_whitespace() || c == '%');
    if text.all().all(blank) {
        let remedy = "export the program again: a full disk or an interrupted copy leaves such a file";
        return Err(InputError::file(program, "the program is empty", remedy).into());
    }
    Ok(())
}

/// Name of the text of a made program: that of the program, as a plain file name.
pub(crate) fn made_file(program: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '+') { c } else { '_' };
    let name: String = program.chars().take(64).map(plain).collect();
    format!("{}.mpf", name.trim_start_matches('.'))
}
