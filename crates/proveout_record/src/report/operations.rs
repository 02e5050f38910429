//! Time, feed and removal by operation: the stretch from a tool change, a message or a comment that names an
//! operation to the next.

use std::{collections::BTreeMap, sync::Arc};

use proveout_controller::{Event, MoveKind};
use proveout_sim::listing;
use proveout_sim::observer::{Batch, BlockRow, Setup};

/// Largest number of separate operations; everything after counts to the last one.
const MOST: usize = 500;
/// Longest text of a message in a name, characters.
const MOST_CHARS: usize = 60;

/// One operation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Operation {
    /// Block that it begins with.
    pub(crate) block: u32,
    /// Text of the message that begins it; empty where a tool change does.
    pub(crate) text: String,
    /// Index of the tool in the library.
    pub(crate) tool: Option<u32>,
    /// First and last line.
    pub(crate) lines: Option<[u32; 2]>,
    pub(crate) time_s: f64,
    pub(crate) feed_s: f64,
    pub(crate) rapid_s: f64,
    /// Length in feed, mm, of the blocks that have a feed, and their times: taken, and at the programmed
    /// feed.
    pub(crate) feed_mm: f64,
    pub(crate) fed_s: f64,
    pub(crate) programmed_s: f64,
    pub(crate) volume_mm3: f64,
}

impl Operation {
    /// Feed reached, mm/min, and its share of the programmed one; none without motion in feed.
    pub(crate) fn feed(&self) -> Option<(f64, f64)> {
        let fed = self.fed_s > 0.0 && self.feed_mm > 0.0;
        fed.then(|| (60.0 * self.feed_mm / self.fed_s, self.programmed_s / self.fed_s))
    }

    /// Adds another one.
    pub(crate) fn add(&mut self, other: &Self) {
        self.time_s += other.time_s;
        self.feed_s += other.feed_s;
        self.rapid_s += other.rapid_s;
        self.feed_mm += other.feed_mm;
        self.fed_s += other.fed_s;
        self.programmed_s += other.programmed_s;
        self.volume_mm3 += other.volume_mm3;
    }

    fn block(&mut self, row: &BlockRow) {
        let time = row.end_time - row.start_time;
        if !(time.is_finite() && row.length.is_finite()) {
            return;
        }
        self.time_s += time;
        self.volume_mm3 += row.volume_mm3;
        self.tool = row.tool.or(self.tool);
        let [low, high] = self.lines.unwrap_or([row.line; 2]);
        self.lines = Some([low.min(row.line), high.max(row.line)]);
        match row.kind {
            MoveKind::Feed => self.feed_s += time,
            MoveKind::Rapid => self.rapid_s += time,
            _ => {}
        }
        // Blocks of rotary motion alone have no tip path length, so no feed can be given for them.
        if let Some(feed) = row.feed.filter(|f| *f > 0.0 && row.kind == MoveKind::Feed && row.length > 0.0) {
            self.feed_mm += row.length;
            self.fed_s += time;
            self.programmed_s += row.length / feed;
        }
    }
}

/// The operations of a run, while it goes on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Operations {
    all: Vec<Operation>,
    /// Names in comments by file: line and name.
    heads: BTreeMap<Arc<str>, Vec<(u32, String)>>,
    /// File and line of the block before.
    last: Option<(Arc<str>, u32)>,
}

impl Operations {
    pub(crate) fn take(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) {
        for event in batch.events {
            match event {
                Event::ToolChange { block, .. } => self.begin(*block, ""),
                Event::Message { block, text, .. } if !text.trim().is_empty() => self.begin(*block, text.trim()),
                _ => {}
            }
        }
        for row in batch.blocks {
            if let Some(name) = self.head_before(row, |file| listing::operations(setup, file)) {
                self.begin(row.block, &name);
            }
            if self.all.first().is_none_or(|first| row.block < first.block) {
                self.all.insert(0, Operation { block: row.block, ..Operation::default() });
            }
            let at = self.all.partition_point(|o| o.block <= row.block).saturating_sub(1);
            self.all[at].block(row);
        }
    }

