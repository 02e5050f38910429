//! Ridges between passes on the cut surface.
//!
//! ```text
//!      ray i        ray i+1
//!        |     X      |            A, B: exact points of the cut surface, made by pieces p and q that
//!        A . /   \ .  |                  the stock remembers
//!      .     |     .  B            X:    top of the ridge, between the rays
//!            |        | .          height over the line s:   h_p(s) = h_q(s)
//!     -------+--------+----- design
//!            s
//! ```
//!
//! **Place.** Between two neighboring points with different makers the surface has a ridge when their outward
//! normals part, as such or against those of the design. Seen along the line A B the material is below both
//! swept surfaces, so that at the ridge the lower of the two changes. Both heights are found by inverse
//! contact on the motion itself, followed from the piece that made A (or B) over the pieces that go on from
//! it; where they are equal (regula falsi on the difference) is X. Nothing of it lies on the grid of the
//! rays: X is exact to rounding for the pieces as they are, and its height is its signed distance from the
//! design.
//!
//! **Of the cut surface.** The heights followed from A and B must be those of A and B themselves, to the
//! bound of the sweeps; otherwise the ridge counts as not followed. No other piece may cut deeper at X. All
//! pieces that come near are checked, and where one does, the two ridges on either side of it replace X.
//!
//! **Between passes.** A ridge between passes runs along the feed of both of them. A kink of a path of
//! straight pieces runs across its own feed, and a step from one level to the next has no top: both are left
//! out.
//!
//! **Weight.** Lines along u with spacing dv meet a ridge of direction t at `|t_v| / dv` places a length;
//! with lines along v as well the weight `dv |t_v| / (t_u^2 + t_v^2)`, and `du |t_u| / (t_u^2 + t_v^2)`
//! there, makes the sum the length of the ridge. Each place of the surface belongs to the set of rays that
//! meets the design most squarely, so `t_u^2 + t_v^2 >= 1/3`.
//!
//! # Error
//!
//! Heights are exact to 1e-9 mm for the pieces and the design as given. The chord error of a design mesh
//! and the deviation of the pieces from the motion that they approximate come on top; the caller knows
//! both.
//!
//! # Limits
//!
//! Passes nearer than two cells: a pass between two rays is found only where it cuts a ridge that was
//! found. [`Ridges::narrow`] is the length of ridges that lie nearer to their neighbor than that.

use proveout_geom::{Aabb, Point, Vector};
use proveout_stock::{RayEnd, RayPlace, TriDexel};
use rayon::prelude::*;

use super::valley::{Valley, sides};
use crate::{
    DesignSurface,
    topography::{ContactDirections, PathContact, SweptPath},
};

/// Least part of the normals' parting that is none of their rounding (16 bits a coordinate).
const PARTING: f64 = 3e-4;
/// The design is met at 55 degrees at most by the set that sees it most squarely, and a ridge is less than 20
/// degrees steeper.
const STEEP: f64 = 0.25;
/// Least angle between the two swept surfaces at a ridge, radian: below, its direction is not known.
const KINK: f64 = 1e-4;
/// Cosine between ridge and feed from which on the ridge lies between passes.
const ALONG: f64 = 0.5;
/// Allowed difference of the followed heights from the points of the stock, mm, on top of the bound of the
/// sweeps: the rounding of the stock.
const ROUNDING: f64 = 1e-6;
/// Heights that are equal, mm.
const EQUAL: f64 = 1e-10;
/// Another piece cuts a ridge when it comes deeper than this, mm.
const CUT: f64 = 1e-7;
/// Ridges within a ridge: passes between two neighboring rays.
const DEPTH: usize = 4;
/// Points of a pair that are nearer than this across the normal have no direction, mm.
const NO_CHORD: f64 = 1e-9;
/// A stretch across a ridge that is shorter is a point, mm: rounding of coordinates of 100 mm.
const NARROW: f64 = 1e-13;
/// Heights that are equal where the search has ended without [`EQUAL`], mm.
const NEARLY_EQUAL: f64 = 1e-7;
/// A way of a pass that is shorter has no direction, mm.
const NO_WAY: f64 = 1e-12;
/// Least square of what the rays of a set see of the direction of a ridge, by which its weight is divided.
const FLATTEST: f64 = 1e-3;

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub struct RidgeSettings<'a> {
    /// Points farther from the design do not count, mm.
    pub reach: f64,
    /// Only in this box.
    pub region: Option<Aabb>,
    /// Only in this box: where finer rays count.
    pub window: Option<Aabb>,
    /// Not in these: finer rays take their place.
    pub finer: &'a [Aabb],
    /// Of more places than this every second, third, ... is taken, with as much more weight.
    pub most: usize,
}

