//! Batches of motions against the stock.

use proveout_geom::{Aabb, Point, ToolPose};
use proveout_tool::Profile;
use rayon::prelude::*;

use crate::{
    dexel::TriDexel,
    grid::{Grid, TILE},
    meridian::{Meridian, TOUCH},
    motion::{self, Piece, SEARCH_ERROR, TURN_ERROR},
    ray::{Ray, Taken},
    ray_ball::sweep_ball,
    ray_translate::sweep_translation,
    ray_turn::sweep_turning,
    span::{Mark, SLIVER, Span},
    tile::{Cut, Overlap, Tile, subtract},
    vec3::{V, along, dot, norm, scale, sub},
};

/// A motion of a tool: the tip runs straight, the axis on the great circle, both uniform in time; frame of the stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepMotion {
    /// Start.
    pub from: ToolPose,
    /// End.
    pub to: ToolPose,
}

/// What a motion does to the stock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Takes away the material that the body meets.
    Remove,
    /// Leaves the stock as it is and reports what the body would overlap with.
    Probe,
}

/// One body on one motion.
#[derive(Clone, Copy, Debug)]
pub struct SweepItem<'a> {
    /// Remembered by every interval end that this motion makes; `u32::MAX` is taken for the initial surface.
    pub id: u32,
    /// The convex body, z from the programmed tip, mm.
    pub body: &'a Profile,
    /// Remove or probe.
    pub action: Action,
    /// The motion.
    pub motion: SweepMotion,
}

/// What one motion met in the stock as it stood at that moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepReport {
    /// Volume removed or overlapped, mm³: mean of the three ray sets.
    pub volume_mm3: f64,
    /// Longest connected overlap on any ray, mm; 0 when the body only touches.
    pub overlap_mm: f64,
    /// Middle of that overlap; among equals the first in the order of the rays.
    pub first_point: Option<Point>,
    /// Box round all overlaps, empty when there is none: range of engagement.
    pub region: Option<Aabb>,
    /// Rays with overlap, all three sets.
    pub rays: u64,
}

/// An item made ready.
struct Ready {
    body: usize,
    id: u32,
    removes: bool,
    /// Box of the motion, mm.
    region: Aabb,
    /// Pieces for the ball and for the rest of the body, in [`Batch::pieces`].
    ball: std::ops::Range<usize>,
    rest: std::ops::Range<usize>,
}

/// Overlap of one item in one tile.
struct Partial {
    item: u32,
    rays: u32,
    length: f64,
    longest: f64,
    at: V,
    range: [f64; 2],
    u: [f64; 2],
    v: [f64; 2],
}

/// A tile on loan to a thread.
struct Work {
    index: usize,
    tile: Tile,
    /// Range of the bin in the list of entries.
    entries: std::ops::Range<usize>,
    found: Vec<Partial>,
    /// Range of removal along the rays, mm; lo > hi when none.
    changed: [f64; 2],
}

/// Entries of tiles and items that one pass may hold: bounds the memory of a batch to some 100 MB.
const ENTRIES: usize = 8 << 20;
/// Items of one pass.
const ITEMS: usize = 16384;

