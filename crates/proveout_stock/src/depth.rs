//! How deep a body was in the material that it met.
//!
//! The longest overlap on a ray is no depth: a cutter that slides along a wall and shaves a micrometer off it overlaps with a ray
//! along the wall over all of its height. The depth of a point that the body has reached is its distance from the free surface of
//! the material as it stood before, through what the body takes up; the depth of a motion is that of its deepest point.
//!
//! ```text
//!      ___________                ___________ free surface
//!     |   :   |   |              |      |:   |
//!     |   : d |   |              |      |:   |     : chord on a ray along the wall
//!     |   :___|   |              |      |:_  |     the depth is the width of the shaving
//!     |___________|              |___________|
//!       plunge                     shaving
//! ```
//!
//! What the body takes up lies on rays of all three sets. An end of such an interval is *free* where the material itself ended
//! there, otherwise it lies on the skin of the swept body, where the depth is asked for. From a point x the free ends are looked at
//! on its own ray, and on the four rays of each other set next to x whose interval reaches as far as x. With the outward normal m
//! of the material at the free end p,
//!
//! ```text
//!     distance = |m . (x - p)|   where p lies beside the foot of x, within a cell and a half across m; else |x - p|, or what
//!                                a free end beside the foot x - m (m . (x - p)) gives
//! ```
//!
//! and the depth of x is the smallest of them. Faces that are plane over a cell and a half give their exact distance at any
//! resolution; a face of curvature k is off by k (1.5 cell)² / 2 at most. Between two rays the skin can be deeper than on them by
//! the sagitta of the body over a cell. Where both ends of an interval are free, its middle is asked for: a rib that is cut
//! away as a whole is half as deep as it is thick. Where no point sees a free end (a body that began inside of material), the
//! longest overlap stands for the depth.
//!
//! *Runs.* A rapid through material is many pieces, each of which meets but the layer that the one before has left. Its depth is
//! that in the material as it stood before its first piece: items with [`Measure::Since`] put what they take together, and ends
//! that items of the run have made are not free.

use std::collections::BTreeMap;

use proveout_geom::{Point, Vector};

use crate::{
    grid::Grid,
    span::{INITIAL, Mark},
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
    since: Option<u32>,
    run: Taken,
}

/// An interval that an item takes up on a ray, with the ends of the material that it reaches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lap {
    pub item: u32,
    /// Set, and numbers of the ray along u and v.
    pub ray: (u8, u32, u32),
    pub lo: f64,
    pub hi: f64,
    /// What made the end of the material that lies there; none where the skin of the body does.
    pub ends: [Option<Mark>; 2],
}

#[derive(Clone, Copy, Debug)]
enum End {
    /// On the skin of the body, or where the run has been before.
    Skin,
    /// The free surface with its outward normal.
    Free(Vector),
}

#[derive(Clone, Copy, Debug)]
struct Seg {
    lo: f64,
    hi: f64,
    ends: [End; 2],
}

/// Intervals by ray, rising.
#[derive(Clone, Debug, Default)]
struct Taken(BTreeMap<(u8, u32, u32), Vec<Seg>>);

/// Part of a cell across the normal within which a free end lies beside the foot of a point.
const BESIDE: f64 = 1.5;
/// Ends that lie this near to each other are one: one item has begun where the other has stopped, mm.
const JOIN: f64 = 1e-9;
/// Intervals of a single item that are looked at first; all only where these do not settle that it is deep.
const FIRST: usize = 1500;

impl Depths {
    /// Overlaps up to `least` (mm) on every ray are not measured further: their length is their depth.
    pub fn new(least: f64) -> Self {
        Self { least, ..Self::default() }
    }

    /// Depth of one item, mm. `laps` are its intervals in a fixed order, `longest` the longest of them.
    pub(crate) fn of_item(&mut self, grid: &Grid, measure: Measure, laps: &[Lap], longest: f64) -> f64 {
        match measure {
            Measure::No => longest,
            Measure::Alone if longest <= self.least => longest,
            Measure::Alone => {
                let mut taken = Taken::default();
                for lap in laps {
                    taken.put(lap, None);
                }
                let step = laps.len().div_ceil(FIRST).max(1);
                let few = taken.deepest(grid, laps.iter().step_by(step));
                let depth = match few {
                    Some(d) if step == 1 || d > self.least => Some(d),
                    _ => taken.deepest(grid, laps.iter()),
                };
                depth.unwrap_or(longest).min(longest)
            }
            Measure::Since(first) => {
                if self.since != Some(first) {
                    (self.since, self.run) = (Some(first), Taken::default());
                }
                for lap in laps {
                    self.run.put(lap, Some(first));
                }
                self.run.deepest(grid, laps.iter()).unwrap_or(longest)
            }
        }
    }
}

