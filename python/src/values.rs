//! Results as Python objects.

use glam::{Mat4, Vec3};
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::Value;

/// The numbers of vectors.
fn floats(vectors: &[Vec3]) -> Vec<f32> {
    bytemuck::cast_slice(vectors).to_vec()
}

fn misshapen(error: numpy::ndarray::ShapeError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A picture of `(height, width, 3)`; the array owns the memory that was rendered into.
pub(crate) fn image<'py>(
    py: Python<'py>,
    [width, height]: [usize; 2],
    pixels: Vec<f32>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    Ok(Array3::from_shape_vec((height, width, 3), pixels).map_err(misshapen)?.into_pyarray(py))
}

/// A layer of a picture.
pub(crate) fn layer<'py>(py: Python<'py>, size: [usize; 2], pixels: &[Vec3]) -> PyResult<Bound<'py, PyArray3<f32>>> {
    image(py, size, floats(pixels))
}

/// One number a pixel.
pub(crate) fn plane<'py, T: numpy::Element>(
    py: Python<'py>,
    [width, height]: [usize; 2],
    pixels: Vec<T>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    Ok(Array2::from_shape_vec((height, width), pixels).map_err(misshapen)?.into_pyarray(py))
}

/// Rows of three numbers.
pub(crate) fn rows<'py>(py: Python<'py>, vectors: &[Vec3]) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let count = vectors.len();
    Ok(Array2::from_shape_vec((count, 3), floats(vectors)).map_err(misshapen)?.into_pyarray(py))
}

pub(crate) fn vector(v: Vec3) -> (f32, f32, f32) {
    v.into()
}

/// A matrix, row by row.
pub(crate) fn matrix<'py>(py: Python<'py>, matrix: &Mat4) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let rows = matrix.transpose().to_cols_array().to_vec();
    Ok(Array2::from_shape_vec((4, 4), rows).map_err(misshapen)?.into_pyarray(py))
}

/// Matrices, row by row.
pub(crate) fn matrices<'py>(py: Python<'py>, all: &[Mat4]) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let rows = all.iter().flat_map(|matrix| matrix.transpose().to_cols_array()).collect();
    Ok(Array3::from_shape_vec((all.len(), 4, 4), rows).map_err(misshapen)?.into_pyarray(py))
}

/// A report as dictionaries, lists and numbers.
pub(crate) fn report<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Null => Ok(py.None().into_bound(py)),
        Value::Bool(is) => is.into_bound_py_any(py),
        Value::Number(n) => match n.as_i64() {
            Some(whole) => whole.into_bound_py_any(py),
            None => n.as_f64().into_bound_py_any(py),
        },
        Value::String(text) => text.into_bound_py_any(py),
        Value::Array(items) => {
            let list = PyList::empty(py);
            items.iter().try_for_each(|item| list.append(report(py, item)?))?;
            Ok(list.into_any())
        }
        Value::Object(items) => {
            let all = PyDict::new(py);
            items.iter().try_for_each(|(key, item)| all.set_item(key, report(py, item)?))?;
            Ok(all.into_any())
        }
    }
}

/// A serialisable report.
pub(crate) fn fields<'py>(py: Python<'py>, value: serde_json::Result<Value>) -> PyResult<Bound<'py, PyDict>> {
    let value = value.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(report(py, &value)?.cast_into::<PyDict>()?)
}
