//! Digests of input files, so that a verdict names exactly what it is about.

use std::{
    io::{BufReader, Read},
    path::{Path, PathBuf},
};

use proveout_input::{InputError, open_regular_file};
use sha2::{Digest, Sha256};

/// A file that a run has opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// What it is to the run: `scene`, `machine`, `program`, `fixture vise`.
    pub role: String,
    /// Where it was opened.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
}

/// SHA-256 of bytes.
pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

/// Size and SHA-256 of a file, which may be larger than the memory.
///
/// # Errors
/// What the system says.
pub fn measure(path: &Path) -> std::io::Result<(u64, String)> {
    let mut file = BufReader::with_capacity(1 << 20, open_regular_file(path)?);
    let (mut hash, mut bytes) = (Sha256::new(), 0);
    let mut buffer = vec![0; 1 << 16];
    loop {
        let read = file.read(&mut buffer)?;
        if read == 0 {
            return Ok((bytes, hex(&hash.finalize())));
        }
        hash.update(&buffer[..read]);
        bytes += read as u64;
    }
}

/// The same with its role.
///
/// # Errors
/// [`InputError`] when the file cannot be read.
pub fn of_input(role: &str, path: &Path) -> Result<InputFile, InputError> {
    let (bytes, sha256) =
        measure(path).map_err(|e| InputError::file(path, format!("cannot be read: {e}"), "check the path"))?;
    Ok(InputFile { role: role.to_owned(), path: path.to_owned(), bytes, sha256 })
}

/// SHA-256 of bytes in hexadecimal digits.
pub fn of_bytes(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|b| format!("{b:02x}")).collect()
}
