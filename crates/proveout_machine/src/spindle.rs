//! The two ends of the kinematic chain: the spindle that holds the tool, and the table.

use proveout_geom::{Point, Pose, Vector};

use crate::Attachment;

/// The spindle.
#[derive(Clone, Debug, PartialEq)]
pub struct SpindleData {
    /// What carries it.
    pub attached_to: Attachment,
    /// Gauge line in M with all joints at zero: origin on the line's plane and the axis, +z from the tool to
    /// the spindle.
    pub gauge_pose: Pose,
    /// Highest speed, 1/min.
    pub max_speed_rpm: Option<f64>,
}

/// The surface that workpieces are clamped on.
#[derive(Clone, Debug, PartialEq)]
pub struct TableData {
    /// What carries it.
    pub attached_to: Attachment,
    /// Middle of the clamping surface in M with all joints at zero, thus in K, mm.
    pub point: Point,
    /// Unit vector out of the surface.
    pub normal: Vector,
}
