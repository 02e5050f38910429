//! Heights by inverse contact over random motions in five axes, against dense searches that share no code,
//! and the law that the height of a point does not depend on which other points are asked for.
//!
//! Corners visited: balls, bull noses, round inserts with rake about the axis and about the nose, barrels
//! with the arc's center far beyond the axis; contacts at the tip itself (an axis that meets the
//! surface) up to the flank; straight and helical edges of either hand; run-out of either sign, also such
//! that the arc crosses the axis; one to four teeth; both senses of the spindle; feeds from a fiftieth of a
//! millimeter a revolution to several; curved paths, a second pass backward, a tip at rest while the axis
//! turns, pieces without length and without time, single pieces of many revolutions and many pieces a
//! revolution.

use std::f64::consts::{FRAC_PI_2, TAU};

use proveout_geom::{Point, Vector};
use proveout_surface::topography::{
    Cut, CutterPiece, Edge, Lattice, Settings, Topography, heights_by_edges, heights_by_envelope,
};
use proveout_tool::{Cutter, Profile};

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

    fn one_of(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    fn yes(&mut self, share: f64) -> bool {
        self.next() < share
    }
}

fn cases(of: usize) -> usize {
    std::env::var("PROVEOUT_TOPOGRAPHY_CASES").ok().and_then(|c| c.parse().ok()).unwrap_or(of)
}

#[derive(Clone, Copy, Debug)]
struct Form {
    center_radius: f64,
    center_height: f64,
    radius: f64,
    corner: [f64; 2],
    /// Corner angles at which it may touch.
    touch: [f64; 2],
}

const FORMS: [Form; 4] = [
    Form { center_radius: 0.0, center_height: 3.0, radius: 3.0, corner: [0.0, FRAC_PI_2], touch: [0.0, 0.9] },
    Form { center_radius: 2.5, center_height: 1.5, radius: 1.5, corner: [0.0, FRAC_PI_2], touch: [0.0, 1.0] },
    Form { center_radius: 5.0, center_height: 4.0, radius: 4.0, corner: [-FRAC_PI_2, FRAC_PI_2], touch: [-0.1, 0.2] },
    Form { center_radius: -20.0, center_height: 5.0, radius: 26.0, corner: [1.35, 1.75], touch: [1.45, 1.65] },
];

fn turned(v: &Vector, u: &Vector, angle: f64) -> Vector {
    v * angle.cos() + u.cross(v) * angle.sin() + u * (u.dot(v) * (1.0 - angle.cos()))
}

fn turn_between(a: &Vector, b: &Vector) -> Vector {
    let c = a.cross(b);
    if c.norm() < 1e-14 { Vector::zeros() } else { c.normalize() * c.norm().atan2(a.dot(b)) }
}

