//! The cutter meets material where it must not cut ([`RAPID_IN_MATERIAL`], [`SPINDLE_OFF`],
//! [`SPINDLE_WRONG_WAY`], gate `process`).
//!
//! It must cut only in feed, with the spindle turning in the sense of its teeth
//! ([`fault`]). A cutter that is in material right after its tool has come
//! into the spindle is reported as a rapid: nothing has cut its way in. The limit of the depth is
//! `tolerances.contact_mm`.

use proveout_nc::SpindleDirection;
use proveout_tool::Role;

use crate::{
    checks::tool_contact::{ContactCheck, ToolContact},
    cut::tool_sweeps::{CuttingState, Swept, fault},
    verdict::finding::{Finding, RAPID_IN_MATERIAL, SPINDLE_OFF, SPINDLE_WRONG_WAY},
};

/// See the module.
#[derive(Debug)]
pub(crate) struct CutterInMaterial;

impl ContactCheck for CutterInMaterial {
    fn judge(&mut self, contact: &ToolContact<'_>) -> Option<Finding> {
        let (code, how) = match contact.what {
            Swept::Entry => (RAPID_IN_MATERIAL, " right after the tool change, before it moves"),
            Swept::Body(Role::Cutting) => {
                let code = fault(contact.piece.kind, contact.state, contact.tool)?;
                let how = match code.code {
                    c if c == RAPID_IN_MATERIAL.code => " at rapid rate",
                    c if c == SPINDLE_OFF.code => why_stopped(contact.state),
                    c if c == SPINDLE_WRONG_WAY.code => " while the spindle turns against its hand",
                    _ => "",
                };
                (code, how)
            }
            _ => return None,
        };
        Some(contact.meets_material(&code, how))
    }
}

/// Why the spindle is stopped.
fn why_stopped(state: &CuttingState) -> &'static str {
    match state.spindle {
        SpindleDirection::Off => {
            " while the spindle is stopped (no M3 or M4 is in force: M5 and a tool change stop it)"
        }
        _ => " while the spindle is stopped (it is on but has no speed: the S word is missing, or is S0)",
    }
}
