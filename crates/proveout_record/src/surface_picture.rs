//! The surface of a run as a picture of bounded size, made while its bands come.
//!
//! Where the surface has more triangles than wanted, its vertices are gathered in cells as
//! [`Picture::clustered`] does. A cell is closed, and takes 28 bytes instead of 200, as soon as no later band
//! can reach it: bands come along x.

use std::collections::BTreeMap;

use proveout_geom::{CellMap, Point, Vector};
use proveout_sim::{
    SurfaceMap, SurfaceShape,
    observer::{MeshPart, PointBand, Setup},
};

use crate::{
    color::DeviationMap,
    deviation_classes::Classes,
    picture::{Cluster, LEAST_CELL_MM, LEAST_SQUARE, NO_AREA, NO_PIECE, Picture, single},
};

/// Part of the triangles of a picture that patches may take together: they are there to be seen.
const FOR_PATCHES: f64 = 0.5;
/// Edge of the cells above the one that area and limit ask for: faces that are slanted against the cells meet
/// more of them than flat ones, and to gather the picture a second time takes 200 bytes a vertex.
const WIDER: f64 = 1.3;
/// Numbers of cells are cut to this: they are whole numbers of 32 bits.
const FARTHEST_CELL: f64 = 1e9;

/// Gathers the points and the meshes of a run's surface.
#[derive(Debug)]
pub(crate) struct SurfacePicture {
    limit: usize,
    /// Whether vertices know the motion piece that made them.
    owned: bool,
    classes: Classes,
    /// Meshes of the patches that are complete.
    patches: Picture,
    now: Option<(Option<usize>, ClusterGather)>,
}

/// What it gives.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShownSurface {
    /// The surface with the deviation (mm) as value of each vertex.
    pub(crate) picture: Picture,
    /// Largest edge (mm) of the cells in which the surface of the stock was gathered, if it was.
    pub(crate) cell: Option<f64>,
    /// Deviations of the points.
    pub(crate) classes: Classes,
}

impl SurfacePicture {
    /// Nothing yet; at most `limit` triangles will be given.
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, owned: false, classes: Classes::default(), patches: Picture::default(), now: None }
    }

    /// The same, whose vertices know the motion piece that made them.
    pub(crate) fn owned(limit: usize) -> Self {
        Self { owned: true, ..Self::new(limit) }
    }

    /// A whole surface at once.
    pub(crate) fn of(surface: &SurfaceMap, limit: usize) -> ShownSurface {
        let mut all = Self::new(limit);
        let shape = surface.shape();
        for band in surface.point_bands() {
            let cells = band.patch.and_then(|k| surface.patches.get(k)).map(|p| p.cells_mm);
            all.count(surface.cells_mm, cells, &band);
        }
        surface.mesh_parts().for_each(|part| all.mesh(&shape, &part));
        all.finish()
    }

    pub(crate) fn points(&mut self, setup: &Setup<'_>, band: &PointBand<'_>) {
        let cells = band.patch.and_then(|k| setup.patches.get(k)).map(|p| p.stock().cells_mm());
        self.count(setup.stock.cells_mm(), cells, band);
    }

    fn count(&mut self, stock_cells: [f64; 3], patch_cells: Option<[f64; 3]>, band: &PointBand<'_>) {
        for p in band.points {
            if let Some(deviation) = p.deviation {
                self.classes.add(deviation, SurfaceShape::weight(stock_cells, patch_cells, p));
            }
        }
    }

    pub(crate) fn mesh(&mut self, shape: &SurfaceShape, part: &MeshPart<'_>) {
        if self.now.as_ref().is_none_or(|(patch, _)| *patch != part.patch) {
            self.close();
            // Patches are gathered on their own, so that a large part does not take their details away.
            let gather = match part.patch.and_then(|k| shape.patches.get(k)) {
                Some(p) => {
                    let each = (FOR_PATCHES * self.limit as f64) as usize / shape.patches.len().max(1);
                    ClusterGather::new(each, p.triangles, p.area_mm2, self.owned)
                }
                None => {
                    let left = self.limit.saturating_sub(self.patches.triangles.len());
                    ClusterGather::new(left, shape.triangles, shape.area_mm2, self.owned)
                }
            };
            self.now = Some((part.patch, gather));
        }
        if let Some((_, gather)) = &mut self.now {
            gather.add(part);
        }
    }

    fn close(&mut self) -> (Picture, Option<f64>) {
        match self.now.take() {
            Some((Some(_), gather)) => self.patches.append(&gather.finish().0),
            Some((None, gather)) => return gather.finish(),
            None => {}
        }
        (Picture::default(), None)
    }

    pub(crate) fn finish(mut self) -> ShownSurface {
        let (mut picture, cell) = self.close();
        picture.append(&self.patches);
        ShownSurface { picture, cell, classes: self.classes }
    }
}

impl ShownSurface {
    /// The color map for its deviations; none when it has none. The range is never below `floor` (mm).
    pub(crate) fn map(&self, floor: f64) -> Option<DeviationMap> {
        self.classes.map(floor)
    }
}

