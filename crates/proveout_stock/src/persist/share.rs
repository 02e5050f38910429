//! One stock cut by several processes: each cuts the tiles of its share, and their logs are merged
//! into the whole.
//!
//! A tile processes its items in order and knows nothing of its neighbors, so tiles can be cut
//! anywhere. What is made of all of them (sums of a report, passes, blocks whose surface changed,
//! depths) is made where the shares come together, from the same numbers in the same order as in a
//! single process:
//!
//! ```text
//!   single   items ─► sorted into tiles ─► each tile cut ────────────────────────► settled ─► reports
//!   share k  items ─► sorted into tiles ─► each tile of k cut ─► as bytes ──────┐
//!   merged                                           bytes of all, by tile ─────┴► settled ─► reports
//! ```
//!
//! So stock and reports are the same bits for any division into shares; the tests compare them with
//! the single process. A share has whole rows of tiles and no material in those of others, so its
//! items are sorted past them row by row. The boxes of all items are computed in each share again,
//! since the bound of the sweeps is over all.

use crate::{
    StockFileError,
    field::depth::{Deepest, Depths, Measure, RayLap},
    field::dexel::TriDexel,
    field::engagement::{Contact, PassMotions},
    field::grid::RayGrid,
    field::span::EndMark,
    field::sweep::{SweepReport, bodies_of, chunks},
    field::tile::Tile,
    field::tile_field::TileOverlap,
    field::tile_work::TileWork,
    field::watch::Watch,
    persist::codec::{ByteFault, Decoder, Encoder, below},
    persist::sweep_log::{rays_end_in, read_lost, read_tile, read_undo, write_lost, write_tile, write_undo},
    sweep_item::SweepItem,
};

/// Bits of the first byte of the record of a tile.
const CUT: u64 = 1;
const UNDO: u64 = 2;

/// Gives every part to one of `shares` so that the sums of their loads are alike: the heaviest first, to
/// whoever has least.
fn shares_of(loads: &[u64], shares: u16) -> Vec<u16> {
    let shares = shares.max(1);
    let mut order: Vec<usize> = (0..loads.len()).collect();
    order.sort_by_key(|&t| (std::cmp::Reverse(loads[t]), t));
    let mut sums = vec![0_u64; usize::from(shares)];
    let mut owners = vec![0; loads.len()];
    for t in order {
        let least = (0..sums.len()).min_by_key(|&k| sums[k]).unwrap_or(0);
        sums[least] = sums[least].saturating_add(loads[t]);
        owners[t] = least as u16;
    }
    owners
}

/// Rows of tiles, over all three sets: the row of every tile.
fn rows(grid: &RayGrid) -> Vec<usize> {
    let mut first = 0;
    let mut all = Vec::with_capacity(grid.first_tile[3]);
    for [across, rows] in grid.tiles {
        all.extend((0..across * rows).map(|t| first + t / across.max(1)));
        first += rows;
    }
    all
}

/// Writes what sweeps did to the tiles of a share.
#[derive(Default)]
pub struct ShareLog(Encoder);

impl ShareLog {
    /// The recorded bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0.bytes
    }
}

/// Reads the record of one share, in the order in which it was written.
pub struct ShareReplay<'a>(Decoder<'a>);

impl<'a> ShareReplay<'a> {
    /// Reads the bytes of a log.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(Decoder::new(bytes))
    }

    /// True when all was read.
    pub fn is_done(&self) -> bool {
        self.0.is_done()
    }
}

