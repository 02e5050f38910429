//! One run of the twin for its feeds: engagement along the path, and what the machine made of each block.

use std::collections::BTreeMap;

use proveout_controller::{BlockRecord, Chunk, MoveKind};
use proveout_machine::Machine;

use crate::{
    cut::{
        engaged_samples::{EngagedSample, EngagedSlice},
        engine::Engine,
        stages::Stages,
    },
    feeds::window,
    observe::block_rows::BlockRow,
    prepare::{
        error::{SimError, from_run_error},
        prepared::Prepared,
    },
    run::motion_plan::{STRETCH_S, controller, opened, stretches},
    verdict::finding::Severity,
};

/// Longest sample, mm of path.
pub(crate) const SAMPLE_MM: f64 = 0.5;
/// Height of a slice, in cells: each has a row of rays.
const CELLS_OF_SLICE: f64 = 2.0;

/// A derivative of a joint's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum JointLimit {
    /// Its highest velocity.
    Velocity,
    /// Its highest acceleration.
    Acceleration,
    /// Its highest jerk.
    Jerk,
}

impl JointLimit {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        }
    }
}

/// A joint at its limit: part of the limit that is used, index of the joint, which limit.
pub(crate) type Busy = (f64, usize, JointLimit);

/// A block of motion as it was run.
#[derive(Clone, Debug)]
pub(crate) struct TwinBlock {
    pub(crate) row: BlockRow,
    /// Its path follows the angle of the spindle.
    pub(crate) coupled: bool,
    /// Highest feed that was reached, mm/s.
    pub(crate) reached: f64,
    /// Way of the tip through the table frame, mm.
    pub(crate) tip_way: f64,
    /// The joint that used most of a limit.
    pub(crate) busiest: Option<Busy>,
}

impl TwinBlock {
    pub(crate) fn time(&self) -> f64 {
        self.row.end_time - self.row.start_time
    }
}

/// A run.
#[derive(Debug)]
pub(crate) struct TwinRun {
    pub(crate) samples: Vec<EngagedSample>,
    /// The slices of each sample, joined over a cell.
    pub(crate) slices: Vec<Vec<EngagedSlice>>,
    /// Blocks of motion, in the order of execution.
    pub(crate) blocks: Vec<TwinBlock>,
    /// Time of the program, s.
    pub(crate) time_s: f64,
    /// Findings that fail a gate, by code, with their lines.
    pub(crate) faults: BTreeMap<String, Vec<u32>>,
    /// Longest edge of a cell, mm.
    pub(crate) cell_mm: f64,
}

/// What is gathered of a block before it ends.
#[derive(Clone, Copy, Debug, Default)]
struct Gathered {
    reached: f64,
    tip_way: f64,
    busiest: Option<Busy>,
}

/// Runs a prepared program.
pub(crate) fn run(mut prepared: Prepared) -> Result<TwinRun, SimError> {
    let (stock, patches) = prepared.stock.take()?;
    let prepared = prepared;
    let cell_mm = prepared.stock.cell_mm();
    let mut engine = Engine::new(&prepared, stock, patches, None)?;
    engine.sample_engagement(SAMPLE_MM, CELLS_OF_SLICE * cell_mm);
    let mut stages = Stages::default();
    let mut controller = controller(&prepared)?;
    let mut gathered: BTreeMap<u32, Gathered> = BTreeMap::new();
    let (mut samples, mut blocks, mut faults) = (Vec::new(), Vec::new(), BTreeMap::<String, Vec<u32>>::new());
    while let Some(chunk) = controller.next_chunk().map_err(|e| from_run_error(opened(&prepared, e)))? {
        for stretch in stretches(chunk, STRETCH_S) {
            gather(&stretch, &prepared.machine, &mut gathered);
            let coupled = |index: u32| stretch.blocks.iter().any(|b: &BlockRecord| b.index == index && b.coupled);
            let batch = engine.step(&stretch, &mut stages);
            engine.check_memory()?;
            samples.extend(engine.take_samples(false));
            for row in batch.blocks {
                let Gathered { reached, tip_way, busiest } = gathered.remove(&row.block).unwrap_or_default();
                blocks.push(TwinBlock { coupled: coupled(row.block), reached, tip_way, busiest, row });
            }
            for finding in batch.findings.iter().filter(|f| f.severity == Severity::Error) {
                faults.entry(finding.code.clone()).or_default().extend(finding.line);
            }
        }
    }
    samples.extend(engine.take_samples(true));
    let slices = window::joined(&samples, cell_mm);
    Ok(TwinRun { samples, slices, blocks, time_s: controller.summary().total_s, faults, cell_mm })
}

/// What pieces and samples of a stretch say of their blocks.
fn gather(chunk: &Chunk, machine: &Machine, all: &mut BTreeMap<u32, Gathered>) {
    for piece in chunk.pieces.iter().filter(|p| p.kind == MoveKind::Feed) {
        let [from, to] = piece.pose;
        all.entry(piece.block).or_default().tip_way += (to.tip - from.tip).norm();
    }
    for sample in chunk.samples.iter().filter(|s| s.kind == MoveKind::Feed) {
        let of_block = all.entry(sample.block).or_default();
        of_block.reached = of_block.reached.max(sample.feed);
        for (j, joint) in machine.joints.iter().enumerate() {
            let used = |value: f64, limit: Option<f64>| limit.filter(|l| *l > 0.0).map(|l| value.abs() / l);
            let parts = [
                (used(sample.velocity[j], joint.max_velocity), JointLimit::Velocity),
                (used(sample.acceleration[j], joint.max_acceleration), JointLimit::Acceleration),
                (used(sample.jerk[j], joint.max_jerk), JointLimit::Jerk),
            ];
            for (part, limit) in parts.into_iter().filter_map(|(part, limit)| Some((part?, limit))) {
                if of_block.busiest.is_none_or(|(most, ..)| part > most) {
                    of_block.busiest = Some((part, j, limit));
                }
            }
        }
    }
}
