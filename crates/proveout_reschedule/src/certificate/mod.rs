//! How far a schedule is from the best one: a lower bound of the time of *every* schedule in a channel.
//!
//! *What is bound.* A stretch of blocks; block i takes at least `least[i]`, by its programmed feed. Each
//! joint that has a channel is within a gate `[low, high]` at every border of blocks, and keeps its limits of
//! velocity, acceleration and jerk in between. Nothing is said of its motion between the gates, of other
//! joints, or of how the stretch begins and ends, so that the bound holds for every schedule, feed law and
//! control that does this.
//!
//! *Three proofs*, each of a window of blocks:
//!
//! ```text
//!   feed      the sum of `least`
//!   travel    from below `high` of a gate to above `low` of a later one (or down): the distance over
//!             the velocity limit
//!   swings    above one gate, below a later one, above the next ...: between two of them the joint
//!             turns back beyond the first and beyond the second, and the times from turn to turn add
//!             (`swing.rs`)
//! ```
//!
//! *Feed and velocity, exactly.* The least of `sum max(least_i, |dq_i| / V)` over all positions in the gates
//! is a linear program; its dual has an optimum of zeros and ones, which is a row of windows of feed and of
//! travel. The best row is found gate by gate (`windows.rs`), for all joints at once. The least itself is
//! taken on the taut string over the time of the feed with both ends free (Davies and Kovac 2001), which is
//! steeper than V where the proof has travels. A window of feed loses a little at both of its ends, since the
//! control may round its corners (`feed_floor.rs`).
//!
//! *Swings.* Let the gates `g_0 < g_1 < ..` demand `q <= a_0, q >= a_1, q <= a_2, ..` with `a_0 < a_1 > a_2 <
//! ..`. Let `e_1` be where q is largest between `g_0` and `g_2`, `e_2` where it is least between `e_1` and
//! `g_3`, and so on. At both ends of each of these intervals q is on the other side of the demand in its
//! inside, so that the extreme lies inside, q' is zero there, the `e_k` rise, and `|q(e_k+1) - q(e_k)| >=
//! |a_k+1 - a_k|`. From `g_0` to `e_1` and from the last e to the last gate the joint is in motion at one
//! end. The corners at which the taut string turns back are the gates that demand most; the times for a
//! distance are such that a swing never takes less than one that leaves two of its gates out.
//!
//! *Windows.* Bounds of windows that do not overlap add. The stretch is halved again and again; each half
//! takes the largest of its own proofs and of the sum of its halves. The windows do not depend on the
//! channel, so that the bound never rises where a gate is widened or a limit is raised.
//!
//! *Limits.* Acceleration and jerk count only where the joint must turn back: a channel that can be followed
//! in one sense of motion is bound by feed and velocity alone. Joints are looked at one by one; linear joints
//! that follow the tool axis are not. Neither is the joint law of a control that does not run at its limits.

mod cells;
mod feed_floor;
mod least_peak;
#[cfg(test)]
mod random_schedules;
mod swing;
#[cfg(test)]
mod tests;
mod windows;

pub use cells::{AxisPair, Caps, CellBound};
pub use feed_floor::FeedFloor;
pub use least_peak::{LeastPeak, peak_of};
pub use swing::SwingLimits;

use super::{TautGate, taut_string};

/// A joint with the channel that it must keep to.
#[derive(Clone, Debug, PartialEq)]
pub struct JointGates {
    /// Name of the joint.
    pub name: String,
    /// Its limits, radian and seconds (mm of a linear joint).
    pub limits: SwingLimits,
    /// Lowest and highest position at the begin of the first block and at the end of each block; infinite
    /// where nothing is demanded.
    pub gates: Vec<[f64; 2]>,
}

/// All schedules of a stretch of blocks, as far as the motion of their joints distinguishes them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedules {
    /// Least time of each block, s; above zero.
    pub least: Vec<f64>,
    /// Joints with a channel, each with a gate more than there are blocks.
    pub joints: Vec<JointGates>,
}

/// What is wrong with [`Schedules`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SchedulesError {
    /// A block without a time.
    #[error("block {0} has no least time")]
    Time(usize),
    /// A gate that is empty or no number, or gates that are missing: joint and gate.
    #[error("joint {0} has no gate {1}")]
    Gate(usize, usize),
    /// A time that windows lose at a gate is missing or below zero: the gate.
    #[error("gate {0} has no time that windows lose there")]
    Seam(usize),
    /// A limit that is not above zero: the joint.
    #[error("joint {0} has no velocity limit, or a limit that is not above zero")]
    Limit(usize),
}

