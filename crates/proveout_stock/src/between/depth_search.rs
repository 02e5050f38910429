//! The search for material between the rays: the text of the folder has the reasons.

use proveout_geom::{Aabb, Point, Vector};

use super::{
    BetweenRays, FILM, MOST_WORK_DEEPER,
    moving_body::{FunctionPart, LeastDistance, MovingBody},
};
use crate::kernels::meridian::Meridian;

/// Smallest cube that is looked at, mm: its center decides.
const SMALLEST: f64 = 0.004;
/// Largest half diagonal of a cube that is asked by its half spaces, mm: with few cuts near it, and with
/// more.
const BY_PLANES: [f64; 2] = [8.0, 2.0];
const FEW_CUTS: usize = 256;
/// Cuts that are asked whether they take up what is left, the deepest first.
const MOST_TRIED: usize = 24;
/// Half spaces that are used at once.
const MOST_PLANES: usize = 4;
/// Part of the half diagonal that a cut must be deep at the middle of a cube to be asked at its corners.
const DEEP_ENOUGH: f64 = 0.5;
/// A place is worth another look where it may be deeper by this part.
const DEEPER: f64 = 1.25;
/// Last step of a climb to the deepest place, mm, and the most steps of it.
const LAST_STEP: f64 = 1e-4;
const MOST_STEPS: usize = 200;
/// Points lie on the inner side of faces by so much more, mm.
const ROUNDING: f64 = 1e-9;
/// Most movers whose depth is climbed from one place.
const MOST_CLIMBED: usize = 3;

/// A body that must not meet material.
pub(super) struct Mover<'b> {
    pub body: &'b Meridian,
    pub moving: MovingBody,
    pub bounds: Aabb,
}

/// A cube of the octree over the raw stock.
#[derive(Clone, Copy, Debug)]
struct Cube {
    level: u32,
    at: [u32; 3],
    center: Point,
    edge: f64,
}

impl Cube {
    fn key(&self) -> Option<u64> {
        let [x, y, z] = self.at.map(u64::from);
        (self.level <= 19).then(|| u64::from(self.level) << 57 | x << 38 | y << 19 | z)
    }

    fn bounds(&self) -> Aabb {
        let half = Vector::repeat(0.5 * self.edge);
        Aabb { min: self.center - half, max: self.center + half }
    }

    /// Half its diagonal: no point of it is farther from its center, mm.
    fn radius(&self) -> f64 {
        0.5 * 3.0_f64.sqrt() * self.edge
    }

    fn child(&self, k: u32) -> Self {
        let bit = |a: usize| k >> a & 1;
        let off = Vector::new(f64::from(bit(0)) - 0.5, f64::from(bit(1)) - 0.5, f64::from(bit(2)) - 0.5);
        Self {
            level: self.level + 1,
            at: [0, 1, 2].map(|a| 2 * self.at[a] + bit(a)),
            center: self.center + off * (0.5 * self.edge),
            edge: 0.5 * self.edge,
        }
    }
}

/// A half space that holds what a mover takes up near a point: `value + slope . (x - point) <= 0`.
type HalfSpace = (f64, Vector);

pub(super) struct DepthSearch<'s, 'b> {
    pub store: &'s mut BetweenRays,
    pub movers: &'s [Mover<'b>],
    /// So much smaller are the movers taken, mm.
    pub shrink: f64,
    /// Cubes of this edge end the search: who reaches into them is in doubt, mm.
    pub coarsest: Option<f64>,
    /// Work after which the search gives up.
    pub most: u64,
    pub doubtful: Vec<bool>,
    /// Deepest place of material in a mover.
    pub found: Option<(Point, f64)>,
    /// Where it is not known, and over which length, mm.
    pub open: Option<(Point, f64)>,
}

