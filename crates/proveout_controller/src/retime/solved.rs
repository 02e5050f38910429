//! What was found for a region: its grid, the tempo there, and how both change from round to round.

use super::{
    field::Field,
    grid::{LimitExcess, Probe},
    problem::{MARGIN, Problem, RELAXED},
    stages::Stages,
};
use crate::tempo::Tempo;

/// A tempo that gains less than this part of the time is not worth its rounding.
const WORTHWHILE: f64 = 1e-4;
/// Intervals that are solved at once, and those of them that are kept: in long problems a single tight place
/// shortens every step of the whole, and what lies more than some tenths of a second ahead hardly acts. A
/// chunk ends at the first law: the intervals that are not kept are those in which the tempo comes down to
/// it, 0.15 s at b = 10 (with 48 of them one curve in three took 1 to 3 percent longer).
const CHUNK: usize = 512;
const COMMITTED: usize = 384;
/// Intervals that are not divided further where they cannot be solved together.
const FEW: usize = 24;
/// Part of an excess that must be left for a result to be kept that does not yet keep all rows.
const BETTER: f64 = 0.8;
const PLATEAU: f64 = 1.0;
const LEVELING: f64 = 0.25;
/// Intervals to either side of a tightened one that are solved again with it.
const AROUND: usize = 32;
/// Excess over its rows, which lie `MARGIN` below the limits, that a tempo may have at the points of its
/// grid.
const ALLOWED: f64 = 1.002;
/// A spot gets a point of its own farther from the nodes than this part of the interval; time around it in
/// which nodes are tightened, s.
const NEW: f64 = 0.05;
const AT_ONCE: f64 = 0.003;

/// What was found for a region.
pub(super) struct RegionTempo {
    pub(super) from: f64,
    pub(super) to: f64,
    field: Field,
    /// Unknowns of the spline.
    c: Vec<f64>,
    /// The begin has another tempo than the law.
    forced: bool,
    /// Something was found at the begin.
    begun: bool,
    /// Places where samples passed limits since.
    pub(super) spots: Vec<LimitExcess>,
    /// Lowered since, where samples passed limits by little.
    dipped: bool,
    /// How often it was slowed down on plateaus.
    pub(super) levels: usize,
}

