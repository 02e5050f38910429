//! Profile parameters, ISO 21920-2:2021 and ISO 4287:1997.

use serde::Serialize;

use super::{SettingClass, Standard, spacing::mean_spacing};

/// Parameters of a profile; heights from the mean line, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ProfileParameters {
    /// Arithmetic mean height, mm.
    pub ra: f64,
    /// Root mean square height, mm.
    pub rq: f64,
    /// Mean of the largest heights of the sections, mm.
    pub rp: f64,
    /// Mean of the largest depths of the sections, mm, positive.
    pub rv: f64,
    /// Mean over the sections of largest height plus largest depth, mm.
    pub rz: f64,
    /// Largest height plus largest depth over the evaluation length, mm.
    pub rt: f64,
    /// Skewness; zero on a flat.
    pub rsk: f64,
    /// Kurtosis; zero on a flat.
    pub rku: f64,
    /// Mean spacing of the profile elements, mm; none where fewer than one element lies in the length.
    pub rsm: Option<f64>,
}

/// Moments of a profile as polygon: mean of |z|, z^2, z^3, z^4.
///
/// Over one segment from p to q: the mean of z^n is (p^n + p^(n-1) q + ... + q^n) / (n + 1); of |z| it is
/// |p + q| / 2 without crossing and (p^2 + q^2) / (2 |p - q|) with one. Sums of points would carry an error
/// of second order of the ends.
struct Moments {
    absolute: f64,
    second: f64,
    third: f64,
    fourth: f64,
}

impl Moments {
    fn of(z: &[f64]) -> Self {
        // A section of a few points may be a single one.
        if let [one] = z {
            return Self { absolute: one.abs(), second: one.powi(2), third: one.powi(3), fourth: one.powi(4) };
        }
        let mut m = Self { absolute: 0.0, second: 0.0, third: 0.0, fourth: 0.0 };
        for w in z.windows(2) {
            let (p, q) = (w[0], w[1]);
            let (p2, q2, pq) = (p * p, q * q, p * q);
            m.absolute += if pq < 0.0 { (p2 + q2) / (2.0 * (p - q).abs()) } else { (p + q).abs() / 2.0 };
            m.second += (p2 + pq + q2) / 3.0;
            m.third += (p + q) * (p2 + q2) / 4.0;
            m.fourth += (p2 * p2 + p2 * pq + p2 * q2 + q2 * pq + q2 * q2) / 5.0;
        }
        let n = (z.len() - 1) as f64;
        Self { absolute: m.absolute / n, second: m.second / n, third: m.third / n, fourth: m.fourth / n }
    }

    fn skewness(&self) -> f64 {
        if self.second > 0.0 { self.third / self.second.powf(1.5) } else { 0.0 }
    }

    fn kurtosis(&self) -> f64 {
        if self.second > 0.0 { self.fourth / (self.second * self.second) } else { 0.0 }
    }
}

impl ProfileParameters {
    /// Parameters of heights from the mean line (mm) at equal steps (mm), which fill the evaluation length.
    /// The profile is not centered again; neighboring sections share the node between them.
    ///
    /// ```
    /// use proveout_surface::texture::{ProfileParameters, Standard};
    ///
    /// // Ten waves of a sine over 4 mm: Ra = 2 a / pi, Rq = a / sqrt 2, Rz = 2 a.
    /// let a = 1e-3; // mm
    /// let wave = |i: u32| a * (std::f64::consts::TAU * f64::from(i) / 1000.0).sin();
    /// let heights: Vec<f64> = (0..=10_000).map(wave).collect();
    /// let found = ProfileParameters::of(&heights, 4e-4, Standard::Iso21920);
    /// assert!((found.ra / a - 2.0 / std::f64::consts::PI).abs() < 1e-4);
    /// assert!((found.rq / a - 0.5_f64.sqrt()).abs() < 1e-4 && (found.rz / a - 2.0).abs() < 1e-4);
    /// ```
    pub fn of(z: &[f64], step: f64, standard: Standard) -> Self {
        if z.len() < 2 {
            return Self::default();
        }
        let sections: Vec<&[f64]> = (0..SettingClass::SECTIONS)
            .map(|k| {
                let last = z.len() - 1;
                &z[k * last / SettingClass::SECTIONS..=(k + 1) * last / SettingClass::SECTIONS]
            })
            .collect();
        let mean = |f: &dyn Fn(&[f64]) -> f64| sections.iter().map(|s| f(s)).sum::<f64>() / sections.len() as f64;
        let top = |s: &[f64]| s.iter().copied().fold(0.0_f64, f64::max);
        let bottom = |s: &[f64]| s.iter().copied().fold(0.0_f64, |a, z| a.max(-z));
        let whole = Moments::of(z);
        let (ra, rq, rsk, rku) = match standard {
            Standard::Iso21920 => (whole.absolute, whole.second.sqrt(), whole.skewness(), whole.kurtosis()),
            Standard::Iso4287 => (
                mean(&|s| Moments::of(s).absolute),
                mean(&|s| Moments::of(s).second.sqrt()),
                mean(&|s| Moments::of(s).skewness()),
                mean(&|s| Moments::of(s).kurtosis()),
            ),
        };
        let (rp, rv) = (mean(&top), mean(&bottom));
        let rz = rp + rv;
        let section = (z.len() - 1) as f64 * step / SettingClass::SECTIONS as f64;
        Self { ra, rq, rp, rv, rz, rt: top(z) + bottom(z), rsk, rku, rsm: mean_spacing(z, step, rz, section) }
    }
}
