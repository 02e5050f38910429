use proveout_geom::{Aabb, Point, TriMesh, Vector};

use crate::{
    StockError,
    grid::{Grid, TILE, TILE_RAYS},
    mesh_rays::mesh_intervals,
    span::{INITIAL, Mark, SLIVER, Span},
    surface::TileId,
    tile::Tile,
};

/// In-process stock: three orthogonal sets of rays with exact interval ends. Frame: that of the constructor's arguments.
///
/// Cells are cubes of `cell_mm` from the lower corner of the stock's box; the rays run through the cell centers. Each
/// interval end remembers the motion that made it and the normal there.
#[derive(Clone, Debug)]
pub struct TriDexel {
    pub(crate) grid: Grid,
    pub(crate) tiles: Vec<Tile>,
    initial_volume: f64,
    pub(crate) sweep_bound: f64,
    changed: Vec<bool>,
}

/// One interval end: an exact point of the stock's surface, within [`TriDexel::sweep_bound_mm`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Place, mm.
    pub point: Point,
    /// Outward unit normal of the stock (stored with 16 bits a coordinate, 7e-5 rad). None where the maker left none.
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

/// Intervals that a ray is counted with in the estimate of memory: deep pockets and slots from several sides leave more,
/// most rays keep one.
const SPANS_PER_RAY: u64 = 2;

impl TriDexel {
    /// Memory that a stock of this box will take, bytes: two intervals a ray and the lists of the tiles.
    pub fn memory_estimate(bounds: &Aabb, cell_mm: f64) -> u64 {
        let size = bounds.size();
        let n = [0, 1, 2].map(|i| (size[i] / cell_mm).ceil().max(1.0));
        let rays = n[1] * n[2] + n[2] * n[0] + n[0] * n[1];
        let per_ray = (SPANS_PER_RAY * size_of::<Span>() as u64) as f64;
        let per_tile = size_of::<Tile>() as f64 / TILE_RAYS as f64;
        (rays * (per_ray + per_tile)) as u64
    }

