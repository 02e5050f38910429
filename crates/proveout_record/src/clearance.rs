//! `clearance.parquet`: what proves the least clearance of every pair of bodies.
//!
//! A row is a part of the motion of a pair in which it keeps apart by at least `distance_mm - motion_mm`. The
//! rows of a pair follow each other along the motion, without a gap in time while both bodies are in place.
//! See `docs/clearance.md`.

use std::path::Path;

use proveout_sim::{
    Observer,
    observer::{Batch, ClearanceProof, ObserverError, Outcome, Setup},
};

use crate::{
    error::RecordError,
    parquet_table::{Column, Table},
    units::JointUnit,
};

fn columns(joints: &[JointUnit]) -> Vec<Column> {
    let mut columns = vec![
        Column::text("body_a"),
        Column::text("body_b"),
        Column::real("begin_s", "s"),
        Column::real("end_s", "s"),
        Column::real("distance_mm", "mm"),
        Column::real("motion_mm", "mm"),
    ];
    for end in ["low", "high", "from", "to"] {
        columns.extend(joints.iter().map(|j| Column::real(format!("{}_{end}_{}", j.name, j.unit), j.unit)));
    }
    columns.push(Column::index("curved"));
    columns
}

fn write(path: &Path, joints: &[JointUnit], proof: &ClearanceProof) -> Result<(), RecordError> {
    let mut table = Table::create(path, &columns(joints), &[])?;
    let mut order: Vec<usize> = (0..proof.spans.len()).collect();
    order.sort_by_key(|&k| proof.spans[k].pair);
    for span in order.into_iter().map(|k| &proof.spans[k]) {
        let mut row = table.row()?;
        for body in &proof.bodies[span.pair] {
            row.text(Some(body));
        }
        row.reals([span.time[0], span.time[1], span.distance, span.motion]);
        for values in [Some(span.low), Some(span.high), span.straight.map(|s| s[0]), span.straight.map(|s| s[1])] {
            for (k, j) in joints.iter().enumerate() {
                row.real(values.map(|v| v[k] * j.factor));
            }
        }
        row.index(u32::from(span.curved));
    }
    table.finish()
}

/// Writes `clearance.parquet` at the end of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClearanceObserver;

impl Observer for ClearanceObserver {
    fn name(&self) -> &'static str {
        "clearance"
    }

    fn begin(&mut self, _setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        let path = outcome.folder.join("clearance.parquet");
        Ok(write(&path, &JointUnit::all(setup.machine), outcome.proof)?)
    }
}
