//! What is remembered of each change of a tile while items are carried out, where somebody asked: the way back, and what the
//! cutter was engaged in.
//!
//! The intervals before and after an item are compared, so that the watch knows nothing of how they were cut.

use crate::{
    contact::{Contact, Moves},
    history::Undo,
    lane_set::{LANES, Strip},
    span::{End, Mark, SLIVER},
    tile_field::Field,
    vec3::V,
};

/// Removed intervals shorter than this (mm) are no engagement: a surface that the same body made overlaps with it by the bound
/// of the sweep, which is this long on rays at two degrees to it.
const SHAVING: f64 = 0.01;

/// The watch over one tile.
#[derive(Default)]
pub(crate) struct Watch {
    /// How to go back, when the history is kept.
    pub undo: Option<Undo>,
    /// Engagement of items, where it is asked for.
    pub contacts: Vec<(u32, Contact)>,
    /// Intervals before the item at work, in the order of the rays, rising.
    before: Vec<Strip>,
    after: Vec<Strip>,
}

impl Watch {
    pub(crate) fn new(undo: Option<Undo>) -> Self {
        Self { undo, ..Self::default() }
    }

    /// A removing item is about to change the tile.
    pub(crate) fn before(&mut self, field: &Field) {
        strips(field, &mut self.before);
    }

    /// The item has changed the tile. `mark` gives what made an end (strip, upper or not) that stood there before.
    pub(crate) fn after(
        &mut self,
        field: &Field,
        a: usize,
        [item, id]: [u32; 2],
        moves: Option<&Moves>,
        mut mark: impl FnMut(&Strip, bool) -> Mark,
    ) {
        strips(field, &mut self.after);
        let mut contact = Contact::default();
        let (mut k, mut m) = (0, 0);
        while k < self.before.len() {
            let ray = self.before[k].ray;
            let old = run(&self.before[k..], ray);
            let new = run(&self.after[m..], ray);
            (k, m) = (k + old.len(), m + new.len());
            if old.len() == new.len() && old.iter().zip(new).all(|(x, y)| x.lo == y.lo && x.hi == y.hi) {
                continue;
            }
            if let Some(undo) = &mut self.undo {
                let same = |i: usize, j: usize| key(old, i) == key(new, j);
                let end = |i: usize| End { s: key(old, i).0, mark: mark(&old[i / 2], i % 2 == 1) };
                undo.note(ray, id, [2 * old.len(), 2 * new.len()], same, end);
            }
            if let Some(moves) = moves {
                let (u, v) = (old[0].u, old[0].v);
                taken(old, new, |lo, hi| {
                    if hi - lo > SHAVING {
                        contact.add(moves.touch(item, in_space(a, [lo, u, v])));
                        contact.add(moves.touch(item, in_space(a, [hi, u, v])));
                    }
                });
            }
        }
        if moves.is_some() && contact.is_any() {
            self.contacts.push((item, contact));
        }
    }
}

/// Point of space of ray coordinates of set `a`.
fn in_space(a: usize, [s, u, v]: V) -> V {
    let mut x = [0.0; 3];
    (x[a], x[(a + 1) % 3], x[(a + 2) % 3]) = (s, u, v);
    x
}

/// Height of an end, and who made it.
fn key(strips: &[Strip], k: usize) -> (f64, f64) {
    let strip = &strips[k / 2];
    if k % 2 == 0 { (strip.lo, strip.lo_by) } else { (strip.hi, strip.hi_by) }
}

/// All intervals of a field in the order of the rays, rising.
fn strips(field: &Field, out: &mut Vec<Strip>) {
    out.clear();
    for r in 0..LANES {
        let held = field.layers().iter().map(|layer| &layer.lanes).take_while(|lanes| lanes.holds(r));
        out.extend(held.map(|lanes| lanes.strip(r)));
    }
}

/// The intervals of a ray at the begin of a list.
fn run(strips: &[Strip], ray: u8) -> &[Strip] {
    &strips[..strips.iter().take_while(|s| s.ray == ray).count()]
}

/// What `old` had and `new` has not; `new` lies within `old`.
fn taken(old: &[Strip], new: &[Strip], mut piece: impl FnMut(f64, f64)) {
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

    fn strips(list: &[[f64; 2]]) -> Vec<Strip> {
        let of = |&[lo, hi]: &[f64; 2]| Strip {
            ray: 0,
            u: 0.0,
            v: 0.0,
            lo,
            hi,
            lo_by: 0.0,
            hi_by: 0.0,
            lo_tau: 0.0,
            hi_tau: 0.0,
        };
        list.iter().map(of).collect()
    }

    #[test]
    fn what_was_taken_is_old_less_new() {
        let old = strips(&[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]]);
        let cases: [(&[[f64; 2]], &[[f64; 2]]); 5] = [
            (&[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]], &[]),
            (&[], &[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]]),
            (&[[0.0, 3.0], [7.0, 9.0]], &[[3.0, 4.0], [5.0, 6.0]]),
            (&[[0.0, 1.0], [2.0, 3.0], [5.0, 6.0], [8.0, 9.0]], &[[1.0, 2.0], [3.0, 4.0], [7.0, 8.0]]),
            (&[[1.0, 4.0], [5.5, 6.0], [7.0, 8.5]], &[[0.0, 1.0], [5.0, 5.5], [8.5, 9.0]]),
        ];
        for (new, want) in cases {
            let mut pieces = Vec::new();
            taken(&old, &strips(new), |lo, hi| pieces.push([lo, hi]));
            assert_eq!(pieces, want);
        }
    }
}
