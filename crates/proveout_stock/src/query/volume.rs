//! Volume of the material, so that what is removed and what is left make up the stock.
//!
//! A ray knows the length of its material exactly, and represents one cell across it. So the set
//! along the normal of a face gives the face exactly, and the other two give it in whole cells. All
//! three agree on one more number: the cells whose middles are in material. A middle lies on a ray
//! of each set. With `V_a` the volume by set a and N that of the cells
//!
//! ```text
//!    volume = V_x + V_y + V_z - 2 N           a slab of thickness t across z, over whole faces of the stock:
//!                                             V_z = t F   V_x = V_y = N = (cells in t) F    so volume = t F
//! ```
//!
//! Each set brings in the part of a cell between its ends and the next borders of cells; the cells themselves
//! count once. A box whose faces lie along the axes has no error of first order in the cell, wherever its
//! faces are. Of slanted and round faces the parts cancel out, as they do in each `V_a`.
//!
//! N is counted on all three sets, a third each. So a ray adds `3 l - 2 c` thirds of its cell, with l the
//! length of its material and c that of the cells whose middles it holds. The sum is linear in the material:
//! what one cut takes and another takes later add up, whatever their order, and nothing is left of a stock
//! without material. What a single small cut takes may be out by a cell.
//!
//! The last cell along an axis ends where the stock does, so that the raw block has its own volume.

use crate::{
    field::dexel::TriDexel,
    field::grid::{RayGrid, TILE, TILE_RAYS},
};

/// Cells along one axis, as they share out the length of the stock.
struct AxisCells {
    least: f64,
    cell: f64,
    /// Cells whose middles lie in the box.
    count: usize,
    /// Edge of the box along the axis, mm.
    length: f64,
}

impl AxisCells {
    fn of(grid: &RayGrid, axis: usize) -> Self {
        let (least, most) = (grid.bounds.min[axis], grid.bounds.max[axis]);
        let count = (0..grid.n[axis]).rev().find(|k| grid.center(axis, *k) < most).map_or(0, |k| k + 1);
        Self { least, cell: grid.cells[axis], count, length: most - least }
    }

    /// Width of a cell, mm.
    fn width(&self, index: usize) -> f64 {
        match index + 1 {
            k if k < self.count => self.cell,
            k if k == self.count => self.length - (self.count - 1) as f64 * self.cell,
            _ => 0.0,
        }
    }

    /// Length of the cells whose middles are below a place, mm.
    fn below(&self, place: f64) -> f64 {
        let cells = ((place - self.least) / self.cell).round();
        if cells >= self.count as f64 { self.length } else { cells.max(0.0) * self.cell }
    }
}

/// The volume of a stock, followed through its cuts.
#[derive(Clone, Debug)]
pub struct Volume {
    of_tile: Vec<f64>,
    /// Passes over the rays that are in it.
    passes: u32,
    total: f64,
}

impl Volume {
    /// Of a stock as it is.
    pub fn of(stock: &TriDexel) -> Self {
        let rows = [0, 1, 2].map(|axis| AxisCells::of(&stock.grid, axis));
        let of_tile: Vec<f64> = (0..stock.tiles.len()).map(|t| of_tile(stock, &rows, t)).collect();
        Self { total: of_tile.iter().sum(), of_tile, passes: stock.passes }
    }

    /// Volume of the material at the last look, mm³.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Looks at what was cut since; gives the volume that has gone, mm³. Negative where more was put back
    /// than cut.
    pub fn follow(&mut self, stock: &TriDexel) -> f64 {
        if stock.passes == self.passes || self.of_tile.len() != stock.tiles.len() {
            return 0.0;
        }
        let rows = [0, 1, 2].map(|axis| AxisCells::of(&stock.grid, axis));
        let mut gone = 0.0;
        for (t, before) in self.of_tile.iter_mut().enumerate().filter(|(t, _)| stock.cut_in[*t] > self.passes) {
            let now = of_tile(stock, &rows, t);
            gone += *before - now;
            *before = now;
        }
        self.passes = stock.passes;
        self.total -= gone;
        gone
    }
}

fn of_tile(stock: &TriDexel, rows: &[AxisCells; 3], tile: usize) -> f64 {
    let (a, [i0, j0]) = stock.grid.tile_place(tile);
    let (along, u, v) = (&rows[a], &rows[(a + 1) % 3], &rows[(a + 2) % 3]);
    let mut sum = 0.0;
    for r in 0..TILE_RAYS {
        let spans = stock.tiles[tile].ray(r);
        if spans.is_empty() {
            continue;
        }
        let thirds: f64 =
            spans.iter().map(|s| 3.0 * (s.hi - s.lo) - 2.0 * (along.below(s.hi) - along.below(s.lo))).sum();
        sum += thirds * u.width(i0 + r % TILE) * v.width(j0 + r / TILE);
    }
    sum / 3.0
}

impl TriDexel {
    /// Volume of the material, mm³: of a block with faces along the axes its own, whatever the cells.
    pub fn exact_volume(&self) -> f64 {
        Volume::of(self).total()
    }
}
