//! A program that is made again by a method of re-scheduling, with how far it is from the best schedule.

use std::path::Path;

use proveout_controller::{ControlError, Reprogrammed};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Settings};
use proveout_reschedule::{ChannelWidth, KeptSchedule};
use proveout_tool::ToolLibrary;

use crate::{
    compare::certificate::{ScheduleCertificate, blocks_of, certify},
    prepare::{
        error::SimError,
        motion_only::{self, MotionCase, Source},
        prepared::Prepared,
        programs::{Original, Rescheduling, rescheduled, text},
        reader_settings::settings_of_made,
    },
    scene::{Scene, joint_limits::limit_joints},
};

/// A program that is made again.
#[derive(Clone, Debug, PartialEq)]
pub struct Remade {
    /// Its text.
    pub text: String,
    /// How far its stretches are from the best schedules.
    pub certificate: ScheduleCertificate,
    /// Why there is no certificate of a stretch, one for each.
    pub uncertified: Vec<String>,
    /// Channels that the method has looked at, those of each run in order.
    pub channels: Vec<ChannelWidth>,
    /// Time in feed of the program before and of this one, s.
    pub feed_s: [f64; 2],
    /// Whose schedule the method has kept, since none of its own was faster or smoother.
    pub kept: Option<KeptSchedule>,
}

/// Refuses a program that sends a joint past its travel where the program before does not.
fn refuse_over_travel(
    machine: &Machine,
    new: &motion_only::Motion,
    original: &motion_only::Motion,
    made: &Reprogrammed,
) -> Result<(), SimError> {
    let already = |joint: usize| original.over_travels.iter().any(|o| o.joint == joint);
    let Some(first) = new.over_travels.iter().filter(|o| !already(o.joint)).min_by_key(|o| o.block) else {
        return Ok(());
    };
    let groups = blocks_of(&new.blocks, &made.runs).into_iter().zip(&made.runs);
    let command = groups.flat_map(|(blocks, run)| blocks.into_iter().flatten().zip(&run.commands));
    let command = command.filter(|(block, _)| block.index <= first.block).last().map(|(_, &command)| command);
    // A rapid before the run goes where its first block begins.
    let command = command.or_else(|| made.runs.first()?.commands.first().copied());
    let joint = &machine.joints[first.joint];
    let (unit, factor) = (joint.kind.unit(), joint.kind.unit_factor());
    let message = format!(
        "the new axes send {} to {:.3} {unit}, {:.3} {unit} past its travel of {:.3} {unit}",
        joint.name,
        first.value * factor,
        ((first.value - first.limit) * factor).abs(),
        first.limit * factor
    );
    let location = command.and_then(|c| made.commands.get(c)).map(|c| c.location.clone());
    // All of the program, so that what is changed is enough.
    let past = |o: &motion_only::OverTravel| {
        (o.joint == first.joint && o.limit == first.limit).then(|| (o.value - o.limit).abs())
    };
    let most = new.over_travels.iter().filter_map(past).fold(0.0, f64::max) * factor;
    let help = format!(
        "over the whole program {} lacks {most:.3} {unit} there: turn the axes less (a larger clearance_deg, a \
         smaller lean_max_deg or turn_max_deg), mount the part that much farther from that end, or use a machine with \
         that much more travel",
        joint.name
    );
    Err(SimError::Control(Box::new(ControlError { code: "reschedule-range", message, location, help: Some(help) })))
}

impl Rescheduling<'_> {
    /// The new program in a language, with how far it is from the best schedule. In the language of the 840D
    /// its text is the one that a run of the entry makes and keeps.
    ///
    /// # Errors
    /// As [`rescheduled`], what keeps machine, tools and part from being read, or what keeps the control from
    /// running the new program: travel of a linear joint, for one.
    pub fn remade(&self, scene: &Scene, dialect: Dialect) -> Result<Remade, SimError> {
        let tools = ToolLibrary::read(&scene.resolve(&scene.file.tools))?;
        let mut machine = Machine::read(&scene.resolve(self.entry.machine.as_ref().unwrap_or(&scene.file.machine)))?;
        let changed_limits = limit_joints(scene, &mut machine)?;
        let part = Prepared::part_on_table(scene, Some(self.entry))?;
        let path = scene.resolve(self.source.file.as_deref().unwrap_or(Path::new("")));
        let (settings, _) = Prepared::running_settings(scene, Some(self.entry), &tools, &machine, &path, false)?;
        let made = rescheduled(scene, &self.file, Original::File(&path), &settings, &machine, &tools, &part)?;
        let run = text(&made.commands, Dialect::Siemens840d, &settings)?;
        let motion_of = |nc: &Settings, source: Source| -> Result<motion_only::Motion, SimError> {
            MotionCase::planned(scene, &machine, &tools, nc, source)?.run()
        };
        let name = format!("{}.mpf", self.entry.name);
        let new = motion_of(&settings_of_made(settings.clone()), Source::Text { name, text: run.clone() })?;
        let original = motion_of(&settings, Source::File(path))?;
        refuse_over_travel(&machine, &new, &original, &made)?;
        let pairs = blocks_of(&new.blocks, &made.runs).into_iter().zip(blocks_of(&original.blocks, &made.runs));
        let line = |command: usize| made.commands.get(command).map_or(0, |c| c.location.line);
        let certified =
            made.runs.iter().zip(pairs).map(|(run, (new, old))| certify(run, line, new, old, &changed_limits));
        let (mut runs, mut uncertified) = (Vec::new(), Vec::new());
        for certificate in certified {
            match certificate {
                Ok(run) => runs.push(run),
                Err(why) => uncertified.push(why),
            }
        }
        let method = self.file.method();
        let certificate = ScheduleCertificate {
            format: ScheduleCertificate::FORMAT,
            method: method.name().to_owned(),
            source: method.source().to_owned(),
            from: self.source.name.clone(),
            machine: machine.name.clone(),
            changed_limits,
            runs,
        };
        let text = if dialect == Dialect::Siemens840d { run } else { text(&made.commands, dialect, &settings)? };
        let channels = made.runs.iter().flat_map(|run| run.study.channels.clone()).collect();
        let kept = made.runs.iter().find_map(|run| run.study.kept);
        let in_feed = |motion: &motion_only::Motion| motion.blocks.iter().map(|b| b.time[1] - b.time[0]).sum::<f64>();
        let feed_s = [in_feed(&original), in_feed(&new)];
        Ok(Remade { text, certificate, uncertified, channels, feed_s, kept })
    }
}
