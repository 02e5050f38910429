//! A tile spread out over lanes while a batch works on it.
//!
//! ```text
//!     ray 0  ===---====---=          first: lane r holds the lowest interval of ray r
//!     ray 1  =====                   more:  lanes for all others, in the order of the rays, rising
//!     ray 2    ====---==
//!            ^ first  ^ more
//! ```
//!
//! Which interval is where follows from the material alone, so results do not depend on how a program is cut into batches.

use crate::{
    grid::{Grid, TILE},
    lane_set::{LANES, Lanes, OLD, ROW, Strip},
    span::{Mark, SLIVER, Span},
    tile::Tile,
};

/// See the module.
#[derive(Debug)]
pub(crate) struct Field {
    pub first: Lanes,
    pub more: Vec<Lanes>,
    /// Rays with more than one interval, one bit each.
    many: u64,
    /// Ray centers along v of the rows, and the range along u.
    pub row_v: [f64; ROW],
    pub u: [f64; 2],
    /// Range of the first intervals of each row, mm.
    pub row_lo: [f64; ROW],
    pub row_hi: [f64; ROW],
    /// Range of all, mm.
    pub lo: f64,
    pub hi: f64,
    /// Whether anything was taken away, and lanes of `more` are to be put in order.
    pub changed: bool,
    pub torn: bool,
    order: Vec<Strip>,
}

impl Default for Field {
    fn default() -> Self {
        Self {
            first: Lanes::default(),
            more: Vec::new(),
            many: 0,
            row_v: [0.0; ROW],
            u: [0.0; 2],
            row_lo: [f64::INFINITY; ROW],
            row_hi: [f64::NEG_INFINITY; ROW],
            lo: f64::INFINITY,
            hi: f64::NEG_INFINITY,
            changed: false,
            torn: false,
            order: Vec::new(),
        }
    }
}

impl Field {
    /// Spreads a tile out.
    pub(crate) fn fill(&mut self, grid: &Grid, index: usize, tile: &Tile) {
        let (a, [i0, j0]) = grid.tile_place(index);
        let (u_axis, v_axis) = ((a + 1) % 3, (a + 2) % 3);
        self.first.clear();
        for lanes in &mut self.more {
            lanes.clear();
        }
        (self.many, self.changed, self.torn) = (0, false, false);
        let columns: [f64; TILE] = std::array::from_fn(|i| grid.center(u_axis, i0 + i));
        self.row_v = std::array::from_fn(|j| grid.center(v_axis, j0 + j));
        let rows = self.row_v;
        let last = grid.n[u_axis].min(i0 + TILE) - 1;
        self.u = [columns[0], grid.center(u_axis, last)];
        for r in 0..LANES {
            let strip = |span: &Span| Strip {
                ray: r as u8,
                u: columns[r % TILE],
                v: rows[r / TILE],
                lo: span.lo,
                hi: span.hi,
                lo_by: OLD,
                hi_by: OLD,
                lo_tau: 0.0,
                hi_tau: 0.0,
            };
            let spans = tile.ray(r);
            let none = Span { lo: f64::INFINITY, hi: f64::NEG_INFINITY, lo_mark: Mark::NONE, hi_mark: Mark::NONE };
            self.first.set(r, &strip(spans.first().unwrap_or(&none)));
            if spans.len() > 1 {
                self.many |= 1 << r;
                for span in &spans[1..] {
                    let strip = strip(span);
                    self.add(&strip);
                }
            }
        }
        for row in 0..ROW {
            self.measure_row(row);
        }
        self.measure();
    }

    /// Adds an interval that is not the first of its ray.
    pub(crate) fn add(&mut self, strip: &Strip) {
        self.many |= 1 << strip.ray;
        for lanes in &mut self.more {
            if lanes.push(strip) {
                return;
            }
        }
        let mut lanes = Lanes::default();
        lanes.push(strip);
        self.more.push(lanes);
    }

    /// Takes the range of a row anew.
    pub(crate) fn measure_row(&mut self, row: usize) {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in row * ROW..(row + 1) * ROW {
            lo = if self.first.lo[k] < lo { self.first.lo[k] } else { lo };
            hi = if self.first.hi[k] > hi { self.first.hi[k] } else { hi };
        }
        (self.row_lo[row], self.row_hi[row]) = (lo, hi);
    }

