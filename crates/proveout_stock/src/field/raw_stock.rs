//! Raw stock: blocks, bars and closed meshes, and what they cost in memory.

use proveout_geom::{Aabb, MeshError, Point, TriMesh, Vector};

use crate::{
    StockError,
    field::dexel::TriDexel,
    field::grid::{Cells, RayGrid, TILE, TILE_RAYS},
    field::last_emptied::LastEmptied,
    field::mesh_rays::{Shells, mesh_intervals},
    field::span::{EndMark, INITIAL, MaterialSpan, SLIVER},
    field::tile::Tile,
};

/// Intervals that a ray is counted with in the estimate of memory: deep pockets and slots from several sides
/// leave more, most rays keep one.
const SPANS_PER_RAY: u64 = 2;
/// Cells that fit are proposed in parts of a millimeter: a tenth of a micrometer.
const PARTS_OF_MM: f64 = 1e4;
/// Cosine of the angle between a ray and the axis of a cylinder below which no end plane is met.
const ACROSS: f64 = 1e-12;
/// Square of the sine of that angle below which the round face is not met.
const ALONG: f64 = 1e-18;

impl TriDexel {
    /// Memory that a stock of this box will take, bytes: two intervals a ray and the lists of the tiles.
    pub fn memory_estimate(bounds: &Aabb, cells: impl Into<Cells>) -> u64 {
        let rays = Self::rays_in(bounds, cells);
        let per_ray = (SPANS_PER_RAY * size_of::<MaterialSpan>() as u64) as f64;
        let per_tile = size_of::<Tile>() as f64 / TILE_RAYS as f64;
        (rays * (per_ray + per_tile)) as u64
    }

    /// Checks the cell size against the memory allowed, before anything is allocated.
    pub(crate) fn plan(bounds: &Aabb, cells: Cells, limit_bytes: u64) -> Result<RayGrid, StockError> {
        if let Some(&cell_mm) = cells.0.iter().find(|c| !(c.is_finite() && **c > 0.0)) {
            return Err(StockError::Cell { cell_mm });
        }
        let size = bounds.size();
        if (0..3).all(|i| size[i].is_finite() && size[i] > 0.0) {
            let needed = Self::memory_estimate(bounds, cells);
            if needed > limit_bytes {
                // All edges grow alike until it fits.
                let (mut low, mut high) = (1.0, (0..3).map(|i| size[i] / cells.0[i]).fold(1.0, f64::max));
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let wider = Cells(cells.0.map(|c| c * middle));
                    if Self::memory_estimate(bounds, wider) > limit_bytes { low = middle } else { high = middle }
                }
                let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
                let longest = cells.0.into_iter().fold(0.0, f64::max);
                return Err(StockError::Memory {
                    cell_mm: longest,
                    needed_mib: mib(needed),
                    limit_mib: mib(limit_bytes),
                    fitting_cell_mm: (longest * high * PARTS_OF_MM).ceil() / PARTS_OF_MM,
                });
            }
        }
        RayGrid::new(bounds, cells.0)
    }

    /// Fills the rays; `spans(set, u, v)` gives the material over a place, rising and disjoint.
    pub(crate) fn filled(grid: RayGrid, mut spans: impl FnMut(usize, usize, usize) -> Vec<MaterialSpan>) -> Self {
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
        let mut stock = Self {
            lost: vec![LastEmptied::default(); tiles.len()],
            passes: 0,
            cut_in: vec![0; tiles.len()],
            grid,
            tiles,
            initial_volume: 0.0,
            sweep_bound: 0.0,
            regrid: None,
            changed,
            history: None,
            watch_engagement: false,
            slice_plan: None,
            slices: Vec::new(),
            empty_rows: Vec::new(),
        };
        stock.initial_volume = stock.volume();
        stock
    }

    /// A block.
    ///
    /// ```
    /// use proveout_geom::{Aabb, Point};
    /// use proveout_stock::{StockError, TriDexel};
    ///
    /// let block = Aabb { min: Point::origin(), max: Point::new(20.0, 16.0, 8.0) }; // mm
    /// let stock = TriDexel::from_box(&block, 0.5, 1 << 30)?; // cells of 0.5 mm, at most 1 GiB
    /// assert_eq!(stock.counts(), [40, 32, 16]);
    /// assert!((stock.volume() - 2560.0).abs() < 1e-9); // mm3
    /// let refused = TriDexel::from_box(&block, 0.001, 1 << 20);
    /// assert!(matches!(refused, Err(StockError::Memory { .. })));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`StockError`] for a cell size or box that makes no grid, or one that needs more than `limit_bytes`.
    pub fn from_box(bounds: &Aabb, cells: impl Into<Cells>, limit_bytes: u64) -> Result<Self, StockError> {
        Ok(Self::block_on(Self::plan(bounds, cells.into(), limit_bytes)?, bounds))
    }

    /// The rays of a grid through a block; the grid may be smaller than the block.
    pub(crate) fn block_on(grid: RayGrid, b: &Aabb) -> Self {
        let centers = grid.clone();
        Self::filled(grid, |a, i, j| {
            let (u, v) = ((a + 1) % 3, (a + 2) % 3);
            // The last cell may reach past the box; a center on the upper face is outside, on the lower face
            // inside.
            if centers.center(u, i) >= b.max[u] || centers.center(v, j) >= b.max[v] {
                return Vec::new();
            }
            let mut n = [0.0; 3];
            n[a] = 1.0;
            vec![MaterialSpan {
                lo: b.min[a],
                hi: b.max[a],
                lo_mark: EndMark::new(INITIAL, n.map(|x| -x)),
                hi_mark: EndMark::new(INITIAL, n),
            }]
        })
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
        cells: impl Into<Cells>,
        limit_bytes: u64,
    ) -> Result<Self, StockError> {
        let bar = Bar::new(base, axis, radius, length)?;
        Ok(Self::bar_on(Self::plan(&bar.bounds, cells.into(), limit_bytes)?, &bar))
    }

    /// The rays of a grid through a bar.
    pub(crate) fn bar_on(grid: RayGrid, bar: &Bar) -> Self {
        let centers = grid.clone();
        Self::filled(grid, |a, i, j| {
            let p = RayGrid::point(a, 0.0, centers.center((a + 1) % 3, i), centers.center((a + 2) % 3, j));
            cylinder_span(&bar.base, &bar.axis, bar.radius, bar.length, a, &p).into_iter().collect()
        })
    }

    /// The inside of a closed mesh.
    ///
    /// # Errors
    /// [`StockError::Mesh`] with the first bad edge when the triangles do not bound a solid or cross
    /// themselves, [`StockError::SelfCrossing`] where shells lie in each other; also as [`Self::from_box`].
    pub fn from_mesh(mesh: &TriMesh, cells: impl Into<Cells>, limit_bytes: u64) -> Result<Self, StockError> {
        mesh.check_solid()?;
        mesh.check_uncrossed()?;
        Self::from_shells(mesh, cells.into(), Shells::Apart, limit_bytes)
    }

    /// The inside of a closed mesh with faults that can be mended without a guess: equal corners that are not
    /// joined, faces that look inward all together, shells that cross each other or themselves. The union of
    /// the shells counts: material is where the winding number is positive.
    ///
    /// # Errors
    /// [`StockError::Mesh`] for holes and faces that are turned against their neighbors; also as
    /// [`Self::from_box`].
    pub fn from_mesh_repaired(mesh: &TriMesh, cells: impl Into<Cells>, limit_bytes: u64) -> Result<Self, StockError> {
        Self::from_shells(&mended(mesh)?, cells.into(), Shells::Union, limit_bytes)
    }

    pub(crate) fn from_shells(
        mesh: &TriMesh,
        cells: Cells,
        shells: Shells,
        limit_bytes: u64,
    ) -> Result<Self, StockError> {
        Self::shells_on(Self::plan(&mesh.aabb(), cells, limit_bytes)?, mesh, shells)
    }

    /// The rays of a grid through a mesh.
    pub(crate) fn shells_on(grid: RayGrid, mesh: &TriMesh, shells: Shells) -> Result<Self, StockError> {
        let mut sets = Vec::new();
        for a in 0..3 {
            sets.push(mesh_intervals(mesh, &grid, a, shells)?);
        }
        let columns = grid.n;
        Ok(Self::filled(grid, |a, i, j| std::mem::take(&mut sets[a][j * columns[(a + 1) % 3] + i])))
    }
}