/// A motion that touches z = 0 near the origin.
fn motion(n: &mut Numbers, form: &Form) -> Vec<CutterPiece> {
    // Upright on the surface in a sixth of the cases.
    let upright = form.touch[0] <= 0.0 && n.yes(0.17);
    let kappa = if upright { 0.0 } else { n.between(form.touch[0], form.touch[1]) };
    let heading = n.between(0.0, TAU);
    let (kappa_rate, heading_rate) =
        if n.yes(0.3) { (0.0, 0.0) } else { (n.between(-0.06, 0.06), n.between(-0.2, 0.2)) };
    let rate = TAU * n.between(20.0, 120.0) * if n.yes(0.5) { 1.0 } else { -1.0 };
    let a_revolution = 0.02 * 150.0_f64.powf(n.next());
    let feed = a_revolution * rate.abs() / TAU;
    let (side, bend) = (n.between(-0.25, 0.25), n.between(-0.1, 0.1));
    let count = 1 + n.one_of(12);
    let (mut nodes, mut time) = (Vec::new(), n.between(0.0, 100.0));
    let passes = 1 + n.one_of(2);
    for pass in 0..passes {
        for k in 0..=count {
            let s = -1.2 + 2.4 * f64::from(k as u32) / f64::from(count as u32);
            let s = if pass == 0 { s } else { -s };
            let (kappa, heading) = (kappa + kappa_rate * s, heading + heading_rate * s);
            let lean = Vector::new(heading.cos(), heading.sin(), 0.0);
            let axis = (Vector::z() * kappa.cos() + lean * kappa.sin()).normalize();
            // The meridian direction on the side of the surface.
            let down = lean * kappa.cos() - Vector::z() * kappa.sin();
            let lowest = axis * form.center_height + down * form.center_radius - Vector::z() * form.radius;
            let touch = Point::new(s, side + bend * s * s + 0.3 * f64::from(pass as u32), 0.0);
            nodes.push((touch - lowest, axis, pass));
        }
        if n.yes(0.3) {
            // The tip is at rest and the axis turns; then nothing at all.
            let (tip, axis, pass) = *nodes.last().expect("a node");
            let other = (axis + Vector::new(n.between(-0.05, 0.05), n.between(-0.05, 0.05), 0.0)).normalize();
            nodes.extend([(tip, other, pass), (tip, other, pass)]);
        }
    }
    let mut azimuth = n.between(0.0, TAU);
    let first = nodes[0].1;
    let mut x = if first.x.abs() < 0.7 { first.cross(&Vector::x()) } else { first.cross(&Vector::y()) }.normalize();
    let mut pieces = Vec::new();
    for w in nodes.windows(2) {
        let ((p, a, pass), (q, b, next)) = (w[0], w[1]);
        if pass != next {
            time += 0.5;
            azimuth = n.between(0.0, TAU);
        }
        let turn = turn_between(&a, &b);
        let (way, angle) = ((q - p).norm(), turn.norm());
        let duration = if pass != next { 0.2 } else { (way / feed).max(angle / 3.0) };
        let housing = [x, a.cross(&x), a];
        if pass == next {
            let motion = pieces.len() as u32;
            pieces.push(CutterPiece {
                time: [time, time + duration],
                tip: [p, q],
                housing,
                turn,
                azimuth,
                azimuth_rate: rate,
                motion,
            });
        }
        time += duration;
        azimuth += rate * duration;
        if angle > 0.0 {
            x = turned(&x, &(turn / angle), angle);
        }
        x = (x - b * x.dot(&b)).normalize();
    }
    pieces
}

fn edges(n: &mut Numbers, form: &Form) -> Vec<Edge> {
    let count = 1 + n.one_of(4);
    let lead = if n.yes(0.5) { 0.0 } else { n.between(-0.2, 0.2) };
    let nose_turn = if form.corner[0] < 0.0 && n.yes(0.5) { n.between(-0.3, 0.3) } else { 0.0 };
    let ahead = n.between(-0.3, 0.3);
    let off = if n.yes(0.2) { 0.0 } else { 0.012 };
    (0..count)
        .map(|k| Edge {
            center_radius: form.center_radius + n.between(-off, off),
            center_height: form.center_height + n.between(-0.4 * off, 0.4 * off),
            radius: form.radius,
            corner: form.corner,
            azimuth: TAU * k as f64 / count as f64 + ahead,
            lead,
            nose_turn,
        })
        .collect()
}

fn points(n: &mut Numbers, count: usize) -> (Vec<Point>, Vec<Vector>) {
    (0..count)
        .map(|_| {
            (
                Point::new(n.between(-0.5, 0.5), n.between(-0.35, 0.35), n.between(-0.002, 0.002)),
                Vector::new(n.between(-0.08, 0.08), n.between(-0.08, 0.08), 1.0).normalize(),
            )
        })
        .unzip()
}

struct Pose {
    tip: Point,
    frame: [Vector; 3],
    azimuth: f64,
}

fn pose(piece: &CutterPiece, time: f64) -> Pose {
    let duration = piece.time[1] - piece.time[0];
    let s = if duration > 0.0 { (time - piece.time[0]) / duration } else { 0.0 };
    let (u, angle) = (piece.turn.try_normalize(1e-14).unwrap_or_else(Vector::x), piece.turn.norm());
    Pose {
        tip: piece.tip[0] + (piece.tip[1] - piece.tip[0]) * s,
        frame: piece.housing.map(|v| turned(&v, &u, angle * s)),
        azimuth: piece.azimuth + piece.azimuth_rate * (time - piece.time[0]),
    }
}

