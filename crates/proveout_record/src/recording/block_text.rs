//! The block that runs as text: its file, its line and what is written there.

use std::{collections::BTreeMap, sync::Arc};

use proveout_sim::{
    listing::{self, Wanted},
    observer::{BlockRow, Setup},
};

/// Rows after which the distance of two rows doubles.
const ROWS: usize = 50_000;
/// First distance of two rows once there are many, s.
const FIRST_SPACING: f64 = 0.02;

/// Lines of a file by their numbers; empty where it cannot be read any more.
type FileLines = BTreeMap<u32, String>;

/// Texts of blocks that are not sent yet.
#[derive(Debug, Default)]
pub(crate) struct BlockTexts {
    /// Begin of the block, s, and text.
    pub(crate) rows: Vec<(f64, String)>,
    files: BTreeMap<Arc<str>, FileLines>,
    written: usize,
    last: f64,
    spacing: f64,
}

impl BlockTexts {
    pub(crate) fn take(&mut self, setup: &Setup<'_>, blocks: &[BlockRow]) {
        for row in blocks.iter().filter(|row| row.start_time.is_finite()) {
            if self.written > 0 && row.start_time < self.last + self.spacing {
                continue;
            }
            let lines = self.files.entry(Arc::clone(&row.file)).or_insert_with(|| read(setup, &row.file));
            self.rows.push((row.start_time, text(row, lines)));
            self.last = row.start_time;
            self.written += 1;
            if self.written.is_multiple_of(ROWS) {
                self.spacing = (2.0 * self.spacing).max(FIRST_SPACING);
            }
        }
    }
}

fn read(setup: &Setup<'_>, file: &str) -> FileLines {
    listing::lines(setup, file, &Wanted::All).map(|all| all.shown.into_iter().collect()).unwrap_or_default()
}

fn text(row: &BlockRow, lines: &FileLines) -> String {
    let line = lines.get(&row.line).map_or("", String::as_str);
    format!("{}\n{}, line {}, block {}", line.trim(), row.file, row.line, row.block)
}

#[cfg(test)]
mod tests {
    use proveout_controller::MoveKind;

    use super::*;

    #[test]
    fn a_block_names_its_line() {
        let row = BlockRow {
            block: 7,
            file: "plate.nc".into(),
            line: 12,
            kind: MoveKind::Feed,
            tool: None,
            start_time: 1.0,
            end_time: 2.0,
            length: 5.0,
            feed: None,
            volume_mm3: 0.0,
            engagement_mm: 0.0,
            engagement: None,
        };
        let lines = FileLines::from([(12, "  N12 G1 X5  ".to_owned())]);
        assert_eq!(text(&row, &lines), "N12 G1 X5\nplate.nc, line 12, block 7");
        assert_eq!(text(&row, &FileLines::new()), "\nplate.nc, line 12, block 7");
    }
}
