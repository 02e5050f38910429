//! The container of a binary glTF file: header and chunks.
//!
//! ```text
//!   "glTF" 2 length | length "JSON" text, blanks | length "BIN\0" bytes, zeros     (Khronos, glTF 2.0, 4.4)
//! ```
//!
//! Words are of 32 bits, little-endian; each chunk ends at a multiple of four bytes.

use std::io::{self, Write};

/// Bytes of the header of the file, and of a chunk.
const FILE_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
/// Chunks end at multiples of this.
const ALIGNED: usize = 4;

/// Writes a binary glTF file: `json` is its document, `bin_length` the length of its binary chunk in bytes,
/// which `bin` writes. Without bytes the chunk is left out.
///
/// # Errors
/// What `out` and `bin` return; a file above 4 GiB, which the format cannot hold; another number of bytes
/// than `bin_length`.
pub fn write_glb_container<W: Write>(
    out: &mut W,
    json: &[u8],
    bin_length: usize,
    bin: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let [text, bytes] = [json.len(), bin_length].map(|n| n.next_multiple_of(ALIGNED));
    let chunk = if bin_length == 0 { 0 } else { CHUNK_HEADER + bytes };
    let length = u32::try_from(FILE_HEADER + CHUNK_HEADER + text + chunk)
        .map_err(|_above| io::Error::other("the file is above 4 GiB, which binary glTF cannot hold"))?;
    // Both are below the length of the file.
    let word = |n: usize| (n as u32).to_le_bytes();
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&word(text))?;
    out.write_all(b"JSON")?;
    out.write_all(json)?;
    out.write_all(&[b' '; ALIGNED][..text - json.len()])?;
    if bin_length == 0 {
        return Ok(());
    }
    out.write_all(&word(bytes))?;
    out.write_all(b"BIN\0")?;
    let mut counted = CountedWriter { out, written: 0 };
    bin(&mut counted)?;
    if counted.written != bin_length {
        let message = format!("{} bytes of {bin_length} were written into the binary chunk", counted.written);
        return Err(io::Error::other(message));
    }
    out.write_all(&[0; ALIGNED][..bytes - bin_length])
}

struct CountedWriter<'a, W> {
    out: &'a mut W,
    written: usize,
}

impl<W: Write> Write for CountedWriter<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.out.write(bytes)?;
        self.written += n;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(json: &str, bin: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        write_glb_container(&mut out, json.as_bytes(), bin.len(), |w| w.write_all(bin))
            .expect("a vector takes everything");
        out
    }

    fn word(file: &[u8], at: usize) -> usize {
        u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]]) as usize
    }

    #[test]
    fn chunks_are_aligned_and_the_lengths_are_those_of_the_file() {
        for (json, bin) in
            [("{}", &[][..]), ("{ }", &[1, 2, 3][..]), ("{  }", &[1, 2, 3, 4][..]), ("{\"a\":1}", &[9; 5][..])]
        {
            let file = file(json, bin);
            assert_eq!((&file[..4], word(&file, 4), word(&file, 8)), (&b"glTF"[..], 2, file.len()));
            let text = word(&file, 12);
            assert_eq!((&file[16..20], text % 4), (&b"JSON"[..], 0));
            assert_eq!(std::str::from_utf8(&file[20..20 + text]).expect("text").trim_end(), json.trim_end());
            if bin.is_empty() {
                assert_eq!(file.len(), 20 + text, "no empty chunk");
                continue;
            }
            let at = 20 + text;
            assert_eq!((&file[at + 4..at + 8], word(&file, at) % 4), (&b"BIN\0"[..], 0));
            assert_eq!(file.len(), at + 8 + word(&file, at));
            assert_eq!(&file[at + 8..at + 8 + bin.len()], bin);
            assert!(file[at + 8 + bin.len()..].iter().all(|b| *b == 0));
        }
    }

    #[test]
    fn a_chunk_of_another_length_is_refused() {
        let mut out = Vec::new();
        let error = write_glb_container(&mut out, b"{}", 8, |w| w.write_all(&[0; 4])).expect_err("4 of 8");
        assert!(error.to_string().contains("4 bytes of 8"), "{error}");
    }
}
