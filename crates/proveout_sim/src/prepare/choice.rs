//! What the call of a run chooses in addition to its scene.

use std::{collections::BTreeMap, path::PathBuf};

use proveout_step::StepFiles;

use crate::{
    prepare::{
        memory::Recorded,
        reading::{Reading, of},
        set_value::SetValue,
        stop_at::StopAt,
    },
    scene::{BoxFile, Dynamics, Plant, ProgramFile, Scene},
};

/// What a run cuts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum StockChoice {
    /// The stock of the scene.
    #[default]
    OfScene,
    /// What the run in this folder left, instead of the scene's `from_run`.
    OfRun(PathBuf),
    /// A cube of a few cells: everything else is read and checked, nothing can be judged.
    StandIn,
}

/// What the call chooses.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// Program of the scene by name.
    pub program: Option<String>,
    /// Program text instead of the one that the scene names.
    pub nc: Option<PathBuf>,
    /// Distance of the stock's rays instead of the scene's, mm.
    pub resolution_mm: Option<f64>,
    /// Dynamics instead of those of the scene.
    pub dynamics: Option<Dynamics>,
    /// Plant instead of that of the scene.
    pub plant: Option<Plant>,
    /// What the observers of the run will hold, for the announcement of its memory.
    pub recorded: Recorded,
    /// Tools, by name, clamped with more overhang than the library says, mm; with less where
    /// negative.
    pub clamped_out_mm: BTreeMap<String, f64>,
    /// Least overhangs that were searched ([`crate::run::overhang`]), by name of the tool, mm.
    pub least_overhang_mm: BTreeMap<String, f64>,
    /// Places along the motion at which the free tool axes are looked for; zero for none.
    pub free_axes: usize,
    /// How the switches of the operator are set, instead of the first reading that the scene wants.
    pub reading: Option<Reading>,
    /// Coarse cells, and without what takes time besides ([`crate::run::partial`]).
    pub preview: bool,
    /// What is cut.
    pub stock: StockChoice,
    /// What ends the run early.
    pub stop_at: Option<StopAt>,
    /// Values that override those in the files of scene, machine and tools.
    pub set: Vec<SetValue>,
    /// STEP files that the call has read already. Clones share them, so that the helper runs once for each.
    pub step_files: StepFiles,
}

/// Replaces the scene's stock by that of the call.
pub(crate) fn choose_stock(scene: &mut Scene, choice: &StockChoice) {
    let stock = scene.file.stock.get_mut();
    match choice {
        StockChoice::OfScene => {}
        StockChoice::OfRun(folder) => stock.from_run = Some(folder.clone()),
        StockChoice::StandIn => {
            (stock.from_run, stock.place, stock.at_time_s, stock.history) = (None, None, None, false);
            stock.patch.clear();
            let edge = 8.0 * scene.file.resolution_mm.get_ref().edges().into_iter().fold(0.0, f64::max);
            stock.block = Some(BoxFile { min_mm: [0.0; 3], max_mm: [edge; 3] });
        }
    }
}

/// The calls of the other readings than the one of the run.
pub(crate) fn calls_of_other_readings(entry: Option<&ProgramFile>, choice: &Choice) -> Vec<Choice> {
    // A run that ends early judges nothing to its end.
    if choice.reading.is_some() || choice.stop_at.is_some() {
        return Vec::new();
    }
    let others = of(entry).into_iter().skip(1);
    others.map(|reading| Choice { reading: Some(reading), free_axes: 0, ..choice.clone() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::reading::of;

    fn program(more: &str) -> ProgramFile {
        toml::from_str(&format!("name = \"p\"\nfile = \"p.nc\"\n{more}")).unwrap_or_else(|e| panic!("{more}: {e}"))
    }

    #[test]
    fn both_of_a_switch_is_each_of_its_readings() {
        let count = |more: &str| of(Some(&program(more))).len();
        assert_eq!((of(None), count("")), (vec![Reading::default()], 1));
        for (more, readings) in [
            ("block_skip = \"on\"\n", 1),
            ("block_skip = \"both\"\n", 2),
            ("optional_stop = \"both\"\n", 2),
            ("block_skip = \"both\"\noptional_stop = \"both\"\n", 4),
            ("block_skip = \"both\"\noptional_stop = \"off\"\n", 2),
        ] {
            assert_eq!(count(more), readings, "{more}");
            let choices = calls_of_other_readings(Some(&program(more)), &Choice::default());
            assert_eq!(choices.len(), readings - 1, "{more}");
            assert!(
                choices.iter().all(|c| calls_of_other_readings(Some(&program(more)), c).is_empty()),
                "a reading has no others"
            );
        }
        assert!(toml::from_str::<ProgramFile>("name = \"p\"\nblock_skip = \"maybe\"\n").is_err());
    }
}
