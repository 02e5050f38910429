//! The inspection plan: touches and walls of the cut part, measured on exact dexel ends.

use proveout_stock::{Interval, Patch, TriDexel, patched_intervals};

use crate::{
    scene::{InspectFile, InspectKindFile, probe_direction},
    verdict::{
        finding::{Finding, INSPECTION},
        log::FindingLog,
        verdict_file::Inspected,
    },
};

/// Measures every feature: from the start point along its direction to the first material, on the ray nearest
/// to the start point (at most half a cell aside in each direction), that of a patch inside of its window.
pub(crate) fn inspect(plan: &[InspectFile], stock: &TriDexel, patches: &[Patch]) -> Vec<Inspected> {
    let on_ray = |axis: usize, from: &[f64; 3]| {
        patched_intervals(stock, patches, axis, from[(axis + 1) % 3], from[(axis + 2) % 3])
    };
    plan.iter()
        .map(|feature| Inspected {
            name: feature.name.clone(),
            nominal_mm: feature.nominal_mm,
            measured_mm: match feature.kind {
                InspectKindFile::Touch => touch(feature, &on_ray),
                InspectKindFile::Thickness => thickness(feature, &on_ray),
            },
            tolerance_mm: feature.tolerance_mm,
        })
        .collect()
}

fn touch(feature: &InspectFile, on_ray: &dyn Fn(usize, &[f64; 3]) -> Vec<Interval>) -> Option<f64> {
    let (axis, sign) = probe_direction(feature.direction.get_ref())?;
    let from = feature.from_mm.get_ref();
    let material = on_ray(axis, from);
    let faces = material.iter().map(|i| if sign > 0.0 { i.lo } else { i.hi });
    let ahead = faces.filter(|face| (face - from[axis]) * sign >= 0.0);
    ahead.min_by(|a, b| (a * sign).total_cmp(&(b * sign)))
}

/// Length of the first interval of material that ends ahead of the start.
fn thickness(feature: &InspectFile, on_ray: &dyn Fn(usize, &[f64; 3]) -> Vec<Interval>) -> Option<f64> {
    let (axis, sign) = probe_direction(feature.direction.get_ref())?;
    let from = feature.from_mm.get_ref();
    let material = on_ray(axis, from);
    let at = from[axis];
    let wall = if sign > 0.0 { material.iter().find(|i| i.hi > at) } else { material.iter().rev().find(|i| i.lo < at) };
    wall.map(|i| i.hi - i.lo)
}

/// Findings for features that are out of tolerance or not there.
pub(crate) fn judge(measured: &[Inspected]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for m in measured {
        let off = m.measured_mm.map(|v| v - m.nominal_mm);
        if off.is_some_and(|o| o.abs() <= m.tolerance_mm) {
            continue;
        }
        let message = match (m.measured_mm, off) {
            (Some(value), Some(off)) => format!(
                "{}: {value:.4} mm instead of {:.4} mm, off by {off:+.4} mm with {:.4} mm allowed",
                m.name, m.nominal_mm, m.tolerance_mm
            ),
            _ => format!("{}: no material found, nominal is {:.4} mm", m.name, m.nominal_mm),
        };
        let mut finding = FindingLog::of(&INSPECTION, message);
        finding.value = off.map(f64::abs);
        finding.limit = Some(m.tolerance_mm);
        finding.unit = Some("mm".into());
        findings.push(finding);
    }
    findings
}
