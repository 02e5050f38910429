//! A body of machine or setup meets the stock ([`STOCK_HIT`], gate `collision`), or comes closer to it than
//! required ([`NEAR_MISS`], gate `near_miss`).
//!
//! The bodies are followed against the stock as it is at that moment
//! ([`StockBodies`](crate::cut::stock_bodies::StockBodies)). Between its rays material is known to half the
//! diagonal of a cell; a preview with coarse cells only warns of a breach that may come from them. At the end
//! of the run each finding takes the deepest penetration and the least clearance of its breach.

use proveout_collision::{Severity as BreachSeverity, StockBreach};

use crate::{
    checks::check::{Check, RunEnd, StretchView},
    cut::stock_bodies::is_near_miss,
    verdict::{
        finding::{Finding, NEAR_MISS, STOCK_HIT, Severity},
        log::FindingLog,
    },
};

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct StockHits {
    /// Breach of a body and the stock, and the finding that reports it.
    breaches: Vec<(usize, usize)>,
}

impl Check for StockHits {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        for (piece, index) in view.stock_breaches {
            let Some(breach) = view.stock_bodies.breach(*index) else { continue };
            let near = view.near_miss_mm();
            let mut f = finding(breach, near, view.stock_bodies.unseen_mm());
            // The whole run sees more of what lies between the rays, and may clear it.
            if view.prepared.wanted.preview.is_some() && may_be_of_the_cells(breach, near) {
                f.severity = Severity::Warning;
                f.message += "; preview: its coarse cells may be the only reason";
            }
            let finding = log.push(view.at_piece(f, &view.chunk.pieces[*piece], breach.time));
            self.breaches.push((*index, finding));
        }
    }

    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        for (breach, finding) in std::mem::take(&mut self.breaches) {
            if let Some(b) = end.stock_bodies.breach(breach) {
                log.deepen(finding, b.penetration_estimate, b.least_distance);
            }
        }
    }
}

/// A distance of a ray's material that is called a meeting, mm.
const TOUCH_MM: f64 = 0.01;

/// A body too near to the stock; `near` is the clearance asked for, `unseen` what the rays cannot
/// resolve, mm.
fn finding(breach: &StockBreach, near: f64, unseen: f64) -> Finding {
    let body = &breach.body;
    let near_miss = is_near_miss(breach);
    let (rays, least) = (breach.ray_distance, breach.distance);
    let how = if breach.severity == BreachSeverity::QueryFailed {
        format!("{body} is not proven clear of the stock: joint positions are not finite numbers")
    } else if near_miss {
        format!("{body} comes closer to the stock than the required {near:.3} mm")
    } else if breach.inside {
        format!("{body} contains a part of the stock")
    } else if rays <= TOUCH_MM {
        format!(
            "{body} hits the stock: it meets material, known to within {:.3} mm, half the diagonal of a cell",
            0.5 * unseen
        )
    } else {
        format!(
            "{body} hits the stock or misses it by less than {rays:.3} mm: between rays material is known to within {:.3} mm, half the diagonal of a \
             cell",
            0.5 * unseen
        )
    };
    let mut f = FindingLog::of(if near_miss { &NEAR_MISS } else { &STOCK_HIT }, how);
    f.bodies = vec![body.to_string(), "stock".into()];
    f.penetration_mm = breach.penetration_estimate;
    if near_miss {
        (f.clearance_mm, f.limit, f.unit) = (Some(least), Some(near), Some("mm".into()));
    }
    f.point_mm = Some(breach.point_in_work.coords.into());
    f
}

/// A breach that rests on what lies between the rays: no ray was as near as that.
fn may_be_of_the_cells(breach: &StockBreach, near: f64) -> bool {
    let limit = if is_near_miss(breach) { near } else { TOUCH_MM };
    !breach.inside && breach.severity != BreachSeverity::QueryFailed && breach.ray_distance > limit
}
