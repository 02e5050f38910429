//! The effect of sweeps on a stock, in bytes, so that a stopped run can resume without cutting
//! again.
//!
//! ```text
//!   recorded   stock before --sweep--> stock after, reports
//!   replayed   stock before --bytes--> stock after, reports        bit for bit, memory included
//! ```
//!
//! The bytes are the changes of the stock, and the reports.
//!
//! A tile that was cut is recorded with all of its intervals: motion that cuts a tile mostly
//! changes most of its rays. What a sweep leaves in a stock besides its intervals (the item that
//! emptied a ray, blocks whose surface has changed, passes, the history) is recorded as well, since
//! later steps use it. The stock must be that of the record: only the room of its tiles is checked.

use crate::{
    StockFileError,
    field::depth::Depths,
    field::dexel::TriDexel,
    field::engagement::Contact,
    field::grid::{RayGrid, TILE_RAYS},
    field::last_emptied::LastEmptied,
    field::span::{INITIAL, MaterialSpan},
    field::sweep::SweepReport,
    field::tile::Tile,
    field::undo::{RayChange, Undo},
    persist::codec::{ByteFault, Decoder, Encoder, below},
};

/// Kind of the ends of the history for the codec; the ends of a ray follow it.
const UNDO_KIND: usize = 0;
/// Bytes that an interval takes at least.
const LEAST_INTERVAL: u64 = 2;
/// Bits of the first byte of a report.
const MET: u64 = 1;
const DEPTH: u64 = 2;
const POINT: u64 = 4;
const REGION: u64 = 8;
const CONTACT: u64 = 16;

/// A moment of a stock: later cuts are recorded relative to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BeforeSweep(u32);

/// Writes what sweeps did.
#[derive(Default)]
pub struct SweepLog(Encoder);

/// Reads it, in the order in which it was written.
pub struct SweepReplay<'a>(Decoder<'a>);

impl TriDexel {
    /// The moment before the next sweep.
    pub fn before_sweep(&self) -> BeforeSweep {
        BeforeSweep(self.passes)
    }
}

impl SweepLog {
    /// Records the effect of the items since `moment` on a stock; `first` is the lowest of their
    /// ids.
    pub fn stock(&mut self, stock: &TriDexel, moment: BeforeSweep, first: u32) {
        let out = &mut self.0;
        out.number(u64::from(stock.passes - moment.0));
        out.real(stock.sweep_bound);
        let cut = || (0..stock.tiles.len()).filter(|&t| stock.cut_in[t] > moment.0);
        out.number(cut().count() as u64);
        let mut before = 0;
        for tile in cut() {
            out.number((tile - before) as u64);
            out.number(u64::from(stock.cut_in[tile] - moment.0));
            before = tile;
            write_tile(out, &stock.tiles[tile]);
            write_lost(out, &stock.lost[tile]);
            if let Some(history) = &stock.history {
                // Ids rise.
                let undo = &history.tiles[tile];
                write_undo(out, undo, undo.changes.partition_point(|c| c.id < first));
            }
        }
        let changed = || stock.changed.iter().enumerate().filter(|(_, c)| **c).map(|(k, _)| k);
        out.number(changed().count() as u64);
        let mut before = 0;
        for block in changed() {
            out.number((block - before) as u64);
            before = block;
        }
    }

    /// Records the reports of the items.
    pub fn reports(&mut self, reports: &[SweepReport]) {
        let out = &mut self.0;
        out.number(reports.len() as u64);
        for r in reports {
            let met = r.volume_mm3.to_bits() != 0 || r.overlap_mm.to_bits() != 0 || r.rays != 0;
            let bit = |set: bool, bit: u64| if set { bit } else { 0 };
            out.number(
                bit(met, MET)
                    | bit(r.depth_mm.is_some(), DEPTH)
                    | bit(r.first_point.is_some(), POINT)
                    | bit(r.region.is_some(), REGION)
                    | bit(r.contact.is_some(), CONTACT),
            );
            if met {
                out.real(r.volume_mm3);
                out.real(r.overlap_mm);
                out.number(r.rays);
            }
            let reals = r.depth_mm.into_iter();
            let reals = reals.chain(r.first_point.iter().flat_map(|p| [p.x, p.y, p.z]));
            let reals = reals.chain(r.region.iter().flat_map(|b| [b.min, b.max]).flat_map(|p| [p.x, p.y, p.z]));
            for x in reals {
                out.real(x);
            }
            if let Some(Contact { height, across, angle, advance }) = r.contact {
                [height, across, angle].iter().flatten().chain([&advance]).for_each(|x| out.real(*x));
            }
        }
    }

