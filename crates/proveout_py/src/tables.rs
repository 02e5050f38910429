//! Tables as Arrow: read from the files of a run, handed out without a copy.

use std::{collections::BTreeMap, fs::File, path::PathBuf, sync::Arc};

use arrow_array::{Array, ArrayRef, RecordBatch, StructArray, cast::AsArray, types::Float64Type, types::UInt32Type};
use arrow_schema::{ArrowError, DataType, Field};
use numpy::IntoPyArray;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use proveout::front::CommandError;
use pyo3::{exceptions::PyKeyError, prelude::*, types::PyCapsule};
use pyo3_arrow::{
    buffer::PyArrowBuffer,
    ffi::{ArrayIterator, to_schema_pycapsule, to_stream_pycapsule},
};

use crate::errors::raised;

/// A table in memory: real columns (64 bit), counts (unsigned, 32 bit) and texts, null where a value is not
/// known.
///
/// Whatever reads the Arrow C stream interface takes it without a copy: `pyarrow.table(t)`,
/// `polars.DataFrame(t)`.
#[pyclass(frozen, module = "proveout._proveout")]
pub(crate) struct Table(RecordBatch);

impl Table {
    pub(crate) fn new(batch: RecordBatch) -> Self {
        Self(batch)
    }

    fn field(&self) -> Arc<Field> {
        Arc::new(Field::new_struct("", self.0.schema().fields().clone(), false))
    }

    fn array(&self, name: &str) -> PyResult<&ArrayRef> {
        self.0.column_by_name(name).ok_or_else(|| {
            let schema = self.0.schema();
            let names: Vec<&str> = schema.fields().iter().map(|f| f.name().as_str()).collect();
            let near = proveout_sim::nearest_word(name, names.iter().copied());
            let near = near.map_or_else(String::new, |n| format!("; did you mean {n:?}?"));
            PyKeyError::new_err(format!("no column {name:?}{near} (columns: {})", names.join(", ")))
        })
    }
}

#[pymethods]
impl Table {
    /// Names of the columns, in order.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.0.schema().fields().iter().map(|f| f.name().clone()).collect()
    }

    /// Unit of each column; empty for texts.
    #[getter]
    fn units(&self) -> BTreeMap<String, String> {
        let schema = self.0.schema();
        let unit = |f: &Arc<Field>| f.metadata().get("unit").cloned().unwrap_or_default();
        schema.fields().iter().map(|f| (f.name().clone(), unit(f))).collect()
    }

    #[getter]
    fn num_rows(&self) -> usize {
        self.0.num_rows()
    }

    #[getter]
    fn num_columns(&self) -> usize {
        self.0.num_columns()
    }

    fn __len__(&self) -> usize {
        self.0.num_rows()
    }

    fn __repr__(&self) -> String {
        format!("Table({} rows, {} columns)", self.0.num_rows(), self.0.num_columns())
    }

    /// A column: numbers as a read-only numpy view of the table's memory, or with nan for null as an array of
    /// its own; texts as a list.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let array = self.array(name)?;
        let view = |data: &dyn Array, kind: &str| -> PyResult<Bound<'py, PyAny>> {
            let data = data.to_data();
            let buffer = Bound::new(py, PyArrowBuffer::new(data.buffers()[0].clone()))?;
            let numpy = py.import("numpy")?;
            let (count, offset) = (data.len(), data.offset());
            let whole = numpy.call_method1("frombuffer", (buffer, kind))?;
            whole.get_item(pyo3::types::PySlice::new(py, offset as isize, (offset + count) as isize, 1))
        };
        let without_null = |values: Vec<f64>| -> PyResult<Bound<'py, PyAny>> {
            let array = values.into_pyarray(py).into_any();
            array.getattr("flags")?.setattr("writeable", false)?;
            Ok(array)
        };
        match array.data_type() {
            DataType::Float64 => {
                let values = array.as_primitive::<Float64Type>();
                match (values.null_count(), values.is_empty()) {
                    (0, false) => view(values, "f8"),
                    _ => without_null(values.iter().map(|v| v.unwrap_or(f64::NAN)).collect()),
                }
            }
            DataType::UInt32 => {
                let values = array.as_primitive::<UInt32Type>();
                match (values.null_count(), values.is_empty()) {
                    (0, false) => view(values, "u4"),
                    _ => without_null(values.iter().map(|v| v.map_or(f64::NAN, f64::from)).collect()),
                }
            }
            _ => {
                let texts: Vec<Option<&str>> = array.as_string_opt::<i32>().into_iter().flatten().collect();
                texts.into_pyobject(py)
            }
        }
    }

    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyCapsule>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let rows: ArrayRef = Arc::new(StructArray::from(self.0.clone()));
        let reader = ArrayIterator::new([Ok::<_, ArrowError>(rows)], self.field());
        Ok(to_stream_pycapsule(py, Box::new(reader), requested_schema)?)
    }

    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        Ok(to_schema_pycapsule(py, self.0.schema().as_ref())?)
    }
}

/// Reads a Parquet file whole.
#[pyfunction]
pub(crate) fn read_parquet(py: Python<'_>, file: PathBuf) -> PyResult<Table> {
    let read = || -> Result<Table, String> {
        let open = File::open(&file).map_err(|e| e.to_string())?;
        let builder = ParquetRecordBatchReaderBuilder::try_new(open).map_err(|e| e.to_string())?;
        let rows = usize::try_from(builder.metadata().file_metadata().num_rows()).unwrap_or_default();
        // One batch: each column is one piece of memory.
        let schema = Arc::clone(builder.schema());
        let mut batches = builder.with_batch_size(rows.max(1)).build().map_err(|e| e.to_string())?;
        let batch = batches.next().transpose().map_err(|e| e.to_string())?;
        Ok(Table(batch.unwrap_or_else(|| RecordBatch::new_empty(schema))))
    };
    let wrong = |e| CommandError::new(format!("{} cannot be read: {e}", file.display()), "run the scene again");
    py.detach(read).map_err(|e| raised(py, &wrong(e)))
}
