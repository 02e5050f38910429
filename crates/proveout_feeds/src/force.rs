//! Forces of one moment of a cut, from the slices in which the cutter is engaged.
//!
//! A tooth under the angle p, seen from the spindle: 0 on the left of the feed, a quarter turn in front. An
//! edge element with the normal (`n_r`, `n_d`) (radial, downward) goes through material with the chip
//! thickness
//!
//! ```text
//! h(p) = (v_x n_r sin p + v_d n_d) / (teeth per second)        v_x: feed across the axis, v_d: down along it
//! ```
//!
//! of the velocities of its own slice, so that a turning axis counts. Where h is above zero and p lies in the
//! range of the slice, the element has the force of [`Material`]. All h grow with the feed alike, so that
//! forces are A s^(1 - m) + B for a feed s times as large, with A and B found once: the largest feed under a
//! limit is a search in one number.
//!
//! Means over a revolution are integrals over each element's range by Gauss and Legendre; peaks are taken
//! over the angles of one pitch in steps of three degrees and at each angle where an edge enters or leaves a
//! slice. Teeth are alike; the run-out counts for the chip thickness alone.

use std::f64::consts::{FRAC_PI_2, TAU};

use proveout_tool::Tool;

use crate::{
    compliance::Compliance,
    cutter_edges::{CutterEdges, EdgeElement},
    material::{Material, ThicknessConvention},
};

/// Steps of the angle for peaks, radian.
const STEP: f64 = TAU / 120.0;
/// Inside of a range by this much an edge is in it, radian.
const INSIDE: f64 = 1e-9;
/// Nodes and weights of Gauss and Legendre on -1 to 1, of order 8: half of them, the others mirror.
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_3),
];
/// Parts of a range of angles in which the integrals run.
const PARTS: usize = 4;

/// One slice of the cutter in material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceCut {
    /// Lowest and highest point in material above the tip, mm.
    pub height: [f64; 2],
    /// Angles at which a tooth enters and leaves material, radian; none where only the end goes down.
    pub range: Option<[f64; 2]>,
    /// Material lies all around: the cutter goes down.
    pub around: bool,
    /// Feed across the axis at this slice, mm/s.
    pub feed_across: f64,
    /// Feed down along the axis, mm/s; below zero where the tool goes up.
    pub feed_down: f64,
}

/// Loads at one moment, at one feed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loads {
    /// Largest uncut chip thickness with run-out, mm.
    pub chip_mm: f64,
    /// Largest force across the axis in a revolution, N.
    pub force_peak_n: f64,
    /// Length of the mean force across the axis, N.
    pub force_mean_n: f64,
    /// Largest torque in a revolution, N m.
    pub torque_peak_nm: f64,
    /// Mean torque, N m.
    pub torque_mean_nm: f64,
    /// Mean power at the spindle motor, kW.
    pub power_kw: f64,
    /// Deflection of the tip at the largest force, micrometers; none where the tool's stiffness is not known.
    pub deflection_um: Option<f64>,
}

/// Forces of a tool in a material.
#[derive(Clone, Debug)]
pub struct ForceModel {
    edges: CutterEdges,
    end: Vec<EdgeElement>,
    material: Material,
    compliance: Option<Compliance>,
    /// Part of the motor's power that arrives at the cut.
    efficiency: f64,
}

/// Force and torque: x against the feed, y to the left, N; torque N mm.
type Wrench = [f64; 3];

/// What a moment of a cut does, as far as it does not depend on the feed.
#[derive(Clone, Debug)]
pub struct CutLoads {
    /// Of the growing part and of the edge part, by angle of the tool.
    turning: Vec<(Wrench, Wrench)>,
    mean: (Wrench, Wrench),
    chip: f64,
    run_out: f64,
    exponent: f64,
    /// mm/N; none where not known.
    bending: Option<f64>,
    /// kW for each N mm of mean torque.
    kw_per_nmm: f64,
}

