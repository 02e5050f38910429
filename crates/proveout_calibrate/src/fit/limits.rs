//! Velocity, acceleration and jerk of a joint, or the moving averages of its interpolator, from the set
//! points of its moves.
//!
//! All moves share velocity and shape of one law (`law.rs`). Each move has its begin and its places before
//! and after as parameters of its own, and a move that runs steadily below the fastest one has its own
//! velocity: a move in feed. The rows at rest count as one reading at each end, since rounding makes their
//! errors the same. Each kind of law is fitted; the smallest criterion of Akaike (1974) decides.

use super::{
    law::{LawKind, LawShape},
    least_squares::{Minimum, Problem, minimize},
    moves::Move,
};
use crate::trace::{Signal, Trace};

/// Most moves of a joint that are fitted: lengths and directions repeat after that.
const MOST_MOVES: usize = 24;
/// A move is steady where it keeps within this part of its highest velocity ...
const STEADY: f64 = 0.01;
/// ... over this part of its time: pure ramps of jerk stay there for less than a sixth.
const STEADY_PART: f64 = 0.25;
/// A steady move slower than the fastest by this part has a feed of its own.
const SLOWER: f64 = 0.01;
/// Fewest rows within a steady stretch that show a velocity.
const STEADY_ROWS: usize = 8;
/// Times of a full acceleration that are tried first, s.
const FIRST_RISES: [f64; 7] = [0.002, 0.005, 0.012, 0.03, 0.07, 0.15, 0.3];
/// Kinds within this of the best criterion fit alike.
const ALIKE: f64 = 6.0;
/// Rows that a first trial looks at in a move.
const TRIAL_ROWS: usize = 60;
/// A move with more than this many times the median misfit is no free move.
const MISFIT: f64 = 6.0;
/// Misfit (in standard deviations of the rows) below which no move is left out.
const LEAST_MISFIT: f64 = 3.0;

/// A kind of law with its parameters.
#[derive(Clone, Debug)]
pub(crate) struct KindFit {
    pub(crate) kind: LawKind,
    pub(crate) shape: LawShape,
    /// Standard errors of velocity and shape as parts of them; none where not determined.
    pub(crate) errors: [Option<f64>; 3],
    /// Correlation of velocity, first and second parameter of the shape (as logarithms).
    pub(crate) correlations: [[f64; 3]; 3],
    /// Criterion of Akaike, up to a constant.
    pub(crate) criterion: f64,
    /// Root mean square of the residuals in standard deviations.
    pub(crate) misfit: f64,
    /// Begin of each move in the time of its trace, and velocity.
    pub(crate) starts: Vec<(f64, f64)>,
    pub(crate) minimum: Minimum,
}

/// What the moves of a joint say about its limits.
#[derive(Clone, Debug)]
pub(crate) struct LimitsFit {
    pub(crate) best: KindFit,
    /// Kinds that fit as well.
    pub(crate) alike: Vec<LawKind>,
    /// Moves that were used.
    pub(crate) moves: Vec<Move>,
    /// Moves that no law fits: feed hold, single block, another program.
    pub(crate) unfit: usize,
    /// Moves that reach the velocity.
    pub(crate) at_velocity: usize,
}

/// One move as numbers: rows with their standard deviations, and both ends.
struct Data {
    time: Vec<f64>,
    place: Vec<f64>,
    deviation: Vec<f64>,
    ends: [f64; 2],
    end_deviation: [f64; 2],
    /// Own velocity of a move in feed.
    feed: Option<f64>,
    /// Time at half of the way.
    middle: f64,
    /// Step of the rows, s.
    step: f64,
}

