//! In what a run is less than the whole check, as its verdict says: a preview, or an early end.

use std::path::Path;

use proveout_input::read_regular_text;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::verdict::{
    gate::{Gate, PerGate},
    gates::Coverage,
};

/// In what a run is less than the whole check; no key of it is set in one that is whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Partial {
    /// The cells were coarse (`run --preview`).
    pub preview: Option<PreviewUsed>,
    /// The run ended early (`run --stop-at`).
    pub stopped: Option<Stopped>,
}

impl Partial {
    /// In what the run was not the whole check, in sentences.
    pub fn words(&self) -> Vec<String> {
        let preview = self.preview.as_ref().map(|p| {
            let [cell, full] = [&p.cells_mm, &p.scene_cells_mm].map(|c| c.iter().copied().fold(0.0, f64::max));
            format!(
                "PREVIEW with cells of {cell} mm instead of {full} mm: not a full check; for that, run again \
                     without --preview"
            )
        });
        let stopped = self.stopped.as_ref().map(|s| {
            let line = s.line.map_or_else(String::new, |l| format!(", after line {l}"));
            format!("STOPPED at {:.3} s{line}: {}; nothing after it was checked", s.time_s, s.why)
        });
        preview.into_iter().chain(stopped).collect()
    }
}

/// Cells of a preview.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PreviewUsed {
    /// Edges of the cells that were cut, mm.
    pub cells_mm: [f64; 3],
    /// Those of the scene.
    pub scene_cells_mm: [f64; 3],
    /// What else was left out: patches, texture.
    pub left_out: Vec<String>,
}

/// Where a run ended early.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stopped {
    /// What the call asked for: `any`, a code, a line, a time.
    pub at: String,
    /// In words.
    pub why: String,
    /// Last motion that was judged: its file.
    pub file: Option<String>,
    /// Its line.
    pub line: Option<u32>,
    /// Simulated time to which motion was cut and judged, s.
    pub time_s: f64,
    /// Time to which the control had planned ahead, s: `axes` and `path` cover the motion until then, all
    /// else that until `time_s`.
    pub planned_s: f64,
}

/// Refuses the stock of a run that was not whole: the next setup would start from a part that does
/// not exist.
pub(crate) fn refused_as_stock(folder: &Path) -> Option<String> {
    #[derive(Deserialize)]
    struct Short {
        #[serde(default)]
        partial: Option<Partial>,
    }
    let text = read_regular_text(&folder.join("verdict.json"), 1 << 30).ok()?;
    let partial = serde_json::from_str::<Short>(&text).ok()?.partial?;
    Some(match (partial.preview, partial.stopped) {
        (_, Some(s)) => format!("is of a run that was stopped at {:.3} s: the part is not finished", s.time_s),
        (Some(p), None) => format!("is of a preview, with cells of {} mm", p.cells_mm.into_iter().fold(0.0, f64::max)),
        (None, None) => return None,
    })
}

/// Takes from the gates what a run that is not whole has not judged.
pub(crate) fn leave_out(partial: Option<&Partial>, gates: &mut PerGate<Coverage>) {
    let Some(partial) = partial else { return };
    if let Some(p) = &partial.preview {
        let longest = |cells: &[f64; 3]| cells.iter().copied().fold(0.0, f64::max);
        let what = format!(
            "preview: cells of {} mm instead of {} mm; features thinner than a cell may have been missed",
            longest(&p.cells_mm),
            longest(&p.scene_cells_mm)
        );
        for gate in [Gate::Process, Gate::Collision, Gate::NearMiss, Gate::Gouge, Gate::Excess] {
            gates[gate].left_out.push(what.clone());
        }
        gates[Gate::Surface].left_out.push(format!("preview: not evaluated: {}", p.left_out.join(", ")));
    }
    if let Some(s) = &partial.stopped {
        let line = s.line.map_or_else(String::new, |l| format!(" (line {l})"));
        let what = format!("stopped at {:.3} s{line}: the motion after that", s.time_s);
        for gate in [Gate::Limits, Gate::Process, Gate::Collision, Gate::NearMiss, Gate::Gouge] {
            gates[gate].left_out.push(what.clone());
        }
        gates[Gate::Program] = Coverage {
            checked: gates[Gate::Program].checked.as_ref().map(|_| "executed so far".to_owned()),
            left_out: vec![format!("stopped at {:.3} s{line}, since {}", s.time_s, s.why)],
        };
        for gate in [Gate::Excess, Gate::Surface] {
            gates[gate] = Coverage {
                checked: None,
                left_out: vec![format!("stopped at {:.3} s{line}: the part is not finished", s.time_s)],
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_gate_of_a_run_that_is_not_whole_passes_unseen() {
        let all = || PerGate::from_fn(|_| Coverage { checked: Some("all".into()), left_out: vec![] });
        let mut gates = all();
        let stopped = Stopped { time_s: 3.0, line: Some(7), why: "line 7 was run".into(), ..Stopped::default() };
        leave_out(Some(&Partial { preview: None, stopped: Some(stopped) }), &mut gates);
        assert!(gates.iter().all(|(_, g)| g.left_out.iter().any(|w| w.contains("stopped at 3.000 s (line 7)"))));
        let mut gates = all();
        let preview = PreviewUsed { cells_mm: [0.8; 3], scene_cells_mm: [0.2; 3], left_out: vec!["ridges".into()] };
        leave_out(Some(&Partial { preview: Some(preview), stopped: None }), &mut gates);
        for (gate, coverage) in gates.iter() {
            let previewed = coverage.left_out.iter().any(|w| w.starts_with("preview"));
            assert_eq!(previewed, !matches!(gate, Gate::Program | Gate::Limits), "{gate}: these two ask no stock");
            assert_eq!(previewed, !coverage.left_out.is_empty(), "{gate}");
        }
    }
}
