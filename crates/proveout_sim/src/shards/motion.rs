//! `motion.bin` and `shares.bin`: what a run asks of its stock, and which tile comes to which shard.
//!
//! ```text
//!   motion.bin   PROVEOUT-MOTION 1\n, then for each stretch with a tool in the spindle: pieces (4 bytes), and 109 bytes each:
//!                  0  number of the piece      4  tool        8  first piece of its barred run, 2^32 - 1 for none
//!                 12  1 where it goes down    13  tip and axis at both ends, twelve reals
//!   shares.bin   PROVEOUT-SHARES 1\n, shards (4), then for each patch and last for the stock: tiles (8), shard of each (2)
//! ```
//!
//! All numbers with the lowest byte first.

use std::{
    fs::File,
    io::{BufReader, BufWriter, Read, Write},
    path::Path,
};

use proveout_geom::{Point, ToolPose, Vector};
use proveout_stock::{SweepMotion, shares_of};

use super::{ShardError, record};
use crate::{
    error::SimError,
    prepare::Prepared,
    process::{Barring, Cutters, CuttingState, PieceCut, Sweeps, states_of_pieces},
    run::{STRETCH_S, controller, from_run_error, opened, stretches},
};

/// The motion of a run, in the folder of its sweep.
pub const MOTION: &str = "motion.bin";
/// Which tile comes to which shard.
pub const SHARES: &str = "shares.bin";

const MOTION_MAGIC: &[u8] = b"PROVEOUT-MOTION 1\n";
const SHARES_MAGIC: &[u8] = b"PROVEOUT-SHARES 1\n";
const PIECE: usize = 109;
/// Most pieces of a stretch of two seconds, and most tiles: what is more is no file of ours.
const MOST_PIECES: u32 = 1 << 24;
const MOST_TILES: u64 = 1 << 34;

/// What was planned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionPlan {
    /// Pieces of motion with a tool.
    pub pieces: u64,
    /// Tiles of stock and patches.
    pub tiles: u64,
    /// Sweeps that come to the tiles of the heaviest and of the lightest shard, before anything is cut.
    pub loads: [u64; 2],
}

/// Plans the motion of a run and shares the tiles of its stock out; writes both files into `folder`.
///
/// # Errors
/// [`SimError`] when program, control or stock refuse, or a file cannot be written.
pub fn plan_motion(mut prepared: Prepared, shards: u16, folder: &Path) -> Result<MotionPlan, SimError> {
    let (mut stock, mut patches) = prepared.stock.take()?;
    let prepared = prepared;
    let cutters = Cutters::new(&prepared.tools.tools, &prepared.holder_zones, stock.cell_mm());
    let work_from_table = prepared.table_from_work.inverse();
    let fields = patches.iter().map(|p| p.stock().ray_tiles()).chain([stock.ray_tiles()]);
    let mut loads: Vec<Vec<u64>> = fields.map(|tiles| vec![0; tiles]).collect();
    let mut plan = MotionPlan { tiles: loads.iter().map(|l| l.len() as u64).sum(), ..MotionPlan::default() };

    let mut out = BufWriter::new(File::create(folder.join(MOTION)).map_err(SimError::Folder)?);
    out.write_all(MOTION_MAGIC).map_err(SimError::Folder)?;
    let (mut barring, mut state, mut id) = (Barring::default(), CuttingState::IDLE, 0);
    let mut control = controller(&prepared)?;
    while let Some(chunk) = control.next_chunk().map_err(|e| from_run_error(opened(&prepared, e)))? {
        for stretch in stretches(chunk, STRETCH_S) {
            let states = states_of_pieces(&stretch, &mut state, |_| ());
            let mut cuts = Vec::with_capacity(stretch.pieces.len());
            for (piece, state) in stretch.pieces.iter().zip(&states) {
                let [from, to] = piece.pose.map(|p| p.transformed(&work_from_table));
                cuts.extend(barring.cut(id, piece, state, &prepared.tools.tools, SweepMotion { from, to }));
                id += 1;
            }
            if cuts.is_empty() {
                continue;
            }
            plan.pieces += cuts.len() as u64;
            write_stretch(&mut out, &cuts).map_err(SimError::Folder)?;
            let mut sweeps = Sweeps::default();
            cuts.iter().for_each(|cut| cutters.add(&mut sweeps, 0, cut));
            for (patch, loads) in patches.iter_mut().zip(&mut loads) {
                let near = patch.near(&sweeps.items);
                patch.stock_mut().add_loads(&near, loads);
            }
            if let Some(loads) = loads.last_mut() {
                stock.add_loads(&sweeps.items, loads);
            }
        }
    }
    out.flush().map_err(SimError::Folder)?;
    drop(out);
    let owners: Vec<Vec<u16>> = loads.iter().map(|l| shares_of(l, shards)).collect();
    let load = |k: u16| {
        let all = loads.iter().zip(&owners).flat_map(|(l, o)| l.iter().zip(o));
        all.filter(|(_, owner)| **owner == k).map(|(load, _)| load).sum::<u64>()
    };
    plan.loads = [(0..shards).map(load).max().unwrap_or(0), (0..shards).map(load).min().unwrap_or(0)];
    write_shares(&folder.join(SHARES), shards, &owners).map_err(SimError::Folder)?;
    Ok(plan)
}

