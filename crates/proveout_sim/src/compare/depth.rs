//! How deep a program cuts along its lines: from the poses of the cutter that cut the part, by the nearest
//! point of the closed form.
//!
//! A ball touches the surface that it leaves where its center comes nearest to the design: the distance of
//! the two less the radius is what stays there, exactly, whatever rays see of the groove. With the material
//! that the raw blade has more than the design, the depth of the cut is
//!
//! ```text
//!   depth = allowance - (|center - nearest point| - radius)    below zero: the ball is outside the raw blade
//! ```
//!
//! at the end of every piece of the motion, weighed with the way of the tip along it. The pieces are those
//! that cut the part: with drives in the loop, the actual ones. A line is one run in feed; its ends are left
//! out with the rest of what is no cutting stretch.

use super::result::Depth;
use crate::{
    prepare::{
        depth_gauge::Deep,
        motion_only::{FeedBlock, Motion},
    },
    units::UM_PER_MM,
};

/// Depths over the cutting stretch, micrometer; none where a tool was no ball or nothing was measured.
pub(super) fn depth_of(motion: &Motion, stretch: &[std::ops::Range<usize>]) -> Option<Depth> {
    let (mut all, mut worst) = (Sums::default(), 0.0_f64);
    let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
    for range in stretch {
        let blocks: &[FeedBlock] = motion.blocks.get(range.clone()).unwrap_or_default();
        let mut line = Sums::default();
        for deep in blocks.iter().flat_map(|b| &b.deep) {
            line.add(deep);
            least = least.min(deep.depth);
            most = most.max(deep.depth);
        }
        worst = worst.max(line.deviation()?);
        all.join(&line);
    }
    Some(Depth {
        places: all.places,
        mean_um: UM_PER_MM * all.mean()?,
        deviation_um: UM_PER_MM * worst,
        least_um: UM_PER_MM * least,
        most_um: UM_PER_MM * most,
    })
}

/// Sums over places, weighed with their ways. The square's mean is taken from a middle near all depths, so
/// that no digits are lost.
#[derive(Default)]
struct Sums {
    places: u64,
    middle: f64,
    way: f64,
    first: f64,
    second: f64,
}

impl Sums {
    fn add(&mut self, deep: &Deep) {
        if self.places == 0 {
            self.middle = deep.depth;
        }
        let off = deep.depth - self.middle;
        self.places += 1;
        self.way += deep.way;
        self.first += deep.way * off;
        self.second += deep.way * off * off;
    }

    fn join(&mut self, other: &Self) {
        if self.places == 0 {
            self.middle = other.middle;
        }
        let shift = other.middle - self.middle;
        self.places += other.places;
        self.way += other.way;
        self.first += other.first + shift * other.way;
    }

    fn mean(&self) -> Option<f64> {
        (self.way > 0.0).then(|| self.middle + self.first / self.way)
    }

    /// Standard deviation about the line's own mean.
    fn deviation(&self) -> Option<f64> {
        let mean = (self.way > 0.0).then(|| self.first / self.way)?;
        Some((self.second / self.way - mean * mean).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proveout_controller::Summary;
    use proveout_geom::Point;
    use proveout_machine::JointValues;

    use super::*;

    fn block(run: u32, deep: &[(f64, f64)]) -> FeedBlock {
        FeedBlock {
            run,
            time: [0.0, 1.0],
            programmed: 1.0,
            length: deep.iter().map(|(way, _)| way).sum(),
            end: JointValues::ZERO,
            tip: Point::origin(),
            center: None,
            high: [JointValues::ZERO; 3],
            index: 0,
            deep: deep.iter().map(|(way, depth)| Deep { way: *way, depth: *depth }).collect(),
        }
    }

    #[test]
    fn places_count_by_their_way_and_lines_have_their_own_mean() {
        // Line 1: 0.1 over 3 mm, 0.2 over 1 mm: mean 0.125, deviation sqrt(3/16) / 10. Line 2: 0.3
        // throughout.
        let blocks = vec![block(1, &[(3.0, 0.1)]), block(1, &[(1.0, 0.2)]), block(2, &[(4.0, 0.3)])];
        let motion = Motion {
            summary: Summary::default(),
            blocks,
            programmed: Vec::new(),
            over_travels: Vec::new(),
            reversals: BTreeMap::new(),
        };
        let depth = depth_of(&motion, &motion.stretch(0.0)).expect("measured");
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{depth:?}: {a} is not {b}");
        assert_eq!(depth.places, 3);
        close(depth.mean_um, 1e3 * (4.0 * 0.125 + 4.0 * 0.3) / 8.0);
        close(depth.deviation_um, 100.0 * (3.0_f64 / 16.0).sqrt());
        close(depth.least_um, 100.0);
        close(depth.most_um, 300.0);
        let none = Motion { blocks: vec![block(1, &[])], ..motion };
        assert!(depth_of(&none, &none.stretch(0.0)).is_none(), "nothing measured is not zero");
    }
}
