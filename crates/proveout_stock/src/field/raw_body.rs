//! What a raw stock is made of, before any ray is: so that the stock and its patches can be planned together.

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector};

use crate::{
    StockError,
    field::dexel::TriDexel,
    field::grid::{Cells, RayGrid},
    field::mesh_rays::Shells,
    field::raw_stock::{Bar, mended},
    field::regrid_bound::Regrid,
    field::span::{EndMark, INITIAL, MaterialSpan, SLIVER},
};

/// Cells along each side of the grid on which intervals are counted; odd, so that its rays do not meet what a
/// drawing puts on halves.
const SAMPLED: f64 = 47.0;

/// A body that fills rays with material, any number of times: once for the stock, once for each of its
/// patches.
#[derive(Clone, Debug)]
pub struct RawBody(RawForm);

#[derive(Clone, Debug)]
enum RawForm {
    Block(Aabb),
    Bar(Bar),
    Mesh(TriMesh, Shells),
    Earlier(Box<EarlierStock>),
}

/// What an earlier run left, in its own frame.
#[derive(Clone, Debug)]
struct EarlierStock {
    stock: TriDexel,
    new_from_old: Pose,
    /// Its surface in the new frame with the bound of that; none where a turn by right angles takes the rays
    /// over.
    surface: Option<(TriMesh, Regrid)>,
    /// Patches of the earlier run, the rest of it where they hold nothing.
    fine: Vec<TriDexel>,
}

