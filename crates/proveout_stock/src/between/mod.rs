//! Whether a body that must not touch meets material between the rays of the stock.
//!
//! The rays of a stock are exact but carry no information between them: a convex edge has no ray
//! within half a cell of both of its faces, a pin thinner than a cell may have none, and a tool
//! thinner than 1.41 cells may fit between them. A hit of a ray and a body is true; the absence of
//! a hit proves little. But the true stock is known: it is the raw stock R, whose form is given,
//! less every swept body `S_i` of a cutter that has removed so far. So for a body on a motion, made
//! smaller by what counts as a touch (S), the question whether S and `R - S_1 - S_2 - ..` have a
//! point in common is decided by halving cubes.
//!
//! ```text
//!   cube B, center c, half its diagonal h
//!
//!     outside    S does not reach into B                least F_S(c) > h - touch
//!     empty      B is outside of R                      distance from R >= h
//!                B is in one S_i                        F_i(c) <= -h, or F_i <= 0 at all corners
//!     cleared    what S takes up of B is in one S_i     see below
//!                or outside of R
//!     material   c is in S, in R and in no S_i          a fault, with its place
//!     else       eight cubes of half the edge
//! ```
//!
//! F is the function of a convex body (`moving_body`): its value is never more than the distance from the
//! skin, and inside it is the depth. A cube that is empty stays so, since material only goes away: it is
//! remembered over the whole run, and eight empty cubes are an empty one. So open space is proved once, in
//! large cubes.
//!
//! *Cleared.* Where S slides along a wall that a cutter has just made, cubes would have to be as small as the
//! touch. Half spaces decide there. S fills at most the polytope P of B with `b + g . (x - c) <= -touch` for
//! each plane (b, g) that bounds `F_S` from below: one plane of the whole body, and one of each line or arc
//! of its outline. A cut `S_i` that does not turn is convex, because `F_i` is convex in place and time. If
//! all corners of P lie in it, all of P does, whatever its size. A cut that turns is split into parts that
//! bend by at most k, and the corners must lie deeper by k. A flat wall is so cleared in one cube. A round
//! wall of radius r, followed by the same body, takes cubes of `sqrt(2 r touch)`. At a face of R with the
//! normal n, and c at the distance d beyond it, S and R have nothing in common if `b + d + touch > |g + n|
//! h`.
//!
//! *Depth.* From the first place found, a climb in shrinking steps looks for the deepest one. A short search
//! then looks for places a quarter deeper. The reported depth is that of a real place; the greatest depth may
//! be larger.
//!
//! *Tolerances.* Material thinner than two micrometers (`FILM` on each side) is none: so much may the cuts on
//! the rays be off (`sweep_bound_mm`), and two passes that just touch leave no film. Cubes end at 4
//! micrometers, where the center decides. So every place where material reaches into S by more than that is
//! found; a place that is found is material in truth.
//!
//! *What is not decided* is reported with its place: where a search takes more work than it may,
//! where the raw stock is what an earlier run left (its rays are known, its form between them is
//! not), and where a part has come off the stock and was taken away.
//!
//! Results depend on the cuts and their order alone, not on threads, nor on the cells.

mod cut_tree;
mod depth_search;
mod mesh_side;
mod moving_body;
mod raw;

use std::collections::HashMap;

use proveout_geom::{Aabb, Point, ToolPose};
use proveout_tool::Profile;

use crate::{RawBody, SweepMotion, TriDexel, field::raw_body::KnownForm, kernels::meridian::Meridian};
use cut_tree::CutTree;
use depth_search::{DepthSearch, Mover};
use moving_body::{FunctionPart, MovingBody};
use raw::{Raw, RayCells};

/// Half the thickness of material that counts for nothing, mm.
const FILM: f64 = 0.001;
/// Cuts that are kept at most.
const MOST_CUTS: usize = 1_000_000;
/// Cubes that are remembered at most.
const MOST_CUBES: usize = 4_000_000;
/// Mark of an empty cube; of others the number of cuts that were tried on it.
const EMPTY: u32 = u32::MAX;
/// Edge of the cubes at which a search over many bodies ends, mm.
const COARSEST: f64 = 0.3;
/// Work of one search, and of one search over many bodies: distances that are searched.
const MOST_WORK: u64 = 400_000;
/// Work for a deeper place, once one is found.
const MOST_WORK_DEEPER: u64 = 20_000;
const MOST_WORK_OF_MANY: u64 = 200_000;
/// Cuts that are compared with a cutter at rest.
const LAST_CUTS: usize = 4;
/// Directions and tips that differ by less go on in one motion, mm.
const STRAIGHT: f64 = 1e-9;

