//! Takes what the lanes say away from the material of a tile, and adds it up.
//!
//! The lowest intervals of all rays go side by side; those further up, and rays of which more than one interval is taken, one by
//! one. Sums run over sixteen columns of lanes in the order of the rays and then over the columns, so that every processor adds
//! in the same order.

use pulp::{Simd, WithSimd};

use crate::{
    lane_set::{Cut, LANES, MET, ROW, Strip, TAKEN},
    lanes::{L, load, put, store, width},
    span::SLIVER,
    tile_field::{Field, Left, Partial},
};

/// Columns of the sums.
const COLUMNS: usize = 16;

/// Takes what the lanes of the lowest intervals say.
pub(crate) struct CutFirst<'a> {
    pub field: &'a mut Field,
    pub removes: bool,
    pub sum: &'a mut Partial,
    /// Upper parts of intervals that were cut in two.
    pub torn: &'a mut Vec<Strip>,
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

impl WithSimd for CutFirst<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { field, removes, sum, torn } = self;
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
            let lanes = &mut field.first;
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
            let gone = hi - lo - below.select(left_below, zero) - above.select(left_above, zero);
            let c = g % (COLUMNS / width::<S>());
            let length = load(simd, &sums.length, c);
            store(&mut sums.length, c, length + met.select(gone, zero));
            let longer = met & overlap.gt(load(simd, &sums.longest, c));
            put(c, &mut sums.longest, longer, overlap);
            put(c, &mut sums.middle, longer, zero.same(0.5) * (from + to));
            put(c, &mut sums.row, longer, zero.same(row as f64));
            let low = load(simd, &sums.low, c);
            put(c, &mut sums.low, met & from.lt(low), from);
            let high = load(simd, &sums.high, c);
            put(c, &mut sums.high, met & to.gt(high), to);
            let count = load(simd, &sums.count, c);
            store(&mut sums.count, c, count + met.select(one, zero));
            put(g, &mut lanes.state, met, zero.same(MET));
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
            field.torn |= field.has_many() && whole.any();
        }
        if met_rows == 0 {
            return;
        }
        if removes {
            field.changed = true;
            for row in (0..ROW).filter(|row| met_rows >> row & 1 == 1) {
                let (mut lo, mut hi) = (none_lo, none_hi);
                for g in row * ROW / width::<S>()..(row + 1) * ROW / width::<S>() {
                    lo = load(simd, &field.first.lo, g).min(lo);
                    hi = load(simd, &field.first.hi, g).max(hi);
                }
                (field.row_lo[row], field.row_hi[row]) = (lo.lowest(), hi.highest());
            }
        }
        add(&sums, met_rows, field, sum);
    }
}

/// Adds the columns to what the item met.
#[inline(always)]
fn add(sums: &Sums, met_rows: u8, field: &Field, sum: &mut Partial) {
    let mut columns = [0.0; ROW];
    for (c, &count) in sums.count.iter().enumerate() {
        columns[c % ROW] += count;
    }
    let (mut count, mut length) = (0.0, 0.0);
    for c in 0..ROW {
        count += columns[c];
        length += sums.length[c] + sums.length[c + ROW];
        sum.range[0] = if sums.low[c] < sum.range[0] { sums.low[c] } else { sum.range[0] };
        sum.range[0] = if sums.low[c + ROW] < sum.range[0] { sums.low[c + ROW] } else { sum.range[0] };
        sum.range[1] = if sums.high[c] > sum.range[1] { sums.high[c] } else { sum.range[1] };
        sum.range[1] = if sums.high[c + ROW] > sum.range[1] { sums.high[c + ROW] } else { sum.range[1] };
        if columns[c] > 0.0 {
            let u = field.first.u[c];
            sum.u = [sum.u[0].min(u), sum.u[1].max(u)];
        }
    }
    sum.rays += count as u32;
    sum.length += length;
    let rows = [met_rows.trailing_zeros() as usize, 7 - met_rows.leading_zeros() as usize];
    sum.v = [sum.v[0].min(field.row_v[rows[0]]), sum.v[1].max(field.row_v[rows[1]])];
    for (c, &longest) in sums.longest.iter().enumerate() {
        if longest > 0.0 && longest >= sum.longest {
            let ray = sums.row[c] as usize * ROW + c % ROW;
            if longest > sum.longest || ray < sum.ray {
                (sum.longest, sum.ray) = (longest, ray);
                sum.at = [sums.middle[c], field.first.u[ray], field.first.v[ray]];
            }
        }
    }
}

/// Takes what the lanes of the other intervals say.
pub(crate) fn cut_more(field: &mut Field, removes: bool, sum: &mut Partial, torn: &mut Vec<Strip>, counted: &mut u64) {
    for b in 0..field.more.len() {
        for k in 0..field.more[b].len() {
            if field.more[b].state[k] == TAKEN {
                let cut = field.more[b].cut(k);
                cut_lane(field, Some(b), k, &cut, removes, sum, torn, counted);
            }
        }
    }
}

/// Takes one interval from one lane (of `more[block]`, or of the lowest intervals).
#[allow(clippy::too_many_arguments, reason = "one step of the two loops above")]
pub(crate) fn cut_lane(
    field: &mut Field,
    block: Option<usize>,
    k: usize,
    cut: &Cut,
    removes: bool,
    sum: &mut Partial,
    torn: &mut Vec<Strip>,
    counted: &mut u64,
) {
    let lanes = match block {
        Some(b) => &mut field.more[b],
        None => &mut field.first,
    };
    let strip = lanes.strip(k);
    let Some(left) = Left::of(&strip, cut) else { return };
    if *counted >> strip.ray & 1 == 0 {
        *counted |= 1 << strip.ray;
        sum.rays += 1;
    }
    sum.add(&strip, left.met, left.gone);
    if !removes {
        return;
    }
    field.changed = true;
    match (left.below, left.above) {
        (Some(below), above) => {
            lanes.set(k, &below);
            torn.extend(above);
        }
        (None, Some(above)) => lanes.set(k, &above),
        (None, None) => {
            lanes.remove(k);
            field.torn |= field.has_many();
        }
    }
    if block.is_none() {
        field.measure_row(k / ROW);
    }
}
