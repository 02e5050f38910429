//! Gouges and excesses put into perfect five-axis parts: which are found, which are invented, and how well
//! their depth is known.
//!
//! Parts: plane, convex and concave cylinder, sphere, each in a random pose in its stock, finished by a
//! leaning ball whose axis turns along every pass. Faults sit on nine sites of a part, one in three left
//! alone: short dips of a ball with an axis of its own (gouges), and stretches of passes that are lifted by a
//! smooth bump (excesses). They are 0.1 to 3 cells deep and at least two cells wide at the face. What is true
//! is found without the library's search: the depth of a ball is its radius less the distance of its center
//! from the design, largest over a dense walk along its path; the height of an excess is the largest over a
//! dense lattice of the lowest entry of the normal into the balls of all passes near, in closed form for a
//! straight piece.
//!
//! Corners visited: dips at the lowest depth and the largest, narrowest grooves, bumps of the least width,
//! faults next to the border of the judged region, parts with the design along the rays (poses of zero turn),
//! sites without fault.
//!
//! 4 parts by default, with some 25 faults; `PROVEOUT_RECALL=175` for the table of at least 1,000.
#![allow(clippy::print_stdout, reason = "the table is what is asked for")]

use std::f64::consts::PI;

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_surface::{
    Area, AreaPart, Areas, DesignSurface, DeviationSettings, Judged, NearestOnDesign, Refine, Seed, Side, Starts,
    Survey, ThinFins, Worst, refined,
    topography::{PathPiece, SweptPath},
};
use proveout_tool::{Cutter, Profile};

const CELL: f64 = 0.125;
/// Radius of the finishing ball, mm, and its step: scallops of 3.3 micrometers on a plane, 4 on the convex
/// parts.
const BALL: f64 = 3.0;
const STEP: f64 = 0.28;
/// What counts as a fault, mm: a twelfth of a cell.
const LIMIT: f64 = 0.01;
/// Half of the judged square, mm, and distance of the sites.
const HALF: f64 = 4.5;
const SITE: f64 = 2.9;
/// Depth of the shallowest and of the deepest fault, in cells.
const DEPTHS: [f64; 2] = [0.1, 3.0];

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

/// A sphere, a cylinder along `along`, or a plane; positive curvature is convex.
#[derive(Clone, Copy)]
struct Design {
    up: Vector,
    along: Vector,
    curvature: f64,
    round: bool,
}

impl Design {
    fn left(&self) -> Vector {
        self.up.cross(&self.along)
    }

    /// Signed distance and outward normal.
    fn measure(&self, p: &Point) -> (f64, Vector) {
        if self.curvature == 0.0 {
            return (p.coords.dot(&self.up), self.up);
        }
        let out = p.coords + self.up / self.curvature;
        let out = if self.round { out } else { out - self.along * out.dot(&self.along) };
        let sign = self.curvature.signum();
        (sign * out.norm() - 1.0 / self.curvature, out.normalize() * sign)
    }

    /// The point of the design over (s, t) of its tangent plane at the origin.
    fn at(&self, s: f64, t: f64) -> (Point, Vector) {
        let flat = Point::from(self.left() * s + self.along * t);
        let (distance, normal) = self.measure(&flat);
        (flat - normal * distance, normal)
    }
}

impl DesignSurface for Design {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let (distance, normal) = self.measure(p);
        (distance.abs() <= range).then_some(NearestOnDesign { distance, normal })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Gouge,
    Excess,
}

struct Fault {
    kind: Kind,
    site: [f64; 2],
    /// What is true, mm.
    depth: f64,
}

/// A motion of a ball: centers at both ends, with axes.
#[derive(Clone, Copy)]
struct Stroke {
    center: [Point; 2],
    axis: [Vector; 2],
    radius: f64,
}

struct Part {
    design: Design,
    strokes: Vec<Stroke>,
    faults: Vec<Fault>,
    free_sites: usize,
}

