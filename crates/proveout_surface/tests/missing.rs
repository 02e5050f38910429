//! Missing material on the rays, areas, and what the rays cannot show. Parts are made as meshes, so that what
//! is missing is known in closed form and nothing is cut.

use std::f64::consts::PI;

use proveout_geom::{Aabb, Point, Pose, ToolPose, TriMesh, Vector, box_mesh, revolved_mesh};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_surface::{
    Area, AreaPart, Areas, DesignMesh, DesignSurface, DeviationSettings, FoundGap, GapEnd, GapSettings, Judged, Seed,
    Side, Solid, Survey, ThinFins, Unseen, Watcher, unseen,
};

const GIB: u64 = 1 << 30;
const FLOOR: f64 = 1e-4;

fn cuboid(min: [f64; 3], max: [f64; 3]) -> TriMesh {
    box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) })
}

fn joined(parts: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    parts.iter().for_each(|p| all.append(p));
    all
}

/// A plate 40 x 40 x 10 with a wall of some thickness from X 20 on, 8 mm high, as one closed outline along Y.
fn with_wall(thickness: f64) -> TriMesh {
    let outline = [
        [0.0, 0.0],
        [40.0, 0.0],
        [40.0, 10.0],
        [20.0 + thickness, 10.0],
        [20.0 + thickness, 18.0],
        [20.0, 18.0],
        [20.0, 10.0],
        [0.0, 10.0],
    ];
    // Triangles of the outline, counter-clockwise.
    extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 6], [0, 6, 7], [3, 4, 5], [3, 5, 6]], 40.0)
}

