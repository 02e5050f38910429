//! Hash maps over the cells of a grid.
//!
//! Keys are whole numbers that the twin makes itself, so they cannot be chosen to collide. The hash is one
//! rotation and one multiplication per number. No order depends on it: such a map is only queried, never
//! iterated where order counts.

use std::{
    collections::HashMap,
    hash::{BuildHasherDefault, Hasher},
};

/// A hash map by cells of a grid.
pub type CellMap<K, V> = HashMap<K, V, BuildHasherDefault<CellHasher>>;

/// Mixes the whole numbers of a cell by Fibonacci hashing (Knuth 1973, 6.4).
#[derive(Clone, Copy, Debug, Default)]
pub struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    fn write_u32(&mut self, i: u32) {
        self.write_u64(u64::from(i));
    }

    fn write_i32(&mut self, i: i32) {
        self.write_u64(i as u64);
    }

    fn write_usize(&mut self, i: usize) {
        self.write_u64(i as u64);
    }

    fn write_u64(&mut self, i: u64) {
        self.0 = (self.0.rotate_left(21) ^ i).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

#[cfg(test)]
mod tests {
    use std::hash::BuildHasher;

    use super::*;

    #[test]
    fn cells_side_by_side_are_distinguished() {
        let mut map: CellMap<[i32; 3], usize> = CellMap::default();
        let mut low_bits = std::collections::BTreeSet::new();
        for (n, [i, j, k]) in (0..8000_i32).map(|n| [n % 20 - 10, n / 20 % 20 - 10, n / 400 - 10]).enumerate() {
            assert_eq!(map.insert([i, j, k], n), None);
            low_bits.insert(map.hasher().hash_one([i, j, k]) & 0xffff);
        }
        assert_eq!(map.len(), 8000);
        assert!(low_bits.len() > 6500, "{} of 8000 places of 65536", low_bits.len());
    }
}
