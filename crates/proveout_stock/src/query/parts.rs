//! Connected parts of the stock.
//!
//! The intervals of the rays along z are the nodes. Two of them on neighboring rays are connected
//! where material runs from one to the other: where their heights overlap, and a ray across says
//! so.
//!
//! ```text
//!   z ^   |#|   |#|              a row of cell centers k in the overlap: the ray along x (y) at this height
//!     |   |#|---|#|--- k         has one interval over both centers                        -> one part
//!     |   |#|   |#|    k         has a gap between them, at all k: a slot narrower than a cell -> two parts
//!     |   |#|                    no center in the overlap: nothing separates them             -> one part
//!     +--------------> x
//! ```
//!
//! The cost is linear in the rays: as a rule the first row says yes. *Limits.* Material that no ray along z
//! meets (a fin thinner than a cell, upright between the rays) is not seen; a bridge that runs between all
//! rays does not hold.

use proveout_geom::{Aabb, Point};

use crate::{
    TriDexel,
    field::grid::RayGrid,
    field::span::{INITIAL, MaterialSpan},
};

/// A part of the stock that hangs together.
#[derive(Clone, Debug, PartialEq)]
pub struct StockPart {
    /// Volume by the rays along z, mm³.
    pub volume_mm3: f64,
    /// Center of this volume, mm.
    pub center: Point,
    /// Box of the ends of its rays along z, to half a cell sideways, mm.
    pub bounds: Aabb,
    /// The last sweep item that made an end of its rays, of all three sets; none where it is as it was at
    /// first.
    pub last_made_by: Option<u32>,
    /// A point on a ray along z, in the middle of one of its intervals.
    pub(crate) seed: Point,
}

/// Which part each interval of the rays along z belongs to.
pub(crate) struct Labels {
    /// Number of the first interval of each column, x fastest; the last entry is the number of intervals.
    first: Vec<usize>,
    /// Part of each interval, counted in the order of the columns.
    number: Vec<usize>,
}

impl Labels {
    /// Part of interval `k` of column `(i, j)` of a stock with `nx` columns along x.
    pub(crate) fn of(&self, nx: usize, [i, j]: [usize; 2], k: usize) -> usize {
        self.number[self.first[j * nx + i] + k]
    }
}

impl StockPart {
    /// Whether a point of it lies in the material of another stock in the same frame, by the
    /// nearest ray along z.
    pub fn lies_in(&self, other: &TriDexel) -> bool {
        let (_, spans) = other.intervals_on(2, self.seed.x, self.seed.y);
        spans.iter().any(|s| s.lo <= self.seed.z && self.seed.z <= s.hi)
    }
}

