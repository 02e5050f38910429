//! Parts of a design that the rays of a stock cannot resolve.
//!
//! On a ray everything is exact; what lies between rays is inferred from its neighbors. A wall is always
//! met by the set of rays that crosses it, however thin it is. A pin or a rib thinner than the cells in two
//! directions may lie between all rays. Whether it was milled away is then not known, and the verdict must
//! say so.
//!
//! The surface of the design is sampled at the distance of the rays (each triangle in strips along its
//! longest edge, so that no triangle is left out, however small). A sample p with outward normal n is *seen*
//! when a point of a ray lies within [`REACH`] cells of it and the straight line between them runs through
//! the design only:
//!
//! ```text
//!      p
//!     _._______
//!    ( | ) o   o  rays
//!     '-'      o
//! ```
//!
//! 1. A ball of radius 0.71 cell inside of the design that touches its surface near p holds a point of each
//!    set of rays (no point of the plane is farther from the next ray than sqrt(2) / 2 of a cell), and the
//!    line from p to it lies in the ball.
//! 2. Otherwise points of the rays round p are tried one by one: beside p, half a cell in, and in the plane
//!    of the surface.
//!
//! Because of the line, a pin does not count as seen when rays only run through the floor below it. What is
//! seen is compared on that ray (see `gaps`).

use proveout_geom::{Aabb, Point, TriMesh, Vector};
use proveout_stock::TriDexel;
use rayon::prelude::*;

use crate::{DesignMesh, DesignSurface};

/// Distance from a sample within which a ray must see it, in cells. Rays meet a wall oblique to all of them
/// at points up to sqrt(3) cells apart in one direction, and in a corner of the wall the next point may be
/// as far in both.
const REACH: f64 = 2.0;
/// Radius of a ball that no ray of a set misses, and depth of its center, in cells.
const BALL: f64 = 0.71;
const BALL_DEPTH: f64 = 0.75;
/// Depth below the surface from which a line of sight begins, in cells.
const UNDER: f64 = 1e-4;
/// Part of the normal along a ray from which on its crossing with a surface is looked at; the largest is
/// 0.577 or more.
const FLAT: f64 = 0.3;
/// A triangle whose longest edge is this many times that of the stock is taken in parts.
const LARGE: f64 = 4.0;
/// Triangles that are worked on at once by a thread.
const TRIANGLES: usize = 64;
/// What a part of an edge is divided by is this at least: the height is least where it ends.
const NOT_ZERO: f64 = 1e-300;

/// Part of the design that no ray resolves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unseen {
    /// Its area, mm².
    pub area: f64,
    /// The place where the design is thinnest there, the first among equals, mm.
    pub point: Point,
    /// Thickness there, mm.
    pub thickness: f64,
}

/// Rays that can see: a stock, or a patch of it within its window.
#[derive(Clone, Copy)]
pub struct Watcher<'a> {
    /// The rays.
    pub stock: &'a TriDexel,
    /// Where they count; none: wherever no other does.
    pub window: Option<Aabb>,
}

/// Finds what none of the rays resolves; `region` is where the design is judged. The first watcher is the
/// stock.
pub fn unseen(mesh: &TriMesh, design: &DesignMesh, watchers: &[Watcher<'_>], region: Option<&Aabb>) -> Option<Unseen> {
    let count = mesh.triangles.len();
    let parts: Vec<Option<Unseen>> = (0..count.div_ceil(TRIANGLES))
        .into_par_iter()
        .map(|k| {
            let mut sum: Option<Unseen> = None;
            for t in k * TRIANGLES..count.min((k + 1) * TRIANGLES) {
                each_sample(mesh, t, watchers, &mut |p, n, area, beyond| {
                    if region.is_some_and(|r| !r.contains(p)) || !beyond && is_seen(design, watchers, p, n) {
                        return;
                    }
                    let thickness = design.thickness(p, n);
                    add(&mut sum, Unseen { area, point: *p, thickness });
                });
            }
            sum
        })
        .collect();
    let mut all = None;
    parts.into_iter().flatten().for_each(|part| add(&mut all, part));
    all
}

fn add(sum: &mut Option<Unseen>, new: Unseen) {
    *sum = Some(match *sum {
        None => new,
        Some(old) => {
            let thinner = if new.thickness < old.thickness { new } else { old };
            Unseen { area: old.area + new.area, ..thinner }
        }
    });
}

/// The watcher of a place.
pub(crate) fn watcher<'a, 'b>(watchers: &'b [Watcher<'a>], p: &Point) -> Option<&'b Watcher<'a>> {
    let patch = watchers.iter().find(|w| w.window.is_some_and(|b| b.contains(p)));
    patch.or_else(|| watchers.iter().find(|w| w.window.is_none()))
}

/// Takes samples: place, outward normal, area that it represents, and whether no ray can be near.
pub(crate) type See<'a> = dyn FnMut(&Point, &Vector, f64, bool) + 'a;

