//! Deviation of a cut surface from its design.

use proveout_geom::{Aabb, Point};
pub use proveout_stock::SurfacePoint;
use rayon::prelude::*;

use crate::DesignSurface;

/// Which points count, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviationSettings {
    /// Points further from the design than this (mm) do not count; infinity lets all count.
    pub range: f64,
    /// Only points inside of this box count.
    pub region: Option<Aabb>,
    /// Only points that a motion has cut count.
    pub only_cut: bool,
    /// Error of the design surface itself (chord error of its mesh), mm: gouges up to it are not counted as
    /// area.
    pub tolerance_floor: f64,
    /// Edges of a cell of the stock along x, y and z, mm: distances of neighboring rays.
    pub cells: [f64; 3],
}

/// Result of a comparison; lengths in mm, areas in mm².
///
/// ```text
///   material outside of the design:  + (excess)        worst: largest magnitude
///   ------------------------------ design ------------
///   material missing inside of it:   - (gouge)
/// ```
///
/// Mean, root mean square and areas weight each point by the area it represents. Rays along axis i with
/// spacing h meet a surface of unit normal n at `|n_i| / h²` points per unit area (`h²` is the area of
/// the two other edges where cells are not cubes). The weight `h² |n_i|` therefore makes the sum over
/// the three families `n_x² + n_y² + n_z² = 1` for each unit of area, with no weight above one cell,
/// while `h² / |n_i|` would let points on grazing rays dominate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Error of the design surface as given.
    pub tolerance_floor: f64,
    /// Deepest point inside of the design, zero or more; the floor is not taken off.
    pub gouge_max: f64,
    /// Highest point outside of the design, zero or more.
    pub excess_max: f64,
    /// Mean deviation, weighted by area.
    pub mean: f64,
    /// Root mean square deviation, weighted by area.
    pub rms: f64,
    /// Area that is deeper inside of the design than the floor.
    pub gouge_area: f64,
    /// Area of all points that count.
    pub area: f64,
    /// Points that count.
    pub samples: u64,
    /// Points inside of the region that the design does not answer for or that are out of range.
    pub out_of_range: u64,
    /// Points that the region, `only_cut` or the caller of [`measure_where`] leaves out.
    pub masked: u64,
    /// Point of largest magnitude, the first one if there are several; none when no point counts.
    pub worst: Option<WorstPoint>,
    /// One value a point, in the order given, mm; NaN where the point does not count.
    pub values: Vec<f64>,
}

/// The point that deviates most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPoint {
    /// Where.
    pub point: Point,
    /// Deviation, mm; negative for a gouge.
    pub deviation: f64,
    /// The motion that cut it.
    pub made_by: Option<u32>,
}

/// What one point gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Judged {
    /// Region or settings leave it out.
    Masked,
    /// The design does not answer for it, or is out of range.
    OutOfRange,
    /// It counts.
    Counts {
        /// Signed deviation, mm.
        deviation: f64,
        /// Area that the point represents, mm².
        weight: f64,
    },
}

impl Judged {
    /// The deviation, not a number where the point does not count.
    pub fn deviation(&self) -> f64 {
        match self {
            Self::Counts { deviation, .. } => *deviation,
            Self::Masked | Self::OutOfRange => f64::NAN,
        }
    }
}

/// Sums over points as they come, with the carry of Neumaier (1974).
#[derive(Debug, Default)]
pub struct Tally {
    result: Deviation,
    area: CarrySum,
    first: CarrySum,
    second: CarrySum,
    gouged: CarrySum,
}

impl Tally {
    /// Nothing yet; gouges up to `tolerance_floor` (mm) are not counted as area.
    pub fn new(tolerance_floor: f64) -> Self {
        Self { result: Deviation { tolerance_floor, ..Deviation::default() }, ..Self::default() }
    }

    /// Adds a point; the order of the points decides the last bits.
    pub fn add(&mut self, sample: &SurfacePoint, judged: &Judged) {
        let result = &mut self.result;
        let (deviation, weight) = match *judged {
            Judged::Masked => return result.masked += 1,
            Judged::OutOfRange => return result.out_of_range += 1,
            Judged::Counts { deviation, weight } => (deviation, weight),
        };
        result.samples += 1;
        result.gouge_max = result.gouge_max.max(-deviation);
        result.excess_max = result.excess_max.max(deviation);
        self.area.add(weight);
        self.first.add(weight * deviation);
        self.second.add(weight * deviation * deviation);
        if deviation < -result.tolerance_floor {
            self.gouged.add(weight);
        }
        if result.worst.is_none_or(|w| deviation.abs() > w.deviation.abs()) {
            result.worst = Some(WorstPoint { point: sample.point, deviation, made_by: sample.made_by });
        }
    }

