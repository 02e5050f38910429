//! Long tasks in a thread of their own, apart from the interpreter.
//!
//! ```text
//! thread of the caller   look for signals, tell progress, sleep 0.1 s ... ─────┐
//! thread of the work     reads, runs, writes; asks at every batch whether it  ─┴─► result, or the exception
//!                        should end                                                that broke it off
//! ```
//!
//! The interpreter is free for other threads except while progress is reported. A task that is broken off
//! is waited for: what it was writing is removed before the exception goes on.

use std::{
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use proveout::front::CommandError;
use pyo3::prelude::*;

use crate::errors::{internal, raised};

/// Time between two looks for signals.
const TICK: Duration = Duration::from_millis(100);

/// How far some work is, and whether it should end.
#[derive(Debug, Default)]
pub(crate) struct WorkState {
    ends: AtomicBool,
    told: Mutex<ProgressStep>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct ProgressStep {
    /// From 0 to 1.
    share: f64,
    text: String,
}

/// The work found that it should end; unwinds without the words of a panic.
struct CancelledWork;

impl WorkState {
    /// Whether the caller wants no more.
    pub(crate) fn ends(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }

    /// Breaks off the task at once, if it should end: for places that cannot return an error.
    pub(crate) fn leave_if_it_ends(&self) {
        if self.ends() {
            resume_unwind(Box::new(CancelledWork));
        }
    }

    /// The reported share never falls: two programs of a comparison run at the same time.
    pub(crate) fn tell(&self, share: f64, text: String) {
        let mut told = lock(&self.told);
        *told = ProgressStep { share: told.share.max(share), text };
    }

    fn told(&self) -> ProgressStep {
        lock(&self.told).clone()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Set when the work is done, however it ends.
#[derive(Default)]
struct CompletionFlag(Mutex<bool>, Condvar);

impl CompletionFlag {
    fn set(&self) {
        *lock(&self.0) = true;
        self.1.notify_all();
    }

    /// Waits for a tick at most; whether it is done.
    fn wait(&self) -> bool {
        let guard = lock(&self.0);
        *self.1.wait_timeout_while(guard, TICK, |done| !*done).unwrap_or_else(PoisonError::into_inner).0
    }
}

/// Does some work on a thread of its own while the interpreter is free; `progress` is called with a share
/// from 0 to 1 and a text.
///
/// # Errors
/// The exception of the fault of the work, of a signal, of `progress`; an internal error in the place of a
/// panic.
pub(crate) fn beside<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Arc<WorkState>) -> Result<T, CommandError> + Send,
) -> PyResult<T> {
    let (shared, done) = (Arc::new(WorkState::default()), CompletionFlag::default());
    let mut broken = None;
    let result = thread::scope(|scope| {
        let handle = thread::Builder::new().name("proveout".to_owned()).spawn_scoped(scope, || {
            let result = catch_unwind(AssertUnwindSafe(|| work(&shared)));
            done.set();
            result
        })?;
        let mut last = ProgressStep::default();
        while !py.detach(|| done.wait()) {
            if broken.is_some() {
                continue;
            }
            let told = shared.told();
            let tell = || match progress {
                Some(progress) if told != last => progress.call1((told.share, told.text.as_str())).map(|_| ()),
                _ => Ok(()),
            };
            if let Err(error) = py.check_signals().and_then(|()| tell()) {
                shared.ends.store(true, Ordering::Relaxed);
                broken = Some(error);
            }
            last = told;
        }
        Ok::<_, PyErr>(py.detach(|| handle.join()))
    })?;
    if let Some(error) = broken {
        return Err(error);
    }
    match result {
        Ok(Ok(Ok(value))) => {
            // The last word, where the work was done before a tick.
            progress.map_or(Ok(()), |p| p.call1((1.0, shared.told().text)).map(|_| ()))?;
            Ok(value)
        }
        Ok(Ok(Err(fault))) => Err(raised(py, &fault)),
        Ok(Err(panic)) | Err(panic) => Err(internal(py, &*panic)),
    }
}
