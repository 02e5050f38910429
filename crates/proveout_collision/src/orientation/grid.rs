//! Cells of the (tilt, yaw) grid.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proveout_geom::{Vector, sin_cos};

use super::contact::LocalFrame;

/// Part by which a number of rings or of halvings may round above a whole one.
const WHOLE: f64 = 1e-9;
/// Part by which a tilt may round above the largest one: the last ring is closed.
const CLOSED: f64 = 1e-12;
/// Added to the spread of a cell: rounding.
const ROUNDING: f64 = 1e-12;

/// A cell: tilts and yaws, radian; lower ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisCell {
    pub(crate) tilt: [f64; 2],
    pub(crate) yaw: [f64; 2],
}

/// The rings of a hemisphere up to a tilt.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AxisGrid {
    /// Height of a ring, radian.
    pub(crate) step: f64,
    /// Index of the first cell of each ring; one more at the end.
    pub(crate) starts: Vec<usize>,
    /// How often cells are halved along their tilt.
    pub(crate) levels: u32,
}

impl AxisGrid {
    /// Rings of at most `largest` up to `limit`, halved until they are at most `finest`, radian.
    pub(crate) fn new(limit: f64, largest: f64, finest: f64) -> Self {
        let rings = (limit / largest - WHOLE).ceil().max(1.0);
        let step = limit / rings;
        let levels = (step / finest * (1.0 - WHOLE)).log2().ceil().max(0.0) as u32;
        let mut starts = vec![0];
        for ring in 0..rings as usize {
            let length = TAU * ((ring as f64 + 0.5) * step).sin();
            // Yaws of a cell differ by at most 90 degrees: what the bound of the motion asks for, with room.
            let sectors = (length / step).ceil().max(4.0) as usize;
            starts.push(starts[ring] + sectors);
        }
        Self { step, starts, levels }
    }

    /// The cells before any is halved, ring by ring from the pole.
    pub(crate) fn roots(&self) -> impl Iterator<Item = AxisCell> + '_ {
        self.starts.windows(2).enumerate().flat_map(move |(ring, ends)| {
            let sectors = ends[1] - ends[0];
            (0..sectors).map(move |k| {
                let yaw = |k: usize| if k == sectors { PI } else { TAU * k as f64 / sectors as f64 - PI };
                AxisCell { tilt: [self.step * ring as f64, self.step * (ring + 1) as f64], yaw: [yaw(k), yaw(k + 1)] }
            })
        })
    }

    /// Number of the root cell of an axis; none beyond the largest tilt.
    pub(crate) fn root_of(&self, [tilt, yaw]: [f64; 2]) -> Option<usize> {
        let rings = self.starts.len() - 1;
        let ring = (tilt / self.step) as usize;
        let ring = if ring == rings && tilt <= self.step * rings as f64 * (1.0 + CLOSED) { rings - 1 } else { ring };
        let ends = self.starts.get(ring..ring + 2)?;
        let sectors = ends[1] - ends[0];
        let k = ((yaw + PI) / TAU * sectors as f64) as usize;
        Some(ends[0] + k.min(sectors - 1))
    }
}

/// What a cell is divided into: two or four, the lower ends first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Halving {
    Tilt,
    Both,
}

impl AxisCell {
    pub(crate) fn middle(&self) -> [f64; 2] {
        [0.5 * (self.tilt[0] + self.tilt[1]), 0.5 * (self.yaw[0] + self.yaw[1])]
    }

    /// A cell that is narrow along its ring, as near the pole, keeps its yaws; not so where the
    /// pole is a circle of poses.
    pub(crate) fn halving(&self, circle_at_pole: bool) -> Halving {
        if circle_at_pole {
            return Halving::Both;
        }
        let wide = self.tilt[1].min(FRAC_PI_2).sin() * (self.yaw[1] - self.yaw[0]);
        if wide < 0.75 * (self.tilt[1] - self.tilt[0]) { Halving::Tilt } else { Halving::Both }
    }

    pub(crate) fn parts(&self, halving: Halving) -> ([Self; 4], usize) {
        let [t, y] = self.middle();
        let (low, high) = ([self.tilt[0], t], [t, self.tilt[1]]);
        match halving {
            Halving::Tilt => {
                let [a, b] = [Self { tilt: low, ..*self }, Self { tilt: high, ..*self }];
                ([a, b, a, a], 2)
            }
            Halving::Both => {
                let (left, right) = ([self.yaw[0], y], [y, self.yaw[1]]);
                let all = [(low, left), (low, right), (high, left), (high, right)];
                (all.map(|(tilt, yaw)| Self { tilt, yaw }), 4)
            }
        }
    }

