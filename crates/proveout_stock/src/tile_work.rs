//! One item on one tile: bounds that clear most rays, then the kernels, then the subtraction.

use proveout_geom::Aabb;
use pulp::Arch;

use crate::{
    grid::{Grid, TILE},
    lane_ball::BallOnLanes,
    lane_body::BodyOnLanes,
    lanes::{LANES, Lanes, Packing, TAKEN, UNPROVEN},
    meridian::Meridian,
    motion::Piece,
    ray::{Ray, Taken},
    ray_ball::sweep_ball,
    ray_translate::sweep_translation,
    ray_turn::sweep_turning,
    span::{Mark, SLIVER, Span},
    tile::{Cut, Overlap, Tile, subtract},
    vec3::{V, along, dot, norm, scale, sub},
    watch::Watch,
};

/// An item made ready.
pub(crate) struct Ready {
    pub body: usize,
    pub id: u32,
    pub removes: bool,
    /// Box of the motion, mm.
    pub region: Aabb,
    /// Pieces for the ball and for the rest of the body, in [`Batch::pieces`].
    pub ball: std::ops::Range<usize>,
    pub rest: std::ops::Range<usize>,
}

/// Overlap of one item in one tile.
pub(crate) struct Partial {
    pub item: u32,
    pub rays: u32,
    pub length: f64,
    pub longest: f64,
    pub at: V,
    pub range: [f64; 2],
    pub u: [f64; 2],
    pub v: [f64; 2],
}

/// A tile on loan to a thread.
pub(crate) struct Work {
    pub index: usize,
    pub tile: Tile,
    pub watch: Watch,
    /// Range of the bin in the list of entries.
    pub entries: std::ops::Range<usize>,
    pub found: Vec<Partial>,
    /// Range of removal along the rays, mm; lo > hi when none.
    pub changed: [f64; 2],
}
pub(crate) struct Batch<'a> {
    pub ready: Vec<Ready>,
    pub pieces: [Vec<Piece>; 3],
    pub bodies: &'a [Meridian],
    /// The instructions of this processor.
    pub arch: Arch,
}

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct Scratch {
    /// Pieces of the motion that may touch the tile; true: with the ball, false: with the rest of the body.
    near: Vec<(usize, bool)>,
    spaces: Vec<HalfSpace>,
    rays: Vec<(usize, Ray)>,
    lanes: Lanes,
    again: Lanes,
    taken: Vec<Taken>,
    cuts: Vec<Cut>,
    left: Vec<Span>,
}

/// Lanes of one ray after the other.
fn by_ray(lanes: &Lanes) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
    let (rays, n) = (lanes.ray, lanes.len());
    let mut first = 0;
    std::iter::from_fn(move || {
        let ray = *rays.get(first).filter(|_| first < n)?;
        let start = first;
        while first < n && rays[first] == ray {
            first += 1;
        }
        Some(start..first)
    })
}

/// Parts of a turning motion for lanes that were not proven in one.
const PARTS: usize = 4;
/// Rays on one side of a patch.
const PATCH: usize = 4;

/// Box in ray coordinates: middle and half lengths.
pub(crate) struct Block {
    middle: V,
    half: V,
}

impl Block {
    fn new(s: [f64; 2], u: [f64; 2], v: [f64; 2]) -> Self {
        let middle = [0.5 * (s[0] + s[1]), 0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])];
        let half = [0.5 * (s[1] - s[0]), 0.5 * (u[1] - u[0]), 0.5 * (v[1] - v[0])];
        Self { middle, half }
    }
}

/// The half space value + normal . (x - at) <= 0, which holds a body during all of a piece of motion.
#[derive(Clone, Copy)]
pub(crate) struct HalfSpace {
    at: V,
    normal: V,
    value: f64,
    /// What a unit of distance from `at` takes from the value: the half space turns.
    turning: f64,
}

