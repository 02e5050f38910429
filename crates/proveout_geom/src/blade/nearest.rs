//! The point of a blade that is nearest to a given one, on its closed form.
//!
//! The solid has two curved faces, the side of the airfoil and the fillet, and plane ones: tip, top and bottom of the platform, and
//! its rim, which is straight along X. Where section and rim lie at an offset, their outline is a parallel curve of the
//! section, so that one search on the section serves them all.
//!
//! **Section.** The point of an outline nearest to `q` fulfills `(P - q) . t = 0`. With the outward normal `n`, the curvature `k`
//! (above zero where the outline is convex) and arc length `s`, `dt/ds = -k n`, so that Newton's step is
//!
//! ```text
//!     ds = -(P - q) . t / (1 + k (q - P) . n)
//! ```
//!
//! It starts at every local minimum among the stations of the outline that could hold the least distance: between two stations
//! the distance falls by no more than half of their way. So no nearer branch is missed.
//!
//! **Side and fillet.** With `w` the twist, `e` the X axis, `t`, `n` turned with the section and `S = x e + P + d n`, the fillet
//! is run by the angle `f` at its center, `x = r (1 - cos f)`, `d = r (1 - sin f)`; the side has `d = 0` and `x` itself. With `m = 1 +
//! k d`, and a prime for the derivative by `x` or `f`,
//!
//! ```text
//!     S_s = m t             S_b  = x' (e + w e x S) + d' n
//!     S_ss = -m k n         S_sb = x' w m e x t + d' k t        S_bb = x'' (e + w e x S) + x' w e x S_b + d'' n + d' x' w e x n
//! ```
//!
//! (`S_ss` without `k' d t`, which is square to `S - p` where the search ends.) Newton's method on `|S - p|^2 / 2` with these
//! second derivatives, within the bounds of `b`; where the matrix is not positive or the distance does not fall, the step is
//! that of Gauss and Newton, and halved. It starts where the nearest point lies without twist: there distances are those in the half plane of `x` and
//! of the distance `u` from the outline, in which the blade is a profile of straight lines and a quarter circle.
//!
//! **Sign.** All edges of the solid are convex: what is nearest to an edge lies outside. Elsewhere the normal tells.

use super::body::Blade;
use super::section::{NEAR_MM, SETTLED_MM, Station};
use crate::{Point, Vector};

/// Steps of a search; Newton needs four or five.
const STEPS: usize = 60;

/// The nearest point of a blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnBlade {
    /// The point of its surface.
    pub point: Point,
    /// Signed distance, mm: below zero inside of the material.
    pub distance: f64,
    /// Outward unit normal; at an edge the direction from there.
    pub normal: Vector,
}

/// One of the curved faces.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Face {
    /// Bounds of X.
    Side([f64; 2]),
    /// Radius; its angle runs from 0 at the platform to a right angle at the airfoil.
    Fillet(f64),
}

impl Face {
    fn bounds(self) -> [f64; 2] {
        match self {
            Self::Side(bounds) => bounds,
            Self::Fillet(_) => [0.0, std::f64::consts::FRAC_PI_2],
        }
    }
}

/// A point of a curved face with its derivatives.
struct Jet {
    point: Vector,
    s: Vector,
    b: Vector,
    ss: Vector,
    sb: Vector,
    bb: Vector,
}

/// The best point so far, and whether it lies on an edge.
struct Best {
    square: f64,
    point: Point,
    /// None at an edge.
    normal: Option<Vector>,
}

impl Best {
    fn take(&mut self, p: &Point, point: Point, normal: Option<Vector>) {
        let square = (p - point).norm_squared();
        if square < self.square {
            *self = Self { square, point, normal };
        }
    }
}

