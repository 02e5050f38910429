//! Executes programs of ten million blocks without keeping their commands, and says how fast and in how much
//! memory: `cargo run -p proveout_nc --release --example stream [BLOCKS]`.
//!
//! Loops: the text is a few lines, ten million blocks come out of it. Files: the text has a tenth of the
//! blocks, all written out; what is in use in addition to the text must not grow with it. CPU time is that of
//! this process.

use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use proveout_nc::{Dialect, Op, Program, Settings};

/// Most memory of this process since `reset_peak`, KiB; 0 where the system does not say.
fn peak_kib() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|n| n.parse().ok()).unwrap_or(0)
}

/// The memory in use now is the peak again (proc(5)).
fn reset_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// A loop that makes so many blocks, ten motions a pass; none where the language has no loops.
fn looped(dialect: Dialect, blocks: u64) -> Option<String> {
    let passes = blocks / 10;
    let body = |words: &dyn Fn(u64) -> String| (0..10).map(words).collect::<String>();
    Some(match dialect {
        Dialect::Siemens840d => {
            let body = body(&|i| format!("X{i} Y{}.5\n", i + 1));
            format!("G0 X0 Y0 Z0\nG1 F1000\nFOR R1=1 TO {passes}\n{body}ENDFOR\nM30\n")
        }
        Dialect::Fanuc => {
            let body = body(&|i| format!("X{i}. Y{}.5\n", i + 1));
            format!("G0 X0 Y0 Z0\nG1 F1000.\n#1=0\nWHILE[#1LT{passes}]DO1\n{body}#1=#1+1\nEND1\nM30\n")
        }
        Dialect::LinuxCnc => {
            let body = body(&|i| format!("X{i} Y{}.5\n", i + 1));
            format!("G0 X0 Y0 Z0\nG1 F1000\nO1 repeat [{passes}]\n{body}O1 endrepeat\nM30\n")
        }
        Dialect::Heidenhain => {
            let body = body(&|i| format!("L X+{i} Y+{}.5\n", i + 1));
            // 65 534 repetitions at most: two loops within each other.
            let outer = passes.div_ceil(50_000).max(1);
            let inner = passes / outer;
            format!(
                "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+0 FMAX\nL X+1 F1000\nLBL 1\nLBL 2\n{body}CALL LBL 2 REP {}\nCALL LBL 1 REP {}\nM30\nEND PGM A MM\n",
                inner.saturating_sub(1),
                outer.saturating_sub(1)
            )
        }
        _ => return None,
    })
}

fn linear(dialect: Dialect, blocks: u64) -> String {
    let mut text = String::from(match dialect {
        Dialect::Heidenhain => "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+0 FMAX\nL X+1 F1000\n",
        Dialect::HeidenhainIso => "%A G71 *\nT1 G17 S1000 *\nG0 X+0 Y+0 Z+0 *\nG1 X+1 F1000 *\n",
        Dialect::Apt => "UNITS/MM\nFEDRAT/1000,MMPM\n",
        _ => "G0 X0 Y0 Z0\nG1 F1000.\n",
    });
    for i in 0..blocks {
        let (x, y, z) = (i % 977, i % 1009, i % 83);
        let line = match dialect {
            Dialect::Heidenhain => format!("{i} L X+{x}.{:03} Y-{y}.{:03} Z+0.{z:03}\n", y % 1000, x % 1000),
            Dialect::HeidenhainIso => format!("N{i} X+{x}.{:03} Y-{y}.{:03} Z+0.{z:03} *\n", y % 1000, x % 1000),
            Dialect::Apt => format!("GOTO/{x}.{:03},-{y}.{:03},0.{z:03}\n", y % 1000, x % 1000),
            _ => format!("N{i} X{x}.{:03} Y-{y}.{:03} Z.{z:03}\n", y % 1000, x % 1000),
        };
        text.push_str(&line);
    }
    text
}

/// CPU seconds of this process.
fn cpu_seconds() -> f64 {
    // Fields 14 and 15 of the line, counted in hundredths of a second, after the name in brackets.
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> =
        text.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2).flat_map(str::parse).collect();
    fields.iter().sum::<f64>() / 100.0
}

fn main() -> ExitCode {
    let blocks: u64 = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(10_000_000);
    let mut out = std::io::stdout();
    let dialects = [
        Dialect::Siemens840d,
        Dialect::Fanuc,
        Dialect::LinuxCnc,
        Dialect::Heidenhain,
        Dialect::HeidenhainIso,
        Dialect::Apt,
    ];
    for (kind, count) in [("loop", blocks), ("file", blocks / 10)] {
        for dialect in dialects {
            let text = if kind == "loop" { looped(dialect, count) } else { Some(linear(dialect, count)) };
            let Some(text) = text else { continue };
            let settings = Settings { dialect, ..Settings::default() };
            let bytes = text.len();
            reset_peak();
            let (before, cpu, wall) = (peak_kib(), cpu_seconds(), Instant::now());
            let program = match Program::from_text("stream", text, &settings) {
                Ok(program) => program,
                Err(error) => {
                    let _ = writeln!(out, "{} {kind}: {error}", dialect.name());
                    return ExitCode::FAILURE;
                }
            };
            let mut motions = 0u64;
            for command in program {
                match command {
                    Ok(command) => motions += u64::from(matches!(command.op, Op::Linear(_))),
                    Err(error) => {
                        let _ = writeln!(out, "{} {kind}: {error}", dialect.name());
                        return ExitCode::FAILURE;
                    }
                }
            }
            let (cpu, wall) = (cpu_seconds() - cpu, wall.elapsed().as_secs_f64());
            let extra = peak_kib().saturating_sub(before);
            let _ = writeln!(
                out,
                "{:14} {kind}: {motions:>9} motions, text {:>6.1} MiB, beside it {extra:>6} KiB; {:.2} million blocks a CPU second ({cpu:.1} s CPU, {wall:.1} s)",
                dialect.name(),
                bytes as f64 / f64::from(1 << 20),
                motions as f64 / cpu.max(0.01) / 1e6,
            );
        }
    }
    ExitCode::SUCCESS
}
