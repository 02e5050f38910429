//! What the table needs at least where every block takes its programmed time, and what the new program has of
//! it.

use proveout_reschedule::{LeastPeak, peak_of};
use serde::Serialize;

/// Angles that fall back by less than this have not turned back, radian: eight decimals of a tool vector.
const TURNED_BACK: f64 = 1e-6;

/// The least peak of a derivative of the table's angle in the channel at programmed times, with its proof.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConstantFeed {
    /// The joint.
    pub joint: String,
    /// 2: acceleration, deg/s2; 3: jerk, deg/s3.
    pub order: usize,
    /// Lowest and highest velocity; zero on one side: only motions that never turn back.
    pub velocity_deg_s: [f64; 2],
    /// Of the new program, by divided differences over its blocks.
    pub program_deg: f64,
    /// Of the best row of angles that was found.
    pub reached_deg: f64,
    /// What the weights prove: no motion in the channel has less at these times.
    pub proved_deg: f64,
    /// Weight of each divided difference.
    pub weights: Vec<f64>,
    /// What the velocity limits push in each block: above zero at the highest velocity, below at the lowest.
    pub pushes: Vec<f64>,
}

impl ConstantFeed {
    /// It is about motions that never turn back.
    pub fn one_way(&self) -> bool {
        self.velocity_deg_s.contains(&0.0)
    }
}

/// Least peaks over blocks of these times (s) in the gates of programmed angles (radian), for all motions and
/// for those that do not turn back where the program is one, no faster than a velocity (rad/s).
pub(super) fn constant_feed(
    joint: &str,
    times: &[f64],
    gates: &[[f64; 2]],
    velocity: f64,
    program: &[f64],
) -> Vec<ConstantFeed> {
    let (first, last) = (program.first().copied().unwrap_or(0.0), program.last().copied().unwrap_or(0.0));
    let sense = (last - first).signum();
    let rises = program.windows(2).all(|q| sense * (q[1] - q[0]) > -TURNED_BACK);
    let one_way = if sense > 0.0 { [0.0, velocity] } else { [-velocity, 0.0] };
    let ranges = [[-velocity, velocity], one_way];
    let inside: Vec<f64> = program.iter().zip(gates).map(|(q, [low, high])| q.clamp(*low, *high)).collect();
    let mut out = Vec::new();
    for order in [2, 3] {
        for range in ranges.iter().take(if rises && sense != 0.0 { 2 } else { 1 }) {
            let Some(found) = LeastPeak::new(times, gates, order, *range, &inside) else { continue };
            out.push(ConstantFeed {
                joint: joint.to_owned(),
                order,
                velocity_deg_s: range.map(f64::to_degrees),
                program_deg: peak_of(times, program, order).to_degrees(),
                reached_deg: found.reached.to_degrees(),
                proved_deg: found.proved.to_degrees(),
                weights: found.weights,
                pushes: found.pushes,
            });
        }
    }
    out
}
