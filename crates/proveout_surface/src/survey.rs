//! The whole surface of a stock compared with a design, band by band.
//!
//! A band is some rows of rays. Its points are measured and its rays compared with the design in parallel;
//! what came out is handed on in the order of the rays, so that nothing depends on the number of threads and
//! no more than a band is in memory.

use proveout_geom::{Aabb, TriMesh};
use proveout_stock::{RayPlace, RaySpan, RowMaterial, TriDexel};
use rayon::prelude::*;

use crate::{
    DesignMesh, DesignSurface,
    deviation::{DeviationSettings, Judged, SurfacePoint, judge},
    gaps::{Gap, GapEnd, GapSettings, OnRay, Side, gaps},
    thin_fins::{FinCrossing, ThinFins},
};

/// Rays of a band, about: some ten megabytes.
const RAYS_AT_ONCE: usize = 1 << 15;

/// What is compared, and how.
pub struct Survey<'a> {
    /// The cut part.
    pub stock: &'a TriDexel,
    /// The design; without one the points have no deviation.
    pub design: Option<&'a dyn DesignSurface>,
    /// The design as a solid, where it is one: its rays are compared, too.
    pub solid: Option<Solid<'a>>,
    /// How points count.
    pub settings: DeviationSettings,
    /// What of the material above the design is no more than a fin.
    pub fins: ThinFins,
    /// Only gaps in this box count; none: in the whole stock.
    pub window: Option<Aabb>,
    /// Gaps in these boxes do not count: finer rays take their place.
    pub finer: &'a [Aabb],
}

/// A design that bounds a solid.
#[derive(Clone, Copy)]
pub struct Solid<'a> {
    /// Its mesh as it is.
    pub mesh: &'a TriMesh,
    /// The same with its tree.
    pub tree: &'a DesignMesh,
    /// What counts on a ray.
    pub gaps: GapSettings,
}

/// A gap with what the stock knows of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundGap {
    /// Where and how deep.
    pub gap: Gap,
    /// Its ray.
    pub ray: RayPlace,
    /// Number of the ray's first point in [`Band::points`].
    pub first_point: usize,
    /// Length that counts, mm.
    pub length: f64,
    /// Height above the design from which on ends of material count, mm.
    pub left: f64,
    /// Numbers of the ends of material next to it, below and above, among the points of the ray.
    pub beside: [Option<usize>; 2],
    /// The last motion that took all material of an interval on this ray.
    pub last_to_empty: Option<u32>,
}

impl FoundGap {
    /// How its ray meets a fin, where all of its ends that count lie on one; `band` is the one that it was
    /// found in.
    pub fn fin(&self, band: &Band) -> Option<FinCrossing> {
        if self.gap.side == Side::Missing {
            return None;
        }
        let counts = |end: usize| {
            let too_high = |j: &Judged| j.deviation() > self.left;
            band.judged.get(self.first_point + end).is_some_and(too_high)
        };
        let cut = self.gap.ends.iter().filter_map(|end| match end {
            GapEnd::Cut(k) if counts(*k) => Some(*k),
            _ => None,
        });
        let mut fins = cut.map(|k| band.fins.get(self.first_point + k).copied().flatten());
        let first = fins.next()??;
        fins.all(|f| f.is_some()).then_some(first)
    }
}

/// Points and gaps of some rows of rays, in the order of [`TriDexel::surface_points`].
#[derive(Debug, Default)]
pub struct Band {
    /// The points of the surface.
    pub points: Vec<SurfacePoint>,
    /// What each gives.
    pub judged: Vec<Judged>,
    /// Whether it lies on a fin too high above the design.
    pub fins: Vec<Option<FinCrossing>>,
    /// The gaps of its rays.
    pub gaps: Vec<FoundGap>,
}

