//! The sine surfaces on which the least angular acceleration of Ma et al. 2020
//! (doi:10.1007/s00170-020-05171-7) is tried: `z = (m / k) (1 - cos k y)`, straight along x. u is x, v is y,
//! both mm; the part lies below.

use std::f64::consts::TAU;

use super::{closed_form::ClosedForm, scalar::Scalar, surface::Domain};

/// The formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Steepest slope m.
    pub steepness: f64,
    /// k, radian/mm.
    pub wave_number: f64,
    /// Width along x, mm.
    pub width: f64,
    /// Length along y, mm.
    pub length: f64,
}

impl Sine {
    /// As steep as the paper's published axes say (m = 3.2, k = 0.22 1/mm), two periods. No ball of 3 mm fits
    /// into its troughs of 1.42 mm: for kinematics only.
    pub fn published_ratio() -> Self {
        Self { steepness: 3.2, wave_number: 0.22, width: 30.0, length: 2.0 * TAU / 0.22 }
    }

    /// Amplitude 6 mm, period 40 mm, 30 mm wide, two periods: smallest radius 6.75 mm.
    pub fn gentle() -> Self {
        Self { steepness: 6.0 * TAU / 40.0, wave_number: TAU / 40.0, width: 30.0, length: 80.0 }
    }
}

impl ClosedForm for Sine {
    fn domain(&self) -> Domain {
        Domain { u: [0.0, self.width], v: [0.0, self.length], u_closed: false }
    }

    fn place<T: Scalar>(&self, x: T, y: T) -> [T; 3] {
        let (_, c) = y.times(self.wave_number).sin_cos();
        [x, y, (T::of(1.0) - c).times(self.steepness / self.wave_number)]
    }
}