impl Blade {
    /// The point of the solid's surface nearest to a point; none for coordinates that are no numbers.
    pub fn nearest(&self, p: &Point) -> Option<NearestOnBlade> {
        if !p.iter().all(|v| v.is_finite()) {
            return None;
        }
        let spec = self.spec();
        let mut best = Best { square: f64::INFINITY, point: *p, normal: None };
        self.curved_faces(p, &mut best);
        // The tip, over the section where it ends.
        self.plane_face(p, spec.length, spec.twist * spec.length, [f64::NEG_INFINITY, 0.0], 1.0, &mut best);
        match spec.platform {
            None => self.plane_face(p, 0.0, 0.0, [f64::NEG_INFINITY, 0.0], -1.0, &mut best),
            Some(platform) => {
                let (radius, margin) = (platform.fillet_radius, platform.margin);
                self.plane_face(p, 0.0, 0.0, [radius, margin], 1.0, &mut best);
                self.plane_face(p, -platform.thickness, 0.0, [f64::NEG_INFINITY, margin], -1.0, &mut best);
                self.rim(p, margin, [-platform.thickness, 0.0], &mut best);
            }
        }
        let away = p - best.point;
        let length = away.norm();
        let (distance, normal) = match best.normal {
            Some(normal) => (if away.dot(&normal) < 0.0 { -length } else { length }, normal),
            None => (length, away / length),
        };
        normal.iter().all(|v| v.is_finite()).then_some(NearestOnBlade { point: best.point, distance, normal })
    }

    /// A plane face square to X at `x`: the section turned by `turn` between two distances from its outline. `sense` is that of
    /// its outward normal along X.
    fn plane_face(&self, p: &Point, x: f64, turn: f64, within: [f64; 2], sense: f64, best: &mut Best) {
        if (p.x - x).powi(2) >= best.square {
            return;
        }
        let from_outline = self.outline_distance(turned(p, -turn));
        if from_outline >= within[0] && from_outline <= within[1] {
            best.take(p, Point::new(x, p.y, p.z), Some(Vector::new(sense, 0.0, 0.0)));
        }
    }

    /// The rim of the platform: the outline at the margin, straight along X.
    fn rim(&self, p: &Point, margin: f64, [low, high]: [f64; 2], best: &mut Best) {
        let x = p.x.clamp(low, high);
        if (p.x - x).powi(2) >= best.square {
            return;
        }
        for station in self.outline().near([p.y, p.z], margin, 0.0) {
            let on = self.outline().settle(station, [p.y, p.z], margin);
            let (sine, cosine) = on.normal_angle.sin_cos();
            let normal = (x > low && x < high).then(|| Vector::new(0.0, cosine, sine));
            best.take(p, Point::new(x, on.position[0], on.position[1]), normal);
        }
    }

    fn curved_faces(&self, p: &Point, best: &mut Best) {
        let spec = self.spec();
        let fillet = spec.platform.map(|platform| platform.fillet_radius);
        let side = [fillet.unwrap_or(0.0), spec.length];
        // Turned back as the section that lies beside the point is, the blade is nearly one without twist.
        let beside = p.x.clamp(0.0, spec.length);
        let flat = turned(p, -spec.twist * beside);
        // The sides lean by the twist: another branch may be nearer by as much of the distance.
        let lean = spec.twist.abs() * flat[0].hypot(flat[1]);
        for station in self.outline().near(flat, 0.0, lean) {
            self.search(p, Face::Side(side), station, p.x.clamp(side[0], side[1]), best);
            if let Some(radius) = fillet {
                // The center of the fillet lies beside the outline at its radius; the angle is that of the point about it.
                let on = self.outline().point(station, 0.0);
                let (sine, cosine) = on.normal_angle.sin_cos();
                let out = (flat[0] - on.position[0]) * cosine + (flat[1] - on.position[1]) * sine;
                let (up, toward) = (radius - p.x, radius - out);
                let angle = toward.atan2(up).clamp(0.0, std::f64::consts::FRAC_PI_2);
                self.search(p, Face::Fillet(radius), station, angle, best);
            }
        }
    }

