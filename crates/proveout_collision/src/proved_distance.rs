//! A distance that was proved at one place of the joints, and what it says of others.
//!
//! Going from `q0` to `q` joint after joint, each moves a point of one body against the other by at most its
//! weight for a unit (see `motion_weights`), so that
//!
//! ```text
//!    distance(q) >= distance(q0) - sum w_j |q_j - q0_j|        whatever way was gone between
//! ```
//!
//! Only the place counts, not the way: a raster that runs to and fro over a part uses nothing up. A
//! joint that turns about a fixed line is back at the same place after a whole turn, so that no
//! more than half a turn counts.

use std::f64::consts::{PI, TAU};

use proveout_machine::{JointValues, MAX_JOINTS, Machine};

/// A proved distance and where it holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProvedDistance {
    /// Distance, mm; minus infinity where nothing is known.
    pub(crate) distance: f64,
    pub(crate) at: JointValues,
}

impl ProvedDistance {
    pub(crate) const NONE: Self = Self { distance: f64::NEG_INFINITY, at: JointValues::ZERO };

    pub(crate) fn is_known(&self) -> bool {
        self.distance > f64::NEG_INFINITY
    }

    /// Distance that is proved on all of a straight way of the joints, mm.
    pub(crate) fn along(&self, turns: &Turns, weights: &[f64; MAX_JOINTS], way: [&JointValues; 2]) -> f64 {
        self.distance - dot(weights, &turns.farthest_offsets(&self.at, way))
    }
}

/// Pairs that one comparison settles together: where they were last looked at, what was proved there, and
/// what they have needed since.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairGroup {
    pub(crate) reference: JointValues,
    /// The largest of the pairs' weights.
    pub(crate) weights: [f64; MAX_JOINTS],
    /// Least distance that was proved of any pair, and by how much at least it is above what needs to be
    /// known of that pair, mm.
    pub(crate) closest: f64,
    pub(crate) budget: f64,
    /// Most of the budget that any piece has needed, mm.
    pub(crate) roamed: f64,
}

impl PairGroup {
    /// Nothing is known.
    pub(crate) const NONE: Self = Self {
        reference: JointValues::ZERO,
        weights: [0.0; MAX_JOINTS],
        closest: f64::INFINITY,
        budget: f64::NEG_INFINITY,
        roamed: 0.0,
    };

    /// No pair, at a place.
    pub(crate) fn empty_at(reference: JointValues) -> Self {
        Self { reference, budget: f64::INFINITY, ..Self::NONE }
    }

    pub(crate) fn add(&mut self, weights: &[f64; MAX_JOINTS], distance: f64, needed: f64) {
        for (most, w) in self.weights.iter_mut().zip(weights) {
            *most = most.max(*w);
        }
        self.closest = self.closest.min(distance);
        self.budget = self.budget.min(distance - needed);
    }

    /// What a way needs of the budget; the joints may leave it by `off` and points by `slack`.
    pub(crate) fn budget_needed(&self, turns: &Turns, way: [&JointValues; 2], off: &JointValues, slack: f64) -> f64 {
        dot(&self.weights, &turns.farthest_offsets(&self.reference, way)) + slack + dot(&self.weights, &off.0)
    }
}

pub(crate) fn dot(a: &[f64; MAX_JOINTS], b: &[f64; MAX_JOINTS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Joints that are back at the same place after a whole turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turns([bool; MAX_JOINTS]);

impl Turns {
    pub(crate) fn of(machine: &Machine) -> Self {
        let whole = |j: &proveout_machine::Joint| j.is_rotary() && j.turn_shift.is_none();
        Self(std::array::from_fn(|j| machine.joints.get(j).is_some_and(whole)))
    }

    /// Farthest that each joint is from a place on a straight way, mm and radian.
    pub(crate) fn farthest_offsets(&self, place: &JointValues, [from, to]: [&JointValues; 2]) -> [f64; MAX_JOINTS] {
        std::array::from_fn(|j| {
            let (a, b) = (from[j] - place[j], to[j] - place[j]);
            let far = a.abs().max(b.abs());
            if far <= PI || !self.0[j] { far } else { turned(a.min(b), a.max(b)) }
        })
    }
}

/// Largest turn out of a place for joints between `low` and `high` of it, at most half a turn.
fn turned(low: f64, high: f64) -> f64 {
    let whole = (low / TAU).round() * TAU;
    let (low, high) = (low - whole, high - whole);
    if high >= PI { PI } else { low.abs().max(high.abs()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the largest of many places between, each turned back by whole turns.
    #[test]
    fn whole_turns_do_not_count() {
        let near = |x: f64| (x - (x / TAU).round() * TAU).abs();
        let mut beyond = 0;
        for k in 0..4000 {
            let a = 40.0 * (0.37 * f64::from(k)).sin();
            let b = a + [0.3, 3.0, 7.0][k as usize % 3] * (1.1 * f64::from(k)).cos();
            let most = (0..=2000).map(|i| near(a + (b - a) * f64::from(i) / 2000.0)).fold(0.0, f64::max);
            let stated = if a.abs().max(b.abs()) <= PI { a.abs().max(b.abs()) } else { turned(a.min(b), a.max(b)) };
            beyond += usize::from(a.abs() > PI && stated < PI);
            assert!(stated >= most - 1e-12 && stated <= most + 4e-3, "{a} {b}: {stated}, {most}");
        }
        assert!(beyond > 500, "{beyond}");
    }
}
