//! Which turns and tilts are free for a stretch of a row.
//!
//! A tilt is a circle of axes about the pole, so that everything that limits the axis is a list of intervals
//! of the turn. A *ring* is the axes of all tilts within half a cell of one; no axis of it is farther than
//! that from the circle. Each limit at a ring of half width h:
//!
//! - **lean from the normal, turn from the program's own axis, at most L**: the part of the circle within
//!   L - h
//! - **ball end: neck, shank, holder**: [`FeasibleRegion::free_turns`] with h as spread, for all ball centers
//!   of a part of the stretch: proved
//! - **bull-nose: gouge, strip, roughness of [`super::super::super::MultiScale`]**: measured from cell to
//!   cell, at the block in the middle of the stretch
//!
//! For a bull-nose the cells only show where to search; every block of the result is judged by
//! itself. For cutters that have no ball, the clearance of the bodies above the cutter is checked:
//! along a block no point moves by more than `|tip' - tip| + |V' - V| reach`. So a block is free
//! where the clearances of its ends together exceed that; otherwise its halves are checked.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use proveout_geom::{Point, ToolPose, Vector};

use super::super::super::multi_scale::{Judge, Measures, RowRules};
use super::super::super::tool_channel::{CHORD_MM, CIRCLE, MOST_AXIAL, WHOLE_TURN, both};
use super::super::super::{AxisTurn, FeasibleRegion};
use super::cells::Scale;
use super::joints::{Angles, TwoJoints};

/// Halvings of a block of which a clearance says too little.
const HALVINGS: u32 = 7;
/// Longest part of a stretch that the free turns of a ball are asked for at once, mm, or this part of the
/// row.
const PART_MM: f64 = 1.6;
const PART_OF_ROW: f64 = 1.0 / 400.0;
/// A clearance below this is looked for where it is only asked whether bodies meet, mm.
const MEETS: f64 = 1e-6;
/// Cells of turn and of tilt from one to the next in which the rules of a bull-nose are measured.
const JUDGED_CELLS: usize = 3;
/// Where the strip is past its limits by more than this part of them nothing else is measured.
const FAR: f64 = 0.15;
/// Rounding of angles, radian.
const ROUNDED: f64 = 1e-9;
/// By how much the rules of a bull-nose may be passed by rounding, as a part of their limits.
const RULES: f64 = 1e-9;
/// Two axes whose sum is shorter than this are opposite: none is half way.
const OPPOSITE: f64 = 1e-9;

