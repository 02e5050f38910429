//! The triangle mesh of the stock.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use crate::common::{GIB, ball, bull, cuboid, flat, pose, probe, remove};
use proveout_geom::{Point, TriMesh, Vector};
use proveout_stock::{SurfaceMesh, TileId, TriDexel};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn cut_block(cell: f64) -> TriDexel {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 8.0]), cell, GIB).unwrap();
    let (a, b, c) = (ball(2.0, 20.0), bull(3.0, 1.0, 20.0), flat(2.5, 20.0));
    stock.sweep(&[
        remove(1, &a, pose([-3.0, 4.03, 6.07], UP), pose([23.0, 5.0, 5.9], [0.1, 0.0, 1.0])),
        remove(2, &b, pose([5.02, 11.0, 10.0], UP), pose([5.02, 11.0, 5.13], UP)),
        remove(3, &c, pose([15.0, 11.0, 4.11], [0.3, 0.1, 1.0]), pose([16.0, 12.0, 4.11], [0.3, 0.1, 1.0])),
    ]);
    stock
}

#[test]
fn the_mesh_of_a_box_is_the_box() {
    let stock = TriDexel::from_box(&cuboid([1.0, 2.0, 3.0], [5.0, 6.0, 6.0]), 0.25, GIB).unwrap();
    let surface = stock.surface();
    surface.mesh.check_solid().unwrap();
    assert!((surface.mesh.volume() - 48.0).abs() < 1e-3, "corners and edges are kept: {}", surface.mesh.volume());
    assert!(surface.made_by.iter().all(Option::is_none));
}

#[test]
fn the_mesh_of_a_cut_block_is_closed_and_keeps_its_volume() {
    let stock = cut_block(0.2);
    let surface = stock.surface();
    surface.mesh.check_solid().unwrap();
    assert_eq!(surface.normals.len(), surface.mesh.positions.len());
    assert_eq!(surface.made_by.len(), surface.mesh.positions.len());
    let ratio = surface.mesh.volume() / stock.volume();
    assert!((ratio - 1.0).abs() < 3e-3, "{ratio}");
    for id in 1..=3 {
        assert!(surface.made_by.contains(&Some(id)));
    }
    for n in &surface.normals {
        assert!((n.norm() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_edge_of_a_plunge_stays_sharp() {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [12.0, 12.0, 6.0]), 0.3, GIB).unwrap();
    let tool = flat(4.0, 20.0);
    stock.sweep(&[remove(1, &tool, pose([6.0, 6.0, 10.0], UP), pose([6.0, 6.0, 2.0], UP))]);
    let surface = stock.surface();
    surface.mesh.check_solid().unwrap();
    // Every vertex lies on floor, wall or block; at the rim of the top face radius and height are both met.
    let mut rim = 0;
    for p in &surface.mesh.positions {
        let d = (p.x - 6.0).hypot(p.y - 6.0);
        if (p.z - 6.0).abs() < 1e-6 && (d - 4.0).abs() < 0.05 {
            rim += 1;
        }
        if p.z > 2.4 && p.z < 5.5 && d < 5.0 {
            assert!((d - 4.0).abs() < 0.02, "wall vertex {p} at radius {d}");
        }
    }
    assert!(rim > 60, "{rim}");
}

/// Parts of a mesh that hang together.
fn components(mesh: &TriMesh) -> usize {
    let mut parent: Vec<usize> = (0..mesh.positions.len()).collect();
    fn root(parent: &mut [usize], mut v: usize) -> usize {
        while parent[v] != v {
            parent[v] = parent[parent[v]];
            v = parent[v];
        }
        v
    }
    for t in &mesh.triangles {
        for k in 1..3 {
            let (a, b) = (root(&mut parent, t[0] as usize), root(&mut parent, t[k] as usize));
            parent[a.max(b)] = a.min(b);
        }
    }
    let used: std::collections::BTreeSet<usize> =
        mesh.triangles.iter().map(|t| root(&mut parent, t[0] as usize)).collect();
    used.len()
}

/// A tilted tool goes in along its axis, turns a little, and is drawn out along its axis again: the mesh has
/// no speckle.
#[test]
fn a_tilted_tool_that_retracts_leaves_a_clean_surface() {
    for (tool, tilt) in
        [(flat(3.0, 40.0), 0.35), (bull(3.0, 1.0, 40.0), 0.35), (ball(3.0, 40.0), 0.2), (flat(3.0, 40.0), 0.0)]
    {
        let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 10.0]), 0.2, GIB).unwrap();
        let axis = Vector::new(tilt, 0.13 * tilt, 1.0).normalize();
        let low = pose([9.0, 8.0, 4.0], axis.into());
        let out = pose((low.tip + axis * 15.0).coords.into(), axis.into());
        let turned = pose([9.4, 8.1, 4.05], [tilt + 0.02, 0.1 * tilt + 0.01, 1.0]);
        let out_turned = pose((turned.tip + turned.axis * 15.0).coords.into(), turned.axis.into());
        let cut = [remove(1, &tool, out, low), remove(2, &tool, low, turned), remove(3, &tool, turned, out_turned)];
        let reports = stock.sweep(&cut);
        assert!(reports[0].volume_mm3 > 50.0);
        let surface = stock.surface();
        surface.mesh.check_solid().unwrap();
        assert_eq!(components(&surface.mesh), 1, "a speck floats in the hole: {tool:?}");
        // Nothing is left in the hole, and what the way out finds again is no deeper than the bound of the
        // sweep.
        let again = stock.sweep(&[probe(4, &tool, low, out), probe(5, &tool, turned, out_turned)]);
        for r in &again {
            // Along a ray at one degree to the wall the bound of 0.4 micrometers is 0.023 mm long.
            assert!(r.overlap_mm < 0.03 && r.volume_mm3 < 0.02, "{r:?}");
        }
        // Facets: none of noticeable size looks into the material.
        for (t, corners) in surface.mesh.triangles.iter().enumerate() {
            let n = surface.mesh.area_normal(t);
            let mean: Vector = corners.iter().map(|&c| surface.normals[c as usize]).sum();
            assert!(
                n.norm() < 1e-4 || n.dot(&mean) > -0.5 * n.norm() * mean.norm(),
                "folded facet at {}",
                surface.mesh.positions[corners[0] as usize]
            );
        }
    }
}