impl Data {
    fn new(one: &Move, trace: &Trace, signal: &Signal) -> Option<Self> {
        let time = trace.time.get(one.rows.clone())?;
        let values = signal.values.get(one.rows.clone())?;
        let first = one.moving.start - one.rows.start;
        let last = one.moving.end - one.rows.start;
        // The way may begin before motion is seen: the half of the rest that is nearer belongs to the rows.
        let lead = first / 2;
        let trail = last + (values.len() - last).div_ceil(2);
        let rest = |part: &[f64]| -> Option<(f64, f64)> {
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            let rounding = signal.quantum * signal.quantum / 12.0;
            // Without noise all readings at rest share one rounding error.
            let shared = if signal.noise >= 0.5 * signal.quantum { rounding / part.len() as f64 } else { rounding };
            let variance = signal.noise * signal.noise / part.len() as f64 + shared;
            (!part.is_empty()).then(|| (mean, variance.sqrt()))
        };
        let (begin, begin_deviation) = rest(values.get(..lead.max(1))?)?;
        let (end, end_deviation) = rest(values.get(trail.min(values.len() - 1)..)?)?;
        let (time, place) = (time.get(lead..trail)?.to_vec(), values.get(lead..trail)?.to_vec());
        let half = 0.5 * (begin + end);
        let at = place.windows(2).position(|w| (w[0] - half) * (w[1] - half) <= 0.0 && w[0] != w[1])?;
        let middle = time[at] + (time[at + 1] - time[at]) * (half - place[at]) / (place[at + 1] - place[at]);
        let mut speed: Vec<f64> = Vec::with_capacity(time.len());
        let half_window = (time.len() / 60).max(1);
        for k in 0..time.len() {
            let (a, b) = (k.saturating_sub(half_window), (k + half_window).min(time.len() - 1));
            speed.push((place[b] - place[a]) / (time[b] - time[a]));
        }
        // Rows with errors of the clock: a step of the time that is not kept shifts the place.
        let jitter = if trace.even { 0.0 } else { 0.02 * trace.step };
        let floor = 1e-12 * (begin.abs() + end.abs()).max(1.0);
        let deviation =
            speed.iter().map(|v| (signal.variance(*v, trace.step) + (v * jitter).powi(2)).sqrt().max(floor)).collect();
        let mut data = Self {
            time,
            place,
            deviation,
            ends: [begin, end],
            end_deviation: [begin_deviation.max(floor), end_deviation.max(floor)],
            feed: None,
            middle,
            step: trace.step,
        };
        data.feed = data.steady_velocity(signal);
        Some(data)
    }

    fn length(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// Velocity of the steady stretch, where the move has one.
    fn steady_velocity(&self, signal: &Signal) -> Option<f64> {
        let (v, steady, all) = self.smoothed_peak(signal)?;
        (steady >= STEADY_ROWS && steady as f64 > STEADY_PART * all as f64).then_some(v)
    }

    /// Highest velocity over a window that noise and rounding leave sharp, rows near it, rows in motion.
    fn smoothed_peak(&self, signal: &Signal) -> Option<(f64, usize, usize)> {
        let rows = self.time.len();
        let mut half = 1;
        let guess = self.length().abs() / (self.time.last()? - self.time.first()?).max(self.step);
        // A window in which noise and rounding make a fifth of what counts as steady.
        let error = signal.noise.max(0.5 * signal.quantum);
        while half < rows / 8 && error > 0.2 * STEADY * guess * self.step * half as f64 {
            half += 1;
        }
        let speed = |k: usize| {
            let (a, b) = (k.saturating_sub(half), (k + half).min(rows - 1));
            ((self.place[b] - self.place[a]) / (self.time[b] - self.time[a])).abs()
        };
        let all: Vec<f64> = (0..rows).map(speed).collect();
        let peak = all.iter().fold(0.0_f64, |m, v| m.max(*v));
        let steady: Vec<f64> = all.iter().copied().filter(|v| *v > (1.0 - STEADY) * peak).collect();
        let moving = all.iter().filter(|v| **v > 0.02 * peak).count();
        let mean = steady.iter().sum::<f64>() / steady.len().max(1) as f64;
        (peak > 0.0).then_some((mean, steady.len(), moving))
    }
}

struct MovesProblem<'a> {
    kind: LawKind,
    data: &'a [Data],
    depends: Vec<Vec<usize>>,
    feeds: Vec<Option<usize>>,
    own: Vec<usize>,
    size: usize,
    shared: usize,
    /// Every so many rows are looked at.
    stride: usize,
}

