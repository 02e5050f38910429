//! Deviations of a surface counted in fine classes, so that shares and colors need no list of all points.
//!
//! A class holds values whose first 12 binary digits are the same: it is 0.025 percent of its value wide, far
//! below what a picture shows.

use std::collections::BTreeMap;

use proveout_geom::CellMap;

use crate::color::DeviationMap;

/// Bits of a double that are left out: 52 of the mantissa less 12.
const DROPPED: u32 = 40;

/// Counts and weights by value.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Classes {
    /// By sign and leading bits, negative values apart.
    below: CellMap<u32, (u64, f64)>,
    above: CellMap<u32, (u64, f64)>,
    count: u64,
}

impl Classes {
    /// Counts a value; one that is not finite is left out.
    pub(crate) fn add(&mut self, value: f64, weight: f64) {
        if !value.is_finite() {
            return;
        }
        let side = if value < 0.0 { &mut self.below } else { &mut self.above };
        let (count, sum) = side.entry((value.abs().to_bits() >> DROPPED) as u32).or_default();
        *count += 1;
        *sum += weight;
        self.count += 1;
    }

    /// Values of the classes with the weight in each: those below zero, then those above, each rising by
    /// magnitude.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let below = rising(&self.below).into_iter().map(|(bits, (_, weight))| (-middle(bits), weight));
        below.chain(rising(&self.above).into_iter().map(|(bits, (_, weight))| (middle(bits), weight)))
    }

    /// The map that [`DeviationMap::of`] gives for the values; none without values.
    pub(crate) fn map(&self, floor: f64) -> Option<DeviationMap> {
        let rank = self.count.checked_sub(1)? * 99 / 100;
        let mut sizes: BTreeMap<u32, u64> = BTreeMap::new();
        for (bits, (count, _)) in self.below.iter().chain(&self.above) {
            *sizes.entry(*bits).or_default() += count;
        }
        let mut before = 0;
        let wanted = sizes.iter().find(|(_, count)| {
            before += *count;
            before > rank
        });
        // The lower end of the class: a round value stays round.
        let size = wanted.map_or(0.0, |(bits, _)| f64::from_bits(u64::from(*bits) << DROPPED));
        Some(DeviationMap::of(&[size], floor))
    }
}

/// Classes by magnitude.
fn rising(classes: &CellMap<u32, (u64, f64)>) -> Vec<(u32, (u64, f64))> {
    let mut all: Vec<_> = classes.iter().map(|(bits, class)| (*bits, *class)).collect();
    all.sort_unstable_by_key(|(bits, _)| *bits);
    all
}

/// The value in the middle of a class.
fn middle(bits: u32) -> f64 {
    if bits == 0 { 0.0 } else { f64::from_bits(u64::from(bits) << DROPPED | 1 << (DROPPED - 1)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_is_that_of_the_list_and_shares_keep_their_weight() {
        let values: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.7).sin() * (1e-6 + f64::from(i) * 1e-6)).collect();
        let mut classes = Classes::default();
        values.iter().for_each(|v| classes.add(*v, 0.5));
        classes.add(f64::NAN, 1.0);
        assert_eq!(classes.map(0.0), Some(DeviationMap::of(&values, 0.0)));
        assert_eq!(classes.map(0.7), Some(DeviationMap::of(&values, 0.7)));
        let weight: f64 = classes.weights().map(|w| w.1).sum();
        assert!((weight - 2500.0).abs() < 1e-9);
        let mean = classes.weights().map(|(v, w)| v * w).sum::<f64>() / weight;
        let true_mean = values.iter().sum::<f64>() / 5000.0;
        assert!((mean - true_mean).abs() < 1e-6, "{mean} {true_mean}");
        assert_eq!(Classes::default().map(0.1), None);
        let mut round = Classes::default();
        (0..100).for_each(|_| round.add(-0.02, 1.0));
        assert_eq!(round.map(0.0), Some(DeviationMap { range: 0.02 }));
    }
}
