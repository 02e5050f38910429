//! Finer patches: a second stock with smaller cells over a box, cut by the same motions in the same order.
//!
//! ```text
//!      +-----------------------------+   stock, coarse cells
//!      |      . . . . . . .          |
//!      |      . +-------+ .          |   the dotted box is the grid of the patch: whole tiles of fine cells,
//!      |      . | window| .          |   counted from the corner of the stock, with at least GUARD cells
//!      |      . +-------+ .          |   round the window
//!      |      . . . . . . .          |   the dots are faces that are none: there the patch was cut off
//!      +-----------------------------+
//! ```
//!
//! Inside of the **window** the surface is that of the patch, outside that of the stock: points by where they
//! lie, meshes cut at the faces of the window. The faces at which the patch was cut off lie outside of the
//! window, and so do the cells whose vertices they could move.
//!
//! The cells of a patch are those that the whole stock would have with the patch's cells: same corner, same
//! tiles of 8 x 8 rays. So its rays are the rays of such a stock (to rounding of their place, 1e-14 mm; bit
//! for bit where the edges of the cells are sums of powers of two), and the sweeps give them the same ends
//! within their bound: a search on a ray begins at the ends of its material, which are others where the box
//! cuts it.

use proveout_geom::{Aabb, Point};
use thiserror::Error;

use crate::{
    StockError,
    field::dexel::{Interval, SurfacePoint, TriDexel},
    field::grid::{Cells, TILE, TileId},
    field::raw_body::RawBody,
    query::surface::SurfaceMesh,
    sweep_item::{Action, SweepItem},
};

/// Fine cells round the window at least: a vertex depends on the cells next to it, and blocks are joined by
/// one more.
const GUARD: f64 = 2.0;
/// Cells across the window at least.
const LEAST_CELLS: f64 = 2.0;
/// Cells that differ by less than this part are equal.
const SAME: f64 = 1e-9;

/// Why a patch cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PatchError {
    /// The box is empty or not finite.
    #[error("its box is empty: along {axis} it goes from {from_mm} to {to_mm} mm")]
    NoVolume {
        /// x, y or z.
        axis: char,
        /// Lower face, mm.
        from_mm: f64,
        /// Upper face, mm.
        to_mm: f64,
    },
    /// The box does not meet the stock.
    #[error(
        "its box lies outside of the stock: along {axis} it goes from {from_mm} to {to_mm} mm, the stock from {stock_from_mm} to \
         {stock_to_mm} mm"
    )]
    Outside {
        /// x, y or z.
        axis: char,
        /// Lower face, mm.
        from_mm: f64,
        /// Upper face, mm.
        to_mm: f64,
        /// Lower face of the stock's box, mm.
        stock_from_mm: f64,
        /// Upper face of the stock's box, mm.
        stock_to_mm: f64,
    },
    /// The box is thinner than two cells.
    #[error(
        "its box is too thin: {size_mm} mm along {axis} within the stock, less than two of its cells of {cell_mm} mm"
    )]
    Thin {
        /// x, y or z.
        axis: char,
        /// Size within the stock, mm.
        size_mm: f64,
        /// Edge of its cells along the axis, mm.
        cell_mm: f64,
    },
    /// The edge of a cell is not a length.
    #[error("its cell_mm = {cell_mm} along {axis} is not a positive length")]
    Cell {
        /// x, y or z.
        axis: char,
        /// The value, mm.
        cell_mm: f64,
    },
    /// The cells are not finer than those of the stock.
    #[error("its cells of {cell_mm} mm along {axis} are not finer than the stock's of {stock_mm} mm")]
    Coarse {
        /// x, y or z.
        axis: char,
        /// Edge of its cells, mm.
        cell_mm: f64,
        /// Edge of the stock's, mm.
        stock_mm: f64,
    },
}

impl PatchError {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NoVolume { .. } => "min_mm must be below max_mm along x, y and z",
            Self::Outside { .. } => "move the box into the stock; coordinates are those of the workpiece frame",
            Self::Thin { .. } => "make the box thicker, or the cells of the patch smaller",
            Self::Cell { .. } => "write for example 0.05, or three lengths for x, y and z",
            Self::Coarse { .. } => {
                "a patch has no edge longer than the stock's and at least one shorter: make its cell_mm smaller, or leave it out"
            }
        }
    }
}

/// Where a patch lies and how fine it is, checked against the stock; nothing is allocated yet.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchPlan {
    window: Aabb,
    grid_bounds: Aabb,
    cells: [f64; 3],
}

