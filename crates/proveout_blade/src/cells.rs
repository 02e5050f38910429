//! The nearest of all points of a smooth map S(u, v), by branch and bound over cells of its parameters.
//!
//! In a cell with center c, half widths a, b and bounds `U >= |S_uu|`, `W >= |S_uv|`, `V >= |S_vv|` Taylor's
//! formula gives
//!
//! ```text
//!   | S(c + (x, y)) - S(c) - x S_u(c) - y S_v(c) |  <=  bulge        |x| <= a, |y| <= b
//!
//!   bulge = (U a^2 + 2 W a b + V b^2) / 2
//! ```
//!
//! so that no point of the cell is nearer than the distance from the parallelogram of the tangents less the
//! bulge. Each halving of a cell quarters the bulge, and round the nearest point a bounded number of cells is
//! left at each size: a search ends after as many sizes as it takes to bring the bulge below
//! [`FOOT_ERROR_MM`], or until the distance is proved to be convex round the place found. Newton's method
//! (gradient of the distance, `(S - p) . S_u = (S - p) . S_v = 0`) finds the place; the cells only prove that
//! there is no nearer one. The bounds come from an interval evaluation of the second derivatives, or from the
//! control points of a spline.

use std::{cmp::Ordering, collections::BinaryHeap};

use proveout_geom::{Point, Vector};

use super::{
    LEAST_PART,
    ball_tree::BallTree,
    scalar::{Interval, Scalar},
    surface::{Domain, Foot, Local, ParametricSurface},
};

/// The distance of the point that a search over cells finds is not larger than the least one by more than
/// this, mm, where the search came to its end; else by more than [`Foot::error`].
pub const FOOT_ERROR_MM: f64 = 1e-6;
/// Relative margin of the bounds against rounding.
const MARGIN: f64 = 1e-9;
/// The bulge of a stored cell against its size: flat enough for a parallelogram.
const FLAT: f64 = 0.25;
/// Steps of Newton's method.
const STEPS: usize = 40;
/// A stored cell is halved at most so many times; then it is as it is, and the search halves it on.
const DEEPEST: u32 = 14;
/// Steps of Newton's method by the gradient alone, at most so long each, mm.
const POLISHING: usize = 3;
const POLISHED_MM: f64 = 1e-3;
/// Starts of Newton's method: the nearest centers.
const STARTS: usize = 3;
/// Cells that are halved to prove that a surface is farther than something.
const LOOKS: usize = 64;
/// Cells that one search looks at: beyond this a whole patch is equally near, as to the center of a sphere.
/// The search ends there and says how much nearer the cells that are left might come ([`Foot::error`]).
const MOST_CELLS: usize = 100_000;
/// A cell whose radius has no bound counts as so large where the size of a surface is estimated, mm.
const MOST_RADIUS_MM: f64 = 1e4;
/// A step of the polishing may lead away by this, mm: rounding.
const AWAY_MM: f64 = 1e-9;
/// Part of the determinant by the first derivatives below which that by the second ones is not used: there is
/// no minimum nearby.
const LEAST_DETERMINANT: f64 = 1e-9;

/// A surface with bounds of its second derivatives.
pub(super) trait CurvatureBounds {
    /// Ranges of x, y, z of `S_uu`, `S_uv`, `S_vv` over a cell; of a surface that is closed along u, cells
    /// may reach over the seam.
    fn second(&self, u: [f64; 2], v: [f64; 2]) -> [[Interval; 3]; 3];

    /// Upper bounds of `|S_uu|`, `|S_uv|`, `|S_vv|` over a cell.
    fn bend(&self, u: [f64; 2], v: [f64; 2]) -> [f64; 3] {
        self.second(u, v).map(|d| d.iter().map(|c| c.magnitude().powi(2)).sum::<f64>().sqrt())
    }
}

/// A cell of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ParameterCell {
    middle: [f64; 2],
    half: [f64; 2],
    center: Point,
    first: [Vector; 2],
    bend: [f64; 3],
    depth: u32,
}

