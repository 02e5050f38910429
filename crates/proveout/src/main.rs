//! The program; see the library of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(proveout::call(std::env::args_os()))
}