impl PatchPlan {
    /// Lays the grid of a patch over the part of `window` inside the box of a stock, in the frame of the
    /// stock.
    ///
    /// A face of the window that reaches the box of the stock is open: the skin of the stock belongs to the
    /// patch.
    ///
    /// # Errors
    /// [`PatchError`] for a window that holds nothing, lies outside or is too thin, and cells that are not
    /// finer.
    pub fn new(
        stock: &Aabb,
        stock_cells: [f64; 3],
        window: &Aabb,
        cells: impl Into<Cells>,
    ) -> Result<Self, PatchError> {
        let cells = cells.into().0;
        let (mut open, mut grid) = (*window, *stock);
        for k in 0..3 {
            let axis = ['x', 'y', 'z'][k];
            let (from_mm, to_mm, cell_mm) = (window.min[k], window.max[k], cells[k]);
            if !(from_mm < to_mm && (from_mm - to_mm).is_finite()) {
                return Err(PatchError::NoVolume { axis, from_mm, to_mm });
            }
            if !(cell_mm > 0.0 && cell_mm.is_finite()) {
                return Err(PatchError::Cell { axis, cell_mm });
            }
            let (low, high) = (stock.min[k], stock.max[k]);
            let (from, to) = (from_mm.max(low), to_mm.min(high));
            if from >= to {
                return Err(PatchError::Outside { axis, from_mm, to_mm, stock_from_mm: low, stock_to_mm: high });
            }
            if cell_mm > stock_cells[k] * (1.0 + SAME) {
                return Err(PatchError::Coarse { axis, cell_mm, stock_mm: stock_cells[k] });
            }
            if to - from < LEAST_CELLS * cell_mm * (1.0 - SAME) {
                return Err(PatchError::Thin { axis, size_mm: to - from, cell_mm });
            }
            let play = SAME * (high - low);
            if from <= low + play {
                open.min[k] = low - stock_cells[k];
            }
            if to >= high - play {
                open.max[k] = high + stock_cells[k];
            }
            let tile = TILE as f64;
            let first = (((from - low) / cell_mm - GUARD) / tile).floor().max(0.0) * tile;
            let last = (((to - low) / cell_mm + GUARD) / tile).ceil() * tile;
            grid.min[k] = low + first * cell_mm;
            grid.max[k] = high.min(low + last * cell_mm);
        }
        let finer = (0..3).any(|k| cells[k] < stock_cells[k] * (1.0 - SAME));
        if !finer {
            return Err(PatchError::Coarse { axis: 'x', cell_mm: cells[0], stock_mm: stock_cells[0] });
        }
        Ok(Self { window: open, grid_bounds: grid, cells })
    }

    /// Where the surface of the patch counts. Faces at the box of the stock lie a cell outside of it.
    pub fn window(&self) -> &Aabb {
        &self.window
    }

    /// Box of the grid: the window and a guard round it, within the stock.
    pub fn grid_bounds(&self) -> &Aabb {
        &self.grid_bounds
    }

    /// Edges of a cell along x, y and z, mm.
    pub fn cells_mm(&self) -> [f64; 3] {
        self.cells
    }

    /// Memory that the patch will take, bytes, see [`TriDexel::memory_estimate`].
    pub fn memory_estimate(&self) -> u64 {
        TriDexel::memory_estimate(&self.grid_bounds, self.cells)
    }
}

/// A stock with finer cells over a box of another one.
#[derive(Clone, Debug)]
pub struct Patch {
    name: String,
    plan: PatchPlan,
    stock: TriDexel,
}