    /// Newton's method on a curved face.
    fn search(&self, p: &Point, face: Face, mut station: Station, mut b: f64, best: &mut Best) {
        let [low, high] = face.bounds();
        let outline = self.outline();
        let mut jet = self.jet(face, station, b);
        for _ in 0..STEPS {
            let r = jet.point - p.coords;
            let (gs, gb) = (jet.s.dot(&r), jet.b.dot(&r));
            let gauss = [jet.s.dot(&jet.s), jet.s.dot(&jet.b), jet.b.dot(&jet.b)];
            let newton = [gauss[0] + jet.ss.dot(&r), gauss[1] + jet.sb.dot(&r), gauss[2] + jet.bb.dot(&r)];
            // At a bound that the distance falls beyond, only the section is free.
            let held = b <= low && gb >= 0.0 || b >= high && gb <= 0.0;
            let Some((ds, db, is_newton)) = step(newton, gauss, gs, gb, held) else { break };
            let now = r.norm_squared();
            let length = ds.abs().max(db.abs() * jet.b.norm());
            // A short step of Newton is right to the last digits, which the distance no longer tells.
            let sure = is_newton && length < NEAR_MM;
            let mut part = 1.0;
            let mut moved = false;
            while part > 1e-9 {
                let to = (b + part * db).clamp(low, high);
                let next = outline.moved(station, part * ds);
                let there = self.jet(face, next, to);
                if sure || (there.point - p.coords).norm_squared() < now {
                    (station, b, jet, moved) = (next, to, there, true);
                    break;
                }
                part *= 0.5;
            }
            if !moved || part * length < SETTLED_MM {
                break;
            }
        }
        // The fillet runs on into the side and the platform; the side ends in an edge at the tip, and at the foot without a
        // platform.
        let edge = match face {
            Face::Fillet(_) => false,
            Face::Side(_) => b >= high || b <= low && self.spec().platform.is_none(),
        };
        let mut normal = jet.s.cross(&jet.b);
        if normal.dot(&self.outward(face, station, b)) < 0.0 {
            normal = -normal;
        }
        best.take(p, Point::from(jet.point), normal.try_normalize(0.0).filter(|_| !edge));
    }

    /// A direction that points out of the material at a curved face.
    fn outward(&self, face: Face, station: Station, b: f64) -> Vector {
        let on = self.outline().point(station, 0.0);
        let (sine, cosine) = match face {
            Face::Side(_) => (on.normal_angle + self.spec().twist * b).sin_cos(),
            Face::Fillet(radius) => (on.normal_angle + self.spec().twist * radius * (1.0 - b.cos())).sin_cos(),
        };
        match face {
            Face::Side(_) => Vector::new(0.0, cosine, sine),
            Face::Fillet(_) => Vector::new(b.cos(), b.sin() * cosine, b.sin() * sine),
        }
    }

    fn jet(&self, face: Face, station: Station, b: f64) -> Jet {
        let w = self.spec().twist;
        // x and d with two derivatives by b.
        let ([x, x1, x2], [d, d1, d2]) = match face {
            Face::Side(_) => ([b, 1.0, 0.0], [0.0; 3]),
            Face::Fillet(r) => {
                let (s, c) = b.sin_cos();
                ([r * (1.0 - c), r * s, r * c], [r * (1.0 - s), -r * c, r * s])
            }
        };
        let on = self.outline().point(station, 0.0);
        let (sine, cosine) = (w * x).sin_cos();
        let turn = |[y, z]: [f64; 2]| Vector::new(0.0, cosine * y - sine * z, sine * y + cosine * z);
        let [ny, nz] = on.normal();
        let (n, t) = (turn([ny, nz]), turn([-nz, ny]));
        let (k, m) = (on.curvature, 1.0 + on.curvature * d);
        let cross = |v: &Vector| Vector::new(0.0, -v.z, v.y); // e x v
        let point = Vector::new(x, 0.0, 0.0) + turn(on.position) + n * d;
        let rise = Vector::x() + cross(&point) * w;
        let b1 = rise * x1 + n * d1;
        Jet {
            point,
            s: t * m,
            b: b1,
            ss: n * (-m * k),
            sb: cross(&t) * (x1 * w * m) + t * (d1 * k),
            bb: rise * x2 + cross(&b1) * (x1 * w) + n * d2 + cross(&n) * (d1 * x1 * w),
        }
    }

    /// Signed distance of a point of the section's plane from the outline, mm: below zero inside.
    fn outline_distance(&self, q: [f64; 2]) -> f64 {
        let outline = self.outline();
        let mut best = (f64::INFINITY, 0.0);
        for station in outline.near(q, 0.0, 0.0) {
            let on = outline.settle(station, q, 0.0);
            let way = [q[0] - on.position[0], q[1] - on.position[1]];
            let (length, [ny, nz]) = (way[0].hypot(way[1]), on.normal());
            if length < best.0 {
                best = (length, way[0] * ny + way[1] * nz);
            }
        }
        best.0.copysign(best.1)
    }
}