impl TriDexel {
    /// Tiles of rays: entries of the loads and owners of a division into shares.
    pub fn ray_tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Adds to each tile how many of the items come to it, as long as nothing is cut.
    pub fn add_loads(&mut self, items: &[SweepItem<'_>], loads: &mut [u64]) {
        let (index, bodies) = bodies_of(items);
        let bound = self.sweep_bound;
        for chunk in chunks(items, &[]) {
            let batch = self.batch(chunk.items, chunk.measures, &index[chunk.range.clone()], &bodies);
            let mut first = 0;
            while first < batch.ready.len() {
                let (bins, next) = self.bin(&batch, first);
                for (tile, entries) in bins.tiles {
                    loads[tile] += entries.len() as u64;
                }
                first = next;
            }
        }
        self.sweep_bound = bound;
    }

    /// Gives every tile to one of `shares`, by whole rows of tiles: what a motion has to do with a row of
    /// another share is settled by one look. `loads` as [`Self::add_loads`] counts them.
    pub fn share_rows(&self, loads: &[u64], shares: u16) -> Vec<u16> {
        let rows = rows(&self.grid);
        let mut sums = vec![0_u64; rows.last().map_or(0, |last| last + 1)];
        // A tile that nothing comes to still takes memory.
        rows.iter().zip(loads).for_each(|(&row, load)| sums[row] = sums[row].saturating_add(*load).saturating_add(1));
        let owners = shares_of(&sums, shares);
        rows.into_iter().map(|row| owners[row]).collect()
    }

    /// The stock with material in the tiles of a share alone. `owners` has one entry a tile.
    #[must_use]
    pub fn share(&self, owners: &[u16], share: u16) -> Self {
        let own = |(tile, owner): (&Tile, &u16)| if *owner == share { tile.clone() } else { Tile::default() };
        let mut part = Self {
            grid: self.grid.clone(),
            tiles: self.tiles.iter().zip(owners).map(own).collect(),
            initial_volume: self.initial_volume,
            sweep_bound: self.sweep_bound,
            regrid: self.regrid,
            changed: self.changed.clone(),
            passes: self.passes,
            cut_in: self.cut_in.clone(),
            history: None,
            lost: self.lost.clone(),
            watch_engagement: self.watch_engagement,
            slice_plan: None,
            slices: Vec::new(),
            empty_rows: Vec::new(),
        };
        if self.history.is_some() {
            part.keep_history();
        }
        part.pass_over_empty_rows();
        part
    }

    /// Has sweeps pass over rows of tiles that hold nothing now: for a share, most of whose rows are those of
    /// others.
    pub fn pass_over_empty_rows(&mut self) {
        let rows = rows(&self.grid);
        self.empty_rows = vec![true; rows.last().map_or(0, |last| last + 1)];
        for (row, tile) in rows.into_iter().zip(&self.tiles) {
            self.empty_rows[row] &= tile.is_empty();
        }
    }

    /// Carries out the items on the tiles of a share, and records the results.
    pub fn sweep_share(&mut self, items: &[SweepItem<'_>], measures: &[Measure], log: &mut ShareLog) {
        let (index, bodies) = bodies_of(items);
        let out = &mut log.0;
        let mut reports = vec![SweepReport::default(); items.len()];
        for chunk in chunks(items, measures) {
            let mut batch = self.batch(chunk.items, chunk.measures, &index[chunk.range.clone()], &bodies);
            batch.moves = self.watch_engagement.then(|| PassMotions::new(chunk.items, &index[chunk.range.clone()]));
            out.real(self.sweep_bound);
            let mut first = 0;
            while first < batch.ready.len() {
                let (bins, next) = self.bin(&batch, first);
                let known: Vec<usize> = match &self.history {
                    Some(history) => bins.tiles.iter().map(|(t, _)| history.tiles[*t].changes.len()).collect(),
                    None => vec![0; bins.tiles.len()],
                };
                let works = self.works(&batch, bins);
                out.number((next - first) as u64);
                let met = || works.iter().zip(&known).filter(|(w, _)| !w.found.is_empty());
                out.number(met().count() as u64);
                let mut before = 0;
                for (work, known) in met() {
                    out.number((work.index - before) as u64);
                    before = work.index;
                    write_work(out, work, *known);
                }
                self.put_back_tiles(works, &mut reports[chunk.range.clone()]);
                first = next;
            }
        }
    }

    /// Applies the recorded results of all shares for the items to the stock, and returns their
    /// reports.
    ///
    /// # Errors
    /// [`StockFileError`] where the bytes are not those of a share of these items; the stock is then spoiled.
    pub fn apply_shares(
        &mut self,
        items: &[SweepItem<'_>],
        measures: &[Measure],
        depths: &mut Depths,
        told: &mut [ShareReplay<'_>],
    ) -> Result<Vec<SweepReport>, StockFileError> {
        let mut reports = vec![SweepReport::default(); items.len()];
        for chunk in chunks(items, measures) {
            let mut bound = self.sweep_bound;
            for share in told.iter_mut() {
                bound = bound.max(share.0.real()?);
            }
            self.sweep_bound = bound;
            let (mut first, mut deepest) = (0, Deepest::default());
            while first < chunk.items.len() {
                let mut works = Vec::new();
                let mut pass = None;
                for share in told.iter_mut() {
                    let input = &mut share.0;
                    let count = below(input, (chunk.items.len() - first) as u64 + 1, "a pass of more items")? as usize;
                    if count == 0 || pass.is_some_and(|p| p != count) {
                        return Err(input.fault("the passes of the shares are others").into());
                    }
                    pass = Some(count);
                    self.take_works(input, (chunk.items.len(), first + count), &mut works)?;
                }
                let Some(count) = pass else {
                    return Err(Decoder::new(&[]).fault("there is no share").into());
                };
                works.sort_by_key(|work| work.index);
                let laps = works.iter_mut().flat_map(|work| std::mem::take(&mut work.laps)).collect();
                let reports = &mut reports[chunk.range.clone()];
                self.put_back_tiles(works, reports);
                self.measure(&chunk, laps, reports, (depths, &mut deepest));
                first += count;
            }
        }
        Ok(reports)
    }

    /// Reads the tiles of one share in one pass; tiles that were not cut stay as they are.
    fn take_works(
        &mut self,
        input: &mut Decoder<'_>,
        (items, until): (usize, usize),
        works: &mut Vec<TileWork>,
    ) -> Result<(), ByteFault> {
        let mut tile = 0;
        for k in 0..below(input, self.tiles.len() as u64 + 1, "more tiles than the stock has")? {
            let step = below(input, (self.tiles.len() - tile) as u64, "a tile that the stock does not have")? as usize;
            if k > 0 && step == 0 {
                return Err(input.fault("a tile that occurs twice"));
            }
            tile += step;
            let undo = self.history.as_mut().map(|h| std::mem::take(&mut h.tiles[tile]));
            let mut work = TileWork {
                index: tile,
                tile: std::mem::take(&mut self.tiles[tile]),
                lost: std::mem::take(&mut self.lost[tile]),
                watch: Watch::new(undo),
                entries: 0..0,
                found: Vec::new(),
                laps: Vec::new(),
                changed: [f64::INFINITY, f64::NEG_INFINITY],
            };
            read_work(input, &mut work, (items.min(until), rays_end_in(&self.grid, tile)))?;
            works.push(work);
        }
        Ok(())
    }
}

fn write_work(out: &mut Encoder, work: &TileWork, known: usize) {
    let undo = work.watch.undo.as_ref();
    out.number(if work.is_cut() { CUT } else { 0 } | if undo.is_some() { UNDO } else { 0 });
    out.number(work.found.len() as u64);
    for p in &work.found {
        out.number(u64::from(p.item));
        out.number(u64::from(p.rays));
        out.bytes.extend([p.ray, p.columns, p.rows]);
        [p.length, p.longest, p.middle, p.range[0], p.range[1]].into_iter().for_each(|x| out.real(x));
    }
    out.number(work.watch.contacts.len() as u64);
    for (item, c) in &work.watch.contacts {
        out.number(u64::from(*item));
        [c.height, c.across, c.angle].iter().flatten().chain([&c.advance]).for_each(|x| out.real(*x));
    }
    out.number(work.laps.len() as u64);
    for lap in &work.laps {
        let (set, i, j) = lap.ray;
        [u64::from(lap.item), u64::from(set), u64::from(i), u64::from(j)].into_iter().for_each(|n| out.number(n));
        out.real(lap.lo);
        out.real(lap.hi);
        for end in lap.ends {
            out.number(u64::from(end.is_some()));
            if let Some(mark) = end {
                out.number(u64::from(mark.id));
                out.number(u64::from(mark.code()));
            }
        }
    }
    if work.is_cut() {
        work.changed.iter().for_each(|x| out.real(*x));
        write_tile(out, &work.tile);
        write_lost(out, &work.lost);
    }
    if let Some(undo) = undo {
        write_undo(out, undo, known);
    }
}

fn read_work(input: &mut Decoder<'_>, work: &mut TileWork, (items, room): (usize, [f64; 2])) -> Result<(), ByteFault> {
    let kind = below(input, 2 * UNDO, "a tile of no known kind")?;
    if (kind & UNDO != 0) != work.watch.undo.is_some() {
        return Err(input.fault("one keeps a history, and the other does not"));
    }
    let item = |input: &mut Decoder<'_>| Ok::<u32, ByteFault>(below(input, items as u64, "an invalid item")? as u32);
    for _ in 0..below(input, items as u64 + 1, "more items than there are")? {
        let mut p = TileOverlap::new(item(input)?);
        p.rays = below(input, 65, "more rays than a tile has")? as u32;
        [p.ray, p.columns, p.rows] = input.three()?;
        if usize::from(p.ray) >= crate::field::grid::TILE_RAYS || p.columns == 0 || p.rows == 0 {
            return Err(input.fault("a ray that the tile does not have"));
        }
        [p.length, p.longest, p.middle] = [input.real()?, input.real()?, input.real()?];
        p.range = [input.real()?, input.real()?];
        work.found.push(p);
    }
    for _ in 0..below(input, items as u64 + 1, "more items than there are")? {
        let at = item(input)?;
        let mut pair = || Ok::<[f64; 2], ByteFault>([input.real()?, input.real()?]);
        let [height, across, angle] = [pair()?, pair()?, pair()?];
        work.watch.contacts.push((at, Contact { height, across, angle, advance: input.real()? }));
    }
    for _ in 0..below(input, input.left() as u64 + 1, "more intervals than there are bytes")? {
        let at = item(input)?;
        let set = below(input, 3, "an invalid set of rays")? as u8;
        let mut place = || Ok::<u32, ByteFault>(below(input, 1 << 32, "an invalid ray")? as u32);
        let ray = (set, place()?, place()?);
        let (lo, hi) = (input.real()?, input.real()?);
        let mut ends = [None; 2];
        for end in &mut ends {
            if below(input, 2, "an invalid flag")? == 1 {
                let mut half = || Ok::<u32, ByteFault>(below(input, 1 << 32, "an invalid mark")? as u32);
                *end = Some(EndMark::from_code(half()?, half()?));
            }
        }
        work.laps.push(RayLap { item: at, ray, lo, hi, ends });
    }
    if kind & CUT != 0 {
        work.changed = [input.real()?, input.real()?];
        if !work.is_cut() {
            return Err(input.fault("a tile that is cut and is not"));
        }
        work.tile = read_tile(input, room)?;
        work.lost = read_lost(input)?;
    }
    if let Some(undo) = &mut work.watch.undo {
        read_undo(input, undo)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::persist::sweep_log::tests::{Random, batches, block, cutters, whole};

    #[test]
    fn shares_of_any_number_give_the_stock_of_a_single_process() {
        let cutters = cutters();
        for (seed, history, shares) in [(1, false, 1), (2, true, 2), (3, true, 3), (4, false, 8), (5, true, 40)] {
            let batches = batches(&cutters, &mut Random(seed * 7919));
            let [mut single, mut merged] = [block(history), block(history)];
            let [mut depths, mut depths_merged] = [Depths::new(0.01), Depths::new(0.01)];
            let mut loads = vec![0; single.ray_tiles()];
            batches.iter().for_each(|(items, _)| single.add_loads(items, &mut loads));
            assert_eq!(single.sweep_bound_mm().to_bits(), 0.0_f64.to_bits(), "nothing was cut");
            let owners = single.share_rows(&loads, shares);
            let mut parts: Vec<TriDexel> = (0..shares).map(|k| single.share(&owners, k)).collect();
            let held: f64 = parts.iter().map(TriDexel::volume).sum();
            assert!((held - single.volume()).abs() < 1e-9 * held, "every tile has one owner");
            for (k, (items, measures)) in batches.iter().enumerate() {
                let reports = single.sweep_measured(items, measures, &mut depths);
                let replies: Vec<Vec<u8>> = parts
                    .iter_mut()
                    .map(|part| {
                        let mut log = ShareLog::default();
                        part.sweep_share(items, measures, &mut log);
                        log.into_bytes()
                    })
                    .collect();
                let again = if k % 3 == 2 {
                    // A merged stock is cut on like any other, and the shares go on with it.
                    merged.sweep_measured(items, measures, &mut depths_merged)
                } else {
                    let mut replays: Vec<ShareReplay<'_>> = replies.iter().map(|b| ShareReplay::new(b)).collect();
                    let again =
                        merged.apply_shares(items, measures, &mut depths_merged, &mut replays).expect("the same items");
                    assert!(replays.iter().all(ShareReplay::is_done));
                    again
                };
                assert_eq!(again, reports, "seed {seed}, batch {k}");
                assert_eq!(format!("{depths_merged:?}"), format!("{depths:?}"));
                assert!(whole(&merged) == whole(&single), "seed {seed}, batch {k}");
                if k % 2 == 1 {
                    assert_eq!(merged.take_changed_tiles(), single.take_changed_tiles());
                }
            }
            assert!(single.volume() < 0.7 * single.initial_volume() && depths.taken() > 5);
        }
    }

    #[test]
    fn loads_are_shared_evenly_and_every_tile_has_one_owner() {
        let mut random = Random(5);
        let loads: Vec<u64> = (0..900).map(|_| random.next(0.0, 50.0) as u64).collect();
        let owners = shares_of(&loads, 7);
        let sum = |k: u16| loads.iter().zip(&owners).filter(|(_, o)| **o == k).map(|(l, _)| l).sum::<u64>();
        let [least, most] = [(0..7).map(sum).min(), (0..7).map(sum).max()].map(Option::unwrap_or_default);
        // The last one given is among the lightest.
        assert!(most - least <= 50, "{least} {most}");
        // Equal ones go round.
        let idle = shares_of(&[1; 70], 7);
        assert!((0..7).all(|k| idle.iter().filter(|o| **o == k).count() == 10));
        assert_eq!(shares_of(&[3, 4], 0), [0, 0]);
    }

    #[test]
    fn spoiled_bytes_are_refused_or_another_stock_and_never_a_panic() {
        let cutters = cutters();
        let mut random = Random(99);
        let (items, measures) = batches(&cutters, &mut random).swap_remove(3);
        let mut part = block(true);
        let mut log = ShareLog::default();
        part.sweep_share(&items, &measures, &mut log);
        let good = log.into_bytes();
        let mut refused = 0;
        for k in 0..400 {
            let mut bad = good.clone();
            if k % 4 == 0 {
                bad.truncate(random.next(0.0, good.len() as f64) as usize);
            } else {
                let at = random.next(0.0, if k % 4 == 1 { 2000.0 } else { good.len() as f64 }) as usize;
                bad[at.min(good.len() - 1)] = random.next(0.0, 256.0) as u8;
            }
            let (mut stock, mut depths) = (block(true), Depths::new(0.01));
            refused +=
                usize::from(stock.apply_shares(&items, &measures, &mut depths, &mut [ShareReplay::new(&bad)]).is_err());
        }
        assert!(refused > 150, "{refused}");
        let none = block(true).apply_shares(&items, &measures, &mut Depths::new(0.01), &mut []);
        assert!(none.is_err(), "no share at all");
    }
}
