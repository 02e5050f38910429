//! The blocks of a run as the player steps through them: of bounded number.

use proveout_controller::MoveKind;
use proveout_sim::observer::BlockRow;

use crate::{
    page_encoding::DeltaWriter,
    report::{
        blocks::{Blocks, LineNumbers},
        player::knots::TIME_STEPS,
    },
    units::PER_MINUTE,
};

/// Most steps: some 2 MB of page.
const MOST_STEPS: usize = 200_000;
/// Steps of a length in a millimeter, and of a volume in a cubic millimeter.
const LENGTH_STEPS: f64 = 100.0;
const VOLUME_STEPS: f64 = 10.0;

/// A block, or a few blocks in a row where there are too many.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlayedStep {
    block: u32,
    end: f64,
    kind: MoveKind,
    tool: Option<u32>,
    /// Programmed feed, mm/s; zero for none.
    feed: f64,
    length: f64,
    volume: f64,
}

/// All steps of a run in order of time.
#[derive(Clone, Debug)]
pub(crate) struct PlayedSteps {
    all: Vec<PlayedStep>,
    /// Blocks of a step.
    stride: u32,
    /// Blocks in the last step.
    filled: u32,
}

impl Default for PlayedSteps {
    fn default() -> Self {
        Self { all: Vec::new(), stride: 1, filled: 1 }
    }
}

impl PlayedSteps {
    pub(crate) fn take(&mut self, rows: &[BlockRow]) {
        for row in rows.iter().filter(|r| r.end_time.is_finite() && r.length.is_finite()) {
            let feed = row.feed.filter(|f| f.is_finite() && row.kind == MoveKind::Feed).unwrap_or(0.0);
            let step = PlayedStep {
                block: row.block,
                end: row.end_time,
                kind: row.kind,
                tool: row.tool,
                feed,
                length: row.length,
                volume: if row.volume_mm3.is_finite() { row.volume_mm3 } else { 0.0 },
            };
            match self.all.last_mut().filter(|_| self.filled < self.stride) {
                Some(last) => {
                    join(last, &step);
                    self.filled += 1;
                }
                None => {
                    self.all.push(step);
                    self.filled = 1;
                }
            }
            if self.all.len() > MOST_STEPS {
                self.halve();
            }
        }
    }

    /// Joins neighbors.
    fn halve(&mut self) {
        let odd = self.all.len() % 2 == 1;
        let old = std::mem::take(&mut self.all);
        for pair in old.chunks(2) {
            let mut step = pair[0];
            pair[1..].iter().for_each(|next| join(&mut step, next));
            self.all.push(step);
        }
        self.filled += if odd { 0 } else { self.stride };
        self.stride *= 2;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Blocks that one step goes over.
    pub(crate) fn stride(&self) -> u32 {
        self.stride
    }

    /// Time (s) at which a block begins, or the step that it is in; zero for blocks before the first.
    pub(crate) fn begin_of(&self, block: u32) -> f64 {
        let after = self.all.partition_point(|s| s.block <= block);
        after.checked_sub(2).and_then(|before| self.all.get(before)).map_or(0.0, |step| step.end)
    }

    /// The steps packed for the page, little endian; each column of whole numbers is zigzag of the
    /// differences:
    ///
    /// ```text
    /// u32       steps
    /// varint    number of the first block
    /// varint    its line, over all files, 0 for none
    /// varint    end, 0.1 ms
    /// varint    2 * (index of the tool in the library + 1), 0 for none; plus 1 for rapid motion
    /// varint    programmed feed, mm/min, 0 for none
    /// varint    way of the tip, 0.01 mm
    /// varint    volume removed, 0.1 mm³
    /// ```
    pub(crate) fn pack(&self, blocks: &Blocks, numbers: &LineNumbers, out: &mut Vec<u8>) {
        out.extend((self.all.len() as u32).to_le_bytes());
        let mut column = |value: &dyn Fn(&PlayedStep) -> i64| {
            let mut deltas = DeltaWriter::default();
            self.all.iter().for_each(|s| deltas.put(value(s), out));
        };
        column(&|s| i64::from(s.block));
        column(&|s| i64::from(numbers.at(blocks.of_block(s.block))));
        column(&|s| (s.end * TIME_STEPS).round() as i64);
        column(&|s| 2 * s.tool.map_or(0, |t| i64::from(t) + 1) + i64::from(s.kind == MoveKind::Rapid));
        column(&|s| (s.feed * PER_MINUTE).round() as i64);
        column(&|s| (s.length * LENGTH_STEPS).round() as i64);
        column(&|s| (s.volume * VOLUME_STEPS).round() as i64);
    }
}

/// The first block names the step; time and sums are of all of them.
fn join(step: &mut PlayedStep, next: &PlayedStep) {
    step.end = step.end.max(next.end);
    step.length += next.length;
    step.volume += next.volume;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(block: u32) -> BlockRow {
        BlockRow {
            block,
            file: "a.mpf".into(),
            line: block + 1,
            kind: MoveKind::Feed,
            tool: Some(2),
            start_time: f64::from(block),
            end_time: f64::from(block + 1),
            length: 0.5,
            feed: Some(20.0),
            volume_mm3: 2.0,
            engagement_mm: 0.0,
            engagement: None,
        }
    }

    #[test]
    fn a_block_is_a_step_until_there_are_too_many() {
        let mut steps = PlayedSteps::default();
        for block in 0..MOST_STEPS as u32 {
            steps.take(&[row(block)]);
        }
        assert_eq!((steps.all.len(), steps.stride()), (MOST_STEPS, 1));
        assert_eq!((steps.begin_of(7), steps.begin_of(0)), (7.0, 0.0));
        let count = 3 * MOST_STEPS as u32 + 5;
        for block in MOST_STEPS as u32..count {
            steps.take(&[row(block)]);
        }
        assert_eq!((steps.all.len(), steps.stride()), ((count as usize).div_ceil(4), 4));
        let sums = steps.all.iter().fold((0.0, 0.0), |(l, v), s| (l + s.length, v + s.volume));
        assert_eq!(sums, (0.5 * f64::from(count), 2.0 * f64::from(count)), "nothing is lost");
        assert!(steps.all.windows(2).all(|w| w[0].end < w[1].end && w[1].block == w[0].block + 4));
        assert_eq!((steps.begin_of(9), steps.all.last().map(|s| s.end)), (8.0, Some(f64::from(count))));
    }

    #[test]
    fn columns_are_packed_one_after_the_other() {
        let mut steps = PlayedSteps::default();
        steps.take(&[row(0), row(1)]);
        let mut out = Vec::new();
        steps.pack(&Blocks::default(), &LineNumbers::default(), &mut out);
        let expected: Vec<u8> = [2_u8, 0, 0, 0]
            .into_iter()
            .chain([0, 2]) // blocks 0, 1
            .chain([0, 0]) // no lines
            .chain([0xa0, 0x9c, 1, 0xa0, 0x9c, 1]) // 10,000 and 20,000
            .chain([12, 0]) // tool 2
            .chain([0xe0, 18, 0]) // 1200 mm/min
            .chain([100, 0]) // 0.5 mm
            .chain([40, 0]) // 2 mm³
            .collect();
        assert_eq!(out, expected);
    }
}
