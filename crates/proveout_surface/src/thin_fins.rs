//! Thin fins: material left above the design that is no thicker than the error of its own faces.
//!
//! Two passes whose walls meet in one plane leave nothing between them. Where their faces come to lie a
//! rounding apart, the stock keeps a sheet there, as high as the cut was deep:
//!
//! ```text
//!      |  first pass  ||  second pass  |     Each face lies within e of the true one, so that a sheet
//!      |              ||               |     thinner than 2 e may as well not be there.
//!      |______________||_______________|
//!      =============== design ===========
//! ```
//!
//! A ray that goes through the sheet has its thickness for its interval: the length square to the face that
//! it meets less aslant, where both faces look away from each other (the angle between their normals is above
//! 120 degrees, so that the crest of a ridge is none). A ray that runs *in* the sheet has a long interval and
//! says nothing of the thickness. But the rays of the three sets cross each other in common points: where
//! those of another set have a fin, or nothing at all, in the points in which they cross the interval, both
//! sets can only agree within the error of the faces.
//!
//! Known limits: the crest of a wedge below 60 degrees counts as fin as far as it is thinner than the bound;
//! nothing thicker of it is left out.

use proveout_stock::{RayPlace, RaySpan, TriDexel};

/// Crossing rays that are asked from the end of an interval inward.
const NODES: i32 = 3;
/// Cosine of the angle between the normals of two faces that look away from each other.
const AWAY: f64 = -0.5;

/// What counts as a thin fin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThinFins {
    /// Sheets up to this are fins, mm; zero for none: twice the distance within which each face of the stock
    /// is known.
    pub thickest: f64,
    /// Only ends of material higher than this above the design are asked, mm.
    pub above: f64,
}

/// How a ray meets a fin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FinCrossing {
    /// It goes through: its interval is the thickness.
    Across,
    /// It runs in the sheet: its interval says nothing of how much material there is.
    Along,
}

impl ThinFins {
    /// Whether an interval on a ray along `axis` is a fin that the ray goes through.
    fn across(&self, span: &RaySpan, axis: usize) -> bool {
        let (n, m) = (&span.lo.normal, &span.hi.normal);
        let thickness = (span.hi.at - span.lo.at) * n[axis].abs().max(m[axis].abs());
        thickness <= self.thickest && n.dot(m) < AWAY
    }

    /// Whether a longer interval lies in a fin at one of its ends: rays of another set cross it there in the
    /// very same points, and none of them has more than a fin where they cross.
    fn along(&self, stock: &TriDexel, ray: &RayPlace, span: &RaySpan, end: f64) -> bool {
        let (axis, cell) = (ray.axis, stock.cells_mm()[ray.axis]);
        let inward = if end == span.lo.at { cell } else { -cell };
        (1..3).map(|k| (axis + k) % 3).any(|across| {
            let mut crossed = false;
            for step in 0..NODES {
                let Some(other) = stock.ray_near(across, &ray.point(end + (f64::from(step) + 0.5) * inward), [0, 0])
                else {
                    continue;
                };
                let node = other.point(0.0)[axis];
                if node <= span.lo.at + self.thickest || node >= span.hi.at - self.thickest {
                    continue;
                }
                let place = ray.point(node)[across];
                let here = |s: &RaySpan| s.lo.at - self.thickest <= place && place <= s.hi.at + self.thickest;
                if stock.material(&other).any(|s| here(&s) && !self.across(&s, across)) {
                    return false;
                }
                crossed = true;
            }
            crossed
        })
    }

