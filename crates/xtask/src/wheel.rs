//! `cargo xtask wheel`: the Python package, built and tested as somebody would get it.
//!
//! ```text
//! target/wheel/tools   environment with maturin     ──► target/wheel/dist/proveout-*.whl
//! target/wheel/clean   environment made anew        ◄── that wheel, and what its tests need
//!                      pytest, doctests, mypy --strict, with nothing of the sources on their path
//! ```
//!
//! Needs cargo, and Python 3.11 or newer with `venv` and `pip`. The first run fetches what
//! `python/requirements-test.txt` pins.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

use crate::{
    TaskError, files,
    workspace::{Workspace, cargo},
};

/// What is installed, and at which version.
const REQUIREMENTS: &str = "python/requirements-test.txt";
/// The tool that builds; the rest of the list is for the tests.
const BUILDER: &str = "maturin==";
/// Names of the interpreter, the first that is new enough is taken.
const INTERPRETERS: [&str; 5] = ["python3", "python3.11", "python3.12", "python3.13", "python"];
/// Oldest version that can load the module.
const OLDEST: (u32, u32) = (3, 11);

/// How the wheel is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct WheelOptions {
    /// Optimized in all crates: what is handed out.
    release: bool,
    /// With recordings for Rerun, which take most of the build.
    rerun: bool,
    /// Not tested.
    untested: bool,
}

impl WheelOptions {
    /// From the words of the call.
    pub(crate) fn read(words: &[&str]) -> Result<Self, TaskError> {
        let mut options = Self::default();
        for word in words {
            match *word {
                "--release" => options.release = true,
                "--rerun" => options.rerun = true,
                "--no-test" => options.untested = true,
                other => {
                    return Err(TaskError(format!(
                        "wheel: unknown option {other:?}; options: --release, --rerun, --no-test"
                    )));
                }
            }
        }
        Ok(options)
    }

    fn words(self) -> Vec<&'static str> {
        let words = [("--release", self.release), ("--features=rerun", self.rerun)];
        words.into_iter().filter(|(_, on)| *on).map(|(word, _)| word).collect()
    }
}

/// Builds the wheel, tests it in an environment of its own, and returns a text with its place.
pub(crate) fn run(root: &Path, options: WheelOptions) -> Result<String, TaskError> {
    let place = Workspace::read(root)?.target.join("wheel");
    let interpreter = interpreter()?;
    let required = files::get(&root.join(REQUIREMENTS))?;
    let begin = Instant::now();
    let tools = environment(&interpreter, &place.join("tools"), &[&builder(&required)?])?;
    let dist = place.join("dist");
    // Wheels of earlier runs would be taken for the new one.
    fs::remove_dir_all(&dist).ok();
    let mut build = Command::new(script(&tools, "maturin"));
    build.args(["build", "--locked", "--out"]).arg(&dist).args(options.words()).current_dir(root).env("CARGO", cargo());
    call(&mut build)?;
    let wheel = only_wheel(&dist)?;
    let size = fs::metadata(&wheel).map_or(0.0, |about| about.len() as f64 / f64::from(1 << 20));
    let built = begin.elapsed().as_secs_f64();
    let account = format!("{} ({size:.1} MiB), built in {built:.0} s", wheel.display());
    if options.untested {
        return Ok(account);
    }
    let begin = Instant::now();
    test(root, &place, &interpreter, &required, &wheel)?;
    Ok(format!("{account}; tests, doctests and types in {:.0} s", begin.elapsed().as_secs_f64()))
}

/// Installs the wheel where nothing of the sources is seen, and tests it there.
fn test(root: &Path, place: &Path, interpreter: &Path, required: &str, wheel: &Path) -> Result<(), TaskError> {
    let clean = place.join("clean");
    // Nothing of an earlier wheel is left.
    fs::remove_dir_all(&clean).ok();
    let packages: Vec<&str> = packages(required).filter(|line| !line.starts_with(BUILDER)).collect();
    let clean = environment(interpreter, &clean, &packages)?;
    let mut install = pip(&clean);
    call(install.args(["--no-deps", "--force-reinstall"]).arg(wheel))?;
    let pytest = |words: &[&str]| call(Command::new(script(&clean, "pytest")).args(words).current_dir(root));
    pytest(&["python/tests"])?;
    pytest(&["--doctest-modules", "--pyargs", "proveout"])?;
    let mut mypy = Command::new(script(&clean, "mypy"));
    call(mypy.args(["--strict", "-p", "proveout"]).current_dir(root))?;
    let mut mypy = Command::new(script(&clean, "mypy"));
    call(mypy.args(["--strict", "examples/typed.py"]).current_dir(root))
}

