use std::{path::Path, time::Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use proveout_sim::{
    finding::Severity,
    observer::{Batch, Observer, ObserverError, Outcome, Setup},
};

/// Wall time between two plain lines, s.
const LINE_EVERY_S: f64 = 10.0;
/// Findings that are told as they come.
const FIRST_FINDINGS: usize = 8;

/// Tells how far the run is: a bar on a terminal, plain lines elsewhere.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Name of the program before each line, where others run beside it.
    name: String,
    terminal: bool,
    main_file: String,
    line: u32,
    findings: usize,
    told: usize,
    last_line: Instant,
}

impl Progress {
    pub(crate) fn new(main_file: &Path) -> Self {
        Self::of(ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()), String::new(), main_file)
    }

    /// Beside others.
    pub(crate) fn beside(all: &MultiProgress, name: &str, main_file: &Path) -> Self {
        Self::of(all.add(ProgressBar::new(0)), format!("{name}: "), main_file)
    }

    fn of(bar: ProgressBar, name: String, main_file: &Path) -> Self {
        let terminal = !bar.is_hidden();
        Self {
            bar,
            name,
            terminal,
            main_file: main_file.display().to_string(),
            line: 0,
            findings: 0,
            told: 0,
            last_line: Instant::now(),
        }
    }
}

impl Observer for Progress {
    fn name(&self) -> &'static str {
        "progress"
    }

    fn begin(&mut self, setup: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        self.bar.set_length(setup.program_lines.into());
        let style = ProgressStyle::with_template("{prefix}{bar:30} line {pos}/{len}  {msg}  {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        self.bar.set_style(style);
        self.bar.set_prefix(self.name.clone());
        let cells = setup.stock.counts();
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        // Bars of programs beside this one stay in their place.
        self.bar.suspend(|| {
            let ([x, y, z], lines, mib_of_stock) = (cells, setup.program_lines, mib(setup.stock.memory_bytes()));
            tell!("{}: {lines} lines; stock of {x} x {y} x {z} cells, {mib_of_stock:.0} MiB", setup.program);
            for patch in setup.patches {
                let ([x, y, z], mib) = (patch.stock().counts(), mib(patch.stock().memory_bytes()));
                tell!("{}patch {}: {x} x {y} x {z} cells, {mib:.0} MiB", self.name, patch.name());
            }
        });
        Ok(())
    }

    fn batch(&mut self, _: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        let last = batch.blocks.iter().rev().find(|b| *b.file == *self.main_file);
        self.line = last.map_or(self.line, |b| b.line);
        self.findings += batch.findings.len();
        for f in batch.findings.iter().filter(|f| f.severity != Severity::Info) {
            self.told += 1;
            if self.told <= FIRST_FINDINGS {
                let line = f.line.map_or_else(String::new, |l| format!("line {l}: "));
                self.bar.suspend(|| {
                    let (name, time) = (&self.name, f.time_s.unwrap_or(batch.time));
                    tell!("{name}finding at {time:.1} s: {line}{} [{}]", f.message, f.code);
                });
            } else if self.told == FIRST_FINDINGS + 1 {
                self.bar.suspend(|| tell!("{}further findings are counted; all are in the report", self.name));
            }
        }
        self.bar.set_position(self.line.into());
        self.bar.set_message(format!("{:.0} s simulated, {} findings", batch.time, self.findings));
        if !self.terminal && self.last_line.elapsed().as_secs_f64() > LINE_EVERY_S {
            self.last_line = Instant::now();
            tell!("{}line {}: {:.0} s simulated, {} findings", self.name, self.line, batch.time, self.findings);
        }
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, _: &Outcome<'_>) -> Result<(), ObserverError> {
        self.bar.finish_and_clear();
        Ok(())
    }
}
