//! The command line of Proveout: arguments, progress, exit codes; no algorithm of its own.
//!
//! A library, so that the program and the Python package call the same thing: [`call`] does what a command
//! line says, [`front`] is what other front ends need of it.
//!
//! | file or folder | holds |
//! |---|---|
//! | `args/` | the command line: options of each command, by subject |
//! | `commands/` | what each command does, one file a command |
//! | `front.rs` | what other front ends call |
//! | `main.rs` | the program |
//! | `progress.rs`, `stop.rs` | progress of a run; Ctrl-C and TERM |
//! | `terminal.rs`, `failure.rs` | text for a terminal; errors with place and remedy |
//! | `host.rs` | memory and time that the host reports |
//! | `every_option.rs` | a test: each option is in a typed command line |

/// A line on standard output, without what would steer a terminal; a reader that went away (`| head`) is no
/// error.
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        writeln!(std::io::stdout(), "{}", crate::terminal::plain(&format!($($words)*))).ok();
    }};
}

/// A line on standard error, in the same way.
macro_rules! tell {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        writeln!(std::io::stderr(), "{}", crate::terminal::plain(&format!($($words)*))).ok();
    }};
}

mod args;
mod commands;
#[cfg(test)]
mod every_option;
mod failure;
pub mod front;
mod host;
mod progress;
mod stop;
mod terminal;

use std::{ffi::OsString, sync::OnceLock};

use clap::Parser;
use proveout_sim::verdict::State;

use crate::args::{Cli, Command, with_new_name};

/// The command did its work and the verdict, if there is one, is pass.
const PASS: u8 = 0;
/// The verdict is fail.
const FAIL: u8 = 1;
/// The input or the call is wrong.
const WRONG: u8 = 2;
/// Nothing failed, but something was not checked.
const UNCHECKED: u8 = 3;

/// Exit code of a verdict.
fn code(verdict: State) -> u8 {
    match verdict {
        State::Pass => PASS,
        State::Fail => FAIL,
        State::Unchecked | State::NotAsked => UNCHECKED,
    }
}

/// The words of [`call`].
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// The arguments of the call: under an interpreter, those of the process differ from the command line.
fn words() -> Vec<OsString> {
    WORDS.get().cloned().unwrap_or_else(|| std::env::args_os().collect())
}

/// Does what a call says, its first word being the name of the program; the exit code.
///
/// A call for help, or one that is wrong, ends the process, as command lines do.
pub fn call(words: impl IntoIterator<Item = OsString>) -> u8 {
    let words: Vec<OsString> = words.into_iter().collect();
    WORDS.set(words.clone()).ok();
    let cli = Cli::try_parse_from(words).unwrap_or_else(|error| with_new_name(error).exit());
    let result = match cli.command {
        Command::New(args) => commands::new::new(&args).map(|()| PASS),
        Command::Tools(args) => commands::tools::tools(&args).map(|()| PASS),
        Command::Machine(args) => commands::machine::machine(&args).map(|()| PASS),
        Command::Run(args) => commands::run::run(&args).map(code),
        Command::Job(args) => commands::job::job(&args).map(code),
        Command::Sweep { command } => commands::sweep::sweep(&command).map(code),
        Command::Compare(args) => commands::compare::compare(&args).map(code),
        Command::Calibrate { command } => commands::calibrate::calibration(&command).map(|()| PASS),
        Command::Verify(args) => commands::verify::verify(&args).map(code),
        Command::Sign(args) => commands::verify::sign(&args).map(|()| PASS),
        Command::Check(args) => commands::check::check(&args).map(|clean| if clean { PASS } else { WRONG }),
        Command::Migrate(args) => commands::migrate::migrate_files(&args),
        Command::Nc(args) => commands::nc::nc(&args).map(|()| PASS),
        Command::Kinematics(args) => commands::kinematics::kinematics(&args).map(|()| PASS),
        Command::Blade(args) => commands::blade::blade(&args).map(|()| PASS),
        Command::Plan(args) => commands::plan::plan(&args).map(|()| PASS),
        Command::Reschedule(args) => commands::plan::reschedule(&args).map(|()| PASS),
        Command::Feeds(args) => commands::feeds::feeds(&args).map(|()| PASS),
        Command::Measure(args) => {
            commands::measure::measure(&args).map(|checked| if checked { PASS } else { UNCHECKED })
        }
        Command::Diff(args) => commands::diff::diff(&args.run_a, &args.run_b).map(|()| PASS),
        Command::Doctor(args) => commands::doctor::doctor(&args).map(|well| if well { PASS } else { WRONG }),
        Command::Completions(args) => commands::install::completions(&args).map(|()| PASS),
        Command::Manual(args) => commands::install::manual(&args).map(|()| PASS),
        Command::View(args) => commands::view::view(&args.run).map(|()| PASS),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            tell!("{}", failure.to_string().trim_end());
            WRONG
        }
    }
}
