//! Distance of two triangles in closed form.
//!
//! Two triangles that do not cross are nearest at a vertex of one and the face of the other, or at two edges:
//! the nearest points of two convex bodies lie on features whose normal cones meet, and two faces that are
//! parallel have such a pair on their border. So the distance is the least of 9 distances of edges and 6 of
//! vertices over a face. They cross where an edge of one passes through the face of the other; triangles in
//! one plane cross with their edges.
//!
//! Degenerate triangles have no face but still have edges, whose distances are those of segments, or of
//! points.
//!
//! Each candidate is a distance between two points of the triangles, so rounding never makes it smaller than
//! what is there by more than 1e-15 of the coordinates. It can be larger: of two edges that are almost
//! parallel, the place where they are nearest is known to one part in `1e-16 / sin^2`, which moves the
//! distance by no more than 1e-8 of the edges. Their four ends are tried as well, so that parallel edges have
//! no such error.

use proveout_geom::{Point, Vector};

/// Squared sine of the angle of two edges below which their ends are tried as well: there the foot of the
/// common perpendicular is known to 1e-8 of the edges only.
const ALMOST_PARALLEL: f64 = 1e-8;
/// Area, as a part of the squares of two edges, below which a triangle has no normal.
const NO_AREA: f64 = 1e-14;

/// Two points that are near each other, one on each body, and the square of their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearestPoints {
    pub(crate) square: f64,
    pub(crate) on_first: Point,
    pub(crate) on_second: Point,
}

impl NearestPoints {
    fn of(on_first: Point, on_second: Point) -> Self {
        Self { square: (on_first - on_second).norm_squared(), on_first, on_second }
    }

    fn keep(&mut self, other: Self) {
        if other.square < self.square {
            *self = other;
        }
    }
}

/// Nearest points of two triangles; both the same point where they cross.
#[cfg(test)]
pub(crate) fn nearest(first: &[Point; 3], second: &[Point; 3]) -> NearestPoints {
    nearest_within(first, second, f64::INFINITY)
}

/// Nearest points of two triangles; both the same point where they cross. Where one lies wholly on one side
/// of the other's plane, at least `bound` (mm) from it, that height is given as the distance, with any two
/// points.
pub(crate) fn nearest_within(first: &[Point; 3], second: &[Point; 3], bound: f64) -> NearestPoints {
    let faces = [TriangleFace::of(first), TriangleFace::of(second)];
    let over = |face: &Option<TriangleFace<'_>>, other: &[Point; 3]| {
        face.as_ref().map_or([0.0; 3], |f| other.map(|p| f.height(&p)))
    };
    let heights = [over(&faces[0], second), over(&faces[1], first)];
    for h in &heights {
        let least = h.iter().fold(f64::INFINITY, |l, x| l.min(*x)).max(h.iter().fold(f64::INFINITY, |l, x| l.min(-x)));
        if least >= bound {
            return NearestPoints { square: least * least, on_first: first[0], on_second: second[0] };
        }
    }
    let mut best = NearestPoints::of(first[0], second[0]);
    if let Some(face) = &faces[1] {
        if let Some(x) = face.crossing(first, heights[1]) {
            return NearestPoints { square: 0.0, on_first: x, on_second: x };
        }
        for (p, height) in first.iter().zip(heights[1]) {
            if let Some(foot) = face.foot(p, height) {
                best.keep(NearestPoints::of(*p, foot));
            }
        }
    }
    if let Some(face) = &faces[0] {
        if let Some(x) = face.crossing(second, heights[0]) {
            return NearestPoints { square: 0.0, on_first: x, on_second: x };
        }
        for (p, height) in second.iter().zip(heights[0]) {
            if let Some(foot) = face.foot(p, height) {
                best.keep(NearestPoints::of(foot, *p));
            }
        }
    }
    for (p, q) in edges(first) {
        for (r, s) in edges(second) {
            best.keep(segments(p, q, r, s));
        }
    }
    best
}

fn edges(t: &[Point; 3]) -> [(Point, Point); 3] {
    [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]
}

/// The inside of a triangle.
struct TriangleFace<'a> {
    corners: &'a [Point; 3],
    normal: Vector,
}

impl<'a> TriangleFace<'a> {
    /// None for a triangle that has no area to speak of: its edges say all there is.
    fn of(corners: &'a [Point; 3]) -> Option<Self> {
        let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
        let across = u.cross(&v);
        let area = across.norm();
        (area > NO_AREA * (u.norm_squared() + v.norm_squared())).then(|| Self { corners, normal: across / area })
    }

    fn height(&self, p: &Point) -> f64 {
        (p - self.corners[0]).dot(&self.normal)
    }

