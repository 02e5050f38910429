//! The rays of a stock row by row, with the intervals of a closed mesh on the same rays: a design
//! can be compared with what is left of the stock ray by ray, without a second stock in memory.
//!
//! A row holds the tiles of a set that lie side by side along u: eight rays along v, all along u. Rows, tiles
//! and rays come in the order of [`TriDexel::surface_points`].

use proveout_geom::{Point, TriMesh, Vector};

use crate::{
    field::dexel::TriDexel,
    field::grid::{RayGrid, TILE, TILE_RAYS},
    field::mesh_rays::{MeshOnRays, Shells},
    field::span::MaterialSpan,
};

/// One ray of a stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayPlace {
    /// Direction: 0 x, 1 y, 2 z.
    pub axis: usize,
    /// Number along axis + 1 and axis + 2 (modulo 3).
    pub index: [usize; 2],
    /// Place along the same axes, mm.
    pub at: [f64; 2],
}

/// One end of material on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayEnd {
    /// Height on the ray, mm.
    pub at: f64,
    /// Outward unit normal of the material (stored with 16 bits a coordinate, 7e-5 rad).
    pub normal: Vector,
    /// The sweep item that made it; none on the initial surface and on a mesh.
    pub made_by: Option<u32>,
}

/// Material on a ray, from `lo` to `hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySpan {
    /// Lower end.
    pub lo: RayEnd,
    /// Upper end.
    pub hi: RayEnd,
}

impl From<&MaterialSpan> for RaySpan {
    fn from(span: &MaterialSpan) -> Self {
        let [lo, hi] = span.ends().map(|e| RayEnd { at: e.s, normal: e.mark.normal(), made_by: e.mark.made_by() });
        Self { lo, hi }
    }
}

impl RayPlace {
    /// The point at a height on the ray.
    pub fn point(&self, at: f64) -> Point {
        RayGrid::point(self.axis, at, self.at[0], self.at[1])
    }
}

impl TriDexel {
    /// The last sweep item that took a whole interval of a ray; none where no item has, and in a stock from a
    /// file.
    pub fn last_to_empty(&self, ray: &RayPlace) -> Option<u32> {
        let [i, j] = ray.index;
        if ray.axis > 2 || i >= self.grid.n[(ray.axis + 1) % 3] || j >= self.grid.n[(ray.axis + 2) % 3] {
            return None;
        }
        let (tile, ray) = self.grid.ray_place(ray.axis, i, j);
        self.lost.get(tile)?.of(ray)
    }
}

impl TriDexel {
    /// Rows of tiles of the set along `axis`.
    pub fn rows(&self, axis: usize) -> usize {
        self.grid.tiles[axis.min(2)][1]
    }

