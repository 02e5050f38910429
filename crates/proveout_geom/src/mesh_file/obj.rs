//! OBJ: vertices and faces; texture, normals, groups and materials say nothing of the shape.

use std::path::Path;

use super::{MAX_TRIANGLES, MeshFileError, content, number, too_many};
use crate::{Point, TriMesh};

/// Reads vertices (`v x y z`) and faces (`f 1 2 3`, `f 1/1/1 2/2/1 -1`); faces of more than three corners
/// become fans from their first corner, which is their shape where they are flat and convex.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshFileError> {
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = TriMesh::default();
    let mut face = Vec::new();
    // A backslash at the end of a line continues it.
    let mut continued = String::new();
    for (number_of_line, line) in text.lines().enumerate() {
        let place = |what: &str| content(path, format!("line {}: {what}", number_of_line + 1));
        let line = line.trim_end();
        if let Some(part) = line.strip_suffix('\\') {
            continued.push_str(part);
            continued.push(' ');
            continue;
        }
        let whole = if continued.is_empty() { line } else { &{ std::mem::take(&mut continued) + line } };
        let mut words = whole.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut xyz = [0.0; 3];
                for x in &mut xyz {
                    *x = number(words.next()).ok_or_else(|| place("a vertex has three numbers"))?;
                }
                mesh.positions.push(Point::from(xyz));
            }
            Some("f") => {
                face.clear();
                for word in words {
                    let corner = corner(word, mesh.positions.len());
                    face.push(corner.ok_or_else(|| place("a corner names no vertex that is defined before it"))?);
                }
                if face.len() < 3 {
                    return Err(place("a face has three corners or more"));
                }
                if mesh.triangles.len() + face.len() - 2 > MAX_TRIANGLES {
                    return Err(too_many(path));
                }
                mesh.triangles.extend((2..face.len()).map(|k| [face[0], face[k - 1], face[k]]));
            }
            _ => {}
        }
    }
    Ok(mesh)
}

/// Index of the vertex of a corner: counted from 1, or backwards from the last one.
fn corner(word: &str, vertices: usize) -> Option<u32> {
    let index: i64 = word.split('/').next()?.parse().ok()?;
    let from_zero = if index > 0 { index - 1 } else { i64::try_from(vertices).ok()?.checked_add(index)? };
    u32::try_from(from_zero).ok().filter(|&i| index != 0 && (i as usize) < vertices)
}
