//! Takes what the lanes say away from the material of a tile, and adds it up.
//!
//! The intervals of a layer go side by side, layers from above, so that what moves up or down has been worked
//! on; lanes of which more than one interval is taken go one by one. Sums run over sixteen columns of lanes
//! in the order of the rays and then over the columns, so that every processor adds in the same order.

use pulp::{Simd, WithSimd};

use crate::{
    field::span::SLIVER,
    field::tile_field::{Field, IntervalLayer, StripRest, TileOverlap},
    kernels::lane_bits::ROW,
    kernels::lane_set::{LANES, LaneCut, LaneStrip, TAKEN, WIDE},
    kernels::lanes::{L, Mask, highest, load, lowest, put, store, width},
};

/// Columns of the sums.
const COLUMNS: usize = 16;

/// Takes what the lanes of a layer say.
pub(crate) struct CutLayer<'a> {
    pub layer: &'a mut IntervalLayer,
    pub removes: bool,
    pub sum: &'a mut TileOverlap,
    /// Rays that have been counted: not zero.
    pub counted: &'a mut [f64; LANES],
    /// Upper parts of intervals that were cut in two.
    pub torn: &'a mut Vec<LaneStrip>,
    /// Rays whose interval is gone, one bit each.
    pub gone: &'a mut u64,
}

struct CutSums {
    length: [f64; COLUMNS],
    longest: [f64; COLUMNS],
    middle: [f64; COLUMNS],
    /// Rays before those of the columns that the longest lies in, in columns.
    lap: [f64; COLUMNS],
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
        let mut sums = CutSums {
            length: [0.0; COLUMNS],
            longest: [0.0; COLUMNS],
            middle: [0.0; COLUMNS],
            lap: [0.0; COLUMNS],
            low: [f64::INFINITY; COLUMNS],
            high: [f64::NEG_INFINITY; COLUMNS],
            count: [0.0; COLUMNS],
        };
        let mut met_rows = 0_u8;
        for g in 0..LANES / width::<S>() {
            let lanes = &mut layer.lanes;
            if !lanes.requests_any::<S>(g) {
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
            met_rows |= rows(met, g);
            let (left_below, left_above) = (from - lo, hi - to);
            let (below, above) = (met & left_below.gt(sliver), met & left_above.gt(sliver));
            let taken_away = hi - lo - below.select(left_below, zero) - above.select(left_above, zero);
            let c = g % (COLUMNS / width::<S>());
            let length = load(simd, &sums.length, c);
            store(&mut sums.length, c, length + met.select(taken_away, zero));
            let longer = met & overlap.gt(load(simd, &sums.longest, c));
            put(c, &mut sums.longest, longer, overlap);
            put(c, &mut sums.middle, longer, zero.same(0.5) * (from + to));
            put(c, &mut sums.lap, longer, zero.same((g * width::<S>() / COLUMNS) as f64));
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
                let mut which = [0.0; WIDE];
                store(&mut which, 0, divided.select(one, zero));
                for (i, _) in which.iter().enumerate().take(width::<S>()).filter(|w| *w.1 > 0.0) {
                    let k = g * width::<S>() + i;
                    let lower = lanes.strip(k);
                    torn.push(LaneStrip { lo: lanes.to[k], lo_by: lanes.to_by[k], lo_tau: lanes.to_tau[k], ..lower });
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
                let mut which = [0.0; WIDE];
                store(&mut which, 0, whole.select(one, zero));
                for (i, &w) in which.iter().enumerate().take(width::<S>()) {
                    *gone |= u64::from(w > 0.0) << (g * width::<S>() + i);
                }
            }
        }
        if met_rows == 0 {
            return;
        }
        if removes {
            for row in (0..ROW).filter(|row| met_rows >> row & 1 == 1) {
                let all = row * ROW..(row + 1) * ROW;
                layer.row_lo[row] = lowest(simd, &layer.lanes.lo[all.clone()]);
                layer.row_hi[row] = highest(simd, &layer.lanes.hi[all]);
            }
            // Two rows to a pair.
            let pairs = met_rows | met_rows >> 1;
            layer.unmeasured |= pairs & 1 | pairs >> 1 & 2 | pairs >> 2 & 4 | pairs >> 3 & 8;
        }
        add(&sums, met_rows, sum);
    }
}

/// Rows that vector `g` has lanes of where the condition holds, one bit each.
#[inline(always)]
fn rows<S: Simd>(met: Mask<S>, g: usize) -> u8 {
    let row = g * width::<S>() / ROW;
    if width::<S>() > ROW {
        let [first, second] = met.any_of_halves();
        u8::from(first) << row | u8::from(second) << (row + 1)
    } else {
        1 << row
    }
}

/// Adds the columns to what the item met.
#[inline(always)]
fn add(sums: &CutSums, met_rows: u8, sum: &mut TileOverlap) {
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
            sum.note_longest(longest, sums.middle[c], (sums.lap[c] as usize * COLUMNS + c) as u8);
        }
    }
}

