//! Arguments: numbers, vectors and arrays, each refused by its name.
//!
//! Arrays are numpy arrays of float32 or float64 (indices: any integers of 32 or 64 bits) with any strides; they are copied once,
//! into the library's own memory.

use glam::{Mat3, Mat4, Vec3};
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// The name of an object's type.
pub(crate) fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string())
}

/// Finite numbers of an iterable; `None` if it is no such thing.
fn numbers(value: &Bound<'_, PyAny>, most: usize) -> Option<Vec<f32>> {
    let items = value.try_iter().ok()?;
    items.take(most + 1).map(|item| item.ok()?.extract::<f64>().ok().map(|x| x as f32)).collect()
}

/// Three finite numbers.
pub(crate) fn vec3(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    let wanted = "expected three numbers";
    match numbers(value, 3).as_deref() {
        Some(&[x, y, z]) if Vec3::new(x, y, z).is_finite() => Ok(Vec3::new(x, y, z)),
        Some(&[x, y, z]) => Err(PyValueError::new_err(format!("{name} is [{x}, {y}, {z}]: expected finite numbers"))),
        Some(list) if list.len() < 3 => {
            Err(PyValueError::new_err(format!("{name} has {} numbers: {wanted}", list.len())))
        }
        Some(_) => Err(PyValueError::new_err(format!("{name} has more than 3 numbers: {wanted}"))),
        None => Err(PyTypeError::new_err(format!("{name} is of type {}: {wanted}", type_name(value)))),
    }
}

/// A vector of any length but 0, as a unit vector.
pub(crate) fn direction(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    let v = vec3(name, value)?;
    v.try_normalize().ok_or_else(|| PyValueError::new_err(format!("{name} is {v}: expected a direction")))
}

/// A colour: three numbers of at least 0, or one for grey.
pub(crate) fn color(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    let color = match value.extract::<f64>() {
        Ok(grey) => Vec3::splat(grey as f32),
        Err(_) if numbers(value, 3).is_none() => {
            let kind = type_name(value);
            return Err(PyTypeError::new_err(format!("{name} is of type {kind}: expected a number, or three")));
        }
        Err(_) => vec3(name, value)?,
    };
    if color.is_finite() && color.min_element() >= 0.0 {
        return Ok(color);
    }
    Err(PyValueError::new_err(format!("{name} is {color}: expected finite numbers of at least 0")))
}

/// A number above 0.
pub(crate) fn positive(name: &str, value: f64) -> PyResult<f32> {
    let x = value as f32;
    if x > 0.0 && x.is_finite() {
        return Ok(x);
    }
    Err(PyValueError::new_err(format!("{name} is {value}: expected a number above 0")))
}

/// A number within bounds, both included.
pub(crate) fn within(name: &str, value: f64, least: f64, most: f64) -> PyResult<f32> {
    if (least..=most).contains(&value) {
        return Ok(value as f32);
    }
    Err(PyValueError::new_err(format!("{name} is {value}: expected a number from {least} to {most}")))
}

/// The rows of an `N` × `N` matrix.
fn square<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f32; N]; N]> {
    let wanted = format!("expected a {N} x {N} matrix");
    let wrong = || PyTypeError::new_err(format!("{name} is of type {}: {wanted}", type_name(value)));
    let rows: Vec<Vec<f32>> = value
        .try_iter()
        .map_err(|_| wrong())?
        .take(N + 1)
        .map(|row| row.ok().and_then(|row| numbers(&row, N)).ok_or_else(wrong))
        .collect::<PyResult<_>>()?;
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
    let matrix: Option<Vec<[f32; N]>> = rows.iter().map(|row| row.as_slice().try_into().ok()).collect();
    let matrix = matrix.and_then(|rows| <[[f32; N]; N]>::try_from(rows).ok());
    let matrix = matrix.ok_or_else(|| {
        PyValueError::new_err(format!("{name} has {} rows of {widest} numbers: {wanted}", rows.len()))
    })?;
    if matrix.iter().flatten().all(|x| x.is_finite()) {
        return Ok(matrix);
    }
    Err(PyValueError::new_err(format!("{name}: expected finite numbers")))
}

