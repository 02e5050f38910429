//! The cut surface against the design part.

use std::collections::HashMap;

use proveout_geom::{Aabb, Point, Vector, rad};
use proveout_stock::{Patch, SurfaceMesh, SurfacePoint, TriDexel};
use proveout_surface::{
    ConeFlank, ConeFrustum, DesignMesh, DesignSurface, Deviation as DeviationOf, DeviationSettings, SurfaceSample,
    measure_where,
};
use rayon::prelude::*;

use crate::{
    prepare::Prepared,
    scene::ConeFrustumFile,
    surface_map::{MapPoint, PatchMap, SurfaceMap},
    verdict::Deviation,
};

/// A face with a closed form counts as measured when at least this part of its area has points. The area that points
/// stand for is known to about one percent on curved faces.
const FULL_COVER: f64 = 0.97;

/// What the measurement says.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub(crate) deviation: Deviation,
    pub(crate) deepest: Option<MapPoint>,
    pub(crate) highest: Option<MapPoint>,
    /// What was measured, in words.
    pub(crate) extent: String,
    /// Parts of the design that were not measured.
    pub(crate) left_out: Vec<String>,
}

/// The design in the form that distances are taken to.
struct Design {
    surface: Box<dyn DesignSurface>,
    /// Points farther away belong to another face, mm.
    reach: f64,
    /// Error of the design itself, mm.
    floor: f64,
    /// Area of the face where it has a closed form, mm².
    area: Option<f64>,
    name: &'static str,
}

/// Surface of the stock or of a patch, measured.
struct Part {
    surface: SurfaceMesh,
    points: Vec<MapPoint>,
    vertex_deviation: Vec<f64>,
    result: Option<DeviationOf>,
}

/// Measures the surface of a stock; only points with `counts` are part of the result. `cut` takes the part of the mesh that
/// is shown.
fn part(
    stock: &TriDexel,
    surface: SurfaceMesh,
    samples: &[SurfaceSample],
    design: Option<&Design>,
    settings: &DeviationSettings,
    counts: impl Fn(&SurfaceSample) -> bool,
) -> Part {
    let settings = DeviationSettings { cells: stock.cells_mm(), ..*settings };
    let result = design.map(|d| measure_where(samples, d.surface.as_ref(), &settings, counts));
    let value = |k: usize| result.as_ref().and_then(|r| r.values.get(k).copied()).filter(|v| v.is_finite());
    let points: Vec<MapPoint> = samples
        .iter()
        .enumerate()
        .map(|(k, s)| MapPoint {
            position: s.point.coords.into(),
            normal: s.normal.unwrap_or_else(Vector::zeros).into(),
            deviation: value(k),
            scallop: None,
            made_by: s.made_by,
        })
        .collect();
    let vertex_deviation = match design {
        Some(_) => deviation_at(&surface.mesh.positions, &points, stock.cell_mm()),
        None => Vec::new(),
    };
    Part { surface, points, vertex_deviation, result }
}

