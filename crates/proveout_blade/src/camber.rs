//! The airfoil of a [`Blade`] (circles on a circular camber line, twisted) as a surface: u is the arc length
//! of the section, v the X, both mm.
//!
//! With the outline P(s) by arc length (outward normal n, tangent t, curvature k, `P' = t`, `t' = -k n`) and
//! the twist w for each mm the airfoil is `S(s, x) = R(w x) P(s) + x e_x`, so that
//!
//! ```text
//!   S_s = t          S_ss = -k n           (t, n turned with the blade)
//!   S_x = e_x + w e_x x S     S_sx = w e_x x t     S_xx = -w^2 (S - x e_x)
//! ```

use std::f64::consts::TAU;

use proveout_geom::{Point, Vector};

use super::{
    body::Blade,
    cells::{CellCover, CurvatureBounds},
    scalar::{Interval, Scalar},
    section::SectionPoint,
    surface::{Domain, Foot, Local, ParametricSurface},
};

/// Places at which the curvature is asked for its range in a cell; within a side it changes slowly.
const PLACES: u32 = 2000;
/// Margin of the curvature between these places.
const BETWEEN: f64 = 1.1;

/// The airfoil of a blade.
#[derive(Clone, Debug)]
pub struct CamberSide {
    blade: Blade,
    /// The section at the middles of so many equal parts of its length.
    samples: Vec<SectionPoint>,
    /// mm.
    apart: f64,
    cells: CellCover,
}

impl CamberSide {
    /// The airfoil from where the fillet ends to the tip.
    pub fn new(blade: Blade) -> Self {
        let apart = blade.outline().perimeter() / f64::from(PLACES);
        let samples = (0..PLACES).map(|k| blade.outline().at((f64::from(k) + 0.5) * apart)).collect();
        let starts = blade.outline().piece_starts();
        let bare = Self { blade, samples, apart, cells: CellCover::default() };
        let cells = CellCover::new(&bare, [&starts, &[]]);
        Self { cells, ..bare }
    }

    /// The blade that it belongs to.
    pub fn blade(&self) -> &Blade {
        &self.blade
    }
}

impl CurvatureBounds for CamberSide {
    fn second(&self, u: [f64; 2], v: [f64; 2]) -> [[Interval; 3]; 3] {
        let twist = self.blade.spec().twist;
        let (mut bend, mut angle, mut place) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN], [[f64::MAX, f64::MIN]; 2]);
        let widen = |range: &mut [f64; 2], x: f64| *range = [range[0].min(x), range[1].max(x)];
        let (count, apart) = (self.samples.len() as i64, self.apart);
        // All samples within, and one to either side.
        let (from, to) = ((u[0] / apart - 0.5).floor() as i64, (u[1] / apart - 0.5).ceil() as i64);
        for k in (from..=to).take(self.samples.len()) {
            let at = &self.samples[k.rem_euclid(count) as usize];
            widen(&mut bend, at.curvature);
            widen(&mut angle, at.normal_angle + TAU * k.div_euclid(count) as f64);
            widen(&mut place[0], at.position[0]);
            widen(&mut place[1], at.position[1]);
        }
        let most = bend[0].abs().max(bend[1].abs()) * BETWEEN;
        let ranged = |r: [f64; 2], by: f64| Interval { low: r[0] - by, high: r[1] + by };
        let bend = ranged(bend, (BETWEEN - 1.0) * most);
        let turn = Interval::new(twist * v[0], twist * v[1]);
        let (sine, cosine) = (ranged(angle, most * apart) + turn).sin_cos();
        let [y, z] = place.map(|r| ranged(r, apart));
        let (s, c) = turn.sin_cos();
        let zero = Interval::of(0.0);
        let back = -(twist * twist);
        [
            [zero, -(bend * cosine), -(bend * sine)],
            // w e_x x t with t = (0, -sin, cos).
            [zero, cosine.times(-twist), sine.times(-twist)],
            [zero, (c * y - s * z).times(back), (s * y + c * z).times(back)],
        ]
    }
}

impl ParametricSurface for CamberSide {
    fn domain(&self) -> Domain {
        let u = [0.0, self.blade.outline().perimeter()];
        Domain { u, v: [self.blade.airfoil_start(), self.blade.spec().length], u_closed: true }
    }

    fn local(&self, s: f64, x: f64) -> Local {
        let twist = self.blade.spec().twist;
        let on = self.blade.outline().at(s);
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

    fn nearest(&self, p: &Point) -> [f64; 2] {
        self.foot(p).parameters
    }

    fn foot(&self, p: &Point) -> Foot {
        self.cells.foot(self, p)
    }

    fn breaks(&self) -> Vec<f64> {
        self.blade.outline().piece_starts().to_vec()
    }
}