/// A 4 × 4 matrix, row by row, that maps column vectors: the translation is its last column.
pub(crate) fn matrix(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Mat4> {
    let rows = square::<4>(name, value)?;
    if rows[3] == [0.0, 0.0, 0.0, 1.0] {
        return Ok(Mat4::from_cols_array_2d(&rows).transpose());
    }
    Err(PyValueError::new_err(format!("{name} has the last row {:?}: expected [0, 0, 0, 1]", rows[3])))
}

/// Matrices as [`matrix`] reads them: an array `(n, 4, 4)`, or a sequence of matrices.
pub(crate) fn matrices(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Mat4>> {
    let wrong = |_| {
        PyTypeError::new_err(format!("{name} is of type {}: expected an array of shape (n, 4, 4)", type_name(value)))
    };
    let all = value.try_iter().map_err(wrong)?;
    all.enumerate().map(|(i, one)| matrix(&format!("{name}[{i}]"), &one?)).collect()
}

/// A 3 × 3 matrix, row by row.
pub(crate) fn matrix3(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Mat3> {
    Ok(Mat3::from_cols_array_2d(&square::<3>(name, value)?).transpose())
}

/// `(n, 3)`, `(height, width, 3)`.
pub(crate) fn shape_of(array: &Bound<'_, PyUntypedArray>) -> String {
    let sides: Vec<String> = array.shape().iter().map(ToString::to_string).collect();
    if sides.len() == 1 { format!("({},)", sides[0]) } else { format!("({})", sides.join(", ")) }
}

/// The reason why a value is no array of a shape and of some types.
pub(crate) fn refuse(name: &str, value: &Bound<'_, PyAny>, shape: &str, types: &str) -> PyErr {
    let Ok(array) = value.cast::<PyUntypedArray>() else {
        let kind = type_name(value);
        return PyTypeError::new_err(format!("{name} is of type {kind}: expected a numpy array of shape {shape}"));
    };
    let dtype = array.dtype().to_string();
    if types.split(", ").all(|known| known != dtype) {
        return PyTypeError::new_err(format!("{name} has dtype {dtype}: expected {types}"));
    }
    PyValueError::new_err(format!("{name} has shape {}: expected {shape}", shape_of(array)))
}

const FLOATS: &str = "float32, float64";
const INTEGERS: &str = "int32, int64, uint32, uint64";

/// The rows of a two-dimensional array of one type.
fn rows_of<T: Element + Copy, U, const N: usize>(
    value: &Bound<'_, PyAny>,
    convert: &impl Fn(T) -> U,
) -> Option<PyResult<Vec<[U; N]>>> {
    let array = value.cast::<PyArray2<T>>().ok().filter(|array| array.shape()[1] == N)?;
    Some(array.try_readonly().map_err(PyErr::from).map(|array| {
        let array = array.as_array();
        array.rows().into_iter().map(|row| core::array::from_fn(|k| convert(row[k]))).collect()
    }))
}

/// Rows of finite numbers.
pub(crate) fn rows<const N: usize>(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f32; N]>> {
    let rows = rows_of(value, &|x: f32| x)
        .or_else(|| rows_of(value, &|x: f64| x as f32))
        .unwrap_or_else(|| Err(refuse(name, value, &format!("(n, {N})"), FLOATS)))?;
    match rows.iter().position(|row| !row.iter().all(|x| x.is_finite())) {
        None => Ok(rows),
        Some(i) => Err(PyValueError::new_err(format!("{name}[{i}] is {:?}: expected finite numbers", rows[i]))),
    }
}

/// Points or vectors.
pub(crate) fn points(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    Ok(rows::<3>(name, value)?.into_iter().map(Vec3::from_array).collect())
}

/// As many vectors as there are points, made unit vectors.
pub(crate) fn directions(name: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Vec3>> {
    let mut all = points(name, value)?;
    same_count(name, all.len(), count)?;
    for (i, v) in all.iter_mut().enumerate() {
        let unit = v.try_normalize();
        *v = unit.ok_or_else(|| PyValueError::new_err(format!("{name}[{i}] is {v}: expected a direction")))?;
    }
    Ok(all)
}

pub(crate) fn same_count(name: &str, count: usize, wanted: usize) -> PyResult<()> {
    if count == wanted {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("{name} has {count} rows: expected {wanted}, one for each point")))
}

/// Triangles: three numbers below `vertices` each.
pub(crate) fn triangles(name: &str, value: &Bound<'_, PyAny>, vertices: usize) -> PyResult<Vec<[u32; 3]>> {
    // Above all that are valid, so that the check below finds it.
    let none = u32::MAX;
    let rows: Vec<[u32; 3]> = rows_of(value, &|i: u32| i)
        .or_else(|| rows_of(value, &|i: i64| u32::try_from(i).unwrap_or(none)))
        .or_else(|| rows_of(value, &|i: i32| u32::try_from(i).unwrap_or(none)))
        .or_else(|| rows_of(value, &|i: u64| u32::try_from(i).unwrap_or(none)))
        .unwrap_or_else(|| Err(refuse(name, value, "(n, 3)", INTEGERS)))?;
    match rows.iter().position(|row| row.iter().any(|i| *i as usize >= vertices)) {
        None => Ok(rows),
        Some(i) => {
            let fault = format!("{name}[{i}] names a vertex that does not exist: there are {vertices}");
            Err(PyValueError::new_err(fault))
        }
    }
}

/// Whole numbers, one a point.
pub(crate) fn numbers_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<i64>> {
    let narrow = |array: &Bound<'_, PyArray1<i32>>| {
        array.try_readonly().map(|a| a.as_array().iter().map(|n| i64::from(*n)).collect())
    };
    let wide = |array: &Bound<'_, PyArray1<i64>>| array.try_readonly().map(|a| a.as_array().iter().copied().collect());
    if let Ok(array) = value.cast::<PyArray1<i64>>() {
        return Ok(wide(array)?);
    }
    match value.cast::<PyArray1<i32>>() {
        Ok(array) => Ok(narrow(array)?),
        Err(_) => Err(refuse(name, value, "(n,)", "int32, int64")),
    }
}

/// Width, height and pixels of a picture, the top row first.
pub(crate) fn picture(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(usize, usize, Vec<Vec3>)> {
    let read = picture_of(value, &|x: f32| x)
        .or_else(|| picture_of(value, &|x: f64| x as f32))
        .unwrap_or_else(|| Err(refuse(name, value, "(height, width, 3)", FLOATS)))?;
    match read.2.iter().position(|pixel| !pixel.is_finite()) {
        None => Ok(read),
        Some(i) => {
            let (row, column) = (i / read.0.max(1), i % read.0.max(1));
            let fault = format!("{name}[{row}, {column}] is {}: expected finite numbers", read.2[i]);
            Err(PyValueError::new_err(fault))
        }
    }
}

fn picture_of<T: Element + Copy>(
    value: &Bound<'_, PyAny>,
    convert: &impl Fn(T) -> f32,
) -> Option<PyResult<(usize, usize, Vec<Vec3>)>> {
    let array = value.cast::<PyArray3<T>>().ok()?;
    let &[height, width, 3] = array.shape() else { return None };
    Some(array.try_readonly().map_err(PyErr::from).map(|array| {
        let array = array.as_array();
        let pixel = |row: usize, column: usize| {
            Vec3::from_array(core::array::from_fn(|channel| convert(array[[row, column, channel]])))
        };
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
        (width, height, pixels.map(|(row, column)| pixel(row, column)).collect())
    }))
}

/// Numbers of which exactly one is given, by their names.
pub(crate) fn one_of<'a, 'py>(
    given: &[(&'static str, &'a Option<Bound<'py, PyAny>>)],
) -> PyResult<(&'static str, &'a Bound<'py, PyAny>)> {
    let mut some = given.iter().filter_map(|(name, value)| value.as_ref().map(|value| (*name, value)));
    match (some.next(), some.next()) {
        (Some(one), None) => Ok(one),
        _ => {
            let names: Vec<&str> = given.iter().map(|(name, _)| *name).collect();
            Err(PyTypeError::new_err(format!("expected exactly one of {}", names.join(", "))))
        }
    }
}
