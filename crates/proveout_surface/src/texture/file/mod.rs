//! Files of measured and simulated texture.
//!
//! Each format with its standard, what is read and what is written:
//!
//! - **SMD**, ISO 5436-2:2012, softgauge (type F1): profiles at equal steps are read; not written
//! - **SDF**, ISO 25178-71:2017, text and binary, `ISO-1.0` and `ISO-2.0`, and the text of the softgauges of
//!   NPL (`aNPL-V1.0`): profiles and maps are read; `ISO-1.0` is written, text and binary
//! - **X3P**, ISO 25178-72:2017 with its amendment of 2020: profiles and maps at equal steps are read, all
//!   data types, both checksums; doubles are written
//!
//! Lengths in the files are meters or carry their unit; in here they are mm. What a file says is taken at its
//! word and checked: counts, steps, checksums, heights that are missing. Evaluations want complete lattices,
//! so a missing height is refused with its place; fill it in where it was measured, by a rule that you choose
//! and know.
//!
//! What is refused by name: compressed SDF, axes of absolute places in place of equal steps, clouds of
//! points, several layers, encrypted archives.

mod md5;
mod sdf;
mod smd;
mod x3p;
mod xml;
mod zip;

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use proveout_input::{open_regular_file, read_regular_file};
pub use sdf::{SdfForm, sdf_bytes};
pub use x3p::x3p_bytes;

use super::{HeightMap, Profile, TextureError};

/// Largest number of heights in a file: a square of 5000 by 5000. Its evaluation takes about 2 GiB.
pub const MOST_HEIGHTS: usize = 25_000_000;
/// Largest height and step, mm: a thousand times the largest machines.
const FARTHEST: f64 = 1e6;
/// Largest file, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Why a file of texture cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct TextureFileError {
    /// The file.
    pub path: PathBuf,
    /// Line from 1; 0 where the fault has none.
    pub line: usize,
    /// What is wrong, with its value and the limit.
    pub message: String,
    /// What to do.
    pub help: String,
}

/// A fault within the bytes of a file: line (0 for none), message, remedy.
#[derive(Debug, PartialEq)]
pub(super) struct FileFault {
    line: usize,
    message: String,
    help: &'static str,
}

impl FileFault {
    fn new(message: impl Into<String>, help: &'static str) -> Self {
        Self { line: 0, message: message.into(), help }
    }

    fn at(line: usize, message: impl Into<String>, help: &'static str) -> Self {
        Self { line, message: message.into(), help }
    }

    fn of_texture(error: &TextureError) -> Self {
        let help = match error {
            TextureError::Hole { .. } => HOLE_HELP,
            TextureError::Step(_) => "the spacing of an axis is a positive length",
            _ => "write the file again from the measuring program",
        };
        Self::new(error.to_string(), help)
    }
}

pub(super) const HOLE_HELP: &str = "fill in missing heights in the measuring program, or cut out a part without any";

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Measured {
    /// Heights over a line.
    Profile(Profile),
    /// Heights over a rectangle.
    Map(HeightMap),
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredFile {
    /// What it holds.
    pub measured: Measured,
    /// Format, with its standard.
    pub format: &'static str,
    /// What a reader should know, such as a checksum that is not that of the file.
    pub remarks: Vec<String>,
}

/// Heights at equal steps as files take them: a profile has one row.
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a> {
    columns: usize,
    rows: usize,
    step_x: f64,
    step_y: f64,
    heights: &'a [f64],
}

impl<'a> From<&'a HeightMap> for Lattice<'a> {
    fn from(map: &'a HeightMap) -> Self {
        Self {
            columns: map.columns(),
            rows: map.rows(),
            step_x: map.step_x(),
            step_y: map.step_y(),
            heights: map.heights(),
        }
    }
}

impl<'a> From<&'a Profile> for Lattice<'a> {
    fn from(profile: &'a Profile) -> Self {
        let heights = profile.heights();
        Self { columns: heights.len(), rows: 1, step_x: profile.step(), step_y: 0.0, heights }
    }
}

/// A profile for one row, a map for more.
fn measured(columns: usize, rows: usize, steps: [f64; 2], heights: Vec<f64>) -> Result<Measured, FileFault> {
    if let Some(k) = heights.iter().position(|z| z.abs() > FARTHEST) {
        return Err(FileFault::new(
            format!("height {} is {} mm; the limit is {FARTHEST} mm", k + 1, heights[k]),
            "look at the unit and the scale of the heights",
        ));
    }
    if let Some(step) = steps.into_iter().find(|s| *s > FARTHEST) {
        return Err(FileFault::new(
            format!("a step of {step} mm; the limit is {FARTHEST} mm"),
            "look at the unit and the scale of the axes",
        ));
    }
    let built = if rows == 1 {
        Profile::new(steps[0], heights).map(Measured::Profile)
    } else {
        HeightMap::new(columns, rows, steps[0], steps[1], heights).map(Measured::Map)
    };
    built.map_err(|e| FileFault::of_texture(&e))
}

