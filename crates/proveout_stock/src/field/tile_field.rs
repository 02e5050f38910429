//! A tile spread out over lanes while a batch works on it.
//!
//! ```text
//!     ray 0  ===---====---=          layer k, lane r: interval k of ray r, counted from below
//!     ray 1  =====
//!     ray 2    ====---==
//!            ^ 0   ^ 1    ^ 2
//! ```
//!
//! Which interval is where follows from the material alone, so results do not depend on how a program is cut
//! into batches.

use crate::{
    field::grid::{RayGrid, TILE},
    field::span::{EndMark, MaterialSpan, SLIVER},
    field::tile::Tile,
    kernels::lane_bits::ROW,
    kernels::lane_blocks::{BlockCenters, measure_pair},
    kernels::lane_set::{BLOCKS, LANES, LaneCut, LaneStrip, Lanes, OLD, WIDE},
};

/// One interval of each ray.
#[derive(Debug, Default)]
pub(crate) struct IntervalLayer {
    pub lanes: Lanes,
    /// Range of each row, mm; lo > hi: empty.
    pub row_lo: [f64; WIDE],
    pub row_hi: [f64; WIDE],
    /// The same of each block, and the pairs of rows whose blocks have not been measured since they changed,
    /// one bit each.
    pub block_lo: [f64; BLOCKS],
    pub block_hi: [f64; BLOCKS],
    pub unmeasured: u8,
}

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct Field {
    /// Those in use, and others that wait to be.
    layers: Vec<IntervalLayer>,
    depth: usize,
    columns: [f64; ROW],
    /// Ray centers along v of the rows, and the range along u.
    pub row_v: [f64; WIDE],
    pub u: [f64; 2],
    pub places: BlockCenters,
    /// Range of all, mm.
    pub lo: f64,
    pub hi: f64,
    /// Whether anything was taken away.
    pub changed: bool,
}

impl IntervalLayer {
    /// Recomputes the range of a row.
    pub(crate) fn measure_row(&mut self, row: usize) {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in row * ROW..(row + 1) * ROW {
            lo = if self.lanes.lo[k] < lo { self.lanes.lo[k] } else { lo };
            hi = if self.lanes.hi[k] > hi { self.lanes.hi[k] } else { hi };
        }
        (self.row_lo[row], self.row_hi[row]) = (lo, hi);
        self.unmeasured |= 1 << (row / 2);
    }

    /// Recomputes the ranges of the blocks whose rows have changed; a ball does not use them.
    #[inline]
    pub(crate) fn measure_blocks(&mut self) {
        while self.unmeasured != 0 {
            let pair = self.unmeasured.trailing_zeros() as usize;
            measure_pair(&self.lanes, pair, &mut self.block_lo, &mut self.block_hi);
            self.unmeasured &= self.unmeasured - 1;
        }
    }
}

impl Field {
    /// Spreads a tile out.
    pub(crate) fn fill(&mut self, grid: &RayGrid, index: usize, tile: &Tile) {
        let (a, [i0, j0]) = grid.tile_place(index);
        let (u_axis, v_axis) = ((a + 1) % 3, (a + 2) % 3);
        (self.depth, self.changed) = (0, false);
        self.columns = std::array::from_fn(|i| grid.center(u_axis, i0 + i));
        self.row_v = std::array::from_fn(|j| grid.center(v_axis, j0 + j));
        self.places = BlockCenters::new(&self.columns, &self.row_v);
        let last = grid.n[u_axis].min(i0 + TILE) - 1;
        self.u = [self.columns[0], grid.center(u_axis, last)];
        self.add_layer();
        for r in 0..LANES {
            for (k, span) in tile.ray(r).iter().enumerate() {
                if k == self.depth {
                    self.add_layer();
                }
                let lanes = &mut self.layers[k].lanes;
                (lanes.lo[r], lanes.hi[r]) = (span.lo, span.hi);
                (lanes.lo_by[r], lanes.hi_by[r]) = (OLD, OLD);
            }
        }
        for layer in &mut self.layers[..self.depth] {
            for row in 0..ROW {
                layer.measure_row(row);
            }
        }
        self.measure();
    }

    /// One layer more, empty.
    fn add_layer(&mut self) {
        if self.depth == self.layers.len() {
            self.layers.push(IntervalLayer::default());
        }
        let IntervalLayer { lanes, row_lo, row_hi, block_lo, block_hi, unmeasured } = &mut self.layers[self.depth];
        lanes.clear();
        (*block_lo, *block_hi) = ([f64::INFINITY; BLOCKS], [f64::NEG_INFINITY; BLOCKS]);
        *unmeasured = 0;
        (*row_lo, *row_hi) = ([f64::INFINITY; WIDE], [f64::NEG_INFINITY; WIDE]);
        for r in 0..LANES {
            (lanes.u[r], lanes.v[r], lanes.ray[r]) = (self.columns[r % ROW], self.row_v[r / ROW], r as u8);
        }
        self.depth += 1;
    }

    pub(crate) fn layers(&self) -> &[IntervalLayer] {
        &self.layers[..self.depth]
    }

    pub(crate) fn layers_mut(&mut self) -> &mut [IntervalLayer] {
        &mut self.layers[..self.depth]
    }