/// Takes one interval from one lane; true when nothing of its interval is left.
pub(crate) fn cut_lane(
    field: &mut Field,
    (k, r): (usize, usize),
    cut: &LaneCut,
    removes: bool,
    sum: &mut TileOverlap,
    counted: &mut [f64; LANES],
) -> bool {
    let layer = &mut field.layers_mut()[k];
    let strip = layer.lanes.strip(r);
    let Some(left) = StripRest::of(&strip, cut) else { return false };
    sum.rays += u32::from(counted[r] == 0.0);
    counted[r] = 1.0;
    sum.add(&strip, left.met, left.gone);
    if !removes {
        return false;
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
        (None, None) => {
            field.close_gap(k, r);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::*;
    use crate::kernels::lane_set::OLD;

    fn number(k: usize, salt: f64) -> f64 {
        ((k as f64 * 12.9898 + salt * 78.233).sin() * 43758.5453).fract().abs()
    }

    /// A layer with gaps, and what is to be taken: nothing, a part below, above or within, or all.
    fn layer(round: usize) -> IntervalLayer {
        let mut layer = IntervalLayer::default();
        for r in 0..LANES {
            let n = |salt: f64| number(round * LANES + r, salt);
            let (lo, hi) = if n(1.0) < 0.2 { (f64::INFINITY, f64::NEG_INFINITY) } else { (n(2.0), 1.0 + n(3.0)) };
            let (u, v) = ((r % ROW) as f64, (r / ROW) as f64);
            layer
                .lanes
                .set(r, &LaneStrip { ray: r as u8, u, v, lo, hi, lo_by: OLD, hi_by: OLD, lo_tau: 0.0, hi_tau: 0.0 });
        }
        for row in (0..ROW).filter(|row| number(round * ROW + row, 4.0) < 0.8) {
            layer.lanes.request_row(row);
            for r in row * ROW..(row + 1) * ROW {
                let n = |salt: f64| number(round * LANES + r, salt);
                let from = 2.5 * n(5.0) - 0.5;
                let cut =
                    LaneCut { from, to: from + n(6.0), from_by: 3.0, to_by: 4.0, from_tau: n(7.0), to_tau: n(8.0) };
                layer.lanes.answer(r, (n(9.0) < 0.7).then_some(&cut));
            }
        }
        for row in 0..ROW {
            layer.measure_row(row);
        }
        layer
    }

    #[test]
    fn lanes_lose_what_single_strips_lose_on_any_processor() {
        let (mut whole, mut divided) = (0, 0);
        for round in 0..200 {
            let run = |wide: bool| {
                let mut cut = layer(round);
                let (mut sum, mut counted, mut torn, mut gone) = (TileOverlap::new(0), [0.0; LANES], Vec::new(), 0);
                let call = CutLayer {
                    layer: &mut cut,
                    removes: true,
                    sum: &mut sum,
                    counted: &mut counted,
                    torn: &mut torn,
                    gone: &mut gone,
                };
                if wide {
                    Arch::new().dispatch(call)
                } else {
                    call.with_simd(pulp::Scalar::new())
                }
                (cut, sum, torn, gone)
            };
            let ((cut, sum, torn, gone), other) = (run(true), run(false));
            let text = |s: &(IntervalLayer, TileOverlap, Vec<LaneStrip>, u64)| {
                format!("{:?} {:?} {:?} {}", s.1, s.2, s.0.row_lo, s.3)
            };
            let bits =
                |l: &IntervalLayer| l.lanes.lo.iter().chain(&l.lanes.hi).map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&cut), bits(&other.0));
            let before = layer(round);
            let mut want = TileOverlap::new(0);
            for r in 0..LANES {
                let (strip, left) = (before.lanes.strip(r), cut.lanes.strip(r));
                let taken = before.lanes.state[r] == TAKEN;
                let Some(one) = taken.then(|| StripRest::of(&strip, &before.lanes.cut(r))).flatten() else {
                    assert_eq!((left.lo.to_bits(), left.hi.to_bits()), (strip.lo.to_bits(), strip.hi.to_bits()));
                    continue;
                };
                want.rays += 1;
                want.add(&strip, one.met, one.gone);
                match (one.below, one.above) {
                    (None, None) => {
                        whole += 1;
                        assert!(!cut.lanes.holds(r) && gone >> r & 1 == 1);
                    }
                    (Some(below), above) => {
                        assert_eq!((left.lo, left.hi, left.hi_by), (below.lo, below.hi, 3.0));
                        let up = torn.iter().find(|s| usize::from(s.ray) == r);
                        assert_eq!(above.map(|s| (s.lo, s.hi, s.lo_by)), up.map(|s| (s.lo, s.hi, s.lo_by)));
                        divided += usize::from(above.is_some());
                    }
                    (None, Some(above)) => assert_eq!((left.lo, left.hi, left.lo_by), (above.lo, above.hi, 4.0)),
                }
            }
            assert_eq!((sum.rays, sum.longest, sum.ray, sum.range), (want.rays, want.longest, want.ray, want.range));
            assert_eq!((sum.columns, sum.rows, sum.middle), (want.columns, want.rows, want.middle));
            // The order of addition differs.
            assert!((sum.length - want.length).abs() < 1e-12 * 64.0);
            assert_eq!(text(&(cut, sum, torn, gone)), text(&other));
        }
        assert!(whole > 50 && divided > 500, "{whole} {divided}");
    }
}
