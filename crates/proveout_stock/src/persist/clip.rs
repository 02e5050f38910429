//! A surface cut at the faces of boxes: inside of one, or outside of all.
//!
//! A triangle is cut by one plane after the other (Sutherland and Hodgman 1974). A corner on a plane belongs
//! to both sides, and a cut edge has one new vertex for both triangles at it, so that each part hangs
//! together as the whole did.

use std::collections::HashMap;

use proveout_geom::{Aabb, Point, Vector};

use crate::query::surface::SurfaceMesh;

/// Means of unit normals that are shorter have no direction.
const SHORTEST: f64 = 1e-9;

impl SurfaceMesh {
    /// The part inside of a box, its faces included.
    #[must_use]
    pub fn inside(&self, bounds: &Aabb) -> Self {
        let mut cutter = MeshClipper::new(self);
        let mut kept = Vec::new();
        for t in &self.mesh.triangles {
            kept.extend(fan(&cutter.divide(t.to_vec(), bounds, 0).0));
        }
        cutter.finish(kept)
    }

    /// The part outside of boxes; a triangle that lies in a face of a box is inside.
    #[must_use]
    pub fn outside(&self, boxes: &[Aabb]) -> Self {
        if boxes.is_empty() {
            return self.clone();
        }
        let mut cutter = MeshClipper::new(self);
        let mut kept = Vec::new();
        for t in &self.mesh.triangles {
            let mut left = vec![t.to_vec()];
            for (k, bounds) in boxes.iter().enumerate() {
                left = left.into_iter().flat_map(|polygon| cutter.divide(polygon, bounds, 6 * k as u32).1).collect();
            }
            left.iter().for_each(|polygon| kept.extend(fan(polygon)));
        }
        cutter.finish(kept)
    }
}

/// Triangles of a convex polygon; none of fewer than three corners.
fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    polygon.windows(2).skip(1).map(|w| [polygon[0], w[0], w[1]])
}

struct MeshClipper {
    out: SurfaceMesh,
    /// Vertices on cut edges, by the ends of the edge (the smaller first) and the number of the plane.
    cuts: HashMap<(u32, u32, u32), u32>,
}

impl MeshClipper {
    fn new(surface: &SurfaceMesh) -> Self {
        Self { out: surface.clone(), cuts: HashMap::new() }
    }

    /// What of a convex polygon lies in a box, and what lies outside of it; `plane` numbers the first of its
    /// six faces.
    fn divide(&mut self, mut polygon: Vec<u32>, bounds: &Aabb, plane: u32) -> (Vec<u32>, Vec<Vec<u32>>) {
        let mut outside = Vec::new();
        let corners = polygon.iter().map(|&i| &self.out.mesh.positions[i as usize]);
        let round = Aabb::of_points(corners);
        if !round.intersects(bounds) {
            return (Vec::new(), vec![polygon]);
        }
        for axis in 0..3 {
            for (side, (sign, face)) in [(-1.0, bounds.min[axis]), (1.0, bounds.max[axis])].into_iter().enumerate() {
                let number = plane + 2 * axis as u32 + side as u32;
                let (within, beyond) = self.split(&polygon, axis, sign, face, number);
                if beyond.len() > 2 {
                    outside.push(beyond);
                }
                polygon = within;
                if polygon.is_empty() {
                    return (polygon, outside);
                }
            }
        }
        (polygon, outside)
    }

    /// Parts of a polygon with `sign (x - face) <= 0` and `>= 0`; a polygon in the plane is within.
    fn split(&mut self, polygon: &[u32], axis: usize, sign: f64, face: f64, number: u32) -> (Vec<u32>, Vec<u32>) {
        let height = |i: u32| sign * (self.out.mesh.positions[i as usize][axis] - face);
        let heights: Vec<f64> = polygon.iter().map(|&i| height(i)).collect();
        if heights.iter().all(|h| *h <= 0.0) {
            return (polygon.to_vec(), Vec::new());
        }
        if heights.iter().all(|h| *h >= 0.0) {
            return (Vec::new(), polygon.to_vec());
        }
        let (mut within, mut beyond) = (Vec::new(), Vec::new());
        for k in 0..polygon.len() {
            let next = (k + 1) % polygon.len();
            if heights[k] <= 0.0 {
                within.push(polygon[k]);
            }
            if heights[k] >= 0.0 {
                beyond.push(polygon[k]);
            }
            if heights[k] * heights[next] < 0.0 {
                let cut = self.cut(polygon[k], polygon[next], axis, face, number);
                within.push(cut);
                beyond.push(cut);
            }
        }
        (within, beyond)
    }

    /// The vertex where an edge meets a face; the same bits from both sides of the edge.
    fn cut(&mut self, i: u32, j: u32, axis: usize, face: f64, number: u32) -> u32 {
        let (low, high) = (i.min(j), i.max(j));
        let next = self.out.mesh.positions.len() as u32;
        let index = *self.cuts.entry((low, high, number)).or_insert(next);
        if index == next {
            let (a, b) = (low as usize, high as usize);
            let (p, q) = (self.out.mesh.positions[a], self.out.mesh.positions[b]);
            let t = (face - p[axis]) / (q[axis] - p[axis]);
            let mut point: Point = p + (q - p) * t;
            point[axis] = face;
            let normal: Vector = self.out.normals[a] * (1.0 - t) + self.out.normals[b] * t;
            let near = if t < 0.5 { a } else { b };
            self.out.mesh.positions.push(point);
            self.out.normals.push(normal.try_normalize(SHORTEST).unwrap_or(self.out.normals[near]));
            self.out.made_by.push(self.out.made_by[near]);
        }
        index
    }

    fn finish(mut self, triangles: Vec<[u32; 3]>) -> SurfaceMesh {
        self.out.mesh.triangles = triangles;
        self.out.without_loose_vertices()
    }
}
