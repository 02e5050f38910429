//! One item on one tile: bounds that clear rows of rays, then the kernels, then the subtraction.

use crate::{
    grid::{Grid, TILE},
    lane_ball::{BallOnLanes, BallOnRows},
    lane_body::BodyOnLanes,
    lane_rows::BodyOnRows,
    lane_set::{Cut, LANES, Lanes, MET, Maker, ROW, Strip, UNPROVEN},
    ray::Ray,
    ray_ball::sweep_ball,
    ray_translate::sweep_translation,
    ray_turn::sweep_turning,
    span::{Mark, SLIVER},
    step::{Batch, Ready, Step},
    tile::Tile,
    tile_cut::{CutFirst, cut_lane, cut_more},
    tile_field::{Field, Partial},
    watch::Watch,
};

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

/// Where a lane of the second chance comes from: a block of `Field::more` or the lowest intervals, and the lane.
type Origin = (Option<usize>, usize);

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct Scratch {
    field: Field,
    /// Steps that may touch the tile, and the rows that they may.
    near: Vec<(usize, u8)>,
    again: Lanes,
    origin: Vec<Origin>,
    torn: Vec<Strip>,
    cuts: Vec<Cut>,
    /// Lanes of which more than one interval is taken.
    several: Vec<(Origin, Cut)>,
}

/// Parts of a turning motion for lanes that were not proven in one.
const PARTS: usize = 4;

