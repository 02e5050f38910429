//! What is remembered of each change of a ray while items are carried out, where somebody asked.

use crate::{
    history::Undo,
    span::{SLIVER, Span},
};

/// Material that one item took from one ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Removed {
    /// Ray within the tile.
    pub ray: u8,
    pub lo: f64,
    pub hi: f64,
}

/// The watch over one tile. A tile that nobody watches costs two comparisons a change.
#[derive(Default)]
pub(crate) struct Watch {
    /// How to go back, when the history is kept.
    pub undo: Option<Undo>,
    /// What the item at work has taken, when engagement is asked for.
    pub removed: Option<Vec<Removed>>,
    before: Vec<Span>,
}

impl Watch {
    pub(crate) fn new(undo: Option<Undo>, engagement: bool) -> Self {
        Self { undo, removed: engagement.then(Vec::new), before: Vec::new() }
    }

    /// A ray is about to change.
    #[inline]
    pub(crate) fn before(&mut self, spans: &[Span]) {
        if self.undo.is_some() || self.removed.is_some() {
            self.before.clear();
            self.before.extend_from_slice(spans);
        }
    }

    /// The ray that was told last has changed by the item `id`.
    #[inline]
    pub(crate) fn after(&mut self, ray: usize, id: u32, spans: &[Span]) {
        if let Some(undo) = &mut self.undo {
            undo.note(ray, id, &self.before, spans);
        }
        if let Some(removed) = &mut self.removed {
            taken(&self.before, spans, |lo, hi| removed.push(Removed { ray: ray as u8, lo, hi }));
        }
    }
}

/// What `old` had and `new` has not; `new` lies within `old`.
fn taken(old: &[Span], new: &[Span], mut piece: impl FnMut(f64, f64)) {
    let mut k = 0;
    for span in old {
        let mut from = span.lo;
        while let Some(left) = new.get(k).filter(|n| n.lo < span.hi) {
            if left.lo - from > SLIVER {
                piece(from, left.lo);
            }
            from = left.hi;
            k += 1;
        }
        if span.hi - from > SLIVER {
            piece(from, span.hi);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::span::{INITIAL, Mark};

    fn spans(list: &[[f64; 2]]) -> Vec<Span> {
        let mark = Mark::new(INITIAL, [0.0, 0.0, 1.0]);
        list.iter().map(|&[lo, hi]| Span { lo, hi, lo_mark: mark, hi_mark: mark }).collect()
    }

    #[test]
    fn what_was_taken_is_old_less_new() {
        let old = spans(&[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]]);
        let cases: [(&[[f64; 2]], &[[f64; 2]]); 5] = [
            (&[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]], &[]),
            (&[], &[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]]),
            (&[[0.0, 3.0], [7.0, 9.0]], &[[3.0, 4.0], [5.0, 6.0]]),
            (&[[0.0, 1.0], [2.0, 3.0], [5.0, 6.0], [8.0, 9.0]], &[[1.0, 2.0], [3.0, 4.0], [7.0, 8.0]]),
            (&[[1.0, 4.0], [5.5, 6.0], [7.0, 8.5]], &[[0.0, 1.0], [5.0, 5.5], [8.5, 9.0]]),
        ];
        for (new, want) in cases {
            let mut pieces = Vec::new();
            taken(&old, &spans(new), |lo, hi| pieces.push([lo, hi]));
            assert_eq!(pieces, want);
        }
    }
}
