//! Heights by inverse contact against a dense search that shares no code, closed forms, and laws.
//!
//! The oracle puts the plane of the edge first: at each of many times a revolution it pierces the normal with
//! the plane, and looks for a change of side of the arc in that plane. The library solves for time and height
//! together and walks from contact to contact. It must find nothing higher, and what it finds lower (the
//! samples step over short contacts) must lie on the edge by its definition. Corners visited: tilted and
//! turning housings, lengths from half a revolution to many, joints of pieces under the point, run-out of
//! either sign, balls whose run-out puts the arc's center beyond the axis, points next to the path, and both
//! senses of the spindle.

use std::f64::consts::{FRAC_PI_2, TAU};

use proveout_geom::{Point, Vector};
use proveout_surface::topography::{
    CutterPiece, Edge, Lattice, RunOut, Settings, TeethCorner, heights_by_edges, heights_by_envelope,
};
use proveout_tool::Cutter;

/// Numbers in [0, 1) by a fixed rule.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }
}

/// A bent path over the origin at z = 0 with a turning axis; the contact of the cutter runs near the z = 0
/// plane.
fn path(n: &mut Numbers, radius: f64, corner: f64, sense: f64) -> Vec<CutterPiece> {
    let (lean, roll) = (n.between(0.1, 0.5), n.between(-0.3, 0.3));
    let (lean_rate, roll_rate) = (n.between(-0.05, 0.05), n.between(-0.05, 0.05));
    let rate = sense * TAU * n.between(40.0, 90.0);
    let feed = n.between(8.0, 20.0);
    let side = n.between(-0.2, 0.2);
    let count = 10;
    let axis = |s: f64| {
        let (a, b) = (lean + lean_rate * s, roll + roll_rate * s);
        Vector::new(a.sin(), b.sin() * a.cos(), b.cos() * a.cos()).normalize()
    };
    // The nose circle touches z = 0: the tip that puts its lowest place there.
    let tip = |s: f64| {
        let t = axis(s);
        let across = (Vector::z() - t * t.z).normalize();
        let lowest = t * corner - across * (radius - corner) - Vector::z() * corner;
        Point::new(s, side + 0.03 * s * s, 0.0) - lowest
    };
    let mut pieces = Vec::new();
    let (mut time, mut azimuth) = (0.0, n.between(0.0, TAU));
    let mut x_dir = Vector::y().cross(&axis(-1.0)).normalize();
    for k in 0..count {
        let (s0, s1) = (-1.0 + 0.2 * f64::from(k), -0.8 + 0.2 * f64::from(k));
        let (z0, z1) = (axis(s0), axis(s1));
        let duration = (tip(s1) - tip(s0)).norm() / feed;
        let turn = {
            let c = z0.cross(&z1);
            if c.norm() < 1e-14 { Vector::zeros() } else { c.normalize() * c.norm().atan2(z0.dot(&z1)) }
        };
        let housing = [x_dir, z0.cross(&x_dir), z0];
        pieces.push(CutterPiece {
            time: [time, time + duration],
            tip: [tip(s0), tip(s1)],
            housing,
            turn,
            azimuth,
            azimuth_rate: rate,
            motion: k as u32,
        });
        time += duration;
        azimuth += rate * duration;
        // The housing goes on where it ended.
        let u = turn.try_normalize(1e-14).unwrap_or_else(Vector::x);
        let angle = turn.norm();
        x_dir = x_dir * angle.cos() + u.cross(&x_dir) * angle.sin() + u * (u.dot(&x_dir) * (1.0 - angle.cos()));
    }
    pieces
}

fn turned(v: &Vector, u: &Vector, angle: f64) -> Vector {
    v * angle.cos() + u.cross(v) * angle.sin() + u * (u.dot(v) * (1.0 - angle.cos()))
}

