//! The channel that the tool itself leaves: at which angles about the table axis it is free, proved for whole
//! blocks.
//!
//! [`super::FeasibleRegion::free_turns`] returns the free intervals of the angle at a ball center
//! *and* at all centers within a distance of it. Taken at the middle of a block with half its
//! length, they hold for the whole block. A schedule whose angles at both ends of the block are in
//! the same interval, and that runs straight between them, is free all along:
//!
//! ```text
//!   angle |   I_1   |   I_2    |        gate at a block's end: the part of I_k and I_(k+1) that both have
//!         | +-----+ | +------+ |        of each block the interval that holds the program's own axis;
//!         | |     |=|=|      | |        where that is not free, the one that has most in common with the
//!         | +-----+ | +------+ |        gate before
//! ```
//!
//! Long blocks are checked in parts of [`PART_MM`], so that the distance does not cost much of the
//! interval. Further wishes of a person or a process have names of their own: `lean_max`, the
//! largest angle between tool axis and normal. The scallop of a ball end does not depend on its
//! lean, so that no limit of scallop or roughness cuts the channel.
//!
//! *Not checked here*: head and table of the machine and travel of its slides, which the control
//! and `run` judge; and the rounding of programmed axes by the control, which a clearance of the
//! region covers.

use std::f64::consts::{PI, TAU};

use proveout_geom::Vector;

use super::{AxisTurn, Channel, RescheduleError, SectionPath, Surroundings};

/// A block is looked at in parts of at most this length, mm.
const PART_MM: f64 = 0.5;
/// Ball centers of a block are no farther from its chord than this, mm: rounding of a text, and the arc of a
/// ball that turns.
pub(super) const CHORD_MM: f64 = 0.005;
/// Axes between two blocks are no farther from the turn than this, radian: a great circle against a
/// circle of equal inclination.
pub(super) const CIRCLE: f64 = 2e-4;
/// An interval of angles as wide as this is a whole turn, radian: rounding.
pub(super) const WHOLE_TURN: f64 = TAU * (1.0 - 1e-12);
/// Largest part along the pole of the axes of a circle: a circle that is a point has no direction.
pub(super) const MOST_AXIAL: f64 = 1.0 - 1e-12;
/// Least amplitude of the lean over the angle: the cosine stays finite.
const LEAST_SIZE: f64 = 1e-12;

/// What limits the channel in addition to freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolChannel {
    /// Largest lean of the tool axis from the outward normal, radian.
    pub lean_max: f64,
}

fn near(angle: f64, to: f64) -> f64 {
    angle - TAU * ((angle - to) / TAU).round()
}

impl ToolChannel {
    /// The channel of a path.
    ///
    /// # Errors
    /// `reschedule-channel`: what the tool must not touch is not known, or nothing is free at some
    /// block; `reschedule-tool`: the free axes of the tool cannot be computed.
    pub fn channel(&self, path: &SectionPath, around: &Surroundings<'_>) -> Result<Channel, RescheduleError> {
        let region = around.region.ok_or_else(|| {
            let message = "what the tool must keep away from is not known";
            let help = "give the scene a part or fixtures, or take the channel of the clearance";
            RescheduleError::new("reschedule-channel", path.lines[0], message, help)
        })?;
        let n = path.len();
        let mut blocks: Vec<[f64; 2]> = Vec::with_capacity(n - 1);
        for i in 0..n - 1 {
            let mut free = vec![[-PI, PI]];
            let (a, b) = (path.centers[i], path.centers[i + 1]);
            let parts = ((b - a).norm() / PART_MM).ceil().max(1.0) as usize;
            for part in 0..parts {
                let at = (part as f64 + 0.5) / parts as f64;
                let tilts = [path.axial[i], path.axial[i + 1]].map(f64::asin);
                let turn = AxisTurn {
                    center: a + (b - a) * at,
                    drift: 0.5 * (b - a).norm() / parts as f64 + CHORD_MM,
                    basis: path.basis,
                    axial: (0.5 * (tilts[0] + tilts[1])).sin(),
                    spread: 0.5 * (tilts[1] - tilts[0]).abs() + CIRCLE,
                };
                let own = region.free_turns(&turn).ok_or_else(|| {
                    let message = "the free axes of this tool cannot be computed";
                    let help = "take a ball end mill, or the channel of the clearance";
                    RescheduleError::new("reschedule-tool", path.lines[i], message, help)
                })?;
                free = both(&free, &own);
            }
            let leans = [self.leans(path, around, i)?, self.leans(path, around, i + 1)?];
            free = leans.iter().fold(free, |free, lean| both(&free, std::slice::from_ref(lean)));
            let original = 0.5 * (path.axis_angle[i] + path.axis_angle[i + 1]);
            let Some(interval) = chosen(&free, original, blocks.last()) else {
                return Err(RescheduleError::new(
                    "reschedule-channel",
                    path.lines[i + 1],
                    format!(
                        "in this block no tool axis with a lean of at most {:.1} degrees is free at the inclination \
                         of {:.1} degrees of the program",
                        self.lean_max.to_degrees(),
                        (0.5 * (path.axial[i] + path.axial[i + 1])).asin().to_degrees()
                    ),
                    "set a larger lean_max_deg, take a slimmer or longer tool, or tilt the head differently",
                ));
            };
            blocks.push(interval);
        }
        let gate = |i: usize| {
            let (before, after) = (blocks[i.max(1) - 1], blocks[i.min(n - 2)]);
            [before[0].max(after[0]), before[1].min(after[1])]
        };
        let gates: Vec<[f64; 2]> = (0..n).map(gate).collect();
        if let Some(first) = gates.iter().position(|[low, high]| low > high) {
            return Err(RescheduleError::new(
                "reschedule-channel",
                path.lines[first],
                "the free axes before and after the end of this block have none in common",
                "set a larger lean_max_deg, take a slimmer or longer tool, or split the path here",
            ));
        }
        Ok(Channel { upper: gates.iter().map(|g| g[1]).collect(), lower: gates.iter().map(|g| g[0]).collect() })
    }

