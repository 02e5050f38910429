//! The airfoil of a [`Blade`] as a surface that answers where a tool touches it, with normal and principal curvatures.
//!
//! With the outline P(s) by arc length (outward normal n, tangent t, curvature k, `P' = t`, `t' = -k n`) and the twist w for
//! each mm the airfoil is `S(s, x) = R(w x) P(s) + x e_x`, so that
//!
//! ```text
//!   S_s = t          S_ss = -k n           (t, n turned with the blade)
//!   S_x = e_x + w e_x x S     S_sx = w e_x x t     S_xx = -w^2 (S - x e_x)
//! ```
//!
//! The nearest point is where `(S - p) . S_s = (S - p) . S_x = 0` (Newton from the nearest of a row of points of the section
//! in the plane of p); principal curvatures are the roots of `det(II - k I) = 0` of the two fundamental forms, here with the
//! sign that makes a convex surface positive (do Carmo 1976, section 3.3).

use proveout_geom::blade::{Blade, Local, SectionPoint};
use proveout_geom::{Point, Pose, Vector};

use crate::reschedule::{Contact, ContactSurface};

/// Points of the section from which the search begins: closer together than the radius of the sharpest edge of a blade of
/// common slenderness, so that the nearest one lies on the right side.
const STARTS: usize = 720;

/// A blade in the frame of a program.
#[derive(Clone, Debug)]
pub struct BladeSurface {
    blade: Blade,
    run_from_blade: Pose,
    blade_from_run: Pose,
    /// Arc length and place of points of the section.
    starts: Vec<(f64, [f64; 2])>,
}

impl BladeSurface {
    /// A blade whose frame stands at `run_from_blade` in the frame of the program.
    pub fn new(blade: Blade, run_from_blade: Pose) -> Self {
        let perimeter = blade.outline().perimeter();
        let starts = (0..STARTS).map(|k| perimeter * k as f64 / STARTS as f64);
        let starts = starts.map(|s| (s, blade.outline().at(s).position)).collect();
        Self { blade, run_from_blade, blade_from_run: run_from_blade.inverse(), starts }
    }

    fn local(&self, s: f64, x: f64) -> Local {
        let twist = self.blade.spec().twist;
        let on: SectionPoint = self.blade.outline().at(s);
        let at = self.blade.raised(on.position, on.normal_angle, x);
        let (sine, cosine) = (on.normal_angle + twist * x).sin_cos();
        let (n, t) = (Vector::new(0.0, cosine, sine), Vector::new(0.0, -sine, cosine));
        let about_x = |v: &Vector| Vector::new(0.0, -v.z, v.y);
        let across = Vector::new(0.0, at.point.y, at.point.z);
        Local {
            point: at.point,
            normal: at.normal,
            first: [t, Vector::x() + about_x(&across) * twist],
            second: [n * -on.curvature, about_x(&t) * twist, across * (-twist * twist)],
        }
    }

    /// Arc length and X of the nearest point of the airfoil, continued beyond its ends.
    fn nearest(&self, p: &Point) -> (f64, f64) {
        let (sine, cosine) = (self.blade.spec().twist * p.x).sin_cos();
        let flat = [cosine * p.y + sine * p.z, cosine * p.z - sine * p.y];
        let gap = |q: &[f64; 2]| (q[0] - flat[0]).powi(2) + (q[1] - flat[1]).powi(2);
        let start = self.starts.iter().min_by(|a, b| gap(&a.1).total_cmp(&gap(&b.1)));
        let (mut s, mut x) = (start.map_or(0.0, |a| a.0), p.x);
        let reach = self.blade.outline().perimeter() / STARTS as f64;
        for _ in 0..40 {
            let at = self.local(s, x);
            let f = at.point - p;
            let g = [f.dot(&at.first[0]), f.dot(&at.first[1])];
            let [a, b, c] = [
                at.first[0].norm_squared() + f.dot(&at.second[0]),
                at.first[0].dot(&at.first[1]) + f.dot(&at.second[1]),
                at.first[1].norm_squared() + f.dot(&at.second[2]),
            ];
            let det = a * c - b * b;
            // Where the distance has no minimum nearby (a point beyond the center of curvature) the gradient leads on.
            let step =
                if a > 1e-6 && det > 1e-6 { [(c * g[0] - b * g[1]) / det, (a * g[1] - b * g[0]) / det] } else { g };
            // Curvature jumps at the ends of the edge arcs: a step stays near.
            s -= step[0].clamp(-reach, reach);
            x -= step[1].clamp(-reach, reach);
            if step[0].abs().max(step[1].abs()) < 1e-12 {
                break;
            }
        }
        (s, x)
    }
}

impl ContactSurface for BladeSurface {
    fn contact(&self, near: &Point) -> Option<Contact> {
        let p = self.blade_from_run.point(near);
        if !p.coords.iter().all(|v| v.is_finite()) {
            return None;
        }
        let (s, x) = self.nearest(&p);
        if x < self.blade.airfoil_start() || x > self.blade.spec().length {
            return None;
        }
        let at = self.local(s, x);
        let curvatures = at.principal().map(|(k, direction)| (k, self.run_from_blade.vector(&direction)));
        Some(Contact {
            point: self.run_from_blade.point(&at.point),
            normal: self.run_from_blade.vector(&at.normal),
            curvatures,
        })
    }
}