    /// The sums, without [`Deviation::values`].
    pub fn finish(self) -> Deviation {
        let mut result = self.result;
        result.area = self.area.value();
        result.gouge_area = self.gouged.value();
        if result.area > 0.0 {
            result.mean = self.first.value() / result.area;
            result.rms = (self.second.value() / result.area).max(0.0).sqrt();
        }
        result
    }
}

/// Measures points against a design.
///
/// Distances are found in parallel and summed in the order of the points, so that the result does not depend
/// on the number of threads.
///
/// ```
/// use proveout_geom::{Point, Vector};
/// use proveout_surface::{DeviationSettings, HalfSpaceDesign, SurfacePoint, measure};
///
/// let design = HalfSpaceDesign { point: Point::origin(), normal: Vector::z() };
/// let at = |z: f64| {
///     let point = Point::new(0.0, 0.0, z);
///     SurfacePoint { point, normal: Some(Vector::z()), axis: 2, made_by: None }
/// };
/// let (range, tolerance_floor, cells) = (1.0, 0.005, [0.5; 3]); // mm
/// let (region, only_cut) = (None, false);
/// let settings = DeviationSettings { range, region, only_cut, tolerance_floor, cells };
/// let found = measure(&[at(0.01), at(-0.03)], &design, &settings);
/// assert!((found.excess_max - 0.01).abs() < 1e-12 && (found.gouge_max - 0.03).abs() < 1e-12);
/// assert!((found.mean + 0.01).abs() < 1e-12);
/// assert!((found.area - 0.5).abs() < 1e-12 && (found.gouge_area - 0.25).abs() < 1e-12); // mm2
/// ```
pub fn measure(
    samples: &[SurfacePoint],
    design: &(impl DesignSurface + ?Sized),
    settings: &DeviationSettings,
) -> Deviation {
    measure_where(samples, design, settings, |_| true)
}

/// The same where only some points count: the others get their value and are left out of all sums, as where a
/// finer surface takes their place.
pub fn measure_where(
    samples: &[SurfacePoint],
    design: &(impl DesignSurface + ?Sized),
    settings: &DeviationSettings,
    counts: impl Fn(&SurfacePoint) -> bool,
) -> Deviation {
    let judged: Vec<Judged> = samples.par_iter().map(|s| judge(s, design, settings)).collect();
    let mut tally = Tally::new(settings.tolerance_floor);
    let mut values = Vec::with_capacity(samples.len());
    for (sample, judged) in samples.iter().zip(judged) {
        values.push(judged.deviation());
        let left_out = matches!(judged, Judged::Counts { .. }) && !counts(sample);
        tally.add(sample, if left_out { &Judged::Masked } else { &judged });
    }
    Deviation { values, ..tally.finish() }
}

impl Deviation {
    /// Both parts of a surface as one; `values` stay those of `self`.
    #[must_use]
    pub fn joined(mut self, other: &Self) -> Self {
        let area = self.area + other.area;
        let mean = |a: f64, b: f64| if area > 0.0 { (a * self.area + b * other.area) / area } else { 0.0 };
        (self.mean, self.rms) = (mean(self.mean, other.mean), mean(self.rms * self.rms, other.rms * other.rms).sqrt());
        self.area = area;
        self.gouge_area += other.gouge_area;
        self.gouge_max = self.gouge_max.max(other.gouge_max);
        self.excess_max = self.excess_max.max(other.excess_max);
        self.samples += other.samples;
        self.out_of_range += other.out_of_range;
        self.masked += other.masked;
        let farther = |w: &WorstPoint| self.worst.is_none_or(|mine| w.deviation.abs() > mine.deviation.abs());
        if let Some(worst) = other.worst.filter(farther) {
            self.worst = Some(worst);
        }
        self
    }
}

/// What a point gives against a design.
pub fn judge(s: &SurfacePoint, design: &(impl DesignSurface + ?Sized), settings: &DeviationSettings) -> Judged {
    let outside = settings.region.is_some_and(|b| !b.contains(&s.point));
    if outside || settings.only_cut && s.made_by.is_none() {
        return Judged::Masked;
    }
    let Some(nearest) = design.nearest(&s.point, settings.range) else { return Judged::OutOfRange };
    // Without a normal of its own the point takes that of the design.
    let normal = s.normal.unwrap_or(nearest.normal);
    let axis = usize::from(s.axis.min(2));
    let area = settings.cells[(axis + 1) % 3] * settings.cells[(axis + 2) % 3];
    let weight = area * normal[axis].abs();
    Judged::Counts { deviation: nearest.distance, weight }
}

/// Sum with carry of lost low-order parts.
#[derive(Debug, Default)]
struct CarrySum {
    total: f64,
    carry: f64,
}

impl CarrySum {
    fn add(&mut self, x: f64) {
        let t = self.total + x;
        self.carry += if self.total.abs() >= x.abs() { (self.total - t) + x } else { (x - t) + self.total };
        self.total = t;
    }

    fn value(&self) -> f64 {
        self.total + self.carry
    }
}
