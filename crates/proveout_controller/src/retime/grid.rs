//! Cuts the time of a first law into regions and grids, and evaluates the joints there.

use proveout_machine::MAX_JOINTS;

use super::{
    cap::{Cap, Caps, inner_points},
    field::Field,
    problem::{JointRow, MARGIN, Problem, TempoNode, joint_row},
};
use crate::{
    jet::JointJet,
    path::{PathCell, PathContext, RunPath, WayMeasure},
    profile::{Cursor, Law},
};

/// Longest interval as part of the time that a joint needs from zero to its full acceleration.
const FINEST: f64 = 1.0 / 12.0;
/// The same in seconds where no joint limits both, and the range in any case.
const INTERVAL: [f64; 3] = [0.001, 0.004, 0.02];
/// Interval at low speed as part of the longest.
const SLOWEST: f64 = 0.35;
/// What a border of pieces must be apart from the next to be a knot, as part of the longest interval. At a
/// border the jerk of the first law jumps, by b^(3/2) times as much in the law that is looked for, and b''
/// can make up for it at knots alone: where b is ten, a border within an interval closes the way to fast laws
/// (a border in 0.2 of an interval left out cost 7 to 12 percent on four of 20 curves).
const SHORTEST: f64 = 0.02;
/// Intervals by which a region reaches into stretches that run at the highest speed already.
const INTO_HELD: f64 = 5.0;
/// Speed along the path that counts as the highest, as part of it.
const AT_SPEED: f64 = 0.996;
/// Part of a piece by which points are moved off its borders, so that each belongs to one side of a
/// jump.
const INSIDE: f64 = 1e-6;
/// Difference of rows of acceleration on both sides of a border that is no jump but the way between the two
/// nodes.
const ALIKE: f64 = 1e-5;
/// Interval as part of the time sqrt(v/J) in which the jerk limit changes a speed v by its own size.
const SLOW: f64 = 0.2;
/// Excess between two points of an interval that needs points between them, and the most parts.
const BETWEEN: f64 = 0.004;
const PARTS: f64 = 4.0;
/// Two places are one where the way between them takes less than this part of the shortest interval.
const SAME_PLACE: f64 = 1e-5;
/// A piece of an interval that is shorter than this part of the step is rounding of its ends.
const NO_PIECE: f64 = 1e-9;
/// Largest speed over jerk that counts, s2: where no jerk is limited it is infinite.
const MOST_PACE: f64 = 1e9;

/// Time between neighboring borders of phases and cells.
#[derive(Clone, Copy, Debug)]
struct PhaseInterval {
    from: f64,
    to: f64,
    cell: usize,
    held: bool,
    /// Square of the time in which the jerk limit changes the speed by its own size: v/J at the slower end,
    /// s^2.
    pace: f64,
}

/// A stretch of time whose tempo is free.
#[derive(Debug)]
pub(super) struct Region {
    pub(super) from: f64,
    pub(super) to: f64,
    pieces: Vec<PhaseInterval>,
}

/// A place where a control sample passed a limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitExcess {
    /// Time of the first law.
    pub(crate) at: f64,
    /// Part by which b must fall there.
    pub(crate) excess: f64,
    /// Time of the first law over which it may fall, to either side.
    pub(crate) width: f64,
}

/// Highest factor of the spots in an interval; `spots` are in the order of time.
fn tight(spots: &[LimitExcess], from: f64, to: f64) -> f64 {
    let first = spots.partition_point(|s| s.at < from);
    spots[first..].iter().take_while(|s| s.at <= to).fold(1.0, |m, s| m.max(1.0 + s.excess))
}

/// Longest interval, s.
fn interval(frame: &PathContext<'_>) -> f64 {
    let l = frame.limits;
    let rise = (0..l.count).map(|i| l.acceleration[i] / l.jerk[i]).filter(|t| t.is_finite() && *t > 0.0);
    let least = rise.fold(f64::INFINITY, f64::min);
    let [low, usual, high] = INTERVAL;
    if least.is_finite() { (FINEST * least).clamp(low, high) } else { usual }
}

