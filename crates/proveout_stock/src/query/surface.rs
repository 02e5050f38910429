//! Triangles of the stock's surface by dual contouring of the rays.
//!
//! The three ray sets meet in the cell centers: the nodes. Rays along z say which nodes hold material; an
//! edge between a node with and a node without is crossed by the surface, and the ray along that edge gives
//! the exact crossing and normal.
//!
//! ```text
//!      o-----x--*     o without, * with material, x crossings
//!      |     '. |     One vertex for each connected sheet of surface in a dual cell, where the tangent
//!      x--__  v x     planes of its crossings meet (v): edges and corners stay sharp. One quadrilateral
//!      |    ''--|     for each crossed edge, joining the vertices of the four cells round it.
//!      *--------*
//! ```
//!
//! Sheets in a cell are separated by the rule that nodes with material do not connect across a face diagonal.
//! Both cells at a face decide alike, so the mesh is closed wherever the stock is (Ju et al. 2002; Nielson
//! 2004, "Dual Marching Cubes" for the sheets). Details thinner than a cell that hold no node are in the rays
//! but not in the mesh. Vertices stay in their cells, so triangles do not fold over. In few configurations
//! two sheets touch along an edge of the mesh.
//!
//! With a coarser step only every step-th node is used: level of detail for a recording.

use proveout_geom::{Aabb, Point, TriMesh, Vector};
use rayon::prelude::*;

use crate::{
    field::dexel::TriDexel,
    field::grid::{BLOCK, TileId},
    field::regrid_bound::Regrid,
    field::span::{EndMark, INITIAL, SLIVER},
    query::mesh_error::{VertexSpread, spread, to_triangle},
    query::qef::Planes,
    query::sheets::{EDGES, Sheets},
};

/// Sums of unit normals that are shorter have no direction.
const SHORTEST: f64 = 1e-9;

/// Triangles of the surface with what is known at their vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Vertices and triangles, counter-clockwise from outside.
    pub mesh: TriMesh,
    /// Outward unit normals, one a vertex: mean over the crossings of the vertex.
    pub normals: Vec<Vector>,
    /// The sweep item that made the surface at the vertex, one a vertex; none on the initial surface.
    pub made_by: Vec<Option<u32>>,
}

/// Nodes of a level of detail, with one layer of empty nodes around: node p >= 1 is cell (p - 1) * step.
pub(crate) struct Nodes<'a> {
    stock: &'a TriDexel,
    step: usize,
    /// Nodes with cells along x, y, z.
    m: [usize; 3],
    /// Range of nodes that are looked at: first, and one past the last.
    from: [usize; 3],
    to: [usize; 3],
    /// One bit a node, rows along z from `from[2]`, row (i, j) at ((i - from.x) * columns + j - from.y) *
    /// words.
    bits: Vec<u64>,
    words: usize,
    /// Whether the vertices get a bound of their error.
    measured: bool,
}

/// One cell with surface in it.
#[derive(Clone, Copy)]
struct SurfaceCell {
    j: u32,
    k: u32,
    config: u8,
    /// First vertex of the cell in its slab.
    vertex: u32,
}

/// The cells of one x index, sorted by j and k.
#[derive(Default)]
pub(crate) struct Slab {
    cells: Vec<SurfaceCell>,
    row: Vec<u32>,
    pub positions: Vec<Point>,
    pub normals: Vec<Vector>,
    pub made_by: Vec<Option<u32>>,
    /// One a vertex where it is asked for.
    spread: Vec<VertexSpread>,
}

impl TriDexel {
    /// The whole surface at the resolution of the cells.
    pub fn surface(&self) -> SurfaceMesh {
        self.surface_with_step(1)
    }

    /// The whole surface from every `step`-th node in each direction (0 counts as 1).
    pub fn surface_with_step(&self, step: usize) -> SurfaceMesh {
        let step = step.max(1);
        let m = self.grid.n.map(|n| (n - 1) / step + 1);
        extract(self, step, [0; 3], m.map(|m| m + 1), false).0
    }