fn with_tilt(n: &mut Numbers, normal: &Vector, most: f64) -> Vector {
    let turn = n.between(0.0, 2.0 * PI);
    let lean = n.between(0.0, most);
    let least = if normal.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let u = normal.cross(&least).normalize();
    let v = normal.cross(&u);
    (normal * lean.cos() + (u * turn.cos() + v * turn.sin()) * lean.sin()).normalize()
}

fn design(n: &mut Numbers, kind: usize, posed: bool) -> Design {
    let mut up = Vector::z();
    let mut along = Vector::x();
    if posed {
        up = with_tilt(n, &Vector::z(), 0.7);
        let turn = n.between(0.0, 2.0 * PI);
        let first = up.cross(&Vector::new(turn.cos(), turn.sin(), 0.3)).normalize();
        along = first;
    }
    let (curvature, round) = match kind {
        0 => (0.0, false),
        1 => (n.between(0.02, 0.08), false),
        2 => (-n.between(0.02, 0.08), false),
        _ => (n.between(0.02, 0.06), true),
    };
    Design { up, along, curvature, round }
}

/// Height that passes are lifted by at a place: the bumps of all excesses.
fn lift(bumps: &[([f64; 2], f64, f64)], s: f64, t: f64) -> f64 {
    bumps
        .iter()
        .map(|([a, b], radius, height)| {
            let r = (s - a).hypot(t - b) / radius;
            if r >= 1.0 { 0.0 } else { height * (0.5 * (1.0 + (PI * r).cos())) }
        })
        .sum()
}

fn part(n: &mut Numbers, index: usize) -> Part {
    let design = design(n, index % 4, !index.is_multiple_of(3));
    let mut sites = Vec::new();
    let mut free_sites = 0;
    let mut bumps = Vec::new();
    for i in -1..=1 {
        for j in -1..=1 {
            let site = [f64::from(i) * SITE + n.between(-0.2, 0.2), f64::from(j) * SITE + n.between(-0.2, 0.2)];
            // As many shallow ones as deep ones; now and then the ends of the range.
            let share = match (n.next() * 16.0) as u32 {
                0 => 0.0,
                1 => 1.0,
                _ => n.next(),
            };
            let depth = CELL * (DEPTHS[0].ln() + share * (DEPTHS[1] / DEPTHS[0]).ln()).exp();
            match (n.next() * 3.0) as u32 {
                0 => sites.push((Kind::Gouge, site, depth)),
                1 => {
                    // Wide enough that the step of the passes follows it: two cells at least at half its
                    // height.
                    let radius = n.between(1.1, 1.4);
                    bumps.push((site, radius, depth));
                    sites.push((Kind::Excess, site, depth));
                }
                _ => free_sites += 1,
            }
        }
    }
    let mut strokes = Vec::new();
    let rows = (2.0 * (HALF + 1.0) / STEP).ceil() as i32;
    let pieces = 48;
    let (lean, roll) = (n.between(0.0, 0.3), n.between(-0.3, 0.3));
    for row in 0..=rows {
        let s = -HALF - 1.0 + STEP * f64::from(row);
        let at = |k: i32| {
            let t = (HALF + 1.5) * (2.0 * f64::from(k) / f64::from(pieces) - 1.0);
            let (point, normal) = design.at(s, t);
            let center = point + normal * (BALL + lift(&bumps, s, t));
            let axis = (normal + design.along * (lean + 0.04 * t) + design.left() * (roll + 0.02 * s)).normalize();
            (center, axis)
        };
        for k in 0..pieces {
            let (a, b) = (at(k), at(k + 1));
            strokes.push(Stroke { center: [a.0, b.0], axis: [a.1, b.1], radius: BALL });
        }
    }
    let mut faults = Vec::new();
    for (kind, site, depth) in sites {
        match kind {
            Kind::Gouge => {
                // A groove two cells wide at the face has (c^2 + d^2) / 2 d as its least radius.
                let least = (CELL * CELL + depth * depth) / (2.0 * depth);
                let radius = n.between(least.max(0.35), least.max(0.35) + 1.0).min(4.0_f64.max(least));
                let turn = n.between(0.0, 2.0 * PI);
                let half = 0.5 * n.between(2.0 * CELL, 1.2);
                let way = [half * turn.cos(), half * turn.sin()];
                let end = |sign: f64| design.at(site[0] + sign * way[0], site[1] + sign * way[1]);
                let ((from, up), (to, over)) = (end(-1.0), end(1.0));
                // One end is deeper than the other.
                let other = depth * n.between(0.3, 1.0);
                let center = [from + up * (radius - depth), to + over * (radius - other)];
                let axis = [with_tilt(n, &up, 0.5), with_tilt(n, &over, 0.5)];
                let above = [center[0] + up * (depth + 1.0), center[1] + over * (other + 1.0)];
                strokes.push(Stroke { center: [above[0], center[0]], axis: [axis[0]; 2], radius });
                strokes.push(Stroke { center, axis, radius });
                strokes.push(Stroke { center: [center[1], above[1]], axis: [axis[1]; 2], radius });
                // The tip runs straight and the axis on the great circle: the center follows both.
                let angle = axis[0].cross(&axis[1]).norm().atan2(axis[0].dot(&axis[1]));
                let deepest = (0..=20_000).map(|k| {
                    let t = f64::from(k) / 20_000.0;
                    let share = |x: f64| if angle > 1e-9 { (x * angle).sin() / angle.sin() } else { x };
                    let turned = axis[0] * share(1.0 - t) + axis[1] * share(t);
                    let tip = |e: usize| center[e] - axis[e] * radius;
                    let c = tip(0) + (tip(1) - tip(0)) * t + turned * radius;
                    radius - design.measure(&c).0
                });
                faults.push(Fault { kind, site, depth: deepest.fold(f64::NEG_INFINITY, f64::max) });
            }
            Kind::Excess => {
                let reach = bumps.iter().find(|b| b.0 == site).map_or(0.0, |b| b.1);
                faults.push(Fault { kind, site, depth: highest(&design, &strokes, site, reach) });
            }
        }
    }
    Part { design, strokes, faults, free_sites }
}