    /// Records the depths of the run under way.
    pub fn depths(&mut self, depths: &Depths) {
        depths.write(&mut self.0);
    }

    /// Bytes so far.
    #[allow(clippy::len_without_is_empty, reason = "not needed")]
    pub fn len(&self) -> u64 {
        self.0.bytes.len() as u64
    }

    /// The recorded bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0.bytes
    }
}

impl<'a> SweepReplay<'a> {
    /// Reads the bytes of a log.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(Decoder::new(bytes))
    }

    /// Does to a stock what the sweeps did.
    ///
    /// # Errors
    /// [`StockFileError::Content`] where the bytes are no record of this stock, which is then spoiled.
    pub fn stock(&mut self, stock: &mut TriDexel) -> Result<(), StockFileError> {
        let input = &mut self.0;
        let before = stock.passes;
        let passes = below(input, u64::from(u32::MAX - before) + 1, "too many passes")? as u32;
        stock.passes += passes;
        stock.sweep_bound = input.real()?;
        let mut tile = 0;
        for _ in 0..below(input, stock.tiles.len() as u64 + 1, "more tiles than the stock has")? {
            tile += below(input, (stock.tiles.len() - tile) as u64, "a tile that the stock does not have")? as usize;
            stock.cut_in[tile] = before + below(input, u64::from(passes) + 1, "a pass that was not made")? as u32;
            stock.tiles[tile] = read_tile(input, rays_end_in(&stock.grid, tile))?;
            stock.lost[tile] = read_lost(input)?;
            if let Some(history) = &mut stock.history {
                read_undo(input, &mut history.tiles[tile])?;
            }
        }
        let mut block = 0;
        for _ in 0..below(input, stock.changed.len() as u64 + 1, "more blocks than the stock has")? {
            block +=
                below(input, (stock.changed.len() - block) as u64, "a block that the stock does not have")? as usize;
            stock.changed[block] = true;
        }
        Ok(())
    }

    /// The reports of the items.
    ///
    /// # Errors
    /// As [`Self::stock`].
    pub fn reports(&mut self) -> Result<Vec<SweepReport>, StockFileError> {
        let input = &mut self.0;
        let count = below(input, input.left() as u64 + 1, "more reports than there are bytes")?;
        let mut reports = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let bits = below(input, 2 * CONTACT, "a report of no known kind")?;
            let mut report = SweepReport::default();
            if bits & MET != 0 {
                (report.volume_mm3, report.overlap_mm, report.rays) = (input.real()?, input.real()?, input.number()?);
            }
            if bits & DEPTH != 0 {
                report.depth_mm = Some(input.real()?);
            }
            let point = |input: &mut Decoder<'a>| -> Result<proveout_geom::Point, ByteFault> {
                Ok(proveout_geom::Point::new(input.real()?, input.real()?, input.real()?))
            };
            if bits & POINT != 0 {
                report.first_point = Some(point(input)?);
            }
            if bits & REGION != 0 {
                report.region = Some(proveout_geom::Aabb { min: point(input)?, max: point(input)? });
            }
            if bits & CONTACT != 0 {
                let mut pair = || -> Result<[f64; 2], ByteFault> { Ok([input.real()?, input.real()?]) };
                let [height, across, angle] = [pair()?, pair()?, pair()?];
                report.contact = Some(Contact { height, across, angle, advance: input.real()? });
            }
            reports.push(report);
        }
        Ok(reports)
    }

    /// The memory of the run under way, taken over.
    ///
    /// # Errors
    /// As [`Self::stock`].
    pub fn depths(&mut self, depths: &mut Depths) -> Result<(), StockFileError> {
        Ok(depths.read(&mut self.0)?)
    }

    /// True when all was read.
    pub fn is_done(&self) -> bool {
        self.0.is_done()
    }
}