impl HalfSpace {
    /// The one that is tangent at mid-time near the point of a box that is nearest to the body, as far as its axis tells.
    fn new(piece: &Piece, body: &Meridian, ball: bool, block: &Block) -> Self {
        let low = block.middle[0] - block.half[0];
        let mut at = block.middle;
        if let (true, Some([z, radius])) = (ball, body.ball) {
            let (from, to) = (piece.on_axis(z, 0.0), piece.on_axis(z, 1.0));
            let center = along(scale(from, 0.5), to, 0.5);
            at[0] = center[0].clamp(low, low + 2.0 * block.half[0]);
            let away = sub(at, center);
            let distance = norm(away);
            let normal = if distance > 0.0 { scale(away, 1.0 / distance) } else { [1.0, 0.0, 0.0] };
            let change = 0.5 * dot(normal, sub(to, from)).abs();
            return Self { at, normal, value: distance - radius - change, turning: 0.0 };
        }
        at[0] = piece.facing(body, at).clamp(low, low + 2.0 * block.half[0]);
        let sample = piece.sample(body, at, 0.5);
        let mut value = sample.f - 0.5 * sample.ft.abs();
        let mut turning = 0.0;
        if piece.turns() {
            value -= piece.bend(body.reach) / 8.0;
            turning = 0.5 * piece.angle2.sqrt();
        }
        Self { at, normal: sample.normal, value, turning }
    }

    /// Whether nothing of the box is in it.
    fn clears(&self, block: &Block) -> bool {
        let n = self.normal;
        let middle = self.value + n[0] * (block.middle[0] - self.at[0]);
        let spread = n[0].abs() * block.half[0] + n[1].abs() * block.half[1] + n[2].abs() * block.half[2];
        middle - spread - self.turning * 2.0 * norm(block.half) > 0.0
    }

    /// Whether nothing of the material of a ray is in it.
    #[inline]
    fn clears_ray(&self, ray: &Ray) -> bool {
        let n = self.normal;
        let nearest = if n[0] > 0.0 { ray.lo } else { ray.hi };
        let (du, dv, ds) = (ray.u - self.at[1], ray.v - self.at[2], nearest - self.at[0]);
        let mut value = self.value + n[0] * ds + n[1] * du + n[2] * dv;
        if self.turning > 0.0 {
            let far = (ray.hi - self.at[0]).abs().max((ray.lo - self.at[0]).abs());
            value -= self.turning * (far + du.abs() + dv.abs());
        }
        value > 0.0
    }
}

