//! Every kind of blade against differences and against brute force.

use std::sync::Arc;

use proveout_blade::{
    Blade, BladeEnd, BladeSolid, BladeSpec, CamberSection, CamberSide, ClosedForm, ClosedSurface, Cui, Domain, Dong,
    FOOT_ERROR_MM, Foot, Local, Lu, ParametricSurface, Plate, PointedSection, SectionPart, Sine, SkinnedBlade,
    scalar::Scalar,
};
use proveout_geom::{Point, Vector};

/// Numbers from 0 to 1, the same in every run (Steele, Lea & Flood 2014, splitmix64).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ z >> 31) as f64 / u64::MAX as f64
    }

    /// Within a range; one in eight at an end, one in eight in the middle, where edges and seams lie.
    fn within(&mut self, range: [f64; 2]) -> f64 {
        let pick = self.next();
        match pick {
            p if p < 0.0625 => range[0],
            p if p < 0.125 => range[1],
            p if p < 0.25 => 0.5 * (range[0] + range[1]),
            _ => range[0] + (range[1] - range[0]) * self.next(),
        }
    }
}

/// Sections of Lu's blade as points, the edges marked: 10 degrees of w to either side of the ends of the
/// chord.
fn sections() -> Vec<PointedSection> {
    let blade = Lu::stand_in();
    let section = |j: u32| {
        let place = |k: u32| f64::from(k) * std::f64::consts::TAU / 360.0;
        let part = |k: u32| match k {
            0..=10 | 350.. => SectionPart::Trailing,
            11..=169 => SectionPart::Suction,
            170..=190 => SectionPart::Leading,
            _ => SectionPart::Pressure,
        };
        let point = |k: u32| Point::from(Vector::from(blade.place(place(k), f64::from(j) / 8.0)));
        PointedSection {
            name: j.to_string(),
            points: (0..360).map(point).collect(),
            parts: (0..360).map(part).collect(),
        }
    };
    (0..=8).map(section).collect()
}

fn camber(twist: f64) -> CamberSide {
    let spec = BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist, platform: None };
    CamberSide::new(Blade::new(spec).expect("a blade"))
}

fn kinds() -> Vec<(&'static str, Box<dyn ParametricSurface>)> {
    vec![
        ("lu", Box::new(ClosedSurface::new(Lu::stand_in()))),
        ("lu untwisted", Box::new(ClosedSurface::new(Lu::untwisted()))),
        ("sine", Box::new(ClosedSurface::new(Sine::published_ratio()))),
        ("gentle sine", Box::new(ClosedSurface::new(Sine::gentle()))),
        ("dong", Box::new(ClosedSurface::new(Dong::stand_in()))),
        ("camber", Box::new(camber(0.004))),
        ("straight camber", Box::new(camber(0.0))),
        ("sections", Box::new(SkinnedBlade::new(&sections()).expect("a blade"))),
        ("cui", Box::new(ClosedSurface::new(Cui::stand_in()))),
    ]
}

