use proveout_geom::{Aabb, Point, Vector};

use crate::{
    field::grid::{Cells, RayGrid, TILE, TILE_RAYS, TileId},
    field::last_emptied::LastEmptied,
    field::regrid_bound::Regrid,
    field::slices::{SliceContact, SlicePlan, joined},
    field::span::MaterialSpan,
    field::tile::Tile,
    field::undo::History,
};

/// In-process stock: three orthogonal sets of rays with exact interval ends. Frame: that of the constructor's
/// arguments.
///
/// Cells of [`Self::cells_mm`] start at the lower corner of the stock's box; the rays run through the cell
/// centers. Each interval end remembers the motion that made it and the normal there.
#[derive(Clone, Debug)]
pub struct TriDexel {
    pub(crate) grid: RayGrid,
    pub(crate) tiles: Vec<Tile>,
    pub(crate) initial_volume: f64,
    pub(crate) sweep_bound: f64,
    /// What was lost when the material was taken over from another grid.
    pub(crate) regrid: Option<Regrid>,
    pub(crate) changed: Vec<bool>,
    /// Passes over the rays that took something away, and the last of them for each tile; see
    /// [`crate::TileTree`].
    pub(crate) passes: u32,
    pub(crate) cut_in: Vec<u32>,
    pub(crate) history: Option<History>,
    /// Who took whole intervals, one for each tile.
    pub(crate) lost: Vec<LastEmptied>,
    pub(crate) watch_engagement: bool,
    /// Into what engagement is sorted, where that is asked for.
    pub(crate) slice_plan: Option<SlicePlan>,
    /// What was sorted since it was last taken, in the order of the tiles.
    pub(crate) slices: Vec<SliceContact>,
    /// Rows of tiles without material, where [`TriDexel::pass_over_empty_rows`] has asked for them; else
    /// empty.
    pub(crate) empty_rows: Vec<bool>,
}

/// One interval end: an exact point of the stock's surface, within [`TriDexel::sweep_bound_mm`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Place, mm.
    pub point: Point,
    /// Outward unit normal of the stock (stored with 16 bits a coordinate, 7e-5 rad). None where the maker
    /// left none.
    pub normal: Option<Vector>,
    /// The sweep item that made it; none on the initial surface.
    pub made_by: Option<u32>,
    /// Direction of the ray: 0 x, 1 y, 2 z.
    pub axis: u8,
}

/// Material on one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end, mm.
    pub lo: f64,
    /// Upper end, mm.
    pub hi: f64,
    /// The item that made the lower end; none on the initial surface.
    pub lo_made_by: Option<u32>,
    /// The item that made the upper end.
    pub hi_made_by: Option<u32>,
}

impl TriDexel {
    /// Volume of material, mm³: mean over the three ray sets of length times cell area.
    pub fn volume(&self) -> f64 {
        (0..3).map(|a| self.volume_along(a) / 3.0).sum()
    }

    /// Volume by one ray set alone (0 x, 1 y, 2 z), mm³.
    pub fn volume_along(&self, axis: usize) -> f64 {
        let a = axis.min(2);
        let tiles = &self.tiles[self.grid.first_tile[a]..self.grid.first_tile[a + 1]];
        tiles.iter().map(|t| t.length() * self.grid.ray_area(a)).sum()
    }

    /// Volume of material before the first cut, mm³, by the same measure as [`Self::volume`].
    pub fn initial_volume(&self) -> f64 {
        self.initial_volume
    }

    /// Largest error of the swept surface of any motion so far, mm, in the direction of the normal; 0 before
    /// the first.
    pub fn sweep_bound_mm(&self) -> f64 {
        self.sweep_bound
    }

    /// Longest edge of a cell, mm: the distance of neighboring rays where cells are cubes.
    pub fn cell_mm(&self) -> f64 {
        self.grid.longest_cell()
    }

    /// Edges of a cell along x, y and z, mm.
    pub fn cells_mm(&self) -> [f64; 3] {
        self.grid.cells
    }

    /// Box of the initial stock.
    pub fn bounds(&self) -> Aabb {
        self.grid.bounds
    }

    /// Cells along x, y and z.
    pub fn counts(&self) -> [usize; 3] {
        self.grid.n
    }

    /// Rays of the three sets.
    pub fn rays(&self) -> usize {
        self.grid.rays()
    }

    /// Intervals of material on a ray, as a mean over all rays.
    pub fn intervals_per_ray(&self) -> f64 {
        self.tiles.iter().map(Tile::ends).sum::<usize>() as f64 / (2 * self.rays().max(1)) as f64
    }

    /// Rays of the three sets that a stock of this box would have.
    pub fn rays_in(bounds: &Aabb, cells: impl Into<Cells>) -> f64 {
        let (size, cells) = (bounds.size(), cells.into().0);
        let n = [0, 1, 2].map(|i| (size[i] / cells[i]).ceil().max(1.0));
        n[1] * n[2] + n[2] * n[0] + n[0] * n[1]
    }

    /// Memory in use, bytes.
    pub fn memory_bytes(&self) -> u64 {
        let tiles = (self.tiles.capacity() * size_of::<Tile>()) as u64;
        let rays = self.tiles.iter().map(Tile::heap_bytes).sum::<u64>();
        let lost = self.lost.iter().map(|l| l.heap_bytes() + size_of::<LastEmptied>() as u64).sum::<u64>();
        tiles
            + rays
            + lost
            + self.changed.len() as u64
            + (self.cut_in.len() * size_of::<u32>()) as u64
            + self.history_bytes()
    }

