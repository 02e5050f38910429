//! Batches of motions against the stock.

use proveout_geom::{Aabb, Point};
use proveout_tool::Profile;
use rayon::prelude::*;

use crate::{
    field::batch::{Batch, Split},
    field::depth::{Deepest, Depths, Measure, RayLap},
    field::dexel::TriDexel,
    field::engagement::{Contact, PassMotions},
    field::grid::{RayGrid, TILE},
    field::slices::SliceContact,
    field::tile_work::{Scratch, TileWork},
    field::watch::Watch,
    kernels::meridian::Meridian,
    sweep_item::SweepItem,
};

/// What one motion met in the stock as it stood at that moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepReport {
    /// Volume removed or overlapped, mm³: mean of the three ray sets.
    pub volume_mm3: f64,
    /// Longest connected overlap on any ray, mm; 0 when the body only touches.
    pub overlap_mm: f64,
    /// Deepest point of the body below the free surface of the material, mm, where it is measured: see
    /// [`Depths`].
    pub depth_mm: Option<f64>,
    /// Middle of the longest overlap; among equals the first in the order of the rays.
    pub first_point: Option<Point>,
    /// Box round all overlaps, empty when there is none: range of engagement.
    pub region: Option<Aabb>,
    /// Rays with overlap, all three sets.
    pub rays: u64,
    /// Where the body was engaged, for removing items when [`TriDexel::watch_engagement`] asks for it.
    pub contact: Option<Contact>,
}

/// Entries of tiles and items that one pass may hold: bounds the memory of a batch to some 100 MB.
const ENTRIES: usize = 8 << 20;
/// Items of one pass.
const ITEMS: usize = 16384;
/// Entries of items whose depth is measured in one go: each may leave an interval of 48 bytes on each ray of
/// its tile.
const MEASURED_ENTRIES: usize = 1 << 13;

