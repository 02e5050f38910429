//! The nearest point of a blade on its closed form against a slow search that shares nothing with it but the
//! outline.
//!
//! Blades: without twist, as of a compressor, twisted by one and by three degrees a millimeter; with and
//! without platform; a section of constant thickness (all circles of its concave side have one center), one
//! thinner in the middle, one nearly straight, one bent by 145 degrees. Points: anywhere round the blade, on
//! the camber line, the X axis and the axis of the camber line, on all faces and next to them, within and
//! beyond the edges of tip and platform, in the center of the fillet, and far away.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use std::f64::consts::FRAC_PI_2;

use proveout_blade::{Blade, BladeSpec, CamberSection, NEAREST_ERROR_MM, Platform, SectionCurve};
use proveout_geom::{Point, Vector};

struct Random(u64);

impl Random {
    fn range(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 33) as f64 / f64::from(1u32 << 31))
    }
}

/// Random points of each blade: a hundred times more with `PROVEOUT_CASES=100`.
fn cases(count: usize) -> usize {
    std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse::<usize>().ok()).unwrap_or(1) * count
}

fn section(thickness: f64, leading: f64, trailing: f64, camber: f64) -> CamberSection {
    let mut section = CamberSection {
        chord: 60.0,
        camber_angle: camber,
        thickness,
        leading_radius: leading,
        trailing_radius: trailing,
        shift: [0.0; 2],
    };
    section.shift = section.centroid().map(|v| -v);
    section
}

const F: f64 = 10.0;
const MARGIN: f64 = 14.0;
const LOW: f64 = -12.0;
const TIP: f64 = 45.0;

fn blades() -> Vec<(Blade, bool)> {
    let plain = CamberSection::stand_in;
    let list = [
        (plain(), 0.0, true),
        (plain(), 0.00175, true),
        (plain(), -0.01, false),
        (plain(), 0.02, true),
        (plain(), 0.05, true),
        (section(8.0, 4.0, 4.0, 1.2), 0.002, true),
        (section(3.0, 2.0, 1.8, 0.8), 0.0, true),
        (section(6.0, 1.0, 1.5, 1e-3), -0.004, true),
        (section(5.0, 1.5, 1.0, 2.53), 0.003, false),
    ];
    let blade = |(section, twist, on_platform): (CamberSection, f64, bool)| {
        let platform = on_platform.then_some(Platform { fillet_radius: F, margin: MARGIN, thickness: -LOW });
        (Blade::new(BladeSpec { section, length: TIP, twist, platform }).unwrap(), on_platform)
    };
    list.into_iter().map(blade).collect()
}

/// A face run by arc length and a second parameter.
struct Face<'a> {
    blade: &'a Blade,
    kind: u8,
    bounds: [f64; 2],
}

impl Face<'_> {
    fn at(&self, arc: f64, b: f64) -> Point {
        let on = self.blade.outline().at(arc);
        let [ny, nz] = on.normal();
        let out = |d: f64| [on.position[0] + d * ny, on.position[1] + d * nz];
        match self.kind {
            0 => self.blade.at(arc, b).point,
            1 => self.blade.raised(out(F * (1.0 - b.sin())), on.normal_angle, F * (1.0 - b.cos())).point,
            _ => Point::new(b, out(MARGIN)[0], out(MARGIN)[1]),
        }
    }
}

/// A face with points on it and their parameters.
type Sampled<'a> = (Face<'a>, Vec<(f64, f64, Point)>);

/// All faces with points on them, and outlines of the plane ones.
struct Brute<'a> {
    blade: &'a Blade,
    faces: Vec<Sampled<'a>>,
    platform: bool,
    outlines: [Vec<[f64; 2]>; 3],
}

impl<'a> Brute<'a> {
    fn new(blade: &'a Blade, platform: bool) -> Self {
        let perimeter = blade.outline().perimeter();
        let kinds: &[(u8, [f64; 2], usize)] = if platform {
            &[(0, [F, TIP], 60), (1, [0.0, FRAC_PI_2], 20), (2, [LOW, 0.0], 10)]
        } else {
            &[(0, [0.0, TIP], 70)]
        };
        let faces = kinds.iter().map(|&(kind, bounds, rows)| {
            let face = Face { blade, kind, bounds };
            let mut points = Vec::new();
            for i in 0..400 {
                let arc = perimeter * f64::from(i) / 400.0;
                for k in 0..=rows {
                    let b = bounds[0] + (bounds[1] - bounds[0]) * k as f64 / rows as f64;
                    points.push((arc, b, face.at(arc, b)));
                }
            }
            (face, points)
        });
        let faces = faces.collect();
        let outline = |offset: f64| -> Vec<[f64; 2]> {
            let curve: SectionCurve = blade.spec().section.curve(offset).unwrap();
            (0..4000).map(|k| curve.at(curve.perimeter() * f64::from(k) / 4000.0).position).collect()
        };
        let outlines =
            if platform { [outline(0.0), outline(F), outline(MARGIN)] } else { [0; 3].map(|_| outline(0.0)) };
        Self { blade, faces, platform, outlines }
    }

