//! Where a compensated path enters its own contour.

use std::fmt;
use std::sync::Arc;

use crate::{AXIS_LETTERS, AxisValues};

/// A place where the tool, guided along its programmed contour, cuts into another part of it, and
/// the control goes on without an alarm: the blocks lie farther apart than it looks ahead, or it
/// does not look there at all.
///
/// The command comes at the end of the compensated stretch; its location is the block that the tool
/// follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Overcut {
    /// What it means.
    pub kind: OvercutKind,
    /// Greatest depth, mm.
    pub depth: f64,
    /// Radius of the compensation, mm.
    pub radius: f64,
    /// File of the block that is cut deepest.
    pub contour_file: Arc<str>,
    /// Its line, from 1.
    pub contour_line: u32,
    /// Point of the contour that is cut deepest, base coordinates, mm; only the axes that are known.
    pub point: AxisValues,
    /// The same point in the coordinates of the program, under the frame in force.
    pub programmed_point: AxisValues,
    /// Blocks of the path in a row for which this holds.
    pub blocks: u32,
}

/// What an overcut means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OvercutKind {
    /// The tool does not fit between two parts of the contour.
    Narrow,
    /// As [`OvercutKind::Narrow`], but the path is higher than the block that is cut was: it is one where
    /// that wall reaches up.
    Above,
    /// The tool runs into the free start or end of the contour.
    ContourEnd,
    /// The straight move onto the contour cuts it.
    Entry,
    /// The straight move off the contour cuts it.
    Exit,
    /// The programmed contour runs through material that an earlier or later part of it would
    /// leave, as where a circle crosses its lead-in: no tool can leave that material.
    Overlap,
}

/// How much it weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OvercutWeight {
    /// The contour is violated.
    Error,
    /// It may be: a look at the part decides.
    Warning,
    /// For information.
    Info,
}

impl OvercutKind {
    /// Name in JSON lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Narrow => "narrow",
            Self::Above => "above",
            Self::ContourEnd => "contour_end",
            Self::Entry => "entry",
            Self::Exit => "exit",
            Self::Overlap => "overlap",
        }
    }

    /// How much it weighs.
    pub fn weight(self) -> OvercutWeight {
        match self {
            Self::Narrow => OvercutWeight::Error,
            Self::Above | Self::ContourEnd | Self::Entry | Self::Exit => OvercutWeight::Warning,
            Self::Overlap => OvercutWeight::Info,
        }
    }
}

impl OvercutWeight {
    /// Name in JSON lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Info => "info",
        }
    }
}

impl fmt::Display for Overcut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { depth, radius, contour_line: line, .. } = self;
        match self.kind {
            OvercutKind::Narrow => {
                write!(f, "the tool of radius {radius} mm does not fit between this contour and that of line {line}")?;
            }
            OvercutKind::Above => {
                write!(
                    f,
                    "the tool of radius {radius} mm runs above the contour of line {line}, between both it does not fit"
                )?;
            }
            OvercutKind::ContourEnd => {
                write!(f, "the tool of radius {radius} mm runs into the open end of the contour in line {line}")?;
            }
            OvercutKind::Entry => write!(f, "the move onto the contour cuts the contour of line {line}")?,
            OvercutKind::Exit => write!(f, "the move off the contour cuts the contour of line {line}")?,
            OvercutKind::Overlap => {
                write!(f, "the contour runs over its own part of line {line}, which the tool cuts")?
            }
        }
        write!(f, ", {depth:.4} mm deep at")?;
        for (axis, letter) in AXIS_LETTERS.iter().enumerate().take(3) {
            if let Some(value) = self.programmed_point.get(axis) {
                write!(f, " {letter}{value:.3}")?;
            }
        }
        if !self.programmed_point.is_empty() {
            write!(f, " in the coordinates of the program")?;
        }
        if self.blocks > 1 { write!(f, ", in {} blocks", self.blocks) } else { Ok(()) }
    }
}
