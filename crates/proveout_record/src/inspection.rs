//! `inspection.csv`: the measured features for a measuring record; module `qif` writes `inspection.qif`.

use std::path::Path;

use proveout_sim::{
    scene::InspectFile,
    verdict::{Inspected, Verdict},
};

use crate::{
    error::RecordError,
    qif::{PlannedFeature, inspection_qif},
};

/// One line a feature: name, nominal value, tolerance to both sides, measured value, deviation (mm),
/// judgement. A feature whose probe met no surface has no value and is `not met`.
pub(crate) fn inspection_csv(features: &[Inspected]) -> String {
    let mut text = String::from("feature,nominal_mm,tolerance_mm,measured_mm,deviation_mm,judgement\n");
    for f in features {
        let off = f.measured_mm.map(|m| m - f.nominal_mm);
        let judgement = match off {
            None => "not met",
            Some(d) if d.abs() <= f.tolerance_mm => "in tolerance",
            Some(_) => "out of tolerance",
        };
        let number = |v: Option<f64>| v.filter(|v| v.is_finite()).map_or_else(String::new, |v| format!("{v:.6}"));
        let row = [
            field(&f.name),
            number(Some(f.nominal_mm)),
            number(Some(f.tolerance_mm)),
            number(f.measured_mm),
            number(off),
            judgement.to_owned(),
        ];
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

/// A field of RFC 4180. One that a spreadsheet would evaluate as a formula is marked as text.
fn field(name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let name = if name.starts_with(['=', '+', '-', '@']) { format!("'{name}") } else { name };
    if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name }
}

/// Writes the table and the document where the scene has features to inspect.
pub(crate) fn write_inspection(folder: &Path, verdict: &Verdict, plan: &[InspectFile]) -> Result<(), RecordError> {
    if verdict.inspection.is_empty() {
        return Ok(());
    }
    let path = folder.join("inspection.csv");
    std::fs::write(&path, inspection_csv(&verdict.inspection)).map_err(RecordError::io(&path))?;
    let run = format!("scene {} program {}", verdict.scene, verdict.program);
    let plan: Vec<PlannedFeature> = plan.iter().map(PlannedFeature::from).collect();
    let Some(text) = inspection_qif(&verdict.inspection, &plan, &run) else { return Ok(()) };
    let path = folder.join("inspection.qif");
    std::fs::write(&path, text).map_err(RecordError::io(&path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn features_are_judged_and_names_cannot_break_the_table() {
        let feature = |name: &str, measured_mm| Inspected {
            name: name.into(),
            nominal_mm: 10.0,
            measured_mm,
            tolerance_mm: 0.01,
        };
        let all = [
            feature("width", Some(10.002)),
            feature("a,\"b\"", Some(10.2)),
            feature("=cmd|x\n", None),
            feature("", Some(f64::NAN)),
        ];
        let text = inspection_csv(&all);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "feature,nominal_mm,tolerance_mm,measured_mm,deviation_mm,judgement");
        assert_eq!(lines[1], "width,10.000000,0.010000,10.002000,0.002000,in tolerance");
        assert_eq!(lines[2], "\"a,\"\"b\"\"\",10.000000,0.010000,10.200000,0.200000,out of tolerance");
        assert_eq!(lines[3], "'=cmd|x ,10.000000,0.010000,,,not met");
        assert_eq!(lines[4], ",10.000000,0.010000,,,out of tolerance");
    }
}
