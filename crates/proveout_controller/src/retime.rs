//! Runs a first law faster where the joints allow it.
//!
//! The chains of `plan.rs` know constants V, A and J a cell and have no acceleration at their anchors: a law that keeps all limits
//! and wastes time at corners and in curves. Its own time p is a parameter in which the joints q(p) have finite derivatives even
//! at rests. The law is run with a *tempo* dp/dt = sqrt(b(p)) (`tempo.rs`); the chain rule gives
//!
//! ```text
//!   q. = q' sqrt(b)      q.. = q' b'/2 + q'' b      q... = sqrt(b) (q' b''/2 + 3/2 q'' b' + q''' b)      T = integral dp / sqrt(b)
//! ```
//!
//! (Verscheure et al. 2009 for the first two, over the path instead of a time). b = 1 is the law as it is.
//!
//! ```text
//!   b |      __            __          b cubic between knots, slope continuous: acceleration is continuous,
//!     |  ___/  \__      __/  \___        jerk bounded and free to jump at knots
//!   1 |_/         \____/         \__    b = 1 where the law runs at feed or joint speed already (held)
//!     +--.--.--.--.----.--.--.--.--.--> p
//!      region 1   held     region 2
//! ```
//!
//! 1. *Regions* (`grid.rs`): all but the stretches that run at their highest speed for longer than a few intervals. They do not act
//!    on each other. A program that runs at its feed costs nothing here.
//! 2. *Grid*: knots at borders of phases and cells and between them, closer where the speed is low; limits at two to five points an
//!    interval, on both sides of every jump.
//! 3. *Solution* (`solver.rs`): an interior point method, chunk by chunk with an overlap.
//! 4. *Samples*: the law is measured at the control samples. Where one passes a limit between the points of the grid, the rows of its
//!    interval are tightened and the surroundings solved again, or, when little is left, the tempo is lowered there (`dip`).
//! 5. *Last resort* (`settle`): what the rounds leave is taken away by plateaus of some percent, and where more is left the first law
//!    is kept for some hundredths of a second; a law from rest to rest that still passes a limit runs slower as a whole. A tempo that would come near to rest is refused (`Tempo::is_sound`).
//!
//! *Windows.* A part of a run is committed up to a node half a second before the last known one. The next part begins with the tempo
//! and its slope there; the tempo found for what lies behind is kept, should that begin not be solved again.
//!
//! *Limits of the method.* A local optimum; knots do not move to where the jerk switches. Against an independent optimum it loses up
//! to 2 percent of the time (`tests/optimum.rs`).

mod grid;
mod solver;

pub(crate) use self::grid::{Spot, jerk_along};
use self::solver::{MARGIN, Problem};
use crate::{
    path::{Frame, Path},
    profile::Law,
    tempo::Tempo,
};

/// How a law begins: square of the tempo and its slope, and a tempo that is known to be possible from there on.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) square: [f64; 2],
    pub(crate) tail: Vec<Tempo>,
}

impl Default for Entry {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl Entry {
    /// The law goes on with these tempos.
    pub(crate) fn new(tail: Vec<Tempo>) -> Self {
        Self { square: tail.first().map_or([1.0, 0.0], |t| [t.square[0], t.square[1]]), tail }
    }

