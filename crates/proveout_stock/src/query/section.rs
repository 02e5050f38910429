//! Section of a closed mesh with a plane.
//!
//! A corner lies above the plane, or on it and below: with this rule no corner is ever on the plane, every
//! triangle has none or one segment of the section, and every cut edge belongs to two triangles. So each
//! segment has one that follows it, and the outlines close.

use std::collections::BTreeMap;

use proveout_geom::{Point, TriMesh, Vector};

/// One closed outline of a section: points in order, the last one joined to the first; the material lies to
/// the left seen against the normal of the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Corners, mm.
    pub points: Vec<Point>,
}

impl Outline {
    /// Signed area seen against the unit normal of the plane, mm²: positive round material, negative round a
    /// hole.
    pub fn area(&self, normal: &Vector) -> f64 {
        let Some(origin) = self.points.first() else { return 0.0 };
        let turn = |k: usize| {
            let (a, b) = (self.points[k] - origin, self.points[(k + 1) % self.points.len()] - origin);
            a.cross(&b).dot(normal)
        };
        0.5 * (0..self.points.len()).map(turn).sum::<f64>()
    }
}

/// A normal that is shorter is none.
const SHORTEST: f64 = 1e-12;

pub(crate) fn outlines(mesh: &TriMesh, on: &Point, normal: &Vector) -> Vec<Outline> {
    let Some(n) = normal.try_normalize(SHORTEST) else { return Vec::new() };
    let height: Vec<f64> = mesh.positions.iter().map(|p| (p - on).dot(&n)).collect();
    let above = |v: u32| height[v as usize] > 0.0;
    // Segments by the edge that they begin at: the edge of a triangle that goes down through the plane, to
    // the one that goes up. Seen against the normal the material is then to the left.
    let mut next: BTreeMap<(u32, u32), Vec<(u32, u32)>> = BTreeMap::new();
    for t in &mesh.triangles {
        let edges = [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let key = |(a, b): (u32, u32)| (a.min(b), a.max(b));
        let up = edges.iter().find(|(a, b)| !above(*a) && above(*b));
        let down = edges.iter().find(|(a, b)| above(*a) && !above(*b));
        if let (Some(&up), Some(&down)) = (up, down) {
            next.entry(key(down)).or_default().push(key(up));
        }
    }
    let point = |(a, b): (u32, u32)| {
        let (ha, hb) = (height[a as usize], height[b as usize]);
        let (p, q) = (mesh.positions[a as usize], mesh.positions[b as usize]);
        p + (q - p) * (ha / (ha - hb))
    };
    let mut out = Vec::new();
    while let Some(mut entry) = next.first_entry() {
        let first = *entry.key();
        let mut at = entry.get_mut().pop();
        if entry.get().is_empty() {
            entry.remove();
        }
        let mut points = vec![point(first)];
        while let Some(edge) = at.filter(|e| *e != first) {
            points.push(point(edge));
            at = next.get_mut(&edge).and_then(Vec::pop);
            if next.get(&edge).is_some_and(Vec::is_empty) {
                next.remove(&edge);
            }
        }
        points.dedup();
        if points.len() > 2 {
            out.push(Outline { points });
        }
    }
    out
}