impl Batch<'_> {
    pub(crate) fn item_on_tile(&self, grid: &Grid, work: &mut Work, item: u32, scratch: &mut Scratch) {
        let ready = &self.ready[item as usize];
        let (a, [i0, j0]) = grid.tile_place(work.index);
        let (u_axis, v_axis) = ((a + 1) % 3, (a + 2) % 3);
        let (min, max) = (&ready.region.min, &ready.region.max);
        let s = [work.tile.lo.max(min[a]), work.tile.hi.min(max[a])];
        if s[1] - s[0] <= SLIVER {
            return;
        }
        let span = |axis: usize, first: usize| {
            let from = grid.first_at_or_above(axis, min[axis]).max(first);
            (from, grid.first_at_or_above(axis, max[axis]).min(first + TILE))
        };
        let ((i_from, i_to), (j_from, j_to)) = (span(u_axis, i0), span(v_axis, j0));
        if i_from >= i_to || j_from >= j_to {
            return;
        }
        let u = [grid.center(u_axis, i_from), grid.center(u_axis, i_to - 1)];
        let v = [grid.center(v_axis, j_from), grid.center(v_axis, j_to - 1)];
        let block = Block::new(s, u, v);
        let body = &self.bodies[ready.body];
        scratch.near.clear();
        let pieces = &self.pieces[a];
        let every = ready.ball.clone().map(|k| (k, true)).chain(ready.rest.clone().map(|k| (k, false)));
        scratch.near.extend(every.filter(|&(k, ball)| !HalfSpace::new(&pieces[k], body, ball, &block).clears(&block)));
        if scratch.near.is_empty() {
            return;
        }
        let mut sum = Partial::new(item);
        let mut place = Place { grid, tile: &mut work.tile, watch: &mut work.watch, ready, a };
        // Patches of rays share one half space for each piece, which clears most of them at the cost of a product.
        for patch_j in (j_from - j_from % PATCH..j_to).step_by(PATCH) {
            let j = [patch_j.max(j_from), (patch_j + PATCH).min(j_to)];
            for patch_i in (i_from - i_from % PATCH..i_to).step_by(PATCH) {
                let i = [patch_i.max(i_from), (patch_i + PATCH).min(i_to)];
                self.gather(&mut place, i, j, scratch, &mut sum);
            }
        }
        self.cut_lanes(&mut place, scratch, &mut sum);
        if sum.rays > 0 {
            if ready.removes {
                // Only what touched the range of the tile can have changed it.
                if sum.range[0] <= work.tile.lo || sum.range[1] >= work.tile.hi {
                    work.tile.update_range();
                }
                work.changed = [work.changed[0].min(sum.range[0]), work.changed[1].max(sum.range[1])];
            }
            work.found.push(sum);
        }
    }

    /// Collects the material of the rays `i` x `j` that the item may meet; works on the lanes whenever they are full.
    fn gather(&self, place: &mut Place<'_>, i: [usize; 2], j: [usize; 2], scratch: &mut Scratch, sum: &mut Partial) {
        let (grid, a) = (place.grid, place.a);
        let (u_axis, v_axis) = ((a + 1) % 3, (a + 2) % 3);
        let (min, max) = (place.ready.region.min[a], place.ready.region.max[a]);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut columns = range;
        scratch.rays.clear();
        for row in j[0]..j[1] {
            let v = grid.center(v_axis, row);
            for column in i[0]..i[1] {
                let r = row % TILE * TILE + column % TILE;
                for span in place.tile.ray(r) {
                    let (lo, hi) = (span.lo.max(min), span.hi.min(max));
                    if hi - lo > SLIVER {
                        let ray = Ray { u: grid.center(u_axis, column), v, lo, hi };
                        scratch.rays.push((r, ray));
                        range = [range[0].min(lo), range[1].max(hi)];
                        // Rays without material may leave any outline: the first and last ray need not span the columns.
                        columns = [columns[0].min(ray.u), columns[1].max(ray.u)];
                    }
                }
            }
        }
        if scratch.rays.is_empty() {
            return;
        }
        let side = |axis: usize, k: [usize; 2]| [grid.center(axis, k[0]), grid.center(axis, k[1] - 1)];
        let block = Block::new(range, columns, side(v_axis, j));
        let body = &self.bodies[place.ready.body];
        let pieces = &self.pieces[a];
        scratch.spaces.clear();
        for &(k, ball) in &scratch.near {
            let space = HalfSpace::new(&pieces[k], body, ball, &block);
            if !space.clears(&block) {
                scratch.spaces.push(space);
            }
        }
        if scratch.spaces.is_empty() {
            return;
        }
        for k in 0..scratch.rays.len() {
            let (r, ray) = scratch.rays[k];
            if scratch.spaces.iter().all(|space| space.clears_ray(&ray)) {
                continue;
            }
            if scratch.lanes.is_full() {
                self.cut_lanes(place, scratch, sum);
            }
            scratch.lanes.push(r, ray.u, ray.v, ray.lo, ray.hi);
        }
    }

    /// Finds what the item takes of the lanes, takes it away and reports it; the lanes are empty afterwards.
    fn cut_lanes(&self, place: &mut Place<'_>, scratch: &mut Scratch, sum: &mut Partial) {
        if scratch.lanes.len() == 0 {
            return;
        }
        scratch.lanes.pad();
        let body = &self.bodies[place.ready.body];
        let pieces = &self.pieces[place.a];
        for &(k, ball) in &scratch.near {
            let (piece, lanes) = (&pieces[k], &mut scratch.lanes);
            if !ball {
                self.arch.dispatch(BodyOnLanes { piece, body, lanes });
            } else if let Some([center_z, radius]) = body.ball {
                self.arch.dispatch(BallOnLanes { piece, center_z, radius, lanes });
            }
        }
        if place.ready.removes {
            self.arch.dispatch(Packing { lanes: &mut scratch.lanes, axis: place.a });
        }
        // Lanes without proof get a second chance in parts of the motion, in which all bounds are smaller.
        scratch.again.clear();
        for lanes in by_ray(&scratch.lanes) {
            let states = &scratch.lanes.state[lanes.clone()];
            if states.contains(&UNPROVEN) {
                scratch.again.copy(&scratch.lanes, lanes);
            } else if states.contains(&TAKEN) {
                place.cut_ray(&scratch.lanes, lanes, &mut scratch.cuts, &mut scratch.left, sum);
            }
        }
        scratch.lanes.clear();
        if scratch.again.len() == 0 {
            return;
        }
        scratch.again.pad();
        for &(k, ball) in scratch.near.iter().filter(|n| n.1 || pieces[n.0].turns()) {
            for part in 0..if ball { 1 } else { PARTS } {
                let lanes = &mut scratch.again;
                if let (true, Some([center_z, radius])) = (ball, body.ball) {
                    self.arch.dispatch(BallOnLanes { piece: &pieces[k], center_z, radius, lanes });
                } else {
                    self.arch.dispatch(BodyOnLanes { piece: &pieces[k].part(part, PARTS), body, lanes });
                }
            }
        }
        // A straight motion gains nothing from parts.
        let straight = scratch.near.iter().any(|n| !n.1 && !pieces[n.0].turns());
        if place.ready.removes {
            self.arch.dispatch(Packing { lanes: &mut scratch.again, axis: place.a });
        }
        for lanes in by_ray(&scratch.again) {
            let states = &scratch.again.state[lanes.clone()];
            if straight || states.contains(&UNPROVEN) {
                self.search_ray(place, lanes, scratch, sum);
            } else if states.contains(&TAKEN) {
                place.cut_ray(&scratch.again, lanes, &mut scratch.cuts, &mut scratch.left, sum);
            }
        }
        scratch.again.clear();
    }

    /// The ray of some lanes by the searches that always end.
    fn search_ray(
        &self,
        place: &mut Place<'_>,
        lanes: std::ops::Range<usize>,
        scratch: &mut Scratch,
        sum: &mut Partial,
    ) {
        let l = &scratch.again;
        let ray = Ray { u: l.u[lanes.start], v: l.v[lanes.start], lo: l.lo[lanes.start], hi: l.hi[lanes.end - 1] };
        let r = usize::from(l.ray[lanes.start]);
        let body = &self.bodies[place.ready.body];
        scratch.taken.clear();
        for &(k, ball) in &scratch.near {
            take(&self.pieces[place.a][k], body, ball, &ray, &mut scratch.taken);
        }
        if scratch.taken.is_empty() {
            return;
        }
        cuts_of(&mut scratch.taken, place.ready.id, place.a, &mut scratch.cuts);
        place.subtract(r, ray.u, ray.v, &scratch.cuts, &mut scratch.left, sum);
    }
}

