//! Families of gouges and of material left between the rays, with the truth by construction, and clean twins
//! of each.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use proveout_geom::{Aabb, Point, Pose, ToolPose, TriMesh, Vector, box_mesh};
use proveout_stock::TriDexel;
use proveout_surface::{
    DesignMesh, DesignSurface, Overcut, Overcuts, Uncut, UncutFound, Watcher, overcuts,
    topography::{PathPiece, SweptBodies},
    uncut,
};
use proveout_tool::{Cutter, Profile};

/// Numbers in [0, 1), the same in every run (Marsaglia 2003, xorshift).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Evenly on a scale of factors.
    fn scaled(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.next())
    }

    fn turn(&mut self) -> Pose {
        let axis = Vector::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0)).normalize();
        let place = Vector::new(self.within(-9.0, 9.0), self.within(-9.0, 9.0), self.within(-9.0, 9.0));
        Pose { translation: place, ..Pose::from_axis_angle(&axis, self.within(0.0, 6.0)) }
    }
}

/// An outline in Y and Z, counter-clockwise seen from +X, with its triangles, along X from -12 to 12.
fn extruded(outline: &[[f64; 2]], triangles: &[[u32; 3]]) -> TriMesh {
    let n = outline.len() as u32;
    let at = |x: f64| outline.iter().map(move |p| Point::new(x, p[0], p[1]));
    let mut mesh = TriMesh { positions: at(-12.0).chain(at(12.0)).collect(), triangles: Vec::new() };
    for t in triangles {
        mesh.triangles.extend([[t[0], t[2], t[1]], [t[0] + n, t[1] + n, t[2] + n]]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    mesh.check_solid().unwrap();
    assert!(mesh.volume() > 0.0);
    mesh
}

fn block() -> Aabb {
    Aabb { min: Point::new(-12.0, -12.0, -10.0), max: Point::new(12.0, 12.0, 0.0) }
}

/// A step: the floor at Z-5 for Y above 0, a wall at Y0.
fn step() -> TriMesh {
    let outline = [[-12.0, -10.0], [12.0, -10.0], [12.0, -5.0], [0.0, -5.0], [0.0, 0.0], [-12.0, 0.0]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
}

fn upright(from: [f64; 3], to: [f64; 3]) -> PathPiece {
    let at = |tip: [f64; 3]| ToolPose { tip: tip.into(), axis: Vector::z() };
    PathPiece { from: at(from), to: at(to), cutter: Some(0) }
}

fn moved(pieces: &[PathPiece], pose: &Pose) -> Vec<PathPiece> {
    let of = |p: &PathPiece| PathPiece { from: p.from.transformed(pose), to: p.to.transformed(pose), ..*p };
    pieces.iter().map(of).collect()
}

fn searched(design: &TriMesh, pieces: &[PathPiece], tool: &[Profile], allowed: f64, block: f64) -> Overcuts {
    let tree = DesignMesh::new(design).unwrap();
    let bounds = tree.bounds();
    let sweeps = SweptBodies::new(pieces, &[tool.to_vec()], &bounds.expanded(5.0), &|_| false);
    let on = Overcut {
        mesh: design,
        tree: &tree,
        sweeps: &sweeps,
        bounds,
        allowed,
        grain: 0.02 * allowed,
        block,
        known: &|_| false,
        most_boxes: 1_000_000,
    };
    overcuts(&on)
}

fn deepest(found: &Overcuts) -> f64 {
    found.found.iter().map(|w| w.depth).fold(0.0, f64::max)
}

/// A pass of a tool through a design: whether it goes as deep as wanted is known by construction.
fn fault(numbers: &mut Numbers, kind: usize, depth: f64) -> (TriMesh, Vec<Profile>, PathPiece) {
    let bodies = |c: Result<Cutter, _>| -> Vec<Profile> { Cutter::bodies(&c.unwrap(), 25.0).unwrap() };
    let length = numbers.within(0.4, 4.0);
    let x = numbers.within(-10.0, 6.0);
    let radius = numbers.within(1.0, 4.0);
    match kind {
        // A flat end mill takes a rebate off the upper edge at Y12: the shorter side counts.
        0 => {
            let (across, down) = if numbers.next() < 0.5 { (depth, depth * 1.5) } else { (depth * 2.0, depth) };
            let y = 12.0 + radius - across;
            (box_mesh(&block()), bodies(Cutter::flat(2.0 * radius)), upright([x, y, -down], [x + length, y, -down]))
        }
        // A ball takes the edge off: on the plane between both faces it lies deepest.
        1 => {
            let off = radius / 2.0_f64.sqrt() - depth;
            let (y, z) = (12.0 + off, off - radius);
            (box_mesh(&block()), bodies(Cutter::ball(2.0 * radius)), upright([x, y, z], [x + length, y, z]))
        }
        // A groove in the top face.
        2 => {
            let y = numbers.within(-8.0, 8.0);
            (
                box_mesh(&block()),
                bodies(Cutter::ball(2.0 * radius)),
                upright([x, y, -depth], [x + length, y + 0.3, -depth]),
            )
        }
        // A thin drill.
        3 => {
            let tool = bodies(Cutter::flat(0.3));
            (box_mesh(&block()), tool, upright([x, 1.0, 5.0], [x, 1.0, -depth]))
        }
        // Along floor and wall, into the floor.
        4 => (
            step(),
            bodies(Cutter::flat(2.0 * radius)),
            upright([x, radius, -5.0 - depth], [x + length, radius, -5.0 - depth]),
        ),
        // The same, into the wall.
        _ => (
            step(),
            bodies(Cutter::flat(2.0 * radius)),
            upright([x, radius - depth, -5.0], [x + length, radius - depth, -5.0]),
        ),
    }
}

/// Gouges of 0.1 to 3 cells along edges, on faces and next to walls, in any direction of space, among clean
/// passes: all are found with their depth, and none where the pass only touches or stays within what is
/// allowed.
#[test]
fn gouges_between_rays_are_found_with_their_depth_and_clean_twins_have_none() {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    let mut boxes = 0;
    for case in 0..120 {
        let kind = case % 6;
        let cell = numbers.scaled(0.2, 1.0);
        let allowed = if case % 2 == 0 { 0.01 } else { 0.05 };
        let depth = numbers.scaled((0.1 * cell).max(1.1 * allowed), 3.0 * cell.max(allowed)).min(0.9);
        let pose = numbers.turn();
        for (deep, clean) in [(depth, false), (0.0, true), (0.97 * allowed, true)] {
            let mut same = Numbers(0x9e37_79b9_7f4a_7c15 + case as u64);
            let (design, tool, piece) = fault(&mut same, kind, deep);
            // Clean passes over the part before and after.
            let mut pieces = Vec::new();
            for k in 0..24 {
                let y = -14.0 + 1.2 * f64::from(k);
                pieces.push(upright([-16.0, y, 0.0], [16.0, y, 0.0]));
            }
            pieces.insert(13, piece);
            let design = design.transformed(&pose);
            let found = searched(&design, &moved(&pieces, &pose), &tool, allowed, cell);
            assert!(found.undecided == 0, "{case} {kind} {deep}: {}", found.undecided);
            boxes += found.boxes;
            if clean {
                assert!(found.found.is_empty(), "{case} {kind} {deep} of {allowed}: {}", deepest(&found));
            } else {
                let worst = deepest(&found);
                assert!(worst <= depth * (1.0 + 1e-6) && worst >= 0.97 * depth, "{case} {kind} {depth}: {worst}");
                assert!(found.found.iter().all(|w| w.made_by == 13), "{case}");
            }
        }
    }
    // A block of one cell is a block for itself: about forty boxes each.
    assert!(boxes < 5_000_000, "{boxes}");
}

/// Random pieces of a tilting tool: what is found is there, and a dense lattice of places finds nothing
/// deeper.
#[test]
fn what_is_found_of_turning_pieces_is_there_and_no_place_of_a_lattice_is_deeper() {
    let mut numbers = Numbers(0x1234_5678_9abc_def1);
    let mut gouged = 0;
    for case in 0..40 {
        let design = step();
        let tree = DesignMesh::new(&design).unwrap();
        let tool = match case % 3 {
            0 => Cutter::flat(3.0),
            1 => Cutter::ball(3.0),
            _ => Cutter::bull_nose(4.0, 0.5),
        };
        let tool = tool.unwrap().bodies(8.0).unwrap();
        let pose = |numbers: &mut Numbers, near: Point| ToolPose {
            tip: near + Vector::new(0.0, numbers.within(-0.4, 1.6), numbers.within(-0.4, 0.8)),
            axis: Vector::new(numbers.within(-0.5, 0.5), numbers.within(-0.2, 0.9), 1.0).normalize(),
        };
        let edge = if case % 2 == 0 { Point::new(-2.0, 0.0, 0.0) } else { Point::new(-2.0, 1.0, -5.0) };
        let (from, to) = (pose(&mut numbers, edge), pose(&mut numbers, edge + Vector::new(2.0, 0.0, 0.0)));
        let to = ToolPose { axis: (from.axis + (to.axis - from.axis) * 0.2).normalize(), ..to };
        let piece = PathPiece { from, to, cutter: Some(0) };
        let found = searched(&design, &[piece], &tool, 0.02, 1.0);
        assert_eq!(found.undecided, 0, "{case}");
        let sweeps =
            SweptBodies::new(&[piece], &[tool], &Aabb { min: [-40.0; 3].into(), max: [40.0; 3].into() }, &|_| false);
        let mut lattice = 0.0_f64;
        for i in 0..30_usize.pow(3) {
            let at =
                |k: usize, low: f64, high: f64| low + (high - low) * ((i / 30_usize.pow(k as u32)) % 30) as f64 / 29.0;
            let p = Point::new(at(0, -3.5, 3.5), at(1, -2.0, 3.0), edge.z + at(2, -2.0, 0.5));
            let depth = -tree.signed_distance(&p).unwrap();
            if depth > lattice && sweeps.last_to_reach(&p, -1e-3).is_some() {
                lattice = depth;
            }
        }
        let worst = deepest(&found);
        assert!(lattice <= 0.0204 || worst >= 0.98 * lattice, "{case}: {worst} {lattice}");
        for w in &found.found {
            assert!((tree.signed_distance(&w.point).unwrap() + w.depth).abs() < 1e-9);
            assert!(sweeps.last_to_reach(&w.point, 1e-6).is_some(), "{case}");
        }
        gouged += usize::from(worst > 0.0);
    }
    assert!((10..40).contains(&gouged), "{gouged}");
}

/// A control rests for some cycles at the end of a motion, so that many pieces have one and the same pose.
#[test]
fn a_gouge_by_a_cutter_at_rest_is_found() {
    let tool = Cutter::flat(6.0).unwrap().bodies(25.0).unwrap();
    for count in [1, 8, 64, 200] {
        let rest = |depth: f64| vec![upright([0.0, 15.0 - depth, -depth], [0.0, 15.0 - depth, -depth]); count];
        let found = searched(&box_mesh(&block()), &rest(0.3), &tool, 0.01, 0.5);
        assert_eq!(found.undecided, 0, "{count}: {found:?}");
        assert!((0.2..=0.301).contains(&deepest(&found)), "{count}: {}", deepest(&found));
        let clean = searched(&box_mesh(&block()), &rest(0.0), &tool, 0.01, 0.5);
        assert!(clean.found.is_empty() && clean.undecided == 0, "{count}: {clean:?}");
    }
}

fn left(design: &TriMesh, pieces: &[PathPiece], tool: &[Profile], allowed: f64, cell: f64) -> UncutFound {
    let tree = DesignMesh::new(design).unwrap();
    let raw = block();
    let stock = TriDexel::from_box(&raw, cell, 1 << 30).unwrap();
    let sweeps = SweptBodies::new(pieces, &[tool.to_vec()], &raw, &|_| false);
    let outside =
        |p: &Point| (0..3).map(|k| (raw.min[k] - p[k]).max(p[k] - raw.max[k])).fold(f64::NEG_INFINITY, f64::max);
    let on = Uncut {
        mesh: design,
        tree: &tree,
        sweeps: Some(&sweeps),
        raw: Some(&outside),
        watchers: &[Watcher { stock: &stock, window: None }],
        fallen: false,
        region: None,
        allowed,
        missing: 0.01,
        film: 1e-3,
        known: &|_| false,
    };
    uncut(&on)
}

/// A block with a slot along X from Y y to y + w, 4 mm deep.
fn slotted(y: f64, w: f64) -> TriMesh {
    let outline =
        [[-12.0, -10.0], [12.0, -10.0], [12.0, 0.0], [y + w, 0.0], [y + w, -4.0], [y, -4.0], [y, 0.0], [-12.0, 0.0]];
    extruded(&outline, &[[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7]])
}

/// A block with a chamfer of c x c mm at the edge Y12 Z0.
fn chamfered(c: f64) -> TriMesh {
    let outline = [[-12.0, -10.0], [12.0, -10.0], [12.0, -c], [12.0 - c, 0.0], [-12.0, 0.0]];
    extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]])
}