fn write_stretch(out: &mut impl Write, cuts: &[PieceCut]) -> std::io::Result<()> {
    out.write_all(&(cuts.len() as u32).to_le_bytes())?;
    for cut in cuts {
        out.write_all(&cut.id.to_le_bytes())?;
        out.write_all(&(cut.tool as u32).to_le_bytes())?;
        out.write_all(&cut.since.unwrap_or(u32::MAX).to_le_bytes())?;
        out.write_all(&[u8::from(cut.goes_down)])?;
        for pose in [&cut.motion.from, &cut.motion.to] {
            for x in [pose.tip.x, pose.tip.y, pose.tip.z, pose.axis.x, pose.axis.y, pose.axis.z] {
                out.write_all(&x.to_bits().to_le_bytes())?;
            }
        }
    }
    Ok(())
}

fn write_shares(path: &Path, shards: u16, owners: &[Vec<u16>]) -> std::io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(SHARES_MAGIC)?;
    out.write_all(&u32::from(shards).to_le_bytes())?;
    for field in owners {
        out.write_all(&(field.len() as u64).to_le_bytes())?;
        for owner in field {
            out.write_all(&owner.to_le_bytes())?;
        }
    }
    out.flush()
}

/// Reads the motion, stretch by stretch.
pub(super) struct MotionReader<'p> {
    path: &'p Path,
    input: BufReader<File>,
}

impl<'p> MotionReader<'p> {
    pub(super) fn open(path: &'p Path) -> Result<Self, ShardError> {
        let fault = |e: std::io::Error| ShardError::new(path, format!("cannot be read: {e}"));
        let mut input = BufReader::with_capacity(1 << 20, File::open(path).map_err(fault)?);
        match record(&mut input, MOTION_MAGIC.len()).map_err(fault)? {
            Some(magic) if magic == MOTION_MAGIC => Ok(Self { path, input }),
            _ => Err(ShardError::new(path, "is no motion that this version reads")),
        }
    }

    /// The pieces of the next stretch.
    pub(super) fn next(&mut self, tools: usize) -> Result<Option<Vec<PieceCut>>, ShardError> {
        let path = self.path;
        let fault = |message: String| ShardError::new(path, message);
        let read =
            |input: &mut BufReader<File>, n: usize| record(input, n).map_err(|e| fault(format!("cannot be read: {e}")));
        let Some(head) = read(&mut self.input, 4)? else { return Ok(None) };
        let count = u32_at(&head, 0);
        if count > MOST_PIECES {
            return Err(fault("a stretch has more pieces than there can be".into()));
        }
        let length = count as usize * PIECE;
        let Some(bytes) = read(&mut self.input, length)? else {
            return Err(fault("it ends in the middle of a record".into()));
        };
        let pieces = bytes.chunks_exact(PIECE).map(|b| {
            let pose = |at: usize| {
                let x = |k: usize| f64::from_bits(u64_at(b, at + 8 * k));
                ToolPose { tip: Point::new(x(0), x(1), x(2)), axis: Vector::new(x(3), x(4), x(5)) }
            };
            let tool = u32_at(b, 4) as usize;
            if tool >= tools {
                return Err(fault("a tool that the library does not have".into()));
            }
            Ok(PieceCut {
                id: u32_at(b, 0),
                tool,
                since: Some(u32_at(b, 8)).filter(|s| *s != u32::MAX),
                goes_down: b[12] != 0,
                motion: SweepMotion { from: pose(13), to: pose(61) },
            })
        });
        pieces.collect::<Result<Vec<_>, _>>().map(Some)
    }
}

/// Reads who has which tile: for each patch and last for the stock, of which `tiles` are known.
pub(super) fn read_shares(path: &Path, (shard, of): (u16, u16), tiles: &[usize]) -> Result<Vec<Vec<u16>>, ShardError> {
    let fault = |e: std::io::Error| ShardError::new(path, format!("cannot be read: {e}"));
    let other = || ShardError::new(path, "is not of this stock, or of another number of shards");
    let mut input = BufReader::with_capacity(1 << 20, File::open(path).map_err(fault)?);
    let head = record(&mut input, SHARES_MAGIC.len() + 4).map_err(fault)?.unwrap_or_default();
    if !head.starts_with(SHARES_MAGIC) || u32_at(&head, SHARES_MAGIC.len()) != u32::from(of) || shard >= of {
        return Err(other());
    }
    let mut all = Vec::new();
    for &count in tiles {
        let told = record(&mut input, 8).map_err(fault)?.map_or(u64::MAX, |b| u64_at(&b, 0));
        if told != count as u64 || told > MOST_TILES {
            return Err(other());
        }
        let bytes = record(&mut input, 2 * count).map_err(fault)?.ok_or_else(other)?;
        let owners: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        if owners.iter().any(|o| *o >= of) {
            return Err(other());
        }
        all.push(owners);
    }
    let mut rest = [0];
    if input.read(&mut rest).map_err(fault)? > 0 { Err(other()) } else { Ok(all) }
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(u32::MAX, u32::from_le_bytes)
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..at + 8).and_then(|b| b.try_into().ok()).map_or(u64::MAX, u64::from_le_bytes)
}