/// Distance of a contact from the edge by its definition read forward.
fn off_the_edge(point: &Point, normal: &Vector, cut: &Cut, piece: &CutterPiece, edge: &Edge) -> f64 {
    let pose = pose(piece, cut.time);
    let q = point + normal * cut.height - pose.tip;
    let up = q.dot(&pose.frame[2]) - edge.center_height;
    let psi = pose.azimuth + edge.azimuth + (up + edge.radius) * edge.lead;
    let at = |a: f64| pose.frame[0] * a.cos() + pose.frame[1] * a.sin();
    let nose = at(psi) * edge.center_radius;
    let flat = q - pose.frame[2] * q.dot(&pose.frame[2]) - nose;
    let side = flat.dot(&at(psi + edge.nose_turn));
    let kappa = side.atan2(-up).clamp(edge.corner[0], edge.corner[1]);
    let on = nose
        + at(psi + edge.nose_turn) * (edge.radius * kappa.sin())
        + pose.frame[2] * (edge.center_height - edge.radius * kappa.cos());
    (on - q).norm()
}

/// What the dense search takes as on the arc, mm: the place on the normal runs so fast that rounding of the
/// time leaves that much. Its heights are wrong by up to this over the cosine between normal and edge.
const OFF: f64 = 1e-9;

/// Lowest contact over many times a revolution: the normal pierces the plane of the edge, whose azimuth
/// follows the height of the place, and the arc is met where the distance from it changes sign. Where that
/// place runs through the range of heights, the times are closer.
fn dense(point: &Point, normal: &Vector, edges: &[Edge], pieces: &[CutterPiece]) -> f64 {
    let mut best = f64::INFINITY;
    for piece in pieces {
        let duration = piece.time[1] - piece.time[0];
        let samples = (piece.azimuth_rate.abs() * duration / TAU * 400.0).ceil() as usize;
        for edge in edges {
            let at = |t: f64| -> (f64, f64, f64, f64) {
                let pose = pose(piece, piece.time[0] + t);
                let direction = |a: f64| pose.frame[0] * a.cos() + pose.frame[1] * a.sin();
                // Plane of the edge through the place at a height: its distance from that place, the height
                // at which the normal pierces it, and the place in it.
                let plane = |h: f64| {
                    let up = (point + normal * h - pose.tip).dot(&pose.frame[2]) - edge.center_height;
                    let psi = pose.azimuth + edge.azimuth + (up + edge.radius) * edge.lead;
                    let across = direction(psi + edge.nose_turn + FRAC_PI_2);
                    let nose = pose.tip + direction(psi) * edge.center_radius;
                    let side = (point + normal * h - nose).dot(&direction(psi + edge.nose_turn));
                    let off = (point + normal * h - nose).dot(&across);
                    (off, (nose - point).dot(&across) / normal.dot(&across), side, up)
                };
                let (mut a, mut b) = (-0.4, 0.4);
                let (low, high) = (plane(a).0, plane(b).0);
                let h = if edge.lead == 0.0 {
                    plane(0.0).1
                } else if low * high > 0.0 {
                    return (1.0, 1e9 * low.signum(), 0.0, 0.0);
                } else {
                    for _ in 0..60 {
                        let m = 0.5 * (a + b);
                        if plane(m).0 * low > 0.0 { a = m } else { b = m }
                    }
                    0.5 * (a + b)
                };
                let (_, _, side, up) = plane(h);
                (side.hypot(up) - edge.radius, h, side, up)
            };
            let mut look = |from: f64, to: f64, parts: usize| {
                let mut last = at(from);
                for i in 1..=parts {
                    let time = |i: usize| from + (to - from) * i as f64 / parts as f64;
                    let here = at(time(i));
                    if last.1.abs() < 0.3 && here.1.abs() < 0.3 && last.0 * here.0 <= 0.0 {
                        let (mut a, mut b) = (time(i - 1), time(i));
                        for _ in 0..50 {
                            let m = 0.5 * (a + b);
                            if at(m).0 * last.0 > 0.0 { a = m } else { b = m }
                        }
                        let (off, h, side, up) = at(a);
                        let kappa = side.atan2(-up);
                        if off.abs() < OFF && kappa >= edge.corner[0] && kappa <= edge.corner[1] {
                            best = best.min(h);
                        }
                    }
                    last = here;
                }
            };
            // The place on the normal runs through the range of heights within a small part of a revolution.
            let mut last = at(0.0);
            for i in 1..=samples {
                let time = |i: usize| duration * i as f64 / samples as f64;
                let here = at(time(i));
                if last.1.min(here.1) < 0.3 && last.1.max(here.1) > -0.3 {
                    look(time(i - 1), time(i), 200);
                }
                last = here;
            }
        }
    }
    best
}

