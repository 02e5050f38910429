//! Lanes and rows of a set as bits of a number.

/// Lanes of a row: rays of a tile with the same v.
pub(crate) const ROW: usize = crate::field::grid::TILE;

/// Bits of one row.
#[inline]
pub(crate) fn row_of(which: u64, row: usize) -> u64 {
    which >> (row * ROW) & 0xFF
}

/// Rows that the first `n` lanes lie in, one bit each.
pub(crate) fn rows_of(n: usize) -> u8 {
    ((1_u32 << n.div_ceil(ROW)) - 1) as u8
}

/// All lanes of some rows, one bit each.
#[inline]
pub(crate) fn lanes_of(rows: u8) -> u64 {
    // Each bit to the first of its byte, then all of the byte.
    let mut x = u64::from(rows);
    x = (x | x << 28) & 0x0000_000F_0000_000F;
    x = (x | x << 14) & 0x0003_0003_0003_0003;
    x = (x | x << 7) & 0x0101_0101_0101_0101;
    x * 0xFF
}

/// Rows of lanes, one bit each.
#[inline]
pub(crate) fn rows_with(which: u64) -> u8 {
    let mut x = which | which >> 4;
    x |= x >> 2;
    x = (x | x >> 1) & 0x0101_0101_0101_0101;
    // The bytes' first bits to the top one.
    (x.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}
