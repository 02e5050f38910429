//! What a reader may know of the machine: data set in its control, as work offsets are.

use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::settings::Settings;

/// Reference points of a machine (G28, G30), in machine coordinates of the axes: no work offset, no tool
/// length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferencePoints {
    /// Name of the machine, for messages; empty where none is known and every reference point is refused.
    pub machine: String,
    /// Bit i is set where the machine has axis i of [`crate::AXIS_LETTERS`].
    pub axes: u16,
    /// Bit i is set where axis i of [`crate::AXIS_LETTERS`] is a rotary axis without limits of travel.
    pub endless: u16,
    /// First reference point, that of G28; mm and radian. An axis without a value has none.
    pub first: AxisValues,
    /// Second reference point, that of G30 and G30 P2.
    pub second: AxisValues,
    /// Where a tool change drives the axes; an axis without a value stays.
    pub tool_change: AxisValues,
}

/// Kinematics that a program may switch on, as the machine lists them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Kinematics {
    /// Name of the machine, for messages.
    pub machine: String,
    /// Tool center point control: TRAORI, G43.4, G43.5, G234, M128, FUNCTION TCPM.
    pub tcp: bool,
    /// Tilted working planes with the tool turned upright on them: G68.2, G254, CYCLE800, PLANE, cycle 19.
    pub tilted_plane: bool,
}

/// A kinematics of [`Kinematics`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum KinematicsKind {
    Tcp,
    TiltedPlane,
}

impl Settings {
    /// Refuses a word that switches on what the machine does not list. Where no machine is known every
    /// kinematics is taken.
    pub(crate) fn check_kinematics(&self, kind: KinematicsKind, word: &str, span: Span) -> Result<(), Fault> {
        let Some(listed) = &self.kinematics else { return Ok(()) };
        let (has, what, value) = match kind {
            KinematicsKind::Tcp => (listed.tcp, "tool center point control", "tcp"),
            KinematicsKind::TiltedPlane => (listed.tilted_plane, "a tilted plane", "tilted-plane"),
        };
        if has {
            return Ok(());
        }
        let message =
            format!("`{word}` switches on {what}, which the kinematics of machine \"{}\" do not list", listed.machine);
        Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help(format!(
            "program positions of the axes; if the control has it, add \"{value}\" to `kinematics` in [control] of the machine file"
        )))
    }
}