impl Taken {
    /// Adds an interval; ends made by items from `since` on are not free.
    fn put(&mut self, lap: &Lap, since: Option<u32>) {
        let end = |mark: Option<Mark>| match mark {
            Some(m) if m.id == INITIAL || since.is_none_or(|first| m.id < first) => End::Free(m.normal()),
            _ => End::Skin,
        };
        let mut new = Seg { lo: lap.lo, hi: lap.hi, ends: lap.ends.map(end) };
        let segs = self.0.entry(lap.ray).or_default();
        let first = segs.partition_point(|s| s.hi < new.lo - JOIN);
        let last = first + segs[first..].partition_point(|s| s.lo <= new.hi + JOIN);
        for s in &segs[first..last] {
            if s.lo <= new.lo {
                (new.lo, new.ends[0]) = (s.lo, s.ends[0]);
            }
            if s.hi >= new.hi {
                (new.hi, new.ends[1]) = (s.hi, s.ends[1]);
            }
        }
        segs.splice(first..last, [new]);
    }

    /// Depth of the deepest point of some intervals; none where no point sees a free end.
    fn deepest<'a>(&self, grid: &Grid, laps: impl Iterator<Item = &'a Lap>) -> Option<f64> {
        let mut deepest = None;
        let mut look = |x: Point, ray, seg: &Seg| {
            if let Some(depth) = self.depth(grid, &x, ray, seg) {
                deepest = Some(depth.max(deepest.unwrap_or(0.0)));
            }
        };
        for lap in laps {
            let (a, u, v) = place(grid, lap.ray);
            let Some(seg) = self.0.get(&lap.ray).and_then(|segs| segs.iter().find(|s| s.hi >= lap.hi)) else {
                continue;
            };
            let at = |s: f64| Grid::point(a, s, u, v);
            match seg.ends {
                [End::Free(_), End::Free(_)] => look(at(0.5 * (seg.lo + seg.hi)), lap.ray, seg),
                _ => {
                    for (s, end) in [(lap.lo, lap.ends[0]), (lap.hi, lap.ends[1])] {
                        if end.is_none() {
                            look(at(s), lap.ray, seg);
                        }
                    }
                }
            }
        }
        deepest
    }

    /// Distance of a point on an interval from the free surface.
    fn depth(&self, grid: &Grid, x: &Point, ray: (u8, u32, u32), own: &Seg) -> Option<f64> {
        let mut nearest = f64::INFINITY;
        let mut see = |p: &Point, m: &Vector| nearest = nearest.min(self.apart(grid, x, p, m));
        for_free_ends(grid, ray, own, &mut see);
        for b in (0..3_u8).filter(|b| *b != ray.0) {
            let axis = usize::from(b);
            let reach = grid.cells[axis];
            self.on_rays_beside(grid, b, x, &mut |ray, seg| {
                if seg.lo - reach <= x[axis] && x[axis] <= seg.hi + reach {
                    for_free_ends(grid, ray, seg, &mut see);
                }
            });
        }
        nearest.is_finite().then_some(nearest)
    }

    /// Distance of a point from the free surface that has the end `p` with the normal `m`.
    fn apart(&self, grid: &Grid, x: &Point, p: &Point, m: &Vector) -> f64 {
        let way = x - p;
        let along = m.dot(&way);
        let near = BESIDE * grid.longest_cell();
        if (way - m * along).norm() <= near {
            return along.abs();
        }
        let foot = x - m * along;
        let mut best = way.norm();
        self.on_rays_beside(grid, m.iamax() as u8, &foot, &mut |ray, seg| {
            for_free_ends(grid, ray, seg, &mut |q, n| {
                if (q - foot).norm() <= near {
                    best = best.min(n.dot(&(x - q)).abs());
                }
            });
        });
        best
    }

    /// The intervals on the rays of a set next to a point.
    fn on_rays_beside(&self, grid: &Grid, b: u8, x: &Point, each: &mut dyn FnMut((u8, u32, u32), &Seg)) {
        let a = usize::from(b);
        let low = |axis: usize| ((x[axis] - grid.bounds.min[axis]) / grid.cells[axis] - 0.5).floor();
        let (i, j) = (low((a + 1) % 3), low((a + 2) % 3));
        for (di, dj) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (i, j) = (i + di, j + dj);
            if i < 0.0 || j < 0.0 {
                continue;
            }
            let ray = (b, i as u32, j as u32);
            for seg in self.0.get(&ray).into_iter().flatten() {
                each(ray, seg);
            }
        }
    }
}

/// Set of a ray, and where it stands along u and v, mm.
fn place(grid: &Grid, (a, i, j): (u8, u32, u32)) -> (usize, f64, f64) {
    let a = usize::from(a);
    (a, grid.center((a + 1) % 3, i as usize), grid.center((a + 2) % 3, j as usize))
}

fn for_free_ends(grid: &Grid, ray: (u8, u32, u32), seg: &Seg, see: &mut dyn FnMut(&Point, &Vector)) {
    let (a, u, v) = place(grid, ray);
    for (s, end) in [(seg.lo, &seg.ends[0]), (seg.hi, &seg.ends[1])] {
        if let End::Free(m) = end {
            see(&Grid::point(a, s, u, v), m);
        }
    }
}