/// Why a window takes its time. Gates are counted from 0, the begin of the first block.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// The blocks between two gates at their least times.
    Feed {
        /// First and last gate.
        gates: [usize; 2],
    },
    /// A joint goes from one gate to a later one at its velocity.
    Travel {
        /// The joint.
        joint: usize,
        /// First and last gate.
        gates: [usize; 2],
        /// It goes up.
        up: bool,
    },
    /// A joint turns back at each gate between the first and the last.
    Swings {
        /// The joint.
        joint: usize,
        /// Three gates or more.
        gates: Vec<usize>,
        /// It goes up from the first to the second.
        up: bool,
    },
}

impl Proof {
    /// First and last gate.
    pub fn span(&self) -> [usize; 2] {
        match self {
            Self::Feed { gates } | Self::Travel { gates, .. } => *gates,
            Self::Swings { gates, .. } => [gates.first().copied().unwrap_or(0), gates.last().copied().unwrap_or(0)],
        }
    }
}

/// A lower bound of the time of all schedules, with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// By the feed alone, s.
    pub feed: f64,
    /// By feed and velocity of each joint, s; the largest there is for one joint and these two.
    pub velocity: Vec<f64>,
    /// The largest one, s.
    pub bound: f64,
    /// Its proof: windows that follow each other and do not overlap, each with its time, s.
    pub windows: Vec<(Proof, f64)>,
}

impl Schedules {
    fn check(&self) -> Result<(), SchedulesError> {
        if let Some(block) = self.least.iter().position(|t| !(t.is_finite() && *t > 0.0)) {
            return Err(SchedulesError::Time(block));
        }
        for (k, joint) in self.joints.iter().enumerate() {
            if joint.gates.len() != self.least.len() + 1 {
                return Err(SchedulesError::Gate(k, joint.gates.len().min(self.least.len())));
            }
            let empty = |[low, high]: &[f64; 2]| low.is_nan() || high.is_nan() || low > high;
            if let Some(gate) = joint.gates.iter().position(empty) {
                return Err(SchedulesError::Gate(k, gate));
            }
            let SwingLimits { velocity, acceleration, jerk } = joint.limits;
            if !(velocity > 0.0 && velocity.is_finite() && acceleration > 0.0 && jerk > 0.0) {
                return Err(SchedulesError::Limit(k));
            }
        }
        Ok(())
    }

    /// The bound with its proof.
    ///
    /// # Errors
    /// A block without a least time, a gate that is missing or empty, a joint without a velocity limit.
    pub fn certificate(&self) -> Result<Certificate, SchedulesError> {
        self.certificate_within(&[])
    }

    /// The bound with its proof where a window of feed loses a time (s) at the gate where it begins and at
    /// the one where it ends, as of [`FeedFloor`].
    ///
    /// # Errors
    /// As [`Self::certificate`]; a time that is missing or below zero, with its gate.
    pub fn certificate_within(&self, seams: &[f64]) -> Result<Certificate, SchedulesError> {
        self.check()?;
        if !seams.is_empty() {
            if seams.len() != self.least.len() + 1 {
                return Err(SchedulesError::Seam(seams.len().min(self.least.len())));
            }
            if let Some(gate) = seams.iter().position(|t| !(t.is_finite() && *t >= 0.0)) {
                return Err(SchedulesError::Seam(gate));
            }
        }
        let mut times = vec![0.0];
        for t in &self.least {
            times.push(times[times.len() - 1] + t);
        }
        let whole = [0, self.least.len()];
        let search = ScheduleSearch { schedules: self, times, seams };
        let velocity = |k| search.total(&search.travels(&[k], whole));
        let windows = search.best(whole);
        let timed: Vec<(Proof, f64)> = windows.into_iter().map(|p| (p.clone(), search.time(&p))).collect();
        Ok(Certificate {
            feed: search.time(&Proof::Feed { gates: whole }),
            velocity: (0..self.joints.len()).map(velocity).collect(),
            bound: timed.iter().map(|(_, t)| t).sum(),
            windows: timed,
        })
    }

