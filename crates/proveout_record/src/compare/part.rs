//! The cut part of a comparison as the page shows it: the judged surface and what lies round it, with one set
//! of colors a program and one a difference.

use proveout_geom::{Aabb, Point, TriMesh, Vector};
use proveout_sim::compare::PartPicture;
use serde::Serialize;

use crate::{
    color::{DeviationMap, STEEL},
    page_encoding::{Shades, base64, deflated, pack_mesh},
    picture::Picture,
    units::UM_PER_MM,
};

/// Most triangles of the view.
const VIEW_TRIANGLES: usize = 300_000;
/// What is shown round the judged surface, part of its diagonal.
const AROUND: f64 = 0.2;
/// Smallest range of the colors of a difference, mm: below it there is nothing but rounding.
const DIFFERENCE_FLOOR: f64 = 1e-4;

/// A set of colors: its name and the position of each vertex on its map.
struct ColorLayer {
    name: String,
    map: DeviationMap,
    ends: [&'static str; 2],
    shades: Vec<f64>,
}

/// A set of values laid flat: title and ends of the legend.
#[derive(Serialize)]
pub(crate) struct FlatMap {
    pub(crate) name: String,
    pub(crate) low: String,
    pub(crate) high: String,
}

/// The side of a blade laid flat, one map a layer; data of the script as JSON.
#[derive(Serialize)]
pub(crate) struct FlatSide {
    pub(crate) maps: Vec<FlatMap>,
    pub(crate) data: String,
    /// Ends of arc length and height, mm.
    pub(crate) ends: [String; 4],
}

/// The packed mesh as Base64 and the data of the viewer's script; none where nothing is judged.
pub(crate) struct ColorMapView {
    pub(crate) mesh: String,
    pub(crate) data: String,
    /// Names of the layers.
    pub(crate) layers: Vec<String>,
    /// Index of the layer that is shown first.
    pub(crate) first: usize,
    pub(crate) low: String,
    pub(crate) high: String,
    /// Colors of the map for the style of the legend.
    pub(crate) stops: String,
    /// The side laid flat, where the design is a blade.
    pub(crate) flat: Option<FlatSide>,
}

/// The view of the cut parts.
pub(crate) fn view(part: &PartPicture, names: &[String], baseline: &str) -> Option<ColorMapView> {
    let judged = judged_box(part)?;
    let (mesh, normals, kept) = cropped(part, &grown(&judged));
    let pick = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&i| values[i]).collect() };
    let all: Vec<f64> = part.deviation.iter().flatten().copied().collect();
    let changes: Vec<f64> = part.difference.iter().flatten().copied().collect();
    let deviation_map = DeviationMap::of(&all, DIFFERENCE_FLOOR);
    let change_map = DeviationMap::of(&changes, DIFFERENCE_FLOOR);
    let mut wanted: Vec<Wanted<'_>> = Vec::new();
    for (name, values) in names.iter().zip(&part.difference).filter(|(_, v)| !v.is_empty()) {
        let title = format!("{name} less {baseline}");
        wanted.push((title, change_map, ["less left than the baseline", "more left than the baseline"], values));
    }
    for (name, values) in names.iter().zip(&part.deviation).filter(|(_, v)| !v.is_empty()) {
        wanted.push((name.clone(), deviation_map, ["gouge", "material left"], values));
    }
    let mut shape: Option<Picture> = None;
    let mut layers = Vec::new();
    let flat = flat_maps(part, &wanted);
    for (name, map, ends, values) in wanted {
        // The reduction depends on the shape alone: the same vertices for every set of values.
        let (picture, _) = Picture::new(&mesh, &normals, &pick(values)).reduced(VIEW_TRIANGLES);
        let shades =
            picture.values.iter().map(|v| if v.is_nan() { f64::NAN } else { map.position(f64::from(*v)) }).collect();
        layers.push(ColorLayer { name, map, ends, shades });
        shape.get_or_insert(picture);
    }
    let (shape, first) = (shape?, layers.first()?);
    let byte = |s: &f64| if s.is_nan() { 255 } else { (s.clamp(0.0, 1.0) * 254.0).round() as u8 };
    let coded: Vec<serde_json::Value> = layers
        .iter()
        .map(|l| {
            let [low, high] = legend(l.map, l.ends);
            let shades: Vec<u8> = l.shades.iter().map(byte).collect();
            serde_json::json!({ "low": low, "high": high, "shades": base64(&shades) })
        })
        .collect();
    let map: Vec<u8> = (0..256).flat_map(|i| DeviationMap::at(f64::from(i) / 255.0).into_iter().take(3)).collect();
    let center: [f64; 3] = judged.center().into();
    let data = serde_json::json!({
        "colored": true,
        "map": base64(&map),
        "plain": STEEL[..3],
        "marks": [],
        "focus": { "target": center, "radius": 0.5 * judged.size().norm() },
        "layers": coded,
    });
    let stops: Vec<String> = (0..=16)
        .map(|i| {
            let [r, g, b, _] = DeviationMap::at(f64::from(i) / 16.0);
            format!("#{r:02x}{g:02x}{b:02x}")
        })
        .collect();
    let [low, high] = legend(first.map, first.ends);
    Some(ColorMapView {
        mesh: deflated(&pack_mesh(&shape, Shades::Positions(&first.shades), &[])),
        data: data.to_string().replace('<', "\\u003c"),
        first: 0,
        low,
        high,
        stops: stops.join(", "),
        flat,
        layers: layers.iter().map(|l| l.name.clone()).collect(),
    })
}