/// A closed mesh with its faults mended, see [`TriDexel::from_mesh_repaired`].
pub(crate) fn mended(mesh: &TriMesh) -> Result<TriMesh, StockError> {
    let mut mesh = mesh.merge_equal_vertices();
    if let Err(MeshError::InsideOut { .. }) = mesh.check_solid() {
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
    mesh.check_solid()?;
    Ok(mesh)
}

/// A round bar.
#[derive(Clone, Debug)]
pub(crate) struct Bar {
    pub base: Point,
    /// Unit vector from the base.
    pub axis: Vector,
    pub radius: f64,
    pub length: f64,
    pub bounds: Aabb,
}

impl Bar {
    pub(crate) fn new(base: &Point, axis: &Vector, radius: f64, length: f64) -> Result<Self, StockError> {
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
        Ok(Self { base: *base, axis: w, radius, length, bounds })
    }

    pub(crate) fn volume(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius * self.length
    }
}

/// The part of a line along axis `a` through `p` inside a cylinder.
fn cylinder_span(base: &Point, w: &Vector, radius: f64, length: f64, a: usize, p: &Point) -> Option<MaterialSpan> {
    let e = Vector::ith(a, 1.0);
    let (mut lo, mut hi) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut lo_normal, mut hi_normal) = (-e, e);
    let y = p - base;
    // Between the two end planes: 0 <= (y + s e) . w <= length.
    let (z, rate) = (y.dot(w), w[a]);
    if rate.abs() > ACROSS {
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
    if f2 > ALONG {
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
    (hi - lo > SLIVER).then(|| MaterialSpan {
        lo,
        hi,
        lo_mark: EndMark::new(INITIAL, lo_normal.into()),
        hi_mark: EndMark::new(INITIAL, hi_normal.into()),
    })
}
