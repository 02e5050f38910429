//! The cut surface against the design part.

use std::collections::HashMap;

use proveout_geom::{Point, Vector, rad};
use proveout_stock::TriDexel;
use proveout_surface::{
    ConeFlank, ConeFrustum, DesignMesh, DesignSurface, DeviationSettings, SurfaceSample, measure as deviation_of,
};
use rayon::prelude::*;

use crate::{
    prepare::Prepared,
    scene::ConeFrustumFile,
    surface_map::{MapPoint, SurfaceMap},
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

/// Extracts the surface of the cut part and measures it where the scene has a design.
pub(crate) fn measure(prepared: &Prepared, stock: &TriDexel) -> (SurfaceMap, Option<Measured>) {
    let extracted = stock.surface();
    let samples: Vec<SurfaceSample> = stock
        .surface_points()
        .map(|p| SurfaceSample { point: p.point, normal: p.normal, axis: p.axis, made_by: p.made_by })
        .collect();
    let to_map = |s: &SurfaceSample, deviation: Option<f64>| MapPoint {
        position: s.point.coords.into(),
        normal: s.normal.unwrap_or_else(Vector::zeros).into(),
        deviation,
        scallop: None,
        made_by: s.made_by,
    };
    let mut map = SurfaceMap {
        mesh: extracted.mesh,
        normals: extracted.normals,
        vertex_deviation: Vec::new(),
        points: Vec::new(),
    };
    let Some(design) = design(prepared) else {
        map.points = samples.iter().map(|s| to_map(s, None)).collect();
        return (map, None);
    };
    let floor = design.floor + stock.sweep_bound_mm() + stock.regrid_bound().map_or(0.0, |r| r.surface_mm);
    let settings = DeviationSettings {
        range: design.reach,
        region: prepared.scene.file.part.as_ref().and_then(|p| p.judged).map(|b| b.aabb()),
        only_cut: false,
        tolerance_floor: floor,
        cells: stock.cells_mm(),
    };
    let result = deviation_of(&samples, design.surface.as_ref(), &settings);
    map.points =
        samples.iter().zip(&result.values).map(|(s, v)| to_map(s, Some(*v).filter(|v| v.is_finite()))).collect();
    map.vertex_deviation = deviation_at(&map.mesh.positions, &map.points, stock.cell_mm());

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