impl DepthSearch<'_, '_> {
    pub(super) fn run(&mut self) {
        let bounds = self.store.bounds;
        let root = Cube { level: 0, at: [0; 3], center: bounds.center(), edge: bounds.size().max() };
        let all: Vec<u32> = (0..self.movers.len() as u32).collect();
        self.visit(&root, &all, None);
    }

    fn is_over_budget(&self) -> bool {
        self.store.work >= self.most
    }

    fn least(
        &mut self,
        body: &Meridian,
        moving: &MovingBody,
        part: FunctionPart,
        p: &Point,
        wanted: f64,
    ) -> LeastDistance {
        self.store.work += 1;
        moving.least(body, part, p, wanted)
    }

    /// How far a mover has to reach beyond a point to count, mm.
    fn depth(&self) -> f64 {
        self.found.map_or(self.shrink, |(_, depth)| self.shrink.max(DEEPER * depth))
    }

    fn touching(&mut self, cube: &Cube, movers: &[u32]) -> Vec<u32> {
        let (bounds, wanted) = (cube.bounds(), cube.radius() - self.depth());
        let all = self.movers;
        let mut out = Vec::new();
        for &m in movers {
            let mover = &all[m as usize];
            if self.doubtful[m as usize] || !mover.bounds.intersects(&bounds) {
                continue;
            }
            // A mover that lies in the cube as a whole touches it.
            let is_within = bounds.contains(&mover.bounds.min) && bounds.contains(&mover.bounds.max);
            if is_within
                || self.least(mover.body, &mover.moving, FunctionPart::Whole, &cube.center, wanted).bound <= wanted
            {
                out.push(m);
            }
        }
        out
    }

    /// True when the cube is known to hold no material.
    fn visit(&mut self, cube: &Cube, movers: &[u32], cuts: Option<&[u32]>) -> bool {
        let (key, radius) = (cube.key(), cube.radius());
        if key.is_some_and(|k| self.store.is_empty(k)) {
            return true;
        }
        if self.store.raw.is_outside(&cube.center, radius - FILM) {
            self.store.set_empty(key);
            return true;
        }
        let movers = self.touching(cube, movers);
        if movers.is_empty() {
            return false;
        }
        if self.is_over_budget() {
            self.mark_undecided(cube, &movers);
            return false;
        }
        let bounds = cube.bounds();
        let near: Option<Vec<u32>> = match cuts {
            Some(above) => {
                let boxes = &self.store.cuts;
                Some(above.iter().copied().filter(|k| boxes[*k as usize].bounds.intersects(&bounds)).collect())
            }
            None if radius <= self.store.widest || self.store.cuts.is_empty() => {
                let mut near = Vec::new();
                self.store.tree.near(&bounds, 0, &mut near);
                Some(near)
            }
            None => None,
        };
        let (near, movers) = if let Some(near) = near {
            let Some(reaching) = self.reaching(cube, near) else {
                self.store.set_empty(key);
                return true;
            };
            self.store.set_first_untried(key);
            self.test_place(&cube.center, cube, &movers, Some(&reaching));
            let is_asked = radius <= BY_PLANES[usize::from(reaching.len() > FEW_CUTS)];
            let mut left = movers;
            left.retain(|m| !(is_asked && self.is_cleared(*m, cube, &reaching)));
            (Some(reaching), left)
        } else {
            // Over many movers material is asked for in small cubes alone.
            if self.coarsest.is_none() {
                self.test_place(&cube.center, cube, &movers, None);
            }
            (None, movers)
        };
        if movers.is_empty() {
            return false;
        }
        if let Some(coarsest) = self.coarsest.filter(|c| cube.edge <= *c) {
            debug_assert!(coarsest > 0.0);
            movers.iter().for_each(|m| self.doubtful[*m as usize] = true);
            return false;
        }
        if cube.edge <= SMALLEST.max(self.store.unknown_below) {
            if !self.store.raw.is_known() {
                self.mark_undecided(cube, &movers);
            }
            return false;
        }
        let mut empty = true;
        for k in 0..8 {
            empty &= self.visit(&cube.child(k), &movers, near.as_deref());
        }
        if empty {
            self.store.set_empty(key);
        }
        empty
    }