impl TriDexel {
    /// Carries out the items in their order and reports on each.
    ///
    /// The result does not depend on the number of threads, nor on how a program is cut into batches: a tile sees its items
    /// in the given order, and sums run over the tiles in a fixed order. An item with a number that is not finite meets
    /// nothing.
    pub fn sweep(&mut self, items: &[SweepItem<'_>]) -> Vec<SweepReport> {
        let mut reports = vec![SweepReport::default(); items.len()];
        let mut bodies: Vec<(*const Profile, Meridian)> = Vec::new();
        let index: Vec<usize> = items
            .iter()
            .map(|item| {
                let address = std::ptr::from_ref(item.body);
                bodies.iter().position(|b| b.0 == address).unwrap_or_else(|| {
                    bodies.push((address, Meridian::split(item.body)));
                    bodies.len() - 1
                })
            })
            .collect();
        let bodies: Vec<Meridian> = bodies.into_iter().map(|b| b.1).collect();
        for first in (0..items.len()).step_by(ITEMS) {
            let last = (first + ITEMS).min(items.len());
            self.pass(&items[first..last], &index[first..last], &bodies, &mut reports[first..last]);
        }
        reports
    }

    fn pass(&mut self, items: &[SweepItem<'_>], index: &[usize], bodies: &[Meridian], reports: &mut [SweepReport]) {
        let split: Vec<[Vec<Piece>; 2]> = items
            .par_iter()
            .zip(index)
            .with_min_len(64)
            .map(|(item, &body)| {
                let body = &bodies[body];
                [
                    body.ball.map_or_else(Vec::new, |[z, _]| motion::ball_pieces(&item.motion, z)),
                    if body.has_rest { motion::pieces(&item.motion, body.radius) } else { Vec::new() },
                ]
            })
            .collect();
        let mut ready = Vec::with_capacity(items.len());
        let mut pieces: [Vec<Piece>; 3] = [Vec::new(), Vec::new(), Vec::new()];
        for ((item, &body), split) in items.iter().zip(index).zip(&split) {
            let mut ranges = split.iter().map(|split| {
                let first = pieces[0].len();
                for p in split {
                    for (a, list) in pieces.iter_mut().enumerate() {
                        list.push(motion::permuted(p, a));
                    }
                }
                first..pieces[0].len()
            });
            let (ball, rest) = (ranges.next().unwrap_or(0..0), ranges.next().unwrap_or(0..0));
            let path = if rest.is_empty() { &split[0] } else { &split[1] };
            ready.push(Ready {
                body,
                id: item.id,
                removes: item.action == Action::Remove,
                // Smaller as the body is, so that its flat faces lie on the box.
                region: motion::swept_box(path, &bodies[body]).expanded(-TOUCH),
                ball,
                rest,
            });
            let turns = path.iter().any(Piece::turns);
            let bound = SEARCH_ERROR + 2.0 * TOUCH + if turns { TURN_ERROR } else { 0.0 };
            self.sweep_bound = self.sweep_bound.max(bound);
        }
        let batch = Batch { ready, pieces, bodies };
        let mut first = 0;
        while first < batch.ready.len() {
            let (bins, next) = self.bin(&batch, first);
            self.run(&batch, bins, reports);
            first = next;
        }
    }

    /// Tiles that the region of an item can touch: first and last (excluded) tile along u and v of set `a`.
    fn tile_range(&self, region: &Aabb, a: usize) -> Option<[[usize; 2]; 2]> {
        let grid = &self.grid;
        if region.is_empty() || !(region.min[a] < grid.bounds.max[a] && region.max[a] > grid.bounds.min[a]) {
            return None;
        }
        let along = |axis: usize| {
            let first = grid.first_at_or_above(axis, region.min[axis]);
            let last = grid.first_at_or_above(axis, region.max[axis]);
            (first < last).then(|| [first / TILE, (last - 1) / TILE + 1])
        };
        Some([along((a + 1) % 3)?, along((a + 2) % 3)?])
    }

    /// Sorts items into the tiles that they may touch, in the order of the items, until the pass is full.
    fn bin(&self, batch: &Batch<'_>, first: usize) -> (Bins, usize) {
        let mut count = 0;
        let mut next = first;
        while next < batch.ready.len() && (next == first || count < ENTRIES) {
            for a in 0..3 {
                if let Some([u, v]) = self.tile_range(&batch.ready[next].region, a) {
                    count += (u[1] - u[0]) * (v[1] - v[0]);
                }
            }
            next += 1;
        }
        let sets: Vec<(Vec<u32>, Vec<u32>)> = (0..3_usize)
            .into_par_iter()
            .map(|a| {
                let base = self.grid.first_tile[a];
                let tiles = &self.tiles[base..self.grid.first_tile[a + 1]];
                let mut pairs: Vec<(u32, u32)> = Vec::new();
                for (k, item) in batch.ready[first..next].iter().enumerate() {
                    let Some([u, v]) = self.tile_range(&item.region, a) else { continue };
                    for j in v[0]..v[1] {
                        for i in u[0]..u[1] {
                            let t = j * self.grid.tiles[a][0] + i;
                            // Material only shrinks: what the item misses now it will miss later.
                            let tile = &tiles[t];
                            if tile.lo < item.region.max[a] && tile.hi > item.region.min[a] {
                                pairs.push((t as u32, (first + k) as u32));
                            }
                        }
                    }
                }
                let mut start = vec![0_u32; tiles.len() + 1];
                for &(t, _) in &pairs {
                    start[t as usize + 1] += 1;
                }
                for t in 0..tiles.len() {
                    start[t + 1] += start[t];
                }
                let mut entries = vec![0; pairs.len()];
                let mut cursor = start.clone();
                for (t, item) in pairs {
                    entries[cursor[t as usize] as usize] = item;
                    cursor[t as usize] += 1;
                }
                (start, entries)
            })
            .collect();
        let mut bins = Bins { entries: Vec::new(), tiles: Vec::new() };
        for (a, (start, entries)) in sets.into_iter().enumerate() {
            let base = bins.entries.len();
            for t in 0..start.len() - 1 {
                if start[t] < start[t + 1] {
                    let range = base + start[t] as usize..base + start[t + 1] as usize;
                    bins.tiles.push((self.grid.first_tile[a] + t, range));
                }
            }
            bins.entries.extend(entries);
        }
        (bins, next)
    }

    fn run(&mut self, batch: &Batch<'_>, bins: Bins, reports: &mut [SweepReport]) {
        let mut works: Vec<Work> = bins
            .tiles
            .into_iter()
            .map(|(index, entries)| Work {
                index,
                tile: std::mem::take(&mut self.tiles[index]),
                entries,
                found: Vec::new(),
                changed: [f64::INFINITY, f64::NEG_INFINITY],
            })
            .collect();
        let grid = &self.grid;
        works.par_iter_mut().with_max_len(16).for_each(|work| {
            let mut scratch = Scratch::default();
            let entries = work.entries.clone();
            for &item in &bins.entries[entries] {
                batch.item_on_tile(grid, work, item, &mut scratch);
            }
        });
        let area = self.grid.cell * self.grid.cell / 3.0;
        for work in works {
            let (a, _) = self.grid.tile_place(work.index);
            for p in &work.found {
                let report = &mut reports[p.item as usize];
                report.volume_mm3 += p.length * area;
                report.rays += u64::from(p.rays);
                if p.longest > report.overlap_mm {
                    report.overlap_mm = p.longest;
                    report.first_point = Some(Grid::point(a, p.at[0], p.at[1], p.at[2]));
                }
                let low = Grid::point(a, p.range[0], p.u[0], p.v[0]);
                let high = Grid::point(a, p.range[1], p.u[1], p.v[1]);
                let region = Aabb { min: low, max: high };
                report.region = Some(report.region.map_or(region, |r| r.union(&region)));
            }
            if work.changed[0] < work.changed[1] {
                self.mark_changed(work.index, work.changed);
            }
            self.tiles[work.index] = work.tile;
        }
    }
}

/// Items sorted by tile.
struct Bins {
    entries: Vec<u32>,
    tiles: Vec<(usize, std::ops::Range<usize>)>,
}

struct Batch<'a> {
    ready: Vec<Ready>,
    pieces: [Vec<Piece>; 3],
    bodies: &'a [Meridian],
}

/// Buffers of one thread.
#[derive(Default)]
struct Scratch {
    /// Pieces of the motion that may touch the tile; true: with the ball, false: with the rest of the body.
    near: Vec<(usize, bool)>,
    spaces: Vec<(usize, bool, HalfSpace)>,
    rays: Vec<(usize, Ray)>,
    taken: Vec<Taken>,
    cuts: Vec<Cut>,
    left: Vec<Span>,
}

/// Rays on one side of a patch.
const PATCH: usize = 4;

/// Box in ray coordinates: middle and half lengths.
struct Block {
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
struct HalfSpace {
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
    fn item_on_tile(&self, grid: &Grid, work: &mut Work, item: u32, scratch: &mut Scratch) {
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
        // Patches of rays share one half space for each piece, which clears most of them at the cost of a product.
        for patch_j in (j_from - j_from % PATCH..j_to).step_by(PATCH) {
            let j = [patch_j.max(j_from), (patch_j + PATCH).min(j_to)];
            for patch_i in (i_from - i_from % PATCH..i_to).step_by(PATCH) {
                let i = [patch_i.max(i_from), (patch_i + PATCH).min(i_to)];
                self.item_on_patch(grid, work, ready, a, i, j, scratch, &mut sum);
            }
        }
        if sum.rays > 0 {
            if ready.removes {
                work.tile.update_range();
                work.changed = [work.changed[0].min(sum.range[0]), work.changed[1].max(sum.range[1])];
            }
            work.found.push(sum);
        }
    }

