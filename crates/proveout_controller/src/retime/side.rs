//! Slack and multiplier of a row, of eight nodes at once: one side of a limit.

use super::lanes::Lanes;

/// Part of the way to the border of a slack or multiplier that a step may go: what takes less of them does
/// not shorten it.
pub(super) const TO_BORDER: f64 = 0.99;
/// How far below the highest quotient another is no higher, whatever their rounding.
const BESIDE: f64 = 1.0 - 1e-9;

/// Slack that a row is given at least at the begin of a search that nothing is known of, where rows are
/// passed by a multiple: from small slacks the first dozen of steps go some percent of their way.
pub(super) const AT_FIRST: f64 = 0.3;
/// The same of a row that joins a search that goes on.
pub(super) const INSIDE: f64 = 0.02;

/// Slacks and multipliers of a row with their steps.
#[derive(Clone, Copy)]
pub(super) struct RowSlacks {
    pub(super) slack: Lanes,
    /// One over the slack.
    pub(super) over: Lanes,
    pub(super) multiplier: Lanes,
    slack_step: Lanes,
}

/// How far a search goes along its last step: parts of the step of tempo and slacks and of that of the
/// multipliers, and the product of slack and multiplier that it aimed at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SolverStep {
    pub(super) primal: f64,
    pub(super) dual: f64,
    pub(super) aim: f64,
}

impl RowSlacks {
    /// Begins as a new row, with a mean product of slack and multiplier and no less than some slack.
    pub(super) fn begun(value: Lanes, [mu, least]: [f64; 2]) -> Self {
        let slack = (-value).each(|slack| slack.max(least));
        Self { slack, over: slack.inverse(), multiplier: slack.each(|slack| mu / slack), slack_step: Lanes::ZERO }
    }

    /// Goes on with slack and multiplier of a node that an earlier search has left.
    pub(super) fn go_on(&mut self, lane: usize, [slack, multiplier]: [f64; 2]) {
        (self.slack.0[lane], self.over.0[lane], self.multiplier.0[lane]) = (slack, 1.0 / slack, multiplier);
    }

    /// Slack and multiplier of a node.
    pub(super) fn of_lane(&self, lane: usize) -> [f64; 2] {
        [self.slack.0[lane], self.multiplier.0[lane]]
    }

    /// Step of the multiplier, where the slack changes by this amount. It is taken twice rather than kept:
    /// rows are many, and what they cost is the way to memory.
    #[inline(always)]
    fn multiplier_step(&self, slack_step: Lanes, aim: f64) -> Lanes {
        (Lanes::all(aim) - self.multiplier * slack_step) * self.over - self.multiplier
    }

    /// Takes the step; `value` is the row's value after it. Returns multiplier over slack, and that
    /// times the sum of value and slack.
    #[inline(always)]
    pub(super) fn advance(&mut self, value: Lanes, going: SolverStep, sums: &mut RowSums) -> (Lanes, Lanes) {
        let s = self.slack + self.slack_step * going.primal;
        let l = self.multiplier + self.multiplier_step(self.slack_step, going.aim) * going.dual;
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
    pub(super) fn step(&mut self, value: Lanes, change: Lanes, aim: f64, sums: &mut RowSums) {
        let ds = -(value + self.slack) - change;
        let (dl, l) = (self.multiplier_step(ds, aim), self.multiplier);
        sums.primal = sums.primal.higher(-ds * self.over);
        // Most multipliers fall by less than counts, or than one before them: their quotients are not asked
        // for.
        if dl.any(l, |step, multiplier| -step > sums.bound * multiplier) {
            sums.dual = sums.dual.higher(-dl.with(l, |step, multiplier| step / multiplier));
            sums.bound = sums.bound.max(BESIDE * sums.dual.highest());
        }
        self.slack_step = ds;
    }
}

/// Sums and extremes over all rows, lane by lane.
pub(super) struct RowSums {
    pub(super) gap: Lanes,
    pub(super) excess: Lanes,
    /// Highest part of a slack and of a multiplier that a full step takes.
    pub(super) primal: Lanes,
    pub(super) dual: Lanes,
    /// Part of a multiplier up to which quotients are not taken: a little below what counts and below the
    /// highest so far.
    bound: f64,
}

impl RowSums {
    pub(super) const ZERO: Self = Self {
        gap: Lanes::ZERO,
        excess: Lanes::ZERO,
        primal: Lanes::ZERO,
        dual: Lanes::ZERO,
        bound: BESIDE * TO_BORDER,
    };
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