impl ForceModel {
    /// `efficiency` is the part of the spindle motor's power that arrives at the cut, above 0 up to 1. None
    /// for a tool without teeth.
    pub fn new(tool: &Tool, material: Material, efficiency: f64, compliance: Option<Compliance>) -> Option<Self> {
        let edges = CutterEdges::of_tool(tool)?;
        Some(Self { end: edges.end(), edges, material, compliance, efficiency })
    }

    /// The same without a material: chip thickness alone, all forces are zero.
    pub fn of_chips(tool: &Tool) -> Option<Self> {
        let material = Material {
            name: String::new(),
            source: String::new(),
            convention: ThicknessConvention::ChipThickness,
            kc11: 0.0,
            exponent: 0.0,
            edge_force: 0.0,
            radial_ratio: 0.0,
            axial_ratio: 0.0,
            uncertainty_percent: 0.0,
        };
        Self::new(tool, material, 1.0, None)
    }

    /// The material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Loads of slices at a spindle speed, 1/min; none where the spindle does not turn.
    pub fn loads(&self, slices: &[SliceCut], speed_rpm: f64) -> Option<CutLoads> {
        if !(speed_rpm > 0.0 && speed_rpm.is_finite()) {
            return None;
        }
        let teeth = f64::from(self.edges.teeth);
        let per_tooth = 60.0 / (speed_rpm * teeth);
        let mut cuts: Vec<(EdgeElement, SliceCut)> = Vec::new();
        for slice in slices {
            if slice.feed_down > 0.0 && slice.around && slice.height[0] < LOW_MM {
                cuts.extend(self.end.iter().map(|e| (*e, SliceCut { range: None, ..*slice })));
            }
            cuts.extend(self.edges.between(slice.height).into_iter().map(|e| (e, *slice)));
        }
        let mut mean = ([0.0; 3], [0.0; 3]);
        let (mut chip, mut moment, mut width) = (0.0_f64, 0.0, 0.0);
        for (e, slice) in &cuts {
            let Some(range) = range_of(slice) else { continue };
            let [first, last] = range;
            let highest = highest_sine(first, last);
            let feed = [slice.feed_across, slice.feed_down].map(|v| v * per_tooth);
            chip = chip.max(feed[0] * e.normal[0] * highest + feed[1] * e.normal[1]);
            (moment, width) = (moment + e.height * e.width, width + e.width);
            let part = (last - first) / PARTS as f64;
            for k in 0..PARTS {
                let middle = first + (k as f64 + 0.5) * part;
                for (node, weight) in NODES {
                    for side in [-1.0, 1.0] {
                        let angle = middle + 0.5 * part * node * side;
                        let share = teeth * 0.5 * part * weight / TAU;
                        self.add(&mut mean, e, feed, angle, share);
                    }
                }
            }
        }
        let turning = self.over_a_pitch(&cuts, per_tooth);
        let height = if width > 0.0 { moment / width } else { 0.0 };
        Some(CutLoads {
            turning,
            mean,
            chip: chip.max(0.0),
            run_out: self.edges.run_out_step,
            exponent: 1.0 - self.material.exponent,
            bending: self.compliance.as_ref().map(|c| c.at_tip(height)),
            kw_per_nmm: speed_rpm * TAU / 60.0 * 1e-6 / self.efficiency,
        })
    }

    /// Sums over the teeth at the angles of one pitch.
    fn over_a_pitch(&self, cuts: &[(EdgeElement, SliceCut)], per_tooth: f64) -> Vec<(Wrench, Wrench)> {
        let pitch = TAU / f64::from(self.edges.teeth);
        let steps = (pitch / STEP).ceil().max(8.0) as usize;
        let mut angles: Vec<f64> = (0..steps).map(|k| pitch * k as f64 / steps as f64).collect();
        for (e, slice) in cuts {
            if let Some([first, last]) = range_of(slice) {
                angles.push((first + INSIDE + e.lag).rem_euclid(pitch));
                angles.push((last - INSIDE + e.lag).rem_euclid(pitch));
            }
        }
        angles.sort_by(f64::total_cmp);
        angles.dedup_by(|a, b| (*a - *b).abs() < 0.1 * INSIDE);
        let of = |angle: &f64| {
            let mut sum = ([0.0; 3], [0.0; 3]);
            for (e, slice) in cuts {
                let Some([first, last]) = range_of(slice) else { continue };
                let feed = [slice.feed_across, slice.feed_down].map(|v| v * per_tooth);
                for tooth in 0..self.edges.teeth {
                    let p = first + (angle + f64::from(tooth) * pitch - e.lag - first).rem_euclid(TAU);
                    if p <= last {
                        self.add(&mut sum, e, feed, p, 1.0);
                    }
                }
            }
            sum
        };
        angles.iter().map(of).collect()
    }