    /// Rays of the tile `tile` of a row, in order; none for a tile that does not exist. The number of tiles
    /// in a row is [`Self::tiles_in_row`].
    pub fn rays_of_tile(&self, axis: usize, row: usize, tile: usize) -> impl Iterator<Item = RayPlace> + '_ {
        let axis = axis.min(2);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let there = row < self.grid.tiles[axis][1] && tile < self.grid.tiles[axis][0];
        (0..if there { TILE_RAYS } else { 0 }).filter_map(move |r| {
            let (i, j) = (tile * TILE + r % TILE, row * TILE + r / TILE);
            let at = [self.grid.center(u, i), self.grid.center(v, j)];
            (i < self.grid.n[u] && j < self.grid.n[v]).then_some(RayPlace { axis, index: [i, j], at })
        })
    }

    /// Tiles side by side in a row of the set along `axis`.
    pub fn tiles_in_row(&self, axis: usize) -> usize {
        self.grid.tiles[axis.min(2)][0]
    }

    /// Material on a ray, rising; none for a ray that does not exist.
    pub fn material(&self, ray: &RayPlace) -> impl Iterator<Item = RaySpan> + '_ {
        let [i, j] = ray.index;
        let there = ray.axis < 3 && i < self.grid.n[(ray.axis + 1) % 3] && j < self.grid.n[(ray.axis + 2) % 3];
        let spans: &[MaterialSpan] = if there { self.spans(ray.axis, i, j) } else { &[] };
        spans.iter().map(RaySpan::from)
    }

    /// The ray of the set along `axis` nearest to a place, moved by `[di, dj]` rays; none where the
    /// stock has none.
    pub fn ray_near(&self, axis: usize, place: &Point, [di, dj]: [isize; 2]) -> Option<RayPlace> {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let index = |k: usize, d: isize| {
            let cell = ((place[k] - self.grid.bounds.min[k]) / self.grid.cells[k]).floor() + d as f64;
            (cell >= 0.0 && cell < self.grid.n[k] as f64).then_some(cell as usize)
        };
        let (i, j) = (index(u, di)?, index(v, dj)?);
        Some(RayPlace { axis, index: [i, j], at: [self.grid.center(u, i), self.grid.center(v, j)] })
    }

    /// Calls with the interval ends from one x to another, each with its number in the order of
    /// [`Self::surface_points`].
    pub fn surface_points_between(&self, [from, to]: [f64; 2], mut see: impl FnMut(usize, Point)) {
        let mut number = 0;
        for (t, tile) in self.tiles.iter().enumerate() {
            let first = number;
            number += tile.ends();
            let (a, [i0, j0]) = self.grid.tile_place(t);
            // Position of x among the axes of the tile: along the rays, u or v.
            let range = match a {
                0 => [tile.lo, tile.hi],
                1 => [self.grid.center(0, j0), self.grid.center(0, j0 + TILE - 1)],
                _ => [self.grid.center(0, i0), self.grid.center(0, i0 + TILE - 1)],
            };
            if range[1] < from || range[0] > to {
                continue;
            }
            let mut number = first;
            for r in 0..TILE_RAYS {
                let at = [self.grid.center((a + 1) % 3, i0 + r % TILE), self.grid.center((a + 2) % 3, j0 + r / TILE)];
                for span in tile.ray(r) {
                    for s in [span.lo, span.hi] {
                        let point = RayGrid::point(a, s, at[0], at[1]);
                        if (from..=to).contains(&point.x) {
                            see(number, point);
                        }
                        number += 1;
                    }
                }
            }
        }
    }

    /// What a closed mesh has on the rays of the set along `axis`. Material is where the winding number is
    /// positive, so that shells that cross count as their union.
    pub fn rows_of_mesh<'a>(&'a self, mesh: &'a TriMesh, axis: usize) -> MeshRows<'a> {
        MeshRows::new(mesh, &self.grid, axis.min(2))
    }
}

/// See [`TriDexel::rows_of_mesh`].
pub struct MeshRows<'a> {
    seen: MeshOnRays<'a>,
    columns: usize,
    lines: usize,
    /// Triangles of row `k`: `start[k]..start[k + 1]` of the list.
    start: Vec<u32>,
    list: Vec<u32>,
}

impl<'a> MeshRows<'a> {
    fn new(mesh: &'a TriMesh, grid: &'a RayGrid, axis: usize) -> Self {
        let seen = MeshOnRays::new(mesh, grid, axis, Shells::Union);
        let rows_of = |t: usize| {
            let lines = seen.range(t, 1);
            if lines.is_empty() || seen.range(t, 0).is_empty() {
                0..0
            } else {
                lines.start / TILE..(lines.end - 1) / TILE + 1
            }
        };
        let mut start = vec![0_u32; grid.tiles[axis][1] + 1];
        for t in 0..mesh.triangles.len() {
            rows_of(t).for_each(|row| start[row + 1] += 1);
        }
        for row in 1..start.len() {
            start[row] += start[row - 1];
        }
        let mut list = vec![0; start.last().map_or(0, |n| *n as usize)];
        let mut cursor = start.clone();
        for t in 0..mesh.triangles.len() {
            rows_of(t).for_each(|row| {
                list[cursor[row] as usize] = t as u32;
                cursor[row] += 1;
            });
        }
        Self { columns: grid.n[(axis + 1) % 3], lines: grid.n[(axis + 2) % 3], seen, start, list }
    }

