//! The bound over cells of both rotary joints, as it is written.

use proveout_controller::TwoAngles;
use proveout_reschedule::CellBound;
use serde::Serialize;

/// One of both joints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellJoint {
    /// Name.
    pub name: String,
    /// The tool axis turns right-handed about this by the joint's value, table frame, both joints at zero.
    pub direction: [f64; 3],
    /// Velocity limit.
    pub velocity_deg_s: f64,
    /// Number of cells, and their size.
    pub cells: usize,
    /// Size of a cell.
    pub size_deg: f64,
    /// Where the first cell begins.
    pub from_deg: f64,
    /// Positions of the new program at the stations.
    pub new_deg: Vec<f64>,
    /// Positions of the program before at the stations.
    pub original_deg: Vec<f64>,
}

/// A bound by dynamic programming, with a lower bound of the time to be in each cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellCertificate {
    /// The joint that carries the tool axis, and the one that turns both; of the outer one whole turns do not
    /// count.
    pub inner: CellJoint,
    /// The outer joint.
    pub outer: CellJoint,
    /// The tool axis with both joints at zero.
    pub zero: [f64; 3],
    /// The farthest that the method has turned an axis of the program before.
    pub stray_deg: f64,
    /// Angle about the axes of the program before that schedules keep to: the same, widened by the rounding
    /// of both joints.
    pub radius_deg: f64,
    /// Gates that were looked at.
    pub stations: Vec<usize>,
    /// Tool axis of the program before at the stations.
    pub axes: Vec<[f64; 3]>,
    /// Of each station its cells (`inner * cells of the outer joint + outer`).
    pub cells: Vec<Vec<usize>>,
    /// Of each station the least time to be in each of its cells, s.
    pub potentials_s: Vec<Vec<f64>>,
    /// The least of the last station.
    pub bound_s: f64,
    /// A schedule of the relaxation takes this; null where none was found.
    pub reached_s: Option<f64>,
}

impl CellCertificate {
    /// Of schedules with velocity limits that may be passed by a part; `feed` is what the feed proves between
    /// two gates. None where there are too many cells.
    pub(super) fn new(angles: &TwoAngles, passed: f64, feed: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut pair = angles.pair;
        pair.velocity = pair.velocity.map(|v| v * (1.0 + passed));
        let found = CellBound::new(&pair, &angles.caps, feed)?;
        let joint = |k: usize, direction: [f64; 3], from: f64| {
            let of = |all: &[[f64; 2]]| found.stations.iter().map(|&g| all[g][k].to_degrees()).collect();
            CellJoint {
                name: angles.names[k].clone(),
                direction,
                velocity_deg_s: angles.pair.velocity[k].to_degrees(),
                cells: found.counts[k],
                size_deg: found.size[k].to_degrees(),
                from_deg: from.to_degrees(),
                new_deg: of(&angles.after),
                original_deg: of(&angles.before),
            }
        };
        let width = found.counts[1];
        let ids = found.cells.iter().map(|row| row.iter().map(|([j, k], _)| j * width + k).collect());
        let potentials = found.cells.iter().map(|row| row.iter().map(|(_, t)| *t).collect());
        Some(Self {
            inner: joint(0, pair.inner.into(), found.from),
            outer: joint(1, pair.outer.into(), 0.0),
            zero: pair.zero.into(),
            stray_deg: angles.stray.to_degrees(),
            radius_deg: angles.caps.radius.to_degrees(),
            axes: found.stations.iter().map(|&g| angles.caps.middles[g].into()).collect(),
            cells: ids.collect(),
            potentials_s: potentials.collect(),
            bound_s: found.time,
            reached_s: found.reached,
            stations: found.stations,
        })
    }
}