/// The step of Newton's method, or of Gauss and Newton where its matrix is not positive; along the section alone when the
/// other coordinate is held.
fn step(newton: [f64; 3], gauss: [f64; 3], gs: f64, gb: f64, held: bool) -> Option<(f64, f64, bool)> {
    if held {
        let is_newton = newton[0] > 0.0;
        let curvature = if is_newton { newton[0] } else { gauss[0] };
        return (curvature > 0.0).then(|| (-gs / curvature, 0.0, is_newton));
    }
    for ([a, c, d], is_newton) in [(newton, true), (gauss, false)] {
        let determinant = a * d - c * c;
        if a > 0.0 && determinant > 1e-12 * a.abs() * d.abs() {
            return Some((-(d * gs - c * gb) / determinant, -(a * gb - c * gs) / determinant, is_newton));
        }
    }
    // Where the face degenerates: down the slope of the section alone.
    (gauss[0] > 0.0).then(|| (-gs / gauss[0], 0.0, false))
}

/// y and z of a point, turned about X.
fn turned(p: &Point, angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c * p.y - s * p.z, s * p.y + c * p.z]
}

#[cfg(test)]
mod tests {
    use super::super::{BladeSpec, CamberSection, Platform};
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    fn blade(twist: f64, platform: bool) -> Blade {
        let platform = platform.then_some(Platform { fillet_radius: 10.0, margin: 14.0, thickness: 12.0 });
        Blade::new(BladeSpec { section: CamberSection::stand_in(), length: 45.0, twist, platform }).unwrap()
    }

    fn random(state: &mut u64, low: f64, high: f64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((*state >> 33) as f64 / f64::from(1u32 << 31))
    }

    /// A point of the fillet with its normal, by its definition: the outline at an offset, and differences for the normal.
    fn fillet(blade: &Blade, arc: f64, angle: f64) -> (Point, Vector) {
        let at = |arc: f64, angle: f64| {
            let on = blade.outline().at(arc);
            let (s, c) = angle.sin_cos();
            let (x, d) = (10.0 * (1.0 - c), 10.0 * (1.0 - s));
            let [ny, nz] = on.normal();
            blade.raised([on.position[0] + d * ny, on.position[1] + d * nz], on.normal_angle, x).point
        };
        let h = 1e-6;
        let along = at(arc + h, angle) - at(arc - h, angle);
        let up = at(arc, angle + h) - at(arc, angle - h);
        let mut n = along.cross(&up).normalize();
        if n.dot(&Vector::new(angle.cos(), 0.0, 0.0)) < 0.0 {
            n = -n;
        }
        (at(arc, angle), n)
    }