    /// Carries out an item on the rays `i` x `j` of a tile.
    #[allow(clippy::too_many_arguments, reason = "the place of the patch and the state of the thread")]
    fn item_on_patch(
        &self,
        grid: &Grid,
        work: &mut Work,
        ready: &Ready,
        a: usize,
        i: [usize; 2],
        j: [usize; 2],
        scratch: &mut Scratch,
        sum: &mut Partial,
    ) {
        let (u_axis, v_axis) = ((a + 1) % 3, (a + 2) % 3);
        let (min, max) = (ready.region.min[a], ready.region.max[a]);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut columns = range;
        scratch.rays.clear();
        for row in j[0]..j[1] {
            for column in i[0]..i[1] {
                let r = row % TILE * TILE + column % TILE;
                let spans = work.tile.ray(r);
                // Material in the region; slots that stand empty do not count.
                let Some(bottom) = spans.iter().find(|x| x.hi - min > SLIVER) else { continue };
                let Some(top) = spans.iter().rev().find(|x| max - x.lo > SLIVER) else { continue };
                let (lo, hi) = (bottom.lo.max(min), top.hi.min(max));
                if hi - lo > SLIVER {
                    let ray = Ray { u: grid.center(u_axis, column), v: grid.center(v_axis, row), lo, hi };
                    scratch.rays.push((r, ray));
                    range = [range[0].min(lo), range[1].max(hi)];
                    // Rays without material may leave any outline: the first and last ray need not span the columns.
                    columns = [columns[0].min(ray.u), columns[1].max(ray.u)];
                }
            }
        }
        if scratch.rays.is_empty() {
            return;
        }
        let side = |axis: usize, k: [usize; 2]| [grid.center(axis, k[0]), grid.center(axis, k[1] - 1)];
        let block = Block::new(range, side(u_axis, i), side(v_axis, j));
        let body = &self.bodies[ready.body];
        let pieces = &self.pieces[a];
        scratch.spaces.clear();
        for &(k, ball) in &scratch.near {
            let space = HalfSpace::new(&pieces[k], body, ball, &block);
            if !space.clears(&block) {
                scratch.spaces.push((k, ball, space));
            }
        }
        if scratch.spaces.is_empty() {
            return;
        }
        for (r, ray) in &scratch.rays {
            scratch.taken.clear();
            for (k, ball, space) in &scratch.spaces {
                if !space.clears_ray(ray) {
                    take(&pieces[*k], body, *ball, ray, &mut scratch.taken);
                }
            }
            if scratch.taken.is_empty() {
                continue;
            }
            cuts_of(&mut scratch.taken, ready.id, a, &mut scratch.cuts);
            let overlap = subtract(work.tile.ray(*r), &scratch.cuts, &mut scratch.left);
            if overlap.longest <= 0.0 {
                continue;
            }
            sum.add(ray, &overlap);
            if ready.removes {
                work.tile.replace(*r, &scratch.left);
            }
        }
    }
}

impl Partial {
    fn new(item: u32) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Self { item, rays: 0, length: 0.0, longest: 0.0, at: [0.0; 3], range: none, u: none, v: none }
    }

    fn add(&mut self, ray: &Ray, overlap: &Overlap) {
        self.rays += 1;
        self.length += overlap.length;
        if overlap.longest > self.longest {
            self.longest = overlap.longest;
            self.at = [overlap.middle, ray.u, ray.v];
        }
        self.range = [self.range[0].min(overlap.lo), self.range[1].max(overlap.hi)];
        self.u = [self.u[0].min(ray.u), self.u[1].max(ray.u)];
        self.v = [self.v[0].min(ray.v), self.v[1].max(ray.v)];
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

/// Joins intervals that meet and marks their ends: the material's outward normal is against the body's.
fn cuts_of(taken: &mut [Taken], id: u32, a: usize, cuts: &mut Vec<Cut>) {
    if taken.len() > 1 {
        taken.sort_by(|x, y| x.lo.s.total_cmp(&y.lo.s));
    }
    let mark = |n: V| {
        let mut world = [0.0; 3];
        world[a] = -n[0];
        world[(a + 1) % 3] = -n[1];
        world[(a + 2) % 3] = -n[2];
        Mark::new(id, world)
    };
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
