//! Samples joined over a cell of path: what the rays of the neighbors have seen counts as well.
//!
//! A sample may hold too few rays to see where the material begins and ends. Over a cell of path each slice
//! has a ray on each side. Joining makes ranges wider, never narrower, and lets a step of engagement begin up
//! to a cell before the cutter meets it. A slice between two others that no ray has marked takes the range
//! of both.

use proveout_feeds::SliceCut;

use crate::cut::engaged_samples::{EngagedSample, EngagedSlice};

/// The slices of each sample with those of its neighbors within `reach` mm of path; same order as the
/// samples.
pub(crate) fn joined(samples: &[EngagedSample], reach: f64) -> Vec<Vec<EngagedSlice>> {
    let mut first = 0;
    let mut all = Vec::with_capacity(samples.len());
    for (i, sample) in samples.iter().enumerate() {
        while samples.get(first).is_some_and(|s| s.path[1] < sample.path[0] - reach) {
            first += 1;
        }
        let near = samples.iter().enumerate().skip(first).take_while(|(_, s)| s.path[0] <= sample.path[1] + reach);
        let mut slices = sample.slices.clone();
        for (k, other) in near {
            if k == i || other.tool != sample.tool {
                continue;
            }
            for slice in &other.slices {
                // What a neighbor took is its own.
                let slice = EngagedSlice { volume_mm3: 0.0, ..*slice };
                match slices.binary_search_by_key(&slice.slice, |s| s.slice) {
                    Ok(at) => slices[at].join(&slice),
                    Err(at) => slices.insert(at, slice),
                }
            }
        }
        all.push(filled(slices));
    }
    all
}

/// Slices between the lowest and the highest one that nothing has marked.
fn filled(slices: Vec<EngagedSlice>) -> Vec<EngagedSlice> {
    let mut out: Vec<EngagedSlice> = Vec::with_capacity(slices.len());
    for slice in slices {
        if let Some(below) = out.last().copied() {
            let gap = slice.slice - below.slice - 1;
            for k in 0..gap {
                let mut between = below;
                between.join(&EngagedSlice { volume_mm3: 0.0, ..slice });
                let at = |part: u32| {
                    let t = f64::from(part) / f64::from(gap);
                    below.height[1] + t * (slice.height[0] - below.height[1])
                };
                out.push(EngagedSlice {
                    slice: below.slice + 1 + k,
                    height: [at(k), at(k + 1)],
                    volume_mm3: 0.0,
                    ..between
                });
            }
        }
        out.push(slice);
    }
    out
}

/// Slices as the force model takes them, at the feed of a sample.
pub(crate) fn cuts(sample: &EngagedSample, slices: &[EngagedSlice]) -> Vec<SliceCut> {
    let of = |s: &EngagedSlice| {
        let [feed_across, feed_down] = sample.feed_at(0.5 * (s.height[0] + s.height[1]));
        SliceCut { height: s.height, range: s.range, around: s.around, feed_across, feed_down }
    };
    slices.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proveout_geom::Vector;

    fn sample(k: u32, slices: &[(u32, [f64; 2])]) -> EngagedSample {
        let slice = |&(slice, range): &(u32, [f64; 2])| EngagedSlice {
            slice,
            height: [f64::from(slice), f64::from(slice) + 0.8],
            range: Some(range),
            around: false,
            across: [0.0, 1.0],
            volume_mm3: 1.0,
        };
        let at = 0.5 * f64::from(k);
        EngagedSample {
            block: k,
            tool: 0,
            speed_rpm: 1000.0,
            time: [at, at + 0.5],
            path: [at, at + 0.5],
            tip_way: 0.5,
            velocity: [Vector::x(), Vector::zeros()],
            axis: Vector::z(),
            slices: slices.iter().map(slice).collect(),
        }
    }

    #[test]
    fn ranges_are_those_of_the_neighbors_and_volumes_are_their_own() {
        // A step of engagement in the fourth sample of eight.
        let all: Vec<EngagedSample> =
            (0..8).map(|k| sample(k, &[(0, if k < 4 { [0.0, 0.5] } else { [0.0, 1.5] })])).collect();
        let exits: Vec<f64> = joined(&all, 0.4).iter().map(|s| s[0].range.map_or(0.0, |r| r[1])).collect();
        assert_eq!(exits, [0.5, 0.5, 0.5, 1.5, 1.5, 1.5, 1.5, 1.5]);
        assert!(joined(&all, 0.4).iter().flatten().all(|s| s.volume_mm3 == 1.0));
        // Another tool is no neighbor.
        let mut other = all;
        other[4].tool = 1;
        let exits: Vec<f64> = joined(&other, 0.4).iter().map(|s| s[0].range.map_or(0.0, |r| r[1])).collect();
        assert_eq!(exits[3], 0.5);
    }

    #[test]
    fn a_slice_that_no_ray_has_marked_takes_both_ranges() {
        let all = joined(&[sample(0, &[(0, [0.0, 0.5]), (3, [0.4, 1.5])])], 0.1);
        let have: Vec<(u32, Option<[f64; 2]>, f64)> = all[0].iter().map(|s| (s.slice, s.range, s.volume_mm3)).collect();
        let both = Some([0.0, 1.5]);
        assert_eq!(have, [(0, Some([0.0, 0.5]), 1.0), (1, both, 0.0), (2, both, 0.0), (3, Some([0.4, 1.5]), 1.0)]);
        let heights: Vec<[f64; 2]> = all[0].iter().map(|s| s.height).collect();
        assert!(heights.windows(2).all(|w| w[0][1] <= w[1][0] + 1e-12) && (heights[2][1] - 3.0).abs() < 1e-12);
    }
}
