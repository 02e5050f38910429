//! The way through cells of turn and tilt from one end of a row to the other: dynamic programming over
//! stations.
//!
//! ```text
//!   tilt ^   station k        station k + 1       A state is a cell at a station. Between two stations
//!        |   +--+--+--+         +--+--+--+        the joints stay in the smallest rectangle that
//!        |   |  |c |  |  ====>  |  |  |c'|        holds both cells, and all of its cells are free for
//!        |   +--+--+--+         +--+--+--+        all blocks between the stations.
//!        +------------------> turn
//! ```
//!
//! The cost of a step is its time: that of its blocks, or what the faster joint needs at its
//! velocity, whichever is longer; with a small part of the squared speeds, so that of ways of the
//! same time the more even one is taken. Which side of the pole the way runs, whether it goes
//! through it, and on which branch, follows from that. Sums of blocked cells (F. C. Crow 1984,
//! Summed-area tables for texture mapping) give at once whether a rectangle is free.

/// Part of the squared speeds, as parts of the joints' velocities, in the cost.
const EVEN: f64 = 0.02;
/// Steps of more cells than this in a joint are not looked at.
const WIDEST_STEP: usize = 16;
/// Least width of a cell, radian: a range that is a point has one.
const LEAST_CELL: f64 = 1e-9;
/// How far inside of a cell its edges are taken, part of its width.
const HAIR: f64 = 1e-9;

/// A cell: places of turn and tilt.
pub(super) type Cell = [usize; 2];

/// Cells of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) low: f64,
    pub(super) step: f64,
    pub(super) count: usize,
}

impl Scale {
    /// As many cells of about a width as a range has room for.
    pub(super) fn new([low, high]: [f64; 2], width: f64) -> Self {
        let count = ((high - low) / width).ceil().max(1.0) as usize;
        Self { low, step: ((high - low) / count as f64).max(LEAST_CELL), count }
    }

    pub(super) fn edge(&self, at: usize) -> f64 {
        self.low + self.step * at as f64
    }

    pub(super) fn cell(&self, value: f64) -> usize {
        (((value - self.low) / self.step).floor().max(0.0) as usize).min(self.count - 1)
    }
}

/// The cells of a row of stations.
pub(super) struct StationCells {
    pub(super) scales: [Scale; 2],
    /// For each stretch between two stations: sums of blocked cells.
    blocked: Vec<Vec<u32>>,
}

/// Where a way ends that goes no farther.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct DeadEnd {
    /// The first stretch that nothing passes.
    pub(super) stretch: usize,
}

impl StationCells {
    pub(super) fn new(scales: [Scale; 2]) -> Self {
        Self { scales, blocked: Vec::new() }
    }

    fn width(&self) -> usize {
        self.scales[0].count + 1
    }

    /// Adds a stretch from the free cells, tilt by tilt.
    pub(super) fn push(&mut self, free: &[Vec<bool>]) {
        let width = self.width();
        let mut sums = vec![0_u32; width * (self.scales[1].count + 1)];
        for (tilt, row) in free.iter().enumerate() {
            let mut sum = 0;
            for (turn, free) in row.iter().enumerate() {
                sum += u32::from(!free);
                sums[(tilt + 1) * width + turn + 1] = sums[tilt * width + turn + 1] + sum;
            }
        }
        self.blocked.push(sums);
    }

    /// Whether all cells of a rectangle are free.
    pub(super) fn is_free(&self, stretch: usize, [a, b]: [Cell; 2]) -> bool {
        let Some(sums) = self.blocked.get(stretch) else { return false };
        let (left, right) = (a[0].min(b[0]), a[0].max(b[0]) + 1);
        let (low, high) = (a[1].min(b[1]), a[1].max(b[1]) + 1);
        let at = |tilt: usize, turn: usize| sums[tilt * self.width() + turn];
        at(high, right) + at(low, left) == at(high, left) + at(low, right)
    }