/// The item and the tile that it works on.
struct Place<'a> {
    grid: &'a Grid,
    tile: &'a mut Tile,
    watch: &'a mut Watch,
    ready: &'a Ready,
    a: usize,
}

impl Place<'_> {
    /// Takes away what some lanes of one ray say.
    fn cut_ray(
        &mut self,
        l: &Lanes,
        lanes: std::ops::Range<usize>,
        cuts: &mut Vec<Cut>,
        left: &mut Vec<Span>,
        sum: &mut Partial,
    ) {
        let k = lanes.start;
        let (r, u, v, id) = (usize::from(l.ray[k]), l.u[k], l.v[k], self.ready.id);
        let mark = |code: &[[f64; LANES]; 2], k: usize| Mark::packed(id, [code[0][k], code[1][k]]);
        if let (1, Some(span)) = (lanes.len(), self.tile.only_span(r)) {
            let (lo, hi) = (l.from[k].max(span.lo), l.to[k].min(span.hi));
            if hi - lo <= SLIVER {
                return;
            }
            let (below, above) = (lo - span.lo > SLIVER, span.hi - hi > SLIVER);
            let old = *span;
            self.watch.before(&[old]);
            let mut overlap = Overlap { length: old.hi - old.lo, longest: hi - lo, middle: 0.5 * (lo + hi), lo, hi };
            let lower = Span { hi: lo, ..old };
            let upper = Span { lo: hi, ..old };
            overlap.length -= if below { lower.hi - lower.lo } else { 0.0 };
            overlap.length -= if above { upper.hi - upper.lo } else { 0.0 };
            sum.add(u, v, &overlap);
            if !self.ready.removes {
                return;
            }
            let lower = || Span { hi_mark: mark(&l.from_code, k), ..lower };
            let upper = || Span { lo_mark: mark(&l.to_code, k), ..upper };
            match (below, above) {
                (true, false) => *span = lower(),
                (false, true) => *span = upper(),
                (true, true) => {
                    let both = [lower(), upper()];
                    self.tile.replace(r, &both);
                }
                (false, false) => self.tile.replace(r, &[]),
            }
            self.watch.after(r, id, self.tile.ray(r));
            return;
        }
        cuts.clear();
        for k in lanes.filter(|&k| l.state[k] == TAKEN) {
            cuts.push(Cut {
                lo: l.from[k].max(l.lo[k]),
                hi: l.to[k].min(l.hi[k]),
                lo_mark: mark(&l.from_code, k),
                hi_mark: mark(&l.to_code, k),
            });
        }
        self.subtract(r, u, v, cuts, left, sum);
    }

    fn subtract(&mut self, r: usize, u: f64, v: f64, cuts: &[Cut], left: &mut Vec<Span>, sum: &mut Partial) {
        let overlap = subtract(self.tile.ray(r), cuts, left);
        if overlap.longest > 0.0 {
            sum.add(u, v, &overlap);
            if self.ready.removes {
                self.watch.before(self.tile.ray(r));
                self.tile.replace(r, left);
                self.watch.after(r, self.ready.id, self.tile.ray(r));
            }
        }
    }
}

