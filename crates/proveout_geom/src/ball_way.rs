//! A ball on a straight way: where it touches triangles, in closed form.
//!
//! The places at which a ball touches a convex body are those of its center in the body grown by the radius.
//! That is convex too, so that a straight way is in it over one range. A triangle grown by a radius is the
//! union of three balls about its corners, three cylinders round its edges and a plate on either side: the
//! range is the hull of theirs, each the solution of a quadratic or of linear inequalities.

use crate::{Aabb, Point, TriMesh, Vector};

/// Squared lengths and steepnesses below this are none, mm2: rounding of coordinates of 1 m.
const NONE_MM2: f64 = 1e-18;

/// A ball whose center runs straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallWay {
    /// Center at the start, mm.
    pub from: Point,
    /// Center at the end, mm.
    pub to: Point,
    /// Radius, mm.
    pub radius: f64,
}

/// Where a ball first touches a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallTouch {
    /// Part of the way, 0 to 1.
    pub share: f64,
    /// The place that it touches, mm.
    pub point: Point,
    /// Index of the triangle.
    pub triangle: usize,
}

type Range = [f64; 2];

/// Where `a s^2 + 2 b s + c <= 0` holds, for `a >= 0`.
fn below_zero(a: f64, b: f64, c: f64) -> Option<Range> {
    if a <= NONE_MM2 {
        return (c <= 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let root = (b * b - a * c).max(-1.0);
    if root < 0.0 {
        return None;
    }
    // The root that does not cancel first.
    let q = -(b + if b >= 0.0 { root.sqrt() } else { -root.sqrt() });
    let (first, second) = (q / a, if q == 0.0 { 0.0 } else { c / q });
    Some([first.min(second), first.max(second)])
}

/// Where `low <= at + s rate <= high` holds.
fn between(at: f64, rate: f64, [low, high]: Range) -> Option<Range> {
    if rate == 0.0 {
        return (low <= at && at <= high).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let (a, b) = ((low - at) / rate, (high - at) / rate);
    Some([a.min(b), a.max(b)])
}

fn both(a: Range, b: Range) -> Option<Range> {
    let range = [a[0].max(b[0]), a[1].min(b[1])];
    (range[0] <= range[1]).then_some(range)
}

impl BallWay {
    /// Center after a part of the way.
    pub fn center(&self, share: f64) -> Point {
        self.from + (self.to - self.from) * share
    }

    /// Box of the ball on its whole way.
    pub fn bounds(&self) -> Aabb {
        Aabb::of_points(&[self.from, self.to]).expanded(self.radius)
    }

    /// Parts of the way, also before its start and behind its end, at which the ball touches a triangle or
    /// overlaps it: from the first to the last.
    ///
    /// ```
    /// use proveout_geom::{BallWay, Point};
    ///
    /// let floor = [Point::new(-9.0, -9.0, 0.0), Point::new(9.0, -9.0, 0.0), Point::new(0.0, 9.0, 0.0)];
    /// let way = BallWay { from: Point::new(0.0, 0.0, 13.0), to: Point::new(0.0, 0.0, 3.0), radius: 3.0 };
    /// let range = way.range_on([&floor[0], &floor[1], &floor[2]]).expect("it comes down on the floor");
    /// assert_eq!(range, [1.0, 1.6]);
    /// ```
    pub fn range_on(&self, corners: [&Point; 3]) -> Option<Range> {
        let d = self.to - self.from;
        let square = self.radius * self.radius;
        let mut hull: Option<Range> = None;
        let mut add = |range: Option<Range>| {
            if let Some([low, high]) = range {
                hull = Some(hull.map_or([low, high], |[l, h]| [l.min(low), h.max(high)]));
            }
        };
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let m = self.from - a;
            add(below_zero(d.norm_squared(), m.dot(&d), m.norm_squared() - square));
            let e = b - a;
            let length2 = e.norm_squared();
            if length2 > NONE_MM2 {
                let across = |v: &Vector| v - e * (v.dot(&e) / length2);
                let (m2, d2) = (across(&m), across(&d));
                let round = below_zero(d2.norm_squared(), m2.dot(&d2), m2.norm_squared() - square);
                let beside = between(m.dot(&e) / length2, d.dot(&e) / length2, [0.0, 1.0]);
                add(round.zip(beside).and_then(|(x, y)| both(x, y)));
            }
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        if let Some(n) = normal.try_normalize(NONE_MM2) {
            let m = self.from - corners[0];
            let mut range = between(n.dot(&m), n.dot(&d), [-self.radius, self.radius]);
            for k in 0..3 {
                let inward = n.cross(&(corners[(k + 1) % 3] - corners[k]));
                let inside = between(inward.dot(&(self.from - corners[k])), inward.dot(&d), [0.0, f64::INFINITY]);
                range = range.zip(inside).and_then(|(x, y)| both(x, y));
            }
            add(range);
        }
        hull
    }

    /// Triangles whose boxes the ball can come to, with the ranges at which it touches them.
    fn ranges<'a>(&'a self, mesh: &'a TriMesh) -> impl Iterator<Item = (usize, Range)> + 'a {
        let bounds = self.bounds();
        (0..mesh.triangles.len()).filter_map(move |t| {
            let [a, b, c] = mesh.corners(t);
            let near = Aabb { min: a.inf(&b).inf(&c), max: a.sup(&b).sup(&c) }.intersects(&bounds);
            near.then(|| self.range_on([&a, &b, &c])).flatten().map(|range| (t, range))
        })
    }

    /// Where the ball first touches a mesh on its way; at the start, where it touches there already.
    pub fn first_touch(&self, mesh: &TriMesh) -> Option<BallTouch> {
        let first = self
            .ranges(mesh)
            .filter(|(_, [low, high])| *high >= 0.0 && *low <= 1.0)
            .min_by(|(s, x), (t, y)| x[0].max(0.0).total_cmp(&y[0].max(0.0)).then(s.cmp(t)));
        first.map(|(triangle, [low, _])| {
            let share = low.max(0.0);
            let [a, b, c] = mesh.corners(triangle);
            BallTouch { share, point: nearest_on(&self.center(share), [&a, &b, &c]), triangle }
        })
    }

    /// The part of the way after which the ball, which touches the meshes at its start, has come off all of
    /// them. None where it does not touch there; above 1 where it does not come off.
    pub fn comes_off<'a>(&self, meshes: impl IntoIterator<Item = &'a TriMesh>) -> Option<f64> {
        let mut ranges: Vec<Range> =
            meshes.into_iter().flat_map(|mesh| self.ranges(mesh).map(|(_, range)| range).collect::<Vec<_>>()).collect();
        ranges.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut off: Option<f64> = None;
        for [low, high] in ranges {
            let begins = low <= 0.0 && high >= 0.0;
            if begins || off.is_some_and(|off| low <= off) {
                off = Some(off.map_or(high, |off| off.max(high)));
            }
        }
        off
    }
}

/// The point of a triangle that is nearest to a place (Ericson 2005, chapter 5.1.5).
fn nearest_on(place: &Point, [a, b, c]: [&Point; 3]) -> Point {
    let (ab, ac, ap) = (b - a, c - a, place - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = place - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = place - c;
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
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{box_mesh, revolved_mesh};

    fn cube() -> TriMesh {
        box_mesh(&Aabb { min: Point::origin(), max: Point::new(20.0, 20.0, 20.0) })
    }

    fn way(from: [f64; 3], to: [f64; 3]) -> BallWay {
        BallWay { from: from.into(), to: to.into(), radius: 3.0 }
    }

    #[test]
    fn faces_edges_and_corners_are_met_where_the_closed_forms_say() {
        let cube = cube();
        // A face: the center is a radius away from it.
        let touch = way([10.0, 10.0, 43.0], [10.0, 10.0, 3.0]).first_touch(&cube).unwrap();
        assert!((touch.share - 0.5).abs() < 1e-14, "{touch:?}");
        assert!((touch.point - Point::new(10.0, 10.0, 20.0)).norm() < 1e-12);
        // An edge along y, the center passing 2 mm above and beside it: x = -sqrt(9 - 4).
        let touch = way([-13.0, 10.0, 22.0], [7.0, 10.0, 22.0]).first_touch(&cube).unwrap();
        assert!((touch.share - (13.0 - 5.0_f64.sqrt()) / 20.0).abs() < 1e-14, "{touch:?}");
        // A corner, on the diagonal: the center is 3 mm from (20, 20, 20).
        let touch = way([40.0, 40.0, 40.0], [20.0, 20.0, 20.0]).first_touch(&cube).unwrap();
        assert!((touch.share - (1.0 - 3.0 / (20.0 * 3.0_f64.sqrt()))).abs() < 1e-14, "{touch:?}");
        assert_eq!(touch.point, Point::new(20.0, 20.0, 20.0));
        // It passes by 1 um.
        assert_eq!(way([-13.0, 10.0, 23.001], [33.0, 10.0, 23.001]).first_touch(&cube), None);
        // A way that ends short of the face.
        assert_eq!(way([10.0, 10.0, 43.0], [10.0, 10.0, 23.001]).first_touch(&cube), None);
    }

    #[test]
    fn a_ball_comes_off_where_it_no_longer_touches() {
        let cube = cube();
        let off = way([10.0, 10.0, 22.0], [10.0, 10.0, 32.0]).comes_off([&cube]).unwrap();
        assert!((off - 0.1).abs() < 1e-14, "{off}");
        assert_eq!(way([10.0, 10.0, 24.0], [10.0, 10.0, 32.0]).comes_off([&cube]), None);
        // Along the face it does not come off before the end.
        assert!(way([10.0, 10.0, 22.0], [15.0, 10.0, 22.0]).comes_off([&cube]).unwrap() > 1.0);
    }

    #[test]
    fn the_first_touch_is_that_of_small_steps() {
        // A body without faces along the axes, random ways, and the distance in steps of 1/4000 of the way.
        let drum = revolved_mesh(&[[0.0, 0.0], [9.0, 1.0], [11.0, 6.0], [4.0, 13.0], [0.0, 13.5]], 17);
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut met, mut missed) = (0, 0);
        for _ in 0..60 {
            let mut place = |spread: f64| Point::from([0, 1, 2].map(|_| spread * (random() - 0.5)));
            let way = BallWay { from: place(20.0) + Vector::new(40.0, 5.0, 0.0), to: place(36.0), radius: 2.5 };
            let distance = |share: f64| {
                let at = way.center(share);
                let corners = (0..drum.triangles.len()).map(|t| drum.corners(t));
                corners.map(|[a, b, c]| (nearest_on(&at, [&a, &b, &c]) - at).norm()).fold(f64::INFINITY, f64::min)
            };
            let step = 1.0 / 4000.0;
            let first = (0..=4000).map(|i| f64::from(i) * step).find(|&s| distance(s) <= way.radius);
            match (way.first_touch(&drum), first) {
                (Some(touch), Some(first)) => {
                    met += 1;
                    assert!(touch.share <= first + 1e-12 && touch.share > first - step - 1e-12, "{touch:?} {first}");
                    assert!((distance(touch.share) - way.radius).abs() < 1e-9);
                }
                (None, None) => missed += 1,
                // A touch between two steps.
                (Some(touch), None) => assert!((distance(touch.share) - way.radius).abs() < 1e-9),
                (None, Some(first)) => panic!("a touch at {first} is not found"),
            }
        }
        assert!(met > 20 && missed > 5, "{met} {missed}");
    }
}