    /// The name in a comment between the block before and this one; where several stand there, the last.
    fn head_before(&mut self, row: &BlockRow, read: impl FnOnce(&str) -> Vec<(u32, String)>) -> Option<String> {
        let heads = self.heads.entry(Arc::clone(&row.file)).or_insert_with(|| read(&row.file));
        let from = match &self.last {
            Some((file, line)) if *file == row.file => *line,
            _ => 0,
        };
        self.last = Some((Arc::clone(&row.file), row.line));
        let at = heads.partition_point(|(line, _)| *line <= row.line).checked_sub(1)?;
        heads.get(at).filter(|(line, _)| *line > from).map(|(_, name)| name.clone())
    }

    fn begin(&mut self, block: u32, text: &str) {
        let text: String = text.chars().take(MOST_CHARS).collect();
        // Tool changes and messages of a stretch come before its blocks.
        let at = self.all.partition_point(|o| o.block <= block);
        let before = at.checked_sub(1).and_then(|before| self.all.get_mut(before));
        // A message or a comment right before or after a tool change names the same operation.
        if let Some(last) = before.filter(|o| block <= o.block + 1 && o.feed_s == 0.0) {
            if last.text.is_empty() {
                last.text = text;
            }
            return;
        }
        if self.all.len() < MOST {
            self.all.insert(at, Operation { block, text, ..Operation::default() });
        }
    }

    /// Those that take time.
    pub(crate) fn finish(self) -> Vec<Operation> {
        self.all.into_iter().filter(|o| o.time_s > 0.0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(block: u32, kind: MoveKind, seconds: f64, length: f64, feed: Option<f64>) -> BlockRow {
        BlockRow {
            block,
            file: "a.mpf".into(),
            line: block + 10,
            kind,
            tool: Some(1),
            start_time: 5.0,
            end_time: 5.0 + seconds,
            length,
            feed,
            volume_mm3: 2.0,
            engagement_mm: 0.0,
            engagement: None,
        }
    }

    #[test]
    fn feed_is_length_over_time_and_its_share_that_of_the_times() {
        let mut o = Operation::default();
        o.block(&row(1, MoveKind::Feed, 2.0, 100.0, Some(100.0)));
        o.block(&row(2, MoveKind::Feed, 3.0, 100.0, Some(50.0)));
        o.block(&row(3, MoveKind::Rapid, 1.0, 400.0, None));
        // A table that turns: no length of the tip.
        o.block(&row(4, MoveKind::Feed, 9.0, 0.0, Some(50.0)));
        let (feed, share) = o.feed().expect("fed");
        assert!((feed - 60.0 * 200.0 / 5.0).abs() < 1e-9 && (share - 3.0 / 5.0).abs() < 1e-12);
        assert_eq!((o.time_s, o.feed_s, o.rapid_s, o.lines), (15.0, 14.0, 1.0, Some([11, 14])));
        assert_eq!(Operation::default().feed(), None);
        o.block(&row(5, MoveKind::Feed, f64::NAN, 1.0, Some(1.0)));
        assert_eq!(o.time_s, 15.0);
    }

    #[test]
    fn a_comment_between_two_blocks_begins_an_operation() {
        let mut all = Operations::default();
        let heads = || vec![(12, "ROUGH".to_owned()), (15, "FINISH".to_owned())];
        let begun: Vec<Option<String>> =
            (1..8).map(|block| all.head_before(&row(block, MoveKind::Feed, 1.0, 1.0, None), |_| heads())).collect();
        // Rows are at the lines 11 to 17.
        let named = |name: &str| Some(name.to_owned());
        assert_eq!(begun, [None, named("ROUGH"), None, None, named("FINISH"), None, None]);
        // A loop that comes back before the head begins it again.
        assert_eq!(all.head_before(&row(3, MoveKind::Feed, 1.0, 1.0, None), |_| Vec::new()), None);
        assert_eq!(all.head_before(&row(6, MoveKind::Feed, 1.0, 1.0, None), |_| Vec::new()), named("FINISH"));
    }

    #[test]
    fn a_message_beside_a_tool_change_names_it() {
        let mut all = Operations::default();
        all.begin(0, "");
        all.begin(1, "ROUGH");
        all.all[0].block(&row(2, MoveKind::Feed, 2.0, 100.0, Some(100.0)));
        all.begin(9, "FINISH");
        all.begin(40, "nothing moves");
        all.all[1].block(&row(10, MoveKind::Feed, 2.0, 100.0, Some(100.0)));
        let names: Vec<String> = all.finish().into_iter().map(|o| o.text).collect();
        assert_eq!(names, ["ROUGH", "FINISH"]);
    }
}