/// Cells of one place along x.
#[derive(Debug, Default)]
struct Slab {
    /// Number of each in the list, by its place along y and z.
    at: CellMap<[i32; 2], u32>,
    /// Vertex of the picture, and what is gathered for it.
    cells: Vec<(u32, Cluster)>,
}

/// A vertex of the mesh.
#[derive(Clone, Copy, Debug)]
struct MeshVertex {
    /// Vertex of the picture; `u32::MAX` for none.
    index: u32,
    place: [f32; 3],
    /// Its cell: place along x, and number in the slab.
    cell: (i32, u32),
}

/// One mesh.
#[derive(Debug)]
struct ClusterGather {
    limit: usize,
    owned: bool,
    /// Edge of the cells; none: every vertex stays.
    cell: Option<f64>,
    out: Picture,
    /// Cells that may still grow, by their place along x.
    open: BTreeMap<i32, Slab>,
    /// The vertices of the band before and of this one.
    known: Vec<MeshVertex>,
    /// Number of the first of them in the mesh, and where this band begins among them.
    first: u32,
    band: usize,
}

impl ClusterGather {
    fn new(limit: usize, triangles: u64, area: f64, owned: bool) -> Self {
        let cell =
            (triangles > limit as u64).then(|| WIDER * (2.0 * area / limit.max(1) as f64).sqrt().max(LEAST_CELL_MM));
        Self {
            limit,
            owned,
            cell,
            out: Picture::default(),
            open: BTreeMap::new(),
            known: Vec::new(),
            first: 0,
            band: 0,
        }
    }

    fn add(&mut self, part: &MeshPart<'_>) {
        // The band before stays, the one before that goes.
        self.known.drain(..self.band);
        self.band = self.known.len();
        self.first = part.first.saturating_sub(self.band as u32);
        if let Some(cell) = self.cell {
            self.close_below(part.from_x, cell);
        }
        for (i, p) in part.positions.iter().enumerate() {
            let normal =
                part.normals.get(i).filter(|n| n.norm_squared() > LEAST_SQUARE && n.norm_squared().is_finite());
            let normal = normal.and_then(|n| n.try_normalize(0.0)).unwrap_or_else(Vector::z);
            let value = part.deviations.get(i).copied();
            let piece = part.made_by.get(i).copied().flatten();
            self.vertex(p, &normal, value, piece);
        }
        for t in part.triangles {
            self.triangle(t);
        }
    }

    fn vertex(&mut self, p: &Point, normal: &Vector, value: Option<f64>, piece: Option<u32>) {
        if !p.iter().all(|v| v.is_finite()) {
            self.known.push(MeshVertex { index: u32::MAX, place: [0.0; 3], cell: (0, 0) });
            return;
        }
        let place = single(&p.coords);
        let next = self.out.positions.len() as u32;
        let (index, cell) = match self.cell {
            None => {
                self.put(place, single(normal), value.map(|v| v as f32), piece);
                (next, (0, 0))
            }
            Some(cell) => {
                let key = place.map(|v| (f64::from(v) / cell).floor() as i32);
                let slab = self.open.entry(key[0]).or_default();
                let fresh = slab.cells.len() as u32;
                let number = *slab.at.entry([key[1], key[2]]).or_insert(fresh);
                if number == fresh {
                    slab.cells.push((next, Cluster::new(key.map(i64::from), cell)));
                }
                let (index, cluster) = &mut slab.cells[number as usize];
                cluster.add_vertex(&place, normal, value);
                let index = *index;
                if index == next {
                    self.put([0.0; 3], [0.0, 0.0, 1.0], value.map(|v| v as f32), piece);
                } else if let (Some(piece), Some(made)) = (piece, self.out.pieces.get_mut(index as usize))
                    && *made == NO_PIECE
                {
                    *made = piece;
                }
                (index, (key[0], number))
            }
        };
        self.known.push(MeshVertex { index, place, cell });
    }

    fn put(&mut self, position: [f32; 3], normal: [f32; 3], value: Option<f32>, piece: Option<u32>) {
        self.out.positions.push(position);
        self.out.normals.push(normal);
        self.out.values.extend(value);
        if self.owned {
            self.out.pieces.push(piece.unwrap_or(NO_PIECE));
        }
    }

