//! The stock at moments of the run, as meshes of bounded size.

use std::collections::BTreeMap;

use proveout_controller::Event;
use proveout_geom::Aabb;
use proveout_sim::{
    finding::Severity,
    observer::{Batch, Setup},
};
use proveout_stock::{Patch, TriDexel};

use crate::{
    in_process::{
        frames::{FrameCollector, RecordingFrame},
        tiles::StockTiles,
    },
    page_encoding::{DeltaWriter, Shades, pack_mesh_in},
    report::{blocks::Blocks, player::knots::TIME_STEPS},
};

/// Triangles of the first picture of the stock, about.
const TRIANGLES: f64 = 100_000.0;
/// Most bytes of all meshes before they are compressed: some 6 MB of page.
const MOST_BYTES: usize = 12 << 20;
/// Most moments of tool changes, and of errors, that thinning keeps.
const KEPT_CHANGES: usize = 24;
const KEPT_ERRORS: usize = 12;
/// Least part of a program that counts as done: the expected end stays a number.
const LEAST_DONE: f64 = 1e-6;

/// Gathers the meshes while the run goes on: tiles that changed, packed at once.
#[derive(Debug)]
pub(crate) struct StockMoments {
    tiles: Vec<StockTiles>,
    frames: FrameCollector<Vec<u8>>,
    /// All meshes round their vertices in this box.
    bounds: Aabb,
    /// Longest edge of the cells of the meshes, mm.
    cell: f64,
    changes: usize,
    errors: usize,
}

/// The moments packed for the page.
#[derive(Clone, Debug, Default)]
pub(crate) struct PackedMoments {
    pub(crate) bytes: Vec<u8>,
    pub(crate) count: usize,
}

impl StockMoments {
    pub(crate) fn new(setup: &Setup<'_>) -> Self {
        let tiles = StockTiles::all(setup.stock, setup.patches, TRIANGLES);
        let stocks = std::iter::once(setup.stock).chain(setup.patches.iter().map(Patch::stock));
        let cell = tiles.iter().zip(stocks).map(|(t, s)| t.step() as f64 * s.cell_mm()).fold(0.0, f64::max);
        let mut moments = Self {
            tiles,
            frames: FrameCollector::default(),
            // Vertices of the raw skin lie in cells that reach over the box.
            bounds: setup.stock.bounds().expanded(setup.stock.cell_mm()),
            cell,
            changes: 0,
            errors: 0,
        };
        moments.push(0.0, true, setup.stock, setup.patches, &Blocks::default());
        moments
    }

    /// Distance of the rays that the meshes are made from, mm: a vertex lies within the diagonal of such a
    /// cell from the surface.
    pub(crate) fn cell(&self) -> f64 {
        self.cell
    }

    pub(crate) fn take(&mut self, setup: &Setup<'_>, batch: &Batch<'_>, blocks: &Blocks) {
        let changed = std::iter::once(batch.changed_tiles).chain(batch.changed_in_patches.iter().map(Vec::as_slice));
        self.tiles.iter_mut().zip(changed).for_each(|(tiles, changed)| tiles.mark(changed));
        if let Some(row) = batch.blocks.last() {
            // As in the recording: the line estimates what is done.
            let done = f64::from(row.line) / f64::from(setup.program_lines.max(1));
            self.frames.expect(batch.time, batch.time / done.clamp(LEAST_DONE, 1.0));
        }
        let change = batch.events.iter().any(|e| matches!(e, Event::ToolChange { .. }));
        let error = batch.findings.iter().any(|f| f.severity == Severity::Error);
        let keep = change && self.changes < KEPT_CHANGES || error && self.errors < KEPT_ERRORS;
        if keep || self.frames.due(batch.time) {
            self.changes += usize::from(change);
            self.errors += usize::from(error);
            self.push(batch.time, keep, batch.stock, batch.patches, blocks);
        }
    }

    fn push(&mut self, time: f64, keep: bool, stock: &TriDexel, patches: &[Patch], blocks: &Blocks) {
        let stocks = std::iter::once(stock).chain(patches.iter().map(Patch::stock));
        let mut parts: BTreeMap<u32, Vec<u8>> = BTreeMap::new();
        for (tiles, stock) in self.tiles.iter_mut().zip(stocks) {
            for (group, picture) in tiles.take_changed(stock) {
                let bytes = if picture.triangles.is_empty() {
                    Vec::new()
                } else {
                    pack_mesh_in(&self.bounds, &picture, Shades::Plain, &blocks.tags(&picture.pieces))
                };
                parts.insert(group, bytes);
            }
        }
        self.frames.push(RecordingFrame { time, keep, parts });
        while self.frames.sum(Vec::len) > MOST_BYTES && self.frames.thin() {}
    }

    /// The moments packed for the page, little endian:
    ///
    /// ```text
    /// u32       groups of tiles
    /// u32       moments
    /// u32       parts
    /// varint    time of all moments, 0.1 ms, zigzag of the differences
    /// varint    moment of all parts, likewise; then the group of all parts, then the bytes of all parts
    /// u8        meshes of the parts, one after the other (see `pack_mesh`); none where nothing is left
    /// ```
    pub(crate) fn pack(mut self) -> PackedMoments {
        let frames: Vec<RecordingFrame<Vec<u8>>> = self.frames.drain().collect();
        let mut dense = BTreeMap::new();
        for group in frames.iter().flat_map(|f| f.parts.keys()) {
            let next = dense.len();
            dense.entry(*group).or_insert(next);
        }
        let parts = || frames.iter().enumerate().flat_map(|(k, f)| f.parts.iter().map(move |(g, bytes)| (k, g, bytes)));
        let mut out = Vec::new();
        for count in [dense.len(), frames.len(), parts().count()] {
            out.extend((count as u32).to_le_bytes());
        }
        let column = |values: &mut dyn Iterator<Item = i64>, out: &mut Vec<u8>| {
            let mut deltas = DeltaWriter::default();
            values.for_each(|v| deltas.put(v, out));
        };
        column(&mut frames.iter().map(|f| (f.time * TIME_STEPS).round() as i64), &mut out);
        column(&mut parts().map(|(k, ..)| k as i64), &mut out);
        column(&mut parts().map(|(_, g, _)| dense.get(g).map_or(0, |g| *g as i64)), &mut out);
        column(&mut parts().map(|(.., bytes)| bytes.len() as i64), &mut out);
        let count = frames.len();
        parts().for_each(|(.., bytes)| out.extend_from_slice(bytes));
        PackedMoments { bytes: out, count }
    }
}
