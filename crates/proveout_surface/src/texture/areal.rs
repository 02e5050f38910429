//! Areal parameters, ISO 25178-2:2021.

use serde::Serialize;

use super::{HeightMap, gaussian_mean_of_map};

/// What the values of an areal evaluation depend on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArealSetting {
    /// Standard and edition of the definitions.
    pub standard: &'static str,
    /// Nesting index of the S-filter, mm; none when it is left out.
    pub s_filter_mm: Option<f64>,
    /// Nesting index of the L-filter, mm; none when it is left out.
    pub l_filter_mm: Option<f64>,
    /// Rule for the ends of the filters.
    pub ends: &'static str,
    /// How the form was removed.
    pub form: &'static str,
    /// Spacing along x and y, mm.
    pub step_mm: [f64; 2],
    /// Evaluation area, mm.
    pub size_mm: [f64; 2],
}

/// Height, hybrid and counting parameters of an area. Heights in mm, from the mean of the nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ArealParameters {
    /// Arithmetical mean height, mm.
    pub sa: f64,
    /// Root mean square height, mm.
    pub sq: f64,
    /// Highest point above the mean, mm.
    pub sp: f64,
    /// Lowest point below the mean, mm, positive.
    pub sv: f64,
    /// Sp + Sv, mm.
    pub sz: f64,
    /// Skewness; zero on a flat.
    pub ssk: f64,
    /// Kurtosis; zero on a flat.
    pub sku: f64,
    /// Root mean square gradient: mean of squared differences along x plus that along y.
    pub sdq: f64,
    /// Developed interfacial area ratio, 1 for a doubled area (not percent).
    pub sdr: f64,
}

/// An area, filtered and not.
#[derive(Clone, Debug, PartialEq)]
pub struct ArealEvaluation {
    /// What the filtered values depend on.
    pub setting: ArealSetting,
    /// Values of the filtered map.
    pub filtered: ArealParameters,
    /// Values of the map as it was given.
    pub unfiltered: ArealParameters,
    /// The filtered map.
    pub map: HeightMap,
}

impl HeightMap {
    /// Filters with an L-filter (mm; none leaves it out) and evaluates. The S-filter is left out: maps of
    /// simulated surfaces hold no noise, and their spacing does not carry it.
    pub fn evaluate(&self, l_filter: Option<f64>) -> ArealEvaluation {
        let map = match l_filter {
            Some(cutoff) => self.minus(&gaussian_mean_of_map(self, cutoff)),
            None => self.clone(),
        };
        let setting = ArealSetting {
            standard: "ISO 25178-2:2021",
            s_filter_mm: None,
            l_filter_mm: l_filter,
            ends: "ISO 16610-28:2016, regression of order zero",
            form: "distance to the design along its normal",
            step_mm: [self.step_x(), self.step_y()],
            size_mm: self.size(),
        };
        ArealEvaluation { setting, filtered: map.parameters(), unfiltered: self.parameters(), map }
    }

    /// Parameters of the map as it is: heights from the mean of the nodes, no plane removed, no filter.
    pub fn parameters(&self) -> ArealParameters {
        let heights = self.heights();
        let count = heights.len() as f64;
        let mean = sum(heights.iter().copied()) / count;
        let moment = |f: &dyn Fn(f64) -> f64| sum(heights.iter().map(|z| f(z - mean))) / count;
        let sq2 = moment(&|z| z * z);
        let sq = sq2.sqrt();
        let (mut sp, mut sv) = (0.0_f64, 0.0_f64);
        for z in heights {
            sp = sp.max(z - mean);
            sv = sv.max(mean - z);
        }
        let (ssk, sku) = if sq2 > 0.0 {
            (moment(&|z| z * z * z) / (sq2 * sq), moment(&|z| z * z * z * z) / (sq2 * sq2))
        } else {
            (0.0, 0.0)
        };
        ArealParameters {
            sa: moment(&f64::abs),
            sq,
            sp,
            sv,
            sz: sp + sv,
            ssk,
            sku,
            sdq: self.gradient(),
            sdr: self.developed_ratio(),
        }
    }

    /// Root mean square gradient from the differences of neighbors along each direction (ISO 25178-2:2021,
    /// 4.3.1).
    fn gradient(&self) -> f64 {
        let (nx, ny) = (self.columns(), self.rows());
        let along_x =
            sum((0..ny)
                .flat_map(|j| (1..nx).map(move |i| ((self.at(i, j) - self.at(i - 1, j)) / self.step_x()).powi(2))))
                / ((nx - 1) * ny) as f64;
        let along_y =
            sum((1..ny)
                .flat_map(|j| (0..nx).map(move |i| ((self.at(i, j) - self.at(i, j - 1)) / self.step_y()).powi(2))))
                / (nx * (ny - 1)) as f64;
        (along_x + along_y).sqrt()
    }

    /// Area over its projection, less one: each cell in two triangles, along both diagonals, averaged (ISO
    /// 25178-2:2021, D.15).
    ///
    /// A corner triangle of slopes p, q has sqrt(1 + p^2 + q^2) of its projection. One is taken off in each
    /// cell, in the form s / (1 + sqrt(1 + s)), so that small ratios keep their digits.
    fn developed_ratio(&self) -> f64 {
        let (nx, ny) = (self.columns(), self.rows());
        let excess = |p: f64, q: f64| {
            let s = p * p + q * q;
            s / (1.0 + (1.0 + s).sqrt())
        };
        let cells = (1..ny).flat_map(|j| {
            (1..nx).map(move |i| {
                let (a, b, c, d) = (self.at(i - 1, j - 1), self.at(i, j - 1), self.at(i - 1, j), self.at(i, j));
                let (low, high) = ((b - a) / self.step_x(), (d - c) / self.step_x());
                let (left, right) = ((c - a) / self.step_y(), (d - b) / self.step_y());
                0.25 * (excess(low, left) + excess(low, right) + excess(high, right) + excess(high, left))
            })
        });
        sum(cells) / ((nx - 1) * (ny - 1)) as f64
    }
}

/// Sum with the carry of Neumaier (1974), so that millions of heights lose no digit.
pub(super) fn sum(values: impl Iterator<Item = f64>) -> f64 {
    let (mut total, mut carry) = (0.0_f64, 0.0_f64);
    for v in values {
        let next = total + v;
        carry += if total.abs() >= v.abs() { (total - next) + v } else { (v - next) + total };
        total = next;
    }
    total + carry
}
