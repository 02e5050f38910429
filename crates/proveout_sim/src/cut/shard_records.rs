//! Records in the files of a run in shards, and what can be wrong with them.

use std::{io::Read, path::PathBuf};

use thiserror::Error;

/// Why a shard cannot be cut, or its cuts not be taken.
#[derive(Debug, Error)]
#[error("{}: {message}", path.display())]
pub struct ShardError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub message: String,
}

impl ShardError {
    pub(crate) fn new(path: &std::path::Path, message: impl std::fmt::Display) -> Self {
        Self { path: path.to_owned(), message: message.to_string() }
    }
}

/// Reads exactly this many bytes; none at the end of the file.
pub(crate) fn record(input: &mut impl Read, length: usize) -> std::io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    input.by_ref().take(length as u64).read_to_end(&mut bytes)?;
    match bytes.len() {
        n if n == length => Ok(Some(bytes)),
        0 => Ok(None),
        _ => Err(std::io::Error::new(std::io::ErrorKind::UnexpectedEof, "it ends in the middle of a record")),
    }
}

pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(u32::MAX, u32::from_le_bytes)
}

pub(crate) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..at + 8).and_then(|b| b.try_into().ok()).map_or(u64::MAX, u64::from_le_bytes)
}

pub(crate) const CUTS_MAGIC: &[u8] = b"PROVEOUT-CUTS 1\n";

/// Bytes of a record before what became of the tiles, its length not counted.
pub(crate) const HEAD: usize = 24;