    /// Takes the range of all from those of the rows.
    pub(crate) fn measure(&mut self) {
        let (mut lo, mut hi) = ([f64::INFINITY; ROW], [f64::NEG_INFINITY; ROW]);
        // The rows side by side, so that no comparison waits for the one before.
        for layer in &self.layers[..self.depth] {
            for row in 0..ROW {
                lo[row] = if layer.row_lo[row] < lo[row] { layer.row_lo[row] } else { lo[row] };
                hi[row] = if layer.row_hi[row] > hi[row] { layer.row_hi[row] } else { hi[row] };
            }
        }
        for half in [ROW / 2, ROW / 4, ROW / 8] {
            for k in 0..half {
                lo[k] = if lo[k + half] < lo[k] { lo[k + half] } else { lo[k] };
                hi[k] = if hi[k + half] > hi[k] { hi[k + half] } else { hi[k] };
            }
        }
        (self.lo, self.hi) = (lo[0], hi[0]);
    }

    /// Puts an interval above interval `k` of its ray; those further up move up.
    pub(crate) fn insert_above(&mut self, k: usize, strip: &LaneStrip) {
        let r = usize::from(strip.ray);
        let mut carried = *strip;
        for next in k + 1.. {
            if next == self.depth {
                self.add_layer();
            }
            let layer = &mut self.layers[next];
            let old = layer.lanes.strip(r);
            let held = layer.lanes.holds(r);
            layer.lanes.set(r, &carried);
            layer.measure_row(r / ROW);
            if !held {
                return;
            }
            carried = old;
        }
    }

    /// Moves the intervals of a ray down into the gap where interval `k` was.
    pub(crate) fn close_gap(&mut self, k: usize, r: usize) {
        for k in k..self.depth {
            let above = self.layers[..self.depth].get(k + 1).map(|l| l.lanes.strip(r));
            let layer = &mut self.layers[k];
            match above.filter(|strip| strip.lo < strip.hi) {
                Some(strip) => {
                    layer.lanes.set(r, &strip);
                    layer.measure_row(r / ROW);
                }
                None => {
                    layer.lanes.remove(r);
                    layer.measure_row(r / ROW);
                    break;
                }
            }
        }
        while self.depth > 1 && self.layers[self.depth - 1].row_lo.iter().all(|lo| *lo == f64::INFINITY) {
            self.depth -= 1;
        }
    }

    /// Writes the tile again; `mark(strip, upper, spans before)` returns what made an end. `before`
    /// is a buffer.
    pub(crate) fn write(
        &self,
        tile: &mut Tile,
        before: &mut Vec<MaterialSpan>,
        mut mark: impl FnMut(&LaneStrip, bool, &[MaterialSpan]) -> EndMark,
    ) {
        tile.rewrite(before, |r, before, spans| {
            for layer in self.layers() {
                if !layer.lanes.holds(r) {
                    break;
                }
                let strip = layer.lanes.strip(r);
                let (lo_mark, hi_mark) = (mark(&strip, false, before), mark(&strip, true, before));
                spans.push(MaterialSpan { lo: strip.lo, hi: strip.hi, lo_mark, hi_mark });
            }
        });
    }
}

/// What one item met in one tile: small, since a pass makes many.
#[derive(Clone, Debug)]
pub(crate) struct TileOverlap {
    pub item: u32,
    pub rays: u32,
    pub length: f64,
    pub longest: f64,
    /// Middle of the longest overlap, mm.
    pub middle: f64,
    /// Range of the overlaps along the ray, mm.
    pub range: [f64; 2],
    /// Tile ray of the longest overlap.
    pub ray: u8,
    /// Columns and rows with overlap, one bit each.
    pub columns: u8,
    pub rows: u8,
}

impl TileOverlap {
    pub(crate) fn new(item: u32) -> Self {
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Self { item, rays: 0, length: 0.0, longest: 0.0, middle: 0.0, range, ray: 0, columns: 0, rows: 0 }
    }

    /// Takes the overlap on a ray for the longest if it is; among equals the first ray counts.
    #[inline]
    pub(crate) fn note_longest(&mut self, longest: f64, middle: f64, ray: u8) {
        if longest > self.longest || (longest == self.longest && ray < self.ray) {
            (self.longest, self.middle, self.ray) = (longest, middle, ray);
        }
    }

    /// Adds the overlap `lo..hi` with a strip, of which `length` is gone.
    pub(crate) fn add(&mut self, strip: &LaneStrip, [lo, hi]: [f64; 2], length: f64) {
        self.length += length;
        self.note_longest(hi - lo, 0.5 * (lo + hi), strip.ray);
        self.range = [self.range[0].min(lo), self.range[1].max(hi)];
        self.columns |= 1 << (usize::from(strip.ray) % ROW);
        self.rows |= 1 << (usize::from(strip.ray) / ROW);
    }
}

/// What is left of a strip when `from..to` goes: below, above, and the length that is gone; none when nothing
/// is met.
pub(crate) struct StripRest {
    pub met: [f64; 2],
    pub gone: f64,
    pub below: Option<LaneStrip>,
    pub above: Option<LaneStrip>,
}

impl StripRest {
    pub(crate) fn of(strip: &LaneStrip, cut: &LaneCut) -> Option<Self> {
        let (from, to) = (cut.from.max(strip.lo), cut.to.min(strip.hi));
        if to - from <= SLIVER {
            return None;
        }
        let mut gone = strip.hi - strip.lo;
        let below = (from - strip.lo > SLIVER).then(|| {
            gone -= from - strip.lo;
            LaneStrip { hi: from, hi_by: cut.from_by, hi_tau: cut.from_tau, ..*strip }
        });
        let above = (strip.hi - to > SLIVER).then(|| {
            gone -= strip.hi - to;
            LaneStrip { lo: to, lo_by: cut.to_by, lo_tau: cut.to_tau, ..*strip }
        });
        Some(Self { met: [from, to], gone, below, above })
    }
}
