//! Runs a first law faster where the joints allow it.

mod grid;
mod solver;

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
/// Excess over limits that a tempo may have at the points of its grid.
const ALLOWED: f64 = 1.0003;

/// Gives the law over the first `cells` cells the fastest tempo that is found. `rest` tells whether the law begins and ends
/// at rest; where it does not, it begins as `entry` says and ends with its own tempo.
pub(crate) fn retime(path: &Path, frame: &Frame<'_>, law: &mut Law, cells: usize, entry: &Entry, rest: [bool; 2]) {
    let step = grid::interval(frame);
    let moving = !entry.is_even();
    let mut found: Vec<Vec<Tempo>> = Vec::new();
    // What must be kept of the tail, where the begin cannot be solved.
    let mut kept_until = 0.0;
    for region in grid::regions(path, frame, law, cells, step, moving) {
        if region.from < kept_until {
            continue;
        }
        let at_begin = region.from <= 0.0;
        let fixed = [!(at_begin && rest[0]), !(region.to >= law.planned && rest[1])];
        let start = if at_begin { entry.square } else { [1.0, 0.0] };
        match solved(path, frame, law, &region, step, fixed, start) {
            Some(tempos) => found.push(tempos),
            None if at_begin && moving => {
                found.push(entry.tail.clone());
                kept_until = entry.tail.last().map_or(0.0, |t| t.begin + t.length);
            }
            None => {}
        }
    }
    if !found.is_empty() {
        law.set_tempos(spliced(found, law.planned));
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
fn solved(
    path: &Path,
    frame: &Frame<'_>,
    law: &Law,
    region: &grid::Region,
    step: f64,
    fixed: [bool; 2],
    start: [f64; 2],
) -> Option<Vec<Tempo>> {
    let problem = grid::problem(path, frame, law, region, step, fixed);
    let n = problem.lengths.len();
    if n < 3 || problem.nodes.is_empty() {
        return None;
    }
    let even = problem.even();
    let mut c = even.clone();
    problem.set_start(&mut c, start);
    let forced = start != [1.0, 0.0];
    let solved = problem.solve(&mut c);
    if std::env::var("RETIME_DEBUG").is_ok() {
        let worst = (0..problem.nodes.len()).map(|i| problem.used(i, &c)).fold(0.0, f64::max);
        let worst_even = (0..problem.nodes.len()).map(|i| problem.used(i, &even)).fold(0.0, f64::max);
        eprintln!(
            "region {:.4}..{:.4} n {n} nodes {} joints {} solved {solved} time {:.5} used {worst:.5} even {worst_even:.5}",
            region.from, region.to, problem.nodes.len(), problem.count, problem.time(&c)
        );
    }
    if !solved {
        return None;
    }
    let mut own_is_good = true;
    for at in 0..problem.nodes.len() {
        let (new, own) = (problem.used(at, &c), problem.used(at, &even));
        own_is_good &= own <= ALLOWED;
        if !(new <= ALLOWED.max(own)) {
            return None;
        }
    }
    let mut tempos = Vec::with_capacity(n);
    let (mut p, mut time) = (region.from, 0.0);
    for k in 0..n {
        let end = if k + 1 == n { region.to } else { p + problem.lengths[k] };
        let tempo = Tempo::new(p, end - p, problem.polynomial(&c, k), time);
        time += tempo.duration;
        tempos.push(tempo);
        p = end;
    }
    let own = region.to - region.from;
    let worthwhile = time < own * (1.0 - WORTHWHILE) || forced || !own_is_good;
    (worthwhile && time.is_finite()).then_some(tempos)
}
