//! Which programs of a folder are read, and why the others are refused, as a table by count: `cargo run -p
//! proveout_nc --example trial -- [--control NAME] [--feed MM_MIN] [--tool-radius MM] [--home] [--files]
//! FILE...`.
//!
//! `--files` lists every file with its first fault; `--feed` is the policy for motions before the first F,
//! `--tool-radius` what the milling cycles of a TNC and an 840D need of the tool; with `--home` the axes
//! are at zero before the first block, as the home position of a machine says. Only the first fault of a
//! program counts.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;

use proveout_nc::{Control, Diagnostic, Op, Program, Settings};

fn main() -> ExitCode {
    let mut out = BufWriter::new(io::stdout().lock());
    match table(&mut out).and_then(|code| out.flush().map(|()| code)) {
        Ok(code) => code,
        Err(_) => ExitCode::from(2),
    }
}

/// Reads the files of the call and writes the table.
fn table(out: &mut impl Write) -> io::Result<ExitCode> {
    let mut settings = Settings::default();
    let mut files = Vec::new();
    let mut each = false;
    let mut radius = None;
    let mut home = false;
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--files" => each = true,
            "--home" => home = true,
            "--feed" => settings.default_feed_mm_per_min = words.next().and_then(|value| value.parse().ok()),
            "--tool-radius" => radius = words.next().and_then(|value| value.parse().ok()),
            "--control" => {
                let name = words.next().unwrap_or_default();
                match Control::find(&name, None) {
                    Ok(control) => settings = Settings::of_control(control),
                    Err(error) => {
                        writeln!(out, "{error}")?;
                        return Ok(ExitCode::from(2));
                    }
                }
            }
            _ => files.push(word),
        }
    }
    if home {
        (0..6).for_each(|axis| settings.start_position.put(axis, 0.0));
    }
    if let Some(radius) = radius {
        for name in ["Q108", "$P_TOOLR"] {
            settings.variables.insert(name.to_owned(), radius);
        }
    }
    let mut reasons: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut read = 0_usize;
    for file in &files {
        match motions(Path::new(file), &settings) {
            Ok((motions, assumed)) => {
                read += 1;
                if each {
                    writeln!(out, "read     {file}: {motions} motions, {assumed} assumed")?;
                }
            }
            Err(fault) => {
                let first = fault.message.split('`').step_by(2).collect::<Vec<_>>().join("`");
                let reason = format!("{}: {}", fault.code, first.trim());
                let place = format!("{file}:{}: {}", fault.line, fault.message);
                if each {
                    writeln!(out, "refused  {place}")?;
                }
                reasons.entry(reason).or_default().push(place);
            }
        }
    }
    writeln!(out, "{read} of {} read", files.len())?;
    let mut by_count: Vec<_> = reasons.into_iter().collect();
    by_count.sort_by_key(|(_, places)| std::cmp::Reverse(places.len()));
    for (reason, places) in by_count {
        writeln!(out, "{:>4}  {reason}\n      {}", places.len(), places[0])?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Motions and assumptions of a program that is read to its end; else its first fault.
fn motions(path: &Path, settings: &Settings) -> Result<(usize, usize), Box<Diagnostic>> {
    let (mut motions, mut assumed) = (0, 0);
    for command in Program::open(path, settings).map_err(|faults| Box::new(faults.0[0].clone()))? {
        match command.map_err(Box::new)?.op {
            Op::Rapid(_) | Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Thread(_) | Op::Probe(_) => motions += 1,
            Op::Note(note) if note.assumption().is_some() => assumed += 1,
            _ => {}
        }
    }
    Ok((motions, assumed))
}
