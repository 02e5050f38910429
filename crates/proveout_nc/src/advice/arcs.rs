//! How the centers of arcs count: each convention is tried on the whole text.

use super::Advised;
use super::Trial;
use super::proposals::{Candidate, Cause};
use crate::codes;
use crate::diagnostic::{Diagnostic, FaultSubject};
use crate::settings::Dialect;

/// Two radii of an arc differ by so much through rounding alone, mm: words of three decimals of an inch, with
/// half a step in each of start, end and center.
const ROUNDED_MM: f64 = 0.05;
/// The same as a share of the radius, where a post computes long arcs with few digits.
const ROUNDED_SHARE: f64 = 0.001;
/// Most that the share may come to, mm.
const MOST_ROUNDED_MM: f64 = 0.25;
/// A tolerance is proposed so much above the largest difference, so that it does not stand on the edge.
const ABOVE: f64 = 1.25;

/// A fault of the shape of an arc.
pub(super) fn is_of_arc(fault: &Diagnostic) -> bool {
    matches!(fault.code, codes::ARC_RADIUS | codes::ARC_GEOMETRY)
}

/// The conventions, and a tolerance where the radii differ by what rounding explains.
pub(super) fn candidates(fault: &Diagnostic, at: &Trial) -> Vec<Candidate> {
    let faults: Vec<&Diagnostic> = at.faults.iter().filter(|fault| is_of_arc(fault)).collect();
    let count = faults.len() as u64;
    let advised = |key: &str, value: String, meaning: &str, why: String| Advised {
        key: key.to_owned(),
        value,
        meaning: meaning.to_owned(),
        why,
        count,
        first: (fault.file.to_string(), fault.line),
        line: fault.source_line.to_string(),
    };
    let mut list = Vec::new();
    // The radii of all that do not close: largest difference, and whether rounding explains each of them.
    let radii: Vec<[f64; 2]> = faults.iter().filter_map(|fault| radii(fault)).collect();
    let little = |[start, end]: &[f64; 2]| {
        (start - end).abs() <= ROUNDED_MM.max((ROUNDED_SHARE * start.max(*end)).min(MOST_ROUNDED_MM))
    };
    if radii.len() == faults.len() && radii.iter().all(little) {
        let largest = radii.iter().map(|[start, end]| (start - end).abs()).fold(0.0, f64::max);
        let tolerance = (largest * ABOVE * 1000.0).ceil() / 1000.0;
        let why = format!(
            "the radii at start and end of {count} arcs differ by up to {largest:.4} mm, which rounding of the words explains"
        );
        list.push(Candidate::rival(
            advised("arcs.tolerance_mm", format!("{tolerance}"), "radii that differ by so much make an arc", why),
            Cause::Arcs,
        ));
    }
    if at.dialect.family() != Dialect::Iso {
        return list;
    }
    for (value, meaning) in [
        ("absolute", "I, J and K are coordinates of the center"),
        ("unsigned", "I, J and K are distances without sign, and an arc stays within a quadrant"),
    ] {
        let why = format!(
            "{count} arcs do not close with centers from the start with sign, and every arc of the text closes with {value} ones"
        );
        list.push(Candidate::rival(advised("arcs.centers", format!("\"{value}\""), meaning, why), Cause::Arcs));
    }
    list
}

fn radii(fault: &Diagnostic) -> Option<[f64; 2]> {
    match fault.about.as_deref() {
        Some(FaultSubject::ArcRadii { start_nm, end_nm }) => Some([*start_nm as f64 / 1e6, *end_nm as f64 / 1e6]),
        _ => None,
    }
}