/// Where a line enters a ball, from below; none next to it.
fn entry(point: &Point, normal: &Vector, center: &Point, radius: f64) -> f64 {
    let d = center - point;
    let along = d.dot(normal);
    let aside = d.norm_squared() - along * along;
    if aside >= radius * radius { f64::INFINITY } else { along - (radius * radius - aside).sqrt() }
}

/// The lowest entry into the balls of a stroke, in closed form: with the center at along a(t) and aside w(t)
/// of the line, both linear, a - sqrt(R^2 - w^2) is lowest where w lies tau = -(a'/|w'|) sqrt(D / (1 +
/// (a'/|w'|)^2)) along w', D = R^2 less the part of w across it squared.
fn lowest_entry(point: &Point, normal: &Vector, stroke: &Stroke) -> f64 {
    let split = |v: Vector| {
        let along = v.dot(normal);
        (along, v - normal * along)
    };
    let (_, w0) = split(stroke.center[0] - point);
    let (a1, w1) = split(stroke.center[1] - stroke.center[0]);
    let at = |t: f64| {
        let center = stroke.center[0] + (stroke.center[1] - stroke.center[0]) * t;
        entry(point, normal, &center, stroke.radius)
    };
    let m = w1.norm();
    let mut best = at(0.0).min(at(1.0));
    if m > 1e-12 {
        let tau0 = w0.dot(&w1) / m;
        let across = w0.norm_squared() - tau0 * tau0;
        let d = stroke.radius * stroke.radius - across;
        if d > 0.0 {
            let slope = a1 / m;
            let t = (-slope * (d / (1.0 + slope * slope)).sqrt() - tau0) / m;
            best = best.min(at(t.clamp(0.0, 1.0)));
        }
    }
    best
}

