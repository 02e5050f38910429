//! What is free at the stretches of a row: stations, cells, and how far each cell is past the rules.

use super::cells::{DeadEnd, Scale, StationCells};
use super::freedom::Freedom;
use super::joints::{Angles, one_turn};
use super::{RescheduleError, RowContext};

/// Cells of turn and tilt, radian; the finer ones for the rules of a bull-nose, which leave a few degrees.
const CELLS: [f64; 2] = [5.0 * std::f64::consts::PI / 180.0, 2.0 * std::f64::consts::PI / 180.0];
const FINE_CELLS: [f64; 2] = [2.0 * std::f64::consts::PI / 180.0, 0.75 * std::f64::consts::PI / 180.0];
/// No more cells than this at a station, nor stations.
const MOST_CELLS: f64 = 8_000.0;
const MOST_STATIONS: usize = 100;
/// Stations where the rules of a bull-nose are looked at: each costs sections of the surface.
const MOST_JUDGED: usize = 15;
/// The search covers half a turn each way from the turns of the program; a sixth for the rules of a
/// bull-nose.
pub(super) const BESIDE: f64 = std::f64::consts::PI;
const BESIDE_RULES: f64 = std::f64::consts::FRAC_PI_3;
/// How far from the tilts of the program the first search reaches, radian.
pub(super) const BAND: f64 = 12.0 * std::f64::consts::PI / 180.0;
/// A second look about what was found: cells are so many times finer, within so many of the coarse ones.
const FINER: f64 = 4.0;
const BESIDE_FINE: f64 = 2.0;

/// What is free at the stretches of a row.
pub(super) struct Ground {
    pub(super) scales: [Scale; 2],
    /// Blocks at the stations.
    pub(super) nodes: Vec<usize>,
    /// How far cells are past the rules ([`Freedom::cells`]), stretch by stretch.
    excess: Vec<Vec<Vec<f64>>>,
    /// Lowest and highest tilt where there are others beyond.
    cut: [Option<f64>; 2],
}

impl Ground {
    /// Within a band of tilts around those of the program, radian, or over all tilts.
    pub(super) fn new(
        work: &RowContext<'_>,
        freedom: &Freedom<'_>,
        course: &[Angles],
        band: Option<f64>,
    ) -> Result<Self, RescheduleError> {
        let (scales, cut) = work.scales(freedom, course, band)?;
        let nodes = nodes(work, course.len());
        let all = scales.map(|s| 0..s.count);
        let excess = nodes.windows(2).map(|pair| freedom.cells(pair[0]..pair[1] + 1, scales, &all)).collect();
        Ok(Self { scales, nodes, excess, cut })
    }

    /// About a schedule, in cells of a part of the width of those that it was found in: what is farther from
    /// it than two of those is not looked at.
    pub(super) fn about(work: &RowContext<'_>, freedom: &Freedom<'_>, angles: &[Angles], coarse: [Scale; 2]) -> Self {
        let scales = coarse.map(|s| Scale::new([s.edge(0), s.edge(s.count)], s.step / FINER));
        let nodes = nodes(work, angles.len());
        let near = |pair: &[usize]| {
            [0, 1].map(|j| {
                let own = angles[pair[0]..=pair[1]].iter().map(|q| q[j]);
                let low = own.clone().fold(f64::INFINITY, f64::min) - BESIDE_FINE * coarse[j].step;
                let high = own.fold(f64::NEG_INFINITY, f64::max) + BESIDE_FINE * coarse[j].step;
                scales[j].cell(low)..scales[j].cell(high) + 1
            })
        };
        let excess = nodes.windows(2).map(|p| freedom.cells(p[0]..p[1] + 1, scales, &near(p))).collect();
        Self { scales, nodes, excess, cut: [None; 2] }
    }

    pub(super) fn is_cut(&self) -> bool {
        self.cut.iter().any(Option::is_some)
    }

