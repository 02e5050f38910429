//! The search of a row through cells: near the tilts of the program, in finer cells about what was found,
//! with the ends of the best start.

use super::cells::{Cell, StationCells};
use super::freedom::Freedom;
use super::ground::{BAND, Ground};
use super::joints::Angles;
use super::local::Rectangles;
use super::{
    KEPT, RescheduleError, RowContext, RowEnds, RowSchedule, ScheduleOrigin, SmoothRows, VELOCITY_GIVEN, chosen,
    put_ends,
};

/// How often rectangles are grown again.
const ROUNDS: usize = 3;
/// By how much the rules of a bull-nose are taken narrower, as a part of their limits, in the order in which
/// it is tried: between stations nothing is known.
const MARGINS: [f64; 3] = [0.01, 0.025, 0.05];

/// What was planned through cells.
struct CellSchedules {
    /// Schedules with the joints at rest at the ends, where that is possible, and without: of all
    /// rounds those with the least effort.
    angles: Vec<Vec<Angles>>,
    /// Gates of turn and tilt at the blocks in the last round.
    gates: [Vec<[f64; 2]>; 2],
}

/// Ends of a row that are given: where it begins, and where it may end.
struct GivenEnds {
    first: Angles,
    last: Vec<Angles>,
}

impl SmoothRows {
    /// Looks through cells for schedules that keep all limits.
    ///
    /// # Errors
    /// Why nothing is possible, where nothing was found before either.
    pub(super) fn search(
        &self,
        work: &RowContext<'_>,
        course: &[Angles],
        freedom: &Freedom<'_>,
        found: &mut Vec<RowSchedule>,
    ) -> Result<(), RescheduleError> {
        let margins = if work.row.rules.is_some() { &MARGINS[..] } else { &[0.0] };
        let mut refused = None;
        let mut ground = None;
        // Near the tilts of the program first: elsewhere it is looked where the schedule wants to go on
        // there.
        for band in [Some(BAND), None] {
            let near = Ground::new(work, freedom, course, band)?;
            let ends = self.kept_ends(work, course, freedom, &near);
            let before = found.len();
            let mut left = false;
            for margin in margins {
                match work.planned(freedom, ends.as_ref(), (&near, *margin)) {
                    Ok(planned) => {
                        left = planned.angles.iter().flatten().any(|q| near.at_cut(q[1]));
                        refused = None;
                        if work.add(planned, freedom, found) {
                            break;
                        }
                    }
                    Err(e) => refused = Some(e),
                }
            }
            let some = found.len() > before;
            let done = !near.is_cut() || some && !left;
            if some || ground.is_none() {
                ground = Some(near);
            }
            if done {
                break;
            }
        }
        let (Some(best), Some(ground)) = (chosen(found.clone()), ground) else {
            return refused.map_or(Ok(()), Err);
        };
        if self.ends == RowEnds::Free {
            // What another schedule gains may be in its ends: lifts and rapids lead to them.
            self.between_its_ends(work, freedom, (&best, &ground), found);
        }
        if work.row.rules.is_none() {
            self.finer(work, course, freedom, &ground, found);
        }
        Ok(())
    }

    /// The program's own ends, where they stay: the last axis by both branches, whole turns apart.
    fn kept_ends(
        &self,
        work: &RowContext<'_>,
        course: &[Angles],
        freedom: &Freedom<'_>,
        ground: &Ground,
    ) -> Option<GivenEnds> {
        let (RowEnds::Kept, Some(first), Some(axis)) = (self.ends, course.first(), freedom.own.last()) else {
            return None;
        };
        let ranges = ground.scales.map(|s| [s.edge(0), s.edge(s.count)]);
        let mut last = work.joints.all(axis, ranges);
        if last.is_empty() {
            last.extend(course.last());
        }
        Some(GivenEnds { first: *first, last })
    }

    /// The smoothest schedules, and even ones, between the ends of one that was no result of the search.
    fn between_its_ends(
        &self,
        work: &RowContext<'_>,
        freedom: &Freedom<'_>,
        (best, ground): (&RowSchedule, &Ground),
        found: &mut Vec<RowSchedule>,
    ) {
        let Some([first, last]) = best.ends() else { return };
        found.extend(self.between_ends(work, freedom, &best.angles));
        if best.origin != ScheduleOrigin::Given {
            return;
        }
        let ends = GivenEnds { first, last: vec![last] };
        let margins = if work.row.rules.is_some() { &MARGINS[..] } else { &[0.0] };
        for margin in margins {
            let planned = work.planned(freedom, Some(&ends), (ground, *margin));
            if planned.is_ok_and(|planned| work.add(planned, freedom, found)) {
                break;
            }
        }
    }

    /// Looks again in finer cells about the best that was found: cells that lie across a border are not free,
    /// so that coarse ones make narrow places narrower.
    fn finer(
        &self,
        work: &RowContext<'_>,
        course: &[Angles],
        freedom: &Freedom<'_>,
        coarse: &Ground,
        found: &mut Vec<RowSchedule>,
    ) {
        let Some(best) = chosen(found.clone()).filter(|best| best.origin != ScheduleOrigin::Even) else { return };
        let ground = Ground::about(work, freedom, &best.angles, coarse.scales);
        let ends = self.kept_ends(work, course, freedom, &ground);
        if let Ok(planned) = work.planned(freedom, ends.as_ref(), (&ground, 0.0)) {
            work.add(planned, freedom, found);
        }
    }
}

