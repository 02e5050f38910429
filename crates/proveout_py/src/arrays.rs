//! Numbers of Rust as numpy arrays: the memory is handed over, not copied, and the arrays are read-only.

use numpy::{
    Element, IntoPyArray, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2,
    ndarray::{Array, Dimension, ShapeBuilder, StrideShape},
};
use pyo3::prelude::*;

use crate::errors::wrong;

/// An array that owns these numbers and is read-only.
///
/// # Errors
/// An internal error when the numbers do not fill the shape.
pub(crate) fn frozen<T: Element, D: Dimension>(
    py: Python<'_>,
    numbers: Vec<T>,
    shape: impl Into<StrideShape<D>>,
) -> PyResult<Py<PyArray<T, D>>> {
    let array = Array::from_shape_vec(shape, numbers).map_err(|e| wrong(py, format!("array shape: {e}"), ""))?;
    let array = array.into_pyarray(py);
    array.try_readwrite()?.make_nonwriteable();
    Ok(array.unbind())
}

/// Rows of numbers, by rows.
pub(crate) fn frozen_rows<T: Element>(py: Python<'_>, numbers: Vec<T>, width: usize) -> PyResult<Py<PyArray2<T>>> {
    let rows = numbers.len() / width.max(1);
    frozen(py, numbers, (rows, width))
}

/// A row of numbers.
pub(crate) fn frozen_row<T: Element>(py: Python<'_>, numbers: Vec<T>) -> PyResult<Py<PyArray1<T>>> {
    let length = numbers.len();
    frozen(py, numbers, length.f())
}

/// The rows of an array of finite numbers, each of `width`.
///
/// # Errors
/// Another shape, or a number that is not finite, named by its row and column.
pub(crate) fn rows(py: Python<'_>, array: &PyReadonlyArray2<'_, f64>, names: &[&str]) -> PyResult<Vec<Vec<f64>>> {
    let array = array.as_array();
    if array.ncols() != names.len() {
        let message =
            format!("each row has {} numbers, but {} are needed: {}", array.ncols(), names.len(), names.join(", "));
        return Err(wrong(py, message, "give an array of shape (n, columns), or one row"));
    }
    for (row, values) in array.rows().into_iter().enumerate() {
        if let Some(column) = values.iter().position(|v| !v.is_finite()) {
            let message = format!("row {row}: {} is {}, not a finite number", names[column], values[column]);
            return Err(wrong(py, message, "remove rows with unknown values"));
        }
    }
    Ok(array.rows().into_iter().map(|r| r.to_vec()).collect())
}