    /// The way of least cost from one of the first cells to one of the last ones: a cell for each station.
    /// `times` are those of the stretches, `velocities` those of the joints; cells that are not there count
    /// as all.
    ///
    /// # Errors
    /// The first stretch that no way passes.
    pub(super) fn way(
        &self,
        first: Option<&[Cell]>,
        last: Option<&[Cell]>,
        times: &[f64],
        velocities: [f64; 2],
    ) -> Result<Vec<Cell>, DeadEnd> {
        let [turns, tilts] = self.scales.map(|s| s.count);
        let mut costs = vec![f64::INFINITY; turns * tilts];
        match first {
            Some(cells) => cells.iter().for_each(|c| costs[c[1] * turns + c[0]] = 0.0),
            None => costs.fill(0.0),
        }
        let mut came: Vec<Vec<u32>> = Vec::with_capacity(times.len());
        for (stretch, time) in times.iter().enumerate() {
            let steps = StepCosts::new(self.scales, *time, velocities);
            let mut next = vec![f64::INFINITY; costs.len()];
            let mut from = vec![u32::MAX; costs.len()];
            for tilt in 0..tilts {
                for turn in 0..turns {
                    let cost = costs[tilt * turns + turn];
                    if !cost.is_finite() || !self.is_free(stretch, [[turn, tilt]; 2]) {
                        continue;
                    }
                    let [a, b] = steps.reach;
                    for to_tilt in tilt.saturating_sub(b)..(tilt + b + 1).min(tilts) {
                        for to_turn in turn.saturating_sub(a)..(turn + a + 1).min(turns) {
                            let sum = cost + steps.of(turn.abs_diff(to_turn), tilt.abs_diff(to_tilt));
                            let at = to_tilt * turns + to_turn;
                            if sum < next[at] && self.is_free(stretch, [[turn, tilt], [to_turn, to_tilt]]) {
                                next[at] = sum;
                                from[at] = (tilt * turns + turn) as u32;
                            }
                        }
                    }
                }
            }
            if next.iter().all(|c| c.is_infinite()) {
                return Err(DeadEnd { stretch });
            }
            came.push(from);
            costs = next;
        }
        let ends: Vec<usize> = match last {
            Some(cells) => cells.iter().map(|c| c[1] * turns + c[0]).collect(),
            None => (0..costs.len()).collect(),
        };
        let end = ends.into_iter().filter(|&i| costs[i].is_finite()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]));
        let Some(mut at) = end else { return Err(DeadEnd { stretch: times.len().saturating_sub(1) }) };
        let mut way = vec![[at % turns, at / turns]];
        for from in came.iter().rev() {
            at = from[at] as usize;
            way.push([at % turns, at / turns]);
        }
        way.reverse();
        Ok(way)
    }

    /// A free rectangle of a stretch that holds another one and cannot be made larger: grown by a cell to
    /// each side in turn.
    pub(super) fn grown(&self, stretch: usize, [a, b]: [Cell; 2]) -> [Cell; 2] {
        let mut low = [a[0].min(b[0]), a[1].min(b[1])];
        let mut high = [a[0].max(b[0]), a[1].max(b[1])];
        let mut grows = true;
        while grows {
            grows = false;
            for joint in 0..2 {
                if high[joint] + 1 < self.scales[joint].count {
                    let mut wider = high;
                    wider[joint] += 1;
                    if self.is_free(stretch, [low, wider]) {
                        (high, grows) = (wider, true);
                    }
                }
                if low[joint] > 0 {
                    let mut wider = low;
                    wider[joint] -= 1;
                    if self.is_free(stretch, [wider, high]) {
                        (low, grows) = (wider, true);
                    }
                }
            }
        }
        [low, high]
    }

    /// Lowest and highest positions of the joints in a rectangle, a hair inside.
    pub(super) fn limits(&self, [low, high]: [Cell; 2]) -> [[f64; 2]; 2] {
        [0, 1].map(|j| {
            let scale = &self.scales[j];
            let hair = HAIR * scale.step;
            [scale.edge(low[j]) + hair, scale.edge(high[j] + 1) - hair]
        })
    }
}

/// Costs of steps by their cells.
struct StepCosts {
    reach: [usize; 2],
    table: Vec<f64>,
}

impl StepCosts {
    fn new(scales: [Scale; 2], time: f64, velocities: [f64; 2]) -> Self {
        let part = [0, 1].map(|j| scales[j].step / (velocities[j] * time));
        let reach = part.map(|p| ((1.0 / p).ceil() as usize + 1).clamp(2, WIDEST_STEP));
        let mut table = Vec::with_capacity((reach[0] + 1) * (reach[1] + 1));
        for tilt in 0..=reach[1] {
            for turn in 0..=reach[0] {
                let used = [turn as f64 * part[0], tilt as f64 * part[1]];
                let slower = used[0].max(used[1]).max(1.0);
                let squares = (used[0] * used[0] + used[1] * used[1]) / (slower * slower);
                table.push(time * slower * (1.0 + EVEN * squares));
            }
        }
        Self { reach, table }
    }