/// Turns and tilts of a row that are free.
pub(super) struct Freedom<'a> {
    pub(super) joints: &'a TwoJoints<'a>,
    /// Blocks of the row: ball centers, or contacts of other cutters.
    pub(super) points: Vec<Point>,
    /// Normals of the surface, where it is known.
    pub(super) normals: Vec<Option<Vector>>,
    /// Axes of the program.
    pub(super) own: Vec<Vector>,
    pub(super) lean_max: f64,
    pub(super) turn_max: f64,
    /// A ball end with what it must keep away from.
    pub(super) ball: Option<(&'a dyn FeasibleRegion, f64)>,
    /// Bodies above a cutter without a ball, their reach from the tip, and the pose of a block with
    /// an axis.
    pub(super) bodies: Option<(&'a dyn FeasibleRegion, f64)>,
    pub(super) pose: &'a dyn Fn(usize, &Vector) -> ToolPose,
    pub(super) rules: Option<&'a RowRules>,
    pub(super) length: f64,
}

/// A circle of axes about the pole.
struct Ring {
    axial: f64,
    across: f64,
    /// Angle of the axis about the pole with the turn at zero.
    zero: f64,
}

impl Freedom<'_> {
    fn ring(&self, tilt: f64) -> Ring {
        let axis = self.joints.axis([0.0, tilt]);
        let [x, y, z] = self.joints.basis.map(|b| b.dot(&axis));
        // A circle that is a point has no direction; a little off it all directions are there.
        let axial = z.clamp(-MOST_AXIAL, MOST_AXIAL);
        Ring { axial, across: (1.0 - axial * axial).sqrt(), zero: y.atan2(x) }
    }

    /// Angles about the pole whose axes are within an angle of a direction.
    fn within(&self, ring: &Ring, direction: &Vector, angle: f64) -> Vec<[f64; 2]> {
        if angle >= PI {
            return vec![[-PI, PI]];
        }
        if angle < 0.0 {
            return Vec::new();
        }
        let [x, y, z] = self.joints.basis.map(|b| b.dot(direction));
        let size = x.hypot(y) * ring.across;
        let room = angle.cos() - ring.axial * z;
        if room <= -size {
            return vec![[-PI, PI]];
        }
        if room > size {
            return Vec::new();
        }
        let (middle, half) = (y.atan2(x), (room / size).acos());
        vec![[middle - half, middle + half]]
    }

    /// How far the cells of the turn, for each cell of the tilt, are past the rules at the blocks of a
    /// stretch: infinite where a cell is not free, minus infinite where it is and no rule is in force. Cells
    /// of turn and tilt outside of `near` are not looked at and count as not free.
    pub(super) fn cells(&self, blocks: Range<usize>, scales: [Scale; 2], near: &[Range<usize>; 2]) -> Vec<Vec<f64>> {
        let [turns, tilts] = scales;
        let parts = self.parts(&blocks);
        let row = |at: usize| -> Vec<f64> {
            if !near[1].contains(&at) {
                return vec![f64::INFINITY; turns.count];
            }
            let half = 0.5 * tilts.step;
            let ring = self.ring(tilts.edge(at) + half);
            let free = self.ring_intervals(&ring, half, &blocks, &parts);
            let of = |k: usize| {
                let [from, to] = [turns.edge(k) + ring.zero, turns.edge(k + 1) + ring.zero];
                let open = near[0].contains(&k) && free.iter().any(|i| holds(i, from, to));
                if open { f64::NEG_INFINITY } else { f64::INFINITY }
            };
            (0..turns.count).map(of).collect()
        };
        let mut cells: Vec<Vec<f64>> = (0..tilts.count).map(row).collect();
        let middle = blocks.start + blocks.len() / 2;
        let judge = self.rules.and_then(|r| r.judged.get(middle).filter(|j| **j).and_then(|_| r.judges.get(middle)));
        if let Some(judge) = judge {
            self.judge_cells(judge, scales, &mut cells);
        }
        cells
    }

    /// Puts the excess of the rules into free cells, from measures at every third cell each way: what they
    /// say is where to look.
    fn judge_cells(&self, judge: &Judge, [turns, tilts]: [Scale; 2], cells: &mut [Vec<f64>]) {
        let measured = |turn: usize, tilt: usize| {
            let at = |scale: &Scale, k: usize| scale.edge(k) + 0.5 * scale.step;
            judge.measures(&self.joints.axis([at(&turns, turn), at(&tilts, tilt)]), FAR)
        };
        let width = turns.count / JUDGED_CELLS + 2;
        let mut nodes: Vec<Option<Option<Measures>>> = vec![None; width * (tilts.count / JUDGED_CELLS + 2)];
        for (tilt, row) in cells.iter_mut().enumerate() {
            for (turn, cell) in row.iter_mut().enumerate().filter(|(_, cell)| **cell < f64::INFINITY) {
                let (a, b) = (turn / JUDGED_CELLS, tilt / JUDGED_CELLS);
                let part = |k: usize| (k % JUDGED_CELLS) as f64 / JUDGED_CELLS as f64;
                let (u, v) = (part(turn), part(tilt));
                let mut node = |i: usize, j: usize| {
                    *nodes[j * width + i].get_or_insert_with(|| measured(JUDGED_CELLS * i, JUDGED_CELLS * j))
                };
                let corners = [node(a, b), node(a + 1, b), node(a, b + 1), node(a + 1, b + 1)];
                let mean = match corners {
                    [Some(p), Some(q), Some(r), Some(s)] => Some(Measures::mean([
                        (p, (1.0 - u) * (1.0 - v)),
                        (q, u * (1.0 - v)),
                        (r, (1.0 - u) * v),
                        (s, u * v),
                    ])),
                    _ => measured(turn, tilt),
                };
                *cell = mean.map_or(f64::INFINITY, |m| judge.excess_of(&m));
            }
        }
    }

    /// Whether the limits of lean and turn leave any axis with a tilt at some block.
    pub(super) fn some_within(&self, tilt: f64) -> bool {
        let ring = self.ring(tilt);
        (0..self.own.len()).any(|i| {
            let lean = self.normals[i].is_none_or(|n| !self.within(&ring, &n, self.lean_max).is_empty());
            lean && (self.turn_max >= PI || !self.within(&ring, &self.own[i], self.turn_max).is_empty())
        })
    }

    /// Ball centers of a stretch in parts: middle and the largest distance from it.
    fn parts(&self, blocks: &Range<usize>) -> Vec<(Point, f64)> {
        let longest = (PART_OF_ROW * self.length).max(PART_MM);
        let mut parts = Vec::new();
        if self.ball.is_none() {
            return parts;
        }
        let mut start = blocks.start;
        while start + 1 < blocks.end {
            let mut end = start + 1;
            while end + 1 < blocks.end && (self.points[end + 1] - self.points[start]).norm() <= longest {
                end += 1;
            }
            let (a, b) = (self.points[start], self.points[end]);
            let pieces = if end == start + 1 { ((b - a).norm() / longest).ceil().max(1.0) as usize } else { 1 };
            for k in 0..pieces {
                let [from, to] = [k, k + 1].map(|k| a + (b - a) * (k as f64 / pieces as f64));
                let middle = nalgebra::center(&from, &to);
                let inner = if pieces == 1 { &self.points[start..=end] } else { &[from, to][..] };
                let far = inner.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
                parts.push((middle, far + CHORD_MM));
            }
            start = end;
        }
        parts
    }

    fn ring_intervals(&self, ring: &Ring, half: f64, blocks: &Range<usize>, parts: &[(Point, f64)]) -> Vec<[f64; 2]> {
        let mut free = vec![[-PI, PI]];
        for i in blocks.clone() {
            if let Some(normal) = &self.normals[i] {
                free = both(&free, &self.within(ring, normal, self.lean_max - half));
            }
            if self.turn_max < PI {
                free = both(&free, &self.within(ring, &self.own[i], self.turn_max - half));
            }
            if free.is_empty() {
                return free;
            }
        }
        let Some((region, _)) = self.ball else { return free };
        for (center, drift) in parts {
            let turn = AxisTurn {
                center: *center,
                drift: *drift,
                basis: self.joints.basis,
                axial: ring.axial,
                spread: half + CIRCLE,
            };
            free = both(&free, &region.free_turns(&turn).unwrap_or_default());
            if free.is_empty() {
                break;
            }
        }
        free
    }

    /// Whether a block of the row is free from end to end, joints straight between them.
    pub(super) fn block_is_free(&self, block: usize, from: Angles, to: Angles) -> bool {
        let ends = [(block, from), (block + 1, to)];
        if !ends.iter().all(|(i, q)| self.keeps(*i, *q)) {
            return false;
        }
        if self.ball.is_some() {
            return self.ball_is_free(block, from, to, HALVINGS);
        }
        let Some((region, reach)) = self.bodies else { return true };
        // What the program itself has stood in is not new.
        let stood = |i: usize| region.clearance_up_to(&(self.pose)(i, &self.own[i]), MEETS) <= 0.0;
        if stood(block) || stood(block + 1) {
            return true;
        }
        let poses = ends.map(|(i, q)| (self.pose)(i, &self.joints.axis(q)));
        let most = motion(reach, &poses);
        between(region, reach, poses.map(|p| (p, region.clearance_up_to(&p, most))), HALVINGS)
    }

    /// Limits that a block has of its own.
    fn keeps(&self, i: usize, q: Angles) -> bool {
        let axis = self.joints.axis(q);
        let within = |to: &Vector, most: f64| to.cross(&axis).norm().atan2(to.dot(&axis)) <= most + ROUNDED;
        let judged = self.rules.and_then(|r| r.judged.get(i).filter(|j| **j).and_then(|_| r.judges.get(i)));
        self.normals[i].as_ref().is_none_or(|n| within(n, self.lean_max))
            && (self.turn_max >= PI || within(&self.own[i], self.turn_max))
            && judged.is_none_or(|j| j.keeps(&axis, -RULES))
    }

    fn ball_is_free(&self, block: usize, from: Angles, to: Angles, halvings: u32) -> bool {
        let (a, b) = (self.points[block], self.points[block + 1]);
        self.ball_piece_is_free([a, b], [from, to], halvings)
    }

    fn ball_piece_is_free(&self, [a, b]: [Point; 2], [from, to]: [Angles; 2], halvings: u32) -> bool {
        let Some((region, _)) = self.ball else { return false };
        let half = 0.5 * (to[1] - from[1]).abs();
        let ring = self.ring(0.5 * (from[1] + to[1]));
        let turn = AxisTurn {
            center: nalgebra::center(&a, &b),
            drift: 0.5 * (b - a).norm() + CHORD_MM,
            basis: self.joints.basis,
            axial: ring.axial,
            spread: half + CIRCLE,
        };
        let free = region.free_turns(&turn).unwrap_or_default();
        let [low, high] = [from[0].min(to[0]) + ring.zero, from[0].max(to[0]) + ring.zero];
        if free.iter().any(|i| holds(i, low, high)) {
            return true;
        }
        let Some(halvings) = halvings.checked_sub(1) else { return false };
        let middle = nalgebra::center(&a, &b);
        let turned = [0, 1].map(|k| 0.5 * (from[k] + to[k]));
        self.ball_piece_is_free([a, middle], [from, turned], halvings)
            && self.ball_piece_is_free([middle, b], [turned, to], halvings)
    }

    /// Whether a schedule is free along the whole row.
    pub(super) fn is_free(&self, angles: &[Angles]) -> bool {
        self.first_taken(angles).is_none()
    }

    /// The first block that a schedule is not free in.
    pub(super) fn first_taken(&self, angles: &[Angles]) -> Option<usize> {
        angles.windows(2).enumerate().find(|(i, q)| !self.block_is_free(*i, q[0], q[1])).map(|(i, _)| i)
    }
}