/// Name, map, words at its ends, value of each vertex of the whole mesh.
type Wanted<'a> = (String, DeviationMap, [&'static str; 2], &'a [f64]);

fn legend(map: DeviationMap, ends: [&str; 2]) -> [String; 2] {
    let range = micro(map.range);
    [format!("-{range} {}", ends[0]), format!("+{range} {}", ends[1])]
}

/// Most columns of a flat map.
const COLUMNS: f64 = 1000.0;

/// Means over cells that are a little wider than the distance of neighboring points.
fn flat_maps(part: &PartPicture, wanted: &[Wanted<'_>]) -> Option<FlatSide> {
    let known: Vec<(usize, [f64; 2])> =
        part.unrolled.iter().copied().enumerate().filter(|(_, p)| p[0].is_finite() && p[1].is_finite()).collect();
    let bounds = |k: usize| {
        let all = known.iter().map(|(_, p)| p[k]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
    };
    let [[left, right], [bottom, top]] = [bounds(0), bounds(1)];
    let (width, height) = (right - left, top - bottom);
    if !(width > 0.0 && height > 0.0) {
        return None;
    }
    let spacing = 1.5 * (width * height / known.len() as f64).sqrt();
    let columns = (width / spacing).ceil().clamp(1.0, COLUMNS) as usize;
    let rows = (height / spacing).ceil().clamp(1.0, COLUMNS) as usize;
    let cell = |p: &[f64; 2]| {
        let column = ((p[0] - left) / width * columns as f64) as usize;
        let row = ((top - p[1]) / height * rows as f64) as usize;
        row.min(rows - 1) * columns + column.min(columns - 1)
    };
    let mut maps = Vec::new();
    let mut coded = Vec::new();
    for (name, map, ends, values) in wanted {
        let mut sums = vec![(0.0, 0_u32); rows * columns];
        for (i, p) in &known {
            if let Some(v) = values.get(*i).filter(|v| v.is_finite()) {
                let sum = &mut sums[cell(p)];
                *sum = (sum.0 + v, sum.1 + 1);
            }
        }
        let byte = |(sum, count): &(f64, u32)| {
            if *count == 0 { 255 } else { (map.position(sum / f64::from(*count)) * 254.0).round() as u8 }
        };
        let cells: Vec<u8> = sums.iter().map(byte).collect();
        coded.push(serde_json::json!({ "columns": columns, "rows": rows, "cells": base64(&cells) }));
        let [low, high] = legend(*map, *ends);
        maps.push(FlatMap { name: name.clone(), low, high });
    }
    let mm = |v: f64| crate::report::format::fixed(v, 1);
    Some(FlatSide { maps, data: serde_json::json!(coded).to_string(), ends: [mm(0.0), mm(width), mm(bottom), mm(top)] })
}

fn micro(mm: f64) -> String {
    format!("{} µm", crate::report::format::compact(UM_PER_MM * mm))
}

/// Box round the vertices that have a value.
fn judged_box(part: &PartPicture) -> Option<Aabb> {
    let mut all = Aabb::empty();
    for values in &part.deviation {
        for (p, _) in part.mesh.positions.iter().zip(values).filter(|(_, v)| v.is_finite()) {
            all.grow(p);
        }
    }
    (!all.is_empty()).then_some(all)
}

fn grown(judged: &Aabb) -> Aabb {
    let around = Vector::repeat(AROUND * judged.size().norm());
    Aabb { min: judged.min - around, max: judged.max + around }
}

/// The triangles within a box, without unused vertices, and the old index of each vertex.
fn cropped(part: &PartPicture, keep: &Aabb) -> (TriMesh, Vec<Vector>, Vec<usize>) {
    let positions = &part.mesh.positions;
    let inside = |t: &&[u32; 3]| t.iter().all(|&i| positions.get(i as usize).is_some_and(|p| keep.contains(p)));
    let mut new_index = vec![u32::MAX; positions.len()];
    let mut kept = Vec::new();
    let mut triangles = Vec::new();
    for t in part.mesh.triangles.iter().filter(inside) {
        triangles.push(t.map(|i| {
            let index = &mut new_index[i as usize];
            if *index == u32::MAX {
                *index = kept.len() as u32;
                kept.push(i as usize);
            }
            *index
        }));
    }
    let points: Vec<Point> = kept.iter().map(|&i| positions[i]).collect();
    let normals = kept.iter().filter_map(|&i| part.normals.get(i).copied()).collect();
    (TriMesh { positions: points, triangles }, normals, kept)
}
