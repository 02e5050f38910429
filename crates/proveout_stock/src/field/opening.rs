//! Samples of the free surface that a body takes away, and the nearest of them to a place.
//!
//! Samples come piece by piece, and between the pieces places are looked up. They are kept as k-d trees
//! (Bentley 1975, "Multidimensional binary search trees") whose sizes are those of the binary digits of the
//! count, the largest first (Bentley and Saxe 1980, "Decomposable searching problems"):
//!
//! ```text
//!     count 7 x BUCKET + 5    |  4 BUCKET  | 2 BUCKET | BUCKET | 5 wait |
//! ```
//!
//! A sample is sorted once for each digit, and a lookup passes one tree a digit and fewer than [`BUCKET`]
//! samples one by one. Among samples of equal distance the first in the order of their coordinates counts, so
//! that a result does not depend on how the samples came.
//!
//! *The deepest of many places* does not need the depth of each. A place is no deeper than its distance from
//! any sample, twice that in the middle of a rib. So a place with a sample within the depth known so far is
//! left out, and the sample of the place before is tried first (the early break of Taha and Hanbury 2015, "An
//! efficient algorithm for calculating the exact Hausdorff distance").

use std::cmp::Ordering;

use proveout_geom::{Point, Vector};

use crate::{
    field::depth::{OpenEnds, RayLap, point},
    field::grid::RayGrid,
    field::span::EndMark,
};

/// A place on the free surface and the outward normal of the material there.
pub(crate) type Sample = (Point, Vector);

/// Samples of the opening, in trees.
#[derive(Clone, Debug, Default)]
pub(crate) struct Opening {
    samples: Vec<Sample>,
    /// End of each tree; what follows the last waits.
    trees: Vec<usize>,
}

/// Part of a cell across the normal within which a sample counts as near the foot of a point.
const BESIDE: f64 = 1.5;
/// Cosine of normals below which two faces count as those of a wall.
const OPPOSITE: f64 = -0.9;
/// Samples in a leaf of a tree.
const LEAF: usize = 8;
/// Samples of the smallest tree.
const BUCKET: usize = 64;
/// Square of a distance that no sample has.
const NONE_IS_NEAR: f64 = -1.0;

impl Opening {
    /// The open ends of some intervals, in one tree.
    pub(crate) fn of<'a>(grid: &RayGrid, laps: impl Iterator<Item = &'a RayLap>) -> Self {
        let mut opening = Self::default();
        laps.for_each(|lap| opening.add(grid, lap, |_| true));
        sort(&mut opening.samples, 0);
        opening.trees = vec![opening.samples.len()];
        opening
    }

    /// The samples that [`Self::samples`] gave.
    pub(crate) fn restored(samples: Vec<Sample>) -> Self {
        let trees = ends_of_trees(samples.len());
        Self { samples, trees }
    }

    /// All samples, tree by tree.
    pub(crate) fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// Adds the ends of an interval that were there before; [`Self::sort`] follows.
    pub(crate) fn add(&mut self, grid: &RayGrid, lap: &RayLap, open: impl Fn(EndMark) -> bool) {
        self.samples.extend(open_ends(grid, lap, open));
    }

    /// Sorts what was added into the trees.
    pub(crate) fn sort(&mut self) {
        let trees = ends_of_trees(self.samples.len());
        let kept = trees.iter().zip(&self.trees).take_while(|(new, old)| new == old).count();
        let mut first = kept.checked_sub(1).map_or(0, |last| trees[last]);
        for &end in &trees[kept..] {
            sort(&mut self.samples[first..end], 0);
            first = end;
        }
        self.trees = trees;
    }

    /// Depth of the deepest place of some intervals, at least `known`; none without an opening, or without a
    /// place on the skin. `whole` gives the interval that one is a part of.
    pub(crate) fn deepest<'a>(
        &self,
        grid: &RayGrid,
        laps: impl Iterator<Item = &'a RayLap>,
        whole: impl Fn(&RayLap) -> OpenEnds,
        known: Option<f64>,
    ) -> Option<f64> {
        let near = BESIDE * grid.longest_cell();
        let (mut deepest, mut hint) = (known, None);
        for lap in laps {
            for place in places(grid, lap, whole(lap)) {
                let enough = deepest.map_or(NONE_IS_NEAR, |d: f64| place.square_within(d));
                let Some((square, sample)) = self.nearest(&place.x, enough, hint) else { continue };
                hint = Some(sample);
                if square > enough {
                    deepest = Some(deepest.unwrap_or(0.0).max(self.depth(&place, &sample, near)));
                }
            }
        }
        deepest
    }

    /// Whether a place of an interval may be deeper than `known`.
    pub(crate) fn may_be_deeper(&self, grid: &RayGrid, lap: &RayLap, known: f64) -> bool {
        places(grid, lap, alone(lap)).any(|place| {
            let enough = place.square_within(known);
            self.nearest(&place.x, enough, None).is_none_or(|(square, _)| square > enough)
        })
    }

    /// Depth of a place whose nearest sample is known.
    fn depth(&self, place: &Place, sample: &Sample, near: f64) -> f64 {
        let x = &place.x;
        let (depth, foot, m) = distance(x, sample, near);
        let other = x + (x - foot);
        let across = if place.middle { self.nearest(&other, NONE_IS_NEAR, None) } else { None };
        match across.filter(|(square, _)| *square <= near * near) {
            // Two faces against each other: their distance, wherever between them the place lies.
            Some((_, (p, n))) if m.dot(&n) < OPPOSITE => m.dot(&(foot - p)).abs().min(2.0 * depth),
            Some(_) => 2.0 * depth,
            None => depth,
        }
    }

    /// The nearest sample with the square of its distance, or the first that is found with a square up to
    /// `enough`.
    fn nearest(&self, x: &Point, enough: f64, hint: Option<Sample>) -> Option<(f64, Sample)> {
        let mut best = Best { square: f64::INFINITY, sample: None, enough };
        if let Some(sample) = hint {
            best.look(x, &sample);
        }
        let mut first = 0;
        for &end in &self.trees {
            if best.is_enough() {
                break;
            }
            nearest(&self.samples[first..end], 0, x, &mut best);
            first = end;
        }
        if !best.is_enough() {
            self.samples[first..].iter().for_each(|sample| best.look(x, sample));
        }
        best.sample.map(|sample| (best.square, sample))
    }
}

