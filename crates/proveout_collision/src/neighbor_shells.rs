//! Parts of a neighbor that lie in the zone of the bearing and bear nothing.
//!
//! A stop that is screwed on the rail of a slide is no higher than the zone that is left out round
//! what bears (`neighbors.rs`), and the slide runs into it all the same. A connected part of a body
//! is checked as a whole, against all of the other body, where
//!
//! ```text
//!    it lies wholly in the zone,            nothing of it would be left to check
//!    it is not near the other at rest,      it bears nothing there
//!    it is outside of the outline of what bears, seen along the joint's motion:
//!
//!          slide at rest        stop                  outline of the rail, seen along its way
//!         .-------------.       .--.                    .--.     <- stop: outside
//!         |_____________|_______|__|________            |##|
//!         |__________________________rail__|            |##|
//! ```
//!
//! A rail in several pieces has one outline: the slide runs over each of them as it rests on the first.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use proveout_geom::{Point, Vector};

use crate::triangle_tree::TriangleTree;

/// A part is outside of an outline if it exceeds it by more than this, mm: less is a chamfer, or a
/// joint of two pieces.
const STANDS_OUT_MM: f64 = 0.5;
/// Triangles at an edge whose directions differ by less lie on each other, radian.
const FLAT: f64 = 1e-6;

/// A rectangle of coordinates that the joint does not change: low and high of each.
type Outline = [[f64; 2]; 2];

/// What is asked of the two bodies.
pub(crate) trait Bodies {
    /// Whether nothing of some triangles of a body is left outside of the zone.
    fn in_zone(&self, triangles: &[[Point; 3]]) -> bool;

    /// Whether some triangles of a body are near the other at rest, or inside of it.
    fn bears(&self, body: usize, triangles: &[[Point; 3]]) -> bool;

    /// Rectangle of a triangle.
    fn outline(&self, triangle: &[Point; 3]) -> Outline;
}

/// Two skins that are held apart whole, one of each body.
pub(crate) type SkinPair = [Arc<TriangleTree>; 2];

/// Pairs of a part that bears nothing and all of the other body.
pub(crate) fn pairs(of: &impl Bodies, bodies: [&Arc<TriangleTree>; 2]) -> Vec<SkinPair> {
    let mut all = Vec::new();
    for k in 0..2 {
        let parts = connected(bodies[k].triangles());
        if parts.len() < 2 {
            continue;
        }
        let (idle, others): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|part| of.in_zone(part) && !of.bears(k, part));
        if idle.is_empty() {
            continue;
        }
        let outline = |part: &[[Point; 3]]| part.iter().map(|t| of.outline(t)).reduce(round);
        let bearing: Vec<Outline> =
            others.iter().filter(|part| of.bears(k, part)).filter_map(|part| outline(part)).collect();
        for part in idle {
            if outline(&part).is_some_and(|own| !bearing.iter().any(|b| holds(b, &own))) {
                let part = Arc::new(TriangleTree::of_triangles(part));
                all.push(if k == 0 { [part, bodies[1].clone()] } else { [bodies[0].clone(), part] });
            }
        }
    }
    all
}

fn round(a: Outline, b: Outline) -> Outline {
    [0, 1].map(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])])
}

fn holds(outer: &Outline, inner: &Outline) -> bool {
    (0..2).all(|k| outer[k][0] - STANDS_OUT_MM <= inner[k][0] && inner[k][1] <= outer[k][1] + STANDS_OUT_MM)
}

/// A point as its bits, with one zero.
fn key(p: &Point) -> [u64; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}

/// An edge by its ends, the lower bits first, and a triangle at it.
type Edge = ([[u64; 3]; 2], usize);

/// Groups of triangles connected by edges, in the order of their first one. Where parts touch in an
/// edge, the material decides which triangles belong together.
fn connected(triangles: &[[Point; 3]]) -> Vec<Vec<[Point; 3]>> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let mut edge = [key(&t[k]), key(&t[(k + 1) % 3])];
            edge.sort_unstable();
            edges.push((edge, i));
        }
    }
    edges.sort_unstable();
    let mut parent: Vec<usize> = (0..triangles.len()).collect();
    for at in edges.chunk_by(|a, b| a.0 == b.0) {
        let pairs = if let [(_, a), (_, b)] = *at { vec![[a, b]] } else { wedges(triangles, at) };
        for [a, b] in pairs {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut parts: BTreeMap<usize, Vec<[Point; 3]>> = BTreeMap::new();
    for (i, t) in triangles.iter().enumerate() {
        parts.entry(root(&mut parent, i)).or_default().push(*t);
    }
    parts.into_values().collect()
}

/// The pairs of triangles at an edge that bound the same material. Seen against the edge, material lies
/// counter-clockwise of a triangle that runs against the edge, up to the next one that runs along it.
fn wedges(triangles: &[[Point; 3]], at: &[Edge]) -> Vec<[usize; 2]> {
    let mut frame: Option<[Vector; 2]> = None;
    let mut turned: Vec<(usize, bool, f64)> = Vec::with_capacity(at.len());
    for (ends, i) in at {
        let t = &triangles[*i];
        let runs = |k: usize| [key(&t[k]), key(&t[(k + 1) % 3])];
        let Some(k) = (0..3).find(|k| runs(*k) == *ends || runs(*k) == [ends[1], ends[0]]) else { continue };
        let is_along = runs(k) == *ends;
        let (begin, end) = if is_along { (t[k], t[(k + 1) % 3]) } else { (t[(k + 1) % 3], t[k]) };
        let apex = t[(k + 2) % 3];
        let Some(edge) = (end - begin).try_normalize(0.0) else { continue };
        let out = (apex - begin) - edge * (apex - begin).dot(&edge);
        let Some(unit) = out.try_normalize(0.0) else { continue };
        let [right, above] = *frame.get_or_insert_with(|| [unit, edge.cross(&unit)]);
        turned.push((*i, is_along, out.dot(&above).atan2(out.dot(&right))));
    }
    let pair = |&(i, _, from): &(usize, bool, f64)| {
        let up = |to: f64| {
            let turn = (to - from).rem_euclid(TAU);
            if turn < FLAT { TAU } else { turn }
        };
        let ahead = turned.iter().filter(|t| t.1);
        let next = ahead.min_by(|a, b| up(a.2).total_cmp(&up(b.2)))?;
        Some([i, next.0])
    };
    turned.iter().filter(|t| !t.1).filter_map(pair).collect()
}

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh};

    use super::*;

    /// Boxes that touch with faces or edges are parts of their own.
    #[test]
    fn boxes_that_touch_are_apart() {
        let block = |min: [f64; 3], max: [f64; 3]| {
            let mesh = box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) });
            (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect::<Vec<_>>()
        };
        let all = [
            block([0.0; 3], [9.0, 9.0, 9.0]),
            block([2.0, 2.0, 9.0], [5.0, 5.0, 12.0]),
            block([9.0, 0.0, 0.0], [12.0, 9.0, 9.0]),
        ]
        .concat();
        assert_eq!(connected(&all).iter().map(Vec::len).collect::<Vec<_>>(), [12, 12, 12]);
    }
}