const SETTINGS: Settings = Settings { max_height: 0.2 };

fn row(points: &[Point], normals: &[Vector]) -> Lattice {
    Lattice::new(points.len(), points.to_vec(), normals.to_vec()).expect("a row")
}

#[test]
#[expect(clippy::print_stdout, reason = "how many contacts were compared is what one wants to read")]
fn edges_leave_what_a_dense_search_finds_in_any_motion() {
    let mut n = Numbers(2026);
    let (mut equal, mut compared, mut short) = (0_usize, 0_usize, 0_usize);
    let cases = cases(6);
    for case in 0..cases {
        let form = FORMS[case % FORMS.len()];
        let pieces = motion(&mut n, &form);
        let edges = edges(&mut n, &form);
        let (mut points, normals) = points(&mut n, 3);
        if case % 5 == 0 {
            // On the path of the tip.
            points[1] = Point::new(pieces[0].tip[0].x * 0.3 + pieces[0].tip[1].x * 0.7, pieces[0].tip[0].y, 0.0);
        }
        let found = heights_by_edges(&row(&points, &normals), &edges, &pieces, &SETTINGS);
        for (i, (point, normal)) in points.iter().zip(&normals).enumerate() {
            let want = dense(point, normal, &edges, &pieces);
            let got = found.cuts[i];
            let height = got.map_or(f64::INFINITY, |c| c.height);
            if want > SETTINGS.max_height && got.is_none() {
                continue;
            }
            assert!(height < want + 3.0 * OFF, "case {case}, point {i}: {height} mm instead of {want} mm ({got:?})");
            let Some(cut) = got else { continue };
            let edge = &edges[cut.edge.expect("a tooth")];
            let off = off_the_edge(point, normal, &cut, &pieces[cut.motion as usize], edge);
            assert!(off < 1e-9, "case {case}, point {i}: {off} mm off the edge ({cut:?})");
            compared += 1;
            equal += usize::from((height - want).abs() < 3.0 * OFF);
            short += usize::from(height < want - 1e-6);
        }
    }
    println!("{compared} points cut, {equal} equal, {short} where the samples stepped over the contact");
    assert!(compared > cases, "only {compared} points were cut in {cases} cases");
    // The others are contacts that the samples step over.
    assert!(equal * 4 >= compared * 3, "{equal} of {compared} are equal");
}

/// The stated bound: two heights of the envelope of a turning piece, each a nanometer's thousandth off.
const STATED_MM: f64 = 2e-9;

fn same(a: Option<Cut>, b: Option<Cut>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a.height - b.height).abs() < STATED_MM,
        (None, None) => true,
        // At the largest height itself.
        (Some(c), None) | (None, Some(c)) => (c.height - SETTINGS.max_height).abs() < STATED_MM,
    }
}

/// Alone, in random parts of a row, in another order, and as a lattice of rows.
fn hold_in_any_company(
    n: &mut Numbers,
    what: &str,
    points: &[Point],
    normals: &[Vector],
    heights: impl Fn(&Lattice) -> Topography,
) -> usize {
    let alone: Vec<Option<Cut>> =
        points.iter().zip(normals).map(|(p, v)| heights(&row(&[*p], &[*v])).cuts[0]).collect();
    for round in 0..4 {
        let mut order: Vec<usize> = (0..points.len()).filter(|_| round == 0 || n.yes(0.6)).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, n.one_of(i + 1));
        }
        if order.is_empty() {
            continue;
        }
        let (p, v): (Vec<Point>, Vec<Vector>) = order.iter().map(|i| (points[*i], normals[*i])).unzip();
        let columns = if order.len().is_multiple_of(3) { 3 } else { order.len() };
        let lattice = Lattice::new(columns, p, v).expect("whole rows");
        let found = heights(&lattice);
        for (k, i) in order.iter().enumerate() {
            let (single, here) = (alone[*i], found.cuts[k]);
            assert!(same(single, here), "{what}, round {round}, point {i}: alone {single:?}, among {order:?} {here:?}");
        }
    }
    alone.iter().flatten().count()
}

