//! Posts: canonical commands to program text.
//!
//! A post writes what the commands say and nothing else. Reading the text gives the same motions within the decimals that
//! were written; a frame may come back as several commands that end in the same transform.

mod siemens;

use std::collections::BTreeMap;
use std::io;

use crate::{Location, WorkOffset};

pub use siemens::SiemensPost;

/// Format of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct PostSettings {
    /// Decimals of lengths, mm.
    pub length_decimals: usize,
    /// Decimals of rotary axes and frame angles, degrees.
    pub angle_decimals: usize,
    /// Decimals of the components of tool vectors.
    pub vector_decimals: usize,
    /// Decimals of feed values.
    pub feed_decimals: usize,
    /// Distance of the N words; none: no N words.
    pub block_number_step: Option<u32>,
    /// Values of the work offsets that stand in the control, as in [`crate::Settings::work_offsets`]: a frame command gives
    /// the whole transform, the text only the part above the work offset.
    pub work_offsets: BTreeMap<String, WorkOffset>,
}

impl Default for PostSettings {
    /// 3 decimals for lengths and angles of axes as shop programs have, 6 for vectors, no block numbers, no offsets.
    fn default() -> Self {
        Self {
            length_decimals: 3,
            angle_decimals: 3,
            vector_decimals: 6,
            feed_decimals: 1,
            block_number_step: None,
            work_offsets: BTreeMap::new(),
        }
    }
}

/// Why a program could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PostError {
    /// The sink failed.
    #[error("the program cannot be written: {0}")]
    Io(#[from] io::Error),
    /// A command that the language of the post cannot say.
    #[error("{}:{}: {what}; {help}", location.file, location.line)]
    Unsupported {
        /// What cannot be said.
        what: String,
        /// What to do about it.
        help: &'static str,
        /// Place of the command.
        location: Location,
    },
}

/// Number with at most so many decimals, without trailing zeros: `10`, `-0.5`, `0`.
fn decimal(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" { "0".to_owned() } else { text }
}

/// As [`decimal`], with as many decimals as it takes for a value above zero not to become zero.
fn positive(value: f64, decimals: usize) -> String {
    (decimals..decimals + 12).map(|d| decimal(value, d)).find(|text| text != "0").unwrap_or_else(|| "0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{decimal, positive};

    #[test]
    fn a_small_feed_stays_a_feed() {
        assert_eq!(positive(0.001, 1), "0.001");
        assert_eq!(positive(100.0, 1), "100");
    }

    #[test]
    fn decimals_are_trimmed() {
        assert_eq!(decimal(10.0, 3), "10");
        assert_eq!(decimal(-0.5, 3), "-0.5");
        assert_eq!(decimal(-0.0001, 3), "0");
        assert_eq!(decimal(100.0, 0), "100");
        assert_eq!(decimal(1.23456, 4), "1.2346");
    }
}
