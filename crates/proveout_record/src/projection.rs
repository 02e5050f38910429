//! Parallel projection of meshes into pictures, with depth and shade.

use proveout_geom::{Aabb, Point, Vector};

use crate::picture::NO_AREA;

/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-12;
/// Sine of the angle between up and the direction of the view below which X is to the right.
const UPRIGHT: f64 = 1e-6;
/// Twice the area of a triangle in the picture, points squared, below which it is not drawn.
const LEAST_SHOWN: f64 = 1e-12;
/// Least half of the width and height of the view, mm: a machine without bodies has one, too.
const LEAST_HALF_MM: f64 = 1e-3;

/// Where from and how large: a parallel projection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    pub(crate) right: Vector,
    pub(crate) up: Vector,
    /// Towards the viewer.
    pub(crate) back: Vector,
    focus: Point,
    /// Points for each mm.
    scale: f64,
    size: [usize; 2],
}

impl Projection {
    /// A view against `back` (from the viewer's side; not zero), with `focus` in the middle of `size` points
    /// and `half` mm of height above and below it. Z stays upright where it can.
    pub(crate) fn new(back: &Vector, focus: Point, half: f64, size: [usize; 2]) -> Self {
        let back = back.try_normalize(SHORTEST).unwrap_or_else(Vector::z);
        Self { scale: 0.5 * size[1] as f64 / half, ..Self::upright(back, &Vector::z(), focus, size) }
    }

    /// All of a box in the view.
    pub(crate) fn fitting(room: &Aabb, back: &Vector, up: &Vector, size: [usize; 2]) -> Self {
        let view = Self::upright(back.normalize(), up, room.center(), size);
        let corners = (0..8).map(|k| {
            let pick = |i: usize| if k >> i & 1 == 1 { room.max[i] } else { room.min[i] };
            Vector::new(pick(0), pick(1), pick(2)) - room.center().coords
        });
        let mut half = [LEAST_HALF_MM; 2];
        for c in corners {
            half = [half[0].max(c.dot(&view.right).abs()), half[1].max(c.dot(&view.up).abs())];
        }
        Self { scale: (0.48 * size[0] as f64 / half[0]).min(0.48 * size[1] as f64 / half[1]), ..view }
    }

    /// One point for each mm.
    fn upright(back: Vector, up: &Vector, focus: Point, size: [usize; 2]) -> Self {
        let right = up.cross(&back).try_normalize(UPRIGHT).unwrap_or_else(Vector::x);
        Self { right, up: back.cross(&right), back, focus, scale: 1.0, size }
    }

    /// Points to the right, down and towards the viewer (mm).
    pub(crate) fn place(&self, p: &Point) -> [f64; 3] {
        let way = p - self.focus;
        let (x, y) = (way.dot(&self.right) * self.scale, way.dot(&self.up) * self.scale);
        [0.5 * self.size[0] as f64 + x, 0.5 * self.size[1] as f64 - y, way.dot(&self.back)]
    }

    /// Points for each mm.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Points of the picture along x and y.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Calls `dot` with the place, the depth (mm) and the shade 0..=1 of each point of a triangle.
    pub(crate) fn triangle(&self, corners: [Point; 3], mut dot: impl FnMut([usize; 2], f64, f64)) {
        let [a, b, c] = corners.map(|p| self.place(&p));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if !(area.abs() > LEAST_SHOWN && [a, b, c].iter().flatten().all(|v| v.is_finite())) {
            return;
        }
        let range = |k: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            let (low, high) = ((low - 0.5).ceil().max(0.0), (high - 0.5).floor().min(self.size[k] as f64 - 1.0));
            if high < low { 0..0 } else { low as usize..high as usize + 1 }
        };
        // Most triangles of a large mesh lie beside a small view.
        let (columns, rows) = (range(0), range(1));
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let Some(normal) = normal.try_normalize(NO_AREA) else { return };
        let light = (self.back + self.up * 0.45 - self.right * 0.3).normalize();
        let shade = 0.4 + 0.6 * normal.dot(&light).abs();
        for y in rows {
            for x in columns.clone() {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let edge =
                    |u: [f64; 3], v: [f64; 3]| ((v[0] - u[0]) * (py - u[1]) - (v[1] - u[1]) * (px - u[0])) / area;
                let (wa, wb, wc) = (edge(b, c), edge(c, a), edge(a, b));
                if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                    dot([x, y], wa * a[2] + wb * b[2] + wc * c[2], shade);
                }
            }
        }
    }
}
