//! Intervals of material side by side, and what a moving body takes of them.

use pulp::Simd;

use crate::{
    field::span::SLIVER,
    kernels::lane_bits::{ROW, row_of, rows_of, rows_with},
    kernels::lanes::{L, Mask, load, put, width},
    kernels::ray::TakenInterval,
};

/// Lanes of one set: the rays of a tile.
pub(crate) const LANES: usize = crate::field::grid::TILE_RAYS;
/// Blocks of a set: two by two rays of a tile.
pub(crate) const BLOCKS: usize = LANES / 4;

/// Room for a number a row, filled up to the widest vector.
pub(crate) const WIDE: usize = 16;

/// What is known of a lane: nothing is taken, one interval is taken, or the kernel could not prove its answer
/// and the ray must be searched (see `ray_translate`, `ray_turn`).
pub(crate) const NOTHING: f64 = 0.0;
pub(crate) const TAKEN: f64 = 1.0;
pub(crate) const UNPROVEN: f64 = 2.0;
/// The lane is not requested.
pub(crate) const IDLE: f64 = 3.0;

/// Maker of an end that was there before the batch began.
pub(crate) const OLD: f64 = -1.0;

/// One array a quantity. Makers are numbers of steps of the batch, times are those of the step, 0 to 1: they
/// give the normal of an end when it is wanted.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes {
    pub u: [f64; LANES],
    pub v: [f64; LANES],
    /// The material, mm; `lo > hi`: none.
    pub lo: [f64; LANES],
    pub hi: [f64; LANES],
    pub lo_by: [f64; LANES],
    pub hi_by: [f64; LANES],
    pub lo_tau: [f64; LANES],
    pub hi_tau: [f64; LANES],
    pub state: [f64; LANES],
    /// The interval taken up, mm; cut off anywhere outside of `lo..=hi`.
    pub from: [f64; LANES],
    pub to: [f64; LANES],
    pub from_by: [f64; LANES],
    pub to_by: [f64; LANES],
    pub from_tau: [f64; LANES],
    pub to_tau: [f64; LANES],
    /// Tile ray of the lane.
    pub ray: [u8; LANES],
    /// Rows that are asked for, one bit each.
    pub rows: u8,
    /// Lanes that [`Self::push`] has filled.
    n: usize,
}

/// Material of one lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneStrip {
    pub ray: u8,
    pub u: f64,
    pub v: f64,
    pub lo: f64,
    pub hi: f64,
    pub lo_by: f64,
    pub hi_by: f64,
    pub lo_tau: f64,
    pub hi_tau: f64,
}

impl Default for Lanes {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            u: zero,
            v: zero,
            lo: [f64::INFINITY; LANES],
            hi: [f64::NEG_INFINITY; LANES],
            lo_by: zero,
            hi_by: zero,
            lo_tau: zero,
            hi_tau: zero,
            state: [IDLE; LANES],
            from: zero,
            to: zero,
            from_by: zero,
            to_by: zero,
            from_tau: zero,
            to_tau: zero,
            ray: [0; LANES],
            rows: 0,
            n: 0,
        }
    }
}

impl Lanes {
    pub(crate) fn len(&self) -> usize {
        self.n
    }

    /// Empties all lanes.
    pub(crate) fn clear(&mut self) {
        self.lo = [f64::INFINITY; LANES];
        self.hi = [f64::NEG_INFINITY; LANES];
        self.n = 0;
        self.clear_requests();
    }

    /// Empties all lanes of a set that is filled by [`Self::gather`].
    pub(crate) fn clear_requested(&mut self) {
        self.n = 0;
        self.clear_requests();
    }

    /// Requests no lane.
    pub(crate) fn clear_requests(&mut self) {
        self.state = [IDLE; LANES];
        self.rows = 0;
    }

    fn request(&mut self, k: usize) {
        self.state[k] = NOTHING;
        self.rows |= 1 << (k / ROW);
    }

    /// Asks for all lanes of a row.
    #[cfg(test)]
    pub(crate) fn request_row(&mut self, row: usize) {
        self.request_lanes(0xFF << (row * ROW));
    }

    /// Asks for lanes, one bit each.
    #[inline]
    pub(crate) fn request_lanes(&mut self, which: u64) {
        let mut rows = rows_with(which);
        self.rows |= rows;
        while rows != 0 {
            let row = rows.trailing_zeros() as usize;
            rows &= rows - 1;
            let bits = row_of(which, row);
            for (i, state) in self.state[row * ROW..(row + 1) * ROW].iter_mut().enumerate() {
                *state = if bits >> i & 1 == 1 { NOTHING } else { *state };
            }
        }
    }

