//! Tools in statements of programs.
//!
//! | who writes it | form |
//! |---|---|
//! | Klartext | `TOOL DEF 5 L+80 R+5` |
//! | CL data | `CUTTER/ d, r` or `TLDATA/MILL, d, r, l, 0, 0` before `LOADTL/ n` |

use proveout_tool::ToolDraft;

use super::tool_words::letter;
use crate::prepare::program_trace::SAME_MM;

/// `TOOL DEF 5 L+80 R+5` of a TNC.
pub(super) fn tool_def(upper: &str, unit: f64, line: usize) -> Option<ToolDraft> {
    let rest = upper.split_once("TOOL DEF ")?.1;
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let number: u32 = rest[..end].parse().ok()?;
    let rest = &rest[end..];
    let radius = letter(rest, 'R').filter(|r| *r > 0.0)? * unit;
    let mut draft = ToolDraft::new(number, format!("TOOL DEF in line {line}"));
    draft.put("diameter_mm", 2.0 * radius);
    draft.gauge = letter(rest, 'L').map(|l| l * unit).filter(|l| *l > 0.0);
    Some(draft)
}

/// `TLDATA/MILL, d, r, length, taper, tip` and `TLDATA/DRILL, d, angle, length` of the CL data of NX.
fn tool_data(upper: &str, unit: f64, line: usize) -> Option<ToolDraft> {
    let rest = upper.trim_start().strip_prefix("TLDATA")?.trim_start().strip_prefix('/')?;
    if let Some(rest) = rest.trim().strip_prefix("DRILL,") {
        let n: Vec<f64> = rest.split(',').map_while(|t| t.trim().parse().ok()).collect();
        let mut draft = ToolDraft::new(0, format!("TLDATA in line {line}"));
        draft.put("diameter_mm", n.first().copied().filter(|d| *d > 0.0)? * unit);
        draft.kind = Some("drill");
        if let Some(angle) = n.get(1).copied().filter(|a| (30.0..=180.0).contains(a)) {
            draft.put("point_angle_deg", angle);
        }
        return Some(draft);
    }
    let n: Vec<f64> = rest.trim().strip_prefix("MILL,")?.split(',').map_while(|t| t.trim().parse().ok()).collect();
    // An inclined flank needs more than this.
    let straight = n.get(3).is_none_or(|a| *a == 0.0) && n.get(4).is_none_or(|a| *a == 0.0);
    let diameter = n.first().copied().filter(|d| *d > 0.0 && straight)? * unit;
    let corner = n.get(1).copied().unwrap_or(0.0) * unit;
    let mut draft = ToolDraft::new(0, format!("TLDATA in line {line}"));
    draft.put("diameter_mm", diameter);
    rounded_end(&mut draft, diameter, corner);
    draft.overall = n.get(2).map(|l| l * unit).filter(|l| *l > 0.0);
    Some(draft)
}

/// Kind of a straight cutter by its corner radius.
fn rounded_end(draft: &mut ToolDraft, diameter: f64, corner: f64) {
    draft.kind = Some("flat");
    if corner > 0.5 * diameter - SAME_MM {
        draft.kind = Some("ball");
    } else if corner > 0.0 {
        draft.kind = Some("bull_nose");
        draft.put("corner_radius_mm", corner);
    }
}

/// `CUTTER/ d, r [, e, f, alpha, beta, h]` of CL data, or `TLDATA/MILL`.
pub(super) fn cutter_statement(upper: &str, unit: f64, line: usize) -> Option<ToolDraft> {
    if let Some(draft) = tool_data(upper, unit, line) {
        return Some(draft);
    }
    let rest = upper.trim_start().strip_prefix("CUTTER")?.trim_start().strip_prefix('/')?;
    let n: Vec<f64> = rest.split(',').map_while(|t| t.trim().parse().ok()).collect();
    let diameter = n.first().copied().filter(|d| *d > 0.0)? * unit;
    let corner = n.get(1).copied().unwrap_or(0.0) * unit;
    let mut draft = ToolDraft::new(0, format!("CUTTER in line {line}"));
    if n.get(4).is_some_and(|a| *a != 0.0) || n.get(5).is_some_and(|a| *a != 0.0) {
        // Lower and upper lines that are inclined need all of it.
        return None;
    }
    draft.put("diameter_mm", diameter);
    rounded_end(&mut draft, diameter, corner);
    draft.flute_length = n.get(6).map(|h| h * unit).filter(|h| *h > corner);
    Some(draft)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_describe_tools() {
        let mill = cutter_statement("TLDATA/MILL,20.0000,2.0000,75.0000,0.0000,0.0000", 1.0, 5).expect("a cutter");
        assert_eq!((mill.kind, mill.diameter(), mill.overall), (Some("bull_nose"), Some(20.0), Some(75.0)));
        assert!(cutter_statement("TLDATA/MILL,20.0,0.0,75.0,15.0,0.0", 1.0, 5).is_none(), "a cone");
        let drill = cutter_statement("TLDATA/DRILL,0.2500,118.0000,3.0000,2.0000,0.0000", 25.4, 5).expect("a drill");
        assert_eq!(
            (drill.kind, drill.diameter(), drill.get("point_angle_deg")),
            (Some("drill"), Some(6.35), Some(118.0))
        );
        let def = tool_def("4 TOOL DEF 5 L+80 R+5", 1.0, 4).expect("a definition");
        assert_eq!((def.number, def.diameter(), def.gauge), (5, Some(10.0), Some(80.0)));
        let cutter = cutter_statement("CUTTER/ 12.0, 1.5, 0,0,0,0,40", 1.0, 2).expect("a cutter");
        assert_eq!((cutter.kind, cutter.diameter(), cutter.flute_length), (Some("bull_nose"), Some(12.0), Some(40.0)));
    }
}
