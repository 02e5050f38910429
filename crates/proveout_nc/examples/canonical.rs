//! Prints the canonical commands of a program as JSON lines:
//! `cargo run -p proveout_nc --example canonical -- FILE`.

use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

use proveout_nc::{JsonWriter, Program, Settings};

fn main() -> ExitCode {
    let mut out = BufWriter::new(io::stdout().lock());
    let mut writer = JsonWriter::new();
    let Some(path) = std::env::args_os().nth(1) else {
        return ExitCode::from(2);
    };
    let result = Program::open(path, &Settings::default()).map_err(|e| e.to_string()).and_then(|mut program| {
        program.try_for_each(|command| {
            let command = command.map_err(|e| format!("{}: {e}", e.code))?;
            writer.write(&command, &mut out).map_err(|e| e.to_string())
        })
    });
    let failed = result.is_err();
    if let Err(message) = result {
        let _ = writeln!(out, "{message}");
    }
    if out.flush().is_err() || failed { ExitCode::from(2) } else { ExitCode::SUCCESS }
}
