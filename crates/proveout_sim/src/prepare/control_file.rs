//! Which control reads a program: the file that the scene names, else the one of the machine.

use std::path::Path;
use std::sync::Arc;

use proveout_machine::Machine;
use proveout_nc::{Control, Dialect, ProgramText, Settings, detect};

use crate::{prepare::error::SimError, scene::Scene};

/// Lines of a program that are read to recognize its language.
const TOLD_FROM: usize = 200;

/// The control of a scene on a machine; none where neither names one. A name is that of a built-in
/// control, or a path relative to the folder of the file that names it.
///
/// # Errors
/// A control that is not there or wrong.
pub fn control_of(scene: Option<&Scene>, machine: &Machine) -> Result<Option<Arc<Control>>, SimError> {
    let of_scene = scene.and_then(|scene| Some((scene.file.control.file.as_deref()?, scene.path.parent())));
    let of_machine = || Some((machine.control.file.as_deref()?, machine.file().parent()));
    let Some((name, folder)) = of_scene.or_else(of_machine) else { return Ok(None) };
    Ok(Some(Control::find(name, folder)?))
}

/// Settings of a reader for a program on a control. A control reads programs of its own language.
/// One in another language is read by the reader of its language alone; the note says so.
///
/// # Errors
/// The program cannot be read.
pub fn settings_on(
    control: Option<&Arc<Control>>,
    dialect: Dialect,
    program: &Path,
) -> Result<(Settings, Option<String>), SimError> {
    let alone = || Settings { dialect, ..Settings::default() };
    let Some(control) = control else { return Ok((alone(), None)) };
    let told = match dialect {
        Dialect::Auto => {
            let text = ProgramText::open(program)?;
            let first: Vec<&str> = text.all().take(TOLD_FROM).collect();
            detect(&program.display().to_string(), &first.join("\n"))
        }
        dialect => dialect,
    };
    if told == Dialect::Auto || told.family() == control.dialect().family() {
        return Ok((Settings::of_control(Arc::clone(control)), None));
    }
    let note = format!(
        "{} is written in {}: the control \"{}\", which is for {}, is not applied",
        program.display(),
        told.name(),
        control.name(),
        control.dialect().name()
    );
    Ok((alone(), Some(note)))
}
