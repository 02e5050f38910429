//! One shard: the motion of the run through the tiles that are its own.
//!
//! ```text
//!   cuts.bin   PROVEOUT-CUTS 1\n, then for each stretch of motion.bin:
//!                0  length of what follows (4)
//!                4  first and last piece (4, 4)      12  begin of the SHA-256 of the sweeps (16)
//!               28  what became of patches and stock ([`proveout_stock::ShareLog`])
//! ```

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
    time::Instant,
};

use proveout_stock::ShareLog;

use super::motion::{MOTION, MotionReader, SHARES, read_shares};
use crate::{
    error::SimError,
    journal::motion,
    prepare::Prepared,
    process::{Cutters, Sweeps},
};

pub(super) const CUTS_MAGIC: &[u8] = b"PROVEOUT-CUTS 1\n";
/// Bytes of a record before what became of the tiles, its length not counted.
pub(super) const HEAD: usize = 24;

/// What a shard took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShardCost {
    /// Tiles of its own, of stock and patches.
    pub tiles: u64,
    /// Pieces of motion.
    pub pieces: u64,
    /// Bytes of its cuts.
    pub bytes: u64,
    /// Wall time of the cutting alone, s.
    pub removal_s: f64,
    /// Memory of its stock and patches at the end, bytes.
    pub stock_bytes: u64,
}

/// Cuts a shard (from 0) of a run whose motion lies in `folder`, and writes what became of its tiles to `out`. `tell` hears, stretch by
/// stretch, how many pieces are done.
///
/// # Errors
/// [`SimError`] when motion or shares are not those of this run, or the file cannot be written.
pub fn cut_shard(
    mut prepared: Prepared,
    folder: &Path,
    (shard, of): (u16, u16),
    out: &Path,
    tell: &mut dyn FnMut(u64),
) -> Result<ShardCost, SimError> {
    let (mut stock, mut patches) = prepared.stock.take()?;
    let prepared = prepared;
    let tiles: Vec<usize> = patches.iter().map(|p| p.stock().ray_tiles()).chain([stock.ray_tiles()]).collect();
    let owners = read_shares(&folder.join(SHARES), (shard, of), &tiles)?;
    for (patch, owners) in patches.iter_mut().zip(&owners) {
        patch.stock_mut().keep_share(owners, shard);
    }
    if let Some(owners) = owners.last() {
        stock.keep_share(owners, shard);
    }
    let own = |field: &Vec<u16>| field.iter().filter(|o| **o == shard).count() as u64;
    let mut cost = ShardCost { tiles: owners.iter().map(own).sum(), ..ShardCost::default() };
    let cutters = Cutters::new(&prepared.tools.tools, &prepared.holder_zones, stock.cell_mm());
    let path = folder.join(MOTION);
    let mut stretches = MotionReader::open(&path)?;
    let mut file = BufWriter::with_capacity(1 << 20, File::create(out).map_err(SimError::Folder)?);
    file.write_all(CUTS_MAGIC).map_err(SimError::Folder)?;
    cost.bytes = CUTS_MAGIC.len() as u64;
    while let Some(cuts) = stretches.next(prepared.tools.tools.len())? {
        let mut sweeps = Sweeps::default();
        cuts.iter().for_each(|cut| cutters.add(&mut sweeps, 0, cut));
        cost.pieces += cuts.len() as u64;
        let [Some(first), Some(last)] = [sweeps.items.first(), sweeps.items.last()] else { continue };
        let cutting = Instant::now();
        let mut log = ShareLog::default();
        for patch in &mut patches {
            let near = patch.near(&sweeps.items);
            if !near.is_empty() {
                patch.stock_mut().sweep_share(&near, &[], &mut log);
            }
        }
        stock.sweep_share(&sweeps.items, &sweeps.measures, &mut log);
        cost.removal_s += cutting.elapsed().as_secs_f64();
        let content = log.into_bytes();
        let length = HEAD + content.len();
        let short =
            u32::try_from(length).map_err(|_| super::ShardError::new(out, "a stretch has more than 4 GiB of cuts"))?;
        let mut head = short.to_le_bytes().to_vec();
        head.extend([first.id, last.id].iter().flat_map(|id| id.to_le_bytes()));
        head.extend(motion(&sweeps.items, &sweeps.measures));
        file.write_all(&head).and_then(|()| file.write_all(&content)).map_err(SimError::Folder)?;
        cost.bytes += (4 + length) as u64;
        tell(cost.pieces);
    }
    file.into_inner().map_err(|e| SimError::Folder(e.into_error()))?.sync_all().map_err(SimError::Folder)?;
    let patches: u64 = patches.iter().map(|p| p.stock().memory_bytes()).sum();
    cost.stock_bytes = stock.memory_bytes() + patches;
    Ok(cost)
}