    #[test]
    fn points_at_a_known_distance_from_every_face_have_it() {
        // Along the normal of a point of a smooth face, as far as no center of curvature or other face comes nearer: 0.5 mm
        // inside of a blade with edges of 1.2 mm radius, 5 mm outside of it, in the fillet up to its center.
        let mut state = 7;
        for (twist, platform) in [(0.0, false), (0.0, true), (0.00175, true), (0.01, true), (-0.01, false)] {
            let blade = blade(twist, platform);
            let perimeter = blade.outline().perimeter();
            let mut hold = |point: Point, normal: Vector, distance: f64, tolerance: f64| {
                let found = blade.nearest(&(point + normal * distance)).unwrap();
                assert!((found.distance - distance).abs() < tolerance, "{found:?} {point} {distance} {twist} {platform}");
                if distance != 0.0 {
                    assert!((found.point - point).norm() < 1e-5 + 1e3 * tolerance, "{found:?} {point} {distance}");
                }
                assert!(found.normal.dot(&normal) > 1.0 - 1e-6, "{found:?} {normal} {distance}");
            };
            for k in 0..400 {
                let distance = [0.0, random(&mut state, -0.5, 0.5), random(&mut state, -1e-6, 1e-6)][k % 3];
                let arc = random(&mut state, 0.0, perimeter);
                let from = if platform { 10.0 } else { 0.0 };
                let side = blade.at(arc, random(&mut state, from + 0.7, 44.4));
                hold(side.point, side.normal, distance, 1e-10);
                // The concave side of the section bends about 60 mm away.
                let far = random(&mut state, 0.0, 5.0);
                let leaves = side.point.x + far * side.normal.x;
                if leaves > from + 0.1 + far && leaves < 45.0 {
                    hold(side.point, side.normal, far, 1e-10);
                }
                if platform {
                    let (point, normal) = fillet(&blade, arc, random(&mut state, 0.1, FRAC_PI_2 - 0.1));
                    // Differences of step 1e-6 turn the normal by 1e-9, which moves the point by as much of the distance.
                    hold(point, normal, distance, 2e-9);
                    let on = blade.outline().at(arc);
                    let (s, c) = on.normal_angle.sin_cos();
                    let out = |d: f64| [on.position[0] + d * c, on.position[1] + d * s];
                    let [y, z] = out(14.0);
                    hold(Point::new(random(&mut state, -11.4, -0.6), y, z), Vector::new(0.0, c, s), distance, 1e-10);
                    let [y, z] = out(random(&mut state, 10.6, 13.4));
                    hold(Point::new(0.0, y, z), Vector::x(), distance, 1e-10);
                    let [y, z] = out(random(&mut state, -0.5, 13.0));
                    hold(Point::new(-12.0, y, z), -Vector::x(), distance, 1e-10);
                }
                let inner = blade.outline().at(arc);
                let depth = random(&mut state, 0.6, 1.1);
                let [ny, nz] = inner.normal();
                let [y, z] = [inner.position[0] - depth * ny, inner.position[1] - depth * nz];
                hold(blade.raised([y, z], inner.normal_angle, 45.0).point, Vector::x(), distance.clamp(-0.4, 0.4), 1e-10);
            }
        }
    }

    #[test]
    fn beyond_an_edge_the_way_to_it_counts() {
        let mut state = 3;
        for (twist, platform) in [(0.0, true), (0.00175, true), (0.00175, false)] {
            let blade = blade(twist, platform);
            for _ in 0..300 {
                let arc = random(&mut state, 0.0, blade.outline().perimeter());
                let on = blade.outline().at(arc);
                let way = random(&mut state, 1e-6, 3.0);
                // Between the normals of both faces of the tip's edge; that of the twisted side leans a little.
                let angle = random(&mut state, 0.2, FRAC_PI_2 - 0.2);
                let edge = blade.at(arc, 45.0).point;
                let turned = blade.raised([0.0; 2], on.normal_angle, 45.0).normal;
                let out = Vector::new(0.0, turned.y, turned.z).normalize();
                let direction = Vector::x() * angle.sin() + out * angle.cos();
                let found = blade.nearest(&(edge + direction * way)).unwrap();
                assert!((found.distance - way).abs() < 1e-9 && (found.point - edge).norm() < 1e-7, "{found:?} {edge} {way}");
                assert!(found.normal.dot(&direction) > 1.0 - 1e-6);
                if platform {
                    let (s, c) = on.normal_angle.sin_cos();
                    let rim = Point::new(-12.0, on.position[0] + 14.0 * c, on.position[1] + 14.0 * s);
                    let direction = -Vector::x() * angle.sin() + Vector::new(0.0, c, s) * angle.cos();
                    let found = blade.nearest(&(rim + direction * way)).unwrap();
                    assert!((found.distance - way).abs() < 1e-9 && (found.point - rim).norm() < 1e-7, "{found:?}");
                }
            }
        }
    }