impl ParameterCell {
    fn new<S: ParametricSurface + CurvatureBounds>(surface: &S, u: [f64; 2], v: [f64; 2], depth: u32) -> Self {
        let bend = surface.bend(u, v).map(|b| b * (1.0 + MARGIN));
        Self::at(
            surface,
            [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])],
            [0.5 * (u[1] - u[0]), 0.5 * (v[1] - v[0])],
            bend,
            depth,
        )
    }

    fn at<S: ParametricSurface>(surface: &S, middle: [f64; 2], half: [f64; 2], bend: [f64; 3], depth: u32) -> Self {
        let at = surface.local(middle[0], middle[1]);
        Self { middle, half, center: at.point, first: at.first, bend, depth }
    }

    fn bulge(&self) -> f64 {
        let [a, b] = self.half;
        0.5 * (self.bend[0] * a * a + 2.0 * self.bend[1] * a * b + self.bend[2] * b * b)
    }

    /// Half lengths along u and v.
    fn reach(&self) -> [f64; 2] {
        [self.first[0].norm() * self.half[0], self.first[1].norm() * self.half[1]]
    }

    fn radius(&self) -> f64 {
        self.reach().iter().sum::<f64>() + self.bulge()
    }

    /// No point of the cell is nearer than this.
    fn least(&self, p: &Point) -> f64 {
        let far = p - self.center;
        let [a, b] = [self.first[0] * self.half[0], self.first[1] * self.half[1]];
        let normal = a.cross(&b);
        let size = normal.norm();
        let outside = if size > 0.0 {
            let across = far.dot(&normal) / size;
            // Parts along both sides beyond the parallelogram, by its dual vectors; at right angles to either
            // side.
            let beyond = |side: &Vector, other: &Vector| {
                let dual = other.cross(&normal) / size;
                let width = dual.dot(side).abs();
                (far.dot(&dual).abs() - width).max(0.0) / dual.norm()
            };
            across.hypot(beyond(&a, &b).max(beyond(&b, &a)))
        } else {
            (far.norm() - a.norm() - b.norm()).max(0.0)
        };
        (outside - self.bulge()).max(0.0)
    }

    /// Halved across its longer side.
    fn halves<S: ParametricSurface>(&self, surface: &S) -> [Self; 2] {
        let [a, b] = self.reach();
        // What bends most across it decides where the sides are alike.
        let along_u = a + self.bend[0] * self.half[0] * self.half[0] >= b + self.bend[2] * self.half[1] * self.half[1];
        [-0.5, 0.5].map(|side| {
            let (mut middle, mut half) = (self.middle, self.half);
            let k = usize::from(!along_u);
            middle[k] += side * half[k];
            half[k] *= 0.5;
            Self::at(surface, middle, half, self.bend, self.depth + 1)
        })
    }
}

/// A cell that may hold the nearest point; the one with the least bound is the greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenCell {
    least: f64,
    cell: ParameterCell,
}

impl Eq for OpenCell {}

impl Ord for OpenCell {
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least)
    }
}

impl PartialOrd for OpenCell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Cells that cover a surface.
#[derive(Clone, Debug, Default)]
pub(super) struct CellCover {
    cells: Vec<ParameterCell>,
    /// By their centers and radii.
    tree: BallTree,
}

impl CellCover {
    /// Cells no longer than a sixteenth of the surface, each nearly flat. `lines`: parameters across which a
    /// cell may not reach, for u and v.
    pub(super) fn new<S: ParametricSurface + CurvatureBounds>(surface: &S, lines: [&[f64]; 2]) -> Self {
        let Domain { u, v, .. } = surface.domain();
        let cut = |range: [f64; 2], lines: &[f64]| {
            let mut ends = vec![range[0]];
            ends.extend(lines.iter().copied().filter(|&x| x > range[0] && x < range[1]));
            ends.push(range[1]);
            ends
        };
        let (us, vs) = (cut(u, lines[0]), cut(v, lines[1]));
        let mut open = Vec::new();
        for a in us.windows(2) {
            for b in vs.windows(2) {
                open.push(ParameterCell::new(surface, [a[0], a[1]], [b[0], b[1]], 0));
            }
        }
        let size = open
            .iter()
            .map(|c| (c.center - open[0].center).norm() + c.radius().min(MOST_RADIUS_MM))
            .fold(0.0, f64::max);
        let mut cells = Vec::new();
        while let Some(cell) = open.pop() {
            let [a, b] = cell.reach();
            let fine = cell.bulge() <= FLAT * (a + b) && a.max(b) <= size / 32.0;
            if fine || cell.depth >= DEEPEST {
                cells.push(cell);
                continue;
            }
            for half in cell.halves(surface) {
                let range = |k: usize| [half.middle[k] - half.half[k], half.middle[k] + half.half[k]];
                let bend = surface.bend(range(0), range(1)).map(|b| b * (1.0 + MARGIN));
                open.push(ParameterCell { bend, ..half });
            }
        }
        let tree = BallTree::new(cells.iter().map(|c| (c.center, c.radius())));
        Self { cells, tree }
    }

    /// Whether every point is at least `reach` away, as far as [`LOOKS`] halvings can prove it.
    pub(super) fn is_beyond<S: ParametricSurface + CurvatureBounds>(&self, surface: &S, p: &Point, reach: f64) -> bool {
        let mut open: Vec<ParameterCell> = Vec::new();
        self.tree.within(p, reach, |k| {
            open.extend(self.cells.get(k as usize).filter(|cell| cell.least(p) < reach));
        });
        let mut looks = 0;
        while let Some(cell) = open.pop() {
            if looks == LOOKS || (cell.center - p).norm() < reach {
                return false;
            }
            looks += 1;
            open.extend(cell.halves(surface).into_iter().filter(|half| half.least(p) < reach));
        }
        true
    }