    /// Fills the lanes from the first on with the material of some of another set, one bit each, and asks for
    /// them; those that find no room are left. Returns them.
    pub(crate) fn gather(&mut self, from: &Self, which: u64) -> u64 {
        let mut left = which;
        while left != 0 && self.n < LANES {
            let (r, k) = (left.trailing_zeros() as usize, self.n);
            (self.u[k], self.v[k], self.lo[k], self.hi[k]) = (from.u[r], from.v[r], from.lo[r], from.hi[r]);
            (self.ray[k], self.state[k]) = (from.ray[r], NOTHING);
            self.n += 1;
            left &= left - 1;
        }
        self.rows = rows_of(self.n);
        left
    }

    /// Takes over what was found for lane `k` of another set; true when something was.
    #[inline]
    pub(crate) fn take_answer(&mut self, r: usize, other: &Self, k: usize) -> bool {
        let state = other.state[k];
        if state != TAKEN && state != UNPROVEN {
            return false;
        }
        self.state[r] = state;
        self.rows |= 1 << (r / ROW);
        (self.from[r], self.to[r]) = (other.from[k], other.to[k]);
        (self.from_by[r], self.to_by[r]) = (other.from_by[k], other.to_by[k]);
        (self.from_tau[r], self.to_tau[r]) = (other.from_tau[k], other.to_tau[k]);
        true
    }

    /// Whether vector `g` has lanes that are asked for.
    #[inline(always)]
    pub(crate) fn requests_any<S: Simd>(&self, g: usize) -> bool {
        let whole = width::<S>() / ROW;
        let rows = if whole > 1 { (1 << whole) - 1 } else { 1 };
        self.rows >> (g * width::<S>() / ROW) & rows != 0
    }

    /// Adds a lane and asks for it; nothing happens when all are in use.
    pub(crate) fn push(&mut self, strip: &LaneStrip) {
        if self.n < LANES {
            self.n += 1;
            self.set(self.n - 1, strip);
            self.request(self.n - 1);
        }
    }

    pub(crate) fn set(&mut self, k: usize, s: &LaneStrip) {
        (self.u[k], self.v[k], self.ray[k]) = (s.u, s.v, s.ray);
        (self.lo[k], self.hi[k]) = (s.lo, s.hi);
        (self.lo_by[k], self.hi_by[k]) = (s.lo_by, s.hi_by);
        (self.lo_tau[k], self.hi_tau[k]) = (s.lo_tau, s.hi_tau);
    }

    pub(crate) fn strip(&self, k: usize) -> LaneStrip {
        LaneStrip {
            ray: self.ray[k],
            u: self.u[k],
            v: self.v[k],
            lo: self.lo[k],
            hi: self.hi[k],
            lo_by: self.lo_by[k],
            hi_by: self.hi_by[k],
            lo_tau: self.lo_tau[k],
            hi_tau: self.hi_tau[k],
        }
    }

    pub(crate) fn remove(&mut self, k: usize) {
        (self.lo[k], self.hi[k]) = (f64::INFINITY, f64::NEG_INFINITY);
    }

    pub(crate) fn holds(&self, k: usize) -> bool {
        self.lo[k] < self.hi[k]
    }

    /// The answer for a lane.
    pub(crate) fn answer(&mut self, k: usize, cut: Option<&LaneCut>) {
        self.state[k] = NOTHING;
        if let Some(c) = cut {
            self.state[k] = TAKEN;
            (self.from[k], self.to[k]) = (c.from, c.to);
            (self.from_by[k], self.to_by[k]) = (c.from_by, c.to_by);
            (self.from_tau[k], self.to_tau[k]) = (c.from_tau, c.to_tau);
        }
    }

    /// What is taken of a lane.
    pub(crate) fn cut(&self, k: usize) -> LaneCut {
        LaneCut {
            from: self.from[k],
            to: self.to[k],
            from_by: self.from_by[k],
            to_by: self.to_by[k],
            from_tau: self.from_tau[k],
            to_tau: self.to_tau[k],
        }
    }
}

/// An interval that an item takes up on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneCut {
    pub from: f64,
    pub to: f64,
    pub from_by: f64,
    pub to_by: f64,
    pub from_tau: f64,
    pub to_tau: f64,
}

/// What a kernel works on: the number of the step, and which part of its time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Maker {
    pub by: f64,
    pub first: f64,
    pub part: f64,
}

impl Maker {
    pub(crate) fn whole(step: usize) -> Self {
        Self { by: step as f64, first: 0.0, part: 1.0 }
    }

    /// Part `k` of `n`.
    pub(crate) fn part(step: usize, k: usize, n: usize) -> Self {
        Self { by: step as f64, first: k as f64 / n as f64, part: 1.0 / n as f64 }
    }
}