/// The highest place within a bump: a dense lattice, then finer ones about the five best places.
fn highest(design: &Design, strokes: &[Stroke], [a, b]: [f64; 2], reach: f64) -> f64 {
    let middle = design.at(a, b).0;
    let near: Vec<&Stroke> = strokes
        .iter()
        .filter(|s| (s.center[0] - middle).norm().min((s.center[1] - middle).norm()) < BALL + reach + 0.4)
        .collect();
    let look = |s: f64, t: f64| {
        let (point, normal) = design.at(s, t);
        near.iter().map(|k| lowest_entry(&point, &normal, k)).fold(f64::INFINITY, f64::min)
    };
    let mut places: Vec<(f64, f64, f64)> = Vec::new();
    let steps = 24;
    for i in -steps..=steps {
        for j in -steps..=steps {
            let (s, t) =
                (a + 0.5 * reach * f64::from(i) / f64::from(steps), b + 0.5 * reach * f64::from(j) / f64::from(steps));
            places.push((look(s, t), s, t));
        }
    }
    places.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best = places[0].0;
    for start in places.iter().take(5) {
        let (mut top, mut step) = (*start, 0.5 * reach / f64::from(steps));
        while step > 2e-5 {
            let from = top;
            for i in -3..=3 {
                for j in -3..=3 {
                    let (s, t) = (from.1 + step * f64::from(i) / 3.0, from.2 + step * f64::from(j) / 3.0);
                    let h = look(s, t);
                    if h > top.0 {
                        top = (h, s, t);
                    }
                }
            }
            if top.0 <= from.0 {
                step *= 0.5;
            }
        }
        best = best.max(top.0);
    }
    best
}

struct Seen {
    kind: Kind,
    area: Area,
    worst: Option<Worst>,
}

/// Cuts the part and looks at it as a run does.
fn look(part: &Part) -> Vec<Seen> {
    let mut radii: Vec<f64> = Vec::new();
    let mut pieces = Vec::new();
    for s in &part.strokes {
        let cutter = radii.iter().position(|r| *r == s.radius).unwrap_or_else(|| {
            radii.push(s.radius);
            radii.len() - 1
        });
        let pose = |k: usize| ToolPose { tip: s.center[k] - s.axis[k] * s.radius, axis: s.axis[k] };
        pieces.push(PathPiece { from: pose(0), to: pose(1), cutter: Some(cutter as u32) });
    }
    let body = |r: &f64| -> Vec<Profile> { Cutter::ball(2.0 * r).and_then(|c| c.bodies(r + 8.0)).expect("a ball") };
    let cutters: Vec<Vec<Profile>> = radii.iter().map(body).collect();
    // Room for the judged square however it is turned, by 0.7 rad at most from the z axis.
    let size = Vector::new(1.42 * HALF + 0.8, 1.42 * HALF + 0.8, HALF + 2.0);
    let bounds = Aabb { min: Point::from(-size), max: Point::from(size) };
    let mut stock = TriDexel::from_box(&bounds, CELL, 1 << 30).expect("a stock");
    let items: Vec<SweepItem<'_>> = pieces
        .iter()
        .enumerate()
        .map(|(k, p)| SweepItem {
            id: k as u32,
            body: &cutters[p.cutter.expect("cuts") as usize][0],
            action: Action::Remove,
            motion: SweepMotion { from: p.from, to: p.to },
        })
        .collect();
    stock.sweep(&items);
    let path = SweptPath::new(pieces, &cutters);
    let design = part.design;
    let judged = |p: &Point| {
        let (s, t) = (p.coords.dot(&design.left()), p.coords.dot(&design.along));
        s.abs() < HALF && t.abs() < HALF && design.measure(p).0.abs() < 1.5
    };
    let settings =
        DeviationSettings { range: 1.5, region: None, only_cut: false, tolerance_floor: 1e-3, cells: stock.cells_mm() };
    let mut sides =
        [Areas::new(vec![AreaPart { corner: bounds.min, cells: stock.cells_mm(), window: None }], LIMIT), {
            Areas::new(vec![AreaPart { corner: bounds.min, cells: stock.cells_mm(), window: None }], LIMIT)
        }];
    let survey = Survey {
        stock: &stock,
        design: Some(&design),
        solid: None,
        settings,
        fins: ThinFins::default(),
        window: None,
        finer: &[],
    };
    let done: Result<(), ()> = survey.run(|band| {
        for (sample, found) in band.points.iter().zip(&band.judged) {
            if let Judged::Counts { deviation, weight } = *found
                && judged(&sample.point)
                && deviation.abs() > LIMIT
            {
                let seed = Seed {
                    depth: deviation.abs(),
                    point: sample.point,
                    made_by: sample.made_by,
                    cut_area: weight,
                    ..Seed::default()
                };
                sides[usize::from(deviation > 0.0)].add(0, &seed);
            }
        }
        Ok(())
    });
    done.expect("nothing refuses");
    let on = Refine { path: &path, design: &design, bounds, region: None, cell: CELL };
    let [missing, left] = sides;
    let mut seen = Vec::new();
    for (kind, side, areas) in [(Kind::Gouge, Side::Missing, missing), (Kind::Excess, Side::Left, left)] {
        let areas: Vec<(Area, Starts)> = areas.finish_with_starts();
        seen.extend(areas.into_iter().map(|(area, starts)| Seen { kind, worst: refined(&on, side, &starts), area }));
    }
    seen
}

