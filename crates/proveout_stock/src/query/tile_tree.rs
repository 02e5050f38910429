//! Boxes round the material, tile by tile and over more and more tiles: so that a search for what is near
//! need not look at every ray.
//!
//! ```text
//!   level 2 (root)   .----------------.
//!   level 1          |  .---. .----.  |     four boxes of the level below in one
//!   level 0: tiles   |  |__ | | _  |  |     8 x 8 rays: their place, lowest and highest end
//!                    '----------------'
//! ```
//!
//! Each ray set has a tree of its own. A box is the smallest one that holds the intervals of its rays, in the
//! frame of the stock; it is empty where nothing is left. Nothing is kept of the intervals themselves: they
//! are read from the stock, of which a tree follows only the tiles that were cut since it was
//! [refreshed](TileTree::refresh).

use proveout_geom::{Aabb, Point};

use crate::{
    field::dexel::TriDexel,
    field::grid::{RayGrid, TILE, TILE_RAYS},
};

/// One level of the tree of a set.
#[derive(Clone, Debug)]
struct TreeLevel {
    /// Boxes along u and v.
    n: [usize; 2],
    boxes: Vec<Aabb>,
}

/// Boxes of the tiles of a stock, see the text of the file. Frame of the stock, mm.
#[derive(Clone, Debug)]
pub struct TileTree {
    /// From the tiles up to the root, for each ray set.
    sets: [Vec<TreeLevel>; 3],
    /// The pass over the stock that was seen last.
    seen: u32,
}

/// A box of a [`TileTree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileNode {
    set: u8,
    level: u8,
    index: u32,
}

/// Material on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySegment {
    /// Direction of the ray: 0 x, 1 y, 2 z.
    pub axis: usize,
    /// Lower end.
    pub lo: Point,
    /// Upper end.
    pub hi: Point,
}

impl TileTree {
    /// The boxes of a stock in its present state.
    pub fn new(stock: &TriDexel) -> Self {
        let level = |n: [usize; 2]| TreeLevel { n, boxes: vec![Aabb::empty(); n[0] * n[1]] };
        let sets = [0, 1, 2].map(|a| {
            let mut levels = vec![level(stock.grid.tiles[a])];
            while let Some(n) = levels.last().map(|l| l.n).filter(|n| n[0] * n[1] > 1) {
                levels.push(level(n.map(|k| k.div_ceil(2))));
            }
            levels
        });
        let mut tree = Self { sets, seen: 0 };
        tree.take(stock, |_| true);
        tree
    }

    /// Takes over what was cut since the tree was made or refreshed, at the cost of the tiles that were. The
    /// stock must be the one that it was made of; a tree that is not refreshed holds more than is left, never
    /// less.
    pub fn refresh(&mut self, stock: &TriDexel) {
        let seen = self.seen;
        if seen != stock.passes {
            self.take(stock, |tile| stock.cut_in[tile] > seen);
        }
    }

    fn take(&mut self, stock: &TriDexel, changed: impl Fn(usize) -> bool) {
        self.seen = stock.passes;
        for (a, levels) in self.sets.iter_mut().enumerate() {
            let first = stock.grid.first_tile[a];
            let mut dirty: Vec<usize> =
                (0..stock.grid.first_tile[a + 1] - first).filter(|k| changed(first + k)).collect();
            for &k in &dirty {
                levels[0].boxes[k] = box_of_tile(stock, first + k);
            }
            for l in 1..levels.len() {
                let (below, above) = levels.split_at_mut(l);
                let (below, above) = (&below[l - 1], &mut above[0]);
                let parent = |k: usize| k / below.n[0] / 2 * above.n[0] + k % below.n[0] / 2;
                dirty = dirty.into_iter().map(parent).collect();
                dirty.sort_unstable();
                dirty.dedup();
                for &k in &dirty {
                    above.boxes[k] =
                        below.children(k, above.n[0]).fold(Aabb::empty(), |all, child| all.union(&below.boxes[child]));
                }
            }
        }
    }

