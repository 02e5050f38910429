//! What can be measured on the stock: sections, distances, thicknesses.
//!
//! **On rays** everything is exact: a caliper along an axis reads the ends of one ray. **Between rays** the
//! extracted surface is taken (dual contouring of the exact crossings, see `surface`), whose error on faces
//! is about cell² / 8 of the radius of curvature; [`Probe`] holds it with a grid of its triangles, so that
//! many questions cost one extraction.

use proveout_geom::{Aabb, Point, TriMesh, Vector};

use crate::{field::dexel::TriDexel, query::mesh_error::nearest_on_triangle, query::section, query::section::Outline};

/// The nearest point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnStock {
    /// The point, mm.
    pub point: Point,
    /// Distance, mm: negative where the place lies in material.
    pub distance: f64,
}

/// Wall between two opposed faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StockWall {
    /// Where material begins and ends along the direction, mm.
    pub faces: [Point; 2],
    /// Length of material between them, mm.
    pub thickness: f64,
}

/// The extracted surface of a stock, ready for questions.
#[derive(Clone, Debug)]
pub struct Probe {
    mesh: TriMesh,
    low: Point,
    cell: f64,
    n: [usize; 3],
    /// Triangles of each cell: `start[c]..start[c + 1]` of the list.
    start: Vec<u32>,
    list: Vec<u32>,
}

/// Edge of the cells of the probe, in cells of the stock.
const COARSE: f64 = 4.0;
/// Cells of the probe at most: memory of a fine stock stays bounded.
const MOST_CELLS: f64 = 4e6;
/// Smallest cell of a probe, mm.
const LEAST_CELL_MM: f64 = 1e-6;
/// Part of a cell by which a line is moved aside, off the lattice.
const OFF_LATTICE: f64 = 1e-6;
/// Part of a cell that ranges are wider, so that a crossing on a border is in a cell that is looked at.
const PLAY: f64 = 1e-9;
/// A direction that is shorter is none.
const SHORTEST: f64 = 1e-12;

impl Probe {
    /// Extracts the surface of a stock.
    pub fn new(stock: &TriDexel) -> Self {
        Self::of_mesh(stock.surface().mesh, COARSE * stock.cell_mm())
    }

    /// Asks a closed mesh, such as a design, instead; `cell_mm` is about the size of its smallest features
    /// and bounds only time and memory.
    pub fn of_mesh(mesh: TriMesh, cell_mm: f64) -> Self {
        let bounds =
            if mesh.positions.is_empty() { Aabb { min: Point::origin(), max: Point::origin() } } else { mesh.aabb() };
        let size = bounds.size();
        let mut cell = if cell_mm.is_finite() { cell_mm.max(LEAST_CELL_MM) } else { 1.0 };
        let count = |cell: f64| [0, 1, 2].map(|k| (size[k] / cell).floor().max(0.0) + 1.0);
        while count(cell).iter().product::<f64>() > MOST_CELLS {
            cell *= 1.5;
        }
        let n = count(cell).map(|x| x as usize);
        let mut probe = Self { mesh, low: bounds.min, cell, n, start: Vec::new(), list: Vec::new() };
        let mut start = vec![0_u32; n.iter().product::<usize>() + 1];
        for t in 0..probe.mesh.triangles.len() {
            probe.cells_of(t, |c| start[c + 1] += 1);
        }
        for c in 1..start.len() {
            start[c] += start[c - 1];
        }
        let mut list = vec![0; start.last().map_or(0, |n| *n as usize)];
        let mut cursor = start.clone();
        for t in 0..probe.mesh.triangles.len() {
            probe.cells_of(t, |c| {
                list[cursor[c] as usize] = t as u32;
                cursor[c] += 1;
            });
        }
        (probe.start, probe.list) = (start, list);
        probe
    }

