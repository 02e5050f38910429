//! The extracted surface of the cut part, band by band to the observers, with the deviation at its vertices.

use proveout_geom::{Aabb, Point, TriMesh};
use proveout_stock::{MeshBand, Patch, SurfaceMesh, TriDexel};

use crate::{
    judge::{design::Neighbors, surface_survey::Surveyed},
    observe::surface_map::MeshPart,
    prepare::error::SimError,
};

/// Receives the bands.
pub(crate) type ShowMesh<'a> = dyn FnMut(&MeshPart<'_>) -> Result<(), SimError> + 'a;

/// Shows the meshes of the patches in their windows, then that of the stock outside of them.
pub(crate) fn show_mesh(
    stock: &TriDexel,
    patches: &[Patch],
    surveyed: &Surveyed,
    show: &mut ShowMesh<'_>,
) -> Result<(), SimError> {
    let judged = surveyed.shape.judged;
    let values = |k: usize| surveyed.deviations.get(k).filter(|_| judged).map_or(&[][..], Vec::as_slice);
    for (k, patch) in patches.iter().enumerate() {
        let cut = |mesh: &SurfaceMesh| mesh.inside(patch.window());
        Shown { stock: patch.stock(), patch: Some(k), values: values(k + 1), judged }.run(Some(&cut), show)?;
    }
    let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
    let cut = |mesh: &SurfaceMesh| mesh.outside(&windows);
    let own = Shown { stock, patch: None, values: values(0), judged };
    own.run(if windows.is_empty() { None } else { Some(&cut) }, show)
}

/// Takes the part of a mesh that is shown.
type Cut<'a> = &'a dyn Fn(&SurfaceMesh) -> SurfaceMesh;

struct Shown<'a> {
    stock: &'a TriDexel,
    patch: Option<usize>,
    values: &'a [f32],
    judged: bool,
}

impl Shown<'_> {
    fn run(&self, cut: Option<Cut<'_>>, show: &mut ShowMesh<'_>) -> Result<(), SimError> {
        let mut before = MeshBand::default();
        let mut first = 0;
        self.stock.surface_in_bands(|band| {
            match cut {
                None => {
                    let deviations = self.deviations(&band.positions);
                    show(&MeshPart {
                        patch: self.patch,
                        first: band.first,
                        from_x: band.from_x,
                        positions: &band.positions,
                        normals: &band.normals,
                        deviations: &deviations,
                        made_by: &band.made_by,
                        triangles: &band.triangles,
                    })?;
                }
                Some(cut) => {
                    let part = cut(&alone(&before, &band));
                    let deviations = self.deviations(&part.mesh.positions);
                    let triangles: Vec<[u32; 3]> = part.mesh.triangles.iter().map(|t| t.map(|i| i + first)).collect();
                    show(&MeshPart {
                        patch: self.patch,
                        first,
                        from_x: band.from_x,
                        positions: &part.mesh.positions,
                        normals: &part.normals,
                        deviations: &deviations,
                        made_by: &part.made_by,
                        triangles: &triangles,
                    })?;
                    first += part.mesh.positions.len() as u32;
                    before = band;
                }
            }
            Ok(())
        })
    }

    /// Deviation at vertices of one band.
    fn deviations(&self, places: &[Point]) -> Vec<f64> {
        if !self.judged {
            return Vec::new();
        }
        let cell = self.stock.cell_mm();
        let mut near = Neighbors::new(cell);
        let bounds = Aabb::of_points(places);
        if !bounds.is_empty() {
            let range = [bounds.min.x - 2.0 * cell, bounds.max.x + 2.0 * cell];
            self.stock.surface_points_between(range, |k, p| {
                if let Some(value) = self.values.get(k).filter(|v| v.is_finite()) {
                    near.add(&p, f64::from(*value));
                }
            });
        }
        near.at(places)
    }
}

/// A band as a mesh of its own: with the vertices of the band before that it names.
fn alone(before: &MeshBand, band: &MeshBand) -> SurfaceMesh {
    let both = |a: &[Point], b: &[Point]| a.iter().chain(b).copied().collect();
    SurfaceMesh {
        mesh: TriMesh {
            positions: both(&before.positions, &band.positions),
            triangles: band.triangles.iter().map(|t| t.map(|i| i - before.first)).collect(),
        },
        normals: before.normals.iter().chain(&band.normals).copied().collect(),
        made_by: before.made_by.iter().chain(&band.made_by).copied().collect(),
    }
}
