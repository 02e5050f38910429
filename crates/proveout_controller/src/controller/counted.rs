//! What F counts in a block that turns rotary axes without tool center point control.

use proveout_nc::{AXIS_LETTERS, Command, FeedCounts};

use super::Controller;
use crate::{mapping::Mapping, motion::BlockPath, shape::BlockShape};

/// Radii nearer than this to that of one degree a millimeter are the same, mm.
const SAME_MM: f64 = 1e-6;

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    /// Part of the programmed feed that is along the way of the block, where F counts the vector of several
    /// axes: the way over the length of the vector, so that the block takes the time that the vector takes at
    /// F.
    pub(super) fn feed_share(&self, path: &BlockPath, mapping: Mapping) -> f64 {
        let Some(counts) = self.state.feed_counts.filter(|_| mapping.tcp_length.is_none()) else { return 1.0 };
        let degrees = |r: &f64| *r == 0.0 || (r - FeedCounts::DEGREE_IS_MM).abs() < SAME_MM;
        if !path.tip_moves && counts.radius.iter().all(degrees) {
            return 1.0;
        }
        let way = |axis: usize| {
            let joint = self.device.machine.joint_for_letter(AXIS_LETTERS[axis]);
            joint.map_or(0.0, |joint| path.end[joint] - self.state.position.q[joint])
        };
        let straight = path.parts.iter().all(|part| matches!(part.shape, BlockShape::Line { .. }));
        let linear = if straight && counts.linear != [1.0; 3] {
            (0..3).map(|axis| (counts.linear[axis] * way(axis)).powi(2)).sum::<f64>()
        } else if path.tip_moves {
            path.length * path.length
        } else {
            0.0
        };
        let rotary = (0..3).map(|axis| (counts.radius[axis] * way(axis + 3)).powi(2)).sum::<f64>();
        let counted = (linear + rotary).sqrt();
        if counted > 0.0 && path.length > 0.0 { path.length / counted } else { 1.0 }
    }
}
