//! The design in the form that the cut part is compared with, and deviations at places between the
//! measured points.

use std::sync::Arc;

use proveout_blade::{Blade, FOOT_ERROR_MM, NEAREST_ERROR_MM};
use proveout_geom::{CellMap, Point, TriMesh};
use proveout_surface::{DesignMesh, DesignSurface, chord_error};
use rayon::prelude::*;

use crate::{
    observe::surface_map::{MapPoint, SurfaceMap},
    prepare::{
        part_shape::{Shape, flank},
        prepared::Prepared,
    },
};

/// Blades whose sides lean more than this from the X axis by their twist (tangent) are compared
/// with their mesh: the search on the closed form then takes long.
const STEEPEST: f64 = 2.0;

/// The points are compared with a mesh.
pub(crate) const MESH: &str = "mesh";

/// The design in the form that distances are taken to.
pub(crate) struct Design<'a> {
    pub(crate) surface: Arc<dyn DesignSurface>,
    /// Its mesh, where it bounds a solid, with the tree of it.
    solid: Option<(&'a TriMesh, Arc<DesignMesh>)>,
    /// Points farther away belong to another face, mm.
    pub(crate) reach: f64,
    /// Error of the design itself, mm.
    pub(crate) floor: f64,
    /// Error of its mesh, mm, by which the rays are judged: as the scene states it, or as measured against
    /// the closed form.
    pub(crate) solid_floor: f64,
    /// Chord error that the scene asks of the mesh of a closed form, mm.
    pub(crate) mesh_asked: Option<f64>,
    /// What the points are compared with, in words.
    pub(crate) against: &'static str,
    /// Area of the face where it has a closed form, mm².
    pub(crate) area: Option<f64>,
    pub(crate) name: &'static str,
}

impl Design<'_> {
    /// The mesh that bounds it, with its tree.
    pub(crate) fn solid(&self) -> Option<(&TriMesh, &DesignMesh)> {
        self.solid.as_ref().map(|(mesh, tree)| (*mesh, tree.as_ref()))
    }
}

/// Deviation at places of the surface, such as the vertices of the extracted mesh: mean of the
/// exact points in the cell of the place and the cells round it; NaN where there is none. The
/// vertices themselves lie up to some hundredths of a cell off the exact surface, and would color
/// the picture with the error of the extraction.
pub(crate) struct Neighbors {
    cell: f64,
    cells: CellMap<u64, (f64, u32)>,
}

impl Neighbors {
    /// None yet; `cell` is the longest edge of a cell, mm.
    pub(crate) fn new(cell: f64) -> Self {
        Self { cell, cells: CellMap::default() }
    }

    fn place(&self, p: &Point) -> [i64; 3] {
        [p.x, p.y, p.z].map(|v| (v / self.cell).floor() as i64)
    }

    /// Twenty-one bits for each axis.
    fn key(place: [i64; 3]) -> u64 {
        place.into_iter().fold(0, |key, k| key << 21 | (k + (1 << 20)) as u64 & 0x1f_ffff)
    }

    /// Adds a point.
    pub(crate) fn add(&mut self, p: &Point, deviation: f64) {
        let (sum, count) = self.cells.entry(Self::key(self.place(p))).or_default();
        *sum += deviation;
        *count += 1;
    }

    /// Their mean round each place.
    pub(crate) fn at(&self, places: &[Point]) -> Vec<f64> {
        let around = |p: &Point| {
            let [x, y, z] = self.place(p);
            let (mut sum, mut count) = (0.0, 0);
            for i in 0..27 {
                if let Some((s, n)) = self.cells.get(&Self::key([x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])) {
                    sum += s;
                    count += n;
                }
            }
            if count > 0 { sum / f64::from(count) } else { f64::NAN }
        };
        places.par_iter().map(around).collect()
    }
}

fn deviation_at(places: &[Point], points: &[MapPoint], cell: f64) -> Vec<f64> {
    let mut near = Neighbors::new(cell);
    for p in points {
        if let Some(deviation) = p.deviation {
            near.add(&Point::from(p.position), deviation);
        }
    }
    near.at(places)
}

/// Deviation at places that stock and patches of a surface share among each other, see [`Neighbors`].
pub(crate) fn deviation_on(places: &[Point], surface: &SurfaceMap) -> Vec<f64> {
    let mut out = vec![f64::NAN; places.len()];
    for part in 0..=surface.patches.len() {
        let mine: Vec<usize> = (0..places.len()).filter(|&i| surface.part_at(&places[i]) == part).collect();
        let at: Vec<Point> = mine.iter().map(|&i| places[i]).collect();
        let (points, cell) = surface.part(part);
        for (i, value) in mine.into_iter().zip(deviation_at(&at, points, cell)) {
            out[i] = value;
        }
    }
    out
}

/// The design of a scene; none where it has none.
pub(crate) fn design(prepared: &Prepared) -> Option<Design<'_>> {
    let part = prepared.scene.file.part.as_ref()?;
    if let Some(cone) = &part.cone_frustum {
        let (flank, area) = flank(cone);
        return Some(Design {
            surface: Arc::new(flank),
            solid: None,
            reach: cone.reach_mm,
            floor: 0.0,
            solid_floor: 0.0,
            mesh_asked: None,
            against: "closed form of the cone",
            area: Some(area),
            name: "cone flank",
        });
    }
    let mesh = prepared.part_mesh.as_ref()?;
    let tree = Arc::new(DesignMesh::new(mesh).ok()?);
    let steepest = |b: &Blade| {
        let reach = mesh.positions.iter().filter(|p| p.x > 0.0).map(|p| p.y.hypot(p.z)).fold(0.0, f64::max);
        b.spec().twist.abs() * reach
    };
    let closed = part.blade.and_then(|file| file.blade(0.0).ok()).filter(|b| steepest(b) <= STEEPEST);
    let closed = closed.and_then(|b| Some((chord_error(mesh, &b)?, b)));
    let ended = part.blade.filter(|b| b.kind.has_ends()).and_then(|file| {
        match Shape::of_scene(&prepared.scene, &file, 0.0).ok()? {
            Shape::Ended(solid) => Some(*solid),
            _ => None,
        }
    });
    let asked = part.blade.map(|b| b.chord_error_mm);
    let stated = prepared.part_mesh_error.or(asked).unwrap_or(part.chord_error_mm);
    let (surface, floor, solid_floor, against): (Arc<dyn DesignSurface>, _, _, _) = match (closed, ended) {
        (None, Some(solid)) => (Arc::new(solid), FOOT_ERROR_MM, stated, "closed form of the blade"),
        (Some((measured, blade)), _) => (Arc::new(blade), NEAREST_ERROR_MM, measured, "closed form of the blade"),
        (None, None) => (tree.clone(), stated, stated, MESH),
    };
    let name = if part.judged_box.is_some() { "surface in the judged box" } else { "whole surface" };
    Some(Design {
        surface,
        solid: Some((mesh, tree)),
        reach: f64::INFINITY,
        floor,
        solid_floor,
        mesh_asked: asked,
        against,
        area: None,
        name,
    })
}