/// Number of heights, within the limit.
fn count(columns: usize, rows: usize) -> Result<usize, FileFault> {
    match columns.checked_mul(rows) {
        Some(n) if (2..=MOST_HEIGHTS).contains(&n) => Ok(n),
        _ => Err(FileFault::new(
            format!("{columns} x {rows} heights; 2 to {MOST_HEIGHTS} are read"),
            "cut out a part, or thin the points out",
        )),
    }
}

/// Whether a path names a file of texture: by its ending, else by its first bytes.
pub fn is_texture(path: &Path) -> bool {
    use std::io::Read;
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    if matches!(ending.as_deref(), Some("sdf" | "x3p" | "smd")) {
        return !path.is_dir();
    }
    let mut begin = Vec::new();
    let read = open_regular_file(path).and_then(|f| f.take(64).read_to_end(&mut begin));
    read.is_ok() && (begin.starts_with(b"PK\x03\x04") || sdf::is_sdf(&begin) || begin.starts_with(b"ISO 5436"))
}

/// Reads the bytes of a file; the format is detected from them, not from the name.
///
/// # Errors
/// [`TextureFileError`] with place, value, limit and remedy.
pub fn read_measured_bytes(path: &Path, bytes: &[u8]) -> Result<MeasuredFile, TextureFileError> {
    let read = if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        x3p::read(bytes)
    } else if sdf::is_sdf(bytes) {
        sdf::read(bytes)
    } else if bytes.contains(&smd::END_OF_RECORD) {
        smd::read(bytes)
    } else {
        let begin: String = bytes.iter().take(16).map(|b| char::from(*b)).filter(|c| !c.is_control()).collect();
        Err(FileFault::new(
            format!("no file of texture: {} bytes that begin with {begin:?}", bytes.len()),
            "SMD (ISO 5436-2), SDF (ISO 25178-71) and X3P (ISO 25178-72) are read; export one of them",
        ))
    };
    read.map_err(|f| TextureFileError {
        path: path.to_path_buf(),
        line: f.line,
        message: f.message,
        help: f.help.to_owned(),
    })
}

/// Reads a file of texture.
///
/// # Errors
/// [`TextureFileError`] with place, value, limit and remedy.
pub fn read_measured(path: &Path) -> Result<MeasuredFile, TextureFileError> {
    let fail = |message: String, help: &str| TextureFileError {
        path: path.to_path_buf(),
        line: 0,
        message,
        help: help.to_owned(),
    };
    let bytes = read_regular_file(path, MOST_BYTES).map_err(|e| {
        let help = match e.kind() {
            ErrorKind::FileTooLarge => "cut out a part, or thin the points out",
            ErrorKind::PermissionDenied => "look at the rights of the file",
            _ => "name a file of texture: SMD, SDF or X3P",
        };
        fail(format!("cannot be read: {e}"), help)
    })?;
    read_measured_bytes(path, &bytes)
}

fn write(path: &Path, bytes: Result<Vec<u8>, FileFault>) -> Result<(), TextureFileError> {
    let fail = |message: String, help: &str| TextureFileError {
        path: path.to_path_buf(),
        line: 0,
        message,
        help: help.to_owned(),
    };
    let bytes = bytes.map_err(|f| fail(f.message, f.help))?;
    std::fs::write(path, bytes).map_err(|e| fail(format!("cannot be written: {e}"), "name a place that can be written"))
}

/// Writes SDF, `ISO-1.0`.
///
/// # Errors
/// More than 65,535 points along a direction, which the format cannot say; a place that cannot be written.
pub fn write_sdf<'a>(path: &Path, lattice: impl Into<Lattice<'a>>, form: SdfForm) -> Result<(), TextureFileError> {
    write(path, sdf::bytes(&lattice.into(), form))
}

/// Writes X3P.
///
/// # Errors
/// More than 4 GiB, which the archive cannot say; a place that cannot be written.
pub fn write_x3p<'a>(path: &Path, lattice: impl Into<Lattice<'a>>) -> Result<(), TextureFileError> {
    write(path, x3p::bytes(&lattice.into()))
}