/// Slots and chamfers of 0.2 to 4 cells and cavities that were left full are found; the same milled are not.
#[test]
fn slots_chamfers_and_cavities_left_full_are_found_and_milled_ones_are_not() {
    let mut numbers = Numbers(0xfeed_5eed_1234_5678);
    for case in 0..90 {
        let cell = numbers.scaled(0.3, 2.0);
        let size = (cell * numbers.scaled(0.2, 4.0)).clamp(0.15, 3.0);
        let allowed = 0.01;
        match case % 3 {
            0 => {
                let y = numbers.within(-9.0, 5.0);
                let design = slotted(y, size);
                let full = left(&design, &[], &[], allowed, cell);
                let most = full.left.iter().map(|l| l.depth).fold(0.0, f64::max);
                assert!(most > 0.6 * (0.5 * size) && most <= 0.5 * size + 1e-9, "{case}: {size} {most}");
                let tool = Cutter::flat(size).unwrap().bodies(20.0).unwrap();
                let pass = upright([-15.0, y + 0.5 * size, -4.0], [15.0, y + 0.5 * size, -4.0]);
                assert_eq!(left(&design, &[pass], &tool, allowed, cell), UncutFound::default(), "{case}");
                // Half way along only.
                let pass = upright([-15.0, y + 0.5 * size, -4.0], [-2.0, y + 0.5 * size, -4.0]);
                assert!(!left(&design, &[pass], &tool, allowed, cell).left.is_empty(), "{case}");
            }
            1 => {
                let c = size.min(2.0);
                let design = chamfered(c);
                let full = left(&design, &[], &[], allowed, cell);
                let most = full.left.iter().map(|l| l.depth).fold(0.0, f64::max);
                let truth = c / 2.0_f64.sqrt();
                assert!(most > 0.3 * truth && most <= truth + 1e-9, "{case}: {truth} {most}");
                // With the face of a tilted end mill.
                let axis = Vector::new(0.0, 1.0, 1.0).normalize();
                let at = |x: f64| ToolPose { tip: Point::new(x, 12.0 - 0.5 * c, -0.5 * c), axis };
                let tool = Cutter::flat(10.0).unwrap().bodies(20.0).unwrap();
                let pass = PathPiece { from: at(-20.0), to: at(20.0), cutter: Some(0) };
                assert_eq!(left(&design, &[pass], &tool, allowed, cell), UncutFound::default(), "{case}");
            }
            _ => {
                let low = Point::new(numbers.within(-8.0, 4.0), numbers.within(-8.0, 4.0), -7.0);
                let mut design = box_mesh(&block());
                let mut hollow = box_mesh(&Aabb { min: low, max: low + Vector::repeat(size) });
                hollow.triangles.iter_mut().for_each(|t| t.swap(1, 2));
                design.append(&hollow);
                let found = left(&design, &[], &[], allowed, cell);
                let most = found.left.iter().map(|l| l.depth).fold(0.0, f64::max);
                assert!(most > 0.3 * size && most <= 0.5 * size + 1e-9, "{case}: {size} {most}");
            }
        }
    }
}