    /// The nearest point.
    pub(super) fn foot<S: ParametricSurface + CurvatureBounds>(&self, surface: &S, p: &Point) -> Foot {
        let domain = surface.domain();
        let mut best = ([domain.u[0], domain.v[0]], f64::INFINITY);
        for start in self.tree.nearest::<STARTS>(p) {
            let cell = &self.cells[start as usize];
            // The nearest one mostly leads to the nearest point, and the others hold none that is nearer.
            if best.1.is_finite() && cell.least(p) >= best.1 - FOOT_ERROR_MM {
                continue;
            }
            let found = descend(surface, &domain, p, cell.middle);
            if found.1 < best.1 {
                best = found;
            }
        }
        // What may hold the nearest point first: nothing is looked at that the last best could rule out.
        let mut open = BinaryHeap::new();
        let near = |cell: &ParameterCell, best: f64| {
            let least = cell.least(p);
            (least < best - FOOT_ERROR_MM).then_some(OpenCell { least, cell: *cell })
        };
        self.tree.within(p, best.1 - FOOT_ERROR_MM, |k| open.extend(near(&self.cells[k as usize], best.1)));
        let mut looked = 0;
        let mut error = FOOT_ERROR_MM;
        let mut bowl = Bowl::new(surface, p, best);
        while let Some(OpenCell { least, cell }) = open.pop() {
            looked += 1;
            if least >= best.1 - FOOT_ERROR_MM {
                break;
            }
            if looked > MOST_CELLS {
                error = best.1 - least;
                break;
            }
            if bowl.found != best {
                bowl = Bowl::new(surface, p, best);
            }
            if bowl.holds(surface, &domain, &cell) {
                continue;
            }
            for half in cell.halves(surface) {
                let distance = (half.center - p).norm();
                if distance < best.1 - FOOT_ERROR_MM {
                    let found = descend(surface, &domain, p, half.middle);
                    best = if found.1 < distance { found } else { (half.middle, distance) };
                }
                open.extend(near(&half, best.1));
            }
        }
        Foot { parameters: best.0, distance: best.1, error }
    }
}

/// The place found, round which the distance may be proved to have no other minimum: where the second
/// derivatives of `|S - p|^2 / 2`, `S_i . S_j + (S - p) . S_ij`, are positive definite over a box that holds
/// the place and a cell, no point of the cell is nearer than the place. Nor is one where the place lies on
/// the rim, the distance grows from there inward all over the box, and is convex along the rim.
struct Bowl {
    found: ([f64; 2], f64),
    at: Local,
    out: Vector,
}

impl Bowl {
    fn new<S: ParametricSurface>(surface: &S, p: &Point, found: ([f64; 2], f64)) -> Self {
        let at = surface.local(found.0[0], found.0[1]);
        Self { found, out: at.point - p, at }
    }

