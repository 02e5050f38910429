//! STL, both forms. The length of the file identifies the binary form, since both forms may begin with
//! `solid`.

use std::path::Path;

use super::{MAX_TRIANGLES, Mesh, MeshFileError, content, number};
use crate::{Point, TriMesh};

/// Bytes before the first facet of a binary file: 80 of free text and the number of facets.
const HEADER: usize = 84;
/// Bytes of a facet: normal, three corners, two bytes of attributes.
const FACET: usize = 50;

/// Reads either form. Corners are joined by the caller.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshFileError> {
    if let Some(count) = bytes.get(80..HEADER) {
        let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize;
        if count.checked_mul(FACET).is_some_and(|n| n == bytes.len() - HEADER) {
            return binary(path, &bytes[HEADER..]);
        }
        if !bytes.trim_ascii_start().starts_with(b"solid") {
            let held = (bytes.len() - HEADER) / FACET;
            return Err(content(path, format!("the header announces {count} facets, and {held} are there")));
        }
    }
    let text = std::str::from_utf8(bytes).map_err(|_e| content(path, "is neither a binary STL nor text"))?;
    ascii(path, text)
}

fn binary(path: &Path, facets: &[u8]) -> Result<TriMesh, MeshFileError> {
    let mut mesh = Mesh::default();
    for facet in facets.chunks_exact(FACET) {
        let real = |at: usize| f64::from(f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]));
        // The normal at 0 to 11 says nothing that the corners do not say.
        let corner = |at: usize| Point::new(real(at), real(at + 4), real(at + 8));
        mesh.facet(path, [corner(12), corner(24), corner(36)])?;
    }
    Ok(mesh.0)
}

/// `solid` name, facets of three `vertex` lines each, `endsolid`; several solids may follow each other.
fn ascii(path: &Path, text: &str) -> Result<TriMesh, MeshFileError> {
    let mut mesh = Mesh::default();
    let mut corners = Vec::with_capacity(3);
    let mut begun = false;
    for (line, words) in text.lines().enumerate() {
        let place = |what: String| content(path, format!("line {}: {what}", line + 1));
        let mut words = words.split_ascii_whitespace();
        let Some(word) = words.next() else { continue };
        match word.to_ascii_lowercase().as_str() {
            "solid" => begun = true,
            "vertex" if begun => {
                let mut xyz = [0.0; 3];
                for x in &mut xyz {
                    let word = words.next().ok_or_else(|| place("a corner has three numbers".into()))?;
                    *x =
                        number(Some(word)).ok_or_else(|| place(format!("`{}` is not a finite number", short(word))))?;
                }
                corners.push(Point::from(xyz));
            }
            "endfacet" if begun => {
                let [a, b, c] = corners[..] else {
                    return Err(place(format!("a facet has {} corners instead of 3", corners.len())));
                };
                mesh.facet(path, [a, b, c])?;
                corners.clear();
            }
            "facet" | "outer" | "endloop" | "endsolid" if begun => {}
            other => return Err(place(format!("`{}` is not a word of an STL file", short(other)))),
        }
    }
    if !corners.is_empty() || !begun {
        return Err(content(path, "the file ends within a facet or has none"));
    }
    Ok(mesh.0)
}

fn short(word: &str) -> String {
    word.chars().take(20).collect::<String>().escape_default().to_string()
}

impl Mesh {
    fn facet(&mut self, path: &Path, corners: [Point; 3]) -> Result<(), MeshFileError> {
        let first = self.0.positions.len();
        if self.0.triangles.len() >= MAX_TRIANGLES {
            return Err(super::too_many(path));
        }
        self.0.positions.extend(corners);
        self.0.triangles.push([0, 1, 2].map(|k| (first + k) as u32));
        Ok(())
    }
}