    /// The boxes round the material of each set.
    pub fn roots(&self) -> [TileNode; 3] {
        [0, 1, 2].map(|a| TileNode { set: a as u8, level: (self.sets[a].len() - 1) as u8, index: 0 })
    }

    /// The box; empty where no material is left.
    pub fn bounds(&self, node: TileNode) -> &Aabb {
        &self.sets[usize::from(node.set)][usize::from(node.level)].boxes[node.index as usize]
    }

    /// True for the box of one tile, which has no children.
    pub fn is_tile(&self, node: TileNode) -> bool {
        node.level == 0
    }

    /// The boxes in it that hold material.
    pub fn children(&self, node: TileNode) -> impl Iterator<Item = TileNode> + '_ {
        let levels = &self.sets[usize::from(node.set)];
        let level = usize::from(node.level);
        let below = level.checked_sub(1).map(|l| &levels[l]);
        let of = below
            .into_iter()
            .flat_map(move |l| l.children(node.index as usize, levels[level].n[0]).map(move |k| (l, k)));
        of.filter(|(l, k)| !l.boxes[*k].is_empty()).map(move |(_, k)| TileNode {
            set: node.set,
            level: node.level - 1,
            index: k as u32,
        })
    }

    /// Calls with the material on the rays of a tile that may meet a box.
    pub fn segments(&self, stock: &TriDexel, tile: TileNode, near: &Aabb, mut see: impl FnMut(RaySegment)) {
        let axis = usize::from(tile.set);
        let index = stock.grid.first_tile[axis] + tile.index as usize;
        if tile.level != 0 || index >= stock.grid.first_tile[axis + 1] {
            return;
        }
        let rays = &stock.tiles[index];
        let (_, [i0, j0]) = stock.grid.tile_place(index);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for r in 0..TILE_RAYS {
            let spans = rays.ray(r);
            if spans.is_empty() {
                continue;
            }
            let at = [stock.grid.center(u, i0 + r % TILE), stock.grid.center(v, j0 + r / TILE)];
            if at[0] < near.min[u] || at[0] > near.max[u] || at[1] < near.min[v] || at[1] > near.max[v] {
                continue;
            }
            for span in spans.iter().filter(|s| s.hi >= near.min[axis] && s.lo <= near.max[axis]) {
                let point = |s: f64| RayGrid::point(axis, s, at[0], at[1]);
                see(RaySegment { axis, lo: point(span.lo), hi: point(span.hi) });
            }
        }
    }

    /// Memory in use, bytes.
    pub fn memory_bytes(&self) -> u64 {
        self.sets.iter().flatten().map(|l| (l.boxes.capacity() * size_of::<Aabb>()) as u64).sum()
    }
}

impl TreeLevel {
    /// Boxes of this level in box `k` of the one above, which has `above` of them along u.
    fn children(&self, k: usize, above: usize) -> impl Iterator<Item = usize> + use<> {
        let [nu, nv] = self.n;
        let (i, j) = (2 * (k % above), 2 * (k / above));
        [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)]
            .into_iter()
            .filter(move |(i, j)| *i < nu && *j < nv)
            .map(move |(i, j)| j * nu + i)
    }
}

fn box_of_tile(stock: &TriDexel, index: usize) -> Aabb {
    let tile = &stock.tiles[index];
    let mut all = Aabb::empty();
    if tile.is_empty() {
        return all;
    }
    let (a, [i0, j0]) = stock.grid.tile_place(index);
    for r in (0..TILE_RAYS).filter(|r| !tile.ray(*r).is_empty()) {
        let at = [stock.grid.center((a + 1) % 3, i0 + r % TILE), stock.grid.center((a + 2) % 3, j0 + r / TILE)];
        all.grow(&RayGrid::point(a, tile.lo, at[0], at[1]));
        all.grow(&RayGrid::point(a, tile.hi, at[0], at[1]));
    }
    all
}

