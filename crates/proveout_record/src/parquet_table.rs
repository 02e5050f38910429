//! Parquet tables of bounded memory and stable bytes.

use std::{
    collections::HashMap,
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
    sync::Arc,
};

use arrow_array::{
    ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch,
    builder::{BooleanBufferBuilder, StringBuilder},
    types::{Float64Type, UInt32Type},
};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::{
    arrow::{ArrowWriter, arrow_writer::ArrowWriterOptions},
    basic::{Compression, Encoding, ZstdLevel},
    file::{
        metadata::KeyValue,
        properties::{EnabledStatistics, WriterProperties},
    },
    schema::types::ColumnPath,
};

use crate::error::RecordError;

/// Rows that are held at most before they are written as one row group.
const ROW_GROUP: usize = 1 << 16;
/// Cells of the same: 9 MB, and as much again while they are written.
const CELLS: usize = 1 << 20;
/// Compression level: at 3 files shrink by 2 percent and take twice the time.
const ZSTD_LEVEL: i32 = 1;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColumnKind {
    /// Double precision, null where unknown.
    Real,
    /// Unsigned, 32 bit, null where none applies.
    Index,
    /// Text.
    Text,
}

/// A column: its name (with the unit at the end), and the unit once more as field metadata.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: &'static str,
    pub(crate) kind: ColumnKind,
}

impl Column {
    pub(crate) fn real(name: impl Into<String>, unit: &'static str) -> Self {
        Self { name: name.into(), unit, kind: ColumnKind::Real }
    }

    pub(crate) fn index(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: "1", kind: ColumnKind::Index }
    }

    pub(crate) fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: "", kind: ColumnKind::Text }
    }

    fn field(&self) -> Field {
        let kind = match self.kind {
            ColumnKind::Real => DataType::Float64,
            ColumnKind::Index => DataType::UInt32,
            ColumnKind::Text => DataType::Utf8,
        };
        // One entry only: more would be written in the order of a hash map.
        Field::new(&self.name, kind, true).with_metadata(HashMap::from([("unit".to_owned(), self.unit.to_owned())]))
    }
}

/// Numbers of a column, and the rows that have none: mostly no row or each, so that a number costs one step.
struct NumberColumn<T: ArrowPrimitiveType> {
    values: Vec<T::Native>,
    unknown: Vec<u32>,
}

impl<T: ArrowPrimitiveType> NumberColumn<T> {
    fn new() -> Self {
        Self { values: Vec::new(), unknown: Vec::new() }
    }

    fn put(&mut self, value: Option<T::Native>) {
        if value.is_none() {
            self.unknown.push(self.values.len() as u32);
        }
        self.values.push(value.unwrap_or_default());
    }

    fn take(&mut self) -> ArrayRef {
        let (values, unknown) = (std::mem::take(&mut self.values), std::mem::take(&mut self.unknown));
        let known = (!unknown.is_empty()).then(|| {
            let mut known = BooleanBufferBuilder::new(values.len());
            known.append_n(values.len(), true);
            unknown.iter().for_each(|row| known.set_bit(*row as usize, false));
            known.finish().into()
        });
        Arc::new(PrimitiveArray::<T>::new(values.into(), known))
    }
}

enum ColumnBuilder {
    Real(NumberColumn<Float64Type>),
    Index(NumberColumn<UInt32Type>),
    Text(StringBuilder),
}

/// A table that is being written: rows are pushed cell by cell, row groups go to the file as they fill.
pub(crate) struct Table {
    path: PathBuf,
    writer: ArrowWriter<BufWriter<File>>,
    schema: SchemaRef,
    held: Vec<ColumnBuilder>,
    rows: usize,
}

/// One row being filled, left to right. Cells of the wrong kind, missing and surplus cells are a fault of
/// this crate; they are written as null or dropped so that no row is lost.
pub(crate) struct RowWriter<'a> {
    held: std::slice::IterMut<'a, ColumnBuilder>,
}

