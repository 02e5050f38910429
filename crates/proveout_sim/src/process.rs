//! From sweep reports to process findings: what met material, with which part of the tool, in which kind of motion.

use proveout_controller::MoveKind;
use proveout_nc::SpindleDirection;
use proveout_stock::{Action, Measure, SweepItem, SweepMotion, SweepReport};
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

/// Which body of a tool, or what beside it, is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swept {
    /// A body of the tool.
    Body(Role),
    /// A part of the holder, widened by the wanted clearance.
    Zone,
    /// The core round the axis of a tool that does not cut there, before its cutter comes.
    Core,
}

/// What one sweep stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SweepPart {
    /// Index of the piece within the batch.
    pub(crate) piece: usize,
    /// What is swept.
    pub(crate) what: Swept,
}

/// The sweeps of a batch, and what each stands for.
#[derive(Debug, Default)]
pub(crate) struct Sweeps<'a> {
    pub(crate) items: Vec<SweepItem<'a>>,
    pub(crate) measures: Vec<Measure>,
    pub(crate) parts: Vec<SweepPart>,
}

impl<'a> Sweeps<'a> {
    /// The sweeps of a piece: the cutter removes, the rest is probed against what the cutter has left; `zones` are the parts
    /// of the holder widened by the wanted clearance, `core` is that of a tool that goes down without edges there. `since` is the
    /// first piece of the run of motion in which the cutter must not meet material, where this is one of it.
    ///
    /// A cutter removes material at rapid rate too, so that one crash is one finding and does not spoil what follows; the
    /// finding tells that it was a rapid.
    pub(crate) fn add(
        &mut self,
        (index, id): (usize, u32),
        motion: SweepMotion,
        tool: &'a Tool,
        [zones, core]: [&'a [Profile]; 2],
        since: Option<u32>,
    ) {
        let mut put = |body: &'a Profile, action: Action, measure: Measure, what: Swept| {
            self.items.push(SweepItem { id, body, action, motion });
            self.measures.push(measure);
            self.parts.push(SweepPart { piece: index, what });
        };
        for body in core {
            put(body, Action::Probe, Measure::No, Swept::Core);
        }
        let depth = since.map_or(Measure::No, Measure::Since);
        for body in tool.cutting() {
            put(&body.profile, Action::Remove, depth, Swept::Body(body.role));
        }
        for body in tool.not_cutting() {
            put(&body.profile, Action::Probe, Measure::Alone, Swept::Body(body.role));
        }
        for zone in zones {
            put(zone, Action::Probe, Measure::Alone, Swept::Zone);
        }
    }
}

/// Why the cutter must not meet material in this motion; none in feed with the spindle turning its way.
pub(crate) fn fault(kind: MoveKind, state: &CuttingState, tool: &Tool) -> Option<Code> {
    match state.spindle {
        _ if kind != MoveKind::Feed => Some(RAPID_IN_MATERIAL),
        SpindleDirection::Off => Some(SPINDLE_OFF),
        // M3 without S, or S0: it is told to turn and does not.
        _ if state.speed_rpm <= 0.0 => Some(SPINDLE_OFF),
        SpindleDirection::Clockwise if tool.left_handed => Some(SPINDLE_WRONG_WAY),
        SpindleDirection::CounterClockwise if !tool.left_handed => Some(SPINDLE_WRONG_WAY),
        _ => None,
    }
}

/// How deep a sweep was in material, mm: measured where it is, else the longest overlap.
pub(crate) fn depth(report: &SweepReport) -> f64 {
    report.depth_mm.unwrap_or(report.overlap_mm)
}

/// The code of what a sweep found; none when all is in order. `contact` is the depth below which a body only touches
/// (mm).
pub(crate) fn judge_sweep(
    part: &SweepPart,
    kind: MoveKind,
    state: &CuttingState,
    tool: &Tool,
    report: &SweepReport,
    contact: f64,
) -> Option<Code> {
    if depth(report) <= contact {
        return None;
    }
    match part.what {
        Swept::Core => None,
        Swept::Zone => Some(NEAR_MISS),
        Swept::Body(Role::Neck) => Some(NECK_RUBS),
        Swept::Body(Role::Shank) => Some(SHANK_RUBS),
        Swept::Body(Role::Holder) => Some(HOLDER_IN_STOCK),
        Swept::Body(Role::Cutting) => fault(kind, state, tool),
    }
}
