//! One item on one tile: bounds that clear blocks and rows of rays, then the kernels, then the subtraction.

use crate::{
    field::batch::{Batch, ReadyItem},
    field::depth::RayLap,
    field::grid::{RayGrid, TILE},
    field::last_emptied::LastEmptied,
    field::span::{EndMark, MaterialSpan, SLIVER},
    field::tile::Tile,
    field::tile_cut::{CutLayer, cut_lane},
    field::tile_field::{Field, StripRest, TileOverlap},
    field::watch::Watch,
    kernels::lane_ball::{BallOnLanes, BallOnRows},
    kernels::lane_bits::lanes_of,
    kernels::lane_blocks::{BodyOnBlocks, rays_of},
    kernels::lane_body::BodyOnLanes,
    kernels::lane_search::MORE_STEPS,
    kernels::lane_set::{LANES, LaneCut, LaneStrip, Lanes, Maker, TAKEN, UNPROVEN},
    kernels::ray::RayLine,
    kernels::ray_ball::sweep_ball,
    kernels::ray_translate::sweep_translation,
    kernels::ray_turn::sweep_turning,
    kernels::sweep_step::SweepStep,
};

/// A tile on loan to a thread.
pub(crate) struct TileWork {
    pub index: usize,
    pub tile: Tile,
    pub lost: LastEmptied,
    pub watch: Watch,
    /// Range of the bin in the list of entries.
    pub entries: std::ops::Range<usize>,
    pub found: Vec<TileOverlap>,
    /// What measured items take up.
    pub laps: Vec<RayLap>,
    /// Range of removal along the rays, mm; lo > hi when none.
    pub changed: [f64; 2],
}

impl TileWork {
    /// True where something was taken away.
    pub(crate) fn is_cut(&self) -> bool {
        self.changed[0] < self.changed[1]
    }
}

/// Layer and lane.
type LanePlace = (usize, usize);
/// A step that may touch a layer, and the lanes that it may, one bit each.
pub(crate) type NearStep = (usize, usize, u64);

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct Scratch {
    pub field: Field,
    pub near: Vec<NearStep>,
    /// Lanes of each layer that any step may meet.
    pub asked: Vec<u64>,
    pub gathered: Lanes,
    again: Lanes,
    places: Vec<LanePlace>,
    torn: Vec<LaneStrip>,
    before: Vec<MaterialSpan>,
    cuts: Vec<LaneCut>,
    /// Lanes of which more than one interval is taken.
    several: Vec<(LanePlace, LaneCut)>,
    /// What a measured item takes of which interval.
    met: Vec<(LaneStrip, [f64; 2])>,
}

/// Parts of a turning motion for lanes that were not proven in one.
const PARTS: usize = 4;