    /// The surface that is asked.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    fn place(&self, p: &Point) -> [usize; 3] {
        [0, 1, 2].map(|k| (((p[k] - self.low[k]) / self.cell).max(0.0) as usize).min(self.n[k] - 1))
    }

    /// Calls with every cell that the box of a triangle meets.
    fn cells_of(&self, t: usize, mut see: impl FnMut(usize)) {
        let [a, b, c] = self.mesh.corners(t);
        let (low, high) = (self.place(&a.inf(&b).inf(&c)), self.place(&a.sup(&b).sup(&c)));
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    see((z * self.n[1] + y) * self.n[0] + x);
                }
            }
        }
    }

    /// The point of the surface that is nearest to a place, and whether the place lies in material; none
    /// without a surface.
    ///
    /// The cells are searched in rings round the place until the next ring is farther than what was found.
    /// The side comes from the number of crossings of a ray from the place, taken where it is not ambiguous.
    pub fn nearest(&self, place: &Point) -> Option<NearestOnStock> {
        if self.mesh.triangles.is_empty() || !place.iter().all(|x| x.is_finite()) {
            return None;
        }
        let home = self.place(place);
        let mut best: Option<(f64, Point)> = None;
        let rings = self.n.into_iter().max().unwrap_or(1);
        // Distance of the place from its cell: rings are counted from there.
        let outside = (0..3)
            .map(|k| {
                let (low, high) = (self.low[k], self.low[k] + self.n[k] as f64 * self.cell);
                (low - place[k]).max(place[k] - high).max(0.0)
            })
            .fold(0.0, f64::max);
        for ring in 0..=rings {
            let reach = ((ring as f64 - 1.0) * self.cell).max(0.0).max(outside);
            if best.is_some_and(|(d, _)| d <= reach && ring > 0) {
                break;
            }
            self.ring(home, ring, |t| {
                let [a, b, c] = self.mesh.corners(t as usize);
                let near = nearest_on_triangle(place, [&a, &b, &c]);
                let d = (near - place).norm();
                if best.is_none_or(|(least, _)| d < least) {
                    best = Some((d, near));
                }
            });
        }
        let (distance, point) = best?;
        Some(NearestOnStock { point, distance: if self.holds(place) { -distance } else { distance } })
    }

    /// Triangles of the cells whose largest index difference from a cell is `ring`.
    fn ring(&self, home: [usize; 3], ring: usize, mut see: impl FnMut(u32)) {
        let range = |k: usize| home[k].saturating_sub(ring)..(home[k] + ring + 1).min(self.n[k]);
        let off = |x: usize, k: usize| x.abs_diff(home[k]);
        for z in range(2) {
            for y in range(1) {
                let edge = off(z, 2) == ring || off(y, 1) == ring;
                for x in range(0) {
                    if edge || off(x, 0) == ring {
                        let c = (z * self.n[1] + y) * self.n[0] + x;
                        self.list[self.start[c] as usize..self.start[c + 1] as usize].iter().for_each(|t| see(*t));
                    }
                }
            }
        }
    }

    /// Whether a place lies in material: by the winding of the surface along a ray in the direction `ASKEW`,
    /// which runs along no face of a machine part.
    fn holds(&self, place: &Point) -> bool {
        self.crossings(place, &Vector::from(ASKEW).normalize())
            .iter()
            .filter(|c| c.0 > 0.0)
            .map(|c| if c.1 { 1 } else { -1 })
            .sum::<i32>()
            > 0
    }

    /// Where a line crosses the surface: distance along the unit direction, and whether it leaves material
    /// there; rising.
    ///
    /// Corners of flat faces lie on a lattice, on which people like to measure: the line is moved aside by a
    /// millionth of a cell, in a direction that meets no such lattice, so that it does not run through
    /// corners and edges.
    fn crossings(&self, from: &Point, way: &Vector) -> Vec<(f64, bool)> {
        let aside = way.cross(&Vector::from(ASIDE)) + way.cross(&Vector::from(ASKEW)) * 0.37;
        let from = &(from + aside * (OFF_LATTICE * self.cell));
        let mut found: Vec<(f64, bool, u32)> = Vec::new();
        self.cells_along(from, way, |c| {
            for &t in &self.list[self.start[c] as usize..self.start[c + 1] as usize] {
                let [a, b, c] = self.mesh.corners(t as usize);
                if let Some((s, leaves)) = crossing(from, way, &a, &b, &c) {
                    found.push((s, leaves, t));
                }
            }
        });
        found.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.2.cmp(&y.2)));
        found.dedup_by_key(|x| x.2);
        found.into_iter().map(|(s, leaves, _)| (s, leaves)).collect()
    }

    /// Cells that a line meets: slab by slab along the axis that it runs along most.
    fn cells_along(&self, from: &Point, way: &Vector, mut see: impl FnMut(usize)) {
        let a = way.iamax();
        let (u, v) = ((a + 1) % 3, (a + 2) % 3);
        for i in 0..self.n[a] {
            let plane = |i: usize| (self.low[a] + i as f64 * self.cell - from[a]) / way[a];
            let ends = [from + way * plane(i), from + way * plane(i + 1)];
            let play = PLAY * self.cell;
            let range = |k: usize| {
                let (low, high) = (ends[0][k].min(ends[1][k]) - play, ends[0][k].max(ends[1][k]) + play);
                let end = self.low[k] + self.n[k] as f64 * self.cell;
                if high < self.low[k] || low > end {
                    return 0..0;
                }
                let index = |x: f64| (((x - self.low[k]) / self.cell).max(0.0) as usize).min(self.n[k] - 1);
                index(low)..index(high) + 1
            };
            for j in range(u) {
                for k in range(v) {
                    let mut place = [0; 3];
                    (place[a], place[u], place[v]) = (i, j, k);
                    see((place[2] * self.n[1] + place[1]) * self.n[0] + place[0]);
                }
            }
        }
    }

    /// Thickness of the wall that a line from `from` along `direction` first goes through, as a
    /// caliper would read it: from the face where it enters material (before `from`, if that lies
    /// in material) to the face where it leaves it. None when it meets no material ahead.
    pub fn wall(&self, from: &Point, direction: &Vector) -> Option<StockWall> {
        let way = direction.try_normalize(SHORTEST)?;
        let mut depth = 0;
        let mut entry = None;
        for (s, leaves) in self.crossings(from, &way) {
            depth += if leaves { -1 } else { 1 };
            if !leaves && depth == 1 {
                entry = Some(s);
            } else if leaves && depth == 0 && s > 0.0 {
                let first: f64 = entry?;
                return Some(StockWall { faces: [from + way * first, from + way * s], thickness: s - first });
            }
        }
        None
    }

    /// The section with the plane through `on` with the unit `normal`: closed outlines, round material and
    /// round holes.
    pub fn section(&self, on: &Point, normal: &Vector) -> Vec<Outline> {
        section::outlines(&self.mesh, on, normal)
    }
}