    /// Adds the force of an element under an angle: what grows with the feed, and what the edge has.
    fn add(&self, sum: &mut (Wrench, Wrench), e: &EdgeElement, feed: [f64; 2], angle: f64, share: f64) {
        let (sin, cos) = angle.sin_cos();
        let h = feed[0] * e.normal[0] * sin + feed[1] * e.normal[1];
        if h <= 0.0 || h.is_nan() {
            return;
        }
        let m = &self.material;
        let kc = m.specific_force(match m.convention {
            ThicknessConvention::ChipThickness => h,
            ThicknessConvention::FeedPerTooth => feed[0].hypot(feed[1]),
        });
        // Left is +y, the feed is +x: the tooth is at (sin, cos) and runs to (cos, -sin), the sense of a
        // spindle that turns clockwise.
        let across = m.radial_ratio * e.normal[0] - m.axial_ratio * e.normal[1];
        let direction = [-cos - across * sin, sin - across * cos, e.radius];
        let [grows, stays] = [kc * h, m.edge_force].map(|f| f * e.width * share);
        for (k, d) in direction.into_iter().enumerate() {
            sum.0[k] += grows * d;
            sum.1[k] += stays * d;
        }
    }
}

/// Heights up to which the end of the tool is in the slice, mm.
const LOW_MM: f64 = 0.01;

/// Angles in which the elements of a slice may cut.
fn range_of(slice: &SliceCut) -> Option<[f64; 2]> {
    if slice.around {
        return Some([0.0, TAU]);
    }
    slice.range.filter(|[first, last]| first.is_finite() && last > first)
}

/// Largest sine of the angles of a range.
fn highest_sine(first: f64, last: f64) -> f64 {
    if first <= FRAC_PI_2 && FRAC_PI_2 <= last { 1.0 } else { first.sin().max(last.sin()) }
}

impl CutLoads {
    /// Loads at `scale` times the feed.
    pub fn at(&self, scale: f64) -> Loads {
        let grown = scale.max(0.0).powf(self.exponent);
        let sum = |(a, b): &(Wrench, Wrench), k: usize| grown * a[k] + b[k];
        let across = |w: &(Wrench, Wrench)| sum(w, 0).hypot(sum(w, 1));
        let force_peak_n = self.turning.iter().map(across).fold(0.0, f64::max);
        let torque_peak = self.turning.iter().map(|w| sum(w, 2)).fold(0.0, f64::max);
        let torque_mean = sum(&self.mean, 2);
        Loads {
            chip_mm: if self.chip > 0.0 { scale * self.chip + self.run_out } else { 0.0 },
            force_peak_n,
            force_mean_n: across(&self.mean),
            torque_peak_nm: torque_peak * 1e-3,
            torque_mean_nm: torque_mean * 1e-3,
            power_kw: torque_mean * self.kw_per_nmm,
            deflection_um: self.bending.map(|c| 1e3 * c * force_peak_n),
        }
    }

    /// Mean force against the feed and to the left of it, at `scale` times the feed, N.
    pub fn mean_force(&self, scale: f64) -> [f64; 2] {
        let grown = scale.max(0.0).powf(self.exponent);
        [0, 1].map(|k| grown * self.mean.0[k] + self.mean.1[k])
    }
}
