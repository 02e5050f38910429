//! Runs that are not the whole check: with coarse cells (`run --preview`), or ended early (`run --stop-at`).
//!
//! What they find is true, and fails its gate as in any run; what they do not find proves nothing.
//! A preview sweeps the same motion through cells [`COARSER`] times as long, so that everything
//! that does not ask the stock (program, limits, bodies against bodies) is judged in full, and
//! gates that ask it stay `unchecked` with both cells. A run that ends early has seen no gate to
//! its end: all are `unchecked` unless they failed, and an unfinished part is not judged for
//! excess, features and texture.

use proveout_controller::{BlockKind, BlockRecord, Chunk, MoveKind, Summary};

use crate::{
    prepare::prepared::Prepared,
    verdict::{
        finding::{Finding, Severity},
        verdict_file,
    },
};

pub use crate::{
    prepare::{preview::COARSER, stop_at::StopAt},
    verdict::partial_run::{Partial, PreviewUsed, Stopped},
};

/// Simulated time of a stretch where a finding ends the run, s: by so much it may run on.
const NEAR_S: f64 = 0.1;

/// Follows a run that may end early.
pub(crate) struct Watch<'a> {
    stop_at: Option<&'a StopAt>,
    file: String,
    /// Index and end of the last block of the line, while it is run.
    on_line: Option<u32>,
    /// What was run.
    time: verdict_file::Time,
    blocks: u64,
    planned_s: f64,
    last: Option<(String, u32)>,
    stopped: Option<String>,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(prepared: &'a Prepared) -> Self {
        Self {
            stop_at: prepared.wanted.stop_at.as_ref(),
            file: prepared.running_file().display().to_string(),
            on_line: None,
            time: verdict_file::Time::default(),
            blocks: 0,
            planned_s: 0.0,
            last: None,
            stopped: None,
        }
    }

    /// Simulated time of a stretch, where it is less than usual.
    pub(crate) fn stretch_s(&self, usual: f64) -> f64 {
        if matches!(self.stop_at, Some(StopAt::Finding(_))) { NEAR_S.min(usual) } else { usual }
    }

    /// The run is at its end.
    pub(crate) fn has_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    /// A finding ended the run within a chunk: the rest of it is not run.
    pub(crate) fn ends_here(&self) -> bool {
        self.stopped.is_some() && matches!(self.stop_at, Some(StopAt::Finding(_)))
    }

    /// The part of a chunk that is run.
    pub(crate) fn cut(&mut self, mut chunk: Chunk) -> Chunk {
        if self.stop_at.is_none() {
            return chunk;
        }
        let ends = [chunk.pieces.last().map(|p| p.time[1]), chunk.blocks.last().map(|b| b.end_time)];
        self.planned_s = ends.into_iter().flatten().fold(self.planned_s, f64::max);
        match self.stop_at {
            Some(StopAt::Line(line)) => {
                if let Some(last) = self.end_of_line(*line, &chunk.blocks) {
                    self.stopped = Some(format!("line {line} was run"));
                    chunk.pieces.retain(|p| p.block <= last);
                    chunk.blocks.retain(|b| b.index <= last);
                    chunk.events.retain(|e| e.block() <= last);
                    let end = chunk.blocks.last().map_or(f64::NEG_INFINITY, |b| b.end_time);
                    chunk.samples.retain(|s| s.time <= end);
                }
            }
            Some(StopAt::Time(time)) if self.planned_s >= *time => {
                self.stopped = Some(format!("{time} s of the program were run"));
                chunk.pieces.retain(|p| p.time[0] < *time);
                let end = chunk.pieces.last().map_or(*time, |p| p.time[1].max(*time));
                chunk.blocks.retain(|b| b.start_time <= end);
                chunk.events.retain(|e| e.time() <= end);
                chunk.samples.retain(|s| s.time <= end);
            }
            _ => {}
        }
        chunk
    }

    /// Last block of the line, once a block of another one follows.
    fn end_of_line(&mut self, line: u32, blocks: &[BlockRecord]) -> Option<u32> {
        for block in blocks {
            if block.line == line && *block.file == *self.file {
                self.on_line = Some(block.index);
            } else if let Some(last) = self.on_line {
                return Some(last);
            }
        }
        None
    }

    /// Books a stretch that was run, with what it found.
    pub(crate) fn ran(&mut self, stretch: &Chunk, findings: &[Finding]) {
        if self.stop_at.is_none() {
            return;
        }
        for piece in &stretch.pieces {
            let seconds = piece.time[1] - piece.time[0];
            match piece.kind {
                MoveKind::Feed => self.time.cutting_s += seconds,
                MoveKind::Rapid | MoveKind::Handling => self.time.rapid_s += seconds,
            }
        }
        for block in &stretch.blocks {
            let seconds = block.end_time - block.start_time;
            match block.kind {
                BlockKind::Dwell => self.time.dwell_s += seconds,
                BlockKind::ToolChange => self.time.tool_change_s += seconds,
                BlockKind::Move(_) | BlockKind::Action => {}
            }
            self.last = Some((block.file.to_string(), block.line));
        }
        self.blocks += stretch.blocks.len() as u64;
        let Some(StopAt::Finding(code)) = self.stop_at else { return };
        let wanted = |f: &&Finding| code.map_or(f.severity == Severity::Error, |code| f.code == code);
        if let Some(found) = findings.iter().find(wanted) {
            let at = found.time_s.map_or_else(String::new, |t| format!(" at {t:.3} s"));
            self.stopped = Some(format!("the first finding {}{at}: {}", found.code, found.message));
        }
    }

    /// What the verdict says of the end, where it came early; the summary then gives the time that
    /// was run.
    pub(crate) fn finish(self, prepared: &Prepared, summary: &mut Summary, time_s: f64) -> Option<Stopped> {
        let why = self.stopped?;
        (summary.cutting_s, summary.rapid_s) = (self.time.cutting_s, self.time.rapid_s);
        (summary.dwell_s, summary.tool_change_s) = (self.time.dwell_s, self.time.tool_change_s);
        (summary.total_s, summary.blocks) = (time_s, self.blocks);
        (summary.lower_bound_s, summary.path_bound_s) = (None, None);
        let (file, line) = self.last.unzip();
        Some(Stopped {
            at: self.stop_at.map(ToString::to_string).unwrap_or_default(),
            why,
            file: file.map(|f| prepared.shown_as(&f)),
            line,
            time_s,
            planned_s: self.planned_s.max(time_s),
        })
    }
}
