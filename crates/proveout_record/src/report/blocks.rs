//! Where the blocks of a run are in its program files, and which motion belongs to which block.

use std::sync::Arc;

use proveout_sim::{listing::Listing, observer::Batch};

use crate::picture::NO_PIECE;

/// Most files whose lines get a number of their own.
const MOST_FILES: usize = 60_000;

/// The blocks of a run: 24 bytes each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    files: Vec<Arc<str>>,
    /// By number of the block.
    places: Vec<Option<BlockPlace>>,
    /// Motion piece with which a block begins, and the block.
    starts: Vec<(u32, u32)>,
    pieces: u32,
}

/// A line of a file, and the tool in the spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockPlace {
    pub(crate) file: u16,
    pub(crate) line: u32,
    /// Index in the library.
    pub(crate) tool: Option<u16>,
}

impl Blocks {
    pub(crate) fn take(&mut self, batch: &Batch<'_>) {
        for piece in batch.pieces {
            if self.starts.last().is_none_or(|(_, block)| *block != piece.block) {
                self.starts.push((self.pieces, piece.block));
            }
            self.pieces += 1;
        }
        for row in batch.blocks {
            let file = self.files.iter().position(|f| *f == row.file).or_else(|| {
                self.files.push(Arc::clone(&row.file));
                (self.files.len() < MOST_FILES).then(|| self.files.len() - 1)
            });
            let at = row.block as usize;
            if self.places.len() <= at {
                self.places.resize(at + 1, None);
            }
            let tool = row.tool.and_then(|t| u16::try_from(t).ok());
            self.places[at] = file.map(|file| BlockPlace { file: file as u16, line: row.line, tool });
        }
    }

    /// Place of a block in the files.
    pub(crate) fn of_block(&self, block: u32) -> Option<BlockPlace> {
        self.places.get(block as usize).copied().flatten()
    }

    /// Number of the block of a motion piece.
    pub(crate) fn block_of_piece(&self, piece: u32) -> Option<u32> {
        if piece == NO_PIECE {
            return None;
        }
        let at = self.starts.partition_point(|(first, _)| *first <= piece).checked_sub(1)?;
        self.starts.get(at).map(|(_, block)| *block)
    }

    /// Numbers of the blocks of motion pieces plus one, 0 for none: as the page gets them with its meshes.
    pub(crate) fn tags(&self, pieces: &[u32]) -> Vec<u32> {
        pieces.iter().map(|piece| self.block_of_piece(*piece).map_or(0, |block| block.saturating_add(1))).collect()
    }

    /// Names of the files, in order of their numbers.
    pub(crate) fn files(&self) -> &[Arc<str>] {
        &self.files
    }
}

/// Numbers for the lines of all files together, from 1; 0 means none.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineNumbers {
    /// Name of a file, and the number before its first line.
    pub(crate) files: Vec<(String, u32)>,
}

impl LineNumbers {
    /// The files of the blocks, and those of the listings that no block is of.
    pub(crate) fn of(blocks: &Blocks, listings: &[Listing]) -> Self {
        let mut most: Vec<(String, u32)> = blocks.files.iter().map(|f| (f.to_string(), 0)).collect();
        for place in blocks.places.iter().flatten() {
            let count = &mut most[usize::from(place.file)].1;
            *count = (*count).max(place.line);
        }
        for listing in listings {
            match most.iter_mut().find(|(name, _)| *name == listing.file) {
                Some((_, count)) => *count = (*count).max(listing.lines),
                None => most.push((listing.file.clone(), listing.lines)),
            }
        }
        let mut before = 0_u32;
        let base = |(name, count): (String, u32)| {
            let base = before;
            before = before.saturating_add(count);
            (name, base)
        };
        Self { files: most.into_iter().map(base).collect() }
    }

    pub(crate) fn at(&self, place: Option<BlockPlace>) -> u32 {
        place.and_then(|p| Some(self.files.get(usize::from(p.file))?.1 + p.line)).unwrap_or(0)
    }

    pub(crate) fn named(&self, file: Option<&str>, line: Option<u32>) -> u32 {
        let base = || self.files.iter().find(|(name, _)| Some(name.as_str()) == file).map(|f| f.1);
        line.and_then(|line| Some(base()? + line)).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_and_lines_find_their_places() {
        let at = |file, line| Some(BlockPlace { file, line, tool: Some(0) });
        let blocks = Blocks {
            files: vec!["main.mpf".into(), "sub.spf".into()],
            places: vec![at(0, 3), None, at(1, 2), at(0, 5)],
            starts: vec![(0, 0), (4, 2), (9, 3)],
            pieces: 12,
        };
        let place = |piece| blocks.block_of_piece(piece).and_then(|block| blocks.of_block(block));
        assert_eq!((place(3), place(4), place(11)), (at(0, 3), at(1, 2), at(0, 5)));
        assert_eq!((place(NO_PIECE), blocks.of_block(1), blocks.of_block(9)), (None, None, None));
        assert_eq!(blocks.tags(&[3, 4, NO_PIECE, 11]), [1, 3, 0, 4]);
        let listing = Listing { file: "main.mpf".into(), lines: 40, shown: Vec::new() };
        let numbers = LineNumbers::of(&blocks, &[listing]);
        assert_eq!(numbers.files, [("main.mpf".to_owned(), 0), ("sub.spf".to_owned(), 40)]);
        assert_eq!((numbers.at(at(1, 2)), numbers.at(None)), (42, 0));
        assert_eq!((numbers.named(Some("sub.spf"), Some(1)), numbers.named(Some("x"), Some(1))), (41, 0));
        assert_eq!(numbers.named(Some("main.mpf"), None), 0);
    }
}
