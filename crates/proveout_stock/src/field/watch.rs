//! What is remembered of each change of a tile while items are carried out, where somebody asked: the way
//! back, and what the cutter was engaged in.
//!
//! The intervals before and after an item are compared, so that the watch knows nothing of how they were cut.

use crate::{
    field::engagement::{Contact, PassMotions},
    field::slices::{SliceContact, SliceTouches},
    field::span::{EndMark, SLIVER, SpanEnd},
    field::tile_field::Field,
    field::undo::Undo,
    kernels::lane_set::{LANES, LaneStrip, Lanes},
    kernels::vec3::V,
};

/// Removed intervals shorter than this (mm) are no engagement: a surface that the same body made overlaps
/// with it by the bound of the sweep, which is this long on rays at two degrees to it.
const SHAVING: f64 = 0.01;

/// The watch over one tile.
#[derive(Default)]
pub(crate) struct Watch {
    /// How to go back, when the history is kept.
    pub undo: Option<Undo>,
    /// Engagement of items, where it is asked for.
    pub contacts: Vec<(u32, Contact)>,
    /// The same by steps and slices; volumes as lengths of ray, mm.
    pub slices: Vec<SliceContact>,
    /// The layers before the item at work; the first `count` are in use.
    before: Vec<Lanes>,
    count: usize,
    /// Intervals of a ray before and after, rising.
    old: Vec<LaneStrip>,
    new: Vec<LaneStrip>,
}

impl Watch {
    pub(crate) fn new(undo: Option<Undo>) -> Self {
        Self { undo, ..Self::default() }
    }

    /// The tile is done with for now: what is only needed while items are at work goes.
    pub(crate) fn drop_buffers(&mut self) {
        (self.before, self.old, self.new) = (Vec::new(), Vec::new(), Vec::new());
    }

    /// A removing item is about to change the tile.
    pub(crate) fn before_item(&mut self, field: &Field) {
        self.count = field.layers().len();
        for (k, layer) in field.layers().iter().enumerate() {
            match self.before.get_mut(k) {
                Some(lanes) => lanes.clone_from(&layer.lanes),
                None => self.before.push(layer.lanes.clone()),
            }
        }
    }

    /// The item has changed the tile. `mark` gives what made an end (strip, upper or not) that stood there
    /// before.
    pub(crate) fn after_item(
        &mut self,
        field: &Field,
        a: usize,
        [item, id]: [u32; 2],
        moves: Option<&PassMotions>,
        mut mark: impl FnMut(&LaneStrip, bool) -> EndMark,
    ) {
        let mut contact = Contact::default();
        let mut touches = SliceTouches::default();
        for r in 0..LANES {
            let (before, after) = (&self.before[..self.count], field.layers());
            let differ = |k: usize| match (before.get(k), after.get(k).map(|layer| &layer.lanes)) {
                (Some(x), Some(y)) => x.lo[r] != y.lo[r] || x.hi[r] != y.hi[r],
                (Some(x), None) | (None, Some(x)) => x.holds(r),
                (None, None) => false,
            };
            if !(0..before.len().max(after.len())).any(differ) {
                continue;
            }
            strips(before.iter(), r, &mut self.old);
            strips(after.iter().map(|layer| &layer.lanes), r, &mut self.new);
            let (old, new) = (&self.old, &self.new);
            if old.len() == new.len() && old.iter().zip(new).all(|(x, y)| x.lo == y.lo && x.hi == y.hi) {
                continue;
            }
            if let Some(undo) = &mut self.undo {
                let same = |i: usize, j: usize| key(old, i) == key(new, j);
                let end = |i: usize| SpanEnd { s: key(old, i).0, mark: mark(&old[i / 2], i % 2 == 1) };
                undo.remember_change(r as u8, id, [2 * old.len(), 2 * new.len()], same, end);
            }
            if let Some((moves, first)) = moves.zip(old.first()) {
                let (u, v) = (first.u, first.v);
                let sorted = moves.slices_of(item);
                removed_intervals(old, new, |lo, hi| {
                    if hi - lo <= SHAVING {
                        return;
                    }
                    let at = |s: f64| moves.touch(item, to_space(a, [s, u, v]));
                    let ends = [at(lo), at(hi)];
                    if moves.contacts {
                        ends.iter().for_each(|touch| contact.add(*touch));
                    }
                    if let Some((plan, steps)) = sorted {
                        ends.iter().for_each(|touch| touches.add(plan, [id, steps], touch, 0.0));
                        let points = plan.points(hi - lo);
                        let length = (hi - lo) / points as f64;
                        for k in 0..points {
                            touches.add(plan, [id, steps], &at(lo + (k as f64 + 0.5) * length), length);
                        }
                    }
                });
            }
        }
        if contact.is_any() {
            self.contacts.push((item, contact));
        }
        self.slices.extend(touches.take(1.0));
    }
}

/// The intervals of a ray, rising: each layer holds one.
fn strips<'a>(layers: impl Iterator<Item = &'a Lanes>, r: usize, out: &mut Vec<LaneStrip>) {
    out.clear();
    out.extend(layers.take_while(|lanes| lanes.holds(r)).map(|lanes| lanes.strip(r)));
}

/// Point of space of ray coordinates of set `a`.
fn to_space(a: usize, [s, u, v]: V) -> V {
    let mut x = [0.0; 3];
    (x[a], x[(a + 1) % 3], x[(a + 2) % 3]) = (s, u, v);
    x
}

/// Height of an end, and who made it.
fn key(strips: &[LaneStrip], k: usize) -> (f64, f64) {
    let strip = &strips[k / 2];
    if k.is_multiple_of(2) { (strip.lo, strip.lo_by) } else { (strip.hi, strip.hi_by) }
}

/// What `old` had and `new` has not; `new` lies within `old`.
fn removed_intervals(old: &[LaneStrip], new: &[LaneStrip], mut piece: impl FnMut(f64, f64)) {
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

    fn strips(list: &[[f64; 2]]) -> Vec<LaneStrip> {
        let of = |&[lo, hi]: &[f64; 2]| LaneStrip {
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
        /// What is left, and what was taken.
        type Case = (&'static [[f64; 2]], &'static [[f64; 2]]);
        let cases: [Case; 5] = [
            (&[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]], &[]),
            (&[], &[[0.0, 4.0], [5.0, 6.0], [7.0, 9.0]]),
            (&[[0.0, 3.0], [7.0, 9.0]], &[[3.0, 4.0], [5.0, 6.0]]),
            (&[[0.0, 1.0], [2.0, 3.0], [5.0, 6.0], [8.0, 9.0]], &[[1.0, 2.0], [3.0, 4.0], [7.0, 8.0]]),
            (&[[1.0, 4.0], [5.5, 6.0], [7.0, 8.5]], &[[0.0, 1.0], [5.0, 5.5], [8.5, 9.0]]),
        ];
        for (new, want) in cases {
            let mut pieces = Vec::new();
            removed_intervals(&old, &strips(new), |lo, hi| pieces.push([lo, hi]));
            assert_eq!(pieces, want);
        }
    }
}
