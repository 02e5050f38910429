//! The search for key axes in the free cells of their contacts.
//!
//! At each key but the ends of the row, which keep the program's axis, an axis is one of a list: cells of
//! inclination to the table's axis and of angle about it that are free ([`FeasibleRegion::free_turns`] for
//! all axes of a cell), lean no more than the cap, and no more than [`LEAN`] from the normal where that is
//! known. Between keys the turn for a mm of way is even, so that the paper's sum (28) is that of its jumps at
//! the keys,
//!
//! ```text
//!   sum over keys  | log(V_k -> V_(k+1)) / L_k  +  log(V_k -> V_(k-1)) / L_(k-1) |^2
//! ```
//!
//! which depends on three consecutive keys: dynamic programming over pairs. Coarse cells come
//! first, then finer ones around the result.

use std::f64::consts::{PI, TAU};

use proveout_geom::{Point, Vector};

use super::super::tool_channel::{MOST_AXIAL, WHOLE_TURN};
use super::super::{AxisTurn, FeasibleRegion};
use super::touching;

/// Largest lean from the normal, radian: beyond, the end of a ball does not cut but its side.
const LEAN: f64 = 80.0 * PI / 180.0;
/// Width of the first cells, and of the finer ones, radian.
const COARSE: f64 = 6.0 * PI / 180.0;
const FINER: [f64; 3] = [2.0 * PI / 180.0, 1.0 * PI / 180.0, 0.5 * PI / 180.0];
/// Finer cells on each side of what was found.
const SIDES: i32 = 3;
/// Ball centers of a contact are no farther from it than this, mm.
const DRIFT: f64 = 0.01;
/// Rounding of a lean, radian.
const ROUNDING: f64 = 1e-12;

/// A key whose axis is looked for.
pub(super) struct KeyPlace {
    pub(super) center: Point,
    pub(super) normal: Option<Vector>,
}

/// What keys are looked for in.
pub(super) struct KeySearch<'a> {
    pub(super) region: &'a dyn FeasibleRegion,
    pub(super) up: Vector,
    pub(super) cap: f64,
}