    /// The whole surface, with bounds of how far it may lie from the true one (see `regrid`).
    pub(crate) fn measured_mesh(&self) -> (TriMesh, Regrid) {
        let (surface, off) = extract(self, 1, [0; 3], self.grid.n.map(|n| n + 1), true);
        (surface.mesh, off)
    }

    /// The surface of one block, from every `step`-th node. The meshes of all blocks together are the whole
    /// surface: vertices on the seams are equal, triangles belong to one block each. Nothing for a block that
    /// does not exist.
    pub fn tile_surface(&self, tile: TileId, step: usize) -> SurfaceMesh {
        // A step that divides the block keeps the nodes of neighboring blocks in line.
        let step = step.clamp(1, BLOCK).next_power_of_two().min(BLOCK);
        let [bx, by, bz] = self.grid.blocks;
        let id = tile.0 as usize;
        if id >= bx * by * bz {
            return SurfaceMesh::default();
        }
        let block = [id % bx, id / bx % by, id / (bx * by)];
        let m = self.grid.n.map(|n| (n - 1) / step + 1);
        let nodes = BLOCK / step;
        // Edges start at the nodes of the block; the first block also owns those from the empty layer.
        let from = [0, 1, 2].map(|a| if block[a] == 0 { 0 } else { block[a] * nodes + 1 });
        let to = [0, 1, 2].map(|a| ((block[a] + 1) * nodes + 1).min(m[a] + 1));
        extract(self, step, from, to, false).0
    }

    /// Number of surface blocks.
    pub fn tile_count(&self) -> usize {
        self.grid.blocks.iter().product()
    }

    /// Box of a block's cells, mm.
    pub fn tile_bounds(&self, tile: TileId) -> Aabb {
        let [bx, by, _] = self.grid.blocks;
        let id = tile.0 as usize;
        let side = Vector::from(self.grid.cells) * BLOCK as f64;
        let place = Vector::new((id % bx) as f64, (id / bx % by) as f64, (id / (bx * by)) as f64);
        let min = self.grid.bounds.min + place.component_mul(&side);
        Aabb { min, max: (min + side).inf(&self.grid.bounds.max) }
    }
}

/// Mesh of the edges that start at the nodes `from..to`, and how far it may be off where it is `measured`.
fn extract(stock: &TriDexel, step: usize, from: [usize; 3], to: [usize; 3], measured: bool) -> (SurfaceMesh, Regrid) {
    let m = stock.grid.n.map(|n| (n - 1) / step + 1);
    // Cells one below the first edge, nodes one above the last cell.
    let first = from.map(|f| f.saturating_sub(1));
    let last = [0, 1, 2].map(|a| (to[a] + 1).min(m[a] + 2));
    if (0..3).any(|a| first[a] + 1 >= last[a]) {
        return (SurfaceMesh::default(), Regrid::default());
    }
    let nodes = Nodes { measured, ..Nodes::new(stock, step, m, first, last) };
    let sheets = Sheets::table();
    let slabs: Vec<Slab> = (first[0]..last[0] - 1).into_par_iter().map(|i| nodes.slab(i, sheets)).collect();
    let mut start = Vec::with_capacity(slabs.len());
    let mut total = 0_u32;
    for s in &slabs {
        start.push(total);
        total += s.positions.len() as u32;
    }
    let parts: Vec<(Vec<[u32; 3]>, Regrid)> = (from[0]..to[0].min(last[0] - 1))
        .into_par_iter()
        .map(|i| nodes.triangles(i, from, to, &slabs, &start, sheets))
        .collect();
    let mut mesh = SurfaceMesh::default();
    for s in slabs {
        mesh.mesh.positions.extend(s.positions);
        mesh.normals.extend(s.normals);
        mesh.made_by.extend(s.made_by);
    }
    let mut off = Regrid::default();
    for (triangles, part) in parts {
        mesh.mesh.triangles.extend(triangles);
        off.surface_mm = off.surface_mm.max(part.surface_mm);
        off.edge_mm = off.edge_mm.max(part.edge_mm);
    }
    (mesh.without_loose_vertices(), off)
}

