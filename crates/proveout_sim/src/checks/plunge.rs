//! A tool without edges at its center goes down into material ([`PLUNGE`], gate `process`).
//!
//! [`descent`](crate::checks::descent) follows the tools and has the derivation of the limits: the steepest
//! ramp that the tool library gives (`max_ramp_angle_deg`), and what it leaves under the tool. A block that
//! has ended is judged with its slope as programmed, since the control rounds the corners of the path.
//!
//! Not decided: ways down of a tool of which the library does not state whether it may make them. The
//! steepest of each tool is left out of the gate, with its line.

use std::{collections::BTreeMap, sync::Arc};

use proveout_controller::Piece;
use proveout_stock::SweepReport;
use proveout_tool::Tool;

use crate::{
    checks::{
        block_slope::BlockEnds,
        check::{Check, RunEnd, StretchView},
        descent::{Judgement, PlungeWatch},
    },
    cut::tool_sweeps::{CuttingState, Swept},
    verdict::{
        finding::{Finding, PLUNGE},
        gate::Gate,
        log::FindingLog,
    },
};

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct Plunge {
    watch: PlungeWatch,
    block_ends: BlockEnds,
    /// By place of the tool in the library.
    unknown: BTreeMap<usize, UnknownPlunge>,
}

/// The steepest way down into material of a tool that may not be allowed, and where.
#[derive(Clone, Copy, Debug)]
struct UnknownPlunge {
    angle: f64,
    block: u32,
}

impl Check for Plunge {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        let sweeps = view.parts.iter().zip(view.reports);
        let mut cores = sweeps.filter(|(part, _)| part.what == Swept::Core).peekable();
        for (i, (piece, state)) in view.chunk.pieces.iter().zip(view.states).enumerate() {
            let met = cores.next_if(|(part, _)| part.piece == i).map(|(_, report)| report);
            if let Some(finding) = self.judge(view, piece, state, met) {
                log.push(finding);
            }
        }
        self.block_ends.keep(view.chunk);
    }

    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        for (tool, steepest) in &self.unknown {
            log.leave_out(Gate::Process, not_decided(&end.prepared.tools.tools[*tool], steepest, end.places));
        }
    }
}

impl Plunge {
    /// Follows the tool along a piece; `met` is what its core met, where it goes down.
    fn judge(
        &mut self,
        view: &StretchView<'_>,
        piece: &Piece,
        state: &CuttingState,
        met: Option<&SweepReport>,
    ) -> Option<Finding> {
        let index = state.tool?;
        let tool = view.prepared.tools.tools.get(index)?;
        let core = view.cutters.core(index)?;
        let contact = view.contact_mm();
        let descent = self.watch.follow((index, tool), piece, met, core, contact)?;
        let measured = descent.angle;
        let (descent, shown) = if BlockEnds::has_ended(view.chunk, piece.block) {
            let descent = descent.with_slope(self.block_ends.slope(view.chunk, piece.block));
            (descent, descent.angle)
        } else {
            (descent.without_rounding(), measured)
        };
        match descent.judged(tool, contact) {
            Judgement::Allowed => None,
            Judgement::Unknown => {
                let steepest = self.unknown.entry(index).or_insert(UnknownPlunge { angle: 0.0, block: piece.block });
                if shown > steepest.angle {
                    *steepest = UnknownPlunge { angle: shown, block: piece.block };
                }
                None
            }
            Judgement::Fault { angle, stub } => {
                let left = if tool.dead_center.is_some() { descent.pillar } else { descent.stub };
                let mut f = view.at_piece(finding(tool, shown, angle, [left, stub]), piece, piece.time[0]);
                f.point_mm = met.and_then(|r| r.first_point).map(|p| [p.x, p.y, p.z]);
                Some(f)
            }
        }
    }
}

/// What is known of a way down that is not allowed: its angle or its stub, each with its limit.
fn finding(tool: &Tool, angle: f64, limit: f64, [stub, most]: [f64; 2]) -> Finding {
    let name = &tool.name;
    let (angle_deg, limit_deg) = (angle.to_degrees(), limit.to_degrees());
    let ramp = match tool.max_ramp_angle {
        Some(_) => format!("its maximum ramp angle is {limit_deg:.3} degrees"),
        None => "its maximum ramp angle is not stated".to_owned(),
    };
    let steep = angle > limit;
    let aside = if tool.dead_center.is_some() { "the region without edges" } else { "its radius" };
    let message = if steep {
        format!("{name} is not center-cutting and plunges into material at {angle_deg:.3} degrees; {ramp}")
    } else {
        format!(
            "{name} is not center-cutting and leaves a stub of {stub:.3} mm under it: it plunges without moving sideways by \
             {aside}; {ramp}, which leaves {most:.3} mm"
        )
    };
    let mut f = FindingLog::of(&PLUNGE, message);
    f.bodies = vec![name.clone()];
    if steep {
        f.value = Some(angle_deg);
        (f.limit, f.unit) = (tool.max_ramp_angle.map(|_| limit_deg), Some("deg".into()));
    } else {
        (f.value, f.limit, f.unit) = (Some(stub), Some(most), Some("mm".into()));
    }
    f
}

/// What was not decided of the steepest way down of a tool, with its place in the program.
fn not_decided(tool: &Tool, plunge: &UnknownPlunge, places: &[Option<(Arc<str>, u32)>]) -> String {
    let at = places.get(plunge.block as usize).and_then(Option::as_ref);
    let at = at.map_or_else(String::new, |(file, line)| format!(" ({file}:{line})"));
    let missing = match (tool.center_cutting, tool.max_ramp_angle) {
        (None, _) => "center_cutting",
        (_, None) => "max_ramp_angle_deg",
        _ => "dead_center_diameter_mm",
    };
    let (name, angle) = (&tool.name, plunge.angle.to_degrees());
    format!(
        "whether {name} may plunge into material at {angle:.1} degrees{at}: the tool library gives no `{missing}` for it"
    )
}
