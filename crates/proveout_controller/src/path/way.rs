//! The way along the path that is run: what the programmed feed, lengths and times at the feed are about.
//!
//! The parameter s is the length of the *programmed* path. A rounded corner cuts it short: its tip moves by
//! |y'(s)| ds, with |y'| down to cos(half of the corner's angle) in the middle. The programmed feed F holds
//! for the tip on the path that is run, so that
//!
//! ```text
//!   |y'(s)| ds/dt <= F          length = integral of |y'| ds          time at the feed = length / F
//! ```
//!
//! A feed by time (G93) means the programmed length of its block over that time, and holds in the
//! same way.
//!
//! Between a block that moves the tip and one that only turns the rotary joints (whose parameter is in
//! degrees) neither rate has a meaning throughout; there the parameter itself runs at the feed.

use proveout_machine::{JointKind, JointValues, MAX_JOINTS, Machine};

use crate::{jet::JointJet, shape::Quintic, tempo::GAUSS};

/// What counts as way on a stretch of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum WayMeasure {
    /// The parameter: exact blocks, and blends between motion and turning.
    #[default]
    Parameter,
    /// The tip (with tool center point control) or the linear joints together, mm.
    Tip,
    /// The rotary joints together, degrees.
    Turn,
}

/// A stretch no longer than this part of a span takes one rule of eight points, a span four of them. The rate
/// of a corner of 90 degrees is then summed to 1e-10 of the span, one of 160 degrees to 1e-6.
const PARTS: f64 = 4.0;

impl WayMeasure {
    /// Of a blend between two blocks that move the tip, or do not.
    pub(crate) fn of(tip_moves: [bool; 2]) -> Self {
        match tip_moves {
            [true, true] => Self::Tip,
            [false, false] => Self::Turn,
            _ => Self::Parameter,
        }
    }

    /// What counts of the slope of one joint.
    fn of_joint(self, kind: JointKind, slope: f64) -> f64 {
        match (self, kind) {
            (Self::Tip, JointKind::Linear) => slope,
            (Self::Turn, JointKind::Rotary) => slope.to_degrees(),
            _ => 0.0,
        }
    }

    /// What counts of a slope of task coordinates, as vector.
    fn counted(self, machine: &Machine, slope: &JointValues) -> JointValues {
        let mut out = JointValues::ZERO;
        for (i, joint) in machine.joints.iter().enumerate() {
            out[i] = self.of_joint(joint.kind, slope[i]);
        }
        out
    }

    /// Way by the parameter, and its derivative by the parameter.
    pub(crate) fn rate(self, machine: &Machine, task: &JointJet) -> [f64; 2] {
        if self == Self::Parameter {
            return [1.0, 0.0];
        }
        let (mut square, mut cross) = (0.0, 0.0);
        for (i, joint) in machine.joints.iter().enumerate() {
            let [slope, bend] = [task.0[1][i], task.0[2][i] * 2.0].map(|x| self.of_joint(joint.kind, x));
            square += slope * slope;
            cross += slope * bend;
        }
        let rate = f64::sqrt(square);
        [rate, if rate > 0.0 { cross / rate } else { 0.0 }]
    }

    /// Bounds of the rate over a whole piece: its slope lies in the hull of the control points of its
    /// derivative. Their longest is no shorter; how far all of them reach along their mean is no longer.
    pub(crate) fn range(self, machine: &Machine, piece: &Quintic) -> [f64; 2] {
        if self == Self::Parameter {
            return [1.0, 1.0];
        }
        let slopes = piece.slopes().map(|slope| self.counted(machine, &slope));
        let mean = slopes.iter().fold(JointValues::ZERO, |sum, slope| sum + *slope);
        let size = dot(&mean, &mean).sqrt();
        let high = slopes.iter().map(|slope| dot(slope, slope)).fold(0.0, f64::max).sqrt();
        let low = slopes.iter().map(|slope| dot(slope, &mean)).fold(f64::INFINITY, f64::min) / size;
        [if low > 0.0 { low.min(high) } else { 0.0 }, high]
    }