impl SurfaceMesh {
    /// Drops vertices that no triangle names: those of cells that belong to a neighboring block.
    pub(crate) fn without_loose_vertices(self) -> Self {
        let mut used = vec![false; self.mesh.positions.len()];
        for t in &self.mesh.triangles {
            for &v in t {
                used[v as usize] = true;
            }
        }
        if used.iter().all(|u| *u) {
            return self;
        }
        let mut map = vec![0; used.len()];
        let mut out = Self::default();
        for (v, _) in used.iter().enumerate().filter(|(_, u)| **u) {
            map[v] = out.mesh.positions.len() as u32;
            out.mesh.positions.push(self.mesh.positions[v]);
            out.normals.push(self.normals[v]);
            out.made_by.push(self.made_by[v]);
        }
        out.mesh.triangles = self.mesh.triangles.iter().map(|t| t.map(|v| map[v as usize])).collect();
        out
    }
}

/// Sets the bits `first..end` of a row.
fn set_bits(row: &mut [u64], first: usize, end: usize) {
    for (w, word) in row.iter_mut().enumerate().take(end.div_ceil(64)).skip(first / 64) {
        let from = !0 << first.saturating_sub(64 * w);
        let to = match end - 64 * w {
            left @ 0..64 => (1 << left) - 1,
            _ => !0,
        };
        *word |= from & to;
    }
}

impl<'a> Nodes<'a> {
    /// Those of the range `from..to`.
    pub(crate) fn new(stock: &'a TriDexel, step: usize, m: [usize; 3], from: [usize; 3], to: [usize; 3]) -> Self {
        let words = (to[2] - from[2]).div_ceil(64);
        let columns = to[1] - from[1];
        let mut bits = vec![0_u64; (to[0] - from[0]) * columns * words];
        bits.par_chunks_mut(columns * words).enumerate().for_each(|(i, plane)| {
            let i = i + from[0];
            if i == 0 || i > m[0] {
                return;
            }
            for j in from[1].max(1)..to[1].min(m[1] + 1) {
                let row = &mut plane[(j - from[1]) * words..][..words];
                for span in stock.spans(2, (i - 1) * step, (j - 1) * step) {
                    // Nodes with lo <= center < hi.
                    let node = |z: f64| stock.grid.first_at_or_above(2, z).div_ceil(step) + 1;
                    let [low, high] = [node(span.lo).max(from[2]), node(span.hi).min(to[2]).min(m[2] + 1)];
                    if low < high {
                        set_bits(row, low - from[2], high - from[2]);
                    }
                }
            }
        });
        Self { stock, step, m, from, to, bits, words, measured: false }
    }

    /// Bits of the nodes with these x and y indices.
    pub(crate) fn row(&self, i: usize, j: usize) -> &[u64] {
        let columns = self.to[1] - self.from[1];
        &self.bits[((i - self.from[0]) * columns + j - self.from[1]) * self.words..][..self.words]
    }

    /// Coordinate of the nodes with this index along an axis, mm.
    pub(crate) fn coordinate(&self, axis: usize, p: usize) -> f64 {
        self.stock.grid.bounds.min[axis] + ((p as f64 - 1.0) * self.step as f64 + 0.5) * self.stock.grid.cells[axis]
    }