/// Calls with samples of a triangle. One that is far larger than the stock is halved, and halves that no ray
/// comes near are one sample each: a design in another unit costs no more than one that fits.
pub(crate) fn each_sample(mesh: &TriMesh, t: usize, watchers: &[Watcher<'_>], see: &mut See<'_>) {
    let corners = mesh.corners(t);
    let Some(stock) = watchers.first().map(|w| w.stock) else { return };
    let longest = |t: &[Point; 3]| (0..3).map(|k| (t[(k + 1) % 3] - t[k]).norm()).fold(0.0, f64::max);
    let most = LARGE * stock.bounds().size().max();
    let near = stock.bounds().expanded((REACH + 1.0) * stock.cell_mm());
    let mut open = vec![corners];
    while let Some(t) = open.pop() {
        if longest(&t) <= most {
            samples(&t, watchers, see);
            continue;
        }
        // A ray can be near a place outside the stock's box along one axis at most: along that of the ray.
        let own = Aabb::of_points(&t);
        let beside = (0..3).filter(|&i| own.max[i] < near.min[i] || near.max[i] < own.min[i]).count();
        if beside >= 2 {
            let across = (t[1] - t[0]).cross(&(t[2] - t[0]));
            if let Some(normal) = across.try_normalize(0.0) {
                let middle = Point::from((t[0].coords + t[1].coords + t[2].coords) / 3.0);
                see(&middle, &normal, 0.5 * across.norm(), true);
            }
            continue;
        }
        let k = (0..3).fold(0, |best, k| {
            let length = |k: usize| (t[(k + 1) % 3] - t[k]).norm_squared();
            if length(k) > length(best) { k } else { best }
        });
        let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
        let middle = a + (b - a) * 0.5;
        open.extend([[a, middle, c], [middle, b, c]]);
    }
}

/// Samples of a triangle that is no larger than the stock by much.
fn samples(corners: &[Point; 3], watchers: &[Watcher<'_>], see: &mut See<'_>) {
    let area_normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let Some(normal) = area_normal.try_normalize(0.0) else { return };
    let middle = Point::from((corners[0].coords + corners[1].coords + corners[2].coords) / 3.0);
    let finest = watchers
        .iter()
        .filter(|w| w.window.is_none_or(|b| b.intersects(&Aabb::of_points(corners))))
        .flat_map(|w| w.stock.cells_mm())
        .fold(f64::INFINITY, f64::min);
    if !finest.is_finite() {
        return;
    }
    // The longest edge first: a to b, with c opposite.
    let longest = (0..3).max_by(|&i, &j| {
        let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm_squared();
        length(i).total_cmp(&length(j)).then(j.cmp(&i))
    });
    let k = longest.unwrap_or(0);
    let (a, b, c) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
    let (along, length) = (b - a, (b - a).norm());
    let foot = ((c - a).dot(&along) / (length * length)).clamp(0.0, 1.0);
    let height = area_normal.norm() / length; // the normal is as long as twice the area
    let strips = (length / finest).ceil().max(1.0);
    if strips <= 1.0 && height <= finest {
        return see(&middle, &normal, 0.5 * area_normal.norm(), false);
    }
    let up = c - (a + along * foot);
    for i in 0..strips as usize {
        let x = (i as f64 + 0.5) / strips;
        // Part of the height that the triangle has over this place of its longest edge.
        let part = if x < foot { x / foot } else { (1.0 - x) / (1.0 - foot).max(NOT_ZERO) }.min(1.0);
        let rows = (height * part / finest).ceil().max(1.0);
        let area = length / strips * height * part / rows;
        for j in 0..rows as usize {
            let y = (j as f64 + 0.5) / rows * part;
            see(&(a + along * x + up * y), &normal, area, false);
        }
    }
}

fn is_seen(design: &DesignMesh, watchers: &[Watcher<'_>], p: &Point, n: &Vector) -> bool {
    let Some(watcher) = watcher(watchers, p) else { return false };
    let stock = watcher.stock;
    let cell = stock.cell_mm();
    let center = p - n * (BALL_DEPTH * cell);
    if stock.bounds().contains(&center) && design.nearest(&center, BALL * cell).is_none() {
        return true;
    }
    let from = p - n * (UNDER * cell);
    // The nine rays round the sample first; on a slanted wall the next one may be one farther.
    (0..3).any(|ring| sees_from(design, stock, &from, n, ring)) || crosses_near(design, stock, &from)
}

/// Whether a ray goes through a thin part of the design near the place and sees it from there: at the end of
/// a wall, whose sides have another normal than the place.
fn crosses_near(design: &DesignMesh, stock: &TriDexel, from: &Point) -> bool {
    let reach = REACH * stock.cell_mm();
    for axis in 0..3 {
        for (di, dj) in (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))) {
            let Some(ray) = stock.ray_near(axis, from, [di, dj]) else { continue };
            let ends = [from[axis] - reach, from[axis] + reach].map(|at| ray.point(at));
            let near = |p: &Point| (p - from).norm() <= reach;
            if design.middles_inside(&ends[0], &ends[1]).iter().any(|p| near(p) && design.is_free(from, p)) {
                return true;
            }
        }
    }
    false
}

/// Whether a point of a ray in a ring round the place sees it.
fn sees_from(design: &DesignMesh, stock: &TriDexel, from: &Point, n: &Vector, ring: isize) -> bool {
    let cell = stock.cell_mm();
    let mut tries: Vec<(f64, usize, Point)> = Vec::new();
    for axis in 0..3 {
        for (di, dj) in (-ring..=ring).flat_map(|i| (-ring..=ring).map(move |j| (i, j))) {
            if di.abs().max(dj.abs()) != ring {
                continue;
            }
            let Some(ray) = stock.ray_near(axis, from, [di, dj]) else { continue };
            // At the sample, half a cell in, and where the ray meets the plane of the surface: in a thin
            // wall.
            let aside = ray.point(from[axis]) - from;
            let beside = [0.0, 0.5].map(|inward| from[axis] - inward * cell * n[axis]);
            let on_plane = (n[axis].abs() > FLAT).then(|| from[axis] - aside.dot(n) / n[axis]);
            for height in beside.into_iter().chain(on_plane) {
                let at = ray.point(height);
                let apart = (at - from).norm();
                if apart <= REACH * cell {
                    tries.push((apart, tries.len(), at));
                }
            }
        }
    }
    tries.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    tries.iter().any(|(_, _, at)| design.is_free(from, at))
}