/// Whether an interval holds angles from one to another, whole turns apart.
fn holds([low, high]: &[f64; 2], from: f64, to: f64) -> bool {
    if high - low >= WHOLE_TURN {
        return true;
    }
    let off = TAU * ((from - low) / TAU).floor();
    to - off <= *high
}

/// By how much a point of the bodies can move from one pose to another, mm; never zero.
fn motion(reach: f64, [a, b]: &[ToolPose; 2]) -> f64 {
    ((b.tip - a.tip).norm() + (b.axis - a.axis).norm() * reach).max(MEETS)
}

/// Whether bodies are free between two poses with their clearances, of which no more need be known than the
/// motion between them.
fn between(
    region: &dyn FeasibleRegion,
    reach: f64,
    [(a, near), (b, far)]: [(ToolPose, f64); 2],
    halvings: u32,
) -> bool {
    if near <= 0.0 || far <= 0.0 {
        return false;
    }
    if near + far > motion(reach, &[a, b]) {
        return true;
    }
    let Some(halvings) = halvings.checked_sub(1) else { return false };
    let Some(axis) = (a.axis + b.axis).try_normalize(OPPOSITE) else { return false };
    let middle = ToolPose { tip: nalgebra::center(&a.tip, &b.tip), axis };
    let most = motion(reach, &[a, middle]).max(motion(reach, &[middle, b]));
    let between_both = (middle, region.clearance_up_to(&middle, most));
    between(region, reach, [(a, near), between_both], halvings)
        && between(region, reach, [between_both, (b, far)], halvings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_holds_angles_whole_turns_away_and_none_across_its_ends() {
        assert!(holds(&[1.0, 2.0], 1.1 + TAU, 1.9 + TAU) && holds(&[-PI, PI], 40.0, 41.0));
        assert!(!holds(&[1.0, 2.0], 0.9, 1.5) && !holds(&[1.0, 2.0], 1.5 - TAU, 2.1 - TAU));
        assert!(holds(&[3.0, 4.0], 3.1 - TAU, 3.9 - TAU) && !holds(&[3.0, 4.0], 3.9, 3.1 + TAU));
    }
}
