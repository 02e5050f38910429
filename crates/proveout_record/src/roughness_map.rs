//! Roughness maps as pictures: thinned to a bounded number of nodes, with colors by height.

use proveout_geom::Point;
use proveout_sim::{SurfaceTexture, TextureMap, TextureProfile};

use crate::{
    color::{Rgba, STEEL, height_color},
    envelope::Envelope,
    picture::{Picture, single},
    units::UM_PER_MM,
};

/// A map as it is shown.
#[derive(Clone, Debug, Default)]
pub(crate) struct ShownTexture {
    pub(crate) name: String,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Distance of the shown nodes, mm.
    pub(crate) step: [f64; 2],
    /// One of so many nodes is shown.
    pub(crate) every: usize,
    /// Heights, µm, columns fastest; not a number where nothing cuts.
    pub(crate) heights: Vec<f32>,
    pub(crate) points: Vec<Point>,
    pub(crate) normals: Vec<[f32; 3]>,
    /// Degrees from the columns.
    pub(crate) lay: Option<f64>,
    /// Smallest and largest height of all nodes, µm.
    pub(crate) range: [f64; 2],
    pub(crate) profiles: Vec<ShownProfile>,
}

/// A profile as it is shown: smallest and largest heights (µm) over stretches of its length (mm).
#[derive(Clone, Debug, Default)]
pub(crate) struct ShownProfile {
    pub(crate) direction: &'static str,
    /// All points, unfiltered; and the roughness profile over the evaluation length, at its place.
    pub(crate) heights: Envelope,
    pub(crate) roughness: Option<Envelope>,
    /// Length and distance of the points, mm.
    pub(crate) length: f64,
    pub(crate) step: f64,
    pub(crate) class: String,
    pub(crate) ra_rz_um: Option<[f64; 2]>,
}

impl ShownProfile {
    fn of(profile: &TextureProfile) -> Self {
        let envelope = |first: usize, heights: &[f64]| {
            let mut shown = Envelope::default();
            for (k, height) in heights.iter().enumerate() {
                shown.push((first + k) as f64 * profile.step_mm, UM_PER_MM * height);
            }
            shown
        };
        let [all, inner] = [profile.heights.len(), profile.roughness.len()];
        Self {
            direction: profile.direction,
            heights: envelope(0, &profile.heights),
            roughness: (inner > 0).then(|| envelope(all.saturating_sub(inner) / 2, &profile.roughness)),
            length: all.saturating_sub(1) as f64 * profile.step_mm,
            step: profile.step_mm,
            class: profile.class.clone(),
            ra_rz_um: profile.ra_rz_um,
        }
    }
}

impl ShownTexture {
    /// With at most `side` nodes along each side; none of a profile alone without its map.
    pub(crate) fn of(texture: &SurfaceTexture, side: usize) -> Self {
        let profiles = texture.profiles.iter().map(ShownProfile::of).collect();
        let Some(map) = &texture.map else {
            return Self { name: texture.name.clone(), profiles, ..Self::default() };
        };
        let every = (map.columns.max(map.rows) - 1).div_ceil(side.max(2) - 1).max(1);
        let (columns, rows) = ((map.columns - 1) / every + 1, (map.rows - 1) / every + 1);
        let places = || (0..rows).flat_map(|j| (0..columns).map(move |i| (j * map.columns + i) * every));
        Self {
            name: texture.name.clone(),
            profiles,
            columns,
            rows,
            step: map.step_mm.map(|s| s * every as f64),
            every,
            heights: places().map(|k| (UM_PER_MM * map.heights[k]) as f32).collect(),
            points: places().map(|k| map.points[k] + map.normals[k] * finite(map, k)).collect(),
            normals: places().map(|k| single(&map.normals[k])).collect(),
            lay: map.lay_deg,
            range: map
                .heights
                .iter()
                .filter(|h| h.is_finite())
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], h| [a.min(UM_PER_MM * h), b.max(UM_PER_MM * h)]),
        }
    }

    pub(crate) fn is_map(&self) -> bool {
        self.columns > 1 && self.rows > 1
    }

    /// Its colors; those of all maps together where `range` is given, µm.
    pub(crate) fn colors(&self, range: [f64; 2]) -> Vec<Rgba> {
        let [low, high] = range;
        let color = |h: &f32| {
            if h.is_nan() {
                return STEEL;
            }
            let [r, g, b] = height_color(if high > low { (f64::from(*h) - low) / (high - low) } else { 0.5 });
            [r, g, b, 255]
        };
        self.heights.iter().map(color).collect()
    }

    /// As a mesh; cells with a node that nothing cuts are left out.
    pub(crate) fn picture(&self) -> Picture {
        let mut triangles = Vec::new();
        for j in 1..self.rows {
            for i in 1..self.columns {
                let at = |i: usize, j: usize| (j * self.columns + i) as u32;
                let quad = [at(i - 1, j - 1), at(i, j - 1), at(i, j), at(i - 1, j)];
                if quad.iter().all(|k| self.heights[*k as usize].is_finite()) {
                    triangles.push([quad[0], quad[1], quad[2]]);
                    triangles.push([quad[0], quad[2], quad[3]]);
                }
            }
        }
        Picture {
            positions: self.points.iter().map(|p| single(&p.coords)).collect(),
            normals: self.normals.clone(),
            values: Vec::new(),
            pieces: Vec::new(),
            triangles,
        }
    }
}

fn finite(map: &TextureMap, k: usize) -> f64 {
    let h = map.heights[k];
    if h.is_finite() { h } else { 0.0 }
}

/// One range for several maps, µm.
pub(crate) fn range_of(all: &[ShownTexture]) -> [f64; 2] {
    let of = all.iter().filter(|t| t.range[0] <= t.range[1]);
    of.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| [a.min(t.range[0]), b.max(t.range[1])])
}