    fn holds<S: ParametricSurface + CurvatureBounds>(
        &self,
        surface: &S,
        domain: &Domain,
        cell: &ParameterCell,
    ) -> bool {
        let [mut u, v] = self.found.0;
        if domain.u_closed {
            u = wrap_near(u, cell.middle[0], domain.u[1] - domain.u[0]);
        }
        let hull = |x: f64, k: usize| {
            let (low, high) = (cell.middle[k] - cell.half[k], cell.middle[k] + cell.half[k]);
            ([low.min(x), high.max(x)], Interval::new(low.min(x) - x, high.max(x) - x))
        };
        let ((us, du), (vs, dv)) = (hull(u, 0), hull(v, 1));
        let second = surface.second(us, vs);
        let of = |v: &Vector| [v.x, v.y, v.z].map(Interval::of);
        let sum = |a: [Interval; 3], b: [Interval; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let times = |a: [Interval; 3], b: Interval| a.map(|c| c * b);
        let dot = |a: [Interval; 3], b: [Interval; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let along_u = sum(of(&self.at.first[0]), sum(times(second[0], du), times(second[1], dv)));
        let along_v = sum(of(&self.at.first[1]), sum(times(second[1], du), times(second[2], dv)));
        // Mean value theorem from the place along the way to any point of the box.
        let out = sum(of(&self.out), sum(times(along_u, du), times(along_v, dv)));
        let a = dot(along_u, along_u) + dot(out, second[0]);
        let b = dot(along_u, along_v) + dot(out, second[1]);
        let c = dot(along_v, along_v) + dot(out, second[2]);
        if a.low > 0.0 && c.low > 0.0 && a.low * c.low > b.magnitude().powi(2) * (1.0 + MARGIN) {
            return true;
        }
        // On the rim the distance need only grow inward, and be convex along the rim.
        let inward = |x: f64, range: [f64; 2], slope: Interval| {
            (x <= range[0] && slope.low > 0.0) || (x >= range[1] && slope.high < 0.0)
        };
        let rim_u = !domain.u_closed && inward(u, domain.u, dot(out, along_u));
        let rim_v = inward(v, domain.v, dot(out, along_v));
        (rim_v && (rim_u || a.low > 0.0)) || (rim_u && c.low > 0.0)
    }
}

/// The x of its period nearest to another one.
fn wrap_near(x: f64, near: f64, period: f64) -> f64 {
    x + ((near - x) / period).round() * period
}

/// Newton's method on the squared distance, kept in the domain; the step is shortened until it comes nearer.
fn descend<S: ParametricSurface>(surface: &S, domain: &Domain, p: &Point, start: [f64; 2]) -> ([f64; 2], f64) {
    let keep = |[u, v]: [f64; 2]| {
        let u = if domain.u_closed { u } else { u.clamp(domain.u[0], domain.u[1]) };
        [u, v.clamp(domain.v[0], domain.v[1])]
    };
    let mut here = start;
    let mut at = surface.local(here[0], here[1]);
    let mut distance = (at.point - p).norm();
    for _ in 0..STEPS {
        let step = step(&at, p, |k, sense| {
            (k == 1 && at_end(here[1], domain.v, sense))
                || (k == 0 && !domain.u_closed && at_end(here[0], domain.u, sense))
        });
        let mut part = 1.0;
        let mut moved = false;
        while part > LEAST_PART {
            let next = keep([here[0] - part * step[0], here[1] - part * step[1]]);
            let there = surface.local(next[0], next[1]);
            let far = (there.point - p).norm();
            if far < distance {
                (here, at, distance, moved) = (next, there, far, true);
                break;
            }
            part *= 0.25;
        }
        if !moved {
            break;
        }
    }
    (here, distance) = polish(surface, domain, p, here, distance);
    if domain.u_closed {
        let period = domain.u[1] - domain.u[0];
        here[0] -= ((here[0] - domain.u[0]) / period).floor() * period;
    }
    (here, distance)
}

/// The distance is flat round its minimum and stops telling places apart at the root of its rounding; there
/// the gradient goes on.
fn polish<S: ParametricSurface>(surface: &S, domain: &Domain, p: &Point, from: [f64; 2], far: f64) -> ([f64; 2], f64) {
    let (mut here, mut distance) = (from, far);
    for _ in 0..POLISHING {
        let at = surface.local(here[0], here[1]);
        let step = step(&at, p, |k, sense| {
            (k == 1 && at_end(here[1], domain.v, sense))
                || (k == 0 && !domain.u_closed && at_end(here[0], domain.u, sense))
        });
        let moved = at.first[0] * step[0] + at.first[1] * step[1];
        let next = [here[0] - step[0], here[1] - step[1]];
        let inside = (domain.v[0]..=domain.v[1]).contains(&next[1])
            && (domain.u_closed || (domain.u[0]..=domain.u[1]).contains(&next[0]));
        if !inside || moved.norm().is_nan() || moved.norm() >= POLISHED_MM {
            break;
        }
        let there = (surface.local(next[0], next[1]).point - p).norm();
        if there > distance + AWAY_MM {
            break;
        }
        (here, distance) = (next, there);
    }
    (here, distance)
}

fn at_end(x: f64, range: [f64; 2], sense: f64) -> bool {
    (x <= range[0] && sense > 0.0) || (x >= range[1] && sense < 0.0)
}

/// The step of Newton's method, or of Gauss's where the distance has no minimum nearby. `held` takes a
/// parameter and the sign of its gradient and returns whether the parameter is at the end of its range.
fn step(at: &Local, p: &Point, held: impl Fn(usize, f64) -> bool) -> [f64; 2] {
    let f = at.point - p;
    let [su, sv] = &at.first;
    let g = [f.dot(su), f.dot(sv)];
    let gauss = [su.norm_squared(), su.dot(sv), sv.norm_squared()];
    let full: [f64; 3] = std::array::from_fn(|k| gauss[k] + f.dot(&at.second[k]));
    let [a, b, c] = if full[0] > 0.0 && full[0] * full[2] - full[1] * full[1] > LEAST_DETERMINANT * gauss[0] * gauss[2]
    {
        full
    } else {
        gauss
    };
    match (held(0, g[0]), held(1, g[1])) {
        (true, true) => [0.0, 0.0],
        (true, false) => [0.0, g[1] / c],
        (false, true) => [g[0] / a, 0.0],
        (false, false) => {
            let det = a * c - b * b;
            if det > 0.0 { [(c * g[0] - b * g[1]) / det, (a * g[1] - b * g[0]) / det] } else { [g[0] / a, g[1] / c] }
        }
    }
}
