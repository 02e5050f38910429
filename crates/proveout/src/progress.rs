use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    time::Instant,
};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use proveout_sim::{
    finding::Severity,
    observer::{Batch, Observer, ObserverError, Outcome, Setup},
};

/// Wall time between two plain lines, s.
const LINE_EVERY_S: f64 = 10.0;
/// Findings that are printed as they come.
const FIRST_FINDINGS: usize = 8;

/// Shows the progress of the run: a bar on a terminal, plain lines elsewhere.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Name of the program before its bar, where others run at the same time.
    name: String,
    /// Whose turn it is to print, and the number of this program.
    turns: Option<(Arc<Mutex<Turns>>, usize)>,
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

    /// One of several programs, which are added in the order of their output.
    pub(crate) fn beside(all: &ParallelBars, name: &str, main_file: &Path) -> Self {
        let mut own = Self::of(all.bars.add(ProgressBar::new(0)), format!("{name}: "), main_file);
        let number = held(&all.turns).enter();
        own.turns = Some((Arc::clone(&all.turns), number));
        own
    }

    fn of(bar: ProgressBar, name: String, main_file: &Path) -> Self {
        let terminal = !bar.is_hidden();
        Self {
            bar,
            name,
            turns: None,
            terminal,
            main_file: main_file.display().to_string(),
            line: 0,
            findings: 0,
            told: 0,
            last_line: Instant::now(),
        }
    }
}

impl Progress {
    /// Prints a line, in its turn.
    fn say(&self, line: String) {
        let Some((turns, number)) = &self.turns else { return self.tell_all(&[line]) };
        // The lock is kept until the lines are printed.
        let mut turns = held(turns);
        let lines = turns.say(*number, line);
        self.tell_all(&lines);
    }

    fn tell_all(&self, lines: &[String]) {
        if !lines.is_empty() {
            self.bar.suspend(|| lines.iter().for_each(|line| tell!("{line}")));
        }
    }
}

impl Drop for Progress {
    /// The next one has its turn, however the run has ended.
    fn drop(&mut self) {
        if let Some((turns, number)) = &self.turns {
            let mut turns = held(turns);
            let lines = turns.leave(*number);
            self.tell_all(&lines);
        }
    }
}

fn held(turns: &Mutex<Turns>) -> MutexGuard<'_, Turns> {
    turns.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bars and lines of programs that run at the same time.
pub(crate) struct ParallelBars {
    bars: MultiProgress,
    turns: Arc<Mutex<Turns>>,
}

impl ParallelBars {
    /// Of none yet.
    pub(crate) fn new() -> Self {
        let bars = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
        Self { bars, turns: Arc::default() }
    }
}

/// Lines of programs in the order of the programs, at whatever speed they run: the first that has not ended
/// prints at once; the lines of the others wait.
#[derive(Debug, Default)]
struct Turns {
    entered: usize,
    now: usize,
    waiting: BTreeMap<usize, Vec<String>>,
    ended: BTreeSet<usize>,
}

impl Turns {
    /// Number of the next one.
    fn enter(&mut self) -> usize {
        self.entered += 1;
        self.entered - 1
    }

    /// Lines to print when this program has a line.
    fn say(&mut self, number: usize, line: String) -> Vec<String> {
        if number == self.now {
            return vec![line];
        }
        self.waiting.entry(number).or_default().push(line);
        Vec::new()
    }

    /// Lines to print when this program has ended.
    fn leave(&mut self, number: usize) -> Vec<String> {
        self.ended.insert(number);
        let mut lines = Vec::new();
        while self.ended.remove(&self.now) {
            self.now += 1;
            lines.extend(self.waiting.remove(&self.now).unwrap_or_default());
        }
        lines
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
        let ([x, y, z], lines, of_stock) = (cells, setup.program_lines, mib(setup.stock.memory_bytes()));
        self.say(format!("{}: {lines} lines; stock of {x} x {y} x {z} cells, {of_stock:.0} MiB", setup.program));
        for patch in setup.patches {
            let ([x, y, z], mib) = (patch.stock().counts(), mib(patch.stock().memory_bytes()));
            self.say(format!("patch {}: {x} x {y} x {z} cells, {mib:.0} MiB", patch.name()));
        }
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
                let time = f.time_s.unwrap_or(batch.time);
                self.say(format!("finding at {time:.1} s: {line}{} [{}]", f.message, f.code));
            } else if self.told == FIRST_FINDINGS + 1 {
                self.say("further findings are counted; all are in the report".into());
            }
        }
        self.bar.set_position(self.line.into());
        self.bar.set_message(format!("{:.0} s simulated, {} findings", batch.time, self.findings));
        if !self.terminal && self.last_line.elapsed().as_secs_f64() > LINE_EVERY_S {
            self.last_line = Instant::now();
            self.say(format!("line {}: {:.0} s simulated, {} findings", self.line, batch.time, self.findings));
        }
        Ok(())
    }

    fn end(&mut self, _: &Setup<'_>, _: &Outcome<'_>) -> Result<(), ObserverError> {
        self.bar.finish_and_clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Turns;

    #[test]
    fn lines_come_in_the_order_of_the_programs() {
        let mut turns = Turns::default();
        let numbers = [turns.enter(), turns.enter(), turns.enter()];
        assert_eq!(numbers, [0, 1, 2]);
        let none: [&str; 0] = [];
        assert_eq!(turns.say(1, "b".into()), none);
        assert_eq!(turns.say(0, "a".into()), ["a"]);
        // The second ends first: its lines still wait for the first one, and the third prints its own after
        // them.
        assert_eq!(turns.leave(1), none);
        assert_eq!(turns.say(2, "c".into()), none);
        assert_eq!(turns.leave(0), ["b", "c"]);
        assert_eq!(turns.say(2, "d".into()), ["d"]);
        assert_eq!(turns.leave(2), none);
    }
}
