//! What is swept: one body on one motion, and what it does to the stock.

use proveout_geom::ToolPose;
use proveout_tool::Profile;

/// A motion of a tool: the tip runs straight, the axis on the great circle, both uniform in time; frame of
/// the stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepMotion {
    /// Start.
    pub from: ToolPose,
    /// End.
    pub to: ToolPose,
}

/// What a motion does to the stock.
///
/// ```
/// use proveout_geom::{Aabb, Point, ToolPose, Vector};
/// use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
/// use proveout_tool::Cutter;
///
/// let block = Aabb { min: Point::new(0.0, 0.0, -10.0), max: Point::new(40.0, 20.0, 0.0) };
/// let mut stock = TriDexel::from_box(&block, 0.5, 1 << 30)?;
/// let tool = Cutter::flat(8.0)?.bodies(20.0)?.remove(0);
/// let at = |x: f64| ToolPose { tip: Point::new(x, 10.0, -2.0), axis: Vector::z() };
/// let motion = SweepMotion { from: at(-10.0), to: at(50.0) };
/// let reports = stock.sweep(&[SweepItem { id: 1, body: &tool, action: Action::Probe, motion }]);
/// // A rapid through 8 x 2 x 40 mm of material, which stays.
/// assert!((reports[0].volume_mm3 - 640.0).abs() < 1.0);
/// assert_eq!(stock.volume(), stock.initial_volume());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Takes away the material that the body meets.
    Remove,
    /// Leaves the stock as it is and reports what the body would overlap with.
    Probe,
}

/// One body on one motion.
#[derive(Clone, Copy, Debug)]
pub struct SweepItem<'a> {
    /// Remembered by every interval end that this motion makes; `u32::MAX` is taken for the initial surface.
    pub id: u32,
    /// The convex body, z from the programmed tip, mm.
    pub body: &'a Profile,
    /// Remove or probe.
    pub action: Action,
    /// The motion.
    pub motion: SweepMotion,
}
