//! The scallop of the cut part against `[tolerances] scallop_um`.

use proveout_stock::{Patch, TriDexel};

use crate::{
    engine::Facts,
    log::FindingLog,
    prepare::Prepared,
    surface_gate::Judgement,
    verdict::{State, Surface},
};

/// Judges the scallop where the scene sets a tolerance for it, and fills in what the verdict says of it.
pub(crate) fn judge(
    prepared: &Prepared,
    _facts: &Facts,
    _stock: &TriDexel,
    _patches: &[Patch],
    _surface: &mut Surface,
    _log: &mut FindingLog,
) -> Option<Judgement> {
    prepared.scene.file.tolerances.scallop_um?;
    Some(Judgement { key: "scallop_um", state: State::Unchecked, reason: "not measured".into() })
}