    /// Number among the parts of the one that holds an axis.
    pub(crate) fn part_of(&self, halving: Halving, [tilt, yaw]: [f64; 2]) -> usize {
        let [t, y] = self.middle();
        match halving {
            Halving::Tilt => usize::from(tilt >= t),
            Halving::Both => 2 * usize::from(tilt >= t) + usize::from(yaw >= y),
        }
    }

    /// Solid angle, steradian.
    pub(crate) fn solid_angle(&self) -> f64 {
        (self.tilt[0].cos() - self.tilt[1].cos()) * (self.yaw[1] - self.yaw[0])
    }

    /// Center and motion inside of the cell.
    pub(crate) fn spread(&self, frame: &LocalFrame) -> CellSpread {
        let [t, y] = self.middle();
        let pair = |a: f64| -> [f64; 2] {
            let (s, c) = sin_cos(a);
            [s, c]
        };
        let turned = |[s, c]: [f64; 2]| [c, -s];
        let (tc, yc) = (pair(t), pair(y));
        let (axis, lean) = (frame.direction(tc, yc), frame.direction(turned(tc), yc));
        let (mut chord, mut lean_chord) = (0.0_f64, 0.0_f64);
        // Both sides in yaw are alike.
        for tilt in self.tilt {
            let (tk, yk) = (pair(tilt), pair(self.yaw[1]));
            chord = chord.max((frame.direction(tk, yk) - axis).norm());
            lean_chord = lean_chord.max((frame.direction(turned(tk), yk) - lean).norm());
        }
        let halves = 0.5 * (self.tilt[1] - self.tilt[0] + self.yaw[1] - self.yaw[0]);
        CellSpread { axis, lean, chord: chord + ROUNDING, lean_chord: lean_chord + ROUNDING, turn: halves + ROUNDING }
    }

    /// The direction of the cell that is nearest to one of polar angle and yaw `at`: its tilt and yaw.
    pub(crate) fn nearest(&self, at: [f64; 2]) -> [f64; 2] {
        let from_middle = at[1] - self.middle()[1];
        let yaw = at[1] - TAU * (from_middle / TAU).round();
        if (self.yaw[0]..=self.yaw[1]).contains(&yaw) {
            return [at[0].clamp(self.tilt[0], self.tilt[1]), yaw];
        }
        // The nearest meridian of the two; on it the foot of the great circle across, kept in the cell.
        let (s, c) = sin_cos(at[0]);
        let on = |edge: f64| {
            let foot = (s * (at[1] - edge).cos()).atan2(c);
            let tilt = foot.clamp(self.tilt[0], self.tilt[1]);
            (s * tilt.sin() * (at[1] - edge).cos() + c * tilt.cos(), [tilt, edge])
        };
        let (a, b) = (on(self.yaw[0]), on(self.yaw[1]));
        if a.0 >= b.0 { a.1 } else { b.1 }
    }
}

/// The pose at the center of a cell and how far others of the cell are from it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellSpread {
    /// V.
    pub(crate) axis: Vector,
    /// e, the derivative of V by the tilt.
    pub(crate) lean: Vector,
    /// Largest |V' - V|.
    pub(crate) chord: f64,
    /// Largest |e' - e|.
    pub(crate) lean_chord: f64,
    /// Largest |t' - t| + |y' - y|, radian.
    pub(crate) turn: f64,
}

#[cfg(test)]
mod tests {
    use proveout_geom::Point;

    use super::*;