    /// Takes the range of all from those of the rows.
    pub(crate) fn measure(&mut self) {
        (self.lo, self.hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for row in 0..ROW {
            self.lo = self.lo.min(self.row_lo[row]);
            self.hi = self.hi.max(self.row_hi[row]);
        }
        for lanes in &self.more {
            for k in (0..lanes.len()).filter(|&k| lanes.holds(k)) {
                self.lo = self.lo.min(lanes.lo[k]);
                self.hi = self.hi.max(lanes.hi[k]);
            }
        }
    }

    pub(crate) fn has_many(&self) -> bool {
        self.many != 0
    }

    /// Puts the intervals of rays with several in order again after some were divided or taken away whole.
    pub(crate) fn settle(&mut self) {
        self.torn = false;
        if self.many == 0 {
            return;
        }
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        for lanes in &mut self.more {
            order.extend((0..lanes.len()).filter(|&k| lanes.holds(k)).map(|k| lanes.strip(k)));
            lanes.clear();
        }
        for r in 0..LANES {
            if self.many >> r & 1 == 1 && self.first.holds(r) {
                order.push(self.first.strip(r));
            }
        }
        order.sort_unstable_by(|a, b| a.ray.cmp(&b.ray).then(a.lo.total_cmp(&b.lo)));
        self.many = 0;
        let mut before = None;
        for strip in &order {
            if before == Some(strip.ray) {
                self.add(strip);
            } else {
                self.first.set(usize::from(strip.ray), strip);
            }
            before = Some(strip.ray);
        }
        self.order = order;
        for row in 0..ROW {
            self.measure_row(row);
        }
    }

    /// The tile again; `mark(strip, upper)` tells what made an end.
    pub(crate) fn tile(&self, mut mark: impl FnMut(&Strip, bool) -> Mark) -> Tile {
        let mut next = 0;
        let mut rest: Vec<Strip> = Vec::new();
        if self.many != 0 {
            for lanes in &self.more {
                rest.extend((0..lanes.len()).filter(|&k| lanes.holds(k)).map(|k| lanes.strip(k)));
            }
        }
        Tile::from_rays(|r, spans| {
            let mut push = |strip: &Strip| {
                let (lo_mark, hi_mark) = (mark(strip, false), mark(strip, true));
                spans.push(Span { lo: strip.lo, hi: strip.hi, lo_mark, hi_mark });
            };
            if self.first.holds(r) {
                push(&self.first.strip(r));
            }
            while let Some(strip) = rest.get(next).filter(|s| usize::from(s.ray) == r) {
                push(strip);
                next += 1;
            }
        })
    }
}

/// What one item met in one tile.
#[derive(Clone, Debug)]
pub(crate) struct Partial {
    pub item: u32,
    pub rays: u32,
    pub length: f64,
    pub longest: f64,
    /// Tile ray of the longest overlap, and its place (ray, u, v).
    pub ray: usize,
    pub at: [f64; 3],
    /// Range of the overlaps along the ray, and of the rays along u and v.
    pub range: [f64; 2],
    pub u: [f64; 2],
    pub v: [f64; 2],
}

impl Partial {
    pub(crate) fn new(item: u32) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Self { item, rays: 0, length: 0.0, longest: 0.0, ray: 0, at: [0.0; 3], range: none, u: none, v: none }
    }

    /// Adds the overlap `lo..hi` with a strip, of which `length` is gone.
    pub(crate) fn add(&mut self, strip: &Strip, [lo, hi]: [f64; 2], length: f64) {
        self.length += length;
        let ray = usize::from(strip.ray);
        if hi - lo > self.longest || (hi - lo == self.longest && ray < self.ray) {
            (self.longest, self.ray) = (hi - lo, ray);
            self.at = [0.5 * (lo + hi), strip.u, strip.v];
        }
        self.range = [self.range[0].min(lo), self.range[1].max(hi)];
        self.u = [self.u[0].min(strip.u), self.u[1].max(strip.u)];
        self.v = [self.v[0].min(strip.v), self.v[1].max(strip.v)];
    }
}

/// What is left of a strip when `from..to` goes: below, above, and the length that is gone; none when nothing is met.
pub(crate) struct Left {
    pub met: [f64; 2],
    pub gone: f64,
    pub below: Option<Strip>,
    pub above: Option<Strip>,
}

impl Left {
    pub(crate) fn of(strip: &Strip, cut: &crate::lane_set::Cut) -> Option<Self> {
        let (from, to) = (cut.from.max(strip.lo), cut.to.min(strip.hi));
        if to - from <= SLIVER {
            return None;
        }
        let mut gone = strip.hi - strip.lo;
        let below = (from - strip.lo > SLIVER).then(|| {
            gone -= from - strip.lo;
            Strip { hi: from, hi_by: cut.from_by, hi_tau: cut.from_tau, ..*strip }
        });
        let above = (strip.hi - to > SLIVER).then(|| {
            gone -= strip.hi - to;
            Strip { lo: to, lo_by: cut.to_by, lo_tau: cut.to_tau, ..*strip }
        });
        Some(Self { met: [from, to], gone, below, above })
    }
}