#[derive(Default, Clone, Copy)]
struct Row {
    faults: u32,
    found: u32,
    /// Largest error of the depth, of the points and refined, mm.
    by_points: f64,
    by_refined: f64,
}

#[test]
fn faults_from_half_a_cell_on_are_found_and_none_is_invented() {
    let parts: usize = std::env::var("PROVEOUT_RECALL").ok().and_then(|v| v.parse().ok()).unwrap_or(4);
    let mut n = Numbers(20_221_103);
    // Up to 0.15, 0.25, 0.5, 1, 2, 3 cells.
    let bounds = [0.15, 0.25, 0.5, 1.0, 2.0, 3.5];
    let mut table = [[Row::default(); 6]; 2];
    let (mut invented, mut free_sites, mut wrong) = (Vec::new(), 0, Vec::new());
    for index in 0..parts {
        let part = part(&mut n, index);
        free_sites += part.free_sites;
        let mut seen = look(&part);
        for fault in &part.faults {
            let at = part.design.at(fault.site[0], fault.site[1]).0;
            let cells = fault.depth / CELL;
            let row = bounds.iter().position(|b| cells <= *b).expect("within the range");
            let row = &mut table[usize::from(fault.kind == Kind::Excess)][row];
            row.faults += 1;
            let of_fault = |s: &Seen| s.kind == fault.kind && (s.area.point - at).norm() < 0.5 * SITE;
            let mut depths: Vec<(f64, f64)> = Vec::new();
            seen.retain(|s| {
                if of_fault(s) {
                    depths.push((s.area.depth, s.worst.map_or(s.area.depth, |w| w.depth)));
                    return false;
                }
                true
            });
            if depths.is_empty() {
                if cells >= 0.5 {
                    wrong.push(format!("part {index}: {:?} of {cells:.3} cells is missed", fault.kind));
                }
                continue;
            }
            row.found += 1;
            let most = depths.iter().fold((0.0_f64, 0.0_f64), |a, d| (a.0.max(d.0), a.1.max(d.1)));
            row.by_points = row.by_points.max((most.0 - fault.depth).abs());
            row.by_refined = row.by_refined.max((most.1 - fault.depth).abs());
            if (most.1 - fault.depth).abs() > 2e-3 {
                wrong.push(format!(
                    "part {index}: {:?} at {:?} is {:.5} deep, told {:.5}, refined {:.5}",
                    fault.kind, fault.site, fault.depth, most.0, most.1
                ));
            }
        }
        invented.extend(seen.iter().map(|s| format!("part {index}: {:?} {:?}", s.kind, s.area)));
    }
    println!(
        "cells of {CELL} mm, limit {LIMIT} mm, {parts} parts, {free_sites} sites without fault, {} invented",
        invented.len()
    );
    println!("  kind    depth, cells   faults  found   share   error of points, um  refined, um");
    let mut all = 0;
    for (kind, rows) in [("gouge", table[0]), ("excess", table[1])] {
        let mut from = DEPTHS[0];
        for (to, row) in bounds.iter().zip(rows) {
            let share = 100.0 * f64::from(row.found) / f64::from(row.faults.max(1));
            let (points, refined) = (1e3 * row.by_points, 1e3 * row.by_refined);
            println!(
                "  {kind:7} {from:4} to {to:4}  {:7} {:6} {share:6.1} % {points:14.2} {refined:17.3}",
                row.faults, row.found
            );
            all += row.faults;
            from = *to;
        }
    }
    assert!(invented.is_empty(), "{invented:#?}");
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(all as usize > 4 * parts && free_sites > parts, "{all} faults, {free_sites} sites without");
}