impl TriDexel {
    /// Parts that hang together, the largest first. Frame: that of the stock.
    ///
    /// ```
    /// use proveout_geom::{Aabb, Point, ToolPose, Vector};
    /// use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
    /// use proveout_tool::Cutter;
    ///
    /// let block = Aabb { min: Point::origin(), max: Point::new(20.0, 10.0, 6.0) }; // mm
    /// let mut stock = TriDexel::from_box(&block, 0.5, 1 << 30)?;
    /// let tool = Cutter::flat(2.0)?.bodies(20.0)?.remove(0);
    /// let at = |y: f64| ToolPose { tip: Point::new(12.5, y, -1.0), axis: Vector::z() };
    /// let motion = SweepMotion { from: at(-2.0), to: at(12.0) };
    /// stock.sweep(&[SweepItem { id: 1, body: &tool, action: Action::Remove, motion }]);
    /// // The cut from x = 11.5 to 13.5 leaves parts of 11.5 and 6.5 mm.
    /// let volumes: Vec<f64> = stock.parts().iter().map(|part| part.volume_mm3.round()).collect();
    /// assert_eq!(volumes, [690.0, 390.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parts(&self) -> Vec<StockPart> {
        let labels = self.labels();
        let mut parts = self.collect(&labels);
        self.add_makers(&labels, &mut parts, |_| true);
        parts.sort_by(|a, b| b.volume_mm3.total_cmp(&a.volume_mm3));
        parts
    }

    /// The parts of [`Self::parts`] but the largest, as far as they have a volume (mm³): costs a pass over
    /// the rays along z where there are none.
    pub fn parts_apart(&self, least_volume: f64) -> Vec<StockPart> {
        let labels = self.labels();
        let mut parts = self.collect(&labels);
        // The first of equals, as sorting keeps it.
        let most = parts.iter().map(|p| p.volume_mm3).fold(f64::NEG_INFINITY, f64::max);
        let Some(largest) = parts.iter().position(|p| p.volume_mm3 >= most) else { return parts };
        let wanted: Vec<bool> =
            parts.iter().enumerate().map(|(k, p)| k != largest && p.volume_mm3 >= least_volume).collect();
        self.add_makers(&labels, &mut parts, |k| wanted[k]);
        let mut kept = wanted.iter();
        parts.retain(|_| kept.next().is_some_and(|w| *w));
        parts.sort_by(|a, b| b.volume_mm3.total_cmp(&a.volume_mm3));
        parts
    }

    pub(crate) fn labels(&self) -> Labels {
        let [nx, ny, _] = self.grid.n;
        let column = |i: usize, j: usize| self.spans(2, i, j);
        let mut first = Vec::with_capacity(nx * ny + 1);
        first.push(0_usize);
        for j in 0..ny {
            for i in 0..nx {
                first.push(first[first.len() - 1] + column(i, j).len());
            }
        }
        let mut sets = Sets::new(first[nx * ny]);
        for j in 0..ny {
            for i in 0..nx {
                let own = first[j * nx + i];
                for (axis, [i2, j2]) in [(0, [i + 1, j]), (1, [i, j + 1])] {
                    if i2 < nx && j2 < ny {
                        let other = first[j2 * nx + i2];
                        self.join([i, j], axis, [own, other], [column(i, j), column(i2, j2)], &mut sets);
                    }
                }
            }
        }
        let (number, _) = sets.numbers();
        Labels { first, number }
    }

    /// Joins the intervals of two neighboring columns; the second follows the first along `axis`.
    fn join(
        &self,
        place: [usize; 2],
        axis: usize,
        [own, other]: [usize; 2],
        columns: [&[MaterialSpan]; 2],
        sets: &mut Sets,
    ) {
        self.each_overlap(columns, |k, m, range| {
            if sets.root(own + k) != sets.root(other + m) && self.bridged(place, axis, range, |_| ()) {
                sets.unite(own + k, other + m);
            }
        });
    }

    /// Intervals of two columns whose heights overlap, and where.
    pub(super) fn each_overlap(&self, [a, b]: [&[MaterialSpan]; 2], mut see: impl FnMut(usize, usize, [f64; 2])) {
        let (mut k, mut m) = (0, 0);
        while k < a.len() && m < b.len() {
            let (low, high) = (a[k].lo.max(b[m].lo), a[k].hi.min(b[m].hi));
            if high > low {
                see(k, m, [low, high]);
            }
            if a[k].hi < b[m].hi {
                k += 1;
            } else {
                m += 1;
            }
        }
    }

    /// Whether material runs from a column to the next one along `axis` between two heights, as far
    /// as rays across show; `read` is called with the tiles of those rays.
    pub(super) fn bridged(
        &self,
        [i, j]: [usize; 2],
        axis: usize,
        [low, high]: [f64; 2],
        mut read: impl FnMut(usize),
    ) -> bool {
        let grid = &self.grid;
        let (from, to) = (grid.first_at_or_above(2, low), grid.first_at_or_above(2, high));
        let at = [i, j][axis];
        let (x0, x1) = (grid.center(axis, at), grid.center(axis, at + 1));
        let mut rows = from..to;
        // Rays along x are counted along y and z, rays along y along z and x.
        let covers = |k: usize| {
            let (tile, ray) = if axis == 0 { grid.ray_place(0, j, k) } else { grid.ray_place(1, k, i) };
            read(tile);
            self.tiles[tile].ray(ray).iter().any(|s| s.lo <= x0 && s.hi >= x1)
        };
        rows.is_empty() || rows.any(covers)
    }

    /// The part that an interval of a ray along x or y (`a` 0 or 1, ray `(p, q)`) belongs to: that of most of
    /// the columns whose centers it covers. One that lies between two columns goes with the nearer of those
    /// that have material at its height, or within a cell of it; none where neither has.
    pub(crate) fn owner(&self, labels: &Labels, a: usize, [p, q]: [usize; 2], span: &MaterialSpan) -> Option<usize> {
        let grid = &self.grid;
        let nx = grid.n[0];
        // Rays along x are counted along y and z, rays along y along z and x.
        let (k, place) = if a == 0 { (q, p) } else { (p, q) };
        let column = |along: usize| if a == 0 { [along, place] } else { [place, along] };
        let z = grid.center(2, k);
        let (from, to) = (grid.first_at_or_above(a, span.lo), grid.first_at_or_above(a, span.hi));
        let mut votes: Vec<(usize, usize)> = Vec::new();
        for along in from..to {
            let [i, j] = column(along);
            let Some(at) = self.spans(2, i, j).iter().position(|s| s.lo <= z && z <= s.hi) else { continue };
            let part = labels.of(nx, [i, j], at);
            match votes.iter_mut().find(|(of, _)| *of == part) {
                Some((_, count)) => *count += 1,
                None => votes.push((part, 1)),
            }
        }
        if let Some((part, _)) = votes.iter().copied().reduce(|best, v| if v.1 > best.1 { v } else { best }) {
            return Some(part);
        }
        let middle = 0.5 * (span.lo + span.hi);
        let near = from.saturating_sub(1)..(to + 1).min(grid.n[a]);
        let mut best: Option<(f64, usize)> = None;
        for along in near {
            let [i, j] = column(along);
            for (at, s) in self.spans(2, i, j).iter().enumerate() {
                let above = (s.lo - z).max(z - s.hi).max(0.0);
                let off = above + (grid.center(a, along) - middle).abs();
                if above <= grid.cells[2] && best.is_none_or(|(least, _)| off < least) {
                    best = Some((off, labels.of(nx, [i, j], at)));
                }
            }
        }
        best.map(|(_, part)| part)
    }

    fn collect(&self, labels: &Labels) -> Vec<StockPart> {
        let grid = &self.grid;
        let [nx, ny, _] = grid.n;
        let half = [0.5 * grid.cells[0], 0.5 * grid.cells[1]];
        let mut parts: Vec<StockPart> = Vec::new();
        for j in 0..ny {
            for i in 0..nx {
                let (x, y) = (grid.center(0, i), grid.center(1, j));
                for (k, span) in self.spans(2, i, j).iter().enumerate() {
                    let number = labels.of(nx, [i, j], k);
                    if number == parts.len() {
                        let seed = Point::new(x, y, 0.5 * (span.lo + span.hi));
                        let (center, bounds) = (Point::origin(), Aabb::empty());
                        parts.push(StockPart { volume_mm3: 0.0, center, bounds, last_made_by: None, seed });
                    }
                    let part = &mut parts[number];
                    let volume = (span.hi - span.lo) * grid.ray_area(2);
                    part.volume_mm3 += volume;
                    part.center += volume * Point::new(x, y, 0.5 * (span.lo + span.hi)).coords;
                    let (low, high) = ([x - half[0], y - half[1], span.lo], [x + half[0], y + half[1], span.hi]);
                    part.bounds.grow(&Point::from(low));
                    part.bounds.grow(&Point::from(high));
                    part.last_made_by = part.last_made_by.max(last_maker(span));
                }
            }
        }
        for part in &mut parts {
            part.center = Point::from(part.center.coords / part.volume_mm3);
        }
        parts
    }

    /// Takes the makers of the rays along x and y too, for the parts that are wanted.
    fn add_makers(&self, labels: &Labels, parts: &mut [StockPart], wanted: impl Fn(usize) -> bool) {
        let grid = &self.grid;
        let boxes = parts.iter().enumerate().filter(|(k, _)| wanted(*k)).map(|(_, p)| p.bounds);
        let Some(near) = boxes.reduce(|a, b| a.union(&b)).map(|b| b.expanded(grid.longest_cell())) else { return };
        for a in 0..2 {
            let (u, v) = (a + 1, (a + 2) % 3);
            for q in 0..grid.n[v] {
                for p in 0..grid.n[u] {
                    for span in self.spans(a, p, q) {
                        let made = last_maker(span);
                        let ends =
                            [span.lo, span.hi].map(|s| RayGrid::point(a, s, grid.center(u, p), grid.center(v, q)));
                        // Most ends are those of the raw stock and need no search.
                        if made.is_some()
                            && near.intersects(&Aabb { min: ends[0], max: ends[1] })
                            && let Some(part) = self.owner(labels, a, [p, q], span).filter(|k| wanted(*k))
                        {
                            parts[part].last_made_by = parts[part].last_made_by.max(made);
                        }
                    }
                }
            }
        }
    }
}

