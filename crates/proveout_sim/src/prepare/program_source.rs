//! What a program is made from, and the making: re-scheduled from another program, or planned again.

use std::path::Path;

use proveout_geom::{Pose, TriMesh};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Settings};
use proveout_tool::ToolLibrary;

use crate::{
    prepare::{
        choice::Choice, error::SimError, made_program::MadeProgram, part_on_table::PartOnTable,
        program_text::made_file, programs, reader_settings, set_values,
    },
    scene::{ProgramFile, Scene},
};

/// What a program is made from.
pub(crate) struct Source<'a> {
    pub(crate) scene: &'a Scene,
    /// Its entry in the scene.
    pub(crate) entry: Option<&'a ProgramFile>,
    /// Its name, and the file of its text.
    pub(crate) program: (&'a str, &'a Path),
    /// How its text is read.
    pub(crate) settings: &'a Settings,
    pub(crate) machine: &'a Machine,
    pub(crate) tools: &'a ToolLibrary,
    pub(crate) part_mesh: Option<&'a TriMesh>,
    pub(crate) fixtures: &'a [(String, TriMesh)],
    pub(crate) table_from_work: &'a Pose,
}

impl Source<'_> {
    /// The made program, and part and fixtures as its method has seen them; none where the program
    /// runs unchanged.
    ///
    /// # Errors
    /// What the method or the plan refuses.
    pub(crate) fn make(&self, choice: &Choice) -> Result<Option<(MadeProgram, Option<PartOnTable>)>, SimError> {
        let Source { scene, entry, machine, tools, .. } = *self;
        let (name, path) = self.program;
        let reschedule = entry.and_then(|e| e.reschedule.as_ref()).filter(|_| choice.nc.is_none());
        let planned = set_values::planned_again(scene, entry, &choice.set, (machine, tools), self.settings)?;
        let file = made_file(name);
        let Some(reschedule) = reschedule else {
            return Ok(planned.map(|text| (MadeProgram { file, text, runs: Vec::new(), planned: None }, None)));
        };
        let part = PartOnTable::new(scene, self.table_from_work, self.part_mesh, self.fixtures)?;
        let settings = match planned {
            None => self.settings.clone(),
            Some(_) => reader_settings::settings_of_made(self.settings.clone()),
        };
        let source = planned.as_deref().map_or(programs::Original::File(path), programs::Original::Text);
        let made = programs::rescheduled(scene, reschedule, source, &settings, machine, tools, &part)?;
        let text = programs::text(&made.commands, Dialect::Siemens840d, self.settings)?;
        Ok(Some((MadeProgram { file, text, runs: made.runs, planned }, Some(part))))
    }
}