/// Names with versions, without comments.
fn packages(required: &str) -> impl Iterator<Item = &str> {
    required.lines().map(|line| line.split('#').next().unwrap_or_default().trim()).filter(|line| !line.is_empty())
}

fn builder(required: &str) -> Result<String, TaskError> {
    let found = packages(required).find(|line| line.starts_with(BUILDER));
    found.map(str::to_owned).ok_or_else(|| TaskError(format!("{REQUIREMENTS} does not list {BUILDER}")))
}

/// An interpreter that is new enough.
fn interpreter() -> Result<PathBuf, TaskError> {
    let named = std::env::var_os("PROVEOUT_PYTHON").map(PathBuf::from);
    let candidates = named.into_iter().chain(INTERPRETERS.map(PathBuf::from));
    for candidate in candidates {
        let asked = Command::new(&candidate)
            .args(["-c", "import sys; print(sys.version_info[0], sys.version_info[1], sys.executable)"])
            .output();
        let Ok(output) = asked else { continue };
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if let Some(path) = new_enough(text.trim()) {
            return Ok(path);
        }
    }
    let (major, minor) = OLDEST;
    Err(TaskError(format!("no Python {major}.{minor} or newer on the path; PROVEOUT_PYTHON may name one")))
}

/// The executable in `3 11 /usr/bin/python3`, where the version will do.
fn new_enough(text: &str) -> Option<PathBuf> {
    let mut words = text.splitn(3, ' ');
    let mut number = || words.next()?.parse::<u32>().ok();
    let version = (number()?, number()?);
    (version >= OLDEST).then(|| words.next().map(PathBuf::from)).flatten()
}

/// An environment with these packages, made where it is not there.
fn environment(interpreter: &Path, place: &Path, packages: &[&str]) -> Result<PathBuf, TaskError> {
    if !script(place, "python").exists() {
        call(Command::new(interpreter).args(["-m", "venv"]).arg(place))?;
    }
    call(pip(place).args(packages))?;
    Ok(place.to_owned())
}

fn pip(place: &Path) -> Command {
    let mut pip = Command::new(script(place, "python"));
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
    pip
}

/// A program of an environment.
fn script(place: &Path, name: &str) -> PathBuf {
    let folder = if cfg!(windows) { "Scripts" } else { "bin" };
    place.join(folder).join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

fn only_wheel(dist: &Path) -> Result<PathBuf, TaskError> {
    let entries = fs::read_dir(dist).map_err(|e| TaskError(format!("{}: {e}", dist.display())))?;
    let wheels: Vec<PathBuf> =
        entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "whl")).collect();
    match wheels.as_slice() {
        [one] => Ok(one.clone()),
        _ => Err(TaskError(format!("{} contains {} wheels", dist.display(), wheels.len()))),
    }
}

/// Runs a command with its output in view; packages of the user and of the sources are not seen by it.
fn call(command: &mut Command) -> Result<(), TaskError> {
    command.env("PYTHONNOUSERSITE", "1").env_remove("PYTHONPATH").env_remove("PYTHONHOME");
    let shown: Vec<String> = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let shown = shown.join(" ");
    println!("{shown}");
    let status = command.status().map_err(|e| TaskError(format!("cannot start {shown}: {e}")))?;
    if status.success() { Ok(()) } else { Err(TaskError(format!("failed: {shown}"))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = WheelOptions::read(&["--release", "--rerun"]).expect("known");
        assert_eq!(read.words(), ["--release", "--features=rerun"]);
        assert!(WheelOptions::read(&[]).expect("none").words().is_empty());
        assert!(WheelOptions::read(&["--fast"]).expect_err("unknown").0.contains("--fast"));
    }

    #[test]
    fn an_interpreter_must_be_new_enough() {
        assert_eq!(new_enough("3 11 /usr/bin/python3"), Some("/usr/bin/python3".into()));
        assert_eq!(new_enough("3 12 C:\\Program Files\\python.exe"), Some("C:\\Program Files\\python.exe".into()));
        assert_eq!(new_enough("3 10 /usr/bin/python3"), None);
        assert_eq!(new_enough("2 7 /usr/bin/python"), None);
        assert_eq!(new_enough(""), None);
    }

    #[test]
    fn the_list_of_packages_names_the_builder() {
        let required = files::get(&crate::workspace_root().join(REQUIREMENTS)).expect("the list");
        assert!(builder(&required).expect("named").starts_with("maturin==1.16."));
        assert!(packages(&required).all(|line| line.contains("==")), "every version is pinned");
        assert!(packages(&required).any(|line| line.starts_with("pytest==")));
    }
}
