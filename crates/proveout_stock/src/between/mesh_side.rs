//! On which side of a closed mesh a point lies, and whether its skin is near: a tree of boxes over the
//! triangles.
//!
//! Inside is where the winding number is positive, as on the rays of the stock: the crossings of a line from
//! the point, counted by their sense. A crossing so near to an edge that rounding could count it twice or not
//! at all makes the line a bad one, and another is taken.

use proveout_geom::{Aabb, Point, TriMesh, Vector};

use crate::query::mesh_error::to_triangle;

/// Triangles near a place that are looked at for half spaces.
const MOST_NEAR: usize = 48;
/// Triangles of a leaf.
const LEAF: usize = 4;
/// Directions of lines, along no face that anybody draws.
const LINES: [[f64; 3]; 4] = [
    [0.577_215_664, 0.303_129_995, 0.757_872_156],
    [-0.431_294_481, 0.915_965_594, 0.261_497_212],
    [0.662_743_419, -0.187_859_642, -0.730_244_114],
    [-0.132_716_548, -0.870_588_379, 0.489_261_307],
];
/// Part of a triangle by which a crossing keeps from its edges.
const EDGE: f64 = 1e-9;

#[derive(Clone, Copy, Debug)]
struct FaceNode {
    bounds: Aabb,
    /// Range of triangles of a leaf; else the second child, the first is the next node.
    first: u32,
    count: u32,
}

/// See the text of the file.
#[derive(Clone, Debug)]
pub(super) struct MeshSide {
    nodes: Vec<FaceNode>,
    triangles: Vec<[Point; 3]>,
}

impl MeshSide {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let mut side =
            Self { nodes: Vec::new(), triangles: (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect() };
        let mut triangles = std::mem::take(&mut side.triangles);
        side.build(&mut triangles, 0);
        side.triangles = triangles;
        side
    }

    fn build(&mut self, triangles: &mut [[Point; 3]], first: usize) {
        let bounds = triangles.iter().flatten().fold(Aabb::empty(), |mut all, p| {
            all.grow(p);
            all
        });
        let at = self.nodes.len();
        self.nodes.push(FaceNode { bounds, first: first as u32, count: triangles.len() as u32 });
        if triangles.len() <= LEAF {
            return;
        }
        let size = bounds.size();
        let a = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
        let middle = triangles.len() / 2;
        let key = |t: &[Point; 3]| t[0][a] + t[1][a] + t[2][a];
        triangles.select_nth_unstable_by(middle, |s, t| key(s).total_cmp(&key(t)));
        let (low, high) = triangles.split_at_mut(middle);
        self.build(low, first);
        let second = self.nodes.len() as u32;
        self.nodes[at] = FaceNode { bounds, first: second, count: 0 };
        self.build(high, first + middle);
    }

    /// True where a triangle is nearer to a point than `radius`.
    fn is_near(&self, node: usize, c: &Point, radius: f64) -> bool {
        let Some(n) = self.nodes.get(node) else { return false };
        let beyond = (n.bounds.min - c).sup(&(c - n.bounds.max)).map(|x| x.max(0.0));
        if beyond.norm_squared() >= radius * radius {
            return false;
        }
        if n.count == 0 && !self.triangles.is_empty() {
            return self.is_near(node + 1, c, radius) || self.is_near(n.first as usize, c, radius);
        }
        let range = n.first as usize..(n.first + n.count) as usize;
        self.triangles[range].iter().any(|[x, y, z]| to_triangle(c, [x, y, z]) < radius)
    }

    fn collect_near(&self, node: usize, c: &Point, radius: f64, out: &mut Vec<[Point; 3]>) {
        let Some(n) = self.nodes.get(node) else { return };
        let beyond = (n.bounds.min - c).sup(&(c - n.bounds.max)).map(|x| x.max(0.0));
        if beyond.norm_squared() > radius * radius || out.len() > MOST_NEAR || self.triangles.is_empty() {
            return;
        }
        if n.count == 0 {
            self.collect_near(node + 1, c, radius, out);
            self.collect_near(n.first as usize, c, radius, out);
            return;
        }
        let range = n.first as usize..(n.first + n.count) as usize;
        out.extend(self.triangles[range].iter().filter(|[x, y, z]| to_triangle(c, [x, y, z]) <= radius));
    }

