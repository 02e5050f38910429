//! Closed meshes of blocks with slots, holes, ribs and cavities (a grid of boxes, some of them empty), and of
//! convex bars.

use std::collections::BTreeMap;

use proveout_geom::{Point, TriMesh};

/// Boxes between the planes of three axes; `filled` says which of them are material.
pub(crate) fn grid_solid(planes: [&[f64]; 3], filled: impl Fn([usize; 3]) -> bool) -> TriMesh {
    let count = planes.map(|p| p.len() - 1);
    let inside =
        |i: [isize; 3]| (0..3).all(|a| i[a] >= 0 && (i[a] as usize) < count[a]) && filled(i.map(|v| v as usize));
    let mut numbers: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    let mut mesh = TriMesh::default();
    for x in 0..count[0] {
        for y in 0..count[1] {
            for z in 0..count[2] {
                if !inside([x as isize, y as isize, z as isize]) {
                    continue;
                }
                for axis in 0..3 {
                    for side in 0..2 {
                        let mut beside = [x as isize, y as isize, z as isize];
                        beside[axis] += if side == 1 { 1 } else { -1 };
                        if inside(beside) {
                            continue;
                        }
                        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
                            let mut at = [x, y, z];
                            at[axis] += side;
                            at[u] += a;
                            at[v] += b;
                            *numbers.entry(at).or_insert_with(|| {
                                mesh.positions.push(Point::new(planes[0][at[0]], planes[1][at[1]], planes[2][at[2]]));
                                mesh.positions.len() as u32 - 1
                            })
                        });
                        let [a, b, c, d] = corners;
                        let quads = if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                        mesh.triangles.extend(quads);
                    }
                }
            }
        }
    }
    mesh
}

/// A bar along X with a convex section, its corners in the plane of Y and Z, counter-clockwise seen against
/// X.
pub(crate) fn convex_bar(from: f64, to: f64, section: &[[f64; 2]]) -> TriMesh {
    let n = section.len() as u32;
    let positions = [from, to].iter().flat_map(|x| section.iter().map(|s| Point::new(*x, s[0], s[1]))).collect();
    let sides = (0..n).flat_map(|i| {
        let j = (i + 1) % n;
        [[i, j, n + j], [i, n + j, n + i]]
    });
    let ends = (1..n - 1).flat_map(|i| [[0, i + 1, i], [n, n + i, n + i + 1]]);
    TriMesh { positions, triangles: sides.chain(ends).collect() }
}