impl<'a> MovesProblem<'a> {
    fn new(kind: LawKind, data: &'a [Data], trial: bool) -> Self {
        let shared = 1 + kind.shape_parameters();
        let mut size = shared;
        let (mut depends, mut feeds, mut own) = (Vec::new(), Vec::new(), Vec::new());
        for one in data {
            let mut list: Vec<usize> = (0..shared).collect();
            let feed = one.feed.map(|_| size);
            if let Some(p) = feed {
                // In feed the velocity of rapids has no effect.
                list.remove(0);
                list.push(p);
                size += 1;
            }
            list.extend([size, size + 1, size + 2]);
            own.push(size);
            size += 3;
            feeds.push(feed);
            depends.push(list);
        }
        let longest = data.iter().map(|d| d.time.len()).max().unwrap_or(0);
        let stride = if trial { (longest / TRIAL_ROWS).max(1) } else { 1 };
        Self { kind, data, depends, feeds, own, size, shared, stride }
    }

    fn shape(&self, block: usize, p: &[f64]) -> LawShape {
        let velocity = p[self.feeds[block].unwrap_or(0)].exp();
        let mut shape = [p[1].exp(), 0.0];
        if self.shared > 2 {
            shape[1] = p[2].exp();
        }
        LawShape { kind: self.kind, velocity, shape }
    }

    /// Parameters with every move placed by the middle of its way.
    fn start(&self, velocity: f64, shape: [f64; 2]) -> Vec<f64> {
        let mut p = vec![0.0; self.size];
        p[0] = velocity.ln();
        p[1] = shape[0].ln();
        if self.shared > 2 {
            p[2] = shape[1].ln();
        }
        for (block, one) in self.data.iter().enumerate() {
            if let (Some(place), Some(v)) = (self.feeds[block], one.feed) {
                p[place] = v.ln();
            }
            let law = self.shape(block, &p).law(one.length());
            let at = self.own[block];
            p[at] = one.middle - 0.5 * law.duration;
            (p[at + 1], p[at + 2]) = (one.ends[0], one.ends[1]);
        }
        p
    }
}

impl Problem for MovesProblem<'_> {
    fn blocks(&self) -> usize {
        self.data.len()
    }

    fn depends(&self, block: usize) -> &[usize] {
        &self.depends[block]
    }

    fn residuals(&self, block: usize, p: &[f64]) -> Option<Vec<f64>> {
        let (one, at) = (&self.data[block], self.own[block]);
        let (begin, from, to) = (p[at], p[at + 1], p[at + 2]);
        let law = self.shape(block, p).law(to - from);
        if !law.duration.is_finite() {
            return None;
        }
        let rows = one.time.iter().zip(&one.place).zip(&one.deviation).step_by(self.stride);
        let mut out: Vec<f64> = rows.map(|((t, x), s)| (from + law.position(t - begin) - x) / s).collect();
        out.push((from - one.ends[0]) / one.end_deviation[0]);
        out.push((to - one.ends[1]) / one.end_deviation[1]);
        Some(out)
    }

    fn step(&self, parameter: usize) -> f64 {
        match self.own.iter().rfind(|at| **at <= parameter) {
            // Seconds, and places; all others are logarithms.
            Some(at) if parameter == *at => 2e-6,
            Some(at) if parameter <= at + 2 => 1e-5,
            _ => 1e-5,
        }
    }

    fn bounds(&self, parameter: usize) -> [f64; 2] {
        let logarithm = |low: f64, high: f64| [low.ln(), high.ln()];
        if self.own.iter().any(|at| (*at..at + 3).contains(&parameter)) {
            return [-f64::MAX, f64::MAX];
        }
        match (self.kind, parameter) {
            (LawKind::OneAverage | LawKind::TwoAverages, 1 | 2) => logarithm(1e-5, 10.0),
            (LawKind::SmoothedTrapezoid, 2) => logarithm(1e-5, 10.0),
            (_, 1) => logarithm(1e-3, 1e6),
            (_, 2) => logarithm(1e-2, 1e9),
            _ => logarithm(1e-5, 1e5),
        }
    }
}