    fn frame() -> LocalFrame {
        LocalFrame {
            point: Point::origin(),
            along: Vector::x(),
            across: Vector::y(),
            normal: Vector::z(),
            curvature: None,
        }
    }

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn every_axis_lies_in_one_cell_and_solid_angles_sum_to_the_cap() {
        for (limit, largest, finest) in [(90.0, 16.0, 0.5), (90.0, 4.0, 2.0), (35.0, 40.0, 1.0), (1.0, 16.0, 2.0)] {
            let grid = AxisGrid::new(f64::to_radians(limit), f64::to_radians(largest), f64::to_radians(finest));
            let cells: Vec<AxisCell> = grid.roots().collect();
            let sum: f64 = cells.iter().map(AxisCell::solid_angle).sum();
            assert!((sum - TAU * (1.0 - f64::to_radians(limit).cos())).abs() < 1e-12);
            let height = grid.step / f64::from(1 << grid.levels);
            assert!(
                height <= f64::to_radians(finest) * 1.000_001
                    && (grid.levels == 0 || 2.0 * height > f64::to_radians(finest))
            );
            let mut state = 3;
            for n in 0..5000 {
                // Corners: the pole, the rim, the seam of yaw.
                let tilt = [0.0, f64::to_radians(limit)]
                    .get(n % 7)
                    .copied()
                    .unwrap_or(f64::to_radians(limit) * random(&mut state));
                let yaw = if n % 5 == 0 { -PI } else { TAU * random(&mut state) - PI };
                let root = grid.root_of([tilt, yaw]).expect("inside");
                let mut cell = cells[root];
                for _ in 0..grid.levels {
                    let halving = cell.halving(false);
                    let (parts, count) = cell.parts(halving);
                    let area: f64 = parts[..count].iter().map(AxisCell::solid_angle).sum();
                    assert!((area - cell.solid_angle()).abs() < 1e-14);
                    cell = parts[cell.part_of(halving, [tilt, yaw])];
                    let holds =
                        cell.tilt[0] <= tilt && tilt <= cell.tilt[1] && cell.yaw[0] <= yaw && yaw <= cell.yaw[1];
                    assert!(holds, "{cell:?} {tilt} {yaw}");
                }
            }
            assert_eq!(grid.root_of([f64::to_radians(limit) + 1e-3, 0.0]), None);
        }
    }

    #[test]
    fn no_axis_of_a_cell_is_farther_from_its_center_than_the_spread_says() {
        let grid = AxisGrid::new(FRAC_PI_2, 0.4, 0.01);
        let frame = frame();
        let mut state = 9;
        for root in grid.roots() {
            let mut cell = root;
            for level in 0..=grid.levels {
                let spread = cell.spread(&frame);
                let mut most = 0.0_f64;
                for n in 0..200 {
                    // Corners and edges of the cell, and its inside.
                    let share = |n: usize, state: &mut u64| [0.0, 1.0].get(n).copied().unwrap_or(random(state));
                    let (u, v) = (share(n % 4, &mut state), share(n / 4 % 4, &mut state));
                    let t = cell.tilt[0] + (cell.tilt[1] - cell.tilt[0]) * u;
                    let y = cell.yaw[0] + (cell.yaw[1] - cell.yaw[0]) * v;
                    let axis = frame.direction([t.sin(), t.cos()], [y.sin(), y.cos()]);
                    let lean = frame.direction([t.cos(), -t.sin()], [y.sin(), y.cos()]);
                    assert!(
                        (axis - spread.axis).norm() <= spread.chord && (lean - spread.lean).norm() <= spread.lean_chord
                    );
                    most = most.max((axis - spread.axis).norm());
                }
                assert!(most > 0.99 * spread.chord, "the bound is met at a corner");
                let halving = cell.halving(false);
                let (parts, count) = cell.parts(halving);
                if level < grid.levels {
                    cell = parts[(random(&mut state) * count as f64) as usize];
                }
            }
        }
    }

    #[test]
    fn the_nearest_axis_of_a_cell_is_that_of_many_samples() {
        let frame = frame();
        let mut state = 21;
        for n in 0..400 {
            let t0 = 1.3 * random(&mut state) * f64::from(u8::from(n % 6 > 0));
            let cell = AxisCell { tilt: [t0, t0 + 0.25], yaw: [2.0, 2.0 + 1.14 * random(&mut state)] };
            let at = [FRAC_PI_2 * random(&mut state), TAU * random(&mut state) - PI];
            let direction = |[t, y]: [f64; 2]| frame.direction([t.sin(), t.cos()], [y.sin(), y.cos()]);
            let found = (direction(cell.nearest(at)) - direction(at)).norm();
            let mut best = f64::MAX;
            for i in 0..=60 {
                for j in 0..=60 {
                    let t = cell.tilt[0] + (cell.tilt[1] - cell.tilt[0]) * f64::from(i) / 60.0;
                    let y = cell.yaw[0] + (cell.yaw[1] - cell.yaw[0]) * f64::from(j) / 60.0;
                    best = best.min((direction([t, y]) - direction(at)).norm());
                }
            }
            assert!(found <= best + 1e-12 && best - found < 0.03, "{found} {best}");
        }
    }
}