impl Batch<'_> {
    /// Works through the items of a tile in their order.
    pub(crate) fn on_tile(&self, grid: &RayGrid, work: &mut TileWork, items: &[u32], scratch: &mut Scratch) {
        let (a, [i0, j0]) = grid.tile_place(work.index);
        let side = |axis: usize, first: usize| {
            let last = grid.n[axis].min(first + TILE) - 1;
            [grid.center(axis, first), grid.center(axis, last)]
        };
        let (u, v) = (side((a + 1) % 3, i0), side((a + 2) % 3, j0));
        let mut filled = false;
        let (mut lo, mut hi) = (work.tile.lo, work.tile.hi);
        for &item in items {
            let ready = &self.ready[item as usize];
            scratch.near.clear();
            for k in ready.steps.clone() {
                let step = &self.steps[a][k];
                let (low, high) = (step.low[0].max(lo), step.high[0].min(hi));
                let apart = high - low <= SLIVER
                    || step.low[1] > u[1]
                    || step.high[1] < u[0]
                    || step.low[2] > v[1]
                    || step.high[2] < v[0]
                    || match &step.ball {
                        Some(path) => path.passes([low, high], u, v),
                        None => {
                            // Without a turn blocks take less than this does.
                            step.passes([low, high], u, v)
                                || step.piece.turns() && step.clears(&self.bodies[ready.body], [low, high], u, v)
                        }
                    };
                if apart {
                    continue;
                }
                if !filled {
                    scratch.field.fill(grid, work.index, &work.tile);
                    filled = true;
                }
                for l in 0..scratch.field.layers().len() {
                    let lanes = self.near(step, ready, &mut scratch.field, l);
                    if lanes != 0 {
                        scratch.near.push((k, l, lanes));
                    }
                }
            }
            if scratch.near.is_empty() {
                continue;
            }
            let mut sum = TileOverlap::new(item);
            let watched = ready.removes && (work.watch.undo.is_some() || self.moves.is_some());
            if watched {
                work.watch.before_item(&scratch.field);
            }
            self.item(ready, a, scratch, &mut sum, &mut work.lost);
            if sum.rays > 0 {
                for (strip, [lo, hi]) in scratch.met.drain(..) {
                    let r = usize::from(strip.ray);
                    let old =
                        |reached: bool, upper: bool| reached.then(|| self.mark_of(a, work.tile.ray(r), &strip, upper));
                    let ends = [old(lo == strip.lo, false), old(hi == strip.hi, true)];
                    let ray = (a as u8, (i0 + r % TILE) as u32, (j0 + r / TILE) as u32);
                    work.laps.push(RayLap { item, ray, lo, hi, ends });
                }
                if watched {
                    let tile = &work.tile;
                    let old = |strip: &LaneStrip, upper: bool| {
                        self.mark_of(a, tile.ray(usize::from(strip.ray)), strip, upper)
                    };
                    work.watch.after_item(&scratch.field, a, [item, ready.id], self.moves.as_ref(), old);
                }
                if ready.removes {
                    work.changed = [work.changed[0].min(sum.range[0]), work.changed[1].max(sum.range[1])];
                    (lo, hi) = (scratch.field.lo, scratch.field.hi);
                }
                work.found.push(sum);
            }
        }
        work.watch.drop_buffers();
        if filled && scratch.field.changed {
            let mark = |strip: &LaneStrip, upper: bool, before: &[MaterialSpan]| self.mark_of(a, before, strip, upper);
            scratch.field.write(&mut work.tile, &mut scratch.before, mark);
        }
    }

    /// What made the lower or upper end of an interval: a step of this batch, or what its ray had `before`
    /// it.
    fn mark_of(&self, a: usize, before: &[MaterialSpan], strip: &LaneStrip, upper: bool) -> EndMark {
        let (s, by, tau, sign) = if upper {
            (strip.hi, strip.hi_by, strip.hi_tau, -1.0)
        } else {
            (strip.lo, strip.lo_by, strip.lo_tau, 1.0)
        };
        if by >= 0.0 {
            return self.mark(a, by, [s, strip.u, strip.v], tau, sign);
        }
        before.iter().map(|span| span.ends()[usize::from(upper)]).find(|e| e.s == s).map_or(EndMark::NONE, |e| e.mark)
    }

    /// Lanes of a layer that a step may meet, one bit each.
    fn near(&self, step: &SweepStep, ready: &ReadyItem, field: &mut Field, l: usize) -> u64 {
        match &step.ball {
            Some(path) => {
                let layer = &field.layers()[l];
                let (u, v, lo, hi) = (field.u, &field.row_v, &layer.row_lo, &layer.row_hi);
                lanes_of(self.arch.dispatch(BallOnRows { path, u, v, lo, hi }))
            }
            None => {
                field.layers_mut()[l].measure_blocks();
                let (body, places, layer) = (&self.bodies[ready.body], &field.places, &field.layers()[l]);
                let (lo, hi) = (&layer.block_lo, &layer.block_hi);
                rays_of(self.arch.dispatch(BodyOnBlocks { step, body, places, lo, hi }))
            }
        }
    }

    /// A step for all lanes that are asked for; true when some may be left without proof.
    pub(crate) fn on_lanes(
        &self,
        step: &SweepStep,
        ready: &ReadyItem,
        maker: Maker,
        steps: usize,
        lanes: &mut Lanes,
    ) -> bool {
        match &step.ball {
            Some(path) => {
                self.arch.dispatch(BallOnLanes { path, maker, lanes });
                false
            }
            None => {
                let (body, range) = (&self.bodies[ready.body], [step.low[0], step.high[0]]);
                self.arch.dispatch(BodyOnLanes { piece: &step.piece, range, body, maker, steps, lanes })
            }
        }
    }

    fn item(&self, ready: &ReadyItem, a: usize, scratch: &mut Scratch, sum: &mut TileOverlap, lost: &mut LastEmptied) {
        let open = self.on_near(ready, a, scratch);
        if open {
            self.retry_in_parts(ready, a, scratch);
        }
        let Scratch { field, torn, several, met, .. } = scratch;
        met.clear();
        let mut counted = [0.0; LANES];
        for l in (0..field.layers().len()).rev() {
            let layer = &mut field.layers_mut()[l];
            if layer.lanes.rows == 0 {
                continue;
            }
            if ready.measured {
                note_taken(&layer.lanes, several.iter().filter(|s| s.0.0 == l).map(|s| (s.0.1, &s.1)), met);
            }
            let mut gone = 0;
            let removes = ready.removes;
            self.arch.dispatch(CutLayer { layer, removes, sum, counted: &mut counted, torn, gone: &mut gone });
            layer.lanes.clear_requests();
            for strip in torn.drain(..) {
                field.insert_above(l, &strip);
            }
            while gone != 0 {
                let r = gone.trailing_zeros() as usize;
                lost.set(r, ready.id);
                if l + 1 < field.layers().len() {
                    field.close_gap(l, r);
                }
                gone &= gone - 1;
            }
            // From above: what is left below stays in the lane.
            for (place, cut) in several.iter().rev().filter(|s| s.0.0 == l) {
                if cut_lane(field, *place, cut, removes, sum, &mut counted) {
                    lost.set(place.1, ready.id);
                }
            }
        }
        several.clear();
        if sum.rays > 0 && ready.removes {
            field.changed = true;
            field.measure();
        }
    }

    /// Lanes without proof again in parts of the motion, in which all bounds are smaller; what is still
    /// without proof is searched.
    fn retry_in_parts(&self, ready: &ReadyItem, a: usize, scratch: &mut Scratch) {
        let mut places = std::mem::take(&mut scratch.places);
        places.clear();
        for (l, layer) in scratch.field.layers().iter().enumerate().filter(|l| l.1.lanes.rows != 0) {
            places.extend((0..LANES).filter(|&r| layer.lanes.state[r] == UNPROVEN).map(|r| (l, r)));
        }
        let mut near: Vec<usize> = scratch.near.iter().map(|n| n.0).collect();
        near.dedup();
        let steps = &self.steps[a];
        for chunk in places.chunks(LANES) {
            let again = &mut scratch.again;
            again.clear();
            for &(l, r) in chunk {
                again.push(&scratch.field.layers()[l].lanes.strip(r));
            }
            for &k in &near {
                let step = &steps[k];
                // A straight motion gains nothing from parts.
                if step.ball.is_some() || !step.piece.turns() {
                    self.on_lanes(step, ready, Maker::whole(k), MORE_STEPS, again);
                    continue;
                }
                for part in 0..PARTS {
                    let step = step.part(part, PARTS);
                    let maker = Maker::part(k, part, PARTS);
                    let before: Vec<(f64, LaneCut)> =
                        (0..chunk.len()).map(|i| (again.state[i], again.cut(i))).collect();
                    if self.on_lanes(&step, ready, maker, MORE_STEPS, again) {
                        let left = (0..chunk.len()).filter(|&i| before[i].0 != UNPROVEN);
                        for i in left {
                            if again.state[i] == UNPROVEN {
                                self.search_part(&step, ready, maker, i, &before[i], again);
                            }
                        }
                    }
                }
            }
            for (i, &(l, r)) in chunk.iter().enumerate() {
                let found = if scratch.again.state[i] == UNPROVEN {
                    self.search(ready, a, &near, &scratch.again.strip(i), &mut scratch.cuts);
                    match &scratch.cuts[..] {
                        [cut] => Some(*cut),
                        [] => None,
                        several => {
                            scratch.several.extend(several.iter().map(|cut| ((l, r), *cut)));
                            None
                        }
                    }
                } else {
                    (scratch.again.state[i] == TAKEN).then(|| scratch.again.cut(i))
                };
                scratch.field.layers_mut()[l].lanes.answer(r, found.as_ref());
            }
        }
        scratch.places = places;
    }

    /// The search for one lane in one part of a motion, added to what the lane had `before`; without proof it
    /// stays where the intervals are apart.
    fn search_part(
        &self,
        step: &SweepStep,
        ready: &ReadyItem,
        maker: Maker,
        i: usize,
        before: &(f64, LaneCut),
        lanes: &mut Lanes,
    ) {
        let strip = lanes.strip(i);
        let ray = RayLine { u: strip.u, v: strip.v, lo: strip.lo, hi: strip.hi };
        let mut taken = Vec::new();
        sweep_turning(&step.piece, &self.bodies[ready.body], &ray, &mut taken);
        let mut cuts: Vec<LaneCut> = taken.iter().map(|t| maker.cut(t)).collect();
        cuts.extend((before.0 == TAKEN).then_some(before.1));
        merge(&mut cuts);
        if cuts.len() < 2 {
            lanes.answer(i, cuts.first());
        }
    }

    /// What the steps take of one strip, by the searches that always end; rising and disjoint.
    fn search(&self, ready: &ReadyItem, a: usize, near: &[usize], strip: &LaneStrip, cuts: &mut Vec<LaneCut>) {
        let ray = RayLine { u: strip.u, v: strip.v, lo: strip.lo, hi: strip.hi };
        let body = &self.bodies[ready.body];
        cuts.clear();
        let mut taken = Vec::new();
        for &k in near {
            let step = &self.steps[a][k];
            taken.clear();
            match &step.ball {
                Some(path) => taken.extend(sweep_ball(path, &ray)),
                None if step.piece.turns() => sweep_turning(&step.piece, body, &ray, &mut taken),
                None => taken.extend(sweep_translation(&step.piece, body, &ray)),
            }
            cuts.extend(taken.iter().map(|t| Maker::whole(k).cut(t)));
        }
        merge(cuts);
    }
}