/// Who emptied which rays.
pub(crate) fn write_lost(out: &mut Encoder, lost: &LastEmptied) {
    let emptied = (0..TILE_RAYS).filter_map(|r| Some((r, lost.of(r)?)));
    out.number(emptied.clone().count() as u64);
    for (ray, id) in emptied {
        out.number(ray as u64);
        out.number(u64::from(id));
    }
}

pub(crate) fn read_lost(input: &mut Decoder<'_>) -> Result<LastEmptied, ByteFault> {
    let mut lost = LastEmptied::default();
    for _ in 0..below(input, TILE_RAYS as u64 + 1, "more rays than a tile has")? {
        let ray = below(input, TILE_RAYS as u64, "a ray that the tile does not have")? as usize;
        lost.set(ray, below(input, u64::from(INITIAL), "an invalid id")? as u32);
    }
    Ok(lost)
}

pub(crate) fn write_tile(out: &mut Encoder, tile: &Tile) {
    out.number(tile.room() as u64);
    for ray in 0..TILE_RAYS {
        let spans = tile.ray(ray);
        out.number(spans.len() as u64);
        for (k, end) in spans.iter().flat_map(MaterialSpan::ends).enumerate() {
            out.end(UNDO_KIND + 1 + k, end);
        }
    }
}

/// Range in which the rays of a tile may end: a cell of play, since they may end by rounding outside of the
/// box.
pub(crate) fn rays_end_in(grid: &RayGrid, tile: usize) -> [f64; 2] {
    let (axis, _) = grid.tile_place(tile);
    let play = grid.cells[axis];
    [grid.bounds.min[axis] - play, grid.bounds.max[axis] + play]
}

pub(crate) fn read_tile(input: &mut Decoder<'_>, [low, high]: [f64; 2]) -> Result<Tile, ByteFault> {
    // Twice what is there at most is kept free, see `Tile::rewrite`.
    let room = below(input, u64::from(u32::MAX), "a tile without bounds")? as usize;
    let mut rays: Vec<Vec<MaterialSpan>> = Vec::with_capacity(TILE_RAYS);
    for _ in 0..TILE_RAYS {
        let count = input.number()?;
        if count.saturating_mul(LEAST_INTERVAL) > input.left() as u64 {
            return Err(input.fault("a ray has more intervals than there are bytes"));
        }
        let (mut last, mut spans) = (low, Vec::with_capacity(count as usize));
        for k in 0..count as usize {
            let (lo, hi) = (input.end(UNDO_KIND + 1 + 2 * k)?, input.end(UNDO_KIND + 2 + 2 * k)?);
            if !(last <= lo.s && lo.s < hi.s && hi.s <= high) {
                return Err(input.fault("the ends on a ray do not rise, or leave the box"));
            }
            last = hi.s;
            spans.push(MaterialSpan::from_ends(lo, hi));
        }
        rays.push(spans);
    }
    let held: usize = rays.iter().map(Vec::len).sum();
    if room < held || room > 2 * held + TILE_RAYS * 64 {
        return Err(input.fault("a tile with room for other than it holds"));
    }
    Ok(Tile::with_room(room, rays))
}

/// Writes the changes after the first `known`.
pub(crate) fn write_undo(out: &mut Encoder, undo: &Undo, known: usize) {
    let ends: usize = undo.changes[known..].iter().map(|c| usize::from(c.put)).sum();
    out.number(undo.changes.capacity() as u64);
    out.number(undo.ends.capacity() as u64);
    out.number(u64::from(undo.broken));
    out.number((undo.changes.len() - known) as u64);
    for c in &undo.changes[known..] {
        for n in [u64::from(c.ray), u64::from(c.id), u64::from(c.at), u64::from(c.take), u64::from(c.put)] {
            out.number(n);
        }
    }
    for end in &undo.ends[undo.ends.len() - ends..] {
        out.end(UNDO_KIND, *end);
    }
}

