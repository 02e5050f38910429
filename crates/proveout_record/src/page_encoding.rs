//! Bytes as text in a page: Base64, and meshes and paths in few bytes.

use std::io::Write;

use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::{Compression, write::ZlibEncoder};
use half::f16;
use proveout_geom::Aabb;

use crate::picture::Picture;

/// Values are cut to this: half precision ends at 65504.
const LARGEST_HALF: f32 = 6e4;

/// Level of compression: higher ones take longer than what they save is worth.
const LEVEL: u32 = 6;

/// Base64 (RFC 4648, section 4), with padding.
pub(crate) fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Bytes compressed (zlib, RFC 1950), in Base64.
pub(crate) fn deflated(bytes: &[u8]) -> String {
    let mut out = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    let packed = out.write_all(bytes).and_then(|()| out.finish());
    base64(&packed.unwrap_or_default()) // memory takes everything
}

/// What the viewer colors the vertices of a mesh by.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shades<'a> {
    /// One color.
    Plain,
    /// Positions on the color map, 0..=1 or not a number.
    Positions(&'a [f64]),
    /// The values of the mesh, mm, on a map whose range the reader chooses.
    Values,
}

/// The value that means "none": the largest half float.
const NO_VALUE: f16 = f16::MAX;

/// A mesh packed for the page's viewer, little endian:
///
/// ```text
/// u32 vertices, u32 triangles, f32 low[3], f32 size[3]          box of the vertices, mm
/// varint        x of all vertices: zigzag of the difference to the one before (LEB128) of the place in the
///               box, low + size * value / 65535; then y, then z
/// u8            x of the normals, times 127: difference to the one before, modulo 256; then y, then z
/// u8            a vertex: 254 * position on the color map, 255 where there is no value; only with positions
/// f16           a vertex: value, mm, the largest number where there is none; only with values
/// varint        a vertex: zigzag of the difference to the block before; only with blocks
/// varint        an index: zigzag of the difference to the index before
/// ```
///
/// A part of 300 mm is resolved to 5 µm. Differences make the page smaller by a million bytes at 200,000
/// triangles. `blocks` are the numbers of the blocks that made the vertices plus one, 0 for none, or empty.
pub(crate) fn pack_mesh(picture: &Picture, shades: Shades<'_>, blocks: &[u32]) -> Vec<u8> {
    pack_mesh_in(&picture.aabb(), picture, shades, blocks)
}

/// The same in a given box, so that meshes which touch round their common vertices alike; what lies outside
/// of the box is drawn at its faces.
pub(crate) fn pack_mesh_in(bounds: &Aabb, picture: &Picture, shades: Shades<'_>, blocks: &[u32]) -> Vec<u8> {
    let (low, size) = if bounds.is_empty() { ([0.0; 3], [1.0; 3]) } else { (bounds.min.into(), bounds.size().into()) };
    let (low, size): ([f64; 3], [f64; 3]) = (low, size);
    let mut out = Vec::with_capacity(picture.positions.len() * 10 + picture.triangles.len() * 5 + 32);
    out.extend((picture.positions.len() as u32).to_le_bytes());
    out.extend((picture.triangles.len() as u32).to_le_bytes());
    for v in low.iter().chain(&size) {
        out.extend((*v as f32).to_le_bytes());
    }
    for k in 0..3 {
        let mut steps = DeltaWriter::default();
        for p in &picture.positions {
            steps.put(i64::from(quantize_u16(f64::from(p[k]), low[k], size[k])), &mut out);
        }
    }
    for k in 0..3 {
        let mut last = 0_u8;
        for n in &picture.normals {
            let byte = (n[k] * 127.0).round() as i8 as u8;
            out.push(byte.wrapping_sub(last));
            last = byte;
        }
    }
    match shades {
        Shades::Plain => {}
        Shades::Positions(all) => {
            out.extend(all.iter().map(|s| if s.is_nan() { 255 } else { (s.clamp(0.0, 1.0) * 254.0).round() as u8 }));
        }
        Shades::Values => {
            for v in &picture.values {
                let half = if v.is_finite() { f16::from_f32(v.clamp(-LARGEST_HALF, LARGEST_HALF)) } else { NO_VALUE };
                out.extend(half.to_bits().to_le_bytes());
            }
        }
    }
    let mut steps = DeltaWriter::default();
    blocks.iter().for_each(|block| steps.put(i64::from(*block), &mut out));
    let mut steps = DeltaWriter::default();
    picture.triangles.iter().flatten().for_each(|i| steps.put(i64::from(*i), &mut out));
    out
}