/// The form of a raw stock, where it is known between the rays.
#[derive(Debug)]
pub(crate) enum KnownForm<'r> {
    Block(Aabb),
    Bar(&'r Bar),
    Mesh(&'r TriMesh),
}

impl RawBody {
    /// Its form; none of what an earlier run left.
    pub(crate) fn known(&self) -> Option<KnownForm<'_>> {
        match &self.0 {
            RawForm::Block(b) => Some(KnownForm::Block(*b)),
            RawForm::Bar(bar) => Some(KnownForm::Bar(bar)),
            RawForm::Mesh(mesh, _) => Some(KnownForm::Mesh(mesh)),
            RawForm::Earlier(_) => None,
        }
    }

    /// Its triangles, where it is a mesh that was not mended.
    pub fn triangles(&self) -> Option<&TriMesh> {
        match &self.0 {
            RawForm::Mesh(mesh, Shells::Apart) => Some(mesh),
            _ => None,
        }
    }

    /// A block.
    pub fn block(bounds: &Aabb) -> Self {
        Self(RawForm::Block(*bounds))
    }

    /// A bar, see [`TriDexel::from_cylinder`].
    ///
    /// # Errors
    /// [`StockError::Degenerate`] for a radius or length that is not positive.
    pub fn cylinder(base: &Point, axis: &Vector, radius: f64, length: f64) -> Result<Self, StockError> {
        Ok(Self(RawForm::Bar(Bar::new(base, axis, radius, length)?)))
    }

    /// The inside of a closed mesh, see [`TriDexel::from_mesh`].
    ///
    /// # Errors
    /// [`StockError::Mesh`] with the first bad edge.
    pub fn mesh(mesh: TriMesh) -> Result<Self, StockError> {
        mesh.check_solid()?;
        mesh.check_uncrossed()?;
        Ok(Self(RawForm::Mesh(mesh, Shells::Apart)))
    }

    /// The inside of a closed mesh whose faults are mended, see [`TriDexel::from_mesh_repaired`].
    ///
    /// # Errors
    /// [`StockError::Mesh`] for what cannot be mended.
    pub fn repaired_mesh(mesh: &TriMesh) -> Result<Self, StockError> {
        Ok(Self(RawForm::Mesh(mended(mesh)?, Shells::Union)))
    }

    /// What an earlier run left, brought from its frame into the new one, see [`TriDexel::regridded`].
    /// `patches` are those of the earlier run: a new patch that lies in one of them and has its cells takes
    /// its rays over.
    ///
    /// # Errors
    /// [`StockError::Degenerate`] when nothing is left, or the pose is not finite.
    pub fn earlier(stock: TriDexel, patches: Vec<TriDexel>, new_from_old: &Pose) -> Result<Self, StockError> {
        stock.check_left(new_from_old)?;
        Ok(Self(RawForm::Earlier(Box::new(EarlierStock {
            stock,
            new_from_old: *new_from_old,
            surface: None,
            fine: patches,
        }))))
    }

    /// Makes ready for a stock of these cells, with patches or without, and gives the box of the stock.
    ///
    /// # Errors
    /// [`StockError`] for a stock that has no surface, and cells that are no lengths.
    pub fn prepare(&mut self, cells: impl Into<Cells>, with_patches: bool) -> Result<Aabb, StockError> {
        let cells = cells.into();
        if let Some(&cell_mm) = cells.0.iter().find(|c| !(c.is_finite() && **c > 0.0)) {
            return Err(StockError::Cell { cell_mm });
        }
        Ok(match &mut self.0 {
            RawForm::Block(b) => *b,
            RawForm::Bar(bar) => bar.bounds,
            RawForm::Mesh(mesh, _) => mesh.aabb(),
            RawForm::Earlier(e) => {
                let turn = e.stock.exact_turn(&e.new_from_old, cells);
                if turn.is_none() || with_patches {
                    e.surface = Some(e.stock.moved_mesh(&e.new_from_old)?);
                }
                match (turn, &e.surface) {
                    (Some(turn), _) => e.stock.turned_bounds(&turn, &e.new_from_old.translation),
                    (None, Some((mesh, _))) => mesh.aabb(),
                    (None, None) => e.stock.bounds(),
                }
            }
        })
    }

    /// Intervals of material on a ray, as a mean over all rays of its box: counted on some thousand of them,
    /// or on those of the earlier stock.
    pub fn intervals_per_ray(&self) -> f64 {
        let bounds = match &self.0 {
            RawForm::Block(_) => return 1.0,
            RawForm::Earlier(e) => return e.stock.intervals_per_ray(),
            RawForm::Bar(bar) => bar.bounds,
            RawForm::Mesh(mesh, _) => mesh.aabb(),
        };
        let few = self.stock(Cells((bounds.size() / SAMPLED).into()), u64::MAX);
        few.map_or(1.0, |few| few.intervals_per_ray())
    }

    /// Volume of the shape itself, mm³; none of a mesh that was mended, whose shells may cross. That of an
    /// earlier stock is that of its rays.
    pub fn own_volume(&self) -> Option<f64> {
        match &self.0 {
            RawForm::Block(b) => Some(b.size().product()),
            RawForm::Bar(bar) => Some(bar.volume()),
            RawForm::Mesh(mesh, Shells::Apart) => Some(mesh.volume()),
            RawForm::Mesh(_, Shells::Union) => None,
            RawForm::Earlier(e) => Some(e.stock.exact_volume()),
        }
    }

    /// The whole stock.
    ///
    /// # Errors
    /// As the constructors of [`TriDexel`].
    pub fn stock(&self, cells: impl Into<Cells>, limit_bytes: u64) -> Result<TriDexel, StockError> {
        let cells = cells.into();
        match &self.0 {
            RawForm::Block(b) => TriDexel::from_box(b, cells, limit_bytes),
            RawForm::Bar(bar) => Ok(TriDexel::bar_on(TriDexel::plan(&bar.bounds, cells, limit_bytes)?, bar)),
            RawForm::Mesh(mesh, shells) => TriDexel::from_shells(mesh, cells, *shells, limit_bytes),
            RawForm::Earlier(e) => match (&e.surface, e.stock.exact_turn(&e.new_from_old, cells)) {
                (Some((mesh, off)), None) => {
                    let mut new = TriDexel::from_shells(mesh, cells, Shells::Union, limit_bytes)?;
                    (new.regrid, new.sweep_bound) = (Some(*off), e.stock.sweep_bound);
                    Ok(new)
                }
                _ => e.stock.regridded(&e.new_from_old, cells, limit_bytes),
            },
        }
    }

    /// The part of it on the grid of a patch, which lies in `bounds`.
    ///
    /// # Errors
    /// As the constructors of [`TriDexel`].
    pub(crate) fn within(&self, bounds: &Aabb, cells: Cells, limit_bytes: u64) -> Result<TriDexel, StockError> {
        let grid = TriDexel::plan(bounds, cells, limit_bytes)?;
        Ok(match &self.0 {
            RawForm::Block(b) => TriDexel::block_on(grid, b),
            RawForm::Bar(bar) => TriDexel::bar_on(grid, bar),
            RawForm::Mesh(mesh, shells) => TriDexel::shells_on(grid, mesh, *shells)?,
            RawForm::Earlier(e) => return e.within(grid, limit_bytes),
        }
        .kept_to_box())
    }
}