/// A place on a ridge between two passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ridge {
    /// Its top.
    pub point: Point,
    /// Above the design, mm.
    pub height: f64,
    /// Outward unit normal of the design.
    pub normal: Vector,
    /// Direction of the ridge.
    pub along: Vector,
    /// Length that it represents, mm.
    pub weight: f64,
    /// Number of the pieces on both sides, the earlier one first.
    pub pieces: [u32; 2],
    /// The valleys on both sides, as the pieces; none where the pass has none within reach.
    pub sides: Option<[Valley; 2]>,
    /// Distance of the valleys along the design, mm.
    pub spacing: Option<f64>,
    /// Curvature of the design across the ridge, from the normals at the valleys, 1/mm; positive where it is
    /// convex.
    pub curvature: Option<f64>,
    /// Height of the ridge over a design that the valleys touch, from axis, feed and cutter at the two
    /// contacts, mm.
    pub geometric: Option<f64>,
    /// One of its two passes touches the design with a flat of its cutter: valleys, spacing and geometric
    /// height are none.
    pub on_flat: bool,
}

/// All ridges of a part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ridges {
    /// In the order of the rays.
    pub ridges: Vec<Ridge>,
    /// Pairs of points between which a ridge lies whose height is not that of the known motion: raw stock, or
    /// a part of the tool that is not known here.
    pub not_followed: u64,
    /// Length of ridges whose passes lie nearer than two cells, mm.
    pub narrow: f64,
    /// Largest distance of points of the stock from the height that was followed from them, mm.
    pub largest_check: f64,
}

/// Two points of the surface with a ridge between.
#[derive(Clone, Copy, Debug)]
struct RidgePair {
    at: [Point; 2],
    made_by: [u32; 2],
    /// Along u or v.
    direction: usize,
    normal: Vector,
    foot: Point,
    cell: [f64; 2],
}

/// Finds the ridges between passes of a cut part.
pub fn ridges(
    stock: &TriDexel,
    path: &SweptPath,
    cutters: &[Vec<proveout_tool::Profile>],
    design: &(impl DesignSurface + ?Sized),
    settings: &RidgeSettings<'_>,
) -> Ridges {
    let search = RidgeSearch { stock, path, cutters, design, settings, bound: stock.sweep_bound_mm() + ROUNDING };
    let mut pairs = Vec::new();
    for axis in 0..3 {
        let places: Vec<(usize, usize)> =
            (0..stock.rows(axis)).flat_map(|row| (0..stock.tiles_in_row(axis)).map(move |t| (row, t))).collect();
        let found: Vec<Vec<RidgePair>> =
            places.into_par_iter().with_min_len(4).map(|(row, tile)| search.pairs(axis, row, tile)).collect();
        pairs.extend(found.into_iter().flatten());
    }
    let stride = pairs.len().div_ceil(settings.most.max(1)).max(1);
    let taken: Vec<RidgePair> = pairs.into_iter().step_by(stride).collect();
    let found: Vec<TracedRidges> = taken.par_iter().map(|pair| search.between(pair)).collect();
    let mut out = Ridges::default();
    let narrowest = 2.0 * stock.cell_mm();
    for f in found {
        out.not_followed += u64::from(f.not_followed) * stride as u64;
        out.largest_check = out.largest_check.max(f.check);
        for mut ridge in f.ridges {
            ridge.weight *= stride as f64;
            if ridge.spacing.is_some_and(|s| s < narrowest) {
                out.narrow += ridge.weight;
            }
            out.ridges.push(ridge);
        }
    }
    out
}

#[derive(Default)]
struct TracedRidges {
    ridges: Vec<Ridge>,
    not_followed: bool,
    check: f64,
}

struct RidgeSearch<'a, D: ?Sized> {
    stock: &'a TriDexel,
    path: &'a SweptPath,
    cutters: &'a [Vec<proveout_tool::Profile>],
    design: &'a D,
    settings: &'a RidgeSettings<'a>,
    bound: f64,
}

/// A height followed on one side of a ridge.
type FollowedContact = (f64, PathContact);