/// Direction of the ray that separates inside from outside; a face of a part is parallel to it only
/// by chance.
const ASKEW: [f64; 3] = [0.577_193_1, 0.211_377_7, 0.788_911_3];
/// Another one.
const ASIDE: [f64; 3] = [-0.411_913_7, 0.817_733_9, 0.402_117_9];

/// Where a line crosses a triangle, and whether it leaves on its outside (Möller and Trumbore 1997).
fn crossing(from: &Point, way: &Vector, a: &Point, b: &Point, c: &Point) -> Option<(f64, bool)> {
    let (ab, ac) = (b - a, c - a);
    let p = way.cross(&ac);
    let determinant = ab.dot(&p);
    if determinant == 0.0 {
        return None;
    }
    let y = from - a;
    let u = y.dot(&p) / determinant;
    let q = y.cross(&ab);
    let v = way.dot(&q) / determinant;
    if u < 0.0 || v < 0.0 || u + v > 1.0 {
        return None;
    }
    // The determinant is minus the outward normal times the way.
    Some((ac.dot(&q) / determinant, determinant < 0.0))
}

impl TriDexel {
    /// Thickness of the material on the ray along `axis` nearest to a place: of the interval that holds the
    /// place, or else of the first one above it. Exact on the ray; the ray is at most half a cell aside in
    /// each direction.
    ///
    /// ```
    /// use proveout_geom::{Aabb, Point, ToolPose, Vector};
    /// use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
    /// use proveout_tool::Cutter;
    ///
    /// let block = Aabb { min: Point::new(0.0, 0.0, -10.0), max: Point::new(40.0, 20.0, 0.0) };
    /// let mut stock = TriDexel::from_box(&block, 0.5, 1 << 30)?;
    /// let tool = Cutter::flat(8.0)?.bodies(20.0)?.remove(0);
    /// let at = |z: f64| ToolPose { tip: Point::new(20.0, 10.0, z), axis: Vector::z() };
    /// let motion = SweepMotion { from: at(5.0), to: at(-7.0) };
    /// stock.sweep(&[SweepItem { id: 1, body: &tool, action: Action::Remove, motion }]);
    /// let floor = stock.thickness_along(2, &Point::new(20.0, 10.0, -9.0)).expect("material");
    /// assert!((floor.thickness - 3.0).abs() < 1e-3); // mm
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn thickness_along(&self, axis: usize, place: &Point) -> Option<StockWall> {
        let a = axis.min(2);
        let ([u, v], material) = self.intervals_on(a, place[(a + 1) % 3], place[(a + 2) % 3]);
        let wall = material.iter().find(|i| i.hi >= place[a])?;
        let at = |s: f64| crate::field::grid::RayGrid::point(a, s, u, v);
        Some(StockWall { faces: [at(wall.lo), at(wall.hi)], thickness: wall.hi - wall.lo })
    }
}