    /// Half spaces that hold all material within a ball: distance of its center beyond each, and the normal.
    ///
    /// They are the planes of triangles in the ball that have all other triangles of the ball on
    /// their inner side. The skin does not enter the part of the ball beyond such a plane: that
    /// part is entirely outside, or entirely inside another shell, which a test of one point
    /// decides.
    pub(super) fn faces(&self, c: &Point, radius: f64) -> Vec<(f64, Vector)> {
        let mut near = Vec::new();
        self.collect_near(0, c, radius, &mut near);
        let mut out: Vec<(f64, Vector)> = Vec::new();
        if near.len() > MOST_NEAR {
            return out;
        }
        for [x, y, z] in &near {
            let area = (y - x).cross(&(z - x));
            let size = area.norm();
            if size < 1e-12 {
                continue;
            }
            let normal = area / size;
            let off = normal.dot(&(c - x));
            let behind = |p: &Point| normal.dot(&(p - x)) <= 1e-6;
            let known = out.iter().any(|(d, n)| (d - off).abs() < 1e-9 && (n - normal).norm() < 1e-9);
            // Another shell may hold the far side.
            let far = c + normal * (0.999 * radius);
            if !known && near.iter().flatten().all(behind) && off > -0.99 * radius && !self.is_wound(&far) {
                out.push((off, normal));
            }
        }
        out
    }

    /// Crossings of a line from a point by their sense; none where one lies on an edge.
    fn winding(&self, p: &Point, line: &Vector) -> Option<i32> {
        let mut winding = 0;
        let mut open = vec![0_usize];
        while let Some(node) = open.pop() {
            let Some(n) = self.nodes.get(node) else { continue };
            let (mut from, mut to) = (0.0_f64, f64::INFINITY);
            for a in 0..3 {
                let s = [(n.bounds.min[a] - 1e-9 - p[a]) / line[a], (n.bounds.max[a] + 1e-9 - p[a]) / line[a]];
                from = from.max(s[0].min(s[1]));
                to = to.min(s[0].max(s[1]));
            }
            if from > to {
                continue;
            }
            if n.count == 0 {
                open.extend([node + 1, n.first as usize]);
                continue;
            }
            for [x, y, z] in &self.triangles[n.first as usize..(n.first + n.count) as usize] {
                let (u, v) = (y - x, z - x);
                let normal = u.cross(&v);
                let rate = normal.dot(line);
                let scale = normal.norm();
                if rate.abs() <= 1e-12 * scale {
                    if scale > 0.0 && normal.dot(&(p - x)).abs() <= 1e-9 * scale {
                        return None;
                    }
                    continue;
                }
                let way = normal.dot(&(x - p)) / rate;
                if way < 0.0 {
                    continue;
                }
                let at = p + line * way - x;
                let square = normal.norm_squared();
                let (s, t) = (at.cross(&v).dot(&normal) / square, u.cross(&at).dot(&normal) / square);
                let least = s.min(t).min(1.0 - s - t);
                if least.abs() <= EDGE {
                    return None;
                }
                if least > 0.0 {
                    winding += if rate > 0.0 { 1 } else { -1 };
                }
            }
        }
        Some(winding)
    }

    fn is_wound(&self, p: &Point) -> bool {
        !self.triangles.is_empty()
            && LINES.iter().find_map(|line| self.winding(p, &Vector::from(*line))).is_some_and(|w| w > 0)
    }

    /// True where no material is nearer to a point than `radius`.
    pub(super) fn is_outside(&self, c: &Point, radius: f64) -> bool {
        !self.is_near(0, c, radius) && !self.is_wound(c)
    }

    /// True at least `depth` below the skin.
    pub(super) fn is_inside(&self, p: &Point, depth: f64) -> bool {
        !self.is_near(0, p, depth) && self.is_wound(p)
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::box_mesh;

    use super::*;

    #[test]
    fn sides_of_two_blocks_are_those_of_their_boxes() {
        let boxes = [[[0.0, 0.0, 0.0], [10.0, 6.0, 4.0]], [[12.0, 1.0, -3.0], [12.2, 1.2, 9.0]]]
            .map(|[a, b]| Aabb { min: Point::from(a), max: Point::from(b) });
        let mut mesh = box_mesh(&boxes[0]);
        mesh.append(&box_mesh(&boxes[1]));
        let side = MeshSide::new(&mesh);
        for k in 0..20_000_u32 {
            let t = f64::from(k);
            // Many of them on planes of the boxes and in line with their corners.
            let p = Point::new((t * 0.1) % 14.0 - 1.0, ((t / 7.0).floor() * 0.1) % 8.0 - 1.0, (t * 0.05) % 14.0 - 4.0);
            let depth = boxes.iter().map(|b| (b.min - p).sup(&(p - b.max)).max()).fold(f64::INFINITY, f64::min);
            if depth > 1e-9 {
                assert!(side.is_outside(&p, depth * 0.999) && !side.is_inside(&p, 0.0), "{p:?}");
                assert!(!side.is_outside(&p, depth * 1.75 + 1e-6) || depth > 0.0);
            } else if depth < -1e-9 {
                assert!(!side.is_outside(&p, 0.0) && side.is_inside(&p, -depth * 0.999), "{p:?}");
                assert!(!side.is_inside(&p, -depth * 1.001));
            }
        }
    }
}
