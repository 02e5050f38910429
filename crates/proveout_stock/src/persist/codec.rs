//! Bytes of interval ends: each end is encoded by its difference from the previous end of the same
//! kind.
//!
//! Neighboring rays end at nearly the same height on the same face, so the XOR of the bit patterns has
//! leading zeros, and mover and normal are mostly those of the neighbor. One control byte an end says what
//! follows:
//!
//! ```text
//!   bit 7 6 | 5            | 4        | 3 2 1 0
//!       0 0 | normal given | id given | bytes of the height that follow, 0 to 8, lowest first
//! ```
//!
//! then these bytes, the id less the id before as zigzag LEB128, and the four bytes of the packed normal.

use crate::field::span::{EndMark, SpanEnd};

/// What is wrong with some bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ByteFault {
    /// Place in the payload, bytes.
    pub at: usize,
    pub what: &'static str,
}

/// FNV-1a of 64 bits (Fowler, Noll and Vo 1991): a change of any single byte changes it.
pub(crate) fn digest(bytes: &[u8]) -> u64 {
    digest_of(&[bytes])
}

/// The digest of parts one after the other.
pub(crate) fn digest_of(parts: &[&[u8]]) -> u64 {
    let bytes = parts.iter().flat_map(|part| part.iter());
    bytes.fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
}

/// Writes numbers and ends.
#[derive(Default)]
pub(crate) struct Encoder {
    pub bytes: Vec<u8>,
    before: Vec<SpanEnd>,
}

impl Encoder {
    /// LEB128, seven bits a byte, lowest first.
    pub(crate) fn number(&mut self, mut x: u64) {
        while x > 127 {
            self.bytes.push(x as u8 | 128);
            x >>= 7;
        }
        self.bytes.push(x as u8);
    }

    pub(crate) fn real(&mut self, x: f64) {
        self.bytes.extend(x.to_bits().to_le_bytes());
    }

    /// Writes an end as its difference from the last one of the same `kind`.
    pub(crate) fn end(&mut self, kind: usize, end: SpanEnd) {
        let before = slot(&mut self.before, kind);
        let change = (end.s.to_bits() ^ before.s.to_bits()).to_le_bytes();
        let count = 8 - change.iter().rev().take_while(|b| **b == 0).count();
        let (id, normal) = (end.mark.id != before.mark.id, end.mark.code() != before.mark.code());
        let step = i64::from(end.mark.id) - i64::from(before.mark.id);
        *before = end;
        self.bytes.push(count as u8 | u8::from(id) << 4 | u8::from(normal) << 5);
        self.bytes.extend(&change[..count]);
        if id {
            self.number((step << 1 ^ step >> 63) as u64);
        }
        if normal {
            self.bytes.extend(end.mark.code().to_le_bytes());
        }
    }
}

fn slot(before: &mut Vec<SpanEnd>, kind: usize) -> &mut SpanEnd {
    if before.len() <= kind {
        before.resize(kind + 1, SpanEnd { s: 0.0, mark: EndMark::from_code(0, 0) });
    }
    &mut before[kind]
}

/// Reads what [`Encoder`] wrote; never past the end.
pub(crate) struct Decoder<'a> {
    bytes: &'a [u8],
    pub at: usize,
    before: Vec<SpanEnd>,
}

impl<'a> Decoder<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, before: Vec::new() }
    }

    pub(crate) fn fault(&self, what: &'static str) -> ByteFault {
        ByteFault { at: self.at, what }
    }

    pub(crate) fn is_done(&self) -> bool {
        self.at == self.bytes.len()
    }

    /// Bytes that are left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn take<const N: usize>(&mut self, count: usize) -> Result<[u8; N], ByteFault> {
        let from = self.bytes.get(self.at..self.at + count).ok_or_else(|| self.fault("it ends in the middle"))?;
        let mut out = [0; N];
        out[..count].copy_from_slice(from);
        self.at += count;
        Ok(out)
    }

    /// Three bytes.
    pub(crate) fn three(&mut self) -> Result<[u8; 3], ByteFault> {
        self.take::<3>(3)
    }

    pub(crate) fn number(&mut self) -> Result<u64, ByteFault> {
        let mut x = 0_u64;
        for shift in (0..64).step_by(7) {
            let [byte] = self.take::<1>(1)?;
            let part = u64::from(byte & 127);
            if shift == 63 && part > 1 {
                break;
            }
            x |= part << shift;
            if byte < 128 {
                return Ok(x);
            }
        }
        Err(self.fault("a number is too long"))
    }

    pub(crate) fn real(&mut self) -> Result<f64, ByteFault> {
        Ok(f64::from_bits(u64::from_le_bytes(self.take::<8>(8)?)))
    }

    pub(crate) fn end(&mut self, kind: usize) -> Result<SpanEnd, ByteFault> {
        let [control] = self.take::<1>(1)?;
        let count = usize::from(control & 15);
        if count > 8 || control >> 6 != 0 {
            return Err(self.fault("a control byte has no meaning"));
        }
        let change = u64::from_le_bytes(self.take::<8>(count)?);
        let step = if control & 16 == 0 { 0 } else { self.number()? };
        let code = if control & 32 == 0 { None } else { Some(u32::from_le_bytes(self.take::<4>(4)?)) };
        let step = (step >> 1) as i64 ^ -((step & 1) as i64);
        let before = slot(&mut self.before, kind);
        let id = i64::from(before.mark.id).checked_add(step).and_then(|id| u32::try_from(id).ok());
        let s = f64::from_bits(before.s.to_bits() ^ change);
        let code = code.unwrap_or_else(|| before.mark.code());
        let Some(id) = id else { return Err(self.fault("the id of a move is out of range")) };
        if !s.is_finite() {
            return Err(self.fault("a height is not finite"));
        }
        let end = SpanEnd { s, mark: EndMark::from_code(id, code) };
        *slot(&mut self.before, kind) = end;
        Ok(end)
    }
}

/// A number below `limit`.
pub(crate) fn below(input: &mut Decoder<'_>, limit: u64, what: &'static str) -> Result<u64, ByteFault> {
    let x = input.number()?;
    if x < limit { Ok(x) } else { Err(input.fault(what)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::span::INITIAL;

    #[test]
    fn ends_and_numbers_come_back_bit_for_bit() {
        let mut state = 88_172_645_463_325_252_u64;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state
        };
        let ends: Vec<(usize, SpanEnd)> = (0..20_000)
            .map(|_| {
                let s = (random() >> 12) as f64 / 1e14 - 20.0;
                let id = if random() % 5 == 0 { INITIAL } else { (random() % 70_000) as u32 };
                ((random() % 4) as usize, SpanEnd { s, mark: EndMark::from_code(id, random() as u32) })
            })
            .collect();
        let mut encoder = Encoder::default();
        for (kind, end) in &ends {
            encoder.end(*kind, *end);
            encoder.number(end.s.to_bits());
            encoder.real(end.s);
        }
        let mut decoder = Decoder::new(&encoder.bytes);
        for (kind, end) in &ends {
            assert_eq!(decoder.end(*kind), Ok(*end));
            assert_eq!(decoder.number(), Ok(end.s.to_bits()));
            assert_eq!(decoder.real(), Ok(end.s));
        }
        assert!(decoder.is_done() && decoder.number().is_err());
    }
}