/// Central differences of fourth order: `(8 (f(h) - f(-h)) - (f(2h) - f(-2h))) / 12 h`.
fn difference(f: impl Fn(f64) -> Vector, h: f64) -> Vector {
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

#[test]
fn derivatives_normal_and_curvatures_agree_with_differences() {
    for (name, surface) in kinds() {
        let (domain, mut draw) = (surface.domain(), Draw(17));
        // Knots of the spline are down to 0.0005 apart.
        let part = if name == "sections" { 5e-6 } else { 1e-4 };
        let step = [domain.u, domain.v].map(|r| (r[1] - r[0]) * part);
        // Lines on which the curvature or its change jumps: differences across them see two surfaces.
        let spline = if name == "sections" { SkinnedBlade::new(&sections()).ok() } else { None };
        let breaks = spline.as_ref().map_or_else(|| surface.breaks(), |s| s.u_of_points().to_vec());
        let rims = spline.as_ref().map_or_else(Vec::new, |s| s.v_of_sections().to_vec());
        for _ in 0..10_000 {
            let mut u = draw.within(domain.u);
            let mut v = draw.within(domain.v);
            // On such lines one side is asked next to it.
            if let Some(line) = breaks.iter().find(|b| {
                let off = (u - **b).abs();
                off.min(domain.u[1] - domain.u[0] - off) < 3.0 * step[0]
            }) {
                u = line + 3.0 * step[0] * if draw.next() < 0.5 { -1.0 } else { 1.0 };
            }
            if let Some(line) = rims.iter().find(|b| (v - **b).abs() < 3.0 * step[1]) {
                let side = if *line <= 0.0 || (*line < 1.0 && draw.next() < 0.5) { 1.0 } else { -1.0 };
                v = line + 3.0 * step[1] * side;
            }
            let at = surface.local(u, v);
            let along_u = |pick: &dyn Fn(f64) -> Vector| difference(pick, step[0]);
            let along_v = |pick: &dyn Fn(f64) -> Vector| difference(pick, step[1]);
            let found = [
                (at.first[0], along_u(&|h| surface.local(u + h, v).point.coords)),
                (at.first[1], along_v(&|h| surface.local(u, v + h).point.coords)),
                (at.second[0], along_u(&|h| surface.local(u + h, v).first[0])),
                (at.second[1], along_v(&|h| surface.local(u, v + h).first[0])),
                (at.second[1], along_u(&|h| surface.local(u + h, v).first[1])),
                (at.second[2], along_v(&|h| surface.local(u, v + h).first[1])),
            ];
            for (k, (exact, rough)) in found.iter().enumerate() {
                // Relative to the derivative, and to how the place itself changes with the parameter where a
                // derivative passes zero.
                let lengths = [domain.u, domain.v].map(|r| r[1] - r[0]);
                let unit = [
                    lengths[0],
                    lengths[1],
                    lengths[0].powi(2),
                    lengths[0] * lengths[1],
                    lengths[0] * lengths[1],
                    lengths[1].powi(2),
                ][k];
                let size = exact.norm().max(10.0 / unit);
                assert!((exact - rough).norm() < 1e-6 * size, "{name} {k} at {u} {v}: {exact} {rough}");
            }
            let normal = at.first[0].cross(&at.first[1]).normalize();
            assert!((at.normal - normal).norm() < 1e-12 && (at.normal.norm() - 1.0).abs() < 1e-12, "{name} at {u} {v}");
            // Curvature along a direction: turn of the normal, -dn . d / |d|^2 with the sign of convexity
            // (Weingarten).
            let [k1, k2] = at.principal();
            for (a, b) in [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)] {
                let d = at.first[0] * (a * step[0]) + at.first[1] * (b * step[1]);
                let turn = difference(|h| surface.local(u + h * a * step[0], v + h * b * step[1]).normal, 1.0);
                let rough = turn.dot(&d) / d.norm_squared();
                let size = k1.0.abs().max(k2.0.abs()).max(1e-3);
                assert!((at.curvature_along(&d) - rough).abs() < 1e-6 * size, "{name} at {u} {v}: {rough}");
            }
        }
    }
}

#[test]
#[ignore = "nightly, 55 s"]
fn the_nearest_point_is_that_of_brute_force() {
    let (mut proved, mut asked) = (0_usize, 0_usize);
    for (name, surface) in kinds() {
        let (domain, mut draw) = (surface.domain(), Draw(5));
        let side = 400;
        let place = |r: [f64; 2], k: u32| r[0] + (r[1] - r[0]) * f64::from(k) / f64::from(side);
        let all: Vec<Point> = (0..=side)
            .flat_map(|i| (0..=side).map(move |j| (i, j)))
            .map(|(i, j)| surface.local(place(domain.u, i), place(domain.v, j)).point)
            .collect();
        for k in 0..120 {
            let [u, v] = [draw.within(domain.u), draw.within(domain.v)];
            let at = surface.local(u, v);
            let aside = Vector::new(draw.next() - 0.5, draw.next() - 0.5, draw.next() - 0.5);
            // On the surface, next to it inside and outside, far away and beyond the rims.
            let p = match k % 4 {
                0 => at.point,
                1 => at.point + at.normal * (draw.next() - 0.5),
                2 => at.point + aside * 10.0,
                _ => at.point + aside * 200.0,
            };
            let foot = surface.foot(&p);
            let [u, v] = foot.parameters;
            assert!(
                u >= domain.u[0] - 1e-12 && u <= domain.u[1] + 1e-12 && v >= domain.v[0] && v <= domain.v[1],
                "{name}"
            );
            let found = (surface.local(u, v).point - p).norm();
            assert!((found - foot.distance).abs() < 1e-12 * found.max(1.0), "{name} {k}");
            let brute = all.iter().map(|q| (q - p).norm()).fold(f64::MAX, f64::min);
            assert!(found <= brute + FOOT_ERROR_MM, "{name} {k}: {found} {brute}");
            if k % 4 == 0 {
                assert!(found < FOOT_ERROR_MM, "{name} {k}: {found}");
            }
            // Far away from a sharp edge a search may end without its proof, and says so; near the surface
            // none does.
            assert!(foot.error >= FOOT_ERROR_MM && (foot.error == FOOT_ERROR_MM || k % 4 == 3), "{name} {k}: {foot:?}");
            proved += usize::from(foot.error == FOOT_ERROR_MM);
            asked += 1;
        }
    }
    assert!(100 * proved > 85 * asked, "{proved} of {asked}");
}

/// A patch of a sphere of 50 mm, 60 degrees each way.
#[derive(Debug)]
struct Ball;

