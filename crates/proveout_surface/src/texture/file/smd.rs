//! SMD, the softgauge of ISO 5436-2:2012 (type F1).
//!
//! ```text
//!   ISO 5436 - 2000 NUL name CRLF                     1: header
//!   PRF NUL 0 NUL ... CRLF
//!   CX NUL I NUL 8001 NUL mm NUL 1.0 NUL D NUL 0.0005 CRLF  axis, type, points, unit, scale, data type, step
//!   CZ NUL A NUL 8001 NUL um NUL 1.0 NUL D CRLF
//!   ETX CRLF
//!   DATE ... CRLF ETX CRLF                            2: about the data
//!   heights, one a line CRLF ETX CRLF                 3
//!   checksum CRLF ETX SUB                             4: sum of all bytes up to the third end of record
//! ```
//!
//! Fields are parted by NUL or blanks. Printed software takes the sum modulo 65535 or 65536; either is taken
//! for right.

use super::{FileFault, HOLE_HELP, MeasuredFile, count, measured, sdf::shown};

/// ETX.
pub(super) const END_OF_RECORD: u8 = 3;
const FORMAT: &str = "SMD (ISO 5436-2)";
const ANEW: &str = "write the file again: header with CX and CZ, remarks and heights, each closed by ETX";
/// Millimeters in a meter, a micrometer and a nanometer.
const MM_PER_M: f64 = 1e3;
const MM_PER_UM: f64 = 1e-3;
const MM_PER_NM: f64 = 1e-6;
/// Points of an axis that are believed at most.
const MOST_POINTS: f64 = 1e9;

struct SmdAxis {
    line: usize,
    kind: String,
    points: usize,
    unit: f64,
    scale: f64,
    rest: Vec<String>,
}

/// Factor to mm.
fn unit(name: &str) -> Option<f64> {
    match name.to_ascii_lowercase().as_str() {
        "m" => Some(MM_PER_M),
        "mm" => Some(1.0),
        "um" | "µm" => Some(MM_PER_UM),
        "nm" => Some(MM_PER_NM),
        _ => None,
    }
}

fn number(line: usize, what: &str, text: &str) -> Result<f64, FileFault> {
    text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
        FileFault::at(line, format!("{what} is {:?}: no number", shown(text)), "write a number with a decimal point")
    })
}

fn axis(line: usize, fields: &[&str]) -> Result<SmdAxis, FileFault> {
    let [name, kind, points, unit_name, scale, rest @ ..] = fields else {
        return Err(FileFault::at(
            line,
            format!("axis with {} fields; at least 5 are expected", fields.len()),
            "an axis is NAME TYPE POINTS UNIT SCALE DATATYPE, and for equal steps the step",
        ));
    };
    let points =
        points.parse::<f64>().ok().filter(|n| n.fract() == 0.0 && (2.0..=MOST_POINTS).contains(n)).ok_or_else(|| {
            FileFault::at(
                line,
                format!("{:?} points on axis {name}; a whole number from 2 is expected", shown(points)),
                ANEW,
            )
        })? as usize;
    let unit = unit(unit_name).ok_or_else(|| {
        FileFault::at(
            line,
            format!("unit {:?} of axis {name} is not known", shown(unit_name)),
            "m, mm, um and nm are read",
        )
    })?;
    Ok(SmdAxis {
        line,
        kind: (*kind).to_ascii_uppercase(),
        points,
        unit,
        scale: number(line, "the scale of the axis", scale)?,
        rest: rest.iter().map(|s| (*s).to_owned()).collect(),
    })
}

