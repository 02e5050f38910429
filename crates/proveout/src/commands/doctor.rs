//! What this machine has of what Proveout uses: one line each, with the remedy.

use std::{
    fs,
    path::PathBuf,
    process::{Command, Stdio},
};

use proveout_sim::{
    MEMORY,
    step::{Helper, VARIABLE},
};
use serde::Serialize;
use serde_json::json;

use crate::{args::DoctorArgs, failure::Failure};

/// Version of the viewer that reads the recordings.
const VIEWER: &str = "0.36";
const MIB: u64 = 1 << 20;

/// What was found of one thing.
#[derive(Debug, Serialize)]
struct Line {
    name: &'static str,
    state: State,
    found: String,
    /// What to do; empty where nothing is to be done.
    remedy: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum State {
    /// It is there.
    Ok,
    /// It is not there: what needs it is refused by name, everything else works.
    Missing,
    /// It is there, and cannot be used as it is.
    Wrong,
}

impl State {
    fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Missing => "missing",
            Self::Wrong => "wrong",
        }
    }
}

/// Prints the lines; whether nothing is wrong.
pub(crate) fn doctor(args: &DoctorArgs) -> Result<bool, Failure> {
    let lines = [program(), recordings(), threads(), memory(), viewer(), step(), browser()];
    if args.json {
        say!("{}", serde_json::to_string_pretty(&json!({ "doctor": lines })).map_err(Failure::new)?);
    } else {
        for Line { name, state, found, remedy } in &lines {
            let remedy = if remedy.is_empty() { String::new() } else { format!("; {remedy}") };
            say!("{:<8} {name}: {found}{remedy}", state.word());
        }
    }
    Ok(lines.iter().all(|line| line.state != State::Wrong))
}

fn line(name: &'static str, state: State, found: impl Into<String>, remedy: impl Into<String>) -> Line {
    Line { name, state, found: found.into(), remedy: remedy.into() }
}

fn program() -> Line {
    let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
    line("program", State::Ok, format!("proveout {} on {system}", env!("CARGO_PKG_VERSION")), "")
}

fn recordings() -> Line {
    match (cfg!(feature = "rerun"), cfg!(feature = "rapier")) {
        (true, true) => line("features", State::Ok, "recordings and Rapier", ""),
        (rerun, _) => {
            let lacks = if rerun { "Rapier" } else { "recordings for the viewer" };
            line("features", State::Missing, format!("built without {lacks}"), "build it without --no-default-features")
        }
    }
}

fn threads() -> Line {
    match std::thread::available_parallelism() {
        Ok(count) => line("threads", State::Ok, format!("{count}"), ""),
        Err(e) => line("threads", State::Wrong, format!("the number of processors is not known: {e}"), "use --threads"),
    }
}

fn memory() -> Line {
    let text = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let of = |key: &str| -> Option<u64> {
        let value = text.lines().find_map(|l| l.strip_prefix(key))?;
        value.split_whitespace().next()?.parse::<u64>().ok().map(|kib| kib / 1024)
    };
    let most = MEMORY / MIB;
    let Some((free, all)) = of("MemAvailable:").zip(of("MemTotal:")) else {
        return line("memory", State::Ok, format!("not shown by the system; a run takes {most} MiB at most"), "");
    };
    let found = format!("{free} MiB free of {all}; a run takes {most} MiB at most, and announces what it will take");
    let remedy = if free < most { "use a larger resolution_mm where a run announces more than is free" } else { "" };
    line("memory", State::Ok, found, remedy)
}

/// First line that a program prints about itself.
fn version(program: &str) -> Option<String> {
    let mut command = Command::new(program);
    let output = command.arg("--version").stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or_default().trim().to_owned();
    output.status.success().then_some(text)
}

fn viewer() -> Line {
    let install = "pip install rerun-sdk==0.36.3";
    match version("rerun") {
        None => line("viewer", State::Missing, "rerun is not on the path", format!("to open recordings: {install}")),
        Some(found) if found.contains(VIEWER) => line("viewer", State::Ok, found, ""),
        Some(found) => {
            let other = format!("{found}: recordings are written for {VIEWER}");
            line("viewer", State::Wrong, other, format!("install that version: {install}"))
        }
    }
}

fn step() -> Line {
    let install = "pip install \"proveout[step]\"";
    match Helper::find() {
        Err(wrong) => line("step", State::Wrong, wrong, format!("correct {VARIABLE}, or unset it")),
        Ok(None) => {
            let found = "proveout-step is not on the path: STEP files are refused";
            line("step", State::Missing, found, install)
        }
        Ok(Some(helper)) => match helper.version() {
            Ok(words) => line("step", State::Ok, format!("{}, {words}", helper.program.display()), ""),
            Err(why) => line("step", State::Wrong, format!("{}: {why}", helper.program.display()), install),
        },
    }
}

/// Pages are whole files with their own styles, pictures and fonts.
fn browser() -> Line {
    let names = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
    let named = std::env::var("PROVEOUT_CHROMIUM").ok();
    let folders: Vec<PathBuf> =
        std::env::var_os("PATH").map(|p| std::env::split_paths(&p).collect()).unwrap_or_default();
    let found = named.map(PathBuf::from).filter(|file| file.is_file()).or_else(|| {
        folders.iter().flat_map(|folder| names.iter().map(|name| folder.join(name))).find(|file| file.is_file())
    });
    match found {
        Some(file) => line("chromium", State::Ok, format!("{}; only tests of pages use it", file.display()), ""),
        None => {
            let found = "not on the path: only tests of pages use it, pages open in any browser";
            line("chromium", State::Missing, found, "")
        }
    }
}