/// What is about to be taken of the lanes of a layer; `several` are the lanes of which more than one interval
/// goes.
fn note_taken<'a>(
    lanes: &Lanes,
    several: impl Iterator<Item = (usize, &'a LaneCut)>,
    met: &mut Vec<(LaneStrip, [f64; 2])>,
) {
    let mut take = |r: usize, cut: &LaneCut| {
        let strip = lanes.strip(r);
        // What is left as a sliver counts as gone: there the end of the material is reached.
        met.extend(StripRest::of(&strip, cut).map(|left| {
            let lo = if left.below.is_none() { strip.lo } else { left.met[0] };
            let hi = if left.above.is_none() { strip.hi } else { left.met[1] };
            (strip, [lo, hi])
        }));
    };
    for r in (0..LANES).filter(|&r| lanes.state[r] == TAKEN) {
        take(r, &lanes.cut(r));
    }
    several.for_each(|(r, cut)| take(r, cut));
}

/// Sorts intervals and joins those that meet.
fn merge(cuts: &mut Vec<LaneCut>) {
    cuts.sort_by(|x, y| x.from.total_cmp(&y.from));
    cuts.dedup_by(|next, kept| {
        let meets = next.from <= kept.to + SLIVER;
        if meets && next.to > kept.to {
            (kept.to, kept.to_by, kept.to_tau) = (next.to, next.to_by, next.to_tau);
        }
        meets
    });
}
