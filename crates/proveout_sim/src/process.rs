//! From sweep reports to process findings: what met material, with which part of the tool, in which kind of motion.

use proveout_controller::{MoveKind, Piece};
use proveout_geom::Pose;
use proveout_nc::SpindleDirection;
use proveout_stock::{Action, SweepItem, SweepMotion, SweepReport};
use proveout_tool::{Profile, Role, Tool};

use crate::finding::{
    Code, HOLDER_IN_STOCK, NEAR_MISS, NECK_RUBS, RAPID_IN_MATERIAL, SHANK_RUBS, SPINDLE_OFF, SPINDLE_WRONG_WAY,
};

/// Spindle and tool while a piece is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CuttingState {
    /// Index of the tool in the library.
    pub(crate) tool: Option<usize>,
    /// Rotation.
    pub(crate) spindle: SpindleDirection,
    /// Speed, 1/min; zero when off.
    pub(crate) speed_rpm: f64,
}

/// What one sweep of one body of the tool stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SweepPart {
    /// Index of the piece within the batch.
    pub(crate) piece: usize,
    /// Role of the swept body.
    pub(crate) role: Role,
    /// The body widened by the wanted clearance, not the body itself.
    pub(crate) zone: bool,
}

/// The sweeps of a piece: the cutter removes, the rest is probed against what the cutter has left; `zones` are the parts
/// of the holder widened by the wanted clearance.
///
/// A cutter removes material at rapid rate too, so that one crash is one finding and does not spoil what follows; the
/// finding tells that it was a rapid.
#[expect(clippy::too_many_arguments, reason = "a piece, its tool, and the two lists that it adds to")]
pub(crate) fn sweeps<'a>(
    index: usize,
    id: u32,
    piece: &Piece,
    tool: &'a Tool,
    zones: &'a [Profile],
    work_from_table: &Pose,
    items: &mut Vec<SweepItem<'a>>,
    parts: &mut Vec<SweepPart>,
) {
    let [from, to] = piece.pose.map(|p| p.transformed(work_from_table));
    let motion = SweepMotion { from, to };
    for cutting in [true, false] {
        for body in tool.bodies.iter().filter(|b| (b.role == Role::Cutting) == cutting) {
            let action = if cutting { Action::Remove } else { Action::Probe };
            items.push(SweepItem { id, body: &body.profile, action, motion });
            parts.push(SweepPart { piece: index, role: body.role, zone: false });
        }
    }
    for zone in zones {
        items.push(SweepItem { id, body: zone, action: Action::Probe, motion });
        parts.push(SweepPart { piece: index, role: Role::Holder, zone: true });
    }
}

/// The code of what a sweep found; none when all is in order. `contact` is the overlap below which a body only touches
/// (mm).
pub(crate) fn judge_sweep(
    part: &SweepPart,
    kind: MoveKind,
    state: &CuttingState,
    tool: &Tool,
    report: &SweepReport,
    contact: f64,
) -> Option<Code> {
    if report.overlap_mm <= contact {
        return None;
    }
    match part.role {
        _ if part.zone => Some(NEAR_MISS),
        Role::Neck => Some(NECK_RUBS),
        Role::Shank => Some(SHANK_RUBS),
        Role::Holder => Some(HOLDER_IN_STOCK),
        Role::Cutting if kind == MoveKind::Rapid => Some(RAPID_IN_MATERIAL),
        Role::Cutting => match state.spindle {
            SpindleDirection::Off => Some(SPINDLE_OFF),
            SpindleDirection::Clockwise if tool.left_handed => Some(SPINDLE_WRONG_WAY),
            SpindleDirection::CounterClockwise if !tool.left_handed => Some(SPINDLE_WRONG_WAY),
            _ => None,
        },
    }
}
