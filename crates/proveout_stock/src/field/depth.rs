//! How deep a body was in the material that it met.
//!
//! The longest overlap on a ray is no depth: a cutter that slides along a wall and shaves 1 um off
//! it overlaps with a ray along the wall over all of its height. The depth of a place that the body
//! has reached is its distance from the *opening*: the part of the earlier free surface that the
//! body has taken away. The depth of a motion is that of its deepest place.
//!
//! ```text
//!      ___________                ___________ free surface; the opening is dotted
//!     |   .   .   |              |      :|   |
//!     |   | d |   |              |      :|   |     chord on a ray along the wall: its whole height
//!     |   |___|   |              |      :|   |     the depth is the width of the shaving
//!     |___________|              |______ |___|
//!       plunge                     shaving
//! ```
//!
//! What the body takes up lies on rays of all three sets. An end of such an interval is a sample of the
//! opening where the material itself ended there, with the outward normal m of the material; otherwise it
//! lies on the skin of the swept body, where the depth is asked for. From the sample p that is nearest to x
//!
//! ```text
//!     depth of x = |m . (x - p)|   where p lies near the foot of x: within a cell and a half across m
//!                  |x - p|         elsewhere (beyond the rim of the opening)
//! ```
//!
//! Faces that are plane over a cell and a half give their exact distance at any resolution; a face
//! of curvature k is off by k (1.5 cell)² / 2 at most. Between two rays the skin can be deeper than
//! on them by the sagitta of the body over a cell. A rib that is cut through counts with its
//! thickness: where both ends of an interval are open its middle is measured, and counts twice
//! where the opening lies as far away on its other side. Where there is no opening at all, the
//! longest overlap is the depth.
//!
//! *What the body held when it began.* A ray that grazes the body may keep a chord left by the
//! previous item, within the bound of the sweep. The body has not entered there: chords that lie, at
//! their middle, no deeper below the skin of the body at its begin than that bound count with twice
//! that depth. (Along a chord the depth below a convex skin is concave and vanishes at the ends: at
//! most twice its value in the middle.)
//!
//! *Runs.* A rapid through material is many pieces, each of which meets but the layer that the one before has
//! left. Its depth is that in the material as it stood before its first piece: items with [`Measure::Since`]
//! put what they take together, and ends that items of the run have made are not open.

use std::collections::BTreeMap;

use proveout_geom::{Point, Vector};

use crate::{
    field::grid::RayGrid,
    field::span::{EndMark, INITIAL},
};

/// Against which material the depth of an item is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// It is not.
    #[default]
    No,
    /// As the item meets it.
    Alone,
    /// As it stood before the item with this id; ids of a run rise, and runs follow one another.
    Since(u32),
}

/// Depths of items, with the memory of the run under way; see [`Measure`].
#[derive(Clone, Debug, Default)]
pub struct Depths {
    /// Overlaps up to this length need no depth, mm.
    least: f64,
    pub(crate) since: Option<u32>,
    pub(crate) run: RunLaps,
    pub(crate) opening: Opening,
    /// Items of runs that were measured.
    pub(crate) taken: u64,
}

/// An interval that an item takes up on a ray, with the ends of the material that it reaches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLap {
    pub item: u32,
    /// Set, and numbers of the ray along u and v.
    pub ray: (u8, u32, u32),
    pub lo: f64,
    pub hi: f64,
    /// What made the end of the material that lies there; none where the skin of the body does.
    pub ends: [Option<EndMark>; 2],
}

/// Ends of what was taken, and which of them are open.
pub(crate) type OpenEnds = ([f64; 2], [bool; 2]);

/// What a run has taken, by ray, rising.
#[derive(Clone, Debug, Default)]
pub(crate) struct RunLaps(pub(crate) BTreeMap<(u8, u32, u32), Vec<OpenEnds>>);

/// Samples of the opening; the first `sorted` are a tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Opening {
    pub(crate) samples: Vec<(Point, Vector)>,
    pub(crate) sorted: usize,
}

/// Part of a cell across the normal within which a sample counts as near the foot of a point.
const BESIDE: f64 = 1.5;
/// Cosine of normals below which two faces count as those of a wall.
const OPPOSITE: f64 = -0.9;
/// Ends that lie this near to each other are one: one item has begun where the other has stopped, mm.
const JOIN: f64 = 1e-9;
/// Intervals of a single item that are looked at first; all only where these do not settle that it is deep.
const FIRST: usize = 1500;
/// Samples in a leaf of the tree, and the most that wait to be sorted in.
const LEAF: usize = 8;
const WAITING: usize = 512;

impl Depths {
    /// Overlaps up to `least` (mm) on every ray are not measured further: their length is their depth.
    pub fn new(least: f64) -> Self {
        Self { least, ..Self::default() }
    }

