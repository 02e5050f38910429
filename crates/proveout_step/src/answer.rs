//! The three files of the helper, read and checked against each other.
//!
//! ```text
//!  mesh.json    protocol, kernel, sha256 of the STEP file, units, loose faces
//!               solids: faces [first, count], volume_mm3, edge_samples
//!               faces: entity (which face of the file, from 0), tri [first, count]
//!               vertices, triangles: counts
//!  mesh.bin     f64 x,y,z of each vertex (mm) | u32 a,b,c of each triangle | u32 face of each triangle
//!  samples.bin  f64 x,y,z of the exact surface: four a triangle (middle, middles of ab, bc, ca), then
//!               `edge_samples` of each solid
//! ```
//!
//! All numbers are little endian.

use std::{io::ErrorKind, path::Path};

use proveout_geom::Point;
use proveout_input::{MAX_LENGTH_MM, read_regular_file};
use serde::Deserialize;

use crate::helper::PROTOCOL;

/// Exact points of each triangle.
pub(crate) const SAMPLES: usize = 4;
/// Most triangles of a file, as of any mesh file.
const MOST_TRIANGLES: usize = 20_000_000;
/// Most exact points of edges.
const MOST_EDGE_SAMPLES: usize = 3 * MOST_TRIANGLES;
/// Longest `mesh.json`.
const MOST_HEAD: u64 = 1 << 28;

/// What the helper found.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) head: Head,
    pub(crate) positions: Vec<Point>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Exact points: [`SAMPLES`] a triangle, then those of the edges.
    pub(crate) samples: Vec<Point>,
}

/// `mesh.json`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Head {
    #[serde(rename = "protocol")]
    _protocol: u64,
    pub(crate) kernel: String,
    pub(crate) sha256: String,
    pub(crate) units: Vec<String>,
    /// Faces of the file that belong to no solid, by entity.
    pub(crate) loose: Vec<i64>,
    pub(crate) solids: Vec<SolidHead>,
    pub(crate) faces: Vec<FaceHead>,
    vertices: usize,
    triangles: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SolidHead {
    /// First face and number of faces.
    pub(crate) faces: [usize; 2],
    pub(crate) volume_mm3: f64,
    /// Exact points of its edges.
    pub(crate) edge_samples: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FaceHead {
    /// Which face of the file it is, in the order of the text; below 0 where the helper does not know.
    pub(crate) entity: i64,
    /// First triangle and number of triangles.
    pub(crate) tri: [usize; 2],
}

#[derive(Deserialize)]
struct Version {
    protocol: Option<u64>,
}

impl Answer {
    /// Reads what the helper left in a folder.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(crate) fn read(folder: &Path) -> Result<Self, String> {
        let head = file(folder, "mesh.json", MOST_HEAD)?;
        let version: Version = serde_json::from_slice(&head).map_err(|e| format!("mesh.json: {e}"))?;
        if version.protocol != Some(PROTOCOL) {
            let spoken = version.protocol.map_or("no protocol".to_owned(), |p| format!("protocol {p}"));
            return Err(format!("it speaks {spoken}, this program reads protocol {PROTOCOL}"));
        }
        let head: Head = serde_json::from_slice(&head).map_err(|e| format!("mesh.json: {e}"))?;
        head.check()?;
        let (vertices, triangles) = (head.vertices, head.triangles);
        let of_edges = head.solids.iter().fold(0_usize, |sum, s| sum.saturating_add(s.edge_samples));
        if of_edges > MOST_EDGE_SAMPLES {
            return Err(format!("mesh.json: it has more than {MOST_EDGE_SAMPLES} points of edges"));
        }
        let points = SAMPLES * triangles + of_edges;
        let mesh = of_length(folder, "mesh.bin", 24 * vertices + 16 * triangles)?;
        let samples = of_length(folder, "samples.bin", 24 * points)?;
        let (positions, rest) = mesh.split_at_checked(24 * vertices).unwrap_or_default();
        let (corners, owners) = rest.split_at_checked(12 * triangles).unwrap_or_default();
        let triangles: Vec<[u32; 3]> = corners.chunks_exact(12).map(|c| [0, 4, 8].map(|at| whole(c, at))).collect();
        if let Some(wrong) = triangles.iter().flatten().find(|v| **v as usize >= vertices) {
            return Err(format!("mesh.bin: a triangle names vertex {wrong} of {vertices}"));
        }
        for (number, face) in head.faces.iter().enumerate() {
            let owned = owners.chunks_exact(4).skip(face.tri[0]).take(face.tri[1]);
            if owned.into_iter().any(|o| whole(o, 0) as usize != number) {
                return Err(format!("mesh.bin: the triangles of face {number} are those of another one in mesh.json"));
            }
        }
        let [positions, samples] =
            [("mesh.bin", positions), ("samples.bin", &samples)].map(|(name, b)| points_of(name, b));
        Ok(Self { positions: positions?, triangles, samples: samples?, head })
    }
}

