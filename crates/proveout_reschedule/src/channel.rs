//! The interference-free channel of the tool axis angle along a path of ball centers.
//!
//! A shaft of the ball's radius touches the blade exactly when the ray from the ball center along the tool
//! axis meets the path of ball centers, so the planar problem is one of visibility on that path.
//!
//! *Tabulated rule* (Li et al. 2022, equation (2), corrected: specification 3.2, errata ST-6 to
//! ST-8). With chord angles g (incoming) and f (outgoing) the forward limit of a convex point is g,
//! the backward limit f - pi; on a concave arc they are those of its exit and its entry; then
//! envelopes make both non-decreasing. On a concave arc chord angles fall, so that its exit has the
//! smallest one ahead and its entry the largest one passed. The whole rule is therefore
//!
//! ```text
//!   forward(S)  = min of g over all blocks ahead
//!   backward(S) = max of f over all blocks passed, less pi
//! ```
//!
//! It is on the safe side of the exact rule: a straight line from `Q_i` to a point ahead is a sum of the
//! chords between them, each at an angle of at least `forward`, and as long as those stay within half a turn
//! the sum lies in their cone. The path is continued at both ends by one layer, shifted by a turn: the blade
//! does not end where the path does.

use std::f64::consts::{PI, TAU};

use super::{RescheduleError, SectionPath};

/// Limits of the tool axis angle at each block, radian, in the sense and zero of [`SectionPath::axis_angle`].
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Largest angle (tool leaned forward), clearance taken off; non-decreasing.
    pub upper: Vec<f64>,
    /// Smallest angle, clearance added; non-decreasing.
    pub lower: Vec<f64>,
}

impl Channel {
    /// Limits by the tabulated rule with a clearance on both sides, radian.
    ///
    /// # Errors
    /// `reschedule-channel`: the limits leave less than `narrowest` radian at some block.
    pub fn tabulated(path: &SectionPath, clearance: f64, narrowest: f64) -> Result<Self, RescheduleError> {
        let (forward, backward) = limits(path);
        let upper: Vec<f64> = forward.iter().map(|a| a - clearance).collect();
        let lower: Vec<f64> = backward.iter().map(|a| a + clearance).collect();
        let channel = Self { upper, lower };
        if let Some(first) = (0..path.len()).find(|&i| channel.width(i) < narrowest) {
            let worst = (0..path.len()).map(|i| channel.width(i)).fold(f64::MAX, f64::min);
            let free = worst + 2.0 * clearance;
            let turning = (PI - free).max(0.0).to_degrees();
            let fits = 0.5 * (free - narrowest).to_degrees();
            return Err(RescheduleError::new(
                "reschedule-channel",
                path.lines[first],
                format!(
                    "there is no channel: the concave side turns by {turning:.1} degrees, and a clearance of {:.1} \
                     degrees on both sides leaves {:.1} degrees; {:.1} are needed",
                    clearance.to_degrees(),
                    worst.to_degrees(),
                    narrowest.to_degrees()
                ),
                if fits > 0.0 {
                    format!("set the clearance to at most {fits:.1} degrees, or take a slimmer tool")
                } else {
                    "the concave side turns too far for any clearance: split the path, or turn the blade over"
                        .to_owned()
                },
            ));
        }
        Ok(channel)
    }

    /// Width at block i, radian.
    pub fn width(&self, i: usize) -> f64 {
        self.upper[i] - self.lower[i]
    }

    /// Smallest distance of angles from the limits, radian; below zero where a limit is passed.
    pub fn margin(&self, angles: &[f64]) -> f64 {
        angles
            .iter()
            .zip(self.upper.iter().zip(&self.lower))
            .map(|(a, (u, l))| (u - a).min(a - l))
            .fold(f64::MAX, f64::min)
    }
}

/// Index of the block nearest to an arc length.
fn at_arc(path: &SectionPath, arc: f64) -> usize {
    let i = path.arc.partition_point(|&s| s < arc).min(path.len() - 1);
    if i > 0 && arc - path.arc[i - 1] < path.arc[i] - arc { i - 1 } else { i }
}

/// Forward and backward limits by the tabulated rule, without clearance.
fn limits(path: &SectionPath) -> (Vec<f64>, Vec<f64>) {
    let n = path.len();
    // The layer after the end repeats the last one a turn further, the layer before the start the
    // first one a turn back.
    let again = at_arc(path, path.arc[n - 1] - path.period);
    let before = at_arc(path, path.period);
    let mut ahead = path.incoming[again..].iter().fold(f64::MAX, |m, a| m.min(a + TAU));
    let mut forward = vec![0.0; n];
    for i in (0..n).rev() {
        ahead = ahead.min(path.incoming[i]);
        forward[i] = ahead;
    }
    let mut behind = path.outgoing[..=before].iter().fold(f64::MIN, |m, a| m.max(a - TAU));
    let mut backward = vec![0.0; n];
    for (limit, angle) in backward.iter_mut().zip(&path.outgoing) {
        behind = behind.max(*angle);
        *limit = behind - PI;
    }
    (forward, backward)
}

/// Limits of a block by visibility over the next and the previous layer, without clearance: the
/// smallest unwrapped angle of a line to any point ahead, and the largest one of a line from any
/// point passed, less pi. Cost grows with the blocks of a layer; this is the reference for the
/// tabulated rule, not a way to plan.
pub fn exact_limits(path: &SectionPath, i: usize) -> [f64; 2] {
    let near = |angle: f64, to: f64| angle - TAU * ((angle - to) / TAU).round();
    let [u, v, _] = path.basis;
    let angle = |a: usize, b: usize| {
        let d = path.centers[b] - path.centers[a];
        d.dot(&v).atan2(d.dot(&u))
    };
    let mut forward = path.outgoing[i];
    let mut last = forward;
    for j in i + 1..path.len() {
        if path.arc[j] - path.arc[i] > 0.9 * path.period {
            break;
        }
        last = near(angle(i, j), last);
        forward = forward.min(last);
    }
    let mut backward = path.incoming[i];
    last = backward;
    for j in (0..i).rev() {
        if path.arc[i] - path.arc[j] > 0.9 * path.period {
            break;
        }
        last = near(angle(j, i), last);
        backward = backward.max(last);
    }
    [forward, backward - PI]
}