/// A block, from -5 to 5 mm along X and Y, below Z = 0.
struct Slab;

impl DesignSurface for Slab {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        // Faces by their outward normals and distances (Quilez' box, with the nearest face inside).
        let off = [p.x.abs() - 5.0, p.y.abs() - 5.0, p.z];
        let signs = [p.x.signum(), p.y.signum(), 1.0];
        let out = Vector::from(off.map(|v| v.max(0.0)));
        let found = if out.norm() > 0.0 {
            NearestOnDesign { distance: out.norm(), normal: out.component_mul(&Vector::from(signs)).normalize() }
        } else {
            let k = (0..3).max_by(|&a, &b| off[a].total_cmp(&off[b])).expect("three faces");
            let mut normal = Vector::zeros();
            normal[k] = signs[k];
            NearestOnDesign { distance: off[k], normal }
        };
        (found.distance.abs() <= range).then_some(found)
    }
}

/// A flat end mill takes 0.2 mm off the top of a block and runs far beyond it: along the normals of its sides
/// everything is gone, and yet no place of it lies deeper than 0.2 mm.
#[test]
fn a_layer_that_is_gone_beside_an_edge_is_as_deep_as_it_is_thick() {
    let deep = 0.2;
    let cutters = vec![Cutter::flat(40.0).and_then(|c| c.bodies(30.0)).expect("a mill")];
    let pose = |x: f64, z: f64| ToolPose { tip: Point::new(x, 0.0, z), axis: Vector::z() };
    let pieces = vec![
        PathPiece { from: pose(-90.0, 0.5), to: pose(-90.0, -deep), cutter: Some(0) },
        PathPiece { from: pose(-90.0, -deep), to: pose(90.0, -deep), cutter: Some(0) },
    ];
    let path = SweptPath::new(pieces, &cutters);
    let bounds = Aabb { min: Point::new(-5.0, -5.0, -5.0), max: Point::new(5.0, 5.0, 0.0) };
    let on = Refine { path: &path, design: &Slab, bounds, region: None, cell: 0.5 };
    for at in [[4.9, 0.0], [4.0, 4.5], [0.0, -4.95], [0.0, 0.0], [4.97, 4.97]] {
        let p = Point::new(at[0], at[1], -deep);
        let depth = -Slab.nearest(&p, 9.0).expect("inside").distance;
        let starts = Starts { points: vec![(depth, p, 1)], raw: false };
        if let Some(worst) = refined(&on, Side::Missing, &starts) {
            assert!((worst.depth - deep).abs() < 5e-3, "{at:?}: {worst:?}");
            assert!(bounds.contains(&worst.point), "{at:?}: {worst:?}");
        }
    }
}