/// Time from a tenth to nine tenths of the velocity, as a first look at the acceleration.
fn first_acceleration(data: &[Data]) -> f64 {
    let of = |one: &Data| {
        let half = (one.time.len() / 200).max(1);
        let speed = |k: usize| {
            let (a, b) = (k.saturating_sub(half), (k + half).min(one.time.len() - 1));
            ((one.place[b] - one.place[a]) / (one.time[b] - one.time[a])).abs()
        };
        let peak = (0..one.time.len()).map(speed).fold(0.0_f64, f64::max);
        let at = |part: f64| (0..one.time.len()).find(|k| speed(*k) > part * peak).map(|k| one.time[k]);
        let (slow, fast) = (at(0.2)?, at(0.8)?);
        Some(0.6 * peak / (fast - slow).max(one.step))
    };
    data.iter().filter_map(of).fold(0.0_f64, f64::max)
}

fn fit_kind(kind: LawKind, data: &[Data], velocity: f64, acceleration: f64) -> Option<KindFit> {
    let trial = MovesProblem::new(kind, data, true);
    let starts: Vec<[f64; 2]> = match kind {
        LawKind::JerkLimited => FIRST_RISES
            .iter()
            .flat_map(|rise| [1.0, 1.6].map(|k| [k * acceleration, k * acceleration / rise]))
            .collect(),
        LawKind::Trapezoid => [0.8, 1.0, 1.5].map(|k| [k * acceleration, 0.0]).to_vec(),
        LawKind::SmoothedTrapezoid => {
            FIRST_RISES.iter().flat_map(|rise| [1.0, 1.6].map(|k| [k * acceleration, *rise])).collect()
        }
        LawKind::OneAverage => [0.6, 1.0, 1.5].map(|k| [k * velocity / acceleration, 0.0]).to_vec(),
        LawKind::TwoAverages => {
            FIRST_RISES.iter().flat_map(|rise| [0.6, 1.0, 1.5].map(|k| [k * velocity / acceleration, *rise])).collect()
        }
    };
    // The two best begins of a coarse look, then their minima.
    let mut tried: Vec<(f64, Vec<f64>)> = starts
        .into_iter()
        .filter_map(|shape| {
            let p = trial.start(velocity, shape);
            let mut sum = 0.0;
            for block in 0..trial.blocks() {
                sum += trial.residuals(block, &p)?.iter().map(|r| r * r).sum::<f64>();
            }
            sum.is_finite().then_some((sum, p))
        })
        .collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.truncate(3);
    let found = tried.into_iter().filter_map(|(_, p)| minimize(&trial, &p));
    let first = found.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let problem = MovesProblem::new(kind, data, false);
    let minimum = minimize(&problem, &first.parameters)?;
    let p = &minimum.parameters;
    let mut shape = [p[1].exp(), if problem.shared > 2 { p[2].exp() } else { 0.0 }];
    let mut order = [0, 1, 2];
    if kind == LawKind::TwoAverages && shape[1] > shape[0] {
        shape.swap(0, 1);
        order.swap(1, 2);
    }
    let known = |k: usize| minimum.errors.get(k).copied().flatten().filter(|_| k < problem.shared && minimum.converged);
    let mut errors = order.map(known);
    if (1..problem.shared).any(|k| known(k).is_none()) {
        // A shape with a part that nothing determines lies in a hollow of its own: none of it is known.
        errors = [errors[0], None, None];
    }
    let correlations = order.map(|i| {
        order.map(|k| if i < problem.shared && k < problem.shared { minimum.correlations[(i, k)] } else { 0.0 })
    });
    let starts = (0..data.len()).map(|b| (p[problem.own[b]], p[problem.feeds[b].unwrap_or(0)].exp())).collect();
    let rows = minimum.rows as f64;
    // With known deviations the criterion is the cost itself; a misfit of all kinds alike is no difference.
    let scale = (minimum.cost / rows).max(f64::MIN_POSITIVE);
    Some(KindFit {
        kind,
        shape: LawShape { kind, velocity: p[0].exp(), shape },
        errors,
        correlations,
        criterion: rows * scale.ln() + 2.0 * problem.shared as f64,
        misfit: scale.sqrt(),
        starts,
        minimum,
    })
}

