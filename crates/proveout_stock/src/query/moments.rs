//! Volume, center and moments of inertia of the material.
//!
//! Each interval of a ray represents a box of its cell's width: exact along the ray, one value a
//! cell across it. The mean over the three ray sets is taken, as for the volume.

use nalgebra::Matrix3;
use proveout_geom::{Point, Vector};

use crate::TriDexel;

/// Moments of a body of density one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Volume, mm³.
    pub volume: f64,
    /// Center of the volume, mm.
    pub center: Point,
    /// Inertia about the center along the axes of the frame, mm⁵: times a density in kg/mm³ it is in kg mm².
    pub inertia: Matrix3<f64>,
}

impl TriDexel {
    /// Moments of all material, in the frame of the stock; none where there is none.
    pub fn moments(&self) -> Option<Moments> {
        // About the middle of the box, so that little is lost where the stock lies far from the origin.
        let origin = self.grid.bounds.center();
        let (mut volume, mut first, mut second) = (0.0, Vector::zeros(), Matrix3::zeros());
        for a in 0..3 {
            let (u, v) = ((a + 1) % 3, (a + 2) % 3);
            let area = self.grid.ray_area(a) / 3.0;
            let [cu, cv] = [self.grid.cells[u], self.grid.cells[v]];
            for j in 0..self.grid.n[v] {
                for i in 0..self.grid.n[u] {
                    for span in self.spans(a, i, j) {
                        let length = span.hi - span.lo;
                        let mut at = Vector::zeros();
                        at[a] = 0.5 * (span.lo + span.hi) - origin[a];
                        at[u] = self.grid.center(u, i) - origin[u];
                        at[v] = self.grid.center(v, j) - origin[v];
                        let mut own = Vector::zeros();
                        (own[a], own[u], own[v]) = (length * length, cu * cu, cv * cv);
                        let share = length * area;
                        volume += share;
                        first += at * share;
                        second += (at * at.transpose() + Matrix3::from_diagonal(&(own / 12.0))) * share;
                    }
                }
            }
        }
        if volume <= 0.0 {
            return None;
        }
        let off = first / volume;
        let central = second - off * off.transpose() * volume;
        let inertia = Matrix3::identity() * central.trace() - central;
        Some(Moments { volume, center: origin + off, inertia })
    }
}