/// The stretches of the law's first `cells` cells where another tempo may be faster. `moving` says
/// whether the law begins with a given tempo that must be followed.
pub(super) fn regions(
    path: &RunPath,
    frame: &PathContext<'_>,
    law: &Law,
    cells: usize,
    moving: bool,
    spots: &[LimitExcess],
) -> Vec<Region> {
    let step = interval(frame);
    let pieces = pieces(path, frame, law, cells, spots);
    let mut regions: Vec<Region> = Vec::new();
    let mut open: Vec<PhaseInterval> = Vec::new();
    let margin = INTO_HELD * step;
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

impl Region {
    /// What is left of the region outside of some stretches, which rise and do not overlap.
    pub(super) fn without(&self, cuts: &[[f64; 2]]) -> Vec<Self> {
        let (mut rest, mut from) = (Vec::new(), self.from);
        let end = [self.to, self.to];
        for [begin, behind] in cuts.iter().chain(std::iter::once(&end)) {
            let to = begin.min(self.to);
            if to > from {
                let pieces: Vec<PhaseInterval> = clipped(&self.pieces, from, to).collect();
                rest.push(Self { from, to, pieces });
            }
            from = from.max(*behind);
        }
        rest
    }
}

fn close(regions: &mut Vec<Region>, open: &mut Vec<PhaseInterval>) {
    let pieces = std::mem::take(open);
    if let (Some(first), Some(last)) = (pieces.first(), pieces.last()) {
        regions.push(Region { from: first.from, to: last.to, pieces });
    }
}

fn clipped(run: &[PhaseInterval], from: f64, to: f64) -> impl Iterator<Item = PhaseInterval> {
    run.iter().map(move |p| PhaseInterval { from: p.from.max(from), to: p.to.min(to), ..*p }).filter(|p| p.to > p.from)
}

/// Highest jerk along the path that the joints allow on a straight line of the cell's direction.
pub(crate) fn jerk_along(frame: &PathContext<'_>, cell: &PathCell) -> f64 {
    let first = &cell.limits.bounds.first;
    (0..frame.limits.count)
        .filter(|i| first[*i] > 0.0)
        .map(|i| frame.limits.jerk[i] / first[i])
        .fold(f64::INFINITY, f64::min)
}

fn pieces(
    path: &RunPath,
    frame: &PathContext<'_>,
    law: &Law,
    cells: usize,
    spots: &[LimitExcess],
) -> Vec<PhaseInterval> {
    let mut out = Vec::with_capacity(cells + law.phases.len());
    let mut cursor = Cursor::default();
    let (mut phase, mut from) = (0, 0.0);
    for cell in 0..cells {
        let c = &path.cells[cell];
        let jerk = jerk_along(frame, c);
        let end = if cell + 1 == cells { law.planned } else { law.planned_time_at(c.s1, &mut cursor) };
        while from < end && phase < law.phases.len() {
            let p = &law.phases[phase];
            let phase_end = if phase + 1 == law.phases.len() { law.planned } else { p.time + p.duration };
            let to = phase_end.min(end);
            let cruise = p.start.a == 0.0 && p.start.j == 0.0;
            let held = cruise && p.start.v >= AT_SPEED * c.limits.highest && tight(spots, from, to) == 1.0;
            if to > from {
                let v = [from, to].map(|t| p.at((t - p.time).clamp(0.0, p.duration)).v);
                out.push(PhaseInterval { from, to, cell, held, pace: v[0].min(v[1]) / jerk });
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
pub(super) struct Probe<'a> {
    path: &'a RunPath,
    frame: &'a PathContext<'a>,
    law: &'a Law,
    cursor: Cursor,
    span: usize,
    last: Option<(usize, f64, JointJet, [f64; 2])>,
}

impl<'a> Probe<'a> {
    pub(super) fn new(path: &'a RunPath, frame: &'a PathContext<'a>, law: &'a Law) -> Self {
        Self { path, frame, law, cursor: Cursor::default(), span: 0, last: None }
    }

    /// Rows of some joints.
    pub(super) fn rows_of(&mut self, used: &[usize], cell: usize, p: f64) -> Vec<JointRow> {
        let (rows, _) = self.rows(cell, p);
        used.iter().map(|i| rows[*i]).collect()
    }

    /// Derivatives by the law's own time, over the limits, and what the squares of feed and joint velocities
    /// are of their limits.
    fn rows(&mut self, cell: usize, p: f64) -> ([JointRow; MAX_JOINTS], Caps) {
        let mut rows = [[0.0_f32; 5]; MAX_JOINTS];
        let mut caps = [Cap::default(); MAX_JOINTS + 1];
        let x = self.law.planned_at(p, &mut self.cursor);
        let c = &self.path.cells[cell];
        let (jet, [rate, bend]) = match self.last {
            // The same place, seen from the other side of a border that the path does not know.
            Some((c, s, jet, rate)) if c == cell && (x.s - s).abs() <= SAME_PLACE * x.v * INTERVAL[0] => (jet, rate),
            _ => {
                let kinematics = &self.frame.kinematics;
                match &c.joints {
                    Some(joints) if c.limits.way == WayMeasure::Parameter => (joints.jet(x.s), [1.0, 0.0]),
                    joints => {
                        let task = self.path.rounded(x.s, &mut self.span);
                        let jet = joints.as_ref().map_or_else(|| kinematics.joints(&task), |own| own.jet(x.s));
                        (jet, c.limits.way.rate(kinematics.machine, &task))
                    }
                }
            }
        };
        self.last = Some((cell, x.s, jet, [rate, bend]));
        let (q1, q2, q3) = (jet.first(), jet.second(), jet.third());
        let l = self.frame.limits;
        let velocity = if c.limits.rapid { &l.rapid } else { &l.velocity };
        caps[MAX_JOINTS] = Cap::of([rate * x.v, rate * x.a + bend * x.v * x.v], c.limits.feed);
        for i in 0..l.count {
            let d1 = q1[i] * x.v;
            let d2 = q1[i] * x.a + q2[i] * x.v * x.v;
            let d3 = q1[i] * x.j + 3.0 * q2[i] * x.v * x.a + q3[i] * x.v * x.v * x.v;
            caps[i] = Cap::of([d1, d2], velocity[i]);
            let (a, j) = ((1.0 + MARGIN) / l.acceleration[i], (1.0 + MARGIN) / l.jerk[i]);
            rows[i] = joint_row([0.5 * d1 * a, d2 * a, 0.5 * d1 * j, 1.5 * d2 * j, d3 * j]);
        }
        (rows, caps)
    }
}

/// Grid and rows of a region.
pub(super) fn field(probe: &mut Probe<'_>, region: &Region, fixed: [bool; 2], spots: &[LimitExcess]) -> Field {
    let step = interval(probe.frame);
    let knots = knots(region, step);
    let lengths: Vec<f64> = knots.windows(2).map(|w| w[1] - w[0]).collect();
    let used = moving(probe, region);
    let begins = knots.clone();
    let problem = Problem { fixed, lengths, begins, scale: step, count: used.len(), used, ..Problem::default() };
    let field = Field::new(problem);
    let mut grid =
        FieldBuilder { tight: 1.0, smooth: 0, cell: 0, field, nodes: Vec::new(), joints: Vec::new(), caps: Vec::new() };
    let mut k = 0;
    let last = knots.len() - 2;
    for piece in &region.pieces {
        let mut from = piece.from;
        while from < piece.to {
            while k < last && knots[k + 1] <= from {
                k += 1;
            }
            let to = if k == last { piece.to } else { piece.to.min(knots[k + 1]) };
            let length = to - from;
            if length > NO_PIECE * step {
                let tau = |part: f64| ((from + part * length - knots[k]) / (knots[k + 1] - knots[k])).clamp(0.0, 1.0);
                let begin = probe.rows(piece.cell, from + INSIDE * length);
                // Between borders alone the acceleration could pass its limit by J h/4, at the middle by a
                // quarter of that at most. Between points the jerk may pass its line by 4.5 h^2 b'' q'''/8
                // with q' b''/2 and q''' up to the limit. Within a blend the third derivative of the path
                // runs from one sign to the other and back.
                let fewest = if probe.path.cells[piece.cell].exact { 2.0 } else { 3.0 };
                let most = length * length / piece.pace.min(MOST_PACE);
                let parts = (most / BETWEEN).sqrt().ceil().clamp(fewest, PARTS) as usize;
                let weight = length / parts as f64;
                (grid.cell, grid.smooth) = (piece.cell, grid.smooth + 1);
                grid.tight = tight(spots, knots[k], knots[k + 1]);
                grid.add(k, tau(INSIDE), 0.5 * weight, begin);
                for i in 1..parts {
                    let part = i as f64 / parts as f64;
                    let rows = probe.rows(piece.cell, from + part * length);
                    grid.add(k, tau(part), weight, rows);
                }
                let end = probe.rows(piece.cell, to - INSIDE * length);
                grid.add(k, tau(1.0 - INSIDE), 0.5 * weight, end);
            }
            from = to;
        }
    }
    grid.close();
    grid.field
}

/// Joints that move anywhere in a region.
fn moving(probe: &Probe<'_>, region: &Region) -> Vec<usize> {
    let mut moves = [false; MAX_JOINTS];
    for piece in &region.pieces {
        let b = &probe.path.cells[piece.cell].limits.bounds;
        for (i, moves) in moves.iter_mut().enumerate().take(probe.frame.limits.count) {
            *moves |= [&b.first, &b.second, &b.third].iter().any(|bound| bound[i] != 0.0);
        }
    }
    (0..MAX_JOINTS).filter(|i| moves[*i]).collect()
}

/// A field under construction.
struct FieldBuilder {
    /// Factor of the rows of the interval under way.
    tight: f64,
    /// Cell under way, and number of the smooth stretch within an interval.
    cell: usize,
    smooth: u32,
    field: Field,
    /// Nodes of the interval under way, with their rows and caps.
    nodes: Vec<TempoNode>,
    joints: Vec<JointRow>,
    caps: Vec<Caps>,
}

impl FieldBuilder {
    fn add(&mut self, k: usize, tau: f64, weight: f64, (rows, caps): ([JointRow; MAX_JOINTS], Caps)) {
        if self.nodes.last().is_some_and(|last| last.k != k) {
            self.close();
        }
        let (cell, smooth, tight) = (self.cell, self.smooth, self.tight);
        self.nodes.push(TempoNode { k, tau, cell, smooth, twin: false, weight, speed: 0.0, lead: 0.0 });
        let used = &self.field.whole().used;
        self.joints.extend(
            used.iter().map(|i| if tight > 1.0 { joint_row(rows[*i].map(|r| f64::from(r) * tight)) } else { rows[*i] }),
        );
        self.caps.push(if tight > 1.0 { caps.map(|cap| cap.tightened(tight)) } else { caps });
    }

    /// Ends an interval: limits its two inner control points, so that b passes no speed.
    fn close(&mut self) {
        let nodes = &mut self.nodes;
        let Some(k) = nodes.first().map(|node| node.k) else { return };
        let length = self.field.whole().lengths[k];
        let [begin, behind] = inner_points(nodes, &self.caps, length);
        let third = length / 3.0;
        (nodes[0].speed, nodes[0].lead) = (begin, third);
        let last = nodes.len() - 1;
        (nodes[last].speed, nodes[last].lead) = (behind, -third);
        self.field.push(nodes, &self.joints, ALIKE);
        self.nodes.clear();
        self.joints.clear();
        self.caps.clear();
    }
}

/// Borders of the intervals: those of pieces that are not too close, and equal parts between them.
fn knots(region: &Region, step: f64) -> Vec<f64> {
    let mut knots = vec![region.from];
    let least = SHORTEST * step;
    let (mut from, mut pace) = (region.from, f64::INFINITY);
    for piece in &region.pieces {
        pace = pace.min(piece.pace);
        let long_enough = piece.to - from >= least && region.to - piece.to >= least;
        if !long_enough && piece.to < region.to {
            continue;
        }
        let local = (SLOW * pace.sqrt()).clamp(SLOWEST * step, step);
        let n = ((piece.to - from) / local).ceil().max(1.0) as usize;
        for i in 1..n {
            knots.push(from + (piece.to - from) * i as f64 / n as f64);
        }
        knots.push(piece.to);
        (from, pace) = (piece.to, f64::INFINITY);
    }
    knots
}