#[test]
fn the_height_of_a_point_does_not_hang_on_the_others() {
    let mut n = Numbers(7);
    let (mut by_edges, mut by_envelope) = (0, 0);
    let cutters: Vec<Profile> = [Cutter::ball(6.0), Cutter::bull_nose(8.0, 1.5), Cutter::bull_nose(18.0, 4.0)]
        .into_iter()
        .map(|c| c.and_then(|c| c.bodies(12.0)).expect("a cutter").remove(0))
        .collect();
    for case in 0..cases(160) {
        let form = FORMS[case % FORMS.len()];
        let pieces = motion(&mut n, &form);
        let edges = edges(&mut n, &form);
        let (points, normals) = points(&mut n, 12);
        by_edges += hold_in_any_company(&mut n, &format!("edges {case}"), &points, &normals, |l| {
            heights_by_edges(l, &edges, &pieces, &SETTINGS)
        });
        if let Some(cutter) = cutters.get(case % FORMS.len()) {
            by_envelope += hold_in_any_company(&mut n, &format!("envelope {case}"), &points, &normals, |l| {
                heights_by_envelope(l, cutter, &pieces, &SETTINGS)
            });
        }
    }
    assert!(by_edges > 600 && by_envelope > 500, "{by_edges} and {by_envelope} points were cut");
}

/// A wall that the side of a cutter leaves, with a level far beyond the cutter: at that height a point has
/// the whole body beyond it.
#[test]
fn a_level_beyond_the_cutter_changes_nothing_and_ends() {
    let cutter = Cutter::bull_nose(8.0, 1.5).and_then(|c| c.bodies(12.0)).expect("a cutter").remove(0);
    for (tilt, turn) in [(0.0, 0.0), (0.0, 0.02), (0.1, 0.0), (0.1, 0.02)] {
        // The axis leans over the wall y = 0, the cutter on its far side; it moves along x.
        let z = Vector::new(0.0, f64::sin(tilt), f64::cos(tilt));
        let piece = |k: u32| {
            let (from, to) = (-4.0 + f64::from(k), -3.0 + f64::from(k));
            CutterPiece {
                time: [f64::from(k), f64::from(k) + 1.0],
                tip: [Point::new(from, 4.0, 0.0), Point::new(to, 4.0, 0.0)],
                housing: [Vector::x(), z.cross(&Vector::x()), z],
                turn: Vector::x() * turn,
                azimuth: 0.0,
                azimuth_rate: 50.0,
                motion: k,
            }
        };
        // Each piece starts its own turn: a join is a jump of the axis, on which no height depends.
        let pieces: Vec<CutterPiece> = (0..8).map(piece).collect();
        let (points, normals): (Vec<Point>, Vec<Vector>) = (0..60)
            .map(|i| (Point::new(-3.9 + 0.13 * f64::from(i), 0.0, 0.3 + 0.19 * f64::from(i)), Vector::y()))
            .unzip();
        let lattice = row(&points, &normals);
        let near = heights_by_envelope(&lattice, &cutter, &pieces, &Settings { max_height: 1.0 });
        for max_height in [5.0, 9.0, 40.0, 100.0] {
            let far = heights_by_envelope(&lattice, &cutter, &pieces, &Settings { max_height });
            for (i, (a, b)) in near.cuts.iter().zip(&far.cuts).enumerate() {
                if a.is_some() {
                    assert!(same(*a, *b), "lean {tilt}, turn {turn}, level {max_height}, point {i}: {a:?} {b:?}");
                }
            }
            assert!(far.cuts.iter().filter(|c| c.is_some()).count() >= 50, "lean {tilt}, turn {turn}: {far:?}");
        }
    }
}