pub(crate) fn read_undo(input: &mut Decoder<'_>, undo: &mut Undo) -> Result<(), ByteFault> {
    let [changes_room, ends_room] = [input.number()?, input.number()?];
    undo.broken |= below(input, 2, "an invalid flag")? == 1;
    let count = below(input, input.left() as u64 + 1, "more changes than there are bytes")?;
    let mut ends = 0;
    for _ in 0..count {
        let ray = below(input, TILE_RAYS as u64, "a ray that the tile does not have")? as u8;
        let id = below(input, u64::from(INITIAL), "an invalid id")? as u32;
        let mut small = || Ok::<u16, ByteFault>(below(input, u64::from(u16::MAX) + 1, "a count out of range")? as u16);
        let [at, take, put] = [small()?, small()?, small()?];
        ends += usize::from(put);
        undo.changes.push(RayChange { id, at, take, put, ray });
    }
    for _ in 0..ends {
        undo.ends.push(input.end(UNDO_KIND)?);
    }
    // The memory that the history takes decides whether it is given up: it takes the same.
    let far = |room: u64, held: usize| room < held as u64 || room > 4 * held as u64 + 64;
    if far(changes_room, undo.changes.len()) || far(ends_room, undo.ends.len()) {
        return Err(input.fault("a history with room for other than it holds"));
    }
    undo.changes = with_room(changes_room as usize, &undo.changes);
    undo.ends = with_room(ends_room as usize, &undo.ends);
    Ok(())
}

fn with_room<T: Copy>(room: usize, held: &[T]) -> Vec<T> {
    let mut out = Vec::with_capacity(room);
    out.extend_from_slice(held);
    out
}

#[cfg(test)]
pub(crate) mod tests {
    use proveout_geom::{Aabb, Point, ToolPose, Vector};
    use proveout_tool::{Profile, Segment};

    use super::*;
    use crate::{Action, Measure, SweepItem, SweepMotion};

    pub(crate) struct Random(pub(crate) u64);

    impl Random {
        pub(crate) fn next(&mut self, low: f64, high: f64) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    pub(crate) fn cutters() -> [Profile; 2] {
        let line = |from, to| Segment::Line { from, to };
        let flat = vec![line([0.0, 0.0], [2.0, 0.0]), line([2.0, 0.0], [2.0, 20.0]), line([2.0, 20.0], [0.0, 20.0])];
        let ball = vec![
            Segment::Arc { center: [0.0, 3.0], radius: 3.0, from: [0.0, 0.0], to: [3.0, 3.0] },
            line([3.0, 3.0], [3.0, 20.0]),
            line([3.0, 20.0], [0.0, 20.0]),
        ];
        [flat, ball].map(|segments| Profile::new(segments).expect("a body"))
    }

    /// Batches of motions, some of them probed, some measured alone and some in runs; from air to far below
    /// the block.
    pub(crate) fn batches<'a>(
        cutters: &'a [Profile; 2],
        random: &mut Random,
    ) -> Vec<(Vec<SweepItem<'a>>, Vec<Measure>)> {
        let mut at = ToolPose { tip: Point::new(1.0, 1.0, 9.0), axis: Vector::z() };
        let (mut id, mut since) = (0, 0);
        let mut batch = |count: usize| {
            let mut out = (Vec::new(), Vec::new());
            for _ in 0..count {
                let tip = Point::new(random.next(-4.0, 24.0), random.next(-4.0, 20.0), random.next(-3.0, 9.0));
                let tilt = Vector::new(random.next(-0.2, 0.2), random.next(-0.2, 0.2), 1.0);
                let next = ToolPose { tip: at.tip + (tip - at.tip) * 0.4, axis: tilt.normalize() };
                let motion = SweepMotion { from: std::mem::replace(&mut at, next), to: next };
                id += 1;
                let kind = random.next(0.0, 8.0) as u32;
                let measure = match kind {
                    0 => Measure::Alone,
                    1..=3 => Measure::Since(since),
                    _ => {
                        since = id + 1;
                        Measure::No
                    }
                };
                let action = if kind == 0 || kind == 7 { Action::Probe } else { Action::Remove };
                out.0.push(SweepItem { id, body: &cutters[usize::from(kind.is_multiple_of(2))], action, motion });
                out.1.push(measure);
            }
            out
        };
        [1, 9, 0, 30, 2, 60, 17, 1].map(&mut batch).into()
    }