/// Root mean square of the residuals of each move.
fn misfits(fit: &KindFit, data: &[Data]) -> Vec<f64> {
    let problem = MovesProblem::new(fit.kind, data, false);
    (0..data.len())
        .map(|b| {
            let r = problem.residuals(b, &fit.minimum.parameters).unwrap_or_default();
            (r.iter().map(|r| r * r).sum::<f64>() / r.len().max(1) as f64).sqrt()
        })
        .collect()
}

/// The longest and shortest moves of both directions, at most [`MOST_MOVES`].
fn chosen(mut moves: Vec<Move>) -> Vec<Move> {
    if moves.len() > MOST_MOVES {
        let key = |m: &Move| (m.to - m.from).abs();
        moves.sort_by(|a, b| {
            key(b).total_cmp(&key(a)).then(a.trace.cmp(&b.trace)).then(a.rows.start.cmp(&b.rows.start))
        });
        // Evenly over the order of lengths.
        let count = moves.len();
        moves = (0..MOST_MOVES).filter_map(|k| moves.get(k * (count - 1) / (MOST_MOVES - 1)).cloned()).collect();
        moves.sort_by_key(|m| (m.trace, m.rows.start));
        moves.dedup_by_key(|m| (m.trace, m.rows.start));
    }
    moves
}

/// Fits every kind of law to the moves of a joint; `signal` is the set point of a trace.
///
/// None where there is no move, or none of the kinds can be placed on them.
pub(crate) fn fit_limits<'t>(
    moves: Vec<Move>,
    traces: &'t [Trace],
    signal: impl Fn(&Trace) -> Option<&Signal>,
) -> Option<LimitsFit> {
    let mut moves = chosen(moves);
    let mut data: Vec<Data> = Vec::new();
    moves.retain(|one| {
        let of = || -> Option<Data> {
            let trace: &'t Trace = traces.get(one.trace)?;
            Data::new(one, trace, signal(trace)?)
        };
        of().map(|d| data.push(d)).is_some()
    });
    let fastest = data.iter().filter_map(|d| d.feed).fold(0.0_f64, f64::max);
    let peak = |d: &Data| {
        let steps = (d.time.len() / 50).max(1);
        (steps..d.time.len())
            .map(|k| ((d.place[k] - d.place[k - steps]) / (d.time[k] - d.time[k - steps])).abs())
            .fold(0.0_f64, f64::max)
    };
    let velocity = if fastest > 0.0 { fastest } else { data.iter().map(peak).fold(0.0_f64, f64::max) };
    let mut at_velocity = 0;
    for one in &mut data {
        if one.feed.is_some_and(|v| v > (1.0 - SLOWER) * velocity) {
            one.feed = None;
            at_velocity += 1;
        }
    }
    let acceleration = first_acceleration(&data);
    if data.is_empty() || !(velocity > 0.0 && acceleration > 0.0) {
        return None;
    }
    let mut unfit = 0;
    loop {
        let mut fits: Vec<KindFit> =
            LawKind::ALL.into_iter().filter_map(|kind| fit_kind(kind, &data, velocity, acceleration)).collect();
        let lowest = fits.iter().map(|f| f.criterion).reduce(f64::min)?;
        // Of those that fit alike the one with the fewest parameters, then the first.
        let alike = fits.iter().enumerate().filter(|(_, f)| f.criterion <= lowest + ALIKE);
        let (place, _) = alike.min_by_key(|(k, f)| (f.kind.shape_parameters(), *k))?;
        let best = fits.remove(place);
        let alike = fits.iter().filter(|f| f.criterion <= lowest + ALIKE).map(|f| f.kind).collect();
        let all = misfits(&best, &data);
        let mut sorted = all.clone();
        sorted.sort_by(f64::total_cmp);
        let bound = (MISFIT * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)).max(LEAST_MISFIT);
        let keep: Vec<bool> = all.iter().map(|m| *m <= bound).collect();
        let out = keep.iter().filter(|k| !**k).count();
        if out == 0 || 2 * out > keep.len() || unfit > 0 {
            return Some(LimitsFit { best, alike, moves, unfit, at_velocity });
        }
        unfit = out;
        let mut at = keep.iter();
        data.retain(|_| at.next().copied().unwrap_or(true));
        let mut at = keep.iter();
        moves.retain(|_| at.next().copied().unwrap_or(true));
    }
}