    /// The time that a proof proves, s; zero or less where it proves nothing.
    pub fn time(&self, proof: &Proof) -> f64 {
        let distance = |joint: usize, [from, to]: [usize; 2], up: bool| {
            let gates = &self.joints[joint].gates;
            if up { gates[to][0] - gates[from][1] } else { gates[from][0] - gates[to][1] }
        };
        match proof {
            Proof::Feed { gates: [from, to] } => self.least[*from..*to].iter().sum(),
            Proof::Travel { joint, gates, up } => self.joints[*joint].limits.travel_time(distance(*joint, *gates, *up)),
            Proof::Swings { joint, gates, up } => {
                let limits = &self.joints[*joint].limits;
                let last = gates.len().saturating_sub(2);
                let pairs = gates.windows(2).enumerate();
                pairs
                    .map(|(k, pair)| {
                        let way = distance(*joint, [pair[0], pair[1]], *up == k.is_multiple_of(2));
                        if way <= 0.0 {
                            f64::NEG_INFINITY
                        } else if k == 0 || k == last {
                            limits.half_swing_time(way)
                        } else {
                            limits.swing_time(way)
                        }
                    })
                    .sum()
            }
        }
    }
}

/// A corner of a string: gate, and whether it touches its top.
type Touch = (usize, bool);

struct ScheduleSearch<'a> {
    schedules: &'a Schedules,
    /// Time of the feed at each gate, s.
    times: Vec<f64>,
    /// What a window of feed loses at each gate, s; empty for nothing.
    seams: &'a [f64],
}