    /// All that a stock holds, its memory included.
    pub(crate) fn whole(stock: &TriDexel) -> String {
        let mut saved = Vec::new();
        stock.save(&mut saved).expect("written");
        let undo = stock.history.iter().flat_map(|h| &h.tiles);
        let rooms: Vec<[usize; 2]> = undo.map(|u| [u.changes.capacity(), u.ends.capacity()]).collect();
        format!(
            "{:?} {:?} {:?} {:?} {} {:?} {} {:x?}",
            stock.passes,
            stock.cut_in,
            stock.changed,
            stock.lost,
            stock.memory_bytes(),
            rooms,
            stock.history_bytes(),
            saved
        )
    }

    pub(crate) fn block(history: bool) -> TriDexel {
        let bounds = Aabb { min: Point::origin(), max: Point::new(20.0, 16.0, 8.0) };
        let mut stock = TriDexel::from_box(&bounds, [0.5, 0.4, 0.3], 1 << 30).expect("a stock");
        stock.watch_engagement(true);
        if history {
            stock.keep_history();
        }
        stock
    }

    #[test]
    fn a_replayed_stock_is_the_one_that_was_cut_whatever_follows() {
        let cutters = cutters();
        for (seed, history) in [(1, false), (2, true), (3, true), (4, false), (5, true)] {
            let batches = batches(&cutters, &mut Random(seed * 7919));
            let [mut cut, mut replayed] = [block(history), block(history)];
            let [mut depths, mut depths_again] = [Depths::new(0.01), Depths::new(0.01)];
            for (k, (items, measures)) in batches.iter().enumerate() {
                let first = items.first().map_or(0, |i| i.id);
                let before = cut.before_sweep();
                let reports = cut.sweep_measured(items, measures, &mut depths);
                let mut log = SweepLog::default();
                log.stock(&cut, before, first);
                log.reports(&reports);
                log.depths(&depths);
                let again = if k % 3 == 2 {
                    // What was replayed is cut on like the stock itself.
                    replayed.sweep_measured(items, measures, &mut depths_again)
                } else {
                    let bytes = log.into_bytes();
                    let mut replay = SweepReplay::new(&bytes);
                    replay.stock(&mut replayed).expect("a record");
                    let again = replay.reports().expect("a record");
                    replay.depths(&mut depths_again).expect("a record");
                    assert!(replay.is_done());
                    again
                };
                assert_eq!(again, reports);
                assert_eq!(format!("{depths_again:?}"), format!("{depths:?}"));
                assert!(whole(&replayed) == whole(&cut), "seed {seed}, batch {k}");
                if k % 2 == 1 {
                    assert_eq!(replayed.take_changed_tiles(), cut.take_changed_tiles());
                }
            }
            assert!(cut.volume() < 0.7 * cut.initial_volume() && depths.taken() > 5);
        }
    }

    #[test]
    fn spoiled_records_are_refused_or_another_stock_and_never_a_panic() {
        let cutters = cutters();
        let mut random = Random(99);
        let (items, measures) = batches(&cutters, &mut random).swap_remove(3);
        let (mut cut, mut depths) = (block(true), Depths::new(0.01));
        let before = cut.before_sweep();
        let reports = cut.sweep_measured(&items, &measures, &mut depths);
        let mut log = SweepLog::default();
        log.stock(&cut, before, items[0].id);
        log.reports(&reports);
        log.depths(&depths);
        let good = log.into_bytes();
        let mut refused = 0;
        for k in 0..400 {
            let mut bad = good.clone();
            if k % 4 == 0 {
                bad.truncate(random.next(0.0, good.len() as f64) as usize);
            } else {
                // Most faults in the first kilobytes, which hold the counts.
                let at = random.next(0.0, if k % 4 == 1 { 2000.0 } else { good.len() as f64 }) as usize;
                bad[at.min(good.len() - 1)] = random.next(0.0, 256.0) as u8;
            }
            let (mut stock, mut depths) = (block(true), Depths::new(0.01));
            let mut replay = SweepReplay::new(&bad);
            let read =
                replay.stock(&mut stock).and_then(|()| replay.reports()).and_then(|_| replay.depths(&mut depths));
            refused += usize::from(read.is_err());
        }
        assert!(refused > 150, "{refused}");
    }
}
