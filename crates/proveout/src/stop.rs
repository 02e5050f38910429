//! Ctrl-C and TERM end a run at once, and say how it goes on.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

use crate::failure::Failure;

/// Exit code of a run that was stopped.
const STOPPED: i32 = 130;
/// Other threads may be writing into the folder that goes: so often it is tried, so long apart.
const TRIES: u32 = 5;
const APART: Duration = Duration::from_millis(50);

/// How far a run is.
#[derive(Debug)]
enum Phase {
    /// Nothing was written.
    Reading,
    /// This folder is being written, with a journal next to it.
    Running(PathBuf),
    /// The complete folder is moved to its place: that is not broken off.
    Ending,
}

/// Waits for Ctrl-C and TERM.
pub(crate) struct Stop(Arc<Mutex<Phase>>);

impl Stop {
    /// Begins to wait.
    pub(crate) fn watch() -> Result<Self, Failure> {
        let phase = Arc::new(Mutex::new(Phase::Reading));
        wait(Arc::clone(&phase)).map_err(|e| Failure::new(format!("cannot listen for Ctrl-C: {e}")))?;
        Ok(Self(phase))
    }

    /// From now on there is something to go on with.
    pub(crate) fn running(&self, partial: &Path) {
        *lock(&self.0) = Phase::Running(partial.to_owned());
    }

    /// From now on the run is complete.
    pub(crate) fn ending(&self) {
        *lock(&self.0) = Phase::Ending;
    }
}

/// On a thread of its own: the others may be deep in their work.
#[cfg(unix)]
fn wait(phase: Arc<Mutex<Phase>>) -> std::io::Result<()> {
    use signal_hook::{
        consts::{SIGINT, SIGTERM},
        iterator::Signals,
    };
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    thread::Builder::new().name("stop".to_owned()).spawn(move || {
        for _ in signals.forever() {
            stop(&lock(&phase));
        }
    })?;
    Ok(())
}

/// Elsewhere the system ends the process; its journal is left all the same.
#[cfg(not(unix))]
fn wait(_: Arc<Mutex<Phase>>) -> std::io::Result<()> {
    Ok(())
}

fn lock(phase: &Mutex<Phase>) -> MutexGuard<'_, Phase> {
    phase.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(unix)]
fn stop(phase: &Phase) {
    match phase {
        Phase::Ending => return,
        Phase::Reading => tell!("\nstopped before the first cut: there is nothing to resume"),
        Phase::Running(partial) => {
            if crate::words().iter().any(|word| word == "--no-journal") {
                tell!("\nstopped; without a journal there is nothing to resume");
            } else {
                tell!("\nstopped; to resume: {}", call());
            }
            for _ in 0..TRIES {
                if std::fs::remove_dir_all(partial).is_ok() {
                    break;
                }
                thread::sleep(APART);
            }
        }
    }
    std::process::exit(STOPPED);
}

/// The call that goes on, as it is typed.
#[cfg(unix)]
fn call() -> String {
    let quoted = |word: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let mut words: Vec<String> =
        crate::words().iter().skip(1).map(|word| quoted(word.to_string_lossy().into_owned())).collect();
    if !words.iter().any(|word| word == "--resume") {
        words.push("--resume".to_owned());
    }
    format!("proveout {}", words.join(" "))
}