    /// Depth of one item, mm. `laps` are its intervals in a fixed order, `longest` the longest of them.
    ///
    /// `held` is the signed distance of a point from the body at the begin of the item, negative inside, and
    /// `bound` what an item may leave, mm.
    pub(crate) fn of_item(
        &mut self,
        grid: &RayGrid,
        measure: Measure,
        laps: &[RayLap],
        longest: f64,
        (held, bound): (impl Fn(&Point) -> f64, f64),
    ) -> f64 {
        if measure == Measure::No || measure == Measure::Alone && longest <= self.least {
            return longest;
        }
        let mut begun = 0.0_f64;
        let mut length = 0.0_f64;
        let entered: Vec<RayLap> = laps
            .iter()
            .filter(|lap| {
                let middle = held(&point(grid, lap.ray, 0.5 * (lap.lo + lap.hi)));
                let left = middle < 0.0 && middle >= -bound && lap.ends.iter().all(Option::is_none);
                if left {
                    begun = begun.max((-2.0 * middle).min(lap.hi - lap.lo));
                } else {
                    length = length.max(lap.hi - lap.lo);
                }
                !left
            })
            .copied()
            .collect();
        let rest = if entered.is_empty() { 0.0 } else { self.of_entered(grid, measure, &entered, length.min(longest)) };
        begun.max(rest)
    }

    fn of_entered(&mut self, grid: &RayGrid, measure: Measure, laps: &[RayLap], longest: f64) -> f64 {
        match measure {
            Measure::No => longest,
            Measure::Alone if longest <= self.least => longest,
            Measure::Alone => {
                let mut opening = Opening::default();
                laps.iter().for_each(|lap| opening.add(grid, lap, |_| true));
                opening.sort();
                let alone = |lap: &RayLap| ([lap.lo, lap.hi], lap.ends.map(|e| e.is_some()));
                let step = laps.len().div_ceil(FIRST).max(1);
                let few = opening.deepest(grid, laps.iter().step_by(step), alone);
                let depth = match few {
                    Some(d) if step == 1 || d > self.least => Some(d),
                    _ => opening.deepest(grid, laps.iter(), alone),
                };
                depth.unwrap_or(longest).min(longest)
            }
            Measure::Since(first) => {
                if self.since != Some(first) {
                    (self.since, self.run, self.opening) = (Some(first), RunLaps::default(), Opening::default());
                }
                self.taken += 1;
                let open = |mark: EndMark| mark.id == INITIAL || mark.id < first;
                for lap in laps {
                    self.run.add_lap(lap, open);
                    self.opening.add(grid, lap, open);
                }
                self.opening.sort();
                self.opening.deepest(grid, laps.iter(), |lap| self.run.at(lap)).unwrap_or(longest)
            }
        }
    }
}

impl Depths {
    /// Items of runs that were measured so far: as long as none follows, the memory stays as it is.
    pub fn taken(&self) -> u64 {
        self.taken
    }

    /// Bytes that the memory takes in a [`SweepLog`](crate::SweepLog), about.
    pub fn bytes(&self) -> u64 {
        (48 * self.opening.samples.len() + 24 * self.run.0.len()) as u64
    }
}

impl RunLaps {
    /// Adds an interval; `open` says whether an end was there before the run.
    fn add_lap(&mut self, lap: &RayLap, open: impl Fn(EndMark) -> bool) {
        let (mut new, mut ends) = ([lap.lo, lap.hi], lap.ends.map(|end| end.is_some_and(&open)));
        let all = self.0.entry(lap.ray).or_default();
        let first = all.partition_point(|(s, _)| s[1] < new[0] - JOIN);
        let last = first + all[first..].partition_point(|(s, _)| s[0] <= new[1] + JOIN);
        for (s, e) in &all[first..last] {
            if s[0] <= new[0] {
                (new[0], ends[0]) = (s[0], e[0]);
            }
            if s[1] >= new[1] {
                (new[1], ends[1]) = (s[1], e[1]);
            }
        }
        all.splice(first..last, [(new, ends)]);
    }

    /// The interval that an added one has become a part of.
    fn at(&self, lap: &RayLap) -> ([f64; 2], [bool; 2]) {
        let all = self.0.get(&lap.ray).map_or(&[][..], Vec::as_slice);
        let found = all.get(all.partition_point(|(s, _)| s[1] < lap.hi));
        found.copied().unwrap_or(([lap.lo, lap.hi], [false; 2]))
    }
}

impl Opening {
    fn add(&mut self, grid: &RayGrid, lap: &RayLap, open: impl Fn(EndMark) -> bool) {
        for (s, end) in [lap.lo, lap.hi].into_iter().zip(lap.ends) {
            if let Some(mark) = end.filter(|m| open(*m)) {
                self.samples.push((point(grid, lap.ray, s), mark.normal()));
            }
        }
    }

    /// Sorts the samples that wait into the tree, when they have become many.
    fn sort(&mut self) {
        if self.samples.len() - self.sorted > WAITING.max(self.sorted / 2) {
            sort(&mut self.samples, 0);
            self.sorted = self.samples.len();
        }
    }

