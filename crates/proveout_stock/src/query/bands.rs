//! The mesh of the surface band by band: memory for a band of it instead of the whole.
//!
//! A band is a stretch of nodes along x. Its triangles join vertices of its own cells and of the last cells
//! of the band before, which stay for that long; vertices are numbered through, so that the bands one after
//! the other are the mesh that [`TriDexel::surface`] gives at once.

use proveout_geom::{Point, Vector};
use rayon::prelude::*;

use crate::{
    field::dexel::TriDexel,
    query::sheets::Sheets,
    query::surface::{Nodes, Slab},
};

/// Nodes of a band at least, and vertices about: a band must feed all threads and stay small (some 20 MB).
const LEAST_NODES: usize = 4;
const VERTICES: u64 = 1 << 17;

/// The next part of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshBand {
    /// Vertices before those of this band.
    pub first: u32,
    /// No vertex of this band or a later one, and no triangle of them, reaches below this x, mm.
    pub from_x: f64,
    /// Its vertices, mm.
    pub positions: Vec<Point>,
    /// Outward unit normals.
    pub normals: Vec<Vector>,
    /// The sweep item that made the surface at the vertex.
    pub made_by: Vec<Option<u32>>,
    /// Triangles with the numbers of the whole mesh: vertices of this band and of the one before.
    pub triangles: Vec<[u32; 3]>,
}

impl TriDexel {
    /// Hands out the mesh of [`Self::surface`] band by band.
    ///
    /// # Errors
    /// The first one that `see` gives.
    pub fn surface_in_bands<E>(&self, mut see: impl FnMut(MeshBand) -> Result<(), E>) -> Result<(), E> {
        let m = self.grid.n;
        let last = m[0] + 1; // one past the last cell and the last edge along x
        // About one vertex for two triangles.
        let at_a_node = (self.surface_triangles() / 2).div_ceil(last as u64).max(1);
        let nodes_in_band = ((VERTICES / at_a_node) as usize).max(LEAST_NODES).min(last);
        let sheets = Sheets::table();
        let to = m.map(|m| m + 1);
        let mut before: Option<(Slab, u32)> = None;
        let mut total = 0_u32;
        for first in (0..last).step_by(nodes_in_band) {
            let end = (first + nodes_in_band).min(last);
            let from = [first.saturating_sub(1), 0, 0];
            let nodes = Nodes::new(self, 1, m, from, [end + 1, m[1] + 2, m[2] + 2]);
            let fresh: Vec<Slab> = (first..end).into_par_iter().map(|i| nodes.slab(i, sheets)).collect();
            let from_x = nodes.coordinate(0, from[0]);
            let mut band = MeshBand { first: total, from_x, ..MeshBand::default() };
            let mut start: Vec<u32> = before.iter().map(|b| b.1).collect();
            for s in &fresh {
                start.push(total);
                total += s.positions.len() as u32;
                band.positions.extend_from_slice(&s.positions);
                band.normals.extend_from_slice(&s.normals);
                band.made_by.extend_from_slice(&s.made_by);
            }
            let slabs: Vec<Slab> = before.take().map(|b| b.0).into_iter().chain(fresh).collect();
            let parts: Vec<Vec<[u32; 3]>> = (first..end)
                .into_par_iter()
                .map(|i| nodes.triangles(i, [first, 0, 0], to, &slabs, &start, sheets).0)
                .collect();
            band.triangles = parts.concat();
            before = slabs.into_iter().next_back().zip(start.last().copied());
            see(band)?;
        }
        Ok(())
    }

    /// Number of triangles of [`Self::surface`], without making them: two for each edge between a node with
    /// material and one without.
    pub fn surface_triangles(&self) -> u64 {
        let m = self.grid.n;
        let crossed = |i: usize| -> u64 {
            let nodes = Nodes::new(self, 1, m, [i, 0, 0], [i + 2, m[1] + 2, m[2] + 2]);
            let differ =
                |a: &[u64], b: &[u64]| -> u64 { a.iter().zip(b).map(|(a, b)| u64::from((a ^ b).count_ones())).sum() };
            (0..=m[1])
                .map(|j| {
                    let row = nodes.row(i, j);
                    // Steps along the row: a row begins and ends with empty nodes.
                    let carry = std::iter::once(0).chain(row.iter().map(|w| w >> 63));
                    let along: u64 =
                        row.iter().zip(carry).map(|(w, c)| u64::from((w ^ (w << 1 | c)).count_ones())).sum();
                    along + differ(row, nodes.row(i, j + 1)) + differ(row, nodes.row(i + 1, j))
                })
                .sum()
        };
        2 * (0..=m[0]).into_par_iter().map(crossed).sum::<u64>()
    }
}
