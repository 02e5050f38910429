//! Schedules that a row may have without any search: what is handed out is never slower for the control than
//! one of these that is free.

use super::super::super::{Method, MinAngularAcceleration, Singularity};
use super::freedom::Freedom;
use super::ground::BESIDE;
use super::joints::{Angles, one_turn};
use super::local::Rectangles;
use super::{KEPT, RowContext, RowEnds, RowSchedule, ScheduleOrigin, SmoothRows, VELOCITY_GIVEN, put_ends};

/// Axes nearer than this are the same, radian.
const SAME_AXIS: f64 = 1e-6;

impl SmoothRows {
    /// The program before, what published methods for such rows make of it, and even turns between its ends,
    /// as far as the ends keep what they must and every block is free.
    pub(super) fn starts(&self, work: &RowContext<'_>, course: &[Angles], freedom: &Freedom<'_>) -> Vec<RowSchedule> {
        let mut all = vec![(ScheduleOrigin::Given, course.to_vec())];
        all.extend(self.published(work, course).into_iter().map(|angles| (ScheduleOrigin::Given, angles)));
        if let (Some(first), Some(axis)) = (course.first(), freedom.own.last()) {
            // Both branches of the last axis, whole turns apart.
            let turns = course.iter().map(|q| q[0]);
            let low = turns.clone().fold(f64::INFINITY, f64::min) - BESIDE;
            let high = turns.fold(f64::NEG_INFINITY, f64::max) + BESIDE;
            let [least, most] = work.joints.travel(0).unwrap_or([low, high]);
            let ranges = [[low.max(least), high.min(most)], one_turn(work.joints.travel(1))];
            // The nearer branch, as ways through cells would take it.
            let speed = |q: &Angles| -> f64 {
                let part = |j: usize| if work.limits[j][0].is_finite() { work.limits[j][0] } else { 1.0 };
                (0..2).map(|j| ((q[j] - first[j]) / part(j)).powi(2)).sum()
            };
            let nearest = work.joints.all(axis, ranges).into_iter().min_by(|a, b| speed(a).total_cmp(&speed(b)));
            let made = nearest.into_iter().flat_map(|last| evens(work, [*first, last]));
            all.extend(made.map(|angles| (ScheduleOrigin::Even, angles)));
        }
        free(work, freedom, all)
    }

    /// Even turns between the ends of a schedule, where these may move.
    pub(super) fn between_ends(
        &self,
        work: &RowContext<'_>,
        freedom: &Freedom<'_>,
        angles: &[Angles],
    ) -> Vec<RowSchedule> {
        let (Some(first), Some(last), RowEnds::Free) = (angles.first(), angles.last(), self.ends) else {
            return Vec::new();
        };
        free(
            work,
            freedom,
            evens(work, [*first, *last]).into_iter().map(|angles| (ScheduleOrigin::Even, angles)).collect(),
        )
    }

    fn published(&self, work: &RowContext<'_>, course: &[Angles]) -> Vec<Vec<Angles>> {
        let made = |method: &dyn Method| {
            let made = method.reschedule(work.run, work.around).ok()?;
            Some((made.poses, made.rotary))
        };
        let methods = match work.row.rules {
            Some(_) => {
                let poses = work.row.by_strip_and_roughness(&self.rules, work.run, work.around);
                vec![poses.map(|poses| (poses, None))]
            }
            None => vec![made(&Singularity::default()), made(&MinAngularAcceleration::default())],
        };
        let mut out = Vec::new();
        for (poses, rotary) in methods.into_iter().flatten() {
            let angles = match rotary {
                Some(rotary) => Ok(rotary.iter().map(|q| work.joints.of(q)).collect()),
                None => work.joints.course(work.run, poses.iter().map(|p| &p.axis)),
            };
            let own = angles.ok().and_then(|a: Vec<Angles>| a.get(work.row.stretch.clone()).map(<[_]>::to_vec));
            let Some(angles) = own else { continue };
            let same = |i: usize| {
                let [a, b] = [&angles, course].map(|q: &[Angles]| q.get(i).map(|q| work.joints.axis(*q)));
                a.zip(b).is_some_and(|(a, b)| (a - b).norm() < SAME_AXIS)
            };
            if self.ends == RowEnds::Free || (same(0) && same(course.len() - 1)) {
                out.push(angles);
            }
        }
        out
    }
}

/// Those that are free, with their times.
fn free(work: &RowContext<'_>, freedom: &Freedom<'_>, all: Vec<(ScheduleOrigin, Vec<Angles>)>) -> Vec<RowSchedule> {
    let free = all.into_iter().filter(|(_, angles)| freedom.is_free(angles));
    free.map(|(origin, angles)| work.tried(angles, origin)).collect()
}

/// From one end to the other in proportion to time, and with ramps where the joints are at rest at
/// the ends.
pub(super) fn evens(work: &RowContext<'_>, [first, last]: [Angles; 2]) -> Vec<Vec<Angles>> {
    let total: f64 = work.least.iter().sum();
    let mut at = vec![0.0];
    at.extend(work.least.iter().scan(0.0, |sum, t| {
        *sum += t;
        Some(*sum / total)
    }));
    let even: Vec<Angles> = at.iter().map(|s| [0, 1].map(|j| first[j] + (last[j] - first[j]) * s)).collect();
    let gates = between([first, last], at.len());
    let ramped = Rectangles { gates: &gates, limits: work.limits }.smoothest(work.least, true, VELOCITY_GIVEN[0]);
    let ramped = ramped.map(|mut angles| {
        put_ends(&mut angles, [Some(first), Some(last)]);
        angles
    });
    [Some(even), ramped].into_iter().flatten().collect()
}

/// Gates of so many blocks that leave all there is between two ends, which are fixed.
pub(super) fn between([first, last]: [Angles; 2], count: usize) -> [Vec<[f64; 2]>; 2] {
    [0, 1].map(|j| {
        // A hair wider than both ends, so that no gate is empty.
        let mut gates = vec![[first[j].min(last[j]) - KEPT, first[j].max(last[j]) + KEPT]; count];
        for (gate, q) in [(0, first[j]), (count - 1, last[j])] {
            gates[gate] = [q - KEPT, q + KEPT];
        }
        gates
    })
}