    /// Cells with x index `i` and their vertices.
    pub(crate) fn slab(&self, i: usize, sheets: &Sheets) -> Slab {
        let mut slab = Slab::default();
        for j in self.from[1]..self.to[1] - 1 {
            slab.row.push(slab.cells.len() as u32);
            let rows = [self.row(i, j), self.row(i + 1, j), self.row(i, j + 1), self.row(i + 1, j + 1)];
            for w in 0..self.words {
                let next = |r: &[u64]| if w + 1 < self.words { r[w + 1] } else { 0 };
                let any = rows.iter().fold(0, |x, r| x | r[w]);
                let any_next = any >> 1 | rows.iter().fold(0, |x, r| x | next(r)) << 63;
                let all = rows.iter().fold(!0, |x, r| x & r[w]);
                let all_next = all >> 1 | rows.iter().fold(!0, |x, r| x & next(r)) << 63;
                let mut mixed = (any | any_next) & !(all & all_next);
                while mixed != 0 {
                    let bit = mixed.trailing_zeros() as usize;
                    mixed &= mixed - 1;
                    let k = w * 64 + bit;
                    if k + 1 >= self.to[2] - self.from[2] {
                        break;
                    }
                    let node = |r: &[u64], k: usize| (r[k / 64] >> (k % 64) & 1) as u8;
                    let mut config = 0;
                    for (c, r) in rows.iter().enumerate() {
                        config |= node(r, k) << c | node(r, k + 1) << (c + 4);
                    }
                    let vertex = slab.positions.len() as u32;
                    self.vertices([i, j, k + self.from[2]], config, sheets, &mut slab);
                    slab.cells.push(SurfaceCell { j: j as u32, k: (k + self.from[2]) as u32, config, vertex });
                }
            }
        }
        slab.row.push(slab.cells.len() as u32);
        slab
    }

    fn vertices(&self, cell: [usize; 3], config: u8, sheets: &Sheets, slab: &mut Slab) {
        let low = Point::from([0, 1, 2].map(|a| self.coordinate(a, cell[a])));
        let high = Point::from([0, 1, 2].map(|a| self.coordinate(a, cell[a] + 1)));
        let middle = nalgebra::center(&low, &high);
        for sheet in 0..sheets.count(config) {
            let mut planes = Planes::new(middle);
            let mut crossings = Vec::new();
            let mut id = INITIAL;
            for edge in 0..EDGES {
                if sheets.of(config, edge) != Some(sheet) {
                    continue;
                }
                let (axis, offset) = Sheets::edge(edge);
                let node = [0, 1, 2].map(|a| cell[a] + offset[a]);
                let inside = Sheets::holds(config, offset);
                let (point, mark) = self.crossing(node, axis, inside);
                let normal = mark.normal();
                planes.add(&point, &normal);
                if self.measured {
                    crossings.push((point, normal));
                }
                // A cut surface counts more than the initial one; among cuts the last.
                if id == INITIAL || (mark.id != INITIAL && mark.id > id) {
                    id = mark.id;
                }
            }
            let vertex = planes.solve().inf(&high).sup(&low);
            if self.measured {
                slab.spread.push(spread(&vertex, &crossings));
            }
            slab.positions.push(vertex);
            slab.normals.push(planes.normal.try_normalize(SHORTEST).unwrap_or_else(Vector::z));
            slab.made_by.push((id != INITIAL).then_some(id));
        }
    }

    /// Where the surface crosses the edge from a node along an axis; `inside`: the node holds material.
    fn crossing(&self, node: [usize; 3], axis: usize, inside: bool) -> (Point, EndMark) {
        let cell = |a: usize| (node[a].clamp(1, self.m[a]) - 1) * self.step;
        let spans = self.stock.spans(axis, cell((axis + 1) % 3), cell((axis + 2) % 3));
        let (x0, x1) = (self.coordinate(axis, node[axis]), self.coordinate(axis, node[axis] + 1));
        let found = if inside {
            spans.iter().find(|s| s.hi >= x0 - SLIVER).map(|s| (s.hi, s.hi_mark))
        } else {
            spans.iter().rev().find(|s| s.lo <= x1 + SLIVER).map(|s| (s.lo, s.lo_mark))
        };
        let mut point = Point::from([0, 1, 2].map(|a| self.coordinate(a, node[a])));
        // The sets may differ by the bound of the sweep: a surface within it of a node is put at the node.
        let (s, mark) = found.unwrap_or_else(|| {
            let mut n = [0.0; 3];
            n[axis] = if inside { 1.0 } else { -1.0 };
            (if inside { x0 } else { x1 }, EndMark::new(INITIAL, n))
        });
        point[axis] = s.clamp(x0, x1);
        (point, mark)
    }