/// The later one of the items that made the ends.
fn last_maker(span: &MaterialSpan) -> Option<u32> {
    [span.lo_mark.id, span.hi_mark.id].into_iter().filter(|id| *id != INITIAL).max()
}

/// Disjoint sets with halved paths (Tarjan and van Leeuwen 1984).
pub(super) struct Sets {
    parent: Vec<usize>,
}

impl Sets {
    pub(super) fn new(n: usize) -> Self {
        Self { parent: (0..n).collect() }
    }

    pub(super) fn root(&mut self, mut at: usize) -> usize {
        while self.parent[at] != at {
            self.parent[at] = self.parent[self.parent[at]];
            at = self.parent[at];
        }
        at
    }

    pub(super) fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller number stays, so the result does not depend on the order of unions.
        self.parent[a.max(b)] = a.min(b);
    }

    /// The number of the set of each, in the order of their first ones, and how many there are.
    pub(super) fn numbers(mut self) -> (Vec<usize>, usize) {
        let mut number = vec![0; self.parent.len()];
        let mut count = 0;
        // The root is the smallest number of its set: it comes first.
        for at in 0..number.len() {
            let root = self.root(at);
            number[at] = if root == at { count } else { number[root] };
            count += usize::from(root == at);
        }
        (number, count)
    }
}