impl ClosedForm for Ball {
    fn domain(&self) -> Domain {
        Domain { u: [-0.5, 0.5], v: [-0.5, 0.5], u_closed: false }
    }
    fn place<T: Scalar>(&self, u: T, v: T) -> [T; 3] {
        let ((su, cu), (sv, cv)) = (u.sin_cos(), v.sin_cos());
        [(cu * cv).times(50.0), (su * cv).times(50.0), sv.times(50.0)]
    }
}

/// All points are equally near to the center: no search can rule them out, and it says how far it came.
#[test]
fn a_search_that_does_not_come_to_its_end_says_so() {
    let surface = ClosedSurface::new(Ball);
    let foot = surface.foot(&Point::origin());
    assert!((foot.distance - 50.0).abs() < 1e-9, "{foot:?}");
    assert!(foot.error > FOOT_ERROR_MM && foot.error < 1.0, "{foot:?}");
    let beside = surface.foot(&Point::new(20.0, 0.0, 0.0));
    assert!((beside.distance - 30.0).abs() < FOOT_ERROR_MM && beside.error == FOOT_ERROR_MM, "{beside:?}");
}

#[test]
fn a_blade_through_sections_is_the_one_they_were_taken_from() {
    let exact = ClosedSurface::new(Lu::stand_in());
    let skinned = SkinnedBlade::new(&sections()).expect("a blade");
    let (mut draw, mut worst) = (Draw(3), 0.0_f64);
    for _ in 0..2000 {
        let at = skinned.local(draw.next(), draw.next());
        let Foot { parameters: foot, distance, .. } = exact.foot(&at.point);
        assert!(exact.local(foot[0], foot[1]).normal.dot(&at.normal) > 0.999);
        worst = worst.max(distance);
    }
    // Points 0.7 mm apart on sides of 100 mm radius, 0.05 mm apart at edges of 0.1 mm; sections 12.5 mm
    // apart.
    assert!(worst < 1e-3, "{worst}");
    for (j, section) in sections().iter().enumerate() {
        for p in &section.points {
            assert!(skinned.foot(p).distance < FOOT_ERROR_MM, "section {j}");
        }
    }
}

/// A surface that nothing is known about without a search.
#[derive(Debug)]
struct Searched(Arc<dyn ParametricSurface>);

impl ParametricSurface for Searched {
    fn domain(&self) -> Domain {
        self.0.domain()
    }

    fn local(&self, u: f64, v: f64) -> Local {
        self.0.local(u, v)
    }

    fn nearest(&self, p: &Point) -> [f64; 2] {
        self.0.nearest(p)
    }

    fn breaks(&self) -> Vec<f64> {
        self.0.breaks()
    }
}

/// Platforms and ends that are nearer than all of the airfoil are given without its foot, and as they are
/// given with it.
#[test]
fn results_with_and_without_a_foot_agree() {
    let plate = Plate { fillet_radius: 3.0, thickness: 6.0, y: [-30.0, 30.0], z: [-30.0, 30.0] };
    let ends = [BladeEnd { x: 2.0, plate: Some(plate) }, BladeEnd { x: 97.0, plate: None }];
    let surfaces: [Arc<dyn ParametricSurface>; 2] =
        [Arc::new(ClosedSurface::new(Lu::stand_in())), Arc::new(SkinnedBlade::new(&sections()).expect("a blade"))];
    let mut draw = Draw(97);
    for surface in surfaces {
        for allowance in [0.0, 0.5] {
            let blade = BladeSolid::new(Arc::clone(&surface), ends, allowance).expect("a blade");
            let searched = BladeSolid::new(Arc::new(Searched(Arc::clone(&surface))), ends, allowance).expect("a blade");
            for k in 0..40 {
                // On and next to the platform's faces, in the fillet, beyond the tip, anywhere.
                let x = match k % 4 {
                    0 => draw.within([1.5, 3.0]),
                    1 => draw.within([-6.0, 8.0]),
                    2 => draw.within([94.0, 103.0]),
                    _ => draw.within([-20.0, 120.0]),
                };
                let p = Point::new(x, draw.within([-32.0, 32.0]), draw.within([-32.0, 32.0]));
                assert_eq!(blade.nearest(&p), searched.nearest(&p), "at {p}");
            }
        }
    }
}

#[test]
#[ignore = "nightly, 26 s"]
fn a_surface_is_beyond_what_is_nearer_than_its_foot_and_never_beyond_its_foot() {
    let mut draw = Draw(12);
    for (name, surface) in kinds() {
        let mut stated = 0;
        for _ in 0..20 {
            let p = Point::new(draw.within([-30.0, 130.0]), draw.within([-60.0, 60.0]), draw.within([-60.0, 60.0]));
            let distance = surface.foot(&p).distance;
            assert!(!surface.is_beyond(&p, distance + 1e-5), "{name}: {p} is {distance} from it");
            stated += usize::from(surface.is_beyond(&p, 0.5 * distance));
        }
        assert!(stated > 18 || name.contains("camber"), "{name}: half of the way is told of {stated} points in 20");
    }
}