    /// For each interval of a ray with the deviations of both its ends: which end is a fin too high above the
    /// design.
    pub(crate) fn of_ray(
        &self,
        stock: &TriDexel,
        ray: &RayPlace,
        material: &[RaySpan],
        deviations: &[f64],
        out: &mut Vec<Option<FinCrossing>>,
    ) {
        for (span, of_ends) in material.iter().zip(deviations.chunks(2)) {
            for (end, deviation) in [span.lo, span.hi].iter().zip(of_ends) {
                let fin = if self.thickest <= 0.0 || deviation.is_nan() || *deviation <= self.above {
                    None
                } else if self.across(span, ray.axis) {
                    Some(FinCrossing::Across)
                } else {
                    self.along(stock, ray, span, end.at).then_some(FinCrossing::Along)
                };
                out.push(fin);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, Point, box_mesh};

    use super::*;

    /// A plate with a sheet of this thickness upright on it, in the plane of rays along z and y.
    fn stock(thickness: f64) -> TriDexel {
        let mut mesh = box_mesh(&Aabb { min: Point::new(0.0, 0.0, 0.0), max: Point::new(8.0, 6.0, 2.0) });
        // A ray of both other sets runs in the middle of the sheet.
        let x = [4.25 - 0.5 * thickness, 4.25 + 0.5 * thickness];
        mesh.append(&box_mesh(&Aabb { min: Point::new(x[0], 0.0, 1.5), max: Point::new(x[1], 6.0, 4.0) }));
        TriDexel::from_mesh_repaired(&mesh, 0.5, 1 << 30).expect("a solid")
    }

    /// Ends above z = 2.5 by what is said of them: across, along, none.
    fn counts(thickness: f64, thickest: f64) -> [usize; 3] {
        let (stock, fins) = (stock(thickness), ThinFins { thickest, above: 0.5 });
        let mut count = [0; 3];
        for axis in 0..3 {
            for (row, tile) in (0..stock.rows(axis)).flat_map(|r| (0..stock.tiles_in_row(axis)).map(move |t| (r, t))) {
                for ray in stock.rays_of_tile(axis, row, tile) {
                    let material: Vec<RaySpan> = stock.material(&ray).collect();
                    let deviations: Vec<f64> =
                        material.iter().flat_map(|s| [s.lo, s.hi]).map(|e| ray.point(e.at).z - 2.0).collect();
                    let mut out = Vec::new();
                    fins.of_ray(&stock, &ray, &material, &deviations, &mut out);
                    for (fin, _) in out.iter().zip(&deviations).filter(|(_, d)| **d > 0.5) {
                        count[fin.map_or(2, |f| usize::from(f == FinCrossing::Along))] += 1;
                    }
                }
            }
        }
        count
    }

    /// A pin that rays of all sets meet is no fin, however thin it is against the cells.
    #[test]
    fn a_pin_between_the_rays_beside_it_is_there() {
        let mut mesh = box_mesh(&Aabb { min: Point::new(0.0, 0.0, 0.0), max: Point::new(8.0, 6.0, 2.0) });
        mesh.append(&box_mesh(&Aabb { min: Point::new(4.2, 3.2, 1.5), max: Point::new(4.3, 3.3, 4.0) }));
        let stock = TriDexel::from_mesh_repaired(&mesh, 0.5, 1 << 30).expect("a solid");
        let top = Point::new(4.25, 3.25, 4.0);
        let ray = stock.ray_near(2, &top, [0, 0]).expect("a ray");
        let span = stock.material(&ray).next().expect("the pin");
        assert_eq!(span.hi.at, 4.0);
        assert!(!ThinFins { thickest: 1e-3, above: 0.5 }.along(&stock, &ray, &span, 4.0));
    }

    #[test]
    fn a_sheet_as_thin_as_the_error_of_its_faces_is_a_fin_on_all_rays_and_a_thicker_one_on_none() {
        let [across, along, none] = counts(4e-4, 1e-3);
        assert!(across > 0 && along > 0 && none == 0, "{across} {along} {none}");
        let [across, along, none] = counts(2e-3, 1e-3);
        assert!((across, along) == (0, 0) && none > 0, "{across} {along} {none}");
        assert_eq!(counts(4e-4, 0.0)[..2], [0, 0], "nothing is left out where nothing is asked");
    }
}
