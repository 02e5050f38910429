//! Slack and multiplier of a row, of eight nodes at once: one side of a limit.

use super::lanes::{LANES, Lanes};

/// Slack that a row is given at least at the begin.
const INSIDE: f64 = 0.02;

/// Slacks and multipliers of a row with their steps.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) slack: Lanes,
    /// One over the slack.
    pub(super) over: Lanes,
    pub(super) multiplier: Lanes,
    slack_step: Lanes,
    multiplier_step: Lanes,
}

impl Side {
    /// Begins with slacks and multipliers that were left by an earlier search where there were any, as a new row elsewhere.
    pub(super) fn begun(value: Lanes, mu: f64, kept: impl Fn(usize) -> Option<[f64; 2]>) -> Self {
        let (mut s, mut l) = (Lanes::ZERO, Lanes::ZERO);
        for lane in 0..LANES {
            let [slack, multiplier] = kept(lane).unwrap_or_else(|| {
                let slack = (-value.0[lane]).max(INSIDE);
                [slack, mu / slack]
            });
            (s.0[lane], l.0[lane]) = (slack, multiplier);
        }
        let (slack_step, multiplier_step) = (Lanes::ZERO, Lanes::ZERO);
        Self { slack: s, over: s.inverse(), multiplier: l, slack_step, multiplier_step }
    }

    /// Slack and multiplier of a node.
    pub(super) fn of_lane(&self, lane: usize) -> [f64; 2] {
        [self.slack.0[lane], self.multiplier.0[lane]]
    }

    /// Goes along the step; `value` is that of the row behind it. Multiplier over slack, and that times value and slack.
    #[inline(always)]
    pub(super) fn advance(&mut self, value: Lanes, [primal, dual]: [f64; 2], sums: &mut Sums) -> (Lanes, Lanes) {
        let s = self.slack + self.slack_step * primal;
        let l = self.multiplier + self.multiplier_step * dual;
        sums.excess = sums.excess.higher(value + s);
        let s = s.higher(-value);
        sums.gap += s * l;
        let over = s.inverse();
        let q = l * over;
        (self.slack, self.multiplier, self.over) = (s, l, over);
        (q, q * (value + s))
    }

    /// The step, where the row changes by this amount.
    #[inline(always)]
    pub(super) fn step(&mut self, value: Lanes, change: Lanes, mu: f64, sums: &mut Sums) {
        let (s, l, over) = (self.slack, self.multiplier, self.over);
        let ds = -(value + s) - change;
        let dl = (Lanes::all(mu) - l * ds) * over - l;
        sums.primal = sums.primal.higher(-ds * over);
        sums.dual = sums.dual.higher(-dl.with(l, |step, multiplier| step / multiplier));
        (self.slack_step, self.multiplier_step) = (ds, dl);
    }
}

/// Sums and extremes over all rows, lane by lane.
pub(super) struct Sums {
    pub(super) gap: Lanes,
    pub(super) excess: Lanes,
    /// Highest part of a slack and of a multiplier that a full step takes.
    pub(super) primal: Lanes,
    pub(super) dual: Lanes,
}

impl Sums {
    pub(super) const ZERO: Self =
        Self { gap: Lanes::ZERO, excess: Lanes::ZERO, primal: Lanes::ZERO, dual: Lanes::ZERO };
}

/// Value of a row of speed or acceleration.
#[inline(always)]
pub(super) fn even(q: &[Lanes; 2], [b, b1, _]: [Lanes; 3]) -> Lanes {
    q[0] * b1 + q[1] * b
}

/// The same of a row of jerk, over the tempo.
#[inline(always)]
pub(super) fn jerk(q: &[Lanes; 3], [b, b1, b2]: [Lanes; 3]) -> Lanes {
    q[0] * b2 + q[1] * b1 + q[2] * b
}
