//! SDF, the surface data file of ISO 25178-71:2017.
//!
//! ```text
//!   text                                       binary, little end first
//!
//!   aISO-1.0                                   bISO-1.0  manufacturer 10  dates 12 + 12
//!   ManufacID   = Proveout        header       points u16  profiles u16 (u32 in ISO-2.0)
//!   NumPoints   = 801                          x, y, z scale f64   z resolution f64
//!   Xscale      = 5e-06   (m)                  compression u8   data type u8   check type u8
//!   *                                          heights
//!   heights, BAD where missing
//!   *
//!   trailer *
//! ```
//!
//! Height in meters = number x z scale. A missing height is the smallest number of its type.

use super::{FileFault, HOLE_HELP, Lattice, Measured, MeasuredFile, TextureFileError, count, measured};

/// Text or binary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdfForm {
    /// `aISO-1.0`
    Text,
    /// `bISO-1.0`
    Binary,
}

const FORMAT: &str = "SDF (ISO 25178-71)";
const ANEW: &str = "write the file again from the measuring program, uncompressed";
/// Meters to mm.
const MM: f64 = 1e3;
/// Heights are written in um: this many meters.
const WRITTEN: f64 = 1e-6;

/// Whether the bytes begin as SDF does.
pub(super) fn is_sdf(bytes: &[u8]) -> bool {
    [&b"aISO-"[..], b"bISO-", b"aNPL-"].iter().any(|magic| bytes.trim_ascii_start().starts_with(magic))
}

pub(super) fn read(bytes: &[u8]) -> Result<MeasuredFile, FileFault> {
    let measured = match bytes {
        [b'b', ..] => binary(bytes)?,
        _ => text(bytes)?,
    };
    Ok(MeasuredFile { measured, format: FORMAT, remarks: Vec::new() })
}

#[derive(Clone, Debug, Default)]
struct Header {
    points: usize,
    profiles: usize,
    x: f64,
    y: f64,
    z: f64,
    compression: u8,
    check: u8,
}

impl Header {
    fn hold(&self) -> Result<usize, FileFault> {
        if self.compression != 0 {
            return Err(FileFault::new(format!("compression {} is not read; 0 is", self.compression), ANEW));
        }
        if self.check != 0 {
            return Err(FileFault::new(format!("check type {} is not read; 0 is", self.check), ANEW));
        }
        if !(self.z.is_finite() && self.z != 0.0) {
            return Err(FileFault::new(format!("a z scale of {} makes no heights", self.z), ANEW));
        }
        let n = count(self.points, self.profiles)?;
        for (axis, scale, used) in [("x", self.x, self.points > 1), ("y", self.y, self.profiles > 1)] {
            if used && !(scale.is_finite() && scale > 0.0 && (scale * MM).is_normal()) {
                return Err(FileFault::new(
                    format!("a {axis} scale of {scale} m is not a spacing"),
                    "the scales of x and y are positive lengths in m",
                ));
            }
        }
        if self.points < 2 {
            return Err(FileFault::new(format!("{} point a profile; 2 are needed", self.points), ANEW));
        }
        Ok(n)
    }

    fn measured(&self, heights: Vec<f64>) -> Result<Measured, FileFault> {
        measured(self.points, self.profiles, [self.x * MM, self.y * MM], heights)
    }
}

