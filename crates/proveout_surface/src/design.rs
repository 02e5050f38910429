//! The surface that a cut part is compared with.

use proveout_geom::{Point, Vector};

/// The point of a design surface nearest to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnDesign {
    /// Signed distance, mm: positive outside of the design (material left), negative inside (gouge).
    pub distance: f64,
    /// Outward unit normal of the design there.
    pub normal: Vector,
}

/// A design surface that knows the signed distance of points, in the frame of the points.
///
/// ```
/// use proveout_geom::Point;
/// use proveout_surface::{DesignSurface, Sphere};
///
/// let design = Sphere { center: Point::origin(), radius: 20.0 }; // mm
/// let deviation = |z: f64| design.signed_distance(&Point::new(0.0, 0.0, z)).expect("finite");
/// assert!((deviation(20.05) - 0.05).abs() < 1e-12); // material left
/// assert!((deviation(19.98) + 0.02).abs() < 1e-12); // a gouge
/// assert_eq!(design.nearest(&Point::new(0.0, 0.0, 25.0), 1.0), None); // beyond 1 mm
/// ```
pub trait DesignSurface: Sync {
    /// Nearest point of the design; none when it is further away than `range` (mm) or when the surface does
    /// not answer for this point (beyond the end of a flank, a coordinate that is not a number).
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign>;

    /// Signed distance, mm, positive outside; none where [`Self::nearest`] gives none without limit of range.
    fn signed_distance(&self, p: &Point) -> Option<f64> {
        self.nearest(p, f64::INFINITY).map(|n| n.distance)
    }
}
