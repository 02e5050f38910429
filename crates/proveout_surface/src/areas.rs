//! Gouged areas, and areas with material left, one by one.
//!
//! Points of the surface that are too deep (or too high), and both ends of gaps on rays, are put into the
//! cells of the stock. What lies in neighboring cells, or on both ends of one gap, is one area.
//!
//! *Why neighboring cells are enough.* In cells as unit of length take the set of rays a whose direction
//! comes nearest to the normal n of the surface: |`n_a`| >= |`n_u`|, |`n_v`|. From one of its rays to the
//! next the surface rises by |`n_u` / `n_a`| <= 1 at most, so that the next point lies at most one cell
//! farther along each axis: points side by side on a surface fall into cells that touch. Two surfaces nearer
//! to each other than a cell count as one.
//!
//! **Volume.** Each set of rays gives a volume `V_a`: length of its gaps times the area `A_a` of its rays.
//! The set that sees the area from the front knows it best (a shallow gouge may lie between all the rays that
//! run along it), so the three are weighed with the square of the area `n_a` `A_a` that their rays see.
//! Without intervals of the design (a face in closed form) it is the sum of depth times area over the points.
//!
//! **Area** is that of the design's surface where a gap begins: each end of an interval of the design
//! represents `A_a`
//! `n_a`| (see [`crate::Deviation`]). Without intervals of the design it is that of the points.
//!
//! **Memory.** Where more than [`MOST_CELLS`] cells are touched, cells of twice the edge are taken, until
//! they are few enough. That depends on all points together and on nothing else.

use std::collections::HashMap;

use proveout_geom::{Aabb, Point};

/// Cells at most: 30 MB.
pub const MOST_CELLS: usize = 1 << 18;
/// Worst points of an area that are remembered.
pub const MOST_STARTS: usize = 24;
/// Bits of a cell's number along an axis.
const BITS: u32 = 20;
/// Cells that numbers begin below the corner: points may lie a little outside.
const BELOW: f64 = 4.0;
/// Cells along the shorter side from which on missing foil may be more than the tip of a wedge.
const FOIL_CELLS: u32 = 3;
/// The same in tolerances: a wedge of 3 degrees is thinner than the tolerance over 19 of them.
const FOIL_TOLERANCES: f64 = 20.0;

/// A part of the surface with cells of its own: the stock, or a patch of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaPart {
    /// Lower corner of its cells, mm.
    pub corner: Point,
    /// Their edges, mm.
    pub cells: [f64; 3],
    /// Where it counts; none for the stock itself.
    pub window: Option<Aabb>,
}

/// What is put into a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seed {
    /// Depth or height, mm.
    pub depth: f64,
    /// Where, mm.
    pub point: Point,
    /// The motion that made it.
    pub made_by: Option<u32>,
    /// Area of the design's surface, mm².
    pub design_area: f64,
    /// Area of the cut surface, mm².
    pub cut_area: f64,
    /// Set and length of the gap that begins here, mm, and area that its ray represents, mm².
    pub gap: Option<(usize, f64, f64)>,
    /// Thickness of the wall that is gone, mm.
    pub wall: Option<f64>,
    /// Part of a wall that is gone and no thicker than allowed.
    pub foil: bool,
}

/// One connected area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Largest depth or height, mm.
    pub depth: f64,
    /// Where, mm.
    pub point: Point,
    /// The motion that made that point, as far as the stock knows.
    pub made_by: Option<u32>,
    /// Area, mm².
    pub area: f64,
    /// Volume that is missing or left, mm³.
    pub volume: f64,
    /// Largest thickness of a wall that is gone, mm.
    pub wall: Option<f64>,
    /// Nothing of it is deeper than allowed: a wall thinner than the tolerance is gone.
    pub foil: bool,
}

/// Where the exact worst place of an area may lie: the worst points of its cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Starts {
    /// Points with depth (or height) and maker, the worst first, at most [`MOST_STARTS`].
    pub points: Vec<(f64, Point, u32)>,
    /// Part of it is the skin of the raw stock.
    pub raw: bool,
}

#[derive(Clone, Copy, Debug)]
struct AreaNode {
    depth: f64,
    point: Point,
    made_by: Option<u32>,
    design_area: f64,
    cut_area: f64,
    /// Sum of depth times area of the cut surface.
    layer: f64,
    volume: [f64; 3],
    seen: [f64; 3],
    wall: Option<f64>,
    foil: bool,
    /// A motion known for any point of it.
    any_maker: Option<u32>,
    /// A point of it is skin of the raw stock.
    raw: bool,
}

