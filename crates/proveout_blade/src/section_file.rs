//! Sections of a blade from a file.
//!
//! The file is CSV with a header line and one line a point; `#` begins a comment:
//!
//! ```text
//! section,part,x_mm,y_mm,z_mm
//! root,leading,0.0,-21.2,1.4
//! root,leading,0.0,-21.3,0.9
//! root,suction,0.0,-20.1,-3.2
//! ```
//!
//! Lines of one section follow each other in the order of the points round it; sections follow each other
//! along the blade. Each is closed: its first point is not repeated at the end (where it is, the repeated one
//! is left). `part` may be left out; with it every point is `leading`, `trailing`, `suction` or `pressure`,
//! and the points where an edge joins a side belong to the edge. Coordinates are in mm.

use proveout_geom::{Point, Vector};
use thiserror::Error;

/// Part of a section that a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionPart {
    /// Leading edge.
    Leading,
    /// Trailing edge.
    Trailing,
    /// Suction side.
    Suction,
    /// Pressure side.
    Pressure,
}

impl SectionPart {
    const NAMES: [(&'static str, Self); 4] = [
        ("leading", Self::Leading),
        ("trailing", Self::Trailing),
        ("suction", Self::Suction),
        ("pressure", Self::Pressure),
    ];
}

/// Points round one section.
#[derive(Clone, Debug, PartialEq)]
pub struct PointedSection {
    /// Its name in the file.
    pub name: String,
    /// Points in order, mm; the first one is not repeated.
    pub points: Vec<Point>,
    /// The part of each point; empty where the file names none.
    pub parts: Vec<SectionPart>,
}

/// Why a text holds no sections.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("line {line}: {message}")]
pub struct SectionFileError {
    /// Line, counted from 1.
    pub line: usize,
    /// What is wrong, and what to write.
    pub message: String,
}

/// Coordinates beyond this are a mistake of the unit, mm.
const FARTHEST_MM: f64 = 1e5;

/// Reads sections.
///
/// # Errors
/// A line is none of the format.
pub fn read_sections(text: &str) -> Result<Vec<PointedSection>, SectionFileError> {
    let wrong = |line: usize, message: String| SectionFileError { line, message };
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate().map(|(k, l)| (k + 1, l.trim()));
    let mut lines = lines.filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let (line, header) = lines.next().ok_or_else(|| wrong(1, "the file has no header line".into()))?;
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    let with_parts = match columns.as_slice() {
        ["section", "part", "x_mm", "y_mm", "z_mm"] => true,
        ["section", "x_mm", "y_mm", "z_mm"] => false,
        _ => {
            let help = "write `section,part,x_mm,y_mm,z_mm`, or the same without `part`";
            return Err(wrong(line, format!("the header is {header:?}; {help}")));
        }
    };
    let mut sections: Vec<PointedSection> = Vec::new();
    for (line, text) in lines {
        let cells: Vec<&str> = text.split(',').map(str::trim).collect();
        if cells.len() != columns.len() {
            return Err(wrong(line, format!("{} values under {} columns", cells.len(), columns.len())));
        }
        let name = cells[0];
        if name.is_empty() {
            return Err(wrong(line, "the section has no name".into()));
        }
        if sections.last().is_none_or(|s| s.name != name) {
            if sections.iter().any(|s| s.name == name) {
                return Err(wrong(
                    line,
                    format!("section {name} goes on after another one began; keep its lines together"),
                ));
            }
            sections.push(PointedSection { name: name.into(), points: Vec::new(), parts: Vec::new() });
        }
        let mut place = [0.0; 3];
        for (value, cell) in place.iter_mut().zip(&cells[cells.len() - 3..]) {
            *value = cell.parse().ok().filter(|v: &f64| v.abs() <= FARTHEST_MM).ok_or_else(|| {
                wrong(line, format!("{cell:?} is not a coordinate; write mm with a point, within 100 m"))
            })?;
        }
        let Some(section) = sections.last_mut() else { continue };
        section.points.push(Point::from(Vector::from(place)));
        if with_parts {
            let part = SectionPart::NAMES.iter().find(|(n, _)| *n == cells[1]);
            let Some((_, part)) = part else {
                let names = SectionPart::NAMES.map(|(n, _)| n).join(", ");
                return Err(wrong(line, format!("{:?} is not a part; write one of {names}", cells[1])));
            };
            section.parts.push(*part);
        }
    }
    for section in &mut sections {
        if section.points.len() > 1 && section.points.first() == section.points.last() {
            section.points.pop();
            section.parts.pop();
        }
    }
    Ok(sections)
}
