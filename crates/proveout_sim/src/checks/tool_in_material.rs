//! Parts of the tool in material: each sweep that is deeper than a touch is asked of the contact checks, in
//! the order of the sweeps.
//!
//! One walk over the sweeps serves all of them, so that their findings come in the order in which the parts
//! met material. A check of another contact is a file with a [`ContactCheck`] and a line in
//! [`ToolInMaterial::default`]; each kind of sweep belongs to one of them.
//!
//! Not decided: places between the rays of the stock where the search was not finished
//! ([`BetweenFacts`](crate::cut::tool_between_rays::BetweenFacts)).

use crate::{
    checks::{
        assumed_values::chosen_of_tool,
        check::{Check, RunEnd, StretchView},
        cutter_in_material::CutterInMaterial,
        holder_near_stock::HolderNearStock,
        neck_and_shank::NeckAndShank,
        tool_contact::{ContactCheck, ToolContact},
    },
    cut::tool_sweeps,
    verdict::log::FindingLog,
};

/// See the module.
pub(crate) struct ToolInMaterial {
    checks: [Box<dyn ContactCheck>; 3],
}

impl Default for ToolInMaterial {
    fn default() -> Self {
        Self { checks: [Box::new(CutterInMaterial), Box::new(NeckAndShank), Box::new(HolderNearStock::default())] }
    }
}

/// What is to be known of material that no ray has met.
const BETWEEN: &str = "; no ray of the stock passes through it: found from the shape of the raw stock and the cuts";

impl Check for ToolInMaterial {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        let tools = &view.prepared.tools;
        for (k, (part, report)) in view.parts.iter().zip(view.reports).enumerate() {
            if tool_sweeps::depth(report) <= view.contact_mm() {
                continue;
            }
            let (piece, state) = (&view.chunk.pieces[part.piece], &view.states[part.piece]);
            let Some((index, tool)) = state.tool.and_then(|t| Some((t, tools.tools.get(t)?))) else { continue };
            let contact = ToolContact {
                what: part.what,
                piece_id: view.first_id + part.piece as u32,
                piece,
                state,
                tool,
                report,
                near_miss_mm: view.near_miss_mm(),
            };
            let Some(mut finding) = self.checks.iter_mut().find_map(|check| check.judge(&contact)) else { continue };
            if view.between_rays.binary_search(&k).is_ok() {
                finding.message += BETWEEN;
            }
            finding.message += &chosen_of_tool(tools, index, tool_sweeps::role_of(part.what));
            log.push(view.at_piece(finding, piece, piece.time[0]));
        }
    }

    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        for (gate, open) in &end.between.left_out {
            open.iter().for_each(|words| log.leave_out(*gate, words.clone()));
        }
    }
}
