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
    io::{BufReader, BufWriter, Write},
    path::Path,
    time::Instant,
};

use proveout_stock::{ShareLog, TriDexel};

use crate::{
    cut::{
        journal::motion,
        shard_records::{CUTS_MAGIC, HEAD, ShardError},
        tool_sweeps::Sweeps,
    },
    prepare::{error::SimError, memory::MEMORY},
    run::shards::motion::{MOTION, MotionReader, raw_files, raw_patch},
};

/// What a shard took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShardCost {
    /// Pieces of motion.
    pub pieces: u64,
    /// Bytes of its cuts.
    pub bytes: u64,
    /// Wall time of the cutting alone, s.
    pub removal_s: f64,
    /// Memory of its stock and patches at the end, bytes.
    pub stock_bytes: u64,
}

/// Cuts the shard whose raw stock lies in `job`, of a run whose motion lies in `folder`, and writes
/// what became of its tiles to `out`. `tell` is called after each stretch with the number of pieces
/// done.
///
/// # Errors
/// [`SimError`] when motion or stock cannot be read, or the file cannot be written.
pub fn cut_shard(folder: &Path, job: &Path, out: &Path, tell: &mut dyn FnMut(u64)) -> Result<ShardCost, SimError> {
    let path = folder.join(MOTION);
    let (mut stretches, cutters) = MotionReader::open(&path)?;
    let patches = (0..).take_while(|k| job.join(raw_patch(*k)).is_file()).count();
    let mut fields = Vec::new();
    for name in raw_files(patches) {
        let path = job.join(name);
        let fault = |e: &dyn std::fmt::Display| ShardError::new(&path, format!("cannot be read: {e}"));
        let mut file = BufReader::new(File::open(&path).map_err(|e| fault(&e))?);
        let mut field = TriDexel::load(&mut file, MEMORY).map_err(|e| fault(&e))?;
        field.pass_over_empty_rows();
        fields.push(field);
    }
    let Some(mut stock) = fields.pop() else { return Err(ShardError::new(job, "holds no stock").into()) };
    stock.watch_engagement(stretches.engagement);
    let mut patches = fields;
    let mut cost = ShardCost::default();
    let mut file = BufWriter::with_capacity(1 << 20, File::create(out).map_err(SimError::Folder)?);
    file.write_all(CUTS_MAGIC).map_err(SimError::Folder)?;
    cost.bytes = CUTS_MAGIC.len() as u64;
    while let Some(cuts) = stretches.next(cutters.0.len())? {
        let mut sweeps = Sweeps::default();
        cuts.iter().for_each(|cut| cutters.add(&mut sweeps, 0, cut));
        cost.pieces += cuts.len() as u64;
        let [Some(first), Some(last)] = [sweeps.items.first(), sweeps.items.last()] else { continue };
        let cutting = Instant::now();
        let mut log = ShareLog::default();
        for patch in &mut patches {
            let near = patch.removing_near(&sweeps.items);
            if !near.is_empty() {
                patch.sweep_share(&near, &[], &mut log);
            }
        }
        stock.sweep_share(&sweeps.items, &sweeps.measures, &mut log);
        cost.removal_s += cutting.elapsed().as_secs_f64();
        let content = log.into_bytes();
        let length = HEAD + content.len();
        let short =
            u32::try_from(length).map_err(|_too_long| ShardError::new(out, "a stretch has more than 4 GiB of cuts"))?;
        let mut head = short.to_le_bytes().to_vec();
        head.extend([first.id, last.id].iter().flat_map(|id| id.to_le_bytes()));
        head.extend(motion(&sweeps.items, &sweeps.measures));
        file.write_all(&head).and_then(|()| file.write_all(&content)).map_err(SimError::Folder)?;
        cost.bytes += (4 + length) as u64;
        tell(cost.pieces);
    }
    file.into_inner().map_err(|e| SimError::Folder(e.into_error()))?.sync_all().map_err(SimError::Folder)?;
    let patches: u64 = patches.iter().map(TriDexel::memory_bytes).sum();
    cost.stock_bytes = stock.memory_bytes() + patches;
    Ok(cost)
}