    fn is_even(&self) -> bool {
        self.square == [1.0, 0.0]
    }
}

/// A tempo that gains less than this part of the time is not worth its rounding.
const WORTHWHILE: f64 = 1e-4;
/// Intervals that are solved at once, and those of them that are kept: in long problems a single tight place shortens every step
/// of the whole, and what lies more than some tenths of a second ahead hardly acts.
const CHUNK: usize = 192;
const COMMITTED: usize = 128;
/// Part of an excess that must be left for a result to be kept that does not yet keep all rows.
const BETTER: f64 = 0.8;
/// Excess of b up to which a region is slowed down on plateaus, how often, the half length of a plateau and of its ramps, s.
const LEVELED: f64 = 0.05;
const LEVELS: usize = 6;
const PLATEAU: f64 = 1.0;
const LEVELING: f64 = 0.25;
/// Time of the first law to either side of a sample that could not be brought below its limit over which the first law is kept, s.
const AS_IT_WAS: f64 = 0.03;
/// Intervals to either side of a tightened one that are solved again with it.
const AROUND: usize = 32;
/// Excess over its rows, which lie `MARGIN` below the limits, that a tempo may have at the points of its grid.
const ALLOWED: f64 = 1.002;

/// What is to be run faster: a first law over the first `cells` cells of a path. `rest` tells whether it begins and ends at
/// rest; where it does not, it begins as `entry` says and ends with its own tempo.
pub(crate) struct Course<'a> {
    pub(crate) path: &'a Path,
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) law: &'a Law,
    pub(crate) cells: usize,
    pub(crate) entry: &'a Entry,
    pub(crate) rest: [bool; 2],
}

/// What came of an attempt to settle what could not be mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Settled {
    /// Regions run slower.
    Slower,
    /// The first law is kept in places.
    AsItWas,
    /// There was nothing to change.
    Nothing,
}

/// Results of earlier rounds, and the places where samples passed limits outside of all regions.
#[derive(Default)]
pub(crate) struct Rounds {
    known: Vec<Solved>,
    /// In the order of time.
    spots: Vec<Spot>,
    /// Stretches of time that run as in the first law, rising.
    cuts: Vec<[f64; 2]>,
}

impl Rounds {
    /// Tightens the rows at these places, to be solved again; with `dips` lowers the tempo there at once, which always
    /// succeeds.
    pub(crate) fn slow_down(&mut self, spots: &[Spot], dips: bool) {
        for known in &mut self.known {
            let own: Vec<&Spot> = spots.iter().filter(|s| s.at >= known.from && s.at <= known.to).collect();
            if dips && !own.is_empty() {
                known.dip(&own);
            } else {
                own.iter().for_each(|s| known.tighten(s));
            }
        }
        for spot in spots {
            if !self.known.iter().any(|k| spot.at >= k.from && spot.at <= k.to) {
                let at = self.spots.partition_point(|s| s.at < spot.at);
                self.spots.insert(at, *spot);
            }
        }
    }

    /// Settles what rounds of [`Self::slow_down`] could not mend: regions that pass limits by little run slower on plateaus, and
    /// the law is left as it was around other places.
    pub(crate) fn settle(&mut self, spots: &[Spot]) -> Settled {
        let mut settled = Settled::Nothing;
        let mut times: Vec<f64> = Vec::new();
        for known in &mut self.known {
            let own: Vec<&Spot> = spots.iter().filter(|s| s.at >= known.from && s.at <= known.to).collect();
            if own.is_empty() {
                continue;
            }
            let far = own.iter().any(|s| s.excess > LEVELED);
            if !far && known.levels < LEVELS {
                known.level(&own);
                settled = Settled::Slower;
            } else {
                times.extend(own.iter().filter(|s| !far || s.excess > LEVELED).map(|s| s.at));
            }
        }
        for t in times {
            if !self.cuts.iter().any(|c| (c[0]..=c[1]).contains(&t)) {
                settled = Settled::AsItWas;
                self.cut(t - AS_IT_WAS, t + AS_IT_WAS);
            }
        }
        settled
    }

    /// Adds a cut; those that overlap become one.
    fn cut(&mut self, mut from: f64, mut to: f64) {
        self.cuts.retain(|c| {
            let apart = c[1] < from || c[0] > to;
            if !apart {
                (from, to) = (from.min(c[0]), to.max(c[1]));
            }
            apart
        });
        let at = self.cuts.partition_point(|c| c[0] < from);
        self.cuts.insert(at, [from, to]);
    }

