//! Engagement of the cutter in a block.

use proveout_controller::Piece;
use proveout_nc::SpindleDirection;
use proveout_stock::Contact;
use proveout_tool::Tool;

use crate::cut::tool_sweeps::CuttingState;

/// How the cutter was engaged, judged on the stock as it stood at that moment: extremes over the pieces of a
/// block.
///
/// ```text
///    from the spindle, feed up; the cutter turns clockwise          from the side
///
///                feed                                                |   |
///          entry  ^  exit          entry 0, exit 180: slot           |   |_____  __ uncut
///            \.---|---./           entry 0, exit  90: up milling     |   |      ^
///           .'\  |  /'.           entry 90, exit 180: climb milling |   |      | axial depth
///     0° --(---\-+-/---)-- 180°                                     '---'______v_ cut
///           '.       .'           width: farthest touches to the
///             '-----'             left and to the right
/// ```
///
/// `proveout_stock::Contact` says how it is found, and how far it can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Engagement {
    /// Length of cutter, along its axis, that touches material: `a_p`, mm.
    pub axial_depth_mm: f64,
    /// Width across feed and axis: `a_e`, mm; none while the tool only moves along its axis.
    pub radial_width_mm: Option<f64>,
    /// Angle at which a tooth comes into material, rad: counted in the sense of the spindle, a quarter turn
    /// is in front, see the drawing. Smallest of the block.
    pub entry: Option<f64>,
    /// Angle at which it leaves it, rad. Largest of the block.
    pub exit: Option<f64>,
    /// Largest uncut chip thickness, mm: the way of the cutter's skin along its own normal from one
    /// tooth to the next, `f_z` sin(angle) sin(slope of the profile) in plane milling (Altintas
    /// 2012, chapter 2). From the actual feed; none without the number of flutes, or while the
    /// spindle is stopped. Run-out and the trochoid of the tooth are left out.
    pub chip_thickness_mm: Option<f64>,
}

impl Engagement {
    /// Of one piece of motion; `contact` is not empty.
    pub(crate) fn of_piece(contact: &Contact, piece: &Piece, state: &CuttingState, tool: &Tool) -> Self {
        let clockwise = match state.spindle {
            SpindleDirection::Clockwise => true,
            SpindleDirection::CounterClockwise => false,
            SpindleDirection::Off => !tool.left_handed,
        };
        let angles = contact.entry_and_exit(clockwise);
        let duration = piece.time[1] - piece.time[0];
        let teeth_per_s = tool.flutes.map(|n| f64::from(n) * state.speed_rpm / 60.0);
        let turning = state.spindle != SpindleDirection::Off && duration > 0.0;
        let chip = teeth_per_s.filter(|rate| *rate > 0.0 && turning).map(|rate| contact.advance / duration / rate);
        Self {
            axial_depth_mm: contact.axial_depth(),
            radial_width_mm: contact.radial_width(),
            entry: angles.map(|a| a[0]),
            exit: angles.map(|a| a[1]),
            chip_thickness_mm: chip,
        }
    }

    /// Extremes of both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let join = |a: Option<f64>, b: Option<f64>, pick: fn(f64, f64) -> f64| match (a, b) {
            (Some(a), Some(b)) => Some(pick(a, b)),
            (a, b) => a.or(b),
        };
        Self {
            axial_depth_mm: self.axial_depth_mm.max(other.axial_depth_mm),
            radial_width_mm: join(self.radial_width_mm, other.radial_width_mm, f64::max),
            entry: join(self.entry, other.entry, f64::min),
            exit: join(self.exit, other.exit, f64::max),
            chip_thickness_mm: join(self.chip_thickness_mm, other.chip_thickness_mm, f64::max),
        }
    }
}
