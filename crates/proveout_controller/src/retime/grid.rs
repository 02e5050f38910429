//! Cuts the time of a first law into regions and grids, and evaluates the joints there.

use proveout_machine::MAX_JOINTS;

use super::solver::{JointRow, Node, Problem};
use crate::{
    jet::JointJet,
    path::{Frame, Path},
    profile::{Cursor, Law},
};

/// Longest interval as part of the time that a joint needs from zero to its full acceleration.
const FINEST: f64 = 1.0 / 12.0;
/// The same in seconds where no joint limits both, and the range in any case.
const INTERVAL: [f64; 3] = [0.001, 0.004, 0.02];
/// Shortest interval as part of the longest.
const SHORTEST: f64 = 0.2;
/// Intervals by which a region reaches into stretches that run at the highest speed already.
const MARGIN: f64 = 5.0;
/// Speed along the path that counts as the highest, as part of it.
const AT_SPEED: f64 = 0.996;
/// Part of a piece by which points stand off its borders, so that each belongs to one side of a jump.
const INSIDE: f64 = 1e-6;
/// Change of speed between two points that needs points between them, as part of the speed, and the most parts.
const CHANGE: f64 = 0.1;
const PARTS: f64 = 4.0;
/// What rows next to a given begin or end may pass their limits, so that these have an inside.
const RELAXED: f64 = 4e-4;

/// Time between neighboring borders of phases and cells.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    to: f64,
    cell: usize,
    held: bool,
}

/// A stretch of time whose tempo is free.
#[derive(Debug)]
pub(super) struct Region {
    pub(super) from: f64,
    pub(super) to: f64,
    pieces: Vec<Piece>,
}

/// Longest interval, s.
pub(super) fn interval(frame: &Frame<'_>) -> f64 {
    let l = frame.limits;
    let rise = (0..l.count).map(|i| l.acceleration[i] / l.jerk[i]).filter(|t| t.is_finite() && *t > 0.0);
    let least = rise.fold(f64::INFINITY, f64::min);
    let [low, usual, high] = INTERVAL;
    if least.is_finite() { (FINEST * least).clamp(low, high) } else { usual }
}

/// The stretches of the law's first `cells` cells where another tempo may be faster. `moving` tells that the law begins with
/// a given tempo that must be followed.
pub(super) fn regions(path: &Path, law: &Law, cells: usize, step: f64, moving: bool) -> Vec<Region> {
    let pieces = pieces(path, law, cells);
    let mut regions: Vec<Region> = Vec::new();
    let mut open: Vec<Piece> = Vec::new();
    let margin = MARGIN * step;
    let mut i = 0;
    let mut at_begin = moving;
    while i < pieces.len() {
        if !pieces[i].held {
            open.push(pieces[i]);
            i += 1;
            continue;
        }
        let mut end = i;
        while end < pieces.len() && pieces[end].held {
            end += 1;
        }
        let run = &pieces[i..end];
        let (from, to) = (run[0].from, run[run.len() - 1].to);
        let after = if open.is_empty() && !at_begin { 0.0 } else { margin };
        let before = if end == pieces.len() { 0.0 } else { margin };
        if to - from < after + before + step {
            open.extend_from_slice(run);
        } else {
            if after > 0.0 {
                open.extend(clipped(run, from, from + after));
                close(&mut regions, &mut open);
            }
            if before > 0.0 {
                open.extend(clipped(run, to - before, to));
            }
        }
        at_begin = false;
        i = end;
    }
    close(&mut regions, &mut open);
    // A straight path has a law that nothing can improve.
    regions.retain(|r| {
        r.from == 0.0 && moving
            || r.pieces.iter().any(|p| path.cells[p.cell].limits.bounds.second.max_abs() > 0.0 && !p.held)
    });
    regions
}

fn close(regions: &mut Vec<Region>, open: &mut Vec<Piece>) {
    let pieces = std::mem::take(open);
    if let (Some(first), Some(last)) = (pieces.first(), pieces.last()) {
        regions.push(Region { from: first.from, to: last.to, pieces });
    }
}

fn clipped(run: &[Piece], from: f64, to: f64) -> impl Iterator<Item = Piece> {
    run.iter()
        .map(move |p| Piece { from: p.from.max(from), to: p.to.min(to), ..*p })
        .filter(|p| p.to > p.from)
}

fn pieces(path: &Path, law: &Law, cells: usize) -> Vec<Piece> {
    let mut out = Vec::with_capacity(cells + law.phases.len());
    let mut cursor = Cursor::default();
    let (mut phase, mut from) = (0, 0.0);
    for cell in 0..cells {
        let c = &path.cells[cell];
        let end = if cell + 1 == cells { law.planned } else { law.planned_time_at(c.s1, &mut cursor) };
        while from < end && phase < law.phases.len() {
            let p = &law.phases[phase];
            let phase_end = if phase + 1 == law.phases.len() { law.planned } else { p.time + p.duration };
            let to = phase_end.min(end);
            let cruise = p.start.a == 0.0 && p.start.j == 0.0;
            let held = cruise && c.tight == 1.0 && p.start.v >= AT_SPEED * c.limits.steady;
            if to > from {
                out.push(Piece { from, to, cell, held });
            }
            from = from.max(to);
            if phase_end <= end {
                phase += 1;
            } else {
                break;
            }
        }
    }
    out
}

/// Evaluates joints on the rounded path, once at a place.
struct Probe<'a> {
    path: &'a Path,
    frame: &'a Frame<'a>,
    law: &'a Law,
    cursor: Cursor,
    span: usize,
    last: Option<(usize, f64, JointJet)>,
}