    fn triangle(&mut self, t: &[u32; 3]) {
        let found = t.map(|i| i.checked_sub(self.first).and_then(|i| self.known.get(i as usize)).copied());
        let [Some(a), Some(b), Some(c)] = found else { return };
        let ids = [a.index, b.index, c.index];
        if ids.contains(&u32::MAX) {
            return;
        }
        if self.cell.is_none() {
            self.out.triangles.push(ids);
            return;
        }
        let at = [a, b, c].map(|v| Point::from(v.place.map(f64::from)));
        let area = (at[1] - at[0]).cross(&(at[2] - at[0]));
        if let Some(n) = area.try_normalize(NO_AREA) {
            for (k, v) in [a, b, c].iter().enumerate() {
                let (slab, number) = v.cell;
                if !ids[..k].contains(&ids[k])
                    && let Some((_, cluster)) = self.open.get_mut(&slab).and_then(|s| s.cells.get_mut(number as usize))
                {
                    cluster.add_plane(&n, &at[0].coords, area.norm());
                }
            }
        }
        if ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0] {
            let least = (0..3).min_by_key(|&k| ids[k]).unwrap_or(0);
            self.out.triangles.push([ids[least], ids[(least + 1) % 3], ids[(least + 2) % 3]]);
        }
    }

    /// Closes the cells that end below an x.
    fn close_below(&mut self, x: f64, cell: f64) {
        if !x.is_finite() {
            return;
        }
        // A hair less: positions are in single precision.
        let first = (x / cell - 0.01).floor().clamp(-FARTHEST_CELL, FARTHEST_CELL) as i32;
        let rest = self.open.split_off(&first);
        let below = std::mem::replace(&mut self.open, rest);
        self.place_all(below, cell);
    }

    fn place_all(&mut self, slabs: BTreeMap<i32, Slab>, cell: f64) {
        for (index, cluster) in slabs.into_values().flat_map(|slab| slab.cells) {
            self.place(index, &cluster, cell);
        }
    }

    fn place(&mut self, index: u32, cluster: &Cluster, cell: f64) {
        let k = index as usize;
        self.out.positions[k] = single(&cluster.place(cell));
        self.out.normals[k] = single(&cluster.normal());
        if let Some(value) = self.out.values.get_mut(k) {
            *value = cluster.mean_value();
        }
    }

    fn finish(mut self) -> (Picture, Option<f64>) {
        let Some(cell) = self.cell else { return (self.out, None) };
        let open = std::mem::take(&mut self.open);
        self.place_all(open, cell);
        // Two sheets that fall together give the same triangle twice.
        self.out.triangles.sort_unstable();
        self.out.triangles.dedup();
        // More than wanted where the faces are slanted against the cells.
        let (picture, wider) = self.out.reduced(self.limit);
        (picture, Some(wider.unwrap_or(cell)))
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, TriMesh};
    use proveout_stock::TriDexel;

    use super::*;

    /// A box on the rays, with the height as value.
    fn bands(cell: f64) -> (SurfaceShape, Vec<proveout_stock::MeshBand>) {
        let bounds = Aabb { min: Point::new(-3.0, 1.0, 0.0), max: Point::new(37.0, 21.0, 7.0) };
        let stock = TriDexel::from_box(&bounds, cell, 1 << 30).expect("a box");
        let mut all = Vec::new();
        let run: Result<(), ()> = stock.surface_in_bands(|b| {
            all.push(b);
            Ok(())
        });
        run.expect("nothing refuses");
        let area = 2.0 * (40.0 * 20.0 + 40.0 * 7.0 + 20.0 * 7.0);
        let shape = SurfaceShape { triangles: stock.surface_triangles(), area_mm2: area, ..SurfaceShape::default() };
        (shape, all)
    }

    fn gathered(limit: usize, cell: f64) -> (ShownSurface, SurfaceShape) {
        let (shape, bands) = bands(cell);
        let mut picture = SurfacePicture::owned(limit);
        for b in &bands {
            let deviations: Vec<f64> = b.positions.iter().map(|p| p.z).collect();
            picture.mesh(
                &shape,
                &MeshPart {
                    patch: None,
                    first: b.first,
                    from_x: b.from_x,
                    positions: &b.positions,
                    normals: &b.normals,
                    deviations: &deviations,
                    made_by: &b.made_by,
                    triangles: &b.triangles,
                },
            );
        }
        (picture.finish(), shape)
    }

    #[test]
    fn a_small_surface_stays_as_it_is() {
        let (shown, shape) = gathered(1 << 20, 0.5);
        assert_eq!((shown.picture.triangles.len() as u64, shown.cell), (shape.triangles, None));
        assert_eq!(shown.picture.values.len(), shown.picture.positions.len());
    }

    #[test]
    fn a_large_one_is_gathered_in_cells_and_keeps_corners_and_values() {
        let (shown, shape) = gathered(4000, 0.1);
        let picture = &shown.picture;
        assert!(shape.triangles > 200_000 && picture.triangles.len() <= 4000 && picture.triangles.len() > 1000);
        let cell = shown.cell.expect("gathered");
        let bounds = picture.aabb();
        for k in 0..3 {
            let (low, high) = ([-3.0, 1.0, 0.0][k], [37.0, 21.0, 7.0][k]);
            assert!((bounds.min[k] - low).abs() < 1e-4 && (bounds.max[k] - high).abs() < 1e-4, "{bounds:?}");
        }
        for (p, v) in picture.positions.iter().zip(&picture.values) {
            assert!((f64::from(p[2]) - f64::from(*v)).abs() <= cell);
        }
        // Closed: the volume of a box whose faces are kept.
        let mesh = TriMesh {
            positions: picture.positions.iter().map(|p| Point::from(p.map(f64::from))).collect(),
            triangles: picture.triangles.clone(),
        };
        assert!((mesh.volume() / (40.0 * 20.0 * 7.0) - 1.0).abs() < 1e-3, "{}", mesh.volume());
    }
}
