//! The path of the tip as the page shows it: lines in the workpiece frame, block by block, of bounded size.

use proveout_controller::MoveKind;
use proveout_geom::Point;
use proveout_sim::observer::{Batch, Setup};

use crate::{
    page_encoding::{DeltaWriter, quantize_u16},
    report::blocks::{Blocks, LineNumbers},
};

/// Most points that are kept: some 200 KB of page.
const MOST_POINTS: usize = 60_000;
/// Distance (mm) below which a point is left out at first; it doubles when there are too many.
const FIRST_STEP: f64 = 0.02;

/// The path, thinned while it grows.
#[derive(Clone, Debug)]
pub(crate) struct ToolPath {
    points: Vec<[f32; 3]>,
    /// First point of a stretch, its block, and whether it is rapid motion.
    stretches: Vec<(u32, u32, bool)>,
    step: f64,
    /// Stretches that were left out.
    pub(crate) left_out: u64,
}

impl Default for ToolPath {
    fn default() -> Self {
        Self { points: Vec::new(), stretches: Vec::new(), step: FIRST_STEP, left_out: 0 }
    }
}

fn apart(a: &[f32; 3], b: &[f32; 3]) -> f64 {
    (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

impl ToolPath {
    pub(crate) fn take(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) {
        let work_from_table = setup.table_from_work.inverse();
        let place = |p: &Point| {
            let p = work_from_table.point(p);
            [p.x as f32, p.y as f32, p.z as f32]
        };
        for piece in batch.pieces {
            let [from, to] = [place(&piece.pose[0].tip), place(&piece.pose[1].tip)];
            if !from.iter().chain(&to).all(|v| v.is_finite()) {
                continue;
            }
            let rapid = piece.kind == MoveKind::Rapid;
            if self.stretches.last().is_none_or(|(_, block, _)| *block != piece.block) {
                self.stretches.push((self.points.len() as u32, piece.block, rapid));
                self.points.push(from);
            }
            self.point(to);
            if self.points.len() > MOST_POINTS {
                self.thin();
            }
        }
    }

    /// The last point of a stretch moves along until it is far enough from the one before.
    fn point(&mut self, to: [f32; 3]) {
        let first = self.stretches.last().map_or(0, |s| s.0 as usize);
        let count = self.points.len();
        if count > first + 1 && apart(&self.points[count - 2], &self.points[count - 1]) < self.step {
            self.points[count - 1] = to;
        } else {
            self.points.push(to);
        }
    }

    /// Doubles the step; every other stretch goes where their ends alone are too many.
    fn thin(&mut self) {
        self.step *= 2.0;
        let old = Self { points: std::mem::take(&mut self.points), ..self.clone() };
        let stretches = std::mem::take(&mut self.stretches);
        let full = stretches.len() * 3 > MOST_POINTS;
        for (k, &(first, block, rapid)) in stretches.iter().enumerate() {
            let end = stretches.get(k + 1).map_or(old.points.len(), |s| s.0 as usize);
            let part = &old.points[first as usize..end];
            // The stretch under way stays: more of it may come.
            if full && k % 2 == 1 && k + 1 < stretches.len() {
                self.left_out += 1;
                continue;
            }
            self.stretches.push((self.points.len() as u32, block, rapid));
            self.points.push(part[0]);
            part[1..].iter().for_each(|p| self.point(*p));
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Distance of neighboring points below which one was left out, mm.
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// The path packed for the page, little endian:
    ///
    /// ```text
    /// u32 stretches, u32 points, f32 low[3], f32 size[3]         box of the points, mm
    /// varint    a stretch: zigzag of the difference to the line before
    /// varint    a stretch: 2 * points + 1 for rapid motion, zigzag of the difference
    /// varint    x of all points, 0..=65535 in the box, differences; then y, then z
    /// ```
    pub(crate) fn pack(&self, blocks: &Blocks, numbers: &LineNumbers) -> Vec<u8> {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for p in &self.points {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
            }
        }
        if self.points.is_empty() {
            (low, high) = ([0.0; 3], [1.0; 3]);
        }
        let size = [0, 1, 2].map(|k| high[k] - low[k]);
        let mut out = Vec::new();
        out.extend((self.stretches.len() as u32).to_le_bytes());
        out.extend((self.points.len() as u32).to_le_bytes());
        low.iter().chain(&size).for_each(|v| out.extend(v.to_le_bytes()));
        let mut steps = DeltaWriter::default();
        for (_, block, _) in &self.stretches {
            steps.put(i64::from(numbers.at(blocks.of_block(*block))), &mut out);
        }
        let mut steps = DeltaWriter::default();
        for (k, (first, _, rapid)) in self.stretches.iter().enumerate() {
            let end = self.stretches.get(k + 1).map_or(self.points.len() as u32, |s| s.0);
            steps.put(i64::from(2 * (end - first) + u32::from(*rapid)), &mut out);
        }
        for k in 0..3 {
            let mut steps = DeltaWriter::default();
            for p in &self.points {
                let place = quantize_u16(f64::from(p[k]), f64::from(low[k]), f64::from(size[k]));
                steps.put(i64::from(place), &mut out);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A helix cut into short blocks, one stretch for each.
    fn helix(blocks: u32, each: u32) -> ToolPath {
        let mut path = ToolPath::default();
        for k in 0..blocks * each {
            let t = f64::from(k) * 0.01;
            let p = [(20.0 * t.cos()) as f32, (20.0 * t.sin()) as f32, (0.1 * t) as f32];
            if k % each == 0 {
                path.stretches.push((path.points.len() as u32, k / each, false));
                path.points.push(p);
            } else {
                path.point(p);
            }
            if path.points.len() > MOST_POINTS {
                path.thin();
            }
        }
        path
    }

    #[test]
    fn a_long_path_stays_small_and_keeps_its_form() {
        let path = helix(50, 20_000);
        assert!(path.points.len() <= MOST_POINTS && path.points.len() > MOST_POINTS / 8 && path.stretches.len() == 50);
        assert_eq!(path.left_out, 0);
        for p in &path.points {
            assert!((p[0].hypot(p[1]) - 20.0).abs() < 1e-4);
        }
        // Within a stretch neighbors are as far apart as the step says, but for the last ones.
        let gaps = path.points[..500].windows(2).map(|w| apart(&w[0], &w[1]));
        assert!(gaps.fold(0.0, f64::max) < 4.0 * path.step + 0.2);
    }

    #[test]
    fn more_blocks_than_points_are_counted() {
        let path = helix(80_000, 2);
        assert!(path.points.len() <= MOST_POINTS && path.left_out > 0);
        let first = path.stretches.iter().map(|s| s.0).collect::<Vec<_>>();
        assert!(first.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn an_empty_path_packs() {
        let bytes = ToolPath::default().pack(&Blocks::default(), &LineNumbers::default());
        assert_eq!((bytes.len(), &bytes[..8]), (32, &[0; 8][..]));
    }
}