#[derive(Clone, Debug)]
struct PastCut {
    set: u32,
    moving: MovingBody,
    motion: SweepMotion,
    bounds: Aabb,
    /// What its bodies are less than convex on their way, mm.
    bend: f64,
}

/// What a look between the rays gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BetweenFound {
    /// No material.
    Clear,
    /// Material in the body.
    Material {
        /// Where, frame of the stock.
        point: Point,
        /// Depth below the skin of the moving body, mm.
        depth_mm: f64,
    },
    /// It is not known.
    Open {
        /// Where, frame of the stock.
        point: Point,
        /// Length over which nothing is known, mm.
        size_mm: f64,
    },
}

/// The true stock of a run, see the text of the folder. Frame of the stock, mm.
#[derive(Clone, Debug)]
pub struct BetweenRays {
    raw: Raw,
    bounds: Aabb,
    /// Edge below which nothing of the raw stock is known, mm.
    unknown_below: f64,
    bodies: Vec<(Profile, Meridian)>,
    /// Bodies that cut together.
    sets: Vec<Vec<u32>>,
    cuts: Vec<PastCut>,
    tree: CutTree,
    /// Largest radius of a body that cuts, mm.
    widest: f64,
    cubes: HashMap<u64, u32>,
    gone: Vec<Aabb>,
    lost: bool,
    work: u64,
    /// The cut that has decided last: mostly it decides the next cube as well.
    last: u32,
}

impl BetweenRays {
    /// The raw stock; `stock` are its rays before the first cut.
    pub fn new(raw: &RawBody, stock: &TriDexel) -> Self {
        let [x, y, z] = stock.cells_mm();
        let (raw, unknown_below) = match raw.known() {
            Some(KnownForm::Block(b)) => (Raw::Block(b), 0.0),
            Some(KnownForm::Bar(bar)) => (Raw::Bar(bar.clone()), 0.0),
            Some(KnownForm::Mesh(mesh)) => (Raw::mesh(mesh), 0.0),
            None => (Raw::Rays(RayCells::new(stock)), 0.25 * x.min(y).min(z)),
        };
        Self {
            raw,
            bounds: stock.bounds(),
            unknown_below,
            bodies: Vec::new(),
            sets: Vec::new(),
            cuts: Vec::new(),
            tree: CutTree::default(),
            widest: 0.0,
            cubes: HashMap::new(),
            gone: Vec::new(),
            lost: false,
            work: 0,
            last: 0,
        }
    }

    fn body(&mut self, profile: &Profile) -> u32 {
        let known = self.bodies.iter().position(|(p, _)| p == profile);
        known.unwrap_or_else(|| {
            self.bodies.push((profile.clone(), Meridian::whole(profile)));
            self.bodies.len() - 1
        }) as u32
    }

