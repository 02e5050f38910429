//! Fixtures and machine bodies that overlap the stock before any motion
//! ([`STOCK_AT_REST`](crate::verdict::finding::STOCK_AT_REST), gate `collision`).
//!
//! They move as one with the stock, so that no motion shows it. The overlap with the raw stock is measured
//! before the run ([`AtRest`]); the limit is `tolerances.contact_mm`. What is inside an open mesh is unknown:
//! the gate names those meshes.

use crate::{
    checks::{
        assumed_values::{ASSUMED_MOUNT, is_fixed_to_work},
        check::{Check, RunEnd, StretchView},
    },
    cut::stock_bodies::AtRest,
    prepare::prepared::Prepared,
    verdict::{
        finding::{Finding, STOCK_AT_REST},
        log::FindingLog,
    },
};

/// See the module.
#[derive(Debug)]
pub(crate) struct StockAtRest {
    /// Overlaps that are not reported yet.
    overlaps: Vec<AtRest>,
}

impl StockAtRest {
    pub(crate) fn new(overlaps: Vec<AtRest>) -> Self {
        Self { overlaps }
    }

    fn report(&mut self, prepared: &Prepared, log: &mut FindingLog) {
        for overlap in std::mem::take(&mut self.overlaps) {
            let mut f = finding(&overlap);
            if prepared.mount_assumed && !is_fixed_to_work(prepared, &overlap.body) {
                f.message += ASSUMED_MOUNT;
            }
            log.push(f);
        }
    }
}

impl Check for StockAtRest {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        self.report(view.prepared, log);
    }

    /// A program without motion has no stretch.
    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        self.report(end.prepared, log);
    }
}

fn finding(AtRest { body, overlap }: &AtRest) -> Finding {
    let message = format!(
        "{body} overlaps the stock before any motion: {:.3} mm deep, {:.3} mm3",
        overlap.depth_mm, overlap.volume_mm3
    );
    let mut f = FindingLog::of(&STOCK_AT_REST, message);
    f.bodies = vec![body.clone(), "stock".into()];
    f.time_s = Some(0.0);
    f.penetration_mm = Some(overlap.depth_mm);
    f.point_mm = Some(overlap.point.coords.into());
    f
}