impl RowWriter<'_> {
    pub(crate) fn real(&mut self, value: impl Into<Option<f64>>) -> &mut Self {
        match self.held.next() {
            Some(ColumnBuilder::Real(v)) => v.put(value.into()),
            other => missing(other),
        }
        self
    }

    pub(crate) fn reals(&mut self, values: impl IntoIterator<Item = f64>) -> &mut Self {
        for v in values {
            self.real(v);
        }
        self
    }

    pub(crate) fn index(&mut self, value: impl Into<Option<u32>>) -> &mut Self {
        match self.held.next() {
            Some(ColumnBuilder::Index(v)) => v.put(value.into()),
            other => missing(other),
        }
        self
    }

    pub(crate) fn text(&mut self, value: Option<&str>) -> &mut Self {
        match self.held.next() {
            Some(ColumnBuilder::Text(v)) => v.append_option(value),
            other => missing(other),
        }
        self
    }
}

impl Drop for RowWriter<'_> {
    fn drop(&mut self) {
        for held in self.held.by_ref() {
            missing(Some(held));
        }
    }
}

fn missing(held: Option<&mut ColumnBuilder>) {
    debug_assert!(false, "a row does not fit its columns");
    match held {
        Some(ColumnBuilder::Real(v)) => v.put(None),
        Some(ColumnBuilder::Index(v)) => v.put(None),
        Some(ColumnBuilder::Text(v)) => v.append_null(),
        None => {}
    }
}

impl Table {
    /// Starts a table; `notes` are key and value pairs for the file's metadata, in their order.
    pub(crate) fn create(path: &Path, columns: &[Column], notes: &[(&str, String)]) -> Result<Self, RecordError> {
        let schema = Arc::new(Schema::new(columns.iter().map(Column::field).collect::<Vec<_>>()));
        let level = ZstdLevel::try_new(ZSTD_LEVEL).map_err(RecordError::table(path))?;
        let mut properties = WriterProperties::builder()
            .set_created_by(concat!("proveout ", env!("CARGO_PKG_VERSION")).into())
            .set_compression(Compression::ZSTD(level))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .set_max_row_group_row_count(Some(ROW_GROUP))
            .set_key_value_metadata(Some(
                notes.iter().map(|(k, v)| KeyValue::new((*k).to_owned(), v.clone())).collect(),
            ));
        for column in columns.iter().filter(|c| c.kind == ColumnKind::Real) {
            // Smooth signals: the bytes of equal weight together compress to about half.
            let path = ColumnPath::new(vec![column.name.clone()]);
            properties = properties
                .set_column_dictionary_enabled(path.clone(), false)
                .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
        }
        let file = BufWriter::new(File::create(path).map_err(RecordError::io(path))?);
        let options = ArrowWriterOptions::new().with_properties(properties.build());
        let writer =
            ArrowWriter::try_new_with_options(file, Arc::clone(&schema), options).map_err(RecordError::table(path))?;
        let held = columns.iter().map(|c| empty(c.kind)).collect();
        Ok(Self { path: path.to_path_buf(), writer, schema, held, rows: 0 })
    }

    /// Begins a row; writes a row group when one is full.
    pub(crate) fn row(&mut self) -> Result<RowWriter<'_>, RecordError> {
        if self.rows >= ROW_GROUP.min(CELLS / self.held.len().max(1)) {
            self.flush()?;
        }
        self.rows += 1;
        Ok(RowWriter { held: self.held.iter_mut() })
    }

    /// Writes the rows that are held as a row group.
    pub(crate) fn flush(&mut self) -> Result<(), RecordError> {
        if self.rows == 0 {
            return Ok(());
        }
        self.rows = 0;
        let arrays: Vec<ArrayRef> = self.held.iter_mut().map(take).collect();
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays).map_err(RecordError::table(&self.path))?;
        self.writer.write(&batch).map_err(RecordError::table(&self.path))?;
        self.writer.flush().map_err(RecordError::table(&self.path))
    }

    /// Writes what is held, and the footer.
    pub(crate) fn finish(mut self) -> Result<(), RecordError> {
        self.flush()?;
        self.writer.close().map_err(RecordError::table(&self.path))?;
        Ok(())
    }
}

