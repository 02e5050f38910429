//! The smoothest schedule in rectangles of turn and tilt: of each joint the least peak of acceleration over
//! time.
//!
//! In rectangles the joints do not depend on each other: the taut string of each through its gates
//! has the least sum of every convex function of its speed, and where one of them needs more than
//! its velocity, the time of the blocks grows for both. In that time each joint gets the spline
//! with the least peak of acceleration, then of jerk (`spline_in_corridor.rs`). The largest of all
//! peaks, as parts of the joints' limits, is then as small as it can be.

use super::super::super::taut::{TautGate, free_taut_string};
use super::super::spline_in_corridor::Corridor;
use super::super::{LEAST_SPEED, RAMP, RAMP_PART, VELOCITY_OF_STRING, VELOCITY_USED, at_gates, kept};
use super::joints::Angles;

/// A joint that moves by less than this counts as at rest, radian.
const SAME_ANGLE: f64 = 1e-9;

/// What a schedule is looked for in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangles<'a> {
    /// Lowest and highest position at each block, joint by joint.
    pub(super) gates: &'a [Vec<[f64; 2]>; 2],
    /// Velocity and acceleration of the joints.
    pub(super) limits: [[f64; 2]; 2],
}

impl Rectangles<'_> {
    /// Strings of both joints, and times at the blocks in which both can follow.
    fn strings(&self, times: &[f64]) -> Option<([Vec<f64>; 2], Vec<f64>)> {
        let mut at = vec![0.0];
        for t in times {
            at.push(at[at.len() - 1] + t);
        }
        let mut ways = [Vec::new(), Vec::new()];
        for (way, gates) in ways.iter_mut().zip(self.gates) {
            let row = gates.iter().zip(&at).map(|([low, high], s)| TautGate { s: *s, low: *low, high: *high });
            let string = free_taut_string(&row.collect::<Vec<_>>()).ok()?;
            *way = kept(at_gates(&string, &at), gates);
        }
        let mut stretched = vec![0.0];
        for (i, t) in times.iter().enumerate() {
            let needed = [0, 1].map(|j| (ways[j][i + 1] - ways[j][i]).abs() / (VELOCITY_OF_STRING * self.limits[j][0]));
            stretched.push(stretched[i] + t.max(needed[0]).max(needed[1]));
        }
        Some((ways, stretched))
    }

    /// Turn and tilt at each block. With `rest` both are at rest at the ends, where that is
    /// possible. Peaks of velocity may be `given` times those of the strings. None if the gates are
    /// closed.
    pub(super) fn smoothest(&self, times: &[f64], rest: bool, given: f64) -> Option<Vec<Angles>> {
        let (ways, at) = self.strings(times)?;
        let mut out = vec![[0.0; 2]; ways[0].len()];
        for (j, way) in ways.iter().enumerate() {
            let [velocity, acceleration] = self.limits[j];
            let slope = |i: usize| (way[i + 1] - way[i]).abs() / (at[i + 1] - at[i]);
            let needed = (0..times.len()).map(slope).fold(0.0, f64::max);
            let moves = way.iter().any(|q| (q - way[0]).abs() > SAME_ANGLE);
            let ramp = if acceleration.is_finite() { RAMP_PART * acceleration } else { RAMP };
            let corridor = Corridor {
                times: &at,
                gates: &self.gates[j],
                way,
                velocity: (VELOCITY_USED * velocity).min(given * needed.max(LEAST_SPEED)),
                rising: false,
                ramp,
                rests: if rest { &[true, false] } else { &[false] },
            };
            let found = if moves { corridor.least_peak() } else { None };
            let values = found.as_ref().map_or(way, |f| &f.angles);
            out.iter_mut().zip(values).for_each(|(q, v)| q[j] = *v);
        }
        Some(out)
    }
}

/// Largest velocity and acceleration of each joint over blocks of these times, rad/s and rad/s2.
pub(super) fn peaks(angles: &[Angles], times: &[f64]) -> [[f64; 2]; 2] {
    [0, 1].map(|j| {
        let values: Vec<f64> = angles.iter().map(|q| q[j]).collect();
        super::super::peaks(&values, times)
    })
}
