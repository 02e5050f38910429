//! Rays of one tile in one arena.

use crate::{
    grid::TILE_RAYS,
    span::{SLIVER, Span},
};

/// The intervals of [`TILE_RAYS`] rays, one after the other in a single list.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Ray `r` has the spans `start[r]..start[r + 1]`.
    start: [u32; TILE_RAYS + 1],
    spans: Vec<Span>,
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
    /// Takes the spans of all rays, each in rising order.
    pub(crate) fn from_rays(rays: impl IntoIterator<Item = Vec<Span>>) -> Self {
        let mut tile = Self::default();
        for (r, spans) in rays.into_iter().enumerate().take(TILE_RAYS) {
            tile.spans.extend(spans);
            tile.start[r + 1] = tile.spans.len() as u32;
        }
        tile.spans.shrink_to_fit();
        tile.update_range();
        tile
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    pub(crate) fn ray(&self, r: usize) -> &[Span] {
        &self.spans[self.start[r] as usize..self.start[r + 1] as usize]
    }

    /// The span of a ray that has exactly one.
    pub(crate) fn only_span(&mut self, r: usize) -> Option<&mut Span> {
        let (from, to) = (self.start[r] as usize, self.start[r + 1] as usize);
        if to - from == 1 { self.spans.get_mut(from) } else { None }
    }

    /// Replaces the spans of one ray.
    pub(crate) fn replace(&mut self, r: usize, new: &[Span]) {
        let (from, to) = (self.start[r] as usize, self.start[r + 1] as usize);
        if new.len() == to - from {
            self.spans[from..to].copy_from_slice(new);
            return;
        }
        self.spans.splice(from..to, new.iter().copied());
        let old = (to - from) as u32;
        for s in &mut self.start[r + 1..] {
            *s = *s - old + new.len() as u32;
        }
    }

    /// Changes marks of all spans; heights must stay.
    pub(crate) fn update_spans(&mut self, change: impl FnMut(&mut Span)) {
        self.spans.iter_mut().for_each(change);
    }

    pub(crate) fn update_range(&mut self) {
        (self.lo, self.hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for s in &self.spans {
            self.lo = self.lo.min(s.lo);
            self.hi = self.hi.max(s.hi);
        }
    }

    /// Total length of material, mm, added in the order of the rays.
    pub(crate) fn length(&self) -> f64 {
        self.spans.iter().map(|s| s.hi - s.lo).sum()
    }

    /// Memory on the heap, bytes.
    pub(crate) fn heap_bytes(&self) -> u64 {
        (self.spans.capacity() * size_of::<Span>()) as u64
    }
}

/// An interval of a ray that a body takes up, with the marks that it would leave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub lo: f64,
    pub hi: f64,
    /// Mark for the material below `lo` and above `hi`.
    pub lo_mark: crate::span::Mark,
    pub hi_mark: crate::span::Mark,
}

/// What a cut does to one ray.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Overlap {
    /// Length of material in the cuts, mm.
    pub length: f64,
    /// Longest connected piece of it, and its middle, mm.
    pub longest: f64,
    pub middle: f64,
    /// Range of all pieces, mm.
    pub lo: f64,
    pub hi: f64,
}

/// Finds the overlap of `spans` with `cuts` (both rising and disjoint) and writes what is left to `left`.
pub(crate) fn subtract(spans: &[Span], cuts: &[Cut], left: &mut Vec<Span>) -> Overlap {
    let mut all = Overlap { lo: f64::INFINITY, hi: f64::NEG_INFINITY, ..Overlap::default() };
    left.clear();
    for span in spans {
        let mut rest = *span;
        let mut gone = false;
        for cut in cuts {
            let (lo, hi) = (cut.lo.max(rest.lo), cut.hi.min(rest.hi));
            if hi - lo <= SLIVER {
                continue;
            }
            if hi - lo > all.longest {
                (all.longest, all.middle) = (hi - lo, 0.5 * (lo + hi));
            }
            (all.lo, all.hi) = (all.lo.min(lo), all.hi.max(hi));
            let below = Span { hi: lo, hi_mark: cut.lo_mark, ..rest };
            if lo - rest.lo > SLIVER {
                left.push(below);
                all.length -= below.hi - below.lo;
            }
            if rest.hi - hi > SLIVER {
                rest.lo = hi;
                rest.lo_mark = cut.hi_mark;
            } else {
                gone = true;
                break;
            }
        }
        if all.longest > 0.0 {
            all.length += span.hi - span.lo;
            if !gone {
                all.length -= rest.hi - rest.lo;
            }
        }
        if !gone {
            left.push(rest);
        }
    }
    all
}
