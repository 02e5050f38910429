//! Collision-free tool axes at places along the motion, as observers get them.

use std::sync::Arc;

use proveout_collision::{OrientationMap, OrientationSettings};
use proveout_geom::{Point, Vector};

/// What was found.
#[derive(Clone, Debug)]
pub struct FreeAxes {
    /// What the maps were made with.
    pub settings: OrientationSettings,
    /// The ball counts as touching the design up to this distance, mm.
    pub touch_mm: f64,
    /// In order of time.
    pub places: Vec<FreePlace>,
    /// What was not looked at, and why.
    pub unchecked: Vec<String>,
}

impl FreeAxes {
    /// What was found, in a few sentences; [`Self::unchecked`] lists what was not looked at.
    pub fn words(&self) -> String {
        let Some(least) = self.places.iter().min_by(|a, b| a.room.total_cmp(&b.room)) else {
            return "No place was checked.".into();
        };
        let tight = self.places.iter().filter(|p| p.room <= 0.0).count();
        let at = least.line.as_ref().map_or_else(String::new, |(_, line)| format!(" (line {line})"));
        format!(
            "{} contact points of a ball end on the design. Smallest free angle around the programmed axis: \
             {:.1}°{at}; at {tight} the axis is not proven collision-free. Neck, shank and holder keep {} mm from \
             part and fixtures; the cutter goes at most {} mm into the part; machine and spindle are not checked. \
             Finest cells {:.1}°, tilts up to {:.0}°.",
            self.places.len(),
            least.room.to_degrees(),
            self.settings.clearance,
            self.settings.gouge,
            self.settings.finest_cell.to_degrees(),
            self.settings.tilt_limit.to_degrees(),
        )
    }
}

/// One place of the motion.
#[derive(Clone, Debug)]
pub struct FreePlace {
    /// When the tool is there, s.
    pub time_s: f64,
    /// File and line of its block.
    pub line: Option<(Arc<str>, u32)>,
    /// Name of the tool.
    pub tool: String,
    /// Contact on the ball's skin, workpiece frame, mm.
    pub point: Point,
    /// Axis of the tool there, workpiece frame.
    pub axis: Vector,
    /// Free, blocked and unknown axes.
    pub map: OrientationMap,
    /// All axes nearer than this to that of the program are proved free, radian.
    pub room: f64,
}
