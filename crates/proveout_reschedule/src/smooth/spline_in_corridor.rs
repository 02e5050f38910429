//! The angle over time with the least peak of acceleration inside of gates: a cubic spline with even knots.
//!
//! ```text
//!   q(t) = sum c_j B((t - t_0)/tau - j + 3)
//!   q'     between the (c_{j+1} - c_j)/tau
//!   q''    at knots (c_{j+1} - 2 c_j + c_{j-1})/tau^2
//! ```
//!
//! q'' is straight between knots, so that its peak over all times is that at a knot; q' is a convex
//! combination of its coefficients, so that a spline whose coefficients do not fall does not fall anywhere
//! (C. de Boor 1978, A practical guide to splines, chapters IX and XI). The gates hold at their times.
//!
//! Two programs: the least peak of q'' first; then the least sum of squares of the third
//! differences (the jerk) with at most [`ALLOWED`] times that peak. At the ends the joint is at
//! rest, because lead-in and lead-out keep their axis; there a short ramp may exceed the peak.

use super::LEAST_SPEED;
use super::corridor_program::{CorridorProgram, CorridorRow, WEIGHTS};

/// Knots are this many blocks apart, in the order in which they are tried: fine knots follow a channel with
/// sharp bends.
const BLOCKS_A_KNOT: [f64; 4] = [4.0, 2.0, 1.0, 0.5];
/// By how much the second program may pass the least peak of the first.
const ALLOWED: f64 = 1.03;
/// A peak that nothing is gained from being below, part of the acceleration of the ramps.
const LEAST_PEAK: f64 = 0.002;
/// Gates are narrowed by this, radian, or by a part of their width: rounding.
const NARROWED: f64 = 1e-7;
/// No more knots than this for each gate: blocks of very different times.
const MOST_KNOTS: usize = 8;
/// By how much the second program may pass the least peak in any case, rad/s2.
const LEAST_ROOM: f64 = 1e-4;
/// Least mean square of third differences: the weight of smoothness stays finite.
const LEAST_THIRD: f64 = 1e-18;

/// What the angle must keep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corridor<'a> {
    /// Time of each gate, s, rising.
    pub(super) times: &'a [f64],
    /// Lowest and highest angle, radian.
    pub(super) gates: &'a [[f64; 2]],
    /// A way through the gates: angle at each of them.
    pub(super) way: &'a [f64],
    /// Largest velocity, rad/s.
    pub(super) velocity: f64,
    /// The angle does not fall.
    pub(super) rising: bool,
    /// Acceleration of the ramps at both ends, rad/s2.
    pub(super) ramp: f64,
    /// Whether the joint is at rest at the ends, in the order in which it is tried.
    pub(super) rests: &'a [bool],
}

/// The angle at each gate, with its largest acceleration between the ramps, rad/s2.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SplineAngles {
    pub(super) angles: Vec<f64>,
    pub(super) acceleration: f64,
}