/// Depth of a place on the skin for which the open ends of all `laps` are looked through, without a tree;
/// none where the interval has no such place, or nothing is open.
pub(crate) fn depth_by_all(grid: &RayGrid, lap: &RayLap, laps: &[RayLap]) -> Option<f64> {
    let place = places(grid, lap, alone(lap)).find(|place| !place.middle)?;
    let mut best = Best { square: f64::INFINITY, sample: None, enough: NONE_IS_NEAR };
    laps.iter().flat_map(|lap| open_ends(grid, lap, |_| true)).for_each(|sample| best.look(&place.x, &sample));
    best.sample.map(|sample| distance(&place.x, &sample, BESIDE * grid.longest_cell()).0)
}

/// An interval that is part of no other.
pub(crate) fn alone(lap: &RayLap) -> OpenEnds {
    ([lap.lo, lap.hi], lap.ends.map(|end| end.is_some()))
}

/// Where the depth of an interval is asked for.
struct Place {
    x: Point,
    /// Between two open ends.
    middle: bool,
}

impl Place {
    /// Square of the distance from a sample within which the place is no deeper than `depth`.
    fn square_within(&self, depth: f64) -> f64 {
        let distance = if self.middle { 0.5 * depth } else { depth };
        distance * distance
    }
}

fn places(grid: &RayGrid, lap: &RayLap, ([lo, hi], open): OpenEnds) -> impl Iterator<Item = Place> {
    let at = |s: f64, middle: bool| Place { x: point(grid, lap.ray, s), middle };
    let middle = (open == [true; 2]).then(|| at(0.5 * (lo + hi), true));
    let skin = |k: usize| (open != [true; 2] && lap.ends[k].is_none()).then(|| at([lap.lo, lap.hi][k], false));
    [middle, skin(0), skin(1)].into_iter().flatten()
}

fn open_ends(grid: &RayGrid, lap: &RayLap, open: impl Fn(EndMark) -> bool) -> impl Iterator<Item = Sample> {
    let at = |k: usize| {
        let mark = lap.ends[k].filter(|mark| open(*mark))?;
        Some((point(grid, lap.ray, [lap.lo, lap.hi][k]), mark.normal()))
    };
    [at(0), at(1)].into_iter().flatten()
}

/// Distance of a place from its nearest sample, the foot that it is measured to, and the normal there.
fn distance(x: &Point, (p, m): &Sample, near: f64) -> (f64, Point, Vector) {
    let way = x - p;
    let along = m.dot(&way);
    let beside = (way - m * along).norm() <= near;
    if beside { (along.abs(), x - m * along, *m) } else { (way.norm(), *p, *m) }
}

