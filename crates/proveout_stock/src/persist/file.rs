//! The stock in a file, bit for bit: heights, what made them, normals, and the history where it was kept. The
//! layout is described in `docs/stock-file.md`.

use std::io::{Read, Write};

use proveout_geom::{Aabb, Point};
use rayon::prelude::*;
use thiserror::Error;

use crate::{
    StockError,
    field::dexel::TriDexel,
    field::grid::{Cells, RayGrid},
    field::regrid_bound::Regrid,
    field::span::MaterialSpan,
    field::undo::{History, RayChange, Undo},
    persist::codec::{ByteFault, Decoder, Encoder, digest, digest_of},
};

/// First bytes of a stock file. The bytes that are no text show a transfer that changed line ends.
const MAGIC: [u8; 8] = *b"DEXEL\r\n\x1a";
/// Version of the layout that is written and read.
const VERSION: u32 = 1;
/// Bytes before the payload.
const HEADER: usize = 176;
/// Bytes that every interval takes at least: a control byte for each end.
const LEAST_INTERVAL: u64 = 2;
/// Kind of the ends of the history for the codec; ends of the stock have their place on the ray.
const UNDO_KIND: usize = 0;

/// Why a stock file cannot be read or written.
#[derive(Debug, Error)]
pub enum StockFileError {
    /// The system refuses.
    #[error("cannot be {what}: {source}")]
    Io {
        /// `read` or `written`.
        what: &'static str,
        /// Why.
        source: std::io::Error,
    },
    /// It does not begin as stock files do.
    #[error("is not a stock file: its first bytes are not those of one")]
    NotStock,
    /// Written by a program with another layout.
    #[error(
        "is a stock file of version {found}, but only version {known} can be read: run the program that wrote it again"
    )]
    Version {
        /// Version of the file.
        found: u32,
        /// Version that is known.
        known: u32,
    },
    /// It ends too early, or goes on after its end.
    #[error("has {found} bytes of content where its header announces {announced}: it was cut off or written over")]
    Length {
        /// Bytes of payload that are there, counted up to one more than announced.
        found: u64,
        /// Bytes that the header announces.
        announced: u64,
    },
    /// Header or payload do not have their digest.
    #[error("is damaged: the digest of its {part} is {found:016x} instead of {announced:016x}")]
    Digest {
        /// `header` or `content`.
        part: &'static str,
        /// Digest of the bytes.
        found: u64,
        /// Digest in the file.
        announced: u64,
    },
    /// The digest is right, but the content is not a stock.
    #[error("is not a stock: {what} (byte {at} of the content)")]
    Content {
        /// What is wrong.
        what: &'static str,
        /// Where, bytes from the begin of the payload.
        at: u64,
    },
    /// Numbers in the header that cannot be.
    #[error("is not a stock: its header announces {what}")]
    Header {
        /// Which, with their values.
        what: String,
    },
    /// Grid that cannot be made, or needs more memory than allowed.
    #[error(transparent)]
    Stock(#[from] StockError),
}

impl From<ByteFault> for StockFileError {
    fn from(f: ByteFault) -> Self {
        Self::Content { what: f.what, at: f.at as u64 }
    }
}

/// The numbers before the payload.
struct Header {
    cells: [f64; 3],
    bounds: Aabb,
    counts: [u32; 3],
    initial_volume: f64,
    sweep_bound: f64,
    /// Bounds of re-gridding, mm; NaN where the stock was not re-gridded.
    regrid: [f64; 2],
    intervals: u64,
    /// Bytes of the intervals and of the history.
    lengths: [u64; 2],
    digest: u64,
}

impl Header {
    fn bytes(&self) -> [u8; HEADER] {
        let mut out = Vec::with_capacity(HEADER);
        out.extend(MAGIC);
        out.extend(VERSION.to_le_bytes());
        out.extend(u32::from(self.lengths[1] > 0).to_le_bytes());
        let reals = self.cells.iter().chain(self.bounds.min.iter()).chain(self.bounds.max.iter());
        let more = [self.initial_volume, self.sweep_bound, self.regrid[0], self.regrid[1]];
        for x in reals.chain(&more) {
            out.extend(x.to_bits().to_le_bytes());
        }
        for n in self.counts {
            out.extend(n.to_le_bytes());
        }
        out.extend([0; 4]);
        for n in [self.intervals, self.lengths[0], self.lengths[1], self.digest] {
            out.extend(n.to_le_bytes());
        }
        out.extend(digest(&out).to_le_bytes());
        let mut bytes = [0; HEADER];
        for (to, from) in bytes.iter_mut().zip(&out) {
            *to = *from;
        }
        bytes
    }

