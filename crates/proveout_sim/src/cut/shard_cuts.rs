//! The cuts of all shards, taken by the run that brings them together.

use std::{
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
};

use proveout_stock::{Depths, Measure, ShareReplay, StockFileError, SweepItem, SweepReport};

use crate::cut::{
    cutting::Cutting,
    journal::motion,
    shard_records::{CUTS_MAGIC, HEAD, ShardError, record, u32_at},
};

/// What a merged run had from its shards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShardFacts {
    /// Shards.
    pub shards: usize,
    /// Sweeps that were taken from them.
    pub taken: u64,
    /// Sweeps that the run made itself, since a body came near the stock within their stretch.
    pub near_bodies: u64,
    /// Sweeps that the run made itself after the first part that was looked at as loose.
    pub behind_loose_part: u64,
}

/// The cuts of all shards of a run.
#[derive(Debug)]
pub struct ShardCuts {
    inputs: Vec<(PathBuf, BufReader<File>)>,
    /// The records of the stretch at work, of each shard.
    at: Vec<Vec<u8>>,
    left: bool,
    fault: Option<ShardError>,
    facts: ShardFacts,
}

impl ShardCuts {
    /// Opens the cuts of all shards, in their order.
    ///
    /// # Errors
    /// [`ShardError`] for a file that is missing or none of cuts.
    pub fn open(paths: &[PathBuf]) -> Result<Self, ShardError> {
        let open = |path: &PathBuf| {
            let fault = |e: std::io::Error| ShardError::new(path, format!("cannot be read: {e}"));
            let mut input = BufReader::with_capacity(1 << 20, File::open(path).map_err(fault)?);
            match record(&mut input, CUTS_MAGIC.len()).map_err(fault)? {
                Some(magic) if magic == CUTS_MAGIC => Ok((path.clone(), input)),
                _ => Err(ShardError::new(path, "holds no cuts that this version can read")),
            }
        };
        let inputs = paths.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let facts = ShardFacts { shards: inputs.len(), ..ShardFacts::default() };
        Ok(Self { inputs, at: Vec::new(), left: false, fault: None, facts })
    }

    /// What was taken from them so far.
    pub fn facts(&self) -> ShardFacts {
        self.facts
    }

    pub(crate) fn take_fault(&mut self) -> Option<ShardError> {
        self.fault.take()
    }

    /// Nothing is taken any more: the stock is another than that of the shards.
    pub(crate) fn leave(&mut self) {
        self.left = true;
        self.at = Vec::new();
    }

    /// Takes what the shards say of these sweeps, or makes them.
    pub(crate) fn sweep(
        &mut self,
        cutting: &mut Cutting<'_>,
        items: &[SweepItem<'_>],
        measures: &[Measure],
    ) -> Vec<SweepReport> {
        let count = items.len() as u64;
        if self.left || self.fault.is_some() {
            self.facts.behind_loose_part += count;
            return cutting.sweep(items, measures);
        }
        let (Some(first), Some(last)) = (items.first(), items.last()) else { return Vec::new() };
        if let Err(fault) = self.come_to(first.id) {
            self.fault = Some(fault);
            return cutting.sweep(items, measures);
        }
        let whole = self.at.first().is_some_and(|r| [u32_at(r, 0), u32_at(r, 4)] == [first.id, last.id]);
        if !whole {
            self.facts.near_bodies += count;
            return cutting.sweep(items, measures);
        }
        let motion = motion(items, measures);
        if let Some(k) = self.at.iter().position(|r| r.get(8..HEAD) != Some(&motion[..])) {
            self.fault = Some(ShardError::new(&self.inputs[k].0, "its motion differs from that of the merged run"));
            return cutting.sweep(items, measures);
        }
        match taken(&self.at, cutting, items, measures) {
            Ok(reports) => {
                self.facts.taken += count;
                reports
            }
            Err(e) => {
                let path = self.inputs.first().map_or_else(|| Path::new("").to_owned(), |i| i.0.clone());
                self.fault = Some(ShardError::new(&path, format!("this shard or a later one does not match: {e}")));
                // The run ends after this stretch; its reports have to be there.
                vec![SweepReport::default(); items.len()]
            }
        }
    }

    /// Reads on until the records hold the piece.
    fn come_to(&mut self, piece: u32) -> Result<(), ShardError> {
        while self.at.first().is_none_or(|r| u32_at(r, 4) < piece) {
            let next = |(path, input): &mut (PathBuf, BufReader<File>)| {
                let fault = |message: String| ShardError::new(path, message);
                let read = |input: &mut BufReader<File>, n: usize| {
                    record(input, n).map_err(|e| fault(format!("cannot be read: {e}")))
                };
                let ends = || fault(format!("it ends before piece {piece} of the motion"));
                let length = u32_at(&read(input, 4)?.ok_or_else(ends)?, 0) as usize;
                if length < HEAD {
                    return Err(fault("a record without a begin".into()));
                }
                read(input, length)?.ok_or_else(ends)
            };
            self.at = self.inputs.iter_mut().map(next).collect::<Result<_, _>>()?;
            if let Some(k) = self.at.iter().position(|r| r[..8] != self.at[0][..8]) {
                return Err(ShardError::new(&self.inputs[k].0, "its stretches differ from those of the first shard"));
            }
        }
        Ok(())
    }
}

fn taken(
    records: &[Vec<u8>],
    cutting: &mut Cutting<'_>,
    items: &[SweepItem<'_>],
    measures: &[Measure],
) -> Result<Vec<SweepReport>, StockFileError> {
    let mut told: Vec<ShareReplay<'_>> =
        records.iter().map(|r| ShareReplay::new(r.get(HEAD..).unwrap_or_default())).collect();
    for patch in cutting.patches.iter_mut() {
        let near = patch.near(items);
        if !near.is_empty() {
            patch.stock_mut().apply_shares(&near, &[], &mut Depths::default(), &mut told)?;
        }
    }
    cutting.stock.apply_shares(items, measures, cutting.depths, &mut told)
}