    /// Whether an outline goes round a point of the section turned by the height `x`.
    fn winds(&self, outline: &[[f64; 2]], p: &Point, x: f64) -> bool {
        let (s, c) = (self.blade.spec().twist * x).sin_cos();
        let q = [c * p.y + s * p.z, c * p.z - s * p.y];
        let mut inside = false;
        for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            if (a[1] > q[1]) != (b[1] > q[1]) && q[0] < a[0] + (q[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                inside = !inside;
            }
        }
        inside
    }

    fn inside(&self, p: &Point) -> bool {
        if self.platform && p.x < 0.0 {
            return p.x > LOW && self.winds(&self.outlines[2], p, 0.0);
        }
        if !(0.0..=TIP).contains(&p.x) {
            return false;
        }
        if self.platform && p.x < F {
            let offset = F - (F * F - (F - p.x).powi(2)).sqrt();
            let curve = self.blade.spec().section.curve(offset).unwrap();
            let outline: Vec<_> =
                (0..2000).map(|k| curve.at(curve.perimeter() * f64::from(k) / 2000.0).position).collect();
            return self.winds(&outline, p, p.x);
        }
        self.winds(&self.outlines[0], p, p.x)
    }

    /// How far a point lies off the face that it should be on: in a plane of one height, of the outline
    /// there.
    fn off_the_surface(&self, p: &Point) -> f64 {
        let (turn, offset) = match p.x {
            x if self.platform && x < F => {
                (x.max(0.0), if x <= 0.0 { MARGIN } else { F - (F * F - (F - x).powi(2)).sqrt() })
            }
            x => (x, 0.0),
        };
        let (s, c) = (self.blade.spec().twist * turn).sin_cos();
        let q = [c * p.y + s * p.z, c * p.z - s * p.y];
        let curve = self.blade.spec().section.curve(offset).unwrap();
        let from = |arc: f64| {
            let at = curve.at(arc).position;
            (at[0] - q[0]).hypot(at[1] - q[1])
        };
        let step = curve.perimeter() / 500.0;
        let mut arc = (0..500).map(|k| f64::from(k) * step).min_by(|a, b| from(*a).total_cmp(&from(*b))).unwrap();
        let mut step = step;
        while step > 1e-9 {
            match [arc - step, arc + step].into_iter().find(|a| from(*a) < from(arc)) {
                Some(to) => arc = to,
                None => step *= 0.5,
            }
        }
        let plane = |x: f64, on: bool| if on { (p.x - x).abs() } else { f64::INFINITY };
        let base = if self.platform { LOW } else { 0.0 };
        let tip = plane(TIP, self.winds(&self.outlines[0], p, TIP));
        let bottom = plane(base, self.winds(&self.outlines[2], p, 0.0));
        let top = plane(
            0.0,
            self.platform && self.winds(&self.outlines[2], p, 0.0) && !self.winds(&self.outlines[1], p, 0.0),
        );
        from(arc).min(tip).min(bottom).min(top)
    }

    /// Distance from all faces: the best points of the grid, each gone down from by halved steps.
    fn distance(&self, p: &Point) -> f64 {
        let mut least = f64::INFINITY;
        let [section, foot, rim] = &self.outlines;
        if self.winds(section, p, TIP) {
            least = least.min((p.x - TIP).abs());
        }
        let ground = if self.platform { LOW } else { 0.0 };
        if self.winds(if self.platform { rim } else { section }, p, 0.0) {
            least = least.min((p.x - ground).abs());
        }
        if self.platform && self.winds(rim, p, 0.0) && !self.winds(foot, p, 0.0) {
            least = least.min(p.x.abs());
        }
        for (face, points) in &self.faces {
            let mut all: Vec<_> = points.iter().map(|(arc, b, at)| ((at - p).norm(), *arc, *b)).collect();
            all.select_nth_unstable_by(20, |a, b| a.0.total_cmp(&b.0));
            all.truncate(20);
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            for &(mut d, mut arc, mut b) in all.iter().step_by(9) {
                let mut step = [0.4, 0.02 * (face.bounds[1] - face.bounds[0])];
                while step[0] > 1e-8 {
                    let mut moved = false;
                    for (i, j) in [
                        (1.0, 0.0),
                        (-1.0, 0.0),
                        (0.0, 1.0),
                        (0.0, -1.0),
                        (1.0, 1.0),
                        (1.0, -1.0),
                        (-1.0, 1.0),
                        (-1.0, -1.0),
                    ] {
                        let to = (arc + i * step[0], (b + j * step[1]).clamp(face.bounds[0], face.bounds[1]));
                        let found = (face.at(to.0, to.1) - p).norm();
                        if found < d {
                            (d, arc, b, moved) = (found, to.0, to.1, true);
                        }
                    }
                    if !moved {
                        step = step.map(|s| 0.5 * s);
                    }
                }
                least = least.min(d);
            }
        }
        least
    }
}

