//! Rows of `clearance.parquet` and of `signals.parquet`.

use std::fs::File;
use std::path::Path;

use arrow_array::{Array, Float64Array, RecordBatch, StringArray, UInt32Array};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use proveout_machine::{JointValues, Machine};

use crate::TaskError;

/// No joint and no body is there, mm or radian: so far off sums lose what is claimed.
const BEYOND: f64 = 1e7;

/// A claim: over this time the two are apart by at least `distance - motion`, mm.
#[derive(Clone, Debug)]
pub(super) struct ClearanceClaim {
    pub(super) bodies: [String; 2],
    pub(super) time: [f64; 2],
    pub(super) distance: f64,
    pub(super) motion: f64,
    pub(super) low: JointValues,
    pub(super) high: JointValues,
    /// Ends of a straight motion, or one place twice; none where slides are free within the range.
    pub(super) straight: Option<[JointValues; 2]>,
    /// In that motion the points go along parabolas, and the motion that is claimed is what leaves these.
    pub(super) curved: bool,
}

impl ClearanceClaim {
    /// Whether its numbers are some.
    pub(super) fn is_told(&self) -> bool {
        let is_told = |x: f64| x.abs() < BEYOND;
        let mut ends = self.straight.iter().flatten().flat_map(|q| q.0);
        let mut ranges = self.low.0.into_iter().chain(self.high.0);
        is_told(self.distance)
            && is_told(self.motion)
            && ends.all(is_told)
            && ranges.all(|x| is_told(x) || x.is_infinite())
    }

    /// The joints that may be anywhere in it.
    pub(super) fn without_ends(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.low.0.len()).filter(|&j| !(self.low[j].is_finite() && self.high[j].is_finite()))
    }

    /// Joints in the middle of their ranges; at zero where a range has no ends.
    pub(super) fn middle(&self) -> JointValues {
        self.low.zip_map(self.high, |a, b| if a.is_finite() && b.is_finite() { 0.5 * (a + b) } else { 0.0 })
    }
}

/// Joints at a moment of the run.
#[derive(Clone, Debug)]
pub(super) struct JointSample {
    pub(super) time: f64,
    pub(super) joints: JointValues,
    /// Number of the tool in the spindle.
    pub(super) tool: Option<u32>,
}

fn batches(path: &Path, mut take: impl FnMut(&RecordBatch) -> Result<(), String>) -> Result<(), TaskError> {
    let fail = |e: String| TaskError(format!("{}: {e}", path.display()));
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).and_then(ParquetRecordBatchReaderBuilder::build);
    for batch in reader.map_err(|e| fail(e.to_string()))? {
        take(&batch.map_err(|e| fail(e.to_string()))?).map_err(fail)?;
    }
    Ok(())
}

fn column<'a, A: Array + 'static>(batch: &'a RecordBatch, name: &str) -> Result<&'a A, String> {
    let found = batch.column_by_name(name).and_then(|c| c.as_any().downcast_ref::<A>());
    found.ok_or_else(|| format!("no column {name}"))
}

/// Columns of the joints, with the factor to mm and radian.
fn joints<'a>(batch: &'a RecordBatch, machine: &Machine, word: &str) -> Result<Vec<(&'a Float64Array, f64)>, String> {
    let of = |j: &proveout_machine::Joint| {
        let name = format!("{}_{word}_{}", j.name, j.kind.unit());
        Ok((column::<Float64Array>(batch, &name)?, 1.0 / j.kind.unit_factor()))
    };
    machine.joints.iter().map(of).collect()
}

fn values(columns: &[(&Float64Array, f64)], row: usize) -> JointValues {
    let mut q = JointValues::ZERO;
    for (j, (column, factor)) in columns.iter().enumerate() {
        q[j] = column.value(row) * factor;
    }
    q
}

pub(super) fn spans(path: &Path, machine: &Machine) -> Result<Vec<ClearanceClaim>, TaskError> {
    let mut all = Vec::new();
    batches(path, |batch| {
        let names = [column::<StringArray>(batch, "body_a")?, column::<StringArray>(batch, "body_b")?];
        let real = |name| column::<Float64Array>(batch, name);
        let (begin, end) = (real("begin_s")?, real("end_s")?);
        let (distance, motion) = (real("distance_mm")?, real("motion_mm")?);
        let [low, high, from, to] = ["low", "high", "from", "to"].map(|w| joints(batch, machine, w));
        let (low, high, from, to) = (low?, high?, from?, to?);
        let curved = column::<UInt32Array>(batch, "curved")?;
        for row in 0..batch.num_rows() {
            let straight = from.first().is_some_and(|(c, _)| !c.is_null(row));
            all.push(ClearanceClaim {
                bodies: names.map(|n| n.value(row).to_owned()),
                time: [begin.value(row), end.value(row)],
                distance: distance.value(row),
                motion: motion.value(row),
                low: values(&low, row),
                high: values(&high, row),
                straight: straight.then(|| [values(&from, row), values(&to, row)]),
                curved: curved.value(row) != 0,
            });
        }
        Ok(())
    })?;
    Ok(all)
}

pub(super) fn samples(path: &Path, machine: &Machine) -> Result<Vec<JointSample>, TaskError> {
    let mut all = Vec::new();
    batches(path, |batch| {
        let (time, tool) = (column::<Float64Array>(batch, "time_s")?, column::<UInt32Array>(batch, "tool")?);
        let joints = joints(batch, machine, "actual")?;
        for row in 0..batch.num_rows() {
            all.push(JointSample {
                time: time.value(row),
                joints: values(&joints, row),
                tool: (!tool.is_null(row)).then(|| tool.value(row)),
            });
        }
        Ok(())
    })?;
    Ok(all)
}