    /// Whether a tilt is in the last cell before others that are not looked at.
    pub(super) fn at_cut(&self, tilt: f64) -> bool {
        let step = self.scales[1].step;
        self.cut[0].is_some_and(|low| tilt < low + step) || self.cut[1].is_some_and(|high| tilt > high - step)
    }

    /// Cells that keep the rules by a part of their limits.
    pub(super) fn cells(&self, margin: f64) -> StationCells {
        let mut cells = StationCells::new(self.scales);
        for stretch in &self.excess {
            let open = |row: &Vec<f64>| row.iter().map(|excess| *excess <= -margin).collect();
            cells.push(&stretch.iter().map(open).collect::<Vec<Vec<bool>>>());
        }
        cells
    }
}

/// Blocks at the stations of a row of so many.
fn nodes(work: &RowContext<'_>, count: usize) -> Vec<usize> {
    let most = if work.row.rules.is_some() { MOST_JUDGED } else { MOST_STATIONS };
    let stretches = (count - 1).min(most);
    (0..=stretches).map(|k| k * (count - 1) / stretches).collect()
}

impl RowContext<'_> {
    /// Cells of turn and tilt: of the tilt what the limits leave anywhere, within a band around
    /// those of the program where one is given; and where the band ends before the limits do.
    fn scales(
        &self,
        freedom: &Freedom<'_>,
        course: &[Angles],
        band: Option<f64>,
    ) -> Result<([Scale; 2], [Option<f64>; 2]), RescheduleError> {
        let widths = if self.row.rules.is_some() { FINE_CELLS } else { CELLS };
        let beside = if self.row.rules.is_some() { BESIDE_RULES } else { BESIDE };
        let turns = course.iter().map(|q| q[0]);
        let mut range =
            [turns.clone().fold(f64::INFINITY, f64::min) - beside, turns.fold(f64::NEG_INFINITY, f64::max) + beside];
        if let Some([low, high]) = self.joints.travel(0) {
            range = [range[0].max(low), range[1].min(high)];
        }
        let all = Scale::new(one_turn(self.joints.travel(1)), 0.5 * widths[1]);
        let some = |at: &usize| freedom.some_within(all.edge(*at) + 0.5 * all.step);
        let open: Vec<usize> = (0..all.count).filter(some).collect();
        let (Some(first), Some(last)) = (open.first(), open.last()) else {
            return Err(self.closed(DeadEnd { stretch: 0 }, &[0, 0], freedom, false));
        };
        // The program's own tilts are always included: where they are not free, the block is
        // reported.
        let own = |pick: fn(f64, f64) -> f64, start: f64| course.iter().map(|q| q[1]).fold(start, pick);
        let [low, high] = [own(f64::min, f64::INFINITY), own(f64::max, f64::NEG_INFINITY)];
        let mut tilts = [all.edge(*first).min(low), all.edge(last + 1).max(high)];
        let mut cut = [None; 2];
        if let Some(band) = band {
            // The other branch of both ends too: the way may go through the pole.
            let ends = [freedom.own.first(), freedom.own.last()].into_iter().flatten();
            let ends = ends.flat_map(|axis| self.joints.all(axis, [range, [all.low, all.edge(all.count)]]));
            let (low, high) = ends.fold((low, high), |(low, high), q| (low.min(q[1]), high.max(q[1])));
            let near = [low - band, high + band];
            cut = [(near[0] > tilts[0]).then_some(near[0]), (near[1] < tilts[1]).then_some(near[1])];
            tilts = [tilts[0].max(near[0]), tilts[1].min(near[1])];
        }
        let count = (range[1] - range[0]) / widths[0] * (tilts[1] - tilts[0]) / widths[1];
        let coarser = (count / MOST_CELLS).sqrt().max(1.0);
        Ok(([Scale::new(range, coarser * widths[0]), Scale::new(tilts, coarser * widths[1])], cut))
    }
}