/// Place of a value in a range, as 16 bits.
pub(crate) fn quantize_u16(value: f64, low: f64, size: f64) -> u16 {
    let t = if size > 0.0 { (value - low) / size } else { 0.0 };
    (t.clamp(0.0, 1.0) * 65535.0).round() as u16
}

/// Writes whole numbers as their differences, small ones in one byte.
#[derive(Default)]
pub(crate) struct DeltaWriter {
    last: i64,
}

impl DeltaWriter {
    pub(crate) fn put(&mut self, value: i64, out: &mut Vec<u8>) {
        let step = value - self.last;
        self.last = value;
        let mut code = (step << 1 ^ step >> 63) as u64;
        while code >= 128 {
            out.push(code as u8 | 128);
            code >>= 7;
        }
        out.push(code as u8);
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;
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
    fn deflated_bytes_come_back() {
        let bytes: Vec<u8> = (0..5000_u32).map(|i| (i / 7) as u8).collect();
        let packed = STANDARD.decode(deflated(&bytes)).expect("base64");
        assert!(packed.len() < 1500);
        let mut back = Vec::new();
        ZlibDecoder::new(packed.as_slice()).read_to_end(&mut back).expect("zlib");
        assert_eq!(back, bytes);
    }

    fn numbers(bytes: &[u8], at: &mut usize, count: usize) -> Vec<u32> {
        let mut last = 0_i64;
        let mut next = || {
            let (mut code, mut shift) = (0_u64, 0);
            loop {
                code |= u64::from(bytes[*at] & 127) << shift;
                shift += 7;
                *at += 1;
                if bytes[*at - 1] < 128 {
                    break;
                }
            }
            last += (code >> 1) as i64 ^ -((code & 1) as i64);
            last as u32
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn a_packed_mesh_unpacks_to_itself() {
        let mesh = box_mesh(&Aabb { min: Point::new(-5.0, 0.0, 2.0), max: Point::new(5.0, 7.0, 2.5) });
        let mut picture = Picture::new(&mesh, &[], &[]);
        picture.values = vec![0.5, -146.0, 0.001, f32::NAN, 1e6, 0.0, 0.0, -0.0];
        let mut shades: Vec<f64> = (0..8).map(|i| f64::from(i) / 4.0).collect();
        shades[7] = f64::NAN;
        let bytes = pack_mesh(&picture, Shades::Positions(&shades), &[]);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        assert_eq!((word(0), word(4)), (8, 12));
        let mut at = 32;
        for k in 0..3 {
            let places = numbers(&bytes, &mut at, 8);
            let (low, size) = (f32::from_bits(word(8 + 4 * k)), f32::from_bits(word(20 + 4 * k)));
            for (p, place) in picture.positions.iter().zip(places) {
                assert!((low + size * place as f32 / 65535.0 - p[k]).abs() < 1e-4);
            }
        }
        for k in 0..3 {
            let mut last = 0_u8;
            for (n, step) in picture.normals.iter().zip(&bytes[at..at + 8]) {
                last = last.wrapping_add(*step);
                assert!((f32::from(last as i8) / 127.0 - n[k]).abs() < 0.5 / 127.0 + 1e-6);
            }
            at += 8;
        }
        let shaded = at;
        assert_eq!(bytes[at..at + 8], [0, 64, 127, 191, 254, 254, 254, 255]);
        at += 8;
        assert_eq!(numbers(&bytes, &mut at, 36), picture.triangles.concat());
        assert_eq!(at, bytes.len());

        let lines = [7, 7, 0, 100_000, 3, 4, 5, 6];
        let bytes = pack_mesh(&picture, Shades::Values, &lines);
        let half = |v: usize| f16::from_le_bytes([bytes[shaded + 2 * v], bytes[shaded + 1 + 2 * v]]);
        assert_eq!([half(0).to_f32(), half(1).to_f32()], [0.5, -146.0]);
        assert!((half(2).to_f32() - 0.001).abs() < 1e-6 && half(3) == f16::MAX && half(4) < f16::MAX);
        at = shaded + 16;
        assert_eq!(numbers(&bytes, &mut at, 8), lines);
        assert_eq!(numbers(&bytes, &mut at, 36), picture.triangles.concat());
    }
}
