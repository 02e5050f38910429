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
//!
//! *The deepest of a run.* A holder that runs through material for a whole pass is one finding with one
//! depth. Items with [`Measure::Deepest`] are measured in full only where a place may be deeper than the
//! deepest so far; of the others one place is proved to be deeper than a touch.

use std::collections::BTreeMap;

use proveout_geom::Point;

use crate::{
    field::grid::RayGrid,
    field::opening::{Opening, alone, depth_by_all},
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
    /// As the item meets it, but only whether it is deeper than a touch: the depth is then a lower bound.
    Touch,
    /// As the item meets it, where it may be deeper than the items before it with the same body in the run
    /// with this id: the depth is then no more than a lower bound. The deepest item of the run has its depth.
    Deepest(u32),
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

/// The deepest items so far of runs with [`Measure::Deepest`], among the items of one chunk.
#[derive(Debug, Default)]
pub(crate) struct Deepest(BTreeMap<(u32, usize), (usize, f64)>);

impl Deepest {
    /// Depth of the deepest item of this run and body, where the last of them was in material; `between` says
    /// whether an item between two others is of that run and body.
    pub(crate) fn of(&self, key: (u32, usize), item: usize, between: impl Fn(usize) -> bool) -> Option<f64> {
        let &(last, depth) = self.0.get(&key)?;
        (last < item && !(last + 1..item).any(between)).then_some(depth)
    }

    /// Takes the depth of an item, of which `known` was asked before; one that is no deeper than `least` ends
    /// the run.
    pub(crate) fn take(&mut self, key: (u32, usize), item: usize, known: Option<f64>, [depth, least]: [f64; 2]) {
        if depth > least {
            self.0.insert(key, (item, known.map_or(depth, |known| depth.max(known))));
        } else {
            self.0.remove(&key);
        }
    }
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

/// Ends that lie this near to each other are one: one item has begun where the other has stopped, mm.
const JOIN: f64 = 1e-9;
/// Intervals of a single item that are looked at first; all only where these do not settle that it is deep.
const FIRST: usize = 1500;
/// Open ends that a first look for the deepest places takes, about.
const COARSE: usize = 1000;
/// Places that are tried for a proof that an item is deeper than a touch.
const TRIED: usize = 4;

impl Depths {
    /// Overlaps up to `least` (mm) on every ray are not measured further: their length is their depth.
    pub fn new(least: f64) -> Self {
        Self { least, ..Self::default() }
    }

    /// Overlaps up to this length are touches, mm.
    pub(crate) fn least(&self) -> f64 {
        self.least
    }

    /// Depth of one item, mm. `laps` are its intervals in a fixed order, `longest` the longest of them.
    ///
    /// `known` is the depth of the deepest item of its run so far, with [`Measure::Deepest`]. `held` is the
    /// signed distance of a point from the body at the begin of the item, negative inside, and `bound` what
    /// an item may leave, mm.
    pub(crate) fn of_item(
        &mut self,
        grid: &RayGrid,
        (measure, known): (Measure, Option<f64>),
        laps: &[RayLap],
        longest: f64,
        (held, bound): (impl Fn(&Point) -> f64, f64),
    ) -> f64 {
        if measure == Measure::No || !matches!(measure, Measure::Since(_)) && longest <= self.least {
            return longest;
        }
        // What is left over from the item before, by the depth in its middle.
        let left = |lap: &RayLap| {
            let middle = held(&point(grid, lap.ray, 0.5 * (lap.lo + lap.hi)));
            (middle < 0.0 && middle >= -bound && lap.ends.iter().all(Option::is_none)).then_some(middle)
        };
        let known = match measure {
            Measure::Touch => Some(f64::INFINITY),
            Measure::Deepest(_) => known.filter(|depth| *depth > self.least),
            _ => None,
        };
        let few: Vec<&RayLap> =
            laps.iter().step_by(laps.len().div_ceil(FIRST).max(1)).filter(|lap| left(lap).is_none()).collect();
        if let Some(depth) = known.and_then(|known| self.up_to(grid, laps, &few, known)) {
            return depth.min(longest);
        }
        let mut begun = 0.0_f64;
        let mut length = 0.0_f64;
        let entered: Vec<RayLap> = laps
            .iter()
            .filter(|lap| {
                let left = left(lap);
                match left {
                    Some(middle) => begun = begun.max((-2.0 * middle).min(lap.hi - lap.lo)),
                    None => length = length.max(lap.hi - lap.lo),
                }
                left.is_none()
            })
            .copied()
            .collect();
        let rest = match measure {
            _ if entered.is_empty() => 0.0,
            Measure::Since(first) => self.of_run(grid, first, &entered, length.min(longest)),
            _ => self.of_entered(grid, &entered, &few, length.min(longest)),
        };
        begun.max(rest)
    }

    /// Depth of an item of which a depth `known` need not be passed, where that is less work than its own
    /// depth: that of its deepest place where this is deeper, else of any place that is deeper than a touch.
    /// None where neither is seen.
    fn up_to(&self, grid: &RayGrid, laps: &[RayLap], few: &[&RayLap], known: f64) -> Option<f64> {
        // From an open end of its own interval no place is farther than the interval is long.
        let mut deeper = few.to_vec();
        deeper.retain(|lap| known.is_finite() && (lap.ends.iter().all(Option::is_none) || lap.hi - lap.lo > known));
        if !deeper.is_empty() {
            let coarse = Opening::of(grid, laps.iter().step_by(laps.len().div_ceil(COARSE).max(1)));
            deeper.retain(|lap| coarse.may_be_deeper(grid, lap, known));
        }
        if !deeper.is_empty() {
            let opening = Opening::of(grid, laps.iter());
            let depth = opening.deepest(grid, deeper.into_iter(), alone, Some(known))?;
            if depth > known {
                return Some(depth);
            }
        }
        let mut tried = few.to_vec();
        tried.sort_by(|a, b| (b.hi - b.lo).total_cmp(&(a.hi - a.lo)));
        let depths = tried.into_iter().take(TRIED).filter_map(|lap| depth_by_all(grid, lap, laps));
        depths.map(|depth| depth.min(known)).find(|depth| *depth > self.least)
    }

    /// Depth of an item as it meets the material; `few` are looked at first.
    fn of_entered(&self, grid: &RayGrid, laps: &[RayLap], few: &[&RayLap], longest: f64) -> f64 {
        if longest <= self.least {
            return longest;
        }
        let opening = Opening::of(grid, laps.iter());
        let first = opening.deepest(grid, few.iter().copied(), alone, None);
        let depth = match first {
            Some(d) if few.len() == laps.len() || d > self.least => Some(d),
            _ => opening.deepest(grid, laps.iter(), alone, first),
        };
        depth.unwrap_or(longest).min(longest)
    }

    /// Depth of an item in the material before its run.
    fn of_run(&mut self, grid: &RayGrid, first: u32, laps: &[RayLap], longest: f64) -> f64 {
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
        self.opening.deepest(grid, laps.iter(), |lap| self.run.at(lap), None).unwrap_or(longest)
    }
}

impl Depths {
    /// Items of runs that were measured so far: as long as none follows, the memory stays as it is.
    pub fn taken(&self) -> u64 {
        self.taken
    }

    /// Bytes that the memory takes in a [`SweepLog`](crate::SweepLog), about.
    pub fn bytes(&self) -> u64 {
        (48 * self.opening.samples().len() + 24 * self.run.0.len()) as u64
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

pub(crate) fn point(grid: &RayGrid, (a, i, j): (u8, u32, u32), s: f64) -> Point {
    let a = usize::from(a);
    RayGrid::point(a, s, grid.center((a + 1) % 3, i as usize), grid.center((a + 2) % 3, j as usize))
}