    /// The law with the fastest tempo that is found.
    pub(crate) fn retimed(&mut self, course: &Course<'_>) -> Law {
        let Course { path, frame, law, cells, entry, rest } = course;
        let moving = !entry.is_even();
        let mut found: Vec<Vec<Tempo>> = Vec::new();
        // What must be kept of the tail, where the begin cannot be solved.
        let mut kept_until = 0.0;
        let mut before = std::mem::take(&mut self.known);
        let tail_end = entry.tail.last().map_or(0.0, |t| t.begin + t.length);
        if moving && self.cuts.first().is_some_and(|c| c[0] < tail_end) {
            self.cut(0.0, tail_end);
            found.push(entry.tail.clone());
        }
        let regions = grid::regions(path, frame, law, *cells, moving, &self.spots);
        for region in regions.iter().flat_map(|r| r.without(&self.cuts)) {
            let at_begin = region.from <= 0.0;
            let same = before.iter().position(|k| k.from == region.from && k.to == region.to);
            let known = match same {
                Some(i) => before.swap_remove(i).repaired(),
                None => {
                    let fixed = [!(at_begin && rest[0]), !(region.to >= law.planned && rest[1])];
                    let start = if at_begin { entry.square } else { [1.0, 0.0] };
                    let problem = grid::problem(path, frame, law, &region, fixed, &self.spots);
                    Solved::new(problem, [region.from, region.to], start)
                }
            };
            if region.from >= kept_until {
                match known.tempos() {
                    Some(tempos) => found.push(tempos),
                    None if at_begin && moving => {
                        found.push(entry.tail.clone());
                        kept_until = entry.tail.last().map_or(0.0, |t| t.begin + t.length);
                    }
                    None => {}
                }
            }
            self.known.push(known);
        }
        let mut law = (*law).clone();
        if !found.is_empty() {
            let tempos = spliced(found, law.planned);
            law.set_tempos(tempos);
        }
        law
    }
}

/// The tempos of regions behind each other, with even ones in the gaps up to `end`.
fn spliced(regions: Vec<Vec<Tempo>>, end: f64) -> Vec<Tempo> {
    let mut tempos: Vec<Tempo> = Vec::new();
    let (mut p, mut time) = (0.0, 0.0);
    for region in regions {
        let Some(first) = region.first() else { continue };
        if first.begin > p {
            tempos.push(Tempo::even(p, first.begin - p, time));
            time += first.begin - p;
        }
        for tempo in region {
            tempos.push(Tempo { time, ..tempo });
            time += tempo.duration;
            p = tempo.begin + tempo.length;
        }
    }
    if end > p {
        tempos.push(Tempo::even(p, end - p, time));
    }
    tempos
}

/// What was found for a region.
struct Solved {
    from: f64,
    to: f64,
    problem: Problem,
    /// Unknowns of the spline.
    c: Vec<f64>,
    /// The begin has another tempo than the law.
    forced: bool,
    /// Something was found at the begin.
    begun: bool,
    /// Intervals whose rows were tightened since.
    touched: Vec<usize>,
    /// Lowered since, where samples passed limits by little.
    dipped: bool,
    /// How often it was slowed down on plateaus.
    levels: usize,
}

impl Solved {
    fn new(problem: Problem, [from, to]: [f64; 2], start: [f64; 2]) -> Self {
        let n = problem.lengths.len();
        let mut c = problem.even();
        problem.set_start(&mut c, start);
        let forced = start != [1.0, 0.0];
        let mut solved =
            Self { from, to, problem, c, forced, begun: false, touched: Vec::new(), dipped: false, levels: 0 };
        let mut begin = 0;
        while begin < n {
            let end = if begin + CHUNK + CHUNK / 4 >= n { n } else { begin + CHUNK };
            let good = solved.solve(begin, end);
            if begin == 0 {
                solved.begun = good;
            }
            // The tempo found for the last part of a chunk is the start of the next one, which knows what comes behind it.
            begin = if end == n { n } else { begin + COMMITTED };
        }
        solved
    }

