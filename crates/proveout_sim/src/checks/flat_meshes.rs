//! Mesh files with triangles that have no area ([`FLAT_TRIANGLES`](crate::verdict::finding::FLAT_TRIANGLES)).
//!
//! The reader of the files finds them; each is reported once, at the begin of the run. No gate: a triangle
//! without area encloses nothing.

use crate::{
    checks::check::{Check, RunEnd, StretchView},
    evidence::inputs::FlatMesh,
    prepare::prepared::Prepared,
    verdict::log::FindingLog,
};

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct FlatMeshes {
    is_reported: bool,
}

impl FlatMeshes {
    fn report(&mut self, prepared: &Prepared, log: &mut FindingLog) {
        if std::mem::replace(&mut self.is_reported, true) {
            return;
        }
        for finding in prepared.flat_meshes.iter().map(FlatMesh::finding) {
            log.push(finding);
        }
    }
}

impl Check for FlatMeshes {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        self.report(view.prepared, log);
    }

    /// A program without motion has no stretch.
    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        self.report(end.prepared, log);
    }
}