fn points(blade: &Blade, platform: bool, random: &mut Random) -> Vec<Point> {
    let mut points = Vec::new();
    let section = &blade.spec().section;
    let low = if platform { LOW } else { 0.0 };
    let turned = |[y, z]: [f64; 2], x: f64| {
        let (s, c) = (blade.spec().twist * x).sin_cos();
        Point::new(x, c * y - s * z, s * y + c * z)
    };
    for k in 0..cases(2) {
        points.push(Point::new(random.range(-25.0, 60.0), random.range(-55.0, 55.0), random.range(-40.0, 40.0)));
        // On the camber line, where both sides are as near, and its ends, where all of an edge is; the axis
        // of the camber line.
        let x = random.range(low, TIP);
        let end = [0.0, 1.0, random.range(0.0, 1.0), 0.5][k % 4];
        let (center, sides) = section.pair(end, 0.0);
        points.push(turned(center, x.max(0.0)));
        let away = [sides[0].position[0] - center[0], sides[0].position[1] - center[1]];
        points.push(turned([center[0] + 0.3 * away[0], center[1] + 0.3 * away[1]], x.max(0.0)));
        let drop = section.camber_radius() * (0.5 * section.camber_angle).cos();
        let pivot = [section.shift[0], section.shift[1] - drop];
        if drop < 200.0 {
            points.push(turned(pivot, x));
        }
        points.push(Point::new(random.range(-20.0, 50.0), 0.0, 0.0));
        // Over the tip and its edge, under the platform and next to its edges.
        let (_, [p, s]) = section.pair(random.range(0.0, 1.0), random.range(-0.8, 3.0));
        points.push(turned(if k % 2 == 0 { p.position } else { s.position }, TIP + random.range(-0.9, 3.0)));
        if platform {
            let (_, [p, s]) = section.pair(random.range(0.0, 1.0), MARGIN + random.range(-3.0, 3.0));
            let at = if k % 2 == 0 { p.position } else { s.position };
            points.push(Point::new([0.0, LOW][k / 2 % 2] + random.range(-3.0, 3.0), at[0], at[1]));
            // In the fillet, up to its center.
            let (_, [p, s]) = section.pair(random.range(0.0, 1.0), F * random.range(0.0, 1.0));
            let at = if k % 2 == 0 { p.position } else { s.position };
            points.push(turned(at, if k % 5 == 0 { F } else { random.range(0.0, F) }));
        }
    }
    points.extend([Point::new(900.0, -700.0, 300.0), Point::new(20.0, 3000.0, 0.0), Point::new(-1e4, 0.0, 0.0)]);
    points
}

