//! The stock of one setup as the raw stock of the next: another pose, other cells.
//!
//! **Right angles.** When the pose turns by right angles and the cells turn with it, every old ray is a ray
//! of the new grid: ends and normals are taken over, exact but for the rounding of a sum (1e-13 mm).
//!
//! **Any other pose or cell.** The surface is extracted at the resolution of the old cells (dual
//! contouring, `surface`), moved, and cut by the new rays. The mesh meets the true surface where
//! the old rays did; between them the normals give a bound of the error:
//!
//! ```text
//!            v            Two crossings p, q of a cell with their tangents, which meet at v under the
//!          .' '.          angle t. An arc that turns only from one tangent to the other stays in the
//!        .' ___ '.        triangle, so no point of the triangle is farther from the arc than its
//!      .-'       '-.      height h <= |pq| / 2 tan(t / 2).
//!     p_____________q
//! ```
//!
//! The vertex of the mesh lies off its tangent planes by r. A facet is off the crossing it was made for by d.
//! Bound of the facet: largest h + r of its vertices, and d.
//!
//! Where normals in one cell turn by more than 30 degrees the surface has an edge, or a rounding as
//! small as the cells: the rays cannot distinguish them. There the same height counts, but
//! separately, as [`Regrid::edge_mm`]: edges are mostly sharp, and then hit far better. Material or
//! gaps that lie between two nodes of the old grid are left out; the longest counts for the edge
//! bound, too. What no ray of the old stock has met is unknown to it and to the bound.

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector};

use crate::{
    StockError,
    field::dexel::TriDexel,
    field::grid::Cells,
    field::mesh_rays::Shells,
    field::regrid_bound::Regrid,
    field::span::{EndMark, INITIAL, MaterialSpan, SpanEnd},
};

/// Rounding of the rays' places in a mesh, mm.
const ROUNDING: f64 = 2e-6;
/// Cells that differ by less than this part are equal.
const SAME_CELL: f64 = 1e-12;
/// A turn by right angles: coordinate `k` comes from coordinate `from[k]` with `sign[k]`.
pub(crate) struct Turn {
    from: [usize; 3],
    sign: [f64; 3],
}

impl Turn {
    fn of(pose: &Pose) -> Option<Self> {
        let mut turn = Self { from: [0; 3], sign: [0.0; 3] };
        for k in 0..3 {
            for a in 0..3 {
                match pose.rotation[(k, a)] {
                    0.0 => {}
                    x if x.abs() == 1.0 => (turn.from[k], turn.sign[k]) = (a, x),
                    _ => return None,
                }
            }
        }
        let mut sorted = turn.from;
        sorted.sort_unstable();
        (sorted == [0, 1, 2] && turn.sign.iter().all(|s| *s != 0.0)).then_some(turn)
    }
}

impl TriDexel {
    /// How far this stock may lie from the one it was taken over from; none for one that was not.
    pub fn regrid_bound(&self) -> Option<Regrid> {
        self.regrid
    }

    /// The material in another frame and with other cells, as raw stock; `new_from_old` brings it
    /// from the frame of this stock into the new one. [`Self::regrid_bound`] of the result says how
    /// exact it is: nothing is lost when the pose turns by right angles only and the cells turn
    /// with it.
    ///
    /// # Errors
    /// [`StockError`] when nothing is left, or the new cells are none or need more than `limit_bytes`.
    pub fn regridded(
        &self,
        new_from_old: &Pose,
        cells: impl Into<Cells>,
        limit_bytes: u64,
    ) -> Result<Self, StockError> {
        let cells = cells.into();
        self.check_left(new_from_old)?;
        let mut new = match self.exact_turn(new_from_old, cells) {
            Some(turn) => self.turned(&turn, &new_from_old.translation, limit_bytes)?,
            None => self.through_mesh(new_from_old, cells, limit_bytes)?,
        };
        new.sweep_bound = self.sweep_bound;
        Ok(new)
    }

    /// Refuses to be taken over where nothing is left, or to nowhere.
    pub(crate) fn check_left(&self, new_from_old: &Pose) -> Result<(), StockError> {
        if !new_from_old.is_finite() {
            return Err(StockError::Degenerate { what: "its pose is not finite".into() });
        }
        if self.is_empty() {
            return Err(StockError::Degenerate { what: "no material is left in it".into() });
        }
        Ok(())
    }

    /// The turn by right angles that brings this grid exactly onto one with the given cells, if the pose is
    /// one.
    pub(crate) fn exact_turn(&self, new_from_old: &Pose, cells: Cells) -> Option<Turn> {
        let same = |t: &Turn, k: usize| (self.grid.cells[t.from[k]] - cells.0[k]).abs() <= SAME_CELL * cells.0[k];
        Turn::of(new_from_old).filter(|t| (0..3).all(|k| same(t, k)))
    }