/// Distance of a contact from the edge at its time, by the definition of the edge read forward: radius c + r
/// sin kappa, height z - r cos kappa, azimuth by the height above the lowest point; the corner angle from the
/// height.
fn off_the_edge(
    point: &Point,
    normal: &Vector,
    cut: &proveout_surface::topography::Cut,
    piece: &CutterPiece,
    edge: &Edge,
) -> f64 {
    let s = (cut.time - piece.time[0]) / (piece.time[1] - piece.time[0]);
    let (u, angle) = (piece.turn.try_normalize(1e-14).unwrap_or_else(Vector::x), piece.turn.norm());
    let frame = piece.housing.map(|v| turned(&v, &u, angle * s));
    let tip = piece.tip[0] + (piece.tip[1] - piece.tip[0]) * s;
    let q = point + normal * cut.height - tip;
    let kappa = ((edge.center_height - q.dot(&frame[2])) / edge.radius).clamp(-1.0, 1.0).acos();
    let azimuth = piece.azimuth
        + piece.azimuth_rate * (cut.time - piece.time[0])
        + edge.azimuth
        + edge.radius * (1.0 - kappa.cos()) * edge.lead;
    let r = edge.center_radius + edge.radius * kappa.sin();
    let on = frame[0] * (r * azimuth.cos())
        + frame[1] * (r * azimuth.sin())
        + frame[2] * (edge.center_height - edge.radius * kappa.cos());
    (on - q).norm()
}

/// Lowest contact by a dense search over all pieces and edges.
fn dense(point: &Point, normal: &Vector, edges: &[Edge], pieces: &[CutterPiece]) -> f64 {
    let mut best = f64::INFINITY;
    for piece in pieces {
        let duration = piece.time[1] - piece.time[0];
        let samples = (piece.azimuth_rate.abs() * duration / TAU * 20_000.0).ceil() as usize;
        let (u, angle) = (piece.turn.try_normalize(1e-14).unwrap_or_else(Vector::x), piece.turn.norm());
        for edge in edges {
            // (distance from the arc, height, along) with the point in the plane of the edge.
            let at = |t: f64| {
                let s = t / duration;
                let frame = piece.housing.map(|v| turned(&v, &u, angle * s));
                let tip = piece.tip[0] + (piece.tip[1] - piece.tip[0]) * s;
                let psi = piece.azimuth + piece.azimuth_rate * t + edge.azimuth;
                let tooth = frame[0] * psi.cos() + frame[1] * psi.sin();
                let across = frame[1] * psi.cos() - frame[0] * psi.sin();
                let h = (tip - point).dot(&across) / normal.dot(&across);
                let q = point + normal * h - tip;
                let (side, up) = (q.dot(&tooth) - edge.center_radius, q.dot(&frame[2]) - edge.center_height);
                (side.hypot(up) - edge.radius, h, side, up)
            };
            let mut last = at(0.0);
            for i in 1..=samples {
                let here = at(duration * i as f64 / samples as f64);
                if last.1.abs() < 0.3 && here.1.abs() < 0.3 && last.0 * here.0 <= 0.0 {
                    let (mut a, mut b) =
                        (duration * (i - 1) as f64 / samples as f64, duration * i as f64 / samples as f64);
                    for _ in 0..60 {
                        let m = 0.5 * (a + b);
                        if at(m).0 * last.0 > 0.0 { a = m } else { b = m }
                    }
                    let (_, h, side, up) = at(a);
                    let kappa = side.atan2(-up);
                    if kappa >= edge.corner[0] && kappa <= edge.corner[1] {
                        best = best.min(h);
                    }
                }
                last = here;
            }
        }
    }
    best
}