#[test]
fn the_envelope_is_no_higher_than_the_cutter_at_any_time_and_touches_it() {
    let mut n = Numbers(99);
    let cutters = [Cutter::ball(6.0), Cutter::bull_nose(8.0, 1.5), Cutter::bull_nose(18.0, 4.0)];
    let mut compared = 0;
    for case in 0..cases(60) {
        let form = FORMS[case % 3];
        let cutter = cutters[case % 3].clone().and_then(|c| c.bodies(12.0)).expect("a cutter").remove(0);
        let pieces = motion(&mut n, &form);
        let (points, normals) = points(&mut n, 4);
        let found = heights_by_envelope(&row(&points, &normals), &cutter, &pieces, &SETTINGS);
        for ((point, normal), cut) in points.iter().zip(&normals).zip(&found.cuts) {
            let distance = |piece: &CutterPiece, time: f64, h: f64| {
                let pose = pose(piece, time);
                let q = point + normal * h - pose.tip;
                let z = q.dot(&pose.frame[2]);
                cutter.signed_distance([(q.norm_squared() - z * z).max(0.0).sqrt(), z])
            };
            let height = cut.map_or(SETTINGS.max_height, |c| c.height);
            if let Some(cut) = cut {
                let off = distance(&pieces[cut.motion as usize], cut.time, cut.height);
                assert!(off.abs() < 1e-9, "case {case}: {off} mm off the cutter");
                compared += 1;
            }
            for piece in &pieces {
                for i in 0..=400 {
                    let time = piece.time[0] + (piece.time[1] - piece.time[0]) * f64::from(i) / 400.0;
                    let d = distance(piece, time, height - 1e-9);
                    assert!(d > -1e-9, "case {case}: at {time} s the cutter is {} mm below {height} mm", -d);
                }
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn numbers_that_are_none_leave_nothing_and_end() {
    let mut n = Numbers(1);
    let form = FORMS[1];
    let pieces = motion(&mut n, &form);
    let edges = edges(&mut n, &form);
    let (points, normals) = points(&mut n, 6);
    let cutter = Cutter::bull_nose(8.0, 1.5).and_then(|c| c.bodies(12.0)).expect("a cutter").remove(0);
    let good = heights_by_edges(&row(&points, &normals), &edges, &pieces, &SETTINGS);
    assert!(good.uncut() < 6);
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300] {
        for field in 0..8 {
            let mut pieces = pieces.clone();
            for p in &mut pieces {
                match field {
                    0 => p.time[1] = bad,
                    1 => p.time[0] = bad,
                    2 => p.tip[0].x = bad,
                    3 => p.tip[1].z = bad,
                    4 => p.housing[1].y = bad,
                    5 => p.turn.x = bad,
                    6 => p.azimuth = bad,
                    _ => p.azimuth_rate = bad,
                }
            }
            let _ = heights_by_edges(&row(&points, &normals), &edges, &pieces, &SETTINGS);
            let _ = heights_by_envelope(&row(&points, &normals), &cutter, &pieces, &SETTINGS);
        }
        for field in 0..6 {
            let mut edges = edges.clone();
            match field {
                0 => edges[0].center_radius = bad,
                1 => edges[0].center_height = bad,
                2 => edges[0].radius = bad,
                3 => edges[0].corner = [bad, bad],
                4 => edges[0].azimuth = bad,
                _ => edges[0].lead = bad,
            }
            let _ = heights_by_edges(&row(&points, &normals), &edges, &pieces, &SETTINGS);
        }
        let (mut p, mut v) = (points.clone(), normals.clone());
        p[2].y = bad;
        v[3].z = bad;
        let found = heights_by_edges(&row(&p, &v), &edges, &pieces, &SETTINGS);
        assert!(found.cuts[2].is_none() && found.cuts[3].is_none());
        for i in [0, 1, 4, 5] {
            assert!(same(found.cuts[i], good.cuts[i]), "point {i}: {:?} instead of {:?}", found.cuts[i], good.cuts[i]);
        }
        let _ = heights_by_envelope(&row(&p, &v), &cutter, &pieces, &SETTINGS);
        let _ = heights_by_edges(&row(&points, &normals), &edges, &pieces, &Settings { max_height: bad });
    }
}
