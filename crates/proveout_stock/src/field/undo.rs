//! What a tile remembers of each change of its rays, so that it can be taken back (see `persist::history`).

use crate::field::span::SpanEnd;

/// One change of one ray: how to take it back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayChange {
    /// The item that made it.
    pub id: u32,
    /// Index of the first end that differs.
    pub at: u16,
    /// Ends there now that go.
    pub take: u16,
    /// Ends that come back, from the end of the list of ends.
    pub put: u16,
    pub ray: u8,
}

/// The log of one tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Undo {
    pub changes: Vec<RayChange>,
    /// Ends to put back, in the order of the changes.
    pub ends: Vec<SpanEnd>,
    /// A ray had more ends than the log can count.
    pub broken: bool,
}

/// History of the whole stock.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct History {
    /// One log a tile.
    pub tiles: Vec<Undo>,
    /// End of some moves: id and time, s, rising.
    pub ended: Vec<(u32, f64)>,
}

pub(crate) fn is_later(change: &RayChange, id: Option<u32>) -> bool {
    id.is_none_or(|id| change.id > id)
}

impl Undo {
    /// Remembers how a ray gets from its new ends back to the old ones; `n` and `m` are their numbers,
    /// `same(i, j)` compares an old with a new end, `old(i)` gives an old one.
    pub(crate) fn remember_change(
        &mut self,
        ray: u8,
        id: u32,
        [n, m]: [usize; 2],
        same: impl Fn(usize, usize) -> bool,
        old: impl FnMut(usize) -> SpanEnd,
    ) {
        let shorter = n.min(m);
        let first = (0..shorter).find(|&k| !same(k, k)).unwrap_or(shorter);
        let last = (0..shorter - first).find(|&k| !same(n - 1 - k, m - 1 - k)).unwrap_or(shorter - first);
        let (put, take) = (n - last - first, m - last - first);
        let small = |x: usize| u16::try_from(x);
        if let (Ok(at), Ok(take), Ok(put)) = (small(first), small(take), small(put)) {
            self.changes.push(RayChange { id, at, take, put, ray });
            self.ends.extend((first..n - last).map(old));
        } else {
            self.broken = true;
        }
    }

    /// Takes back the changes of later items than `id` (all without one), on the ends of the rays.
    pub(crate) fn back_to(&self, id: Option<u32>, rays: &mut [Vec<SpanEnd>]) {
        let mut left = self.ends.len();
        for change in self.changes.iter().rev().take_while(|c| is_later(c, id)) {
            let (at, take) = (usize::from(change.at), usize::from(change.take));
            let ends = &self.ends[left - usize::from(change.put)..left];
            left -= ends.len();
            if let Some(ray) = rays.get_mut(usize::from(change.ray)).filter(|r| at + take <= r.len()) {
                ray.splice(at..at + take, ends.iter().copied());
            }
        }
    }

    pub(crate) fn heap_bytes(&self) -> u64 {
        (self.changes.capacity() * size_of::<RayChange>() + self.ends.capacity() * size_of::<SpanEnd>()) as u64
    }
}