    fn read(bytes: &[u8; HEADER]) -> Result<Self, StockFileError> {
        let word = |at: usize| {
            let mut w = [0; 8];
            w.copy_from_slice(&bytes[at..at + 8]);
            u64::from_le_bytes(w)
        };
        let (found, announced) = (digest(&bytes[..HEADER - 8]), word(HEADER - 8));
        if found != announced {
            return Err(StockFileError::Digest { part: "header", found, announced });
        }
        let real = |k: usize| f64::from_bits(word(16 + 8 * k));
        let point = |k: usize| Point::new(real(k), real(k + 1), real(k + 2));
        let half = |at: usize| (word(at) & u64::from(u32::MAX)) as u32;
        Ok(Self {
            cells: [0, 1, 2].map(real),
            bounds: Aabb { min: point(3), max: point(6) },
            initial_volume: real(9),
            sweep_bound: real(10),
            regrid: [real(11), real(12)],
            counts: [half(120), half(124), half(128)],
            intervals: word(136),
            lengths: [word(144), word(152)],
            digest: word(160),
        })
    }
}

impl TriDexel {
    /// Writes the stock. Same stock, same bytes.
    ///
    /// # Errors
    /// [`StockFileError::Io`].
    pub fn save(&self, out: &mut impl Write) -> Result<(), StockFileError> {
        let sets: Vec<(Vec<u8>, u64)> = (0..3).into_par_iter().map(|a| self.encode_set(a)).collect();
        let history = self.history.as_ref().map(|h| self.encode_history(h)).unwrap_or_default();
        // What is written, part by part: a copy in one piece would take as much memory again.
        let lengths: Vec<[u8; 8]> = sets.iter().map(|s| (s.0.len() as u64).to_le_bytes()).collect();
        let mut payload: Vec<&[u8]> = Vec::with_capacity(2 * sets.len() + 1);
        for ((bytes, _), length) in sets.iter().zip(&lengths) {
            payload.push(length.as_slice());
            payload.push(bytes.as_slice());
        }
        let length: u64 = payload.iter().map(|part| part.len() as u64).sum();
        payload.push(history.as_slice());
        let regrid = self.regrid.map_or([f64::NAN; 2], |r| [r.surface_mm, r.edge_mm]);
        let header = Header {
            cells: self.grid.cells,
            bounds: self.grid.bounds,
            counts: self.grid.n.map(|n| n as u32),
            initial_volume: self.initial_volume,
            sweep_bound: self.sweep_bound,
            regrid,
            intervals: sets.iter().map(|s| s.1).sum(),
            lengths: [length, history.len() as u64],
            digest: digest_of(&payload),
        };
        let failed = |source| StockFileError::Io { what: "written", source };
        out.write_all(&header.bytes()).map_err(failed)?;
        for part in payload {
            out.write_all(part).map_err(failed)?;
        }
        out.flush().map_err(failed)
    }

    /// Reads a stock; `limit_bytes` bounds the memory that it may take.
    ///
    /// # Errors
    /// [`StockFileError`] for the first fault. Nothing is allocated beyond what the file has and the limit
    /// allows.
    pub fn load(input: &mut impl Read, limit_bytes: u64) -> Result<Self, StockFileError> {
        let failed = |source| StockFileError::Io { what: "read", source };
        let mut first = Vec::with_capacity(HEADER);
        input.by_ref().take(HEADER as u64).read_to_end(&mut first).map_err(failed)?;
        if first.len() < MAGIC.len() || first[..MAGIC.len()] != MAGIC {
            return Err(StockFileError::NotStock);
        }
        if let Some(v) = first.get(8..12) {
            let found = u32::from_le_bytes([v[0], v[1], v[2], v[3]]);
            if found != VERSION {
                return Err(StockFileError::Version { found, known: VERSION });
            }
        }
        let Ok(bytes) = <[u8; HEADER]>::try_from(first.as_slice()) else {
            return Err(StockFileError::Length { found: 0, announced: HEADER as u64 - first.len() as u64 });
        };
        let header = Header::read(&bytes)?;
        let grid = header.checked_grid(limit_bytes)?;
        let announced = header.lengths[0].saturating_add(header.lengths[1]);
        let mut payload = Vec::new();
        input.take(announced.saturating_add(1)).read_to_end(&mut payload).map_err(failed)?;
        if payload.len() as u64 != announced {
            return Err(StockFileError::Length { found: payload.len() as u64, announced });
        }
        let found = digest(&payload);
        if found != header.digest {
            return Err(StockFileError::Digest { part: "content", found, announced: header.digest });
        }
        let split = header.lengths[0] as usize;
        let sets = decode_sets(&payload[..split], &grid, header.intervals)?;
        let columns = grid.n;
        let mut stock = Self::filled(grid, |a, i, j| sets[a].ray(j * columns[(a + 1) % 3] + i).to_vec());
        stock.initial_volume = header.initial_volume;
        stock.sweep_bound = header.sweep_bound;
        let [surface_mm, edge_mm] = header.regrid;
        stock.regrid = (!surface_mm.is_nan()).then_some(Regrid { surface_mm, edge_mm });
        if header.lengths[1] > 0 {
            stock.history = Some(stock.decode_history(&payload[split..])?);
        }
        Ok(stock)
    }

