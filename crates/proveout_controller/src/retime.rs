//! Runs a first law faster where the joints allow it.

mod grid;
mod solver;

pub(crate) use self::grid::Spot;
use self::solver::Problem;
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
/// Excess over limits that a tempo may have at the points of its grid.
const ALLOWED: f64 = 1.0003;

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

/// What was found for a region, kept while the rows in it stay as they are.
struct Solved {
    from: f64,
    to: f64,
    tempos: Option<Vec<Tempo>>,
}

/// Results of earlier rounds and the places where their samples passed limits.
#[derive(Default)]
pub(crate) struct Rounds {
    known: Vec<Solved>,
    /// In the order of time.
    spots: Vec<Spot>,
}

impl Rounds {
    /// Tightens the rows at these places, and forgets what was found there.
    pub(crate) fn tighten(&mut self, spots: &[Spot]) {
        self.known.retain(|k| !spots.iter().any(|s| s.at >= k.from && s.at <= k.to));
        for spot in spots {
            let at = self.spots.partition_point(|s| s.at < spot.at);
            // The same interval once more: both factors count.
            let before = self.spots[..at].iter().rev().chain(&self.spots[at..]);
            let near = before.filter(|s| (s.at - spot.at).abs() < 1e-3).fold(1.0_f64, |m, s| m.max(s.factor));
            self.spots.insert(at, Spot { at: spot.at, factor: near * spot.factor });
        }
    }

    /// The law with the fastest tempo that is found.
    pub(crate) fn retimed(&mut self, course: &Course<'_>) -> Law {
        let Course { path, frame, law, cells, entry, rest } = course;
        let moving = !entry.is_even();
        let mut found: Vec<Vec<Tempo>> = Vec::new();
        // What must be kept of the tail, where the begin cannot be solved.
        let mut kept_until = 0.0;
        let mut known = Vec::new();
        for region in grid::regions(path, frame, law, *cells, moving, &self.spots) {
            let at_begin = region.from <= 0.0;
            let before = self.known.iter().find(|k| k.from == region.from && k.to == region.to);
            let tempos = match before {
                Some(k) => k.tempos.clone(),
                None => {
                    let fixed = [!(at_begin && rest[0]), !(region.to >= law.planned && rest[1])];
                    let start = if at_begin { entry.square } else { [1.0, 0.0] };
                    let problem = grid::problem(path, frame, law, &region, fixed, &self.spots);
                    solved(&problem, [region.from, region.to], start)
                }
            };
            known.push(Solved { from: region.from, to: region.to, tempos: tempos.clone() });
            if region.from < kept_until {
                continue;
            }
            match tempos {
                Some(tempos) => found.push(tempos),
                None if at_begin && moving => {
                    found.push(entry.tail.clone());
                    kept_until = entry.tail.last().map_or(0.0, |t| t.begin + t.length);
                }
                None => {}
            }
        }
        self.known = known;
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

/// The fastest tempo of a region; none where the law's own is kept.
fn solved(problem: &Problem, [from, to]: [f64; 2], start: [f64; 2]) -> Option<Vec<Tempo>> {
    let n = problem.lengths.len();
    if problem.nodes.is_empty() {
        return None;
    }
    let even = problem.even();
    let mut c = even.clone();
    problem.set_start(&mut c, start);
    let forced = start != [1.0, 0.0];
    let (mut begin, mut any) = (0, false);
    while begin < n {
        let end = if begin + CHUNK + CHUNK / 4 >= n { n } else { begin + CHUNK };
        let part = problem.part(begin, end);
        let mut found = c[2 * begin..=2 * end + 1].to_vec();
        let t0 = std::time::Instant::now();
        let good = part.solve(&mut found) && (0..part.nodes.len()).all(|at| part.used(at, &found) <= ALLOWED);
        if std::env::var("RETIME_DEBUG").is_ok() {
            let worst = (0..part.nodes.len()).map(|i| part.used(i, &found)).fold(0.0, f64::max);
            eprintln!(
                "region {from:.4}..{to:.4} n {n} chunk {begin}..{end} nodes {} joints {} good {good} time {:.5} worst {worst:.5} wall {:.5}",
                part.nodes.len(),
                part.count,
                part.time(&found),
                t0.elapsed().as_secs_f64()
            );
        }
        if good {
            c[2 * begin..=2 * end + 1].copy_from_slice(&found);
            any = true;
        } else if begin == 0 && forced {
            return None;
        }
        // The tempo found for the last part of a chunk is the start of the next one, which knows what comes behind it.
        begin = if end == n { n } else { begin + COMMITTED };
    }
    if !any {
        return None;
    }
    let mut own_is_good = true;
    for at in 0..problem.nodes.len() {
        let (new, own) = (problem.used(at, &c), problem.used(at, &even));
        own_is_good &= own <= ALLOWED;
        if new.is_nan() || new > ALLOWED.max(own) {
            return None;
        }
    }
    let mut tempos = Vec::with_capacity(n);
    let (mut p, mut time) = (from, 0.0);
    for k in 0..n {
        let end = if k + 1 == n { to } else { p + problem.lengths[k] };
        let tempo = Tempo::new(p, end - p, problem.polynomial(&c, k), time);
        time += tempo.duration;
        tempos.push(tempo);
        p = end;
    }
    let worthwhile = time < (to - from) * (1.0 - WORTHWHILE) || forced || !own_is_good;
    (worthwhile && time.is_finite()).then_some(tempos)
}
