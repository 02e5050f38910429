//! The archive round an X3P file: entries stored or deflated (PKWARE APPNOTE 6.3), no encryption, one disk,
//! below 4 GiB.
//!
//! What is read comes from the central directory at the end; local headers are only asked where the data
//! begin.

use std::io::{Read, Write};

use flate2::{Compression, Crc, read::DeflateDecoder, write::DeflateEncoder};

use super::FileFault;

const ANEW: &str = "write the file again from the measuring program";
const END: &[u8] = b"PK\x05\x06";
const CENTRAL: &[u8] = b"PK\x01\x02";
const LOCAL: &[u8] = b"PK\x03\x04";
/// Most entries that are looked at.
const MOST_ENTRIES: usize = 4096;

/// One file in the archive.
#[derive(Debug)]
struct ZipEntry {
    name: String,
    method: u16,
    encrypted: bool,
    crc: u32,
    packed: usize,
    size: usize,
    local: usize,
}

/// An archive in memory.
#[derive(Debug)]
pub(super) struct Archive<'a> {
    bytes: &'a [u8],
    entries: Vec<ZipEntry>,
}

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at.checked_add(2)?).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..at.checked_add(4)?).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)
}

impl<'a> Archive<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, FileFault> {
        let damaged = || FileFault::new("the archive has no readable directory: the file is cut off or damaged", ANEW);
        // The end record is followed by a remark of 65535 bytes at most.
        let from = bytes.len().saturating_sub(22 + 65_535);
        let end = bytes[from..].windows(4).rposition(|w| w == END).map(|k| from + k).ok_or_else(damaged)?;
        let entries = u16_at(bytes, end + 10).ok_or_else(damaged)?;
        if entries > MOST_ENTRIES {
            return Err(FileFault::new(
                format!("{entries} files in the archive; {MOST_ENTRIES} are read at most"),
                ANEW,
            ));
        }
        let mut at = u32_at(bytes, end + 16).ok_or_else(damaged)?;
        let mut list = Vec::with_capacity(entries);
        for _ in 0..entries {
            if bytes.get(at..).is_none_or(|b| !b.starts_with(CENTRAL)) {
                return Err(damaged());
            }
            let short = |offset: usize| u16_at(bytes, at + offset).ok_or_else(damaged);
            let long = |offset: usize| u32_at(bytes, at + offset).ok_or_else(damaged);
            let name_length = short(28)?;
            let name = bytes.get(at + 46..at + 46 + name_length).ok_or_else(damaged)?;
            list.push(ZipEntry {
                name: String::from_utf8_lossy(name).replace('\\', "/"),
                method: short(10)? as u16,
                encrypted: short(8)? & 1 == 1,
                crc: long(16)? as u32,
                packed: long(20)?,
                size: long(24)?,
                local: long(42)?,
            });
            at += 46 + name_length + short(30)? + short(32)?;
        }
        Ok(Self { bytes, entries: list })
    }

    /// The content of a file, at most `most` bytes; none where it is not in the archive.
    pub(super) fn read(&self, name: &str, most: usize) -> Result<Option<Vec<u8>>, FileFault> {
        let wanted = name.trim_start_matches("./");
        let Some(entry) = self.entries.iter().find(|e| e.name == wanted) else { return Ok(None) };
        let damaged = |why: &str| FileFault::new(format!("{wanted} in the archive: {why}"), ANEW);
        if entry.encrypted {
            return Err(damaged("it is encrypted"));
        }
        if entry.size > most {
            return Err(damaged(&format!("it has {} bytes; the limit is {most}", entry.size)));
        }
        let header = self.bytes.get(entry.local..).filter(|b| b.starts_with(LOCAL));
        let header = header.ok_or_else(|| damaged("its header is damaged"))?;
        let (Some(name), Some(extra)) = (u16_at(header, 26), u16_at(header, 28)) else {
            return Err(damaged("its header is cut off"));
        };
        let packed = header.get(30 + name + extra..).and_then(|b| b.get(..entry.packed));
        let packed = packed.ok_or_else(|| damaged("its data are cut off"))?;
        let content = match entry.method {
            0 => packed.to_vec(),
            8 => {
                // One byte more than stated: if more comes out, the file is damaged; memory stays bounded.
                let mut content = Vec::new();
                let told = entry.size as u64 + 1;
                DeflateDecoder::new(packed)
                    .take(told)
                    .read_to_end(&mut content)
                    .map_err(|e| damaged(&format!("it does not unpack: {e}")))?;
                content
            }
            other => return Err(damaged(&format!("it is packed by method {other}; 0 and 8 are read"))),
        };
        if content.len() != entry.size {
            return Err(damaged(&format!("{} bytes in place of {}", content.len(), entry.size)));
        }
        let crc = crc(&content);
        if crc != entry.crc {
            return Err(damaged(&format!("its checksum is {crc:08x} and not {:08x}", entry.crc)));
        }
        Ok(Some(content))
    }
}

fn crc(content: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(content);
    crc.sum()
}

/// An archive of these files, deflated; the date of each is the earliest that the format knows.
pub(super) fn pack(files: &[(&str, &[u8])]) -> Result<Vec<u8>, FileFault> {
    let too_long = || FileFault::new("the archive has more than 4 GiB", "write a smaller patch");
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
        let packed = encoder.write_all(content).and_then(|()| encoder.finish());
        let packed = packed.map_err(|e| FileFault::new(format!("{name} cannot be packed: {e}"), "write SDF"))?;
        let offset = u32::try_from(out.len()).map_err(|_ignored| too_long())?;
        let mut fields = Vec::new();
        for v in [20_u16, 0, 8, 0, 0x21] {
            fields.extend_from_slice(&v.to_le_bytes());
        }
        let long = |n: usize| u32::try_from(n).map_err(|_ignored| too_long());
        for v in [crc(content), long(packed.len())?, long(content.len())?] {
            fields.extend_from_slice(&v.to_le_bytes());
        }
        fields.extend_from_slice(&(name.len() as u16).to_le_bytes());
        fields.extend_from_slice(&[0; 2]);
        out.extend_from_slice(LOCAL);
        out.extend_from_slice(&fields);
        out.extend_from_slice(name.as_bytes());
        out.extend_from_slice(&packed);
        directory.extend_from_slice(CENTRAL);
        directory.extend_from_slice(&20_u16.to_le_bytes());
        directory.extend_from_slice(&fields);
        // No remark, first disk, no attributes.
        directory.extend_from_slice(&[0; 10]);
        directory.extend_from_slice(&offset.to_le_bytes());
        directory.extend_from_slice(name.as_bytes());
    }
    let begin = u32::try_from(out.len()).map_err(|_ignored| too_long())?;
    let count = (files.len() as u16).to_le_bytes();
    out.extend_from_slice(&directory);
    out.extend_from_slice(END);
    out.extend_from_slice(&[0; 4]);
    out.extend_from_slice(&count);
    out.extend_from_slice(&count);
    out.extend_from_slice(&(directory.len() as u32).to_le_bytes());
    out.extend_from_slice(&begin.to_le_bytes());
    out.extend_from_slice(&[0; 2]);
    Ok(out)
}