    /// The rays of a set, the place along u fastest: number of intervals, then their ends.
    fn encode_set(&self, a: usize) -> (Vec<u8>, u64) {
        let mut out = Encoder::default();
        let mut intervals = 0;
        for j in 0..self.grid.n[(a + 2) % 3] {
            for i in 0..self.grid.n[(a + 1) % 3] {
                let spans = self.spans(a, i, j);
                intervals += spans.len() as u64;
                out.number(spans.len() as u64);
                for (k, end) in spans.iter().flat_map(MaterialSpan::ends).enumerate() {
                    out.end(k, end);
                }
            }
        }
        (out.bytes, intervals)
    }

    fn encode_history(&self, history: &History) -> Vec<u8> {
        let mut out = Encoder::default();
        out.number(history.ended.len() as u64);
        for &(id, time) in &history.ended {
            out.number(u64::from(id));
            out.real(time);
        }
        for tile in &history.tiles {
            out.number(tile.changes.len() as u64);
            let (mut id, mut end) = (0, 0);
            for c in &tile.changes {
                out.number(u64::from(c.ray));
                out.number(u64::from(c.id.wrapping_sub(id)));
                out.number(u64::from(c.at));
                out.number(u64::from(c.take));
                out.number(u64::from(c.put));
                for e in &tile.ends[end..end + usize::from(c.put)] {
                    out.end(UNDO_KIND, *e);
                }
                id = c.id;
                end += usize::from(c.put);
            }
        }
        out.bytes
    }

    fn decode_history(&self, bytes: &[u8]) -> Result<History, StockFileError> {
        let mut input = Decoder::new(bytes);
        let mut history = History::default();
        for _ in 0..input.number()? {
            let id = small(&mut input, u32::MAX)?;
            let time = input.real()?;
            if history.ended.last().is_some_and(|&(i, t)| id <= i || time < t) || !time.is_finite() {
                return Err(input.fault("the ends of the moves do not rise").into());
            }
            history.ended.push((id, time));
        }
        for _ in 0..self.tiles.len() {
            let mut undo = Undo::default();
            let mut id = 0_u32;
            for _ in 0..input.number()? {
                let ray = small(&mut input, crate::field::grid::TILE_RAYS as u32 - 1)? as u8;
                id = id.wrapping_add(small(&mut input, u32::MAX)?);
                let [at, take, put] = [
                    small(&mut input, u32::from(u16::MAX))? as u16,
                    small(&mut input, u32::from(u16::MAX))? as u16,
                    small(&mut input, u32::from(u16::MAX))? as u16,
                ];
                for _ in 0..put {
                    undo.ends.push(input.end(UNDO_KIND)?);
                }
                undo.changes.push(RayChange { id, at, take, put, ray });
            }
            history.tiles.push(undo);
        }
        if !input.is_done() {
            return Err(input.fault("bytes are left after the history").into());
        }
        Ok(history)
    }
}

/// A number up to `most`.
fn small(input: &mut Decoder<'_>, most: u32) -> Result<u32, ByteFault> {
    let x = input.number()?;
    u32::try_from(x).ok().filter(|x| *x <= most).ok_or_else(|| input.fault("a count is out of range"))
}