#[test]
fn edges_leave_what_a_dense_search_finds() {
    let mut n = Numbers(11);
    let cases: usize = std::env::var("PROVEOUT_TOPOGRAPHY_CASES").ok().and_then(|c| c.parse().ok()).unwrap_or(8);
    let (mut equal, mut compared) = (0, 0);
    for case in 0..cases {
        let ball = case % 2 == 0;
        let (radius, corner) = if ball { (3.0, 3.0) } else { (4.0, 1.5) };
        let sense = if case % 3 == 0 { 1.0 } else { -1.0 };
        let pieces = path(&mut n, radius, corner, sense);
        let run_out: Vec<RunOut> = (0..2 + case % 3)
            .map(|_| RunOut { radial: n.between(-0.01, 0.01), axial: n.between(-0.004, 0.004) })
            .collect();
        let edges = TeethCorner { radius, corner_radius: corner, corner: [0.0, FRAC_PI_2], helix: 0.0 }.edges(&run_out);
        let points: Vec<Point> =
            (0..3).map(|_| Point::new(n.between(-0.5, 0.5), n.between(-0.3, 0.3), n.between(-0.002, 0.002))).collect();
        let normals = vec![Vector::new(n.between(-0.1, 0.1), n.between(-0.1, 0.1), 1.0).normalize(); points.len()];
        // As one row, so that each has a neighbor to follow, and alone.
        let row = Lattice::new(points.len(), points.clone(), normals.clone()).expect("a row");
        let settings = Settings { max_height: 0.3 };
        let found = heights_by_edges(&row, &edges, &pieces, &settings);
        for (i, (point, normal)) in points.iter().zip(&normals).enumerate() {
            let alone = Lattice::new(1, vec![*point], vec![*normal]).expect("a point");
            let single = heights_by_edges(&alone, &edges, &pieces, &settings).cuts[0];
            let got = found.cuts[i];
            assert_eq!(got.is_some(), single.is_some(), "case {case}, point {i}");
            let want = dense(point, normal, &edges, &pieces);
            let height = got.map_or(f64::INFINITY, |c| c.height);
            assert!(
                (single.map_or(f64::INFINITY, |c| c.height) - height).abs() < 1e-11 || got.is_none(),
                "case {case}, point {i}: alone {single:?}, in a row {got:?}"
            );
            if want.is_finite() || got.is_some() {
                assert!(height < want + 1e-9, "case {case}, point {i}: {height} mm instead of {want} mm ({got:?})");
                // A contact that the samples stepped over must lie on the edge all the same.
                let cut = got.expect("cut, since nothing is above infinity");
                let off =
                    off_the_edge(point, normal, &cut, &pieces[cut.motion as usize], &edges[cut.edge.expect("a tooth")]);
                assert!(off < 1e-9, "case {case}, point {i}: {off} mm off the edge");
                equal += usize::from((height - want).abs() < 1e-9);
                compared += 1;
            }
        }
    }
    assert!(compared > cases, "only {compared} points were cut");
    assert!(equal * 10 >= compared * 9, "{equal} of {compared} are equal");
}

#[test]
fn a_contact_with_helix_lies_on_the_edge() {
    let mut n = Numbers(5);
    for case in 0..20 {
        let (radius, corner) = (4.0, 1.5);
        let pieces = path(&mut n, radius, corner, -1.0);
        let helix = n.between(-0.6, 0.6);
        let run_out = [RunOut { radial: 0.004, axial: -0.002 }, RunOut { radial: -0.003, axial: 0.001 }];
        let edges = TeethCorner { radius, corner_radius: corner, corner: [0.0, FRAC_PI_2], helix }.edges(&run_out);
        let point = Point::new(n.between(-0.3, 0.3), n.between(-0.2, 0.2), 0.0);
        let lattice = Lattice::new(1, vec![point], vec![Vector::z()]).expect("a point");
        let found = heights_by_edges(&lattice, &edges, &pieces, &Settings { max_height: 0.3 });
        let cut = found.cuts[0].expect("cut");
        let k = cut.edge.expect("a tooth");
        // From the catalogue's numbers, not from those that the search uses.
        let by_hand = Edge {
            center_radius: radius - corner + run_out[k].radial,
            center_height: corner + run_out[k].axial,
            radius: corner,
            corner: [0.0, FRAC_PI_2],
            azimuth: TAU * k as f64 / 2.0,
            lead: helix.tan() / radius,
            nose_turn: 0.0,
        };
        let off = off_the_edge(&point, &Vector::z(), &cut, &pieces[cut.motion as usize], &by_hand);
        assert!(off < 1e-9, "case {case}: {off} mm off");
    }
}