/// A bound of a group holds for each of its members, along any direction, for cutters that turn, groups near
/// and far from the axis included; of a ball whose axis swings it is no wider than the ways of its center.
#[test]
fn a_group_of_moves_reaches_no_farther_than_its_bound_and_a_ball_is_bounded_by_its_center() {
    let mut numbers = Numbers(0x0b0b_1e5e_1ea5_7001);
    let mut tighter = 0;
    for case in 0..60 {
        let ball = case % 2 == 0;
        let tool = if ball { Cutter::ball(8.0) } else { Cutter::bull_nose(10.0, 1.5) };
        let tool = tool.unwrap().bodies(40.0).unwrap();
        let lean = numbers.within(0.0, 0.6);
        let pose = |k: usize| {
            let angle = lean * (0.37 * k as f64).sin();
            let axis = Vector::new(angle.sin(), 0.0, angle.cos());
            // The center of the ball runs along X; of the others the tip does.
            let up = if ball { 4.0 } else { 0.0 };
            ToolPose { tip: Point::new(0.05 * k as f64, 0.0, 0.0) - axis * up, axis }
        };
        let pieces: Vec<PathPiece> =
            (0..200).map(|k| PathPiece { from: pose(k), to: pose(k + 1), cutter: Some(0) }).collect();
        let everywhere = Aabb { min: Point::new(-1e3, -1e3, -1e3), max: Point::new(1e3, 1e3, 1e3) };
        let sweeps = SweptBodies::new(&pieces, &[tool], &everywhere, &|_| false);
        let mut open: Vec<_> = sweeps.root().into_iter().collect();
        while let Some(item) = open.pop() {
            let members: Vec<_> = sweeps.members(item).collect();
            for _ in 0..4 {
                let near_axis = numbers.within(0.0, 1.0) < 0.3;
                let aside = if near_axis { 1e-3 } else { 1.0 };
                let n = Vector::new(aside * numbers.within(-1.0, 1.0), aside * numbers.within(-1.0, 1.0), 1.0)
                    .normalize()
                    * numbers.within(-1.0, 1.0).signum();
                let bound = sweeps.least(item, &n);
                let lowest = members.iter().map(|m| sweeps.least(*m, &n)).fold(f64::INFINITY, f64::min);
                assert!(bound <= lowest + 1e-9, "{case}: {n} {bound} {lowest}");
                if ball && !item.is_single() {
                    let of_box = {
                        let b = sweeps.bounds(item);
                        (0..3).map(|k| n[k] * if n[k] > 0.0 { b.min[k] } else { b.max[k] }).sum::<f64>()
                    };
                    tighter += usize::from(bound > of_box + 0.1);
                }
            }
            open.extend(members);
        }
    }
    assert!(tighter > 500, "{tighter}");
}