/// An outline in X and Z (counter-clockwise seen from -Y) with its triangles, along Y.
fn extruded(outline: &[[f64; 2]], triangles: &[[u32; 3]], length: f64) -> TriMesh {
    let n = outline.len() as u32;
    let at = |y: f64| outline.iter().map(move |p| Point::new(p[0], y, p[1]));
    let mut mesh = TriMesh { positions: at(0.0).chain(at(length)).collect(), triangles: Vec::new() };
    for t in triangles {
        mesh.triangles.push(*t);
        mesh.triangles.push([t[0] + n, t[2] + n, t[1] + n]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        mesh.triangles.extend([[i, i + n, j + n], [i, j + n, j]]);
    }
    mesh.check_solid().expect("an outline gives a solid");
    mesh
}

struct Found {
    gaps: Vec<FoundGap>,
    areas: Vec<Area>,
    deepest_point: f64,
}

/// Compares a part with a design, as a run does.
fn hold(stock: &TriDexel, design: &TriMesh, limit: f64) -> Found {
    let tree = DesignMesh::new(design).expect("solid");
    let settings = DeviationSettings {
        range: f64::INFINITY,
        region: None,
        only_cut: false,
        tolerance_floor: FLOOR,
        cells: stock.cells_mm(),
    };
    let gaps = GapSettings { missing: limit, left: limit, floor: FLOOR };
    let solid = Solid { mesh: design, tree: &tree, gaps };
    let survey = Survey {
        stock,
        design: Some(&tree),
        solid: Some(solid),
        settings,
        fins: ThinFins::default(),
        window: None,
        finer: &[],
    };
    let mut areas =
        Areas::new(vec![AreaPart { corner: stock.bounds().min, cells: stock.cells_mm(), window: None }], limit);
    let mut found = Found { gaps: Vec::new(), areas: Vec::new(), deepest_point: 0.0 };
    let ray_area = |axis: usize| stock.cells_mm()[(axis + 1) % 3] * stock.cells_mm()[(axis + 2) % 3];
    let run: Result<(), ()> = survey.run(|band| {
        for j in &band.judged {
            if let Judged::Counts { deviation, .. } = j {
                found.deepest_point = found.deepest_point.max(-deviation);
            }
        }
        for f in band.gaps.iter().filter(|f| f.gap.side == Side::Missing) {
            let area = ray_area(f.ray.axis);
            let seed = |k: usize| Seed {
                depth: f.gap.depth,
                point: f.ray.point(f.gap.at[k]),
                design_area: match f.gap.ends[k] {
                    GapEnd::Design(n) => n[f.ray.axis].abs() * area,
                    GapEnd::Cut(_) => 0.0,
                },
                gap: (k == 0).then_some((f.ray.axis, f.length, area)),
                made_by: match f.gap.ends[k] {
                    GapEnd::Cut(end) => band.points[f.first_point + end].made_by,
                    GapEnd::Design(_) => f.last_to_empty,
                },
                wall: f.gap.wall,
                foil: f.gap.foil,
                ..Seed::default()
            };
            areas.add(0, &seed(0));
            areas.add(0, &seed(1));
            areas.join(0, &seed(0).point, &seed(1).point);
        }
        found.gaps.extend(band.gaps);
        Ok(())
    });
    run.expect("nothing refuses");
    found.areas = areas.finish();
    found
}

fn plate() -> TriDexel {
    let stock = TriDexel::from_mesh(
        &joined(&[cuboid([0.0; 3], [40.0, 40.0, 10.0]), cuboid([-1.0, -1.0, 17.0], [-0.9, -0.9, 18.0])]),
        0.5,
        GIB,
    );
    stock.expect("solid")
}

#[test]
fn a_wall_that_is_gone_counts_with_its_thickness() {
    for (thickness, limit) in [(1.0, 0.02), (0.4, 0.02), (0.2, 0.02), (0.2, 0.15), (0.07, 0.05)] {
        let found = hold(&plate(), &with_wall(thickness), limit);
        assert_eq!(found.areas.len(), 1, "{thickness}: {:?}", found.areas);
        let area = &found.areas[0];
        assert!((area.depth - thickness).abs() < 1e-9 && area.wall == Some(area.depth), "{thickness}: {area:?}");
        // Both sides, 40 mm long and 8 mm high; the top and the ends only where rays meet them.
        let sides = 2.0 * 40.0 * 8.0;
        assert!(area.area >= sides * 0.999 && area.area < sides + 56.0 * (thickness + 0.5), "{area:?}");
        assert!((area.volume / (40.0 * 8.0 * thickness) - 1.0).abs() < 0.02, "{thickness}: {area:?}");
        assert!((10.0..=18.0).contains(&area.point.z), "{area:?}");
        // What the points of the part show: half of it at most.
        assert!(found.deepest_point <= 0.5 * thickness + 1e-9);
    }
}

#[test]
fn a_foil_below_the_tolerance_is_missed_where_it_is_gone_and_a_wedge_is_no_foil() {
    let found = hold(&plate(), &with_wall(0.04), 0.05);
    assert!(found.areas.len() == 1 && found.areas[0].foil && (found.areas[0].depth - 0.04).abs() < 1e-9);
    // The tip of a wedge of 20 degrees recedes by 0.1 mm: 0.035 mm thick there, within a tolerance of 0.05
    // mm.
    let wedge = |tip: f64| {
        let half = 10.0 * (10.0_f64 / 180.0 * PI).tan();
        let w = half * tip / 10.0;
        extruded(&[[-half, 0.0], [half, 0.0], [w, 10.0 - tip], [-w, 10.0 - tip]], &[[0, 1, 2], [0, 2, 3]], 20.0)
    };
    for cell in [0.03, 0.1, 0.37] {
        let stock =
            TriDexel::from_mesh(&joined(&[wedge(0.1), cuboid([-3.0, -1.0, 10.5], [-2.9, -0.9, 10.6])]), cell, GIB);
        let found = hold(&stock.expect("solid"), &wedge(1e-6), 0.05);
        assert!(found.areas.is_empty(), "{cell}: {:?}", found.areas);
    }
}

#[test]
fn a_wall_cut_from_one_side_counts_with_what_is_missing() {
    // 1 mm thick, 0.7 mm of it taken from the side of +X.
    let part = joined(&[with_wall(0.3), cuboid([-1.0, -1.0, 17.0], [-0.9, -0.9, 18.0])]);
    let stock = TriDexel::from_mesh(&part, 0.5, GIB).expect("solid");
    let found = hold(&stock, &with_wall(1.0), 0.02);
    assert_eq!(found.areas.len(), 1);
    assert!((found.areas[0].depth - 0.7).abs() < 1e-9, "{:?}", found.areas);
    assert!((found.areas[0].volume / (40.0 * 8.0 * 0.7) - 1.0).abs() < 0.03, "{:?}", found.areas);
    assert!((found.deepest_point - 0.3).abs() < 1e-9, "the points are nearer to the other side");
}

#[test]
fn a_layer_that_was_milled_off_a_block_is_no_wall() {
    for layer in [0.03, 0.3, 2.0] {
        let part =
            joined(&[cuboid([0.0; 3], [40.0, 30.0, 18.0 - layer]), cuboid([-1.0, -1.0, 17.9], [-0.9, -0.9, 18.0])]);
        for cell in [0.5, 0.37] {
            let stock = TriDexel::from_mesh(&part, cell, GIB).expect("solid");
            let found = hold(&stock, &cuboid([0.0; 3], [40.0, 30.0, 18.0]), 0.02);
            assert_eq!(found.areas.len(), 1, "{:?}", found.areas);
            let area = &found.areas[0];
            assert!((area.depth - layer).abs() < 1e-9 && area.wall.is_none(), "{layer}: {area:?}");
            assert!((area.volume / (40.0 * 30.0 * layer) - 1.0).abs() < 0.02, "{layer}: {area:?}");
            assert!((area.area - 1200.0).abs() < 40.0 + 140.0 * (layer + cell), "{layer}: {area:?}");
        }
    }
}

/// Shapes with edges, crowns, fins, wedges, cavities, at grids that fit none of their faces.
fn shapes() -> Vec<(&'static str, TriMesh)> {
    // Fins from 0.05 to 0.37 mm on a bar: breaks along X, at each of them the outline goes up and down.
    let breaks: Vec<f64> = (0..9).flat_map(|k| [0.4 + 4.0 * f64::from(k), 0.45 + 4.04 * f64::from(k)]).collect();
    let breaks: Vec<f64> = [&[0.0][..], &breaks, &[40.0]].concat();
    let n = breaks.len() as u32;
    let mut outline: Vec<[f64; 2]> = breaks.iter().map(|x| [*x, 0.0]).collect();
    outline.extend(breaks.iter().rev().map(|x| [*x, 5.0]));
    let mut triangles = Vec::new();
    let above = |i: u32| 2 * n - 1 - i;
    for i in 0..n - 1 {
        triangles.extend([[i, i + 1, above(i + 1)], [i, above(i + 1), above(i)]]);
    }
    // Tops of the fins lie between the upper points of their feet.
    let mut order: Vec<u32> = (0..n).collect();
    for i in (0..n).rev() {
        order.push(above(i));
        if i % 2 == 0 && i > 0 && i < n - 1 {
            let first = outline.len() as u32;
            outline.extend([[breaks[i as usize], 9.0], [breaks[i as usize - 1], 9.0]]);
            order.extend([first, first + 1]);
            triangles.extend([[above(i - 1), above(i), first], [above(i - 1), first, first + 1]]);
        }
    }
    let number: Vec<u32> =
        (0..order.len() as u32).map(|k| order.iter().position(|o| *o == k).expect("all") as u32).collect();
    let outline: Vec<[f64; 2]> = order.iter().map(|o| outline[*o as usize]).collect();
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|c| number[c as usize])).collect();
    let comb = extruded(&outline, &triangles, 12.0);
    let ball: Vec<[f64; 2]> = (0..=48)
        .map(|i| {
            let a = PI * f64::from(i) / 48.0;
            [if i == 0 || i == 48 { 0.0 } else { 9.0 * a.sin() }, -9.0 * a.cos()]
        })
        .collect();
    vec![
        ("block", cuboid([0.0; 3], [13.0, 9.0, 7.0])),
        ("wall", with_wall(0.2)),
        ("comb", comb),
        ("ball", revolved_mesh(&ball, 96)),
        (
            "cup",
            revolved_mesh(&[[0.0, 0.0], [8.0, 0.0], [9.0, 12.0], [8.0, 12.0], [7.0, 1.0], [2.0, 1.5], [0.0, 1.0]], 64),
        ),
        ("needle", revolved_mesh(&[[0.0, 0.0], [3.0, 0.0], [0.0, 14.0]], 40)),
        ("wedge", extruded(&[[0.0, 0.0], [9.0, 0.0], [9.0, 1.5]], &[[0, 1, 2]], 11.0)),
    ]
}

