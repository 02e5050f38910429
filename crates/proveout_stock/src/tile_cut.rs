//! Takes what the lanes say away from the material of a tile, and adds it up.
//!
//! The intervals of a layer go side by side, layers from above, so that what moves up or down has been worked on; lanes of which
//! more than one interval is taken go one by one. Sums run over sixteen columns of lanes in the order of the rays and then over the columns, so that every processor adds
//! in the same order.

use pulp::{Simd, WithSimd};

use crate::{
    lane_set::{Cut, LANES, ROW, Strip, TAKEN},
    lanes::{L, load, put, store, width},
    span::SLIVER,
    tile_field::{Field, Layer, Left, Partial},
};

/// Columns of the sums.
const COLUMNS: usize = 16;

/// Takes what the lanes of a layer say.
pub(crate) struct CutLayer<'a> {
    pub layer: &'a mut Layer,
    pub removes: bool,
    pub sum: &'a mut Partial,
    /// Rays that have been counted: not zero.
    pub counted: &'a mut [f64; LANES],
    /// Upper parts of intervals that were cut in two.
    pub torn: &'a mut Vec<Strip>,
    /// Rays whose interval is gone, one bit each.
    pub gone: &'a mut u64,
}

struct Sums {
    length: [f64; COLUMNS],
    longest: [f64; COLUMNS],
    middle: [f64; COLUMNS],
    row: [f64; COLUMNS],
    low: [f64; COLUMNS],
    high: [f64; COLUMNS],
    count: [f64; COLUMNS],
}

impl WithSimd for CutLayer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { layer, removes, sum, counted, torn, gone } = self;
        let zero = L::splat(simd, 0.0);
        let (one, taken, sliver) = (zero.same(1.0), zero.same(TAKEN), zero.same(SLIVER));
        let (none_lo, none_hi) = (zero.same(f64::INFINITY), zero.same(f64::NEG_INFINITY));
        let mut sums = Sums {
            length: [0.0; COLUMNS],
            longest: [0.0; COLUMNS],
            middle: [0.0; COLUMNS],
            row: [0.0; COLUMNS],
            low: [f64::INFINITY; COLUMNS],
            high: [f64::NEG_INFINITY; COLUMNS],
            count: [0.0; COLUMNS],
        };
        let mut met_rows = 0_u8;
        for g in 0..LANES / width::<S>() {
            let lanes = &mut layer.lanes;
            if !lanes.asks::<S>(g) {
                continue;
            }
            let state = load(simd, &lanes.state, g);
            let (lo, hi) = (load(simd, &lanes.lo, g), load(simd, &lanes.hi, g));
            let from = load(simd, &lanes.from, g).max(lo);
            let to = load(simd, &lanes.to, g).min(hi);
            let overlap = to - from;
            let met = state.ge(taken) & state.le(taken) & overlap.gt(sliver);
            if !met.any() {
                continue;
            }
            let row = g * width::<S>() / ROW;
            met_rows |= 1 << row;
            let (left_below, left_above) = (from - lo, hi - to);
            let (below, above) = (met & left_below.gt(sliver), met & left_above.gt(sliver));
            let taken_away = hi - lo - below.select(left_below, zero) - above.select(left_above, zero);
            let c = g % (COLUMNS / width::<S>());
            let length = load(simd, &sums.length, c);
            store(&mut sums.length, c, length + met.select(taken_away, zero));
            let longer = met & overlap.gt(load(simd, &sums.longest, c));
            put(c, &mut sums.longest, longer, overlap);
            put(c, &mut sums.middle, longer, zero.same(0.5) * (from + to));
            put(c, &mut sums.row, longer, zero.same(row as f64));
            let low = load(simd, &sums.low, c);
            put(c, &mut sums.low, met & from.lt(low), from);
            let high = load(simd, &sums.high, c);
            put(c, &mut sums.high, met & to.gt(high), to);
            let count = load(simd, &sums.count, c);
            let before = load(simd, counted, g);
            store(&mut sums.count, c, count + met.select(one - before, zero));
            store(counted, g, met.select(one, before));
            if !removes {
                continue;
            }
            let divided = below & above;
            if divided.any() {
                let mut which = [0.0; ROW];
                store(&mut which, 0, divided.select(one, zero));
                for (i, _) in which.iter().enumerate().take(width::<S>()).filter(|w| *w.1 > 0.0) {
                    let k = g * width::<S>() + i;
                    let lower = lanes.strip(k);
                    torn.push(Strip { lo: lanes.to[k], lo_by: lanes.to_by[k], lo_tau: lanes.to_tau[k], ..lower });
                }
            }
            let upper = above & !below;
            let whole = met & !(below | above);
            let (from_by, to_by) = (load(simd, &lanes.from_by, g), load(simd, &lanes.to_by, g));
            let (from_tau, to_tau) = (load(simd, &lanes.from_tau, g), load(simd, &lanes.to_tau, g));
            put(g, &mut lanes.hi_by, below, from_by);
            put(g, &mut lanes.hi_tau, below, from_tau);
            put(g, &mut lanes.lo_by, upper, to_by);
            put(g, &mut lanes.lo_tau, upper, to_tau);
            store(&mut lanes.hi, g, whole.select(none_hi, below.select(from, hi)));
            store(&mut lanes.lo, g, whole.select(none_lo, upper.select(to, lo)));
            if whole.any() {
                let mut which = [0.0; ROW];
                store(&mut which, 0, whole.select(one, zero));
                for (i, &w) in which.iter().enumerate() {
                    *gone |= u64::from(w > 0.0) << (g * width::<S>() + i);
                }
            }
        }
        if met_rows == 0 {
            return;
        }
        if removes {
            for row in (0..ROW).filter(|row| met_rows >> row & 1 == 1) {
                let (mut lo, mut hi) = (none_lo, none_hi);
                for g in row * ROW / width::<S>()..(row + 1) * ROW / width::<S>() {
                    lo = load(simd, &layer.lanes.lo, g).min(lo);
                    hi = load(simd, &layer.lanes.hi, g).max(hi);
                }
                (layer.row_lo[row], layer.row_hi[row]) = (lo.lowest(), hi.highest());
            }
        }
        add(&sums, met_rows, sum);
    }
}

