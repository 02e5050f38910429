use proveout_geom::ToolPose;
use proveout_machine::{JointValues, Machine};

use crate::{jet::JointJet, rtcp::Rig};

/// How task coordinates become joints in a run, and which tool hangs in the spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mapping {
    /// Tool center point control with this tool length, mm; none: task coordinates are the joints.
    pub(crate) tcp_length: Option<f64>,
    /// Gauge length of the tool in the spindle, mm; zero for an empty spindle (the gauge line's center is the
    /// tip).
    pub(crate) tool_length: f64,
    /// Distance from its tip to the end of its cutting edges, mm; to the gauge line if the edges
    /// are not given.
    pub(crate) edge_length: f64,
}

/// The machine and the mapping in force.
#[derive(Clone, Copy)]
pub(crate) struct ActiveKinematics<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) rig: Option<&'a Rig>,
    pub(crate) mapping: Mapping,
}

impl ActiveKinematics<'_> {
    /// Joint positions with derivatives.
    pub(crate) fn joints(&self, task: &JointJet) -> JointJet {
        match (self.mapping.tcp_length, self.rig) {
            (Some(length), Some(rig)) => rig.joints(task, length).unwrap_or(*task),
            _ => *task,
        }
    }

    /// Joint positions alone.
    pub(crate) fn position(&self, task: &JointValues) -> JointValues {
        match (self.mapping.tcp_length, self.rig) {
            (Some(length), Some(rig)) => rig.position(task, length).unwrap_or(*task),
            _ => *task,
        }
    }

    /// Tip and axis in K of the tool in the spindle as the actual machine brings them: the control plans with
    /// the described one and knows nothing of its geometric errors.
    pub(crate) fn pose(&self, q: &JointValues) -> ToolPose {
        self.machine.actual_forward(q, self.mapping.tool_length)
    }

    pub(crate) fn is_tcp(&self) -> bool {
        self.mapping.tcp_length.is_some() && self.rig.is_some()
    }
}
