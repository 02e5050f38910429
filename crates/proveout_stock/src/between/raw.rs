//! The raw stock as a body: which balls lie outside of it, which points inside, and its faces near a point.

use proveout_geom::{Aabb, Point, TriMesh, Vector};

use super::mesh_side::MeshSide;
use crate::{TileTree, TriDexel, field::raw_stock::Bar};

/// Cells along the longest side of the grid that represents a stock of which only the rays are
/// known.
const COARSE: f64 = 160.0;

/// What is known of the raw stock between its rays.
#[derive(Clone, Debug)]
pub(super) enum Raw {
    Block(Aabb),
    Bar(Bar),
    Mesh(Box<MeshSide>),
    /// What an earlier run left: its rays, and what may lie between them.
    Rays(RayCells),
}

impl Raw {
    pub(super) fn mesh(mesh: &TriMesh) -> Self {
        Self::Mesh(Box::new(MeshSide::new(mesh)))
    }

    /// True where no material is nearer to a point than `radius`.
    pub(super) fn is_outside(&self, c: &Point, radius: f64) -> bool {
        match self {
            Self::Block(_) | Self::Bar(_) => self.convex_faces(c).any(|(d, _)| d >= radius),
            Self::Mesh(mesh) => mesh.is_outside(c, radius),
            Self::Rays(cells) => cells.is_outside(c, radius),
        }
    }

    /// Whether a point lies at least `depth` below the skin; none where that is not known.
    pub(super) fn is_inside(&self, p: &Point, depth: f64) -> Option<bool> {
        match self {
            Self::Block(_) | Self::Bar(_) => Some(self.convex_faces(p).all(|(d, _)| d <= -depth)),
            Self::Mesh(mesh) => Some(mesh.is_inside(p, depth)),
            Self::Rays(cells) => cells.is_outside(p, 0.0).then_some(false),
        }
    }

    /// True where what lies between the rays is known.
    pub(super) fn is_known(&self) -> bool {
        !matches!(self, Self::Rays(_))
    }

    /// Half spaces that hold all material within a ball: distance of its center beyond each, and the normal.
    pub(super) fn faces(&self, c: &Point, radius: f64) -> Vec<(f64, Vector)> {
        match self {
            Self::Mesh(mesh) => mesh.faces(c, radius),
            _ => self.convex_faces(c).collect(),
        }
    }

    /// Faces of a convex raw stock.
    fn convex_faces(&self, p: &Point) -> impl Iterator<Item = (f64, Vector)> + use<> {
        let mut out = [(f64::NEG_INFINITY, Vector::zeros()); 6];
        let count = match self {
            Self::Block(b) => {
                for a in 0..3 {
                    out[2 * a] = (b.min[a] - p[a], -Vector::ith(a, 1.0));
                    out[2 * a + 1] = (p[a] - b.max[a], Vector::ith(a, 1.0));
                }
                6
            }
            Self::Bar(bar) => {
                let q = p - bar.base;
                let z = q.dot(&bar.axis);
                let across = q - bar.axis * z;
                let r = across.norm();
                out[0] = (-z, -bar.axis);
                out[1] = (z - bar.length, bar.axis);
                out[2] = (r - bar.radius, if r > 1e-12 { across / r } else { Vector::zeros() });
                3
            }
            Self::Mesh(_) | Self::Rays(_) => 0,
        };
        out.into_iter().take(count)
    }
}

/// Cells that may hold material according to the rays of a stock: all within a diagonal of one of
/// its cells of material on a ray (the text of the stock's check against bodies says why).
#[derive(Clone, Debug)]
pub(super) struct RayCells {
    low: Point,
    edge: f64,
    n: [usize; 3],
    /// Number of cells that may hold material below and before each corner of the grid.
    sums: Vec<u32>,
}