impl ScheduleSearch<'_> {
    fn seam(&self, gate: usize) -> f64 {
        self.seams.get(gate).copied().unwrap_or(0.0)
    }

    /// The time that a proof proves, with what windows of feed lose.
    fn time(&self, proof: &Proof) -> f64 {
        let time = self.schedules.time(proof);
        match proof {
            Proof::Feed { gates: [from, to] } => (time - self.seam(*from) - self.seam(*to)).max(0.0),
            _ => time,
        }
    }

    fn total(&self, proofs: &[Proof]) -> f64 {
        proofs.iter().map(|p| self.time(p)).sum()
    }

    /// What the feed proves from one gate to another.
    fn feed(&self, from: usize, to: usize) -> f64 {
        if from < to { (self.times[to] - self.times[from] - self.seam(from) - self.seam(to)).max(0.0) } else { 0.0 }
    }

    /// The gate at which a string with a free end leaves its level, from one end of a window: the last gate
    /// with the limit that a later gate contradicts. None where one level passes all gates.
    fn free_end(gates: impl Iterator<Item = (usize, [f64; 2])>) -> Option<Touch> {
        let (mut bottom, mut top) = ((0, f64::NEG_INFINITY), (0, f64::INFINITY));
        for (i, [low, high]) in gates {
            if low > top.1 {
                return Some((top.0, true));
            }
            if high < bottom.1 {
                return Some((bottom.0, false));
            }
            if low >= bottom.1 {
                bottom = (i, low);
            }
            if high <= top.1 {
                top = (i, high);
            }
        }
        None
    }

    /// Corners of the taut string of a joint in a window with both ends free; none where one level passes all
    /// gates.
    fn string(&self, joint: usize, [from, to]: [usize; 2]) -> Vec<Touch> {
        let gates = &self.schedules.joints[joint].gates;
        let ends = (
            Self::free_end((from..=to).map(|i| (i, gates[i]))),
            Self::free_end((from..=to).rev().map(|i| (i, gates[i]))),
        );
        let (Some(first), Some(last)) = ends else { return Vec::new() };
        if first.0 >= last.0 {
            return Vec::new();
        }
        let point = |(i, top): Touch| [self.times[i], gates[i][usize::from(top)]];
        // The string lies between the ends and the demands: an open gate is as wide as all of them.
        let finite = || (first.0..=last.0).flat_map(|i| gates[i]).filter(|v| v.is_finite());
        let (least, most) = (finite().fold(f64::MAX, f64::min), finite().fold(f64::MIN, f64::max));
        let between: Vec<TautGate> = (first.0 + 1..last.0)
            .map(|i| TautGate { s: self.times[i], low: gates[i][0].max(least), high: gates[i][1].min(most) })
            .collect();
        let Ok(string) = taut_string(point(first), &between, point(last)) else { return Vec::new() };
        let inner = string.get(1..string.len().saturating_sub(1)).unwrap_or_default();
        let mut corners = vec![first];
        for p in inner {
            let i = self.times.partition_point(|&t| t < p[0]);
            corners.push((i, p[1] >= gates[i][1]));
        }
        corners.push(last);
        corners
    }

    /// Feed, swings where the string turns back, feed. The swings may begin and end at any gate, where that
    /// proves more.
    fn swings(&self, joint: usize, [from, to]: [usize; 2], string: &[Touch]) -> Option<Vec<Proof>> {
        let gates = &self.schedules.joints[joint].gates;
        let at = |(i, top): Touch| gates[i][usize::from(top)];
        let senses: Vec<f64> = string.windows(2).map(|p| (at(p[1]) - at(p[0])).signum()).collect();
        let mut turns: Vec<usize> = Vec::new();
        let mut sense = 0.0;
        for (k, next) in senses.iter().enumerate().filter(|(k, _)| at(string[k + 1]) != at(string[*k])) {
            if sense != 0.0 && *next != sense {
                turns.push(string[k].0);
            }
            sense = *next;
        }
        let up = senses.iter().zip(string.windows(2)).find(|(_, p)| at(p[1]) != at(p[0])).map(|(s, _)| *s > 0.0)?;
        if turns.is_empty() {
            return None;
        }
        // The turns are a maximum, a minimum, ... where the string begins upwards.
        let is_maximum = |k: usize| up == k.is_multiple_of(2);
        let demand = |k: usize| gates[turns[k]][usize::from(!is_maximum(k))];
        let limits = &self.schedules.joints[joint].limits;
        let ramp = |k: usize, i: usize| {
            let way = if is_maximum(k) { demand(k) - gates[i][1] } else { gates[i][0] - demand(k) };
            if way > 0.0 { limits.half_swing_time(way) } else { f64::NEG_INFINITY }
        };
        // Best first and last gate; with the turns that lie between them.
        let n = turns.len();
        let mut after = vec![0.0; n];
        for k in (0..n - 1).rev() {
            after[k] = after[k + 1] + limits.swing_time((demand(k + 1) - demand(k)).abs());
        }
        // By the first turn: the most that a begin before it or before an earlier one proves, with
        // all later turns.
        let mut begins = vec![(f64::NEG_INFINITY, 0, from); n];
        for i in from..to {
            let k = turns.partition_point(|&t| t <= i);
            if k < n {
                let value = self.feed(from, i) + ramp(k, i) + after[k];
                if value > begins[k].0 {
                    begins[k] = (value, k, i);
                }
            }
        }
        for k in 1..n {
            if begins[k - 1].0 > begins[k].0 {
                begins[k] = begins[k - 1];
            }
        }
        let (mut most, mut first, mut last) = (f64::NEG_INFINITY, begins[0], (0, to));
        for i in from + 1..=to {
            let k = turns.partition_point(|&t| t < i);
            if k > 0 {
                let value = begins[k - 1].0 + self.feed(i, to) + ramp(k - 1, i) - after[k - 1];
                if value > most {
                    (most, first, last) = (value, begins[k - 1], (k - 1, i));
                }
            }
        }
        if !most.is_finite() {
            return None;
        }
        let mut through = vec![first.2];
        through.extend(&turns[first.1..=last.0]);
        through.push(last.1);
        let mut proofs = Vec::new();
        if first.2 > from {
            proofs.push(Proof::Feed { gates: [from, first.2] });
        }
        proofs.push(Proof::Swings { joint, gates: through, up: is_maximum(first.1) });
        if last.1 < to {
            proofs.push(Proof::Feed { gates: [last.1, to] });
        }
        Some(proofs)
    }

    /// The best proofs of a window by halving.
    fn best(&self, window: [usize; 2]) -> Vec<Proof> {
        let joints: Vec<usize> = (0..self.schedules.joints.len()).collect();
        let mut best = self.travels(&joints, window);
        let mut time = self.total(&best);
        let mut turns = false;
        for &joint in &joints {
            let Some(proofs) = self.swings(joint, window, &self.string(joint, window)) else { continue };
            turns = true;
            let own = self.total(&proofs);
            if own > time {
                (best, time) = (proofs, own);
            }
        }
        // Feed and travel have their best row already; halves prove more only where swings are best in some
        // part.
        if turns && window[1] - window[0] > 1 {
            let middle = (window[0] + window[1]) / 2;
            let mut halves = self.best([window[0], middle]);
            halves.extend(self.best([middle, window[1]]));
            if self.total(&halves) > time {
                best = halves;
            }
        }
        best
    }
}