fn places() -> [Pose; 3] {
    let v = Vector::new(0.123, -0.377, 0.211);
    [
        Pose::from_translation(v),
        Pose::from_rpy(v, 0.4, -0.7, 1.1),
        Pose::from_rpy(v, 0.0, 0.0, std::f64::consts::FRAC_PI_4),
    ]
}

#[test]
fn a_perfect_part_has_no_gap_anywhere() {
    for (name, mesh) in shapes() {
        for place in places() {
            let design = mesh.transformed(&place);
            let stock = TriDexel::from_mesh_repaired(&design, 0.43, GIB).expect("solid");
            let found = hold(&stock, &design, 1e-5);
            assert!(found.gaps.is_empty() && found.areas.is_empty(), "{name}: {:?}", found.areas);
        }
    }
}

#[test]
fn a_part_within_its_tolerance_has_no_gap_and_one_beyond_it_has() {
    // Smaller by a layer on all sides: the design is the part grown, so that the distance is the same
    // everywhere.
    for layer in [0.02, 0.08] {
        let limit = 0.05;
        let ball = |r: f64| {
            let profile: Vec<[f64; 2]> = (0..=96)
                .map(|i| {
                    let a = PI * f64::from(i) / 96.0;
                    [if i == 0 || i == 96 { 0.0 } else { r * a.sin() }, -r * a.cos()]
                })
                .collect();
            revolved_mesh(&profile, 192)
        };
        let block = |d: f64| cuboid([d; 3], [13.0 - d, 9.0 - d, 7.0 - d]);
        for (part, design) in [(ball(9.0 - layer), ball(9.0)), (block(layer), block(0.0))] {
            for place in places() {
                let (part, design) = (part.transformed(&place), design.transformed(&place));
                for cell in [0.21, 0.43] {
                    let stock = TriDexel::from_mesh(&part, cell, GIB).expect("solid");
                    let found = hold(&stock, &design, limit);
                    if layer < limit {
                        assert!(found.areas.is_empty(), "{:?}", found.areas);
                    } else {
                        // Facets and edges of a block that is smaller by sqrt(3) layers at its corners stay
                        // between.
                        assert_eq!(found.areas.len(), 1, "{:?}", found.areas);
                        let depth = found.areas[0].depth;
                        assert!(depth >= layer * 0.99 && depth <= layer * 1.75, "{depth}");
                    }
                }
            }
        }
    }
}

