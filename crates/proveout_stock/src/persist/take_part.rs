//! A part that is taken out of the stock, and put back.
//!
//! All intervals of the three ray sets that belong to the part go; every other interval keeps each
//! bit of its ends and marks. The earlier content of the tiles is kept with the part, so that
//! putting it back leaves the stock as it was. The history records a removal, and each ray that is
//! emptied remembers the motion that cut the part off.

use proveout_geom::Aabb;

use crate::{
    StockPart, TriDexel,
    field::grid::{RayGrid, TILE, TILE_RAYS},
    field::last_emptied::LastEmptied,
    field::span::{MaterialSpan, SpanEnd},
    field::tile::Tile,
    query::parts::Labels,
};

/// What a tile was before a part was taken from it.
#[derive(Clone, Debug)]
struct TileBefore {
    index: usize,
    tile: Tile,
    lost: LastEmptied,
    /// Changes and ends in its history.
    noted: [usize; 2],
}

/// A part out of the stock.
#[derive(Clone, Debug)]
pub struct TakenPart {
    stock: TriDexel,
    before: Vec<TileBefore>,
}

impl TakenPart {
    /// The part alone, in the frame and on the rays of the stock that it was taken from.
    pub fn stock(&self) -> &TriDexel {
        &self.stock
    }
}

/// The part that is meant.
struct PartToTake<'a> {
    labels: &'a Labels,
    number: usize,
    /// Nothing of it lies outside.
    near: Aabb,
}

/// The box of whole cells of a grid that holds `bounds` with a cell around: first cells and numbers.
fn window(grid: &RayGrid, bounds: &Aabb) -> ([i64; 3], [usize; 3]) {
    let first = [0, 1, 2].map(|c| ((bounds.min[c] - grid.bounds.min[c]) / grid.cells[c]).floor() as i64 - 1);
    let last = [0, 1, 2].map(|c| ((bounds.max[c] - grid.bounds.min[c]) / grid.cells[c]).ceil() as i64 + 1);
    (first, [0, 1, 2].map(|c| (last[c] - first[c]).max(1) as usize))
}

impl TriDexel {
    /// Takes a part out, one of those that [`Self::parts`] returns for this stock; none if there is
    /// no material in its place. `id` is the item that the history books it under, the last one
    /// that was swept; `cut_by` the one that cut the part off.
    pub fn take_part(&mut self, part: &StockPart, id: u32, cut_by: u32) -> Option<TakenPart> {
        let labels = self.labels();
        let [i, j] = [0, 1].map(|c| self.grid.nearest(c, part.seed[c]));
        let at = self.spans(2, i, j).iter().position(|s| s.lo <= part.seed.z && part.seed.z <= s.hi)?;
        let which = PartToTake {
            number: labels.of(self.grid.n[0], [i, j], at),
            near: part.bounds.expanded(self.grid.longest_cell()),
            labels: &labels,
        };
        let mut taken = self.part_alone(&which)?;
        self.passes += 1;
        for index in 0..self.tiles.len() {
            self.take_from(index, &which, [id, cut_by], &mut taken.before);
        }
        Some(taken)
    }

    /// Puts a part back that was taken out last, with nothing done to the stock since: the stock is then as
    /// it was.
    pub fn put_back(&mut self, taken: TakenPart) {
        self.passes += 1;
        for before in taken.before {
            let (range, index) = ([before.tile.lo, before.tile.hi], before.index);
            self.tiles[index] = before.tile;
            self.cut_in[index] = self.passes;
            self.lost[index] = before.lost;
            if let Some(history) = &mut self.history {
                let undo = &mut history.tiles[index];
                undo.changes.truncate(before.noted[0]);
                undo.ends.truncate(before.noted[1]);
            }
            self.mark_changed(index, range);
        }
    }

    /// Whether an interval of ray `(i, j)` of set `a` belongs to a part.
    fn belongs(&self, which: &PartToTake<'_>, a: usize, [i, j]: [usize; 2], at: usize, span: &MaterialSpan) -> bool {
        let [u, v] = [(a + 1) % 3, (a + 2) % 3];
        let ends = [span.lo, span.hi].map(|s| RayGrid::point(a, s, self.grid.center(u, i), self.grid.center(v, j)));
        if !which.near.intersects(&Aabb { min: ends[0], max: ends[1] }) {
            return false;
        }
        match a {
            2 => which.labels.of(self.grid.n[0], [i, j], at) == which.number,
            _ => self.owner(which.labels, a, [i, j], span) == Some(which.number),
        }
    }

