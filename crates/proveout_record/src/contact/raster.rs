//! Triangles as a shaded picture: parallel projection with a depth for each point, two bodies in color and everything else in gray.
//!
//! A gray body never hides a colored one: in front of it, it is drawn as glass, so that a contact inside a
//! door or between two walls is visible. If one colored body hides the other, as stock around a shank does,
//! the hidden part is hatched.

use proveout_geom::{Point, TriMesh, Vector};

use crate::{canvas::Canvas, picture::NO_AREA};

/// Color of the first body, of the second, of the others: distinct for all kinds of color vision (Okabe and
/// Ito 2008).
pub(crate) const COLORS: [[u8; 3]; 3] = [[213, 94, 0], [0, 114, 178], [190, 192, 196]];
/// Where there is no body.
const BACKGROUND: [u8; 3] = [250, 250, 250];
/// A body of which less than this part is seen is hatched where the other hides it, by stripes of so many points.
const SEEN: f64 = 0.25;
const STRIPE: usize = 3;
/// Share of the gray of a body that is drawn as glass.
const GLASS: f64 = 0.22;
/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-12;
/// Sine of the angle between Z and the direction of the view below which X is to the right.
const UPRIGHT: f64 = 1e-6;
/// Twice the area of a triangle in the picture, points squared, below which it is not drawn.
const LEAST_SHOWN: f64 = 1e-12;

/// What a mesh is in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    First,
    Second,
    Other,
}

/// Where from and how large: a parallel projection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    right: Vector,
    up: Vector,
    /// Towards the viewer.
    back: Vector,
    focus: Point,
    /// Points for each mm.
    scale: f64,
    size: [usize; 2],
}

impl View {
    /// A view against `back` (from the viewer's side; not zero), with `focus` in the middle of `size` points and `half` mm of height
    /// above and below it. Z stays upright where it can.
    pub(crate) fn new(back: &Vector, focus: Point, half: f64, size: [usize; 2]) -> Self {
        let back = back.try_normalize(SHORTEST).unwrap_or_else(Vector::z);
        let side = Vector::z().cross(&back);
        let right = side.try_normalize(UPRIGHT).unwrap_or_else(Vector::x);
        Self { right, up: back.cross(&right), back, focus, scale: 0.5 * size[1] as f64 / half, size }
    }

    /// Points to the right, down and towards the viewer (mm).
    fn place(&self, p: &Point) -> [f64; 3] {
        let way = p - self.focus;
        let (x, y) = (way.dot(&self.right) * self.scale, way.dot(&self.up) * self.scale);
        [0.5 * self.size[0] as f64 + x, 0.5 * self.size[1] as f64 - y, way.dot(&self.back)]
    }

    /// Points for each mm.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }
}

/// Nearest surface at every point of the first body, the second and all others apart.
pub(crate) struct Raster {
    view: View,
    /// Depth towards the viewer (mm) and shade 0..=1.
    surfaces: [Vec<(f64, f64)>; 3],
}

impl Raster {
    pub(crate) fn new(view: View) -> Self {
        let points = view.size[0] * view.size[1];
        Self { view, surfaces: std::array::from_fn(|_| vec![(f64::NEG_INFINITY, 0.0); points]) }
    }

    /// Draws a mesh in the frame of the view.
    pub(crate) fn draw(&mut self, mesh: &TriMesh, part: Part) {
        for t in 0..mesh.triangles.len() {
            self.triangle(mesh.corners(t), part);
        }
    }