/// Ends of the trees of so many samples.
fn ends_of_trees(count: usize) -> Vec<usize> {
    let buckets = count / BUCKET;
    let mut end = 0;
    (0..usize::BITS)
        .rev()
        .filter(|digit| buckets >> digit & 1 == 1)
        .map(|digit| {
            end += BUCKET << digit;
            end
        })
        .collect()
}

/// Puts samples into the order of a tree: the middle one divides the others along an axis, then each half
/// along the next.
fn sort(samples: &mut [Sample], axis: usize) {
    if samples.len() <= LEAF {
        return;
    }
    let middle = samples.len() / 2;
    let (low, _, high) = samples.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    sort(low, (axis + 1) % 3);
    sort(high, (axis + 1) % 3);
}

/// The nearest sample so far.
struct Best {
    square: f64,
    sample: Option<Sample>,
    /// Square of a distance from which on no nearer sample is looked for.
    enough: f64,
}

impl Best {
    fn is_enough(&self) -> bool {
        self.square <= self.enough
    }

    fn look(&mut self, x: &Point, sample: &Sample) {
        let square = (x - sample.0).norm_squared();
        let first = || self.sample.is_none_or(|best| order(sample, &best).is_lt());
        if square < self.square || square == self.square && first() {
            (self.square, self.sample) = (square, Some(*sample));
        }
    }
}

/// Order of samples at equal distances.
fn order(a: &Sample, b: &Sample) -> Ordering {
    let coordinates = |s: &Sample| [s.0.x, s.0.y, s.0.z, s.1.x, s.1.y, s.1.z];
    let pairs = coordinates(a).into_iter().zip(coordinates(b));
    pairs.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

fn nearest(tree: &[Sample], axis: usize, x: &Point, best: &mut Best) {
    if tree.len() <= LEAF {
        tree.iter().for_each(|sample| best.look(x, sample));
        return;
    }
    let middle = tree.len() / 2;
    let (low, rest) = tree.split_at(middle);
    let (divider, high) = rest.split_at(1);
    best.look(x, &divider[0]);
    let over = x[axis] - divider[0].0[axis];
    let (first, second) = if over < 0.0 { (low, high) } else { (high, low) };
    nearest(first, (axis + 1) % 3, x, best);
    if over * over <= best.square && !best.is_enough() {
        nearest(second, (axis + 1) % 3, x, best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(k: usize) -> f64 {
        ((k as f64 * 12.9898).sin() * 43758.5453).fract().abs()
    }

    fn at(k: usize) -> Point {
        Point::new(10.0 * number(3 * k), 4.0 * number(3 * k + 1), number(3 * k + 2))
    }

    #[test]
    fn the_trees_find_the_nearest_of_all_however_the_samples_come() {
        for steps in [&[7][..], &[64], &[500, 1, 63, 64, 3000, 5], &[20; 90]] {
            let mut opening = Opening::default();
            let mut count = 0;
            for step in steps {
                opening.samples.extend((count..count + step).map(|k| (at(k), Vector::z())));
                count += step;
                opening.sort();
                assert!(opening.samples.len() - opening.trees.last().unwrap_or(&0) < BUCKET);
            }
            let again = Opening::restored(opening.samples().to_vec());
            for k in 0..200 {
                let x = at(100_000 + k) * 1.2;
                let wanted = (0..count).map(|k| (x - at(k)).norm_squared()).fold(f64::INFINITY, f64::min);
                for opening in [&opening, &again] {
                    assert_eq!(opening.nearest(&x, NONE_IS_NEAR, None).map(|n| n.0), Some(wanted), "{steps:?}");
                    // A sample that is near enough ends the search; one that is not is none.
                    let early = opening.nearest(&x, 4.0 * wanted, None).expect("samples").0;
                    assert!(wanted <= early && early <= 4.0 * wanted);
                }
            }
        }
        assert_eq!(Opening::default().nearest(&Point::origin(), NONE_IS_NEAR, None).map(|n| n.0), None);
    }

    #[test]
    fn samples_at_equal_distances_give_the_same_in_any_order() {
        let all: Vec<Sample> = (0..300)
            .map(|k| {
                let angle = 0.1 * f64::from(k % 60);
                (Point::new(angle.cos().round(), angle.sin().round(), 0.0), Vector::new(f64::from(k % 5), 1.0, 0.0))
            })
            .collect();
        let found = |order: &[Sample]| {
            let mut opening = Opening { samples: order.to_vec(), trees: Vec::new() };
            opening.sort();
            opening.nearest(&Point::origin(), NONE_IS_NEAR, None)
        };
        let reversed: Vec<Sample> = all.iter().rev().copied().collect();
        assert_eq!(found(&all), found(&reversed));
        assert_eq!(found(&all), found(&all[..]));
    }
}