impl Survey<'_> {
    /// Measures everything and hands it on.
    ///
    /// # Errors
    /// The first one that `see` gives.
    pub fn run<E>(&self, mut see: impl FnMut(Band) -> Result<(), E>) -> Result<(), E> {
        for axis in 0..3 {
            let mesh_rows = self.solid.map(|s| self.stock.rows_of_mesh(s.mesh, axis));
            let tiles = self.stock.tiles_in_row(axis);
            let rows_at_once = (RAYS_AT_ONCE / (tiles * 64).max(1)).max(1);
            for first in (0..self.stock.rows(axis)).step_by(rows_at_once) {
                let rows = first..(first + rows_at_once).min(self.stock.rows(axis));
                let design: Vec<Option<RowMaterial>> =
                    rows.clone().into_par_iter().map(|row| mesh_rows.as_ref().map(|m| m.row(row))).collect();
                let places: Vec<(usize, usize)> = rows.flat_map(|row| (0..tiles).map(move |t| (row, t))).collect();
                let parts: Vec<Band> = places
                    .into_par_iter()
                    .with_min_len(4)
                    .map(|(row, tile)| self.tile(axis, row, tile, design[row - first].as_ref()))
                    .collect();
                let mut band = Band::default();
                for part in parts {
                    let before = band.points.len();
                    band.points.extend(part.points);
                    band.judged.extend(part.judged);
                    band.fins.extend(part.fins);
                    band.gaps
                        .extend(part.gaps.into_iter().map(|g| FoundGap { first_point: g.first_point + before, ..g }));
                }
                see(band)?;
            }
        }
        Ok(())
    }

    fn tile(&self, axis: usize, row: usize, tile: usize, design: Option<&RowMaterial>) -> Band {
        let mut band = Band::default();
        let (mut material, mut wanted, mut found): (Vec<RaySpan>, Vec<RaySpan>, Vec<Gap>) = Default::default();
        let mut deviations = Vec::new();
        for ray in self.stock.rays_of_tile(axis, row, tile) {
            material.clear();
            material.extend(self.stock.material(&ray));
            let first_point = band.points.len();
            for end in material.iter().flat_map(|s| [s.lo, s.hi]) {
                let sample = SurfacePoint {
                    point: ray.point(end.at),
                    normal: Some(end.normal),
                    axis: axis as u8,
                    made_by: end.made_by,
                };
                band.judged.push(self.design.map_or(Judged::Masked, |d| judge(&sample, d, &self.settings)));
                band.points.push(sample);
            }
            deviations.clear();
            deviations.extend(band.judged[first_point..].iter().map(Judged::deviation));
            self.fins.of_ray(self.stock, &ray, &material, &deviations, &mut band.fins);
            let (Some(solid), Some(design)) = (&self.solid, design) else { continue };
            let allowed = self.allowed(&ray);
            if allowed.is_empty() {
                continue;
            }
            wanted.clear();
            wanted.extend(design.on(&ray));
            let on_ray = OnRay { place: &ray, material: &material, design: &wanted, deviations: &deviations };
            let counts = |at: f64| allowed.iter().any(|[lo, hi]| *lo <= at && at <= *hi);
            found.clear();
            gaps(&on_ray, solid.tree, &solid.gaps, &counts, &mut found);
            for gap in &found {
                let within = |[lo, hi]: &[f64; 2]| (gap.at[1].min(*hi) - gap.at[0].max(*lo)).max(0.0);
                band.gaps.push(FoundGap {
                    gap: *gap,
                    ray,
                    first_point,
                    left: solid.gaps.left,
                    length: allowed.iter().map(within).sum(),
                    beside: [
                        material.iter().rposition(|m| m.hi.at <= gap.at[0]).map(|k| 2 * k + 1),
                        material.iter().position(|m| m.lo.at >= gap.at[1]).map(|k| 2 * k),
                    ],
                    last_to_empty: self.stock.last_to_empty(&ray),
                });
            }
        }
        band
    }

    /// Stretches of a ray on which gaps count, rising.
    fn allowed(&self, ray: &RayPlace) -> Vec<[f64; 2]> {
        let over = |b: &Aabb| {
            let at = ray.point(0.5 * (b.min[ray.axis] + b.max[ray.axis]));
            b.contains(&at).then(|| [b.min[ray.axis], b.max[ray.axis]])
        };
        let mut whole = [f64::NEG_INFINITY, f64::INFINITY];
        for bounds in [self.settings.region.as_ref(), self.window.as_ref()].into_iter().flatten() {
            let Some([lo, hi]) = over(bounds) else { return Vec::new() };
            whole = [whole[0].max(lo), whole[1].min(hi)];
        }
        let mut left = vec![whole];
        for [lo, hi] in self.finer.iter().filter_map(over) {
            left = left.into_iter().flat_map(|[from, to]| [[from, to.min(lo)], [from.max(hi), to]]).collect();
            left.retain(|[from, to]| from < to);
        }
        left
    }
}
