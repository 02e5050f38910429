//! Times of standstills by what the program asks for there: tool changes, dwells, M words.

use proveout_nc::{Command, Dwell, Op, ToolAction};
use serde::Serialize;

use crate::{fit::moves::at_rest, trace::Trace};

/// Standstills of a program by line.
#[derive(Clone, Debug, Default)]
pub struct WordTimes {
    lines: u32,
    words: Vec<(u32, &'static str, f64)>,
}

/// Time of one kind of standstill.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WordTime {
    /// What the program asks for.
    pub word: &'static str,
    /// How often it was seen.
    pub count: usize,
    /// Mean, s. Of dwells, the mean time beyond the programmed one.
    pub mean_s: f64,
    /// Standard error of the mean, s: rows and spread.
    pub standard_error_s: f64,
    /// Standard deviation of one, s; zero of a single one.
    pub spread_s: f64,
}

impl WordTimes {
    /// A program with so many lines.
    pub fn new(lines: u32) -> Self {
        Self { lines, words: Vec::new() }
    }

    /// Takes in a command of the program.
    pub fn add(&mut self, command: &Command) {
        let (word, seconds) = match &command.op {
            Op::Tool(ToolAction::Change(_)) => ("tool change", 0.0),
            Op::Dwell(Dwell::Seconds(s)) => ("dwell", *s),
            Op::Spindle(_) => ("spindle", 0.0),
            Op::Coolant(_) => ("coolant", 0.0),
            _ => return,
        };
        self.words.push((command.location.line, word, seconds));
    }

    /// Times as the traces show them; error and remedy where a trace has lines that the program does not.
    pub(crate) fn measured(&self, traces: &[Trace]) -> Result<Vec<WordTime>, (String, &'static str)> {
        let mut all: Vec<(&'static str, Vec<f64>, f64)> = Vec::new();
        for trace in traces {
            let Some(block) = &trace.block else { continue };
            if let Some(line) = block.iter().find(|b| **b > self.lines) {
                let message =
                    format!("line {line} is in the trace {}, and the program has {} lines", trace.name, self.lines);
                return Err((message, "name the program that was recorded"));
            }
            let rest = at_rest(trace);
            let mut row = 0;
            while row < block.len() {
                let line = block.get(row).copied().unwrap_or_default();
                let end = row + block.iter().skip(row).take_while(|b| **b == line).count();
                let still = (row..end).filter(|r| rest.get(*r).copied().unwrap_or(false)).count();
                let of_line: Vec<_> = self.words.iter().filter(|(l, ..)| *l == line).collect();
                // Two words in one line share a time that nothing divides.
                if let [(_, word, programmed)] = of_line.as_slice()
                    && end < block.len()
                    && row > 0
                {
                    let time = still as f64 * trace.step - programmed;
                    match all.iter_mut().find(|(w, ..)| w == word) {
                        Some((_, times, step)) => {
                            times.push(time);
                            *step = step.max(trace.step);
                        }
                        None => all.push((word, vec![time], trace.step)),
                    }
                }
                row = end.max(row + 1);
            }
        }
        let summary = |(word, times, step): (&'static str, Vec<f64>, f64)| {
            let n = times.len() as f64;
            let mean = times.iter().sum::<f64>() / n;
            let squares: f64 = times.iter().map(|t| (t - mean) * (t - mean)).sum();
            let spread = if n > 1.0 { (squares / (n - 1.0)).sqrt() } else { 0.0 };
            // Begin and end of a block fall between two rows: a uniform error of a step each.
            let rows = step / 6_f64.sqrt();
            WordTime {
                word,
                count: times.len(),
                mean_s: mean,
                standard_error_s: ((spread * spread + rows * rows) / n).sqrt(),
                spread_s: spread,
            }
        };
        Ok(all.into_iter().map(summary).collect())
    }
}