impl Patch {
    /// Fills the rays of a patch.
    ///
    /// # Errors
    /// [`StockError`] where it needs more than `limit_bytes`, and for a mesh that crosses itself on its rays.
    pub fn new(name: &str, plan: PatchPlan, body: &RawBody, limit_bytes: u64) -> Result<Self, StockError> {
        let stock = body.within(&plan.grid_bounds, Cells(plan.cells), limit_bytes)?;
        Ok(Self { name: name.into(), plan, stock })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where its surface counts.
    pub fn window(&self) -> &Aabb {
        &self.plan.window
    }

    /// Its rays. Beyond the window there are faces at which it was cut off.
    pub fn stock(&self) -> &TriDexel {
        &self.stock
    }

    /// The same to be changed: for the history and for [`TriDexel::take_changed_tiles`].
    pub fn stock_mut(&mut self) -> &mut TriDexel {
        &mut self.stock
    }

    /// True in the window, faces included.
    pub fn holds(&self, p: &Point) -> bool {
        self.plan.window.contains(p)
    }

    /// Carries out the removing items, in their order; probes and motions that cannot reach the patch are
    /// left out. What they meet is reported by the stock that the patch belongs to, so that nothing is
    /// counted twice.
    pub fn sweep(&mut self, items: &[SweepItem<'_>]) {
        let near = self.near(items);
        if !near.is_empty() {
            self.stock.sweep(&near);
        }
    }

    /// The items that [`Self::sweep`] carries out: for the stock of the patch in shares.
    pub fn near<'a>(&self, items: &[SweepItem<'a>]) -> Vec<SweepItem<'a>> {
        self.stock.removing_near(items)
    }

    /// The exact points of the surface in the window, in the order of [`TriDexel::surface_points`].
    pub fn surface_points(&self) -> impl Iterator<Item = SurfacePoint> + '_ {
        self.stock.surface_points().filter(|p| self.holds(&p.point))
    }

    /// The surface in the window.
    pub fn surface(&self) -> SurfaceMesh {
        self.stock.surface().inside(&self.plan.window)
    }

    /// The surface of one block of the patch in the window, see [`TriDexel::tile_surface`].
    pub fn tile_surface(&self, tile: TileId, step: usize) -> SurfaceMesh {
        self.stock.tile_surface(tile, step).inside(&self.plan.window)
    }
}

impl TriDexel {
    /// The removing items that may come to the box of the stock.
    pub fn removing_near<'a>(&self, items: &[SweepItem<'a>]) -> Vec<SweepItem<'a>> {
        let bounds = self.bounds();
        let near = |item: &&SweepItem<'_>| item.action == Action::Remove && reaches(item, &bounds);
        items.iter().filter(near).copied().collect()
    }
}

/// Whether the body can come to a box: its piece of axis lies in the sum of the boxes of the tip's path and
/// of the axis at both ends, but for the height of the arc on which the axis turns.
fn reaches(item: &SweepItem<'_>, bounds: &Aabb) -> bool {
    let (body, [from, to]) = (item.body, [item.motion.from, item.motion.to]);
    let heights = [body.z_min(), body.z_max()];
    let along = heights.map(|z| [from.axis * z, to.axis * z]);
    let ends = along.iter().flatten();
    let (low, high) = ends.fold((along[0][0], along[0][0]), |(low, high), p| (low.inf(p), high.sup(p)));
    let path = Aabb { min: from.tip.inf(&to.tip) + low, max: from.tip.sup(&to.tip) + high };
    let reach = heights[0].abs().max(heights[1].abs());
    let arc = reach * (1.0 - (0.5 * from.angle_to(&to)).cos());
    // A number that is not finite meets nothing in either way.
    path.expanded(body.max_radius() + arc).intersects(bounds)
}

/// Material on the ray along `axis` nearest to a place, as [`TriDexel::intervals_on`] gives it, with that of
/// the first patch over the place inside of its window. Neighboring rays of stock and patch may lie some part
/// of a coarse cell apart.
pub fn patched_intervals(stock: &TriDexel, patches: &[Patch], axis: usize, u: f64, v: f64) -> Vec<Interval> {
    let a = axis.min(2);
    let coarse = stock.intervals_on(a, u, v).1;
    let over = |w: &Aabb| {
        let (k, l) = ((a + 1) % 3, (a + 2) % 3);
        (w.min[k]..=w.max[k]).contains(&u) && (w.min[l]..=w.max[l]).contains(&v)
    };
    let mut inside: Vec<&Patch> = patches.iter().filter(|p| over(p.window())).collect();
    inside.sort_by(|p, q| p.window().min[a].total_cmp(&q.window().min[a]));
    // Borders between stock and patches, rising: [from, to] and whose material counts there.
    let mut parts: Vec<([f64; 2], Vec<Interval>)> = Vec::new();
    let mut from = f64::NEG_INFINITY;
    for patch in inside {
        let window = [patch.window().min[a].max(from), patch.window().max[a]];
        parts.push(([from, window[0]], coarse.clone()));
        parts.push((window, patch.stock.intervals_on(a, u, v).1));
        from = window[1];
    }
    parts.push(([from, f64::INFINITY], coarse));
    let mut out: Vec<Interval> = Vec::new();
    for ([from, to], material) in parts {
        for mut piece in material {
            (piece.lo, piece.hi) = (piece.lo.max(from), piece.hi.min(to));
            if piece.lo >= piece.hi {
                continue;
            }
            match out.last_mut() {
                // Cut by a border alone.
                Some(last) if last.hi >= piece.lo => (last.hi, last.hi_made_by) = (piece.hi, piece.hi_made_by),
                _ => out.push(piece),
            }
        }
    }
    out
}
