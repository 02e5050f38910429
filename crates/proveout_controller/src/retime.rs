//! Runs a first law faster where the joints allow it.

mod grid;
mod solver;

use crate::{
    path::{Frame, Path},
    profile::Law,
    tempo::Tempo,
};

/// How a law begins: square of the tempo and its slope by the time of the first law, and tempos that are known to be possible
/// from there on.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) square: [f64; 2],
    pub(crate) tail: Vec<Vec<Tempo>>,
}

impl Default for Entry {
    fn default() -> Self {
        Self { square: [1.0, 0.0], tail: Vec::new() }
    }
}

impl Entry {
    /// The law goes on with these tempos, level by level.
    pub(crate) fn new(tail: Vec<Vec<Tempo>>) -> Self {
        let mut square = [1.0, 0.0];
        for level in &tail {
            let [b, slope] = level.first().map_or([1.0, 0.0], |t| t.square_at(0.0));
            // d(B b)/dp = B' b + B b' dx/dp, where the time x of the level passes with dx/dp = 1/sqrt(B).
            square = [square[0] * b, square[1] * b + square[0].sqrt() * slope];
        }
        Self { square, tail }
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
    let levels: usize = std::env::var("LV").ok().and_then(|v| v.parse().ok()).unwrap_or(2);
    for pass in 0..levels {
        let start = if pass == 0 { entry.square } else { [1.0, 0.0] };
        let moving = start != [1.0, 0.0];
        let mut found: Vec<Vec<Tempo>> = Vec::new();
        for region in grid::regions(path, frame, law, cells, step, moving) {
            let at_begin = region.from <= 0.0;
            let fixed = [!(at_begin && rest[0]), !(region.to >= law.duration && rest[1])];
            let start = if at_begin { start } else { [1.0, 0.0] };
            match solved(path, frame, law, &region, step, fixed, start) {
                Some(tempos) => found.push(tempos),
                None if at_begin && moving => {
                    // The begin is given: what was found for it before still holds.
                    for level in &entry.tail {
                        let mut tempos = Vec::new();
                        splice(&mut tempos, [level.clone()], law.duration);
                        law.push_level(tempos);
                    }
                    return;
                }
                None => {}
            }
        }
        if found.is_empty() {
            return;
        }
        let mut tempos = Vec::new();
        splice(&mut tempos, found, law.duration);
        law.push_level(tempos);
    }
}

/// Puts the tempos of regions behind each other and fills the gaps up to `end` with even ones.
fn splice(tempos: &mut Vec<Tempo>, regions: impl IntoIterator<Item = Vec<Tempo>>, end: f64) {
    let (mut p, mut time) = (0.0, 0.0);
    let even = |tempos: &mut Vec<Tempo>, p: f64, to: f64, time: &mut f64| {
        if to > p {
            tempos.push(Tempo::even(p, to - p, *time));
            *time += to - p;
        }
    };
    for region in regions {
        let Some(first) = region.first() else { continue };
        even(tempos, p, first.begin, &mut time);
        for tempo in region {
            tempos.push(Tempo { time, ..tempo });
            time += tempo.duration;
            p = tempo.begin + tempo.length;
        }
    }
    even(tempos, p, end, &mut time);
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
    let even = vec![1.0; n + 2];
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