/// Extracts the surface of the cut part and measures it where the scene has a design: in the windows of the patches on their
/// points, elsewhere on those of the stock.
pub(crate) fn measure(prepared: &Prepared, stock: &TriDexel, patches: &[Patch]) -> (SurfaceMap, Option<Measured>) {
    let design = design(prepared);
    let bound = |s: &TriDexel| s.sweep_bound_mm() + s.regrid_bound().map_or(0.0, |r| r.surface_mm);
    let finest = patches.iter().map(|p| bound(p.stock())).fold(bound(stock), f64::max);
    let floor = design.as_ref().map_or(0.0, |d| d.floor) + finest;
    let settings = DeviationSettings {
        range: design.as_ref().map_or(f64::INFINITY, |d| d.reach),
        region: prepared.scene.file.part.as_ref().and_then(|p| p.judged).map(|b| b.aabb()),
        only_cut: false,
        tolerance_floor: floor,
        cells: stock.cells_mm(),
    };
    let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
    // The first patch has a point on the face between two.
    let outside = |point: &Point, windows: &[Aabb]| !windows.iter().any(|w| w.contains(point));

    // Points of the stock under a patch are measured too: vertices at the windows have them as neighbors.
    let samples: Vec<SurfaceSample> = stock.surface_points().map(SurfaceSample::from).collect();
    let own = stock.surface().outside(&windows);
    let whole = part(stock, own, &samples, design.as_ref(), &settings, |s| outside(&s.point, &windows));
    let mut map = SurfaceMap {
        mesh: whole.surface.mesh,
        normals: whole.surface.normals,
        vertex_deviation: whole.vertex_deviation,
        points: whole.points,
        cells_mm: stock.cells_mm(),
        patches: Vec::new(),
    };
    map.points.retain(|p| outside(&Point::from(p.position), &windows));
    let mut result = whole.result;
    for (k, patch) in patches.iter().enumerate() {
        let mine = |p: &SurfacePoint| outside(&p.point, &windows[..k]);
        let samples: Vec<SurfaceSample> = patch.surface_points().filter(mine).map(SurfaceSample::from).collect();
        let fine = part(patch.stock(), patch.surface(), &samples, design.as_ref(), &settings, |_| true);
        let first = map.points.len();
        map.points.extend(fine.points);
        map.patches.push(PatchMap {
            name: patch.name().into(),
            window: *patch.window(),
            cells_mm: patch.stock().cells_mm(),
            mesh: fine.surface.mesh,
            normals: fine.surface.normals,
            vertex_deviation: fine.vertex_deviation,
            points: first..map.points.len(),
        });
        result = result.zip(fine.result).map(|(all, more)| all.joined(&more));
    }
    let (Some(design), Some(result)) = (design, result) else { return (map, None) };

    let counted = || map.points.iter().filter(|p| p.deviation.is_some());
    let by = |p: &&MapPoint| p.deviation.unwrap_or(0.0);
    let deepest = counted().min_by(|a, b| by(a).total_cmp(&by(b))).copied();
    let highest = counted().max_by(|a, b| by(a).total_cmp(&by(b))).copied();
    let mut left_out = Vec::new();
    let mut extent = design.name.to_owned();
    if let Some(area) = design.area {
        let cover = result.area / area;
        extent = format!("{extent}, {:.1} % of its {area:.0} mm2", 100.0 * cover);
        if cover < FULL_COVER {
            left_out.push(format!(
                "{:.1} % of the {} have no surface within {} mm of the design",
                100.0 * (1.0 - cover),
                design.name,
                design.reach
            ));
        }
    }
    if !map.patches.is_empty() {
        let names: Vec<&str> = map.patches.iter().map(|p| p.name.as_str()).collect();
        extent = format!("{extent}, finer in {}", names.join(", "));
    }
    if result.samples == 0 {
        left_out.push("no point of the cut part lies near the design".into());
    }
    let measured = |value: f64| (result.samples > 0).then_some(value);
    let deviation = Deviation {
        tolerance_floor_mm: Some(floor),
        gouge_max_mm: measured(result.gouge_max),
        excess_max_mm: measured(result.excess_max),
        mean_mm: measured(result.mean),
        rms_mm: measured(result.rms),
        gouge_area_mm2: measured(result.gouge_area),
        samples: Some(result.samples),
        worst_point: result.worst.map(|w| w.point.coords.into()),
    };
    (map, Some(Measured { deviation, deepest, highest, extent, left_out }))
}

/// Deviation at places of the surface, such as the vertices of the extracted mesh: mean of the exact points in the
/// cell of the place and the cells round it; NaN where there is none. The vertices themselves lie up to some hundredths of a cell beside the exact surface and
/// would color the picture with the error of the extraction.
///
/// See [`deviation_on`] for places of another surface.
pub(crate) fn deviation_at(places: &[Point], points: &[MapPoint], cell: f64) -> Vec<f64> {
    let key = |p: &[f64; 3]| p.map(|v| (v / cell).floor() as i64);
    let mut cells: HashMap<[i64; 3], (f64, u32)> = HashMap::new();
    for p in points {
        if let Some(deviation) = p.deviation {
            let (sum, count) = cells.entry(key(&p.position)).or_default();
            *sum += deviation;
            *count += 1;
        }
    }
    let around = |p: &Point| {
        let [x, y, z] = key(&[p.x, p.y, p.z]);
        let (mut sum, mut count) = (0.0, 0);
        for i in 0..27 {
            if let Some((s, n)) = cells.get(&[x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]) {
                sum += s;
                count += n;
            }
        }
        if count > 0 { sum / f64::from(count) } else { f64::NAN }
    };
    places.par_iter().map(around).collect()
}

/// The same at places that stock and patches of a surface share among each other.
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

fn design(prepared: &Prepared) -> Option<Design> {
    let part = prepared.scene.file.part.as_ref()?;
    if let Some(cone) = &part.cone_frustum {
        let (flank, area) = flank(cone);
        let surface = Box::new(flank);
        return Some(Design { surface, reach: cone.reach_mm, floor: 0.0, area: Some(area), name: "cone flank" });
    }
    let mesh = prepared.part_mesh.as_ref()?;
    let surface = DesignMesh::new(mesh).ok()?;
    let floor = part.blade.map_or(part.chord_error_mm, |b| b.chord_error_mm);
    let name = if part.judged.is_some() { "surface in the judged box" } else { "whole surface" };
    Some(Design { surface: Box::new(surface), reach: f64::INFINITY, floor, area: None, name })
}

/// The flank between its two distances from the apex, and its area: mean circumference times slant height.
fn flank(cone: &ConeFrustumFile) -> (ConeFlank, f64) {
    let (sine, cosine) = proveout_geom::sin_cos(rad(cone.half_angle_deg));
    let slope = sine / cosine;
    let axis = Vector::from(cone.axis).normalize();
    let frustum = ConeFrustum {
        base: Point::from(cone.apex_mm) + axis * cone.to_mm,
        axis: -axis,
        base_radius: cone.to_mm * slope,
        top_radius: cone.from_mm * slope,
        height: cone.to_mm - cone.from_mm,
    };
    let area = std::f64::consts::PI * (frustum.base_radius + frustum.top_radius) * frustum.height / cosine;
    (ConeFlank { frustum, end_margin: 0.0 }, area)
}