#[cfg(test)]
mod tests {
    use proveout_geom::{ToolPose, Vector};
    use proveout_tool::{Profile, Segment};

    use super::*;
    use crate::{Action, SweepItem, SweepMotion};

    fn pin() -> Profile {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 30.0], [0.0, 30.0]];
        Profile::new(corners.windows(2).map(|w| Segment::Line { from: w[0], to: w[1] }).collect()).expect("a cylinder")
    }

    /// All material under a node, by walking down.
    fn under(tree: &TileTree, stock: &TriDexel, node: TileNode, out: &mut Vec<RaySegment>) {
        let all = Aabb { min: Point::from([-1e9; 3]), max: Point::from([1e9; 3]) };
        tree.segments(stock, node, &all, |s| {
            for p in [s.lo, s.hi] {
                assert!(tree.bounds(node).contains(&p));
            }
            out.push(s);
        });
        for child in tree.children(node) {
            let (outer, inner) = (*tree.bounds(node), *tree.bounds(child));
            assert!(outer.contains(&inner.min) && outer.contains(&inner.max));
            under(tree, stock, child, out);
        }
    }

    #[test]
    fn a_refreshed_tree_is_that_of_the_stock_and_holds_every_interval_once() {
        let bounds = Aabb { min: Point::new(-1.0, 0.0, 2.0), max: Point::new(40.0, 17.3, 9.0) };
        let mut stock = TriDexel::from_box(&bounds, [0.5, 0.4, 0.3], 1 << 30).expect("stock");
        let mut tree = TileTree::new(&stock);
        let body = pin();
        for k in 0..12_u32 {
            let x = 3.0 * f64::from(k);
            let at = |y: f64| ToolPose { tip: Point::new(x, y, 9.5 - f64::from(k)), axis: Vector::z() };
            let motion = SweepMotion { from: at(-5.0), to: at(25.0) };
            let before = tree.seen;
            stock.sweep(&[SweepItem { id: k, body: &body, action: Action::Probe, motion }]);
            tree.refresh(&stock);
            assert_eq!(tree.seen, before, "a probe changes nothing");
            stock.sweep(&[SweepItem { id: k, body: &body, action: Action::Remove, motion }]);
            tree.refresh(&stock);
            let anew = TileTree::new(&stock);
            for (mine, fresh) in tree.sets.iter().flatten().zip(anew.sets.iter().flatten()) {
                assert_eq!(mine.boxes.len(), fresh.boxes.len());
                assert!(mine.boxes.iter().zip(&fresh.boxes).all(|(a, b)| a == b || a.is_empty() && b.is_empty()));
            }
        }
        let mut found = Vec::new();
        for root in tree.roots() {
            under(&tree, &stock, root, &mut found);
        }
        assert_eq!(2 * found.len(), stock.surface_points().count());
        let length: f64 = found.iter().filter(|s| s.axis == 0).map(|s| s.hi.x - s.lo.x).sum();
        assert!((length * 0.4 * 0.3 - stock.volume_along(0)).abs() < 1e-6 * stock.volume());
    }

    #[test]
    fn a_stock_that_is_gone_has_empty_boxes() {
        let bounds = Aabb { min: Point::origin(), max: Point::new(1.0, 1.0, 1.0) };
        let mut stock = TriDexel::from_box(&bounds, 0.5, 1 << 30).expect("stock");
        let mut tree = TileTree::new(&stock);
        let at = |y: f64| ToolPose { tip: Point::new(0.5, y, -1.0), axis: Vector::z() };
        let motion = SweepMotion { from: at(-5.0), to: at(5.0) };
        stock.sweep(&[SweepItem { id: 1, body: &pin(), action: Action::Remove, motion }]);
        assert!(stock.is_empty());
        tree.refresh(&stock);
        assert!(tree.roots().iter().all(|r| tree.bounds(*r).is_empty() && tree.children(*r).count() == 0));
    }
}
