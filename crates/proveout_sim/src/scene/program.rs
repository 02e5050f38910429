//! Programs of a scene: a text, one that a plan writes (with a tool axis of its own: `planned_axis`), or one
//! that is re-scheduled.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use proveout_input::{InputError, Step::Item, Step::Key};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::{
    AxisFile, Dynamics, HELIX, Mount, OffsetFile, RescheduleFile, Scene, SceneFile, StrategyFile, place::offset_of,
};

/// One named program.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProgramFile {
    /// Name.
    pub name: String,
    /// Program text, relative to the scene; left out where the text is not ours: give it with `--nc`.
    pub file: Option<PathBuf>,
    /// Table under `[plan]` that writes `file`, for choices of `compare` that change the plan.
    pub planned: Option<String>,
    /// Orientation of the tool axis, instead of the one in that table, for `planned` by contacts.
    pub planned_axis: Option<AxisFile>,
    /// How the program is made from another one of this scene, instead of `file`.
    pub reschedule: Option<RescheduleFile>,
    /// Dialect; found from the ending and the text when left out.
    pub dialect: Option<String>,
    /// Machine for this program, where it is not the scene's.
    pub machine: Option<PathBuf>,
    /// Work offsets for this program, where they are not the scene's.
    pub work_offsets: Option<BTreeMap<String, OffsetFile>>,
    /// Mounting for this program, where it is not the scene's.
    pub mount: Option<Mount>,
    /// Dynamics for this program, where they are not the scene's.
    pub dynamics: Option<Dynamics>,
    /// The block-skip switch: `on` leaves out the blocks that a `/` begins, whatever its level, `off` runs
    /// them, `both` runs the program either way and judges each gate by the worse. When left out, and no
    /// control file says it, such blocks are run and the gate `program` is unchecked.
    pub block_skip: Option<SwitchFile>,
    /// The switch of the optional stop M1: `off` passes it, `on` stops there, and the spindle with
    /// it until the next M3 or M4, `both` runs the program either way. When left out, a program
    /// that cuts after M1 without a new M3 or M4 has its gate `program` unchecked.
    pub optional_stop: Option<SwitchFile>,
}

/// A switch of the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SwitchFile {
    /// On.
    On,
    /// Off.
    Off,
    /// Each of them is proved.
    Both,
}

impl Scene {
    /// This scene with the table that writes a program as that program wants it.
    pub fn planned_for(&self, program: &ProgramFile) -> Cow<'_, Self> {
        let strategy = program.planned.as_deref().and_then(StrategyFile::named);
        let (Some(strategy), Some(axis)) = (strategy, &program.planned_axis) else { return Cow::Borrowed(self) };
        let mut own = self.clone();
        if let Some(table) = own.file.plan.as_mut().and_then(|plan| strategy.of_mut(plan)) {
            table.axis = axis.clone();
        }
        Cow::Owned(own)
    }
}

/// Programs have names and texts of their own, and options that their methods read.
///
/// # Errors
/// The first fault.
pub(crate) fn check(path: &Path, text: &str, file: &SceneFile) -> Result<(), InputError> {
    let fault = |offset: usize, message: String, help: &str| Err(InputError::at(path, text, offset, message, help));
    for (i, program) in file.program.iter().enumerate() {
        let of_key = |key: &'static str| offset_of(text, &[Key("program"), Item(i), Key(key)]);
        if program.reschedule.is_some() && program.file.is_some() {
            let at = of_key("reschedule");
            let message = format!("program {:?} has both a file and `reschedule`", program.name);
            return fault(at, message, "give either `file` or `reschedule`");
        }
        let plan = |name: &str| {
            let plans = file.plan.as_ref();
            let helix = name == HELIX.0 && plans.is_some_and(|p| p.helix.is_some());
            helix || StrategyFile::named(name).is_some_and(|s| plans.is_some_and(|p| s.of(p).is_some()))
        };
        if let Some(name) = program.planned.as_deref().filter(|name| program.file.is_none() || !plan(name)) {
            let at = of_key("planned");
            let message =
                format!("program {:?} is planned by {name:?}, which writes no file of this scene", program.name);
            return fault(at, message, "name a table under [plan], for a program with a file");
        }
        let by_contacts = program.planned.as_deref().is_some_and(|name| StrategyFile::named(name).is_some());
        if program.planned_axis.is_some() && !by_contacts {
            let at = of_key("planned_axis");
            let message = format!("program {:?} gives `planned_axis` without a plan that reads it", program.name);
            return fault(at, message, "name a table under [plan] other than helix as `planned`, or leave it out");
        }
        if let Some(reschedule) = &program.reschedule
            && let Some(key) = reschedule.unread()
        {
            let at = of_key("reschedule");
            let read = reschedule.read().join(", ");
            let message = format!("program {:?} gives `{key}`, which its method does not read", program.name);
            return fault(at, message, &format!("leave it out; options of the method: {read}"));
        }
        if let Some(reschedule) = &program.reschedule
            && !file.program.iter().any(|p| p.name == reschedule.from && p.file.is_some())
        {
            let at = of_key("reschedule");
            let message = format!("program {:?} is made from {:?}, which has no file", program.name, reschedule.from);
            return fault(at, message, "name a program of this scene that has a file");
        }
        if file.program[..i].iter().any(|p| p.name == program.name) {
            let at = of_key("name");
            return fault(at, format!("two programs are named {:?}", program.name), "give each its own name");
        }
    }
    Ok(())
}