/// Weights of the four coefficients at a place of a cell, 0 to 1.
fn basis(u: f64) -> [f64; WEIGHTS] {
    let v = 1.0 - u;
    let inner = |u: f64| (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0;
    [v * v * v / 6.0, inner(u), inner(v), u * u * u / 6.0]
}

impl Corridor<'_> {
    /// None where no spline with the finest knots passes the gates within the velocity.
    pub(super) fn least_peak(&self) -> Option<SplineAngles> {
        let steps = self.times.len().checked_sub(1).filter(|n| *n >= 3)?;
        let mut blocks: Vec<f64> = self.times.windows(2).map(|t| t[1] - t[0]).collect();
        blocks.sort_by(f64::total_cmp);
        let typical = blocks[steps / 2];
        BLOCKS_A_KNOT.into_iter().find_map(|count| {
            let cells = (self.span() / (count * typical)).ceil().clamp(2.0, (MOST_KNOTS * steps) as f64);
            self.rests.iter().find_map(|rest| self.with_cells(cells as usize, *rest, typical))
        })
    }

    fn span(&self) -> f64 {
        self.times.last().zip(self.times.first()).map_or(0.0, |(b, a)| b - a)
    }

    fn with_cells(&self, cells: usize, rest: bool, block: f64) -> Option<SplineAngles> {
        let knot = self.span() / cells as f64;
        let start = self.times[0];
        let count = cells + 3;
        let place = |t: f64| {
            let at = ((t - start) / knot).clamp(0.0, cells as f64);
            let cell = (at as usize).min(cells - 1);
            (cell, basis(at - cell as f64))
        };
        let slope = |i: usize| (self.way[i + 1] - self.way[i]) / (self.times[i + 1] - self.times[i]);
        let fastest = (0..self.way.len() - 1).map(|i| slope(i).abs()).fold(LEAST_SPEED, f64::max);
        let mut rows: Vec<CorridorRow> = Vec::with_capacity(self.times.len() + 2 * count);
        for (t, [low, high]) in self.times.iter().zip(self.gates) {
            let (at, weights) = place(*t);
            let off = NARROWED.min(0.25 * (high - low));
            rows.push(CorridorRow { at, weights, low: low + off, high: high - off, peak: false });
        }
        // Rows of three or two weights begin where four fit.
        let narrow = |first: usize, weights: &[f64], low: f64, high: f64, peak: bool| {
            let at = first.min(count - WEIGHTS);
            let mut all = [0.0; WEIGHTS];
            for (k, w) in weights.iter().enumerate() {
                all[first - at + k] = *w;
            }
            CorridorRow { at, weights: all, low, high, peak }
        };
        let (most, least) = (self.velocity / fastest, if self.rising { 0.0 } else { -self.velocity / fastest });
        if most.is_finite() || least.is_finite() {
            let scale = 1.0 / (knot * fastest);
            rows.extend((0..count - 1).map(|j| narrow(j, &[-scale, scale], least, most, false)));
        }
        // Accelerations in units of a change of the largest velocity within a knot or a second.
        let unit = fastest / knot.max(1.0);
        let scale = 1.0 / (knot * knot * unit);
        let ramps = 1.5 * fastest / self.ramp + 2.0 * knot;
        let in_ramp = |j: usize| {
            let t = (j as f64) * knot;
            rest && (t < ramps || self.span() - t < ramps)
        };
        let ramp = self.ramp / unit;
        for j in 0..count - 2 {
            rows.push(narrow(j, &[scale, -2.0 * scale, scale], -ramp, ramp, !in_ramp(j)));
        }
        if rest {
            // As fast as half a block of the ramp makes it.
            let slow = 0.5 * self.ramp * block;
            let scale = 0.5 / (knot * slow);
            for first in [0, count - 3] {
                rows.push(narrow(first, &[-scale, 0.0, scale], if self.rising { -0.1 } else { -1.0 }, 1.0, false));
            }
        }
        let begin: Vec<f64> = (0..count).map(|j| self.on_way(start + (j as f64 - 1.0) * knot)).collect();
        let mut program = CorridorProgram { unknowns: count, rows, smoothness: 0.0, peak_cost: 1.0 };
        if !program.rows.iter().any(|r| r.peak) {
            return None;
        }
        let (mut best, peak) = program.solved(&begin)?;
        let bound = (ALLOWED * peak).max(LEAST_PEAK * ramp).max(peak + LEAST_ROOM);
        let third = |x: &[f64]| {
            x.windows(4).map(|c| (c[3] - 3.0 * c[2] + 3.0 * c[1] - c[0]).powi(2)).sum::<f64>() / count as f64
        };
        program.peak_cost = 0.0;
        program.smoothness = 1.0 / third(&best).max(LEAST_THIRD);
        for row in program.rows.iter_mut().filter(|r| r.peak) {
            (row.peak, row.low, row.high) = (false, -bound, bound);
        }
        if let Some((x, _)) = program.solved(&best) {
            best = x;
        }
        let angle = |t: f64| {
            let (cell, weights) = place(t);
            weights.iter().zip(&best[cell..]).map(|(w, c)| w * c).sum::<f64>()
        };
        let acceleration = (0..count - 2)
            .filter(|j| !in_ramp(*j))
            .map(|j| ((best[j] - 2.0 * best[j + 1] + best[j + 2]) / (knot * knot)).abs())
            .fold(0.0, f64::max);
        let mut angles: Vec<f64> = self.times.iter().map(|t| angle(*t)).collect();
        // What a solution is off its gates is rounding.
        for (angle, [low, high]) in angles.iter_mut().zip(self.gates) {
            *angle = angle.clamp(*low, *high);
        }
        if self.rising {
            for i in 1..angles.len() {
                angles[i] = angles[i].max(angles[i - 1]);
            }
        }
        let held = angles.iter().zip(self.gates).all(|(q, [low, high])| q >= low && q <= high);
        held.then_some(SplineAngles { angles, acceleration })
    }

    /// The way at a time, level beyond its ends.
    fn on_way(&self, t: f64) -> f64 {
        let k = self.times.partition_point(|&x| x < t).clamp(1, self.times.len() - 1);
        let part = ((t - self.times[k - 1]) / (self.times[k] - self.times[k - 1])).clamp(0.0, 1.0);
        self.way[k - 1] + (self.way[k] - self.way[k - 1]) * part
    }
}