impl RegionTempo {
    pub(super) fn new(
        (probe, stages): (&mut Probe<'_>, &mut Stages),
        field: Field,
        [from, to]: [f64; 2],
        start: [f64; 2],
    ) -> Self {
        let n = field.len();
        let mut c = field.whole().even();
        field.whole().set_start(&mut c, start);
        let forced = start != [1.0, 0.0];
        let mut solved = Self { from, to, field, c, forced, begun: false, spots: Vec::new(), dipped: false, levels: 0 };
        let mut begin = 0;
        while begin < n {
            let end = if begin + CHUNK + CHUNK / 4 >= n { n } else { solved.roomy(begin + CHUNK, CHUNK / 8) };
            let good = solved.solve_in_parts(probe, stages, begin, end);
            if begin == 0 {
                solved.begun = good;
            }
            // The tempo found for the last part of a chunk is the start of the next chunk, which
            // includes what follows.
            begin = if end == n { n } else { begin + COMMITTED };
        }
        solved
    }

    /// Solves some intervals, or what can be solved of them: a tight place does not keep the others as slow
    /// as they were. True where something was found at their begin.
    fn solve_in_parts(&mut self, probe: &mut Probe<'_>, stages: &mut Stages, begin: usize, end: usize) -> bool {
        if self.solve(probe, stages, begin, end) {
            return true;
        }
        let n = end - begin;
        if n <= FEW {
            return false;
        }
        // Halves that overlap by a quarter: where they meet, the second one moves what the first has found.
        let good = self.solve_in_parts(probe, stages, begin, self.roomy(end - 3 * n / 8, n / 16));
        self.solve_in_parts(probe, stages, begin + 3 * n / 8, end);
        good
    }

    /// The knot no farther than `beside` from another where the given tempo leaves the most room
    /// below the limits. A first law exceeds them in places, and the values given at the end of a
    /// search must be feasible.
    fn roomy(&self, near: usize, beside: usize) -> usize {
        let [from, to] = [near - beside, near + beside + 1];
        let problem = self.field.between([from - 1, to]);
        let mut used = vec![0.0_f64; to + 1 - from];
        for (k, part) in problem.all_used(&self.c[2 * (from - 1)..2 * to + 2]) {
            used[k] = used[k].max(part);
        }
        let both = |k: usize| used[k - from].max(used[k + 1 - from]);
        (from..to)
            .min_by(|a, b| both(*a).total_cmp(&both(*b)).then(a.abs_diff(near).cmp(&b.abs_diff(near))))
            .unwrap_or(near)
    }

    /// Solves some intervals between what is given at their ends; keeps what was there where that does not
    /// succeed.
    fn solve(&mut self, probe: &mut Probe<'_>, stages: &mut Stages, begin: usize, end: usize) -> bool {
        let mut problem = self.field.between([begin, end]);
        let before = &self.c[2 * begin..2 * end + 2];
        let mut c = before.to_vec();
        problem.seed_tempo(&mut c);
        let good = stages.run(probe, &mut problem, &mut c);
        let after = worst(&problem, &c, &stages.relaxed);
        let good = good && after <= ALLOWED;
        // Better than before is something, too: the next round goes on from there.
        if good || after - 1.0 < BETTER * (worst(&problem, before, &[]) - 1.0) {
            self.c[2 * begin..2 * end + 2].copy_from_slice(&c);
        }
        self.field.put_back(begin, problem);
        good
    }

    /// Places a point at a spot, or tightens the points around it where the rows do not see the excess there.
    fn tighten(&mut self, probe: &mut Probe<'_>, spot: &LimitExcess) -> Option<usize> {
        let begins = &self.field.whole().begins;
        let k = begins[..self.field.len()].partition_point(|b| *b <= spot.at).saturating_sub(1);
        let (mut p, c) = (self.field.between([k, k + 1]), &self.c[2 * k..2 * k + 4]);
        let tau = (spot.at - p.begins[0]) / p.lengths[0];
        if p.nodes.is_empty() {
            return None;
        }
        let behind = p.nodes.partition_point(|n| n.tau <= tau).max(1) - 1;
        let next = (behind + 1).min(p.nodes.len() - 1);
        let near = if tau - p.nodes[behind].tau < p.nodes[next].tau - tau { behind } else { next };
        let mut seen = p.used(near, c);
        if (p.nodes[near].tau - tau).abs() > NEW {
            let used = p.used.clone();
            p.insert(&[(behind, tau)], |cell, at| probe.rows_of(&used, cell, at));
            seen = p.used(behind + 1, c);
        }
        if seen < 1.0 + MARGIN + 0.5 * spot.excess {
            for at in 0..p.nodes.len() {
                if (p.nodes[at].tau - tau).abs() * p.lengths[0] < AT_ONCE {
                    p.tighten(at, 1.0 + spot.excess);
                }
            }
        }
        self.field.put_back(k, p);
        Some(k)
    }

    /// Solves again around the intervals whose rows were tightened.
    pub(super) fn repaired(mut self, probe: &mut Probe<'_>, stages: &mut Stages) -> Self {
        let spots = std::mem::take(&mut self.spots);
        let mut touched: Vec<usize> = spots.iter().filter_map(|s| self.tighten(probe, s)).collect();
        touched.sort_unstable();
        touched.dedup();
        let n = self.field.whole().lengths.len();
        let mut i = 0;
        while i < touched.len() {
            let begin = touched[i].saturating_sub(AROUND);
            let mut last = touched[i];
            while i < touched.len() && touched[i] < last + AROUND && touched[i] < begin + CHUNK {
                last = touched[i];
                i += 1;
            }
            let mut good = self.solve(probe, stages, begin, (last + AROUND + 1).min(n));
            if !good {
                // Where the acceleration is at its limit for long, the speed before must change too.
                good = self.solve(probe, stages, begin.saturating_sub(3 * AROUND), (last + 4 * AROUND + 1).min(n));
            }
            if begin == 0 {
                self.begun |= good;
            }
        }
        self
    }

    /// Lowers b around the spots, by a factor that leaves no kink and ends with zero slope at both sides:
    ///
    /// ```text
    ///   b -> b (1 - e w),   w = cos^2(pi x / 2 W) for |x| < W,   W = 3.5 sqrt(v/J)
    /// ```
    ///
    /// Acceleration falls with e, jerk with 3/2 e; what the slope of the factor adds to the jerk, e v w''/4,
    /// is below a third of e J. A dip always exists, where rows that are tightened may contradict each other.
    pub(super) fn lower_tempo_at(&mut self, spots: &[&LimitExcess]) {
        let n = self.field.whole().lengths.len();
        let mut factors = vec![[1.0, 0.0]; n + 1];
        for spot in spots {
            // Given ends stay as they are.
            let room = [spot.at - self.from, self.to - spot.at];
            let fixed = self.field.whole().fixed;
            let width = [0, 1].map(|side| if fixed[side] { spot.width.min(room[side]) } else { spot.width });
            let mut at = self.from;
            for k in 0..=n {
                let x = at - spot.at;
                let w = width[usize::from(x > 0.0)];
                if x.abs() < w {
                    let (sin, cos) = (std::f64::consts::FRAC_PI_2 * x / w).sin_cos();
                    let factor = 1.0 - spot.excess * cos * cos;
                    if factor < factors[k][0] {
                        factors[k] = [factor, spot.excess * std::f64::consts::PI * sin * cos / w];
                    }
                } else if x > w {
                    break;
                }
                at += self.field.whole().lengths.get(k).copied().unwrap_or(0.0);
            }
        }
        self.scale(&factors);
    }

    /// Lowers b on long plateaus around the spots: acceleration falls with their excess, jerk with 3/2 of it.
    ///
    /// ```text
    ///            ____________       1 - e
    ///   ___.-''  |    x     |  ''-.___     given ends stay
    ///       0.25 s   1 s   1 s  0.25 s
    /// ```
    pub(super) fn level(&mut self, spots: &[&LimitExcess]) {
        let n = self.field.whole().lengths.len();
        let ramp = |x: f64, long: f64| {
            let (sin, cos) = (std::f64::consts::FRAC_PI_2 * (x / long).clamp(0.0, 1.0)).sin_cos();
            [sin * sin, if x < long { std::f64::consts::PI * sin * cos / long } else { 0.0 }]
        };
        let long = LEVELING.min(0.25 * (self.to - self.from));
        let mut factors = Vec::with_capacity(n + 1);
        let mut at = self.from;
        for k in 0..=n {
            let mut end = [1.0, 0.0];
            for (side, distance, sense) in [(0, at - self.from, 1.0), (1, self.to - at, -1.0)] {
                if self.field.whole().fixed[side] && distance < long {
                    let [part, slope] = ramp(distance, long);
                    end = [part, sense * slope];
                }
            }
            let mut lowered = [0.0, 0.0];
            for spot in spots {
                let x = at - spot.at;
                let [part, slope] = ramp(PLATEAU + LEVELING - x.abs(), LEVELING);
                if spot.excess * part > lowered[0] {
                    lowered = [spot.excess * part, -spot.excess * slope * x.signum()];
                }
            }
            factors.push([1.0 - lowered[0] * end[0], -(lowered[1] * end[0] + lowered[0] * end[1])]);
            at += self.field.whole().lengths.get(k).copied().unwrap_or(0.0);
        }
        self.scale(&factors);
        self.levels += 1;
    }

    /// Multiplies b by a function of time, given by value and slope at the knots.
    fn scale(&mut self, factors: &[[f64; 2]]) {
        for (k, [factor, slope]) in factors.iter().copied().enumerate() {
            let b = self.c[2 * k];
            self.c[2 * k] = b * factor;
            self.c[2 * k + 1] = self.c[2 * k + 1] * factor + b * slope * self.field.whole().scale;
        }
        self.dipped = true;
    }

    /// The tempos; none where those of the law are kept.
    pub(super) fn tempos(&self) -> Option<Vec<Tempo>> {
        if self.forced && !self.begun {
            return None;
        }
        let n = self.field.whole().lengths.len();
        let mut tempos = Vec::with_capacity(n);
        let (mut p, mut time) = (self.from, 0.0);
        for k in 0..n {
            let end = if k + 1 == n { self.to } else { p + self.field.whole().lengths[k] };
            let tempo = Tempo::new(p, end - p, self.field.whole().polynomial(&self.c, k), time);
            if !tempo.is_sound() {
                return None;
            }
            time += tempo.duration;
            tempos.push(tempo);
            p = end;
        }
        let own = self.to - self.from;
        let worthwhile = time < own * (1.0 - WORTHWHILE) || self.forced || self.dipped || {
            let whole = self.field.between([0, n]);
            let even = whole.even();
            whole.all_used(&even).any(|(_, used)| used > 1.0003 * (1.0 + MARGIN))
        };
        (worthwhile && time.is_finite()).then_some(tempos)
    }
}

/// Highest part of the limits, less what is allowed next to given unknowns and in `relaxed` intervals.
fn worst(problem: &Problem, c: &[f64], relaxed: &[usize]) -> f64 {
    if !c.iter().all(|x| x.is_finite()) {
        return f64::INFINITY;
    }
    let last = problem.lengths.len();
    let part = |(k, used): (usize, f64)| {
        let near = problem.fixed[0] && k == 0 || problem.fixed[1] && k + 1 == last || relaxed.contains(&k);
        used * if near { 1.0 - RELAXED } else { 1.0 }
    };
    problem.all_used(c).map(part).fold(0.0, f64::max)
}
