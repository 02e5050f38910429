//! Surfaces that are given by a formula: written once, differentiated and bounded by [`super::scalar`].

use std::fmt::Debug;

use proveout_geom::{Point, Vector};

use super::{
    cells::{CellCover, CurvatureBounds},
    scalar::{Interval, Jet, Scalar},
    surface::{Domain, Foot, Local, ParametricSurface},
};

/// A formula for S(u, v) that is smooth over its whole domain, seams included.
pub trait ClosedForm: Debug + Send + Sync {
    /// Range of the parameters.
    fn domain(&self) -> Domain;
    /// x, y, z in mm; `S_u x S_v` points outward.
    fn place<T: Scalar>(&self, u: T, v: T) -> [T; 3];
}

/// A surface with a [`ClosedForm`], ready to be asked.
#[derive(Clone, Debug)]
pub struct ClosedSurface<F> {
    form: F,
    cells: CellCover,
}

impl<F: ClosedForm> ClosedSurface<F> {
    /// The surface of a formula.
    pub fn new(form: F) -> Self {
        let bare = Self { form, cells: CellCover::default() };
        let cells = CellCover::new(&bare, [&[], &[]]);
        Self { cells, ..bare }
    }

    /// Its formula.
    pub fn form(&self) -> &F {
        &self.form
    }
}

impl<F: ClosedForm> CurvatureBounds for ClosedSurface<F> {
    fn second(&self, u: [f64; 2], v: [f64; 2]) -> [[Interval; 3]; 3] {
        let at = self.form.place(Jet::u(Interval::new(u[0], u[1])), Jet::v(Interval::new(v[0], v[1])));
        std::array::from_fn(|k| std::array::from_fn(|c| at[c].second[k]))
    }
}

impl<F: ClosedForm> ParametricSurface for ClosedSurface<F> {
    fn domain(&self) -> Domain {
        self.form.domain()
    }

    fn local(&self, u: f64, v: f64) -> Local {
        let [x, y, z] = self.form.place(Jet::u(u), Jet::v(v));
        let vector = |of: &dyn Fn(&Jet<f64>) -> f64| Vector::new(of(&x), of(&y), of(&z));
        let first = [0, 1].map(|k| vector(&|j| j.first[k]));
        Local {
            point: Point::from(vector(&|j| j.value)),
            normal: first[0].cross(&first[1]).try_normalize(0.0).unwrap_or_else(Vector::x),
            first,
            second: [0, 1, 2].map(|k| vector(&|j| j.second[k])),
        }
    }

    fn nearest(&self, p: &Point) -> [f64; 2] {
        self.foot(p).parameters
    }

    fn foot(&self, p: &Point) -> Foot {
        self.cells.foot(self, p)
    }

    fn is_beyond(&self, p: &Point, reach: f64) -> bool {
        self.cells.is_beyond(self, p, reach)
    }
}
