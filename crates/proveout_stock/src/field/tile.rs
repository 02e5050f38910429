//! Rays of one tile in one arena.

use crate::{field::grid::TILE_RAYS, field::span::MaterialSpan};

/// The intervals of [`TILE_RAYS`] rays, one after the other in a single list.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Ray `r` has the spans `start[r]..start[r + 1]`.
    start: [u32; TILE_RAYS + 1],
    spans: Vec<MaterialSpan>,
    /// Lowest and highest end of any span; empty tile: lo > hi.
    pub lo: f64,
    pub hi: f64,
}

impl Default for Tile {
    fn default() -> Self {
        Self { start: [0; TILE_RAYS + 1], spans: Vec::new(), lo: f64::INFINITY, hi: f64::NEG_INFINITY }
    }
}

impl Tile {
    /// Takes the spans of all rays, in rising order each: `add(ray, list)` appends those of a ray.
    pub(crate) fn from_rays(mut add: impl FnMut(usize, &mut Vec<MaterialSpan>)) -> Self {
        let mut tile = Self { spans: Vec::with_capacity(TILE_RAYS), ..Self::default() };
        for r in 0..TILE_RAYS {
            add(r, &mut tile.spans);
            tile.start[r + 1] = tile.spans.len() as u32;
        }
        tile.spans.shrink_to_fit();
        tile.update_range();
        tile
    }

    /// Rewrites all rays: `add(ray, before, list)` appends the spans of a ray, given those that it
    /// had. `buffer` holds them until all are known.
    pub(crate) fn rewrite(
        &mut self,
        buffer: &mut Vec<MaterialSpan>,
        mut add: impl FnMut(usize, &[MaterialSpan], &mut Vec<MaterialSpan>),
    ) {
        buffer.clear();
        let mut first = 0;
        for r in 0..TILE_RAYS {
            let last = self.start[r + 1] as usize;
            add(r, self.spans.get(first..last).unwrap_or(&[]), buffer);
            first = last;
            self.start[r + 1] = buffer.len() as u32;
        }
        // Memory stays near what is held: grown by an eighth, so that a tile that gains an interval now and
        // then is not moved each time, and given back when less than half is in use.
        let (need, have) = (buffer.len(), self.spans.capacity());
        if need > have || need < have / 2 {
            self.spans = Vec::with_capacity(if need > have { need + need / 8 } else { need });
        } else {
            self.spans.clear();
        }
        self.spans.extend_from_slice(buffer);
        self.update_range();
    }

    /// Takes the spans of all rays, and keeps room for so many.
    pub(crate) fn with_room(room: usize, rays: Vec<Vec<MaterialSpan>>) -> Self {
        let mut tile = Self { spans: Vec::with_capacity(room), ..Self::default() };
        for (r, spans) in rays.into_iter().take(TILE_RAYS).enumerate() {
            tile.spans.extend(spans);
            tile.start[r + 1] = tile.spans.len() as u32;
        }
        tile.update_range();
        tile
    }

    /// Spans that there is room for.
    pub(crate) fn room(&self) -> usize {
        self.spans.capacity()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    pub(crate) fn ray(&self, r: usize) -> &[MaterialSpan] {
        &self.spans[self.start[r] as usize..self.start[r + 1] as usize]
    }

    /// Number of the first span of a ray in the order of the tile.
    pub(crate) fn first(&self, r: usize) -> usize {
        self.start[r] as usize
    }

    fn update_range(&mut self) {
        (self.lo, self.hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for s in &self.spans {
            self.lo = self.lo.min(s.lo);
            self.hi = self.hi.max(s.hi);
        }
    }

    /// Number of interval ends.
    pub(crate) fn ends(&self) -> usize {
        2 * self.spans.len()
    }

    /// Total length of material, mm, added in the order of the rays.
    pub(crate) fn length(&self) -> f64 {
        self.spans.iter().map(|s| s.hi - s.lo).sum()
    }

    /// Memory on the heap, bytes.
    pub(crate) fn heap_bytes(&self) -> u64 {
        (self.spans.capacity() * size_of::<MaterialSpan>()) as u64
    }
}