    fn of(&self, turn: usize, tilt: usize) -> f64 {
        self.table[tilt * (self.reach[0] + 1) + turn]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(count: usize, stretches: usize) -> StationCells {
        let scale = Scale::new([0.0, count as f64], 1.0);
        let mut cells = StationCells::new([scale, scale]);
        for _ in 0..stretches {
            cells.push(&vec![vec![true; count]; count]);
        }
        cells
    }

    #[test]
    fn in_open_cells_the_way_is_even_and_takes_the_time_of_its_blocks() {
        let cells = open(12, 11);
        let way = cells.way(Some(&[[0, 3]]), Some(&[[11, 3]]), &[1.0; 11], [2.0; 2]).unwrap();
        assert_eq!(way, (0..12).map(|k| [k, 3]).collect::<Vec<_>>());
        // Ends that are free: nothing moves.
        let still = cells.way(None, None, &[1.0; 11], [2.0; 2]).unwrap();
        assert!(still.windows(2).all(|w| w[0] == w[1]));
    }

    #[test]
    fn a_wall_is_gone_round_where_it_has_a_gap_and_closes_the_way_where_it_has_none() {
        let count = 12;
        let scale = Scale::new([0.0, count as f64], 1.0);
        for gap in [Some(9), None] {
            let mut cells = StationCells::new([scale, scale]);
            for stretch in 0..11 {
                // From the fifth stretch on a wall runs across the turn.
                let row = |tilt: usize| (0..count).map(|turn| turn != 6 || Some(tilt) == gap || stretch < 4).collect();
                cells.push(&(0..count).map(row).collect::<Vec<Vec<bool>>>());
            }
            let found = cells.way(Some(&[[5, 2]]), Some(&[[7, 2]]), &[1.0; 11], [2.0; 2]).unwrap();
            for (stretch, pair) in found.windows(2).enumerate() {
                assert!(cells.is_free(stretch, [pair[0], pair[1]]), "{stretch}");
                let [low, high] = cells.grown(stretch, [pair[0], pair[1]]);
                assert!(cells.is_free(stretch, [low, high]) && low[0] <= pair[0][0] && high[1] >= pair[1][1]);
            }
        }
        let mut cells = StationCells::new([scale, scale]);
        for stretch in 0..11 {
            cells.push(&vec![vec![stretch != 7; count]; count]);
        }
        assert_eq!(cells.way(None, None, &[1.0; 11], [2.0; 2]), Err(DeadEnd { stretch: 7 }));
    }

    /// Against a search over all ways of a small row of random cells.
    #[test]
    fn the_way_is_the_cheapest_of_all() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        let (mut open, mut shut) = (0, 0);
        for _ in 0..200 {
            let scales = [Scale::new([0.0, 3.0], 1.0), Scale::new([0.0, 4.0], 2.0)];
            let mut cells = StationCells::new(scales);
            for _ in 0..3 {
                let row: Vec<Vec<bool>> = (0..2).map(|_| (0..3).map(|_| random() % 3 > 0).collect()).collect();
                cells.push(&row);
            }
            let times = [1.0, 0.5, 2.0];
            let steps: Vec<StepCosts> = times.iter().map(|t| StepCosts::new(scales, *t, [1.5, 3.0])).collect();
            let mut best = f64::INFINITY;
            for code in 0..6_usize.pow(4) {
                let at = |k: u32| [code / 6_usize.pow(k) % 3, code / 6_usize.pow(k) / 3 % 2];
                let mut cost = 0.0;
                for k in 0..3 {
                    let (a, b) = (at(k), at(k + 1));
                    let fits = cells.is_free(k as usize, [a, b]);
                    cost += if fits {
                        steps[k as usize].of(a[0].abs_diff(b[0]), a[1].abs_diff(b[1]))
                    } else {
                        f64::INFINITY
                    };
                }
                best = best.min(cost);
            }
            match cells.way(None, None, &times, [1.5, 3.0]) {
                Ok(way) => {
                    let cost: f64 = way
                        .windows(2)
                        .zip(&steps)
                        .map(|(w, s)| s.of(w[0][0].abs_diff(w[1][0]), w[0][1].abs_diff(w[1][1])))
                        .sum();
                    assert!((cost - best).abs() < 1e-12, "{cost} {best}");
                    open += 1;
                }
                Err(_) => {
                    assert!(best.is_infinite());
                    shut += 1;
                }
            }
        }
        assert!(open > 50 && shut > 5, "{open} {shut}");
    }
}