fn text(bytes: &[u8]) -> Result<Measured, FileFault> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().enumerate().map(|(k, l)| (k + 1, l.trim()));
    let mut header = Header::default();
    let mut seen: Vec<String> = Vec::new();
    let mut ended = false;
    for (k, line) in lines.by_ref() {
        if line == "*" {
            ended = true;
            break;
        }
        if line.is_empty() || seen.is_empty() && is_sdf(line.as_bytes()) {
            continue;
        }
        let Some((name, value)) = line.split_once('=') else {
            return Err(FileFault::at(
                k,
                format!("{:?} is not a line of the header", shown(line)),
                "write NAME = VALUE there",
            ));
        };
        let (name, value) = (name.trim().to_ascii_lowercase(), value.trim());
        let number = || {
            value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
                FileFault::at(
                    k,
                    format!("{} of {name} is not a number", shown(value)),
                    "write a number with a decimal point",
                )
            })
        };
        let whole = |most: f64| {
            let v = number()?;
            if v.fract() == 0.0 && (0.0..=most).contains(&v) {
                Ok(v)
            } else {
                Err(FileFault::at(k, format!("{name} = {} is not a whole number from 0 to {most}", shown(value)), ANEW))
            }
        };
        match name.as_str() {
            "numpoints" => header.points = whole(4_294_967_295.0)? as usize,
            "numprofiles" => header.profiles = whole(4_294_967_295.0)? as usize,
            "xscale" => header.x = number()?,
            "yscale" => header.y = number()?,
            "zscale" => header.z = number()?,
            "compression" => header.compression = whole(255.0)? as u8,
            "checktype" => header.check = whole(255.0)? as u8,
            "datatype" => {
                whole(7.0)?;
            }
            "manufacid" | "createdate" | "moddate" | "zresolution" => {}
            _ => return Err(FileFault::at(k, format!("unknown key {:?} in the header", shown(&name)), ANEW)),
        }
        seen.push(name);
    }
    if !ended {
        return Err(FileFault::new("the header has no end: a line with * alone", ANEW));
    }
    for key in ["numpoints", "numprofiles", "xscale", "zscale"] {
        if !seen.iter().any(|s| s == key) {
            return Err(FileFault::new(format!("the header has no {key}"), ANEW));
        }
    }
    let n = header.hold()?;
    let mut heights = Vec::with_capacity(n);
    let mut closed = false;
    for (k, line) in lines {
        if line.starts_with('*') {
            closed = true;
            break;
        }
        for word in line.split_ascii_whitespace() {
            if heights.len() == n {
                return Err(FileFault::at(
                    k,
                    format!("more heights than {} x {}", header.points, header.profiles),
                    ANEW,
                ));
            }
            if word.eq_ignore_ascii_case("bad") {
                return Err(FileFault::at(
                    k,
                    format!("height {} is BAD: it was not measured", heights.len() + 1),
                    HOLE_HELP,
                ));
            }
            match word.parse::<f64>() {
                Ok(z) if z.is_finite() => heights.push(z * header.z * MM),
                _ => {
                    return Err(FileFault::at(
                        k,
                        format!("height {} is {:?}: no number", heights.len() + 1, shown(word)),
                        "write a number with a decimal point, or BAD, there",
                    ));
                }
            }
        }
    }
    if heights.len() != n {
        let after = if closed { "" } else { ", and no * after them" };
        return Err(FileFault::new(
            format!(
                "{} heights for {} x {}{after}: the file is cut off",
                heights.len(),
                header.points,
                header.profiles
            ),
            ANEW,
        ));
    }
    header.measured(heights)
}

/// A value for an error text.
pub(super) fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Bytes from the front.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*head)
    }

    fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    fn header(&mut self, wide: bool) -> Option<(Header, u8)> {
        self.take::<34>()?; // manufacturer, two dates
        let number = |b: &mut Self| {
            if wide {
                b.take().map(|n| u32::from_le_bytes(n) as usize)
            } else {
                b.take().map(|n| u16::from_le_bytes(n).into())
            }
        };
        let (points, profiles) = (number(self)?, number(self)?);
        let (x, y, z, _resolution) = (self.f64()?, self.f64()?, self.f64()?, self.f64()?);
        let [compression, kind, check] = self.take()?;
        Some((Header { points, profiles, x, y, z, compression, check }, kind))
    }
}