    /// Triangles of the edges that start at nodes with x index `i` in `from..to`. The slabs begin at the
    /// first x index of the nodes; `start` are the numbers of their first vertices.
    pub(crate) fn triangles(
        &self,
        i: usize,
        from: [usize; 3],
        to: [usize; 3],
        slabs: &[Slab],
        start: &[u32],
        sheets: &Sheets,
    ) -> (Vec<[u32; 3]>, Regrid) {
        let mut out = Vec::new();
        let mut off = Regrid::default();
        let find = |c: [usize; 3], edge: usize| -> Option<(u32, &Point, VertexSpread)> {
            let s = c[0].checked_sub(self.from[0])?;
            let slab = slabs.get(s)?;
            let j = c[1].checked_sub(self.from[1])?;
            let row = &slab.cells[*slab.row.get(j)? as usize..*slab.row.get(j + 1)? as usize];
            let cell = row[row.binary_search_by(|x| (x.k as usize).cmp(&c[2])).ok()?];
            let local = cell.vertex as usize + sheets.of(cell.config, edge)?;
            let spread = slab.spread.get(local).copied().unwrap_or_default();
            Some((start[s] + local as u32, &slab.positions[local], spread))
        };
        let Some(slab) = slabs.get(i - self.from[0]) else { return (out, off) };
        for cell in &slab.cells {
            let p = [i, cell.j as usize, cell.k as usize];
            if (0..3).any(|a| p[a] < from[a] || p[a] >= to[a]) {
                continue;
            }
            for axis in 0..3 {
                if sheets.of(cell.config, Sheets::edge_index(axis, 0, 0)).is_none() {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |du: usize, dv: usize| {
                    let mut c = p;
                    c[u] = c[u].checked_sub(du)?;
                    c[v] = c[v].checked_sub(dv)?;
                    find(c, Sheets::edge_index(axis, du, dv))
                };
                let [Some(a), Some(b), Some(c), Some(d)] = [corner(1, 1), corner(0, 1), corner(0, 0), corner(1, 0)]
                else {
                    continue;
                };
                let quad = if cell.config & 1 == 1 { [a, b, c, d] } else { [a, d, c, b] };
                let cut = |k: usize| (quad[k].1 - quad[k + 2].1).norm_squared();
                let halves = if cut(0) <= cut(1) { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
                out.extend(halves.map(|h| h.map(|k| quad[k].0)));
                if self.measured {
                    let (point, _) = self.crossing(p, axis, cell.config & 1 == 1);
                    let near = halves.map(|h| to_triangle(&point, h.map(|k| quad[k].1)));
                    let height = quad.iter().map(|q| q.2.height).fold(0.0, f64::max) + near[0].min(near[1]);
                    let edge = quad.iter().any(|q| q.2.edge);
                    let worst = if edge { &mut off.edge_mm } else { &mut off.surface_mm };
                    *worst = worst.max(height);
                }
            }
        }
        (out, off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_bits_is_that_bit_by_bit() {
        for first in 0..200 {
            for end in first + 1..=200 {
                let (mut row, mut wanted) = ([1_u64 << 5, 0, 0, 1 << 63], [1_u64 << 5, 0, 0, 1 << 63]);
                set_bits(&mut row, first, end);
                (first..end).for_each(|k| wanted[k / 64] |= 1 << (k % 64));
                assert_eq!(row, wanted, "{first} {end}");
            }
        }
    }
}
