use proveout_geom::{Aabb, Point};

use crate::StockError;

/// Rays on one side of a tile.
pub(crate) const TILE: usize = 8;
/// Rays of a tile.
pub(crate) const TILE_RAYS: usize = TILE * TILE;
/// Cells on one side of a block of the surface (see [`crate::TileId`]).
pub(crate) const BLOCK: usize = 32;
/// Part of a cell by which a length of whole cells may round above them.
const WHOLE_CELLS: f64 = 1e-7;

/// Edges of a cell along x, y and z, mm; a single number means a cube.
///
/// Rays of set `a` are as far apart as the edges of the two other axes: a stock that is finished from above
/// along x may have long cells in x and short ones in y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells(pub [f64; 3]);

impl From<f64> for Cells {
    fn from(cell_mm: f64) -> Self {
        Self([cell_mm; 3])
    }
}

impl From<[f64; 3]> for Cells {
    fn from(cells_mm: [f64; 3]) -> Self {
        Self(cells_mm)
    }
}

/// A block of 32 x 32 x 32 cells of the stock, x fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileId(pub u32);

/// Cells from the lower corner of the stock's box, with an edge of their own along each axis. Rays of set
/// `a` run along axis `a` through the cell centers of the other two axes, taken in cyclic order: u = a + 1,
/// v = a + 2 (modulo 3).
#[derive(Clone, Debug)]
pub(crate) struct RayGrid {
    pub bounds: Aabb,
    /// Edges of a cell along x, y, z, mm.
    pub cells: [f64; 3],
    /// 1 / cell, 1/mm.
    per_cell: [f64; 3],
    /// Cells along x, y, z.
    pub n: [usize; 3],
    /// Tiles along u and v of each set.
    pub tiles: [[usize; 2]; 3],
    /// Index of the first tile of each set; the last entry is the number of tiles.
    pub first_tile: [usize; 4],
    /// Surface blocks along x, y, z.
    pub blocks: [usize; 3],
}

impl RayGrid {
    pub(crate) fn new(bounds: &Aabb, cells: [f64; 3]) -> Result<Self, StockError> {
        if let Some(&cell_mm) = cells.iter().find(|c| !(c.is_finite() && **c > 0.0)) {
            return Err(StockError::Cell { cell_mm });
        }
        let size = bounds.size();
        if !(0..3).all(|i| size[i].is_finite() && bounds.min[i].is_finite() && size[i] > 0.0) {
            let what = format!("the box measures {} x {} x {} mm", size.x, size.y, size.z);
            return Err(StockError::Degenerate { what });
        }
        let n = [0, 1, 2].map(|i| ((size[i] / cells[i] - WHOLE_CELLS).ceil() as usize).max(1));
        let tiles = [0, 1, 2].map(|a| [n[(a + 1) % 3].div_ceil(TILE), n[(a + 2) % 3].div_ceil(TILE)]);
        let mut first_tile = [0; 4];
        for a in 0..3 {
            first_tile[a + 1] = first_tile[a] + tiles[a][0] * tiles[a][1];
        }
        let blocks = n.map(|k| k.div_ceil(BLOCK));
        Ok(Self { bounds: *bounds, cells, per_cell: cells.map(|c| 1.0 / c), n, tiles, first_tile, blocks })
    }

    /// Coordinate of a cell center.
    pub(crate) fn center(&self, axis: usize, index: usize) -> f64 {
        self.bounds.min[axis] + (index as f64 + 0.5) * self.cells[axis]
    }

    /// Area that a ray of set `a` represents, mm².
    pub(crate) fn ray_area(&self, a: usize) -> f64 {
        self.cells[(a + 1) % 3] * self.cells[(a + 2) % 3]
    }

    /// Longest edge of a cell, mm.
    pub(crate) fn longest_cell(&self) -> f64 {
        self.cells.into_iter().fold(0.0, f64::max)
    }

    /// Index of the first cell whose center is at or above `x`, at most the number of cells.
    pub(crate) fn first_at_or_above(&self, axis: usize, x: f64) -> usize {
        // Rounded up by hand: without SSE4.1 `ceil` is a call.
        let guess = ((x - self.bounds.min[axis]) * self.per_cell[axis] - 0.5).clamp(-1.0, self.n[axis] as f64);
        let down = guess as isize;
        (down + isize::from(guess > down as f64)).max(0) as usize
    }

    /// Index of the nearest cell.
    pub(crate) fn nearest(&self, axis: usize, x: f64) -> usize {
        let guess = ((x - self.bounds.min[axis]) / self.cells[axis]).floor();
        guess.clamp(0.0, (self.n[axis] - 1) as f64) as usize
    }

    /// Set, and first ray along u and v, of a tile.
    pub(crate) fn tile_place(&self, tile: usize) -> (usize, [usize; 2]) {
        let a = if tile < self.first_tile[1] {
            0
        } else if tile < self.first_tile[2] {
            1
        } else {
            2
        };
        let local = tile - self.first_tile[a];
        (a, [local % self.tiles[a][0] * TILE, local / self.tiles[a][0] * TILE])
    }

    /// Tile and ray within it.
    pub(crate) fn ray_place(&self, a: usize, i: usize, j: usize) -> (usize, usize) {
        (self.first_tile[a] + j / TILE * self.tiles[a][0] + i / TILE, j % TILE * TILE + i % TILE)
    }

    /// Point at height `s` over a place given in ray coordinates of set `a`.
    pub(crate) fn point(a: usize, s: f64, u: f64, v: f64) -> Point {
        let mut p = Point::origin();
        p[a] = s;
        p[(a + 1) % 3] = u;
        p[(a + 2) % 3] = v;
        p
    }

    /// Number of rays of the three sets.
    pub(crate) fn rays(&self) -> usize {
        self.n[1] * self.n[2] + self.n[2] * self.n[0] + self.n[0] * self.n[1]
    }
}