impl KeySearch<'_> {
    fn basis(&self) -> [Vector; 3] {
        let helper = if self.up.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let u = (helper - self.up * helper.dot(&self.up)).normalize();
        [u, self.up.cross(&u), self.up]
    }

    fn axis(&self, lean: f64, about: f64) -> Vector {
        let [u, v, w] = self.basis();
        (u * about.cos() + v * about.sin()) * lean.sin() + w * lean.cos()
    }

    /// Whether all axes of a cell are free at a key; none if this is not known for the tool.
    fn is_free(&self, key: &KeyPlace, [lean, about]: [f64; 2], half: f64) -> Option<bool> {
        let axis = self.axis(lean, about);
        let from_normal = key.normal.map_or(0.0, |n| axis.cross(&n).norm().atan2(axis.dot(&n)));
        if lean > self.cap + ROUNDING || from_normal > LEAN {
            return Some(false);
        }
        let axial = lean.cos().clamp(-MOST_AXIAL, MOST_AXIAL);
        let turn = AxisTurn { center: key.center, drift: DRIFT, basis: self.basis(), axial, spread: half };
        let free = self.region.free_turns(&turn)?;
        let holds = |[low, high]: &[f64; 2]| {
            let at = about - TAU * ((about - low) / TAU).floor();
            high - low >= WHOLE_TURN || at <= *high
        };
        Some(free.iter().any(holds))
    }

    /// Free cells of a key.
    fn cells(&self, key: &KeyPlace, width: f64) -> Option<Vec<[f64; 2]>> {
        let mut cells = Vec::new();
        // Half the diagonal of a cell.
        let half = width * std::f64::consts::FRAC_1_SQRT_2;
        for ring in 0..=(self.cap / width) as usize {
            let lean = ring as f64 * width;
            let count = (TAU * lean.sin() / width).ceil().max(1.0) as usize;
            for k in 0..count {
                let cell = [lean, TAU * k as f64 / count as f64 - PI];
                if self.is_free(key, cell, half)? {
                    cells.push(cell);
                }
            }
        }
        Some(cells)
    }

    /// Finer cells round one.
    fn beside(&self, key: &KeyPlace, [lean, about]: [f64; 2], width: f64) -> Option<Vec<[f64; 2]>> {
        let half = width * std::f64::consts::FRAC_1_SQRT_2;
        let middle = self.axis(lean, about);
        let helper = if middle.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let u = (helper - middle * helper.dot(&middle)).normalize();
        let v = middle.cross(&u);
        let [x, y, z] = self.basis();
        let mut cells = vec![[lean, about]];
        for a in -SIDES..=SIDES {
            for b in -SIDES..=SIDES {
                let axis = (middle + u * (f64::from(a) * width) + v * (f64::from(b) * width)).normalize();
                let flat = [axis.dot(&x), axis.dot(&y)];
                let cell = [flat[0].hypot(flat[1]).atan2(axis.dot(&z)), flat[1].atan2(flat[0])];
                if (a, b) != (0, 0) && self.is_free(key, cell, half)? {
                    cells.push(cell);
                }
            }
        }
        Some(cells)
    }

    /// Axes of the keys between two ends, with ways between them and from and to the ends.
    /// `Err(k)`: nothing is free at key k. None if the free axes of the tool are not known.
    pub(super) fn keys(
        &self,
        ends: [Vector; 2],
        places: &[KeyPlace],
        ways: &[f64],
    ) -> Option<Result<Vec<Vector>, usize>> {
        let mut lists = Vec::with_capacity(places.len());
        for (k, key) in places.iter().enumerate() {
            let cells = self.cells(key, COARSE)?;
            if cells.is_empty() {
                return Some(Err(k));
            }
            lists.push(cells);
        }
        let mut found = self.least(ends, &lists, ways);
        for width in FINER {
            let lists: Option<Vec<_>> =
                places.iter().zip(&found).map(|(key, at)| self.beside(key, *at, width)).collect();
            found = self.least(ends, &lists?, ways);
        }
        Some(Ok(found.iter().map(|[lean, about]| self.axis(*lean, *about)).collect()))
    }

    /// One of each list, with the least sum.
    fn least(&self, [first, last]: [Vector; 2], lists: &[Vec<[f64; 2]>], ways: &[f64]) -> Vec<[f64; 2]> {
        let mut columns: Vec<Vec<Vector>> = vec![vec![first]];
        columns.extend(lists.iter().map(|list| list.iter().map(|[lean, about]| self.axis(*lean, *about)).collect()));
        columns.push(vec![last]);
        let turn = |a: &Vector, b: &Vector, way: f64| touching(a, b) / way;
        // costs[b * na + a]: the least sum up to the key before b, with a there.
        let mut costs = vec![0.0; columns[1].len()];
        let mut came: Vec<Vec<u32>> = Vec::new();
        for k in 1..columns.len() - 1 {
            let (before, here, next) = (&columns[k - 1], &columns[k], &columns[k + 1]);
            let mut sums = vec![f64::INFINITY; here.len() * next.len()];
            let mut from = vec![0_u32; sums.len()];
            for (b, axis) in here.iter().enumerate() {
                let back: Vec<Vector> = before.iter().map(|a| turn(axis, a, ways[k - 1])).collect();
                for (c, to) in next.iter().enumerate() {
                    let on = turn(axis, to, ways[k]);
                    let at = c * here.len() + b;
                    for (a, back) in back.iter().enumerate() {
                        let sum = costs[b * before.len() + a] + (on + back).norm_squared();
                        if sum < sums[at] {
                            (sums[at], from[at]) = (sum, a as u32);
                        }
                    }
                }
            }
            came.push(from);
            costs = sums;
        }
        // The last column has one axis.
        let mut b = (0..costs.len()).min_by(|&x, &y| costs[x].total_cmp(&costs[y])).unwrap_or(0);
        let mut c = 0;
        let mut out = Vec::with_capacity(lists.len());
        for k in (0..lists.len()).rev() {
            out.push(lists[k][b]);
            let a = came[k][c * columns[k + 1].len() + b] as usize;
            (c, b) = (b, a);
        }
        out.reverse();
        out
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::ToolPose;

    use super::*;

    /// Free away from a direction.
    struct Cap(Vector, f64);

    impl FeasibleRegion for Cap {
        fn clearance(&self, pose: &ToolPose) -> f64 {
            pose.axis.dot(&self.0).acos() - self.1
        }

        fn free_turns(&self, turn: &AxisTurn) -> Option<Vec<[f64; 2]>> {
            let [x, y, z] = turn.basis.map(|b| b.dot(&self.0));
            let size = x.hypot(y) * (1.0 - turn.axial * turn.axial).sqrt();
            let room = (self.1 + turn.spread).cos() - turn.axial * z;
            Some(if room > size {
                vec![[-PI, PI]]
            } else if room < -size {
                Vec::new()
            } else {
                let (middle, half) = (y.atan2(x), (room / size).acos());
                let from = middle + half;
                vec![[from, from + TAU - 2.0 * half]]
            })
        }
    }

    fn places(count: usize) -> Vec<KeyPlace> {
        (0..count).map(|_| KeyPlace { center: Point::origin(), normal: Some(Vector::z()) }).collect()
    }

    fn sum(axes: &[Vector], ways: &[f64]) -> f64 {
        let on = |k: usize| touching(&axes[k], &axes[k + 1]) / ways[k] + touching(&axes[k], &axes[k - 1]) / ways[k - 1];
        (1..axes.len() - 1).map(|k| on(k).norm_squared()).sum()
    }

    #[test]
    fn keys_lie_on_the_way_between_the_ends_where_all_is_free_and_beside_what_is_not() {
        let lean = |a: f64| Vector::new(0.0, a.sin(), a.cos());
        let ends = [lean(-0.5), lean(0.4)];
        let ways = [3.0, 4.0, 2.0];
        let straight: Vec<Vector> = [-0.5 + 0.3, -0.5 + 0.7].map(lean).to_vec();
        let open = Cap(-Vector::z(), 0.1);
        let search = KeySearch { region: &open, up: Vector::z(), cap: 0.8 };
        let found = search.keys(ends, &places(2), &ways).unwrap().unwrap();
        for (axis, wanted) in found.iter().zip(&straight) {
            assert!(axis.dot(wanted).acos() < 0.012, "{axis:?} {wanted:?}");
        }
        // The second key lies in what is not free: it is gone round, at no more than the cells are wide.
        let shut = Cap(straight[1], 0.2);
        let search = KeySearch { region: &shut, up: Vector::z(), cap: 0.8 };
        let round = search.keys(ends, &places(2), &ways).unwrap().unwrap();
        let off = round[1].dot(&straight[1]).acos();
        assert!(off > 0.2 && off < 0.26, "{off}");
        let all = |keys: &[Vector]| sum(&[&ends[..1], keys, &ends[1..]].concat(), &ways);
        assert!(all(&found) < all(&round));
        // The cap alone: nothing is free that leans more.
        let search = KeySearch { region: &open, up: Vector::z(), cap: 0.05 };
        assert!(
            search.keys(ends, &places(2), &ways).unwrap().unwrap().iter().all(|a| a.dot(&Vector::z()).acos() <= 0.0501)
        );
        let nothing = Cap(Vector::z(), 1.5);
        let search = KeySearch { region: &nothing, up: Vector::z(), cap: 0.8 };
        assert_eq!(search.keys(ends, &places(2), &ways), Some(Err(0)));
    }

    /// Against all choices of short lists.
    #[test]
    fn of_lists_the_least_sum_is_taken() {
        let open = Cap(-Vector::z(), 0.1);
        let search = KeySearch { region: &open, up: Vector::z(), cap: 0.8 };
        let mut state = 3_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..50 {
            let lists: Vec<Vec<[f64; 2]>> =
                (0..3).map(|_| (0..4).map(|_| [random(), TAU * random()]).collect()).collect();
            let ends = [search.axis(random(), TAU * random()), search.axis(random(), TAU * random())];
            let ways: Vec<f64> = (0..4).map(|_| 0.5 + random()).collect();
            let of = |pick: [usize; 3]| {
                let keys = (0..3).map(|k| search.axis(lists[k][pick[k]][0], lists[k][pick[k]][1]));
                sum(&[ends[0]].into_iter().chain(keys).chain([ends[1]]).collect::<Vec<_>>(), &ways)
            };
            let best = (0..64).map(|c| of([c % 4, c / 4 % 4, c / 16])).fold(f64::INFINITY, f64::min);
            let found = search.least(ends, &lists, &ways);
            let picked: Vec<usize> = (0..3).map(|k| lists[k].iter().position(|c| *c == found[k]).unwrap()).collect();
            assert!((of([picked[0], picked[1], picked[2]]) - best).abs() < 1e-12);
        }
    }
}