    fn take_from(&mut self, index: usize, part: &PartToTake<'_>, [id, cut_by]: [u32; 2], before: &mut Vec<TileBefore>) {
        let (a, [i0, j0]) = self.grid.tile_place(index);
        let n = [self.grid.n[(a + 1) % 3], self.grid.n[(a + 2) % 3]];
        let mut goes = [const { Vec::new() }; TILE_RAYS];
        let (mut any, mut range) = (false, [f64::INFINITY, f64::NEG_INFINITY]);
        for (r, goes) in goes.iter_mut().enumerate() {
            let ray = [i0 + r % TILE, j0 + r / TILE];
            if ray[0] >= n[0] || ray[1] >= n[1] {
                continue;
            }
            let spans = self.tiles[index].ray(r);
            goes.extend(spans.iter().enumerate().map(|(k, s)| self.belongs(part, a, ray, k, s)));
            for (s, _) in spans.iter().zip(goes.iter()).filter(|(_, goes)| **goes) {
                any = true;
                range = [range[0].min(s.lo), range[1].max(s.hi)];
            }
        }
        if !any {
            return;
        }
        let noted = self.history.as_ref().map_or([0; 2], |h| {
            let undo = &h.tiles[index];
            [undo.changes.len(), undo.ends.len()]
        });
        before.push(TileBefore { index, tile: self.tiles[index].clone(), lost: self.lost[index].clone(), noted });
        let old = &before[before.len() - 1].tile;
        let ends = |spans: &[MaterialSpan]| spans.iter().flat_map(MaterialSpan::ends).collect::<Vec<SpanEnd>>();
        let left = Tile::from_rays(|r, list| {
            let kept = old.ray(r).iter().enumerate().filter(|(k, _)| !goes[r].get(*k).copied().unwrap_or(false));
            list.extend(kept.map(|(_, s)| *s));
        });
        for r in (0..TILE_RAYS).filter(|&r| goes[r].contains(&true)) {
            self.lost[index].set(r, cut_by);
            if let Some(history) = &mut self.history {
                let (was, is) = (ends(old.ray(r)), ends(left.ray(r)));
                history.tiles[index].remember_change(
                    r as u8,
                    id,
                    [was.len(), is.len()],
                    |i, j| was[i] == is[j],
                    |i| was[i],
                );
            }
        }
        self.tiles[index] = left;
        self.cut_in[index] = self.passes;
        self.mark_changed(index, range);
    }

    /// The part on a grid of its own that has the rays of this one.
    fn part_alone(&self, which: &PartToTake<'_>) -> Option<TakenPart> {
        let mut bounds = Aabb::empty();
        for a in 0..3 {
            let (u, v) = ((a + 1) % 3, (a + 2) % 3);
            for j in 0..self.grid.n[v] {
                for i in 0..self.grid.n[u] {
                    for (k, s) in self.spans(a, i, j).iter().enumerate() {
                        if self.belongs(which, a, [i, j], k, s) {
                            bounds.grow(&RayGrid::point(a, s.lo, self.grid.center(u, i), self.grid.center(v, j)));
                            bounds.grow(&RayGrid::point(a, s.hi, self.grid.center(u, i), self.grid.center(v, j)));
                        }
                    }
                }
            }
        }
        if bounds.is_empty() {
            return None;
        }
        let (first, count) = window(&self.grid, &bounds);
        let corner = |k: [i64; 3]| {
            let mut p = self.grid.bounds.min;
            for c in 0..3 {
                p[c] += k[c] as f64 * self.grid.cells[c];
            }
            p
        };
        let last = [0, 1, 2].map(|c| first[c] + count[c] as i64);
        let grid = RayGrid::new(&Aabb { min: corner(first), max: corner(last) }, self.grid.cells).ok()?;
        let tiles = (0..grid.first_tile[3]).map(|t| {
            let (a, [i0, j0]) = grid.tile_place(t);
            let (u, v) = ((a + 1) % 3, (a + 2) % 3);
            let whole = |c: usize, k: usize| usize::try_from(k as i64 + first[c]).ok().filter(|k| *k < self.grid.n[c]);
            Tile::from_rays(|r, list| {
                let [Some(i), Some(j)] = [whole(u, i0 + r % TILE), whole(v, j0 + r / TILE)] else { return };
                let own = self.spans(a, i, j).iter().enumerate();
                list.extend(own.filter(|(k, s)| self.belongs(which, a, [i, j], *k, s)).map(|(_, s)| *s));
            })
        });
        let tiles: Vec<Tile> = tiles.collect();
        let blocks = grid.blocks.iter().product();
        let (lost, cut_in) = (vec![LastEmptied::default(); tiles.len()], vec![0; tiles.len()]);
        let mut stock = Self {
            grid,
            tiles,
            initial_volume: 0.0,
            sweep_bound: self.sweep_bound,
            regrid: self.regrid,
            changed: vec![true; blocks],
            passes: 0,
            cut_in,
            history: None,
            lost,
            watch_engagement: false,
            slice_plan: None,
            slices: Vec::new(),
            empty_rows: Vec::new(),
        };
        stock.initial_volume = stock.volume();
        Some(TakenPart { stock, before: Vec::new() })
    }
}
