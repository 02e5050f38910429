//! Bytes as text in a page: Base64, and a mesh in few bytes.

use crate::picture::Picture;

/// Base64 (RFC 4648, section 4), with padding.
pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let group = chunk.iter().chain([0, 0].iter()).take(3).fold(0_u32, |g, b| g << 8 | u32::from(*b));
        for k in 0..4 {
            let letter = LETTERS[(group >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

/// A mesh packed for the page's viewer, little endian:
///
/// ```text
/// u32 vertices, u32 triangles, f32 low[3], f32 size[3]          box of the vertices, mm
/// u16 x, y, z   a vertex: low + size * value / 65535
/// i8  x, y, z   a vertex: normal * 127
/// u8            a vertex: 254 * position on the color map, 255 where there is no value; only with shades
/// varint        an index: zigzag of the difference to the index before (LEB128)
/// ```
///
/// A part of 300 mm is resolved to 5 µm. `shades` are positions on the color map, 0..=1
/// or not a number, or empty.
pub(crate) fn pack_mesh(picture: &Picture, shades: &[f64]) -> Vec<u8> {
    let bounds = picture.aabb();
    let (low, size) = if bounds.is_empty() { ([0.0; 3], [1.0; 3]) } else { (bounds.min.into(), bounds.size().into()) };
    let low: [f64; 3] = low;
    let size: [f64; 3] = size;
    let mut out = Vec::with_capacity(picture.positions.len() * 10 + picture.triangles.len() * 5 + 32);
    out.extend((picture.positions.len() as u32).to_le_bytes());
    out.extend((picture.triangles.len() as u32).to_le_bytes());
    for v in low.iter().chain(&size) {
        out.extend((*v as f32).to_le_bytes());
    }
    for p in &picture.positions {
        for k in 0..3 {
            let t = if size[k] > 0.0 { (f64::from(p[k]) - low[k]) / size[k] } else { 0.0 };
            out.extend(((t.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
        }
    }
    for n in &picture.normals {
        out.extend(n.map(|v| (v * 127.0).round() as i8 as u8));
    }
    if !shades.is_empty() {
        out.extend(shades.iter().map(|s| if s.is_nan() { 255 } else { (s.clamp(0.0, 1.0) * 254.0).round() as u8 }));
    }
    let mut last = 0_i64;
    for &i in picture.triangles.iter().flatten() {
        let step = i64::from(i) - last;
        last = i64::from(i);
        let mut code = (step << 1 ^ step >> 63) as u64;
        while code >= 128 {
            out.push(code as u8 | 128);
            code >>= 7;
        }
        out.push(code as u8);
    }
    out
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, Point, box_mesh};

    use super::*;

    #[test]
    fn base64_of_the_standard() {
        // RFC 4648, section 10.
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn a_packed_mesh_unpacks_to_itself() {
        let mesh = box_mesh(&Aabb { min: Point::new(-5.0, 0.0, 2.0), max: Point::new(5.0, 7.0, 2.5) });
        let picture = Picture::new(&mesh, &[], &[]);
        let mut shades: Vec<f64> = (0..8).map(|i| f64::from(i) / 4.0).collect();
        shades[7] = f64::NAN;
        let bytes = pack_mesh(&picture, &shades);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        assert_eq!((word(0), word(4)), (8, 12));
        for (v, p) in picture.positions.iter().enumerate() {
            for (k, value) in p.iter().enumerate() {
                let at = 32 + 6 * v + 2 * k;
                let t = f32::from(u16::from_le_bytes([bytes[at], bytes[at + 1]])) / 65535.0;
                let (low, size) = (f32::from_bits(word(8 + 4 * k)), f32::from_bits(word(20 + 4 * k)));
                assert!((low + size * t - value).abs() < 1e-4);
            }
        }
        assert_eq!(bytes[32 + 8 * 9..32 + 8 * 10], [0, 64, 127, 191, 254, 254, 254, 255]);
        let (mut at, mut last, mut indices) = (32 + 8 * 10, 0_i64, Vec::new());
        while at < bytes.len() {
            let (mut code, mut shift) = (0_u64, 0);
            loop {
                code |= u64::from(bytes[at] & 127) << shift;
                shift += 7;
                at += 1;
                if bytes[at - 1] < 128 {
                    break;
                }
            }
            last += (code >> 1) as i64 ^ -((code & 1) as i64);
            indices.push(last as u32);
        }
        assert_eq!(indices, picture.triangles.concat());
    }
}
