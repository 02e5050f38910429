//! The program; see the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(proveout::call(std::env::args_os()))
}
