//! Where the ball of a stylus touches the stock.
//!
//! The extracted surface says which place of the stock the ball meets first, in closed form ([`BallWay`]).
//! Its vertices lie off a curved surface by about cell² / 8 of the radius of curvature, so that place is
//! found again on what is exact: the ends of the rays round it. A quadric through them (below) over the
//! tangent plane takes the place of the mesh where it fits; how well it fits is the bound that is printed. At
//! edges and corners it does not, and the mesh, which has them sharp, stays.
//!
//! ```text
//!            .--.      ball           o ends of rays, exact
//!           (    )                    - quadric through those within REACH cells of the touch
//!        o--o'--'o---o          h = c0 + c1 u + c2 v + c3 u² + c4 u v + c5 v²
//! ```

use nalgebra::{Matrix6, Vector6};
use proveout_geom::{BallWay, Point, TriMesh, Vector};

use crate::field::dexel::TriDexel;

/// Ends of rays this near count, in cells: some thirty on a flat face, of which six would do.
const REACH: f64 = 2.2;
/// Fewer ends fix no quadric that could be trusted.
const LEAST_ENDS: usize = 12;
/// Cosine between the normals of two ends of one smooth surface.
const SAME_SIDE: f64 = 0.9;
/// A quadric that leaves its ends by more is not taken, mm.
const FITS_MM: f64 = 5e-4;
/// Steps of Newton's method; each squares the error.
const STEPS: usize = 12;

/// A touch of the ball of a stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StylusTouch {
    /// Part of the way, 0 to 1.
    pub share: f64,
    /// The place that it touches, mm.
    pub point: Point,
    /// Outward unit normal of the stock there.
    pub normal: Vector,
    /// How far the center of the ball may be from where it touches the true surface, mm: along the normal.
    pub bound: f64,
}

/// Height over the tangent plane.
struct Quadric {
    origin: Point,
    axes: [Vector; 3],
    c: [f64; 6],
    /// How far it leaves the ends of the rays, mm.
    off: f64,
}

impl Quadric {
    /// Through the ends of the rays round a place whose outward normals are near `normal`.
    fn through(stock: &TriDexel, origin: Point, normal: Vector) -> Option<Self> {
        let reach = REACH * stock.cell_mm();
        let u = normal.cross(&Vector::ith(normal.iamin(), 1.0)).try_normalize(0.0)?;
        let axes = [u, normal.cross(&u), normal];
        let (mut square, mut right) = (Matrix6::zeros(), Vector6::zeros());
        let mut ends = Vec::new();
        for end in stock.surface_points() {
            let way = end.point - origin;
            if way.norm_squared() <= reach * reach && end.normal.is_some_and(|n| n.dot(&normal) >= SAME_SIDE) {
                ends.push(axes.map(|axis| way.dot(&axis)));
            }
        }
        if ends.len() < LEAST_ENDS {
            return None;
        }
        for [u, v, h] in &ends {
            let row = row_of(*u, *v);
            square += row * row.transpose();
            right += row * *h;
        }
        let c = square.cholesky()?.solve(&right);
        let off = ends.iter().map(|[u, v, h]| (row_of(*u, *v).dot(&c) - h).abs()).fold(0.0, f64::max);
        Some(Self { origin, axes, c: c.into(), off })
    }

    fn height(&self, u: f64, v: f64) -> (f64, [f64; 2]) {
        let c = &self.c;
        let h = c[0] + c[1] * u + c[2] * v + c[3] * u * u + c[4] * u * v + c[5] * v * v;
        (h, [c[1] + 2.0 * c[3] * u + c[4] * v, c[2] + c[4] * u + 2.0 * c[5] * v])
    }

    /// Nearest point to a place above it, with the distance.
    fn nearest(&self, place: &Point) -> Option<([f64; 2], f64)> {
        let way = place - self.origin;
        let [x, y, z] = self.axes.map(|axis| way.dot(&axis));
        let (mut u, mut v) = (x, y);
        for _ in 0..STEPS {
            let (h, [hu, hv]) = self.height(u, v);
            let lift = z - h;
            // Gradient and second derivatives of half the squared distance.
            let g = [u - x - lift * hu, v - y - lift * hv];
            let a = 1.0 + hu * hu - 2.0 * lift * self.c[3];
            let b = hu * hv - lift * self.c[4];
            let d = 1.0 + hv * hv - 2.0 * lift * self.c[5];
            let determinant = a * d - b * b;
            if determinant <= 0.0 {
                return None;
            }
            u -= (d * g[0] - b * g[1]) / determinant;
            v -= (a * g[1] - b * g[0]) / determinant;
        }
        let (h, _) = self.height(u, v);
        Some(([u, v], ((x - u).powi(2) + (y - v).powi(2) + (z - h).powi(2)).sqrt()))
    }
}

fn row_of(u: f64, v: f64) -> Vector6<f64> {
    Vector6::new(1.0, u, v, u * u, u * v, v * v)
}

impl TriDexel {
    /// Where a ball first touches the stock on its way; `surface` is the mesh of [`TriDexel::surface`] of the
    /// stock as it is.
    pub fn stylus_touch(&self, surface: &TriMesh, way: &BallWay) -> Option<StylusTouch> {
        let touch = way.first_touch(surface)?;
        let [a, b, c] = surface.corners(touch.triangle);
        let face = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector::z);
        let away = (way.center(touch.share) - touch.point).try_normalize(0.0);
        let on_mesh =
            StylusTouch { share: touch.share, point: touch.point, normal: away.unwrap_or(face), bound: self.cell_mm() };
        if touch.share <= 0.0 {
            return Some(on_mesh);
        }
        Some(self.on_rays(way, &on_mesh, face).unwrap_or(on_mesh))
    }

    /// The same on the ends of the rays; none where they lie on no smooth surface.
    fn on_rays(&self, way: &BallWay, touch: &StylusTouch, face: Vector) -> Option<StylusTouch> {
        let quadric = Quadric::through(self, touch.point, face).filter(|q| q.off <= FITS_MM)?;
        let length = (way.to - way.from).norm();
        let mut share = touch.share;
        let cell = self.cell_mm();
        for _ in 0..STEPS {
            let center = way.center(share);
            let ([u, v], distance) = quadric.nearest(&center)?;
            let (_, [hu, hv]) = quadric.height(u, v);
            let [x, y, z] = quadric.axes;
            let normal = (z - x * hu - y * hv).normalize();
            let approach = -normal.dot(&(way.to - way.from));
            if approach <= 1e-3 * length {
                return None;
            }
            share += (distance - way.radius) / approach;
        }
        let center = way.center(share);
        let ([u, v], distance) = quadric.nearest(&center)?;
        let off = (share - touch.share).abs() * length;
        let beside = u.hypot(v);
        if (distance - way.radius).abs() > 1e-9 || off > cell || beside > cell || !(0.0..=1.0).contains(&share) {
            return None;
        }
        let (h, _) = quadric.height(u, v);
        let [x, y, z] = quadric.axes;
        let point = quadric.origin + x * u + y * v + z * h;
        let bound = quadric.off + self.sweep_bound_mm();
        Some(StylusTouch { share, point, normal: (center - point) / way.radius, bound })
    }
}
