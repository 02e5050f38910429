//! X3P, the archive of ISO 25178-72:2017 (openGPS): `main.xml` with axes and counts, files with the
//! heights, checksums.
//!
//! ```text
//!   main.xml             Record1: Revision, FeatureType PRF or SUR, Axes CX CY CZ (type, data type,
//!                        increment, offset)
//!                        Record3: MatrixDimension SizeX SizeY SizeZ; DataLink with MD5, or DataList of Datum
//!                        Record4: ChecksumFile
//!   bindata/data.bin     heights, x fastest, little end first
//!   bindata/valid.bin    one bit a height, lowest first: measured (whole numbers only)
//!   md5checksum.hex      checksum of main.xml
//! ```
//!
//! All lengths are m; height = offset + increment x number.

use roxmltree::Node;

use super::{
    FileFault, HOLE_HELP, Lattice, MeasuredFile, TextureFileError, count, md5, measured,
    sdf::shown,
    xml::{self, child, text_of},
    zip::{Archive, pack},
};

const FORMAT: &str = "X3P (ISO 25178-72)";
const ANEW: &str = "write the file again from the measuring program";
/// Meters to mm.
const MM: f64 = 1e3;
/// Most bytes of the text.
const MOST_XML: usize = 64 << 20;
const DATA: &str = "bindata/data.bin";

pub(super) fn read(bytes: &[u8]) -> Result<MeasuredFile, FileFault> {
    let archive = Archive::open(bytes)?;
    let xml = archive.read("main.xml", MOST_XML)?.ok_or_else(|| FileFault::new("the archive has no main.xml", ANEW))?;
    let mut remarks = Vec::new();
    match archive.read("md5checksum.hex", 4096)? {
        None => remarks.push("the file has no md5checksum.hex".to_owned()),
        Some(told) => {
            let told = String::from_utf8_lossy(&told);
            compare(&xml, told.split_whitespace().next().unwrap_or_default(), "main.xml")?;
        }
    }
    let text = String::from_utf8_lossy(&xml);
    let document = xml::parse(&text)?;
    let root = document.root_element();
    let record = |name: &str| child(root, name).ok_or_else(|| FileFault::new(format!("main.xml has no {name}"), ANEW));
    let (axes, data) = (record("Record1")?, record("Record3")?);
    let kind = text_of(axes, &["FeatureType"]).unwrap_or_default();
    if !["PRF", "SUR"].contains(&kind.as_str()) {
        return Err(FileFault::new(
            format!("a feature of type {:?} is not read; PRF and SUR are", shown(&kind)),
            "write the file as a grid of heights",
        ));
    }
    let matrix = child(data, "MatrixDimension").ok_or_else(|| {
        FileFault::new(
            "Record3 has no MatrixDimension: a list of points is not a grid",
            "write the file as a grid of heights",
        )
    })?;
    let size = |name: &str| {
        let told = text_of(matrix, &[name]).unwrap_or_default();
        told.parse::<usize>().ok().filter(|n| *n > 0).ok_or_else(|| {
            FileFault::new(format!("{name} is {:?}; a whole number from 1 is expected", shown(&told)), ANEW)
        })
    };
    let (columns, rows, layers) = (size("SizeX")?, size("SizeY")?, size("SizeZ")?);
    if layers != 1 {
        return Err(FileFault::new(format!("{layers} layers; one is read"), "write one layer"));
    }
    if columns < 2 {
        return Err(FileFault::new(format!("{columns} x {rows} heights; 2 along x are needed"), ANEW));
    }
    let n = count(columns, rows)?;
    let axes = child(axes, "Axes").ok_or_else(|| FileFault::new("Record1 has no Axes", ANEW))?;
    let steps = [step(axes, "CX", true)?, step(axes, "CY", rows > 1)?];
    let z = child(axes, "CZ").ok_or_else(|| FileFault::new("the axis CZ is missing", ANEW))?;
    let kind = text_of(z, &["AxisType"]).unwrap_or_default();
    if kind != "A" {
        return Err(FileFault::new(
            format!("axis CZ is of type {:?}; A, absolute heights, is read", shown(&kind)),
            ANEW,
        ));
    }
    let (increment, offset) = (number(z, "CZ", "Increment", 1.0)?, number(z, "CZ", "Offset", 0.0)?);
    let values = match (child(data, "DataLink"), child(data, "DataList")) {
        (Some(link), _) => linked(&archive, link, &text_of(z, &["DataType"]).unwrap_or_default(), n)?,
        (None, Some(list)) => listed(list, n)?,
        (None, None) => {
            return Err(FileFault::new("Record3 has neither DataLink nor DataList: there are no heights", ANEW));
        }
    };
    let mut heights = Vec::with_capacity(n);
    for (k, value) in values.into_iter().enumerate() {
        let height = (offset + increment * value) * MM;
        if !height.is_finite() {
            return Err(FileFault::new(
                format!("height {} (column {}, row {}) is missing", k + 1, k % columns + 1, k / columns + 1),
                HOLE_HELP,
            ));
        }
        heights.push(height);
    }
    Ok(MeasuredFile { measured: measured(columns, rows, steps, heights)?, format: FORMAT, remarks })
}

