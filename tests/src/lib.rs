//! Fixtures of the whole prove-outs: where scenes and real programs lie, and a run without any recorder.

use std::path::{Path, PathBuf};

use proveout_sim::{Choice, Prepared, SimError, run::RunResult};

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// A scene by its name.
pub fn scene(name: &str) -> PathBuf {
    root().join("scenes").join(name)
}

/// A real program that is published elsewhere and lies next to some checkouts; none where it does not.
pub fn published(path: &str) -> Option<PathBuf> {
    let root = root();
    let places = root.ancestors().skip(1).map(|up| up.join("shared/cases").join(path));
    places.into_iter().find(|p| p.is_file())
}

/// Says past the capture of the test harness that a test passes without looking: `cargo xtask ci` has these
/// lines in its summary.
pub fn left_out(what: &str) {
    use std::io::Write as _;
    writeln!(std::io::stdout(), "\nLEFT OUT: {what}").ok();
}

/// Runs a scene with a number of threads; nothing is written.
///
/// # Errors
/// What keeps the run from being made.
pub fn prove(scene: &Path, choice: &Choice, threads: usize) -> Result<RunResult, SimError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| SimError::Folder(std::io::Error::other(e)))?;
    pool.install(|| proveout_sim::run::run(Prepared::read(scene, choice)?, &mut [], Path::new(".")))
}
