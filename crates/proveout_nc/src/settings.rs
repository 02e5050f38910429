//! What the reader must know besides the text.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::OrientationInterpolation;

/// Language of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dialect {
    /// Told from the ending of the file and from its text.
    #[default]
    Auto,
    /// Siemens Sinumerik 840D sl.
    Siemens840d,
    /// RS274 as spoken by Fanuc, Haas and `LinuxCNC`.
    Iso,
}

/// Values of one work offset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorkOffset {
    /// Offset of X, Y, Z in base coordinates, mm.
    pub translation: [f64; 3],
    /// Offset of the rotary axes A, B, C, radian.
    pub rotary: [f64; 3],
}

/// What stops a program that never ends by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Subprogram calls within each other.
    pub max_call_depth: u32,
    /// Jumps back to an earlier block (loop passes, GOTOB, REPEAT) in the whole run.
    pub max_loop_passes: u64,
    /// Jumps back without any motion between them.
    pub max_idle_passes: u64,
    /// Elements of all arrays of a program together.
    pub max_array_elements: usize,
}

impl Default for Limits {
    /// 32 calls deep (an 840D allows 16), 100 million passes, one million of them without motion, a million elements.
    fn default() -> Self {
        Self {
            max_call_depth: 32,
            max_loop_passes: 100_000_000,
            max_idle_passes: 1_000_000,
            max_array_elements: 1_000_000,
        }
    }
}

/// Settings of a reader.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Language of the program.
    pub dialect: Dialect,
    /// Work offsets by the word that calls them (`G54`, `G505`). An offset that is not named here is zero.
    pub work_offsets: BTreeMap<String, WorkOffset>,
    /// Values of variables that the program reads and does not set itself: `R5`, names of global user data.
    pub variables: BTreeMap<String, f64>,
    /// Folders searched for subprograms after the folder of the program.
    pub subprogram_folders: Vec<PathBuf>,
    /// Levels 0 to 9 of blocks with `/` that are skipped: bit i for level i.
    pub skipped_levels: u16,
    /// Largest difference between the radius at the start and at the end of an arc, mm.
    pub arc_tolerance_mm: f64,
    /// Path of the orientation before the program says otherwise.
    pub orientation_interpolation: OrientationInterpolation,
    /// Limits of loops, calls and memory.
    pub limits: Limits,
}

impl Default for Settings {
    /// No offsets, no block skipped, 0.01 mm arc tolerance (as `MD21000` of an 840D), tool axis on the great circle.
    fn default() -> Self {
        Self {
            dialect: Dialect::Auto,
            work_offsets: BTreeMap::new(),
            variables: BTreeMap::new(),
            subprogram_folders: Vec::new(),
            skipped_levels: 0,
            arc_tolerance_mm: 0.01,
            orientation_interpolation: OrientationInterpolation::GreatCircle,
            limits: Limits::default(),
        }
    }
}
