use std::{collections::BTreeSet, path::Path};

use proveout_sim::{
    finding::Finding,
    read_regular_text,
    verdict::{MachineUsed, Verdict},
};

use super::pairing::pairs;
use crate::failure::Failure;

/// Largest verdict.
const MAX_BYTES: u64 = 1 << 30;
/// A change of a smaller number is told without its share: of what rounding leaves, a share says nothing.
const LEAST_OF_SHARE: f64 = 1e-9;

/// Reads the verdict of a run folder.
fn read(run: &Path) -> Result<Verdict, Failure> {
    let file = run.join("verdict.json");
    let text = read_regular_text(&file, MAX_BYTES).map_err(|e| {
        Failure::new(format!("{}: {e}", file.display())).with_help("name a run folder written by `proveout run`")
    })?;
    serde_json::from_str(&text)
        .map_err(|e| Failure::new(format!("{}:{}:{}: {e}", file.display(), e.line(), e.column())))
}

/// Prints what changed from run a to run b.
pub(crate) fn diff(run_a: &Path, run_b: &Path) -> Result<(), Failure> {
    let (a, b) = (read(run_a)?, read(run_b)?);
    say!("verdict   {:?} -> {:?}", a.verdict, b.verdict);
    if a.machine != b.machine {
        let shown = |m: &MachineUsed| format!("{} ({})", m.name, m.digest.get(..12).unwrap_or("no digest"));
        say!("machine   {} -> {}", shown(&a.machine), shown(&b.machine));
    }
    for gate in &b.gates {
        let before = a.gates.iter().find(|g| g.gate == gate.gate).map(|g| g.state);
        if before != Some(gate.state) {
            let before = before.map_or_else(|| "missing".to_owned(), |s| format!("{s:?}"));
            say!("gate      {}: {before} -> {:?} ({})", gate.gate, gate.state, gate.reason);
        }
    }
    let pairs = pairs(&a.findings, &b.findings);
    let alone = |label: &str, f: &Finding| {
        say!("{label:<9} {} line {}: {}", f.code, f.line.map_or("-".into(), |l| l.to_string()), f.message);
    };
    for (_, f) in a.findings.iter().enumerate().filter(|(i, _)| !pairs.contains_key(i)) {
        alone("gone", f);
    }
    let taken: BTreeSet<usize> = pairs.values().copied().collect();
    for (_, f) in b.findings.iter().enumerate().filter(|(i, _)| !taken.contains(i)) {
        alone("new", f);
    }
    for (f, g) in pairs.iter().filter_map(|(i, k)| Some((a.findings.get(*i)?, b.findings.get(*k)?))) {
        if (f.value, f.penetration_mm, f.clearance_mm, f.repeats)
            != (g.value, g.penetration_mm, g.clearance_mm, g.repeats)
        {
            say!("changed   {}: {} -> {}", f.code, f.message, g.message);
        }
    }
    let number = |name: &str, x: Option<f64>, y: Option<f64>| {
        if x != y {
            let show = |v: Option<f64>| v.map_or("unchecked".to_owned(), |v| format!("{v:.6}"));
            let percent = match (x, y) {
                (Some(x), Some(y)) if x.abs() > LEAST_OF_SHARE => format!(" ({:+.3} %)", 100.0 * (y - x) / x),
                _ => String::new(),
            };
            say!("{name:<28} {} -> {}{percent}", show(x), show(y));
        }
    };
    number("time.total_s", Some(a.time.total_s), Some(b.time.total_s));
    number("time.cutting_s", Some(a.time.cutting_s), Some(b.time.cutting_s));
    number("time.rapid_s", Some(a.time.rapid_s), Some(b.time.rapid_s));
    number("path.length_mm", Some(a.path.length_mm), Some(b.path.length_mm));
    number("path.max_contour_error_mm", a.path.max_contour_error_mm, b.path.max_contour_error_mm);
    number("path.max_axis_error_deg", a.path.max_axis_error_deg, b.path.max_axis_error_deg);
    number("removal.volume_mm3", Some(a.removal.volume_mm3), Some(b.removal.volume_mm3));
    number("removal.stock_left_mm3", Some(a.removal.stock_left_mm3), Some(b.removal.stock_left_mm3));
    number("removal.fallen_mm3", Some(a.removal.fallen_mm3), Some(b.removal.fallen_mm3));
    number("deviation.gouge_max_mm", a.deviation.gouge_max_mm, b.deviation.gouge_max_mm);
    number("deviation.excess_max_mm", a.deviation.excess_max_mm, b.deviation.excess_max_mm);
    number("deviation.mean_mm", a.deviation.mean_mm, b.deviation.mean_mm);
    number("deviation.rms_mm", a.deviation.rms_mm, b.deviation.rms_mm);
    number("clearance.min_mm", a.clearance.min_mm, b.clearance.min_mm);
    for (name, axis) in &b.axes {
        if let Some(before) = a.axes.get(name) {
            number(&format!("axes.{name}.max_velocity"), Some(before.max_velocity), Some(axis.max_velocity));
            number(
                &format!("axes.{name}.max_acceleration"),
                Some(before.max_acceleration),
                Some(axis.max_acceleration),
            );
            number(&format!("axes.{name}.reversals"), Some(before.reversals as f64), Some(axis.reversals as f64));
        }
    }
    for item in &b.inspection {
        if let Some(before) = a.inspection.iter().find(|i| i.name == item.name) {
            number(&format!("inspection.{}", item.name), before.measured_mm, item.measured_mm);
        }
    }
    Ok(())
}
