//! The holder meets the stock ([`HOLDER_IN_STOCK`], gate `collision`), or comes closer to it than the scene
//! asks ([`NEAR_MISS`], gate `near_miss`).
//!
//! The holder is probed against what the cutter has left, and so are its parts widened by
//! `tolerances.near_miss_mm`. A holder in material is no near miss of the same piece. The limit of the depth
//! is `tolerances.contact_mm`. Not decided: tools without a holder in the library; the gate names them.

use proveout_tool::Role;

use crate::{
    checks::tool_contact::{ContactCheck, ToolContact},
    cut::tool_sweeps::Swept,
    verdict::finding::{Finding, HOLDER_IN_STOCK, NEAR_MISS},
};

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct HolderNearStock {
    /// Last piece on which the holder was in material, by its number in the run.
    in_stock: Option<u32>,
}

impl ContactCheck for HolderNearStock {
    fn judge(&mut self, contact: &ToolContact<'_>) -> Option<Finding> {
        match contact.what {
            Swept::Body(Role::Holder) => {
                self.in_stock = Some(contact.piece_id);
                Some(contact.meets_material(&HOLDER_IN_STOCK, ""))
            }
            Swept::Zone if self.in_stock != Some(contact.piece_id) => {
                let (part, wanted) = (contact.part(), contact.near_miss_mm);
                let message = format!(
                    "{part} of {} comes closer to the stock than the required {wanted:.3} mm",
                    contact.tool.name
                );
                let mut f = contact.finding(&NEAR_MISS, message);
                (f.limit, f.unit) = (Some(wanted), Some("mm".into()));
                Some(f)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use proveout_controller::{MoveKind, Piece};
    use proveout_geom::{Point, ToolPose, Vector};
    use proveout_machine::JointValues;
    use proveout_nc::SpindleDirection;
    use proveout_stock::SweepReport;
    use proveout_tool::{Cutter, ToolBuilder};

    use super::*;
    use crate::cut::tool_sweeps::CuttingState;

    #[test]
    fn a_holder_in_material_is_no_near_miss_of_the_same_piece() {
        let tool = ToolBuilder::new(1, "BALL", Cutter::ball(8.0).expect("ball"), 10.0, 80.0).build().expect("tool");
        let at = ToolPose { tip: Point::origin(), axis: Vector::z() };
        let piece = Piece {
            time: [0.0, 1.0],
            block: 0,
            kind: MoveKind::Feed,
            joints: [JointValues::ZERO; 2],
            pose: [at, at],
            deviation: 0.0,
            edge_deviation: 0.0,
            joint_deviation: JointValues::ZERO,
            finer: None,
        };
        let state = CuttingState { tool: Some(0), spindle: SpindleDirection::Clockwise, speed_rpm: 1000.0 };
        let report = SweepReport { depth_mm: Some(0.5), ..SweepReport::default() };
        let mut check = HolderNearStock::default();
        let mut judge = |what, piece_id| {
            let (piece, state, tool, report) = (&piece, &state, &tool, &report);
            check.judge(&ToolContact { what, piece_id, piece, state, tool, report, near_miss_mm: 1.0 })
        };
        let near = judge(Swept::Zone, 6).expect("the zone is in material");
        assert_eq!((near.code.as_str(), near.limit), (NEAR_MISS.code, Some(1.0)));
        let hit = judge(Swept::Body(Role::Holder), 7).expect("the holder is");
        assert_eq!((hit.code.as_str(), hit.penetration_mm), (HOLDER_IN_STOCK.code, Some(0.5)));
        assert_eq!(hit.bodies, ["BALL/holder", "stock"]);
        assert_eq!(judge(Swept::Zone, 7), None);
        assert!(judge(Swept::Zone, 8).is_some(), "another piece");
        assert_eq!(judge(Swept::Body(Role::Shank), 8), None, "of another check");
    }
}
