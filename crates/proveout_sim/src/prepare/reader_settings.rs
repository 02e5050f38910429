//! How the programs of a scene are read: language, work offsets, radii of tools, what control file and
//! machine say.

use std::{collections::BTreeMap, path::Path};

use proveout_input::InputError;
use proveout_machine::Machine;
use proveout_nc::{Compensation, Dialect, Limits, Settings as NcSettings, Settings, ToolName, ToolRadii, WorkOffset};
use proveout_tool::ToolLibrary;

use crate::{
    prepare::{
        control_file::{control_of, settings_on},
        error::SimError,
        machine_data::with_machine,
        prepared::Prepared,
        reading,
    },
    scene::{ProgramFile, Scene},
};

impl Prepared {
    /// Settings of a reader as a run has them: offsets, dialect, what the machine gives, and contours as
    /// paths of the tool center.
    ///
    /// `given`: the program is not that of the entry. Returns a note, too, where the control of the
    /// scene has no part in reading it.
    ///
    /// # Errors
    /// A dialect that is not known, a control file that is wrong.
    pub(crate) fn running_settings(
        scene: &Scene,
        entry: Option<&ProgramFile>,
        tools: &ToolLibrary,
        machine: &Machine,
        program: &Path,
        given: bool,
    ) -> Result<(NcSettings, Option<String>), SimError> {
        let compensation = Compensation::ToolCenter(tool_radii(tools));
        let control = control_of(Some(scene), machine)?;
        let (mut on_control, note) = settings_on(control.as_ref(), dialect(scene, entry, given)?, program)?;
        reading::of(entry).first().copied().unwrap_or_default().apply(&mut on_control);
        let work_offsets = work_offsets(scene, entry);
        let limits = scene.file.run_limits.of_reader(on_control.limits);
        Ok((NcSettings { compensation, work_offsets, limits, ..with_machine(on_control, machine) }, note))
    }

    /// Settings of a reader for a scene's offsets.
    ///
    /// # Errors
    /// A dialect that is not known.
    pub fn reader_settings(scene: &Scene, entry: Option<&ProgramFile>) -> Result<NcSettings, InputError> {
        Ok(NcSettings {
            dialect: dialect(scene, entry, false)?,
            work_offsets: work_offsets(scene, entry),
            limits: scene.file.run_limits.of_reader(Limits::default()),
            ..NcSettings::default()
        })
    }
}

/// Radii of the library as a control has them in its tool table; offset numbers are those of the tools.
pub fn tool_radii(tools: &ToolLibrary) -> ToolRadii {
    let mut radii = ToolRadii { offset_is_tool: true, ..ToolRadii::default() };
    for tool in &tools.tools {
        let radius = tool.cutting().map(|body| body.profile.max_radius()).fold(0.0, f64::max);
        radii.by_tool.insert(ToolName::Number(tool.number), radius);
        radii.by_tool.insert(ToolName::Name(tool.name.clone()), radius);
    }
    radii
}

fn work_offsets(scene: &Scene, entry: Option<&ProgramFile>) -> BTreeMap<String, WorkOffset> {
    let offsets = entry.and_then(|e| e.work_offsets.as_ref()).unwrap_or(&scene.file.work_offsets);
    offsets.iter().map(|(word, o)| (word.clone(), o.into())).collect()
}

/// The dialect of a program's text; that of a re-scheduled program is the one of the text that it
/// is made from, and that of a text that is `given` instead is recognized from the text.
fn dialect(scene: &Scene, entry: Option<&ProgramFile>, given: bool) -> Result<Dialect, InputError> {
    if given {
        return Ok(Dialect::Auto);
    }
    let source = entry.and_then(|e| e.reschedule.as_ref()).and_then(|r| scene.program(Some(&r.from)));
    match [entry, source].into_iter().flatten().find_map(|e| Some((e, e.dialect.as_deref()?))) {
        None => Ok(Dialect::Auto),
        Some((of, name)) => Dialect::from_name(name).ok_or_else(|| {
            let names: Vec<&str> = Dialect::NAMES.iter().map(|(name, _)| *name).collect();
            let message = format!("dialect {name:?} is not known");
            scene.error_of_program(
                of,
                "dialect",
                message,
                format!("write one of {}, or leave it out", names.join(", ")),
            )
        }),
    }
}

/// How the text of a made program is read, from how its source is.
pub(crate) fn settings_of_made(source: Settings) -> Settings {
    Settings {
        work_offsets: source.work_offsets,
        compensation: source.compensation,
        reference_points: source.reference_points,
        kinematics: source.kinematics,
        dialect: Dialect::Siemens840d,
        limits: source.limits,
        ..Settings::default()
    }
}
