//! A part of the tool in material, as one sweep through the stock has met it.

use proveout_controller::Piece;
use proveout_stock::SweepReport;
use proveout_tool::{Role, Tool};

use crate::{
    cut::tool_sweeps::{self, CuttingState, Swept},
    verdict::{
        finding::{Code, Finding, ToolPart},
        log::FindingLog,
    },
};

/// Judges the contact of one part of the tool.
pub(crate) trait ContactCheck {
    /// The finding of a contact; none where it is allowed, or of another part of the tool. Place and time are
    /// added by the caller.
    fn judge(&mut self, contact: &ToolContact<'_>) -> Option<Finding>;
}

/// A sweep that was deeper in material than a touch.
pub(crate) struct ToolContact<'a> {
    pub(crate) what: Swept,
    /// Number of the piece in the run.
    pub(crate) piece_id: u32,
    pub(crate) piece: &'a Piece,
    pub(crate) state: &'a CuttingState,
    pub(crate) tool: &'a Tool,
    pub(crate) report: &'a SweepReport,
    /// Clearance that the scene asks for, mm.
    pub(crate) near_miss_mm: f64,
}

/// Volumes that are printed as zero are left out, mm³.
const LEAST_VOLUME_MM3: f64 = 0.0005;

impl ToolContact<'_> {
    /// Name of the part.
    pub(crate) fn part(&self) -> &'static str {
        tool_sweeps::part_of_tool(self.what)
    }

    /// A finding about the part against the stock.
    pub(crate) fn finding(&self, code: &Code, message: String) -> Finding {
        let mut f = FindingLog::of(code, message);
        f.bodies = vec![format!("{}/{}", self.tool.name, self.part()), "stock".into()];
        let role = tool_sweeps::role_of(self.what);
        f.tool = self.state.tool.map(|tool| ToolPart { tool, role, body: 0, swept: true });
        f.point_mm = self.report.first_point.map(|p| [p.x, p.y, p.z]);
        f
    }

    /// The part meets material; `how` follows in the message, with a space before it.
    pub(crate) fn meets_material(&self, code: &Code, how: &str) -> Finding {
        // A body that clamps or carries the cutter is more often at the side of the material than
        // below it.
        let cuts = matches!(self.what, Swept::Body(Role::Cutting) | Swept::Entry | Swept::Core);
        let deep = if cuts { "mm deep" } else { "mm below the nearest free surface" };
        // Between the rays a depth is known, and no volume.
        let volume = match self.report.volume_mm3 {
            volume if volume >= LEAST_VOLUME_MM3 => format!(", {volume:.3} mm3 in this piece"),
            _ => String::new(),
        };
        let (part, depth) = (self.part(), tool_sweeps::depth(self.report));
        let message = format!("{part} of {} meets material{how}: {depth:.3} {deep}{volume}", self.tool.name);
        let mut f = self.finding(code, message);
        f.penetration_mm = Some(depth);
        f
    }
}