    pub(crate) fn spans(&self, a: usize, i: usize, j: usize) -> &[MaterialSpan] {
        let (tile, ray) = self.grid.ray_place(a, i, j);
        self.tiles[tile].ray(ray)
    }

    /// Material on the ray `(i, j)` of the set along `axis`; i counts along axis + 1, j along axis + 2
    /// (modulo 3). Empty for a ray that does not exist.
    pub fn ray_intervals(&self, axis: usize, i: usize, j: usize) -> Vec<Interval> {
        if axis > 2 || i >= self.grid.n[(axis + 1) % 3] || j >= self.grid.n[(axis + 2) % 3] {
            return Vec::new();
        }
        let interval = |s: &MaterialSpan| Interval {
            lo: s.lo,
            hi: s.hi,
            lo_made_by: s.lo_mark.made_by(),
            hi_made_by: s.hi_mark.made_by(),
        };
        self.spans(axis, i, j).iter().map(interval).collect()
    }

    /// Material on the ray along `axis` nearest to the place (`u` along axis + 1, `v` along axis + 2, modulo
    /// 3; mm), and the place of that ray.
    pub fn intervals_on(&self, axis: usize, u: f64, v: f64) -> ([f64; 2], Vec<Interval>) {
        let a = axis.min(2);
        let (i, j) = (self.grid.nearest((a + 1) % 3, u), self.grid.nearest((a + 2) % 3, v));
        ([self.grid.center((a + 1) % 3, i), self.grid.center((a + 2) % 3, j)], self.ray_intervals(a, i, j))
    }

    /// Place of ray `(i, j)` of the set along `axis`, mm, in the order of [`Self::ray_intervals`].
    pub fn ray_place(&self, axis: usize, i: usize, j: usize) -> [f64; 2] {
        [self.grid.center((axis + 1) % 3, i), self.grid.center((axis + 2) % 3, j)]
    }

    /// All interval ends: the exact points of the surface, set by set, tile by tile, ray by ray, rising.
    pub fn surface_points(&self) -> impl Iterator<Item = SurfacePoint> + '_ {
        self.tiles.iter().enumerate().flat_map(move |(t, tile)| {
            let (a, [i0, j0]) = self.grid.tile_place(t);
            (0..TILE_RAYS).flat_map(move |r| {
                let u = self.grid.center((a + 1) % 3, i0 + r % TILE);
                let v = self.grid.center((a + 2) % 3, j0 + r / TILE);
                tile.ray(r).iter().flat_map(move |s| {
                    [(s.lo, s.lo_mark), (s.hi, s.hi_mark)].map(|(h, mark)| SurfacePoint {
                        point: RayGrid::point(a, h, u, v),
                        normal: Some(mark.normal()),
                        made_by: mark.made_by(),
                        axis: a as u8,
                    })
                })
            })
        })
    }

    /// Has every removing item report where its body was engaged ([`SweepReport::contact`]); costs the time
    /// of one search for each end of a removed interval.
    ///
    /// [`SweepReport::contact`]: crate::SweepReport::contact
    pub fn watch_engagement(&mut self, on: bool) {
        self.watch_engagement = on;
    }

    /// Has every removing item sort its engagement into steps and slices, until [`Self::take_slices`] takes
    /// them; none ends that. Costs a search for each point of the removed intervals, in steps of the plan.
    /// Sweeps of a share do not sort.
    pub fn watch_slices(&mut self, plan: Option<SlicePlan>) {
        self.slice_plan = plan;
    }

    /// What was sorted since the last call, by item, step and slice.
    pub fn take_slices(&mut self) -> Vec<SliceContact> {
        joined(std::mem::take(&mut self.slices))
    }

    /// True when nothing is left.
    pub fn is_empty(&self) -> bool {
        self.tiles.iter().all(Tile::is_empty)
    }

    /// Remembers that the surface blocks met by a range of removal along the rays of a tile have changed.
    pub(crate) fn mark_changed(&mut self, tile: usize, range: [f64; 2]) {
        let (a, [i0, j0]) = self.grid.tile_place(tile);
        let mut place = [[0_usize; 2]; 3];
        // A node more on each side: the mesh of a block depends on the ring of cells round it.
        let along = |lo: usize, hi: usize, axis: usize| {
            let last = self.grid.n[axis] - 1;
            let block = |i: usize| i.min(last) / crate::field::grid::BLOCK;
            [block(lo.saturating_sub(2)), block(hi + 2)]
        };
        place[a] = along(self.grid.nearest(a, range[0]), self.grid.nearest(a, range[1]), a);
        place[(a + 1) % 3] = along(i0, i0 + TILE - 1, (a + 1) % 3);
        place[(a + 2) % 3] = along(j0, j0 + TILE - 1, (a + 2) % 3);
        let blocks = self.grid.blocks;
        for k in place[2][0]..=place[2][1] {
            for j in place[1][0]..=place[1][1] {
                for i in place[0][0]..=place[0][1] {
                    self.changed[(k * blocks[1] + j) * blocks[0] + i] = true;
                }
            }
        }
    }

    /// Surface blocks that have changed since the last call, in rising order; at first all.
    pub fn take_changed_tiles(&mut self) -> Vec<TileId> {
        let changed: Vec<TileId> =
            self.changed.iter().enumerate().filter(|(_, c)| **c).map(|(k, _)| TileId(k as u32)).collect();
        self.changed.fill(false);
        changed
    }
}
