//! Triangles in quarters, and these in quarters, as far as they were asked for.
//!
//! They do not hang on where the tool stands, so that contacts that follow each other share them.

use proveout_geom::Point;

use super::solids::Solid;

/// So many pieces are kept for the contacts that follow; where there are more they are made anew: some 30 MB.
const MOST_KEPT: usize = 1 << 18;
/// What has no parts yet.
const WHOLE: u32 = u32::MAX;

/// Pieces by number; the four parts of one follow each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Quarters {
    /// A ball that holds each.
    balls: Vec<(Point, f64)>,
    corners: Vec<[Point; 3]>,
    /// First of its parts.
    parts: Vec<u32>,
    /// First part of each triangle of each solid.
    triangles: Vec<Vec<u32>>,
}

impl Quarters {
    /// Before a contact: room for the triangles of these solids, and not too much of what was made for others.
    pub(super) fn begin(&mut self, solids: &[Solid]) {
        let fits = self.triangles.len() == solids.len()
            && self.triangles.iter().zip(solids).all(|(known, solid)| known.len() == solid.triangles.len());
        if fits && self.balls.len() <= MOST_KEPT {
            return;
        }
        (self.balls, self.corners, self.parts) = Default::default();
        self.triangles = solids.iter().map(|s| vec![WHOLE; s.triangles.len()]).collect();
    }

    /// A ball that holds a piece.
    pub(super) fn ball(&self, piece: u32) -> (Point, f64) {
        self.balls[piece as usize]
    }

    /// Center of the corners of a piece.
    pub(super) fn middle(&self, piece: u32) -> Point {
        let [a, b, c] = &self.corners[piece as usize];
        Point::from((a.coords + b.coords + c.coords) / 3.0)
    }

    /// The first of the four parts of a triangle.
    pub(super) fn of_triangle(&mut self, solids: &[Solid], solid: u32, triangle: u32) -> u32 {
        let known = self.triangles[solid as usize][triangle as usize];
        if known != WHOLE {
            return known;
        }
        let corners = solids[solid as usize].triangles[triangle as usize];
        let made = self.quarter(corners, circle(&corners));
        self.triangles[solid as usize][triangle as usize] = made;
        made
    }

    /// The first of the four parts of a piece.
    pub(super) fn of_piece(&mut self, piece: u32) -> u32 {
        let known = self.parts[piece as usize];
        if known != WHOLE {
            return known;
        }
        let made = self.quarter(self.corners[piece as usize], self.balls[piece as usize]);
        self.parts[piece as usize] = made;
        made
    }

    /// The quarters of a triangle: three shrunk to a half towards its corners, and the one amid them, shrunk and turned by half a turn about the
    /// middle of the corners. The balls that hold them come from its ball in the same way.
    fn quarter(&mut self, [a, b, c]: [Point; 3], (center, radius): (Point, f64)) -> u32 {
        let first = self.balls.len() as u32;
        let [d, e, f] = [nalgebra::center(&a, &b), nalgebra::center(&b, &c), nalgebra::center(&c, &a)];
        let radius = 0.5 * radius * (1.0 + 1e-12) + 1e-12;
        let amid = Point::from(0.5 * (a.coords + b.coords + c.coords - center.coords));
        let parts = [
            ([a, d, f], nalgebra::center(&a, &center)),
            ([d, b, e], nalgebra::center(&b, &center)),
            ([f, e, c], nalgebra::center(&c, &center)),
            ([d, e, f], amid),
        ];
        for (corners, center) in parts {
            self.balls.push((center, radius));
            self.corners.push(corners);
            self.parts.push(WHOLE);
        }
        first
    }
}

/// A ball that holds a triangle: round its longest edge, or through its corners where it has no wide angle.
fn circle(corners: &[Point; 3]) -> (Point, f64) {
    let [a, b, c] = corners;
    let (u, v) = (b - a, c - a);
    let normal = u.cross(&v);
    let square = normal.norm_squared();
    let longest = [(a, b, c), (b, c, a), (c, a, b)]
        .into_iter()
        .max_by(|x, y| (x.1 - x.0).norm_squared().total_cmp(&(y.1 - y.0).norm_squared()));
    if let Some((p, q, other)) = longest {
        let middle = nalgebra::center(p, q);
        let radius = 0.5 * (q - p).norm();
        if (other - middle).norm() <= radius || square <= 0.0 {
            let radius = radius.max((other - middle).norm());
            return (middle, radius * (1.0 + 1e-12) + 1e-12);
        }
    }
    let center = a + (normal.cross(&u) * v.norm_squared() + v.cross(&normal) * u.norm_squared()) / (2.0 * square);
    let radius = corners.iter().map(|p| (p - center).norm()).fold(0.0, f64::max);
    (center, radius * (1.0 + 1e-12) + 1e-12)
}
