//! Planned and re-scheduled programs, and the canonical commands of NC text.

use std::{path::PathBuf, sync::Arc};

use arrow_array::{
    ArrayRef, RecordBatch,
    builder::{Float64Builder, StringBuilder, UInt32Builder},
};
use arrow_schema::{DataType, Field, Schema};
use proveout::front::{self, CommandError, ReaderOptions};
use proveout_nc::JsonWriter;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::{tables::Table, work::beside};

fn json_fault(error: impl std::fmt::Display) -> CommandError {
    CommandError::new(format!("JSON cannot be written: {error}"), "")
}

/// A program for the blade of a scene, and as JSON what it asks of the machine (null for a helix).
#[pyfunction]
pub(crate) fn plan(
    py: Python<'_>,
    scene: PathBuf,
    strategy: String,
    dialect: Option<String>,
) -> PyResult<(String, String)> {
    beside(py, None, |_| {
        let (text, report) = front::plan(&scene, &strategy, None, front::dialect(dialect.as_deref())?)?;
        Ok((text, serde_json::to_string(&report).map_err(json_fault)?))
    })
}

/// A program of a scene with new tool axes, and as JSON what is known of it.
#[pyfunction]
pub(crate) fn reschedule(
    py: Python<'_>,
    scene: PathBuf,
    program: String,
    method: String,
    options: Vec<(String, String)>,
    dialect: Option<String>,
) -> PyResult<(String, String)> {
    beside(py, None, |_| {
        let options: Vec<(&str, &str)> = options.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        let dialect = front::dialect(dialect.as_deref())?;
        let work = front::reschedule(&scene, &program, &method, &options, "options:", dialect)?;
        let runs = work.made.certificate.runs.iter().map(|run| {
            json!({
                "lines": run.lines, "time_s": run.time_s, "original_time_s": run.original_time_s, "bound_s": run.bound_s,
                "gain_percent": run.gain_percent(), "gap_percent": run.gap_percent,
            })
        });
        let channels = work.made.channels.iter().map(|c| {
            json!({ "name": c.name, "narrowest_deg": c.narrowest_deg, "least_velocity_deg_s": c.least_velocity_deg_s })
        });
        let options: serde_json::Map<String, Value> =
            work.options.iter().map(|(k, v)| ((*k).to_owned(), Value::from(v.as_str()))).collect();
        let info = json!({
            "method": method, "source": work.source, "entry": work.entry, "options": options,
            "runs": runs.collect::<Vec<_>>(), "channels": channels.collect::<Vec<_>>(), "uncertified": work.made.uncertified,
            "certificate": serde_json::to_value(&work.made.certificate).map_err(json_fault)?,
        });
        Ok((work.made.text, info.to_string()))
    })
}

/// Letters of axes with their units, as columns of the table of commands have them.
const AXES: [(&str, &str); 9] = [
    ("X", "mm"),
    ("Y", "mm"),
    ("Z", "mm"),
    ("A", "deg"),
    ("B", "deg"),
    ("C", "deg"),
    ("U", "mm"),
    ("V", "mm"),
    ("W", "mm"),
];
/// Numbers that are direct members of a command line, with their units.
const NUMBERS: [(&str, &str); 5] = [
    ("feed_mm_min", "mm/min"),
    ("feed_mm_rev", "mm/rev"),
    ("inverse_time_min", "1/min"),
    ("speed_rpm", "1/min"),
    ("radius", "mm"),
];

/// The table of canonical commands under way: a row a line of `docs/nc-json.md`.
#[derive(Default)]
struct Rows {
    file: StringBuilder,
    /// Line, column, depth.
    place: [UInt32Builder; 3],
    op: StringBuilder,
    /// Programmed ends, base coordinates.
    ends: [[Float64Builder; AXES.len()]; 2],
    axis: [Float64Builder; 3],
    numbers: [Float64Builder; NUMBERS.len()],
    json: StringBuilder,
}

impl Rows {
    fn add(&mut self, line: &Value) {
        self.file.append_option(line["file"].as_str());
        for (builder, key) in self.place.iter_mut().zip(["line", "column", "depth"]) {
            builder.append_option(line[key].as_u64().and_then(|n| u32::try_from(n).ok()));
        }
        self.op.append_option(line["op"].as_str());
        for (builders, key) in self.ends.iter_mut().zip(["end", "end_base"]) {
            for (builder, (letter, _)) in builders.iter_mut().zip(AXES) {
                builder.append_option(line[key][letter].as_f64());
            }
        }
        for (k, builder) in self.axis.iter_mut().enumerate() {
            builder.append_option(line["end"]["axis"][k].as_f64());
        }
        for (builder, (key, _)) in self.numbers.iter_mut().zip(NUMBERS) {
            builder.append_option(line[key].as_f64());
        }
        self.json.append_value(line.to_string());
    }

    fn finish(mut self) -> Result<RecordBatch, CommandError> {
        let mut columns: Vec<(String, &str, ArrayRef)> = vec![("file".into(), "", Arc::new(self.file.finish()))];
        for (builder, name) in self.place.iter_mut().zip(["line", "column", "depth"]) {
            columns.push((name.into(), "1", Arc::new(builder.finish())));
        }
        columns.push(("op".into(), "", Arc::new(self.op.finish())));
        for (builders, which) in self.ends.iter_mut().zip(["", "_base"]) {
            for (builder, (letter, unit)) in builders.iter_mut().zip(AXES) {
                columns.push((format!("{letter}{which}_{unit}"), unit, Arc::new(builder.finish())));
            }
        }
        for (builder, name) in self.axis.iter_mut().zip(["i", "j", "k"]) {
            columns.push((format!("axis_{name}"), "1", Arc::new(builder.finish())));
        }
        for (builder, (name, unit)) in self.numbers.iter_mut().zip(NUMBERS) {
            let name = if name == "radius" { "radius_mm" } else { name };
            columns.push((name.into(), unit, Arc::new(builder.finish())));
        }
        columns.push(("json".into(), "", Arc::new(self.json.finish())));
        let field = |(name, unit, array): &(String, &str, ArrayRef)| {
            let kind: &DataType = array.data_type();
            let unit = [("unit".to_owned(), (*unit).to_owned())].into();
            Field::new(name, kind.clone(), true).with_metadata(unit)
        };
        let schema = Schema::new(columns.iter().map(field).collect::<Vec<_>>());
        let arrays = columns.into_iter().map(|(.., array)| array).collect();
        RecordBatch::try_new(Arc::new(schema), arrays).map_err(json_fault)
    }
}

/// The canonical commands of a program.
#[pyfunction]
#[pyo3(signature = (program, *, machine, tools, dialect, control, variables, offsets, feed_mm_min, subprograms))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of one Python call")]
pub(crate) fn read_nc(
    py: Python<'_>,
    program: PathBuf,
    machine: Option<PathBuf>,
    tools: Option<PathBuf>,
    dialect: Option<String>,
    control: Option<String>,
    variables: Vec<String>,
    offsets: Vec<String>,
    feed_mm_min: Option<f64>,
    subprograms: Vec<PathBuf>,
) -> PyResult<Table> {
    let how = ReaderOptions { machine, tools, dialect, control, variables, offsets, feed_mm_min, subprograms };
    let batch = beside(py, None, |shared| {
        let (mut rows, mut writer) = (Rows::default(), JsonWriter::new());
        front::canonical(&program, &how, &mut |command| {
            shared.leave_if_it_ends();
            writer.values(command).iter().for_each(|line| rows.add(line));
        })?;
        rows.finish()
    })?;
    Ok(Table::new(batch))
}
