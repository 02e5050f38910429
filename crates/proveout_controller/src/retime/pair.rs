//! Slacks and multipliers of the rows to both sides of a limit, which share their gradients but for a sign.

/// Slack that a row is given at least at the begin.
const INSIDE: f64 = 0.02;

/// Slacks and multipliers of the rows to both sides of a limit, with their steps.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) slack: [f64; 2],
    /// One over the slack.
    pub(super) over: [f64; 2],
    pub(super) multiplier: [f64; 2],
    pub(super) slack_step: [f64; 2],
    pub(super) multiplier_step: [f64; 2],
}

/// What a pair of rows adds: m / slack in one, the rest in the other of both right sides.
pub(super) struct Forces {
    /// Sum and difference of multiplier over slack.
    pub(super) sum: f64,
    pub(super) difference: f64,
    /// Difference and sum of both parts of the right side.
    pub(super) rest: [f64; 2],
    pub(super) central: [f64; 2],
}

impl Pair {
    /// Not yet begun.
    pub(super) const NEW: Self =
        Self { slack: [0.0; 2], over: [0.0; 2], multiplier: [0.0; 2], slack_step: [0.0; 2], multiplier_step: [0.0; 2] };

    /// Takes no further step.
    pub(super) fn rest_here(&mut self) {
        (self.slack_step, self.multiplier_step) = ([0.0; 2], [0.0; 2]);
    }

    pub(super) fn new(values: [f64; 2], mu: f64) -> Self {
        let slack = values.map(|v| (-v).max(INSIDE));
        let over = slack.map(|s| 1.0 / s);
        Self { slack, over, multiplier: over.map(|o| mu * o), ..Self::NEW }
    }

    /// Goes along the step; `values` are those of the rows behind it.
    #[inline]
    pub(super) fn advance(&mut self, values: [f64; 2], [primal, dual]: [f64; 2], sums: &mut Sums) -> Forces {
        let (mut q, mut f) = ([0.0; 2], [0.0; 2]);
        for i in 0..2 {
            let s = self.slack[i] + primal * self.slack_step[i];
            let l = self.multiplier[i] + dual * self.multiplier_step[i];
            sums.excess = higher(sums.excess, values[i] + s);
            let s = higher(s, -values[i]);
            sums.gap += s * l;
            let over = 1.0 / s;
            q[i] = l * over;
            f[i] = q[i] * (values[i] + s);
            (self.slack[i], self.multiplier[i], self.over[i]) = (s, l, over);
        }
        Forces {
            sum: q[0] + q[1],
            difference: q[0] - q[1],
            rest: [f[0] - f[1], f[0] + f[1]],
            central: [self.over[0] - self.over[1], self.over[0] + self.over[1]],
        }
    }

    /// The step, where the rows change by these amounts.
    #[inline]
    pub(super) fn step(&mut self, values: [f64; 2], changes: [f64; 2], mu: f64, sums: &mut Sums) {
        for i in 0..2 {
            let (s, l, over) = (self.slack[i], self.multiplier[i], self.over[i]);
            let ds = -(values[i] + s) - changes[i];
            let dl = (mu - l * ds) * over - l;
            sums.primal = higher(sums.primal, -ds * over);
            sums.shorten_dual(dl, l);
            (self.slack_step[i], self.multiplier_step[i]) = (ds, dl);
        }
    }

    /// As [`Self::advance`], of the first row alone.
    pub(super) fn forward(&mut self, value: f64, [primal, dual]: [f64; 2], sums: &mut Sums) {
        let s = self.slack[0] + primal * self.slack_step[0];
        let l = self.multiplier[0] + dual * self.multiplier_step[0];
        sums.excess = higher(sums.excess, value + s);
        let s = higher(s, -value);
        sums.gap += s * l;
        (self.slack[0], self.multiplier[0], self.over[0]) = (s, l, 1.0 / s);
    }
}

/// Sums and extremes over all rows.
#[derive(Default)]
pub(super) struct Sums {
    pub(super) gap: f64,
    pub(super) excess: f64,
    /// Highest part of a slack and of a multiplier that a full step takes.
    pub(super) primal: f64,
    pub(super) dual: f64,
}

impl Sums {
    /// Takes note of a multiplier's step; few of them are longer than all before, so that the division is rare.
    #[inline]
    pub(super) fn shorten_dual(&mut self, step: f64, multiplier: f64) {
        if -step > self.dual * multiplier {
            self.dual = -step / multiplier;
        }
    }
}

/// The higher of two numbers; the first where the second is none. One instruction, unlike [`f64::max`].
#[inline]
pub(super) fn higher(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Values of the rows to both sides of an acceleration limit, less the limit.
#[inline]
pub(super) fn acceleration(q: &[f64; 2], [b, b1, _]: [f64; 3]) -> [f64; 2] {
    let a = q[0] * b1 + q[1] * b;
    [a - 1.0, -a - 1.0]
}

/// The same of a jerk limit; `slow` is one over the tempo.
#[inline]
pub(super) fn jerk(q: &[f64; 3], [b, b1, b2]: [f64; 3], slow: f64) -> [f64; 2] {
    let j = q[0] * b2 + q[1] * b1 + q[2] * b;
    [j - slow, -j - slow]
}
