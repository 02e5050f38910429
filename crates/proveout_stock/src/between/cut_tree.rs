//! Boxes round the cuts of a run, in order of time: eight in one, and so on up. What comes later is near what
//! came before, so that boxes that are joined in order of time are small.

use proveout_geom::Aabb;

/// Boxes in one of the level above.
const FAN: usize = 8;

/// See the text of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct CutTree {
    /// From the cuts up.
    levels: Vec<Vec<Aabb>>,
}

impl CutTree {
    pub(super) fn push(&mut self, bounds: &Aabb) {
        let mut index = self.levels.first().map_or(0, Vec::len);
        for level in 0.. {
            if self.levels.len() == level {
                self.levels.push(Vec::new());
                // What the level below holds already.
                if let Some(below) = level.checked_sub(1).and_then(|b| self.levels.get(b)) {
                    let all = below.iter().fold(Aabb::empty(), |all, b| all.union(b));
                    self.levels[level].push(all);
                    break;
                }
            }
            let boxes = &mut self.levels[level];
            match boxes.get_mut(index) {
                Some(known) => *known = known.union(bounds),
                None => boxes.push(*bounds),
            }
            if boxes.len() == 1 {
                break;
            }
            index /= FAN;
        }
    }

    /// The last cut has become longer.
    pub(super) fn grow_last(&mut self, bounds: &Aabb) {
        for boxes in &mut self.levels {
            if let Some(last) = boxes.last_mut() {
                *last = last.union(bounds);
            }
        }
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.levels.first().map_or(0, Vec::len)
    }

    /// Numbers of the cuts whose boxes meet a box, the latest first, from `first` on.
    pub(super) fn near(&self, bounds: &Aabb, first: usize, out: &mut Vec<u32>) {
        if let Some(top) = self.levels.len().checked_sub(1) {
            for k in (0..self.levels[top].len()).rev() {
                self.under(top, k, bounds, first, out);
            }
        }
    }

    fn under(&self, level: usize, k: usize, bounds: &Aabb, first: usize, out: &mut Vec<u32>) {
        if !self.levels[level][k].intersects(bounds) || (k + 1) * FAN.pow(level as u32) <= first {
            return;
        }
        if level == 0 {
            out.push(k as u32);
            return;
        }
        let below = self.levels[level - 1].len();
        for child in (k * FAN..((k + 1) * FAN).min(below)).rev() {
            self.under(level - 1, child, bounds, first, out);
        }
    }

    pub(super) fn memory_bytes(&self) -> u64 {
        self.levels.iter().map(|l| (l.capacity() * size_of::<Aabb>()) as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Point, Vector};

    use super::*;

    #[test]
    fn it_finds_what_a_search_over_all_finds() {
        let mut tree = CutTree::default();
        let mut all = Vec::new();
        for k in 0..1000_u32 {
            let at = Point::new(f64::from(k % 37), f64::from(k % 11), f64::from(k) * 0.1);
            let bounds = Aabb { min: at, max: at + Vector::repeat(2.0) };
            tree.push(&bounds);
            all.push(bounds);
            if k % 97 == 0 || k < 20 {
                for first in [0, 5, all.len() / 2] {
                    let asked = Aabb { min: Point::new(3.0, 2.0, 0.0), max: Point::new(9.0, 6.0, 40.0) };
                    let mut found = Vec::new();
                    tree.near(&asked, first, &mut found);
                    let wanted: Vec<u32> =
                        (first..all.len()).rev().filter(|i| all[*i].intersects(&asked)).map(|i| i as u32).collect();
                    assert_eq!(found, wanted);
                }
            }
        }
        assert_eq!(tree.len(), 1000);
    }
}
