//! The search for the tempo of some intervals, stage by stage: first with all rows that may count, then with
//! those that the tempo comes near to, and at the end only around the places that still need a point.
//!
//! ```text
//!   gap 0.9 --> 0.03     rows of every joint that reaches a part of the highest load
//!      0.03 --> 0.001    rows that the tempo comes near to, some nodes by some nodes;
//!                        points where a row passes its limit between two nodes
//!                        twice: points where that is still so, and a search of the intervals around
//!                        them alone, of more around them where that does not succeed
//! ```
//!
//! A row that is left out is checked again after each stage, and all of them on the result.

use super::{
    grid::Probe,
    part::{Names, SPEED},
    problem::{Loads, Problem},
    solver::{Before, GAP, NEW, TempoSolver},
};

/// Part of the highest load of all above which a joint's rows take part from the begin.
const FAR: f64 = 0.75;
/// Gap at which nodes are added for the first time.
const COARSE: f64 = 0.03;
/// Part of its limit above which a row takes part from then on.
const NEAR: f64 = 0.8;
/// Part of a limit above which a row between nodes gets one, at the coarse gap and at the end, and how often
/// at the end.
const EARLY: f64 = 0.9;
const PEAK: f64 = 1.003;
const LATE: usize = 2;
/// Intervals to either side of a late node that are searched again with it.
const BESIDE: usize = 6;
/// The same, where that does not succeed.
const FAR_BESIDE: usize = 30;

/// Searches with their room, for one problem after the other: what a search has grown to is not asked of the
/// system again.
#[derive(Default)]
pub(crate) struct Stages {
    now: TempoSolver,
    before: TempoSolver,
    local: TempoSolver,
    /// Of the nodes of the problem those in the search `now`.
    nodes: Vec<usize>,
    /// Rows that take part, node by node.
    rows: Vec<Names>,
    own: Vec<Names>,
    loads: Loads,
    /// Intervals next to given ends of the searches at the end, whose rows may pass their limits a little.
    pub(super) relaxed: Vec<usize>,
}

impl Stages {
    /// Looks for the fastest tempo from `c` on; the problem gets the nodes that are needed. False when it is
    /// not found.
    pub(super) fn run(&mut self, probe: &mut Probe<'_>, problem: &mut Problem, c: &mut [f64]) -> bool {
        self.relaxed.clear();
        problem.loads(c, &mut self.loads);
        problem.far(&self.loads, FAR, &mut self.rows);
        if !self.now.run(problem, &self.rows, c, COARSE, None) {
            return false;
        }
        self.same_nodes(problem);
        problem.loads(c, &mut self.loads);
        problem.near(&self.loads, NEAR, &mut self.rows);
        let peaks = problem.peaks(&self.loads, EARLY);
        self.insert(probe, problem, &peaks);
        if !self.go_on(problem, c) {
            return false;
        }
        for _ in 0..LATE {
            problem.loads(c, &mut self.loads);
            let peaks = problem.peaks(&self.loads, PEAK);
            let mut touched = problem.passed(&self.loads, &self.rows);
            touched.extend(peaks.iter().map(|p| problem.nodes[p.0].k));
            if touched.is_empty() {
                break;
            }
            touched.sort_unstable();
            self.insert(probe, problem, &peaks);
            if !self.around(problem, c, &touched) {
                self.relaxed.clear();
                problem.loads(c, &mut self.loads);
                problem.near(&self.loads, NEAR, &mut self.rows);
                if !self.go_on(problem, c) {
                    return false;
                }
            }
        }
        true
    }

    /// Searches all intervals again.
    fn go_on(&mut self, problem: &Problem, c: &mut [f64]) -> bool {
        std::mem::swap(&mut self.now, &mut self.before);
        let before = Before { search: &self.before, nodes: &self.nodes };
        let good = self.now.run(problem, &self.rows, c, GAP, Some(&before));
        self.same_nodes(problem);
        good
    }

    fn same_nodes(&mut self, problem: &Problem) {
        self.nodes.clear();
        self.nodes.extend(0..problem.nodes.len());
    }

    /// Adds nodes, each after a given one.
    fn insert(&mut self, probe: &mut Probe<'_>, problem: &mut Problem, peaks: &[(usize, f64)]) {
        for (behind, _) in peaks.iter().rev() {
            self.nodes.insert(behind + 1, NEW);
            self.rows.insert(behind + 1, self.rows[*behind] & !(1 << SPEED));
        }
        let used = problem.used.clone();
        problem.insert(peaks, |cell, p| probe.rows_of(&used, cell, p));
    }

    /// Searches the intervals around those touched, which rise; what lies between stays. False, where they
    /// are too many or one of the searches fails.
    fn around(&mut self, problem: &Problem, c: &mut [f64], touched: &[usize]) -> bool {
        let n = problem.lengths.len();
        let mut ranges: Vec<[usize; 2]> = Vec::new();
        for k in touched {
            let [from, to] = [k.saturating_sub(BESIDE), (k + BESIDE + 1).min(n)];
            match ranges.last_mut().filter(|last| last[1] >= from) {
                Some(last) => last[1] = to,
                None => ranges.push([from, to]),
            }
        }
        if ranges.iter().map(|r| r[1] - r[0]).sum::<usize>() > n / 2 {
            return false;
        }
        ranges.into_iter().all(|[from, to]| {
            let more = FAR_BESIDE - BESIDE;
            let wide = [from.saturating_sub(more), (to + more).min(n)];
            self.search_again(problem, c, [from, to])
                || 2 * (wide[1] - wide[0]) <= n && self.search_again(problem, c, wide)
        })
    }

    /// Searches some intervals again from what is there; their ends stay.
    fn search_again(&mut self, problem: &Problem, c: &mut [f64], [from, to]: [usize; 2]) -> bool {
        let own = problem.between([from, to]);
        let first = problem.nodes.partition_point(|node| node.k < from);
        let last = first + own.nodes.len();
        let unknowns = 2 * from..2 * to + 2;
        own.loads(&c[unknowns.clone()], &mut self.loads);
        own.near(&self.loads, NEAR, &mut self.own);
        let before = Before { search: &self.now, nodes: &self.nodes[first..last] };
        let mut found = c[unknowns.clone()].to_vec();
        if !self.local.run(&own, &self.own, &mut found, GAP, Some(&before)) {
            return false;
        }
        c[unknowns].copy_from_slice(&found);
        for (rows, own) in self.rows[first..last].iter_mut().zip(&self.own) {
            *rows |= own;
        }
        self.relaxed.extend([from, to - 1]);
        true
    }
}
