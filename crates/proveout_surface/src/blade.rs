//! Blades as designs, and how far a mesh lies from a closed form.

use proveout_blade::{Blade, BladeSolid};
use proveout_geom::{Point, TriMesh, Vector};
use rayon::prelude::*;

use crate::{DesignSurface, NearestOnDesign};

/// The solid with all of its faces.
impl DesignSurface for Blade {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let found = Self::nearest(self, p)?;
        (found.distance.abs() <= range).then_some(NearestOnDesign { distance: found.distance, normal: found.normal })
    }
}

/// The blade with both of its ends.
impl DesignSurface for BladeSolid {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let found = p.iter().all(|v| v.is_finite()).then(|| Self::nearest(self, p))?;
        (found.distance.abs() <= range).then_some(NearestOnDesign { distance: found.distance, normal: found.normal })
    }
}

/// Places of a facet as parts of its corners: its middle, the middles of its edges, and between them.
const COARSE: [[f64; 3]; 4] = [[1.0 / 3.0; 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];
/// Steps of the finer places along an edge.
const FINE: usize = 8;
/// Facets are looked at closer where their distance is more than this part of the largest.
const CLOSER: f64 = 0.8;

/// Largest distance of the facets of a mesh from the surface that it approximates, mm, as measured: at the
/// middles of all facets and edges, and where these are farthest off, at 45 places of each facet.
///
/// Between these places a facet deviates by little more: the distance of a flat facet from a smooth surface
/// bends no more than the surface itself, and is largest at the middles of the facet and of its edges.
/// `None` where the design does not answer for a place.
///
/// ```
/// use proveout_geom::{Point, Vector, cylinder_mesh};
/// use proveout_surface::{ConeFrustum, chord_error};
///
/// // A cylinder of 10 mm radius as a prism of 36 sides in it.
/// let (base, axis) = (Point::origin(), Vector::z());
/// let (base_radius, top_radius, height) = (10.0, 10.0, 50.0);
/// let design = ConeFrustum { base, axis, base_radius, top_radius, height };
/// let error = chord_error(&cylinder_mesh(10.0, 0.0, 50.0, 36), &design).expect("finite");
/// assert!((error - 10.0 * (1.0 - 5_f64.to_radians().cos())).abs() < 1e-9); // mm
/// ```
pub fn chord_error(mesh: &TriMesh, design: &(impl DesignSurface + ?Sized)) -> Option<f64> {
    let place = |triangle: &[u32; 3], parts: [f64; 3]| {
        let corners = triangle.map(|i| mesh.positions.get(i as usize).map_or_else(Vector::zeros, |p| p.coords));
        Point::from(corners[0] * parts[0] + corners[1] * parts[1] + corners[2] * parts[2])
    };
    let worst = |triangle: &[u32; 3], parts: &[[f64; 3]]| {
        parts.iter().try_fold(0.0_f64, |most, p| Some(most.max(design.signed_distance(&place(triangle, *p))?.abs())))
    };
    let coarse: Option<Vec<f64>> = mesh.triangles.par_iter().map(|t| worst(t, &COARSE)).collect();
    let coarse = coarse?;
    let most = coarse.iter().copied().fold(0.0, f64::max);
    let steps = (0..=FINE).flat_map(|i| (0..=FINE - i).map(move |j| [i, j, FINE - i - j]));
    let places: Vec<[f64; 3]> = steps.map(|parts| parts.map(|k| k as f64 / FINE as f64)).collect();
    let fine = mesh.triangles.par_iter().zip(&coarse).filter(|(_, d)| **d >= CLOSER * most);
    let fine = fine.map(|(t, _)| worst(t, &places));
    let fine: Option<Vec<f64>> = fine.collect();
    Some(fine?.into_iter().fold(most, f64::max))
}
