//! Digests of input files, so that a verdict names exactly what it is about.

use std::path::Path;

use sha2::{Digest, Sha256};

use crate::config::ConfigError;

/// SHA-256 of a file in hexadecimal digits.
///
/// # Errors
/// [`ConfigError`] when the file cannot be read.
pub(crate) fn of_file(path: &Path) -> Result<String, ConfigError> {
    let bytes =
        std::fs::read(path).map_err(|e| ConfigError::file(path, format!("cannot be read: {e}"), "check the path"))?;
    Ok(of_bytes(&bytes))
}

/// SHA-256 of bytes in hexadecimal digits.
pub(crate) fn of_bytes(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}
