//! The search for material between the rays: the text of the folder has the reasons.

use proveout_geom::{Aabb, Point, Vector};

use super::{
    BetweenRays, FILM,
    moving::{Least, Moving, Part},
};
use crate::kernels::meridian::{Meridian, Piece};

/// Smallest cube that is looked at, mm: its center decides.
const SMALLEST: f64 = 0.004;
/// Largest half diagonal of a cube that is asked by its half spaces, mm.
const BY_PLANES: f64 = 2.0;
/// A place is worth another look where it may be deeper by this part.
const DEEPER: f64 = 1.25;

/// A body that must not meet material.
pub(super) struct Mover<'b> {
    pub body: &'b Meridian,
    pub moving: Moving,
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

pub(super) struct Search<'s, 'b> {
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

impl Search<'_, '_> {
    pub(super) fn run(&mut self) {
        let bounds = self.store.bounds;
        let root = Cube { level: 0, at: [0; 3], center: bounds.center(), edge: bounds.size().max() };
        let all: Vec<u32> = (0..self.movers.len() as u32).collect();
        self.visit(&root, &all, None);
    }

    fn gives_up(&self) -> bool {
        self.store.work >= self.most
    }

    fn least(&mut self, body: &Meridian, moving: &Moving, part: Part, p: &Point, wanted: f64) -> Least {
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
            let least = self.least(mover.body, &mover.moving, Part::Whole, &cube.center, wanted);
            if least.bound <= wanted {
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
        if self.gives_up() {
            self.leave_open(cube, &movers);
            return false;
        }
        let bounds = cube.bounds();
        let near: Option<Vec<u32>> = match cuts {
            Some(above) => {
                let boxes = &self.store.cuts;
                Some(above.iter().copied().filter(|k| boxes[*k as usize].bounds.intersects(&bounds)).collect())
            }
            None if radius <= self.store.widest => {
                let mut near = Vec::new();
                self.store.tree.near(&bounds, 0, &mut near);
                Some(near)
            }
            None => None,
        };
        if let Some(near) = &near {
            let tried = key.map_or(0, |k| self.store.tried(k));
            for &k in near.iter().take_while(|k| **k as usize >= tried) {
                if self.holds_cube(k, cube) {
                    self.store.set_empty(key);
                    return true;
                }
            }
            self.store.set_tried(key);
            self.look_at_center(cube, &movers, Some(near));
            if radius <= BY_PLANES && movers.iter().all(|m| self.is_cleared(*m, cube, near)) {
                return false;
            }
        } else {
            self.look_at_center(cube, &movers, None);
        }
        if let Some(coarsest) = self.coarsest.filter(|c| cube.edge <= *c) {
            debug_assert!(coarsest > 0.0);
            movers.iter().for_each(|m| self.doubtful[*m as usize] = true);
            return false;
        }
        if cube.edge <= SMALLEST.max(self.store.unknown_below) {
            if !self.store.raw.is_known() {
                self.leave_open(cube, &movers);
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

    fn leave_open(&mut self, cube: &Cube, movers: &[u32]) {
        movers.iter().for_each(|m| self.doubtful[*m as usize] = true);
        self.open.get_or_insert((cube.center, cube.edge));
    }

    /// A cut that takes up the whole cube at one time.
    fn holds_cube(&mut self, k: u32, cube: &Cube) -> bool {
        let cut = &self.store.cuts[k as usize];
        let (bounds, own) = (cube.bounds(), cut.bounds.expanded(FILM));
        if !(own.contains(&bounds.min) && own.contains(&bounds.max)) {
            return false;
        }
        let wanted = FILM - cube.radius();
        let (moving, bodies) = (cut.moving, &self.store.sets[cut.set as usize]);
        self.store.work += bodies.len() as u64;
        bodies.iter().any(|b| {
            let body = &self.store.bodies[*b as usize].1;
            moving.least(body, Part::Whole, &cube.center, wanted).met.is_some()
        })
    }

    /// Material at the center of a cube, within a mover. `cuts` are those near the cube, where they are known.
    fn look_at_center(&mut self, cube: &Cube, movers: &[u32], cuts: Option<&[u32]>) {
        let p = cube.center;
        let all = self.movers;
        let depth = self.depth();
        let mut met = Vec::new();
        for &m in movers {
            let mover = &all[m as usize];
            if self.least(mover.body, &mover.moving, Part::Whole, &p, -depth).met.is_some() {
                met.push(m);
            }
        }
        if met.is_empty() || self.store.raw.is_inside(&p, FILM) != Some(true) {
            return;
        }
        let uncut = match cuts {
            Some(cuts) => self.store.is_uncut(&p, cuts),
            None => self.store.is_uncut(&p, &self.store.near(&p)),
        };
        if !uncut {
            return;
        }
        if self.store.is_gone(&p) {
            self.leave_open(cube, &met);
        } else if self.coarsest.is_some() {
            met.iter().for_each(|m| self.doubtful[*m as usize] = true);
        } else {
            let mut deepest = depth;
            for m in met {
                let mover = &all[m as usize];
                let least = self.least(mover.body, &mover.moving, Part::Whole, &p, f64::NEG_INFINITY);
                deepest = deepest.max(-least.seen);
            }
            self.found = Some((p, deepest));
        }
    }

    /// True where what a mover takes up of a cube is outside of the raw stock, or within one cut at one time.
    fn is_cleared(&mut self, m: u32, cube: &Cube, cuts: &[u32]) -> bool {
        let all = self.movers;
        let mover = &all[m as usize];
        let (c, radius, shrink) = (cube.center, cube.radius(), self.shrink);
        let mut of_mover: Vec<HalfSpace> = Vec::new();
        let whole = self.least(mover.body, &mover.moving, Part::Whole, &c, f64::NEG_INFINITY);
        of_mover.extend(whole.slope.map(|slope| (whole.bound, slope)));
        if mover.body.pieces.len() > 1 {
            for k in 0..mover.body.pieces.len() {
                let one = self.least(mover.body, &mover.moving, Part::One(k), &c, f64::NEG_INFINITY);
                // What lies wholly on its inner side says nothing.
                if one.bound + radius > -shrink {
                    of_mover.extend(one.slope.map(|slope| (one.bound, slope)));
                }
            }
        }
        let beyond = |(d, n): (f64, Vector)| {
            of_mover.iter().any(|(value, slope)| value + d + FILM + shrink > (slope + n).norm() * radius)
        };
        if self.store.raw.faces(&c, radius).into_iter().any(beyond) {
            return true;
        }
        let last = self.store.last;
        if cuts.contains(&last) && self.holds(last, cube, &of_mover) {
            return true;
        }
        let found = cuts.iter().copied().find(|k| self.holds(*k, cube, &of_mover));
        self.store.last = found.unwrap_or(last);
        found.is_some()
    }

    /// Whether a cut takes up, at one time, all of a cube that some half spaces hold.
    fn holds(&mut self, k: u32, cube: &Cube, half_spaces: &[HalfSpace]) -> bool {
        let (c, radius, shrink) = (cube.center, cube.radius(), self.shrink);
        let cut = &self.store.cuts[k as usize];
        let (moving, bodies) = (cut.moving, &self.store.sets[cut.set as usize]);
        self.store.work += bodies.len() as u64;
        bodies.iter().any(|b| {
            let body = &self.store.bodies[*b as usize].1;
            let least = moving.least(body, Part::Whole, &c, f64::NEG_INFINITY);
            if least.seen > radius {
                return false;
            }
            let off = moving.off_axis(&c, least.at);
            (0..body.pieces.len()).all(|q| {
                let (value, slope) = moving.at(body, Part::One(q), &c, least.at);
                let bends = || bend(&body.pieces[q], off, value, radius) * 0.5 * radius * radius;
                value + radius <= FILM
                    || half_spaces.iter().any(|(bound, g)| {
                        let apart = value - bound - shrink + (slope - g).norm() * radius;
                        apart <= FILM && apart + bends() <= FILM
                    })
            })
        })
    }
}

/// Largest second derivative of the function of a piece within `radius` of a point that is `off` its axis and where the function has a
/// value, 1/mm.
fn bend(piece: &Piece, off: f64, value: f64, radius: f64) -> f64 {
    let round = |nr: f64| {
        if nr <= 0.0 {
            0.0
        } else if off > radius {
            nr / (off - radius)
        } else {
            f64::INFINITY
        }
    };
    match *piece {
        Piece::Line { nr, .. } => round(nr),
        Piece::Arc { center, radius: of_arc, .. } => {
            // At least so far is the point from the center of the arc.
            let far = value + of_arc;
            let own = if far > radius { 1.0 / (far - radius) } else { f64::INFINITY };
            if center[0].abs() < 1e-9 { own } else { own.max(round(1.0)) }
        }
    }
}