impl TriDexel {
    /// Carries out the items in their order and reports on each.
    ///
    /// The result does not depend on the number of threads, nor on how a program is cut into batches: a tile
    /// sees its items in the given order, and sums run over the tiles in a fixed order. An item with a number
    /// that is not finite meets nothing.
    pub fn sweep(&mut self, items: &[SweepItem<'_>]) -> Vec<SweepReport> {
        self.sweep_measured(items, &[], &mut Depths::default())
    }

    /// The same, and measures how deep those items were in the material that `measures` says, item by item
    /// (none: of no item).
    pub fn sweep_measured(
        &mut self,
        items: &[SweepItem<'_>],
        measures: &[Measure],
        depths: &mut Depths,
    ) -> Vec<SweepReport> {
        let mut reports = vec![SweepReport::default(); items.len()];
        let (index, bodies) = bodies_of(items);
        for chunk in chunks(items, measures) {
            let mut batch = self.batch(chunk.items, chunk.measures, &index[chunk.range.clone()], &bodies);
            let body_of = &index[chunk.range.clone()];
            batch.moves = PassMotions::watched(self.watch_engagement, self.slice_plan, chunk.items, body_of);
            let reports = &mut reports[chunk.range.clone()];
            let (mut first, mut deepest) = (0, Deepest::default());
            while first < batch.ready.len() {
                let (bins, next) = self.bin(&batch, first);
                let mut works = self.works(&batch, bins);
                let laps = works.iter_mut().flat_map(|work| std::mem::take(&mut work.laps)).collect();
                self.put_back_tiles(works, reports);
                self.measure(&chunk, laps, reports, (depths, &mut deepest));
                first = next;
            }
        }
        reports
    }

    /// The items made ready, and the bound of their sweeps taken note of.
    pub(crate) fn batch<'b>(
        &mut self,
        items: &[SweepItem<'_>],
        measures: &[Measure],
        index: &[usize],
        bodies: &'b [Meridian],
    ) -> Batch<'b> {
        let bounds = &self.grid.bounds;
        let split: Vec<Split> = items
            .par_iter()
            .zip(index)
            .with_min_len(64)
            .map(|(item, &body)| Split::of(item, &bodies[body], bounds))
            .collect();
        for s in &split {
            self.sweep_bound = self.sweep_bound.max(s.bound);
        }
        let mut batch = Batch::new(items, index, &split, bodies, &self.grid.bounds);
        for (ready, measure) in batch.ready.iter_mut().zip(measures) {
            ready.measured = *measure != Measure::No;
        }
        batch
    }

    /// How deep the measured items of a pass were; `laps` are in the order of the tiles.
    pub(crate) fn measure(
        &self,
        chunk: &ItemChunk<'_, '_>,
        mut laps: Vec<RayLap>,
        reports: &mut [SweepReport],
        (depths, deepest): (&mut Depths, &mut Deepest),
    ) {
        // In the order of the items; among those of one item, that of the tiles stays.
        laps.sort_by_key(|lap| lap.item);
        for of_item in laps.chunk_by(|x, y| x.item == y.item) {
            let item = of_item[0].item as usize;
            let longest = reports[item].overlap_mm;
            let (body, begin) = (chunk.items[item].body, &chunk.items[item].motion.from);
            let held = |x: &Point| {
                let way = x - begin.tip;
                let z = way.dot(&begin.axis);
                body.signed_distance([(way - begin.axis * z).norm(), z])
            };
            let measure = chunk.measures[item];
            let key_of = |item: usize| match chunk.measures[item] {
                Measure::Deepest(run) => Some((run, std::ptr::from_ref(chunk.items[item].body).addr())),
                _ => None,
            };
            let key = key_of(item);
            let known = key.and_then(|key| deepest.of(key, item, |k| key_of(k) == Some(key)));
            let depth = depths.of_item(&self.grid, (measure, known), of_item, longest, (held, self.sweep_bound));
            if let Some(key) = key {
                deepest.take(key, item, known, [depth, depths.least()]);
            }
            reports[item].depth_mm = Some(depth);
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
    pub(crate) fn bin(&self, batch: &Batch<'_>, first: usize) -> (Bins, usize) {
        let (mut count, mut measured) = (0, 0);
        let mut next = first;
        while next < batch.ready.len() && (next == first || count < ENTRIES && measured < MEASURED_ENTRIES) {
            for a in 0..3 {
                if let Some([u, v]) = self.tile_range(&batch.ready[next].region, a) {
                    let entries = (u[1] - u[0]) * (v[1] - v[0]);
                    count += entries;
                    measured += if batch.ready[next].measured { entries } else { 0 };
                }
            }
            next += 1;
        }
        let sets: Vec<(Vec<u32>, Vec<u32>)> = (0..3_usize)
            .into_par_iter()
            .map(|a| {
                let base = self.grid.first_tile[a];
                let first_row: usize = self.grid.tiles[..a].iter().map(|tiles| tiles[1]).sum();
                let tiles = &self.tiles[base..self.grid.first_tile[a + 1]];
                // Twice over the same tiles: first to count, then to write.
                let each = |f: &mut dyn FnMut(usize, u32)| {
                    for (k, item) in batch.ready[first..next].iter().enumerate() {
                        let Some([u, v]) = self.tile_range(&item.region, a) else { continue };
                        let (low, high) = (item.region.min[a], item.region.max[a]);
                        for j in v[0]..v[1] {
                            if self.empty_rows.get(first_row + j).is_some_and(|empty| *empty) {
                                continue;
                            }
                            let row = j * self.grid.tiles[a][0];
                            for (i, tile) in tiles[row + u[0]..row + u[1]].iter().enumerate() {
                                // Material only shrinks: what the item misses now it will miss later.
                                if tile.lo < high && tile.hi > low {
                                    f(row + u[0] + i, (first + k) as u32);
                                }
                            }
                        }
                    }
                };
                let mut start = vec![0_u32; tiles.len() + 1];
                each(&mut |t, _| start[t + 1] += 1);
                for t in 0..tiles.len() {
                    start[t + 1] += start[t];
                }
                let mut entries = vec![0; start[tiles.len()] as usize];
                let mut cursor = start.clone();
                each(&mut |t, item| {
                    entries[cursor[t] as usize] = item;
                    cursor[t] += 1;
                });
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

    /// Carries out what the bins hold, on tiles that are taken out of the stock.
    pub(crate) fn works(&mut self, batch: &Batch<'_>, bins: Bins) -> Vec<TileWork> {
        let mut undo = self.history.as_mut();
        let mut works: Vec<TileWork> = bins
            .tiles
            .into_iter()
            .map(|(index, entries)| TileWork {
                index,
                tile: std::mem::take(&mut self.tiles[index]),
                lost: std::mem::take(&mut self.lost[index]),
                watch: Watch::new(undo.as_mut().map(|h| std::mem::take(&mut h.tiles[index]))),
                entries,
                found: Vec::new(),
                laps: Vec::new(),
                changed: [f64::INFINITY, f64::NEG_INFINITY],
            })
            .collect();
        let grid = &self.grid;
        works.par_iter_mut().with_max_len(16).for_each_init(Scratch::default, |scratch, work| {
            let entries = work.entries.clone();
            batch.on_tile(grid, work, &bins.entries[entries], scratch);
        });
        works
    }

    /// Puts tiles back, in rising order, and adds up what was met in them.
    pub(crate) fn put_back_tiles(&mut self, works: Vec<TileWork>, reports: &mut [SweepReport]) {
        let cut = works.iter().any(TileWork::is_cut);
        let pass = self.passes + u32::from(cut);
        self.passes = pass;
        for work in works {
            let (a, [i0, j0]) = self.grid.tile_place(work.index);
            let u = |column: usize| self.grid.center((a + 1) % 3, i0 + column);
            let v = |row: usize| self.grid.center((a + 2) % 3, j0 + row);
            let area = self.grid.ray_area(a) / 3.0;
            for p in &work.found {
                let report = &mut reports[p.item as usize];
                report.volume_mm3 += p.length * area;
                report.rays += u64::from(p.rays);
                if p.longest > report.overlap_mm {
                    let ray = usize::from(p.ray);
                    report.overlap_mm = p.longest;
                    report.first_point = Some(RayGrid::point(a, p.middle, u(ray % TILE), v(ray / TILE)));
                }
                let ends =
                    |bits: u8| [bits.trailing_zeros() as usize, 7_u32.saturating_sub(bits.leading_zeros()) as usize];
                let (columns, rows) = (ends(p.columns), ends(p.rows));
                let low = RayGrid::point(a, p.range[0], u(columns[0]), v(rows[0]));
                let high = RayGrid::point(a, p.range[1], u(columns[1]), v(rows[1]));
                let region = Aabb { min: low, max: high };
                report.region = Some(report.region.map_or(region, |r| r.union(&region)));
            }
            self.slices
                .extend(work.watch.slices.iter().map(|s| SliceContact { volume_mm3: s.volume_mm3 * area, ..*s }));
            for (item, contact) in &work.watch.contacts {
                let report = &mut reports[*item as usize];
                report.contact = Some(report.contact.map_or(*contact, |c| c.union(contact)));
            }
            if work.is_cut() {
                self.cut_in[work.index] = pass;
                self.mark_changed(work.index, work.changed);
            }
            if let (Some(history), Some(undo)) = (&mut self.history, work.watch.undo) {
                history.tiles[work.index] = undo;
            }
            self.lost[work.index] = work.lost;
            self.tiles[work.index] = work.tile;
        }
    }
}

/// Items sorted by tile.
pub(crate) struct Bins {
    pub(crate) entries: Vec<u32>,
    pub(crate) tiles: Vec<(usize, std::ops::Range<usize>)>,
}

/// Items that are made ready in one go.
pub(crate) struct ItemChunk<'c, 'a> {
    pub(crate) range: std::ops::Range<usize>,
    pub(crate) items: &'c [SweepItem<'a>],
    pub(crate) measures: &'c [Measure],
}

/// The items in goes; the same for everyone who is given the same items.
pub(crate) fn chunks<'c, 'a>(
    items: &'c [SweepItem<'a>],
    measures: &'c [Measure],
) -> impl Iterator<Item = ItemChunk<'c, 'a>> {
    (0..items.len()).step_by(ITEMS).map(move |first| {
        let range = first..(first + ITEMS).min(items.len());
        ItemChunk { items: &items[range.clone()], measures: measures.get(range.clone()).unwrap_or(&[]), range }
    })
}

/// The bodies of items, each made ready once, and which one each item has.
pub(crate) fn bodies_of(items: &[SweepItem<'_>]) -> (Vec<usize>, Vec<Meridian>) {
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
    (index, bodies.into_iter().map(|b| b.1).collect())
}
