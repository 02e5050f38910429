//! Triangles as a shaded picture: parallel projection with a depth for each point, two bodies in color and
//! everything else in gray.
//!
//! A gray body never hides a colored one: in front of it, it is drawn as glass, so that a contact inside a
//! door or between two walls is visible. If one colored body hides the other, as stock around a shank does,
//! the hidden part is hatched.

use proveout_geom::{Point, TriMesh};

use crate::{canvas::Canvas, projection::Projection};

/// Color of the first body, of the second, of the others: distinct for all kinds of color vision (Okabe and
/// Ito 2008).
pub(crate) const COLORS: [[u8; 3]; 3] = [[213, 94, 0], [0, 114, 178], [190, 192, 196]];
/// Where there is no body.
const BACKGROUND: [u8; 3] = [250, 250, 250];
/// A body of which less than this part is seen is hatched where the other hides it, by stripes of so many
/// points.
const SEEN: f64 = 0.25;
const STRIPE: usize = 3;
/// Share of the gray of a body that is drawn as glass.
const GLASS: f64 = 0.22;

/// What a mesh is in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureBody {
    First,
    Second,
    Other,
}

/// Nearest surface at every point of the first body, the second and all others apart.
pub(crate) struct Raster {
    view: Projection,
    /// Depth towards the viewer (mm) and shade 0..=1.
    surfaces: [Vec<(f64, f64)>; 3],
}

impl Raster {
    pub(crate) fn new(view: Projection) -> Self {
        let points = view.size().into_iter().product();
        Self { view, surfaces: std::array::from_fn(|_| vec![(f64::NEG_INFINITY, 0.0); points]) }
    }

    /// Draws a mesh in the frame of the view.
    pub(crate) fn draw(&mut self, mesh: &TriMesh, part: PictureBody) {
        for t in 0..mesh.triangles.len() {
            self.triangle(mesh.corners(t), part);
        }
    }

    fn triangle(&mut self, corners: [Point; 3], part: PictureBody) {
        let (surface, wide) = (&mut self.surfaces[part as usize], self.view.size()[0]);
        self.view.triangle(corners, |[x, y], depth, shade| {
            let nearest = &mut surface[y * wide + x];
            if depth > nearest.0 {
                *nearest = (depth, shade);
            }
        });
    }

    /// Points at which the first and the second body are seen, and the depth of the nearest of both in the
    /// middle, mm.
    pub(crate) fn seen(&self) -> ([usize; 2], f64) {
        let [first, second, _] = &self.surfaces;
        let nearer = |a: &[(f64, f64)], b: &[(f64, f64)]| a.iter().zip(b).filter(|(a, b)| a.0 > b.0).count();
        let [wide, high] = self.view.size();
        let middle = high / 2 * wide + wide / 2;
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
        for (i, gray) in self.surfaces[PictureBody::Other as usize].iter().enumerate() {
            let [x, y] = [i % self.view.size()[0], i / self.view.size()[0]];
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
    use proveout_geom::{Aabb, Vector, box_mesh};

    use super::*;

    fn cube(center: [f64; 3], half: f64) -> TriMesh {
        let c = Vector::from(center);
        let h = Vector::repeat(half);
        box_mesh(&Aabb { min: Point::from(c - h), max: Point::from(c + h) })
    }

    #[test]
    fn a_cube_covers_its_share_and_the_nearer_one_is_seen() {
        let view = Projection::new(&Vector::x(), Point::origin(), 10.0, [200, 100]);
        let mut raster = Raster::new(view);
        raster.draw(&cube([0.0, 0.0, 0.0], 5.0), PictureBody::First);
        // 10 of 20 mm of height are 50 points, in both directions.
        assert_eq!(raster.seen(), ([2500, 0], 5.0));
        raster.draw(&cube([20.0, 0.0, 0.0], 2.0), PictureBody::Second);
        assert_eq!(raster.seen(), ([2500 - 400, 400], 22.0));
        // A body farther away changes nothing, nor does a gray one in front.
        raster.draw(&cube([-20.0, 0.0, 0.0], 4.0), PictureBody::Second);
        raster.draw(&cube([40.0, 0.0, 0.0], 9.0), PictureBody::Other);
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
            let mut raster = Raster::new(Projection::new(&Vector::x(), Point::origin(), 10.0, [200, 100]));
            raster.draw(&cube([0.0, 0.0, 0.0], 6.0), PictureBody::Second);
            raster.draw(&cube(center, 3.0), PictureBody::First);
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
        let mut raster = Raster::new(Projection::new(&Vector::z(), Point::origin(), 1.0, [8, 8]));
        let at = |x: f64| Point::new(x, 0.0, 0.0);
        raster.triangle([at(0.0), at(1.0), at(0.5)], PictureBody::First);
        raster.triangle([at(0.0), at(f64::NAN), Point::new(0.0, 1.0, 0.0)], PictureBody::First);
        raster.triangle([at(0.0), at(f64::INFINITY), Point::new(0.0, 1.0, 0.0)], PictureBody::First);
        assert_eq!(raster.seen().0, [0, 0]);
    }
}