impl Partial {
    fn new(item: u32) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Self { item, rays: 0, length: 0.0, longest: 0.0, at: [0.0; 3], range: none, u: none, v: none }
    }

    fn add(&mut self, u: f64, v: f64, overlap: &Overlap) {
        self.rays += 1;
        self.length += overlap.length;
        if overlap.longest > self.longest {
            self.longest = overlap.longest;
            self.at = [overlap.middle, u, v];
        }
        self.range = [self.range[0].min(overlap.lo), self.range[1].max(overlap.hi)];
        self.u = [self.u[0].min(u), self.u[1].max(u)];
        self.v = [self.v[0].min(v), self.v[1].max(v)];
    }
}

/// Intervals that the ball or the rest of a body takes up on a ray on one piece of motion.
fn take(piece: &Piece, body: &Meridian, ball: bool, ray: &Ray, taken: &mut Vec<Taken>) {
    if !ball {
        if piece.turns() {
            sweep_turning(piece, body, ray, taken);
        } else {
            taken.extend(sweep_translation(piece, body, ray));
        }
    } else if let Some([z, radius]) = body.ball {
        taken.extend(sweep_ball(piece, z, radius, ray));
    }
}

/// Mark that a body with the normal `n` (ray, u, v) leaves on a ray of set `a`.
fn mark(id: u32, a: usize, n: V) -> Mark {
    let mut world = [0.0; 3];
    world[a] = -n[0];
    world[(a + 1) % 3] = -n[1];
    world[(a + 2) % 3] = -n[2];
    Mark::new(id, world)
}

/// Joins intervals that meet and marks their ends: the material's outward normal is against the body's.
fn cuts_of(taken: &mut [Taken], id: u32, a: usize, cuts: &mut Vec<Cut>) {
    if taken.len() > 1 {
        taken.sort_by(|x, y| x.lo.s.total_cmp(&y.lo.s));
    }
    let mark = |n: V| mark(id, a, n);
    cuts.clear();
    let mut open: Option<Taken> = None;
    for t in taken.iter() {
        match &mut open {
            Some(o) if t.lo.s <= o.hi.s + SLIVER => {
                if t.hi.s > o.hi.s {
                    o.hi = t.hi;
                }
            }
            _ => {
                if let Some(o) = open.take() {
                    cuts.push(Cut { lo: o.lo.s, hi: o.hi.s, lo_mark: mark(o.lo.normal), hi_mark: mark(o.hi.normal) });
                }
                open = Some(*t);
            }
        }
    }
    if let Some(o) = open {
        cuts.push(Cut { lo: o.lo.s, hi: o.hi.s, lo_mark: mark(o.lo.normal), hi_mark: mark(o.hi.normal) });
    }
}