fn looked_for(design: &TriMesh, stock: &TriDexel) -> Option<Unseen> {
    let tree = DesignMesh::new(design).expect("solid");
    unseen(design, &tree, &[Watcher { stock, window: None }], None)
}

#[test]
fn walls_are_seen_at_any_thickness_and_pins_between_the_rays_are_not() {
    for (name, mesh) in shapes().into_iter().filter(|(name, _)| !matches!(*name, "needle" | "wedge")) {
        for place in places() {
            let design = mesh.transformed(&place);
            let stock = TriDexel::from_mesh_repaired(&design, 0.43, GIB).expect("solid");
            assert_eq!(looked_for(&design, &stock), None, "{name}");
        }
    }
    // A pin of 0.2 mm on the plate, in the middle between rays along X and Y, and on one.
    let on = |x: f64, y: f64, width: f64| {
        let pin = cuboid([x - 0.5 * width, y - 0.5 * width, 10.0], [x + 0.5 * width, y + 0.5 * width, 14.0]);
        joined(&[cuboid([0.0; 3], [40.0, 40.0, 10.0]), pin])
    };
    let pin = on(20.0, 20.0, 0.2);
    let found = looked_for(&pin, &plate()).expect("between the rays");
    // Its sides above the floor but for the reach of the rays of the floor, and its top.
    assert!(found.area > 0.8 * 4.0 * 0.2 * 4.0 && found.area < 4.0 * 0.2 * 4.1 + 0.05, "{found:?}");
    assert!((found.thickness - 0.2).abs() < 1e-9 && found.point.z > 10.0);
    assert_eq!(looked_for(&on(20.25, 20.25, 0.2), &plate()), None);
    assert_eq!(looked_for(&on(20.0, 20.0, 0.6), &plate()), None, "wider than a cell");
    // It is gone from the plate: the rays that meet the second one show it.
    assert!(hold(&plate(), &pin, 0.02).areas.is_empty());
    assert_eq!(hold(&plate(), &on(20.25, 20.25, 0.2), 0.02).areas.len(), 1);
    // Finer cells see it.
    let fine =
        TriDexel::from_box(&Aabb { min: Point::origin(), max: Point::new(40.0, 40.0, 18.0) }, 0.15, GIB).expect("box");
    assert_eq!(looked_for(&pin, &fine), None);
    let tree = DesignMesh::new(&pin).expect("solid");
    let window = Aabb { min: Point::new(18.0, 18.0, 8.0), max: Point::new(22.0, 22.0, 19.0) };
    let watchers = [Watcher { stock: &plate(), window: None }, Watcher { stock: &fine, window: Some(window) }];
    assert_eq!(unseen(&pin, &tree, &watchers, None), None, "within a patch");
}