    /// Depth of the deepest place of some intervals; none without an opening, or without a place on the skin.
    fn deepest<'a>(
        &self,
        grid: &RayGrid,
        laps: impl Iterator<Item = &'a RayLap>,
        whole: impl Fn(&RayLap) -> ([f64; 2], [bool; 2]),
    ) -> Option<f64> {
        let near = BESIDE * grid.longest_cell();
        let mut deepest: Option<f64> = None;
        let mut look = |s: f64, lap: &RayLap, middle: bool| {
            let x = point(grid, lap.ray, s);
            let Some((depth, foot, m)) = self.distance(&x, near) else { return };
            let other = x + (x - foot);
            let across = if middle { self.nearest(&other).filter(|(p, _)| (p - other).norm() <= near) } else { None };
            let depth = match across {
                // Two faces against each other: their distance, wherever between them the place lies.
                Some((p, n)) if m.dot(&n) < OPPOSITE => m.dot(&(foot - p)).abs().min(2.0 * depth),
                Some(_) => 2.0 * depth,
                None => depth,
            };
            deepest = Some(deepest.unwrap_or(0.0).max(depth));
        };
        for lap in laps {
            let ([lo, hi], open) = whole(lap);
            if open == [true; 2] {
                look(0.5 * (lo + hi), lap, true);
                continue;
            }
            for (s, end) in [lap.lo, lap.hi].into_iter().zip(lap.ends) {
                if end.is_none() {
                    look(s, lap, false);
                }
            }
        }
        deepest
    }

    /// Distance of a point, the place that it is measured to, and the normal there.
    fn distance(&self, x: &Point, near: f64) -> Option<(f64, Point, Vector)> {
        let (p, m) = self.nearest(x)?;
        let way = x - p;
        let along = m.dot(&way);
        let beside = (way - m * along).norm() <= near;
        Some(if beside { (along.abs(), x - m * along, m) } else { (way.norm(), p, m) })
    }

    fn nearest(&self, x: &Point) -> Option<(Point, Vector)> {
        let (tree, waiting) = self.samples.split_at(self.sorted);
        let mut best = (f64::INFINITY, None);
        nearest(tree, 0, x, &mut best);
        compare_samples(waiting, x, &mut best);
        best.1
    }
}

fn point(grid: &RayGrid, (a, i, j): (u8, u32, u32), s: f64) -> Point {
    let a = usize::from(a);
    RayGrid::point(a, s, grid.center((a + 1) % 3, i as usize), grid.center((a + 2) % 3, j as usize))
}

/// Puts samples into the order of a tree: the middle one divides the others along an axis, then each half
/// along the next (Bentley 1975, "Multidimensional binary search trees").
fn sort(samples: &mut [(Point, Vector)], axis: usize) {
    if samples.len() <= LEAF {
        return;
    }
    let middle = samples.len() / 2;
    let (low, _, high) = samples.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    sort(low, (axis + 1) % 3);
    sort(high, (axis + 1) % 3);
}

/// Square of the distance of the nearest sample so far, and the sample.
type Best = (f64, Option<(Point, Vector)>);

fn compare_samples(samples: &[(Point, Vector)], x: &Point, best: &mut Best) {
    for sample in samples {
        let square = (x - sample.0).norm_squared();
        if square < best.0 {
            *best = (square, Some(*sample));
        }
    }
}

fn nearest(tree: &[(Point, Vector)], axis: usize, x: &Point, best: &mut Best) {
    if tree.len() <= LEAF {
        return compare_samples(tree, x, best);
    }
    let middle = tree.len() / 2;
    let (low, rest) = tree.split_at(middle);
    let (divider, high) = rest.split_at(1);
    compare_samples(divider, x, best);
    let over = x[axis] - divider[0].0[axis];
    let (first, second) = if over < 0.0 { (low, high) } else { (high, low) };
    nearest(first, (axis + 1) % 3, x, best);
    if over * over < best.0 {
        nearest(second, (axis + 1) % 3, x, best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_the_nearest_of_all() {
        let number = |k: usize| ((k as f64 * 12.9898).sin() * 43758.5453).fract().abs();
        let at = |k: usize| Point::new(10.0 * number(3 * k), 4.0 * number(3 * k + 1), number(3 * k + 2));
        for n in [0, 1, 7, 9, 500, 3000] {
            let mut opening = Opening { samples: (0..n).map(|k| (at(k), Vector::z())).collect(), sorted: 0 };
            let plain = opening.samples.clone();
            opening.sort();
            // Some that came later wait.
            opening.samples.extend((n..n + 20).map(|k| (at(k), Vector::z())));
            for k in 0..200 {
                let x = at(100_000 + k) * 1.2;
                let all = plain.iter().map(|s| s.0).chain((n..n + 20).map(at));
                let wanted = all.map(|p| (x - p).norm()).fold(f64::INFINITY, f64::min);
                // No sample lies near the foot: the distance itself.
                assert_eq!(opening.distance(&x, -1.0).map(|d| d.0), Some(wanted), "{n}");
            }
        }
        assert_eq!(Opening::default().distance(&Point::origin(), 1.0), None);
    }
}
