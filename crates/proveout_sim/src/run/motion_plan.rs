//! The control at the start of a program, and its motion in stretches.

use std::sync::Arc;

use proveout_controller::{Chunk, Controller, RunError};
use proveout_nc::{Command, Diagnostic};

use crate::prepare::{error::SimError, prepared::Prepared, program_survey::known_offset};

/// Simulated time of one stretch, s.
pub(crate) const STRETCH_S: f64 = 2.0;

/// The control at the begin of the program.
pub(crate) fn controller(
    prepared: &Prepared,
) -> Result<Controller<'_, impl Iterator<Item = Result<Command, Diagnostic>>>, SimError> {
    let scene_path = prepared.scene.path.display().to_string();
    let program = prepared.program()?;
    let settings = prepared.control_settings(program.dialect());
    let commands = program.map(move |command| {
        let mut command = command.and_then(|c| known_offset(c, &prepared.nc_settings, &scene_path))?;
        if let Some(name) = prepared.shown.get(&*command.location.file) {
            command.location.file = Arc::clone(name);
        }
        Ok(command)
    });
    Ok(Controller::new(commands, &prepared.machine, &prepared.tools.tools, settings)?)
}

/// A fault of the control at the file that was opened, so that its line can be shown.
pub(crate) fn opened(prepared: &Prepared, mut fault: RunError<Diagnostic>) -> RunError<Diagnostic> {
    if let RunError::Control(control) = &mut fault
        && let Some(location) = &mut control.location
        && let Some((name, _)) = prepared.shown.iter().find(|(_, shown)| **shown == location.file)
    {
        location.file = Arc::from(name.as_str());
    }
    fault
}

/// Splits a chunk into stretches of at most this many simulated seconds, at borders of pieces.
pub(crate) fn stretches(chunk: Chunk, seconds: f64) -> impl Iterator<Item = Chunk> {
    let start = [
        chunk.pieces.first().map(|p| p.time[0]),
        chunk.samples.first().map(|s| s.time),
        chunk.events.first().map(|e| e.time()),
        chunk.blocks.first().map(|b| b.end_time),
    ];
    let mut until = start.into_iter().flatten().fold(f64::INFINITY, f64::min);
    // Handed over, not copied: a chunk may hold a million samples.
    let mut pieces = chunk.pieces.into_iter().peekable();
    let mut samples = chunk.samples.into_iter().peekable();
    let mut events = chunk.events.into_iter().peekable();
    let mut blocks = chunk.blocks.into_iter().peekable();
    std::iter::from_fn(move || {
        loop {
            if pieces.peek().is_none() && samples.peek().is_none() && events.peek().is_none() && blocks.peek().is_none()
            {
                return None;
            }
            until += seconds;
            let stretch = Chunk {
                pieces: std::iter::from_fn(|| pieces.next_if(|p| p.time[0] < until)).collect(),
                samples: std::iter::from_fn(|| samples.next_if(|s| s.time < until)).collect(),
                events: std::iter::from_fn(|| events.next_if(|e| e.time() < until)).collect(),
                blocks: std::iter::from_fn(|| blocks.next_if(|b| b.end_time < until)).collect(),
            };
            let empty = stretch.pieces.is_empty()
                && stretch.samples.is_empty()
                && stretch.events.is_empty()
                && stretch.blocks.is_empty();
            if !empty {
                return Some(stretch);
            }
        }
    })
}