impl Default for AreaNode {
    fn default() -> Self {
        Self {
            depth: f64::NEG_INFINITY,
            point: Point::origin(),
            made_by: None,
            design_area: 0.0,
            cut_area: 0.0,
            layer: 0.0,
            volume: [0.0; 3],
            seen: [0.0; 3],
            wall: None,
            foil: true,
            any_maker: None,
            raw: false,
        }
    }
}

impl AreaNode {
    fn take(&mut self, other: &Self) {
        // What is no foil counts before foil.
        let deeper = (!other.foil, other.depth) > (!self.foil, self.depth);
        if deeper {
            (self.depth, self.point, self.made_by) = (other.depth, other.point, other.made_by);
        }
        self.foil &= other.foil;
        self.design_area += other.design_area;
        self.cut_area += other.cut_area;
        self.layer += other.layer;
        for a in 0..3 {
            self.volume[a] += other.volume[a];
            self.seen[a] += other.seen[a];
        }
        self.wall = match (self.wall, other.wall) {
            (Some(x), Some(y)) => Some(x.max(y)),
            (x, y) => x.or(y),
        };
        self.any_maker = self.any_maker.or(other.any_maker);
        self.raw |= other.raw;
    }
}

/// Gathers points and gaps, which come in a fixed order, into areas.
#[derive(Debug)]
pub struct Areas {
    parts: Vec<AreaPart>,
    /// Missing foil shorter than this is none, mm.
    foil: f64,
    /// Edge of the cells taken, in powers of two of those of the parts.
    level: u32,
    most: usize,
    cells: HashMap<u64, u32>,
    nodes: Vec<(u64, AreaNode)>,
    parent: Vec<u32>,
}

impl Areas {
    /// Nothing yet; the first part is the stock. `tolerance` is what is allowed, mm.
    pub fn new(parts: Vec<AreaPart>, tolerance: f64) -> Self {
        Self::with_most(parts, tolerance, MOST_CELLS)
    }

    fn with_most(parts: Vec<AreaPart>, tolerance: f64, most: usize) -> Self {
        Self {
            parts,
            foil: FOIL_TOLERANCES * tolerance,
            level: 0,
            most,
            cells: HashMap::new(),
            nodes: Vec::new(),
            parent: Vec::new(),
        }
    }

    fn key(&self, part: usize, p: &Point) -> u64 {
        let AreaPart { corner, cells, .. } = self.parts[part];
        let most = f64::from((1_u32 << BITS) - 1);
        let along = |k: usize| (((p[k] - corner[k]) / cells[k]).floor() + BELOW).clamp(0.0, most) as u64 >> self.level;
        (part as u64) << (3 * BITS) | along(0) << (2 * BITS) | along(1) << BITS | along(2)
    }

    /// Puts something into the cell of its point.
    pub fn add(&mut self, part: usize, seed: &Seed) {
        let key = self.key(part, &seed.point);
        let next = self.nodes.len() as u32;
        let index = *self.cells.entry(key).or_insert(next);
        if index == next {
            self.nodes.push((key, AreaNode::default()));
            self.parent.push(next);
        }
        let mut one = AreaNode {
            depth: seed.depth,
            point: seed.point,
            made_by: seed.made_by,
            design_area: seed.design_area,
            cut_area: seed.cut_area,
            layer: seed.cut_area * seed.depth,
            wall: seed.wall,
            foil: seed.foil,
            any_maker: seed.made_by,
            raw: seed.made_by.is_none() && seed.cut_area > 0.0,
            ..AreaNode::default()
        };
        if let Some((set, length, area)) = seed.gap {
            (one.volume[set], one.seen[set]) = (length * area, area);
        }
        self.nodes[index as usize].1.take(&one);
        if self.nodes.len() > self.most {
            self.coarsen();
        }
    }