impl<D: DesignSurface + ?Sized> RidgeSearch<'_, D> {
    fn counts(&self, p: &Point) -> bool {
        let s = self.settings;
        s.region.is_none_or(|b| b.contains(p))
            && s.window.is_none_or(|b| b.contains(p))
            && !s.finer.iter().any(|b| b.contains(p))
    }

    /// Pairs whose first point lies on the rays of a tile.
    fn pairs(&self, axis: usize, row: usize, tile: usize) -> Vec<RidgePair> {
        let mut out = Vec::new();
        let cells = self.stock.cells_mm();
        let cell = [cells[(axis + 1) % 3], cells[(axis + 2) % 3]];
        for ray in self.stock.rays_of_tile(axis, row, tile) {
            let ends: Vec<(bool, RayEnd)> =
                self.stock.material(&ray).flat_map(|s| [(false, s.lo), (true, s.hi)]).collect();
            if ends.iter().all(|(_, e)| e.made_by.is_none()) {
                continue;
            }
            for direction in 0..2 {
                let mut next = RayPlace { axis, index: ray.index, at: ray.at };
                next.index[direction] += 1;
                next.at[direction] += cell[direction];
                let beside: Vec<(bool, RayEnd)> =
                    self.stock.material(&next).flat_map(|s| [(false, s.lo), (true, s.hi)]).collect();
                for (upper, a) in &ends {
                    out.extend(self.pair([&ray, &next], direction, (*upper, a), &beside, cell));
                }
            }
        }
        out
    }

    fn pair(
        &self,
        rays: [&RayPlace; 2],
        direction: usize,
        (upper, a): (bool, &RayEnd),
        beside: &[(bool, RayEnd)],
        cell: [f64; 2],
    ) -> Option<RidgePair> {
        let axis = rays[0].axis;
        let p = a.made_by?;
        if a.normal[axis].abs() < STEEP {
            return None;
        }
        let nearest = beside
            .iter()
            .filter(|(side, b)| *side == upper && (b.at - a.at).abs() <= cell[direction] / STEEP)
            .min_by(|x, y| (x.1.at - a.at).abs().total_cmp(&(y.1.at - a.at).abs()))?;
        let b = nearest.1;
        let q = b.made_by.filter(|q| *q != p)?;
        let at = [rays[0].point(a.at), rays[1].point(b.at)];
        let chord = at[1] - at[0];
        let middle = Point::from((at[0].coords + at[1].coords) * 0.5);
        if !self.counts(&middle) {
            return None;
        }
        let nearest = self.design.nearest(&middle, self.settings.reach)?;
        let n = nearest.normal;
        // In a hollow the normals of the cut surface come together as those of the design do: what counts is
        // how they part against it. The normals of a design mesh jump, so that either will do.
        let parting = (b.normal - a.normal).dot(&chord);
        let least = PARTING * chord.norm();
        if parting <= least {
            let [first, second] = at.map(|p| self.design.nearest(&p, self.settings.reach).map(|d| d.normal));
            if parting - (second? - first?).dot(&chord) <= least {
                return None;
            }
        }
        if (0..3).any(|k| n[k].abs() > n[axis].abs() || k < axis && n[k].abs() == n[axis].abs()) {
            return None;
        }
        Some(RidgePair { at, made_by: [p, q], direction, normal: n, foot: middle - n * nearest.distance, cell })
    }

    /// The ridges between the two points of a pair.
    fn between(&self, pair: &RidgePair) -> TracedRidges {
        let mut out = TracedRidges::default();
        let chord = pair.at[1] - pair.at[0];
        let Some(across) = (chord - pair.normal * chord.dot(&pair.normal)).try_normalize(NO_CHORD) else { return out };
        let line = Line { origin: pair.foot, across, normal: pair.normal };
        let s = pair.at.map(|p| (p - line.origin).dot(&across));
        let mut ends = [None, None];
        for k in 0..2 {
            let own = (pair.at[k] - line.origin).dot(&pair.normal);
            let start = PathContact { height: own, piece: pair.made_by[k], at: f64::NAN };
            let found = self.path.follow(&start, &line.at(s[k]), &pair.normal);
            let check = found.map_or(f64::INFINITY, |f| (f.height - own).abs());
            // Where the surface leans against the normal the bound is longer along it.
            if check > 4.0 * self.bound {
                out.not_followed = true;
                return out;
            }
            out.check = out.check.max(check);
            ends[k] = found;
        }
        let [Some(a), Some(b)] = ends else { return out };
        self.split(pair, &line, [(s[0], a), (s[1], b)], DEPTH, &mut out);
        out
    }

    /// The ridges between two places with their contacts.
    fn split(&self, pair: &RidgePair, line: &Line, [a, b]: [FollowedContact; 2], depth: usize, out: &mut TracedRidges) {
        let Some((s, p, q)) = self.meet(line, a, b) else { return };
        let place = line.at(s);
        let top = place + line.normal * p.height;
        let near = self.path.near(&top, CUT);
        let deeper = self.path.lowest_of(&near, &place, &line.normal, p.height);
        if let Some(third) = deeper.filter(|c| c.height < p.height - CUT) {
            if depth > 0 {
                self.split(pair, line, [a, (s, third)], depth - 1, out);
                self.split(pair, line, [(s, third), b], depth - 1, out);
            }
            return;
        }
        out.ridges.extend(self.ridge(pair, line, s, [p, q]));
    }

    /// Where the surfaces followed from two contacts meet between them.
    fn meet(&self, line: &Line, a: FollowedContact, b: FollowedContact) -> Option<(f64, PathContact, PathContact)> {
        let both = |s: f64, near: [PathContact; 2]| {
            let point = line.at(s);
            let p = self.path.follow(&near[0], &point, &line.normal)?;
            let q = self.path.follow(&near[1], &point, &line.normal)?;
            Some((p, q))
        };
        let (mut low, mut high) = (a.0, b.0);
        let (p, q) = both(low, [a.1, b.1])?;
        let mut below = p.height - q.height;
        let mut last = (p, q);
        let (p, q) = both(high, [a.1, b.1])?;
        let mut above = p.height - q.height;
        // A surface that was just cut differs from the one before by no more than the bound: the ridge may
        // lie outside the pair.
        let width = high - low;
        if below > -EQUAL && below <= self.bound && above > below + EQUAL {
            low -= width;
            below = both(low, [a.1, b.1]).map(|(p, q)| p.height - q.height)?;
        } else if above < EQUAL && above >= -self.bound && below < above - EQUAL {
            high += width;
            above = both(high, [a.1, b.1]).map(|(p, q)| p.height - q.height)?;
        }
        // The same surface on both sides has no ridge.
        if !(below < -EQUAL && above > EQUAL) {
            return None;
        }
        let mut side = 0;
        for _ in 0..60 {
            let mut s = (low * above - high * below) / (above - below);
            if !(s > low.min(high) && s < low.max(high)) {
                s = 0.5 * (low + high);
            }
            last = both(s, [last.0, last.1])?;
            let d = last.0.height - last.1.height;
            if d.abs() <= EQUAL || (high - low).abs() < NARROW {
                return Some((s, last.0, last.1));
            }
            if d < 0.0 {
                (low, below) = (s, d);
                if side == -1 {
                    above *= 0.5;
                }
                side = -1;
            } else {
                (high, above) = (s, d);
                if side == 1 {
                    below *= 0.5;
                }
                side = 1;
            }
        }
        let s = 0.5 * (low + high);
        let (p, q) = both(s, [last.0, last.1])?;
        ((p.height - q.height).abs() < NEARLY_EQUAL).then_some((s, p, q))
    }

    /// The ridge where two contacts meet, if it lies between passes.
    fn ridge(&self, pair: &RidgePair, line: &Line, s: f64, contacts: [PathContact; 2]) -> Option<Ridge> {
        let place = line.at(s);
        let touching = [
            self.path.touching(&contacts[0], &place, &line.normal)?,
            self.path.touching(&contacts[1], &place, &line.normal)?,
        ];
        let top = place + line.normal * contacts[0].height;
        let along = touching[0].normal.cross(&touching[1].normal);
        let kink = along.norm();
        if kink < KINK {
            return None;
        }
        let along = along / kink;
        let runs_along =
            |t: &ContactDirections| t.way.try_normalize(NO_WAY).is_some_and(|w| w.dot(&along).abs() > ALONG);
        if !touching.iter().all(runs_along) || !self.counts(&top) {
            return None;
        }
        let nearest = self.design.nearest(&top, self.settings.reach)?;
        let slope = |t: &ContactDirections| (nearest.normal - t.normal).dot(&line.across);
        if !(slope(&touching[0]) > 0.0 && slope(&touching[1]) < 0.0) {
            return None;
        }
        let (u, v) = ((self.axis_of(pair) + 1) % 3, (self.axis_of(pair) + 2) % 3);
        let flat = along[u] * along[u] + along[v] * along[v];
        let (spacing, share) =
            if pair.direction == 0 { (pair.cell[1], along[v].abs()) } else { (pair.cell[0], along[u].abs()) };
        let mut ridge = Ridge {
            point: top,
            height: nearest.distance,
            normal: nearest.normal,
            along,
            weight: spacing * share / flat.max(FLATTEST),
            pieces: [contacts[0].piece, contacts[1].piece],
            sides: None,
            spacing: None,
            curvature: None,
            geometric: None,
            on_flat: false,
        };
        let range = (self.settings.reach, self.stock.cell_mm());
        sides(self.path, self.cutters, self.design, &mut ridge, contacts, range);
        if ridge.pieces[0] > ridge.pieces[1] {
            ridge.pieces.swap(0, 1);
            ridge.sides = ridge.sides.map(|[a, b]| [b, a]);
        }
        Some(ridge)
    }

    fn axis_of(&self, pair: &RidgePair) -> usize {
        let n = pair.normal;
        (0..3).fold(0, |best, k| if n[k].abs() > n[best].abs() { k } else { best })
    }
}

/// Lines along one normal over a straight line across.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) origin: Point,
    pub(super) across: Vector,
    pub(super) normal: Vector,
}

impl Line {
    pub(super) fn at(&self, s: f64) -> Point {
        self.origin + self.across * s
    }
}