    #[test]
    fn no_point_of_the_surface_is_nearer() {
        // An independent, slow search: points of all faces, close together. None is nearer than what is found; and the best
        // of them is not farther than their spacing allows: sqrt(d^2 + h^2) at half a spacing h.
        for (twist, platform) in [(0.00175, true), (0.02, true), (-0.01, false)] {
            let blade = blade(twist, platform);
            let perimeter = blade.outline().perimeter();
            let mut dense: Vec<Point> = Vec::new();
            let n = 700;
            for i in 0..n {
                let arc = perimeter * f64::from(i) / f64::from(n);
                let on = blade.outline().at(arc);
                let [ny, nz] = on.normal();
                let out = |d: f64| [on.position[0] + d * ny, on.position[1] + d * nz];
                let low = if platform { 10.0 } else { 0.0 };
                dense.extend((0..=175).map(|k| blade.at(arc, low + (45.0 - low) * f64::from(k) / 175.0).point));
                // Plane faces over the section: points on rays from the outline inward.
                for k in 0..=20 {
                    let inward = out(-0.2 * f64::from(k));
                    let tip = blade.raised(inward, on.normal_angle, 45.0).point;
                    dense.push(tip);
                    if !platform {
                        dense.push(Point::new(0.0, inward[0], inward[1]));
                    }
                }
                if platform {
                    for k in 0..=80 {
                        let (s, c) = (FRAC_PI_2 * f64::from(k) / 80.0).sin_cos();
                        dense.push(blade.raised(out(10.0 * (1.0 - s)), on.normal_angle, 10.0 * (1.0 - c)).point);
                    }
                    for k in 0..=60 {
                        let [y, z] = out(14.0);
                        dense.push(Point::new(-0.2 * f64::from(k), y, z));
                    }
                    for k in 0..=90 {
                        let [y, z] = out(14.0 - 0.2 * f64::from(k));
                        dense.push(Point::new(-12.0, y, z));
                        if k <= 20 {
                            dense.push(Point::new(0.0, y, z));
                        }
                    }
                }
            }
            let mut state = 11;
            for _ in 0..400 {
                let p = Point::new(
                    random(&mut state, -20.0, 55.0),
                    random(&mut state, -55.0, 55.0),
                    random(&mut state, -35.0, 35.0),
                );
                let found = blade.nearest(&p).unwrap();
                let least = dense.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
                let d = found.distance.abs();
                assert!(((p - found.point).norm() - d).abs() < 1e-12);
                assert!(d <= least + 1e-9, "{p} {found:?} {least}");
                assert!(least <= (d * d + 0.3 * 0.3).sqrt() + 1e-9, "{p} {found:?} {least}");
                // Inside where rays of the mesh say so.
                assert_eq!(found.distance < 0.0, blade.nearest(&(p - found.normal * 1e-4)).unwrap().distance < found.distance && is_inside(&blade, &p), "{p} {found:?}");
            }
        }
    }

    /// Inside by the definition of the solid: section and platform, by the winding of the outline.
    fn is_inside(blade: &Blade, p: &Point) -> bool {
        let spec = blade.spec();
        let winds = |offset: f64, turn: f64| {
            let curve = spec.section.curve(offset).unwrap();
            let n = 4000;
            let q = turned(p, -turn);
            let angle = |i: i32| {
                let at = curve.at(curve.perimeter() * f64::from(i) / f64::from(n)).position;
                (at[1] - q[1]).atan2(at[0] - q[0])
            };
            let sum: f64 = (0..n).map(|i| (angle(i + 1) - angle(i) + 3.0 * std::f64::consts::PI).rem_euclid(TAU) - std::f64::consts::PI).sum();
            sum > std::f64::consts::PI
        };
        match spec.platform {
            Some(platform) if p.x < 0.0 => p.x > -platform.thickness && winds(platform.margin, 0.0),
            _ if !(0.0..=spec.length).contains(&p.x) => false,
            Some(platform) if p.x < platform.fillet_radius => {
                let f = platform.fillet_radius;
                winds(f - (f * f - (f - p.x).powi(2)).sqrt(), spec.twist * p.x)
            }
            _ => winds(0.0, spec.twist * p.x),
        }
    }

    #[test]
    fn numbers_that_are_none_have_no_nearest_point() {
        let blade = blade(0.00175, true);
        assert_eq!(blade.nearest(&Point::new(f64::NAN, 0.0, 0.0)), None);
        assert_eq!(blade.nearest(&Point::new(0.0, f64::INFINITY, 0.0)), None);
        // Far away it is as far as the box says, and finite.
        let far = blade.nearest(&Point::new(1e6, 1e6, -1e6)).unwrap();
        assert!((far.distance - 3f64.sqrt() * 1e6).abs() < 100.0);
    }
}