impl Head {
    /// Solids and faces follow each other without a gap, and all have triangles.
    fn check(&self) -> Result<(), String> {
        if self.vertices > 3 * MOST_TRIANGLES || self.triangles > MOST_TRIANGLES {
            return Err(format!("mesh.json: it has more than {MOST_TRIANGLES} triangles"));
        }
        follow(self.solids.iter().map(|s| s.faces), self.faces.len(), "the faces of solid")?;
        follow(self.faces.iter().map(|f| f.tri), self.triangles, "the triangles of face")
    }
}

/// Each range begins where the one before ends, has a member, and the last ends at `all`.
fn follow(ranges: impl Iterator<Item = [usize; 2]>, all: usize, what: &str) -> Result<(), String> {
    let mut next = 0_usize;
    for (number, [first, count]) in ranges.enumerate() {
        if count == 0 {
            return Err(format!("mesh.json: {what} {number} are none"));
        }
        if first != next {
            return Err(format!("mesh.json: {what} {number} begin at {first} and not at {next}"));
        }
        next = next.saturating_add(count);
    }
    if next == all { Ok(()) } else { Err(format!("mesh.json: {what}s are {next} of {all}")) }
}

fn file(folder: &Path, name: &str, limit: u64) -> Result<Vec<u8>, String> {
    read_regular_file(&folder.join(name), limit).map_err(|e| match e.kind() {
        ErrorKind::NotFound => format!("it left no {name}"),
        _ => format!("{name}: {e}"),
    })
}

fn of_length(folder: &Path, name: &str, length: usize) -> Result<Vec<u8>, String> {
    let bytes = file(folder, name, length as u64)?;
    if bytes.len() == length {
        Ok(bytes)
    } else {
        Err(format!("{name} has {} bytes, and mesh.json announces {length}", bytes.len()))
    }
}

/// Four bytes as a number; the caller has chunks that are long enough.
fn whole(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(u32::MAX, u32::from_le_bytes)
}

fn points_of(name: &str, bytes: &[u8]) -> Result<Vec<Point>, String> {
    let number = |b: &[u8]| b.try_into().map_or(f64::NAN, f64::from_le_bytes);
    let mut points = Vec::with_capacity(bytes.len() / 24);
    for chunk in bytes.chunks_exact(24) {
        let mut parts = chunk.chunks_exact(8).map(number);
        let mut next = || parts.next().unwrap_or(f64::NAN);
        let point = Point::new(next(), next(), next());
        // NaN is beyond every limit, too.
        if !point.iter().all(|x| x.abs() <= MAX_LENGTH_MM) {
            return Err(format!(
                "{name}: a point lies at ({:e}, {:e}, {:e}) mm; the limit is {MAX_LENGTH_MM} mm",
                point.x, point.y, point.z
            ));
        }
        points.push(point);
    }
    Ok(points)
}