    /// Box of the grid after a turn by right angles.
    pub(crate) fn turned_bounds(&self, turn: &Turn, shift: &Vector) -> Aabb {
        let old = &self.grid;
        let mut bounds = Aabb { min: Point::origin(), max: Point::origin() };
        for k in 0..3 {
            let a = turn.from[k];
            (bounds.min[k], bounds.max[k]) = if turn.sign[k] > 0.0 {
                (old.bounds.min[a] + shift[k], old.bounds.max[a] + shift[k])
            } else {
                // The last cell may reach past the box: turned round it is the first one, and the box begins
                // with it.
                let end = old.bounds.min[a] + old.n[a] as f64 * old.cells[a];
                (shift[k] - end, shift[k] - old.bounds.min[a])
            };
        }
        bounds
    }

    pub(crate) fn turned(&self, turn: &Turn, shift: &Vector, limit_bytes: u64) -> Result<Self, StockError> {
        let old = &self.grid;
        let bounds = self.turned_bounds(turn, shift);
        let grid = Self::plan(&bounds, Cells(turn.from.map(|a| old.cells[a])), limit_bytes)?;
        let identity = (0..3).all(|k| turn.from[k] == k && turn.sign[k] > 0.0);
        let end = |e: SpanEnd, k: usize| {
            let mark = if identity {
                EndMark::from_code(INITIAL, e.mark.code())
            } else {
                let n = e.mark.normal();
                EndMark::new(INITIAL, [0, 1, 2].map(|i| turn.sign[i] * n[turn.from[i]]))
            };
            SpanEnd { s: turn.sign[k] * e.s + shift[k], mark }
        };
        let counts = grid.n;
        let mut new = Self::filled(grid, |k, i, j| {
            let mut place = [0; 3];
            for (axis, index) in [((k + 1) % 3, i), ((k + 2) % 3, j)] {
                place[turn.from[axis]] = if turn.sign[axis] > 0.0 { index } else { counts[axis] - 1 - index };
            }
            let a = turn.from[k];
            let (u, v) = (place[(a + 1) % 3], place[(a + 2) % 3]);
            if u >= old.n[(a + 1) % 3] || v >= old.n[(a + 2) % 3] {
                return Vec::new();
            }
            let spans = self.spans(a, u, v).iter().map(|s| s.ends().map(|e| end(e, k)));
            if turn.sign[k] > 0.0 {
                spans.map(|[lo, hi]| MaterialSpan::from_ends(lo, hi)).collect()
            } else {
                spans.rev().map(|[lo, hi]| MaterialSpan::from_ends(hi, lo)).collect()
            }
        });
        new.regrid = self.regrid;
        Ok(new)
    }

    fn through_mesh(&self, new_from_old: &Pose, cells: Cells, limit_bytes: u64) -> Result<Self, StockError> {
        let (mesh, off) = self.moved_mesh(new_from_old)?;
        let mut new = Self::from_shells(&mesh, cells, Shells::Union, limit_bytes)?;
        new.regrid = Some(off);
        Ok(new)
    }

    /// The extracted surface in another pose, and how far a stock made from it may be off.
    pub(crate) fn moved_mesh(&self, new_from_old: &Pose) -> Result<(TriMesh, Regrid), StockError> {
        let (mesh, off) = self.measured_mesh();
        if mesh.triangles.is_empty() {
            return Err(StockError::Degenerate { what: "all that is left of it is thinner than its cells".into() });
        }
        let before = self.regrid.unwrap_or_default();
        let edge = off.edge_mm.max(self.longest_lost());
        let bound = Regrid {
            surface_mm: before.surface_mm + off.surface_mm + ROUNDING,
            edge_mm: before.edge_mm + edge + ROUNDING,
        };
        Ok((mesh.transformed(new_from_old), bound))
    }

    /// Length of the longest interval of material, or gap between two, without a node of the grid, mm.
    fn longest_lost(&self) -> f64 {
        let mut longest = 0.0_f64;
        for a in 0..3 {
            let node = |x: f64| self.grid.first_at_or_above(a, x);
            let mut see = |from: f64, to: f64| {
                if node(from) == node(to) {
                    longest = longest.max(to - from);
                }
            };
            for j in 0..self.grid.n[(a + 2) % 3] {
                for i in 0..self.grid.n[(a + 1) % 3] {
                    let spans = self.spans(a, i, j);
                    spans.iter().for_each(|s| see(s.lo, s.hi));
                    spans.windows(2).for_each(|w| see(w[0].hi, w[1].lo));
                }
            }
        }
        longest
    }
}
