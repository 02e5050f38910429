//! Findings for gouged areas and areas with material left.

use proveout_surface::Area;
use proveout_tool::ToolLibrary;

use crate::{
    engine::Facts,
    finding::{self, Code, Finding},
    log::FindingLog,
    prepare::Prepared,
    survey::Measured,
};

/// Areas of a kind that get a finding of their own, the worst first; the others are told in one more. A page of findings is
/// read, a longer list is not, and all of them are counted.
const TOLD: usize = 20;

/// Findings for the areas beyond the tolerances, the worst first; the place in the program is the block that made the worst point.
pub(crate) fn judge_areas(
    prepared: &Prepared,
    facts: &Facts,
    measured: &Measured,
    finished: bool,
    log: &mut FindingLog,
) {
    let tolerances = &prepared.scene.file.tolerances;
    let floor = measured.deviation.tolerance_floor_mm.unwrap_or(0.0);
    let kinds = [
        (&finding::GOUGE, ["gouge", "gouges"], &measured.gouges, tolerances.gouge_mm),
        (&finding::EXCESS, ["excess", "areas with excess"], &measured.excesses, tolerances.excess_mm),
    ];
    // On a part that is not finished there is material everywhere.
    for (code, words, areas, limit) in kinds.into_iter().take(if finished { 2 } else { 1 }) {
        let (told, rest) = areas.split_at(areas.len().min(TOLD));
        for area in told {
            let mut f = of_area(code, words[0], area, [limit, floor]);
            f.block = area.made_by.and_then(|p| facts.block_of_piece.get(p as usize)).copied();
            let round = f.block.and_then(|b| facts.envelopes.get(&b)).and_then(|t| prepared.tools.tools.get(*t));
            if let Some(tool) = round {
                f.message += &format!(
                    "; {} cuts here as the cylinder round it ({ENVELOPE}): where the design has the hole before the thread, the depth of the \
                     thread is no fault",
                    tool.name
                );
            }
            if let Some((file, line)) = f.block.and_then(|b| facts.places.get(b as usize)).and_then(Option::as_ref) {
                (f.file, f.line) = (Some(file.to_string()), Some(*line));
            }
            log.push(f);
        }
        if let Some(worst) = rest.first() {
            let sum = |of: fn(&Area) -> f64| rest.iter().map(of).sum::<f64>();
            let (area, volume) = (sum(|a| a.area), sum(|a| a.volume));
            let message = format!(
                "{} more {}, up to {:.4} mm: {} mm2 and {} mm3 together",
                rest.len(),
                words[1],
                worst.depth,
                figure(area),
                figure(volume)
            );
            let mut f = FindingLog::of(code, message);
            (f.value, f.limit, f.unit) = (Some(worst.depth), Some(limit), Some("mm".into()));
            (f.area_mm2, f.volume_mm3, f.areas) = (Some(area), Some(volume), Some(rest.len() as u64));
            log.push(f);
        }
    }
}

/// What a tool is that has a cylinder in place of its teeth.
const ENVELOPE: &str = "a cylinder of its diameter is its envelope";

/// Whether a tool cuts as the cylinder round it: a tap, a thread mill.
pub(crate) fn is_envelope(tools: &ToolLibrary, index: usize) -> bool {
    let threads = |why: &str| why.contains(ENVELOPE) && (why.contains("a tap: ") || why.contains("a thread mill: "));
    tools.notes.get(index).is_some_and(|n| n.chosen.iter().any(|(_, why)| threads(why)))
}

fn of_area(code: &Code, word: &str, area: &Area, [limit, floor]: [f64; 2]) -> Finding {
    let [x, y, z]: [f64; 3] = area.point.coords.into();
    let what = match area.wall {
        Some(wall) if area.foil => format!("a wall of {wall:.4} mm, no thicker than the tolerance, is gone"),
        Some(wall) => format!("{word} of {:.4} mm: a wall of {wall:.4} mm is gone", area.depth),
        None => format!("{word} of {:.4} mm", area.depth),
    };
    let raw = if area.made_by.is_none() { "; no motion has cut it, the raw stock is like that" } else { "" };
    let message = format!(
        "{what} at X{x:.3} Y{y:.3} Z{z:.3} of the workpiece, {} mm2 and {} mm3{raw}; allowed are {limit:.4} mm plus {floor:.4} \
         mm that the measurement cannot tell apart",
        figure(area.area),
        figure(area.volume)
    );
    let mut f = FindingLog::of(code, message);
    (f.value, f.limit, f.unit) = (Some(area.depth), Some(limit), Some("mm".into()));
    (f.area_mm2, f.volume_mm3, f.areas) = (Some(area.area), Some(area.volume), Some(1));
    f.point_mm = Some(area.point.coords.into());
    f
}

/// Three figures, as far as they are known.
fn figure(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-6).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}