impl Batch<'_> {
    /// Works through the items of a tile in their order.
    pub(crate) fn on_tile(&self, grid: &Grid, work: &mut Work, items: &[u32], scratch: &mut Scratch) {
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
                let apart = step.high[0].min(hi) - step.low[0].max(lo) <= SLIVER
                    || step.low[1] > u[1]
                    || step.high[1] < u[0]
                    || step.low[2] > v[1]
                    || step.high[2] < v[0];
                if apart {
                    continue;
                }
                if !filled {
                    scratch.field.fill(grid, work.index, &work.tile);
                    filled = true;
                }
                let rows = self.rows(step, ready, &scratch.field);
                if rows != 0 || scratch.field.has_many() {
                    scratch.near.push((k, rows));
                }
            }
            if scratch.near.is_empty() {
                continue;
            }
            let mut sum = Partial::new(item);
            let watched = ready.removes && (work.watch.undo.is_some() || self.moves.is_some());
            if watched {
                work.watch.before(&scratch.field);
            }
            self.item(ready, a, scratch, &mut sum);
            if sum.rays > 0 {
                if watched {
                    let old = |strip: &Strip, upper: bool| self.mark_of(a, &work.tile, strip, upper);
                    work.watch.after(&scratch.field, a, [item, ready.id], self.moves.as_ref(), old);
                }
                if ready.removes {
                    work.changed = [work.changed[0].min(sum.range[0]), work.changed[1].max(sum.range[1])];
                    (lo, hi) = (scratch.field.lo, scratch.field.hi);
                }
                work.found.push(sum);
            }
        }
        if filled && scratch.field.changed {
            let old = std::mem::take(&mut work.tile);
            work.tile = scratch.field.tile(|strip, upper| self.mark_of(a, &old, strip, upper));
        }
    }

    /// What made the lower or upper end of an interval: a step of this batch, or what the tile had before it.
    fn mark_of(&self, a: usize, old: &Tile, strip: &Strip, upper: bool) -> Mark {
        let (s, by, tau, sign) = if upper {
            (strip.hi, strip.hi_by, strip.hi_tau, -1.0)
        } else {
            (strip.lo, strip.lo_by, strip.lo_tau, 1.0)
        };
        if by >= 0.0 {
            return self.mark(a, by, [s, strip.u, strip.v], tau, sign);
        }
        let ends = old.ray(usize::from(strip.ray)).iter().map(|span| span.ends()[usize::from(upper)]);
        ends.into_iter().find(|e| e.s == s).map_or(Mark::NONE, |e| e.mark)
    }

    /// Rows of a tile that a step may meet.
    fn rows(&self, step: &Step, ready: &Ready, field: &Field) -> u8 {
        let (u, v, lo, hi) = (field.u, &field.row_v, &field.row_lo, &field.row_hi);
        match &step.ball {
            Some(path) => self.arch.dispatch(BallOnRows { path, u, v, lo, hi }),
            None => self.arch.dispatch(BodyOnRows { step, body: &self.bodies[ready.body], u, v, lo, hi }),
        }
    }

    /// A step for all lanes that are asked for; true when some may be left without proof.
    fn on_lanes(&self, step: &Step, ready: &Ready, maker: Maker, lanes: &mut Lanes) -> bool {
        match &step.ball {
            Some(path) => {
                self.arch.dispatch(BallOnLanes { path, maker, lanes });
                false
            }
            None => {
                let body = &self.bodies[ready.body];
                self.arch.dispatch(BodyOnLanes { piece: &step.piece, body, maker, lanes })
            }
        }
    }

    fn item(&self, ready: &Ready, a: usize, scratch: &mut Scratch, sum: &mut Partial) {
        let field = &mut scratch.field;
        let rows = scratch.near.iter().fold(0, |all, n| all | n.1);
        for row in (0..ROW).filter(|row| rows >> row & 1 == 1) {
            field.first.ask_row(row);
        }
        let mut more = false;
        if field.has_many() {
            let steps = &self.steps[a];
            for lanes in &mut field.more {
                for k in 0..lanes.len() {
                    let meets = |step: &Step| {
                        step.high[0].min(lanes.hi[k]) - step.low[0].max(lanes.lo[k]) > SLIVER
                            && (step.low[1] <= lanes.u[k] && lanes.u[k] <= step.high[1])
                            && (step.low[2] <= lanes.v[k] && lanes.v[k] <= step.high[2])
                    };
                    if scratch.near.iter().any(|&(s, _)| meets(&steps[s])) {
                        lanes.ask(k);
                        more = true;
                    }
                }
            }
        }
        if rows == 0 && !more {
            return;
        }
        // Two steps may take intervals apart from each other.
        let mut open = scratch.near.len() > 1;
        for &(k, step_rows) in &scratch.near {
            let (step, maker) = (&self.steps[a][k], Maker::whole(k));
            field.first.rows = step_rows;
            open |= self.on_lanes(step, ready, maker, &mut field.first);
            for lanes in field.more.iter_mut().filter(|l| l.rows != 0) {
                open |= self.on_lanes(step, ready, maker, lanes);
            }
        }
        field.first.rows = rows;
        if open {
            self.second_chance(ready, a, scratch);
        }
        let field = &mut scratch.field;
        let torn = &mut scratch.torn;
        self.arch.dispatch(CutFirst { field, removes: ready.removes, sum, torn });
        if more || !scratch.several.is_empty() {
            let mut counted = 0_u64;
            for k in (0..LANES).filter(|&k| field.first.state[k] == MET) {
                counted |= 1 << k;
            }
            cut_more(field, ready.removes, sum, torn, &mut counted);
            // From above: what is left below stays in the lane.
            for ((block, k), cut) in scratch.several.drain(..).rev() {
                cut_lane(field, block, k, &cut, ready.removes, sum, torn, &mut counted);
            }
        }
        field.first.hush();
        if more {
            field.more.iter_mut().for_each(Lanes::hush);
        }
        if sum.rays > 0 && ready.removes {
            if !torn.is_empty() {
                for strip in torn.drain(..) {
                    field.add(&strip);
                }
                field.torn = true;
            }
            if field.torn {
                field.settle();
            }
            field.measure();
        }
    }

    /// Lanes without proof again in parts of the motion, in which all bounds are smaller; what is still without proof is searched.
    fn second_chance(&self, ready: &Ready, a: usize, scratch: &mut Scratch) {
        scratch.origin.clear();
        let unproven = |lanes: &Lanes, k: &usize| lanes.state[*k] == UNPROVEN;
        let field = &scratch.field;
        scratch.origin.extend((0..LANES).filter(|k| unproven(&field.first, k)).map(|k| (None, k)));
        for (b, lanes) in field.more.iter().enumerate().filter(|l| l.1.rows != 0) {
            scratch.origin.extend((0..lanes.len()).filter(|k| unproven(lanes, k)).map(|k| (Some(b), k)));
        }
        // A straight motion gains nothing from parts.
        let steps = &self.steps[a];
        let straight = scratch.near.iter().any(|&(k, _)| steps[k].ball.is_none() && !steps[k].piece.turns());
        let origins = std::mem::take(&mut scratch.origin);
        for chunk in origins.chunks(LANES) {
            let again = &mut scratch.again;
            again.clear();
            for &(block, k) in chunk {
                let lanes = block.map_or(&scratch.field.first, |b| &scratch.field.more[b]);
                again.push(&lanes.strip(k));
                again.ask(again.len() - 1);
                if straight {
                    again.state[again.len() - 1] = UNPROVEN;
                }
            }
            if !straight {
                for &(k, _) in &scratch.near {
                    let step = &steps[k];
                    if step.ball.is_some() {
                        self.on_lanes(step, ready, Maker::whole(k), again);
                        continue;
                    }
                    for part in 0..PARTS {
                        let step = Step { piece: step.piece.part(part, PARTS), ..step.clone() };
                        self.on_lanes(&step, ready, Maker::part(k, part, PARTS), again);
                    }
                }
            }
            for (i, &(block, k)) in chunk.iter().enumerate() {
                let found = if scratch.again.state[i] == UNPROVEN {
                    self.search(ready, a, &scratch.near, &scratch.again.strip(i), &mut scratch.cuts);
                    match &scratch.cuts[..] {
                        [cut] => Some(*cut),
                        [] => None,
                        several => {
                            scratch.several.extend(several.iter().map(|cut| ((block, k), *cut)));
                            None
                        }
                    }
                } else {
                    (scratch.again.state[i] == crate::lane_set::TAKEN).then(|| scratch.again.cut(i))
                };
                let lanes = match block {
                    Some(b) => &mut scratch.field.more[b],
                    None => &mut scratch.field.first,
                };
                lanes.answer(k, found.as_ref());
            }
        }
        scratch.origin = origins;
    }

    /// What the steps take of one strip, by the searches that always end; rising and disjoint.
    fn search(&self, ready: &Ready, a: usize, near: &[(usize, u8)], strip: &Strip, cuts: &mut Vec<Cut>) {
        let ray = Ray { u: strip.u, v: strip.v, lo: strip.lo, hi: strip.hi };
        let body = &self.bodies[ready.body];
        cuts.clear();
        let mut taken = Vec::new();
        for &(k, _) in near {
            let step = &self.steps[a][k];
            taken.clear();
            match &step.ball {
                Some(path) => taken.extend(sweep_ball(path, &ray)),
                None if step.piece.turns() => sweep_turning(&step.piece, body, &ray, &mut taken),
                None => taken.extend(sweep_translation(&step.piece, body, &ray)),
            }
            let by = k as f64;
            cuts.extend(taken.iter().map(|t| Cut {
                from: t.lo.s,
                to: t.hi.s,
                from_by: by,
                to_by: by,
                from_tau: t.lo.tau,
                to_tau: t.hi.tau,
            }));
        }
        cuts.sort_by(|x, y| x.from.total_cmp(&y.from));
        cuts.dedup_by(|next, kept| {
            let meets = next.from <= kept.to + SLIVER;
            if meets && next.to > kept.to {
                (kept.to, kept.to_by, kept.to_tau) = (next.to, next.to_by, next.to_tau);
            }
            meets
        });
    }
}