    /// Checks the cell size against the memory allowed, before anything is allocated.
    fn plan(bounds: &Aabb, cell_mm: f64, limit_bytes: u64) -> Result<Grid, StockError> {
        if !(cell_mm.is_finite() && cell_mm > 0.0) {
            return Err(StockError::Cell { cell_mm });
        }
        let size = bounds.size();
        if (0..3).all(|i| size[i].is_finite() && size[i] > 0.0) {
            let needed = Self::memory_estimate(bounds, cell_mm);
            if needed > limit_bytes {
                let (mut low, mut high) = (cell_mm, cell_mm.max(size.max()));
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if Self::memory_estimate(bounds, middle) > limit_bytes { low = middle } else { high = middle }
                }
                let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
                return Err(StockError::Memory {
                    cell_mm,
                    needed_mib: mib(needed),
                    limit_mib: mib(limit_bytes),
                    fitting_cell_mm: (high * 1e4).ceil() / 1e4,
                });
            }
        }
        Grid::new(bounds, cell_mm)
    }

    /// Fills the rays; `spans(set, u, v)` gives the material over a place, rising and disjoint.
    fn filled(grid: Grid, mut spans: impl FnMut(usize, usize, usize) -> Vec<Span>) -> Self {
        let mut tiles = Vec::with_capacity(grid.first_tile[3]);
        for t in 0..grid.first_tile[3] {
            let (a, [i0, j0]) = grid.tile_place(t);
            let (nu, nv) = (grid.n[(a + 1) % 3], grid.n[(a + 2) % 3]);
            tiles.push(Tile::from_rays(|r, list| {
                let (i, j) = (i0 + r % TILE, j0 + r / TILE);
                if i < nu && j < nv {
                    list.extend(spans(a, i, j));
                }
            }));
        }
        let changed = vec![true; grid.blocks.iter().product()];
        let mut stock = Self { grid, tiles, initial_volume: 0.0, sweep_bound: 0.0, changed };
        stock.initial_volume = stock.volume();
        stock
    }

    /// A block.
    ///
    /// # Errors
    /// [`StockError`] for a cell size or box that makes no grid, or one that needs more than `limit_bytes`.
    pub fn from_box(bounds: &Aabb, cell_mm: f64, limit_bytes: u64) -> Result<Self, StockError> {
        let grid = Self::plan(bounds, cell_mm, limit_bytes)?;
        let b = *bounds;
        let centers = grid.clone();
        Ok(Self::filled(grid, |a, i, j| {
            let (u, v) = ((a + 1) % 3, (a + 2) % 3);
            // The last cell may reach past the box; a center on the upper face is outside, on the lower face inside.
            if centers.center(u, i) >= b.max[u] || centers.center(v, j) >= b.max[v] {
                return Vec::new();
            }
            let mut n = [0.0; 3];
            n[a] = 1.0;
            vec![Span {
                lo: b.min[a],
                hi: b.max[a],
                lo_mark: Mark::new(INITIAL, n.map(|x| -x)),
                hi_mark: Mark::new(INITIAL, n),
            }]
        }))
    }

    /// A bar of `radius` and `length` (mm) from `base` along the unit vector `axis`.
    ///
    /// # Errors
    /// As [`Self::from_box`]; also for a radius or length that is not positive.
    pub fn from_cylinder(
        base: &Point,
        axis: &Vector,
        radius: f64,
        length: f64,
        cell_mm: f64,
        limit_bytes: u64,
    ) -> Result<Self, StockError> {
        let norm = axis.norm();
        if !(radius > 0.0 && length > 0.0 && norm > 0.0 && (radius + length + norm).is_finite()) {
            let what = format!("cylinder of radius {radius} mm, length {length} mm, axis of length {norm}");
            return Err(StockError::Degenerate { what });
        }
        let w = axis / norm;
        let mut bounds = Aabb::empty();
        let half = w.map(|x| radius * (1.0 - x * x).max(0.0).sqrt());
        for c in [*base, base + w * length] {
            bounds.grow(&(c - half));
            bounds.grow(&(c + half));
        }
        let grid = Self::plan(&bounds, cell_mm, limit_bytes)?;
        let centers = grid.clone();
        Ok(Self::filled(grid, |a, i, j| {
            let p = Grid::point(a, 0.0, centers.center((a + 1) % 3, i), centers.center((a + 2) % 3, j));
            cylinder_span(base, &w, radius, length, a, &p).into_iter().collect()
        }))
    }

    /// The inside of a closed mesh.
    ///
    /// # Errors
    /// [`StockError::Mesh`] with the first bad edge when the triangles do not bound a solid, [`StockError::SelfCrossing`]
    /// with the place where they cross themselves; also as [`Self::from_box`].
    pub fn from_mesh(mesh: &TriMesh, cell_mm: f64, limit_bytes: u64) -> Result<Self, StockError> {
        mesh.check_solid()?;
        let grid = Self::plan(&mesh.aabb(), cell_mm, limit_bytes)?;
        let mut sets = Vec::new();
        for a in 0..3 {
            sets.push(mesh_intervals(mesh, &grid, a)?);
        }
        let columns = grid.n;
        Ok(Self::filled(grid, |a, i, j| std::mem::take(&mut sets[a][j * columns[(a + 1) % 3] + i])))
    }

    /// Volume of material, mm³: mean over the three ray sets of length times cell area.
    pub fn volume(&self) -> f64 {
        let area = self.grid.cell * self.grid.cell / 3.0;
        self.tiles.iter().map(|t| t.length() * area).sum()
    }

    /// Volume by one ray set alone (0 x, 1 y, 2 z), mm³.
    pub fn volume_along(&self, axis: usize) -> f64 {
        let tiles = &self.tiles[self.grid.first_tile[axis.min(2)]..self.grid.first_tile[axis.min(2) + 1]];
        tiles.iter().map(|t| t.length() * self.grid.cell * self.grid.cell).sum()
    }

    /// Volume of material before the first cut, mm³, by the same measure as [`Self::volume`].
    pub fn initial_volume(&self) -> f64 {
        self.initial_volume
    }

    /// Largest error of the swept surface of any motion so far, mm, in the direction of the normal; 0 before the first.
    pub fn sweep_bound_mm(&self) -> f64 {
        self.sweep_bound
    }

    /// Edge of a cell, mm.
    pub fn cell_mm(&self) -> f64 {
        self.grid.cell
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

    /// Memory in use, bytes.
    pub fn memory_bytes(&self) -> u64 {
        let tiles = (self.tiles.capacity() * size_of::<Tile>()) as u64;
        tiles + self.tiles.iter().map(Tile::heap_bytes).sum::<u64>() + self.changed.len() as u64
    }

    pub(crate) fn spans(&self, a: usize, i: usize, j: usize) -> &[Span] {
        let (tile, ray) = self.grid.ray_place(a, i, j);
        self.tiles[tile].ray(ray)
    }

    /// Material on the ray `(i, j)` of the set along `axis`; i counts along axis + 1, j along axis + 2 (modulo 3). Empty for
    /// a ray that does not exist.
    pub fn ray_intervals(&self, axis: usize, i: usize, j: usize) -> Vec<Interval> {
        if axis > 2 || i >= self.grid.n[(axis + 1) % 3] || j >= self.grid.n[(axis + 2) % 3] {
            return Vec::new();
        }
        let interval = |s: &Span| Interval {
            lo: s.lo,
            hi: s.hi,
            lo_made_by: s.lo_mark.made_by(),
            hi_made_by: s.hi_mark.made_by(),
        };
        self.spans(axis, i, j).iter().map(interval).collect()
    }

    /// Material on the ray along `axis` nearest to the place (`u` along axis + 1, `v` along axis + 2, modulo 3; mm), and the
    /// place of that ray.
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
                        point: Grid::point(a, h, u, v),
                        normal: Some(mark.normal()),
                        made_by: mark.made_by(),
                        axis: a as u8,
                    })
                })
            })
        })
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
            let block = |i: usize| i.min(last) / crate::grid::BLOCK;
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