    fn mark_undecided(&mut self, cube: &Cube, movers: &[u32]) {
        movers.iter().for_each(|m| self.doubtful[*m as usize] = true);
        self.open.get_or_insert((cube.center, cube.edge));
    }

    /// Those of `near` that reach into a cube, the one that covers its center deepest first; none if one of
    /// them empties the cube.
    fn reaching(&mut self, cube: &Cube, near: Vec<u32>) -> Option<Vec<u32>> {
        let (radius, tried) = (cube.radius(), cube.key().map_or(0, |k| self.store.first_untried(k)));
        let is_filtered = radius <= BY_PLANES[usize::from(near.len() > FEW_CUTS)];
        let mut reaching: Vec<(f64, u32)> = Vec::new();
        for k in near {
            if !is_filtered && (k as usize) < tried {
                reaching.push((0.0, k));
                continue;
            }
            let Some(depth) = self.depth_of_cut(k, cube) else { continue };
            if depth <= FILM - radius
                || depth < -DEEP_ENOUGH * radius && k as usize >= tried && self.holds_cube(k, cube)
            {
                return None;
            }
            reaching.push((depth, k));
        }
        reaching.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        Some(reaching.into_iter().map(|r| r.1).collect())
    }

    /// About the least value of a cut at the center of a cube; none where it does not reach into the cube.
    /// Where the cut takes up the whole ball round the cube, the value says so; else it is searched only as
    /// far as these answers ask.
    fn depth_of_cut(&mut self, k: u32, cube: &Cube) -> Option<f64> {
        let cut = &self.store.cuts[k as usize];
        let bodies = &self.store.sets[cut.set as usize];
        let (fills, reaches) = (FILM - cube.radius(), cube.radius() + 2.0 * FILM);
        let mut work = 0;
        let mut of = |b: &u32| {
            let mut least = |wanted: f64| {
                work += 1;
                cut.moving.least(&self.store.bodies[*b as usize].1, FunctionPart::Whole, &cube.center, wanted)
            };
            let rough = least(fills);
            let open = rough.bound <= reaches && rough.seen > reaches;
            let known = if open { least(reaches) } else { rough };
            known.seen.min(rough.seen)
        };
        let depth = bodies.iter().map(&mut of).fold(f64::INFINITY, f64::min);
        self.store.work += work;
        (depth <= reaches).then_some(depth)
    }

    /// Whether a cut takes up all corners of a cube.
    fn holds_cube(&mut self, k: u32, cube: &Cube) -> bool {
        let bounds = cube.bounds();
        let corners: Vec<Point> = (0..8).map(|k| corner(&bounds, k)).collect();
        self.holds(k, &corners)
    }

    /// Material at a place of a cube, within a mover. `cuts` are those near the cube, where they are known.
    fn test_place(&mut self, p: &Point, cube: &Cube, movers: &[u32], cuts: Option<&[u32]>) {
        let all = self.movers;
        let depth = self.depth();
        let mut met = Vec::new();
        for &m in movers {
            let mover = &all[m as usize];
            if self.least(mover.body, &mover.moving, FunctionPart::Whole, p, -depth).met.is_some() {
                met.push(m);
            }
        }
        if met.is_empty() || self.store.raw.is_inside(p, FILM) != Some(true) {
            return;
        }
        let uncut = match cuts {
            Some(cuts) => self.store.is_uncut(p, cuts),
            None => self.store.is_uncut(p, &self.store.near(p)),
        };
        if !uncut {
            return;
        }
        if self.store.is_gone(p) {
            self.mark_undecided(cube, &met);
        } else if self.coarsest.is_some() {
            met.iter().for_each(|m| self.doubtful[*m as usize] = true);
        } else {
            self.found = Some(self.climb_to_deepest(p, &met, cube.edge));
            self.most = self.most.min(self.store.work + MOST_WORK_DEEPER);
        }
    }

