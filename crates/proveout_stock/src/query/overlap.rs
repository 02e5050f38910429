//! Material inside of a fixed solid.

use proveout_geom::{Point, TriMesh};

use crate::field::dexel::TriDexel;

/// Material in a solid, see [`TriDexel::overlap_with`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidOverlap {
    /// Depth of the overlap, mm.
    pub depth_mm: f64,
    /// Middle of the overlap on the ray that gives the depth.
    pub point: Point,
    /// Volume by the ray set of that ray, mm³.
    pub volume_mm3: f64,
}

impl TriDexel {
    /// Material inside of a closed mesh in the frame of the stock; none where no ray has any. Shells that
    /// cross count as their union.
    ///
    /// ```text
    ///      _________
    ///     |  stock  |____
    ///     |       |/|    |   depth: for each axis the longest overlap on a ray, of these the shortest:
    ///     |_______|_|    |   here that along the rays from left to right
    ///             |______|
    /// ```
    ///
    /// Exact for a face along the axes that sank into another; the way out in that direction, and so at most
    /// too large by the slope, for a face across. An overlap that is thinner than a cell is seen by the rays
    /// across it.
    pub fn overlap_with(&self, solid: &TriMesh) -> Option<SolidOverlap> {
        (0..3).filter_map(|axis| self.overlap_along(solid, axis)).min_by(|x, y| x.depth_mm.total_cmp(&y.depth_mm))
    }

    fn overlap_along(&self, solid: &TriMesh, axis: usize) -> Option<SolidOverlap> {
        let rows = self.rows_of_mesh(solid, axis);
        let mut longest: Option<SolidOverlap> = None;
        let mut sum = 0.0;
        for row in 0..self.rows(axis) {
            let inside = rows.row(row);
            if inside.is_empty() {
                continue;
            }
            for ray in (0..self.tiles_in_row(axis)).flat_map(|tile| self.rays_of_tile(axis, row, tile)) {
                for own in inside.on(&ray) {
                    for material in self.material(&ray) {
                        let (lo, hi) = (own.lo.at.max(material.lo.at), own.hi.at.min(material.hi.at));
                        if hi <= lo {
                            continue;
                        }
                        sum += hi - lo;
                        if longest.is_none_or(|l| hi - lo > l.depth_mm) {
                            let point = ray.point(0.5 * (lo + hi));
                            longest = Some(SolidOverlap { depth_mm: hi - lo, point, volume_mm3: 0.0 });
                        }
                    }
                }
            }
        }
        longest.map(|l| SolidOverlap { volume_mm3: sum * self.grid.ray_area(axis), ..l })
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh};

    use super::*;

    #[test]
    fn the_depth_is_the_way_out() {
        let b = |min: [f64; 3], max: [f64; 3]| Aabb { min: Point::from(min), max: Point::from(max) };
        let stock = TriDexel::from_box(&b([0.0; 3], [20.0, 20.0, 10.0]), 0.5, 1 << 30).expect("stock");
        // A jaw at the side x = 20, sunk in by less than a cell and by more.
        for depth in [0.02, 3.3] {
            let jaw = box_mesh(&b([20.0 - depth, 5.0, -1.0], [40.0, 15.0, 8.0]));
            let found = stock.overlap_with(&jaw).expect("it overlaps the stock");
            assert!((found.depth_mm - depth).abs() < 1e-9, "{found:?}");
            assert!((found.volume_mm3 - depth * 10.0 * 8.0).abs() < 1e-6, "{found:?}");
            assert!((found.point.x - (20.0 - 0.5 * depth)).abs() < 1e-9);
        }
        for apart in [0.0, 0.3] {
            let jaw = box_mesh(&b([20.0 + apart, 5.0, -1.0], [40.0, 15.0, 8.0]));
            assert_eq!(stock.overlap_with(&jaw), None, "next to it, {apart} mm away");
        }
        let within = box_mesh(&b([5.0, 5.0, 2.0], [7.0, 9.0, 8.0]));
        assert!(stock.overlap_with(&within).is_some_and(|o| (o.depth_mm - 2.0).abs() < 1e-9), "wholly inside");
    }
}