#[test]
fn the_blocks_together_are_the_whole() {
    let stock = cut_block(0.2);
    for step in [1, 2, 4] {
        let mut all = TriMesh::default();
        for t in 0..stock.tile_count() {
            all.append(&stock.tile_surface(TileId(t as u32), step).mesh);
        }
        let whole = stock.surface_with_step(step).mesh;
        let merged = all.merge_equal_vertices();
        assert_eq!(merged.triangles.len(), whole.triangles.len());
        assert!((merged.volume() - whole.volume()).abs() < 1e-9 * whole.volume());
        merged.check_solid().unwrap();
    }
    assert_eq!(stock.tile_surface(TileId(u32::MAX), 1), SurfaceMesh::default());
}

#[test]
fn the_bands_one_after_the_other_are_the_whole() {
    // One band, several, thin boxes of one cell.
    let thin = |size: [f64; 3]| TriDexel::from_box(&cuboid([0.0; 3], size), 1.0, GIB).unwrap();
    for stock in [cut_block(0.2), cut_block(0.05), thin([1.0, 1.0, 1.0]), thin([1.0, 9.0, 4.0]), thin([7.0, 1.0, 2.0])]
    {
        let mut all = SurfaceMesh::default();
        let (mut bands, mut highest) = (0, f64::NEG_INFINITY);
        let run: Result<(), ()> = stock.surface_in_bands(|band| {
            assert_eq!(band.first as usize, all.mesh.positions.len());
            all.mesh.positions.extend(&band.positions);
            all.normals.extend(&band.normals);
            all.made_by.extend(&band.made_by);
            let lowest = band.triangles.iter().flatten().map(|&i| all.mesh.positions[i as usize].x);
            assert!(lowest.fold(f64::INFINITY, f64::min) >= band.from_x && band.from_x >= highest);
            highest = band.from_x;
            all.mesh.triangles.extend(&band.triangles);
            bands += 1;
            Ok(())
        });
        run.unwrap();
        assert_eq!(all, stock.surface());
        assert_eq!(stock.surface_triangles(), all.mesh.triangles.len() as u64);
        assert!(bands > 1 || all.mesh.positions.len() < 1 << 17, "{bands}");
    }
    assert_eq!(cut_block(0.2).surface_in_bands(|_| Err(7)), Err(7));
}

#[test]
fn only_blocks_that_were_cut_have_changed() {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [32.0, 32.0, 32.0]), 0.25, GIB).unwrap();
    assert_eq!(stock.take_changed_tiles().len(), stock.tile_count());
    assert!(stock.take_changed_tiles().is_empty());
    let before: Vec<SurfaceMesh> = (0..stock.tile_count()).map(|t| stock.tile_surface(TileId(t as u32), 1)).collect();
    let tool = ball(1.0, 10.0);
    stock.sweep(&[remove(1, &tool, pose([3.0, 3.0, 31.0], UP), pose([4.0, 3.0, 31.0], UP))]);
    let changed = stock.take_changed_tiles();
    assert!(!changed.is_empty() && changed.len() < 8);
    for (t, old) in before.iter().enumerate() {
        let same = stock.tile_surface(TileId(t as u32), 1) == *old;
        assert!(same || changed.contains(&TileId(t as u32)), "block {t} changed unnoticed");
    }
    let near = stock.tile_bounds(changed[0]);
    assert!(near.contains(&Point::new(3.0, 3.0, 31.5)) || changed.len() > 1);
}

#[test]
fn normals_look_out_of_the_material() {
    let stock = cut_block(0.4);
    for p in stock.surface_points() {
        let n = p.normal.unwrap();
        let e = Vector::ith(usize::from(p.axis), 1.0);
        let (_, spans) = stock.intervals_on(
            usize::from(p.axis),
            p.point[(usize::from(p.axis) + 1) % 3],
            p.point[(usize::from(p.axis) + 2) % 3],
        );
        let is_upper = spans.iter().any(|s| s.hi == p.point[usize::from(p.axis)]);
        assert!(n.dot(&e) * if is_upper { 1.0 } else { -1.0 } >= -1e-4, "{p:?} {spans:?}");
    }
}