    /// The deepest place that a climb from a place of material reaches, and its depth in one of some movers.
    fn climb_to_deepest(&mut self, from: &Point, movers: &[u32], edge: f64) -> (Point, f64) {
        let all = self.movers;
        let mut best = (*from, 0.0);
        for &m in movers.iter().take(MOST_CLIMBED) {
            let mover = &all[m as usize];
            let at = |search: &mut Self, p: &Point| {
                -search.least(mover.body, &mover.moving, FunctionPart::Whole, p, f64::NEG_INFINITY).seen
            };
            let mut here = (*from, at(self, from));
            let mut step = (0.5 * edge).max(0.25 * mover.body.radius);
            let mut steps = 0;
            while step > LAST_STEP && steps < MOST_STEPS {
                let mut next = here;
                for way in self.climb_directions(mover, &here.0, step) {
                    let mut p = here.0 + way * step;
                    // Back through the faces that the step has passed.
                    for (d, n) in self.store.raw.faces(&p, step) {
                        if d > -FILM {
                            p -= n * (d + FILM + ROUNDING);
                        }
                    }
                    let depth = at(self, &p);
                    if depth > next.1 && self.store.is_material(&p) == Some(true) {
                        next = (p, depth);
                    }
                }
                if next.1 > here.1 {
                    here = next
                } else {
                    step *= 0.5
                }
                steps += 1;
            }
            if here.1 > best.1 {
                best = here;
            }
        }
        best
    }

    /// Directions that a climb tries: 26 of a lattice, along each near face of the mover and the raw stock,
    /// and along the edges where two of them meet.
    fn climb_directions(&mut self, mover: &Mover<'_>, p: &Point, step: f64) -> Vec<Vector> {
        let lattice = (0..27).filter(|k| *k != 13);
        let of_lattice = |k: i32| Vector::new(f64::from(k % 3 - 1), f64::from(k / 3 % 3 - 1), f64::from(k / 9 - 1));
        let mut ways: Vec<Vector> = lattice.map(of_lattice).collect();
        let whole = self.least(mover.body, &mover.moving, FunctionPart::Whole, p, f64::NEG_INFINITY);
        let (value, slope) = mover.moving.at(mover.body, FunctionPart::Whole, p, whole.at);
        let mut normals = vec![slope];
        for k in 0..mover.body.pieces.len() {
            let (own, slope) = mover.moving.at(mover.body, FunctionPart::One(k), p, whole.at);
            normals.extend((own > value - step).then_some(slope));
        }
        normals.extend(self.store.raw.faces(p, step).into_iter().filter(|(d, _)| *d > -step).map(|(_, n)| n));
        normals.truncate(8);
        for (i, n) in normals.iter().enumerate() {
            ways.push(n * slope.dot(n) - slope * n.norm_squared());
            for m in normals.iter().skip(i + 1) {
                ways.extend([n.cross(m), m.cross(n)]);
            }
        }
        ways.into_iter().filter_map(|way| way.try_normalize(1e-9)).collect()
    }