    /// Joins the cells of two points of a part to one area; nothing happens where one of them was not added.
    pub fn join(&mut self, part: usize, a: &Point, b: &Point) {
        let node = |p: &Point| self.cells.get(&self.key(part, p)).copied();
        if let (Some(a), Some(b)) = (node(a), node(b)) {
            self.unite(a, b);
        }
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    fn root(&mut self, mut node: u32) -> u32 {
        while self.parent[node as usize] != node {
            let above = self.parent[self.parent[node as usize] as usize];
            self.parent[node as usize] = above;
            node = above;
        }
        node
    }

    /// Takes cells of twice the edge until there is room.
    fn coarsen(&mut self) {
        while self.nodes.len() > self.most {
            self.level += 1;
            let roots: Vec<u32> = (0..self.nodes.len() as u32).map(|n| self.root(n)).collect();
            let half = |key: u64| {
                let mask = (1_u64 << BITS) - 1;
                let axis = |k: u32| (key >> (k * BITS) & mask) >> 1;
                (key >> (3 * BITS)) << (3 * BITS) | axis(2) << (2 * BITS) | axis(1) << BITS | axis(0)
            };
            let old = std::mem::take(&mut self.nodes);
            self.cells.clear();
            self.parent.clear();
            let mut new_of = Vec::with_capacity(old.len());
            for (key, node) in &old {
                let key = half(*key);
                let next = self.nodes.len() as u32;
                let index = *self.cells.entry(key).or_insert(next);
                if index == next {
                    self.nodes.push((key, AreaNode::default()));
                    self.parent.push(next);
                }
                self.nodes[index as usize].1.take(node);
                new_of.push(index);
            }
            for (n, root) in roots.into_iter().enumerate() {
                self.unite(new_of[n], new_of[root as usize]);
            }
        }
    }

    /// Joins cells that touch; those of different parts where a part ends.
    fn join_neighbors(&mut self) {
        let mask = (1_u64 << BITS) - 1;
        let around = |key: u64, d: [i64; 3]| -> Option<u64> {
            let mut out = key >> (3 * BITS);
            for (k, d) in d.into_iter().enumerate() {
                let moved = (key >> ((2 - k as u32) * BITS) & mask).checked_add_signed(d)?;
                if moved > mask {
                    return None;
                }
                out = out << BITS | moved;
            }
            Some(out)
        };
        let steps: Vec<[i64; 3]> = (0..27).map(|i| [i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1]).collect();
        for n in 0..self.nodes.len() {
            let key = self.nodes[n].0;
            // Half of the neighbors: the other half finds this cell.
            for d in &steps[14..] {
                if let Some(&other) = around(key, *d).and_then(|k| self.cells.get(&k)) {
                    self.unite(n as u32, other);
                }
            }
        }
        if self.parts.len() < 2 {
            return;
        }
        // At the faces of the windows, in cells of the stock.
        let mut border: HashMap<u64, u32> = HashMap::new();
        let reach = f64::from(1_u32 << self.level) * self.parts[0].cells.into_iter().fold(0.0, f64::max);
        for n in 0..self.nodes.len() {
            let node = self.nodes[n].1;
            let near = |w: &Aabb| w.expanded(reach).contains(&node.point) && !w.expanded(-reach).contains(&node.point);
            if !self.parts.iter().filter_map(|p| p.window.as_ref()).any(near) {
                continue;
            }
            let coarse = self.key(0, &node.point);
            for other in steps.iter().filter_map(|d| border.get(&around(coarse, *d)?).copied()).collect::<Vec<_>>() {
                self.unite(n as u32, other);
            }
            border.entry(coarse).or_insert(n as u32);
        }
    }

    /// The areas, the deepest first; among equals by place.
    pub fn finish(self) -> Vec<Area> {
        self.finish_with_starts().into_iter().map(|(area, _)| area).collect()
    }

    /// The same, with the places from which their worst may be searched between the rays
    /// ([`crate::refined`]).
    pub fn finish_with_starts(mut self) -> Vec<(Area, Starts)> {
        self.join_neighbors();
        let mut of_root: HashMap<u32, usize> = HashMap::new();
        let edge = f64::from(1_u32 << self.level);
        let (foil, parts) = (self.foil, self.parts.clone());
        let mut sums: Vec<(AreaNode, Extent, Starts)> = Vec::new();
        let mask = (1_u64 << BITS) - 1;
        for n in 0..self.nodes.len() {
            let root = self.root(n as u32);
            let next = sums.len();
            let index = *of_root.entry(root).or_insert(next);
            if index == next {
                sums.push((AreaNode::default(), Extent::default(), Starts::default()));
            }
            let (key, node) = &self.nodes[n];
            sums[index].0.take(node);
            if let Some(maker) = node.made_by.filter(|_| !node.foil && node.depth > 0.0) {
                sums[index].2.add(node.depth, node.point, maker);
            }
            let cells = parts[(key >> (3 * BITS)) as usize].cells;
            let at = [2, 1, 0].map(|k| (key >> (k * BITS) & mask) as f64);
            sums[index].1.grow([0, 1, 2].map(|k| at[k] * edge * cells[k]), cells.map(|c| c * edge));
        }
        let mut areas: Vec<(Area, Starts)> = sums
            .into_iter()
            .filter(|(node, extent, _)| !node.foil || extent.is_wide(foil))
            .map(|(node, _, starts)| {
                let weight = node.seen.map(|s| s * s);
                let total: f64 = weight.iter().sum();
                let by_rays = (0..3).map(|a| weight[a] * node.volume[a]).sum::<f64>() / total;
                let area = Area {
                    depth: node.depth,
                    point: node.point,
                    made_by: node.made_by.or(node.any_maker),
                    area: if node.design_area > 0.0 { node.design_area } else { node.cut_area },
                    volume: if total > 0.0 { by_rays } else { node.layer },
                    wall: node.wall,
                    foil: node.foil,
                };
                (area, Starts { raw: node.raw, ..starts })
            })
            .collect();
        let place = |a: &Area| [a.point.x, a.point.y, a.point.z];
        areas.sort_by(|(a, _), (b, _)| {
            let by_place = place(a).into_iter().zip(place(b)).map(|(x, y)| x.total_cmp(&y)).find(|o| o.is_ne());
            b.depth.total_cmp(&a.depth).then(by_place.unwrap_or(std::cmp::Ordering::Equal))
        });
        areas
    }
}

impl Starts {
    /// Keeps the worst; among equals the first.
    fn add(&mut self, depth: f64, point: Point, maker: u32) {
        let place = self.points.partition_point(|p| p.0 >= depth);
        if place < MOST_STARTS {
            self.points.insert(place, (depth, point, maker));
            self.points.truncate(MOST_STARTS);
        }
    }
}

/// Box of the cells of an area, mm.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: [f64; 3],
    high: [f64; 3],
    /// Longest cell of it along each axis.
    cells: [f64; 3],
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], cells: [0.0; 3] }
    }
}