fn compare(content: &[u8], told: &str, what: &str) -> Result<(), FileFault> {
    let is = md5::hex(content);
    if told.eq_ignore_ascii_case(&is) {
        return Ok(());
    }
    Err(FileFault::new(
        format!("the checksum of {what} is {is} and not {:?}: the file was changed or damaged", shown(told)),
        "fetch the file again from where it was measured",
    ))
}

fn number(axis: Node<'_, '_>, name: &str, key: &str, default: f64) -> Result<f64, FileFault> {
    match text_of(axis, &[key]).as_deref() {
        None | Some("") => Ok(default),
        Some(told) => told
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite())
            .ok_or_else(|| FileFault::new(format!("{key} of axis {name} is {:?}: no number", shown(told)), ANEW)),
    }
}

/// Spacing along an axis, mm.
fn step(axes: Node<'_, '_>, name: &str, used: bool) -> Result<f64, FileFault> {
    if !used {
        return Ok(0.0);
    }
    let axis = child(axes, name).ok_or_else(|| FileFault::new(format!("the axis {name} is missing"), ANEW))?;
    let kind = text_of(axis, &["AxisType"]).unwrap_or_default();
    if kind != "I" {
        return Err(FileFault::new(
            format!("axis {name} is of type {:?}; I, equal steps, is read", shown(&kind)),
            "write the heights at equal steps",
        ));
    }
    let step = number(axis, name, "Increment", 0.0)? * MM;
    if step.is_normal() && step > 0.0 {
        Ok(step)
    } else {
        Err(FileFault::new(
            format!("an increment of {step} mm along {name} is not a spacing"),
            "increments are positive lengths in m",
        ))
    }
}

/// Numbers in a file of the archive.
fn linked(archive: &Archive<'_>, link: Node<'_, '_>, kind: &str, n: usize) -> Result<Vec<f64>, FileFault> {
    let size = match kind {
        "I" => 2,
        "L" | "F" => 4,
        "D" => 8,
        other => return Err(FileFault::new(format!("data type {:?}; I, L, F and D are read", shown(other)), ANEW)),
    };
    let file = |key: &str, bytes: usize| {
        let Some(path) = text_of(link, &[key]).filter(|p| !p.is_empty()) else { return Ok(None) };
        let content = archive.read(&path, bytes)?;
        let content = content.ok_or_else(|| FileFault::new(format!("the archive has no {:?}", shown(&path)), ANEW))?;
        if content.len() == bytes {
            Ok(Some(content))
        } else {
            Err(FileFault::new(format!("{:?} has {} bytes instead of {bytes}", shown(&path), content.len()), ANEW))
        }
    };
    let content =
        file("PointDataLink", n * size)?.ok_or_else(|| FileFault::new("DataLink names no PointDataLink", ANEW))?;
    if let Some(told) = text_of(link, &["MD5ChecksumPointData"]).filter(|t| !t.is_empty()) {
        compare(&content, &told, "the heights")?;
    }
    if let Some(valid) = file("ValidPointsLink", n.div_ceil(8))? {
        if let Some(told) = text_of(link, &["MD5ChecksumValidPoints"]).filter(|t| !t.is_empty()) {
            compare(&valid, &told, "the measured points")?;
        }
        if let Some(k) = (0..n).find(|k| valid[k / 8] >> (k % 8) & 1 == 0) {
            return Err(FileFault::new(format!("height {} was not measured", k + 1), HOLE_HELP));
        }
    }
    fn fixed<const N: usize>(b: &[u8]) -> [u8; N] {
        b.try_into().unwrap_or([0; N])
    }
    let value: fn(&[u8]) -> f64 = match kind {
        "I" => |b| f64::from(i16::from_le_bytes(fixed(b))),
        "L" => |b| f64::from(i32::from_le_bytes(fixed(b))),
        "F" => |b| f64::from(f32::from_le_bytes(fixed(b))),
        _ => |b| f64::from_le_bytes(fixed(b)),
    };
    Ok(content.chunks_exact(size).map(value).collect())
}

