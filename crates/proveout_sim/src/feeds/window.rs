//! Samples joined over a cell of path: what the rays of the neighbors have seen counts as well.
//!
//! A sample may hold too few rays to see where the material begins and ends. Over a cell of path each slice
//! has a ray on each side. Joining makes ranges wider, never narrower, and lets a step of engagement begin up
//! to a cell before the cutter meets it. A slice between two others that no ray has marked takes the range
//! of both.

use proveout_feeds::SliceCut;

use crate::cut::engaged_samples::{EngagedSample, EngagedSlice};

/// The slices of each sample with those of its neighbors within `reach` mm of path; same order as the samples.
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