    /// Length of a part of a piece.
    pub(crate) fn length(self, machine: &Machine, piece: &Quintic, [from, to]: [f64; 2]) -> f64 {
        if self == Self::Parameter {
            return to - from;
        }
        let parts = (PARTS * (to - from) / (piece.u1 - piece.u0)).ceil().clamp(1.0, PARTS);
        let half = 0.5 * (to - from) / parts;
        // Control points of the slopes that count, a joint after the other.
        let slopes = piece.slopes();
        let (mut rows, mut count) = ([[0.0; 5]; MAX_JOINTS], 0);
        for (i, joint) in machine.joints.iter().enumerate().take(MAX_JOINTS) {
            let row = [0, 1, 2, 3, 4].map(|k: usize| self.of_joint(joint.kind, slopes[k][i]));
            if row != [0.0; 5] {
                rows[count] = row;
                count += 1;
            }
        }
        let over = 1.0 / (piece.u1 - piece.u0);
        let rate = |u: f64| {
            let t = ((u - piece.u0) * over).clamp(0.0, 1.0);
            let r = 1.0 - t;
            let (tt, rr) = (t * t, r * r);
            let weights = [rr * rr, 4.0 * rr * r * t, 6.0 * rr * tt, 4.0 * r * t * tt, tt * tt];
            let slope = |row: &[f64; 5]| row.iter().zip(&weights).map(|(s, w)| s * w).sum::<f64>();
            rows[..count].iter().map(|row| slope(row).powi(2)).sum::<f64>().sqrt()
        };
        let part = |k: usize| {
            let middle = from + half * (2.0 * k as f64 + 1.0);
            GAUSS.iter().map(|(at, weight)| weight * (rate(middle - half * at) + rate(middle + half * at))).sum::<f64>()
        };
        half * (0..parts as usize).map(part).sum::<f64>()
    }
}

fn dot(u: &JointValues, w: &JointValues) -> f64 {
    u.0.iter().zip(&w.0).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> Machine {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
        Machine::read(&folder).expect("library machine")
    }

    /// A corner of some angle between two lines in the first two linear joints, rounded over -1..=1.
    fn corner(machine: &Machine, angle: f64) -> Quintic {
        let linear: Vec<usize> = (0..machine.joints.len()).filter(|i| !machine.joints[*i].is_rotary()).collect();
        let along = |a: f64| {
            let mut slope = JointValues::ZERO;
            (slope[linear[0]], slope[linear[1]]) = (a.cos(), a.sin());
            slope
        };
        let (u, w) = (along(0.0), along(angle));
        let jet = |at: JointValues, slope| JointJet([at, slope, JointValues::ZERO, JointValues::ZERO]);
        Quintic::hermite(-1.0, 1.0, &jet(u * -1.0, u), &jet(w, w))
    }

    #[test]
    fn a_rounded_corner_is_as_long_as_many_chords_of_it() {
        let machine = machine();
        for (degrees, close) in [(5.0_f64, 1e-9), (90.0, 1e-8), (160.0, 1e-5)] {
            let piece = corner(&machine, degrees.to_radians());
            let at = |k: i32| piece.jet(-1.0 + f64::from(k) / 5000.0).0[0];
            let chords: f64 =
                (0..10_000).map(|k| (at(k + 1) - at(k)).0.iter().map(|x| x * x).sum::<f64>().sqrt()).sum();
            let length = WayMeasure::Tip.length(&machine, &piece, [-1.0, 1.0]);
            assert!((length - chords).abs() < close, "{degrees}: {length} {chords}");
            let parts = [[-1.0, -0.3], [-0.3, 0.9], [0.9, 1.0]];
            let sum: f64 = parts.iter().map(|part| WayMeasure::Tip.length(&machine, &piece, *part)).sum();
            assert!((length - sum).abs() < close, "{degrees}: {length} {sum}");
            assert_eq!(WayMeasure::Turn.length(&machine, &piece, [-1.0, 1.0]), 0.0);
            assert_eq!(WayMeasure::Parameter.length(&machine, &piece, [-1.0, 0.5]), 1.5);
            // In the middle the slope is the mean of both.
            let [middle, slope] = WayMeasure::Tip.rate(&machine, &piece.jet(0.0));
            assert!((middle - (0.5 * degrees.to_radians()).cos()).abs() < 1e-12 && slope.abs() < 1e-12);
            let h = 1e-5;
            let [before, at, after] = [-h, 0.0, h].map(|x| WayMeasure::Tip.rate(&machine, &piece.jet(0.4 + x)));
            assert!(((after[0] - before[0]) / (2.0 * h) - at[1]).abs() < 1e-8);
        }
    }

    #[test]
    fn the_rate_stays_within_its_range_on_every_part() {
        let machine = machine();
        for degrees in [1.0_f64, 45.0, 90.0, 135.0, 179.0] {
            let piece = corner(&machine, degrees.to_radians());
            for (a, b) in [(-1.0, 1.0), (-1.0, 0.0), (-0.2, 0.1), (0.5, 0.75)] {
                let part = piece.between(a, b);
                let [low, high] = WayMeasure::Tip.range(&machine, &part);
                for k in 0..=100 {
                    let s = a + (b - a) * f64::from(k) / 100.0;
                    let [rate, _] = WayMeasure::Tip.rate(&machine, &piece.jet(s));
                    assert!(rate >= low - 1e-12 && rate <= high + 1e-12, "{degrees} {s}: {low} {rate} {high}");
                    assert!((part.jet(s).0[0] - piece.jet(s).0[0]).max_abs() < 1e-13);
                }
                assert!(b - a > 0.5 || degrees > 100.0 || high - low < 0.2, "{degrees}: {low} {high}");
            }
        }
    }
}