    fn triangle(&mut self, corners: [Point; 3], part: Part) {
        let [a, b, c] = corners.map(|p| self.view.place(&p));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if !(area.abs() > LEAST_SHOWN && [a, b, c].iter().flatten().all(|v| v.is_finite())) {
            return;
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let Some(normal) = normal.try_normalize(NO_AREA) else { return };
        let light = (self.view.back + self.view.up * 0.45 - self.view.right * 0.3).normalize();
        let shade = 0.4 + 0.6 * normal.dot(&light).abs();
        let range = |k: usize, most: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            let (low, high) = ((low - 0.5).ceil().max(0.0), (high - 0.5).floor().min(most as f64 - 1.0));
            if high < low { 0..0 } else { low as usize..high as usize + 1 }
        };
        for y in range(1, self.view.size[1]) {
            for x in range(0, self.view.size[0]) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let edge =
                    |u: [f64; 3], v: [f64; 3]| ((v[0] - u[0]) * (py - u[1]) - (v[1] - u[1]) * (px - u[0])) / area;
                let (wa, wb, wc) = (edge(b, c), edge(c, a), edge(a, b));
                if wa < 0.0 || wb < 0.0 || wc < 0.0 {
                    continue;
                }
                let depth = wa * a[2] + wb * b[2] + wc * c[2];
                let at = y * self.view.size[0] + x;
                let nearest = &mut self.surfaces[part as usize][at];
                if depth > nearest.0 {
                    *nearest = (depth, shade);
                }
            }
        }
    }

    /// Points at which the first and the second body are seen, and the depth of the nearest of both in the middle, mm.
    pub(crate) fn seen(&self) -> ([usize; 2], f64) {
        let [first, second, _] = &self.surfaces;
        let nearer = |a: &[(f64, f64)], b: &[(f64, f64)]| a.iter().zip(b).filter(|(a, b)| a.0 > b.0).count();
        let middle = self.view.size[1] / 2 * self.view.size[0] + self.view.size[0] / 2;
        ([nearer(first, second), nearer(second, first)], first[middle].0.max(second[middle].0))
    }

    /// Whether so little of the first and of the second body is seen that what the other hides is hatched.
    fn hatched(&self) -> [bool; 2] {
        let (seen, _) = self.seen();
        [0, 1].map(|k| {
            let all = self.surfaces[k].iter().filter(|p| p.0.is_finite()).count();
            (seen[k] as f64) < SEEN * all as f64
        })
    }

    /// Puts the picture on a canvas, with its upper left corner at `at`.
    pub(crate) fn put(&self, canvas: &mut Canvas, at: [usize; 2]) {
        let mix = |a: [u8; 3], b: [u8; 3], share: f64| {
            [0, 1, 2].map(|k| (f64::from(a[k]) * (1.0 - share) + f64::from(b[k]) * share).round() as u8)
        };
        let shaded = |color: [u8; 3], shade: f64| color.map(|c| (f64::from(c) * shade).round() as u8);
        let hatched = self.hatched();
        for (i, gray) in self.surfaces[Part::Other as usize].iter().enumerate() {
            let [x, y] = [i % self.view.size[0], i / self.view.size[0]];
            let (first, second) = (self.surfaces[0][i], self.surfaces[1][i]);
            let nearest = usize::from(second.0 > first.0);
            let hidden = 1 - nearest;
            let stripe = ((x + y) / STRIPE).is_multiple_of(2);
            let through = stripe && hatched[hidden] && self.surfaces[hidden][i].0.is_finite();
            let shown = if through { hidden } else { nearest };
            let colored = self.surfaces[shown][i];
            let dull = shaded(COLORS[2], gray.1);
            let color = match (colored.0.is_finite(), gray.0.is_finite()) {
                (false, false) => BACKGROUND,
                (false, true) => dull,
                (true, _) => {
                    let full = shaded(COLORS[shown], colored.1);
                    if gray.0 > first.0.max(second.0) { mix(full, dull, GLASS) } else { full }
                }
            };
            canvas.dot((at[0] + x) as isize, (at[1] + y) as isize, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh};

    use super::*;

    fn cube(center: [f64; 3], half: f64) -> TriMesh {
        let c = Vector::from(center);
        let h = Vector::repeat(half);
        box_mesh(&Aabb { min: Point::from(c - h), max: Point::from(c + h) })
    }

    #[test]
    fn a_cube_covers_its_share_and_the_nearer_one_is_seen() {
        let view = View::new(&Vector::x(), Point::origin(), 10.0, [200, 100]);
        let mut raster = Raster::new(view);
        raster.draw(&cube([0.0, 0.0, 0.0], 5.0), Part::First);
        // 10 of 20 mm of height are 50 points, in both directions.
        assert_eq!(raster.seen(), ([2500, 0], 5.0));
        raster.draw(&cube([20.0, 0.0, 0.0], 2.0), Part::Second);
        assert_eq!(raster.seen(), ([2500 - 400, 400], 22.0));
        // A body farther away changes nothing, nor does a gray one in front.
        raster.draw(&cube([-20.0, 0.0, 0.0], 4.0), Part::Second);
        raster.draw(&cube([40.0, 0.0, 0.0], 9.0), Part::Other);
        assert_eq!(raster.seen(), ([2500 - 400, 400], 22.0));
        let mut canvas = Canvas::new(200, 100);
        raster.put(&mut canvas, [0, 0]);
        let color = |x: usize, y: usize| &canvas.colors[3 * (200 * y + x)..][..3];
        assert_eq!(color(0, 0), BACKGROUND);
        let [blue, orange] = [color(100, 50), color(82, 50)];
        assert!(blue[2] > blue[0] && orange[0] > orange[2], "{blue:?} {orange:?}");
    }

    /// A cube wholly inside of another is hatched; one that is half outside is not.
    #[test]
    fn what_the_other_body_hides_is_hatched() {
        for (center, hatched) in [([0.0, 0.0, 0.0], true), ([0.0, 6.0, 0.0], false)] {
            let mut raster = Raster::new(View::new(&Vector::x(), Point::origin(), 10.0, [200, 100]));
            raster.draw(&cube([0.0, 0.0, 0.0], 6.0), Part::Second);
            raster.draw(&cube(center, 3.0), Part::First);
            assert_eq!(raster.hatched(), [hatched, false]);
            let mut canvas = Canvas::new(200, 100);
            raster.put(&mut canvas, [0, 0]);
            // Of the points in which both lie, half are in the color of the hidden one.
            let color = |x: usize| &canvas.colors[3 * (200 * 50 + x)..][..3];
            let orange = (90..110).filter(|x| color(*x)[0] > color(*x)[2]).count();
            assert!(if hatched { (8..=12).contains(&orange) } else { orange == 0 }, "{center:?}: {orange}");
        }
    }

    #[test]
    fn degenerate_and_endless_triangles_are_left_out() {
        let mut raster = Raster::new(View::new(&Vector::z(), Point::origin(), 1.0, [8, 8]));
        let at = |x: f64| Point::new(x, 0.0, 0.0);
        raster.triangle([at(0.0), at(1.0), at(0.5)], Part::First);
        raster.triangle([at(0.0), at(f64::NAN), Point::new(0.0, 1.0, 0.0)], Part::First);
        raster.triangle([at(0.0), at(f64::INFINITY), Point::new(0.0, 1.0, 0.0)], Part::First);
        assert_eq!(raster.seen().0, [0, 0]);
    }
}