#[test]
fn a_ball_along_straight_passes_leaves_its_closed_form() {
    // Passes along x at pitch p: height R - sqrt(R^2 - d^2) at distance d from the nearest one.
    let (radius, pitch) = (3.0, 0.4);
    let bodies = Cutter::ball(2.0 * radius).and_then(|c| c.bodies(12.0)).expect("a ball");
    let mut pieces = Vec::new();
    for pass in -4..=4 {
        for k in 0..8 {
            let (x, y) = (-2.0 + 0.5 * f64::from(k), pitch * f64::from(pass));
            let time = f64::from(pass + 4) * 10.0 + f64::from(k) * 0.05;
            pieces.push(CutterPiece {
                time: [time, time + 0.05],
                tip: [Point::new(x, y, 0.0), Point::new(x + 0.5, y, 0.0)],
                housing: [Vector::x(), Vector::y(), Vector::z()],
                turn: Vector::zeros(),
                azimuth: 0.0,
                azimuth_rate: -500.0,
                motion: 0,
            });
        }
    }
    let lattice = Lattice::plane(Point::new(-0.5, -0.5, 0.0), Vector::x(), Vector::y(), [0.01, 0.01], 101, 101)
        .expect("a lattice");
    let found = heights_by_envelope(&lattice, &bodies[0], &pieces, &Settings { max_height: 0.2 });
    for (p, cut) in lattice.points().iter().zip(&found.cuts) {
        let d = p.y - (p.y / pitch).round() * pitch;
        let want = radius - (radius * radius - d * d).sqrt();
        let got = cut.expect("cut").height;
        assert!((got - want).abs() < 1e-12, "at {p}: {got} instead of {want}");
    }
    assert_eq!(found.again, 0);
}

#[test]
fn the_same_bytes_at_any_number_of_threads_and_nothing_where_nothing_cuts() {
    let mut n = Numbers(3);
    let pieces = path(&mut n, 3.0, 3.0, -1.0);
    let edges = TeethCorner { radius: 3.0, corner_radius: 3.0, corner: [0.0, FRAC_PI_2], helix: 0.3 }
        .edges(&[RunOut::default(); 2]);
    let lattice = Lattice::plane(Point::new(-0.4, -0.4, 0.0), Vector::x(), Vector::y(), [0.008, 0.008], 101, 101)
        .expect("a lattice");
    let settings = Settings { max_height: 0.3 };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| heights_by_edges(&lattice, &edges, &pieces, &settings))
    };
    let (one, two) = (run(1), run(2));
    let bits =
        |t: &proveout_surface::topography::Topography| t.heights().iter().map(|h| h.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&one), bits(&two));
    assert_eq!(one.uncut(), 0);
    // Far away, without teeth, without motion, with a spindle at rest.
    let far =
        Lattice::plane(Point::new(50.0, 0.0, 0.0), Vector::x(), Vector::y(), [0.1, 0.1], 5, 5).expect("a lattice");
    assert_eq!(heights_by_edges(&far, &edges, &pieces, &settings).uncut(), 25);
    assert_eq!(heights_by_edges(&lattice, &[], &pieces, &settings).uncut(), 101 * 101);
    assert_eq!(heights_by_edges(&lattice, &edges, &[], &settings).uncut(), 101 * 101);
    let still: Vec<CutterPiece> = pieces.iter().map(|p| CutterPiece { azimuth_rate: 0.0, ..*p }).collect();
    assert_eq!(heights_by_edges(&lattice, &edges, &still, &settings).uncut(), 101 * 101);
}