impl Extent {
    fn grow(&mut self, at: [f64; 3], cells: [f64; 3]) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(at[k]);
            self.high[k] = self.high[k].max(at[k] + cells[k]);
            self.cells[k] = self.cells[k].max(cells[k]);
        }
    }

    /// Whether it spans some cells, and `least` mm, in two directions at least.
    fn is_wide(&self, least: f64) -> bool {
        let wide = |k: usize| self.high[k] - self.low[k] >= least.max((f64::from(FOIL_CELLS) - 0.5) * self.cells[k]);
        (0..3).filter(|&k| wide(k)).count() >= 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part() -> AreaPart {
        AreaPart { corner: Point::origin(), cells: [0.5; 3], window: None }
    }

    fn seed(x: f64, y: f64, depth: f64) -> Seed {
        Seed { depth, point: Point::new(x, y, 0.1), made_by: Some(x as u32), cut_area: 0.25, ..Seed::default() }
    }

    /// Two squares a row of cells apart, and a long one bound to the first by a gap.
    fn fill(areas: &mut Areas, order: &[usize]) {
        for &k in order {
            let (i, j) = ((k % 4) as f64, (k / 4) as f64);
            areas.add(0, &seed(1.0 + 0.5 * i, 1.0 + 0.5 * j, 0.1 + 0.01 * i));
            areas.add(0, &seed(4.0 + 0.5 * i, 1.0 + 0.5 * j, 0.3 + 0.01 * j));
        }
        let (a, b) = (seed(1.0, 9.0, 0.2), seed(1.0, 1.0, 0.05));
        areas.add(0, &a);
        areas.add(0, &b);
        areas.join(0, &a.point, &b.point);
    }

    #[test]
    fn neighboring_cells_and_the_ends_of_a_gap_are_one_area() {
        let order: Vec<usize> = (0..16).collect();
        let mut areas = Areas::new(vec![part()], 0.03);
        fill(&mut areas, &order);
        let found = areas.finish();
        assert_eq!(found.len(), 2);
        assert!((found[0].depth - 0.33).abs() < 1e-12 && (found[0].area - 4.0).abs() < 1e-12);
        assert_eq!(found[0].point, Point::new(4.0, 2.5, 0.1), "the first of the deepest");
        assert_eq!((found[1].depth, found[1].made_by), (0.2, Some(1)));
        assert!((found[1].area - 4.5).abs() < 1e-12);
        // Depth times area, as no ray was compared.
        let layer: f64 = (0..16).map(|k| 0.25 * (0.1 + 0.01 * f64::from(k % 4))).sum::<f64>() + 0.25 * 0.25;
        assert!((found[1].volume - layer).abs() < 1e-12);
    }

    #[test]
    fn too_many_cells_are_gathered_in_larger_ones_whatever_the_order() {
        let run = |order: &[usize]| {
            let mut areas = Areas::with_most(vec![part()], 0.03, 12);
            fill(&mut areas, order);
            assert!(areas.nodes.len() <= 12 && areas.level > 0);
            (areas.level, areas.finish().len())
        };
        let forth: Vec<usize> = (0..16).collect();
        let back: Vec<usize> = (0..16).rev().collect();
        assert_eq!(run(&forth), run(&back));
        let sum = |most: usize| {
            let mut areas = Areas::with_most(vec![part()], 0.03, most);
            fill(&mut areas, &forth);
            areas.finish().iter().map(|a| a.area).sum::<f64>()
        };
        assert!((sum(12) - sum(1000)).abs() < 1e-12, "nothing is lost");
    }

    #[test]
    fn missing_foil_counts_where_it_spans_more_than_the_edge_of_a_wedge() {
        let foil = |x: f64, y: f64| Seed { foil: true, wall: Some(0.02), ..seed(x, y, 0.02) };
        let mut edge = Areas::new(vec![part()], 0.03);
        (0..40).for_each(|k| {
            edge.add(0, &foil(1.0 + 0.5 * f64::from(k), 1.0));
        });
        assert!(edge.finish().is_empty());
        let mut wall = Areas::new(vec![part()], 0.03);
        (0..40).for_each(|k| {
            wall.add(0, &foil(1.0 + 0.5 * f64::from(k % 10), 1.0 + 0.5 * f64::from(k / 10)));
        });
        let found = wall.finish();
        assert!(found.len() == 1 && found[0].foil && found[0].wall == Some(0.02));
        // Next to something deep it is part of that, and does not set its depth.
        let mut both = Areas::new(vec![part()], 0.03);
        both.add(0, &foil(1.0, 1.0));
        both.add(0, &Seed { depth: 0.01, ..seed(1.5, 1.0, 0.01) });
        assert_eq!(both.finish().iter().map(|a| (a.depth, a.foil)).collect::<Vec<_>>(), [(0.01, false)]);
    }

    #[test]
    fn the_set_that_sees_an_area_from_the_front_gives_its_volume() {
        let mut areas = Areas::new(vec![part()], 0.03);
        for k in 0..100 {
            let (x, y) = (f64::from(k % 10), f64::from(k / 10));
            let gap = Some((2, 0.3, 0.25));
            areas.add(0, &Seed { gap, ..seed(2.0 + 0.5 * x, 2.0 + 0.5 * y, 0.3) });
        }
        // Rays along it: one layer of them, which represents a whole cell of depth.
        (0..10).for_each(|y| {
            areas.add(0, &Seed { gap: Some((0, 5.0, 0.25)), ..seed(2.0, 2.0 + 0.5 * f64::from(y), 0.1) });
        });
        let found = areas.finish();
        let truth = 25.0 * 0.3;
        assert!(found.len() == 1 && (found[0].volume / truth - 1.0).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn areas_go_on_across_the_face_of_a_patch() {
        let window = Aabb { min: Point::new(5.0, -1.0, -1.0), max: Point::new(9.0, 9.0, 9.0) };
        let fine = AreaPart { corner: Point::origin(), cells: [0.1; 3], window: Some(window) };
        let mut areas = Areas::new(vec![part(), fine], 0.03);
        for k in 0..8 {
            areas.add(0, &seed(1.25 + 0.5 * f64::from(k), 2.0, 0.1));
        }
        for k in 0..10 {
            areas.add(1, &seed(5.05 + 0.1 * f64::from(k), 2.0, 0.2));
        }
        areas.add(1, &seed(8.05, 8.0, 0.2));
        assert_eq!(areas.finish().len(), 2);
    }
}