#[test]
fn gouges_of_known_size_have_their_figures() {
    // Plunges of flat cutters into a block, apart by some cells: place, diameter, depth.
    let pits = [
        ([6.13, 6.31], 8.0, 1.3),
        ([16.2, 8.77], 5.0, 0.4),
        ([26.0, 20.0], 10.0, 3.1),
        ([36.3, 4.2], 2.0, 0.06),
        ([6.4, 24.9], 2.0, 4.0),
    ];
    for cell in [0.2, 0.5] {
        let block = Aabb { min: Point::origin(), max: Point::new(40.0, 32.0, 12.0) };
        let mut stock = TriDexel::from_box(&block, cell, GIB).expect("box");
        for (k, (at, diameter, depth)) in pits.iter().enumerate() {
            let cutter = proveout_tool::Cutter::flat(*diameter).expect("flat").bodies(30.0).expect("bodies").remove(0);
            let pose = |z: f64| ToolPose { tip: Point::new(at[0], at[1], z), axis: Vector::z() };
            let motion = SweepMotion { from: pose(20.0), to: pose(12.0 - depth) };
            stock.sweep(&[SweepItem { id: 10 + k as u32, body: &cutter, action: Action::Remove, motion }]);
        }
        let found = hold(&stock, &box_mesh(&block), 0.02);
        let mut wanted: Vec<(usize, f64, f64)> =
            pits.iter().enumerate().map(|(k, (_, d, depth))| (k, *depth, 0.25 * PI * d * d)).collect();
        wanted.sort_by(|a, b| b.1.total_cmp(&a.1));
        assert_eq!(found.areas.len(), wanted.len(), "{:?}", found.areas);
        for (area, (k, depth, size)) in found.areas.iter().zip(wanted) {
            // The cutter is taken smaller by rounding, and the stock promises its sweep within its bound.
            assert!((area.depth - depth).abs() <= stock.sweep_bound_mm() + 1e-6, "{area:?} {depth}");
            assert_eq!(area.made_by, Some(10 + k as u32));
            // Points of a lattice in a disk: the error is less than half a cell along the rim.
            let rim = 0.5 * cell * PI * pits[k].1;
            assert!((area.area - size).abs() <= rim, "{cell}: {area:?} {size}");
            assert!((area.volume - size * depth).abs() <= rim * depth, "{cell}: {area:?} {}", size * depth);
        }
    }
}

#[test]
fn gaps_do_not_depend_on_threads() {
    let (stock, design) = (plate(), with_wall(0.4));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
        pool.install(|| format!("{:?}", hold(&stock, &design, 0.02).areas))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_mesh_tells_free_sight_and_thickness() {
    let tree = DesignMesh::new(&with_wall(0.2)).expect("solid");
    assert!((tree.thickness(&Point::new(20.0, 5.0, 15.0), &-Vector::x()) - 0.2).abs() < 1e-9);
    assert!(tree.is_free(&Point::new(20.1, 5.0, 11.0), &Point::new(20.05, 9.0, 17.0)));
    assert!(!tree.is_free(&Point::new(20.1, 5.0, 11.0), &Point::new(20.5, 5.0, 11.0)));
    assert!(tree.signed_distance(&Point::new(20.1, 5.0, 15.0)).expect("near") < 0.0);
}