impl Maker {
    /// An interval that one of the searches found.
    pub(crate) fn cut(&self, taken: &TakenInterval) -> LaneCut {
        let tau = |t: f64| self.first + self.part * t;
        LaneCut {
            from: taken.lo.s,
            to: taken.hi.s,
            from_by: self.by,
            to_by: self.by,
            from_tau: tau(taken.lo.tau),
            to_tau: tau(taken.hi.tau),
        }
    }
}

/// Adds the interval `ends` where `hit` holds to what a lane has, or gives the lane up when the two do not
/// meet.
#[inline(always)]
pub(crate) fn join<S: Simd>(
    simd: S,
    lanes: &mut Lanes,
    g: usize,
    hit: Mask<S>,
    ends: [L<S>; 2],
    taus: [L<S>; 2],
    maker: Maker,
) {
    let state = load(simd, &lanes.state, g);
    let (nothing, taken) = (state.same(NOTHING), state.same(TAKEN));
    let fresh = hit & state.le(nothing);
    let more = hit & state.ge(taken) & state.le(taken);
    let (mut lower, mut upper, mut after) = (fresh, fresh, taken);
    if more.any() {
        let (from, to) = (load(simd, &lanes.from, g), load(simd, &lanes.to, g));
        let gap = state.same(SLIVER);
        let meets = ends[0].le(to + gap) & ends[1].ge(from - gap);
        lower = fresh | (more & meets & ends[0].lt(from));
        upper = fresh | (more & meets & ends[1].gt(to));
        after = (more & !meets).select(state.same(UNPROVEN), taken);
    }
    let by = state.same(maker.by);
    let (first, part) = (state.same(maker.first), state.same(maker.part));
    put(g, &mut lanes.state, fresh | more, after);
    put(g, &mut lanes.from, lower, ends[0]);
    put(g, &mut lanes.to, upper, ends[1]);
    put(g, &mut lanes.from_by, lower, by);
    put(g, &mut lanes.to_by, upper, by);
    put(g, &mut lanes.from_tau, lower, first + part * taus[0]);
    put(g, &mut lanes.to_tau, upper, first + part * taus[1]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(r: usize, layer: f64) -> LaneStrip {
        let (u, v) = ((r % ROW) as f64, (r / ROW) as f64);
        let (lo, hi) = (100.0 * layer + r as f64, 100.0 * layer + r as f64 + 0.5);
        LaneStrip { ray: r as u8, u, v, lo, hi, lo_by: OLD, hi_by: OLD, lo_tau: 0.0, hi_tau: 0.0 }
    }

    /// Lanes of two layers, more than find room: each comes back with its own answer, and no other is
    /// touched.
    #[test]
    fn gathered_lanes_take_their_own_answers_back() {
        for (first, second) in [(0b1011, 1 << 63), (u64::MAX, 0xF0F0), (u64::MAX >> 1, 0b11), (0, u64::MAX)] {
            let mut layers = [Lanes::default(), Lanes::default()];
            for (l, layer) in layers.iter_mut().enumerate() {
                (0..LANES).for_each(|r| layer.set(r, &strip(r, l as f64)));
            }
            let mut gathered = Lanes::default();
            let left = [gathered.gather(&layers[0], first), gathered.gather(&layers[1], second)];
            assert!(left[0] == 0 && left[1] & !second == 0);
            let room = LANES as u32 - first.count_ones();
            assert_eq!(left[1].count_ones(), second.count_ones().saturating_sub(room));
            assert_eq!(gathered.rows.count_ones(), (gathered.len() as u32).div_ceil(ROW as u32));
            for k in 0..gathered.len() {
                assert_eq!(gathered.state[k], NOTHING);
                let (from, by) = (gathered.lo[k], k as f64);
                let cut = LaneCut { from, to: gathered.hi[k], from_by: by, to_by: by, from_tau: 0.25, to_tau: 0.75 };
                gathered.answer(k, (k % 3 != 1).then_some(&cut));
            }
            let mut k = 0;
            for (l, which) in [first, second & !left[1]].into_iter().enumerate() {
                for r in (0..LANES).filter(|r| which >> r & 1 == 1) {
                    assert_eq!(layers[l].take_answer(r, &gathered, k), k % 3 != 1);
                    k += 1;
                }
                for r in 0..LANES {
                    let taken = layers[l].state[r] == TAKEN;
                    assert!(!taken || which >> r & 1 == 1 && layers[l].cut(r).from == layers[l].lo[r]);
                    assert!(!taken || layers[l].rows >> (r / ROW) & 1 == 1);
                }
            }
            assert_eq!(k, gathered.len());
        }
    }
}