/// The part of a line along axis `a` through `p` inside a cylinder.
fn cylinder_span(base: &Point, w: &Vector, radius: f64, length: f64, a: usize, p: &Point) -> Option<Span> {
    let e = Vector::ith(a, 1.0);
    let (mut lo, mut hi) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut lo_normal, mut hi_normal) = (-e, e);
    let y = p - base;
    // Between the two end planes: 0 <= (y + s e) . w <= length.
    let (z, rate) = (y.dot(w), w[a]);
    if rate.abs() > 1e-12 {
        let (s0, s1) = (-z / rate, (length - z) / rate);
        (lo, hi) = (s0.min(s1), s0.max(s1));
        (lo_normal, hi_normal) = if rate > 0.0 { (-w, *w) } else { (*w, -w) };
    } else if !(0.0..length).contains(&z) {
        return None;
    }
    // Within the radius: |q + s f|^2 <= R^2 with the parts of y and e perpendicular to w.
    let (q, f) = (y - w * z, e - w * rate);
    let (f2, qf) = (f.norm_squared(), q.dot(&f));
    let normal_at = |s: f64| (q + f * s) / radius;
    if f2 > 1e-18 {
        let under = qf * qf - f2 * (q.norm_squared() - radius * radius);
        if under <= 0.0 {
            return None;
        }
        let root = under.sqrt();
        let (s0, s1) = ((-qf - root) / f2, (-qf + root) / f2);
        if s0 > lo {
            (lo, lo_normal) = (s0, normal_at(s0));
        }
        if s1 < hi {
            (hi, hi_normal) = (s1, normal_at(s1));
        }
    } else if q.norm_squared() >= radius * radius {
        return None;
    }
    (hi - lo > SLIVER).then(|| Span {
        lo,
        hi,
        lo_mark: Mark::new(INITIAL, lo_normal.into()),
        hi_mark: Mark::new(INITIAL, hi_normal.into()),
    })
}