    /// Takes away what some bodies sweep together.
    pub fn cut<'p>(&mut self, bodies: impl Iterator<Item = &'p Profile>, motion: &SweepMotion) {
        if !is_finite(motion) {
            return;
        }
        let set: Vec<u32> = bodies.map(|p| self.body(p)).collect();
        let of = |b: &u32| &self.bodies[*b as usize].1;
        let reach = set.iter().map(|b| of(b).reach).fold(0.0, f64::max);
        let whole = MovingBody::new(motion);
        let bounds = set.iter().fold(Aabb::empty(), |all, b| all.union(&whole.bounds(of(b))));
        if set.is_empty() || !bounds.intersects(&self.bounds) {
            return;
        }
        self.widest = set.iter().map(|b| of(b).radius).fold(self.widest, f64::max);
        let number = self.sets.iter().position(|s| *s == set).unwrap_or_else(|| {
            self.sets.push(set.clone());
            self.sets.len() - 1
        });
        for part in MovingBody::parts(motion, reach) {
            self.cut_part(number as u32, &set, &part, reach);
        }
    }

    fn cut_part(&mut self, number: u32, set: &[u32], motion: &SweepMotion, reach: f64) {
        let moving = MovingBody::new(motion);
        let of = |b: &u32| &self.bodies[*b as usize].1;
        let bounds = set.iter().fold(Aabb::empty(), |all, b| all.union(&moving.bounds(of(b))));
        if !bounds.intersects(&self.bounds) {
            return;
        }
        if let Some(last) = self.cuts.last_mut()
            && last.set == number
            && continues_straight(&last.motion, motion)
        {
            last.motion.to = motion.to;
            last.moving = MovingBody::new(&last.motion);
            last.bounds = last.bounds.union(&bounds);
            let grown = last.bounds;
            self.tree.grow_last(&grown);
            return;
        }
        if self.cuts.len() >= MOST_CUTS {
            self.lost = true;
            return;
        }
        self.tree.push(&bounds);
        let bend = moving.bend(reach);
        self.cuts.push(PastCut { set: number, moving, motion: *motion, bounds, bend });
    }

    /// A part has come off within this box and was taken away.
    pub fn part_is_gone(&mut self, bounds: &Aabb) {
        self.gone.push(*bounds);
    }

    /// Whether the form of the raw stock is known between its rays.
    pub fn is_raw_known(&self) -> bool {
        self.raw.is_known()
    }

    /// Work so far: distances that were searched.
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Looks for material in a body on its way that lies more than `shrink` below its skin.
    pub fn look(&mut self, body: &Profile, motion: &SweepMotion, shrink: f64) -> BetweenFound {
        if !is_finite(motion) {
            return BetweenFound::Clear;
        }
        let index = self.body(body);
        if self.stays_in_last_cut(index, motion) {
            return BetweenFound::Clear;
        }
        let meridian = self.bodies[index as usize].1.clone();
        let movers = self.movers(&meridian, motion, shrink);
        if movers.is_empty() {
            return BetweenFound::Clear;
        }
        let most = self.work + MOST_WORK;
        let mut search = DepthSearch {
            store: self,
            movers: &movers,
            shrink,
            coarsest: None,
            most,
            doubtful: vec![false; movers.len()],
            found: None,
            open: None,
        };
        search.run();
        let (found, open) = (search.found, search.open);
        match (found, open) {
            (Some((point, depth_mm)), _) if !self.lost => BetweenFound::Material { point, depth_mm },
            (Some((point, _)), _) => BetweenFound::Open { point, size_mm: self.bounds.size().max() },
            (None, Some((point, size_mm))) => BetweenFound::Open { point, size_mm },
            (None, None) => BetweenFound::Clear,
        }
    }

    /// Which of many bodies on their ways are not proved clear by a short search.
    pub fn in_doubt(&mut self, many: &[(&Profile, SweepMotion)], shrink: f64) -> Vec<bool> {
        let index: Vec<Option<u32>> = many.iter().map(|(p, m)| is_finite(m).then(|| self.body(p))).collect();
        let bodies: Vec<Meridian> = self.bodies.iter().map(|(_, m)| m.clone()).collect();
        let mut place = Vec::new();
        let mut movers = Vec::new();
        for (k, (index, (_, motion))) in index.iter().zip(many).enumerate() {
            let Some(index) = index.filter(|k| !self.stays_in_last_cut(*k, motion)) else { continue };
            let parts = self.movers(&bodies[index as usize], motion, shrink);
            place.extend(parts.iter().map(|_| k));
            movers.extend(parts);
        }
        let mut out = vec![false; many.len()];
        if movers.is_empty() {
            return out;
        }
        let most = self.work + MOST_WORK_OF_MANY;
        let doubtful = vec![false; movers.len()];
        let mut search = DepthSearch {
            store: self,
            movers: &movers,
            shrink,
            coarsest: Some(COARSEST),
            most,
            doubtful,
            found: None,
            open: None,
        };
        search.run();
        for (k, doubtful) in place.into_iter().zip(search.doubtful) {
            out[k] |= doubtful;
        }
        out
    }

    /// Whether a cutter stays where one of the last cuts ended: all that it takes up is cut. A control that
    /// changes from feed to rapid rests for some cycles between both.
    fn stays_in_last_cut(&self, body: u32, motion: &SweepMotion) -> bool {
        let is_same =
            |a: &ToolPose, b: &ToolPose| (a.tip - b.tip).norm() <= STRAIGHT && (a.axis - b.axis).norm() <= STRAIGHT;
        let ends_there =
            |cut: &PastCut| is_same(&cut.motion.to, &motion.from) && self.sets[cut.set as usize].contains(&body);
        is_same(&motion.from, &motion.to) && self.cuts.iter().rev().take(LAST_CUTS).any(ends_there)
    }

    /// The parts of a motion of a body that reach the raw stock.
    fn movers<'b>(&self, body: &'b Meridian, motion: &SweepMotion, shrink: f64) -> Vec<Mover<'b>> {
        let is_near = |moving: &MovingBody| moving.bounds(body).expanded(-shrink).intersects(&self.bounds);
        if !is_near(&MovingBody::new(motion)) {
            return Vec::new();
        }
        let parts = MovingBody::parts(motion, body.reach).into_iter().map(|part| {
            let moving = MovingBody::new(&part);
            Mover { body, moving, bounds: moving.bounds(body).expanded(-shrink) }
        });
        parts.filter(|part| part.bounds.intersects(&self.bounds)).collect()
    }

    /// Whether a point lies in material; none where that is not known.
    pub fn is_material(&self, p: &Point) -> Option<bool> {
        let inside = self.raw.is_inside(p, FILM);
        if inside == Some(false) {
            return Some(false);
        }
        if !self.is_uncut(p, &self.near(p)) {
            return Some(false);
        }
        inside.filter(|_| !self.lost && !self.is_gone(p))
    }

    /// Cuts whose boxes hold a point.
    fn near(&self, p: &Point) -> Vec<u32> {
        let mut near = Vec::new();
        self.tree.near(&Aabb { min: *p, max: *p }, 0, &mut near);
        near
    }

    /// True where none of some cuts has come to a point.
    fn is_uncut(&self, p: &Point, cuts: &[u32]) -> bool {
        cuts.iter().all(|k| {
            let cut = &self.cuts[*k as usize];
            !cut.bounds.contains(p)
                || self.sets[cut.set as usize].iter().all(|b| {
                    let body = &self.bodies[*b as usize].1;
                    cut.moving.least(body, FunctionPart::Whole, p, FILM).bound > FILM
                })
        })
    }

    fn is_gone(&self, p: &Point) -> bool {
        self.gone.iter().any(|b| b.contains(p))
    }

    fn is_empty(&self, key: u64) -> bool {
        self.cubes.get(&key) == Some(&EMPTY)
    }

    fn set_empty(&mut self, key: Option<u64>) {
        if let Some(key) = key.filter(|k| self.cubes.len() < MOST_CUBES || self.cubes.contains_key(k)) {
            self.cubes.insert(key, EMPTY);
        }
    }

    /// Number of the first cut that was not tried on a cube; the last one may have gone on since.
    fn first_untried(&self, key: u64) -> usize {
        self.cubes.get(&key).map_or(0, |n| *n as usize)
    }

    fn set_first_untried(&mut self, key: Option<u64>) {
        let tried = self.cuts.len().saturating_sub(1) as u32;
        if let Some(key) = key.filter(|k| self.cubes.len() < MOST_CUBES || self.cubes.contains_key(k)) {
            self.cubes.insert(key, tried);
        }
    }

    /// Memory in use, bytes.
    pub fn memory_bytes(&self) -> u64 {
        (self.cuts.capacity() * size_of::<PastCut>() + self.cubes.capacity() * 16) as u64 + self.tree.memory_bytes()
    }
}

fn is_finite(motion: &SweepMotion) -> bool {
    [&motion.from, &motion.to].iter().all(|p| p.tip.iter().chain(p.axis.iter()).all(|x| x.is_finite()))
}

/// Whether a motion goes straight on from another, without turning.
fn continues_straight(first: &SweepMotion, then: &SweepMotion) -> bool {
    let axes = [first.to.axis, then.from.axis, then.to.axis];
    let (way, more) = (first.to.tip - first.from.tip, then.to.tip - then.from.tip);
    let length = way.norm();
    axes.iter().all(|a| (a - first.from.axis).norm() <= 1e-12)
        && (first.to.tip - then.from.tip).norm() <= STRAIGHT
        && length > 0.0
        && way.dot(&more) >= 0.0
        && way.cross(&more).norm() <= STRAIGHT * length
}

#[cfg(test)]
mod tests;