    /// Whether the part of a cube that a mover fills lies outside of the raw stock or within one cut. If not,
    /// the middle of that part is checked for material.
    fn is_cleared(&mut self, m: u32, cube: &Cube, cuts: &[u32]) -> bool {
        let all = self.movers;
        let mover = &all[m as usize];
        let (c, radius, shrink) = (cube.center, cube.radius(), self.shrink);
        let mut of_mover: Vec<HalfSpace> = Vec::new();
        let whole = self.least(mover.body, &mover.moving, FunctionPart::Whole, &c, f64::NEG_INFINITY);
        of_mover.extend(whole.slope.map(|slope| (whole.bound, slope)));
        if mover.body.pieces.len() > 1 {
            for k in 0..mover.body.pieces.len() {
                let one = self.least(mover.body, &mover.moving, FunctionPart::One(k), &c, f64::NEG_INFINITY);
                of_mover.extend(one.slope.map(|slope| (one.bound, slope)));
            }
        }
        // What lies wholly on the inner side of a plane is not cut by it.
        of_mover.retain(|(value, slope)| value + slope.norm() * radius > -shrink);
        let beyond = |(d, n): (f64, Vector)| {
            of_mover.iter().any(|(value, slope)| value + d + FILM + shrink > (slope + n).norm() * radius)
        };
        if self.store.raw.faces(&c, radius).into_iter().any(beyond) {
            return true;
        }
        let corners = corners_of_part(cube, &of_mover, shrink);
        let last = self.store.last;
        if cuts.contains(&last) && self.holds(last, &corners) {
            return true;
        }
        let found = cuts.iter().copied().take(MOST_TRIED).find(|k| self.holds(*k, &corners));
        self.store.last = found.unwrap_or(last);
        if found.is_none() && !corners.is_empty() {
            // The middle of what is left is where material is most likely.
            let middle = corners.iter().map(|p| p.coords).sum::<Vector>() / corners.len() as f64;
            self.test_place(&middle.into(), cube, &[m], Some(cuts));
        }
        found.is_some()
    }

    /// Whether a cut takes up all that lies between these corners.
    fn holds(&mut self, k: u32, corners: &[Point]) -> bool {
        let cut = &self.store.cuts[k as usize];
        let wanted = FILM - cut.bend;
        let (moving, bodies) = (cut.moving, &self.store.sets[cut.set as usize]);
        let mut work = 0;
        let holds = bodies.iter().any(|b| {
            let body = &self.store.bodies[*b as usize].1;
            corners.iter().all(|p| {
                work += 1;
                moving.least(body, FunctionPart::Whole, p, wanted).met.is_some()
            })
        });
        self.store.work += work;
        holds
    }
}

fn corner(bounds: &Aabb, k: u8) -> Point {
    let at = |a: usize| if k >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] };
    Point::new(at(0), at(1), at(2))
}

/// Corners of the part of a cube in which every half space is at most `-shrink`: the points where three
/// planes meet and that no other plane cuts off. Planes beyond the first [`MOST_PLANES`] are ignored, which
/// only makes the part larger.
fn corners_of_part(cube: &Cube, half_spaces: &[HalfSpace], shrink: f64) -> Vec<Point> {
    /// Points so far beyond a plane count as in it, mm.
    const ROUNDING: f64 = 1e-7;
    /// Three planes whose normals have a smaller volume do not meet in a point.
    const PARALLEL: f64 = 1e-9;
    let half = 0.5 * cube.edge;
    // Normals n and lengths d with n . (x - center) <= d.
    let mut planes: Vec<(Vector, f64)> = Vec::with_capacity(6 + MOST_PLANES);
    for a in 0..3 {
        planes.push((Vector::ith(a, 1.0), half));
        planes.push((-Vector::ith(a, 1.0), half));
    }
    let cutting = half_spaces.iter().filter_map(|(value, slope)| {
        let length = slope.norm();
        (length > 1e-6).then(|| (slope / length, (-shrink - value) / length))
    });
    planes.extend(cutting.take(MOST_PLANES));
    let mut corners = Vec::new();
    for (i, (n, d)) in planes.iter().enumerate() {
        for (j, (m, e)) in planes.iter().enumerate().skip(i + 1) {
            let cross = n.cross(m);
            for (o, f) in planes.iter().skip(j + 1) {
                let volume = cross.dot(o);
                if volume.abs() < PARALLEL {
                    continue;
                }
                let x = (m.cross(o) * *d + o.cross(n) * *e + cross * *f) / volume;
                if planes.iter().all(|(n, d)| n.dot(&x) <= d + ROUNDING) {
                    corners.push(cube.center + x);
                }
            }
        }
    }
    corners
}