    /// Angles whose lean from the normal of a block is not too large.
    fn leans(&self, path: &SectionPath, around: &Surroundings<'_>, i: usize) -> Result<[f64; 2], RescheduleError> {
        let [u, v, w] = path.basis;
        // Across the chords, outward; of the surface itself where it is known.
        let across = 0.5 * (path.incoming[i] + path.outgoing[i]) - 0.5 * PI;
        let flat: Vector = u * across.cos() + v * across.sin();
        let surface = around.surface.and_then(|s| s.contact(&path.centers[i])).map(|c| c.normal);
        let normal = surface.filter(|n| n.dot(&flat) > 0.5).unwrap_or(flat);
        let (in_plane, along) = ([normal.dot(&u), normal.dot(&v)], normal.dot(&w));
        let size = in_plane[0].hypot(in_plane[1]) * (1.0 - path.axial[i] * path.axial[i]).max(0.0).sqrt();
        let cosine = (self.lean_max.cos() - along * path.axial[i]) / size.max(LEAST_SIZE);
        if cosine > 1.0 {
            return Err(RescheduleError::new(
                "reschedule-channel",
                path.lines[i],
                format!(
                    "the inclination of {:.1} degrees alone leans the tool by more than {:.1} degrees",
                    path.axial[i].asin().to_degrees(),
                    self.lean_max.to_degrees()
                ),
                "set a larger lean_max_deg, or tilt the head less",
            ));
        }
        let middle = near(in_plane[1].atan2(in_plane[0]), 0.0);
        let half = cosine.max(-1.0).acos();
        Ok([middle - half, middle + half])
    }
}

/// Intervals that are in both lists, modulo turns.
pub(super) fn both(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let whole = |i: &[f64; 2]| i[1] - i[0] >= WHOLE_TURN;
    let mut out = Vec::new();
    for x in a {
        for y in b {
            if whole(x) || whole(y) {
                out.push(if whole(x) { *y } else { *x });
                continue;
            }
            for turn in [-TAU, 0.0, TAU] {
                let common = [x[0].max(y[0] + turn), x[1].min(y[1] + turn)];
                if common[0] < common[1] {
                    out.push(common);
                }
            }
        }
    }
    out
}

/// The interval that holds an angle, turned next to it; else the one that has most in common with the
/// interval before, which then must be there.
fn chosen(free: &[[f64; 2]], original: f64, before: Option<&[f64; 2]>) -> Option<[f64; 2]> {
    let turned = |i: &[f64; 2], to: f64| {
        let off = near(0.5 * (i[0] + i[1]), to) - 0.5 * (i[0] + i[1]);
        [i[0] + off, i[1] + off]
    };
    let beside: Vec<[f64; 2]> = free.iter().map(|i| turned(i, original)).collect();
    if let Some(own) = beside.iter().find(|i| (i[0]..=i[1]).contains(&original)) {
        return Some(*own);
    }
    match before {
        None => {
            let off = |i: &[f64; 2]| (i[0] - original).max(original - i[1]);
            beside.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)))
        }
        Some(last) => {
            let common = |i: &[f64; 2]| i[1].min(last[1]) - i[0].max(last[0]);
            beside.into_iter().max_by(|a, b| common(a).total_cmp(&common(b)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_meet_across_turns_and_the_one_with_the_axis_is_taken() {
        let whole = [[-PI, PI]];
        assert_eq!(both(&whole, &[[1.0, 2.0]]), [[1.0, 2.0]]);
        let seam = both(&[[3.0, 4.0]], &[[-3.0, -2.5]]);
        assert_eq!(seam.len(), 1);
        assert!((seam[0][0] - (TAU - 3.0)).abs() < 1e-12 && (seam[0][1] - (TAU - 2.5)).abs() < 1e-12);
        let free = [[-1.0, 0.5], [1.0, 2.0]];
        let own = chosen(&free, TAU * 3.0 + 1.5, None).expect("one");
        assert!((own[0] - (TAU * 3.0 + 1.0)).abs() < 1e-12);
        // The axis itself is not free: on with the interval before.
        assert_eq!(chosen(&free, 0.7, Some(&[-0.9, 0.4])), Some([-1.0, 0.5]));
        assert_eq!(chosen(&free, 0.7, Some(&[1.2, 1.9])), Some([1.0, 2.0]));
        assert_eq!(chosen(&[], 0.7, None), None);
    }
}