fn empty(kind: ColumnKind) -> ColumnBuilder {
    match kind {
        ColumnKind::Real => ColumnBuilder::Real(NumberColumn::new()),
        ColumnKind::Index => ColumnBuilder::Index(NumberColumn::new()),
        ColumnKind::Text => ColumnBuilder::Text(StringBuilder::new()),
    }
}

fn take(held: &mut ColumnBuilder) -> ArrayRef {
    match held {
        ColumnBuilder::Real(v) => v.take(),
        ColumnBuilder::Index(v) => v.take(),
        ColumnBuilder::Text(v) => Arc::new(v.finish()),
    }
}

#[cfg(test)]
mod tests {
    use arrow_array::{Array, cast::AsArray};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

    use super::*;

    fn columns() -> Vec<Column> {
        let (none, tooth) = (Column::real("none", "1"), Column::index("tooth"));
        vec![
            Column::real("time_s", "s"),
            Column::index("block"),
            Column::text("file"),
            Column::real("X_mm", "mm"),
            none,
            tooth,
        ]
    }

    fn write(path: &Path, rows: u32) {
        let mut table = Table::create(path, &columns(), &[("frame", "workpiece".into())]).expect("created");
        for i in 0..rows {
            let known = (i % 3 != 0).then_some(f64::from(i) * 0.25);
            let tooth = (i % 5 == 4).then_some(i % 2);
            let mut row = table.row().expect("row");
            row.real(f64::from(i) * 1e-3).index(i / 7).text(Some("part.mpf")).real(known).real(None).index(tooth);
        }
        table.finish().expect("finished");
    }

    #[test]
    fn what_is_read_is_what_was_written_over_several_row_groups() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("t.parquet");
        let rows = 2 * ROW_GROUP as u32 + 5;
        write(&path, rows);
        let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(&path).expect("file")).expect("parquet");
        assert_eq!(builder.metadata().num_row_groups(), 3);
        let schema = Arc::clone(builder.schema());
        assert_eq!(
            schema.fields().iter().map(|f| f.name().as_str()).collect::<Vec<_>>(),
            ["time_s", "block", "file", "X_mm", "none", "tooth"]
        );
        assert_eq!(schema.field(3).metadata()["unit"], "mm");
        let mut i = 0;
        for batch in builder.build().expect("reader") {
            let batch = batch.expect("batch");
            let time = batch.column(0).as_primitive::<Float64Type>();
            let block = batch.column(1).as_primitive::<UInt32Type>();
            let x = batch.column(3).as_primitive::<Float64Type>();
            let tooth = batch.column(5).as_primitive::<UInt32Type>();
            assert_eq!(batch.column(4).null_count(), batch.num_rows());
            for r in 0..batch.num_rows() {
                assert_eq!((time.value(r), block.value(r)), (f64::from(i) * 1e-3, i / 7));
                assert_eq!(x.is_null(r), i % 3 == 0);
                assert!(x.is_null(r) || x.value(r) == f64::from(i) * 0.25);
                assert_eq!(tooth.is_valid(r).then(|| tooth.value(r)), (i % 5 == 4).then_some(i % 2));
                i += 1;
            }
        }
        assert_eq!(i, rows);
    }

    #[test]
    fn same_rows_same_bytes() {
        let folder = tempfile::tempdir().expect("folder");
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        write(&a, 1000);
        write(&b, 1000);
        assert_eq!(std::fs::read(a).expect("a"), std::fs::read(b).expect("b"));
    }

    #[test]
    fn a_table_without_rows_has_its_columns() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("t.parquet");
        write(&path, 0);
        let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(&path).expect("file")).expect("parquet");
        assert_eq!(builder.schema().fields().len(), 6);
        assert_eq!(builder.metadata().file_metadata().num_rows(), 0);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = Table::create(Path::new("/no/such/folder/t.parquet"), &columns(), &[]).err().expect("refused");
        assert!(error.to_string().contains("/no/such/folder/t.parquet"), "{error}");
    }
}
