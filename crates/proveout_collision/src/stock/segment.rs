//! Segment against triangle, in closed form: no iteration, and no slack for one.

use proveout_geom::{Point, Vector};

/// Square of the sine below which two segments count as parallel, so that their ends decide.
const PARALLEL: f64 = 1e-10;

/// Distance of a segment from a triangle, mm, with a nearest point of each; zero where they meet. A triangle
/// without area counts as its edges, a segment without length as a point.
pub(crate) fn segment_triangle(segment: [Point; 2], triangle: &[Point; 3]) -> (f64, Point, Point) {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(&(c - a));
    let area2 = normal.norm_squared();
    let mut best = (f64::INFINITY, segment[0], a);
    if area2 > 0.0 {
        // Three sides of the plane's triangle, seen along its normal.
        let within = |p: &Point| {
            let side = |from: &Point, to: &Point| normal.dot(&(to - from).cross(&(p - from))) >= 0.0;
            side(&a, &b) && side(&b, &c) && side(&c, &a)
        };
        let heights = segment.map(|p| normal.dot(&(p - a)));
        if heights[0] * heights[1] <= 0.0 && heights[0] != heights[1] {
            let meeting = segment[0] + (segment[1] - segment[0]) * (heights[0] / (heights[0] - heights[1]));
            if within(&meeting) {
                return (0.0, meeting, meeting);
            }
        }
        for (end, height) in segment.iter().zip(heights) {
            let foot = end - normal * (height / area2);
            if within(&foot) {
                nearer(&mut best, *end, foot);
            }
        }
    }
    for [from, to] in [[a, b], [b, c], [c, a]] {
        let (p, q) = segment_segment(segment, [from, to]);
        nearer(&mut best, p, q);
    }
    best
}

fn nearer(best: &mut (f64, Point, Point), p: Point, q: Point) {
    let d = (p - q).norm();
    if d < best.0 {
        *best = (d, p, q);
    }
}

/// Nearest points of two segments: the feet of their common normal, or, where those lie outside, of their
/// ends.
fn segment_segment(p: [Point; 2], q: [Point; 2]) -> (Point, Point) {
    let (u, v, r) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let at = |from: Point, along: Vector, t: f64| from + along * t;
    let foot = |x: &Point, from: &Point, along: &Vector, square: f64| {
        if square > 0.0 { ((x - from).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 }
    };
    let sine = uu * vv - uv * uv;
    if sine > PARALLEL * uu * vv {
        let s = ((uv * r.dot(&v) - vv * r.dot(&u)) / sine).clamp(0.0, 1.0);
        // The foot of a point of one line on the other segment, and back: the distance is convex in s.
        let y = at(q[0], v, foot(&at(p[0], u, s), &q[0], &v, vv));
        return (at(p[0], u, foot(&y, &p[0], &u, uu)), y);
    }
    let mut best = (f64::INFINITY, p[0], q[0]);
    for x in p {
        nearer(&mut best, x, at(q[0], v, foot(&x, &q[0], &v, vv)));
    }
    for y in q {
        nearer(&mut best, at(p[0], u, foot(&y, &p[0], &u, uu)), y);
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Small deterministic generator (xorshift, Marsaglia 2003), -1..1.
    struct Random(u64);

    impl Random {
        fn point(&mut self) -> Point {
            let mut next = || {
                self.0 ^= self.0 << 13;
                self.0 ^= self.0 >> 7;
                self.0 ^= self.0 << 17;
                (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
            };
            // Half of the coordinates on a coarse grid: parallel, touching and degenerate ones come by
            // themselves.
            Point::from([0; 3].map(|_| {
                let x = next();
                if next() > 0.0 { (2.0 * x).round() / 2.0 } else { x }
            }))
        }
    }

    /// By subdivision of both: an upper bound that is too large by less than `2 step`.
    fn sampled(segment: [Point; 2], t: &[Point; 3], n: usize) -> f64 {
        let mut best = f64::INFINITY;
        for k in 0..=n {
            let p = segment[0] + (segment[1] - segment[0]) * (k as f64 / n as f64);
            for i in 0..=n {
                for j in 0..=n - i {
                    let q = t[0] + (t[1] - t[0]) * (i as f64 / n as f64) + (t[2] - t[0]) * (j as f64 / n as f64);
                    best = best.min((p - q).norm());
                }
            }
        }
        best
    }

    #[test]
    fn the_distance_is_that_of_many_points() {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let (mut met, mut flat) = (0, 0);
        for k in 0..3000 {
            let segment = [random.point(), random.point()];
            let mut t = [random.point(), random.point(), random.point()];
            if k % 50 == 0 {
                // A line, or a point.
                t[2] = t[1];
                t[0] = if k % 100 == 0 { t[1] } else { t[0] };
            }
            let (d, p, q) = segment_triangle(segment, &t);
            assert!(((p - q).norm() - d).abs() < 1e-12);
            let n = 24;
            let size = [segment[1] - segment[0], t[1] - t[0], t[2] - t[0]].iter().map(|e| e.norm()).sum::<f64>();
            let upper = sampled(segment, &t, n);
            assert!(d <= upper + 1e-12 && upper <= d + size / n as f64, "{segment:?} {t:?}: {d} {upper}");
            met += u32::from(d == 0.0);
            flat += u32::from((t[1] - t[0]).cross(&(t[2] - t[0])).norm() == 0.0);
        }
        assert!(met > 100 && flat > 50, "{met} {flat}");
    }
}