fn binary(bytes: &[u8]) -> Result<Measured, FileFault> {
    let mut rest = Bytes(bytes);
    let wide = match rest.take::<8>() {
        Some(magic) if &magic == b"bISO-1.0" => false,
        Some(magic) if &magic == b"bISO-2.0" => true,
        other => {
            let begin = String::from_utf8_lossy(other.as_ref().map_or(bytes, |m| m)).into_owned();
            return Err(FileFault::new(format!("version {begin:?} is not read; bISO-1.0 and bISO-2.0 are"), ANEW));
        }
    };
    let Some((header, kind)) = rest.header(wide) else {
        return Err(FileFault::new(format!("{} bytes are shorter than the header", bytes.len()), ANEW));
    };
    let n = header.hold()?;
    type Number = (usize, fn(&[u8]) -> f64, f64);
    fn fixed<const N: usize>(b: &[u8]) -> [u8; N] {
        b.try_into().unwrap_or([0; N])
    }
    // Bytes, value, the number that marks a missing height.
    let (size, value, missing): Number = match kind {
        0 => (1, |b| f64::from(fixed::<1>(b)[0]), f64::NAN),
        1 => (2, |b| f64::from(u16::from_le_bytes(fixed(b))), f64::NAN),
        2 => (4, |b| f64::from(u32::from_le_bytes(fixed(b))), f64::NAN),
        3 => (4, |b| f64::from(f32::from_le_bytes(fixed(b))), f64::from(f32::MIN)),
        4 => (1, |b| f64::from(i8::from_le_bytes(fixed(b))), f64::from(i8::MIN)),
        5 => (2, |b| f64::from(i16::from_le_bytes(fixed(b))), f64::from(i16::MIN)),
        6 => (4, |b| f64::from(i32::from_le_bytes(fixed(b))), f64::from(i32::MIN)),
        7 => (8, |b| f64::from_le_bytes(fixed(b)), f64::MIN),
        other => return Err(FileFault::new(format!("data type {other} is not of the standard; 0 to 7 are"), ANEW)),
    };
    let Some(data) = rest.0.get(..n * size) else {
        return Err(FileFault::new(
            format!(
                "{} bytes of heights for {} x {} of {size} bytes: the file is cut off",
                rest.0.len(),
                header.points,
                header.profiles
            ),
            ANEW,
        ));
    };
    let mut heights = Vec::with_capacity(n);
    for (k, b) in data.chunks_exact(size).enumerate() {
        let z = value(b);
        if z == missing || !z.is_finite() {
            return Err(FileFault::new(
                format!(
                    "height {} (point {} of profile {}) is missing",
                    k + 1,
                    k % header.points + 1,
                    k / header.points + 1
                ),
                HOLE_HELP,
            ));
        }
        heights.push(z * header.z * MM);
    }
    header.measured(heights)
}

/// The bytes of an SDF file.
///
/// # Errors
/// More than 65,535 points along a direction, which the format cannot say.
pub fn sdf_bytes<'a>(lattice: impl Into<Lattice<'a>>, form: SdfForm) -> Result<Vec<u8>, TextureFileError> {
    bytes(&lattice.into(), form).map_err(|f| TextureFileError {
        path: "SDF".into(),
        line: 0,
        message: f.message,
        help: f.help.to_owned(),
    })
}

pub(super) fn bytes(lattice: &Lattice<'_>, form: SdfForm) -> Result<Vec<u8>, FileFault> {
    let (Ok(points), Ok(profiles)) = (u16::try_from(lattice.columns), u16::try_from(lattice.rows)) else {
        return Err(FileFault::new(
            format!("{} x {} points; SDF holds 65535 along a direction at most", lattice.columns, lattice.rows),
            "write X3P, or a smaller patch",
        ));
    };
    let (x, y) = (lattice.step_x / MM, lattice.step_y / MM);
    // An unknown date is twelve zeros, an unknown resolution -1.
    let (date, resolution) = ("000000000000", -1.0_f64);
    let written = |z: &f64| z / MM / WRITTEN;
    Ok(match form {
        SdfForm::Text => {
            let mut text = format!(
                "aISO-1.0\r\nManufacID = Proveout\r\nCreateDate = {date}\r\nModDate = {date}\r\nNumPoints = {points}\r\n\
                 NumProfiles = {profiles}\r\nXscale = {x:e}\r\nYscale = {y:e}\r\nZscale = {WRITTEN:e}\r\nZresolution = {resolution}\r\n\
                 Compression = 0\r\nDataType = 7\r\nCheckType = 0\r\n*\r\n"
            );
            for row in lattice.heights.chunks(8) {
                let row: Vec<String> = row.iter().map(|z| format!("{:e}", written(z))).collect();
                text += &row.join(" ");
                text += "\r\n";
            }
            text += "*\r\n*\r\n";
            text.into_bytes()
        }
        SdfForm::Binary => {
            let mut out = Vec::with_capacity(81 + 8 * lattice.heights.len());
            out.extend_from_slice(b"bISO-1.0Proveout  ");
            out.extend_from_slice(date.as_bytes());
            out.extend_from_slice(date.as_bytes());
            out.extend_from_slice(&points.to_le_bytes());
            out.extend_from_slice(&profiles.to_le_bytes());
            for v in [x, y, WRITTEN, resolution] {
                out.extend_from_slice(&v.to_le_bytes());
            }
            out.extend_from_slice(&[0, 7, 0]);
            for z in lattice.heights {
                out.extend_from_slice(&written(z).to_le_bytes());
            }
            out
        }
    })
}