impl Probe<'_> {
    /// Derivatives by the law's own time, over the limits, and one over the highest square of the tempo.
    fn rows(&mut self, cell: usize, p: f64, rows: &mut [JointRow; MAX_JOINTS]) -> f64 {
        let x = self.law.planned_at(p, &mut self.cursor);
        let jet = match self.last {
            // The same place, seen from the other side of a border that the path does not know.
            Some((c, s, jet)) if c == cell && (x.s - s).abs() <= 1e-5 * x.v * INTERVAL[0] => jet,
            _ => {
                let task = self.path.rounded(x.s, &mut self.span);
                self.frame.kinematics.joints(&task)
            }
        };
        self.last = Some((cell, x.s, jet));
        let (q1, q2, q3) = (jet.first(), jet.second(), jet.third());
        let c = &self.path.cells[cell];
        let l = self.frame.limits;
        let velocity = if c.limits.rapid { &l.rapid } else { &l.velocity };
        let mut speed = (x.v / c.limits.feed).powi(2);
        for i in 0..l.count {
            let d1 = q1[i] * x.v;
            let d2 = q1[i] * x.a + q2[i] * x.v * x.v;
            let d3 = q1[i] * x.j + 3.0 * q2[i] * x.v * x.a + q3[i] * x.v * x.v * x.v;
            speed = speed.max((d1 / velocity[i]).powi(2));
            let (a, j) = (c.tight / l.acceleration[i], c.tight / l.jerk[i]);
            rows[i] = [0.5 * d1 * a, d2 * a, 0.5 * d1 * j, 1.5 * d2 * j, d3 * j];
        }
        speed
    }
}

/// Grid and rows of a region.
pub(super) fn problem(path: &Path, frame: &Frame<'_>, law: &Law, region: &Region, step: f64, fixed: [bool; 2]) -> Problem {
    let knots = knots(region, step);
    let mut problem = Problem { fixed, ..Problem::default() };
    problem.lengths = knots.windows(2).map(|w| w[1] - w[0]).collect();
    let mut probe = Probe { path, frame, law, cursor: Cursor::default(), span: 0, last: None };
    let mut all: Vec<[JointRow; MAX_JOINTS]> = Vec::new();
    let mut used = [false; MAX_JOINTS];
    let mut k = 0;
    let last = problem.lengths.len() - 1;
    for piece in &region.pieces {
        let mut from = piece.from;
        while from < piece.to {
            while k < last && knots[k + 1] <= from {
                k += 1;
            }
            let border = if k == last { piece.to } else { piece.to.min(knots[k + 1]) };
            // Where the speed changes much within an interval, next to a rest above all, its borders say little about what
            // lies between them.
            let [a, b] = [from, border].map(|p| probe.law.planned_at(p, &mut probe.cursor));
            let change = a.a.abs().max(b.a.abs()) * (border - from) / a.v.min(b.v).max(1e-9);
            let parts = (change / CHANGE).ceil().clamp(1.0, PARTS);
            let to = if parts > 1.0 { border.min(from + (border - from) / parts) } else { border };
            let length = to - from;
            if length > 1e-9 * step {
                for part in [INSIDE, 1.0 - INSIDE] {
                    let p = from + part * length;
                    let tau = ((p - knots[k]) / problem.lengths[k]).clamp(0.0, 1.0);
                    let mut rows = [[0.0; 5]; MAX_JOINTS];
                    let mut speed = probe.rows(piece.cell, p, &mut rows);
                    let near = [fixed[0] && k == 0, fixed[1] && k == last];
                    if near[0] || near[1] || piece.held {
                        speed *= 1.0 - RELAXED;
                        rows.iter_mut().flatten().for_each(|r| *r *= 1.0 - RELAXED);
                    }
                    if near[0] && tau < 0.01 || near[1] && tau > 0.99 {
                        // Given by both fixed coefficients: nothing can be done about it here.
                        speed = 0.0;
                        rows.iter_mut().for_each(|r| (r[0], r[1]) = (0.0, 0.0));
                    }
                    for (used, row) in used.iter_mut().zip(&rows) {
                        *used |= row.iter().any(|r| *r != 0.0);
                    }
                    let basis = problem.basis(k, tau);
                    problem.nodes.push(Node { k, basis, weight: 0.5 * length, speed });
                    all.push(rows);
                }
            }
            from = to;
        }
    }
    problem.count = used.iter().filter(|u| **u).count();
    problem.joints.reserve(problem.count * all.len());
    for rows in &all {
        problem.joints.extend(rows.iter().zip(&used).filter(|(_, used)| **used).map(|(row, _)| *row));
    }
    problem
}

/// Borders of the intervals: those of pieces that are not too close, and equal parts between them.
fn knots(region: &Region, step: f64) -> Vec<f64> {
    let mut coarse = vec![region.from];
    let least = SHORTEST * step;
    for piece in &region.pieces {
        if piece.to - coarse[coarse.len() - 1] >= least && region.to - piece.to >= least {
            coarse.push(piece.to);
        }
    }
    coarse.push(region.to);
    let mut knots = vec![region.from];
    for w in coarse.windows(2) {
        let n = ((w[1] - w[0]) / step).ceil().max(1.0) as usize;
        for i in 1..n {
            knots.push(w[0] + (w[1] - w[0]) * i as f64 / n as f64);
        }
        knots.push(w[1]);
    }
    knots
}
