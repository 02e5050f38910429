//! Slacks and multipliers of the rows to both sides of a limit, which share their gradients but for a sign; of eight nodes at once.

use super::lanes::Lanes;

/// Slack that a row is given at least at the begin.
const INSIDE: f64 = 0.02;

/// Slacks and multipliers of the rows to both sides of a limit, with their steps.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) slack: [Lanes; 2],
    /// One over the slack.
    pub(super) over: [Lanes; 2],
    pub(super) multiplier: [Lanes; 2],
    pub(super) slack_step: [Lanes; 2],
    pub(super) multiplier_step: [Lanes; 2],
}

/// What a pair of rows adds: m / slack in one, the rest in the other of both right sides.
pub(super) struct Forces {
    /// Sum and difference of multiplier over slack.
    pub(super) sum: Lanes,
    pub(super) difference: Lanes,
    /// Difference and sum of both parts of the right side.
    pub(super) rest: [Lanes; 2],
    pub(super) central: [Lanes; 2],
}

impl Pair {
    pub(super) const REST: Self = Self {
        slack: [Lanes::ZERO; 2],
        over: [Lanes::ZERO; 2],
        multiplier: [Lanes::ZERO; 2],
        slack_step: [Lanes::ZERO; 2],
        multiplier_step: [Lanes::ZERO; 2],
    };

    /// Begins with slacks and multipliers that were left by an earlier search where there were any, as a new pair elsewhere.
    pub(super) fn begun(values: [Lanes; 2], mu: f64, kept: impl Fn(usize) -> Option<[f64; 4]>) -> Self {
        let mut pair = Self::REST;
        for lane in 0..super::lanes::LANES {
            let was = kept(lane);
            for i in 0..2 {
                let (slack, multiplier) = match was {
                    Some(k) => (k[i], k[2 + i]),
                    None => {
                        let slack = (-values[i].0[lane]).max(INSIDE);
                        (slack, mu / slack)
                    }
                };
                pair.slack[i].0[lane] = slack;
                pair.over[i].0[lane] = 1.0 / slack;
                pair.multiplier[i].0[lane] = multiplier;
            }
        }
        pair
    }

    /// Slacks and multipliers of a node.
    pub(super) fn of_lane(&self, lane: usize) -> [f64; 4] {
        [self.slack[0].0[lane], self.slack[1].0[lane], self.multiplier[0].0[lane], self.multiplier[1].0[lane]]
    }

    /// Goes along the step; `values` are those of the rows behind it.
    #[inline(always)]
    pub(super) fn advance(&mut self, values: [Lanes; 2], steps: [f64; 2], sums: &mut Sums) -> Forces {
        let (mut q, mut f) = ([Lanes::ZERO; 2], [Lanes::ZERO; 2]);
        for i in 0..2 {
            (q[i], f[i]) = self.advance_one(i, values[i], steps, sums);
        }
        Forces {
            sum: q[0] + q[1],
            difference: q[0] - q[1],
            rest: [f[0] - f[1], f[0] + f[1]],
            central: [self.over[0] - self.over[1], self.over[0] + self.over[1]],
        }
    }

    /// The same of one of both rows: multiplier over slack, and that times value and slack.
    #[inline(always)]
    pub(super) fn advance_one(
        &mut self,
        i: usize,
        value: Lanes,
        [primal, dual]: [f64; 2],
        sums: &mut Sums,
    ) -> (Lanes, Lanes) {
        let s = self.slack[i] + self.slack_step[i] * primal;
        let l = self.multiplier[i] + self.multiplier_step[i] * dual;
        sums.excess = sums.excess.higher(value + s);
        let s = s.higher(-value);
        sums.gap += s * l;
        let over = s.inverse();
        let q = l * over;
        (self.slack[i], self.multiplier[i], self.over[i]) = (s, l, over);
        (q, q * (value + s))
    }

    /// The step, where the rows change by these amounts.
    #[inline(always)]
    pub(super) fn step(&mut self, values: [Lanes; 2], changes: [Lanes; 2], mu: f64, sums: &mut Sums) {
        for i in 0..2 {
            self.step_one(i, values[i], changes[i], mu, sums);
        }
    }

    /// The same of one of both rows.
    #[inline(always)]
    pub(super) fn step_one(&mut self, i: usize, value: Lanes, change: Lanes, mu: f64, sums: &mut Sums) {
        let (s, l, over) = (self.slack[i], self.multiplier[i], self.over[i]);
        let ds = -(value + s) - change;
        let dl = (Lanes::all(mu) - l * ds) * over - l;
        sums.primal = sums.primal.higher(-ds * over);
        sums.shorten_dual(dl, l);
        (self.slack_step[i], self.multiplier_step[i]) = (ds, dl);
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

    /// Takes note of a multiplier's step; few of them are longer than all before, so that the division is rare.
    #[inline(always)]
    fn shorten_dual(&mut self, step: Lanes, multiplier: Lanes) {
        let longer = (-step - self.dual * multiplier).higher(Lanes::ZERO);
        if longer.0.iter().fold(0.0, |sum, x| sum + x) > 0.0 {
            let part = -step.with(multiplier, |s, l| s / l);
            self.dual = self.dual.higher(part);
        }
    }
}

/// Values of the rows to both sides of an acceleration limit, less the limit.
#[inline(always)]
pub(super) fn acceleration(q: &[Lanes; 2], [b, b1, _]: [Lanes; 3]) -> [Lanes; 2] {
    let a = q[0] * b1 + q[1] * b;
    let one = Lanes::all(1.0);
    [a - one, -a - one]
}

/// The same of a jerk limit; `slow` is one over the tempo.
#[inline(always)]
pub(super) fn jerk(q: &[Lanes; 3], [b, b1, b2]: [Lanes; 3], slow: Lanes) -> [Lanes; 2] {
    let j = q[0] * b2 + q[1] * b1 + q[2] * b;
    [j - slow, -j - slow]
}