    /// Whether a point over or under the face is over its inside.
    fn covers(&self, p: &Point) -> bool {
        edges(self.corners).iter().all(|(a, b)| (b - a).cross(&(p - a)).dot(&self.normal) >= 0.0)
    }

    fn foot(&self, p: &Point, height: f64) -> Option<Point> {
        self.covers(p).then(|| p - self.normal * height)
    }

    /// Where an edge of another triangle passes through.
    fn crossing(&self, other: &[Point; 3], heights: [f64; 3]) -> Option<Point> {
        (0..3).find_map(|k| {
            let (p, q, from, to) = (other[k], other[(k + 1) % 3], heights[k], heights[(k + 1) % 3]);
            if from * to > 0.0 || from == to {
                return None;
            }
            let x = p + (q - p) * (from / (from - to));
            self.covers(&x).then_some(x)
        })
    }
}

/// Nearest points of two segments, either of which may be a point.
pub(crate) fn segments(p: Point, q: Point, r: Point, s: Point) -> NearestPoints {
    let (u, v, w) = (q - p, s - r, p - r);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let on = |a: Point, along: &Vector, square: f64, x: &Point| {
        let t = if square > 0.0 { ((x - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        a + along * t
    };
    let determinant = uu * vv - uv * uv;
    let mut best = if determinant > 0.0 {
        // Foot of the common perpendicular on the first line, brought into the segment; then the nearest of
        // each to the other.
        let t = ((uv * v.dot(&w) - vv * u.dot(&w)) / determinant).clamp(0.0, 1.0);
        let y = on(r, &v, vv, &(p + u * t));
        NearestPoints::of(on(p, &u, uu, &y), y)
    } else {
        let y = on(r, &v, vv, &p);
        NearestPoints::of(on(p, &u, uu, &y), y)
    };
    if determinant <= ALMOST_PARALLEL * uu * vv {
        best.keep(NearestPoints::of(p, on(r, &v, vv, &p)));
        best.keep(NearestPoints::of(q, on(r, &v, vv, &q)));
        best.keep(NearestPoints::of(on(p, &u, uu, &r), r));
        best.keep(NearestPoints::of(on(p, &u, uu, &s), s));
    }
    best
}

/// Nearest points of a point and a triangle.
pub(crate) fn point_triangle(p: Point, t: &[Point; 3]) -> NearestPoints {
    let mut best = NearestPoints::of(p, t[0]);
    if let Some(face) = TriangleFace::of(t)
        && let Some(foot) = face.foot(&p, face.height(&p))
    {
        return NearestPoints::of(p, foot);
    }
    for (a, b) in edges(t) {
        best.keep(segments(p, p, a, b));
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of the distance of two triangles, as a part of the longest edge.
    const EDGE_ERROR: f64 = 1e-8;

    /// Small deterministic generator (xorshift, Marsaglia 2003), -1..1.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            2.0 * (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
        }

        fn point(&mut self, size: f64) -> Point {
            Point::new(size * self.next(), size * self.next(), size * self.next())
        }
    }

    /// Another way to the same number: projected gradient descent on the four barycentric parameters would
    /// share nothing with the code; alternating projections onto two convex sets (von Neumann) do neither,
    /// and converge from above.
    fn alternating(first: &[Point; 3], second: &[Point; 3], rounds: usize) -> f64 {
        // Projection onto a triangle by the region of its barycentric coordinates (Ericson 2005, 5.1.5).
        fn project(p: &Point, [a, b, c]: &[Point; 3]) -> Point {
            let (ab, ac, ap) = (b - a, c - a, p - a);
            let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
            if d1 <= 0.0 && d2 <= 0.0 {
                return *a;
            }
            let bp = p - b;
            let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
            if d3 >= 0.0 && d4 <= d3 {
                return *b;
            }
            let vc = d1 * d4 - d3 * d2;
            if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
                return a + ab * (d1 / (d1 - d3));
            }
            let cp = p - c;
            let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
            if d6 >= 0.0 && d5 <= d6 {
                return *c;
            }
            let vb = d5 * d2 - d1 * d6;
            if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
                return a + ac * (d2 / (d2 - d6));
            }
            let va = d3 * d6 - d5 * d4;
            if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
                return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
            }
            let sum = va + vb + vc;
            a + ab * (vb / sum) + ac * (vc / sum)
        }
        let mut p = first[0];
        let mut d = f64::INFINITY;
        for _ in 0..rounds {
            let q = project(&p, second);
            p = project(&q, first);
            d = (p - q).norm();
        }
        d
    }

    /// Corners visited: triangles apart, near, crossing, slivers, with a common plane, with parallel edges.
    #[test]
    fn the_distance_is_that_of_alternating_projections() {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let (mut apart, mut crossing) = (0, 0);
        for case in 0..20_000 {
            let mut first = [0; 3].map(|_| random.point(1.0));
            let shift = random.point(1.0);
            let mut second = [0; 3].map(|_| random.point(1.0) + shift.coords);
            match case % 8 {
                1 => first[2] = first[0] + (first[1] - first[0]) * random.next() + random.point(1e-7).coords,
                2 => second = first.map(|p| p + shift.coords),
                3 => second[1] = second[0] + (first[1] - first[0]) * random.next(),
                4 => (0..3).for_each(|k| (first[k].z, second[k].z) = (0.0, 0.3 * shift.z)),
                _ => {}
            }
            let found = nearest(&first, &second).square.sqrt();
            let turned = nearest(&second, &first).square.sqrt();
            assert!((found - turned).abs() < 1e-12, "{case}: {found} {turned}");
            // Projections converge from above, slowly where edges are almost parallel.
            let other = alternating(&first, &second, 3000);
            assert!(found <= other + 1e-12, "{case}: {found} {other}");
            if found > 0.0 {
                apart += 1;
                assert!(other - found < 2e-3, "{case}: {found} {other}");
            } else {
                crossing += 1;
                assert!(other < 2e-2, "{case}: said to cross, {other}");
            }
        }
        assert!(apart > 5000 && crossing > 1000, "{apart} {crossing}");
    }

    #[test]
    fn closed_forms_hold_to_rounding() {
        let at = Point::new;
        let floor = [at(0.0, 0.0, 0.0), at(9.0, 0.0, 0.0), at(0.0, 9.0, 0.0)];
        let cases = [
            // Vertex over the face; edge over the face, parallel to it; faces parallel and one over the
            // other.
            ([at(1.0, 1.0, 2.0), at(2.0, 1.0, 5.0), at(1.0, 2.0, 5.0)], 2.0),
            ([at(1.0, 1.0, 3.0), at(2.0, 2.0, 3.0), at(1.0, 2.0, 5.0)], 3.0),
            ([at(1.0, 1.0, 4.0), at(2.0, 1.0, 4.0), at(1.0, 2.0, 4.0)], 4.0),
            // Edge against edge, parallel and askew; in one plane.
            ([at(1.0, -3.0, 4.0), at(8.0, -3.0, 4.0), at(3.0, -9.0, 7.0)], 5.0),
            ([at(4.0, -2.0, -5.0), at(4.0, -2.0, 7.0), at(4.0, -9.0, 0.0)], 2.0),
            ([at(-3.0, 1.0, 0.0), at(-3.0, 4.0, 0.0), at(-8.0, 2.0, 0.0)], 3.0),
            // Through the face; touching it; one inside of the other in one plane.
            ([at(1.0, 1.0, -2.0), at(2.0, 1.0, 5.0), at(1.0, 2.0, 5.0)], 0.0),
            ([at(1.0, 1.0, 0.0), at(2.0, 1.0, 5.0), at(1.0, 2.0, 5.0)], 0.0),
            ([at(1.0, 1.0, 0.0), at(2.0, 1.0, 0.0), at(1.0, 2.0, 0.0)], 0.0),
            // A needle and a point.
            ([at(2.0, 2.0, 1.5), at(2.0, 2.0, 6.0), at(2.0, 2.0, 3.0)], 1.5),
            ([at(-3.0, 4.0, 4.0); 3], 5.0),
            ([at(3.0, 3.0, 0.0); 3], 0.0),
        ];
        for (k, (other, exact)) in cases.iter().enumerate() {
            let found = nearest(&floor, other);
            assert!((found.square.sqrt() - exact).abs() < 1e-12, "{k}: {found:?}");
            assert!(((found.on_first - found.on_second).norm() - exact).abs() < 1e-12, "{k}: {found:?}");
        }
    }

    /// Long edges at small angles that cross at a known height: the place is uncertain, the distance is not.
    #[test]
    fn edges_that_are_almost_parallel_keep_their_distance() {
        let mut random = Random(77);
        for k in 0..4000 {
            let angle = 10_f64.powf(-12.0 + 10.0 * f64::from(k % 100) / 100.0);
            let (half, height) = (500.0, 10_f64.powf(-6.0 + 3.0 * (0.5 + 0.5 * random.next())));
            let shift = 0.9 * half * random.next();
            let (s, c) = angle.sin_cos();
            let (p, q) = (Point::new(-half, 0.0, 0.0), Point::new(half, 0.0, 0.0));
            let at = |t: f64| Point::new(shift + t * c, t * s, height);
            let found = segments(p, q, at(-half), at(half)).square.sqrt();
            assert!((found - height).abs() <= EDGE_ERROR * 2.0 * half, "{angle:e}: {found:e} {height:e}");
        }
    }
}