impl RayCells {
    pub(super) fn new(stock: &TriDexel) -> Self {
        let [x, y, z] = stock.cells_mm();
        let unseen = Vector::new(x, y, z).norm();
        let bounds = stock.bounds();
        let size = bounds.size();
        let edge = (size.max() / COARSE).max(1e-6);
        let n = [0, 1, 2].map(|a| ((size[a] / edge).ceil() as usize).max(1));
        let index = |i: usize, j: usize, k: usize| (k * n[1] + j) * n[0] + i;
        let mut full = vec![false; n[0] * n[1] * n[2]];
        let cell = |a: usize, s: f64| (((s - bounds.min[a]) / edge).floor().max(0.0) as usize).min(n[a] - 1);
        let tree = TileTree::new(stock);
        let all = bounds.expanded(1.0);
        let mut open: Vec<_> = tree.roots().into_iter().collect();
        while let Some(node) = open.pop() {
            if !tree.is_tile(node) {
                open.extend(tree.children(node));
                continue;
            }
            tree.segments(stock, node, &all, |s| {
                let from = [0, 1, 2].map(|a| cell(a, s.lo[a] - unseen));
                let to = [0, 1, 2].map(|a| cell(a, s.hi[a] + unseen));
                for k in from[2]..=to[2] {
                    for j in from[1]..=to[1] {
                        full[index(from[0], j, k)..=index(to[0], j, k)].fill(true);
                    }
                }
            });
        }
        let m = n.map(|k| k + 1);
        let at = |i: usize, j: usize, k: usize| (k * m[1] + j) * m[0] + i;
        let mut sums = vec![0_u32; m[0] * m[1] * m[2]];
        for k in 0..n[2] {
            for j in 0..n[1] {
                let mut row = 0;
                for i in 0..n[0] {
                    row += u32::from(full[index(i, j, k)]);
                    sums[at(i + 1, j + 1, k + 1)] =
                        row + sums[at(i + 1, j, k + 1)] + sums[at(i + 1, j + 1, k)] - sums[at(i + 1, j, k)];
                }
            }
        }
        Self { low: bounds.min, edge, n, sums }
    }

    fn is_outside(&self, c: &Point, radius: f64) -> bool {
        let mut range = [[0; 3]; 2];
        for a in 0..3 {
            let from = ((c[a] - radius - self.low[a]) / self.edge).floor();
            let to = ((c[a] + radius - self.low[a]) / self.edge).floor() + 1.0;
            if !(to > 0.0 && from < self.n[a] as f64) {
                return true;
            }
            range[0][a] = from.max(0.0) as usize;
            range[1][a] = (to as usize).min(self.n[a]);
        }
        let [[x0, y0, z0], [x1, y1, z1]] = range;
        let at = |i: usize, j: usize, k: usize| self.sums[(k * (self.n[1] + 1) + j) * (self.n[0] + 1) + i];
        let of_layer = |k: usize| at(x1, y1, k) + at(x0, y0, k) - at(x0, y1, k) - at(x1, y0, k);
        of_layer(z1) == of_layer(z0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_rays_hold_all_material_and_leave_the_rest_out() {
        let bounds = Aabb { min: Point::new(-3.0, 0.0, 2.0), max: Point::new(17.0, 10.0, 9.0) };
        let bar = Point::new(7.0, 5.0, 2.0);
        let stock = TriDexel::from_cylinder(&bar, &Vector::z(), 4.0, 7.0, 0.25, 1 << 30).expect("stock");
        let raw = Raw::Rays(RayCells::new(&stock));
        for k in 0..4000_u32 {
            let t = f64::from(k);
            let p = bounds.min + Vector::new((t * 0.37) % 20.0, (t * 0.53) % 10.0, (t * 0.71) % 7.0);
            let off = (p - bar).xy().norm() - 4.0;
            if off < 0.0 {
                assert!(!raw.is_outside(&p, 0.0), "{p:?}");
            } else if off > 1.2 {
                assert!(raw.is_outside(&p, 0.1), "{p:?} {off}");
            }
        }
        assert!(raw.is_outside(&Point::new(100.0, 0.0, 0.0), 5.0));
        assert_eq!(raw.is_inside(&bar, 0.1), None);
    }
}
