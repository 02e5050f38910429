//! What a call leaves out of a scene: a preview with coarse cells (`run --preview`), an early end.

use crate::{
    prepare::{choice::Choice, stop_at::StopAt},
    scene::Scene,
    verdict::partial_run::PreviewUsed,
};

/// Factor of the cells of a preview: the rays, and with them most of the time of sweeps, fall to a sixteenth;
/// motion and bodies take theirs.
pub const COARSER: f64 = 4.0;

/// What the call makes of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wanted {
    pub(crate) preview: Option<PreviewUsed>,
    pub(crate) stop_at: Option<StopAt>,
}

impl Wanted {
    /// Takes out of a scene what a preview leaves out; gives the cells to cut with.
    pub(crate) fn of(choice: &Choice, scene: &mut Scene, cells: [f64; 3]) -> (Self, [f64; 3]) {
        let stop_at = choice.stop_at.clone();
        if !choice.preview {
            return (Self { preview: None, stop_at }, cells);
        }
        let coarse = cells.map(|c| COARSER * c);
        let mut left_out = Vec::new();
        let patches = &mut scene.file.stock.get_mut().patch;
        if !patches.is_empty() {
            let names: Vec<String> = patches.drain(..).map(|p| p.into_inner().name).collect();
            left_out.push(format!("finer patches ({})", names.join(", ")));
        }
        if scene.file.surface.take().is_some() {
            left_out.push("roughness of [surface]".to_owned());
        }
        left_out.push("ridges between the passes".to_owned());
        let preview = Some(PreviewUsed { cells_mm: coarse, scene_cells_mm: cells, left_out });
        (Self { preview, stop_at }, coarse)
    }
}