/// Numbers in the text: the last of those of a datum is the height.
fn listed(list: Node<'_, '_>, n: usize) -> Result<Vec<f64>, FileFault> {
    let data: Vec<Node<'_, '_>> = list.children().filter(|c| c.tag_name().name() == "Datum").collect();
    if data.len() != n {
        return Err(FileFault::new(format!("{} Datum in place of {n}", data.len()), ANEW));
    }
    data.iter()
        .enumerate()
        .map(|(k, datum)| {
            let text = xml::text(*datum);
            let told = text.rsplit(';').next().unwrap_or_default().trim();
            if told.is_empty() {
                return Err(FileFault::new(format!("height {} was not measured", k + 1), HOLE_HELP));
            }
            told.parse::<f64>()
                .map_err(|_ignored| FileFault::new(format!("height {} is {:?}: no number", k + 1, shown(told)), ANEW))
        })
        .collect()
}

/// The bytes of an X3P file.
///
/// # Errors
/// More than 4 GiB.
pub fn x3p_bytes<'a>(lattice: impl Into<Lattice<'a>>) -> Result<Vec<u8>, TextureFileError> {
    bytes(&lattice.into()).map_err(|f| TextureFileError {
        path: "X3P".into(),
        line: 0,
        message: f.message,
        help: f.help.to_owned(),
    })
}

pub(super) fn bytes(lattice: &Lattice<'_>) -> Result<Vec<u8>, FileFault> {
    let data: Vec<u8> = lattice.heights.iter().flat_map(|z| (z / MM).to_le_bytes()).collect();
    let axis = |name: &str, kind: &str, increment: f64| {
        format!(
            "      <{name}>\n        <AxisType>{kind}</AxisType>\n        <DataType>D</DataType>\n        \
             <Increment>{increment:e}</Increment>\n        <Offset>0</Offset>\n      </{name}>\n"
        )
    };
    let (feature, y) = if lattice.rows == 1 { ("PRF", 1.0) } else { ("SUR", lattice.step_y / MM) };
    let xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\"?>\n\
         <p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"http://www.opengps.eu/2008/ISO5436_2 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd\">\n  \
         <Record1>\n    <Revision>ISO5436 - 2000</Revision>\n    <FeatureType>{feature}</FeatureType>\n    <Axes>\n{}{}{}    </Axes>\n  \
         </Record1>\n  <Record3>\n    <MatrixDimension>\n      <SizeX>{}</SizeX>\n      <SizeY>{}</SizeY>\n      <SizeZ>1</SizeZ>\n    \
         </MatrixDimension>\n    <DataLink>\n      <PointDataLink>{DATA}</PointDataLink>\n      \
         <MD5ChecksumPointData>{}</MD5ChecksumPointData>\n    </DataLink>\n  </Record3>\n  <Record4>\n    \
         <ChecksumFile>md5checksum.hex</ChecksumFile>\n  </Record4>\n</p:ISO5436_2>\n",
        axis("CX", "I", lattice.step_x / MM),
        axis("CY", "I", y),
        axis("CZ", "A", 1.0),
        lattice.columns,
        lattice.rows,
        md5::hex(&data).to_uppercase(),
    );
    let checksum = format!("{} *main.xml\n", md5::hex(xml.as_bytes()));
    pack(&[("main.xml", xml.as_bytes()), (DATA, &data), ("md5checksum.hex", checksum.as_bytes())])
}
