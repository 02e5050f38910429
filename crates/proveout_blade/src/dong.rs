//! The free-form surface used to test the tool axes of Dong et al. 2023 (doi:10.3390/mi14061199). The
//! paper gives none; this is the substitute defined in its specification:
//! `z = (0.004 + 0.016 x / 60) (y - 20)^2 / 2 + 0.8 sin(2 pi x / 60)` over 60 x 40 mm. u is x, the
//! feed; v is y, across it; both mm. The part lies below the surface.

use std::f64::consts::TAU;

use super::{closed_form::ClosedForm, scalar::Scalar, surface::Domain};

/// The formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dong {
    /// Length along x, mm: one wave.
    pub length: f64,
    /// Width along y, mm.
    pub width: f64,
    /// Curvature across the feed at x = 0 and what is added up to the end, 1/mm.
    pub cross_curvature: [f64; 2],
    /// Height of the wave along the feed, mm.
    pub wave: f64,
}

impl Dong {
    /// The substitute surface.
    pub fn stand_in() -> Self {
        Self { length: 60.0, width: 40.0, cross_curvature: [0.004, 0.016], wave: 0.8 }
    }
}

impl ClosedForm for Dong {
    fn domain(&self) -> Domain {
        Domain { u: [0.0, self.length], v: [0.0, self.width], u_closed: false }
    }

    fn place<T: Scalar>(&self, x: T, y: T) -> [T; 3] {
        let off = y.plus(-0.5 * self.width);
        let [start, rise] = self.cross_curvature;
        let bend = x.times(rise / self.length).plus(start);
        let (s, _) = x.times(TAU / self.length).sin_cos();
        [x, y, (bend * off * off).times(0.5) + s.times(self.wave)]
    }
}
