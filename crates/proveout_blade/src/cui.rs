//! The ruled face used to test the smoothing of axes near a pole of Cui et al. 2022. The paper gives no
//! surface; this is the substitute defined in its specification.
//!
//! ```text
//!   S(z, w) = d n(a) + w t(a) + z e_z
//!
//!   a = 90 + 25 z / 120 degrees      n = (cos a, sin a, 0)      t = (-sin a, cos a, 0)
//! ```
//!
//! The row runs along z from plate to plate at w = 0, d from the axis of C. u is w, v is z, both mm; the
//! blade's length is along +Z.

use proveout_geom::rad;

use super::{closed_form::ClosedForm, scalar::Scalar, surface::Domain};

/// The formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cui {
    /// Distance of the row from the axis, mm.
    pub distance: f64,
    /// Half of the face's width, mm.
    pub half_width: f64,
    /// Half of the length between the plates, mm.
    pub half_length: f64,
    /// Angle of the normal from +X at z = 0, radian.
    pub azimuth: f64,
    /// Turn for each mm of z, radian/mm.
    pub twist: f64,
}

impl Cui {
    /// The substitute: 120 mm between the plates, 8 mm from the axis, 6 mm wide: a wheel's contact stays
    /// within 3 mm of the row.
    pub fn stand_in() -> Self {
        Self { distance: 8.0, half_width: 3.0, half_length: 60.0, azimuth: rad(90.0), twist: rad(25.0) / 120.0 }
    }
}

impl ClosedForm for Cui {
    fn domain(&self) -> Domain {
        Domain { u: [-self.half_width, self.half_width], v: [-self.half_length, self.half_length], u_closed: false }
    }

    fn place<T: Scalar>(&self, w: T, z: T) -> [T; 3] {
        let (s, c) = z.times(self.twist).plus(self.azimuth).sin_cos();
        [c.times(self.distance) - w * s, s.times(self.distance) + w * c, z]
    }
}