#[test]
fn no_point_of_the_surface_is_nearer_and_the_sign_is_that_of_the_solid() {
    let mut random = Random(11);
    for (blade, platform) in blades() {
        let brute = Brute::new(&blade, platform);
        for p in points(&blade, platform, &mut random) {
            let found = blade.nearest(&p).unwrap();
            let (d, twist) = (found.distance.abs(), blade.spec().twist);
            let least = brute.distance(&p);
            let scale = 1.0 + 1e-9 * p.coords.norm();
            assert!(d <= least + NEAREST_ERROR_MM * scale, "{p} {found:?} {least} twist {twist}");
            // Not farther either: the slow search may stop next to a minimum that is flat, but what was found
            // is a point of the surface.
            assert!(((p - found.point).norm() - d).abs() < 1e-9 * scale, "{p} {found:?}");
            assert!(
                brute.off_the_surface(&found.point) < 1e-6 * scale,
                "{p} {found:?} is not on the surface, twist {twist}"
            );
            if d > 1e-3 {
                assert_eq!(found.distance < 0.0, brute.inside(&p), "{p} {found:?} twist {twist}");
            }
            assert!((found.normal.norm() - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn beside_every_face_the_distance_is_that_along_its_normal() {
    // As far as no center of curvature or other face comes nearer: 0.4 mm. Zero and picometers to micrometers
    // are among them, where the sign must hold down to 1e-8 mm.
    let mut random = Random(7);
    for (blade, platform) in blades() {
        if blade.spec().twist.abs() > 0.03 {
            continue;
        }
        let perimeter = blade.outline().perimeter();
        let hold = |point: Point, normal: Vector, distance: f64| {
            let p = point + normal * distance;
            let found = blade.nearest(&p).unwrap();
            assert!((found.distance - distance).abs() < 1e-8, "{found:?} {point} {distance} {}", blade.spec().twist);
            assert!(found.normal.dot(&normal) > 1.0 - 1e-6, "{found:?} {normal} {distance}");
        };
        for k in 0..cases(400) {
            let small = random.range(-1e-6, 1e-6);
            let d = [0.0, random.range(-0.4, 0.4), small, 1e-3 * small, random.range(-0.01, 0.01)][k % 5];
            let arc = random.range(0.0, perimeter);
            let from = if platform { F } else { 0.0 };
            let side = blade.at(arc, random.range(from + 0.6, TIP - 0.6));
            hold(side.point, side.normal, d);
            let on = blade.outline().at(arc);
            let (s, c) = on.normal_angle.sin_cos();
            let out = |d: f64| [on.position[0] + d * c, on.position[1] + d * s];
            if platform {
                let b = random.range(0.02, FRAC_PI_2 - 0.02);
                let (steep, level) = b.sin_cos();
                let at = blade.raised(out(F * (1.0 - steep)), on.normal_angle, F * (1.0 - level));
                // The lean of the airfoil, and the slope of the fillet on top of it.
                let lean = at.normal.x / at.normal.y.hypot(at.normal.z);
                let flat = Vector::new(0.0, at.normal.y, at.normal.z).normalize();
                hold(at.point, (flat * steep + Vector::x() * (level + steep * lean)).normalize(), d);
                let [y, z] = out(MARGIN);
                hold(Point::new(random.range(LOW + 0.5, -0.5), y, z), Vector::new(0.0, c, s), d);
                let [y, z] = out(random.range(F + 0.5, MARGIN - 0.5));
                hold(Point::new(0.0, y, z), Vector::x(), d);
                let [y, z] = out(random.range(-0.5, MARGIN - 0.5));
                hold(Point::new(LOW, y, z), -Vector::x(), d);
            }
            let inner = blade.raised(out(-random.range(0.6, 0.9)), on.normal_angle, TIP).point;
            hold(inner, Vector::x(), d.clamp(-0.3, 0.4));
        }
    }
}

#[test]
fn beyond_an_edge_the_way_to_it_counts() {
    let mut random = Random(3);
    for (blade, platform) in blades() {
        if blade.spec().twist.abs() > 0.015 {
            continue;
        }
        for _ in 0..cases(100) {
            let on = blade.outline().at(random.range(0.0, blade.outline().perimeter()));
            let (way, angle) = (random.range(2e-3, 0.9), random.range(0.5, FRAC_PI_2 - 0.5));
            let hold = |edge: Point, direction: Vector| {
                let found = blade.nearest(&(edge + direction * way)).unwrap();
                assert!((found.distance - way).abs() < 1e-7, "{found:?} {edge} {way}");
                assert!((found.point - edge).norm() < 1e-3 && found.normal.dot(&direction) > 1.0 - 1e-5, "{found:?}");
            };
            let turned = on.normal_angle + blade.spec().twist * TIP;
            let out = Vector::new(0.0, turned.cos(), turned.sin());
            hold(blade.raised(on.position, on.normal_angle, TIP).point, Vector::x() * angle.sin() + out * angle.cos());
            if platform {
                let [ny, nz] = on.normal();
                let rim = Point::new(LOW, on.position[0] + MARGIN * ny, on.position[1] + MARGIN * nz);
                hold(rim, -Vector::x() * angle.sin() + Vector::new(0.0, ny, nz) * angle.cos());
            }
        }
    }
}

#[test]
fn numbers_that_are_none_have_no_nearest_point_and_far_ones_end() {
    let (blade, _) = &blades()[1];
    assert_eq!(blade.nearest(&Point::new(f64::NAN, 0.0, 0.0)), None);
    assert_eq!(blade.nearest(&Point::new(0.0, f64::INFINITY, 0.0)), None);
    assert_eq!(blade.nearest(&Point::new(0.0, 0.0, 1e8)), None);
    let far = blade.nearest(&Point::new(1e6, 1e6, -1e6)).unwrap();
    assert!((far.distance - 3f64.sqrt() * 1e6).abs() < 100.0);
}

#[test]
fn an_outline_that_crosses_itself_is_refused() {
    // Bent by 139 degrees, thick in the middle: the arc of the trailing edge runs into the concave side,
    // which does not fold.
    let section = CamberSection {
        shift: [0.0; 2],
        ..section(35.495_491_974_335_16, 2.111_615, 15.652_537_414_059_042, 2.421_683_587_785_810_5)
    };
    let platform = Some(Platform { fillet_radius: 0.1, margin: 0.616_231_168_992_817_5, thickness: 5.0 });
    let error = Blade::new(BladeSpec { section, length: 20.0, twist: 0.0, platform }).unwrap_err();
    assert!(error.to_string().contains("crosses itself"), "{error}");
}