impl RowContext<'_> {
    /// What of a plan is free, and what follows from it in the times of the control; false where nothing is.
    fn add(&self, planned: CellSchedules, freedom: &Freedom<'_>, found: &mut Vec<RowSchedule>) -> bool {
        let before = found.len();
        let free = planned.angles.into_iter().filter(|angles| freedom.is_free(angles));
        found.extend(free.map(|angles| self.tried(angles, ScheduleOrigin::Search)));
        let some = found.len() > before;
        if some {
            found.extend(self.with_control(&planned.gates, found, freedom));
        }
        some
    }

    /// The way through the cells and the smoothest schedules round it, from an angle to one of some others
    /// where the ends are given.
    fn planned(
        &self,
        freedom: &Freedom<'_>,
        ends: Option<&GivenEnds>,
        (ground, margin): (&Ground, f64),
    ) -> Result<CellSchedules, RescheduleError> {
        let Ground { scales, nodes, .. } = ground;
        let cells = ground.cells(margin);
        let times: Vec<f64> = nodes.windows(2).map(|p| self.least[p[0]..p[1]].iter().sum()).collect();
        let velocities = self.limits.map(|[v, _]| if v.is_finite() { v } else { std::f64::consts::PI });
        let cell = |q: &Angles| -> Cell { [0, 1].map(|j| scales[j].cell(q[j])) };
        let first = ends.map(|e| [cell(&e.first)]);
        let last: Option<Vec<Cell>> = ends.map(|e| e.last.iter().map(cell).collect());
        let way = cells
            .way(first.as_ref().map(|c| &c[..]), last.as_deref(), &times, velocities)
            .map_err(|closed| self.closed(closed, nodes, freedom, ends.is_some()))?;
        let end = ends.and_then(|e| {
            let off = |q: &Angles| usize::from(way.last() != Some(&cell(q)));
            e.last.iter().copied().min_by_key(off)
        });
        let fixed = [ends.map(|e| e.first), end];
        let mut rectangles: Vec<[Cell; 2]> = way.windows(2).map(|w| [w[0], w[1]]).collect();
        let mut planned = CellSchedules { angles: Vec::new(), gates: [Vec::new(), Vec::new()] };
        let mut least: [Option<(f64, Vec<Angles>)>; 2] = [None, None];
        for _ in 0..ROUNDS {
            for (stretch, rectangle) in rectangles.iter_mut().enumerate() {
                *rectangle = cells.grown(stretch, *rectangle);
            }
            let gates = gates(&cells, &rectangles, nodes, fixed);
            let within = Rectangles { gates: &gates, limits: self.limits };
            let mut next = None;
            for (least, rest) in least.iter_mut().zip([true, false]) {
                let Some(mut angles) = within.smoothest(self.least, rest, VELOCITY_GIVEN[0]) else { continue };
                put_ends(&mut angles, fixed);
                let effort = self.effort(&angles);
                if least.as_ref().is_none_or(|(most, _)| effort < *most) {
                    *least = Some((effort, angles.clone()));
                }
                next = Some(angles);
            }
            planned.gates = gates;
            let Some(angles) = next else { break };
            for (stretch, pair) in nodes.windows(2).enumerate() {
                let [mut low, mut high] = [cell(&angles[pair[0]]); 2];
                for q in &angles[pair[0]..=pair[1]] {
                    let c = cell(q);
                    (low, high) = ([low[0].min(c[0]), low[1].min(c[1])], [high[0].max(c[0]), high[1].max(c[1])]);
                }
                if cells.is_free(stretch, [low, high]) {
                    rectangles[stretch] = [low, high];
                }
            }
        }
        planned.angles = least.into_iter().flatten().map(|(_, angles)| angles).collect();
        Ok(planned)
    }
}

/// Gates at the blocks from rectangles of the stretches between nodes, with ends that are fixed.
fn gates(
    cells: &StationCells,
    rectangles: &[[Cell; 2]],
    nodes: &[usize],
    fixed: [Option<Angles>; 2],
) -> [Vec<[f64; 2]>; 2] {
    let n = nodes.last().copied().unwrap_or(0) + 1;
    let mut gates = [vec![[f64::NEG_INFINITY, f64::INFINITY]; n], vec![[f64::NEG_INFINITY, f64::INFINITY]; n]];
    for (rectangle, pair) in rectangles.iter().zip(nodes.windows(2)) {
        let limits = cells.limits(*rectangle);
        for i in pair[0]..=pair[1] {
            for (gates, [low, high]) in gates.iter_mut().zip(limits) {
                gates[i] = [gates[i][0].max(low), gates[i][1].min(high)];
            }
        }
    }
    for (i, end) in [0, n - 1].into_iter().zip(fixed) {
        let Some(q) = end else { continue };
        for (gates, q) in gates.iter_mut().zip(q) {
            gates[i] = [q - KEPT, q + KEPT];
        }
    }
    gates
}
