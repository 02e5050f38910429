//! Neck or shank of the tool rub on material ([`NECK_RUBS`], [`SHANK_RUBS`], gate `process`).
//!
//! Both carry no edges: what they meet, they rub on, in feed and at rapid rate. They are probed against what
//! the cutter has left. The limit of the depth is `tolerances.contact_mm`.

use proveout_tool::Role;

use crate::{
    checks::tool_contact::{ContactCheck, ToolContact},
    cut::tool_sweeps::Swept,
    verdict::finding::{Finding, NECK_RUBS, SHANK_RUBS},
};

/// See the module.
#[derive(Debug)]
pub(crate) struct NeckAndShank;

impl ContactCheck for NeckAndShank {
    fn judge(&mut self, contact: &ToolContact<'_>) -> Option<Finding> {
        let code = match contact.what {
            Swept::Body(Role::Neck) => NECK_RUBS,
            Swept::Body(Role::Shank) => SHANK_RUBS,
            _ => return None,
        };
        Some(contact.meets_material(&code, ""))
    }
}