impl Header {
    /// The grid, when all that the header announces can be.
    fn checked_grid(&self, limit_bytes: u64) -> Result<RayGrid, StockFileError> {
        let absurd = |what: String| Err(StockFileError::Header { what });
        let b = &self.bounds;
        if !(0..3).all(|i| b.min[i].is_finite() && b.max[i].is_finite()) {
            return absurd("a box that is not finite".into());
        }
        let grid = TriDexel::plan(b, Cells(self.cells), limit_bytes)?;
        if grid.n.map(|n| n as u64) != self.counts.map(u64::from) {
            return absurd(format!("{:?} cells where box and cell size make {:?}", self.counts, grid.n));
        }
        let rays = grid.rays() as u64;
        let least = LEAST_INTERVAL.saturating_mul(self.intervals).saturating_add(rays);
        if least > self.lengths[0] {
            return absurd(format!(
                "{} intervals on {rays} rays in {} bytes, which need {least} at least",
                self.intervals, self.lengths[0]
            ));
        }
        let needed = (self.intervals.saturating_mul(size_of::<MaterialSpan>() as u64)).saturating_add(self.lengths[1]);
        if needed > limit_bytes {
            let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
            return absurd(format!(
                "{} intervals and a history of {:.0} MiB, more than the {:.0} MiB of memory allowed",
                self.intervals,
                mib(self.lengths[1]),
                mib(limit_bytes)
            ));
        }
        let volumes = [self.initial_volume, self.sweep_bound];
        if !volumes.iter().all(|v| v.is_finite() && *v >= 0.0) {
            return absurd(format!("an invalid volume or bound: {volumes:?}"));
        }
        Ok(grid)
    }
}

/// Intervals of all rays of a set.
struct Rays {
    start: Vec<usize>,
    spans: Vec<MaterialSpan>,
}

impl Rays {
    fn ray(&self, r: usize) -> &[MaterialSpan] {
        &self.spans[self.start[r]..self.start[r + 1]]
    }
}

fn decode_sets(bytes: &[u8], grid: &RayGrid, intervals: u64) -> Result<Vec<Rays>, StockFileError> {
    let mut parts = Vec::with_capacity(3);
    let mut at = 0;
    for a in 0..3 {
        let rest = &bytes[at..];
        let length = rest.first_chunk::<8>().map(|b| u64::from_le_bytes(*b)).unwrap_or(u64::MAX);
        let part = usize::try_from(length).ok().and_then(|n| rest.get(8..n.checked_add(8)?));
        let Some(part) = part else {
            return Err(StockFileError::Content { what: "a set of rays is longer than the content", at: at as u64 });
        };
        parts.push((a, at + 8, part));
        at += 8 + part.len();
    }
    if at != bytes.len() {
        return Err(StockFileError::Content { what: "bytes are left after the rays", at: at as u64 });
    }
    let sets: Result<Vec<Rays>, ByteFault> = parts
        .into_par_iter()
        .map(|(a, at, part)| decode_set(part, grid, a).map_err(|f| ByteFault { at: f.at + at, ..f }))
        .collect();
    let sets = sets?;
    if sets.iter().map(|s| s.spans.len() as u64).sum::<u64>() != intervals {
        return Err(StockFileError::Content { what: "the number of intervals is not that of the header", at: 0 });
    }
    Ok(sets)
}

fn decode_set(bytes: &[u8], grid: &RayGrid, a: usize) -> Result<Rays, ByteFault> {
    let mut input = Decoder::new(bytes);
    let rays = grid.n[(a + 1) % 3] * grid.n[(a + 2) % 3];
    let mut out = Rays { start: Vec::with_capacity(rays + 1), spans: Vec::new() };
    out.start.push(0);
    // A cell of play: rays may end by rounding outside of the box.
    let (low, high) = (grid.bounds.min[a] - grid.cells[a], grid.bounds.max[a] + grid.cells[a]);
    for _ in 0..rays {
        let count = input.number()?;
        if count.saturating_mul(LEAST_INTERVAL) > input.left() as u64 {
            return Err(input.fault("a ray has more intervals than there are bytes"));
        }
        let mut last = low;
        for k in 0..count as usize {
            let (lo, hi) = (input.end(2 * k)?, input.end(2 * k + 1)?);
            if !(last <= lo.s && lo.s < hi.s && hi.s <= high) {
                return Err(input.fault("the ends on a ray do not rise, or leave the box"));
            }
            last = hi.s;
            out.spans.push(MaterialSpan::from_ends(lo, hi));
        }
        out.start.push(out.spans.len());
    }
    if input.is_done() { Ok(out) } else { Err(input.fault("bytes are left after the last ray")) }
}