pub(super) fn read(bytes: &[u8]) -> Result<MeasuredFile, FileFault> {
    let ends: Vec<usize> =
        bytes.iter().enumerate().filter(|(_, b)| **b == END_OF_RECORD).map(|(k, _)| k).take(4).collect();
    let [first, second, third, ..] = ends[..] else {
        return Err(FileFault::new(format!("{} ends of record (ETX); 3 are expected", ends.len()), ANEW));
    };
    let (mut cx, mut cz) = (None, None);
    let header = latin(&bytes[..first]);
    for (k, line) in header.split('\n').enumerate() {
        let fields: Vec<&str> =
            line.split(|c: char| c == '\0' || c.is_whitespace()).filter(|f| !f.is_empty()).collect();
        match fields.first().map(|f| f.to_ascii_uppercase()).as_deref() {
            Some("CX") => cx = Some(axis(k + 1, &fields)?),
            Some("CZ") => cz = Some(axis(k + 1, &fields)?),
            Some("CY") => {
                return Err(FileFault::at(
                    k + 1,
                    "an axis CY makes an area; profiles are read",
                    "take SDF or X3P for areas",
                ));
            }
            _ => {}
        }
    }
    let (Some(x), Some(z)) = (cx, cz) else {
        return Err(FileFault::new("the header does not have both axes CX and CZ", ANEW));
    };
    if x.kind != "I" {
        return Err(FileFault::at(
            x.line,
            format!("axis CX is of type {:?}; I, equal steps, is read", shown(&x.kind)),
            "write the profile at equal steps",
        ));
    }
    if z.kind != "A" {
        return Err(FileFault::at(
            z.line,
            format!("axis CZ is of type {:?}; A, absolute heights, is read", shown(&z.kind)),
            "write the heights as they are",
        ));
    }
    // Data type, then the step.
    let step = x.rest.get(1).ok_or_else(|| FileFault::at(x.line, "axis CX states no step", ANEW))?;
    let step = number(x.line, "the step of CX", step)? * x.scale * x.unit;
    if !(step.is_normal() && step > 0.0) {
        return Err(FileFault::at(
            x.line,
            format!("a step of {step} mm is not a spacing"),
            "step times scale is a positive length",
        ));
    }
    let factor = z.scale * z.unit;
    if !(factor.is_normal()) {
        return Err(FileFault::at(z.line, format!("a scale of {factor} mm makes no heights"), ANEW));
    }
    if x.points != z.points {
        return Err(FileFault::at(z.line, format!("{} places and {} heights", x.points, z.points), ANEW));
    }
    let n = count(x.points, 1)?;
    let mut heights = Vec::with_capacity(n);
    let lines_before = bytes[..=second].iter().filter(|b| **b == b'\n').count();
    for (k, line) in latin(&bytes[second + 1..third]).split('\n').enumerate() {
        let at = lines_before + k + 1;
        let mut fields = line.split(|c: char| c == '\0' || c.is_whitespace()).filter(|f| !f.is_empty());
        let Some(field) = fields.next() else { continue };
        if fields.next().is_some() {
            return Err(FileFault::at(at, "two values on a line of heights; one is read", ANEW));
        }
        if heights.len() == n {
            return Err(FileFault::at(at, format!("more heights than the {n} of the header"), ANEW));
        }
        if ["bad", "nan", "inf", "-inf"].contains(&field.to_ascii_lowercase().as_str()) {
            return Err(FileFault::at(
                at,
                format!("height {} is {field}: it was not measured", heights.len() + 1),
                HOLE_HELP,
            ));
        }
        heights.push(number(at, "a height", field)? * factor);
    }
    if heights.len() != n {
        return Err(FileFault::new(format!("{} heights, {n} in the header: the file is cut off", heights.len()), ANEW));
    }
    Ok(MeasuredFile {
        measured: measured(n, 1, [step, 0.0], heights)?,
        format: FORMAT,
        remarks: checksum(bytes, third, ends.get(3).copied()).into_iter().collect(),
    })
}

/// What is wrong with the checksum.
fn checksum(bytes: &[u8], third: usize, fourth: Option<usize>) -> Option<String> {
    let Some(fourth) = fourth else { return Some("the file has no checksum".to_owned()) };
    let end = bytes[third..fourth].iter().position(|b| *b == b'\n').map_or(third, |k| third + k);
    let told = latin(&bytes[end + 1..fourth]);
    let told = told.trim_matches(|c: char| c == '\0' || c.is_whitespace());
    let sum: u64 = bytes[..=end].iter().map(|b| u64::from(*b)).sum();
    let right = [sum % 65_535, sum % 65_536];
    match told.parse::<u64>() {
        Ok(told) if right.contains(&told) => None,
        _ => Some(format!("the checksum is {} and not {:?}: the file was changed or damaged", right[0], shown(told))),
    }
}

fn latin(bytes: &[u8]) -> String {
    bytes.iter().map(|b| char::from(*b)).collect()
}