impl EarlierStock {
    fn within(&self, grid: RayGrid, limit_bytes: u64) -> Result<TriDexel, StockError> {
        let cells = Cells(grid.cells);
        for source in self.fine.iter().chain([&self.stock]) {
            if let Some(turn) = source.exact_turn(&self.new_from_old, cells) {
                let turned = source.turned(&turn, &self.new_from_old.translation, limit_bytes)?;
                if let Some(mut part) = turned.part_on(&grid) {
                    part.sweep_bound = source.sweep_bound;
                    return Ok(part.kept_to_box());
                }
            }
        }
        let surface = match &self.surface {
            Some(known) => known.clone(),
            None => self.stock.moved_mesh(&self.new_from_old)?,
        };
        let mut part = TriDexel::shells_on(grid, &surface.0, Shells::Union)?.kept_to_box();
        (part.regrid, part.sweep_bound) = (Some(surface.1), self.stock.sweep_bound);
        Ok(part)
    }
}

/// Part of a cell by which rays of two grids may miss each other and still be the same.
const SAME_RAY: f64 = 1e-6;

impl TriDexel {
    /// Cuts off what reaches out of the box of the grid along the rays.
    pub(crate) fn kept_to_box(mut self) -> Self {
        let (mut tiles, mut before) = (std::mem::take(&mut self.tiles), Vec::new());
        for (t, tile) in tiles.iter_mut().enumerate() {
            let (a, _) = self.grid.tile_place(t);
            let (low, high) = (self.grid.bounds.min[a], self.grid.bounds.max[a]);
            if tile.lo >= low && tile.hi <= high {
                continue;
            }
            let face = |sign: f64| {
                let mut n = [0.0; 3];
                n[a] = sign;
                EndMark::new(INITIAL, n)
            };
            tile.rewrite(&mut before, |_, spans, out| {
                for s in spans {
                    let mut s = *s;
                    if s.lo < low {
                        (s.lo, s.lo_mark) = (low, face(-1.0));
                    }
                    if s.hi > high {
                        (s.hi, s.hi_mark) = (high, face(1.0));
                    }
                    if s.hi - s.lo > SLIVER {
                        out.push(s);
                    }
                }
            });
        }
        self.tiles = tiles;
        self.initial_volume = self.volume();
        self
    }

    /// The rays of a grid that are rays of this one; none where it has others, or does not reach over the
    /// grid.
    fn part_on(&self, grid: &RayGrid) -> Option<Self> {
        let mut first = [0; 3];
        for (k, first) in first.iter_mut().enumerate() {
            let cells = (grid.bounds.min[k] - self.grid.bounds.min[k]) / grid.cells[k];
            let play = SAME_RAY * grid.cells[k];
            let inside = cells > -SAME_RAY && grid.bounds.max[k] <= self.grid.bounds.max[k] + play;
            if !(inside && (cells - cells.round()).abs() < SAME_RAY) {
                return None;
            }
            *first = cells.round() as usize;
        }
        let mut part = Self::filled(grid.clone(), |a, i, j| -> Vec<MaterialSpan> {
            let (u, v) = (i + first[(a + 1) % 3], j + first[(a + 2) % 3]);
            if u < self.grid.n[(a + 1) % 3] && v < self.grid.n[(a + 2) % 3] {
                self.spans(a, u, v).to_vec()
            } else {
                Vec::new()
            }
        });
        part.regrid = self.regrid;
        Some(part)
    }
}