    /// Its material in a row; nothing for a row that does not exist.
    pub fn row(&self, row: usize) -> RowMaterial {
        let lines = row * TILE..self.lines.min((row + 1) * TILE);
        let mut out = RowMaterial { columns: self.columns, first: lines.start, start: vec![0], spans: Vec::new() };
        let (Some(&from), Some(&to)) = (self.start.get(row), self.start.get(row + 1)) else { return out };
        let triangles = self.list[from as usize..to as usize].iter().map(|t| *t as usize);
        // The union of shells knows no error.
        for spans in self.seen.intervals(triangles, lines).unwrap_or_default() {
            out.spans.extend(spans);
            out.start.push(out.spans.len() as u32);
        }
        out
    }
}

/// What a mesh has on the rays of one row.
#[derive(Clone, Debug, Default)]
pub struct RowMaterial {
    columns: usize,
    /// First ray along v.
    first: usize,
    start: Vec<u32>,
    spans: Vec<MaterialSpan>,
}

impl RowMaterial {
    /// True when there is nothing in the row.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Material on a ray of the row, rising.
    pub fn on(&self, ray: &RayPlace) -> impl Iterator<Item = RaySpan> + '_ {
        let at = ray.index[1].checked_sub(self.first).map(|j| j * self.columns + ray.index[0]);
        let range = at.and_then(|k| Some(*self.start.get(k)? as usize..*self.start.get(k + 1)? as usize));
        self.spans[range.unwrap_or(0..0)].iter().map(RaySpan::from)
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh};

    use super::*;

    #[test]
    fn rows_of_a_mesh_are_the_rays_of_the_stock_made_from_it() {
        let mut mesh = box_mesh(&Aabb { min: Point::new(0.1, 0.2, 0.3), max: Point::new(7.0, 5.0, 4.0) });
        mesh.append(&box_mesh(&Aabb { min: Point::new(8.05, 0.2, 0.3), max: Point::new(8.1, 3.0, 4.0) }));
        let stock = TriDexel::from_mesh(&mesh, 0.25, 1 << 30).expect("solid");
        let mut rays = 0;
        for axis in 0..3 {
            let rows = stock.rows_of_mesh(&mesh, axis);
            for row in 0..stock.rows(axis) {
                let design = rows.row(row);
                for tile in 0..stock.tiles_in_row(axis) {
                    for ray in stock.rays_of_tile(axis, row, tile) {
                        rays += 1;
                        assert!(stock.material(&ray).eq(design.on(&ray)), "{ray:?}");
                    }
                }
            }
            assert_eq!(rows.row(stock.rows(axis)).spans.len(), 0);
        }
        assert_eq!(rays, stock.rays());
        let points: Vec<f64> = stock.surface_points().map(|p| p.point[usize::from(p.axis)]).collect();
        let mut again = Vec::new();
        for axis in 0..3 {
            for (row, tile) in (0..stock.rows(axis)).flat_map(|r| (0..stock.tiles_in_row(axis)).map(move |t| (r, t))) {
                for ray in stock.rays_of_tile(axis, row, tile) {
                    again.extend(stock.material(&ray).flat_map(|s| [s.lo.at, s.hi.at]));
                }
            }
        }
        assert_eq!(points, again, "in the same order");
        let mut between = Vec::new();
        stock.surface_points_between([2.0, 3.0], |k, p| between.push((k, p)));
        let wanted = stock.surface_points().enumerate().map(|(k, p)| (k, p.point));
        assert!(wanted.filter(|(_, p)| (2.0..=3.0).contains(&p.x)).eq(between));
    }
}
