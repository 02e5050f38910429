//! The point nearest to a set of tangent planes.

use nalgebra::{Matrix3, SymmetricEigen};
use proveout_geom::{Point, Vector};

/// Directions in which the planes fix the point less than this part of the best one are left at the mean of
/// the crossings: below it is noise of the normals, above it are edges of more than about 12 degrees.
const RANK: f64 = 0.02;

/// Crossings of one vertex with their tangent planes.
#[derive(Clone, Debug)]
pub(crate) struct Planes {
    ata: Matrix3<f64>,
    /// Sum of n (n . p), p from the reference point.
    atb: Vector,
    sum: Vector,
    pub normal: Vector,
    count: f64,
    reference: Point,
    /// Normal of the first crossing, as long as the others have the same.
    only: Option<Vector>,
}

impl Planes {
    /// Coordinates are taken from a reference point near by, against rounding.
    pub(crate) fn new(reference: Point) -> Self {
        let zero = Vector::zeros();
        Self { ata: Matrix3::zeros(), atb: zero, sum: zero, normal: zero, count: 0.0, reference, only: None }
    }

    pub(crate) fn add(&mut self, point: &Point, normal: &Vector) {
        let p = point - self.reference;
        self.only = if self.count == 0.0 { Some(*normal) } else { self.only.filter(|only| only == normal) };
        self.ata += normal * normal.transpose();
        self.atb += normal * normal.dot(&p);
        self.sum += p;
        self.normal += normal;
        self.count += 1.0;
    }

    /// Least squares of the distances from the planes, nearest to the mean of the crossings where they leave
    /// it open (Ju et al. 2002, "Dual Contouring of Hermite Data"; the truncation of Lindstrom 2000).
    pub(crate) fn solve(&self) -> Point {
        let mean = self.sum / self.count.max(1.0);
        let rest = self.atb - self.ata * mean;
        if let Some(n) = self.only {
            // Parallel planes: the mean of the crossings, moved along the normal into the mean plane.
            let square = n.norm_squared();
            let shift =
                if square > 0.0 { n * (n.dot(&rest) / (self.count * square * square)) } else { Vector::zeros() };
            return self.reference + mean + shift;
        }
        let eigen = SymmetricEigen::new(self.ata);
        let largest = eigen.eigenvalues.max();
        let mut shift = Vector::zeros();
        for (value, axis) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value > RANK * largest && *value > 0.0 {
                shift += axis * (axis.dot(&rest) / value);
            }
        }
        self.reference + mean + shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_meet_in_a_corner_and_one_plane_keeps_the_mean() {
        let mut corner = Planes::new(Point::new(0.3, 0.3, 0.3));
        corner.add(&Point::new(1.0, 0.2, 0.4), &Vector::x());
        corner.add(&Point::new(0.1, 2.0, 0.4), &Vector::y());
        corner.add(&Point::new(0.6, 0.2, 3.0), &Vector::z());
        assert!((corner.solve() - Point::new(1.0, 2.0, 3.0)).norm() < 1e-12);
        let mut flat = Planes::new(Point::origin());
        flat.add(&Point::new(0.0, 0.0, 1.0), &Vector::z());
        flat.add(&Point::new(1.0, 2.0, 1.0), &Vector::z());
        assert!((flat.solve() - Point::new(0.5, 1.0, 1.0)).norm() < 1e-12);
        // The same by the general way: a normal that differs in its last bits.
        let slanted = Vector::new(0.48, 0.6, 0.64);
        let nearly = slanted + Vector::new(1e-16, 0.0, 1e-16);
        let solved = |second: Vector| {
            let mut planes = Planes::new(Point::new(0.1, 0.2, 0.3));
            planes.add(&Point::new(0.3, 0.5, 0.7), &slanted);
            planes.add(&Point::new(0.9, -0.2, 0.8), &second);
            planes.solve()
        };
        assert!(nearly != slanted && (solved(nearly) - solved(slanted)).norm() < 1e-12);
    }
}
