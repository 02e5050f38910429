//! Heights of ridges in figures: mean and percentile by length, by patch, by pass, and as a histogram.

use std::collections::BTreeMap;

use proveout_geom::Point;

use super::ridges::Ridge;

/// Bars of a histogram at most.
const BARS: f64 = 20.0;
/// Width of a bar at least, mm: what is known of a height.
const NARROWEST: f64 = 1e-6;

/// Heights of some ridges, mm; means and percentiles are weighted by the length of the ridges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heights {
    /// Places on ridges.
    pub places: u64,
    /// Length of the ridges, mm.
    pub length: f64,
    /// Mean.
    pub mean: f64,
    /// The smallest height that 95 percent of the length do not pass.
    pub p95: f64,
    /// Largest.
    pub max: f64,
    /// Index of the highest place.
    pub highest: usize,
}

/// The same for a cube of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchHeights {
    /// Middle of the cube, mm.
    pub middle: Point,
    /// Its ridges.
    pub heights: Heights,
}

/// The same for a pass: the ridges that it leaves against earlier ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassHeights {
    /// First piece of the pass.
    pub first_piece: u32,
    /// Its ridges.
    pub heights: Heights,
}

/// Length of ridges by height.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histogram {
    /// Lower bound of the first bar, mm.
    pub from: f64,
    /// Width of a bar, mm.
    pub width: f64,
    /// Length of the ridges in each bar, mm.
    pub lengths: Vec<f64>,
}

/// Height above the design that ridges are known by.
fn summary<'a>(ridges: impl Iterator<Item = (usize, &'a Ridge)>) -> Option<Heights> {
    let mut all: Vec<(f64, f64, usize)> = ridges.map(|(i, r)| (r.height, r.weight, i)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    let length: f64 = all.iter().map(|a| a.1).sum();
    let &(max, _, highest) = all.last()?;
    let mean = all.iter().map(|a| a.0 * a.1).sum::<f64>() / length;
    let mut passed = 0.0;
    let p95 = all.iter().find(|a| {
        passed += a.1;
        passed >= 0.95 * length
    });
    Some(Heights { places: all.len() as u64, length, mean, p95: p95.map_or(max, |a| a.0), max, highest })
}

/// All ridges together; none without ridges.
pub fn heights(ridges: &[Ridge]) -> Option<Heights> {
    summary(ridges.iter().enumerate())
}

/// Ridges by cubes of an edge (mm), the one with the highest percentile first.
pub fn by_patch(ridges: &[Ridge], edge: f64) -> Vec<PatchHeights> {
    let mut cubes: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, r) in ridges.iter().enumerate() {
        cubes.entry([0, 1, 2].map(|k| (r.point[k] / edge).floor() as i64)).or_default().push(i);
    }
    let patch = |(key, of): (&[i64; 3], &Vec<usize>)| {
        let heights = summary(of.iter().map(|i| (*i, &ridges[*i])))?;
        Some(PatchHeights { middle: Point::from(key.map(|k| (k as f64 + 0.5) * edge)), heights })
    };
    let mut patches: Vec<PatchHeights> = cubes.iter().filter_map(patch).collect();
    patches.sort_by(|a, b| b.heights.p95.total_cmp(&a.heights.p95));
    patches
}

/// Ridges by pass, in the order of the passes.
///
/// A pass is the longest stretch of motion that leaves no ridge with itself. A ridge of the pieces p < q
/// says that a pass begins in p + 1 ..= q. With the ridges in the order of q, a begin at q wherever none
/// lies in that range is the smallest number of begins. So the turns of a helix and the rows of a zigzag
/// are separated without interpreting the program.
pub fn by_pass(ridges: &[Ridge]) -> Vec<PassHeights> {
    let mut ends: Vec<[u32; 2]> = ridges.iter().map(|r| [r.pieces[1], r.pieces[0]]).collect();
    ends.sort_unstable();
    let mut begins = vec![0];
    for [q, p] in ends {
        if begins.last().is_none_or(|b| *b <= p) && q > p {
            begins.push(q);
        }
    }
    let mut passes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, r) in ridges.iter().enumerate() {
        passes.entry(begins.partition_point(|b| *b <= r.pieces[1]) - 1).or_default().push(i);
    }
    let pass = |(k, of): (&usize, &Vec<usize>)| {
        let heights = summary(of.iter().map(|i| (*i, &ridges[*i])))?;
        Some(PassHeights { first_piece: begins[*k], heights })
    };
    passes.iter().filter_map(pass).collect()
}

/// Ridges by height, in bars of 1, 2 or 5 times a power of ten.
pub fn histogram(ridges: &[Ridge]) -> Histogram {
    let heights = || ridges.iter().map(|r| r.height);
    let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    if ridges.is_empty() {
        return Histogram::default();
    }
    // No bar is narrower than what is known of a height.
    let least = ((high - low) / BARS).max(NARROWEST);
    let power = 10.0_f64.powf(least.log10().floor());
    let width = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|w| *w >= least).unwrap_or(least);
    let from = (low / width).floor() * width;
    let mut lengths = vec![0.0; ((high - from) / width).floor() as usize + 1];
    for r in ridges {
        lengths[((r.height - from) / width).floor().max(0.0) as usize] += r.weight;
    }
    Histogram { from, width, lengths }
}