    /// Solves some intervals between what is given at their ends; keeps what was there where that does not succeed.
    fn solve(&mut self, begin: usize, end: usize) -> bool {
        let part = self.problem.part(begin, end);
        let own = 2 * begin..2 * end + 2;
        let mut found = self.c[own.clone()].to_vec();
        let worst = |c: &[f64]| (0..part.nodes.len()).map(|at| part.used(at, c)).fold(0.0, f64::max);
        let before = worst(&self.c[own.clone()]);
        let good = part.solve(&mut found);
        let after = if found.iter().all(|x| x.is_finite()) { worst(&found) } else { f64::INFINITY };
        let good = good && after <= ALLOWED;
        // Better than before is something, too: the next round goes on from there.
        if good || after - 1.0 < BETTER * (before - 1.0) {
            self.c[own].copy_from_slice(&found);
        }
        good
    }

    fn tighten(&mut self, spot: &Spot) {
        let mut at = self.from;
        let k = self.problem.lengths.iter().position(|h| {
            at += h;
            at >= spot.at
        });
        let Some(k) = k else { return };
        self.problem.tighten(k, 1.0 + spot.excess);
        if self.touched.last() != Some(&k) {
            self.touched.push(k);
        }
    }

    /// Solves again around the intervals whose rows were tightened.
    fn repaired(mut self) -> Self {
        let mut touched = std::mem::take(&mut self.touched);
        touched.sort_unstable();
        let n = self.problem.lengths.len();
        let mut i = 0;
        while i < touched.len() {
            let begin = touched[i].saturating_sub(AROUND);
            let mut last = touched[i];
            while i < touched.len() && touched[i] < last + AROUND && touched[i] < begin + CHUNK {
                last = touched[i];
                i += 1;
            }
            let mut good = self.solve(begin, (last + AROUND + 1).min(n));
            if !good {
                // Where the acceleration is at its limit for long, the speed before must change too.
                good = self.solve(begin.saturating_sub(3 * AROUND), (last + 4 * AROUND + 1).min(n));
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
    /// Acceleration falls with e, jerk with 3/2 e; what the slope of the factor adds to the jerk, e v w''/4, is below a third
    /// of e J. A dip always exists, where rows that are tightened may contradict each other.
    fn dip(&mut self, spots: &[&Spot]) {
        let n = self.problem.lengths.len();
        let mut factors = vec![[1.0, 0.0]; n + 1];
        for spot in spots {
            // Given ends stay as they are.
            let room = [spot.at - self.from, self.to - spot.at];
            let fixed = self.problem.fixed;
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
                at += self.problem.lengths.get(k).copied().unwrap_or(0.0);
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
    fn level(&mut self, spots: &[&Spot]) {
        let n = self.problem.lengths.len();
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
                if self.problem.fixed[side] && distance < long {
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
            at += self.problem.lengths.get(k).copied().unwrap_or(0.0);
        }
        self.scale(&factors);
        self.levels += 1;
    }

    /// Multiplies b by a function of time, given by value and slope at the knots.
    fn scale(&mut self, factors: &[[f64; 2]]) {
        for (k, [factor, slope]) in factors.iter().copied().enumerate() {
            let b = self.c[2 * k];
            self.c[2 * k] = b * factor;
            self.c[2 * k + 1] = self.c[2 * k + 1] * factor + b * slope * self.problem.scale;
        }
        self.dipped = true;
    }

    /// The tempos; none where those of the law are kept.
    fn tempos(&self) -> Option<Vec<Tempo>> {
        if self.forced && !self.begun {
            return None;
        }
        let n = self.problem.lengths.len();
        let mut tempos = Vec::with_capacity(n);
        let (mut p, mut time) = (self.from, 0.0);
        for k in 0..n {
            let end = if k + 1 == n { self.to } else { p + self.problem.lengths[k] };
            let tempo = Tempo::new(p, end - p, self.problem.polynomial(&self.c, k), time);
            if !tempo.is_sound() {
                return None;
            }
            time += tempo.duration;
            tempos.push(tempo);
            p = end;
        }
        let own = self.to - self.from;
        let worthwhile = time < own * (1.0 - WORTHWHILE) || self.forced || self.dipped || {
            let even = self.problem.even();
            (0..self.problem.nodes.len()).any(|at| self.problem.used(at, &even) > 1.0003 * (1.0 + MARGIN))
        };
        (worthwhile && time.is_finite()).then_some(tempos)
    }
}