/// Adds the columns to what the item met.
#[inline(always)]
fn add(sums: &Sums, met_rows: u8, sum: &mut Partial) {
    let (mut count, mut length) = (0.0, 0.0);
    for c in 0..ROW {
        count += sums.count[c] + sums.count[c + ROW];
        length += sums.length[c] + sums.length[c + ROW];
        sum.range[0] = if sums.low[c] < sum.range[0] { sums.low[c] } else { sum.range[0] };
        sum.range[0] = if sums.low[c + ROW] < sum.range[0] { sums.low[c + ROW] } else { sum.range[0] };
        sum.range[1] = if sums.high[c] > sum.range[1] { sums.high[c] } else { sum.range[1] };
        sum.range[1] = if sums.high[c + ROW] > sum.range[1] { sums.high[c + ROW] } else { sum.range[1] };
        sum.columns |= u8::from(sums.longest[c] > 0.0 || sums.longest[c + ROW] > 0.0) << c;
    }
    sum.rays += count as u32;
    sum.length += length;
    sum.rows |= met_rows;
    for (c, &longest) in sums.longest.iter().enumerate() {
        if longest > 0.0 && longest >= sum.longest {
            sum.offer(longest, sums.middle[c], (sums.row[c] as usize * ROW + c % ROW) as u8);
        }
    }
}

/// Takes one interval from one lane.
pub(crate) fn cut_lane(
    field: &mut Field,
    (k, r): (usize, usize),
    cut: &Cut,
    removes: bool,
    sum: &mut Partial,
    counted: &mut [f64; LANES],
) {
    let layer = &mut field.layers_mut()[k];
    let strip = layer.lanes.strip(r);
    let Some(left) = Left::of(&strip, cut) else { return };
    sum.rays += u32::from(counted[r] == 0.0);
    counted[r] = 1.0;
    sum.add(&strip, left.met, left.gone);
    if !removes {
        return;
    }
    match (left.below, left.above) {
        (Some(below), above) => {
            layer.lanes.set(r, &below);
            layer.measure_row(r / ROW);
            if let Some(above) = above {
                field.insert_above(k, &above);
            }
        }
        (None, Some(above)) => {
            layer.lanes.set(r, &above);
            layer.measure_row(r / ROW);
        }
        (None, None) => field.close(k, r),
    }
}
